"""Files of records: what is wrong with one is said with file, line and column and what to do, and what is not wrong is
taken. `{record}` and `{folder}` in the words of a refusal are the record's path and its folder."""

from pathlib import Path

import numpy as np
import pytest
from checks import check, note, verdict
from conftest import EXIT_INPUT, command, one_json_object, run_json, settings
from make_files import (HEADER, WRONG_LINE, back_in_time, cell, commented, content, dated, doubled_time, encoded, encoder,
                        encoder_in_mm, force_z, from_a_spreadsheet, from_the_end, gaps_and_jitter, in_labelled_parts, in_mm, named_in_units,
                        packed, quoted, renamed, robot_alone,
                        rounded_stamps, since_1970, stamps_since_1970, still_operator, still_robot, table_of, text_of,
                        two_files, with_a_cell_too_many, with_blanks, with_ends, with_more, without_header)
from recipes import record_in
from table import Refused, Row, each

ENDS = {"LF": "\n", "CR LF": "\r\n", "CR": "\r"}
MAPPED = 'base = "ess"\nname = "mapped"\n[signals]\nrobot_position_m = { column = "encoder", scale = 1.0 }\n'
PARTED = 'base = "ess"\n[signals]\nsegment = "part"\n'
NOT_TEXT = bytes(1 + (37 * n) % 9 for n in range(300)) + b";" + bytes(range(1, 32)) * 20


ENCODER = 'base = "ess"\n[signals]\nrobot_position_m = { column = "encoder_mm", scale = 0.001 }\n'


def unit(header, units, *says):
    """Columns of these names, with a row of units below them where `units` is given."""
    return Refused(f"units of {header}, {units}", text_of(change=named_in_units, names=header, units=units), "{record}", *says)


CELLS = [
    *[Refused(f"{HEADER[column]} of {value:g} in one row", table_of(change=cell, column=column, value=value),
              f"{{record}}:72: {HEADER[column]}: {value:g}", "leave its row out")
      for column in (1, 2) for value in (1e300, -1e300, 1e13, 2e4)],
    Refused("a cell that is no number", table_of(change=cell, column=2, value=np.nan, row=17), "{record}:19:",
            "robot_position_m", "finite"),
    Refused("a cell too many", text_of(change=with_a_cell_too_many), "{record}:51: ", "more cells than the 3", "comma"),
    Refused("a cell too few", content(data=(",".join(HEADER) + "\n0,1\n").encode()), "{record}:2:", "cells"),
    Refused("an empty file", content(data=b""), "{record}", "is empty"),
    Refused("bytes that are no text", content(data=NOT_TEXT), "{record}:1: ", "is no text", "a CSV file or a log"),
    Refused("letters of four bytes", text_of(change=encoded, encoding="utf-32"), "{record}", ":1: ", "UTF-16",
            "save it as UTF-8"),
    Refused("columns separated by blanks", text_of(change=with_blanks), "{record}:1: ", "separated by blanks", "write commas"),
    Refused("no header", text_of(change=without_header), "{record}:2: ", "no names", "comment"),
    *[Refused(f"{damage} in a file with comments, lines end with {name}", text_of(change=commented, end=end, damage=damage),
              f"{{record}}:{WRONG_LINE}: {told}") for name, end in ENDS.items()
      for damage, told in (("time", "t_s goes from"), ("cell", "command_position_m"))],
    *[Refused(f"a packed file, {name}", text_of(change=packed, name="record.csv.gz", **given), "{record}")
      for name, given in {"cut": {"cut": -9}, "without its end": {"cut": -1}, "half": {"cut": "half"},
                          "damaged": {"hole": True}}.items()],
]

