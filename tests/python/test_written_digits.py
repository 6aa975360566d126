"""Records of a manipulator whose forces were written with fewer digits than the loop had: rounding, integrated twice, is
slow and smooth, and no fault of the manipulator."""

import json

import numpy as np
import pytest
import scipy.linalg
from conftest import EXIT_DONE, command

PERIOD_s, ROWS, STEPS = 0.0025, 8000, 64
MASS_kg, DAMPING, STIFFNESS = 200.0, 125.0, 7900.0
RIG = f"""
name = "few-digits"
[manipulator]
mass_kg = {MASS_kg}
damping_N_s_per_m = {DAMPING}
stiffness_N_per_m = {STIFFNESS}
"""


def moved(push_N, friction_N):
    """Position where each push is held over its row: exact, but for the instants at which the friction turns."""
    a = np.array([[0.0, 1.0, 0.0], [-STIFFNESS / MASS_kg, -DAMPING / MASS_kg, 1.0 / MASS_kg], [0.0, 0.0, 0.0]])
    (xx, xv, xp), (vx, vv, vp) = scipy.linalg.expm(a * PERIOD_s / STEPS)[:2]
    x, v, position_m = 0.0, 0.0, np.empty(ROWS)
    for n, push in enumerate(push_N):
        position_m[n] = x
        for _ in range(STEPS):
            free = vx * x + vv * v + vp * push
            against_N = min(friction_N, abs(free) / vp) * (1.0 if free > 0.0 else -1.0)
            x, v = xx * x + xv * v + xp * (push - against_N), free - vp * against_N
    return position_m


def told_of(folder, digits, friction_N=0.0):
    rng = np.random.default_rng(3)
    t_s = PERIOD_s * np.arange(ROWS)
    push_N = 60.0 * np.sin(2 * np.pi * (0.2 + 0.1 * t_s) * t_s) * np.sin(2 * np.pi * 0.07 * t_s)
    push_N += 0.1 * rng.standard_normal(ROWS)
    lines = [f"{t:.4f},{digits % push},{x:.11f}" for t, push, x in zip(t_s, push_N, moved(push_N, friction_N))]
    (folder / "record.csv").write_text("\n".join(["t_s,operator_force_N,command_position_m"] + lines) + "\n")
    (folder / "rig.toml").write_text(RIG)
    done = command("diagnose", folder / "record.csv", "--rig", folder / "rig.toml", "--out", folder / "out")
    assert done.returncode == EXIT_DONE, done.stderr.decode()
    return json.loads((folder / "out" / "diagnosis.json").read_text())


@pytest.mark.parametrize("digits, unit", [("%.2f", "0.01"), ("%.3f", "0.001"), ("%.4g", "0.01")])
def test_few_digits_are_told_and_nothing_is_made_of_them(tmp_path, digits, unit):
    told = told_of(tmp_path, digits)
    assert told["verdict"] == "nothing_detectable", [block["doubts"] for block in told["blocks"]]
    [note] = [note for note in told["notes"] if note.startswith("written are")]
    assert f"operator_force_N to {unit} N" in note
    assert told["residual"]["command_position_m"]["fit"]["after"] > 1e-9, "too little to be a test"


def test_all_digits_need_no_word(tmp_path):
    told = told_of(tmp_path, "%.12g")
    assert told["verdict"] == "nothing_detectable"
    assert not any(note.startswith("written are") for note in told["notes"])


def test_beside_few_digits_a_cause_is_named(tmp_path):
    told = told_of(tmp_path, "%.3f", friction_N=2.0)
    assert told["verdict"] == "named", told["blocks"][0]["doubts"]
    [cause] = told["causes"]
    assert cause["effect"] == "manipulator.coulomb_friction"
    assert cause["parameters"][0]["value"] == pytest.approx(2.0, rel=0.01)
