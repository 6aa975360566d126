"""An object that relaxes, as rubber does, is to its force what a sensor that lags is before another damping and mass: of
such a record neither is named. The force is made here, by the transfer functions of both."""

import json

import numpy as np
import pytest
import scipy.signal
from conftest import EXIT_DONE, command

PERIOD_s = 0.0025
STEPS = 10  # of a period
NOISE_N = 0.05
DEAD_TIME_s, DELAY_s, LOW_PASS_Hz = 0.012, 0.0025, 60.0
RIG = """
name = "touch"
[loop]
rate_Hz = 400
[robot]
dead_time_ms = 12.0
interpolation = "linear"
[sensor]
stiffness_N_per_m = 2e7
damping_ratio = 0.05
low_pass_order = 1
low_pass_frequency_Hz = 60.0
delay_ms = 2.5
[object]
kind = "gripped"
mass_kg = {{ value = 0.001, tolerance = 0.08 }}
stiffness_N_per_m = {{ value = {stiffness_N_per_m}, tolerance = 0.08 }}
damping_N_s_per_m = {{ value = {damping_N_s_per_m}, tolerance = 0.15 }}
surface_position_m = 0.0
[bus]
ideal = true
"""


def told_of(tmp_path, seed, object_and_sensor, **given):
    """What is told of a force that this transfer function (numerator, denominator) makes of the robot's motion."""
    print(f"seed {seed}; again: pytest tests/python/test_relaxing_objects.py -k '{seed}'")
    rng = np.random.default_rng(seed)
    t_s = PERIOD_s * np.arange(8000)
    lines_Hz = np.linspace(0.1, 3.0, 25)
    command_m = sum(np.sin(2 * np.pi * f * t_s + rng.uniform(0, 2 * np.pi)) for f in lines_Hz)
    command_m *= 0.004 / np.max(np.abs(command_m)) * np.clip(t_s, 0.0, 1.0)
    fine_s = PERIOD_s / STEPS * np.arange(len(t_s) * STEPS)
    robot_m = np.interp(fine_s - DEAD_TIME_s, t_s, command_m)
    numerator, denominator = object_and_sensor
    low_pass = [1.0 / (2 * np.pi * LOW_PASS_Hz), 1.0]
    _, force_N, _ = scipy.signal.lsim((numerator, np.polymul(denominator, low_pass)), robot_m, fine_s)
    columns = {"t_s": t_s, "command_position_m": command_m,
               "robot_position_m": robot_m[::STEPS] + 2e-6 * rng.standard_normal(len(t_s)),
               "force_N": np.interp(t_s - DELAY_s, fine_s, force_N) + NOISE_N * rng.standard_normal(len(t_s))}
    np.savetxt(tmp_path / "record.csv", np.column_stack(list(columns.values())), delimiter=",",
               header=",".join(columns), comments="", fmt="%.12g")
    (tmp_path / "rig.toml").write_text(RIG.format(**given))
    done = command("diagnose", tmp_path / "record.csv", "--rig", tmp_path / "rig.toml", "--out", tmp_path / "out")
    assert done.returncode == EXIT_DONE, done.stderr.decode()
    return json.loads((tmp_path / "out" / "diagnosis.json").read_text())


def relaxing(k, d, k1, tau_s):
    """k + d s + k1 tau s / (1 + tau s): a spring and a damper beside a spring and a damper in series."""
    return [d * tau_s, d + (k + k1) * tau_s, k], [tau_s, 1.0]


def lagging(k, d, tau_s):
    """The same spring and damper before a sensor that lags."""
    return [d, k], [tau_s, 1.0]


@pytest.mark.parametrize("seed, k, d, k1, tau_s, given_d", [(3, 6000.0, 20.0, 1500.0, 0.03, 55.0),
                                                            (1, 4000.0, 15.0, 800.0, 0.025, 33.0),
                                                            (2, 6000.0, 20.0, 600.0, 0.05, 45.0)])
@pytest.mark.first(1)
def test_an_object_that_relaxes_is_not_named(tmp_path, seed, k, d, k1, tau_s, given_d):
    told = told_of(tmp_path, seed, relaxing(k, d, k1, tau_s), stiffness_N_per_m=1.03 * k, damping_N_s_per_m=given_d)
    assert told["verdict"] in ("partly_explained", "unknown", "one_of"), told["causes"]


@pytest.mark.parametrize("seed, tau_s", [(4, 0.012), (5, 0.03)])
@pytest.mark.first(1)
def test_a_sensor_that_lags_is(tmp_path, seed, tau_s):
    told = told_of(tmp_path, seed, lagging(4000.0, 35.0, tau_s), stiffness_N_per_m=4100.0, damping_N_s_per_m=33.0)
    assert told["verdict"] == "named" and [cause["effect"] for cause in told["causes"]] == ["sensor.lag"]


def test_a_sensor_that_lags_is_before_another_damping_too(tmp_path):
    told = told_of(tmp_path, 6, lagging(4000.0, 80.0, 0.03), stiffness_N_per_m=4100.0, damping_N_s_per_m=33.0)
    assert told["verdict"] == "named"
    assert sorted(cause["effect"] for cause in told["causes"]) == ["object.parameters", "sensor.lag"]
