"""The figures of the paper as pictures, each as the bytes of a PNG."""
import io
import re
import textwrap

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt  # noqa: E402 (the backend comes first)
import numpy as np  # noqa: E402
from matplotlib.ticker import FixedLocator, MaxNLocator, NullLocator  # noqa: E402

from berth_map import LEVELS_A_SIDE  # noqa: E402
from map_picture import OWN, WALL, colour_bar, colours, draw_flat  # noqa: E402
from paper_figures import Contour, Plot, Surface  # noqa: E402
from report_figure import DASHES as DASHED, STYLE  # noqa: E402
from report_words import typeset  # noqa: E402

HEIGHT_IN, DOTS_PER_INCH = 6.2, 110
# Edges in inches, by hand: matplotlib's constrained layout costs as much as all the rest. Maps have an axis on top, and a
# colour bar on the right; other plots have the legend below the axis.
LEFT_IN, BAR_IN, BAR_GAP_IN = 0.85, 0.18, 0.25
EDGES_IN = {True: {"right": 2.0, "top": 1.15, "bottom": 0.95}, False: {"right": 0.35, "top": 0.85, "bottom": 1.4}}
DASHES = {"line": DASHED["solid"], "dash": DASHED["dash"], "dot": DASHED["dot"]}
MARKERS = {"points": {"marker": "o", "markersize": 5}, "star": {"marker": "*", "markersize": 13},
           "ring": {"marker": "o", "markersize": 10, "markerfacecolor": "none", "markeredgewidth": 1.8}}


def draw_curve(axes, curve):
    if curve.style in MARKERS:
        axes.plot(curve.x, curve.y, linestyle="", color=curve.colour, label=curve.label, **MARKERS[curve.style])
    else:
        axes.plot(curve.x, curve.y, linestyle=DASHES[curve.style], color=curve.colour, label=curve.label,
                  linewidth=1.6)


def draw_plot(axes, plot):
    for curve in plot.curves:
        draw_curve(axes, curve)
    axes.set(xlabel=plot.x_title, ylabel=plot.y_title, title=plot.title)
    if plot.is_log_x:
        axes.set_xscale("log")
        axes.xaxis.set_major_locator(FixedLocator(plot.curves[-1].x))
        axes.xaxis.set_minor_locator(NullLocator())
        axes.xaxis.set_major_formatter("{x:.0f}")
        axes.tick_params(axis="x", rotation=45)
    if plot.is_equal:
        axes.set_aspect("equal", adjustable="box")
        axes.xaxis.set_major_locator(MaxNLocator(5))
    axes.set(xlim=plot.x_range, ylim=plot.y_range)
    axes.ticklabel_format(axis="y", useOffset=False)
    if len(plot.curves) > 1:
        below = -0.22 if plot.is_log_x else -0.16
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, below), ncols=1 + (len(plot.curves) > 2), fontsize=10)


def draw_surface(axes, surface):
    found = surface.map
    x, y, height = surface.every_second()
    bottom, top = np.nanmin(height), np.nanmax(height)
    axes.computed_zorder = False  # matplotlib does not know what hides what: the plane of the limit is its edge
    corners = [0, 0, -1, -1, 0], [0, -1, -1, 0, 0]
    axes.plot(x[corners], y[corners], np.zeros(5), color="0.4", linewidth=1, zorder=1)
    shade = 0.5 + 0.5 * found.place_on_scale(height) / (LEVELS_A_SIDE + 1)
    axes.plot_surface(x, y, height, facecolors=colours()(shade), rcount=45, ccount=45, shade=False, linewidth=0,
                      antialiased=False, zorder=2)
    wall_x, wall_y = surface.wall()
    if len(wall_x):
        ends = np.array([[bottom], [top]])
        axes.plot_surface(np.tile(wall_x, (2, 1)), np.tile(wall_y, (2, 1)), np.tile(ends, len(wall_x)),
                          color=WALL, alpha=0.4, zorder=3)
    axes.contour(x, y, height, levels=[0.0], colors="black", linewidths=2, zorder=4)
    own = found.told["own"]
    axes.plot([own["x"]], [own["y"]], [own["growth_per_s"]], "o", color=OWN, markeredgecolor="black", markersize=9, zorder=5)
    axes.set(xlabel="ω/ω_M (1)", ylabel="ζ (1)", zlabel="growth (1/s)", zlim=(bottom, top))
    axes.tick_params(axis="z", pad=6)
    axes.yaxis.set_major_locator(MaxNLocator(3))
    axes.zaxis.labelpad = axes.yaxis.labelpad = 10
    axes.set_box_aspect((1.15, 1.0, 0.75), zoom=1.05)
    axes.view_init(elev=28, azim=-125)


