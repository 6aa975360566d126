"""What `berth diagnose` says a record would have shown: tried with effects of just such sizes, and by closed forms."""

import json

import numpy as np
import pytest
from conftest import EXIT_DONE, command, settings

NOISE_N, NOISE_m, RATE_Hz = 0.2, 5e-6, 400
RUN = {"run.duration_s": 30, "profile.kind": "chirp", "profile.amplitude_m": 0.01, "profile.frequency_end_Hz": 4,
       "profile.duration_s": 29, "sensor.noise_N": NOISE_N, "robot.feedback_noise_m": NOISE_m}
SEED = 7


def diagnose(out, *arguments):
    """The diagnosis in `out`; it must not fail."""
    done = command("diagnose", *arguments, "--out", out)
    assert done.returncode == EXIT_DONE, done.stderr.decode()
    return json.loads((out / "diagnosis.json").read_text()), done.stdout.decode()


def diagnosed_run(folder, **more):
    """A run of `ess` with further keys, diagnosed with the rig that knows nothing of them; how to do it again."""
    if "sensor.delay_ms" in more:  # a sample must come as a tick begins, or it waits for the next one
        more["sensor.sample_phase_ms"] = -more["sensor.delay_ms"] % (1000 / RATE_Hz)
    keys = settings({**RUN, "run.seed": SEED, **more})
    assert command("run", "ess", *keys, "--out", folder).returncode == EXIT_DONE
    again = f"build/berth run ess {' '.join(keys)} --out DIR && build/berth diagnose DIR/ess.ulg --rig ess"
    return *diagnose(folder, folder / "ess.ulg", "--rig", "ess"), again


@pytest.fixture(scope="module")
def clean(tmp_path_factory):
    """(diagnosis, terminal, rows of the fit) of a run of the rig as given."""
    folder = tmp_path_factory.mktemp("clean")
    found, terminal, again = diagnosed_run(folder)
    assert found["verdict"] == "nothing_detectable", again
    series = np.genfromtxt(folder / "series.csv", delimiter=",", names=True)
    return found, terminal, int((series["force_use"] == 1).sum())


def smallest(clean, key):
    return next(one for one in clean[0]["detectable"] if one["key"] == key)


@pytest.mark.long
def test_every_effect_that_acts_there_is_told_once(clean):
    """All but those of the manipulator, which is software here, of a contact, and of what refines another."""
    listed = {one["effect"] for one in json.loads(command("effects", "--json").stdout)}
    told = clean[0]["detectable"]
    missing = listed - {one["effect"] for one in told}
    assert all(name.startswith("manipulator.") or name == "object.impact_damping" for name in missing), missing
    assert len({(one["effect"], one["key"]) for one in told}) == len(told)
    sizes = [one["value"] for one in told if one["value"] is not None]
    assert all(np.isfinite(size) for size in sizes) and len(sizes) > 25
    assert len(sizes) == len(told)
    # Spring, damper and mass of the object scaled together are what a gain is, as far as their tolerances let them.
    assert 0.05 < smallest(clean, "sensor.gain_error")["value"] < 0.06
    for one in told:
        assert one["key"] in clean[1] if one["value"] is not None else one["effect"] in clean[1]


def needed_square(found, rows):
    """White sum of squares S that is seen 19 times in 20: S - 2 * 1.645 sqrt(S) is what BIC wants (better by 20 with
    one parameter more), or 30 % of what is above the floor."""
    fit = found["residual"]["force_N"]["fit"]
    above = (fit["after"] / fit["floor"]) ** 2 - 1.0
    least = max(20.0 + np.log(rows), 0.3 / 0.7 * rows * above)
    return np.roots([1.0, -2.0 * 1.645, -least]).max() ** 2


def test_a_constant_against_white_noise_is_the_closed_form(clean):
    """A constant is no part of what the base can make up for: rows b^2 / sigma^2 = S."""
    found, _, rows = clean
    expected = NOISE_N * np.sqrt(needed_square(found, rows) / rows)
    assert smallest(clean, "sensor.bias_N")["value"] == pytest.approx(expected, rel=0.05)


def test_drift_against_white_noise_is_the_closed_form(clean):
    """A line from the start of the record on: sum (r t)^2 / sigma^2 = S."""
    found, _, rows = clean
    t_s = np.linspace(0.0, RUN["run.duration_s"], rows)
    expected = NOISE_N * np.sqrt(needed_square(found, rows) / (t_s**2).sum())
    assert smallest(clean, "sensor.drift_N_per_s")["value"] == pytest.approx(expected, rel=0.08)


# The rest of a robot's path shows in the force as well, where the stiff sensor makes more of it than is told here.
KEYS = ["robot.gain_error", "robot.dead_time_ms", "robot.lag_ms", "robot.velocity_limit_m_per_s",
        "sensor.delay_ms", "sensor.lag_ms", "sensor.gain_error",
        "object.cubic_stiffness_N_per_m3", "object.coulomb_friction_N", "object.mass_kg", "sensor.bias_N"]
LIMIT = "robot.velocity_limit_m_per_s"


@pytest.mark.long
@pytest.mark.parametrize("key", KEYS)
@pytest.mark.first(4)
def test_twice_the_size_is_seen(clean, tmp_path, key):
    told = smallest(clean, key)
    given = told["given"] or 0.0
    # A limit acts below its value.
    size = 0.97 * told["value"] if key == LIMIT else given + 2.0 * (told["value"] - given)
    found, _, again = diagnosed_run(tmp_path, **{key: size, "run.seed": SEED + 1})
    seen = [one["effect"] for one in found["causes"] + found["alternatives"]]
    print(f"{key} = {size:.4g}: {found['verdict']}, {', '.join(seen)}")
    assert found["verdict"] != "nothing_detectable", again
    assert told["effect"] in seen, f"{seen}; {again}"


@pytest.mark.long
@pytest.mark.parametrize("key", [key for key in KEYS if key != LIMIT])
@pytest.mark.first(4)
def test_a_third_of_the_size_is_not_named(clean, tmp_path, key):
    told = smallest(clean, key)
    given = told["given"] or 0.0
    size = given + 0.3 * (told["value"] - given)
    found, _, again = diagnosed_run(tmp_path, **{key: size, "run.seed": SEED + 2})
    assert found["verdict"] == "nothing_detectable" and found["causes"] == [], again
