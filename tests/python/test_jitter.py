"""Loops that change from tick to tick, from outside: the histogram file, `--jitter` of run, eigen and map, and the
Lyapunov exponent against numpy's product of the loop's matrices over the very losses that a run's log shows."""

import json
import pathlib
import re
import subprocess
import sys

import numpy as np
import pytest
from conftest import EXIT_INPUT, ROOT, command, one_json_object, replay_json, run_json, settings, topic

sys.path.insert(0, str(ROOT / "scripts"))
from loop_matrix import Loop, loop_matrices  # noqa: E402

ESS = Loop(rate_Hz=400, T_R=17.5e-3, T_S=2.5e-3)
SENSOR_BUS, FORCE_ID, RECEIVED, RUNNING = 1, 64, 0, 2


def histogram(counts, **more):
    """What cyclictest --json writes, shortened."""
    cycles = sum(counts.values())
    thread = {"histogram": {str(us): n for us, n in counts.items()}, "cycles": cycles, "min": min(counts),
              "max": max(counts), "avg": 1.0, "cpu": 0}
    return {"file_version": 1, "cmdline:": "cyclictest", "rt_test_version:": "2.40", "num_threads": 1,
            "resolution_in_ns": 0, "thread": {"0": thread}, **more}


@pytest.fixture
def write(tmp_path):
    """A function that writes an object as JSON and returns the path."""
    def writer(value, name="jitter.json"):
        path = tmp_path / name
        path.write_text(value if isinstance(value, str) else json.dumps(value))
        return path
    return writer


def eigen(*arguments):
    """`berth eigen ess --json`: the object."""
    done = command("eigen", "ess", *arguments, "--json")
    assert done.returncode == 0, done.stderr.decode()
    return one_json_object(done.stdout)


# --- the histogram ------------------------------------------------------------------------------------------------
COUNTS = {3: 500, 20: 300, 400: 200}


@pytest.mark.parametrize("value", [
    histogram(COUNTS),
    histogram({1000 * us: n for us, n in COUNTS.items()}, resolution_in_ns=1),
    {"thread": {"0": {"histogram": {"3": 500, "20": 200}}, "1": {"histogram": {"20": 100, "400": 200, "7": 0}}}},
], ids=["us", "ns", "two threads"])
def test_the_loop_wakes_as_late_as_the_histogram_says(value, write, tmp_path):
    result = run_json("ess", tmp_path, "--jitter", write(value))
    tick = topic(result["log"])
    lateness_us, seen = np.unique((tick["woke_ns"] - tick["scheduled_ns"]) / 1000, return_counts=True)
    assert list(lateness_us) == sorted(COUNTS)
    expected = np.array([COUNTS[int(us)] for us in lateness_us]) / 1000
    assert np.abs(seen / len(tick["woke_ns"]) - expected).max() < 4 * np.sqrt(0.25 / len(tick["woke_ns"]))
    assert result["overruns"] == 0
    assert replay_json(result["log"])["equal"] is True


def test_always_as_late_displays_a_step_as_much_later(write):
    def measure(*arguments):
        done = command("deadtime", "ess", "--json", *arguments)
        return one_json_object(done.stdout)["command_to_motion_ms"]
    late = measure("--set", f"run.lateness_file={write(histogram({500: 9}))}")
    assert late - measure() == pytest.approx(0.5, abs=1e-6)


BAD = {
    "not JSON": ("# Histogram\n000003 000120\n", ["is not JSON", "cyclictest"]),
    "half of it": ('{"thread": {"0": {"histogram": {"3": 1', ["is not JSON"]),
    "a list": ([1, 2], ["no histogram", "thread.0.histogram"]),
    "no threads": ({"file_version": 1}, ["no histogram"]),
    "no histogram": ({"thread": {"0": {"cycles": 5}}}, ["no histogram", "--histogram"]),
    "empty": (histogram({0: 0}), ["is empty"]),
    "no entries": ({"thread": {"0": {"histogram": {}}}}, ["is empty"]),
    "negative count": (histogram({3: 5, 4: -1}), ['"4"', "0 or more", "-1"]),
    "a word for a count": ({"thread": {"0": {"histogram": {"3": "many"}}}}, ['"3"', "many"]),
    "negative lateness": (histogram({-3: 5}), ['"-3"', "whole number"]),
    "a word for a lateness": ({"thread": {"0": {"histogram": {"late": 1}}}}, ['"late"', "whole number"]),
    "a lateness that a terminal obeys": ({"thread": {"0": {"histogram": {"l\n\x1b[2Jate": 1}}}}, ['"l??[2Jate"']),
    "such a lateness and no count": ({"thread": {"0": {"histogram": {"l\n\x1b[2Jate": -1}}}}, ['"l??[2Jate"']),
    "more wakes than there can be": (histogram({3: 5, 4: 10**300}), ['"4"', "at most 1e15"]),
    "a whole period": (histogram({3: 5, 2500: 1}), ["2500 us", "period", "missed"]),
    "nothing": ("", ["is not JSON"]),
}


