"""A probe that touches and leaves: run and limits have one restitution, the energy's word does not hang on the instant at
which the run ends, and what is recommended passes the check that is printed."""

import json
import re
import resource
import shlex
import subprocess

import pytest
from conftest import EXIT_DIFFERENT, EXIT_DONE, ROOT, command, one_json_object, run_json, settings

PROBE = """
[loop]
rate_Hz = 500
[manipulator]
mass_kg = 180
stiffness_N_per_m = 700
damping_N_s_per_m = 50
initial_position_m = -0.01
initial_velocity_m_per_s = 0.02
[robot]
dead_time_ms = 34
[sensor]
delay_ms = 2
stiffness_N_per_m = 2e6
low_pass_frequency_Hz = 40
[object]
kind = "contact"
mass_kg = 4
stiffness_N_per_m = 4500
damping_N_s_per_m = 20
"""
WITHOUT_SPRING = {"manipulator.stiffness_N_per_m": 0, "manipulator.damping_N_s_per_m": 0}


@pytest.fixture
def probe(tmp_path):
    path = tmp_path / "probe.toml"
    path.write_text(PROBE)
    return path


@pytest.mark.parametrize("changes", [
    {}, {"object.stiffness_N_per_m": 1800}, {"object.stiffness_N_per_m": 9000}, {"robot.dead_time_ms": 8},
    {"object.damping_N_s_per_m": 120}, {"manipulator.stiffness_N_per_m": 1500}, WITHOUT_SPRING,
], ids=str)
def test_run_and_limits_have_one_restitution(changes, probe, tmp_path):
    told = run_json(probe, tmp_path, *settings(changes | {"run.duration_s": 20}))
    limits = one_json_object(command("limits", probe, "--json", *settings(changes)).stdout)
    assert told["bounces"]["count"] >= 1
    assert told["bounces"]["restitution"] == pytest.approx(limits["bounce"]["restitution"], abs=0.012)


@pytest.mark.parametrize("changes, gains", [({}, False), (WITHOUT_SPRING, True), ({"manipulator.damping_N_s_per_m": 5}, True)],
                         ids=str)
@pytest.mark.parametrize("duration_s", [12, 13.1, 20, 24.3, 28, 29, 30])
def test_the_word_on_energy_does_not_hang_on_the_end_of_the_run(duration_s, changes, gains, probe, tmp_path):
    told = run_json(probe, tmp_path, *settings(changes | {"run.duration_s": duration_s}))
    assert told["energy"]["gains"] is gains


@pytest.mark.long
@pytest.mark.parametrize("changes", [{}, {"object.stiffness_N_per_m": 12000}, {"object.damping_N_s_per_m": 120}], ids=str)
def test_what_is_recommended_passes_the_check_that_is_printed(changes, probe):
    told = one_json_object(command("compensate", probe, "--json", *settings(changes)).stdout)
    assert told["recommended"] or told["passed_over"]
    if told["recommended"]:
        done = subprocess.run(shlex.split(told["check"]), cwd=ROOT, capture_output=True, text=True)
        assert done.returncode == EXIT_DONE, done.stdout
    methods = {method["method"]: method for method in told["methods"]}
    for one in told["passed_over"]:
        asked = [f"--set={setting}" for setting in methods[one["method"]]["settings"]]
        done = command("eigen", probe, *settings(changes), *asked, "--check", "--json")
        assert done.returncode == EXIT_DIFFERENT and json.loads(done.stdout)["because"] == one["because"]


# --- a free body against foam ------------------------------------------------------------------------------------------
FOAM = """
[run]
duration_s = 10
[loop]
rate_Hz = 500
[manipulator]
mass_kg = 100
stiffness_N_per_m = 0
damping_N_s_per_m = 0
initial_position_m = -0.01
initial_velocity_m_per_s = 0.05
[robot]
dead_time_ms = 10
[sensor]
delay_ms = 2
low_pass_frequency_Hz = 100
[object]
kind = "contact"
mass_kg = 2
stiffness_N_per_m = 500
damping_N_s_per_m = 200
"""


