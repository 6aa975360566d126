"""The operator follows files: generated ones, and a positioning move that was measured on a real machine."""

import gzip

import numpy as np
import pytest
from conftest import command, data_folder, run_json, settings, topic
from reference_loop import Loop, simulate
from test_physics import POSITION_TOLERANCE_m, first_running_tick

RELEASE_s = 0.1
ESS = {"rate_Hz": 400.0, "T_R": 17.5e-3, "T_S": 2.5e-3}
START_AT_ZERO = {"manipulator.initial_position_m": 0.0}


def write_csv(path, columns):
    """A CSV file with a header, gzipped if its name says so."""
    rows = [",".join(columns)] + [",".join(repr(float(cell)) for cell in row) for row in zip(*columns.values())]
    opened = gzip.open if path.suffix == ".gz" else open
    with opened(path, "wt") as file:
        file.write("\n".join(rows) + "\n")


def check_command(tick, t_s, position_m):
    """At each tick the loop has the command of one tick before: the newest frame that has arrived. The velocity is
    the slope of the line that the position is on; at a row of the file rounding decides which of the two lines."""
    sent_s = (tick["scheduled_ns"] - tick["scheduled_ns"][1])[1:] * 1e-9 - RELEASE_s + t_s[0]
    position = np.interp(sent_s, t_s, position_m)
    slopes = np.concatenate([[0.0], np.diff(position_m) / np.diff(t_s), [0.0]])
    errors = [np.abs(tick["operator_velocity_m_per_s"][1:] - slopes[np.searchsorted(t_s, sent_s + shift_s)])
              for shift_s in (-1e-9, 1e-9)]
    assert np.abs(tick["operator_position_m"][1:] - position).max() <= 0.5e-9 + 1e-15  # one frame step is 1 nm
    assert np.minimum(*errors).max() <= 0.5e-6 + 1e-12  # 1 um/s


def check_follows(log, t_s, position_m, loop, duration_s):
    """The command that the loop received is the file; the manipulator does what the independent loop does."""
    tick = topic(log)
    assert not tick["limits"].any() and not tick["rejected_frames"].any()
    check_command(tick, t_s, position_m)
    count = len(tick["index"])
    assert count == round(duration_s * loop.rate_Hz)
    operator = np.column_stack([tick["operator_position_m"], tick["operator_velocity_m_per_s"], np.zeros(count)])
    x, _ = simulate(loop, count, first_running_tick(tick), x_start=0.0, operator=operator)
    error_m = np.abs(tick["manipulator_position_m"] - x).max()
    moved_m = np.ptp(tick["manipulator_position_m"])
    lag_m = np.abs(tick["manipulator_position_m"] - tick["operator_position_m"]).max()
    print(f"moves {moved_m:.4f} m, up to {lag_m:.4f} m off the command, {error_m:.2e} m off the independent loop")
    assert moved_m > 0.5 * np.ptp(position_m)
    assert error_m < POSITION_TOLERANCE_m


@pytest.mark.parametrize("name", ["move.csv", "move.csv.gz"])
def test_generated_profile_is_followed(name, tmp_path):
    t_s = np.linspace(0.0, 3.0, 301)
    position_m = 0.05 * np.sin(2.0 * t_s) ** 2
    write_csv(tmp_path / name, {"t_s": t_s, "position_m": position_m})
    result = run_json("ess", tmp_path, "--profile", tmp_path / name,
                      *settings({**START_AT_ZERO, "run.duration_s": 4.0}))
    check_follows(result["log"], t_s, position_m, Loop(**ESS), 4.0)


def test_gzip_and_plain_give_the_same_run(tmp_path):
    t_s = np.linspace(0.0, 1.0, 50)
    runs = []
    for name in ("a.csv", "a.csv.gz"):
        write_csv(tmp_path / name, {"t_s": t_s, "position_m": 0.01 * t_s})
        result = run_json("ess", tmp_path / name.replace(".", "_"), "--profile", tmp_path / name,
                          *settings({"run.duration_s": 1.0}))
        runs.append(topic(result["log"])["manipulator_position_m"])
    assert np.array_equal(*runs)


def test_one_of_several_columns_and_a_scale(tmp_path):
    """Columns in any order; millimetres; a file that starts at some other time than 0."""
    t_s = np.linspace(7.0, 9.0, 201)
    position_m = 0.02 * np.sin(3.0 * (t_s - 7.0))
    write_csv(tmp_path / "m.csv", {"other": np.ones(201), "p_mm": 1e3 * position_m, "t_s": t_s})
    result = run_json("ess", tmp_path, "--profile", tmp_path / "m.csv",
                      *settings({**START_AT_ZERO, "profile.column": "p_mm", "profile.scale": 1e-3,
                                 "run.duration_s": 3.0}))
    check_follows(result["log"], t_s, position_m, Loop(**ESS), 3.0)


