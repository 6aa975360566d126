"""A map written by `berth map`: its grids, and what every picture of it shows."""
import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

TITLES = {"omega_per_omega_M": "ω/ω_M of the coupled system without dead time (1)",
          "zeta": "damping ratio ζ of the coupled system (1)"}
UNITS = {"N_per_m": "N/m", "N_s_per_m": "N s/m", "N_per_m2": "N/m²", "N_per_m3": "N/m³", "m_per_s": "m/s",
         "m_per_s2": "m/s²", "kg": "kg", "ms": "ms", "Hz": "Hz", "kHz": "kHz", "rad": "rad", "m": "m", "s": "s", "N": "N"}

# Of each decade of growth two levels; so many of them on either side of 0.
LEVELS_A_SIDE = 5


def key_title(key):
    """A key of a rig file with its unit in brackets: object.mass_kg -> object mass (kg)."""
    for suffix in sorted(UNITS, key=len, reverse=True):
        if key.endswith("_" + suffix):
            return key[:-len(suffix) - 1].replace(".", " ").replace("_", " ") + f" ({UNITS[suffix]})"
    return key.replace(".", " ").replace("_", " ") + " (1)"


def level_text(growth_per_s):
    """A growth rate with the time in which the motion doubles or halves: +3 (0.23 s)."""
    if growth_per_s == 0.0:
        return "0"
    time_s = float(f"{np.log(2.0) / abs(growth_per_s):.2g}")  # 230, not 2.3e+02
    return f"{growth_per_s:+g} ({time_s:g} s)".replace("-", "−")


@dataclass(frozen=True)
class Map:
    """Grids (rows of y) of a map over two parameters; nan in `radius` where no such rig is possible."""
    x: np.ndarray
    y: np.ndarray
    radius: np.ndarray  # largest |z|
    growth_per_s: np.ndarray
    is_below_wall: np.ndarray  # 1 or 0, nan where not possible
    lower: np.ndarray | None  # |z| at the lower end of a robot's dead time; None: it has no range
    growth_varying_per_s: np.ndarray | None  # Lyapunov exponents with jitter, drift or losses; None: without
    restitution: np.ndarray | None  # speed after a bounce over that before it, nan: it stays; None: no contact
    lasts: np.ndarray | None  # of a map in the time domain: 1 where a swing neither decays nor grows
    faulted: np.ndarray | None  # the same: 1 where a fault ended the run before the swing grew
    told: dict  # the JSON file beside the CSV file

    def names(self):
        """Names of both axes, as the rig file has them."""
        return [self.told["axes"][axis]["name"] for axis in "xy"]

    def titles(self):
        """Titles of both axes."""
        return [TITLES.get(name) or key_title(name) for name in self.names()]

    @property
    def is_faulted(self):
        """Where a fault ended the run before it had a growth: `berth map` then tells one over the run's length."""
        return np.zeros(self.radius.shape, bool) if self.faulted is None else self.faulted == 1

    @property
    def is_lasting(self):
        """Where a swing neither decays nor grows, which is not stable."""
        return np.zeros(self.radius.shape, bool) if self.lasts is None else (self.lasts == 1) & ~self.is_faulted

    @property
    def is_stable(self):
        """Where the motion decays."""
        return self.measured_growth_per_s() < 0.0

    @property
    def is_impossible(self):
        """Where no such rig is possible."""
        return np.isnan(self.growth_per_s)

    def measured_growth_per_s(self):
        """Growth where there is one, else nan: a swing that lasts has none, and of a run that a fault ended nobody knows."""
        return np.where(self.is_faulted | self.is_lasting, np.nan, self.growth_per_s)

    def levels_per_s(self):
        """Rates of growth to tell apart by colour, about 0 and the same on either side: 0, 0.1, 0.3, 1, 3, 10, or
        other decades; outliers of one in a hundred lie beyond."""
        found = np.abs(self.measured_growth_per_s())
        reach = np.nanpercentile(found, 99) if np.isfinite(found).any() else 1.0
        half_decades = np.floor(2.0 * np.log10(max(reach, 1e-9)) + 0.1)  # 10^0.5 is called 3
        steps = half_decades - np.arange(LEVELS_A_SIDE)[::-1]
        side = [float(f"{(1 if step % 2 == 0 else 3) * 10.0 ** (step // 2):.1g}") for step in steps]
        return np.array([-level for level in side[::-1]] + [0.0] + side)

    def place_on_scale(self, growth_per_s):
        """Which level a growth is at, -LEVELS_A_SIDE to LEVELS_A_SIDE, and between two of them in proportion."""
        return np.interp(growth_per_s, self.levels_per_s(), np.arange(-LEVELS_A_SIDE, LEVELS_A_SIDE + 1.0))

    @property
    def has_frequency_axis(self):
        """Whether x is the coupled system's frequency over the manipulator's, which has a frequency in Hz beside it."""
        return self.names()[0] == "omega_per_omega_M"

    def damped_frequency_Hz(self):
        """Of the coupled system without dead time; known from the axes of a variation only."""
        return self.told["manipulator_Hz"] * self.x * np.sqrt(np.maximum(0.0, 1.0 - self.y**2))

    def own_is_inside(self):
        """Whether the rig itself lies on the map."""
        own = self.told["own"]
        return self.x.min() <= own["x"] <= self.x.max() and self.y.min() <= own["y"] <= self.y.max()


def read_map(csv):
    """The map in a CSV file and the JSON file beside it. Raises OSError, ValueError or KeyError."""
    csv = Path(csv)
    told = json.loads(csv.with_suffix(".json").read_text())
    shape = told["axes"]["y"]["count"], told["axes"]["x"]["count"]
    with csv.open() as file:
        names = file.readline().strip().split(",")
        columns = dict(zip(names, np.loadtxt(file, delimiter=",", unpack=True, ndmin=2)))
    grids = [columns[name].reshape(shape) for name in [*names[:2], "spectral_radius", "growth_per_s", "wall"]]
    optional = [columns[name].reshape(shape) if name in columns else None
                for name in ("spectral_radius_low", "lyapunov_per_s", "restitution", "lasts", "faulted")]
    if told["time_domain"] and "faulted" not in columns:
        raise ValueError("its column faulted is missing; run `berth map` again")
    return Map(*grids, *optional, told)
