"""Runs and logs as arrays."""
from __future__ import annotations

import os
from dataclasses import dataclass

import numpy as np

from . import _core
from .answers import Verdict

_NUMPY_TYPES = {"double": "f8", "float": "f4", "char": "S1"}


def _dtype(log_format: str, item_bytes: int | None = None) -> np.dtype:
    """Of a record that ULog describes as "name:type field;type field;..."."""
    names, formats, offsets, at = [], [], [], 0
    for part in log_format.partition(":")[2].strip(";").split(";"):
        type_name, name = part.split(" ")
        made = np.dtype(_NUMPY_TYPES.get(type_name, type_name.removesuffix("_t")))
        names.append(name)
        formats.append(made)
        offsets.append(at)
        at += made.itemsize
    return np.dtype({"names": names, "formats": formats, "offsets": offsets, "itemsize": item_bytes or at})


def _records(raw: np.ndarray, log_format: str, item_bytes: int | None = None) -> np.ndarray:
    return raw.view(_dtype(log_format, item_bytes))


class _Ticks:
    """The records of a run's ticks: a mapping from field to array."""

    ticks: np.ndarray

    def __getitem__(self, field: str) -> np.ndarray:
        try:
            return self.ticks[field]
        except ValueError:
            raise KeyError(f"{field}: no field of a tick; there are {', '.join(self.fields)}") from None

    @property
    def fields(self) -> tuple[str, ...]:
        """Names of what each tick records; the unit is the last part of a name."""
        return self.ticks.dtype.names

    @property
    def time_s(self) -> np.ndarray:
        """When each tick was due, s, shape (n,)."""
        return 1e-9 * self.ticks["scheduled_ns"]

    def to_pandas(self):
        """All fields as pandas.DataFrame, indexed by time_s, where pandas is installed."""
        import pandas
        return pandas.DataFrame({name: self.ticks[name] for name in self.fields},
                                index=pandas.Index(self.time_s, name="time_s"))

    def to_xarray(self):
        """All fields as xarray.Dataset over time_s, where xarray is installed."""
        import xarray
        return xarray.Dataset({name: ("time_s", self.ticks[name]) for name in self.fields}, {"time_s": self.time_s})

    def to_mat(self, path: str | os.PathLike) -> None:
        """All fields and time_s into a .mat file that MATLAB and Octave load, where SciPy is installed."""
        from scipy.io import savemat
        savemat(os.fspath(path), {"time_s": self.time_s, **{name[:63]: self.ticks[name] for name in self.fields}},
                oned_as="column", long_field_names=True)

    def plot(self, axes=None):
        """Positions and force over time; returns the two matplotlib axes."""
        from .plots import plot_ticks
        return plot_ticks(self, axes)


class Run(_Ticks):
    """A run in virtual time.

    verdict         from prediction and motion together
    ticks           structured array, one record a tick; run["force_N"] is a field of it, run.time_s its times
    measured_peak_N, measured_peak_s   the largest measured force, and when
    true_peak_N, true_peak_s           the same in the sensor's spring
    """

    def __init__(self, rig, told: dict):
        self.rig = rig.copy()
        self.verdict = Verdict.of(told)
        self.ticks = _records(told["ticks"], _core.tick_format, _core.tick_bytes)
        self.measured_peak_N, self.measured_peak_s = told["measured_peak"]
        self.true_peak_N, self.true_peak_s = told["true_peak"] or (None, None)

    def __repr__(self) -> str:
        return f"<Run {self.rig.name}: {len(self.ticks)} ticks, {self.verdict.kind}>"

    def _repr_html_(self) -> str:
        return self.verdict._repr_html_()


@dataclass(repr=False)
class Log(_Ticks):
    """A log of a run, in virtual time or on a target.

    ticks   structured array, one record a tick; log["force_N"] is a field of it
    frames, arm, side   the same of CAN frames, of an arm, of further axes; None: the log has none
    rig     the rig that the log was made with
    infos   what the log says of itself, text by key
    cut     its end is missing; whole_until_s: up to where it is whole, s, or None
    """

    ticks: np.ndarray
    frames: np.ndarray | None
    arm: np.ndarray | None
    side: np.ndarray | None
    rig: object
    infos: dict
    cut: bool
    whole_until_s: float | None

    def __repr__(self) -> str:
        return f"<Log of {self.rig.name}: {len(self.ticks)} ticks{', cut' if self.cut else ''}>"


def read_log(path: str | os.PathLike) -> Log:
    """A log (.ulg) as arrays. InputError where it is no log of berth, or damaged."""
    from .rig import Rig
    told = _core.read_log(os.fspath(path))
    topics = {name: _records(raw, log_format) for name, (log_format, raw) in told["topics"].items()}
    empty = np.empty(0, _dtype(_core.tick_format))
    return Log(ticks=topics.get("tick", empty), frames=topics.get("can_frame"), arm=topics.get("arm"),
               side=topics.get("side"), rig=Rig(told["rig"]), infos=told["infos"], cut=told["cut"],
               whole_until_s=told["whole_until_s"])
