"""tests/scenarios on real buses and lines: the documented state, and nothing recorded is lost."""

import re
import subprocess

import numpy as np
import pytest
from conftest import ROOT, SCENARIOS
from target_log import TargetLog

PERIOD_ns = 2_500_000
ROBOT, SENSOR = 0, 1
CAN_ERR_BUSOFF, CAN_ERR_RESTARTED = 0x040, 0x100  # linux/can/error.h


@pytest.fixture
def play(guest):
    """A function NAME -> (what the scenario has left, its log)."""
    def played(name):
        step = guest(name)
        step.check_done()
        return step, TargetLog(step.path("run.ulg"))
    return played


@pytest.mark.parametrize("name", SCENARIOS)
def test_a_scenario_leads_to_the_documented_state(play, name):
    scenario = SCENARIOS[name]
    step, log = play(name)
    said = step.text("loop.stdout") + step.text("loop.stderr")
    assert log.states() == scenario["states"], said
    assert log.stop_cause() == scenario["stop_cause"], said
    fewest, most = scenario.get("missed_ticks", [0, 0])
    assert fewest <= log.missed_ticks() <= most
    assert step.number("loop.exit_code") == scenario.get("exit_code", 0), said
    assert scenario.get("prints", "") in said


@pytest.mark.parametrize("name", [name for name in SCENARIOS if "log" not in SCENARIOS[name]])
def test_nothing_recorded_is_lost(play, name):
    step, log = play(name)
    log.check_no_tick_is_missing()
    assert log.last_state() == "stopped"
    assert "0 not recorded" in step.text("loop.stdout")
    command = [ROOT / "build" / "berth", "replay", step.path("run.ulg")]
    replay = subprocess.run(command, capture_output=True, text=True, check=False)
    assert replay.returncode == 0, replay.stdout + replay.stderr


@pytest.mark.parametrize("name", [name for name in SCENARIOS if len(SCENARIOS[name]["events"]) == 2])
def test_the_fault_line_shows_outside_whether_it_is_in_fault(play, name):
    """0.5 s after the first event, and not before it."""
    step, _ = play(name)
    is_fault = SCENARIOS[name]["states"][-1] == "fault"
    assert [line[-1] for line in step.lines("events")] == ["0", "1" if is_fault else "0"]


@pytest.mark.parametrize("bus", [ROBOT, SENSOR])
def test_frames_pass_again_after_the_kernel_has_restarted_the_controller(play, bus):
    """After restart-ms; the states above say that the loop stays in fault all the same."""
    _, log = play(["robot_bus_off", "sensor_bus_off"][bus])
    frame = log.topic("can_frame")
    here = (frame["bus"] == bus) & (frame["direction"] == 0)
    is_error = here & (frame["flags"] != 0)
    [off_ns] = frame["time_ns"][is_error & (frame["id"] == CAN_ERR_BUSOFF)]
    [restarted_ns] = frame["time_ns"][is_error & (frame["id"] == CAN_ERR_RESTARTED)]
    assert 100e6 <= restarted_ns - off_ns < 110e6
    later = here & (frame["flags"] == 0) & (frame["time_ns"] > restarted_ns)
    assert np.count_nonzero(later) > 0.9 * (log.tick["scheduled_ns"][-1] - restarted_ns) / PERIOD_ns


def test_frames_that_are_not_for_the_loop_never_reach_it(play):
    _, log = play("foreign_frames")
    assert log.tick["rejected_frames"][-1] == log.tick["lost_frames"][-1] == 0
    assert set(log.topic("can_frame")["id"]) == {0x10, 0x11, 0x20, 0x30, 0x40}


def test_a_full_disk_cuts_the_log_and_not_the_loop(play):
    """What is missing is told, to the tick."""
    step, log = play("disk_full")
    [ticks] = re.findall(r"timing: (\d+) ticks, 0 overruns", step.text("loop.stdout"))
    [dropped] = re.findall(r"(\d+) records dropped \(No space left on device\)", step.text("loop.stderr"))
    assert int(ticks) >= 1200
    assert 0 < len(log.tick["index"]) == int(ticks) - int(dropped) < int(ticks)


@pytest.mark.parametrize("name", ["emergency_stop", "emergency_stop_tapped"])
def test_the_first_tick_after_the_edge_is_in_fault(play, name):
    """By the kernel's time stamp of the edge."""
    _, log = play(name)
    edges = log.topic("line")
    assert list(edges["level"]) == [1, 0]
    pressed_ns = edges["time_ns"][0]
    tick = log.tick
    before = tick["woke_ns"] < pressed_ns
    assert np.all(tick["emergency_stop"][before] == 0)
    [first] = np.flatnonzero(~before)[:1]
    assert tick["emergency_stop"][first] == 1
    assert tick["state"][first] == 4
    assert tick["scheduled_ns"][first] - pressed_ns < PERIOD_ns


def test_the_loop_keeps_its_own_time_when_the_clock_is_set(play):
    _, log = play("clock_step")
    lateness_us = (log.tick["woke_ns"] - log.tick["scheduled_ns"]) / 1000
    assert np.all(np.diff(log.tick["scheduled_ns"]) == PERIOD_ns)
    assert np.max(lateness_us) < 1000
    ages_ms = log.tick["force_frame_age_ns"][100:] / 1e6
    assert np.all((ages_ms >= 0) & (ages_ms < 10))
