"""Force sensors of several frames a sample and of a rate of their own: cantools is the peer for what the bits mean, and
samples are put together here once more, from the candump text of a run."""

import ctypes
import json
import random
import subprocess

import cantools
import numpy as np
import pytest
from conftest import DBC, ROOT, command, run_json, settings, topic

# Rig key -> messages of a sample in their order, as in berth.dbc.
LAYOUTS = {
    "one_frame": ["force"],
    "two_frames_intel": ["wrench2i_force", "wrench2i_torque"],
    "two_frames_motorola": ["wrench2m_force", "wrench2m_torque"],
    "three_frames_intel": ["wrench3i_fx_fy", "wrench3i_fz_tx", "wrench3i_ty_tz"],
    "three_frames_motorola": ["wrench3m_x", "wrench3m_y", "wrench3m_z"],
    "two_frames_unnumbered": ["wrench2u_force", "wrench2u_torque"],
    "two_frames_unnumbered_split": ["wrench2s_first", "wrench2s_second"],
}
SEVERAL_FRAMES = [name for name in LAYOUTS if name != "one_frame"]
UNNUMBERED = [name for name in LAYOUTS if "unnumbered" in name]
NUMBERED_FRAMES = [name for name in SEVERAL_FRAMES if name not in UNNUMBERED]
STEP_N = {"two_frames_intel": 1e-2, "two_frames_motorola": 2e-2, "three_frames_intel": 1e-4,
          "three_frames_motorola": 1e-5, "two_frames_unnumbered": 1e-2, "two_frames_unnumbered_split": 2e-2}
# A sensor that has no bit for saturation is at the end of its range.
NO_BIT = {"wrench2i_force": 327, "wrench2u_force": 327}
PERIOD_us = 2500
DELAY_us = 2500  # from a sample to the end of its last frame, in the rig ess
AXES = "xyz"
SEED = random.SystemRandom().randrange(1 << 32)


@pytest.fixture(scope="module")
def dbc():
    return cantools.database.load_file(DBC)


# --- the bits, by cantools ---------------------------------------------------------------------------------------
class Wrench(ctypes.Structure):
    _fields_ = [("force_N", ctypes.c_double * 3), ("torque_N_m", ctypes.c_double * 3), ("saturated", ctypes.c_uint8)]


DECODE = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_char_p, ctypes.POINTER(Wrench))


class SensorFrame(ctypes.Structure):
    _fields_ = [("id", ctypes.c_uint32), ("counter_byte", ctypes.c_uint8), ("counter_mask", ctypes.c_uint8),
                ("decode", DECODE)]


class LayoutRow(ctypes.Structure):
    _fields_ = [("frame_count", ctypes.c_uint8), ("axis_count", ctypes.c_uint8), ("force_max_N", ctypes.c_double),
                ("torque_max_N_m", ctypes.c_double),
                ("force_step_N", ctypes.c_double), ("frames", SensorFrame * 3)]


@pytest.fixture(scope="module")
def firmware_layouts(tmp_path_factory):
    """The firmware's own table of layouts, compiled for this test: {layout: row}."""
    library = tmp_path_factory.mktemp("layouts") / "layouts.so"
    sources = [ROOT / "firmware" / "sensor_layout.c", ROOT / "firmware" / "can" / "berth_can.c"]
    subprocess.run(["gcc", "-std=c11", "-O1", "-shared", "-fPIC", "-o", library, *sources], check=True)
    table = (LayoutRow * len(LAYOUTS)).in_dll(ctypes.CDLL(str(library)), "sensor_layouts")
    return dict(zip(LAYOUTS, table, strict=True))


def place(wrench, signal):
    """Where a signal of the DBC belongs: fx_N, ty_N_m; the one force of one_frame counts as x."""
    axis = AXES.index(signal[1]) if signal != "force_N" else 0
    return (wrench.torque_N_m if signal.startswith("t") else wrench.force_N)[axis]


def random_values(message, draw):
    """A value of each signal, on the wire's grid and within its range; ends of the range among them."""
    values = {}
    for signal in message.signals:
        low, high = (round((end - signal.offset) / signal.scale) for end in (signal.minimum, signal.maximum))
        raw = draw.choice([low, high, min(max(0, low), high), draw.randint(low, high), draw.randint(low, high)])
        values[signal.name] = raw * signal.scale + signal.offset
    return values


