#!/usr/bin/env python3
"""Times the firmware's tick and the closed loop on one core, beside scipy and jitcdde on the same case.

Prints a table and writes build/bench.json. Ends with 1 if a peer's growth rate is not ours; times only inform.
"""

import argparse
import json
import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path
from statistics import median

from bench_peers import JitcddeLoop, Loop, run_scipy

RIG = "ess"
GROWTH_AGREES = 0.01  # of our growth rate
TICK_AIM_NS, SPEED_AIM, JITCDDE_AIM = 150.0, 10000.0, 25.0
LOOPS = {
    "fast solver, no log": ["--no-log"],
    "fast solver, log file": ["--out", "build/bench"],
    "CVODE, no log": ["--no-log", "--set", "solver.kind=cvode"],
    "CVODE, log file": ["--out", "build/bench", "--set", "solver.kind=cvode"],
}
SCIPY, JITCDDE, JITCDDE_COARSE = "scipy solve_ivp, DOP853", "jitcdde", "jitcdde, coarse"
COARSE = 1e-3  # relative tolerance: as coarse as still gives the growth rate
FASTEST = "fast solver, no log"


# One-sided contact looks whether it touches eight times a tick: the dearest of a unit.
UNITS = {
    "none": [],
    "extrapolation, order 3": ["extrapolation.order=3"],
    "adaptive inverse": ["adaptive_inverse.enabled=true"],
    "force lead": ["force_lead.enabled=true"],
    "prediction": ["prediction.enabled=true"],
    "identification": ["prediction.enabled=true", "identification.enabled=true"],
    "passivity controller": ["passivity.action=damping"],
    "energy tank": ["passivity.action=tank"],
    "dissipation": ["dissipation.damping_N_s_per_m=500"],
}
UNIT_RIGS = ("ess", "concept-copper")


class Effort:
    """How much is run: enough for figures, or (quick) enough to see that there are figures."""

    def __init__(self, quick):
        self.rounds = 1 if quick else 7
        self.loop_s = 20 if quick else 60
        self.scipy_s = 5 if quick else 10
        self.tick_s = 3 if quick else 60
        self.tick_passes = 1 if quick else 20
        self.counted_ticks = (200, 1000) if quick else (4000, 20000)


def output_of(*command):
    """Standard output of a command; ends the bench if it fails."""
    run = subprocess.run([str(part) for part in command], capture_output=True, text=True)
    if run.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}\n{run.stdout}{run.stderr}")
    return run.stdout


def callgrind(out_file, *command):
    """Instructions that a command executes; the profile goes to `out_file`."""
    options = ["--tool=callgrind", f"--callgrind-out-file={out_file}", f"--log-file={out_file}.log"]
    output_of("valgrind", *options, *command)
    return int(re.search(r"Collected : (\d+)", Path(f"{out_file}.log").read_text())[1])


def firmware_tick(effort):
    """Distribution of app_step() in ns, and its instructions as the difference of two counted runs."""
    result = json.loads(output_of("build/tick_bench", "time", RIG, effort.tick_s, effort.tick_passes))
    few, many = effort.counted_ticks
    counted = [callgrind("build/bench/tick.callgrind", "build/tick_bench", "step", RIG, effort.tick_s, ticks)
               for ticks in (few, many)]
    result["instructions"] = (counted[1] - counted[0]) / (many - few)
    result["counted_ticks"] = [few, many]
    return result


def compensation_ticks(effort):
    """Median and p99.9 of a tick in ns by rig and unit, the units in turn."""
    return {rig: {name: json.loads(output_of("build/tick_bench", "time", rig, min(20, effort.tick_s), 5, *settings))
                  for name, settings in UNITS.items()} for rig in UNIT_RIGS}


def print_units(ticks):
    print("\na tick with compensation, ns")
    print(f"  {'unit':26}" + "".join(f"{rig + ' median':>24}{'p99.9':>10}" for rig in ticks))
    for name in UNITS:
        print(f"  {name:26}" + "".join(f"{rows[name]['median_ns']:24.0f}{rows[name]['p99_9_ns']:10.0f}"
                                       for rows in ticks.values()))


def berth_run(arguments, duration_s):
    """One run of the host command: growth in 1/s and speed in multiples of real time."""
    run = json.loads(output_of("build/berth", "run", RIG, "--json", "--set", f"run.duration_s={duration_s}",
                               *arguments))
    return run["growth_per_s"], run["speed_x_realtime"]


def all_loops(effort, loop):
    """Every program in turn, round after round, so that a disturbance meets all alike: rows of figures by name."""
    compiled = JitcddeLoop(loop)

    def peer(result):
        return result.growth_per_s, result.simulated_s / result.wall_s

    programs = {name: lambda arguments=arguments: berth_run(arguments, effort.loop_s)
                for name, arguments in LOOPS.items()}
    programs[SCIPY] = lambda: peer(run_scipy(loop, effort.scipy_s))
    programs[JITCDDE] = lambda: peer(compiled.run(effort.loop_s))
    programs[JITCDDE_COARSE] = lambda: peer(compiled.run(effort.loop_s, COARSE))
    runs = {name: [] for name in programs}
    for _ in range(effort.rounds):
        for name, program in programs.items():
            runs[name].append(program())

    ours = runs[FASTEST][0][0]
    fastest = median(speed for _, speed in runs[FASTEST])
    rows = {}
    for name, pairs in runs.items():
        speeds = [speed for _, speed in pairs]
        speed = median(speeds)
        rows[name] = {
            "speed_x_realtime": speed,
            "speed_best_x_realtime": max(speeds),
            "ns_per_tick": 1e9 * loop.period / speed,
            "slower_than_fast": fastest / speed,
            "growth_per_s": pairs[0][0],
            "growth_deviation": pairs[0][0] / ours - 1.0,
        }
    return rows, compiled.compile_s


