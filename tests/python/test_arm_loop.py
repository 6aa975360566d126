"""A whole arm in the loop: it grows as its eigenvalues say, replays bit for bit, and takes orders by frames."""

import json
import re
import tomllib

import numpy as np
import pytest
from conftest import (EXIT_DIFFERENT, EXIT_INPUT, RIG_FOLDER, command, data_id, one_json_object, patched, record_type,
                      replay_json, run_json, topic, ulog_messages, without_checksums)

ARM_TOPIC = 4
ARM = ("--set", "manipulator.arm=ess")
BERTHING = RIG_FOLDER / "ess-berthing.toml"


def eigen(*settings):
    return one_json_object(command("eigen", "ess", "--json", *ARM, *settings).stdout)


@pytest.mark.long
@pytest.mark.parametrize("dead_time_ms,duration_s", [(17.5, 300), (30.0, 250), (60.0, 120)])
def test_it_grows_as_its_eigenvalues_say(tmp_path, dead_time_ms, duration_s):
    settings = ("--set", f"robot.dead_time_ms={dead_time_ms}")
    expected = eigen(*settings)["growth_per_s"]
    assert expected > 0.0, "the reduced model is stable here: what is looked at is what it leaves out"
    result = run_json("ess", tmp_path, *ARM, *settings, "--set", f"run.duration_s={duration_s}",
                      "--set", "manipulator.initial_position_m=0", "--set", "profile.kind=minimum_jerk",
                      "--set", "profile.amplitude_m=0.001", "--set", "profile.duration_s=1")
    assert result["prediction"]["growth_per_s"] == pytest.approx(expected, rel=1e-9)
    assert growth_in(result, 2.5e-3) == pytest.approx(expected, rel=0.03)


@pytest.mark.parametrize("rig", ["ess-pose", "ess-berthing"])
def test_its_limits_are_where_its_eigenvalues_leave_the_circle(rig):
    told = one_json_object(command("limits", rig, "--json").stdout)
    checked = one_json_object(command("check", rig, "--json").stdout)
    assert told["stable"] is checked["stable"]
    assert told["margin"] == checked["margin"]
    moved_alone = set(told["parameters"]) - ({"robot.dead_time_ms"} if rig == "ess-pose" else set())  # six axes have it
    limits = [(key, side, told["parameters"][key][side]) for key in sorted(moved_alone) for side in ("below", "above")
              if told["parameters"][key][side] is not None]
    assert limits
    for key, side, value in limits:
        stable = [one_json_object(command("eigen", rig, "--json", "--set", f"{key}={value * by!r}").stdout)["stable"]
                  for by in (1 - 2e-3, 1 + 2e-3)]
        assert stable == [told["stable"] is not (side == "below"), told["stable"] is (side == "below")], (key, side)


