"""`berth check`: values that no rig has, loops that do not start, shipped rigs."""

import pytest
from conftest import EXIT_DIFFERENT, EXIT_DONE, EXIT_INPUT, RIGS, command, one_json_object, settings


@pytest.mark.parametrize("values, key", [
    ({"object.stiffness_N_per_m": 5e7}, "object.stiffness_N_per_m"),
    ({"object.stiffness_N_per_m": 5e7}, "sensor.stiffness_N_per_m"),
    ({"sensor.stiffness_N_per_m": 2e3}, "sensor.stiffness_N_per_m"),
    ({"loop.rate_Hz": 10, "robot.dead_time_ms": 100}, "loop.rate_Hz"),
    ({"sensor.low_pass_frequency_Hz": 1.0}, "sensor.low_pass_frequency_Hz"),
    ({"robot.dead_time_ms": 600}, "robot.dead_time_ms"),
    ({"sensor.delay_ms": 2500}, "sensor.delay_ms"),
    ({"robot.lag_ms": 900}, "robot.lag_ms"),
    ({"robot.dead_time_ms": 490}, "robot.dead_time_ms"),
    ({"sensor.lag_ms": 600}, "sensor.lag_ms"),
    ({"sensor.low_pass_frequency_Hz": 0.3}, "sensor.low_pass_frequency_Hz"),
    ({"limits.velocity_m_per_s": 1e-4}, "limits.velocity_m_per_s"),
    ({"limits.acceleration_m_per_s2": 0.01}, "limits.acceleration_m_per_s2"),
    ({"sensor.noise_N": 1000}, "sensor.noise_N"),
    ({"sensor.gain_error": -0.99}, "sensor.gain_error"),
    ({"object.damping_N_s_per_m": 1e5}, "object.damping_N_s_per_m"),
    ({"manipulator.damping_N_s_per_m": 0}, "manipulator.damping_N_s_per_m"),
    ({"object.mass_kg": 1e5}, "object.mass_kg"),
    ({"object.stiffness_N_per_m": 3e6}, "manipulator.initial_position_m"),
])
def test_check_names_an_implausible_value_why_and_what_to_do(values, key):
    done = command("check", "ess", "--json", *settings(values))
    assert done.returncode == EXIT_DIFFERENT, done.stderr.decode()
    found = {one["key"]: one for one in one_json_object(done.stdout)["implausible"]}
    assert key in found and found[key]["why"] and found[key]["advice"]
    shown = command("check", "ess", *settings(values)).stdout.decode()
    assert f"implausible    {key}: " in shown and "delay " in shown


@pytest.mark.parametrize("values, ran, words", [
    ({"sensor.bias_N": 1e6}, False, "the force is beyond sensor_channel.force_limit_N"),
    ({"sensor.saturation_N": 1}, False, "the force sensor is saturated"),
    ({"sensor.noise_N": 10, "sensor_channel.force_limit_N": 25}, False, "force_limit"),
    ({"run.duration_s": 0.01}, False, "run.duration_s is not longer than run.release_s"),
    ({"limits.position_min_m": -0.002}, True, "position_limit"),
])
def test_check_finds_that_a_stable_rig_does_not_start_or_is_stopped(values, ran, words):
    done = command("check", "ess", "--json", *settings(values))
    told = one_json_object(done.stdout)
    assert done.returncode == EXIT_DIFFERENT and told["stable"] is True and told["implausible"] == []
    assert told["start"]["ran"] is ran and words in told["start"]["because"]
    assert ran or "does not start" in told["caveat"]
    shown = command("check", "ess", *settings(values)).stdout.decode()
    [line] = [line for line in shown.splitlines() if told["start"]["because"] in line]
    assert line.split()[0] == ("stops" if ran else "does")
    assert "the drive is not enabled" not in shown  # there is none


def test_of_a_long_delay_only_the_longest_part_is_named():
    """The others are what nobody set."""
    found = one_json_object(command("check", "ess", "--json", "--set", "robot.dead_time_ms=490").stdout)["implausible"]
    assert [one["key"] for one in found] == ["robot.dead_time_ms"] and "490 ms" in found[0]["what"]


def test_a_run_that_limits_held_most_of_the_time_says_so():
    def because(*words):
        return one_json_object(command("run", "ess", "--no-log", "--json", "--no-advice", *words).stdout)["because"]

    assert "limits acted in 100 % of the ticks" in because("--set", "limits.velocity_m_per_s=0.0001")
    assert "limits acted" not in because()


@pytest.mark.parametrize("rig", [rig for rig in RIGS if "berthing" not in rig and "arm" not in rig])
def test_the_shipped_rigs_are_plausible(rig):
    done = command("check", rig, "--json")
    result = one_json_object(done.stdout)
    assert result["implausible"] == [], result["implausible"]
    assert done.returncode == (EXIT_DONE if result["stable"] else EXIT_DIFFERENT)


def test_check_of_a_file_that_cannot_be_read_has_an_exit_code_of_its_own(tmp_path):
    assert command("check", tmp_path / "none.toml").returncode == EXIT_INPUT
    assert command("check", "ess", "--set", "object.mass_kg=-1").returncode == EXIT_INPUT
    assert command("check", "ess").returncode == EXIT_DONE
