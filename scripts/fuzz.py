#!/usr/bin/env python3
"""Feeds broken files to every reader of a file that somebody else wrote, under libFuzzer with sanitizers.

    fuzz.py [--seconds S] [PARSER...]     S seconds each, 60 by default; goes on where the last call ended
    fuzz.py --runs N [PARSER...]          the first N files of a fixed seed, with what `make test` has built

Whatever a file holds, berth says what is wrong with it or reads it: it does not crash, takes no more than 5 s and no
more than 1 GB. A file at which it does is kept; the line that repeats it is printed, and the exit code is 1.
build/fuzz/corpus has the files that found new ways through the code, build/fuzz/executions.json counts all runs.
"""

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
FOLDER = ROOT / "build" / "fuzz"
COMMITTED = ROOT / "tests" / "fuzz" / "corpus"
COUNTS = FOLDER / "executions.json"
FIXED_SEED = 1
# A short log has 34 kB.
LIMITS = ["-timeout=5", "-rss_limit_mb=1024", "-max_len=65536"]
SHIPPED = {"rig": "sim_hal/rigs/*.toml", "robot": "sim_hal/robots/*.toml", "arm": "sim_hal/arms/*.toml",
           "urdf": "tests/arms/*.urdf"}
SHORT_RUN = ["--set", "run.duration_s=0.05", "--no-advice"]


def parsers(program):
    """Their names, as the program lists them."""
    done = subprocess.run([program], capture_output=True, text=True, check=False)
    return re.search(r"NAME:(.*)", done.stderr).group(1).split()


def seeds(parser, folder):
    """Fills the folder with whole files of this kind; returns it."""
    folder.mkdir(parents=True)
    for path in [*(COMMITTED / parser).glob("*"), *ROOT.glob(SHIPPED.get(parser, "none"))]:
        shutil.copy(path, folder)
    if parser == "log":
        subprocess.run([ROOT / "build" / "berth", "run", "ess", *SHORT_RUN, "--out", folder], check=True,
                       stdout=subprocess.DEVNULL)
    return folder


def runs_in(told):
    """How many files libFuzzer tried."""
    counts = re.findall(r"^#(\d+)\s", told, re.MULTILINE) + re.findall(r"^Done (\d+) runs", told, re.MULTILINE)
    return max(map(int, counts), default=0)


def fuzz(program, parser, options, grows):
    """(runs, what went wrong or "") of one parser."""
    with tempfile.TemporaryDirectory() as scratch:
        corpora = [seeds(parser, Path(scratch) / "seeds")]
        if grows:
            (FOLDER / "corpus" / parser).mkdir(parents=True, exist_ok=True)
            corpora.insert(0, FOLDER / "corpus" / parser)
        else:  # what is new goes where it is forgotten
            corpora.insert(0, Path(scratch) / "new")
            corpora[0].mkdir()
        found = FOLDER / "found" / parser
        found.mkdir(parents=True, exist_ok=True)
        words = [program, f"--parser={parser}", *LIMITS, *options, f"-artifact_prefix={found}/", *corpora]
        done = subprocess.run(list(map(str, words)), cwd=ROOT, capture_output=True, text=True, errors="replace", check=False)
    if done.returncode == 0:
        return runs_in(done.stderr), ""
    kept = re.search(r"Test unit written to (\S+)", done.stderr)
    reason = re.search(r"^(?:SUMMARY|==\d+== ?ERROR): (.*)", done.stderr, re.MULTILINE)
    return runs_in(done.stderr), (f"{reason.group(1) if reason else done.stderr[-500:]}\n  repeat: "
                                  f"{os.path.relpath(program, ROOT)} --parser={parser} {kept.group(1) if kept else ''}")


def add_up(counted):
    """Adds these runs to all before and returns the sums."""
    total = json.loads(COUNTS.read_text()) if COUNTS.exists() else {}
    for parser, runs in counted.items():
        total[parser] = total.get(parser, 0) + runs
    FOLDER.mkdir(parents=True, exist_ok=True)
    COUNTS.write_text(json.dumps(total, indent=1) + "\n")
    return total


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parsers", nargs="*", metavar="PARSER")
    parser.add_argument("--seconds", type=int, default=60, help="of each parser")
    parser.add_argument("--runs", type=int, help="of each parser, with a fixed seed")
    given = parser.parse_args()
    program = ROOT / "build" / ("sanitize" if given.runs else "fuzz") / "parsers"
    if not program.exists():
        sys.exit(f"fuzz.py: {program} is not built; run `make fuzz`")
    names = parsers(program)
    wanted = given.parsers or names
    if unknown := set(wanted) - set(names):
        parser.error(f"no parser is called {', '.join(sorted(unknown))}; there are {', '.join(names)}")
    options = [f"-runs={given.runs}", f"-seed={FIXED_SEED}"] if given.runs else [f"-max_total_time={given.seconds}"]
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        results = dict(zip(wanted, pool.map(lambda name: fuzz(program, name, options, not given.runs), wanted)))
    total = {} if given.runs else add_up({name: runs for name, (runs, _) in results.items()})
    for name, (runs, wrong) in results.items():
        print(f"{name:14} {runs:>10} files{f', {total[name]} in all' if total else ''}: {wrong or 'read or refused'}")
    sys.exit(any(wrong for _, wrong in results.values()))


if __name__ == "__main__":
    main()
