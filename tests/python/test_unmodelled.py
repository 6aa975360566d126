"""`berth diagnose` on what its library lacks, or its replay cannot know: no name is given as if it were the whole truth.
The records are made here, by other means than the project's."""

import json
import subprocess
import sys

import numpy as np
import pytest
import scipy.linalg
import scipy.signal
from conftest import EXIT_DONE, EXIT_INPUT, ROOT, command, settings

PERIOD_s = 0.0025
DEAD_TIME_s = 0.0175


def multisine(rows, seed, amplitude_m=0.01):
    """Time and a smooth command with 25 lines up to 4 Hz."""
    rng = np.random.default_rng(seed)
    t_s = PERIOD_s * np.arange(rows)
    lines_Hz = np.linspace(0.1, 4.0, 25) * (1.0 + 0.03 * rng.standard_normal(25))
    x = sum(np.sin(2 * np.pi * f * t_s + rng.uniform(0, 2 * np.pi)) / (1.0 + f) for f in lines_Hz)
    return t_s, amplitude_m * x / np.max(np.abs(x)) * np.clip(t_s / 0.5, 0.0, 1.0)


def write(path, **columns):
    table = np.column_stack(list(columns.values()))
    np.savetxt(path, table, delimiter=",", header=",".join(columns), comments="", fmt="%.12g")
    return path


def diagnosed(tmp_path, *arguments):
    done = command("diagnose", *arguments, "--out", tmp_path / "out")
    assert done.returncode == EXIT_DONE, done.stderr.decode()
    return json.loads((tmp_path / "out" / "diagnosis.json").read_text())


def refused(tmp_path, *arguments, contains):
    done = command("diagnose", *arguments, "--out", tmp_path / "out")
    message = done.stderr.decode()
    assert done.returncode == EXIT_INPUT and message.count("\n") == 1 and not (tmp_path / "out").exists()
    for part in contains:
        assert part in message, message


def robot_record(tmp_path, robot, name="record", seed=1):
    t_s, command_m = multisine(12000, seed)
    noise_m = 5e-6 * np.random.default_rng(seed + 100).standard_normal(len(t_s))
    return write(tmp_path / f"{name}.csv", t_s=t_s, command_position_m=command_m,
                 robot_position_m=robot(np.interp(t_s - DEAD_TIME_s, t_s, command_m)) + noise_m)


def slower_up_than_down(goal_m, up_m_per_s=0.04, down_m_per_s=0.09):
    made = np.empty_like(goal_m)
    made[0] = goal_m[0]
    for n in range(1, len(goal_m)):
        way = goal_m[n] - made[n - 1]
        made[n] = made[n - 1] + min(max(way, -down_m_per_s * PERIOD_s), up_m_per_s * PERIOD_s)
    return made


def farther_upwards(goal_m, share=0.02):
    return goal_m * np.where(np.gradient(goal_m) > 0.0, 1.0 + share, 1.0)


def lag_that_grows(goal_m, growth=6e-5):
    """A first-order low-pass whose time constant grows from nothing to 1.8 ms in 30 s, integrated a tenth of a tick at a
    time."""
    parts = 10
    x, made = goal_m[0], np.empty_like(goal_m)
    for n in range(len(goal_m)):
        for part in range(1, parts + 1 if n else 1):
            goal = goal_m[n - 1] + (goal_m[n] - goal_m[n - 1]) * part / parts
            lag_s = max(growth * PERIOD_s * (n - 1 + part / parts), 1e-9)
            x = goal + (x - goal) * np.exp(-PERIOD_s / parts / lag_s)
        made[n] = x
    return made


def dead_time_that_grows(goal_m, growth=6e-5):
    t_s = PERIOD_s * np.arange(len(goal_m))
    return np.interp(t_s * (1.0 - growth), t_s, goal_m)


