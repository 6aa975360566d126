#!/usr/bin/env python3
"""Times a diagnosis on one core: `berth diagnose` beside the same diagnosis written with scipy's least_squares, on a
simulator compiled by numba and on solve_ivp; and its cost against the length of the record.

Times are those of the processor, so that other programs on the machine do not count.
Prints a table and writes build/bench_diagnose.json. Ends with 1 if cause or value differ; times only inform.
"""

import argparse
import json
import os
import resource
import subprocess
import sys
import time
import tomllib
from pathlib import Path
from statistics import median

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before numpy

import numba  # noqa: E402
import numpy as np  # noqa: E402
import scipy  # noqa: E402
from diagnosis_peer import BASE, PeerDiagnosis, Record, parameters_of  # noqa: E402

RIG, FOLDER = "ess", Path("build/bench/diagnosis")
HIDDEN, HIDDEN_KEY, HIDDEN_BY_PEER = "robot.backlash", "robot.backlash_m", "robot_backlash"
HIDDEN_SIZE_M, FORCE_NOISE_N = 2e-4, 0.2
LENGTH_S, LENGTHS_S = 60, (10, 20, 40, 60, 120)
AGREES = 0.01  # of berth's value
SIMULATIONS_AGREE = 0.5  # of the force's noise: solve_ivp's and numba's
SECONDS_AIM, EXPONENT_AIM = 2.0, 1.2  # near linear


