#!/usr/bin/env python3
"""Draws two runs over each other: one page with the motion, the force and the verdicts of both.

  compare.py A.ulg B.ulg --out build/runs/compare.html
"""
import argparse
import html
import json
import re
import subprocess
import sys
from pathlib import Path

import progress
from berth_log import InputError, behind_latest, read_log, read_summary, write_whole
from page_data import AXIS, VERDICT_CLASSES, Page, filled, shared_parts, with_gaps
from report_signals import MANIPULATOR, ROBOT, part_that_matters
from report_words import VERDICT_COLOURS, four_digits

ROOT = Path(__file__).resolve().parents[1]
EXIT_INPUT = 2
# Field of the log, factor to the unit that is shown, that unit, name of the panel, its note.
PANELS = (("command_position_m", 1e3, "mm", "Command", "Where the manipulator sends the robot."),
          ("robot_position_m", 1e3, "mm", "Robot", "Where the robot reports to be."),
          ("force_N", 1.0, "N", "Force", "As the loop receives it from the sensor."))
RUNS = (("A", MANIPULATOR, 0.75), ("B", ROBOT, 0.9))  # opacity: dense swings of one do not hide the other; dashes would break up
PERIODS_MIN = 4  # of a run that goes on when the other has failed


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("logs", metavar="LOG", type=Path, nargs=2, help="a .ulg file written by `berth run`")
    parser.add_argument("--out", type=Path, required=True, help="the page to write")
    parser.add_argument("--berth", type=Path, default=ROOT / "build" / "berth")
    return parser.parse_args()


def read_run(path, berth):
    """Log and summary of a run that has ticks. Raises InputError."""
    progress.show(f"compare: reads {path}")
    log = read_log(path)
    if len(log.tick_s) == 0:
        raise InputError(f"{path}: has no ticks; there is nothing to draw")
    return log, read_summary(path, berth)


def curves(page, logs):
    """A panel for each signal, with a curve of each run."""
    for field, factor, unit, title, note in PANELS:
        drawn = []
        for log, (name, colour, opacity) in zip(logs, RUNS):
            values = factor * log.tick[field].astype(float)
            trace = {"type": "scatter", "mode": "lines", "name": name, "line": {"color": colour},
                     "opacity": opacity, "hovertemplate": f"%{{y:.6~g}} {unit}"}
            drawn.append(page.curve(*with_gaps(log.tick_s, values, log.period_s), trace))
        page.add(title.lower(), title, note, drawn, {"yaxis": AXIS | {"title": {"text": f"{title.lower()} ({unit})"}}})


def cells(row, classes=("",) * 3):
    """A row of a table; a key may break behind a dot or an underscore."""
    return "<tr>" + "".join((f'<td class="{name}">' if name else "<td>")
                            + re.sub(r"(?<=[a-z])([._])(?=[a-zA-Z])", r"\1<wbr>", html.escape(str(cell))) + "</td>"
                            for cell, name in zip(row, classes)) + "</tr>"


def number(value, unit):
    return "none" if value is None else f"{four_digits(value)} {unit}"


def growth(summary):
    """Measured, or what the eigenvalues say of a run that does not show it; with the digits of `berth compare`."""
    told = summary["growth"]
    if told is None:
        return "none"
    return ("predicted " if told["origin"] == "predicted" else "") + number(told["growth_per_s"], "1/s")


def force_in_spring(summary):
    """Only a simulated rig knows it."""
    peak = summary["peak_force"]["true"]
    return number(peak and peak["force_N"], "N")


def fact_rows(logs, summaries):
    """Verdict, figures and versions of both runs, as rows of a table."""
    marks = [VERDICT_CLASSES[VERDICT_COLOURS[one["stable"]]] for one in summaries]
    rows = [cells(("rig", *(log.config["name"] for log in logs))),
            cells(("verdict", *(one["verdict"] for one in summaries)), ("", *marks))]
    rows.append(cells(("growth", *map(growth, summaries))))
    rows.append(cells(("frequency", *(number(one["frequency_Hz"], "Hz") for one in summaries))))
    rows.append(cells(("peak force", *(number(one["peak_force_N"], "N") for one in summaries))))
    rows.append(cells(("in the sensor's spring", *map(force_in_spring, summaries))))
    rows += [cells((title, *(one[key] for one in summaries)))
             for title, key in (("commit", "version"), ("configuration", "config_hash"))]
    return "\n".join(rows)


