"""Files and folders that are not there, are none, are damaged or cannot be written, and a user who asks for help."""

import gzip
import random
import subprocess

import pytest
from conftest import EXIT_DONE, EXIT_INPUT, ROOT, command
from refusals import Bad, each

NOISE = random.Random(1).randbytes(1000)
WHOLE = gzip.compress("\n".join(["t_s,x", *(f"{i},{i % 7}" for i in range(5000))]).encode())
# All numbers are there where only the checksum is cut.
DAMAGED = {"half": WHOLE[:len(WHOLE) // 2], "without its checksum": WHOLE[:-8], "without its last byte": WHOLE[:-1],
           "with a hole": WHOLE[:200] + bytes(100) + WHOLE[300:]}
RIGS = [("nosuchrig", "no shipped rig", "ess-50hz"), ("nosuch.toml", "cannot be read"), ("no/such/file", "cannot be read"),
        ("sim_hal", "cannot be read"), ("/proc", "cannot be read"), ("", "no shipped rig")]


def profile(name, path, *says, files=None, more=()):
    return Bad(f"profile {name}", ["run", "ess", "--profile", path, *more, "--out", "{out}"], *says, files=files)


ROWS = [
    Bad("rig that is no text", ["run", "{noise.toml}"], "{noise.toml}:1", files={"noise.toml": NOISE}),
    *[Bad(f"rig that is not there: {name or 'no name'}", ["run", "--out", "{out}", name], name, *says,
          also=[["run", "--print-config", name], ["deadtime", name]]) for name, *says in RIGS],
    Bad("rig without an end", ["run", "/dev/zero", "--out", "{out}"], "/dev/zero: is larger than 64 MB", "device",
        also=[["eigen", "/dev/zero"]]),
    Bad("robot without an end", ["run", "ess", "--robot", "/dev/zero", "--out", "{out}"], "/dev/zero: is larger"),
    Bad("arm without an end", ["arm", "/dev/zero"], "/dev/zero: is larger"),
    profile("that is not there", "{no.csv}", "{no.csv}", "cannot be read"),
    profile("that is a folder", "{folder}", "{folder}", "cannot be read", files={"folder/file": ""}),
    *[profile(f"{name}, packed", "{p.csv.gz}", "{p.csv.gz}", files={"p.csv.gz": data}) for name, data in DAMAGED.items()],
    profile("without the column", "{p.csv}", "{p.csv}:1", "z", "t_s, x, y", files={"p.csv": "t_s,x,y\n0,0,0\n1,1,1\n"},
            more=["--set", "profile.column=z"]),
    *[Bad(f"log below {folder}", ["run", "ess", "--out", folder, "--json"], folder, "--out", files={"file": ""})
      for folder in ("{file}", "{file/below}", "/proc/nothing", "/dev/null/x")],
    Bad("log whose place is taken by a folder", ["run", "ess", "--out", "{logs}"], "ess.ulg", "--out",
        files={"logs/ess.ulg/file": ""}),
]


@each(ROWS)
def test_path(row, tmp_path):
    row.check(tmp_path)
    made = {path.relative_to(tmp_path).as_posix() for path in tmp_path.rglob("*") if path.is_file()}
    assert made == set(row.files)


@pytest.mark.parametrize("arguments", [["--help"], ["run", "--help"], ["--version"]])
def test_asking_for_help_is_no_error(arguments):
    done = command(*arguments)
    assert done.returncode == EXIT_DONE and done.stderr == b"" and done.stdout


def test_a_map_that_memory_does_not_hold(tmp_path):
    done = subprocess.run(
        f"ulimit -v 700000; exec {ROOT}/build/berth map ess --vary mass --grid 20000x20000 --yes --out {tmp_path}/out",
        shell=True, capture_output=True, check=False, timeout=120)
    assert done.returncode == EXIT_INPUT and b"not enough memory" in done.stderr and done.stdout == b""


def test_standard_output_that_is_full():
    with open("/dev/full", "wb") as full:
        done = subprocess.run([ROOT / "build" / "berth", "rigs"], stdout=full, stderr=subprocess.PIPE, timeout=60)
    assert done.returncode == EXIT_INPUT and b"standard output" in done.stderr
