"""Logs as others read them: pyulog, cantools, can-utils."""

import json
import re
import shutil
import subprocess

import can
import cantools
import numpy as np
import pytest
from conftest import DBC, DISTURBED, EXIT_DONE, RIGS, ROOT, STATE_RUNNING, command, run_json, topic
from pyulog import ULog

CANTOOLS = ROOT / ".venv" / "bin" / "cantools"
UNITS = ("_ns", "_ms", "_s", "_s2", "_m", "_m_per_s", "_N", "_J", "_kg", "_rad", "_N_m", "_N_m_s", "_N_s_per_m",
         "_N_per_m")
DIMENSIONLESS = {
    "index", "missed_ticks", "rejected_frames", "old_frames", "lost_frames", "error_frames", "unsent_frames",
    "saturated_setpoints", "conditions", "force_samples", "torn_samples",
    "enable", "emergency_stop", "stop", "state", "stop_cause", "limits", "operator_request", "heartbeat",
    "drive_error", "drive_statusword", "drive_trouble", "drive_setup_step",
    "inverse_gain", "base_quaternion_w", "base_quaternion_x", "base_quaternion_y", "base_quaternion_z", "guided_by",
    "motors_at_limit", "order",
    "data", "id", "bus", "length", "flags", "direction",
}
SHORT = {"run.duration_s": 3.0}


