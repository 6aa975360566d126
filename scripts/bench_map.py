#!/usr/bin/env python3
"""Times stability maps on one core: `berth map` beside numpy's LAPACK on the same matrices and python-control
building the same loop; and the cost of a point against the dead time.

Times are those of the processor, so that other programs on the machine do not count.
Prints a table and writes build/bench_map.json. Ends with 1 if a largest |z| is not ours to 1e-9; times only inform.
"""

import argparse
import json
import os
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path
from statistics import median

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before numpy

import control  # noqa: E402
import numpy as np  # noqa: E402
from loop_matrix import Loop, coupled_rigs, loop_matrices, plant  # noqa: E402

AGREES = 1e-9
NUMPY_AIM = 50.0
EXPONENT_AIM = 1.2  # near linear
ESS = Loop(rate_Hz=400, T_R=17.5e-3, T_S=2.5e-3)
DEAD_TIME_SAMPLES = (8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256, 400)
BATCH = 2000  # matrices that numpy gets at a time


def berth_map(*arguments):
    """`berth map` on one thread: its JSON, and its CSV as columns."""
    command = ["build/berth", "map", "ess", "--json", "--threads", "1", "--out", "build/bench", *map(str, arguments)]
    run = subprocess.run(command, capture_output=True, text=True)
    if run.returncode != 0:
        sys.exit(f"{' '.join(command)}\n{run.stderr}")
    result = json.loads(run.stdout)
    return result, np.loadtxt(result["csv"], delimiter=",", skiprows=1)


def numpy_radii(loop, vary, x, y):
    """Largest |z| at points of a map by numpy, and the seconds that eigvals took, without building the matrices."""
    radii, taken_s = [], 0.0
    for i in range(0, len(x), BATCH):
        matrices = loop_matrices(coupled_rigs(loop, vary, x[i:i + BATCH], y[i:i + BATCH]))
        start = time.process_time()
        eigenvalues = np.linalg.eigvals(matrices)
        taken_s += time.process_time() - start
        radii.append(np.abs(eigenvalues).max(axis=1))
    return np.concatenate(radii), taken_s


def control_radius(rig):
    """Largest |z| of one rig whose dead times are whole periods, python-control building and closing the loop."""
    T, samples = rig.T, round((rig.T_R + rig.T_S) / rig.T)
    A, b = plant(rig.arrays())
    # Straight between setpoints: first-order hold.
    hardware = control.sample_system(control.ss(A[0], b[0][:, None], [[0, 0, 1, 0]], 0), T, method="foh")
    arm = control.ss([[0, 1], [-rig.K / rig.M, -rig.D / rig.M]], [[0], [rig.k_S / rig.M]], [[1, 0]], 0)
    arm = control.sample_system(arm, T, method="zoh")
    delay = control.ss(np.eye(samples, k=-1), np.eye(samples, 1), np.eye(1, samples, samples - 1), 0, T)
    return np.abs(control.feedback(control.series(hardware, delay, arm), 1).poles()).max()


def compare(vary, points, rounds, control_points):
    """One map by all three: figures by name."""
    runs = [berth_map("--vary", vary, "--grid", f"{points}x{points}") for _ in range(rounds)]
    ours_s = median(run["compute_cpu_s"] for run, _ in runs)
    x, y, ours = runs[0][1][:, :3].T
    possible = np.isfinite(ours)
    x, y, ours = x[possible], y[possible], ours[possible]
    theirs, numpy_s = numpy_radii(ESS, vary, x, y)
    chosen = np.linspace(0, len(x) - 1, control_points).astype(int)
    rigs = coupled_rigs(ESS, vary, x[chosen], y[chosen])
    start = time.process_time()
    by_control = [control_radius(replace(ESS, k=k, m=m, d=d)) for k, m, d in zip(rigs.k, rigs.m, rigs.d)]
    control_s = time.process_time() - start
    return {"points": len(x), "ours_us": 1e6 * ours_s / len(x), "numpy_us": 1e6 * numpy_s / len(x),
            "control_us": 1e6 * control_s / control_points, "control_points": control_points,
            "times_numpy": numpy_s / ours_s,
            "times_control": control_s / control_points / (ours_s / len(x)),
            "difference_numpy": float(np.abs(ours / theirs - 1.0).max()),
            "difference_control": float(np.abs(ours[chosen] / by_control - 1.0).max())}


