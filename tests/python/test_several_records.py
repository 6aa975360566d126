"""`berth diagnose` with more than one record, of other lengths, and with records that have gaps."""

import json

import numpy as np
import pytest
from conftest import EXIT_DONE, EXIT_INPUT, command, play

PERIOD_s, DELAY_TICKS, NOISE_m, BACKLASH_m = 0.0025, 7, 2e-6, 2e-4
MOVE_rows = 200
HEADER = "t_s,command_position_m,robot_position_m"


def robot(rows, seed, gap=BACKLASH_m, start_s=0.0):
    """t_s, command and position of a robot with play, 7 ticks late: the dead time of `ess`."""
    rng = np.random.default_rng(seed)
    t_s = PERIOD_s * np.arange(rows)
    tones_Hz = rng.uniform(0.1, 2.0, 5)
    command_m = sum(3e-3 * np.sin(2 * np.pi * tone_Hz * t_s + i) for i, tone_Hz in enumerate(tones_Hz))
    late_m = np.concatenate((np.full(DELAY_TICKS, command_m[0]), command_m[:-DELAY_TICKS]))
    return start_s + t_s, command_m, play(late_m, gap) + NOISE_m * rng.standard_normal(rows)


def write(path, columns, header=HEADER):
    np.savetxt(path, np.column_stack(columns), delimiter=",", comments="", fmt="%.12g", header=header)
    return path


def diagnose(out, *arguments):
    done = command("diagnose", *arguments, "--rig", "ess", "--out", out)
    assert done.returncode == EXIT_DONE, done.stderr.decode()
    series = np.genfromtxt(out / "series.csv", delimiter=",", names=True)
    return json.loads((out / "diagnosis.json").read_text()), series


def backlash(found):
    """(value, low, high) in m of the one cause."""
    assert found["verdict"] == "named", found["verdict"]
    assert [cause["effect"] for cause in found["causes"]] == ["robot.backlash"]
    parameter = found["causes"][0]["parameters"][0]
    return parameter["value"], *parameter["ci95"]


def test_two_records_of_other_lengths_are_one_diagnosis(tmp_path):
    paths = [write(tmp_path / "long.csv", robot(8000, 1)), write(tmp_path / "short.csv", robot(3000, 2, start_s=50.0))]
    found, series = diagnose(tmp_path / "both", *paths)
    assert len(series) == 11000 and np.all(np.diff(series["t_s"]) > 0.0)
    assert [one["path"] for one in found["inputs"] if one["role"] == "record"] == [str(path) for path in paths]
    value_m, low_m, high_m = backlash(found)
    assert value_m == pytest.approx(BACKLASH_m, rel=0.01)
    # Each knows the play by itself; both together know it better than the shorter one.
    for path in paths:
        alone, _ = diagnose(tmp_path / path.stem, path)
        alone_m, alone_low_m, alone_high_m = backlash(alone)
        assert alone_m == pytest.approx(BACKLASH_m, rel=0.02)
    assert high_m - low_m < alone_high_m - alone_low_m


def test_the_seam_between_two_records_is_no_motion(tmp_path):
    """The second one starts elsewhere: joined without a seam, the robot would seem to jump there."""
    first = robot(4000, 3, gap=0.0)
    second = robot(3000, 4, gap=0.0)
    moved = (second[0], second[1] + 0.05, second[2] + 0.05)
    found, series = diagnose(tmp_path / "out", write(tmp_path / "a.csv", first), write(tmp_path / "b.csv", moved))
    assert found["verdict"] == "nothing_detectable" and found["causes"] == []
    assert np.abs(series["robot_error_after_m"]).max() < 6.0 * NOISE_m
    assert found["residual"]["robot_position_m"]["fit"]["after"] == pytest.approx(NOISE_m, rel=0.05)


def test_both_records_count(tmp_path):
    """A fault that only the second one has is no fault of a rig that made the first: it is not passed over."""
    paths = [write(tmp_path / "good.csv", robot(4000, 5, gap=0.0)), write(tmp_path / "worn.csv", robot(4000, 6))]
    found, _ = diagnose(tmp_path / "out", *paths)
    assert found["verdict"] != "nothing_detectable"


def test_records_with_other_signals_do_not_go_together(tmp_path):
    t_s, command_m, robot_m = robot(3000, 7)
    whole = write(tmp_path / "whole.csv", (t_s, command_m, robot_m))
    part = write(tmp_path / "part.csv", (t_s, command_m), "t_s,command_position_m")
    done = command("diagnose", whole, part, "--rig", "ess", "--out", tmp_path / "out")
    assert done.returncode == EXIT_INPUT and "part.csv" in done.stderr.decode()
    assert "same signals" in done.stderr.decode() and not (tmp_path / "out").exists()


