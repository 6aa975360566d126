"""What an editor gets: with `make compile_commands.json`, clangd reads the repository's files without an error."""

import json
import re
import subprocess

import pytest
from conftest import ROOT

FILES = ["firmware/app.c", "sim_hal/verdict.cpp", "tests/unit/edges_test.cpp"]


@pytest.fixture(scope="module")
def database(tmp_path_factory):
    """A folder with the database of the whole repository, as make writes it."""
    folder = tmp_path_factory.mktemp("editor")
    subprocess.run(["make", "-s", "compile_commands.json", f"COMPILE_COMMANDS={folder}/compile_commands.json"],
                   cwd=ROOT, check=True)
    return folder


def errors_of(database, file):
    """What clangd says is wrong. --check-lines keeps it from trying its code changes at every word of the file, some
    of which fail in correct code."""
    done = subprocess.run(["clangd", f"--compile-commands-dir={database}", f"--check={file}", "--check-lines=1-1"],
                          cwd=ROOT, capture_output=True, text=True, check=False)
    errors = re.findall(r"^E\[[^]]*\] (.*)", done.stderr, re.MULTILINE)
    assert errors or "All checks completed, 0 errors" in done.stderr, done.stderr
    return errors


@pytest.mark.long
@pytest.mark.parametrize("file", FILES)
def test_clangd_reads_a_file_without_an_error(database, file):
    assert errors_of(database, ROOT / file) == []


def test_clangd_finds_an_error(database, tmp_path):
    wrong = tmp_path / "wrong.cpp"
    wrong.write_text('int number = "text";\n')
    assert len(errors_of(database, wrong)) == 1


def test_database_has_every_file_once(database):
    listed = [entry["file"] for entry in json.loads((database / "compile_commands.json").read_text())]
    there = [str(path.relative_to(ROOT)) for folder in ("firmware", "hal", "sim_hal", "tests")
             for path in (ROOT / folder).rglob("*") if path.suffix in (".c", ".cpp", ".h")]
    assert sorted(listed) == sorted(there)
