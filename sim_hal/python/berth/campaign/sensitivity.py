"""Which inputs matter: SALib's indices of what was answered."""
from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np
import pyarrow as pa

from .spec import Spec

ROWS_MAX = 16384  # more rows sharpen the indices no further than anyone reads them
# What the indices are of: the first that was asked.
OUTPUTS = ("growth_per_s", "predicted_growth_per_s", "run_growth_per_s", "dead_time_margin_ms", "peak_force_N",
           "restitution", "compensated_error", "motion_error")
ROWS_MIN = 64


@dataclass(frozen=True)
class Influence:
    """first    share of the output's variance that this input makes alone (Sobol's first index), with 95 % interval
    other    of Saltelli's design the total index: alone and together with others, with 95 % interval. Of any other
             PAWN's index: the largest difference that fixing this input makes to the output's distribution, 0 to 1
    method   "sobol" or "pawn"; output: the column
    """

    name: str
    first: float
    first_ci95: float
    other: float
    other_ci95: float | None
    method: str
    output: str


def influences(spec: Spec, table: pa.Table, is_whole: bool) -> list[Influence]:
    """The most influential first; empty where there is nothing to tell: too few samples, or an output that is the same
    for all."""
    output = next((name for name in OUTPUTS if name in table.column_names
                   and table[name].null_count < table.num_rows), None)
    numbers = [one.name for one in spec.inputs if one.is_number]
    if output is None or not numbers:
        return []
    y = table[output].to_numpy(zero_copy_only=False).astype(float)
    if spec.method == "saltelli" and is_whole and np.isfinite(y).all() and len(numbers) == len(spec.inputs):
        found = _of_saltelli(numbers, y)
        columns = zip(*(found[key].tolist() for key in ("S1", "S1_conf", "ST", "ST_conf")))
        method = "sobol"
    else:
        x = np.column_stack([table[name].to_numpy(zero_copy_only=False).astype(float) for name in numbers])
        known = np.flatnonzero(np.isfinite(y))
        known = known[np.linspace(0, len(known) - 1, min(len(known), ROWS_MAX)).astype(int)] if len(known) else known
        if len(known) < ROWS_MIN or np.ptp(y[known]) == 0.0 or (np.ptp(x[known], axis=0) == 0.0).any():
            return []
        found = _of_any(numbers, x[known], y[known])
        columns = zip(*found, [None] * len(numbers))
        method = "pawn"
    told = [Influence(name, *row, method, output) for name, row in zip(numbers, columns)]
    return sorted(told, key=lambda one: -one.other)


def _of_saltelli(numbers, y):
    from SALib.analyze import sobol
    problem = {"num_vars": len(numbers), "names": numbers, "bounds": [[0.0, 1.0]] * len(numbers)}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return sobol.analyze(problem, y, calc_second_order=False, seed=1)


def _of_any(numbers, x, y):
    """First index and its interval by RBD-FAST, and PAWN's median index."""
    from SALib.analyze import pawn, rbd_fast
    problem = {"num_vars": len(numbers), "names": numbers,
               "bounds": [[float(low), float(high)] for low, high in zip(x.min(axis=0), x.max(axis=0))]}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        first = rbd_fast.analyze(problem, x, y, num_resamples=100, seed=1)
        return [np.asarray(column, float).tolist()
                for column in (first["S1"], first["S1_conf"], pawn.analyze(problem, x, y, seed=1)["median"])]
