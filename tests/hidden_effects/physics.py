"""The simulated truth: compiles the engine, runs the loop, replays single blocks. All units SI."""

import ctypes
import functools
import hashlib
import os
import pathlib
import subprocess
import tempfile
from dataclasses import dataclass

import numpy as np
from fields import DEFAULTS, FIELDS, c_struct
from scipy.linalg import expm

HERE = pathlib.Path(__file__).resolve().parent
BUILD = HERE.parents[1] / "build" / "hidden_effects"
# No fused multiply-add: the same seed gives the same bytes on any machine of an architecture.
FLAGS = ["-O2", "-std=c11", "-D_GNU_SOURCE", "-ffp-contract=off", "-fPIC", "-shared", "-Wall", "-Wextra", "-Werror"]


class Truth(ctypes.Structure):
    """struct truth."""

    _fields_ = [(name, ctypes.c_double) for name, _, _ in FIELDS]


class Unstable(Exception):
    """The loop has left every bound."""


def pointers(*names):
    return [(name, ctypes.c_void_p) for name in names]


class Inputs(ctypes.Structure):
    """struct inputs."""

    _fields_ = [
        ("ticks", ctypes.c_int64),
        *pointers("operator_N", "force_noise_N", "robot_noise_m", "command_noise_m"),
        *pointers("command_is_lost", "force_is_lost", "tick_is_lost", "command_m", "exact_step"),
        ("start_m", ctypes.c_double),
    ]


OUTPUTS = ["command_m", "robot_m", "force_N", "clean_robot_m", "clean_force_N", "object_m", "spring_N"]


class Outputs(ctypes.Structure):
    """struct outputs."""

    _fields_ = pointers(*OUTPUTS)


@functools.cache
def engine():
    """The compiled engine; built once per version of its source."""
    sources = sorted((HERE / "engine").glob("*.[ch]"))
    digest = hashlib.sha256("".join([*(s.read_text() for s in sources), c_struct(), *FLAGS]).encode()).hexdigest()
    library = BUILD / f"engine-{digest[:16]}.so"
    if not library.exists():
        BUILD.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=BUILD) as folder:
            folder = pathlib.Path(folder)
            (folder / "truth.h").write_text(c_struct())
            made = folder / "engine.so"
            files = [str(s) for s in sources if s.suffix == ".c"]
            compiler = os.environ.get("CC", "gcc")
            subprocess.run([compiler, *FLAGS, f"-I{folder}", *files, "-o", made, "-lm"], check=True)
            os.replace(made, library)  # several processes may build at once
    return ctypes.CDLL(str(library))


def truth(**values):
    """A full set of parameters: what is not given is switched off."""
    unknown = set(values) - set(DEFAULTS)
    assert not unknown, unknown
    return {**DEFAULTS, **values}


def exact_step(p):
    """Exact zero-order hold of the firmware's manipulator: rows x, v; columns x (m), v (m/s), net force (N)."""
    M, D, K = (p["manipulator_" + name] for name in ("mass_kg", "damping_N_s_per_m", "stiffness_N_per_m"))
    A = np.zeros((3, 3))
    A[0, 1] = 1.0
    A[1] = [-K / M, -D / M, 1.0 / M]
    return np.ascontiguousarray(expm(A * p["period_s"])[:2])


@dataclass
class Disturbance:
    """Everything random over a run, one value a tick, settling ticks included."""

    force_noise_N: np.ndarray
    robot_noise_m: np.ndarray
    command_noise_m: np.ndarray
    command_is_lost: np.ndarray
    force_is_lost: np.ndarray
    tick_is_lost: np.ndarray

    @classmethod
    def none(cls, ticks):
        """A run without noise and losses."""
        return cls(*np.zeros((3, ticks)), *np.zeros((3, ticks), np.uint8))


def address(array, kind):
    """The array in the engine's layout, and where it is."""
    array = np.ascontiguousarray(array, kind)
    return array, array.ctypes.data


def simulate(p, operator_N, disturbance=None, command_m=None, start_m=0.0):
    """Runs the loop; {name: array}, settling ticks included. With `command_m` the loop is open: given setpoints."""
    ticks = len(operator_N)
    disturbance = disturbance or Disturbance.none(ticks)
    keep = []

    def at(array, kind=np.float64):
        array, where = address(array, kind)
        assert array.size in (ticks, 6)
        keep.append(array)
        return where

    inputs = Inputs(
        ticks, at(operator_N), at(disturbance.force_noise_N), at(disturbance.robot_noise_m),
        at(disturbance.command_noise_m), at(disturbance.command_is_lost, np.uint8),
        at(disturbance.force_is_lost, np.uint8), at(disturbance.tick_is_lost, np.uint8),
        None if command_m is None else at(command_m), at(exact_step(p)), start_m,
    )
    result = {name: np.empty(ticks) for name in OUTPUTS}
    outputs = Outputs(*(result[name].ctypes.data for name in OUTPUTS))
    code = engine().run(ctypes.byref(Truth(**p)), ctypes.byref(inputs), ctypes.byref(outputs))
    if code == 2:
        raise Unstable
    assert code == 0
    return result


def replay_manipulator(p, net_N, start_m=0.0, start_m_per_s=0.0):
    """Positions in m of the manipulator alone under operator force minus measured force, N."""
    position_m = np.empty(len(net_N))
    net, net_at = address(net_N, np.float64)
    step, step_at = address(exact_step(p), np.float64)
    start, start_at = address([start_m, start_m_per_s], np.float64)
    engine().replay_manipulator(
        ctypes.byref(Truth(**p)), ctypes.c_int64(len(net)), ctypes.c_void_p(net_at), ctypes.c_void_p(step_at),
        ctypes.c_void_p(start_at), ctypes.c_void_p(position_m.ctypes.data),
    )
    return position_m
