"""The generator of hidden effects: its physics against closed forms."""

import sys

import numpy as np
import pytest
from conftest import ROOT
from reference_loop import Loop
from reference_loop import simulate as reference_simulate
from scipy.signal import lsim

FOLDER = ROOT / "tests" / "hidden_effects"
sys.path.insert(0, str(FOLDER))
from physics import Disturbance, replay_manipulator, simulate, truth  # noqa: E402

T = 0.0025
EXACT = {"sensor_step_N": 0.0, "command_step_m": 0.0}


def hardware(command_m, disturbance=None, **fields):
    """The hardware alone, following given setpoints."""
    p = truth(**{**EXACT, "robot_dead_time_s": 2 * T, "sensor_delay_s": T, **fields})
    return simulate(p, np.zeros(len(command_m)), disturbance, command_m)


def slow_sine(amplitude_m, period_s, cycles):
    """Setpoints of a sine from rest, and the slice of its last cycle."""
    ticks = int(round(cycles * period_s / T))
    last = slice(ticks - int(round(period_s / T)), ticks)
    return amplitude_m * np.sin(2 * np.pi * np.arange(ticks) * T / period_s), last


def loop_area(force, position):
    """Work over a closed cycle, J."""
    closed_F, closed_x = np.append(force, force[0]), np.append(position, position[0])
    return float(np.sum(0.5 * (closed_F[1:] + closed_F[:-1]) * np.diff(closed_x)))


# --- the loop without effects -----------------------------------------------------------------------------------


@pytest.mark.parametrize("dead_time_s, delay_s", [(0.0175, 0.0025), (0.0183, 0.005)])
def test_closed_loop_is_that_of_the_reference_program(dead_time_s, delay_s):
    loop = Loop(400, dead_time_s, delay_s)
    x, force = reference_simulate(loop, 8000, 0, 0.01)
    p = truth(**EXACT, manipulator_mass_kg=loop.M, manipulator_stiffness_N_per_m=loop.K,
              manipulator_damping_N_s_per_m=loop.D, object_mass_kg=loop.m, object_stiffness_N_per_m=loop.k,
              object_damping_N_s_per_m=loop.d, spring_stiffness_N_per_m=loop.k_S,
              spring_damping_N_s_per_m=2 * loop.zeta_S * np.sqrt(loop.k_S * loop.m),
              low_pass_rad_per_s=2 * np.pi * loop.f_L, robot_dead_time_s=dead_time_s, sensor_delay_s=delay_s)
    at_rest = Disturbance.none(8000)
    first = simulate(p, np.zeros(8000), start_m=0.01)["force_N"][0]
    at_rest.force_noise_N[: round(delay_s / T)] = -first  # the reference program starts without a sample
    result = simulate(p, np.zeros(8000), at_rest, start_m=0.01)
    assert np.max(np.abs(result["command_m"] - x)) < 1e-9
    assert np.max(np.abs(result["force_N"] - force)) < 1e-5


def test_manipulator_decays_as_a_damped_sine():
    p = truth(manipulator_is_measured=1)
    M, D, K = (p["manipulator_" + n] for n in ("mass_kg", "damping_N_s_per_m", "stiffness_N_per_m"))
    t = np.arange(4000) * T
    s = D / (2 * M)
    w = np.sqrt(K / M - s**2)
    expected = 0.01 * np.exp(-s * t) * (np.cos(w * t) + s / w * np.sin(w * t))
    assert np.max(np.abs(replay_manipulator(p, np.zeros(4000), 0.01) - expected)) < 1e-9
    p["manipulator_is_measured"] = 0
    assert np.max(np.abs(replay_manipulator(p, np.zeros(4000), 0.01) - expected)) < 1e-12


