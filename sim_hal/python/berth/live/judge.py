"""From the last seconds of a loop to a verdict that a person reads across the lab."""
from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass

import numpy as np

from .. import _core
from .sample import STATE_RUNNING, Sample

# Growth is sought in these last parts of the window, shortest first: a short one sees a change early, a long one sees a
# slow mode. Only the longest window says that a motion decays.
SPANS_S = (2.5, 5.0, 10.0)
GAP_MAX = 5          # samples in a row that may be missing: they are interpolated
# Growth is asked ten times a second: at 95 % alone, noise would alarm once in a while. A motion without noise has intervals
# a thousand times smaller than its growth; noise of 3 N on `ess` came to twice the interval.
CERTAIN = 3.0        # times the 95 % interval
STALE_AFTER_s = 1.0  # without a sample
STANDS_STILL_m = 1e-11  # as sim_hal/motion.cpp: less never comes to the robot
REST_m = 10 * _core.growth_floor_m  # from crest to trough
LATE = 0.75          # of the window: limits that act after that still act
GOOD, BAD, UNSURE = "good", "bad", "unsure"


@dataclass(frozen=True)
class State:
    """What the page shows.

    verdict   one or two words; look: "good" (green), "bad" (red) or "unsure" (grey); because: one sentence
    growth_per_s, growth_ci95_per_s, frequency_Hz, growth_span_s   of the manipulator's motion in the last seconds; None:
                                                                   no growth can be told
    dead_time_J, operator_J, damping_J   made by dead time, given by the operator, taken by the manipulator's damping,
                                         in the last window_s seconds; None: not known
    peak_force_N   the largest measured in that time
    state, stop_cause, limits   names; missed_ticks in all
    lost_datagrams, unsent_datagrams, bad_datagrams   that did not arrive, did not get out, were none
    age_s   of the newest sample; None: there is none
    """

    verdict: str
    look: str
    because: str
    growth_per_s: float | None = None
    growth_ci95_per_s: float | None = None
    frequency_Hz: float | None = None
    growth_span_s: float | None = None
    window_s: float = 0.0
    dead_time_J: float | None = None
    operator_J: float | None = None
    damping_J: float | None = None
    peak_force_N: float | None = None
    state: str = ""
    stop_cause: str = "none"
    limits: tuple[str, ...] = ()
    missed_ticks: int = 0
    lost_datagrams: int = 0
    unsent_datagrams: int = 0
    bad_datagrams: int = 0
    age_s: float | None = None
    time_s: float | None = None
    rig: str = ""

    def as_json(self) -> dict:
        return asdict(self)


@dataclass(frozen=True)
class Growth:
    per_s: float
    ci95_per_s: float
    frequency_Hz: float
    span_s: float

    @property
    def words(self) -> str:
        """Its size; the interval only where the digits that are shown are not sure."""
        interval = f" ± {self.ci95_per_s:.1g}" if self.ci95_per_s > 0.01 * abs(self.per_s) else ""
        return f"{abs(self.per_s):.2g}{interval} /s"

    @property
    def grows(self) -> bool:
        return self.per_s > CERTAIN * self.ci95_per_s

    @property
    def decays(self) -> bool:
        return self.per_s < -CERTAIN * self.ci95_per_s


def words(name: str) -> str:
    return name.replace("_", " ")


def limits_of(bits: int) -> tuple[str, ...]:
    return tuple(name for i, name in enumerate(_core.limit_names) if bits >> i & 1)


def _free_motion(samples: Sequence[Sample]) -> list[Sample]:
    """The newest samples of running without a gap, a limit that acts or a value that is not finite."""
    if not samples:
        return []
    found: list[Sample] = []
    for sample in reversed(samples):
        is_free = sample.state == STATE_RUNNING and sample.limits == 0 and math.isfinite(sample.manipulator_position_m)
        if not is_free or (found and found[-1].sequence - sample.sequence > 1 + GAP_MAX):
            break
        found.append(sample)
    return found[::-1]


def _spacing_s(samples: Sequence[Sample]) -> float:
    return (samples[-1].time_s - samples[0].time_s) / (samples[-1].sequence - samples[0].sequence)


def growth_of(samples: Sequence[Sample]) -> Growth | None:
    """By the method of `berth run`, on an even grid."""
    if len(samples) < 9:
        return None
    spacing_s, span_s = _spacing_s(samples), samples[-1].time_s - samples[0].time_s
    grid = np.arange(samples[0].sequence, samples[-1].sequence + 1, dtype=float)
    motion = np.interp(grid, [one.sequence for one in samples], [one.manipulator_position_m for one in samples])
    found = _core.growth_of(motion, spacing_s)
    return None if found is None else Growth(*found, span_s)


def newest_growth(samples: Sequence[Sample]) -> Growth | None:
    """Of the shortest part that grows; else of all."""
    if len(samples) < 2:
        return None
    end_s = samples[-1].time_s
    for span_s in SPANS_S:
        if samples[0].time_s <= end_s - span_s:
            found = growth_of([one for one in samples if one.time_s >= end_s - span_s])
            if found and found.grows:
                return found
    return growth_of(samples)


