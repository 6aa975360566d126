"""The characteristic equation of the loop to 50 digits, from its definitions alone.

Everything that happens goes as z^n over the ticks n. With setpoints x_n = z^n the plant's state at the ticks, the force
and the manipulator's answer follow; an eigenvalue is a z whose answer is the setpoint it began with.
"""

from dataclasses import dataclass

import mpmath
import numpy as np
from mpmath import mp, mpf

mp.dps = 50


@dataclass
class Parameters:
    """The rig's numbers in SI units, dead times in ns; low-pass of order 2, straight lines between setpoints."""

    rate_Hz: int
    T_R_ns: int
    sample_ticks: int
    M: float
    K: float
    D: float
    m: float
    k: float
    d: float
    k_S: float
    zeta_S: float
    f_L: float
    zeta_L: float
    m_2: float = 0.0  # hangs on the object; 0: none
    f_2: float = 0.0
    zeta_2: float = 0.0
    m_T: float = 0.0  # of the tool behind the sensor
    k_R: float = 0.0  # of what relaxes; 0: nothing
    tau_R_ms: float = 0.0

    def settings(self):
        """The same as keys of a rig file."""
        second = {
            "object.second_mass_kg": repr(self.m_2),
            "object.second_frequency_Hz": repr(self.f_2),
            "object.second_damping_ratio": repr(self.zeta_2),
        }
        relaxing = {
            "object.relaxation_stiffness_N_per_m": repr(self.k_R),
            "object.relaxation_time_ms": repr(self.tau_R_ms),
        }
        return {
            **(second if self.m_2 else {}),
            **(relaxing if self.k_R else {}),
            **({"sensor.tool_mass_kg": repr(self.m_T)} if self.m_T else {}),
            "loop.rate_Hz": self.rate_Hz,
            "robot.dead_time_ms": repr(self.T_R_ns / 1e6),
            "sensor.delay_ms": repr(1e3 * self.sample_ticks / self.rate_Hz),
            "manipulator.mass_kg": repr(self.M),
            "manipulator.stiffness_N_per_m": repr(self.K),
            "manipulator.damping_N_s_per_m": repr(self.D),
            "object.mass_kg": repr(self.m),
            "object.stiffness_N_per_m": repr(self.k),
            "object.damping_N_s_per_m": repr(self.d),
            "sensor.stiffness_N_per_m": repr(self.k_S),
            "sensor.damping_ratio": repr(self.zeta_S),
            "sensor.low_pass_frequency_Hz": repr(self.f_L),
            "sensor.low_pass_damping_ratio": repr(self.zeta_L),
        }