def differences(paths, berth):
    """What `berth compare A B --json` says of the parameters. Raises InputError."""
    done = subprocess.run([str(berth), "compare", *map(str, paths), "--json"], capture_output=True, text=True)
    if done.returncode != 0:
        raise InputError(done.stderr.strip().removeprefix("berth: "))
    return json.loads(done.stdout)["differences"]


def shortened(text):
    """A number of a rig file with six digits; other values as they are."""
    return re.sub(r"^-?\d[\d.e+-]*$", lambda found: f"{float(found[0]):.6g}", text)


def parameters(found):
    """What differs of the two configurations, as a table."""
    if not found:
        return "<p>No parameter differs.</p>"
    rows = []
    for one in found:
        a, b = (shortened(one[side]) for side in "ab")
        if a == b:  # beyond six digits
            a, b = one["a"], one["b"]
        rows.append(cells((one["key"], a, b)))
    return ('<div class="wide"><table class="differing">\n<thead><tr><th>key (unit last)</th><th>A</th><th>B</th></tr>'
            "</thead>\n" + "\n".join(rows) + "\n</table></div>")


def span_shown(logs, summaries):
    """From when to when the page opens: what matters of either run, but of a stable one beside one that fails only as much
    as that takes, or a few periods."""
    parts = [part_that_matters(log, summary) for log, summary in zip(logs, summaries)]
    start_s = min(start for start, _ in parts)
    failing = [end for (_, end), summary in zip(parts, summaries) if summary["stable"] is False]
    if not failing:
        return start_s, max(end for _, end in parts)
    few_s = [start_s + PERIODS_MIN / summary["frequency_Hz"] for summary in summaries
             if summary["stable"] and summary["frequency_Hz"]]
    return start_s, min(max(end for _, end in parts), max(failing + few_s))


def build_page(logs, summaries, found, path):
    """The page as text, for a file at `path`. `found`: what differs, see differences."""
    whole_s = (min(float(log.tick_s[0]) for log in logs), max(float(log.tick_s[-1] + log.period_s) for log in logs))
    shown_s = span_shown(logs, summaries)
    page = Page(logs[0].period_s, None if shown_s == whole_s else shown_s)
    curves(page, logs)
    data = page.data(*whole_s)
    names = [log.config["name"] for log in logs]
    title = f"Two runs of {names[0]}" if names[0] == names[1] else f"{names[0]} and {names[1]}"
    return filled("compare_page.html", shared_parts(path, ("compare_page.css",), ("report_page.js",)) | {
        "kind": "berth compare", "title": html.escape(title),
        "log_a": html.escape(str(logs[0].path)), "log_b": html.escape(str(logs[1].path)),
        "facts": fact_rows(logs, summaries), "parameters": parameters(found), "data": data,
        "thinned": html.escape(page.thinning_words())})


def main():
    progress.end_with_the_pipe()
    arguments = parse_arguments()
    arguments.logs = [behind_latest(log) for log in arguments.logs]
    try:
        logs, summaries = zip(*(read_run(path, arguments.berth) for path in arguments.logs))
        progress.show(f"compare: draws {arguments.out}")
        arguments.out.parent.mkdir(parents=True, exist_ok=True)
        page = build_page(logs, summaries, differences(arguments.logs, arguments.berth), arguments.out).encode()
        write_whole(arguments.out, page)
        progress.show()
        print(f"{arguments.out} ({len(page) / 1e6:.1f} MB)")
    except (InputError, OSError) as error:
        progress.show()
        print(f"compare: {error}", file=sys.stderr)
        return EXIT_INPUT
    return 0


if __name__ == "__main__":
    sys.exit(main())
