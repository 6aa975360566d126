"""Records of an object that a robot holds or touches, and the force upon it, made here by other means than the project's:
transfer functions of scipy, and exact steps of the matrix exponential."""

import tomllib

import numpy as np
import scipy.linalg
import scipy.signal
from conftest import RIG_FOLDER
from make_robot import DEAD_TIME_s, PERIOD_s, multisine
from recipes import recipe, save

NOISE_N = 0.2

# --- an object that relaxes, as rubber does, and a sensor that lags ------------------------------------------------
TOUCH_NOISE_N = 0.05
TOUCH_DEAD_TIME_s, TOUCH_DELAY_s, LOW_PASS_Hz = 0.012, 0.0025, 60.0
TOUCH_STEPS = 10  # of a period
TOUCH_RIG = """
name = "touch"
[loop]
rate_Hz = 400
[robot]
dead_time_ms = 12.0
interpolation = "linear"
[sensor]
stiffness_N_per_m = 2e7
damping_ratio = 0.05
low_pass_order = 1
low_pass_frequency_Hz = 60.0
delay_ms = 2.5
[object]
kind = "gripped"
mass_kg = {{ value = 0.001, tolerance = 0.08 }}
stiffness_N_per_m = {{ value = {stiffness_N_per_m}, tolerance = 0.08 }}
damping_N_s_per_m = {{ value = {damping_N_s_per_m}, tolerance = 0.15 }}
surface_position_m = 0.0
[bus]
ideal = true
"""


def relaxing(k, d, k1, tau_s):
    """k + d s + k1 tau s / (1 + tau s): a spring and a damper beside a spring and a damper in series."""
    return [d * tau_s, d + (k + k1) * tau_s, k], [tau_s, 1.0]


def lagging(k, d, tau_s):
    """The same spring and damper before a sensor that lags."""
    return [d, k], [tau_s, 1.0]


@recipe()
def touched(folder, seed, law, stiffness_N_per_m, damping_N_s_per_m):
    """A force that this transfer function (numerator, denominator) makes of the robot's motion, beside a rig with these
    values."""
    rng = np.random.default_rng(seed)
    t_s = PERIOD_s * np.arange(8000)
    lines_Hz = np.linspace(0.1, 3.0, 25)
    command_m = sum(np.sin(2 * np.pi * f * t_s + rng.uniform(0, 2 * np.pi)) for f in lines_Hz)
    command_m *= 0.004 / np.max(np.abs(command_m)) * np.clip(t_s, 0.0, 1.0)
    fine_s = PERIOD_s / TOUCH_STEPS * np.arange(len(t_s) * TOUCH_STEPS)
    robot_m = np.interp(fine_s - TOUCH_DEAD_TIME_s, t_s, command_m)
    numerator, denominator = law
    low_pass = [1.0 / (2 * np.pi * LOW_PASS_Hz), 1.0]
    _, force_N, _ = scipy.signal.lsim((numerator, np.polymul(denominator, low_pass)), robot_m, fine_s)
    save(folder / "record.csv", t_s=t_s, command_position_m=command_m,
         robot_position_m=robot_m[::TOUCH_STEPS] + 2e-6 * rng.standard_normal(len(t_s)),
         force_N=np.interp(t_s - TOUCH_DELAY_s, fine_s, force_N) + TOUCH_NOISE_N * rng.standard_normal(len(t_s)))
    (folder / "rig.toml").write_text(TOUCH_RIG.format(stiffness_N_per_m=stiffness_N_per_m,
                                                      damping_N_s_per_m=damping_N_s_per_m))


