"""A robot that holds an object with a stiff sensor between: a linear chain, moved by scipy, and what `berth diagnose`
tells of its record."""

import json

import numpy as np
import scipy.signal
from conftest import EXIT_DONE, command

PERIOD_s, STEPS, ROWS = 0.0025, 20, 8000
STEP_s = PERIOD_s / STEPS
DEAD_TIME_ms, FORCE_NOISE_N = 10.0, 0.2
SENSOR = {"stiffness_N_per_m": 4e5, "damping_ratio": 0.03, "low_pass_order": 2, "low_pass_frequency_Hz": 60.0,
          "low_pass_damping_ratio": 0.7, "delay_ms": 5.0}
OBJECT = {"mass_kg": 12.0, "stiffness_N_per_m": 3500.0, "damping_N_s_per_m": 25.0}
RIG = f"""
name = "chain"
[robot]
dead_time_ms = {DEAD_TIME_ms}
interpolation = "linear"
[sensor]
""" + "".join(f"{key} = {value}\n" for key, value in SENSOR.items()) + """
[object]
kind = "gripped"
surface_position_m = 0.0
""" + "".join(f"{key} = {value}\n" for key, value in OBJECT.items())


def chain(mass_kg, damping_N_s_per_m, stiffness_N_per_m):
    """From the robot's position and velocity: those of the object, the filtered force and its slope."""
    low, spring = 2 * np.pi * SENSOR["low_pass_frequency_Hz"], SENSOR["stiffness_N_per_m"]
    damper = 2 * SENSOR["damping_ratio"] * np.sqrt(spring * mass_kg)
    a, b = np.zeros((4, 4)), np.zeros((4, 2))
    a[0, 1] = a[2, 3] = 1.0
    a[1, :2] = -(spring + stiffness_N_per_m) / mass_kg, -(damper + damping_N_s_per_m) / mass_kg
    b[1] = spring / mass_kg, damper / mass_kg
    a[3] = -low**2 * spring, -low**2 * damper, -low**2, -2 * SENSOR["low_pass_damping_ratio"] * low
    b[3] = low**2 * spring, low**2 * damper
    return scipy.signal.StateSpace(a, b, np.eye(4)[[2]], np.zeros((1, 2)))


def chirp():
    return 0.01 * scipy.signal.chirp(PERIOD_s * np.arange(ROWS), 0.1, PERIOD_s * ROWS, 5.0, phi=-90)


def diagnosed(folder, rng, sent_m, dead_time_ms, keep=slice(None), command_step_m=1e-12, read=lambda force_N: force_N):
    """What is told of a record with these setpoints, written in such steps, and this dead time; of its rows only some
    are kept. `read`: what a sensor makes of the force."""
    t_s, fine_s = PERIOD_s * np.arange(ROWS), STEP_s * np.arange(ROWS * STEPS)
    moved_m = np.interp(fine_s - 1e-3 * dead_time_ms, t_s, sent_m)
    mass, spring, damper = (value * (1.0 + 0.02 * rng.uniform(-1.0, 1.0)) for value in OBJECT.values())
    ways = np.column_stack([moved_m, np.gradient(moved_m, fine_s)])
    felt_N = scipy.signal.lsim(chain(mass, damper, spring), ways, fine_s)[1]
    robot_m = moved_m[::STEPS] + 5e-6 * rng.standard_normal(ROWS)
    force_N = np.interp(t_s - 1e-3 * SENSOR["delay_ms"], fine_s, felt_N) + FORCE_NOISE_N * rng.standard_normal(ROWS)
    written_m = command_step_m * np.round(sent_m / command_step_m)
    np.savetxt(folder / "record.csv", np.column_stack([t_s, written_m, robot_m, read(force_N)])[keep], delimiter=",",
               comments="", fmt="%.12g", header="t_s,command_position_m,robot_position_m,force_N")
    (folder / "rig.toml").write_text(RIG)
    done = command("diagnose", folder / "record.csv", "--rig", folder / "rig.toml", "--out", folder / "out")
    assert done.returncode == EXIT_DONE, done.stderr.decode()
    return json.loads((folder / "out" / "diagnosis.json").read_text())
