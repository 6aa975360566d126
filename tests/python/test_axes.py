"""A robot of more than one axis in the loop: poses out, wrenches back, each axis with its own dead time."""

import cantools
import numpy as np
import pytest
from conftest import (DBC, EXIT_DIFFERENT, EXIT_INPUT, RIG_FOLDER, ROOT, STATE_RUNNING, command, data_id,
                      one_json_object, patched, record_type, replay_json, run_json, topic, ulog_messages,
                      without_checksums)
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

SIDE_TOPIC = 5
BERTHING = (RIG_FOLDER / "ess-berthing.toml").read_text()
PLANAR_AXES = """
[axis.y]
mass_kg = 60.0
stiffness_N_per_m = 1500.0
damping_N_s_per_m = 20.0
robot_dead_time_ms = 25.0

[axis.rz]
inertia_kg_m2 = 40.0
stiffness_N_m_per_rad = 900.0
damping_N_m_s_per_rad = 8.0
robot_dead_time_ms = 12.5
"""
LAYOUT = ("--set", "sensor_channel.layout=three_frames_motorola")


def rig_file(folder, *parts, name="axes"):
    """ess-berthing for 8 s from the grip on, with more said."""
    text = BERTHING.replace("grip_close_s = 20.0", "grip_close_s = 0.0").replace("duration_s = 70.0", "duration_s = 8.0")
    file = folder / f"{name}.toml"
    file.write_text(text.split("[[orders]]")[0] + "".join(parts) + """
[[orders]]
at_s = 0.5
line_m = [-0.01, 0.004]
speed_m_per_s = 0.005
""")
    return file


def test_every_axis_has_its_own_dead_time(tmp_path):
    result = run_json(rig_file(tmp_path, PLANAR_AXES), tmp_path, *LAYOUT)
    assert result["frames_rejected"] == 0 and result["frames_lost"] == 0
    tick, side = topic(result["log"]), topic(result["log"], "side")
    assert np.all(tick["state"][100:-1] == STATE_RUNNING)
    for axis, unit, dead_time_ticks in (("y", "m", 10), ("rz", "rad", 5)):
        sent, reported = side[f"{axis}_command_{unit}"], side[f"{axis}_robot_{unit}"]
        assert np.abs(sent).max() > 1e-4
        # What is reported is a tick old; the dead times are whole ticks, so the robot is at a setpoint there.
        late = dead_time_ticks + 1
        assert np.abs(reported[late:] - sent[:-late]).max() < 2e-11
    assert np.all(side["z_command_m"] == 0.0) and np.all(side["rx_torque_N_m"] == 0.0)
    assert np.abs(side["rz_manipulator_rad"][100:] - side["rz_command_rad"][100:]).max() < 1e-11


def loads_of(positions, mass, stiffness, damping, sensor_stiffness, period_s=2.5e-3):
    """Of a mass on spring and damper behind a sensor's spring, its other end on straight lines through `positions`:
    by scipy's matrix exponential."""
    sensor_damping = 2 * 0.05 * np.sqrt(sensor_stiffness * mass)
    rates = np.zeros((4, 4))  # x, x', position and velocity of the other end
    rates[0, 1] = rates[2, 3] = 1.0
    rates[1] = [-(stiffness + sensor_stiffness) / mass, -(damping + sensor_damping) / mass, sensor_stiffness / mass,
                sensor_damping / mass]
    over = expm(rates * period_s)
    velocities = np.append(np.diff(positions) / period_s, 0.0)
    state, loads = np.zeros(4), []
    for position, velocity in zip(positions, velocities):
        state[2:] = position, velocity
        loads.append(sensor_stiffness * (position - state[0]) + sensor_damping * (velocity - state[1]))
        state = over @ state
    return np.array(loads)


