"""Runs the commands of the README's console blocks again and writes what they print into the README.

usage: readme.py            (from anywhere; commands that start with one of RUN are run, others are left alone)
"""

import re
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
BLOCK = re.compile(r"(```console\n)(.*?)(```)", re.S)

RUN = ("build/", ".venv/bin/python scripts/claims.py", ".venv/bin/python scripts/restitution.py")


def split_block(text):
    """[command, printed text] pairs of one console block, which starts with a command."""
    parts = (part.partition("\n") for part in re.split(r"^\$ ", text, flags=re.M)[1:])
    return [[command, printed] for command, _, printed in parts]


def is_run(command):
    return command.startswith(RUN)


def run(command):
    """What the command prints on standard output."""
    return subprocess.run(command, shell=True, cwd=ROOT, capture_output=True, text=True, check=False).stdout


def refresh(match):
    lines = []
    for command, printed in split_block(match[2]):
        lines += [f"$ {command}\n", run(command) if is_run(command) else printed]
    return match[1] + "".join(lines) + match[3]


def main():
    path = ROOT / "README.md"
    path.write_text(BLOCK.sub(refresh, path.read_text()))


if __name__ == "__main__":
    main()
