"""Accuracy where it is hard: 400 samples of dead time, with them hundreds of eigenvalues that crowd in rings and around
0, and a rig tuned onto its limit. Against 50-digit arithmetic."""

import json
import math
import os
import random

import pytest
from conftest import command, settings
from fifty_digits import CharacteristicEquation, Parameters

SEED = int(os.environ.get("BERTH_TEST_SEED", "20260"))
CASES = 20
TOLERANCE = 1e-12


def berth_json(subcommand, values):
    """`berth SUBCOMMAND ess --json` with these keys."""
    done = command(subcommand, "ess", "--json", *settings(values))
    assert done.returncode == 0, done.stderr.decode()
    return json.loads(done.stdout)


def draw(number):
    """One case: every second with 400 samples of dead time, the others with 8 to 80."""
    rng = random.Random(SEED * 1000 + number)
    rate_Hz = rng.choice([200, 250, 400, 500, 1000])
    samples = 400 if number % 2 == 0 else rng.randint(8, 80)
    sample_ticks = rng.randint(1, 4)
    M = rng.uniform(50, 500)
    K = M * (2 * math.pi * rng.uniform(0.5, 2)) ** 2
    m = M * rng.uniform(0.05, 0.8)
    k = K * rng.uniform(0.05, 3)
    T_R_ns = int((samples - sample_ticks - rng.random()) * 1e9 / rate_Hz)
    return Parameters(rate_Hz, T_R_ns, sample_ticks, M, K, 2 * rng.uniform(0.01, 0.2) * math.sqrt(K * M), m, k,
                      2 * rng.uniform(0.0, 0.1) * math.sqrt(k * m), 10 ** rng.uniform(6, 7.3),
                      rng.uniform(0.01, 0.1), rng.uniform(10, 40), rng.uniform(0.5, 1.0))


def onto_its_limit(parameters):
    """The same rig with the object's mass, stiffness or damping on the limit of stability; the name of what moved."""
    limits = berth_json("limits", parameters.settings())["parameters"]
    for name, key in (("m", "object.mass_kg"), ("k", "object.stiffness_N_per_m"), ("d", "object.damping_N_s_per_m"),
                      ("D", "manipulator.damping_N_s_per_m")):
        for side in ("above", "below"):
            if limits[key][side] is not None:
                setattr(parameters, name, limits[key][side]["value"])
                return name
    return None


@pytest.mark.parametrize("number", range(CASES))
def test_spectral_radius_against_fifty_digits(number):
    parameters = draw(number)
    moved = onto_its_limit(parameters) if number % 4 < 2 else None
    told = berth_json("eigen", parameters.settings())["spectral_radius"]
    exact = CharacteristicEquation(parameters).spectral_radius()
    error = abs(float(told / exact - 1))
    print(f"case {number}: {parameters.T_R_ns * parameters.rate_Hz / 1e9 + parameters.sample_ticks:.2f} samples of "
          f"dead time, {f'{moved} on its limit, ' if moved else ''}|z| - 1 = {float(exact - 1):+.3e}, "
          f"relative difference {error:.1e}; BERTH_TEST_SEED={SEED}")
    assert error < TOLERANCE
    if moved:
        assert abs(float(exact - 1)) < 1e-9
