#!/usr/bin/env python3
"""Compares what berth computes with independent oracles: closed forms, numpy on the loop's definitions, CVODE.

One line each: what, our number, theirs, the deviation, and the command that gives ours. Exit code 1 where a deviation is
beyond its bound. The oracles that take longer are in tests/theory and tests/python.
"""

import json
import math
import subprocess
import sys
import tempfile
from dataclasses import dataclass

import numpy as np
import readme
import restitution
from berth_program import Berth
from loop_matrix import Loop, loop_matrices


@dataclass(frozen=True)
class Row:
    what: str
    source: str
    ours: float
    theirs: float
    bound: float  # of the relative deviation
    command: str

    @property
    def deviation(self):
        return abs(self.ours / self.theirs - 1)


def berth(words):
    done = subprocess.run(["build/berth", *words.split(), "--json"], cwd=readme.ROOT, capture_output=True, check=True)
    return json.loads(done.stdout)


def eigenvalues():
    """(rig, rate, T_R, T_S) of the paper's three loops, by numpy on matrices from the definitions alone."""
    for rig, rate_Hz, robot_s, sensor_s in (("ess", 400, 0.0175, 0.0025), ("ess-50hz", 50, 0.04, 0.02),
                                            ("ess-half-dead-time", 400, 0.0075, 0.0025)):
        radius = np.abs(np.linalg.eigvals(loop_matrices(Loop(rate_Hz, robot_s, sensor_s))[0])).max()
        yield Row(f"largest |z| of {rig}", "numpy on the definitions", berth(f"eigen {rig}")["spectral_radius"], radius,
                  1e-8, f"berth eigen {rig}")


def growth():
    """Runs of firmware and simulated rig against the eigenvalues, and by the other solver."""
    for rig in ("ess", "ess-50hz", "ess-half-dead-time"):
        yield Row(f"growth of a run of {rig} in 1/s", "its eigenvalues", berth(f"run {rig} --no-log")["growth_per_s"],
                  berth(f"eigen {rig}")["growth_per_s"], 0.01, f"berth run {rig}")
    other = berth("run ess --no-log --set solver.kind=cvode --set run.duration_s=20")["growth_per_s"]
    ours = berth("run ess --no-log --set run.duration_s=20")["growth_per_s"]
    yield Row("growth of a run of ess in 1/s", "CVODE (SUNDIALS)", ours, other, 1e-4, "berth run ess --set solver.kind=cvode")


def limits():
    """First-order formula of the slow mode: zeta > tau/2 M/(M+m) (w - w_M^2/w)."""
    found = berth("limits ess")["parameters"]["object.stiffness_N_per_m"]
    yield Row("largest stiffness of the object of ess in N/m", "first-order formula", found["above"]["value"],
              found["first_order_above"], 0.01, "berth limits ess")


def bounces():
    """A free mass against an elastic wall: exp(-pi z / sqrt(1 - z^2)), z = -w0 tau / 2 without damping."""
    with tempfile.TemporaryDirectory() as folder:
        for delay_ms in (3.0, 3.5, 4.0):
            phase = 2 * math.pi * 3.0 * 1e-3 * delay_ms
            z = -phase / 2
            ours = restitution.restitution(Berth(folder), restitution.rig(phase, 0.0, 0.0, 1))
            yield Row(f"coefficient of restitution at 3 Hz, {delay_ms:g} ms", "closed form, Li et al. 2026", ours,
                      math.exp(-math.pi * z / math.sqrt(1 - z * z)), 0.002, "scripts/restitution.py --noise 0")


def beam():
    """Clamped beam: frequencies as the squares of the roots of cos x cosh x = -1."""
    modes = [mode["frequency_Hz"] for mode in berth("reduce ess-beam")["object"]["modes"]]
    for number, root in ((2, 4.694091133), (3, 7.854757438)):
        yield Row(f"beam: mode {number} over mode 1", "cos x cosh x = -1", modes[number - 1] / modes[0],
                  (root / 1.875104069)**2, 1e-6, "berth reduce ess-beam")


def dead_time():
    yield Row("dead time of ess, from a step, in ms", "the rig file", berth("deadtime ess")["command_to_motion_ms"], 17.5, 1e-4,
              "berth deadtime ess")


def main():
    rows = [row for make in (eigenvalues, growth, limits, bounces, beam, dead_time) for row in make()]
    print(f"{'what':<49}{'oracle':<29}{'ours':>13}{'oracle':>13}{'deviation':>11}  command")
    for row in rows:
        mark = "" if row.deviation <= row.bound else "  BEYOND ITS BOUND"
        print(f"{row.what:<49}{row.source:<29}{row.ours:>13.8g}{row.theirs:>13.8g}{100 * row.deviation:>10.4f}%  {row.command}{mark}")
    beyond = sum(row.deviation > row.bound for row in rows)
    print(f"{len(rows) - beyond} of {len(rows)} within their bounds")
    return 1 if beyond else 0


if __name__ == "__main__":
    sys.exit(main())
