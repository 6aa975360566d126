"""The robot alone: what is named, with which size, and what the library lacks, of which no name is given as the whole
truth."""

import subprocess
import sys
from functools import partial

import numpy as np
import pytest
from checks import (at, causes, check, doubt, named, near, no_cause, no_doubt, no_note, note, nothing, offers, size, verdict,
                    width)
from conftest import EXIT_DONE, ROOT
from make_robot import (ROBOT_RIG, coarse_reports, creeping, dead_time_that_grows, farther_upwards,
                        gain_that_grows_with_the_way, jittering, lag_that_grows, late_in_stretches,
                        motor_with_little_voltage, parts_of_moves, played, random_steps, rippled, robot, scaled,
                        servo_with_limits, sines_to_4_Hz, slow_sines, slower_up_than_down, stepped_servo, triangle,
                        with_other_signals)
from table import Refused, Row, each


@check
def open_floor(told, channel):
    """Estimated beside what nothing explains, the noise may hold some of that."""
    low, high = told.at(f"residual.{channel}.floor_ci95")
    assert low == 0.0 < high


@check
def size_in_note(told, text, expected):
    """The one note of noise that grows says its size after this text."""
    [one] = [one for one in told.found["notes"] if "the noise of the robot grows" in one]
    assert float(one.split(text)[1].split()[0]) == expected


@check
def report_is_drawn(told):
    done = subprocess.run([sys.executable, ROOT / "scripts/diagnosis_report.py", told.out], check=False, capture_output=True)
    assert done.returncode == EXIT_DONE, done.stderr.decode()


@check
def two_offered_are_named(told):
    assert told.verdict == ("named" if len(told.offered) == 2 else "one_of")


@check
def within_its_interval(told, name, true, narrower_than):
    low, high = told.parameter(name)["ci95"]
    assert abs(told.parameter(name)["value"] - true) < high - low < narrower_than


@check
def records(told, *names):
    assert [one["path"].rsplit("/", 1)[1] for one in told.found["inputs"] if one["role"] == "record"] == list(names)


@check
def unused_rows(told, *rows):
    """Right after a gap the past of the robot is not known."""
    for row in rows:
        assert told.series["robot_use"][row] == 0 < told.series["robot_use"][row - 1]


@check
def rows(told, count):
    assert len(told.series) == count and np.all(np.diff(told.series["t_s"]) > 0.0)


@check
def used_rows(told, more_than):
    assert np.count_nonzero(told.series["robot_use"]) > more_than


@check
def largest_error(told, below):
    assert np.abs(told.series["robot_error_after_m"]).max() < below


@check
def rms_of_used(told, expected):
    used_m = told.series["robot_error_after_m"][told.series["robot_use"] > 0]
    assert np.sqrt(np.mean(used_m ** 2)) == expected


@check
def knows_more_than(told, name, *records):
    """Each record knows it by itself; all together know it better than the last one."""
    for n, record in enumerate(records):
        alone = Row("alone", record).told(told.out.with_name(f"alone{n}"))
        named("robot.backlash")(alone)
        size(name, near(PLAY_m, rel=0.02))(alone)
    low, high = told.parameter(name)["ci95"]
    alone_low, alone_high = alone.parameter(name)["ci95"]
    assert high - low < alone_high - alone_low


FIT = "residual.robot_position_m.fit.after"
PART = ("partly_explained", "unknown")
PLAY_m = 2e-4
LACKS = {"is slower upwards than downwards": slower_up_than_down, "goes farther upwards": farther_upwards,
         "has a motor with little voltage": motor_with_little_voltage}
LATE = {"dead time of 20 ms": (0.004, 20.0, False), "another pitch": (0.0042, 20.0, True),
        "dead time of 19.5 ms": (0.004, 19.5, True)}

