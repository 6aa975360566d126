"""What the table of a campaign says."""
from __future__ import annotations

import json
import shlex
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq
from scipy.stats import binomtest

from ..errors import InputError
from .evaluation import SEED, settings_of
from .inputs import PRESET, RECORD, Input
from .sensitivity import Influence, influences
from .spec import Spec

BINS, PAIR_BINS = 8, 6
WORST = 5
OTHER_INDEX = {"sobol": "total", "pawn": "PAWN"}
# What is worst, by the first that was asked: column, and whether more is worse.
WORST_BY = (("run_growth_per_s", True), ("growth_per_s", True), ("predicted_growth_per_s", True),
            ("dead_time_margin_ms", False), ("peak_force_N", True), ("restitution", True), ("compensated_error", True),
            ("motion_error", True))


@dataclass(frozen=True)
class Share:
    """Stable samples of all whose verdict is known, with Wilson's interval of 95 %."""

    stable: int
    known: int
    low: float
    high: float

    @classmethod
    def of(cls, stable: int, known: int) -> Share:
        if known == 0:
            return cls(0, 0, 0.0, 1.0)
        found = binomtest(int(stable), int(known)).proportion_ci(0.95, method="wilson")
        return cls(int(stable), int(known), float(found.low), float(found.high))

    @property
    def value(self) -> float:
        return self.stable / self.known if self.known else float("nan")


@dataclass(frozen=True)
class OverInput:
    """P(stable) over one input: labels, middles (of numbers) and the share in each part."""

    name: str
    edges: np.ndarray | None
    labels: list[str]
    shares: list[Share]


@dataclass(frozen=True)
class OverPair:
    """P(stable) over two inputs, shape (parts of y, parts of x); nan: no sample there."""

    x: OverInput
    y: OverInput
    share: np.ndarray


@dataclass(frozen=True)
class Worst:
    """A sample, what is bad about it, and the command that repeats it."""

    sample: int
    column: str
    value: float
    command: str


@dataclass(frozen=True)
class Summary:
    """spec       the campaign; folder: where it is; table: all rows, as pyarrow.Table
    p_stable     None: nobody asked
    states       samples by how they ended; reasons: of those that are not done, the most frequent first
    ranges       least, median and largest of each number that was answered
    """

    spec: Spec
    folder: Path
    commit: str
    is_whole: bool
    table: pa.Table = field(repr=False)
    p_stable: Share | None
    states: dict
    reasons: list
    ranges: dict
    influences: list[Influence]
    over: list[OverInput]
    pairs: list[OverPair]
    worst: list[Worst]


def read(folder: Path) -> tuple[Spec, dict, pa.Table, bool]:
    try:
        about = json.loads((folder / "campaign.json").read_text())
    except (OSError, ValueError):
        raise InputError(f"{folder}: has no campaign; name a folder that `berth campaign FILE.toml` wrote",
                         str(folder)) from None
    spec = Spec.from_json(about["spec"])
    whole = folder / "samples.parquet"
    parts = sorted((folder / "parts").glob("*.parquet"))
    if not whole.exists() and not parts:
        raise InputError(f"{folder}: has no samples yet; go on with --resume", str(folder))
    try:
        table = pq.read_table(whole) if whole.exists() else pa.concat_tables(map(pq.read_table, parts))
    except pa.ArrowInvalid as error:
        raise InputError(f"{folder}: the table is damaged: {error}; remove the file and go on with --resume") from None
    return spec, about, table, whole.exists()


def summarise(folder) -> Summary:
    """Of the folder of a campaign, or of its table; also of one that is not whole yet."""
    folder = Path(folder)
    folder = folder.parent if folder.suffix == ".parquet" else folder
    spec, about, table, is_whole = read(folder)
    stable = _stable(table)
    over = [_over(one, table, stable) for one in spec.inputs if one.name != RECORD] if stable is not None else []
    return Summary(spec=spec, folder=folder, commit=about["commit"], is_whole=is_whole, table=table,
                   p_stable=_p_stable(spec, table, stable), states=_states(table), reasons=_reasons(table),
                   ranges=_ranges(spec, table), influences=influences(spec, table, is_whole), over=over,
                   pairs=_pairs(spec, table, stable, over), worst=_worst(spec, table))


