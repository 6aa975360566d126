"""`berth diagnose` and the files it reads and writes: what is wrong with a record is said with file, line and column,
and an output folder holds what belongs together."""

import gzip
import json

import numpy as np
import pytest
from conftest import EXIT_DONE, EXIT_INPUT, command
from hidden_record import hidden_and_told

HEADER = ["t_s", "command_position_m", "robot_position_m"]


def motion(rows=4000, noise_m=1e-6, seed=1):
    """t_s, command and robot of a robot that does as it is told, 17.5 ms late."""
    t_s = 0.0025 * np.arange(rows)
    command_m = 0.01 * np.sin(2 * np.pi * 0.7 * t_s) + 0.003 * np.sin(2 * np.pi * 2.3 * t_s + 1.0)
    robot_m = np.interp(t_s - 0.0175, t_s, command_m)
    return t_s, command_m, robot_m + noise_m * np.random.default_rng(seed).standard_normal(rows)


def lines_of(header, columns):
    return [",".join(header)] + [",".join(repr(float(value)) for value in row) for row in zip(*columns)]


def write(path, header, columns):
    path.write_text("\n".join(lines_of(header, columns)) + "\n")
    return path


def refused(tmp_path, *arguments, contains=()):
    """Exit code 2 and one line; the message."""
    done = command("diagnose", *arguments, "--out", tmp_path / "refused")
    message = done.stderr.decode()
    assert done.returncode == EXIT_INPUT and done.stdout == b"", (done.returncode, message)
    assert message.startswith("berth: ") and message.count("\n") == 1 and "internal error" not in message, message
    assert not (tmp_path / "refused").exists()
    for part in contains:
        assert part in message, message
    return message


def diagnosed(out, *arguments):
    done = command("diagnose", *arguments, "--out", out)
    assert done.returncode == EXIT_DONE, done.stderr.decode()
    return json.loads((out / "diagnosis.json").read_text())


# --- cells, rows and columns --------------------------------------------------------------------------------------
@pytest.mark.parametrize("value", [1e300, -1e300, 1e13, 2e4])
@pytest.mark.parametrize("column", [1, 2])
def test_a_cell_beyond_all_others(tmp_path, column, value):
    columns = motion()
    columns[column][70] = value
    record = write(tmp_path / "spoilt.csv", HEADER, columns)
    refused(tmp_path, record, "--rig", "ess",
            contains=[f"{record}:72: {HEADER[column]}: {value:g}", "leave its row out"])


def test_a_spike_is_no_damaged_cell(tmp_path):
    """What a loose contact does, 500 times the motion, is for the diagnosis to find."""
    columns = motion()
    columns[2][70] = 5.0
    diagnosed(tmp_path / "out", write(tmp_path / "spike.csv", HEADER, columns), "--rig", "ess")


def test_a_row_with_a_cell_too_many(tmp_path):
    lines = lines_of(HEADER, motion())
    lines[50] += ",0.5"
    record = tmp_path / "cells.csv"
    record.write_text("\n".join(lines) + "\n")
    refused(tmp_path, record, "--rig", "ess", contains=[f"{record}:51: ", "more cells than the 3", "comma"])


def test_a_rate_that_is_not_given_is_told_where_the_default_decides(tmp_path):
    rig = tmp_path / "fast.toml"
    rig.write_text("[robot]\ndead_time_ms = 2.0\n")
    record = write(tmp_path / "record.csv", HEADER, motion())
    refused(tmp_path, record, "--rig", rig, contains=[f"{rig}:2: ", "one period (2.5", "no loop.rate_Hz is given, 400"])


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-le", "utf-16-be", "utf-32"])
def test_letters_of_more_than_a_byte(tmp_path, encoding):
    """As some spreadsheets save what they call Unicode text."""
    record = tmp_path / "wide.csv"
    record.write_bytes("\n".join(lines_of(HEADER, motion())).encode(encoding))
    refused(tmp_path, record, "--rig", "ess", contains=[":1: ", "UTF-16", "save it as UTF-8"])


def test_bytes_that_are_no_text(tmp_path):
    record = tmp_path / "bytes.csv"
    record.write_bytes(bytes(1 + (37 * n) % 9 for n in range(300)) + b";" + bytes(range(1, 32)) * 20)
    refused(tmp_path, record, "--rig", "ess", contains=[f"{record}:1: ", "is no text", "a CSV file or a log"])


