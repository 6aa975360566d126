"""The closed loop of the program against the independent one of reference_loop.py, sample by sample."""

import numpy as np
import pytest
from conftest import STATE_RUNNING, topic
from reference_loop import Loop, simulate
from scipy.integrate import solve_ivp

# Setpoints go in steps of 10 pm and forces in steps of 0.1 uN. What those add up to is some pm.
POSITION_TOLERANCE_m = 1e-10
FORCE_TOLERANCE_N = 1e-4

CASES = {
    "ess": ("ess", {}, Loop(400.0, 17.5e-3, 2.5e-3)),
    "ess-50hz": ("ess-50hz", {}, Loop(50.0, 40e-3, 20e-3)),
    "ess-half-dead-time": ("ess-half-dead-time", {}, Loop(400.0, 7.5e-3, 2.5e-3)),
    "dead time of no whole ticks": (
        "ess",
        {"robot.dead_time_ms": 13.3, "sensor.delay_ms": 4.1},
        Loop(400.0, 13.3e-3, 4.1e-3),
    ),
    "just one tick of dead time": (
        "ess",
        {"robot.dead_time_ms": 2.5, "sensor.delay_ms": 0.2},
        Loop(400.0, 2.5e-3, 0.2e-3),
    ),
    "hold": ("ess", {"robot.interpolation": "hold"}, Loop(400.0, 17.5e-3, 2.5e-3, hold=True)),
    "hold, dead time of no whole ticks": (
        "ess",
        {"robot.interpolation": "hold", "robot.dead_time_ms": 13.3, "sensor.delay_ms": 4.1},
        Loop(400.0, 13.3e-3, 4.1e-3, hold=True),
    ),
    "hold, less than a tick": (
        "ess",
        {"robot.interpolation": "hold", "robot.dead_time_ms": 0.9, "sensor.delay_ms": 2.5},
        Loop(400.0, 0.9e-3, 2.5e-3, hold=True),
    ),
    "50 Hz, dead time of no whole ticks": (
        "ess-50hz",
        {"robot.dead_time_ms": 33.3, "sensor.delay_ms": 7.7},
        Loop(50.0, 33.3e-3, 7.7e-3),
    ),
    "unstable": (
        "ess",
        {"object.stiffness_N_per_m": 23687.0, "run.duration_s": 6.0},
        Loop(400.0, 17.5e-3, 2.5e-3, k=23687.0),
    ),
    "other numbers": (
        "ess",
        {
            "manipulator.mass_kg": 150.0,
            "manipulator.damping_N_s_per_m": 300.0,
            "manipulator.stiffness_N_per_m": 5000.0,
            "object.mass_kg": 40.0,
            "object.stiffness_N_per_m": 3000.0,
            "object.damping_N_s_per_m": 50.0,
            "sensor.stiffness_N_per_m": 1e6,
            "sensor.damping_ratio": 0.2,
            "sensor.low_pass_frequency_Hz": 35.0,
            "sensor.low_pass_damping_ratio": 0.5,
            "robot.dead_time_ms": 6.1,
        },
        Loop(400.0, 6.1e-3, 2.5e-3, 150.0, 5000.0, 300.0, 40.0, 3000.0, 50.0, 1e6, 0.2, 35.0, 0.5),
    ),
}


def first_running_tick(tick):
    """The tick at which the supervisor let the manipulator go, and no interruption after it."""
    running = tick["state"] == STATE_RUNNING
    first = int(np.argmax(running))
    assert running[first:].all()
    return first


