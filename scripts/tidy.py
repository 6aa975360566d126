#!/usr/bin/env python3
"""clang-tidy over the sources given.

    tidy.py FILE...

Host tools and their tests are looked at in batches: one source that includes several of a folder, as their headers,
Eigen above all, take most of the time. Files that do not go together (names of their own that are the same) are looked
at one by one. Prints what clang-tidy found; exits with 1 if it found anything.
"""
import json
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from itertools import groupby
from pathlib import Path

BATCH = 8  # of 6, 8 and 12 the least time on two cores
FLAGS = ["-I.", "-isystem", "/usr/include/eigen3", "-DEIGEN_DONT_VECTORIZE", "-DEIGEN_RUNTIME_NO_MALLOC",
         "-DBERTH_WITH_SUNDIALS", "-DBERTH_WITH_ZLIB", '-DBERTH_COMMIT="lint"', "-D_GNU_SOURCE"]
OF_BATCHES = ["--header-filter=(firmware|hal|sim_hal|tests)/.*", "--checks=-bugprone-suspicious-include"]
NOT_TOGETHER = "clang-diagnostic-error"
FOLDER = Path("build/lint")


def tidy(source, *options):
    """(something was found, what clang-tidy printed) of one source."""
    standard = "-std=c11" if source.endswith(".c") else "-std=c++17"
    done = subprocess.run(["clang-tidy", "--quiet", *options, source, "--", standard, *FLAGS], capture_output=True,
                          text=True, check=False)
    return done.returncode != 0, done.stdout


def tidy_batch(number, sources):
    """The same of several sources of one folder, by a file that is not really there: it has the folder's settings."""
    if len(sources) == 1:
        return tidy(sources[0])
    batch = FOLDER / f"batch{number}.cpp"
    batch.write_text("".join(f'#include "{source}"\n' for source in sources))
    shown = Path(sources[0]).parent / batch.name
    overlay = FOLDER / f"batch{number}.json"
    overlay.write_text(json.dumps({"version": 0, "roots": [
        {"type": "file", "name": str(shown.absolute()), "external-contents": str(batch.absolute())}]}))
    found, printed = tidy(str(shown.absolute()), f"--vfsoverlay={overlay}", *OF_BATCHES)
    if NOT_TOGETHER not in printed:
        return found, printed
    one_by_one = [tidy(source) for source in sources]
    return any(found for found, _ in one_by_one), "".join(printed for _, printed in one_by_one)


def batches_of(sources):
    """Firmware and hal one by one: the static analyzer, which looks at them, takes its time by function."""
    host = sorted(s for s in sources if s.startswith(("sim_hal/", "tests/")) and s.endswith(".cpp")
                  and not s.startswith("tests/bench/"))
    alone = [s for s in sources if s not in host and (s.endswith(".cpp") or s.endswith(".c")) and "gpio_v2" not in s]
    made = [[source] for source in sorted(alone, key=os.path.getsize, reverse=True)]
    for _, of_folder in groupby(host, key=os.path.dirname):
        files = list(of_folder)
        made += [files[i:i + BATCH] for i in range(0, len(files), BATCH)]
    return made


def main():
    FOLDER.mkdir(parents=True, exist_ok=True)
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        results = list(pool.map(tidy_batch, *zip(*enumerate(batches_of(sys.argv[1:])))))
    for _, printed in results:
        sys.stdout.write(printed)
    sys.exit(any(found for found, _ in results))


if __name__ == "__main__":
    main()
