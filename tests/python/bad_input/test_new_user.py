"""Mistakes that people make in their first hour: units, quotes, commas, files of another kind, words of another program.

The rig file is one that a new user writes. Each message names file, line and key where there is one, and a remedy.
"""

import json
import shlex

import pytest
from conftest import EXIT_DONE, ROOT, command
from refusals import Bad, each

MINE = """name = "mine"
[loop]
rate_Hz = 500
[manipulator]
mass_kg = 120.0
stiffness_N_per_m = 8000.0
damping_N_s_per_m = 100.0
initial_position_m = 0.005
[robot]
dead_time_ms = 34.0
interpolation = "linear"
[sensor]
delay_ms = 2.0
[object]
kind = "gripped"
mass_kg = 40.0
stiffness_N_per_m = 5e4
damping_N_s_per_m = 50.0
"""
URDF = '<?xml version="1.0"?>\n<robot name="r"><link name="a"/></robot>\n'
RECORD = "t_s,command_position_m,robot_position_m\n" + "".join(f"{0.01 * i:.2f},{i % 7},{i % 5}\n" for i in range(50))
PNG = b"\x89PNG\r\n\x1a\n" + bytes(range(200))
XLSX = b"PK\x03\x04\x14\x00\x06\x00" + bytes(range(200))
LOG = b"ULog\x01\x12\x35\x01" + bytes(200)
PRESET = 'source = "our own measurement"\n[loop]\nperiod_ms = 5.0\n[robot]\ndead_time_ms = [10.0, 30.0]\n'

