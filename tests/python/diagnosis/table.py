"""A row of a table of records and what `berth diagnose` is to tell of them, and how a row is run.

    Row("play of 0.2 mm", robot(law=partial(play, gap=2e-4)), named("robot.backlash"), size("backlash_m", near(2e-4)))

To add a case, add a row to the test_*.py of its topic. Run one: pytest tests/python/diagnosis -k 'play and mm'.
"""

import json
from dataclasses import dataclass

import pytest
from checks import Told
from conftest import EXIT_DONE, EXIT_INPUT, command, settings
from recipes import Recipe, again, beside, record_in


@dataclass(init=False, repr=False)
class Row:
    """A case. `rig`: of the diagnosis, where the record has no rig.toml beside it; `given`: settings of that rig, as
    `--set`; `options`: further words, or a function that gives them; `slow`: it runs in `make full-test` alone."""

    name: str
    record: Recipe
    checks: tuple
    rig: str
    given: dict
    options: object
    slow: bool

    def __init__(self, name, record, *checks, rig="ess", given=None, options=(), slow=False):
        self.name, self.record, self.checks = name, record, checks
        self.rig, self.given, self.options, self.slow = rig, given or {}, options, slow

    def __repr__(self):
        return self.name

    def command(self, out):
        """The words of the diagnosis."""
        folder = self.record.folder()
        rig = folder / "rig.toml" if (folder / "rig.toml").exists() and self.rig == "ess" else self.rig
        options = self.options() if callable(self.options) else self.options
        return ["diagnose", record_in(folder), *folder.glob("second.csv"), "--rig", rig, *beside(folder),
                *settings(self.given), *options, "--out", out]

    def told(self, out):
        """Runs the diagnosis, which must not fail."""
        words = self.command(out)
        if "seed" in self.record.given and self.record.make.__name__ == "hidden":
            print(again(self.record))
        print("berth", *words)
        done = command(*words)
        assert done.returncode == EXIT_DONE, done.stderr.decode()
        truth = self.record.folder() / "truth.json"
        return Told(json.loads((out / "diagnosis.json").read_text()), done.stdout.decode(), out,
                    json.loads(truth.read_text()) if truth.exists() else {}, words[1])

    def check(self, out):
        told = self.told(out)
        print(told)
        for one in self.checks:
            print(f"check: {one.__qualname__}")
            one(told)


class Refused(Row):
    """A record that is refused: exit code 2, one line that holds the words and none of those in `without`, and nothing
    written."""

    def __init__(self, *words, without=(), **given):
        super().__init__(*words, **given)
        self.without = without

    def check(self, out):
        words = self.command(out)
        print("berth", *words)
        done = command(*words)
        message = done.stderr.decode()
        assert done.returncode == EXIT_INPUT and done.stdout == b"", message
        assert message.startswith("berth: ") and message.count("\n") == 1 and "internal error" not in message, message
        assert not out.exists()
        for text in self.checks:
            assert text.replace("{record}", str(words[1])).replace("{folder}", str(words[1].parent)) in message, message
        assert not any(text in message for text in self.without), message


def each(rows):
    """For `test_...(row, tmp_path)`: once for every row."""
    names = [row.name for row in rows]
    assert len(set(names)) == len(names), [name for name in names if names.count(name) > 1]
    return pytest.mark.parametrize("row", [pytest.param(row, id=row.name, marks=[pytest.mark.slow] * row.slow)
                                           for row in rows])
