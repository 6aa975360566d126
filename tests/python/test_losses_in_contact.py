"""Setpoints that are lost before a soft contact, which feels few of them: their share is told as it is. The contact is
integrated here, exactly between the rows of a fine grid, by other means than the project's."""

import json
import tomllib

import numpy as np
import pytest
import scipy.linalg
import scipy.signal
from conftest import EXIT_DONE, RIG_FOLDER, command

PERIOD_s = 0.0025
STEPS = 20  # of a period
STEP_s = PERIOD_s / STEPS
ROWS = 12000
NOISE_N = 0.2
FOAM = tomllib.loads((RIG_FOLDER / "concept-foam.toml").read_text())


def strides(rows, rng, reach_m=0.01):
    """A smooth way between goals on both sides of the surface: for half of it there is no contact."""
    goal_m = np.empty(rows)
    n = 0
    while n < rows:
        more = int(rng.uniform(0.4, 1.2) / PERIOD_s)
        goal_m[n:n + more] = rng.uniform(-reach_m, reach_m)
        n += more
    wide = 2 * np.pi * 2.0
    way = scipy.signal.StateSpace([[0, 1], [-wide**2, -0.8 * wide]], [[0], [wide**2]], [[1, 0]], [[0]])
    return scipy.signal.lsim(way, goal_m, PERIOD_s * np.arange(rows))[1]


def step_matrices(is_touching):
    """Of position and velocity of the tool, force behind the low pass and its slope; the robot moves evenly."""
    sensor, foam = FOAM["sensor"], FOAM["object"]
    mass = foam["mass_kg"]
    spring, damper = sensor["stiffness_N_per_m"], 2 * sensor["damping_ratio"] * np.sqrt(
        sensor["stiffness_N_per_m"] * mass)
    stiffness, damping = (foam["stiffness_N_per_m"], foam["damping_N_s_per_m"]) if is_touching else (0.0, 0.0)
    low = 2 * np.pi * sensor["low_pass_frequency_Hz"]
    whole = np.zeros((6, 6))  # with the robot's position and velocity
    whole[0, 1] = whole[2, 3] = whole[4, 5] = 1.0
    whole[1] = np.array([-spring - stiffness, -damper - damping, 0.0, 0.0, spring, damper]) / mass
    whole[3] = [-low**2 * spring, -low**2 * damper, -low**2, -2 * sensor["low_pass_damping_ratio"] * low,
                low**2 * spring, low**2 * damper]
    made = scipy.linalg.expm(STEP_s * whole)[:4]
    return made[:, :4], made[:, 4:]


def force_on(robot_m):
    """In each step; free where the foam would have to pull."""
    foam = FOAM["object"]
    free, touching = step_matrices(False), step_matrices(True)
    state, made_N = np.array([robot_m[0], 0.0, 0.0, 0.0]), np.empty(len(robot_m))
    velocity_m_per_s = np.append(np.diff(robot_m), 0.0) / STEP_s
    for n, drive in enumerate(np.column_stack([robot_m, velocity_m_per_s])):
        made_N[n] = state[2]
        depth_m = state[0] - foam["surface_position_m"]
        is_touching = depth_m > 0.0 and foam["stiffness_N_per_m"] * depth_m + foam["damping_N_s_per_m"] * state[1] > 0.0
        own, driven = touching if is_touching else free
        state = own @ state + driven @ drive
    return made_N


def robot_on(setpoint_m, lag_ms):
    """Its way in each step, behind its dead time and a lag of first order."""
    t_s = PERIOD_s * np.arange(len(setpoint_m))
    fine_s = STEP_s * np.arange(len(setpoint_m) * STEPS)
    robot_m = np.interp(fine_s - 1e-3 * FOAM["robot"]["dead_time_ms"], t_s, setpoint_m)
    if lag_ms > 0.0:
        keeps = np.exp(-STEP_s / (1e-3 * lag_ms))
        robot_m = scipy.signal.lfilter([1 - keeps], [1, -keeps], robot_m, zi=[keeps * robot_m[0]])[0]
    return robot_m


def measured(robot_m):
    """The force in each row, without noise."""
    t_s = STEP_s * np.arange(len(robot_m))
    return np.interp(t_s[::STEPS] - 1e-3 * FOAM["sensor"]["delay_ms"], t_s, force_on(robot_m))


