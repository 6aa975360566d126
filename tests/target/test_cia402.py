"""Profile "cia402" for 60 s over the kernel's CAN stack: the same motion as in simulation, and a bus that python canopen
understands."""

import subprocess

import can
import canopen
import numpy as np
import pytest
from conftest import BERTH, berth
from target_log import TargetLog

GROWTH_AGREES = 0.02  # of the growth rate in simulation
TICKS = 24_000
NODE = 1
COUNTS_PER_M = 1e8
SYNC, RPDO, TPDO, HEARTBEAT = 0x080, 0x200 + NODE, 0x180 + NODE, 0x700


@pytest.fixture
def loop(guest):
    step = guest("closed_loop_cia402")
    step.check_loop_done()
    return step


@pytest.fixture
def log(loop):
    return TargetLog(loop.path("run.ulg"))


@pytest.fixture
def frames(loop):
    """What candump saw on the rig's end of the bus."""
    return list(can.CanutilsLogReader(loop.path("robot.candump")))


def test_it_grows_as_in_simulation(loop, tmp_path):
    simulated = berth("run", "ess-cia402", "--out", tmp_path)["growth_per_s"]
    displayed = berth("summary", loop.path("run.ulg"))["growth_per_s"]
    assert displayed == pytest.approx(simulated, rel=GROWTH_AGREES)


def test_it_runs_to_the_end_and_replays(loop, log):
    assert log.states() == ["start", "ready", "running"]
    assert log.last_state() == "stopped"
    assert np.count_nonzero(log.before_end) == TICKS
    log.check_no_tick_is_missing()
    assert "0 not recorded, 0 frames not sent" in loop.text("loop.stdout")
    done = subprocess.run([BERTH, "replay", loop.path("run.ulg")], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def test_canopen_understands_the_bus(frames, log):
    network = canopen.Network()
    node = canopen.RemoteNode(NODE, canopen.ObjectDictionary())
    network.add_node(node)
    targets, actual = [], []
    network.subscribe(RPDO, lambda _, data, __: targets.append(int.from_bytes(data[2:6], "little", signed=True)))
    network.subscribe(TPDO, lambda _, data, __: actual.append(int.from_bytes(data[2:6], "little", signed=True)))
    states = []
    node.nmt.add_heartbeat_callback(states.append)
    for frame in frames:
        network.notify(frame.arbitration_id, frame.data, frame.timestamp)
    assert not node.emcy.log
    assert set(states) >= {0, 5}
    commanded = [round(x * COUNTS_PER_M) for x in log.tick["command_position_m"]]
    assert targets == commanded
    assert max(actual) - min(actual) > 0.005 * COUNTS_PER_M


def test_a_sync_in_each_tick_and_heartbeats_both_ways(frames, log):
    times_s = np.array([frame.timestamp for frame in frames if frame.arbitration_id == SYNC])
    assert len(times_s) == len(log.tick["index"])
    assert np.max(np.abs(np.diff(times_s) - 0.0025)) < 0.001
    for node in (NODE, 127):
        beats_s = [frame.timestamp for frame in frames if frame.arbitration_id == HEARTBEAT + node]
        assert np.median(np.diff(beats_s)) == pytest.approx(0.1, abs=0.005)


def test_the_sync_is_on_the_wire_soon_after_the_tick(loop):
    jitter = loop.json("jitter.json")["berth"]
    assert jitter["overruns"] == 0
    assert jitter["wake_up"]["count"] >= TICKS
    assert jitter["tick_to_wire"]["count"] >= TICKS - 10
    assert jitter["execution"]["p99_9_us"] < 75  # two frames a tick instead of one
    assert jitter["tick_to_wire"]["max_us"] < 500
