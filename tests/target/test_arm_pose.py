"""A whole arm in the loop over the kernel's CAN stack: the operator's orders as frames, the tool's planar pose on three
axes of the robot, the whole wrench back."""

import cantools
import numpy as np
import pytest
from conftest import ROOT, berth
from target_log import TargetLog

TICKS = 12_000
SIDES = ("y_{}_m", "rz_{}_rad")


@pytest.fixture
def loop(guest):
    step = guest("arm_pose")
    step.check_loop_done()
    return step


@pytest.fixture
def log(loop):
    return TargetLog(loop.path("run.ulg"))


def test_it_runs_to_the_end_in_time(loop, log):
    log.check_ran_to_the_end(TICKS)
    p99_9_us = loop.json("jitter.json")["berth"]["execution"]["p99_9_us"]
    print(f"a tick with an arm, three axes and twelve frames: p99.9 {p99_9_us} us")
    assert p99_9_us < 150


def test_it_replays_bit_for_bit_on_the_host(loop):
    loop.check_replays("run.ulg")


def test_the_arm_goes_where_it_goes_in_simulation(log, tmp_path):
    simulated = TargetLog(berth("run", "ess-pose", "--out", tmp_path)["log"])
    log.check_arm_moves_as(simulated)


def test_every_axis_is_told_and_heard(log):
    side = log.topic("side")
    for name in SIDES:
        assert np.ptp(side[name.format("command")]) > 1e-3
        assert np.ptp(side[name.format("robot")]) > 1e-3
    assert np.ptp(side["y_force_N"]) > 1 and np.ptp(side["rz_torque_N_m"]) > 0.1


def test_candump_saw_the_setpoints_of_every_axis(loop, log):
    dbc = cantools.database.load_file(ROOT / "firmware" / "can" / "berth.dbc")
    frames = [line.split()[2].split("#") for line in loop.text("robot.candump").splitlines()]
    silent = np.isin(log.tick["state"], [0, 5])
    for message, field in (("setpoint_y", "y_command_m"), ("setpoint_rz", "rz_command_rad")):
        about = dbc.get_message_by_name(message)
        seen = [about.decode(bytes.fromhex(data)) for identifier, data in frames if int(identifier, 16) == about.frame_id]
        values = np.array([frame["position_m" if message == "setpoint_y" else "angle_rad"] for frame in seen])
        np.testing.assert_allclose(values, log.topic("side")[field][~silent], rtol=0, atol=1e-11)
