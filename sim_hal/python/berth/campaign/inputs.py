"""One input of a campaign: how its values come out of a number between 0 and 1."""
from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.special import ndtr, ndtri

# Keys that are none of a rig file.
PRESET, RECORD = "preset", "record"


@dataclass(frozen=True)
class Input:
    """name    key of the rig file, or "preset" (a robot preset) or "record" (for a diagnosis)
    kind    "uniform", "log-uniform", "normal", "log-normal", "triangular" or "values"
    low, high   ends of the range; of an unbounded one infinite
    middle      mean, median or most likely value; width: standard deviation, of a log-normal one as a factor
    values      those of "values", each equally likely
    count       of a grid: in equal steps of `kind` from low to high
    integer     values are whole
    """

    name: str
    kind: str
    low: float = -math.inf
    high: float = math.inf
    middle: float = math.nan
    width: float = math.nan
    values: tuple = ()
    count: int = 0
    integer: bool = False

    @property
    def is_number(self) -> bool:
        return not self.values or all(isinstance(one, (int, float)) and not isinstance(one, bool)
                                      for one in self.values)

    @property
    def grid_count(self) -> int:
        return len(self.values) or self.count

    def of_unit(self, u: np.ndarray) -> np.ndarray:
        """Values at these points of (0, 1), shape as given."""
        if self.values:
            return np.asarray(self.values)[np.minimum((u * len(self.values)).astype(int), len(self.values) - 1)]
        if self.integer:
            return np.minimum(np.floor(self.low + u * (self.high - self.low + 1.0)), self.high).astype(np.int64)
        return np.clip(self._continuous(u), self.low, self.high)

    def _continuous(self, u: np.ndarray) -> np.ndarray:
        if self.kind == "uniform":
            return self.low + u * (self.high - self.low)
        if self.kind == "log-uniform":
            return self.low * (self.high / self.low) ** u
        if self.kind == "triangular":
            share = (self.middle - self.low) / (self.high - self.low)
            rising = self.low + np.sqrt(u * (self.high - self.low) * (self.middle - self.low))
            falling = self.high - np.sqrt((1.0 - u) * (self.high - self.low) * (self.high - self.middle))
            return np.where(u < share, rising, falling)
        z = ndtri(self._share_below(self.low) + u * (self._share_below(self.high) - self._share_below(self.low)))
        if self.kind == "log-normal":
            return self.middle * self.width ** z
        return self.middle + self.width * z

    def _share_below(self, end: float) -> float:
        """Of the uncut normal distribution."""
        if self.kind == "log-normal":
            return float(ndtr(math.log(end / self.middle) / math.log(self.width))) if end > 0.0 else 0.0
        return float(ndtr((end - self.middle) / self.width))

    def of_step(self, step: np.ndarray) -> np.ndarray:
        """Values of these steps of a grid."""
        if self.values:
            return np.asarray(self.values)[step]
        share = step / max(self.count - 1, 1)
        found = np.where(step == self.count - 1, self.high, self._continuous(share)) if self.count > 1 \
            else np.full(step.shape, self.low)
        return np.rint(found).astype(np.int64) if self.integer else found
