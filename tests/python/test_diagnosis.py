"""`berth diagnose`: what it finds in logs of our own, in measured data, and what it refuses."""

import contextlib
import gzip
import json
import os
import pty
import re
import resource
import subprocess
import threading
import tomllib
import zlib

import numpy as np
import pytest
import scipy.signal
from conftest import BERTH, EXIT_DONE, EXIT_INPUT, ROOT, command, data_folder

# A drive whose mass and viscous friction are known (EMPS benchmark, Janot, Gautier & Brunot 2019).
DRIVE = """
name = "drive"
[loop]
rate_Hz = 1000
[manipulator]
mass_kg = 95.1089
damping_N_s_per_m = 203.5034
stiffness_N_per_m = 0.0
[operator]
interface = "force"
[signals]
command_position_m = "qm_m"
operator_force_N = { column = "vir_V", scale = 35.15065 }
"""

def diagnose(out, *arguments):
    """The diagnosis in `out`; it must not fail."""
    done = command("diagnose", *arguments, "--out", out)
    assert done.returncode == EXIT_DONE, done.stderr.decode()
    return json.loads((out / "diagnosis.json").read_text())


def values(found):
    """{effect: {parameter: value}} of the causes."""
    return {cause["effect"]: {p["name"]: p["value"] for p in cause["parameters"]} for cause in found["causes"]}


def measured(*names):
    """Paths of measured data; says loudly if they are not there."""
    folder = data_folder()
    paths = [folder / name for name in names] if folder else []
    if not paths or not all(path.exists() for path in paths):
        pytest.skip(f"NOT TRIED ON MEASURED DATA: no {', '.join(names)} in $BERTH_DATA or ../shared/data")
    return paths


# --- logs of our own ----------------------------------------------------------------------------------------------
RUN = ["--set", "run.duration_s=20", "--set", "profile.kind=multisine", "--set", "profile.amplitude_m=0.01", "--set",
       "profile.frequency_end_Hz=4", "--set", "sensor.noise_N=0.2"]


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    """A run of `ess` with some noise."""
    folder = tmp_path_factory.mktemp("run")
    assert command("run", "ess", *RUN, "--out", folder).returncode == EXIT_DONE
    return folder / "ess.ulg"


def test_of_the_rig_that_made_a_log_only_noise_is_left(log, tmp_path):
    found = diagnose(tmp_path, log, "--rig", "ess")
    assert found["verdict"] == "nothing_detectable" and found["causes"] == []
    # The wire's step of 10 pm, rounded: 2.9 pm rms.
    assert found["residual"]["command_position_m"]["fit"]["before"] == pytest.approx(1e-11 / np.sqrt(12), rel=0.05)
    assert found["residual"]["robot_position_m"]["fit"]["before"] < 1e-14
    assert found["residual"]["force_N"]["fit"]["before"] == pytest.approx(0.2, rel=0.05)


@pytest.mark.parametrize("layout", ["one_frame", "three_frames_intel"])
def test_in_a_run_without_noise_the_steps_of_the_wire_are_no_fault(tmp_path, layout):
    keys = ["--set", f'sensor_channel.layout="{layout}"', "--set", "run.duration_s=20"]
    assert command("run", "ess", *keys, "--out", tmp_path).returncode == EXIT_DONE
    found = diagnose(tmp_path / "out", tmp_path / "ess.ulg", "--rig", "ess", *keys)
    assert found["verdict"] == "nothing_detectable" and found["causes"] == []
    assert 0.0 < found["residual"]["force_N"]["fit"]["before"] < 0.01


@pytest.mark.parametrize("more", [
    {}, {"robot.lag_ms": 15}, {"robot.lag_ms": 15, "robot.velocity_limit_m_per_s": 0.1}, {"robot.velocity_limit_m_per_s": 0.1},
    {"robot.backlash_m": 2e-4},
    {"robot.transfer_frequency_Hz": 12, "robot.transfer_damping_ratio": 0.6}, {"robot.dead_time_ms": 18.3}], ids=str)
