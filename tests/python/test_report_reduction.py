"""How far an arm's reduction misleads, in a report: the numbers are those of the whole arm in the run's loop, the words and
the picture those of the numbers."""

import sys

import numpy as np
import pytest
from browser import Browser
from conftest import BERTH, RIG_FOLDER, ROOT, command, one_json_object
from test_report import made, run

sys.path.insert(0, str(ROOT / "scripts"))
import report_reduction  # noqa: E402
from berth_log import read_log  # noqa: E402


@pytest.fixture(scope="module")
def berthing(tmp_path_factory):
    return run(tmp_path_factory.mktemp("berthing"), "ess-berthing", ["run.duration_s=2"])[0]


@pytest.fixture(scope="module")
def sweeps(berthing):
    return report_reduction.sweeps_of(read_log(berthing), BERTH)


def turned(tmp_path, joint, angle_rad):
    """The shipped arm with another angle at its start."""
    parts = (RIG_FOLDER.parent / "arms" / "ess.toml").read_text().split("[[joint]]")
    old = next(line for line in parts[joint].splitlines() if line.startswith("initial_rad"))
    parts[joint] = parts[joint].replace(old, f"initial_rad = {float(angle_rad)!r}")
    arm = tmp_path / "turned.toml"
    arm.write_text("[[joint]]".join(parts))
    return arm


def eigen(arm, dead_time_ms):
    done = command("eigen", "ess", "--json", "--set", f"manipulator.arm={arm}", "--set",
                   f"robot.dead_time_ms={float(dead_time_ms)!r}")
    return one_json_object(done.stdout)["growth_per_s"]


@pytest.mark.long
@pytest.mark.parametrize("joint,place", [(1, 3), (1, 12), (2, 5), (2, 24)])
def test_the_full_arm_is_the_one_of_eigen(sweeps, tmp_path, joint, place):
    sweep = sweeps[joint - 1]
    arm = turned(tmp_path, joint, sweep.angle_rad[place])
    assert sweep.growth_full[place] == pytest.approx(eigen(arm, 17.5), rel=1e-6)
    critical_ms = sweep.dead_time_full_ms[place]
    assert 2.5 < critical_ms < 175
    assert eigen(arm, 0.9999 * critical_ms) < 0 < eigen(arm, 1.0001 * critical_ms)


def test_the_reduced_one_is_a_rig_without_an_arm(sweeps):
    sweep = sweeps[1]
    place = 20
    pose = f"1.35,{float(sweep.angle_rad[place])!r}"
    mode = one_json_object(command("reduce", "ess", "--json", "--arm", "ess", "--pose", pose).stdout)
    mode = mode["poses"][0]["reduced"]
    rig = [word for key in ("mass_kg", "damping_N_s_per_m", "stiffness_N_per_m")
           for word in ("--set", f"manipulator.{key}={mode[key]!r}")]
    found = one_json_object(command("eigen", "ess", "--json", *rig).stdout)
    assert sweep.growth_reduced[place] == pytest.approx(found["growth_per_s"], rel=1e-6)


@pytest.mark.long
def test_the_words_are_those_of_the_numbers(berthing, sweeps):
    page, _ = made(berthing)
    growth = np.array([(r, f) for sweep in sweeps for r, f in zip(sweep.growth_reduced, sweep.growth_full)])
    stable, unstable = (int(np.sum(((growth[:, 0] > 0) == flag) & ((growth[:, 1] > 0) != flag))) for flag in (False, True))
    told = " ".join((ROOT / "scripts/docs/explanation/whole-arm.md").read_text().split())
    assert f"whole arm is not; for `ess-berthing` at {stable} of {len(growth)}." in told
    assert f"Both models were compared at {len(growth)} poses." in page.text
    if stable + unstable == 0:
        assert "At every pose they agree whether the loop is stable." in page.text
    else:
        assert f"Stable by the reduced model, unstable by the whole arm: {report_reduction.poses(stable)}." in page.text
        assert f"Unstable by the reduced model, stable by the whole arm: {report_reduction.poses(unstable)}." in page.text
    off = [100 * abs(min(r, 175.0) / f - 1) for sweep in sweeps
           for r, f in zip(sweep.dead_time_reduced_ms, sweep.dead_time_full_ms) if f > 0]
    assert f" {1 + max(off) / 100:.0f} times too long: " in page.text


