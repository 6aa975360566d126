"""What a report shows of a run: signals with their names and colours, bands over time, and the words about it.
The page and the figure take everything from here, so that they tell the same."""
from dataclasses import dataclass

import numpy as np

from berth_log import LIMITS, STATES, STOP_CAUSES, intervals, stretches

# Okabe and Ito's colours, distinct to colour-blind readers. A colour is a place in the loop.
MANIPULATOR = "#0072B2"
COMMAND = "#E69F00"
ROBOT = "#D55E00"
REPORTED = "#CC79A7"
OBJECT = "#009E73"
OPERATOR = "#666666"
STORED = "#000000"
GOOD, BAD, NEUTRAL = "#0072B2", "#D55E00", "#666666"
STATE_COLOURS = dict(zip(STATES, ("#DDDDDD", "#F0E442", "#56B4E9", "#E69F00", "#D55E00", "#888888")))
BAND_COLOUR = "#888888"


@dataclass(frozen=True)
class Signal:
    """A curve: times in s, values in the unit of its panel."""
    label: str
    colour: str
    time_s: np.ndarray
    values: np.ndarray
    dash: str = "solid"  # solid, dash or dot
    is_step: bool = False
    is_second_axis: bool = False


@dataclass(frozen=True)
class Bar:
    """A stretch of time in a band."""
    row: str
    label: str
    colour: str
    start_s: float
    end_s: float


@dataclass(frozen=True)
class DeadTime:
    """Where the command passes a level and the robot follows: times in s, level in mm."""
    command_s: float
    robot_s: float
    level_mm: float
    from_s: float  # a window worth looking at
    to_s: float
    is_reported: bool  # the robot's own report of where it is, which arrives later


def positions(log):
    """Positions in mm, from the operator's command to the object."""
    tick, rig = log.tick, log.rig
    signals = []
    if log.config["operator"]["interface"] == "motion":
        signals.append(Signal("operator", OPERATOR, log.tick_s, 1e3 * tick["operator_position_m"], "dash"))
    signals.append(Signal("manipulator", MANIPULATOR, log.tick_s, 1e3 * tick["manipulator_position_m"]))
    if rig:
        signals.append(Signal("object", OBJECT, log.rig_s, 1e3 * rig["object_position_m"]))
    return signals + command_and_robot(log)


def command_and_robot(log):
    """Command and robot in mm: what the dead time lies between."""
    tick, rig = log.tick, log.rig
    signals = [Signal("command", COMMAND, log.tick_s, 1e3 * tick["command_position_m"], "dash"),
               Signal("robot, as reported", REPORTED, log.tick_s, 1e3 * tick["robot_position_m"], "dot")]
    if rig:
        signals.append(Signal("robot", ROBOT, log.rig_s, 1e3 * rig["robot_position_m"]))
    return signals


def following(log):
    """Command less robot in mm, at each tick: the robot's true position, or the reported one where that is not known."""
    command_mm = 1e3 * log.tick["command_position_m"]
    if not log.rig:
        return [Signal("command − robot, as reported", REPORTED, log.tick_s,
                       command_mm - 1e3 * log.tick["robot_position_m"])]
    robot_mm = np.interp(log.tick_s, log.rig_s, 1e3 * log.rig["robot_position_m"])
    return [Signal("command − robot", ROBOT, log.tick_s, command_mm - robot_mm)]


def forces(log):
    """Forces in N, from the sensor spring to the manipulator."""
    tick, rig = log.tick, log.rig
    signals = []
    if log.config["operator"]["interface"] == "force":
        signals.append(Signal("operator", OPERATOR, log.tick_s, tick["operator_force_N"], "dash"))
    if rig:
        signals += [Signal("sensor spring", OBJECT, log.rig_s, rig["spring_force_N"]),
                    Signal("measured (after low-pass)", REPORTED, log.rig_s, rig["measured_force_N"])]
    used_N = tick.get("used_force_N", tick["force_N"])  # with compensation another than the measured one
    return signals + [Signal("used by the loop", MANIPULATOR, log.tick_s, used_N, is_step=True)]


