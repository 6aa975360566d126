"""What the README shows is what the commands print: its console blocks are run again and compared."""

import re
import sys

import pytest
from conftest import ROOT

sys.path.insert(0, str(ROOT / "scripts"))
import readme  # noqa: E402

README = (ROOT / "README.md").read_text()
VOLATILE = [
    (r"\d+ times real time \([\d.]+ ms\)", "SPEED"),  # of the machine
    (r"configuration +.*", "CONFIGURATION"),          # holds the commit
]


def console_commands():
    """(command, expected output) of each command in the README's console blocks that runs a program of the build."""
    for block in readme.BLOCK.finditer(README):
        for command, printed in readme.split_block(block[2]):
            if readme.is_run(command):
                takes_long = command.startswith("build/berth accuracy") or "--rig ess-paper" in command
                yield pytest.param(command, printed, marks=[pytest.mark.slow] * takes_long)


def stable(text):
    for pattern, replacement in VOLATILE:
        text = re.sub(pattern, replacement, text)
    return text.strip().splitlines()


@pytest.mark.parametrize("command, expected", list(console_commands()), ids=lambda value: value.split("\n")[0][:60])
def test_console_block(command, expected):
    assert stable(readme.run(command)) == stable(expected), "scripts/readme.py brings the README up to date"


def test_commands_were_found():
    assert len(list(console_commands())) >= 7


def test_the_layout_names_every_folder():
    for folder in ["firmware", "hal", "sim_hal", "tests", "scripts"]:
        assert re.search(rf"^{folder}/ ", README, re.M), folder
    for folder in (path.name for path in (ROOT / "sim_hal").iterdir() if path.is_dir()):
        assert re.search(rf"^  {folder}/ ", README, re.M), folder


def test_pictures_exist():
    for picture in re.findall(r"!\[[^]]*\]\(([^)]+)\)", README):
        assert (ROOT / picture).is_file(), picture
