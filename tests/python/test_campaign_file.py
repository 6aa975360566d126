"""Campaign files: a message names file, line, key and remedy of each mistake; and what a right one means."""

import math

import berth
import numpy as np
import pytest
from berth.campaign import Spec, sampling
from campaigns import TOLERANCES
from conftest import EXIT_INPUT, command
from scipy import stats

HEAD = 'rig = "ess"\n[sample]\ncount = 64\n[vary]\n'
MASS = '"object.mass_kg" = '

WRONG = [
    ("rig = ess", None, "is no TOML"),
    ("", "rig", "is missing"),
    ('rig = "es"\n', "rig", "ess"),
    ("rig = 3\n", "rig", "must be text"),
    ('rig = "ess"\nsampel = 3\n', "sampel", "the nearest known one is sample"),
    ('rig = "ess"\n', "vary", "nothing varies"),
    ('rig = "ess"\nask = ["grwth"]\n' + HEAD[12:] + MASS + "[1, 2]", "ask", "the nearest known one is growth"),
    ('rig = "ess"\nrobot = "ur10"\n' + HEAD[12:] + MASS + "[1, 2]", "robot", "ur10e-servoj"),
    (HEAD + '"object.mass" = { from = 1, to = 2 }', "vary.object.mass", "the nearest known one is object.mass_kg"),
    (HEAD + MASS + '"heavy"', "vary.object.mass_kg", "must say how it varies"),
    (HEAD + MASS + '{ from = "1", to = 2 }', "vary.object.mass_kg", "without quotes"),
    (HEAD + MASS + "{ from = nan, to = 2 }", "vary.object.mass_kg", "finite number (is nan)"),
    (HEAD + MASS + "{ from = 1, to = inf }", "vary.object.mass_kg", "finite number (is inf)"),
    (HEAD + MASS + "{ from = 3, to = 2 }", "vary.object.mass_kg", "from must be less than to"),
    (HEAD + MASS + "{ from = -3, to = 2 }", "vary.object.mass_kg", "greater than 0"),
    (HEAD + MASS + "{ from = 1 }", "vary.object.mass_kg", "needs both ends"),
    (HEAD + MASS + "{ fron = 1, to = 2 }", "vary.object.mass_kg.fron", "the nearest known one is from"),
    (HEAD + MASS + "{ mean = 3 }", "vary.object.mass_kg", "sigma"),
    (HEAD + MASS + "{ median = 3, factor = 1 }", "vary.object.mass_kg", "greater than 1"),
    (HEAD + MASS + "{ from = 1, to = 2, likely = 3 }", "vary.object.mass_kg", "between from and to"),
    (HEAD + MASS + "{ from = 1, to = 2, count = 3 }", "vary.object.mass_kg", "count is for a grid"),
    (HEAD + MASS + "{ tolerance_percent = 0 }", "vary.object.mass_kg", "greater than 0"),
    (HEAD + MASS + "{ values = [] }", "vary.object.mass_kg", "must be a list"),
    (HEAD + MASS + '{ values = [1, "two"] }', "vary.object.mass_kg", "of one kind"),
    (HEAD + '"object.kind" = { from = 1, to = 2 }', "vary.object.kind", "is no number"),
    (HEAD + '"object.kind" = { values = ["gone"] }', "vary.object.kind", '"gripped"'),
    (HEAD + 'preset = { values = ["ur10"] }', "vary.preset", "ur10e-servoj"),
    (HEAD + 'record = { files = ["nothing*.csv"] }', "vary.record", "no file is called nothing*.csv"),
    (HEAD + MASS + "[1, 2]\n[set]\n" + MASS + "3", "vary.object.mass_kg", "has a value and varies"),
    (HEAD + MASS + "[1, 2]\n[set]\n\"object.stiffnes\" = 3", "set.object.stiffnes", "object.stiffness_N_per_m"),
    (HEAD + MASS + "[1, 2]\n[[correlate]]\nkeys = [\"a\", \"b\"]\ncoefficient = 0.5", "correlate.keys", "no number that varies"),
    ('rig = "ess"\n[sample]\ncount = "many"\n[vary]\n' + MASS + "[1, 2]", "sample.count", "whole number"),
    ('rig = "ess"\n[sample]\ncount = 0\n[vary]\n' + MASS + "[1, 2]", "sample.count", "at least 1"),
    ('rig = "ess"\n[sample]\ncount = 64\nmethod = "sobl"\n[vary]\n' + MASS + "[1, 2]", "sample.method", "is sobol"),
    ('rig = "ess"\n[sample]\ncount = 64\nseed = -1\n[vary]\n' + MASS + "[1, 2]", "sample.seed", "from 0 to"),
    ('rig = "ess"\n[sample]\ncount = 64\nmethod = "saltelli"\n[vary]\n' + MASS + "[1, 2]", "sample.count", "power of two"),
    ('rig = "ess"\n[sample]\nmethod = "grid"\n[vary]\n' + MASS + "{ from = 1, to = 2 }", "vary.object.mass_kg", "from, to and count"),
]


@pytest.mark.parametrize("text, key, words", WRONG)
def test_what_is_wrong_is_said_with_its_place(text, key, words):
    with pytest.raises(berth.InputError) as caught:
        Spec.parse(text, "my.toml")
    error = caught.value
    assert words in str(error) and "\n" not in str(error) and error.file == "my.toml"
    if key:
        assert error.key == key
        stands = next((i for i, line in enumerate(text.splitlines(), 1) if key.split(".")[-1].split("_")[0] in line), None)
        assert stands is None or error.line is not None


