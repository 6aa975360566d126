"""A run in which nothing moves says nothing of the loop: no verdict, and why."""

from pathlib import Path

import pytest
from conftest import command, one_json_object, run_json, settings
from test_report import made

AT_REST = {"manipulator.initial_position_m": 0, "run.duration_s": 20}


@pytest.mark.parametrize("arm", [{}, {"manipulator.arm": "ess"}], ids=["without an arm", "with an arm"])
def test_a_loop_at_rest_is_not_called_stable(tmp_path, arm):
    told = run_json("ess", tmp_path, *settings(AT_REST | arm))
    assert told["stable"] is None and told["growth_per_s"] is None and told["peak_force_N"] == 0
    shown = command("run", "ess", "--no-log", *settings(AT_REST | arm)).stdout.decode()
    assert "  NOT DETERMINED nothing moved: there is no motion to judge\n" in shown
    assert one_json_object(command("summary", told["log"], "--json").stdout)["stable"] is None
    page, _ = made(Path(told["log"]))
    assert " Not determined " in page.text and "Nothing moved: there is no motion to judge." in page.text


def test_what_comes_to_rest_is_still_stable(tmp_path):
    damped = {"manipulator.damping_N_s_per_m": 2000, "run.duration_s": 20}
    assert run_json("ess", tmp_path, *settings(damped))["stable"] is True
