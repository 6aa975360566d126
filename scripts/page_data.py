"""What all HTML pages share: their parts, the samples that go into them, and the script file that draws the plots.

A page holds what a screen can show of a signal: every sample of the part that the page opens on, and of the rest the
lowest and the highest sample of each stretch, so that peaks remain. The log holds every sample."""
import base64
import json
import os
from pathlib import Path

import numpy as np
import plotly
from plotly.offline import get_plotlyjs

from berth_log import InputError, write_whole
from report_signals import BAD, GOOD, NEUTRAL

HERE = Path(__file__).resolve().parent
BUILD = HERE.parent / "build"
PLOTLY = f"plotly-{plotly.__version__}.min.js"

# Points that a plot of 1200 pixels shows of a curve: the lowest and the highest a pixel.
POINTS_MAX, POINTS_MIN = 2400, 600
# Of all curves of a page together, in base64.
CURVES_MAX_BYTES = 500_000
BASE64 = 4 / 3
POINT_BYTES = 6 * BASE64  # 32 bits of value and 16 of time

UNSURE = "#8A5A00"
VERDICT_CLASSES = {GOOD: "good", BAD: "bad", NEUTRAL: "neutral", UNSURE: "unsure"}

# Colours are written as they are on white; page.css has their counterparts on black.
AXIS = {"gridcolor": "#E6E6E6", "zeroline": True, "zerolinecolor": "#CCCCCC", "linecolor": "#999999",
        "ticks": "outside", "tickcolor": "#999999", "showline": True}


def shared_folder(folder):
    """The build folder that a page in `folder` lies in: the repository's, or one where `berth run` keeps its runs. None
    elsewhere."""
    if folder.is_relative_to(BUILD.resolve()):
        return BUILD
    parts = folder.parts
    found = [i for i in range(1, len(parts)) if parts[i - 1:i + 1] == ("build", "runs")]
    return Path(*parts[:found[-1]]) if found else None


def plotly_address(page):
    """Where the page at this path finds plotly, relative to it. All pages of a build folder share one file there; for a
    page elsewhere the file is copied beside it. Raises InputError."""
    folder = page.resolve().parent
    assets = (shared_folder(folder) or folder) / "assets"
    content = get_plotlyjs().encode()
    file = assets / PLOTLY
    try:
        assets.mkdir(parents=True, exist_ok=True)
        is_there = file.is_file() and file.stat().st_size == len(content)
    except OSError as error:
        raise InputError(f"{assets}: cannot be made ({error.strerror}); the plots of {page} need {PLOTLY} there") from error
    if not is_there:
        write_whole(file, content)
    return Path(os.path.relpath(file.resolve(), folder)).as_posix()


def encoded(values, kind):
    return base64.b64encode(np.ascontiguousarray(values, dtype=kind).tobytes()).decode()


