"""Names, help and versions of commands, and sentences that are the same in all of them."""

import re

import pytest
from conftest import EXIT_DONE, EXIT_INPUT, SHORT, command, one_json_object, settings


@pytest.mark.parametrize("words, answer", [
    (["eigne", "ess"], "did you mean eigen?"),
    (["compnsate", "ess"], "did you mean compensate?"),
    (["eigen", "ess", "--robot", "ur10e"], "the nearest is ur10e-servoj"),
    (["eigen", "ess", "--robot", "dx200"], "the nearest is yaskawa-dx200"),
    (["eigen", "es"], "did you mean ess?"),
    (["check", "ess_beam"], "did you mean ess-beam?"),
    (["check", "ess-beem"], "did you mean ess-beam?"),
    (["check", "ess-baem"], "did you mean ess-beam?"),
    (["check", "ess", "--robot", "xyz"], "there is no such file; `berth robots` lists them"),
    (["check", "ess", "--robot", "abb_emg"], "the nearest is abb-egm"),
    (["check", "abs"], "and there is no such file\n"),
    (["run", "ess", "--objct", "beam"], "berth run has no such option; did you mean --object? these have it: init;"),
    (["init", "x.toml", "--objct", "beam"], "did you mean --object?"),
    (["run", "--with", "prediction", "passivity", "ess"],
     "berth: passivity: is a compensation and no rig; give --with once for each: --with passivity; see"),
    (["run", "ess", "--with", "prediction", "passivity"], "passivity: is a compensation and no rig; give --with once"),
    (["eigen", "--with", "prediction", "passivity"], "passivity: is a compensation and no rig; give --with once"),
    (["eigen", "concept_foam"], "did you mean concept-foam?"),
    (["run", "ess", "--with", "preduction"], "did you mean prediction?"),
    (["run", "ess", "--set", "robot.dead_tme_ms=3"], "the nearest known one is robot.dead_time_ms"),
    (["eigen", "ess", "--amplitud", "3"], "berth: --amplitud: berth eigen has no such option; did you mean --amplitude?"),
    (["eigen", "ess", "--ampl=3"], "berth: --ampl: berth eigen has no such option; did you mean --amplitude?"),
    (["run", "ess", "--sett", "x"], "berth: --sett: berth run has no such option; did you mean --set?; see berth run"),
    (["run", "ess", "--set", "x", "--rob", "abb-egm"], "--rob: berth run has no such option; did you mean --robot?"),
    (["run", "ess", "--amplitude", "3"], "--amplitude: berth run has no such option; these have it: eigen, map, limits"),
    (["rigs", "--object", "beam"], "--object: berth rigs has no such option; these have it: init"),
    (["run", "ess", "--quick"], "berth: --quick: berth run has no such option; see berth run --help"),
    (["run", "ess", "a", "b", "c"], "berth: a b c: too many words; berth run takes RIG; see"),
    (["run", "ess", "a"], "berth: a: one word too many; berth run takes RIG; see"),
    (["compare", "a", "b", "c"], "berth: c: one word too many; berth compare takes A B; see"),
    (["rigs", "ess"], "berth: ess: one word too many; berth rigs takes nothing; see"),
    (["map", "ess", "--vary", "mas"], "must be elasticity or mass (is \"mas\"); did you mean mass?"),
    (["map", "ess", "--x", "object.mas_kg=1:2:3", "--y", "robot.dead_time_ms=1:2:3"], "one is object.mass_kg"),
    (["diagnose", "x.ulg", "--rig", "ess", "--without", "robot.backlas"], "did you mean robot.backlash? berth effects"),
    (["diagnose", "x.ulg", "--rig", "es"], "did you mean ess?"),
    (["run", "ess", "--set", "object.kind=contct"], "did you mean contact?"),
    (["run", "ess", "--set", "object.stifness=5"], "nearest known one is object.stiffness_N_per_m"),
    (["run", "ess", "--set", "robot.dead_tme=5"], "nearest known one is robot.dead_time_ms"),
    (["run", "ess", "--set", "loop.freq=5"], "unknown key, and none is near; [loop] has "),
    (["run", "ess", "--set", "compensation.method=tank"], "unknown key, and none is near; `berth schema` lists all"),
    (["rths", "data", "--earthquake", "kob"], "did you mean kobe?"),
    (["init", "x.toml", "--robot", "ur10"], "the nearest is ur10e-servoj"),
    (["arm", "es"], "did you mean ess?"),
    (["--verison"], "did you mean --version?"),
    (["-v"], "did you mean --version?"),
    (["--hlp"], "did you mean --help?"),
    (["--jsn", "run", "ess"], "did you mean --json?"),
    (["--json", "run", "ess"], "options stand behind the subcommand, as berth run ... --json"),
    (["init", "x.toml", "--object", "beem"], "did you mean beam?"),
    (["completion", "BASH"], "did you mean bash?"),
    (["compare"], "A is missing: a .ulg file written by `berth run`, the folder of one run, or a rig's name: its newest run; see berth compare --help"),
    (["run", "none/x.toml"], "none/x.toml: cannot be read: there is no folder none"),
    (["run", "./none.toml"], "none.toml: cannot be read: there is no such file"),
    (["check", "."], ".: cannot be read: it is a folder"),
    (["summary", "scripts"], "scripts: cannot be read: it is a folder with 0 logs"),
    (["man", "rum"], "there are run, replay"),
    (["man", "rum"], "did you mean run?"),
])
def test_the_nearest_name_is_told(words, answer):
    done = command(*words)
    assert done.returncode == EXIT_INPUT
    assert answer in done.stderr.decode()