def test_the_measured_loads_are_those_of_each_axis_hardware(tmp_path):
    log = run_json(rig_file(tmp_path, PLANAR_AXES), tmp_path, *LAYOUT, "--set", "sensor.low_pass_order=0")["log"]
    side = topic(log, "side")
    for load, position, *hardware in (("y_force_N", "y_robot_m", 60.0, 1500.0, 20.0, 2e7),
                                      ("rz_torque_N_m", "rz_robot_rad", 40.0, 900.0, 8.0, 2e6)):
        expected = loads_of(side[position], *hardware)
        assert np.ptp(expected) > 0.1
        # Positions come in steps of 1e-11, which the sensor's spring makes a force of.
        step = 1e-11 * hardware[3]
        assert np.abs(side[load][1:-1] - expected[1:-1]).max() < 30 * step, load


def test_what_is_called_x_and_what_y_does_not_matter(tmp_path):
    """The same hardware, once as the loop's axis and once as another: the arm goes the same way."""
    swapped = """
[axis.y]
mass_kg = 100.0
stiffness_N_per_m = 2368.705056261446
damping_N_s_per_m = 19.46773764467334
robot_dead_time_ms = 17.5
"""
    straight = swapped.replace("100.0", "60.0").replace("2368.705056261446", "1500.0").replace("17.5", "25.0")
    first = rig_file(tmp_path, straight, name="first")
    second = rig_file(tmp_path, swapped, name="second")
    fine = ("--set", "sensor_channel.layout=three_frames_motorola")
    a = topic(run_json(first, tmp_path, *fine)["log"], "arm")
    b = topic(run_json(second, tmp_path, *fine, "--set", "manipulator.direction_x=0", "--set",
                       "manipulator.direction_y=1", "--set", "object.mass_kg=60", "--set",
                       "object.stiffness_N_per_m=1500", "--set", "robot.dead_time_ms=25", "--set",
                       "manipulator.mass_kg=200")["log"], "arm")
    for field in ("tool_x_m", "tool_y_m", "base_turn_rad"):
        assert np.ptp(a[field]) > 1e-5
        # Frames carry 1e-5 N; what is left grows with the loop.
        assert np.abs(a[field] - b[field]).max() < 1e-5 * np.ptp(a[field]), field


CROSSTALK = np.eye(6) + 0.03 * np.array([[0, 1, -1, 2, 0, 1], [1, 0, 1, 0, 1, -2], [0, 2, 0, 1, 1, 0],
                                         [1, 0, 0, 0, 1, 1], [0, -1, 1, 0, 0, 2], [2, 0, 1, -1, 0, 0]])
MOUNTING = {"roll_rad": 0.4, "pitch_rad": -0.7, "yaw_rad": 2.1, "x_m": 0.12, "y_m": -0.05, "z_m": 0.3}


def wrench_section():
    rows = ",\n".join(str(list(map(float, row))) for row in CROSSTALK)
    return "\n[wrench]\n" + "".join(f"{key} = {value}\n" for key, value in MOUNTING.items()) + f"crosstalk = [{rows}]\n"


def samples(log):
    """Wrenches as the sensor's frames carry them, decoded by cantools, by their counter in order."""
    database = cantools.database.load_file(DBC)
    frames = topic(log, "can_frame")
    values = {}
    for which, names in (("wrench3m_x", ("fx_N", "tx_N_m")), ("wrench3m_y", ("fy_N", "ty_N_m")),
                         ("wrench3m_z", ("fz_N", "tz_N_m"))):
        message = database.get_message_by_name(which)
        found = [message.decode(int(data).to_bytes(8, "little")) for data, id in zip(frames["data"], frames["id"])
                 if id == message.frame_id]
        for name in names:
            values[name] = np.array([frame[name] for frame in found])
    return np.array([values[name] for name in ("fx_N", "fy_N", "fz_N", "tx_N_m", "ty_N_m", "tz_N_m")])


