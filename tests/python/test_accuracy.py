"""`berth accuracy`: orders and sizes of the errors of fixed steps."""

import pytest
from conftest import EXIT_INPUT, command, one_json_object

INTEGRATORS = ("semi_implicit_euler", "rk4", "implicit_midpoint")


@pytest.fixture(scope="module")
def found():
    done = command("accuracy", "ess", "--json")
    assert done.returncode == 0, done.stderr.decode()
    return one_json_object(done.stdout)


def errors(found, integrator, force):
    """Error of the tool by step, ms to m."""
    return {row["step_ms"]: row["tool_m"] for row in found["rows"]
            if row["integrator"] == integrator and row["force"] == force}


def test_the_manoeuvre_has_contact(found):
    assert found["events"] >= 2
    assert found["largest_force_N"] > 50
    assert found["truth_m"] < 1e-9


@pytest.mark.parametrize("integrator,order", [("semi_implicit_euler", 1), ("rk4", 2), ("implicit_midpoint", 2)])
def test_order(found, integrator, order):
    """RK4 has order 2 here: the force that it is given is a mean over each step."""
    by_step = errors(found, integrator, "mean")
    assert by_step[5.0] / by_step[0.5] == pytest.approx(10 ** order, rel=0.1)


def test_holding_the_force_costs_more_than_the_integrator(found):
    alone = errors(found, "implicit_midpoint", "mean")[2.5]
    held = errors(found, "implicit_midpoint", "held")[2.5]
    led = errors(found, "implicit_midpoint", "led")[2.5]
    assert alone < 5e-6
    assert held > 50 * alone
    assert led < held / 50
    assert found["tool_m"] == alone and found["held_tool_m"] == held and found["led_tool_m"] == led


def test_momentum_comes_of_nothing_only_by_rounding_and_order(found):
    for name in ("rk4", "implicit_midpoint"):
        drift = found["momentum_drift"][name]
        assert drift["moved_N_s"] > 1
        assert drift["linear_N_s"] < 1e-6 * drift["moved_N_s"]


def test_stiff_joints_need_the_implicit_integrator(tmp_path):
    """A hundred thousand times as stiff: the others blow up at the loop's step."""
    arm = command("arm", "ess").stdout.decode()
    lines = []
    for line in arm.splitlines():
        key, _, value = line.partition(" = ")
        if key == "stiffness_N_m_per_rad" and "[attitude]" not in lines:
            line = f"{key} = {1e5 * float(value.split()[0])}"
        lines.append(line)
    file = tmp_path / "stiff.toml"
    file.write_text("\n".join(lines))
    found = one_json_object(command("accuracy", file, "--json").stdout)
    assert errors(found, "implicit_midpoint", "mean")[2.5] < 20e-6
    for explicit in ("semi_implicit_euler", "rk4"):
        error = errors(found, explicit, "mean")[2.5]
        assert error is None or error > 0.01


def test_bad_step():
    done = command("accuracy", "ess", "--step-ms", "3")
    assert done.returncode == EXIT_INPUT
    assert b"must be one of 0.1, 0.2" in done.stderr
    done = command("accuracy", "no-such-arm")
    assert done.returncode == EXIT_INPUT
    assert b"no shipped arm" in done.stderr and b"ess" in done.stderr


@pytest.mark.parametrize("repeatability", ["nan", "0", "-1"])
def test_a_repeatability_that_is_none_is_refused(repeatability):
    done = command("accuracy", "ess", "--repeatability-um", repeatability)
    assert done.returncode == EXIT_INPUT and b"--repeatability-um" in done.stderr


def test_a_beam_is_measured_by_its_reduction():
    """An object of several modes is refused with what to do about it, and that works."""
    refused = command("accuracy", "ess-berthing-pose", "--json")
    assert refused.returncode == EXIT_INPUT and b"--set object.modes=1" in refused.stderr
    done = command("accuracy", "ess-berthing-pose", "--json", "--set", "object.modes=1")
    assert done.returncode == 0, done.stderr.decode()
    reduced = one_json_object(done.stdout)
    assert reduced["events"] >= 2 and 0.0 < reduced["tool_m"] < 1e-4
    of_an_arm = command("accuracy", "ess", "--set", "object.modes=1")
    assert of_an_arm.returncode == EXIT_INPUT and b"--set: goes with a rig; ess is an arm" in of_an_arm.stderr


def test_a_step_too_coarse_is_told_with_the_substeps_that_are_enough(found):
    repeatability_m = 0.5e-6
    done = command("accuracy", "ess", "--repeatability-um", "0.5")
    assert done.returncode == 0, done.stderr.decode()
    [advice] = [line for line in done.stdout.decode().splitlines() if "substeps" in line]
    by_step = errors(found, "implicit_midpoint", "mean")
    assert by_step[2.5] > repeatability_m
    enough_ms = max(step for step, error in by_step.items() if step < 2.5 and error <= repeatability_m)
    assert f"steps of {enough_ms:g} ms" in advice and f"substeps = {-(-2.5 // enough_ms):g} " in advice
