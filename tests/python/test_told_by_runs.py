"""Rigs that neither eigenvalues nor a single run tell: compensations that saturate, adapt or hide what grows, play, drives
with limits, arms that touch nothing, schedules. All commands give one answer, and what is advised is run."""

import re
import sys

import pytest
from answers import answers, ask
from conftest import EXIT_DIFFERENT, ROOT, command, settings
from test_one_answer import BASE, LONGER, NO_ADVICE, STIFF, STIFFER

sys.path.insert(0, str(ROOT / "scripts"))
import report_delay  # noqa: E402

DIVERGING = """
[run]
duration_s = 20
[loop]
rate_Hz = 500
[manipulator]
mass_kg = 150
damping_N_s_per_m = 90
stiffness_N_per_m = 6000
initial_position_m = 0.005
[limits]
position_min_m = -1.0
position_max_m = 1.0
velocity_m_per_s = 2.0
acceleration_m_per_s2 = 50.0
[sensor_channel]
force_limit_N = 20000.0
[robot]
dead_time_ms = 20
[sensor]
stiffness_N_per_m = 1e7
low_pass_frequency_Hz = 40
delay_ms = 2
[object]
mass_kg = 40
stiffness_N_per_m = 6000
damping_N_s_per_m = 20
[adaptive_inverse]
enabled = true
"""
ARM_TOOL = """
[run]
duration_s = 5
[loop]
rate_Hz = 400
[manipulator]
mass_kg = 200
stiffness_N_per_m = 7900
damping_N_s_per_m = 125
arm = "ess"
[robot]
dead_time_ms = 20
[sensor]
low_pass_frequency_Hz = 150
[object]
kind = "contact"
mass_kg = 1
stiffness_N_per_m = 2000
damping_N_s_per_m = 150
surface_position_m = 0.02
"""
LEAD = {"force_lead.enabled": "true", "object.mass_kg": 260}
PASSIVE = {"passivity.action": "damping"}


@pytest.mark.parametrize("rig, changes, stable, words, advice", [
    ("ess", LEAD, False, {"run": "at its limit of 2e+04 N"}, "--set force_lead.enabled=false --with prediction"),
    ("ess", LEAD | {"robot.backlash_m": 1e-4}, False, {"run": "it rattles", "eigen": "it rattles"}, "object.mass_kg below"),
    (DIVERGING, {}, False, {"run": "limits hold what grows", "check": "limits hold what grows"}, "adaptive_inverse.enabled=false"),
    (ARM_TOOL, {}, None, {name: "never come" for name in ("eigen", "limits", "check")}, "surface_position_m"),
    (BASE, STIFF | LONGER | PASSIVE, None, {}, ""),
], ids=["lead", "lead and play", "adaptive inverse", "an arm that never touches", "a schedule under passivity"])
def test_what_no_eigenvalue_tells_has_one_answer(rig, changes, stable, words, advice, write_rig):
    told = answers(write_rig(rig) if "\n" in rig else rig, *settings(changes))
    assert len({(one["margin"] or {})["dead_time_margin_ms"] for one in told.values()}) == 1
    assert len({one["advice"] for one in told.values()}) == 1, {name: one["advice"] for name, one in told.items()}
    for name, part in words.items():
        assert part in told[name]["because"], told[name]["because"]
    if rig != BASE:
        assert told["run"]["stable"] is stable and advice in told["run"]["advice"], told["run"]["advice"]


PLAY = {"robot.backlash_m": 5e-4, "object.stiffness_N_per_m": 9000}


@pytest.mark.parametrize("changes", [PLAY, PLAY | {"adaptive_inverse.enabled": "true", "object.stiffness_N_per_m": 12000}, STIFFER | {"robot.velocity_limit_m_per_s": 0.02}], ids=str)
def test_what_is_advised_on_a_rig_that_runs_judge_cures_it(changes, write_rig):
    file = write_rig(BASE)
    told, _ = ask("run", file, *settings(changes))
    assert told["stable"] is False and told["advice"] == ask("eigen", file, *settings(changes))[0]["advice"]
    assert told["advice"] != NO_ADVICE
    for one in told["advice"].split(", or "):
        change = re.fullmatch(r"(\S+) (above|below) (\S+)", one)
        options = ("--set", f"{change[1]}={float(change[3]) * (0.95 if change[2] == 'below' else 1.05):.9g}") if change \
            else one.split(":")[0].split()
        assert ask("run", file, *settings(changes), *options)[0]["stable"] is True, one


@pytest.mark.parametrize("changes, from_s, more_ms", [(LONGER, 5, 70), ({"robot.dead_time_drift_ms_per_s": 6}, None, 100)], ids=str)
def test_the_delay_budget_has_what_a_schedule_makes_of_it(changes, from_s, more_ms, write_rig):
    file = write_rig(BASE)
    for told in answers(file, *settings(changes)).values():
        last = told["delay_budget"]["scheduled"][-1]
        assert from_s is None or last["from_s"] == from_s
        assert last["total_ms"] - told["delay_budget"]["total_ms"] >= more_ms - 1e-6
    assert f"; {last['total_ms']:.4g} ms from 5 s on" in command("eigen", file, *settings(LONGER)).stdout.decode() or from_s is None
    assert f"{last['total_ms']:.4g} ms from {last['from_s']:.4g} s on" in report_delay.section(told["delay_budget"])
    assert ask("check", file)[0]["delay_budget"]["scheduled"] == []


@pytest.mark.parametrize("options", [(), ("--with", "identification")], ids=["eigenvalues", "runs"])
def test_a_run_that_never_grips_is_said_where_the_loop_is_judged_by_itself(options, write_rig):
    file = write_rig(BASE)
    late = settings({"run.grip_close_s": 31})
    for subcommand in ("eigen", "limits"):
        told, _ = ask(subcommand, file, *late, *options)
        assert told["stable"] is True and "never grips the object; let run.grip_close_s lie" in told["caveat"]
        assert "  caveat " in command(subcommand, file, *late, *options).stdout.decode()
        assert ask(subcommand, file, *options)[0]["caveat"] is None
    assert ask("run", file, *late, *options)[0]["verdict"] == "undetermined"


@pytest.mark.parametrize("limit", [{"robot.velocity_limit_m_per_s": 0.05}], ids=str)
def test_what_grows_from_rest_up_to_a_drives_limit_is_a_limit_cycle_in_every_command(limit):
    found = answers("ess-beam", *settings(limit), "--with", "extrapolation-1").values()
    assert {told["verdict"] for told in found} == {"limit cycle"} and {told["stable"] for told in found} == {False}
    assert all("the eigenvalues say +5.05 /s" in told["because"] for told in found)


def test_check_says_that_a_run_never_grips(write_rig):
    told, code = ask("check", write_rig(BASE), *settings({"run.grip_close_s": 31}))
    assert code == EXIT_DIFFERENT and [one["key"] for one in told["implausible"]] == ["run.grip_close_s"]
