"""The files of a campaign. Each batch is a file of its own as soon as it is there; at the end they become one table.

    FOLDER/campaign.toml          the campaign file, as it was
    FOLDER/campaign.json          what decides the table, and the commit
    FOLDER/parts/FIRST-LAST.parquet
    FOLDER/samples.parquet        the table; then there are no parts any more

A file has its name only when it is whole and on the disk. So whatever ends a campaign, what has a name counts, and the
rest is computed again.
"""
from __future__ import annotations

import fcntl
import json
import os
import shutil
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from ..errors import InputError
from .evaluation import schema, version
from .spec import Spec

ROWS_IN_A_GROUP = 65536  # of the table: the same whatever the batches were


def _on_disk(path: Path, write) -> None:
    """Calls write(a path beside it) and gives the file its name."""
    unfinished = path.with_name(f".{path.name}.unfinished")
    try:
        write(unfinished)
        with open(unfinished, "rb") as file:
            os.fsync(file.fileno())
        os.replace(unfinished, path)
    except OSError as error:
        unfinished.unlink(missing_ok=True)
        raise InputError(f"{path}: cannot be written: {error.strerror or error}; what was written before is whole. "
                         "Make room, and go on with --resume", str(path)) from None


class Table:
    """The folder of one campaign, kept from other processes while this one writes."""

    def __init__(self, spec: Spec, folder: str | os.PathLike, resume: bool = False, anew: bool = False):
        self.spec, self.folder = spec, Path(folder)
        self.parts = self.folder / "parts"
        self.path = self.folder / "samples.parquet"
        try:
            self.parts.mkdir(parents=True, exist_ok=True)
            self._lock = open(self.folder / ".lock", "w")
        except OSError as error:
            raise InputError(f"{self.folder}: {error.strerror}; choose another folder with --out",
                             str(self.folder)) from None
        self._take()
        if anew:
            self._clear()
        self._begin(resume)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._lock.close()

    def _take(self) -> None:
        try:
            fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise InputError(f"{self.folder}: another process runs a campaign here; wait for it, or choose another "
                             "folder with --out", str(self.folder)) from None

    def _clear(self) -> None:
        for path in (self.path, *self.parts.glob("*.parquet")):
            path.unlink(missing_ok=True)

    def _begin(self, resume: bool) -> None:
        about = self.folder / "campaign.json"
        mine = {"identity": self.spec.identity, "commit": version, "spec": self.spec.to_json()}
        if self.path.exists() or any(self.parts.glob("*.parquet")):
            if not resume:
                raise InputError(f"{self.folder}: has {self.done_count()} of {self.spec.count} samples already; go on "
                                 "with --resume, delete them with --anew, or choose another folder with --out", str(self.folder))
            try:
                theirs = json.loads(about.read_text())
            except (OSError, ValueError):
                raise InputError(f"{about}: is missing or damaged; begin anew in another folder with --out",
                                 str(about)) from None
            if theirs["identity"] != mine["identity"]:
                raise InputError(f"{self.folder}: its samples are of another campaign file; begin anew in another "
                                 "folder with --out", str(self.folder))
            if theirs["commit"] != version:
                raise InputError(f"{self.folder}: was begun with berth {theirs['commit']}, and this is {version}; "
                                 "go on with that one, or begin anew in another folder with --out", str(self.folder))
        else:
            _on_disk(about, lambda path: path.write_text(json.dumps(mine, indent=1) + "\n"))
            if self.spec.text:
                _on_disk(self.folder / "campaign.toml", lambda path: path.write_text(self.spec.text))
        for left in self.parts.glob(".*.unfinished"):
            left.unlink()

    def _ranges(self) -> list[tuple[int, int]]:
        """(first, behind the last) of each part, in order."""
        found = [tuple(map(int, path.stem.split("-"))) for path in self.parts.glob("*.parquet")]
        return sorted((first, last + 1) for first, last in found)

    def done_count(self) -> int:
        if self.path.exists():
            return self.spec.count
        return sum(end - begin for begin, end in self._ranges())

    def missing(self) -> list[tuple[int, int]]:
        """(first, count) of each stretch of samples that has no part."""
        if self.path.exists():
            return []
        gaps, at = [], 0
        for begin, end in [*self._ranges(), (self.spec.count, self.spec.count)]:
            if begin > at:
                gaps.append((at, begin - at))
            at = end
        return gaps

    def add(self, rows: pa.Table) -> None:
        """A batch of samples, in order and without a gap."""
        first = rows["sample"][0].as_py()
        name = f"{first:015d}-{first + rows.num_rows - 1:015d}.parquet"
        _on_disk(self.parts / name, lambda path: pq.write_table(rows, path))

    def finish(self) -> Path:
        """All parts as one table, whose bytes do not depend on the batches."""
        if self.path.exists():
            return self.path
        if self.missing():
            raise AssertionError("samples are missing")
        _on_disk(self.path, self._merge)
        shutil.rmtree(self.parts, ignore_errors=True)
        return self.path

    def _merge(self, path: Path) -> None:
        columns, waiting, waiting_rows, rows = schema(self.spec), [], 0, 0
        with pq.ParquetWriter(path, columns, compression="zstd") as writer:
            for first, last in self._ranges():
                part = pq.read_table(self.parts / f"{first:015d}-{last - 1:015d}.parquet", schema=columns)
                waiting.append(part)
                waiting_rows += part.num_rows
                rows += part.num_rows
                while waiting_rows >= ROWS_IN_A_GROUP or (rows == self.spec.count and waiting_rows):
                    whole = pa.concat_tables(waiting)
                    writer.write_table(whole.slice(0, ROWS_IN_A_GROUP).combine_chunks())
                    waiting = [whole.slice(ROWS_IN_A_GROUP)]
                    waiting_rows = waiting[0].num_rows
        if rows != self.spec.count:
            raise AssertionError(f"{rows} rows of {self.spec.count}")
