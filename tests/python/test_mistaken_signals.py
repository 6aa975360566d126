"""`berth diagnose` and signals with the wrong sign or in thousandths: told with the line to write into the rig file,
and put right by it. The records come from a run of `ess`, written anew as CSV."""

import json
import re

import numpy as np
import pytest
import scipy.signal
from conftest import EXIT_DONE, EXIT_INPUT, RIG_FOLDER, command

RUN = ["--set", "run.duration_s=20", "--set", "profile.kind=multisine", "--set", "profile.amplitude_m=0.01", "--set",
       "profile.frequency_end_Hz=4", "--set", "sensor.noise_N=0.2", "--set", "robot.feedback_noise_m=5e-6"]


@pytest.fixture(scope="module")
def columns(tmp_path_factory):
    """{name: values} of a run in which all is as the rig says."""
    folder = tmp_path_factory.mktemp("run")
    assert command("run", "ess", *RUN, "--out", folder).returncode == EXIT_DONE
    assert command("diagnose", folder / "ess.ulg", "--rig", "ess", "--out", folder).returncode == EXIT_DONE
    with (folder / "series.csv").open() as file:
        names = file.readline().strip().split(",")
        values = np.loadtxt(file, delimiter=",")
    assert any(name.startswith("operator") for name in names)
    return {name: values[:, i] for i, name in enumerate(names)
            if name == "t_s" or name.endswith(("force_N", "position_m"))}


def write(path, columns):
    np.savetxt(path, np.column_stack(list(columns.values())), delimiter=",", header=",".join(columns), comments="",
               fmt="%.12g")
    return path


def diagnosed(out, *arguments):
    done = command("diagnose", *arguments, "--out", out)
    assert done.returncode == EXIT_DONE, done.stderr.decode()
    return json.loads((out / "diagnosis.json").read_text())


def part_of(columns, block):
    wanted = {"robot": ["command_position_m", "robot_position_m"], "force": ["command_position_m", "force_N"],
              "all": list(columns)}[block]
    return {name: values for name, values in columns.items() if name == "t_s" or name in wanted}


@pytest.fixture(scope="module")
def good(columns, tmp_path_factory):
    """{block: diagnosis} without any mistake."""
    folder = tmp_path_factory.mktemp("good")
    return {block: diagnosed(folder / block, write(folder / f"{block}.csv", part_of(columns, block)), "--rig", "ess")
            for block in ("robot", "force", "all")}


MISTAKES = [("robot", "robot_position_m", -1.0, "opposite sign"), ("robot", "robot_position_m", 1e3, "in mm"),
            ("robot", "command_position_m", 1e3, "in mm"), ("robot", "robot_position_m", 100.0, "in cm"),
            ("robot", "command_position_m", 1.0 / 0.0254, "in inches"), ("force", "force_N", -1.0, "opposite sign"),
            ("force", "force_N", 1e-3, "in kN"), ("force", "command_position_m", 1e3, "in mm"),
            ("all", "force_N", -1.0, "opposite sign"), ("all", "force_N", 1.0 / 9.80665, "in kgf"),
            ("all", "force_N", 1.0 / 4.4482216, "in lbf"), ("all", "command_position_m", 1e3, "in mm"),
            ("all", "operator_position_m", -1.0, "opposite sign"), ("all", "operator_position_m", 1e3, "in mm")]


@pytest.mark.parametrize("block, signal, factor, what", MISTAKES)
def test_a_sign_or_a_unit_is_told_and_the_cure_cures(columns, good, tmp_path, block, signal, factor, what):
    spoilt = part_of(columns, block)
    spoilt = spoilt | {signal: factor * spoilt[signal]}
    record = write(tmp_path / "record.csv", spoilt)
    done = command("diagnose", record, "--rig", "ess", "--out", tmp_path / "out")
    message = done.stderr.decode()
    assert done.returncode == EXIT_INPUT and done.stdout == b"" and message.count("\n") == 1, message
    assert f"{record}:1: " in message and f"{signal}" in message and what in message, message
    cures = dict(re.findall(r"\[signals\] (\w+) = (\{[^}]*\})", message))
    assert signal in cures, message
    rig = tmp_path / "cured.toml"
    rig.write_text((RIG_FOLDER / "ess.toml").read_text() + f"\n[signals]\n{signal} = {cures[signal]}\n")
    found = diagnosed(tmp_path / "out", record, "--rig", rig)
    wanted = good[block]
    assert found["verdict"] == wanted["verdict"]
    for name, residual in wanted["residual"].items():
        assert found["residual"][name]["fit"]["before"] == pytest.approx(residual["fit"]["before"], rel=0.02), name


