"""The figures of the paper as pictures, each as the bytes of a PNG."""
import io
import textwrap

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt  # noqa: E402 (the backend comes first)
import numpy as np  # noqa: E402
from matplotlib.ticker import FixedLocator, MaxNLocator, NullLocator  # noqa: E402

from map_picture import COLOURS, colour_norm, draw_flat  # noqa: E402
from paper_figures import Contour, Plot, Surface  # noqa: E402
from report_figure import DASHES as DASHED, STYLE  # noqa: E402

HEIGHT_IN, DOTS_PER_INCH = 6.0, 110
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
    norm = colour_norm(found)
    bottom, top = np.nanmin(height), np.nanmax(height)
    axes.computed_zorder = False  # matplotlib does not know what hides what: the plane |z| = 1 is its edge
    corners = [0, 0, -1, -1, 0], [0, -1, -1, 0, 0]
    axes.plot(x[corners], y[corners], np.ones(5), color="0.4", linewidth=1, zorder=1)
    axes.plot_surface(x, y, height, facecolors=plt.get_cmap(COLOURS)(norm(height)), rcount=90, ccount=90,
                      shade=False, linewidth=0, antialiased=False, zorder=2)
    wall_x, wall_y = surface.wall()
    if len(wall_x):
        ends = np.array([[bottom], [top]])
        axes.plot_surface(np.tile(wall_x, (2, 1)), np.tile(wall_y, (2, 1)), np.tile(ends, len(wall_x)),
                          color="#1B7837", alpha=0.4, zorder=3)
    axes.contour(x, y, height, levels=[1.0], colors="black", linewidths=2, zorder=4)
    own = found.told["own"]
    axes.plot([own["x"]], [own["y"]], [own["spectral_radius"]], "o", color="gold", markeredgecolor="black",
              markersize=9, zorder=5)
    axes.set(xlabel="ω/ω_M", ylabel="ζ", zlabel="largest |z|", zlim=(bottom, top))
    axes.tick_params(axis="z", pad=6)
    axes.zaxis.labelpad = 14
    axes.set_box_aspect((1.15, 1.0, 0.75), zoom=0.92)
    axes.view_init(elev=28, azim=-125)


def draw_contour(figure, axes, contour):
    axes.grid(False)
    low, high = contour.map.colour_range()
    marks = [*np.linspace(low, 1.0, 6), *(np.linspace(1.0, high, 6)[1:] if high > 1.001 else ())]
    figure.colorbar(draw_flat(axes, contour.map), ax=axes, label="largest |z|", format="%.3f", ticks=marks)
    if contour.before is not None:
        before = contour.before
        axes.contour(before.x, before.y, before.radius, levels=[1.0], colors="black", linewidths=2, linestyles=":")
    axes.set_title(contour.title, fontsize=11)


def build_picture(figure):
    """The PNG of one figure."""
    width_in = {1: 9.0, 2: 14.0, 3: 16.0}[len(figure.panels)]
    with plt.rc_context(STYLE):
        drawn = plt.figure(figsize=(width_in, HEIGHT_IN), dpi=DOTS_PER_INCH, layout="constrained")
        for i, panel in enumerate(figure.panels):
            axes = drawn.add_subplot(1, len(figure.panels), i + 1,
                                     projection="3d" if isinstance(panel, Surface) else None)
            if isinstance(panel, Plot):
                draw_plot(axes, panel)
            elif isinstance(panel, Contour):
                draw_contour(drawn, axes, panel)
            else:
                draw_surface(axes, panel)
        drawn.suptitle(f"{figure.name}: {figure.title}", fontsize=15, weight="bold")
        drawn.supxlabel(textwrap.fill(figure.caption, int(13 * width_in)), fontsize=10, color="#444444")
        png = io.BytesIO()
        drawn.savefig(png, format="png")
        plt.close(drawn)
    return png.getvalue()
