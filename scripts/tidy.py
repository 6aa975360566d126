#!/usr/bin/env python3
"""clang-tidy over the sources given.

    tidy.py FILE...

C++ sources are looked at in batches, as batches.py makes them. Prints what clang-tidy found; exits with 1 if it found
anything. What was clean is remembered, by every byte that was read, as ccache does, and not looked at again:
~/.cache/berth/tidy ($XDG_CACHE_HOME), or with BERTH_TIDY_CACHE= not at all.
"""
import functools
import hashlib
import json
import os
import re
import subprocess
import sys
import sysconfig
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from batches import batches

FLAGS = ["-I.", "-isystem", "/usr/include/eigen3", "-DEIGEN_DONT_VECTORIZE", "-DEIGEN_RUNTIME_NO_MALLOC",
         "-DBERTH_WITH_SUNDIALS", "-DBERTH_WITH_ZLIB", "-DBERTH_WITH_URDF", '-DBERTH_COMMIT="lint"', "-D_GNU_SOURCE"]
PACKAGE = "sim_hal/python/"  # of Python's and nanobind's headers
PACKAGE_FLAGS = [word for folder in (sysconfig.get_paths()["include"],
                                     *Path(".venv").glob("lib/python3*/site-packages/nanobind/include"))
                 for word in ("-isystem", str(folder))]
FOLDER = Path("build/lint")
AT_ONCE = 40  # most of the time goes to headers: of the diagnosis, 26 files take as long as 8
AT_ONCE_OF_TESTS = 8  # their names go together no further
CLEAN = os.environ.get("BERTH_TIDY_CACHE", os.environ.get("XDG_CACHE_HOME", f"{Path.home()}/.cache") + "/berth/tidy")
ALONE = ("firmware/", "tests/bench/", "tests/peers/")  # of the firmware the analyzer takes most of the time; programs


@functools.cache
def digest(path):
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()


@functools.cache
def tool():
    """What decides besides what is read."""
    version = subprocess.run(["clang-tidy", "--version"], capture_output=True, text=True, check=True).stdout
    settings = sorted([*Path().glob(".clang-tidy"), *Path().glob("*/.clang-tidy")])
    return version + "".join(digest(path) for path in [*settings, __file__])


def place_if_clean(source, text, flags):
    """Where it is remembered that the source, whose text that file has, is clean; None: it does not compile."""
    done = subprocess.run(["clang", "-M", *flags, "-iquote", str(Path(source).parent), text], capture_output=True,
                          text=True, check=False)
    if done.returncode != 0:
        return None
    read = done.stdout.replace("\\\n", " ").split()[1:]
    key = "\n".join([tool(), source, *flags, *(f"{path} {digest(path)}" for path in read)])
    return Path(CLEAN) / hashlib.sha256(key.encode()).hexdigest()


def tidy(source, text=None):
    """(something was found, what clang-tidy printed, it was looked at now) of one source, whose text that file has,
    if not the source itself."""
    flags = ["-std=c11" if source.endswith(".c") else "-std=c++17", *FLAGS,
             *(PACKAGE_FLAGS if source.startswith(PACKAGE) else [])]
    clean = place_if_clean(source, text or source, flags) if CLEAN else None
    if clean and clean.exists():
        return False, "", False
    shown = []
    if text:
        source, overlay = str(Path(source).absolute()), Path(text).with_suffix(".json")
        overlay.write_text(json.dumps({"version": 0, "roots": [
            {"type": "file", "name": source, "external-contents": str(Path(text).absolute())}]}))
        shown = [f"--vfsoverlay={overlay}"]
    done = subprocess.run(["clang-tidy", "--quiet", *shown, source, "--", *flags], capture_output=True, text=True,
                          check=False)
    failed = done.returncode != 0
    if clean and not failed and not done.stdout:
        clean.parent.mkdir(parents=True, exist_ok=True)
        clean.touch()
    return failed, done.stdout or (done.stderr if failed else ""), True


def tidy_batch(name, sources):
    """The same of a batch: its sources one after another in a file, as the static analyzer and some checks pass over
    what is included, that is shown to clang-tidy in the sources' folder, for its settings and headers."""
    batch = FOLDER / name
    texts = [Path(source).read_text() for source in sources]
    batch.parent.mkdir(parents=True, exist_ok=True)
    batch.write_text("".join(texts))
    places = [f"{source}:{line + 1}" for source, text in zip(sources, texts) for line in range(text.count("\n"))]
    found, printed, now = tidy(name, str(batch))
    return found, re.sub(rf"\S*{name}:(\d+)", lambda place: places[int(place[1]) - 1], printed), now


def main():
    # What libgpiod 2 declares is not there where version 1 is installed; headers are looked at with what includes them.
    sources = [source for source in sys.argv[1:] if source.endswith((".c", ".cpp")) and "gpio_v2" not in source]
    alone = [source for source in sources if source.endswith(".c") or source.startswith(ALONE)]
    tests = {source for source in sources if source.startswith("tests/")}
    together = [*batches(set(sources) - set(alone) - tests, AT_ONCE), *batches(tests - set(alone), AT_ONCE_OF_TESTS)]
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        waiting = [pool.submit(tidy, source) for source in sorted(alone, key=os.path.getsize, reverse=True)]
        waiting += [pool.submit(tidy_batch, *batch) for batch in together]
    results = [result.result() for result in waiting]
    sys.stdout.write("".join(printed for _, printed, _ in results))
    before = sum(not now for _, _, now in results)
    print(f"clang-tidy: {len(results) - before} sources and batches looked at, {before} clean as before")
    sys.exit(any(found for found, _, _ in results))


if __name__ == "__main__":
    main()
