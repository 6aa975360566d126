"""The scorer of hidden effects can fail: hand-made diagnoses, and programs that are right, guess, or say nothing."""

import json
import shlex
import subprocess
import sys

import pytest
from conftest import ROOT

FOLDER = ROOT / "tests" / "hidden_effects"
sys.path.insert(0, str(FOLDER))
import diagnosis  # noqa: E402
import fixed_records  # noqa: E402
import judge  # noqa: E402
import score  # noqa: E402
import tally  # noqa: E402
from generate import write  # noqa: E402
from scenario import ONE_AS_A_PAIR, choose, draw  # noqa: E402

CHANNELS = {"command_position_m": 1e-11, "robot_position_m": 5e-6, "force_N": 0.1}


def truth(*names, visible=True, richer=False, parameters=None):
    """A truth with these effects."""
    effects = [{"effect": name, "size": "large", "parameters": parameters or {"backlash_m": 1e-4},
                "detectability": {"detectable": visible}} for name in names]
    return {"effects": effects, "richer": richer, "floor_rms": CHANNELS}


def said(verdict, *names, value=1e-4, half=1e-5, name="backlash_m", **more):
    """A diagnosis with these causes."""
    causes = [{"effect": effect, "parameters": [
        {"key": f"{effect.split('.')[0]}.{name}", "value": value, "ci95": [value - half, value + half], "unit": "m"}]} for effect in names]
    residual = {"force_N": {"held_out": {"before": 1.0, "after": 0.105, "floor": 0.1}}}
    return diagnosis.parse({"verdict": verdict, "causes": causes, "residual": residual, **more})


BACKLASH, FRICTION = "robot.backlash", "object.coulomb_friction"


@pytest.mark.parametrize("true, found, outcome", [
    (truth(BACKLASH), said("named", BACKLASH), "right"),
    (truth(BACKLASH), said("named", FRICTION), "wrong"),
    (truth(BACKLASH), said("named", FRICTION, partial=True), "missed"),
    (truth(BACKLASH), said("named", BACKLASH, FRICTION), "wrong"),
    (truth(BACKLASH), said("unknown"), "missed"),
    (truth(BACKLASH), said("nothing_detectable"), "missed"),
    (truth(BACKLASH), said("one_of", BACKLASH, FRICTION), "missed"),
    (truth(BACKLASH), said("partly_explained", BACKLASH), "missed"),
    (truth(BACKLASH, richer=True), said("partly_explained", BACKLASH), "right"),
    (truth(BACKLASH, visible=False), said("nothing_detectable"), "quiet"),
    (truth(BACKLASH, visible=False), said("named", BACKLASH), "right"),
    (truth(BACKLASH, visible=False), said("named", FRICTION), "wrong"),
    (truth(), said("nothing_detectable"), "quiet"),
    (truth(), said("named", BACKLASH), "wrong"),
    (truth(BACKLASH, FRICTION), said("named", BACKLASH, FRICTION), "right"),
    (truth(BACKLASH, FRICTION), said("named", BACKLASH), "missed"),
    (truth("outside.object_drag"), said("named", FRICTION), "wrong"),
    (truth("outside.object_drag"), said("unknown"), "missed"),
])
def test_outcome(true, found, outcome):
    assert judge.judge(true, found).outcome == outcome


def test_a_name_that_the_record_cannot_tell_apart_is_not_wrong():
    assert judge.judge(truth("robot.lag"), said("named", "robot.dead_time"), ["robot.dead_time"]).outcome == "right"
    assert judge.judge(truth("robot.lag"), said("named", FRICTION), ["robot.dead_time"]).outcome == "wrong"


def test_several_that_the_record_cannot_tell_apart_are_rightly_offered():
    found = said("one_of", "object.parameters", alternatives=[{"effect": "sensor.gain"}])
    for true, other in [("sensor.gain", "object.parameters"), ("object.parameters", "sensor.gain")]:
        assert judge.judge(truth(true), found, [other]).outcome == "right"
        assert judge.judge(truth(true), found).outcome == "missed"
    assert judge.judge(truth("robot.lag"), found, ["object.parameters", "sensor.gain"]).outcome == "missed"
    more = said("one_of", "object.parameters", alternatives=[{"effect": "sensor.gain"}, {"effect": FRICTION}])
    assert judge.judge(truth("sensor.gain"), more, ["object.parameters"]).outcome == "missed"
    assert judge.admits_ignorance(found, ["object.parameters", "sensor.gain"])
    assert not judge.admits_ignorance(found, ["object.parameters"])


