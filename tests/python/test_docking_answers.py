"""`run`, `eigen`, `limits` and `check` give one answer to "will my rig blow up?": the same verdict and exit code. What a
docking tool does is read off long runs without noise on both sides of each limit."""

import json
import re
import sys
import tomllib

import numpy as np
import pytest
from answers import COMMANDS, answers, ask
from conftest import EXIT_DIFFERENT, EXIT_DONE, ROOT, command, settings

sys.path.insert(0, str(ROOT / "scripts"))
from berth_log import read_log  # noqa: E402

# A tool bounces on a spring of its own, without damping: each flight ends as it began, and what a bounce does to the
# energy adds up. At 1400 N/m a bounce loses; from 1475 N/m on it gains; from 1558 N/m on a tool in contact grows.
DOCK = """
[run]
duration_s = 40
release_s = 0.1
[loop]
rate_Hz = 500
[manipulator]
mass_kg = 90
stiffness_N_per_m = 100
damping_N_s_per_m = 0
initial_position_m = -0.02
[robot]
dead_time_ms = 34
interpolation = "linear"
[sensor]
delay_ms = 2
low_pass_frequency_Hz = 150
[object]
kind = "contact"
mass_kg = 1
stiffness_N_per_m = 1400
damping_N_s_per_m = 60
"""
FREE = DOCK.replace("stiffness_N_per_m = 100\n", "stiffness_N_per_m = 0\n").replace(
    "initial_position_m = -0.02", "initial_position_m = -0.02\ninitial_velocity_m_per_s = 0.05").replace(
    "duration_s = 40", "duration_s = 8")
PRESSED = DOCK.replace("stiffness_N_per_m = 100\ndamping_N_s_per_m = 0", "stiffness_N_per_m = 6000\ndamping_N_s_per_m = 120")
# As heavy a tool, a third of the manipulator: in free flight its inertia makes a mode at 110 Hz grow by 6.98 /s, although
# in contact all decays.
FLYING = """
[run]
duration_s = 20
[loop]
rate_Hz = 500
[manipulator]
mass_kg = 120
stiffness_N_per_m = 8000
damping_N_s_per_m = 100
initial_position_m = -0.01
[robot]
dead_time_ms = 34
[sensor]
delay_ms = 2
low_pass_frequency_Hz = 100
[object]
kind = "contact"
mass_kg = 40
stiffness_N_per_m = 50000
damping_N_s_per_m = 3000
[profile]
kind = "minimum_jerk"
offset_m = -0.01
amplitude_m = 0.02
duration_s = 10
"""
GAINS = {"object.stiffness_N_per_m": 1500}
NOTHING = """
[manipulator]
mass_kg = 150
stiffness_N_per_m = 6000
damping_N_s_per_m = 120
initial_position_m = 0.005
[robot]
dead_time_ms = 34
[object]
kind = "none"
"""


def changes(advice, beyond=1.0):
    """The setting that an advice names, taken farther by a factor."""
    found = re.match(r"([a-z_]+\.[A-Za-z_]+) (above|below) ([0-9.e+-]+)", advice)
    value = float(found[3]) * (beyond if found[2] == "above" else 1 / beyond)
    return settings({found[1]: value})


def flight_peaks_m(path, tmp_path, *more):
    """How far the tool flies from the surface after each bounce."""
    command("run", path, "--out", tmp_path / "log", *more, check=True)
    log = read_log(tmp_path / "log" / "my.ulg")
    x = -log.tick["manipulator_position_m"][log.tick["state"] == 2]
    tops = (x[1:-1] > x[:-2]) & (x[1:-1] >= x[2:]) & (x[1:-1] > 0.0)
    return x[1:-1][tops]


def test_a_map_counts_no_point_stable_whose_bounces_gain_energy(write_rig, tmp_path):
    """From 1475 N/m on, at the rig's damping; of the last two points the tool in contact grows as well."""
    done = command("map", write_rig(DOCK), "--json", "--out", tmp_path, "--x", "object.stiffness_N_per_m=1350:1650:7",
                   "--y", "object.damping_N_s_per_m=59:60:2", check=True)
    told = json.loads(done.stdout)
    columns = np.genfromtxt(told["csv"], delimiter=",", names=True)
    stays, gains = columns["growth_per_s"] < 0.0, columns["restitution"] > 1.0
    assert (stays & gains).any() and told["stable_share"] == pytest.approx((stays & ~gains).mean())


