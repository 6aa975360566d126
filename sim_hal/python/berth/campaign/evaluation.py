"""What a worker does with a few samples: their inputs in, rows of the table out."""
from __future__ import annotations

import itertools

import numpy as np
import pyarrow as pa

from .. import _core
from .._core import __version__ as version
from ..diagnosis import diagnose
from ..errors import InputError
from .inputs import RECORD
from .sampling import rows, seeds
from .spec import Spec

SEED = "run.seed"
# Columns of each question, in the order of the table.
COLUMNS = {
    "growth": {"growth_per_s": pa.float64(), "spectral_radius": pa.float64()},
    "verdict": {"verdict": pa.string(), "predicted_growth_per_s": pa.float64()},
    "margins": {"dead_time_margin_ms": pa.float64(), "dead_time_margin_is_open": pa.bool_(), "modulus": pa.float64()},
    "peak_force": {"run_verdict": pa.string(), "run_growth_per_s": pa.float64(), "peak_force_N": pa.float64(),
                   "peak_s": pa.float64(), "stop_cause": pa.string()},
    "restitution": {"restitution": pa.float64()},
    "fidelity": {"motion_error": pa.float64()},
    "compensation": {"compensation": pa.string(), "compensated_error": pa.float64()},
    "diagnosis": {"diagnosis": pa.string(), "block": pa.string(), "cause": pa.string(), "cause_key": pa.string(),
                  "cause_value": pa.float64()},
}
DECIDES = {"growth", "verdict", "margins", "peak_force"}  # whether a sample is stable


class OtherVersion(RuntimeError):
    """A worker has another version of berth than the campaign."""


def schema(spec: Spec) -> pa.Schema:
    """Of the table: number, seed, inputs, outputs, how it ended, commit."""
    fields = [("sample", pa.int64()), ("seed", pa.int64())]
    for one in spec.inputs:
        kind = pa.string() if one.values and isinstance(one.values[0], str) else \
            pa.bool_() if one.values and isinstance(one.values[0], bool) else \
            pa.int64() if one.integer else pa.float64()
        fields.append((one.name, kind))
    if DECIDES & set(spec.asks):
        fields.append(("stable", pa.bool_()))
    for ask in spec.asks:
        fields += COLUMNS[ask].items()
    return pa.schema([*fields, ("state", pa.string()), ("reason", pa.string()), ("commit", pa.string())])


def evaluate(spec: Spec, first: int, count: int, commit: str) -> pa.Table:
    """The rows of the samples first .. first + count - 1. A rig that is refused, or an answer that fails, is a row with
    its reason. What goes wrong besides comes as RuntimeError with one line: any other error may not survive the way to
    the client, which would then wait for ever."""
    if version != commit:
        raise OtherVersion(f"a worker has berth {version}, and the campaign {commit}")
    try:
        return _rows(spec, first, count)
    except Exception as error:
        raise RuntimeError(f"{type(error).__name__}: {str(error)[:500]}") from None


def _rows(spec: Spec, first: int, count: int) -> pa.Table:
    inputs = rows(spec, first, count)
    found = _growth_at_once(spec, inputs, count) if spec.asks == ("growth",) else None
    if found is None:
        found = [_one(spec, *one) for one in _samples(spec, inputs, first, count)]
        found = {name: [one.get(name) for one in found] for name in set().union(*found)}
    return _table(spec, inputs, first, count, found)


def without_answer(spec: Spec, first: int, state: str, reason: str) -> pa.Table:
    """The row of a sample that ended its worker, or that failed."""
    return _table(spec, rows(spec, first, 1), first, 1, {"state": [state], "reason": [reason]})


def settings_of(spec: Spec, values: dict, seed: int) -> dict:
    """What is set on the rig for a sample: its inputs, and its seed unless that is stated."""
    stated = SEED in spec.fixed or SEED in values
    return {**values, **({} if stated else {SEED: int(seed)})}


def _samples(spec: Spec, inputs: dict, first: int, count: int):
    columns = [values.tolist() for values in inputs.values()]
    for values, seed in zip(zip(*columns), seeds(spec, first, count).tolist()):
        yield dict(zip(inputs, values)), seed


def _table(spec: Spec, inputs: dict, first: int, count: int, found: dict) -> pa.Table:
    own_seeds = inputs.get(SEED, np.full(count, spec.fixed[SEED]) if SEED in spec.fixed else seeds(spec, first, count))
    columns = {"sample": np.arange(first, first + count), "seed": own_seeds, **inputs,
               "state": ["done"] * count, "commit": [version] * count, **found}
    made = schema(spec)
    arrays = [pa.array(columns[name], kind) if name in columns else pa.nulls(count, kind)
              for name, kind in zip(made.names, made.types)]
    return pa.Table.from_arrays(arrays, schema=made)