@pytest.mark.parametrize("name", BAD)
def test_a_bad_histogram_is_one_line_that_says_what_is_wrong(name, write, tmp_path):
    value, says = BAD[name]
    path = write(value)
    for words in (["run", "--no-log"], ["eigen"], ["map", "--vary", "mass", "--out", tmp_path / "maps"]):
        done = command(words[0], "ess", *words[1:], "--jitter", path)
        message = done.stderr.decode()
        assert done.returncode == EXIT_INPUT and done.stdout == b"", words
        assert message.startswith(f"berth: {path}: ") and message.count("\n") == 1, message
        assert all(part in message for part in says), message
    assert not (tmp_path / "maps").exists()


def test_a_histogram_that_is_not_there(tmp_path):
    done = command("eigen", "ess", "--jitter", tmp_path / "none.json")
    assert done.returncode == EXIT_INPUT and b"none.json: cannot be read" in done.stderr


def test_wake_ups_beyond_the_histogram_are_told(write):
    value = histogram({3: 95})
    value["thread"]["0"]["cycles"] = 100
    path = write(value)
    assert any("5 of 100" in text for text in eigen("--jitter", path)["varies"])
    done = command("run", "ess", "--no-log", "--set", "run.duration_s=0.1", "--jitter", path)
    assert done.returncode == 0
    assert done.stderr.decode().startswith(f"berth: {path}: 5 of 100 wake-ups are later than")


# --- the picture of histograms ------------------------------------------------------------------------------------
def plotted(*words):
    return subprocess.run([sys.executable, ROOT / "scripts" / "jitter_plot.py", *words], capture_output=True, text=True)


NO_PICTURE = {
    "nothing": ("{}", "has no histogram"),
    "a list": ("[1]", "has no histogram"),
    "no number": ({"thread": {"0": {"histogram": {"late": 1}, "cycles": 1, "min": 0, "avg": 0, "max": 1}}}, "has no histogram"),
    "half of it": ('{"thread"', "is not JSON"),
}


@pytest.mark.parametrize("name", NO_PICTURE)
def test_a_file_that_cannot_be_drawn_is_one_sentence(name, write):
    value, says = NO_PICTURE[name]
    path = write(value)
    done = plotted(path)
    assert done.returncode == EXIT_INPUT and done.stdout == ""
    assert done.stderr.startswith(f"jitter_plot.py: {path}: {says}") and done.stderr.count("\n") == 1


def test_files_that_are_not_there_or_cannot_be_written_are_one_sentence(write, tmp_path):
    assert plotted(tmp_path / "none.json").stderr == f"jitter_plot.py: {tmp_path}/none.json: cannot be read: No such file or directory\n"
    for name in ("none/a.png", "a.xyz"):
        done = plotted(write(histogram(COUNTS)), "--out", tmp_path / name)
        assert done.returncode == EXIT_INPUT and done.stderr.count("\n") == 1
        assert done.stderr.startswith(f"jitter_plot.py: {tmp_path / name}: cannot be written: ")


def test_the_picture_says_whose_wake_ups_they_are_and_no_number_lies_on_a_curve():
    import jitter_plot
    import matplotlib.pyplot as plt
    told = histogram(COUNTS, **{"cmdline:": "cyclictest --histogram=500"})
    first = jitter_plot.of_threads(told, "lone")
    assert jitter_plot.title(told, first, []) == "How late the thread of cyclictest woke"
    assert jitter_plot.title({"thread": {"0": {}}}, first, first) == "How late the thread of lone woke, beside lone"
    assert jitter_plot.title({"berth": {}}, first, []) == "How late the loop woke"
    five = [jitter_plot.Histogram(str(i), 10, {us: 10}, us, us, us + 1) for i, us in enumerate((3, 4, 5, 300, 400))]
    axes = plt.figure(figsize=(7, 6)).add_axes((0.2, 0.4, 0.7, 0.5))
    jitter_plot.draw_percentiles(axes, five, [f"C{i}" for i in range(5)])
    axes.figure.canvas.draw()
    boxes = [text.get_window_extent() for text in axes.texts]
    assert len(boxes) == 5 * (1 + len(jitter_plot.SHARES_DRAWN))
    assert all(box.y1 < axes.xaxis.label.get_window_extent().y0 for box in boxes)
    assert not any(a.overlaps(b) for i, a in enumerate(boxes) for b in boxes[:i])
    plt.close("all")


