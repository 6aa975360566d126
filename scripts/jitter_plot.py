#!/usr/bin/env python3
"""How late threads woke, as a table and as the picture labs are used to: linear x, logarithmic y.

  jitter_plot.py build/jitter/berth.json build/jitter/cyclictest.json    writes build/jitter/berth.png

Reads histograms in the layout of cyclictest --json; the first file may be berth-target's, with execution, tick to wire
and force age beside the wake-up. More files are compared with the first.
"""

import argparse
import json
import math
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

SHARES = (0.5, 0.99, 0.999, 0.9999)
OURS = {"wake_up": "wake-up", "execution": "execution", "tick_to_wire": "tick to wire", "force_age": "force age"}


class Histogram:
    """Counts by whole microseconds, {bin: count}, with smallest, mean and largest time in microseconds."""

    def __init__(self, name, count, bins, least_us, mean_us, most_us):
        self.name, self.bins = name, dict(sorted(bins.items()))
        self.least_us, self.mean_us, self.most_us = least_us, mean_us, most_us
        self.count = count  # those beyond the last bin too

    def percentile_us(self, share):
        """Upper edge of the bin that this share of all times lies in or below."""
        wanted, below = math.ceil(share * self.count), 0
        for time_us, count in self.bins.items():
            below += count
            if below >= wanted:
                return min(time_us + 1, self.most_us)
        return self.most_us


def whole_us(bins):
    return {int(time_us): count for time_us, count in bins.items()}


def read(path):
    """The histograms of a file, wake-up first."""
    told = json.loads(path.read_text())
    if "berth" in told:
        found = ((label, told["berth"][name]) for name, label in OURS.items())
        return [Histogram(label, one["count"], whole_us(one["histogram"]), one["min_us"], one["avg_us"], one["max_us"])
                for label, one in found if one["count"] > 0]
    thread = told["thread"]["0"]
    if not thread["histogram"]:
        raise ValueError(f"{path} has no histogram")
    return [Histogram(path.stem, thread["cycles"], whole_us(thread["histogram"]), thread["min"], thread["avg"],
                      thread["max"])]


def print_beside(path):
    """What berth-target's file says that is no histogram: overruns, and what a run without buses could not measure."""
    told = json.loads(path.read_text()).get("berth")
    if told is None:
        return
    print(f"overruns: {told['overruns']} in {told['wake_up']['count']} ticks")
    if missing := [label for name, label in OURS.items() if told[name]["count"] == 0]:
        print(f"not measured: {', '.join(missing)}; a loop with buses does, as berth-target --jitter")


def print_table(histograms):
    print(f"{'us':14s}{'count':>9s}{'min':>9s}{'avg':>9s}" + "".join(f"{f'p{100 * s:g}':>9s}" for s in SHARES)
          + f"{'max':>9s}")
    for one in histograms:
        percentiles = "".join(f"{one.percentile_us(share):9.0f}" for share in SHARES)
        print(f"{one.name:14s}{one.count:9d}{one.least_us:9.1f}{one.mean_us:9.1f}{percentiles}{one.most_us:9.1f}")


def draw(path, histograms):
    figure, axes = plt.subplots(figsize=(9, 5), layout="constrained")
    for one in histograms:
        axes.stairs([one.bins.get(us, 0) for us in range(max(one.bins) + 1)], range(max(one.bins) + 2), baseline=0.5,
                    label=f"{one.name}: max {one.most_us:.0f} us")
    axes.set(yscale="log", xlabel="time, us", ylabel="count in 1 us", xlim=(0, None), ylim=(0.5, None))
    axes.grid(alpha=0.3)
    axes.legend()
    figure.savefig(path, dpi=120)
    plt.close(figure)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", type=Path, nargs="+")
    parser.add_argument("--out", type=Path, help="picture; default: the first file's name with .png")
    given = parser.parse_args()
    try:
        first, *others = [read(path) for path in given.file]
    except (OSError, ValueError, KeyError) as problem:
        print(f"jitter_plot.py: {problem}: give files as cyclictest --json=FILE --histogram=US and berth-target --jitter write them",
              file=sys.stderr)
        return 2
    histograms = first + [one for other in others for one in other]
    print_table(histograms)
    print_beside(given.file[0])
    for other in others:
        print(f"largest {first[0].name} to {other[0].name}: {first[0].most_us / max(other[0].most_us, 1):.2f}")
    picture = given.out or given.file[0].with_suffix(".png")
    draw(picture, histograms)
    print(picture)
    return 0


if __name__ == "__main__":
    sys.exit(main())
