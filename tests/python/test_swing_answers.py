"""Where what becomes of a swing depends on its size, play and a limited drive, `run`, `eigen`, `limits` and `check` give one
answer and one margin. The last swing of long runs without noise, read off their logs, tells whether it is right."""

import json
import sys

import pytest
from answers import answers
from conftest import ROOT, command, settings

sys.path.insert(0, str(ROOT / "scripts"))
from berth_log import read_log  # noqa: E402

HELD = """
[run]
duration_s = 20
release_s = 0.1
[loop]
rate_Hz = 500
[manipulator]
mass_kg = 150
stiffness_N_per_m = 6000
damping_N_s_per_m = 120
initial_position_m = 0.005
[robot]
dead_time_ms = 34
interpolation = "linear"
[sensor]
delay_ms = 2
low_pass_frequency_Hz = 150
noise_N = 0.2
[object]
mass_kg = 30
stiffness_N_per_m = 4000
damping_N_s_per_m = 60
"""
SLOW = {"robot.velocity_limit_m_per_s": 0.01}
PLAY = {"robot.backlash_m": 3e-4, "object.stiffness_N_per_m": 3000}
QUICK = ("run", "eigen", "check")  # `limits` goes through all parameters at each amplitude: 30 s


@pytest.fixture
def rig(tmp_path):
    path = tmp_path / "my.toml"
    path.write_text(HELD)
    return path


def last_height_mm(path, tmp_path, values, duration_s=120):
    """Of the manipulator's swing in the last 5 s of a run without noise, from crest to trough."""
    quiet = values | {"sensor.noise_N": 0, "run.duration_s": duration_s}
    command("run", path, "--out", tmp_path / "log", *settings(quiet), check=True)
    log = read_log(tmp_path / "log" / "my.ulg")
    x = log.tick["manipulator_position_m"][log.tick_s > duration_s - 5]
    return 1e3 * float(x.max() - x.min())


@pytest.mark.parametrize("values, verdict, lasts", [
    (SLOW, "limit cycle", True),
    (SLOW | {"manipulator.initial_position_m": 0.0025}, "limit cycle", True),
    (SLOW | {"manipulator.initial_position_m": 0.002}, "stable", False),
    (SLOW | {"manipulator.initial_position_m": 0.001}, "stable", False),
    (PLAY, "stable", False),
    (PLAY | {"robot.dead_time_ms": 70}, "stable", False),
    (PLAY | {"robot.dead_time_ms": 85}, "limit cycle", True),
    (PLAY | {"robot.dead_time_ms": 150}, "unstable", None),
])
def test_commands_agree_on_swings_of_a_size(rig, tmp_path, values, verdict, lasts):
    told = answers(rig, *settings(values), commands=QUICK)
    assert told["eigen"]["verdict"] == told["check"]["verdict"] == verdict
    if lasts is not None:
        assert (last_height_mm(rig, tmp_path, values) > 0.05) is lasts
    origins = {name: (answer["growth"] or {}).get("origin") for name, answer in told.items()}
    assert origins["eigen"] == origins["check"] and "measured" not in (origins["eigen"], origins["check"])
    if verdict == "stable":
        shown = command("eigen", rig, *settings(values)).stdout.decode()
        assert f"  stable         {told['eigen']['because']}" in shown, "the growth of the runs, beside that of the eigenvalues"
    if verdict == "limit cycle":
        assert told["run"]["growth_per_s"] is None or told["run"]["verdict"] != "limit cycle"
        assert told["eigen"]["growth_per_s"] is None or told["eigen"]["growth_per_s"] > 0
        shown = command("eigen", rig, *settings(values)).stdout.decode()
        assert "limit cycle, spectral radius" not in shown
    if verdict != "stable":
        assert all(answer["margin"]["dead_time_margin_ms"] is None for answer in told.values())


@pytest.mark.slow
@pytest.mark.parametrize("values", [SLOW, SLOW | {"manipulator.initial_position_m": 0.001}, PLAY])
def test_limits_agrees_with_the_others_on_swings_of_a_size(rig, values):
    told = answers(rig, *settings(values))
    margins_ms = {answer["margin"]["dead_time_margin_ms"] for answer in told.values()}
    assert len(margins_ms) == 1


def test_a_limited_drive_is_stable_up_to_a_swing(rig, tmp_path):
    """Harmonic balance is an approximation: 2.22 mm; runs put it between 2.1 and 2.4 mm."""
    because = answers(rig, *settings(SLOW), commands=QUICK)["eigen"]["because"]
    assert "stable for swings below 2.22 mm" in because and "limit cycle of 6.94 mm at 1.025 Hz" in because
    heights_mm = [last_height_mm(rig, tmp_path, SLOW | {"manipulator.initial_position_m": start})
                  for start in (0.0021, 0.0024, 0.005)]
    assert heights_mm[0] < 0.01
    assert heights_mm[1] == pytest.approx(2 * 6.94, rel=0.03) and heights_mm[2] == pytest.approx(2 * 6.94, rel=0.03)


@pytest.mark.long
def test_margin_with_play_ends_where_a_swing_lasts(rig, tmp_path):
    told = answers(rig, *settings(PLAY), commands=QUICK)
    margins_ms = {answer["margin"]["dead_time_margin_ms"] for answer in told.values()}
    assert len(margins_ms) == 1
    for share, lasts in ((0.9, False), (1.1, True)):
        values = PLAY | {"robot.dead_time_ms": 34 + share * min(margins_ms)}
        assert (last_height_mm(rig, tmp_path, values) > 0.05) is lasts


# --- effects of the manipulator, which the firmware knows nothing of ------------------------------------------------
@pytest.mark.parametrize("method", ["passivity", "tank", "prediction", "force-lead"])
def test_a_manipulators_effect_leaves_the_compensation_on(method):
    """Friction of 1 uN does nothing, and a loop that only the compensation makes stable stays so."""
    words = ["run", "ess", "--no-log", "--no-advice", "--json", "--with", method,
             *settings({"object.stiffness_N_per_m": 14000, "run.duration_s": 30})]
    plain, rubs = (json.loads(command(*words, *more).stdout)
                   for more in ([], settings({"manipulator.coulomb_friction_N": 1e-6})))
    assert rubs["verdict"] == plain["verdict"] == "stable"
    assert rubs["growth_per_s"] == pytest.approx(plain["growth_per_s"], abs=0.02)


def test_runs_behind_the_answer_have_the_manipulators_play():
    """The more play, the less the manipulator's damper takes."""
    growths_per_s = [json.loads(command("eigen", "ess", "--json", *settings(
        {"object.stiffness_N_per_m": 10000, "manipulator.backlash_m": play_m})).stdout)["growth"]["growth_per_s"]
        for play_m in (0, 1e-4, 5e-4, 1e-3)]
    assert growths_per_s == sorted(growths_per_s) and growths_per_s[-1] > 0.7 * growths_per_s[0]
