"""The figures of the paper as one HTML page that opens without a network: plots can be zoomed, surfaces rotated. A map
that several plots show is in the page once."""
import base64
import html
import json

import numpy as np

from berth_map import LEVELS_A_SIDE, level_text
from map_picture import FAULTED, LASTS, NOT_POSSIBLE, OWN, SHADES, WALL
from page_data import AXIS, extremes, filled, script_safe, shared_parts
from paper_figures import Contour, Plot, Surface
from report_words import typeset

MARKERS = {"points": {"symbol": "circle", "size": 7}, "star": {"symbol": "star", "size": 14},
           "ring": {"symbol": "circle-open", "size": 12, "line": {"width": 2}}}
DASHES = {"line": "solid", "dash": "dash", "dot": "dot"}
BLACK = "#000000"
POINTS_A_SIDE_MAX = 121  # of a map: what a plot of this size shows
CURVE_POINTS_MAX = 1200  # the lowest and the highest of each of 600 pixels, the width of a plot
HATCHES_WIDE, HATCHES_HIGH = 64, 48
PLACES = 1000  # to which a level of the scale is divided, for 16 bits


class Maps:
    """The maps of a page: where each point lies on the scale of its levels, as 16-bit numbers in base64."""

    def __init__(self):
        self.kept = []  # the maps themselves, so that the same one is found again
        self.packed = []

    def number(self, found):
        """Place of a map in `packed`."""
        for i, kept in enumerate(self.kept):
            if kept is found:
                return i
        x, y, growth_per_s = (thinned_map(grid) for grid in (found.x, found.y, found.measured_growth_per_s()))
        place = found.place_on_scale(growth_per_s)
        whole = np.where(np.isnan(place), -2**15, np.rint(PLACES * place)).astype("<i2")
        self.kept.append(found)
        self.packed.append({"x": shortened(x[0]), "y": shortened(y[:, 0]), "levels": found.levels_per_s().tolist(),
                            "places": base64.b64encode(whole.tobytes()).decode()})
        return len(self.kept) - 1


