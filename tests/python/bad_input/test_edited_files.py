"""Files with a mistake in them: one line that names the file, the line and the key, and says what it must be.

A row is a change of a good file (old text, new text) and words of the message.
"""

import gzip

from conftest import RIG_FOLDER, ROOT
from refusals import Bad, each

ESS = (RIG_FOLDER / "ess.toml").read_text()

# --- rig files ----------------------------------------------------------------------------------------------------
# name: (text to replace, its replacement, what the message must say); the place is that of the replacement.
FILES = {
    "unknown key": ("dead_time_ms = 17.5", "ded_time_ms = 17.5",
                    ["robot.ded_time_ms", "unknown key", "robot.dead_time_ms"]),
    "key without its unit": ("dead_time_ms = 17.5", "dead_time = 17.5", ["robot.dead_time", "robot.dead_time_ms"]),
    "key with another unit": ("dead_time_ms = 17.5", "dead_time_s = 0.0175",
                              ["robot.dead_time_s", "robot.dead_time_ms"]),
    "unknown section": ("[robot]", "[robbot]", ["robbot", "unknown section", "[robot]"]),
    "unknown empty section": ("[loop]", "[lop]\n[loop]", ["lop", "unknown section", "loop"]),
    "key outside sections": ("[run]", "rate_Hz = 400\n[run]", ["rate_Hz", "loop.rate_Hz"]),
    "negative mass": ("mass_kg = 200.0", "mass_kg = -200.0", ["manipulator.mass_kg", "greater than 0", "-200"]),
    "no mass": ("mass_kg = 100.0", "mass_kg = 0", ["object.mass_kg", "greater than 0"]),
    "nan": ("mass_kg = 200.0", "mass_kg = nan", ["manipulator.mass_kg", "finite", "nan"]),
    "inf": ("mass_kg = 200.0", "mass_kg = inf", ["manipulator.mass_kg", "finite", "inf"]),
    "-inf": ("initial_position_m = 0.01", "initial_position_m = -inf", ["manipulator.initial_position_m", "finite"]),
    "infinite duration": ("duration_s = 60.0", "duration_s = inf", ["run.duration_s", "finite"]),
    "too large a number": ("mass_kg = 200.0", "mass_kg = 1e999", []),
    "text for a number": ("mass_kg = 200.0", 'mass_kg = "heavy"', ["manipulator.mass_kg", "a number", "heavy"]),
    "boolean for a number": ("mass_kg = 200.0", "mass_kg = true", ["manipulator.mass_kg", "a number", "true"]),
    "list for a number": ("mass_kg = 200.0", "mass_kg = [1, 2]", ["manipulator.mass_kg", "a number"]),
    "table for a number": ("mass_kg = 200.0", "mass_kg = {a = 1}", ["manipulator.mass_kg", "a number"]),
    "date for a number": ("mass_kg = 200.0", "mass_kg = 2001-01-01", ["manipulator.mass_kg", "a number"]),
    "number for a word": ('interpolation = "linear"', "interpolation = 3", ["robot.interpolation", "quotes"]),
    "unknown word": ('interpolation = "linear"', 'interpolation = "cubic"',
                     ["robot.interpolation", '"linear"', '"hold"', "cubic"]),
    "number for a boolean": ("[robot]", "[bus]\nideal = 1\n[robot]", ["bus.ideal", "true or false"]),
    "fraction for a whole number": ("low_pass_order = 2", "low_pass_order = 1.5",
                                    ["sensor.low_pass_order", "whole"]),
    "probability above 1": ("[robot]", "[bus]\nloss_probability = 1.5\n[robot]", ["bus.loss_probability", "0 to 1"]),
    "rate that does not divide": ("rate_Hz = 400", "rate_Hz = 399", ["loop.rate_Hz", "320", "400"]),
    "rate of 0": ("rate_Hz = 400", "rate_Hz = 0", ["loop.rate_Hz", "greater than 0"]),
    "rate beyond any loop": ("rate_Hz = 400", "rate_Hz = 2000000", ["loop.rate_Hz", "1000000"]),
    "linear dead time below a tick": ("dead_time_ms = 17.5", "dead_time_ms = 2.4",
                                      ["robot.dead_time_ms", "one period", "linear", "hold"]),
    "delay below the time on the bus": ("delay_ms = 2.5", "delay_ms = 0.05", ["sensor.delay_ms", "bus.ideal"]),
    "sensor order": ("low_pass_order = 2", "low_pass_order = 3", ["sensor.low_pass_order", "0, 1 or 2"]),
    "start outside the limits": ("initial_position_m = 0.01", "initial_position_m = 7.0",
                                 ["manipulator.initial_position_m", "limits.position_max_m"]),
    "profile without a file": ("[robot]", '[profile]\nkind = "file"\n[robot]', ["profile.file", "missing"]),
    "filter without a robot to invert": ("[robot]", "[inverse_filter]\nenabled = true\n[robot]",
                                         ["inverse_filter.enabled", "robot.transfer_frequency_Hz"]),
    "more ticks than a run may have": ("duration_s = 60.0", "duration_s = 1e9", ["run.duration_s", "ticks"]),
    "name that leaves the folder": ('name = "ess"', 'name = "../ess"', ["name"]),
    "name with a line break": ('name = "ess"', 'name = "e\\nss"', ["name"]),
    "name of the wrong type": ('name = "ess"', "name = 3", ["name", "quotes"]),
    "description too long for a log": ("Solar generator", "Solar generator" * 500, ["description", "2000"]),
    "syntax error": ("dead_time_ms = 17.5", "dead_time_ms = = 17.5", []),
    "letter outside ASCII in a key": ("dead_time_ms = 17.5", "dead_time_m\u00e9 = 17.5", ["\u00e9", "letters a to z"]),
    "open bracket": ("[robot]", "[robot", []),
    "bracket alone": ("[robot]", "[\n[robot]", ["syntax"]),
    "open quotes": ('interpolation = "linear"', 'interpolation = "linear', []),
    "duplicate key": ("dead_time_ms = 17.5", "dead_time_ms = 17.5\ndead_time_ms = 20.0", ["dead_time_ms"]),
    "duplicate section": ("[object]", "[robot]\n[object]", ["robot"]),
}
# Where the error is noticed in a later line than the one that was changed.
LINES_LATER = {"key outside sections": 0, "number for a boolean": 1, "probability above 1": 1,
               "filter without a robot to invert": 1, "duplicate key": 1, "duplicate section": 12,
               "bracket alone": 22}
