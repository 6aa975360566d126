"""The report of a campaign as a page that holds its pictures, and the first picture by itself."""
from __future__ import annotations

import base64
import html
import io
from pathlib import Path

import numpy as np

from .report import OTHER_INDEX, OverInput, Summary, Worst, lines

PAIRS_SHOWN = 6
GREEN, RED, BLUE, GREY = "#1a7f37", "#cf222e", "#0969da", "#6e7781"
STYLE = """
:root { color-scheme: light dark }
body { font: 16px/1.5 system-ui, sans-serif; max-width: 68rem; margin: 2rem auto; padding: 0 1rem }
h1 { font-size: 1.5rem } h2 { font-size: 1.15rem; margin-top: 2rem }
.verdict { font-size: 1.6rem; border-left: .4em solid var(--c); padding: .2em .8em }
table { border-collapse: collapse } td, th { padding: .25em .9em .25em 0; text-align: left; vertical-align: top }
td.n { text-align: right; font-variant-numeric: tabular-nums }
code, pre { font: 13px/1.4 ui-monospace, monospace; white-space: pre-wrap; overflow-wrap: anywhere }
img { max-width: 100%; background: white }
"""


def _figure(rows: int, columns: int, width: float, height: float):
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    figure = Figure(figsize=(width * columns, height * rows), layout="constrained")
    FigureCanvasAgg(figure)
    return figure, np.atleast_1d(figure.subplots(rows, columns, squeeze=False)).ravel()


def _label(key: str) -> str:
    from ..plots import _label
    try:
        return _label(key)
    except ValueError:
        return key


