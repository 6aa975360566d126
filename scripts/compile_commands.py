#!/usr/bin/env python3
"""How each file is compiled, for editors and clangd: a compilation database of all C and C++ files of the repository.

    compile_commands.py C_COMMAND C++_COMMAND > compile_commands.json
"""
import json
import shlex
import sys
from pathlib import Path

FOLDERS = ("firmware", "hal", "sim_hal", "tests")
COMMANDS = {".c": 0, ".cpp": 1, ".h": 1}  # headers are read by C++ files, too
NOT_FOR_A_COMPILER = ("ccache", "-MMD", "-MP")


def entries(commands):
    """An entry for each file, in the order of their names."""
    top = Path.cwd()
    for source in sorted(path for folder in FOLDERS for path in Path(folder).rglob("*") if path.suffix in COMMANDS):
        words = [word for word in shlex.split(commands[COMMANDS[source.suffix]])
                 if Path(word).name not in NOT_FOR_A_COMPILER]
        language = ["-xc++"] if source.suffix == ".h" else []
        yield {"directory": str(top), "file": str(source), "arguments": [*words, *language, "-c", str(source)]}


if __name__ == "__main__":
    json.dump(list(entries(sys.argv[1:3])), sys.stdout, indent=1)