def aims(tick, rows):
    """Name, figure and whether it is met, for every aim."""
    found = [("firmware tick below 150 ns (median)", f"{tick['median_ns']:.0f} ns", tick["median_ns"] < TICK_AIM_NS)]
    for name in list(LOOPS)[:2]:
        speed = rows[name]["speed_x_realtime"]
        found.append((f"{name}: beyond 10,000 times real time", f"{speed:,.0f}", speed > SPEED_AIM))
    ratio = rows[JITCDDE]["slower_than_fast"]
    found.append(("about 25 times jitcdde", f"{ratio:.0f} times", ratio >= JITCDDE_AIM))
    return [{"aim": aim, "figure": figure, "met": met} for aim, figure, met in found]


def processor():
    """The processor's name."""
    found = re.search(r"model name\s*: (.*)", Path("/proc/cpuinfo").read_text())
    return found[1] if found else os.uname().machine


def print_tick(tick):
    """The firmware's part of the table."""
    few, many = tick["counted_ticks"]
    print(f"\nfirmware tick: app_step() with codec and recorder, {tick['ticks']} ticks with the inputs of a run")
    print(f"  median        {tick['median_ns']:8.1f} ns")
    print(f"  p99.9         {tick['p99_9_ns']:8.1f} ns")
    print(f"  in batches    {tick['batch_median_ns']:8.1f} ns   median, {tick['batch_ticks']} ticks at a time: "
          "finer than a clock's step")
    print(f"  clock         {tick['clock_reading_ns']:8.1f} ns   for one reading, subtracted above")
    print(f"  instructions  {tick['instructions']:8.0f}      callgrind, difference of {many} and {few} ticks")


def print_loops(rows, effort, compile_s):
    """The loops' part of the table."""
    print(f"\nclosed loop: median of {effort.rounds} runs of {effort.loop_s} s (scipy {effort.scipy_s} s) in turn")
    print(f"  {'':24} {'x real time':>12} {'best':>9} {'ns a tick':>10} {'fast is':>9} {'growth':>12} "
          f"{'to ours':>9}")
    for name, row in rows.items():
        print(f"  {name:24} {row['speed_x_realtime']:12,.1f} {row['speed_best_x_realtime']:9,.0f}"
              f" {row['ns_per_tick']:10,.0f} {row['slower_than_fast']:7.1f} x {row['growth_per_s']:+9.6f} /s"
              f" {100 * row['growth_deviation']:+7.4f} %")
    print(f"  The log file is written while the loop runs. scipy integrates tick by tick, with our sampling;\n"
          f"  jitcdde in continuous time, F(t) = y(t - T_S - T/2) and r(t) = x(t - T_R), at its own relative\n"
          f"  tolerance 1e-5 and at {COARSE:g}; its {compile_s:.1f} s to generate and compile C are not counted.")


def print_profile(out_file, *command):
    """Where the instructions of a command go."""
    callgrind(out_file, *command)
    lines = output_of("callgrind_annotate", "--auto=no", out_file).splitlines()
    start = next(i for i, line in enumerate(lines) if "file:function" in line)
    print(f"\nprofile of {' '.join(command)} (instructions, callgrind; the kernel's are not in it)")
    print("\n".join(line[:117] for line in lines[start:start + 17]))


def main():
    """Measures, prints, writes build/bench.json."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="few ticks and runs: figures are rough")
    effort = Effort(parser.parse_args().quick)
    os.chdir(Path(__file__).resolve().parent.parent)
    Path("build/bench").mkdir(parents=True, exist_ok=True)
    cpu = max(os.sched_getaffinity(0))
    os.sched_setaffinity(0, {cpu})  # children too

    machine = {"processor": processor(), "cpu": cpu, "load_average": os.getloadavg()[0]}
    rig = tomllib.loads(output_of("build/berth", "run", RIG, "--print-config"))
    print(f"berth bench: rig {RIG} at {rig['loop']['rate_Hz']:g} Hz on one core, CPU {cpu} of {machine['processor']}; "
          f"load average {machine['load_average']:.1f}")
    tick = firmware_tick(effort)
    print_tick(tick)
    units = compensation_ticks(effort)
    print_units(units)
    rows, compile_s = all_loops(effort, Loop.of_rig(rig))
    print_loops(rows, effort, compile_s)
    checked = aims(tick, rows)
    print("\naims")
    for aim in checked:
        print(f"  {aim['aim']:54} {aim['figure']:>10}   {'aim met' if aim['met'] else 'MISSED'}")
    Path("build/bench.json").write_text(json.dumps(
        {"machine": machine, "firmware_tick": tick, "compensation": units, "closed_loop": rows, "jitcdde_compile_s": compile_s,
         "aims": checked}, indent=2) + "\n")
    if not checked[0]["met"]:
        print_profile("build/bench/tick.callgrind", "build/tick_bench", "step", RIG, "60", "24000")
    if not all(aim["met"] for aim in checked[1:]):
        print_profile("build/bench/loop.callgrind", "build/berth", "run", RIG, "--no-log", "--json")

    wrong = [name for name, row in rows.items() if abs(row["growth_deviation"]) > GROWTH_AGREES]
    if wrong:
        sys.exit(f"growth rates differ from ours by more than {100 * GROWTH_AGREES:.0f} %: {', '.join(wrong)}")


if __name__ == "__main__":
    main()
