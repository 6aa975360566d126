"""A run of hours takes no more memory than one of minutes, and says the same."""
import json
import os
import subprocess

import pytest
from conftest import ROOT

LONG_s = 6000  # 2.4 million ticks: twice as many as are kept


def peak_memory_kB(duration_s, folder):
    """Of a run without a log, and what it says."""
    with open(folder / "result.json", "wb") as output:
        process = subprocess.Popen([ROOT / "build/berth", "run", "ess", "--no-log", "--json", "--set",
                                    f"run.duration_s={duration_s}"], stdout=output)
        _, status, usage = os.wait4(process.pid, 0)
    assert status == 0
    return usage.ru_maxrss, json.loads((folder / "result.json").read_text())


@pytest.mark.long
def test_a_longer_run_takes_no_more_memory(tmp_path):
    memory_kB, result = peak_memory_kB(LONG_s, tmp_path)
    longer_kB, longer = peak_memory_kB(3 * LONG_s, tmp_path)
    assert longer_kB < memory_kB + 4000, (memory_kB, longer_kB)
    assert memory_kB < 300_000
    for key in ("verdict", "growth_per_s", "frequency_Hz", "peak_force", "margin"):
        assert result[key] == longer[key], key
    assert result["energy"]["gains"] is longer["energy"]["gains"] is False
