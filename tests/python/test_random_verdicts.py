"""200 rigs drawn at random: `run`, `eigen` and `limits` give the same verdict, or the output says why they do not; none is
undetermined without a reason. BERTH_TEST_SEED draws others."""

import os

import pytest
from conftest import EXIT_DONE, EXIT_INPUT, command, one_json_object
from random_rigs import KINDS, draw, toml

SEED = int(os.environ.get("BERTH_TEST_SEED", "20261"))
COUNT, COUNT_OF_ALL = 32, 200  # what every run of the tests draws, and what the slowest do
SUBCOMMANDS = ("run", "eigen", "limits")

# Why a run may show another thing than the model: one of these stands in its `because`.
REASONS = ["noise, limits, events of the run and the size of the motion are not in it", "what stays in contact grows",
           "of a tool that stays in contact", "what grows has not come up yet", "never came to running",
           "the tool never came to the object", "never with the object gripped", "held by the limits",
           "harmonic balance predicts", "the motion comes to rest", "the motion falls although limits bound it"]
# `limits` takes the loop as if it did not change, `eigen` and `run` as it is.
SMALL = "another start may do otherwise"  # of a loop without eigenvalues


def told(subcommand, file, methods):
    """The JSON object, or the message of a refusal."""
    done = command(subcommand, file, "--json", *[word for method in methods for word in ("--with", method)],
                   *(["--no-log"] if subcommand == "run" else []))
    assert done.returncode in (EXIT_DONE, EXIT_INPUT), done.stderr.decode()
    return one_json_object(done.stdout) if done.returncode == EXIT_DONE else done.stderr.decode()


def check_one(told):
    """A verdict has a reason, one that is open what to do as well, one that is not agrees with `stable`."""
    assert told["because"], told["verdict"]
    stable = {"stable": [True], "unstable": [False], "limit cycle": [False], "driven": [True, None],
              "bouncing": [True, None], "undetermined": [None]}[told["verdict"]]
    assert told["stable"] in stable
    if told["stable"] is None:
        assert told["advice"]


def check_agreement(run, eigen, limits):
    models = [one for one in (eigen, limits) if not isinstance(one, str) and one["stable"] is not None]
    if len(models) == 2:
        assert eigen["stable"] is limits["stable"], (eigen["because"], limits["because"])
    for model in models:
        if run["stable"] is not None and run["stable"] is not model["stable"]:
            is_told = SMALL in model["because"] or any(reason in run["because"] for reason in REASONS)
            assert is_told, (run["because"], model["because"])


@pytest.mark.long
@pytest.mark.first(COUNT)
@pytest.mark.parametrize("index", range(COUNT_OF_ALL))
def test_all_verdicts_on_a_random_rig_agree_or_say_why(index, tmp_path):
    kind, rig, methods = draw(SEED, index)
    file = tmp_path / "random.toml"
    file.write_text(toml(rig))
    print(f"{kind}, --with {methods}; BERTH_TEST_SEED={SEED} .venv/bin/python -m pytest -m '' "
          f"'{__file__}::test_all_verdicts_on_a_random_rig_agree_or_say_why[{index}]'\n{file.read_text()}")
    found = {subcommand: told(subcommand, file, methods) for subcommand in SUBCOMMANDS}
    for subcommand, one in found.items():
        print(subcommand, one if isinstance(one, str) else [one[key] for key in ("verdict", "because", "advice")])
        if isinstance(one, str):
            assert subcommand != "run" and "z = 1" in one
        else:
            check_one(one)
    check_agreement(*found.values())


@pytest.mark.long
def test_the_draws_hold_enough_of_every_verdict(tmp_path):
    """Of the first 96; the others have the same odds."""
    counts = {}
    for index in range(96):
        kind, rig, methods = draw(SEED, index)
        (tmp_path / "random.toml").write_text(toml(rig))
        verdict = told("run", tmp_path / "random.toml", methods)["verdict"]
        counts[verdict] = counts.get(verdict, 0) + 1
    print(f"BERTH_TEST_SEED={SEED}: {counts}, {96 // len(KINDS)} of each kind of rig")
    least = {"stable": 20, "unstable": 15, "driven": 3, "bouncing": 3, "limit cycle": 3, "undetermined": 3}
    assert all(counts.get(verdict, 0) >= count for verdict, count in least.items()), counts
