"""What a report says of a run: the verdict, and the run in numbers. The page and the figure take their words from here,
so that they tell the same."""
import math
import re
from dataclasses import dataclass, field

from berth_log import stretches
from report_signals import BAD, GOOD, NEUTRAL, dead_time, words


@dataclass(frozen=True)
class Verdict:
    word: str
    sentence: str
    colour: str
    alarm: str = ""  # what stopped the loop; empty while it runs or ended as it was asked to
    notes: list = field(default_factory=list)


def energy_words(summary, log):
    """(name, value, remark): whether the loop makes energy, and where."""
    energy = summary.get("energy")
    if energy is None:
        return []
    if log.arm:  # its own damping is in what its joints gave: nobody knows what it took
        return [("energy", f"{energy['dead_time_J']:+.4g} J".replace("-", "−"), "made by dead time; the arm's joints and "
                 f"satellite gave {energy['operator_J']:.4g} J, hardware took {energy['measured_port_J']:.4g} J"
                 .replace("-", "−"))]
    word = {None: "none", True: "gained", False: "lost"}[energy["gains"]]
    made = f"made: dead time {energy['dead_time_J']:+.4g} J, integrator {energy['integrator_J']:+.4g} J; "
    if energy["compensation_J"] != 0.0:
        made = made.replace("; ", f", compensation {energy['compensation_J']:+.4g} J; ")
    return [("energy", word, made.replace("-", "−") + f"taken: damping {energy['dissipated_J']:.4g} J, hardware "
             f"{energy['measured_port_J']:.4g} J".replace("-", "−"))]


def stop_sentence(log, summary):
    """Where the supervisor ended and since when; empty while it runs."""
    if len(log.tick_s) == 0 or summary["state"] == "running":
        return ""
    cause = summary["stop_cause"]
    since_s = stretches(log.tick["state"], log.tick_s, log.period_s)[-1][1]
    because = f", because: {words(cause)}" if cause != "none" else ""
    return f"Ended in state {summary['state']} (since {since_s:.4g} s){because}."


def alarm(summary):
    """Fault or hold, in a few words."""
    if summary["state"] not in ("fault", "holding"):
        return ""
    return f"{summary['state']}: {words(summary['stop_cause'])}".capitalize()


def limit_words(summary):
    acted = [f"{words(name)} {ticks}" for name, ticks in summary["limit_ticks"].items() if ticks > 0]
    return ", ".join(acted) if acted else "never"


def guidance(summary):
    """What an arm's guidance held back of the operator's orders, as a fact; none without an arm."""
    if summary["guidance"] is None:
        return []
    acted = [f"{name} {ticks}, from {summary['guidance']['first_s'][name]:.2f} s on"
             for name, ticks in summary["guidance"]["ticks"].items() if ticks > 0]
    return [("guidance acted", "; ".join(acted) if acted else "never", "ticks" if acted else "")]


def motors(summary):
    """How often an arm's motors were at their torque limits, as a fact; none without an arm, or where no log tells."""
    if summary["motors"] is None:
        return []
    ticks = summary["motors"]["limit_ticks"]
    return [("motors at torque limit", f"{ticks}, from {summary['motors']['first_s']:.2f} s on" if ticks else "never",
             "ticks" if ticks else "")]


def wheel(summary):
    """How often the satellite's wheel was full, as a fact; none without a wheel."""
    if summary["wheel"] is None:
        return []
    ticks = summary["wheel"]["full_ticks"]
    return [("wheel full", f"{ticks}, from {summary['wheel']['first_s']:.2f} s on" if ticks else "never",
             "ticks: the satellite's attitude was not held" if ticks else "")]


# A stable loop is good, one that is not is bad; without either there is nothing to praise or to blame.
VERDICT_COLOURS = {True: GOOD, False: BAD, None: NEUTRAL}


def four_digits(value):
    """A number as a person writes it, with four digits and no exponent: 30.37, 14790. As `berth run` prints forces."""
    size = abs(value)
    if not 1e-4 <= size < 1e7:
        return f"{value:.4g}".replace("-", "−")
    rounded = float(f"{value:.3e}")
    return f"{rounded:.{max(0, 3 - math.floor(math.log10(abs(rounded))))}f}".replace("-", "−")


def typeset(text):
    """A sentence of `berth run` with the signs of print: ± and −."""
    return re.sub(r"(?<![\w.])-(?=\d)", "−", text.replace(" +- ", " ± "))


def signed(text):
    return text if text.startswith("−") else f"+{text}"


def with_interval(value, ci95):
    """A value with as many decimals as its interval leaves to it, and its sign: −0.298369 with ± 5e-06."""
    decimals = 6 if ci95 <= 0 else min(6, max(0, -math.floor(math.log10(ci95))))
    return f"{value:+.{decimals}f}".replace("-", "−")


def frequency_words(summary):
    """In Hz, with the digits that the growth's interval leaves: both are parts of one pole, and as uncertain."""
    if summary["frequency_Hz"] is None:
        return None
    if not summary["growth_ci95_per_s"]:
        return f"{four_digits(summary['frequency_Hz'])} Hz"
    decimals = min(4, max(0, -math.floor(math.log10(summary["growth_ci95_per_s"] / (2.0 * math.pi)))))
    return f"{summary['frequency_Hz']:.{decimals}f} Hz"


def capitalised(text):
    return text[:1].upper() + text[1:]


def margin_and_advice(log, summary):
    """(name, words): how far the loop is from its limit, and what to change; what is not known is left out."""
    found = []
    if summary["margin"]["sentence"]:
        found.append(("Margin", summary["margin"]["sentence"]))
    elif summary["stable"] is False:
        found.append(("Margin", "none: the loop is beyond its limit"))
    if summary["advice"]:
        found.append(("Advice", typeset(summary["advice"])))
    return found


