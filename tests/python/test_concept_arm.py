"""The concept test with a whole arm whose satellite is held: the loop's stability depends on the material alone."""

import json
import sys
from pathlib import Path

import numpy as np
import pytest
from conftest import RIG_FOLDER, ROOT, command, replay_json, run_json, topic
from test_report import made

sys.path.insert(0, str(ROOT / "scripts"))
import report_arm  # noqa: E402
from berth_log import read_log  # noqa: E402


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("concept")
    return {material: run_json(f"concept-arm-{material}", folder) for material in ("foam", "copper")}


def test_foam_stays_and_copper_blows_up(runs):
    foam, copper = runs["foam"], runs["copper"]
    print(f"foam {foam['growth_per_s']:+.4f} /s, copper {copper['growth_per_s']:+.4f} /s")
    assert foam["stable"] is True and foam["state"] == "running"
    assert not any(foam["limit_ticks"].values())
    assert copper["stable"] is False and copper["stop_cause"] == "position_limit"
    assert copper["peak_force_N"] > 100 * foam["peak_force_N"]


@pytest.mark.long
@pytest.mark.parametrize("material", ["foam", "copper"])
def test_it_replays_and_is_shown_from_the_side(runs, material):
    log = runs[material]["log"]
    assert replay_json(log)["equal"] is True
    assert np.ptp(topic(log, "arm")["joint_0_rad"]) > 1e-3
    assert "The arm from the side" in made(Path(log))[0].text
    assert json.loads(report_arm.scene(read_log(Path(log))))["frames"] > 50


def test_the_held_arm_is_the_arm_ess_but_for_its_satellite():
    folder = RIG_FOLDER.parent / "arms"
    free, held = ((folder / f"{name}.toml").read_text().splitlines() for name in ("ess", "ess-held"))
    changed = [line for line in held if line not in free]
    assert [line.split(" = ")[0] for line in changed] == ["name", "description", "is_free"]
    left_out = free[free.index("[attitude]"):]
    assert [line for line in free if line not in held and line not in left_out] == [
        line for line in free if line.split(" = ")[0] in ("name", "description", "is_free")][:3]
