"""What the tests of the programs share. They see the programs from outside only: command line, files, exit codes.

Run from the repository root: .venv/bin/python -m pytest -q tests/python
"""

import collections
import csv
import json
import os
import pathlib
import signal
import subprocess
import sys
from dataclasses import dataclass

import numpy as np
import pytest
from pyulog import ULog

pytest.register_assert_rewrite("checks", "table", "refusals")  # of diagnosis/ and bad_input/: they assert for the rows

ROOT = pathlib.Path(__file__).resolve().parents[2]
BERTH = ROOT / "build" / "berth"
ARM64_BUILD = ROOT / "build" / "aarch64-linux-gnu"
DBC = ROOT / "firmware" / "can" / "berth.dbc"
RIG_FOLDER = ROOT / "sim_hal" / "rigs"
RIGS = sorted(path.stem for path in RIG_FOLDER.glob("*.toml"))
TIMEOUT_s = 600
SHORT = {"run.duration_s": 2.0}

EXIT_DONE, EXIT_DIFFERENT, EXIT_INPUT, EXIT_SIGNAL = 0, 1, 2, 128

# Numbers of supervisor states in the log (VAL_ 17 state in berth.dbc).
STATE_RUNNING, STATE_STOPPED = 2, 5

# Everything that can go wrong on the way, at once.
DISTURBED = {
    "sensor.noise_N": 5,
    "sensor.bias_N": 0.5,
    "sensor.loss_probability": 0.02,
    "sensor.stale_probability": 0.02,
    "bus.loss_probability": 0.02,
    "bus.burst_probability": 0.002,
    "bus.burst_length_frames": 3,
    "bus.error_probability": 0.01,
    "robot.jitter_ms": 0.3,
}


def pytest_sessionstart(session):
    """Once, before pytest-xdist's workers start: records of the tables that no run has used for a day go."""
    if not hasattr(session.config, "workerinput"):
        sys.path.insert(0, str(ROOT / "tests" / "python" / "diagnosis"))
        import record_store

        record_store.remove_unused()