# What is written, what should be there, the line in which the message finds it, and words of the message.
LINES = [
    # numbers
    ("mass_kg = 120.0;", "mass_kg = 120.0", 5, "';'"),
    ("mass_kg = 120,5", "mass_kg = 120.0", 5, "120.5"),
    ("stiffness_N_per_m = 8'000", "stiffness_N_per_m = 8000.0", 6),
    ("stiffness_N_per_m = 8,000", "stiffness_N_per_m = 8000.0", 6, "8.000"),
    ("mass_kg = 120 kg", "mass_kg = 120.0", 5, "unit"),
    ("mass_kg = 120kg", "mass_kg = 120.0", 5, "unit"),
    ('mass_kg = "120"', "mass_kg = 120.0", 5, "manipulator.mass_kg", "quotes"),
    ('dead_time_ms = "34 ms"', "dead_time_ms = 34.0", 10, "robot.dead_time_ms", "quotes"),
    ("rate_Hz = '500'", "rate_Hz = 500", 3, "loop.rate_Hz", "quotes"),
    ("mass_kg =", "mass_kg = 120.0", 5),
    ("mass_kg 120.0", "mass_kg = 120.0", 5, "="),
    ("mass_kg: 120.0", "mass_kg = 120.0", 5, "="),
    ("mass_kg == 120.0", "mass_kg = 120.0", 5),
    ("mass_kg = .5", "mass_kg = 120.0", 5, "0.5"),
    ("mass_kg = 1/2", "mass_kg = 120.0", 5),
    ("mass_kg = 2*60", "mass_kg = 120.0", 5),
    ("mass_kg = { value = 120.0, tol = 0.1 }", "mass_kg = 120.0", 5, "manipulator.mass_kg", "tolerance"),
    ("mass_kg = { tolerance = 0.1 }", "mass_kg = 120.0", 5, "manipulator.mass_kg", "value"),
    ("dead_time_ms = -34", "dead_time_ms = 34.0", 10, "robot.dead_time_ms", "-34"),
    ('kind = "gripped', 'kind = "gripped"', 15, "quote", "behind"),
    ("[sensor", "[sensor]", 12, "close", "[robot]"),
    ("dead_time_ms = 34.0\ndead_time_ms = 30.0", "dead_time_ms = 34.0", 11, "dead_time_ms", "line 10"),
    ("[robot]\ndead_time_ms = 40.0", "[object]", 14, "robot", "line 9"),
    ("delay_ms = 0.002", "delay_ms = 2.0", 13, "sensor.delay_ms", "is 0.002 ms", "milliseconds"),
    ("dead_time_ms = 0.034", "dead_time_ms = 34.0", 10, "robot.dead_time_ms", "one period"),
    ("rate_Hz = 0.5", "rate_Hz = 500", 3, "loop.rate_Hz"),
    # units
    ("rate_kHz = 0.5", "rate_Hz = 500", 3, "loop.rate_kHz", "loop.rate_Hz"),
    ("rate_hz = 500", "rate_Hz = 500", 3, "loop.rate_hz", "loop.rate_Hz"),
    ("period_ms = 2", "rate_Hz = 500", 3, "loop.period_ms", "[loop] has rate_Hz"),
    ("initial_position_mm = 5", "initial_position_m = 0.005", 8, "manipulator.initial_position_m"),
    ("stiffness_N_per_mm = 8", "stiffness_N_per_m = 8000.0", 6, "manipulator.stiffness_N_per_m"),
    ("mass_g = 120000", "mass_kg = 120.0", 5, "manipulator.mass_kg"),
    ("mass = 120", "mass_kg = 120.0", 5, "manipulator.mass_kg"),
    ("damping_Ns_per_m = 100", "damping_N_s_per_m = 100.0", 7, "manipulator.damping_N_s_per_m"),
    ("Mass_kg = 120", "mass_kg = 120.0", 5, "manipulator.Mass_kg", "manipulator.mass_kg"),
    ("dead-time_ms = 34", "dead_time_ms = 34.0", 10, "robot.dead-time_ms", "robot.dead_time_ms"),
    ("latency_ms = 34", "dead_time_ms = 34.0", 10, "robot.latency_ms"),
    ("initial_position_m = 5", "initial_position_m = 0.005", 8, "manipulator.initial_position_m", "limits.position_max_m", "is 5 m",
     "metres", "0.005"),
    # words
    ("interpolation = linear", 'interpolation = "linear"', 11, "quotes"),
    ("interpolation = “linear”", 'interpolation = "linear"', 11, "quotes"),
    ('interpolation = "Linear"', 'interpolation = "linear"', 11, "robot.interpolation", '"linear"'),
    ('interpolation = "lin"', 'interpolation = "linear"', 11, "robot.interpolation", '"linear"'),
    ('kind = "grasped"', 'kind = "gripped"', 15, "object.kind", '"gripped"'),
    ('name = mine', 'name = "mine"', 1, "quotes"),
    # sections
    ("[Robot]", "[robot]", 9, "Robot", "robot"),
    ("[robots]", "[robot]", 9, "robots", "robot"),
    ("[Object]", "[object]", 14, "Object", "object"),
    ("robot:", "[robot]", 9),
    ("[manipulator.robot]", "[robot]", 9, "manipulator.robot"),
    ("; the object\n[object]", "[object]", 14, "#"),
    ("// the object\n[object]", "[object]", 14, "#"),
    ('base = "esss"', 'name = "mine"', 1, "base", "ess"),
    ("[prediction]\nenabled = True\n[object]", "[object]", 15, "true", "small letters"),
    ("[prediction]\nenabled = yes\n[object]", "[object]", 15, "true"),
    ("robot.delay_ms = 3\n[object]", "[object]", 14, "robot"),
]
# Whole files: name, content, the line of the message or 0, words.
FILES = [
    ("empty", "mine.toml", "", 0, "empty"),
    ("comments alone", "mine.toml", "# my rig\n", 0, "empty"),
    ("Notepad's Unicode", "mine.toml", MINE.encode("utf-16"), 1, "UTF-8"),
    ("Latin-1", "mine.toml", MINE.replace("[robot]", "[robot] # für").encode("latin-1"), 9, "UTF-8"),
    ("JSON", "mine.json", json.dumps({"loop": {"rate_Hz": 500}}, indent=1), 1, "TOML"),
    ("YAML", "mine.yaml", "loop:\n  rate_Hz: 500\n", 1, "TOML"),
    ("URDF", "mine.urdf", URDF, 1, "URDF", "manipulator.arm"),
    ("URDF named toml", "mine.toml", URDF, 1, "XML"),
    ("a record", "record.csv", RECORD, 1, "berth diagnose"),
    ("a log", "mine.ulg", LOG, 0, "berth summary"),
    ("a Makefile", "Makefile", "# builds it\nCC := gcc\nall: mine\n", 2, "no line begins a section", "--print-config"),
    ("a letter", "letter.txt", "Dear all,\nthe rig is ready = soon\n", 1),
    ("a picture", "mine.png", PNG, 1, "TOML"),
    ("a robot preset", "preset.toml", PRESET, 0, "--robot"),
    ("an arm file", "arm.toml", (ROOT / "sim_hal" / "arms" / "ess.toml").read_text(), 0, "manipulator.arm"),
]
# Command lines, the files that they read, and words of the message.
COMMANDS = [
    ("rnu ess", {}, "rnu", "did you mean run"),
    ("limit ess", {}, "limit", "did you mean limits"),
    ("eigenvalues ess", {}, "did you mean eigen"),
    ("Run ess", {}, "did you mean run"),
    ("--json run ess", {}, "--json", "behind"),
    ("--set robot.dead_time_ms=20 run ess", {}, "--set", "behind"),
    ("ess run", {}, "ess", "run ess"),
    ("ess", {}, "ess"),
    ("eigen ess --set robot=ur10e", {}, "robot: is a section", "--robot ur10e"),
    ("run ess --set robot.dead_time_ms 20", {}, "robot.dead_time_ms", "section.key=value"),
    ("run ess --set robot.dead_time_ms = 20", {}, "robot.dead_time_ms", "section.key=value"),
    ("run ess --set robot.dead_time_ms:20", {}, "section.key=value"),
    ("run ess --set robot.dead_time_ms=20ms", {}, "robot.dead_time_ms", "20ms", "number"),
    ("run ess --set robot.dead_time_ms=17,5", {}, "robot.dead_time_ms", "17.5"),
    ("run ess --set object.mass=40", {}, "object.mass", "object.mass_kg"),
    ("run ess robot.dead_time_ms=20", {}, "robot.dead_time_ms=20", "--set"),
    ("run ess --robot.dead_time_ms=20", {}, "--robot.dead_time_ms", "--set"),
    ("run ess --dead-time-ms 20", {}, "--dead-time-ms"),
    ("run ess -json", {}, "-json"),
    ("run ess --out", {}, "--out"),
    ("run es", {}, "es", "ess"),
    ("run ESS", {}, "ESS", "ess"),
    ("run ess.toml", {}, "ess.toml", "ess"),
    ("run ess --robot ur10e", {}, "ur10e", "ur10e-servoj"),
    ("run ess --robot UR10E-SERVOJ", {}, "ur10e-servoj"),
    ("run ess --with predict", {}, "predict", "prediction"),
    ("eigen ess --no-log", {}, "--no-log"),
    ("limits ess --vary mass", {}, "--vary"),
    ("map ess --vary stiffness", {}, "elasticity or mass"),
    ("map ess --x object.mass_kg=10:100 --y robot.dead_time_ms=5:50:10", {}, "object.mass_kg=10:100", "KEY=FROM:TO:COUNT"),
    ("map ess --x object.mass_kg=10..100 --y robot.dead_time_ms=5:50:10", {}, "KEY=FROM:TO:COUNT"),
    ("diagnose {record.csv}", {"record.csv": RECORD}, "--rig"),
    ("diagnose --rig ess", {}, "RECORD"),
    ("diagnose {mine.toml} --rig ess", {"mine.toml": MINE}, "{mine.toml}:1", "rig file", "--rig"),
    ("diagnose {record.csv} --rig {record.csv}", {"record.csv": RECORD}, "{record.csv}", "--rig"),
    ("diagnose {folder} --rig ess", {"folder/file": ""}, "{folder}", "folder"),
    ("diagnose {empty.csv} --rig ess", {"empty.csv": ""}, "{empty.csv}", "empty"),
    ("diagnose {record.xlsx} --rig ess", {"record.xlsx": XLSX}, "{record.xlsx}", "CSV"),
    ("replay {mine.toml}", {"mine.toml": MINE}, "{mine.toml}", ".ulg"),
    ("summary {record.csv}", {"record.csv": RECORD}, "{record.csv}", ".ulg"),
    ("candump {mine.png}", {"mine.png": PNG}, "{mine.png}", ".ulg"),
    ("export {record.csv} --csv", {"record.csv": RECORD}, "{record.csv}", ".ulg"),
    ("arm {mine.toml}", {"mine.toml": MINE}, "{mine.toml}", "arm"),
    ("robots {mine.toml}", {"mine.toml": MINE}, "{mine.toml}:4", "no section of a robot preset"),
    ("run ess --profile {mine.toml}", {"mine.toml": MINE}, "{mine.toml}:1", "rig file"),
    ("run ess --profile {profile.xlsx}", {"profile.xlsx": XLSX}, "{profile.xlsx}", "CSV"),
    ("run ess --jitter {record.csv}", {"record.csv": RECORD}, "{record.csv}", "cyclictest", "--json=FILE"),
]


