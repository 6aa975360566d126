"""Records of which a logger lost rows in bursts, up to four in a row and one row in fourteen of them all: commands that
are put in there push a stiff sensor."""

import numpy as np
import pytest
import scipy.signal
from gripped_chain import DEAD_TIME_ms, FORCE_NOISE_N, PERIOD_s, ROWS, chirp, diagnosed


def tremble(rng):
    """What is between its rows cannot be told from them."""
    return scipy.signal.lfilter(*scipy.signal.butter(2, 40.0, fs=1 / PERIOD_s), 1e-3 * rng.standard_normal(ROWS))


def bursts(rng):
    keep, n = np.ones(ROWS, bool), 50
    while n < ROWS - 50:
        keep[n:n + rng.integers(1, 5)] = False
        n += int(rng.integers(15, 60))
    return keep


def told_of(tmp_path, seed, motion, dead_time_ms=DEAD_TIME_ms):
    print(f"seed {seed}; again: pytest tests/python/test_missing_bursts.py -k '{seed}'")
    rng = np.random.default_rng(seed)
    told = diagnosed(tmp_path, rng, motion(rng), dead_time_ms, bursts(rng))
    assert any("missing" in note for note in told["notes"])
    return told


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.first(1)
def test_a_smooth_command_is_put_in_so_well_that_nothing_shows(tmp_path, seed):
    told = told_of(tmp_path, seed, lambda rng: chirp())
    assert told["verdict"] == "nothing_detectable", [block["causes"] for block in told["blocks"]]
    assert told["residual"]["force_N"]["fit"]["after"] == pytest.approx(FORCE_NOISE_N, rel=0.05)


def test_beside_it_a_cause_is_named(tmp_path):
    told = told_of(tmp_path, 4, lambda rng: chirp(), dead_time_ms=16.0)
    [cause] = told["causes"]
    assert told["verdict"] == "named" and cause["effect"] == "robot.dead_time"
    low, high = cause["parameters"][0]["ci95"]
    assert low < 16.0 < high


@pytest.mark.parametrize("seed", [5, 6])
@pytest.mark.first(1)
def test_a_command_that_trembles_is_not_and_nothing_is_named_for_it(tmp_path, seed):
    told = told_of(tmp_path, seed, tremble)
    assert told["verdict"] not in ("named", "one_of"), told["causes"]


@pytest.mark.parametrize("dead_time_ms, causes", [(DEAD_TIME_ms, []), (16.0, ["robot.dead_time"])])
def test_on_both_sides_of_a_longer_gap(tmp_path, dead_time_ms, causes):
    """Which parts the record: where the second part begins, every row that was put in before it counts, and no other."""
    rng = np.random.default_rng(7)
    keep = bursts(rng)
    keep[4000:4040] = False
    told = diagnosed(tmp_path, rng, chirp(), dead_time_ms, keep)
    assert any("gap" in note for note in told["notes"]) and any("missing" in note for note in told["notes"])
    assert [cause["effect"] for cause in told["causes"]] == causes, told["verdict"]
    assert told["verdict"] == ("named" if causes else "nothing_detectable")
    assert told["residual"]["force_N"]["fit"]["after"] == pytest.approx(FORCE_NOISE_N, rel=0.05)


@pytest.mark.parametrize("dead_time_ms, causes", [(DEAD_TIME_ms, []), (12.0, ["robot.dead_time"])])
def test_few_bursts_in_a_command_that_trembles_a_little(tmp_path, dead_time_ms, causes):
    """As a noisy force makes it in a closed loop: the sensor rings from what was put in, and is left to ring out."""
    rng = np.random.default_rng(8)
    keep = np.ones(ROWS, bool)
    for begin in np.linspace(500, ROWS - 500, 12, dtype=int):
        keep[begin:begin + 4] = False
    told = diagnosed(tmp_path, rng, chirp() + 5e-6 * rng.standard_normal(ROWS), dead_time_ms, keep)
    assert [cause["effect"] for cause in told["causes"]] == causes, told["verdict"]
    assert told["verdict"] == ("named" if causes else "nothing_detectable")
    assert told["residual"]["force_N"]["fit"]["after"] == pytest.approx(FORCE_NOISE_N, rel=0.05)


def test_a_single_row_between_gaps_tells_nothing(tmp_path):
    """The robot may seem to stand in it: nothing in a part so short shows that it does."""
    rng = np.random.default_rng(9)
    keep = np.ones(ROWS, bool)
    for begin in np.linspace(700, ROWS - 900, 40, dtype=int):
        keep[begin:begin + 28] = False
        keep[begin + 7 + rng.integers(0, 3)] = True
    told = diagnosed(tmp_path, rng, chirp(), DEAD_TIME_ms, keep)
    assert told["verdict"] == "nothing_detectable", [block["doubts"] for block in told["blocks"]]
    assert told["residual"]["robot_position_m"]["fit"]["after"] == pytest.approx(5e-6, rel=0.05)