TIMES = [
    Refused("time that runs backwards", table_of(change=back_in_time), "{record}:1002:", "time must increase"),
    Refused("rows the last one first", table_of(change=from_the_end), "t_s never increases", "the last one first"),
    Refused("stamps of too few digits", table_of(change=rounded_stamps), "t_s repeats in ", "stamps are rounded", "more digits"),
    Refused("another rate", table_of(change=doubled_time), "{record}", "loop.rate_Hz=200"),
    *[Refused(f"a time since 1970 in {name}", table_of(change=since_1970, factor=factor), "{record}", "since 1970",
              f"scale = {told}") for name, factor, told in (("ms", 1e3, "0.001"), ("us", 1e6, "1e-06"), ("ns", 1e9, "1e-09"))],
    Refused("three rows", table_of(rows=3), "{record}", "3 rows"),
    Refused("a rig that needs another rate than the default", table_of(rig="[manipulator]\nmass_kg = 100.0\n[robot]\ndead_time_ms = 2.0\n"),
            "{folder}/rig.toml:4: ", "one period (2.5", "no loop.rate_Hz is given, 400"),
]

COLUMNS = [
    Refused("no time", table_of(change=renamed, t_s="s"), "{record}", "t_s", "command_position_m, robot_position_m"),
    Refused("a robot without a command or a force", table_of(change=robot_alone), "no block can be replayed"),
    Refused("a command in another unit", table_of(change=in_mm), "{record}", "command_position_mm", "another unit", "scale"),
    unit("t_s,command_position_m,robot_position_m", "s,mm,m", ":2: ", "command_position_m has another unit", "(mm)",
         "scale = 0.001 }"),
    unit("t_s,command_position_mm,robot_position_m", None, ":1: ", "(mm)", "scale = 0.001 }"),
    unit("t_s,command_position [cm],robot_position_m", None, ":1: ", "(cm)", "scale = 0.01 }"),
    unit("t_ms,command_position_m,robot_position_m", None, ":1: ", "t_ms has another unit than t_s (ms)", "scale = 0.001 }"),
    unit("Time [ms],command_position_m,robot_position_m", None, ":1: ",
         '[signals] t_s = { column = "Time [ms]", scale = 0.001 }'),
    Refused("a mapped column in another unit", table_of(change=encoder_in_mm, rig='[signals]\nrobot_position_m = "encoder_mm"\n'),
            "{record}", ":1: ", "encoder_mm", "scale = 0.001 }"),
    Refused("a robot that never moves", table_of(change=still_robot), "{record}", "robot_position_m", "every row"),
    Refused("two columns of one name", table_of(change=with_more, names=["robot_position_m"], of=[2]), "{record}:1: ",
            "two columns", "robot_position_m", "rename"),
    Refused("two columns of a mapped name", table_of(change=encoder, both=False, rig=MAPPED), "{record}:1: ", "two columns",
            "encoder"),
    Refused("an operator who never does anything", table_of(change=still_operator, force_N=3.0, has_force=False),
            "{record}:1: ", "operator_force_N is 3 in every row", "leave the column out"),
    Refused("a force of another name", table_of(change=force_z), "{record}:1: ", "no column force_N",
            '[signals] force_N = "force_z_N"', without=["another unit"]),
    Refused("an operator's velocity in another unit", table_of(change=with_more, names=["operator_velocity_mm_per_s"], of=[0]),
            "operator_velocity_mm_per_s has another unit"),
    Refused("two signals of one column",
            table_of(rig='[signals]\nforce_N = { column = "robot_position_m", scale = 1e3 }\n'), "{record}:1: ",
            "robot_position_m and force_N from one column, robot_position_m"),
    Refused("labels of parts that are no whole numbers", table_of(change=in_labelled_parts, last=2, rig=PARTED),
            "{record}:3: part is 1.0002", "whole"),
    Refused("a part in each row", table_of(change=in_labelled_parts, last=4000, rig=PARTED),
            "part changes in 3999 of 4000 rows"),
]

