"""The energy account as a user sees it: in the log, in the result, and its verdict beside that of the motion."""
import numpy as np
import pytest
from conftest import replay_json, run_json, settings, topic

FIELDS = ("stored", "operator", "dissipated", "integrator", "simulated_port", "measured_port", "dead_time")


@pytest.mark.parametrize("rig, changes, gains", [
    ("ess", {}, False),
    ("concept-foam", {}, False),
    ("concept-copper", {}, True),
    ("ess", {"object.stiffness_N_per_m": 13000, "run.duration_s": 20}, True),  # a spring beyond its limit of 10657 N/m
    ("ess", {"profile.kind": "minimum_jerk", "profile.amplitude_m": 0.1, "profile.duration_s": 3}, False),
    ("ess", {"manipulator.integrator": "semi_implicit_euler"}, False),
])
def test_a_loop_that_gains_energy_is_one_that_grows(rig, changes, gains, tmp_path):
    result = run_json(rig, tmp_path, *settings(changes))
    assert result["energy"]["gains"] is gains
    assert result["stable"] is not gains
    tick = topic(result["log"])
    last = {name: tick[f"energy_{name}_J"][tick["state"] == 2][-1] for name in FIELDS}
    assert {name: result["energy"][f"{name}_J"] for name in FIELDS} == last
    assert (last["dead_time"] > 0) >= gains


def test_the_account_is_what_force_and_motion_in_the_log_make(tmp_path):
    """Simulated port: force held in a tick times the way made in it. Stored: M v^2 / 2 + K (x - x_op)^2 / 2."""
    result = run_json("ess", tmp_path, *settings({"sensor.noise_N": 1, "profile.kind": "multisine",
                                                  "profile.amplitude_m": 0.01, "run.duration_s": 10}))
    tick = topic(result["log"])
    running = tick["state"] == 2
    of = {name: values[running] for name, values in tick.items()}
    way_m = np.diff(of["manipulator_position_m"])
    port_J = np.concatenate(([0], np.cumsum(of["force_N"][:-1] * way_m)))
    assert np.abs(of["energy_simulated_port_J"] - port_J).max() < 1e-12 * np.abs(port_J).max() + 1e-15
    mass_kg, stiffness_N_per_m = 200.0, 200.0 * (2 * np.pi) ** 2
    stored_J = (mass_kg * of["manipulator_velocity_m_per_s"] ** 2
                + stiffness_N_per_m * (of["manipulator_position_m"] - of["operator_position_m"]) ** 2) / 2
    assert np.abs(of["energy_stored_J"] - stored_J).max() < 1e-9 * stored_J.max()
    replay_json(result["log"])  # exits with 0: the account replays bit for bit


def test_a_loop_that_never_ran_has_no_account(tmp_path):
    result = run_json("ess", tmp_path, *settings({"run.emergency_stop_s": 0.0, "run.duration_s": 2.0}))
    assert "energy" not in result