@pytest.mark.first(3)
def test_of_a_robot_that_jumps_to_its_setpoints_only_noise_is_left(more, tmp_path):
    keys = [word for key, value in {"robot.interpolation": '"hold"', **more}.items() for word in ("--set", f"{key}={value}")]
    assert command("run", "ess", *RUN, *keys, "--out", tmp_path).returncode == EXIT_DONE
    found = diagnose(tmp_path / "out", tmp_path / "ess.ulg", "--rig", "ess", *keys)
    assert found["verdict"] == "nothing_detectable" and found["causes"] == []
    assert found["residual"]["robot_position_m"]["fit"]["before"] < 2e-8
    assert found["residual"]["force_N"]["fit"]["before"] == pytest.approx(0.2, rel=0.05)


@pytest.mark.parametrize("key, wrong, effect, name, right", [
    ("robot.dead_time_ms", 14.0, "robot.dead_time", "dead_time_ms", 17.5),
    ("sensor.bias_N", 1.5, "sensor.bias", "bias_N", 0.0),
    ("object.mass_kg", 60.0, "object.parameters", "mass_kg", 100.0),
])
def test_a_rig_file_that_is_wrong_is_put_right(log, tmp_path, key, wrong, effect, name, right):
    found = diagnose(tmp_path, log, "--rig", "ess", "--set", f"{key}={wrong}")
    assert found["verdict"] == "named" and list(values(found)) == [effect]
    assert values(found)[effect][name] == pytest.approx(right, rel=1e-3, abs=0.05)
    extended = command("run", tmp_path / "extended.toml", "--no-log", "--json")
    assert extended.returncode == EXIT_DONE, extended.stderr.decode()


def test_a_force_that_is_older_than_its_tolerance_is_no_second_mode(tmp_path):
    """The base goes as far as it may, filter and spring with it: what is left looks like many things."""
    late = ["--set", "sensor.sample_phase_ms=1.3", "--set", "run.duration_s=30", "--set", "robot.feedback_noise_m=5e-6"]
    assert command("run", "ess", *RUN, *late, "--out", tmp_path).returncode == EXIT_DONE
    found = diagnose(tmp_path / "out", tmp_path / "ess.ulg", "--rig", "ess")
    assert [one["effect"] for one in found["causes"]] == ["sensor.delay"]
    low_ms, high_ms = found["causes"][0]["parameters"][0]["ci95"]
    assert low_ms < 2.5 + 1.2 < high_ms


@pytest.mark.slow
def test_a_body_of_a_hundredth_is_told_in_part(tmp_path):
    """The sensor's spring is a twentieth of what the rig file says, which no effect is: an object that hangs on another
    of no mass does the same."""
    soft = ["--set", "sensor.stiffness_N_per_m=1e6", "--set", "run.duration_s=30", "--set", "robot.feedback_noise_m=5e-6"]
    assert command("run", "ess", *RUN, *soft, "--out", tmp_path).returncode == EXIT_DONE
    found = diagnose(tmp_path / "out", tmp_path / "ess.ulg", "--rig", "ess")
    assert found["verdict"] == "partly_explained" and "object.parameters" in [one["effect"] for one in found["causes"]]
    assert any("hundredth" in doubt for block in found["blocks"] for doubt in block["doubts"])


def test_a_software_mismatch_is_said(log, tmp_path):
    """The firmware of the log had another mass: the command does not replay."""
    found = diagnose(tmp_path, log, "--rig", "ess", "--set", "manipulator.mass_kg=201")
    assert found["verdict"] == "software_mismatch" and found["block"] == "manipulator"


