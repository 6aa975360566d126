"""The guide's operator station: what it sends in each state of the loop, read with berth.dbc."""

import can
import cantools
import numpy as np
import pytest
from conftest import ROOT
from page_program import page_program

DBC = ROOT / "firmware" / "can" / "berth.dbc"
MOTION = cantools.database.load_file(DBC).get_message_by_name("operator_motion")
AMPLITUDE_m = 0.003


@pytest.fixture(scope="module")
def program():
    return page_program("build-an-operator-station.md", "operator_station")


@pytest.fixture
def station(program):
    return program.Station(AMPLITUDE_m, DBC)


def tell(station, state):
    data = station.status.encode({"state": state, "stop_cause": 0, "limits": 0, "missed_ticks": 0, "torn_samples": 0, "counter": 0})
    station.take(can.Message(arbitration_id=station.status.frame_id, data=data, is_extended_id=False))


def sent(station, now_s):
    frame = station.cycle(now_s)
    assert frame.arbitration_id == MOTION.frame_id
    return {name: str(value) if name == "request" else float(value) for name, value in MOTION.decode(frame.data).items()}


def test_it_requests_nothing_until_the_loop_is_ready_and_rests_until_it_runs(station):
    tell(station, "start")
    assert sent(station, 0.0) == {"position_m": 0, "velocity_m_per_s": 0, "request": "none", "counter": 1}
    tell(station, "ready")
    assert sent(station, 5.0) == {"position_m": 0, "velocity_m_per_s": 0, "request": "run", "counter": 2}
    tell(station, "running")
    frames = [sent(station, 5.0 + 0.005 * i) for i in range(400)]
    assert frames[0]["position_m"] == 0 and frames[-1]["position_m"] != 0
    assert [frame["counter"] for frame in frames] == [(3 + i) % 16 for i in range(400)]


def test_the_motion_is_faded_in_and_its_velocity_is_its_derivative(program):
    time_s = np.linspace(0.0, 12.0, 12_001)
    position_m, velocity_m_per_s = np.array([program.multisine(t, AMPLITUDE_m) for t in time_s]).T
    assert position_m[0] == velocity_m_per_s[0] == 0.0
    assert 0.3 * AMPLITUDE_m < np.abs(position_m).max() <= AMPLITUDE_m
    differences = np.gradient(position_m, time_s)
    np.testing.assert_allclose(velocity_m_per_s[1:-1], differences[1:-1], atol=5e-4 * np.abs(velocity_m_per_s).max())


def test_its_lines_lie_at_a_tenth_to_five_hertz(program):
    """Of a period behind the fade."""
    time_s = program.FADE_s + np.arange(4000) / 400.0
    position_m = np.array([program.multisine(t, AMPLITUDE_m)[0] for t in time_s])
    lines_m = 2.0 / len(position_m) * np.abs(np.fft.rfft(position_m))
    expected_m = np.zeros(len(lines_m))
    expected_m[list(program.MULTIPLES)] = AMPLITUDE_m / len(program.MULTIPLES)
    np.testing.assert_allclose(lines_m, expected_m, atol=1e-12)
