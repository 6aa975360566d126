"""What the tests of campaigns share: a small campaign, and workers that something happens to."""

import os
import subprocess
import sys
import textwrap

import pyarrow.parquet as pq
from conftest import command

TOLERANCES = """
rig = "ess"
ask = ["growth"]

[sample]
method = "sobol"
count = {count}
seed = 7

[vary]
"object.mass_kg" = {{ mean = 190, sigma = 10 }}
"robot.dead_time_ms" = {{ from = 10, to = 25 }}
"""


def written(folder, count=256, text=TOLERANCES, name="tolerances.toml"):
    path = folder / name
    path.write_text(text.format(count=count))
    return path


def campaign(file, *words, workers=2, **options):
    """`berth campaign FILE` to its end."""
    return command("campaign", file, "--workers", workers, *words, **options)


def rows_of(folder):
    return pq.read_table(folder / "samples.parquet")


def with_preload(folder, code):
    """The environment in which every worker first runs `code`, once; there `whole(spec, inputs, count)` computes
    growth, and what is called `instead` takes its place."""
    path = folder / "preload.py"
    path.write_text("import os\nimport time\nfrom berth.campaign import evaluation\n"
                    "if evaluation._growth_at_once.__name__ != 'instead':\n    whole = evaluation._growth_at_once\n"
                    f"{textwrap.dedent(code)}\nevaluation._growth_at_once = instead\n")
    return {**os.environ, "DASK_DISTRIBUTED__WORKER__PRELOAD": str(path)}


def dask(*words, **options):
    """`dask scheduler` or `dask worker`, as a process."""
    return subprocess.Popen([sys.executable, "-m", "distributed.cli.dask_" + words[0], *map(str, words[1:])],
                            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, **options)