@pytest.mark.parametrize("limit", ["limits.velocity_m_per_s=0.05", "limits.acceleration_m_per_s2=0.3"])
def test_limits_of_the_firmware_that_acted_are_no_mismatch(limit, tmp_path):
    """They hold back the command from where the manipulator is."""
    assert command("run", "ess", *RUN, "--set", limit, "--out", tmp_path).returncode == EXIT_DONE
    found = diagnose(tmp_path / "out", tmp_path / "ess.ulg", "--rig", "ess", "--set", limit)
    assert found["verdict"] == "nothing_detectable" and "manipulator" not in [one["block"] for one in found["blocks"]]
    assert any("limits of the firmware acted" in note for note in found["notes"])


def test_a_probability_stays_one(tmp_path):
    """Six lost samples in 20 s: of 0 to 0.16 %, not less."""
    lost = ["--set", "loop.lost_sample_probability=0.0007", "--set", "run.seed=3"]
    assert command("run", "ess", *RUN, *lost, "--out", tmp_path).returncode == EXIT_DONE
    done = command("diagnose", tmp_path / "ess.ulg", "--rig", "ess", "--out", tmp_path)
    found = json.loads((tmp_path / "diagnosis.json").read_text())
    parameter = found["causes"][0]["parameters"][0]
    assert parameter["key"] == "loop.lost_sample_probability" and parameter["ci95"][0] == 0.0
    assert parameter["value"] < parameter["ci95"][1] < 0.01
    assert "lost_sample_probability = 0.00075424 (0 to 0.0016)" in done.stdout.decode()


def test_what_was_not_fitted_stands_as_given(tmp_path):
    undamped = ["--set", "object.damping_N_s_per_m=0"]
    assert command("run", "ess", *RUN, *undamped, "--out", tmp_path).returncode == EXIT_DONE
    done = command("diagnose", tmp_path / "ess.ulg", "--rig", "ess", *undamped, "--set", "object.mass_kg=60", "--out",
                   tmp_path)
    found = json.loads((tmp_path / "diagnosis.json").read_text())
    fitted = {one["name"]: one["fitted"] for one in found["causes"][0]["parameters"]}
    assert fitted == {"mass_kg": True, "damping_N_s_per_m": False, "stiffness_N_per_m": True, "damping_ratio": True}
    assert "damping_N_s_per_m = 0, as given" in done.stdout.decode()


# --- measured data ------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("tolerance", [None, 0.005])
@pytest.mark.first(1)
def test_friction_and_offset_of_a_real_drive(tmp_path, tolerance):
    """Within 2 % of the published values, though the record knows no zero of either; then the asymmetry."""
    train, pulses = measured("emps/train.csv.gz", "emps/test_pulses.csv.gz")
    rig = tmp_path / "drive.toml"
    text = DRIVE
    for value in ("95.1089", "203.5034") if tolerance else ():
        text = text.replace(value, f"{{ value = {value}, tolerance = {tolerance} }}")
    rig.write_text(text)
    found = diagnose(tmp_path, train, "--rig", rig, "--validate", pulses)
    causes = values(found)
    assert list(causes)[:2] == ["manipulator.coulomb_friction", "manipulator.gravity_offset"]
    assert causes["manipulator.coulomb_friction"]["coulomb_friction_N"] == pytest.approx(20.3935, rel=0.02)
    assert causes["manipulator.gravity_offset"]["gravity_offset_N"] == pytest.approx(-3.1648, rel=0.02)
    assert list(causes)[2:] == ["manipulator.asymmetric_friction"]
    assert all(cause["held_out_gain"]["ci95"][0] > 0.0 for cause in found["causes"])


# --- what is refused ----------------------------------------------------------------------------------------------
def motion(rows=4000):
    """t_s, command and robot of a robot that does as it is told, with noise."""
    t_s = 0.0025 * np.arange(rows)
    command_m = 0.01 * np.sin(2 * np.pi * 0.7 * t_s) + 0.003 * np.sin(2 * np.pi * 2.3 * t_s + 1.0)
    robot_m = np.interp(t_s - 0.0175, t_s, command_m) + 1e-6 * np.random.default_rng(1).standard_normal(rows)
    return t_s, command_m, robot_m