@pytest.mark.parametrize("order, lag_s", [(0, 0.0), (1, 0.0), (2, 0.0), (2, 0.008)])
def test_object_and_sensor_answer_as_the_linear_system(order, lag_s):
    m, k, d, k_S, d_S, w, z = 50.0, 2000.0, 30.0, 1e5, 200.0, 120.0, 0.7
    rng = np.random.default_rng(4)
    setpoints = 1e-3 * np.cumsum(np.cumsum(rng.standard_normal(400))) / 400
    setpoints[0] = 0.0
    result = hardware(setpoints, object_mass_kg=m, object_stiffness_N_per_m=k, object_damping_N_s_per_m=d,
                      spring_stiffness_N_per_m=k_S, spring_damping_N_s_per_m=d_S, low_pass_order=order,
                      low_pass_rad_per_s=w, low_pass_damping=z, sensor_lag_s=lag_s)
    # p = v - d_S r / m instead of v: then the velocity of r does not appear in x' and p'.
    G = np.polymul([m, d, k], [d_S, k_S]), np.array([m, d + d_S, k + k_S])  # F / r
    for den, use in [([1 / w, 1], order == 1), ([1 / w**2, 2 * z / w, 1], order == 2), ([lag_s, 1], lag_s > 0)]:
        G = (G[0], np.polymul(G[1], den)) if use else G
    r = np.concatenate([[0, 0], setpoints[:-2]])
    t = np.arange(len(r)) * T
    if order == 0:  # improper: F = k_S (r - x) + d_S (r' - x') from x alone
        x = lsim(([d_S, k_S], [m, d + d_S, k + k_S]), r, t, interp=True)[1]
        assert np.max(np.abs(result["object_m"] - x)) < 1e-9
        return
    y = lsim(G, r, t, interp=True)[1] if len(G[0]) <= len(G[1]) else improper(G, r, t)
    assert np.max(np.abs(result["clean_force_N"][1:] - y[:-1])) < 1e-6 * np.max(np.abs(y))


def improper(G, r, t):
    """Answer of G = direct * s + rest to a piecewise straight r, at the end of each line."""
    rate, rest = np.polydiv(*G)
    slope = np.concatenate([[0.0], np.diff(r) / T])
    return rate[0] * slope + rate[1] * r + lsim((rest, G[1]), r, t, interp=True)[1]


def test_dead_time_to_a_fraction_of_a_tick():
    step = np.where(np.arange(40) >= 10, 1e-3, 0.0)
    r = hardware(step, robot_dead_time_s=3.3 * T)["robot_m"]
    # From the setpoint before to this one in the period that ends at (10 + 3.3) T.
    expected = np.interp(np.arange(40), [12.3, 13.3], [0.0, 1e-3])
    assert np.max(np.abs(r - expected)) < 1e-14


def test_sensor_delay_to_a_fraction_of_a_tick():
    ramp = 1e-5 * np.arange(4000)
    stiff = {"low_pass_rad_per_s": 2000.0, "object_damping_N_s_per_m": 0.0, "spring_damping_N_s_per_m": 4e4}
    force = [hardware(ramp, sensor_delay_s=s * T, **stiff)["force_N"][-1] for s in (1.0, 1.4, 3.0)]
    slope = 2368.0 * 1e-5  # N a tick
    assert force[0] - force[1] == pytest.approx(0.4 * slope, rel=1e-3)
    assert force[0] - force[2] == pytest.approx(2.0 * slope, rel=1e-3)


# --- effects of the robot ---------------------------------------------------------------------------------------


def test_backlash_is_the_play_operator():
    setpoints = np.cumsum(np.random.default_rng(2).standard_normal(2000)) * 1e-4
    setpoints[:3] = 0.0
    b, r, expected = 4e-4, 0.0, []
    for u in np.concatenate([[0, 0], setpoints[:-2]]):
        r = min(max(r, u - b / 2), u + b / 2)
        expected.append(r)
    assert np.max(np.abs(hardware(setpoints, robot_backlash_m=b)["robot_m"] - expected)) < 1e-13


def test_limits():
    step = np.where(np.arange(800) >= 10, 0.01, 0.0)
    r = hardware(step, robot_velocity_limit_m_per_s=0.05)["robot_m"]
    assert np.max(np.diff(r)) == pytest.approx(0.05 * T, rel=1e-9)
    assert r[-1] == pytest.approx(0.01)
    A = 0.1
    r = hardware(step, robot_acceleration_limit_m_per_s2=A)["robot_m"]
    assert np.max(np.abs(np.diff(r, 2))) <= A * T**2 * (1 + 1e-6)
    assert np.max(r) <= 0.01 + 0.1 * A * T**2, "a reference at rest is not overshot"
    half_s = np.interp(0.005, r[:400], np.arange(400)) * T - 11 * T
    assert half_s == pytest.approx(np.sqrt(0.01 / A), abs=2 * T), "bang-bang: half way at sqrt(x/A)"
    V = 0.02
    r = hardware(step, robot_velocity_limit_m_per_s=V, robot_acceleration_limit_m_per_s2=A)["robot_m"]
    assert np.max(np.abs(np.diff(r, 2))) <= A * T**2 * (1 + 1e-6)
    assert np.max(np.diff(r)) == pytest.approx(V * T, rel=1e-9), "neither limit gives way to the other"
    arrival_s = np.argmax(r > 0.01 - 1e-9) * T - 11 * T
    assert arrival_s == pytest.approx(0.01 / V + V / A, abs=3 * T), "a trapezium of velocity"


