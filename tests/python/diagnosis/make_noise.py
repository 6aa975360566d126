"""Runs of the closed loop again, in which the noise of the force moves the command: for --repeat and --standstill."""

import numpy as np
from conftest import EXIT_DONE, command, settings
from recipes import columns_of, program_digest, recipe, save

NOISE_N, NOISE_m = 0.2, 5e-6
NOISE = {"sensor.noise_N": NOISE_N, "robot.feedback_noise_m": NOISE_m}
PERIOD_s, LENGTH_s = 10.0, 20.0
GIVEN = {"manipulator.initial_position_m": 0}


def berth(*words):
    done = command(*words)
    assert done.returncode == EXIT_DONE, done.stderr.decode()


def profile(path):
    """Five tones that repeat after PERIOD_s, as for a frequency response."""
    t_s = 0.02 * np.arange(round(LENGTH_s / 0.02) + 1)
    position_m = sum(2e-3 * np.sin(2 * np.pi * tone / PERIOD_s * t_s + tone) for tone in (2, 5, 9, 14, 20))
    return save(path, 9, t_s=t_s, operator_position_m=position_m - position_m[0])


def toned(folder, rig, seed, fault):
    """A run with these tones."""
    keys = NOISE | fault | {"run.duration_s": LENGTH_s, "run.seed": seed} | GIVEN
    berth("run", rig, *settings(keys), "--profile", profile(folder.parent / "profile.csv"), "--out", folder)


def other(folder, rig, keys):
    berth("run", rig, *settings(NOISE | {"run.duration_s": LENGTH_s, "run.seed": 2} | keys | GIVEN), "--out", folder)


@recipe(program_digest)
def repeated(folder, rig="ess", fault=None, again=True, seed=1, beside=None, lacks=()):
    """A run as a log, and in repeat/ the same with other noise, or in the folder of `beside` ("repeat" or "standstill")
    one with other settings. `lacks`: columns that the repetition has not, as CSV."""
    (folder / "first").mkdir()
    toned(folder / "first", rig, seed, fault or {})
    [log] = (folder / "first").glob("*.ulg")
    log.rename(folder / log.name)
    if beside:
        [(role, keys)] = beside.items()
        other(folder / role, rig, keys)
    elif again:
        toned(folder / "repeat", rig, seed + 1, fault or {})
    if lacks:
        berth("diagnose", folder / "repeat" / f"{rig}.ulg", "--rig", rig, *settings(GIVEN), "--out", folder / "told")
        series = columns_of(folder / "told" / "series.csv")
        kept = [name for name in ("t_s", "operator_position_m", "command_position_m", "robot_position_m", "force_N")
                if name not in lacks]
        save(folder / "repeat.csv", 13, **{name: series[name] for name in kept})


@recipe()
def column_of_zeros(folder, nothing, something):
    """Two commands of which the one operator's column is as good as the other's."""
    t_s = 0.0025 * np.arange(2000)
    for name, tone_Hz in (("record", 0.5), ("repeat", 0.8)):
        operator = 0.01 * np.sin(2 * np.pi * tone_Hz * t_s)
        columns = {"t_s": t_s, nothing: 0.0 * t_s, something: operator, "command_position_m": operator,
                   "force_N": 500.0 * operator}
        save(folder / f"{name}.csv", 9, **columns)
