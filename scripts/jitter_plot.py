#!/usr/bin/env python3
"""How late threads woke, as a table and as a picture: the histogram that labs are used to (logarithmic y), and
beside it the percentiles.

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

from report_figure import STYLE  # noqa: E402
from report_signals import COMMAND, MANIPULATOR, OBJECT, REPORTED, ROBOT  # noqa: E402

COLOURS = (MANIPULATOR, COMMAND, OBJECT, REPORTED)  # of ours
OTHERS = (ROBOT, "#333333", "#56B4E9", "#8C6D00", "#7A3DB8")  # of files beside it
TAIL_FROM = 10  # times the 99th percentile
SHARES_DRAWN = (0.5, 0.9, 0.99, 0.999, 0.9999, 1.0)
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


class BadFile(Exception):
    """One sentence that says which file cannot be used, and why."""


def whole_us(bins):
    return {int(time_us): count for time_us, count in bins.items()}


def ours(told):
    """The histograms of berth-target's file, wake-up first."""
    found = ((label, told["berth"][name]) for name, label in OURS.items())
    return [Histogram(label, one["count"], whole_us(one["histogram"]), one["min_us"], one["avg_us"], one["max_us"])
            for label, one in found if one["count"] > 0]


def of_threads(told, name):
    """One histogram of all threads of cyclictest together; none if they have none."""
    threads = [thread for thread in told["thread"].values() if thread["histogram"]]
    if not threads:
        return []
    bins = {}
    for thread in threads:
        for time_us, count in whole_us(thread["histogram"]).items():
            bins[time_us] = bins.get(time_us, 0) + count
    cycles = sum(thread["cycles"] for thread in threads)
    if not all({"min", "avg", "max"} <= thread.keys() for thread in threads):  # whole us, as the histogram has them
        counted = sum(bins.values())
        return [Histogram(name, cycles, bins, min(bins), sum(us * many for us, many in bins.items()) / counted, max(bins))]
    return [Histogram(name, cycles, bins, min(thread["min"] for thread in threads),
                      sum(thread["avg"] * thread["cycles"] for thread in threads) / cycles,
                      max(thread["max"] for thread in threads))]


def read(path):
    """(object, histograms) of a file. Raises BadFile."""
    try:
        told = json.loads(path.read_text())
        found = ours(told) if "berth" in told else of_threads(told, path.stem)
    except OSError as problem:
        raise BadFile(f"{path}: cannot be read: {problem.strerror}") from problem
    except UnicodeDecodeError as problem:
        raise BadFile(f"{path}: is not JSON, it is no text") from problem
    except json.JSONDecodeError as problem:
        raise BadFile(f"{path}: is not JSON: {problem}") from problem
    except (ValueError, KeyError, TypeError, AttributeError, ZeroDivisionError):
        found = []
    if not found:
        raise BadFile(f"{path}: has no histogram; give files as cyclictest --json=FILE --histogram=US and "
                      "berth-target --jitter write them")
    return told, found


def print_beside(told):
    """What berth-target's file says that is no histogram: overruns, and what a run without buses could not measure."""
    told = told.get("berth")
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


def machine_words(told):
    """The machine and how the loop ran on it, as the file tells."""
    system = told.get("sysinfo", {})
    words = []
    if system:
        is_realtime = system.get("realtime") or "PREEMPT_RT" in system.get("version", "")
        words.append(f"{system.get('nodename', 'unknown machine')}: {system.get('sysname')} {system.get('release')} "
                     f"{system.get('machine')}, {'real-time' if is_realtime else 'no real-time'} kernel")
    loop = told.get("berth")
    if loop:
        words.append(f"{loop['real_time']}; period {loop['interval_us']} µs; {loop['overruns']} overruns in "
                     f"{loop['wake_up']['count']} ticks; {told.get('start_time', '')}")
    return words


def title(told, first, others):
    """Whose wake-ups they are."""
    name = "cyclictest" if "cyclictest" in str(told.get("cmdline:")) else first[0].name  # its own spelling
    who = "the loop" if "berth" in told else f"the thread{'s' * (len(told['thread']) > 1)} of {name}"
    beside = f", beside {', '.join(one.name for one in others)}" if others else ""
    return f"How late {who} woke{beside}"


