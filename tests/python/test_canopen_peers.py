"""Profile "cia402" against other people's CANopen: python `canopen` as the drive that our firmware commands, as the
master that commands our simulated drive, and as a listener to a run's recorded bus."""

import struct
import threading
import time
from pathlib import Path

import can
import canopen
import pytest
from canopen.profiles.p402 import BaseNode402
from conftest import command, one_json_object, run_json, settings, topic, without_checksums
from peer_bus import PeerBus
from servo_drive import COUNTS_PER_M, MASTER, NMT, NODE, SYNC, ServoDrive, servo_dictionary

PROFILE = {"robot_channel.profile": "cia402", "run.release_s": 0.3}
START, READY, RUNNING, HOLDING, FAULT, STOPPED = range(6)
ROBOT_FAULT = 7  # stop cause
SDO_ABORT, NO_ANSWER, WRONG_VALUE, EMERGENCY, HEARTBEAT, NOT_OPERATIONAL, IN_FAULT = range(1, 8)  # trouble
STRANGE_ANSWER, NO_PERIOD, UNWATCHED = range(10, 13)
REQUEST_NONE, REQUEST_RUN, REQUEST_RESET = 0, 2, 3


@pytest.fixture
def loop():
    """The firmware as master."""
    bus = PeerBus("loop", "ess", *(f"{key}={value}" for key, value in PROFILE.items()))
    yield bus
    bus.close()


def is_in(bus, state):
    return lambda: bus.state[0] == state


def running(bus, **changed):
    drive = ServoDrive(bus, **changed)
    bus.request = REQUEST_RUN
    bus.run_until(is_in(bus, RUNNING))
    return drive


def requests_in_flight(bus):
    """The largest number of SDO requests without an answer at one time."""
    most, open_requests = 0, 0
    events = [(tick, 0, identifier) for tick, identifier, _ in bus.heard]
    events += [(tick, 1, identifier) for tick, identifier, _ in bus.sent]
    for _, _, identifier in sorted(events):
        open_requests += (identifier == 0x600 + NODE) - (identifier == 0x580 + NODE)
        most = max(most, open_requests)
    return most


def test_the_firmware_sets_up_a_drive_of_other_people_and_moves_it(loop):
    drive = running(loop)
    node = drive.node
    rpdo, tpdo = node.rpdo[1], node.tpdo[1]
    assert [variable.index for variable in rpdo] == [0x6040, 0x607A]
    assert [variable.index for variable in tpdo] == [0x6041, 0x6064]
    assert rpdo.enabled and tpdo.enabled
    assert (rpdo.trans_type, tpdo.trans_type) == (1, 1)
    assert (rpdo.cob_id, tpdo.cob_id) == (0x200 + NODE, 0x180 + NODE)
    assert node.sdo[0x60C2][1].raw * 10.0 ** node.sdo[0x60C2][2].raw == pytest.approx(2.5e-3)
    assert node.sdo[0x1006].raw == 2500
    assert node.sdo[0x6060].raw == 8
    assert node.sdo[0x1017].raw == 100
    assert node.sdo[0x1016][1].raw == MASTER << 16 | 300
    assert requests_in_flight(loop) == 1
    assert drive.states == ["SWITCH ON DISABLED", "READY TO SWITCH ON", "SWITCHED ON", "OPERATION ENABLED"]

    commands_m = {}
    for _ in range(800):
        loop.tick()
        commands_m[loop.ticks - 1] = struct.unpack("<i", loop.state[4:])[0] * 1e-9
    assert loop.state[0] == RUNNING
    assert max(commands_m.values()) - min(commands_m.values()) > 0.01
    moved = dict(drive.targets)
    late = [abs(moved[tick] / COUNTS_PER_M - commands_m[tick - 1]) for tick in commands_m if tick - 1 in commands_m]
    assert max(late) < 6e-9  # a setpoint acts at the SYNC of the next tick, rounded to a count
    syncs = [tick for tick, identifier, data in loop.heard if identifier == SYNC and not data]
    assert syncs == list(range(loop.ticks))
    beats = drive.heartbeats
    assert {after - before for before, after in zip(beats, beats[1:])} == {40}  # 100 ms


