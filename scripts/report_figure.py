"""The run on one picture of 1600 x 1000 pixels, for a README or a slide."""
import io

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt  # noqa: E402 (the backend comes first)
import numpy as np  # noqa: E402
from matplotlib.ticker import FormatStrFormatter, LogLocator, NullFormatter  # noqa: E402

import report_signals as signals  # noqa: E402
import report_words as told  # noqa: E402

WIDTH_PX, HEIGHT_PX, DOTS_PER_INCH = 1600, 1000, 100
LEFT, RIGHT = 0.03, 0.975  # shares of the picture between which text stands
LINE_HEIGHT = 0.027  # of the picture, a line of the head
DASHES = {"solid": "-", "dash": (0, (5, 2.5)), "dot": (0, (1.2, 1.6))}
STYLE = {"font.size": 12, "axes.titlesize": 13, "axes.titlelocation": "left", "axes.titleweight": "bold",
         "axes.spines.top": False, "axes.spines.right": False, "axes.grid": True, "grid.color": "#E6E6E6",
         "axes.edgecolor": "#999999", "xtick.color": "#333333", "ytick.color": "#333333", "axes.axisbelow": True,
         "legend.frameon": False, "legend.fontsize": 11, "path.simplify_threshold": 0.5}


def plot_signals(axes, found, width=1.4):
    for signal in found:
        style = "steps-post" if signal.is_step else "default"
        axes.plot(signal.time_s, signal.values, color=signal.colour, linestyle=DASHES[signal.dash], linewidth=width,
                  label=signal.label, drawstyle=style)
    axes.set_xlabel("time (s)")


def legend_within(axes, place="best"):
    axes.legend(loc=place, handlelength=1.6, frameon=True, framealpha=0.85, edgecolor="none")


def legend_above(axes, columns):
    axes.legend(loc="lower right", bbox_to_anchor=(1.01, 1.0), ncols=columns, borderpad=0, borderaxespad=0.2,
                handlelength=1.6, columnspacing=1.1, handletextpad=0.5)


def shade_rest(axes, log):
    for start_s, end_s in signals.not_running(log)[:50]:
        axes.axvspan(start_s, end_s, color="#F0F0F0", linewidth=0, zorder=0)


def plot_positions(axes, log):
    shade_rest(axes, log)
    found = [signal for signal in signals.positions(log) if signal.label != "robot, as reported"]
    plot_signals(axes, found)
    if log.is_contact:
        axes.axhline(1e3 * log.config["object"]["surface_position_m"], color=signals.OBJECT, linewidth=1,
                     linestyle=DASHES["dash"], label="surface")
    axes.set(title="Positions", ylabel="position (mm)")
    legend_above(axes, 6)


def plot_forces(axes, log):
    shade_rest(axes, log)
    plot_signals(axes, signals.forces(log))
    axes.set(title="Forces", ylabel="force (N)")
    legend_above(axes, 4)


def plot_dead_time(axes, log):
    axes.set(title="Command and robot", ylabel="position (mm)", xlabel="time (s)")
    found = signals.dead_time(log)
    if found is None:
        empty(axes, "no motion to show")
        return
    shown = []
    for signal in signals.command_and_robot(log):
        inside = (signal.time_s >= found.from_s) & (signal.time_s <= found.to_s)
        shown.append(signals.Signal(signal.label, signal.colour, signal.time_s[inside], signal.values[inside],
                                    signal.dash, signal.is_step))
    plot_signals(axes, shown, 2.0)
    axes.annotate("", (found.robot_s, found.level_mm), (found.command_s, found.level_mm),
                  arrowprops={"arrowstyle": "->", "color": "#333333", "linewidth": 1.6, "shrinkA": 0, "shrinkB": 0})
    reported = ", reported" if found.is_reported else ""
    axes.annotate(f"{1e3 * (found.robot_s - found.command_s):.2f} ms{reported}", (found.robot_s, found.level_mm), (9, 0),
                  textcoords="offset points", verticalalignment="center", weight="bold",
                  bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 2})
    legend_within(axes)


