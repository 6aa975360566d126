"""The closed loop from its definitions alone: an independent program to compare logs of `berth run` with.

One tick, period T, tick n at t_n = n T:
  1. F_n is the newest force sample that has arrived by t_n; the sample of t_k arrives at t_k + T_S.
  2. Setpoint x_n goes to the robot, which passes it at t_n + T_R, on a straight line or in a jump.
  3. M x'' + D (x' - v_op) + K (x - x_op) = F_op - F, exactly, with everything on the right held for the tick.
Sensor spring, object and low-pass are linear. The damper of the sensor spring feels u', the velocity of the robot;
the state is chosen so that u' does not appear (p = v_o - d_S u / m, q = y' - w^2 d_S u), so that lines and jumps of
u need the same equations. Time is in s, lengths in m; the force y is kept as the length y / k_S, which scales the
matrices.
"""

from dataclasses import dataclass, field

import numpy as np
from scipy.linalg import expm


@dataclass
class Loop:
    """The rig's parameters in SI units; names as in the definitions."""

    rate_Hz: float
    T_R: float
    T_S: float
    M: float = 200.0
    K: float = 7895.6835208714865
    D: float = 125.66370614359172
    m: float = 100.0
    k: float = 2368.705056261446
    d: float = 19.46773764467334
    k_S: float = 2e7
    zeta_S: float = 0.05
    f_L: float = 20.0
    zeta_L: float = 0.7
    hold: bool = False
    steps: dict = field(default_factory=dict)

    @property
    def T(self):
        """Period, s."""
        return 1.0 / self.rate_Hz

    def plant(self):
        """A, b of z' = A z + b u with z = (x_o, p, y/k_S, q/k_S)."""
        m, k, d, k_S = self.m, self.k, self.d, self.k_S
        d_S = 2.0 * self.zeta_S * np.sqrt(k_S * m)
        w = 2.0 * np.pi * self.f_L
        v = np.array([0.0, 1.0, 0.0, 0.0]), d_S / m  # v_o = p + d_S/m u
        y_rate = np.array([0.0, 0.0, 0.0, 1.0]), w**2 * d_S / k_S
        x = np.eye(4)[0]
        y = np.eye(4)[2]
        spring = -k_S * x - d_S * v[0], k_S - d_S * v[1]  # F without d_S u'
        rows = [
            v,
            ((spring[0] - k * x - d * v[0]) / m, (spring[1] - d * v[1]) / m),
            y_rate,
            (
                w**2 * (spring[0] / k_S - y) - 2.0 * self.zeta_L * w * y_rate[0],
                w**2 * spring[1] / k_S - 2.0 * self.zeta_L * w * y_rate[1],
            ),
        ]
        return np.array([row[0] for row in rows]), np.array([row[1] for row in rows])

    def step_matrices(self, duration_s):
        """Phi, g, h: z(t + duration) = Phi z + g u + h u', u' constant."""
        if duration_s not in self.steps:
            A, b = self.plant()
            n = len(b)
            G = np.zeros((n + 2, n + 2))
            G[:n, :n], G[:n, n], G[n, n + 1] = A, b, 1.0
            E = expm(G * duration_s)
            self.steps[duration_s] = E[:n, :n], E[:n, n], E[:n, n + 1]
        return self.steps[duration_s]

    def advance(self, z, u_from, u_to, duration_s, line_s):
        """z one segment further, u on the straight line that goes from u_from to u_to within line_s."""
        if duration_s <= 0.0:
            return z
        Phi, g, h = self.step_matrices(duration_s)
        return Phi @ z + g * u_from + h * (u_to - u_from) / line_s

    def at_rest(self, u):
        """The plant's state with the robot resting at u."""
        A, b = self.plant()
        return np.linalg.solve(A, -b * u)

    def manipulator(self):
        """a, b of (x, v)(n+1) = a (x, v)(n) + b (x_op, v_op, F_op - F)."""
        G = np.zeros((5, 5))
        G[0, 1] = 1.0
        G[1] = [-self.K / self.M, -self.D / self.M, self.K / self.M, self.D / self.M, 1.0 / self.M]
        E = expm(G * self.T)
        return E[:2, :2], E[:2, 2:]


def dead_ticks(dead_time_s, period_s):
    """Whole periods in a dead time, and the rest in s: none if it is a whole number of periods up to rounding."""
    whole = int(np.floor(dead_time_s / period_s + 1e-9))
    return whole, max(0.0, dead_time_s - whole * period_s) if dead_time_s / period_s - whole > 1e-9 else 0.0


def simulate(loop, ticks, first_running_tick, x_start, v_start=0.0, operator=None):
    """Manipulator position in m and force F_n in N at each tick.

    `operator`: rows (x_op in m, v_op in m/s, F_op in N), one a tick; at rest at 0 if absent. Before its first
    running tick the manipulator is held.
    """
    T = loop.T
    robot_ticks, robot_rest_s = dead_ticks(loop.T_R, T)
    sensor_ticks, sensor_rest_s = dead_ticks(loop.T_S, T)
    if sensor_rest_s > 0.0:
        sensor_ticks += 1  # a sample that arrives between two ticks counts for the later one
    operator = np.zeros((ticks, 3)) if operator is None else operator
    a, b = loop.manipulator()
    z = loop.at_rest(x_start)
    state = np.array([x_start, v_start])
    x = np.empty(ticks)
    force = np.empty(ticks)
    sample = np.empty(ticks)

    def setpoint(n):
        return x[n] if n >= 0 else x_start

    for n in range(ticks):
        x[n] = state[0]
        sample[n] = loop.k_S * z[2]
        force[n] = sample[n - sensor_ticks] if n >= sensor_ticks else 0.0
        if n >= first_running_tick:
            state = a @ state + b @ (operator[n] - [0.0, 0.0, force[n]])
        # Between t_n and t_n + rest the robot comes from two setpoints back, then it is on the way to the next.
        before, now = setpoint(n - robot_ticks - 1), setpoint(n - robot_ticks)
        if loop.hold:
            z = loop.advance(z, before, before, robot_rest_s, T)
            z = loop.advance(z, now, now, T - robot_rest_s, T)
        else:
            after = setpoint(n - robot_ticks + 1)
            here = now - (now - before) * robot_rest_s / T
            z = loop.advance(z, here, here + (now - before), robot_rest_s, T)
            z = loop.advance(z, now, after, T - robot_rest_s, T)
    return x, force
