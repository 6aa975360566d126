"""A map written by `berth map`: its grids, and what every picture of it shows."""
import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

TITLES = {"omega_per_omega_M": "ω/ω_M of the coupled system without dead time",
          "zeta": "damping ratio ζ of the coupled system without dead time"}


@dataclass(frozen=True)
class Map:
    """Grids (rows of y) of a map over two parameters; nan in `radius` where no such rig is possible."""
    x: np.ndarray
    y: np.ndarray
    radius: np.ndarray  # largest |z|
    is_below_wall: np.ndarray  # 1 or 0, nan where not possible
    lower: np.ndarray | None  # |z| at the lower end of a robot's dead time; None: it has no range
    growth_varying_per_s: np.ndarray | None  # Lyapunov exponents with jitter, drift or losses; None: without
    told: dict  # the JSON file beside the CSV file

    def names(self):
        """Names of both axes, as the rig file has them."""
        return [self.told["axes"][axis]["name"] for axis in "xy"]

    def titles(self):
        """Titles of both axes."""
        return [TITLES.get(name, name) for name in self.names()]

    def damped_frequency_Hz(self):
        """Of the coupled system without dead time; known from the axes of a variation only."""
        return self.told["manipulator_Hz"] * self.x * np.sqrt(np.maximum(0.0, 1.0 - self.y**2))

    def colour_range(self):
        """Lowest and highest |z| to tell apart by colour, about 1; outliers of one in a hundred are left out."""
        low, high = np.nanpercentile(self.radius, [1, 99])
        return min(low, 1.0 - 1e-6), max(high, 1.0 + 1e-6)

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
    grids = [columns[name].reshape(shape) for name in [*names[:2], "spectral_radius", "wall"]]
    optional = [columns[name].reshape(shape) if name in columns else None
                for name in ("spectral_radius_low", "lyapunov_per_s")]
    return Map(*grids, *optional, told)