def stops(loop, trouble, ticks_max=400):
    loop.run_until(is_in(loop, FAULT), ticks_max)
    assert (loop.state[1], loop.state[2]) == (ROBOT_FAULT, trouble)


def recovers(loop, drive):
    loop.request = REQUEST_RESET
    loop.run_until(is_in(loop, READY))
    loop.request = REQUEST_RUN
    loop.run_until(is_in(loop, RUNNING))
    assert drive.state == "OPERATION ENABLED"


def test_an_emergency_message_stops_the_loop_until_it_is_reset(loop):
    drive = running(loop)
    drive.node.emcy.send(0x2310, 0x03)
    stops(loop, EMERGENCY, 3)
    loop.run(400)
    assert loop.state[0] == FAULT
    drive.node.emcy.reset()
    recovers(loop, drive)


def test_a_missing_heartbeat_stops_the_loop(loop):
    drive = running(loop)
    beat_at = max(tick for tick, identifier, _ in loop.sent if identifier == 0x700 + NODE)
    drive.node.nmt.stop_heartbeat()
    stops(loop, HEARTBEAT)
    assert 120 <= loop.ticks - beat_at <= 124  # 300 ms
    recovers(loop, drive)


def test_a_drive_in_fault_stops_the_loop_and_is_reset_with_it(loop):
    drive = running(loop)
    drive.enter("FAULT")
    stops(loop, IN_FAULT, 4)
    loop.run(400)
    assert drive.state == "FAULT" and loop.state[0] == FAULT
    recovers(loop, drive)


def test_a_drive_that_reboots_is_set_up_again_when_a_person_says_so(loop):
    drive = running(loop)
    drive.enter("SWITCH ON DISABLED")
    drive.boot()
    loop.run_until(is_in(loop, FAULT), 4)
    assert loop.state[1] == ROBOT_FAULT
    loop.run(400)
    assert drive.node.nmt.state == "PRE-OPERATIONAL"
    recovers(loop, drive)


@pytest.mark.parametrize("index, value, trouble", [("0x60C2", None, SDO_ABORT), ("0x6502", 0, WRONG_VALUE),
                                                   ("0x1000", 0x00020191, WRONG_VALUE)])
def test_a_drive_that_cannot_do_it_is_refused(loop, index, value, trouble):
    drive = ServoDrive(loop, **({} if value is None else {index: value}))
    if value is None:
        del drive.node.object_dictionary[int(index, 16)]
    stops(loop, trouble, 2000)
    assert "OPERATION ENABLED" not in drive.states


def test_an_object_that_is_only_offered_may_be_missing(loop):
    drive = ServoDrive(loop)
    del drive.node.object_dictionary[0x1006]
    loop.run_until(is_in(loop, READY))


class DriveWithFixedIndex(ServoDrive):
    """Takes one index of the interpolation period, as drives do that count in ms, or in tenths of them."""

    def __init__(self, bus, index):
        super().__init__(bus)
        self.node.object_dictionary[0x60C2][2].default = index
        self.index = index
        self.node.add_write_callback(self.refuse_other_index)

    def refuse_other_index(self, index, od, data, **_):
        if (index, od.subindex) == (0x60C2, 2) and int.from_bytes(data, "little", signed=True) != self.index:
            raise canopen.SdoAbortedError(0x06090030)


# Loop rate, index that the drive takes, trouble.
PERIODS = [(500, -3, None), (250, -3, None), (100, -3, None), (50, -3, None), (400, -4, None), (100, -4, None),
           (100, -2, None), (400, -3, NO_PERIOD), (10, -4, NO_PERIOD)]