def draw_contour(axes, contour):
    """Returns its legend handles by name, and what a colour bar needs."""
    axes.grid(False)
    shades, handles = draw_flat(axes, contour.map)
    if contour.before is not None:
        before = contour.before
        axes.contour(before.x, before.y, before.measured_growth_per_s(), levels=[0.0], colors="black", linewidths=2,
                     linestyles=":")
        handles.append(plt.Line2D([], [], color="black", linewidth=2, linestyle=":", label="limit without compensation"))
    axes.set_title(contour.title, fontsize=11)
    return {handle.get_label(): handle for handle in handles}, shades


def finish_contours(whole, axes, panels, drawn, places):
    """One legend and one colour bar for all maps of a figure, and titles that fit where there are several."""
    named = {re.sub(r": (growth .*|[\d.e-]+ %)$", "", label) if len(panels) > 1 else label: handle
             for handles, _ in drawn for label, handle in handles.items()}
    whole.legend(named.values(), named.keys(), loc="lower center", bbox_to_anchor=(0.5, places["foot"]), ncols=6, fontsize=9,
                 frameon=False)
    if len(panels) > 1:
        for one in axes:
            one.set(xlabel="ω/ω_M (1)", ylabel="")
        axes[0].set_ylabel("damping ratio ζ (1)")
    width_in = whole.get_figwidth()
    bar = whole.add_axes([places["right"] + BAR_GAP_IN / width_in, places["bottom"], BAR_IN / width_in,
                          places["top"] - places["bottom"]])
    colour_bar(whole, panels[-1].map, drawn[-1][1], cax=bar)


def places_in(width_in, height_in, caption_in, has_map):
    """Edges of the plots and of the caption, as shares of the picture."""
    edges = EDGES_IN[has_map]
    return {"left": LEFT_IN / width_in, "right": 1.0 - edges["right"] / width_in, "top": 1.0 - edges["top"] / height_in,
            "bottom": (caption_in + edges["bottom"]) / height_in, "foot": caption_in / height_in}


def build_picture(figure):
    """The PNG of one figure."""
    width_in = {1: 9.0, 2: 14.0, 3: 16.0}[len(figure.panels)]
    caption = textwrap.wrap(typeset(figure.caption), int(12 * width_in))
    caption_in = 0.2 * len(caption) + 0.2
    height_in = HEIGHT_IN + caption_in
    places = places_in(width_in, height_in, caption_in, any(isinstance(panel, Contour) for panel in figure.panels))
    with plt.rc_context(STYLE):
        whole = plt.figure(figsize=(width_in, height_in), dpi=DOTS_PER_INCH)
        grid = whole.add_gridspec(1, len(figure.panels), wspace=0.22,
                                  **{edge: places[edge] for edge in ("left", "right", "top", "bottom")})
        flat = []
        for i, panel in enumerate(figure.panels):
            axes = whole.add_subplot(grid[0, i], projection="3d" if isinstance(panel, Surface) else None)
            if isinstance(panel, Plot):
                draw_plot(axes, panel)
            elif isinstance(panel, Contour):
                flat.append((axes, panel, draw_contour(axes, panel)))
            else:
                draw_surface(axes, panel)
        if flat:
            finish_contours(whole, *(list(column) for column in zip(*flat)), places)
        whole.suptitle(f"{figure.name}: {figure.title}", fontsize=15, weight="bold", y=1.0 - 0.15 / height_in)
        whole.text(0.5, 0.5 * places["foot"], "\n".join(caption), fontsize=10, color="#444444", horizontalalignment="center",
                   verticalalignment="center")
        png = io.BytesIO()
        with np.errstate(over="ignore"):  # matplotlib pads faces with values that it does not draw
            whole.canvas.print_png(png)  # savefig() would draw everything twice
        plt.close(whole)
    return png.getvalue()
