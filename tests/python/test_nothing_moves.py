"""A run in which nothing moves says nothing of the loop: the verdict is the model's, and says so."""

from pathlib import Path

import pytest
from conftest import command, one_json_object, run_json, settings
from test_report import made

AT_REST = {"manipulator.initial_position_m": 0, "run.duration_s": 20}


@pytest.mark.long
@pytest.mark.parametrize("arm", [{}, {"manipulator.arm": "ess"}], ids=["without an arm", "with an arm"])
def test_of_a_loop_at_rest_the_model_tells(tmp_path, arm):
    told = run_json("ess", tmp_path, *settings(AT_REST | arm))
    assert told["growth_per_s"] is None and told["peak_force_N"] == 0
    if told["prediction"]["growth_per_s"] < 0:
        assert told["verdict"] == "stable" and told["because"].endswith("; nothing moved in this run")
    else:
        assert told["verdict"] == "unstable"
    assert one_json_object(command("summary", told["log"], "--json").stdout)["verdict"] == told["verdict"]
    page, _ = made(Path(told["log"]))
    assert f" {told['verdict'].capitalize()} " in page.text


def test_of_a_loop_at_rest_without_a_model_nobody_knows(tmp_path):
    still = AT_REST | {"robot.backlash_m": 1e-4}
    told = run_json("ess", tmp_path, *settings(still))
    assert told["verdict"] == "undetermined" and told["stable"] is None and told["advice"]
    shown = command("run", "ess", "--no-log", *settings(still)).stdout.decode()
    assert "  undetermined   nothing moved: there is no motion to judge; not predicted: " in shown


def test_what_comes_to_rest_is_still_stable(tmp_path):
    damped = {"manipulator.damping_N_s_per_m": 2000, "run.duration_s": 20}
    assert run_json("ess", tmp_path, *settings(damped))["stable"] is True
