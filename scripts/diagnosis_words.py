"""A diagnosis in plain words: what is wrong, where, by how much, how sure, and what is left."""
import math

from diagnosis_data import smallest_visible
from page_data import UNSURE
from report_signals import BAD, GOOD

BLOCKS = {"manipulator": ("manipulator", "from operator and force to the command"),
          "robot": ("robot", "from the command to its position"),
          "force": ("object and sensor", "from the robot's motion to the measured force")}
VERDICTS = {"nothing_detectable": ("Nothing detectable", GOOD), "named": ("Named", BAD),
            "one_of": ("One of several", UNSURE),
            "partly_explained": ("Partly explained", UNSURE), "unknown": ("Unknown", UNSURE),
            "software_mismatch": ("Software mismatch", BAD)}
FLOOR_TOO_HIGH = 1.5
WORTH_A_WORD = 0.001  # of the explainable error
MORE_THAN_ITS_SHARE = 0.3  # a quarter of the rows has a quarter of noise
UNDECIDED_BIC = 10.0  # nearer than this two causes cannot be told apart
WITH_REST = ("unknown", "partly_explained")
PREFIXES = {"m": (("m", 1.0), ("mm", 1e-3), ("µm", 1e-6), ("nm", 1e-9), ("pm", 1e-12)),
            "N": (("kN", 1e3), ("N", 1.0), ("mN", 1e-3), ("µN", 1e-6))}
UNITS = {"N_per_m": "N/m", "N_per_m2": "N/m²", "N_per_m3": "N/m³", "N_s_per_m": "N s/m", "m_per_s": "m/s",
         "m_per_s2": "m/s²", "ms_per_s": "ms/s", "N_per_s": "N/s", "s_per_m": "s/m", "per_s": "1/s", "1": ""}


def scale_of(value, unit):
    """Unit with the prefix that suits a size, and how many of the plain unit it is."""
    for name, factor in PREFIXES[unit]:
        if abs(value) >= factor:
            return name, factor
    return PREFIXES[unit][-1]


def size(value, unit):
    """A size as people write it: 52.0 µm."""
    name, factor = scale_of(value, unit)
    return f"{value / factor:#.3g}".rstrip(".") + f" {name}"


def short(value):
    """For a bar: whole, and thousands as k where there are many."""
    return f"{value / 1000:.0f}k" if abs(value) >= 10000 else f"{value:.0f}".replace("-", "−")


def percent(share):
    return f"{100.0 * share:.1f} %".replace("-", "−")


def share_text(share, verdict):
    """At most all of it: noise can make an explained share a little larger. Where some is left it is never all."""
    if verdict not in WITH_REST:
        return percent(min(share, 1.0))
    texts = [f"{100.0 * share:.{digits}f} %" for digits in (1, 2, 3, 4)]
    return next((text for text in texts if float(text.split()[0]) < 100.0), "nearly all")


def estimate(parameter):
    """Name, value and interval of a parameter, with as many digits as the interval leaves."""
    value, (low, high) = parameter["value"], parameter["ci95"]
    unit = UNITS.get(parameter["unit"], parameter["unit"])
    half = None if low is None or high is None else 0.5 * (high - low)
    if parameter["fitted"] and half is not None and value and half < (least := 10.0 ** (math.floor(math.log10(abs(value))) - 5)):
        return f"{value:#.6g}".rstrip(".").replace("-", "−") + f" ± < {least:g} {unit}".rstrip().replace("-", "−")
    digits, mark = 6, ""
    if half and value:
        digits = min(8, max(2, math.floor(math.log10(abs(value))) - math.floor(math.log10(half)) + 2))
        mark = "#"  # zeros too: as many digits as the interval
    text = f"{value:{mark}.{digits}g}".rstrip(".")
    if half is None:
        text += " (no interval)"
    elif not parameter["fitted"]:
        return f"{text} {unit}".strip().replace("-", "−") + ", as given"
    elif abs(high + low - 2.0 * value) > 0.01 * half:  # cut off where the parameter cannot be
        text = f"{value:.{digits}g} ({low:.2g} to {high:.2g})"
    else:
        text += f" ± {half:#.2g}".rstrip(".")
    return f"{text} {unit}".strip().replace("-", "−")


def gain_text(gain):
    low, high = gain["ci95"]
    return f"{percent(gain['value'])} ({percent(low)} to {percent(high)})"


def is_counted(cause):
    """Found in single samples: no fit, hence no BIC and no gain, belongs to it."""
    return cause["delta_bic"] is None


def is_shown_by_force(cause):
    """What the robot does, below the noise of its reports: the share that it explains is of the force's error."""
    return cause["effect"].startswith("robot.") and cause["shown_by"] == "force"


def ranked_share(candidate):
    """A candidate's share of the explainable error, 0 to 1, and what is written at it."""
    share = candidate["share_explained"]
    if candidate["delta_bic"] <= 0.0:
        return 0.0, "as chance"
    return min(max(share, 0.0), 1.0), "with noise" if share > 1.0 else percent(share)


def name_of(parameter):
    """Its key without the section."""
    return parameter["key"].split(".")[1]


def cause_sentence(cause, verdict):
    found = ", ".join(f"{name_of(parameter)} = {estimate(parameter)}" for parameter in cause["parameters"])
    text = f"{cause['effect']}: {found}."
    if is_counted(cause):
        share = cause["share_explained"]
        of_force = " of the force" if is_shown_by_force(cause) else ""
        explains = "" if share is None else \
            f" It explains {share_text(share, verdict)} of the explainable error{of_force}."
        return text + f"{explains} It was counted in single samples, not fitted: no BIC and no held-out gain belong to it."
    return (f"{text} It explains {share_text(cause['share_explained'], verdict)} of the explainable error, BIC is "
            f"better by {round(cause['delta_bic'])}, and on data that the fit never saw the squared error, weighted by "
            f"the noise, falls by {gain_text(cause['held_out_gain'])}.")


