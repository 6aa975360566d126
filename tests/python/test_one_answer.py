"""A loop that changes while it runs gets one answer: `run`, `eigen`, `limits` and `check` predict the same growth and give
the same verdict, --check agrees with it, and what is advised is a cure. The figures are those of long runs without noise."""

import re
import sys

import numpy as np
import pytest
from answers import answers, ask
from conftest import EXIT_DIFFERENT, EXIT_DONE, EXIT_INPUT, ROOT, command, one_json_object, run_json, settings, topic

sys.path.insert(0, str(ROOT / "scripts"))
from berth_log import read_log  # noqa: E402
from report_words import verdict  # noqa: E402

BASE = """
[run]
duration_s = 30
[loop]
rate_Hz = 250
[manipulator]
mass_kg = 150
stiffness_N_per_m = 6000
damping_N_s_per_m = 120
initial_position_m = 0.005
[robot]
dead_time_ms = 24
[sensor]
delay_ms = 4
low_pass_frequency_Hz = 40
[object]
mass_kg = 10
stiffness_N_per_m = 1500
damping_N_s_per_m = 60
"""
SIX_AXES = """
[run]
duration_s = 5
[loop]
rate_Hz = 400
[manipulator]
mass_kg = 200
stiffness_N_per_m = 7900
damping_N_s_per_m = 125
arm = "ess"
direction_x = 1.0
[robot]
dead_time_ms = 20
[sensor]
low_pass_frequency_Hz = 150
[object]
mass_kg = 40
stiffness_N_per_m = 500
damping_N_s_per_m = 60
[sensor_channel]
layout = "three_frames_motorola"
force_limit_N = 20000
[axis.y]
mass_kg = 40
stiffness_N_per_m = 500
damping_N_s_per_m = 50
"""
LONGER = {"run.dead_time_jump_s": 5, "run.dead_time_jump_ms": 70}
STIFF = {"object.stiffness_N_per_m": 4000}
STIFFER = {"object.stiffness_N_per_m": 9000}
UNDAMPED = {"manipulator.damping_N_s_per_m": 0, "object.damping_N_s_per_m": 0}
FREE_CLOCK = {"robot.clock": "free", "robot.clock_drift_ppm": 100}

RIGS = {
    "steady": (BASE, {}, "stable"),
    "steady, stiff": (BASE, STIFFER, "unstable"),
    "a longer dead time": (BASE, STIFF | LONGER, "unstable"),
    "a longer dead time, still stable": (BASE, {"object.stiffness_N_per_m": 1000} | LONGER, "stable"),
    "a longer dead time after the end": (BASE, STIFF | LONGER | {"run.dead_time_jump_s": 31}, "stable"),
    "a longer dead time after the grip": (BASE, STIFF | LONGER | {"run.grip_release_s": 4}, "stable"),
    "a shorter dead time": (BASE, STIFF | {"robot.dead_time_ms": 94, "run.dead_time_jump_s": 5, "run.dead_time_jump_ms": -70},
                            "unstable"),
    "a dead time that grows": (BASE, {"robot.dead_time_drift_ms_per_s": 6}, "unstable"),
    "a spring that stiffens": (BASE, {"object.stiffness_drift_per_s": 0.3}, "unstable"),
    "losses": (BASE, {"bus.loss_probability": 0.1}, "stable"),
    "losses, stiff": (BASE, STIFFER | {"sensor.loss_probability": 0.3}, "unstable"),
    "a free clock": (BASE, FREE_CLOCK, "stable"),
    "a free clock makes it unstable": (BASE, FREE_CLOCK | {"object.stiffness_N_per_m": 5700}, "unstable"),
    "losses and a longer dead time": (BASE, STIFF | LONGER | {"bus.loss_probability": 0.05}, "unstable"),
    "no damping": (BASE, UNDAMPED, "unstable"),
    "extrapolation": (BASE, STIFFER | {"robot.dead_time_ms": 120, "extrapolation.order": 1}, "unstable"),
    "extrapolation and jitter": (BASE, STIFFER | {"robot.dead_time_ms": 120, "extrapolation.order": 1, "robot.jitter_ms": 1},
                                 "unstable"),
    "six axes": (SIX_AXES, {}, "unstable"),
    "six axes and a longer dead time": (SIX_AXES, {"robot.dead_time_ms": 8, "run.dead_time_jump_s": 2,
                                                   "run.dead_time_jump_ms": 12}, "unstable"),
}
NO_ADVICE = "no single parameter and no compensation that was tried makes it stable"


