"""Rigs of new users: each gets the right verdict, what stopped it, where the delay comes from, what was assumed and what to
do, in the same words on terminal, JSON, page and picture."""

import json
import re
import subprocess
import sys

import pytest
from conftest import EXIT_DIFFERENT, EXIT_DONE, EXIT_INPUT, ROOT, command, one_json_object, run_json, settings

sys.path.insert(0, str(ROOT / "scripts"))
import report_signals  # noqa: E402
import report_words  # noqa: E402
from berth_log import read_log, read_summary  # noqa: E402

KINDS = {"stable", "unstable", "limit cycle", "driven", "bouncing", "undetermined"}

# A robot of 34 ms displays 120 kg and holds 40 kg on a stiff spring.
HELD = """
[loop]
rate_Hz = 500
[manipulator]
mass_kg = 120
stiffness_N_per_m = 8000
damping_N_s_per_m = 100
initial_position_m = 0.005
[robot]
dead_time_ms = 34
[sensor]
delay_ms = 2
noise_N = 0.3
"""
OBJECT = """
[object]
mass_kg = 40
stiffness_N_per_m = 5e4
damping_N_s_per_m = 50
"""

# The same robot moves a tool of 40 kg against a port.
DOCKING = """
[run]
duration_s = 20
[loop]
rate_Hz = 500
[manipulator]
mass_kg = 120
stiffness_N_per_m = 8000
damping_N_s_per_m = 100
initial_position_m = -0.01
[profile]
kind = "minimum_jerk"
offset_m = -0.01
amplitude_m = 0.02
duration_s = 2
[robot]
dead_time_ms = 34
[sensor]
delay_ms = 2
low_pass_frequency_Hz = 100
[object]
kind = "contact"
mass_kg = 40
stiffness_N_per_m = 5e4
damping_N_s_per_m = 50
"""


@pytest.fixture
def rig(tmp_path):
    """A function that writes a rig file and returns its path."""
    def write(text, name="my"):
        path = tmp_path / f"{name}.toml"
        path.write_text(text)
        return path
    return write


def lines(*arguments, exit_code=EXIT_DONE):
    done = command(*arguments)
    assert done.returncode == exit_code, done.stderr.decode()
    return done.stdout.decode().splitlines()


def line_of(shown, start):
    return next(line for line in shown if line.strip().startswith(start))


def test_what_blows_up_is_unstable_with_what_stopped_it_and_what_to_do(rig, tmp_path):
    file = rig(HELD + OBJECT)
    told = run_json(file, tmp_path, advised=True)
    assert told["verdict"] == "unstable" and told["stable"] is False
    assert told["prediction"]["growth_per_s"] == pytest.approx(4.32, abs=0.01)
    assert told["doubling_time_s"] == pytest.approx(0.16, abs=0.005)
    assert told["stopped"]["cause"] == "position_limit"
    assert told["stopped"]["after_s"] == pytest.approx(1.19, abs=0.01)
    assert told["peak_force"]["measured"]["force_N"] == pytest.approx(12.6e3, rel=0.02)
    assert told["peak_force"]["true"]["force_N"] > told["peak_force"]["measured"]["force_N"]
    shown = lines("run", file, "--no-log")
    line = line_of(shown, "unstable")
    assert "the eigenvalues say +4.32 /s: doubles every 0.161 s" in line
    assert line.endswith("stopped by the position limit after 1.19 s")
    assert line_of(shown, "advice").split(maxsplit=1)[1] == told["advice"]
    assert not any("NOT DETERMINED" in line or "DIVERGING" in line for line in shown)


def test_what_was_advised_makes_it_stable(rig):
    advice = one_json_object(command("run", rig(HELD + OBJECT), "--no-log", "--json").stdout)["advice"]
    key, side, value = advice.split(",")[0].split()
    factor = 0.999 if side == "below" else 1.001
    told = one_json_object(command("eigen", rig(HELD + OBJECT), "--json", "--set", f"{key}={float(value) * factor}").stdout)
    assert told["verdict"] == "stable"


