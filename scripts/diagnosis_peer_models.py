"""The blocks of a rig with effects, as one writes them with numba and scipy: fixed steps, compiled; and the object
with solve_ivp. Nothing of berth's solver is in here.

Everything is in SI units; `p` are Parameters, all floats.
"""

import math
from collections import namedtuple

import numpy as np
from numba import njit
from scipy.integrate import solve_ivp

STEPS = 4  # a tick: of the robot's reference, and of Runge and Kutta's method for the object (75 Hz on its sensor)
NO_LIMIT = 1e9

# Parameters with what they are where an effect is not there; the base model's come from the rig file. numba compiles
# named tuples.
EFFECTS = {
    "gain_error": 0.0, "lag": 0.0, "resonance_w": 0.0, "resonance_z": 0.5, "robot_backlash": 0.0, "deadband": 0.0,
    "velocity_limit": NO_LIMIT, "acceleration_limit": NO_LIMIT, "periodic": 0.0, "pitch": 1.0, "phase": 0.0,
    "cubic": 0.0, "quadratic": 0.0, "coulomb": 0.0, "object_backlash": 0.0, "stiffness_drift": 0.0,
    "bias": 0.0, "drift": 0.0, "force_gain_error": 0.0, "sensor_lag": 0.0, "saturation": NO_LIMIT,
    "hum": 0.0, "hum_w": 1.0, "hum_phase": 0.0,
}
BASE = ("mass", "damping", "stiffness", "dead_time", "object_mass", "object_damping", "object_stiffness", "spring",
        "spring_z", "filter_w", "filter_z", "sensor_delay")
Parameters = namedtuple("Parameters", (*BASE, *EFFECTS), defaults=EFFECTS.values())
SLIDES = 1e-4  # m/s: dry friction as a smooth function of the velocity


@njit
def move_manipulator(operator, operator_rate, force, p, period, start, rate, out):
    """Operator's motion and force, held over a tick, to the command; one step of Runge and Kutta's method a tick."""
    x, v = start, rate
    for n in range(len(operator)):
        out[n] = x
        push = p.stiffness * operator[n] + p.damping * operator_rate[n] - force[n]
        a1 = (push - p.stiffness * x - p.damping * v) / p.mass
        x2, v2 = x + 0.5 * period * v, v + 0.5 * period * a1
        a2 = (push - p.stiffness * x2 - p.damping * v2) / p.mass
        x3, v3 = x + 0.5 * period * v2, v + 0.5 * period * a2
        a3 = (push - p.stiffness * x3 - p.damping * v3) / p.mass
        x4, v4 = x + period * v3, v + period * a3
        a4 = (push - p.stiffness * x4 - p.damping * v4) / p.mass
        x += period / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4)
        v += period / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)


@njit
def move_robot(command, p, period, out):
    """Commands to the robot's position at the ends of steps: out[0] at the first tick, STEPS more for each."""
    count = len(command)
    taken = np.empty(count)
    held, position, velocity = command[0], command[0], 0.0
    speed, ramp = p.velocity_limit, p.acceleration_limit
    for n in range(count):
        if abs(command[n] - held) > p.deadband or p.deadband == 0.0:
            held = command[n]
        wanted = (held - position) / period
        wanted = min(max(wanted, -speed), speed)
        if ramp < NO_LIMIT:
            stop = math.sqrt(2.0 * ramp * abs(held - position))  # from which it can still stop in time
            wanted = min(max(wanted, -stop), stop)
            wanted = min(max(wanted, velocity - ramp * period), velocity + ramp * period)
        velocity = wanted
        position += wanted * period
        taken[n] = position
    h = period / STEPS
    late = p.dead_time / period
    keep = math.exp(-h / p.lag) if p.lag > 0.0 else 0.0
    w, z = min(p.resonance_w, 1.0 / h), p.resonance_z  # beyond it the step would be too long
    x = y = lagged = (1.0 + p.gain_error) * command[0]
    rate = 0.0
    half = 0.5 * p.robot_backlash
    for i in range(count * STEPS + 1):
        at = min(max(i / STEPS - late, 0.0), count - 1.0)
        before = min(int(at), count - 2)
        u = (1.0 + p.gain_error) * (taken[before] + (at - before) * (taken[before + 1] - taken[before]))
        if w > 0.0:  # the middle of the step counts: Stoermer and Verlet's method
            rate += h * (w * w * (u - x) - 2.0 * z * w * rate)
            x += h * rate
        else:
            x = u
        lagged = x + (lagged - x) * keep
        y = min(max(y, lagged - half), lagged + half)
        out[i] = y + p.periodic * math.sin(2.0 * math.pi * y / p.pitch + p.phase)


