"""`berth diagnose --repeat` and `--standstill` with runs of the closed loop, in which the noise of the force moves the
command, and records whose own command repeats itself."""

import json

import numpy as np
import pytest
from conftest import EXIT_DONE, EXIT_INPUT, command, settings

NOISE_N, NOISE_m = 0.2, 5e-6
NOISE = {"sensor.noise_N": NOISE_N, "robot.feedback_noise_m": NOISE_m}
PERIOD_s, LENGTH_s = 10.0, 20.0
GIVEN = ["--set", "manipulator.initial_position_m=0"]


def profile(path):
    """Five tones that repeat after PERIOD_s, as for a frequency response."""
    t_s = 0.02 * np.arange(round(LENGTH_s / 0.02) + 1)
    position_m = sum(2e-3 * np.sin(2 * np.pi * tone / PERIOD_s * t_s + tone) for tone in (2, 5, 9, 14, 20))
    np.savetxt(path, np.column_stack((t_s, position_m - position_m[0])), delimiter=",", comments="", fmt="%.9g",
               header="t_s,operator_position_m")
    return path


def run(folder, rig, seed, fault):
    keys = {**NOISE, **fault, "run.duration_s": LENGTH_s, "run.seed": seed}
    folder.mkdir(parents=True)
    done = command("run", rig, *settings(keys), *GIVEN, "--profile", profile(folder / "profile.csv"), "--out", folder)
    assert done.returncode == EXIT_DONE, done.stderr.decode()
    return folder / f"{rig}.ulg"


def diagnose(out, *arguments):
    done = command("diagnose", *arguments, *GIVEN, "--out", out)
    assert done.returncode == EXIT_DONE, done.stderr.decode()
    return json.loads((out / "diagnosis.json").read_text())


def floors(told):
    return {one["block"]: one["residual"]["fit"]["floor"] for one in told["blocks"]
            if one["residual"]["floor_is_measured"]}


@pytest.mark.parametrize("rig, fault, effect",
                         [("ess", {}, None), ("ess-50hz", {"robot.backlash_m": 2e-4}, "robot.backlash"),
                          ("ess", {"robot.deadband_m": 1e-4}, "robot.deadband"), ("ess-50hz", {}, None),
                          ("ess", {"robot.backlash_m": 5e-5}, "robot.backlash")])
@pytest.mark.first(3)
def test_a_run_again_tells_the_noise(tmp_path, rig, fault, effect):
    """Half the variance of what two runs differ by, less what the other command does: the noise that was put in."""
    first, second = (run(tmp_path / str(seed), rig, seed, fault) for seed in (1, 2))
    told = diagnose(tmp_path / "out", first, "--rig", rig, "--repeat", second)
    assert [cause["effect"] for cause in told["causes"]] == ([effect] if effect else []), told["verdict"]
    measured = floors(told)
    if effect is None or rig == "ess":  # a tick of 20 ms is long for a run's own steps, and play turns within them
        assert measured["force"] == pytest.approx(NOISE_N, rel=0.05)
    if effect is None:  # a robot that switches goes another way after another command
        assert measured["robot"] == pytest.approx(NOISE_m, rel=0.05)


def test_a_run_with_another_command_repeats_none(tmp_path):
    first, second = run(tmp_path / "1", "ess", 1, {}), tmp_path / "2" / "ess.ulg"
    keys = {**NOISE, "run.duration_s": LENGTH_s, "run.seed": 2, "profile.kind": "chirp", "profile.amplitude_m": 5e-3}
    assert command("run", "ess", *settings(keys), *GIVEN, "--out", second.parent).returncode == EXIT_DONE
    done = command("diagnose", first, "--rig", "ess", *GIVEN, "--repeat", second, "--out", tmp_path / "out")
    assert done.returncode == EXIT_INPUT and b"repeats no command" in done.stderr


@pytest.mark.parametrize("nothing, something", [("operator_force_N", "operator_position_m"),
                                                ("operator_position_m", "operator_force_N")])
def test_a_column_of_zeros_makes_no_repetition(tmp_path, nothing, something):
    t_s = 0.0025 * np.arange(2000)
    for name, tone_Hz in (("first", 0.5), ("second", 0.8)):
        operator = 0.01 * np.sin(2 * np.pi * tone_Hz * t_s)
        columns = {"t_s": t_s, nothing: 0.0 * t_s, something: operator, "command_position_m": operator,
                   "force_N": 500.0 * operator}
        np.savetxt(tmp_path / f"{name}.csv", np.column_stack(list(columns.values())), delimiter=",", comments="",
                   header=",".join(columns), fmt="%.9g")
    done = command("diagnose", tmp_path / "first.csv", "--rig", "ess", "--repeat", tmp_path / "second.csv", "--out",
                   tmp_path / "out")
    assert done.returncode == EXIT_INPUT and b"repeats no command" in done.stderr, done.stderr.decode()


def test_a_repetition_without_a_column_says_so(tmp_path):
    first, second = (run(tmp_path / str(seed), "ess", seed, {}) for seed in (1, 2))
    done = command("diagnose", second, "--rig", "ess", *GIVEN, "--out", tmp_path / "second")
    assert done.returncode == EXIT_DONE
    series = np.genfromtxt(tmp_path / "second" / "series.csv", delimiter=",", names=True)
    kept = ("t_s", "operator_position_m", "command_position_m", "robot_position_m")
    np.savetxt(tmp_path / "second.csv", np.column_stack([series[name] for name in kept]), delimiter=",", comments="",
               header=",".join(kept), fmt="%.13g")
    told = diagnose(tmp_path / "out", first, "--rig", "ess", "--repeat", tmp_path / "second.csv")
    assert "force" not in floors(told)
    [note] = [note for note in told["notes"] if "the noise of the force" in note]
    assert "it lacks columns" in note, note


def test_a_standstill_that_is_noisier_than_the_record_is_not_its_floor_and_that_is_said(tmp_path):
    record = run(tmp_path / "1", "ess", 1, {})
    keys = {"sensor.noise_N": 2.0, "robot.feedback_noise_m": NOISE_m, "run.duration_s": LENGTH_s, "run.seed": 2,
            "profile.kind": "rest"}
    rest = tmp_path / "rest" / "ess.ulg"
    assert command("run", "ess", *settings(keys), *GIVEN, "--out", rest.parent).returncode == EXIT_DONE
    told = diagnose(tmp_path / "out", record, "--rig", "ess", "--standstill", rest)
    assert "force" not in floors(told)
    [note] = [note for note in told["notes"] if "the noise of the force" in note]
    assert "--standstill does not tell" in note and "estimated from the record" in note


@pytest.mark.parametrize("rig, gap_m", [("ess-50hz", 2e-4), ("ess", 2e-4), ("ess-50hz", 5e-5)])
@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.first(3)
def test_a_motion_that_repeats_itself_is_no_copy(tmp_path, rig, gap_m, seed):
    """Play makes it jerk at the same places in both halves; the noise is another one."""
    record = run(tmp_path / "run", rig, seed, {"robot.backlash_m": gap_m})
    told = diagnose(tmp_path / "out", record, "--rig", rig)
    assert [cause["effect"] for cause in told["causes"]] == ["robot.backlash"], told["verdict"]
