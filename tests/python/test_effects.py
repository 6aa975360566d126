"""Round trips: the simulated rig runs an effect, the diagnosis of its log names it; and the rig that made a log
replays it but for the noise."""

import json

import numpy as np
import pytest
from conftest import EXIT_DONE, EXIT_INPUT, command, settings

NOISE_N = 0.05
NOISE_m = 2e-6
EXCITED = {
    "run.duration_s": 20.1,
    "profile.kind": "multisine",
    "profile.duration_s": 20,
    "profile.amplitude_N": 200,
    "operator.interface": "force",
    "sensor.noise_N": NOISE_N,
    "robot.feedback_noise_m": NOISE_m,
}

EFFECTS = {
    "robot.backlash": {"robot.backlash_m": 1e-4},
    "robot.gain": {"robot.gain_error": 0.02},
    "robot.lag": {"robot.lag_ms": 6},
    "robot.dead_time_drift": {"robot.dead_time_drift_ms_per_s": 0.5},
    "robot.lost_commands": {"robot.lost_command_probability": 0.02},
    "robot.periodic_error": {"robot.periodic_error_m": 1e-4, "robot.periodic_error_pitch_m": 4e-3},
    "sensor.lag": {"sensor.lag_ms": 5},
    "sensor.drift": {"sensor.drift_N_per_s": 0.5},
    "sensor.periodic_disturbance": {"sensor.periodic_N": 1, "sensor.periodic_frequency_Hz": 50},
    "sensor.spikes": {"sensor.spike_probability": 0.01, "sensor.spike_N": 20},
    "object.coulomb_friction": {"object.coulomb_friction_N": 2},
    "object.cubic_stiffness": {"object.cubic_stiffness_N_per_m3": 2e6},
    "object.quadratic_stiffness": {"object.quadratic_stiffness_N_per_m2": 5e4},
    "object.stiffness_drift": {"object.stiffness_drift_per_s": 0.01},
    "object.second_mode": {"object.second_mass_kg": 5, "object.second_frequency_Hz": 5,
                           "object.second_damping_ratio": 0.02},
    "object.hysteresis": {"object.hysteresis_force_N": 5, "object.hysteresis_length_m": 2e-3},
    "object.relaxation": {"object.relaxation_stiffness_N_per_m": 800, "object.relaxation_time_ms": 150},
    "sensor.curvature": {"sensor.curvature_per_N": 2e-3},
    "sensor.tool_inertia": {"sensor.tool_mass_kg": 15},
    "loop.lost_samples": {"loop.lost_sample_probability": 0.02},
    "manipulator.gravity_offset": {"manipulator.gravity_offset_N": 5},
    "manipulator.cubic_stiffness": {"manipulator.cubic_stiffness_N_per_m3": 2e6},
}

# On a stiff sensor the object moves as the tool behind it does: the tool is mass of the object.
HELD_STIFFLY = {"sensor.tool_inertia": "object.parameters"}

# Which setpoints were lost no rig file tells; the manipulator is the firmware's own.
NOT_REPLAYED = ("robot.lost_commands", "manipulator.gravity_offset", "manipulator.cubic_stiffness")


@pytest.fixture(scope="module")
def excited(tmp_path_factory):
    """Log of `ess` with an effect under an excitation that shows it."""
    made = {}

    def make(effect, overrides=None):
        case = (effect, str(overrides))
        if case not in made:
            folder = tmp_path_factory.mktemp("effects")
            given = EXCITED | EFFECTS[effect] | (overrides or {})
            done = command("run", "ess", *settings(given), "--out", folder)
            assert done.returncode == 0, done.stderr
            made[case] = folder / "ess.ulg"
        return made[case]

    return make


def diagnose(log, folder, overrides):
    done = command("diagnose", log, "--rig", "ess", *settings(overrides), "--out", folder)
    assert done.returncode == 0, done.stderr
    return json.loads((folder / "diagnosis.json").read_text())


@pytest.mark.long
@pytest.mark.parametrize("effect", EFFECTS)
def test_the_diagnosis_names_what_the_rig_ran_with(effect, excited, tmp_path):
    diagnosis = diagnose(excited(effect), tmp_path, {})
    assert diagnosis["verdict"] == "named"
    assert [cause["effect"] for cause in diagnosis["causes"]] == [HELD_STIFFLY.get(effect, effect)]
    if effect in HELD_STIFFLY:
        return
    for parameter in diagnosis["causes"][0]["parameters"]:
        truth = next((value for key, value in EFFECTS[effect].items() if key == parameter["key"]), None)
        if truth is not None and "probability" not in parameter["key"]:
            assert parameter["value"] == pytest.approx(truth, rel=0.15), parameter