def test_intervals_and_gain():
    found = judge.judge(truth(BACKLASH), said("named", BACKLASH))
    assert found.intervals == [("robot.backlash.backlash_m", True)]
    assert found.gain == pytest.approx(1.05)
    assert judge.judge(truth(BACKLASH), said("named", BACKLASH, value=2e-4)).intervals[0][1] is False
    assert judge.judge(truth(BACKLASH), said("named", BACKLASH, name="gap")).intervals[0][1] is False


def test_phases_are_compared_modulo_a_turn():
    assert judge.inside("periodic_phase_rad", -3.1, 3.18, 3.1, 3.26)
    assert not judge.inside("periodic_N", -3.1, 3.18, 3.1, 3.26)


@pytest.mark.parametrize("found, nothing, ignorance", [
    (said("nothing_detectable"), True, False),
    (said("unknown"), True, True),
    (said("partly_explained", BACKLASH), False, True),
    (said("named", BACKLASH), False, False),
    (said("named", BACKLASH, partial=True), False, True),
    (said("one_of", BACKLASH, FRICTION), False, False),
])
def test_fault_free_and_left_out(found, nothing, ignorance):
    assert judge.names_nothing(found) == nothing
    assert judge.admits_ignorance(found) == ignorance
    assert judge.admits_ignorance(said("named", BACKLASH), [BACKLASH])


@pytest.mark.parametrize("content", [
    {}, {"verdict": "sure"}, {"verdict": "named", "causes": []}, {"verdict": "named", "causes": [{}]},
    {"verdict": "named", "causes": [{"effect": BACKLASH, "parameters": [{"key": "robot.backlash_m", "value": 1}]}]},
])
def test_a_file_against_the_schema_is_refused(content):
    with pytest.raises(diagnosis.BadDiagnosis):
        diagnosis.parse(content)


def test_bounds():
    assert tally.Bound("", 3, 300, 0.01, True).is_met()
    assert not tally.Bound("", 4, 300, 0.01, True).is_met()
    assert tally.Bound("", 90, 100, 0.9, False).is_met()
    assert not tally.Bound("", 89, 100, 0.9, False).is_met()
    assert not tally.Bound("", 0, 0, 0.9, False).is_met(), "a full run that shows nothing has not passed"
    assert tally.Bound("", 10, 12, 0.9, False).is_met(few=True)
    assert not tally.Bound("", 6, 12, 0.9, False).is_met(few=True)


# A program that diagnoses as it is told to: it finds the truth where the scorer has put it, beside the record.
FAKE = '''#!/usr/bin/env python3
import json, pathlib, sys
how = "{how}"
arguments = sys.argv[2:]
out = pathlib.Path(arguments[arguments.index("--out") + 1])
record = pathlib.Path(arguments[0]).parent
truth = json.loads((record.parent / record.name.replace("record", "truth") / "truth.json").read_text())
left_out = "--without" in arguments
shown = [e for e in truth["effects"] if e["detectability"]["detectable"] and not e["effect"].startswith("outside.")]
causes = [{{"effect": e["effect"], "parameters": [
    {{"key": "robot." + n, "value": v, "ci95": [v, v], "unit": ""}} for n, v in e["parameters"].items()]}} for e in shown]
held_out = {{c: {{"held_out": {{"before": 1.0, "after": f, "floor": f}}}} for c, f in truth["floor_rms"].items()}}
answer = {{"verdict": "named" if causes else "nothing_detectable", "causes": causes, "residual": held_out}}
if how == "silent" or left_out or truth["kind"] == "outside":
    answer = {{"verdict": "nothing_detectable" if how == "silent" else "unknown"}}
if how == "guess":
    answer = {{"verdict": "named", "causes": [{{"effect": "sensor.spikes"}}]}}
if how == "broken":
    sys.exit("no idea")
out.mkdir(parents=True, exist_ok=True)
(out / "diagnosis.json").write_text(json.dumps(answer))
'''