def test_crosstalk_and_mounting_are_undone(tmp_path):
    plain = run_json(rig_file(tmp_path, PLANAR_AXES), tmp_path, *LAYOUT)["log"]
    mounted = run_json(rig_file(tmp_path, PLANAR_AXES, wrench_section(), name="mounted"), tmp_path, *LAYOUT)["log"]
    a, b = topic(plain, "side"), topic(mounted, "side")
    assert np.ptp(a["y_force_N"]) > 1 and np.ptp(a["rz_torque_N_m"]) > 0.1
    for field, step in (("y_force_N", 1e-5), ("rz_torque_N_m", 1e-5), ("y_command_m", 1e-8)):
        assert np.abs(a[field] - b[field]).max() < 20 * step + 1e-4 * np.ptp(a[field]), field

    # By scipy and numpy, from the frames: shown = crosstalk * (turned force, turned torque about the sensor).
    to_sensor = Rotation.from_euler("xyz", [MOUNTING[key] for key in ("roll_rad", "pitch_rad", "yaw_rad")]).as_matrix().T
    lever = np.cross(np.eye(3), [MOUNTING[key] for key in ("x_m", "y_m", "z_m")])
    whole = np.block([[to_sensor, np.zeros((3, 3))], [-to_sensor @ lever, to_sensor]])
    shown = samples(mounted)
    load = np.linalg.solve(CROSSTALK @ whole, shown)
    tick = topic(mounted)
    count = len(tick["force_N"])
    first = count - shown.shape[1] if shown.shape[1] < count else 0
    assert np.abs(load[0][-count + first:] - tick["force_N"][first:]).max() < 1e-9 + 1e-12 * np.ptp(tick["force_N"])
    assert np.abs(load[1][-count + first:] - b["y_force_N"][first:]).max() < 1e-9
    assert np.abs(load[5][-count + first:] - b["rz_torque_N_m"][first:]).max() < 1e-9
    assert np.abs(shown[2]).max() > 0.1, "the sensor's z shows what there is not in the robot's frame"


def seven(folder):
    """A spatial arm, from its URDF."""
    text = command("arm", ROOT / "tests" / "arms" / "seven.urdf", "--tool", "gripper").stdout.decode()
    arm = folder / "seven.toml"
    angles = iter((0.3, 0.6, -0.4, -1.2, 0.5, 0.9, 0.2))
    arm.write_text("\n".join(f"initial_rad = {next(angles)}" if line.startswith("initial_rad") else line
                             for line in text.splitlines()) + "\n")
    return arm


SIX = "".join(f"\n[axis.{axis}]\n{'mass_kg' if axis in 'yz' else 'inertia_kg_m2'} = {0.5 if axis in 'yz' else 0.01}\nrobot_dead_time_ms = "
              f"{5.0 + 2.5 * i}\n" for i, axis in enumerate(("y", "z", "rx", "ry", "rz")))


def six_axes(folder):
    file = rig_file(folder, SIX, name="six")
    file.write_text(file.read_text().replace('arm = "ess"', f'arm = "{seven(folder)}"')
                    .replace("line_m = [-0.01, 0.004]", "line_m = [-0.01, 0.004, 0.006]")
                    .replace("duration_s = 8.0", "duration_s = 4.0"))
    return file


def test_six_axes_on_a_spatial_arm(tmp_path):
    result = run_json(six_axes(tmp_path), tmp_path, *LAYOUT, "--set", "object.mass_kg=0.5", "--set",
                      "object.stiffness_N_per_m=0")
    assert result["state"] == "running" and result["prediction"]["growth_per_s"] < 0
    assert result["frames_rejected"] == 0 and result["frames_lost"] == 0
    side, arm = topic(result["log"], "side"), topic(result["log"], "arm")
    for i, name in enumerate(("y_{}_m", "z_{}_m", "rx_{}_rad", "ry_{}_rad", "rz_{}_rad")):
        late = 2 + i + 1
        sent, reported = side[name.format("command")], side[name.format("robot")]
        assert np.ptp(sent) > 1e-7, name
        assert np.abs(reported[late:] - sent[:-late]).max() < 2e-11, name
    # The direction is x, so the robot's frame is the world's.
    for axis in "yz":
        way = arm[f"tool_{axis}_m"] - arm[f"tool_{axis}_m"][0]
        assert np.abs(way - side[f"{axis}_manipulator_m"]).max() < 1e-12
    assert replay_json(result["log"])["equal"]


def test_arm64_replays_six_axes_bit_for_bit(tmp_path, arm64):
    log = run_json(six_axes(tmp_path), tmp_path, *LAYOUT, "--set", "run.duration_s=1")["log"]
    assert replay_json(log, program=arm64)["equal"]


