"""A campaign file: a base rig, what varies, how it is sampled, which questions each sample answers."""
from __future__ import annotations

import hashlib
import json
import math
import os
import re
import tomllib
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path

import numpy as np

from .. import _core
from ..errors import InputError
from ..rig import Rig
from .inputs import PRESET, RECORD, Input
from .places import Places, nearest

# What may be asked of each sample; evaluation.py answers.
ASKS = ("growth", "verdict", "margins", "peak_force", "restitution", "fidelity", "compensation", "diagnosis")
METHODS = ("sobol", "latin-hypercube", "saltelli", "grid")
TOP_KEYS = ("rig", "robot", "name", "ask", "sample", "set", "vary", "correlate", "slurm")
SAMPLE_KEYS = ("method", "count", "seed")
CORRELATE_KEYS = ("keys", "coefficient")
SLURM_KEYS = ("queue", "account", "workers", "cores", "memory", "walltime")
RANGE_KEYS = ("from", "to", "scale", "mean", "sigma", "median", "factor", "likely", "tolerance_percent", "values",
              "count", "files")
COUNT_MAX = 2**62


@dataclass(frozen=True)
class Spec:
    """rig       name of a shipped rig, or the path of a file, whose text is `rig_text`
    fixed     settings on top of it; inputs: what varies; correlations: (index, index, coefficient)
    count     samples; seed: of the sampling, and of each sample's run.seed
    """

    name: str
    rig: str
    rig_text: str
    robot: str
    fixed: dict
    inputs: tuple[Input, ...]
    correlations: tuple
    method: str
    count: int
    seed: int
    asks: tuple[str, ...]
    slurm: dict = field(default_factory=dict, compare=False)
    text: str = field(default="", compare=False, repr=False)

    @classmethod
    def load(cls, path: str | os.PathLike) -> Spec:
        """From a file. InputError with file, line, key and remedy."""
        path = os.fspath(path)
        try:
            text = Path(path).read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError) as error:
            reason = error.strerror if isinstance(error, OSError) else "is no UTF-8 text"
            raise InputError(f"{path}: {reason}; give a campaign file, NAME.toml", path) from None
        return cls.parse(text, path)

    @classmethod
    def parse(cls, text: str, path: str = "campaign.toml") -> Spec:
        """From the text of a file; `path` stands for it in messages, and relative paths start beside it."""
        try:
            table = tomllib.loads(text)
        except tomllib.TOMLDecodeError as error:
            line = re.search(r"at line (\d+)", str(error))
            place = f"{path}:{line[1]}" if line else path
            raise InputError(f"{place}: is no TOML: {error}; see https://toml.io", place) from None
        return replace(_Reader(table, Places(path, text), Path(path)).spec(), text=text)

    def to_json(self) -> dict:
        return asdict(self)

    @classmethod
    def from_json(cls, told: dict) -> Spec:
        inputs = tuple(Input(**{**one, "values": tuple(one["values"])}) for one in told["inputs"])
        return cls(**{**told, "inputs": inputs, "correlations": tuple(map(tuple, told["correlations"])),
                      "asks": tuple(told["asks"])})

    @property
    def identity(self) -> str:
        """Of all that decides the table: samples and questions."""
        known = {key: value for key, value in asdict(self).items() if key not in ("slurm", "name", "text")}
        return hashlib.sha256(json.dumps(known, sort_keys=True, default=repr).encode()).hexdigest()[:16]

    def base(self, values: dict | None = None) -> Rig:
        """The rig with these values of inputs."""
        values = dict(values or {})
        robot = values.pop(PRESET, self.robot)
        values.pop(RECORD, None)
        settings = {**self.fixed, **values}
        if self.rig_text:
            return Rig.parse(self.rig_text, self.rig, settings, robot)
        return Rig.load(self.rig, settings, robot)


