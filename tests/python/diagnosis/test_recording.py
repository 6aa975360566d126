"""What is wrong with a recording is no fault of the rig: digits, stamps, missing rows, parts, the robot's reports."""

import numpy as np
import pytest
from checks import (at, block, causes, check, doubt, near, no_cause, no_note, not_verdict, note, nothing, size, verdict)
from make_run import (FAULTLESS, FAULTLESS_RUN, NOISE_m, NOISE_N, at_a_rate_that_changes, coarse_command, echoed, faultless,
                      in_parts, jittered_and_gapped, low_passed, machine, missing_rows, moved_with_its_force, rippled,
                      stamped_in_ms, stamped_late, stamped_late_now_and_then, still, two_rows_late, unevenly_stamped, with_an_operator, with_another,
                      with_reports)
from recipes import hidden, logged_late, run_with
from table import Refused, Row, each


@check
def floor_is_known_as_white_noise_is(told):
    """N rows have their rms to 1.96 / sqrt(2 N)."""
    for channel, sigma in (("robot_position_m", NOISE_m), ("force_N", NOISE_N)):
        low, high = told.at(f"residual.{channel}.floor_ci95")
        rows = 0.8 * len(told.series)
        assert low < told.at(f"residual.{channel}.fit.floor") < high
        assert high - low == near(2 * 1.96 * sigma / np.sqrt(2 * rows), rel=0.2)
        assert low - (high - low) < sigma < high + (high - low)


@check
def error_as_with(told, velocity, is_same):
    """The manipulator's error as given, beside that of the record with this velocity."""
    path = "residual.command_position_m.fit.before"
    other = Row("other", faultless(with_an_operator, velocity=velocity)).told(told.out.with_name("other")).at(path)
    if is_same:
        assert told.at(path) == near(other, rel=1e-3)
    else:
        assert abs(told.at(path) - other) > 0.01 * other


STILL = "what is measured does not follow what should move it: a constant does as well"
DEAD = [("robot", "robot_position_m", 5e-6), ("force", "force_N", 0.3)]
OFF = {"with a ripple": rippled, "low-passed": low_passed}

