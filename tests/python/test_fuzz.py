"""What scripts/fuzz.py makes of libFuzzer's words. The program is a stand-in that everybody can follow."""

import sys

import pytest
from conftest import ROOT

sys.path.insert(0, str(ROOT / "scripts"))
import fuzz  # noqa: E402


@pytest.fixture
def stand_in(tmp_path, monkeypatch):
    """A program of these words and this exit code."""
    monkeypatch.setattr(fuzz, "FOLDER", tmp_path)
    monkeypatch.setattr(fuzz, "COUNTS", tmp_path / "executions.json")

    def make(told, exit_code):
        path = tmp_path / "parsers"
        path.write_text(f"#!/bin/sh\ncat >&2 <<'END'\n{told}\nEND\nexit {exit_code}\n")
        path.chmod(0o755)
        return path

    return make


def test_parsers_are_those_that_the_program_lists(stand_in):
    assert fuzz.parsers(stand_in("usage: parsers --parser=NAME\nNAME: rig log", 2)) == ["rig", "log"]


def test_files_are_counted(stand_in):
    told = "#2\tINITED cov: 7\n#512\tpulse  cov: 9\nDone 1000 runs in 2 second(s)"
    assert fuzz.fuzz(stand_in(told, 0), "profile", [], grows=False) == (1000, "")


@pytest.mark.parametrize("reason", ["SUMMARY: AddressSanitizer: heap-buffer-overflow a.cpp:3 in read",
                                    "==7== ERROR: libFuzzer: timeout after 5 seconds"])
def test_a_file_that_breaks_a_reader_is_told_with_the_line_that_repeats_it(stand_in, reason):
    told = f"#64\tNEW    cov: 9\n{reason}\nartifact_prefix='f/'; Test unit written to f/crash-1"
    runs, wrong = fuzz.fuzz(stand_in(told, 77), "profile", [], grows=False)
    assert runs == 64
    assert wrong.startswith(reason.partition(": ")[2])
    assert wrong.endswith("--parser=profile f/crash-1")


def test_sums_go_on_from_call_to_call(stand_in, tmp_path):
    assert fuzz.add_up({"rig": 5}) == {"rig": 5}
    assert fuzz.add_up({"rig": 7, "log": 1}) == {"rig": 12, "log": 1}
    assert (tmp_path / "executions.json").exists()


def test_every_parser_has_files_to_begin_with(tmp_path):
    source = (ROOT / "tests" / "fuzz" / "parsers.cpp").read_text()
    names = [line.split('"')[1] for line in source.splitlines() if line.startswith('    {"')]
    assert len(names) > 9
    for name in names:
        assert list(fuzz.seeds(name, tmp_path / name).iterdir()), name
