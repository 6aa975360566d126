"""`--robot`: presets against the table that they come from, bands against maps of their ends, and what is refused."""

import math
import pathlib
import sys

import numpy as np
import pytest
from conftest import EXIT_INPUT, ROOT, command, one_json_object, replay_json, run_json, settings

sys.path.insert(0, str(ROOT / "scripts"))
import map_picture  # noqa: E402
from berth_map import read_map  # noqa: E402
from loop_matrix import Loop, loop_matrices  # noqa: E402
from matplotlib.image import imread  # noqa: E402

# What is reported: period, dead time from command to motion, delay in the force path; ms. None: the rig's own.
TABLE = {
    "krenn-50hz": (20, (40, 40), 20),
    "krenn-400hz": (2.5, (17.5, 17.5), 2.5),
    "kuka-rsi-krc2": (12, (120, 120), None),
    "abb-egm": (4, (40, 80), None),
    "ur10e-servoj": (2, (34, 34), None),
    "ur5cb3-servoj": (8, (35, 35), None),
    "yaskawa-dx100": (20, (150, 150), None),
    "yaskawa-dx200": (20, (250, 250), None),
    "ethercat-csp": (None, "3 periods", None),
    "franka-fci": (1, (1, 1), None),  # "below 1 ms": the bound
    "parallel-1khz": (1, (1, 1), 3),  # command to motion is not reported: one period
}
ESS_PERIOD_ms, ESS_FORCE_ms = 2.5, 2.5
PLUS_DRIVE_LAG = {"ethercat-csp", "franka-fci"}


def ask(*arguments):
    """`berth ... --json`: the object."""
    done = command(*arguments, "--json")
    assert done.returncode == 0, done.stderr.decode()
    return one_json_object(done.stdout)


def expected(name):
    """Period, both ends of the dead time and force delay in ms that `ess` gets from a preset."""
    period_ms, dead_time_ms, force_ms = TABLE[name]
    period_ms = period_ms or ESS_PERIOD_ms
    if dead_time_ms == "3 periods":
        dead_time_ms = (3 * period_ms,) * 2
    return period_ms, dead_time_ms, force_ms or ESS_FORCE_ms


def config_of(*arguments):
    """The resolved rig as {key: text}."""
    done = command("run", *arguments, "--print-config")
    assert done.returncode == 0, done.stderr.decode()
    section, values = "", {}
    for line in done.stdout.decode().splitlines():
        if line.startswith("["):
            section = line.strip("[]") + "."
        elif line and not line.startswith("#"):
            key, _, rest = line.partition(" = ")
            values[section + key] = rest.split(" # ")[0].strip()
    return values


# --- the presets --------------------------------------------------------------------------------------------------
def test_the_list_is_the_table():
    told = {robot["name"]: robot for robot in ask("robots")["robots"]}
    assert told.keys() == TABLE.keys()
    for name, (period_ms, dead_time_ms, force_ms) in TABLE.items():
        robot = told[name]
        assert robot["period_ms"] == period_ms and robot["force_delay_ms"] == force_ms, name
        if dead_time_ms == "3 periods":
            assert robot["dead_time_ms"] is None and robot["dead_time_periods"] == 3
        else:
            assert robot["dead_time_ms"] == list(dead_time_ms) and robot["dead_time_periods"] is None, name
        assert robot["plus_drive_lag"] is (name in PLUS_DRIVE_LAG)
        assert robot["source"].endswith(".") and robot["description"]
        if not name.startswith("krenn"):
            assert "not a promise" in robot["source"], name


def test_the_list_for_a_person_and_one_file():
    listed = command("robots").stdout.decode()
    for name in TABLE:
        assert f"\n{name} " in listed
        text = command("robots", name).stdout.decode()
        assert text == (ROOT / "sim_hal" / "robots" / f"{name}.toml").read_text()
    assert "40-80 ms" in listed and "3 T + lag" in listed
    assert max(map(len, listed.splitlines())) <= 117
    assert ask("robots", "abb-egm")["dead_time_ms"] == [40, 80]


