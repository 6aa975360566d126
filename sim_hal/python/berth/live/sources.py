"""Where datagrams come from: a simulated run or a log, at the pace of the clock, or a target's UDP."""
from __future__ import annotations

import asyncio
import socket
from collections.abc import Callable
from pathlib import Path

import numpy as np

from .. import _core
from ..errors import InputError
from .sample import DATAGRAM_BYTES_MAX

CHUNK_s, CHUNK_TICKS = 0.02, 64  # shown at once
DATAGRAMS_PER_S_MAX = 2000  # twenty times what a target sends; more is a flood


class Replay:
    """The ticks of a run or a log, as the target would have sent them."""

    def __init__(self, rig, ticks: np.ndarray, speed: float):
        if len(ticks) == 0:
            raise InputError(f"{rig.name}: has no tick to show", "", "")
        self.rig, self.ticks, self.speed = rig, ticks, speed
        self.refused = 0

    async def feed(self, take: Callable[[bytes], None]) -> None:
        """Until the last tick."""
        loop = asyncio.get_running_loop()
        thinner = _core.LiveThinner(self.rig._core, 0, _core.live_rate_Hz)
        times_s = 1e-9 * self.ticks["scheduled_ns"]
        begin_s = loop.time()
        per_chunk = max(1, min(CHUNK_TICKS, int(CHUNK_s * self.speed * float(self.rig["loop.rate_Hz"]))))
        for at in range(0, len(self.ticks), per_chunk):
            chunk = self.ticks[at:at + per_chunk]
            due_s = begin_s + (times_s[min(at + per_chunk, len(times_s)) - 1] - times_s[0]) / self.speed
            await asyncio.sleep(max(0.0, due_s - loop.time()))
            for datagram in thinner.samples(np.frombuffer(chunk.tobytes(), np.uint8)):
                take(datagram)


class _Receiver(asyncio.DatagramProtocol):
    """Takes datagrams of one host, and no more than so many a second."""

    def __init__(self, source: Target, take: Callable[[bytes], None]):
        self.source, self.take = source, take
        self.second, self.count = 0, 0

    def datagram_received(self, data: bytes, address) -> None:
        second = int(asyncio.get_running_loop().time())
        if second != self.second:
            self.second, self.count = second, 0
        self.count += 1
        if address[0] != self.source.address or self.count > DATAGRAMS_PER_S_MAX or len(data) > DATAGRAM_BYTES_MAX:
            self.source.refused += 1
        else:
            self.take(data)


def own_address_towards(address: str, port: int) -> str:
    """The address of this machine by which it is reached from there: loopback for loopback."""
    family = socket.AF_INET6 if ":" in address else socket.AF_INET
    with socket.socket(family, socket.SOCK_DGRAM) as probe:
        probe.connect((address, port))
        return probe.getsockname()[0]


class Target:
    """What `berth-target --live` sends from `address` to `port` of this machine."""

    rig = None  # the host does not know its file, unless --rig names it

    def __init__(self, address: str, port: int, listen: str = ""):
        try:
            self.address = socket.getaddrinfo(address, port, type=socket.SOCK_DGRAM)[0][4][0]
            own = listen or own_address_towards(self.address, port)
            self.socket = socket.socket(socket.AF_INET6 if ":" in own else socket.AF_INET, socket.SOCK_DGRAM)
            self.socket.bind((own, port))
        except (OSError, UnicodeError) as error:
            raise InputError(f"--from {address}:{port}: cannot be listened to ({error}); name the target's address and a "
                             "free port of this machine", "--from") from None
        self.socket.setblocking(False)
        self.port = self.socket.getsockname()[1]
        self.refused = 0  # of other hosts, too long, too many

    async def feed(self, take: Callable[[bytes], None]) -> None:
        """Until it is cancelled."""
        loop = asyncio.get_running_loop()
        transport, _ = await loop.create_datagram_endpoint(lambda: _Receiver(self, take), sock=self.socket)
        try:
            await asyncio.Event().wait()
        finally:
            transport.close()
