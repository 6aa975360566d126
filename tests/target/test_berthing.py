"""A whole arm on its satellite approaches, grips and berths the generator over the kernel's CAN stack."""

import numpy as np
import pytest
from conftest import berth
from target_log import TargetLog

TICKS = 28_000
GRIP_TICK = 8_000  # run.grip_close_s


@pytest.fixture
def loop(guest):
    step = guest("berthing")
    step.check_loop_done()
    return step


@pytest.fixture
def log(loop):
    return TargetLog(loop.path("run.ulg"))


@pytest.fixture
def simulated(tmp_path):
    return TargetLog(berth("run", "ess-berthing", "--out", tmp_path)["log"])


def test_it_runs_to_the_end_in_time(loop, log):
    log.check_ran_to_the_end(TICKS)
    p99_9_us = loop.json("jitter.json")["berth"]["execution"]["p99_9_us"]
    print(f"a tick with an arm: p99.9 {p99_9_us} us")
    assert p99_9_us < 100


def test_it_replays_bit_for_bit_on_the_host(loop):
    loop.check_replays("run.ulg")


def test_the_arm_goes_where_it_goes_in_simulation(log, simulated):
    log.check_arm_moves_as(simulated)


def test_it_meets_the_generator_when_the_grip_closes(log, simulated):
    here, there = log.tick["force_N"], simulated.tick["force_N"]
    assert not here[:GRIP_TICK].any()
    assert np.abs(here).max() == pytest.approx(np.abs(there).max(), rel=0.02)
    assert np.abs(there).max() > 5