@pytest.mark.long
@pytest.mark.parametrize("text, values, verdict, stable", [
    (DOCK, {}, "stable", True),
    (DOCK, GAINS, "unstable", False),
    (DOCK, {"object.stiffness_N_per_m": 1800}, "unstable", False),
    (FREE, {}, "stable", True),
    (FREE, GAINS, "unstable", False),
    (FREE, {"object.stiffness_N_per_m": 8000}, "unstable", False),
    (PRESSED, {}, "stable", True),
    (PRESSED, {"object.stiffness_N_per_m": 80000, "object.damping_N_s_per_m": 20}, "unstable", False),
    (DOCK, {"object.surface_position_m": 0.5}, "undetermined", None),
    (FLYING, {}, "unstable", False),
    (FLYING, {"object.mass_kg": 36}, "stable", True),
    (FLYING, {"object.surface_position_m": 0.3}, "unstable", False),
    (FLYING, {"profile.duration_s": 2}, "unstable", False),
])
def test_four_commands_agree_on_a_docking_rig(write_rig, text, values, verdict, stable):
    path = write_rig(text)
    told = answers(path, *settings(values))
    assert {told[name]["verdict"] for name in ("eigen", "limits", "check")} == {verdict}
    assert told["run"]["stable"] is stable
    assert (told["run"]["verdict"] == "unstable") is (verdict == "unstable")
    if values == GAINS:
        assert "of its speed: energy is gained" in told["eigen"]["because"]
        assert told["eigen"]["bounce"]["restitution"] > 1.0 and told["run"]["bounces"]["restitution"] > 1.0


@pytest.mark.parametrize("method, values", [
    ("prediction", {"object.stiffness_N_per_m": 80000, "object.damping_N_s_per_m": 20}),
    ("force-lead", {"object.stiffness_N_per_m": 80000, "object.damping_N_s_per_m": 20}),
    ("extrapolation-1", {"object.stiffness_N_per_m": 2500, "object.damping_N_s_per_m": 200}),
])
def test_four_commands_agree_on_a_docking_rig_with_compensation(write_rig, method, values):
    told = answers(write_rig(PRESSED), "--with", method, *settings(values))
    gains = told["eigen"]["bounce"]["restitution"] > 1.0
    assert told["eigen"]["stable"] is not gains


@pytest.mark.long
def test_a_map_grows_where_only_free_flight_does(write_rig, tmp_path):
    """At the first mass both decay."""
    path = write_rig(FLYING)
    done = command("map", path, "--json", "--out", tmp_path, "--x", "object.mass_kg=34:46:3", "--y",
                   "object.damping_N_s_per_m=2900:3000:2", check=True)
    columns = np.genfromtxt(json.loads(done.stdout)["csv"], delimiter=",", names=True)
    for point in columns:
        told, _ = ask("eigen", path, *settings({name.replace("object", "object."): point[name]
                                                for name in ("objectmass_kg", "objectdamping_N_s_per_m")}))
        assert told["prediction"]["growth_per_s"] == pytest.approx(point["growth_per_s"], rel=1e-6)
    assert (columns["growth_per_s"] > 0).tolist() == [False, True, True] * 2


def test_a_tool_in_free_flight_grows_as_predicted(write_rig, tmp_path):
    """Of the force, whose growth is that of what is fast in it: seen between the noise of numbers and the limits."""
    free = {"object.surface_position_m": 0.3, "profile.kind": "rest", "manipulator.initial_position_m": 0.001, "run.duration_s": 2}
    path = write_rig(FLYING.split("[profile]")[0])
    told, _ = ask("eigen", path, *settings(free))
    assert told["prediction"]["source"] == "free_flight"
    gripped = {"object.kind": "gripped", "object.stiffness_N_per_m": 0, "object.damping_N_s_per_m": 0}
    assert told["prediction"]["growth_per_s"] == pytest.approx(ask("eigen", path, *settings(gripped))[0]["growth_per_s"])
    command("run", path, "--out", tmp_path / "log", *settings(free), check=True)
    log = read_log(tmp_path / "log" / "my.ulg")
    fast = np.diff(log.tick["force_N"], 4)
    windows = [np.sqrt(np.mean(fast[n:n + 100] ** 2)) for n in (200, 400, 600, 800)]
    grown_per_s = np.diff(np.log(windows)) / (200 / 500)
    print(f"seen {grown_per_s}, predicted {told['prediction']['growth_per_s']:.4f} /s")
    assert grown_per_s[1] == pytest.approx(told["prediction"]["growth_per_s"], rel=0.02)


def test_what_cures_a_tool_without_damping_is_said(write_rig):
    """Damping of 0 has no factor that leads to the limit; the docking case needs one of 37."""
    undamped = DOCK.replace("damping_N_s_per_m = 60", "damping_N_s_per_m = 0")
    told, _ = ask("eigen", write_rig(undamped), *settings({"object.stiffness_N_per_m": 900}))
    assert told["stable"] is False
    cured = settings({"object.stiffness_N_per_m": 900}) + changes(told["advice"], beyond=1.02)
    assert ask("eigen", write_rig(undamped), *cured)[0]["stable"] is True


@pytest.mark.parametrize("key", ["object.stiffness_N_per_m", "robot.dead_time_ms", "object.damping_N_s_per_m"])
def test_bounces_gain_energy_beyond_the_limit_and_lose_it_before(write_rig, tmp_path, key):
    """Heights of flight in runs: no sum of the program's own."""
    path = write_rig(DOCK)
    told, _ = ask("limits", path)
    parameter = told["parameters"][key]
    side, away = ("above", 1.03) if parameter["above"] else ("below", 1 / 1.03)
    limit = parameter[side]["value"]
    assert parameter[side]["mode"] == "a bounce gains energy"
    for value, grows in ((limit / away, False), (limit * away, True)):
        peaks_m = flight_peaks_m(path, tmp_path, *settings({key: value}))
        assert len(peaks_m) > 5
        assert (np.diff(peaks_m) > 0).all() if grows else (np.diff(peaks_m) < 0).all()
        assert answers(path, *settings({key: value}), commands=("run", "eigen"))["run"]["stable"] is not grows


