#!/usr/bin/env python3
"""A simulated free mass hits a real wall that is displayed through dead time: how much of its speed it comes back with,
by compensation, beside what it would be without dead time. Li et al. (J. Aerosp. Eng. 2026) published 300 kg, 3 Hz and
3 ms, w0 tau = 0.057: 1.0892 without compensation, 1.0218 with a hybrid Smith predictor, 0.9987 with an observer;
ideal 1.

  restitution.py [--noise N] [--seeds COUNT] [--stiffness SHARE] [--dead-time SHARE]
  restitution.py --limits [...] [--method NAME]       up to which w0 tau each method holds, over masses and stiffnesses
"""
import argparse
import itertools
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from berth_log import InputError
from berth_program import Berth

MASS_kg = 300.0
FREQUENCY_Hz = 3.0
W0_rad_per_s = 2 * np.pi * FREQUENCY_Hz
SPEED_m_per_s = 0.1
PERIODS_ms = (0.5, 0.25, 0.125, 0.1, 0.05)  # of the loop, and of the force on its way
PHASES = (0.04, 0.057, 0.1, 0.2, 0.3, 0.45, 0.6)  # w0 tau
LIMIT_PHASES = (0.02, 0.04, 0.06, 0.1, 0.15, 0.2, 0.3, 0.45, 0.6)
LIMIT_MASSES_kg = (30.0, 300.0, 3000.0)
LIMIT_FREQUENCIES_Hz = (1.0, 3.0, 10.0)
DAMPING_RATIOS = (0.0, 0.1)
TOLERANCES = (0.01, 0.05)
PREDICTION = {"prediction.enabled": "true"}
PASSIVITY = {"passivity.action": "damping", "passivity.credit_J": 0.02, "passivity.horizon_ms": 10}
METHODS = {
    "none": {},
    "prediction": PREDICTION,
    "identification": PREDICTION | {"identification.enabled": "true"},
    "extrapolation-1": {"extrapolation.order": 1},
    "extrapolation-2": {"extrapolation.order": 2},
    "extrapolation-3": {"extrapolation.order": 3},
    "passivity": PASSIVITY,
}
impacts = itertools.count()


def ideal(damping_ratio):
    """The wall pushes and never pulls: it lets go where k x + d v = 0, at a phase of atan2(2 z s, 2 z^2 - 1)."""
    if damping_ratio == 0:
        return 1.0
    s = np.sqrt(1 - damping_ratio**2)
    return np.exp(-damping_ratio / s * np.arctan2(2 * damping_ratio * s, 2 * damping_ratio**2 - 1))


def rig(phase, damping_ratio, noise_N, seed, mass_kg=MASS_kg, frequency_Hz=FREQUENCY_Hz):
    """A loop with `phase` / w0 of delay in all: robot, force, and half a period that the force is held. The robot has
    at least a period of it."""
    w0_rad_per_s = 2 * np.pi * frequency_Hz
    delay_ms = 1e3 * phase / w0_rad_per_s
    period_ms = next(period for period in PERIODS_ms if 2.5 * period <= delay_ms)
    return {
        "loop.rate_Hz": 1e3 / period_ms, "bus.ideal": "true", "run.duration_s": 0.2 + 3 / frequency_Hz,
        "run.release_s": 0.01,
        "manipulator.mass_kg": mass_kg, "manipulator.stiffness_N_per_m": 0, "manipulator.damping_N_s_per_m": 0,
        "manipulator.initial_position_m": -0.005, "manipulator.initial_velocity_m_per_s": SPEED_m_per_s,
        "limits.acceleration_m_per_s2": 1e7, "limits.velocity_m_per_s": 100, "sensor_channel.force_limit_N": 1e6,
        "run.seed": seed, "robot.dead_time_ms": delay_ms - 1.5 * period_ms,
        "sensor.delay_ms": period_ms,
        "sensor.stiffness_N_per_m": 1e8 * mass_kg / MASS_kg * (frequency_Hz / FREQUENCY_Hz)**2,
        "sensor.damping_ratio": 0.7, "sensor.low_pass_order": 0, "sensor.noise_N": noise_N,
        "object.kind": "contact", "object.mass_kg": 0.1 * mass_kg / MASS_kg,
        "object.stiffness_N_per_m": mass_kg * w0_rad_per_s**2,
        "object.damping_N_s_per_m": 2 * damping_ratio * mass_kg * w0_rad_per_s,
    }


def settings_of(method, values):
    """What a passivity controller is set to goes with energy and period of the impact."""
    settings = METHODS[method]
    if "passivity.action" not in settings:
        return settings
    mass_share = values["manipulator.mass_kg"] / MASS_kg
    w0_rad_per_s = np.sqrt(values["object.stiffness_N_per_m"] / values["manipulator.mass_kg"])
    faster = w0_rad_per_s / W0_rad_per_s
    return settings | {"passivity.credit_J": settings["passivity.credit_J"] * mass_share,
                       "passivity.horizon_ms": settings["passivity.horizon_ms"] / faster,
                       "passivity.damping_max_N_s_per_m": 5000 * mass_share * faster}