@pytest.mark.long
@pytest.mark.parametrize("effect", [name for name in EFFECTS if name not in NOT_REPLAYED])
def test_the_rig_that_made_a_log_replays_it_but_for_the_noise(effect, excited, tmp_path):
    """Without noise in the robot's reports, so that its dead time, told anew from them, is exact."""
    diagnose(excited(effect, {"robot.feedback_noise_m": 0}), tmp_path, EFFECTS[effect])
    series = np.genfromtxt(tmp_path / "series.csv", delimiter=",", names=True)[400:]
    # What was lost or thrown off is not compared.
    robot_m = series["robot_error_before_m"][series["robot_use"] > 0]
    used_N = series["force_error_before_N"][series["force_use"] > 0]
    assert len(used_N) > 0.9 * len(series)
    assert np.sqrt(np.mean(used_N ** 2)) == pytest.approx(NOISE_N, rel=0.05)
    assert np.sqrt(np.mean(robot_m ** 2)) < 1e-10


@pytest.mark.long
@pytest.mark.parametrize("effect", ["robot.gain", "robot.backlash", "object.cubic_stiffness", "robot.dead_time_drift"])
def test_the_extended_model_runs_and_has_eigenvalues_at_once(effect, excited, tmp_path):
    diagnose(excited(effect), tmp_path, {})
    extended = str(tmp_path / "extended.toml")
    run = command("run", extended, "--json", "--no-log")
    assert run.returncode == 0, run.stderr
    eigen = command("eigen", extended, "--json", text=True)
    assert eigen.returncode == 0, eigen.stderr
    told = json.loads(eigen.stdout)
    assert effect not in eigen.stderr and told["left_out"] == []
    assert bool(told["prediction"]["schedule"]) == (effect == "robot.dead_time_drift")
    replaced = [part["effect"] for part in (told["describing_function"] or {"effects": []})["effects"]]
    assert replaced == ([effect] if effect in ("robot.backlash", "object.cubic_stiffness") else [])
    assert command("map", extended, "--vary", "mass", "--grid", "4x4", "--out", tmp_path).returncode == 0


def diagnosed_quick_robot(folder, rest_of_rig):
    """verdict and causes of a robot that is 1 ms late, and the arguments that diagnose its record."""
    period_s, late_s, rows = 0.0025, 0.001, 4000
    t_s = period_s * np.arange(rows)
    command_m = 0.01 * np.sin(2 * np.pi * 0.7 * t_s) * np.sin(2 * np.pi * 0.11 * t_s)
    robot_m = np.interp(t_s - late_s, t_s, command_m) + 2e-6 * np.random.default_rng(1).standard_normal(rows)
    np.savetxt(folder / "record.csv", np.column_stack([t_s, command_m, robot_m]), delimiter=",", comments="",
               header="t_s,command_position_m,robot_position_m", fmt="%.12g")
    (folder / "rig.toml").write_text('name = "quick"\n[loop]\nrate_Hz = 400\n[robot]\ndead_time_ms = 12\n'
                                     'interpolation = "linear"\n[bus]\nideal = true\n' + rest_of_rig)
    return diagnosed_with(folder, folder / "rig.toml", folder)


def diagnosed_with(folder, rig, out):
    done = command("diagnose", folder / "record.csv", "--rig", rig, "--out", out, text=True)
    assert done.returncode == EXIT_DONE, done.stderr
    return json.loads((out / "diagnosis.json").read_text())


@pytest.mark.long
def test_a_robot_that_is_hardly_late_is_extended_to_what_runs(tmp_path):
    """A straight line to a setpoint needs it a period ahead: what is less late is told in part."""
    found = diagnosed_quick_robot(tmp_path, "[manipulator]\nmass_kg = 200\n[object]\nmass_kg = 100\n")
    assert found["verdict"] in ("partly_explained", "unknown")
    for what in ("run", "eigen"):
        done = command(what, tmp_path / "extended.toml", "--json", *["--no-log"] * (what == "run"), text=True)
        assert done.returncode == EXIT_DONE, done.stderr