@pytest.mark.parametrize("separator, told", [(";", "semicolons"), ("\t", "tabs"), (" ", "blanks")])
def test_a_table_with_other_separators(tmp_path, separator, told):
    """As a spreadsheet writes it where the comma is the decimal point."""
    lines = [line.replace(",", separator).replace(".", ",") for line in lines_of(HEADER, motion())]
    record = tmp_path / "table.csv"
    record.write_text("\n".join(lines) + "\n")
    refused(tmp_path, record, "--rig", "ess",
            contains=[f"{record}:1: ", f"separated by {told}", "write commas, and points in the numbers"])


def test_rows_the_last_one_first(tmp_path):
    record = write(tmp_path / "turned.csv", HEADER, [column[::-1] for column in motion()])
    refused(tmp_path, record, "--rig", "ess", contains=["t_s never increases", "the last one first"])


def test_stamps_of_a_clock_that_counts_microseconds_since_1970(tmp_path):
    t_s, command_m, robot_m = motion()
    rig = tmp_path / "rig.toml"
    rig.write_text('name = "mapped"\n[signals]\nt_s = { column = "t_us", scale = 1e-6 }\n')
    stamps = 1732700000000000 + np.round(1e6 * t_s)
    record = write(tmp_path / "good.csv", ["t_us", *HEADER[1:]], (stamps, command_m, robot_m))
    assert diagnosed(tmp_path / "out", record, "--rig", rig)["verdict"] == "nothing_detectable"


def test_stamps_of_too_few_digits(tmp_path):
    t_s, command_m, robot_m = motion()
    record = write(tmp_path / "rounded.csv", HEADER, [np.round(t_s, 2), command_m, robot_m])
    refused(tmp_path, record, "--rig", "ess", contains=["t_s repeats in ", "stamps are rounded", "more digits"])


def test_two_columns_of_one_name(tmp_path):
    t_s, command_m, robot_m = motion()
    record = write(tmp_path / "twice.csv", [*HEADER, "robot_position_m"], (t_s, command_m, robot_m, robot_m))
    refused(tmp_path, record, "--rig", "ess", contains=[f"{record}:1: ", "two columns", "robot_position_m", "rename"])


RIG = 'name = "mapped"\n[signals]\nrobot_position_m = { column = "encoder", scale = 1.0 }\n'


def test_two_columns_of_a_mapped_name(tmp_path):
    (tmp_path / "rig.toml").write_text(RIG)
    t_s, command_m, robot_m = motion()
    record = write(tmp_path / "twice.csv", ["t_s", "command_position_m", "encoder", "encoder"],
                   (t_s, command_m, robot_m, robot_m))
    refused(tmp_path, record, "--rig", tmp_path / "rig.toml", contains=[f"{record}:1: ", "two columns", "encoder"])
    record = write(tmp_path / "both.csv", [*HEADER, "encoder"], (t_s, command_m, 0 * robot_m, robot_m))
    found = diagnosed(tmp_path / "out", record, "--rig", tmp_path / "rig.toml")
    assert any("encoder, as the rig file says" in note for note in found["notes"])


def test_columns_that_nobody_asks_for_may_have_any_name(tmp_path):
    t_s, command_m, robot_m = motion()
    diagnosed(tmp_path / "out", write(tmp_path / "more.csv", [*HEADER, "", ""], (t_s, command_m, robot_m, t_s, t_s)),
              "--rig", "ess")


def test_an_operator_who_never_does_anything(tmp_path):
    t_s, command_m, _ = motion()
    header = ["t_s", "operator_force_N", "command_position_m"]
    record = write(tmp_path / "still.csv", header, (t_s, 0 * t_s + 3.0, command_m))
    refused(tmp_path, record, "--rig", "ess",
            contains=[f"{record}:1: ", "operator_force_N is 3 in every row", "leave the column out"])
    record = write(tmp_path / "force.csv", [*header, "force_N"],
                   (t_s, 0 * t_s, command_m, 100.0 * motion()[2]))
    found = diagnosed(tmp_path / "out", record, "--rig", "ess")
    assert any("operator_force_N is 0 in every row" in note for note in found["notes"])


def test_a_column_of_another_name_has_no_other_unit(tmp_path):
    t_s, command_m, robot_m = motion()
    record = write(tmp_path / "z.csv", ["t_s", "command_position_m", "force_z_N"], (t_s, command_m, 100 * robot_m))
    message = refused(tmp_path, record, "--rig", "ess",
                      contains=[f"{record}:1: ", "no column force_N", '[signals] force_N = "force_z_N"'])
    assert "another unit" not in message
    rig = tmp_path / "rig.toml"
    rig.write_text('name = "z"\n[signals]\nforce_N = "force_z_N"\n')
    diagnosed(tmp_path / "out", record, "--rig", rig)
    record = write(tmp_path / "velocity.csv", [*HEADER, "operator_velocity_mm_per_s"], (*motion(), t_s))
    refused(tmp_path, record, "--rig", "ess", contains=["operator_velocity_mm_per_s has another unit"])


