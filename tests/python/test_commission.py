"""`berth commission`: the stages on a simulated rig whose hardware is not what its file says, in order and out of it;
and `berth-target --stage`, whose logs a PC judges."""

import cmath
import json

import pytest
from conftest import EXIT_DIFFERENT, EXIT_DONE, EXIT_INPUT, ROOT, STATE_STOPPED, command, replay_json, settings, topic

STAGES = ("watch", "tare", "step", "shadow", "ramp", "run")
TARGET = ROOT / "build" / "berth-target"
STATE_START = 0
SHARE_MAX = 0.02  # by which a measured value may be off

# The sensor's one axis points up: the tool's weight is on it.
CELL = """
name = "cell"
base = "ess"
[tool]
gravity_x_m_per_s2 = -9.80665
gravity_z_m_per_s2 = 0.0
"""
REALLY = {"robot.dead_time_ms": 21.0, "sensor.bias_N": 7.3, "tool.mass_kg": 4.2, "sensor.noise_N": 0.3,
          "robot.feedback_noise_m": 5e-6}
POSES = ("--pose=-1,0,0", "--pose=0,0,-1", "--pose=1,0,0")


def really(values):
    return [word for key, value in values.items() for word in ("--hardware", f"{key}={value}")]


def commission(rig, folder, *arguments, exit_code=EXIT_DONE):
    """The record after it."""
    done = command("commission", rig, "--out", folder, *arguments, "--json")
    assert done.returncode == exit_code, done.stdout.decode() + done.stderr.decode()
    return json.loads(done.stdout) if done.stdout else done.stderr.decode()


def measured(record, name):
    """The value of that name in the newest entry."""
    return next(value for value in record["entries"][-1]["values"] if value["name"] == name)


def close_to(value, expected):
    return abs(value - expected) <= SHARE_MAX * abs(expected)


def waive(rig, folder, *stages, options=()):
    for stage in stages:
        commission(rig, folder, *options, "--waive", stage, "--because", "a test")


@pytest.fixture(scope="module")
def cell(tmp_path_factory):
    """The record after all stages, of a rig whose dead time, tool and zero differ from its file."""
    folder = tmp_path_factory.mktemp("cell")
    rig = folder / "cell.toml"
    rig.write_text(CELL)
    for stage in STAGES:
        poses = POSES if stage == "tare" else ()
        commission(rig, folder, "--stage", stage, *poses, *really(REALLY))
    return folder


def test_each_difference_is_found_within_two_percent(cell):
    entries = {entry["stage"]: entry for entry in json.loads((cell / "record.json").read_text())["entries"]}
    assert list(entries) == list(STAGES)
    assert {entry["outcome"] for entry in entries.values()} == {"passed"}
    proposed = entries["tare"]["proposed"] | entries["step"]["proposed"]
    assert close_to(proposed["tare.force_x_N"], REALLY["sensor.bias_N"])
    assert close_to(proposed["tool.mass_kg"], REALLY["tool.mass_kg"])
    assert close_to(proposed["robot.dead_time_ms"], REALLY["robot.dead_time_ms"])
    assumed = {value["name"]: value["assumed"] for value in entries["step"]["values"]}
    assert assumed["robot.dead_time_ms"] == 17.5


def test_the_proposal_is_a_rig_file_with_what_was_measured(cell):
    printed = command("run", cell / "proposal.toml", "--print-config").stdout.decode()
    robot = printed.split("[robot]")[1]
    line = next(line for line in robot.splitlines() if line.startswith("dead_time_ms = "))
    assert close_to(float(line.split("=")[1].split("#")[0]), REALLY["robot.dead_time_ms"])


def test_zero_and_weight_are_off_the_force_in_later_stages(cell):
    force_N = topic(cell / "step.ulg")["force_N"]  # the robot touches nothing
    assert abs(force_N.mean()) < 0.05
    assert topic(cell / "tare.ulg")["force_N"].mean() < -30.0  # the last pose: hangs the other way