BESIDE = [
    Refused("the same measurement, packed", two_files(packed=True), "{folder}/validate.csv.gz", "same content",
            "independent evidence"),
    Refused("the same measurement, at another time", two_files(shift_s=100.0), "{folder}/validate.csv", "same content",
            "independent evidence"),
    Refused("an effect that there is not", table_of(), "robot.ghost", options=("--without", "robot.ghost")),
]


# --- what is taken ------------------------------------------------------------------------------------------------
def fnv1a(data):
    value = 0xCBF29CE484222325
    for byte in data:
        value = (value ^ byte) * 0x100000001B3 % 2**64
    return f"{value:016x}"


@check
def hashes_are_of_the_stored_files(told, *roles):
    inputs = {one["role"]: one for one in told.found["inputs"]}
    for role in roles:
        with open(inputs[role]["path"], "rb") as file:
            assert inputs[role]["hash"] == fnv1a(file.read()), role


@check
def roles_are(told, *roles):
    assert [one["role"] for one in told.found["inputs"]] == list(roles)


@check
def same_as_unpacked(told):
    whole = Row("whole", text_of(change=with_ends, end="\n")).told(told.out.with_name("whole"))
    assert told.found["residual"] == whole.found["residual"]


NOTHING = verdict("nothing_detectable")
TAKEN = [
    Row("a good record, packed", table_of(name="record.csv.gz"), NOTHING, hashes_are_of_the_stored_files("record")),
    *[Row(f"lines that end with {name}", text_of(change=with_ends, end=end), NOTHING) for name, end in ENDS.items()],
    *[Row(f"letters of two bytes, {encoding}", text_of(change=encoded, encoding=encoding), NOTHING)
      for encoding in ("utf-16", "utf-16-le", "utf-16-be")],
    *[Row(f"a spreadsheet's table, separated by {name}", text_of(change=from_a_spreadsheet, separator=separator), NOTHING)
      for name, separator in (("semicolons", ";"), ("tabs", "\t"))],
    Row("stamps that are dates", text_of(change=dated), NOTHING),
    Row("names in quotes, and a comma in one", text_of(change=quoted), NOTHING),
    Row("a mapped column that the rig file converts", table_of(change=encoder_in_mm, rig=ENCODER), NOTHING),
    Row("packed files one after another", text_of(change=packed, name="record.csv.gz", twice=True), same_as_unpacked()),
    Row("a gap and stamps that jitter", table_of(change=gaps_and_jitter), NOTHING, note("1 gap"), note("jitter")),
    # What a loose contact does, 500 times the motion, is for the diagnosis to find.
    Row("a spike is no damaged cell", table_of(change=cell, column=2, value=5.0)),
    Row("stamps in microseconds since 1970", table_of(change=stamps_since_1970, rig='base = "ess"\nname = "mapped"\n[signals]\n'
                                                      't_s = { column = "t_us", scale = 1e-6 }\n'), NOTHING),
    Row("a mapped column beside one of the signal's own name", table_of(change=encoder, both=True, rig=MAPPED),
        note("encoder, as the rig file says")),
    Row("a mapped column whose name is like another signal's",
        table_of(change=renamed, robot_position_m="force_V", rig=MAPPED.replace("encoder", "force_V").replace("1.0", "1.0000001")), NOTHING),
    Row("columns that nobody asks for may have any name", table_of(change=with_more, names=["", ""], of=[0, 0])),
    Row("a force of 0 in every row", table_of(change=still_operator, force_N=0.0, has_force=True),
        note("operator_force_N is 0 in every row")),
    Row("a force of another name that the rig file gives",
        table_of(change=force_z, rig='base = "ess"\nname = "z"\n[signals]\nforce_N = "force_z_N"\n')),
    *[Row(f"{column} may be meant", table_of(change=with_more, names=[column], of=[0]), note(f"{column} is meant"))
      for column in ("force_limit_N", "force", "Force_N", "FORCE")],
    Row("a repetition beside it", two_files(role="repeat", seed=3), roles_are("rig", "record", "repetition"),
        hashes_are_of_the_stored_files("record", "repetition")),
    Row("a validation beside it", two_files(seed=2), roles_are("rig", "record", "validation"),
        hashes_are_of_the_stored_files("record", "validation")),
]


