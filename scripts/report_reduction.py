"""The section of a report on how far an arm's reduction to one degree of freedom misleads about stability, pose by pose:
each joint by itself from where the run starts, both models in the run's own loop, asked of `berth reduce`."""
import html
import json
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import progress
from page_data import AXIS
from report_signals import COMMAND, MANIPULATOR, OBJECT, ROBOT

POSES = 33  # of a joint
POSES_OF_MANY_JOINTS = 17  # where there are more than MANY
MANY = 3
REDUCED, FULL = COMMAND, MANIPULATOR
PLOT_HEIGHT_PX = 280
LINEAR_SHARE = 0.003  # of the largest growth: below it the axis is linear, above it logarithmic


@dataclass(frozen=True)
class Sweep:
    """Of one joint. Growth rates in 1/s and longest dead times in ms over the angle; NaN at poses without a reduction.
    A dead time that is infinite was not found up to `looked_to_ms`; at one of 0 the loop is unstable at `looked_from_ms`."""
    joint: int  # from 1
    name: str
    angle_rad: np.ndarray
    visited_rad: tuple  # least and largest of the run
    growth_reduced: np.ndarray
    growth_full: np.ndarray
    dead_time_reduced_ms: np.ndarray
    dead_time_full_ms: np.ndarray
    looked_from_ms: float
    looked_to_ms: float

    @property
    def compared(self):
        return ~np.isnan(self.growth_full)

    @property
    def falsely_stable(self):
        return (self.growth_reduced <= 0) & (self.growth_full > 0)

    @property
    def falsely_unstable(self):
        return (self.growth_reduced > 0) & (self.growth_full <= 0)

    @property
    def neither_found(self):
        return np.isinf(self.dead_time_reduced_ms) & np.isinf(self.dead_time_full_ms)

    def off_percent(self):
        """By how much the reduced model's dead time is off, of that of the full one; NaN where that is none, or neither was
        found. At least so much where one was not."""
        reduced = np.minimum(self.dead_time_reduced_ms, self.looked_to_ms)
        full = np.minimum(self.dead_time_full_ms, self.looked_to_ms)
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where((full > 0) & ~self.neither_found, 100 * np.abs(reduced / full - 1), np.nan)


def range_of(joint):
    """All round, or as far as the joint turns."""
    low, high = (float(joint.get(f"angle_{end}_rad", sign * np.inf)) for end, sign in (("min", -1), ("max", 1)))
    return max(low, -np.pi), min(high, np.pi)


def sweep_from(found, number, joint, visited_rad):
    def values(pick):
        return np.array([np.nan if pose["reduced"] is None else pick(pose) for pose in found["poses"]], float)

    def dead_time(model):
        return values(lambda pose: np.inf if pose["dead_time_limit_ms"][model] is None
                      else pose["dead_time_limit_ms"][model])

    def looked(end):
        return max((pose["dead_time_limit_ms"][end] for pose in found["poses"] if pose["reduced"] is not None), default=0.0)

    return Sweep(number + 1, joint.get("name", f"joint {number + 1}"),
                 np.array([pose["pose_rad"][number] for pose in found["poses"]]), visited_rad,
                 values(lambda pose: pose["loop"]["reduced"]["growth_per_s"]),
                 values(lambda pose: pose["loop"]["full"]["growth_per_s"]), dead_time("reduced"), dead_time("full"),
                 looked("looked_from"), looked("looked_to"))


def sweeps_of(log, berth):
    """One of each joint; None without an arm. In place of the sweeps what `berth reduce` says where it cannot look at the
    rig's loop."""
    arm = log.config["manipulator"].get("arm")
    if not isinstance(arm, dict) or not log.arm:
        return None
    count = POSES if len(arm["joint"]) <= MANY else POSES_OF_MANY_JOINTS
    sweeps = []
    with tempfile.TemporaryDirectory() as folder:
        rig = Path(folder) / "rig.toml"
        rig.write_text(log.config_text)
        for number, joint in enumerate(arm["joint"]):
            progress.show(f"report: poses of joint {number + 1} of {len(arm['joint'])}")
            low, high = range_of(joint)
            if high - low > 1.999 * np.pi:  # all round: both ends are one pose
                high -= (high - low) / count
            words = [str(berth), "reduce", str(rig), "--json", "--sweep",
                     f"{number + 1}={low!r}:{high!r}:{count}"]
            done = subprocess.run(words, capture_output=True, text=True)
            if done.returncode != 0:
                return done.stderr.strip().removeprefix("berth: ").replace(f"{rig}: ", "")
            angle_rad = log.arm[f"joint_{number}_rad"]
            visited_rad = (float(angle_rad.min()), float(angle_rad.max())) if len(angle_rad) else (np.nan, np.nan)
            sweeps.append(sweep_from(json.loads(done.stdout), number, joint, visited_rad))
    return sweeps


def number_text(value):
    return f"{value:.3g}" if value < 1000 else f"{value:.0f}"


