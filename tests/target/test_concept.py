"""Touch and push, over the kernel's CAN stack: foam lets the loop come to rest, a copper sheet does not."""

import numpy as np
import pytest
from conftest import berth
from target_log import TargetLog

MATERIALS = ["foam", "copper", "arm-foam", "arm-copper"]
BOUNCE_TICKS = 280  # of the last bounces in simulation


@pytest.fixture
def step(guest):
    step = guest("concept")
    step.check_done()
    return step


@pytest.fixture
def log(step):
    return lambda material: TargetLog(step.path(f"{material}.ulg"))


@pytest.fixture
def simulated(tmp_path):
    return lambda material: TargetLog(
        berth("run", f"concept-{material}", "--set", "run.duration_s=10", "--out", tmp_path)["log"])


@pytest.mark.parametrize("material", MATERIALS)
def test_every_tick_is_there_and_replays_bit_for_bit(step, log, material):
    log(material).check_no_tick_is_missing()
    assert log(material).missed_ticks() == 0
    step.check_replays(f"{material}.ulg")


@pytest.mark.parametrize("foam, rest", [("foam", 0.01), ("arm-foam", 0.04)])  # the arm's joints swing on for longer
def test_foam_comes_to_rest_under_the_push(foam, rest, step, log, simulated):
    here, there = log(foam), simulated(foam)
    assert step.number(f"{foam}.exit_code") == 0
    assert here.states() == ["start", "ready", "running"]
    force_N = here.tick["force_N"][here.before_end]
    assert force_N.max() == pytest.approx(there.tick["force_N"].max(), rel=0.02)
    assert np.ptp(force_N[-400:]) < rest * force_N.max()
    assert force_N[-400:].mean() == pytest.approx(there.tick["force_N"][-400:].mean(), rel=0.02)


@pytest.mark.parametrize("copper", ["copper", "arm-copper"])
def test_copper_throws_the_robot_out_of_its_limits(copper, log, simulated):
    here, there = log(copper), simulated(copper)
    assert here.states() == there.states() == ["start", "ready", "running", "fault"]
    assert here.stop_cause() == there.stop_cause() == "position_limit"
    first = [int(np.argmax(np.abs(one.tick["force_N"]) > 1.0)) for one in (here, there)]
    ended = [int(np.argmax(one.tick["limits"] != 0)) for one in (here, there)]
    assert first[0] == pytest.approx(first[1], abs=4)
    # A tick more of dead time, and it ends a bounce earlier.
    assert ended[0] - first[0] == pytest.approx(ended[1] - first[1], abs=BOUNCE_TICKS)
