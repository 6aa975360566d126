"""The figures of the paper as one HTML page that opens without a network: plots can be zoomed, surfaces rotated."""
import base64
import html
import json
from pathlib import Path

import numpy as np
from plotly.offline import get_plotlyjs

from paper_figures import Contour, Plot, Surface
from report_page import AXIS, filled, script_safe

HERE = Path(__file__).resolve().parent
MARKERS = {"points": {"symbol": "circle", "size": 7}, "star": {"symbol": "star", "size": 14},
           "ring": {"symbol": "circle-open", "size": 12, "line": {"width": 2}}}
DASHES = {"line": "solid", "dash": "dash", "dot": "dot"}
BLACK, WALL, OWN = "#000000", "#1B7837", "#FFD700"
BLUE_TO_WHITE = ("#053061", "#4393C3", "#D1E5F0", "#F7F7F7")
WHITE_TO_RED = ("#F7F7F7", "#FDDBC7", "#D6604D", "#67001F")


def encoded(values):
    """An array as plotly reads it: 32-bit numbers in base64."""
    values = np.asarray(values)
    content = np.ascontiguousarray(values, "<f4").tobytes()
    found = {"dtype": "f4", "bdata": base64.b64encode(content).decode()}
    return found | ({"shape": f"{values.shape[0]}, {values.shape[1]}"} if values.ndim == 2 else {})


def curve_trace(curve):
    """A curve; its numbers as text, since eigenvalues near 1 need more than seven digits."""
    trace = {"type": "scatter", "name": curve.label, "x": curve.x.tolist(), "y": curve.y.tolist()}
    if curve.style in MARKERS:
        return trace | {"mode": "markers", "marker": MARKERS[curve.style] | {"color": curve.colour}}
    return trace | {"mode": "lines", "line": {"color": curve.colour, "width": 2, "dash": DASHES[curve.style]}}


def plot_of(plot):
    x_axis = {"title": {"text": plot.x_title}} | AXIS
    y_axis = {"title": {"text": plot.y_title}} | AXIS
    if plot.x_range:
        x_axis["range"] = plot.x_range
    if plot.y_range:
        y_axis["range"] = plot.y_range
    if plot.is_log_x:
        x_axis |= {"type": "log", "tickvals": plot.curves[-1].x.tolist()}
    if plot.is_equal:
        y_axis |= {"scaleanchor": "x", "constrain": "domain"}
        x_axis |= {"constrain": "domain"}
    layout = {"xaxis": x_axis, "yaxis": y_axis, "height": 490,
              "title": {"text": plot.title, "font": {"size": 15}, "xref": "paper", "x": 0, "yref": "paper", "y": 1,
                        "yanchor": "bottom", "pad": {"b": 10}},
              "legend": {"orientation": "h", "y": -0.22, "yanchor": "top"}, "showlegend": len(plot.curves) > 1,
              "margin": {"l": 70, "r": 20, "t": 64, "b": 110}}
    return {"data": [curve_trace(curve) for curve in plot.curves], "layout": layout}


def colours_of(found):
    """Stable and unstable side each use their half of the colours, white at 1."""
    low, high = found.colour_range()
    middle = (1.0 - low) / (high - low)
    places = [*np.linspace(0.0, middle, 4), *np.linspace(middle, 1.0, 4)]
    return low, high, [list(pair) for pair in zip(places, BLUE_TO_WHITE + WHITE_TO_RED)]


def hover_of(found):
    return (f"{found.names()[0]} %{{x:.4f}}<br>{found.names()[1]} %{{y:.4f}}<br>largest |z| %{{z:.6f}}"
            "<extra></extra>")