SIDE_DASHES = {"y": "solid", "z": "dash", "rx": "solid", "ry": "dash", "rz": "dot"}
SIDE_COLOURS = {"y": (REPORTED, COMMAND), "z": (MANIPULATOR, OBJECT), "rx": (REPORTED, COMMAND), "ry": (MANIPULATOR, OBJECT),
                "rz": (ROBOT, STORED)}  # of robot and command


def sides(log, rotation):
    """The tool's pose across the loop's direction on the axes that the robot has there: translation in mm, or rotation in
    mrad. The command is dashed and lies on the robot's curve, so that both are seen where they coincide."""
    unit = "rad" if rotation else "m"
    return [Signal(f"{axis}, {label}", colour, log.tick_s, 1e3 * log.side[f"{axis}_{what}_{unit}"], dash)
            for axis, colours in SIDE_COLOURS.items() if axis in log.config.get("axis", {}) and axis.startswith("r") == rotation
            for colour, (label, what, dash) in zip(colours, (("robot, as reported", "robot", "solid"),
                                                             ("command", "command", "dash")))]


def side_loads(log):
    """Measured there: forces in N, and on a second axis torques in N m."""
    colours = dict(zip(SIDE_DASHES, (MANIPULATOR, ROBOT, COMMAND, REPORTED, OBJECT)))
    return [Signal(axis, colours[axis], log.tick_s,
                   log.side[f"{axis}_torque_N_m" if axis.startswith("r") else f"{axis}_force_N"],
                   SIDE_DASHES[axis], is_step=True, is_second_axis=axis.startswith("r"))
            for axis in SIDE_DASHES if axis in log.config.get("axis", {})]


def energies(log):
    """The firmware's energy account in J; none in logs of versions that had none."""
    if "energy_dead_time_J" not in log.tick:
        return []
    kinds = (("dead time made", "dead_time", ROBOT, "solid"),
             ("compensation made", "compensation", REPORTED, "solid"),
             ("step made", "integrator", COMMAND, "dash"),
             ("joints and satellite gave" if log.arm else "operator gave", "operator", OPERATOR, "dash"),
             ("damping took", "dissipated", MANIPULATOR, "dot"),
             ("hardware took", "measured_port", OBJECT, "dot"),
             ("stored", "stored", STORED, "solid"))
    found = ((label, colour, dash, log.tick[f"energy_{name}_J"]) for label, name, colour, dash in kinds
             if f"energy_{name}_J" in log.tick)
    return [Signal(label, colour, log.tick_s, values, dash) for label, colour, dash, values in found if values.any()]


def is_on(log, section):
    """A unit of compensation that is switched on; logs of versions without it have no such section."""
    values = log.config.get(section, {})
    return values.get("enabled") is True or values.get("action", "off") != "off"


def prediction_error(log):
    """What the sensor shows beyond the twin of the hardware, in N, beside the force itself."""
    if not is_on(log, "prediction"):
        return []
    return [Signal("measured", REPORTED, log.tick_s, log.tick["force_N"], "dot", is_step=True),
            Signal("measured less predicted", ROBOT, log.tick_s, log.tick["predicted_error_N"], is_step=True)]


def lead_error(log):
    """What the sensor shows beyond the model's force, as old as it is, in N, beside the force itself."""
    if not is_on(log, "force_lead"):
        return []
    return [Signal("measured", REPORTED, log.tick_s, log.tick["force_N"], "dot", is_step=True),
            Signal("measured less model", ROBOT, log.tick_s, log.tick["lead_error_N"], is_step=True)]


def inverse(log):
    """The robot's delay in ms as the adaptive inverse has it, and on a second axis its gain."""
    if not is_on(log, "adaptive_inverse"):
        return []
    delay_ms = 1e3 * log.tick["inverse_delay_s"].astype(float)
    return [Signal("given", OPERATOR, log.tick_s, np.full_like(delay_ms, delay_ms[0]), "dash"),
            Signal("delay", ROBOT, log.tick_s, delay_ms),
            Signal("gain (right axis)", MANIPULATOR, log.tick_s, log.tick["inverse_gain"].astype(float), "dot",
                   is_second_axis=True)]


