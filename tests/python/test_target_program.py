"""berth-target as any machine can run it: without buses, and without the rights that a board gives it."""

import json
import os
import random
import resource
import shutil
import signal
import socket
import subprocess
import sys
import time

import pytest
from conftest import BERTH, EXIT_DONE, EXIT_INPUT, ROOT, TIMEOUT_s, command, settings
from pyulog import ULog

TARGET = ROOT / "build" / "berth-target"
EXIT_HARDWARE = 3
NOBODY = 65534


def target(*arguments, **options):
    return command(*arguments, program=(TARGET,), **options)


def without_rights():
    """As a user who may neither schedule nor lock."""
    resource.setrlimit(resource.RLIMIT_RTPRIO, (0, 0))
    resource.setrlimit(resource.RLIMIT_MEMLOCK, (65536, 65536))
    if os.geteuid() == 0:
        os.setuid(NOBODY)


@pytest.fixture
def open_folder(tmp_path_factory):
    """One that nobody may write to."""
    folder = tmp_path_factory.mktemp("target")
    folder.chmod(0o777)
    for parent in list(folder.parents)[:3]:
        if parent.stat().st_uid == os.geteuid() and parent.name.startswith(("pytest", "popen")):  # xdist's workers
            parent.chmod(0o755)
    return folder


def test_without_can_it_says_so():
    try:
        socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW).close()
        expected = b"no such CAN interface"
    except OSError:
        expected = b"this kernel has no SocketCAN"
    done = target("ess", *settings({"target.robot_interface": "can-none"}))
    assert done.returncode == EXIT_HARDWARE
    assert expected in done.stderr
    assert done.stderr.count(b"\n") == 1


@pytest.mark.parametrize("arguments", [(), ("no-such-rig",), ("ess", "--no-such-option"),
                                       ("ess", "--set", "target.priority=99"),
                                       ("ess", "--set", "target.robot_interface="),
                                       ("ess", "/proc/none/log.ulg", "--without-buses"),
                                       ("ess", "--without-buses", "--jitter", "/proc/none/jitter.json")])
def test_usage_and_input(arguments):
    """Before the first tick: a run that is over has nothing to say."""
    done = target(*arguments)
    assert done.returncode == EXIT_INPUT
    assert done.stderr.count(b"\n") == 1
    assert done.stdout == b""


@pytest.mark.long
def test_timing_without_buses(tmp_path):
    """Its file is one that the stability tools read."""
    done = target("ess", tmp_path / "log.ulg", "--without-buses", "--jitter", tmp_path / "jitter.json",
                  *settings({"run.duration_s": 1}))
    assert done.returncode == EXIT_DONE, done.stderr
    log = ULog(str(tmp_path / "log.ulg"))
    ticks = log.get_dataset("tick").data
    assert ticks["index"][-1] == len(ticks["index"]) - 1 + ticks["missed_ticks"].sum()
    assert ticks["scheduled_ns"][-1] >= 1_000_000_000
    for key in ("berth_kernel", "berth_kernel_realtime", "berth_isolated_cpus", "berth_governor", "berth_scheduling",
                "berth_config_hash", "ver_sw"):
        assert log.msg_info_dict[key], key
    assert command("replay", tmp_path / "log.ulg").returncode == EXIT_DONE
    used = command("eigen", "ess", "--jitter", tmp_path / "jitter.json", program=(BERTH,))
    assert b"the loop wakes late by" in used.stdout or b"would be missed" in used.stderr


@pytest.mark.long
def test_the_table_of_the_timing_has_all_that_labs_ask_for(tmp_path):
    target("ess", "--without-buses", "--jitter", tmp_path / "jitter.json", *settings({"run.duration_s": 1}))
    told = json.loads((tmp_path / "jitter.json").read_text())
    assert {"file_version", "cmdline", "return_code", "sysinfo", "num_threads", "resolution_in_ns", "thread"} <= told.keys()
    assert {"histogram", "cycles", "min", "max", "avg", "cpu"} <= told["thread"]["0"].keys()
    for name in ("wake_up", "execution", "tick_to_wire", "force_age"):
        shares = {"min_us", "avg_us", "p50_us", "p99_us", "p99_9_us", "p99_99_us", "max_us", "histogram"}
        assert shares <= told["berth"][name].keys()
    done = subprocess.run([sys.executable, ROOT / "scripts" / "jitter_plot.py", tmp_path / "jitter.json"],
                          capture_output=True, text=True, timeout=TIMEOUT_s, check=True)
    head, wake_up, *_ = done.stdout.splitlines()
    assert head.split() == ["us", "count", "min", "avg", "p50", "p99", "p99.9", "p99.99", "max"]
    assert wake_up.split()[:2] == ["wake-up", str(told["thread"]["0"]["cycles"])]
    assert f"overruns: {told['berth']['overruns']} in" in done.stdout
    assert "not measured: tick to wire, force age" in done.stdout
    assert (tmp_path / "jitter.png").stat().st_size > 10_000


