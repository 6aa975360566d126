"""`berth diagnose` of what happens to single samples: told in the block where it happens, with the error that it makes."""

import json

import numpy as np
import pytest
from conftest import EXIT_DONE, command, settings

NOISE_N, NOISE_m, DELAY_TICKS = 0.2, 5e-6, 7
RUN = {"run.duration_s": 20, "profile.kind": "multisine", "profile.amplitude_m": 0.01, "profile.frequency_end_Hz": 2,
       "sensor.noise_N": NOISE_N, "robot.feedback_noise_m": NOISE_m}


def diagnosed_run(folder, **more):
    """(diagnosis, terminal, series) of a run of `ess` that the rig file knows nothing of."""
    assert command("run", "ess", *settings({**RUN, **more}), "--out", folder).returncode == EXIT_DONE
    done = command("diagnose", folder / "ess.ulg", "--rig", "ess", "--out", folder)
    assert done.returncode == EXIT_DONE, done.stderr.decode()
    series = np.genfromtxt(folder / "series.csv", delimiter=",", names=True)
    return json.loads((folder / "diagnosis.json").read_text()), done.stdout.decode(), series


def rms(x):
    return np.sqrt(np.mean(np.square(x)))


@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.first(1)
def test_what_the_robot_loses_is_told_in_the_robot(tmp_path, seed):
    told, terminal, series = diagnosed_run(tmp_path, **{"robot.lost_command_probability": 0.03, "run.seed": seed})
    assert told["verdict"] == "named" and told["block"] == "robot", seed
    blocks = {one["block"]: one for one in told["blocks"]}
    assert [one["effect"] for one in blocks["robot"]["causes"]] == ["robot.lost_commands"]
    assert blocks["force"]["causes"] == [] and blocks["force"]["verdict"] == "nothing_detectable"
    assert "explains" in terminal
    # As given the robot is 7 ticks late and no more: what it then lacks is what it lost.
    lacks_m = series["robot_position_m"][DELAY_TICKS:] - series["command_position_m"][:-DELAY_TICKS]
    fit = blocks["robot"]["residual"]["fit"]
    assert rms(lacks_m) > 2.0 * NOISE_m and fit["before"] == pytest.approx(rms(lacks_m), rel=0.15)
    assert fit["retuned"] > 0.9 * fit["before"] and fit["after"] == pytest.approx(NOISE_m, rel=0.05)
    assert rms(series["robot_error_before_m"]) == pytest.approx(rms(lacks_m), rel=0.02)


def test_spikes_are_in_the_error_as_given(tmp_path):
    size_N, share = 20.0, 0.01
    told, _, series = diagnosed_run(tmp_path, **{"sensor.spike_probability": share, "sensor.spike_N": size_N})
    assert told["verdict"] == "named" and told["block"] == "force"
    fit = told["residual"]["force_N"]["fit"]
    assert fit["after"] == pytest.approx(NOISE_N, rel=0.05)
    # A spike has either sign: by the size that it was given, counted in the record itself.
    count = np.mean(np.abs(series["force_error_before_N"]) > 0.5 * size_N)
    assert count == pytest.approx(share, rel=0.3)
    assert fit["before"] == pytest.approx(np.hypot(NOISE_N, size_N * np.sqrt(share)), rel=0.25)
