"""Reads a diagnosis.json: the one place that knows its shape.

    verdict            named, one_of, partly_explained, unknown, nothing_detectable
    partial            true: named, yet flagged as not the full cause (optional)
    causes             [{effect, parameters: [{name, value, ci95: [low, high], unit}], ...}]
    alternatives       [{effect, ...}] or [name]
    residual           {channel: {part: {before, after, floor}}}, part: fit, held_out
"""

import json
import pathlib
from dataclasses import dataclass

VERDICTS = {"named", "one_of", "partly_explained", "unknown", "nothing_detectable"}


class BadDiagnosis(Exception):
    """The file is not what the schema says."""


@dataclass
class Diagnosis:
    """`parameters`: {effect: {name: (value, low, high)}}; `held_out`: {channel: rms after the extension}."""

    verdict: str
    partial: bool
    causes: list
    alternatives: list
    parameters: dict
    held_out: dict


def effect_name(entry):
    return entry if isinstance(entry, str) else entry["effect"]


def parameter(entry):
    """(name, (value, low, high)); a gain's error from 1 becomes the gain."""
    name = entry["key"].split(".")[1]
    if name == "gain_error":
        return "gain", tuple(1.0 + value for value in (entry["value"], *entry["ci95"]))
    return name, (entry["value"], *entry["ci95"])


def parse(content):
    """A Diagnosis of the JSON object."""
    try:
        verdict = content["verdict"]
        causes = content.get("causes", [])
        parameters = {
            cause["effect"]: dict(parameter(p) for p in cause.get("parameters", []))
            for cause in causes
        }
        held_out = {channel: parts["held_out"]["after"] for channel, parts in content.get("residual", {}).items()}
        alternatives = [effect_name(entry) for entry in content.get("alternatives", [])]
    except (KeyError, TypeError, ValueError) as error:
        raise BadDiagnosis(f"diagnosis.json: {type(error).__name__}: {error}") from error
    if verdict not in VERDICTS:
        raise BadDiagnosis(f"diagnosis.json: verdict {verdict!r}")
    names = [cause["effect"] for cause in causes]
    if verdict == "named" and not names:
        raise BadDiagnosis("diagnosis.json: named, but no cause")
    return Diagnosis(verdict, bool(content.get("partial", False)), names, alternatives, parameters, held_out)


def read(path):
    """A Diagnosis of the file."""
    try:
        return parse(json.loads(pathlib.Path(path).read_text()))
    except (OSError, ValueError) as error:
        raise BadDiagnosis(f"diagnosis.json: {error}") from error
