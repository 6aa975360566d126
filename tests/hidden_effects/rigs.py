"""Draws a rig: what the rig file says, with tolerances, and what is true within them."""

from dataclasses import dataclass

import numpy as np
from physics import truth

# Relative tolerances that rig files state. Clocks and filters are known better than masses and springs.
TOLERANCES = {
    "manipulator.mass_kg": 0.08,
    "manipulator.stiffness_N_per_m": 0.08,
    "manipulator.damping_N_s_per_m": 0.08,
    "robot.dead_time_ms": 0.02,
    "sensor.low_pass_frequency_Hz": 0.03,
    "object.mass_kg": 0.08,
    "object.stiffness_N_per_m": 0.08,
    "object.damping_N_s_per_m": 0.08,
}

# Key of the rig file -> field of the truth, and the factor between their units.
FIELD_OF_KEY = {
    "manipulator.mass_kg": ("manipulator_mass_kg", 1.0),
    "manipulator.stiffness_N_per_m": ("manipulator_stiffness_N_per_m", 1.0),
    "manipulator.damping_N_s_per_m": ("manipulator_damping_N_s_per_m", 1.0),
    "robot.dead_time_ms": ("robot_dead_time_s", 1e-3),
    "sensor.low_pass_frequency_Hz": ("low_pass_rad_per_s", 2.0 * np.pi),
    "object.mass_kg": ("object_mass_kg", 1.0),
    "object.stiffness_N_per_m": ("object_stiffness_N_per_m", 1.0),
    "object.damping_N_s_per_m": ("object_damping_N_s_per_m", 1.0),
}


@dataclass
class Rig:
    """`values`: what the rig file says, by key; `tolerances` of some of them; `true`: the fields of the truth."""

    values: dict
    tolerances: dict
    true: dict

    def toml(self):
        """The rig file."""
        sections = {}
        for path, value in self.values.items():
            section, _, key = path.rpartition(".")
            text = f'"{value}"' if isinstance(value, str) else repr(value).lower()
            if path in self.tolerances:
                text = f"{{ value = {text}, tolerance = {self.tolerances[path]!r} }}"
            sections.setdefault(section, []).append(f"{key} = {text}")
        return "\n\n".join("\n".join([f"[{s}]"] * bool(s) + lines) for s, lines in sections.items()) + "\n"


def rounded(value, digits=6):
    """A number as one would write it into a rig file."""
    return float(f"{value:.{digits}g}")


def log_uniform(rng, low, high):
    """A draw whose logarithm is uniform."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def draw_values(rng, contact, soft_grip):
    """Keys of a rig file. Gripped objects around the shipped `ess`, materials around the shipped foam."""
    spring, spring_damping = 2e7, 0.05
    rate_Hz = int(rng.choice([250, 400, 400, 400, 500]))
    period_ms = 1000.0 / rate_Hz
    M = rounded(rng.uniform(120, 300), 4)
    w = 2 * np.pi * rng.uniform(0.6, 1.4)
    K, D = M * w**2, 2 * rng.uniform(0.05, 0.15) * M * w
    if contact:
        m, k = rng.uniform(1.0, 4.0), K * rng.uniform(0.1, 0.5)
        d = rng.uniform(80.0, 250.0)
        spring = 2e6
    else:
        m, k = M * rng.uniform(0.15, 0.5), K * rng.uniform(0.15, 0.8)
        d = 2 * rng.uniform(0.02, 0.1) * np.sqrt(k * m)
        if soft_grip or rng.random() < 0.2:  # rubber jaws
            spring, spring_damping = 5e5, 0.5
    order = int(rng.choice([1, 2, 2, 2]))
    return {
        "name": "hidden",
        "loop.rate_Hz": rate_Hz,
        "manipulator.mass_kg": M,
        "manipulator.stiffness_N_per_m": rounded(K),
        "manipulator.damping_N_s_per_m": rounded(D),
        "manipulator.initial_position_m": 0.0,
        "operator.interface": "force",
        "robot.dead_time_ms": rounded(rng.uniform(4.0, 18.0), 3),
        "robot.interpolation": "linear",
        "bus.ideal": True,  # the engine's frames take no time
        "sensor.stiffness_N_per_m": spring,
        "sensor.damping_ratio": spring_damping,
        "sensor.low_pass_order": order,
        "sensor.low_pass_frequency_Hz": rounded(rng.uniform(20.0, 60.0), 3),
        "sensor.low_pass_damping_ratio": 0.7,
        "sensor.delay_ms": period_ms * int(rng.choice([1, 1, 2])),
        "object.kind": "contact" if contact else "gripped",
        "object.mass_kg": rounded(m, 4),
        "object.stiffness_N_per_m": rounded(k, 5),
        "object.damping_N_s_per_m": rounded(d, 4),
        "object.surface_position_m": rounded(rng.uniform(0.001, 0.004), 3) if contact else 0.0,
    }


def true_fields(values):
    """The fields of the truth if the rig file were right."""
    m, k_S = values["object.mass_kg"], values["sensor.stiffness_N_per_m"]
    fields = {
        "period_s": 1.0 / values["loop.rate_Hz"],
        "spring_stiffness_N_per_m": k_S,
        "spring_damping_N_s_per_m": 2.0 * values["sensor.damping_ratio"] * np.sqrt(k_S * m),
        "low_pass_order": values["sensor.low_pass_order"],
        "low_pass_damping": values["sensor.low_pass_damping_ratio"],
        "sensor_delay_s": 1e-3 * values["sensor.delay_ms"],
        "contact": float(values["object.kind"] == "contact"),
        "surface_m": values["object.surface_position_m"],
    }
    fields |= {field: factor * values[key] for key, (field, factor) in FIELD_OF_KEY.items()}
    return truth(**fields)


def draw_rig(rng, contact=False, measured_manipulator=False, soft_grip=False):
    """A rig and its truth: each parameter with a tolerance off by up to that, the firmware's manipulator exact."""
    values = draw_values(rng, contact, soft_grip)
    tolerances = {key: rounded(limit * rng.choice([0.5, 1.0]), 3) for key, limit in TOLERANCES.items()}
    true = true_fields(values)
    for key, tolerance in tolerances.items():
        off = rng.uniform(-tolerance, tolerance)
        if measured_manipulator or not key.startswith("manipulator."):
            true[FIELD_OF_KEY[key][0]] *= 1.0 + off
    true["manipulator_is_measured"] = float(measured_manipulator)
    return Rig(values, tolerances, true)