def answers_of(file, changes):
    """What each command tells, or None of one that refuses the rig, and whether it found the loop safe."""
    told, safe = {}, {}
    for subcommand, *more in (["run", "--no-log", "--check"], ["eigen", "--check"], ["limits", "--check"], ["check"]):
        done = command(subcommand, file, *more, "--json", *settings(changes))
        if done.returncode == EXIT_INPUT and subcommand == "limits":
            assert b"one degree of freedom" in done.stderr
            continue
        assert done.returncode in (EXIT_DONE, EXIT_DIFFERENT), done.stderr.decode()
        told[subcommand], safe[subcommand] = one_json_object(done.stdout), done.returncode == EXIT_DONE
    return told, safe


def same(a, b):
    """Predictions that agree to rounding."""
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(same(a[key], b[key]) for key in a)
    if isinstance(a, list):
        return len(a) == len(b) and all(map(same, a, b))
    return a == pytest.approx(b, rel=1e-6, abs=1e-7) if isinstance(a, float) else a == b


def check_advice(file, changes, told):
    """Each change that is advised makes the loop stable."""
    if told["advice"] == NO_ADVICE:
        return
    for advice in told["advice"].split(", or "):
        change = re.fullmatch(r"(\S+) (above|below) (\S+)", advice)
        options = ("--set", f"{change[1]}={change[3]}") if change else advice.split(":")[0].split()
        cured = one_json_object(command("eigen", file, "--json", *settings(changes), *options).stdout)
        growth_per_s = cured["prediction"]["growth_per_s"]
        assert cured["verdict"] == "stable" and growth_per_s < -max(cured["prediction"]["growth_ci95_per_s"], 1e-6), advice
        for share in (0.98, 0.95) if change else ():  # no sliver
            further = float(change[3]) * (share if change[2] == "below" else 2 - share)
            further = command("eigen", file, "--json", *settings(changes), "--set", f"{change[1]}={further:.9g}")
            assert further.returncode == EXIT_INPUT or one_json_object(further.stdout)["stable"] is True, advice


@pytest.mark.long
@pytest.mark.parametrize("name", RIGS)
def test_all_commands_give_one_answer_and_its_advice_is_a_cure(name, write_rig):
    text, changes, verdict = RIGS[name]
    file = write_rig(text)
    told, safe = answers_of(file, changes)
    model = {subcommand: one for subcommand, one in told.items() if subcommand != "run"}
    assert {one["verdict"] for one in model.values()} == {verdict}, {key: one["because"] for key, one in told.items()}
    for subcommand, one in told.items():
        assert same(one["prediction"], told["check"]["prediction"]), subcommand
        assert one["prediction"]["stable"] is one["stable"] is (verdict == "stable"), (subcommand, one["because"])
        assert one["advice"] == told["check"]["advice"], subcommand
    if "growth_per_s" in told["eigen"]:
        assert told["eigen"]["growth_per_s"] == pytest.approx(told["check"]["prediction"]["growth_per_s"], rel=1e-6)
    safe.pop("check" if "damping" in name else "", None)  # which finds it implausible, too
    assert set(safe.values()) == {verdict == "stable"}
    assert bool(told["check"]["advice"]) == (verdict == "unstable")
    if verdict == "unstable":
        check_advice(file, changes, told["check"])