QUOTED = '"t_s","x_m"'
FORMS = {"quoted names": (QUOTED, ",", "."), "comment above": ("# a slow move\n% of one axis\nt_s,x_m", ",", "."),
         "spreadsheet": ("Move 7\n\nt_s;x_m\ns;m", ";", ","), "time in ms": ("Time [ms],x_m", ",", ".")}


@pytest.mark.parametrize("form", FORMS)
def test_a_profile_as_other_programs_write_it(form, tmp_path):
    header, separator, mark = FORMS[form]
    t_s = np.linspace(0.0, 2.0, 41)
    position_m = 0.03 * np.sin(1.5 * t_s) ** 2
    scale = 1e3 if "ms" in form else 1.0
    rows = [f"{scale * t!r}{separator}{x!r}".replace(".", mark) for t, x in zip(t_s.tolist(), position_m.tolist())]
    (tmp_path / "move.csv").write_text("\n".join([header, *rows]) + "\n")
    result = run_json("ess", tmp_path, "--profile", tmp_path / "move.csv",
                      *settings({**START_AT_ZERO, "run.duration_s": 3.0}))
    check_follows(result["log"], t_s, position_m, Loop(**ESS), 3.0)


@pytest.mark.parametrize("name, is_told", [("x", True), ("position_m", False)])
def test_a_column_without_a_unit_is_told(name, is_told, tmp_path):
    write_csv(tmp_path / "move.csv", {"t_s": [0.0, 1.0], name: [0.0, 0.01]})
    done = command("run", "ess", "--no-log", "--profile", tmp_path / "move.csv", "--set", "run.duration_s=1")
    assert done.returncode == 0 and (b"names no unit" in done.stderr) == is_told


@pytest.fixture(scope="module")
def measured_move():
    """The reference of a real positioning move, 1 kHz: path, times in s, positions in m."""
    folder = data_folder()
    path = folder / "emps" / "train.csv.gz" if folder else None
    if path is None or not path.exists():
        pytest.skip("THE REAL POSITIONING MOVE WAS NOT TRIED: no emps/train.csv.gz in $BERTH_DATA or ../shared/data")
    columns = np.genfromtxt(path, delimiter=",", names=True)
    return path, columns["t_s"], columns["qg_m"]


def run_measured_move(path, folder, overrides):
    """24 s of it; the log."""
    result = run_json("ess", folder, "--profile", path,
                      *settings({**START_AT_ZERO, "profile.column": "qg_m", "run.duration_s": 24.0, **overrides}))
    assert result["stop_cause"] == "none"
    return result["log"]


def test_real_positioning_move_with_the_gripped_object(measured_move, tmp_path):
    path, t_s, position_m = measured_move
    log = run_measured_move(path, tmp_path, {})
    check_follows(log, t_s, position_m, Loop(**ESS), 24.0)


def test_real_positioning_move_with_next_to_no_object(measured_move, tmp_path):
    """A well damped manipulator that carries a gram is a filter of the command alone: scipy's lsim."""
    from scipy.signal import lsim

    path, t_s, position_m = measured_move
    M, K = 200.0, 200.0 * (2.0 * np.pi * 5.0) ** 2
    D = 2.0 * 0.7 * np.sqrt(K * M)
    object_is = {"object.mass_kg": 1e-3, "object.stiffness_N_per_m": 0.0, "object.damping_N_s_per_m": 0.0,
                 "manipulator.stiffness_N_per_m": K, "manipulator.damping_N_s_per_m": D,
                 "sensor.stiffness_N_per_m": 1e3}
    tick = topic(run_measured_move(path, tmp_path, object_is))
    t = tick["scheduled_ns"] * 1e-9
    check_command(tick, t_s, position_m)
    running = np.arange(len(t)) >= first_running_tick(tick)
    system = ([[0, 1], [-K / M, -D / M]], [[0, 0], [K / M, D / M]], np.eye(2), np.zeros((2, 2)))
    inputs = np.column_stack([tick["operator_position_m"], tick["operator_velocity_m_per_s"]])[running]
    _, _, states = lsim(system, inputs, t[running] - t[running][0], interp=False)
    error_m = np.abs(tick["manipulator_position_m"][running] - states[:, 0]).max()
    follows_m = np.abs(tick["manipulator_position_m"] - tick["operator_position_m"])[running].max()
    print(f"of {np.ptp(position_m):.3f} m: off the command by {follows_m:.2e} m, off lsim by {error_m:.2e} m")
    assert error_m < 1e-7
    assert follows_m < 0.1 * np.ptp(position_m)