NO_LINE = {"profile without a file"}  # the key that is wrong is not there


def changed(text, old, new):
    assert old in text
    return text.replace(old, new, 1)


def line_of(text, part):
    """Number of the first line that contains `part`."""
    return next(i for i, line in enumerate(text.splitlines(), 1) if part in line)


def of_rig_file(name, old, new, says):
    text = changed(ESS, old, new)
    line = line_of(text, new.split("\n")[0]) + LINES_LATER.get(name, 0)
    place = "berth: {bad.toml}" + (" (default value)" if name in NO_LINE else f":{line}") + ": "
    return Bad(f"rig: {name}", ["run", "{bad.toml}", "--json", "--out", "{out}"], *says, files={"bad.toml": text},
               starts=place, also=[["run", "{bad.toml}", "--print-config"], ["deadtime", "{bad.toml}", "--json"]])


RIG_FILES = [of_rig_file(name, *case) for name, case in FILES.items()]

# --- a rig whose manipulator is an arm, with orders ---------------------------------------------------------------
BERTHING = [
    ('arm = "ess"', 'arm = "nothing"', "no shipped arm has this name"),
    ("direction_x = 1.0", "direction_x = 0.0", "manipulator.direction_x"),
    ("direction_x = 1.0", "direction_z = 1.0", "manipulator.direction_z"),
    ("direction_x = 1.0", "direction_x = 1e300", "manipulator.direction_x: must be 0, or of a size"),
    ("direction_x = 1.0", "direction_x = 1e-300", "manipulator.direction_x: must be 0, or of a size"),
    ("direction_x = 1.0", "initial_velocity_m_per_s = 0.1", "an arm starts at rest"),
    ("direction_x = 1.0", "coulomb_friction_N = 5", "one degree of freedom"),
    ("[limits]", "[prediction]\nenabled = true\n[limits]", "prediction.enabled"),
    ('arm = "ess"', "", "need an arm"),
    ("line_m = [0.3, 0.0]", "line_m = [0.3, 0.0, 0.1]", "must have two numbers"),
    ("line_m = [0.3, 0.0]", "line_m = [0.3]", "two or three numbers"),
    ("line_m = [0.3, 0.0]", "line_m = [7.3, 0.0]", "at most 6.5"),
    ("line_m = [0.3, 0.0]", "line = [0.3, 0.0]", "orders.line: unknown"),
    ("speed_m_per_s = 0.03", "speed_m_per_s = 0", "greater than 0"),
    ("joint = 2", "joint = 3", "must be from 1 to 2"),
    ("rate_rad_per_s = -0.001", "move_to_rad = 0.1\nrate_rad_per_s = -0.001", "must be 0 (as fast as it may)"),
    ("follow = true", "follow = false", "follow = true"),
    ("at_s = 24.0", "at_s = 0.5", "not earlier"),
    ("at_s = 1.0", "at_s = 0.0", "greater than 0"),  # the loop does not run yet: it would be lost
    ("speed_m_per_s = 0.03", "speed_m_per_s = 0.0016", "steps of 0.001 m/s"),
    ("rate_rad_per_s = -0.001", "rate_rad_per_s = 4e-7", "steps of 0.000001 rad/s"),
    ("rate_rad_per_s = -0.001", "move_to_rad = -1.6\nrate_rad_per_s = 4e-7", "steps of 0.000001 rad/s"),  # 0: any rate
    ("line_m = [0.3, 0.0]", "line_m = [0.00009, -0.00004]", "steps of 0.0002 m and must be a multiple of that (is 9e-05)"),
    ("line_m = [0.3, 0.0]", "line_m = [0.3, 0.00009]", "orders.line_m: goes over the wire in steps of 0.0002 m and must "
     "be a multiple of that (is 9e-05)"),
    # At the line of the order.
    ("line_m = [0.3, 0.0]", "line_m = [0.30011, 0.0]", "wrong.toml:46: orders.line_m: goes over the wire"),
    ("line_m = [0.3, 0.0]", "line_m = [0.0, 0.0]", "wrong.toml:48: orders.line_m: goes nowhere; an arm that is to stand "
     "still has joint = 1 and rate_rad_per_s = 0"),
    ("grip_close_s = 20.0", "grip_close_s = 20.0\ngrip_release_s = 10", "later than run.grip_close_s"),
    ('kind = "gripped"', 'kind = "contact"', "run.grip_close_s"),
]

