"""The generator of hidden effects: its records, the truth beside them, and that both can be made again."""

import csv
import json
import subprocess
import sys
import tomllib

import numpy as np
import pytest
from conftest import ROOT, command
from scipy.linalg import expm
from scipy.signal import StateSpace, dlsim

FOLDER = ROOT / "tests" / "hidden_effects"
sys.path.insert(0, str(FOLDER))
import detectability  # noqa: E402
import equivalents  # noqa: E402
import scenario as scenarios  # noqa: E402
from effects import ASKED_FOR, LIBRARY, Change  # noqa: E402
from noise import Noise  # noqa: E402

T = 0.0025


def test_noise_has_the_spectrum_that_the_truth_states():
    noise = Noise(0.1, 0.2, 5.0, 0.0)
    ticks = 200_000
    values = noise.draw(np.random.default_rng(1), ticks, T)
    assert np.std(values) == pytest.approx(noise.rms, rel=0.02)
    f_Hz = np.fft.rfftfreq(ticks, T)
    power = np.abs(np.fft.rfft(values)) ** 2 / ticks / noise.spectrum(f_Hz, T)
    for low, high in [(0.1, 2), (2, 10), (10, 50), (50, 190)]:
        assert np.mean(power[(f_Hz > low) & (f_Hz < high)]) == pytest.approx(1.0, abs=0.12)


