"""Records of a robot alone: a command and where the robot was, made here by other means than the project's.

A law is a function `law(command_m, t_s, rng)` that gives the robot's position in each row.
"""

import numpy as np
import scipy.signal
from conftest import play
from recipes import recipe, save

PERIOD_s = 0.0025
DEAD_TIME_s = 0.0175  # of rig `ess`, 7 ticks


# --- commands -----------------------------------------------------------------------------------------------------
def multisine(rows, seed, amplitude_m=0.01):
    """Time and a smooth command with 25 lines up to 4 Hz."""
    rng = np.random.default_rng(seed)
    t_s = PERIOD_s * np.arange(rows)
    lines_Hz = np.linspace(0.1, 4.0, 25) * (1.0 + 0.03 * rng.standard_normal(25))
    x = sum(np.sin(2 * np.pi * f * t_s + rng.uniform(0, 2 * np.pi)) / (1.0 + f) for f in lines_Hz)
    return t_s, amplitude_m * x / np.max(np.abs(x)) * np.clip(t_s / 0.5, 0.0, 1.0)


def five_tones(rows, rng):
    """Of up to 2 Hz."""
    t_s = PERIOD_s * np.arange(rows)
    tones_Hz = rng.uniform(0.1, 2.0, 5)
    return t_s, sum(3e-3 * np.sin(2 * np.pi * tone_Hz * t_s + i) for i, tone_Hz in enumerate(tones_Hz))


def triangle(rows, seed):
    t_s = PERIOD_s * np.arange(rows)
    return t_s, 0.01 * scipy.signal.sawtooth(2 * np.pi * t_s / 1.99, 0.5)


def slow_sines(rows, seed):
    t_s = PERIOD_s * np.arange(rows)
    return t_s, 5e-3 * np.sin(1.9 * t_s) + 3e-3 * np.sin(6.9 * t_s + 1.1) + 2e-3 * np.sin(14.5 * t_s + 2.3)


def sines_to_4_Hz(rows, seed):
    t_s = PERIOD_s * np.arange(rows)
    return t_s, sum(a * np.sin(2.0 * np.pi * f * t_s + f) for a, f in ((4e-3, 0.3), (3e-3, 1.1), (2e-3, 2.3), (1e-3, 4.0)))


