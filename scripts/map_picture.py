#!/usr/bin/env python3
"""Draws a map written by `berth map`: largest |z|, the limit of stability, the robot's wall, the rig itself.

  map_picture.py build/maps/ess-elasticity.csv     writes build/maps/ess-elasticity.png
"""

import argparse
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from matplotlib.colors import TwoSlopeNorm  # noqa: E402
from matplotlib.patches import Patch  # noqa: E402

from berth_map import read_map  # noqa: E402

COLOURS = "RdBu_r"  # stable blue, unstable red


def colour_norm(found):
    """Stable and unstable side each use their half of the colours, however much one outdoes the other."""
    low, high = found.colour_range()
    return TwoSlopeNorm(1.0, low, high)


def draw_band(axes, found):
    """The limit at the lower end of the dead time, and the band between it and the upper end's; legend handles."""
    upper_ms, lower_ms = found.told["robot"]["dead_time_ms"], found.told["lower_end"]["dead_time_ms"]
    handles = []
    if np.nanmin(found.lower) < 1.0 < np.nanmax(found.lower):
        axes.contour(found.x, found.y, found.lower, levels=[1.0], colors="black", linewidths=2, linestyles=":")
        handles.append(plt.Line2D([], [], color="black", linewidth=2, linestyle=":",
                                  label=f"the same at {lower_ms:g} ms"))
    between = (found.radius - 1.0) * (found.lower - 1.0)  # negative: one of them is stable and the other is not
    if np.nanmin(between) < 0.0:
        axes.contourf(found.x, found.y, between, levels=[-np.inf, 0.0], colors=["black"], alpha=0.25)
        handles.append(Patch(facecolor="black", alpha=0.25,
                             label=f"depends on the dead time, {lower_ms:g} to {upper_ms:g} ms"))
    return handles


def draw_varying(axes, found):
    """The limit of the loop that changes from tick to tick; legend handles."""
    if not np.nanmin(found.growth_varying_per_s) < 0.0 < np.nanmax(found.growth_varying_per_s):
        return []
    axes.contour(found.x, found.y, found.growth_varying_per_s, levels=[0.0], colors="magenta", linewidths=1.5)
    lost = 100 * found.told["varying"]["lost_share_of_stable_area"]
    return [plt.Line2D([], [], color="magenta", linewidth=1.5,
                       label=f"with jitter, drift or losses: {abs(lost):.2g} % of the stable area "
                             + ("lost" if lost >= 0 else "gained"))]


def draw_flat(axes, found):
    """The map as filled contours; returns what a colour bar needs."""
    x, y, told = found.x, found.y, found.told
    axes.set_facecolor("white")
    axes.patch.set(hatch="////", edgecolor="0.8", linewidth=0)  # shows where there is no value

    norm = colour_norm(found)
    levels = np.concatenate([np.linspace(norm.vmin, 1.0, 16)[:-1], np.linspace(1.0, norm.vmax, 16)])
    filled = axes.contourf(x, y, found.radius, levels=levels, norm=norm, cmap=COLOURS, extend="both")

    handles = []
    if np.nanmin(found.radius) < 1.0 < np.nanmax(found.radius):
        axes.contour(x, y, found.radius, levels=[1.0], colors="black", linewidths=2)
        at = "" if found.lower is None else f" at {told['robot']['dead_time_ms']:g} ms"
        handles.append(plt.Line2D([], [], color="black", linewidth=2, label=f"limit of stability, |z| = 1{at}"))
    if found.lower is not None:
        handles += draw_band(axes, found)
    if found.growth_varying_per_s is not None:
        handles += draw_varying(axes, found)
    if np.nanmin(found.is_below_wall) < np.nanmax(found.is_below_wall):
        heights, level = found.is_below_wall, 0.5
        if told["vary"]:  # known between the points, too
            heights, level = found.damped_frequency_Hz(), told["wall_Hz"]
        axes.contour(x, y, heights, levels=[level], colors="darkgreen", linewidths=1.5, linestyles="--")
        handles.append(plt.Line2D([], [], color="darkgreen", linestyle="--",
                                  label=f"wall: damped eigenfrequency {told['wall_Hz']:g} Hz"))
    if found.own_is_inside():
        own = told["own"]
        axes.plot(own["x"], own["y"], "o", color="gold", markeredgecolor="black", markersize=9, zorder=5)
        handles.append(plt.Line2D([], [], linestyle="", marker="o", color="gold", markeredgecolor="black",
                                  label=f"{told['rig']}: |z| = {own['spectral_radius']:.6f}"))
    if not np.isfinite(found.radius).all():
        handles.append(Patch(facecolor="white", edgecolor="0.8", hatch="////", label="not possible"))
    axes.legend(handles=handles, loc="upper right", fontsize=9, frameon=True, framealpha=0.85)
    axes.set(xlim=(x.min(), x.max()), ylim=(y.min(), y.max()))
    axes.set(**dict(zip(("xlabel", "ylabel"), found.titles())))
    return filled


def draw(found, picture):
    """One picture of one map."""
    told = found.told
    figure, axes = plt.subplots(figsize=(8, 5.5), constrained_layout=True)
    figure.colorbar(draw_flat(axes, found), ax=axes, label="largest |z| of the one-period map", format="%.5f")
    names = found.names()
    what = f"{told['vary']} of the object varied" if told["vary"] else f"{names[0]} and {names[1]} varied"
    robot = f" on {told['robot']['preset']}" if told.get("robot") else ""
    stable = f"{100 * told['stable_share']:.1f} %"
    if found.lower is not None:
        stable += f" to {100 * told['lower_end']['stable_share']:.1f} %"
    title = f"{told['rig']}{robot}, {what}: {stable} stable"
    axes.set_title(title if len(title) <= 70 else title.replace(": ", ":\n"))
    figure.savefig(picture, dpi=130)
    plt.close(figure)


def main():
    """Draws each map that is named."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("csv", nargs="+", type=Path, help="a CSV file written by `berth map`")
    for csv in parser.parse_args().csv:
        picture = csv.with_suffix(".png")
        try:
            found = read_map(csv)
            if not np.isfinite(found.radius).any():
                sys.exit(f"{csv}: no point of this map has a value")
            draw(found, picture)
        except (OSError, ValueError, KeyError) as error:
            sys.exit(f"{csv}: not a map written by `berth map`: {error}")
        print(picture)


if __name__ == "__main__":
    main()
