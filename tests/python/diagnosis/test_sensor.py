"""The force sensor and the digits of a command, in a chain of robot, sensor and object, and in runs of `ess`: coarse
steps, rows that a logger lost, biases that drift, spikes, sensors that are late behind robots that are late."""

from functools import partial

import numpy as np
import pytest
from checks import (at, block, causes, check, doubt, interval, named, near, no_doubt, no_note, not_verdict, note,
                    offers, size, verdict)
from make_chain import (DEAD_TIME_ms, FORCE_NOISE_N, chained, chirp_that_trembles, in_steps, in_steps_with_spikes, trembling,
                        wandering, wandering_in_steps, with_bias, with_single_rows_between_gaps, without_bursts,
                        without_bursts_and_a_tenth_of_a_second, without_twelve_bursts)
from make_run import MOVING, NOISE_N, NOISE_m, NOISY, biased, crept, faultless, slightly_biased
from recipes import run_with
from table import Row, each

FORCE, ROBOT = "residual.force_N.fit.after", "residual.robot_position_m.fit"


# --- columns in coarse steps --------------------------------------------------------------------------------------
STEPPED = [(0.0, 0.0), (0.05, 0.0), (0.15, 0.0), (0.0, 0.005), (0.0, 0.03)]
COARSE = [
    # The robot was sent something finer: that is as if setpoints were lost, or smoothed by a lag.
    *[Row(f"of a command in steps of {step_m} m nothing is made, seed {seed}",
          chained(seed=seed, goes=wandering, command_step_m=step_m), verdict("nothing_detectable"),
          note("command_position_m is written in steps of"),
          at(f"{ROBOT}.floor", near(np.hypot(5e-6, step_m / np.sqrt(12.0)), rel=0.15)), slow=seed == 2)
      for seed in (1, 2) for step_m in (1e-5, 2e-5, 1e-4)],
    Row("a cause beside a coarse command", chained(seed=3, goes=wandering, dead_time_ms=16.0, command_step_m=2e-5),
        verdict("named", "one_of"), causes("robot.dead_time"), size("dead_time_ms", near(16.0, abs=0.2))),
    # A resonance takes the rounding out of the error that a dead time leaves, and was named in its place.
    *[Row(f"steps of {step_m} m and a dead time {late_ms} ms longer",
          chained(seed=7, goes=wandering, dead_time_ms=DEAD_TIME_ms + late_ms, command_step_m=step_m),
          offers("robot.dead_time"), verdict("named", "one_of"), slow=(step_m, late_ms) != (2e-6, 3.0))
      for step_m, late_ms in ((2e-6, 3.0), (3e-6, 3.0), (2e-6, 6.0))],
    # A controller may count in them: then they are what the robot was sent, and nothing is open.
    *[Row(f"steps of {step_m} m that were sent hide nothing",
          chained(seed=6, goes=partial(wandering_in_steps, step_m=step_m), command_step_m=step_m, read=with_bias),
          named("sensor.bias"), size("bias_N", near(2.0, abs=0.05)), no_note("is written in steps of"))
      for step_m in (2e-5, 1e-4)],
    *[Row(f"steps of a sensor with noise of {noise_N} N upon them and {astray} of its values beside them",
          chained(seed=4, read=partial(in_steps, step_N=2.0, noise_N=noise_N, astray=astray)), named("sensor.quantisation"),
          at("causes.0.parameters.0.value", near(2.0, rel=0.005))) for noise_N, astray in STEPPED],
    Row("spikes beside steps with noise", chained(seed=5, read=in_steps_with_spikes),
        causes("sensor.quantisation", "sensor.spikes"), size("spike_N", near(30.0, rel=0.02))),
]


# --- rows that a logger lost: commands that are put in there push a stiff sensor -----------------------------------
BURSTS = [
    *[Row(f"bursts of rows missing in a smooth command, seed {seed}", chained(seed=seed, keeps=without_bursts),
          verdict("nothing_detectable"), note("missing"), at(FORCE, near(FORCE_NOISE_N, rel=0.05)), slow=seed > 1)
      for seed in (1, 2, 3)],
    Row("a cause beside bursts of rows missing", chained(seed=4, dead_time_ms=16.0, keeps=without_bursts),
        named("robot.dead_time"), interval("dead_time_ms", 16.0), note("missing")),
    *[Row(f"bursts of rows missing in a command that trembles, seed {seed}",
          chained(seed=seed, goes=trembling, keeps=without_bursts), not_verdict("named", "one_of"), note("missing"),
          slow=seed > 5) for seed in (5, 6)],
    # A gap parts the record: where the second part begins, every row that was put in before it counts, and no other.
    *[Row(f"bursts on both sides of a longer gap, {' '.join(found) or 'nothing wrong'}",
          chained(seed=7, dead_time_ms=late_ms, keeps=without_bursts_and_a_tenth_of_a_second), note("gap"),
          note("missing"), causes(*found), verdict("named" if found else "nothing_detectable"),
          at(FORCE, near(FORCE_NOISE_N, rel=0.05))) for late_ms, found in ((DEAD_TIME_ms, []), (16.0, ["robot.dead_time"]))],
    # The sensor rings from what was put in, and is left to ring out.
    *[Row(f"few bursts in a command that trembles a little, {' '.join(found) or 'nothing wrong'}",
          chained(seed=8, goes=chirp_that_trembles, dead_time_ms=late_ms, keeps=without_twelve_bursts), causes(*found),
          verdict("named" if found else "nothing_detectable"), at(FORCE, near(FORCE_NOISE_N, rel=0.05)))
      for late_ms, found in ((DEAD_TIME_ms, []), (12.0, ["robot.dead_time"]))],
    # The robot may seem to stand in it: nothing in a part so short shows that it does.
    Row("a single row between gaps tells nothing", chained(seed=9, keeps=with_single_rows_between_gaps),
        verdict("nothing_detectable"), at(f"{ROBOT}.after", near(5e-6, rel=0.05))),
    # Reports and force weigh the two; with a dead time of 13 ms the resonance is 10 better in the sum of squares.
    *[Row(f"what two parameters more earn by chance names no resonance, dead time of {late_ms} ms",
          chained(seed=4, dead_time_ms=late_ms), verdict("named", "one_of"), causes("robot.dead_time"), slow=late_ms > 12.5)
      for late_ms in (12.5, 13.0, 13.5)],
]


