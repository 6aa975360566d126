"""The claims of the paper as tests. What the claims module says is compared with matrices that another program
makes from the definitions alone, with closed forms, and with the logs of runs."""

import functools
import sys
import tomllib

import numpy as np
import pytest
from conftest import RIG_FOLDER, ROOT, command

sys.path.insert(0, str(ROOT / "scripts"))
import claims as claims_module  # noqa: E402
from berth_program import Berth  # noqa: E402
from loop_matrix import Loop, coupled_rigs, loop_matrices  # noqa: E402
from paper_case import FAST, HALF, RIGS, SLOW, Case, assumptions_of  # noqa: E402
from paper_data import ADDED_SAMPLES, ROBOT, PaperData  # noqa: E402
from paper_search import RANGES, Search  # noqa: E402

LOOPS = {FAST: dict(rate_Hz=400, T_R=17.5e-3, T_S=2.5e-3), SLOW: dict(rate_Hz=50, T_R=40e-3, T_S=20e-3),
         HALF: dict(rate_Hz=400, T_R=7.5e-3, T_S=2.5e-3)}
WALL_Hz = 5.0
STIFF_N_per_m = 23687.0


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    return PaperData(Berth(tmp_path_factory.mktemp("paper")))


@pytest.fixture(scope="module")
def claims(data):
    return claims_module.measure(data)


def the(claims, number, figure, words=""):
    """The one claim with this number and figure whose sentence has these words."""
    found = [c for c in claims if (c.number, c.figure) == (number, figure) and words in c.sentence]
    assert len(found) == 1, (number, figure, words)
    print(f"{found[0].verdict}: {found[0].sentence}: {found[0].measured}. {found[0].remark}")
    return found[0]


def radii(loop):
    """Largest |z| by numpy, with matrices that know nothing of the host command."""
    return np.abs(np.linalg.eigvals(loop_matrices(loop))).max(axis=1)


def growth_per_s(loop):
    return float(np.log(radii(loop)[0]) * loop.rate_Hz)


def area(rig, vary, x_range, zeta_range=(0.0, 0.3), columns=61, rows=41, **values):
    """Points of a map below the wall or beyond it, by numpy: damped eigenfrequency in Hz, and whether it is stable,
    of every passive object."""
    x, y = [grid.ravel() for grid in np.meshgrid(np.linspace(*x_range, columns), np.linspace(*zeta_range, rows))]
    loop = Loop(**{**LOOPS[rig], **values})
    rigs = coupled_rigs(loop, vary, x, y)
    possible = (rigs.k >= 0) & (rigs.d >= 0) & (rigs.m > 0)
    manipulator_Hz = np.sqrt(loop.K / loop.M) / (2.0 * np.pi)
    damped_Hz = manipulator_Hz * (x * np.sqrt(1.0 - y**2))[possible]
    return damped_Hz, radii(coupled_rigs(loop, vary, x[possible], y[possible])) < 1.0


@functools.cache
def stable_share(rig, vary, **values):
    """Of what the robot could display, over the map's own axes."""
    x_range = (np.sqrt(2.0 / 3.0), 6.0) if vary == "elasticity" else (0.285, np.sqrt(1.3))
    damped_Hz, is_stable = area(rig, vary, x_range, **values)
    return is_stable[damped_Hz < WALL_Hz].mean()


@pytest.mark.long
def test_claim_1_two_passive_systems_go_unstable_through_dead_time_and_the_object_alone_decides(claims):
    claim = the(claims, "1", "Fig. 4")
    configs = [command("run", f"concept-{material}", "--print-config").stdout.decode().splitlines()
               for material in ("foam", "copper")]
    different = {line.split(" = ")[0] for lines in zip(*configs) if lines[0] != lines[1] for line in lines}
    assert different == {"name", "description", "stiffness_N_per_m", "damping_N_s_per_m"}
    start = configs[0].index("[object]")
    assert configs[0][:start][4:] == configs[1][:start][4:]  # so the keys that differ are those of the object
    tool = {"m": 1.0, "k_S": 2e6}
    foam, copper = {"k": 2000.0, "d": 150.0}, {"k": 60000.0, "d": 20.0}  # all positive: passive
    told = claim.values["growth_per_s"]
    # Foam is never left again: the contact is a gripped object. Copper is left at each bounce.
    assert told["foam"] == pytest.approx(growth_per_s(Loop(**LOOPS[FAST], **tool, **foam)), rel=0.01)
    assert growth_per_s(Loop(**LOOPS[FAST], **tool, **copper)) > 0.5 and told["copper"] > 0.5
    quick = Loop(rate_Hz=10000, T_R=1e-4, T_S=1e-4, f_L=1e4, **tool, **copper)
    assert told["no_dead_time"] == pytest.approx(growth_per_s(quick), rel=0.05) and told["no_dead_time"] < 0
    assert claim.met


