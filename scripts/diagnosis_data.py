"""Reads the folder that `berth diagnose` writes, and makes of its errors what can be drawn and said: over position
and velocity, over frequency, and where they are largest."""
import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from berth_log import InputError
from json_schema import errors_of

HERE = Path(__file__).resolve().parent
FIT = 1  # a row's use in series.csv; 0: none, 2: held out
OUTPUT = {"manipulator": "command_position_m", "robot": "robot_position_m", "force": "force_N"}
BINS = 40
ROWS_PER_BIN_MIN = 20
SPECTRUM_ROWS = 2048
PART_GAP = 10  # periods, drawn between parts that each count their time from the start
SEGMENTS_MIN = 8


@dataclass(frozen=True)
class Block:
    """One block: `told` is its part of diagnosis.json; one value a row in use, in the block's unit."""
    told: dict
    time_s: np.ndarray
    position_m: np.ndarray  # of the robot, as commanded
    velocity_m_per_s: np.ndarray
    measured: np.ndarray
    before: np.ndarray  # measured less simulated with the rig as given
    after: np.ndarray  # the same with the extended rig
    held_out: np.ndarray  # True where the fit did not see the row
    period_s: float

    @property
    def name(self):
        return self.told["block"]

    @property
    def unit(self):
        return self.told["residual"]["unit"]

    @property
    def largest_error(self):
        return float(max(np.abs(self.before).max(), np.abs(self.after).max()))

    @property
    def floor_rms(self):
        return self.told["residual"]["fit"]["floor"]


@dataclass(frozen=True)
class Diagnosis:
    """`told` is diagnosis.json; `given` and `extended` are paths of rig files."""
    folder: Path
    told: dict
    blocks: list
    given: Path
    extended: Path

    @property
    def main_block(self):
        """The one to look at first: at fault, with the largest error against its floor."""
        at_fault = [block for block in self.blocks if block.told["verdict"] != "nothing_detectable"]
        return max(at_fault or self.blocks, key=lambda block: block.told["residual"]["fit"]["retuned"]
                   / max(block.floor_rms, 1e-300))


def read_json(path):
    try:
        told = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); give the folder that `berth diagnose --out` "
                         "wrote") from error
    except ValueError as error:
        raise InputError(f"{path}: is no JSON ({error})") from error
    schema = json.loads((HERE / "diagnosis.schema.json").read_text(encoding="utf-8"))
    errors = errors_of(told, schema)
    if errors:
        more = f" (and {len(errors) - 1} more)" if len(errors) > 1 else ""
        raise InputError(f"{path}: not as diagnosis.schema.json says: {errors[0]}{more}")
    return told


def read_series(path):
    """The columns of series.csv by name."""
    try:
        with path.open(encoding="utf-8") as file:
            names = file.readline().strip().split(",")
            values = np.loadtxt(file, delimiter=",", ndmin=2)
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from error
    except ValueError as error:
        raise InputError(f"{path}: is damaged ({error})") from error
    if len(values) < 2 or values.shape[1] != len(names):
        raise InputError(f"{path}: is cut off")
    return dict(zip(names, values.T))


def one_after_another(time_s, period_s):
    """Parts of a record that each count their time from the start, laid out one after another with a gap between."""
    step_s = np.diff(time_s)
    back = step_s <= 0.0
    return time_s + np.concatenate([[0.0], np.cumsum(np.where(back, PART_GAP * period_s - step_s, 0.0))])


def velocity(position_m, time_s, period_s):
    """By differences within the parts that follow each other without a gap."""
    parts = np.split(np.arange(len(time_s)), np.flatnonzero(np.diff(time_s) > 1.5 * period_s) + 1)
    return np.concatenate([np.gradient(position_m[part], time_s[part]) if len(part) > 1 else np.zeros(len(part))
                           for part in parts])


def block_of(told, series, path, period_s):
    name, unit = told["block"], told["residual"]["unit"]
    try:
        use = series[f"{name}_use"]
        before, after = (series[f"{name}_error_{part}_{unit}"] for part in ("before", "after"))
        measured, time_s = series[OUTPUT[name]], one_after_another(series["t_s"], period_s)
    except KeyError as error:
        raise InputError(f"{path}: has no column {error.args[0]}, though diagnosis.json tells of that "
                         "block") from error
    position_m = series.get("command_position_m", series.get("robot_position_m"))
    if position_m is None:
        raise InputError(f"{path}: has neither command_position_m nor robot_position_m")
    used = use > 0
    if not used.any():
        raise InputError(f"{path}: no row of the block {name} is in use")
    return Block(told, time_s[used], position_m[used], velocity(position_m, time_s, period_s)[used], measured[used],
                 before[used], after[used], (use != FIT)[used], period_s)


