"""`berth diagnose` and records that are their own copy, forwards or backwards, with noise or without: no evidence.
What a command does again is none of that."""

import numpy as np
import pytest
import scipy.signal
from conftest import EXIT_DONE, command
from test_diagnosis import HEADER, diagnose, motion, refused, write


@pytest.mark.parametrize("turn", [lambda x: x, lambda x: x[::-1], lambda x: -x])
def test_a_second_half_that_is_the_first(tmp_path, turn):
    t_s, command_m, robot_m = motion()
    half = len(t_s) // 2
    robot_m = np.concatenate((robot_m[:half], turn(robot_m[:half])))
    refused(tmp_path, write(tmp_path / "copy.csv", HEADER, t_s, command_m, robot_m), "second half",
            "independent evidence")


def halves(values, turn):
    half = values[:len(values) // 2]
    return np.concatenate((half, turn(half)))


MIRRORED = {"mirrored": lambda x: x[::-1], "mirrored and turned over": lambda x: -x[::-1]}
REPEATED = {"again": lambda x: x, "turned over": lambda x: -x}
ROBOTS = {"late": lambda t_s, x: np.interp(t_s - 0.0175, t_s, x), "a little late": lambda t_s, x: np.interp(
    t_s - 0.0025, t_s, x), "without any lag": lambda _, x: x, "bent, without any lag": lambda _, x: x + 1e3 * x**3}


def noise(like, share):
    return share * np.std(like) * np.random.default_rng(3).standard_normal(len(like))


@pytest.mark.parametrize("share", [0.0, 1e-3, 0.01, 0.03])
@pytest.mark.parametrize("turn", MIRRORED)
@pytest.mark.parametrize("is_all", [True, False])
def test_a_second_half_that_is_the_first_backwards_with_noise_upon_it(tmp_path, turn, share, is_all):
    """Time cannot run backwards in a robot that lags: neither with its command, nor without."""
    t_s, command_m, robot_m = motion()
    robot_m = halves(robot_m, MIRRORED[turn])
    command_m = halves(command_m, MIRRORED[turn]) if is_all else command_m
    refused(tmp_path, write(tmp_path / "copy.csv", HEADER, t_s, command_m, robot_m + noise(robot_m, share)),
            "second half", "backwards", "independent evidence")


def test_a_robot_that_does_the_same_again_without_being_told(tmp_path):
    t_s, command_m, robot_m = motion()
    robot_m = halves(robot_m, lambda x: x)
    refused(tmp_path, write(tmp_path / "copy.csv", HEADER, t_s, command_m, robot_m + noise(robot_m, 0.01)),
            "second half", "again", "independent evidence")


@pytest.mark.parametrize("robot", ROBOTS)
@pytest.mark.parametrize("turn", [*MIRRORED, *REPEATED])
def test_a_command_may_do_the_same_again_or_backwards(tmp_path, turn, robot):
    """Its answer was measured twice: other noise, and the lag the right way round."""
    t_s, command_m, _ = motion()
    command_m = halves(command_m, (MIRRORED | REPEATED)[turn])
    robot_m = ROBOTS[robot](t_s, command_m)
    record = write(tmp_path / "same.csv", HEADER, t_s, command_m, robot_m + noise(robot_m, 0.01))
    diagnose(tmp_path / "out", record, "--rig", "ess")


@pytest.mark.parametrize("lag_s", [0.0, 0.001, 0.0175])
@pytest.mark.parametrize("shape", ["triangle", "sine"])
def test_a_periodic_command_is_no_copy(tmp_path, shape, lag_s):
    """Wherever the middle of the record falls: of a sine, on the crest of the answer, too."""
    t_s, _, _ = motion()
    for phase in (0.0, 0.25, 0.25 + lag_s / 2.0, 0.6):
        at = t_s / 2.0 - t_s[-1] / 4.0 + phase
        wave = {"sine": lambda turns: np.sin(2 * np.pi * turns), "triangle": lambda turns: scipy.signal.sawtooth(
            2 * np.pi * turns, 0.5)}[shape]
        robot_m = 0.01 * wave(at - lag_s / 2.0)
        record = write(tmp_path / "wave.csv", HEADER, t_s, 0.01 * wave(at), robot_m + noise(robot_m, 0.01))
        done = command("diagnose", record, "--rig", "ess", "--set", f"robot.dead_time_ms={max(2.5, 1e3 * lag_s)}",
                       "--out", tmp_path / "out")
        assert done.returncode == EXIT_DONE, (phase, done.stderr.decode())
