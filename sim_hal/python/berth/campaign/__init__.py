"""Campaigns: many rigs that differ from one as a file says, evaluated by Dask's workers, in one table.

`berth campaign FILE.toml` runs one, `berth campaign report` says what came out. From Python:

>>> from berth.campaign import Spec, report, run
>>> spec = Spec.load("tolerances.toml")  # doctest: +SKIP
>>> table = run(spec, "build/campaigns/tolerances")  # doctest: +SKIP
>>> report(table).p_stable  # doctest: +SKIP

sampling   which samples there are; evaluation: what a worker does with a few of them
engine     hands batches to workers until the table is whole; table: the files that make it
report     what the table says; page: the same with pictures
"""
from .spec import Spec

__all__ = ["Spec", "report", "run"]


def run(*arguments, **options):
    """See engine.run()."""
    from .engine import run as run_campaign
    return run_campaign(*arguments, **options)


def report(*arguments, **options):
    """See report.summarise()."""
    from .report import summarise
    return summarise(*arguments, **options)
