"""What `--json` promises to programs, for every subcommand and every way to name a rig."""

import json
import math
import pathlib
import shutil

import numpy as np
import pytest
from conftest import RIG_FOLDER, RIGS, ROOT, command, one_json_object, replay_json, run_json, settings, topic

RUN_KEYS = {"growth_per_s", "frequency_Hz", "stable", "ticks", "overruns", "peak_force_N", "speed_x_realtime", "log",
            "config_hash"}
SHORT = {"run.duration_s": 2.0}


@pytest.mark.parametrize("rig", RIGS)
def test_run_of_a_shipped_rig(rig, logs):
    result, log = logs(rig)
    assert RUN_KEYS <= result.keys()
    rate_Hz = 50 if rig == "ess-50hz" else 400
    duration_s = {"concept-copper": 20, "concept-foam": 20, "concept-arm-copper": 40, "concept-arm-foam": 40,
                  "ess-berthing": 70, "ess-berthing-pose": 70,
                  "ess-beam": 8, "ess-pose": 30}.get(rig, 60)
    assert result["ticks"] == rate_Hz * duration_s
    assert result["overruns"] == 0
    assert result["speed_x_realtime"] > 0
    assert result["log"] == str(log) and log.exists()
    assert len(result["config_hash"]) == 16 and int(result["config_hash"], 16) >= 0
    assert result["peak_force_N"] == np.abs(topic(log)["force_N"]).max()
    assert result["stable"] is {"concept-copper": False, "concept-arm-copper": False, "ess-berthing": False,
                                "ess-beam": False}.get(rig, True)
    assert result["growth_per_s"] is None or math.isfinite(result["growth_per_s"])
    assert result["dropped_records"] == 0


def test_no_oscillation_gives_null_and_not_a_number_made_up(tmp_path):
    result = run_json("ess", tmp_path, *settings({"manipulator.initial_position_m": 0.0}))
    assert result["growth_per_s"] is None and result["frequency_Hz"] is None
    assert result["peak_force_N"] == 0.0


def test_a_loop_that_never_ran_is_neither_stable_nor_not(tmp_path):
    result = run_json("ess", tmp_path, *settings({"run.emergency_stop_s": 0.0, "run.duration_s": 2.0}))
    assert result["stable"] is None and result["growth_per_s"] is None and result["state"] == "fault"


@pytest.mark.parametrize("changes, stable", [
    # limits turn the growing oscillation into one of constant height
    ({"object.mass_kg": 180, "robot.dead_time_ms": 60, "sensor.delay_ms": 10}, False),
    ({"manipulator.mass_kg": 1, "run.duration_s": 20}, False),
    # stopped before anything could be seen
    ({"limits.position_max_m": 0.011, "limits.position_min_m": 0.009}, True),
    # the supervisor stops it early; the losses make it grow, by its Lyapunov exponent
    ({"bus.burst_probability": 0.01, "bus.burst_length_frames": 300}, False),
])
def test_the_verdict_says_no_more_than_the_run_shows(changes, stable, tmp_path):
    result = run_json("ess", tmp_path, "--no-log", *settings(changes))
    assert result["stable"] is stable
    if stable is False:
        assert result["prediction"]["growth_per_s"] > 0


UNCLEAR = {"sensor.noise_N": 20, "run.duration_s": 15, "manipulator.damping_N_s_per_m": 5, "object.damping_N_s_per_m": 0,
           "robot.dead_time_ms": 2.5}


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_growth_that_its_interval_holds_zero_of_is_no_finding(seed, tmp_path):
    values = UNCLEAR | {"run.seed": seed}
    result = run_json("ess", tmp_path, "--no-log", *settings(values))
    print(f"growth {result['growth_per_s']:+.4f} +- {result['growth_ci95_per_s']:.4f} /s: {result['stable']}")
    assert abs(result["growth_per_s"]) <= result["growth_ci95_per_s"]
    assert result["verdict"] == "stable" and result["because"].startswith("the eigenvalues say -")
    assert result["because"].endswith("; this run does not show whether it grows or decays")
    hidden = run_json("ess", tmp_path, "--no-log", *settings(values | {"object.backlash_m": 1e-9}))
    assert hidden["stable"] is True and hidden["because"].endswith("; this run alone does not tell")
    assert hidden["prediction"]["growth_per_s"] is None and hidden["because"].startswith("a run without noise: ")
    longer = run_json("ess", tmp_path, "--no-log", *settings(values | {"run.duration_s": 60, "sensor.noise_N": 1}))
    assert abs(longer["growth_per_s"]) > longer["growth_ci95_per_s"] and longer["stable"] is True


