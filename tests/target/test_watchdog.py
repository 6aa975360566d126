"""The loop and the kernel's software watchdog: what the kernel says of it in each phase of steps/watchdog.sh."""

import pytest

FIRED = "softdog: Triggered"


@pytest.fixture
def watchdog(guest):
    step = guest("watchdog")
    step.check_done()
    return step


def test_a_loop_that_runs_feeds_it(watchdog):
    """For 6 s, where it fires after 2."""
    assert FIRED not in watchdog.text("fed.kernel")


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