@pytest.mark.long
@each(CELLS + TIMES + COLUMNS + BESIDE + TAKEN)
def test_record_file(row, tmp_path):
    row.check(tmp_path / "out")


# --- a log of ours as a CSV file -------------------------------------------------------------------------------------
RUN = settings({"robot.feedback_noise_m": 5e-6, "sensor.noise_N": 0.2, "profile.kind": "multisine", "profile.amplitude_m": 0.01,
                "profile.duration_s": 20, "run.duration_s": 20})


@pytest.mark.long
@pytest.mark.parametrize("hidden, found", [({"robot.backlash_m": 2e-4}, ["robot.backlash"]), ({"bus.ideal": "true"}, []), ({}, [])])
def test_a_log_says_the_same_as_the_csv_file_made_of_it(hidden, found, tmp_path):
    log = Path(run_json("ess", tmp_path, *RUN, *settings(hidden))["log"])
    assert command("export", log, "--csv").returncode == 0
    rig = tmp_path / "rig.toml"
    ideal = "[bus]\nideal = true\n" if "bus.ideal" in hidden else ""
    rig.write_text(f'base = "ess"\n{ideal}[signals]\nt_s = {{ column = "timestamp", scale = 1e-6 }}\n')
    told = {}
    for record in (log, log.with_suffix(".tick.csv")):
        done = command("diagnose", record, "--rig", rig, "--json", "--out", tmp_path / record.suffix[1:])
        assert done.returncode == 0, done.stderr.decode()
        blocks = one_json_object(done.stdout)["blocks"]
        told[record.suffix] = [cause["effect"] for block in blocks for cause in block["causes"]]
        floors = {block["block"]: block["residual"]["fit"]["floor"] for block in blocks if block["block"] != "manipulator"}
        told[record.suffix, "floors"] = pytest.approx(floors, rel=1e-6)
    assert told[".ulg"] == told[".csv"] == found
    assert told[".ulg", "floors"].expected == told[".csv", "floors"]


# --- the folder ---------------------------------------------------------------------------------------------------
def test_a_folder_holds_what_belongs_together(tmp_path):
    """Reports of an earlier diagnosis are not of this one."""
    for name in ("report.html", "report.png", "next_experiment.csv", "notes.txt"):
        (tmp_path / name).write_text("of another day")
    Row("", table_of()).told(tmp_path)
    assert not (tmp_path / "report.html").exists() and not (tmp_path / "report.png").exists()
    assert (tmp_path / "notes.txt").read_text() == "of another day"


def test_a_folder_that_cannot_take_every_file_is_told_before_the_work(tmp_path):
    """An earlier diagnosis stays as it was."""
    out = tmp_path / "out"
    (out / "extended.toml").mkdir(parents=True)
    (out / "diagnosis.json").write_text("of another day")
    record = record_in(table_of().folder())
    (tmp_path / "round").symlink_to("round")
    (tmp_path / "nowhere").symlink_to("there is none")
    for folder, told in ((out, f"{out}/extended.toml: is a folder"), (record, f"{record} is no folder"),
                         (record / "a/b", f"{record} is no folder"), (tmp_path / "round/a", "round/a is no folder"),
                         (tmp_path / "nowhere", f"{tmp_path}/nowhere is no folder"), (tmp_path / ("a" * 300), "no folder")):
        done = command("diagnose", record, "--rig", "ess", "--out", folder)
        assert done.returncode == EXIT_INPUT and told in done.stderr.decode(), done.stderr
        assert b"robot" not in done.stderr  # no progress: nothing had been done
    assert sorted(path.name for path in out.iterdir()) == ["diagnosis.json", "extended.toml"]
    assert (out / "diagnosis.json").read_text() == "of another day"
