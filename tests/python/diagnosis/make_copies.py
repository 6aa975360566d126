"""Records that are their own copy or another one's, whatever was done to it, and those that only look like it."""

import functools

import numpy as np
import scipy.signal
from recipes import recipe, save


def motion(rows=4000):
    """t_s, command and robot of a robot that does as it is told, with noise."""
    t_s = 0.0025 * np.arange(rows)
    command_m = 0.01 * np.sin(2 * np.pi * 0.7 * t_s) + 0.003 * np.sin(2 * np.pi * 2.3 * t_s + 1.0)
    robot_m = np.interp(t_s - 0.0175, t_s, command_m) + 1e-6 * np.random.default_rng(1).standard_normal(rows)
    return t_s, command_m, robot_m


def save_robot(path, t_s, command_m, robot_m):
    save(path, None, t_s=t_s, command_position_m=command_m, robot_position_m=robot_m)


def as_it_was(x):
    return x


def mirrored(x):
    return x[::-1]


def turned_over(x):
    return -x


def mirrored_and_turned_over(x):
    return -x[::-1]


MIRRORED = (mirrored, mirrored_and_turned_over)
REPEATED = (as_it_was, turned_over)


def halves(values, turn):
    half = values[:len(values) // 2]
    return np.concatenate((half, turn(half)))


def noise(like, share):
    return share * np.std(like) * np.random.default_rng(3).standard_normal(len(like))


@recipe()
def copied_half(folder, turn, share=0.0, command_too=False, dies_away=False):
    """The robot's second half is its first, turned, with noise upon it; `command_too`: so is the command's;
    `dies_away`: most of the motion happens in a few of the parts in which chance is counted."""
    t_s, command_m, robot_m = motion()
    if dies_away:
        command_m = command_m * np.exp(-t_s / (0.08 * t_s[-1]))
        robot_m = np.interp(t_s - 0.0175, t_s, command_m)
    robot_m = halves(robot_m, turn)
    command_m = halves(command_m, turn) if command_too else command_m
    save_robot(folder / "record.csv", t_s, command_m, robot_m + noise(robot_m, share))


# --- a command that does the same again ----------------------------------------------------------------------------
def late(t_s, x):
    return np.interp(t_s - 0.0175, t_s, x)


def a_little_late(t_s, x):
    return np.interp(t_s - 0.0025, t_s, x)


def without_lag(t_s, x):
    return x


def bent_without_lag(t_s, x):
    return x + 1e3 * x**3


@recipe()
def same_command_again(folder, turn, robot):
    """Its answer was measured twice: other noise, and the lag the right way round."""
    t_s, command_m, _ = motion()
    command_m = halves(command_m, turn)
    robot_m = robot(t_s, command_m)
    save_robot(folder / "record.csv", t_s, command_m, robot_m + noise(robot_m, 0.01))


@recipe()
def wave(folder, shape, lag_s, phase):
    """Periodic; wherever the middle of the record falls: of a sine, on the crest of the answer, too."""
    t_s, _, _ = motion()
    at = t_s / 2.0 - t_s[-1] / 4.0 + phase
    of = {"sine": lambda turns: np.sin(2 * np.pi * turns),
          "triangle": lambda turns: scipy.signal.sawtooth(2 * np.pi * turns, 0.5)}[shape]
    robot_m = 0.01 * of(at - lag_s / 2.0)
    save_robot(folder / "record.csv", t_s, 0.01 * of(at), robot_m + noise(robot_m, 0.01))


@recipe()
def command_that_repeats_itself(folder, noise_m, quantum_m):
    """With next to no noise, or one that steps hide, nothing is there that could tell."""
    t_s, command_m, _ = noisy_motion(1)
    command_m = halves(command_m, as_it_was)
    robot_m = np.interp(t_s - 0.0175, t_s, command_m) + noise_m * np.random.default_rng(1).standard_normal(len(t_s))
    save_robot(folder / "record.csv", t_s, command_m, quantum_m * np.round(robot_m / quantum_m) if quantum_m else robot_m)


# --- a push and the way that it made ------------------------------------------------------------------------------
@functools.cache
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


@recipe()
def pushed(folder, turn=None, share=0.0):
    """The mass; with `turn`, the second half of force and position is the first, turned."""
    t_s, push_N, position_m = pushed_mass()
    if turn:
        position_m = halves(position_m, turn)
        push_N, position_m = halves(push_N, turn), position_m + noise(position_m, share)
    save(folder / "record.csv", None, t_s=t_s, operator_force_N=push_N, command_position_m=position_m)
    (folder / "rig.toml").write_text('[manipulator]\nmass_kg = 95\ndamping_N_s_per_m = 200\nstiffness_N_per_m = 0\n'
                                     '[operator]\ninterface = "force"\n')


# --- a file made from another one ---------------------------------------------------------------------------------
def noisy_motion(seed, turns=1.0, quantum_m=0.0, noise_m=5e-6):
    """Time, command and robot: one command, and an answer with its own noise."""
    t_s, command_m, _ = motion(8000)
    command_m = command_m + 0.002 * np.sin(2 * np.pi * turns * 3.1 * t_s)
    robot_m = np.interp(t_s - 0.0175, t_s, command_m)
    robot_m = robot_m + noise_m * np.random.default_rng(seed).standard_normal(len(t_s))
    return t_s, command_m, quantum_m * np.round(robot_m / quantum_m) if quantum_m else robot_m


def in_other_digits(x):
    return np.round(x, 6)


def a_part_of_it(x):
    return x[2000:]


def larger(x):
    return 1.5 * x


def with_noise_upon_it(x):
    return x + noise(x, 2e-4)


def all_of_that(x):
    return np.round(-1.5 * x[1000:6000][::-1], 6)


DERIVED = (in_other_digits, turned_over, a_part_of_it, mirrored, larger, with_noise_upon_it, all_of_that)


@recipe()
def derived(folder, form, role, given="record"):
    """A record, and one that was made from it in the role of `role`; or both beside another record: then the first is
    the validation."""
    t_s, command_m, robot_m = noisy_motion(1)
    made = [form(x) for x in (command_m, robot_m)]
    save_robot(folder / f"{given}.csv", t_s, command_m, robot_m)
    save_robot(folder / f"{role}.csv", t_s[:len(made[0])], *made)
    if given != "record":
        save_robot(folder / "record.csv", *noisy_motion(2))


@recipe()
def derived_half(folder, turn, change):
    """The second half is made from the first one, command and all."""
    t_s, command_m, robot_m = noisy_motion(1)
    half = len(t_s) // 2
    columns = [np.concatenate((x[:half], change(turn(x[:half])))) for x in (command_m, robot_m)]
    save_robot(folder / "record.csv", t_s, *columns)


@recipe()
def measured_again(folder, role, turns, quantum_m):
    """The same command and other noise, be it hidden by the steps of the sensor or not."""
    save_robot(folder / "record.csv", *noisy_motion(1, quantum_m=quantum_m))
    save_robot(folder / f"{role}.csv", *noisy_motion(2, turns, quantum_m))
