"""`berth diagnose` and records that are their own copy or another one's, whatever was done to it: no evidence. What a
command does again is none of that."""

import numpy as np
import pytest
import scipy.signal
from conftest import EXIT_DONE, EXIT_INPUT, command
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


@pytest.mark.parametrize("turn", MIRRORED)
def test_a_motion_that_dies_away_is_known_backwards_too(tmp_path, turn):
    """Most of it happens in a few of the parts in which chance is counted."""
    t_s, command_m, _ = motion()
    command_m = command_m * np.exp(-t_s / (0.08 * t_s[-1]))
    robot_m = halves(np.interp(t_s - 0.0175, t_s, command_m), MIRRORED[turn])
    record = write(tmp_path / "copy.csv", HEADER, t_s, halves(command_m, MIRRORED[turn]), robot_m + noise(robot_m, 1e-3))
    refused(tmp_path, record, "second half", "backwards", "independent evidence")


def test_a_robot_that_does_the_same_again_without_being_told(tmp_path):
    t_s, command_m, robot_m = motion()
    robot_m = halves(robot_m, lambda x: x)
    refused(tmp_path, write(tmp_path / "copy.csv", HEADER, t_s, command_m, robot_m + noise(robot_m, 0.01)),
            "second half", "again", "independent evidence")


@pytest.mark.parametrize("robot", ROBOTS)
@pytest.mark.parametrize("turn", [*MIRRORED, *REPEATED])
@pytest.mark.first(6)
def test_a_command_may_do_the_same_again_or_backwards(tmp_path, turn, robot):
    """Its answer was measured twice: other noise, and the lag the right way round."""
    t_s, command_m, _ = motion()
    command_m = halves(command_m, (MIRRORED | REPEATED)[turn])
    robot_m = ROBOTS[robot](t_s, command_m)
    record = write(tmp_path / "same.csv", HEADER, t_s, command_m, robot_m + noise(robot_m, 0.01))
    diagnose(tmp_path / "out", record, "--rig", "ess")


@pytest.mark.parametrize("lag_s", [0.0, 0.001, 0.0175])
@pytest.mark.parametrize("shape", ["triangle", "sine"])
@pytest.mark.first(2)
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


def pushed_mass(rows=24000, period_s=0.001):
    """Time, force and position of a mass with viscous and dry friction, as an encoder of 0.1 um shows it."""
    rng = np.random.default_rng(5)
    t_s = period_s * np.arange(rows)
    push_N = sum(60.0 / (1 + f) * np.sin(2 * np.pi * f * t_s + rng.uniform(0, 6.28)) for f in (0.3, 0.7, 1.1, 1.9, 3.1))
    x_m, v_m_per_s, position_m = 0.0, 0.0, np.empty(rows)
    for n in range(rows):
        position_m[n] = x_m
        v_m_per_s += period_s / 95.0 * (push_N[n] - 200.0 * v_m_per_s)
        v_m_per_s -= np.clip(v_m_per_s, -1, 1) * min(1.0, period_s / 95.0 * 20.0 / max(abs(v_m_per_s), 1e-12))
        x_m += period_s * v_m_per_s
    return t_s, push_N, position_m


@pytest.mark.parametrize("turn, share", [("mirrored", 0.0), ("mirrored", 0.01), ("again", 0.0), ("turned over", 0.0)])
@pytest.mark.first(2)
def test_a_push_and_the_way_it_made_are_no_second_measurement_of_themselves(tmp_path, turn, share):
    """Of a manipulator alone the position is what was measured: a mass, whose damping turns with time."""
    t_s, push_N, position_m = pushed_mass()
    rig = tmp_path / "mass.toml"
    rig.write_text('[manipulator]\nmass_kg = 95\ndamping_N_s_per_m = 200\nstiffness_N_per_m = 0\n'
                   '[operator]\ninterface = "force"\n')
    header = "t_s,operator_force_N,command_position_m"
    whole = write(tmp_path / "whole.csv", header, t_s, push_N, position_m)
    assert command("diagnose", whole, "--rig", rig, "--out", tmp_path / "whole").returncode == EXIT_DONE
    how = (MIRRORED | REPEATED)[turn]
    position_m = halves(position_m, how)
    copy = write(tmp_path / "copy.csv", header, t_s, halves(push_N, how), position_m + noise(position_m, share))
    done = command("diagnose", copy, "--rig", rig, "--out", tmp_path / "out")
    message = done.stderr.decode()
    print(message)
    assert done.returncode == EXIT_INPUT and "second half" in message and "no independent evidence" in message
    assert not (tmp_path / "out").exists()