@pytest.mark.long
def test_the_plots_are_on_the_page_on_every_screen(berthing, tmp_path):
    made(berthing)
    checks = (ROOT / "tests/python/page_checks.js").read_text()
    with Browser(berthing.with_suffix(".html"), tmp_path) as browser:
        for width_px, scheme in ((390, "dark"), (1400, "light")):
            browser.look(width_px, scheme)
            browser.evaluate("allDrawn.then(() => true)")
            assert browser.evaluate("document.querySelectorAll('#reduction .js-plotly-plot').length") == 4
            assert browser.evaluate("document.querySelectorAll('img').length") == 0
            assert browser.evaluate(checks) == []
        assert browser.console == []


def test_growth_of_either_sign_is_drawn_in_order_with_its_own_numbers(berthing, sweeps):
    plots = {plot["id"]: plot for plot in report_reduction.plots(read_log(berthing), sweeps)}
    assert set(plots) == {"growth-1", "critical-1", "growth-2", "critical-2"}
    for sweep in sweeps:
        reduced, full, *_ = plots[f"growth-{sweep.joint}"]["data"]
        assert full["customdata"] == pytest.approx(sweep.growth_full, abs=1e-6)
        drawn, rates = (np.array(reduced[key] + full[key]) for key in ("y", "customdata"))
        assert (np.sign(drawn) == np.sign(rates)).all()
        order = np.argsort(rates, kind="stable")
        assert (np.diff(drawn[order]) > -1e-4).all()  # rounded on the page
    scale = report_reduction.SignedDecades(2.0)
    ticks = scale.ticks()
    assert ticks["tickvals"] == pytest.approx([float(scale.place(float(text.replace("−", "-")))) for text in ticks["ticktext"]], abs=1e-4)


def test_poses_with_nothing_springy_are_left_out(tmp_path):
    done = command("reduce", "ess", "--json", "--held", "--pose", "0,0", "--direction", "1,0", "--sweep",
                   "2=-0.5:0.5:3")
    poses = one_json_object(done.stdout)["poses"]
    assert [pose["reduced"] is None for pose in poses] == [False, True, False]
    found = report_reduction.sweep_from({"poses": poses}, 1, {}, (0.0, 0.0))
    assert found.compared.tolist() == [True, False, True]
    assert " compared at 2 poses." in report_reduction.statement([found])
    shown = command("reduce", "ess", "--held", "--pose", "0,0", "--direction", "1,0", "--sweep",
                    "2=-0.5:0.5:3").stdout.decode()
    assert "0.000  no spring of the arm moves the tool along the direction" in shown


@pytest.mark.long
def test_a_rig_that_has_no_eigenvalues_says_why(tmp_path):
    log, _ = run(tmp_path, "ess", ["manipulator.arm=ess", "extrapolation.order=1", "run.duration_s=1"])
    page, _ = made(log)
    assert "berth reduce cannot compare the models of this rig:" in page.text and "rig.toml" not in page.text


def test_without_an_arm_there_is_none(tmp_path):
    log, _ = run(tmp_path, "ess", ["run.duration_s=1"])
    assert "How far the reduced model misleads" not in made(log)[0].text


def test_dead_times_that_neither_model_ends_at_are_no_error():
    pose = {"pose_rad": [0.0], "reduced": {}, "loop": {"reduced": {"growth_per_s": -1.0}, "full": {"growth_per_s": -2.0}},
            "dead_time_limit_ms": {"reduced": None, "full": None, "looked_from": 2.5, "looked_to": 175.0}}
    ended = pose | {"dead_time_limit_ms": {"reduced": 50.0, "full": 40.0, "looked_from": 2.5, "looked_to": 175.0}}
    both = report_reduction.sweep_from({"poses": [pose, pose]}, 0, {}, (0.0, 0.0))
    assert report_reduction.statement([both]).endswith("Both stay stable with 175 ms of dead time at every pose.")
    one = report_reduction.sweep_from({"poses": [pose, ended]}, 0, {}, (0.0, 0.0))
    assert "an error of up to 25 %: 50 ms instead of 40 ms, with joint 1 at 0.00 rad." in report_reduction.statement([one])
    far = ended | {"dead_time_limit_ms": {"reduced": None, "full": 5.0, "looked_from": 2.5, "looked_to": 175.0}}
    worst = report_reduction.sweep_from({"poses": [ended, far]}, 0, {}, (0.0, 0.0))
    assert "at least 35 times too long: more than 175 ms instead of 5 ms" in report_reduction.statement([worst])