# --- biases and spikes --------------------------------------------------------------------------------------------
LOST_RUN = MOVING | NOISY | {"run.duration_s": 20, "profile.frequency_end_Hz": 2}
DELAY_TICKS = 7


def rms(x):
    return np.sqrt(np.mean(np.square(x)))


@check
def losses_are_the_robots_error(told):
    """As given the robot is 7 ticks late and no more: what it then lacks is what it lost."""
    lacks_m = told.series["robot_position_m"][DELAY_TICKS:] - told.series["command_position_m"][:-DELAY_TICKS]
    fit = told.block("robot")["residual"]["fit"]
    assert rms(lacks_m) > 2.0 * NOISE_m and fit["before"] == near(rms(lacks_m), rel=0.15)
    assert fit["retuned"] > 0.9 * fit["before"] and fit["after"] == near(NOISE_m, rel=0.05)
    assert rms(told.series["robot_error_before_m"]) == near(rms(lacks_m), rel=0.02)


@check
def spikes_are_in_the_error_as_given(told, size_N, share):
    """A spike has either sign: by the size that it was given, counted in the record itself."""
    fit = told.at("residual.force_N.fit")
    count = np.mean(np.abs(told.series["force_error_before_N"]) > 0.5 * size_N)
    assert count == near(share, rel=0.3)
    assert fit["after"] == near(NOISE_N, rel=0.05)
    assert fit["before"] == near(np.hypot(NOISE_N, size_N * np.sqrt(share)), rel=0.25)


@check
def is_at_its_floor_or_unknown(told):
    left = told.at("residual.force_N.fit")
    assert left["after"] < 1.4 * left["floor"] or told.block("force")["verdict"] == "unknown"
    assert told.block("force")["verdict"] != "nothing_detectable"


JUMPED = "what is named acts otherwise from one moment on"
BIASES = [
    # A straight line has three quarters of the square of a step in its middle; what is left of that is small.
    Row("a bias that jumps is no drift", faultless(biased, at_end_N=0.25, jumps=True),
        block("force", "partly_explained", cause=["sensor.drift"]), doubt("force", JUMPED)),
    Row("a bias that drifts", faultless(biased, at_end_N=0.5, jumps=False), block("force", "named", cause=["sensor.drift"]),
        no_doubt("force", JUMPED)),
    # What gains less than the noise is known is believed beside a standstill alone.
    Row("a bias of a tenth of the noise beside a standstill", faultless(slightly_biased, standstill=True),
        block("force", "named", cause=["sensor.bias"]), no_doubt("force", "a standstill would tell")),
    Row("a bias of a tenth of the noise", faultless(slightly_biased, standstill=False),
        block("force", "partly_explained", cause=["sensor.bias"]), doubt("force", "a standstill would tell")),
    # Its error is above its own floor, and no standstill tells the noise.
    Row("a sensor that creeps", faultless(crept), is_at_its_floor_or_unknown()),
    *[Row(f"what the robot loses is told in the robot, seed {seed}",
          run_with(LOST_RUN | {"robot.lost_command_probability": 0.03, "run.seed": seed}), verdict("named"),
          at("block", "robot"), block("robot", "named", cause=["robot.lost_commands"]),
          block("force", "nothing_detectable", cause=[]), losses_are_the_robots_error(), slow=seed > 1) for seed in (1, 2)],
    Row("spikes are in the error as given", run_with(LOST_RUN | {"sensor.spike_probability": 0.01, "sensor.spike_N": 20.0}),
        verdict("named"), at("block", "force"), spikes_are_in_the_error_as_given(20.0, 0.01)),
]


@pytest.mark.long
@each(COARSE + BURSTS + BIASES)
def test_sensor(row, tmp_path):
    row.check(tmp_path / "out")
