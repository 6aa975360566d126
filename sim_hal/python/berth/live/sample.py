"""Samples of a running loop, as hal/live_sample.h makes them."""
from __future__ import annotations

import json
import math
from collections import deque
from dataclasses import dataclass, fields

from .. import _core

DATAGRAM_BYTES_MAX = 1472  # one frame of Ethernet; the sender stays below
TEXT_MAX = 64
COUNT_MAX = 2**53  # as far as JSON's readers count
NUMBER_MAX = 1e15  # of any rig; sums and differences of such numbers stay finite
STATE_RUNNING = _core.state_names.index("running")


class BadDatagram(ValueError):
    """What came is no sample."""


@dataclass(frozen=True, slots=True)
class Sample:
    """Names and units as in the log. A number that is not finite is nan."""

    rig: str
    config_hash: str
    period_ms: float
    run: int
    sequence: int
    unsent: int
    time_s: float
    woke_late_ms: float
    force_frame_age_ms: float
    operator_position_m: float
    operator_force_N: float
    manipulator_position_m: float
    command_position_m: float
    robot_position_m: float
    force_N: float
    peak_force_N: float
    energy_operator_J: float
    energy_dissipated_J: float
    energy_dead_time_J: float
    missed_ticks: int
    rejected_frames: int
    lost_frames: int
    state: int
    stop_cause: int
    limits: int

    def as_json(self) -> dict:
        """By name; None in the place of nan, which JSON has not."""
        return {name: None if value != value else value for name in NAMES for value in [getattr(self, name)]}


NAMES = tuple(field.name for field in fields(Sample))
KINDS = {field.name: field.type for field in fields(Sample)}
NAMES_COUNTED = {"state": len(_core.state_names), "stop_cause": len(_core.stop_cause_names),
                 "limits": 1 << len(_core.limit_names)}


def _refuse_constant(text: str):
    raise BadDatagram(f"{text} is no JSON")


def _value(name: str, found):
    kind = KINDS[name]
    if kind == "str":
        if not isinstance(found, str) or len(found) > TEXT_MAX or not found.isprintable():
            raise BadDatagram(f"{name} is no short text")
        return found
    if found is None and kind == "float":
        return math.nan
    if isinstance(found, bool) or not isinstance(found, (int, float)):
        raise BadDatagram(f"{name} is no number")
    if kind == "float":
        if not abs(found) <= NUMBER_MAX:
            raise BadDatagram(f"{name} is too large")
        return float(found)
    if not isinstance(found, int) or not 0 <= found < NAMES_COUNTED.get(name, COUNT_MAX):
        raise BadDatagram(f"{name} is no count that may be")
    return found


def parse(datagram: bytes) -> Sample:
    """Raises BadDatagram, and nothing else, whatever the bytes are."""
    if len(datagram) > DATAGRAM_BYTES_MAX:
        raise BadDatagram(f"longer than {DATAGRAM_BYTES_MAX} bytes")
    try:
        found = json.loads(datagram, parse_constant=_refuse_constant)
    except (ValueError, RecursionError) as error:
        raise BadDatagram(f"no JSON: {error}") from None
    if not isinstance(found, dict) or found.get("berth_live") != 1:
        raise BadDatagram("no sample of this version of berth")
    if found.keys() - {"berth_live"} != KINDS.keys():
        raise BadDatagram("has other fields than a sample")
    sample = Sample(**{name: _value(name, found[name]) for name in NAMES})
    if not 0.0 < sample.period_ms <= 1e3 or not 0.0 <= sample.time_s < 1e9:
        raise BadDatagram("period_ms or time_s is not possible")
    return sample


class Window:
    """The last seconds of one run. Bounded, whatever comes: samples older than `span_s`, and more than `count_max`, go."""

    def __init__(self, span_s: float = 10.0, count_max: int = 4096):
        self.span_s = span_s
        self.samples: deque[Sample] = deque(maxlen=count_max)
        self.lost = 0  # datagrams of this run that did not come

    def add(self, sample: Sample) -> bool:
        """False: it is late or doubled, and was left out."""
        last = self.samples[-1] if self.samples else None
        if last and (last.run, last.rig, last.config_hash) != (sample.run, sample.rig, sample.config_hash):
            self.samples.clear()
            self.lost, last = 0, None
        if last and (sample.sequence <= last.sequence or sample.time_s <= last.time_s):
            return False
        self.lost += sample.sequence - last.sequence - 1 if last else 0
        self.samples.append(sample)
        while self.samples[0].time_s < sample.time_s - self.span_s:
            self.samples.popleft()
        return True
