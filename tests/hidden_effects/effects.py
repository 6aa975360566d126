"""The library's effects as the truth has them: which fields change, by how much, and what the parameters are called.

Each draw gets `s`, a share of what the record does: a large effect is a good part of the motion, a tiny one is lost
in the noise of many records. `richer` draws have physics that the library's candidates lack: presliding, a static
part of friction, integral action that winds up at a limit.
"""

from dataclasses import dataclass, field

import numpy as np
from rigs import FIELD_OF_KEY, log_uniform

SIZES = {"large": 0.4, "medium": 0.1, "small": 0.025, "tiny": 0.006}


@dataclass
class Scale:
    """What the record does without the effect."""

    position_m: float
    velocity_m_per_s: float
    acceleration_m_per_s2: float
    force_rms_N: float
    force_peak_N: float
    pull_peak_N: float
    drive_rms_N: float
    duration_s: float
    period_s: float


@dataclass
class Change:
    """`fields` of the truth, `parameters` by the names that diagnosis.json uses, `chances` of random losses."""

    fields: dict
    parameters: dict
    chances: dict = field(default_factory=dict)


def same(name, value, parameter, factor=1.0):
    """A change of one field that is one parameter, `factor` between their units."""
    return Change({name: float(value)}, {parameter: float(value * factor)})


def sign(rng):
    return float(rng.choice([-1.0, 1.0]))


# --- robot ------------------------------------------------------------------------------------------------------


def dead_time(rng, s, scale, rig, richer):
    key = "robot.dead_time_ms"
    nominal_ms = rig.values[key]
    off_ms = nominal_ms * rig.tolerances[key] + s * 12.0
    lowest_ms = 1000.0 * scale.period_s
    ms = nominal_ms + off_ms * (sign(rng) if nominal_ms - off_ms > lowest_ms else 1.0)
    return same("robot_dead_time_s", 1e-3 * ms, "dead_time_ms", 1e3)


def dead_time_drift(rng, s, scale, rig, richer):
    total_ms = s * 15.0
    falls = rng.random() < 0.5 and rig.values["robot.dead_time_ms"] - total_ms > 1000.0 * scale.period_s
    return same("robot_dead_time_drift", (-1e-3 if falls else 1e-3) * total_ms / scale.duration_s,
                "dead_time_drift_ms_per_s", 1e3)


def robot_gain(rng, s, scale, rig, richer):
    return same("robot_gain", 1.0 + sign(rng) * 0.25 * s, "gain")


def robot_lag(rng, s, scale, rig, richer):
    return same("robot_lag_s", 0.025 * s, "lag_ms", 1e3)


def resonance(rng, s, scale, rig, richer):
    f_Hz, z = 5.0 / np.sqrt(s), rng.uniform(0.2, 0.8)
    return Change({"robot_resonance_rad_per_s": 2 * np.pi * f_Hz, "robot_resonance_damping": z},
                  {"transfer_frequency_Hz": f_Hz, "transfer_damping_ratio": z})


def velocity_limit(rng, s, scale, rig, richer):
    change = same("robot_velocity_limit_m_per_s", scale.velocity_m_per_s * (1.0 - s), "velocity_limit_m_per_s")
    if richer:
        change.fields |= {"robot_windup_per_s": rng.uniform(0.3, 2.0), "robot_windup_leak_s": rng.uniform(0.1, 0.4)}
    return change


def acceleration_limit(rng, s, scale, rig, richer):
    limit = scale.acceleration_m_per_s2 * (1.0 - s)
    change = same("robot_acceleration_limit_m_per_s2", limit, "acceleration_limit_m_per_s2")
    if richer:
        change.fields |= {"robot_windup_per_s": rng.uniform(0.3, 2.0), "robot_windup_leak_s": rng.uniform(0.1, 0.4)}
    return change


def robot_backlash(rng, s, scale, rig, richer):
    return same("robot_backlash_m", 0.2 * s * scale.position_m, "backlash_m")


def deadband(rng, s, scale, rig, richer):
    return same("robot_deadband_m", 0.05 * s * scale.position_m, "deadband_m")


def lost_commands(rng, s, scale, rig, richer):
    return Change({}, {"lost_command_probability": 0.25 * s}, {"command_lost": 0.25 * s})