def contour_plot(contour):
    found = contour.map
    low, high, scale = colours_of(found)
    told = found.told
    room = 0.06 * (high - low)  # for a number
    above = np.linspace(1.0, high, 5).tolist() if high - 1.0 > 4 * room else [1.0]
    marks = ([low] if 1.0 - low > room else []) + above
    traces = [{"type": "contour", "x": encoded(found.x[0]), "y": encoded(found.y[:, 0]), "z": encoded(found.radius),
               "zmin": low, "zmax": high, "colorscale": scale, "name": "limit of stability, |z| = 1",
               "contours": {"coloring": "heatmap", "start": 1.0, "end": 1.0, "size": 1.0},
               "line": {"color": BLACK, "width": 2.5}, "hovertemplate": hover_of(found),
               "colorbar": {"title": {"text": "largest |z|", "side": "right"}, "tickformat": ".3f",
                            "tickvals": marks}},
              {"type": "scatter", "mode": "lines", "x": [None], "y": [None], "name": "limit of stability, |z| = 1",
               "line": {"color": BLACK, "width": 2.5}}]
    if contour.before is not None:
        before = contour.before
        line = {"color": BLACK, "width": 2, "dash": "dot"}
        x, y, height = (grid[::4, ::4] for grid in (before.x, before.y, before.radius))  # fine enough for a line
        traces.append({"type": "contour", "x": encoded(x[0]), "y": encoded(y[:, 0]), "z": encoded(height),
                       "showscale": False, "showlegend": False, "hoverinfo": "skip", "line": line,
                       "contours": {"coloring": "none", "start": 1.0, "end": 1.0, "size": 1.0}})
        traces.append({"type": "scatter", "mode": "lines", "x": [None], "y": [None], "name": "without compensation",
                       "line": line})
    x, y = Surface(found).wall()
    if len(x):
        traces.append({"type": "scatter", "mode": "lines", "x": x.tolist(), "y": y.tolist(),
                       "name": f"wall, {told['wall_Hz']:g} Hz",
                       "line": {"color": WALL, "width": 2.5, "dash": "dash"}})
    own = told["own"]
    traces.append({"type": "scatter", "mode": "markers", "x": [own["x"]], "y": [own["y"]], "name": told["rig"],
                   "marker": {"color": OWN, "size": 11, "line": {"color": BLACK, "width": 1.5}},
                   "hovertemplate": f"largest |z| {own['spectral_radius']:.9f}<extra>{told['rig']}</extra>"})
    axes = {f"{axis}axis": AXIS | {"title": {"text": title}, "range": [float(grid.min()), float(grid.max())],
                                   "showgrid": False, "zeroline": False}
            for axis, title, grid in zip("xy", found.titles(), (found.x, found.y))}
    layout = axes | {"legend": {"orientation": "h", "y": 1.02, "yanchor": "bottom"},
                     "margin": {"l": 70, "r": 10, "t": 72, "b": 60}, "height": 540, "plot_bgcolor": "#E4E4E4"}
    if contour.title:
        layout |= {"title": {"text": contour.title, "font": {"size": 15}, "xref": "paper", "x": 0, "y": 0.93,
                             "yanchor": "top"},
                   "legend": {"orientation": "h", "y": -0.16, "yanchor": "top"},
                   "margin": layout["margin"] | {"b": 130}}
    return {"data": traces, "layout": layout}