def test_turns_about_several_axes_stay_below_half_a_turn_together(tmp_path):
    file = six_axes(tmp_path)
    text = file.read_text()
    for limit_rad, is_taken in ((1.7, True), (1.8, False)):
        changed = text.replace("inertia_kg_m2 = 0.01", f"inertia_kg_m2 = 0.01\nangle_limit_rad = {limit_rad}")
        assert changed != text
        file.write_text(changed)
        done = command("run", file, "--print-config", *LAYOUT)
        assert done.returncode == (0 if is_taken else EXIT_INPUT), done.stderr.decode()
        assert is_taken or b"axis.rz.angle_limit_rad: leads beyond half a turn" in done.stderr


def test_a_recorded_side_is_compared_too(tmp_path):
    log = run_json(rig_file(tmp_path, PLANAR_AXES), tmp_path, *LAYOUT, "--set", "run.duration_s=1")["log"]
    assert replay_json(log)["equal"]
    data = without_checksums(open(log, "rb").read())
    sides = [message for message in ulog_messages(data) if data_id(message) == SIDE_TOPIC]
    assert len(sides) == 400
    changed = tmp_path / "changed.ulg"
    changed.write_bytes(patched(data, sides[321], record_type(data, "side"), "rz_torque_N_m",
                                lambda value: np.nextafter(value, 9.0)))
    difference = replay_json(changed, EXIT_DIFFERENT)["first_difference"]
    assert (difference["tick"], difference["field"]) == (321, "side rz_torque_N_m")


def test_limits_act_on_every_axis(tmp_path):
    slow = PLANAR_AXES + "velocity_limit_m_per_s = 1\n"  # of no turning axis
    done = command("run", rig_file(tmp_path, slow), "--no-log", *LAYOUT)
    assert done.returncode == EXIT_INPUT and b"rate_limit_rad_per_s" in done.stderr
    slow = PLANAR_AXES.replace("robot_dead_time_ms = 25.0", "robot_dead_time_ms = 25.0\nvelocity_limit_m_per_s = 0.001")
    log = run_json(rig_file(tmp_path, slow), tmp_path, *LAYOUT)["log"]
    tick, side = topic(log), topic(log, "side")
    speed = np.abs(np.diff(side["y_command_m"])) / 2.5e-3
    assert speed.max() < 0.001 * (1 + 1e-6)
    assert np.any(tick["limits"] & 4), "velocity"


def test_frames_of_all_axes_are_laid_out_alike():
    database = cantools.database.load_file(DBC)
    for kind, first in (("setpoint", "setpoint"), ("feedback", "robot_feedback")):
        reference = database.get_message_by_name(first)
        for axis in ("y", "z", "rx", "ry", "rz"):
            message = database.get_message_by_name(f"{kind}_{axis}")
            assert message.length == reference.length
            layout = lambda of: [(s.start, s.length, s.is_signed, s.scale, s.minimum, s.maximum) for s in of.signals]  # noqa: E731
            assert layout(message) == layout(reference)


def test_the_resolved_rig_reads_back(tmp_path):
    text = command("run", rig_file(tmp_path, PLANAR_AXES, wrench_section()), "--print-config", *LAYOUT).stdout.decode()
    again = tmp_path / "again.toml"
    again.write_text(text)
    assert "[axis.rz]" in text and "[wrench]" in text
    assert command("run", again, "--print-config").stdout.decode() == text