@pytest.fixture(params=[pytest.param(("right", 10), marks=pytest.mark.slow), pytest.param(("guess", 7), marks=pytest.mark.slow), ("silent", 4), ("broken", 2)], ids=lambda case: case[0])
def scored(request, tmp_path):
    """(how the program answers, exit code, score.json, score.md) of some records."""
    how, count = request.param
    program = tmp_path / "fake"
    program.write_text(FAKE.format(how=how))
    program.chmod(0o755)
    words = [sys.executable, FOLDER / "score.py", "--count", str(count), "--seed", "5", "--program", program,
             "--out", tmp_path / "score", "--jobs", "2"]
    done = subprocess.run([str(w) for w in words], capture_output=True, text=True, timeout=300, check=False)
    assert (tmp_path / "score" / "score.json").exists(), done.stderr
    content = json.loads((tmp_path / "score" / "score.json").read_text())
    return how, done.returncode, content, (tmp_path / "score" / "score.md").read_text()


@pytest.mark.long
def test_the_scorer_tells_programs_apart(scored):
    how, code, content, report = scored
    met = {bound["name"]: bound["met"] for bound in content["bounds"]}
    assert (code == 0) == (how == "right"), report
    if how == "guess":
        assert not met["confident wrong name"] and not met["fault-free: nothing named"]
        assert not met["true effect not in the library: said so"]
    if how == "silent":
        assert met["confident wrong name"] and met["fault-free: nothing named"]
        assert not met["named when detectable"] and not met["two effects: both named"]
    if how == "broken":
        assert "exit code 1: no idea" in report and not met["named when detectable"]


@pytest.mark.slow
def test_which_names_a_record_cannot_tell_apart():
    import equivalents
    import scenario

    made = scenario.draw(21, "robot.gain", "large")
    gain = made.effects[0][2].parameters["gain"]
    found = equivalents.chi2_between(made, {"robot.gain": {"gain": 1.0 + 0.9 * (gain - 1.0)}})
    assert found < equivalents.CHI2_APART, "itself, from a start that is a tenth off"
    assert equivalents.chi2_between(made, {"robot.dead_time": {"dead_time_ms": 10.0}}) > 1000.0
    assert equivalents.chi2_between(made, {"sensor.spikes": {"spike_N": 1.0}}) is None
    assert not equivalents.inseparable_alone(made, ["robot.backlash"], {"robot.backlash": {"backlash_m": 1e-4}})
    made = scenario.draw(22, "sensor.lag", "tiny", noise="high")  # 0.15 ms: the low-pass within its tolerance
    told = {"sensor.delay": {"delay_ms": made.rig.values["sensor.delay_ms"] + 0.1}}
    assert equivalents.inseparable_alone(made, ["sensor.delay"], told) == ["sensor.delay"]


@pytest.mark.slow
def test_which_names_together_do_what_the_truth_does():
    """A clock that does not slip within the record is a dead time that is off and drifts, not either of them alone; and a
    lag that is not there does not stand in for the dead time."""
    import equivalents
    import scenario

    made = scenario.draw(137127, "loop.clock_drift", "small", "single")
    told = {"robot.dead_time": {"dead_time_ms": 16.72}, "robot.dead_time_drift": {"dead_time_drift_ms_per_s": 0.016}}
    names = list(told)
    assert equivalents.inseparable_alone(made, names, told) == []
    found = equivalents.inseparable_together(made, names, ["robot.gain"], told)
    assert found == names


def test_few_records_fail_a_bound_only_if_that_is_improbable():
    few = [tally.Bound("confident wrong name", wrong, 24, 0.01, True).as_json(True) for wrong in (0, 2, 4)]
    assert [one["met"] for one in json.loads(json.dumps(few))] == [True, True, False]


