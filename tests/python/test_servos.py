"""`berth diagnose` on position servos as the robot: dead time, lag and a limit of the speed are behind each other, and one
stands in for the other until all are there."""

import gzip

import numba
import numpy as np
import pytest
import scipy.optimize
import scipy.signal
from test_diagnosis import diagnose, measured, values, write

# A hobby servo as the robot; its angle in half turns is displayed as metres. It goes to a command as soon as that is
# there: nothing interpolates.
SERVO = """
name = "servo"
[loop]
rate_Hz = 50
[robot]
dead_time_ms = 20.0
interpolation = "hold"
[sensor]
delay_ms = 20.0
[signals]
command_position_m = "command_halfturn"
robot_position_m = "real_angle_halfturn"
segment = "rollout"
"""


def test_speed_limit_of_a_real_servo(tmp_path):
    """A servo that cannot follow: named, and flagged as not the whole of it."""
    (record,) = measured("hobby_servo/paired_real_sim.csv.gz")
    rig = tmp_path / "servo.toml"
    rig.write_text(SERVO)
    found = diagnose(tmp_path, record, "--rig", rig)
    assert found["verdict"] == "partly_explained" and found["block"] == "robot"
    assert list(values(found)) == ["robot.velocity_limit", "robot.lag"]
    (limit,) = (p for p in found["causes"][0]["parameters"] if p["name"] == "velocity_limit_m_per_s")
    # 1.52 to 1.55 half turns a second, read from the slopes of the record: data/hobby_servo/PROVENANCE.md
    low, high = limit["ci95"]
    assert low < 1.55 and high > 1.52
    assert limit["value"] == pytest.approx(1.535, rel=0.06)
    assert [rival["effect"] for rival in found["alternatives"]] == ["robot.dead_time"]
    residual = found["residual"]["robot_position_m"]["held_out"]
    assert residual["after"] < 0.12 * residual["before"]


def test_what_diverges_is_no_candidate_for_a_real_servo(tmp_path):
    """A drift of the dead time that its fit had left with a replay without numbers; the report could not be drawn."""
    (record,) = measured("hobby_servo/paired_real_sim.csv.gz")
    rig = tmp_path / "servo.toml"
    rig.write_text(SERVO.replace("real_angle_halfturn", "authors_mujoco_sim_angle_halfturn").replace(
        "[sensor]\ndelay_ms = 20.0\n", ""))
    found = diagnose(tmp_path, record, "--rig", rig)
    tried = [one for block in found["blocks"] for one in block["ranking"]]
    assert len(tried) > 5 and all(np.isfinite([one["delta_bic"], one["share_explained"]]).all() for one in tried)


def test_each_limit_of_a_real_servo_is_found_where_other_rollouts_prove_it(tmp_path):
    """Every other rollout, and those between as another record, as PROVENANCE.md of these data has it: the speed limit,
    the dead time of 20 to 45 ms and a lag, on unseen rollouts nearer to the truth than its authors' own simulation."""
    (record,) = measured("hobby_servo/paired_real_sim.csv.gz")
    header, *rows = gzip.open(record, "rt").read().splitlines()
    paths = []
    for name, turn in (("fit", 0), ("unseen", 1)):
        kept = [row for row in rows if int(row.split(",")[0]) % 2 == turn]
        paths.append(tmp_path / f"{name}.csv")
        paths[-1].write_text("\n".join([header, *kept]) + "\n")
    rig = tmp_path / "servo.toml"
    rig.write_text(SERVO)
    found = diagnose(tmp_path, paths[0], "--validate", paths[1], "--rig", rig)
    assert found["verdict"] == "partly_explained" and found["block"] == "robot"
    assert sorted(values(found)) == ["robot.dead_time", "robot.lag", "robot.velocity_limit"]
    told = {one["name"]: one for cause in found["causes"] for one in cause["parameters"]}
    print(told, found["residual"]["robot_position_m"]["held_out"])
    assert told["velocity_limit_m_per_s"]["value"] == pytest.approx(1.535, rel=0.08)
    low, high = told["dead_time_ms"]["ci95"]
    assert low < 45.0 and high > 20.0
    authors_simulation = 0.0330  # half turns rms on the same rollouts
    assert found["residual"]["robot_position_m"]["held_out"]["after"] < authors_simulation


@numba.njit
def servo(command, parameters, form, deadband, start, parts=10):
    """A position servo by itself, 50 rows a second: dead time, gain and offset, second order within limits of velocity
    and acceleration. Dead band: 1 of commands, 2 the drive rests, 3 the drive sees what is beyond it."""
    dead_time_s, w, damping, velocity_max, acceleration_max, gain, offset = parameters
    step_s = 0.02 / parts
    angle, velocity, held = start, 0.0, gain * command[0] + offset
    angles = np.zeros(len(command))
    for row in range(len(command)):
        angles[row] = angle
        for part in range(parts):
            sent = int(np.floor(((row * parts + part) * step_s - dead_time_s) / 0.02 + 1e-9))
            goal = gain * command[max(sent, 0)] + offset
            if form != 1 or abs(goal - held) > deadband:
                held = goal
            error = held - angle
            if form >= 2:
                beyond = error - np.sign(error) * deadband
                error = 0.0 if abs(error) < deadband else beyond if form == 3 else error
            pull = w * w * error - 2.0 * damping * w * velocity
            velocity += step_s * min(max(pull, -acceleration_max), acceleration_max)
            velocity = min(max(velocity, -velocity_max), velocity_max)
            angle += step_s * velocity
    return angles


