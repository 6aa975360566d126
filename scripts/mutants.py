#!/usr/bin/env python3
"""How many small mistakes in the firmware the C++ tests notice: changes one line at a time and runs them.

    mutants.py [--count N] [--seed S] [FILE...]      FILE: of the firmware, in C; else the safety units

A mutant is a line changed by a rule of universalmutator (another operator, a condition turned round, a statement left
out). The tests are those with sanitizers, which see an index out of bounds. Mutants that the compiler refuses or makes
the same code of are not counted. Of each file N are drawn; what was found stays in build/mutants/found.json, so that a
second call goes on where the first one ended, and tries survivors again. Survivors are printed: either a test is
missing, or the mutant does the same in other words.
"""

import argparse
import difflib
import hashlib
import json
import os
import random
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
FOLDER = ROOT / "build" / "mutants"
SAFETY_UNITS = ("supervisor", "limits", "reception", "robot_channel", "sensor_channel", "cia402", "cia402_setup",
                "side_axes")
TESTS = ("*unit/*", "*contract/*", "*scenarios/*")
AT_MOST_s = 120  # a mutant that never ends is noticed, too
FASTER_LINKER = ["-fuse-ld=mold"] if shutil.which("mold") else []
RULES = "universalmutator==1.14.1"


def run(words, **more):
    return subprocess.run(list(map(str, words)), cwd=ROOT, capture_output=True, check=False, **more)


def mutate_program():
    """The generator has an environment of its own: it needs a dozen packages that nothing else does."""
    python = FOLDER / "venv" / "bin" / "python"
    if not python.exists():
        subprocess.run([sys.executable, "-m", "venv", python.parent.parent], check=True)
        subprocess.run([python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", RULES], check=True)
    return python.with_name("mutate")


def texts_of(source, program):
    """The file's text in every mutant, in a fixed order."""
    folder = FOLDER / "texts" / source.stem
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.iterdir():
        old.unlink()
    subprocess.run([program, source, "--noCheck", "--mutantDir", folder], check=True, stdout=subprocess.DEVNULL)
    return sorted({path.read_text() for path in folder.iterdir()})


class Build:
    """The C++ tests, linked once more for each mutant."""

    def __init__(self, command):
        self.compile, link = (shlex.split(line) for line in command.splitlines())
        self.link, self.objects = link[:link.index("--")], link[link.index("--") + 1:]

    def code(self, source, text, name):
        """The object's file, or None if the text cannot be compiled."""
        made = FOLDER / name
        done = run([*self.compile, "-g0", "-w", "-iquote", source.parent, "-x", "c", "-c", "-", "-o", made],
                   input=text.encode())
        return made if done.returncode == 0 else None

    def tests_with(self, source, made):
        own = f"/{source.relative_to(ROOT)}.o"
        objects = [made if word.endswith(own) else word for word in self.objects]
        assert made in objects, f"{source}: is not linked into the tests"
        program = FOLDER / "cpp_tests"
        done = run([*self.link, *FASTER_LINKER, "-o", program, *objects])
        assert done.returncode == 0, done.stderr.decode()
        return program


def is_noticed(program):
    words = [program, "--abort-after=1", f"--source-file={','.join(TESTS)}"]
    try:
        return run(words, timeout=AT_MOST_s).returncode != 0
    except subprocess.TimeoutExpired:
        return True


def change(source, text):
    """The changed lines, as in a diff."""
    lines = difflib.unified_diff(source.read_text().splitlines(), text.splitlines(), n=0, lineterm="")
    return "\n".join(line for line in lines if line[:3] not in ("---", "+++"))


def judge(build, source, text, original):
    """"same", "refused", "noticed" or "survived"."""
    made = build.code(source, text, "mutant.o")
    if made is None:
        return "refused"
    if made.read_bytes() == original:
        return "same"
    return "noticed" if is_noticed(build.tests_with(source, made)) else "survived"


def look_at(source, count, seed, build, found, program):
    texts = texts_of(source, program)
    random.Random(f"{seed} {source.name}").shuffle(texts)
    original = build.code(source, source.read_text(), "original.o").read_bytes()
    counts, survivors = {"noticed": 0, "survived": 0}, []
    for text in texts:
        if sum(counts.values()) == count:
            break
        key = hashlib.sha256(f"{source.name}\n{text}".encode()).hexdigest()[:16]
        if found.get(key, "survived") == "survived":  # there may be another test by now
            found[key] = judge(build, source, text, original)
            (FOLDER / "found.json").write_text(json.dumps(found))
        if found[key] in counts:
            counts[found[key]] += 1
            survivors += [text] if found[key] == "survived" else []
    return counts, survivors


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="*", type=Path)
    parser.add_argument("--count", type=int, default=25, help="mutants of each file")
    parser.add_argument("--seed", type=int, default=20261)
    given = parser.parse_args()
    FOLDER.mkdir(parents=True, exist_ok=True)
    sources = [ROOT / path for path in given.files] or [ROOT / "firmware" / f"{name}.c" for name in SAFETY_UNITS]
    command = run(["make", "SANITIZE=1", "WERROR=1", "mutants-command"], env=os.environ | {"MAKEFLAGS": ""})
    assert command.returncode == 0, command.stderr.decode()
    build = Build("\n".join(command.stdout.decode().splitlines()[-2:]))
    program = mutate_program()
    kept = FOLDER / "found.json"
    found = json.loads(kept.read_text()) if kept.exists() else {}
    total = {"noticed": 0, "survived": 0}
    for source in sources:
        counts, survivors = look_at(source, given.count, given.seed, build, found, program)
        share = 100 * counts["noticed"] / max(1, sum(counts.values()))
        print(f"{source.relative_to(ROOT)}: {counts['noticed']} of {sum(counts.values())} noticed, {share:.0f} %")
        for text in survivors:
            print("  survived " + change(source, text).replace("\n", "\n           "), flush=True)
        for name in total:
            total[name] += counts[name]
    print(f"in all: {total['noticed']} of {sum(total.values())} noticed; seed {given.seed}")


if __name__ == "__main__":
    main()