@pytest.mark.parametrize("old,new,says", [
    ("[axis.y]", "[axis.x]", "axis.x: must be a section"),
    ("[axis.y]", "[axis.z]", "is none of a planar arm's"),
    ("mass_kg = 60.0", "mass_kg = 0.0", "greater than 0"),
    ("mass_kg = 60.0", "mass_kg = nan", "finite number"),
    ("mass_kg = 60.0", "inertia_kg_m2 = 60.0", "axis.y.inertia_kg_m2: unknown"),
    ("mass_kg = 60.0\n", "", "axis.y.mass_kg: must be greater than 0"),
    ("damping_N_s_per_m = 20.0\nrobot", "damping_N_s_per_m = -1.0\nrobot", "0 or more"),
    ("robot_dead_time_ms = 12.5", "robot_dead_time_ms = 1", "a period at least"),
    ("robot_dead_time_ms = 12.5", "angle_limit_rad = 4", "must be 3 at most"),
    ("robot_dead_time_ms = 12.5", "robot_dead_time_ms = 1e9", "axis.rz.robot_dead_time_ms: must be from 0 to 1e+05"),
    ("stiffness_N_per_m = 1500.0", "stiffness_N_per_m = 1e300", "axis.y.stiffness_N_per_m: must be from 0 to 1e+13"),
    ("mass_kg = 60.0", "mass_kg = 1e-300", "axis.y.mass_kg: must be from 1e-06 to 1e+09"),
    ("x_m = 0.12", "x_m = 1e300", "wrench.x_m: must be within +-100"),
    ("roll_rad = 0.4", "roll_rad = 23", "wrench.roll_rad: must be within +-10"),
    ('arm = "ess"', "", "needs an arm"),
    ("[axis.y]", "[robot_channel]\nprofile = \"cia402\"\n[axis.y]", "frames of berth.dbc alone"),
    ("roll_rad = 0.4", "roll_deg = 0.4", "wrench.roll_deg: unknown"),
    ("x_m = 0.12", "x_m = inf", "finite number"),
    ("crosstalk = [[", "crosstalk = [[7, ", "six rows of six"),
    ("crosstalk = [", "torque_noise_N_m = -1\ncrosstalk = [", "0 or more"),
])
def test_what_is_wrong_is_said(tmp_path, old, new, says):
    file = rig_file(tmp_path, PLANAR_AXES, wrench_section())
    text = file.read_text()
    assert old in text
    file.write_text(text.replace(old, new, 1).replace('arm = "ess"\n', 'arm = "ess"\n'))
    done = command("run", file, "--no-log", *LAYOUT)
    message = done.stderr.decode()
    assert done.returncode == EXIT_INPUT, message
    assert says in message and message.count("\n") == 1, message


def test_a_singular_crosstalk_and_a_sensor_of_one_axis_are_refused(tmp_path):
    singular = "\n[wrench]\ncrosstalk = [" + ", ".join(["[1, 1, 1, 1, 1, 1]"] * 6) + "]\n"
    done = command("run", rig_file(tmp_path, PLANAR_AXES, singular), "--no-log", *LAYOUT)
    assert done.returncode == EXIT_INPUT and b"cannot be undone" in done.stderr
    done = command("run", rig_file(tmp_path, PLANAR_AXES), "--no-log")
    assert done.returncode == EXIT_INPUT and b"sensor_channel.layout" in done.stderr


@pytest.mark.parametrize("size,is_taken", [(1e-300, False), (1e-4, False), (0.01, True), (100, True), (1e4, False),
                                           (1e150, False)])
def test_a_sensor_in_other_units_is_refused(tmp_path, size, is_taken):
    rows = ", ".join(str([size if i == j else 0.0 for i in range(6)]) for j in range(6))
    done = command("run", rig_file(tmp_path, PLANAR_AXES, f"\n[wrench]\ncrosstalk = [{rows}]\n"), "--print-config",
                   *LAYOUT)
    assert done.returncode == (0 if is_taken else EXIT_INPUT)
    assert is_taken or b"wrench.crosstalk: shows loads" in done.stderr, done.stderr.decode()


def test_a_setpoint_that_comes_after_its_time_is_refused(tmp_path):
    """An axis whose dead time is over before the setpoint is on the bus would not move at all."""
    file = rig_file(tmp_path, PLANAR_AXES.replace("robot_dead_time_ms = 25.0", "robot_dead_time_ms = 0.9"))
    hold = (*LAYOUT, "--set", "robot.interpolation=hold", "--set", "run.duration_s=2")
    done = command("run", file, "--no-log", *hold)
    assert done.returncode == EXIT_INPUT
    assert b"axis.y.robot_dead_time_ms: is shorter than the setpoint's time on the bus" in done.stderr
    side = topic(run_json(file, tmp_path, *hold, "--set", "bus.ideal=true")["log"], "side")
    assert np.ptp(side["y_command_m"]) > 1e-4
    assert np.abs(side["y_robot_m"][1:] - side["y_command_m"][:-1]).max() < 2e-11