@pytest.mark.parametrize("rate_Hz, index, trouble", PERIODS)
def test_a_drive_that_takes_one_unit_of_the_period(rate_Hz, index, trouble):
    slow = {"robot.dead_time_ms": 300, "sensor.delay_ms": 100} if rate_Hz < 250 else {}
    rig = {**PROFILE, "loop.rate_Hz": rate_Hz, **slow}
    bus = PeerBus("loop", "ess", *(f"{key}={value}" for key, value in rig.items()), period_s=1 / rate_Hz)
    drive = DriveWithFixedIndex(bus, index)
    bus.request = REQUEST_RUN
    if trouble is None:
        bus.run_until(is_in(bus, RUNNING))
        period = drive.node.sdo[0x60C2]
        assert period[1].raw * 10.0 ** period[2].raw == pytest.approx(1 / rate_Hz)
    else:
        stops(bus, trouble, 2000)
    bus.close()


@pytest.mark.parametrize("command", [0x43, 0x42, 0x41])
def test_a_read_is_answered_with_four_bytes_or_without_a_size_or_in_segments(loop, command):
    send = loop.send

    def changed(message, *rest):
        data = message.data
        if message.arbitration_id == 0x580 + NODE and data[0] & 0xE0 == 0x40:
            size = 4 - (data[0] >> 2 & 3)
            changed.segment = bytes([0x01 | (7 - size) << 1]) + bytes(data[4:4 + size]).ljust(7, b"\0")
            data[0] = command
            if command == 0x41:
                data[4:8] = struct.pack("<I", size)
        send(message, *rest)

    loop.send = changed
    drive = ServoDrive(loop)
    if command == 0x41:  # canopen's server has sent all of it already, so its answer to the second request is left out
        loop.network.unsubscribe(0x600 + NODE, drive.node.sdo.on_request)

        def answer(identifier, data, when):
            if data[0] == 0x60:
                send(can.Message(arbitration_id=0x580 + NODE, data=changed.segment, is_extended_id=False))
            else:
                drive.node.sdo.on_request(identifier, data, when)
        loop.network.subscribe(0x600 + NODE, answer)
    loop.request = REQUEST_RUN
    loop.run_until(is_in(loop, RUNNING))


def test_an_answer_that_is_none_of_the_standard_is_told_as_such(loop):
    send = loop.send

    def changed(message, *rest):
        if message.arbitration_id == 0x580 + NODE and message.data[0] == 0x60:
            message.data[0] = 0xE0
        send(message, *rest)

    loop.send = changed
    ServoDrive(loop)
    stops(loop, STRANGE_ANSWER, 2000)


@pytest.mark.parametrize("is_demanded", [True, False])
def test_a_drive_that_does_not_watch_its_master(is_demanded):
    rig = {**PROFILE, "cia402.must_watch_loop": str(is_demanded).lower()}
    bus = PeerBus("loop", "ess", *(f"{key}={value}" for key, value in rig.items()))
    drive = ServoDrive(bus)
    del drive.node.object_dictionary[0x1016]
    bus.request = REQUEST_RUN
    if is_demanded:
        stops(bus, UNWATCHED, 2000)
    else:
        bus.run_until(is_in(bus, RUNNING))
    bus.close()


def test_without_an_answer_it_asks_again_and_then_gives_up(loop):
    drive = ServoDrive(loop)
    loop.run(10)
    loop.network.unsubscribe(0x600 + NODE, drive.node.sdo.on_request)
    since = len(loop.heard)
    stops(loop, NO_ANSWER)
    requests = [data for _, identifier, data in loop.heard[since:] if identifier == 0x600 + NODE]
    assert requests[-1][0] == 0x80 and struct.unpack("<I", requests[-1][4:])[0] == 0x05040000
    assert 2 <= len(requests[:-1]) <= 3 and len(set(requests[:-1])) == 1


@pytest.fixture
def rig():
    """The simulated drive, with a thread that lets time pass while canopen's master waits: SYNC in each tick."""
    bus = PeerBus("drive", "ess", *(f"{key}={value}" for key, value in PROFILE.items()))
    stop, positions_m = threading.Event(), []

    def pump():
        while not stop.is_set():
            bus.network.sync.transmit()
            bus.tick()
            positions_m.append(struct.unpack("<d", bus.state)[0])

    bus.positions_m = positions_m
    thread = threading.Thread(target=pump)
    thread.start()
    yield bus
    stop.set()
    thread.join()
    bus.close()