@pytest.mark.parametrize("name", TABLE)
def test_eigenvalues_with_a_preset_agree_with_numpy(name):
    period_ms, ends_ms, force_ms = expected(name)
    told = ask("eigen", "ess", "--robot", name)
    assert told["robot"]["preset"] == name
    assert told["robot"]["period_ms"] == period_ms and told["robot"]["dead_time_ms"] == ends_ms[1]
    assert told["robot"]["lacks_drive_lag"] is (name in PLUS_DRIVE_LAG)
    radii = [np.abs(np.linalg.eigvals(loop_matrices(Loop(1e3 / period_ms, 1e-3 * end, 1e-3 * force_ms)))).max()
             for end in ends_ms]
    print(f"{name}: |z| = {told['spectral_radius']:.9f}, numpy {radii[1]:.9f}")
    assert told["spectral_radius"] == pytest.approx(radii[1], rel=1e-9)
    assert told["stable"] is bool(radii[1] < 1) and told["stable"] is (name != "yaskawa-dx200")
    if ends_ms[0] < ends_ms[1]:
        assert told["lower_end"]["dead_time_ms"] == ends_ms[0]
        assert told["lower_end"]["spectral_radius"] == pytest.approx(radii[0], rel=1e-9)
        assert told["robot"]["dead_time_band_ms"] == list(ends_ms)
    else:
        assert told["lower_end"] is None and told["robot"]["dead_time_band_ms"] is None


def test_presets_of_the_paper_have_the_reference_values_on_either_rig():
    for rig in ("ess", "ess-50hz"):
        for name, radius in {"krenn-50hz": 0.994238761, "krenn-400hz": 0.999254356}.items():
            assert round(ask("eigen", rig, "--robot", name)["spectral_radius"], 9) == radius


@pytest.mark.parametrize("name", TABLE)
def test_the_simulated_robot_has_the_dead_time_and_the_loop_runs(name, tmp_path):
    period_ms, ends_ms, _ = expected(name)
    told = ask("deadtime", "ess", "--robot", name)
    assert told["command_to_motion_ms"] == pytest.approx(ends_ms[1], abs=1e-6)
    told = run_json("ess", tmp_path, "--no-log", "--robot", name, "--set", "run.duration_s=6")
    assert told["state"] == "running" and told["ticks"] == math.floor(6000 / period_ms)


@pytest.mark.parametrize("name", TABLE)
def test_keys_that_a_preset_does_not_state_stay_the_rigs(name):
    period_ms, ends_ms, force_ms = expected(name)
    own, with_robot = config_of("ess"), config_of("ess", "--robot", name)
    assert own.keys() == with_robot.keys()
    changed = {key for key in own if own[key] != with_robot[key]}
    assert changed <= {"loop.rate_Hz", "robot.dead_time_ms", "sensor.delay_ms"}
    assert 1e3 / float(with_robot["loop.rate_Hz"]) == pytest.approx(period_ms, rel=1e-12)
    assert float(with_robot["robot.dead_time_ms"]) == pytest.approx(ends_ms[1], rel=1e-12)
    assert float(with_robot["sensor.delay_ms"]) == force_ms


def test_set_comes_after_the_preset():
    told = ask("eigen", "ess", "--robot", "abb-egm", "--set", "robot.dead_time_ms=50")
    assert told["robot"]["dead_time_ms"] == 50 and told["robot"]["reported_dead_time_ms"] == [40, 80]
    assert told["robot"]["dead_time_band_ms"] is None and told["lower_end"] is None
    same = ask("eigen", "ess", "--set", "loop.rate_Hz=250", "--set", "robot.dead_time_ms=50")
    assert same["robot"] is None and same["eigenvalues"] == told["eigenvalues"]
    text = command("eigen", "ess", "--robot", "abb-egm", "--set", "robot.dead_time_ms=50").stdout.decode()
    assert "dead time 50 ms (reported: 40 to 80 ms)" in text


def test_periods_follow_the_rate_that_is_set():
    told = ask("eigen", "ess", "--robot", "ethercat-csp", "--set", "loop.rate_Hz=1000")
    assert told["robot"]["dead_time_ms"] == 3 and told["robot"]["period_ms"] == 1


def test_a_drive_lag_that_the_user_states_is_no_longer_missing():
    lag = ["--set", "robot.transfer_frequency_Hz=40"]
    assert ask("eigen", "ess", "--robot", "franka-fci", *lag)["robot"]["lacks_drive_lag"] is False
    assert "without the drive's lag" in command("eigen", "ess", "--robot", "franka-fci").stdout.decode()
    assert "without the drive's lag" not in command("eigen", "ess", "--robot", "franka-fci", *lag).stdout.decode()