def _stable(table: pa.Table) -> np.ndarray | None:
    """1, 0, or nan: not known."""
    if "stable" not in table.column_names:
        return None
    return table["stable"].cast(pa.float64()).to_numpy(zero_copy_only=False).astype(float)


def _p_stable(spec: Spec, table: pa.Table, stable) -> Share | None:
    if stable is None:
        return None
    if spec.method == "saltelli":  # rows between the two independent designs repeat their values
        number = table["sample"].to_numpy() % (len(spec.inputs) + 2)
        stable = stable[(number == 0) | (number == len(spec.inputs) + 1)]
    known = ~np.isnan(stable)
    return Share.of(int(stable[known].sum()), int(known.sum()))


def _states(table: pa.Table) -> dict:
    found = pc.value_counts(table["state"]).to_pylist()
    return {one["values"]: one["counts"] for one in sorted(found, key=lambda one: -one["counts"])}


def _reasons(table: pa.Table) -> list:
    reasons = table.filter(pc.is_valid(table["reason"]))
    counted: dict = {}
    for sample, reason in zip(reasons["sample"].to_pylist(), reasons["reason"].to_pylist()):
        first, count = counted.get(reason, (sample, 0))
        counted[reason] = first, count + 1
    return sorted(((count, first, reason) for reason, (first, count) in counted.items()), reverse=True)[:WORST]


def _ranges(spec: Spec, table: pa.Table) -> dict:
    inputs = {one.name for one in spec.inputs} | {"sample", "seed"}
    found = {}
    for name in table.column_names:
        if name not in inputs and pa.types.is_floating(table[name].type):
            values = table[name].to_numpy(zero_copy_only=False)
            values = values[np.isfinite(values)]
            if len(values):
                found[name] = tuple(np.percentile(values, [0, 50, 100]).tolist())
    return found


def _parts(one: Input, table: pa.Table, bins: int):
    """(part of each row, edges, labels): equally many samples in each part; of few values, each by itself."""
    values = table[one.name].to_numpy(zero_copy_only=False)
    distinct = np.unique(values) if not one.is_number or one.values or one.count or one.integer else ()
    if len(distinct) and (len(distinct) <= 2 * bins or not one.is_number):
        labels = [f"{value:.4g}" if one.is_number else Path(str(value)).stem for value in distinct]
        return np.searchsorted(distinct, values), None, labels
    edges = np.unique(np.quantile(values, np.linspace(0.0, 1.0, bins + 1)))
    part = np.clip(np.searchsorted(edges, values, side="right") - 1, 0, len(edges) - 2)
    return part, edges, [f"{low:.4g} to {high:.4g}" for low, high in zip(edges, edges[1:])]


def _over(one: Input, table: pa.Table, stable) -> OverInput:
    part, edges, labels = _parts(one, table, BINS)
    known = ~np.isnan(stable)
    shares = [Share.of(int(stable[known & (part == i)].sum()), int((known & (part == i)).sum()))
              for i in range(len(labels))]
    return OverInput(one.name, edges, labels, shares)


def _pairs(spec: Spec, table: pa.Table, stable, over) -> list[OverPair]:
    found, known = [], None if stable is None else ~np.isnan(stable)
    parts = {one.name: _parts(one, table, PAIR_BINS) for one in spec.inputs if stable is not None and one.name != RECORD}
    names = list(parts)
    for i, x in enumerate(names):
        for y in names[i + 1:]:
            (px, ex, lx), (py, ey, ly) = parts[x], parts[y]
            counts, stables = np.zeros((len(ly), len(lx))), np.zeros((len(ly), len(lx)))
            np.add.at(counts, (py[known], px[known]), 1.0)
            np.add.at(stables, (py[known], px[known]), stable[known])
            with np.errstate(invalid="ignore"):
                found.append(OverPair(OverInput(x, ex, lx, []), OverInput(y, ey, ly, []), stables / counts))
    return found


