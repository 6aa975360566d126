"""Two effects in one block: both are named with their sizes, or a rival of either is told; never one that stands in."""

import gripped_chain
import numpy as np
import pytest
from conftest import EXIT_DONE, command, settings, topic
from test_diagnosis import diagnose, values, write

RUN = {"run.duration_s": 30, "profile.kind": "multisine", "profile.amplitude_m": 0.01, "sensor.noise_N": 0.2,
       "robot.feedback_noise_m": 5e-6}


def run_with(tmp_path, hidden, rig="ess"):
    done = command("run", rig, "--out", tmp_path, *settings(RUN | hidden))
    assert done.returncode == EXIT_DONE, done.stderr.decode()
    [log] = tmp_path.glob("*.ulg")
    return log


@pytest.mark.parametrize("hidden", [
    {"robot.lag_ms": 8.0, "robot.backlash_m": 1e-4},  # beside the lag the play is small, and yet all that is left
    {"object.cubic_stiffness_N_per_m3": 3e6, "object.coulomb_friction_N": 2.0},
    {"robot.dead_time_ms": 20.0, "robot.periodic_error_m": 5e-5, "robot.periodic_error_pitch_m": 0.004},  # no resonance
    {"robot.lag_ms": 8.0, "robot.velocity_limit_m_per_s": 0.06},
], ids=" and ".join)
@pytest.mark.first(2)
def test_both_of_one_block_are_named(tmp_path, hidden):
    found = diagnose(tmp_path / "out", run_with(tmp_path, hidden), "--rig", "ess")
    assert found["verdict"] == "named" and len(found["causes"]) == 2
    sizes = {one["name"]: one for cause in found["causes"] for one in cause["parameters"]}
    for key, true in hidden.items():
        size = sizes[key.split(".")[1]]
        assert size["value"] == pytest.approx(true, rel=0.01)
        assert size["ci95"][0] - 1e-3 * true < true < size["ci95"][1] + 1e-3 * true


@pytest.mark.parametrize("pitch_m, dead_time_ms", [(0.004, 20.0), (0.0042, 20.0), (0.004, 19.5)])
@pytest.mark.first(1)
def test_without_a_force_a_rival_of_the_first_cause_is_told(tmp_path, pitch_m, dead_time_ms):
    """To slow reports a resonance is a dead time, and the periodic error comes second."""
    t_s = 0.0025 * np.arange(12000)
    command_m = 5e-3 * np.sin(1.9 * t_s) + 3e-3 * np.sin(6.9 * t_s + 1.1) + 2e-3 * np.sin(14.5 * t_s + 2.3)
    robot_m = np.interp(t_s - 1e-3 * dead_time_ms, t_s, command_m)
    robot_m += 5e-5 * np.sin(2.0 * np.pi * robot_m / pitch_m)
    robot_m += 5e-6 * np.random.default_rng(3).standard_normal(len(t_s))
    record = write(tmp_path / "late.csv", "t_s,command_position_m,robot_position_m", t_s, command_m, robot_m)
    found = diagnose(tmp_path / "out", record, "--rig", "ess")
    offered = {*values(found), *(other["effect"] for other in found["alternatives"])}
    assert {"robot.dead_time", "robot.periodic_error"} <= offered
    assert found["verdict"] == ("named" if len(offered) == 2 else "one_of")


def test_a_late_sensor_behind_reports_too_noisy_to_tell_how_the_robot_is_late(tmp_path):
    """The force follows both alike: a lag of the robot and a delay of the sensor do what is a dead time and a lag."""
    hidden = {"robot.dead_time_ms": 22.0, "sensor.lag_ms": 1.0, "robot.feedback_noise_m": 1e-4}
    found = diagnose(tmp_path / "out", run_with(tmp_path, hidden), "--rig", "ess")
    told = {block["block"]: block["verdict"] for block in found["blocks"]}
    right = set(values(found)) == {"robot.dead_time", "sensor.lag"}
    assert right or "named" not in (told["robot"], told["force"]), found["causes"]