def test_no_stage_feeds_back_more_than_it_says(cell):
    for stage in ("step", "shadow"):
        tick = topic(cell / f"{stage}.ulg")
        assert (tick["used_force_N"] == 0.0).all() and abs(tick["force_N"]).max() > 0.5
    ramp = topic(cell / "ramp.ulg")
    running = ramp["state"] == 2
    gain = ramp["used_force_N"][running] / ramp["force_N"][running]
    number = running.cumsum()[running]
    assert abs(gain - (number / (60 * 400)).clip(max=1.0)).max() < 1e-9
    assert (topic(cell / "watch.ulg")["state"] == STATE_START).all()


@pytest.mark.parametrize("stage", STAGES)
def test_the_log_of_a_stage_replays(cell, stage):
    assert replay_json(cell / f"{stage}.ulg")["equal"]


def test_the_page_shows_measured_beside_assumed(cell):
    page = (cell / "commissioning.html").read_text()
    assert page.count('class="passed"') == len(STAGES)
    row = next(line for line in page.splitlines() if "robot.dead_time_ms" in line)
    assert "21.00 ms" in row and "17.50 ms" in row


def test_a_heavy_object_that_nobody_knows_is_stopped_in_the_ramp(tmp_path):
    heavy = really({"object.mass_kg": 210, "sensor.noise_N": 0.5})
    waive("ess", tmp_path, "watch", "tare", "step", "shadow")
    record = commission("ess", tmp_path, "--stage", "ramp", *heavy, exit_code=EXIT_DIFFERENT)
    assert "growth" in record["entries"][-1]["because"]
    assert 0.3 < measured(record, "feedback reached")["measured"] < 0.97
    assert "stage ramp has failed" in commission("ess", tmp_path, "--stage", "run", *heavy, exit_code=EXIT_INPUT)


def test_a_dead_time_that_makes_it_unstable_ends_the_ramp_at_the_margin(tmp_path):
    stiff = (*settings({"object.stiffness_N_per_m": 7000}),
             *really({"robot.dead_time_ms": 80, "robot.feedback_noise_m": 5e-6}))
    waive("ess", tmp_path, "watch", "tare", options=stiff)
    record = commission("ess", tmp_path, *stiff, "--stage", "step")
    assert close_to(record["entries"][-1]["proposed"]["robot.dead_time_ms"], 80)
    record = commission("ess", tmp_path, *stiff, "--stage", "shadow", exit_code=EXIT_DIFFERENT)
    damping = measured(record, "predicted damping ratio at full feedback")
    assert damping["measured"] < 0.0 < damping["assumed"]
    limit = measured(record, "feedback at which the margin is used up")["measured"]
    waive("ess", tmp_path, "shadow", options=stiff)
    record = commission("ess", tmp_path, *stiff, "--stage", "ramp", exit_code=EXIT_DIFFERENT)
    assert measured(record, "feedback reached")["measured"] == pytest.approx(limit)
    assert limit < 0.9
    # The eigenvalues of the same rig, asked by themselves: damped by the margin of 0.01 there, and not beyond.
    for gain, is_damped in ((limit - 0.01, True), (limit + 0.01, False)):
        eigen = json.loads(command("eigen", "ess", "--json", *settings(
            {"object.stiffness_N_per_m": 7000, "robot.dead_time_ms": 80, "sensor.gain_error": gain - 1})).stdout)
        s = [cmath.log(complex(*z)) for z in eigen["eigenvalues"] if abs(complex(*z)) > 0.0]
        assert (min(-one.real / abs(one) for one in s) > 0.01) == is_damped


REFUSALS = {
    "too early": (("--stage", "tare"), "stage watch has not run yet"),
    "a waiver without a reason": (("--waive", "watch"), "needs --because"),
    "a waiver too early": (("--waive", "step", "--because", "x"), "stage watch has not run yet"),
    "no stage": (("--stage", "jump"), "jump"),
    "both": (("--stage", "watch", "--waive", "watch"), "--waive"),
    "hardware that the firmware is": (("--stage", "watch", "--hardware", "loop.rate_Hz=500"), "nothing of the hardware"),
    "a key that there is not": (("--stage", "watch", "--hardware", "robot.deadtime=5"), "unknown key"),
    "a pose": (("--stage", "watch", "--pose=1,2"), "must be X,Y,Z"),
    "a pose of no length": (("--stage", "watch", "--pose=0,0,0"), "must be X,Y,Z"),
}