class _Reader:
    """Reads one table; every method raises InputError with the key's place."""

    def __init__(self, table: dict, places: Places, path: Path):
        self.table, self.places, self.folder, self.stem = table, places, path.parent, path.stem

    def spec(self) -> Spec:
        self.refuse_unknown("", self.table, TOP_KEYS)
        rig, rig_text = self.rig()
        robot = self.file_or_name(self.text("robot", ""), _core.shipped_robots())
        fixed = dict(self.settings("set"))
        self.bare = Spec("", rig, rig_text, robot, {}, (), (), "grid", 1, 0, ())
        self.try_rig("robot", {})
        self.check_settings(fixed)
        asks = self.asks()
        inputs = tuple(self.input(name, value) for name, value in self.settings("vary"))
        self.refuse_mismatch(inputs, fixed, asks)
        method, count, seed = self.sample(inputs)
        return Spec(self.text("name", self.stem), rig, rig_text, robot, fixed, inputs, self.correlations(inputs, method),
                    method, count, seed, asks, self.slurm())

    def fail(self, key: str, message: str):
        raise self.places.error(key, message)

    def refuse_unknown(self, where: str, table: dict, known) -> None:
        for key in table:
            if key not in known:
                self.fail(f"{where}.{key}".lstrip("."), f"unknown key; {nearest(key, known)}")

    def part(self, key: str, kind: type = dict):
        value = self.table.get(key, kind())
        if not isinstance(value, kind):
            self.fail(key, f"must be a table: write [{key}]" if kind is dict else f"must be a list: write [[{key}]]")
        return value

    def text(self, key: str, default: str | None = None) -> str:
        value = self.table.get(key, default)
        if value is None:
            self.fail(key, "is missing; name a shipped rig or the path of a rig file, as rig = \"ess\"")
        if not isinstance(value, str) or (key in self.table and not value):
            self.fail(key, f"must be text in quotes (is {value!r})")
        return value

    def number(self, key: str, value, whole: bool = False) -> float:
        kinds = (int,) if whole else (int, float)
        if isinstance(value, bool) or not isinstance(value, kinds) or not math.isfinite(value):
            self.fail(key, f"must be a {'whole' if whole else 'finite'} number (is {value!r})"
                      + ("; write it without quotes" if isinstance(value, str) else ""))
        return value

    def file_or_name(self, name: str, shipped) -> str:
        beside = self.folder / name
        return str(beside.resolve()) if name and name not in shipped and beside.is_file() else name

    def rig(self) -> tuple[str, str]:
        rig = self.file_or_name(self.text("rig"), _core.shipped_rigs())
        try:
            Rig.load(rig)
        except InputError as error:
            place = self.places.of("rig")
            raise InputError(f"{place}: rig: {error}", place, "rig") from None
        return rig, "" if rig in _core.shipped_rigs() else Path(rig).read_text(encoding="utf-8")

    def settings(self, section: str):
        """(key of the rig, value), from "object.mass_kg" = 1 as well as from [vary.object] mass_kg = 1."""
        for name, value in self.part(section).items():
            is_section = isinstance(value, dict) and not value.keys() & set(RANGE_KEYS)
            if is_section and "." not in name and value:
                for key, inner in value.items():
                    yield f"{name}.{key}", inner
            else:
                yield name, value

    def check_settings(self, fixed: dict) -> None:
        so_far = {}
        for key, value in fixed.items():
            if not isinstance(value, (bool, int, float, str)):
                self.fail(f"set.{key}", f"must be a number, a truth value or text (is {value!r})")
            so_far[key] = value
            self.try_rig(f"set.{key}", so_far)
        self.fixed_rig = self.try_rig("set", so_far)

    def try_rig(self, key: str, values: dict, varied: str = "") -> Rig | None:
        """With what is wrong at the place of `key`. What a value of `varied` makes wrong elsewhere may be right with
        other values: such samples are refused one by one."""
        try:
            return self.bare.base(values)
        except InputError as error:
            if varied and error.key not in ("", varied):
                return None
            message = str(error).removeprefix(f"{error.place}: ") if error.place else str(error)
            self.fail(key, message.removeprefix(f"{key.partition('.')[2]}: "))

    def asks(self) -> tuple[str, ...]:
        asks = self.table.get("ask", ["growth"])
        asks = [asks] if isinstance(asks, str) else asks
        if not isinstance(asks, list) or not asks:
            self.fail("ask", f"must be a list of questions: {', '.join(ASKS)}")
        for one in asks:
            if one not in ASKS:
                self.fail("ask", f"unknown question {one!r}; {nearest(str(one), ASKS)}")
        return tuple(one for one in ASKS if one in asks)

    def input(self, name: str, value) -> Input:
        key = f"vary.{name}"
        if name in (PRESET, RECORD):
            return self.named_input(name, key, value)
        own = self.value_of(key, name)
        if isinstance(value, list):
            value = {"values": value}
        if not isinstance(value, dict):
            self.fail(key, f"must say how it varies, as {{ from = 80, to = 120 }} or {{ values = [1, 2] }} (is {value!r})")
        self.refuse_unknown(key, value, RANGE_KEYS)
        if "values" in value:
            found = self.values(name, key, value)
        elif isinstance(own, (bool, str)):
            self.fail(key, "is no number; list its values, as { values = [...] }")
        else:
            found = self.range(name, key, value, own)
        for end in (found.values or [x for x in (found.low, found.high, found.middle) if math.isfinite(x)]):
            self.try_rig(key, {**self.fixed_rig_values(), name: int(end) if found.integer else end}, name)
        return found

    def fixed_rig_values(self) -> dict:
        return dict(self.settings("set"))

    def value_of(self, key: str, name: str):
        try:
            return self.fixed_rig[name]
        except InputError as error:
            self.fail(key, str(error).split(f"{name}: ", 1)[-1])

    def named_input(self, name: str, key: str, value) -> Input:
        names = value.get("values", value.get("files")) if isinstance(value, dict) else value
        if not isinstance(names, list) or not names or not all(isinstance(one, str) and one for one in names):
            self.fail(key, "must be a list of names, as { values = [\"...\", \"...\"] }")
        if name == PRESET:
            names = [self.file_or_name(one, _core.shipped_robots()) for one in names]
            for one in names:
                self.try_rig(key, {**self.fixed_rig_values(), PRESET: one})
        else:
            names = sorted(str(path.resolve()) for one in names for path in self.records(key, one))
        return Input(name, "values", values=tuple(names))

    def records(self, key: str, pattern: str):
        found = [Path(pattern)] if os.path.isabs(pattern) and Path(pattern).is_file() else list(self.folder.glob(pattern))
        if not found:
            self.fail(key, f"no file is called {pattern} beside the campaign file; check the name")
        return found

    def values(self, name: str, key: str, value: dict) -> Input:
        values = value["values"]
        if len(value) > 1 or not isinstance(values, list) or not values:
            self.fail(key, "values must be a list, and stand alone: { values = [1, 2, 3] }")
        for one in values:
            if not isinstance(one, (bool, int, float, str)) or (isinstance(one, float) and not math.isfinite(one)):
                self.fail(key, f"a value must be a finite number, a truth value or text (is {one!r})")
        kinds = {bool if isinstance(one, bool) else str if isinstance(one, str) else float for one in values}
        if len(kinds) > 1:
            self.fail(key, "values must be of one kind: numbers, truth values or texts")
        is_whole = isinstance(self.fixed_rig[name], int) and kinds == {float}
        return Input(name, "values", values=tuple(values if is_whole or kinds != {float} else map(float, values)),
                     integer=is_whole)

    def range(self, name: str, key: str, value: dict, own: float) -> Input:
        given = {one: self.number(f"{key}", value[one]) for one in value if one not in ("scale", "count", "values")}
        low, high = given.get("from", -math.inf), given.get("to", math.inf)
        count = int(self.number(key, value["count"], whole=True)) if "count" in value else 0
        integer = isinstance(own, int)
        if "tolerance_percent" in given:
            if len(value) > 1 or not given["tolerance_percent"] > 0.0 or own == 0.0:
                self.fail(key, "tolerance_percent stands alone, is greater than 0, and is of a value that is not 0")
            reach = abs(own) * given["tolerance_percent"] / 100.0
            return Input(name, "uniform", own - reach, own + reach)
        if low >= high:
            self.fail(key, f"from must be less than to (are {low:g} and {high:g})")
        if "mean" in given or "median" in given:
            return self.normal(name, key, given, low, high)
        if not (math.isfinite(low) and math.isfinite(high)):
            self.fail(key, "needs both ends, { from = ..., to = ... }; or mean and sigma; or median and factor; or values")
        scale = value.get("scale", "linear")
        if scale not in ("linear", "log"):
            self.fail(key, f"scale must be \"linear\" or \"log\" (is {scale!r})")
        if scale == "log" and low <= 0.0:
            self.fail(key, "with scale = \"log\" both ends must be greater than 0")
        if "likely" in given:
            if not low <= given["likely"] <= high:
                self.fail(key, "the likely value must lie between from and to")
            return Input(name, "triangular", low, high, given["likely"])
        return Input(name, "log-uniform" if scale == "log" else "uniform", low, high, count=count, integer=integer)

    def normal(self, name: str, key: str, given: dict, low: float, high: float) -> Input:
        if "mean" in given:
            middle, width, least, is_log = given["mean"], given.get("sigma"), 0.0, False
        else:
            middle, width, least, is_log = given["median"], given.get("factor"), 1.0, True
        if width is None or not width > least or (is_log and middle <= 0.0):
            self.fail(key, "median must be greater than 0, and factor, which holds 68 % of the values, greater than 1"
                      if is_log else "mean needs sigma, its standard deviation, greater than 0")
        if not low < middle < high:
            self.fail(key, "the middle must lie between from and to")
        return Input(name, "log-normal" if is_log else "normal", low, high, middle, width)

    def refuse_mismatch(self, inputs, fixed: dict, asks) -> None:
        names = [one.name for one in inputs]
        if not inputs:
            self.fail("vary", "nothing varies; write [vary] and a key of the rig, as "
                      "\"object.mass_kg\" = { from = 80, to = 120 }")
        for name in names:
            if name in fixed or names.count(name) > 1:
                self.fail(f"vary.{name}", "has a value and varies; leave out one of them")
        if (RECORD in names) != ("diagnosis" in asks):
            self.fail("ask", "a diagnosis needs records that vary, and records a diagnosis: "
                      "[vary] record = { files = [\"records/*.csv\"] } and ask = [\"diagnosis\"]")
        if PRESET in names and "robot" in self.table:
            self.fail("robot", "a preset is stated and varies; leave out one of them")

    def sample(self, inputs) -> tuple[str, int, int]:
        table = self.part("sample")
        self.refuse_unknown("sample", table, SAMPLE_KEYS)
        method = table.get("method", "sobol")
        if method not in METHODS:
            self.fail("sample.method", f"unknown method {method!r}; {nearest(str(method), METHODS)}")
        seed = int(self.number("sample.seed", table.get("seed", 1), whole=True))
        if not 0 <= seed < 2**32:
            self.fail("sample.seed", f"must be from 0 to {2**32 - 1} (is {seed})")
        for one in inputs:
            if method == "grid" and one.grid_count < 1:
                self.fail(f"vary.{one.name}", "in a grid it needs values, or from, to and count")
            if method != "grid" and one.count:
                self.fail(f"vary.{one.name}", "count is for a grid; set sample.method = \"grid\", or leave it out")
        if method == "grid":
            if "count" in table:
                self.fail("sample.count", "a grid has as many samples as its inputs have values; leave it out")
            return method, math.prod(one.grid_count for one in inputs), seed
        count = self.number("sample.count", table.get("count", 0), whole=True)
        if not 1 <= count <= COUNT_MAX:
            self.fail("sample.count", f"must be at least 1 (is {count}); 4096 is a good start")
        if method == "saltelli":
            stride = len(inputs) + 2
            base = 2 ** round(math.log2(max(count / stride, 1.0)))
            if base * stride != count:
                self.fail("sample.count", f"with {len(inputs)} inputs it must be a power of two times {stride}; "
                          f"the nearest is {base * stride}")
        return method, int(count), seed

    def correlations(self, inputs, method: str) -> tuple:
        names = [one.name for one in inputs]
        matrix, found = np.eye(len(names)), []
        for one in self.part("correlate", list):
            self.refuse_unknown("correlate", one, CORRELATE_KEYS)
            keys = one.get("keys")
            coefficient = self.number("correlate.coefficient", one.get("coefficient", "missing"))
            if method in ("grid", "saltelli"):
                self.fail("correlate", f"with the method {method} inputs are independent; choose sobol")
            if not isinstance(keys, list) or len(keys) != 2 or len(set(map(str, keys))) != 2:
                self.fail("correlate.keys", "must name two inputs, as [\"object.mass_kg\", \"object.stiffness_N_per_m\"]")
            for key in keys:
                if key not in names or not inputs[names.index(key)].is_number:
                    self.fail("correlate.keys", f"{key} is no number that varies; {nearest(str(key), names)}")
            if not -1.0 < coefficient < 1.0:
                self.fail("correlate.coefficient", f"must lie between -1 and 1 (is {coefficient:g})")
            i, j = sorted(map(names.index, keys))
            matrix[i, j] = matrix[j, i] = coefficient
            found.append((i, j, float(coefficient)))
        if np.linalg.eigvalsh(matrix).min() <= 0.0:
            self.fail("correlate", "these coefficients contradict each other: their matrix is not positive definite; "
                      "lower one of them")
        return tuple(found)

    def slurm(self) -> dict:
        table = self.part("slurm")
        self.refuse_unknown("slurm", table, SLURM_KEYS)
        return table