def noisy_motion(seed, turns=1.0, quantum_m=0.0, noise_m=5e-6):
    """Time, command and robot: one command, and an answer with its own noise."""
    t_s, command_m, _ = motion(8000)
    command_m = command_m + 0.002 * np.sin(2 * np.pi * turns * 3.1 * t_s)
    robot_m = np.interp(t_s - 0.0175, t_s, command_m)
    robot_m = robot_m + noise_m * np.random.default_rng(seed).standard_normal(len(t_s))
    return t_s, command_m, quantum_m * np.round(robot_m / quantum_m) if quantum_m else robot_m


DERIVED = {
    "in other digits": lambda x: np.round(x, 6),
    "turned over": lambda x: -x,
    "a part of it": lambda x: x[2000:],
    "backwards": lambda x: x[::-1],
    "larger": lambda x: 1.5 * x,
    "with noise upon it": lambda x: x + noise(x, 2e-4),
    "all of that": lambda x: np.round(-1.5 * x[1000:6000][::-1], 6)}


@pytest.mark.parametrize("form", DERIVED)
@pytest.mark.parametrize("other, argument", [("given", "--validate"), ("given", "--repeat"), ("--validate", "--repeat")])
def test_a_file_made_from_another_one_is_no_second_measurement(tmp_path, form, other, argument):
    """Its noise gives it away. A repetition starts with the same command, or it is refused as none."""
    t_s, command_m, robot_m = noisy_motion(1)
    made = [DERIVED[form](x) for x in (command_m, robot_m)]
    record = write(tmp_path / "record.csv", HEADER, t_s, command_m, robot_m)
    derived = write(tmp_path / "derived.csv", HEADER, t_s[:len(made[0])], *made)
    given = record if other == "given" else write(tmp_path / "given.csv", HEADER, *noisy_motion(2))
    arguments = ["--rig", "ess", "--out", tmp_path / "out", argument, derived]
    done = command("diagnose", given, *arguments, *(() if other == "given" else (other, record)))
    message = done.stderr.decode()
    assert done.returncode == EXIT_INPUT and not (tmp_path / "out").exists(), message
    for part in (derived.name, record.name, "robot_position_m", "no independent evidence", "give another measurement"):
        assert part in message, message


def test_what_was_done_to_it_is_told(tmp_path):
    t_s, command_m, robot_m = noisy_motion(1)
    record = write(tmp_path / "record.csv", HEADER, t_s, command_m, robot_m)
    made = write(tmp_path / "made.csv", HEADER, t_s[:5000], *(DERIVED["all of that"](x) for x in (command_m, robot_m)))
    done = command("diagnose", record, "--rig", "ess", "--out", tmp_path / "out", "--validate", made)
    assert "backwards, turned over, times 1.5, from its 14.9975 s on" in done.stderr.decode(), done.stderr.decode()


@pytest.mark.parametrize("turn", [*MIRRORED, *REPEATED])
@pytest.mark.parametrize("change", ["in other digits", "with noise upon it"])
def test_a_second_half_made_from_the_first_one_commands_and_all(tmp_path, turn, change):
    t_s, command_m, robot_m = noisy_motion(1)
    half = len(t_s) // 2
    columns = [np.concatenate((x[:half], DERIVED[change]((MIRRORED | REPEATED)[turn](x[:half]))))
               for x in (command_m, robot_m)]
    refused(tmp_path, write(tmp_path / "copy.csv", HEADER, t_s, *columns), "second half",
            "independent evidence", "measured in one go")


@pytest.mark.parametrize("quantum_m", [0.0, 1e-6, 2e-5, 1e-3])
@pytest.mark.parametrize("argument, turns", [("--repeat", 1.0), ("--validate", 1.0), ("--validate", 1.3)])
def test_what_was_measured_again_is_another_measurement(tmp_path, argument, turns, quantum_m):
    """The same command and other noise, be it hidden by the steps of the sensor or not."""
    record = write(tmp_path / "record.csv", HEADER, *noisy_motion(1, quantum_m=quantum_m))
    again = write(tmp_path / "again.csv", HEADER, *noisy_motion(2, turns, quantum_m))
    diagnose(tmp_path / "out", record, "--rig", "ess", argument, again)


@pytest.mark.parametrize("noise_m, quantum_m", [(1e-9, 0.0), (5e-6, 0.0), (5e-6, 1e-6), (5e-6, 2e-5)])
def test_a_command_that_repeats_itself_makes_no_copy_of_what_it_moves(tmp_path, noise_m, quantum_m):
    """With next to no noise, or one that steps hide, nothing is there that could tell."""
    t_s, command_m, _ = noisy_motion(1)
    command_m = halves(command_m, lambda x: x)
    robot_m = np.interp(t_s - 0.0175, t_s, command_m) + noise_m * np.random.default_rng(1).standard_normal(len(t_s))
    robot_m = quantum_m * np.round(robot_m / quantum_m) if quantum_m else robot_m
    record = write(tmp_path / "same.csv", HEADER, t_s, command_m, robot_m)
    assert "second half" not in command("diagnose", record, "--rig", "ess", "--out", tmp_path / "out").stderr.decode()
