"""A case of the paper: one rig and what was assumed for it, at the three interfaces that the paper compares."""
import hashlib
import tomllib
from dataclasses import dataclass, fields, replace
from math import pi, sqrt
from pathlib import Path

RIG_FOLDER = Path(__file__).resolve().parents[1] / "sim_hal" / "rigs"
SLOW, FAST, HALF = "ess-50hz", "ess", "ess-half-dead-time"
RIGS = (SLOW, FAST, HALF)
CASES = (FAST, "ess-paper")  # the rigs at 400 Hz; the paper's is found by paper_search.py

# The same rig at the other two interfaces. A frame may be late by three periods and more before it is stale.
INTERFACES = {SLOW: {"loop.rate_Hz": 50, "robot.dead_time_ms": 40, "sensor.delay_ms": 20,
                     "sensor_channel.stale_after_ms": 200, "robot_channel.stale_after_ms": 200},
              FAST: {}, HALF: {"robot.dead_time_ms": 7.5}}


@dataclass(frozen=True)
class Assumptions:
    """What the paper does not tell, without a unit where a ratio says as much. Of the manipulator's mass itself the
    loop takes only its ratio to the object's and to the sensor's stiffness."""
    manipulator_Hz: float
    manipulator_damping_ratio: float
    object_mass_share: float  # of the manipulator's
    object_stiffness_share: float
    object_damping_ratio: float
    low_pass_Hz: float
    manipulator_kg: float = 200.0

    def values(self):
        """As keys of a rig file."""
        w = 2.0 * pi * self.manipulator_Hz
        M, K = self.manipulator_kg, self.manipulator_kg * w * w
        m, k = self.object_mass_share * M, self.object_stiffness_share * K
        return {"manipulator.mass_kg": M, "manipulator.stiffness_N_per_m": K,
                "manipulator.damping_N_s_per_m": 2.0 * self.manipulator_damping_ratio * sqrt(K * M),
                "object.mass_kg": m, "object.stiffness_N_per_m": k,
                "object.damping_N_s_per_m": 2.0 * self.object_damping_ratio * sqrt(k * m),
                "sensor.low_pass_frequency_Hz": self.low_pass_Hz}

    def with_one_of(self, other):
        """By name of each assumption that differs: these, but that one of the other."""
        return {field.name: replace(self, **{field.name: getattr(other, field.name)}) for field in fields(self)
                if getattr(self, field.name) != getattr(other, field.name)}


def assumptions_of(rig):
    """Those of a shipped rig, to the digits that its file has of them."""
    told = tomllib.loads((RIG_FOLDER / f"{rig}.toml").read_text())
    arm, held = told["manipulator"], told["object"]
    M, K, D = (arm[key] for key in ("mass_kg", "stiffness_N_per_m", "damping_N_s_per_m"))
    m, k, d = (held[key] for key in ("mass_kg", "stiffness_N_per_m", "damping_N_s_per_m"))
    exact = (sqrt(K / M) / (2.0 * pi), D / (2.0 * sqrt(K * M)), m / M, k / K, d / (2.0 * sqrt(k * m)),
             told["sensor"]["low_pass_frequency_Hz"], M)
    return Assumptions(*[float(f"{value:.9g}") for value in exact])


@dataclass(frozen=True)
class Case:
    """A shipped rig, with its own assumptions or with others."""
    rig: str = FAST
    changed: Assumptions = None

    @property
    def assumptions(self):
        return self.changed or assumptions_of(self.rig)

    @property
    def spoken(self):
        return "the case" if self.changed else self.rig

    def at(self, interface):
        """The rig and its overrides at one of the interfaces; those of ess are shipped."""
        changed = self.changed.values() if self.changed else {}
        if self.rig == FAST:
            return interface, changed
        return self.rig, INTERFACES[interface] | changed

    def name(self, interface):
        """Of a folder for what is measured there."""
        own = "-" + hashlib.sha256(repr(self.changed).encode()).hexdigest()[:12] if self.changed else ""
        return f"{self.rig}-at-{interface}{own}"
