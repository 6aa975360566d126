"""A reaction wheel holds no more than it can, however seldom its law is evaluated, and a run tells when it is full."""

from pathlib import Path

import numpy as np
import pytest
from conftest import RIG_FOLDER, STATE_RUNNING, command, one_json_object, run_json, topic
from test_report import made

LIMIT_N_m_s = 5.0
ORDERS = """
[[orders]]
at_s = 1.0
line_m = [0.6, 0.3]
speed_m_per_s = 0.06
[[orders]]
at_s = 20.0
joint = 2
move_to_rad = -1.3
"""


def swinging_rig(folder, period_ticks, limit_N_m_s):
    """ess-berthing's arm with a small wheel, moved about before anything is gripped."""
    arm = (RIG_FOLDER.parent / "arms" / "ess.toml").read_text()
    for before, after in (("momentum_limit_N_m_s = 500.0", f"momentum_limit_N_m_s = {limit_N_m_s}"),
                          ("period_ticks = 1", f"period_ticks = {period_ticks}")):
        assert arm.count(before) == 1
        arm = arm.replace(before, after)
    (folder / "small-wheel.toml").write_text(arm)
    rig = (RIG_FOLDER / "ess-berthing.toml").read_text()
    rig = rig[:rig.index("[[orders]]")].replace('arm = "ess"', f'arm = "{folder}/small-wheel.toml"') + ORDERS
    file = folder / "swinging.toml"
    file.write_text(rig)
    return file


def told_of(folder, period_ticks, limit_N_m_s):
    rig = swinging_rig(folder, period_ticks, limit_N_m_s)
    words = ("--set", "run.duration_s=40", "--set", "run.grip_close_s=39")
    return run_json(rig, folder, *words), command("run", rig, "--no-log", *words).stdout.decode()


def line_of_wheel(shown):
    [line] = [line for line in shown.splitlines() if line.startswith("  wheel ")]
    return line


@pytest.mark.long
@pytest.mark.parametrize("period_ticks", [1, 40, 400])
def test_the_wheel_never_holds_more_than_its_limit_and_is_told_to_be_full(tmp_path, period_ticks):
    found, shown = told_of(tmp_path, period_ticks, LIMIT_N_m_s)
    running = topic(found["log"])["state"] == STATE_RUNNING
    held_N_m_s = topic(found["log"], "arm")["wheel_z_N_m_s"]
    full = running & (np.abs(held_N_m_s) > LIMIT_N_m_s * (1.0 - 1e-9))
    first_s = 2.5e-3 * np.flatnonzero(full)[0]
    print(f"period {period_ticks} ticks: the wheel holds {np.abs(held_N_m_s).max()} N m s at most, full in {full.sum()} "
          f"ticks from {first_s:.2f} s on")
    assert np.abs(held_N_m_s).max() <= LIMIT_N_m_s * (1.0 + 1e-9) and full.sum() > 1000
    assert found["wheel"] == {"full_ticks": full.sum(), "first_s": pytest.approx(first_s, abs=1e-9),
                              "axis_full_ticks": [0, 0, full.sum()]}
    assert line_of_wheel(shown) == (f"  {'wheel':14} full (5 N m s) in {full.sum()} ticks, first at {first_s:.2f} s (z in "
                                    f"{full.sum()}): it held the satellite's attitude no longer")
    assert one_json_object(command("summary", found["log"], "--json").stdout)["wheel"] == found["wheel"]
    if period_ticks == 1:
        page, _ = made(Path(found["log"]))
        assert f"wheel full {full.sum()}, from {first_s:.2f} s on" in page.text


def test_a_wheel_with_room_is_told_as_such_and_a_rig_without_one_says_nothing(tmp_path):
    found, shown = told_of(tmp_path, 1, 500.0)
    assert found["wheel"] == {"full_ticks": 0, "first_s": None, "axis_full_ticks": [0, 0, 0]}
    assert line_of_wheel(shown) == f"  {'wheel':14} never full"
    assert run_json("ess", tmp_path, "--set", "run.duration_s=1")["wheel"] is None