def write(path, header, *columns):
    text = header + "\n" + "".join(",".join(repr(float(v)) for v in row) + "\n" for row in zip(*columns))
    path.write_bytes(gzip.compress(text.encode()) if path.suffix == ".gz" else text.encode())
    return path


def refused(out, record, *contains, arguments=(), **options):
    done = command("diagnose", record, *arguments, "--rig", "ess", "--out", out / "out", **options)
    message = done.stderr.decode()
    assert done.returncode == EXIT_INPUT and done.stdout == b"", message
    assert message.startswith("berth: ") and message.count("\n") == 1 and "internal error" not in message, message
    assert not (out / "out").exists()
    for part in (record.name, *contains):
        assert part in message, message


HEADER = "t_s,command_position_m,robot_position_m"
ENDLESS_BYTES_MAX = 400000000  # of memory, to refuse a record that is larger


def test_good_motion_is_not_refused(tmp_path):
    record = write(tmp_path / "good.csv.gz", HEADER, *motion())
    assert diagnose(tmp_path / "out", record, "--rig", "ess")["verdict"] == "nothing_detectable"


def test_not_a_number(tmp_path):
    t_s, command_m, robot_m = motion()
    robot_m[17] = np.nan
    refused(tmp_path, write(tmp_path / "nan.csv", HEADER, t_s, command_m, robot_m), ":19:", "robot_position_m",
            "finite")


def test_missing_columns(tmp_path):
    t_s, command_m, robot_m = motion()
    refused(tmp_path, write(tmp_path / "no_time.csv", "s,command_position_m,robot_position_m", t_s, command_m, robot_m),
            "t_s", "command_position_m, robot_position_m")
    refused(tmp_path, write(tmp_path / "alone.csv", "t_s,robot_position_m", t_s, robot_m), "no block can be replayed")


def test_another_unit(tmp_path):
    t_s, command_m, robot_m = motion()
    header = "t_s,command_position_mm,robot_position_m"
    refused(tmp_path, write(tmp_path / "mm.csv", header, t_s, 1e3 * command_m, robot_m), "command_position_mm",
            "another unit", "scale")


def test_a_column_that_never_changes(tmp_path):
    t_s, command_m, robot_m = motion()
    refused(tmp_path, write(tmp_path / "constant.csv", HEADER, t_s, command_m, 0 * robot_m), "robot_position_m",
            "every row")


def test_three_samples(tmp_path):
    refused(tmp_path, write(tmp_path / "three.csv", HEADER, *motion(3)), "3 rows")


def test_time_that_runs_backwards(tmp_path):
    t_s, command_m, robot_m = motion()
    t_s[1000:] -= 1.0
    refused(tmp_path, write(tmp_path / "back.csv", HEADER, t_s, command_m, robot_m), ":1002:", "time must increase")


def test_another_rate(tmp_path):
    t_s, command_m, robot_m = motion()
    refused(tmp_path, write(tmp_path / "rate.csv", HEADER, 2 * t_s, command_m, robot_m), "loop.rate_Hz=200")


# An electronic oscillator, with voltages for force and position, sampled at no whole rate.
OSCILLATOR = """
name = "oscillator"
{rate}
[manipulator]
mass_kg = 5.4e-6
damping_N_s_per_m = 2e-4
stiffness_N_per_m = 0.95
[operator]
interface = "force"
[signals]
operator_force_N = "V1"
command_position_m = "V2"
"""