@pytest.mark.parametrize("rig, figure", [(SLOW, "Fig. 10"), (FAST, "Fig. 11")])
def test_claim_2_every_further_sample_of_dead_time_adds_one_eigenvalue(rig, figure, claims, data):
    claim = the(claims, "2", figure)
    loop = LOOPS[rig]
    for added, count in zip(ADDED_SAMPLES, claim.values["counts"], strict=True):
        matrix = loop_matrices(Loop(**{**loop, "T_R": loop["T_R"] + added / loop["rate_Hz"]}))[0]
        assert len(matrix) == count
    expected = np.linalg.eigvals(loop_matrices(Loop(**loop))[0])
    for pair in data.spectra[rig]["eigenvalues"]:  # the farther from 0, the better numpy knows them
        z = complex(*pair)
        assert np.abs(expected - z).min() < (1e-9 if abs(z) > 0.5 else 1e-3), z
    assert claim.met


@pytest.mark.parametrize("rig, figure, reference", [(SLOW, "Fig. 10", 0.994238761), (FAST, "Fig. 11", 0.999254356)])
def test_claim_3_ess_is_stable_at_50_and_at_400_Hz(rig, figure, reference, claims):
    claim = the(claims, "3", figure)
    assert round(claim.values["spectral_radius"], 9) == reference
    assert claim.values["spectral_radius"] == pytest.approx(radii(Loop(**LOOPS[rig]))[0], rel=1e-9)
    assert claim.met


def test_claim_4_at_50_Hz_only_a_very_small_area_is_stable_when_the_elasticity_varies(claims):
    claim = the(claims, "4", "Fig. 12")
    assert claim.values["share"] == pytest.approx(stable_share(SLOW, "elasticity"), abs=0.02)
    assert stable_share(SLOW, "elasticity") < 0.25
    assert claim.met


def test_claim_4_is_missed_for_the_mass_unless_the_robot_holds_between_setpoints(claims):
    claim = the(claims, "4", "Fig. 13")
    assert claim.values["share"] == pytest.approx(stable_share(SLOW, "mass"), abs=0.02)
    assert claim.values["share_hold"] == pytest.approx(stable_share(SLOW, "mass", hold=True), abs=0.02)
    assert stable_share(SLOW, "mass") > 0.25 > stable_share(SLOW, "mass", hold=True)
    assert not claim.met and "holds" in claim.remark


def test_claim_5_at_400_Hz_a_wide_area_is_stable(claims):
    claim = the(claims, "5", "Fig. 14", "wide area")
    assert claim.values["share"] == pytest.approx(stable_share(FAST, "elasticity"), abs=0.02)
    assert stable_share(FAST, "elasticity") > 2.0 * stable_share(SLOW, "elasticity")
    assert claim.met


@pytest.mark.long
def test_claim_5_beyond_the_wall_is_missed_unless_the_force_low_pass_is_wider(claims):
    claim = the(claims, "5", "Fig. 14", "wall")
    for values, told in (({}, claim.values["highest_Hz"]), ({"f_L": 50.0}, claim.values["wider_Hz"])):
        damped_Hz, is_stable = area(FAST, "elasticity", (2.5, 8.0), (0.2, 0.7), 111, 51, **values)
        assert told == pytest.approx(damped_Hz[is_stable].max(), abs=0.05)
    assert claim.values["highest_Hz"] < WALL_Hz < claim.values["wider_Hz"]
    assert not claim.met and "low-pass of 50 Hz" in claim.remark


def test_claim_5_ess_is_near_the_limit_above_all_when_the_mass_varies(claims):
    claim = the(claims, "5", "Fig. 15")
    mass_kg = claim.values["mass_kg"]
    assert radii(Loop(**LOOPS[FAST], m=mass_kg * (1.0 - 1e-5)))[0] < 1.0 < \
        radii(Loop(**LOOPS[FAST], m=mass_kg * (1.0 + 1e-5)))[0]
    assert (radii(Loop(**LOOPS[FAST], m=np.linspace(100.0, 0.999 * mass_kg, 40))) < 1.0).all()
    k = np.array([0.999, 1.001]) * claim.values["times"]["object.stiffness_N_per_m"] * Loop.k
    assert (radii(Loop(**LOOPS[FAST], k=k)) < 1.0).tolist() == [True, False]
    assert mass_kg < 200.0 and k[0] > 4.0 * Loop.k
    assert claim.met


