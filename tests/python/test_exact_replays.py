"""Hidden effects whose own history a replay has to follow exactly: down to the noise, with the size that was hidden.

A bent spring of the manipulator makes each window depend on where it starts; a grip that gives way decides all that
follows. Records come from the generator of tests/hidden_effects, which shares no code with the program.
"""

import json
import subprocess
import sys

import pytest
from conftest import ROOT, command

GENERATE = ROOT / "tests/hidden_effects/generate.py"


@pytest.mark.parametrize("seed, effect, block", [
    (102, "manipulator.quadratic_stiffness", "manipulator"), (105, "manipulator.cubic_stiffness", "manipulator"),
    (103, "manipulator.backlash", "manipulator"), (104, "object.loss_of_contact", "force"),
])
def test_what_was_hidden_is_named_with_its_size_and_leaves_noise(seed, effect, block, tmp_path):
    record, truth = tmp_path / "record", tmp_path / "truth"
    hide = [sys.executable, str(GENERATE), "--seed", str(seed), "--effect", effect, "--size", "large"]
    print("again: python", *hide[1:], "--out A --truth B")
    subprocess.run([*hide, "--out", record, "--truth", truth], check=True, stdout=subprocess.DEVNULL)
    more = [part for name in ("validate", "repeat", "standstill") if (record / f"{name}.csv").exists()
            for part in (f"--{name}", record / f"{name}.csv")]
    done = command("diagnose", record / "record.csv", "--rig", record / "rig.toml", *more, "--out", tmp_path / "out")
    assert done.returncode == 0, done.stderr.decode()
    told = json.loads((tmp_path / "out/diagnosis.json").read_text())
    hidden = json.loads((truth / "truth.json").read_text())["effects"][0]
    found = next(one for one in told["blocks"] if one["block"] == block)
    print(hidden["parameters"], [(c["effect"], [(p["name"], p["value"]) for p in c["parameters"]]) for c in found["causes"]],
          found["residual"]["fit"])
    assert told["verdict"] == "named" and [c["effect"] for c in found["causes"]] == [effect]
    for parameter in found["causes"][0]["parameters"]:
        assert parameter["value"] == pytest.approx(hidden["parameters"][parameter["name"]], rel=1e-3)
    assert found["residual"]["fit"]["after"] < 1.1 * found["residual"]["fit"]["floor"]
