"""Hides effects, lets `berth diagnose` look for them, and scores what it says.

    python tests/hidden_effects/score.py [--count 300] [--seed 1] [--short | --fixed] [--kind KIND]
        [--program build/berth] [--out DIR]

Writes score.json and score.md into DIR; exits with 1 if a bound is missed. What was cut short goes on where it ended,
from DIR/records.jsonl, if program and records are the same. --short: 12 records,
seeds from the date; few records cannot show a share, so a bound then fails only on a count that it makes improbable
(0.1 %), and only wrong names, false alarms and crashes decide. --fixed: the records of fixed_records.py, one of each
kind of hidden effect; every one of them must be told right.
"""

import argparse
import concurrent.futures
import datetime
import hashlib
import json
import os
import pathlib
import shutil
import subprocess
import sys
import traceback

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import diagnosis  # noqa: E402
import tally  # noqa: E402
from effects import LIBRARY, SIZES  # noqa: E402
from equivalents import inseparable_alone, inseparable_together  # noqa: E402
from fixed_records import FIXED  # noqa: E402
from generate import write  # noqa: E402
from judge import admits_ignorance, detectable, is_confident, judge, names_nothing, offered  # noqa: E402
from outside import OUTSIDE  # noqa: E402
from physics import Unstable  # noqa: E402
from scenario import draw  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]
TIMEOUT_s = 600
PATTERN = ["single", "fault_free", "single", "two", "single", "single", "outside", "single", "fault_free", "single",
           "single", "fault_free", "single", "two_of_one_block", "single", "single", "outside", "single", "fault_free",
           "single"]
A_TURN = 10  # records, of which one holds an effect that the library lacks


