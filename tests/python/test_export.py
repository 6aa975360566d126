"""`berth export`: what other programs' own readers get from the files is what pyulog gets from the log."""

import csv
import json

import numpy as np
import pytest
from conftest import EXIT_DONE, EXIT_INPUT, command
from pyulog import ULog

SHORT = {"run.duration_s": 2.0, "sensor.noise_N": 1.0}


@pytest.fixture(scope="module")
def exported(logs):
    """The log, its topics as pyulog reads them, and the files that were named."""
    _, log = logs("ess", SHORT)
    done = command("export", log, "--csv", "--parquet", "--mcap")
    assert done.returncode == EXIT_DONE, done.stderr.decode()
    return log, {data.name: data.data for data in ULog(str(log)).data_list}, done.stdout.decode().split()


def test_the_files_that_were_written_are_named(exported):
    log, topics, files = exported
    wanted = [log.with_suffix(f".{name}.{kind}") for kind in ("csv", "parquet") for name in topics]
    assert sorted(files) == sorted(map(str, [*wanted, log.with_suffix(".mcap")]))
    assert {"tick", "can_frame"} <= set(topics)


def test_csv_holds_every_digit(exported):
    log, topics, _ = exported
    for name, columns in topics.items():
        with log.with_suffix(f".{name}.csv").open(newline="") as file:
            header, *rows = csv.reader(file)
        assert sorted(header) == sorted(columns)
        for field, cells in zip(header, zip(*rows)):
            kind = float if columns[field].dtype.kind == "f" else int
            assert np.array_equal([kind(cell) for cell in cells], columns[field], equal_nan=True), field


def test_parquet_keeps_values_and_types(exported):
    import pyarrow.parquet
    log, topics, _ = exported
    for name, columns in topics.items():
        table = pyarrow.parquet.read_table(log.with_suffix(f".{name}.parquet"))
        assert sorted(table.column_names) == sorted(columns)
        for field, values in columns.items():
            read = table[field].to_numpy()
            assert read.dtype == values.dtype and np.array_equal(read, values, equal_nan=True), field


def test_mcap_holds_every_message_with_a_schema(exported):
    from mcap.reader import make_reader
    log, topics, _ = exported
    seen = {}
    with log.with_suffix(".mcap").open("rb") as file:
        for schema, channel, message in make_reader(file).iter_messages():
            assert (schema.encoding, channel.message_encoding) == ("jsonschema", "json")
            properties = json.loads(schema.data)["properties"]
            fields = json.loads(message.data)
            assert set(fields) <= set(properties) and message.log_time == 1000 * fields["timestamp"]
            seen.setdefault(channel.topic, []).append(fields)
    assert set(seen) == {f"/{name}" for name in topics}
    for name, columns in topics.items():
        for field, values in columns.items():
            read = [fields.get(field, np.nan) for fields in seen[f"/{name}"]]
            wanted = np.where(np.isfinite(values), values, np.nan) if values.dtype.kind == "f" else values
            assert np.array_equal(read, wanted, equal_nan=values.dtype.kind == "f"), field


@pytest.mark.parametrize("words, told", [([], "no format"), (["--xml"], "--xml")])
def test_a_format_that_is_none(words, told, logs):
    _, log = logs("ess", SHORT)
    done = command("export", log, *words)
    assert done.returncode == EXIT_INPUT and told in done.stderr.decode()


def test_a_file_that_is_no_log(tmp_path):
    (tmp_path / "x.ulg").write_text("nothing of the kind")
    done = command("export", tmp_path / "x.ulg", "--csv")
    assert done.returncode == EXIT_INPUT and "is not a ULog file" in done.stderr.decode()
