"""Signals with the wrong sign, in another unit, from another zero or exchanged: told with the line to write into the rig
file, and put right by it."""

import json
import re
from dataclasses import dataclass

import numpy as np
import pytest
from checks import has_cause, near, no_note, note, offers
from conftest import EXIT_DONE, EXIT_INPUT, RIG_FOLDER, command
from make_manipulator import drive_of_2_kg
from make_run import MOVING, NOISY
from recipes import as_table, changed, run_with
from table import Refused, Row, each

RUN = as_table(log=run_with(MOVING | NOISY | {"run.duration_s": 20, "profile.frequency_end_Hz": 4}))
BLOCKS = {"robot": ["t_s", "command_position_m", "robot_position_m"], "force": ["t_s", "command_position_m", "force_N"]}


# --- what can be wrong with columns -------------------------------------------------------------------------------
def part_of(columns, block):
    return {name: values for name, values in columns.items() if block == "all" or name in BLOCKS[block]}


def as_they_are(columns, block):
    return part_of(columns, block)


def multiplied(columns, block, signal, factor):
    return part_of(columns | {signal: factor * columns[signal]}, block)


def shifted(columns, block, signal, offset):
    return part_of(columns | {signal: columns[signal] + offset}, block)


def in_another_row(columns, block, signal, rows):
    return part_of(columns | {signal: np.roll(columns[signal], rows)}, block)


def exchanged(columns, block):
    return {"t_s": columns["t_s"], "command_position_m": columns["robot_position_m"],
            "robot_position_m": columns["command_position_m"]}


def with_columns(by, block="all", **given):
    return changed(record=RUN, by=by, block=block, **given)


# --- told, and cured by what is told ------------------------------------------------------------------------------
@dataclass
class Mistake:
    """A record whose signals are wrong; `says`: words of the refusal, or of the note where the record is taken."""

    name: str
    record: object
    block: str
    says: tuple
    signals: tuple
    is_refused: bool = True
    within: float = 0.02  # of the residual that a record without the mistake leaves


def wrong(block, signal, factor, what):
    return Mistake(f"{signal} {what}, {block}", with_columns(multiplied, block, signal=signal, factor=factor), block,
                   (what, signal), (signal,))


KGF_N, LBF_N, INCH_m = 9.80665, 4.4482216, 0.0254
MISTAKES = [
    wrong("robot", "robot_position_m", -1.0, "opposite sign"), wrong("robot", "robot_position_m", 1e3, "in mm"),
    wrong("robot", "command_position_m", 1e3, "in mm"), wrong("robot", "robot_position_m", 100.0, "in cm"),
    wrong("robot", "command_position_m", 1.0 / INCH_m, "in inches"), wrong("force", "force_N", -1.0, "opposite sign"),
    wrong("force", "force_N", 1e-3, "in kN"), wrong("force", "command_position_m", 1e3, "in mm"),
    wrong("all", "force_N", -1.0, "opposite sign"), wrong("all", "force_N", 1.0 / KGF_N, "in kgf"),
    wrong("all", "force_N", 1.0 / LBF_N, "in lbf"), wrong("all", "command_position_m", 1e3, "in mm"),
    wrong("all", "operator_position_m", -1.0, "opposite sign"), wrong("all", "operator_position_m", 1e3, "in mm"),
    Mistake("positions exchanged", with_columns(exchanged, "robot"), "robot", ("exchanged",),
            ("command_position_m", "robot_position_m")),
    # It may be in another unit, or the stiffness is wrong.
    *[Mistake(f"a force that may be in {unit}", with_columns(multiplied, "force", signal="force_N", factor=1.0 / in_N),
              "force", ("were in", unit), ("force_N",), is_refused=False) for unit, in_N in (("kgf", KGF_N), ("lbf", LBF_N))],
    Mistake("another zero of the reports", with_columns(shifted, "robot", signal="robot_position_m", offset=0.02), "robot",
            ("another zero", "0.02 m throughout"), ("robot_position_m",), is_refused=False),
    *[Mistake(f"another zero of the force, {offset_N} N", with_columns(shifted, "all", signal="force_N", offset=offset_N), "all",
              ("another zero", f"force_N has {offset_N:.2g}"), ("force_N",), is_refused=False, within=0.5)
      for offset_N in (20.0, -35.0)],
]


@pytest.fixture(scope="module")
def good(tmp_path_factory):
    """{block: diagnosis} without any mistake."""
    folder = tmp_path_factory.mktemp("good")
    return {block: Row("good", with_columns(as_they_are, block)).told(folder / block).found for block in ("robot", "force", "all")}


