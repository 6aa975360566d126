"""A diagnosis on one picture of 1600 x 1000 pixels: the block to look at first, before and after."""
import io

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt  # noqa: E402 (the backend comes first)

import diagnosis_words as words  # noqa: E402
from diagnosis_data import profile, spectrum  # noqa: E402
from diagnosis_page import AFTER, BEFORE, CHOSEN, FLOOR, MEASURED, OTHER, RIVAL, shown_unit  # noqa: E402
from page_data import with_gaps  # noqa: E402
from report_figure import (  # noqa: E402
    DOTS_PER_INCH, HEIGHT_PX, LEFT, RIGHT, STYLE, WIDTH_PX, empty, legend_above, wrapped)

CANDIDATES_MAX = 8
HEADLINE_HEIGHT, TEXT_HEIGHT = 0.026, 0.0185  # of the picture, a line


def error_unit(block):
    return words.scale_of(0.5 * block.largest_error, block.unit)


def plot_over_time(axes, block, curves, factor):
    for values, name, colour, style in curves:
        axes.plot(*with_gaps(block.time_s, values / factor, block.period_s), style, color=colour, linewidth=1.0,
                  label=name)
    axes.set(xlabel="time (s)", xlim=(block.time_s[0], block.time_s[-1]))


def plot_signals(axes, block):
    unit, factor = shown_unit(block)
    plot_over_time(axes, block, [(block.measured, "measured", MEASURED, "-"),
                                 (block.measured - block.before, "rig as given", BEFORE, "-"),
                                 (block.measured - block.after, "extended", AFTER, "--")], factor)
    axes.set(title="Measured and simulated", ylabel=f"{'position' if block.unit == 'm' else 'force'} ({unit})")
    legend_above(axes, 3)


def plot_errors(axes, block):
    unit, factor = error_unit(block)
    plot_over_time(axes, block, [(block.before, "as given", BEFORE, "-"), (block.after, "extended", AFTER, "-")],
                   factor)
    axes.set(title="Error over time", ylabel=f"error ({unit})")
    legend_above(axes, 2)


def plot_spectrum(axes, block):
    unit, factor = error_unit(block)
    found = spectrum(block)
    for values, name, colour, style in ((found.before, "as given", BEFORE, "-"),
                                        (found.after, "extended", AFTER, "-"), (found.floor, "floor", FLOOR, ":")):
        axes.loglog(found.frequency_Hz, values / factor, style, color=colour, linewidth=1.4, label=name)
    axes.set(title="Spectrum", xlabel="frequency (Hz)", ylabel=f"error ({unit}/√Hz)")
    legend_above(axes, 3)


def plot_over_velocity(axes, block):
    unit, factor = error_unit(block)
    for error, name, colour in ((block.before, "as given", BEFORE), (block.after, "extended", AFTER)):
        found = profile(block.velocity_m_per_s, error)
        axes.fill_between(found.at / 1e-3, found.low / factor, found.high / factor, color=colour, alpha=0.18,
                          linewidth=0)
        axes.plot(found.at / 1e-3, found.mean / factor, color=colour, linewidth=1.6, label=name)
    axes.set(title="Error over velocity", xlabel="velocity (mm/s)", ylabel=f"error ({unit})")
    legend_above(axes, 2)


def plot_ranking(axes, block):
    axes.set(title="Candidates")
    ranking = [one for one in block.told["ranking"] if one["round"] == 1][:CANDIDATES_MAX][::-1]
    if not ranking:
        empty(axes, "no candidates were ranked here")
        return
    chosen = {cause["effect"] for cause in block.told["causes"]}
    rivals = {other["effect"] for other in block.told["alternatives"]}
    colours = [CHOSEN if one["effect"] in chosen else RIVAL if one["effect"] in rivals else OTHER for one in ranking]
    shares = [words.ranked_share(one)[0] for one in ranking]
    axes.barh([one["effect"] for one in ranking], [100.0 * share for share in shares], color=colours)
    for i, one in enumerate(ranking):
        axes.text(1.0, i, f" BIC better by {round(one['delta_bic'])}", verticalalignment="center", fontsize=10,
                  color="white" if colours[i] == CHOSEN and shares[i] > 0.4 else "black")
    axes.set(xlabel="share explained (%)", xlim=(0, 105))
    axes.tick_params(axis="y", labelsize=10, length=0)
    axes.grid(False, axis="y")


def write_head(figure, diagnosis):
    """Verdict and sentences; returns how far down the picture they reach."""
    word, colour = words.VERDICTS[diagnosis.told["verdict"]]
    block = diagnosis.main_block
    figure.text(LEFT, 0.955, "berth diagnosis", fontsize=24, weight="bold")
    figure.text(RIGHT, 0.957, f" {word} ", fontsize=19, weight="bold", color="white", horizontalalignment="right",
                bbox={"facecolor": colour, "edgecolor": "none", "pad": 5})
    font = {"fontsize": 14, "weight": "bold"}
    headline = wrapped(figure, words.headline(diagnosis), **font)
    figure.text(LEFT, 0.938, "\n".join(headline), color=colour, verticalalignment="top", **font)
    sentences = [*(words.cause_sentence(cause, diagnosis.told["verdict"]) for cause in diagnosis.told["causes"]),
                 words.error_sentence(block)]
    if block.told["verdict"] in words.WITH_REST:
        sentences.append(words.left_sentence(block))
    lines = [line for sentence in sentences for line in wrapped(figure, sentence, fontsize=11)]
    top = 0.931 - HEADLINE_HEIGHT * len(headline)
    figure.text(LEFT, top, "\n".join(lines), fontsize=11, color="#333333", verticalalignment="top")
    hashes = ", ".join(f"{one['role']} {one['hash']}" for one in diagnosis.told["inputs"])
    figure.text(RIGHT, 0.012, f"{hashes}, berth {diagnosis.told['version']}", fontsize=9, color="#888888",
                horizontalalignment="right")
    return top - TEXT_HEIGHT * len(lines)


def build_picture(diagnosis):
    """The picture as the bytes of a PNG."""
    block = diagnosis.main_block
    with plt.rc_context(STYLE):
        figure = plt.figure(figsize=(WIDTH_PX / DOTS_PER_INCH, HEIGHT_PX / DOTS_PER_INCH), dpi=DOTS_PER_INCH)
        head_end = write_head(figure, diagnosis)
        grid = figure.add_gridspec(3, 2, width_ratios=[1.5, 1], left=0.06, right=0.98, top=min(0.77, head_end - 0.07),
                                   bottom=0.075, hspace=0.62, wspace=0.40)
        plot_signals(figure.add_subplot(grid[0, 0]), block)
        plot_errors(figure.add_subplot(grid[1, 0]), block)
        plot_over_velocity(figure.add_subplot(grid[2, 0]), block)
        plot_spectrum(figure.add_subplot(grid[0:2, 1]), block)
        plot_ranking(figure.add_subplot(grid[2, 1]), block)
        png = io.BytesIO()
        figure.savefig(png, format="png")
        plt.close(figure)
    return png.getvalue()
