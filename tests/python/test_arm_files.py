"""Arm files and URDF: what is read is what is printed, and what is wrong is said with its line."""

import pytest
from conftest import EXIT_INPUT, ROOT, command


def test_arm_file_reads_back(tmp_path):
    text = command("arm", "ess").stdout.decode()
    file = tmp_path / "again.toml"
    file.write_text(text)
    assert command("arm", file).stdout.decode() == text


URDF = """<robot name="r"><link name="a"><inertial><mass value="{mass}"/>
<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="{izz}"/></inertial></link>
<link name="b"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
<joint name="j" type="{type}"><parent link="a"/><child link="{child}"/><axis xyz="{axis}"/></joint></robot>"""
GOOD = {"mass": "10", "izz": "1", "type": "continuous", "child": "b", "axis": "0 0 1"}


@pytest.mark.parametrize("change,line,says", [
    ({}, None, None),
    ({"izz": "3"}, 2, "no body has it"),
    ({"izz": "-1"}, 2, "no body has it"),
    ({"mass": "heavy"}, 1, "mass"),
    ({"mass": "1,5"}, 1, 'must be a number (is "1,5")'),
    ({"mass": "60 kg"}, 1, "must be a number"),
    ({"izz": "1e400"}, 2, "must be a number"),
    ({"mass": " +10.0 "}, None, None),
    ({"mass": "-1"}, 1, "must be 0 or more"),
    ({"type": "prismatic"}, 4, "revolute, continuous or fixed"),
    ({"type": "revolute"}, 4, "needs <limit>"),
    ({"child": "c"}, 4, 'there is no link "c"'),
    ({"child": "a"}, 4, "j"),
    ({"axis": "0 0 0"}, 4, "no direction"),
    ({"axis": "0 0"}, 4, "three numbers"),
    ({"mass": "0"}, 1, "no mass, and yet moments of inertia"),
    ({"axis": '0 0 1"/><mimic joint="k'}, 4, "<mimic>: of joint"),
])
def test_urdf_errors(tmp_path, change, line, says):
    file = tmp_path / "arm.urdf"
    file.write_text(URDF.format(**{**GOOD, **change}))
    done = command("arm", file)
    if says is None:
        assert done.returncode == 0, done.stderr.decode()
        return
    assert done.returncode == EXIT_INPUT
    assert says in done.stderr.decode()
    if change != {"child": "a"}:
        assert f"arm.urdf:{line}:" in done.stderr.decode()


def test_an_axis_that_no_planar_arm_has_is_refused_with_its_joint_and_line(tmp_path):
    file = tmp_path / "arm.urdf"
    file.write_text(URDF.format(**GOOD | {"axis": "1 0 0"}))
    done = command("arm", file, "--planar")
    assert done.returncode == EXIT_INPUT
    assert 'arm.urdf:4: <joint> "j": axis: of a planar arm must be [0, 0, 1]' in done.stderr.decode()


@pytest.mark.parametrize("name", ["two&#10;lines", "a/b", ".hidden"])
def test_a_urdf_name_that_cannot_name_an_arm_file_is_refused(tmp_path, name):
    file = tmp_path / "arm.urdf"
    file.write_text(URDF.format(**GOOD).replace('name="', f'name="{name}', 1))
    done = command("arm", file)
    assert done.returncode == EXIT_INPUT and done.stdout == b""
    assert "arm.urdf:1: <robot>" in done.stderr.decode() and "names files" in done.stderr.decode()


def test_a_urdf_that_is_not_utf_8_is_refused_where_it_is_not(tmp_path):
    file = tmp_path / "arm.urdf"
    file.write_bytes(("\n" + URDF.format(**GOOD)).encode().replace(b'name="', b'name="Gr\xfcn', 1))
    done = command("arm", file)
    assert done.returncode == EXIT_INPUT and done.stdout == b"" and b"arm.urdf:2: is not UTF-8" in done.stderr


@pytest.mark.parametrize("again,says", [
    ('<link name="b"/>', '<link> "b": there are two links "b"'),
    ('<link name="c"/><joint name="j" type="fixed"><parent link="b"/><child link="c"/></joint>',
     '<joint> "j": there are two joints "j"'),
])
def test_a_name_that_is_taken_is_refused(tmp_path, again, says):
    file = tmp_path / "arm.urdf"
    file.write_text(URDF.format(**GOOD).replace("</robot>", f"\n{again}</robot>"))
    done = command("arm", file)
    assert done.returncode == EXIT_INPUT and f"arm.urdf:5: {says}" in done.stderr.decode()


def test_urdf_in_the_place_of_an_arm_file_is_told_how_to_be_made_one(tmp_path):
    file = tmp_path / "arm.urdf"
    file.write_text("\n" + URDF.format(**GOOD))
    for words in (("run", "ess", "--no-log", "--set", f"manipulator.arm={file}"), ("accuracy", file),
                  ("reduce", "ess", "--arm", file)):
        done = command(*words)
        message = done.stderr.decode()
        assert done.returncode == EXIT_INPUT and f"{file}:2: is XML, as URDF is, and no arm file" in message, message
        assert "`berth arm ROBOT.urdf --tool LINK > ARM.toml`" in message
    made = command("arm", file, "--tool", "b")
    assert made.returncode == 0 and b"kind =" in made.stdout