@pytest.mark.long
@pytest.mark.parametrize("mistake", MISTAKES, ids=lambda one: one.name)
def test_a_mistake_is_told_and_the_cure_cures(mistake, good, tmp_path):
    record = mistake.record.folder() / "record.csv"
    done = command("diagnose", record, "--rig", "ess", "--out", tmp_path / "out")
    message = done.stderr.decode()
    if mistake.is_refused:
        assert done.returncode == EXIT_INPUT and done.stdout == b"" and message.count("\n") == 1, message
        assert message.startswith(f"berth: {record}:1: "), message
    else:
        assert done.returncode == EXIT_DONE, message
        notes = json.loads((tmp_path / "out" / "diagnosis.json").read_text())["notes"]
        [message] = [note for note in notes if mistake.says[0] in note]
    assert all(text in message for text in mistake.says), message
    cures = dict(re.findall(r"(\w+) = (\{[^}]*\})", message))
    assert set(mistake.signals) <= set(cures), message
    rig = tmp_path / "cured.toml"
    rig.write_text((RIG_FOLDER / "ess.toml").read_text() + "\n[signals]\n"
                   + "".join(f"{name} = {cures[name]}\n" for name in mistake.signals))
    cured = Row("cured", mistake.record, rig=rig).told(tmp_path / "cured").found
    wanted = good[mistake.block]
    zeros = {"manipulator.gravity_offset", "sensor.bias"}  # what the digits of the cure leave of another zero
    assert cured["verdict"] == wanted["verdict"] or {cause["effect"] for cause in cured["causes"]} <= zeros
    for name, residual in wanted["residual"].items():
        assert cured["residual"][name]["fit"]["before"] == near(residual["fit"]["before"], rel=mistake.within), name
    assert not any(mistake.says[0] in note for note in cured["notes"] + wanted["notes"])


# --- what is no mistake, or may be none ---------------------------------------------------------------------------
FAR_OFF = {"robot.dead_time_ms": 60, "object.mass_kg": 250, "object.stiffness_N_per_m": 100000, "sensor.bias_N": 200}
SURE = (RIG_FOLDER / "ess.toml").read_text() + '\n[signals]\nrobot_position_m = { column = "robot_position_m", scale = 1 }\n'

ROWS = [
    # A bias that the manipulator felt is one.
    *[Row(f"a bias of {bias_N} N that the manipulator felt", with_columns(as_they_are), has_cause("sensor.bias"),
          no_note("another zero"), given={"sensor.bias_N": bias_N}) for bias_N in (-20.0, 35.0)],
    *[Row(f"a rig file that is far off is no wrong sign, {key}", with_columns(as_they_are), no_note("looks as if"),
          given={key: value}) for key, value in FAR_OFF.items()],
    # As sampled, or as logged after the tick: the manipulator tells, and without one a delay of whole rows.
    *[Row(f"a force one row {where}", with_columns(in_another_row, signal="force_N", rows=-rows),
          note(f"force_N stands one row {where}")) for rows, where in ((1, "before"), (-1, "behind"))],
    Row("a delay of whole rows may be that of the log", with_columns(in_another_row, "force", signal="force_N", rows=2),
        offers("sensor.delay"), note("sensor.delay_ms is wrong by a whole number of rows, 2")),
    *[Row(f"a force in its row, {block}", with_columns(as_they_are, block), no_note("stands"))
      for block in ("robot", "force", "all")],
    *[Row(f"an operator's force, stiffness {stiffness}", drive_of_2_kg(factor=1.0, stiffness=stiffness))
      for stiffness in (0.0, 400.0)],
    *[Refused(f"an operator's force {what}, stiffness {stiffness}", drive_of_2_kg(factor=factor, stiffness=stiffness),
              "operator_force_N", "looks as if", what)
      for factor, what in ((-1.0, "opposite sign"), (1e-3, "in kN")) for stiffness in (0.0, 400.0)],
]


@pytest.mark.long
@each(ROWS)
def test_signal(row, tmp_path):
    row.check(tmp_path / "out")


@pytest.mark.long
def test_who_says_that_it_is_right_is_only_told(tmp_path):
    rig = tmp_path / "sure.toml"
    rig.write_text(SURE)
    record = with_columns(multiplied, "robot", signal="robot_position_m", factor=-1.0)
    Row("sure", record, note("opposite sign", "scale = -1"), rig=rig).check(tmp_path / "out")