def poses(count):
    return f"{count} pose{'s' * (count != 1)}"


def statement(sweeps):
    """The comparison in a few sentences."""
    compared = sum(int(sweep.compared.sum()) for sweep in sweeps)
    if compared == 0:
        return "At no pose is there anything springy along the direction to reduce the arm to."
    falsely_stable = sum(int(sweep.falsely_stable.sum()) for sweep in sweeps)
    falsely_unstable = sum(int(sweep.falsely_unstable.sum()) for sweep in sweeps)
    says = [f"Both models were compared at {compared} poses."]
    if falsely_stable + falsely_unstable == 0:
        says.append("At every pose they agree whether the loop is stable.")
    else:
        says.append(f"Stable by the reduced model, unstable by the whole arm: {poses(falsely_stable)}. "
                    f"Unstable by the reduced model, stable by the whole arm: {poses(falsely_unstable)}.")
    worst = None
    for sweep in sweeps:
        off = sweep.off_percent()
        if np.all(np.isnan(off)):
            continue
        at = int(np.nanargmax(off))
        if worst is None or off[at] > worst[0]:
            worst = off[at], sweep, at
    if worst is not None:
        off, sweep, at = worst
        reduced_ms, full_ms = sweep.dead_time_reduced_ms[at], sweep.dead_time_full_ms[at]
        unseen = np.isinf(reduced_ms) or np.isinf(full_ms)
        shown = [f"more than {number_text(sweep.looked_to_ms)} ms" if np.isinf(ms) else f"{number_text(ms)} ms"
                 for ms in (reduced_ms, full_ms)]
        bound = "at least" if unseen else "up to"
        amount = f"has an error of {bound} {number_text(off)} %" if off < 200 else f"is {bound} {1 + off / 100:.0f} times too long"
        says.append(f"The critical dead time of the reduced model {amount}: {shown[0]} instead of {shown[1]}, with joint "
                    f"{sweep.joint} at {sweep.angle_rad[at]:.2f} rad.")
    elif all(np.all(sweep.neither_found[sweep.compared]) for sweep in sweeps):
        says.append(f"Both stay stable with {number_text(max(sweep.looked_to_ms for sweep in sweeps))} ms of dead time at "
                    "every pose.")
    none = sum(int((sweep.dead_time_full_ms == 0).sum()) for sweep in sweeps)
    missed = sum(int(((sweep.dead_time_full_ms == 0) & (sweep.dead_time_reduced_ms > 0)).sum()) for sweep in sweeps)
    if none:
        shortest_ms = max(sweep.looked_from_ms for sweep in sweeps)
        says.append(f"The whole arm is unstable even with the shortest dead time, {number_text(shortest_ms)} ms: "
                    f"{poses(none)}. The reduced model is stable with it at {missed} of them.")
    return " ".join(says)


def plain(values):
    """For JSON: None where there is no value."""
    return [None if np.isnan(value) else round(float(value), 6) for value in values]


class SignedDecades:
    """An axis for growth rates of either sign and of all sizes: linear about 0, decades beyond."""

    def __init__(self, largest):
        self.largest = max(largest, 1e-9)
        self.linear = 10.0 ** np.ceil(np.log10(LINEAR_SHARE * self.largest))

    def place(self, growth_per_s):
        return np.sign(growth_per_s) * np.log10(1.0 + np.abs(growth_per_s) / self.linear)

    def ticks(self):
        """Layout of an axis that shows growth rates where place() puts them."""
        decades = range(int(np.ceil(np.log10(self.largest / self.linear))) + 1)
        side = [self.linear * 10.0**decade for decade in decades]
        values = [-value for value in side[::-1]] + [0.0] + side
        return {"tickvals": [round(float(self.place(value)), 4) for value in values],
                "ticktext": [f"{value:g}".replace("-", "\u2212") for value in values]}


def curve(name, colour, angle_rad, values, shown=None, **more):
    """`shown`: where to draw the values, if elsewhere."""
    return {"type": "scatter", "mode": "lines+markers", "name": name, "x": plain(angle_rad),
            "y": plain(values if shown is None else shown), "customdata": plain(values),
            "line": {"color": colour, "width": 2}, "marker": {"color": colour, "size": 5}} | more


def angle_axis(sweep):
    name = f", {sweep.name}" if sweep.name != f"joint {sweep.joint}" else ""
    return AXIS | {"title": {"text": f"joint {sweep.joint}{name}: angle (rad)"}}


def visited(sweep):
    """(shape, trace for the legend) of the angles that the run came through."""
    low, high = sweep.visited_rad
    if np.isnan(low):
        return [], []
    colour = f"{OBJECT}40"
    shape = {"type": "rect", "x0": low, "x1": max(high, low + 0.01 * np.ptp(sweep.angle_rad)), "yref": "paper", "y0": 0,
             "y1": 1, "fillcolor": colour, "line": {"width": 0}, "layer": "below"}
    return [shape], [{"type": "scatter", "x": [None], "y": [None], "fill": "toself", "fillcolor": colour, "mode": "lines",
                      "name": "where the run was"}]


