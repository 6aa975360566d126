"""Records of a robot that follows its command 7 ticks late, with noise and a fault that is known, and what
`berth diagnose` and its report make of them."""

import json
import subprocess
import sys

import numpy as np
import pytest
from conftest import EXIT_DONE, ROOT, command, play

SEED = 20
RATE_Hz, DELAY_TICKS, NOISE_m = 400, 7, 2e-6  # the dead time of `ess` is 17.5 ms
BACKLASH_m = 4e-4


def no_law(reference):
    """A fault that no effect of the library describes: even in the position, with a comb on it."""
    return reference + 3e-4 * np.abs(np.sin(reference / 1.3e-3)) ** 0.3


FAULTS = {"named": lambda reference: play(reference, BACKLASH_m), "unknown": no_law,
          "nothing_detectable": lambda reference: reference}


def write_record(path, fault, duration_s=40.0):
    """A record of the robot alone; the true error of the rig `ess` about it, in m."""
    rng = np.random.default_rng(SEED)
    t_s = np.arange(int(duration_s * RATE_Hz)) / RATE_Hz
    command_m = sum(4e-3 / (k + 1) * np.sin(2 * np.pi * (0.11 + 0.37 * k) * t_s + 1.7 * k) for k in range(6))
    command_m = np.round((command_m - command_m[0]) * 1e11) / 1e11
    late_m = np.concatenate((np.full(DELAY_TICKS, command_m[0]), command_m[:-DELAY_TICKS]))
    robot_m = fault(late_m) + NOISE_m * rng.standard_normal(len(t_s))
    np.savetxt(path, np.column_stack((t_s, command_m, robot_m)), delimiter=",", comments="", fmt="%.12g",
               header="t_s,command_position_m,robot_position_m")
    return robot_m - late_m


def report(*arguments):
    words = [sys.executable, ROOT / "scripts" / "diagnosis_report.py", *map(str, arguments)]
    return subprocess.run(words, capture_output=True, text=True)


@pytest.fixture(scope="module", params=FAULTS)
def made(request, tmp_path_factory):
    """(verdict, folder with the report, true error as given)"""
    folder = tmp_path_factory.mktemp(request.param)
    record = folder / "record.csv"
    error_m = write_record(record, FAULTS[request.param])
    done = command("diagnose", record, "--rig", "ess", "--out", folder / "out")
    assert done.returncode == EXIT_DONE, done.stderr.decode()
    assert f"report: build/berth report {folder / 'out'}\n" in done.stdout.decode()
    made = report(folder / "out")
    assert made.returncode == EXIT_DONE, made.stderr
    assert str(folder / "out" / "report.html") in made.stdout and str(folder / "out" / "report.png") in made.stdout
    return request.param, folder / "out", error_m


def told(folder):
    return json.loads((folder / "diagnosis.json").read_text())


def place_in(found, path):
    for name in path.split("."):
        found = found[int(name) if name.isdigit() else name]
    return found