# --- an object behind the sensor's spring --------------------------------------------------------------------------
def force_on_a_soft_sensor(robot_m, step_s, held, sensor):
    """Of an object behind the sensor's spring, after rig ess' low-pass of 20 Hz; lines between the rows."""
    mass_kg, damping_N_s_per_m, stiffness_N_per_m = held.values()
    spring_N_per_m, turn_per_s = sensor["sensor.stiffness_N_per_m"], 2 * np.pi * 20.0
    damper = 2 * sensor["sensor.damping_ratio"] * np.sqrt(spring_N_per_m * mass_kg)
    whole = np.array([mass_kg, damping_N_s_per_m, stiffness_N_per_m])
    above = turn_per_s ** 2 * np.polymul([damper, spring_N_per_m], whole)
    below = np.polymul(whole + [0, damper, spring_N_per_m], [1, 2 * 0.7 * turn_per_s, turn_per_s ** 2])
    fast = 200.0  # time in units that keep the coefficients together
    above, below = above * fast ** np.arange(3, -1, -1), below * fast ** np.arange(4, -1, -1)
    return scipy.signal.lsim((above, below), robot_m, fast * step_s * np.arange(len(robot_m)))[1]


SOFT = {"sensor.stiffness_N_per_m": 1e6, "sensor.damping_ratio": 0.02}
HELD = {"object.mass_kg": 100.0, "object.damping_N_s_per_m": 20.0, "object.stiffness_N_per_m": 2400.0}
BENT = {"object.mass_kg": 100.0, "object.damping_N_s_per_m": 19.46773764467334, "object.stiffness_N_per_m": 2368.705056261446}


