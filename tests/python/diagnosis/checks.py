"""What a row of a table expects of a diagnosis. Each check is a function of `Told`; its name and arguments say what."""

import functools
import pathlib
from dataclasses import dataclass

import numpy as np
import pytest


def near(value, rel=None, abs=None):
    return pytest.approx(value, rel=rel, abs=abs)


@dataclass(frozen=True)
class Between:
    """low < value < high."""

    low: float = -np.inf
    high: float = np.inf

    def __eq__(self, value):
        return self.low < value < self.high


def name_of(parameter):
    """Of {key, value, ...}: its key without the section."""
    return parameter["key"].split(".")[1]


@dataclass
class Told:
    """A diagnosis with all that it left, and the truth of the record."""

    found: dict
    text: str
    out: pathlib.Path
    truth: dict
    record: pathlib.Path

    @functools.cached_property
    def series(self):
        return np.genfromtxt(self.out / "series.csv", delimiter=",", names=True)

    @property
    def verdict(self):
        return self.found["verdict"]

    @property
    def causes(self):
        return [cause["effect"] for cause in self.found["causes"]]

    @property
    def offered(self):
        """Causes and those that do as well."""
        return {*self.causes, *(other["effect"] for other in self.found["alternatives"])}

    def block(self, name):
        return next(one for one in self.found["blocks"] if one["block"] == name)

    def cause(self, effect):
        return next(one for one in self.found["causes"] if one["effect"] == effect)

    def parameter(self, name):
        """{value, ci95, ...} of a parameter, as lag_ms or robot.lag.lag_ms. Where several causes have it, that of the last
        one, which was fitted beside the others."""
        effect, _, name = name.rpartition(".")
        return [one for cause in self.found["causes"] if effect in ("", cause["effect"])
                for one in cause["parameters"] if name_of(one) == name][-1]

    def at(self, path):
        """What stands at a path such as residual.force_N.fit.after or blocks.robot.verdict: a block by its name."""
        found = self.found | {"blocks": {one["block"]: one for one in self.found["blocks"]}}
        for name in path.split("."):
            found = found[int(name) if name.isdigit() else name]
        return found

    def __str__(self):
        lines = [f"{self.verdict}: {', '.join(self.causes) or 'no cause'}; {self.record}"]
        for one in self.found["blocks"]:
            lines.append(f"  {one['block']}: {one['verdict']} {one['residual']['fit']} {one['doubts']}")
        for cause in self.found["causes"]:
            lines += [f"  {cause['effect']}.{name_of(p)} = {p['value']} {p['ci95']}" for p in cause["parameters"]]
        return "\n".join(lines + [f"  note: {note}" for note in self.found["notes"]])


def check(function):
    """A function `check(told, ...)` that asserts becomes `check(...)`, which a row holds."""
    @functools.wraps(function)
    def with_values(*words, **given):
        def on(told):
            function(told, *words, **given)
        on.__qualname__ = f"{function.__name__}{words or ''}{given or ''}"
        return on
    return with_values


# --- the verdict --------------------------------------------------------------------------------------------------
@check
def verdict(told, *allowed):
    assert told.verdict in allowed


@check
def not_verdict(told, *excluded):
    assert told.verdict not in excluded


@check
def causes(told, *names):
    """These and no others, in any order."""
    assert sorted(told.causes) == sorted(names)


@check
def causes_in_order(told, *names):
    assert told.causes == list(names)


@check
def has_cause(told, *names):
    assert set(names) <= set(told.causes)


@check
def no_cause(told, *names):
    """None of these; without names none at all."""
    assert not (set(names) & set(told.causes) if names else told.causes)


@check
def offers(told, *names):
    """As causes or as what does as well."""
    assert set(names) <= told.offered


@check
def offers_only(told, *names):
    assert told.offered == set(names)


@check
def offers_no(told, *names):
    assert not set(names) & told.offered


@check
def named(told, *names):
    """Outright: these causes and no others."""
    assert told.verdict == "named" and sorted(told.causes) == sorted(names)


@check
def nothing(told):
    assert told.verdict == "nothing_detectable" and told.causes == []


@check
def block(told, name, *verdicts, cause=None):
    one = told.block(name)
    assert one["verdict"] in verdicts
    assert cause is None or [each["effect"] for each in one["causes"]] == cause


@check
def doubt(told, name, text):
    """The block's doubts say so; without a block's name, those of any."""
    blocks = [told.block(name)] if name else told.found["blocks"]
    assert any(text in one for block in blocks for one in block["doubts"])


@check
def no_doubt(told, name, text):
    assert not any(text in one for one in told.block(name)["doubts"])


@check
def note(told, *texts):
    """One note holds all of them."""
    assert any(all(text in one for text in texts) for one in told.found["notes"])


@check
def no_note(told, *texts):
    """No note holds all of them."""
    assert not any(all(text in one for text in texts) for one in told.found["notes"])


# --- sizes --------------------------------------------------------------------------------------------------------
@check
def size(told, name, expected):
    """A parameter's value: `near(...)` or `Between(...)`."""
    assert told.parameter(name)["value"] == expected


@check
def interval(told, name, true, wider=0.0):
    """The interval of 95 % holds the true value; `wider`: by this share of its width, on both sides."""
    low, high = told.parameter(name)["ci95"]
    more = wider * (high - low)
    assert low - more < true < high + more


@check
def width(told, name, less_than):
    """Of the interval of 95 %."""
    low, high = told.parameter(name)["ci95"]
    assert high - low < less_than


@check
def at(told, path, expected):
    """What stands at a path of diagnosis.json (a block by its name: blocks.force.verdict)."""
    assert told.at(path) == expected


@check
def prints(told, *texts):
    for text in texts:
        assert text in told.text


# --- a hidden effect, by the truth that the generator wrote -------------------------------------------------------
@check
def finds_what_is_hidden(told, *names):
    """The record hides these, and the diagnosis names them outright."""
    assert sorted(one["effect"] for one in told.truth["effects"]) == sorted(names)
    assert told.verdict == "named" and sorted(told.causes) == sorted(names)


def hidden_value(told, name):
    [value] = [one["parameters"][name] for one in told.truth["effects"] if name in one["parameters"]]
    return value


@check
def sizes_as_hidden(told, rel, *names):
    """The parameters `names`, or all of every cause, within `rel` of the hidden ones."""
    for name in names or [name_of(one) for cause in told.found["causes"] for one in cause["parameters"]]:
        assert told.parameter(name)["value"] == near(hidden_value(told, name), rel), name


@check
def intervals_hold_what_is_hidden(told, twice=False):
    """Of all parameters; `twice`: within twice the stated 95 %, beyond which a draw lies once in ten thousand."""
    for cause in told.found["causes"]:
        [truth] = [one["parameters"] for one in told.truth["effects"] if one["effect"] == cause["effect"]]
        for parameter in cause["parameters"]:
            low, high = parameter["ci95"]
            true = truth[name_of(parameter)]
            if twice:
                assert abs(parameter["value"] - true) < high - low, parameter
            else:
                assert low < true < high, parameter


@check
def leaves_noise(told, channel, *parts, times=1.1):
    """In these parts (fit, held_out) no more is left than so many times the true noise."""
    for part in parts:
        assert told.at(f"residual.{channel}.{part}.after") < times * told.truth["floor_rms"][channel], part
