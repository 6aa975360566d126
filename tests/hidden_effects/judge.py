"""Judges one diagnosis by the truth: pure functions of two JSON files.

    right     each detectable effect is among the causes, and no cause is wrong. The verdict is `named`; where the
              truth has richer physics than the library, `partly_explained` says so rightly and counts as well
    wrong     `named`, not flagged as partial, and a cause is not the truth's (nor inseparable from it here)
    missed    anything else although an effect was detectable
    quiet     nothing is named outright, and nothing was detectable
"""

import math
from dataclasses import asdict, dataclass, field

GAIN_LIMIT = 1.1

# Effects that a diagnosis tells as several: dry friction that differs between the directions is, while the body moves,
# dry friction and a constant force.
PARTS = {"manipulator.asymmetric_friction": {"manipulator.coulomb_friction", "manipulator.gravity_offset"}}
SAME_PARAMETER = {"friction_asymmetry_N": "gravity_offset_N"}


@dataclass
class Judgement:
    """How one record went. `intervals`: [(parameter, inside)] if right; `gain`: held-out rms by true floor."""

    outcome: str
    verdict: str
    causes: list
    wrong_causes: list = field(default_factory=list)
    intervals: list = field(default_factory=list)
    gain: float | None = None

    def as_json(self):
        return asdict(self)


def inside(name, true, value, low, high):
    """A true parameter lies in the interval; phases are compared modulo a turn."""
    if name.endswith("_rad"):
        turn = 2.0 * math.pi
        true += turn * round((value - true) / turn)
    return low <= true <= high


def intervals(truth, diagnosis):
    """[(effect.parameter, inside)] of the causes that are right; a parameter that is not reported is outside."""
    found = []
    for entry in truth["effects"]:
        if entry["effect"] not in diagnosis.parameters:
            continue
        reported = {}
        for effect in (*PARTS.get(entry["effect"], ()), entry["effect"]):
            reported |= diagnosis.parameters.get(effect, {})
        for name, true in entry["parameters"].items():
            name = name if name in reported else SAME_PARAMETER.get(name, name)
            ok = name in reported and inside(name, true, *reported[name])
            found.append((f"{entry['effect']}.{name}", ok))
    return found


def gain(truth, diagnosis):
    """Largest held-out residual after the extension, in units of the true floor; None if none is reported.

    What a quantised sensor rounds away is gone: where it was hidden, its share of the force counts to the floor.
    """
    step_N = max([entry["parameters"].get("resolution_N", 0.0) for entry in truth["effects"]], default=0.0)
    floor = truth["floor_rms"] | {"force_N": math.hypot(truth["floor_rms"].get("force_N", 0.0), step_N / math.sqrt(12.0))}
    ratios = [after / floor[channel] for channel, after in diagnosis.held_out.items()
              if floor.get(channel, 0.0) > 1e-9]
    return max(ratios, default=None)


def detectable(truth):
    """The names of the effects that the record shows."""
    return [entry["effect"] for entry in truth["effects"] if entry["detectability"]["detectable"]]


def is_confident(diagnosis):
    return diagnosis.verdict == "named" and not diagnosis.partial


def offered(diagnosis):
    """All names that a diagnosis leaves the choice between."""
    return {*diagnosis.causes, *diagnosis.alternatives}


def is_rightly_undecided(diagnosis, visible, true):
    """`one_of` what is visible and what this record cannot tell from the truth, and nothing else."""
    names = offered(diagnosis)
    return diagnosis.verdict == "one_of" and visible <= names <= true


def judge(truth, diagnosis, inseparable=()):
    """The judgement of a record; `inseparable`: names that this record cannot tell from the truth."""
    true = {entry["effect"] for entry in truth["effects"]} | set(inseparable)
    true |= {part for name in true for part in PARTS.get(name, ())}
    visible = set(detectable(truth))
    wrong = [name for name in diagnosis.causes if name not in true]
    named = set(diagnosis.causes) | ({entry["effect"] for entry in truth["effects"]}
                                     if set(diagnosis.causes) & set(inseparable) else set())
    named |= {whole for whole, parts in PARTS.items() if parts <= named}
    verdicts = {"named", "partly_explained"} if truth["richer"] else {"named"}
    found = Judgement("quiet", diagnosis.verdict, diagnosis.causes, wrong)
    in_library = all(not name.startswith("outside.") for name in true)
    if is_confident(diagnosis) and wrong:
        found.outcome = "wrong"
    elif visible and in_library and not wrong and visible <= named and diagnosis.verdict in verdicts:
        found.outcome = "right"
        found.intervals = intervals(truth, diagnosis)
        found.gain = gain(truth, diagnosis)
    elif visible and is_rightly_undecided(diagnosis, visible, true):
        found.outcome = "right"
        found.intervals = intervals(truth, diagnosis)
        found.gain = gain(truth, diagnosis)
    elif visible:
        found.outcome = "missed"
    elif diagnosis.causes and not wrong and diagnosis.verdict == "named":
        found.outcome = "right"  # more than was asked for
        found.intervals = intervals(truth, diagnosis)
    return found


def names_nothing(diagnosis):
    """For a fault-free record: no cause, under whatever verdict."""
    return not diagnosis.causes and diagnosis.verdict not in ("named", "one_of", "partly_explained")


def admits_ignorance(diagnosis, inseparable=()):
    """For a record whose cause is not in the library: it says so, or what it names is flagged or inseparable."""
    if diagnosis.verdict in ("unknown", "partly_explained") or (diagnosis.verdict == "named" and diagnosis.partial):
        return True
    return diagnosis.verdict in ("named", "one_of") and offered(diagnosis) <= set(inseparable)