def plot_envelope(axes, log, summary):
    axes.set(title="Envelope", ylabel="height, peak to peak (mm)", xlabel="time (s)")
    envelope = summary["envelope"]
    time_s, height_mm = np.array(envelope["time_s"]), 1e3 * np.array(envelope["height_m"])
    held = signals.cycle(log, summary)
    if held is not None:
        axes.semilogy(held.time_s, held.heights_mm, "o", markersize=3.5, color=signals.COMMAND,
                      label="cycle, held by limits")
        axes.set_xlim(*signals.part_that_matters(log, summary))
    if not (height_mm > 0.0).any():
        if held is None:
            empty(axes, "no oscillation to show")
        return
    axes.semilogy(time_s, height_mm, "o", markersize=3.5, color=signals.MANIPULATOR, label="extremes")
    growth = told.measured_growth(summary)
    if growth is not None:
        line_s = np.array([envelope["fit_from_s"], envelope["fit_to_s"]])
        line_mm = 1e3 * envelope["fit_height_from_m"] * np.exp(summary["growth_per_s"] * (line_s - line_s[0]))
        axes.semilogy(line_s, line_mm, color=signals.ROBOT, linewidth=2,
                      label=f"fitted: {told.with_interval(summary['growth_per_s'], summary['growth_ci95_per_s'])} /s")
    used = np.zeros(len(time_s), bool)
    if growth is not None:
        used = (time_s >= envelope["fit_from_s"] - 1e-9) & (time_s <= envelope["fit_to_s"] + 1e-9)
    if held is not None:
        height_mm, used = np.append(height_mm, held.heights_mm), np.append(used, np.ones(len(held.heights_mm), bool))
    low, high = signals.height_range(height_mm, used, np.ones(len(used), bool))
    axes.set_ylim(10**low, 10**high)
    if high - low < 1.5:  # whole powers of ten may all lie outside
        axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if high - low > 0.6 else np.arange(1.0, 10.0)))
        axes.yaxis.set_major_formatter(FormatStrFormatter("%g"))
        axes.yaxis.set_minor_formatter(NullFormatter())
    legend_above(axes, 3)


def plot_band(axes, log):
    found = signals.bars(log)
    rows = list(dict.fromkeys(bar.row for bar in found))
    duration_s = log.tick_s[-1] - log.tick_s[0] + log.period_s
    for row in rows:
        of_row = [bar for bar in found if bar.row == row]
        axes.broken_barh([(bar.start_s, bar.end_s - bar.start_s) for bar in of_row], (rows.index(row) - 0.38, 0.76),
                         facecolors=[bar.colour for bar in of_row], edgecolors=[bar.colour for bar in of_row],
                         linewidth=0.6)
        for bar in of_row:
            if bar.label and bar.end_s - bar.start_s > 0.012 * len(bar.label) * duration_s:
                axes.text(0.5 * (bar.start_s + bar.end_s), rows.index(row), bar.label, verticalalignment="center",
                          horizontalalignment="center", color="#111111", fontsize=11)
    axes.set(yticks=range(len(rows)), yticklabels=rows, ylim=(len(rows) - 0.5, -0.5), xlabel="time (s)",
             title="Supervisor and limits")
    axes.grid(False)
    axes.tick_params(axis="y", length=0, labelsize=11)


def empty(axes, text):
    axes.text(0.5, 0.5, text, transform=axes.transAxes, horizontalalignment="center", color="#666666")
    axes.set(xticks=[], yticks=[])


def wrapped(figure, text, separator=" ", **font):
    """The text's lines, broken at separators, each as wide as it is drawn and no wider than from LEFT to RIGHT."""
    probe = figure.text(LEFT, 0.0, "", **font)
    lines = []
    for part in text.split(separator):
        probe.set_text(f"{lines[-1]}{separator}{part}" if lines else part)
        if lines and probe.get_window_extent().x1 <= RIGHT * figure.bbox.width:
            lines[-1] = probe.get_text()
        else:
            lines.append(part)
    probe.remove()
    return lines