@pytest.mark.long
@pytest.mark.parametrize("solver", ["fast", "cvode"])
@pytest.mark.parametrize("case", CASES)
def test_every_sample_agrees_with_the_independent_loop(case, solver, logs):
    rig, overrides, loop = CASES[case]
    _, log = logs(rig, overrides if solver == "fast" else {**overrides, "solver.kind": solver})
    tick = topic(log)
    assert not tick["limits"].any()
    first = first_running_tick(tick)
    # The request to run is sent at 0.1 s, and is on the bus for less than a tick.
    assert first == round(0.1 * loop.rate_Hz) + 1
    x, force = simulate(loop, len(tick["index"]), first, x_start=0.01)

    position_error_m = np.abs(tick["manipulator_position_m"] - x)
    force_error_N = np.abs(tick["force_N"] - force)
    print(f"{case}, {solver}: |x| up to {np.abs(x).max():.4g} m, error up to {position_error_m.max():.2e} m; "
          f"|F| up to {np.abs(force).max():.4g} N, error up to {force_error_N.max():.2e} N")
    assert np.abs(x[first + len(x) // 100 :]).max() > 1e-3, "nothing moves: the comparison would say nothing"
    assert position_error_m.max() < POSITION_TOLERANCE_m
    assert force_error_N.max() < FORCE_TOLERANCE_N


def test_the_comparison_notices_a_dead_time_that_is_10_us_off(logs):
    _, log = logs("ess", {})
    tick = topic(log)
    x, _ = simulate(Loop(400.0, 17.51e-3, 2.5e-3), len(tick["index"]), first_running_tick(tick), x_start=0.01)
    assert np.abs(tick["manipulator_position_m"] - x).max() > 100 * POSITION_TOLERANCE_m


@pytest.mark.parametrize("robot_at", [lambda t: 0.01 + 0.02 * t, lambda t: 0.013])
def test_the_independent_loops_plant_agrees_with_a_solver_of_differential_equations(robot_at):
    """One tick of a line, and of a jump from 0.01 m to 0.013 m, by DOP853 with the velocity spelled out."""
    loop = Loop(400.0, 17.5e-3, 2.5e-3)
    d_S = 2.0 * loop.zeta_S * np.sqrt(loop.k_S * loop.m)
    w = 2.0 * np.pi * loop.f_L
    start, slope = robot_at(0.0), robot_at(1.0) - robot_at(0.0)
    jump = start - 0.01

    def rate(t, s):
        x, v, y, y_rate = s
        F = loop.k_S * (start + slope * t - x) + d_S * (slope - v)
        return [v, (F - loop.k * x - loop.d * v) / loop.m, y_rate, w**2 * (F - y) - 2 * loop.zeta_L * w * y_rate]

    x_o = loop.k_S * 0.01 / (loop.k_S + loop.k)
    at_rest = [x_o, d_S * jump / loop.m, loop.k * x_o, w**2 * d_S * jump]
    x, v, y, _ = solve_ivp(rate, (0.0, loop.T), at_rest, "DOP853", rtol=1e-12, atol=1e-14).y[:, -1]
    z = loop.advance(loop.at_rest(0.01), start, start + slope * loop.T, loop.T, loop.T)
    assert z[0] == pytest.approx(x, rel=1e-11)
    assert z[1] + d_S / loop.m * (start + slope * loop.T) == pytest.approx(v, rel=1e-8, abs=1e-12)
    assert loop.k_S * z[2] == pytest.approx(y, rel=1e-8)


# Largest eigenvalue of the one-period map, by an independent program: growth in 1/s.
GROWTH_PER_S = {"ess": -0.298369, "ess-50hz": -0.288895, "ess-half-dead-time": -0.280819}


@pytest.mark.parametrize("rig", GROWTH_PER_S)
def test_growth_rate_is_the_predicted_one_within_1_percent(rig, logs):
    result, _ = logs(rig)
    print(f"{rig}: {result['growth_per_s']:.6f} /s, predicted {GROWTH_PER_S[rig]:.6f} /s")
    assert result["growth_per_s"] == pytest.approx(GROWTH_PER_S[rig], rel=0.01)
    assert result["stable"] is True


def test_an_object_beyond_the_stable_range_is_called_diverging(logs):
    result, _ = logs(*CASES["unstable"][:2])
    print(f"grows by {result['growth_per_s']:.4f} /s")
    assert result["stable"] is False
    assert result["growth_per_s"] > 0.0
