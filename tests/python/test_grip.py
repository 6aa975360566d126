"""A gripper that closes on the object while the arm moves, and lets it go: along all axes, and with a beam's modes."""

import numpy as np
import pytest
from conftest import RIG_FOLDER, ROOT, STATE_RUNNING, command, replay_json, run_json, settings, topic
from scipy.linalg import expm
from test_beam import modes

T = 2.5e-3
LOW_PASS = 2 * np.pi * 20.0, 0.7
Y, RZ = np.array([[60.0, 20.0, 1500.0]]), np.array([[40.0, 8.0, 900.0]])  # (m, d, k) a row
ONE_MODE = np.array([[100.0, 19.46773764467334, 2368.705056261446]])
LIGHT = 0.01  # without a low-pass the loop holds no heavy object
GRIPS = {  # s; on a tick and between two
    "closes": (1.0, np.inf),
    "closes between two ticks": (1.00137, np.inf),
    "lets go": (0.0, 1.50071),
    "closes and lets go": (0.80033, 1.5),
    "for less than a tick": (1.0004, 1.0017),
}


def rig_file(folder, size=1.0, beam=False):
    """ess-berthing with further axes, the arm in motion from 0.5 s on; masses, dampers and springs `size` times as
    large as usual."""
    head = (RIG_FOLDER / "ess-berthing.toml").read_text().split("[object]")[0]
    bodies = {"axis.y": ("mass_kg", "damping_N_s_per_m", "stiffness_N_per_m", Y, 25.0),
              "axis.rz": ("inertia_kg_m2", "damping_N_m_s_per_rad", "stiffness_N_m_per_rad", RZ, 12.5)}
    lines = ["[object]"]
    if beam:
        lines += ['kind = "beam"', "modes = 4", "beam_length_m = 8.0", f"beam_mass_kg_per_m = {50.0 * size}",
                  f"beam_stiffness_N_m2 = {392409.4293856904 * size}", "beam_damping_ratio = 0.02"]
    else:
        lines += ['kind = "gripped"', *(f"{key} = {value * size}" for key, value in zip(
            ("mass_kg", "damping_N_s_per_m", "stiffness_N_per_m"), ONE_MODE[0]))]
    for section, (*keys, values, dead_time_ms) in bodies.items():
        lines += [f"[{section}]", *(f"{key} = {value * size}" for key, value in zip(keys, values[0])),
                  f"robot_dead_time_ms = {dead_time_ms}"]
    lines += ["[[orders]]", "at_s = 0.5", "line_m = [-0.01, 0.004]", "speed_m_per_s = 0.005"]
    file = folder / "grip.toml"
    file.write_text(head + "\n".join(lines) + "\n")
    return file


def grip_settings(grip, values=()):
    close_s, release_s = GRIPS[grip]
    return settings({"run.duration_s": 3.0, "run.grip_close_s": close_s, "run.grip_release_s": release_s,
                     "sensor_channel.layout": "three_frames_motorola"} | dict(values))