def thinned_map(grid):
    """Every so many rows and columns, so that a plot shows the rest."""
    step = -(-max(grid.shape) // POINTS_A_SIDE_MAX)
    return grid[::step, ::step]


def shortened(values, digits=7):
    return [float(f"{value:.{digits}g}") for value in values]


def curve_trace(curve):
    """A curve, thinned to what a plot shows. Ten digits: eigenvalues near 1 need more than seven."""
    picked, _ = extremes(curve.y, CURVE_POINTS_MAX)
    trace = {"type": "scatter", "name": curve.label, "x": shortened(curve.x[picked], 10),
             "y": shortened(curve.y[picked], 10)}
    if curve.style in MARKERS:
        return trace | {"mode": "markers", "marker": MARKERS[curve.style] | {"color": curve.colour}}
    return trace | {"mode": "lines", "line": {"color": curve.colour, "width": 2, "dash": DASHES[curve.style]}}


def apart(values, times=1.5):
    """Those of rising values that are so many times the one before: on a logarithmic axis their names need room."""
    kept = [float(values[0])]
    for value in values[1:]:
        if value >= times * kept[-1]:
            kept.append(float(value))
    return kept


def plot_of(plot, _maps):
    x_axis = {"title": {"text": plot.x_title}} | AXIS
    y_axis = {"title": {"text": plot.y_title}} | AXIS
    if plot.x_range:
        x_axis["range"] = plot.x_range
    if plot.y_range:
        y_axis["range"] = plot.y_range
    if plot.is_log_x:
        x_axis |= {"type": "log", "tickvals": apart(plot.curves[-1].x)}
    if plot.is_equal:
        y_axis |= {"scaleanchor": "x", "constrain": "domain"}
        x_axis |= {"constrain": "domain"}
    return {"title": plot.title, "data": [curve_trace(curve) for curve in plot.curves],
            "layout": {"xaxis": x_axis, "yaxis": y_axis, "height": 380, "hovermode": "closest"}}


def colour_scale():
    """The shades, evenly."""
    return [[i / (len(SHADES) - 1), shade] for i, shade in enumerate(SHADES)]


def colour_bar(found):
    ticks = list(range(-LEVELS_A_SIDE, LEVELS_A_SIDE + 1))
    return {"title": {"text": "growth (1/s), and time to double or halve (s)", "side": "right"}, "tickvals": ticks,
            "ticktext": [level_text(level) for level in found.levels_per_s()], "thickness": 14, "outlinewidth": 0,
            "short": [f"{level:+g}".replace("-", "−") if level else "0" for level in found.levels_per_s()]}


REACH = LEVELS_A_SIDE + 0.5  # of the colours


def hover_of(found):
    return (f"{found.names()[0]} %{{x:.4f}}<br>{found.names()[1]} %{{y:.4f}}<br>growth %{{customdata:.3g}} /s"
            "<extra></extra>")


def named_line(name, line):
    """An entry of the legend for what has none of its own."""
    return {"type": "scatter", "mode": "lines", "x": [None], "y": [None], "name": name, "line": line, "swatch": "map"}


def grown(mask):
    """A mask with its neighbours: shades end at the points beside a gap, which leaves a seam."""
    wide = np.pad(mask, 1)
    rows, columns = mask.shape
    return np.any([wide[i:i + rows, j:j + columns] for i in range(3) for j in range(3)], axis=0)


def hatched_places(found, mask):
    """Places of strokes that hatch the gaps which these points leave: the map ends at their neighbours on all sides. Where no
    object is possible there is no stroke, as there the ground has another colour."""
    rows, columns = found.x.shape
    row, column = (grid.ravel() for grid in np.meshgrid(np.linspace(0, rows - 1, HATCHES_HIGH),
                                                        np.linspace(0, columns - 1, HATCHES_WIDE), indexing="ij"))
    gaps = np.argwhere(mask)
    away = np.maximum(np.abs(row[:, None] - gaps[:, 0]), np.abs(column[:, None] - gaps[:, 1]))
    nearest = np.rint(row).astype(int), np.rint(column).astype(int)
    inside = (away.min(axis=1) < 0.98) & ~found.is_impossible[nearest]
    return (np.interp(column[inside], np.arange(columns), found.x[0]),
            np.interp(row[inside], np.arange(rows), found.y[:, 0]))


def gap_traces(found, mask, look, symbol):
    """Points that have no growth: a ground that the map lies on, and hatches."""
    if not mask.any():
        return []
    ground = np.where(grown(mask) & ~found.is_impossible, 1.0, np.nan)
    rows = [[None if np.isnan(value) else value for value in row] for row in ground]
    x, y = hatched_places(found, mask)
    marker = {"symbol": symbol, "size": 9 if symbol == "line-ne" else 2.5, "color": look.ink, "line": {"color": look.ink, "width": 1.4}}
    return [{"type": "heatmap", "x": shortened(found.x[0]), "y": shortened(found.y[:, 0]), "z": rows, "showscale": False,
             "hoverinfo": "skip", "colorscale": [[0, look.ground], [1, look.ground]], "zmin": 0, "zmax": 1},
            {"type": "scatter", "mode": "markers", "x": shortened(x), "y": shortened(y), "hoverinfo": "skip",
             "marker": marker, "name": look.label, "swatch": "hatch"}]


def frequency_axis(found):
    """The coupled system's frequency in Hz, on top of its ratio."""
    manipulator_Hz = found.told["manipulator_Hz"]
    low, high = manipulator_Hz * found.x.min(), manipulator_Hz * found.x.max()
    step = next(step for step in (0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100) if (high - low) / step < 9)
    ticks = np.arange(np.ceil(low / step), np.floor(high / step) + 1) * step
    return AXIS | {"overlaying": "x", "side": "top", "matches": "x", "tickvals": (ticks / manipulator_Hz).tolist(),
                   "ticktext": [f"{tick:g}" for tick in ticks], "showgrid": False, "zeroline": False,
                   "title": {"text": "frequency of the coupled system (Hz)"}}


def contour_plot(contour, maps):
    found = contour.map
    told = found.told
    line = {"color": "#111111", "width": 2.5}
    limit = {"start": 0.0, "end": 0.0, "size": 1.0}
    traces = gap_traces(found, found.is_lasting, LASTS, "circle") + gap_traces(found, found.is_faulted, FAULTED, "line-ne")
    traces += [{"type": "contour", "map": maps.number(found), "zmin": -REACH, "zmax": REACH,
                "colorscale": colour_scale(), "name": "limit of stability", "showlegend": False,
                "contours": {"coloring": "heatmap"} | limit, "line": line, "hovertemplate": hover_of(found),
                "colorbar": colour_bar(found)},
               named_line("limit of stability", line)]
    if contour.before is not None:
        dotted = {"color": "#111111", "width": 2, "dash": "dot"}
        traces += [{"type": "contour", "map": maps.number(contour.before), "showscale": False, "showlegend": False,
                    "hoverinfo": "skip", "line": dotted, "contours": {"coloring": "none"} | limit},
                   named_line("without compensation", dotted)]
    x, y = Surface(found).wall()
    if len(x):
        traces.append({"type": "scatter", "mode": "lines", "x": x.tolist(), "y": y.tolist(),
                       "name": f"wall, {told['wall_Hz']:g} Hz", "line": {"color": WALL, "width": 2.5, "dash": "dash"}, "swatch": "map"})
    own = told["own"]
    traces.append({"type": "scatter", "mode": "markers", "x": [own["x"]], "y": [own["y"]], "name": told["rig"],
                   "marker": {"color": OWN, "size": 11, "line": {"color": "#111111", "width": 1.5}},
                   "hovertemplate": f"growth {own['growth_per_s']:.4g} /s<extra>{told['rig']}</extra>"})
    layout = {f"{axis}axis": AXIS | {"title": {"text": title}, "range": [float(grid.min()), float(grid.max())],
                                     "showgrid": False, "zeroline": False}
              for axis, title, grid in zip("xy", found.titles(), (found.x, found.y))}
    if found.has_frequency_axis:
        layout["xaxis2"] = frequency_axis(found)
        traces.append({"type": "scatter", "x": [None], "y": [None], "xaxis": "x2", "showlegend": False, "hoverinfo": "skip"})
    return {"title": contour.title, "data": traces,
            "layout": layout | {"height": 460, "plot_bgcolor": NOT_POSSIBLE, "hovermode": "closest", "margin": {"t": 56}}}


def inner_ticks(low, high):
    """Round numbers between the ends of an axis, away from the corners, where labels of two axes meet."""
    step = next(step for step in (10.0 ** power * many for power in range(-4, 5) for many in (1, 2, 5)) if (high - low) / step < 5)
    margin = 0.12 * (high - low)
    ticks = np.arange(np.ceil((low + margin) / step), np.floor((high - margin) / step) + 1) * step
    return {"tickvals": ticks.tolist(), "ticktext": [f"{tick:.6g}" for tick in ticks]}


def surface_plot(surface, maps):
    found = surface.map
    height = surface.every_second()[2]
    bottom, top = float(np.nanmin(height)), float(np.nanmax(height))
    flat = {"type": "surface", "showscale": False, "hoverinfo": "skip", "contours": {"x": {"highlight": False},
                                                                                     "y": {"highlight": False},
                                                                                     "z": {"highlight": False}}}
    ends = [[float(grid.min()), float(grid.max())] for grid in (found.x, found.y)]
    traces = [{"type": "surface", "map": maps.number(found), "cmin": -REACH, "cmax": REACH,
               "colorscale": colour_scale(), "showscale": False, "hovertemplate": hover_of(found),
               "lighting": {"ambient": 0.75, "diffuse": 0.5, "specular": 0.05},
               "contours": {"z": {"show": True, "start": 0.0, "end": 1e-9, "size": 1.0, "color": BLACK,
                                  "width": 8}}},
              flat | {"x": ends[0], "y": ends[1], "z": [[0.0, 0.0], [0.0, 0.0]], "opacity": 0.35,
                      "colorscale": [[0, "#888888"], [1, "#888888"]]}]
    wall_x, wall_y = surface.wall()
    if len(wall_x):
        traces.append(flat | {"x": [wall_x.tolist()] * 2, "y": [wall_y.tolist()] * 2, "opacity": 0.45,
                              "z": [[bottom] * len(wall_x), [top] * len(wall_x)],
                              "colorscale": [[0, WALL], [1, WALL]]})
    own = found.told["own"]
    traces.append({"type": "scatter3d", "mode": "markers", "x": [own["x"]], "y": [own["y"]],
                   "z": [own["growth_per_s"]], "name": found.told["rig"], "showlegend": False,
                   "marker": {"color": OWN, "size": 7, "line": {"color": "#111111", "width": 2}},
                   "hovertemplate": f"growth {own['growth_per_s']:.4g} /s<extra>{found.told['rig']}</extra>"})
    axis = {"gridcolor": "#CCCCCC", "backgroundcolor": "rgba(0,0,0,0)"}
    x_ticks, y_ticks = (inner_ticks(*one) for one in ends)
    scene = {"xaxis": axis | {"title": {"text": "ω/ω_M (1)"}} | x_ticks, "yaxis": axis | {"title": {"text": "ζ (1)"}} | y_ticks,
             "zaxis": axis | {"title": {"text": "growth (1/s)"}, "range": [bottom, top], "nticks": 5},
             "aspectmode": "manual", "aspectratio": {"x": 1.15, "y": 1.0, "z": 0.7},
             "camera": {"eye": {"x": -1.35, "y": -1.55, "z": 0.9}, "center": {"x": 0, "y": 0, "z": -0.12}}}
    return {"title": "", "data": traces,
            "layout": {"scene": scene, "margin": {"l": 0, "r": 0, "t": 0, "b": 0}, "height": 460}}


DRAWN = {Plot: plot_of, Contour: contour_plot, Surface: surface_plot}


def plot_place(name, title):
    """Where the page's script draws one plot: its title, its legend, the plot."""
    heading = f"<h3>{html.escape(title)}</h3>" if title else ""
    return f'<div class="figure-panel">{heading}<ul class="legend"></ul><div class="plot" id="{name}"></div></div>'


def claim_lines(claims):
    lines = []
    for claim in claims:
        kind = "met" if claim.met else "missed"
        remark = f" <em>{html.escape(claim.remark)}</em>" if claim.remark else ""
        lines.append(f'<li class="{kind}"><strong>{claim.verdict.lower()}</strong> claim {claim.number} · '
                     f"{html.escape(claim.sentence)} – {html.escape(typeset(claim.measured))}.{remark}</li>")
    return "\n".join(lines)


def section(figure, claims):
    own = [claim for claim in claims if claim.figure == figure.name]
    panels = "\n".join(plot_place(f"{figure.file_stem}-{i}", getattr(panel, "title", ""))
                       for i, panel in enumerate(figure.panels))
    return (f'<section id="{figure.file_stem}">\n<h2>{html.escape(figure.name)} · {html.escape(figure.title)}</h2>\n'
            f'<div class="panels">\n{panels}\n</div>\n<p class="caption">{html.escape(typeset(figure.caption))}</p>\n'
            f'<ul class="claims">\n{claim_lines(own)}\n</ul>\n</section>')


def summary_rows(figures, claims):
    stems = {figure.name: figure.file_stem for figure in figures}
    return "\n".join(
        f'<tr class="{"met" if claim.met else "missed"}"><td>{claim.number}</td><td><strong>{claim.verdict.lower()}'
        f'</strong></td><td>{html.escape(claim.sentence)}</td><td data-title="here">{html.escape(typeset(claim.measured))}</td>'
        f'<td><a href="#{stems[claim.figure]}">{html.escape(claim.figure)}</a></td></tr>' for claim in claims)


COMPENSATED = ('Below the paper\'s figures stand the same <a href="#compensated">with compensation of the dead time'
               '</a>.')


def build_page(figures, claims, rig, path):
    """The page as text, for a file at `path`; `rig`: of the case that the figures are about."""
    maps = Maps()
    plots = [{"id": f"{figure.file_stem}-{i}"} | DRAWN[type(panel)](panel, maps)
             for figure in figures for i, panel in enumerate(figure.panels)]
    return filled("figures_page.html", shared_parts(path, ("figures_page.css",), ("figures_page.js",)) | {
        "kind": "berth figures",
        "title": "The paper's figures and claims",
        "rig": html.escape(rig),
        "compensated": COMPENSATED if any(figure.file_stem == "compensated" for figure in figures) else "",
        "met": str(sum(claim.met for claim in claims)),
        "claims": str(len(claims)),
        "rows": summary_rows(figures, claims),
        "sections": "\n".join(section(figure, claims) for figure in figures),
        "plots": script_safe(json.dumps(plots, separators=(",", ":"), allow_nan=False)),
        "maps": script_safe(json.dumps(maps.packed, separators=(",", ":"), allow_nan=False)),
    })
