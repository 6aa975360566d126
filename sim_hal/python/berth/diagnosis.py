"""What a simulation gets wrong, by a record of the real thing."""
from __future__ import annotations

import html
import os
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from . import _core
from .rig import Rig


@dataclass(frozen=True)
class Parameter:
    """Value of a key with its 95 % interval, value +- ci95, in `unit`."""

    key: str
    value: float
    ci95: float
    unit: str

    def __str__(self) -> str:
        return f"{self.key} = {self.value:.4g} +- {self.ci95:.2g}{'' if self.unit == '1' else ' ' + self.unit}"


@dataclass(frozen=True)
class Cause:
    """An effect that the simulation lacks. share_explained: of the error that can be explained; delta_bic: by how much
    the evidence is for it."""

    effect: str
    parameters: list[Parameter]
    delta_bic: float
    share_explained: float

    def __str__(self) -> str:
        return f"{self.effect}: " + ", ".join(map(str, self.parameters))


@dataclass(frozen=True)
class Block:
    """One part of the loop: "manipulator", "robot" or "force".

    verdict       as of the whole; causes: effects that were found; alternatives: names of others that do as well
    rms_before, rms_after, rms_floor   of the error on rows that no fit has seen: as given, extended, and of noise
                  alone, in `unit`
    error_before, error_after   measured less simulated, shape (n,), in `unit`
    """

    block: str
    verdict: str
    unit: str
    causes: list[Cause]
    alternatives: list[str]
    rms_before: float
    rms_after: float
    rms_floor: float
    error_before: np.ndarray = field(repr=False)
    error_after: np.ndarray = field(repr=False)


@dataclass(frozen=True)
class Diagnosis:
    """verdict   "nothing_detectable", "named", "one_of", "partly_explained", "unknown" or "software_mismatch"
    block     the block at fault; None: none, or more than one
    blocks    each that was judged; notes: sentences that belong to the verdict
    signals   the record's columns by name, time_s among them; period_s: of its rows
    given, extended   the rig before, and with what was found
    """

    verdict: str
    block: str | None
    blocks: list[Block]
    notes: list[str]
    not_tried: list[str]
    period_s: float
    signals: dict = field(repr=False)
    given: Rig
    extended: Rig

    @property
    def causes(self) -> list[Cause]:
        return [cause for block in self.blocks for cause in block.causes]

    def __str__(self) -> str:
        lines = [self.verdict.replace("_", " ")]
        lines += [f"  {block.block}: {cause}" for block in self.blocks for cause in block.causes]
        lines += [f"  {block.block}: error {block.rms_before:.4g} -> {block.rms_after:.4g} {block.unit}, noise "
                  f"{block.rms_floor:.4g} {block.unit}" for block in self.blocks]
        return "\n".join(lines + [f"  {note}" for note in self.notes])

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(str(self))}</pre>"

    def plot(self, axes=None):
        """The error of each block before and after, over time; returns the matplotlib axes."""
        from .plots import plot_diagnosis
        return plot_diagnosis(self, axes)


def diagnose(record: str | os.PathLike | Iterable[str | os.PathLike], rig: Rig, validation: str | os.PathLike = "",
             repetition: str | os.PathLike = "", standstill: str | os.PathLike = "", limit_s: float | None = None,
             without: Iterable[str] = ()) -> Diagnosis:
    """What `rig` gets wrong by a record (CSV or a log), or several, as `berth diagnose`.

    validation, repetition, standstill   further records: held out; the same motion again; at rest
    limit_s   of processor time; None: as long as the record lasts, a minute at least
    without   effects that are not to be tried
    """
    records = [record] if isinstance(record, (str, os.PathLike)) else list(record)
    told = _core.diagnose([os.fspath(one) for one in records], rig._core, os.fspath(validation),
                          os.fspath(repetition), os.fspath(standstill), limit_s, list(without))
    blocks = [Block(**{**block, "causes": [Cause(**{**cause, "parameters": [Parameter(**one) for one in
                                                                            cause["parameters"]]})
                                           for cause in block["causes"]]}) for block in told.pop("blocks")]
    return Diagnosis(blocks=blocks, given=Rig(told.pop("given")), extended=Rig(told.pop("extended")), **told)