def hardware(reported, beam, sensor_stiffness, grip, low_pass):
    """What the sensor shows at each tick, and where the tip is, of a robot that reports being at `reported`: modes
    (m, d, k) that all feel the sensor's spring while it is held, and swing by themselves while it is not. By scipy's
    matrix exponential, in pieces that end where a tick does or the grip changes. Reports are a tick old, as samples."""
    m, d, k = beam.T
    n = len(beam)
    sensor_damping = 2 * 0.05 * np.sqrt(sensor_stiffness * m[0])
    w, zeta = LOW_PASS
    size = 2 * n + 5  # q, q', the low-pass and its rate, u, u', 1

    def force(held, grip_m):
        row = np.zeros(size)
        if held:
            row[:n], row[n:2 * n] = -sensor_stiffness, -sensor_damping
            row[-3:] = sensor_stiffness, sensor_damping, -sensor_stiffness * grip_m
        return row

    def rates(row):
        a = np.zeros((size, size))
        a[:n, n:2 * n] = np.eye(n)
        for i in range(n):
            a[n + i] = row / m[i]
            a[n + i, i] -= k[i] / m[i]
            a[n + i, n + i] -= d[i] / m[i]
        a[2 * n, 2 * n + 1] = 1.0
        a[2 * n + 1] = w**2 * row
        a[2 * n + 1, 2 * n] -= w**2
        a[2 * n + 1, 2 * n + 1] -= 2 * zeta * w
        a[-3, -2] = 1.0
        return a

    close_s, release_s = GRIPS[grip]
    held, grip_m = close_s == 0.0, 0.0
    row = force(held, grip_m)
    whole = expm(rates(row) * T)
    state = np.zeros(size)
    state[-1] = 1.0
    shown, tip = [], []
    for tick, position in enumerate(reported):
        ahead = reported[tick + 1] if tick + 1 < len(reported) else position
        state[-3:-1] = position, (ahead - position) / T
        shown.append(state[2 * n] if low_pass else row @ state)
        tip.append(state[:n].sum())
        at, end = T * (tick - 1), T * tick
        changes = [now for now in (close_s, release_s) if now > 0.0 and at - 1e-12 <= now < end - 1e-12]
        for now in changes:
            state = expm(rates(row) * max(0.0, now - at)) @ state
            held = now == close_s
            grip_m = state[-3] - state[:n].sum()
            row = force(held, grip_m)
            whole = expm(rates(row) * T)
            at = max(at, now)
        state = (expm(rates(row) * (end - at)) if changes else whole) @ state
    return np.array(shown), np.array(tip)


def check_axis(shown, reported, beam, sensor_stiffness, grip, low_pass):
    expected, tip = hardware(reported, beam, sensor_stiffness, grip, low_pass)
    close_s, release_s = GRIPS[grip]
    before = int(np.ceil(close_s / T)) + 1
    assert np.all(shown[:before] == 0.0)
    if release_s < np.inf and not low_pass:
        assert np.all(shown[int(np.ceil(release_s / T)) + 2:] == 0.0)
    # Positions come in steps of 1e-11, which the sensor's spring makes a force of; so do forces, in steps of 1e-7.
    bound = 3 * 1e-11 * sensor_stiffness + 1e-6 * np.abs(expected).max()
    assert np.abs(shown - expected)[1:-1].max() < bound
    assert grip == "for less than a tick" or np.abs(expected).max() > 5 * bound
    return tip


@pytest.mark.long
@pytest.mark.parametrize("solver", ["fast", "cvode"])
@pytest.mark.parametrize("low_pass", [0, 2])
@pytest.mark.parametrize("grip", GRIPS)
@pytest.mark.parametrize("beam", [False, True])
def test_all_axes_and_modes(tmp_path, beam, grip, low_pass, solver):
    size = 1.0 if low_pass else LIGHT
    log = run_json(rig_file(tmp_path, size, beam), tmp_path,
                   *grip_settings(grip, {"solver.kind": solver, "sensor.low_pass_order": low_pass}))["log"]
    tick, side, truth = topic(log), topic(log, "side"), topic(log, "rig")
    assert np.all(tick["state"][100:] == STATE_RUNNING)
    bodies = size * (modes(4) if beam else ONE_MODE)
    tip = check_axis(tick["force_N"], tick["robot_position_m"], bodies, 2e7, grip, low_pass)
    check_axis(side["y_force_N"], side["y_robot_m"], size * Y, 2e7, grip, low_pass)
    check_axis(side["rz_torque_N_m"], side["rz_robot_rad"], size * RZ, 2e6, grip, low_pass)
    # The tip rests before, and swings on with all its modes after.
    assert np.abs(truth["object_position_m"][:-2] - tip[1:-1]).max() < 1e-9
    close_s, release_s = GRIPS[grip]
    assert np.all(truth["object_position_m"][:int(close_s / T)] == 0.0)
    assert release_s == np.inf or np.ptp(truth["object_position_m"][-400:]) > 1e-6
    assert replay_json(log)["equal"]


