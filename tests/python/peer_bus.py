"""A CANopen network of python `canopen` whose bus is one side of build/peer: virtual time, tick by tick.

The other side answers when its tick has passed, so a test is as fast as the machine lets it, and never too late.
"""

import pathlib
import struct
import subprocess
import threading

import can
import canopen

ROOT = pathlib.Path(__file__).resolve().parents[2]
PEER = ROOT / "build" / "peer"
FRAME = struct.Struct("<IB3x8s")
MARK = 0xFFFFFFFF


class Periodic:
    """What python-can's send_periodic() gives, in virtual time."""

    def __init__(self, bus, message, period_s):
        self.bus, self.message, self.period_s, self.due_s = bus, message, period_s, bus.now_s

    def stop(self):
        self.bus.periodic.remove(self)

    def modify_data(self, message):
        self.message = message


class PeerBus:
    """As much of a python-can bus as canopen.Network uses, and the ticks."""

    def __init__(self, role, rig, *overrides, period_s=0.0025):
        self.process = subprocess.Popen([PEER, role, rig, *overrides], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                        cwd=ROOT)
        self.period_s = period_s
        self.now_s = 0.0
        self.request = 0  # to the other side, with each mark
        self.state = bytes(8)  # from the other side
        self.periodic = []
        self.to_send = []
        self.lock = threading.Lock()
        self.heard = []  # (tick, identifier, data) of all that came
        self.sent = []
        self.ticks = 0
        self.network = canopen.Network()
        self.network.bus = self

    def send(self, message, *_):
        with self.lock:
            self.to_send.append(message)

    def send_periodic(self, message, period_s, **_):
        self.periodic.append(Periodic(self, message, period_s))
        return self.periodic[-1]

    def tick(self):
        """Takes what the other side has sent in its tick, and sends what has been answered."""
        stdout, stdin = self.process.stdout, self.process.stdin
        while True:
            record = stdout.read(FRAME.size)
            assert len(record) == FRAME.size, f"{PEER} ended with {self.process.wait()}"
            identifier, length, data = FRAME.unpack(record)
            if identifier == MARK:
                self.state = data
                break
            self.heard.append((self.ticks, identifier, data[:length]))
            self.network.notify(identifier, bytearray(data[:length]), self.now_s)
        for task in self.periodic:
            while task.due_s <= self.now_s:
                self.send(task.message)
                task.due_s += task.period_s
        with self.lock:
            messages, self.to_send = self.to_send, []
        for message in messages:
            assert isinstance(message, can.Message)
            data = bytes(message.data)
            stdin.write(FRAME.pack(message.arbitration_id, len(data), data.ljust(8, b"\0")))
            self.sent.append((self.ticks, message.arbitration_id, data))
        stdin.write(FRAME.pack(MARK, 8, bytes([self.request]).ljust(8, b"\0")))
        stdin.flush()
        self.ticks += 1
        self.now_s = self.ticks * self.period_s

    def run(self, ticks):
        for _ in range(ticks):
            self.tick()

    def run_until(self, condition, ticks_max=2000):
        for _ in range(ticks_max):
            if condition():
                return
            self.tick()
        raise AssertionError(f"not within {ticks_max} ticks")

    def close(self):
        self.process.stdin.close()
        self.process.stdout.read()
        self.process.stdout.close()
        assert self.process.wait(timeout=30) == 0


def variable(dictionary, index, name, kind, default, subindex=None, access="rw", record=None):
    """Adds a variable to an object dictionary, or to one of its records."""
    made = canopen.objectdictionary.ODVariable(name, index, subindex or 0)
    made.data_type = kind
    made.access_type = access
    made.default = default
    made.pdo_mappable = True
    if record is None:
        dictionary.add_object(made)
    else:
        record.add_member(made)
    return made


def servo_dictionary(node_id):
    """The objects of a CiA 402 servo drive that a master in cyclic synchronous position needs."""
    types = canopen.objectdictionary
    od = types.ObjectDictionary()
    od.node_id = node_id

    def record(index, name, members):
        made = types.ODRecord(name, index)
        od.add_object(made)
        for subindex, (member, kind, default) in enumerate(members):
            variable(od, index, member, kind, default, subindex, record=made)

    variable(od, 0x1000, "Device type", types.UNSIGNED32, 0x00020192, access="ro")
    variable(od, 0x1001, "Error register", types.UNSIGNED8, 0, access="ro")
    variable(od, 0x1006, "Communication cycle period", types.UNSIGNED32, 0)
    variable(od, 0x1017, "Producer heartbeat time", types.UNSIGNED16, 0)
    record(0x1016, "Consumer heartbeat time", [("Entries", types.UNSIGNED8, 1), ("Consumer 1", types.UNSIGNED32, 0)])
    for index, name, cob_id in ((0x1400, "RPDO 1", 0x200), (0x1800, "TPDO 1", 0x180)):
        record(index, name, [(f"{name} entries", types.UNSIGNED8, 2), ("COB-ID", types.UNSIGNED32, cob_id + node_id),
                             ("Transmission type", types.UNSIGNED8, 255)])
    for index, name in ((0x1600, "RPDO 1 mapping"), (0x1A00, "TPDO 1 mapping")):
        record(index, name, [(f"{name} entries", types.UNSIGNED8, 0)] +
               [(f"Object {i}", types.UNSIGNED32, 0) for i in range(1, 9)])
    variable(od, 0x6040, "Controlword", types.UNSIGNED16, 0)
    variable(od, 0x6041, "Statusword", types.UNSIGNED16, 0, access="ro")
    variable(od, 0x6060, "Modes of operation", types.INTEGER8, 0)
    variable(od, 0x6061, "Modes of operation display", types.INTEGER8, 0, access="ro")
    variable(od, 0x6064, "Position actual value", types.INTEGER32, 0, access="ro")
    variable(od, 0x607A, "Target position", types.INTEGER32, 0)
    record(0x60C2, "Interpolation time period", [("Entries", types.UNSIGNED8, 2), ("Value", types.UNSIGNED8, 1),
                                                 ("Index", types.INTEGER8, -3)])
    variable(od, 0x6502, "Supported drive modes", types.UNSIGNED32, 1 << 7, access="ro")
    return od