def in_full_tier():
    """Rows of full_tier.csv: `moved`, how the names of tests begin that `make full-test` alone runs; `cpu_s`, processor
    time of each; `stays`, how the name of one begins that `make test` has of the same kind."""
    with open(ROOT / "tests" / "python" / "full_tier.csv", newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def pytest_collection_modifyitems(items):
    """Puts every test that needs the programs built for arm64 behind its mark. Among the slow ones: what full_tier.csv
    names, and what comes after the first sets of parameters of those that are many."""
    seen = collections.Counter()
    moved = tuple(row["moved"] for row in in_full_tier())
    for item in items:
        if "arm64" in item.fixturenames:
            item.add_marker(pytest.mark.arm64)
        if item.nodeid.rpartition("python/")[2].startswith(moved):
            item.add_marker(pytest.mark.slow)
        first = item.get_closest_marker("first")
        if first is not None and item.get_closest_marker("slow") is None:
            function = item.nodeid.partition("[")[0]
            seen[function] += 1
            if seen[function] > first.args[0]:
                item.add_marker(pytest.mark.slow)


def settings(values):
    """`--set` arguments for a mapping of keys to values."""
    return [word for key, value in values.items() for word in ("--set", f"{key}={value}")]


def command(*arguments, program=(BERTH,), **options):
    """Runs a program of ours to its end; never raises on its exit code."""
    words = [str(word) for word in (*program, *arguments)]
    return subprocess.run(words, cwd=ROOT, capture_output=True, timeout=TIMEOUT_s, **options)


def berth(folder, *arguments, **options):
    """The program in a folder of its own, where it keeps its runs."""
    return subprocess.run([str(word) for word in (BERTH, *arguments)], cwd=folder, capture_output=True, text=True,
                          timeout=TIMEOUT_s, **options)


def play(reference, gap):
    """What comes behind a gap of full width `gap`."""
    follower = np.empty_like(reference)
    at = reference[0]
    for n, now in enumerate(reference):
        at = min(max(at, now - 0.5 * gap), now + 0.5 * gap)
        follower[n] = at
    return follower


def one_json_object(stdout):
    """The object on standard output, which must hold it and nothing else."""
    text = stdout.decode()
    value, end = json.JSONDecoder().raw_decode(text)
    assert isinstance(value, dict)
    assert text[end:] == "\n"
    return value


def run_json(rig, folder, *arguments, exit_code=EXIT_DONE, program=(BERTH,), advised=False, **options):
    """`berth run RIG --json` with its log in `folder`: the object; `advised`: with margin, advice and accuracy, which
    may take seconds."""
    shorter = () if advised else ("--no-advice",)
    done = command("run", rig, "--out", folder, "--json", *shorter, *arguments, program=program, **options)
    assert done.returncode == exit_code, done.stderr.decode()
    return one_json_object(done.stdout)


def replay_json(log, exit_code=EXIT_DONE, program=(BERTH,)):
    """`berth replay LOG --json`: the object."""
    done = command("replay", log, "--json", program=program)
    assert done.returncode == exit_code, done.stdout.decode() + done.stderr.decode()
    return one_json_object(done.stdout)


def topic(log, name="tick"):
    """The columns of one topic of a log: {field: array}."""
    return ULog(str(log)).get_dataset(name).data


@dataclass
class Message:
    """One ULog message: where it starts in the file, its type, and its content."""

    at: int
    type: str
    content: bytes

    @property
    def end(self):
        """The first byte after it."""
        return self.at + 3 + len(self.content)


def ulog_messages(data):
    """The whole messages of a ULog file's bytes, by the file format's definition and not by any reader's."""
    at = 16
    while at + 3 <= len(data):
        size = int.from_bytes(data[at : at + 2], "little")
        if at + 3 + size > len(data):
            return
        yield Message(at, chr(data[at + 2]), data[at + 3 : at + 3 + size])
        at += 3 + size


def data_id(message):
    """Which topic a data message belongs to; None for other messages."""
    return int.from_bytes(message.content[:2], "little") if message.type == "D" else None


BLOCK_KEY = b"\x14char[38] berth_block"  # of the messages that end blocks: hal/log_blocks.h


GARBAGE = ("zeros", "ones", "noise", "shifted", "doubled")


def with_garbage(kind, data, at, size, random_source):
    """The bytes of a log with `size` of them from `at` on spoilt in one of the ways of GARBAGE."""
    stuff = {"zeros": bytes(size), "ones": b"\xff" * size, "noise": random_source.randbytes(size), "shifted": b"",
             "doubled": data[at : at + size] * 2}[kind]
    return data[:at] + stuff + data[at + size :]


def without_checksums(data):
    """The bytes of a log without the messages that end its blocks, as other programs save it: for tests that change a
    log on purpose. It counts as a log that has no checksums, so that a change is no damage."""
    messages = list(ulog_messages(data))
    kept = b"".join(data[m.at : m.end] for m in messages if not m.content.startswith(BLOCK_KEY))
    return data[:16] + kept + data[messages[-1].end :]


TICK, FRAME, RIG = 0, 1, 2  # message ids of the topics


def record_type(data, name):
    """The numpy type of a topic's records, from the format that the log carries."""
    kinds = {"uint64_t": "<u8", "int64_t": "<i8", "uint32_t": "<u4", "uint16_t": "<u2", "uint8_t": "u1", "double": "<f8",
             "float": "<f4"}
    for message in ulog_messages(data):
        text = message.content.decode(errors="replace")
        if message.type == "F" and text.startswith(name + ":"):
            fields = [field.split() for field in text.split(":")[1].split(";") if field]
            return np.dtype([(field, kinds[kind]) for kind, field in fields])
    raise AssertionError(f"the log does not describe {name}")


def patched(data, message, dtype, field, change):
    """The bytes of a log with one field of one record changed by `change(value)`."""
    start = message.at + 5
    record = np.frombuffer(data[start : start + dtype.itemsize], dtype).copy()
    record[field] = change(record[field])
    return data[:start] + record.tobytes() + data[start + dtype.itemsize :]


@pytest.fixture
def write_rig(tmp_path):
    """A function that writes a rig file and returns its path."""
    def write(text):
        path = tmp_path / "my.toml"
        path.write_text(text)
        return path
    return write


@pytest.fixture(scope="session")
def logs(tmp_path_factory):
    """A function (rig, **overrides) -> (JSON object, path of the log), one run per case and session."""
    made = {}

    def make(rig, overrides=None):
        overrides = overrides or {}
        case = (rig, tuple(sorted(overrides.items())))
        if case not in made:
            folder = tmp_path_factory.mktemp(str(rig).rsplit("/", 1)[-1])
            result = run_json(rig, folder, *settings(overrides))
            made[case] = result, pathlib.Path(result["log"])
        return made[case]

    return make


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    """Two runs of one rig and the folder where the program was called."""
    folder = tmp_path_factory.mktemp("kept")
    runs = [json.loads(berth(folder, "run", "ess", "--json", *settings({**SHORT, **values})).stdout)
            for values in ({}, {"robot.dead_time_ms": 25.0})]
    return folder, runs


@pytest.fixture(scope="session")
def arm64():
    """How to start `run` and `replay` built for arm64. Absent is a failure, no skip: deselect with -m "not arm64"."""
    program = ARM64_BUILD / "replay"
    assert program.exists(), "build it: make CROSS_COMPILE=aarch64-linux-gnu- build/aarch64-linux-gnu/replay"
    return "qemu-aarch64-static", program


def limit_file_size(size_bytes):
    """For preexec_fn: from here on no file can grow beyond this."""
    import resource

    return lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size_bytes, size_bytes))


def interrupt_when(process, condition, number=signal.SIGINT, timeout_s=TIMEOUT_s):
    """Sends a signal to a running process once `condition()` holds; its stdout, stderr and exit code."""
    import time

    deadline_s = time.monotonic() + timeout_s
    while not condition():
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < deadline_s, "the run never got that far"
        time.sleep(0.005)
    process.send_signal(number)
    stdout, stderr = process.communicate(timeout=timeout_s)
    return stdout, stderr, process.returncode


def data_folder():
    """Measured data: $BERTH_DATA, or shared/data beside the repository; None where there is none."""
    for folder in (os.environ.get("BERTH_DATA"), ROOT.parent / "shared" / "data"):
        if folder and pathlib.Path(folder).is_dir():
            return pathlib.Path(folder)
    return None