def test_wind_up_overshoots_and_comes_back():
    step = np.where(np.arange(4000) >= 10, 0.01, 0.0)
    r = hardware(step, robot_velocity_limit_m_per_s=0.02, robot_windup_per_s=2.0)["robot_m"]
    assert 0.0102 < np.max(r) < 0.013
    assert r[-1] == pytest.approx(0.01, abs=1e-9)


def test_lag_resonance_gain_and_periodic_error():
    step = np.where(np.arange(4000) >= 10, 1e-3, 0.0)
    tau = 0.02
    r = hardware(step, robot_lag_s=tau)["robot_m"]
    after = np.arange(50) * T
    start = 1.0 - r[12] / 1e-3  # the setpoint is reached at tick 12
    assert np.max(np.abs(1.0 - r[12:62] / 1e-3 - start * np.exp(-after / tau))) < 1e-9
    ramp = 1e-5 * np.arange(400)
    assert hardware(ramp, robot_lag_s=tau)["robot_m"][-1] == pytest.approx(1e-5 * (397 - tau / T), rel=1e-9)
    z = 0.3
    overshoot = np.max(hardware(step, robot_resonance_rad_per_s=20.0, robot_resonance_damping=z)["robot_m"]) / 1e-3
    assert overshoot - 1.0 == pytest.approx(np.exp(-np.pi * z / np.sqrt(1 - z**2)), rel=5e-3)
    assert hardware(step, robot_gain=1.03)["robot_m"][-1] == pytest.approx(1.03e-3)
    r = hardware(step, robot_periodic_m=2e-5, robot_pitch_m=5e-3, robot_periodic_rad=0.4)["robot_m"][-1]
    assert r == pytest.approx(1e-3 + 2e-5 * np.sin(2 * np.pi * 1e-3 / 5e-3 + 0.4), abs=1e-12)


def test_deadband_and_lost_commands():
    ramp = 1e-5 * np.arange(200)
    r = hardware(ramp, robot_deadband_m=4.5e-5)["robot_m"]
    assert np.allclose(r[2:], np.floor(ramp[:-2] / 5e-5 + 1e-9) * 5e-5)
    lost = Disturbance.none(200)
    lost.command_is_lost[50:52] = 1
    r = hardware(ramp, lost)["robot_m"]
    assert np.allclose(r[50:56] / 1e-5, [48, 49, 49, 49, 52, 53])


def test_free_clock_adds_a_sawtooth_to_the_dead_time():
    ramp = 1e-5 * np.arange(8000)
    r = hardware(ramp, free_clock=1, clock_drift=2e-4, clock_phase_s=0.4 * T)["robot_m"]
    delay_s = (np.arange(8000) - r / 1e-5)[100:] * T - 2 * T
    assert -1e-12 < np.min(delay_s) < 0.05 * T and 0.95 * T < np.max(delay_s) <= T * 1.001
    assert delay_s[0] == pytest.approx(0.4 * T + 2e-4 * 100 * T, abs=1e-3 * T)
    grown_s = np.median(np.diff(delay_s[:2000]))
    assert grown_s == pytest.approx(2e-4 * T, rel=1e-2)


# --- effects of manipulator and object --------------------------------------------------------------------------


def test_coulomb_friction_takes_4_Fc_by_K_a_cycle_and_sticks():
    Fc, x0 = 4.0, 0.02
    p = truth(manipulator_is_measured=1, manipulator_damping_N_s_per_m=0.0, manipulator_friction_up_N=Fc,
              manipulator_friction_down_N=Fc, manipulator_presliding_m=1e-9)
    K = p["manipulator_stiffness_N_per_m"]
    x = replay_manipulator(p, np.zeros(12000), x0)
    tops = [x[i] for i in range(1, len(x) - 1) if x[i - 1] < x[i] > x[i + 1]]
    decrements = -np.diff([x0, *tops[:8]])
    assert decrements == pytest.approx(np.full(8, 4 * Fc / K), rel=0.02)
    assert abs(x[-1]) <= Fc / K * 1.01 and np.ptp(x[-400:]) < 1e-7, "it rests where friction holds the spring"


def test_gap_and_gravity_of_the_manipulator():
    p = truth(manipulator_is_measured=1, manipulator_gap_m=2e-3, manipulator_gravity_N=30.0)
    x = replay_manipulator(p, np.zeros(20000))
    assert x[-1] == pytest.approx(-30.0 / p["manipulator_stiffness_N_per_m"] - 1e-3, rel=1e-3)