def passivity(log):
    """Deficit in J, and on a second axis the controller's force in N."""
    if not is_on(log, "passivity"):
        return []
    return [Signal("deficit (below 0: credit that is left)", ROBOT, log.tick_s, log.tick["passivity_deficit_J"]),
            Signal("force of the controller (right axis)", MANIPULATOR, log.tick_s, log.tick["passivity_force_N"],
                   "dot", is_step=True, is_second_axis=True)]


def believed_object(log):
    """Mass and stiffness as identification has them, as shares of their first values, and on a second axis the damping in
    N s/m."""
    if not is_on(log, "identification") or "believed_mass_kg" not in log.tick:
        return []
    found = []
    for label, field, colour in (("mass", "believed_mass_kg", OBJECT),
                                 ("stiffness", "believed_stiffness_N_per_m", MANIPULATOR)):
        values = log.tick[field].astype(float)
        if values[0] > 0:
            found.append(Signal(f"{label}, given {values[0]:.6g}", colour, log.tick_s, 100 * values / values[0]))
    return found + [Signal("damping (right axis)", COMMAND, log.tick_s,
                           log.tick["believed_damping_N_s_per_m"].astype(float), "dot", is_second_axis=True)]


def believed_dead_time(log):
    """The robot's dead time as identification has it, in ms, and as given."""
    if not is_on(log, "identification") or "believed_dead_time_ms" not in log.tick:
        return []
    values = log.tick["believed_dead_time_ms"].astype(float)
    return [Signal("given", OPERATOR, log.tick_s, np.full_like(values, values[0]), "dash"),
            Signal("tracked", ROBOT, log.tick_s, values)]


def timing(log):
    """Age of the newest force frame in ms, and on a second axis how late the loop woke in us, if it ever did."""
    tick = log.tick
    lateness_us = 1e-3 * (tick["woke_ns"] - tick["scheduled_ns"])
    age_ms = 1e-6 * tick["force_frame_age_ns"]
    found = [Signal("age of the newest force frame", MANIPULATOR, log.tick_s, age_ms, is_step=True)]
    if lateness_us.any():
        found.append(Signal("lateness of the wake-up (right axis)", ROBOT, log.tick_s, lateness_us, "dot",
                            is_second_axis=True))
    return found


def counts(log):
    """Totals of what went wrong on the way; none where nothing did."""
    tick = log.tick
    totals = (("missed ticks", ROBOT, "solid", np.cumsum(tick["missed_ticks"], dtype=np.int64)),
              ("rejected frames", COMMAND, "dash", tick["rejected_frames"]),
              ("lost frames", MANIPULATOR, "dot", tick["lost_frames"]),
              ("error frames", REPORTED, "solid", tick["error_frames"]))
    return [Signal(f"{name}: {total[-1]}", colour, log.tick_s, total.astype(float), dash, is_step=True)
            for name, colour, dash, total in totals if total[-1] > 0]


def bars(log):
    """State of the supervisor, why it stopped, what limited, contact; in this order of rows."""
    tick, time_s, period_s = log.tick, log.tick_s, log.period_s
    found = [Bar("supervisor", name_of(STATES, value), STATE_COLOURS.get(name_of(STATES, value), BAND_COLOUR), *when)
             for value, *when in stretches(tick["state"], time_s, period_s)]
    found += [Bar("stopped because", words(name_of(STOP_CAUSES, value)), BAND_COLOUR, *when)
              for value, *when in stretches(tick["stop_cause"], time_s, period_s) if value != 0]
    for bit, name in enumerate(LIMITS):
        found += [Bar(f"limit: {words(name)}", "", COMMAND, *when)
                  for when in intervals(tick["limits"] >> bit & 1, time_s, period_s)]
    found += [Bar("emergency stop", "", BAD, *when) for when in intervals(tick["emergency_stop"], time_s, period_s)]
    is_off = (tick["enable"] == 0) & (tick["state"] != STATES.index("start"))  # no run begins enabled
    found += [Bar("enable off", "", BAND_COLOUR, *when) for when in intervals(is_off, time_s, period_s)]
    if log.is_contact and log.rig:
        found += [Bar("contact", "", OBJECT, *when) for when in intervals(in_contact(log), log.rig_s, period_s)]
    return found


