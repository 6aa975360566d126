#!/usr/bin/env python3
"""Draws what `berth accuracy ARM --json` found: errors of tool, force and energy over the length of the step.

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
# Where two integrators do alike, the narrow line lies on the wide one.
LINES = {
    "semi_implicit_euler": ("semi-implicit Euler", {"color": "tab:orange", "linewidth": 1.5, "markersize": 4}),
    "implicit_midpoint": ("implicit midpoint", {"color": "tab:green", "linewidth": 4, "markersize": 8, "alpha": 0.6}),
    "rk4": ("RK4", {"color": "tab:blue", "linewidth": 1.2, "markersize": 3}),
}
PANELS = {
    "mean": "the integrator alone",
    "held": "the force held over the step",
    "led": "the force led by half a step",
}


QUANTITIES = {  # field: (in its unit, axis)
    "tool_m": (1e6, "largest error of the tool in µm"),
    "force_N": (1.0, "largest error of the force in N"),
    "energy_J": (1.0, "largest error of the energy in J"),
}


def draw_panel(axes, found, force, quantity):
    scale, _ = QUANTITIES[quantity]
    for integrator, (name, line) in LINES.items():
        rows = [row for row in found["rows"] if row["integrator"] == integrator and row["force"] == force
                and row["substeps"] == 1]
        points = [(row["step_ms"], scale * row[quantity]) for row in rows
                  if row[quantity] is not None and row["tool_m"] is not None and row["tool_m"] < LOST_m]
        axes.loglog(*zip(*points), "o-", label=name, **line)
    axes.axvline(found["step_ms"], color="grey", linewidth=0.8, label=f"{found['step_ms']:g} ms")
    axes.grid(True, which="both", alpha=0.2)


def draw(found, path):
    """`path`: a file's, or an open binary file."""
    figure, grid = plt.subplots(len(QUANTITIES), len(PANELS), figsize=(13, 11), sharex=True, sharey="row")
    for row, (quantity, (_, label)) in zip(grid, QUANTITIES.items()):
        for axes, force in zip(row, PANELS):
            if quantity == "force_N" and force == "mean":
                axes.text(0.5, 0.5, "the true force is given", ha="center", transform=axes.transAxes, fontsize=9)
                axes.grid(True, which="both", alpha=0.2)
                continue
            draw_panel(axes, found, force, quantity)
        row[0].set_ylabel(label)
    for axes, title in zip(grid[0], PANELS.values()):
        repeatability_um = 1e6 * found["repeatability_m"]
        axes.axhline(repeatability_um, color="black", linestyle=":",
                     label=f"repeatability of a robot, {repeatability_um:g} µm")
        axes.set_title(title, fontsize=10)
    for axes in grid[-1]:
        axes.set_xlabel("step in ms")
    figure.suptitle(f"{found['arm']}: berthing of 60 s with {found['events']} touches and releases, up to "
                    f"{found['largest_force_N']:.3g} N and {found['largest_energy_J']:.3g} J, against CVODE at 1e-12", y=0.995)
    handles, labels = grid[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="upper center", bbox_to_anchor=(0.5, 0.98), ncols=len(labels), fontsize=9)
    figure.tight_layout(rect=(0, 0, 1, 0.965))
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
