"""Motors of an arm at their torque limits are told of a run: by `berth run`, by `berth summary`, and in the report."""

from pathlib import Path

import numpy as np
import pytest
from conftest import (RIG_FOLDER, STATE_RUNNING, command, one_json_object, replay_json, run_json, settings, topic,
                      ulog_messages, without_checksums)
from test_report import made

PERIOD_s = 2.5e-3
SMALL = "says nothing of small motions"


def arm_file(folder, torque_limit_N_m, **changes):
    """The shipped arm with weaker motors."""
    text = (RIG_FOLDER.parent / "arms" / "ess.toml").read_text()
    for limit in ("2000.0", "1500.0"):
        assert text.count(f"torque_limit_N_m = {limit}") == 1
        text = text.replace(f"torque_limit_N_m = {limit}", f"torque_limit_N_m = {torque_limit_N_m}")
    for before, after in changes.items():
        assert text.count(f"{before} = ") == 1
        text = "\n".join(f"{before} = {after}" if line.startswith(f"{before} = ") else line for line in text.split("\n"))
    file = folder / "weak.toml"
    file.write_text(text)
    return file


def line_of(shown, name):
    [line] = [line for line in shown.splitlines() if line.startswith(f"  {name} ")]
    return line


@pytest.fixture(scope="module")
def told(tmp_path_factory):
    folder = tmp_path_factory.mktemp("weak")
    words = ("--set", f"manipulator.arm={arm_file(folder, 5)}")
    return run_json("ess-berthing", folder, *words), command("run", "ess-berthing", "--no-log", *words).stdout.decode()


def test_the_log_has_a_bit_for_every_joint_and_the_ticks_are_counted(told):
    found, shown = told
    at_limit = topic(found["log"], "arm")["motors_at_limit"][topic(found["log"])["state"] == STATE_RUNNING]
    first_s = PERIOD_s * (np.flatnonzero(topic(found["log"], "arm")["motors_at_limit"])[0])
    joints = [int(np.sum((at_limit >> joint) & 1)) for joint in range(2)]
    print(f"ticks at the limit: {np.sum(at_limit != 0)}, of the joints {joints}, first at {first_s} s")
    assert min(joints) > 100 and not np.any(at_limit >> 2)
    assert found["motors"] == {"limit_ticks": int(np.sum(at_limit != 0)), "first_s": pytest.approx(first_s, abs=1e-9),
                               "joint_limit_ticks": joints}
    assert line_of(shown, "motors") == (
        f"  {'motors':14} at their torque limit in {np.sum(at_limit != 0)} ticks, first at {first_s:.2f} s "
        f"(joint 1 in {joints[0]}, joint 2 in {joints[1]})")


def test_a_growth_beside_motors_at_their_limits_says_so(told):
    found, shown = told
    assert found["growth_per_s"] > 0.03 > found["prediction"]["growth_per_s"]
    assert SMALL in line_of(shown, "unstable")
    assert "motors were at their torque limit in " in line_of(shown, "unstable")


def test_a_longer_run_is_not_promised_to_tell(tmp_path):
    """A loop that grows until its motors bound it: however long it runs."""
    arm = arm_file(tmp_path, 200)
    longer = {"manipulator.arm": arm, "robot.dead_time_ms": 40, "run.duration_s": 200}
    shown = command("run", "ess", "--no-log", *settings(longer)).stdout.decode()
    print(shown)
    assert "a longer run" not in shown and SMALL in shown


@pytest.mark.long
def test_a_log_tells_the_same_and_replays(told):
    found, _ = told
    assert one_json_object(command("summary", found["log"], "--json").stdout)["motors"] == found["motors"]
    shown = command("summary", found["log"]).stdout.decode()
    assert line_of(shown, "motors") == line_of(told[1], "motors") and SMALL in line_of(shown, "unstable")
    assert replay_json(found["log"])["equal"]
    page, _ = made(Path(found["log"]))
    assert f"motors at torque limit {found['motors']['limit_ticks']}, from " in page.text and SMALL in page.text


@pytest.mark.parametrize("integrator", ["semi_implicit_euler", "rk4", "implicit_midpoint"])
def test_every_integrator_tells(tmp_path, integrator):
    arm = arm_file(tmp_path, 5, integrator=f'"{integrator}"\nsubsteps = 10')
    found = run_json("ess", tmp_path, "--set", f"manipulator.arm={arm}", "--set", "run.duration_s=5")
    print(f"{integrator}: {found['motors']}")
    assert found["motors"]["limit_ticks"] > 100 and replay_json(found["log"])["equal"]


def test_of_motors_that_are_strong_enough_nothing_is_told(tmp_path):
    found = run_json("ess-berthing", tmp_path)
    assert found["motors"] == {"limit_ticks": 0, "first_s": None, "joint_limit_ticks": [0, 0]}
    shown = command("summary", found["log"]).stdout.decode()
    assert line_of(shown, "motors") == f"  {'motors':14} never at their torque limit" and SMALL not in shown
    assert run_json("ess", tmp_path, "--set", "run.duration_s=1")["motors"] is None
    assert "  motors " not in command("run", "ess", "--no-log", "--set", "run.duration_s=1").stdout.decode()


@pytest.mark.long
def test_a_log_from_before_they_were_told_is_read_and_says_that_it_does_not_know(tmp_path):
    data = without_checksums(Path(run_json("ess-berthing", tmp_path, "--set", "run.duration_s=20")["log"]).read_bytes())
    [message] = [m for m in ulog_messages(data) if m.type == "F" and m.content.startswith(b"arm:")]
    content = message.content.replace(b"uint16_t guided_by;uint16_t motors_at_limit;", b"uint32_t guided_by;")
    assert content != message.content
    before = tmp_path / "before.ulg"
    before.write_bytes(data[:message.at] + len(content).to_bytes(2, "little") + b"F" + content + data[message.end:])
    done = command("summary", before)
    assert "the log does not tell" in line_of(done.stdout.decode(), "motors"), done.stderr
    assert one_json_object(command("summary", before, "--json").stdout)["motors"] is None
    assert replay_json(before)["equal"]
    page, _ = made(before)
    assert "motors at torque limit" not in page.text
