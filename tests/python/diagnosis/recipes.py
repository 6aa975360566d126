"""How a record is made: a recipe is a function that writes a record into a folder, with the values for it.

The functions with `@recipe` stand in make_*.py, by what they move: a robot alone, an object in a grip, a manipulator.
Those here start a program: `run` is a `berth run`, `hidden` the generator of tests/hidden_effects, `changed` alters the
columns of another record. A record's folder holds record.csv or a log, perhaps rig.toml, validate.csv, repeat.csv and
standstill.csv (or a log in a folder of that name), and in truth.json what the maker returned: what the record hides.
"""

import functools
import gzip
import json
import pathlib
import shlex
import sys
from dataclasses import dataclass, field

import numpy as np
import pytest
from conftest import EXIT_DONE, ROOT, command, data_folder, settings
from record_store import digest, made_once

HERE = pathlib.Path(__file__).resolve().parent
GENERATOR = ROOT / "tests" / "hidden_effects"
MAKERS = [*HERE.glob("make_*.py"), HERE / "recipes.py", HERE.parent / "conftest.py"]
BESIDE = ("validate", "repeat", "standstill")  # records that go with the option of that name


@functools.cache
def program_digest():
    return digest(ROOT / "build" / "berth")


@functools.cache
def sources_digest():
    return digest(*MAKERS)


@functools.cache
def generator_digest():
    return digest(*GENERATOR.glob("*.py"), *(path for path in (GENERATOR / "engine").rglob("*") if path.is_file()))


def described(value):
    """A JSON value that says what `value` is."""
    if isinstance(value, Recipe):
        return value.key()
    if isinstance(value, functools.partial):
        return [described(value.func), described(value.args), described(value.keywords)]
    if callable(value):
        assert "<lambda>" not in value.__qualname__, "a recipe's functions need names"
        return f"{value.__module__}.{value.__qualname__}"
    if isinstance(value, dict):
        return {str(key): described(one) for key, one in value.items()}
    if isinstance(value, (list, tuple)):
        return [described(one) for one in value]
    return repr(value)


@dataclass(frozen=True)
class Recipe:
    """A function `make(folder, **given)`; `used`: functions that give digests of what else decides the record."""

    make: object
    given: dict = field(hash=False)
    used: tuple = ()

    def key(self):
        return [described(self.make), described(self.given), sources_digest(), [one() for one in self.used]]

    def folder(self):
        """The folder of the record, made now if it is not there yet."""
        return made_once(self.key(), self.fill)

    def fill(self, folder):
        truth = self.make(folder, **self.given)
        if truth is not None:
            (folder / "truth.json").write_text(json.dumps(truth, default=float))


def recipe(*used):
    """Turns a function `make(folder, **given)` into one that gives the recipe."""
    def turn(make):
        @functools.wraps(make)
        def with_values(**given):
            return Recipe(make, given, used)
        return with_values
    return turn


# --- files --------------------------------------------------------------------------------------------------------
def save(path, digits=12, **columns):
    """Writes the columns as CSV; `digits`: significant ones, None for all."""
    if digits is None:
        rows = "".join(",".join(repr(float(value)) for value in row) + "\n" for row in zip(*columns.values()))
        path.write_text(",".join(columns) + "\n" + rows)
    else:
        np.savetxt(path, np.column_stack(list(columns.values())), delimiter=",", header=",".join(columns), comments="",
                   fmt=f"%.{digits}g")
    return path


def columns_of(path):
    """{name: values} of a CSV file."""
    with path.open() as file:
        names = file.readline().strip().split(",")
        table = np.loadtxt(file, delimiter=",", ndmin=2)
    return dict(zip(names, table.T))


def record_in(folder):
    """The record of a folder: record.csv, or the one log."""
    [record] = [*folder.glob("record.csv*"), *folder.glob("*.ulg")]
    return record


def beside(folder):
    """The options for the records that go with it: repeat.csv, or a log in repeat/."""
    found = {name: sorted(folder.glob(f"{name}.csv*")) or sorted(folder.glob(f"{name}/*.ulg")) for name in BESIDE}
    return [word for name, paths in found.items() for path in paths for word in (f"--{name}", path)]


# --- records that a program makes ---------------------------------------------------------------------------------
def berth(*words):
    done = command(*words)
    assert done.returncode == EXIT_DONE, done.stderr.decode()
    return done


