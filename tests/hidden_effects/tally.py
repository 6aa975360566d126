"""Sums up judged records: the bounds, and tables by effect, size and noise in Markdown."""

from collections import defaultdict
from dataclasses import dataclass

from effects import LIBRARY, SIZES
from noise import LEVELS
from scenario import PAIRS
from scipy.stats import binomtest


@dataclass
class Bound:
    """A share that must be at most, or at least, so much."""

    name: str
    count: int
    total: int
    limit: float
    at_most: bool

    @property
    def share(self):
        return self.count / self.total if self.total else 0.0

    def is_met(self, few=False):
        """The figure itself; with `few` records, that it is not improbable (0.1 %) if the bound were just met."""
        if self.total == 0:
            return few  # nothing was shown: a full run cannot pass without
        if few:
            side = "greater" if self.at_most else "less"
            return bool(binomtest(self.count, self.total, self.limit, alternative=side).pvalue > 1e-3)
        return self.share <= self.limit if self.at_most else self.share >= self.limit

    def as_json(self, few):
        return {"name": self.name, "count": self.count, "total": self.total, "share": self.share,
                "limit": self.limit, "at_most": self.at_most, "met": self.is_met(few)}


# What misleads whoever believes it: what the few records of a short run decide on.
HARMFUL = {"confident wrong name", "fault-free: nothing named"}


def bounds(records):
    """The bounds of the specification over the records that score.py has judged."""
    shown = [r for r in records if r["visible"] and r["kind"] != "outside"]
    pairs = [r for r in shown if r["kind"] in PAIRS and len(r["visible"]) == 2]
    singles = [r for r in shown if r not in pairs]
    free = [r for r in records if r["kind"] == "fault_free"]
    left_out = [r for r in records if r.get("left_out_ok") is not None]
    right = [r for r in records if r["outcome"] == "right"]
    intervals = [ok for r in right for _, ok in r["intervals"]]
    gains = [r["gain"] for r in right if r["gain"] is not None and not r["richer"]]

    def count(rows, test):
        return sum(1 for r in rows if test(r)), len(rows)

    return [
        Bound("confident wrong name", *count(records, lambda r: r["outcome"] == "wrong"), 0.01, True),
        Bound("named when detectable", *count(singles, lambda r: r["outcome"] == "right"), 0.90, False),
        Bound("fault-free: nothing named", *count(free, lambda r: r["names_nothing"]), 0.98, False),
        Bound("true effect not in the library: said so", *count(left_out, lambda r: r["left_out_ok"]), 0.95, False),
        Bound("two effects: both named", *count(pairs, lambda r: r["outcome"] == "right"), 0.80, False),
        Bound("parameter within its interval", sum(intervals), len(intervals), 0.90, False),
        Bound("held-out residual <= 1.1 floor", sum(g <= 1.1 for g in gains), len(gains), 0.90, False),
    ]


def table(header, rows):
    lines = ["| " + " | ".join(header) + " |", "|" + "|".join(" --- " for _ in header) + "|"]
    return "\n".join(lines + ["| " + " | ".join(str(cell) for cell in row) + " |" for row in rows])


def cell(records):
    """named / detectable of all, and wrong names if there are any."""
    if not records:
        return ""
    right = sum(r["outcome"] == "right" and bool(r["visible"]) for r in records)
    wrong = sum(r["outcome"] == "wrong" for r in records)
    visible = sum(bool(r["visible"]) for r in records)
    return f"{right}/{visible} of {len(records)}" + (f", {wrong} wrong" if wrong else "")


def by(records, keys):
    groups = defaultdict(list)
    for r in records:
        groups[tuple(r[key] for key in keys)].append(r)
    return groups


def percent(bound):
    return f"{100 * bound.share:.1f} % ({bound.count}/{bound.total})" if bound.total else "none"


def markdown(records, few):
    """The report: bounds, table by effect and size, table by noise, every miss with its reason."""
    out = ["# Hidden effects", "", f"{len(records)} records.", ""]
    out.append(table(["", "bound", "measured", ""], [
        (b.name, f"{'at most' if b.at_most else 'at least'} {100 * b.limit:g} %", percent(b),
         "met" if b.is_met(few) else "MISSED") for b in bounds(records)]))
    singles = [r for r in records if r["kind"] == "single"]
    out += ["", "Named / detectable of all records, by effect and size:", ""]
    sizes = by(singles, ["effect", "size"])
    out.append(table(["effect", *SIZES], [
        (name, *(cell(sizes[name, size]) for size in SIZES)) for name in LIBRARY
        if any(effect == name for effect, _ in sizes)]))
    out += ["", "By size and noise:", ""]
    noises = by(singles, ["size", "noise"])
    out.append(table(["size", *(f"{n} noise" for n in LEVELS)], [
        (size, *(cell(noises[size, noise]) for noise in LEVELS)) for size in SIZES]))
    out += ["", "By kind:", ""]
    kinds = by(records, ["kind"])
    out.append(table(["kind", "records", "right", "missed", "quiet", "wrong", "failed"], [
        (kind, len(rows), *(sum(r["outcome"] == o for r in rows) for o in OUTCOMES))
        for (kind,), rows in kinds.items()]))
    out += ["", *misses(records), ""]
    return "\n".join(out)


OUTCOMES = ["right", "missed", "quiet", "wrong", "failed"]


def counts_against_a_bound(r):
    if r["kind"] == "fault_free" and not r["names_nothing"] or r["kind"] != "outside" and r["outcome"] == "missed":
        return True
    return r["outcome"] in ("wrong", "failed") or r.get("left_out_ok") is False


def misses(records):
    """Every record that counts against a bound, and every effect that its record does not show, with the reason."""
    bad = [r for r in records if counts_against_a_bound(r)]
    lines = ["Misses:", ""] + [
        f"- seed {r['seed']} {r['label']}: {r['outcome']}, {r['verdict']} {', '.join(r['causes']) or 'nothing'}"
        + (f"; without it: {r['left_out']}" if r.get("left_out_ok") is False else "")
        + (f"; {r['error']}" if r.get("error") else "") + f"\n  `{r['again']}`" for r in bad]
    hidden = [(r, name, d) for r in records for name, d in r["detectability"].items() if not d["detectable"]]
    lines += ["", "Not detectable (what re-tuning within the tolerances leaves is below the noise):", ""] + [
        f"- seed {r['seed']} {name}, {r['size']}, {r['noise']} noise: chi2 {d['chi2']:.3g}, "
        f"{d['share_of_floor']:.2g} of the floor" for r, name, d in hidden]
    return lines
