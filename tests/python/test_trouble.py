"""Trouble while a run is under way: a full disk, an interruption. The loop goes on or stops in order."""

import contextlib
import os
import pathlib
import signal
import subprocess

import pytest
from conftest import (BERTH, EXIT_DONE, EXIT_INPUT, EXIT_SIGNAL, ROOT, STATE_STOPPED, command, interrupt_when,
                      limit_file_size, one_json_object, replay_json, run_json, settings, topic, ulog_messages)

TICKS = 24000  # of a whole run of ess


# --- full disk ----------------------------------------------------------------------------------------------------
def check_incomplete(done, ticks=TICKS):
    """What is promised when the log does not fit: the object."""
    message = done.stderr.decode()
    assert done.returncode == EXIT_INPUT, (done.returncode, message)
    result = one_json_object(done.stdout)
    assert result["ticks"] == ticks and result["state"] == "running"
    assert result["growth_per_s"] == pytest.approx(-0.298369, rel=0.01)  # the loop did not suffer
    assert result["dropped_records"] > 0
    assert f"{result['dropped_records']} records dropped" in message
    return result


def check_ends_with_a_whole_record(path):
    data = path.read_bytes()
    messages = list(ulog_messages(data))
    assert messages[-1].end == len(data)
    return messages


def records_in(messages):
    """What log_file counts as records: a tick with its frames, and the simulated rig's own."""
    kinds = [int.from_bytes(message.content[:2], "little") for message in messages if message.type == "D"]
    return kinds.count(0) + kinds.count(2)


def last_tick_in(messages):
    """Index of the newest tick, which follows the timestamp in its record."""
    ticks = [message.content for message in messages if message.type == "D" and message.content[:2] == b"\0\0"]
    return int.from_bytes(ticks[-1][10:18], "little") if ticks else -1


@pytest.mark.parametrize("size_bytes", [100_000, 1_000_000, 5_000_001])
def test_log_that_may_not_grow_beyond_a_size(size_bytes, tmp_path):
    done = command("run", "ess", "--out", tmp_path, "--json", preexec_fn=limit_file_size(size_bytes))
    result = check_incomplete(done)
    assert "File too large" in done.stderr.decode()
    log = tmp_path / "ess.ulg"
    assert log.stat().st_size <= size_bytes
    messages = check_ends_with_a_whole_record(log)
    assert records_in(messages) + result["dropped_records"] == 2 * TICKS  # nothing is lost uncounted
    has_gap = last_tick_in(messages) == TICKS - 1  # a part did not fit, the last and shortest one did
    replayed = replay_json(log, EXIT_INPUT if has_gap else EXIT_DONE)
    has_end = messages[-1].content.endswith(b" last")  # that fits or it does not, as a record
    assert replayed["equal"] and replayed["cut"] is not has_end and replayed["gap"] is has_gap
    assert replayed["ticks"] > 0 or size_bytes < 200_000
    assert sorted(path.name for path in tmp_path.iterdir()) == ["ess.ulg"]  # no frames as text of half a run


def test_log_that_may_not_even_hold_its_header(tmp_path):
    done = command("run", "ess", "--out", tmp_path, "--json", preexec_fn=limit_file_size(1000))
    assert check_incomplete(done)["dropped_records"] == 2 * TICKS
    assert (tmp_path / "ess.ulg").stat().st_size == 0


def test_log_on_a_device_that_is_always_full(tmp_path):
    (tmp_path / "ess.ulg").symlink_to("/dev/full")
    done = command("run", "ess", "--out", tmp_path, "--json")
    assert check_incomplete(done)["dropped_records"] == 2 * TICKS
    assert "No space left" in done.stderr.decode()
    assert (tmp_path / "ess.ulg").is_symlink()


@contextlib.contextmanager
def small_disk(folder, size):
    """A file system of this size; skips where nobody may mount one."""
    folder.mkdir()
    done = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", folder], capture_output=True)
    if done.returncode != 0:
        pytest.skip(f"A FULL DISK WAS NOT TRIED, only limits and /dev/full: mount: {done.stderr.decode().strip()}")
    try:
        yield folder
    finally:
        subprocess.run(["umount", folder], check=True)


def test_full_disk(tmp_path):
    with small_disk(tmp_path / "disk", "1m") as disk:
        done = command("run", "ess", "--out", disk, "--json")
        check_incomplete(done)
        assert "No space left" in done.stderr.decode()
        check_ends_with_a_whole_record(disk / "ess.ulg")
        assert replay_json(disk / "ess.ulg", EXIT_INPUT)["ticks"] > 100


def test_disk_with_room_for_the_log_and_not_for_the_frames_as_text(tmp_path):
    """The result is told all the same; no half text file stays."""
    assert command("run", "ess", "--out", tmp_path).returncode == 0
    log_bytes = (tmp_path / "ess.ulg").stat().st_size
    text_bytes = sum(path.stat().st_size for path in tmp_path.glob("*.candump.log"))
    with small_disk(tmp_path / "disk", f"{log_bytes + text_bytes // 2}") as disk:
        done = command("run", "ess", "--out", disk, "--json")
        assert done.returncode == EXIT_INPUT
        result = one_json_object(done.stdout)
        assert result["dropped_records"] == 0 and result["ticks"] == TICKS
        assert b".candump" in done.stderr and done.stderr.count(b"\n") == 1
        assert replay_json(disk / "ess.ulg")["ticks"] == TICKS
        left = {path.name: path.read_bytes() for path in disk.glob("*.candump*")}
        assert all(text.endswith(b"\n") for text in left.values()) and not any("partial" in name for name in left)