def plan(first_seed, count, pattern=PATTERN):
    """[(seed, kind, effect or None, size or None)]: every effect and size in turn, starting anywhere."""
    jobs, library, strange = [], list(LIBRARY), list(OUTSIDE)
    turn = first_seed % len(library)
    for i in range(count):
        kind, effect, size = pattern[i % len(pattern)], None, None
        if kind == "single":
            effect, size = library[turn % len(library)], list(SIZES)[(turn // len(library) + turn) % len(SIZES)]
            turn += 7  # so that a short run meets every block
        elif kind == "outside":
            effect = strange[(first_seed + i // A_TURN) % len(strange)]
        elif kind == "fault_free":
            effect = "none"
        jobs.append((first_seed + i, kind, effect, size))
    return jobs


def diagnose(program, folder, out, without=None):
    """Runs the program on a record's folder; (Diagnosis or None, what went wrong)."""
    words = [program, "diagnose", folder / "record.csv", "--rig", folder / "rig.toml", "--out", out]
    for name in ("validate", "standstill", "repeat"):
        if (folder / f"{name}.csv").exists():
            words += [f"--{name}", folder / f"{name}.csv"]
    words += ["--without", without] if without else []
    try:
        words = [str(word) for word in words]
        done = subprocess.run(words, capture_output=True, text=True, timeout=TIMEOUT_s, check=False)
    except subprocess.TimeoutExpired:
        return None, f"no answer in {TIMEOUT_s} s"
    except OSError as error:
        return None, str(error)
    if done.returncode != 0:
        return None, f"exit code {done.returncode}: {done.stderr.strip()[-300:]}"
    try:
        return diagnosis.read(out / "diagnosis.json"), None
    except diagnosis.BadDiagnosis as error:
        return None, str(error)


def inseparable_names(scenario, found, true):
    """The wrong names that this record cannot tell from the truth, of causes named outright or of several offered."""
    if not (is_confident(found) or found.verdict == "one_of"):
        return []
    told = {effect: {name: value for name, (value, _, _) in parameters.items()}
            for effect, parameters in found.parameters.items()}
    try:
        if len(found.causes) == len(scenario.effects):
            return inseparable_alone(scenario, sorted(offered(found) - set(true)), told)
        if not set(found.causes) & set(true):
            return inseparable_together(scenario, found.causes, found.alternatives, told)
    except Unstable:  # the loop with the other effects is none
        pass
    return []


def reproduction(seed, effect, size, kind):
    words = ("python tests/hidden_effects/generate.py "
             f"--seed {seed} --out build/hidden/{seed} --truth build/hidden-truth/{seed}")
    given = [("effect", effect), ("size", size), ("kind", kind)]
    return words + "".join(f" --{name} {value}" for name, value in given if value)


def score_one(job, program, work, leaves_out=True):
    """Makes, diagnoses and judges one record; a JSON object. `leaves_out`: a single effect is looked for a second time,
    with a library that lacks it."""
    seed, kind, effect, size = job
    folder, truth_folder, out = (pathlib.Path(work) / f"{name}-{seed}" for name in ("record", "truth", "out"))
    scenario = draw(seed, effect, size, kind)
    truth = write(scenario, folder, truth_folder)
    names = [entry["effect"] for entry in truth["effects"]]
    record = {
        "seed": seed, "kind": kind, "effect": names[0] if len(names) == 1 else None, "size": truth["size"],
        "noise": truth["noise"], "richer": truth["richer"], "label": " + ".join(names) or "fault-free",
        "visible": detectable(truth), "again": reproduction(seed, effect, size, kind),
        "detectability": {entry["effect"]: entry["detectability"] for entry in truth["effects"]},
    }
    found, error = diagnose(program, folder, out)
    if found is None:
        return record | {"outcome": "failed", "verdict": "none", "causes": [], "wrong_causes": [], "intervals": [],
                         "gain": None, "names_nothing": False, "error": error}
    inseparable = inseparable_names(scenario, found, names)
    record |= judge(truth, found, inseparable).as_json()
    record |= {"names_nothing": names_nothing(found), "inseparable": inseparable}
    if kind == "outside" and record["visible"]:
        record |= {"left_out_ok": admits_ignorance(found, inseparable),
                   "left_out": f"{found.verdict} {found.causes}"}
    if leaves_out and kind == "single" and record["visible"]:
        other, error = diagnose(program, folder, out.with_name(f"without-{seed}"), names[0])
        near = inseparable_names(scenario, other, names) if other else []
        record |= {"left_out_ok": other is not None and admits_ignorance(other, near),
                   "left_out": f"{other.verdict} {other.causes}" if other else error}
    if record["outcome"] in ("right", "quiet") and record.get("left_out_ok") is not False:
        for path in (folder, truth_folder, out, out.with_name(f"without-{seed}")):
            shutil.rmtree(path, ignore_errors=True)
    return record


def score_safely(job, program, work, leaves_out=True):
    """The same; where the scorer itself fails, a record that says so, so that the others are not lost."""
    try:
        return score_one(job, program, work, leaves_out)
    except Exception:
        return {"seed": job[0], "kind": job[1], "effect": None, "size": job[3], "noise": "", "richer": False,
                "label": f"{job[1]} {job[2] or ''}".strip(), "visible": False, "again": reproduction(job[0], job[2], job[3], job[1]),
                "detectability": {}, "outcome": "failed", "verdict": "none", "causes": [], "wrong_causes": [],
                "intervals": [], "gain": None, "names_nothing": False, "error": traceback.format_exc()}


class Journal:
    """The records so far, a line each, below a line that says of which program and plan."""

    def __init__(self, path, program, jobs):
        self.path = path
        digest = hashlib.sha256(pathlib.Path(program).read_bytes() + json.dumps(jobs).encode()).hexdigest()
        lines = path.read_text().splitlines(keepends=True) if path.exists() else []
        whole = [line for line in lines if line.endswith("\n")]
        is_same = bool(whole) and json.loads(whole[0]) == {"sha256": digest}
        self.records = [json.loads(line) for line in whole[1:]] if is_same else []
        path.write_text("".join(json.dumps(line) + "\n" for line in [{"sha256": digest}, *self.records]))

    def add(self, record):
        self.records.append(record)
        with self.path.open("a") as file:
            file.write(json.dumps(record) + "\n")


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1, help="of the first record")
    parser.add_argument("--short", action="store_true", help="12 records, seeds from the date")
    parser.add_argument("--fixed", action="store_true", help="one record of each kind of effect, all of which must be right")
    parser.add_argument("--kind", choices=sorted(set(PATTERN)), help="records of this kind alone")
    parser.add_argument("--program", default=str(ROOT / "build" / "berth"))
    parser.add_argument("--out", default=str(ROOT / "build" / "hidden_effects" / "score"))
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    return parser.parse_args()


def is_right(record):
    """As it must be in a fixed record: what is hidden is shown and named; where the library lacks it, that is said."""
    if record["kind"] == "fault_free":
        return record["names_nothing"]
    if record["kind"] == "outside":
        return bool(record.get("left_out_ok")) and record["outcome"] != "wrong"
    return record["outcome"] == "right" and bool(record["visible"])


def score_fixed(program, work, jobs_at_once):
    """Scores the fixed records; those that are not right. Seeds repeat, and each record has a folder of its own."""
    def made(folder):
        folder.mkdir(parents=True, exist_ok=True)
        return folder

    with concurrent.futures.ProcessPoolExecutor(jobs_at_once) as pool:
        pending = [pool.submit(score_safely, job, program, made(work / str(n)), False) for n, job in enumerate(FIXED)]
        records = [done.result() for done in concurrent.futures.as_completed(pending)]
    bad = [r for r in records if not is_right(r)]
    for r in bad:
        print(f"WRONG: {r['label']}: {r['outcome']}, {r['verdict']} {', '.join(r['causes']) or 'nothing'}"
              f"{'; ' + r['error'] if r.get('error') else ''}\n  again: {r['again']}")
    print(f"{len(records) - len(bad)} of {len(records)} fixed records are told right")
    return bad


def main():
    given = arguments()
    if given.fixed:
        work = pathlib.Path(given.out).with_name("fixed")
        sys.exit(1 if score_fixed(given.program, work, given.jobs) else 0)
    if given.short:
        given.count, given.seed = 12, int(datetime.date.today().strftime("%Y%m%d")) * 100
    work = pathlib.Path(given.out)
    work.mkdir(parents=True, exist_ok=True)
    print(f"{given.count} records from seed {given.seed} on; again: "
          f"python tests/hidden_effects/score.py --count {given.count} --seed {given.seed}"
          + (f" --kind {given.kind}" if given.kind else ""), flush=True)
    jobs = plan(given.seed, given.count, [given.kind] if given.kind else PATTERN)
    journal = Journal(work / "records.jsonl", given.program, jobs)
    known = {r["seed"] for r in journal.records}
    with concurrent.futures.ProcessPoolExecutor(given.jobs) as pool:
        pending = [pool.submit(score_safely, job, given.program, work) for job in jobs if job[0] not in known]
        for done in concurrent.futures.as_completed(pending):
            r = done.result()
            journal.add(r)
            print(f"  {len(journal.records):4d} seed {r['seed']} {r['label']}: {r['outcome']} ({r['verdict']} "
                  f"{', '.join(r['causes'])})", flush=True)
    records = journal.records
    records.sort(key=lambda r: r["seed"])
    bounds = tally.bounds(records)
    content = {"bounds": [b.as_json(given.short) for b in bounds], "records": records}
    (work / "score.json").write_text(json.dumps(content, indent=1) + "\n")
    (work / "score.md").write_text(tally.markdown(records, given.short))
    print(tally.markdown(records, given.short))
    decisive = [b for b in bounds if b.name in tally.HARMFUL] if given.short else bounds
    crashed = any(r["outcome"] == "failed" for r in records)
    sys.exit(0 if all(b.is_met(given.short) for b in decisive) and not crashed else 1)


if __name__ == "__main__":
    main()
