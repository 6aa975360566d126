"""Runs the commands of the Markdown pages' console blocks again, writes what they print into the pages, and renews the pages'
pictures.

usage: readme.py [PAGE...]     (default: README.md and every page of the documentation)

Commands that start with one of RUN are run, others are left alone. A line that ends in a backslash goes on in the next.
A block of a file, whose first line is `# build/NAME`, is written to that path before the page's commands are run.
A picture comes from the file of the comment `<!-- build/NAME.png -->` before it, which the page's commands write.
"""

import re
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
FOLDERS = ("firmware", "hal", "sim_hal", "tests", "scripts")
BLOCK = re.compile(r"(```console\n)(.*?)(```)", re.S)
FILE_BLOCK = re.compile(r"```(?:toml|csv|python)\n# (build/\S+)\n(.*?)```", re.S)
PICTURE = re.compile(r"<!-- (build/\S+\.png) -->\n\n!\[[^\]]*\]\(([^)\s]+)\)")
FOOTER = 0.03  # share of a picture's height, at its foot: commit and hashes, which may differ
COMMAND = re.compile(r"^\$ ((?:.*\\\n)*.*)\n?", re.M)

RUN = ("build/", ".venv/bin/python scripts/", ".venv/bin/python build/")


def pages():
    """README.md and the pages, in a fixed order; none of hidden folders, as tools leave them."""
    found = (page for folder in FOLDERS for page in (ROOT / folder).rglob("*.md"))
    return [ROOT / "README.md"] + sorted(page for page in found if "/." not in str(page.relative_to(ROOT)))


def split_block(text):
    """[command, printed text] pairs of one console block, which starts with a command."""
    parts = COMMAND.split(text)[1:]
    return [list(pair) for pair in zip(parts[::2], parts[1::2])]


def is_run(command):
    return command.startswith(RUN)


def run(command):
    """What the command prints on standard output."""
    return subprocess.run(command, shell=True, cwd=ROOT, capture_output=True, text=True, check=False).stdout


def write_files(text):
    """The files that a page tells its reader to write."""
    for path, content in FILE_BLOCK.findall(text):
        (ROOT / path).parent.mkdir(parents=True, exist_ok=True)
        (ROOT / path).write_text(content)


def pictures(page):
    """[(file that the page's commands write, picture of the page)] of a page."""
    return [(ROOT / made, (page.parent / shown).resolve()) for made, shown in PICTURE.findall(page.read_text())]


def differing_pixels(made, shown):
    """How many pixels of two pictures differ visibly, without their footer; all if they differ in size."""
    from matplotlib.image import imread  # takes a second, which other users of this module need not wait for
    one, other = imread(made)[..., :3], imread(shown)[..., :3]
    if one.shape != other.shape:
        return one.size
    return int(((abs(one - other).max(axis=2) > 0.2)[:round((1 - FOOTER) * len(one))]).sum())


def refresh(match):
    lines = []
    for command, printed in split_block(match[2]):
        lines += [f"$ {command}\n", run(command) if is_run(command) else printed]
    return match[1] + "".join(lines) + match[3]


def main():
    for path in [Path(word).resolve() for word in sys.argv[1:]] or pages():
        write_files(path.read_text())
        path.write_text(BLOCK.sub(refresh, path.read_text()))
        for made, shown in pictures(path):
            if not shown.exists() or differing_pixels(made, shown):
                shutil.copy(made, shown)
                print(f"{shown.relative_to(ROOT)}: new, from {made.relative_to(ROOT)}")


if __name__ == "__main__":
    main()