def place(block):
    name, way = BLOCKS[block.name]
    return f"{name} ({way})"


def error_sentence(block):
    fit, held_out = (block.told["residual"][part] for part in ("fit", "held_out"))
    measured = "measured" if block.told["residual"]["floor_is_measured"] else "estimated"
    unit = block.unit
    return (f"{BLOCKS[block.name][0].capitalize()}: error {size(fit['before'], unit)} rms with the rig as given, "
            f"{size(fit['retuned'], unit)} re-tuned within its tolerances, {size(fit['after'], unit)} extended; "
            f"held out {size(held_out['retuned'], unit)} to {size(held_out['after'], unit)}; {measured} noise floor "
            f"{size(fit['floor'], unit)}.")


def has_high_floor(block):
    """The measured floor is well above the error: it hides what could be seen."""
    told = block.told["residual"]
    return told["floor_is_measured"] and told["fit"]["floor"] > FLOOR_TOO_HIGH * told["fit"]["after"]


def floor_sentence(block):
    fit = block.told["residual"]["fit"]
    return (f"{BLOCKS[block.name][0].capitalize()}: the measured floor ({size(fit['floor'], block.unit)}) is above "
            f"the error itself ({size(fit['after'], block.unit)}): something moved or jumped in the record that it "
            "was measured on. A small fault of this block may go unseen.")


def left_sentence(block):
    """Where the error that nothing explains lives."""
    fit = block.told["residual"]["fit"]
    left = block.told["left"]
    text = (f"In the {place(block)} {size(fit['after'], block.unit)} rms are left above a floor of "
            f"{size(fit['floor'], block.unit)}")
    if left["band_Hz"]:
        text += ", most of it from {:.3g} to {:.3g} Hz".format(*left["band_Hz"])
    if left["where"] and left["where"]["share"] > MORE_THAN_ITS_SHARE:
        text += (f"; the quarter of the rows {left['where']['rows']} holds {percent(left['where']['share'])} of the "
                 "squared error")
    if left["share"] > WORTH_A_WORD:
        text += (f". By class it is {left['depends']}; {percent(left['share'])} of the explainable error is left in "
                 "that form")
    why = "; ".join(block.told["doubts"])
    return f"{text}. Why it is not fully explained: {why}." if why else f"{text}."


def visible_sentence(block):
    least, at_Hz = smallest_visible(block)
    return (f"{BLOCKS[block.name][0].capitalize()}: an error that goes with the motion (mostly {at_Hz:.2g} Hz) "
            f"would have shown from about {size(least, block.unit)} rms on.")


def as_sentence(note):
    """Begins with a capital, unless with the name of a signal or a key, and ends with a full stop."""
    is_name = "_" in note.split()[0]
    return (note if is_name else note[0].upper() + note[1:]) + "." * (not note.endswith("."))


def next_sentence(found):
    """What to measure next."""
    if found["file"]:
        return f"Next experiment: {found['excitation']} ({found['file']}): {found['why']}."
    rest = f" Instead: {found['calibration']}." if found["calibration"] else ""
    return f"No next experiment: {found['why']}.{rest}"


def headline(diagnosis):
    """The verdict in one sentence."""
    told = diagnosis.told
    *first, last = [cause["effect"] for cause in told["causes"]] or [""]
    names = f"{', '.join(first)} and {last}" if first else last
    block = diagnosis.main_block
    where = f"in the {BLOCKS[told['block']][0]}" if told["block"] else "in more than one block"
    verdict = told["verdict"]
    if verdict == "named":
        return f"The rig file is wrong {where}: {names}."
    if verdict == "one_of":
        others = ", ".join(other["effect"] for other in told["alternatives"])
        return f"The rig file is wrong {where}: {names}, or {others}. This record cannot tell them apart."
    if verdict == "partly_explained":
        explain = "explains" if len(told["causes"]) == 1 else "explain"
        return f"The rig file is wrong {where}. {names} {explain} a part of it; another part has no name."
    if verdict == "unknown":
        return (f"The simulation is wrong in the {place(block)}, and nothing in the library explains it.")
    if verdict == "software_mismatch":
        return "The record's command is not what this firmware computes from its inputs: software, not physics."
    return "Measured and simulated agree down to the noise: this record shows no fault of the rig file."


def rival_text(other):
    """A rival that fits clearly better was refused: unseen data do not prove it."""
    delta_bic = other["delta_bic"]
    proof = ", but not proven on unseen data" if delta_bic < -UNDECIDED_BIC else ""
    return f"worse by {delta_bic:.1f}" if delta_bic >= 0.0 else f"better by {-delta_bic:.1f}{proof}"


def details(diagnosis):
    """What stands under the headline, a sentence each."""
    told = diagnosis.told
    lines = [cause_sentence(cause, told["verdict"]) for cause in told["causes"]]
    lines += [f"Or {other['effect']}: its BIC is {rival_text(other)}." for other in told["alternatives"]]
    for block in diagnosis.blocks:
        if block.told["verdict"] in WITH_REST:
            lines.append(left_sentence(block))
    if told["verdict"] == "nothing_detectable":
        lines += [visible_sentence(block) for block in diagnosis.blocks]
    if told["next_experiment"]:
        lines.append(next_sentence(told["next_experiment"]))
    lines.append(error_sentence(diagnosis.main_block))
    lines += [floor_sentence(block) for block in diagnosis.blocks if has_high_floor(block)]
    return lines + [as_sentence(note) for note in told["notes"] if note]
