"""The report of a diagnosis as one HTML page that opens without a network: time series that zoom together, and plots of
the errors over position, velocity and frequency. See page_data for the samples that it holds."""
import html
import json
import tomllib

import numpy as np

import diagnosis_stability as stability
import diagnosis_words as words
from diagnosis_data import profile, spectrum
from figures_page import plot_place
from page_data import AXIS, VERDICT_CLASSES, Page, filled, layered, script_safe, shared_parts, with_gaps
from report_signals import COMMAND, MANIPULATOR, ROBOT

BEFORE, AFTER, MEASURED, FLOOR = ROBOT, MANIPULATOR, "#222222", "#009E73"
CHOSEN, OTHER, RIVAL = MANIPULATOR, "#BBBBBB", COMMAND
PARTS = (("as given", "before"), ("re-tuned", "retuned"), ("extended", "after"), ("floor", "floor"))


def table(head, rows, name="", marked=()):
    """A cell is text, or text and attributes; the rows whose places are in `marked` get a mark. A phone shows each row as a
    card, where a cell has its title in front."""
    titles = [one[0] if isinstance(one, tuple) else one for one in head]

    def cell(found, tag, title):
        text, attributes = found if isinstance(found, tuple) else (found, "")
        of_card = f' data-title="{html.escape(title)}"' if tag == "td" and title else ""
        return f"<{tag} {attributes}{of_card}>{html.escape(str(text))}</{tag}>"

    def line(cells, tag, attributes=""):
        return f"<tr{attributes}>{''.join(cell(one, tag, title) for one, title in zip(cells, titles))}</tr>"
    body = "\n".join(line(cells, "td", ' class="at-fault"' if i in marked else "") for i, cells in enumerate(rows))
    return (f'<div class="wide cards"><table id="{name}">\n<thead>{line(head, "th")}</thead>\n<tbody>\n{body}\n</tbody>\n'
            f"</table></div>")


def number(text, of):
    """A cell that shows the number at this place of diagnosis.json."""
    return text, f'class="number" data-of="{of}"'


def right(*titles):
    return [(title, 'class="number"') for title in titles]


def blocks_table(diagnosis):
    rows = []
    for i, block in enumerate(diagnosis.blocks):
        cells = [words.place(block), block.told["verdict"].replace("_", " ")]
        for part in ("fit", "held_out"):
            told = block.told["residual"][part]
            cells += [number(words.size(told[key], block.unit), f"blocks.{i}.residual.{part}.{key}")
                      for _, key in (PARTS if part == "fit" else PARTS[:3])]
        rows.append(cells)
    names = [name for name, _ in PARTS]
    head = ["block", "verdict", *right(*names, *(f"held out: {name}" for name in names[:3]))]
    at_fault = [i for i, block in enumerate(diagnosis.blocks) if block.told["verdict"] != "nothing_detectable"]
    return table(head, rows, "blocks", at_fault)


def base_parameters(diagnosis):
    """(block's number, block, parameter's number, parameter) of what was re-tuned; what two blocks share is there once."""
    found = [(i, block, j, parameter) for i, block in enumerate(diagnosis.blocks)
             for j, parameter in enumerate(block.told["base"])]
    first = {(one[3]["key"], one[3]["value"]): one for one in reversed(found)}
    return [one for one in found if one is first[one[3]["key"], one[3]["value"]]]