@pytest.mark.parametrize("seed", [11, 12, 13])
def test_parts_that_begin_in_motion_are_no_fault(tmp_path, seed):
    """Half a second each: some begin near a turning point, where setpoint and robot hardly move."""
    columns = *robot(16000, seed, gap=0.0), np.arange(16000) // 200
    found, series = diagnose(tmp_path / "out", write(tmp_path / "parts.csv", columns, HEADER + ",segment"))
    assert found["verdict"] == "nothing_detectable", found["blocks"][0]["doubts"]
    assert found["residual"]["robot_position_m"]["fit"]["after"] == pytest.approx(NOISE_m, rel=0.05)
    assert np.count_nonzero(series["robot_use"]) > 8000  # what is used is more than half


def moves_and_stands(seed, gap):
    """Setpoints of 20 moves, half a second each, with stands as long between them, and the robot behind them."""
    rng = np.random.default_rng(seed)
    move, stand = np.sin(0.5 * np.pi * np.linspace(0.0, 1.0, MOVE_rows)) ** 2, np.ones(MOVE_rows)
    goals_m = np.cumsum(rng.choice([-1.0, 1.0], 21) * rng.uniform(2e-3, 8e-3, 21))
    command_m = np.concatenate([before + (after - before) * np.r_[move, stand]
                                for before, after in zip(goals_m[:-1], goals_m[1:])])
    late_m = np.concatenate((np.full(DELAY_TICKS, command_m[0]), command_m[:-DELAY_TICKS]))
    return command_m, play(late_m, gap), rng


@pytest.mark.parametrize("seed", [21, 22, 23])
def test_parts_that_begin_at_the_edge_of_the_play(tmp_path, seed):
    """The robot stands where it was brought to. Where a part begins is seen by all rows until it moves, not by one."""
    command_m, robot_m, rng = moves_and_stands(seed, BACKLASH_m)
    robot_m += 5e-6 * rng.standard_normal(len(command_m))
    # Parts of three moves, from the middle of a stand on.
    kept = np.arange(3 * MOVE_rows // 2, len(command_m) - MOVE_rows // 2)
    columns = PERIOD_s * kept, command_m[kept], robot_m[kept], np.arange(len(kept)) // (6 * MOVE_rows)
    found, series = diagnose(tmp_path / "out", write(tmp_path / "parts.csv", columns, HEADER + ",segment"))
    value_m, low_m, high_m = backlash(found)
    assert value_m == pytest.approx(BACKLASH_m, rel=0.002) and high_m - low_m < 0.005 * BACKLASH_m
    used_m = series["robot_error_after_m"][series["robot_use"] > 0]
    assert np.sqrt(np.mean(used_m ** 2)) == pytest.approx(5e-6, rel=0.03)


@pytest.mark.parametrize("seed", [31, 36, 52])
@pytest.mark.parametrize("gap_m", [0.0, 4e-5])
def test_coarse_reports_of_a_robot_that_stands(tmp_path, seed, gap_m):
    """Their rounding is the same for as long as it stands, one fact and not 200: that had been a fault of the robot."""
    command_m, robot_m, rng = moves_and_stands(seed, gap_m)
    step_m = 1e-5
    read_m = step_m * np.round((robot_m + 0.1 * step_m * rng.standard_normal(len(robot_m))) / step_m)
    columns = PERIOD_s * np.arange(len(command_m)), command_m, read_m
    found, _ = diagnose(tmp_path / "out", write(tmp_path / "coarse.csv", columns))
    if gap_m == 0.0:
        assert found["verdict"] == "nothing_detectable" and found["causes"] == [], found["blocks"][0]
    else:
        value_m, _, _ = backlash(found)
        # What it is off by was 0.06 of a step, rms, over 25 seeds.
        assert value_m == pytest.approx(gap_m, abs=0.2 * step_m)


def test_gaps_do_not_hide_a_cause(tmp_path):
    """Two holes, one of them a second long: each part is replayed by itself."""
    columns = robot(10000, 8)
    kept = np.r_[0:3000, 3400:7000, 7020:10000]
    found, series = diagnose(tmp_path / "out", write(tmp_path / "gaps.csv", [values[kept] for values in columns]))
    assert any("2 gaps" in note for note in found["notes"])
    assert len(series) == len(kept)
    value_m, _, _ = backlash(found)
    assert value_m == pytest.approx(BACKLASH_m, rel=0.01)
    # Right after a gap the past of the robot is not known: those rows are not used.
    for begin in (3000, 6600):
        assert series["robot_use"][begin] == 0 and series["robot_use"][begin - 1] > 0


def test_a_record_with_gaps_and_a_whole_one(tmp_path):
    gapped = robot(6000, 9)
    kept = np.r_[0:2000, 2500:6000]
    paths = [write(tmp_path / "gaps.csv", [values[kept] for values in gapped]),
             write(tmp_path / "whole.csv", robot(4000, 10))]
    found, series = diagnose(tmp_path / "out", *paths)
    value_m, low_m, high_m = backlash(found)
    assert len(series) == len(kept) + 4000
    assert value_m == pytest.approx(BACKLASH_m, rel=0.01)
