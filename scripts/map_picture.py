#!/usr/bin/env python3
"""Draws a map written by `berth map`: largest |z|, the limit of stability, the robot's wall, the rig itself.

  map_picture.py build/maps/ess-elasticity.csv     writes build/maps/ess-elasticity.png
"""

import argparse
import json
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from matplotlib.patches import Patch  # noqa: E402

TITLES = {"omega_per_omega_M": "ω/ω_M of the coupled system without dead time",
          "zeta": "damping ratio ζ of the coupled system without dead time"}


def load(csv):
    """x, y, |z|, the wall and growth with jitter in 1/s (or None) as grids (rows of y), and what is told beside them."""
    told = json.loads(csv.with_suffix(".json").read_text())
    shape = told["axes"]["y"]["count"], told["axes"]["x"]["count"]
    columns = np.loadtxt(csv, delimiter=",", skiprows=1)
    x, y, radius, _, wall, *varying = [column.reshape(shape) for column in columns.T]
    return x, y, radius, wall, varying[0] if varying else None, told


def draw(csv, picture):
    """One picture of one map."""
    x, y, radius, wall, varying, told = load(csv)
    if not np.isfinite(radius).any():
        sys.exit(f"{csv}: no point of this map has a value")
    figure, axes = plt.subplots(figsize=(8, 5.5), constrained_layout=True)
    axes.set_facecolor("white")
    axes.patch.set(hatch="////", edgecolor="0.8", linewidth=0)  # shows where there is no value

    # Differences from 1 on both sides in one scale: stable blue, unstable red.
    reach = max(np.nanpercentile(np.abs(radius - 1.0), 99), 1e-6)
    levels = 1.0 + reach * np.linspace(-1.0, 1.0, 41)
    filled = axes.contourf(x, y, radius, levels=levels, cmap="RdBu_r", extend="both")
    figure.colorbar(filled, ax=axes, label="largest |z| of the one-period map", format="%.5f")

    handles = []
    if np.nanmin(radius) < 1.0 < np.nanmax(radius):
        axes.contour(x, y, radius, levels=[1.0], colors="black", linewidths=2)
        handles.append(plt.Line2D([], [], color="black", linewidth=2, label="limit of stability, |z| = 1"))
    if varying is not None and np.nanmin(varying) < 0.0 < np.nanmax(varying):
        axes.contour(x, y, varying, levels=[0.0], colors="magenta", linewidths=1.5)
        lost = 100 * told["varying"]["lost_share_of_stable_area"]
        handles.append(plt.Line2D([], [], color="magenta", linewidth=1.5,
                                  label=f"with jitter, drift or losses: {abs(lost):.2g} % of the stable area "
                                        + ("lost" if lost >= 0 else "gained")))
    if np.nanmin(wall) < np.nanmax(wall):
        frequency_Hz, level = (wall, 0.5)
        if told["vary"]:  # known between the points, too
            frequency_Hz, level = told["manipulator_Hz"] * x * np.sqrt(np.maximum(0.0, 1.0 - y**2)), told["wall_Hz"]
        axes.contour(x, y, frequency_Hz, levels=[level], colors="darkgreen", linewidths=1.5, linestyles="--")
        handles.append(plt.Line2D([], [], color="darkgreen", linestyle="--",
                                  label=f"wall: damped eigenfrequency {told['wall_Hz']:g} Hz"))
    own = told["own"]
    if x.min() <= own["x"] <= x.max() and y.min() <= own["y"] <= y.max():
        axes.plot(own["x"], own["y"], "o", color="gold", markeredgecolor="black", markersize=9, zorder=5)
        handles.append(plt.Line2D([], [], linestyle="", marker="o", color="gold", markeredgecolor="black",
                                  label=f"{told['rig']}: |z| = {own['spectral_radius']:.6f}"))
    if not np.isfinite(radius).all():
        handles.append(Patch(facecolor="white", edgecolor="0.8", hatch="////", label="not possible"))
    axes.legend(handles=handles, loc="upper right", fontsize=9)
    axes.set_xlim(x.min(), x.max())
    axes.set_ylim(y.min(), y.max())
    names = [told["axes"][axis]["name"] for axis in "xy"]
    axes.set_xlabel(TITLES.get(names[0], names[0]))
    axes.set_ylabel(TITLES.get(names[1], names[1]))
    what = f"{told['vary']} of the object varied" if told["vary"] else f"{names[0]} and {names[1]} varied"
    share = told["stable_share"]
    axes.set_title(f"{told['rig']}, {what}: {100 * share:.1f} % stable")
    figure.savefig(picture, dpi=130)
    plt.close(figure)


def main():
    """Draws each map that is named."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("csv", nargs="+", type=Path, help="a CSV file written by `berth map`")
    for csv in parser.parse_args().csv:
        picture = csv.with_suffix(".png")
        try:
            draw(csv, picture)
        except (OSError, ValueError, KeyError) as error:
            sys.exit(f"{csv}: not a map written by `berth map`: {error}")
        print(picture)


if __name__ == "__main__":
    main()