def causes_tables(diagnosis):
    """Causes with their evidence, and every fitted parameter beside its given value."""
    told = diagnosis.told
    given = tomllib.loads(diagnosis.given.read_text(encoding="utf-8"))

    def given_text(parameter):
        section, name = parameter["key"].split(".")
        value = given.get(section, {}).get(name)
        if value is None or value == float("inf"):  # an infinite frequency: the rig has no such effect
            return "none"
        unit = words.UNITS.get(parameter["unit"], parameter["unit"])
        return f"{value:.6g} {unit}".strip() if isinstance(value, (int, float)) else str(value)

    def parameter_cells(parameter, of):
        return [parameter["key"], number(words.estimate(parameter), f"{of}.value"),
                (given_text(parameter), 'class="number"')]

    def share_of_counted(cause, of):
        share = cause["share_explained"]
        if share is None:
            return ""
        of_force = " of the force's" if words.is_shown_by_force(cause) else ""
        return number(words.share_text(share, told["verdict"]) + of_force, f"{of}.share_explained")

    text = ""
    if told["causes"]:
        rows = [[cause["effect"], "counted in single samples", share_of_counted(cause, f"causes.{i}"), ""]
                if words.is_counted(cause) else
                [cause["effect"], number(f"{cause['delta_bic']:.1f}", f"causes.{i}.delta_bic"),
                 number(words.share_text(cause["share_explained"], told["verdict"]), f"causes.{i}.share_explained"),
                 number(words.gain_text(cause["held_out_gain"]), f"causes.{i}.held_out_gain.value")]
                for i, cause in enumerate(told["causes"])]
        rows += [[f"or {other['effect']}", number(words.rival_text(other), f"alternatives.{i}.delta_bic"), "", ""]
                 for i, other in enumerate(told["alternatives"])]
        text += "<h2>Causes</h2>\n" + table(["effect", *right("BIC better by", "share explained",
                                                              "held-out gain (95 %)")], rows, "causes")
    rows = [[*parameter_cells(parameter, f"causes.{i}.parameters.{j}"), cause["effect"]]
            for i, cause in enumerate(told["causes"]) for j, parameter in enumerate(cause["parameters"])]
    named = {parameter["key"] for cause in told["causes"] for parameter in cause["parameters"]}
    rows += [[*parameter_cells(parameter, f"blocks.{i}.base.{j}"), f"re-tuned with the {words.BLOCKS[block.name][0]}"]
             for i, block, j, parameter in base_parameters(diagnosis) if parameter["key"] not in named]
    return text + ("\n<h2>Parameters</h2>\n" + table(["key", *right("fitted (± 95 %)", "given"), "of"], rows,
                                                    "parameters") if rows else "")


def visible_table(diagnosis):
    """For nothing_detectable: the smallest sizes that would have shown."""
    found = diagnosis.told["detectable"]
    if not found:
        return ""

    def value(number_, unit):
        return f"{number_:.3g} {words.UNITS.get(unit, unit)}".strip().replace("-", "−")

    rows = [[one["effect"], one["key"],
             ("in no size", 'class="number"') if one["value"] is None else
             number(value(one["value"], one["unit"]), f"detectable.{i}.value"),
             ("without bound" if one["given"] is None else value(one["given"], one["unit"]), 'class="number"'),
             ", ".join(f"{other['key']} {other['value']:.3g}" for other in one["others"])]
            for i, one in enumerate(found)]
    note = ("<p class=\"note\">From this size on, 19 records in 20 like this one would have shown the effect; limits "
            "and frequencies show below theirs. What the rig file’s tolerances make up for does not count.</p>\n")
    return "<h2>What would have been seen</h2>\n" + note + table(
        ["effect", "key", *right("from", "given"), "with"], rows, "visible")


def shown_unit(block):
    """Name and factor for signals of the block."""
    return ("mm", 1e-3) if block.unit == "m" else ("N", 1.0)