def generate(folder, seed, *arguments):
    """Runs the command line; the record's folder and the truth."""
    out, hidden = folder / f"record-{seed}", folder / f"truth-{seed}"
    words = [sys.executable, FOLDER / "generate.py", "--seed", seed, "--out", out, "--truth", hidden, *arguments]
    done = subprocess.run([str(w) for w in words], capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    print(done.stdout)
    return out, json.loads((hidden / "truth.json").read_text())


def columns(path):
    with open(path, newline="") as file:
        rows = list(csv.reader(file))
    return dict(zip(rows[0], np.array(rows[1:], float).T))


def plain_values(rig):
    """The rig file's values, tolerances left out: {section: {key: value}}."""
    return {section: {key: value["value"] if isinstance(value, dict) else value for key, value in keys.items()}
            for section, keys in rig.items() if isinstance(keys, dict)}


@pytest.mark.long
def test_same_seed_same_bytes_and_the_truth_stays_apart(tmp_path):
    arguments = ["--effect", "robot.backlash", "--size", "medium"]
    first, _ = generate(tmp_path / "a", 7, *arguments)
    second, _ = generate(tmp_path / "b", 7, *arguments)
    other, _ = generate(tmp_path / "a", 8, *arguments)
    names = sorted(path.name for path in first.iterdir())
    assert set(names) <= {"rig.toml", "record.csv", "validate.csv", "repeat.csv", "standstill.csv"}
    for name in names:
        assert (first / name).read_bytes() == (second / name).read_bytes()
        assert "backlash" not in (first / name).read_text()
    assert (first / "record.csv").read_bytes() != (other / "record.csv").read_bytes()
    done = subprocess.run([sys.executable, str(FOLDER / "generate.py"), "--seed", "7", "--out", str(tmp_path),
                           "--truth", str(tmp_path)], capture_output=True, check=False)
    assert done.returncode != 0, "record and truth in one folder"


@pytest.mark.long
@pytest.mark.parametrize("effect, seed", [("none", 1), ("robot.deadband", 2), ("sensor.spikes", 3),
                                          ("object.coulomb_friction", 4), ("loop.lost_samples", 5)])
@pytest.mark.first(2)
def test_the_firmwares_command_follows_from_operator_and_force(tmp_path, effect, seed):
    out, hidden = generate(tmp_path, seed, "--effect", effect, "--size", "medium")
    if hidden["true_fields"]["manipulator_is_measured"]:
        seed += 100
        out, hidden = generate(tmp_path, seed, "--effect", effect, "--size", "medium")
    assert not hidden["true_fields"]["manipulator_is_measured"]
    rig = plain_values(tomllib.loads((out / "rig.toml").read_text()))
    M, K, D = (rig["manipulator"][n] for n in ("mass_kg", "stiffness_N_per_m", "damping_N_s_per_m"))
    period_s = 1.0 / rig["loop"]["rate_Hz"]
    G = np.zeros((3, 3))
    G[0, 1], G[1] = 1.0, [-K / M, -D / M, 1.0 / M]
    step = expm(G * period_s)
    record = columns(out / "record.csv")
    system = StateSpace(step[:2, :2], step[:2, 2:], np.eye(2)[:1], [[0.0]], dt=period_s)
    x = dlsim(system, record["operator_force_N"] - record["force_N"])[1][:, 0]
    assert np.max(np.abs(x - record["command_position_m"])) < 6e-12, "half a step of 10 pm"


@pytest.mark.long
@pytest.mark.parametrize("effect, words, shows", [
    ("object.cubic_stiffness", ["eigen"], b": stable"),
    ("object.impact_damping", ["run", "--print-config"], b'kind = "contact"'),
])
@pytest.mark.first(1)
def test_the_rig_file_is_one_that_berth_takes(tmp_path, effect, words, shows):
    out, _ = generate(tmp_path, 11, "--effect", effect, "--size", "small")
    rig = plain_values(tomllib.loads((out / "rig.toml").read_text()))
    text = "".join(f"[{section}]\n" + "".join(
        f"{key} = {json.dumps(value)}\n" for key, value in keys.items()) for section, keys in rig.items())
    (tmp_path / "plain.toml").write_text('name = "hidden"\n' + text)
    done = command(words[0], tmp_path / "plain.toml", *words[1:])
    assert done.returncode == 0, done.stderr.decode()
    assert shows in done.stdout


@pytest.mark.parametrize("seed", range(40, 46))
def test_true_parameters_lie_within_the_tolerances(seed):
    made = scenarios.draw(seed, "none")
    print(f"again: python tests/hidden_effects/generate.py --seed {seed} --effect none --out A --truth B")
    off = [abs(value / (0.5 * (low + high)) - 1.0) / ((high - low) / (high + low))
           for _, value, low, high in detectability.tunable(made)]
    assert max(off) <= 1.0 and min(off) < max(off)
    assert detectability.assess(made) == []


def test_standstill_shows_the_floor():
    made = next(s for s in (scenarios.draw(seed, "none") for seed in range(60, 80)) if "standstill" in s.runs)
    result = made.runs["standstill"].result
    for channel, values in (("force_N", result["force_N"]), ("robot_position_m", result["robot_m"])):
        assert np.std(values) == pytest.approx(made.noise[channel].rms, rel=0.25), f"seed {made.seed}"


@pytest.mark.long
def test_detectability_of_a_bias_is_the_textbooks():
    made = scenarios.draw(3, "sensor.bias", "large")
    bias_N = made.effects[0][2].parameters["bias_N"]
    noise = made.noise["force_N"] = Noise(0.5, 0.0, 1.0, 0.0)
    T_s, ticks = made.base["period_s"], len(made.runs["record"].operator_N)
    added = {c: np.zeros(ticks) for c in detectability.measured_channels(made)}
    added["force_N"] = np.full(ticks, bias_N)
    chi2 = np.sum(detectability.stacked(made, added) ** 2)
    assert chi2 == pytest.approx(ticks * bias_N**2 / 0.25, rel=1e-9)
    assert 0.5 * chi2 < detectability.assess(made)[0]["chi2"] <= chi2 * 1.001
    added["force_N"] = np.random.default_rng(0).standard_normal(ticks)
    chi2 = np.sum(detectability.stacked(made, added) ** 2)
    assert chi2 == pytest.approx(np.sum(added["force_N"] ** 2) / 0.25, rel=1e-9), "Parseval"
    assert np.allclose(noise.spectrum(np.fft.rfftfreq(ticks, T_s), T_s), 0.25)


@pytest.mark.slow
def test_what_the_other_effect_makes_up_for_is_not_shown():
    """A second mass that a heavier object does the most of; beside the object's true parameters it would be shown."""
    made = scenarios.draw(641154, kind="two_of_one_block")
    assert [name for name, _, _ in made.effects] == ["object.second_mode", "object.parameters"]
    second, heavier = detectability.assess(made)
    assert heavier["detectable"] and not second["detectable"]
    everything = detectability.with_effects(made, made.runs["record"], [change for _, _, change in made.effects])
    fixed, _ = detectability.Tuning(made).absorb(everything, [made.effects[1][2]])
    assert fixed > 10.0 * detectability.CHI2_MARGIN > 10.0 * second["chi2"]


@pytest.mark.long
def test_what_the_tolerances_allow_is_not_an_effect():
    made = scenarios.draw(12, "object.cubic_stiffness", "large")
    tuning = detectability.Tuning(made)
    within = detectability.with_effects(made, made.runs["record"], [])
    name, value, low, high = next(t for t in detectability.tunable(made) if t[0] == "object_stiffness_N_per_m")
    nearer = value + 0.2 * ((low if value - low > high - value else high) - value)
    other = detectability.with_effects(made, made.runs["record"], [Change({name: nearer}, {})])
    added = {c: other[c] - within[c] for c in detectability.measured_channels(made)}
    chi2 = np.sum(detectability.stacked(made, added) ** 2)
    assert tuning.absorb(other, [])[0] < 1e-6 * chi2


@pytest.mark.slow
def test_a_force_scaled_by_a_sensor_is_an_object_scaled_within_its_tolerances():
    """To first order a resonance that moves by its width is not the re-tuned one: Gauss-Newton has to get there."""
    made = next(s for s in (scenarios.draw(seed, "sensor.gain", "small") for seed in range(7046, 7100))
                if not s.base["contact"])
    factor = made.effects[0][2].parameters["gain"]
    scaled = {name: made.base[name] * factor for name in (
        "object_mass_kg", "object_damping_N_s_per_m", "object_stiffness_N_per_m", "spring_stiffness_N_per_m",
        "spring_damping_N_s_per_m")}
    run = made.runs["record"]
    by_gain = detectability.with_effects(made, run, [change for _, _, change in made.effects])
    by_object = detectability.with_effects(made, run, [Change(scaled, {})])
    difference = {c: by_gain[c] - by_object[c] for c in by_gain}
    added = {c: by_gain[c] - detectability.with_effects(made, run, [])[c] for c in by_gain}
    assert np.std(difference["force_N"]) < 1e-6 * np.std(added["force_N"]), made.seed
    allowed = {name: (low, high) for name, _, low, high in detectability.tunable(made)}
    assert all(allowed[name][0] < value < allowed[name][1] for name, value in scaled.items()), made.seed
    assert detectability.assess(made)[0]["chi2"] < 10.0 < np.sum(detectability.stacked(made, added) ** 2), made.seed


@pytest.mark.slow
def test_an_object_that_a_scaled_sensor_looks_like_is_found_from_afar():
    """1.6e6 away in chi2, and along the tolerance of a stiffness that hardly matters: an optimiser may crawl there."""
    made = scenarios.draw(181049, "sensor.gain", "medium")
    begin = equivalents.beginnings(made, "object.parameters", {})[0]
    assert equivalents.chi2_between(made, {"object.parameters": begin}) < 1e-6


def test_every_effect_of_the_library_can_be_drawn():
    listed = {one["effect"] for one in json.loads(command("effects", "--json").stdout)}
    assert {*LIBRARY, *ASKED_FOR} == listed and not {*LIBRARY} & {*ASKED_FOR}
    blocks = {name.split(".")[0] for name in LIBRARY}
    assert blocks == {"robot", "manipulator", "object", "sensor", "loop"}
