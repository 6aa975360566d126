"""Dask's scheduler and workers: on this machine, at an address, or as Slurm's jobs."""
from __future__ import annotations

import contextlib
import logging
import os
import shutil

from ..errors import InputError

CONNECT_S = 10
SLURM_WAIT_S = 600


def needed(module: str, what: str):
    """An import that a campaign wants and the package alone does not."""
    import importlib
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise InputError(f"{what} needs the Python package {error.name}; install it with: pip install "
                         "'berth[campaign]'") from None


@contextlib.contextmanager
def connected(scheduler: str, slurm: dict | bool, workers: int):
    """A client of the cluster, which is shut down at the end if it was started here."""
    distributed = needed("dask.distributed", "a campaign")
    for name in ("distributed", "distributed.nanny", "distributed.core", "distributed.scheduler", "distributed.comm"):
        logging.getLogger(name).setLevel(logging.CRITICAL)  # the campaign itself reports a worker that died
    if scheduler:
        with _client_of(distributed, scheduler) as client:
            yield client
        return
    with (_slurm(slurm) if slurm else _local(distributed, workers)) as cluster, \
            distributed.Client(cluster, timeout=CONNECT_S) as client:
        if slurm:
            _wait_for_a_worker(client, "Slurm has started no worker", "see squeue")
        yield client


def _local(distributed, workers: int):
    import dask
    dask.config.set({"distributed.scheduler.allowed-failures": 0,  # the campaign tries again itself
                     "distributed.worker.memory.terminate": 0.95,
                     "distributed.worker.profile.enabled": False})  # it looks at each worker every 10 ms
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        os.environ.setdefault(name, "1")
    return distributed.LocalCluster(n_workers=workers or _cores(), threads_per_worker=1, host="127.0.0.1",
                                    dashboard_address="127.0.0.1:0", silence_logs=logging.CRITICAL)


def _cores() -> int:
    return len(os.sched_getaffinity(0))


def _slurm(options: dict):
    jobqueue = needed("dask_jobqueue", "--slurm")
    if shutil.which("sbatch") is None:
        raise InputError("--slurm: sbatch is not on this machine; start the campaign where Slurm takes jobs, or use "
                         "--scheduler", "--slurm")
    options = dict(options)
    workers = options.pop("workers", 1)
    options = {"cores": 1, "memory": "2GB", "walltime": "01:00:00"} | options
    try:
        cluster = jobqueue.SLURMCluster(processes=options["cores"], **options)
        cluster.scale(workers)
    except (OSError, ValueError, RuntimeError) as error:
        raise InputError(f"--slurm: {error}; is sbatch on this machine, and does [slurm] name a queue of it?",
                         "--slurm") from None
    return cluster


def _client_of(distributed, address: str):
    try:
        client = distributed.Client(address, timeout=CONNECT_S)
    except (OSError, TimeoutError, ValueError) as error:
        raise InputError(f"--scheduler {address}: no scheduler answers there within {CONNECT_S} s "
                         f"({type(error).__name__}); start one with `dask scheduler`, and workers with `dask worker "
                         f"{address}`, or leave --scheduler out", "--scheduler") from None
    try:
        _wait_for_a_worker(client, f"--scheduler {address}: has no worker", f"start one with `dask worker {address}`",
                           CONNECT_S)
    except InputError:
        client.close()
        raise
    return client


def _wait_for_a_worker(client, what: str, remedy: str, timeout_s: float = SLURM_WAIT_S) -> None:
    try:
        client.wait_for_workers(1, timeout=timeout_s)
    except TimeoutError:
        raise InputError(f"{what} within {timeout_s:g} s; {remedy}", "--scheduler") from None


def _version() -> str:
    try:
        from berth.campaign import evaluation
        return evaluation.version
    except ImportError:
        return "none that knows campaigns"


def refuse_other_versions(client, mine: str) -> None:
    """All workers have the berth of the campaign: else their numbers may differ."""
    others = {worker: found for worker, found in client.run(_version).items() if found != mine}
    if others:
        worker, found = next(iter(others.items()))
        raise InputError(f"{len(others)} of the workers have another berth, such as {worker}: {found}, and the campaign "
                         f"{mine}; two versions may give two tables: install the same one everywhere", worker)
