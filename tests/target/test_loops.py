"""The loop to its end over the kernel's CAN stack, for each rig of the table: the same motion as in simulation, every tick
recorded and in time, a log that replays, and a bus that other people's tools understand.

To add a rig: a step in tests/target/steps that runs it, its name in STEPS of conftest.py, and a row here.
"""

from dataclasses import dataclass

import can
import canopen
import cantools
import numpy as np
import pytest
from conftest import CLOSED_LOOP_s, ROOT, berth
from target_log import TargetLog, state_names

GROWTH_AGREES = 0.02  # of the growth rate in simulation
WIRE_us = 500  # from the tick to the last setpoint on the wire
DBC = ROOT / "firmware" / "can" / "berth.dbc"


@dataclass(frozen=True)
class Loop:
    """A step that runs a rig. `execution_us`: of a tick, p99.9; `moves`: the checks of its motion; `speaks`: those of its
    bus and of what else only this rig shows."""

    step: str
    rig: str
    ticks: int
    execution_us: float
    moves: tuple = ()
    speaks: tuple = ()


@dataclass
class Ran:
    """What the step has left, and the log of the loop in it."""

    loop: Loop
    step: object
    log: TargetLog

    def timing(self):
        return self.step.json("jitter.json")["berth"]

    def candump(self, name):
        """(id, data) of each line of candump -L text."""
        frames = (line.split()[2].split("#") for line in self.step.lines(name))
        return [(int(identifier, 16), bytes.fromhex(data)) for identifier, data in frames]

    def sends(self):
        """In which ticks the loop sends setpoints."""
        silent = [number for number, name in state_names().items() if name in ("start", "stopped")]
        return ~np.isin(self.log.tick["state"], silent)


# --- of every loop ------------------------------------------------------------------------------------------------
def it_runs_to_the_end_and_records_every_tick(ran, tmp_path):
    ran.log.check_ran_to_the_end(ran.loop.ticks)
    assert ran.log.last_state() == "stopped"
    assert "0 not recorded, 0 frames not sent" in ran.step.text("loop.stdout")


def its_log_replays_bit_for_bit_on_the_host(ran, tmp_path):
    ran.step.check_replays("run.ulg")


def every_tick_is_in_time(ran, tmp_path):
    timing = ran.timing()
    print(f"a tick of {ran.loop.rig}: p99.9 {timing['execution']['p99_9_us']} us")
    assert timing["overruns"] == 0
    assert timing["wake_up"]["count"] >= ran.loop.ticks
    assert timing["execution"]["p99_9_us"] < ran.loop.execution_us


COMMON = (it_runs_to_the_end_and_records_every_tick, its_log_replays_bit_for_bit_on_the_host, every_tick_is_in_time)


# --- the motion ---------------------------------------------------------------------------------------------------
def it_grows_as_in_simulation(ran, tmp_path):
    simulated = berth("run", ran.loop.rig, "--out", tmp_path)["growth_per_s"]
    displayed = berth("summary", ran.step.path("run.ulg"))["growth_per_s"]
    assert displayed == pytest.approx(simulated, rel=GROWTH_AGREES)


def the_arm_goes_where_it_goes_in_simulation(ran, tmp_path):
    ran.log.check_arm_moves_as(TargetLog(berth("run", ran.loop.rig, "--out", tmp_path)["log"]))


def it_meets_the_generator_when_the_grip_closes(ran, tmp_path):
    here, there = ran.log.tick["force_N"], TargetLog(berth("run", ran.loop.rig, "--out", tmp_path)["log"]).tick["force_N"]
    grip_tick = 8_000  # run.grip_close_s
    assert not here[:grip_tick].any()
    assert np.abs(here).max() == pytest.approx(np.abs(there).max(), rel=0.02)
    assert np.abs(there).max() > 5


SIDES = ("y_{}_m", "rz_{}_rad")


def every_axis_is_told_and_heard(ran, tmp_path):
    side = ran.log.topic("side")
    for name in SIDES:
        assert np.ptp(side[name.format("command")]) > 1e-3
        assert np.ptp(side[name.format("robot")]) > 1e-3
    assert np.ptp(side["y_force_N"]) > 1 and np.ptp(side["rz_torque_N_m"]) > 0.1


# --- the wire, by can-utils, cantools and python canopen ----------------------------------------------------------
RECEIVED, SENT = 0, 1


def frames_in_log(log, bus, direction):
    """(id, data) of each frame that the loop took or sent."""
    frame = log.topic("can_frame")
    chosen = (frame["bus"] == bus) & (frame["direction"] == direction) & (frame["flags"] == 0)
    return [(int(identifier), int(data).to_bytes(8, "little")[:length]) for identifier, data, length in
            zip(frame["id"][chosen], frame["data"][chosen], frame["length"][chosen], strict=True)]


def frame_id(message):
    return cantools.database.load_file(DBC).get_message_by_name(message).frame_id


def candump_saw_every_setpoint_that_the_loop_logged(ran, tmp_path):
    setpoint = frame_id("setpoint")
    seen = [frame for frame in ran.candump("robot.candump") if frame[0] == setpoint]
    assert seen == [frame for frame in frames_in_log(ran.log, 0, SENT) if frame[0] == setpoint]