@pytest.mark.parametrize("layout", LAYOUTS)
def test_the_firmware_decodes_what_cantools_encodes(layout, dbc, firmware_layouts):
    draw = random.Random(SEED)
    row = firmware_layouts[layout]
    assert row.frame_count == len(LAYOUTS[layout])
    for frame, name in zip(row.frames, LAYOUTS[layout]):
        message = dbc.get_message_by_name(name)
        assert (frame.id, message.length) == (message.frame_id, 8)
        for _ in range(500):
            values = random_values(message, draw)
            data = message.encode(values)
            wrench = Wrench()
            assert frame.decode(data, wrench) == 1, f"seed {SEED}: {name} {values}"
            for signal, value in values.items():
                if signal.endswith(("_N", "_m")):
                    assert place(wrench, signal) == pytest.approx(value, abs=1e-9), f"seed {SEED}: {name} {values}"
            counter = int(values.get("counter", 0)) & frame.counter_mask
            assert data[frame.counter_byte] & frame.counter_mask == counter, f"seed {SEED}: {name} {values}"
            at_end = name in NO_BIT and any(abs(values[f"f{axis}_N"]) >= NO_BIT[name] - 1e-9 for axis in AXES)
            saturated = values.get("saturated", values.get("overload", at_end)) != 0
            assert wrench.saturated == int(saturated), f"seed {SEED}: {name} {values}"


def test_a_torque_across_two_frames_is_one_number(dbc, firmware_layouts):
    first, second = (dbc.get_message_by_name(name) for name in LAYOUTS["two_frames_unnumbered_split"])
    row = firmware_layouts["two_frames_unnumbered_split"]
    for raw in [-32000, -257, -256, -255, -1, 0, 1, 255, 256, 32000, -32001, 32001]:
        wrench = Wrench()
        high, low = divmod(raw, 256)
        values = {"response": 11, "tx_high_N_m": high * 0.128, "tx_low_N_m": low * 0.0005}
        data = [message.encode({signal.name: values.get(signal.name, 0) for signal in message.signals})
                for message in (first, second)]
        assert data[0][7] == high & 0xFF and data[1][0] == low
        assert row.frames[0].decode(data[0], wrench) == 1
        assert row.frames[1].decode(data[1], wrench) == (abs(raw) <= 32000)
        if abs(raw) <= 32000:
            assert wrench.torque_N_m[0] == pytest.approx(raw * 0.0005, abs=1e-12)


@pytest.mark.parametrize("layout", LAYOUTS)
def test_a_signal_beyond_its_range_is_refused(layout, dbc, firmware_layouts):
    for frame, name in zip(firmware_layouts[layout].frames, LAYOUTS[layout]):
        message = dbc.get_message_by_name(name)
        for signal in message.signals:
            for end, step in ((signal.minimum, -signal.scale), (signal.maximum, signal.scale)):
                if signal.name.endswith(("_N", "_m")) and not signal.name.startswith(("tx_high", "tx_low")):
                    values = {other.name: other.minimum for other in message.signals} | {signal.name: end + step}
                    assert frame.decode(message.encode(values, strict=False), Wrench()) == 0, (name, values)


# --- a run, by cantools ------------------------------------------------------------------------------------------
def candump(log):
    """(us, id, data) of each line of the sensor bus beside a log."""
    words = (line.split() for line in log.with_suffix(".sensor.candump.log").read_text().splitlines())
    return [(round(float(time.strip("()")) * 1e6), int(frame.split("#")[0], 16), bytes.fromhex(frame.split("#")[1]))
            for time, _, frame in words]


def whole_samples(log, dbc, layout, axis, rate_Hz=0):
    """Arrival in us and force of each sample all of whose messages came, one after the other with one counter; if the
    layout has none, nearest to the time at which the sensor sent that sample."""
    messages = {dbc.get_message_by_name(name).frame_id: dbc.get_message_by_name(name) for name in LAYOUTS[layout]}
    samples, parts = [], {}
    for time_us, identifier, data in candump(log):
        signals = messages[identifier].decode(data)
        if layout in UNNUMBERED:
            signals["counter"] = round((time_us - DELAY_us) * (rate_Hz or 400) * 1e-6)
        if parts and signals["counter"] != parts["counter"]:
            parts = {}
        parts |= signals
        axes = {name[:2] for name in parts if name.endswith(("_N", "_m")) and not name.startswith("tx_high")}
        if len(axes) == (1 if layout == "one_frame" else 6):
            samples.append((time_us, parts["force_N" if layout == "one_frame" else f"f{axis}_N"]))
            parts = {}
    return samples


