"""A beam as the gripped object: against a program of its own for the loop with N modes, the beam's closed forms, and the
object of one degree of freedom."""

import tomllib
from dataclasses import dataclass, field

import numpy as np
import pytest
from conftest import EXIT_INPUT, ROOT, command, one_json_object, run_json, settings, topic
from reference_loop import Loop, dead_ticks, simulate
from scipy.linalg import eigvals
from scipy.optimize import brentq

RIG = "ess-beam"
START_m = 0.001
LENGTH_m, MASS_kg_per_m, STIFFNESS_N_m2, DAMPING_RATIO = 8.0, 50.0, 392409.4293856904, 0.02
ESS_RADIUS = 0.999254356  # largest |z| of the reference case, from the definitions


def rows_of(b, x):
    """sin b x, cos b x, exp(-b x), exp(b (x - 1)), and their first three derivatives by b x."""
    s, c, falling, rising = np.sin(b * x), np.cos(b * x), np.exp(-b * x), np.exp(b * (x - 1.0))
    return np.array([[s, c, falling, rising], [c, -s, -falling, rising], [-s, -c, falling, rising],
                     [-c, s, -falling, rising]])


def shape(b, root):
    """Determinant of the four conditions at the ends of a beam held by a spring, root = k L / (E I), and the shape over
    0 to 1 that meets them."""
    start, end = rows_of(b, 0.0), rows_of(b, 1.0)
    turn = start[1] if np.isinf(root) else (root * start[1] - b * start[2]) / (root + b)
    conditions = np.array([start[0], turn, end[2], end[3]])
    weights = np.linalg.svd(conditions)[2][-1]
    return np.linalg.det(conditions), lambda x: weights @ rows_of(b, x)[0]


def modes(count, root_N_m_per_rad=np.inf, mass_kg_per_m=MASS_kg_per_m, stiffness_N_m2=STIFFNESS_N_m2,
          damping_ratio=DAMPING_RATIO):
    """(m, d, k) of the first modes at the tip, a row each."""
    root = root_N_m_per_rad * LENGTH_m / stiffness_N_m2
    grid = np.linspace(0.05, (count + 1) * np.pi, 200 * (count + 1))
    values = [shape(b, root)[0] for b in grid]
    found = []
    for low, high, before, after in zip(grid, grid[1:], values, values[1:]):
        if before * after < 0 and len(found) < count:
            b = brentq(lambda x: shape(x, root)[0], low, high, xtol=1e-15)
            w = shape(b, root)[1]
            square = sum(weight * w(0.5 + 0.5 * x) ** 2 for x, weight in zip(*np.polynomial.legendre.leggauss(80))) / 2
            m = mass_kg_per_m * LENGTH_m * square / w(1.0) ** 2
            rate = (b / LENGTH_m) ** 2 * np.sqrt(stiffness_N_m2 / mass_kg_per_m)
            found.append((m, 2 * damping_ratio * rate * m, rate**2 * m))
    assert len(found) == count
    return np.array(found)


