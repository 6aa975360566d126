"""What README and guides show is what the commands print: their console blocks are run again and compared.

One page: pytest -k docking-stability tests/python/test_readme.py
"""

import re
import sys

import pytest
from conftest import ROOT

sys.path.insert(0, str(ROOT / "scripts"))
import readability  # noqa: E402
import readme  # noqa: E402

PAGES = {str(page.relative_to(ROOT)).removeprefix("scripts/docs/"): page for page in readme.pages()}
VOLATILE = [
    (r"\d+ times real time \([\d.]+ ms\)", "SPEED"),  # of the machine
    (r"configuration +.*", "CONFIGURATION"),          # holds the commit
    (r"\d{4}-\d\d-\d\dT\d\d-\d\d-\d\d(-\d+)?", "TIME"),  # of the run's folder
    (r"\bto be run ", "not run   "),  # a stage of commissioning, where the page ran before
]
PICTURE_PIXELS_MAX = 5  # of 1.6 million; another last digit of a number makes 20
SLOW = ("build/berth accuracy", "--rig ess-paper")
LONG = ("scripts/claims.py", "scripts/restitution.py", "report.py", "map_picture.py", "scripts/verification.py")


def marks(command, block):
    """A block with a slow command is slow as a whole: what follows reads the files of what came before."""
    if any(words in block for words in SLOW):
        return [pytest.mark.slow]
    return [pytest.mark.long] * any(words in command for words in LONG)


def console_commands():
    """(page, command, expected output) of each command in the pages' console blocks that runs a program of ours."""
    for page, path in PAGES.items():
        for block in readme.BLOCK.finditer(path.read_text()):
            for command, printed in readme.split_block(block[2]):
                if readme.is_run(command):
                    name = f"{page}: {command.splitlines()[0][:60]}"
                    yield pytest.param(page, command, printed, marks=marks(command, block[2]), id=name)


def stable(text):
    for pattern, replacement in VOLATILE:
        text = re.sub(pattern, replacement, text)
    return text.strip().splitlines()


@pytest.mark.long
@pytest.mark.parametrize("page, command, expected", list(console_commands()))
def test_console_block(page, command, expected):
    readme.write_files(PAGES[page].read_text())
    assert stable(readme.run(command)) == stable(expected), f"scripts/readme.py {PAGES[page]} brings it up to date"


def page_pictures():
    """(page, file that its commands wrote, picture that it shows)."""
    for page, path in PAGES.items():
        slow = any(words in path.read_text() for words in SLOW)
        for made, shown in readme.pictures(path):
            yield pytest.param(page, made, shown, marks=[pytest.mark.slow] if slow else [], id=f"{page}: {shown.name}")


def newest(made):
    """Pages share `latest`: of the runs of this rig, the newest that has the picture."""
    if made.parent.name != "latest":
        return made
    return max(made.parent.parent.glob(f"*/{made.name}"), key=lambda path: path.stat().st_mtime, default=made)


@pytest.mark.long
@pytest.mark.parametrize("page, made, shown", list(page_pictures()))
def test_picture_is_what_the_commands_draw(page, made, shown):
    """The commands ran above."""
    made = newest(made)
    assert made.is_file(), f"run the page's commands first: pytest -k '{page}' tests/python/test_readme.py"
    differing = readme.differing_pixels(made, shown)
    assert differing <= PICTURE_PIXELS_MAX, f"{differing} pixels differ: scripts/readme.py {PAGES[page]} renews {shown}"


def test_every_picture_says_which_command_draws_it():
    drawn = {shown for path in PAGES.values() for _, shown in readme.pictures(path)}
    kept = set((ROOT / "scripts" / "pictures").glob("*.png"))
    assert drawn == kept and kept


def test_commands_were_found():
    assert len(list(console_commands())) >= 60
    for page in (page for page in PAGES if page.startswith("tutorials/") and not page.endswith("index.md")):
        assert any(param.values[0] == page for param in console_commands()), f"{page} runs nothing"


DECIMAL = re.compile(r"\d+\.\d+(?:e[+-]?\d+)?")
BLOCKS = re.compile(r"^```(?:console|toml|python)\n.*?^```", re.S | re.M)
# Numbers of the prose that no block of the page holds, and where they come from.
OF_ELSEWHERE = {
    "README.md": {"2.5": "dead time of the sensor, in the rig file ess",
                  "0.3": "score in sim_hal/diagnosis/README.md, which tests/hidden_effects measures"},
    "tutorials/empty-board.md": {"0.1": "start of the simulated operator, in berth-rig"},
    "tutorials/hybrid-testing.md": {"0.20": "the estimate by hand, from the numbers in its sentence"},
}


def numbers_of_no_block(text):
    """Numbers with a decimal point in a page's prose and tables that are not in its blocks, digit for digit."""
    shown = {number for block in BLOCKS.findall(text) for number in DECIMAL.findall(block)}
    told = DECIMAL.findall(" ".join(readability.prose(text) + readability.tables(text)))
    return {number for number in told if number not in shown}


@pytest.mark.parametrize("page", [page for page in PAGES if page == "README.md" or page.startswith("tutorials/")])
def test_numbers_of_the_prose_are_those_of_the_blocks(page):
    text = PAGES[page].read_text()
    assert numbers_of_no_block(text) == set(OF_ELSEWHERE.get(page, {}))
    assert numbers_of_no_block(text + "\n\nThe restitution is 0.8123.\n") == set(OF_ELSEWHERE.get(page, {})) | {"0.8123"}


def test_readme_stays_short():
    assert len((ROOT / "README.md").read_text().splitlines()) <= 250


def test_the_layout_names_every_folder():
    layout = PAGES["explanation/architecture.md"].read_text()
    for folder in ["firmware", "hal", "sim_hal", "tests", "scripts"]:
        assert re.search(rf"^{folder}/ ", layout, re.M), folder
    for folder in (path.name for path in (ROOT / "sim_hal").iterdir() if path.is_dir()):
        assert re.search(rf"^  {folder}/ ", layout, re.M), folder


def test_pictures_exist():
    for path in PAGES.values():
        for picture in re.findall(r"!\[[^]]*\]\(([^)]+)\)", path.read_text()):
            assert (path.parent / picture).is_file(), f"{path}: {picture}"