@pytest.mark.parametrize("column", ["force_limit_N", "force", "Force_N", "FORCE"])
def test_a_column_that_may_be_meant_is_told(tmp_path, column):
    t_s, command_m, robot_m = motion()
    record = write(tmp_path / "z.csv", [*HEADER, column], (t_s, command_m, robot_m, t_s))
    found = diagnosed(tmp_path / "out", record, "--rig", "ess")
    assert any(f"{column} is meant" in note for note in found["notes"])


def test_two_signals_are_not_of_one_column(tmp_path):
    record = write(tmp_path / "record.csv", HEADER, motion())
    (tmp_path / "rig.toml").write_text('[signals]\nforce_N = { column = "robot_position_m", scale = 1e3 }\n')
    refused(tmp_path, record, "--rig", tmp_path / "rig.toml",
            contains=[f"{record}:1: ", "robot_position_m and force_N from one column, robot_position_m"])


def test_labels_of_parts_are_whole(tmp_path):
    record = write(tmp_path / "parts.csv", [*HEADER, "part"], [*motion(), np.linspace(1.0, 2.0, 4000)])
    (tmp_path / "rig.toml").write_text('[signals]\nsegment = "part"\n')
    refused(tmp_path, record, "--rig", tmp_path / "rig.toml", contains=[f"{record}:3: part is 1.0002", "whole"])
    write(record, [*HEADER, "part"], [*motion(), np.arange(4000)])
    refused(tmp_path, record, "--rig", tmp_path / "rig.toml", contains=["part changes in 3999 of 4000 rows"])


# --- lines --------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_lines_count_as_in_an_editor(tmp_path, end):
    t_s, command_m, robot_m = motion()
    t_s[1000] = t_s[998]
    lines = lines_of(HEADER, (t_s, command_m, robot_m))
    lines = ["# measured on a Monday", "", *lines[:500], "", "# a break", "", *lines[500:]]
    wrong = 1 + next(i for i, line in enumerate(lines) if line == lines[1001 + 5])
    record = tmp_path / "lines.csv"
    record.write_bytes(end.join(lines).encode())
    refused(tmp_path, record, "--rig", "ess", contains=[f"{record}:{wrong}: t_s goes from"])
    lines[wrong - 1] = lines[wrong - 1].replace(",", ",x", 1)
    record.write_bytes(end.join(lines).encode())
    refused(tmp_path, record, "--rig", "ess", contains=[f"{record}:{wrong}: command_position_m"])


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_lines_may_end_in_any_way(tmp_path, end):
    lines = lines_of(HEADER, motion())
    record = tmp_path / "ends.csv"
    record.write_bytes((end.join(lines) + end).encode())
    assert diagnosed(tmp_path / "out", record, "--rig", "ess")["verdict"] == "nothing_detectable"


def test_a_file_without_a_header(tmp_path):
    lines = lines_of(HEADER, motion())
    record = tmp_path / "headless.csv"
    record.write_text("\n".join(["# " + lines[0], *lines[1:]]))
    refused(tmp_path, record, "--rig", "ess", contains=[f"{record}:2: ", "no names", "comment"])


# --- packed files, hashes, roles ----------------------------------------------------------------------------------
def fnv1a(data):
    value = 0xCBF29CE484222325
    for byte in data:
        value = (value ^ byte) * 0x100000001B3 % 2**64
    return f"{value:016x}"


def test_hashes_are_of_the_files_as_they_are_stored(tmp_path):
    record = write(tmp_path / "record.csv", HEADER, motion())
    packed = tmp_path / "record.csv.gz"
    packed.write_bytes(gzip.compress(record.read_bytes()))
    other = write(tmp_path / "other.csv", HEADER, motion(seed=2))
    found = diagnosed(tmp_path / "out", packed, "--rig", "ess", "--validate", other)
    inputs = {one["role"]: one for one in found["inputs"]}
    assert inputs["record"]["hash"] == fnv1a(packed.read_bytes())
    assert inputs["validation"]["hash"] == fnv1a(other.read_bytes())
    found = diagnosed(tmp_path / "out", record, "--rig", "ess")
    assert {one["role"]: one["hash"] for one in found["inputs"]}["record"] == fnv1a(record.read_bytes())


def test_roles_are_those_of_the_arguments(tmp_path):
    record = write(tmp_path / "record.csv", HEADER, motion())
    second = write(tmp_path / "second.csv", HEADER, motion(seed=2))
    third = write(tmp_path / "third.csv", HEADER, motion(seed=3))
    found = diagnosed(tmp_path / "out", record, second, "--rig", "ess", "--repeat", third)
    assert [one["role"] for one in found["inputs"]] == ["rig", "record", "record", "repetition"]


