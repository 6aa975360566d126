"""Setpoints that are lost before a robot that swings, in the force of an object that it holds: the sensor's noise is a
good part of what they leave. The chain is linear, and is moved here by scipy."""

import json

import numpy as np
import pytest
import scipy.linalg
import scipy.signal
from conftest import EXIT_DONE, command
from gripped_chain import DEAD_TIME_ms, FORCE_NOISE_N, OBJECT, PERIOD_s, RIG, ROWS, SENSOR, STEP_s, STEPS

FREQUENCY_Hz, RATIO = 8.0, 0.5


def chain():
    """From the way asked of the robot: its position and velocity, those of the object, the filtered force and its slope."""
    w, low = 2 * np.pi * FREQUENCY_Hz, 2 * np.pi * SENSOR["low_pass_frequency_Hz"]
    mass, spring = OBJECT["mass_kg"], SENSOR["stiffness_N_per_m"]
    damper = 2 * SENSOR["damping_ratio"] * np.sqrt(spring * mass)
    a, b = np.zeros((6, 6)), np.zeros((6, 1))
    a[0, 1] = a[2, 3] = a[4, 5] = 1.0
    a[1, :2], b[1] = [-w**2, -2 * RATIO * w], w**2
    felt_N = np.array([spring, damper, -spring, -damper])
    a[3, :4] = (felt_N - [0, 0, OBJECT["stiffness_N_per_m"], OBJECT["damping_N_s_per_m"]]) / mass
    a[5, :4] = low**2 * felt_N
    a[5, 4:] = -low**2, -2 * SENSOR["low_pass_damping_ratio"] * low
    return scipy.signal.StateSpace(a, b, np.eye(6)[[0, 4]], np.zeros((2, 1)))


def lossy_record(path, seed, lost_share):
    rng = np.random.default_rng(seed)
    goals_m = np.repeat(rng.uniform(-0.03, 0.03, ROWS // 200), 200)
    sent_m = scipy.signal.lfilter(*scipy.signal.butter(3, 1.5, fs=1 / PERIOD_s), goals_m)
    taken_m, is_lost = sent_m.copy(), rng.random(ROWS) < lost_share
    for n in np.flatnonzero(is_lost[1:]) + 1:
        taken_m[n] = taken_m[n - 1]
    t_s, fine_s = PERIOD_s * np.arange(ROWS), STEP_s * np.arange(ROWS * STEPS)
    asked_m = np.interp(fine_s - 1e-3 * DEAD_TIME_ms, t_s, taken_m)
    moved = scipy.signal.lsim(chain(), asked_m, fine_s)[1]
    robot_m = moved[::STEPS, 0] + 5e-6 * rng.standard_normal(ROWS)
    force_N = np.interp(t_s - 1e-3 * SENSOR["delay_ms"], fine_s, moved[:, 1]) + FORCE_NOISE_N * rng.standard_normal(ROWS)
    np.savetxt(path, np.column_stack([t_s, sent_m, robot_m, force_N]), delimiter=",", comments="", fmt="%.12g",
               header="t_s,command_position_m,robot_position_m,force_N")
    return np.mean(is_lost)


def diagnosed(tmp_path, seed, lost_share):
    """What is told, and the share of setpoints that were lost."""
    print(f"seed {seed}; again: pytest tests/python/test_losses_behind_resonance.py -k '{seed}'")
    share = lossy_record(tmp_path / "record.csv", seed, lost_share)
    (tmp_path / "rig.toml").write_text(RIG)
    done = command("diagnose", tmp_path / "record.csv", "--rig", tmp_path / "rig.toml", "--out", tmp_path / "out")
    assert done.returncode == EXIT_DONE, done.stderr.decode()
    return json.loads((tmp_path / "out" / "diagnosis.json").read_text()), share


@pytest.mark.parametrize("seed, lost_share", [(21, 0.0), (22, 0.02), (23, 0.02)])
@pytest.mark.first(1)
def test_losses_and_resonance_are_both_named(tmp_path, seed, lost_share):
    told, share = diagnosed(tmp_path, seed, lost_share)
    values = {cause["effect"]: cause["parameters"] for cause in told["causes"]}
    assert told["verdict"] == "named", [block["doubts"] for block in told["blocks"]]
    assert sorted(values) == ["robot.lost_commands"] * (lost_share > 0.0) + ["robot.resonance"]
    assert values["robot.resonance"][0]["value"] == pytest.approx(FREQUENCY_Hz, rel=0.005)
    if lost_share > 0.0:
        low, high = values["robot.lost_commands"][0]["ci95"]
        assert low < share < high
        assert told["residual"]["force_N"]["fit"]["after"] < 1.5 * FORCE_NOISE_N


@pytest.mark.slow
def test_of_many_losses_behind_it_no_share_is_told_without_a_doubt(tmp_path):
    """A loss in twenty rings into the next ones, and not all are told from each other."""
    told, share = diagnosed(tmp_path, 24, 0.05)
    causes = {cause["effect"]: cause["parameters"] for cause in told["causes"]}
    assert "robot.resonance" in causes
    low, high = causes["robot.lost_commands"][0]["ci95"] if "robot.lost_commands" in causes else (0.0, 0.0)
    assert low < share < high or told["verdict"] == "partly_explained", (share, low, high)
