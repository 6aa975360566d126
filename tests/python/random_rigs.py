"""Rigs drawn at random, of every kind that a verdict has to judge: held, driven, in contact, limited, faulted, with
effects of size, changing from tick to tick, with events; every second one with a compensation of the dead time."""

import math
import random

LINEAR = ["extrapolation-1", "extrapolation-2", "fixed-inverse", "force-lead", "prediction"]
NONLINEAR = ["adaptive-inverse", "identification", "passivity", "tank"]
RATES_Hz = [100, 200, 250, 400, 500]


def log_uniform(source, low, high):
    return math.exp(source.uniform(math.log(low), math.log(high)))


def base(source):
    """A gripped object and what a rig file states of the rest. About half of them are unstable."""
    rate_Hz = source.choice(RATES_Hz)
    period_ms = 1e3 / rate_Hz
    mass_kg = log_uniform(source, 50, 500)
    w = 2 * math.pi * log_uniform(source, 0.4, 2.5)
    zeta = log_uniform(source, 0.01, 0.3)
    object_kg = mass_kg * log_uniform(source, 0.05, 0.9)
    stiffness = mass_kg * w * w * log_uniform(source, 0.05, 8)
    return {
        "run": {"duration_s": round(source.uniform(8, 25), 1), "seed": source.randrange(1, 10**6)},
        "loop": {"rate_Hz": rate_Hz},
        "manipulator": {"mass_kg": mass_kg, "stiffness_N_per_m": mass_kg * w * w,
                        "damping_N_s_per_m": 2 * zeta * mass_kg * w,
                        "initial_position_m": source.choice([-1, 1]) * log_uniform(source, 1e-3, 0.02)},
        "robot": {"dead_time_ms": period_ms * source.randint(1, 4) + log_uniform(source, 0.5, 30),
                  "interpolation": source.choice(["linear", "linear", "hold"])},
        "sensor": {"delay_ms": period_ms + source.choice([0, log_uniform(source, 0.1, 10)]),
                   "low_pass_frequency_Hz": log_uniform(source, 10, 150),
                   "noise_N": source.choice([0, 0, log_uniform(source, 0.05, 2)])},
        "object": {"mass_kg": object_kg, "stiffness_N_per_m": stiffness,
                   "damping_N_s_per_m": 2 * log_uniform(source, 0.005, 0.2) * math.sqrt(stiffness * object_kg)},
    }


def held(source, rig):
    """As it is: it swings by itself."""


def driven(source, rig):
    """An operator's profile moves it."""
    kind = source.choice(["triangle", "pulses", "multisine", "chirp", "minimum_jerk", "step", "ramp"])
    whole = rig["run"]["duration_s"]
    rig["profile"] = {"kind": kind, "amplitude_m": log_uniform(source, 2e-3, 0.02),
                      "duration_s": source.uniform(1, 5) if kind in ("triangle", "pulses")
                      else source.uniform(0.2, 0.95) * whole}
    if kind == "multisine":
        rig["profile"]["frequency_end_Hz"] = 2.0
    if source.random() < 0.6:
        rig["manipulator"]["initial_position_m"] = 0.0


def contact(source, rig):
    """A tool that comes to the material, or stands in it."""
    stiffness = log_uniform(source, 1e3, 3e4)
    tool_kg = log_uniform(source, 2, 50)
    rig["object"] = {"kind": "contact", "mass_kg": tool_kg, "stiffness_N_per_m": stiffness,
                     "damping_N_s_per_m": 2 * log_uniform(source, 0.003, 0.3) * math.sqrt(stiffness * tool_kg)}
    before_m = log_uniform(source, 1e-3, 0.02)
    rig["manipulator"]["initial_position_m"] = -before_m
    if source.random() < 0.5:  # it swings about the surface
        rig["profile"] = {"kind": "rest", "offset_m": source.choice([0, log_uniform(source, 1e-3, 0.02)])}
    else:
        rig["profile"] = {"kind": "minimum_jerk", "offset_m": -before_m, "duration_s": round(source.uniform(1, 4), 2),
                          "amplitude_m": before_m + log_uniform(source, 1e-3, 0.02)}


def limited(source, rig):
    """Limits of the setpoints bound the motion."""
    start_m = abs(rig["manipulator"]["initial_position_m"])
    w = math.sqrt(rig["manipulator"]["stiffness_N_per_m"] / rig["manipulator"]["mass_kg"])
    rig["limits"] = source.choice([
        {"velocity_m_per_s": start_m * w * log_uniform(source, 0.3, 3)},
        {"acceleration_m_per_s2": start_m * w * w * log_uniform(source, 0.3, 5)},
        {"position_min_m": -start_m * source.uniform(1.1, 5), "position_max_m": start_m * source.uniform(1.1, 5)},
    ])


