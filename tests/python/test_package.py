"""The Python package: its numbers are the command's, bit for bit; its errors have parts; it lets other threads run."""

import json
import math
import resource
import threading
import time

import berth
import numpy as np
import pytest
from conftest import EXIT_DONE, ROOT, command, run_json, settings
from pyulog import ULog

CONTACT = {"object.kind": "contact", "object.damping_N_s_per_m": 30, "manipulator.initial_position_m": -0.01}
RIGS = [("ess", {}), ("ess", {"object.mass_kg": 190}), ("ess", {"prediction.enabled": True}), ("ess-pose", {}),
        ("concept-copper", {}), ("ess", {"run.dead_time_jump_s": 5, "run.dead_time_jump_ms": 15}), ("ess-beam", {})]
JUDGED = [*RIGS, ("ess", CONTACT), ("ess", {"robot.backlash_m": 0.001}), ("ess", {"loop.lost_sample_probability": 0.05}),
          ("ess", {"passivity.action": "damping"}), ("ess-berthing", {})]


def as_words(values):
    return settings({key: str(value).lower() if isinstance(value, bool) else value for key, value in values.items()})


def told(subcommand, rig, values, *more):
    done = command(subcommand, rig, "--json", *as_words(values), *more)
    assert done.returncode == EXIT_DONE, done.stderr.decode()
    return json.loads(done.stdout)


@pytest.mark.parametrize("name, values", RIGS)
def test_eigenvalues_are_those_of_the_command(name, values):
    found = berth.Rig.load(name, values).eigenvalues()
    of_command = told("eigen", name, values)
    assert found.growth_per_s == of_command["growth_per_s"]
    assert found.spectral_radius == of_command["spectral_radius"] == pytest.approx(np.abs(found.z).max(), rel=1e-14)
    assert found.stable == of_command["stable"]


@pytest.mark.long
@pytest.mark.parametrize("name, values", JUDGED)
def test_verdicts_are_those_of_the_command(name, values):
    found = berth.Rig.load(name, values).verdict()
    of_command = told("eigen", name, values)
    assert (found.kind, found.stable, found.because, found.advice) == tuple(
        of_command[key] for key in ("verdict", "stable", "because", "advice"))
    margin = of_command["margin"]
    assert (found.dead_time_margin_ms, found.modulus, found.dead_time_margin_is_open) == (
        margin["dead_time_margin_ms"], margin["modulus"], margin["dead_time_margin_is_open"])


@pytest.mark.parametrize("name, values", [("ess", {"object.mass_kg": 120, "run.duration_s": 5}),
                                          ("concept-copper", {"run.duration_s": 4}),
                                          ("ess", {"sensor.noise_N": 2, "run.seed": 7, "run.duration_s": 5})])
def test_a_run_is_that_of_the_command(name, values, tmp_path):
    of_command = told("run", name, values, "--out", tmp_path)
    run = berth.Rig.load(name, values).run(log=tmp_path / "python.ulg")
    assert (run.verdict.kind, run.verdict.because) == (of_command["verdict"], of_command["because"])
    for path in (tmp_path / f"{name}.ulg", tmp_path / "python.ulg"):
        ticks = ULog(str(path)).get_dataset("tick").data
        assert set(run.fields) == set(ticks)
        for field in run.fields:
            assert run[field].tobytes() == ticks[field].tobytes(), field
    log = berth.read_log(tmp_path / f"{name}.ulg")
    assert log.ticks.tobytes() == run.ticks.tobytes() and not log.cut
    assert log.rig.config_hash == run.rig.config_hash
    assert len(log.frames) == len(ULog(str(tmp_path / f"{name}.ulg")).get_dataset("can_frame").data["id"])