def surface_plot(surface):
    found = surface.map
    low, high, scale = colours_of(found)
    x, y, height = surface.every_second()
    bottom, top = float(np.nanmin(height)), float(np.nanmax(height))
    flat = {"type": "surface", "showscale": False, "hoverinfo": "skip", "contours": {"x": {"highlight": False},
                                                                                     "y": {"highlight": False},
                                                                                     "z": {"highlight": False}}}
    ends = [[float(grid.min()), float(grid.max())] for grid in (x, y)]
    traces = [{"type": "surface", "x": encoded(x[0]), "y": encoded(y[:, 0]), "z": encoded(height), "cmin": low,
               "cmax": high, "colorscale": scale, "showscale": False, "hovertemplate": hover_of(found),
               "lighting": {"ambient": 0.75, "diffuse": 0.5, "specular": 0.05},
               "contours": {"z": {"show": True, "start": 1.0, "end": 1.0 + 1e-9, "size": 1.0, "color": BLACK,
                                  "width": 8}}},
              flat | {"x": ends[0], "y": ends[1], "z": [[1.0, 1.0], [1.0, 1.0]], "opacity": 0.35,
                      "colorscale": [[0, "#888888"], [1, "#888888"]]}]
    wall_x, wall_y = surface.wall()
    if len(wall_x):
        traces.append(flat | {"x": [wall_x.tolist()] * 2, "y": [wall_y.tolist()] * 2, "opacity": 0.45,
                              "z": [[bottom] * len(wall_x), [top] * len(wall_x)],
                              "colorscale": [[0, WALL], [1, WALL]]})
    own = found.told["own"]
    traces.append({"type": "scatter3d", "mode": "markers", "x": [own["x"]], "y": [own["y"]],
                   "z": [own["spectral_radius"]], "name": found.told["rig"], "showlegend": False,
                   "marker": {"color": OWN, "size": 7, "line": {"color": BLACK, "width": 2}},
                   "hovertemplate": f"largest |z| {own['spectral_radius']:.9f}<extra>{found.told['rig']}</extra>"})
    scene = {"xaxis": {"title": {"text": "ω/ω_M"}}, "yaxis": {"title": {"text": "ζ"}},
             "zaxis": {"title": {"text": "largest |z|"}, "range": [bottom, top]},
             "aspectmode": "manual", "aspectratio": {"x": 1.15, "y": 1.0, "z": 0.7},
             "camera": {"eye": {"x": -1.25, "y": -1.45, "z": 0.85}, "center": {"x": 0, "y": 0, "z": -0.12}}}
    return {"data": traces, "layout": {"scene": scene, "margin": {"l": 0, "r": 0, "t": 10, "b": 0}, "height": 540}}


DRAWN = {Plot: plot_of, Contour: contour_plot, Surface: surface_plot}


def claim_lines(claims):
    lines = []
    for claim in claims:
        kind = "met" if claim.met else "missed"
        remark = f" <em>{html.escape(claim.remark)}</em>" if claim.remark else ""
        lines.append(f'<li class="{kind}"><strong>{claim.verdict.lower()}</strong> claim {claim.number} · '
                     f"{html.escape(claim.sentence)} – {html.escape(claim.measured)}.{remark}</li>")
    return "\n".join(lines)


def section(figure, claims):
    own = [claim for claim in claims if claim.figure == figure.name]
    panels = "\n".join(f'<div class="plot" id="{figure.file_stem}-{i}"></div>' for i in range(len(figure.panels)))
    return (f'<section id="{figure.file_stem}">\n<h2>{html.escape(figure.name)} · {html.escape(figure.title)}</h2>\n'
            f'<div class="panels">\n{panels}\n</div>\n<p class="caption">{html.escape(figure.caption)}</p>\n'
            f'<ul class="claims">\n{claim_lines(own)}\n</ul>\n</section>')


def summary_rows(figures, claims):
    stems = {figure.name: figure.file_stem for figure in figures}
    return "\n".join(
        f'<tr class="{"met" if claim.met else "missed"}"><td>{claim.number}</td><td><strong>{claim.verdict.lower()}'
        f'</strong></td><td>{html.escape(claim.sentence)}</td><td>{html.escape(claim.measured)}</td>'
        f'<td><a href="#{stems[claim.figure]}">{html.escape(claim.figure)}</a></td></tr>' for claim in claims)


COMPENSATED = ('Below the paper\'s figures stand the same <a href="#compensated">with compensation of the dead time'
               '</a>.')


def build_page(figures, claims, rig):
    """The page as text; `rig`: of the case that the figures are about."""
    plots = [{"id": f"{figure.file_stem}-{i}"} | DRAWN[type(panel)](panel)
             for figure in figures for i, panel in enumerate(figure.panels)]
    style = [(HERE / name).read_text(encoding="utf-8") for name in ("report_page.css", "figures_page.css")]
    return filled("figures_page.html", {
        "style": "".join(style),
        "rig": html.escape(rig),
        "compensated": COMPENSATED if any(figure.file_stem == "compensated" for figure in figures) else "",
        "met": str(sum(claim.met for claim in claims)),
        "claims": str(len(claims)),
        "rows": summary_rows(figures, claims),
        "sections": "\n".join(section(figure, claims) for figure in figures),
        "plots": script_safe(json.dumps(plots, separators=(",", ":"), allow_nan=False)),
        "script": script_safe((HERE / "figures_page.js").read_text(encoding="utf-8")),
        "plotly": get_plotlyjs(),
    })