def test_the_same_measurement_packed_or_written_anew_is_the_same(tmp_path):
    columns = motion()
    record = write(tmp_path / "record.csv", HEADER, columns)
    packed = tmp_path / "packed.csv.gz"
    packed.write_bytes(gzip.compress(record.read_bytes()))
    shifted = write(tmp_path / "shifted.csv", HEADER, (columns[0] + 100.0, *columns[1:]))
    for other in (packed, shifted):
        refused(tmp_path, record, "--rig", "ess", "--validate", other,
                contains=[str(other), "same content", "independent evidence"])


def test_packed_files_one_after_another_are_one(tmp_path):
    text = ("\n".join(lines_of(HEADER, motion())) + "\n").encode()
    whole = tmp_path / "whole.csv"
    whole.write_bytes(text)
    parts = tmp_path / "parts.csv.gz"
    parts.write_bytes(gzip.compress(text[:70001]) + gzip.compress(text[70001:]) + bytes(512))
    found, wanted = (diagnosed(tmp_path / "out", path, "--rig", "ess") for path in (parts, whole))
    assert found["residual"] == wanted["residual"]


def test_a_packed_file_that_is_cut_or_damaged(tmp_path):
    packed = gzip.compress("\n".join(lines_of(HEADER, motion())).encode())
    for name, data in {"cut": packed[:-9], "end": packed[:-1], "half": packed[:len(packed) // 2],
                       "bad": packed[:200] + bytes(100) + packed[300:]}.items():
        path = tmp_path / f"{name}.csv.gz"
        path.write_bytes(data)
        refused(tmp_path, path, "--rig", "ess", contains=[str(path)])


# --- the folder ---------------------------------------------------------------------------------------------------
def test_a_folder_holds_what_belongs_together(tmp_path):
    """Reports of an earlier diagnosis are not of this one."""
    out = tmp_path / "out"
    out.mkdir()
    for name in ("report.html", "report.png", "next_experiment.csv", "notes.txt"):
        (out / name).write_text("of another day")
    diagnosed(out, write(tmp_path / "record.csv", HEADER, motion()), "--rig", "ess")
    assert not (out / "report.html").exists() and not (out / "report.png").exists()
    assert (out / "notes.txt").read_text() == "of another day"


def test_a_folder_that_cannot_take_every_file_is_told_before_the_work(tmp_path):
    """An earlier diagnosis stays as it was."""
    out = tmp_path / "out"
    (out / "extended.toml").mkdir(parents=True)
    (out / "diagnosis.json").write_text("of another day")
    record = write(tmp_path / "record.csv", HEADER, motion())
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


@pytest.mark.parametrize("seed, effect, causes", [
    (2, "none", []), (3, "none", []), (21, "sensor.quantisation", ["sensor.quantisation"]),
    (24, "robot.backlash", ["robot.backlash"])])
@pytest.mark.first(2)
def test_rows_that_a_logger_lost_are_no_fault(seed, effect, causes, tmp_path):
    """What is put in for them lies beside the steps of a coarse sensor, and off what the robot was told."""
    missing = np.random.default_rng(seed).choice(np.arange(100, 7000), 20, replace=False)
    size = () if effect == "none" else ("--size", "large")
    _, told = hidden_and_told(tmp_path, seed, "--effect", effect, *size, missing=list(missing))
    assert [one["effect"] for one in told["causes"]] == causes
    assert told["verdict"] == ("named" if causes else "nothing_detectable")
    assert any("missing" in note or "gap" in note for note in told["notes"])


@pytest.mark.parametrize("effect, cause", [("none", None), ("robot.gain", "robot.gain")])
@pytest.mark.parametrize("which", ["one in seven", "any of twenty"])
@pytest.mark.first(1)
def test_where_many_rows_are_missing_the_noise_is_what_it_is(which, effect, cause, tmp_path):
    """Few rows then have many before them, and what is put in between has the noise of the next ones."""
    rows = np.arange(100, 7000)
    missing = rows[::7] if which == "one in seven" else np.random.default_rng(5).choice(rows, len(rows) // 20, False)
    _, told = hidden_and_told(tmp_path, 5, "--effect", effect, "--size", "large", missing=list(missing))
    assert [one["effect"] for one in told["causes"]] == ([cause] if cause else [])
    assert told["verdict"] == ("named" if cause else "nothing_detectable")
    truth = json.loads((tmp_path / "truth/truth.json").read_text())
    for channel, parts in told["residual"].items():
        assert parts["fit"]["floor"] == pytest.approx(truth["floor_rms"][channel], rel=0.2)
