"""`berth summary` tells from the log what `berth run` told: one computation, fed once live and once from records."""
import json
import subprocess
from pathlib import Path

import pytest
from conftest import ulog_messages

BERTH = Path(__file__).resolve().parents[2] / "build" / "berth"
OF_THE_RUN_ONLY = {"speed_x_realtime", "dropped_records"}
OF_THE_LOG_ONLY = {"checksums", "cut", "damage", "whole_until_s", "missing_ticks", "envelope"}
NOISY = ["sensor.noise_N=2", "sensor.stale_probability=0.01", "bus.loss_probability=0.01",
         "bus.error_probability=0.002", "run.duration_s=30"]
CASES = {
    "ess": ("ess", []),
    "ess-50hz": ("ess-50hz", []),
    "concept-copper": ("concept-copper", []),
    "emergency stop": ("ess", ["run.emergency_stop_s=5", "run.duration_s=10"]),
    "noise and losses": ("ess", NOISY),
    "never released": ("ess", ["run.release_s=5", "run.duration_s=2"]),
    "one tick": ("ess", ["run.duration_s=0.0025"]),
}


def berth(*arguments):
    return subprocess.run([BERTH, *map(str, arguments)], capture_output=True, text=True)


def run(folder, rig, settings):
    """Runs a rig and returns the path of the log and what was said about the run."""
    done = berth("run", rig, "--json", "--out", folder, *(word for s in settings for word in ("--set", s)))
    assert done.returncode == 0, done.stderr
    result = json.loads(done.stdout)
    return Path(result["log"]), result


def summary(log):
    done = berth("summary", log, "--json")
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.mark.parametrize("case", CASES)
def test_summary_agrees_with_run(tmp_path, case):
    log, told = run(tmp_path, *CASES[case])
    again = summary(log)
    assert set(told) - set(again) == OF_THE_RUN_ONLY
    assert set(again) - set(told) == OF_THE_LOG_ONLY
    for key in set(told) & set(again):
        assert again[key] == told[key], key
    assert again["cut"] is False and again["damage"] is None and again["missing_ticks"] == 0


def test_envelope_lies_on_the_fit(tmp_path):
    """Heights of a decay by itself: between the ends of the fit they follow the exponential that was told."""
    log, told = run(tmp_path, "ess", [])
    envelope = summary(log)["envelope"]
    start_s, end_s = envelope["fit_from_s"], envelope["fit_to_s"]
    fitted = [(t, h) for t, h in zip(envelope["time_s"], envelope["height_m"]) if start_s <= t <= end_s]
    assert len(fitted) > 40
    for time_s, height_m in fitted:
        expected_m = envelope["fit_height_from_m"] * 2.718281828459045 ** (told["growth_per_s"] * (time_s - start_s))
        assert height_m == pytest.approx(expected_m, rel=0.01)
    half_period_s = (fitted[-1][0] - fitted[0][0]) / (len(fitted) - 1)
    assert 0.5 / half_period_s == pytest.approx(told["frequency_Hz"], rel=1e-3)


def test_cut_log_is_told_up_to_the_cut(tmp_path):
    log, told = run(tmp_path, "ess", ["run.duration_s=10"])
    content = log.read_bytes()
    last_record = [message for message in ulog_messages(content) if message.type == "D"][-1]
    log.write_bytes(content[:last_record.end - 1])
    again = summary(log)
    assert again["cut"] is True
    assert again["ticks"] == told["ticks"] - 1
    log.write_bytes(content[:len(content) // 2])
    again = summary(log)
    assert told["ticks"] // 3 < again["ticks"] < told["ticks"]
    assert again["simulated_s"] == pytest.approx(again["ticks"] / 400)


@pytest.mark.parametrize("content, word", [(None, "cannot be read"), (b"not a log of any kind", "is not a ULog")])
def test_wrong_file_is_named(tmp_path, content, word):
    log = tmp_path / "some.ulg"
    if content is not None:
        log.write_bytes(content)
    done = berth("summary", log, "--json")
    assert done.returncode == 2
    assert str(log) in done.stderr and word in done.stderr and done.stdout == ""


def test_growth_is_of_motion_without_interruption(tmp_path):
    """Where limits act on and off, samples from before and after do not make one oscillation: what is fitted lies
    within one stretch, at the frequency of the free run."""
    _, free = run(tmp_path / "free", "ess", [])
    log, limited = run(tmp_path / "limited", "ess", ["limits.velocity_m_per_s=0.03"])
    assert limited["limit_ticks"]["velocity"] > 0
    assert limited["frequency_Hz"] == pytest.approx(free["frequency_Hz"], rel=1e-4)
    assert limited["growth_per_s"] == pytest.approx(free["growth_per_s"], rel=1e-3)

    _, broken = run(tmp_path / "broken", "ess", ["manipulator.stiffness_N_per_m=1e9", "run.duration_s=5"])
    assert broken["limit_ticks"]["acceleration"] > 1000
    assert broken["growth_per_s"] is None


@pytest.mark.parametrize("rig,settings,stable", [
    ("ess-beam", ["run.duration_s=2"], False),  # 2 s do not tell: its eigenvalues do
    ("ess", ["run.duration_s=2"], True),
    ("ess", ["run.duration_s=0.5"], True),
    ("ess", ["run.duration_s=2", "robot.backlash_m=1e-3"], True),  # it has no eigenvalues: a longer run without noise does
    ("ess", ["run.duration_s=20"], True),
    ("ess-beam", ["run.duration_s=20"], False),
    ("ess", ["manipulator.initial_position_m=0", "run.duration_s=20"], True),  # nothing moves
])
def test_what_a_run_does_not_tell_is_left_to_the_model(tmp_path, rig, settings, stable):
    assert run(tmp_path, rig, settings)[1]["stable"] is stable