def restitution(berth, values):
    """Speed after over speed before; nan if the mass does not come back."""
    _, log = berth.run(f"impact-{next(impacts)}", "ess", values)
    running = log.tick["state"] == 2
    x = log.tick["manipulator_position_m"][running]
    v = log.tick["manipulator_velocity_m_per_s"][running]
    hit = np.argmax(x > 0)
    back = np.flatnonzero((x < -1e-3) & (np.arange(len(x)) > hit))
    log.path.unlink()
    return -v[back[0]] / v[hit - 1] if len(back) else np.nan


def models(values, method, arguments):
    """The prediction's model: the wall, or one whose stiffness or dead time is off either way."""
    if "prediction.enabled" not in METHODS[method]:
        return [{}]
    wrong = [{key: values[of] * (1 + sign * share)}
             for key, of, share in (("prediction.stiffness_N_per_m", "object.stiffness_N_per_m", arguments.stiffness),
                                    ("prediction.dead_time_ms", "robot.dead_time_ms", arguments.dead_time))
             for sign in (-1, 1) if share > 0]
    return wrong or [{}]


def furthest(berth, values, method, damping_ratio, arguments):
    """The restitution furthest from the ideal over seeds and models; nan if a mass did not come back."""
    seeds = range(1, 1 + (arguments.seeds if arguments.noise > 0 else 1))
    found = [restitution(berth, values | settings_of(method, values) | model | {"run.seed": seed})
             for model in models(values, method, arguments) for seed in seeds]
    return max(found, key=lambda value: np.inf if np.isnan(value) else abs(value - ideal(damping_ratio)))


def print_by_phase(berth, arguments, pool):
    print(f"{'damping':>8}{'w0 tau':>8}{'ideal':>8}" + "".join(f"{name:>17}" for name in arguments.method))
    for damping_ratio in DAMPING_RATIOS:
        for phase in PHASES:
            values = rig(phase, damping_ratio, arguments.noise, 1)
            found = pool.map(lambda method: furthest(berth, values, method, damping_ratio, arguments),
                             arguments.method)
            print(f"{damping_ratio:8.2f}{phase:8.3f}{ideal(damping_ratio):8.4f}"
                  + "".join(f"{value:17.4f}" for value in found), flush=True)


def holds_up_to(errors, tolerance):
    """The largest phase up to which every error is within the tolerance, as text."""
    held = 0
    while held < len(errors) and errors[held] <= tolerance:
        held += 1
    return "-" if held == 0 else f"{LIMIT_PHASES[held - 1]:g}"


def print_limits(berth, arguments, pool):
    print("largest w0 tau of " + ", ".join(f"{phase:g}" for phase in LIMIT_PHASES)
          + "\nup to which the restitution is within " + " / ".join(f"{t:g}" for t in TOLERANCES) + " of the ideal")
    print(f"{'mass':>6}{'wall':>7}{'':>10}{'damping':>9}" + "".join(f"{name:>17}" for name in arguments.method))
    for mass_kg in LIMIT_MASSES_kg:
        for frequency_Hz in LIMIT_FREQUENCIES_Hz:
            for damping_ratio in DAMPING_RATIOS:
                def limit(method):
                    found = [furthest(berth, rig(phase, damping_ratio, arguments.noise, 1, mass_kg, frequency_Hz), method,
                                      damping_ratio, arguments) for phase in LIMIT_PHASES]
                    errors = [np.inf if np.isnan(value) else abs(value - ideal(damping_ratio)) for value in found]
                    return " / ".join(holds_up_to(errors, tolerance) for tolerance in TOLERANCES)
                stiffness = mass_kg * (2 * np.pi * frequency_Hz)**2
                print(f"{mass_kg:6g}{stiffness:12.3g} N/m{damping_ratio:9g}"
                      + "".join(f"{text:>17}" for text in pool.map(limit, arguments.method)), flush=True)


def number(least, most, kind=float):
    def within(text):
        value = kind(text)
        if not least <= value <= most:
            raise argparse.ArgumentTypeError(f"{text} is not from {least:g} to {most:g}")
        return value
    within.__name__ = kind.__name__  # for argparse's message
    return within


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--noise", type=number(0, 1e4), default=8 / 3, help="of the force, N: standard deviation (default 8/3)")
    parser.add_argument("--seeds", type=number(1, 1000, int), default=3, help="runs with noise (default 3)")
    parser.add_argument("--stiffness", type=number(0, 0.99), default=0.0,
                        help="share by which the prediction's stiffness is off, either way (default 0)")
    parser.add_argument("--dead-time", type=number(0, 0.99), default=0.0,
                        help="share by which the prediction's dead time is off, either way (default 0)")
    parser.add_argument("--limits", action="store_true",
                        help="where each method breaks, over masses, stiffnesses and dampings")
    parser.add_argument("--method", action="append", choices=METHODS, help="only this one; may be repeated")
    arguments = parser.parse_args()
    arguments.method = arguments.method or list(METHODS)
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(2) as pool:
        (print_limits if arguments.limits else print_by_phase)(Berth(folder), arguments, pool)


if __name__ == "__main__":
    try:
        main()
    except InputError as error:
        sys.exit(f"restitution.py: {error}")
