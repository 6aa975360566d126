"""The loop of a rig, solved by other people's programs: scipy's solve_ivp and jitcdde.

Both start at the release, from rest under tension, and see what berth's rig file says, with the frames on the bus,
their rounding and the supervisor left out.
"""

import collections
import time
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import curve_fit

SAMPLE_S = 0.02  # of the manipulator's position, for the growth fit: 50 points in a second-long oscillation


@dataclass
class Loop:
    """Parameters of the loop in SI units."""

    period: float  # T, s
    robot_delay: float  # T_R, s
    sensor_delay: float  # T_S, s
    mass: float  # M, kg
    damping: float  # D, N s/m
    stiffness: float  # K, N/m
    start: float  # m
    object_mass: float  # m, kg
    object_damping: float  # d, N s/m
    object_stiffness: float  # k, N/m
    spring: float  # k_S, N/m
    spring_damping: float  # d_S, N s/m
    filter_w: float  # rad/s
    filter_z: float

    @classmethod
    def of_rig(cls, rig):
        """From a resolved rig file, as a dictionary. Refuses what the equations here do not have."""
        manipulator, robot, sensor, target = (rig[name] for name in ("manipulator", "robot", "sensor", "object"))
        if robot["interpolation"] != "linear" or target["kind"] != "gripped" or sensor["low_pass_order"] != 2:
            raise ValueError(f"{rig['name']}: the peers need linear interpolation, a gripped object, order 2")
        spring, mass = sensor["stiffness_N_per_m"], target["mass_kg"]
        return cls(
            period=1.0 / rig["loop"]["rate_Hz"],
            robot_delay=robot["dead_time_ms"] * 1e-3,
            sensor_delay=sensor["delay_ms"] * 1e-3,
            mass=manipulator["mass_kg"],
            damping=manipulator["damping_N_s_per_m"],
            stiffness=manipulator["stiffness_N_per_m"],
            start=manipulator["initial_position_m"],
            object_mass=mass,
            object_damping=target["damping_N_s_per_m"],
            object_stiffness=target["stiffness_N_per_m"],
            spring=spring,
            spring_damping=2.0 * sensor["damping_ratio"] * (spring * mass) ** 0.5,
            filter_w=2.0 * np.pi * sensor["low_pass_frequency_Hz"],
            filter_z=sensor["low_pass_damping_ratio"],
        )

    def at_rest(self):
        """State (x, x', x_o, x_o', y, y') in m, m/s, N, N/s with the robot held at the start."""
        object_position = self.start * self.spring / (self.spring + self.object_stiffness)
        return [self.start, 0.0, object_position, 0.0, self.spring * (self.start - object_position), 0.0]

    def rates(self, state, robot_position, robot_velocity, fed_back_force):
        """Time derivative of the state; numbers or symbols."""
        x, v, object_x, object_v, y, y_rate = state
        force = self.spring * (robot_position - object_x) + self.spring_damping * (robot_velocity - object_v)
        return [
            v,
            (-self.damping * v - self.stiffness * x - fed_back_force) / self.mass,
            object_v,
            (force - self.object_damping * object_v - self.object_stiffness * object_x) / self.object_mass,
            y_rate,
            self.filter_w**2 * (force - y) - 2.0 * self.filter_z * self.filter_w * y_rate,
        ]


@dataclass
class Result:
    growth_per_s: float
    simulated_s: float
    wall_s: float


def growth_per_s(times_s, positions_m):
    """Growth rate of a single decaying or growing oscillation, from a least-squares fit after the first second."""

    def oscillation(t, growth, w, a, b, offset):
        return np.exp(growth * t) * (a * np.cos(w * t) + b * np.sin(w * t)) + offset

    tail = times_s >= 1.0
    t, x = times_s[tail], positions_m[tail] / np.abs(positions_m[tail]).max()
    crossings = np.count_nonzero(np.diff(np.sign(x)))
    guess = (-0.1, np.pi * crossings / (t[-1] - t[0]), 1.0, 0.0, 0.0)
    return float(curve_fit(oscillation, t, x, guess, maxfev=20000)[0][0])


def run_scipy(loop, duration_s, method="DOP853"):
    """Tick by tick as the loop is defined: setpoints queue for T_R and are joined by straight lines, the force that
    was sampled T_S ago is held over the tick. Both dead times must be whole ticks.
    """
    ticks_ahead, ticks_old = round(loop.robot_delay / loop.period), round(loop.sensor_delay / loop.period)
    if abs(ticks_ahead * loop.period - loop.robot_delay) + abs(ticks_old * loop.period - loop.sensor_delay) > 1e-12:
        raise ValueError("dead times must be whole ticks")
    state = loop.at_rest()
    setpoints = collections.deque([state[0]] * ticks_ahead)
    forces = collections.deque([state[4]] * ticks_old)
    tolerance = [1e-10, 1e-9, 1e-10, 1e-9, 1e-4, 1e-3]  # m, m/s, m, m/s, N, N/s
    positions = []
    begin = time.perf_counter()
    for _ in range(round(duration_s / loop.period)):
        positions.append(state[0])
        setpoints.append(state[0])
        forces.append(state[4])
        position, force = setpoints.popleft(), forces.popleft()
        velocity = (setpoints[0] - position) / loop.period

        def rates(t, s):
            return loop.rates(s, position + velocity * t, velocity, force)

        state = solve_ivp(rates, (0.0, loop.period), state, method=method, rtol=1e-6, atol=tolerance).y[:, -1]
    wall_s = time.perf_counter() - begin
    times = loop.period * np.arange(len(positions))
    return Result(growth_per_s(times, np.array(positions)), duration_s, wall_s)


class JitcddeLoop:
    """The loop as a delay-differential equation, compiled once, run as often as wanted.

    Continuous time has no ticks. Straight lines between setpoints follow x(t - T_R) to second order, and a force
    that is held for T is late by T/2 in the mean, so r(t) = x(t - T_R) and F(t) = y(t - T_S - T/2).
    """

    def __init__(self, loop):
        from jitcdde import jitcdde, t, y

        self._start = loop.at_rest()
        force_delay = loop.sensor_delay + 0.5 * loop.period
        robot = [y(i, t - loop.robot_delay) for i in range(2)]
        rates = loop.rates([y(i) for i in range(6)], *robot, y(4, t - force_delay))
        begin = time.perf_counter()
        self._equation = jitcdde(rates, delays=[0.0, force_delay, loop.robot_delay], verbose=False)
        self._equation.compile_C(simplify=False)
        self.compile_s = time.perf_counter() - begin

    def run(self, duration_s, relative_tolerance=1e-5):
        """One run; jitcdde's own tolerance is 1e-5. Its state is read only as often as the fit needs it."""
        equation = self._equation
        equation.set_integration_parameters(rtol=relative_tolerance)
        equation.purge_past()
        equation.constant_past(self._start, time=0.0)
        begin = time.perf_counter()
        equation.step_on_discontinuities()
        times = np.arange(equation.t, duration_s, SAMPLE_S)
        positions = np.array([equation.integrate(time_s)[0] for time_s in times])
        wall_s = time.perf_counter() - begin
        return Result(growth_per_s(times, positions), duration_s, wall_s)