def _worst(spec: Spec, table: pa.Table) -> list[Worst]:
    for column, more_is_worse in WORST_BY:
        if column in table.column_names and table[column].null_count < table.num_rows:
            values = table[column].to_numpy(zero_copy_only=False).astype(float)
            order = np.argsort(-values if more_is_worse else values, kind="stable")[:WORST]  # nan comes last
            rows = table.take(order).to_pylist()
            return [Worst(row["sample"], column, row[column], command_of(spec, row)) for row in rows
                    if row[column] is not None]
    return []


def command_of(spec: Spec, row: dict) -> str:
    """What repeats a sample: the same rig, to the last bit."""
    values = {one.name: row[one.name] for one in spec.inputs}
    settings = {**spec.fixed, **settings_of(spec, values, row["seed"])}
    preset, record = settings.pop(PRESET, spec.robot), settings.pop(RECORD, "")
    runs, asks = {"peak_force"}, set(spec.asks)
    verb = ["run", spec.rig, "--no-log"] if asks & runs else \
        ["compensate", spec.rig] if asks & {"fidelity", "compensation"} else \
        ["diagnose", record, "--rig", spec.rig] if record else ["eigen", spec.rig]
    if verb[0] == "eigen" and SEED not in values and "verdict" not in asks:
        settings.pop(SEED, None)
    words = ["berth", *verb, *(["--robot", preset] if preset else [])]
    for key, value in settings.items():
        text = str(value).lower() if isinstance(value, bool) else repr(value) if isinstance(value, float) else str(value)
        words += ["--set", f"{key}={text}"]
    return shlex.join(words)


def lines(found: Summary, short: bool = False) -> list[str]:
    """For a person at a terminal; short: without what each input does, and with one worst sample."""
    spec, told = found.spec, []
    told.append(f"{spec.name}: {found.table.num_rows:,} samples of {spec.rig}" +
                ("" if found.is_whole else f", of {spec.count:,}: it is not whole"))
    if (share := found.p_stable) is not None:
        told.append(f"  P(stable)      {share.value:.4f}, 95 % interval {share.low:.4f} to {share.high:.4f} (Wilson, "
                    f"{share.stable:,} of {share.known:,})")
    told += [f"  {state:<14} {count:,}" for state, count in found.states.items() if state != "done"]
    told += [f"  reason         {count:,} times, sample {first} first: {reason}" for count, first, reason in found.reasons]
    for name, (least, middle, most) in found.ranges.items():
        told.append(f"  {name:<14} {least:.4g} to {most:.4g}, median {middle:.4g}")
    for at, one in enumerate(found.influences):
        with_interval = f" +- {one.other_ci95:.3f}" if one.other_ci95 is not None else ""
        told.append(f"  {'influence' if at == 0 else '':<14} {one.name}: alone {one.first:.3f} +- {one.first_ci95:.3f}, "
                    f"{OTHER_INDEX[one.method]} {one.other:.3f}{with_interval} of {one.output}")
    for one in () if short else found.over:
        told.append(f"  over {one.name}")
        told += [f"    {label:<22} P(stable) {share.value:.3f}, {share.low:.3f} to {share.high:.3f}"
                 for label, share in zip(one.labels, one.shares) if share.known]
    for one in found.worst[:1] if short else found.worst:
        told.append(f"  worst          sample {one.sample}: {one.column} {one.value:.6g}")
        told.append(f"    {one.command}")
    return [*told, f"  table          {found.folder / 'samples.parquet'}"] if found.is_whole else told