def read_diagnosis(folder):
    """The diagnosis in a folder. Raises InputError."""
    folder = Path(folder)
    if not folder.is_dir():
        raise InputError(f"{folder}: is no folder; give the one that `berth diagnose --out` wrote")
    told = read_json(folder / "diagnosis.json")
    rigs = [folder / f"{name}.toml" for name in ("given", "extended")]
    for path in rigs:
        if not path.is_file():
            raise InputError(f"{path}: is missing; run `berth diagnose` again")
    path = folder / "series.csv"
    series = read_series(path)
    blocks = [block_of(block, series, path, 1e-3 * told["period_ms"]) for block in told["blocks"]]
    return Diagnosis(folder, told, blocks, *rigs)


@dataclass(frozen=True)
class Profile:
    """Error over a state: mean, and the tenth and ninetieth percentile, of bins of equal width."""
    at: np.ndarray
    mean: np.ndarray
    low: np.ndarray
    high: np.ndarray


def profile(state, error):
    """Bins with few rows are left out, as are the outermost 0.5 % of the state at either end."""
    edges = np.linspace(*np.quantile(state, (0.005, 0.995)), BINS + 1)
    place = np.searchsorted(edges, state, side="right") - 1
    found = []
    for i in range(BINS):
        inside = error[place == i]
        if len(inside) >= ROWS_PER_BIN_MIN:
            found.append((0.5 * (edges[i] + edges[i + 1]), inside.mean(), *np.quantile(inside, (0.1, 0.9))))
    return Profile(*np.array(found).reshape(-1, 4).T)


@dataclass(frozen=True)
class Spectrum:
    """Amplitude densities, in the block's unit per root Hz."""
    frequency_Hz: np.ndarray
    before: np.ndarray
    after: np.ndarray
    floor: np.ndarray


def power_density(error, period_s):
    """Welch's estimate: Hann windows that overlap by half; one-sided, per Hz."""
    rows = min(SPECTRUM_ROWS, max(16, 2 * len(error) // (SEGMENTS_MIN + 1)))
    window = np.hanning(rows)
    starts = range(0, max(len(error) - rows, 0) + 1, max(rows // 2, 1))
    parts = [np.abs(np.fft.rfft(window[:len(part)] * part, rows)) ** 2
             for part in (error[start:start + rows] for start in starts)]
    power = 2.0 * period_s * np.mean(parts, axis=0) / np.sum(window ** 2)
    power[[0, -1] if rows % 2 == 0 else [0]] *= 0.5  # these lines have no mirror image
    return np.fft.rfftfreq(rows, period_s), power


def floor_density(noise, frequency_Hz, period_s):
    """Power density of the noise of the floor: autoregressive, or white beside a slow one of first order."""
    turn = np.exp(-2j * np.pi * frequency_Hz * period_s)
    filtered = 1.0 - sum((a * turn ** (k + 1) for k, a in enumerate(noise["ar"])), np.zeros_like(turn))
    decay, gain = noise["slow_decay"], noise["slow_gain"]
    slow = (1.0 - decay * (1.0 - gain) * turn) / (1.0 - decay * turn) if gain > 0.0 else 1.0
    return 2.0 * period_s * noise["sigma"] ** 2 * np.abs(slow) ** 2 / np.abs(filtered) ** 2


def spectrum(block):
    """The rows in use are taken as if they followed each other."""
    frequency_Hz, before = power_density(block.before, block.period_s)
    _, after = power_density(block.after, block.period_s)
    floor = floor_density(block.told["floor_noise"], frequency_Hz, block.period_s)
    return Spectrum(*(values[1:] for values in (frequency_Hz, *map(np.sqrt, (before, after, floor)))))


def smallest_visible(block):
    """Rms in the block's unit from which on an error would have stood out that goes with the motion, and the main
    frequency of that motion in Hz. An estimate: BIC better by 10 with one more parameter, against the floor."""
    frequency_Hz, power = power_density(block.position_m - block.position_m.mean(), block.period_s)
    at_Hz = float(frequency_Hz[1 + np.argmax(power[1:])])
    noise = floor_density(block.told["floor_noise"], np.array([at_Hz]), block.period_s)[0]
    rows = len(block.before)
    return float(np.sqrt(0.5 * noise / block.period_s * (np.log(rows) + 10.0) / rows)), at_Hz