@recipe()
def parts_that_ring(folder):
    """Parts of 3 s that begin in motion, of an object that decays by 2/s."""
    rng = np.random.default_rng(1)
    t_s, command_m = multisine(24000, 1)
    fine_s = 0.1 * PERIOD_s * np.arange(10 * len(t_s))
    force_N = force_on_a_soft_sensor(np.interp(fine_s - DEAD_TIME_s, t_s, command_m), fine_s[1], HELD, SOFT)
    whole = {"t_s": t_s, "command_position_m": command_m,
             "robot_position_m": np.interp(t_s - DEAD_TIME_s, t_s, command_m) + 5e-6 * rng.standard_normal(len(t_s)),
             "force_N": np.interp(t_s - 0.0025, fine_s, force_N) + NOISE_N * rng.standard_normal(len(t_s))}
    speed = np.abs(np.gradient(command_m))
    begins = [first + np.argmax(speed[first:first + 800]) for first in range(400, 22000, 3200)]
    kept = np.concatenate([np.arange(begin, begin + 1200) for begin in begins])
    save(folder / "record.csv", **{name: values[kept] for name, values in whole.items()},
         segment=np.arange(len(kept)) // 1200)


@recipe()
def behind_a_bent_way(folder, bend_per_m2, seed):
    """The robot bends its way, as the library has it not."""
    rng = np.random.default_rng(seed)
    t_s = PERIOD_s * np.arange(8000)
    command_m = 0.0037 * (1.0 - np.exp(-(2.0 * t_s)**2)) * sum(
        np.sin(2 * np.pi * tone_Hz * t_s + rng.uniform(0, 2 * np.pi)) for tone_Hz in np.linspace(0.1, 2.0, 14))
    fine_s = 0.1 * PERIOD_s * np.arange(10 * len(t_s))
    there_m = np.interp(fine_s - DEAD_TIME_s, t_s, command_m)
    there_m += bend_per_m2 * there_m**3
    force_N = force_on_a_soft_sensor(there_m, fine_s[1], BENT,
                                     {"sensor.stiffness_N_per_m": 2e7, "sensor.damping_ratio": 0.05})
    save(folder / "record.csv", t_s=t_s, command_position_m=command_m,
         robot_position_m=there_m[::10] + 5e-6 * rng.standard_normal(len(t_s)),
         force_N=np.interp(t_s - 0.0025, fine_s, force_N) + NOISE_N * rng.standard_normal(len(t_s)))


# --- setpoints that are lost before a soft contact, which feels few of them ----------------------------------------
FOAM = tomllib.loads((RIG_FOLDER / "concept-foam.toml").read_text())
FOAM_STEPS = 20  # of a period
STEP_s = PERIOD_s / FOAM_STEPS


def strides(rows, rng, reach_m=0.01):
    """A smooth way between goals on both sides of the surface: for half of it there is no contact."""
    goal_m = np.empty(rows)
    n = 0
    while n < rows:
        more = int(rng.uniform(0.4, 1.2) / PERIOD_s)
        goal_m[n:n + more] = rng.uniform(-reach_m, reach_m)
        n += more
    wide = 2 * np.pi * 2.0
    way = scipy.signal.StateSpace([[0, 1], [-wide**2, -0.8 * wide]], [[0], [wide**2]], [[1, 0]], [[0]])
    return scipy.signal.lsim(way, goal_m, PERIOD_s * np.arange(rows))[1]


def step_matrices(is_touching):
    """Of position and velocity of the tool, force behind the low pass and its slope; the robot moves evenly."""
    sensor, foam = FOAM["sensor"], FOAM["object"]
    mass = foam["mass_kg"]
    spring, damper = sensor["stiffness_N_per_m"], 2 * sensor["damping_ratio"] * np.sqrt(
        sensor["stiffness_N_per_m"] * mass)
    stiffness, damping = (foam["stiffness_N_per_m"], foam["damping_N_s_per_m"]) if is_touching else (0.0, 0.0)
    low = 2 * np.pi * sensor["low_pass_frequency_Hz"]
    whole = np.zeros((6, 6))  # with the robot's position and velocity
    whole[0, 1] = whole[2, 3] = whole[4, 5] = 1.0
    whole[1] = np.array([-spring - stiffness, -damper - damping, 0.0, 0.0, spring, damper]) / mass
    whole[3] = [-low**2 * spring, -low**2 * damper, -low**2, -2 * sensor["low_pass_damping_ratio"] * low,
                low**2 * spring, low**2 * damper]
    made = scipy.linalg.expm(STEP_s * whole)[:4]
    return made[:, :4], made[:, 4:]


def force_on_foam(robot_m):
    """In each step; free where the foam would have to pull."""
    foam = FOAM["object"]
    free, touching = step_matrices(False), step_matrices(True)
    state, made_N = np.array([robot_m[0], 0.0, 0.0, 0.0]), np.empty(len(robot_m))
    velocity_m_per_s = np.append(np.diff(robot_m), 0.0) / STEP_s
    for n, drive in enumerate(np.column_stack([robot_m, velocity_m_per_s])):
        made_N[n] = state[2]
        depth_m = state[0] - foam["surface_position_m"]
        is_touching = depth_m > 0.0 and foam["stiffness_N_per_m"] * depth_m + foam["damping_N_s_per_m"] * state[1] > 0.0
        own, driven = touching if is_touching else free
        state = own @ state + driven @ drive
    return made_N


def robot_on(setpoint_m, lag_ms):
    """Its way in each step, behind its dead time and a lag of first order."""
    t_s = PERIOD_s * np.arange(len(setpoint_m))
    fine_s = STEP_s * np.arange(len(setpoint_m) * FOAM_STEPS)
    robot_m = np.interp(fine_s - 1e-3 * FOAM["robot"]["dead_time_ms"], t_s, setpoint_m)
    if lag_ms > 0.0:
        keeps = np.exp(-STEP_s / (1e-3 * lag_ms))
        robot_m = scipy.signal.lfilter([1 - keeps], [1, -keeps], robot_m, zi=[keeps * robot_m[0]])[0]
    return robot_m


def measured_on_foam(robot_m):
    """The force in each row, without noise."""
    t_s = STEP_s * np.arange(len(robot_m))
    return np.interp(t_s[::FOAM_STEPS] - 1e-3 * FOAM["sensor"]["delay_ms"], t_s, force_on_foam(robot_m))


@recipe()
def lossy_on_foam(folder, seed, lost_share, lag_ms, rows=12000, force_step_N=0.0):
    """The truth: the share of setpoints that are lost, the mean square [N2] of what that does to the force, and its share
    of the error of the robot as given, which has no lag."""
    rng = np.random.default_rng(seed)
    sent_m = strides(rows, rng)
    taken_m = sent_m.copy()
    is_lost = rng.random(rows) < lost_share
    for n in np.flatnonzero(is_lost[1:]) + 1:
        taken_m[n] = taken_m[n - 1]
    robot_m, loses_none_m = robot_on(taken_m, lag_ms), robot_on(sent_m, lag_ms)
    exact_N = measured_on_foam(robot_m)
    force_N = exact_N + NOISE_N * rng.standard_normal(rows)
    if force_step_N > 0.0:
        force_N = force_step_N * np.round(force_N / force_step_N)
    save(folder / "record.csv", t_s=PERIOD_s * np.arange(rows), command_position_m=sent_m,
         robot_position_m=robot_m[::FOAM_STEPS] + 5e-6 * rng.standard_normal(rows), force_N=force_N)
    made_N2 = np.mean((exact_N - measured_on_foam(loses_none_m)) ** 2)
    made_m2, as_given_m2 = (np.mean((robot_m - other_m)[::FOAM_STEPS] ** 2) for other_m in
                            (loses_none_m, robot_on(sent_m, 0.0)))
    return {"lost_share": np.mean(is_lost), "made_N2": made_N2, "of_robot": made_m2 / as_given_m2 if made_m2 > 0.0 else 0.0}


# --- records without setpoints: the measured motion of a test machine and the force upon it ------------------------
SPECIMEN_RATE_Hz, SPECIMEN_ROWS, FINE, SPECIMEN_NOISE_N = 200.0, 6000, 40, 0.3
SPECIMEN_RIG = """
name = "specimen"
[object]
mass_kg = 0.001
stiffness_N_per_m = { value = 8200.0, tolerance = 0.1 }
damping_N_s_per_m = { value = 62.0, tolerance = 0.1 }
[sensor]
low_pass_order = 0
delay_ms = 0.0
[bus]
ideal = true
"""


def motion_of_the_machine(seed):
    """Position and velocity, `FINE` values a row: 20 lines up to 4 Hz, none a multiple of another."""
    rng = np.random.default_rng(seed)
    t_s = np.arange(SPECIMEN_ROWS * FINE) / SPECIMEN_RATE_Hz / FINE
    lines_Hz = np.linspace(0.2, 4.0, 20) * (1.0 + 0.03 * rng.standard_normal(20))
    sizes_m = 0.02 / (1.0 + lines_Hz) / np.sum(1.0 / (1.0 + lines_Hz))
    phases = rng.uniform(0, 2 * np.pi, 20)
    x_m = sum(a * np.sin(2 * np.pi * f * t_s + p) for a, f, p in zip(sizes_m, lines_Hz, phases))
    v_m_per_s = sum(a * 2 * np.pi * f * np.cos(2 * np.pi * f * t_s + p) for a, f, p in zip(sizes_m, lines_Hz, phases))
    return x_m, v_m_per_s


def no_law(x_m):
    return 0.0


def cubic_N(x_m):
    return 5e6 * x_m**3


def dahl_N(x_m, force_N=6.0, length_m=8e-4):
    """Exact for motion in one direction between two values."""
    z = np.zeros_like(x_m)
    for n in range(1, len(x_m)):
        way_m = x_m[n] - x_m[n - 1]
        towards = np.sign(way_m)
        z[n] = towards - (towards - z[n - 1]) * np.exp(-abs(way_m) / length_m)
    return force_N * z


@recipe()
def specimen(folder, law=no_law, noise_m=0.0, has_force=True):
    """Of 8000 N/m and 60 N s/m, with a second record for --validate."""
    for name, seed in (("record", 1), ("validate", 2)):
        x_m, v_m_per_s = motion_of_the_machine(seed)
        force_N = (8000.0 * x_m + 60.0 * v_m_per_s + law(x_m))[::FINE]
        rng = np.random.default_rng(seed + 100)
        columns = {"t_s": np.arange(SPECIMEN_ROWS) / SPECIMEN_RATE_Hz,
                   "robot_position_m": x_m[::FINE] + noise_m * rng.standard_normal(SPECIMEN_ROWS),
                   "force_N": force_N + SPECIMEN_NOISE_N * rng.standard_normal(SPECIMEN_ROWS)}
        if has_force:
            save(folder / f"{name}.csv", **columns)
        elif name == "record":
            columns.pop("force_N")
            save(folder / "record.csv", **columns)
    (folder / "rig.toml").write_text(SPECIMEN_RIG)
