"""`berth map`: its files, its refusals, and its values against numpy on matrices from the definitions alone."""

import csv
import json
import pathlib
import subprocess
import sys

import numpy as np
import pytest
from conftest import EXIT_INPUT, ROOT, command, one_json_object

sys.path.insert(0, str(ROOT / "scripts"))
from loop_matrix import Loop, coupled_rigs, loop_matrices  # noqa: E402

ESS = Loop(rate_Hz=400, T_R=17.5e-3, T_S=2.5e-3)
LOOPS = {"ess": ESS, "ess-50hz": Loop(50, 40e-3, 20e-3), "ess-half-dead-time": Loop(400, 7.5e-3, 2.5e-3)}
REFERENCE = {"ess": 0.999254356, "ess-50hz": 0.994238761, "ess-half-dead-time": 0.999298199}


def map_json(folder, *arguments):
    """`berth map --json` with its files in `folder`: the object, and the columns of the CSV."""
    done = command("map", *arguments, "--json", "--out", folder)
    assert done.returncode == 0, done.stderr.decode()
    assert done.stderr == b""
    result = one_json_object(done.stdout)
    return result, np.loadtxt(result["csv"], delimiter=",", skiprows=1).T


def radii(loop):
    """Largest |z| of rigs."""
    return np.abs(np.linalg.eigvals(loop_matrices(loop))).max(axis=1)


@pytest.mark.parametrize("rig", LOOPS)
def test_the_independent_matrices_have_the_reference_values(rig):
    assert radii(LOOPS[rig])[0] == pytest.approx(REFERENCE[rig], abs=5e-10)


@pytest.mark.parametrize("rig", LOOPS)
@pytest.mark.parametrize("vary", ["elasticity", "mass"])
def test_map_of_the_coupled_system_agrees_with_numpy(rig, vary, tmp_path):
    result, (x, y, radius, growth, wall) = map_json(tmp_path, rig, "--vary", vary, "--grid", "31x17")
    assert len(x) == 31 * 17 == result["points"]
    rigs = coupled_rigs(LOOPS[rig], vary, x, y)
    possible = (rigs.k >= 0) & (rigs.d >= 0) & (rigs.m > 0)
    assert np.array_equal(possible, np.isfinite(radius))
    assert result["points_possible"] == possible.sum() and result["points_not_passive"] == (~possible).sum()
    rigs = coupled_rigs(LOOPS[rig], vary, x[possible], y[possible])
    assert np.abs(radius[possible] / radii(rigs) - 1).max() < 1e-9
    assert growth[possible] == pytest.approx(np.log(radius[possible]) / LOOPS[rig].T, rel=1e-12, abs=1e-12)
    damped_Hz = x * np.sqrt(1 - y**2)  # the manipulator's eigenfrequency is 1 Hz
    assert np.array_equal(wall[possible] == 1, damped_Hz[possible] < 5)
    assert np.isnan(wall[~possible]).all() and np.isnan(growth[~possible]).all()
    assert result["stable_share"] == pytest.approx(np.mean(radius[possible] < 1))
    assert result["spectral_radius_min"] == np.nanmin(radius)
    assert result["spectral_radius_max"] == np.nanmax(radius)
    assert result["own"]["spectral_radius"] == pytest.approx(REFERENCE[rig], abs=5e-10)


SETTINGS = {
    "hold": (["robot.interpolation=hold"], {"hold": True}),
    "dead times that are no whole periods": (["robot.dead_time_ms=13.3", "sensor.delay_ms=3.1",
                                              "sensor.sample_phase_ms=1.7"],
                                             {"T_R": 13.3e-3, "T_S": 3.1e-3, "phase": 1.7e-3}),
    "transfer behaviour": (["robot.transfer_frequency_Hz=12", "robot.transfer_damping_ratio=0.6"],
                           {"f_R": 12.0, "zeta_R": 0.6}),
    "hold and transfer behaviour": (["robot.interpolation=hold", "robot.transfer_frequency_Hz=12",
                                     "robot.dead_time_ms=8.1"],
                                    {"hold": True, "f_R": 12.0, "T_R": 8.1e-3}),
}


