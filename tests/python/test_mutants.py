"""The mutation check itself: what it counts, and what it says of a mutant. The compiler and the tests are stood for by
a rule that everybody can follow."""
import sys

import pytest
from conftest import ROOT

sys.path.insert(0, str(ROOT / "scripts"))
import mutants  # noqa: E402


class Pretended:
    """Code is the text without spaces; "?" cannot be compiled; the tests notice a minus."""

    def __init__(self, folder):
        self.made = folder / "made"

    def code(self, _source, text, _name):
        if "?" in text:
            return None
        self.made.write_text(text.replace(" ", ""))
        return self.made

    def tests_with(self, _source, made):
        return made.read_text()


@pytest.fixture
def pretended(tmp_path, monkeypatch):
    monkeypatch.setattr(mutants, "FOLDER", tmp_path)
    monkeypatch.setattr(mutants, "is_noticed", lambda code: "-" in code)
    return Pretended(tmp_path)


@pytest.mark.parametrize("text, verdict", [("a ? b", "refused"), ("a  +  b", "same"), ("a - b", "noticed"),
                                           ("b + a", "survived")])
def test_a_mutant_is_judged(pretended, tmp_path, text, verdict):
    assert mutants.judge(pretended, tmp_path / "source.c", text, b"a+b") == verdict


def test_what_is_refused_or_the_same_does_not_count_and_survivors_are_tried_again(pretended, tmp_path, monkeypatch):
    source = tmp_path / "source.c"
    source.write_text("a + b")
    monkeypatch.setattr(mutants, "texts_of", lambda *_: ["a ? b", "a  + b", "a - b", "- a + b", "b + a"])
    found = {}
    counts, survivors = mutants.look_at(source, 10, 1, pretended, found, None)
    assert counts == {"noticed": 2, "survived": 1} and survivors == ["b + a"]
    monkeypatch.setattr(mutants, "is_noticed", lambda code: True)  # there is a test of it by now
    assert mutants.look_at(source, 10, 1, pretended, found, None) == ({"noticed": 3, "survived": 0}, [])
    assert sum(mutants.look_at(source, 2, 1, pretended, found, None)[0].values()) == 2


def test_a_survivor_is_printed_as_the_lines_that_changed(tmp_path):
    source = tmp_path / "source.c"
    source.write_text("one\ntwo\nthree\n")
    assert mutants.change(source, "one\n2\nthree\n").splitlines()[1:] == ["-two", "+2"]