def growth_plot(sweep):
    rates = np.abs(np.concatenate((sweep.growth_reduced, sweep.growth_full)))
    scale = SignedDecades(np.nanmax(rates) if np.isfinite(rates).any() else 0.0)
    hover = {"hovertemplate": "%{customdata:.3~g} /s at %{x:.3~g} rad"}
    traces = [curve(name, colour, sweep.angle_rad, values, scale.place(values), **hover)
              for name, colour, values in (("reduced", REDUCED, sweep.growth_reduced), ("whole arm", FULL, sweep.growth_full))]
    wrong = sweep.falsely_stable | sweep.falsely_unstable
    if wrong.any():
        full = sweep.growth_full[wrong]
        traces.append(curve("the other verdict", ROBOT, sweep.angle_rad[wrong], full, scale.place(full), **hover)
                      | {"mode": "markers", "marker": {"color": ROBOT, "size": 10, "symbol": "x"}})
    shapes, legend = visited(sweep)
    axis = AXIS | {"title": {"text": "growth (1/s)"}, "zerolinecolor": "#333333"} | scale.ticks()
    return {"data": traces + legend, "layout": {"xaxis": angle_axis(sweep), "yaxis": axis, "shapes": shapes,
                                               "height": PLOT_HEIGHT_PX, "hovermode": "closest"}}


def dead_time_plot(sweep, own_ms):
    traces = []
    for name, colour, values in (("reduced", REDUCED, sweep.dead_time_reduced_ms), ("whole arm", FULL, sweep.dead_time_full_ms)):
        beyond = np.isinf(values)
        shown = np.minimum(values, sweep.looked_to_ms)
        one = curve(name, colour, sweep.angle_rad, shown,
                    hovertemplate="%{text} at %{x:.3~g} rad",
                    text=["" if np.isnan(value) else f"more than {sweep.looked_to_ms:.3g} ms" if np.isinf(value)
                          else f"{value:.3g} ms" for value in values])
        one["marker"] |= {"symbol": ["triangle-up" if far else "circle" for far in beyond],
                          "size": [9 if far else 5 for far in beyond]}
        traces.append(one)
    ends = [float(sweep.angle_rad.min()), float(sweep.angle_rad.max())]
    traces.append({"type": "scatter", "mode": "lines", "x": ends, "y": [own_ms, own_ms], "name": "the rig's dead time",
                   "line": {"color": "#333333", "width": 2, "dash": "dot"}, "hovertemplate": f"{own_ms:g} ms"})
    shapes, legend = visited(sweep)
    axis = AXIS | {"title": {"text": "critical dead time (ms)"}, "rangemode": "tozero"}
    return {"data": traces + legend, "layout": {"xaxis": angle_axis(sweep), "yaxis": axis, "shapes": shapes,
                                               "height": PLOT_HEIGHT_PX, "hovermode": "closest"}}


def plots(log, sweeps):
    """What the page's script draws in the places that section() makes; none where it makes none."""
    if not isinstance(sweeps, list):
        return []
    own_ms = log.config["robot"]["dead_time_ms"]
    return [{"id": f"{what}-{sweep.joint}"} | plot for sweep in sweeps
            for what, plot in (("growth", growth_plot(sweep)), ("critical", dead_time_plot(sweep, own_ms)))]


def section(log, sweeps):
    """HTML; nothing for a run without an arm."""
    if sweeps is None:
        return ""
    head = '<section id="reduction">\n<h2>How far the reduced model misleads, pose by pose</h2>\n'
    if isinstance(sweeps, str):
        return f"{head}<p>berth reduce cannot compare the models of this rig: {html.escape(sweeps)}.</p>\n</section>"
    words = ("One joint moves at a time; the others stay where the run starts. Both models describe small motions about rest, "
             "in this run's loop, with the object gripped. The whole arm is linearised. The reduced model has one degree of "
             "freedom: of the modes that the arm's own springs hold, that which moves the tool most along the direction "
             "(berth reduce). Above 0 the oscillation grows. The critical dead time is that of the robot up to which the "
             f"loop is stable; triangles: longer than {number_text(max(sweep.looked_to_ms for sweep in sweeps))} ms.")
    if log.config["manipulator"]["arm"].get("attitude", {}).get("actuator") == "thrusters":
        words += " Thrusters are left out of both."
    places = "\n".join(f'<div class="figure-panel"><ul class="legend"></ul><div class="plot" id="{what}-{sweep.joint}"></div></div>'
                       for sweep in sweeps for what in ("growth", "critical"))
    return (f"{head}<p><strong>{html.escape(statement(sweeps))}</strong> {words}</p>\n"
            f'<div class="panels">\n{places}\n</div>\n</section>')
