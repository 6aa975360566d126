"""A record with a hidden effect, from the generator of tests/hidden_effects, and what the program tells of it."""

import json
import subprocess
import sys

import pytest
from conftest import ROOT, command

GENERATE = ROOT / "tests/hidden_effects/generate.py"


def slow(*arguments):
    """Of a test that takes long with them: `make slow-test`."""
    return pytest.param(*arguments, marks=pytest.mark.slow)


def hidden_and_told(folder, seed, *arguments, rows=None, missing=(), options=()):
    """The effects that the generator hides and what is told of the record; with `rows`, of its beginning alone; without
    the rows that are `missing`."""
    record, truth = folder / "record", folder / "truth"
    hide = [sys.executable, str(GENERATE), "--seed", str(seed), *arguments]
    print("again: python", *hide[1:], "--out A --truth B")
    subprocess.run([*hide, "--out", record, "--truth", truth], check=True, stdout=subprocess.DEVNULL)
    if rows is not None:
        lines = (record / "record.csv").read_text().splitlines(keepends=True)
        (record / "record.csv").write_text("".join(lines[:rows + 1]))
        for name in ("validate", "repeat", "standstill"):
            (record / f"{name}.csv").unlink(missing_ok=True)
    if missing:
        lines = (record / "record.csv").read_text().splitlines(keepends=True)
        (record / "record.csv").write_text("".join(line for n, line in enumerate(lines) if n - 1 not in set(missing)))
    more = [part for name in ("validate", "repeat", "standstill") if (record / f"{name}.csv").exists()
            for part in (f"--{name}", record / f"{name}.csv")]
    done = command("diagnose", record / "record.csv", "--rig", record / "rig.toml", *more, *options, "--out",
                   folder / "out")
    assert done.returncode == 0, done.stderr.decode()
    return (json.loads((truth / "truth.json").read_text())["effects"],
            json.loads((folder / "out/diagnosis.json").read_text()))