def growth_in(result, period_s):
    """Of the second half of a run."""
    position_m = topic(result["log"])["manipulator_position_m"]
    late = position_m[len(position_m) // 2:]
    half = len(late) // 2
    return np.log(np.std(late[half:]) / np.std(late[:half])) / (half * period_s)


@pytest.mark.parametrize("integrator,substeps,force", [
    ("semi_implicit_euler", 1, "held"), ("semi_implicit_euler", 3, "held"), ("semi_implicit_euler", 1, "led"),
    ("rk4", 1, "led"), ("implicit_midpoint", 1, "led"), ("implicit_midpoint", 1, "held")])
def test_in_coarse_steps_it_grows_as_the_eigenvalues_of_its_integrator_say(tmp_path, integrator, substeps, force):
    """At 100 Hz the semi-implicit steps, which know half a step of the future, take an eighth off the growth."""
    text = (RIG_FOLDER.parent / "arms" / "ess.toml").read_text()
    arm = tmp_path / "arm.toml"
    arm.write_text(text.replace('integrator = "implicit_midpoint"',
                                f'integrator = "{integrator}"\nforce = "{force}"\nsubsteps = {substeps}'))
    words = ("--set", f"manipulator.arm={arm}", "--set", "loop.rate_Hz=100", "--set", "robot.dead_time_ms=40")
    expected = one_json_object(command("eigen", "ess", "--json", *words).stdout)["growth_per_s"]
    result = run_json("ess", tmp_path, *words, "--set", "run.duration_s=200", "--set", "manipulator.initial_position_m=0",
                      "--set", "profile.kind=minimum_jerk", "--set", "profile.amplitude_m=1e-5", "--set", "profile.duration_s=1")
    assert growth_in(result, 0.01) == pytest.approx(expected, rel=0.01)


def test_growth_is_measured_between_orders(tmp_path):
    """Orders and the grip move the arm too: only what follows the last of them is free to grow by itself."""
    run = run_json(BERTHING, tmp_path)
    told = one_json_object(command("summary", run["log"], "--json").stdout)
    assert 46.1 <= told["envelope"]["time_s"][0] < told["envelope"]["fit_from_s"]
    assert told["growth_per_s"] == run["growth_per_s"]
    assert run["growth_per_s"] == pytest.approx(run["prediction"]["growth_per_s"], rel=0.15), "a moved arm's: 0.3 m off"


def test_of_an_arm_nobody_knows_whether_the_loop_makes_energy(tmp_path):
    """What its joints took by damping is in what they gave."""
    result = run_json("ess", tmp_path, *ARM, "--set", "run.duration_s=5")
    assert result["energy"]["gains"] is None and result["energy"]["dead_time_J"] != 0.0


@pytest.mark.parametrize("duration_s, limits_act", [(70, False), (80, True)])
def test_growth_is_that_of_the_gripped_object(tmp_path, duration_s, limits_act):
    """A minute of the manipulator's own decay, then the grip, and what blows up."""
    late = run_json("ess", tmp_path, *(word for setting in (
        "manipulator.initial_position_m=0", "run.grip_close_s=60", f"run.duration_s={duration_s}", "object.mass_kg=198",
        "profile.kind=minimum_jerk", "profile.amplitude_m=0.05", "profile.duration_s=2") for word in ("--set", setting)))
    assert late["prediction"]["growth_per_s"] > 1.0
    assert late["stable"] is False and late["growth_per_s"] is None
    assert any(late["limit_ticks"].values()) == limits_act


def test_a_recorded_arm_is_compared_too(tmp_path):
    log = run_json(BERTHING, tmp_path, "--set", "run.duration_s=3")["log"]
    assert replay_json(log)["equal"]
    data = without_checksums(open(log, "rb").read())
    arms = [message for message in ulog_messages(data) if data_id(message) == ARM_TOPIC]
    assert len(arms) == 1200
    changed = tmp_path / "changed.ulg"
    changed.write_bytes(patched(data, arms[321], record_type(data, "arm"), "motor_1_rad",
                                lambda value: np.nextafter(value, 9.0)))
    difference = replay_json(changed, EXIT_DIFFERENT)["first_difference"]
    assert (difference["tick"], difference["field"]) == (321, "arm motor_1_rad")


@pytest.mark.long
def test_orders_lead_the_tool_and_the_satellite_answers(logs):
    result, log = logs(BERTHING)
    assert result["frames_rejected"] == 0
    arm, tick = topic(log, "arm"), topic(log)
    at = lambda seconds: int(round(seconds * 400))  # noqa: E731
    # The line of 0.3 m is that of the tool seen from the base, but for joints that still swing a little.
    turn = arm["base_turn_rad"]
    in_base_x = np.cos(turn) * (arm["tool_x_m"] - arm["base_x_m"]) + np.sin(turn) * (arm["tool_y_m"] - arm["base_y_m"])
    in_base_y = -np.sin(turn) * (arm["tool_x_m"] - arm["base_x_m"]) + np.cos(turn) * (arm["tool_y_m"] - arm["base_y_m"])
    assert in_base_x[at(19)] - in_base_x[0] == pytest.approx(0.3, abs=5e-4)
    assert in_base_y[at(19)] - in_base_y[0] == pytest.approx(0.0, abs=5e-4)
    # Nothing is felt before the grip, and something after it.
    assert np.all(tick["force_N"][:at(20)] == 0.0)
    assert np.abs(tick["force_N"][at(21):]).max() > 1.0
    # Centre of mass of all: it stays, from the bodies' own places, until the object is gripped.
    assert np.abs(arm["base_x_m"][at(19)]) > 0.01
    assert np.abs(arm["wheel_z_N_m_s"]).max() > 0.1
    assert set(np.unique(arm["order"])) == {0, 1, 3}
    # The joint's rate, after it has come to it.
    rate = (arm["motor_1_rad"][at(43)] - arm["motor_1_rad"][at(41)]) / 2.0
    assert rate == pytest.approx(-0.001, rel=0.05)


def test_the_resolved_rig_reads_back(tmp_path):
    text = command("run", BERTHING, "--print-config").stdout.decode()
    again = tmp_path / "again.toml"
    again.write_text(text)
    assert "[manipulator.arm]" in text and "[[orders]]" in text
    assert command("run", again, "--print-config").stdout.decode() == text


def with_range(folder, joint_range, order):
    """A satellite's arm whose first joint has ends, with one order after three harmless ones."""
    arm = (RIG_FOLDER.parent / "arms" / "ess.toml").read_text()
    assert arm.count("[[joint]]") == 2
    before, first, second = arm.split("[[joint]]")
    least, most = joint_range
    (folder / "ends.toml").write_text(f"{before}[[joint]]\nangle_min_rad = {least}\nangle_max_rad = {most}{first}[[joint]]{second}")
    text = BERTHING.read_text()
    text = text[:text.index("[[orders]]")].replace('arm = "ess"', f'arm = "{folder}/ends.toml"')
    for at_s in (1, 2, 3):
        text += f"[[orders]]\nat_s = {at_s}\njoint = 2\nrate_rad_per_s = 0.001\n"
    file = folder / "ends-rig.toml"
    file.write_text(f"{text}[[orders]]\nat_s = 4\n{order}\n")
    return file


@pytest.mark.parametrize("end_rad", [0.9, 0.8, 1.1, 1.0])  # as the wire has them, three are below themselves
def test_a_move_to_the_end_of_a_joints_range_is_carried_out(tmp_path, end_rad):
    rig = with_range(tmp_path, (end_rad, 1.6), f"joint = 1\nmove_to_rad = {end_rad}")
    found = run_json(rig, tmp_path, "--set", "run.duration_s=20", "--set", "run.grip_close_s=19",
                     "--set", "limits.position_min_m=-5.3", "--set", "limits.position_max_m=5.3",
                     "--set", "limits.velocity_m_per_s=5", "--set", "limits.acceleration_m_per_s2=100")
    at_end = topic(found["log"], "arm")["motor_0_rad"][7000]  # 17.5 s
    assert found["frames_rejected"] == 0
    assert at_end == pytest.approx(end_rad, abs=1e-3)


def test_a_move_beyond_a_joints_range_is_refused_with_the_orders_line_and_the_range(tmp_path):
    rig = with_range(tmp_path, (0.9, 1.6), "joint = 1\nmove_to_rad = 1.7")
    line = rig.read_text()[:rig.read_text().index("at_s = 4")].count("\n")
    done = command("run", rig, "--no-log")
    assert done.returncode == EXIT_INPUT
    assert (f"ends-rig.toml:{line}: orders.move_to_rad: must be an angle that joint 1 can have, from 0.9 to 1.6 rad (is 1.7)"
            in done.stderr.decode())


@pytest.mark.parametrize("rig", ["concept-foam", "concept-copper"])
def test_of_a_satellite_that_drives_off_it_says_when_it_left(rig, tmp_path):
    """From the force: what rings in the sensor's own spring afterwards is a hundredth of the push."""
    log = run_json(rig, tmp_path, *ARM)["log"]
    tick = topic(log)
    pushed = np.nonzero(tick["force_N"] > 0.05 * tick["force_N"].max())[0]
    shown = command("summary", log).stdout.decode()
    words = re.search(r"(?:bouncing|unstable) .*; the tool touched the object for (.*) s, left it at (.*) s and did not", shown)
    assert words, shown
    last = np.split(pushed, np.nonzero(np.diff(pushed) > 1)[0] + 1)[-1]  # copper throws the tool back once
    assert float(words[2]) == pytest.approx(2.5e-3 * last[-1], abs=0.2)
    assert float(words[1]) == pytest.approx(2.5e-3 * len(last), rel=0.3)


def test_what_was_never_touched_has_no_loop(tmp_path):
    words = ("--set", "object.surface_position_m=1")
    told = run_json("concept-foam", tmp_path, *words)
    assert told["stable"] is None and told["growth_per_s"] is None
    shown = command("run", "concept-foam", "--no-log", *words).stdout.decode()
    assert "undetermined   it ran for 19.90 s, but the tool never came to the object: there was no loop" in shown


def test_orders_after_the_end_of_the_run_are_told(tmp_path):
    at_s = [order["at_s"] for order in tomllib.loads(BERTHING.read_text())["orders"]]
    for duration_s, words in ((70, ("--no-log",)), (10, ("--no-log",)), (10, ("--no-log", "--json"))):
        done = command("run", BERTHING, *words, "--set", f"run.duration_s={duration_s}")
        told = done.stderr.decode().splitlines()
        late = [time for time in at_s if time + 0.1 >= duration_s]
        assert len(late) == (0 if duration_s == 70 else len(at_s) - 1) and done.returncode == 0
        assert told == [f"berth: ess-berthing: orders.at_s = {time:g}: is after the run's end, at {duration_s - 0.1:g} s "
                        "from run.release_s on, and never given; run.duration_s makes it longer" for time in late]


def test_an_amplitude_changes_nothing_where_nothing_is_of_size():
    done = command("eigen", "ess", "--amplitude", "0.01", *ARM)
    assert done.returncode == 0 and b"unstable" in done.stdout, done.stderr.decode()


def test_the_map_is_the_whole_arm_s_and_tells_how_far_its_reduction_misleads(tmp_path):
    done = one_json_object(command("map", "ess", "--json", *ARM, "--vary", "elasticity", "--grid", "31x21",
                                   "--out", tmp_path).stdout)
    columns = np.genfromtxt(done["csv"], delimiter=",", names=True)
    possible = ~np.isnan(columns["spectral_radius"])
    whole, reduced = columns["spectral_radius"][possible], columns["spectral_radius_reduced"][possible]
    assert done["reduced"]["falsely_stable_share"] == pytest.approx(np.mean((whole >= 1) & (reduced < 1)))
    assert done["reduced"]["falsely_unstable_share"] == pytest.approx(np.mean((whole < 1) & (reduced >= 1)))
    assert done["reduced"]["falsely_unstable_share"] > 0
    assert done["own"]["spectral_radius"] == pytest.approx(eigen()["spectral_radius"], rel=1e-12)
    # A point of the map by itself, from eigen.
    at = np.flatnonzero(possible)[len(whole) // 2]
    ratio, zeta = columns["omega_per_omega_M"][at], columns["zeta"][at]
    stiffness = ratio ** 2 * 7895.683520871487 / 200 * 300 - 7895.683520871487
    damping = 2 * zeta * ratio * np.sqrt(7895.683520871487 / 200) * 300 - 125.66370614359172
    there = ("--set", f"object.stiffness_N_per_m={float(stiffness)!r}",
             "--set", f"object.damping_N_s_per_m={float(damping)!r}")
    assert eigen(*there)["spectral_radius"] == pytest.approx(columns["spectral_radius"][at], rel=1e-9)
    # The same object at what `reduce` makes of the arm, not at the manipulator of the rig file.
    reduced = one_json_object(command("reduce", "ess", "--json", *ARM).stdout)["poses"][0]["reduced"]
    own = [word for key in ("mass_kg", "damping_N_s_per_m", "stiffness_N_per_m")
           for word in ("--set", f"manipulator.{key}={reduced[key]!r}")]
    alone = one_json_object(command("eigen", "ess", "--json", *own, *there).stdout)
    assert alone["spectral_radius"] == pytest.approx(columns["spectral_radius_reduced"][at], rel=1e-9)


def test_an_arm_that_starts_stretched_is_refused(tmp_path):
    arm = (RIG_FOLDER.parent / "arms" / "ess.toml").read_text().replace("initial_rad = -1.7", "initial_rad = 0.0")
    (tmp_path / "stretched.toml").write_text(arm)
    done = command("run", "ess", "--no-log", "--set", f"manipulator.arm={tmp_path / 'stretched.toml'}")
    assert done.returncode == EXIT_INPUT and "singular" in done.stderr.decode()


@pytest.mark.parametrize("integrator, stiffness, refused", [
    ("rk4", 1e9, True), ("rk4", 1e6, False), ("semi_implicit_euler", 1e9, True), ("semi_implicit_euler", 1e6, False),
    ("implicit_midpoint", 1e9, False),
])
def test_steps_that_blow_up_by_themselves_are_refused(tmp_path, integrator, stiffness, refused):
    """And only those: what is taken comes to the end of its run."""
    arm = (RIG_FOLDER.parent / "arms" / "ess.toml").read_text()
    lines = [line if "stiffness_N_m_per_rad" not in line else f"stiffness_N_m_per_rad = {stiffness}"
             for line in arm.splitlines() if not line.startswith("integrator")]
    lines.insert(next(i for i, line in enumerate(lines) if line.startswith("[")), f'integrator = "{integrator}"')
    (tmp_path / "arm.toml").write_text("\n".join(lines) + "\n")
    done = command("run", "ess", "--no-log", "--json", "--set", f"manipulator.arm={tmp_path / 'arm.toml'}",
                   "--set", "run.duration_s=2")
    assert done.returncode == (EXIT_INPUT if refused else 0), done.stderr.decode()
    if refused:
        assert "too fast for integrator" in done.stderr.decode()
    else:
        assert one_json_object(done.stdout)["state"] == "running"


def test_gravity_leaves_no_rest_to_linearise_about(tmp_path):
    arm = tmp_path / "heavy.toml"
    text = (RIG_FOLDER.parent / "arms" / "ess.toml").read_text()
    arm.write_text(text.replace("is_free = true", "is_free = true\ngravity_m_per_s2 = [0, -1e-3, 0]"))
    heavy = ("--set", f"manipulator.arm={arm}")
    for words in (("eigen", "ess", *heavy), ("reduce", "ess", *heavy)):
        done = command(*words)
        assert done.returncode == EXIT_INPUT and b"base.gravity_m_per_s2" in done.stderr, done.stderr.decode()
    assert run_json("ess", tmp_path, *heavy, "--set", "run.duration_s=2")["prediction"]["growth_per_s"] is None


def with_thrusters(tmp_path):
    text = (RIG_FOLDER.parent / "arms" / "ess.toml").read_text()
    arm = tmp_path / "thrusters.toml"
    arm.write_text(text.split("[attitude]")[0] + """[attitude]
actuator = "thrusters"
torque_limit_N_m = 20.0
deadband_rad = 0.01
rate_weight_s = 5.0
on_time_min_ms = 100.0
""")
    return "--set", f"manipulator.arm={arm}"


def test_thrusters_are_left_out_and_it_is_said(tmp_path):
    arm = with_thrusters(tmp_path)
    grid = ("--vary", "elasticity", "--grid", "3x2", "--out", tmp_path)
    for words in (("eigen", "ess"), ("reduce", "ess"), ("map", "ess", *grid)):
        done = command(*words, *arm)
        assert done.returncode == 0 and b"thrusters have no linearisation and are left out" in done.stderr, words
        assert any("thrusters" in line for line in one_json_object(command(*words, *arm, "--json").stdout)["left_out"])
        plain = command(*words, *ARM, "--json")
        assert plain.stderr == b"" and one_json_object(plain.stdout)["left_out"] == []
    run = command("run", "ess", *arm, "--no-log", "--set", "run.duration_s=2").stdout.decode()
    assert "thrusters have no linearisation and are left out" in run
    told = run_json("ess", tmp_path, *arm, "--set", "run.duration_s=2")
    assert told["prediction"]["growth_per_s"] is not None and "thrusters" in told["prediction_left_out"][0]
    assert run_json("ess", tmp_path, *ARM, "--set", "run.duration_s=2")["prediction_left_out"] == []


def test_a_wheel_whose_torque_is_held_is_taken_for_one_that_is_not_and_it_is_said(tmp_path):
    arm = tmp_path / "slow.toml"
    text = (RIG_FOLDER.parent / "arms" / "ess.toml").read_text()
    assert text.count("period_ticks = 1") == 1
    arm.write_text(text.replace("period_ticks = 1", "period_ticks = 400"))
    for command_name in ("eigen", "reduce"):
        done = command(command_name, "ess", "--set", f"manipulator.arm={arm}", "--json")
        [line] = one_json_object(done.stdout)["left_out"]
        assert "attitude.period_ticks" in line and "400 ticks" in line and line in done.stderr.decode()
    told = run_json("ess", tmp_path, "--set", f"manipulator.arm={arm}", "--set", "run.duration_s=2")
    assert "400 ticks" in told["prediction_left_out"][0]


def strong_wheel(folder, stiffness_N_m_per_rad, damping_N_m_s_per_rad):
    text = (RIG_FOLDER.parent / "arms" / "ess.toml").read_text()
    for key, value in {"stiffness_N_m_per_rad = 30.0": stiffness_N_m_per_rad,
                       "damping_N_m_s_per_rad = 400.0": damping_N_m_s_per_rad,
                       "torque_limit_N_m = 20.0": "inf", "momentum_limit_N_m_s = 500.0": "inf"}.items():
        assert text.count(f"\n{key}\n") == 1
        text = text.replace(f"\n{key}\n", f"\n{key.split(' = ')[0]} = {value}\n")
    file = folder / "strong.toml"
    file.write_text(text)
    return "--set", f"manipulator.arm={file}"


@pytest.mark.parametrize("rig,stiffness,damping,is_said", [
    ("ess-50hz", 1e6, 5000, True),     # T/2 of 10 ms: the hold takes twice its damping
    ("ess-50hz", 1e4, 5000, True),     # 2 %
    ("ess-50hz", 2.9e3, 3000, False),   # 0.97 %, and 30 N m s^2 of the other
    ("ess", 3.9e4, 5000, False),       # 1 % of 400 Hz
    ("ess", 1e5, 5000, True),
    ("ess-50hz", 30, 4e4, True),       # D T/2 of 400 N m s^2 beside 3200 kg m^2
    ("ess-50hz", 30, 400, False),      # as shipped
    ("ess-50hz", 30, 0, True),
    ("ess-50hz", 0, 0, False),
])
def test_a_wheel_whose_hold_of_one_tick_matters_is_named_where_there_are_no_ticks(tmp_path, rig, stiffness, damping,
                                                                                  is_said):
    """The modes that `reduce` tells are of an arm by itself; the loop's eigenvalues hold the wheel as the firmware."""
    words = strong_wheel(tmp_path, stiffness, damping)
    done = command("reduce", rig, *words, "--json")
    lines = one_json_object(done.stdout)["left_out"]
    assert any("attitude.period_ticks" in line and "held for 1 tick;" in line for line in lines) == is_said
    assert (b"attitude.period_ticks" in done.stderr) == is_said
    assert one_json_object(command("eigen", rig, *words, "--json").stdout)["left_out"] == []
    assert not run_json(rig, tmp_path, *words, "--set", "run.duration_s=2")["prediction_left_out"]


def test_a_held_wheel_makes_a_satellite_swing_as_its_eigenvalues_say(tmp_path):
    """Its torque is half a tick late in the mean: 10 ms, which takes more than the wheel's own damping."""
    words = strong_wheel(tmp_path, 4e4, 100)
    expected = one_json_object(command("eigen", "ess-50hz", *words, "--json").stdout)["growth_per_s"]
    assert expected > 0.01
    result = run_json("ess-50hz", tmp_path, *words, "--set", "run.duration_s=150", "--set", "manipulator.initial_position_m=0",
                      "--set", "profile.kind=minimum_jerk", "--set", "profile.amplitude_m=0.0001", "--set", "profile.duration_s=1")
    assert growth_in(result, 0.02) == pytest.approx(expected, rel=0.03)


def stiffnesses_of_the_planar_arm(arm, jacobian, mass):
    """M, D, K over turn and way of the base, links, motors, as Spong's elastic joints have them; no code of berth's
    but for the inertia of rigid links, which Pinocchio and MuJoCo agree with."""
    inertia, damping, stiffness = (np.zeros((7, 7)) for _ in range(3))
    inertia[:5, :5] = mass
    damping[0, 0] = arm["attitude"]["damping_N_m_s_per_rad"]
    stiffness[0, 0] = arm["attitude"]["stiffness_N_m_per_rad"]
    for i, joint in enumerate(arm["joint"]):
        link, motor = 3 + i, 5 + i
        rotor = joint["rotor_inertia_kg_m2"] * joint["gear_ratio"] ** 2
        servo = 2 * np.pi * joint["servo_frequency_Hz"]
        inertia[motor, motor] = rotor
        between = np.eye(7)[link] - np.eye(7)[motor]
        stiffness += joint["stiffness_N_m_per_rad"] * np.outer(between, between)
        damping += joint["damping_N_m_s_per_rad"] * np.outer(between, between)
        stiffness[motor, motor] += rotor * servo ** 2
        damping[motor, motor] += 2 * joint["servo_damping_ratio"] * servo * rotor
    way = np.append(jacobian, (0.0, 0.0))
    return inertia, damping, stiffness, way


@pytest.mark.parametrize("with_object", [False, True])
def test_the_arm_that_eigen_tells_without_a_loop_is_the_whole_arm(tmp_path, with_object):
    file = RIG_FOLDER.parent / "arms" / "ess.toml"
    arm = tomllib.loads(file.read_text())
    states = tmp_path / "states.json"
    states.write_text(json.dumps([{"link_rad": [joint["initial_rad"] for joint in arm["joint"]]}]))
    [at] = json.loads(command("arm", file, "--states", states).stdout)
    inertia, damping, stiffness, way = stiffnesses_of_the_planar_arm(arm, at["jacobian"][1], np.array(at["inertia"]))
    if with_object:
        rig = tomllib.loads((RIG_FOLDER / "ess.toml").read_text())["object"]
        square = np.outer(way, way)
        inertia += rig["mass_kg"] * square
        damping += rig["damping_N_s_per_m"] * square
        stiffness += rig["stiffness_N_per_m"] * square
    first_order = np.block([[np.zeros((7, 7)), np.eye(7)], [-np.linalg.solve(inertia, stiffness),
                                                            -np.linalg.solve(inertia, damping)]])
    expected = np.linalg.eigvals(first_order)
    expected = np.sort_complex(np.exp(2.5e-3 * expected[np.abs(expected) > 1e-3]))
    told = np.sort_complex([complex(*z) for z in eigen()["coupled" if with_object else "manipulator"]["eigenvalues"]])
    assert told == pytest.approx(expected, rel=1e-9)


def test_slow_modes_count_at_every_rate():
    """A free satellite's own motion is left out, a mode of 0.0103 Hz is not, however short the period."""
    growth_per_s = [one_json_object(command("eigen", "ess-pose", "--set", f"loop.rate_Hz={rate_Hz}", "--json").stdout)
                    ["growth_per_s"] for rate_Hz in (400, 800, 1000)]
    assert growth_per_s == pytest.approx([growth_per_s[0]] * 3, rel=2e-3)