def verdict(log, summary):
    """The run's verdict as `berth run` tells it, and what has to be known beside it."""
    notes = [note for note in (stop_sentence(log, summary),) if note]
    if summary["caveat"]:
        notes.insert(0, typeset(capitalised(summary["caveat"])) + ".")
    if summary["limit_ticks"] and any(summary["limit_ticks"].values()):
        notes.append(f"Limits acted (ticks): {limit_words(summary)}.")
    if summary["motors"] and summary["motors"]["limit_ticks"]:
        notes.append(f"Motors were at their torque limit in {summary['motors']['limit_ticks']} ticks: the growth of a "
                     "saturated loop says nothing of small motions.")
    if summary["assumed"]:
        notes.append("Assumed, as the rig file does not state it: "
                     + ", ".join(f"{one['key']} = {one['value']}" for one in summary["assumed"]) + ".")
    if summary["cut"]:
        notes.append("The log is cut: shown up to its last whole tick.")
    if summary["missing_ticks"]:
        notes.append(f"{summary['missing_ticks']} ticks are missing in the log.")
    if len(log.tick_s) == 0:
        return Verdict("No ticks", "The log holds no whole tick.", NEUTRAL, "", notes)
    return Verdict(capitalised(summary["verdict"]), typeset(capitalised(summary["because"])) + ".",
                   VERDICT_COLOURS[summary["stable"]], alarm(summary), notes)


def robot_preset(robot):
    """The robot preset as a fact; none for a rig's own robot."""
    if robot is None:
        return []
    remark = f"period {robot['period_ms']:g} ms, dead time {robot['dead_time_ms']:g} ms"
    if robot["dead_time_band_ms"]:
        remark += ", the upper end of the reported {:g} to {:g} ms".format(*robot["dead_time_band_ms"])
    return [("robot preset", robot["preset"], remark)]


def measured_growth(summary):
    """In 1/s; None where there is none, or where it is no larger than its interval: that is no finding."""
    growth = summary["growth_per_s"]
    is_finding = growth is not None and abs(growth) > summary["growth_ci95_per_s"]
    return growth if is_finding and summary["verdict"] != "driven" else None


def growth_stretch(summary):
    envelope = summary["envelope"]
    return f"of the motion from {envelope['fit_from_s']:.1f} to {envelope['fit_to_s']:.1f} s"


def prediction(summary):
    """What the loop's eigenvalues, or its Lyapunov exponent, say of the growth; none where it has neither."""
    predicted = summary["prediction"]["growth_per_s"]
    if predicted is None:
        return []
    return [("predicted growth", signed(four_digits(predicted)) + " /s", "of small motions, at the start")]


def margin_fact(margin):
    """A number and what it means; the sentence stands above."""
    if not margin["sentence"]:
        return []
    margin_ms = margin["dead_time_margin_ms"]
    if margin_ms is None:
        return [("dead time margin", "unlimited" if margin["unlimited"] else "none found", "")]
    at_least = "at least " if margin["dead_time_margin_is_open"] else ""
    modulus = "" if margin["modulus"] is None else f"; modulus margin {four_digits(margin['modulus'])} (0: unstable)"
    return [("dead time margin", f"{at_least}{four_digits(margin_ms)} ms", f"more until the loop is unstable{modulus}")]


def peak_facts(peaks):
    """The measured peak, and what the sensor's spring really carried, which only a simulated rig knows."""
    found = [("peak force", f"{four_digits(peaks['measured']['force_N'])} N", f"as measured, at {peaks['measured']['at_s']:.3f} s")]
    if peaks["true"]:
        found.append(("true peak force", f"{four_digits(peaks['true']['force_N'])} N",
                      f"in the sensor's spring, at {peaks['true']['at_s']:.3f} s"))
    return found


def facts(log, summary):
    """(name, value, remark): the run in numbers."""
    growth = measured_growth(summary)
    rate_Hz = log.config["loop"]["rate_Hz"]
    found = dead_time(log) if len(log.tick_s) else None
    cause = summary["stop_cause"]
    return robot_preset(summary["robot"]) + [
        ("growth rate", "not measured" if growth is None else f"{with_interval(growth, summary['growth_ci95_per_s'])} /s",
         "" if growth is None else f"± {summary['growth_ci95_per_s']:.1g} /s (95 %), {growth_stretch(summary)}"),
        *prediction(summary),
        ("frequency", frequency_words(summary) or "not measured", ""),
        *energy_words(summary, log),
        *margin_fact(summary["margin"]),
        *peak_facts(summary["peak_force"]),
        ("command to motion", "not shown" if found is None else f"{1e3 * (found.robot_s - found.command_s):.2f} ms",
         ("by the robot's own reports; " if found and found.is_reported else "") +
         f"dead time of the robot as configured: {log.config['robot']['dead_time_ms']:g} ms"),
        ("ticks", f"{summary['ticks']:,}".replace(",", " "), f"{rate_Hz:g} Hz, {summary['simulated_s']:.2f} s"),
        ("overruns", str(summary["overruns"]), "missed ticks"),
        ("supervisor", summary["state"], "" if cause == "none" else f"because: {words(cause)}"),
        ("limits acted", limit_words(summary), "ticks" if any(summary["limit_ticks"].values()) else ""),
        *guidance(summary),
        *motors(summary),
        *wheel(summary),
        ("frames", f"{summary['frames_accepted']:,} taken".replace(",", " "),
         f"{summary['frames_rejected']} rejected, {summary['frames_lost']} lost, {summary['error_frames']} error "
         f"frames; {summary['saturated_setpoints']} setpoints saturated"),
        ("configuration", log.config_hash, f"berth {log.version}"),
    ]