def test_no_log_writes_nothing(tmp_path):
    result = run_json("ess", tmp_path / "folder", "--no-log", *settings(SHORT))
    assert result["log"] is None
    assert list(tmp_path.iterdir()) == []


def test_a_file_by_path_is_the_same_as_the_shipped_rig(logs, tmp_path):
    shutil.copy(RIG_FOLDER / "ess.toml", tmp_path / "copy.toml")
    result = run_json(tmp_path / "copy.toml", tmp_path)
    shipped, log = logs("ess")
    assert result["config_hash"] == shipped["config_hash"]
    assert logs_equal(result["log"], log)


def test_a_file_without_a_name_is_called_after_itself(tmp_path):
    (tmp_path / "my own.toml").write_text('base = "ess"\n[run]\nduration_s = 1.0\n')
    result = run_json(tmp_path / "my own.toml", tmp_path)
    assert result["rig"] == "my own" and result["log"].endswith("my own.ulg")


def test_set_is_applied_in_order_and_changes_the_hash(logs, tmp_path):
    result = run_json("ess", tmp_path, "--set", "run.duration_s=9", "--set", "run.duration_s=2",
                      "--set", "object.kind=gripped")
    assert result["ticks"] == 800
    assert result["config_hash"] != logs("ess")[0]["config_hash"]


def logs_equal(one, other):
    """The same bytes: header with configuration, hash and commit, and all data."""
    return pathlib.Path(one).read_bytes() == pathlib.Path(other).read_bytes()


AWKWARD = {
    "sensor.noise_N": 0.1 + 0.2,
    "object.damping_N_s_per_m": 1e-300,
    "manipulator.mass_kg": 1 / 3 * 1e3,
    "sensor.stiffness_N_per_m": 12345678.9,
    "run.seed": 9000000000000000,
    "robot.transfer_frequency_Hz": 7,
    "inverse_filter.enabled": "true",
    "operator.interface": "motion",
    "profile.column": 'a "quoted" \\ name\twith\n everything \x7f',
}


@pytest.mark.long
@pytest.mark.parametrize("rig", RIGS)
@pytest.mark.parametrize("overrides", [{}, AWKWARD], ids=["as shipped", "awkward values"])
def test_print_config_loads_again_as_the_same_rig(rig, overrides, tmp_path):
    if rig in ("ess-beam", "ess-berthing-pose"):  # the object's own follows from the beam's
        overrides = {key.replace("object.damping_N_s_per_m", "object.beam_damping_ratio"): value
                     for key, value in overrides.items()}
    arguments = settings({**SHORT, **overrides})
    printed = command("run", rig, "--print-config", *arguments)
    assert printed.returncode == 0 and printed.stderr == b""
    (tmp_path / "printed.toml").write_bytes(printed.stdout)
    direct = run_json(rig, tmp_path / "direct", *arguments)
    again = run_json(tmp_path / "printed.toml", tmp_path / "again")
    assert again["config_hash"] == direct["config_hash"]
    assert logs_equal(direct["log"], again["log"])
    assert command("run", tmp_path / "printed.toml", "--print-config").stdout == printed.stdout


