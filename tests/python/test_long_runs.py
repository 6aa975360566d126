"""A run of hours takes no more memory than one of minutes, and says the same."""
import json
import subprocess

import pytest
from conftest import ROOT

LONG_s = 6000  # 2.4 million ticks: twice as many as are kept
MEMORY_kB = 250_000  # of addresses; 24 h had taken 1.3 GB


def result(duration_s):
    """Of a run without a log that has no more memory than that."""
    done = subprocess.run(f"ulimit -v {MEMORY_kB}; exec {ROOT}/build/berth run ess --no-log --json --set run.duration_s={duration_s}",
                          shell=True, capture_output=True, check=False, timeout=120)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.mark.long
def test_a_longer_run_takes_no_more_memory():
    short, longer = result(LONG_s), result(4 * LONG_s)
    for key in ("verdict", "growth_per_s", "peak_force", "margin"):
        assert short[key] == longer[key], key
    assert short["energy"]["gains"] is longer["energy"]["gains"] is False
