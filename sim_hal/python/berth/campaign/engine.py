"""Hands batches of samples to Dask's workers until the table is whole.

A batch whose worker died is cut into eight. A single sample whose worker died is tried again at the end, alone; if its
worker dies each time, the table says so in its row. So one rig that ends its worker costs no other sample.
"""
from __future__ import annotations

import os
import shutil
import time
from collections import deque
from concurrent.futures import CancelledError
from pathlib import Path

from ..errors import InputError
from . import sampling
from .cluster import connected, refuse_other_versions
from .evaluation import OtherVersion, evaluate, version, without_answer
from .progress import Progress, duration_words
from .spec import Spec
from .table import Table

BATCH_S = 2.0  # long enough that handing it over (about 5 ms) is nothing, short enough that little is lost
BATCH_ROWS_MAX = 65536
BATCHES_A_WORKER = 8  # at least, so that all end at about the same time
WAITING_A_WORKER = 3  # batches handed over ahead
PILOT = 8  # samples to time
ALONE_TRIES = 3
CUT = 8
DAY_s = 86400.0
ROW_BYTES = 24  # and 10 more for each column: on disk, compressed


class Interrupted(Exception):
    """Ended before the table was whole; the message says how far it is and how to go on."""


def run(spec: Spec, folder: str | os.PathLike, *, scheduler: str = "", slurm: bool = False, workers: int = 0,
        resume: bool = False, anew: bool = False, yes: bool = False, tell=lambda line: None) -> Path:
    """Evaluates all samples that are not yet there, and returns the path of the table.

    scheduler   address of a Dask scheduler that is there, "tcp://host:8786"; else workers start on this machine,
                or, with slurm, as Slurm's jobs
    workers     how many; 0: one for each core
    resume      go on with the samples that are there; anew: delete them
    yes         start even if it takes more than a day; tell: gets each line for a person
    InputError: wrong input, a scheduler that is not there, workers of another berth. Interrupted: go on with resume.
    """
    if sampling.is_too_large(spec):
        raise InputError(f"sample.count: the design of {spec.count} samples by {spec.method} does not fit into memory; "
                         "choose sample.method = \"sobol\"", "", "sample.count")
    with Table(spec, folder, resume, anew) as table:
        if not table.missing():
            return table.finish()
        if table.done_count():
            tell(f"{table.done_count():,} of {spec.count:,} samples are there already")
        with connected(scheduler, slurm and spec.slurm | {"workers": workers or spec.slurm.get("workers", 1)},
                       workers) as client:
            try:
                _Campaign(spec, table, client, tell).run(yes)
            except OtherVersion as error:
                raise InputError(f"{error}; two versions may give two tables: install the same one on all workers, then "
                                 "go on with --resume") from None
            except (CancelledError, OSError, TimeoutError) as error:
                raise Interrupted(f"the scheduler is gone ({type(error).__name__}); {table.done_count():,} of "
                                  f"{spec.count:,} samples are in {table.folder}; go on with --resume") from None
            except KeyboardInterrupt:
                raise Interrupted(f"stopped; {table.done_count():,} of {spec.count:,} samples are in {table.folder}; "
                                  "go on with --resume") from None
        return table.finish()


