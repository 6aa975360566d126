"""The count of banned phrases reads every place where a user meets our words."""

import sys

import pytest
from conftest import ROOT

sys.path.insert(0, str(ROOT / "scripts"))
import readability  # noqa: E402


@pytest.mark.parametrize("name, text", [
    ("a.py", 'print("The loop "\n      f"is {x:.1f} and told " "a dead time")'),
    ("a.py", '"""The loop is told a dead time."""\nx = 1\n'),
    ("a.cpp", 'std::printf("a loop that is "\n            "told a dead time");'),
    ("a.toml", 'description = "a copper sheet: is told a lot"'),
    ("a.html", "<p>The loop <b>is told</b> it.</p>"),
    ("a.js", 'const words = "the loop is " + "told it";'),
    ("a.js", "const words = `the loop is told ${it}`;"),
])
def test_a_banned_phrase_is_found_wherever_it_is_written(name, text, tmp_path):
    (tmp_path / name).write_text(text)
    found = [phrase for one in readability.texts_of(tmp_path / name) for phrase in readability.banned_in(one)]
    assert set(found) & {"is told", "told a"}


def test_a_comment_of_a_function_is_no_message(tmp_path):
    (tmp_path / "a.py").write_text('"""One."""\n\n\ndef f():\n    """Of what it is told."""\n    return 1\n')
    assert readability.texts_of(tmp_path / "a.py") == ["One."]


def test_all_kinds_of_files_are_read():
    read = {path.rsplit(".", 1)[-1] for path, _ in readability.messages()}
    assert read == {"cpp", "h", "c", "py", "toml", "js", "html"}
