"""The delay budget as a bar: where the delay of a slow force comes from, in ms."""
import html

# The names that `berth run` prints, by their keys in its JSON, in the order of the signal; colours as in report_signals.
PARTS = {"robot_ms": ("robot", "#D55E00"), "hold_ms": ("hold", "#0072B2"), "bus_ms": ("bus", "#999999"),
         "sensor_ms": ("sensor", "#CC79A7"), "low_pass_ms": ("low-pass", "#009E73"),
         "wait_ms": ("waiting for the tick", "#E69F00")}


def section(budget):
    """HTML of the bar and its numbers, and of what a schedule makes of their sum. A part that takes delay away, as an inverse filter may, has no width."""
    shown = [(name, f"var(--c-{colour[1:]})", budget[key]) for key, (name, colour) in PARTS.items() if budget[key] != 0.0]
    bars = "".join(f'<span style="background: {colour}; flex: {max(0.0, delay_ms):.4g} 0 0" '
                   f'title="{html.escape(name)} {delay_ms:.3g} ms"></span>' for name, colour, delay_ms in shown)
    parts = "".join(f'<li><i style="background: {colour}"></i>{html.escape(name)} <b>{delay_ms:.3g}</b> ms</li>'
                    for name, colour, delay_ms in shown)
    later = ", ".join(f"{change['total_ms']:.4g} ms from {change['from_s']:.4g} s on" for change in budget["scheduled"])
    return (f'<section class="delay"><h2>Delay budget: {budget["total_ms"]:.4g} ms from a command to the force that '
            f'answers it</h2>\n<div class="bar" role="img" aria-label="parts of the delay">{bars}</div>\n'
            f"<ul>{parts}</ul>{f'<p>As the run changes it: {later}</p>' if later else ''}</section>")