@pytest.mark.parametrize("text, values", [
    (DOCK, {"object.stiffness_N_per_m": 1500}),
    (DOCK, {"object.stiffness_N_per_m": 1800}),
    (FREE, {"object.stiffness_N_per_m": 8000}),
    (PRESSED, {"object.stiffness_N_per_m": 80000, "object.damping_N_s_per_m": 20}),
])
def test_advice_for_a_docking_rig_cures_it(write_rig, text, values):
    path = write_rig(text)
    told, code = ask("eigen", path, *settings(values))
    assert code == EXIT_DIFFERENT
    cured = settings(values) + changes(told["advice"])
    for name in ("eigen", "check"):
        assert ask(name, path, *cured)[0]["stable"] is True, told["advice"]
    cured = settings(values) + changes(told["advice"], beyond=1.02)
    assert ask("run", path, *cured)[0]["stable"] is True, told["advice"]


def restitution_by_itself(mass_kg, spring_N_per_m, stiffness_N_per_m, damping_N_s_per_m, delay_s):
    """Of a mass on a spring that is relaxed at a wall, which never pulls and is felt late: M x'' = -K x - F(t - delay), in
    steps of 20 us."""
    step_s = 2e-5
    late = round(delay_s / step_s)
    x, v, forces_N, quiet = 0.0, 0.1, [0.0] * late, 0
    while quiet <= late:  # until the last push has been felt
        push_N = max(0.0, stiffness_N_per_m * x + damping_N_s_per_m * v) if x >= 0.0 else 0.0
        quiet = 0 if push_N > 0.0 else quiet + 1
        forces_N.append(push_N)
        v -= step_s * (forces_N[-late - 1] + spring_N_per_m * x) / mass_kg
        x += step_s * v
    return np.sqrt(v**2 + spring_N_per_m / mass_kg * x**2) / 0.1


# No low-pass and hardly a tool: all the delay there is are 34 ms, 2 ms, and half a period that the force is held.
TAPPING = {"sensor.low_pass_order": 0, "object.mass_kg": 0.01, "object.stiffness_N_per_m": 1000}


@pytest.mark.long
@pytest.mark.parametrize("profile, is_driven", [({}, False), ({"profile.kind": "triangle", "profile.amplitude_m": 0.01, "profile.duration_s": 1}, True),
                                                ({"profile.kind": "multisine", "profile.amplitude_m": 0.01, "profile.frequency_end_Hz": 1}, True)],
                         ids=["rests", "triangle", "multisine"])
def test_taps_that_an_operator_drives_do_not_tell_what_a_bounce_does(write_rig, profile, is_driven):
    """His work is in the speeds: more than 1 of a bounce that by itself returns 0.9."""
    told = answers(write_rig(DOCK), *settings(TAPPING | profile), commands=("run", "eigen"))
    by_itself = restitution_by_itself(90.0, 100.0, 1000.0, 60.0, 0.034 + 0.002 + 0.001)
    print(told["run"]["because"], by_itself)
    assert told["eigen"]["bounce"]["restitution"] == pytest.approx(by_itself, abs=0.01)
    assert told["run"]["bounces"]["driven"] is is_driven and told["run"]["stable"] is True
    if is_driven:
        assert "the operator's work is in it" in told["run"]["because"]
    else:
        assert told["run"]["bounces"]["restitution"] == pytest.approx(by_itself, abs=0.01)


@pytest.mark.long
def test_margin_of_a_docking_rig_ends_where_bounces_gain(write_rig):
    path = write_rig(DOCK)
    told = answers(path)
    margins_ms = {told[name]["margin"]["dead_time_margin_ms"] for name in COMMANDS}
    assert max(margins_ms) - min(margins_ms) < 1e-9
    own_ms = tomllib.loads(DOCK)["robot"]["dead_time_ms"]
    for share, stable in ((0.95, True), (1.05, False)):
        longer = settings({"robot.dead_time_ms": own_ms + share * min(margins_ms)})
        answer = answers(path, *longer, commands=("run", "eigen", "check"))
        assert answer["run"]["stable"] is stable


def test_a_robot_that_touches_nothing_has_any_margin(write_rig):
    path = write_rig(NOTHING)
    for name in ("run", "eigen", "limits"):
        told, code = ask(name, path, "--margin-ms", "500")
        assert code == EXIT_DONE
        assert told["margin"]["unlimited"] is True and "nothing feeds back" in told["margin"]["note"]
    assert answers(path)["check"]["margin"]["unlimited"] is True
    shown = command("eigen", path).stdout.decode()
    assert "no limit: nothing feeds back" in shown and "modulus" not in shown