def in_contact(log):
    """The elastic material pushes on the tool."""
    material, rig = log.config["object"], log.rig
    depth_m = rig["object_position_m"] - material["surface_position_m"]
    force_N = (material["stiffness_N_per_m"] * depth_m
               + material["damping_N_s_per_m"] * rig["object_velocity_m_per_s"])
    return (depth_m > 0.0) & (force_N > 0.0)


def lively_until(log):
    """When the manipulator's motion has died down to a hundredth of its largest, in s; else the end of the run."""
    position_m = log.tick["manipulator_position_m"]
    distance = np.abs(position_m - position_m[-1])
    end_s = log.tick_s[-1] + log.period_s
    lively = np.flatnonzero(distance > 0.01 * distance.max())
    return min(1.1 * log.tick_s[lively[-1]], end_s) if lively.size else end_s


@dataclass(frozen=True)
class Cycle:
    """A swing of the manipulator that neither grows nor dies down, as in the last quarter of a run: from when on, and how
    high it is, peak to peak, in each period."""
    from_s: float
    period_s: float
    time_s: np.ndarray
    heights_mm: np.ndarray


CYCLE_SHARE = 0.8  # of the height of a cycle: from here on the swing is held


def cycle(log, summary):
    """The cycle that the limits hold a growing swing at; None for a run of another verdict."""
    if summary["verdict"] != "limit cycle":
        return None
    position_mm = 1e3 * log.tick["manipulator_position_m"].astype(float)
    last = len(position_mm) * 3 // 4
    above = position_mm[last:] > position_mm[last:].mean()
    rises = np.flatnonzero(~above[:-1] & above[1:])
    if len(rises) < 2:
        return None
    ticks = max(1, int(round((rises[-1] - rises[0]) / (len(rises) - 1))))
    periods = position_mm[:len(position_mm) // ticks * ticks].reshape(-1, ticks)
    heights_mm = np.ptp(periods, axis=1)
    height_mm = float(np.median(heights_mm[len(heights_mm) * 3 // 4:]))
    first = int(np.flatnonzero(heights_mm >= CYCLE_SHARE * height_mm)[0])
    time_s = log.tick_s[:len(heights_mm) * ticks:ticks]
    return Cycle(float(time_s[first]), ticks * log.period_s, time_s[first:], heights_mm[first:])


def height_range(height_mm, used, seen):
    """Powers of ten between which an envelope is worth looking at, of the heights that are seen: far below the fit there is
    only rounding."""
    least_mm = 0.01 * height_mm[used].min() if used.any() else 1e-6 * height_mm.max()
    shown = height_mm[(height_mm > max(least_mm, 1e-12)) & seen]
    return [float(np.log10(shown.min())) - 0.2, float(np.log10(shown.max())) + 0.2] if shown.size else [-3, 0]


# Before a stop: so many doublings of the motion are of interest, and so many seconds at least. After it: a share of that.
DOUBLINGS_SHOWN, BEFORE_STOP_MIN_S, AFTER_STOP_SHARE = 10, 1.0, 0.25
CYCLE_PERIODS_SHOWN = 8  # of a cycle that limits hold
WHOLE_FROM_SHARE = 0.8  # of the run: a part that is longer is no part
SWINGS_SHOWN = 20  # of a motion that goes on: more of them fill a plot, on a phone with one block


def around_peak_force(log, from_s, to_s):
    """(from, to) in s of as many swings of the command as a plot can show, about the largest force; all, if there are no
    more."""
    command_m = log.tick["command_position_m"]
    is_seen = (log.tick_s >= from_s) & (log.tick_s <= to_s)
    above = command_m > command_m[is_seen].mean()
    rise_s = log.tick_s[1:][~above[:-1] & above[1:] & is_seen[1:]]
    if len(rise_s) <= SWINGS_SHOWN:
        return from_s, to_s
    peak_s = log.tick_s[np.argmax(np.where(is_seen, np.abs(log.tick["force_N"]), -1.0))]
    first = np.clip(np.searchsorted(rise_s, peak_s) - SWINGS_SHOWN // 2, 0, len(rise_s) - 1 - SWINGS_SHOWN)
    return from_s if first == 0 else float(rise_s[first]), float(rise_s[first + SWINGS_SHOWN])


def part_that_matters(log, summary):
    """(from, to) in s: what led to the stop of a loop that was stopped, the growth of a swing that limits hold and a few of
    its periods, else the motion until it has died down, or about its largest force where it goes on for long."""
    if len(log.tick_s) == 0:
        return 0.0, 0.0
    start_s, end_s = float(log.tick_s[0]), float(log.tick_s[-1] + log.period_s)
    state, since_s, _ = stretches(log.tick["state"], log.tick_s, log.period_s)[-1]
    from_s, to_s = start_s, float(lively_until(log))
    if name_of(STATES, state) in ("fault", "holding"):
        doubling_s = summary["doubling_time_s"]
        before_s = since_s - start_s if doubling_s is None else max(BEFORE_STOP_MIN_S, DOUBLINGS_SHOWN * doubling_s)
        from_s = max(start_s, float(since_s) - before_s)
        to_s = min(end_s, float(since_s) + AFTER_STOP_SHARE * max(BEFORE_STOP_MIN_S, float(since_s) - from_s))
    elif held := cycle(log, summary):
        before_s = max(BEFORE_STOP_MIN_S, DOUBLINGS_SHOWN * (summary["doubling_time_s"] or held.from_s))
        from_s, to_s = max(start_s, held.from_s - before_s), min(end_s, held.from_s + CYCLE_PERIODS_SHOWN * held.period_s)
        from_s = start_s if from_s - start_s < to_s - from_s else from_s  # the release, where it is near
    elif summary["stable"] is not False:  # growth is seen from its beginning
        from_s, to_s = around_peak_force(log, from_s, to_s)
    return (start_s, end_s) if to_s - from_s > WHOLE_FROM_SHARE * (end_s - start_s) else (from_s, to_s)


def not_running(log):
    """(start, end) in s of the stretches in which the robot may not move."""
    return intervals(log.tick["state"] != STATES.index("running"), log.tick_s, log.period_s)


def _crossing(time_s, values, level, rising, after_s):
    """When `values` first pass `level` in the given direction at or after `after_s`; None if they do not."""
    above = values >= level
    passes = ~above[:-1] & above[1:] if rising else above[:-1] & ~above[1:]
    passes &= time_s[1:] >= after_s
    if not passes.any():
        return None
    i = np.flatnonzero(passes)[0]
    return time_s[i] + (level - values[i]) / (values[i + 1] - values[i]) * (time_s[i + 1] - time_s[i])


def dead_time(log):
    """The command at its fastest while no limit acts, and the robot after it: its true motion, or the reported one where
    that is not known. None where nothing moves."""
    free = (log.tick["state"] == STATES.index("running")) & (log.tick["limits"] == 0)
    command_mm = 1e3 * log.tick["command_position_m"]
    in_one_tick = free[:-1] & free[1:] & (np.diff(log.tick_s) < 1.5 * log.period_s)
    moved_mm = np.where(in_one_tick, np.abs(np.diff(command_mm)), 0.0)
    if moved_mm.size == 0 or moved_mm.max() < 1e-6:
        return None
    i = int(moved_mm.argmax())
    level_mm = 0.5 * (command_mm[i] + command_mm[i + 1])
    command_s = 0.5 * (log.tick_s[i] + log.tick_s[i + 1])
    robot = command_and_robot(log)[-1]
    robot_s = _crossing(robot.time_s, robot.values, level_mm, command_mm[i + 1] > command_mm[i], command_s)
    width_s = max(1e-3 * log.config["robot"]["dead_time_ms"], 2.0 * log.period_s)
    if robot_s is None or robot_s - command_s > 5.0 * width_s:
        return None
    return DeadTime(command_s, robot_s, level_mm, command_s - 4.0 * width_s, command_s + 5.0 * width_s, not log.rig)


def name_of(names, value):
    return names[value] if value < len(names) else f"unknown ({value})"


def words(name):
    return name.replace("_", " ")