def test_work_of_damping_and_coulomb_friction():
    A, period_s, Fc, d = 0.01, 2.0, 5.0, 60.0
    setpoints, last = slow_sine(A, period_s, 4)
    r = hardware(setpoints, object_friction_N=Fc, object_presliding_m=1e-7, object_damping_N_s_per_m=d)
    expected = np.pi * d * (2 * np.pi / period_s) * A**2 + 4 * Fc * A
    assert loop_area(r["spring_N"][last], r["object_m"][last]) == pytest.approx(expected, rel=0.01)


def test_dahl_loop_area():
    A, Fh, xh = 0.01, 8.0, 0.004
    setpoints, last = slow_sine(A, 4.0, 4)
    r = hardware(setpoints, object_hysteresis_N=Fh, object_hysteresis_length_m=xh, object_damping_N_s_per_m=0.0)
    expected = 4 * Fh * (A - xh * np.tanh(A / xh))
    assert loop_area(r["spring_N"][last], r["object_m"][last]) == pytest.approx(expected, rel=0.01)


def test_bouc_wen_with_exponent_2_rises_as_a_tanh():
    setpoints, last = slow_sine(0.01, 4.0, 3)
    fields = {"object_stiffness_N_per_m": 0.0, "object_damping_N_s_per_m": 0.0, "object_mass_kg": 0.5,
              "spring_damping_N_s_per_m": 300.0}
    r = hardware(setpoints, object_hysteresis_N=8.0, object_hysteresis_length_m=0.002,
                 object_hysteresis_exponent=2.0, **fields)
    assert np.max(np.abs(r["spring_N"][last])) == pytest.approx(8.0, rel=0.03)
    rise = slice(20, int(1.0 / T))  # the jerk at the start has died down
    assert np.max(np.abs(r["spring_N"] - 8.0 * np.tanh(r["object_m"] / 0.002))[rise]) < 0.1


@pytest.mark.parametrize("fields, extra", [
    ({"object_cubic_N_per_m3": 2e6}, lambda x: 2e6 * x**3),
    ({"object_quadratic_N_per_m2": 3e4}, lambda x: 3e4 * x**2),
    ({"object_gap_m": 4e-3}, lambda x: -2368.0 * np.clip(x, -2e-3, 2e-3)),
    ({"object_softening_m": 0.01}, lambda x: 2368.0 * (0.01 * np.sin(x / 0.01) - x)),
])
def test_static_force_of_the_object(fields, extra):
    setpoints, _ = slow_sine(0.01, 40.0, 1)
    light = {"object_damping_N_s_per_m": 0.0, "object_mass_kg": 1.0, "spring_damping_N_s_per_m": 2000.0}
    r = hardware(setpoints, **light, **fields)
    x = r["object_m"]
    assert np.max(np.abs(r["spring_N"] - 2368.0 * x - extra(x))[100:]) < 0.05


def test_second_mass_absorbs_at_its_frequency():
    m2, f_Hz, z, A = 20.0, 3.0, 0.02, 1e-3
    w = 2 * np.pi * f_Hz
    t = np.arange(16000) * T
    r = hardware(A * np.sin(w * t), second_mass_kg=m2, second_stiffness_N_per_m=m2 * w**2,
                 second_damping_N_s_per_m=2 * z * m2 * w, object_damping_N_s_per_m=0.0)
    last = t > 30
    s = 1j * w
    hang = m2 * s**2 * (2 * z * w * s + w**2) / (s**2 + 2 * z * w * s + w**2)
    expected = abs(100.0 * s**2 + 2368.0 + hang) * A
    basis = np.exp(-1j * w * t[last])
    measured = 2 * abs(np.mean(r["spring_N"][last] * basis)) * A / (2 * abs(np.mean(r["object_m"][last] * basis)))
    assert measured == pytest.approx(expected, rel=0.01)


def test_contact():
    ramp = np.concatenate([2e-5 * np.arange(800), 2e-5 * np.arange(800)[::-1]])
    fields = {"contact": 1, "object_mass_kg": 1.0, "surface_m": 0.004, "spring_stiffness_N_per_m": 2e6,
              "spring_damping_N_s_per_m": 500.0, "object_stiffness_N_per_m": 3000.0}
    v = 2e-5 / T
    r = hardware(ramp, **fields, impact_damping_s_per_m=20.0)
    depth = r["object_m"][700] - 0.004
    assert r["spring_N"][700] == pytest.approx(3000.0 * depth * (1 + 20.0 * v), rel=1e-3)
    depth = r["object_m"][1200] - 0.004
    assert r["spring_N"][1200] == pytest.approx(3000.0 * depth * (1 - 20.0 * v), rel=1e-3)
    assert abs(r["spring_N"][100]) < 1e-6 and abs(r["spring_N"][-50]) < 1e-6, "nothing is touched"