# --- logs ---------------------------------------------------------------------------------------------------------
@pytest.mark.long
def test_the_log_tells_the_preset_and_is_otherwise_that_of_the_same_values(tmp_path):
    short = {"run.duration_s": 5}
    told = run_json("ess", tmp_path / "robot", "--robot", "abb-egm", *settings(short))
    assert told["robot"]["preset"] == "abb-egm" and told["robot"]["dead_time_band_ms"] == [40, 80]
    values = {**short, "loop.rate_Hz": 250, "robot.dead_time_ms": 80}
    plain = run_json("ess", tmp_path / "values", *settings(values))
    assert plain["robot"] is None and plain["config_hash"] == told["config_hash"]
    assert plain["growth_per_s"] == told["growth_per_s"]
    assert ask("summary", told["log"])["robot"] == told["robot"]
    assert ask("summary", plain["log"])["robot"] is None
    assert replay_json(told["log"])["equal"] is True
    sentence = "abb-egm: period 4 ms, dead time 80 ms, the upper end of the reported 40 to 80 ms"
    assert sentence in command("summary", told["log"]).stdout.decode()


def test_print_config_shows_effective_values_and_loads_again(tmp_path):
    done = command("run", "ess", "--robot", "abb-egm", "--print-config")
    assert done.stdout.startswith(b"# robot abb-egm: ")
    (tmp_path / "printed.toml").write_bytes(done.stdout)
    again = run_json(tmp_path / "printed.toml", tmp_path, "--set", "run.duration_s=1")
    direct = run_json("ess", tmp_path / "direct", "--robot", "abb-egm", "--set", "run.duration_s=1")
    assert again["config_hash"] == direct["config_hash"]


def test_a_preset_that_is_damaged_in_a_log_is_said_to_be(tmp_path):
    told = run_json("ess", tmp_path, "--robot", "abb-egm", "--set", "run.duration_s=1")
    content = pathlib.Path(told["log"]).read_bytes()
    for old, new in ((b'"dead_time_ms":', b'"dead_tyme_ms":'), (b'{"assumed', b'["assumed'),
                     (b"[40.0,80.0]", b"[40.0 80.0]")):
        assert old in content
        damaged = tmp_path / "damaged.ulg"
        damaged.write_bytes(content.replace(old, new))
        done = command("summary", damaged, "--json")
        assert done.returncode == EXIT_INPUT and b"is damaged" in done.stderr and done.stdout == b""


# --- bands --------------------------------------------------------------------------------------------------------
def map_columns(folder, *arguments):
    """`berth map --json`: the object, and the columns of its CSV by name."""
    told = ask("map", *arguments, "--out", folder)
    return told, np.genfromtxt(told["csv"], delimiter=",", names=True)


@pytest.mark.parametrize("vary", ["elasticity", "mass"])
def test_both_ends_of_a_band_are_the_maps_at_these_dead_times(vary, tmp_path):
    what = ["ess", "--vary", vary, "--grid", "60x40"]
    told, columns = map_columns(tmp_path / "band", *what, "--robot", "abb-egm")
    ends = {ms: map_columns(tmp_path / str(ms), *what,
                            *settings({"loop.rate_Hz": 250, "robot.dead_time_ms": ms})) for ms in (40, 80)}
    assert np.array_equal(columns["spectral_radius"], ends[80][1]["spectral_radius"], equal_nan=True)
    assert np.array_equal(columns["spectral_radius_low"], ends[40][1]["spectral_radius"], equal_nan=True)
    assert told["robot"]["dead_time_band_ms"] == [40, 80] and told["lower_end"]["dead_time_ms"] == 40
    for key in ("stable_share", "stable_share_below_wall", "spectral_radius_min", "spectral_radius_max", "own"):
        assert told[key] == ends[80][0][key] and told["lower_end"][key] == ends[40][0][key], key
    assert told["lower_end"]["stable_share"] > told["stable_share"]  # there is a band
    assert told["csv"].endswith(f"ess-abb-egm-{vary}.csv") and ends[40][0]["lower_end"] is None
    assert "spectral_radius_low" not in ends[40][1].dtype.names


def test_the_summary_of_a_map_tells_both_ends(tmp_path):
    what = ["map", "ess", "--vary", "elasticity", "--grid", "60x40", "--robot", "abb-egm", "--out", tmp_path]
    told = ask(*what)
    text = command(*what).stdout.decode()
    assert f"stable at {100 * told['stable_share']:.1f} % of {told['points_possible']} points" in text
    assert f"at the lower end, 40 ms, stable at {100 * told['lower_end']['stable_share']:.1f} % of the points" in text