@pytest.fixture(scope="module")
def oscillation(tmp_path_factory):
    """At 610.35 Hz, the spring 1 N/m instead of 0.95; stamps with 4 digits, as loggers write them."""
    random = np.random.default_rng(7)
    force_N = random.normal(0, 0.1, 12000)
    plant = scipy.signal.cont2discrete(([1.0], [5.4e-6, 2e-4, 1.0]), 1 / 610.35)
    position_m = scipy.signal.lfilter(plant[0].ravel(), plant[1], force_N) + random.normal(0, 1e-4, len(force_N))
    path = tmp_path_factory.mktemp("oscillation") / "oscillation.csv"
    table = np.column_stack((np.round(np.arange(len(force_N)) / 610.35, 4), force_N, position_m))
    np.savetxt(path, table, delimiter=",", header="t_s,V1,V2", comments="", fmt=["%.4f", "%.9g", "%.9g"])
    return path


def test_a_rig_file_without_a_rate_takes_the_records(oscillation, tmp_path):
    rig = tmp_path / "rig.toml"
    rig.write_text(OSCILLATOR.format(rate=""))
    found = diagnose(tmp_path, oscillation, "--rig", rig)
    assert any("610.35" in note and "the rig file states none" in note for note in found["notes"])
    assert list(values(found)) == ["manipulator.parameters"]
    assert values(found)["manipulator.parameters"]["stiffness_N_per_m"] == pytest.approx(1.0, rel=2e-3)
    for made in ("given.toml", "extended.toml"):
        rate = tomllib.loads((tmp_path / made).read_text())["loop"]["rate_Hz"]
        assert rate == pytest.approx(610.35, rel=1e-6)
    assert command("eigen", tmp_path / "extended.toml").returncode == EXIT_DONE


def test_the_rate_that_is_asked_for_is_taken(oscillation, tmp_path):
    rig = tmp_path / "rig.toml"
    rig.write_text(OSCILLATOR.format(rate="[loop]\nrate_Hz = 625"))
    refusal = command("diagnose", oscillation, "--rig", rig, "--out", tmp_path)
    assert refusal.returncode == EXIT_INPUT
    asked_for = refusal.stderr.decode().split("say ")[1].split()
    assert float(asked_for[1].removeprefix("loop.rate_Hz=")) == pytest.approx(610.35, rel=1e-6)
    found = diagnose(tmp_path, oscillation, "--rig", rig, *asked_for)
    assert list(values(found)) == ["manipulator.parameters"]


def test_a_file_that_is_no_record(tmp_path):
    (tmp_path / "empty.csv").write_bytes(b"")
    refused(tmp_path, tmp_path / "empty.csv", "is empty")
    (tmp_path / "short.csv").write_text("t_s,command_position_m,robot_position_m\n0,1\n")
    refused(tmp_path, tmp_path / "short.csv", ":2:", "cells")
    refused(tmp_path, tmp_path / "absent.csv", "cannot be read")


def endless_rows():
    """A record that never ends, piece by piece."""
    yield (HEADER + "\n").encode()
    first = 0
    while True:
        yield "".join(f"{0.0025 * n:.4f},{1e-6 * (n % 977)},{1e-6 * (n % 977)}\n"
                      for n in range(first, first + 20000)).encode()
        first += 20000


@pytest.mark.parametrize("pack", ["plain", "gz"])
def test_a_record_without_end_is_refused_while_it_is_read(tmp_path, pack):
    name = tmp_path / ("pipe.csv.gz" if pack == "gz" else "pipe.csv")
    os.mkfifo(name)
    written = 0

    def feed():
        nonlocal written
        packer = zlib.compressobj(1, wbits=31) if pack == "gz" else None
        with contextlib.suppress(BrokenPipeError), open(name, "wb", buffering=0) as pipe:
            for rows in endless_rows():
                pipe.write(packer.compress(rows) if packer else rows)
                written += len(rows)

    feeder = threading.Thread(target=feed, daemon=True)
    feeder.start()
    limit = lambda: resource.setrlimit(resource.RLIMIT_AS, (ENDLESS_BYTES_MAX, ENDLESS_BYTES_MAX))  # noqa: E731
    refused(tmp_path, name, "more than 1000000 rows", "cut out", preexec_fn=limit)
    feeder.join(timeout=20)
    assert not feeder.is_alive(), "it is still being read"
    assert written < 50e6, "it was read to no purpose"


