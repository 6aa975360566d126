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
REMOTE = 0x40000000  # CAN_RTR_FLAG


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
                                        stderr=subprocess.PIPE, cwd=ROOT)
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
        self.on_remote = lambda identifier: None  # a request for that frame
        self.words = ""  # what was wrong with the drive, once closed
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
            assert len(record) == FRAME.size, f"{PEER} ended: {self.process.stderr.read().decode()}"
            identifier, length, data = FRAME.unpack(record)
            if identifier == MARK:
                self.state = data
                break
            self.heard.append((self.ticks, identifier, data[:length]))
            if identifier & REMOTE:
                self.on_remote(identifier & ~REMOTE)
                continue
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
        self.words = self.process.stderr.read().decode()
        self.process.stderr.close()
        assert self.process.wait(timeout=30) == 0
