"""make target-image: what a board gets."""

import subprocess

import pytest
from conftest import PROGRAMS, ROOT

FILES = [
    "etc/berth/rig.toml", "etc/security/limits.d/berth.conf", "usr/bin/berth-target", "usr/share/berth/berth.dbc",
    "usr/lib/systemd/system/berth.service", "usr/lib/udev/rules.d/60-berth.rules",
]


def ask_package(arch, option):
    [package] = (ROOT / PROGRAMS[arch]).glob("berth_*.deb")
    return subprocess.run(["dpkg-deb", option, package], capture_output=True, text=True, check=True).stdout


@pytest.mark.parametrize("arch", PROGRAMS)
def test_the_package_is_for_its_architecture_and_whole(arch):
    assert f" Architecture: {arch}\n" in ask_package(arch, "--info")
    contents = ask_package(arch, "--contents")
    for name in FILES:
        assert f" ./{name}\n" in contents


def test_its_program_takes_its_rig(guest):
    step = guest("image")
    step.check_done()
    assert step.number("check.exit_code") == 0, step.text("check")