def add_block(page, block):
    """Its two panels over time."""
    title = words.BLOCKS[block.name][0].capitalize()
    fit = block.told["residual"]["fit"]

    def curve(values, factor, unit, name, colour, dash="solid"):
        time_s, drawn = with_gaps(block.time_s, values / factor, block.period_s)
        trace = {"type": "scatter", "mode": "lines", "name": name,
                 "line": {"color": colour, "dash": dash}, "hovertemplate": f"%{{y:.6~g}} {unit}"}
        return page.curve(time_s, drawn, trace)

    unit, factor = shown_unit(block)
    page.add(f"{block.name}-signals", f"{title}: measured and simulated",
             f"{words.BLOCKS[block.name][1]}; what is simulated is driven by what was measured before the block.",
             [curve(block.measured, factor, unit, "measured", MEASURED),
              curve(block.measured - block.before, factor, unit, "simulated, rig as given", BEFORE),
              curve(block.measured - block.after, factor, unit, "simulated, extended", AFTER, "dash")],
             {"yaxis": AXIS | {"title": {"text": f"{'position' if block.unit == 'm' else 'force'} ({unit})"}}})
    unit, factor = words.scale_of(0.5 * block.largest_error, block.unit)
    floor = [{"type": "line", "xref": "paper", "x0": 0, "x1": 1, "y0": side * fit["floor"] / factor,
              "y1": side * fit["floor"] / factor, "line": {"color": "#000000", "width": 2, "dash": "dash"}}
             for side in (-1, 1)]  # lies on curves that fill the plot
    page.add(f"{block.name}-errors", f"{title}: error over time",
             f"Measured less simulated. Dashes: noise floor, ± {words.size(fit['floor'], block.unit)} rms.",
             [curve(block.before, factor, unit, "as given", BEFORE),
              curve(block.after, factor, unit, "extended", AFTER)],
             {"yaxis": AXIS | {"title": {"text": f"error ({unit})"}}, "shapes": floor}, height_px=260)


def layout(x_title, y_title, **more):
    return {"xaxis": AXIS | {"title": {"text": x_title}} | more.pop("x", {}),
            "yaxis": AXIS | {"title": {"text": y_title}} | more.pop("y", {}), "height": 340, "hovermode": "closest"} | more


def line_trace(x, y, name, colour, dash="solid"):
    return {"type": "scatter", "mode": "lines", "x": x.tolist(), "y": y.tolist(), "name": name,
            "line": {"color": colour, "dash": dash}}


def band_trace(found, factor, x_factor, name, colour):
    x = np.concatenate((found.at, found.at[::-1])) / x_factor
    y = np.concatenate((found.high, found.low[::-1])) / factor
    return {"type": "scatter", "mode": "lines", "x": x.tolist(), "y": y.tolist(), "fill": "toself", "name": name,
            "line": {"width": 0}, "fillcolor": colour + "30", "hoverinfo": "skip"}


def position_plot(block, unit, factor):
    """Split by direction: what differs between the two is hysteresis."""
    traces = []
    for part, error, colour in (("as given", block.before, BEFORE), ("extended", block.after, AFTER)):
        for way, chosen, dash in (("moving up", block.velocity_m_per_s > 0.0, "solid"),
                                  ("moving down", block.velocity_m_per_s < 0.0, "dash")):
            if chosen.any():
                found = profile(block.position_m[chosen], error[chosen])
                traces.append(line_trace(found.at / 1e-3, found.mean / factor, f"{part}, {way}", colour, dash))
    return {"title": "Mean error over position", "data": layered(traces), "layout": layout("position (mm)", f"error ({unit})")}


def velocity_plot(block, unit, factor):
    traces = []
    for part, error, colour in (("as given", block.before, BEFORE), ("extended", block.after, AFTER)):
        found = profile(block.velocity_m_per_s, error)
        traces += [band_trace(found, factor, 1e-3, f"{part}, 10 to 90 %", colour),
                   line_trace(found.at / 1e-3, found.mean / factor, f"{part}, mean", colour)]
    return {"title": "Error over velocity", "data": layered(traces), "layout": layout("velocity (mm/s)", f"error ({unit})")}


