"""Each drive of drive_zoo.py, run by python `canopen`: the firmware enables it and it follows, or the fault says which
object is missing."""

import functools
import struct

import canopen
import pytest
from drive_zoo import DRIVES, READ_ONLY, Drive
from peer_bus import PeerBus
from servo_drive import COUNTS_PER_M, NODE, ServoDrive

RUNNING, FAULT = 2, 4
REQUEST_RUN = 2
START_M = 0.0112  # the loop begins at 0.01 m; it may be 2 mm away
HOMING_TICKS = 60
NMT_NUMBERS = {"PRE-OPERATIONAL": 0x7F, "OPERATIONAL": 0x05, "STOPPED": 0x04}


class ZooDrive(ServoDrive):
    """What a row says, where it is not what every drive does."""

    def __init__(self, bus, row):
        self.row, self.mode, self.homed_at, self.toggle, self.guarded_at, self.polls = row, 0, None, 0, None, []
        self.has_shown_mode = False
        self.has_heartbeat = 0x1017 not in row.lacks
        super().__init__(bus, start_counts=round(START_M * COUNTS_PER_M), pdos=4)
        od = self.node.object_dictionary
        for number, entries in row.fixed_pdos.items():
            for subindex, value in enumerate((len(entries), *entries)):
                od[number][subindex].default = value
        absent = [number + n for number in (0x1600, 0x1A00) for n in range(4) if number + n not in row.fixed_pdos]
        for number in (*row.lacks, *(absent if row.fixed_pdos else ())):
            del od[number]
        for key, value in row.values.items():
            self.entry(*key).default = value
        self.node.add_read_callback(self.on_read)
        bus.on_remote = self.on_remote

    def entry(self, index, subindex):
        found = self.node.object_dictionary[index]
        return found if isinstance(found, canopen.objectdictionary.ODVariable) else found[subindex]

    def boot(self):
        self.toggle, self.guarded_at = 0, None
        if self.has_heartbeat:
            super().boot()
        else:
            self.node.nmt._state = NMT_NUMBERS["PRE-OPERATIONAL"]
            self.bus.network.send_message(0x700 + NODE, [0])

    def on_write(self, index, data, od, **_):
        allowed, code = self.row.refuses.get((index, od.subindex), (None, 0))
        value = int.from_bytes(data, "little", signed=od.data_type in canopen.objectdictionary.SIGNED_TYPES)
        if allowed is not None and value not in allowed:
            raise canopen.SdoAbortedError(code)
        if index in self.row.fixed_pdos:
            raise canopen.SdoAbortedError(READ_ONLY)
        if self.row.only_default_cob_ids and (index, od.subindex) in ((0x1400, 1), (0x1800, 1)):
            assert value & 0x7FF == od.default & 0x7FF
        if index == 0x6060:
            self.mode = value
        elif index == 0x6040:
            self.obey(value)
            if self.mode == 6 and self.state == "OPERATION ENABLED" and value & 0x10:
                self.homed_at = self.bus.ticks + HOMING_TICKS
        super().on_write(index, data)

    def on_read(self, index, subindex, od):
        if index == 0x6041:
            return self.statusword()
        if index == 0x6061 and self.row.late_mode:
            self.has_shown_mode = self.state == "OPERATION ENABLED"
            return self.mode if self.has_shown_mode else 0
        return None

    def statusword(self):
        is_at_end = self.mode == 6 and self.homed_at is not None and self.bus.ticks >= self.homed_at
        return super().statusword() | (is_at_end and {"attained": 0x1400, "error": 0x2000}[self.row.homing])

    def position(self):
        """Before its homing it does not know where it is."""
        return super().position() + (round(0.3 * COUNTS_PER_M) if self.row.homing and not self.homed_at else 0)

    def on_remote(self, identifier):
        assert identifier == 0x700 + NODE and not self.has_heartbeat
        self.polls.append(self.bus.ticks)
        self.guarded_at = self.bus.now_s
        self.bus.network.send_message(identifier, [self.toggle | NMT_NUMBERS[self.node.nmt.state]])
        self.toggle ^= 0x80

    def on_sync(self, *rest):
        if self.guarded_at is not None:
            life_s = self.node.sdo[0x100C].raw * self.node.sdo[0x100D].raw * 1e-3
            assert self.bus.now_s - self.guarded_at < life_s, "life guarding: it would have stopped"
        super().on_sync(*rest)