@pytest.mark.parametrize("form", [1, 2, 3])
def test_a_dead_band_is_buried_in_what_else_a_real_servo_does(form):
    """Why none is named: a program of its own, with all else that these rollouts show, is off by several times what the
    dead band would do that is read from where the servo comes to rest. Fitted, that predicts unseen rollouts no better;
    put into the data on top, and then known, it explains no share worth a name."""
    (record,) = measured("hobby_servo/paired_real_sim.csv.gz")
    table = np.loadtxt(gzip.open(record, "rt"), delimiter=",", skiprows=1)
    rollouts = [table[table[:, 0] == number] for number in np.unique(table[:, 0])]
    scales, begin = np.array([0.02, 25.0, 1.2, 1.5, 50.0, 1.0, 0.01]), np.array([0.6, 1.0, 1.0, 1.0, 1.0, 1.0, -1.0])
    size = 0.009  # half turns: PROVENANCE.md of these data

    def moved(places, one, form, size):
        return servo(one[:, 2], places * scales, form, size, one[0, 3])

    def errors(places, chosen, form, size):
        return np.concatenate([moved(places, one, form, size) - one[:, 3] for one in chosen])

    def unseen_rms(chosen, form, size, begin):
        places = scipy.optimize.least_squares(errors, begin, args=(chosen[1::2], form, size), diff_step=2e-3).x
        return places, np.sqrt(np.mean(errors(places, chosen[::2], form, size) ** 2))

    places, without = unseen_rms(rollouts, 0, 0.0, begin)
    _, with_it = unseen_rms(rollouts, form, size, places)
    effects = [moved(places, one, form, size) - moved(places, one, 0, 0.0) for one in rollouts]
    effect = np.sqrt(np.mean(np.concatenate(effects) ** 2))
    added = [one.copy() for one in rollouts]
    for one, by in zip(added, effects):
        one[:, 3] += by
    _, ignored = unseen_rms(added, 0, 0.0, places)
    _, known = unseen_rms(added, form, size, places)
    print(f"half turns rms: dead band {effect:.4f}; unseen rollouts {without:.4f} without it, {with_it:.4f} with it; "
          f"with another one put in {ignored:.4f} where it is ignored, {known:.4f} where it is known")
    assert without < 0.0330  # its authors' own simulation, of all rollouts
    assert effect < 0.3 * without
    assert with_it > 0.98 * without
    assert known > 0.98 * ignored


STEPS = """
name = "steps"
[robot]
dead_time_ms = 10.0
interpolation = "hold"
"""


@pytest.mark.parametrize("dead_time_ms, lag_ms", [(30, 120), (40, 80), (20, 60), (50, 200), (100, 500)])
def test_a_lag_behind_a_dead_time_under_steps(tmp_path, dead_time_ms, lag_ms):
    """First order and dead time, what most servos look like: a resonance had stood in for the dead time."""
    rows, period_ms = 800, 10
    t_s = 1e-3 * period_ms * np.arange(rows)
    command_m = np.repeat([0, 1, 0.3, -0.7, 0.5, 0, -1, 0.8], rows // 8)
    late = np.concatenate((np.zeros(dead_time_ms // period_ms), command_m))[:rows]
    keeps = np.exp(-period_ms / lag_ms)
    robot_m = scipy.signal.lfilter([0.0, 1.0 - keeps], [1.0, -keeps], late)
    robot_m += 0.005 * np.random.default_rng(4).standard_normal(rows)
    rig = tmp_path / "steps.toml"
    rig.write_text(STEPS)
    record = write(tmp_path / "steps.csv", "t_s,command_position_m,robot_position_m", t_s, command_m, robot_m)
    found = diagnose(tmp_path, record, "--rig", rig)
    assert found["verdict"] == "named" and sorted(values(found)) == ["robot.dead_time", "robot.lag"]
    told = {one["name"]: one for cause in found["causes"] for one in cause["parameters"]}
    for name, true in (("dead_time_ms", dead_time_ms), ("lag_ms", lag_ms)):
        low, high = told[name]["ci95"]
        assert abs(told[name]["value"] - true) < high - low < 0.2 * true


@pytest.mark.parametrize("late_ms, gain", [(3.5, 0.02), (4.5, 0.01), (2.5, 0.01)])
@pytest.mark.first(1)
def test_a_dead_time_beside_a_gain_is_no_resonance(tmp_path, late_ms, gain):
    """Slow motion hardly tells them apart; the gain was found second, and a resonance stood in for the dead time."""
    period_s, dead_time_s = 0.0025, 0.0175
    t_s = period_s * np.arange(12000)
    sines = ((4e-3, 0.3), (3e-3, 1.1), (2e-3, 2.3), (1e-3, 4.0))
    command_m = sum(a * np.sin(2.0 * np.pi * f * t_s + f) for a, f in sines)
    robot_m = (1.0 + gain) * np.interp(t_s - dead_time_s - 1e-3 * late_ms, t_s, command_m)
    robot_m += 5e-6 * np.random.default_rng(8).standard_normal(len(t_s))
    record = write(tmp_path / "late.csv", "t_s,command_position_m,robot_position_m", t_s, command_m, robot_m)
    found = diagnose(tmp_path, record, "--rig", "ess")
    assert found["verdict"] == "named" and sorted(values(found)) == ["robot.dead_time", "robot.gain"]
    [late] = [one for cause in found["causes"] for one in cause["parameters"] if one["name"] == "dead_time_ms"]
    assert late["value"] == pytest.approx(1e3 * dead_time_s + late_ms, abs=0.01)
