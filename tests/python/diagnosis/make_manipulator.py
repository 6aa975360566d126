"""Records of a manipulator, of which the driving force and the position are measured, made here by other means than the
project's: scipy's integrators, exact steps, and Runge-Kutta."""

import numpy as np
import scipy.linalg
import scipy.signal
from make_robot import multisine
from recipes import recipe, save
from scipy.integrate import solve_ivp

PERIOD_s = 0.0025

# --- commands with many digits ------------------------------------------------------------------------------------
PRECISE_ROWS = 4000
GIVEN = {"mass_kg": 200.0, "damping_N_s_per_m": 125.0, "stiffness_N_per_m": 7900.0}
FRICTION_N = 6.0
LINES_rad_per_s = 2 * np.pi * np.array([0.31, 0.73, 1.13, 1.97])


# Further force against the motion, N, of the way off the goal and of velocity.
def nothing_more(x, v):
    return 0.0


def asymmetric_N(x, v, size=20.0):
    return size * abs(v)


def cubic_N(x, v, size=2e6):
    return size * x**3


def quadratic_N(x, v, size=5e4):
    return size * x**2


def constant_N(x, v, size):
    return -size


def moves(push_N, law=nothing_more, scale=1.0, goal_m=None):
    """Each row from where the one before ended, the push held over it; the law is of what is off the goal."""
    m, d, k = (scale * GIVEN[key] for key in GIVEN)
    state, path_m = np.zeros(2), []
    for push, goal in zip(push_N, np.zeros(len(push_N)) if goal_m is None else goal_m):
        path_m.append(state[0])
        state = solve_ivp(lambda _, y, push=push, goal=goal: [
            y[1], (push - d * y[1] - k * y[0] - law(y[0] - goal, y[1])) / m],
            (0.0, PERIOD_s), state, method="DOP853", rtol=1e-12, atol=1e-15).y[:, -1]
    return np.array(path_m)


def sticks_and_slides(push_N):
    """Each row from where the one before ended; where it stops, it sticks while the friction holds the rest, else it
    goes on the other way."""
    m, d, k = (1.02 * GIVEN[key] for key in GIVEN)

    def stops(_, y):
        return y[1]

    stops.terminal = True
    state, path_m = np.zeros(2), []
    for push in push_N:
        path_m.append(state[0])
        left_s = PERIOD_s
        while left_s > 0.0:
            rest_N = push - k * state[0]
            if state[1] == 0.0 and abs(rest_N) <= FRICTION_N:
                break
            way = np.sign(state[1]) or np.sign(rest_N)
            stops.direction = -way
            part = solve_ivp(lambda _, y, push=push, way=way: [y[1], (push - d * y[1] - k * y[0] - way * FRICTION_N) / m],
                             (0.0, left_s), state, method="DOP853", rtol=1e-12, atol=1e-15, events=stops)
            state, left_s = part.y[:, -1], left_s - part.t[-1]
            if part.status == 1:
                state[1] = 0.0
            else:
                left_s = 0.0
    return np.array(path_m)


def precise_rig(more=""):
    return 'name = "precise"\n[manipulator]\n' + "".join(
        f"{key} = {{ value = {value}, tolerance = 0.05 }}\n" for key, value in GIVEN.items()) + more


@recipe()
def pushed(folder, moves, seed=3, step_m=None, more=""):
    """By a swaying force; `step_m`: of the command, none: 13 digits; `more`: of the rig file."""
    t_s = np.arange(PRECISE_ROWS) * PERIOD_s
    push_N = sum(30.0 * np.sin(2 * np.pi * f * t_s + p) for f, p in zip(
        (0.31, 0.73, 1.13, 1.97), np.random.default_rng(seed).uniform(0, 2 * np.pi, 4)))
    command_m = moves(push_N)
    if step_m is not None:
        command_m = np.round(command_m / step_m) * step_m
    save(folder / "record.csv", 13, t_s=t_s, operator_force_N=push_N, command_position_m=command_m)
    (folder / "rig.toml").write_text(precise_rig(more))


@recipe()
def guided(folder, law):
    """By an operator's motion, held over the tick, as the regression takes it to be only nearly."""
    t_s = np.arange(PRECISE_ROWS) * PERIOD_s
    operator_m = sum(0.004 * (np.cos(w * t_s) - 1.0) for w in LINES_rad_per_s)
    operator_m_per_s = sum(-0.004 * w * np.sin(w * t_s) for w in LINES_rad_per_s)
    push_N = GIVEN["stiffness_N_per_m"] * operator_m + GIVEN["damping_N_s_per_m"] * operator_m_per_s
    save(folder / "record.csv", 13, t_s=t_s, operator_position_m=operator_m, operator_velocity_m_per_s=operator_m_per_s,
         command_position_m=moves(push_N, law, 1.0, operator_m))
    (folder / "rig.toml").write_text(precise_rig())