ROWS = [
    Row("nothing wrong", FAULTLESS, nothing(), no_note("written in steps"), floor_is_known_as_white_noise_is()),
    # In a contact of 2e7 N/m a micrometre is 20 N.
    *[Row(f"a command in steps of {step_m} m", faultless(coarse_command, step_m=step_m), no_cause(),
          verdict("nothing_detectable", "unknown"), note("command_position_m is written in steps of"), slow=step_m > 1e-7)
      for step_m in (1e-7, 1e-6, 1e-5)],
    # A replay begins at rest: the object is hit at the robot's velocity, and swings on the sensor's spring.
    Row("parts that begin in motion", faultless(in_parts, rows=400), nothing()),
    # Rows are put back by their place and not by their stamps: a cubic through those was off by 2.5 um.
    *[Row(f"rows missing, stamps that jitter by {jitter_ms} ms", faultless(jittered_and_gapped, jitter_ms=jitter_ms),
          nothing()) for jitter_ms in (0.1, 0.2, 0.4)],
    Row("stamps 0.4 of a row early or late", faultless(stamped_late), nothing(), no_note("rows are missing")),
    # A logger that is not woken in time: the next stamp is on time again, and no row is missing.
    *[Row(f"one stamp in {one_in} late by up to {late_ms} ms", faultless(stamped_late_now_and_then, one_in=one_in,
                                                                         late_ms=late_ms),
          nothing(), note("late, by up to"), no_note("rows are missing"), no_note("gap in"))
      for one_in, late_ms in ((100, 2.4), (20, 2.0), (300, 9.0))],
    # A motion is smooth over the times at which it was measured.
    Row("rows of a machine taken at uneven times", machine(taken_at_stamps=True), nothing(),
        note("taken at their stamps")),
    Row("rows of a machine taken evenly and stamped unevenly", machine(taken_at_stamps=False), nothing(),
        note("rows count as evenly spaced")),
    Row("single rows missing", faultless(missing_rows, seed=20261122, count=25), verdict("nothing_detectable"),
        note("rows are missing in")),
    # --- brakes that are on, a sensor that is dead or stuck
    *[Row(f"{channel} that stays at {constant}", faultless(still, channel=channel, noise=noise, constant=constant),
          verdict("unknown"), no_cause(), doubt(name, STILL), slow=(name, constant) != ("robot", 0.0))
      for constant in (0.0, 12.0) for name, channel, noise in DEAD],
    # --- reports that are off, where the force shows that the motion is not
    *[Row(f"reports {what}", faultless(with_reports, law=law), verdict("unknown"), at("block", "robot"), no_cause(),
          doubt("robot", "the reports are off, not the motion"), block("force", "nothing_detectable"),
          slow=True) for what, law in OFF.items()],
    # --- a column that the logger wrote late: two blocks say so, and a delay of the rig explains one of them only
    Row("reports late by two rows", faultless(with_reports, law=two_rows_late), verdict("named"),
        causes("log.robot_position_late"), size("robot_position_late_rows", near(2, abs=0.2))),
    *[Row(f"{column} of hidden record {seed} logged {rows} rows late",
          logged_late(record=hidden(seed=seed, effect="none"), column=column, rows=rows), causes(f"log.{name}_late"),
          size(f"{name}_late_rows", near(rows, abs=0.2)), slow=(seed, rows) != (7001, 2))
      for seed, rows in ((7001, 2), (7002, 3), (7003, 5))
      for column, name in (("force_N", "force"), ("robot_position_m", "robot_position"), ("command_position_m", "command"))],
    *[Row(f"{effect} is no late column", hidden(seed=7004, effect=effect, size="large"),
          no_cause("log.force_late", "log.robot_position_late", "log.command_late"), slow=True)
      for effect in ("sensor.delay", "sensor.lag", "robot.dead_time", "robot.lag")],
    Row("a motion that is off, of which reports and force tell", run_with(FAULTLESS_RUN | {"robot.dead_time_ms": 21}),
        verdict("named", "one_of"), causes("robot.dead_time"), slow=True),
    Row("an offset of the motion is no bias", faultless(moved_with_its_force), not_verdict("named"),
        block("force", "partly_explained", "unknown")),
    # --- an operator's velocity that is missing
    Row("an operator's velocity is differentiated where it is missing", faultless(with_an_operator, velocity="without"),
        note("taken as differences of operator_position_m"), error_as_with("with", True), slow=True),
    Row("an operator who hardly moves is another one", faultless(with_an_operator, velocity="zero"),
        error_as_with("with", False), slow=True),
    # --- refused
    Refused("stamps without a rate", faultless(unevenly_stamped), "{record}", "no constant rate"),
    Refused("stamps in milliseconds", faultless(stamped_in_ms), "{record}", "scale = 0.001"),
    Refused("a rate that changes", faultless(at_a_rate_that_changes), "{record}", "no constant rate",
            "in places"),
    Refused("a repetition of another command", faultless(with_another, role="repeat"), "{folder}/repeat.csv",
            "repeats no command"),
    Refused("a standstill that moves", faultless(with_another, role="standstill"), "{folder}/standstill.csv",
            "is no standstill"),
    Refused("a validation without a command", faultless(with_another, role="validate", has_command=False),
            "{folder}/validate.csv", "no block in common"),
    *[Refused(f"setpoints as reports, to {decimals} decimals", faultless(echoed, decimals=decimals),
              "{record}:1: robot_position_m repeats command_position_m", "leave it out") for decimals in (12, 9)],
]


@pytest.mark.long
@each(ROWS)
def test_recording(row, tmp_path):
    row.check(tmp_path / "out")