@dataclass
class BeamLoop(Loop):
    """The tip is where the modes' ways add up; each feels the whole force."""

    beam: np.ndarray = field(default_factory=lambda: np.empty((0, 3)))

    def plant(self):
        """A, b of z' = A z + b u with z = (q_1, p_1, y/k_S, Q/k_S, q_2, p_2 ...), p_i = q_i' - d_S u / m_i."""
        count = len(self.beam)
        m, d, k = self.beam.T
        k_S, w = self.k_S, 2.0 * np.pi * self.f_L
        d_S = 2.0 * self.zeta_S * np.sqrt(k_S * self.m)
        places = np.array([0] + [4 + 2 * i for i in range(count - 1)])
        A, b = np.zeros((2 + 2 * count,) * 2), np.zeros(2 + 2 * count)
        q = np.eye(len(b))[places]
        rate = np.eye(len(b))[places + 1], d_S / m
        spring = -k_S * q.sum(0) - d_S * rate[0].sum(0), k_S - d_S * rate[1].sum()
        for i, place in enumerate(places):
            A[place], b[place] = rate[0][i], rate[1][i]
            A[place + 1] = (spring[0] - d[i] * rate[0][i] - k[i] * q[i]) / m[i]
            b[place + 1] = (spring[1] - d[i] * rate[1][i]) / m[i]
        A[2, 3], b[2] = 1.0, w**2 * d_S / k_S
        A[3] = w**2 * spring[0] / k_S
        A[3, 2] -= w**2
        A[3, 3] -= 2.0 * self.zeta_L * w
        b[3] = w**2 * spring[1] / k_S - 2.0 * self.zeta_L * w * b[2]
        return A, b

    def largest(self):
        """Largest |z| of the map over one period, put together tick by tick."""
        a, by = self.manipulator()
        robot_ticks, rest_s = dead_ticks(self.T_R, self.T)
        sensor_ticks, _ = dead_ticks(self.T_S, self.T)
        assert rest_s == 0.0 and not self.hold
        n = len(self.plant()[1])

        def tick(state):
            arm, z, before, samples = np.split(state, [2, 2 + n, 2 + n + robot_ticks])
            samples = np.concatenate(([self.k_S * z[2]], samples))
            setpoints = np.concatenate(([arm[0]], before))
            z = self.advance(z, setpoints[robot_ticks], setpoints[robot_ticks - 1], self.T, self.T)
            arm = a @ arm + by @ [0.0, 0.0, -samples[sensor_ticks]]
            return np.concatenate((arm, z, setpoints[:robot_ticks], samples[:sensor_ticks]))

        states = np.eye(2 + n + robot_ticks + sensor_ticks)
        return np.abs(np.linalg.eigvals(np.array([tick(row) for row in states]).T)).max()


BEAMS = {
    "as shipped": {},
    "one mode": {"object.modes": 1},
    "two modes": {"object.modes": 2},
    "eight modes, well damped": {"object.modes": 8, "object.beam_damping_ratio": 0.1},
    "soft root": {"object.modes": 5, "object.beam_root_stiffness_N_m_per_rad": 2e5},
    "heavy and soft": {"object.modes": 6, "object.beam_mass_kg_per_m": 90.0, "object.beam_stiffness_N_m2": 1e5,
                       "object.beam_damping_ratio": 0.2},
}
HOLD = {"object.modes": 3, "robot.interpolation": "hold", "object.beam_damping_ratio": 0.1}
STABLE = "one mode", "eight modes, well damped", "heavy and soft"


def loop_of(values):
    beam = modes(values.get("object.modes", 4), values.get("object.beam_root_stiffness_N_m_per_rad", np.inf),
                 values.get("object.beam_mass_kg_per_m", MASS_kg_per_m),
                 values.get("object.beam_stiffness_N_m2", STIFFNESS_N_m2),
                 values.get("object.beam_damping_ratio", DAMPING_RATIO))
    return BeamLoop(rate_Hz=400.0, T_R=17.5e-3, T_S=2.5e-3, m=beam[0, 0], beam=beam,
                    hold=values.get("robot.interpolation") == "hold")


def test_oracle_of_the_oracle():
    """One clamped mode is the object of the reference case, whose largest |z| the definitions state."""
    assert modes(1)[0] == pytest.approx([100.0, 19.46773764467334, 2368.705056261446], rel=1e-9)
    assert loop_of({"object.modes": 1}).largest() == pytest.approx(ESS_RADIUS, abs=5e-10)


@pytest.mark.long
@pytest.mark.parametrize("name", BEAMS)
def test_largest_eigenvalue(name):
    done = command("eigen", RIG, "--json", *settings(BEAMS[name]))
    assert done.returncode == 0, done.stderr.decode()
    found = one_json_object(done.stdout)["spectral_radius"]
    assert found == pytest.approx(loop_of(BEAMS[name]).largest(), abs=1e-10)
    assert (found < 1) == (name in STABLE)


