"""The loop and the kernel's software watchdog: what the kernel says of it in each phase of steps/watchdog.sh."""

import numpy as np
import pytest
from target_log import TargetLog

PERIOD_s = 0.0025
FIRED = "softdog: Triggered"


@pytest.fixture
def watchdog(guest):
    step = guest("watchdog")
    step.check_done()
    return step


def test_a_loop_that_runs_feeds_it(watchdog):
    """For 6 s, where it fires after 2."""
    assert FIRED not in watchdog.text("fed.kernel")


def test_sigterm_leads_the_robot_to_rest_and_closes_the_log(watchdog):
    """From full motion, within the limits."""
    log = TargetLog(watchdog.path("terminated.ulg"))
    assert watchdog.number("terminated.exit_code") == 0, watchdog.text("loop.stderr")
    assert "stopped because: requested" in watchdog.text("terminated.stdout")
    assert "0 not recorded" in watchdog.text("terminated.stdout")
    log.check_no_tick_is_missing()
    assert log.states() == ["start", "ready", "running"]
    assert log.last_state() == "stopped"
    speeds_m_per_s = np.abs(np.diff(log.tick["command_position_m"])) / PERIOD_s
    stop = np.flatnonzero(~log.before_end)[0]
    assert stop == pytest.approx(6 / PERIOD_s, abs=20)
    assert speeds_m_per_s[stop - 400 : stop].max() > 0.005
    assert speeds_m_per_s[-1] < 1e-4


def test_a_clean_stop_gives_it_back(watchdog):
    """Magic close: the kernel does not complain, and nothing fires afterwards."""
    assert "did not stop" not in watchdog.text("fed.kernel") + watchdog.text("given_back.kernel")
    assert FIRED not in watchdog.text("given_back.kernel")


def test_it_fires_when_the_loop_stands_still_although_the_feeding_thread_goes_on(watchdog):
    assert FIRED in watchdog.text("starved.kernel")
    assert "stopped because: feedback_stale" in watchdog.text("starved.stdout")


def test_it_fires_when_the_program_is_killed(watchdog):
    assert "watchdog did not stop!" in watchdog.text("killed.kernel")
    assert FIRED in watchdog.text("after_killing.kernel")