# --- arm files and URDF -------------------------------------------------------------------------------------------
ARM_FILE = [
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
    ('name = "elbow"', 'name = "shoulder"',
     'joint.2.name: there are two joints "shoulder"; each needs a name of its own'),
    ("period_ticks = 1", "period_ticks = 0", "attitude.period_ticks"),
    ("centre_m = [2.0, 0.0, 0.0]", "centre_m = [2.0, 0.0]", "must be 3 numbers"),
    ("mass_kg = 2200.0\n", "", "base.mass_kg: is missing, or 0, and yet there are moments of inertia"),
    ("mass_kg = 45.0\n", "mass_kg = 0\n", "joint.1.link (shoulder).mass_kg: is missing, or 0, and yet"),
]

URDF = """<robot name="r"><link name="a"><inertial><mass value="{mass}"/>
<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="{izz}"/></inertial></link>
<link name="b"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
<joint name="j" type="{type}"><parent link="a"/><child link="{child}"/><axis xyz="{axis}"/></joint></robot>"""
GOOD = {"mass": "10", "izz": "1", "type": "continuous", "child": "b", "axis": "0 0 1"}


# what is changed, the line, what is said
URDF_FILE = [
    ({"izz": "3"}, 2, "no body has it"),
    ({"izz": "-1"}, 2, "no body has it"),
    ({"mass": "heavy"}, 1, "mass"),
    ({"mass": "1,5"}, 1, 'must be a number (is "1,5")'),
    ({"mass": "60 kg"}, 1, "must be a number"),
    ({"izz": "1e400"}, 2, "must be a number"),
    ({"mass": "-1"}, 1, "must be 0 or more"),
    ({"type": "screw"}, 4,
     'is of type "screw"; there are fixed, revolute, continuous, prismatic, planar and floating'),
    ({"type": "revolute"}, 4, "needs <limit>"),
    ({"child": "c"}, 4, 'there is no link "c"'),
    ({"child": "a"}, 4, "j"),
    ({"axis": "0 0 0"}, 4, "no direction"),
    ({"axis": "0 0"}, 4, "three numbers"),
]
URDF_LIMITS = [
    ('lower="-1 rad" upper="2"', 'lower: must be a number (is "-1 rad")'),
    ('lower="-1" upper="2" velocity="fast"', "velocity: must be a number"),
    ('lower="2" upper="-1"', "upper must be greater than lower"),
    ('lower="-1" upper="2" effort="-5"', "effort must not be negative; without it the joint has no such limit"),
    ('lower="-1" upper="2" velocity="-1"', "velocity must not be negative"),
]