def height_growth_per_s(log, from_s, to_s):
    """Of a line through the logarithms of the manipulator's turning points."""
    tick = topic(log)
    t_s, position_m = 1e-6 * (tick["timestamp"] - tick["timestamp"][0]), np.abs(tick["manipulator_position_m"])
    assert t_s[-1] >= to_s - 0.1, "the run was stopped"
    turns = np.flatnonzero((position_m[1:-1] > position_m[:-2]) & (position_m[1:-1] >= position_m[2:])) + 1
    turns = turns[(t_s[turns] > from_s) & (t_s[turns] < to_s)]
    return np.polyfit(t_s[turns], np.log(position_m[turns]), 1)[0]


SMALL = {"manipulator.initial_position_m": 0.001}  # so that nothing stops the run


@pytest.mark.parametrize("changes, from_s, to_s, at", [
    (STIFF | LONGER, 0.5, 5.0, 0), (STIFF | LONGER, 6.0, 13.0, 1),
    ({"object.stiffness_N_per_m": 1000} | LONGER, 6.0, 25.0, 1),
], ids=["before it", "after it", "after it, stable"])
def test_a_run_grows_on_both_sides_of_a_jump_as_predicted(changes, from_s, to_s, at, write_rig, tmp_path):
    file = write_rig(BASE)
    schedule = one_json_object(command("check", file, "--json", *settings(changes)).stdout)["prediction"]["schedule"]
    assert [loop["from_s"] for loop in schedule] == [0.1, 5]
    assert [loop["dead_time_ms"] for loop in schedule] == [24, 94]
    seen_per_s = height_growth_per_s(run_json(file, tmp_path, *settings(changes | SMALL))["log"], from_s, to_s)
    print(f"seen {seen_per_s:.4f}, predicted {schedule[at]['growth_per_s']:.4f} /s")
    assert seen_per_s == pytest.approx(schedule[at]["growth_per_s"], abs=0.02)


@pytest.mark.parametrize("drift", [{"robot.dead_time_drift_ms_per_s": 6, "run.duration_s": 60}, {"object.stiffness_drift_per_s": 0.3}],
                         ids=["dead time", "stiffness"])
def test_a_drift_makes_a_run_grow_from_the_time_on_that_is_told(drift, write_rig, tmp_path):
    """The swing is lowest where its growth passes 0."""
    file = write_rig(BASE)
    told = one_json_object(command("check", file, "--json", *settings(drift)).stdout)
    turn_s = float(re.search(r"stable before (\S+) s \(.*\), unstable from then on", told["because"])[1])
    tick = topic(run_json(file, tmp_path, *settings(drift))["log"])
    t_s, position_m = 1e-6 * (tick["timestamp"] - tick["timestamp"][0]), np.abs(tick["manipulator_position_m"])
    middles_s = np.arange(2.0, t_s[-1] - 2.0, 0.25)
    heights_m = [position_m[np.abs(t_s - middle) < 0.6].max() for middle in middles_s]
    lowest_s = middles_s[int(np.argmin(heights_m))]
    print(f"lowest at {lowest_s:.2f} s, told {turn_s:.2f} s")
    assert lowest_s == pytest.approx(turn_s, abs=2.5)


@pytest.mark.long
@pytest.mark.parametrize("changes", [{"sensor.loss_probability": 0.3}, {"bus.loss_probability": 0.1},
                                     STIFFER | {"sensor.loss_probability": 0.3}, FREE_CLOCK], ids=str)
def test_the_exponent_is_the_growth_of_runs_with_other_seeds(changes, write_rig, tmp_path):
    file = write_rig(BASE)
    told = one_json_object(command("check", file, "--json", *settings(changes)).stdout)["prediction"]
    assert told["source"] == "lyapunov_exponent" and told["growth_ci95_per_s"] > 0
    end_s = 12.0 if told["growth_per_s"] > 0 else 18.0
    seen_per_s = [height_growth_per_s(run_json(file, tmp_path / str(seed), *settings(changes | SMALL | {"run.seed": seed}))["log"], 1.0, end_s)
                  for seed in range(11, 17)]
    mean, error = np.mean(seen_per_s), np.std(seen_per_s, ddof=1) / np.sqrt(len(seen_per_s))
    print(f"seen {mean:.4f} +- {error:.4f}, predicted {told['growth_per_s']:.4f} +- {told['growth_ci95_per_s']:.4f} /s")
    assert abs(mean - told["growth_per_s"]) < 3.5 * error + told["growth_ci95_per_s"] + 0.01


