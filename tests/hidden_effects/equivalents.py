"""Can this record tell the true effect from another one? Asked only where a diagnosis has named another one, or several
that together do what the true one does: a late start and a drift of the lateness are a clock of another period that does
not slip within the record.

The other effects' parameters, and the base within its tolerances, are fitted to the true blocks' noise-free answer.
If what is left has chi2 <= 10 (in units of the noise, as in detectability), no method can hold the two apart on this
record: the names are then a documented pair, and no wrong name.
"""

import itertools

import numpy as np
from detectability import Tuning, with_effects
from effects import Change
from parameters import FIELDS

CHI2_APART = 10.0

SWITCHES = {"loop.clock_drift": {"free_clock": 1.0}}


# From where to begin with an effect that a diagnosis offers without its size, in the units of diagnosis.json; the
# others cannot be asked about then.
BEGINNINGS = {"sensor.gain": {"gain": 1.001}, "robot.gain": {"gain": 1.001}, "robot.lag": {"lag_ms": 1.0},
              "sensor.lag": {"lag_ms": 1.0},
              "robot.resonance": {"transfer_frequency_Hz": 50.0, "transfer_damping_ratio": 0.7}}
OF_THE_BASE = {"robot.dead_time", "sensor.delay", "object.parameters", "manipulator.parameters"}


def lateness_of_clocks(scenario, effect, slope):
    """What makes the lateness drift by so much, as the clock that does not slip: the dead time's own drift, or an uneven
    clock."""
    period_s = scenario.base["period_s"]
    way_s = slope * len(scenario.runs["record"].result["force_N"]) * period_s
    return {"robot.dead_time_drift": {"dead_time_drift_ms_per_s": 1e3 * slope},
            "loop.clock_drift": {"clock_drift_ppm": 1e6 * slope,
                                 "clock_phase_ms": 1e3 * (0.02 * period_s - min(way_s, 0.0))}}[effect]


def beginnings(scenario, effect, told):
    """Parameters to begin with, one set after the other; `told`: {effect: parameters} of the whole diagnosis."""
    first = told.get(effect, {})
    if effect in ("robot.dead_time_drift", "loop.clock_drift"):
        slopes = [scenario.true["robot_dead_time_drift"] or scenario.true["clock_drift"],
                  1e-3 * told.get("robot.dead_time_drift", {}).get("dead_time_drift_ms_per_s", 0.0),
                  1e-6 * told.get("loop.clock_drift", {}).get("clock_drift_ppm", 0.0)]
        return ([first] if first else []) + [lateness_of_clocks(scenario, effect, slope)
                                             for slope in slopes if slope != 0.0]
    if first:
        return [first]
    if effect in OF_THE_BASE:
        return [{name: scenario.base[field] / factor for name, (field, factor) in FIELDS[effect].items()}]
    return [BEGINNINGS.get(effect, {})]


def chi2_between(scenario, stand_ins, beside=()):
    """What is left of the true record when these effects together stand in for the truth. `stand_ins`: {effect:
    parameters to begin with}; `beside`: changes of the truth that they do not stand in for.

    None where the question cannot be asked: a random effect, a parameter that is missing, a block that overflows at the
    start.
    """
    fields = [(*FIELDS[effect][name], value) for effect, start in stand_ins.items() if effect in FIELDS
              for name, value in start.items() if name in FIELDS[effect]]
    if any(not set(start) & set(FIELDS.get(effect, ())) for effect, start in stand_ins.items()):
        return None
    switches = {name: value for effect in stand_ins for name, value in SWITCHES.get(effect, {}).items()}
    run, tuning = scenario.runs["record"], Tuning(scenario)
    truth = with_effects(scenario, run, [change for _, _, change in scenario.effects])
    begin = np.array([value * factor for _, factor, value in fields])
    scale = np.where(begin != 0.0, begin, 1e-12)

    def changes_at(x):
        values = {field: float(value) for (field, _, _), value in zip(fields, x * scale)} | switches
        return [Change(values, {}), *beside]

    chi2, _ = tuning.fit(truth, changes_at, len(fields))
    return chi2 if np.isfinite(chi2) else None


def stand_in(scenario, effects, told, beside=()):
    """These effects together leave nothing of the truth that the record could show, from one of their beginnings."""
    for starts in itertools.product(*(beginnings(scenario, effect, told) for effect in effects)):
        chi2 = chi2_between(scenario, dict(zip(effects, starts)), beside)
        if chi2 is not None and chi2 <= CHI2_APART:
            return True
    return False


def inseparable_alone(scenario, names, told):
    """Those of the names that this record cannot tell from the truth, or from one of several effects that are true."""
    changes = [change for _, _, change in scenario.effects]
    return [name for name in names if any(
        stand_in(scenario, [name], told, [change for change in changes if change is not replaced])
        for replaced in changes)]


def inseparable_together(scenario, causes, alternatives, told):
    """Causes that this record cannot tell from the truth if all of them are true together, and the alternatives that
    could replace one of them."""
    if not stand_in(scenario, causes, told):
        return []
    return [*causes, *(other for other in alternatives if other not in causes and any(
        stand_in(scenario, [other, *(kept for kept in causes if kept != cause)], told) for cause in causes))]