def faulted(source, rig):
    """Something fails, or is too much, while it runs."""
    at_s = round(source.uniform(0.3, 0.9) * rig["run"]["duration_s"], 2)
    kind = source.choice(["emergency", "enable", "force", "saturation", "losses", "never", "follow"])
    if kind == "emergency":
        rig["run"]["emergency_stop_s"] = at_s
    elif kind == "enable":
        rig["run"]["enable_off_s"] = at_s
    elif kind == "force":
        rig["sensor_channel"] = {"force_limit_N": log_uniform(source, 5, 2000)}
    elif kind == "saturation":
        rig["sensor"]["saturation_N"] = log_uniform(source, 5, 2000)
    elif kind == "losses":
        rig["bus"] = {"loss_probability": source.uniform(0.2, 0.7)}
    elif kind == "never":
        rig["run"]["emergency_stop_s"] = 0.05
    else:
        rig["reflex"] = {"following_error_m": log_uniform(source, 1e-4, 1e-2)}


def with_effects(source, rig):
    """Play, friction and the like: small motions say nothing of large ones. Those whose equivalent takes a simulation
    are left out: `limits` would take minutes."""
    amplitude_m = abs(rig["manipulator"]["initial_position_m"])
    force_N = amplitude_m * rig["object"]["stiffness_N_per_m"]
    section, values = source.choice([
        ("robot", {"backlash_m": amplitude_m * log_uniform(source, 0.01, 0.5)}),
        ("robot", {"deadband_m": amplitude_m * log_uniform(source, 0.01, 0.3)}),
        ("manipulator", {"coulomb_friction_N": force_N * log_uniform(source, 0.01, 0.5)}),
        ("object", {"coulomb_friction_N": force_N * log_uniform(source, 0.01, 0.5)}),
        ("object", {"backlash_m": amplitude_m * log_uniform(source, 0.01, 0.5)}),
        ("object", {"cubic_stiffness_N_per_m3": rig["object"]["stiffness_N_per_m"] / amplitude_m**2 *
                    log_uniform(source, 0.05, 2)}),
    ])
    rig[section].update(values)


def varying(source, rig):
    """The loop changes from tick to tick."""
    section, values = source.choice([
        ("robot", {"jitter_ms": 1e3 / rig["loop"]["rate_Hz"] * log_uniform(source, 0.01, 0.4)}),
        ("sensor", {"loss_probability": log_uniform(source, 0.005, 0.1)}),
        ("bus", {"loss_probability": log_uniform(source, 0.005, 0.1)}),
        ("bus", {"burst_probability": log_uniform(source, 0.001, 0.01), "burst_length_frames": 3}),
        ("robot", {"clock": "free", "clock_drift_ppm": source.uniform(-100, 100)}),
    ])
    rig.setdefault(section, {}).update(values)


def with_events(source, rig):
    """The grip closes or opens, the dead time jumps, or the run is short."""
    at_s = round(source.uniform(0.2, 0.8) * rig["run"]["duration_s"], 2)
    kind = source.choice(["close", "never closes", "release", "jump", "short", "still", "nothing"])
    if kind == "close":
        rig["run"]["grip_close_s"] = at_s
    elif kind == "never closes":
        rig["run"]["grip_close_s"] = rig["run"]["duration_s"] + 1
    elif kind == "release":
        rig["run"]["grip_release_s"] = at_s
    elif kind == "jump":
        rig["run"].update({"dead_time_jump_s": at_s, "dead_time_jump_ms": source.uniform(1, 40)})
    elif kind == "short":
        rig["run"]["duration_s"] = round(log_uniform(source, 0.2, 3), 2)
    elif kind == "still":
        rig["manipulator"]["initial_position_m"] = 0.0
    else:
        rig["object"] = {"kind": "none"}


KINDS = {"held": held, "driven": driven, "contact": contact, "limited": limited, "faulted": faulted,
         "effects": with_effects, "varying": varying, "events": with_events}


def draw(seed, index):
    """Rig number `index`: its kind, its sections, and names for --with."""
    source = random.Random(f"{seed} {index}")
    names = list(KINDS)
    name = names[index % len(names)]
    rig = base(source)
    KINDS[name](source, rig)
    is_compensated = index // len(names) % 2 == 1 and name not in ("varying",)
    method = [source.choice(LINEAR + NONLINEAR)] if is_compensated else []
    return name, rig, method


def toml(rig):
    """The text of its file."""
    def value(of):
        return f'"{of}"' if isinstance(of, str) else f"{of:.6g}" if isinstance(of, float) else str(of)

    return "".join(f"[{section}]\n" + "".join(f"{key} = {value(of)}\n" for key, of in keys.items())
                   for section, keys in rig.items())
