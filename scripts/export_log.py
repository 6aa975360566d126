#!/usr/bin/env python3
"""Writes the topics of a log for other programs; `berth export` calls it.

CSV and Parquet: one file a topic, LOG.TOPIC.csv and LOG.TOPIC.parquet, a column a field. MCAP: all topics in LOG.mcap,
as JSON with a schema each, as Foxglove opens it. Prints the files that it has written.
"""
import argparse
import csv
import io
import json
import sys
from pathlib import Path

import progress
from berth_log import InputError, write_whole
from pyulog import ULog

EXIT_INPUT = 2
NS_PER_US = 1000


def topics_of(path):
    """{topic: {field: values}}, the fields in the order of the log's formats."""
    log = ULog(str(path))
    return {data.name: {field.field_name: data.data[field.field_name] for field in data.field_data}
            for data in log.data_list}


def plain(values):
    """As Python's own numbers, which print with all of their digits."""
    return values.tolist()


def csv_bytes(columns):
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*map(plain, columns.values())))
    return text.getvalue().encode()


def parquet_bytes(columns):
    import pyarrow
    import pyarrow.parquet
    made = pyarrow.BufferOutputStream()
    pyarrow.parquet.write_table(pyarrow.table(columns), made)
    return made.getvalue().to_pybytes()


def schema_of(name, columns):
    """JSON Schema of a topic's messages."""
    kinds = {field: "number" if values.dtype.kind == "f" else "integer" for field, values in columns.items()}
    return {"title": f"berth.{name}", "type": "object",
            "properties": {field: {"type": kind} for field, kind in kinds.items()}}


def mcap_bytes(topics):
    from mcap.writer import CompressionType, Writer
    made = io.BytesIO()
    writer = Writer(made, compression=CompressionType.ZSTD)
    writer.start(profile="", library="berth")
    messages = []
    for name, columns in topics.items():
        schema = writer.register_schema(name=f"berth.{name}", encoding="jsonschema",
                                        data=json.dumps(schema_of(name, columns)).encode())
        channel = writer.register_channel(topic=f"/{name}", message_encoding="json", schema_id=schema)
        rows = zip(*map(plain, columns.values()))
        messages += [(int(t_us) * NS_PER_US, channel, dict(zip(columns, row)))
                     for t_us, row in zip(columns["timestamp"], rows)]
    messages.sort(key=lambda message: message[0])
    for sequence, (time_ns, channel, message) in enumerate(messages):
        # No NaN in JSON: such a value is left out of its message.
        finite = {field: value for field, value in message.items() if value == value and abs(value) != float("inf")}
        writer.add_message(channel, log_time=time_ns, publish_time=time_ns, sequence=sequence,
                           data=json.dumps(finite).encode())
    writer.finish()
    return made.getvalue()


def export(log, formats):
    """Yields each path and its content."""
    topics = topics_of(log)
    for kind, bytes_of in (("csv", csv_bytes), ("parquet", parquet_bytes)):
        if kind in formats:
            for name, columns in topics.items():
                progress.show(f"export: {name} as {kind}")
                yield log.with_suffix(f".{name}.{kind}"), bytes_of(columns)
    if "mcap" in formats:
        progress.show("export: every message as MCAP")
        yield log.with_suffix(".mcap"), mcap_bytes(topics)


def main():
    progress.end_with_the_pipe()
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("log", metavar="LOG", type=Path, help="a .ulg file written by `berth run`")
    for kind in ("csv", "parquet", "mcap"):
        parser.add_argument(f"--{kind}", action="store_true")
    arguments = parser.parse_args()
    formats = {kind for kind in ("csv", "parquet", "mcap") if getattr(arguments, kind)}
    try:
        for path, content in export(arguments.log, formats):
            write_whole(path, content)
            progress.show()
            print(path)
    except ImportError as error:
        progress.show()
        print(f"berth: {error.name} is not installed; `make setup` installs it", file=sys.stderr)
        return EXIT_INPUT
    except (InputError, OSError) as error:
        progress.show()
        print(f"berth: {error}", file=sys.stderr)
        return EXIT_INPUT
    return 0


if __name__ == "__main__":
    sys.exit(main())
