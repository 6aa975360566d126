"""Records of a robot that holds an object with a stiff sensor between: a linear chain, moved by scipy."""

import numpy as np
import scipy.signal
from recipes import recipe, save

PERIOD_s, STEPS, ROWS = 0.0025, 20, 8000
STEP_s = PERIOD_s / STEPS
DEAD_TIME_ms, FORCE_NOISE_N = 10.0, 0.2
SENSOR = {"stiffness_N_per_m": 4e5, "damping_ratio": 0.03, "low_pass_order": 2, "low_pass_frequency_Hz": 60.0,
          "low_pass_damping_ratio": 0.7, "delay_ms": 5.0}
OBJECT = {"mass_kg": 12.0, "stiffness_N_per_m": 3500.0, "damping_N_s_per_m": 25.0}
RIG = f"""
name = "chain"
[robot]
dead_time_ms = {DEAD_TIME_ms}
interpolation = "linear"
[sensor]
""" + "".join(f"{key} = {value}\n" for key, value in SENSOR.items()) + """
[object]
kind = "gripped"
surface_position_m = 0.0
""" + "".join(f"{key} = {value}\n" for key, value in OBJECT.items())


def chain(mass_kg, damping_N_s_per_m, stiffness_N_per_m):
    """From the robot's position and velocity: those of the object, the filtered force and its slope."""
    low, spring = 2 * np.pi * SENSOR["low_pass_frequency_Hz"], SENSOR["stiffness_N_per_m"]
    damper = 2 * SENSOR["damping_ratio"] * np.sqrt(spring * mass_kg)
    a, b = np.zeros((4, 4)), np.zeros((4, 2))
    a[0, 1] = a[2, 3] = 1.0
    a[1, :2] = -(spring + stiffness_N_per_m) / mass_kg, -(damper + damping_N_s_per_m) / mass_kg
    b[1] = spring / mass_kg, damper / mass_kg
    a[3] = -low**2 * spring, -low**2 * damper, -low**2, -2 * SENSOR["low_pass_damping_ratio"] * low
    b[3] = low**2 * spring, low**2 * damper
    return scipy.signal.StateSpace(a, b, np.eye(4)[[2]], np.zeros((1, 2)))


# --- commands, of which each takes what it needs from the record's own random numbers -----------------------------
def chirp(rng):
    return 0.01 * scipy.signal.chirp(PERIOD_s * np.arange(ROWS), 0.1, PERIOD_s * ROWS, 5.0, phi=-90)


def trembling(rng):
    """What is between its rows cannot be told from them."""
    return scipy.signal.lfilter(*scipy.signal.butter(2, 40.0, fs=1 / PERIOD_s), 1e-3 * rng.standard_normal(ROWS))


def chirp_that_trembles(rng):
    """As a noisy force makes it in a closed loop."""
    return chirp(rng) + 5e-6 * rng.standard_normal(ROWS)


def wandering(rng):
    """A few millimetres and up to 5 Hz, as an operator moves."""
    return scipy.signal.lfilter(*scipy.signal.butter(4, 5.0, fs=1 / PERIOD_s), 0.02 * rng.standard_normal(ROWS))


def wandering_in_steps(rng, step_m):
    """Of a controller that counts in them."""
    return step_m * np.round(wandering(rng) / step_m)


# --- rows that a logger lost --------------------------------------------------------------------------------------
def all_rows(rng):
    return np.ones(ROWS, bool)


def without_bursts(rng):
    """Up to four in a row are lost, and one row in fourteen of them all."""
    keep, n = np.ones(ROWS, bool), 50
    while n < ROWS - 50:
        keep[n:n + rng.integers(1, 5)] = False
        n += int(rng.integers(15, 60))
    return keep


def without_bursts_and_a_tenth_of_a_second(rng):
    keep = without_bursts(rng)
    keep[4000:4040] = False
    return keep


def without_twelve_bursts(rng):
    keep = np.ones(ROWS, bool)
    for begin in np.linspace(500, ROWS - 500, 12, dtype=int):
        keep[begin:begin + 4] = False
    return keep


def with_single_rows_between_gaps(rng):
    keep = np.ones(ROWS, bool)
    for begin in np.linspace(700, ROWS - 900, 40, dtype=int):
        keep[begin:begin + 28] = False
        keep[begin + 7 + rng.integers(0, 3)] = True
    return keep


# --- what a sensor makes of the force -----------------------------------------------------------------------------
def as_it_is(force_N, rng):
    return force_N


def with_bias(force_N, rng):
    return force_N + 2.0


def in_steps(force_N, rng, step_N, noise_N=0.0, astray=0.0):
    """With noise upon the steps, and a share of the values off them."""
    level_N = step_N * np.round(force_N / step_N) + noise_N * rng.standard_normal(ROWS)
    return level_N + 0.4 * step_N * rng.uniform(-1.0, 1.0, ROWS) * (rng.uniform(size=ROWS) < astray)


