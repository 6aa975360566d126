"""Force sensors of several frames a sample over the kernel's CAN stack: samples are put together here once more, from
what candump saw and cantools decodes, and compared with the loop's log."""

import re
import subprocess

import numpy as np
import pytest
from conftest import ROOT
from target_log import TargetLog

CANTOOLS = ROOT / ".venv" / "bin" / "cantools"
DBC = ROOT / "firmware" / "can" / "berth.dbc"
RUNS = {layout: (int(rate_Hz), foreign) for layout, rate_Hz, foreign in re.findall(
    r"^run_with (\w+) (\d+) (\S+)$", (ROOT / "tests/target/steps/sensor_layouts.sh").read_text(), re.MULTILINE)}
DURATION_s = 3
PERIOD_ms = 2.5


@pytest.fixture(params=RUNS)
def run(request, guest):
    """(layout, its log, the step)"""
    step = guest("sensor_layouts")
    step.check_done()
    layout = request.param
    assert step.number(f"{layout}.exit_code") == 0, step.text(f"{layout}.stdout")
    return layout, TargetLog(step.path(f"{layout}.ulg")), step


def decoded(text):
    """`cantools decode` of candump text: the signals of each frame."""
    done = subprocess.run([CANTOOLS, "decode", "--single-line", DBC], input=text, capture_output=True, text=True,
                          check=True)
    signals = re.findall(r" :: \w+\((.*)\)", done.stdout)
    assert len(signals) == len(text.splitlines())
    return [{name: float(value) for name, value in re.findall(r"(\w+): ([-+.\w]+)", frame)} for frame in signals]


def samples(frames):
    """Force along z of each whole sample. Frames without a number come one after the other, the forces first."""
    forces, parts = [], {}
    for frame in frames:
        is_first = parts.get("counter") != frame["counter"] if "counter" in frame else "fz_N" in frame
        if is_first:
            parts = {}
        parts |= frame
        axes = {name[:2] for name in parts if name.endswith(("_N", "_m")) and not name.startswith("tx_high")}
        if len(axes) == 6:
            forces.append(parts["fz_N"])
    return forces


def test_the_loop_runs_on_it(run):
    layout, log, _ = run
    assert log.states() == ["start", "ready", "running"]
    assert log.missed_ticks() == 0
    assert log.tick["force_samples"][log.before_end][-1] == pytest.approx(DURATION_s * RUNS[layout][0], abs=15)


def test_its_forces_are_those_that_candump_saw_and_cantools_decodes(run):
    """In their order, each tick the newest: no sample is made of two. The foreign frame costs the sample that it falls
    into, or, with the number of one of the next two, those up to it."""
    layout, log, step = run
    lines = step.text(f"{layout}.candump").splitlines(keepends=True)
    own = [line for line in lines if line.split()[2] != RUNS[layout][1]]
    assert len(own) == len(lines) - 1
    seen = samples(decoded("".join(own)))
    rejected = 0
    for taken, used in zip(log.tick["force_samples"].astype(int), log.tick["force_N"], strict=True):
        while taken > 0 and abs(seen[taken + rejected - 1] - used) > 1e-9:
            rejected += 1
            assert rejected <= 3, f"after {taken} samples the loop used {used} N"
    assert np.ptp(log.tick["force_N"]) > 30


def test_a_foreign_frame_is_found_and_counted(run):
    _, log, _ = run
    found = log.tick["torn_samples"] + log.tick["rejected_frames"]  # rejected: its number is that of an older sample
    assert found[-1] >= 1
    changes = np.flatnonzero(np.diff(found))
    assert np.all(np.abs(changes * 0.0025 - 1.6) < 0.2)


def test_the_age_of_the_force_is_in_the_log(run):
    """At most what a sample period and the far end's lead allow."""
    layout, log, _ = run
    running = log.before_end & (np.arange(len(log.before_end)) > 100)
    ages_ms = log.tick["force_frame_age_ns"][running] / 1e6
    sample_ms = 1e3 / RUNS[layout][0]
    oldest_ms = sample_ms + 0.5
    assert 0 < ages_ms.min()
    # The foreign frame tears a sample, and two that its counter is ahead of are passed over: LATE_SAMPLES_MAX.
    passed_over_ms = 3 * sample_ms
    assert ages_ms.max() < oldest_ms + passed_over_ms
    assert np.count_nonzero(ages_ms >= 2 * oldest_ms) <= np.ceil(passed_over_ms / PERIOD_ms)
