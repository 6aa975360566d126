"""`berth diagnose` on records without setpoints: the measured motion of a test machine and the force upon it. The records
are made here, by other means than the project's."""

import json
import re

import numpy as np
import pytest
from conftest import EXIT_DONE, EXIT_INPUT, command
from scipy.interpolate import CubicSpline

RATE_Hz = 200.0
ROWS = 6000
FINE = 40
NOISE_N = 0.3

RIG = """
name = "specimen"
[object]
mass_kg = 0.001
stiffness_N_per_m = { value = 8200.0, tolerance = 0.1 }
damping_N_s_per_m = { value = 62.0, tolerance = 0.1 }
[sensor]
low_pass_order = 0
delay_ms = 0.0
[bus]
ideal = true
"""


def motion(seed):
    """Position and velocity, `FINE` values a row: 20 lines up to 4 Hz, none a multiple of another."""
    rng = np.random.default_rng(seed)
    t_s = np.arange(ROWS * FINE) / RATE_Hz / FINE
    lines_Hz = np.linspace(0.2, 4.0, 20) * (1.0 + 0.03 * rng.standard_normal(20))
    sizes_m = 0.02 / (1.0 + lines_Hz) / np.sum(1.0 / (1.0 + lines_Hz))
    phases = rng.uniform(0, 2 * np.pi, 20)
    x_m = sum(a * np.sin(2 * np.pi * f * t_s + p) for a, f, p in zip(sizes_m, lines_Hz, phases))
    v_m_per_s = sum(a * 2 * np.pi * f * np.cos(2 * np.pi * f * t_s + p)
                    for a, f, p in zip(sizes_m, lines_Hz, phases))
    return x_m, v_m_per_s


def dahl_N(x_m, force_N, length_m):
    """Exact for motion in one direction between two values."""
    z = np.zeros_like(x_m)
    for n in range(1, len(x_m)):
        way_m = x_m[n] - x_m[n - 1]
        towards = np.sign(way_m)
        z[n] = towards - (towards - z[n - 1]) * np.exp(-abs(way_m) / length_m)
    return force_N * z


LAWS = {
    "nothing": lambda x_m: 0.0,
    "object.cubic_stiffness": lambda x_m: 5e6 * x_m**3,
    "object.hysteresis": lambda x_m: dahl_N(x_m, 6.0, 8e-4),
}


def record(path, law, seed, noise_m=0.0):
    x_m, v_m_per_s = motion(seed)
    force_N = (8000.0 * x_m + 60.0 * v_m_per_s + LAWS[law](x_m))[::FINE]
    rng = np.random.default_rng(seed + 100)
    columns = [np.arange(ROWS) / RATE_Hz, x_m[::FINE] + noise_m * rng.standard_normal(ROWS),
               force_N + NOISE_N * rng.standard_normal(ROWS)]
    np.savetxt(path, np.column_stack(columns), delimiter=",", header="t_s,robot_position_m,force_N", comments="",
               fmt="%.12g")
    return path


def diagnosed(tmp_path, law, noise_m=0.0):
    rig = tmp_path / "specimen.toml"
    rig.write_text(RIG)
    done = command("diagnose", record(tmp_path / "fit.csv", law, 1, noise_m), "--validate",
                   record(tmp_path / "unseen.csv", law, 2, noise_m), "--rig", rig, "--out", tmp_path / "out")
    assert done.returncode == EXIT_DONE, done.stderr.decode()
    found = json.loads((tmp_path / "out" / "diagnosis.json").read_text())
    assert any("robot_position_m drives the force" in note for note in found["notes"])
    assert [block["block"] for block in found["blocks"]] == ["force"]
    return found


def test_of_a_spring_and_a_damper_only_noise_is_left(tmp_path):
    found = diagnosed(tmp_path, "nothing")
    assert found["verdict"] == "nothing_detectable" and found["causes"] == []
    assert found["residual"]["force_N"]["held_out"]["after"] == pytest.approx(NOISE_N, rel=0.05)
    assert not any(size["effect"].startswith("robot.") for size in found["detectable"])


@pytest.mark.parametrize("law, name, value, noise_m", [
    ("object.cubic_stiffness", "cubic_stiffness_N_per_m3", 5e6, 0.0),
    ("object.cubic_stiffness", "cubic_stiffness_N_per_m3", 5e6, 1e-6),
    ("object.hysteresis", "hysteresis_force_N", 6.0, 0.0),
    ("object.hysteresis", "hysteresis_length_m", 8e-4, 0.0)])
@pytest.mark.first(2)
def test_what_a_specimen_does_is_named(tmp_path, law, name, value, noise_m):
    found = diagnosed(tmp_path, law, noise_m)
    assert found["verdict"] == "named" and [cause["effect"] for cause in found["causes"]] == [law]
    told = {one["name"]: one for one in found["causes"][0]["parameters"]}[name]
    low, high = told["ci95"]
    assert told["value"] == pytest.approx(value, rel=0.02)
    assert low - 0.2 * (high - low) < value < high + 0.2 * (high - low)
    series = (tmp_path / "out" / "series.csv").read_text().splitlines()[0]
    assert "robot_position_m" in series and "command_position_m" not in series
    extended = command("run", tmp_path / "out" / "extended.toml", "--no-log", "--json")
    assert extended.returncode == EXIT_DONE, extended.stderr.decode()


def test_noise_of_the_motion_makes_no_cause(tmp_path):
    """Of 5 um: the damper makes 0.08 N of it, which follows the motion as it was measured."""
    found = diagnosed(tmp_path, "object.cubic_stiffness", 5e-6)
    assert found["verdict"] == "partly_explained" and len(found["causes"]) == 1
    assert found["causes"][0]["parameters"][0]["value"] == pytest.approx(5e6, rel=0.02)


def test_what_the_noise_of_the_motion_makes_of_the_force_is_told(tmp_path):
    """Held against scipy's spline: what drives the force is one through noise as well as through the motion."""
    noise_m = 5e-6
    spline = CubicSpline(np.arange(ROWS) / RATE_Hz, noise_m * np.random.default_rng(5).standard_normal(ROWS))
    force_N = 8000.0 * spline(spline.x) + 60.0 * spline(spline.x, 1)
    told = [re.search(r"noise of (\S+) m from row to row: .* is (\S+) N rms of the (\S+) N", note)
            for note in diagnosed(tmp_path, "nothing", noise_m)["notes"]]
    told = [match for match in told if match]
    assert len(told) == 1
    assert float(told[0][1]) == pytest.approx(noise_m, rel=0.05)
    assert float(told[0][2]) == pytest.approx(np.std(force_N), rel=0.05)
    assert float(told[0][3]) == pytest.approx(np.hypot(NOISE_N, np.std(force_N)), rel=0.05)
    assert not any("from row to row" in note for note in diagnosed(tmp_path, "nothing")["notes"])


def test_a_motion_alone_says_what_is_missing(tmp_path):
    path = tmp_path / "motion.csv"
    np.savetxt(path, np.column_stack([np.arange(ROWS) / RATE_Hz, motion(1)[0][::FINE]]), delimiter=",",
               header="t_s,robot_position_m", comments="")
    rig = tmp_path / "specimen.toml"
    rig.write_text(RIG)
    done = command("diagnose", path, "--rig", rig, "--out", tmp_path / "out")
    assert done.returncode == EXIT_INPUT and "robot_position_m with force_N" in done.stderr.decode()