@pytest.mark.parametrize("name", SETTINGS)
def test_map_over_keys_agrees_with_numpy(name, tmp_path):
    texts, values = SETTINGS[name]
    sets = [word for text in texts for word in ("--set", text)]
    _, (m, k, radius, _, _) = map_json(tmp_path, "ess", "--x", "object.mass_kg=10:300:23", "--y",
                                       "object.stiffness_N_per_m=100:50000:11", *sets)
    loop = Loop(**{**ESS.__dict__, **values, "m": m, "k": k})
    assert np.abs(radius / radii(loop) - 1).max() < 1e-9


def test_map_over_dead_time_agrees_with_numpy_and_leaves_out_invalid_rigs(tmp_path):
    result, (T_R_ms, m, radius, _, _) = map_json(tmp_path, "ess", "--x", "robot.dead_time_ms=1:41:41", "--y",
                                                 "object.mass_kg=20:200:4")
    assert np.array_equal(np.isnan(radius), T_R_ms < 2.5)  # "linear" needs a period
    assert result["points_invalid"] == 2 * 4 and result["points_not_passive"] == 0
    for i in np.flatnonzero(T_R_ms >= 2.5):
        expected = radii(Loop(400, T_R_ms[i] * 1e-3, 2.5e-3, m=m[i]))[0]
        assert radius[i] == pytest.approx(expected, rel=1e-9)


def test_growth_counts_the_period_where_the_rate_is_an_axis(tmp_path):
    _, (rate_Hz, _, radius, growth, _) = map_json(
        tmp_path, "ess", "--x", "loop.rate_Hz=100:500:5", "--y", "object.mass_kg=50:100:2")
    possible = np.isfinite(radius)
    assert np.array_equal(possible, rate_Hz != 300)  # does not divide 1e9
    assert growth[possible] == pytest.approx(np.log(radius[possible]) * rate_Hz[possible], rel=1e-12)


@pytest.mark.parametrize("key, largest", [
    ("sensor.loss_probability", 0.9), ("robot.backlash_m", 2e-3), ("robot.velocity_limit_m_per_s", 0.02)])
def test_an_axis_may_bring_an_effect_that_the_rig_itself_does_not_have(key, largest, tmp_path):
    axes = ["--x", f"{key}={largest / 2}:{largest}:2", "--y", "object.stiffness_N_per_m=8000:10000:2"]
    _, columns = map_json(tmp_path, "ess", *axes, "--ticks", "20000")
    growth = columns[-1] if key == "sensor.loss_probability" else columns[3]
    done = command("eigen", "ess", "--json", "--ticks", "20000", "--set", f"{key}={largest}",
                   "--set", "object.stiffness_N_per_m=10000")
    assert growth[-1] == pytest.approx(one_json_object(done.stdout)["growth_per_s"], rel=1e-6)
    assert growth[-1] != growth[-2]


def test_csv_is_read_by_others(tmp_path):
    result, columns = map_json(tmp_path, "ess", "--vary", "mass", "--grid", "5x4")
    path = pathlib.Path(result["csv"])
    assert path == tmp_path / "ess-mass.csv"
    assert sorted(p.name for p in tmp_path.iterdir()) == ["ess-mass.csv", "ess-mass.json"]
    named = np.genfromtxt(path, delimiter=",", names=True)
    assert named.dtype.names == ("omega_per_omega_M", "zeta", "spectral_radius", "growth_per_s", "wall")
    assert np.array_equal(named["spectral_radius"], columns[2], equal_nan=True)
    rows = list(csv.DictReader(path.open()))
    assert [float(row["zeta"]) for row in rows] == list(columns[1])
    assert "-nan" not in path.read_text()
    beside = json.loads(path.with_suffix(".json").read_text())
    assert all(result[key] == value for key, value in beside.items())


def test_threads_give_the_same_bytes(tmp_path):
    texts = [pathlib.Path(map_json(tmp_path / n, "ess", "--vary", "elasticity", "--grid", "60x50", "--threads",
                                   n)[0]["csv"]).read_bytes() for n in ("1", "2", "7")]
    assert texts[0] == texts[1] == texts[2]


def test_a_folder_that_cannot_be_written(tmp_path):
    (tmp_path / "file").write_text("")
    done = command("map", "ess", "--vary", "mass", "--grid", "3x3", "--out", tmp_path / "file" / "maps")
    assert done.returncode == EXIT_INPUT and len(done.stderr.splitlines()) == 1