def in_steps_with_spikes(force_N, rng):
    return in_steps(force_N, rng, 1.0, 0.03) + 30.0 * (rng.uniform(size=ROWS) < 0.005)


@recipe()
def chained(folder, seed, goes=chirp, dead_time_ms=DEAD_TIME_ms, keeps=all_rows, command_step_m=1e-12, read=as_it_is):
    """`goes`: the command; `keeps`: which rows are there; `read`: what the sensor makes of the force."""
    rng = np.random.default_rng(seed)
    sent_m = goes(rng)
    keep = keeps(rng)
    t_s, fine_s = PERIOD_s * np.arange(ROWS), STEP_s * np.arange(ROWS * STEPS)
    moved_m = np.interp(fine_s - 1e-3 * dead_time_ms, t_s, sent_m)
    mass, spring, damper = (value * (1.0 + 0.02 * rng.uniform(-1.0, 1.0)) for value in OBJECT.values())
    ways = np.column_stack([moved_m, np.gradient(moved_m, fine_s)])
    felt_N = scipy.signal.lsim(chain(mass, damper, spring), ways, fine_s)[1]
    robot_m = moved_m[::STEPS] + 5e-6 * rng.standard_normal(ROWS)
    force_N = np.interp(t_s - 1e-3 * SENSOR["delay_ms"], fine_s, felt_N) + FORCE_NOISE_N * rng.standard_normal(ROWS)
    columns = {"t_s": t_s, "command_position_m": command_step_m * np.round(sent_m / command_step_m),
               "robot_position_m": robot_m, "force_N": read(force_N, rng)}
    save(folder / "record.csv", **{name: values[keep] for name, values in columns.items()})
    (folder / "rig.toml").write_text(RIG)


# --- setpoints that are lost before a robot that swings -----------------------------------------------------------
RESONANCE_Hz, RESONANCE_RATIO = 8.0, 0.5


def swinging_chain():
    """From the way asked of the robot: its position and velocity, those of the object, the filtered force and its slope."""
    w, low = 2 * np.pi * RESONANCE_Hz, 2 * np.pi * SENSOR["low_pass_frequency_Hz"]
    mass, spring = OBJECT["mass_kg"], SENSOR["stiffness_N_per_m"]
    damper = 2 * SENSOR["damping_ratio"] * np.sqrt(spring * mass)
    a, b = np.zeros((6, 6)), np.zeros((6, 1))
    a[0, 1] = a[2, 3] = a[4, 5] = 1.0
    a[1, :2], b[1] = [-w**2, -2 * RESONANCE_RATIO * w], w**2
    felt_N = np.array([spring, damper, -spring, -damper])
    a[3, :4] = (felt_N - [0, 0, OBJECT["stiffness_N_per_m"], OBJECT["damping_N_s_per_m"]]) / mass
    a[5, :4] = low**2 * felt_N
    a[5, 4:] = -low**2, -2 * SENSOR["low_pass_damping_ratio"] * low
    return scipy.signal.StateSpace(a, b, np.eye(6)[[0, 4]], np.zeros((2, 1)))


@recipe()
def lossy_before_resonance(folder, seed, lost_share):
    """The truth: the share of setpoints that were lost."""
    rng = np.random.default_rng(seed)
    goals_m = np.repeat(rng.uniform(-0.03, 0.03, ROWS // 200), 200)
    sent_m = scipy.signal.lfilter(*scipy.signal.butter(3, 1.5, fs=1 / PERIOD_s), goals_m)
    taken_m, is_lost = sent_m.copy(), rng.random(ROWS) < lost_share
    for n in np.flatnonzero(is_lost[1:]) + 1:
        taken_m[n] = taken_m[n - 1]
    t_s, fine_s = PERIOD_s * np.arange(ROWS), STEP_s * np.arange(ROWS * STEPS)
    asked_m = np.interp(fine_s - 1e-3 * DEAD_TIME_ms, t_s, taken_m)
    moved = scipy.signal.lsim(swinging_chain(), asked_m, fine_s)[1]
    robot_m = moved[::STEPS, 0] + 5e-6 * rng.standard_normal(ROWS)
    force_N = np.interp(t_s - 1e-3 * SENSOR["delay_ms"], fine_s, moved[:, 1]) + FORCE_NOISE_N * rng.standard_normal(ROWS)
    save(folder / "record.csv", t_s=t_s, command_position_m=sent_m, robot_position_m=robot_m, force_N=force_N)
    (folder / "rig.toml").write_text(RIG)
    return {"lost_share": np.mean(is_lost)}
