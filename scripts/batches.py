#!/usr/bin/env python3
"""Sources of one folder in batches, each read by the compiler as one, as headers, Eigen's above all, take most of the
time.

    batches.py FOLDER FILE...

Writes FOLDER/sim_hal/cli/batch1.cpp and so on, which include the files, those of a folder sorted and shared evenly,
and prints sim_hal/cli/batch1.cpp: a batch goes by the name that it would have among its files. Batches that have not
changed are left as they are. Names in the files of a folder must go together; the compiler tells when they do not.
"""
import sys
from itertools import groupby
from math import ceil
from pathlib import Path

AT_ONCE = 8


def batches(sources, at_once=AT_ONCE):
    """(name, sources) of each batch."""
    in_order = sorted(map(Path, sources), key=lambda source: (source.parent, source))
    for folder, of_folder in groupby(in_order, key=lambda source: source.parent):
        files = list(of_folder)
        count = ceil(len(files) / at_once)
        for i in range(count):
            yield f"{folder}/batch{i + 1}.cpp", files[len(files) * i // count:len(files) * (i + 1) // count]


def write(path, sources):
    text = "".join(f'#include "{source}"\n' for source in sources)
    if not path.exists() or path.read_text() != text:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)


def main():
    for name, sources in batches(sys.argv[2:]):
        write(Path(sys.argv[1]) / name, sources)
        print(name)


if __name__ == "__main__":
    main()
