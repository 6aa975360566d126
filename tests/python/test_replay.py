"""Recorded inputs give the recorded outputs, bit for bit; what was tampered with is found, at its tick and field."""

import numpy as np
import pytest
from conftest import (DISTURBED, EXIT_DIFFERENT, EXIT_INPUT, FRAME, RIGS, TICK, command, data_id, patched,
                      record_type, replay_json, topic, ulog_messages, without_checksums)

VARIANTS = {
    "drive": {"robot_channel.profile": "cia402"},
    "disturbed": DISTURBED,
    "rk4": {"manipulator.integrator": "rk4"},
    "semi-implicit Euler": {"manipulator.integrator": "semi_implicit_euler", "manipulator.substeps": 7},
    "inverse filter": {"robot.transfer_frequency_Hz": 12, "inverse_filter.enabled": "true", "sensor.noise_N": 1},
    "force interface with chirp": {"operator.interface": "force", "profile.kind": "chirp", "profile.amplitude_N": 20,
                                   "profile.duration_s": 30},
    "operator on the sensor's bus": {"operator.bus": "sensor", "profile.kind": "chirp", "profile.amplitude_m": 0.01,
                                     "profile.duration_s": 30},
    "multisine": {"profile.kind": "multisine", "profile.amplitude_m": 0.01, "profile.duration_s": 10},
    "emergency stop": {"run.emergency_stop_s": 5.0},
    "enable taken away": {"run.enable_off_s": 5.0},
    "limits act": {"limits.acceleration_m_per_s2": 0.3, "limits.velocity_m_per_s": 0.02},
    "bursts of losses": {"bus.burst_probability": 0.01, "bus.burst_length_frames": 30},
    "three frames a sample, some torn": {"sensor_channel.layout": "three_frames_motorola", "sensor.rate_Hz": 333,
                                         "bus.loss_probability": 0.02},
    "free robot clock": {"robot.clock": "free", "robot.clock_phase_ms": 0.7, "robot.clock_drift_ppm": 100},
}


@pytest.mark.long
@pytest.mark.parametrize("rig", RIGS)
@pytest.mark.parametrize("overrides", [{}, DISTURBED], ids=["as shipped", "disturbed"])
def test_every_rig_replays_bit_for_bit(rig, overrides, logs):
    result, log = logs(rig, overrides)
    replayed = replay_json(log)
    assert replayed.pop("whole_until_s") > 0
    assert replayed == {"log": str(log), "equal": True, "ticks": result["ticks"], "cut": False, "gap": False,
                        "checksums": True, "damage": None}


@pytest.mark.parametrize("variant", VARIANTS)
def test_every_part_of_the_firmware_replays_bit_for_bit(variant, logs):
    result, log = logs("ess", VARIANTS[variant])
    replayed = replay_json(log)
    assert replayed["equal"] and replayed["ticks"] == result["ticks"]


@pytest.mark.long
def test_the_variants_do_what_their_names_say(logs):
    """Else their replays would say little."""
    assert logs("ess", DISTURBED)[0]["frames_lost"] > 100 and logs("ess", DISTURBED)[0]["error_frames"] > 100
    assert logs("ess", DISTURBED)[0]["frames_rejected"] > 100  # sent again by a stale sensor
    assert logs("ess", VARIANTS["emergency stop"])[0]["stop_cause"] == "emergency_stop"
    assert logs("ess", VARIANTS["enable taken away"])[0]["stop_cause"] == "enable_off"
    assert logs("ess", VARIANTS["limits act"])[0]["limit_ticks"]["acceleration"] > 0
    assert np.ptp(topic(logs("ess", VARIANTS["force interface with chirp"])[1])["operator_force_N"]) > 35
    filtered = topic(logs("ess", VARIANTS["inverse filter"])[1])
    assert not np.array_equal(filtered["filtered_position_m"], filtered["manipulator_position_m"])
    plain = topic(logs("ess")[1])["manipulator_position_m"]
    for variant in ("rk4", "semi-implicit Euler", "free robot clock", "multisine"):
        assert not np.array_equal(plain, topic(logs("ess", VARIANTS[variant])[1])["manipulator_position_m"]), variant


# --- tampering ----------------------------------------------------------------------------------------------------
AT_TICK = 200
OUTPUT_FIELDS = ["operator_position_m", "operator_velocity_m_per_s", "operator_force_N", "force_N", "force_frame_age_ns",
                 "manipulator_position_m", "manipulator_velocity_m_per_s", "filtered_position_m",
                 "command_position_m", "robot_position_m", "energy_stored_J", "energy_operator_J",
                 "energy_dissipated_J", "energy_integrator_J", "energy_simulated_port_J", "energy_measured_port_J",
                 "energy_dead_time_J", "energy_compensation_J", "used_force_N", "displayed_position_m",
                 "predicted_error_N", "inverse_gain", "inverse_delay_s", "inverse_curve_s2", "inverse_error_m",
                 "lead_error_N", "passivity_deficit_J", "passivity_force_N", "believed_mass_kg",
                 "believed_damping_N_s_per_m", "believed_stiffness_N_per_m", "believed_dead_time_ms",
                 "rejected_frames", "old_frames", "lost_frames", "error_frames",
                 "force_samples", "torn_samples", "saturated_setpoints", "conditions", "state", "stop_cause", "limits",
                 "operator_request", "heartbeat", "drive_error", "drive_statusword", "drive_trouble",
                 "drive_setup_step", "timestamp"]