@pytest.mark.parametrize("fields", [
    {"object_gap_m": 4e-3, "object_stiffness_N_per_m": 2e5},
    {"contact": 1, "surface_m": 0.002, "object_stiffness_N_per_m": 5e5, "object_damping_N_s_per_m": 50.0},
    {"object_friction_N": 30.0, "object_presliding_m": 2e-5},
])
def test_switches_are_met_whatever_the_step(fields):
    setpoints, _ = slow_sine(0.01, 0.5, 4)
    soft = {"object_mass_kg": 2.0, "spring_stiffness_N_per_m": 1e4, "spring_damping_N_s_per_m": 20.0, **fields}
    fine, coarse = (hardware(setpoints, substep_s=h, **soft)["object_m"] for h in (1e-5, 2.5e-4))
    print(np.max(np.abs(fine - coarse)))
    assert np.max(np.abs(fine - coarse)) < 1e-7


def test_grip_lets_go_at_a_corner_whose_pull_is_over_within_a_tick():
    """A jump of the robot's velocity to -v pulls with d v at once, which the object's giving in takes away."""
    velocity_m_per_s, damping_N_s_per_m = 0.02, 3000.0
    setpoints = np.concatenate([np.zeros(50), -velocity_m_per_s * T * np.array([1.0, 1.0]), np.zeros(50)])
    setpoints[52:] = setpoints[51]
    body = {"spring_stiffness_N_per_m": 1e4, "spring_damping_N_s_per_m": damping_N_s_per_m, "object_mass_kg": 5.0}
    jump_N = damping_N_s_per_m * velocity_m_per_s
    held = hardware(setpoints, grip_N=1.02 * jump_N, **body)
    assert np.min(held["spring_N"]) > -0.9 * jump_N, "at the ticks it is over"
    assert np.array_equal(held["spring_N"], hardware(setpoints, **body)["spring_N"])
    loose = hardware(setpoints, grip_N=0.98 * jump_N, **body)
    assert np.all(loose["spring_N"][53:56] == 0.0)


def test_grip_lets_go_and_is_touched_again():
    setpoints, _ = slow_sine(0.01, 4.0, 4)
    r = hardware(setpoints, grip_N=10.0, object_damping_N_s_per_m=60.0)
    held = hardware(setpoints, object_damping_N_s_per_m=60.0)
    assert np.min(held["spring_N"]) < -20.0
    assert np.min(r["spring_N"]) >= -10.1
    assert np.sum(r["spring_N"] == 0.0) > 400, "it swings by itself"


# --- sensor and losses ------------------------------------------------------------------------------------------


def test_sensor():
    setpoints, _ = slow_sine(0.005, 1.0, 4)
    plain = hardware(setpoints)["force_N"]
    t = np.arange(len(setpoints)) * T
    assert np.allclose(hardware(setpoints, sensor_gain=1.1)["force_N"], 1.1 * plain)
    changed = hardware(setpoints, sensor_bias_N=2.0, sensor_drift_N_per_s=0.3)["force_N"]
    assert np.allclose(changed, plain + 2.0 + 0.3 * t)
    changed = hardware(setpoints, sensor_periodic_N=0.5, sensor_periodic_rad_per_s=40.0, sensor_periodic_rad=1.0)
    sampled_s = t - T  # it hums into the sample
    assert np.allclose(changed["force_N"], plain + 0.5 * np.sin(40.0 * sampled_s + 1.0))
    assert np.allclose(hardware(setpoints, sensor_saturation_N=6.0)["force_N"], np.clip(plain, -6, 6))
    stepped = hardware(setpoints, sensor_step_N=0.5)["force_N"]
    assert np.allclose(stepped % 0.5, 0.0) and np.max(np.abs(stepped - plain)) <= 0.25 + 1e-12
    lost = Disturbance.none(len(t))
    lost.force_is_lost[100:103] = 1
    lost.tick_is_lost[200] = 1
    r = hardware(setpoints, lost)
    assert np.all(r["force_N"][99:103] == r["force_N"][99]) and r["force_N"][103] == plain[103]
    assert r["force_N"][200] == r["force_N"][199] and r["robot_m"][200] == r["robot_m"][199]