@pytest.mark.parametrize("vary, figure", [("elasticity", "Fig. 16"), ("mass", "Fig. 17")])
def test_claim_6_half_the_dead_time_extends_the_area(vary, figure, claims):
    claim = the(claims, "6", figure, "extends")
    assert claim.values["share"] == pytest.approx(stable_share(HALF, vary), abs=0.02)
    assert claim.values["whole"] == pytest.approx(stable_share(FAST, vary), abs=0.02)
    assert stable_share(HALF, vary) > stable_share(FAST, vary) + 0.02
    assert claim.met


def test_claim_6_yet_not_the_whole_range_left_of_the_wall_is_stable(claims):
    claim = the(claims, "6", "Fig. 16", "not the whole range")
    # A closed form: at 4 Hz and a damping ratio of 0.1 the delay takes more damping than there is.
    delay_s = 10e-3 + 1.25e-3 + 2.0 * 0.7 / (2.0 * np.pi * 20.0)
    w, w_M = 2.0 * np.pi * 4.0, 2.0 * np.pi
    assert 0.1 < 0.5 * delay_s * 200.0 / 300.0 * (w - w_M**2 / w)
    damped_Hz, is_stable = area(HALF, "elasticity", (3.99, 4.01), (0.09, 0.11), 3, 3)
    assert (damped_Hz < WALL_Hz).all() and not is_stable.any()
    assert claim.values["share"] < 0.8
    assert claim.met


def test_claim_7_finer_simulation_steps_do_not_cure_an_unstable_loop(claims, data):
    claim = the(claims, "7", "Refinement")
    assert claim.values["exact_per_s"] == pytest.approx(growth_per_s(Loop(**LOOPS[FAST], k=STIFF_N_per_m)), rel=1e-9)
    fast = Loop(**{**LOOPS[FAST], "rate_Hz": 4000}, k=STIFF_N_per_m)
    assert claim.values["fast_per_s"] == pytest.approx(growth_per_s(fast), rel=1e-6)
    assert growth_per_s(fast) > 0.0
    # The integrator is of first order: ten times the steps, a tenth of its error.
    errors = claim.values["exact_per_s"] - np.array(data.growth_by_substeps["semi_implicit_euler"])[[0, 2, 4, 6]]
    assert (errors[:-1] / errors[1:] == pytest.approx(10.0, rel=0.05)), errors
    assert claim.met


def test_claim_8_the_robot_s_amplitude_rises_slightly_and_can_be_filtered_away(claims, data):
    rise, filtered = the(claims, "8", "Fig. 5", "rises"), the(claims, "8", "Fig. 5", "filtered")
    found = data.amplitude
    f = found.frequency_Hz
    assert len(f) == 16 and f[0] == 0.25 and f[-1] == 5.0
    s = 2j * np.pi * f
    w = 2.0 * np.pi * ROBOT["robot.transfer_frequency_Hz"]
    robot = np.abs(w**2 / (s**2 + 2.0 * ROBOT["robot.transfer_damping_ratio"] * w * s + w**2))
    lines = np.sinc(f / 400.0) ** 2  # straight lines between setpoints
    assert found.without == pytest.approx(robot * lines, rel=2e-6)
    butterworth = 1.0 / np.sqrt(1.0 + (f / 40.0) ** 4)
    assert found.with_filter == pytest.approx(butterworth * lines, rel=1e-5)
    assert rise.values["rise"] == pytest.approx(robot[-1] * lines[-1] - 1.0, abs=1e-6)
    slope = np.corrcoef(f, found.without)[0, 1]
    assert slope > 0.95 and 0.01 < rise.values["rise"] < 0.05
    assert rise.met and filtered.met


@pytest.mark.parametrize("rig, ticks", [(FAST, 7), (SLOW, 2)])
def test_claim_8_the_dead_times_show_between_command_and_motion(rig, ticks, claims, data):
    claim = the(claims, "8", "Fig. 6")
    _, log = data.berth.run(f"motion-{rig}", rig, {"run.duration_s": 5})
    command_m, robot_m = log.tick["command_position_m"], log.rig["robot_position_m"]
    first = int(np.searchsorted(log.rig_s, log.tick_s[0] - 1e-6))
    error_m = {shift: np.abs(robot_m[first + shift:][:200] - command_m[:200]).max()
               for shift in (ticks - 1, ticks, ticks + 1)}
    print(error_m)
    assert error_m[ticks] < 1e-9 and min(error_m[ticks - 1], error_m[ticks + 1]) > 1e-5
    assert claim.values["dead_time_ms"][rig] == pytest.approx(1e3 * ticks / LOOPS[rig]["rate_Hz"], abs=1e-3)
    assert claim.met