@pytest.fixture(scope="module")
def tampered(logs, tmp_path_factory):
    """A function that writes a log of 1 s with one field changed and returns its path."""
    data = without_checksums(logs("ess", {"run.duration_s": 1.0})[1].read_bytes())
    ticks = [message for message in ulog_messages(data) if data_id(message) == TICK]
    frames = [message for message in ulog_messages(data) if data_id(message) == FRAME]
    types = {"tick": record_type(data, "tick"), "can_frame": record_type(data, "can_frame")}
    folder = tmp_path_factory.mktemp("tampered")

    def frame_at(tick, direction, identifier):
        for message in frames:
            record = np.frombuffer(message.content[2:], types["can_frame"])[0]
            if (record["timestamp"], record["direction"], record["id"]) == (tick * 2500, direction, identifier):
                return message
        raise AssertionError("no such frame")

    def make(name, message, field, change):
        path = folder / "tampered.ulg"
        path.write_bytes(patched(data, message, types[name], field, change))
        return path

    make.tick = lambda field, change: make("tick", ticks[AT_TICK], field, change)
    make.frame = lambda direction, identifier, field, change: make(
        "can_frame", frame_at(AT_TICK, direction, identifier), field, change)
    make.types = types
    return make


def lowest_bit_flipped(value):
    """The next representable value, in effect: one bit differs."""
    whole = np.asarray(value).view(f"u{value.dtype.itemsize}") ^ 1
    return whole.view(value.dtype)


@pytest.mark.parametrize("field", OUTPUT_FIELDS)
def test_one_bit_of_a_recorded_output(field, tampered):
    result = replay_json(tampered.tick(field, lowest_bit_flipped), EXIT_DIFFERENT)
    assert result["equal"] is False and result["ticks"] == AT_TICK
    difference = result["first_difference"]
    assert (difference["tick"], difference["field"]) == (AT_TICK, field)
    assert float(difference["recorded"]) != float(difference["replayed"])


def test_a_person_is_told_tick_field_and_both_values(tampered):
    path = tampered.tick("command_position_m", lambda value: 1.25)
    done = command("replay", path)
    assert done.returncode == EXIT_DIFFERENT and done.stderr == b""
    assert f"differs at tick {AT_TICK} in command_position_m: recorded 1.25, replayed -0.00" in done.stdout.decode()


def test_every_field_is_an_input_or_tested_as_an_output(tampered):
    inputs = {"index", "scheduled_ns", "woke_ns", "missed_ticks", "unsent_frames", "enable", "emergency_stop", "stop"}
    assert set(tampered.types["tick"].names) == inputs | set(OUTPUT_FIELDS)


@pytest.mark.parametrize("field, expected", [("data", "data"), ("id", "id"), ("length", "length")])
def test_a_recorded_frame_to_the_robot(field, expected, tampered):
    result = replay_json(tampered.frame(1, 0x10, field, lambda value: value - 1), EXIT_DIFFERENT)
    assert result["first_difference"]["tick"] == AT_TICK
    assert result["first_difference"]["field"] == f"sent frame 0 {expected}"


@pytest.mark.parametrize("field, change, first", [
    ("enable", lambda value: 1 - value, "manipulator_position_m"),  # it is put to rest where the robot is
    ("emergency_stop", lambda value: 1 - value, "manipulator_position_m"),
    ("stop", lambda value: 1 - value, "manipulator_position_m"),
    ("scheduled_ns", lambda value: value + 1000, "timestamp"),
])
def test_a_recorded_input_of_the_tick(field, change, first, tampered):
    result = replay_json(tampered.tick(field, change), EXIT_DIFFERENT)
    assert (result["first_difference"]["tick"], result["first_difference"]["field"]) == (AT_TICK, first)


@pytest.mark.parametrize("identifier, field, change, first", [
    (0x40, "data", lambda value: value + 1, "force_N"),
    (0x40, "id", lambda value: value + 1, "force_frame_age_ns"),
    (0x40, "time_ns", lambda value: value - 1, "force_frame_age_ns"),
    (0x40, "length", lambda value: value - 1, "force_frame_age_ns"),
    (0x40, "flags", lambda value: value | 1, "force_frame_age_ns"),
    (0x20, "data", lambda value: value + 1, "robot_position_m"),
    (0x30, "data", lambda value: value + 1, "operator_position_m"),
    (0x30, "bus", lambda value: value + 1, "rejected_frames"),
])
def test_a_received_frame(identifier, field, change, first, tampered):
    result = replay_json(tampered.frame(0, identifier, field, change), EXIT_DIFFERENT)
    assert (result["first_difference"]["tick"], result["first_difference"]["field"]) == (AT_TICK, first)


def test_another_configuration_than_the_recorded_one_is_refused(logs, tmp_path):
    data = without_checksums(logs("ess", {"run.duration_s": 1.0})[1].read_bytes())
    other = data.replace(b"mass_kg = 200.0", b"mass_kg = 200.1")
    assert other != data
    (tmp_path / "other.ulg").write_bytes(other)
    done = command("replay", tmp_path / "other.ulg")
    assert done.returncode == EXIT_INPUT and b"hash" in done.stderr