def spectrum_plot(block, unit, factor):
    found = spectrum(block)
    traces = [line_trace(found.frequency_Hz, values / factor, name, colour, dash)
              for name, values, colour, dash in (("as given", found.before, BEFORE, "solid"),
                                                 ("extended", found.after, AFTER, "solid"),
                                                 ("floor", found.floor, FLOOR, "dot"))]
    axis = {"type": "log", "exponentformat": "power"}
    return {"title": "Spectrum of the error", "data": layered(traces),
            "layout": layout("frequency (Hz)", f"error ({unit}/√Hz)", x={"type": "log", "dtick": 1}, y=axis)}


def ranking_plot(block):
    """One bar for each candidate and round; None if none was tried."""
    ranking = block.told["ranking"][::-1]
    if not ranking:
        return None
    chosen = {cause["effect"] for cause in block.told["causes"]}
    rivals = {other["effect"] for other in block.told["alternatives"]}
    colours = [CHOSEN if one["effect"] in chosen else RIVAL if one["effect"] in rivals else OTHER for one in ranking]
    shares = [words.ranked_share(one) for one in ranking]
    rounds = max(one["round"] for one in ranking)
    labels = [(f"{one['round']}: " if rounds > 1 else "") + one["effect"].replace(".", ".<br>") for one in ranking]
    shared = {"type": "bar", "orientation": "h", "y": labels, "marker": {"color": colours}, "showlegend": False,
              "textposition": "auto", "cliponaxis": False}
    # What makes it worse has no bar: its number, at the left of one, would reach into the names.
    better_by = [max(0.0, one["delta_bic"]) for one in ranking]
    traces = [shared | {"x": better_by, "name": "BIC better by", "text": [words.short(one["delta_bic"]) for one in ranking],
                        "textposition": ["auto" if better > 0.0 else "outside" for better in better_by]},
              shared | {"x": [100.0 * share for share, _ in shares], "name": "share explained",
                        "text": [text for _, text in shares], "xaxis": "x2",
                        "textposition": ["auto" if share > 0.0 else "outside" for share, _ in shares]}]
    most = max(better_by)
    mark = 10.0 ** np.floor(np.log10(max(most, 1.0)))  # two labels fit on every screen
    mark *= max(many for many in (1, 2, 5) if many * mark <= max(most, 1.0))
    made = layout("ΔBIC (1)", "", x={"domain": [0.0, 0.42], "range": [0.0, 1.9 * max(most, 1.0)],
                                     "tickvals": [0, mark], "ticktext": ["0", words.short(mark)], "tickangle": 0},
                  y={"automargin": True, "ticks": ""}, height=max(300, 130 + 36 * len(ranking)))
    made["xaxis2"] = AXIS | {"title": {"text": "explained (%)"}, "domain": [0.52, 1.0], "range": [0, 220], "tickvals": [0, 100]}
    return {"title": "Candidates" + (" by round" if rounds > 1 else ""), "data": traces, "layout": made}


def block_plots(block):
    unit, factor = words.scale_of(0.5 * block.largest_error, block.unit)
    plots = {"position": position_plot(block, unit, factor), "velocity": velocity_plot(block, unit, factor),
             "spectrum": spectrum_plot(block, unit, factor), "ranking": ranking_plot(block)}
    return [{"id": f"{block.name}-{name}"} | plot for name, plot in plots.items() if plot]


def section(block, plots):
    title = words.BLOCKS[block.name][0].capitalize()
    divisions = "\n".join(plot_place(plot["id"], plot["title"]) for plot in plots)
    none = "" if block.told["ranking"] else '<p class="note">No candidates were ranked here.</p>'
    return (f'<section id="{block.name}">\n<h2>{title}: what the error depends on</h2>\n{none}'
            f'<div class="panels">\n{divisions}\n</div>\n</section>')


