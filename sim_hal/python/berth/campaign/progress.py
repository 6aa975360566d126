"""How far a campaign is: one line of standard error, where that is a terminal."""
from __future__ import annotations

import os
import sys
import time


def duration_words(seconds: float) -> str:
    for unit, length_s in (("years", 31556952.0), ("days", 86400.0), ("h", 3600.0), ("min", 60.0)):
        if seconds >= length_s:
            return f"{seconds / length_s:.3g} {unit}"
    return f"{max(seconds, 0.0):.2g} s"


class Progress:
    """A bar, samples per second and the time that is left. Begins to count where a campaign goes on."""

    WIDTH = 30
    EVERY_S = 0.2

    def __init__(self, name: str, count: int, done: int):
        self.name, self.count, self.done, self.begun_with = name, count, done, done
        self.begin_s = time.monotonic()
        self.next_s = 0.0
        self.is_shown = sys.stderr.isatty() and os.environ.get("TERM", "dumb") != "dumb"

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.is_shown:
            sys.stderr.write("\r\033[K")
            sys.stderr.flush()

    def add(self, samples: int) -> None:
        self.done += samples
        now_s = time.monotonic()
        if self.is_shown and now_s >= self.next_s:
            self.next_s = now_s + self.EVERY_S
            sys.stderr.write("\r\033[K" + self.line(now_s - self.begin_s))
            sys.stderr.flush()

    def line(self, passed_s: float) -> str:
        rate = (self.done - self.begun_with) / max(passed_s, 1e-9)
        filled = self.WIDTH * self.done // self.count
        left = f", {duration_words((self.count - self.done) / rate)} left" if rate > 0.0 else ""
        return (f"{self.name} [{'#' * filled}{'.' * (self.WIDTH - filled)}] {self.done:,} of {self.count:,}, "
                f"{rate:,.0f} a second{left}")