def wait_ticks(rig, ticks):
    end = rig.ticks + ticks
    while rig.ticks < end:
        time.sleep(0.001)


def commanded(rig):
    """Our drive as canopen's master of CiA 402 sees it, set up by canopen."""
    node = BaseNode402(NODE, servo_dictionary(NODE))
    rig.network.add_node(node)
    node.nmt.state = "PRE-OPERATIONAL"
    assert node.sdo[0x1000].raw & 0xFFFF == 402
    node.sdo[0x6060].raw = 8
    node.sdo[0x60C2][1].raw, node.sdo[0x60C2][2].raw = 25, -4
    for pdo, cob_id, indices in ((node.rpdo[1], 0x200 + NODE, (0x6040, 0x607A)),
                                 (node.tpdo[1], 0x180 + NODE, (0x6041, 0x6064))):
        pdo.cob_id, pdo.enabled, pdo.trans_type = cob_id, True, 1
        pdo.clear()
        for index in indices:
            pdo.add_variable(index)
        pdo.save()
    node.setup_402_state_machine()
    node.rpdo[1][0x607A].raw = round(0.01 * COUNTS_PER_M)
    node.nmt.state = "OPERATIONAL"
    node.rpdo[1].start(rig.period_s)
    wait_ticks(rig, 4)
    return node


def test_our_drive_obeys_a_master_of_other_people(rig):
    node = commanded(rig)
    assert node.state == "SWITCH ON DISABLED"
    for state in ("READY TO SWITCH ON", "SWITCHED ON", "OPERATION ENABLED", "SWITCHED ON", "READY TO SWITCH ON",
                  "OPERATION ENABLED"):
        node.state = state
        assert node.state == state
    assert node.op_mode == "CYCLIC SYNCHRONOUS POSITION"
    node.rpdo[1][0x607A].raw = round(0.011 * COUNTS_PER_M)
    wait_ticks(rig, 40)
    assert rig.positions_m[-1] == pytest.approx(0.011, abs=1e-9)
    assert node.tpdo[1][0x6064].raw == round(0.011 * COUNTS_PER_M)
    node.state = "SWITCH ON DISABLED"
    node.rpdo[1][0x607A].raw = round(0.012 * COUNTS_PER_M)
    wait_ticks(rig, 40)
    assert rig.positions_m[-1] == pytest.approx(0.011, abs=1e-9)  # without torque it stays


def test_our_drive_tells_its_fault_and_is_reset_by_that_master(rig):
    node = commanded(rig)
    node.state = "OPERATION ENABLED"
    rig.request = 1  # an error, as long as it is there
    emergency = node.emcy.wait(timeout=5)
    assert emergency.code == 0x2310
    wait_ticks(rig, 4)
    assert node.state == "FAULT"
    node.controlword = 0x80
    wait_ticks(rig, 10)
    assert node.state == "FAULT"  # the error is still there
    rig.request = 0
    wait_ticks(rig, 4)
    node.controlword = 0
    wait_ticks(rig, 4)
    node.controlword = 0x80
    wait_ticks(rig, 10)
    assert node.state == "SWITCH ON DISABLED"


def test_our_drive_misses_the_heartbeat_of_its_master(rig):
    node = commanded(rig)
    node.sdo[0x1016][1].raw = MASTER << 16 | 100
    rig.network.send_message(0x700 + MASTER, [5])
    emergency = node.emcy.wait(timeout=5)
    assert emergency.code == 0x8130


@pytest.mark.parametrize("index, subindex, value, code", [(0x1000, 0, b"\0\0\0\0", 0x06010002),
                                                          (0x2000, 0, b"\0", 0x06020000),
                                                          (0x1016, 9, b"\0\0\0\0", 0x06090011),
                                                          (0x6060, 0, b"\x01", 0x06090030),
                                                          (0x6060, 0, b"\x08\0", 0x06070010)])