def changed(old, new):
    assert MINE.count(old) >= 1, old
    return MINE.replace(old, new, 1)


def of_line(wrong, right, line, *says):
    return Bad(f"line: {wrong}", ["run", "{mine.toml}", "--out", "{out}"], *says, files={"mine.toml": changed(right, wrong)},
               starts=f"berth: {{mine.toml}}:{line}: ", also=[["eigen", "{mine.toml}"]])


def of_file(name, file, content, line, *says):
    return Bad(f"file: {name}", ["run", f"{{{file}}}", "--out", "{out}"], *says, files={file: content},
               starts=f"berth: {{{file}}}:" + (f"{line}: " if line else " "))


def of_command(line, files, *says):
    words = shlex.split(line)
    takes_out = words[:1] in (["run"], ["map"], ["diagnose"]) and "--out" not in words
    return Bad(f"command: {line}", words + ["--out", "{out}"] * takes_out, *says, files=files)


ROWS = [*[of_line(*row) for row in LINES], *[of_file(*row) for row in FILES], *[of_command(*row) for row in COMMANDS]]


@each(ROWS)
def test_mistake(row, tmp_path):
    row.check(tmp_path)


@pytest.mark.parametrize("text", [MINE.replace("\n", "\r\n"), "\ufeff" + MINE, MINE.replace(" = ", "\t=\t"),
                                  MINE.replace("120.0", "120")], ids=["CRLF", "BOM", "tabs", "whole number"])
def test_what_an_editor_adds_is_no_mistake(text, tmp_path):
    (tmp_path / "mine.toml").write_bytes(text.encode())
    done = command("eigen", tmp_path / "mine.toml")
    assert done.returncode == EXIT_DONE, done.stderr.decode()