@pytest.mark.long
def test_picture(tmp_path):
    result, _ = map_json(tmp_path, "ess", "--vary", "elasticity", "--grid", "40x30", "--picture")
    assert result["picture"] == str(tmp_path / "ess-elasticity.png")
    (tmp_path / "ess-elasticity.png").unlink()
    done = subprocess.run([sys.executable, "scripts/map_picture.py", result["csv"]], cwd=ROOT, capture_output=True)
    assert done.returncode == 0, done.stderr.decode()
    from matplotlib.image import imread
    pixels = imread(tmp_path / "ess-elasticity.png")[..., :3]
    red = (pixels[..., 0] > pixels[..., 2] + 0.3).mean()
    blue = (pixels[..., 2] > pixels[..., 0] + 0.05).mean()
    assert red > 0.1 and blue > 0.05  # both sides of the limit are there


@pytest.mark.long
def test_map_at_an_amplitude_is_what_eigen_says_at_every_point(tmp_path):
    """Also where the mode that decides is not the one whose frequency the equivalent spring was taken at."""
    softening = ["--set", "object.cubic_stiffness_N_per_m3=-1e7"]
    result, (x, y, radius, *_) = map_json(tmp_path, "ess", *softening, "--x", "sensor.stiffness_N_per_m=11482758.62:2e7:3",
                                          "--y", "object.mass_kg=20:250:4")
    assert result["amplitude_m"] == 0.01 and len(x) == 12
    for stiffness, mass_kg, told in zip(x, y, radius):
        values = [f"sensor.stiffness_N_per_m={float(stiffness)!r}", f"object.mass_kg={float(mass_kg)!r}"]
        point = command("eigen", "ess", "--json", *softening, *(part for v in values for part in ("--set", v)))
        assert one_json_object(point.stdout)["spectral_radius"] == pytest.approx(told, rel=1e-9), values


JUMP = ["run.dead_time_jump_s=5", "run.dead_time_jump_ms=4"]


@pytest.mark.parametrize("scheduled, x, instants", [
    (JUMP, "robot.dead_time_ms=5:29:4", 2),
    (["robot.dead_time_drift_ms_per_s=0.2"], "robot.dead_time_ms=5:29:4", 17),
    (["object.stiffness_drift_per_s=0.02"], "object.damping_N_s_per_m=0:60:4", 17),
    ([*JUMP, "loop.lost_sample_probability=0.1"], "robot.dead_time_ms=5:29:2", 2)])
def test_a_loop_that_changes_on_schedule_is_at_each_point_what_eigen_says(scheduled, x, instants, tmp_path):
    result, columns = map_json(tmp_path, "ess", *(part for one in scheduled for part in ("--set", one)), "--x", x,
                               "--y", "object.mass_kg=60:190:2")
    assert len(result["scheduled_at_s"]) == instants and result["left_out"] == []
    for point, growth_per_s in zip(zip(columns[0], columns[1]), columns[-1 if "lost" in scheduled[-1] else 3]):
        values = [*scheduled, *(f"{axis['name']}={float(value)!r}"
                                for axis, value in zip((result["axes"]["x"], result["axes"]["y"]), point))]
        at_point = one_json_object(
            command("eigen", "ess", "--json", "--ticks", 8000, *(part for one in values for part in ("--set", one))).stdout)
        assert at_point["growth_per_s"] == pytest.approx(growth_per_s, rel=1e-6, abs=1e-6), values


def test_points_that_drift_freely_are_not_counted_as_stable(tmp_path):
    """No spring on either body: z = 1, whatever rounding makes of it."""
    result, columns = map_json(tmp_path, "ess", "--set", "manipulator.stiffness_N_per_m=0", "--x",
                               "object.stiffness_N_per_m=0:100:2", "--y", "object.mass_kg=50:150:40")
    free = columns[0] == 0.0
    assert abs(columns[2][free] - 1.0).max() < 1e-7
    assert result["stable_share"] == pytest.approx((columns[2][~free] < 1.0).sum() / 80)


