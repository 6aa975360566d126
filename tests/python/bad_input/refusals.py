"""What a user can get wrong, as rows: a command line, the files that it reads, and words that the one message must hold.

    Bad("a step of 0", ["map", "ess", "--step", "0"], "--step", "greater than 0")
    Bad("a profile of text", ["run", "ess", "--profile", "{p.csv}"], "{p.csv}:3: ", "finite", files={"p.csv": "t_s,x\\n..."})

`{p.csv}` stands for the path of that file, `{out}` for a folder that must not be there afterwards.
"""

import re
from dataclasses import dataclass, field

import pytest
from conftest import BERTH, EXIT_INPUT, command


LENGTH_MAX = 600  # of a message with the paths of a test in it


@dataclass(init=False, repr=False)
class Bad:
    """A case. `says`: words of the message, each with what is in braces put in; `files`: {name: text or bytes} to write
    first; `program`: another one than `berth`; `starts`: how the message starts; `also`: further command lines, which must
    give the same message."""

    name: str
    arguments: list
    says: tuple
    files: dict = field(default_factory=dict)
    program: tuple = (BERTH,)
    starts: str = ""
    also: tuple = ()

    def __init__(self, name, arguments, *says, files=None, program=(BERTH,), starts="", also=()):
        self.name, self.arguments, self.says, self.files, self.program = name, arguments, says, files or {}, program
        self.starts, self.also = starts, also

    def check(self, folder):
        for name, content in self.files.items():
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content if isinstance(content, bytes) else content.encode())

        def placed(text):
            return re.sub(r"\{([\w./-]+)\}", lambda match: str(folder / match[1]), str(text))

        message = refusal(*[placed(word) for word in self.arguments], program=self.program)
        assert message.startswith(placed(self.starts)), message
        for text in self.says:
            assert placed(text) in message, message
        for words in self.also:
            assert refusal(*[placed(word) for word in words], program=self.program) == message
        assert not (folder / "out").exists(), list((folder / "out").rglob("*"))


def refusal(*arguments, program=(BERTH,), **options):
    """Runs and checks everything that every refusal has in common; the message."""
    done = command(*arguments, program=program, **options)
    message = done.stderr.decode(errors="replace")
    print(message)
    assert done.returncode == EXIT_INPUT, (done.returncode, message)
    assert done.stdout == b""
    assert message.startswith("berth: ") and message.count("\n") == 1 and "internal error" not in message, message
    assert len(message) < LENGTH_MAX, message
    return message


def each(rows):
    """For `test_...(row, tmp_path)`: once for every row."""
    names = [row.name for row in rows]
    assert len(set(names)) == len(names), [name for name in names if names.count(name) > 1]
    return pytest.mark.parametrize("row", [pytest.param(row, id=row.name) for row in rows])
