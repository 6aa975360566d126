"""Can this record tell the true effect from another one? Asked only where a diagnosis has named another one.

The other effect's parameters, and the base within its tolerances, are fitted to the true blocks' noise-free answer.
If what is left has chi2 <= 10 (in units of the noise, as in detectability), no method can hold the two apart on this
record: the names are then a documented pair, and no wrong name.
"""

import numpy as np
from detectability import Tuning, stacked, with_effects
from effects import Change
from scipy.optimize import least_squares

CHI2_APART = 10.0

# effect -> {parameter of diagnosis.json: (field of the truth, factor to SI)}; others cannot be asked about.
FIELDS = {
    "robot.dead_time": {"dead_time_ms": ("robot_dead_time_s", 1e-3)},
    "robot.dead_time_drift": {"dead_time_drift_ms_per_s": ("robot_dead_time_drift", 1e-3)},
    "robot.gain": {"gain": ("robot_gain", 1.0)},
    "robot.lag": {"lag_ms": ("robot_lag_s", 1e-3)},
    "robot.resonance": {"transfer_frequency_Hz": ("robot_resonance_rad_per_s", 2 * np.pi),
                        "transfer_damping_ratio": ("robot_resonance_damping", 1.0)},
    "robot.velocity_limit": {"velocity_limit_m_per_s": ("robot_velocity_limit_m_per_s", 1.0)},
    "robot.acceleration_limit": {"acceleration_limit_m_per_s2": ("robot_acceleration_limit_m_per_s2", 1.0)},
    "robot.backlash": {"backlash_m": ("robot_backlash_m", 1.0)},
    "robot.deadband": {"deadband_m": ("robot_deadband_m", 1.0)},
    "robot.periodic_error": {"periodic_error_m": ("robot_periodic_m", 1.0),
                             "periodic_error_pitch_m": ("robot_pitch_m", 1.0),
                             "periodic_error_phase_rad": ("robot_periodic_rad", 1.0)},
    "manipulator.parameters": {"mass_kg": ("manipulator_mass_kg", 1.0),
                               "damping_N_s_per_m": ("manipulator_damping_N_s_per_m", 1.0),
                               "stiffness_N_per_m": ("manipulator_stiffness_N_per_m", 1.0)},
    "manipulator.cubic_stiffness": {"cubic_stiffness_N_per_m3": ("manipulator_cubic_N_per_m3", 1.0)},
    "manipulator.quadratic_stiffness": {"quadratic_stiffness_N_per_m2": ("manipulator_quadratic_N_per_m2", 1.0)},
    "manipulator.backlash": {"backlash_m": ("manipulator_gap_m", 1.0)},
    "manipulator.gravity_offset": {"gravity_offset_N": ("manipulator_gravity_N", 1.0)},
    "object.parameters": {"mass_kg": ("object_mass_kg", 1.0),
                          "damping_N_s_per_m": ("object_damping_N_s_per_m", 1.0),
                          "stiffness_N_per_m": ("object_stiffness_N_per_m", 1.0)},
    "object.cubic_stiffness": {"cubic_stiffness_N_per_m3": ("object_cubic_N_per_m3", 1.0)},
    "object.quadratic_stiffness": {"quadratic_stiffness_N_per_m2": ("object_quadratic_N_per_m2", 1.0)},
    "object.coulomb_friction": {"coulomb_friction_N": ("object_friction_N", 1.0)},
    "object.backlash": {"backlash_m": ("object_gap_m", 1.0)},
    "object.hysteresis": {"hysteresis_force_N": ("object_hysteresis_N", 1.0),
                          "hysteresis_length_m": ("object_hysteresis_length_m", 1.0)},
    "object.stiffness_drift": {"stiffness_drift_per_s": ("object_drift_per_s", 1.0)},
    "object.loss_of_contact": {"grip_force_N": ("grip_N", 1.0)},
    "object.impact_damping": {"impact_damping_s_per_m": ("impact_damping_s_per_m", 1.0)},
    "sensor.bias": {"bias_N": ("sensor_bias_N", 1.0)},
    "sensor.drift": {"drift_N_per_s": ("sensor_drift_N_per_s", 1.0)},
    "sensor.gain": {"gain": ("sensor_gain", 1.0)},
    "sensor.lag": {"lag_ms": ("sensor_lag_s", 1e-3)},
    "sensor.delay": {"delay_ms": ("sensor_delay_s", 1e-3)},
    "sensor.saturation": {"saturation_N": ("sensor_saturation_N", 1.0)},
    "loop.clock_drift": {"clock_drift_ppm": ("clock_drift", 1e-6), "clock_phase_ms": ("clock_phase_s", 1e-3)},
}
SWITCHES = {"loop.clock_drift": {"free_clock": 1.0}}