def test_the_low_pass_that_nobody_stated_is_said_before_the_verdict(rig, tmp_path):
    told = run_json(rig(HELD + OBJECT), tmp_path)
    assumed = {one["key"]: one["value"] for one in told["assumed"]}
    assert float(assumed["sensor.low_pass_frequency_Hz"]) == 20 and "sensor.delay_ms" not in assumed
    assert told["delay_budget"]["total_ms"] == pytest.approx(48.1, abs=0.05)
    assert told["delay_budget"]["low_pass_ms"] == pytest.approx(11.1, abs=0.05)
    shown = lines("run", rig(HELD + OBJECT), "--no-log")
    kinds = [line.split()[0] for line in shown[1:]]
    assert kinds.index("assumed") < kinds.index("unstable") < kinds.index("delay")
    assert "low_pass_frequency_Hz = 20" in "".join(shown[:kinds.index("unstable") + 1])
    assert line_of(shown, "delay").endswith("= 48.14 ms")


def answers(file, folder, *changes):
    """What `compensate` and `map` answer, for a person and for a program."""
    made = {}
    for subcommand, *more in (["compensate", "--duration", "2"], ["map", "--vary", "mass", "--grid", "5x5", "--out", folder]):
        made[subcommand] = (lines(subcommand, file, *more, *changes),
                            one_json_object(command(subcommand, file, *more, *changes, "--json").stdout))
    return made


@pytest.mark.long
def test_map_and_compensate_list_what_is_assumed_and_where_the_delay_comes_from(rig, tmp_path):
    for subcommand, (shown, told) in answers(rig(HELD + OBJECT), tmp_path).items():
        assert "sensor.low_pass_frequency_Hz" in {one["key"] for one in told["assumed"]}, subcommand
        assert told["delay_budget"]["total_ms"] == pytest.approx(48.1, abs=0.05)
        assert line_of(shown, "assumed") and any("low_pass_frequency_Hz = 20" in line for line in shown), subcommand
        assert line_of(shown, "delay").endswith("= 48.14 ms")


@pytest.mark.parametrize("arguments", [["ess", "--set", "object.stiffness_N_per_m=60000"], ["ess"]], ids=["stiff", "ess"])
def test_what_compensate_recommends_passes_the_check_that_it_names(arguments):
    shown = lines("compensate", *arguments, "--duration", "2")
    line = line_of(shown, "check it:").split(": ")[1]
    words = line.split()
    assert words[:2] == ["build/berth", "eigen"] and words[-1] == "--check" and arguments[-1] in line
    assert command(*words[1:]).returncode == EXIT_DONE, line


@pytest.mark.parametrize("left_out, mentioned", [("object", "force"), ("robot", "robot"), ("manipulator", "manipulator")])
def test_a_diagnosis_judges_the_blocks_that_the_rig_describes(left_out, mentioned, rig, tmp_path):
    """The record shows all three, and the rig file has all but one."""
    log = run_json("ess", tmp_path, *settings({"run.duration_s": 12, "profile.kind": "multisine", "sensor.noise_N": 0.5,
                                               "profile.amplitude_m": 0.01}))["log"]
    sections = (ROOT / "sim_hal" / "rigs" / "ess.toml").read_text().split("\n[")
    part = rig("\n[".join(text for text in sections if not text.startswith(left_out)), "part")
    done = command("diagnose", log, "--rig", part, "--json", "--out", tmp_path / "out")
    assert done.returncode == EXIT_DONE, done.stderr.decode()
    told = one_json_object(done.stdout)
    assert told["not_described"] == [mentioned] and mentioned not in {block["block"] for block in told["blocks"]}
    assert len(told["blocks"]) == 2
    assert any(f"the {mentioned} is not judged" in note and f"[{left_out}]" in note for note in told["notes"])