def test_times_beyond_the_histogram_are_in_the_table(tmp_path):
    (tmp_path / "plain.json").write_text('{"thread": {"0": {"histogram": {"3": 98}, "cycles": 100, "min": 3, "max": 70, '
                                         '"avg": 4.3}}}')
    done = subprocess.run([sys.executable, ROOT / "scripts" / "jitter_plot.py", tmp_path / "plain.json"],
                          capture_output=True, text=True, timeout=TIMEOUT_s, check=True)
    assert done.stdout.splitlines()[1].split() == ["plain", "100", "3.0", "4.3", "4", "70", "70", "70", "70.0"]


def test_a_file_without_a_histogram_is_refused(tmp_path):
    (tmp_path / "plain.json").write_text('{"thread": {"0": {"histogram": {}, "min": 1, "max": 2, "avg": 1.5}}}')
    done = subprocess.run([sys.executable, ROOT / "scripts" / "jitter_plot.py", tmp_path / "plain.json"],
                          capture_output=True, text=True, timeout=TIMEOUT_s, check=False)
    assert done.returncode == EXIT_INPUT
    assert "--histogram" in done.stderr and done.stderr.count("\n") == 1


def test_a_rig_without_an_end_is_refused():
    done = target("/dev/zero", "--check")
    assert done.returncode == EXIT_INPUT and b"/dev/zero: is larger than 64 MB" in done.stderr


@pytest.mark.skipif(not shutil.which("systemd-analyze"), reason="no systemd-analyze to judge the service")
def test_systemd_understands_the_service(tmp_path):
    """All but the program, which this machine does not have where a board does."""
    unit = (ROOT / "scripts" / "image" / "berth.service").read_text()
    (tmp_path / "berth.service").write_text(unit.replace("/usr/bin/berth-target", str(TARGET)))
    done = subprocess.run(["systemd-analyze", "verify", tmp_path / "berth.service"], capture_output=True, text=True,
                          timeout=TIMEOUT_s, check=False)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.skipif(not shutil.which("systemd-analyze"), reason="no systemd-analyze to judge the service")
def test_the_service_can_do_little_that_the_loop_does_not_need():
    """2 of 10, by systemd's own scale."""
    done = subprocess.run(["systemd-analyze", "security", "--offline=true", "--threshold=20", "--no-pager",
                           ROOT / "scripts/image/berth.service"], capture_output=True, text=True, timeout=TIMEOUT_s, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "Overall exposure level for berth.service" in done.stdout


@pytest.mark.long
def test_sigterm_is_an_orderly_stop(tmp_path):
    process = subprocess.Popen([TARGET, "ess", tmp_path / "log.ulg", "--without-buses", "--until-stopped"],
                               stdout=subprocess.PIPE, text=True)
    time.sleep(1)
    process.send_signal(signal.SIGTERM)
    printed, _ = process.communicate(timeout=TIMEOUT_s)
    assert process.returncode == EXIT_DONE
    assert "stopped because: requested" in printed
    ticks = ULog(str(tmp_path / "log.ulg")).get_dataset("tick").data
    assert ticks["stop"][-1] == 1
    assert not ticks["stop"][: len(ticks["stop"]) - 3].any()


def of_log(subcommand, log, exit_code=EXIT_DONE):
    done = command(subcommand, log, "--json")
    assert done.returncode == exit_code, done.stdout + done.stderr
    return json.loads(done.stdout)


@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.long)])
def test_a_killed_loop_leaves_a_log_that_is_whole_up_to_2_s_before(seed, tmp_path):
    """A kill loses what the program has not handed over; what a power cut loses beside that, fdatasync bounds."""
    log = tmp_path / "log.ulg"
    process = subprocess.Popen([TARGET, "ess", log, "--without-buses", "--until-stopped"], stdout=subprocess.DEVNULL)
    deadline_s = time.monotonic() + TIMEOUT_s
    while not log.exists() or b"D\0\0" not in log.read_bytes():  # the first tick
        assert process.poll() is None and time.monotonic() < deadline_s
        time.sleep(0.01)
    began_s = time.monotonic()
    time.sleep(random.Random(seed).uniform(1.5, 3.5))
    ran_s = time.monotonic() - began_s
    process.kill()
    process.wait()
    told = of_log("summary", log)
    assert told["cut"] and told["checksums"] and told["damage"] is None
    assert told["whole_until_s"] > ran_s - 2
    assert of_log("replay", log)["equal"]