def _growth_at_once(spec: Spec, inputs: dict, count: int) -> dict | None:
    """Eigenvalues of all samples in C++, where numbers alone vary and the rig may be changed in place."""
    others = [one.name for one in spec.inputs if not one.is_number]
    numbers = [one.name for one in spec.inputs if one.is_number]
    presets = bool(spec.robot) or "preset" in others
    if not numbers or SEED in numbers or RECORD in others or (presets and "loop.rate_Hz" in numbers):
        return None
    groups: dict = {}
    for i, key in enumerate(zip(*(inputs[name].tolist() for name in others)) if others else itertools.repeat((), count)):
        groups.setdefault(key, []).append(i)
    table = np.column_stack([inputs[name].astype(float) for name in numbers])
    found = {"growth_per_s": np.full(count, np.nan), "spectral_radius": np.full(count, np.nan),
             "state": ["done"] * count, "reason": [None] * count}
    for key, places in groups.items():
        base = _first_rig(spec, dict(zip(others, key)), {name: inputs[name][places] for name in numbers})
        if base is None or not base.settable:
            return None
        told = _core.growth_of_many(base, numbers, np.ascontiguousarray(table[places]))
        for name in ("growth_per_s", "spectral_radius"):
            found[name][places] = told[name]
        for at, line in told["refused"]:
            found["state"][places[at]], found["reason"][places[at]] = "refused", line
    found["stable"] = found["spectral_radius"] < 1.0
    return _without_refused(found)


def _without_refused(found: dict) -> dict:
    was_refused = np.array([state != "done" for state in found["state"]])
    return {name: values if isinstance(values, list) else pa.array(values, mask=was_refused)
            for name, values in found.items()}


def _first_rig(spec: Spec, others: dict, numbers: dict):
    """A rig with values of these samples, so that what varies counts as stated; None: the first few are refused."""
    for i in range(min(4, len(next(iter(numbers.values()))))):
        try:
            rig = spec.base({**others, **{name: values[i].item() for name, values in numbers.items()}})._core
            rig.refuse_unstated()
            return rig
        except InputError:
            continue
    return None


def _one(spec: Spec, values: dict, seed: int) -> dict:
    try:
        rig = spec.base(settings_of(spec, values, seed))
        found: dict = {}
        for answer in _answers(spec):
            found.update(answer(rig, spec, values))
        return found
    except InputError as error:
        return {"state": "refused", "reason": str(error)}
    except Exception as error:  # the sample is in the table, and the others go on
        return {"state": "failed", "reason": f"{type(error).__name__}: {error}"}


def _answers(spec: Spec):
    """In this order: what decides last whether a sample is stable, decides."""
    asks = set(spec.asks)
    if "growth" in asks:
        yield _growth
    if asks & {"verdict", "margins", "restitution"}:
        yield _verdict
    if "peak_force" in asks:
        yield _run
    if asks & {"fidelity", "compensation"}:
        yield _compensation
    if "diagnosis" in asks:
        yield _diagnosis


def _growth(rig, spec, values) -> dict:
    found = rig.eigenvalues()
    return {"growth_per_s": found.growth_per_s, "spectral_radius": found.spectral_radius, "stable": found.stable}


def _verdict(rig, spec, values) -> dict:
    found = rig.verdict(advice="margins" in spec.asks)
    return {"verdict": found.kind, "stable": found.stable, "predicted_growth_per_s": found.prediction["growth_per_s"],
            "dead_time_margin_ms": found.dead_time_margin_ms,
            "dead_time_margin_is_open": found.dead_time_margin_is_open, "modulus": found.modulus,
            "restitution": found.prediction["restitution"]}


def _run(rig, spec, values) -> dict:
    found = rig.run(advice=False)
    return {"run_verdict": found.verdict.kind, "stable": found.verdict.stable,
            "run_growth_per_s": found.verdict.growth_per_s, "peak_force_N": found.measured_peak_N,
            "peak_s": found.measured_peak_s, "stop_cause": found.verdict.stop_cause}


def _compensation(rig, spec, values) -> dict:
    found = rig.compensate()
    errors = {one.method: one for one in found.methods}
    best = errors.get(found.recommended)
    return {"motion_error": errors["none"].error if "none" in errors else None, "compensation": found.recommended,
            "compensated_error": best.worst_error if best else None}


def _diagnosis(rig, spec, values) -> dict:
    found = diagnose(values[RECORD], rig)
    made = {"diagnosis": found.verdict, "block": found.block}
    if found.causes:
        first = found.causes[0]
        made["cause"] = first.effect
        if first.parameters:
            made |= {"cause_key": first.parameters[0].key, "cause_value": first.parameters[0].value}
    return made