def random_steps(rows, seed):
    """Of a second each."""
    rng = np.random.default_rng(seed)
    return PERIOD_s * np.arange(rows), np.repeat(0.01 * rng.uniform(-1.0, 1.0, rows // 400), 400)


# --- laws ---------------------------------------------------------------------------------------------------------
def late(command_m, t_s, rng, by_s=DEAD_TIME_s):
    return np.interp(t_s - by_s, t_s, command_m)


def slower_up_than_down(command_m, t_s, rng, up_m_per_s=0.04, down_m_per_s=0.09):
    goal_m = late(command_m, t_s, rng)
    made = np.empty_like(goal_m)
    made[0] = goal_m[0]
    for n in range(1, len(goal_m)):
        way = goal_m[n] - made[n - 1]
        made[n] = made[n - 1] + min(max(way, -down_m_per_s * PERIOD_s), up_m_per_s * PERIOD_s)
    return made


def farther_upwards(command_m, t_s, rng, share=0.02):
    goal_m = late(command_m, t_s, rng)
    return goal_m * np.where(np.gradient(goal_m) > 0.0, 1.0 + share, 1.0)


def lag_that_grows(command_m, t_s, rng, growth=6e-5):
    """A first-order low-pass whose time constant grows from nothing to 1.8 ms in 30 s, integrated a tenth of a tick at a
    time."""
    goal_m, parts = late(command_m, t_s, rng), 10
    x, made = goal_m[0], np.empty_like(goal_m)
    for n in range(len(goal_m)):
        for part in range(1, parts + 1 if n else 1):
            goal = goal_m[n - 1] + (goal_m[n] - goal_m[n - 1]) * part / parts
            lag_s = max(growth * PERIOD_s * (n - 1 + part / parts), 1e-9)
            x = goal + (x - goal) * np.exp(-PERIOD_s / parts / lag_s)
        made[n] = x
    return made


def dead_time_that_grows(command_m, t_s, rng, growth=6e-5):
    return np.interp(t_s * (1.0 - growth), t_s, late(command_m, t_s, rng))


def motor_with_little_voltage(command_m, t_s, rng, gain_per_s=40.0, motor_s=0.05, voltage_max=0.06):
    """A proportional controller on a motor whose voltage ends: it gathers speed with its own lag up to a limit."""
    goal_m, steps = late(command_m, t_s, rng), 10
    x, v, made = goal_m[0], 0.0, np.empty_like(goal_m)
    for n, goal in enumerate(goal_m):
        made[n] = x
        for _ in range(steps):
            wanted = min(max(gain_per_s * (goal - x), -voltage_max), voltage_max)
            v += PERIOD_s / steps * (wanted - v) / motor_s
            x += PERIOD_s / steps * v
    return made


def gain_that_grows_with_the_way(command_m, t_s, rng):
    late_m = late(command_m, t_s, rng)
    return late_m + 30.0 * late_m**3


def jittering(command_m, t_s, rng, jitter_ms=0.0, wander=0.0):
    """A delay that jitters, or a gain that wanders from row to row."""
    late_s = DEAD_TIME_s + 1e-3 * jitter_ms * rng.standard_normal(len(t_s))
    return (1.0 + wander * rng.standard_normal(len(t_s))) * np.interp(t_s - late_s, t_s, command_m)


def late_in_stretches(command_m, t_s, rng, seed):
    """By one period more in some stretches, as behind a queue."""
    begins_s = np.sort(np.random.default_rng(seed).uniform(0.0, t_s[-1], 8))
    more_s = PERIOD_s * (np.searchsorted(begins_s, t_s) % 2)
    return np.interp(t_s - DEAD_TIME_s - more_s, t_s, command_m)


def rippled(command_m, t_s, rng, by_s=DEAD_TIME_s, size_m=8e-6, pitch_m=0.003):
    """With an error that repeats along the way."""
    late_m = late(command_m, t_s, rng, by_s)
    return late_m + size_m * np.sin(2.0 * np.pi * late_m / pitch_m)


def creeping(command_m, t_s, rng):
    return late(command_m, t_s, rng) + 2e-4 * (1.0 - np.exp(-t_s / 8.0))


def scaled(command_m, t_s, rng, gain, by_s):
    return (1.0 + gain) * late(command_m, t_s, rng, by_s)


def ticks_late(command_m, t_s, rng, ticks=7):
    return np.concatenate([np.full(ticks, command_m[0]), command_m[:-ticks]])


def with_play(command_m, t_s, rng, gap_m):
    return play(ticks_late(command_m, t_s, rng), gap_m)


def servo_with_limits(command_m, t_s, rng, frequency_rad_per_s=60.0, damping=0.5, velocity_max=0.08, acceleration_max=2.0):
    goal_m = ticks_late(command_m, t_s, rng)
    x, v, made, steps = goal_m[0], 0.0, np.empty_like(goal_m), 10
    for n, goal in enumerate(goal_m):
        made[n] = x
        for _ in range(steps):
            wanted = frequency_rad_per_s**2 * (goal - x) - 2 * damping * frequency_rad_per_s * v
            v += PERIOD_s / steps * min(max(wanted, -acceleration_max), acceleration_max)
            v = min(max(v, -velocity_max), velocity_max)
            x += PERIOD_s / steps * v
    return made


# --- recipes ------------------------------------------------------------------------------------------------------
ROBOT_RIG = """
name = "robot"
[loop]
rate_Hz = 400
[robot]
dead_time_ms = 17.5
interpolation = "linear"
[bus]
ideal = true
"""


def columns_of_robot(law, goes, rows, seed, noise_seed, noise_m, noise_skips=0):
    t_s, command_m = goes(rows, seed)
    rng = np.random.default_rng(noise_seed)
    rng.random(noise_skips)
    robot_m = law(command_m, t_s, rng)
    return {"t_s": t_s, "command_position_m": command_m, "robot_position_m": robot_m + noise_m * rng.standard_normal(rows)}


@recipe()
def robot(folder, law, goes=multisine, rows=12000, seed=1, noise_seed=101, noise_m=5e-6, noise_skips=0,
          unseen_seed=None, rig=None, digits=12):
    """`unseen_seed`: a further record for --validate; `noise_skips`: so many random numbers before the noise."""
    save(folder / "record.csv", digits, **columns_of_robot(law, goes, rows, seed, noise_seed, noise_m, noise_skips))
    if unseen_seed is not None:
        save(folder / "validate.csv", digits, **columns_of_robot(law, goes, rows, unseen_seed, unseen_seed + 100, noise_m))
    if rig is not None:
        (folder / "rig.toml").write_text(rig)


@recipe()
def stepped_servo(folder, dead_time_ms, lag_ms, rows=800, period_ms=10):
    """First order and dead time under steps, as most servos are."""
    t_s = 1e-3 * period_ms * np.arange(rows)
    command_m = np.repeat([0, 1, 0.3, -0.7, 0.5, 0, -1, 0.8], rows // 8)
    behind = np.concatenate((np.zeros(dead_time_ms // period_ms), command_m))[:rows]
    keeps = np.exp(-period_ms / lag_ms)
    robot_m = scipy.signal.lfilter([0.0, 1.0 - keeps], [1.0, -keeps], behind)
    robot_m += 0.005 * np.random.default_rng(4).standard_normal(rows)
    save(folder / "record.csv", None, t_s=t_s, command_position_m=command_m, robot_position_m=robot_m)
    (folder / "rig.toml").write_text('name = "steps"\n[robot]\ndead_time_ms = 10.0\ninterpolation = "hold"\n')


# --- moves and stands, parts and gaps -----------------------------------------------------------------------------
MOVE_rows = 200


def with_gap(rows, seed, gap_m, start_s=0.0, noise_m=2e-6):
    """Columns of a robot with play, 7 ticks late."""
    rng = np.random.default_rng(seed)
    t_s, command_m = five_tones(rows, rng)
    return {"t_s": start_s + t_s, "command_position_m": command_m,
            "robot_position_m": with_play(command_m, t_s, rng, gap_m) + noise_m * rng.standard_normal(rows)}


def moves_and_stands(seed, gap_m):
    """Setpoints of 20 moves, half a second each, with stands as long between them, and the robot behind them."""
    rng = np.random.default_rng(seed)
    move, stand = np.sin(0.5 * np.pi * np.linspace(0.0, 1.0, MOVE_rows)) ** 2, np.ones(MOVE_rows)
    goals_m = np.cumsum(rng.choice([-1.0, 1.0], 21) * rng.uniform(2e-3, 8e-3, 21))
    command_m = np.concatenate([before + (after - before) * np.r_[move, stand]
                                for before, after in zip(goals_m[:-1], goals_m[1:])])
    return command_m, with_play(command_m, None, rng, gap_m), rng


@recipe()
def played(folder, rows, seed, gap_m, start_s=0.0, part_rows=None, gone=(), more=None):
    """A robot with play. `part_rows`: in parts of so many rows; `gone`: stretches of rows that are missing; `more`: a
    second record, of a robot by itself, as second.csv (rows, seed, gap_m, moved by)."""
    columns = with_gap(rows, seed, gap_m, start_s)
    if part_rows:
        columns["segment"] = np.arange(rows) // part_rows
    kept = np.ones(rows, bool)
    for first, last in gone:
        kept[first:last] = False
    save(folder / "record.csv", **{name: values[kept] for name, values in columns.items()})
    if more:
        second = with_gap(*more[:3], start_s=more[3] if len(more) > 3 else 0.0)
        for name in ("command_position_m", "robot_position_m"):
            second[name] = second[name] + (more[4] if len(more) > 4 else 0.0)
        save(folder / "second.csv", **second)


@recipe()
def with_other_signals(folder):
    """The second record lacks the robot's position."""
    columns = with_gap(3000, 7, 2e-4)
    save(folder / "record.csv", **columns)
    columns.pop("robot_position_m")
    save(folder / "second.csv", **columns)


@recipe()
def parts_of_moves(folder, seed, gap_m):
    """Parts of three moves, each from the middle of a stand on, at the edge of the play."""
    command_m, robot_m, rng = moves_and_stands(seed, gap_m)
    robot_m += 5e-6 * rng.standard_normal(len(command_m))
    kept = np.arange(3 * MOVE_rows // 2, len(command_m) - MOVE_rows // 2)
    save(folder / "record.csv", t_s=PERIOD_s * kept, command_position_m=command_m[kept], robot_position_m=robot_m[kept],
         segment=np.arange(len(kept)) // (6 * MOVE_rows))


@recipe()
def coarse_reports(folder, seed, gap_m, step_m=1e-5):
    """Of a robot that moves and stands: its rounding is the same for as long as it stands."""
    command_m, robot_m, rng = moves_and_stands(seed, gap_m)
    read_m = step_m * np.round((robot_m + 0.1 * step_m * rng.standard_normal(len(robot_m))) / step_m)
    save(folder / "record.csv", t_s=PERIOD_s * np.arange(len(command_m)), command_position_m=command_m,
         robot_position_m=read_m)

