"""A probe that touches and leaves: run and limits have one restitution, the energy's word does not hang on the instant at
which the run ends, and what is recommended passes the check that is printed."""

import json
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
