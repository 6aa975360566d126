"""The section of a report on how wrong the arm's fixed step is: what `berth accuracy` found, if it is about the run's own
arm and step."""
import base64
import html
import io
import json

from accuracy_picture import draw
from berth_log import InputError

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


def section(found):
    """HTML; nothing where there is nothing to tell."""
    if found is None:
        return ""
    picture = io.BytesIO()
    draw(found, picture)
    encoded = base64.b64encode(picture.getvalue()).decode()
    words = (f"Found by berth accuracy with {html.escape(found['arm'])} and {html.escape(found['integrator'])}, in a "
             f"berthing of 60 s with contact, up to {found['largest_force_N']:.4g} N: not in this run itself. The truth is "
             f"CVODE at 1e-12.")
    return (f'<section id="accuracy">\n<h2>Accuracy of the fixed step</h2>\n<p><strong>{statement(found)}</strong> '
            f'{words}</p>\n<img alt="error of the tool over the step" style="max-width: 100%" '
            f'src="data:image/png;base64,{encoded}">\n</section>')
