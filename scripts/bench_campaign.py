"""How much a campaign costs beside what it computes: eigenvalues of `ess` with tolerances.

usage: bench_campaign.py [SAMPLES] [WORKERS]     (from the repository's root; default 50000 samples, 2 workers)

One C++ process builds and solves the same rigs, alone on one core. Compared is processor time per sample, which other
programs on the machine disturb little: of client and workers together, with and without what they take to start, which
a campaign of a few samples shows. The time on the clock is printed as well.
"""
import resource
import shutil
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

OUT = Path("build/bench/campaign")
TEXT = """rig = "ess"
ask = ["growth"]
[sample]
count = {count}
[vary]
"object.mass_kg" = {{ mean = 180, sigma = 6 }}
"object.stiffness_N_per_m" = {{ tolerance_percent = 10 }}
"robot.dead_time_ms" = {{ from = 15, to = 20 }}
"manipulator.mass_kg" = {{ tolerance_percent = 5 }}
"""


def main():
    from berth.campaign import Spec, engine, sampling
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 50000
    workers = int(sys.argv[2]) if len(sys.argv) > 2 else 2
    shutil.rmtree(OUT, ignore_errors=True)
    OUT.mkdir(parents=True)
    spec = Spec.parse(TEXT.format(count=count))
    inputs = sampling.rows(spec, 0, count)
    np.column_stack(list(inputs.values())).astype("<f8").tofile(OUT / "inputs.bin")

    told, alone_s = timed(lambda: subprocess.run(["build/campaign_bench", OUT / "inputs.bin", "ess", *inputs],
                                                 capture_output=True, text=True, check=True).stdout)
    print(f"one C++ process    {told.strip()}")
    in_place_ns, anew_ns = float(told.split()[2]), float(told.split()[6])
    # The process also reads a tenth of the rigs anew: its processor time is shared as its clock is.
    alone_ns = 1e9 * alone_s / count * in_place_ns / (in_place_ns + 0.1 * anew_ns)

    _, start_s = timed(lambda: engine.run(Spec.parse(TEXT.format(count=64)), OUT / "few", workers=workers))
    begin = time.perf_counter()
    _, whole_s = timed(lambda: engine.run(spec, OUT / "table", workers=workers, tell=print))
    clock_s = time.perf_counter() - begin
    print(f"campaign           {count} samples on {workers} workers: {clock_s:.2f} s on the clock, {whole_s:.2f} s of "
          f"processors, of which {start_s:.2f} s to start")
    print(f"  the process      {alone_ns:,.0f} ns of a core per sample")
    for name, time_s in (("with its start", whole_s), ("without", whole_s - start_s)):
        ns = 1e9 * time_s / count
        print(f"  {name:<16} {ns:,.0f} ns of a core per sample: {ns / alone_ns:.2f} times the process")
    million_s = 1e6 * (whole_s - start_s) / count + start_s
    print(f"  1,000,000        would take {million_s:.0f} s of processors: {1e9 * million_s / 1e6 / alone_ns:.2f} times")


def timed(do):
    """What it returns, and the processor time that it took, s, with that of processes which it waited for."""
    def now_s():
        used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
        return sum(one.ru_utime + one.ru_stime for one in used)
    begin_s = now_s()
    return do(), now_s() - begin_s


if __name__ == "__main__":
    main()