@pytest.mark.long
@pytest.mark.parametrize("solver", ["fast", "cvode"])
@pytest.mark.parametrize("name", [*BEAMS, "hold"])
def test_run_against_the_definitions(tmp_path, name, solver):
    values = (BEAMS | {"hold": HOLD})[name] | {"run.duration_s": 4.0, "solver.kind": solver}
    tick = topic(run_json(RIG, tmp_path, *settings(values))["log"])
    running = int(np.argmax(tick["state"] == 2))
    x_m, force_N = simulate(loop_of(values), len(tick["state"]), running, START_m)
    assert not tick["limits"].any()
    assert np.abs(force_N).max() > 2.0
    # Steps of the wire, 10 pm and 0.1 uN, behind a stiff spring; what grows, grows with them.
    grown = max(1.0, np.abs(force_N[-400:]).max() / np.abs(force_N[running:running + 400]).max())
    assert np.abs(tick["manipulator_position_m"] - x_m).max() < 1e-10 * grown
    assert np.abs(tick["force_N"] - force_N).max() < 1e-4 * grown


@pytest.mark.long
@pytest.mark.parametrize("name", ["one mode", "two modes", "eight modes, well damped"])
def test_it_grows_as_its_eigenvalues_say(tmp_path, name):
    """Where one mode decides: the fit is to one."""
    values = BEAMS[name] | {"run.duration_s": 30.0}
    result = run_json(RIG, tmp_path, *settings(values))
    expected = np.log(loop_of(values).largest()) * 400.0
    assert result["prediction"]["growth_per_s"] == pytest.approx(expected, rel=1e-5)
    assert result["growth_per_s"] == pytest.approx(expected, rel=0.01)


@pytest.mark.long
def test_one_mode_is_the_object_of_one_degree_of_freedom(tmp_path):
    like_ess = {"run.duration_s": 60.0, "manipulator.initial_position_m": 0.01}
    beam = topic(run_json(RIG, tmp_path / "beam", *settings({"object.modes": 1} | like_ess))["log"])
    plain = topic(run_json("ess", tmp_path / "plain")["log"])
    for signal in ("manipulator_position_m", "robot_position_m", "force_N"):
        assert np.abs(beam[signal] - plain[signal]).max() < 1e-9 * max(1.0, np.abs(plain[signal]).max()), signal
    several = topic(run_json(RIG, tmp_path / "several", *settings({"object.modes": 2} | like_ess))["log"])
    assert len(several["index"]) == len(plain["index"])
    assert np.abs(several["manipulator_position_m"] - plain["manipulator_position_m"]).max() > 1e-5


def coupled_Hz(M, K):
    """First frequency of the clamped beam with a mass and a spring at its tip, by the beam's own equation."""
    def equation(b):
        end = rows_of(b, 1.0)
        start = rows_of(b, 0.0)
        w2 = (b / LENGTH_m) ** 4 * STIFFNESS_N_m2 / MASS_kg_per_m
        shear = STIFFNESS_N_m2 * (b / LENGTH_m) ** 3 * end[3] - (K - M * w2) * end[0]
        return np.linalg.det([start[0], start[1], end[2], shear / K])

    b = brentq(equation, 0.5, 3.0, xtol=1e-15)
    return (b / LENGTH_m) ** 2 * np.sqrt(STIFFNESS_N_m2 / MASS_kg_per_m) / (2.0 * np.pi)


