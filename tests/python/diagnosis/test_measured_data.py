"""Measured data of other people, in $BERTH_DATA or ../shared/data: each is skipped, and says so, where it is absent."""

import numpy as np
import pytest
from checks import (Between, at, causes, causes_in_order, check, doubt, has_cause, name_of, near, no_cause, note, offers, offers_only, size,
                    verdict)
from recipes import measured
from table import Row, each

# --- a drive whose mass and viscous friction are known (EMPS benchmark, Janot, Gautier & Brunot 2019) --------------
DRIVE = """
name = "drive"
[loop]
rate_Hz = 1000
[manipulator]
mass_kg = 95.1089
damping_N_s_per_m = 203.5034
stiffness_N_per_m = 0.0
[operator]
interface = "force"
[signals]
command_position_m = "qm_m"
operator_force_N = { column = "vir_V", scale = 35.15065 }
"""


def known_to(tolerance):
    text = DRIVE
    for value in ("95.1089", "203.5034") if tolerance else ():
        text = text.replace(value, f"{{ value = {value}, tolerance = {tolerance} }}")
    return text


@check
def every_cause_gains_on_unseen_data(told):
    assert all(cause["held_out_gain"]["ci95"][0] > 0.0 for cause in told.found["causes"])


# Within 2 % of the published values, though the record knows no zero of either; then the asymmetry.
DRIVES = [Row(f"friction and offset of a real drive, {f'parameters known to {tolerance}' if tolerance else 'no tolerances given'}",
              measured(record="emps/train.csv.gz", validate="emps/test_pulses.csv.gz", rig=known_to(tolerance)),
              causes_in_order("manipulator.coulomb_friction", "manipulator.gravity_offset", "manipulator.asymmetric_friction"),
              size("manipulator.coulomb_friction.coulomb_friction_N", near(20.3935, rel=0.02)),
              # published: -3.1648; by an inverse model of the same record: -3.20
              size("manipulator.gravity_offset.gravity_offset_N", near(-3.20, rel=0.02)), every_cause_gains_on_unseen_data(),
              slow=bool(tolerance))
          for tolerance in (None, 0.005)]


# --- a hobby servo as the robot; its angle in half turns is displayed as metres ------------------------------------
SERVO_DATA = "hobby_servo/paired_real_sim.csv.gz"
# It goes to a command as soon as that is there: nothing interpolates.
SERVO = """
name = "servo"
[loop]
rate_Hz = 50
[robot]
dead_time_ms = 20.0
interpolation = "hold"
[sensor]
delay_ms = 20.0
[signals]
command_position_m = "command_halfturn"
robot_position_m = "real_angle_halfturn"
segment = "rollout"
"""
AUTHORS_SERVO = SERVO.replace("real_angle_halfturn", "authors_mujoco_sim_angle_halfturn").replace(
    "[sensor]\ndelay_ms = 20.0\n", "")
HELD_OUT = "residual.robot_position_m.held_out"


def every_other_rollout(row):
    return int(row.split(",")[0]) % 2


@check
def interval_meets(told, name, low, high):
    """The interval of 95 % and this one have something in common."""
    ours = told.parameter(name)["ci95"]
    assert ours[0] < high and ours[1] > low


@check
def leaves_a_share(told, below):
    left = told.at(HELD_OUT)
    assert left["after"] < below * left["before"]


@check
def every_candidate_has_numbers(told):
    """A drift of the dead time that its fit had left with a replay without numbers; the report could not be drawn."""
    tried = [one for block in told.found["blocks"] for one in block["ranking"]]
    assert len(tried) > 5 and all(np.isfinite([one["delta_bic"], one["share_explained"]]).all() for one in tried)


SERVOS = [
    # 1.52 to 1.55 half turns a second, read from the slopes of the record: data/hobby_servo/PROVENANCE.md
    Row("speed limit of a real servo", measured(record=SERVO_DATA, rig=SERVO), verdict("partly_explained"),
        at("block", "robot"), causes_in_order("robot.velocity_limit", "robot.lag"),
        interval_meets("velocity_limit_m_per_s", 1.52, 1.55), size("velocity_limit_m_per_s", near(1.535, rel=0.06)),
        offers_only("robot.velocity_limit", "robot.lag", "robot.dead_time"), leaves_a_share(below=0.12)),
    Row("what diverges is no candidate for a real servo", measured(record=SERVO_DATA, rig=AUTHORS_SERVO),
        every_candidate_has_numbers()),
    # A dead time of 20 to 45 ms is in the data: it lowers the error in 95 to 97 of 100 draws of unseen stretches.
    Row("each limit of a real servo is found where other rollouts prove it",
        measured(record=SERVO_DATA, rig=SERVO, keeps=every_other_rollout), verdict("partly_explained"), at("block", "robot"),
        causes("robot.lag", "robot.velocity_limit"), size("velocity_limit_m_per_s", near(1.535, rel=0.08)),
        doubt("robot", "robot.dead_time was fitted, and does not predict unseen data better"), leaves_a_share(below=0.12)),
]


