"""What the model answers on a rig."""
from __future__ import annotations

import html
from dataclasses import dataclass, field

import numpy as np

from . import _core


@dataclass(frozen=True)
class Spectrum:
    """Eigenvalues of one period, by falling |z|; z = exp(s T) with the loop's period T.

    z                   complex, shape (n,)
    mode_growth_per_s   ln|z| / T of each, 1/s, shape (n,)
    mode_frequency_Hz   |arg z| / (2 pi T) of each, Hz, shape (n,)
    mode_damping_ratio  -Re s / |s| of each, shape (n,)
    spectral_radius     the largest |z|: below 1, the loop is stable
    growth_per_s        of the largest, 1/s: below 0, it decays
    """

    z: np.ndarray
    mode_growth_per_s: np.ndarray
    mode_frequency_Hz: np.ndarray
    mode_damping_ratio: np.ndarray
    spectral_radius: float
    growth_per_s: float

    @property
    def stable(self) -> bool:
        return self.spectral_radius < 1.0

    def plot(self, axes=None):
        """The eigenvalues in the unit circle, in the matplotlib axes given or in new ones, which are returned."""
        from .plots import plot_spectrum
        return plot_spectrum(self, axes)


@dataclass(frozen=True)
class Verdict:
    """One verdict on a loop, in the words and names of the command's JSON.

    kind     "stable", "unstable", "limit cycle", "driven", "bouncing" or "undetermined"
    stable   True, False, or None: not determined
    because  one sentence; advice: one line, or None
    caveat   where prediction and this run differ: which to believe, or None
    growth_per_s, growth_ci95_per_s, frequency_Hz   of the motion, 1/s and Hz; None: no growth is known
    dead_time_margin_ms   by which the robot's dead time may grow, ms; None: there is none.
                          dead_time_margin_is_open: by more, that is as far as was searched
    modulus               smallest |1 + L|; None: has none
    unlimited             nothing feeds back: any dead time will do
    stop_cause, stop_after_s  what stopped a run before its time, and when, s; else None
    prediction            of the model: growth_per_s, growth_ci95_per_s, source, restitution, why_not_predicted
    """

    kind: str
    stable: bool | None
    because: str
    caveat: str | None
    advice: str | None
    growth_per_s: float | None
    growth_ci95_per_s: float | None
    frequency_Hz: float | None
    stop_cause: str | None
    stop_after_s: float | None
    dead_time_margin_ms: float | None
    dead_time_margin_is_open: bool
    unlimited: bool
    modulus: float | None
    margin_note: str | None
    prediction: dict = field(repr=False)

    @classmethod
    def of(cls, told: dict) -> Verdict:
        told = dict(told)
        kind = told.pop("verdict")
        return cls(kind=kind, **{name: told[name] for name in cls.__dataclass_fields__ if name != "kind"})

    def __str__(self) -> str:
        lines = [f"{self.kind}: {self.because}"]
        if self.unlimited:
            lines.append(f"margin: {self.margin_note}")
        elif self.dead_time_margin_ms is not None:
            least = "at least " if self.dead_time_margin_is_open else ""
            lines.append(f"margin: {least}{self.dead_time_margin_ms:.4g} ms of dead time")
        if self.caveat:
            lines.append(f"caveat: {self.caveat}")
        if self.advice:
            lines.append(f"advice: {self.advice}")
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        colour = {True: "#1a7f37", False: "#cf222e", None: "#6e7781"}[self.stable]
        first, *others = str(self).split("\n")
        rest = first.partition(": ")[2]
        return (f'<div style="border-left:.4em solid {colour};padding:.2em .8em"><b style="color:{colour}">'
                f"{html.escape(self.kind)}</b> {html.escape(rest)}"
                + "".join(f"<br>{html.escape(line)}" for line in others) + "</div>")


@dataclass(frozen=True)
class Limit:
    """How far one parameter may go, in the unit of its key.

    value             the rig's own
    below, above      the nearest values at which the loop turns unstable, or stable; None: there is none in the range
    stable_intervals  (from, to) of each stable part of the range that was searched; empty with compensation
    """

    key: str
    value: float
    below: float | None
    above: float | None
    stable_intervals: list = field(default_factory=list)


@dataclass(frozen=True)
class Map:
    """Growth over two parameters.

    x_key, y_key     keys of the rig file; x, y their values, shapes (nx,) and (ny,), in the units of the keys
    growth_per_s     1/s, shape (ny, nx): below 0, the point is stable; nan: no rig may be there
    spectral_radius  the largest |z|, shape (ny, nx); of a map in the time domain, what |z| would be
    method           "eigenvalues" or "time domain"
    """

    x_key: str
    y_key: str
    x: np.ndarray
    y: np.ndarray
    growth_per_s: np.ndarray
    spectral_radius: np.ndarray
    method: str
    own: tuple[float, float]

    @classmethod
    def of(cls, axes: list[_core.Axis], told: dict, rig) -> Map:
        x, y = axes
        shape = (len(y.values), len(x.values))
        return cls(x_key=x.key, y_key=y.key, x=x.values, y=y.values,
                   growth_per_s=told["growth_per_s"].reshape(shape),
                   spectral_radius=told["spectral_radius"].reshape(shape), method=told["method"],
                   own=(float(rig[x.key]), float(rig[y.key])))

    @property
    def stable_share(self) -> float:
        """Of the points that a rig may have."""
        possible = ~np.isnan(self.growth_per_s)
        return float((self.growth_per_s[possible] < 0.0).mean()) if possible.any() else float("nan")

    def to_xarray(self):
        """As xarray.Dataset, where xarray is installed."""
        import xarray
        return xarray.Dataset({"growth_per_s": ((self.y_key, self.x_key), self.growth_per_s),
                               "spectral_radius": ((self.y_key, self.x_key), self.spectral_radius)},
                              {self.x_key: self.x, self.y_key: self.y})

    def plot(self, axes=None):
        """Growth by colour, centred on 0, with the limit and the rig itself; returns the matplotlib axes."""
        from .plots import plot_map
        return plot_map(self, axes)


@dataclass(frozen=True)
class Method:
    """A compensation of the dead time, tried.

    method       its name; settings: keys and values that switch it on
    robust       ran and stayed bounded on every rig that was tried
    error        distance to the motion without dead time on the rig as it is, as a share of its swing;
    worst_error  the same on the worst of the others
    """

    method: str
    settings: list
    robust: bool
    error: float
    worst_error: float


@dataclass(frozen=True)
class Compensation:
    """Every method, robust ones first; `recommended` is one that is robust, useful and stable, or None, `settings` what
    switches it on; `passed_over` names each that was not taken, with the reason."""

    methods: list[Method]
    recommended: str | None
    settings: dict | None
    passed_over: list

    @classmethod
    def of(cls, told: dict) -> Compensation:
        settings = told["settings"]
        return cls(methods=[Method(**one) for one in told["methods"]], recommended=told["recommended"],
                   settings=None if settings is None else dict(one.split("=", 1) for one in settings),
                   passed_over=told["passed_over"])
