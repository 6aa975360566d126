"""Two effects at once, of one block or of robot and sensor: both are named with their sizes, or a rival of either is told;
never one that stands in."""

import pytest
from checks import check, named, near, offers, offers_no, size, verdict
from make_run import LONG, WELL_KNOWN, blind
from recipes import run_with
from table import Row, each

PAIRS = [{"robot.lag_ms": 8.0, "robot.backlash_m": 1e-4},  # beside the lag the play is small, and yet all that is left
         {"object.cubic_stiffness_N_per_m3": 3e6, "object.coulomb_friction_N": 2.0},
         {"robot.dead_time_ms": 20.0, "robot.periodic_error_m": 5e-5, "robot.periodic_error_pitch_m": 0.004},
         {"robot.lag_ms": 8.0, "robot.velocity_limit_m_per_s": 0.06}]


@check
def sizes_and_intervals(told, hidden):
    assert len(told.causes) == 2
    for key, true in hidden.items():
        one = told.parameter(key.split(".")[1])
        assert one["value"] == near(true, rel=0.01)
        assert one["ci95"][0] - 1e-3 * true < true < one["ci95"][1] + 1e-3 * true


@check
def right_or_not_named(told, *names):
    """A lag of the robot and a delay of the sensor do what is a dead time and a lag: in the force both are alike."""
    blocks = (told.block("robot")["verdict"], told.block("force")["verdict"])
    assert set(told.causes) == set(names) or "named" not in blocks


@check
def named_if_not_one_of(told, *names):
    assert told.verdict == "one_of" or set(told.causes) == set(names)


@check
def right_or_doubted(told, *names):
    """As one resonance both do what they do, damped more than critically."""
    [one] = told.found["blocks"]
    assert set(told.causes) == set(names) or (
        told.verdict == "partly_explained" and "two other effects together do as well" in one["doubts"])


LATE = [{"sensor.lag_ms": 6.0}, {"sensor.delay_ms": 7.5}]
LAGS = [(5.0, 4.0), (6.0, 4.0), (4.0, 5.0)]
BLIND = [{"robot.lag_ms": 6.0, "sensor.lag_ms": 4.0}, {"robot.lag_ms": 8.0, "sensor.lag_ms": 5.0}]


def effect_of(key):
    return key.removesuffix("_ms")


ROWS = [
    *[Row(" and ".join(pair), run_with(LONG | pair), verdict("named"), sizes_and_intervals(pair), slow=n > 0)
      for n, pair in enumerate(PAIRS)],
    # To reports that are as noisy as this the robot is late in any way.
    Row("a late sensor behind noisy reports of a late robot",
        run_with(LONG | {"robot.dead_time_ms": 22.0, "sensor.lag_ms": 1.0, "robot.feedback_noise_m": 1e-4}),
        right_or_not_named("robot.dead_time", "sensor.lag")),
    *[Row(f"{key} of {true} behind clear reports of a late robot", run_with(LONG | {"robot.lag_ms": 8.0} | late),
          named("robot.lag", effect_of(key)), size(f"{effect_of(key)}.{key.split('.')[1]}", near(true, rel=0.05)),
          slow=key == "sensor.delay_ms") for late in LATE for key, true in late.items()],
    # The robot's could make up for the sensor's, if its reports did not hold it.
    *[Row(f"a sensor that lags {sensor_ms} ms behind a robot that lags {robot_ms} ms",
          run_with(LONG | {"robot.lag_ms": robot_ms, "sensor.lag_ms": sensor_ms}), verdict("named", "one_of"),
          offers("robot.lag", "sensor.lag"), named_if_not_one_of("robot.lag", "sensor.lag"), slow=(robot_ms, sensor_ms) != LAGS[0])
      for robot_ms, sensor_ms in LAGS],
    *[Row(f"two lags without reports, {lags['robot.lag_ms']} and {lags['sensor.lag_ms']} ms", blind(values=LONG | lags),
          right_or_doubted("robot.lag", "sensor.lag")) for lags in BLIND],
    # A resonance contains the lag; only beside the gain do both do as well, where the object is known too well for it.
    Row("a lag without reports is no resonance beside a gain",
        blind(values=LONG | {"robot.lag_ms": 6.0, "sensor.gain_error": 0.1, "loop.rate_Hz": 400, "object.mass_kg": 12.2},
              rig=WELL_KNOWN),
        verdict("one_of"), offers_no("robot.resonance"), offers("robot.lag", "sensor.lag", "robot.gain", "sensor.gain"),
        slow=True),
]


@pytest.mark.long
@each(ROWS)
def test_two(row, tmp_path):
    row.check(tmp_path / "out")