def test_a_growth_that_is_no_more_than_rounding_is_no_verdict_and_no_cure(write_rig):
    """Nothing damps it, and the force of an object of 1 mg is too small to drive it."""
    file = write_rig(BASE)
    undamped = UNDAMPED | {"object.stiffness_N_per_m": 0, "object.mass_kg": 1e-6}
    told, safe = answers_of(file, undamped)
    for subcommand, one in told.items():
        if subcommand != "run":
            assert one["verdict"] == "undetermined" and "ticks" not in one["advice"], (subcommand, one["because"])
            assert "no more than rounding" in one["because"] and not safe[subcommand]


def test_an_exponent_whose_interval_holds_0_does_not_pass_check(write_rig):
    file = write_rig(BASE)
    changes = {"object.stiffness_N_per_m": 5620, "bus.loss_probability": 0.3}
    done = command("eigen", file, "--check", "--json", "--ticks", "3000", *settings(changes))
    told = one_json_object(done.stdout)
    assert told["verdict"] == "undetermined" and "its interval holds 0" in told["because"] and "--ticks" in told["advice"]
    assert done.returncode == EXIT_DIFFERENT


def test_a_loop_that_never_runs_has_one_answer_and_no_margin(write_rig):
    told, safe = answers_of(write_rig(BASE), {"sensor.loss_probability": 1.0})
    for subcommand, one in told.items():
        assert one["verdict"] == "undetermined" and not safe[subcommand], (subcommand, one["because"])
        assert one["margin"]["dead_time_margin_ms"] is None and one["margin"]["modulus"] is None, subcommand


DRIVEN = {"manipulator.initial_position_m": 0, "profile.kind": "multisine", "profile.amplitude_m": 0.01, "profile.frequency_end_Hz": 2}


@pytest.mark.parametrize("changes, verdict, cause", [
    ({"run.emergency_stop_s": 0.5}, "stable", "emergency_stop"),
    ({"run.enable_off_s": 0.5}, "stable", "enable_off"),
    ({"run.grip_release_s": 0.5}, "stable", None),
    ({"bus.loss_probability": 0.6}, "stable", "sensor_stale"),
    ({"manipulator.initial_velocity_m_per_s": 1, "limits.position_max_m": 0.01}, "stable", "position_limit"),
    (DRIVEN | {"sensor_channel.force_limit_N": 5}, "driven", "force_limit"),
    (DRIVEN | {"run.emergency_stop_s": 5}, "driven", "emergency_stop"),
    (STIFFER | {"run.emergency_stop_s": 0.5}, "unstable", "emergency_stop"),
], ids=str)
def test_what_stops_a_run_does_not_hide_what_the_loop_does(changes, verdict, cause, write_rig):
    told = answers(write_rig(BASE), *settings(changes), commands=("run", "eigen"))
    run = told["run"]
    assert run["verdict"] == verdict and run["stable"] is (verdict != "unstable"), run["because"]
    assert (run["stopped"] or {}).get("cause") == cause
    if verdict == "stable" and cause:
        assert "stable by prediction" in run["because"] and "; stopped by " in run["because"]


# Stable up to a dead time of 22.56 ms, and again from 24.87 to 26.25 ms.
ISLAND = """
[loop]
rate_Hz = 200
[manipulator]
mass_kg = 300.088
stiffness_N_per_m = 7020.5
damping_N_s_per_m = 57.9361
initial_position_m = -0.0015
[robot]
dead_time_ms = 12.8501
interpolation = "linear"
[sensor]
delay_ms = 5
low_pass_frequency_Hz = 117.196
[object]
mass_kg = 80.9866
stiffness_N_per_m = 5967
damping_N_s_per_m = 49.1272
"""