def test_a_rig_that_describes_nothing_of_a_record_is_refused(rig, tmp_path):
    log = run_json("ess", tmp_path, *settings({"run.duration_s": 2}))["log"]
    done = command("diagnose", log, "--rig", rig("[loop]\nrate_Hz = 400\n"), "--out", tmp_path / "out")
    assert done.returncode == EXIT_INPUT and b"nothing to judge" in done.stderr and not (tmp_path / "out").exists()


@pytest.mark.parametrize("arguments", [["run", "--no-log"], ["eigen"], ["limits"], ["compensate"],
                                       ["map", "--vary", "mass"]], ids=lambda words: words[0])
def test_a_rig_without_an_object_is_refused(arguments, rig, tmp_path):
    file = rig(HELD)
    out = ["--out", tmp_path / "maps"] if arguments[0] == "map" else []
    done = command(arguments[0], file, *arguments[1:], *out)
    assert done.returncode == EXIT_INPUT and done.stdout == b""
    message = done.stderr.decode()
    assert message.startswith(f"berth: {file}: object: the section [object] is missing")
    assert 'base = "ess"' in message and 'kind = "none"' in message


def test_an_object_may_be_taken_on_purpose(rig, tmp_path):
    told = run_json(rig('base = "ess"\n' + HELD), tmp_path, advised=True)
    given = run_json(rig(HELD + "[object]\nmass_kg = 100\nstiffness_N_per_m = 2368.705056261446\n"
                         "damping_N_s_per_m = 19.46773764467334\n"), tmp_path)
    assert told["prediction"]["growth_per_s"] == pytest.approx(given["prediction"]["growth_per_s"], rel=1e-9)


def test_a_robot_that_touches_nothing_swings_as_the_manipulator_alone(rig, tmp_path):
    file = rig(HELD + '[object]\nkind = "none"\n')
    told = run_json(file, tmp_path, "--set", "sensor.noise_N=0")
    assert told["verdict"] == "stable" and told["peak_force"]["true"]["force_N"] == 0
    assert told["growth_per_s"] == pytest.approx(-100 / 120 / 2, rel=1e-3)
    eigen = one_json_object(command("eigen", file, "--json").stdout)
    assert eigen["growth_per_s"] == pytest.approx(-100 / 120 / 2, rel=1e-6)


def test_a_driven_run_is_driven(tmp_path):
    told = run_json("ess", tmp_path, *settings({"profile.kind": "multisine", "profile.amplitude_m": 0.01,
                                                "profile.duration_s": 20}))
    assert told["verdict"] == "driven" and told["stable"] is True
    assert 0 < told["tracking"]["rms_m"] < told["tracking"]["peak_m"] < told["tracking"]["range_m"]
    assert "the robot is" in told["because"] and "oscillation" not in told["because"]


FREE = {"limits.position_min_m": -5, "limits.position_max_m": 5, "limits.velocity_m_per_s": 100,
        "limits.acceleration_m_per_s2": 1e6, "sensor_channel.force_limit_N": 5e4, "run.duration_s": 300}


@pytest.mark.parametrize("effect", [{"object.stiffness_N_per_m": 9000, "robot.backlash_m": 1e-3},
                                    {"object.stiffness_N_per_m": 40000, "manipulator.cubic_stiffness_N_per_m3": 2e7},
                                    {"object.stiffness_N_per_m": 12000, "object.cubic_stiffness_N_per_m3": -2e7}], ids=max)
def test_a_limit_cycle_stands_beside_the_one_that_harmonic_balance_predicts(effect):
    told = one_json_object(command("run", "ess", "--no-log", "--json", *settings(FREE | effect)).stdout)
    assert told["verdict"] == "limit cycle" and told["stable"] is False
    words = re.search(r"height of (\S+) mm and \S+ Hz; harmonic balance predicts (\S+) mm", told["because"])
    seen_mm, predicted_mm = map(float, words.groups())
    assert seen_mm == pytest.approx(predicted_mm, rel=0.1)