def test_all_threads_of_a_file_are_one_histogram():
    import jitter_plot
    thread = {"cycles": 500, "min": 3, "max": 3, "avg": 3.0, "histogram": {"3": 500}}
    found, = jitter_plot.of_threads({"thread": {"0": thread, "1": thread | {"max": 9, "avg": 5.0, "histogram": {"3": 499, "9": 1}}}}, "two")
    assert (found.bins, found.count, found.least_us, found.mean_us, found.most_us) == ({3: 999, 9: 1}, 1000, 3, 4.0, 9)


# --- the exponent -------------------------------------------------------------------------------------------------
def test_no_lateness_gives_the_eigenvalue(write):
    told = eigen("--jitter", write(histogram({0: 7})))
    assert told["growth_per_s"] == pytest.approx(eigen()["growth_per_s"], rel=1e-9)
    assert told["eigenvalues"] is None and told["stable"] is True
    assert told["without"]["growth_per_s"] == eigen()["growth_per_s"]


def test_the_seed_decides_and_the_interval_covers_other_seeds(write):
    path = write(histogram({us: 1 for us in range(500)}))
    told = [eigen("--jitter", path, "--seed", seed, "--ticks", 20000) for seed in (1, 1, 2, 3, 4, 5)]
    assert told[0] == told[1]
    growths = [one["growth_per_s"] for one in told[1:]]
    assert len(set(growths)) == 5
    print(f"{np.mean(growths):.6f} /s, scatter {np.std(growths):.1g}, told {told[0]['growth_ci95_per_s']:.1g}")
    assert np.ptp(growths) < 4 * told[0]["growth_ci95_per_s"]


