"""Of each kind of test that full_tier.csv leaves to `make full-test`, `make test` keeps one."""

import subprocess
import sys

from conftest import ROOT, in_full_tier


def names(marks):
    """Tests of these marks, without their folder."""
    done = subprocess.run([sys.executable, "-m", "pytest", "--collect-only", "-q", "-p", "no:cacheprovider", "-m", marks,
                           "tests/python"], cwd=ROOT, capture_output=True, text=True, check=True)
    return [line.removeprefix("python/") for line in done.stdout.splitlines() if "::" in line]


def test_what_moved_is_there_and_one_of_its_kind_stays():
    slow, others = names("slow"), names("not slow")
    for row in in_full_tier():
        assert any(name.startswith(row["moved"]) for name in slow), f"no test is named {row['moved']}"
        assert any(name.startswith(row["stays"]) for name in others), f"nothing stays of {row['moved']}: {row['stays']}"