def test_a_margin_names_where_the_loop_is_stable_again(write_rig):
    file = write_rig(ISLAND)
    for subcommand, told in answers(file).items():
        (from_ms, to_ms), = told["margin"]["stable_again_ms"]
        assert f"stable again from {from_ms:.4g} to {to_ms:.4g} ms of dead time" in told["margin"]["sentence"], subcommand
    limit_ms = 12.8501 + told["margin"]["dead_time_margin_ms"]
    for dead_time_ms, stable in ((limit_ms + 0.1, False), (from_ms + 0.1, True), (to_ms - 0.1, True), (to_ms + 0.1, False)):
        answers(file, *settings({"robot.dead_time_ms": dead_time_ms}), commands=("run", "eigen"))
        assert ask("eigen", file, *settings({"robot.dead_time_ms": dead_time_ms}))[0]["stable"] is stable, dead_time_ms


@pytest.mark.parametrize("method", ["prediction", "force-lead", "extrapolation-1", "adaptive-inverse", "identification", "tank", "passivity"])
def test_the_margin_of_a_compensated_loop_says_what_stays_as_it_is(method, write_rig):
    file = write_rig(BASE)
    told, _ = ask("eigen", file, "--with", method)
    assert "with the firmware's settings as they are" in told["margin"]["sentence"]
    if method in ("tank", "passivity"):
        bare = ask("eigen", file)[0]["margin"]
        assert f"without its passivity controller by {bare['dead_time_margin_ms']:.4g} ms" in told["margin"]["sentence"]
        grows, _ = ask("eigen", file, "--with", method, *settings({"object.stiffness_N_per_m": 5800, "robot.dead_time_ms": 26}))
        assert grows["stable"] is False or "without its passivity controller the loop is unstable" in grows["margin"]["sentence"]


def test_a_run_that_shows_another_mode_than_decides_says_which_to_believe(tmp_path):
    """A beam's second mode grows slowly, and the first one still decays; terminal, JSON, summary and page say so."""
    slow = settings({"sensor.low_pass_frequency_Hz": 200, "robot.dead_time_ms": 5, "run.duration_s": 12})
    told = run_json("ess-beam", tmp_path, *slow)
    predicted, seen = told["prediction"]["growth_per_s"], told["growth_per_s"]
    assert predicted > 0 > seen and told["stable"] is False
    assert told["caveat"].startswith(f"predicted {predicted:+.3g} /s, this run measured {seen:+.3g} +- ")
    assert told["caveat"].endswith("believe the prediction")
    assert one_json_object(command("summary", told["log"], "--json").stdout)["caveat"] == told["caveat"]
    assert f"caveat         {told['caveat']}" in command("run", "ess-beam", "--no-log", *slow).stdout.decode()
    assert ask("run", "ess")[0]["caveat"] is None
    assert any("elieve the prediction" in note for note in verdict(read_log(told["log"]), told | {"cut": False, "missing_ticks": 0}).notes)


@pytest.mark.parametrize("subcommand", ["eigen", "limits", "check"])
def test_the_margin_of_an_arm_says_what_stays_as_it_is(subcommand):
    margin = ask(subcommand, "ess", *settings({"manipulator.arm": "ess", "object.stiffness_N_per_m": 1500}))[0]["margin"]
    assert margin["dead_time_margin_ms"] > 0
    assert "of the arm where it starts, with the firmware's settings as they are" in margin["sentence"]


@pytest.mark.parametrize("subcommand", ["run", "eigen", "limits", "check"])
def test_what_nothing_damps_neither_decays_nor_grows(subcommand, write_rig):
    """A longer run shows no more of it."""
    text = "[manipulator]\nmass_kg = 120\nstiffness_N_per_m = 8000\ndamping_N_s_per_m = 0\ninitial_position_m = 0.005\n" \
           "[robot]\ndead_time_ms = 34\n[object]\nkind = \"none\"\n"
    told, _ = ask(subcommand, write_rig(text))
    assert told["verdict"] == "undetermined" and "neither decays nor grows" in told["because"]
    assert "give it damping" in told["advice"] and "less noise" not in told["advice"]