@recipe(program_digest)
def run(folder, rig="ess", **keys):
    """The log of a run; `keys`: its settings, with two underscores for the point."""
    values = {key.replace("__", "."): value for key, value in keys.items()}
    if (HERE / "rigs" / f"{rig}.toml").exists():
        rig = HERE / "rigs" / f"{rig}.toml"
    berth("run", rig, *settings(values), "--out", folder)


def run_with(values, rig="ess"):
    """The recipe of a run with these settings, {key: value}."""
    return run(rig=rig, **{key.replace(".", "__"): value for key, value in values.items()})


@recipe(program_digest)
def as_table(folder, log, names=None):
    """The signals of a log as CSV: t_s, positions and forces, or those of `names`."""
    berth("diagnose", record_in(log.folder()), "--rig", "ess", "--out", folder / "told")
    columns = columns_of(folder / "told" / "series.csv")
    kept = names or [name for name in columns if name == "t_s" or name.endswith(("force_N", "position_m"))]
    save(folder / "record.csv", **{name: columns[name] for name in kept})


@recipe()
def changed(folder, record, by, digits=12, **given):
    """Another record with its columns changed: `by(columns, **given)` gives the new ones. A further table of columns in
    `by`'s result under "validate", "repeat" or "standstill" is a record beside it."""
    columns = by(columns_of(record.folder() / "record.csv"), **given)
    for name in BESIDE:
        if name in columns:
            save(folder / f"{name}.csv", digits, **columns.pop(name))
    save(folder / "record.csv", digits, **columns)


@recipe(generator_digest)
def hidden(folder, seed, kind=None, effect=None, size=None, rows=None, missing=()):
    """A record of tests/hidden_effects. With `rows`, its beginning alone and nothing beside it; without the rows that
    are `missing`."""
    sys.path.insert(0, str(GENERATOR))
    from generate import write
    from scenario import draw

    truth = write(draw(seed, effect, size, kind), folder, folder / "truth")
    lines = (folder / "record.csv").read_text().splitlines(keepends=True)
    if rows is not None:
        lines = lines[:rows + 1]
        for name in BESIDE:
            (folder / f"{name}.csv").unlink(missing_ok=True)
    gone = set(missing)
    (folder / "record.csv").write_text("".join(line for n, line in enumerate(lines) if n - 1 not in gone))
    return truth


@recipe()
def logged_late(folder, record, column, rows):
    """Another record, and those beside it, with one column written some rows below where its values belong."""
    for path in record.folder().glob("*.csv"):
        columns = columns_of(path)
        values = columns[column]
        late = np.concatenate(([values[0]] * rows, values[:-rows]))
        save(folder / path.name, digits=None, **(columns | {column: late}))
    if (record.folder() / "rig.toml").exists():
        (folder / "rig.toml").write_text((record.folder() / "rig.toml").read_text())


def again(recipe_of_it):
    """The command that makes a hidden record again."""
    given = {name: value for name, value in recipe_of_it.given.items() if name in ("seed", "kind", "effect", "size")}
    words = [word for name, value in given.items() if value is not None for word in (f"--{name}", str(value))]
    return "again: python tests/hidden_effects/generate.py " + shlex.join(words) + " --out A --truth B"


def where_data_are():
    return str(data_folder())


@recipe(where_data_are)
def measured(folder, record, validate=None, rig=None, keeps=None):
    """Measured data of $BERTH_DATA; says loudly if they are not there. `rig`: the text of a rig file; `keeps(row)`: 0 for
    a row of the record, 1 for one of the validation, None for one that is left out."""
    for name, path in (("record", record), ("validate", validate)):
        if path is not None:
            (folder / f"{name}.csv.gz").symlink_to(data_file(path))
    if keeps:
        header, *rows = gzip.open(folder / "record.csv.gz", "rt").read().splitlines()
        (folder / "record.csv.gz").unlink()
        for number, name in enumerate(("record", "validate")):
            (folder / f"{name}.csv").write_text("\n".join([header, *(row for row in rows if keeps(row) == number)]) + "\n")
    if rig is not None:
        (folder / "rig.toml").write_text(rig)


def data_file(path):
    """A file of measured data; says loudly if it is not there."""
    data = data_folder()
    if not data or not (data / path).exists():
        pytest.skip(f"NOT TRIED ON MEASURED DATA: no {path} in $BERTH_DATA or ../shared/data")
    return data / path
