"""A diagnosis as one writes it with scipy: every effect of a list is fitted by least_squares to the error of its block,
from two starts, and BIC ranks them. It stops at the first effect: no held-out data, no second cause, no verdict.
"""

import math
from dataclasses import dataclass, field

import numpy as np
from diagnosis_peer_models import (STEPS, Parameters, feel_object, feel_object_by_solve_ivp, move_manipulator,
                                   move_robot, sample_force)
from scipy.optimize import least_squares

SETTLE_S = 0.5  # until what was before the record has died away
TOLERANCE = 0.05  # of the base model's parameters, as berth's where a rig file says nothing
WIDE = 30.0  # times its start, an effect's size may become
BIC_CLEAR, SHARE_CLEAR = 20.0, 0.3  # an effect is named from here on
BASE = {"manipulator": ("mass", "damping", "stiffness"), "robot": ("dead_time",),
        "force": ("object_mass", "object_damping", "object_stiffness", "spring", "spring_z", "filter_w", "filter_z",
                  "sensor_delay")}


def parameters_of(rig):
    """From a resolved rig file, as a dictionary."""
    manipulator, robot, sensor, target = (rig[name] for name in ("manipulator", "robot", "sensor", "object"))
    return Parameters(
        mass=manipulator["mass_kg"], damping=manipulator["damping_N_s_per_m"],
        stiffness=manipulator["stiffness_N_per_m"], dead_time=1e-3 * robot["dead_time_ms"],
        object_mass=target["mass_kg"], object_damping=target["damping_N_s_per_m"],
        object_stiffness=target["stiffness_N_per_m"], spring=sensor["stiffness_N_per_m"],
        spring_z=sensor["damping_ratio"], filter_w=2.0 * math.pi * sensor["low_pass_frequency_Hz"],
        filter_z=sensor["low_pass_damping_ratio"], sensor_delay=1e-3 * sensor["delay_ms"])


@dataclass
class Record:
    """Signals in SI units, one value a tick."""

    period: float  # s
    operator: np.ndarray
    command: np.ndarray
    robot: np.ndarray
    force: np.ndarray

    @classmethod
    def of_series(cls, path, period):
        """From the series.csv of `berth diagnose`: the record's rows as it has aligned them."""
        table = np.genfromtxt(path, delimiter=",", names=True)
        return cls(period, *(np.ascontiguousarray(table[name]) for name in
                             ("operator_position_m", "command_position_m", "robot_position_m", "force_N")))


def robot_effects(p, record, error):
    """Two starts for each effect: of the sizes that the record has."""
    period = record.period
    x = np.abs(record.command - record.command.mean()).max()
    speed = np.diff(record.command) / period
    v, a = np.abs(speed).max(), np.abs(np.diff(speed)).max() / period
    w = 2.0 * math.pi
    return {
        "robot.dead_time": [{"dead_time": p.dead_time - period}, {"dead_time": p.dead_time + period}],
        "robot.gain": [{"gain_error": 0.01}, {"gain_error": -0.01}],
        "robot.lag": [{"lag": period}, {"lag": 8.0 * period}],
        "robot.resonance": [{"resonance_w": 4.0 * w, "resonance_z": 0.5}, {"resonance_w": 16.0 * w,
                                                                          "resonance_z": 0.5}],
        "robot.backlash": [{"robot_backlash": 0.01 * x}, {"robot_backlash": 0.1 * x}],
        "robot.deadband": [{"deadband": 0.01 * x}, {"deadband": 0.1 * x}],
        "robot.velocity_limit": [{"velocity_limit": 0.9 * v}, {"velocity_limit": 0.5 * v}],
        "robot.acceleration_limit": [{"acceleration_limit": 0.9 * a}, {"acceleration_limit": 0.5 * a}],
        "robot.periodic_error": [{"periodic": error.std(), "pitch": 0.3 * x, "phase": 0.1},
                                 {"periodic": error.std(), "pitch": 0.03 * x, "phase": 0.1}],
    }


def force_effects(p, record, error):
    """The same for object and sensor."""
    period, f = record.period, np.abs(record.force).max()
    x, duration = f / p.object_stiffness, len(record.force) * record.period
    line = 1 + np.argmax(np.abs(np.fft.rfft(error))[1:])
    w = 2.0 * math.pi * line / (len(error) * period)
    own = {"object_mass": p.object_mass, "object_damping": p.object_damping, "object_stiffness": p.object_stiffness}

    def both(name, size):
        return [{name: size}, {name: -size}]

    return {
        "object.parameters": [{name: 1.1 * value for name, value in own.items()},
                              {name: 0.9 * value for name, value in own.items()}],
        "object.cubic_stiffness": both("cubic", 0.1 * p.object_stiffness / x**2),
        "object.quadratic_stiffness": both("quadratic", 0.1 * p.object_stiffness / x),
        "object.coulomb_friction": [{"coulomb": 0.01 * f}, {"coulomb": 0.1 * f}],
        "object.backlash": [{"object_backlash": 0.01 * x}, {"object_backlash": 0.1 * x}],
        "object.stiffness_drift": both("stiffness_drift", 0.1 / duration),
        "sensor.bias": both("bias", 0.02 * f),
        "sensor.drift": both("drift", 0.02 * f / duration),
        "sensor.gain": both("force_gain_error", 0.02),
        "sensor.lag": [{"sensor_lag": period}, {"sensor_lag": 8.0 * period}],
        "sensor.delay": [{"sensor_delay": 0.5 * period}, {"sensor_delay": 3.0 * period}],
        "sensor.saturation": [{"saturation": 0.9 * f}, {"saturation": 0.5 * f}],
        "sensor.periodic_disturbance": [{"hum": error.std(), "hum_w": w, "hum_phase": phase} for phase in (0.1, 1.6)],
    }