class CharacteristicEquation:
    """f(z) = 0 for every eigenvalue z but 0."""

    def __init__(self, parameters):
        p = parameters
        self.p = p
        self.states = 4 + (2 if p.m_2 else 0) + (1 if p.k_R else 0)
        T = mpf(1) / p.rate_Hz
        self.whole = p.T_R_ns * p.rate_Hz // 10**9
        rest = mpf(p.T_R_ns) / 10**9 - self.whole * T
        self.first = self.part(rest)
        self.second = self.part(T - rest)
        self.rest, self.T = rest, T
        self.Phi = self.second[0] * self.first[0]
        # Where the robot's velocity jumps by 1 m/s, the tool gives the low-pass an impulse.
        jump = mpmath.zeros(self.states, 1)
        jump[3] = (2 * mp.pi * mpf(p.f_L)) ** 2 * mpf(p.m_T) / mpf(p.k_S)
        self.jump = self.second[0] * jump
        G = mpmath.zeros(3)
        G[0, 1] = 1
        G[1, 0], G[1, 1], G[1, 2] = -mpf(p.K) / p.M, -mpf(p.D) / p.M, -1 / mpf(p.M)
        E = mpmath.expm(G * T)
        self.A, self.b = E[:2, :2], E[:2, 2]

    def part(self, duration_s):
        """Phi, g, h: state, robot at the start (m) and its velocity (m/s) to the state after `duration_s`."""
        p = self.p
        m, k, d, k_S = mpf(p.m), mpf(p.k), mpf(p.d), mpf(p.k_S)
        d_S = 2 * mpf(p.zeta_S) * mpmath.sqrt(k_S * m)
        w = 2 * mp.pi * mpf(p.f_L)
        # State x_o, v_o, y/k_S, y'/k_S, x_2, v_2 if there is a second mass; then u and u'.
        n = self.states
        G = mpmath.zeros(n + 2)
        G[0, 1] = 1
        force = mpmath.zeros(1, n + 2)  # F/k_S
        force[0], force[1], force[n], force[n + 1] = -1, -d_S / k_S, 1, d_S / k_S
        G[1, :] = force * (k_S / m)
        G[1, 0] -= k / m
        G[1, 1] -= d / m
        G[2, 3] = 1
        G[3, :] = force * w**2
        G[3, 2] -= w**2
        G[3, 3] -= 2 * mpf(p.zeta_L) * w
        if p.m_2:
            w_2 = 2 * mp.pi * mpf(p.f_2)
            pull = mpmath.zeros(1, n + 2)  # of the second mass on the object, per kg of it
            pull[4], pull[5] = w_2**2, 2 * mpf(p.zeta_2) * w_2
            pull[0], pull[1] = -pull[4], -pull[5]
            G[1, :] += pull * (mpf(p.m_2) / m)
            G[4, 5] = 1
            G[5, :] = -pull
        if p.k_R:
            rate = 1000 / mpf(p.tau_R_ms)
            own = n - 1  # how far the spring of what relaxes is stretched
            G[1, own] -= mpf(p.k_R) / m
            G[own, 1] = 1
            G[own, own] = -rate
        G[n, n + 1] = 1
        E = mpmath.expm(G * duration_s) if duration_s > 0 else mpmath.eye(n + 2)
        return E[:n, :n], E[:n, n], E[:n, n + 1]

    def __call__(self, z):
        z = mpmath.mpmathify(z)
        before, now, after = (z ** -(self.whole + i) for i in (1, 0, -1))
        velocity = (now - before) / self.T
        Phi1, g1, h1 = self.first
        Phi2, g2, h2 = self.second
        driven = Phi2 * (g1 * (now - velocity * self.rest) + h1 * velocity) + g2 * now + h2 * ((after - now) / self.T)
        driven += self.jump * ((after - now) / self.T - velocity)
        plant = mpmath.lu_solve(z * mpmath.eye(self.states) - self.Phi, driven)
        force = mpf(self.p.k_S) * plant[2] * z**-self.p.sample_ticks
        answer = mpmath.lu_solve(z * mpmath.eye(2) - self.A, self.b * force)
        return answer[0] - 1

    def eigenvalues(self):
        """All eigenvalues of the one-period map in double precision, put together block by block."""

        def double(block):
            return np.array(block.tolist(), dtype=float)

        whole, ticks = self.whole, self.p.sample_ticks
        T, r = float(self.T), float(self.rest)
        Phi1, g1, h1 = (double(block) for block in self.first)
        Phi2, g2, h2 = (double(block) for block in self.second)
        now = Phi2 @ (g1 * (1 - r / T) + h1 / T) + g2 - h2 / T
        before = Phi2 @ (g1 * (r / T) - h1 / T)
        after = h2 / T
        jump = double(self.jump) / T
        now, before, after = now - 2 * jump, before + jump, after + jump
        # x, v of the manipulator; plant; setpoints sent, newest first; samples taken, newest first.
        plant, sent, samples = 2, 2 + self.states, 2 + self.states + whole + 1
        matrix = np.zeros((samples + ticks, samples + ticks))
        matrix[0:2, 0:2] = double(self.A)
        matrix[0:2, [samples + ticks - 1]] = double(self.b) * self.p.k_S
        matrix[plant:sent, plant:sent] = double(self.Phi)

        def column_of(setpoint):
            return 0 if setpoint == 0 else sent + setpoint - 1

        for age, column in ((whole - 1, after), (whole, now), (whole + 1, before)):
            matrix[plant:sent, [column_of(age)]] += column
        for i in range(whole + 1):
            matrix[sent + i, column_of(i)] = 1.0
        matrix[samples, plant + 2] = 1.0  # the sample at this tick
        for i in range(1, ticks):
            matrix[samples + i, samples + i - 1] = 1.0
        return np.linalg.eigvals(matrix)

    def spectral_radius(self, candidates=4):
        """Largest |z|: the largest in double precision, then each of them to 50 digits."""
        rough = sorted((z for z in self.eigenvalues() if z.imag >= 0), key=abs, reverse=True)[:candidates]
        return max(abs(mpmath.findroot(self, mpmath.mpmathify(z), solver="secant", tol=1e-40)) for z in rough)