@pytest.mark.parametrize("shipped, measured_N, true_N", [("ess", 30.4, 62), ("ess-berthing", 16, 70)])
def test_the_peak_of_the_sensors_spring_stands_beside_the_measured_one(shipped, measured_N, true_N, tmp_path):
    told = run_json(shipped, tmp_path)
    assert told["peak_force"]["measured"]["force_N"] == told["peak_force_N"] == pytest.approx(measured_N, abs=0.5)
    assert told["peak_force"]["true"]["force_N"] == pytest.approx(true_N, rel=0.05)


@pytest.mark.long
def test_the_same_words_on_terminal_json_page_and_picture(rig, tmp_path):
    told = run_json(rig(HELD + OBJECT), tmp_path, advised=True)
    log = tmp_path / "my.ulg"
    summary = read_summary(log, ROOT / "build" / "berth")
    for key in ("verdict", "because", "advice", "stopped", "assumed", "delay_budget", "peak_force", "margin"):
        assert summary[key] == told[key], key
    shown = report_words.verdict(read_log(log), summary)
    assert shown.word == "Unstable" and shown.sentence[1:] == told["because"][1:] + "."
    assert shown.colour == report_signals.BAD
    done = subprocess.run([sys.executable, ROOT / "scripts" / "report.py", log], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    page = log.with_suffix(".html").read_text()
    assert '<p class="word">Unstable' in page and "Delay budget: 48.14 ms" in page
    assert "Assumed, as the rig file does not state it: " in page


def test_a_docking_rig_gets_an_answer_before_it_blows_up(rig, tmp_path):
    told = run_json(rig(DOCKING), tmp_path, advised=True)
    assert told["verdict"] in ("bouncing", "unstable") and told["stable"] is False
    assert told["prediction"]["growth_per_s"] > 0
    assert told["stopped"]["cause"] == "position_limit"


@pytest.mark.long
@pytest.mark.parametrize("arguments, exit_code", [
    (["run", "ess", "--no-log"], EXIT_DONE),
    (["run", "ess", "--no-log", "--set", "object.mass_kg=210"], EXIT_DIFFERENT),
    (["eigen", "ess"], EXIT_DONE),
    (["eigen", "ess", "--set", "object.mass_kg=210"], EXIT_DIFFERENT),
    (["eigen", "ess", "--margin-ms", "1"], EXIT_DONE),
    (["eigen", "ess", "--margin-ms", "1e4"], EXIT_DIFFERENT),
    (["limits", "ess"], EXIT_DONE),
    (["limits", "ess", "--set", "object.mass_kg=210"], EXIT_DIFFERENT),
])
def test_check_gives_an_exit_code_to_scripts(arguments, exit_code):
    assert command(*arguments, "--check").returncode == exit_code
    assert one_json_object(command(*arguments, "--check", "--json").stdout)["verdict"] in KINDS


def test_a_margin_is_nothing_without_a_check():
    done = command("eigen", "ess", "--margin-ms", "1")
    assert done.returncode == EXIT_INPUT and b"--check" in done.stderr


def test_print_config_marks_given_and_assumed(rig):
    shown = lines("run", rig(HELD), "--print-config")
    assert "# given: " in line_of(shown, "dead_time_ms")
    assert "# assumed: " in line_of(shown, "low_pass_frequency_Hz")
    assert any(line.startswith("assumed = [") and '"object"' in line for line in shown)


@pytest.mark.long
def test_json_of_the_prediction_has_the_same_keys():
    for subcommand in ("eigen", "limits", "run"):
        told = json.loads(command(subcommand, "ess", "--json", *(["--no-log"] if subcommand == "run" else [])).stdout)
        assert told["verdict"] == "stable" and told["stable"] is True, subcommand
        assert told["assumed"] == [] and told["delay_budget"]["total_ms"] == pytest.approx(32.39, abs=0.01)
        assert told["margin"]["modulus"] == pytest.approx(0.5389, abs=1e-4), subcommand


OF_ARM = "of the arm where it starts, with the firmware's settings as they are"


@pytest.mark.parametrize("rig_name, settings, note", [
    ("concept-foam", [], None),
    ("concept-arm-foam", [], OF_ARM),
    ("ess-pose", [], OF_ARM),  # a dead time of its own on each axis, and an operator
    ("concept-foam", ["sensor.loss_probability=0.02"], "without what changes from tick to tick"),
])
def test_a_loop_is_stable_up_to_the_margin_that_its_run_says(rig, rig_name, settings, note):
    changes = [word for setting in settings for word in ("--set", setting)]
    margin = one_json_object(command("run", rig_name, "--json", "--no-log", *changes).stdout)["margin"]
    assert margin["note"] == note and not margin["dead_time_margin_is_open"]
    shipped = (ROOT / "sim_hal/rigs" / f"{rig_name}.toml").read_text()
    for share, is_stable in ((0.99, True), (1.01, False)):
        longer, count = re.subn(r"(dead_time_ms = )([\d.]+)", lambda found: found[1] + str(
            float(found[2]) + share * margin["dead_time_margin_ms"]), shipped)
        assert count >= 1
        assert one_json_object(command("eigen", rig(longer), "--json").stdout)["stable"] is is_stable, share


@pytest.mark.parametrize("method, rests_on", [("extrapolation-1", ""), ("identification", "by runs of 20 s without noise, "),
                                              ("adaptive-inverse", "by runs of 20 s without noise, ")])
def test_a_compensated_run_says_the_margin_that_its_limits_have(method, rests_on):
    told = [one_json_object(command(subcommand, "concept-foam", "--json", "--with", method, *more).stdout)["margin"]
            for subcommand, more in (("run", ["--no-log"]), ("eigen", []), ("limits", []))]
    assert told[0]["note"] == rests_on + "with the firmware's settings as they are" and told[0]["dead_time_margin_ms"] > 0.0
    assert told[0] == told[1] == told[2]
    wanted = 0.9 * told[0]["dead_time_margin_ms"], 1.1 * told[0]["dead_time_margin_ms"]
    codes = [command("run", "concept-foam", "--no-log", "--with", method, "--check", "--margin-ms", str(ms)).returncode
             for ms in wanted]
    assert codes == [0, 1]


def test_the_margin_of_a_robot_with_play_comes_from_runs():
    line = line_of(lines("run", "ess", "--no-log", "--set", "robot.backlash_m=0.0001"), "margin")
    assert "the dead time may grow by" in line and "runs of up to 100 s" in line


@pytest.mark.long
def test_a_rig_in_contact_has_eigenvalues_a_bounce_and_the_stiffness_at_which_it_gains_energy(rig):
    file = rig(DOCKING)
    eigen = one_json_object(command("eigen", file, "--json").stdout)
    held = one_json_object(command("eigen", file, "--json", "--set", "object.kind=gripped").stdout)
    assert eigen["growth_per_s"] == held["growth_per_s"] > 0 and eigen["bounce"]["restitution"] > 1
    limits = one_json_object(command("limits", file, "--json").stdout)
    limit = limits["bounce"]["limits"]["object.stiffness_N_per_m"]
    for factor in (0.98, 1.02):
        value = limit["value"] * factor
        told = one_json_object(command("eigen", file, "--json", "--set", f"object.stiffness_N_per_m={value}").stdout)
        assert (told["bounce"]["restitution"] > 1) is ((factor > 1) is (limit["gains"] == "above"))
    shown = lines("limits", file)
    assert "restitution" in line_of(shown, "bounce") and "gains" in line_of(shown, "bounce")


def test_a_map_of_a_rig_in_contact_shows_restitution(rig, tmp_path):
    told = one_json_object(command("map", rig(DOCKING), "--json", "--out", tmp_path, "--x",
                                   "object.stiffness_N_per_m=1e3:1e5:6", "--y", "robot.dead_time_ms=5:60:4").stdout)
    header, *rows = open(told["csv"], encoding="utf-8").read().splitlines()
    assert header.split(",")[-1] == "restitution" and len(rows) == 24
    assert told["bounces"]["restitution_max"] > 1 and 0 < told["bounces"]["gaining_share"] <= 1