def command_m(bus):
    return struct.unpack("<i", bus.state[4:])[0] * 1e-9


def path_of(bus):
    """The set-up as the bus has seen it: each SDO request with its value, and what it was answered with."""
    requests = [bytes(data) for _, identifier, data in bus.heard if identifier == 0x600 + NODE]
    aborts = [bytes(data) for _, identifier, data in bus.sent if identifier == 0x580 + NODE and data[0] == 0x80]
    return tuple(requests), tuple(aborts)


@functools.cache
def outcome(row: Drive):
    rig = {"robot_channel.profile": "cia402", "run.release_s": 0.3, "loop.rate_Hz": row.rate_Hz, **row.rig}
    bus = PeerBus("loop", "ess", *(f"{key}={value}" for key, value in rig.items()), period_s=1 / row.rate_Hz)
    drive = ZooDrive(bus, row)
    bus.request = REQUEST_RUN
    bus.run_until(lambda: bus.state[0] in (RUNNING, FAULT), 12 * row.rate_Hz)
    ended_in, enabled_at, commands_m = bus.state[0], bus.ticks, {}
    for _ in range(200 if not row.refused else 20):
        bus.tick()
        commands_m[bus.ticks - 1] = command_m(bus)
    ended_in = bus.state[0] if ended_in == RUNNING else ended_in
    path = path_of(bus)
    bus.close()
    return drive, ended_in, enabled_at, commands_m, path, bus.words


def names(rows):
    return [row.name for row in rows]


ENABLED = [row for row in DRIVES if not row.refused]
REFUSED = [row for row in DRIVES if row.refused]


@pytest.mark.parametrize("row", ENABLED, ids=names(ENABLED))
def test_it_is_enabled_and_follows(row):
    drive, ended_in, running_at, commands_m, _, words = outcome(row)
    assert ended_in == RUNNING, words
    assert words == ""
    assert drive.states[-4:] == ["SWITCH ON DISABLED", "READY TO SWITCH ON", "SWITCHED ON", "OPERATION ENABLED"]
    assert drive.has_shown_mode == row.late_mode  # asked for when it was enabled
    moved = dict(drive.targets)
    late_m = [abs(moved[tick] / COUNTS_PER_M - commands_m[tick - 1]) for tick in commands_m if tick - 1 in commands_m]
    assert len(late_m) > 150 and max(late_m) < 6e-9
    assert max(commands_m.values()) - min(commands_m.values()) > 1e-3
    for (index, subindex), value in row.holds.items():
        held = drive.entry(index, subindex).decode_raw(drive.node.get_data(index, subindex))
        assert held == value, f"{index:#x}:{subindex}"


@pytest.mark.parametrize("row", ENABLED, ids=names(ENABLED))
def test_nothing_jumps_when_it_is_enabled(row):
    drive, _, running_at, _, _, _ = outcome(row)
    before = [counts for tick, counts in drive.targets if tick < running_at]
    assert before[0] == round(START_M * COUNTS_PER_M)  # its own position
    steps_m = [abs(after - counts) / COUNTS_PER_M for counts, after in zip(before, before[1:])]
    assert 0 < max(steps_m) < 1.001 * 0.002 / row.rate_Hz  # 2 mm in a second
    assert before[-1] == pytest.approx(0.01 * COUNTS_PER_M, abs=1)


@pytest.mark.parametrize("row", REFUSED, ids=names(REFUSED))
def test_it_is_refused_with_the_object_that_is_missing(row):
    drive, ended_in, _, _, _, words = outcome(row)
    assert ended_in == FAULT, words
    for part in row.refused:
        assert part in words
    assert drive.state == "SWITCH ON DISABLED"
    assert row.homing or "OPERATION ENABLED" not in drive.states


def test_no_two_drives_have_the_same_way_through_the_set_up():
    paths = {row.name: outcome(row)[4] for row in DRIVES}
    assert len(set(paths.values())) == len(paths) >= 8


def test_every_row_has_its_source():
    for row in DRIVES:
        assert row.source, row.name


def test_a_drive_without_heartbeat_is_polled_as_often_as_it_would_beat():
    drive = outcome(next(row for row in DRIVES if row.name == "minimal"))[0]
    assert {after - before for before, after in zip(drive.polls, drive.polls[1:])} == {40}  # 100 ms
