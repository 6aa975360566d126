#!/usr/bin/env python3
"""Draws a map written by `berth map`: growth of the motion, the limit of stability, where a bounce gains energy, the robot's
wall, the rig itself.

  map_picture.py build/maps/ess-elasticity.csv     writes build/maps/ess-elasticity.png
"""

import argparse
import sys
from dataclasses import dataclass
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from matplotlib.collections import LineCollection  # noqa: E402
from matplotlib.colors import LinearSegmentedColormap  # noqa: E402
from matplotlib.patches import Patch  # noqa: E402

import progress  # noqa: E402
from berth_map import LEVELS_A_SIDE, level_text, read_map  # noqa: E402

# Stable blue, unstable red, each from pale to dark. The palest of each differs from white and from the other.
SHADES = ("#053061", "#2166AC", "#4393C3", "#7DB6D8", "#B5D6E8", "#DCEAF2", "#FBE3D4", "#F5BFA2", "#E68B6C", "#D6604D",
          "#B2182B", "#67001F")
NOT_POSSIBLE = "#D9D9D9"
ALONE_SHARE = 0.05  # of the points
WALL, OWN, BOUNCE = "#1B5E20", "#FFD700", "#6A1B9A"


@dataclass(frozen=True)
class Look:
    """Of points that have no growth."""
    label: str
    ground: str
    ink: str
    hatch: str  # matplotlib's


LASTS = Look("swings on without growing", "#F2E6B3", "#7A6200", "....")
FAULTED = Look("a fault ended the run before it grew", "#E9DCE4", "#8E3B6F", "////")


def colours():
    """The shades as matplotlib reads them."""
    return LinearSegmentedColormap.from_list("growth", SHADES)


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


def draw_bounces(axes, found):
    """Where a tool leaves the material as fast as it came; legend handles."""
    if found.restitution is None or not np.nanmin(found.restitution) < 1.0 < np.nanmax(found.restitution):
        return []
    axes.contour(found.x, found.y, found.restitution, levels=[1.0], colors=BOUNCE, linewidths=2, linestyles="-.")
    gaining = f"{100 * found.told['bounces']['gaining_share']:.2g} %"
    return [plt.Line2D([], [], color=BOUNCE, linewidth=2, linestyle="-.",
                       label=f"restitution 1: a bounce gains energy at {gaining}")]


def edges(places):
    """Between the points of an axis, and as far beyond its ends."""
    middles = 0.5 * (places[1:] + places[:-1])
    return np.concatenate(([2 * places[0] - middles[0]], middles, [2 * places[-1] - middles[-1]]))


def needs_cells(found):
    """Whether points without a growth lie between the others, or many stand alone: shades between points need four."""
    has_growth = np.isfinite(found.measured_growth_per_s())
    whole = has_growth[:-1, :-1] & has_growth[:-1, 1:] & has_growth[1:, :-1] & has_growth[1:, 1:]
    corners = np.zeros(has_growth.shape, bool)
    for rows, columns in ((slice(-1), slice(-1)), (slice(-1), slice(1, None)), (slice(1, None), slice(-1)),
                          (slice(1, None), slice(1, None))):
        corners[rows, columns] |= whole
    alone = has_growth & ~corners
    return (found.is_lasting | found.is_faulted).any() or alone.sum() > ALONE_SHARE * has_growth.sum()


def draw_cells(axes, found, place):
    """A cell of one shade for each point."""
    shade = np.ma.masked_invalid(np.clip(np.floor(place), -LEVELS_A_SIDE, LEVELS_A_SIDE - 1) + 0.5)
    axes.pcolormesh(edges(found.x[0]), edges(found.y[:, 0]), shade, cmap=colours(), vmin=-LEVELS_A_SIDE - 1,
                    vmax=LEVELS_A_SIDE + 1)


def draw_hatched(axes, found, mask, look):
    """Cells of points that have no growth; legend handles."""
    if not mask.any():
        return []
    plt.rcParams["hatch.linewidth"] = 0.8
    ground = LinearSegmentedColormap.from_list("ground", [look.ground, look.ground])
    axes.pcolor(edges(found.x[0]), edges(found.y[:, 0]), np.ma.masked_where(~mask, np.ones(mask.shape)), cmap=ground,
                hatch=look.hatch, edgecolor=look.ink, linewidth=0, zorder=1.5)
    share = 100 * mask.sum() / np.isfinite(found.growth_per_s).sum()
    return [Patch(facecolor=look.ground, edgecolor=look.ink, hatch=look.hatch, linewidth=0,
                  label=f"{look.label}: {share:.2g} %")]


def draw_shades(axes, found):
    """Growth by colour, one shade a level; what has none is grey or hatched, never white. Legend handles, and what a
    colour bar needs."""
    axes.set_facecolor(NOT_POSSIBLE)
    levels = np.arange(-LEVELS_A_SIDE, LEVELS_A_SIDE + 1)
    place = found.place_on_scale(found.measured_growth_per_s())
    is_cells = needs_cells(found)
    if is_cells:
        draw_cells(axes, found, place)
    shades = axes.contourf(found.x, found.y, np.full_like(place, np.nan) if is_cells else place, levels=levels, cmap=colours(), vmin=-LEVELS_A_SIDE - 1,
                           vmax=LEVELS_A_SIDE + 1, extend="both")
    handles = draw_hatched(axes, found, found.is_lasting, LASTS) + draw_hatched(axes, found, found.is_faulted, FAULTED)
    if found.is_impossible.any():
        handles.append(Patch(facecolor=NOT_POSSIBLE, label="not possible"))
    return handles, shades


