#!/usr/bin/env python3
"""A simulated free mass of 300 kg hits a real wall that is displayed through dead time: how much of its speed it
comes back with, by compensation, beside what it would be without dead time. Li et al. (J. Aerosp. Eng. 2026) published
3 Hz and 3 ms, w0 tau = 0.057: 1.0892 without compensation, 1.0218 with a hybrid Smith predictor, 0.9987 with an
observer; ideal 1.

  restitution.py [--noise N] [--seeds COUNT] [--stiffness SHARE]
"""
import argparse
import sys
import tempfile

import numpy as np

from berth_log import InputError
from berth_program import Berth

MASS_kg = 300.0
W0_rad_per_s = 2 * np.pi * 3
SPEED_m_per_s = 0.1
FORCE_DELAY_ms = 0.5
PERIOD_ms = 0.5
PHASES = (0.04, 0.057, 0.1, 0.2, 0.3, 0.45, 0.6)  # w0 tau
PREDICTION = {"prediction.enabled": "true"}
METHODS = {
    "none": {},
    "prediction": PREDICTION,
    "identification": PREDICTION | {"identification.enabled": "true"},
    "extrapolation-1": {"extrapolation.order": 1},
    "extrapolation-2": {"extrapolation.order": 2},
    "extrapolation-3": {"extrapolation.order": 3},
    "passivity": {"passivity.action": "damping", "passivity.credit_J": 0.02, "passivity.horizon_ms": 10},
}


def ideal(damping_ratio):
    """The wall pushes and never pulls: it lets go where k x + d v = 0, at a phase of atan2(2 z s, 2 z^2 - 1)."""
    if damping_ratio == 0:
        return 1.0
    s = np.sqrt(1 - damping_ratio**2)
    return np.exp(-damping_ratio / s * np.arctan2(2 * damping_ratio * s, 2 * damping_ratio**2 - 1))


def rig(phase, damping_ratio, noise_N, seed):
    """A loop of 2 kHz with `phase` / w0 of delay in all: robot, force, and half a period that the force is held."""
    dead_time_ms = 1e3 * phase / W0_rad_per_s - FORCE_DELAY_ms - PERIOD_ms / 2
    return {
        "loop.rate_Hz": 1e3 / PERIOD_ms, "bus.ideal": "true", "run.duration_s": 1.2, "run.release_s": 0.01,
        "manipulator.mass_kg": MASS_kg, "manipulator.stiffness_N_per_m": 0, "manipulator.damping_N_s_per_m": 0,
        "manipulator.initial_position_m": -0.005, "manipulator.initial_velocity_m_per_s": SPEED_m_per_s,
        "limits.acceleration_m_per_s2": 1e7, "limits.velocity_m_per_s": 100,
        "run.seed": seed, "robot.dead_time_ms": dead_time_ms,
        "sensor.delay_ms": FORCE_DELAY_ms, "sensor.stiffness_N_per_m": 1e8, "sensor.damping_ratio": 0.7,
        "sensor.low_pass_order": 0, "sensor.noise_N": noise_N, "object.kind": "contact", "object.mass_kg": 0.1,
        "object.stiffness_N_per_m": MASS_kg * W0_rad_per_s**2,
        "object.damping_N_s_per_m": 2 * damping_ratio * MASS_kg * W0_rad_per_s,
    }


def restitution(berth, values):
    """Speed after over speed before; nan if the mass does not come back."""
    _, log = berth.run("impact", "ess", values)
    running = log.tick["state"] == 2
    x = log.tick["manipulator_position_m"][running]
    v = log.tick["manipulator_velocity_m_per_s"][running]
    hit = np.argmax(x > 0)
    back = np.flatnonzero((x < -1e-3) & (np.arange(len(x)) > hit))
    return -v[back[0]] / v[hit - 1] if len(back) else np.nan


def worst(berth, values, method, arguments):
    """The restitution furthest from the ideal over seeds, and over models whose stiffness is off either way."""
    stiffness = values["object.stiffness_N_per_m"]
    models = [{}]
    if "prediction.enabled" in METHODS[method] and arguments.stiffness > 0:
        models = [{"prediction.stiffness_N_per_m": stiffness * (1 + s)}
                  for s in (-arguments.stiffness, arguments.stiffness)]
    seeds = range(1, 1 + (arguments.seeds if arguments.noise > 0 else 1))
    return [restitution(berth, values | METHODS[method] | model | {"run.seed": seed})
            for model in models for seed in seeds]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--noise", type=float, default=8 / 3, help="of the force, N: standard deviation (default 8/3)")
    parser.add_argument("--seeds", type=int, default=3, help="runs with noise (default 3)")
    parser.add_argument("--stiffness", type=float, default=0.0,
                        help="share by which the prediction's stiffness is off, either way (default 0)")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        berth = Berth(folder)
        print(f"{'damping':>8}{'w0 tau':>8}{'ideal':>8}" + "".join(f"{name:>17}" for name in METHODS))
        for damping_ratio in (0.0, 0.1):
            for phase in PHASES:
                values = rig(phase, damping_ratio, arguments.noise, 1)
                goal = ideal(damping_ratio)
                row = f"{damping_ratio:8.2f}{phase:8.3f}{goal:8.4f}"
                for method in METHODS:
                    found = worst(berth, values, method, arguments)
                    row += f"{max(found, key=lambda value: abs(value - goal)):17.4f}"
                print(row, flush=True)


if __name__ == "__main__":
    try:
        main()
    except InputError as error:
        sys.exit(f"restitution.py: {error}")