def lossy_record(path, seed, lost_share, lag_ms, rows=ROWS, force_step_N=0.0):
    """Writes it. The share of setpoints that are lost, the mean square [N2] of what that does to the force, and its
    share of the error of the robot as given, which has no lag."""
    rng = np.random.default_rng(seed)
    sent_m = strides(rows, rng)
    taken_m = sent_m.copy()
    is_lost = rng.random(rows) < lost_share
    for n in np.flatnonzero(is_lost[1:]) + 1:
        taken_m[n] = taken_m[n - 1]
    t_s = PERIOD_s * np.arange(rows)
    robot_m, loses_none_m = robot_on(taken_m, lag_ms), robot_on(sent_m, lag_ms)
    exact_N = measured(robot_m)
    force_N = exact_N + NOISE_N * rng.standard_normal(rows)
    if force_step_N > 0.0:
        force_N = force_step_N * np.round(force_N / force_step_N)
    columns = {"t_s": t_s, "command_position_m": sent_m,
               "robot_position_m": robot_m[::STEPS] + 5e-6 * rng.standard_normal(rows), "force_N": force_N}
    np.savetxt(path, np.column_stack(list(columns.values())), delimiter=",", header=",".join(columns), comments="",
               fmt="%.12g")
    made_N2 = np.mean((exact_N - measured(loses_none_m)) ** 2)
    made_m2, as_given_m2 = (np.mean((robot_m - other_m)[::STEPS] ** 2) for other_m in
                            (loses_none_m, robot_on(sent_m, 0.0)))
    return np.mean(is_lost), made_N2, made_m2 / as_given_m2 if made_m2 > 0.0 else 0.0


def told_of(tmp_path, seed, lost_share, lag_ms, **more):
    print(f"seed {seed}; again: pytest tests/python/test_losses_in_contact.py -k '{seed}'")
    truth = lossy_record(tmp_path / "record.csv", seed, lost_share, lag_ms, **more)
    done = command("diagnose", tmp_path / "record.csv", "--rig", "concept-foam", "--out", tmp_path / "out")
    assert done.returncode == EXIT_DONE, done.stderr.decode()
    told = json.loads((tmp_path / "out" / "diagnosis.json").read_text())
    values = {cause["effect"]: cause["parameters"][0] for cause in told["causes"]}
    return truth, told, values


def test_nothing_is_lost(tmp_path):
    _, told, _ = told_of(tmp_path, 1, 0.0, 0.0)
    assert told["verdict"] == "nothing_detectable", told["causes"]


def test_of_rounding_no_share_is_told(tmp_path):
    """No replay tells what it does: the next row is rounded as it comes."""
    _, told, _ = told_of(tmp_path, 2, 0.0, 0.0, force_step_N=1.0)
    [cause] = told["causes"]
    assert cause["effect"] == "sensor.quantisation" and cause["share_explained"] is None


@pytest.mark.parametrize("lost_share, lag_ms", [(0.02, 0.0), (0.08, 0.0), (0.02, 10.0), (0.05, 10.0)])
@pytest.mark.parametrize("seed", [11, 12])
@pytest.mark.first(3)
def test_the_share_that_is_lost_is_told(tmp_path, seed, lost_share, lag_ms):
    (share, made_N2, of_robot), told, values = told_of(tmp_path, seed, lost_share, lag_ms)
    if lost_share < 0.06:
        assert told["verdict"] == "named", told["verdict"]
        assert sorted(values) == sorted(["robot.lost_commands"] + ["robot.lag"] * (lag_ms > 0.0))
    else:  # the smallest of so many are not found, and something small may stand in for them, which is said
        robot = next(block for block in told["blocks"] if block["block"] == "robot")
        assert told["verdict"] == "named" or robot["doubts"], told["verdict"]
    [loss] = [cause for cause in told["causes"] if cause["effect"] == "robot.lost_commands"]
    explained = loss["share_explained"]
    if loss["shown_by"] == "robot":
        assert abs(explained - of_robot) < 0.05, of_robot
    else:  # below the noise of its reports
        rms = told["residual"]["force_N"]["fit"]
        told_N2 = explained * (rms["before"]**2 - rms["floor"]**2)
        by_noise_N2 = 2 * NOISE_N * np.sqrt(made_N2 / ROWS)
        assert abs(told_N2 - made_N2) < 0.15 * made_N2 + 3 * by_noise_N2, (explained, told_N2, made_N2)
    low, high = values["robot.lost_commands"]["ci95"]
    middle, half = (low + high) / 2, (high - low) / 2
    assert abs(middle - share) < 1.5 * half, (low, high, share)  # a draw in 300 is further off
    assert half < max(share, 0.01), (low, high)
    if lag_ms > 0.0:
        low, high = values["robot.lag"]["ci95"]
        assert low - (high - low) < lag_ms < high + (high - low)