@pytest.mark.long
@pytest.mark.parametrize("name, values", [("ess", {}), ("ess", {"prediction.enabled": True}), ("concept-copper", {})])
def test_limits_are_those_of_the_command(name, values):
    found = berth.Rig.load(name, values).limits()
    of_command = told("limits", name, values)
    parameters = of_command["parameters"]
    assert set(found) == set(parameters) and len(found) >= 3
    for key, one in parameters.items():
        assert found[key].value == one["value"], key
        for side in ("below", "above"):
            limit = one[side]
            assert getattr(found[key], side) == (limit["value"] if isinstance(limit, dict) else limit), key


def test_a_map_is_that_of_the_command(tmp_path):
    x, y = ("robot.dead_time_ms", 2.0, 30.0, 15), ("object.mass_kg", 20, 200, 10)
    of_command = told("map", "ess", {}, "--x", "robot.dead_time_ms=2:30:15", "--y", "object.mass_kg=20:200:10", "--out",
                      tmp_path)
    found = berth.Rig.load("ess").map(x, y)
    table = np.genfromtxt(of_command["csv"], delimiter=",", names=True)
    for name in ("growth_per_s", "spectral_radius"):
        np.testing.assert_array_equal(getattr(found, name).ravel(), table[name])
    assert np.isnan(found.growth_per_s).any()  # a dead time below one period
    assert found.stable_share == of_command["stable_share"]


def test_compensation_is_that_of_the_command():
    found = berth.Rig.load("ess", {"object.mass_kg": 200}).compensate(duration_s=3)
    of_command = told("compensate", "ess", {"object.mass_kg": 200}, "--duration", "3")
    assert found.recommended == of_command["recommended"]
    assert [(one.method, one.worst_error) for one in found.methods] == [
        (one["method"], one["worst_error"]) for one in of_command["methods"]]


@pytest.mark.long
def test_a_diagnosis_is_that_of_the_command(tmp_path):
    hidden = {"robot.transfer_frequency_Hz": 12, "sensor.noise_N": 0.3, "run.duration_s": 20, "profile.kind": "multisine",
              "profile.amplitude_m": 0.01, "profile.duration_s": 18}
    berth.Rig.load("ess", hidden).run(log=tmp_path / "record.ulg", advice=False)
    rig = berth.Rig.load("ess")
    found = berth.diagnose(tmp_path / "record.ulg", rig)
    done = command("diagnose", tmp_path / "record.ulg", "--rig", "ess", "--json", "--out", tmp_path / "out")
    of_command = json.loads(done.stdout)
    assert found.verdict == of_command["verdict"] == "named" and len(found.causes) == len(of_command["causes"])
    for one, other in zip(found.causes, of_command["causes"]):
        assert one.effect == other["effect"]
        assert [(p.key, p.value) for p in one.parameters] == [(p["key"], p["value"]) for p in other["parameters"]]
    assert found.extended["robot.transfer_frequency_Hz"] == pytest.approx(12, rel=0.05)
    assert rig["robot.transfer_frequency_Hz"] != found.extended["robot.transfer_frequency_Hz"]
    assert found.blocks[0].error_after.shape == found.signals["time_s"].shape


def test_values_of_every_kind_go_in_and_come_out():
    rig = berth.Rig.load("ess")
    for key, value in (("object.mass_kg", 0.1 + 0.2), ("run.seed", 42), ("prediction.enabled", True),
                       ("passivity.action", "tank"), ("object.mass_kg", np.float64(12.5)), ("run.seed", np.int64(3)),
                       ("robot.interpolation", "linear")):
        rig[key] = value
        assert rig[key] == value and type(rig[key]) in (bool, int, float, str)
    assert set(rig) == set(berth.keys()) and len(rig) == len(berth.keys()) and "object.mass_kg" in rig
    assert berth.unit("object.mass_kg") == "kg" and berth.meaning("object.mass_kg")
    other = rig.copy()
    other["object.mass_kg"] = 50
    assert (rig["object.mass_kg"], other["object.mass_kg"]) == (12.5, 50)


def refuse(do):
    with pytest.raises(berth.InputError) as caught:
        do(berth.Rig.load("ess"))
    return caught.value


MISSING = '[object]\nmass_kg = 3\n'


