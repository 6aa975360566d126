"""Which samples a campaign has. Each is known by its number alone, so that any worker can make any of them."""
from __future__ import annotations

import functools
import math
import warnings

import numpy as np
from scipy.special import ndtr, ndtri
from scipy.stats import qmc

from .spec import Spec

_WHOLE_DESIGN_MAX = 2**27  # numbers; a design that exists as a whole only


def rows(spec: Spec, first: int, count: int) -> dict[str, np.ndarray]:
    """Values of the inputs by name, shape (count,), of the samples first .. first + count - 1."""
    if spec.method == "grid":
        return _grid(spec, np.arange(first, first + count))
    unit = _correlated(spec, _unit(spec, first, count))
    return {one.name: one.of_unit(unit[:, i]) for i, one in enumerate(spec.inputs)}


def seeds(spec: Spec, first: int, count: int) -> np.ndarray:
    """run.seed of each sample: 52 bits of the seed and the number, mixed (splitmix64), so that neighbours share
    nothing."""
    with np.errstate(over="ignore"):
        z = (np.arange(first, first + count, dtype=np.uint64) + np.uint64(1)) * np.uint64(0x9E3779B97F4A7C15)
        z += np.uint64(spec.seed) * np.uint64(0xD1B54A32D192ED03)
        z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
        return ((z ^ (z >> np.uint64(31))) >> np.uint64(12)).astype(np.int64)


def _grid(spec: Spec, index: np.ndarray) -> dict[str, np.ndarray]:
    """The last input changes fastest."""
    found = {}
    for one in reversed(spec.inputs):
        index, step = np.divmod(index, one.grid_count)
        found[one.name] = one.of_step(step)
    return {one.name: found[one.name] for one in spec.inputs}


def _unit(spec: Spec, first: int, count: int) -> np.ndarray:
    if spec.method == "sobol":
        bits = max(30, math.ceil(math.log2(spec.count + 1)))
        engine = qmc.Sobol(len(spec.inputs), scramble=True, bits=bits, rng=spec.seed)
        if first:
            engine.fast_forward(first)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # a batch need not be a power of two
            return _inside(engine.random(count))
    return _whole_design(spec.method, len(spec.inputs), spec.count, spec.seed)[first:first + count]


@functools.lru_cache(maxsize=1)
def _whole_design(method: str, inputs: int, count: int, seed: int) -> np.ndarray:
    if method == "latin-hypercube":
        return _inside(qmc.LatinHypercube(inputs, rng=seed).random(count))
    from SALib.sample import sobol
    problem = {"num_vars": inputs, "names": [str(i) for i in range(inputs)], "bounds": [[0.0, 1.0]] * inputs}
    return _inside(sobol.sample(problem, count // (inputs + 2), calc_second_order=False, seed=seed))


def is_too_large(spec: Spec) -> bool:
    """Its design would not fit into memory; that of Sobol's sequence and of a grid is made batch by batch."""
    return spec.method in ("latin-hypercube", "saltelli") and spec.count * len(spec.inputs) > _WHOLE_DESIGN_MAX


def _inside(unit: np.ndarray) -> np.ndarray:
    """Without the ends, where a normal distribution is infinite."""
    return np.clip(unit, 2.0**-54, 1.0 - 2.0**-53)


def _correlated(spec: Spec, unit: np.ndarray) -> np.ndarray:
    """Gaussian copula: each input keeps its distribution."""
    if not spec.correlations:
        return unit
    matrix = np.eye(len(spec.inputs))
    for i, j, coefficient in spec.correlations:
        matrix[i, j] = matrix[j, i] = coefficient
    factor = np.linalg.cholesky(matrix)
    normal = ndtri(unit)
    # Column by column: a matrix product may add in another order for another number of rows.
    mixed = np.stack([sum(factor[i, j] * normal[:, j] for j in range(i + 1)) for i in range(len(spec.inputs))], axis=1)
    return _inside(ndtr(mixed))