@pytest.mark.long
def test_reduction():
    M, D, K = 200.0, 125.66370614359172, 7895.6835208714865
    errors = []
    for count in range(1, 9):
        beam = modes(count)
        done = command("reduce", RIG, "--json", *settings({"object.modes": count}))
        assert done.returncode == 0, done.stderr.decode()
        found = one_json_object(done.stdout)["object"]
        assert found["reduced"]["mass_kg"] == pytest.approx(100.0, rel=1e-9)
        assert found["reduced"]["stiffness_N_per_m"] == pytest.approx(2368.705056261446, rel=1e-9)
        assert found["reduced"]["damping_N_s_per_m"] == pytest.approx(19.46773764467334, rel=1e-9)
        assert [mode["stiffness_N_per_m"] for mode in found["modes"]] == pytest.approx(list(beam[:, 2]), rel=1e-8)
        # All modes, with the manipulator on the sum of their ways.
        inertia, damping, stiffness = (np.diag(beam[:, i]) + of for i, of in ((0, M), (1, D), (2, K)))
        zero, one = np.zeros_like(inertia), np.eye(count)
        rates = eigvals(np.block([[zero, one], [-stiffness, -damping]]), np.block([[one, zero], [zero, inertia]]))
        first = min((s for s in rates if s.imag > 0), key=abs)
        assert found["coupled"]["full"]["frequency_Hz"] == pytest.approx(first.imag / (2 * np.pi), rel=1e-9)
        assert found["coupled"]["full"]["damping_ratio"] == pytest.approx(-first.real / abs(first), rel=1e-8)
        radius = loop_of({"object.modes": count}).largest()
        assert found["loop"]["full"]["spectral_radius"] == pytest.approx(radius, abs=1e-10)
        assert found["loop"]["reduced"]["spectral_radius"] == pytest.approx(ESS_RADIUS, abs=5e-10)
        undamped = np.sqrt(eigvals(stiffness, inertia).real.min()) / (2 * np.pi)
        errors.append(undamped / coupled_Hz(M, K) - 1.0)
    assert all(0.0 < after < before for before, after in zip(errors, errors[1:])), errors
    assert errors[-1] < 0.01 * errors[0], errors


def test_a_whole_arm_swings_with_all_modes(tmp_path):
    """With the satellite held and the force held over a tick the arm ess is the manipulator of the rig but for what
    its joints' motors do."""
    arm_file = tmp_path / "held.toml"
    text = (ROOT / "sim_hal" / "arms" / "ess.toml").read_text()
    arm_file.write_text(text.replace('integrator = ', 'force = "held"\nintegrator = '))
    done = command("reduce", RIG, "--json", "--arm", arm_file, "--direction", "1,0", "--held", "--guided")
    assert done.returncode == 0, done.stderr.decode()
    found = one_json_object(done.stdout)
    arm, beam = found["poses"][0], found["object"]
    radius = loop_of({}).largest()
    assert arm["loop"]["reduced"]["spectral_radius"] == pytest.approx(radius, abs=1e-7)
    assert arm["loop"]["full"]["spectral_radius"] == pytest.approx(radius, abs=2e-5)
    assert arm["loop"]["full"]["spectral_radius"] != pytest.approx(radius, abs=1e-9)
    for number in ("frequency_Hz", "damping_ratio"):
        assert arm["coupled"]["full"][number] == pytest.approx(beam["coupled"]["full"][number], rel=1e-3)


@pytest.mark.long
def test_a_limit_is_where_the_largest_eigenvalue_crosses_the_circle():
    done = command("limits", RIG, "--json")
    assert done.returncode == 0, done.stderr.decode()
    found = one_json_object(done.stdout)["parameters"]["object.damping_N_s_per_m"]["above"]["value"]
    beam = modes(4)
    for share, is_stable in ((0.9999, False), (1.0001, True)):
        at = beam * [1.0, share * found / beam[0, 1], 1.0]
        assert (BeamLoop(rate_Hz=400.0, T_R=17.5e-3, T_S=2.5e-3, beam=at).largest() < 1.0) == is_stable


def test_the_map_varies_the_whole_beam(tmp_path):
    """An object twice as stiff is so in every mode: the beam with twice E I, its dampers as they were."""
    done = command("map", RIG, "--x", "object.stiffness_N_per_m=2368.705056261446:4737.410112522892:2", "--y",
                   "object.mass_kg=100:150:2", "--out", tmp_path)
    assert done.returncode == 0, done.stderr.decode()
    lines = next(tmp_path.glob("*.csv")).read_text().splitlines()
    rows = [[float(number) for number in line.split(",")[:3]] for line in lines if line[:1].isdigit()]
    assert len(rows) == 4
    for k, m, found in rows:
        beam = modes(4, mass_kg_per_m=m / 2.0, stiffness_N_m2=STIFFNESS_N_m2 * k / 2368.705056261446)
        beam[:, 1] = modes(4)[:, 1]
        loop = BeamLoop(rate_Hz=400.0, T_R=17.5e-3, T_S=2.5e-3, m=m, beam=beam)
        assert found == pytest.approx(loop.largest(), abs=2e-9), (k, m)