def test_no_band_where_the_dead_time_is_an_axis(tmp_path):
    told, columns = map_columns(tmp_path, "ess", "--robot", "abb-egm", "--x", "robot.dead_time_ms=40:80:5", "--y",
                                "object.mass_kg=50:100:2")
    assert told["lower_end"] is None and "spectral_radius_low" not in columns.dtype.names


def test_a_point_that_is_only_possible_at_the_upper_end(tmp_path):
    told, columns = map_columns(tmp_path, "ess", "--robot", "abb-egm", "--x", "loop.rate_Hz=20:50:4", "--y",
                                "object.mass_kg=50:100:2")
    at_20_Hz = columns["looprate_Hz"] == 20  # genfromtxt leaves the dot out
    assert np.isfinite(columns["spectral_radius"][at_20_Hz]).all()  # a period of 50 ms
    assert np.isnan(columns["spectral_radius_low"][at_20_Hz]).all()
    assert told["points_invalid"] == 2 * 1  # 30 Hz does not divide


@pytest.mark.long
@pytest.mark.parametrize("stiffness_N_per_m, stable", [(2368.7, "all"), (15000, "part"), (60000, "none")])
@pytest.mark.first(1)
def test_limits_tell_where_in_the_band_the_loop_is_stable(stiffness_N_per_m, stable):
    what = {"object.stiffness_N_per_m": stiffness_N_per_m, "object.damping_N_s_per_m": 400}
    arguments = ["ess", "--robot", "abb-egm", *settings(what)]
    told = ask("limits", *arguments)["dead_time_band"]
    print(f"k = {stiffness_N_per_m} N/m: {told}")
    assert told["dead_time_band_ms"] == [40, 80] and told["stable"] == stable
    for ms in np.linspace(40, 80, 21):
        inside = any(start <= ms <= end for start, end in told["stable_intervals_ms"])
        values = {"loop.rate_Hz": 250, "robot.dead_time_ms": repr(float(ms)), **what}
        assert ask("eigen", "ess", *settings(values))["stable"] is inside, ms
    for end in {ms for interval in told["stable_intervals_ms"] for ms in interval} - {40, 80}:
        values = {"loop.rate_Hz": 250, "robot.dead_time_ms": repr(end), **what}
        assert ask("eigen", "ess", *settings(values))["spectral_radius"] == pytest.approx(1, abs=1e-7)
    words = {"all": "stable over the whole of it", "part": "stable over a part of it: [40, ",
             "none": "unstable over the whole of it"}
    text = command("limits", *arguments).stdout.decode()
    assert f"reported dead time from 40 to 80 ms: {words[stable]}" in text


@pytest.mark.long
def test_limits_without_a_band_tell_none():
    told = ask("limits", "ess", "--robot", "ur10e-servoj")
    assert told["dead_time_band"] is None and told["robot"]["preset"] == "ur10e-servoj"


@pytest.mark.long
def test_picture_of_a_band(tmp_path, monkeypatch):
    told, _ = map_columns(tmp_path, "ess", "--robot", "abb-egm", "--vary", "elasticity", "--grid", "60x40")
    found = read_map(pathlib.Path(told["csv"]))
    pixels = {}
    for name in ("band", "plain"):
        with monkeypatch.context() as changed:
            if name == "plain":
                changed.setattr(map_picture, "draw_band", lambda axes, found: [])
            map_picture.draw(found, tmp_path / f"{name}.png")
        pixels[name] = imread(tmp_path / f"{name}.png")[100:600, :, :3]  # without the legend
    darker = pixels["plain"].sum(axis=2) - pixels["band"].sum(axis=2)
    assert 0.02 < (darker > 0.1).mean() < 0.3 and (darker < -0.1).mean() < 0.01


# --- presets of a user, and wrong ones ----------------------------------------------------------------------------
MINE = 'source = "our own measurement"\n[loop]\nperiod_ms = 5.0\n[robot]\ndead_time_ms = [10.0, 30.0]\n'


def test_a_file_of_a_user_is_called_after_itself(tmp_path):
    path = tmp_path / "our robot.toml"
    path.write_text(MINE)
    told = ask("eigen", "ess", "--robot", path)
    assert told["robot"]["preset"] == "our robot" and told["robot"]["dead_time_band_ms"] == [10, 30]
    assert command("robots", path).stdout.decode() == MINE