@pytest.mark.parametrize("do, key, words", [
    (lambda rig: rig.__setitem__("object.mass_kg", -1), "object.mass_kg", "greater than 0"),
    (lambda rig: rig.__setitem__("object.mass", 1), "object.mass", "object.mass_kg"),
    (lambda rig: rig.__setitem__("object.mass_kg", math.nan), "object.mass_kg", "nan"),
    (lambda rig: rig.__setitem__("object.mass_kg", math.inf), "object.mass_kg", "inf"),
    (lambda rig: rig.__setitem__("object.mass_kg", "heavy"), "object.mass_kg", "must be a number"),
    (lambda rig: rig.__setitem__("object.kind", "gone"), "object.kind", '"gripped"'),
    (lambda rig: rig.__getitem__("object.mass"), "object.mass", "object.mass_kg"),
    (lambda rig: rig.update({"object.mass_kg": 3, "robot.dead_time_ms": -1}), "robot.dead_time_ms", "must be"),
    (lambda rig: rig.map(("object.mass", 1, 2, 3), ("robot.dead_time_ms", 5, 6, 2)), "object.mass", "object.mass_kg"),
    (lambda rig: rig.map(("object.mass_kg", 1, math.inf, 3), ("robot.dead_time_ms", 5, 6, 2)), "object.mass_kg", "finite"),
    (lambda rig: rig.map(("object.kind", 1, 2, 3), ("robot.dead_time_ms", 5, 6, 2)), "object.kind", "no number"),
    (lambda rig: berth.Rig.load("nope"), "", "no shipped rig"),
    (lambda rig: berth.Rig.load("ess", robot="ur10"), "", "no robot preset"),
    (lambda rig: berth.Rig.parse(MISSING).verdict(), "manipulator.mass_kg", "is missing"),
    (lambda rig: berth.Rig.load("ess", {"loop.lost_sample_probability": 0.1}).eigenvalues(), "", "verdict()"),
    (lambda rig: berth.read_log("/dev/null"), "", "/dev/null"),
    (lambda rig: berth.diagnose("nothing.csv", rig), "", "nothing.csv"),
    (lambda rig: berth.diagnose("nothing.csv", rig, without=["robot.ghost"]), "", "robot.ghost"),
])
def test_what_is_wrong_is_said_with_its_key(do, key, words):
    error = refuse(do)
    assert error.key == key and words in str(error) and "\n" not in str(error)


def test_a_refused_change_leaves_the_rig_as_it_was():
    rig = berth.Rig.load("ess", {"object.mass_kg": 90})
    before = rig.config_hash
    for change in (lambda: rig.__setitem__("object.mass_kg", -1),
                   lambda: rig.update({"object.mass_kg": 3, "robot.dead_time_ms": -1})):
        with pytest.raises(berth.InputError):
            change()
    assert rig.config_hash == before and rig["object.mass_kg"] == 90


@pytest.mark.parametrize("value", [None, [1], {}, 1j, object()])
def test_a_value_of_no_kind_is_a_type_error(value):
    rig = berth.Rig.load("ess")
    with pytest.raises(TypeError):
        rig["object.mass_kg"] = value


def test_an_error_in_a_file_has_its_line(tmp_path):
    path = tmp_path / "my.toml"
    path.write_text('base = "ess"\n[object]\nmass_kg = -3\n')
    with pytest.raises(berth.InputError) as caught:
        berth.Rig.load(path)
    error = caught.value
    assert (error.file, error.line, error.key) == (str(path), 3, "object.mass_kg")
    with pytest.raises(berth.InputError) as caught:
        berth.Rig.parse('[object]\nmass_kg = "3"\n')
    assert caught.value.remedy == "write it without quotes and without its unit"


def test_other_threads_run_while_a_rig_does():
    """A counter that waits for the interpreter stands still where a run keeps it."""
    rig = berth.Rig.load("ess", {"run.duration_s": 600})
    counted, done = [], threading.Event()

    def count():
        while not done.is_set():
            counted.append(time.perf_counter())
            time.sleep(0.001)

    counter = threading.Thread(target=count)
    counter.start()
    begin = time.perf_counter()
    rig.run(advice=False)
    end = time.perf_counter()
    done.set()
    counter.join()
    assert sum(begin < at < end for at in counted) > 20