def bump_slope(logarithms):
    """Mean slope of a sequence in 1/tick, free of what swings and of its ends."""
    part = logarithms[len(logarithms) // 8:]
    share = (np.arange(len(part) - 1) + 0.5) / (len(part) - 1)
    weight = np.exp(-0.25 / (share * (1 - share)))
    return (weight * np.diff(part)).sum() / weight.sum()


def height(x, before, z):
    """|a| of the oscillation Re(a z^n) with these two successive values."""
    turned = before * abs(z)
    angle = np.angle(z)
    return np.hypot((x - turned * np.cos(angle)) / np.sin(angle), turned)


@pytest.mark.parametrize("probability", [0.05, 0.3])
def test_lost_forces_grow_as_numpys_product_of_matrices(probability, tmp_path):
    """The losses are read from the log of a run; each tick multiplies by the matrix with the new force or the old."""
    ticks = 20000
    losing = settings({"sensor.loss_probability": probability, "run.release_s": 0, "sensor_channel.stale_after_ms": 1e6})
    log = run_json("ess", tmp_path, *losing, *settings({"run.duration_s": 51}))["log"]
    tick, frame = topic(log), topic(log, "can_frame")
    force = (frame["bus"] == SENSOR_BUS) & (frame["id"] == FORCE_ID) & (frame["direction"] == RECEIVED)
    arrived = np.isin(np.arange(len(tick["index"])), np.round(frame["time_ns"][force] / 2.5e6).astype(int))
    first = np.flatnonzero(tick["state"] == RUNNING)[0]
    assert 0.8 * probability < 1 - arrived[first:].mean() < 1.2 * probability

    received = loop_matrices(ESS)[0]
    lost = received.copy()
    sample = len(received) - 1  # one sample is on its way: what the next tick will use
    lost[sample] = np.eye(len(received))[sample]
    state = np.zeros(len(received))
    state[0] = 1.0
    eigenvalues = np.linalg.eigvals(received)
    z = eigenvalues[np.abs(eigenvalues).argmax()]
    logarithms, scale, before = [], 0.0, 0.0
    for n in range(first, first + ticks):
        size = height(state[0], before, z)
        logarithms.append(scale + np.log(size))
        state, scale, before = state / size, logarithms[-1], state[0] / size
        state = (received if arrived[n + 1] else lost) @ state
    expected = bump_slope(np.array(logarithms)) * 400
    told = eigen(*losing, "--ticks", ticks)
    without = eigen()["growth_per_s"]
    print(f"{probability:.0%} lost: {told['growth_per_s']:.9f} /s, numpy {expected:.9f}, none lost {without:.9f}")
    # The same losses, but another phase of the oscillation at the start, which a loss meets early or late in its swing.
    assert abs(told["growth_per_s"] - expected) < told["growth_ci95_per_s"] < 0.25 * abs(expected - without)


# --- the map ------------------------------------------------------------------------------------------------------
def map_json(folder, *arguments):
    """`berth map ess --json`: the object and the columns of its CSV file."""
    done = command("map", "ess", *arguments, "--json", "--out", folder)
    assert done.returncode == 0, done.stderr.decode()
    assert done.stderr == b""
    result = one_json_object(done.stdout)
    return result, np.genfromtxt(result["csv"], delimiter=",", names=True)


def test_map_without_lateness_has_the_growth_of_the_eigenvalues_twice(write, tmp_path):
    result, columns = map_json(tmp_path, "--vary", "mass", "--grid", "12x8", "--jitter", write(histogram({0: 1})))
    possible = np.isfinite(columns["growth_per_s"])
    assert np.array_equal(possible, np.isfinite(columns["lyapunov_per_s"]))
    error = np.abs(columns["lyapunov_per_s"][possible] / columns["growth_per_s"][possible] - 1)
    print(f"relative differences: median {np.median(error):.1g}, largest {error.max():.1g}")
    assert np.quantile(error, 0.8) < 1e-9
    assert error.max() < 0.01  # where two modes grow nearly alike, 8000 ticks do not part them
    assert abs(result["varying"]["lost_share_of_stable_area"]) < 1e-5


@pytest.mark.slow
def test_map_with_jitter_loses_area_and_its_points_are_those_of_eigen(write, tmp_path):
    path = write(histogram({us: 1 for us in range(0, 2000, 3)}))
    grid = ["--vary", "elasticity", "--grid", "40x20", "--jitter", path]
    result, columns = map_json(tmp_path, *grid)
    steady = columns["growth_per_s"] < 0
    varying = columns["lyapunov_per_s"] < 0
    assert result["varying"]["stable_share"] == pytest.approx(varying.sum() / result["points_possible"])
    lost = result["varying"]["lost_share_of_stable_area"]
    assert lost == pytest.approx((steady.sum() - varying.sum()) / steady.sum(), abs=0.02)  # points are coarse
    fine, _ = map_json(tmp_path / "fine", "--vary", "elasticity", "--grid", "160x60", "--jitter", path, "--ticks", "4000")
    print(f"area lost: {lost:.2%} at 40x20 points, {fine['varying']['lost_share_of_stable_area']:.2%} at 160x60")
    assert 0.02 < lost == pytest.approx(fine["varying"]["lost_share_of_stable_area"], abs=5e-3)
    assert map_json(tmp_path / "2", *grid, "--threads", "1")[1].tobytes() == columns.tobytes()
    # the stable region keeps one border in each row
    for row in (columns["lyapunov_per_s"].reshape(20, 40) < 0)[8:]:
        assert (np.diff(row[np.flatnonzero(row)[0]:].astype(int)) != 0).sum() == 1

    _, columns = map_json(tmp_path, "--x", "object.mass_kg=50:150:3", "--y", "robot.dead_time_ms=15:20:2", "--jitter",
                          path)
    for m, dead_time_ms, told in zip(columns["objectmass_kg"], columns["robotdead_time_ms"],
                                     columns["lyapunov_per_s"]):
        one = eigen("--jitter", path, "--ticks", 8000,
                    *settings({"object.mass_kg": m, "robot.dead_time_ms": dead_time_ms}))
        assert told == pytest.approx(one["growth_per_s"], rel=1e-12)


def test_a_map_that_takes_long_is_announced_and_not_begun(write, tmp_path):
    done = command("map", "ess", "--vary", "mass", "--grid", "3000x3000", "--jitter", write(histogram({3: 1})), "--out",
                   tmp_path / "maps")
    assert done.returncode == EXIT_INPUT and done.stdout == b""
    assert b"9000000 points over 8000 ticks each take about" in done.stderr and b"--yes" in done.stderr
    assert not (tmp_path / "maps").exists()


@pytest.mark.long
def test_picture_shows_both_limits(write, tmp_path):
    result, _ = map_json(tmp_path, "--vary", "elasticity", "--grid", "40x30", "--ticks", "2000", "--jitter",
                         write(histogram({us: 1 for us in range(2000)})))
    done = subprocess.run([sys.executable, "scripts/map_picture.py", result["csv"]], cwd=ROOT, capture_output=True)
    assert done.returncode == 0, done.stderr.decode()
    from matplotlib.image import imread
    red, green, blue = imread(pathlib.Path(result["csv"]).with_suffix(".png"))[..., :3].transpose(2, 0, 1)
    assert ((red > 0.9) & (green < 0.1) & (blue > 0.9)).sum() > 300  # magenta


# --- with a robot preset ------------------------------------------------------------------------------------------
EGM_MS = {"upper": 80, "lower": 40}


def egm_at(end):
    """The settings that the preset abb-egm stands for, at one end of its range of dead times."""
    return settings({"loop.rate_Hz": 250, "robot.dead_time_ms": EGM_MS[end]})


def test_eigen_tells_the_exponent_at_both_ends_of_a_band(write):
    path = write(histogram(COUNTS))
    told = eigen("--robot", "abb-egm", "--jitter", path)
    assert told["robot"]["preset"] == "abb-egm" and told["lower_end"]["dead_time_ms"] == EGM_MS["lower"]
    ends = {end: eigen(*egm_at(end), "--jitter", path) for end in EGM_MS}
    for key in ("growth_per_s", "growth_ci95_per_s", "stable", "ticks"):
        assert told[key] == ends["upper"][key] and told["lower_end"][key] == ends["lower"][key], key
    assert told["without"] == ends["upper"]["without"]
    text = command("eigen", "ess", "--robot", "abb-egm", "--jitter", path).stdout.decode()
    assert f"dead time 40 ms, the lower end: stable, Lyapunov exponent {told['lower_end']['growth_per_s']:.6f}" in text


@pytest.mark.long
def test_map_has_the_band_without_jitter_and_exponents_at_the_upper_end(write, tmp_path):
    what = ["--vary", "mass", "--grid", "12x8", "--jitter", write(histogram(COUNTS))]
    told, columns = map_json(tmp_path / "band", *what, "--robot", "abb-egm")
    ends = {end: map_json(tmp_path / end, *what, *egm_at(end)) for end in EGM_MS}
    for column, end, same in [("spectral_radius", "upper", "spectral_radius"),
                              ("lyapunov_per_s", "upper", "lyapunov_per_s"),
                              ("spectral_radius_low", "lower", "spectral_radius")]:
        assert np.array_equal(columns[column], ends[end][1][same], equal_nan=True), column
    assert told["varying"] == ends["upper"][0]["varying"]
    assert told["lower_end"]["stable_share"] == ends["lower"][0]["stable_share"] != told["stable_share"]
    done = subprocess.run([sys.executable, "scripts/map_picture.py", told["csv"]], cwd=ROOT, capture_output=True)
    assert done.returncode == 0, done.stderr.decode()


def test_run_predicts_for_a_preset_with_jitter(write, tmp_path):
    result = run_json("ess", tmp_path, "--no-log", "--robot", "abb-egm", "--jitter", write(histogram(COUNTS)))
    assert result["robot"]["preset"] == "abb-egm"
    assert result["growth_per_s"] == pytest.approx(result["prediction"]["growth_per_s"], rel=2e-3)


# --- the prediction of a run --------------------------------------------------------------------------------------
@pytest.mark.parametrize("values", [{"robot.jitter_ms": 0.5}, {"sensor.loss_probability": 0.2},
                                    {"robot.clock": "free", "robot.clock_phase_ms": 1.0}])
def test_run_predicts_with_the_exponent(values, tmp_path):
    result = run_json("ess", tmp_path, "--no-log", *settings(values))
    steady = eigen()["growth_per_s"]
    print(f"{values}: measured {result['growth_per_s']:.6f}, predicted {result['prediction']['growth_per_s']:.6f} /s")
    assert result["growth_per_s"] == pytest.approx(result["prediction"]["growth_per_s"], rel=2e-3)
    assert abs(result["growth_per_s"] - steady) > abs(result["growth_per_s"] - result["prediction"]["growth_per_s"])


def test_a_histogram_without_the_least_the_mean_and_the_largest_tells_them(tmp_path):
    path = tmp_path / "short.json"
    path.write_text(json.dumps({"thread": {"0": {"histogram": {"8": 120, "9": 77}, "cycles": 197}}}))
    words = [sys.executable, ROOT / "scripts" / "jitter_plot.py", path, "--out", tmp_path / "short.png"]
    told = subprocess.run(words, capture_output=True, text=True, check=True).stdout
    assert re.search(r"short +197 +8\.0 +8\.4 +9 .* 9\.0\n", told) and (tmp_path / "short.png").exists()