@njit
def object_rates(x, v, y, s, r, r_rate, t, p):
    """Time derivatives of the object's velocity and of the low-pass's rate, with the robot at `r`."""
    force = p.spring * (r - x) + 2.0 * p.spring_z * math.sqrt(p.spring * p.object_mass) * (r_rate - v)
    half = 0.5 * p.object_backlash
    bent = x - min(max(x, -half), half)
    resists = ((1.0 + p.stiffness_drift * t) * p.object_stiffness * bent + p.object_damping * v
               + p.cubic * x * x * x + p.quadratic * x * x)
    if p.coulomb != 0.0:
        resists += p.coulomb * math.tanh(v / SLIDES)
    w = p.filter_w
    return (force - resists) / p.object_mass, w * w * (force - y) - 2.0 * p.filter_z * w * s


@njit
def at_rest(r, p):
    """Object's position and force with the robot held at `r`."""
    x = r * p.spring / (p.spring + p.object_stiffness)
    return x, p.spring * (r - x)


@njit
def feel_object(robot, p, period, force):
    """The robot's position at the ends of steps to the filtered force there."""
    h = period / STEPS
    x, y = at_rest(robot[0], p)
    v = s = 0.0
    force[0] = y
    for i in range(len(robot) - 1):
        r, rate, t = robot[i], (robot[i + 1] - robot[i]) / h, i * h
        a1, b1 = object_rates(x, v, y, s, r, rate, t, p)
        x2, v2, y2, s2 = x + 0.5 * h * v, v + 0.5 * h * a1, y + 0.5 * h * s, s + 0.5 * h * b1
        a2, b2 = object_rates(x2, v2, y2, s2, r + 0.5 * h * rate, rate, t, p)
        x3, v3, y3, s3 = x + 0.5 * h * v2, v + 0.5 * h * a2, y + 0.5 * h * s2, s + 0.5 * h * b2
        a3, b3 = object_rates(x3, v3, y3, s3, r + 0.5 * h * rate, rate, t, p)
        x4, v4, y4, s4 = x + h * v3, v + h * a3, y + h * s3, s + h * b3
        a4, b4 = object_rates(x4, v4, y4, s4, r + h * rate, rate, t, p)
        x += h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4)
        v += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
        y += h / 6.0 * (s + 2.0 * s2 + 2.0 * s3 + s4)
        s += h / 6.0 * (b1 + 2.0 * b2 + 2.0 * b3 + b4)
        force[i + 1] = y


@njit
def sample_force(force, p, period, out):
    """The filtered force at the ends of steps to the samples of each tick."""
    h = period / STEPS
    keep = math.exp(-h / p.sensor_lag) if p.sensor_lag > 0.0 else 0.0
    lagged = force[0]
    for i in range(len(force)):
        lagged = force[i] + (lagged - force[i]) * keep
        force[i] = lagged
    for n in range(len(out)):
        t = n * period - p.sensor_delay
        at = min(max(t / h, 0.0), len(force) - 1.0)
        before = min(int(at), len(force) - 2)
        y = force[before] + (at - before) * (force[before + 1] - force[before])
        y = (1.0 + p.force_gain_error) * y + p.bias + p.drift * t + p.hum * math.sin(p.hum_w * t + p.hum_phase)
        out[n] = min(max(y, -p.saturation), p.saturation)


def feel_object_by_solve_ivp(robot, p, period):
    """feel_object() by LSODA, scipy's fastest here, as it comes: the right-hand side is compiled, its steps are not."""
    h = period / STEPS
    times = h * np.arange(len(robot))

    def rates(t, state):
        x, v, y, s = state
        i = min(int(t / h), len(robot) - 2)
        rate = (robot[i + 1] - robot[i]) / h
        a, b = object_rates(x, v, y, s, robot[i] + rate * (t - times[i]), rate, t, p)
        return v, a, s, b

    x, y = at_rest(robot[0], p)
    return solve_ivp(rates, (0.0, times[-1]), [x, 0.0, y, 0.0], method="LSODA", t_eval=times, max_step=period,
                     rtol=1e-6, atol=[1e-10, 1e-8, 1e-3, 1e-1]).y[2]