def sides_between(found):
    """Sides of cells with a stable point on one side and another that is possible on the other: [((x, y), (x, y)), ...]"""
    x, y, stable, possible = edges(found.x[0]), edges(found.y[:, 0]), found.is_stable, ~found.is_impossible
    beside = np.argwhere((stable[:, 1:] != stable[:, :-1]) & possible[:, 1:] & possible[:, :-1])
    above = np.argwhere((stable[1:] != stable[:-1]) & possible[1:] & possible[:-1])
    return [((x[column + 1], y[row]), (x[column + 1], y[row + 1])) for row, column in beside] + \
           [((x[column], y[row + 1]), (x[column + 1], y[row + 1])) for row, column in above]


def draw_limit(axes, found):
    """The limit of stability; legend handles."""
    growth_per_s = found.measured_growth_per_s()
    if needs_cells(found):
        sides = sides_between(found)
        axes.add_collection(LineCollection(sides, colors="black", linewidths=2, capstyle="projecting", zorder=2), autolim=False)
        is_there = bool(sides)
    else:
        is_there = np.nanmin(growth_per_s) < 0.0 < np.nanmax(growth_per_s)
        if is_there:
            axes.contour(found.x, found.y, growth_per_s, levels=[0.0], colors="black", linewidths=2)
    at = "" if found.lower is None else f" at {found.told['robot']['dead_time_ms']:g} ms"
    return [plt.Line2D([], [], color="black", linewidth=2, label=f"limit of stability{at}")] if is_there else []


def draw_wall(axes, found):
    """How fast the robot can move; legend handles."""
    if not np.nanmin(found.is_below_wall) < np.nanmax(found.is_below_wall):
        return []
    heights, level = found.is_below_wall, 0.5
    if found.told["vary"]:  # known between the points, too
        heights, level = found.damped_frequency_Hz(), found.told["wall_Hz"]
    axes.contour(found.x, found.y, heights, levels=[level], colors=WALL, linewidths=1.5, linestyles="--")
    return [plt.Line2D([], [], color=WALL, linestyle="--", label=f"wall: damped frequency {found.told['wall_Hz']:g} Hz")]


def draw_axes(axes, found):
    """Both titles, and a physical axis on top where x is a ratio."""
    axes.set(xlim=(found.x.min(), found.x.max()), ylim=(found.y.min(), found.y.max()))
    axes.set(**dict(zip(("xlabel", "ylabel"), found.titles())))
    if found.has_frequency_axis:
        manipulator_Hz = found.told["manipulator_Hz"]
        top = axes.secondary_xaxis("top", functions=(lambda ratio: ratio * manipulator_Hz, lambda f: f / manipulator_Hz))
        top.set_xlabel("frequency of the coupled system (Hz)")


def draw_flat(axes, found):
    """The map from above; returns what a colour bar needs, and legend handles."""
    told = found.told
    shaded, shades = draw_shades(axes, found)
    handles = draw_limit(axes, found)
    if found.lower is not None:
        handles += draw_band(axes, found)
    if found.growth_varying_per_s is not None:
        handles += draw_varying(axes, found)
    handles += draw_bounces(axes, found) + draw_wall(axes, found)
    if found.own_is_inside():
        own = told["own"]
        axes.plot(own["x"], own["y"], "o", color=OWN, markeredgecolor="black", markersize=9, zorder=5)
        growth = f"{own['growth_per_s']:+.3g} /s".replace("-", "−")
        handles.append(plt.Line2D([], [], linestyle="", marker="o", color=OWN, markeredgecolor="black",
                                  label=f"{told['rig']}: growth {growth}"))
    draw_axes(axes, found)
    return shades, handles + shaded


def colour_bar(figure, found, shades, **where):
    """Levels as growth, and as the time in which the motion doubles or halves. `where`: ax or cax."""
    bar = figure.colorbar(shades, **where, spacing="uniform", ticks=np.arange(-LEVELS_A_SIDE, LEVELS_A_SIDE + 1),
                          label="growth (1/s), and time to double or halve (s)")
    bar.ax.set_yticklabels([level_text(level) for level in found.levels_per_s()], fontsize=9)


def draw(found, picture):
    """One picture of one map."""
    told = found.told
    figure, axes = plt.subplots(figsize=(9, 6.2), constrained_layout=True)
    shades, handles = draw_flat(axes, found)
    colour_bar(figure, found, shades, ax=axes)
    figure.legend(handles=handles, loc="outside lower center", ncols=3, fontsize=9, frameon=False)
    names = found.names()
    what = f"{told['vary']} of the object varied" if told["vary"] else f"{names[0]} and {names[1]} varied"
    robot = f" on {told['robot']['preset']}" if told.get("robot") else ""
    stable = f"{100 * told['stable_share']:.1f} %"
    if found.lower is not None:
        stable += f" to {100 * told['lower_end']['stable_share']:.1f} %"
    title = f"{told['rig']}{robot}, {what}: stable at {stable} of the points"
    axes.set_title(title if len(title) <= 70 else title.replace(": ", ":\n"))
    figure.savefig(picture, dpi=130)
    plt.close(figure)


def main():
    """Draws each map that is named."""
    progress.end_with_the_pipe()
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("csv", nargs="+", type=Path, help="a CSV file written by `berth map`")
    parser.add_argument("--quiet", action="store_true", help="do not print the names of the pictures")
    arguments = parser.parse_args()
    for csv in arguments.csv:
        picture = csv.with_suffix(".png")
        try:
            found = read_map(csv)
            if not np.isfinite(found.radius).any():
                sys.exit(f"{csv}: no point of this map has a value")
            progress.show(f"map: draws {picture}")
            draw(found, picture)
            progress.show()
        except (OSError, ValueError, KeyError) as error:
            progress.show()
            sys.exit(f"{csv}: not a map written by `berth map`: {error}")
        if not arguments.quiet:
            print(picture)


if __name__ == "__main__":
    main()