@pytest.mark.parametrize("late", [{"sensor.lag_ms": 6.0}, {"sensor.delay_ms": 7.5}], ids=str)
@pytest.mark.first(1)
def test_a_late_sensor_behind_a_late_robot_whose_reports_are_clear(tmp_path, late):
    found = diagnose(tmp_path / "out", run_with(tmp_path, {"robot.lag_ms": 8.0} | late), "--rig", "ess")
    [(key, true)] = late.items()
    effect = key.removesuffix("_ms")
    assert found["verdict"] == "named" and set(values(found)) == {"robot.lag", effect}
    assert values(found)[effect][key.split(".")[1]] == pytest.approx(true, rel=0.05)


@pytest.mark.parametrize("robot_lag_ms, sensor_lag_ms", [(5.0, 4.0), (6.0, 4.0), (4.0, 5.0)])
@pytest.mark.first(1)
def test_a_sensor_that_lags_behind_a_robot_that_lags_is_offered(tmp_path, robot_lag_ms, sensor_lag_ms):
    """The robot's could make up for the sensor's, if its reports did not hold it."""
    found = diagnose(tmp_path / "out", run_with(tmp_path, {"robot.lag_ms": robot_lag_ms, "sensor.lag_ms": sensor_lag_ms}),
                     "--rig", "ess")
    offered = {*values(found), *(other["effect"] for other in found["alternatives"])}
    assert found["verdict"] in ("named", "one_of") and {"robot.lag", "sensor.lag"} <= offered
    assert found["verdict"] == "one_of" or set(values(found)) == {"robot.lag", "sensor.lag"}


def without_reports(log, path):
    """The command and the force alone."""
    tick = topic(log)
    return write(path, "t_s,command_position_m,force_N", 1e-6 * tick["timestamp"], tick["command_position_m"],
                 tick["force_N"])


@pytest.mark.parametrize("late", [{"robot.lag_ms": 6.0, "sensor.lag_ms": 4.0}, {"robot.lag_ms": 8.0, "sensor.lag_ms": 5.0}],
                         ids=str)
def test_without_reports_two_lags_are_no_resonance_beyond_doubt(tmp_path, late):
    """As one it does what they do, damped more than critically."""
    record = without_reports(run_with(tmp_path, late), tmp_path / "blind.csv")
    found = diagnose(tmp_path / "out", record, "--rig", "ess")
    [block] = found["blocks"]
    assert set(values(found)) == set(key.removesuffix("_ms") for key in late) or (
        found["verdict"] == "partly_explained" and "two other effects together do as well" in block["doubts"])


WELL_KNOWN = """
name = "well-known"
[manipulator]
mass_kg = 60.0
damping_N_s_per_m = 120.0
stiffness_N_per_m = 6000.0
[robot]
dead_time_ms = { value = 10.0, tolerance = 0.03 }
interpolation = "linear"
[sensor]
stiffness_N_per_m = 400000.0
damping_ratio = 0.03
low_pass_order = 2
low_pass_frequency_Hz = 60.0
low_pass_damping_ratio = 0.7
delay_ms = 5.0
[object]
kind = "gripped"
mass_kg = { value = 12.0, tolerance = 0.03 }
stiffness_N_per_m = { value = 3500.0, tolerance = 0.03 }
damping_N_s_per_m = { value = 25.0, tolerance = 0.03 }
surface_position_m = 0.0
"""


@pytest.mark.slow
def test_without_reports_a_lag_is_no_resonance_beside_a_gain(tmp_path):
    """Which contains it; only beside the gain do both do as well, where the object is known too well for it."""
    rig = tmp_path / "rig.toml"
    rig.write_text(WELL_KNOWN)
    hidden = {"robot.lag_ms": 6.0, "sensor.gain_error": 0.1, "loop.rate_Hz": 400, "object.mass_kg": 12.2}
    record = without_reports(run_with(tmp_path, hidden, rig), tmp_path / "blind.csv")
    found = diagnose(tmp_path / "out", record, "--rig", rig)
    offered = {*values(found), *(other["effect"] for other in found["alternatives"])}
    assert found["verdict"] == "one_of" and "robot.resonance" not in offered
    assert {"robot.lag", "sensor.lag", "robot.gain", "sensor.gain"} <= offered