@pytest.mark.parametrize("arguments, words", REFUSALS.values(), ids=REFUSALS)
def test_it_refuses(tmp_path, arguments, words):
    assert words in commission("ess", tmp_path, *arguments, exit_code=EXIT_INPUT)
    assert not (tmp_path / "record.json").exists()


def test_another_rig_file_begins_anew(tmp_path):
    commission("ess", tmp_path, "--stage", "watch")
    changed = settings({"object.mass_kg": 101})
    words = commission("ess", tmp_path, *changed, "--stage", "tare", exit_code=EXIT_INPUT)
    assert "was run with another rig file" in words
    commission("ess", tmp_path, *settings({"run.duration_s": 30}), "--stage", "tare")


SICK = {
    "a silent sensor": ({"sensor.loss_probability": 1}, "the force is missing or too old"),
    "a bus that loses frames": ({"bus.loss_probability": 0.1}, "lost or rejected"),
    "an emergency stop": ({"run.emergency_stop_s": 1}, "the emergency stop is pressed"),
    "a sensor at its end": ({"sensor.bias_N": 1e6}, "the sensor is at the end of its range"),
}


@pytest.mark.parametrize("hardware, words", SICK.values(), ids=SICK)
def test_watch_sees_what_is_wrong(tmp_path, hardware, words):
    record = commission("ess", tmp_path, "--stage", "watch", *really(hardware), exit_code=EXIT_DIFFERENT)
    assert words in record["entries"][-1]["because"]
    assert "stage watch has failed" in commission("ess", tmp_path, "--stage", "tare", exit_code=EXIT_INPUT)


def test_tare_sees_a_drift(tmp_path):
    waive("ess", tmp_path, "watch")
    drift = really({"sensor.drift_N_per_s": 0.5, "sensor.noise_N": 0.2})
    record = commission("ess", tmp_path, "--stage", "tare", *drift, exit_code=EXIT_DIFFERENT)
    assert "drifts" in record["entries"][-1]["because"]
    assert close_to(measured(record, "drift of the force")["measured"], 30.0)


def test_a_target_refuses_and_records_and_a_pc_judges(tmp_path):
    record = tmp_path / "record.json"
    words = ("ess", tmp_path / "a.ulg", "--without-buses", "--record", record)
    early = command(*words, "--stage", "tare", program=(TARGET,))
    assert early.returncode == EXIT_INPUT and b"stage watch has not run yet" in early.stderr
    assert not (tmp_path / "a.ulg").exists()
    ran = command(*words, "--stage", "watch", program=(TARGET,))
    assert ran.returncode == EXIT_DONE and b"judge it on a PC" in ran.stderr
    assert set(topic(tmp_path / "a.ulg")["state"]) == {STATE_START, STATE_STOPPED}
    assert json.loads(record.read_text())["entries"][-1]["outcome"] == "unjudged"
    waits = command(*words, "--stage", "tare", program=(TARGET,))
    assert waits.returncode == EXIT_INPUT and b"not judged yet" in waits.stderr
    judged = commission("ess", tmp_path, "--stage", "watch", "--log", tmp_path / "a.ulg", "--record", record,
                        exit_code=EXIT_DIFFERENT)
    assert judged["entries"][-1]["because"] == "the robot's feedback is missing or too old"
    failed = command(*words, "--stage", "tare", program=(TARGET,))
    assert failed.returncode == EXIT_INPUT and b"stage watch has failed" in failed.stderr
    other = command("commission", "ess", "--out", tmp_path, "--record", record, "--stage", "watch")
    assert other.returncode == EXIT_INPUT and b"name another file with --record" in other.stderr
