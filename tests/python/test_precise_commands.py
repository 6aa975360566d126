"""`berth diagnose` on commands that were written with many digits: what is left of them is rounding. The records are made
here, by scipy."""

import json

import numpy as np
import pytest
from conftest import EXIT_DONE, command
from scipy.integrate import solve_ivp

PERIOD_s = 0.0025
ROWS = 4000
GIVEN = {"mass_kg": 200.0, "damping_N_s_per_m": 125.0, "stiffness_N_per_m": 7900.0}
LAWS = {  # further force against the motion, N, of the way off the goal and of velocity
    "nothing": lambda x, v: 0.0,
    "manipulator.asymmetric_friction": lambda x, v: 20.0 * abs(v),
    "manipulator.cubic_stiffness": lambda x, v: 2e6 * x**3,
    "manipulator.quadratic_stiffness": lambda x, v: 5e4 * x**2,
}
VALUES = {"manipulator.asymmetric_friction": 20.0, "manipulator.cubic_stiffness": 2e6,
          "manipulator.quadratic_stiffness": 5e4}


FRICTION_N = 6.0


def with_dry_friction_m(push_N):
    """Each row from where the one before ended; where it stops, it sticks while the friction holds the rest, else it
    goes on the other way."""
    m, d, k = (1.02 * GIVEN[key] for key in GIVEN)

    def stops(_, y):
        return y[1]

    stops.terminal = True
    state, path_m = np.zeros(2), []
    for push in push_N:
        path_m.append(state[0])
        left_s = PERIOD_s
        while left_s > 0.0:
            rest_N = push - k * state[0]
            if state[1] == 0.0 and abs(rest_N) <= FRICTION_N:
                break
            way = np.sign(state[1]) or np.sign(rest_N)
            stops.direction = -way
            part = solve_ivp(lambda _, y, push=push, way=way: [y[1], (push - d * y[1] - k * y[0] - way * FRICTION_N) / m],
                             (0.0, left_s), state, method="DOP853", rtol=1e-12, atol=1e-15, events=stops)
            state, left_s = part.y[:, -1], left_s - part.t[-1]
            if part.status == 1:
                state[1] = 0.0
            else:
                left_s = 0.0
    return np.array(path_m)


def motion_m(law, push_N, scale, goal_m=None):
    """Each row from where the one before ended, the push held over it; the law is of what is off the goal."""
    m, d, k = (scale * GIVEN[key] for key in GIVEN)
    state, path_m = np.zeros(2), []
    for push, goal in zip(push_N, np.zeros(len(push_N)) if goal_m is None else goal_m):
        path_m.append(state[0])
        state = solve_ivp(lambda _, y, push=push, goal=goal: [
            y[1], (push - d * y[1] - k * y[0] - law(y[0] - goal, y[1])) / m],
            (0.0, PERIOD_s), state, method="DOP853", rtol=1e-12, atol=1e-15).y[:, -1]
    return np.array(path_m)


def swaying_N(seed):
    t_s = np.arange(ROWS) * PERIOD_s
    return sum(30.0 * np.sin(2 * np.pi * f * t_s + p) for f, p in zip(
        (0.31, 0.73, 1.13, 1.97), np.random.default_rng(seed).uniform(0, 2 * np.pi, 4)))


def write_record(folder, **columns):
    columns = {"t_s": np.arange(ROWS) * PERIOD_s} | columns
    np.savetxt(folder / "record.csv", np.column_stack(list(columns.values())), delimiter=",", comments="",
               header=",".join(columns), fmt="%.13g")


def told_of_record(folder, more=""):
    """`more`: of the rig file."""
    rig = folder / "rig.toml"
    rig.write_text('name = "precise"\n[manipulator]\n' + "".join(
        f"{key} = {{ value = {value}, tolerance = 0.05 }}\n" for key, value in GIVEN.items()) + more)
    done = command("diagnose", folder / "record.csv", "--rig", rig, "--out", folder / "out")
    assert done.returncode == EXIT_DONE, done.stderr.decode()
    return json.loads((folder / "out" / "diagnosis.json").read_text())


def diagnosed(tmp_path, moved_m, step_m, seed=3, more=""):
    """`moved_m`: of the push, N, one a row; `step_m`: of the command, none: 13 digits; `more`: of the rig file."""
    push_N = swaying_N(seed)
    command_m = moved_m(push_N)
    if step_m is not None:
        command_m = np.round(command_m / step_m) * step_m
    write_record(tmp_path, operator_force_N=push_N, command_position_m=command_m)
    return told_of_record(tmp_path, more)