def test_two_threads_run_two_rigs():
    masses = (80, 120)
    alone = [berth.Rig.load("ess", {"object.mass_kg": mass, "run.duration_s": 20}).run(advice=False) for mass in masses]
    together = [None, None]

    def go(i):
        together[i] = berth.Rig.load("ess", {"object.mass_kg": masses[i], "run.duration_s": 20}).run(advice=False)

    threads = [threading.Thread(target=go, args=(i,)) for i in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for one, other in zip(alone, together):
        assert one.ticks.tobytes() == other.ticks.tobytes()
    assert together[0].ticks.tobytes() != together[1].ticks.tobytes()


def test_eigenvalues_take_a_fiftieth_of_starting_the_command():
    """As a ratio of times on this machine: once the command, against the mean of many calls."""
    begin = time.perf_counter()
    for _ in range(5):
        told("eigen", "ess", {})
    of_command_s = (time.perf_counter() - begin) / 5
    rig, count = berth.Rig.load("ess"), 1000
    begin = time.perf_counter()
    for i in range(count):
        rig["object.mass_kg"] = 50 + 0.1 * i
        rig.eigenvalues()
    assert (time.perf_counter() - begin) / count < of_command_s / 50


def test_a_run_takes_no_longer_than_that_of_the_command(tmp_path):
    """As a ratio of the least processor time of several: with its log, at most 1.1 of the whole command."""
    rig = berth.Rig.load("ess")

    def least_s(work, who):
        def once():
            begin = resource.getrusage(who)
            work()
            end = resource.getrusage(who)
            return end.ru_utime + end.ru_stime - begin.ru_utime - begin.ru_stime
        return min(once() for _ in range(7))

    of_command_s = least_s(lambda: run_json("ess", tmp_path), resource.RUSAGE_CHILDREN)
    here_s = least_s(lambda: rig.run(log=tmp_path / "here.ulg", advice=False), resource.RUSAGE_SELF)
    print(f"{here_s:.4f} s here, {of_command_s:.4f} s of the command: {here_s / of_command_s:.2f}")
    assert here_s < 1.1 * of_command_s


def test_what_a_notebook_shows(tmp_path):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    rig = berth.Rig.load("ess", {"run.duration_s": 2})
    run = rig.run()
    assert "stable" in rig._repr_html_() and "<b" in run._repr_html_()
    shown = [rig.eigenvalues().plot(), *run.plot(),
             rig.map(("robot.dead_time_ms", 5, 30, 6), ("object.mass_kg", 20, 200, 5)).plot()]
    for axes in shown:
        assert axes.get_xlabel() or axes.get_ylabel()
        assert axes.has_data()
    labels = shown[-1].get_xlabel(), shown[-1].get_ylabel()
    assert labels == ("robot.dead_time (ms)", "object.mass (kg)")
    plt.close("all")


def test_matlab_reads_a_run(tmp_path):
    from scipy.io import loadmat
    run = berth.Rig.load("ess", {"run.duration_s": 1}).run(advice=False)
    run.to_mat(tmp_path / "run.mat")
    read = loadmat(tmp_path / "run.mat")
    np.testing.assert_array_equal(read["force_N"].ravel(), run["force_N"])
    np.testing.assert_array_equal(read["time_s"].ravel(), run.time_s)


def test_all_that_is_public_says_what_it_is():
    for name in berth.__all__:
        thing = getattr(berth, name)
        if callable(thing):
            assert thing.__doc__, name
    for name, thing in vars(berth.Rig).items():
        if callable(thing) and not name.startswith("_"):
            assert thing.__doc__ or name == "copy", name
    package = ROOT / "sim_hal" / "python" / "berth"
    assert (package / "py.typed").exists()