def test_who_says_that_it_is_right_is_only_told(columns, tmp_path):
    spoilt = part_of(columns, "robot")
    spoilt["robot_position_m"] = -spoilt["robot_position_m"]
    rig = tmp_path / "sure.toml"
    rig.write_text((RIG_FOLDER / "ess.toml").read_text()
                   + '\n[signals]\nrobot_position_m = { column = "robot_position_m", scale = 1 }\n')
    found = diagnosed(tmp_path / "out", write(tmp_path / "record.csv", spoilt), "--rig", rig)
    assert any("opposite sign" in note and "scale = -1" in note for note in found["notes"])


@pytest.mark.parametrize("unit, in_N", [("kgf", 9.80665), ("lbf", 4.4482216)])
def test_a_force_that_may_be_in_another_unit_or_a_wrong_stiffness_is_told(columns, good, tmp_path, unit, in_N):
    spoilt = part_of(columns, "force")
    spoilt["force_N"] = spoilt["force_N"] / in_N
    record = write(tmp_path / "record.csv", spoilt)
    found = diagnosed(tmp_path / "out", record, "--rig", "ess")
    [note] = [note for note in found["notes"] if f"were in {unit}" in note]
    [cure] = re.findall(r"force_N = (\{[^}]*\})", note)
    rig = tmp_path / "cured.toml"
    rig.write_text((RIG_FOLDER / "ess.toml").read_text() + f"\n[signals]\nforce_N = {cure}\n")
    cured = diagnosed(tmp_path / "out", record, "--rig", rig)
    assert cured["verdict"] == good["force"]["verdict"]
    assert not any("were in" in note for note in cured["notes"] + good["force"]["notes"])


def test_another_zero_of_the_reports_is_told_and_the_cure_cures(columns, good, tmp_path):
    spoilt = part_of(columns, "robot")
    spoilt["robot_position_m"] = spoilt["robot_position_m"] + 0.02
    record = write(tmp_path / "record.csv", spoilt)
    found = diagnosed(tmp_path / "out", record, "--rig", "ess")
    [note] = [note for note in found["notes"] if "another zero" in note]
    assert "0.02 m throughout" in note
    [cure] = re.findall(r"robot_position_m = (\{[^}]*\})", note)
    rig = tmp_path / "cured.toml"
    rig.write_text((RIG_FOLDER / "ess.toml").read_text() + f"\n[signals]\nrobot_position_m = {cure}\n")
    cured = diagnosed(tmp_path / "out", record, "--rig", rig)
    assert cured["verdict"] == good["robot"]["verdict"]
    for notes in (cured["notes"], good["robot"]["notes"]):
        assert not any("another zero" in note for note in notes)


@pytest.mark.parametrize("offset_N", [20.0, -35.0])
def test_another_zero_of_the_force_is_told_and_the_cure_cures(columns, good, tmp_path, offset_N):
    spoilt = columns | {"force_N": columns["force_N"] + offset_N}
    record = write(tmp_path / "record.csv", spoilt)
    found = diagnosed(tmp_path / "out", record, "--rig", "ess")
    [note] = [note for note in found["notes"] if "another zero" in note]
    assert f"force_N has {offset_N:.2g}" in note
    [cure] = re.findall(r"force_N = (\{[^}]*\})", note)
    rig = tmp_path / "cured.toml"
    rig.write_text((RIG_FOLDER / "ess.toml").read_text() + f"\n[signals]\nforce_N = {cure}\n")
    cured = diagnosed(tmp_path / "out", record, "--rig", rig)
    assert cured["verdict"] == good["all"]["verdict"]
    # A bias that the manipulator felt is one.
    felt = diagnosed(tmp_path / "out", write(tmp_path / "felt.csv", columns), "--rig", "ess", "--set",
                     f"sensor.bias_N={-offset_N}")
    assert any(cause["effect"] == "sensor.bias" for cause in felt["causes"])
    for notes in (cured["notes"], felt["notes"]):
        assert not any("another zero" in note for note in notes)