def write_lines(figure, below, text, separator=" ", color="#333333", **font):
    """Writes the text below this height; returns the height of its last line."""
    for line in wrapped(figure, text, separator, **font):
        below -= LINE_HEIGHT
        figure.text(LEFT, below, line, color=color, **font)
    return below


def write_head(figure, log, summary):
    """Verdict, sentence and facts; returns how far down the picture they reach."""
    verdict = told.verdict(log, summary)
    figure.text(LEFT, 0.955, log.config["name"], fontsize=24, weight="bold")
    figure.text(RIGHT, 0.957, f" {verdict.word} ", fontsize=19, weight="bold", color="white",
                horizontalalignment="right", bbox={"facecolor": verdict.colour, "edgecolor": "none", "pad": 5})
    if verdict.alarm:
        figure.text(RIGHT, 0.905, f" {verdict.alarm} ", fontsize=13, weight="bold", color="white",
                    horizontalalignment="right", bbox={"facecolor": signals.BAD, "edgecolor": "none", "pad": 4})
    below = write_lines(figure, 0.955, log.config["description"], color="#444444", fontsize=13)
    below = write_lines(figure, below - 0.006, verdict.sentence, color=verdict.colour, fontsize=14, weight="bold")
    cause = summary["stop_cause"]
    because = "" if cause == "none" else f" ({signals.words(cause)})"
    ticks = f"{summary['ticks']:,}".replace(",", " ")
    true_peak = summary["peak_force"]["true"]
    truly = f" ({told.four_digits(true_peak['force_N'])} N in the sensor's spring)" if true_peak else ""
    line = (f"peak force {told.four_digits(summary['peak_force_N'])} N{truly}   ·   {ticks} ticks at {log.config['loop']['rate_Hz']:g} Hz, "
            f"{summary['overruns']} overruns   ·   supervisor: {summary['state']}{because}   ·   limits acted: "
            f"{told.limit_words(summary)}   ·   frames: {summary['frames_rejected']} rejected, "
            f"{summary['frames_lost']} lost, {summary['error_frames']} error")
    below = write_lines(figure, below, line, "   ·   ", fontsize=11.5)
    figure.text(RIGHT, 0.012, f"configuration {log.config_hash}, berth {log.version}", fontsize=9, color="#888888",
                horizontalalignment="right")
    return below


def build_figure(log, summary):
    """The picture as the bytes of a PNG."""
    with plt.rc_context(STYLE):
        figure = plt.figure(figsize=(WIDTH_PX / DOTS_PER_INCH, HEIGHT_PX / DOTS_PER_INCH), dpi=DOTS_PER_INCH)
        head_end = write_head(figure, log, summary)
        if len(log.tick_s):
            band_rows = len({bar.row for bar in signals.bars(log)})
            grid = figure.add_gridspec(3, 2, height_ratios=[3, 3, 0.32 * band_rows + 0.1], width_ratios=[1.75, 1],
                                       left=0.105, right=0.98, top=head_end - 0.06, bottom=0.075, hspace=0.46, wspace=0.17)
            positions = figure.add_subplot(grid[0, 0])
            plot_positions(positions, log)
            plot_forces(figure.add_subplot(grid[1, 0], sharex=positions), log)
            band = figure.add_subplot(grid[2, :])
            plot_band(band, log)
            plot_dead_time(figure.add_subplot(grid[0, 1]), log)
            plot_envelope(figure.add_subplot(grid[1, 1]), log, summary)
            positions.set_xlim(*signals.part_that_matters(log, summary))
            band.set_xlim(log.tick_s[0], log.tick_s[-1] + log.period_s)
        png = io.BytesIO()
        figure.savefig(png, format="png")
        plt.close(figure)
    return png.getvalue()