def test_the_line_is_the_one_of_the_key(tmp_path):
    file = tmp_path / "my.toml"
    file.write_text(HEAD + "\n[vary.robot]\n# late\ndead_time_ms = { from = 20, to = 10 }\n")
    done = command("campaign", file)
    assert done.returncode == EXIT_INPUT
    assert done.stderr.decode().startswith(f"berth: {file}:8: vary.robot.dead_time_ms: from must be less than to")


def unit(count=20000):
    return (np.arange(count) + 0.5) / count


@pytest.mark.parametrize("text, oracle", [
    ("{ from = 80, to = 120 }", stats.uniform(80, 40)),
    ("{ from = 80, to = 120, scale = \"log\" }", stats.loguniform(80, 120)),
    ("{ mean = 100, sigma = 5 }", stats.norm(100, 5)),
    ("{ mean = 100, sigma = 20, from = 80, to = 105 }", stats.truncnorm(-1, 0.25, 100, 20)),
    ("{ median = 100, factor = 1.2 }", stats.lognorm(math.log(1.2), scale=100)),
    ("{ from = 80, to = 120, likely = 90 }", stats.triang(0.25, 80, 40)),
    ("{ tolerance_percent = 10 }", stats.uniform(90, 20)),
])
def test_distributions_are_those_of_scipy(text, oracle):
    spec = Spec.parse(HEAD + MASS + text + "\n")
    own = berth.Rig.load("ess")["object.mass_kg"]
    found = spec.inputs[0].of_unit(unit())
    scale = own / 100.0 if "percent" in text else 1.0
    np.testing.assert_allclose(found, scale * oracle.ppf(unit()), rtol=1e-9)


def test_correlated_inputs_keep_their_distributions_and_rank_correlation():
    spec = Spec.parse(TOLERANCES.format(count=8192) + '[[correlate]]\nkeys = ["robot.dead_time_ms", "object.mass_kg"]\n'
                      "coefficient = -0.6\n")
    found = sampling.rows(spec, 0, 8192)
    mass, dead_time = found["object.mass_kg"], found["robot.dead_time_ms"]
    assert stats.kstest(mass, stats.norm(190, 10).cdf).statistic < 0.01
    assert stats.kstest(dead_time, stats.uniform(10, 15).cdf).statistic < 0.01
    # Gaussian copula: Spearman's rho = 6 / pi asin(r / 2)
    assert stats.spearmanr(mass, dead_time).statistic == pytest.approx(6 / math.pi * math.asin(-0.3), abs=0.01)


@pytest.mark.parametrize("method, count", [("sobol", 100), ("latin-hypercube", 100), ("saltelli", 128)])
def test_a_sample_is_the_same_in_any_batch(method, count):
    text = TOLERANCES.format(count=count).replace('"sobol"', f'"{method}"')
    text += "" if method == "saltelli" else '[[correlate]]\nkeys = ["robot.dead_time_ms", "object.mass_kg"]\ncoefficient = 0.3\n'
    spec = Spec.parse(text)
    whole = sampling.rows(spec, 0, count)
    for size in (1, 7, 33):
        for first in range(0, count, size):
            part = sampling.rows(spec, first, min(size, count - first))
            for name, values in part.items():
                np.testing.assert_array_equal(values, whole[name][first:first + size])


def test_a_grid_has_every_combination_once():
    spec = Spec.parse('rig = "ess"\n[sample]\nmethod = "grid"\n[vary]\n"object.mass_kg" = { from = 100, to = 200, count = 3 }\n'
                      '"object.kind" = ["gripped", "contact"]\n"run.seed" = { from = 1, to = 4, count = 4 }\n')
    found = sampling.rows(spec, 0, spec.count)
    assert spec.count == 24
    assert sorted(zip(*(values.tolist() for values in found.values()))) == sorted(
        (mass, kind, seed) for mass in (100.0, 150.0, 200.0) for kind in ("gripped", "contact") for seed in (1, 2, 3, 4))
    log = Spec.parse('rig = "ess"\n[sample]\nmethod = "grid"\n[vary]\n"object.mass_kg" = { from = 1, to = 100, count = 3, '
                     'scale = "log" }\n')
    np.testing.assert_allclose(sampling.rows(log, 0, 3)["object.mass_kg"], [1, 10, 100])


def test_every_sample_has_a_seed_of_its_own():
    one, other = (Spec.parse(TOLERANCES.format(count=4096).replace("seed = 7", f"seed = {seed}")) for seed in (7, 8))
    seeds = np.concatenate([sampling.seeds(one, 0, 4096), sampling.seeds(other, 0, 4096)])
    assert len(np.unique(seeds)) == 8192 and seeds.min() >= 0
    np.testing.assert_array_equal(sampling.seeds(one, 100, 5), sampling.seeds(one, 0, 105)[100:])


def test_a_spec_survives_its_json():
    import json
    spec = Spec.parse(TOLERANCES.format(count=64) + '"object.kind" = ["gripped"]\n')
    again = Spec.from_json(json.loads(json.dumps(spec.to_json())))
    assert again.identity == spec.identity
    assert sampling.rows(again, 0, 64).keys() == sampling.rows(spec, 0, 64).keys()
