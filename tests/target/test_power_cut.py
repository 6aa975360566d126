"""A power cut while the loop logs: the guest's processor stops between two instructions, and what its disk does not have is
lost. The log must be whole up to at most two seconds before, and berth must say that it ends early."""

import io
import os
import random
import subprocess

import pytest
from conftest import PROGRAMS, TIMEOUT_s, berth, guest_run

LOST_AT_MOST_s = 2.0  # data reach the disk every second; the writer may be in the middle of the next one
RATE_Hz = 400
SEED = int(os.environ.get("BERTH_TEST_SEED", "20261"))
CUTS = int(os.environ.get("BERTH_POWER_CUTS", "2"))
DISK_MB = 64


class PowerCut(Exception):
    """Enough has been sent."""


class Console(io.StringIO):
    """The guest's console; cuts the power once so many setpoints have come to the robot."""

    def __init__(self, setpoints):
        super().__init__()
        self.setpoints, self.seen = setpoints, 0

    def write(self, line):
        super().write(line)
        if line.startswith("setpoints "):
            self.seen = int(line.split()[1])
            if self.seen >= self.setpoints:
                raise PowerCut
        return len(line)


def log_after_cut(arch, folder, setpoints):
    """(setpoints that had come to the robot, the log as the disk has it after the file system was mended)."""
    disk = folder / "disk.img"
    with disk.open("wb") as image:
        image.truncate(DISK_MB << 20)
    subprocess.run(["/sbin/mke2fs", "-q", "-t", "ext4", disk], check=True)
    console = Console(setpoints)
    script = f"sh tests/target/power_cut.sh /src/{PROGRAMS[arch]}\n"
    with pytest.raises(PowerCut):
        code = guest_run.run(script, arch=arch, icount=True, results=folder / "results", timeout_s=TIMEOUT_s,
                             output=console, disk=disk)
        pytest.fail(f"the guest ended with {code} by itself:\n{console.getvalue()}")
    mended = subprocess.run(["/sbin/e2fsck", "-fy", disk], capture_output=True, text=True, check=False)
    assert mended.returncode in (0, 1), mended.stdout  # 1: the journal was played
    log = folder / "run.ulg"
    subprocess.run(["/sbin/debugfs", "-R", f"dump /run.ulg {log}", disk], capture_output=True, check=True)
    return console.seen, log


@pytest.mark.parametrize("arch", PROGRAMS)
@pytest.mark.parametrize("cut", range(CUTS))
def test_a_power_cut_takes_two_seconds_of_the_log_at_most(arch, cut, tmp_path):
    setpoints = random.Random(f"{SEED} {arch} {cut}").randrange(2 * RATE_Hz, 20 * RATE_Hz)
    print(f"BERTH_TEST_SEED={SEED} BERTH_POWER_CUTS={CUTS} .venv/bin/python -m pytest "
          f"'{__file__}::{test_a_power_cut_takes_two_seconds_of_the_log_at_most.__name__}[{cut}-{arch}]'")
    sent, log = log_after_cut(arch, tmp_path, setpoints)
    told = berth("summary", log)
    lost_s = (sent - told["ticks"]) / RATE_Hz  # a setpoint a tick
    print(f"cut after {sent / RATE_Hz:.2f} s: whole until {told['whole_until_s']:.2f} s, {lost_s:.2f} s are lost")
    assert told["checksums"] and (told["cut"] or told["damage"]), "a log that ends early says so"
    assert told["whole_until_s"] == pytest.approx((told["ticks"] - 1) / RATE_Hz), "all of its ticks are whole"
    assert lost_s <= LOST_AT_MOST_s
    again = berth("replay", log)
    assert again["equal"] and again["ticks"] == told["ticks"]
