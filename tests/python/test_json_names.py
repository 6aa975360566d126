"""scripts/docs/reference/json.md against what the commands print: each key stands there, and none that no command
prints; one quantity has one name."""

import json
import re

import pytest
from conftest import ROOT, command, settings

PAGE = ROOT / "scripts" / "docs" / "reference" / "json.md"
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


def rows(title):
    """The cells of a table of the page, without back quotes."""
    text = PAGE.read_text().split(f"\n## {title}\n")[1].split("\n## ")[0]
    lines = [line for line in text.splitlines() if line.startswith("| `")]
    return [[cell.strip().strip("`") for cell in line.strip("|").split(" | ")] for line in lines]


def test_every_name_is_explained_and_every_explained_name_is_printed(outputs):
    names = {name for output in outputs.values() for name in names_in(output) if "." not in name}
    explained = [name for name, *_ in rows("Names")]
    assert len(explained) == len(set(explained))
    assert names - set(explained) == set()
    assert set(explained) - names == set()


def test_one_quantity_has_one_name(outputs):
    names = {name for output in outputs.values() for name in names_in(output)}
    assert "frequency_Hz" in names
    assert len({name.lower() for name in names}) == len(names)


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
    assert listed == top