BETWEEN = {  # what else there may be between setpoint and sample
    "jumps": {"robot.interpolation": "hold"},
    "transfer behaviour": {"robot.transfer_frequency_Hz": 8.0},
    "lag": {"robot.lag_ms": 5.0, "sensor.lag_ms": 4.0},
    "low-pass of first order": {"sensor.low_pass_order": 1},
}


@pytest.mark.parametrize("between", BETWEEN)
@pytest.mark.parametrize("grip", ["closes and lets go", "lets go"])
def test_steps_and_cvode_agree(tmp_path, grip, between):
    logs = []
    for solver in ("fast", "cvode"):
        (tmp_path / solver).mkdir()
        file = rig_file(tmp_path / solver, beam=between != "lag")
        logs.append(run_json(file, tmp_path / solver, *grip_settings(
            grip, {"solver.kind": solver, "solver.relative_tolerance": 1e-11} | BETWEEN[between]))["log"])
    for name, fields in (("tick", ["force_N", "robot_position_m"]), ("side", ["y_force_N", "rz_torque_N_m"]),
                         ("rig", ["object_position_m"])):
        a, b = (topic(log, name) for log in logs)
        for field in fields:
            assert np.abs(a[field] - b[field]).max() < 1e-6 * np.ptp(a[field]) + 1e-6 * (field[-1] != "m"), field


@pytest.mark.long
def test_the_shipped_rig_grips_along_all_axes_and_its_report_shows_it(logs):
    result, log = logs("ess-berthing-pose")
    assert result["frames_rejected"] == 0 and result["frames_lost"] == 0 and result["state"] == "running"
    tick, side, arm = topic(log), topic(log, "side"), topic(log, "arm")
    at = int(20.0 / T)
    loads = {name: side[name] for name in ("y_force_N", "rz_torque_N_m")} | {"x": tick["force_N"]}
    for name, load in loads.items():
        assert np.all(load[:at] == 0.0) and np.abs(load[at:]).max() > 1.0, name
    assert np.ptp(arm["tool_x_m"][:at]) > 0.25 and np.abs(arm["wheel_z_N_m_s"]).max() > 0.1
    assert replay_json(log)["equal"]


@pytest.mark.slow
def test_the_report_shows_a_grip(tmp_path):
    log = run_json(rig_file(tmp_path, beam=True), tmp_path, *grip_settings("closes"))["log"]
    command(ROOT / "scripts" / "report.py", log, program=(ROOT / ".venv" / "bin" / "python",))
    page = open(log.replace(".ulg", ".html")).read()
    for word in ("Pose: lateral translation", "Pose: rotation", "Lateral forces and torques", "beam_length_m"):
        assert word in page, word


@pytest.mark.long
@pytest.mark.parametrize("values", [
    {"run.duration_s": 5, "run.grip_close_s": 60},
    {"run.duration_s": 8, "run.grip_close_s": 5, "run.emergency_stop_s": 2},  # stopped by when the gripper closes
], ids=["ends before the grip", "stopped before the grip"])
def test_a_run_that_never_gripped_has_no_verdict(values, tmp_path):
    """The manipulator alone swings and decays meanwhile, and it did run."""
    told = run_json("ess", tmp_path, *settings(values))
    assert told["stable"] is None and told["growth_per_s"] is None and told["gripped"] is False
    shown = command("run", "ess", "--no-log", *settings(values)).stdout.decode()
    assert told["verdict"] == "undetermined" and "run.grip_close_s" in told["advice"]
    assert "undetermined   it ran for" in shown and "never with the object gripped" in shown
    command(ROOT / "scripts" / "report.py", told["log"], program=(ROOT / ".venv" / "bin" / "python",))
    assert "never with the object gripped" in open(told["log"].replace(".ulg", ".html")).read()


def test_a_run_that_gripped_has_one(tmp_path):
    told = run_json("ess", tmp_path, *settings({"run.duration_s": 20, "run.grip_close_s": 0.2}))
    assert told["stable"] is True and told["gripped"] is True
