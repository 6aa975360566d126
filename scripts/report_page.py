"""The HTML report of a run: verdict, margin, advice and delay budget, then the signals over time. It opens on the part
that matters, and without a network; its plots need the script file that all pages share, see page_data."""
import html
import json
import math

import numpy as np

import report_accuracy
import report_arm
import report_delay
import report_reduction
import report_signals as signals
import report_words as told
from page_data import AXIS, VERDICT_CLASSES, Page, filled, script_safe, shared_parts

# Stretches that a row of the state band may have before close ones are drawn as one.
BARS_PER_ROW_MAX = 400


def rest_shapes(log):
    """Grey behind the times at which the robot may not move."""
    stretches = signals.not_running(log)
    return [{"type": "rect", "x0": start, "x1": end, "yref": "paper", "y0": 0, "y1": 1, "fillcolor": "#F0F0F0",
             "line": {"width": 0}, "layer": "below"} for start, end in stretches[:50]]


def add_positions(page, log):
    note = "Grey: the supervisor does not let the robot move."
    found = signals.positions(log)
    if log.is_contact:
        surface_mm = np.full(len(log.tick_s), 1e3 * log.config["object"]["surface_position_m"])
        found.append(signals.Signal("surface", signals.OBJECT, log.tick_s, surface_mm, "dash"))
        note += " Green dashes: surface of the material; the tool meets it from below."
    page.add_signals("positions", "Positions", note, found, "position (mm)", "mm", {"shapes": rest_shapes(log)},
                     height_px=360)


def add_following(page, log):
    page.add_signals("following", "Following error",
                     "Command less position of the robot, at the same tick: what the dead time and the robot leave.",
                     signals.following(log), "error (mm)", "mm", {"shapes": rest_shapes(log)}, height_px=220)


def add_forces(page, log):
    page.add_signals("forces", "Forces",
                     "The sensor spring, what the sensor makes of it, and what the loop works with, after the delay "
                     "of the sensor. All are drawn as they were at the ticks; the spring's force also jumps between.",
                     signals.forces(log), "force (N)", "N", {"shapes": rest_shapes(log)})


def second_axis(title):
    return {"yaxis2": AXIS | {"title": {"text": title}, "overlaying": "y", "side": "right", "showgrid": False,
                              "tickmode": "auto"}}


def add_sides(page, log):
    """The robot's axes across the direction of the loop."""
    shapes = {"shapes": rest_shapes(log)}
    panels = (("side-translation", "Pose: lateral translation", signals.sides(log, False), "translation (mm)", "mm", shapes),
              ("side-rotation", "Pose: rotation", signals.sides(log, True), "rotation (mrad)", "mrad", shapes),
              ("side-loads", "Lateral forces and torques", signals.side_loads(log), "force (N)", "",
               shapes | second_axis("torque (N m)")))
    for name, title, found, axis_title, unit, layout in panels:
        if found:
            page.add_signals(name, title, "In the robot's frame. x is the direction of the loop; lateral is across it.", found, axis_title, unit,
                             layout)


def add_energy(page, log):
    found = signals.energies(log)
    if found:
        page.add_signals("energy", "Energy",
                         "Sums since the loop began to run, and what is stored in the manipulator. Between the force that "
                         "the loop uses and the motion that the robot makes lies the dead time: what it makes comes "
                         "from nowhere.",
                         found, "energy (J)", "J", {"shapes": rest_shapes(log)})