def the_loop_took_every_force_that_candump_saw(ran, tmp_path):
    force = frame_id("force")
    seen = [frame for frame in ran.candump("sensor.candump") if frame[0] == force]
    taken = [frame for frame in frames_in_log(ran.log, 1, RECEIVED) if frame[0] == force]
    assert len(taken) >= ran.loop.ticks - 10
    first = seen.index(taken[0])
    assert seen[first : first + len(taken)] == taken


def check_setpoints(ran, message, signal, commanded):
    """cantools decodes from candump's text what the loop's log has as commanded."""
    about = cantools.database.load_file(DBC).get_message_by_name(message)
    seen = np.array([about.decode(data)[signal] for identifier, data in ran.candump("robot.candump")
                     if identifier == about.frame_id])
    np.testing.assert_allclose(seen, commanded[ran.sends()], rtol=0, atol=1e-11)


def cantools_decodes_the_positions_that_were_commanded(ran, tmp_path):
    check_setpoints(ran, "setpoint", "position_m", ran.log.tick["command_position_m"])


def cantools_decodes_the_setpoints_of_every_axis(ran, tmp_path):
    side = ran.log.topic("side")
    check_setpoints(ran, "setpoint_y", "position_m", side["y_command_m"])
    check_setpoints(ran, "setpoint_rz", "angle_rad", side["rz_command_rad"])


def setpoints_reach_the_wire_soon(ran, tmp_path):
    wire = ran.timing()["tick_to_wire"]
    assert wire["count"] >= ran.loop.ticks - 10 and wire["max_us"] < WIRE_us


def its_log_says_who_stamps_the_frames(ran, tmp_path):
    for bus in ("robot", "sensor"):
        assert ran.log.ulog.msg_info_dict[f"berth_{bus}_stamps"] == "software"


NODE, COUNTS_PER_M = 1, 1e8
SYNC, RPDO, TPDO, HEARTBEAT = 0x080, 0x200 + NODE, 0x180 + NODE, 0x700


def canopen_frames(ran):
    """What candump saw on the rig's end of the bus."""
    return list(can.CanutilsLogReader(ran.step.path("robot.candump")))


def canopen_understands_the_bus(ran, tmp_path):
    network = canopen.Network()
    node = canopen.RemoteNode(NODE, canopen.ObjectDictionary())
    network.add_node(node)
    targets, actual, states = [], [], []
    network.subscribe(RPDO, lambda _, data, __: targets.append(int.from_bytes(data[2:6], "little", signed=True)))
    network.subscribe(TPDO, lambda _, data, __: actual.append(int.from_bytes(data[2:6], "little", signed=True)))
    node.nmt.add_heartbeat_callback(states.append)
    for frame in canopen_frames(ran):
        network.notify(frame.arbitration_id, frame.data, frame.timestamp)
    assert not node.emcy.log
    assert set(states) >= {0, 5}
    assert targets == [round(x * COUNTS_PER_M) for x in ran.log.tick["command_position_m"]]
    assert max(actual) - min(actual) > 0.005 * COUNTS_PER_M


def there_is_a_sync_in_each_tick_and_heartbeats_both_ways(ran, tmp_path):
    frames = canopen_frames(ran)
    times_s = np.array([frame.timestamp for frame in frames if frame.arbitration_id == SYNC])
    assert len(times_s) == len(ran.log.tick["index"])
    assert np.max(np.abs(np.diff(times_s) - 0.0025)) < 0.001
    for node in (NODE, 127):
        beats_s = [frame.timestamp for frame in frames if frame.arbitration_id == HEARTBEAT + node]
        assert np.median(np.diff(beats_s)) == pytest.approx(0.1, abs=0.005)


LOOPS = [
    Loop("closed_loop", "ess", 400 * CLOSED_LOOP_s, 50, (it_grows_as_in_simulation,),
         (candump_saw_every_setpoint_that_the_loop_logged, the_loop_took_every_force_that_candump_saw,
          cantools_decodes_the_positions_that_were_commanded, setpoints_reach_the_wire_soon,
          its_log_says_who_stamps_the_frames)),
    # Two frames a tick instead of one.
    Loop("closed_loop_cia402", "ess-cia402", 24_000, 75, (it_grows_as_in_simulation,),
         (canopen_understands_the_bus, there_is_a_sync_in_each_tick_and_heartbeats_both_ways, setpoints_reach_the_wire_soon)),
    # A whole arm on its satellite approaches, grips and berths the generator.
    Loop("berthing", "ess-berthing", 28_000, 100, (the_arm_goes_where_it_goes_in_simulation,
                                                   it_meets_the_generator_when_the_grip_closes)),
    # An arm, three axes of the robot, and twelve frames a tick.
    Loop("arm_pose", "ess-pose", 12_000, 150, (the_arm_goes_where_it_goes_in_simulation, every_axis_is_told_and_heard),
         (cantools_decodes_the_setpoints_of_every_axis,)),
]
ROWS = [pytest.param(loop, check, id=f"{loop.step}: {check.__name__}") for loop in LOOPS
        for check in (*COMMON, *loop.moves, *loop.speaks)]


@pytest.mark.parametrize("loop, check", ROWS)
def test_loop(loop, check, guest, tmp_path):
    step = guest(loop.step)
    step.check_loop_done()
    check(Ran(loop, step, TargetLog(step.path("run.ulg"))), tmp_path)
