"""The moving picture of the arm in a report: bodies where the log has them, and a page that plays it."""

import dataclasses
import json
import sys

import numpy as np
import pytest
from browser import Browser
from conftest import ROOT, command
from test_report import made, run

sys.path.insert(0, str(ROOT / "scripts"))
import report_arm  # noqa: E402
from berth_log import read_log  # noqa: E402


@pytest.fixture(scope="module")
def berthing(tmp_path_factory):
    log, _ = run(tmp_path_factory.mktemp("berthing"), "ess-berthing", ["run.duration_s=12"])
    return log


def test_the_tool_is_where_the_firmware_has_it(berthing):
    """Python's kinematics from the angles against the tool's place that the firmware logs."""
    log = read_log(berthing)
    points, _ = report_arm.places(log.config["manipulator"]["arm"], log.arm)
    for i, part in enumerate("xyz"):
        assert np.abs(points[:, -1, i] - log.arm[f"tool_{part}_m"]).max() < 1e-12
    assert np.ptp(points[:, -1, 0]) > 0.2


def test_a_spatial_arm_is_placed_too(tmp_path):
    """Seven joints on a turned base: the same, by quaternion and Rodrigues' formula."""
    text = command("arm", ROOT / "tests" / "arms" / "seven.urdf", "--tool", "gripper").stdout.decode()
    arm = tmp_path / "seven.toml"
    arm.write_text(text)
    log, _ = run(tmp_path, "ess", [f"manipulator.arm={arm}", "manipulator.direction_z=0.5", "run.duration_s=3",
                                   "manipulator.initial_position_m=0", "profile.kind=minimum_jerk",
                                   "profile.amplitude_m=0.05"])
    log = read_log(log)
    points, _ = report_arm.places(log.config["manipulator"]["arm"], log.arm)
    for i, part in enumerate("xyz"):
        assert np.abs(points[:, -1, i] - log.arm[f"tool_{part}_m"]).max() < 1e-12
    assert np.ptp(log.arm["base_quaternion_w"]) > 0 and np.ptp(log.arm["tool_x_m"]) > 1e-3


@pytest.mark.long
def test_the_page_plays_it(berthing, tmp_path):
    made(berthing)
    with Browser(berthing.with_suffix(".html"), tmp_path) as browser:
        first = browser.evaluate("document.getElementById('arm-links').getAttribute('points')")
        browser.evaluate("document.getElementById('arm-speed').value = '20'")
        browser.evaluate("document.getElementById('arm-play').click()")
        browser.evaluate("""(async () => {
          const slider = document.getElementById("arm-time");
          while (slider.value !== slider.max) await new Promise(requestAnimationFrame);
        })()""")
        last = browser.evaluate("document.getElementById('arm-links').getAttribute('points')")
        assert browser.evaluate("document.getElementById('arm-clock').textContent").startswith("12.0 s")
        assert browser.console == []
    log = read_log(berthing)
    ends = [[float(value) for value in points.split()[-1].split(",")] for points in (first, last)]
    for (x, y), tick in zip(ends, (0, 20 * (len(log.tick_s) // 20) - 20)):
        assert x == pytest.approx(log.arm["tool_x_m"][tick], abs=1e-5)
        assert -y == pytest.approx(log.arm["tool_y_m"][tick], abs=1e-5)


def test_the_object_is_where_the_rig_has_it(tmp_path):
    """Foam before the touch lies with its face at the surface, and under the tool while it is pressed."""
    log, _ = run(tmp_path, "concept-arm-foam", ["run.duration_s=8"])
    log = read_log(log)
    parts, way, _ = report_arm.parts_of(log)
    assert way.tolist() == [1.0, 0.0]
    face, back = parts["object"][:, 0, 0], parts["object"][:, 2, 0]
    start = log.arm["tool_x_m"][0] - log.tick["manipulator_position_m"][0]
    assert np.abs(face[:40] - start).max() < 1e-9
    pressed = log.rig["object_position_m"] > 1e-4
    assert np.count_nonzero(pressed) > 1000
    # The tool leads the robot by the dead time of 17.5 ms at up to 5 cm/s.
    assert np.abs(face - log.arm["tool_x_m"])[pressed].max() < 1e-3
    assert np.ptp(face) > 0.01 and np.all(back > face)


def test_a_gripped_panel_bends_as_the_rig_has_it(berthing):
    """Without a grip there is none to place; with one its end is under the tool and its root where it was gripped."""
    log = read_log(berthing)
    parts, *_ = report_arm.parts_of(log)
    assert "object" not in parts and "object" not in json.loads(report_arm.scene(log))["parts"]
    log, _ = run(berthing.parent, "ess-berthing", ["run.duration_s=30", "run.grip_close_s=15"])
    log = read_log(log)
    parts, *_ = report_arm.parts_of(log)
    tip, root = parts["object"][:, -1, 0], parts["object"][:, 0, 0]
    held = log.tick_s > 15.1
    assert np.abs(tip - log.arm["tool_x_m"])[held].max() < 1e-3
    assert tip - root == pytest.approx(log.rig["object_position_m"], abs=2e-6)
    assert np.ptp(root) < 2e-6 and np.abs(log.rig["object_position_m"]).max() > 1e-4


@pytest.mark.long
def test_the_view_may_be_close_and_has_a_scale(berthing, tmp_path):
    made(berthing)
    with Browser(berthing.with_suffix(".html"), tmp_path) as browser:
        def width():
            return float(browser.evaluate("document.getElementById('arm-view').getAttribute('viewBox')").split()[2])

        def labels():
            return browser.evaluate("[...document.querySelectorAll('#arm-labels text')].map((text) => text.textContent)")

        whole_m, whole_labels = width(), labels()
        browser.evaluate("""(() => { const box = document.getElementById("arm-box");
          box.value = "tool"; box.dispatchEvent(new Event("change")); })()""")
        assert width() < whole_m / 4 and whole_m > 7
        assert "4 m" in whole_labels and "3.2 m" in labels()
        assert browser.console == []


def test_a_log_that_was_cut_is_drawn_as_far_as_it_goes(tmp_path):
    log, _ = run(tmp_path, "concept-arm-foam", ["run.duration_s=1"])
    found = read_log(log)
    found = dataclasses.replace(found, rig={name: values[:-1] for name, values in found.rig.items()})
    parts, *_ = report_arm.parts_of(found)
    assert {len(part) for part in parts.values()} == {len(found.arm["tool_x_m"]) - 1}
    assert json.loads(report_arm.scene(found))["frames"] == 20


@pytest.mark.long
def test_without_an_arm_there_is_no_picture(tmp_path):
    log, _ = run(tmp_path, "ess", ["run.duration_s=1"])
    assert report_arm.scene(read_log(log)) == "null"
    with Browser(log.with_suffix(".html") if made(log) else None, tmp_path / "profile") as browser:
        assert browser.evaluate("document.getElementById('arm').hidden")


@pytest.mark.slow
def test_what_orders_moved_is_not_called_stopped(tmp_path):
    log, _ = run(tmp_path, "ess-pose", ["run.duration_s=10"])
    page, _ = made(log)
    assert "driven" in page.text.lower() and "the eigenvalues say" in page.text
    assert "was stopped before" not in page.text