@pytest.mark.long
@pytest.mark.parametrize("place", [0, 1, 3, 6, 13])
@pytest.mark.first(2)
def test_a_record_is_made_again_by_the_line_that_tells_how(place, tmp_path):
    """One of each kind: single, fault-free, two, outside, two of one block."""
    seed, kind, effect, size = score.plan(7001, 20)[place]
    write(draw(seed, effect, size, kind), tmp_path / "first", tmp_path / "truth")
    program, script, *words = shlex.split(score.reproduction(seed, effect, size, kind))
    words[words.index("--out") + 1] = tmp_path / "again"
    words[words.index("--truth") + 1] = tmp_path / "again-truth"
    assert program == "python"
    subprocess.run([sys.executable, ROOT / script, *map(str, words)], check=True, stdout=subprocess.DEVNULL)
    assert (tmp_path / "again/record.csv").read_bytes() == (tmp_path / "first/record.csv").read_bytes()


@pytest.mark.parametrize("seed", range(8200, 8230))
def test_half_of_the_pairs_are_of_one_block(seed):
    assert [kind for _, kind, _, _ in score.plan(seed, 300)].count("two_of_one_block") == 15
    for kind, is_of_one_block in (("two", False), ("two_of_one_block", True)):
        _, names, size, _ = choose(seed, kind=kind)
        assert len({name.split(".")[0] for name in names}) == (1 if is_of_one_block else 2)
        assert len(set(names)) == 2 and set(names) not in ONE_AS_A_PAIR and size in ("large", "medium")


def test_a_score_that_was_cut_short_goes_on_where_it_ended(tmp_path):
    program, path, jobs = tmp_path / "berth", tmp_path / "records.jsonl", [[1, "single", None, None]]
    program.write_text("one")
    score.Journal(path, program, jobs).add({"seed": 1})
    with path.open("a") as file:
        file.write('{"seed": 2, "par')  # as the power went
    again = score.Journal(path, program, jobs)
    assert again.records == [{"seed": 1}]
    again.add({"seed": 3})
    assert score.Journal(path, program, jobs).records == [{"seed": 1}, {"seed": 3}]
    assert score.Journal(path, program, [*jobs, [2, "single", None, None]]).records == []
    score.Journal(path, program, jobs).add({"seed": 1})
    program.write_text("another")
    assert score.Journal(path, program, jobs).records == []


def test_a_failure_of_the_scorer_itself_is_a_record_that_failed(monkeypatch, tmp_path):
    def broken(*_):
        raise KeyError("robot_position_m")

    monkeypatch.setattr(score, "score_one", broken)
    found = score.score_safely((7, "single", "robot.lag", "small"), "berth", tmp_path)
    assert found["outcome"] == "failed" and "robot_position_m" in found["error"] and found["seed"] == 7
    assert tally.markdown([found], True)


def test_every_kind_of_hidden_effect_has_a_fixed_record():
    effects = [effect for _, kind, effect, _ in score.FIXED if kind in ("single", "outside")]
    assert sorted([*effects, *fixed_records.WITHOUT]) == sorted([*score.LIBRARY, *score.OUTSIDE])
    assert {kind for _, kind, _, _ in score.FIXED} == set(score.PATTERN)


def record_of(kind, outcome, **more):
    return {"kind": kind, "outcome": outcome, "visible": ["robot.lag"], "names_nothing": False, **more}


@pytest.mark.parametrize("record, right", [
    (record_of("single", "right"), True), (record_of("single", "missed"), False), (record_of("two", "wrong"), False),
    (record_of("single", "right", visible=[]), False), (record_of("single", "failed"), False),
    (record_of("fault_free", "quiet", names_nothing=True), True), (record_of("fault_free", "quiet"), False),
    (record_of("outside", "missed", left_out_ok=True), True), (record_of("outside", "wrong", left_out_ok=True), False),
    (record_of("outside", "missed"), False),
])
def test_what_a_fixed_record_must_be(record, right):
    assert score.is_right(record) is right


@pytest.mark.long
@pytest.mark.parametrize("how, bad", [("right", []), ("silent", ["robot.backlash"])])
def test_fixed_records_tell_programs_apart(monkeypatch, tmp_path, how, bad):
    program = tmp_path / "fake"
    program.write_text(FAKE.format(how=how))
    program.chmod(0o755)
    monkeypatch.setattr(score, "FIXED", [(3, "fault_free", "none", None), (7, "single", "robot.backlash", "medium")])
    found = score.score_fixed(program, tmp_path, 1)
    assert [one["label"] for one in found] == bad
