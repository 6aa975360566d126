"""How the reference case keeps time over the kernel's CAN stack under load, beside cyclictest, and what happens without
real-time scheduling. Its motion and its bus: test_loops.py."""

import pytest
from conftest import CLOSED_LOOP_s, berth
from target_log import TargetLog

TICKS = 400 * CLOSED_LOOP_s


@pytest.fixture
def loop(guest):
    step = guest("closed_loop")
    step.check_loop_done()
    return step


@pytest.fixture
def log(loop):
    return TargetLog(loop.path("run.ulg"))


@pytest.fixture
def jitter(loop):
    return loop.json("jitter.json")


def test_every_tick_counts_in_the_histogram(jitter):
    assert jitter["thread"]["0"]["cycles"] >= TICKS


def test_it_wakes_as_well_as_cyclictest(jitter, loop):
    ours_us = jitter["berth"]["wake_up"]["max_us"]
    theirs_us = loop.json("cyclictest.json")["thread"]["0"]["max"]
    print(f"largest wake-up: {ours_us} us, cyclictest {theirs_us} us, ratio {ours_us / theirs_us:.2f}")
    assert ours_us <= 1.5 * theirs_us


def test_forces_are_fresh(jitter):
    assert 0 < jitter["berth"]["force_age"]["max_us"] < 2500


def test_the_age_of_the_force_is_that_at_its_use(jitter, log):
    """By the log, which has it at the tick's own time, and how much later the tick woke."""
    tick = log.tick
    ages_us = (tick["force_frame_age_ns"] + tick["woke_ns"] - tick["scheduled_ns"])[tick["force_samples"] > 0] / 1000
    ages_us = ages_us[:-1]  # the last tick has no wait behind it
    told = jitter["berth"]["force_age"]
    assert told["count"] == len(ages_us)
    assert (told["min_us"], told["max_us"]) == pytest.approx((ages_us.min(), ages_us.max()), abs=0.001)


def test_the_histogram_is_jitter_input_of_the_host_command(loop, jitter, tmp_path):
    late = f"{jitter['thread']['0']['min']} to {jitter['thread']['0']['max']} us"
    told = berth("eigen", "ess", "--jitter", loop.path("jitter.json"))
    assert late in told["varies"][0]
    assert told["growth_per_s"] != told["without"]["growth_per_s"]
    mapped = berth("map", "ess", "--vary", "elasticity", "--grid", "8x4", "--jitter", loop.path("jitter.json"), "--out",
                   tmp_path)
    assert late in mapped["varying"]["varies"][0]


# --- without real-time scheduling --------------------------------------------------------------------------------
@pytest.fixture
def without_realtime(guest):
    step = guest("without_realtime")
    step.check_done()
    return step


def test_without_real_time_scheduling_it_does_not_move(without_realtime):
    log = TargetLog(without_realtime.path("refused.ulg"))
    assert without_realtime.number("refused.exit_code") == 0, without_realtime.text("refused.stderr")
    assert "no real-time scheduling" in without_realtime.text("refused.stderr")
    assert "running" not in log.states()
    assert log.ulog.msg_info_dict["berth_without_realtime"] == "refused"


def test_told_to_move_all_the_same_it_says_so_in_the_log(without_realtime):
    log = TargetLog(without_realtime.path("allowed.ulg"))
    assert without_realtime.number("allowed.exit_code") == 0, without_realtime.text("allowed.stderr")
    assert "running" in log.states()
    assert log.ulog.msg_info_dict["berth_without_realtime"] == "allowed by option"


def test_without_real_time_scheduling_it_wakes_visibly_later(without_realtime, jitter):
    """Or the bounds above could not fail."""
    other = without_realtime.json("jitter.json")["berth"]
    for share in ("p50_us", "p99_us", "p99_9_us"):
        assert other["wake_up"][share] > 3 * jitter["berth"]["wake_up"][share]
    assert other["wake_up"]["max_us"] > 2 * jitter["berth"]["wake_up"]["max_us"]
