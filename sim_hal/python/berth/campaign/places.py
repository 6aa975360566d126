"""Where in a campaign file a key stands, which Python's TOML reader does not say, and errors that name the place."""
from __future__ import annotations

import difflib
import re
from collections.abc import Iterable

from ..errors import InputError

_HEADER = re.compile(r"\s*\[\[?([^\]]+)\]\]?")
_KEY = re.compile(r"""\s*((?:"[^"]*"|'[^']*'|[\w-]+)(?:\s*\.\s*(?:"[^"]*"|'[^']*'|[\w-]+))*)\s*=""")


def _plain(path: str) -> str:
    return re.sub(r"[\"'\s]", "", path)


class Places:
    """Lines of a file by key, "vary.object.mass_kg"."""

    def __init__(self, path: str, text: str):
        self.path = path
        self.lines: dict[str, int] = {}
        table = ""
        for number, line in enumerate(text.splitlines(), 1):
            if header := _HEADER.match(line):
                table = _plain(header[1])
                self.lines.setdefault(table, number)
            elif key := _KEY.match(line):
                self.lines.setdefault(".".join(filter(None, (table, _plain(key[1])))), number)

    def of(self, key: str) -> str:
        """"file:line" of the key, or of the table or inline table that it would stand in."""
        while key:
            if key in self.lines:
                return f"{self.path}:{self.lines[key]}"
            key = key.rpartition(".")[0]
        return self.path

    def error(self, key: str, message: str) -> InputError:
        place = self.of(key)
        return InputError(f"{place}: {key}: {message}", place, key)


def nearest(name: str, known: Iterable[str]) -> str:
    """"; the nearest known one is ..." or the list of all where none is near."""
    known = list(known)
    found = difflib.get_close_matches(name, known, 1, 0.5)
    return f"the nearest known one is {found[0]}" if found else f"there are {', '.join(known)}"