def test_text_files_of_an_earlier_run_do_not_stay_beside_an_incomplete_log(tmp_path):
    run_json("ess", tmp_path, *settings({"run.duration_s": 1.0}))
    assert len(list(tmp_path.glob("*.candump.log"))) == 2
    check_incomplete(command("run", "ess", "--out", tmp_path, "--json", preexec_fn=limit_file_size(1_000_000)))
    assert list(tmp_path.glob("*.candump.log")) == []


def test_a_person_is_told_of_dropped_records(tmp_path):
    done = command("run", "ess", "--out", tmp_path, preexec_fn=limit_file_size(1_000_000))
    assert done.returncode == EXIT_INPUT and b"records dropped" in done.stderr and b"peak force" in done.stdout


def test_the_loop_program_on_a_full_disk(tmp_path):
    (tmp_path / "ess.ulg").symlink_to("/dev/full")
    done = command("ess", tmp_path / "ess.ulg", program=(ROOT / "build" / "berth-loop",))
    assert done.returncode == EXIT_INPUT and b"records dropped" in done.stderr and b"24000 ticks" in done.stdout


# --- interruption -------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("rig", ["ess", "ess-50hz", "concept-foam"])
def test_interrupted_run_closes_its_log(rig, number, tmp_path):
    process = subprocess.Popen([BERTH, "run", rig, "--json", "--out", tmp_path, "--set", "run.duration_s=100000"],
                               cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    log = tmp_path / f"{rig}.ulg"
    stdout, stderr, exit_code = interrupt_when(
        process, lambda: log.exists() and log.stat().st_size > 1_000_000, number)
    assert exit_code == EXIT_SIGNAL + number, stderr
    assert stderr.startswith(b"berth: interrupted") and stderr.count(b"\n") == 1
    result = one_json_object(stdout)
    assert result["state"] == "stopped" and result["stop_cause"] == "requested" and result["dropped_records"] == 0
    check_ends_with_a_whole_record(log)
    replayed = replay_json(log)
    assert replayed["equal"] and replayed["ticks"] == result["ticks"] and not replayed["cut"]

    tick = topic(log)
    assert tick["state"][-1] == STATE_STOPPED
    assert tick["stop"][-1] == 1 and not tick["stop"][0]
    period_s = (tick["scheduled_ns"][1] - tick["scheduled_ns"][0]) * 1e-9
    # The stopping tick itself sends no setpoint any more.
    speed_m_per_s = abs(tick["command_position_m"][-2] - tick["command_position_m"][-3]) / period_s
    assert speed_m_per_s < 1e-3, "stopped while the robot was still moving"
    assert {path.suffix for path in tmp_path.iterdir()} == {".ulg", ".log"}


def test_interruption_before_the_release_stops_as_well(tmp_path):
    process = subprocess.Popen([BERTH, "run", "ess", "--json", "--out", tmp_path, "--set", "run.duration_s=100000",
                                "--set", "run.release_s=90000"], cwd=ROOT, stdout=subprocess.PIPE,
                               stderr=subprocess.PIPE)
    log = tmp_path / "ess.ulg"
    stdout, _, exit_code = interrupt_when(process, lambda: log.exists() and log.stat().st_size > 1_000_000)
    assert exit_code == EXIT_SIGNAL + signal.SIGINT and one_json_object(stdout)["state"] == "stopped"
    assert replay_json(log)["equal"]


def test_interruption_without_a_log(tmp_path):
    """Nothing shows how far it is; it needs no more than the signal handler to be there."""
    process = subprocess.Popen([BERTH, "run", "ess", "--json", "--no-log", "--set", "run.duration_s=1000000"],
                               cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    status = pathlib.Path(f"/proc/{process.pid}/status")

    def catches_interrupts():
        mask = next(line for line in status.read_text().splitlines() if line.startswith("SigCgt"))
        return int(mask.split()[1], 16) >> (signal.SIGINT - 1) & 1

    stdout, stderr, exit_code = interrupt_when(process, catches_interrupts)
    assert exit_code == EXIT_SIGNAL + signal.SIGINT and one_json_object(stdout)["state"] == "stopped"
    assert stderr.startswith(b"berth: interrupted")


def test_a_killed_run_leaves_whole_ticks(tmp_path):
    """No chance to close: what had reached the file replays up to the last whole tick."""
    process = subprocess.Popen([BERTH, "run", "ess", "--out", tmp_path, "--set", "run.duration_s=100000"], cwd=ROOT,
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    log = tmp_path / "ess.ulg"
    far_enough = lambda: log.exists() and log.stat().st_size > 1_000_000  # noqa: E731
    _, _, exit_code = interrupt_when(process, far_enough, signal.SIGKILL)
    assert exit_code == -signal.SIGKILL
    replayed = replay_json(log)
    assert replayed["equal"] and replayed["ticks"] > 1000


def test_reader_of_the_result_that_went_away(tmp_path):
    """`berth run --json | head -c 0`: no crash report, and the log is whole."""
    read_end, write_end = os.pipe()
    os.close(read_end)
    with os.fdopen(write_end, "wb") as closed:
        subprocess.run([BERTH, "run", "ess", "--json", "--out", tmp_path], cwd=ROOT, stdout=closed,
                       stderr=subprocess.PIPE, timeout=60)
    assert replay_json(tmp_path / "ess.ulg", EXIT_DONE)["ticks"] == TICKS


# --- what must not run for ever -----------------------------------------------------------------------------------
def test_a_bus_that_destroys_every_frame_is_refused():
    done = command("run", "ess", "--no-log", "--set", "bus.error_probability=1")
    assert done.returncode == EXIT_INPUT and b"bus.error_probability" in done.stderr


def test_dead_time_of_a_robot_that_never_reports():
    done = command("deadtime", "ess", "--set", "bus.loss_probability=1")
    assert done.returncode == 3 and b"feedback does not come" in done.stderr