@pytest.mark.long
def test_a_robot_by_itself_may_be_less_late_than_a_row(tmp_path):
    """Its log has target and actual position in one packet. What is written is diagnosed once more, and runs no loop. A
    lag of as much would do the same at 0.7 Hz."""
    found = diagnosed_quick_robot(tmp_path, "")
    assert (found["verdict"], [cause["effect"] for cause in found["causes"]]) == ("one_of", ["robot.dead_time"])
    [robot] = [block for block in found["blocks"] if block["block"] == "robot"]
    assert [other["effect"] for other in robot["alternatives"]] == ["robot.lag"]
    assert found["causes"][0]["parameters"][0]["value"] == pytest.approx(1.0, abs=0.01)
    again = diagnosed_with(tmp_path, tmp_path / "extended.toml", tmp_path / "again")
    assert again["verdict"] == "nothing_detectable"
    done = command("run", tmp_path / "extended.toml", text=True)
    assert done.returncode == EXIT_INPUT and "[object] is missing" in done.stderr


LINEAR = [{"robot.lag_ms": 5}, {"sensor.lag_ms": 5}, EFFECTS["object.second_mode"],
          EFFECTS["object.relaxation"], EFFECTS["sensor.tool_inertia"]]
OF_SIZE = [{"robot.backlash_m": 5e-4}, {"robot.deadband_m": 5e-4}, {"robot.velocity_limit_m_per_s": 0.03},
           {"robot.lag_ms": 5, "robot.velocity_limit_m_per_s": 0.03}, {"robot.acceleration_limit_m_per_s2": 0.2}, {"object.coulomb_friction_N": 2},
           {"object.cubic_stiffness_N_per_m3": 2e7}, {"object.quadratic_stiffness_N_per_m2": 2e5},
           {"object.backlash_m": 2e-3}, EFFECTS["object.hysteresis"], {"object.grip_force_N": 5},
           {"manipulator.coulomb_friction_N": 2}, {"manipulator.cubic_stiffness_N_per_m3": 2e7},
           {"manipulator.backlash_m": 2e-3}, {"manipulator.quadratic_stiffness_N_per_m2": 2e5},
           {"sensor.resolution_N": 5}, {"sensor.saturation_N": 10}]
LIMITS_TAKE_LONG = ("object.grip_force_N", "robot.velocity_limit_m_per_s", "sensor.saturation_N")
WITHOUT_EFFECTS_per_s = -0.298369


def slow_where_limits_take_long(keys):
    return pytest.param(keys, marks=[pytest.mark.slow] * any(key in LIMITS_TAKE_LONG for key in keys))


@pytest.mark.long
@pytest.mark.parametrize("keys", [slow_where_limits_take_long(keys) for keys in LINEAR + OF_SIZE], ids=lambda keys: next(iter(keys)))
def test_every_effect_is_in_eigenvalues_limits_and_maps(keys, tmp_path):
    eigen, limits, mapped = (command(what, "ess", *settings(keys), *more, "--json", text=True) for what, more in
                             (("eigen", ()), ("limits", ()),
                              ("map", ("--vary", "mass", "--grid", "4x3", "--out", tmp_path))))
    for done in (eigen, limits, mapped):
        assert (done.returncode, done.stderr) == (0, "")
    told = json.loads(eigen.stdout)
    growth_per_s = told["prediction"]["growth_per_s"]
    assert abs(growth_per_s - WITHOUT_EFFECTS_per_s) > 1e-4
    if told["growth_per_s"] is not None or told["verdict"] != "limit cycle":
        assert told["growth_per_s"] == pytest.approx(growth_per_s, rel=1e-6)
    assert json.loads(limits.stdout)["prediction"]["growth_per_s"] == pytest.approx(growth_per_s, rel=1e-6)
    assert json.loads(mapped.stdout)["own"]["growth_per_s"] == pytest.approx(growth_per_s, rel=1e-6)
    if keys in OF_SIZE:
        assert told["describing_function"]["amplitude_m"] == 0.01 and told["describing_function"]["settled"]
    else:
        assert told["describing_function"] is None


def test_the_amplitude_is_said_and_can_be_chosen(tmp_path):
    keys = settings({"robot.backlash_m": 1e-3})
    small = command("eigen", "ess", *keys, "--amplitude", "0", text=True)
    assert "robot.backlash has no linearisation" in small.stderr
    assert f"growth {WITHOUT_EFFECTS_per_s:+.6f} /s" in small.stdout
    assert "describing function at 0.005 m" in command("eigen", "ess", *keys, "--amplitude", "0.005", text=True).stdout
    assert "describing function at 0.01 m" in command("map", "ess", *keys, "--vary", "mass", "--grid", "2x2", "--out",
                                                      tmp_path, text=True).stdout