def test_the_log_goes_on_in_further_files_and_the_oldest_go(tmp_path):
    log = tmp_path / "run.ulg"
    log.write_bytes(b"of an earlier run")
    done = target("ess", log, "--without-buses", "--rotate-MB", "0.05", "--keep-MB", "0.3",
                  *settings({"run.duration_s": 4}))
    assert done.returncode == EXIT_DONE and b"0 not recorded" in done.stdout, done.stderr
    parts = sorted(tmp_path.glob("run.*.ulg"), key=lambda path: int(path.name.split(".")[1])) + [log]
    assert not (tmp_path / "run.1.ulg").exists()
    assert 3 <= len(parts) <= 6 and sum(path.stat().st_size for path in parts) <= 0.3e6
    ends = []
    for part in parts:
        assert part.stat().st_mode & 0o777 & ~0o640 == 0
        told = of_log("summary", part)
        assert told["checksums"] and not told["cut"] and told["damage"] is None and told["missing_ticks"] == 0
        ticks = ULog(str(part)).get_dataset("tick").data
        ends.append((ticks["index"][0] - ticks["missed_ticks"][0], ticks["index"][-1] + 1))
        refused = command("replay", part)
        assert refused.returncode == EXIT_INPUT and b"of a run: the state in which it begins" in refused.stderr
    assert all(before[1] == after[0] for before, after in zip(ends, ends[1:]))


def test_the_first_of_several_files_replays(tmp_path):
    done = target("ess", tmp_path / "run.ulg", "--without-buses", "--rotate-MB", "0.05",
                  *settings({"run.duration_s": 2}))
    assert done.returncode == EXIT_DONE, done.stderr
    first = tmp_path / "run.1.ulg"
    replayed = of_log("replay", first)
    assert replayed["equal"] and replayed["ticks"] == len(ULog(str(first)).get_dataset("tick").data["index"]) > 0


@pytest.mark.parametrize("options", [("--rotate-MB", "0"), ("--rotate-h", "-1"), ("--keep-MB", "100"),
                                     ("--rotate-MB", "100", "--keep-MB", "150")])
def test_a_rotation_that_cannot_be_is_refused(options, tmp_path):
    done = target("ess", tmp_path / "run.ulg", "--without-buses", *options)
    assert done.returncode == EXIT_INPUT and done.stderr.count(b"\n") == 1 and options[-2].encode() in done.stderr


@pytest.mark.parametrize("option, stamp", [((), "refused"), (("--without-realtime",), "allowed by option")])
def test_without_realtime_motion_is_refused_unless_told(open_folder, option, stamp):
    log_path = open_folder / "log.ulg"
    program = shutil.copy(TARGET, open_folder)  # the clone may lie where that user cannot go
    done = command("ess", log_path, "--without-buses", *option, *settings({"run.duration_s": 0.2}),
                   program=(program,), preexec_fn=without_rights)
    assert done.returncode == EXIT_DONE, done.stderr
    assert (b"motion stays disabled" in done.stderr) == (not option)
    log = ULog(str(log_path))
    assert log.msg_info_dict["berth_without_realtime"] == stamp
    assert log.msg_info_dict["berth_scheduling"].startswith("not real-time")
    assert (log.get_dataset("tick").data["enable"] == (2 if option else 0)).all()


def test_the_preflight_names_what_is_missing_and_what_to_do():
    done = target("ess", "--check", *settings({"target.fault_line": "NO_SUCH_LINE", "target.tick_line": ""}))
    printed = done.stdout.decode()
    assert done.returncode == EXIT_HARDWARE
    assert "no line is called NO_SUCH_LINE" in printed
    assert printed.endswith("not fit to move the robot: see MISSING above\n")
    assert all("->" in after for line, after in zip(printed.splitlines(), printed.splitlines()[1:])
               if line.startswith(("MISSING", "WARNING")))
    for subject in ("kernel", "throttling", "isolation", "governor", "limits", "scheduling", "GPIO"):
        assert subject in printed
