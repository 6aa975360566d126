"""What the operator's guidance had to hold back is told of a run: by `berth run`, by `berth summary`, and in the report."""

from pathlib import Path

import numpy as np
import pytest
from conftest import RIG_FOLDER, command, one_json_object, run_json, settings, topic
from test_report import made

BERTHING = RIG_FOLDER / "ess-berthing.toml"
NAMES = ("rate", "acceleration", "angle", "singular")
RUNNING = 2
# 3 m are more than the arm reaches.
TOO_FAR = {"limits.position_max_m": 5.3, "limits.velocity_m_per_s": 5, "limits.acceleration_m_per_s2": 100,
           "run.grip_close_s": 39, "run.duration_s": 40}


def stretched(folder):
    text = BERTHING.read_text()
    text = text[:text.index("[[orders]] # pull")].replace("[0.3, 0.0]", "[3.0, 0.0]").replace("= 0.03", "= 0.1")
    file = folder / "stretched.toml"
    file.write_text(text)
    return file


@pytest.fixture(scope="module")
def told(tmp_path_factory):
    folder = tmp_path_factory.mktemp("stretched")
    return stretched(folder), run_json(stretched(folder), folder, *settings(TOO_FAR))


def test_an_order_into_a_singular_pose_leaves_a_trace(told):
    rig, found = told
    guided_by = topic(found["log"], "arm")["guided_by"]
    in_running = topic(found["log"])["state"] == RUNNING
    counted = {name: int(np.sum((guided_by[in_running] >> bit) & 1)) for bit, name in enumerate(NAMES)}
    print(f"limits of the guidance, ticks: {counted}")
    assert found["guidance"]["ticks"] == counted
    assert counted["singular"] > 1000
    first = np.flatnonzero((guided_by >> 3) & in_running)[0]
    assert found["guidance"]["first_s"]["singular"] == pytest.approx(2.5e-3 * first, abs=1e-9)
    assert found["guidance"]["first_s"]["angle"] is None
    shown = command("run", rig, "--no-log", *settings(TOO_FAR)).stdout.decode()
    [line] = [line for line in shown.splitlines() if line.startswith("  guidance ")]
    assert f"singular in {counted['singular']} ticks, first at {2.5e-3 * first:.2f} s" in line
    assert "the tool falls behind its order" in line
    assert "angle" not in line


@pytest.mark.long
def test_a_log_tells_the_same(told):
    log = told[1]["log"]
    assert one_json_object(command("summary", log, "--json").stdout)["guidance"] == told[1]["guidance"]
    assert "  guidance       acted: " in command("summary", log).stdout.decode()
    page, _ = made(Path(log))
    assert f"singular {told[1]['guidance']['ticks']['singular']}" in page.text


def test_without_an_arm_there_is_no_guidance(tmp_path):
    assert run_json("ess", tmp_path, "--set", "run.duration_s=1")["guidance"] is None
    assert "guidance" not in command("run", "ess", "--no-log", "--set", "run.duration_s=1").stdout.decode()


def test_of_what_did_not_act_nothing_is_told(tmp_path):
    """The operator lets go of the tool in a jerk, and that alone is held back; with orders that take their time, nothing."""
    jerk = ("--set", "manipulator.arm=ess", "--set", "run.duration_s=2")
    ticks = run_json("ess", tmp_path, *jerk)["guidance"]["ticks"]
    assert ticks.pop("acceleration") > 0 and set(ticks.values()) == {0}
    shown = command("run", "ess", "--no-log", *jerk).stdout.decode()
    assert "  guidance       acted: acceleration in " in shown and "falls behind" not in shown
    calm = command("run", "ess-berthing", "--no-log", "--set", "run.duration_s=20").stdout.decode()
    assert "  guidance       never acted\n" in calm