def periodic_error(rng, s, scale, rig, richer):
    a, pitch, phase = 1e-4 * s, rng.uniform(0.004, 0.02), rng.uniform(-np.pi, np.pi)
    return Change({"robot_periodic_m": a, "robot_pitch_m": pitch, "robot_periodic_rad": phase},
                  {"periodic_error_m": a, "periodic_error_pitch_m": pitch, "periodic_error_phase_rad": phase})


# --- manipulator ------------------------------------------------------------------------------------------------


def parameters_of(block, gains):
    """One or two of a block's parameters beyond their tolerance; `gains`: how far at s = 1."""

    def draw(rng, s, scale, rig, richer):
        keys = [f"{block}.{name}" for name in gains]
        chosen = rng.choice(keys, size=int(rng.choice([1, 2])), replace=False)
        change = Change({}, {})
        for key in chosen:
            name = key.split(".")[1]
            off = rig.tolerances[key] + gains[name] * s
            factor = 1.0 + off if rng.random() < 0.5 else 1.0 / (1.0 + off)
            field_name, unit = FIELD_OF_KEY[key]
            change.fields[field_name] = rig.values[key] * unit * factor
            change.parameters[name] = rig.values[key] * factor
        return change

    return draw


def presliding(rng, richer):
    """Length over which friction builds up: micrometres, or next to nothing."""
    return log_uniform(rng, 2e-6, 2e-5) if richer else 1e-7


def manipulator_coulomb(rng, s, scale, rig, richer):
    s = s**1.5  # its position is known to a fraction of a micrometre: the same share would always be clear
    Fc = 0.8 * s * scale.drive_rms_N
    return Change({"manipulator_friction_up_N": Fc, "manipulator_friction_down_N": Fc,
                   "manipulator_presliding_m": presliding(rng, richer)}, {"coulomb_friction_N": Fc})


def asymmetric_friction(rng, s, scale, rig, richer):
    """Fc +- a and D +- b where x' is positive and negative."""
    s = s**1.5
    Fc = 0.8 * s * scale.drive_rms_N
    a = sign(rng) * Fc * rng.uniform(0.2, 0.5)
    b = sign(rng) * rig.values["manipulator.damping_N_s_per_m"] * min(0.5, s * rng.uniform(0.5, 1.5))
    return Change(
        {"manipulator_friction_up_N": Fc + a, "manipulator_friction_down_N": Fc - a,
         "manipulator_damping_asymmetry_N_s_per_m": b, "manipulator_presliding_m": presliding(rng, richer)},
        {"coulomb_friction_N": Fc, "friction_asymmetry_N": a, "damping_asymmetry_N_s_per_m": b})


def spring_term(block, field_name, parameter, order, strength):
    """A force that reaches strength * s of the linear spring's at the record's amplitude."""

    def draw(rng, s, scale, rig, richer):
        k = rig.values[f"{block}.stiffness_N_per_m"]
        s = s**1.5 if block == "manipulator" else s
        softens = rng.random() < 0.4
        factor = sign(rng) if order == 1 else -0.5 if softens else 1.0
        return same(field_name, factor * strength * s * k / scale.position_m**order, parameter)

    return draw


def manipulator_backlash(rng, s, scale, rig, richer):
    s = s**1.5
    return same("manipulator_gap_m", 0.5 * s * scale.position_m, "backlash_m")


def gravity_offset(rng, s, scale, rig, richer):
    s = s**1.5
    return same("manipulator_gravity_N", sign(rng) * 0.8 * s * scale.drive_rms_N, "gravity_offset_N")


# --- object -----------------------------------------------------------------------------------------------------


def spring_N(scale, rig):
    return rig.values["object.stiffness_N_per_m"] * scale.position_m


def object_coulomb(rng, s, scale, rig, richer):
    Fc = 0.5 * s * spring_N(scale, rig)
    change = same("object_friction_N", Fc, "coulomb_friction_N")
    change.fields["object_presliding_m"] = presliding(rng, richer)
    if richer:
        change.fields |= {"object_static_ratio": rng.uniform(1.0, 1.15), "object_stribeck_m_per_s": 0.002}
    return change


def object_backlash(rng, s, scale, rig, richer):
    return same("object_gap_m", 0.6 * s * scale.position_m, "backlash_m")


def second_mode(rng, s, scale, rig, richer):
    m2, f_Hz, z = 0.4 * s * rig.values["object.mass_kg"], rng.uniform(1.5, 8.0), rng.uniform(0.01, 0.06)
    w = 2 * np.pi * f_Hz
    return Change({"second_mass_kg": m2, "second_stiffness_N_per_m": m2 * w**2,
                   "second_damping_N_s_per_m": 2 * z * m2 * w},
                  {"second_mass_kg": m2, "second_frequency_Hz": f_Hz, "second_damping_ratio": z})