def motor_with_little_voltage(goal_m, gain_per_s=40.0, motor_s=0.05, voltage_max=0.06):
    """A proportional controller on a motor whose voltage ends: it gathers speed with its own lag up to a limit."""
    x, v, made = goal_m[0], 0.0, np.empty_like(goal_m)
    steps = 10
    for n, goal in enumerate(goal_m):
        made[n] = x
        for _ in range(steps):
            wanted = min(max(gain_per_s * (goal - x), -voltage_max), voltage_max)
            v += PERIOD_s / steps * (wanted - v) / motor_s
            x += PERIOD_s / steps * v
    return made


@pytest.mark.parametrize("robot", [slower_up_than_down, farther_upwards, motor_with_little_voltage])
@pytest.mark.parametrize("is_validated", [True, False])
@pytest.mark.first(2)
def test_what_a_neighbour_leaves_far_above_the_noise_is_said(tmp_path, robot, is_validated):
    """What is left is smooth, as the motion is; it had been taken for the noise, and the neighbour for the truth."""
    record = robot_record(tmp_path, robot)
    more = ["--validate", robot_record(tmp_path, robot, "other", 78)] if is_validated else []
    told = diagnosed(tmp_path, record, "--rig", "ess", *more)
    print(told["verdict"], [cause["effect"] for cause in told["causes"]], [b["doubts"] for b in told["blocks"]])
    assert told["verdict"] in ("partly_explained", "unknown")
    low_m, high_m = told["residual"]["robot_position_m"]["floor_ci95"]
    assert low_m == 0.0 < high_m, "estimated beside what nothing explains, it may hold some of that"


@pytest.fixture(scope="module")
def faultless(tmp_path_factory):
    """Columns of a run of rig ess that is as its file says, with the noise of its sensors."""
    out = tmp_path_factory.mktemp("faultless")
    run = {"robot.feedback_noise_m": 5e-6, "sensor.noise_N": 0.2, "profile.kind": "multisine",
           "profile.amplitude_m": 0.01, "profile.duration_s": 30, "run.duration_s": 30}
    for words in (["run", "ess", "--out", out, *settings(run)],
                  ["diagnose", out / "ess.ulg", "--rig", "ess", "--out", out]):
        assert command(*words).returncode == EXIT_DONE
    table = np.genfromtxt(out / "series.csv", delimiter=",", names=True)
    force = [name for name in table.dtype.names if name.startswith("force")][0]
    robot = [name for name in table.dtype.names if name.startswith("robot")][0]
    return {"t_s": PERIOD_s * np.arange(len(table)), "command_position_m": table["command_position_m"],
            "robot_position_m": table[robot], "force_N": table[force]}


@pytest.mark.parametrize("step_m", [1e-7, 1e-6, 1e-5])
@pytest.mark.first(1)
def test_a_command_with_too_few_digits_hides_no_cause(tmp_path, faultless, step_m):
    """In a contact of 2e7 N/m a micrometre is 20 N; a mass of 326 kg had been found in it."""
    coarse = faultless | {"command_position_m": step_m * np.round(faultless["command_position_m"] / step_m)}
    told = diagnosed(tmp_path, write(tmp_path / "coarse.csv", **coarse), "--rig", "ess")
    assert told["causes"] == [] and told["verdict"] in ("nothing_detectable", "unknown")
    assert any("command_position_m is written in steps of" in note for note in told["notes"]), told["notes"]


