"""`berth diagnose` as a command: records without end, a terminal that waits, and its library of effects. What it finds in
records stands in the tables of tests/python/diagnosis."""

import contextlib
import gzip
import json
import os
import pty
import re
import resource
import subprocess
import sys
import threading
import zlib

import pytest
from conftest import BERTH, EXIT_INPUT, ROOT, command

sys.path.insert(0, str(ROOT / "tests" / "python" / "diagnosis"))
from make_files import lines_of, motion  # noqa: E402


def write(path, *columns):
    text = "\n".join(lines_of(HEADER.split(","), columns)) + "\n"
    path.write_bytes(gzip.compress(text.encode()) if path.suffix == ".gz" else text.encode())
    return path


def refused(out, record, *contains, arguments=(), **options):
    done = command("diagnose", record, *arguments, "--rig", "ess", "--out", out / "out", **options)
    message = done.stderr.decode()
    assert done.returncode == EXIT_INPUT and done.stdout == b"", message
    assert message.startswith("berth: ") and message.count("\n") == 1 and "internal error" not in message, message
    assert not (out / "out").exists()
    for part in (record.name, *contains):
        assert part in message, message


HEADER = "t_s,command_position_m,robot_position_m"
ENDLESS_BYTES_MAX = 400000000  # of memory, to refuse a record that is larger


def endless_rows():
    """A record that never ends, piece by piece."""
    yield (HEADER + "\n").encode()
    first = 0
    while True:
        yield "".join(f"{0.0025 * n:.4f},{1e-6 * (n % 977)},{1e-6 * (n % 977)}\n"
                      for n in range(first, first + 20000)).encode()
        first += 20000


@pytest.mark.long
@pytest.mark.parametrize("pack", ["plain", "gz"])
def test_a_record_without_end_is_refused_while_it_is_read(tmp_path, pack):
    name = tmp_path / ("pipe.csv.gz" if pack == "gz" else "pipe.csv")
    os.mkfifo(name)
    written = 0

    def feed():
        nonlocal written
        packer = zlib.compressobj(1, wbits=31) if pack == "gz" else None
        with contextlib.suppress(BrokenPipeError), open(name, "wb", buffering=0) as pipe:
            for rows in endless_rows():
                pipe.write(packer.compress(rows) if packer else rows)
                written += len(rows)

    feeder = threading.Thread(target=feed, daemon=True)
    feeder.start()
    limit = lambda: resource.setrlimit(resource.RLIMIT_AS, (ENDLESS_BYTES_MAX, ENDLESS_BYTES_MAX))  # noqa: E731
    refused(tmp_path, name, "more than 1000000 rows", "cut out", preexec_fn=limit)
    feeder.join(timeout=20)
    assert not feeder.is_alive(), "it is still being read"
    assert written < 50e6, "it was read to no purpose"


@pytest.mark.long
def test_records_that_together_are_too_long(tmp_path):
    record = write(tmp_path / "part.csv.gz", *motion(10000))
    refused(tmp_path, record, "and those before it", "more than 1000000 rows", arguments=[record] * 100)


def test_a_log_that_is_too_large_to_be_read(tmp_path):
    log = tmp_path / "large.ulg"
    with log.open("wb") as file:
        file.truncate(1000000000)  # takes no room on the disk
    refused(tmp_path, log, "more than 1000000 rows")


def test_whoever_waits_at_a_terminal_sees_what_is_done(tmp_path):
    record = write(tmp_path / "good.csv", *motion())
    ours, theirs = pty.openpty()
    words = [BERTH, "diagnose", record, "--rig", "ess", "--out", tmp_path / "out"]
    done = subprocess.run(words, cwd=ROOT, stdout=subprocess.PIPE, stderr=theirs, timeout=60, check=True)
    shown = os.read(ours, 10000).decode()
    for what in ("reading", "looking at the robot", "looking at the robot: robot.lag",
                 "looking for what it would have shown"):
        assert f"\r\033[K{what}\r" in shown
    assert shown.endswith("\r\033[K") and b"looking" not in done.stdout
    assert command(*words[1:]).stderr == b""


def test_the_library_is_listed():
    done = command("effects", "--json")
    listed = {effect["effect"]: effect for effect in json.loads(done.stdout)}
    assert len(listed) == 44 and listed["robot.backlash"]["parameters"][0]["unit"] == "m"
    assert all(effect["physics"] and effect["source"] for effect in listed.values())
    assert (ROOT / "sim_hal" / "effects" / "robot_backlash.cpp").exists()


def test_an_effect_is_one_file_and_one_line():
    """The guide's example is the real file, and every file of an effect has its line."""
    folder = ROOT / "sim_hal" / "effects"
    example = (folder / "sensor_drift.cpp").read_text()
    assert f"```cpp\n{example}```" in (ROOT / "scripts/docs/how-to/add-an-effect.md").read_text()
    lines = re.findall(r"^    EFFECT\((\w+)\)", (folder / "effects.h").read_text(), re.MULTILINE)
    files = [path.stem for path in folder.glob("*.cpp") if f"effect {path.stem}()" in path.read_text()]
    assert sorted(lines) == sorted(files) and "sensor_drift" in lines
    listed = json.loads(command("effects", "--json").stdout)
    assert [name.replace("_", ".", 1) for name in lines] == [effect["effect"] for effect in listed]
    elsewhere = [path for path in (ROOT / "sim_hal").rglob("*.cpp") if "sensor_drift" in path.read_text()]
    assert [path.name for path in elsewhere] == ["sensor_drift.cpp"]
