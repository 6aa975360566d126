"""What a terminal shows and a pipe does not: colours, lines that fit, progress."""

import os
import pty
import re
import subprocess

import pytest
from conftest import BERTH, EXIT_DONE, ROOT, SHORT, berth, command, data_folder, settings

ESCAPE = b"\033["


def on_terminal(words, **environment):
    """What a command writes to a terminal."""
    leader, follower = pty.openpty()
    variables = {**os.environ, "TERM": "xterm", **environment}
    variables = {name: value for name, value in variables.items() if value is not None}
    with subprocess.Popen([str(word) for word in (BERTH, *words)], stdout=follower, stderr=follower, cwd=ROOT,
                          env=variables) as process:
        os.close(follower)
        shown = b""
        while True:
            try:
                part = os.read(leader, 65536)
            except OSError:
                break
            if not part:
                break
            shown += part
        process.wait()
    os.close(leader)
    return shown


RED, GREEN, YELLOW = (f"\033[{number}m{{}}\033[0m".format for number in (31, 32, 33))


@pytest.mark.parametrize("words, shown", [
    (["eigen", "ess"], GREEN("stable")),
    (["check", "ess"], GREEN("values")),
    (["check", "ess", *settings({"object.stiffness_N_per_m": 5e7})], YELLOW("implausible")),
    (["check", "ess", *settings({"limits.position_min_m": -0.002})], RED("stops")),
    (["compare", "LOG", "UNSTABLE"], f"{GREEN('stable')}                   {RED('unstable')}"),
    (["map", "ess", "--vary", "mass", "--grid", "4x4", "--out", "FOLDER"], GREEN("stable")),
    (["eigen", "nothing"], RED("berth:")),
    (["eigen"], RED("berth:")),
    (["eigne"], RED("berth:")),
])
def test_colours_are_on_a_terminal_only(words, shown, kept, tmp_path):
    folder, runs = kept
    if "UNSTABLE" in words:
        unstable = berth(tmp_path, "run", "ess", "--out", ".", *settings({**SHORT, "object.mass_kg": 210}))
        assert unstable.returncode == EXIT_DONE
    names = {"LOG": folder / runs[0]["log"], "UNSTABLE": tmp_path / "ess.ulg", "FOLDER": tmp_path}
    words = [names.get(word, word) for word in words]
    assert shown in on_terminal(words, NO_COLOR=None).decode()
    assert ESCAPE not in on_terminal(words, NO_COLOR="1")
    assert ESCAPE not in on_terminal(words, NO_COLOR=None, TERM="dumb")
    piped = command(*words)
    assert ESCAPE not in piped.stdout + piped.stderr


# --- width --------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("words", [
    ["run", "ess", "--no-log", *settings(SHORT)], ["check", "ess", "--robot", "ur10e-servoj"], ["limits", "ess", "--help"],
    ["--help"], ["eigen", "ess", "--robot", "abb-egm"], ["effects"], ["robots"], ["rigs"], ["eigne"], ["check", "es"],
], ids=" ".join)
@pytest.mark.parametrize("width", [80, 100])
def test_lines_of_prose_fit_the_terminal(words, width):
    """Each line of a pipe is there whole, in lines of the terminal that end at blanks; rows of tables stay."""
    shown = re.sub(rb"\033\[[0-9;]*[mK]", b"", on_terminal(words, COLUMNS=str(width))).decode().replace("\r\n", "\n")
    shown = re.sub(r"\r[^\n]*\r", "", shown)
    piped = command(*words)
    whole = (piped.stdout + piped.stderr).decode()
    long = [line for line in shown.splitlines() if len(line) > width]
    assert all(re.search(r"\S  +\S.*  +\S", line) or " " not in line.strip() for line in long), long
    assert len(shown.splitlines()) > len(whole.splitlines()) or max(map(len, whole.splitlines())) <= width

    def same(text):
        return re.sub(r"\d+ times real time \([\d.]+ ms\)", "", " ".join(text.split()))

    assert same(shown) == same(whole)


def test_a_wrapped_line_goes_on_under_its_text():
    shown = on_terminal(["check", "ess"], COLUMNS="80", NO_COLOR="1").decode().splitlines()
    at = next(i for i, line in enumerate(shown) if line.startswith("  delay"))
    assert re.match(r" {17}\S", shown[at + 1]), shown[at:at + 2]


def test_json_on_a_terminal_is_one_line():
    assert len(on_terminal(["eigen", "ess", "--json"], COLUMNS="80").splitlines()) == 1


@pytest.mark.long
@pytest.mark.parametrize("words, doing", [
    (["report", "LOG"], b"report: draws"),
    (["compare", "LOG", "LOG", "--page", "FOLDER/page.html"], b"compare: draws"),
    (["export", "LOG", "--mcap"], b"export: every message"),
    (["map", "ess", "--vary", "mass", "--grid", "4x4", "--out", "FOLDER", "--picture"], b"map: draws"),
    (["reduce", "ess", "--arm", "ess", "--sweep", "1=0:1:3", "--json"], b"reduce: pose 3 of 3"),
    (["rths", "DATA/rths", "--perturbed", "2"], b"rths: plant 2 of 2"),
])
def test_what_takes_seconds_says_on_a_terminal_what_it_does(words, doing, kept, tmp_path):
    """The line is erased before anything else is printed; in a pipe there is none."""
    folder, runs = kept
    names = {"LOG": folder / runs[0]["log"], "FOLDER": tmp_path, "DATA": data_folder()}
    if "DATA/rths" in words and names["DATA"] is None:
        pytest.skip("the benchmark's data are not here; BERTH_DATA names their folder")
    for name, value in names.items():
        words = [word.replace(name, str(value)) for word in words]
    shown = on_terminal(words)
    assert doing in shown
    assert all(line.startswith(b"\033[K") for line in shown.split(b"\r")[1:] if doing in line), shown
    last = shown.rindex(doing)
    assert b"\r\033[K" in shown[last:] and doing not in command(*words).stderr


def test_a_terminal_that_only_prints_has_no_line_to_erase():
    assert ESCAPE not in on_terminal(["reduce", "ess", "--arm", "ess", "--sweep", "1=0:1:3", "--json"], TERM="dumb")


def test_an_empty_no_color_counts_as_unset():
    """As https://no-color.org has it."""
    assert ESCAPE in on_terminal(["eigen", "ess"], NO_COLOR="")