class _Campaign:
    def __init__(self, spec: Spec, table: Table, client, tell):
        self.spec, self.table, self.client, self.tell = spec, table, client, tell
        self.alone: deque[int] = deque()

    def run(self, yes: bool) -> None:
        refuse_other_versions(self.client, version)
        workers = max(len(self.client.scheduler_info(n_workers=-1)["workers"]), 1)
        todo = sum(count for _, count in self.table.missing())
        sample_s = self._time_a_sample()
        self._refuse_what_takes_too_long(todo, sample_s, workers, yes)
        size = self._batch_size(todo, sample_s, workers)
        self.tell(f"{todo:,} samples in batches of {size:,} on {workers} worker{'s' if workers > 1 else ''}, about "
                  f"{duration_words(todo * sample_s / workers)}; dashboard {self.client.dashboard_link}")
        batches = deque((at, min(size, first + count - at)) for first, count in self.table.missing()
                        for at in range(first, first + count, size))
        with Progress(self.spec.name, self.spec.count, self.table.done_count()) as self.progress:
            self._work_through(batches, WAITING_A_WORKER * workers)
            self._try_alone()

    def _submit(self, first: int, count: int):
        future = self.client.submit(evaluate, self.spec, first, count, version, pure=False)
        future.range = first, count
        return future

    def _time_a_sample(self) -> float:
        """By a worker, as it may end it: then a sample counts as a second."""
        count = min(PILOT, self.spec.count)
        first = self.table.missing()[0][0]
        try:
            count = min(count, self.spec.count - first)
            self.client.submit(evaluate, self.spec, first, 1, version, pure=False).result()
            return self.client.submit(_timed, self.spec, first, count, version, pure=False).result()
        except (OtherVersion, CancelledError, OSError, TimeoutError):
            raise
        except Exception:
            return 1.0

    def _refuse_what_takes_too_long(self, todo: int, sample_s: float, workers: int, yes: bool) -> None:
        whole_s = todo * sample_s / workers
        needed = todo * (ROW_BYTES + 10 * len(self.spec.inputs))
        free = shutil.disk_usage(self.table.folder).free
        if whole_s > DAY_s and not yes:
            raise InputError(f"sample.count: {todo:,} samples take about {duration_words(whole_s)} on {workers} "
                             f"worker{'s' if workers > 1 else ''} ({1e3 * sample_s:.3g} ms each) and about "
                             f"{needed / 1e9:.2g} GB; start it all the same with --yes, or ask for fewer samples, or "
                             "for more workers with --scheduler or --slurm", "", "sample.count")
        if 2 * needed > free and not yes:
            raise InputError(f"{self.table.folder}: {todo:,} samples want about {2 * needed / 1e9:.2g} GB meanwhile, and "
                             f"{free / 1e9:.2g} GB are free; choose another disk with --out, or start with --yes")

    @staticmethod
    def _batch_size(todo: int, sample_s: float, workers: int) -> int:
        by_time = int(BATCH_S / max(sample_s, 1e-9))
        return max(1, min(by_time, todo // (BATCHES_A_WORKER * workers), BATCH_ROWS_MAX))

    def _work_through(self, batches: deque, window: int) -> None:
        from dask.distributed import as_completed
        waiting = as_completed()
        while batches or not waiting.is_empty():
            while batches and waiting.count() < window:
                waiting.add(self._submit(*batches.popleft()))
            for future in waiting.next_batch():
                batches.extendleft(self._take(future))

    def _take(self, future) -> list[tuple[int, int]]:
        """Its rows into the table; or the batches that it is to be cut into."""
        first, count = future.range
        try:
            rows = future.result()
        except (OtherVersion, CancelledError, OSError, TimeoutError):
            raise
        except Exception:  # its worker died, or has no memory left
            if count == 1:
                self.alone.append(first)
                return []
            size = -(-count // CUT)
            return [(at, min(size, first + count - at)) for at in range(first, first + count, size)]
        self.table.add(rows)
        self.progress.add(count)
        return []

    def _try_alone(self) -> None:
        while self.alone:
            first = self.alone.popleft()
            for _ in range(ALONE_TRIES):
                try:
                    rows = self._submit(first, 1).result()
                    break
                except (OtherVersion, CancelledError, OSError, TimeoutError):
                    raise
                except RuntimeError as error:  # of evaluate(): it would come again
                    rows = without_answer(self.spec, first, "failed", str(error))
                    break
                except Exception:
                    rows = without_answer(self.spec, first, "lost", f"its worker died {ALONE_TRIES} times")
            self.table.add(rows)
            self.progress.add(1)


def _timed(spec: Spec, first: int, count: int, commit: str) -> float:
    """Time of a sample, s, by the shortest of three; the first call of a worker also loads libraries."""
    found = []
    for _ in range(3):
        begin = time.perf_counter()
        evaluate(spec, first, count, commit)
        found.append((time.perf_counter() - begin) / count)
        if found[-1] > 0.3:
            break
    return min(found)