def contact_of_a_free_body_s(mass_kg, stiffness_N_per_m, damping_N_s_per_m, speed_m_per_s):
    """Until the material pushes no more: M x'' = -(k x + d x'), without delay, in steps of 10 us."""
    x, v, t, step_s = 0.0, speed_m_per_s, 0.0, 1e-5
    while stiffness_N_per_m * x + damping_N_s_per_m * v > 0.0:
        v -= step_s * (stiffness_N_per_m * x + damping_N_s_per_m * v) / mass_kg
        x += step_s * v
        t += step_s
    return t


def test_contact_lasts_as_long_as_the_material_pushes(write_rig, tmp_path):
    """Damped material lets the tool go before the tool is back at the surface."""
    path = write_rig(FOAM)
    expected_s = contact_of_a_free_body_s(102.0, 500.0, 200.0, 0.05)
    because = run_json(path, tmp_path)["because"]
    assert float(re.search(r"touched the object for ([0-9.]+) s", because)[1]) == pytest.approx(expected_s, rel=0.05), because
    told = one_json_object(command("eigen", path, "--json").stdout)
    assert told["bounce"]["contact_s"] == pytest.approx(expected_s, rel=0.05)


def test_a_body_that_drifts_off_after_its_bounce_has_bounced(write_rig, tmp_path):
    told = run_json(write_rig(FOAM), tmp_path, *settings({"limits.position_min_m": -0.05}))
    assert told["verdict"] == "bouncing" and told["stable"] is True
    assert "1 bounce, " in told["because"] and "stopped by the position limit" in told["because"]


# A hard and undamped wall, and a loop nearly without delay: a bounce keeps its energy.
EVEN = {"robot.dead_time_ms": 2, "sensor.delay_ms": 0.5, "sensor.low_pass_order": 0, "object.mass_kg": 1,
        "object.damping_N_s_per_m": 0, "object.stiffness_N_per_m": 100, "run.duration_s": 20}


@pytest.mark.parametrize("changes, says", [
    ({}, "a bounce loses "),
    ({"object.damping_N_s_per_m": 0, "object.stiffness_N_per_m": 3000}, "a bounce gains "),
    (EVEN | {"sensor.noise_N": 5}, "whether a bounce gains or loses energy does not show"),
], ids=["loses", "gains", "noise"])
def test_a_difference_as_small_as_the_noise_is_neither_gain_nor_loss(changes, says, write_rig, tmp_path):
    because = run_json(write_rig(FOAM), tmp_path, *settings(changes))["because"]
    assert says in because


# Free flight grows, a wall that gives way for ever, a tool on a spring so soft that it never comes: (name, setting)
SLOW = {"free flight grows": {"manipulator.mass_kg": 120, "object.mass_kg": 40, "robot.dead_time_ms": 34,
                              "manipulator.stiffness_N_per_m": 8000, "manipulator.damping_N_s_per_m": 100,
                              "manipulator.initial_velocity_m_per_s": 0, "object.stiffness_N_per_m": 50000,
                              "object.damping_N_s_per_m": 3000},
        "foam": {},
        "undamped": {"manipulator.mass_kg": 300, "loop.rate_Hz": 1000, "robot.dead_time_ms": 1, "sensor.delay_ms": 3,
                     "sensor.low_pass_order": 0, "object.mass_kg": 1, "object.stiffness_N_per_m": 106592,
                     "object.damping_N_s_per_m": 0}}


@pytest.mark.parametrize("name", SLOW)
def test_limits_of_a_tool_in_contact_take_seconds(name, write_rig):
    """CPU time of the process: minutes where a bounce is played as long as it may take."""
    path = write_rig(FOAM)
    before_s = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    done = command("limits", path, "--json", *settings(SLOW[name]))
    assert done.returncode == EXIT_DONE, done.stderr.decode()
    spent_s = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before_s
    print(f"{name}: {spent_s:.2f} s")
    assert spent_s < 10.0
