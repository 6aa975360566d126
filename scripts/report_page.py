"""The HTML report: one file that opens without a network. Signals go into it whole, as 32-bit numbers in base64; the
page's own script draws as many of them as the screen can show, and every sample once zoomed in."""
import base64
import html
import json
from pathlib import Path

import numpy as np
from plotly.offline import get_plotlyjs

import report_accuracy
import report_arm
import report_delay
import report_reduction
import report_signals as signals
import report_words as told

HERE = Path(__file__).resolve().parent

# Samples that a page keeps of one signal. Longer runs are thinned out to the lowest and highest of each stretch.
SAMPLES_MAX = 60_000
# Stretches that a row of the state band may have before close ones are drawn as one.
BARS_PER_ROW_MAX = 400

AXIS = {"gridcolor": "#E6E6E6", "zeroline": True, "zerolinecolor": "#CCCCCC", "linecolor": "#999999",
        "ticks": "outside", "tickcolor": "#999999", "showline": True}


def encoded(values, kind):
    return base64.b64encode(np.ascontiguousarray(values, dtype=kind).tobytes()).decode()


def thinned(time_s, values, samples_max=SAMPLES_MAX):
    """At most `samples_max` samples: the lowest and the highest of each stretch, in their order. Also the length of a
    stretch, 1 if all samples are there."""
    stretch = -(-len(values) // (samples_max // 2)) if len(values) > samples_max else 1
    if stretch == 1:
        return time_s, values, 1
    whole = len(values) // stretch * stretch
    blocks = values[:whole].reshape(-1, stretch)
    first = np.arange(0, whole, stretch)
    picked = np.unique(np.concatenate((first + blocks.argmin(axis=1), first + blocks.argmax(axis=1),
                                       np.arange(whole, len(values)))))
    return time_s[picked], values[picked], stretch


def with_gaps(time_s, values, period_s):
    """A NaN where samples are missing, so that no line is drawn across."""
    gaps = np.flatnonzero(np.diff(time_s) > 1.5 * period_s) + 1
    return np.insert(time_s, gaps, time_s[gaps] - 0.5 * period_s), np.insert(values, gaps, np.nan)


class Page:
    """Collects what the page's script needs."""

    def __init__(self, log=None, samples_max=SAMPLES_MAX):
        self.log = log
        self.samples_max = samples_max
        self.clocks = []  # time axes, shared between signals
        self.panels = []
        self.coarsest = 1

    def clock(self, time_s):
        """Place of a time axis in `clocks`; evenly spaced ones need no samples."""
        clock = {"samples": encoded(time_s, "<f8")}
        if len(time_s) > 1:
            step_s = (time_s[-1] - time_s[0]) / (len(time_s) - 1)
            if np.abs(np.diff(time_s) - step_s).max() < 1e-9:
                clock = {"start": time_s[0], "step": step_s, "count": len(time_s)}
        if clock not in self.clocks:
            self.clocks.append(clock)
        return self.clocks.index(clock)

    def curve(self, time_s, values, trace):
        """Adds the samples to a plotly trace."""
        time_s, values, stretch = thinned(time_s, values, self.samples_max)
        self.coarsest = max(self.coarsest, stretch)
        return {"clock": self.clock(time_s), "samples": encoded(values, "<f4"), "trace": trace}

    def curve_of(self, signal, unit):
        line = {"color": signal.colour, "width": 1.6, "dash": signal.dash}
        if signal.is_step:
            line["shape"] = "hv"
        trace = {"type": "scatter", "mode": "lines", "name": signal.label, "line": line,
                 "hovertemplate": f"%{{y:.6~g}} {unit}"}
        if signal.is_second_axis:
            trace["yaxis"] = "y2"
        time_s, values = with_gaps(signal.time_s, signal.values, self.log.period_s)
        return self.curve(time_s, values, trace)

    def add(self, name, title, note, curves, layout, height_px=300, **more):
        self.panels.append({"name": name, "title": title, "note": note, "curves": curves, "layout": layout,
                            "height": height_px, "bars": [], "linked": True} | more)

    def add_signals(self, name, title, note, found, axis_title, unit, layout=None, **more):
        layout = {"yaxis": AXIS | {"title": {"text": axis_title}}} | (layout or {})
        self.add(name, title, note, [self.curve_of(signal, unit) for signal in found], layout, **more)

    def data(self, start_s, end_s):
        """What the page's script reads, as JSON that can stand in a script element."""
        data = {"clocks": self.clocks, "panels": self.panels, "axis": AXIS, "range": [start_s, end_s]}
        return script_safe(json.dumps(data, separators=(",", ":"), allow_nan=False))


def rest_shapes(log):
    """Grey behind the times at which the robot may not move."""
    stretches = signals.not_running(log)
    return [{"type": "rect", "x0": start, "x1": end, "yref": "paper", "y0": 0, "y1": 1, "fillcolor": "#F0F0F0",
             "line": {"width": 0}, "layer": "below"} for start, end in stretches[:50]]


def add_positions(page):
    log = page.log
    layout = {"shapes": rest_shapes(log), "annotations": []}
    note = "Grey: the supervisor does not let the robot move."
    if log.is_contact:
        surface_mm = 1e3 * log.config["object"]["surface_position_m"]
        layout["shapes"].append({"type": "line", "xref": "paper", "x0": 0, "x1": 1, "y0": surface_mm,
                                 "y1": surface_mm, "line": {"color": signals.OBJECT, "width": 1, "dash": "dash"}})
        layout["annotations"].append({"xref": "paper", "x": 1, "xanchor": "right", "y": surface_mm,
                                      "yanchor": "bottom", "text": "surface", "showarrow": False,
                                      "font": {"color": signals.OBJECT}})
        note += " Green dashes: surface of the material, which is met from below."
    page.add_signals("positions", "Positions", note, signals.positions(log), "position (mm)", "mm", layout,
                     height_px=360)


def add_forces(page):
    page.add_signals("forces", "Forces",
                     "The sensor spring, what the sensor makes of it, and what the loop works with, after the delay "
                     "of the sensor. All are drawn as they were at the ticks; the spring's force also jumps between.",
                     signals.forces(page.log), "force (N)", "N", {"shapes": rest_shapes(page.log)})


def second_axis(title):
    return {"yaxis2": AXIS | {"title": {"text": title}, "overlaying": "y", "side": "right", "showgrid": False,
                              "tickmode": "auto"}}


def add_sides(page):
    """The robot's axes beside that of the loop."""
    log = page.log
    shapes = {"shapes": rest_shapes(log)}
    panels = (("side-ways", "Pose: ways beside the direction", signals.sides(log, False), "way (mm)", "mm", shapes),
              ("side-turns", "Pose: turns", signals.sides(log, True), "turn (mrad)", "mrad", shapes),
              ("side-loads", "Loads beside the direction", signals.side_loads(log), "force (N)", "",
               shapes | second_axis("torque (N m)")))
    for name, title, found, axis_title, unit, layout in panels:
        if found:
            page.add_signals(name, title, "In the robot's frame: x is the direction of the loop.", found, axis_title, unit,
                             layout)


def add_energy(page):
    found = signals.energies(page.log)
    if found:
        page.add_signals("energy", "Energy",
                         "Sums since the loop began to run, and what is stored in the manipulator. Between the force that "
                         "the loop uses and the motion that the robot makes lies the dead time: what it makes comes "
                         "from nowhere.",
                         found, "energy (J)", "J", {"shapes": rest_shapes(page.log)})


def add_compensation(page):
    """What goes on in the units that are switched on."""
    log = page.log
    shapes = {"shapes": rest_shapes(log)}

    panels = (
        ("prediction", "Prediction: what the model does not know", signals.prediction_error(log), "force (N)", "N",
         shapes, "The twin of the hardware moves along with the setpoints. What the sensor shows beyond it is fed back; "
         "0 where the model is right."),
        ("identified", "Identification: the object", signals.believed_object(log), "share of what was told (%)", "",
         shapes | second_axis("damping (N s/m)"), "A motion at a single frequency does not tell mass from stiffness: they "
         "may settle at other values with the same force."),
        ("tracked", "Identification: the robot's dead time", signals.believed_dead_time(log), "dead time (ms)", "ms",
         shapes, "From the positions that the robot reports. It only learns while the robot moves."),
        ("inverse", "Adaptive inverse: the robot", signals.inverse(log), "delay (ms)", "ms", shapes | second_axis("gain"),
         "Setpoints are gain x + delay x' + ..., by which the robot is where the manipulator is. Learnt from the "
         "positions that it reports."),
        ("lead", "Force lead: what the model does not know", signals.lead_error(log), "force (N)", "N", shapes,
         "Against the model's force as it was when the sample was taken; 0 where model and age are right."),
        ("passivity", "Passivity: energy out of nothing", signals.passivity(log), "deficit (J)", "",
         shapes | second_axis("force (N)"), "Above 0 the manipulator has got energy that the hardware never had: the "
         "controller takes it back."))
    for name, title, found, axis_title, unit, layout, note in panels:
        if found:
            page.add_signals(name, title, note, found, axis_title, unit, layout)


def add_dead_time(page):
    log = page.log
    found = signals.dead_time(log)
    if found is None:
        return
    late_ms = 1e3 * (found.robot_s - found.command_s)
    arrow = {"x": found.robot_s, "y": found.level_mm, "ax": found.command_s, "ay": found.level_mm, "axref": "x",
             "ayref": "y", "text": "", "arrowhead": 2, "arrowwidth": 2, "arrowcolor": "#333333"}
    label = {"x": found.robot_s, "y": found.level_mm, "xanchor": "left", "yanchor": "top", "xshift": 8,
             "text": f"<b>{late_ms:.2f} ms</b>", "showarrow": False, "font": {"size": 14},
             "bgcolor": "rgba(255,255,255,0.8)"}
    page.add_signals("dead-time", "Dead time: command and robot",
                     f"Where the command is fastest, the robot passes the same place {late_ms:.2f} ms later "
                     f"(configured dead time: {log.config['robot']['dead_time_ms']:g} ms). This plot has its own "
                     "time axis.",
                     signals.command_and_robot(log), "position (mm)", "mm",
                     {"annotations": [arrow, label]}, linked=False, range=[found.from_s, found.to_s])


def height_range(height_mm, used):
    """Powers of ten between which an envelope is worth looking at: far below the fit there is only rounding."""
    least_mm = 0.01 * height_mm[used].min() if used.any() else 1e-6 * height_mm.max()
    shown = height_mm[height_mm > max(least_mm, 1e-12)]
    return [float(np.log10(shown.min())) - 0.2, float(np.log10(shown.max())) + 0.2] if shown.size else [-3, 0]


def height_ticks(low, high):
    """An axis from one power of ten to another: labels at whole powers, or where plotly likes them if there are too few."""
    decades = high - low
    ticks = {"dtick": max(1, round(decades / 6))} if decades > 2 else {}
    return {"range": [low, high], "exponentformat": "power"} | ticks


def add_envelope(page, summary):
    envelope = summary["envelope"]
    time_s = np.array(envelope["time_s"])
    height_mm = 1e3 * np.array(envelope["height_m"])
    if len(time_s) == 0:
        return
    used = np.zeros(len(time_s), dtype=bool)
    fit = []
    note = "Height between successive extremes of the manipulator's free motion. "
    if told.measured_growth(summary) is not None:
        start_s, end_s = envelope["fit_from_s"], envelope["fit_to_s"]
        used = (time_s >= start_s - 1e-9) & (time_s <= end_s + 1e-9)
        line_s = np.linspace(start_s, end_s, 50)
        line_mm = 1e3 * envelope["fit_height_from_m"] * np.exp(summary["growth_per_s"] * (line_s - start_s))
        name = f"fitted exponential: {summary['growth_per_s']:+.6f} /s".replace("-", "−")
        fit.append(page.curve(line_s, line_mm, {"type": "scatter", "mode": "lines", "name": name,
                                                "line": {"color": signals.ROBOT, "width": 2.5},
                                                "hovertemplate": "%{y:.4~g} mm"}))
        note += f"The line is the fit that gives the growth rate, ± {summary['growth_ci95_per_s']:.1g} /s (95 %)."
    else:
        note += "They give no growth rate that is larger than its interval."
    heights = [page.curve(time_s[chosen], height_mm[chosen],
                          {"type": "scatter", "mode": "markers", "name": name,
                           "marker": {"color": signals.MANIPULATOR, "size": 6, "symbol": symbol},
                           "hovertemplate": "%{y:.4~g} mm"})
               for name, chosen, symbol in (("used by the fit", used, "circle"),
                                           ("left out of the fit", ~used, "circle-open"))
               if chosen.any()]
    axis = AXIS | {"title": {"text": "height, peak to peak (mm)"}, "type": "log"} | height_ticks(*height_range(height_mm, used))
    page.add("envelope", "Envelope and growth", note, heights + fit, {"yaxis": axis})


def merged(bars, shortest_gap_s):
    """Bars of one row, those less than a gap apart as one."""
    result = []
    for bar in bars:
        if result and bar.label == result[-1]["label"] and bar.start_s - result[-1]["end"] < shortest_gap_s:
            result[-1]["end"] = bar.end_s
        else:
            result.append({"row": bar.row, "label": bar.label, "colour": bar.colour, "start": bar.start_s,
                           "end": bar.end_s})
    return result


def add_band(page):
    log = page.log
    rows = {}
    for bar in signals.bars(log):
        rows.setdefault(bar.row, []).append(bar)
    bars = []
    duration_s = log.tick_s[-1] - log.tick_s[0] + log.period_s
    for found in rows.values():
        bars += merged(found, duration_s / BARS_PER_ROW_MAX if len(found) > BARS_PER_ROW_MAX else 0.0)
    quiet = [row for row in ("stopped because", "limit") if not any(name.startswith(row) for name in rows)]
    note = {"stopped because": "The robot was never stopped. ", "limit": "No limit acted. "}
    page.add("band", "Supervisor and limits", "".join(note[row] for row in quiet), [],
             {"yaxis": AXIS | {"autorange": "reversed", "type": "category", "categoryorder": "array",
                               "categoryarray": list(rows), "showgrid": False, "ticks": "", "fixedrange": True,
                               "tickfont": {"size": 12}},
              "barmode": "overlay", "bargap": 0.25, "hovermode": "closest", "showlegend": False,
              "uniformtext": {"mode": "hide", "minsize": 10}}, height_px=80 + 30 * len(rows), bars=bars)


def add_health(page):
    log = page.log
    lateness_us = 1e-3 * np.max(log.tick["woke_ns"] - log.tick["scheduled_ns"])
    second = AXIS | {"title": {"text": "lateness (µs)"}, "overlaying": "y", "side": "right", "showgrid": False,
                     "rangemode": "tozero", "tickmode": "auto"}
    if lateness_us == 0:
        second["range"] = [0, 1]
    page.add_signals("timing", "Loop health: timing",
                     "How long ago the force that each tick uses arrived, and how late the loop woke "
                     + ("(never: the simulation owns the time)." if lateness_us == 0 else "after its due time."),
                     signals.timing(log), "", "",
                     {"yaxis": AXIS | {"title": {"text": "force age (ms)"}, "rangemode": "tozero"},
                      "yaxis2": second}, height_px=240)
    found = signals.counts(log)
    highest = max(signal.values[-1] for signal in found)
    axis = AXIS | {"title": {"text": "total (1)"}, "rangemode": "tozero", "tickformat": "~d"}
    if highest == 0:
        axis["range"] = [0, 1]
        axis["nticks"] = 2
    page.add_signals("counts", "Loop health: missed ticks and lost frames",
                     "There were none." if highest == 0 else "Totals since the start.", found, "", "",
                     {"yaxis": axis}, height_px=220)


def config_table(log, assumed):
    """The resolved configuration as HTML; what decides and was not stated is marked."""
    keys = {one["key"] for one in assumed}
    lines = []
    section = ""
    for row in log.config_rows:
        if row.section != section:
            section = row.section
            lines.append(f'<tr class="section"><th colspan="3">[{html.escape(section)}]</th></tr>')
        mark = "assumed: " if f"{row.section}.{row.key}" in keys else ""
        lines.append(f"<tr><td>{html.escape(row.key)}</td><td>{html.escape(row.value)}</td>"
                     f"<td>{mark}{html.escape(row.note)}</td></tr>")
    return "\n".join(lines)


def fact_tiles(found):
    return "\n".join(f'<div class="fact"><dt>{html.escape(name)}</dt><dd>{html.escape(value)}</dd>'
                     f'<dd class="remark">{html.escape(remark)}</dd></div>' for name, value, remark in found)


def script_safe(text):
    """Text that cannot end the script element it stands in."""
    return text.replace("</", "<\\/")


def filled(template, parts):
    """A template of this folder with @@name@@ replaced by parts[name]."""
    pieces = (HERE / template).read_text(encoding="utf-8").split("@@")
    return "".join(parts[piece] if i % 2 else piece for i, piece in enumerate(pieces))


def build_page(log, summary, accuracy=None, sweeps=None):
    """The whole page as text. `accuracy`: what `berth accuracy` found of the run's arm, see report_accuracy; `sweeps`: what
    `berth reduce` found of it, see report_reduction."""
    page = Page(log)
    if len(log.tick_s):
        add_positions(page)
        add_dead_time(page)
        add_forces(page)
        add_sides(page)
        add_energy(page)
        add_compensation(page)
        add_envelope(page, summary)
        add_band(page)
        add_health(page)
    verdict = told.verdict(log, summary)
    notes = list(verdict.notes)
    if page.coarsest > 1:
        notes.append(f"The run is long: of every {page.coarsest} samples the lowest and the highest are shown.")
    end_s = float(log.tick_s[-1] + log.period_s) if len(log.tick_s) else 0.0
    start_s = float(log.tick_s[0]) if len(log.tick_s) else 0.0
    parts = {
        "title": html.escape(log.config["name"]),
        "description": html.escape(log.config["description"]),
        "verdict": html.escape(verdict.word),
        "verdict_colour": verdict.colour,
        "alarm": f'<strong class="alarm">{html.escape(verdict.alarm)}</strong>' if verdict.alarm else "",
        "sentence": html.escape(verdict.sentence),
        "notes": "\n".join(f"<li>{html.escape(note)}</li>" for note in notes),
        "facts": fact_tiles(told.facts(log, summary)),
        "delay": report_delay.section(summary["delay_budget"]),
        "config": config_table(log, summary["assumed"]),
        "config_hash": html.escape(log.config_hash),
        "version": html.escape(log.version),
        "log": html.escape(log.path.name),
        "replay": html.escape(f"build/berth replay {log.path}"),
        "style": (HERE / "report_page.css").read_text(encoding="utf-8"),
        "data": page.data(start_s, end_s),
        "script": script_safe((HERE / "report_page.js").read_text(encoding="utf-8")),
        "accuracy": report_accuracy.section(accuracy),
        "reduction": report_reduction.section(log, sweeps),
        "arm": script_safe(report_arm.scene(log)),
        "arm_script": script_safe((HERE / "report_arm.js").read_text(encoding="utf-8")),
        "plotly": get_plotlyjs(),
    }
    return filled("report_page.html", parts)
