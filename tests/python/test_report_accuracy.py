"""The accuracy statement in a report: there when `berth accuracy` has been asked about the run's own arm and step."""

import json
import re

import pytest
from conftest import EXIT_INPUT, command, one_json_object
from test_report import made, report, run


@pytest.fixture(scope="module")
def found():
    done = command("accuracy", "ess-berthing", "--json")
    assert done.returncode == 0, done.stderr.decode()
    return one_json_object(done.stdout)


@pytest.fixture
def log(tmp_path):
    return run(tmp_path, "ess-berthing", ["run.duration_s=2"])[0]


def beside(log, found):
    path = log.with_suffix(".accuracy.json")
    path.write_text(json.dumps(found))
    return path


@pytest.mark.slow
def test_the_statement_stands_in_the_report(log, found):
    assert "Accuracy of the fixed step" not in made(log)[0].text
    beside(log, found)
    page, _ = made(log)
    worst_um = 1e6 * next(row["tool_m"] for row in found["rows"]
                          if (row["integrator"], row["force"], row["step_ms"]) == (found["integrator"], "mean", 2.5))
    share = 1e-4 * worst_um / found["repeatability_m"]
    held_um, led_um = 1e6 * found["held_tool_m"], 1e6 * found["led_tool_m"]
    assert (f"At 2.5 ms the worst end-effector error of the integrator alone is {worst_um:.3g} µm, {share:.2g} % of the "
            f"robot's repeatability of {1e6 * found['repeatability_m']:g} µm; with the force held over the step it "
            f"is {held_um:.3g} µm, {1e-4 * held_um / found['repeatability_m']:.0f} %; led by half a step, as the "
            f"loop does, {led_um:.3g} µm, {1e-4 * led_um / found['repeatability_m']:.2g} %.") in page.text
    html = log.with_suffix(".html").read_text()
    assert '<section id="accuracy">' in html and "<img" not in html
    plots = {one["id"]: one for one in json.loads(re.search(r'id="plots"[^>]*>(.*?)</script>', html, re.S)[1])}
    assert len([name for name in plots if name.endswith(("-mean", "-held", "-led"))]) == 8
    rk4 = next(trace for trace in plots["tool_m-mean"]["data"] if trace["name"] == "RK4")
    assert dict(zip(rk4["x"], rk4["y"]))[2.5] == pytest.approx(1e6 * next(
        row["tool_m"] for row in found["rows"] if (row["integrator"], row["force"], row["step_ms"]) == ("rk4", "mean", 2.5)))


@pytest.mark.long
@pytest.mark.parametrize("change,says", [
    ({"arm_hash": "0123456789abcdef"}, "is about another arm"),
    ({"step_ms": 5.0}, "is about steps of 5 ms, and"),
    ({"arm_hash": None, "step_ms": None}, "is about another arm"),
])
def test_what_is_about_something_else_is_refused(log, found, change, says):
    path = beside(log, found | change)
    done = report(log)
    assert done.returncode == EXIT_INPUT
    assert str(path) in done.stderr and says in done.stderr
    assert not log.with_suffix(".html").exists()


@pytest.mark.long
def test_what_is_no_accuracy_is_refused(log, tmp_path):
    for text in ("{", "[]", "{}"):
        log.with_suffix(".accuracy.json").write_text(text)
        done = report(log)
        assert done.returncode == EXIT_INPUT
        assert "is not what `berth accuracy RIG --json` prints" in done.stderr


def test_a_run_without_an_arm_has_none(tmp_path, found):
    log, _ = run(tmp_path, "ess", ["run.duration_s=1"])
    beside(log, found)
    done = report(log)
    assert done.returncode == EXIT_INPUT
    assert "is about an arm, and" in done.stderr