# --- a robot arm, target and actual angle in one packet; its lag is below one row ----------------------------------
ROBOT_JOINT = """
name = "joint"
[robot]
dead_time_ms = 8.0
interpolation = "linear"
[signals]
command_position_m = "q{joint}_target_rad"
robot_position_m = "q{joint}_rad"
"""
# --- a pendulum that swings freely; published friction 4.1e-3 Nm, a plain fit in windows of 60 rows 3.5e-3 ---------
PENDULUM = """
name = "free pendulum"
[manipulator]
mass_kg = { value = 0.022448, tolerance = 0.1 }
damping_N_s_per_m = { value = 0.0005, tolerance = 0.99 }
stiffness_N_per_m = 0.0
[operator]
interface = "force"
[signals]
command_position_m = "angle_rad"
operator_force_N = "gravity_Nm"
"""
@check
def rubs_with(told, low_N, high_N):
    """Dry friction, whichever of its two models says it: what builds up over a way is both."""
    [name] = [name for name in ("hysteresis_force_N", "coulomb_friction_N")
              if any(name_of(one) == name for cause in told.found["causes"] for one in cause["parameters"])]
    assert low_N < told.parameter(name)["value"] < high_N, name


# --- a band that rubs, with play: slips at 2.1 to 2.9 kip; and a cylinder: rubs with 4 to 5 N beside a preload -----
BENCH = """
name = "bench"
[object]
mass_kg = {mass_kg}
stiffness_N_per_m = {{ value = {stiffness}, tolerance = {tolerance} }}
damping_N_s_per_m = {{ value = {damping}, tolerance = {tolerance} }}
[sensor]
low_pass_order = 0
delay_ms = 0.0
[bus]
ideal = true
[signals]
segment = "segment"
"""
BAND = BENCH.format(mass_kg=1.0, stiffness=4.0e5, damping=1.0e4, tolerance=0.5) + """
robot_position_m = { column = "x_in", scale = 0.0254 }
force_N = { column = "F_kip", scale = 4448.22 }
"""
CYLINDER = BENCH.format(mass_kg=0.1, stiffness=10.0, damping=10.0, tolerance=0.9) + """
robot_position_m = { column = "x_mm", scale = 0.001 }
force_N = "F_less_pA_N"
[loop]
rate_Hz = 100
"""
NO_FAULT_OF_THE_SENSOR = ("sensor.dropouts", "sensor.drift", "sensor.spikes", "sensor.saturation")
BENCHES = [
    *(Row(f"a robot arm's lag below one row, joint {joint}",
          measured(record="ur5e_rtde/motion.csv.gz", rig=ROBOT_JOINT.format(joint=joint)), verdict("one_of"),
          causes("robot.dead_time"), offers_only("robot.dead_time", "robot.lag"),
          size("dead_time_ms", near(0.5, abs=0.05)), at(f"{HELD_OUT}.after", Between(high=high_rad)))
      for joint, high_rad in ((1, 0.065e-3), (2, 0.09e-3))),
    Row("a robot arm's lag below one row, joint 5, whose gears show as well",
        measured(record="ur5e_rtde/motion.csv.gz", rig=ROBOT_JOINT.format(joint=5)), verdict("partly_explained"),
        causes("robot.dead_time"),
        size("dead_time_ms", near(0.5, abs=0.05)), at(f"{HELD_OUT}.after", Between(high=0.09e-3))),
    Row("dry friction of a free pendulum",
        measured(record="free_pendulum/train.csv.gz", validate="free_pendulum/validate.csv.gz", rig=PENDULUM),
        causes("manipulator.coulomb_friction"), size("coulomb_friction_N", near(3.8e-3, rel=0.2)),
        at("residual.command_position_m.held_out.after", Between(high=1.7e-3))),
    Row("friction and play of a damper",
        measured(record="friction_play_damper/train.csv.gz", validate="friction_play_damper/validate_0.25Hz_1.csv.gz", rig=BAND),
        has_cause("object.hysteresis"), offers("object.hysteresis", "object.backlash"), no_cause(*NO_FAULT_OF_THE_SENSOR),
        size("hysteresis_force_N", Between(2.4 * 4448.22, 2.7 * 4448.22)), slow=True),
    Row("preload and friction of a cylinder, logged by a computer that stalls",
        measured(record="pneumatic_cylinder/3bar_1.csv.gz", validate="pneumatic_cylinder/3bar_2.csv.gz", rig=CYLINDER),
        has_cause("sensor.bias"), rubs_with(3.0, 5.0), no_cause(*NO_FAULT_OF_THE_SENSOR),
        note("stamps late"), slow=True),
]


@pytest.mark.long
@each(DRIVES + SERVOS + BENCHES)
def test_measured(row, tmp_path):
    row.check(tmp_path / "out")
