#!/usr/bin/env python3
"""Times the arm's step beside Pinocchio's articulated-body algorithm and MuJoCo's step of the same arms, in turns.

Prints a table of medians and 99.9 % values over all rounds, of all samples and of the least of each tick over several
passes of the same motion (what a tick took at best is its own; the rest came from outside), ratios within each round, and
instructions of single steps counted by callgrind, each as what one step more adds; writes build/bench_arm.json. Times only
inform; a count that is not the same from step to step ends it with 1.
"""

import argparse
import json
import re
import subprocess
import sys
from pathlib import Path
from statistics import median

ROOT = Path(__file__).resolve().parents[1]
ARMS = {
    "two links on a satellite, planar": ("two_link.urdf", ["--planar"], "planar", 5000),
    "seven joints on a satellite": ("seven.urdf", ["--tool", "gripper"], "spatial", 20000),
}
SPREAD_MAX = 0.05  # of the instructions of single steps: what the most and the least differ by
FIRST_STEPS = (1, 51, 501)  # single steps are counted from each of these on ...
SINGLE_STEPS = 4  # ... so many


def output_of(*command):
    run = subprocess.run([str(part) for part in command], cwd=ROOT, capture_output=True, text=True, check=False)
    if run.returncode != 0:
        sys.exit(f"bench_arm.py: {' '.join(map(str, command))} failed:\n{run.stderr}")
    return run


def instructions(arm, steps):
    run = output_of("valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", "build/arm_bench", "step", arm,
                    steps)
    return int(re.search(r"Collected : (\d+)", run.stderr)[1])


def counted(arm):
    """Instructions of single steps, one after the other in each of some stretches."""
    found = []
    for first in FIRST_STEPS:
        sums = [instructions(arm, first - 1 + count) for count in range(SINGLE_STEPS + 1)]
        found += [after - before for before, after in zip(sums, sums[1:])]
    return found


def measured(urdf, options, kind, rounds, samples):
    arm = ROOT / "build" / "bench" / Path(urdf).with_suffix(".toml")
    arm.parent.mkdir(parents=True, exist_ok=True)
    arm.write_text(output_of("build/berth", "arm", f"tests/arms/{urdf}", *options).stdout)
    timed = []
    for _ in range(rounds):
        own = json.loads(output_of("build/arm_bench", "time", arm, samples).stdout)
        peers = json.loads(output_of("build/arm_peers", f"tests/arms/{urdf}", kind, samples).stdout)
        timed.append({**own, **peers})
    return timed, counted(arm)


VALUES = ("median_ns", "p99.9_ns", "least_median_ns", "least_p99.9_ns")


def over_rounds(timed, name, value):
    return median(one[name][value] for one in timed)


def ratio(timed, ours, other):
    return median(one[ours]["least_median_ns"] / one[other]["least_median_ns"] for one in timed)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="one short round, to see that there are figures")
    quick = parser.parse_args().quick
    told, steady = {}, True
    for title, (urdf, options, kind, aim_ns) in ARMS.items():
        timed, single = measured(urdf, options, kind, 1 if quick else 7, 500 if quick else 10000)
        steady = steady and max(single) <= (1.0 + SPREAD_MAX) * min(single)
        print(f"{title}\n  {'':24} {'all':>10} {'':>10} {'least of each tick':>21}\n"
              f"  {'':24} {'median ns':>10} {'99.9 % ns':>10} {'median ns':>10} {'99.9 % ns':>10}")
        for name in timed[0]:
            print(f"  {name:24} " + " ".join(f"{over_rounds(timed, name, value):10.0f}" for value in VALUES))
        figures = {
            "aim_ns": aim_ns,
            "instructions_of_single_steps": single,
            "dynamics_to_pinocchio": ratio(timed, "forward_dynamics", "pinocchio_aba"),
            "step_to_mujoco": ratio(timed, "implicit_midpoint", "mujoco_step"),
            "step_to_mujoco_with_motors": ratio(timed, "implicit_midpoint", "mujoco_step_with_motors"),
            "rounds": timed,
        }
        print(f"  aim of a step {aim_ns} ns; dynamics / Pinocchio's {figures['dynamics_to_pinocchio']:.2f}, "
              f"step / MuJoCo's {figures['step_to_mujoco']:.2f}, with motors "
              f"{figures['step_to_mujoco_with_motors']:.2f}; {min(single)} to {max(single)} instructions in {len(single)} "
              f"single steps")
        told[title] = figures
    (ROOT / "build" / "bench_arm.json").write_text(json.dumps(told, indent=2))
    return 0 if steady else 1


if __name__ == "__main__":
    sys.exit(main())
