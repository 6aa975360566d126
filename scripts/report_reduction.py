"""The section of a report on how far an arm's reduction to one degree of freedom misleads about stability, pose by pose:
each joint by itself from where the run starts, both models in the run's own loop, asked of `berth reduce`."""
import base64
import html
import io
import json
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

POSES = 33  # of a joint
POSES_OF_MANY_JOINTS = 17  # where there are more than MANY
MANY = 3
COLUMNS_MAX = 4
WIDTH_in = 12.0
REDUCED, FULL = "tab:orange", "tab:blue"


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


def statement(sweeps):
    """The comparison in a few sentences."""
    compared = sum(int(sweep.compared.sum()) for sweep in sweeps)
    if compared == 0:
        return "At no pose is there anything springy along the direction to reduce the arm to."
    falsely_stable = sum(int(sweep.falsely_stable.sum()) for sweep in sweeps)
    falsely_unstable = sum(int(sweep.falsely_unstable.sum()) for sweep in sweeps)
    says = [f"At {falsely_stable} of {compared} poses the reduced model calls stable what the whole arm makes unstable, "
            f"at {falsely_unstable} unstable what it makes stable."]
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
        amount = f"off by {bound} {number_text(off)} %" if off < 200 else f"{bound} {1 + off / 100:.0f} times too long"
        says.append(f"The critical dead time is {amount}: "
                    f"{shown[0]} in place of {shown[1]}, joint {sweep.joint} at {sweep.angle_rad[at]:.2f} rad.")
    elif all(np.all(sweep.neither_found[sweep.compared]) for sweep in sweeps):
        says.append(f"Both bear more than {number_text(max(sweep.looked_to_ms for sweep in sweeps))} ms of dead time at "
                    "every pose.")
    none = sum(int((sweep.dead_time_full_ms == 0).sum()) for sweep in sweeps)
    missed = sum(int(((sweep.dead_time_full_ms == 0) & (sweep.dead_time_reduced_ms > 0)).sum()) for sweep in sweeps)
    if none:
        shortest_ms = max(sweep.looked_from_ms for sweep in sweeps)
        says.append(f"At {none} pose{'s' * (none > 1)} the whole arm is unstable at the shortest dead time already, "
                    f"{number_text(shortest_ms)} ms; at {missed} of them the reduced model bears a longer one.")
    return " ".join(says)


def draw(sweeps, own_ms, path):
    """`own_ms`: the rig's dead time. `path`: a file's, or an open binary file."""
    columns = min(len(sweeps), COLUMNS_MAX)
    blocks = -(-len(sweeps) // columns)
    figure, panels = plt.subplots(2 * blocks, columns, figsize=(WIDTH_in, 5.6 * blocks + 0.5),
                                  squeeze=False)
    for axes in panels.flat:
        axes.set_visible(False)
    for i, sweep in enumerate(sweeps):
        block, column = divmod(i, columns)
        growth, dead_time = panels[2 * block, column], panels[2 * block + 1, column]
        low, high = sweep.visited_rad
        for axes in (growth, dead_time):
            axes.set_visible(True)
            axes.grid(True, alpha=0.25)
            axes.axvspan(low, max(high, low + 0.01 * np.ptp(sweep.angle_rad)), color="tab:green", alpha=0.25, linewidth=0,
                         label="visited")
            axes.set_xlabel(f"joint {sweep.joint}, {sweep.name}: angle in rad" if sweep.name != f"joint {sweep.joint}"
                            else f"joint {sweep.joint}: angle in rad")
        growth.axhline(0.0, color="black", linewidth=0.8)
        growth.plot(sweep.angle_rad, sweep.growth_reduced, "o-", color=REDUCED, markersize=3, label="reduced")
        growth.plot(sweep.angle_rad, sweep.growth_full, "o-", color=FULL, markersize=3, label="whole arm")
        wrong = sweep.falsely_stable | sweep.falsely_unstable
        growth.plot(sweep.angle_rad[wrong], sweep.growth_full[wrong], "x", color="red", markersize=8,
                    label="the other verdict")
        largest = np.nanmax(np.abs(np.concatenate((sweep.growth_reduced, sweep.growth_full))), initial=0.0)
        growth.set_yscale("symlog", linthresh=10.0 ** np.ceil(np.log10(max(1e-12, 0.003 * largest))))
        for model, colour in ((sweep.dead_time_reduced_ms, REDUCED), (sweep.dead_time_full_ms, FULL)):
            shown = np.minimum(model, sweep.looked_to_ms)
            dead_time.plot(sweep.angle_rad, shown, "o-", color=colour, markersize=3)
            beyond = np.isinf(model)
            dead_time.plot(sweep.angle_rad[beyond], shown[beyond], "^", color=colour, markersize=6)
        own = dead_time.axhline(own_ms, color="black", linestyle=":", linewidth=1.2)
        dead_time.set_ylim(bottom=-0.03 * max(sweep.looked_to_ms, own_ms))
        if column == 0:
            growth.set_ylabel("growth rate in 1/s")
            dead_time.set_ylabel("critical dead time in ms")
    handles, labels = panels[0, 0].get_legend_handles_labels()
    figure.legend([*handles, own], [*labels, "the rig's dead time"], loc="upper center", ncols=len(labels) + 1, fontsize=9)
    figure.tight_layout(rect=(0, 0, 1, 1 - 0.4 / figure.get_figheight()))
    figure.savefig(path, dpi=110, format="png")
    plt.close(figure)


def section(log, sweeps):
    """HTML; nothing for a run without an arm."""
    if sweeps is None:
        return ""
    head = '<section id="reduction">\n<h2>How far the reduced model misleads, pose by pose</h2>\n'
    if isinstance(sweeps, str):
        return f"{head}<p>It cannot be told of this rig: {html.escape(sweeps)}.</p>\n</section>"
    picture = io.BytesIO()
    draw(sweeps, log.config["robot"]["dead_time_ms"], picture)
    encoded = base64.b64encode(picture.getvalue()).decode()
    words = ("Each joint by itself, the others where the run starts; green is what the run came through. Both models, small "
             "motions about rest, are in this run's loop with the object gripped: the whole arm linearised, and, of the "
             "modes that its own springs hold, that by which the tool moves most along the direction as the manipulator of "
             "one degree of freedom (berth reduce). Above 0 the oscillation grows. The critical dead time is the "
             f"robot's, up to which the loop is stable; triangles: longer than {number_text(max(sweep.looked_to_ms for sweep in sweeps))} ms.")
    if log.config["manipulator"]["arm"].get("attitude", {}).get("actuator") == "thrusters":
        words += " Thrusters are left out of both."
    return (f"{head}<p><strong>{html.escape(statement(sweeps))}</strong> {words}</p>\n"
            f'<img alt="growth rate and critical dead time over the angle of each joint" style="max-width: 100%" '
            f'src="data:image/png;base64,{encoded}">\n</section>')