@pytest.mark.parametrize("dead_time_ms", [12.5, 13.0, 13.5])
@pytest.mark.first(1)
def test_what_two_parameters_more_earn_by_chance_names_no_resonance(tmp_path, dead_time_ms):
    """Reports and force weigh the two; of a dead time of 13 ms the resonance is 10 better in the sum of squares."""
    told = gripped_chain.diagnosed(tmp_path, np.random.default_rng(4), gripped_chain.chirp(), dead_time_ms)
    assert told["verdict"] in ("named", "one_of")
    assert [cause["effect"] for cause in told["causes"]] == ["robot.dead_time"]


def test_friction_that_differs_between_the_directions_by_itself(tmp_path):
    """Without dry friction, beside which it had been looked for alone."""
    period_s, mass_kg, damping_N_s_per_m, stiffness_N_per_m = 0.0025, 200.0, 125.664, 7895.684
    more_N_s_per_m, steps = 60.0, 20
    t_s = period_s * np.arange(8000)
    operator_N = 60.0 * np.sin(1.7 * t_s) + 40.0 * np.sin(4.9 * t_s) + 30.0 * np.sin(11.3 * t_s)
    x_m, v_m_per_s, command_m = 0.0, 0.0, []
    for force_N in operator_N:
        command_m.append(x_m)
        for _ in range(steps):
            pull_N = force_N - damping_N_s_per_m * v_m_per_s - more_N_s_per_m * abs(v_m_per_s) - stiffness_N_per_m * x_m
            v_m_per_s += period_s / steps * pull_N / mass_kg
            x_m += period_s / steps * v_m_per_s
    command_m = np.array(command_m) + 1e-5 * np.random.default_rng(5).standard_normal(len(t_s))
    record = write(tmp_path / "way.csv", "t_s,operator_force_N,command_position_m", t_s, operator_N, command_m)
    found = diagnose(tmp_path / "out", record, "--rig", "ess")
    assert found["verdict"] == "named" and list(values(found)) == ["manipulator.asymmetric_friction"]
    size = values(found)["manipulator.asymmetric_friction"]["damping_asymmetry_N_s_per_m"]
    assert size == pytest.approx(more_N_s_per_m, rel=0.01)


@pytest.mark.slow
def test_a_cause_is_no_rival_of_itself(tmp_path):
    """Dry friction, found second, had been a rival of the offset that was found first."""
    period_s, mass_kg, damping_N_s_per_m, stiffness_N_per_m = 0.0025, 200.0, 125.664, 7895.684
    t_s = period_s * np.arange(8000)
    operator_N = 60.0 * np.sin(1.7 * t_s) + 40.0 * np.sin(4.9 * t_s)
    x_m, v_m_per_s, command_m, steps = 0.0, 0.0, [], 50
    for force_N in operator_N:
        command_m.append(x_m)
        for _ in range(steps):
            dry_N = 6.0 * np.tanh(v_m_per_s / 1e-5)
            pull_N = force_N + 4.0 - dry_N - damping_N_s_per_m * v_m_per_s - stiffness_N_per_m * x_m
            v_m_per_s += period_s / steps * pull_N / mass_kg
            x_m += period_s / steps * v_m_per_s
    command_m = np.array(command_m) + 1e-6 * np.random.default_rng(5).standard_normal(len(t_s))
    record = write(tmp_path / "dry.csv", "t_s,operator_force_N,command_position_m", t_s, operator_N, command_m)
    found = diagnose(tmp_path / "out", record, "--rig", "ess")
    [block] = [one for one in found["blocks"] if one["block"] == "manipulator"]
    causes = [cause["effect"] for cause in block["causes"]]
    assert "manipulator.coulomb_friction" in causes
    assert not set(causes) & {other["effect"] for other in block["alternatives"]}
