"""The section of a report on how wrong the arm's fixed step is: what `berth accuracy` found, if it is about the run's own
arm and step."""
import html
import json

from accuracy_picture import LOST_m, PANELS
from berth_log import InputError
from page_data import AXIS
from report_signals import COMMAND, MANIPULATOR, OBJECT

ARM_SECTION = "[manipulator.arm]"


def fnv1a_64(text):
    """The hash that berth writes, as 16 hexadecimal digits."""
    value = 0xCBF29CE484222325
    for byte in text.encode():
        value = (value ^ byte) * 0x100000001B3 % 2**64
    return f"{value:016x}"


def accuracy_of(log, path):
    """What the file at `path` says about the run's arm, by default that beside the log; None where there is none. Raises
    InputError for one that cannot be read, or is about another arm or step."""
    if path is None:
        path = log.path.with_suffix(".accuracy.json")
        if not path.exists():
            return None
    try:
        found = json.loads(path.read_text())
        arm_hash, step_ms, _ = found["arm_hash"], found["step_ms"], (found["substeps"], found["force"])
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from error
    except (ValueError, KeyError, TypeError) as error:
        raise InputError(f"{path}: is not what `berth accuracy RIG --json` prints ({error!r})") from error
    if ARM_SECTION not in log.config_text:
        raise InputError(f"{path}: is about an arm, and {log.path} has none; leave it out")
    arm_text = log.config_text[log.config_text.index(ARM_SECTION):]
    if arm_hash != fnv1a_64(arm_text):
        raise InputError(f"{path}: is about another arm than that of {log.path}; make it anew with "
                         "`berth accuracy RIG --json`")
    period_ms = 1e3 * log.period_s
    if abs(step_ms - period_ms) > 1e-9 * period_ms:
        raise InputError(f"{path}: is about steps of {step_ms:g} ms, and {log.path} has {period_ms:g} ms; make it anew "
                         f"with --step-ms {period_ms:g}")
    return found


def error_text(tool_m):
    return "more than 1 m: the steps blow up" if tool_m is None or tool_m > 1.0 else f"{1e6 * tool_m:.3g} \u00b5m"


def percent_text(percent):
    return f"{percent:.2g}" if percent < 100 else f"{percent:.0f}"


def statement(found):
    """The accuracy in one sentence."""
    repeatability_um = 1e6 * found["repeatability_m"]
    substeps = f" in {found['substeps']} substeps" if found["substeps"] > 1 else ""

    def share(tool_m, of=""):
        return "" if tool_m is None else f", {percent_text(100.0 * tool_m / found['repeatability_m'])} %{of}"

    def in_loop(force):
        return ", as the loop does," if found["force"] == force else ""

    tool_m, held_m, led_m = found["tool_m"], found["held_tool_m"], found["led_tool_m"]
    of_it = f" of the robot's repeatability of {repeatability_um:g} \u00b5m"
    return (f"At {found['step_ms']:g} ms{substeps} the worst end-effector error of the integrator alone is "
            f"{error_text(tool_m)}{share(tool_m, of_it)}; with the force held over the step{in_loop('held')} it is "
            f"{error_text(held_m)}{share(held_m)}; led by half a step{in_loop('led')} {error_text(led_m)}{share(led_m)}.")


INTEGRATORS = {"semi_implicit_euler": ("semi-implicit Euler", COMMAND, 2), "implicit_midpoint": ("implicit midpoint", OBJECT, 5),
               "rk4": ("RK4", MANIPULATOR, 2)}  # where two do alike, the narrow line lies on the wide one
QUANTITIES = {"tool_m": (1e6, "tool (\u00b5m)"), "force_N": (1.0, "force (N)"), "energy_J": (1.0, "energy (J)")}
LOG_AXIS = AXIS | {"type": "log", "dtick": 1, "exponentformat": "power"}


def pairs():
    """(how the force is held, quantity) of each plot; where the true force is given it has no error."""
    return [(force, quantity) for quantity in QUANTITIES for force in PANELS if (force, quantity) != ("mean", "force_N")]


def error_plot(found, force, quantity):
    """The largest error over the length of the step."""
    factor, title = QUANTITIES[quantity]
    traces, ends = [], []
    for integrator, (name, colour, width) in INTEGRATORS.items():
        rows = [row for row in found["rows"] if (row["integrator"], row["force"], row["substeps"]) == (integrator, force, 1)]
        rows = [row for row in rows if row[quantity] and row["tool_m"] is not None and row["tool_m"] < LOST_m]
        ends += [row["step_ms"] for row in rows]
        traces.append({"type": "scatter", "mode": "lines+markers", "name": name, "x": [row["step_ms"] for row in rows],
                       "y": [factor * row[quantity] for row in rows], "line": {"color": colour, "width": width},
                       "marker": {"color": colour, "size": width + 3},
                       "hovertemplate": "%{y:.3~g} at %{x:.3~g} ms"})
    if quantity == "tool_m" and ends:
        height = [factor * found["repeatability_m"]] * 2
        traces.append({"type": "scatter", "mode": "lines", "name": "the robot's repeatability", "x": [min(ends), max(ends)],
                       "y": height, "line": {"color": "#333333", "width": 2, "dash": "dot"}, "hovertemplate": "%{y:.3~g}"})
    own = {"type": "line", "x0": found["step_ms"], "x1": found["step_ms"], "yref": "paper", "y0": 0, "y1": 1,
           "line": {"color": "#999999", "width": 1.5, "dash": "dash"}}
    return {"data": traces, "layout": {"xaxis": LOG_AXIS | {"title": {"text": "step (ms)"}}, "height": 300, "shapes": [own],
                                       "yaxis": LOG_AXIS | {"title": {"text": f"largest error of the {title}"}},
                                       "hovermode": "closest"}}


def plots(found):
    """What the page's script draws in the places that section() makes."""
    return [] if found is None else [{"id": f"{quantity}-{force}"} | error_plot(found, force, quantity)
                                     for force, quantity in pairs()]


def section(found):
    """HTML; nothing where there is nothing to tell."""
    if found is None:
        return ""
    words = (f"Found by berth accuracy with {html.escape(found['arm'])} and {html.escape(found['integrator'])}, in a "
             f"berthing of 60 s with contact, up to {found['largest_force_N']:.4g} N: not in this run itself. The truth is "
             f"CVODE at 1e-12. The dashed line is the step of {found['step_ms']:g} ms.")
    places = "\n".join(f'<div class="figure-panel"><h3>{PANELS[force].capitalize()}</h3><ul class="legend"></ul>'
                       f'<div class="plot" id="{quantity}-{force}"></div></div>' for force, quantity in pairs())
    return (f'<section id="accuracy">\n<h2>Accuracy of the fixed step</h2>\n<p><strong>{statement(found)}</strong> '
            f'{words}</p>\n<div class="panels">\n{places}\n</div>\n</section>')
