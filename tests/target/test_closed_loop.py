"""The reference case for 60 s over the kernel's CAN stack, under load: the same motion as in simulation, seen by
other people's tools as well, and in time."""

import subprocess

import cantools
import numpy as np
import pytest
from conftest import BERTH, ROOT, berth
from target_log import TargetLog, state_names

TICKS = 24_000
GROWTH_AGREES = 0.02  # of the growth rate in simulation
RECEIVED, SENT = 0, 1


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


@pytest.fixture(scope="module")
def dbc():
    return cantools.database.load_file(ROOT / "firmware" / "can" / "berth.dbc")


def candump(path):
    """(id, data) of each line of candump -L text."""
    frames = (line.split()[2].split("#") for line in path.read_text().splitlines())
    return [(int(identifier, 16), bytes.fromhex(data)) for identifier, data in frames]


def frames_in_log(log, bus, direction):
    """(id, data) of each frame that the loop took or sent."""
    frame = log.topic("can_frame")
    chosen = (frame["bus"] == bus) & (frame["direction"] == direction) & (frame["flags"] == 0)
    return [(int(identifier), int(data).to_bytes(8, "little")[:length]) for identifier, data, length in
            zip(frame["id"][chosen], frame["data"][chosen], frame["length"][chosen], strict=True)]


# --- the motion --------------------------------------------------------------------------------------------------
def test_it_grows_as_in_simulation(loop, tmp_path):
    simulated = berth("run", "ess", "--out", tmp_path)["growth_per_s"]
    displayed = berth("summary", loop.path("run.ulg"))["growth_per_s"]
    assert displayed == pytest.approx(simulated, rel=GROWTH_AGREES)


def test_it_runs_to_the_end_and_records_every_tick(loop, log):
    assert log.states() == ["start", "ready", "running"]
    assert log.last_state() == "stopped"
    assert np.count_nonzero(log.before_end) == TICKS
    log.check_no_tick_is_missing()
    assert "0 not recorded, 0 frames not sent" in loop.text("loop.stdout")


def test_the_log_says_who_stamps_the_frames(log):
    for bus in ("robot", "sensor"):
        assert log.ulog.msg_info_dict[f"berth_{bus}_stamps"] == "software"


def test_the_log_replays_bit_for_bit(loop):
    done = subprocess.run([BERTH, "replay", loop.path("run.ulg")], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


# --- the wire, by can-utils and cantools -------------------------------------------------------------------------
def test_candump_saw_every_setpoint_that_the_loop_logged(loop, log, dbc):
    setpoint = dbc.get_message_by_name("setpoint").frame_id
    seen = [frame for frame in candump(loop.path("robot.candump")) if frame[0] == setpoint]
    assert seen == [frame for frame in frames_in_log(log, 0, SENT) if frame[0] == setpoint]


def test_the_loop_took_every_force_that_candump_saw(loop, log, dbc):
    force = dbc.get_message_by_name("force").frame_id
    seen = [frame for frame in candump(loop.path("sensor.candump")) if frame[0] == force]
    taken = [frame for frame in frames_in_log(log, 1, RECEIVED) if frame[0] == force]
    assert len(taken) >= TICKS - 10
    first = seen.index(taken[0])
    assert seen[first : first + len(taken)] == taken


def test_cantools_decodes_the_positions_that_were_commanded(loop, log, dbc):
    message = dbc.get_message_by_name("setpoint")
    seen = np.array([message.decode(data)["position_m"] for identifier, data in candump(loop.path("robot.candump"))
                     if identifier == message.frame_id])
    silent = [number for number, name in state_names().items() if name in ("start", "stopped")]
    sends = ~np.isin(log.tick["state"], silent)
    np.testing.assert_allclose(seen, log.tick["command_position_m"][sends], rtol=0, atol=1e-11)


# --- time ---------------------------------------------------------------------------------------------------------
def test_no_overruns_under_load(jitter, log):
    assert jitter["berth"]["overruns"] == 0
    assert jitter["thread"]["0"]["cycles"] >= TICKS
    assert log.missed_ticks() == 0


def test_it_wakes_as_well_as_cyclictest(jitter, loop):
    ours_us = jitter["berth"]["wake_up"]["max_us"]
    theirs_us = loop.json("cyclictest.json")["thread"]["0"]["max"]
    print(f"largest wake-up: {ours_us} us, cyclictest {theirs_us} us, ratio {ours_us / theirs_us:.2f}")
    assert ours_us <= 1.5 * theirs_us


def test_a_tick_takes_less_than_50_us(jitter):
    assert jitter["berth"]["execution"]["p99_9_us"] < 50


def test_setpoints_reach_the_wire_and_forces_are_fresh(jitter):
    assert jitter["berth"]["tick_to_wire"]["count"] >= TICKS - 10
    assert jitter["berth"]["tick_to_wire"]["max_us"] < 500
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