@dataclass
class Fit:
    """An effect (or none) fitted together with its block's base model."""

    effect: str
    p: Parameters
    values: dict
    rss: float
    bic: float
    simulations: int


@dataclass
class BlockResult:
    """Of one block: best BIC first."""

    base: Fit
    ranking: list = field(default_factory=list)

    @property
    def cause(self):
        """The effect that is named, or None."""
        if not self.ranking:
            return None
        best = self.ranking[0]
        is_clear = self.base.bic - best.bic > BIC_CLEAR and best.rss < (1.0 - SHARE_CLEAR) * self.base.rss
        return best if is_clear else None

    @property
    def simulations(self):
        """That all its fits took."""
        return self.base.simulations + sum(one.simulations for one in self.ranking)


class PeerDiagnosis:
    """Block by block, each driven by what was recorded at its input; the object by the robot as it was found."""

    def __init__(self, record, given):
        self._record = record
        self.p = given
        count = len(record.command)
        self._out = np.empty(count)
        self.path = np.empty(count * STEPS + 1)
        self.force = np.empty(count * STEPS + 1)
        self._operator_rate = np.gradient(record.operator, record.period)
        self._skip = round(SETTLE_S / record.period)

    def simulate(self, block, p):
        """What the block puts out, one value a tick."""
        record = self._record
        if block == "manipulator":
            rate = (record.command[1] - record.command[0]) / record.period
            move_manipulator(record.operator, self._operator_rate, record.force, p, record.period, record.command[0], rate, self._out)
        elif block == "robot":
            move_robot(record.command, p, record.period, self.path)
            return self.path[:-1:STEPS]
        else:
            feel_object(self.path, p, record.period, self.force)
            sample_force(self.force, p, record.period, self._out)
        return self._out

    def error(self, block, p):
        """Measured less simulated."""
        measured = {"manipulator": self._record.command, "robot": self._record.robot, "force": self._record.force}
        return (measured[block] - self.simulate(block, p))[self._skip:]

    def fit(self, block, effect, start):
        """By bounded least squares: the base within its tolerance, the effect's values by decades where they have
        one sign."""
        base = {name: getattr(self.p, name) for name in BASE[block] if name not in start}
        size = self.error(block, self.p).std()
        names = [*base, *start]
        centres = np.array([*base.values(), *start.values()])
        is_signed = np.array([value < 0.0 or name in ("gain_error", "force_gain_error", "bias", "drift", "cubic",
                                                      "quadratic", "stiffness_drift", "phase", "hum_phase")
                              for name, value in zip(names, centres)])
        reach = np.where(is_signed, WIDE, math.log(WIDE))
        reach[:len(base)] = TOLERANCE
        simulations = 0

        def with_values(places):
            values = np.where(is_signed, centres * places, centres * np.exp(places))
            values[:len(base)] = centres[:len(base)] * (1.0 + places[:len(base)])
            return self.p._replace(**dict(zip(names, map(float, values))))

        def residual(places):
            nonlocal simulations
            simulations += 1
            return self.error(block, with_values(places)) / size

        places = np.where(is_signed, 1.0, 0.0)
        with np.errstate(over="ignore"):  # of a step that diverges; least_squares takes it back
            found = least_squares(residual, places, bounds=(-reach, reach), x_scale=np.minimum(reach, 1.0),
                                  diff_step=1e-5, ftol=1e-6, xtol=1e-6, max_nfev=40)
        p, rows = with_values(found.x), len(found.fun)
        rss = 2.0 * found.cost * size**2
        return Fit(effect, p, {name: getattr(p, name) for name in start}, rss,
                   rows * math.log(rss / rows) + len(names) * math.log(rows), simulations)

    def diagnose_block(self, block):
        """Base, then every effect from both starts; goes on with the one that is named."""
        base = self.fit(block, "", {})
        self.p = base.p
        result = BlockResult(base)
        effects = {"manipulator": lambda *_: {}, "robot": robot_effects, "force": force_effects}[block]
        for effect, starts in effects(self.p, self._record, self.error(block, self.p)).items():
            fits = [self.fit(block, effect, start) for start in starts]
            best = min(fits, key=lambda fit: fit.rss)
            best.simulations = sum(fit.simulations for fit in fits)
            result.ranking.append(best)
        result.ranking.sort(key=lambda fit: fit.bic)
        self.p = (result.cause or base).p
        self.simulate(block, self.p)  # the robot's path for what follows
        return result

    def run(self):
        """Results by block."""
        return {block: self.diagnose_block(block) for block in ("manipulator", "robot", "force")}

    def force_by_solve_ivp(self):
        """The force before its samples, as simulate() has it in `force`, by solve_ivp."""
        return feel_object_by_solve_ivp(self.path, self.p, self._record.period)