def dead_time_costs(points, rounds):
    """Cost of a point in us against samples of dead time, and numpy's up to where it takes too long."""
    rows = []
    for samples in DEAD_TIME_SAMPLES:
        T_R_ms = 2.5 * (samples - 1)
        runs = [berth_map("--vary", "elasticity", "--grid", f"{points}x{points}",
                          "--set", f"robot.dead_time_ms={T_R_ms}") for _ in range(rounds)]
        x, y, ours = runs[0][1][:, :3].T
        possible = np.flatnonzero(np.isfinite(ours))
        chosen = possible[np.linspace(0, len(possible) - 1, max(3, 1000 // samples)).astype(int)]
        loop = Loop(ESS.rate_Hz, T_R_ms * 1e-3, ESS.T_S)
        theirs, numpy_s = numpy_radii(loop, "elasticity", x[chosen], y[chosen])
        rows.append({"samples": samples, "searches": runs[0][0]["searches"],
                     "ours_us": 1e6 * median(r["compute_cpu_s"] for r, _ in runs) / len(possible),
                     "numpy_us": 1e6 * numpy_s / len(chosen),
                     "difference": float(np.abs(ours[chosen] / theirs - 1.0).max())})
    return rows


def exponent(rows, key):
    """Slope of the cost in the dead time, both logarithmic, least squares."""
    return float(np.polyfit(np.log([row["samples"] for row in rows]), np.log([row[key] for row in rows]), 1)[0])


def main():
    """Measures, prints, writes build/bench_map.json."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="small maps: figures are rough")
    quick = parser.parse_args().quick
    os.chdir(Path(__file__).resolve().parent.parent)
    Path("build/bench").mkdir(parents=True, exist_ok=True)
    cpu = max(os.sched_getaffinity(0))
    os.sched_setaffinity(0, {cpu})  # children too

    points, rounds = (20, 1) if quick else (200, 7)
    print(f"berth bench, stability maps: rig ess, {points} x {points} points on one core, CPU {cpu}; load average "
          f"{os.getloadavg()[0]:.1f}\n")
    print(f"  {'':12} {'berth':>9} {'numpy':>9} {'control':>10}   {'numpy':>9} {'control':>10}   "
          "largest difference of |z|")
    print(f"  {'':12} {'us/point':>9} {'us/point':>9} {'us/point':>10}   {'slower by':>9} {'slower by':>10}   "
          f"{'to numpy':>11} {'to control':>11}")
    maps = {}
    for vary in ("elasticity", "mass"):
        row = maps[vary] = compare(vary, points, rounds, 20 if quick else 100)
        print(f"  {vary:12} {row['ours_us']:9.3f} {row['numpy_us']:9.2f} {row['control_us']:10.1f}   "
              f"{row['times_numpy']:9.1f} {row['times_control']:10.0f}   {row['difference_numpy']:11.1e} "
              f"{row['difference_control']:11.1e}")
    print(f"  berth: rig to |z|, everything but the file. numpy {np.__version__}: linalg.eigvals alone, {BATCH} "
          f"matrices at a time,\n  OPENBLAS_NUM_THREADS=1. python-control {control.__version__}: blocks to poles, "
          f"{maps['mass']['control_points']} points of the map.\n")

    rows = dead_time_costs(20 if quick else 100, 1 if quick else 3)
    print(f"  {'dead time':>12} {'berth':>9} {'numpy':>10}   searches   largest difference of |z|")
    print(f"  {'samples':>12} {'us/point':>9} {'us/point':>10}")
    for row in rows:
        print(f"  {row['samples']:12d} {row['ours_us']:9.3f} {row['numpy_us']:10.1f}   {row['searches']:8d}   "
              f"{row['difference']:11.1e}")
    ours, theirs = exponent(rows, "ours_us"), exponent(rows, "numpy_us")
    print(f"  cost ~ samples^{ours:.2f} (numpy {theirs:.2f})\n\naims")
    aims = [(f"map of {vary}: {NUMPY_AIM:.0f} times numpy", f"{row['times_numpy']:.1f} times",
             row["times_numpy"] >= NUMPY_AIM) for vary, row in maps.items()]
    aims.append(("cost against dead time near linear", f"exponent {ours:.2f}", ours <= EXPONENT_AIM))
    for aim, figure, met in aims:
        print(f"  {aim:54} {figure:>14}   {'aim met' if met else 'MISSED'}")
    Path("build/bench_map.json").write_text(json.dumps(
        {"maps": maps, "dead_time": rows, "exponent": ours, "exponent_numpy": theirs,
         "aims": [{"aim": a, "figure": f, "met": m} for a, f, m in aims]}, indent=2) + "\n")

    worst = max([row[key] for row in maps.values() for key in ("difference_numpy", "difference_control")] +
                [row["difference"] for row in rows])
    if not worst <= AGREES:
        sys.exit(f"a largest |z| differs by {worst:.1e}, more than {AGREES:g}")


if __name__ == "__main__":
    main()