ROWS = [
    # --- what the library lacks: what is left is smooth, as the motion is, and is not taken for noise
    *[Row(f"a robot that {what}, {'validated' if unseen else 'by itself'}",
          robot(law=law, unseen_seed=unseen), verdict(*PART), open_floor("robot_position_m"),
          slow=not (unseen and law is not motor_with_little_voltage))
      for unseen in (78, None) for what, law in LACKS.items()],
    Row("a gain that grows with the way is not three causes",
        robot(law=gain_that_grows_with_the_way, seed=11, noise_seed=12), verdict(*PART)),
    *[Row(f"late in stretches is no clock that drifts, seed {seed}",
          robot(law=partial(late_in_stretches, seed=seed), seed=seed, noise_seed=seed, noise_m=2e-5), verdict(*PART),
          slow=seed > 1) for seed in (1, 2, 3, 4)],
    Row("a slow servo under steps loses no setpoints",
        robot(law=servo_with_limits, goes=random_steps, noise_seed=1, noise_skips=30, noise_m=2e-6,
              rig='[loop]\nrate_Hz = 400\n[robot]\ndead_time_ms = 17.5\ninterpolation = "hold"\n'),
        no_cause("robot.lost_commands"), verdict(*PART), slow=True),
    Row("what creeps is a drift", robot(law=creeping, noise_seed=2), verdict("unknown"),
        at("blocks.robot.left.depends", "drift over time")),
    Row("a lag that grows is a dead time that grows in part", robot(law=lag_that_grows), verdict("partly_explained"),
        causes("robot.dead_time_drift"), doubt("robot", "low-pass")),
    # A clock of another period that does not slip is the same.
    Row("a dead time that grows", robot(law=dead_time_that_grows), verdict("named", "one_of"),
        causes("robot.dead_time_drift"), no_doubt("robot", "low-pass")),
    # --- noise that follows the motion
    Row("a delay that jitters", robot(law=partial(jittering, jitter_ms=0.3), seed=7, noise_seed=8, rig=ROBOT_RIG),
        no_cause(), verdict("unknown"), size_in_note("velocity, as of a delay that jitters by ", near(0.3, rel=0.1)),
        at("next_experiment.rivals", []), report_is_drawn()),
    Row("a gain that wanders", robot(law=partial(jittering, wander=0.004), seed=7, noise_seed=8, rig=ROBOT_RIG),
        no_cause(), verdict("unknown"), size_in_note("size, as of a gain that wanders by ", near(0.4, rel=0.1)),
        at("next_experiment.rivals", []), report_is_drawn(), slow=True),
    Row("noise that does not follow the motion", robot(law=jittering, seed=7, noise_seed=8, rig=ROBOT_RIG), no_cause(),
        no_note("the noise of the robot grows"), slow=True),
    # --- one cause stands in for another until all are there
    Row("a triangle hides no cause", robot(law=rippled, goes=triangle, noise_seed=1, noise_m=1e-6),
        named("robot.periodic_error"), no_note("written in steps")),
    *[Row(f"a rival of the first cause, {what}",
          robot(law=partial(rippled, by_s=1e-3 * late_ms, size_m=5e-5, pitch_m=pitch_m), goes=slow_sines, noise_seed=3,
                digits=None), offers("robot.dead_time", "robot.periodic_error"), two_offered_are_named(), slow=slow)
      for what, (pitch_m, late_ms, slow) in LATE.items()],
    *[Row(f"a lag of {lag_ms} ms behind a dead time of {dead_time_ms} ms, under steps",
          stepped_servo(dead_time_ms=dead_time_ms, lag_ms=lag_ms), named("robot.dead_time", "robot.lag"),
          within_its_interval("dead_time_ms", dead_time_ms, narrower_than=0.2 * dead_time_ms),
          within_its_interval("lag_ms", lag_ms, narrower_than=0.2 * lag_ms))
      for dead_time_ms, lag_ms in ((30, 120), (40, 80), (20, 60), (50, 200), (100, 500))],
    *[Row(f"a dead time {late_ms} ms longer beside a gain of {gain} is no resonance",
          robot(law=partial(scaled, gain=gain, by_s=0.0175 + 1e-3 * late_ms), goes=sines_to_4_Hz, noise_seed=8,
                digits=None),
          named("robot.dead_time", "robot.gain"), size("dead_time_ms", near(17.5 + late_ms, abs=0.01)),
          slow=(late_ms, gain) != (3.5, 0.02))
      for late_ms, gain in ((3.5, 0.02), (4.5, 0.01), (2.5, 0.01))],
    # --- play, in several records and in parts
    Row("play in two records of other lengths", played(rows=8000, seed=1, gap_m=PLAY_m, more=(3000, 2, PLAY_m, 50.0)),
        rows(11000), records("record.csv", "second.csv"), named("robot.backlash"), size("backlash_m", near(PLAY_m, rel=0.01)),
        knows_more_than("backlash_m", played(rows=8000, seed=1, gap_m=PLAY_m),
                        played(rows=3000, seed=2, gap_m=PLAY_m, start_s=50.0))),
    # The second one starts elsewhere: joined without a seam, the robot would seem to jump there.
    Row("the seam between two records is no motion", played(rows=4000, seed=3, gap_m=0.0, more=(3000, 4, 0.0, 0.0, 0.05)),
        nothing(), largest_error(below=6.0 * 2e-6), at(FIT, near(2e-6, rel=0.05))),
    Row("a fault in the second record counts", played(rows=4000, seed=5, gap_m=0.0, more=(4000, 6, PLAY_m)),
        verdict("named", "one_of", "partly_explained", "unknown")),
    *[Row(f"parts that begin in motion, seed {seed}", played(rows=16000, seed=seed, gap_m=0.0, part_rows=200),
          verdict("nothing_detectable"), at(FIT, near(2e-6, rel=0.05)), used_rows(more_than=8000))
      for seed in (11, 12, 13)],
    # Where a part begins is seen by all rows until the robot moves, not by one.
    *[Row(f"parts that begin at the edge of the play, seed {seed}", parts_of_moves(seed=seed, gap_m=PLAY_m),
          named("robot.backlash"), size("backlash_m", near(PLAY_m, rel=0.002)),
          width("backlash_m", less_than=0.005 * PLAY_m), rms_of_used(near(5e-6, rel=0.03)))
      for seed in (21, 22, 23)],
    # The rounding is one fact for as long as the robot stands. Over 25 seeds the play was off by 0.06 of a step, rms.
    *[Row(f"coarse reports of a robot that stands, play of {gap_m} m, seed {seed}",
          coarse_reports(seed=seed, gap_m=gap_m),
          *([named("robot.backlash"), size("backlash_m", near(gap_m, abs=2e-6))] if gap_m else [nothing()]))
      for gap_m in (0.0, 4e-5) for seed in (31, 36, 52)],
    Row("gaps hide no cause", played(rows=10000, seed=8, gap_m=PLAY_m, gone=((3000, 3400), (7000, 7020))),
        note("2 gaps"), rows(9580), named("robot.backlash"), size("backlash_m", near(PLAY_m, rel=0.01)),
        unused_rows(3000, 6600)),
    Row("a record with gaps and a whole one",
        played(rows=6000, seed=9, gap_m=PLAY_m, gone=((2000, 2500),), more=(4000, 10, PLAY_m)), rows(9500),
        named("robot.backlash"), size("backlash_m", near(PLAY_m, rel=0.01))),
    Refused("records with other signals do not go together", with_other_signals(), "second.csv", "same signals"),
]


@pytest.mark.long
@each(ROWS)
def test_robot(row, tmp_path):
    row.check(tmp_path / "out")