def draw_histogram(axes, histograms, colours):
    """The first is ours and the widest, so that one that lies on it leaves it visible."""
    for i, (one, colour) in enumerate(zip(histograms, colours)):
        axes.stairs([one.bins.get(us, 0) for us in range(max(one.bins) + 1)], range(max(one.bins) + 2), baseline=0.5,
                    color=colour, linewidth=max(1.2, 2.6 - 0.5 * i), label=f"{one.name}, {one.count} times")
    axes.set(yscale="log", xlabel="time (µs)", ylabel="count in 1 µs (1)", xlim=(0, None), ylim=(0.5, None),
             title="Histogram")
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.12), ncols=2)
    if any(one.most_us > TAIL_FROM * one.percentile_us(0.99) for one in histograms):
        axes.set(xscale="log", xlim=(1, None))  # else the tail squeezes all others into one line


def draw_percentiles(axes, histograms, colours):
    """One step a nine, so that the rare ones are as wide as the usual ones."""
    places = range(len(SHARES_DRAWN))
    for one, colour in zip(histograms, colours):
        times_us = [max(0.1, one.percentile_us(share)) for share in SHARES_DRAWN]
        axes.plot(places, times_us, "o-", color=colour, linewidth=1.6, markersize=5)
    axes.set(yscale="log", ylabel="time (µs)", title="Percentiles", xlim=(-0.4, len(SHARES_DRAWN) - 0.6))
    axes.set_xticks(places, ["max" if share == 1.0 else f"{100 * share:g}" for share in SHARES_DRAWN])
    axes.set_xlabel("share of all times (%), and below it the times (µs)")
    below = axes.get_xaxis_transform()
    for row, (one, colour) in enumerate(zip(histograms, colours)):  # a table: on the curves they would lie on others
        numbers = [f"{one.percentile_us(share):.0f}" for share in SHARES_DRAWN]
        for place, text in zip([-0.3, *places], [one.name, *numbers]):
            axes.annotate(text, (place, 0), (0, -54 - 17 * row), xycoords=below, textcoords="offset points", color=colour,
                          fontsize=10.5, weight="bold" if place in places else "normal",
                          horizontalalignment="center" if place in places else "right")


def draw(path, told, first, others):
    """`told`, `first`: the first file and its histograms; `others`: those of the files beside it. Raises BadFile."""
    colours = [*COLOURS[:len(first)], *(OTHERS[i % len(OTHERS)] for i in range(len(others)))]
    histograms = first + others
    with plt.rc_context(STYLE):
        figure, (left, right) = plt.subplots(1, 2, figsize=(13, 6.4), layout="constrained", width_ratios=[1.25, 1])
        draw_histogram(left, histograms, colours)
        draw_percentiles(right, histograms, colours)
        figure.suptitle(f"{title(told, first, others)}\n\n", fontsize=16, weight="bold", horizontalalignment="left", x=0.012)
        figure.text(0.012, 0.945, "\n".join(machine_words(told)), fontsize=10.5, color="#444444", verticalalignment="top")
        try:
            figure.savefig(path, dpi=120)
        except OSError as problem:
            raise BadFile(f"{path}: cannot be written: {problem.strerror}") from problem
        except ValueError as problem:
            raise BadFile(f"{path}: cannot be written: {problem}") from problem
        finally:
            plt.close(figure)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", type=Path, nargs="+")
    parser.add_argument("--out", type=Path, help="picture; default: the first file's name with .png")
    given = parser.parse_args()
    try:
        (told, first), *others = [read(path) for path in given.file]
        beside = [one for _, found in others for one in found]
        print_table(first + beside)
        print_beside(told)
        for _, other in others:
            print(f"largest {first[0].name} to {other[0].name}: {first[0].most_us / max(other[0].most_us, 1):.2f}")
        picture = given.out or given.file[0].with_suffix(".png")
        draw(picture, told, first, beside)
    except BadFile as problem:
        print(f"jitter_plot.py: {problem}", file=sys.stderr)
        return 2
    print(picture)
    return 0


if __name__ == "__main__":
    sys.exit(main())