def extremes(values, points_max):
    """Indices of at most about `points_max` samples: the lowest and the highest of each stretch, the first and the last
    of all, and what is no number. Also the length of a stretch, 1 if all are there."""
    count = len(values)
    if count <= points_max:
        return np.arange(count), 1
    stretch = -(-2 * count // points_max)
    starts = np.arange(0, count, stretch)
    padded = np.full(len(starts) * stretch, np.nan)
    padded[:count] = values
    rows = padded.reshape(-1, stretch)
    is_gap = np.isnan(rows)
    lowest, highest = (np.where(is_gap, worst, rows) for worst in (np.inf, -np.inf))
    found = np.concatenate((starts + lowest.argmin(axis=1), starts + highest.argmax(axis=1), [0, count - 1],
                            np.flatnonzero(np.isnan(values))))
    return np.unique(found), stretch


def with_gaps(time_s, values, period_s):
    """A NaN where samples are missing, so that no line is drawn across."""
    gaps = np.flatnonzero(np.diff(time_s) > 1.5 * period_s) + 1
    return np.insert(time_s, gaps, time_s[gaps] - 0.5 * period_s), np.insert(values, gaps, np.nan)


def clock_of(time_s, period_s):
    """A time axis as the page's script reads it: whole half periods since the sample before, where the times are
    that; else the times themselves."""
    if period_s and len(time_s) > 1:
        step_s = 0.5 * period_s
        steps = np.rint((time_s - time_s[0]) / step_s)
        if np.abs(time_s - time_s[0] - step_s * steps).max() < 1e-6 * period_s:
            deltas = np.diff(steps, prepend=0)
            kind = "<u2" if deltas.max() < 2**16 else "<u4"
            return {"start": float(time_s[0]), "step": step_s, "kind": kind[1:], "deltas": encoded(deltas, kind)}
    return {"samples": encoded(time_s, "<f8")}


class Page:
    """Collects what the page's script needs. `shown_s`: from when to when the page opens; None for all."""

    def __init__(self, period_s, shown_s=None):
        self.period_s = period_s
        self.shown_s = shown_s
        self.panels = []
        self.coarsest = 1
        self.left_out = []  # titles of panels in which nothing would be seen

    def curve(self, time_s, values, trace, only_s=None):
        """A curve of a panel. `only_s`: the times that its panel can show, where it is not linked with the others."""
        if only_s is not None:
            inside = (time_s >= only_s[0]) & (time_s <= only_s[1])
            time_s, values = time_s[inside], values[inside]
        return {"time_s": time_s, "values": np.asarray(values, float), "trace": trace}

    def curve_of(self, signal, unit, only_s=None):
        line = {"color": signal.colour, "dash": signal.dash}
        if signal.is_step:
            line["shape"] = "hv"
        trace = {"type": "scatter", "mode": "lines", "name": signal.label, "line": line,
                 "hovertemplate": f"%{{y:.6~g}} {unit}"}
        if signal.is_second_axis:
            trace["yaxis"] = "y2"
        return self.curve(*with_gaps(signal.time_s, signal.values, self.period_s), trace, only_s)

    def add(self, name, title, note, curves, layout, height_px=300, **more):
        layered([curve["trace"] for curve in curves])
        self.panels.append({"name": name, "title": title, "note": note, "curves": curves, "layout": layout,
                            "height": height_px, "bars": [], "linked": True} | more)

    def add_signals(self, name, title, note, found, axis_title, unit, layout=None, **more):
        layout = {"yaxis": AXIS | {"title": {"text": axis_title}}} | (layout or {})
        own_s = more.get("range")
        if not any(np.nan_to_num(signal.values).any() for signal in found):
            self.left_out.append(title)
            return
        self.add(name, title, note, [self.curve_of(signal, unit, own_s) for signal in found], layout, **more)

    def picked(self, curve, points_max):
        """Indices of a curve's samples that go into the page."""
        found, stretch = extremes(curve["values"], points_max)
        if stretch > 1 and self.shown_s is not None:
            first, end = np.searchsorted(curve["time_s"], self.shown_s)
            shown, stretch_shown = extremes(curve["values"][first:end], points_max)
            found = np.union1d(found, first + shown)
            self.coarsest_shown = max(self.coarsest_shown, stretch_shown)
        self.coarsest = max(self.coarsest, stretch)
        return found

    def data(self, start_s, end_s):
        """What the page's script reads, as JSON that can stand in a script element."""
        self.coarsest_shown = 1
        count = sum(len(panel["curves"]) for panel in self.panels)
        share = CURVES_MAX_BYTES / POINT_BYTES / max(1, count) / (1 if self.shown_s is None else 2)
        points_max = int(min(POINTS_MAX, max(POINTS_MIN, share)))
        clocks, panels = [], []
        for panel in self.panels:
            curves = []
            for curve in panel["curves"]:
                chosen = self.picked(curve, points_max)
                clock = clock_of(curve["time_s"][chosen], self.period_s)
                if clock not in clocks:
                    clocks.append(clock)
                curves.append({"clock": clocks.index(clock), "samples": encoded(curve["values"][chosen], "<f4"),
                               "trace": curve["trace"]})
            panels.append(panel | {"curves": curves})
        data = {"clocks": clocks, "panels": panels, "axis": AXIS, "range": [start_s, end_s],
                "shown": list(self.shown_s or (start_s, end_s))}
        return script_safe(json.dumps(data, separators=(",", ":"), allow_nan=False))

    def left_out_words(self):
        """Which plots are not drawn; nothing where all are."""
        return f"Not drawn, as all of it is 0 throughout: {'; '.join(self.left_out)}." if self.left_out else ""

    def thinning_words(self):
        """What a reader has to know of the samples that are not there; nothing where all are."""
        if self.coarsest == 1:
            return ""
        of_all = f"of every {self.coarsest} samples the lowest and the highest are drawn"
        if self.shown_s is None:
            return f"The page is thinned: {of_all}. The log holds all."
        if self.coarsest_shown > 1:
            return (f"The page is thinned: of every {self.coarsest_shown} samples in the part that it opens on, and of every "
                    f"{self.coarsest} elsewhere, the lowest and the highest are drawn. The log holds all.")
        return f"The page is thinned: outside of the part that it opens on, {of_all}. The log holds all."


def layered(traces):
    """Lines that lie on each other stay visible: each is narrower than the one below it."""
    lines = [trace["line"] for trace in traces if "line" in trace]
    for i, line in enumerate(lines):
        line.setdefault("width", round(1.6 + 0.9 * (len(lines) - 1 - i), 1))
    return traces


def script_safe(text):
    """Text that cannot end the script element it stands in."""
    return text.replace("</", "<\\/")


def text_of(*names):
    """Files of this folder, one after another."""
    return "\n".join((HERE / name).read_text(encoding="utf-8") for name in names)


def filled(template, parts):
    """The head of every page and a template of this folder, with @@name@@ replaced by parts[name]."""
    pieces = text_of("page_head.html", template).split("@@")
    return "".join(parts[piece] if i % 2 else piece for i, piece in enumerate(pieces))


def shared_parts(path, styles, scripts):
    """The parts that every template has, for a page at `path`: style, scripts, and the address of plotly."""
    return {"style": text_of("page.css", *styles), "script": script_safe(text_of("page_plots.js", *scripts)),
            "plotly": plotly_address(path)}