# --- forces with few digits: rounding, integrated twice, is slow and smooth ---------------------------------------
DIGIT_ROWS, DIGIT_STEPS = 8000, 64


def pushed_exactly(push_N, friction_N):
    """Position where each push is held over its row: exact, but for the instants at which the friction turns."""
    mass, damping, stiffness = GIVEN.values()
    a = np.array([[0.0, 1.0, 0.0], [-stiffness / mass, -damping / mass, 1.0 / mass], [0.0, 0.0, 0.0]])
    (xx, xv, xp), (vx, vv, vp) = scipy.linalg.expm(a * PERIOD_s / DIGIT_STEPS)[:2]
    x, v, position_m = 0.0, 0.0, np.empty(DIGIT_ROWS)
    for n, push in enumerate(push_N):
        position_m[n] = x
        for _ in range(DIGIT_STEPS):
            free = vx * x + vv * v + vp * push
            against_N = min(friction_N, abs(free) / vp) * (1.0 if free > 0.0 else -1.0)
            x, v = xx * x + xv * v + xp * (push - against_N), free - vp * against_N
    return position_m


@recipe()
def written(folder, digits, friction_N=0.0):
    """`digits`: the format of the force."""
    rng = np.random.default_rng(3)
    t_s = PERIOD_s * np.arange(DIGIT_ROWS)
    push_N = 60.0 * np.sin(2 * np.pi * (0.2 + 0.1 * t_s) * t_s) * np.sin(2 * np.pi * 0.07 * t_s)
    push_N += 0.1 * rng.standard_normal(DIGIT_ROWS)
    lines = [f"{t:.4f},{digits % push},{x:.11f}" for t, push, x in zip(t_s, push_N, pushed_exactly(push_N, friction_N))]
    (folder / "record.csv").write_text("\n".join(["t_s,operator_force_N,command_position_m"] + lines) + "\n")
    (folder / "rig.toml").write_text('name = "few-digits"\n[manipulator]\n' + "".join(
        f"{key} = {value}\n" for key, value in GIVEN.items()))


# --- a force that may have moved between the rows -----------------------------------------------------------------
DRIVE_RIG = """
name = "drive"
[loop]
rate_Hz = {rate_Hz}
[manipulator]
mass_kg = 20.0
damping_N_s_per_m = 60.0
stiffness_N_per_m = 0.0
[operator]
interface = "force"
"""