def test_our_drive_refuses_with_the_codes_of_the_standard(rig, index, subindex, value, code):
    node = BaseNode402(NODE, servo_dictionary(NODE))
    rig.network.add_node(node)
    with pytest.raises(canopen.SdoAbortedError) as refused:
        node.sdo.download(index, subindex, value)
    assert refused.value.code == code


def test_a_run_is_understood_by_a_listener(tmp_path):
    """The recorded bus of a run, with the mapping that the set-up on it has made."""
    result = run_json("ess", tmp_path, *settings({**PROFILE, "run.duration_s": 2}))
    ticks = topic(result["log"])
    network, node = canopen.Network(), canopen.RemoteNode(NODE, servo_dictionary(NODE))
    network.add_node(node)
    for pdo, cob_id, indices in ((node.rpdo[1], 0x200 + NODE, (0x6040, 0x607A)),
                                 (node.tpdo[1], 0x180 + NODE, (0x6041, 0x6064))):
        pdo.cob_id, pdo.enabled = cob_id, True
        for index in indices:
            pdo.add_variable(index)
        pdo.subscribe()
    seen = {"sync": 0, "nmt": [], "target": [], "actual": []}
    node.rpdo[1].add_callback(lambda pdo: seen["target"].append(pdo[0x607A].raw))
    node.tpdo[1].add_callback(lambda pdo: seen["actual"].append(pdo[0x6064].raw))
    for message in can.CanutilsLogReader(tmp_path / "ess.robot.candump.log"):
        seen["sync"] += message.arbitration_id == SYNC
        if message.arbitration_id == NMT:
            seen["nmt"].append(bytes(message.data))
        network.notify(message.arbitration_id, message.data, message.timestamp)
    assert seen["sync"] == len(ticks["index"]) == len(seen["target"])
    assert seen["nmt"] == [bytes([0x82, NODE]), bytes([0x01, NODE])]
    assert node.nmt.state == "OPERATIONAL"
    assert not node.emcy.log
    assert [round(x * COUNTS_PER_M) for x in ticks["command_position_m"]] == seen["target"]
    actual = {round(x * COUNTS_PER_M) for x in ticks["robot_position_m"]}
    assert actual - {0} <= set(seen["actual"])
    assert len(seen["actual"]) > 700


def test_a_record_of_a_drive_holds_nothing_unexplained(tmp_path):
    """Its positions come in counts, and its dead time has the tick until the SYNC in it."""
    move = {"profile.kind": "multisine", "profile.amplitude_m": 0.01, "profile.duration_s": 5, "run.duration_s": 8}
    result = run_json("ess-cia402", tmp_path, *settings(move))
    done = command("diagnose", result["log"], "--rig", "ess-cia402", "--out", tmp_path, "--json")
    assert done.returncode == 0, done.stderr.decode()
    assert one_json_object(done.stdout)["verdict"] == "nothing_detectable"


def test_candump_text_tells_a_request_for_a_frame(tmp_path):
    """The loop's log, with a SYNC in it made a remote frame: what is sent to a drive without heartbeat."""
    result = run_json("ess", tmp_path, *settings({**PROFILE, "run.duration_s": 1}))
    log = bytearray(without_checksums(Path(result["log"]).read_bytes()))
    is_remote, record = 4, struct.Struct("<qqqIBBBB")
    made, at = 0, 16
    while at + 3 <= len(log) and made < 3:
        size, kind = struct.unpack_from("<HB", log, at)
        is_frame = kind == ord("D") and size == 2 + record.size and log[at + 3] == 1
        if is_frame and record.unpack_from(log, at + 5)[3] == SYNC:
            log[at + 5 + 30] = is_remote
            made += 1
        at += 3 + size
    path = tmp_path / "remote.ulg"
    path.write_bytes(log)
    assert command("candump", path).returncode == 0
    messages = list(can.CanutilsLogReader(tmp_path / "remote.robot.candump.log"))
    assert [message.arbitration_id for message in messages if message.is_remote_frame] == [SYNC] * 3