def test_the_same_seed_repeats_a_noisy_run_and_another_does_not(tmp_path):
    noisy = {**SHORT, "sensor.noise_N": 1, "bus.loss_probability": 0.05}
    logs = [run_json("ess", tmp_path / str(i), *settings({**noisy, "run.seed": seed}))["log"]
            for i, seed in enumerate((7, 7, 8))]
    assert logs_equal(logs[0], logs[1])
    assert not np.array_equal(topic(logs[0])["manipulator_position_m"], topic(logs[2])["manipulator_position_m"])


def test_replay(logs):
    result, log = logs("ess")
    assert replay_json(log) == {"log": str(log), "equal": True, "ticks": result["ticks"], "cut": False, "gap": False,
                                "checksums": True, "damage": None, "whole_until_s": pytest.approx(59.9975)}


@pytest.mark.parametrize("rig, dead_time_ms", [("ess", 17.5), ("ess-50hz", 40.0), ("ess-half-dead-time", 7.5),
                                               ("concept-foam", 17.5), ("concept-copper", 17.5)])
def test_deadtime(rig, dead_time_ms):
    done = command("deadtime", rig, "--json")
    assert done.returncode == 0 and done.stderr == b""
    result = one_json_object(done.stdout)
    assert result["rig"] == rig and result["configured_ms"] == dead_time_ms
    assert result["command_to_motion_ms"] == pytest.approx(dead_time_ms, abs=1e-6)


def test_deadtime_of_no_whole_ticks():
    done = command("deadtime", "ess", "--json", "--set", "robot.dead_time_ms=13.3")
    result = one_json_object(done.stdout)
    assert result["command_to_motion_ms"] == pytest.approx(13.3, abs=1e-6)
    # On a straight line from the setpoint before, which is displayed a period earlier, to the step.
    time_ms = result["period_ms"] * np.arange(len(result["step"]))
    assert result["period_ms"] == 2.5 and time_ms[-1] > 100.0
    assert result["step"] == pytest.approx(np.clip((time_ms - 10.8) / 2.5, 0.0, 1.0), abs=1e-7)


def test_rigs():
    done = command("rigs", "--json")
    assert done.returncode == 0 and done.stderr == b""
    rigs = one_json_object(done.stdout)["rigs"]
    assert sorted(rig["name"] for rig in rigs) == RIGS
    assert all(rig["description"] for rig in rigs)


def test_candump(logs):
    _, log = logs("ess")
    done = command("candump", log, "--json")
    assert done.returncode == 0 and done.stderr == b""
    assert one_json_object(done.stdout) == {
        "log": str(log), "candumps": [str(log.with_suffix(f".{bus}.candump.log")) for bus in ("robot", "sensor")]}


@pytest.mark.parametrize("arguments", [("run", "ess", "--no-log"), ("rigs",), ("deadtime", "ess")])
def test_without_json_a_person_is_spoken_to(arguments):
    done = command(*arguments)
    assert done.returncode == 0 and len(done.stdout.splitlines()) >= 1
    with pytest.raises(json.JSONDecodeError):
        json.loads(done.stdout)


def test_a_path_that_is_no_utf8_is_still_json(tmp_path):
    done = command("run", "ess", "--json", "--set", "run.duration_s=1", "--out", str(tmp_path) + "/\udcff")
    assert done.returncode == 0, done.stderr
    assert "\ufffd" in one_json_object(done.stdout)["log"]


def test_the_loop_program_runs_the_same_loop(tmp_path, logs):
    """build/berth-loop: the firmware's own main() on the simulated rig."""
    log = tmp_path / "ess.ulg"
    done = command("ess", log, program=(ROOT / "build" / "berth-loop",))
    assert done.returncode == 0 and b"24000 ticks, 0 not recorded" in done.stdout
    assert logs_equal(log, logs("ess")[1])


@pytest.mark.parametrize("arguments", [(), ("nosuch",), ("ess", "/proc/x/ess.ulg"), ("ess", "a", "b")])
def test_the_loop_program_refuses_bad_usage(arguments):
    done = command(*arguments, program=(ROOT / "build" / "berth-loop",))
    assert done.returncode == 2 and done.stdout == b"" and len(done.stderr.splitlines()) == 1
