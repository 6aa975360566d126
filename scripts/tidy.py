#!/usr/bin/env python3
"""clang-tidy over the sources given.

    tidy.py FILE...

C++ sources are looked at in batches, as batches.py makes them. Prints what clang-tidy found; exits with 1 if it found anything.
"""
import json
import os
import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from batches import batches

FLAGS = ["-I.", "-isystem", "/usr/include/eigen3", "-DEIGEN_DONT_VECTORIZE", "-DEIGEN_RUNTIME_NO_MALLOC",
         "-DBERTH_WITH_SUNDIALS", "-DBERTH_WITH_ZLIB", "-DBERTH_WITH_URDF", '-DBERTH_COMMIT="lint"', "-D_GNU_SOURCE"]
FOLDER = Path("build/lint")
ALONE = ("firmware/", "tests/bench/")  # of the firmware the analyzer takes most of the time; benchmarks are programs


def tidy(source, *options):
    """(something was found, what clang-tidy printed) of one source."""
    standard = "-std=c11" if source.endswith(".c") else "-std=c++17"
    done = subprocess.run(["clang-tidy", "--quiet", *options, source, "--", standard, *FLAGS], capture_output=True,
                          text=True, check=False)
    failed = done.returncode != 0
    return failed, done.stdout or (done.stderr if failed else "")


def tidy_batch(name, sources):
    """The same of a batch: its sources one after another in a file, as the static analyzer and some checks pass over
    what is included, that is shown to clang-tidy in the sources' folder, for its settings and headers."""
    batch, overlay = FOLDER / name, (FOLDER / name).with_suffix(".json")
    texts = [Path(source).read_text() for source in sources]
    batch.parent.mkdir(parents=True, exist_ok=True)
    batch.write_text("".join(texts))
    overlay.write_text(json.dumps({"version": 0, "roots": [
        {"type": "file", "name": str(Path(name).absolute()), "external-contents": str(batch.absolute())}]}))
    places = [f"{source}:{line + 1}" for source, text in zip(sources, texts) for line in range(text.count("\n"))]
    found, printed = tidy(str(Path(name).absolute()), f"--vfsoverlay={overlay}")
    return found, re.sub(rf"\S*{name}:(\d+)", lambda place: places[int(place[1]) - 1], printed)


def main():
    # What libgpiod 2 declares is not there where version 1 is installed; headers are looked at with what includes them.
    sources = [source for source in sys.argv[1:] if source.endswith((".c", ".cpp")) and "gpio_v2" not in source]
    alone = [source for source in sources if source.endswith(".c") or source.startswith(ALONE)]
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        results = [pool.submit(tidy, source) for source in sorted(alone, key=os.path.getsize, reverse=True)]
        results += [pool.submit(tidy_batch, *batch) for batch in batches(set(sources) - set(alone))]
    for result in results:
        sys.stdout.write(result.result()[1])
    sys.exit(any(result.result()[0] for result in results))


if __name__ == "__main__":
    main()