def hysteresis(rng, s, scale, rig, richer):
    force_N, length_m = 0.5 * s * spring_N(scale, rig), scale.position_m * rng.uniform(0.05, 0.3)
    exponent = rng.uniform(1.0, 2.5) if rng.random() < 0.5 else 0.0
    change = Change({"object_hysteresis_N": force_N, "object_hysteresis_length_m": length_m,
                     "object_hysteresis_exponent": exponent},
                    {"hysteresis_force_N": force_N, "hysteresis_length_m": length_m})
    if exponent:
        change.parameters["hysteresis_exponent"] = exponent
    return change


def stiffness_drift(rng, s, scale, rig, richer):
    return same("object_drift_per_s", sign(rng) * 0.6 * s / scale.duration_s, "stiffness_drift_per_s")


def loss_of_contact(rng, s, scale, rig, richer):
    """Rigs with soft jaws: on stiff ones the object bounces so often that no two runs are alike."""
    return same("grip_N", scale.pull_peak_N * (1.0 - 0.7 * s), "grip_force_N")


def impact_damping(rng, s, scale, rig, richer):
    """About the force that the linear damper has at half of the greatest depth."""
    k, d = rig.values["object.stiffness_N_per_m"], rig.values["object.damping_N_s_per_m"]
    c = d / (k * 0.5 * scale.position_m) * (1.0 + sign(rng) * s)
    return same("impact_damping_s_per_m", c, "impact_damping_s_per_m")


def relaxation(rng, s, scale, rig, richer):
    """Its spring as strong as the object's at s = 1; it settles within the periods of the motion."""
    stiffness, time_s = s * rig.values["object.stiffness_N_per_m"], log_uniform(rng, 0.05, 1.0)
    return Change({"relaxation_N_per_m": stiffness, "relaxation_s": time_s},
                  {"relaxation_stiffness_N_per_m": stiffness, "relaxation_time_ms": 1e3 * time_s})


def stribeck_friction(rng, s, scale, rig, richer):
    """Beside dry friction of its own size."""
    s = s**1.5
    Fc, Fs = 0.5 * s * scale.drive_rms_N, 0.5 * s * scale.drive_rms_N
    v = scale.velocity_m_per_s * rng.uniform(0.05, 0.2)
    return Change({"manipulator_friction_up_N": Fc, "manipulator_friction_down_N": Fc, "manipulator_presliding_m": 1e-7,
                   "manipulator_stribeck_N": Fs, "manipulator_stribeck_m_per_s": v},
                  {"coulomb_friction_N": Fc, "stribeck_friction_N": Fs, "stribeck_velocity_m_per_s": v})


def tool_inertia(rng, s, scale, rig, richer):
    return same("tool_mass_kg", s * rig.values["object.mass_kg"], "tool_mass_kg")


def even_term(rng, s, scale, rig, richer):
    return same("sensor_even_per_N", sign(rng) * 0.6 * s / scale.force_peak_N, "curvature_per_N")


# --- sensor, loop -----------------------------------------------------------------------------------------------


def sensor_bias(rng, s, scale, rig, richer):
    return same("sensor_bias_N", sign(rng) * s * scale.force_rms_N, "bias_N")


def sensor_drift(rng, s, scale, rig, richer):
    return same("sensor_drift_N_per_s", sign(rng) * 2.0 * s * scale.force_rms_N / scale.duration_s, "drift_N_per_s")


def sensor_gain(rng, s, scale, rig, richer):
    return same("sensor_gain", 1.0 + sign(rng) * 0.4 * s, "gain")


def sensor_lag(rng, s, scale, rig, richer):
    return same("sensor_lag_s", 0.025 * s, "lag_ms", 1e3)


def sensor_delay(rng, s, scale, rig, richer):
    ms = rig.values["sensor.delay_ms"] + s * 15.0
    return same("sensor_delay_s", 1e-3 * ms, "delay_ms", 1e3)


def saturation(rng, s, scale, rig, richer):
    return same("sensor_saturation_N", scale.force_peak_N * (1.0 - s), "saturation_N")


def quantisation(rng, s, scale, rig, richer):
    return same("sensor_step_N", float(f"{s * scale.force_rms_N:.3g}"), "resolution_N")


