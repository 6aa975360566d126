"""scripts/docs/reference/json.md against what the commands print: each key stands there, and none that no command
prints; one quantity has one name. Of `diagnose` its schema, against which its tests validate what it prints."""

import json
import re

import pytest
from conftest import ROOT, command, data_folder, settings

PAGE = ROOT / "scripts" / "docs" / "reference" / "json.md"
SCHEMA = json.loads((ROOT / "scripts" / "diagnosis.schema.json").read_text())
SHORT = settings({"run.duration_s": 2.0})
RUNS = {
    "run": ("ess",),
    "run, a drive": ("ess-cia402",),
    "run, an arm": ("ess-berthing",),
    "run, stopped": ("ess", *settings({"limits.position_min_m": -0.002})),
    "run, contact": ("concept-foam", "--robot", "abb-egm"),
    "run, inverse filter": ("ess", *settings({"robot.transfer_frequency_Hz": 12, "inverse_filter.enabled": "true",
                                              "inverse_filter.bandwidth_Hz": 60})),
}
ASKED = {
    "run, bounces": ("concept-foam", "--no-log", *settings({"manipulator.arm": "ess"})),  # long enough for one
    "deadtime": ("ess",),
    "check": ("ess", *settings({"robot.dead_time_ms": 600})),
    "check, a schedule": ("ess", *settings({"run.dead_time_jump_s": 5, "run.dead_time_jump_ms": 10})),
    "eigen": ("ess",),
    "eigen, a range": ("ess", "--robot", "abb-egm"),
    "eigen, jitter": ("ess", *settings({"robot.jitter_ms": 0.5}), "--ticks", "4000"),
    "eigen, contact": ("concept-foam",),
    "eigen, of a size": ("ess", *settings({"robot.backlash_m": 1e-4}), "--amplitude", "0.01"),
    "eigen, passivity": ("ess", "--with", "passivity"),
    "limits": ("ess",),
    "limits, a range": ("ess", "--robot", "abb-egm"),
    "limits, contact": ("concept-foam",),
    "limits, of a size": ("ess", *settings({"robot.backlash_m": 1e-4}), "--amplitude", "0.01"),
    "reduce": ("ess",),
    "compensate": ("ess", *SHORT),
    "accuracy": ("ess",),
    "effects": (),
    "rigs": (),
    "robots": (),
}
pytestmark = pytest.mark.long


def printed(name, *arguments):
    done = command(name.split(",")[0], *arguments, "--json")
    assert done.stdout, done.stderr.decode()
    return json.loads(done.stdout)


@pytest.fixture(scope="module")
def outputs(tmp_path_factory):
    """What each command prints, by its name and what is special about it."""
    folder = tmp_path_factory.mktemp("json")
    found = {name: printed(name, *words, "--out", folder / str(i), *SHORT)
             for i, (name, words) in enumerate(RUNS.items())}
    log = folder / "0" / "ess.ulg"
    for name in ("replay", "candump"):
        found[name] = printed(name, log)
    damaged = folder / "damaged.ulg"
    damaged.write_bytes(b"".join((log.read_bytes()[:100_000], b"\xff" * 10, log.read_bytes()[100_010:])))
    found["replay, damaged"] = printed("replay", damaged)
    printed("run", "ess", "--out", folder, *settings({"run.duration_s": 12.0}))  # long enough for an envelope
    found["summary"] = printed("summary", folder / "ess.ulg")
    found["compare"] = printed("compare", log, folder / str(list(RUNS).index("run, inverse filter")) / "ess.ulg")
    found["map"] = printed("map", "ess", "--vary", "mass", "--grid", "4x4", "--out", folder)
    printed("commission", "ess", "--stage", "watch", "--out", folder / "stages")
    found["commission"] = printed("commission", "ess", "--stage", "tare", "--out", folder / "stages")
    if data_folder() is not None:
        found["rths"] = printed("rths", data_folder() / "rths", "--perturbed", "1")
    return found | {name: printed(name, *words) for name, words in ASKED.items()}


def names_in(value):
    """Every key at any depth; keys of the rig file have a dot."""
    if isinstance(value, dict):
        for key, inner in value.items():
            yield key
            yield from names_in(inner)
    elif isinstance(value, list):
        for inner in value:
            yield from names_in(inner)


def names_of_schema(schema):
    """Every key that it describes, at any depth."""
    if isinstance(schema, dict):
        yield from schema.get("properties", {})
        for inner in schema.values():
            yield from names_of_schema(inner)


def all_names(outputs):
    """None of `rths` where its data are missing."""
    return {name for output in outputs.values() for name in names_in(output)} | set(names_of_schema(SCHEMA))


def rows(title):
    """The cells of a table of the page, without back quotes."""
    text = PAGE.read_text().split(f"\n## {title}\n")[1].split("\n## ")[0]
    lines = [line for line in text.splitlines() if line.startswith("| `")]
    return [[cell.strip().strip("`") for cell in line.strip("|").split(" | ")] for line in lines]


def test_every_name_is_explained_and_every_explained_name_is_printed(outputs):
    names = {name for name in all_names(outputs) if "." not in name}
    explained = [name for name, _, meaning in rows("Names") if "rths" in outputs or not meaning.startswith("rths:")]
    assert len(explained) == len(set(explained))
    assert names - set(explained) == set()
    assert set(explained) - names == set()


def test_one_quantity_has_one_name(outputs):
    names = all_names(outputs)
    assert "frequency_Hz" in names
    assert len({name.lower() for name in names}) == len(names)


UNITS_OF_ONE_QUANTITY = (("s", "ms", "us", "ns"), ("m", "mm"), ("Hz", "rad_per_s"))


def test_one_quantity_has_one_unit(outputs):
    """No name stands there in two units, such as period_s and period_ms."""
    names = all_names(outputs)
    for units in UNITS_OF_ONE_QUANTITY:
        stems = [name.removesuffix("_" + unit) for unit in units for name in names if name.endswith("_" + unit)]
        assert len(stems) == len(set(stems)), {stem for stem in stems if stems.count(stem) > 1}


def test_a_diagnosis_names_a_parameter_by_its_key_alone():
    for one in ("parameter", "detectable"):
        assert "key" in SCHEMA["$defs"][one]["required"] and "name" not in SCHEMA["$defs"][one]["properties"]


def test_the_unit_of_a_name_is_the_one_that_it_ends_in():
    for name, unit, meaning in rows("Names"):
        ending = unit.replace("1/", "per_").replace("/", "_per_").replace(" ", "_")
        assert name.endswith("_" + ending) if unit else not re.search(r"_(m|s|ms|N|J|Hz|kg|deg|rad|dB)$", name), name
        assert meaning


def test_the_keys_of_each_command_are_listed(outputs):
    listed = {name: set(re.findall(r"[a-zA-Z_0-9]+", keys)) for name, keys in rows("What each command prints")}
    top = {}
    for name, output in outputs.items():
        top.setdefault(name.split(",")[0], set()).update(output[0] if isinstance(output, list) else output)
    top["diagnose"] = set(SCHEMA["properties"])
    if data_folder() is None:
        del listed["rths"]
    assert listed == top