def check_forces(log, samples):
    """At each tick the log has the newest whole sample that had arrived, and its age."""
    tick = topic(log)
    times = np.array([time for time, _ in samples])
    at = np.searchsorted(times, tick["timestamp"], side="right") - 1
    there = at >= 0
    expected = np.array([force for _, force in samples])[at[there]]
    np.testing.assert_allclose(tick["force_N"][there], expected, rtol=0, atol=1e-9)
    ages_us = tick["timestamp"][there] - times[at[there]]
    np.testing.assert_allclose(tick["force_frame_age_ns"][there] / 1000, ages_us, rtol=0, atol=1.1)
    np.testing.assert_array_equal(tick["force_samples"][there], at[there] + 1)


@pytest.mark.parametrize("rate_Hz", [0, 1000, 333, 250])
@pytest.mark.parametrize("layout", LAYOUTS)
def test_each_tick_uses_the_newest_whole_sample(layout, rate_Hz, logs, dbc):
    axis = AXES[(len(layout) + rate_Hz) % 3]
    result, log = logs("ess", {"run.duration_s": 5, "sensor_channel.layout": layout, "sensor.rate_Hz": rate_Hz,
                               "sensor_channel.axis": axis})
    assert result["torn_samples"] == result["frames_rejected"] == result["frames_lost"] == 0
    samples = whole_samples(log, dbc, layout, axis, rate_Hz)
    assert len(samples) == pytest.approx(5 * (rate_Hz or 400), abs=5)
    check_forces(log, samples)
    assert np.ptp(topic(log)["force_N"]) > 30


@pytest.mark.parametrize("layout", NUMBERED_FRAMES)
def test_torn_samples_are_found_and_counted_where_the_bus_loses_frames(layout, logs, dbc):
    """Samples begun and never whole, counted here from the text of the bus."""
    result, log = logs("ess", {"run.duration_s": 10, "sensor_channel.layout": layout, "bus.loss_probability": 0.05})
    samples = whole_samples(log, dbc, layout, "z")
    counters = [identifier_data[2] for identifier_data in candump(log)]
    begun = 1 + sum(number(layout, a) != number(layout, b) for a, b in zip(counters, counters[1:]))
    assert result["force_samples"] == len(samples)
    assert abs(result["torn_samples"] - (begun - len(samples))) <= 1  # the last one may still be coming
    assert result["torn_samples"] > 200
    check_forces(log, samples)


