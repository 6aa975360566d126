"""From datagrams to everybody who watches."""
from __future__ import annotations

import json
import socket
import time

from .events import Events
from .judge import State, judge
from .sample import BadDatagram, Sample, Window, parse

JUDGED_EVERY_s = 0.1


class Hub:
    """Takes datagrams, keeps the last seconds, tells pages, Foxglove and PlotJuggler."""

    def __init__(self, facts: dict, events: Events, foxglove=None, plotjuggler: tuple[str, int] | None = None,
                 clock=time.monotonic):
        self.facts, self.events, self.foxglove = facts, events, foxglove
        self.window = Window()
        self.pages: set = set()
        self.clients = self.dropped = 0
        self.bad = self.taken = 0
        self.state = judge([], None)
        self._new: list[Sample] = []
        self._came_at_s: float | None = None
        self._clock = clock
        self._plotjuggler = plotjuggler
        family = socket.AF_INET6 if plotjuggler and ":" in plotjuggler[0] else socket.AF_INET
        self._socket = socket.socket(family, socket.SOCK_DGRAM) if plotjuggler else None
        if self._socket:
            self._socket.setblocking(False)

    def take(self, datagram: bytes) -> None:
        """One datagram, whatever is in it."""
        try:
            sample = parse(datagram)
        except BadDatagram:
            self.bad += 1
            return
        if not self.window.add(sample):
            return
        self.taken += 1
        self._came_at_s = self._clock()
        self._new.append(sample)
        told = sample.as_json()
        if self.foxglove:
            self.foxglove.log("/loop", told)
        if self._socket:
            try:
                self._socket.sendto(json.dumps({"timestamp": sample.time_s, "berth": told}).encode(), self._plotjuggler)
            except OSError:
                pass  # nobody listens, or its queue is full: PlotJuggler misses a sample

    def tell(self) -> State:
        """Judges, and tells everybody what is new. Every JUDGED_EVERY_s."""
        age_s = None if self._came_at_s is None else self._clock() - self._came_at_s
        self.state = judge(self.window.samples, age_s, self.window.lost, self.bad)
        new, self._new = self._new, []
        message = json.dumps({"samples": [one.as_json() for one in new], "state": self.state.as_json()})
        for page in list(self.pages):
            page.say(message)
        if self.foxglove:
            self.foxglove.log("/verdict", self.state.as_json())
        return self.state

    def mark(self, text: str) -> None:
        """An event at the newest sample's time."""
        if not self.window.samples:
            return
        last = self.window.samples[-1]
        event = self.events.mark(text, last.rig, last.run, last.time_s)
        if event is None:
            return
        if self.foxglove:
            self.foxglove.log("/event", event)
        for page in list(self.pages):
            page.say(json.dumps({"events": [event]}))

    def greeting(self) -> str:
        """What a new page has to know: the rig, and the last seconds."""
        return json.dumps({"facts": self.facts, "events_file": str(self.events.path), "events": list(self.events.newest),
                           "samples": [one.as_json() for one in self.window.samples], "state": self.state.as_json()})

    def close(self) -> None:
        for page in list(self.pages):
            page.close()
        if self._socket:
            self._socket.close()