def test_exchanged_positions_are_told_and_the_cure_cures(columns, good, tmp_path):
    both = part_of(columns, "robot")
    spoilt = {"t_s": both["t_s"], "command_position_m": both["robot_position_m"],
              "robot_position_m": both["command_position_m"]}
    record = write(tmp_path / "record.csv", spoilt)
    done = command("diagnose", record, "--rig", "ess", "--out", tmp_path / "out")
    message = done.stderr.decode()
    assert done.returncode == EXIT_INPUT and f"{record}:1: " in message and "exchanged" in message, message
    cures = re.findall(r"(\w+) = (\{[^}]*\})", message)
    assert [name for name, _ in cures] == ["command_position_m", "robot_position_m"], message
    rig = tmp_path / "cured.toml"
    rig.write_text((RIG_FOLDER / "ess.toml").read_text() + "\n[signals]\n"
                   + "".join(f"{name} = {cure}\n" for name, cure in cures))
    found = diagnosed(tmp_path / "out", record, "--rig", rig)
    assert found["verdict"] == good["robot"]["verdict"]
    assert not any("exchanged" in note for note in found["notes"])


DRIVE = """
name = "drive"
[loop]
rate_Hz = 500
[manipulator]
mass_kg = 2.0
damping_N_s_per_m = 5.0
stiffness_N_per_m = {stiffness}
[operator]
interface = "force"
"""


@pytest.mark.parametrize("stiffness", [0.0, 400.0])
@pytest.mark.parametrize("factor, what", [(-1.0, "opposite sign"), (1e-3, "in kN"), (1.0, None)])
def test_the_operators_force(tmp_path, factor, what, stiffness):
    random = np.random.default_rng(5)
    force_N = scipy.signal.lfilter(*scipy.signal.butter(2, 0.02), random.normal(0, 200, 10000))
    plant = scipy.signal.cont2discrete(([1.0], [2.0, 5.0, stiffness]), 0.002)
    position_m = scipy.signal.lfilter(plant[0].ravel(), plant[1], force_N) + random.normal(0, 1e-6, len(force_N))
    record = write(tmp_path / "record.csv", {"t_s": 0.002 * np.arange(len(force_N)),
                                             "operator_force_N": factor * force_N, "command_position_m": position_m})
    rig = tmp_path / "drive.toml"
    rig.write_text(DRIVE.format(stiffness=stiffness))
    done = command("diagnose", record, "--rig", rig, "--out", tmp_path / "out")
    if what is None:
        assert done.returncode == EXIT_DONE, done.stderr.decode()
        return
    message = done.stderr.decode()
    assert done.returncode == EXIT_INPUT and "looks as if" in message, message
    assert re.search(f"operator_force_N (looks )?as if it (were|had the) {what}", message), message


@pytest.mark.parametrize("wrong", ["robot.dead_time_ms=60", "object.mass_kg=250",
                                   "object.stiffness_N_per_m=100000", "sensor.bias_N=200"])
def test_a_rig_file_that_is_far_off_is_no_wrong_sign(columns, tmp_path, wrong):
    record = write(tmp_path / "record.csv", part_of(columns, "all"))
    found = diagnosed(tmp_path / "out", record, "--rig", "ess", "--set", wrong)
    assert not any("looks as if" in note for note in found["notes"])


@pytest.mark.parametrize("rows", [1, -1])
def test_a_force_that_stands_in_another_row_is_told(columns, tmp_path, rows):
    """As sampled, or as logged after the tick: by the manipulator, and without one by a delay of whole rows."""
    shifted = columns | {"force_N": np.roll(columns["force_N"], -rows)}
    told = diagnosed(tmp_path / "all", write(tmp_path / "all.csv", shifted), "--rig", "ess")
    where = "before" if rows > 0 else "behind"
    assert any(f"force_N stands one row {where}" in note for note in told["notes"]), told["notes"]


def test_a_delay_of_whole_rows_may_be_that_of_the_log(columns, tmp_path):
    """Without an operator's signal there is no manipulator that tells."""
    shifted = part_of(columns | {"force_N": np.roll(columns["force_N"], 2)}, "force")
    told = diagnosed(tmp_path / "force", write(tmp_path / "force.csv", shifted), "--rig", "ess")
    assert "sensor.delay" in [cause["effect"] for cause in told["causes"] + told["alternatives"]]
    assert any("sensor.delay_ms is off by a whole number of rows, 2" in note for note in told["notes"]), told["notes"]


def test_a_force_in_its_row_is_not_told_as_shifted(good):
    assert not any("stands" in note for told in good.values() for note in told["notes"])