# --- presets of robots --------------------------------------------------------------------------------------------
MINE = 'source = "our own measurement"\n[loop]\nperiod_ms = 5.0\n[robot]\ndead_time_ms = [10.0, 30.0]\n'

# what is changed, and what the message says behind the file's name
PRESET = {
    "unknown key": (("dead_time_ms", "dead_tme_ms"), ":5: robot.dead_tme_ms: unknown key; the nearest known one is "
                                                     "robot.dead_time_ms"),
    "reversed range": (("[10.0, 30.0]", "[30.0, 10.0]"), ":5: robot.dead_time_ms: the range from 30.0 to "
                                                         "10.0 is reversed"),
    "nan": (("30.0]", "nan]"), ":5: robot.dead_time_ms: must be a finite number (is nan)"),
    "missing source": (('source = "our own measurement"\n', ""), ": source: is missing"),
    "too short for straight lines": (("[10.0, 30.0]", "[1.0, 30.0]"), ":5: robot.dead_time_ms: must be at "
                                                                       "least one period"),
    "no period of whole ns": (("period_ms = 5.0", "rate_Hz = 300"), ":3: loop.rate_Hz: must divide 1e9"),
    "part of the object": (("[robot]", "[object]\nmass_kg = 3.0\n[robot]"), ":4: object: is no section"),
    "no TOML": (("[robot]", "[robot"), ":4: "),
}
SUBCOMMANDS = [["run", "--no-log"], ["eigen"], ["limits"], ["map", "--vary", "mass"], ["deadtime"]]