def add_compensation(page, log):
    """What goes on in the units that are switched on."""
    shapes = {"shapes": rest_shapes(log)}

    panels = (
        ("prediction", "Prediction: what the model does not know", signals.prediction_error(log), "force (N)", "N",
         shapes, "The twin of the hardware moves along with the setpoints. What the sensor shows beyond it is fed back; "
         "0 where the model is right."),
        ("identified", "Identification: the object", signals.believed_object(log), "share of what was given (%)", "",
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


def add_dead_time(page, log):
    found = signals.dead_time(log)
    if found is None:
        return
    late_ms = 1e3 * (found.robot_s - found.command_s)
    reports = "reports that it " if found.is_reported else ""
    arrow = {"x": found.robot_s, "y": found.level_mm, "ax": found.command_s, "ay": found.level_mm, "axref": "x",
             "ayref": "y", "text": "", "arrowhead": 2, "arrowwidth": 2, "arrowcolor": "#333333"}
    # Where the motion falls, the curves go on below.
    falls = np.interp(found.robot_s, log.tick_s, 1e3 * log.tick["command_position_m"]) < found.level_mm
    label = {"x": found.robot_s, "y": found.level_mm, "xanchor": "left", "yanchor": "bottom" if falls else "top", "xshift": 8,
             "text": f"<b>{late_ms:.2f} ms{', reported' if found.is_reported else ''}</b>", "showarrow": False, "font": {"size": 14},
             "bgcolor": "#FFFFFFCC"}
    page.add_signals("dead-time", "Dead time: command and robot",
                     f"Where the command is fastest, the robot {reports}passes the same place {late_ms:.2f} ms later "
                     f"(configured dead time: {log.config['robot']['dead_time_ms']:g} ms). This plot has its own "
                     "time axis.",
                     signals.command_and_robot(log), "position (mm)", "mm",
                     {"annotations": [arrow, label]}, linked=False, range=[found.from_s, found.to_s])


RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def height_ticks(low, high):
    """An axis from one power of ten to another: labels at whole powers, at 1, 2 and 5 of each if these are few, or where
    plotly likes them."""
    decades = high - low
    axis = {"range": [low, high], "exponentformat": "power"}
    if decades > 3:  # plotly's own labels of powers are a quarter larger than those of the other axes
        powers = range(math.ceil(low), math.floor(high) + 1, max(1, round(decades / 6)))
        return axis | {"tickvals": [10.0 ** power for power in powers],
                       "ticktext": ["10" + str(power).translate(RAISED) for power in powers]}
    if decades > 0.7:
        values = [float(f"{digit}e{power}") for power in range(math.floor(low), math.ceil(high) + 1) for digit in (1, 2, 5)]
        return axis | {"tickvals": values, "ticktext": [f"{value:g}" for value in values]}
    return axis


def add_envelope(page, log, summary):
    envelope = summary["envelope"]
    time_s = np.array(envelope["time_s"])
    height_mm = 1e3 * np.array(envelope["height_m"])
    held = signals.cycle(log, summary)
    if len(time_s) == 0 and held is None:
        return
    used = np.zeros(len(time_s), dtype=bool)
    from_s, to_s = page.shown_s or span(log)
    fit, own_axis = [], {}
    note = "Height, peak to peak, between successive extremes of the manipulator's free motion. "
    if told.measured_growth(summary) is not None:
        start_s, end_s = envelope["fit_from_s"], envelope["fit_to_s"]
        used = (time_s >= start_s - 1e-9) & (time_s <= end_s + 1e-9)
        line_s = np.linspace(start_s, end_s, 50)
        line_mm = 1e3 * envelope["fit_height_from_m"] * np.exp(summary["growth_per_s"] * (line_s - start_s))
        growth = told.with_interval(summary["growth_per_s"], summary["growth_ci95_per_s"])
        name = f"fitted exponential: {growth} /s"
        fit.append(page.curve(line_s, line_mm, {"type": "scatter", "mode": "lines", "name": name,
                                                "line": {"color": signals.ROBOT, "width": 2.5},
                                                "hovertemplate": "%{y:.4~g} mm"}))
        note += f"The line is the fit that gives the growth rate, ± {summary['growth_ci95_per_s']:.1g} /s (95 %). "
        if end_s > to_s and held is None:  # most of the fit lies behind what the page opens on
            to_s = min(1.02 * end_s, span(log)[1])
            own_axis = {"linked": False, "range": [from_s, to_s]}
            note += "This plot has its own time axis, so that all of the fit is seen."
    elif held is None:
        note += "The growth that they give is smaller than its uncertainty."
    if held is not None:
        note += f"From {held.from_s:.3g} s on the limits hold the swing as a cycle."
    heights = [page.curve(time_s[chosen], height_mm[chosen],
                          {"type": "scatter", "mode": "markers", "name": name,
                           "marker": {"color": signals.MANIPULATOR, "size": 6, "symbol": symbol},
                           "hovertemplate": "%{y:.4~g} mm"})
               for name, chosen, symbol in (("used by the fit", used, "circle"),
                                           ("left out of the fit", ~used, "circle-open"))
               if chosen.any()]
    if held is not None:
        heights.append(page.curve(held.time_s, held.heights_mm,
                                  {"type": "scatter", "mode": "markers", "name": "a period of the cycle",
                                   "marker": {"color": signals.COMMAND, "size": 6, "symbol": "circle"},
                                   "hovertemplate": "%{y:.4~g} mm"}))
        height_mm, used, time_s = (np.append(one, of_cycle) for one, of_cycle in
                                   ((height_mm, held.heights_mm), (used, np.ones(len(held.heights_mm), bool)),
                                    (time_s, held.time_s)))
    seen = (time_s >= from_s) & (time_s <= to_s)
    axis = AXIS | {"title": {"text": "height (mm)"}, "type": "log"} \
        | height_ticks(*signals.height_range(height_mm, used, seen if seen.any() else np.ones(len(seen), bool)))
    page.add("envelope", "Envelope and growth", note, heights + fit, {"yaxis": axis}, **own_axis)


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


def add_band(page, log):
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


def add_health(page, log):
    """How old the force was and how late the loop woke; totals of what went wrong, if anything did."""
    found = signals.timing(log)
    is_ever_late = len(found) > 1
    missed = signals.counts(log)
    layout = {"yaxis": AXIS | {"title": {"text": "force age (ms)"}, "rangemode": "tozero"}}
    if is_ever_late:
        layout |= second_axis("lateness (µs)")
        layout["yaxis2"]["rangemode"] = "tozero"
    note = "How long ago the force that each tick uses arrived. "
    note += "Lateness is the time from when a tick was due to when the loop woke. " if is_ever_late else \
        "The loop never woke late. "
    if not missed:
        note += "No tick was missed, no frame was rejected, lost or in error."
    page.add_signals("timing", "Loop health", note, found, "", "", layout, height_px=240)
    if missed:
        page.add_signals("counts", "Missed ticks and lost frames", "Totals since the start.", missed, "", "",
                         {"yaxis": AXIS | {"title": {"text": "total (1)"}, "rangemode": "tozero", "tickformat": "~d"}},
                         height_px=220)


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


def told_list(found):
    return "\n".join(f"<dt>{html.escape(name)}</dt><dd>{html.escape(value)}</dd>" for name, value in found)


def fact_tiles(found):
    return "\n".join(f'<div class="fact"><dt>{html.escape(name)}</dt><dd>{html.escape(value)}</dd>'
                     f'<dd class="remark">{html.escape(remark)}</dd></div>' for name, value, remark in found)


def span(log):
    """First and last moment of the log in s."""
    if len(log.tick_s) == 0:
        return 0.0, 0.0
    return float(log.tick_s[0]), float(log.tick_s[-1] + log.period_s)


def fill(page, log, summary):
    """All panels of a run that has ticks."""
    add_positions(page, log)
    add_following(page, log)
    add_forces(page, log)
    add_dead_time(page, log)
    add_energy(page, log)
    add_envelope(page, log, summary)
    add_sides(page, log)
    add_compensation(page, log)
    add_band(page, log)
    add_health(page, log)


def build_page(log, summary, path, accuracy=None, sweeps=None):
    """The whole page as text, for a file at `path`. `accuracy`: what `berth accuracy` found of the run's arm, see
    report_accuracy; `sweeps`: what `berth reduce` found of it, see report_reduction."""
    whole_s = span(log)
    shown_s = signals.part_that_matters(log, summary)
    page = Page(log.period_s, None if shown_s == whole_s else shown_s)
    if len(log.tick_s):
        fill(page, log, summary)
    data = page.data(*whole_s)
    verdict = told.verdict(log, summary)
    notes = [*verdict.notes, page.left_out_words(), page.thinning_words()]
    parts = shared_parts(path, ("report_arm.css",), ("report_page.js", "figures_page.js", "report_arm.js")) | {
        "kind": "berth run report",
        "title": html.escape(log.config["name"]),
        "description": html.escape(log.config["description"]),
        "verdict": html.escape(verdict.word),
        "verdict_class": VERDICT_CLASSES[verdict.colour],
        "alarm": f'<span class="alarm">{html.escape(verdict.alarm)}</span>' if verdict.alarm else "",
        "sentence": html.escape(verdict.sentence),
        "told": told_list(told.margin_and_advice(log, summary)),
        "notes": "\n".join(f"<li>{html.escape(note)}</li>" for note in notes if note),
        "facts": fact_tiles(told.facts(log, summary)),
        "delay": report_delay.section(summary["delay_budget"]),
        "config": config_table(log, summary["assumed"]),
        "config_hash": html.escape(log.config_hash),
        "version": html.escape(log.version),
        "log": html.escape(log.path.name),
        "replay": html.escape(f"build/berth replay {log.path}"),
        "data": data,
        "accuracy": report_accuracy.section(accuracy),
        "reduction": report_reduction.section(log, sweeps),
        "plots": script_safe(json.dumps(report_reduction.plots(log, sweeps) + report_accuracy.plots(accuracy), allow_nan=False)),
        "arm": script_safe(report_arm.scene(log)),
    }
    return filled("report_page.html", parts)