def test_a_dead_time_that_jumps_does_so_along_every_axis(tmp_path):
    file = rig_file(tmp_path, PLANAR_AXES)
    jump = (*LAYOUT, "--set", "run.dead_time_jump_s=4", "--set")
    done = command("run", file, "--no-log", *jump, "run.dead_time_jump_ms=-10")
    assert done.returncode == EXIT_INPUT
    assert b"run.dead_time_jump_ms: must leave axis.rz a dead time of 2 periods or more" in done.stderr
    side = topic(run_json(file, tmp_path, *jump, "run.dead_time_jump_ms=-5")["log"], "side")
    for axis, unit, ticks in (("y", "m", 10), ("rz", "rad", 5)):
        sent, reported = side[f"{axis}_command_{unit}"], side[f"{axis}_robot_{unit}"]
        for late, part in ((ticks + 1, slice(100, 1500)), (ticks - 1, slice(1700, 3100))):
            assert np.abs(reported[part] - sent[part.start - late:part.stop - late]).max() < 2e-11, axis


@pytest.mark.parametrize("order,says", [
    ("joint = 1.9\nrate_rad_per_s = 0.001", "orders.joint: must be a whole number (is 1.9)"),
    ("joint = 1\nrate_rad_per_s = 0.001\nspeed_m_per_s = 0.1", "orders.speed_m_per_s: goes with line_m only"),
    ("line_m = [0.01, 0]\nspeed_m_per_s = 0.1\nrate_rad_per_s = 0.001", "orders.rate_rad_per_s: goes with joint only"),
    ("follow = true\nmove_to_rad = 1.3", "orders.move_to_rad: goes with joint only"),
    ("joint = 1", "orders.joint: needs rate_rad_per_s or move_to_rad"),
    ("joint = 1\nrate_rad_per_s = 0", None),
])
def test_an_order_has_no_key_that_does_nothing(tmp_path, order, says):
    file = rig_file(tmp_path)
    file.write_text(file.read_text().split("[[orders]]")[0] + f"\n[[orders]]\nat_s = 0.5\n{order}\n")
    done = command("run", file, "--print-config")
    assert done.returncode == (0 if says is None else EXIT_INPUT), done.stderr.decode()
    assert says is None or says in done.stderr.decode()


def dead_times_ms(file, *arguments):
    text = command("run", file, "--print-config", *LAYOUT, *arguments).stdout.decode()
    axes = {line.split("=")[1].split("#")[0].strip() for line in text.splitlines() if "robot_dead_time_ms" in line}
    return {float(value) for value in axes}


def test_another_robot_has_its_dead_time_along_every_axis(tmp_path):
    file = rig_file(tmp_path, PLANAR_AXES)
    assert dead_times_ms(file) == {25.0, 12.5}
    assert dead_times_ms(file, "--robot", "yaskawa-dx200") == {250.0}
    assert dead_times_ms(file, "--robot", "ethercat-csp") == {7.5}
    assert dead_times_ms(file, "--robot", "abb-egm", "--set", "robot.dead_time_ms=50") == {50.0}


def test_both_ends_of_a_range_are_those_of_every_axis(tmp_path):
    file = rig_file(tmp_path, PLANAR_AXES)
    of = lambda *more: one_json_object(command("eigen", file, "--json", *LAYOUT, "--robot", "abb-egm", *more).stdout)  # noqa: E731
    both = of()
    assert both["growth_per_s"] == of("--set", "robot.dead_time_ms=80")["growth_per_s"]
    assert both["lower_end"]["growth_per_s"] == of("--set", "robot.dead_time_ms=40")["growth_per_s"]
    assert both["lower_end"]["growth_per_s"] != both["growth_per_s"]