def test_records_that_together_are_too_long(tmp_path):
    t_s, command_m, robot_m = motion(10000)
    record = write(tmp_path / "part.csv.gz", HEADER, t_s, command_m, robot_m)
    refused(tmp_path, record, "and those before it", "more than 1000000 rows", arguments=[record] * 100)


def test_a_log_that_is_too_large_to_be_read(tmp_path):
    log = tmp_path / "large.ulg"
    with log.open("wb") as file:
        file.truncate(1000000000)  # takes no room on the disk
    refused(tmp_path, log, "more than 1000000 rows")


def test_whoever_waits_at_a_terminal_sees_what_is_done(tmp_path):
    record = write(tmp_path / "good.csv", HEADER, *motion())
    ours, theirs = pty.openpty()
    words = [BERTH, "diagnose", record, "--rig", "ess", "--out", tmp_path / "out"]
    done = subprocess.run(words, cwd=ROOT, stdout=subprocess.PIPE, stderr=theirs, timeout=60, check=True)
    shown = os.read(ours, 10000).decode()
    for what in ("reading", "looking at the robot", "looking at the robot: robot.lag",
                 "looking for what it would have shown"):
        assert f"\r\033[K{what}\r" in shown
    assert shown.endswith("\r\033[K") and b"looking" not in done.stdout
    assert command(*words[1:]).stderr == b""


def test_an_effect_that_there_is_not(tmp_path):
    record = write(tmp_path / "good.csv", HEADER, *motion())
    done = command("diagnose", record, "--rig", "ess", "--without", "robot.ghost", "--out", tmp_path / "out")
    assert done.returncode == EXIT_INPUT and b"robot.ghost" in done.stderr


def test_gaps_and_jitter_are_told_and_borne(tmp_path):
    t_s, command_m, robot_m = motion()
    kept = np.r_[0:1500, 1600:4000]
    jittered_s = t_s + 1e-4 * np.random.default_rng(2).uniform(-1, 1, len(t_s))
    record = write(tmp_path / "gaps.csv", HEADER, jittered_s[kept], command_m[kept], robot_m[kept])
    found = diagnose(tmp_path / "out", record, "--rig", "ess")
    assert found["verdict"] == "nothing_detectable"
    assert any("1 gap" in note for note in found["notes"]) and any("jitter" in note for note in found["notes"])


def test_the_library_is_listed():
    done = command("effects", "--json")
    listed = {effect["effect"]: effect for effect in json.loads(done.stdout)}
    assert len(listed) == 40 and listed["robot.backlash"]["parameters"][0]["unit"] == "m"
    assert all(effect["physics"] and effect["source"] for effect in listed.values())
    assert (ROOT / "sim_hal" / "effects" / "robot_backlash.cpp").exists()


def test_an_effect_is_one_file_and_one_line():
    """README's example is the real file, and every file of an effect has its line."""
    folder = ROOT / "sim_hal" / "effects"
    example = (folder / "sensor_drift.cpp").read_text()
    assert f"```cpp\n{example}```" in (ROOT / "README.md").read_text()
    lines = re.findall(r"^    EFFECT\((\w+)\)", (folder / "effects.h").read_text(), re.MULTILINE)
    files = [path.stem for path in folder.glob("*.cpp") if f"effect {path.stem}()" in path.read_text()]
    assert sorted(lines) == sorted(files) and "sensor_drift" in lines
    listed = json.loads(command("effects", "--json").stdout)
    assert [name.replace("_", ".", 1) for name in lines] == [effect["effect"] for effect in listed]
    elsewhere = [path for path in (ROOT / "sim_hal").rglob("*.cpp") if "sensor_drift" in path.read_text()]
    assert [path.name for path in elsewhere] == ["sensor_drift.cpp"]