@pytest.mark.parametrize("layout", UNNUMBERED)
def test_without_a_number_each_sample_that_lost_one_frame_is_suspected(layout, logs, dbc):
    """The frames that the bus lost, from its text: sample k is there at its own time. Two samples in a row, the first
    without its end and the second without its begin, may count as one; a sample that lost both frames is not seen."""
    loss = 0.05
    result, log = logs("ess", {"run.duration_s": 10, "sensor_channel.layout": layout, "bus.loss_probability": loss})
    first = dbc.get_message_by_name(LAYOUTS[layout][0]).frame_id
    here = {}
    for time_us, identifier, _ in candump(log):
        here.setdefault((time_us + PERIOD_us // 4) // PERIOD_us, []).append(identifier)
    slots = range(min(here), max(here) + 1)
    torn = [k for k in slots if len(here.get(k, [])) == 1]
    one_gap = sum(here[k] == [first] and k + 1 in torn and here[k + 1] != [first] for k in torn)
    unseen = sum(k not in here for k in slots)
    assert result["torn_samples"] == result["frames_rejected"] == 0  # frames_lost: the robot's, which are numbered
    assert result["suspected_torn_samples"] == pytest.approx(len(torn) - one_gap, abs=1)  # the last is not judged yet
    assert one_gap + unseen <= 5 * 2 * loss**2 * len(slots)
    assert len(torn) > 300
    assert result["force_samples"] == sum(len(there) == 2 for there in here.values())
    check_forces(log, whole_samples(log, dbc, layout, "z"))


def test_a_run_says_that_torn_samples_are_suspected():
    done = command("run", "ess", "--no-log", *settings({
        "sensor_channel.layout": "two_frames_unnumbered", "bus.loss_probability": 0.01, "run.duration_s": 2}))
    line = next(line for line in done.stdout.decode().splitlines() if line.startswith("  force "))
    assert "rejected as suspected torn (frames without a number)" in line


@pytest.mark.parametrize("given, message", [
    ({"sensor_channel.pairing_window_ms": 0.1}, "is shorter than the frames of a sample take on the bus"),
    ({"sensor.rate_Hz": 1600}, "must be at most half of the time between two samples"),
    ({"sensor_channel.pairing_window_ms": 0}, "sensor_channel.pairing_window_ms"),
])
def test_a_window_that_cannot_work_is_refused(given, message):
    done = command("run", "ess", "--no-log", *settings({"sensor_channel.layout": "two_frames_unnumbered"} | given))
    assert done.returncode == 2
    assert "sensor_channel.pairing_window_ms" in done.stderr.decode() and message in done.stderr.decode()


def number(layout, data):
    return data[6] if layout == "two_frames_intel" else data[7] & (0x0F if layout == "three_frames_motorola" else 0xFF)


# --- the motion --------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("layout", SEVERAL_FRAMES)
def test_a_layout_changes_nothing_but_the_steps_of_the_force(layout, logs):
    """The loop of a one-frame sensor with the same resolution makes the same motion."""
    _, log = logs("ess", {"run.duration_s": 5, "sensor_channel.layout": layout})
    _, plain = logs("ess", {"run.duration_s": 5, "sensor.resolution_N": STEP_N[layout]})
    ours, theirs = topic(log), topic(plain)
    np.testing.assert_allclose(ours["force_N"], theirs["force_N"], rtol=0, atol=1e-7)
    np.testing.assert_allclose(ours["manipulator_position_m"], theirs["manipulator_position_m"], rtol=0, atol=1e-9)


@pytest.mark.parametrize("rate_Hz", [1000, 800, 333, 250])
def test_a_run_grows_as_the_model_says_at_each_rate(rate_Hz, logs):
    result, _ = logs("ess", {"sensor.rate_Hz": rate_Hz, "sensor_channel.layout": "three_frames_motorola",
                             "run.duration_s": 20})
    assert result["growth_per_s"] == pytest.approx(result["prediction"]["growth_per_s"], rel=5e-4)


def test_a_slow_sensor_is_an_older_force():
    """Older by half a sample period in the mean: below the manipulator's own frequency dead time damps."""
    growth = {}
    for rate_Hz in (400, 250, 100):
        done = command("eigen", "ess", "--json", *settings({"sensor.rate_Hz": rate_Hz}))
        growth[rate_Hz] = json.loads(done.stdout)["growth_per_s"]
    assert growth[400] > growth[250] > growth[100]


# --- what does not fit -------------------------------------------------------------------------------------------
def test_a_run_tells_of_samples_and_their_age():
    done = command("run", "ess", "--no-log", *settings({"sensor.rate_Hz": 1000, "run.duration_s": 2}))
    assert "1996 samples, 0 torn ones rejected; arrived 0.000 to 0.500 ms before their use" in done.stdout.decode()


@pytest.mark.long
def test_a_force_whose_age_changes_is_not_judged(tmp_path):
    """Its held samples are the sensor's own; they had been told as dropouts."""
    made = run_json("ess", tmp_path, *settings({"run.duration_s": 5, "sensor.rate_Hz": 333}))
    rig = tmp_path / "rig.toml"
    rig.write_bytes(command("run", "ess", "--print-config", "--set", "sensor.rate_Hz=333").stdout)
    done = command("diagnose", made["log"], "--rig", rig, "--out", tmp_path)
    told = done.stdout.decode()
    assert told.startswith("verdict: nothing_detectable\n") and "sensor.rate_Hz = 333" in told
    assert "\nrobot: nothing_detectable\n" in told and "\nforce:" not in told