@pytest.mark.parametrize("scale", [1.0, 0.97, 1.03])
def test_a_mass_within_its_tolerance_leaves_rounding_alone(tmp_path, scale):
    """The floor that was estimated beside the rig as given is far above what is left of the one that fits."""
    step_m = 1e-11
    found = diagnosed(tmp_path, lambda push_N: motion_m(LAWS["nothing"], push_N, scale), step_m)
    assert found["verdict"] == "nothing_detectable", found["blocks"][0]["doubts"]
    told = found["residual"]["command_position_m"]["fit"]
    assert told["floor"] == pytest.approx(step_m / np.sqrt(12.0), rel=0.1)
    assert told["retuned"] == pytest.approx(told["floor"], rel=0.1)


@pytest.mark.parametrize("effect", VALUES)
def test_a_smooth_cause_is_named_and_its_interval_holds(tmp_path, effect):
    found = diagnosed(tmp_path, lambda push_N: motion_m(LAWS[effect], push_N, 1.02), 1e-9)
    assert found["verdict"] == "named", found["blocks"][0]["doubts"]
    assert [cause["effect"] for cause in found["causes"]] == [effect]
    told = found["causes"][0]["parameters"][0]
    low, high = told["ci95"]
    assert low < VALUES[effect] < high, told
    assert high - low < 1e-3 * VALUES[effect]


SMALL = {  # forces of a ten thousandth of the push and less
    "manipulator.gravity_offset": (lambda x, v: -5e-3, -5e-3),
    "manipulator.asymmetric_friction": (lambda x, v: 2e-2 * abs(v), 2e-2),
    "manipulator.cubic_stiffness": (lambda x, v: 5e2 * x**3, 5e2),
    "manipulator.quadratic_stiffness": (lambda x, v: 10.0 * x**2, 10.0),
}


@pytest.mark.parametrize("effect", SMALL)
def test_a_cause_that_is_less_than_a_regression_errs_is_named(tmp_path, effect):
    """An operator's motion, held over the tick, as the regression takes it to be only nearly."""
    law, value = SMALL[effect]
    t_s = np.arange(ROWS) * PERIOD_s
    lines_rad_per_s = 2 * np.pi * np.array([0.31, 0.73, 1.13, 1.97])
    operator_m = sum(0.004 * (np.cos(w * t_s) - 1.0) for w in lines_rad_per_s)
    operator_m_per_s = sum(-0.004 * w * np.sin(w * t_s) for w in lines_rad_per_s)
    push_N = GIVEN["stiffness_N_per_m"] * operator_m + GIVEN["damping_N_s_per_m"] * operator_m_per_s
    write_record(tmp_path, operator_position_m=operator_m, operator_velocity_m_per_s=operator_m_per_s,
                 command_position_m=motion_m(law, push_N, 1.0, operator_m))
    found = told_of_record(tmp_path)
    assert found["verdict"] == "named", found["blocks"][0]["doubts"]
    assert [cause["effect"] for cause in found["causes"]] == [effect]
    told = found["causes"][0]["parameters"][0]
    low, high = sorted(told["ci95"], key=abs)
    assert abs(low) < abs(value) < abs(high) < 1.02 * abs(low), told


@pytest.mark.parametrize("seed", [3, 4, 5])
@pytest.mark.first(1)
def test_dry_friction_is_named_although_it_catches_between_steps(tmp_path, seed):
    found = diagnosed(tmp_path, with_dry_friction_m, 1e-9, seed)
    assert found["verdict"] == "named", found["blocks"][0]["doubts"]
    assert [cause["effect"] for cause in found["causes"]] == ["manipulator.coulomb_friction"]
    told = found["causes"][0]["parameters"][0]
    low, high = told["ci95"]
    assert low < FRICTION_N < high, told
    assert high - low < 2e-3 * FRICTION_N


def test_dry_friction_that_the_rig_knows_is_no_unknown(tmp_path):
    found = diagnosed(tmp_path, with_dry_friction_m, None, more=f"coulomb_friction_N = {FRICTION_N}\n")
    assert found["verdict"] == "nothing_detectable", found["blocks"][0]["doubts"]


@pytest.mark.parametrize("seed", [4, 5])
@pytest.mark.first(1)
def test_its_instants_within_steps_leave_less_than_a_ten_thousandth_of_what_it_moves(tmp_path, seed):
    rough = diagnosed(tmp_path, with_dry_friction_m, None, seed)["residual"]["command_position_m"]["fit"]
    known = diagnosed(tmp_path, with_dry_friction_m, None, seed, f"coulomb_friction_N = {FRICTION_N}\n")
    left = known["residual"]["command_position_m"]["fit"]
    print(rough, left)
    assert known["verdict"] == "nothing_detectable", known["blocks"][0]["doubts"]
    assert left["after"] < 1e-4 * rough["retuned"]