def berth(*arguments):
    """Standard output of a command of berth and the processor's seconds that it took; ends the bench if it fails."""
    command = ["build/berth", *map(str, arguments)]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    run = subprocess.run(command, capture_output=True, text=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if run.returncode != 0:
        sys.exit(f"{' '.join(command)}\n{run.stdout}{run.stderr}")
    return run.stdout, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def make_record(length_s):
    """A run with the hidden effect: noise on force and feedback, an operator who moves freely. Its log."""
    out = FOLDER / f"{length_s}s"
    settings = {HIDDEN_KEY: HIDDEN_SIZE_M, "robot.feedback_noise_m": 5e-6, "sensor.noise_N": FORCE_NOISE_N,
                "profile.kind": "multisine", "profile.amplitude_m": 0.01, "profile.duration_s": length_s,
                "run.duration_s": length_s}
    berth("run", RIG, "--out", out, *[part for key, value in settings.items() for part in ("--set", f"{key}={value}")])
    return out / f"{RIG}.ulg"


def diagnose(log, rounds):
    """Its diagnosis, and the median of the processor's seconds."""
    runs = [berth("diagnose", log, "--rig", RIG, "--out", log.parent, "--json") for _ in range(rounds)]
    return json.loads(runs[0][0]), median(seconds for _, seconds in runs)


def berth_row(log, rounds):
    """Berth's row of the table."""
    found, seconds = diagnose(log, rounds)
    causes = [(cause["effect"], cause["parameters"][0]["value"]) for cause in found["causes"]]
    effects = sum(len(block["tried"]) for block in found["blocks"])
    return {"seconds": seconds, "effects": effects, "causes": causes}


def peer_rows(log, rig):
    """Both peers' rows; what goes before the fits is not counted: reading the record and compiling."""
    period = 1.0 / rig["loop"]["rate_Hz"]
    record = Record.of_series(log.parent / "series.csv", period)
    start = time.process_time()
    warm = PeerDiagnosis(record, parameters_of(rig))
    for block in BASE:
        warm.simulate(block, warm.p)
    compile_s = time.process_time() - start

    peer = PeerDiagnosis(record, parameters_of(rig))
    start = time.process_time()
    results = peer.run()
    seconds = time.process_time() - start
    causes = [(result.cause.effect, result.cause.values) for result in results.values() if result.cause]
    effects = sum(len(result.ranking) for result in results.values())
    fits = sum(2 * len(result.ranking) + 1 for result in results.values())
    simulations = {block: result.simulations for block, result in results.items()}

    peer.simulate("force", peer.p)
    start = time.process_time()
    force = peer.force_by_solve_ivp()
    by_solve_ivp_s = time.process_time() - start
    start = time.process_time()
    peer.simulate("force", peer.p)
    compiled_s = time.process_time() - start
    return {
        "numba": {"seconds": seconds, "effects": effects, "causes": [(name, values[HIDDEN_BY_PEER]) if name == HIDDEN
                                                                     else (name, None) for name, values in causes],
                  "compile_s": compile_s, "fits": fits, "simulations": simulations},
        "solve_ivp": {"seconds": seconds + simulations["force"] * (by_solve_ivp_s - compiled_s), "effects": effects,
                      "one_simulation_s": by_solve_ivp_s,
                      "differs_by_N": float(np.sqrt(np.mean((force - peer.force)**2)))},
    }


def exponent(seconds):
    """Slope of the cost in the record's length, both logarithmic, least squares."""
    return float(np.polyfit(np.log(list(seconds)), np.log(list(seconds.values())), 1)[0])


def print_rows(rows, length_s, rounds):
    """The table of the three programs."""
    ours = rows["berth"]
    print(f"  {'':36} {'CPU s':>9} {'effects':>8} {'s/effect':>9} {'slower by':>10} {'an effect':>10}")
    for name, title in (("berth", "berth diagnose"), ("numba", "least_squares, numba"),
                        ("solve_ivp", "least_squares, solve_ivp (estimate)")):
        row = rows[name]
        print(f"  {title:36} {row['seconds']:9.2f} {row['effects']:8d} {row['seconds'] / row['effects']:9.3f}"
              f" {row['times_slower']:10.1f} {row['times_slower_an_effect']:10.1f}")
    numba_row, ivp = rows["numba"], rows["solve_ivp"]
    print(f"  berth: median of {rounds}, from the log to the report's files, with screening, held-out data, a second "
          f"search,\n  the verdict. The peer: {numba_row['fits']} fits, {sum(numba_row['simulations'].values())} "
          f"simulations, each effect once with the base model from two starts,\n  ranked by BIC; its "
          f"{numba_row['compile_s']:.1f} s to compile and reading the record are not counted. numba "
          f"{numba.__version__}, scipy {scipy.__version__}.\n"
          f"  solve_ivp: extrapolated. Its one simulation of the force over {length_s} s (LSODA, compiled right-hand "
          f"side) took\n  {ivp['one_simulation_s']:.1f} s, times the {numba_row['simulations']['force']} of the fits "
          f"above; it is {ivp['differs_by_N']:.3f} N rms from numba's.")
    for name in ("berth", "numba"):
        told = ", ".join(f"{effect} = {value:.6g} m" for effect, value in rows[name]["causes"] if value is not None)
        print(f"  {name:9} names {told}")


def disagreements(rows):
    """What of the work was not the same, in words; the hidden size itself is the truth for both."""
    wrong = []
    for name in ("berth", "numba"):
        if [effect for effect, _ in rows[name]["causes"]] != [HIDDEN]:
            wrong.append(f"{name} names {rows[name]['causes']} and not {HIDDEN} alone")
    if not wrong:
        ours, theirs = (rows[name]["causes"][0][1] for name in ("berth", "numba"))
        if not abs(theirs / ours - 1.0) <= AGREES or not abs(ours / HIDDEN_SIZE_M - 1.0) <= AGREES:
            wrong.append(f"{HIDDEN_KEY}: {ours} by berth, {theirs} by the peer, {HIDDEN_SIZE_M} in truth")
    if not rows["solve_ivp"]["differs_by_N"] <= SIMULATIONS_AGREE * FORCE_NOISE_N:
        wrong.append(f"solve_ivp's force is {rows['solve_ivp']['differs_by_N']:.3g} N rms from numba's")
    return wrong


def main():
    """Measures, prints, writes build/bench_diagnose.json."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="short records, run once: figures are rough")
    quick = parser.parse_args().quick
    os.chdir(Path(__file__).resolve().parent.parent)
    cpu = max(os.sched_getaffinity(0))
    os.sched_setaffinity(0, {cpu})  # children too

    length_s, lengths_s, rounds = (10, (5, 10), 1) if quick else (LENGTH_S, LENGTHS_S, 3)
    rig = tomllib.loads(berth("run", RIG, "--print-config")[0])
    print(f"berth bench, diagnosis: a record of rig {RIG}, {length_s} s at {rig['loop']['rate_Hz']:g} Hz, with "
          f"{HIDDEN}; one core, CPU {cpu};\nload average {os.getloadavg()[0]:.1f}\n")
    logs = {length: make_record(length) for length in lengths_s}
    rows = {"berth": berth_row(logs[length_s], rounds), **peer_rows(logs[length_s], rig)}
    ours = rows["berth"]
    for row in rows.values():
        row["times_slower"] = row["seconds"] / ours["seconds"]
        row["times_slower_an_effect"] = row["times_slower"] * ours["effects"] / row["effects"]
    print_rows(rows, length_s, rounds)

    seconds = {length: diagnose(log, rounds)[1] for length, log in logs.items()}
    print(f"\n  {'record':>8} {'CPU s':>7}")
    for length, taken in seconds.items():
        print(f"  {length:6d} s {taken:7.2f}")
    slope = exponent(seconds)
    print(f"  cost ~ length^{slope:.2f}\n\naims")
    aims = [(f"diagnosis of {length_s} s: below {SECONDS_AIM:g} s on one core", f"{ours['seconds']:.2f} s",
             ours["seconds"] < SECONDS_AIM),
            ("cost against the record's length near linear", f"exponent {slope:.2f}", slope <= EXPONENT_AIM)]
    for aim, figure, met in aims:
        print(f"  {aim:54} {figure:>14}   {'aim met' if met else 'MISSED'}")
    Path("build/bench_diagnose.json").write_text(json.dumps(
        {"rows": rows, "seconds_by_length_s": seconds, "exponent": slope,
         "aims": [{"aim": a, "figure": f, "met": m} for a, f, m in aims]}, indent=2) + "\n")

    if wrong := disagreements(rows):
        sys.exit("the peer does not do the same work: " + "; ".join(wrong))


if __name__ == "__main__":
    main()
