"""Rigs: what is simulated, driven and measured, as a rig file describes it."""
from __future__ import annotations

import math
import numbers
import os
from collections.abc import Iterator, Mapping

import numpy as np

from . import _core
from .answers import Compensation, Limit, Map, Spectrum, Verdict
from .errors import InputError
from .run import Run

Value = bool | int | float | str


def _text(key: str, value: Value) -> str:
    """A value as it stands in a rig file."""
    if isinstance(value, (bool, np.bool_)):
        return "true" if value else "false"
    if isinstance(value, numbers.Integral):
        return str(int(value))
    if isinstance(value, numbers.Real):
        if math.isnan(value):
            raise InputError(f"{key}: must be a number (is nan)", "", key)
        return repr(float(value))
    if isinstance(value, (str, os.PathLike)):
        return os.fspath(value)
    raise TypeError(f"{key}: a value is a number, a truth value or text, and no {type(value).__name__}")


def _settings(values: Mapping[str, Value]) -> list[str]:
    return [f"{key}={_text(key, value)}" for key, value in values.items()]


class Rig:
    """A rig: keys of a rig file and their values, units in the names.

    >>> rig = Rig.load("ess")
    >>> rig["object.mass_kg"] = 120
    >>> rig.verdict().kind
    'stable'

    A change is refused with InputError where a rig file would be, and leaves the rig as it was. Rigs may be used by
    several threads as long as each changes its own copy(); runs and answers do not hold Python up.
    """

    def __init__(self, core: _core.Rig):
        self._core = core

    @classmethod
    def load(cls, name_or_path: str | os.PathLike, settings: Mapping[str, Value] | None = None, robot: str = "") -> Rig:
        """A shipped rig by its name (see shipped_rigs()) or a rig file by its path.

        settings  keys and values on top of the file, as `--set` takes them
        robot     a robot preset by name (see shipped_robots()) or the path of one
        """
        return cls(_core.Rig.load(os.fspath(name_or_path), _settings(settings or {}), robot))

    @classmethod
    def parse(cls, toml: str, name: str = "rig", settings: Mapping[str, Value] | None = None, robot: str = "") -> Rig:
        """A rig from the text of a rig file; `name` stands for the file's in messages."""
        return cls(_core.Rig.parse(toml, name, _settings(settings or {}), robot))

    def __getitem__(self, key: str) -> Value:
        return self._core.get(key)

    def __setitem__(self, key: str, value: Value) -> None:
        self._core.set(f"{key}={_text(key, value)}")

    def __iter__(self) -> Iterator[str]:
        return iter(_core.keys())

    def __len__(self) -> int:
        return len(_core.keys())

    def __contains__(self, key: str) -> bool:
        return key in _core.keys()

    def update(self, settings: Mapping[str, Value]) -> None:
        """Several values at once: all of them, or, if one is refused, none."""
        core = self._core.copy()
        for setting in _settings(settings):
            core.set(setting)
        self._core = core

    def copy(self) -> Rig:
        return Rig(self._core.copy())

    @property
    def name(self) -> str:
        return self._core.name

    @property
    def description(self) -> str:
        return self._core.description

    @property
    def toml(self) -> str:
        """The whole rig as a rig file: each key, what it means, and whether it was given or is assumed."""
        return self._core.toml

    @property
    def config_hash(self) -> str:
        """Names this configuration, in logs as well."""
        return self._core.hash

    @property
    def assumed(self) -> dict[str, str]:
        """Keys that the answer depends on and that nobody stated, with the values that were taken."""
        return dict(self._core.assumed)

    @property
    def delay_budget(self) -> dict[str, float]:
        """Where the delay of the loop comes from, in ms, in the order of the signal; the parts add up to the whole."""
        return dict(self._core.delay_budget)

    def eigenvalues(self) -> Spectrum:
        """Eigenvalues of one period of the loop, as `berth eigen` has them. InputError where a loop has none: with a
        compensation that is not linear, or where it changes from tick to tick."""
        self._core.refuse_unstated()
        return Spectrum(**_core.spectrum(self._core))

    def verdict(self, advice: bool = True) -> Verdict:
        """Will it blow up? From the model alone, as `berth eigen` answers.

        advice  also seek the margin of a stable loop and the smallest change that cures an unstable one
        """
        self._core.refuse_unstated()
        return Verdict.of(_core.answer(self._core, advice))

    def run(self, log: str | os.PathLike = "", advice: bool = True) -> Run:
        """Firmware and simulated rig in virtual time, as `berth run`; its length is run.duration_s.

        log     path of a log to write (ULog); none if empty
        advice  as for verdict()
        """
        self._core.refuse_unstated()
        return Run(self, _core.run(self._core, os.fspath(log), advice))

    def limits(self) -> dict[str, Limit]:
        """How far each physical parameter may go, as `berth limits`: by key, in the unit of the key."""
        self._core.refuse_unstated()
        return {key: Limit(key=key, **found) for key, found in _core.limits(self._core).items()}

    def map(self, x: tuple[str, float, float, int], y: tuple[str, float, float, int], threads: int = 0) -> Map:
        """Growth over two keys, each (key, from, to, count). As `berth map`; points that no rig may have are nan.

        threads  0: one for each core
        """
        self._core.refuse_unstated()
        axes = [_core.Axis(*axis) for axis in (x, y)]
        return Map.of(axes, _core.map(self._core, *axes, threads or os.cpu_count() or 1), self)

    def compensate(self, duration_s: float = 10.0) -> Compensation:
        """Every compensation of the dead time on this rig and on rigs that are somewhat different, as
        `berth compensate`; each trial lasts `duration_s` of simulated time."""
        self._core.refuse_unstated()
        return Compensation.of(_core.compensate(self._core, duration_s))

    def __repr__(self) -> str:
        changed = "".join(f", {setting}" for setting in self._core.settings)
        return f"<Rig {self.name}{changed}>"

    def _repr_html_(self) -> str:
        return self.verdict()._repr_html_()