def test_the_picture_of_a_contact_rig_draws_where_a_bounce_gains_energy(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "path", [str(ROOT / "scripts"), *sys.path])
    import matplotlib.pyplot as plt
    from berth_map import read_map
    from map_picture import draw_bounces
    result, _ = map_json(tmp_path, "concept-foam", "--x", "object.stiffness_N_per_m=500:20000:12",
                         "--y", "robot.dead_time_ms=5:60:8")
    axes = plt.figure().gca()
    found = read_map(result["csv"])
    line, = draw_bounces(axes, found)
    drawn = np.vstack([path.vertices for path in axes.collections[0].get_paths()])
    gaining = found.restitution > 1.0
    assert 0 < gaining.mean() < 1 and line.get_label().startswith("restitution 1: a bounce gains energy at")
    assert result["bounces"]["gaining_share"] == pytest.approx(gaining.mean(), abs=1e-9)
    for column in np.flatnonzero(gaining.any(axis=0) & ~gaining.all(axis=0)):  # between two points, the line passes
        x = found.x[0, column]
        first = found.y[np.flatnonzero(gaining[:, column])[0], column]
        near = drawn[np.abs(drawn[:, 0] - x) < 0.01 * np.ptp(found.x)]
        assert np.abs(near[:, 1] - first).min() < 1.01 * (found.y[1, 0] - found.y[0, 0])
    plt.close("all")


def cells_of(found):
    """The colours of a map's cells, nan where there is none, and the limit's sides."""
    import map_picture
    import matplotlib.pyplot as plt
    axes = plt.figure().gca()
    handles, _ = map_picture.draw_shades(axes, found)
    limit = map_picture.draw_limit(axes, found)
    colours = axes.collections[0].get_array().filled(np.nan)
    labels = [handle.get_label() for handle in [*handles, *limit]]
    plt.close("all")
    return colours, labels, map_picture.sides_between(found)


def test_swings_that_last_are_neither_stable_nor_growing(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "path", [str(ROOT / "scripts"), *sys.path])
    from berth_map import read_map
    result, columns = map_json(tmp_path, "ess", "--x", "object.mass_kg=180:260:7", "--y",
                               "object.stiffness_N_per_m=1000:12000:4", "--time-domain")
    growth, lasts, faulted = columns[3], columns[6] == 1, columns[7] == 1
    assert lasts.any() and faulted.any() and not (lasts & faulted).any()
    assert growth[faulted] == pytest.approx(1 / result["time_domain"]["run_s"]) and (np.abs(growth[lasts]) < 0.005).all()
    assert result["time_domain"]["faulted_share"] == pytest.approx(faulted.mean())
    assert result["time_domain"]["lasting_share"] == pytest.approx(lasts.mean())
    found = read_map(result["csv"])
    assert found.is_stable.mean() == pytest.approx(result["stable_share"])
    colours, labels, sides = cells_of(found)
    assert np.array_equal(np.isnan(colours).ravel(), lasts | faulted)
    assert {"limit of stability", "swings on without growing", "a fault ended the run before it grew"} <= \
        {label.split(":")[0] for label in labels}
    stable = found.is_stable
    assert len(sides) == (stable[:, 1:] != stable[:, :-1]).sum() + (stable[1:] != stable[:-1]).sum()


def test_points_that_stand_alone_are_drawn(tmp_path, monkeypatch):
    """Of these rates one in three divides a second into whole nanoseconds: no four points are beside each other."""
    monkeypatch.setattr(sys, "path", [str(ROOT / "scripts"), *sys.path])
    from berth_map import read_map
    result, (*_, growth, _) = map_json(tmp_path, "ess", "--x", "object.mass_kg=50:400:12", "--y", "loop.rate_Hz=50:1000:20")
    colours, labels, sides = cells_of(read_map(result["csv"]))
    has_growth = np.isfinite(growth)
    assert 0 < has_growth.sum() == result["points_possible"] < 0.5 * len(growth)
    assert np.array_equal(np.isfinite(colours).ravel(), has_growth)
    assert ((colours.ravel() < 0) == (growth < 0))[has_growth].all()
    assert len(sides) == result["points_possible"] // 12 and "limit of stability" in labels  # one in each row


def test_a_map_of_many_neighbours_is_shaded_between_them(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "path", [str(ROOT / "scripts"), *sys.path])
    from berth_map import read_map
    from map_picture import needs_cells
    result, _ = map_json(tmp_path, "ess", "--vary", "elasticity", "--grid", "40x30")
    assert result["points_not_passive"] > 0 and not needs_cells(read_map(result["csv"]))
