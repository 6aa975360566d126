"""Records of a rig without a fault, of which the reports of the robot's position are off, or rows are missing: what was
wrong with the recording is no fault of the rig."""

import json

import numpy as np
import pytest
from conftest import EXIT_DONE, EXIT_INPUT, command

SEED = 20261122
COLUMNS = ["t_s", "command_position_m", "robot_position_m", "force_N"]
NOISE = ["--set", "robot.feedback_noise_m=5e-6", "--set", "sensor.noise_N=0.2"]
MOTION = ["--set", "profile.kind=multisine", "--set", "profile.amplitude_m=0.01", "--set", "profile.duration_s=40",
          "--set", "run.duration_s=40"]


def run_with(folder, *settings):
    """t_s, command, robot and force of a run of `ess`, one a row."""
    assert command("run", "ess", *NOISE, *MOTION, *settings, "--out", folder).returncode == EXIT_DONE
    assert command("diagnose", folder / "ess.ulg", "--rig", "ess", "--out", folder).returncode == EXIT_DONE
    lines = (folder / "series.csv").read_text().splitlines()
    places = [lines[0].split(",").index(name) for name in COLUMNS]
    return np.loadtxt(lines[1:], delimiter=",", usecols=places)


@pytest.fixture(scope="module")
def rows(tmp_path_factory):
    return run_with(tmp_path_factory.mktemp("faultless"))


def diagnosed(folder, rows):
    np.savetxt(folder / "record.csv", rows, delimiter=",", header=",".join(COLUMNS), comments="", fmt="%.12g")
    done = command("diagnose", folder / "record.csv", "--rig", "ess", "--out", folder)
    assert done.returncode == EXIT_DONE, done.stderr.decode()
    return json.loads((folder / "diagnosis.json").read_text())


def block(found, name):
    return next(one for one in found["blocks"] if one["block"] == name)


def late(robot_m):
    return np.concatenate(([robot_m[0]] * 2, robot_m[:-2]))


def rippled(robot_m):
    return robot_m + 3e-5 * np.sin(2 * np.pi * robot_m / 2e-3)


def low_passed(robot_m):
    made = robot_m.copy()
    for n in range(1, len(made)):
        made[n] = made[n - 1] + 0.4 * (robot_m[n] - made[n - 1])
    return made


@pytest.mark.parametrize("fault", [late, pytest.param(rippled, marks=pytest.mark.slow), low_passed])
@pytest.mark.first(1)
def test_reports_that_are_off_are_not_taken_for_motion(tmp_path, rows, fault):
    off = rows.copy()
    off[:, 2] = fault(off[:, 2])
    found = diagnosed(tmp_path, off)
    assert found["verdict"] == "unknown" and found["block"] == "robot" and found["causes"] == []
    assert any("the reports are off, not the motion" in why for why in block(found, "robot")["doubts"])
    assert block(found, "force")["verdict"] == "nothing_detectable"


@pytest.mark.slow
def test_a_motion_that_is_off_is_still_named(tmp_path):
    found = diagnosed(tmp_path, run_with(tmp_path, "--set", "robot.dead_time_ms=21"))
    assert found["verdict"] in ("named", "one_of")
    assert [one["effect"] for one in found["causes"]] == ["robot.dead_time"]


def test_behind_a_robot_that_nothing_explains_no_cause_is_sure(tmp_path, rows):
    """An offset of the motion, which no effect describes, looks like a bias of the force."""
    off = rows.copy()
    off[:, 2] += 4e-4
    off[:, 3] += 4e-4 * 2368.0
    found = diagnosed(tmp_path, off)
    assert found["verdict"] != "named"
    assert block(found, "force")["verdict"] in ("partly_explained", "unknown")


def test_single_rows_that_are_missing_are_no_fault(tmp_path, rows):
    rng = np.random.default_rng(SEED)
    gone = rng.choice(np.arange(100, len(rows) - 100), 25, replace=False)
    found = diagnosed(tmp_path, np.delete(rows, gone, axis=0))
    assert found["verdict"] == "nothing_detectable", f"seed {SEED}"
    assert any("rows are missing in" in note for note in found["notes"])


@pytest.mark.parametrize("decimals", [12, 9])
def test_an_echoed_setpoint_is_no_measured_position(tmp_path, rows, decimals):
    echo = rows.copy()
    echo[:, 2] = np.round(echo[:, 1], decimals)
    np.savetxt(tmp_path / "echo.csv", echo, delimiter=",", header=",".join(COLUMNS), comments="", fmt="%.12g")
    done = command("diagnose", tmp_path / "echo.csv", "--rig", "ess", "--out", tmp_path)
    assert done.returncode == EXIT_INPUT
    assert b"echo.csv:1: robot_position_m repeats command_position_m" in done.stderr
    assert b"leave it out" in done.stderr and not (tmp_path / "diagnosis.json").exists()


def test_an_error_above_its_own_floor_is_not_called_nothing(tmp_path, rows):
    """A sensor that creeps, of which the library knows nothing, and no standstill tells the noise."""
    creeping = rows.copy()
    crept_N = 0.0
    for n, force_N in enumerate(rows[:, 3]):
        creeping[n, 3] += crept_N
        crept_N += 0.0025 / 6.0 * (0.15 * force_N - crept_N)
    found = diagnosed(tmp_path, creeping)
    force = block(found, "force")
    left = found["residual"]["force_N"]["fit"]
    assert left["after"] < 1.4 * left["floor"] or force["verdict"] == "unknown"
    assert force["verdict"] != "nothing_detectable"