def _range(values) -> float:
    values = [value for value in values if math.isfinite(value)]
    return max(values) - min(values) if values else 0.0


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _measured(samples: Sequence[Sample], growth: Growth | None) -> dict:
    """What is shown whatever the verdict is."""
    first, last = samples[0], samples[-1]
    peaks = [one.peak_force_N for one in samples if math.isfinite(one.peak_force_N)]
    late = [one.limits for one in samples if one.time_s >= last.time_s - 1.0]
    return {
        "growth_per_s": growth and growth.per_s, "growth_ci95_per_s": growth and growth.ci95_per_s,
        "frequency_Hz": growth and growth.frequency_Hz, "growth_span_s": growth and growth.span_s,
        "window_s": last.time_s - first.time_s, "time_s": last.time_s,
        "dead_time_J": _number(last.energy_dead_time_J - first.energy_dead_time_J),
        "operator_J": _number(last.energy_operator_J - first.energy_operator_J),
        "damping_J": _number(last.energy_dissipated_J - first.energy_dissipated_J),
        "peak_force_N": max(peaks, key=abs, default=None),
        "state": _core.state_names[last.state], "stop_cause": _core.stop_cause_names[last.stop_cause],
        "limits": limits_of(int(np.bitwise_or.reduce(late))), "missed_ticks": last.missed_ticks,
        "unsent_datagrams": last.unsent, "rig": last.rig}


def _not_running(last: Sample) -> tuple[str, str, str]:
    state, cause = _core.state_names[last.state], _core.stop_cause_names[last.stop_cause]
    because = "" if cause == "none" else f" because: {words(cause)}"
    if state == "fault":
        return "stopped", BAD, f"the supervisor has stopped the robot{because}"
    if state == "holding":
        return "holding", UNSURE, f"the supervisor holds the robot{because}"
    if state == "stopped":
        is_asked = cause in ("none", "requested")
        return ("ended" if is_asked else "stopped"), (UNSURE if is_asked else BAD), f"the run is over{because}"
    return "not running", UNSURE, f"the loop is in state {state}, and the manipulator does not move"


def _running(samples: Sequence[Sample], growth: Growth | None) -> tuple[str, str, str]:
    end_s = samples[-1].time_s
    late_s = end_s - (1.0 - LATE) * (end_s - samples[0].time_s)
    if any(one.limits for one in samples if one.time_s >= late_s):
        acted = limits_of(int(np.bitwise_or.reduce([one.limits for one in samples])))
        return "at the limits", BAD, f"limits act ({', '.join(map(words, acted))}): they hold a motion that would grow"
    is_driven = any(_range(getattr(one, name) for one in samples) > least for name, least in
                    (("operator_position_m", STANDS_STILL_m), ("operator_force_N", 0.0)))
    rate = "" if growth is None else f"by {growth.words} at {growth.frequency_Hz:.3g} Hz"
    if growth and growth.grows and not is_driven:
        return "growing", BAD, f"the motion grows {rate}: doubles every {math.log(2) / growth.per_s:.2g} s"
    if is_driven:
        return "driven", UNSURE, "the operator moves: what the loop does by itself cannot be seen"
    if growth and growth.decays:
        return "decaying", GOOD, f"the motion decays {rate}: halves every {math.log(2) / -growth.per_s:.2g} s"
    if _range(one.manipulator_position_m for one in samples) < REST_m:
        return "at rest", GOOD, "the manipulator does not move"
    if growth:
        return "undecided", UNSURE, f"growth {growth.per_s:.1g} ± {growth.ci95_per_s:.1g} /s: neither grows nor decays surely"
    return "undecided", UNSURE, f"too few swings in {end_s - samples[0].time_s:.1f} s to tell growth from decay"


def judge(samples: Sequence[Sample], age_s: float | None, lost: int = 0, bad: int = 0) -> State:
    """The verdict on the last seconds of one run. Pure: the same samples give the same answer.

    samples  of one run, in order; age_s  since the newest arrived, on the host's clock; None: none has
    lost, bad  datagrams that are missing, or were none
    """
    counts = {"lost_datagrams": lost, "bad_datagrams": bad, "age_s": age_s}
    if not samples or age_s is None:
        return State("no data", UNSURE, "no sample has come yet", **counts)
    samples = list(samples)
    running = [one for one in samples if one.state == STATE_RUNNING]
    growth = newest_growth(_free_motion(samples))
    measured = _measured(samples, growth)
    if samples[-1].state != STATE_RUNNING:
        told = _not_running(samples[-1])
    elif age_s > STALE_AFTER_s:
        told = "no data", UNSURE, f"the last sample came {age_s:.1f} s ago"
    elif not math.isfinite(samples[-1].manipulator_position_m):
        told = "not finite", BAD, "the manipulator's position is no number any more"
    else:
        told = _running(running, growth)
    return State(*told, **measured, **counts)
