#!/usr/bin/env python3
"""Draws two runs over each other: one page with the motion, the force and the verdicts of both.

  compare.py A.ulg B.ulg --out build/runs/compare.html
"""
import argparse
import html
import sys
from pathlib import Path

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from berth_log import InputError, read_log, read_summary, write_whole

ROOT = Path(__file__).resolve().parents[1]
EXIT_INPUT = 2
POINTS_MAX = 4000  # of a curve: more than a screen is wide
ROWS = (("command_position_m", "manipulator (m)"), ("robot_position_m", "robot (m)"), ("force_N", "force (N)"))
COLOURS = ("#0072B2", "#D55E00")  # of Okabe and Ito: told apart by everybody
FACTS = (("verdict", "verdict", ""), ("growth_per_s", "growth", "1/s"), ("frequency_Hz", "frequency", "Hz"),
         ("peak_force_N", "peak force", "N"), ("version", "commit", ""), ("config_hash", "configuration", ""))


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("logs", metavar="LOG", type=Path, nargs=2, help="a .ulg file written by `berth run`")
    parser.add_argument("--out", type=Path, required=True, help="the page to write")
    parser.add_argument("--berth", type=Path, default=ROOT / "build" / "berth")
    return parser.parse_args()


def thinned(time_s, values):
    """The lowest and the highest sample of each stretch, in their order."""
    stretch = -(-len(values) // (POINTS_MAX // 2))
    if stretch <= 2:
        return time_s, values
    whole = len(values) // stretch * stretch
    blocks = values[:whole].reshape(-1, stretch)
    first = np.arange(0, whole, stretch)
    picked = np.unique(np.concatenate((first + blocks.argmin(axis=1), first + blocks.argmax(axis=1))))
    return time_s[picked], values[picked]


def curves(logs):
    figure = make_subplots(rows=len(ROWS), shared_xaxes=True, vertical_spacing=0.04)
    for name, log, colour, dash in zip("AB", logs, COLOURS, ("solid", "dash")):
        for row, (field, title) in enumerate(ROWS, start=1):
            time_s, values = thinned(log.tick_s, log.tick[field].astype(float))
            figure.add_scatter(x=time_s, y=values, row=row, col=1, name=name, legendgroup=name, showlegend=row == 1,
                               line={"color": colour, "width": 1.5, "dash": dash})
            figure.update_yaxes(title_text=title, row=row, col=1)
    figure.update_xaxes(title_text="time (s)", row=len(ROWS), col=1)
    figure.update_layout(height=780, template="plotly_white", margin={"l": 70, "r": 20, "t": 30, "b": 50},
                         hovermode="x unified", legend={"orientation": "h", "y": 1.05})
    return figure


def flat(config):
    return {f"{section}.{key}": value for section, keys in config.items() if isinstance(keys, dict)
            for key, value in keys.items()}


def table(rows):
    lines = ("<tr>" + "".join(f"<td>{html.escape(str(cell))}</td>" for cell in row) + "</tr>" for row in rows)
    return '<div class="wide"><table>' + "".join(lines) + "</table></div>"


def shown(value):
    return "none" if value is None else f"{value:.4g}" if isinstance(value, float) else value


def build_page(logs, summaries, plots):
    facts = [("", "A", "B")] + [(f"{title} ({unit})" if unit else title, *(shown(one[key]) for one in summaries))
                                for key, title, unit in FACTS]
    a, b = (flat(log.config) for log in logs)
    differing = [(key, a.get(key, "none"), b.get(key, "none")) for key in [*a, *(b.keys() - a.keys())]
                 if a.get(key) != b.get(key)]
    parameters = table([("parameter", "A", "B"), *differing]) if differing else "<p>No parameter differs.</p>"
    return f"""<!doctype html>
<html lang="en">
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>berth: two runs compared</title>
<style>
body {{ font: 15px/1.5 system-ui, sans-serif; margin: 1.5rem auto; max-width: 75rem; padding: 0 1rem; color: #222;
        background: #fff; }}
.wide {{ overflow-x: auto; }}
td {{ border-bottom: 1px solid #ddd; padding: .25rem .8rem .25rem 0; overflow-wrap: anywhere; }}
code {{ overflow-wrap: anywhere; }}
</style>
<h1>Two runs compared</h1>
<p>A: <code>{html.escape(str(logs[0].path))}</code><br>B: <code>{html.escape(str(logs[1].path))}</code></p>
{table(facts)}
<h2>Parameters that differ</h2>
{parameters}
<h2>Curves</h2>
{plots}
</html>
"""


def main():
    arguments = parse_arguments()
    try:
        logs = [read_log(path) for path in arguments.logs]
        for log in logs:
            if len(log.tick_s) == 0:
                raise InputError(f"{log.path}: has no ticks; there is nothing to draw")
        summaries = [read_summary(path, arguments.berth) for path in arguments.logs]
        figure = curves(logs)
        arguments.out.parent.mkdir(parents=True, exist_ok=True)
        script = arguments.out.parent / "plotly.min.js"
        if not script.exists():
            from plotly.offline import get_plotlyjs
            write_whole(script, get_plotlyjs().encode())
        plots = figure.to_html(full_html=False, include_plotlyjs=script.name, config={"responsive": True})
        page = build_page(logs, summaries, plots).encode()
        write_whole(arguments.out, page)
        print(f"{arguments.out} ({len(page) / 1e6:.1f} MB)")
    except (InputError, OSError) as error:
        print(f"compare: {error}", file=sys.stderr)
        return EXIT_INPUT
    return 0


if __name__ == "__main__":
    sys.exit(main())
