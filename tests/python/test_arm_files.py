"""Arm files and URDF: what is read is what is printed, and one in the place of the other is told so. Mistakes in them:
bad_input/test_edited_files.py."""

import re

import pytest
from conftest import EXIT_INPUT, command


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


@pytest.mark.parametrize("change", [{}, {"mass": " +10.0 "}])
def test_urdf_is_read(tmp_path, change):
    file = tmp_path / "arm.urdf"
    file.write_text(URDF.format(**{**GOOD, **change}))
    done = command("arm", file)
    assert done.returncode == 0, done.stderr.decode()


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


def test_urdf_limits(tmp_path):
    file = tmp_path / "arm.urdf"
    limit = '<limit lower="-1" upper="2" effort="5" velocity="1"/>'
    file.write_text(URDF.format(**{**GOOD, "type": "revolute"}).replace("</joint>", f"{limit}</joint>"))
    done = command("arm", file)
    assert done.returncode == 0 and re.search(r"^angle_max_rad = 2 ", done.stdout.decode(), re.M)


def test_dynamics_of_a_urdf_are_said_to_be_left_out(tmp_path):
    file = tmp_path / "arm.urdf"
    for damping, is_told in (("", False), ('<dynamics damping="1.5"/>', True)):
        limits = '<limit lower="-1" upper="2"/>'
        file.write_text(URDF.format(**{**GOOD, "type": "revolute"}).replace("</joint>", f"{limits}{damping}</joint>"))
        done = command("arm", file)
        assert done.returncode == 0 and ("<dynamics> of its joints is left out" in done.stdout.decode()) == is_told