@pytest.mark.parametrize("words", [(), ("run",), ("eigen",)])
def test_help_is_a_word_too(words):
    asked = command("help", *words)
    assert asked.returncode == 0 and asked.stdout == command(*words, "--help").stdout and b"Usage: " in asked.stdout


@pytest.mark.parametrize("words", [("run",), ("eigen",), ("diagnose",), ("arm",)], ids=" ".join)
def test_help_promises_one_value_for_an_option_that_is_given_again(words):
    lines = command(*words, "--help").stdout.decode().split("\n  -")
    again = [line for line in lines if "may be given again" in line]
    assert again and not any("..." in line.splitlines()[0].partition("  ")[0] for line in again), again


def test_the_version_is_semantic_and_names_the_commit():
    shown = command("--version").stdout.decode()
    assert re.fullmatch(r"berth \d+\.\d+\.\d+(-[0-9a-z.]+)? \(([0-9a-f]{12}(-dirty)?|unknown)\)\n", shown), shown


@pytest.mark.parametrize("rig, sentence", [
    ("ess", "the dead time may grow by at least 157.5 ms before the loop is unstable; modulus 0.5389 (0: unstable)"),
    ("ess-50hz", "the dead time may grow by 170.9 ms before the loop is unstable; stable again from 212 to 230.2 ms of dead time, and in 9 more beyond; modulus 0.7320 (0: unstable)"),
])
def test_the_margin_is_the_same_sentence_everywhere(rig, sentence, tmp_path):
    """The page of a run prints the sentence of the JSON: see test_pages.py."""
    for words in (["run", rig, "--no-log", *settings(SHORT)], ["check", rig], ["eigen", rig], ["limits", rig],
                  ["map", rig, "--vary", "mass", "--grid", "4x4", "--out", tmp_path]):
        lines = command(*words).stdout.decode().splitlines()
        assert [line for line in lines if "margin  " in line][:1] == [f"  margin         {sentence}"], words
        assert one_json_object(command(*words, "--json").stdout)["margin"]["sentence"] == sentence


def test_a_loop_that_grows_has_no_margin(tmp_path):
    heavy = settings({"object.mass_kg": 210})
    for words in (["eigen", "ess"], ["limits", "ess"], ["map", "ess", "--vary", "mass", "--grid", "4x4", "--out", tmp_path]):
        done = command(*words, *heavy)
        assert done.returncode == EXIT_DONE and "  margin   " not in done.stdout.decode().split("most margin")[0]
        assert one_json_object(command(*words, *heavy, "--json").stdout)["margin"]["sentence"] is None


@pytest.mark.parametrize("changes, says", [
    ({"object.kind": "none", "object.mass_kg": 30}, "object.mass_kg"),
    ({"robot.clock_drift_ppm": 100}, 'robot.clock_drift_ppm: without effect, because robot.clock = "locked"'),
    ({"robot.clock_drift_ppm": 100, "robot.clock": "free"}, ""),
    ({}, ""),
], ids=str)
def test_a_key_without_effect_is_told_in_one_line(changes, says):
    done = command("check", "ess", "--json", *settings(changes))
    told = [line for line in done.stderr.decode().splitlines() if "without effect" in line]
    assert len(told) == bool(says) and says in "".join(told)


def test_a_robot_that_touches_nothing_has_no_delay_of_a_force():
    assert b"low-pass" not in command("run", "ess", "--no-log", "--set", "object.kind=none").stdout
