"""What the extension does to stability: `berth eigen` and `berth limits` on the rig as given and on the extended
one. Whether they account for an effect at all is tried, not assumed: the analysis is repeated without it."""
import tomllib
from dataclasses import dataclass

from berth_log import InputError


@dataclass(frozen=True)
class Stability:
    """What `berth eigen` and `berth limits` say of either rig; None where they refuse, then `refusals` say why.
    `ignored`: effects without which eigen says the very same."""
    given: dict
    extended: dict
    given_limits: dict
    extended_limits: dict
    ignored: list
    refusals: list


def set_in(text, section, name, value):
    """The text of a rig file with one key set, or without it if the value is None."""
    lines, inside = [], ""
    for line in text.splitlines():
        if line.startswith("["):
            inside = line.strip("[] ")
        if inside == section and line.split("=")[0].strip() == name:
            if value is None:
                continue
            line = f"{name} = {value!r}" if not isinstance(value, str) else f'{name} = "{value}"'
        lines.append(line)
    return "\n".join(lines) + "\n"


def without_effect(extended, given, cause):
    """The extended rig's text with the parameters of one cause as they were given."""
    values = tomllib.loads(given)
    for parameter in cause["parameters"]:
        section, name = parameter["key"].split(".")
        extended = set_in(extended, section, name, values.get(section, {}).get(name))
    return extended


def ask(berth, subcommand, rig, refusals):
    try:
        return berth.ask(subcommand, str(rig))
    except InputError as error:
        if "cannot be started" in str(error):
            raise
        refusals.append(str(error))
        return None


def measure(diagnosis, berth):
    """Asks `berth`; files that are only asked about go to its folder."""
    refusals = []
    given, extended = (ask(berth, "eigen", rig, refusals) for rig in (diagnosis.given, diagnosis.extended))
    limits = [ask(berth, "limits", rig, refusals) for rig in (diagnosis.given, diagnosis.extended)]
    ignored = []
    given_text, extended_text = (path.read_text(encoding="utf-8") for path in (diagnosis.given, diagnosis.extended))
    for cause in diagnosis.told["causes"]:
        path = berth.folder / f"without-{cause['effect']}.toml"
        path.write_text(without_effect(extended_text, given_text, cause), encoding="utf-8")
        other = ask(berth, "eigen", path, refusals)
        if extended and other and other["eigenvalues"] == extended["eigenvalues"]:
            ignored.append(cause["effect"])
    return Stability(given, extended, *limits, ignored, refusals)


def kind_of(told):
    """Stable or not; what neither grows nor decays by more than rounding does is marginal: a body without a spring."""
    growth_per_s, rounding_per_s = told["growth_per_s"], 1e-9
    if growth_per_s is None:  # runs decide, and go the other way than the eigenvalues
        return told["verdict"]
    if abs(growth_per_s) < rounding_per_s:
        return "marginal (it neither grows nor decays: a motion without a spring)"
    return f"{'stable' if told['stable'] else 'unstable'} (growth {growth_per_s:+.6g} /s)"


def margin_ms(limits):
    """Dead time that may be added; None: nothing is known, or there is no limit within the search."""
    margin = limits["margin"] if limits else None
    return margin["dead_time_margin_ms"] if margin and not margin["dead_time_margin_is_open"] else None


def sentence(found):
    """In plain words."""
    if found.given is None or found.extended is None:
        return "Cannot be told: " + " ".join(found.refusals)
    words = [f"{name} {kind_of(told)}"
             for name, told in (("As given, the loop is", found.given), ("extended, it is", found.extended))]
    text = "; ".join(words).replace("-", "−") + "."
    margins = [margin_ms(limits) for limits in (found.given_limits, found.extended_limits)]
    if any(margin is not None for margin in margins):
        given, extended = ("no limit" if margin is None else f"{margin:.5g} ms" for margin in margins)
        text += f" Dead time that may be added: {given} as given, {extended} extended."
    sized = found.extended.get("describing_function") or found.given.get("describing_function")
    if sized:
        text += (f" What depends on the size of the motion is taken for a swing of {sized['amplitude_m']:.5g} m "
                 "(describing function).")
        for cycle in sized["limit_cycles"]:
            what = ("smaller motion grows to it and larger motion decays to it" if cycle["attracts"] else
                    "smaller motion decays and larger motion grows")
            text += (f" A limit cycle of {cycle['amplitude_m']:.4g} m at {cycle['frequency_Hz']:.4g} Hz is "
                     f"predicted: {what}.")
    if found.ignored:
        text += (f" berth eigen and limits do not account for {' and '.join(found.ignored)}: without it they say "
                 "the very same. What differs comes from the re-tuned parameters; what the effect itself does to "
                 "the limit is not in these numbers.")
    return text


def limit_rows(found):
    """(parameter, given value, extended value, given limits, extended limits) of each parameter with a limit."""
    if not found.given_limits or not found.extended_limits:
        return []
    rows = []
    for key, given in found.given_limits["parameters"].items():
        extended = found.extended_limits["parameters"].get(key)
        if extended is None or not any(side[end] for side in (given, extended) for end in ("below", "above")):
            continue
        rows.append((key, given["value"], extended["value"],
                     *(tuple(side[end] and side[end]["value"] for end in ("below", "above"))
                       for side in (given, extended))))
    return rows