@pytest.mark.parametrize("words", [("run",), ("eigen",), ("reduce",)])
def test_urdf_in_the_place_of_a_rig_is_told_what_it_takes(tmp_path, words):
    file = tmp_path / "arm.urdf"
    file.write_text(URDF.format(**GOOD))
    done = command(*words, file)
    message = done.stderr.decode()
    assert done.returncode == EXIT_INPUT and f"{file}:1: is XML, as URDF is, and no rig file" in message, message
    assert "`berth arm ROBOT.urdf --tool LINK > ARM.toml`" in message and "--set manipulator.arm=ARM.toml" in message


def test_an_arm_file_in_the_place_of_a_rig_is_told_where_it_goes(tmp_path):
    file = tmp_path / "arm.toml"
    file.write_bytes(command("arm", "ess").stdout)
    done = command("eigen", file)
    message = done.stderr.decode()
    assert done.returncode == EXIT_INPUT and "is an arm file, and no rig file" in message, message
    assert f"--set manipulator.arm={file}" in message


def test_turns_of_a_urdf_are_bounded(tmp_path):
    file = tmp_path / "arm.urdf"
    file.write_text(URDF.format(**GOOD).replace("</joint>", '<origin xyz="0 0 0" rpy="0 0 1e300"/></joint>'))
    done = command("arm", file)
    assert done.returncode == EXIT_INPUT
    assert "arm.urdf:4:" in done.stderr.decode() and "rpy: must be within 1e6 rad" in done.stderr.decode()


def test_joints_that_go_round_in_a_circle_are_refused(tmp_path):
    """Beside a sound arm, which would be read without a word."""
    hang = ('<link name="{0}"/><joint name="to_{0}" type="fixed"><parent link="{1}"/><child link="{0}"/></joint>')
    file = tmp_path / "arm.urdf"
    file.write_text(URDF.format(**GOOD).replace("</robot>", hang.format("c", "d") + hang.format("d", "c") + "</robot>"))
    done = command("arm", file, "--tool", "b")
    assert done.returncode == EXIT_INPUT and "round in a circle" in done.stderr.decode()


@pytest.mark.parametrize("limit,says", [
    ('lower="-1" upper="2" effort="5" velocity="1"', None),
    ('lower="-1 rad" upper="2"', 'lower: must be a number (is "-1 rad")'),
    ('lower="-1" upper="2" velocity="fast"', "velocity: must be a number"),
    ('lower="2" upper="-1"', "upper must be greater than lower"),
    ('lower="-1" upper="2" effort="-5"', "effort must not be negative; without it the joint has no such limit"),
    ('lower="-1" upper="2" velocity="-1"', "velocity must not be negative"),
])
def test_urdf_limits(tmp_path, limit, says):
    file = tmp_path / "arm.urdf"
    file.write_text(URDF.format(**{**GOOD, "type": "revolute"}).replace("</joint>", f"<limit {limit}/></joint>"))
    done = command("arm", file)
    if says is None:
        assert done.returncode == 0 and "angle_max_rad = 2\n" in done.stdout.decode()
    else:
        assert done.returncode == EXIT_INPUT and says in done.stderr.decode()
        assert "arm.urdf:4:" in done.stderr.decode()


def test_dynamics_of_a_urdf_are_said_to_be_left_out(tmp_path):
    file = tmp_path / "arm.urdf"
    for damping, is_told in (("", False), ('<dynamics damping="1.5"/>', True)):
        limits = '<limit lower="-1" upper="2"/>'
        file.write_text(URDF.format(**{**GOOD, "type": "revolute"}).replace("</joint>", f"{limits}{damping}</joint>"))
        done = command("arm", file)
        assert done.returncode == 0 and ("<dynamics> of its joints is left out" in done.stdout.decode()) == is_told