def overview(found: Summary):
    """P(stable) over each input and, beside, which inputs matter."""
    panels = len(found.over) + bool(found.influences)
    if panels == 0:
        return None
    columns = 2 if panels == 4 else min(panels, 3)
    figure, axes = _figure(-(-panels // columns), columns, 4.2, 3.0)
    for one, on in zip(found.over, axes):
        _draw_over(one, on)
    if found.influences:
        _draw_influences(found, axes[len(found.over)])
    for on in axes[panels:]:
        on.set_visible(False)
    return figure


def _draw_over(one: OverInput, on) -> None:
    low = np.array([share.low for share in one.shares])
    high = np.array([share.high for share in one.shares])
    value = np.array([share.value for share in one.shares])
    if one.edges is not None:
        on.fill_between(np.repeat(one.edges, 2)[1:-1], np.repeat(low, 2), np.repeat(high, 2), color=BLUE, alpha=0.25, lw=0,
                        label="95 % interval")
        on.stairs(value, one.edges, color=BLUE, lw=2, baseline=None)
    else:
        at = np.arange(len(value))
        on.errorbar(at, value, [value - low, high - value], fmt="o", color=BLUE, capsize=3)
        on.set_xticks(at, one.labels, rotation=30 if max(map(len, one.labels)) > 6 else 0)
    on.set(xlabel=_label(one.name), ylabel="P(stable)", ylim=(-0.03, 1.03))
    on.grid(alpha=0.3)


def _draw_influences(found: Summary, on) -> None:
    told = found.influences[::-1]
    at = np.arange(len(told))
    on.barh(at - 0.2, [one.first for one in told], 0.4, xerr=[one.first_ci95 for one in told], color=BLUE, label="alone")
    on.barh(at + 0.2, [one.other for one in told], 0.4, xerr=[one.other_ci95 or 0.0 for one in told], color=GREY,
            label=OTHER_INDEX[told[0].method])
    on.set_yticks(at, [one.name.partition(".")[2] or one.name for one in told], fontsize=8)
    on.set(xlabel=f"influence on {told[0].output}", xlim=(0.0, None))
    on.legend(fontsize=8)


def pairs(found: Summary):
    """P(stable) over pairs of inputs, those of the most influential first."""
    order = {one.name: at for at, one in enumerate(found.influences)}
    shown = sorted(found.pairs, key=lambda one: order.get(one.x.name, 99) + order.get(one.y.name, 99))[:PAIRS_SHOWN]
    if not shown:
        return None
    columns = min(len(shown), 3)
    figure, axes = _figure(-(-len(shown) // columns), columns, 4.2, 3.4)
    for pair, on in zip(shown, axes):
        x = pair.x.edges if pair.x.edges is not None else np.arange(len(pair.x.labels) + 1) - 0.5
        y = pair.y.edges if pair.y.edges is not None else np.arange(len(pair.y.labels) + 1) - 0.5
        mesh = on.pcolormesh(x, y, np.ma.masked_invalid(pair.share), cmap="RdYlGn", vmin=0.0, vmax=1.0)
        for set_ticks, over in ((on.set_xticks, pair.x), (on.set_yticks, pair.y)):
            if over.edges is None:
                set_ticks(np.arange(len(over.labels)), over.labels)
        on.set(xlabel=_label(pair.x.name), ylabel=_label(pair.y.name))
    for on in axes[len(shown):]:
        on.set_visible(False)
    figure.colorbar(mesh, ax=axes.tolist(), label="P(stable)")
    return figure


def answers(found: Summary):
    """How each answer is spread."""
    names = list(found.ranges)[:6]
    if not names:
        return None
    columns = min(len(names), 3)
    figure, axes = _figure(-(-len(names) // columns), columns, 4.2, 2.6)
    for name, on in zip(names, axes):
        values = found.table[name].to_numpy(zero_copy_only=False)
        on.hist(values[np.isfinite(values)], bins=60, color=BLUE)
        on.set(xlabel=name, ylabel="samples")
        if name.endswith("growth_per_s"):
            on.axvline(0.0, color=RED, lw=1)
    for on in axes[len(names):]:
        on.set_visible(False)
    return figure


def _png(figure, dpi: int = 110) -> bytes:
    into = io.BytesIO()
    figure.savefig(into, format="png", dpi=dpi, metadata={"Software": None})
    return into.getvalue()


def _picture(title: str, figure) -> str:
    if figure is None:
        return ""
    data = base64.b64encode(_png(figure)).decode()
    return f'<h2>{title}</h2>\n<img alt="{title}" src="data:image/png;base64,{data}">\n'


def _head(found: Summary) -> str:
    share = found.p_stable
    if share is None:
        return f"<p>{found.table.num_rows:,} samples of {html.escape(found.spec.rig)}</p>"
    colour = GREEN if share.value > 0.5 else RED
    return (f'<p class="verdict" style="--c:{colour}">stable: <b>{100.0 * share.value:.2f} %</b> of {share.known:,} samples'
            f"<br><small>95 % interval {100.0 * share.low:.2f} to {100.0 * share.high:.2f} %</small></p>")


def _worst(worst: list[Worst]) -> str:
    rows = "".join(f"<tr><td class=n>{one.sample}</td><td class=n>{one.value:.6g}</td>"
                   f"<td><code>{html.escape(one.command)}</code></td></tr>" for one in worst)
    return (f"<h2>Worst samples, and what repeats each</h2><table><tr><th>sample</th><th>{worst[0].column}</th>"
            f"<th>command</th></tr>{rows}</table>" if worst else "")


def write_page(found: Summary) -> Path:
    """FOLDER/report.html, and FOLDER/report.png, which is its first picture."""
    first = overview(found)
    body = "".join([_head(found), _picture("P(stable) over each input", first),
                    _picture("P(stable) over pairs of inputs", pairs(found)),
                    _picture("How the answers are spread", answers(found)), _worst(found.worst),
                    f"<h2>In words</h2><pre>{html.escape(chr(10).join(lines(found)))}</pre>"])
    name = html.escape(found.spec.name)
    page = found.folder / "report.html"
    page.write_text(f"<!doctype html><html lang=en><meta charset=utf-8><title>{name}: campaign</title><style>{STYLE}"
                    f"</style><h1>{name}</h1>{body}<p><small>berth {html.escape(found.commit)}</small></p></html>\n",
                    encoding="utf-8")
    if first is not None:
        page.with_suffix(".png").write_bytes(_png(first))
    return page