@recipe()
def driven(folder, every):
    """A drive with dry friction of 30 N, controlled at 1 kHz, of which every so many rows one is kept."""
    period_s = 0.001
    t_s = period_s * np.arange(30000)
    wanted_m = 0.05 * np.sin(2 * np.pi * 0.5 * t_s) + 0.01 * np.sin(2 * np.pi * 1.7 * t_s)
    x, v, steps = 0.0, 0.0, 20
    force_N, position_m = np.empty_like(t_s), np.empty_like(t_s)
    for n, goal in enumerate(wanted_m):
        position_m[n] = x
        force_N[n] = 60000.0 * (goal - x) - 1500.0 * v
        for _ in range(steps):
            v += period_s / steps * (force_N[n] - 60.0 * v - 30.0 * np.tanh(v / 1e-4)) / 20.0
            x += period_s / steps * v
    position_m += 1e-7 * np.random.default_rng(3).standard_normal(len(t_s))
    save(folder / "record.csv", t_s=t_s[::every], operator_force_N=force_N[::every], command_position_m=position_m[::every])
    (folder / "rig.toml").write_text(DRIVE_RIG.format(rate_Hz=1000 // every))


@recipe()
def slow_record(folder):
    """20 Hz, and the rig file states neither a rate nor a robot: its dead time is less than a period."""
    t_s = 0.05 * np.arange(1200)
    force_N = 5.0 * np.sin(1.3 * t_s) + 3.0 * np.sin(2.9 * t_s)
    held = scipy.signal.cont2discrete((np.array([[0.0, 1.0], [-20.0, -1.0]]), np.array([[0.0], [0.05]]),
                                       np.array([[1.0, 0.0]]), np.zeros((1, 1))), 0.05)
    position_m = scipy.signal.dlsim(held, force_N)[1][:, 0] + 1e-4 * np.random.default_rng(2).standard_normal(1200)
    save(folder / "record.csv", t_s=t_s, operator_force_N=force_N, command_position_m=position_m)
    (folder / "rig.toml").write_text("[manipulator]\nmass_kg = 20\ndamping_N_s_per_m = 20\nstiffness_N_per_m = 400\n")


FAST_RIG = """
name = "fast"
[loop]
rate_Hz = {rate_Hz}
[manipulator]
mass_kg = {{ value = 0.53, tolerance = 0.1 }}
damping_N_s_per_m = {{ value = 9.5, tolerance = 0.1 }}
stiffness_N_per_m = {{ value = 18500.0, tolerance = 0.1 }}
[operator]
interface = "force"
"""
OVERSAMPLED = 16


def oscillator(force_N, is_held, cubic_N_per_m3, step_s):
    """Its position at the force's instants, between which that is held or straight: 0.5 kg, 9 N s/m, 18 kN/m."""
    def slope(x, v, push_N):
        return v, (push_N - 9.0 * v - 18000.0 * x - cubic_N_per_m3 * x**3) / 0.5

    x, v, position_m = 0.0, 0.0, np.zeros_like(force_N)
    for n in range(len(force_N) - 1):
        position_m[n] = x
        next_N = force_N[n] if is_held else force_N[n + 1]
        middle_N = 0.5 * (force_N[n] + next_N)
        a, b = slope(x, v, force_N[n])  # Runge-Kutta
        c, d = slope(x + step_s / 2 * a, v + step_s / 2 * b, middle_N)
        e, f = slope(x + step_s / 2 * c, v + step_s / 2 * d, middle_N)
        g, h = slope(x + step_s * e, v + step_s * f, next_N)
        x, v = x + step_s / 6 * (a + 2 * c + 2 * e + g), v + step_s / 6 * (b + 2 * d + 2 * f + h)
    position_m[-1] = x
    return position_m


def held_at_the_rows(force_N):
    return np.repeat(force_N[::OVERSAMPLED], OVERSAMPLED)


@recipe()
def shaken(folder, moves, cubic_N_per_m3):
    """Noise up to half of the highest frequency drives an oscillator of 30 Hz, logged at 400 Hz."""
    rate_Hz, rng = 400.0, np.random.default_rng(11)
    for name in ("record", "validate"):
        force_N = rng.standard_normal(4000 * OVERSAMPLED)
        force_N = scipy.signal.sosfilt(scipy.signal.butter(9, 100.0, fs=rate_Hz * OVERSAMPLED, output="sos"), force_N)
        force_N *= 20.0 / force_N.std()
        force_N = force_N if moves else held_at_the_rows(force_N)
        position_m = oscillator(force_N, not moves, cubic_N_per_m3, 1.0 / rate_Hz / OVERSAMPLED)[::OVERSAMPLED]
        position_m += 1e-5 * rng.standard_normal(4000)
        save(folder / f"{name}.csv", t_s=np.arange(4000) / rate_Hz, operator_force_N=force_N[::OVERSAMPLED],
             command_position_m=position_m)
    (folder / "rig.toml").write_text(FAST_RIG.format(rate_Hz=400))


@recipe()
def slowly_shaken(folder, moves):
    """At 1 kHz the force hardly changes from row to row; held, it is late by ten times the noise."""
    rate_Hz = 1000.0
    t_s = np.arange(12000 * OVERSAMPLED) / rate_Hz / OVERSAMPLED
    force_N = sum(8.0 * np.sin(2 * np.pi * tone_Hz * t_s + i) for i, tone_Hz in enumerate((1.1, 2.9, 5.3, 7.7)))
    force_N = force_N if moves else held_at_the_rows(force_N)
    position_m = oscillator(force_N, not moves, 0.0, 1.0 / rate_Hz / OVERSAMPLED)[::OVERSAMPLED]
    position_m += 1e-6 * np.random.default_rng(5).standard_normal(12000)
    save(folder / "record.csv", t_s=t_s[::OVERSAMPLED], operator_force_N=force_N[::OVERSAMPLED],
         command_position_m=position_m)
    (folder / "rig.toml").write_text(FAST_RIG.format(rate_Hz=1000))


# --- more -----------------------------------------------------------------------------------------------------------
@recipe()
def scaled_push(folder, scale=0.85):
    """A manipulator of which all is scaled, or a force that is."""
    mass_kg, damping_N_s_per_m, stiffness_N_per_m = 150.0, 400.0, 6000.0
    t_s, push_N = multisine(12000, 6, amplitude_m=200.0)
    step = scipy.linalg.expm(PERIOD_s * np.array([[0, 1, 0], [-stiffness_N_per_m / mass_kg, -damping_N_s_per_m / mass_kg,
                                                              1 / mass_kg], [0, 0, 0]]))
    state, position_m = np.zeros(2), np.empty(len(t_s))
    for n, force_N in enumerate(push_N):
        position_m[n] = state[0]
        state = step[:2, :2] @ state + step[:2, 2] * force_N
    position_m += 1e-6 * np.random.default_rng(8).standard_normal(len(t_s))
    save(folder / "record.csv", t_s=t_s, command_position_m=position_m, operator_force_N=scale * push_N)
    (folder / "rig.toml").write_text(
        f'[manipulator]\nmass_kg = {mass_kg}\ndamping_N_s_per_m = {damping_N_s_per_m}\n'
        f'stiffness_N_per_m = {stiffness_N_per_m}\n[operator]\ninterface = "force"\n')


def rubbing_more_one_way(v_m_per_s, push_N):
    return push_N - 60.0 * abs(v_m_per_s)


def rubbing_with_an_offset(v_m_per_s, push_N):
    return push_N + 4.0 - 6.0 * np.tanh(v_m_per_s / 1e-5)


@recipe()
def ess_pushed(folder, tones, pull, steps, noise_m):
    """The manipulator of rig `ess`; `tones`: [(N, rad/s)]."""
    mass_kg, damping_N_s_per_m, stiffness_N_per_m = 200.0, 125.664, 7895.684
    t_s = PERIOD_s * np.arange(8000)
    operator_N = sum(size_N * np.sin(turn * t_s) for size_N, turn in tones)
    x_m, v_m_per_s, command_m = 0.0, 0.0, []
    for force_N in operator_N:
        command_m.append(x_m)
        for _ in range(steps):
            pull_N = pull(v_m_per_s, force_N) - damping_N_s_per_m * v_m_per_s - stiffness_N_per_m * x_m
            v_m_per_s += PERIOD_s / steps * pull_N / mass_kg
            x_m += PERIOD_s / steps * v_m_per_s
    command_m = np.array(command_m) + noise_m * np.random.default_rng(5).standard_normal(len(t_s))
    save(folder / "record.csv", None, t_s=t_s, operator_force_N=operator_N, command_position_m=command_m)


# An electronic oscillator, with voltages for force and position, sampled at no whole rate.
OSCILLATOR = """
name = "oscillator"
{rate}
[manipulator]
mass_kg = 5.4e-6
damping_N_s_per_m = 2e-4
stiffness_N_per_m = 0.95
[operator]
interface = "force"
[signals]
operator_force_N = "V1"
command_position_m = "V2"
"""


@recipe()
def oscillation(folder, rate=""):
    """At 610.35 Hz, the spring 1 N/m instead of 0.95; stamps with 4 digits, as loggers write them."""
    random = np.random.default_rng(7)
    force_N = random.normal(0, 0.1, 12000)
    plant = scipy.signal.cont2discrete(([1.0], [5.4e-6, 2e-4, 1.0]), 1 / 610.35)
    position_m = scipy.signal.lfilter(plant[0].ravel(), plant[1], force_N) + random.normal(0, 1e-4, len(force_N))
    table = np.column_stack((np.round(np.arange(len(force_N)) / 610.35, 4), force_N, position_m))
    np.savetxt(folder / "record.csv", table, delimiter=",", header="t_s,V1,V2", comments="", fmt=["%.4f", "%.9g", "%.9g"])
    (folder / "rig.toml").write_text(OSCILLATOR.format(rate=rate))


MOVED_RIG = """
name = "drive"
[loop]
rate_Hz = 500
[manipulator]
mass_kg = 2.0
damping_N_s_per_m = 5.0
stiffness_N_per_m = {stiffness}
[operator]
interface = "force"
"""


@recipe()
def drive_of_2_kg(folder, factor, stiffness):
    """`factor`: of the force in the record, as of a wrong sign or unit."""
    random = np.random.default_rng(5)
    force_N = scipy.signal.lfilter(*scipy.signal.butter(2, 0.02), random.normal(0, 200, 10000))
    plant = scipy.signal.cont2discrete(([1.0], [2.0, 5.0, stiffness]), 0.002)
    position_m = scipy.signal.lfilter(plant[0].ravel(), plant[1], force_N) + random.normal(0, 1e-6, len(force_N))
    save(folder / "record.csv", t_s=0.002 * np.arange(len(force_N)), operator_force_N=factor * force_N,
         command_position_m=position_m)
    (folder / "rig.toml").write_text(MOVED_RIG.format(stiffness=stiffness))