def test_all_eight_claims_are_judged_and_every_map_has_one(claims):
    assert {claim.number for claim in claims} == set("12345678")
    assert {claim.figure for claim in claims} >= {f"Fig. {n}" for n in (4, 5, 6, 10, 11, 12, 13, 14, 15, 16, 17)}
    assert len(RIGS) == 3 and all(claim.sentence and claim.measured for claim in claims)
    assert claims_module.text(claims).endswith(f"{sum(c.met for c in claims)} of {len(claims)} met\n")


@pytest.fixture(scope="module")
def paper_data(tmp_path_factory):
    return PaperData(Berth(tmp_path_factory.mktemp("ess-paper")), Case("ess-paper"))


@functools.cache
def paper_values():
    """What the rig file assumes, as the matrices of the other program take it."""
    told = tomllib.loads((RIG_FOLDER / "ess-paper.toml").read_text())
    of = {"mass_kg": "m", "stiffness_N_per_m": "k", "damping_N_s_per_m": "d"}
    return {of[key]: told["object"][key] for key in of} | {of[key].upper(): told["manipulator"][key] for key in of} | {
        "f_L": told["sensor"]["low_pass_frequency_Hz"]}


@pytest.mark.long
def test_with_ess_paper_all_17_checks_hold_at_once(paper_data):
    found = claims_module.measure(paper_data)
    print(claims_module.text(found))
    assert len(found) == 17 and [claim.sentence for claim in found if not claim.met] == []
    assert claims_module.text(found).endswith("17 of 17 met\n")


@pytest.mark.long
def test_ess_paper_is_as_stable_as_another_program_says(paper_data):
    areas = {}
    for rig in RIGS:
        radius = radii(Loop(**LOOPS[rig], **paper_values()))[0]
        assert paper_data.spectra[rig]["spectral_radius"] == pytest.approx(radius, rel=1e-9)
        assert radius < 1.0
        for vary in ("elasticity", "mass"):
            told = paper_data.maps[rig, vary].told
            x = told["axes"]["x"]
            damped_Hz, is_stable = area(rig, vary, (x["from"], x["to"]), **paper_values())
            areas[rig, vary] = is_stable[damped_Hz < WALL_Hz].mean()
            assert told["stable_share_below_wall"] == pytest.approx(areas[rig, vary], abs=0.02), (rig, vary)
    print(areas)
    assert areas[SLOW, "elasticity"] < 0.25 and areas[SLOW, "mass"] < 0.25
    assert areas[FAST, "elasticity"] > 2.0 * areas[SLOW, "elasticity"]
    assert 1.0 > areas[HALF, "elasticity"] > areas[FAST, "elasticity"] and areas[HALF, "mass"] > areas[FAST, "mass"]


def test_ess_paper_is_stable_beyond_the_wall_and_near_its_limit_as_another_program_says():
    values = paper_values()
    damped_Hz, is_stable = area(FAST, "elasticity", (2.0, 3.2), (0.2, 0.7), 97, 51, **values)
    assert damped_Hz[is_stable].max() > WALL_Hz
    at = {name: (radii(Loop(**LOOPS[FAST], **{**values, name: values[name] * np.linspace(1.0, 2.0, 41)})) < 1.0)
          for name in ("m", "k")}
    assert at["m"][0] and not at["m"].all() and at["k"].all()


@pytest.mark.slow
def test_the_search_does_not_leave_the_shipped_values():
    """No neighbour on the lattice has a larger smallest margin."""
    own = assumptions_of("ess-paper")
    search = Search(ROOT / "build" / "berth")
    point = tuple(each.index(getattr(own, each.name)) for each in RANGES)
    assert search.assumptions(point) == own
    ends, margin = search.climb(point, -np.inf)
    assert ends == point and margin > 0.0


@pytest.mark.slow
def test_which_assumption_each_claim_hangs_on_is_told(tmp_path):
    table = claims_module.assumption_table(Berth(tmp_path), "ess-paper")
    print(table)
    cases = [line.split()[0] for line in table.splitlines() if line.startswith("  ")][:-1]
    marks = np.array([[mark == "+" for mark in line[16:].split("  ")[:len(cases)]] for line in table.splitlines()
                      if line[:1].isdigit()])
    assert cases[0] == "-" and cases[-1] == "*" and marks.shape == (11, len(cases))
    assert marks[:, 0].all()  # as it is
    assert marks[:, -1].sum() == 9  # as ess, which misses two
    assert not marks[:, 1:-1].all()


def test_a_missing_program_is_named(tmp_path):
    with pytest.raises(claims_module.InputError, match="no-such-program"):
        Berth(tmp_path, tmp_path / "no-such-program").ask("eigen", "ess")