@pytest.mark.parametrize("old,new,says", [
    ('kind = "planar"', 'kind = "cubic"', "kind: must be one of"),
    ("axis = [0, 0, 1]", "axis = [0, 1, 0]", "joint.1 (shoulder).axis: "),
    ("mass_kg = 45.0", "mass_kg = -45.0", "joint.1.link (shoulder).mass_kg"),
    ("gear_ratio = 600", "gear_ratio = 0", "joint.1 (shoulder).gear_ratio"),
    ("gear_ratio = 500", "gear_ratio = 1e200", "joint.2 (elbow).gear_ratio: must be from 1e-3 to 1e6"),
    ("gear_ratio = 600", "gear_ratio = 1e-200", "joint.1 (shoulder).gear_ratio: must be from 1e-3 to 1e6"),
    ("rotor_inertia_kg_m2 = 2e-3", "rotor_inertia_kg_m2 = 1e200", "rotor_inertia_kg_m2: must be from 1e-12 to 1e9"),
    ("stiffness_N_m_per_rad = 68349.5994859", "stiffness_N_m_per_rad = 1e300", "must be from 1e-6 to 1e12"),
    ("servo_frequency_Hz = 8.0", "servo_frequency_Hz = 1e200", "must be from 1e-6 to 1e6"),
    ("servo_damping_ratio = 0.7", "servo_damping_ratio = 1e200", "must be from 1e-6 to 1e6"),
    ("torque_limit_N_m = 2000.0", "torque_limit_N_m = 1e-300", "must be from 1e-9 to 1e12"),
    ("mass_kg = 45.0", "mass_kg = 1e200", "joint.1.link (shoulder).mass_kg: must be 1e12 at most"),
    ("centre_m = [2.0, 0.0, 0.0]", "centre_m = [2e200, 0.0, 0.0]", "centre_m: must be 1e6 m away at most"),
    ("inertia_kg_m2 = [0, 0, 0, 0, 0, 3200.0]", "inertia_kg_m2 = [0, 0, 0, 0, 0, 1e200]", "must be 1e18 at most"),
    ("origin_m = [4.0, 0.0, 0.0]", "origin_m = [1e200, 0.0, 0.0]", "joint.2 (elbow).origin_m: must be 1e6 m away"),
    ("[tool]\norigin_m = [4.0, 0.0, 0.0]", "[tool]\norigin_m = [4.0, 1e200, 0.0]", "tool.origin_m: must be 1e6 m away"),
    ("stiffness_N_m_per_rad = 30.0", "stiffness_N_m_per_rad = 1e200", "attitude.stiffness_N_m_per_rad: must be 1e12 at"),
    ("stiffness_N_m_per_rad = 30.0", "stiffness_N_m_per_rad = inf", "attitude.stiffness_N_m_per_rad: must be 1e12 at"),
    ("momentum_limit_N_m_s = 500.0", "", "attitude.momentum_limit_N_m_s: is missing, or 0"),
    ("torque_limit_N_m = 20.0", "torque_limit_N_m = 0", "attitude.torque_limit_N_m: is missing, or 0"),
    ('actuator = "wheel"\nperiod_ticks = 1\nstiffness_N_m_per_rad = 30.0\ndamping_N_m_s_per_rad = 400.0\n'
     "torque_limit_N_m = 20.0", 'actuator = "thrusters"\ntorque_limit_N_m = inf',
     "attitude.torque_limit_N_m: must be finite"),
    ('name = "elbow"', "gear = 3", "joint.2.gear: unknown key"),
    ("gear_ratio = 600", "gear_ration = 600", "unknown key"),
    ("gear_ratio = 600", 'gear_ratio = "600"', "must be a number"),
    ("initial_rad = 1.35", "initial_rad = nan", "initial_rad"),
    ("initial_rad = 1.35", "initial_rad = 1e15", "initial_rad"),
    ("[base]", "[base]\nturn_rad = 1e300", "base.turn_rad: must be within 1e6 rad"),
    ("[base]", "[base]\nturn_rad = inf", "base.turn_rad: must be within 1e6 rad"),
    ("origin_m = [1.2, 0.6, 0.0]", "origin_m = [1.2, 0.6, 0.0]\nrpy_rad = [0, 0, 1e300]",
     "joint.1.rpy_rad: must be within 1e6 rad"),
    ("origin_m = [1.2, 0.6, 0.0]", "origin_m = [1.2, 0.6, 0.0]\nrpy_rad = [nan, 0, 0]",
     "joint.1.rpy_rad: must be within 1e6 rad"),
    ("[tool]", "[tool]\nrpy_rad = [0, 0, -1e300]", "tool.rpy_rad: must be within 1e6 rad"),
    ('name = "elbow"', 'name = "shoulder"', 'joint.2.name: there are two joints "shoulder"; each needs a name of its own'),
    ("period_ticks = 1", "period_ticks = 0", "attitude.period_ticks"),
    ("centre_m = [2.0, 0.0, 0.0]", "centre_m = [2.0, 0.0]", "must be 3 numbers"),
    ("mass_kg = 2200.0\n", "", "base.mass_kg: is missing, or 0, and yet there are moments of inertia"),
    ("mass_kg = 45.0\n", "mass_kg = 0\n", "joint.1.link (shoulder).mass_kg: is missing, or 0, and yet"),
])
def test_arm_file_errors(tmp_path, old, new, says):
    text = (ROOT / "sim_hal" / "arms" / "ess.toml").read_text()
    assert old in text
    file = tmp_path / "wrong.toml"
    file.write_text(text.replace(old, new, 1))
    done = command("arm", file)
    assert done.returncode == EXIT_INPUT
    assert says in done.stderr.decode() and "wrong.toml:" in done.stderr.decode()
