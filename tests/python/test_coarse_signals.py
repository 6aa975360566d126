"""Records whose columns move in coarse steps: of a command that was written with few digits nothing is made, and those of
a sensor are named as what they are, though noise is upon them or values lie beside them."""

import numpy as np
import pytest
import scipy.signal
from gripped_chain import DEAD_TIME_ms, PERIOD_s, ROWS, chirp, diagnosed


def wandering(rng):
    """A few millimetres and up to 5 Hz, as an operator moves."""
    return scipy.signal.lfilter(*scipy.signal.butter(4, 5.0, fs=1 / PERIOD_s), 0.02 * rng.standard_normal(ROWS))


@pytest.mark.parametrize("step_m", [1e-5, 2e-5, 1e-4])
@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.first(3)
def test_of_a_coarse_command_nothing_is_made(tmp_path, step_m, seed):
    """The robot was sent something finer: that is as if setpoints were lost, or smoothed by a lag."""
    rng = np.random.default_rng(seed)
    told = diagnosed(tmp_path, rng, wandering(rng), DEAD_TIME_ms, command_step_m=step_m)
    assert told["verdict"] == "nothing_detectable", [block["causes"] for block in told["blocks"]]
    assert any("command_position_m is written in steps of" in note for note in told["notes"])
    floor_m = told["residual"]["robot_position_m"]["fit"]["floor"]
    assert floor_m == pytest.approx(np.hypot(5e-6, step_m / np.sqrt(12.0)), rel=0.15)


def test_beside_a_coarse_command_a_cause_is_named(tmp_path):
    rng = np.random.default_rng(3)
    told = diagnosed(tmp_path, rng, wandering(rng), 16.0, command_step_m=2e-5)
    [cause] = told["causes"]
    assert told["verdict"] in ("named", "one_of") and cause["effect"] == "robot.dead_time"
    assert cause["parameters"][0]["value"] == pytest.approx(16.0, abs=0.2)


@pytest.mark.parametrize("step_m, late_ms", [(2e-6, 3.0), (3e-6, 3.0), (2e-6, 6.0)])
@pytest.mark.first(1)
def test_what_smooths_a_rounded_command_does_not_win_by_that(tmp_path, step_m, late_ms):
    """A resonance takes the rounding out of the error that a dead time leaves, and was named in its place."""
    rng = np.random.default_rng(7)
    told = diagnosed(tmp_path, rng, wandering(rng), DEAD_TIME_ms + late_ms, command_step_m=step_m)
    assert "robot.dead_time" in [one["effect"] for one in told["causes"] + told["alternatives"]], told["verdict"]
    assert told["verdict"] in ("named", "one_of")


@pytest.mark.parametrize("step_m", [2e-5, 1e-4])
def test_coarse_steps_that_were_sent_hide_nothing(tmp_path, step_m):
    """A controller may count in them: then they are what the robot was sent, and nothing is open."""
    rng = np.random.default_rng(6)
    sent_m = step_m * np.round(wandering(rng) / step_m)
    told = diagnosed(tmp_path, rng, sent_m, DEAD_TIME_ms, command_step_m=step_m, read=lambda force_N: force_N + 2.0)
    assert [cause["effect"] for cause in told["causes"]] == ["sensor.bias"] and told["verdict"] == "named"
    assert told["causes"][0]["parameters"][0]["value"] == pytest.approx(2.0, abs=0.05)
    assert not any("is written in steps of" in note for note in told["notes"])


def stepped(rng, step_N, noise_N=0.0, astray=0.0):
    """In steps; with noise upon them, and a share of the values off them."""
    def read(force_N):
        level_N = step_N * np.round(force_N / step_N) + noise_N * rng.standard_normal(ROWS)
        return level_N + 0.4 * step_N * rng.uniform(-1.0, 1.0, ROWS) * (rng.uniform(size=ROWS) < astray)
    return read


@pytest.mark.parametrize("noise_N, astray", [(0.0, 0.0), (0.05, 0.0), (0.15, 0.0), (0.0, 0.005), (0.0, 0.03)])
def test_steps_of_a_sensor_are_neither_spikes_nor_dropouts(tmp_path, noise_N, astray):
    rng = np.random.default_rng(4)
    told = diagnosed(tmp_path, rng, chirp(), DEAD_TIME_ms, read=stepped(rng, 2.0, noise_N, astray))
    assert [cause["effect"] for cause in told["causes"]] == ["sensor.quantisation"], told["verdict"]
    assert told["verdict"] == "named"
    assert told["causes"][0]["parameters"][0]["value"] == pytest.approx(2.0, rel=0.005)


def test_beside_steps_with_noise_spikes_are_seen(tmp_path):
    rng = np.random.default_rng(5)
    steps = stepped(rng, 1.0, 0.03)
    told = diagnosed(tmp_path, rng, chirp(), DEAD_TIME_ms,
                     read=lambda force_N: steps(force_N) + 30.0 * (rng.uniform(size=ROWS) < 0.005))
    causes = {cause["effect"]: cause["parameters"] for cause in told["causes"]}
    assert set(causes) == {"sensor.quantisation", "sensor.spikes"}, told["verdict"]
    assert causes["sensor.spikes"][1]["value"] == pytest.approx(30.0, rel=0.02)
