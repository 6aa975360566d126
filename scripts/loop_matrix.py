"""One-period matrices of the loop from its definitions alone, many rigs at a time.

One tick, period T, tick n at t_n = n T:
  1. F_n is the newest force sample that has arrived by t_n; the sample of t_k + phase arrives T_S later.
  2. Setpoint x_n goes to the robot, which passes it at t_n + T_R, on a straight line or in a jump.
  3. M x'' + D x' + K x = -F_n, exactly, with F_n held for the tick.
State just before a tick: manipulator (x, v), hardware, setpoints that still matter and samples that have not been
used, newest first. Hardware: object (x_o, p), low-pass (y, q), both divided by k_S, and where there is one the
robot's (r, r'). p and q are chosen so that u' does not appear: p = v_o - d_S u / m, q = y' - w^2 d_S u / k_S. SI units.
"""

from dataclasses import dataclass, fields, replace

import numpy as np
from scipy.linalg import expm


@dataclass
class Loop:
    """A rig with low-pass of second order; values may be arrays, one entry a rig; dead times and rate may not."""

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
    phase: float = 0.0  # of the sample after the tick, s
    f_R: float = np.inf  # eigenfrequency of the robot's transfer behaviour, Hz; inf: none
    zeta_R: float = 0.7
    hold: bool = False

    @property
    def T(self):
        """Period, s."""
        return 1.0 / self.rate_Hz

    def arrays(self):
        """The same with every physical value as an array of one length."""
        names = [f.name for f in fields(self) if f.name not in ("rate_Hz", "T_R", "T_S", "phase", "hold", "f_R")]
        values = np.broadcast_arrays(*[np.atleast_1d(np.asarray(getattr(self, name), float)) for name in names])
        return replace(self, **dict(zip(names, values)))


def whole_and_rest(duration_s, period_s):
    """Whole periods in a duration, and the rest in s: exactly 0 if it is whole periods up to rounding."""
    whole = int(np.floor(duration_s / period_s + 1e-9))
    rest = duration_s - whole * period_s
    return whole, rest if rest > 1e-9 * period_s else 0.0


def plant(loop):
    """A, b of z' = A z + b u for arrays of rigs: A (n, s, s), b (n, s)."""
    n = len(loop.m)
    has_robot = np.isfinite(loop.f_R)
    s = 6 if has_robot else 4
    A, b = np.zeros((n, s, s)), np.zeros((n, s))
    d_S = 2.0 * loop.zeta_S * np.sqrt(loop.k_S * loop.m)
    w = 2.0 * np.pi * loop.f_L
    if has_robot:  # r and r' are states: p and q are v_o and y' / k_S themselves
        g = 2.0 * np.pi * loop.f_R
        A[:, 0, 1] = A[:, 2, 3] = A[:, 4, 5] = 1.0
        A[:, 5, 4], A[:, 5, 5], b[:, 5] = -g * g, -2.0 * loop.zeta_R * g, g * g
        force = np.zeros((n, s))
        force[:, 0], force[:, 1], force[:, 4], force[:, 5] = -loop.k_S, -d_S, loop.k_S, d_S
    else:
        A[:, 0, 1], b[:, 0] = 1.0, d_S / loop.m
        A[:, 2, 3], b[:, 2] = 1.0, w**2 * d_S / loop.k_S
        force = np.zeros((n, s))  # without d_S u'
        force[:, 0], force[:, 1] = -loop.k_S, -d_S
        b[:, 1] = (loop.k_S - d_S * d_S / loop.m) / loop.m - loop.d / loop.m * d_S / loop.m
        b[:, 3] = w**2 * (loop.k_S - d_S * d_S / loop.m) / loop.k_S
        b[:, 3] -= 2.0 * loop.zeta_L * w * w**2 * d_S / loop.k_S
    A[:, 1] += force / loop.m[:, None]
    A[:, 1, 0] -= loop.k / loop.m
    A[:, 1, 1] -= loop.d / loop.m
    A[:, 3] += w[:, None] ** 2 * force / loop.k_S[:, None]
    A[:, 3, 2] -= w**2
    A[:, 3, 3] -= 2.0 * loop.zeta_L * w
    return A, b


def augmented(A, b, duration_s):
    """Phi, g, h: z(t + duration) = Phi z + g u + h u', u' constant."""
    n, s, _ = A.shape
    G = np.zeros((n, s + 2, s + 2))
    G[:, :s, :s], G[:, :s, s], G[:, s, s + 1] = A, b, 1.0
    E = expm(G * duration_s)
    return E[:, :s, :s], E[:, :s, s], E[:, :s, s + 1]


def loop_matrices(loop):
    """The one-period maps, (n, size, size)."""
    loop = loop.arrays()
    T, n = loop.T, len(loop.m)
    A, b = plant(loop)
    s = A.shape[1]
    whole, knot = whole_and_rest(loop.T_R, T)
    age, late = whole_and_rest(loop.phase + loop.T_S, T)
    age += late > 0.0
    history = whole + (1 if knot > 0.0 or loop.hold else 0)
    size = 2 + s + history + age
    setpoint = [0] + [2 + s + i for i in range(history)]  # columns: x[n], x[n-1], ...

    state = np.zeros((n, s, size))  # hardware as a function of the state before the tick
    state[:, :, 2:2 + s] = np.eye(s)
    unit = np.eye(size)
    now = unit[setpoint[whole]]
    before = unit[setpoint[whole + 1]] if whole + 1 <= history else np.zeros(size)
    after = unit[setpoint[whole - 1]] if whole > 0 else np.zeros(size)
    sample = None
    instants = sorted({0.0, knot, loop.phase, T})
    for start, end in zip(instants[:-1], instants[1:]):
        if start == loop.phase:
            sample = state[:, 2].copy()
        Phi, g, h = augmented(A, b, end - start)
        if loop.hold:
            u, slope = (now if start >= knot else before), np.zeros(size)
        else:
            slope = ((after - now) if start >= knot else (now - before)) / T
            u = now + slope * (start - knot)
        state = Phi @ state + g[:, :, None] * u + h[:, :, None] * slope

    G = np.zeros((n, 3, 3))
    G[:, 0, 1] = 1.0
    G[:, 1, 0], G[:, 1, 1], G[:, 1, 2] = -loop.K / loop.M, -loop.D / loop.M, -loop.k_S / loop.M
    E = expm(G * T)
    force = np.broadcast_to(unit[2 + s + history + age - 1], (n, size)) if age > 0 else sample
    matrices = np.zeros((n, size, size))
    matrices[:, :2, :2] = E[:, :2, :2]
    matrices[:, :2] += E[:, :2, 2, None] * force[:, None, :]
    matrices[:, 2:2 + s] = state
    for i in range(history):
        matrices[:, 2 + s + i] += unit[setpoint[i]]
    if age > 0:
        matrices[:, 2 + s + history] = sample
        for i in range(1, age):
            matrices[:, 2 + s + history + i] = unit[2 + s + history + i - 1]
    return matrices


def coupled_rigs(loop, vary, frequency_ratio, damping_ratio):
    """The rigs at points of a map, k or m and d following from omega/omega_M and zeta; d is negative where no
    passive object is there."""
    w = frequency_ratio * np.sqrt(loop.K / loop.M)
    if vary == "elasticity":
        k, m = w**2 * (loop.M + loop.m) - loop.K, np.full_like(w, loop.m)
    else:
        k, m = np.full_like(w, loop.k), (loop.K + loop.k) / w**2 - loop.M
    d = 2.0 * damping_ratio * w * (loop.M + m) - loop.D
    return replace(loop, k=k, m=m, d=d)
