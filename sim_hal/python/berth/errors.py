"""What goes wrong with what a user gave."""
import re

from . import _core


class InputError(ValueError):
    """A rig, a record or a log is not as it must be. `str()` is one line for a person; the parts are for a program.

    place   the file, "file:line" or the setting; empty where the line names none
    file    the file alone, and `line` its line, counted from 1, or None
    key     the key of the rig file, "object.mass_kg"; empty where the line names none
    remedy  what to do about it: what follows the last semicolon; empty where there is nothing else to say
    """

    def __init__(self, message, place="", key=""):
        super().__init__(message)
        self.place, self.key = place, key
        found = re.fullmatch(r"(.*?)(?::(\d+))?", place, re.DOTALL)
        self.file = "" if place.startswith("--") else found[1]
        self.line = int(found[2]) if found[2] else None
        self.remedy = message.rpartition("; ")[2] if "; " in message else ""


_core.raise_as(InputError)
