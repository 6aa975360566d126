"""`berth diagnose` on measured manipulators whose driving force may have moved between the rows of the record. The records
are made here, by other means than the project's."""

import numpy as np
import pytest
import scipy.signal
from conftest import EXIT_DONE, command
from test_unmodelled import diagnosed, write


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


@pytest.mark.parametrize("every, moves", [(1, False), (10, True)])
def test_a_force_that_moves_between_the_rows_is_told(tmp_path, every, moves):
    """A drive with dry friction, controlled at 1 kHz, of which every row or each tenth one is kept."""
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
    record = write(tmp_path / "record.csv", t_s=t_s[::every], operator_force_N=force_N[::every],
                   command_position_m=position_m[::every])
    rig = tmp_path / "drive.toml"
    rig.write_text(DRIVE_RIG.format(rate_Hz=1000 // every))
    found = diagnosed(tmp_path, record, "--rig", rig)
    assert any("counts as moving on between them" in note for note in found["notes"]) == moves
    friction = {p["name"]: p["value"] for cause in found["causes"] for p in cause["parameters"]}["coulomb_friction_N"]
    assert friction == pytest.approx(30.0, rel=0.02 if moves else 0.005)


def test_a_slow_record_needs_no_robot_that_suits_it(tmp_path):
    """20 Hz, and the rig file states neither a rate nor a robot: its dead time is less than a period."""
    t_s = 0.05 * np.arange(1200)
    force_N = 5.0 * np.sin(1.3 * t_s) + 3.0 * np.sin(2.9 * t_s)
    held = scipy.signal.cont2discrete((np.array([[0.0, 1.0], [-20.0, -1.0]]), np.array([[0.0], [0.05]]),
                                       np.array([[1.0, 0.0]]), np.zeros((1, 1))), 0.05)
    position_m = scipy.signal.dlsim(held, force_N)[1][:, 0] + 1e-4 * np.random.default_rng(2).standard_normal(1200)
    record = write(tmp_path / "record.csv", t_s=t_s, operator_force_N=force_N, command_position_m=position_m)
    rig = tmp_path / "slow.toml"
    rig.write_text("[manipulator]\nmass_kg = 20\ndamping_N_s_per_m = 20\nstiffness_N_per_m = 400\n")
    found = diagnosed(tmp_path, record, "--rig", rig)
    assert found["verdict"] == "nothing_detectable"
    assert any("the record does not show the robot" in note for note in found["notes"])
    extended = command("run", tmp_path / "out" / "extended.toml", "--no-log", "--json")
    assert extended.returncode == EXIT_DONE, extended.stderr.decode()


FAST_RIG = """
name = "fast"
[loop]
rate_Hz = 400
[manipulator]
mass_kg = { value = 0.53, tolerance = 0.1 }
damping_N_s_per_m = { value = 9.5, tolerance = 0.1 }
stiffness_N_per_m = { value = 18500.0, tolerance = 0.1 }
[operator]
interface = "force"
"""


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


@pytest.mark.parametrize("moves, cubic_N_per_m3", [(True, 0.0), (True, 3e7), (False, 0.0), (False, 3e7)])
@pytest.mark.first(2)
def test_a_force_between_the_rows_is_the_one_that_explains_more(tmp_path, moves, cubic_N_per_m3):
    """Noise up to half of the highest frequency drives an oscillator of 30 Hz, logged at 400 Hz."""
    fine, rate_Hz = 16, 400.0
    rng = np.random.default_rng(11)
    files = []
    for name in ("fit", "unseen"):
        force_N = rng.standard_normal(4000 * fine)
        force_N = scipy.signal.sosfilt(scipy.signal.butter(9, 100.0, fs=rate_Hz * fine, output="sos"), force_N)
        force_N *= 20.0 / force_N.std()
        if not moves:
            force_N = np.repeat(force_N[::fine], fine)
        position_m = oscillator(force_N, not moves, cubic_N_per_m3, 1.0 / rate_Hz / fine)[::fine]
        position_m += 1e-5 * rng.standard_normal(4000)
        files.append(write(tmp_path / f"{name}.csv", t_s=np.arange(4000) / rate_Hz, operator_force_N=force_N[::fine],
                           command_position_m=position_m))
    rig = tmp_path / "fast.toml"
    rig.write_text(FAST_RIG)
    found = diagnosed(tmp_path, files[0], "--validate", files[1], "--rig", rig)
    assert any("counts as moving on between them" in note for note in found["notes"]) == moves
    assert found["residual"]["command_position_m"]["held_out"]["after"] == pytest.approx(1e-5, rel=0.1)
    if cubic_N_per_m3:
        assert found["verdict"] == "named" and found["causes"][0]["effect"] == "manipulator.cubic_stiffness"
        assert found["causes"][0]["parameters"][0]["value"] == pytest.approx(cubic_N_per_m3, rel=0.005)
    else:
        assert found["verdict"] == "nothing_detectable"


@pytest.mark.parametrize("moves", [True, False])
def test_a_slow_force_shows_between_the_rows_where_the_noise_is_small(tmp_path, moves):
    """At 1 kHz it hardly changes from row to row; held, it is late by ten times the noise."""
    fine, rate_Hz, noise_m = 16, 1000.0, 1e-6
    t_s = np.arange(12000 * fine) / rate_Hz / fine
    force_N = sum(8.0 * np.sin(2 * np.pi * tone_Hz * t_s + i) for i, tone_Hz in enumerate((1.1, 2.9, 5.3, 7.7)))
    if not moves:
        force_N = np.repeat(force_N[::fine], fine)
    position_m = oscillator(force_N, not moves, 0.0, 1.0 / rate_Hz / fine)[::fine]
    position_m += noise_m * np.random.default_rng(5).standard_normal(12000)
    record = write(tmp_path / "slow.csv", t_s=t_s[::fine], operator_force_N=force_N[::fine],
                   command_position_m=position_m)
    rig = tmp_path / "fast.toml"
    rig.write_text(FAST_RIG.replace("400", "1000"))
    found = diagnosed(tmp_path, record, "--rig", rig)
    assert found["verdict"] == "nothing_detectable", found["blocks"][0]["doubts"]
    assert any("counts as moving on between them" in note for note in found["notes"]) == moves
    assert found["residual"]["command_position_m"]["fit"]["after"] == pytest.approx(noise_m, rel=0.1)