def test_the_map_varies_the_beam_itself(tmp_path):
    done = command("map", RIG, "--x", "object.beam_damping_ratio=0.02:0.1:2", "--y", "object.beam_length_m=8:9:2",
                   "--out", tmp_path)
    assert done.returncode == 0, done.stderr.decode()
    lines = next(tmp_path.glob("*.csv")).read_text().splitlines()
    rows = [[float(number) for number in line.split(",")[:3]] for line in lines if line[:1].isdigit()]
    assert len(rows) == 4
    for ratio, length_m, found in rows:
        stretch = length_m / LENGTH_m  # of a beam: m L, E I / L^3
        beam = modes(4, mass_kg_per_m=MASS_kg_per_m * stretch, stiffness_N_m2=STIFFNESS_N_m2 / stretch**3,
                     damping_ratio=ratio)
        loop = BeamLoop(rate_Hz=400.0, T_R=17.5e-3, T_S=2.5e-3, m=beam[0, 0], beam=beam)
        assert found == pytest.approx(loop.largest(), abs=2e-9), (ratio, length_m)


def test_the_resolved_rig_reads_back(tmp_path):
    text = command("run", RIG, "--print-config").stdout.decode()
    again = tmp_path / "again.toml"
    again.write_text(text)
    assert "beam_length_m = 8" in text
    assert "mass_kg" not in tomllib.loads(text)["object"], "it follows from the beam"
    assert command("run", again, "--print-config").stdout.decode() == text
    assert "beam_length_m" not in tomllib.loads(command("run", "ess", "--print-config").stdout.decode())["object"]


def test_file_and_line_are_named(tmp_path):
    text = command("run", RIG, "--print-config").stdout.decode()
    file = tmp_path / "bad.toml"
    for line, says in (("beam_length_m = 0.0001", "must be from 0.001 to 10000 (is 0.0001)"),
                       ("mass_kg = 3", "object.mass_kg: follows from the beam")):
        lines = text.splitlines()
        at = [line.startswith("beam_length_m") for line in lines].index(True)
        lines[at] = line
        file.write_text("\n".join(lines))
        done = command("run", file, "--out", tmp_path)
        assert done.returncode == EXIT_INPUT
        assert f"{file}:{at + 1}: object." in done.stderr.decode() and says in done.stderr.decode()
    file.write_text("\n".join(line for line in text.splitlines() if not line.startswith("beam_length_m")))
    done = command("run", file, "--out", tmp_path)
    assert done.returncode == EXIT_INPUT
    assert 'object.beam_length_m: is missing: object.kind = "beam" needs it' in done.stderr.decode()


@pytest.mark.parametrize("what", ["compensate", "accuracy", "diagnose"])
def test_what_knows_one_mode_only_says_so(tmp_path, what):
    words = [what, RIG]
    if what == "diagnose":
        words = [what, run_json(RIG, tmp_path, "--set", "run.duration_s=2")["log"], "--rig", RIG]
    elif what == "accuracy":
        file = tmp_path / "arm.toml"
        file.write_text(command("run", RIG, "--print-config", "--set", "manipulator.arm=ess", "--set",
                                "manipulator.initial_position_m=0").stdout.decode())
        words = [what, file]
    done = command(*words)
    assert done.returncode == EXIT_INPUT, done.stdout.decode()
    assert "object.modes: this reckons with an object of one degree of freedom" in done.stderr.decode()


@pytest.mark.long
def test_what_fell_at_first_and_then_grows_slowly_is_not_called_stable():
    """Eight modes: what the release left falls twenty-fold within the run, what grows hides below it."""
    words = ("--no-log", "--json", "--set", "object.modes=8", "--set", "object.beam_root_stiffness_N_m_per_rad=1e5",
             "--set", "object.beam_damping_ratio=0.06")
    short = one_json_object(command("run", "ess-beam", *words, "--set", "run.duration_s=20").stdout)
    long = one_json_object(command("run", "ess-beam", *words, "--set", "run.duration_s=120").stdout)
    assert short["growth_per_s"] is None and short["prediction"]["growth_per_s"] > 0
    assert short["stable"] is not True and long["stable"] is False