def limits_table(found):
    rows = stability.limit_rows(found)
    if not rows:
        return "" if found.given_limits and found.extended_limits else \
            f'<p class="note">{html.escape(" ".join(found.refusals))}</p>'

    def limit(value):
        return ("none" if value is None else f"{value:.5g}"), 'class="number"'
    cells = [[key, *((f"{value:.5g}", 'class="number"') for value in (given, extended)),
              limit(given_limits[0]), limit(extended_limits[0]), limit(given_limits[1]), limit(extended_limits[1])]
             for key, given, extended, given_limits, extended_limits in rows]
    head = ["parameter (unit last)", *right("given", "extended", "stable above, given", "stable above, extended",
                                            "stable below, given", "stable below, extended")]
    return table(head, cells, "limits")


def experiment_section(diagnosis):
    found = diagnosis.told["next_experiment"]
    if not found:
        return ""
    rows = [["to be told apart", " · ".join(found["rivals"])]] if found["rivals"] else []
    if found["file"]:
        rows += [["excitation", found["excitation"]],
                 ["expected difference of BIC", number(f"{found['predicted_delta_bic']:.0f}",
                                                       "next_experiment.predicted_delta_bic")],
                 ["profile, for berth run --profile", found["file"]]]
    rows.append(["why", found["why"]])
    if found["calibration"]:
        rows.append(["instead", found["calibration"]])
    return f'<section id="experiment">\n<h2>Next experiment</h2>\n{table(["", ""], rows, "next")}\n</section>'


def inputs_table(diagnosis):
    rows = [[one["role"], one["hash"], one["path"]] for one in diagnosis.told["inputs"]]
    return table(["role", "hash", "path"], rows, "files")


def version_words(diagnosis):
    told = diagnosis.told
    text = f"Made by berth {told['version']}, schema {told['schema']}."
    if told["overrides"]:
        text += f" Overrides of the rig: {', '.join(told['overrides'])}."
    if told["without"]:
        text += f" Left out of the library: {', '.join(told['without'])}."
    return text


def build_page(diagnosis, found, path):
    """The page as text, for a file at `path`; `found` is its Stability."""
    told = diagnosis.told
    main = diagnosis.main_block
    blocks = [main, *(block for block in diagnosis.blocks if block is not main)]
    rows = max(len(block.time_s) for block in blocks)
    page = Page(main.period_s)
    plots = {}
    for block in blocks:
        add_block(page, block)
        plots[block.name] = block_plots(block)
    word, colour = words.VERDICTS[told["verdict"]]
    name = tomllib.loads(diagnosis.given.read_text(encoding="utf-8")).get("name", "")
    records = ", ".join(one["path"].rsplit("/", 1)[-1] for one in told["inputs"] if one["role"] == "record")
    data = page.data(min(float(block.time_s[0]) for block in blocks), max(float(block.time_s[-1]) for block in blocks))
    return filled("diagnosis_page.html", shared_parts(path, ("figures_page.css", "diagnosis_page.css"),
                                                      ("report_page.js", "figures_page.js")) | {
        "kind": "berth diagnosis",
        "title": html.escape(name or "rig"),
        "description": html.escape(f"{records}, {rows} rows of {told['period_ms']:g} ms"),
        "verdict": html.escape(word),
        "verdict_class": VERDICT_CLASSES[colour],
        "headline": html.escape(words.headline(diagnosis)),
        "details": "\n".join(f"<li>{html.escape(line)}</li>" for line in words.details(diagnosis)),
        "blocks": blocks_table(diagnosis),
        "causes": causes_tables(diagnosis),
        "visible": visible_table(diagnosis),
        "thinned": page.thinning_words().replace("The log", "series.csv"),
        "sections": "\n".join(section(block, plots[block.name]) for block in blocks),
        "stability": html.escape(stability.sentence(found)),
        "limits": limits_table(found),
        "experiment": experiment_section(diagnosis),
        "inputs": inputs_table(diagnosis),
        "versions": html.escape(version_words(diagnosis)),
        "data": data,
        "plots": script_safe(json.dumps([plot for one in plots.values() for plot in one], separators=(",", ":"),
                                        allow_nan=False)),
    })