def dropouts(rng, s, scale, rig, richer):
    return Change({}, {"loss_probability": 0.4 * s}, {"force_lost": 0.4 * s})


def spikes(rng, s, scale, rig, richer):
    p, size_N = rng.uniform(0.002, 0.01), 4.0 * s * scale.force_rms_N
    return Change({}, {"spike_probability": p, "spike_N": size_N}, {"spike": p, "spike_N": size_N})


def periodic_disturbance(rng, s, scale, rig, richer):
    a, f_Hz, phase = 0.4 * s * scale.force_rms_N, log_uniform(rng, 0.3, 60.0), rng.uniform(-np.pi, np.pi)
    return Change({"sensor_periodic_N": a, "sensor_periodic_rad_per_s": 2 * np.pi * f_Hz,
                   "sensor_periodic_rad": phase},
                  {"periodic_N": a, "periodic_frequency_Hz": f_Hz, "periodic_phase_rad": phase})


def lost_samples(rng, s, scale, rig, richer):
    return Change({}, {"lost_sample_probability": 0.25 * s}, {"tick_lost": 0.25 * s})


def clock_drift(rng, s, scale, rig, richer):
    ppm, phase_s = sign(rng) * 500.0 * s, rng.uniform(0.0, scale.period_s)
    return Change({"free_clock": 1.0, "clock_drift": 1e-6 * ppm, "clock_phase_s": phase_s},
                  {"clock_drift_ppm": ppm, "clock_phase_ms": 1e3 * phase_s})


BLOCK_GAINS = {"mass_kg": 1.0, "stiffness_N_per_m": 1.0, "damping_N_s_per_m": 4.0}

LIBRARY = {
    "robot.dead_time": dead_time,
    "robot.dead_time_drift": dead_time_drift,
    "robot.gain": robot_gain,
    "robot.lag": robot_lag,
    "robot.resonance": resonance,
    "robot.velocity_limit": velocity_limit,
    "robot.acceleration_limit": acceleration_limit,
    "robot.backlash": robot_backlash,
    "robot.deadband": deadband,
    "robot.lost_commands": lost_commands,
    "robot.periodic_error": periodic_error,
    "manipulator.parameters": parameters_of("manipulator", BLOCK_GAINS),
    "manipulator.coulomb_friction": manipulator_coulomb,
    "manipulator.asymmetric_friction": asymmetric_friction,
    "manipulator.cubic_stiffness": spring_term(
        "manipulator", "manipulator_cubic_N_per_m3", "cubic_stiffness_N_per_m3", 2, 0.8),
    "manipulator.quadratic_stiffness": spring_term(
        "manipulator", "manipulator_quadratic_N_per_m2", "quadratic_stiffness_N_per_m2", 1, 0.8),
    "manipulator.backlash": manipulator_backlash,
    "manipulator.gravity_offset": gravity_offset,
    "object.parameters": parameters_of("object", BLOCK_GAINS),
    "object.cubic_stiffness": spring_term("object", "object_cubic_N_per_m3", "cubic_stiffness_N_per_m3", 2, 1.0),
    "object.quadratic_stiffness": spring_term(
        "object", "object_quadratic_N_per_m2", "quadratic_stiffness_N_per_m2", 1, 0.8),
    "object.coulomb_friction": object_coulomb,
    "object.backlash": object_backlash,
    "object.second_mode": second_mode,
    "object.hysteresis": hysteresis,
    "object.stiffness_drift": stiffness_drift,
    "object.loss_of_contact": loss_of_contact,
    "object.impact_damping": impact_damping,
    "sensor.bias": sensor_bias,
    "sensor.drift": sensor_drift,
    "sensor.gain": sensor_gain,
    "sensor.lag": sensor_lag,
    "sensor.delay": sensor_delay,
    "sensor.saturation": saturation,
    "sensor.quantisation": quantisation,
    "sensor.dropouts": dropouts,
    "sensor.spikes": spikes,
    "sensor.periodic_disturbance": periodic_disturbance,
    "loop.lost_samples": lost_samples,
    "loop.clock_drift": clock_drift,
}

# Drawn on request only. Every other seed keeps its draw.
ASKED_FOR = {
    "manipulator.stribeck_friction": stribeck_friction,
    "object.relaxation": relaxation,
    "sensor.curvature": even_term,
    "sensor.tool_inertia": tool_inertia,
}