def test_what_rings_as_a_part_begins_in_motion_is_no_fault(tmp_path, faultless):
    """A replay begins at rest: the object is hit at the robot's velocity, and swings on the sensor's spring."""
    parts = faultless | {"segment": np.arange(len(faultless["t_s"])) // 400}
    told = diagnosed(tmp_path, write(tmp_path / "parts.csv", **parts), "--rig", "ess")
    assert told["verdict"] == "nothing_detectable" and told["causes"] == []


def force_on_a_soft_sensor(robot_m, step_s, mass_kg, damping_N_s_per_m, stiffness_N_per_m, sensor):
    """Of an object behind the sensor's spring, after rig ess' low-pass of 20 Hz; lines between the rows."""
    spring_N_per_m, turn_per_s = sensor["sensor.stiffness_N_per_m"], 2 * np.pi * 20.0
    damper = 2 * sensor["sensor.damping_ratio"] * np.sqrt(spring_N_per_m * mass_kg)
    held = np.array([mass_kg, damping_N_s_per_m, stiffness_N_per_m])
    above = turn_per_s ** 2 * np.polymul([damper, spring_N_per_m], held)
    below = np.polymul(held + [0, damper, spring_N_per_m], [1, 2 * 0.7 * turn_per_s, turn_per_s ** 2])
    fast = 200.0  # time in units that keep the coefficients together
    above, below = above * fast ** np.arange(3, -1, -1), below * fast ** np.arange(4, -1, -1)
    return scipy.signal.lsim((above, below), robot_m, fast * step_s * np.arange(len(robot_m)))[1]


def test_what_rings_for_longer_than_the_parts_last_is_not_named(tmp_path):
    """It decays by 2/s and a part lasts 3 s: other damping than the rig's lowers the error, and was named."""
    soft = {"sensor.stiffness_N_per_m": 1e6, "sensor.damping_ratio": 0.02}
    held = {"object.mass_kg": 100.0, "object.damping_N_s_per_m": 20.0, "object.stiffness_N_per_m": 2400.0}
    rng = np.random.default_rng(1)
    t_s, command_m = multisine(24000, 1)
    fine_s = 0.1 * PERIOD_s * np.arange(10 * len(t_s))
    force_N = force_on_a_soft_sensor(np.interp(fine_s - DEAD_TIME_s, t_s, command_m), fine_s[1], *held.values(), soft)
    whole = {"t_s": t_s, "command_position_m": command_m,
             "robot_position_m": np.interp(t_s - DEAD_TIME_s, t_s, command_m) + 5e-6 * rng.standard_normal(len(t_s)),
             "force_N": np.interp(t_s - 0.0025, fine_s, force_N) + 0.2 * rng.standard_normal(len(t_s))}
    speed = np.abs(np.gradient(command_m))
    begins = [first + np.argmax(speed[first:first + 800]) for first in range(400, 22000, 3200)]
    kept = np.concatenate([np.arange(begin, begin + 1200) for begin in begins])
    parts = {name: values[kept] for name, values in whole.items()} | {"segment": np.arange(len(kept)) // 1200}
    told = diagnosed(tmp_path, write(tmp_path / "parts.csv", **parts), "--rig", "ess", *settings(soft | held))
    assert told["verdict"] == "partly_explained", told["causes"]
    assert any("ceased to ring" in doubt for doubt in told["blocks"][-1]["doubts"])


def test_a_command_with_all_its_digits_is_not_told_as_coarse(tmp_path, faultless):
    told = diagnosed(tmp_path, write(tmp_path / "fine.csv", **faultless), "--rig", "ess")
    assert told["verdict"] == "nothing_detectable"
    assert not any("written in steps" in note for note in told["notes"])


@pytest.mark.parametrize("jitter_ms", [0.1, 0.2, 0.4])
def test_rows_are_put_back_by_their_place_and_not_by_stamps_that_jitter(tmp_path, faultless, jitter_ms):
    """A cubic through jittered stamps was off by 2.5 um, which the contact answered to with a cause of its own."""
    rng = np.random.default_rng(5)
    kept = np.ones(len(faultless["t_s"]), bool)
    kept[rng.choice(np.arange(100, len(kept) - 100), 30, replace=False)] = False
    jitter_s = 1e-3 * jitter_ms * rng.uniform(-1.0, 1.0, len(kept))
    table = {name: values[kept] for name, values in (faultless | {"t_s": faultless["t_s"] + jitter_s}).items()}
    told = diagnosed(tmp_path, write(tmp_path / "jittered.csv", **table), "--rig", "ess")
    assert told["verdict"] == "nothing_detectable" and told["causes"] == []


def test_a_record_beside_that_cannot_be_used_is_refused(tmp_path, faultless):
    record = write(tmp_path / "record.csv", **faultless)
    rng = np.random.default_rng(4)  # noise of their own, or they would be no other measurement
    other = {name: faultless[name] + size * rng.standard_normal(len(faultless["t_s"]))
             for name, size in (("robot_position_m", 5e-5), ("force_N", 2.0))}
    moving = write(tmp_path / "moving.csv",
                   **(faultless | other | {"command_position_m": 1.5 * faultless["command_position_m"]}))
    no_command = write(tmp_path / "force.csv", t_s=faultless["t_s"], force_N=other["force_N"])
    for option, file, words in [("--repeat", moving, "repeats no command"), ("--standstill", moving, "is no standstill"),
                                 ("--validate", no_command, "no block in common")]:
        refused(tmp_path, record, "--rig", "ess", option, file, contains=[str(file), words])


def test_stamps_that_no_rate_suits(tmp_path, faultless):
    steps_s = np.random.default_rng(3).uniform(0.001, 0.004, len(faultless["t_s"]))
    uneven = write(tmp_path / "uneven.csv", **(faultless | {"t_s": np.cumsum(steps_s)}))
    refused(tmp_path, uneven, "--rig", "ess", contains=[str(uneven), "no constant rate"])
    thousand = write(tmp_path / "ms.csv", **(faultless | {"t_s": 1e3 * faultless["t_s"]}))
    refused(tmp_path, thousand, "--rig", "ess", contains=[str(thousand), "scale = 0.001"])


def test_stamps_that_come_as_late_as_a_missing_row_would_make_them(tmp_path, faultless):
    """Even in the mean: 0.4 of a row early or late."""
    off_s = np.random.default_rng(4).uniform(-0.4, 0.4, len(faultless["t_s"])) * PERIOD_s
    late = write(tmp_path / "late.csv", **(faultless | {"t_s": 1.0 + faultless["t_s"] + off_s}))
    refused(tmp_path, late, "--rig", "ess", contains=[str(late), "late stamps cannot be told from rows that are missing"])


def test_a_rate_that_changes_is_no_jitter(tmp_path, faultless):
    """A tenth slower in the middle: no step is far from the others, and the sum of them is half a second off."""
    rows = len(faultless["t_s"])
    steps_s = PERIOD_s * (1.0 + 0.1 * np.sin(2.0 * np.pi * np.arange(rows) / rows))
    drifting = write(tmp_path / "drifting.csv", **(faultless | {"t_s": np.cumsum(steps_s)}))
    refused(tmp_path, drifting, "--rig", "ess", contains=[str(drifting), "no constant rate", "s away from steps of"])


@pytest.mark.parametrize("channel, noise", [("robot_position_m", 5e-6), ("force_N", 0.3)])
@pytest.mark.parametrize("constant", [0.0, 12.0])
@pytest.mark.first(1)
def test_what_follows_nothing_has_no_cause(tmp_path, faultless, channel, noise, constant):
    """Brakes that are on, a sensor that is dead or stuck: limits, play and saturation fitted it to the noise."""
    still = constant + noise * np.random.default_rng(4).standard_normal(len(faultless["t_s"]))
    told = diagnosed(tmp_path, write(tmp_path / "still.csv", **(faultless | {channel: still})), "--rig", "ess")
    name = "robot" if channel.startswith("robot") else "force"
    block = next(one for one in told["blocks"] if one["block"] == name)
    assert told["verdict"] == "unknown" and told["causes"] == []
    assert "what is measured does not follow what should move it: a constant does as well" in block["doubts"]


def test_a_gain_that_grows_with_the_way_is_not_told_as_three_causes(tmp_path):
    """Gain, a limit and an error of the gears explained nearly all of it, each with an interval that holds none."""
    t_s, command_m = multisine(12000, 11)
    late_m = np.interp(t_s - DEAD_TIME_s, t_s, command_m)
    robot_m = late_m + 30.0 * late_m**3 + 5e-6 * np.random.default_rng(12).standard_normal(len(t_s))
    record = write(tmp_path / "record.csv", t_s=t_s, command_position_m=command_m, robot_position_m=robot_m)
    told = diagnosed(tmp_path, record, "--rig", "ess")
    assert told["verdict"] in ("partly_explained", "unknown"), told["causes"]


@pytest.mark.slow
def test_the_operators_velocity_is_differentiated_where_it_is_missing(tmp_path, faultless):
    """The manipulator's error is the same with the column and without it, and another one with hardly any velocity."""
    rng = np.random.default_rng(13)
    t_s, operator_m = multisine(12000, 14)
    velocity_m_per_s = np.gradient(operator_m, PERIOD_s, edge_order=2)
    columns = {"t_s": t_s, "operator_position_m": operator_m, "operator_velocity_m_per_s": velocity_m_per_s,
               "command_position_m": faultless["command_position_m"], "force_N": rng.standard_normal(len(t_s))}
    columns = {name: values[:min(len(t_s), len(faultless["t_s"]))] for name, values in columns.items()}
    told = {}
    for name in ("with", "without", "zero"):
        table = dict(columns)
        if name == "without":
            table.pop("operator_velocity_m_per_s")
        elif name == "zero":
            table["operator_velocity_m_per_s"] = 1e-6 * columns["operator_velocity_m_per_s"]
        told[name] = diagnosed(tmp_path, write(tmp_path / f"{name}.csv", **table), "--rig", "ess")
    before = {name: one["residual"]["command_position_m"]["fit"]["before"] for name, one in told.items()}
    print(before)
    assert any("taken as differences of operator_position_m" in note for note in told["without"]["notes"])
    assert before["without"] == pytest.approx(before["with"], rel=1e-3)
    assert abs(before["zero"] - before["with"]) > 0.01 * before["with"]


def test_the_floor_has_an_interval(tmp_path, faultless):
    """White noise of N rows has its rms to 1.96 / sqrt(2 N)."""
    told = diagnosed(tmp_path, write(tmp_path / "record.csv", **faultless), "--rig", "ess")
    for channel, sigma in (("robot_position_m", 5e-6), ("force_N", 0.2)):
        low, high = told["residual"][channel]["floor_ci95"]
        rows = 0.8 * len(faultless["t_s"])
        assert low < told["residual"][channel]["fit"]["floor"] < high
        assert high - low == pytest.approx(2 * 1.96 * sigma / np.sqrt(2 * rows), rel=0.2)
        assert low - (high - low) < sigma < high + (high - low)


def test_a_manipulator_of_which_all_is_scaled_may_be_a_force_that_is(tmp_path):
    mass_kg, damping_N_s_per_m, stiffness_N_per_m, scale = 150.0, 400.0, 6000.0, 0.85
    t_s, push_N = multisine(12000, 6, amplitude_m=200.0)
    step = scipy.linalg.expm(PERIOD_s * np.array([[0, 1, 0], [-stiffness_N_per_m / mass_kg, -damping_N_s_per_m / mass_kg,
                                                              1 / mass_kg], [0, 0, 0]]))
    state, position_m = np.zeros(2), np.empty(len(t_s))
    for n, force_N in enumerate(push_N):
        position_m[n] = state[0]
        state = step[:2, :2] @ state + step[:2, 2] * force_N
    position_m += 1e-6 * np.random.default_rng(8).standard_normal(len(t_s))
    rig = tmp_path / "rig.toml"
    rig.write_text(f'[manipulator]\nmass_kg = {mass_kg}\ndamping_N_s_per_m = {damping_N_s_per_m}\n'
                   f'stiffness_N_per_m = {stiffness_N_per_m}\n[operator]\ninterface = "force"\n')
    record = write(tmp_path / "record.csv", t_s=t_s, command_position_m=position_m, operator_force_N=scale * push_N)
    told = diagnosed(tmp_path, record, "--rig", rig)
    assert [cause["effect"] for cause in told["causes"]] == ["manipulator.parameters"]
    assert any("forces that are all" in note and "known weight" in note for note in told["notes"]), told["notes"]


@pytest.mark.parametrize("jumps", [True, False])
def test_a_bias_that_jumps_is_no_drift(tmp_path, faultless, jumps):
    """A straight line has three quarters of the square of a step in its middle; what is left of that is small."""
    share = np.linspace(0.0, 1.0, len(faultless["t_s"]))
    offset_N = 0.25 * (share > 0.5) if jumps else 0.5 * share
    told = diagnosed(tmp_path, write(tmp_path / "record.csv", **faultless | {"force_N": faultless["force_N"] + offset_N}),
                     "--rig", "ess")
    [force] = [block for block in told["blocks"] if block["block"] == "force"]
    print(force["verdict"], [(cause["effect"], cause["delta_bic"]) for cause in force["causes"]], force["doubts"])
    assert [cause["effect"] for cause in force["causes"]] == ["sensor.drift"]
    assert force["verdict"] == ("partly_explained" if jumps else "named")
    assert ("what is named acts otherwise from one moment on" in force["doubts"]) == jumps


@pytest.mark.parametrize("is_measured", [True, False])
def test_what_gains_less_than_the_noise_is_known_is_believed_beside_a_standstill_alone(tmp_path, faultless, is_measured):
    rng = np.random.default_rng(4)
    rows = len(faultless["t_s"])
    record = write(tmp_path / "record.csv", **faultless | {"force_N": faultless["force_N"] + 0.022})
    still = write(tmp_path / "standstill.csv", t_s=faultless["t_s"], command_position_m=np.zeros(rows),
                  robot_position_m=5e-6 * rng.standard_normal(rows), force_N=0.2 * rng.standard_normal(rows))
    told = diagnosed(tmp_path, record, "--rig", "ess", *(["--standstill", still] if is_measured else []))
    [force] = [block for block in told["blocks"] if block["block"] == "force"]
    print(force["verdict"], [(cause["effect"], cause["held_out_gain"]) for cause in force["causes"]], force["doubts"])
    assert [cause["effect"] for cause in force["causes"]] == ["sensor.bias"]
    assert force["verdict"] == ("named" if is_measured else "partly_explained")
    assert any("a standstill would tell" in doubt for doubt in force["doubts"]) != is_measured


ROBOT_RIG = """
name = "robot"
[loop]
rate_Hz = 400
[robot]
dead_time_ms = 17.5
interpolation = "linear"
[bus]
ideal = true
"""


@pytest.mark.parametrize("jitter_ms, wander, told, size", [
    (0.3, 0.0, "velocity, as of a delay that jitters by ", 0.3), (0.0, 0.004, "size, as of a gain that wanders by ", 0.4),
    (0.0, 0.0, None, None)])
@pytest.mark.first(1)
def test_noise_that_follows_the_motion_is_told_with_its_size(tmp_path, jitter_ms, wander, told, size):
    t_s, command_m = multisine(12000, 7)
    rng = np.random.default_rng(8)
    late_s = DEAD_TIME_s + 1e-3 * jitter_ms * rng.standard_normal(len(t_s))
    robot_m = (1.0 + wander * rng.standard_normal(len(t_s))) * np.interp(t_s - late_s, t_s, command_m)
    robot_m += 5e-6 * rng.standard_normal(len(t_s))
    record = write(tmp_path / "record.csv", t_s=t_s, command_position_m=command_m, robot_position_m=robot_m)
    rig = tmp_path / "robot.toml"
    rig.write_text(ROBOT_RIG)
    found = diagnosed(tmp_path, record, "--rig", rig)
    notes = [note for note in found["notes"] if "the noise of the robot grows" in note]
    assert len(notes) == (told is not None), notes
    assert found["causes"] == []
    if told:
        assert found["verdict"] == "unknown" and "no effect of the library" in found["next_experiment"]["why"]
        assert "--standstill" in found["next_experiment"]["calibration"] and not found["next_experiment"]["rivals"]
        report = subprocess.run([sys.executable, ROOT / "scripts/diagnosis_report.py", tmp_path / "out"], check=False,
                                capture_output=True)
        assert report.returncode == EXIT_DONE, report.stderr.decode()
        assert told in notes[0]
        assert float(notes[0].split(told)[1].split()[0]) == pytest.approx(size, rel=0.1)


def late_in_stretches(command_m, t_s, seed):
    """By one period more in some stretches, as behind a queue."""
    begins_s = np.sort(np.random.default_rng(seed).uniform(0.0, t_s[-1], 8))
    more_s = PERIOD_s * (np.searchsorted(begins_s, t_s) % 2)
    return np.interp(t_s - DEAD_TIME_s - more_s, t_s, command_m)


@pytest.mark.parametrize("seed", [1, 2, 3, 4])
@pytest.mark.first(1)
def test_a_robot_that_is_late_in_stretches_has_no_drifting_clock(tmp_path, seed):
    """Slips of a clock come evenly, these go back and forth; a floor that had to be estimated had hidden that."""
    t_s, command_m = multisine(12000, seed)
    robot_m = late_in_stretches(command_m, t_s, seed) + 2e-5 * np.random.default_rng(seed).standard_normal(len(t_s))
    told = diagnosed(tmp_path, write(tmp_path / "queue.csv", t_s=t_s, command_position_m=command_m,
                                     robot_position_m=robot_m), "--rig", "ess")
    print(seed, told["verdict"], [cause["effect"] for cause in told["causes"]], told["blocks"][0]["doubts"])
    assert told["verdict"] in ("partly_explained", "unknown")


def test_a_triangle_hides_no_cause(tmp_path):
    """Its way from row to row is the same, and no step in which the column is written."""
    t_s = PERIOD_s * np.arange(12000)
    command_m = 0.01 * scipy.signal.sawtooth(2 * np.pi * t_s / 1.99, 0.5)
    robot_m = np.interp(t_s - DEAD_TIME_s, t_s, command_m)
    robot_m += 8e-6 * np.sin(2 * np.pi * robot_m / 0.003) + 1e-6 * np.random.default_rng(1).standard_normal(len(t_s))
    told = diagnosed(tmp_path, write(tmp_path / "triangle.csv", t_s=t_s, command_position_m=command_m,
                                     robot_position_m=robot_m), "--rig", "ess")
    assert not any("written in steps" in note for note in told["notes"])
    assert told["verdict"] == "named" and [cause["effect"] for cause in told["causes"]] == ["robot.periodic_error"]


def servo_with_limits(goal_m, frequency_rad_per_s=60.0, damping=0.5, velocity_max=0.08, acceleration_max=2.0):
    x, v, made, steps = goal_m[0], 0.0, np.empty_like(goal_m), 10
    for n, goal in enumerate(goal_m):
        made[n] = x
        for _ in range(steps):
            wanted = frequency_rad_per_s**2 * (goal - x) - 2 * damping * frequency_rad_per_s * v
            v += PERIOD_s / steps * min(max(wanted, -acceleration_max), acceleration_max)
            v = min(max(v, -velocity_max), velocity_max)
            x += PERIOD_s / steps * v
    return made


@pytest.mark.slow
def test_a_slow_servo_under_steps_loses_no_setpoints(tmp_path):
    """Nine in ten of the few that lead anywhere: what stands still has another reason."""
    rng = np.random.default_rng(1)
    t_s = PERIOD_s * np.arange(12000)
    command_m = np.repeat(0.01 * rng.uniform(-1.0, 1.0, 30), 400)
    late_m = np.concatenate([np.full(7, command_m[0]), command_m[:-7]])
    robot_m = servo_with_limits(late_m) + 2e-6 * rng.standard_normal(len(t_s))
    rig = tmp_path / "servo.toml"
    rig.write_text('[loop]\nrate_Hz = 400\n[robot]\ndead_time_ms = 17.5\ninterpolation = "hold"\n')
    told = diagnosed(tmp_path, write(tmp_path / "steps.csv", t_s=t_s, command_position_m=command_m,
                                     robot_position_m=robot_m), "--rig", rig)
    print(told["verdict"], [(c["effect"], c["parameters"]) for c in told["causes"]])
    assert "robot.lost_commands" not in [cause["effect"] for cause in told["causes"]]
    assert told["verdict"] in ("partly_explained", "unknown")


def test_what_creeps_is_told_as_a_drift(tmp_path):
    t_s, command_m = multisine(12000, 1)
    creep_m = 2e-4 * (1.0 - np.exp(-t_s / 8.0))
    robot_m = np.interp(t_s - DEAD_TIME_s, t_s, command_m) + creep_m
    robot_m += 5e-6 * np.random.default_rng(2).standard_normal(len(t_s))
    told = diagnosed(tmp_path, write(tmp_path / "warm.csv", t_s=t_s, command_position_m=command_m,
                                     robot_position_m=robot_m), "--rig", "ess")
    assert told["verdict"] == "unknown"
    assert told["blocks"][0]["left"]["depends"] == "drift over time", told["blocks"][0]["left"]


@pytest.mark.parametrize("robot, verdicts", [(lag_that_grows, ["partly_explained"]),
                                             (dead_time_that_grows, ["named", "one_of"])])
def test_a_lag_that_grows_is_no_dead_time_that_grows(robot, verdicts, tmp_path):
    """To first order both are one lateness that grows; the second order of the motion tells them apart. A clock of
    another period that does not slip is the same as the dead time."""
    told = diagnosed(tmp_path, robot_record(tmp_path, robot), "--rig", "ess")
    assert told["verdict"] in verdicts and [one["effect"] for one in told["causes"]] == ["robot.dead_time_drift"]
    [block] = [one for one in told["blocks"] if one["block"] == "robot"]
    assert any("low-pass" in doubt for doubt in block["doubts"]) == (robot == lag_that_grows)


@pytest.mark.parametrize("bend_per_m2, seed", [(8.0, 4), (8.0, 3), (20.0, 3)])
@pytest.mark.first(1)
def test_no_cause_makes_the_error_larger(tmp_path, bend_per_m2, seed):
    """Behind a robot that bends its way as the library has it not, slow noise is taken to be in the force."""
    sensor = {"sensor.stiffness_N_per_m": 2e7, "sensor.damping_ratio": 0.05}
    rng = np.random.default_rng(seed)
    t_s = PERIOD_s * np.arange(8000)
    command_m = 0.0037 * (1.0 - np.exp(-(2.0 * t_s)**2)) * sum(
        np.sin(2 * np.pi * tone_Hz * t_s + rng.uniform(0, 2 * np.pi)) for tone_Hz in np.linspace(0.1, 2.0, 14))
    fine_s = 0.1 * PERIOD_s * np.arange(10 * len(t_s))
    there_m = np.interp(fine_s - DEAD_TIME_s, t_s, command_m)
    there_m += bend_per_m2 * there_m**3
    force_N = force_on_a_soft_sensor(there_m, fine_s[1], 100.0, 19.46773764467334, 2368.705056261446, sensor)
    record = write(tmp_path / "record.csv", t_s=t_s, command_position_m=command_m,
                   robot_position_m=there_m[::10] + 5e-6 * rng.standard_normal(len(t_s)),
                   force_N=np.interp(t_s - 0.0025, fine_s, force_N) + 0.2 * rng.standard_normal(len(t_s)))
    told = diagnosed(tmp_path, record, "--rig", "ess")
    assert told["verdict"] in ("partly_explained", "unknown")
    for block in told["blocks"]:
        fit = block["residual"]["fit"]
        print(block["block"], [cause["effect"] for cause in block["causes"]], fit)
        assert fit["after"] < 1.05 * fit["retuned"]