# --- ULog ---------------------------------------------------------------------------------------------------------
@pytest.mark.long
@pytest.mark.parametrize("rig", RIGS)
def test_pyulog_reads_every_record(rig, logs):
    result, log = logs(rig)
    ulog = ULog(str(log))
    assert not ulog.file_corruption and not ulog.dropouts
    arm = {"concept-arm-copper": {"arm"}, "concept-arm-foam": {"arm"},
           "ess-berthing": {"arm"}, "ess-berthing-pose": {"arm", "side"}, "ess-pose": {"arm", "side"}}.get(rig, set())
    assert {data.name for data in ulog.data_list} == {"tick", "can_frame", "rig"} | arm
    assert all(len(topic(log, name)["timestamp"]) == result["ticks"] for name in arm)
    tick = topic(log)
    assert list(tick["index"]) == list(range(result["ticks"]))
    assert len(topic(log, "rig")["timestamp"]) == result["ticks"]
    assert np.array_equal(tick["timestamp"], tick["scheduled_ns"] // 1000)


@pytest.mark.parametrize("rig", ["ess", "ess-berthing", "ess-pose"])
def test_every_field_name_ends_in_its_unit(rig, logs):
    """`timestamp` is the format's own, in us."""
    for data in ULog(str(logs(rig)[1])).data_list:
        for field in data.data:
            assert field == "timestamp" or field in DIMENSIONLESS or field.endswith(UNITS), f"{data.name}.{field}"


INPUTS = {"index", "unsent_frames", "scheduled_ns", "woke_ns", "missed_ticks", "stop", "enable", "emergency_stop"}
OUTPUTS = {"operator_position_m", "operator_velocity_m_per_s", "operator_force_N", "force_N", "force_frame_age_ns",
           "manipulator_position_m", "manipulator_velocity_m_per_s", "filtered_position_m", "command_position_m",
           "robot_position_m", "state", "stop_cause", "limits", "heartbeat"}


def test_all_inputs_and_outputs_are_there(logs):
    _, log = logs("ess")
    assert INPUTS | OUTPUTS <= topic(log).keys()
    frame = topic(log, "can_frame")
    assert {"time_ns", "id", "bus", "length", "flags", "data", "direction"} <= frame.keys()
    sent, received = frame["direction"] == 1, frame["direction"] == 0
    assert set(frame["id"][sent]) == {0x10, 0x11} and set(frame["id"][received]) == {0x20, 0x30, 0x40}


def fnv1a_64(data):
    """FNV-1a from its definition."""
    value = 0xCBF29CE484222325
    for byte in data:
        value = (value ^ byte) * 0x100000001B3 % 2**64
    return f"{value:016x}"


def test_commit_configuration_and_hash_are_in_the_log_and_consistent(logs, tmp_path):
    result, log = logs("ess", {"robot.dead_time_ms": 13.3, **SHORT})
    info = ULog(str(log)).msg_info_dict
    version = command("--version").stdout.decode().strip()
    assert version == f"berth 1.0.0-rc.1 ({info['ver_sw']})" and result["version"] == info["ver_sw"]
    assert re.fullmatch(r"[0-9a-f]{12}(-dirty)?", info["ver_sw"])
    assert info["berth_config_hash"] == result["config_hash"] == fnv1a_64(info["berth_config"].encode())
    assert re.search(r"^dead_time_ms = 13.3 ", info["berth_config"], re.MULTILINE)

    assumed = json.dumps(info["berth_assumed"].split(","))
    (tmp_path / "from-log.toml").write_text(f"assumed = {assumed}\n{info['berth_config']}")
    again = run_json(tmp_path / "from-log.toml", tmp_path)
    assert again["config_hash"] == result["config_hash"]
    assert open(again["log"], "rb").read() == log.read_bytes()


# --- candump ------------------------------------------------------------------------------------------------------
LINE = re.compile(r"\((\d{10})\.(\d{6})\) (can[01]) ([0-9A-F]{3}|[0-9A-F]{8})#((?:[0-9A-F]{2}){0,8})")
BUSES = {"robot": "can0", "sensor": "can1"}


def candump(log, bus):
    """The lines of one bus: (time in us, interface, identifier, data, text)."""
    text = log.with_suffix(f".{bus}.candump.log").read_text()
    assert text.endswith("\n")
    lines = []
    for line in text.splitlines():
        match = LINE.fullmatch(line)
        assert match, line
        seconds, micros, interface, identifier, data = match.groups()
        lines.append((int(seconds) * 10**6 + int(micros), interface, int(identifier, 16), bytes.fromhex(data), line))
    return lines


@pytest.mark.parametrize("overrides", [SHORT, {**SHORT, **DISTURBED}], ids=["ideal", "disturbed"])
def test_candump_has_exactly_the_frames_of_the_log(overrides, logs):
    _, log = logs("ess", overrides)
    frame = topic(log, "can_frame")
    for number, (bus, interface) in enumerate(BUSES.items()):
        lines = candump(log, bus)
        assert {line[1] for line in lines} == {interface}
        times = [line[0] for line in lines]
        assert times == sorted(times)
        on_bus = [(int(time_ns) // 1000, 0x20000000 if flags & 1 else int(identifier),
                   int(data).to_bytes(8, "little")[:length])
                  for time_ns, identifier, data, length, flags, at in zip(
                      *(frame[name] for name in ("time_ns", "id", "data", "length", "flags", "bus")))
                  if at == number]
        assert sorted((line[0], line[2], line[3]) for line in lines) == sorted(on_bus)
    assert any(line[2] == 0x20000000 for line in candump(log, "robot")) == ("bus.error_probability" in overrides)


def cantools_decode(text):
    """The lines of `cantools decode` on standard input: (message, {signal: value})."""
    done = subprocess.run([CANTOOLS, "decode", "--single-line", DBC], input=text.encode(),
                          capture_output=True, timeout=120)
    assert done.returncode == 0, done.stderr.decode()
    decoded = []
    for line in done.stdout.decode().splitlines():
        assert "Unknown frame" not in line and "rror" not in line, line
        name, signals = re.fullmatch(r".* :: (\w+)\((.*)\)", line).groups()
        decoded.append((name, dict(re.findall(r"(\w+): ('?[-+\w.]+'?)", signals))))
    return decoded


@pytest.mark.long
def test_cantools_decodes_every_line_to_the_values_in_the_log(logs):
    """Text to value by cantools; frame to value by our generated codec, as recorded in each tick."""
    _, log = logs("ess", SHORT)
    tick = topic(log)
    received = {"force": {}, "robot_feedback": {}, "operator_motion": {}, "setpoint": {}, "loop_status": {}}
    for bus in BUSES:
        lines = candump(log, bus)
        decoded = cantools_decode("\n".join(line[4] for line in lines) + "\n")
        assert len(decoded) == len(lines)
        for (time_us, *_), (name, signals) in zip(lines, decoded):
            received[name][time_us] = signals

    def column(message, signal):
        """Value at each tick: sent at the tick, or the newest that arrived by it."""
        times = np.array(sorted(received[message]))
        values = np.array([float(received[message][time][signal]) for time in times])
        at = np.searchsorted(times, tick["timestamp"], side="right") - 1
        return np.where(at >= 0, values[np.clip(at, 0, None)], 0.0)

    assert np.array_equal(column("force", "force_N"), tick["force_N"])
    assert np.array_equal(column("robot_feedback", "position_m"), tick["robot_position_m"])
    assert np.array_equal(column("operator_motion", "position_m"), tick["operator_position_m"])
    assert np.array_equal(column("operator_motion", "velocity_m_per_s"), tick["operator_velocity_m_per_s"])
    assert np.array_equal(column("setpoint", "position_m")[1:], tick["command_position_m"][1:])
    assert np.array_equal(column("setpoint", "motion_allowed") == 1, tick["state"] == STATE_RUNNING)
    states = {signals["state"] for signals in received["loop_status"].values()}
    assert states == {"start", "ready", "running"}


def test_the_dbc_gives_the_recorded_force_from_the_recorded_bytes(logs):
    """The same without text: ULog frame, cantools' decoder, ULog tick."""
    _, log = logs("ess", {**SHORT, "sensor.noise_N": 5})
    tick, frame = topic(log), topic(log, "can_frame")
    message = cantools.database.load_file(DBC).get_message_by_name("force")
    at_tick = {int(t): message.decode(int(d).to_bytes(8, "little"))["force_N"]
               for t, d, i in zip(frame["timestamp"], frame["data"], frame["id"]) if i == message.frame_id}
    assert len(at_tick) >= len(tick["index"]) - 1
    assert all(tick["force_N"][int(t) // 2500] == force for t, force in at_tick.items())


@pytest.mark.long
def test_lines_of_a_disturbed_run_decode_but_for_error_frames(logs):
    _, log = logs("ess", {**SHORT, **DISTURBED})
    for bus in BUSES:
        text = "".join(line[4] + "\n" for line in candump(log, bus) if not line[2] & 0x20000000)
        assert len(cantools_decode(text)) == text.count("\n")


@pytest.mark.skipif(shutil.which("log2asc") is None, reason="can-utils is not installed: log2asc was not tried")
@pytest.mark.parametrize("overrides", [SHORT, {**SHORT, **DISTURBED}], ids=["ideal", "disturbed"])
def test_can_utils_read_every_line(overrides, logs, tmp_path):
    _, log = logs("ess", overrides)
    for bus, interface in BUSES.items():
        source, target = log.with_suffix(f".{bus}.candump.log"), tmp_path / f"{bus}.asc"
        done = subprocess.run(["log2asc", "-I", source, "-O", target, interface], capture_output=True, timeout=60)
        assert done.returncode == 0 and done.stderr == b""
        frames = [line for line in target.read_text().splitlines() if re.match(r"\s*\d+\.\d+ +1 +", line)]
        assert len(frames) == len(candump(log, bus))


@pytest.mark.parametrize("overrides", [SHORT, {**SHORT, **DISTURBED}], ids=["ideal", "disturbed"])
def test_python_can_reads_the_files_by_their_ending_and_writes_blf_from_them(overrides, logs, tmp_path):
    _, log = logs("ess", overrides)
    for bus in BUSES:
        blf = tmp_path / f"{bus}.blf"
        with can.LogReader(log.with_suffix(f".{bus}.candump.log")) as frames, can.Logger(blf) as writer:
            for frame in frames:
                if not frame.is_extended_id:  # those that are are error frames, which python-can takes for data
                    writer(frame)
        with can.LogReader(blf) as frames:
            read = [(round(frame.timestamp * 1e6), frame.arbitration_id, bytes(frame.data)) for frame in frames]
        wanted = [(line[0], line[2], line[3]) for line in candump(log, bus) if not line[2] & 0x20000000]
        assert [frame[1:] for frame in read] == [frame[1:] for frame in wanted] and len(wanted) > 500
        off_us = [abs(a[0] - read[0][0] - (b[0] - wanted[0][0])) for a, b in zip(read, wanted)]
        assert max(off_us) <= 1


def test_candump_of_a_log_gives_the_same_files_again(logs, tmp_path):
    _, log = logs("ess", SHORT)
    copy = shutil.copy(log, tmp_path / "a.b.ulg")
    assert command("candump", copy).returncode == EXIT_DONE
    for bus in BUSES:
        assert (tmp_path / f"a.b.{bus}.candump.log").read_bytes() == log.with_suffix(f".{bus}.candump.log").read_bytes()


def test_candump_lines_sent_to_the_robot_are_what_it_was_told(logs):
    """Setpoint frames alone tell the whole commanded motion."""
    _, log = logs("ess", SHORT)
    message = cantools.database.load_file(DBC).get_message_by_name("setpoint")
    sent = [message.decode(line[3])["position_m"] for line in candump(log, "robot") if line[2] == message.frame_id]
    tick = topic(log)
    assert sent == list(tick["command_position_m"][tick["state"] > 0])