def test_more_eigenvalues_than_memory_are_refused(tmp_path):
    slow = PLANAR_AXES.replace("robot_dead_time_ms = 25.0", "robot_dead_time_ms = 1e5")
    for file in (rig_file(tmp_path, slow), rig_file(tmp_path, PLANAR_AXES.replace("25.0", "3000").replace("12.5", "3000"))):
        done = command("eigen", file, *LAYOUT)
        assert done.returncode == EXIT_INPUT and b"eigenvalues; more than" in done.stderr, done.stderr.decode()


def test_what_the_command_line_cannot_set_is_said(tmp_path):
    for key in ("axis.y.mass_kg=80", "wrench.x_m=1", "orders.at_s=2"):
        done = command("run", rig_file(tmp_path, PLANAR_AXES), "--no-log", *LAYOUT, "--set", key)
        assert done.returncode == EXIT_INPUT and b"is set in the rig file alone" in done.stderr


@pytest.mark.long
@pytest.mark.parametrize("stiffer,duration_s", [(1, 240), (4, 95)])
def test_it_grows_as_its_eigenvalues_say(tmp_path, stiffer, duration_s):
    axes = PLANAR_AXES.replace("stiffness_N_per_m = 1500.0", f"stiffness_N_per_m = {1500.0 * stiffer}")
    file = rig_file(tmp_path, axes)
    file.write_text(file.read_text().replace("duration_s = 8.0", f"duration_s = {duration_s}.0"))
    expected = one_json_object(command("eigen", file, "--json", *LAYOUT).stdout)["growth_per_s"]
    alone = one_json_object(command("eigen", rig_file(tmp_path, name="alone"), "--json").stdout)["growth_per_s"]
    assert abs(expected - alone) > 0.01, "the axes are part of it"
    result = run_json(file, tmp_path, *LAYOUT)
    assert result["prediction"]["growth_per_s"] == pytest.approx(expected, rel=1e-9)
    turned = topic(result["log"], "side")["rz_manipulator_rad"]
    late = np.diff(turned[2 * len(turned) // 3:])
    half = len(late) // 2
    grown = np.log(np.std(late[half:]) / np.std(late[:half])) / (half * 2.5e-3)
    assert grown == pytest.approx(expected, rel=0.03)


@pytest.mark.slow
def test_the_report_shows_every_axis(tmp_path):
    log = run_json(rig_file(tmp_path, PLANAR_AXES, wrench_section()), tmp_path, *LAYOUT, "--set", "run.duration_s=2")["log"]
    command(ROOT / "scripts" / "report.py", log, program=(ROOT / ".venv" / "bin" / "python",))
    page = open(log.replace(".ulg", ".html")).read()
    for word in ("Pose: lateral translation", "Pose: rotation", "Lateral forces and torques", "rz, robot, as reported",
                 "y, command"):
        assert word in page, word
    assert "rx, command" not in page


def test_a_map_over_the_dead_time_moves_every_axis(tmp_path):
    words = ("--x", "robot.dead_time_ms=17.5:27.5:3", "--y", "sensor.stiffness_N_per_m=1e7:2e7:2", *LAYOUT)
    file = rig_file(tmp_path, PLANAR_AXES)
    found = one_json_object(command("map", file, "--json", *words, "--out", tmp_path).stdout)
    columns = np.genfromtxt(found["csv"], delimiter=",", names=True)
    at = np.flatnonzero((columns["robotdead_time_ms"] == 27.5) & (columns["sensorstiffness_N_per_m"] == 2e7))[0]
    later = PLANAR_AXES.replace("= 25.0", "= 35.0").replace("= 12.5", "= 22.5")
    there = command("eigen", rig_file(tmp_path, later, name="later"), "--json", *LAYOUT, "--set", "robot.dead_time_ms=27.5",
                    "--set", "sensor.stiffness_N_per_m=2e7")
    assert columns["spectral_radius"][at] == pytest.approx(one_json_object(there.stdout)["spectral_radius"], rel=1e-9)
    assert "moves the dead times of all axes" in found["moves"][0] and "along x alone" in found["moves"][1]
    said = command("map", file, *words, "--out", tmp_path).stdout.decode()
    assert all(line in said for line in found["moves"])
    alone = command("map", "ess", "--json", *words[:4], "--out", tmp_path)
    assert one_json_object(alone.stdout)["moves"] == []