# --- profiles -----------------------------------------------------------------------------------------------------
# name: (text, the line, words)
PROFILES = {
    "no column t_s": ("when,x\n0,0\n1,1\n", ":1", ["t_s", "when, x"]),
    "time without a unit": ("time,x\n0,0\n1,1\n", ":2", ["time names no unit", "t_s"]),
    "two columns to choose from": ("t_s,x,y\n0,0,0\n1,1,1\n", ":1", ["profile.column"]),
    "nan": ("t_s,x\n0,0\n1,nan\n", ":3", ["nan", "finite"]),
    "inf": ("t_s,x\n0,0\n1,inf\n", ":3", ["inf", "finite"]),
    "no number": ("t_s,x\n0,0\n1,one\n", ":3", ["one", "finite"]),
    "empty cell": ("t_s,x\n0,0\n1,\n", ":3", ["finite"]),
    "decreasing time": ("t_s,x\n0,0\n2,1\n1,1\n", ":4", ["t_s", "increase"]),
    "repeated time": ("t_s,x\n0,0\n0,1\n", ":3", ["t_s", "increase"]),
    "missing cell": ("t_s,x\n0,0\n1\n", ":3", ["too few"]),
    "beyond what the loop takes": ("t_s,x\n0,0\n\n9,1e9\n", ":4",
                                   ["a position of 1e+09 m is beyond operator.position_limit_m = 2"]),
    "faster than the loop takes": ("t_s,x\n0,0\n0.001,1\n", ":3",
                                   ["1000 m/s is beyond operator.velocity_limit_m_per_s = 2"]),
    "one row": ("t_s,x\n0,0\n", "", ["two rows"]),
    "header only": ("t_s,x\n", "", ["two rows"]),
    "empty": ("", "", ["is empty"]),
    "millimetres": ("t_s,x_mm\n0,0\n1,1\n", ":1", ["x_mm is in mm", "profile.scale=0.001"]),
    "millimetres, by the row of units": ("t_s,x\ns,mm\n0,0\n1,1\n", ":2", ["x is in mm", "profile.scale=0.001"]),
    "a force": ("t_s,push_N\n0,0\n1,1\n", ":1", ["push_N is in N", "something else", "profile.column"]),
}


def of_profile(name, text, place, says, suffix):
    content = gzip.compress(text.encode()) if suffix == ".gz" else text
    file = "p.csv" + suffix
    return Bad(f"profile{suffix}: {name}", ["run", "ess", "--profile", f"{{{file}}}", "--out", "{out}", "--json"],
               *says, files={file: content}, starts=f"berth: {{{file}}}{place}: ")


BERTHING_RIG = (RIG_FOLDER / "ess-berthing.toml").read_text()
ESS_ARM = (ROOT / "sim_hal" / "arms" / "ess.toml").read_text()


def of_urdf(change, says, place, extra=""):
    text = URDF.format(**GOOD | change).replace("</joint>", f"{extra}</joint>")
    return Bad(f"URDF: {extra or change}", ["arm", "{arm.urdf}"], says, place, files={"arm.urdf": text})


OTHERS = [
    *[Bad(f"berthing: {new}", ["run", "{wrong.toml}", "--no-log"], says,
          files={"wrong.toml": changed(BERTHING_RIG, old, new)}) for old, new, says in BERTHING],
    *[Bad(f"arm: {old} -> {new}", ["arm", "{wrong.toml}"], "{wrong.toml}:", says,
          files={"wrong.toml": changed(ESS_ARM, old, new)}) for old, new, says in ARM_FILE],
    *[of_urdf(change, says, "" if change == {"child": "a"} else f"{{arm.urdf}}:{line}:")
      for change, line, says in URDF_FILE],
    *[of_urdf({"type": "revolute"}, says, "{arm.urdf}:4:", f"<limit {limit}/>") for limit, says in URDF_LIMITS],
    *[Bad(f"preset: {name}: {words[0]}", [*words, "ess", "--robot", "{mine.toml}", "--json"],
          files={"mine.toml": changed(MINE, *change)}, starts="berth: {mine.toml}" + says)
      for name, (change, says) in PRESET.items() for words in SUBCOMMANDS],
    *[of_profile(name, *case, suffix) for name, case in PROFILES.items() for suffix in ("", ".gz")],
]


@each(RIG_FILES + OTHERS)
def test_file(row, tmp_path):
    row.check(tmp_path)
