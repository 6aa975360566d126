#!/usr/bin/env python3
"""Draws what `berth accuracy ARM --json` found: error of the tool over the length of the step.

  build/berth accuracy ess --json > build/accuracy.json
  accuracy_picture.py build/accuracy.json     writes build/accuracy.png
"""

import argparse
import json
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

LOST_m = 1.0  # beyond it the steps have blown up
COLOURS = {"semi_implicit_euler": "tab:orange", "rk4": "tab:blue", "implicit_midpoint": "tab:green"}
PANELS = {
    "mean": "the integrator alone",
    "held": "the force held over the step, as the loop does",
    "led": "the force led by half a step",
}


def draw(found, path):
    """`path`: a file's, or an open binary file."""
    figure, panels = plt.subplots(1, len(PANELS), figsize=(13, 4.5), sharey=True)
    for axes, (force, title) in zip(panels, PANELS.items()):
        for integrator, colour in COLOURS.items():
            rows = [row for row in found["rows"] if row["integrator"] == integrator and row["force"] == force]
            points = [(row["step_ms"], 1e6 * row["tool_m"]) for row in rows
                      if row["tool_m"] is not None and row["tool_m"] < LOST_m]
            axes.loglog(*zip(*points), "o-", color=colour, markersize=4, label=integrator.replace("_", " "))
        axes.axhline(1e6 * found["repeatability_m"], color="black", linestyle=":")
        axes.text(0.1, 1.15e6 * found["repeatability_m"], "repeatability of a robot", fontsize=8)
        axes.axvline(found["step_ms"], color="grey", linewidth=0.8)
        axes.set_title(title, fontsize=10)
        axes.set_xlabel("step in ms")
        axes.grid(True, which="both", alpha=0.2)
    panels[0].set_ylabel("largest error of the tool in µm")
    panels[0].legend(fontsize=8)
    figure.suptitle(f"{found['arm']}: berthing of 60 s with contact, against CVODE at 1e-12")
    figure.tight_layout()
    figure.savefig(path, dpi=110, format="png")
    plt.close(figure)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("json", type=Path, help="what `berth accuracy ARM --json` printed")
    parser.add_argument("-o", "--out", type=Path, help="default: beside it, as PNG")
    arguments = parser.parse_args()
    out = arguments.out or arguments.json.with_suffix(".png")
    draw(json.loads(arguments.json.read_text()), out)
    print(out)


if __name__ == "__main__":
    main()