# From where to begin with an effect that a diagnosis offers without its size, in the units of diagnosis.json; the
# others cannot be asked about then.
BEGINNINGS = {"sensor.gain": {"gain": 1.001}, "robot.gain": {"gain": 1.001}, "robot.lag": {"lag_ms": 1.0},
              "sensor.lag": {"lag_ms": 1.0},
              "robot.resonance": {"transfer_frequency_Hz": 50.0, "transfer_damping_ratio": 0.7}}
OF_THE_BASE = {"robot.dead_time", "sensor.delay", "object.parameters", "manipulator.parameters"}


def lateness_of_clocks(scenario, effect):
    """What makes the lateness drift as it truly does, as the clock that does not slip: the dead time's own drift, or
    an uneven clock."""
    true, period_s = scenario.true, scenario.base["period_s"]
    slope = true["robot_dead_time_drift"] or true["clock_drift"]
    if slope == 0.0:
        return {}
    way_s = slope * len(scenario.runs["record"].result["force_N"]) * period_s
    return {"robot.dead_time_drift": {"dead_time_drift_ms_per_s": 1e3 * slope},
            "loop.clock_drift": {"clock_drift_ppm": 1e6 * slope,
                                 "clock_phase_ms": 1e3 * (0.02 * period_s - min(way_s, 0.0))}}[effect]


def beginning(scenario, effect):
    """Parameters to begin with."""
    if effect in ("robot.dead_time_drift", "loop.clock_drift"):
        return lateness_of_clocks(scenario, effect)
    if effect in OF_THE_BASE:
        return {name: scenario.base[field] / factor for name, (field, factor) in FIELDS[effect].items()}
    return BEGINNINGS.get(effect, {})


def chi2_between(scenario, effect, start, beside=()):
    """What is left of the true record when `effect` stands in for the truth; `start`: parameters to begin with;
    `beside`: changes of the truth that it does not stand in for.

    None where the question cannot be asked: a random effect, a parameter that is missing, a block that overflows.
    """
    table = FIELDS.get(effect)
    start = start or beginning(scenario, effect)
    if table is None or not set(start) & set(table):
        return None
    run, tuning = scenario.runs["record"], Tuning(scenario)
    truth = with_effects(scenario, run, [change for _, _, change in scenario.effects])
    names = [name for name in table if name in start]
    scale = np.array([abs(start[name] * table[name][1]) or 1e-12 for name in names])

    def left(x):
        values = {table[name][0]: float(value) for name, value in zip(names, x * scale)} | SWITCHES.get(effect, {})
        return stacked(scenario, tuning.absorb(truth, [Change(values, {}), *beside])[1])

    first = np.array([start[name] * table[name][1] for name in names]) / scale
    if not np.all(np.isfinite(left(first))):
        return None
    found = least_squares(left, first, diff_step=1e-3, max_nfev=12)  # passes over what is not finite
    return 2.0 * float(found.cost)


def indistinguishable(scenario, effect, start):
    """This record cannot tell `effect` from the truth, or from one of several effects that are true."""
    changes = [change for _, _, change in scenario.effects]
    for replaced in changes:
        chi2 = chi2_between(scenario, effect, start, [change for change in changes if change is not replaced])
        if chi2 is not None and chi2 <= CHI2_APART:
            return True
    return False
