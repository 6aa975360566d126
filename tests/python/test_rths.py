"""`berth rths`: the public benchmark of virtual real-time hybrid simulation.

The port against matrix exponentials in numpy, on a frame and an earthquake of this file; then against the figures
that others recomputed, on the benchmark's own data.
"""

import gzip

import numpy as np
import pytest
from conftest import EXIT_DONE, EXIT_INPUT, command, data_folder, one_json_object
from scipy.linalg import expm

RATE_Hz = 4096.0
T_s = 1.0 / RATE_Hz
CRITERIA = ["J1_ms"] + [f"J{n}_percent" for n in range(2, 10)]

# The nominal hardware, as the benchmark's definition has it.
MASS_kg, STIFFNESS_N_per_m, DAMPING_RATIO = 29.13, 1.19e6, 0.0097
GAIN, A1_BETA0, BETA1, BETA2, A2, A3 = 1.0261, 2.1283e13, 425.0, 9.9976e4, 4.2297e6, 3.3

# A frame like those of the benchmark, not one of them.
FRAME_M = np.diag([900.0, 1000.0, 1100.0])
FRAME_K = np.array([[26.0, -23.0, 5.9], [-23.0, 32.0, -14.0], [5.9, -14.0, 9.1]]) * 1e6
FRAME_C = 10.0 * FRAME_M + 2e-4 * FRAME_K


def matrix_text(*matrices):
    return "# of a test\n" + "\n".join(" ".join(f"{value:.17g}" for value in row) for m in matrices for row in m) + "\n"


@pytest.fixture(scope="module")
def own_data(tmp_path_factory):
    """Folder with a frame and 6 s of a smooth earthquake."""
    folder = tmp_path_factory.mktemp("rths")
    (folder / "case_1.txt").write_text(matrix_text(FRAME_M, FRAME_C, FRAME_K))
    t_s = np.arange(0, 6 * 64 + 1) / 64.0  # on samples of the run
    ground = np.sin(2.0 * np.pi * 1.3 * t_s) * np.exp(-0.3 * t_s) + 0.7 * np.sin(2.0 * np.pi * 3.1 * t_s)
    ground *= np.minimum(1.0, t_s)
    with gzip.open(folder / "el_centro.csv.gz", "wt") as file:
        file.write("t_s,ground_acceleration_m_per_s2\n")
        file.writelines(f"{t:.17g},{a:.17g}\n" for t, a in zip(t_s, ground))
    return folder, t_s, 0.4 * ground


def samples_of(tmp_path, folder, *arguments):
    path = tmp_path / "samples.csv"
    done = command("rths", folder, "--samples", path, "--json", *arguments)
    assert done.returncode == EXIT_DONE, done.stderr.decode()
    return np.genfromtxt(path, delimiter=",", names=True), one_json_object(done.stdout)


def held_step(a, b, ramp):
    """x' = a x + b u + ramp's column times (g0 + (g1 - g0) t/T): exact over one sample."""
    n, m = a.shape[0], b.shape[1]
    block = np.zeros((n + m + 2, n + m + 2))
    block[:n, :n] = a
    block[:n, n:n + m] = b
    block[:n, n + m] = ramp
    block[n + m, n + m + 1] = 1.0 / T_s
    e = expm(block * T_s)
    return e[:n, :n], e[:n, n:n + m], e[:n, n + m], e[:n, n + m + 1]


def transfer_matrices():
    c = 2.0 * DAMPING_RATIO * np.sqrt(STIFFNESS_N_per_m * MASS_kg)
    a = np.array([[0, 1, 0, 0, 0], [-BETA2, -BETA1, 0, -A1_BETA0, 0], [1, 0, -A3, 0, -A2], [0, 0, 0, 0, 1],
                  [0, 0, 1 / MASS_kg, -STIFFNESS_N_per_m / MASS_kg, -c / MASS_kg]])
    return a, np.array([0.0, GAIN * A1_BETA0, 0.0, 0.0, 0.0])[:, None], c


def frame_matrices(with_specimen_simulated):
    m, c, k = FRAME_M.copy(), FRAME_C.copy(), FRAME_K.copy()
    if not with_specimen_simulated:
        m[0, 0] -= MASS_kg
        c[0, 0] -= transfer_matrices()[2]
        k[0, 0] -= STIFFNESS_N_per_m
    inverse = np.linalg.inv(m)
    a = np.block([[np.zeros((3, 3)), np.eye(3)], [-inverse @ k, -inverse @ c]])
    force = np.concatenate([np.zeros(3), -inverse[:, 0]])[:, None]
    ground = np.concatenate([np.zeros(3), -inverse @ FRAME_M @ np.ones(3)])
    return a, force, ground


class Tustin:
    """Transfer function b / a of s, by substitution of s = 2/T (z - 1)/(z + 1)."""

    def __init__(self, b, a):
        from scipy.signal import bilinear

        self.b, self.a = bilinear(b, a, fs=RATE_Hz)
        self.inputs, self.outputs = np.zeros(2), np.zeros(1)

    def __call__(self, value):
        self.inputs = np.array([value, self.inputs[0]])
        self.outputs = np.array([(self.b @ self.inputs - self.a[1] * self.outputs[0]) / self.a[0]])
        return self.outputs[0]


def reference_run(t_s, ground, count):
    """The benchmark with the PI controller, without noise: samples of target, hardware, force and reference."""
    frame = held_step(*frame_matrices(False))
    whole = held_step(*frame_matrices(True))
    transfer_a, transfer_b, _ = transfer_matrices()
    hardware = held_step(transfer_a, transfer_b, np.zeros(5))
    lead, pi = Tustin([50.83, 8570.4], [1.0, 8570.4]), Tustin([2.0, 95.0], [1.0, 0.0])
    x, r, p, late_N = np.zeros(6), np.zeros(6), np.zeros(5), 0.0
    rows = []
    at = np.interp(T_s * np.arange(count + 1), t_s, ground, right=0.0)
    for n in range(count):
        command_m = pi(lead(x[0]) - p[3])
        rows.append([command_m, x[0], x[2], p[3], p[2], r[0], r[2]])
        slope = at[n + 1] - at[n]
        force_N, late_N = late_N, p[2]
        x = frame[0] @ x + frame[1][:, 0] * force_N + frame[2] * at[n] + frame[3] * slope
        r = whole[0] @ r + whole[2] * at[n] + whole[3] * slope
        p = hardware[0] @ p + hardware[1][:, 0] * command_m
    return np.array(rows).T


def test_the_port_agrees_with_matrix_exponentials(own_data, tmp_path):
    """Without noise. The earthquake bends on samples only: what is left is the error of the fixed step."""
    folder, t_s, ground = own_data
    got, _ = samples_of(tmp_path, folder, "--noise", 0)
    count = int(t_s[-1] * RATE_Hz) + 1
    assert len(got) == count
    names = ["command_m", "simulated_1_m", "simulated_3_m", "true_m", "true_N", "reference_1_m", "reference_3_m"]
    for name, want in zip(names, reference_run(t_s, ground, count)):
        error = np.abs(got[name] - want).max() / np.abs(want).max()
        print(f"{name}: off by {error:.1e} of its largest value")
        assert error < 1e-7, name
    assert np.array_equal(got["measured_m"], got["true_m"])


def test_the_criteria_are_those_of_numpy(own_data, tmp_path):
    """From the samples of a noisy run."""
    got, told = samples_of(tmp_path, own_data[0], "--seed", 3)
    measured, floor_1, reference_1 = got["measured_m"], got["simulated_1_m"], got["reference_1_m"]

    def spread(a, b):
        return 100.0 * np.std(a - b, ddof=1) / np.std(b, ddof=1)

    def peak(a, b):
        return 100.0 * np.abs(a - b).max() / np.abs(b).max()

    lags = [np.corrcoef(measured[n:], floor_1[:len(floor_1) - n])[0, 1] for n in range(50)]
    upper = [(got[f"simulated_{n}_m"], got[f"reference_{n}_m"]) for n in (2, 3)]
    want = [1e3 * T_s * np.argmax(lags), spread(measured, floor_1), peak(measured, floor_1),
            spread(measured, reference_1), peak(measured, reference_1),
            *(spread(*pair) for pair in upper), *(peak(*pair) for pair in upper)]
    assert [told["nominal"][name] for name in CRITERIA] == pytest.approx(want, rel=1e-9)


def test_noise_and_converters(own_data, tmp_path):
    """16 um of noise on a grid of 2^-18 m, 2.2 N on none. Hardware and frame follow, exactly, what a noisy run says
    that they were given: the command on its grid, and the measured force of a sample before."""
    seed = 11
    folder, t_s, ground = own_data
    got, _ = samples_of(tmp_path, folder, "--seed", seed)
    step_m = 2.0**-18
    expected = {"m": np.sqrt(6.25e-14 * RATE_Hz + step_m**2 / 12.0), "N": np.sqrt(1.16e-3 * RATE_Hz)}
    for unit, want in expected.items():
        noise = np.std(got[f"measured_{unit}"] - got[f"true_{unit}"])
        print(f"seed {seed}: {noise:.4e} {unit}, expected {want:.4e} {unit}")
        assert noise == pytest.approx(want, rel=4.0 / np.sqrt(2.0 * len(got)))
    assert np.array_equal(got["measured_m"] / step_m, np.round(got["measured_m"] / step_m))

    frame = held_step(*frame_matrices(False))
    transfer_a, transfer_b, _ = transfer_matrices()
    hardware = held_step(transfer_a, transfer_b, np.zeros(5))
    at = np.interp(T_s * np.arange(len(got) + 1), t_s, ground, right=0.0)
    x, p, floor_m, hardware_m = np.zeros(6), np.zeros(5), [], []
    for n in range(len(got)):
        floor_m.append(x[0])
        hardware_m.append(p[3])
        late_N = got["measured_N"][n - 1] if n > 0 else 0.0
        x = frame[0] @ x + frame[1][:, 0] * late_N + frame[2] * at[n] + frame[3] * (at[n + 1] - at[n])
        p = hardware[0] @ p + hardware[1][:, 0] * np.round(got["command_m"][n] / step_m) * step_m
    assert np.abs(floor_m - got["simulated_1_m"]).max() < 1e-7 * np.abs(floor_m).max()
    # Noise in the command shakes the hardware's fast mode, where the fixed step is less exact.
    assert np.abs(hardware_m - got["true_m"]).max() < 1e-6 * np.abs(hardware_m).max()


def test_the_same_seed_gives_the_same_run_and_another_another(own_data):
    runs = [command("rths", own_data[0], "--perturbed", 2, "--json", "--seed", seed).stdout for seed in (5, 5, 6)]
    assert runs[0] == runs[1] != runs[2]
    told = one_json_object(runs[0])
    for name in CRITERIA:
        assert told["worst_of_perturbed"][name] == max(run[name] for run in told["perturbed"])
    assert told["perturbed"][0] != told["perturbed"][1]


@pytest.mark.parametrize("arguments, said", [
    (["--case", "5"], "--case"), (["--earthquake", "x"], "el_centro"), (["--controller", "x"], "pi"),
    (["--case", "2"], "case_2.txt"), (["--earthquake", "kobe"], "kobe.csv.gz"), (["--perturbed", "-1"], "--perturbed"),
    (["--seed", "-1"], "--seed"), (["--noise", "-1"], "--noise"),
    (["--force-age", "1.5"], "--force-age"), (["--samples", "no/such/folder"], "no/such/folder"),
])
def test_wrong_arguments_are_told(own_data, arguments, said):
    done = command("rths", own_data[0], *arguments)
    assert done.returncode == EXIT_INPUT and done.stdout == b""
    assert said in done.stderr.decode()


@pytest.mark.parametrize("text, said", [
    (matrix_text(FRAME_M, FRAME_C), "6 rows"), (matrix_text(FRAME_M, FRAME_C, FRAME_K, FRAME_K), "case_1.txt:11"),
    (matrix_text(FRAME_M, FRAME_C, FRAME_K).replace("900", "x"), "case_1.txt:2"),
    (matrix_text(FRAME_M, FRAME_C, -FRAME_K), "K [N/m]"), (matrix_text(0.01 * FRAME_M, FRAME_C, FRAME_K), "specimen"),
    (matrix_text(FRAME_M * np.nan, FRAME_C, FRAME_K), "case_1.txt"),
])
def test_a_wrong_frame_is_told(own_data, tmp_path, text, said):
    (tmp_path / "el_centro.csv.gz").write_bytes((own_data[0] / "el_centro.csv.gz").read_bytes())
    (tmp_path / "case_1.txt").write_text(text)
    done = command("rths", tmp_path)
    assert done.returncode == EXIT_INPUT and done.stdout == b""
    assert said in done.stderr.decode()


# --- the benchmark's own data -------------------------------------------------------------------------------------
@pytest.fixture(scope="module")
def benchmark_data():
    folder = data_folder()
    if folder is None or not (folder / "rths" / "case_1.txt").exists():
        pytest.skip("THE PUBLIC BENCHMARK WAS NOT RUN: no rths/case_1.txt in $BERTH_DATA or ../shared/data")
    return folder / "rths"


def run_benchmark(folder, *arguments):
    done = command("rths", folder, "--json", *arguments)
    assert done.returncode == EXIT_DONE, done.stderr.decode()
    return one_json_object(done.stdout)


SEEDS = range(1, 11)
PEAKS = ("J3_percent", "J5_percent")  # among them that of the noise, which is another for every seed


def criteria_over_seeds(folder, *arguments):
    """Criteria of the nominal plant, a row for each seed."""
    runs = [run_benchmark(folder, *arguments, "--seed", seed)["nominal"] for seed in SEEDS]
    return np.array([[run[name] for name in CRITERIA] for run in runs])


@pytest.mark.long
@pytest.mark.parametrize("controller, case, row", [
    ("pi", 1, [4.64, 10.37, 11.56, 36.0, 18.4, 32.2, 32.3, 14.8, 14.8]),
    ("pi", 4, [4.64, 10.46, 11.41, 72.5, 35.5, 68.5, 68.6, 33.4, 33.3]),
    ("inverse", 1, [4.64, 10.48, 11.09, 34.2, 17.3, 31.3, 31.3, 14.7, 14.6]),
])
def test_the_recomputed_rows_come_out(benchmark_data, controller, case, row):
    """Every figure within 1 %, a peak as far off as one seed's noise brings it; those of the PI within 3 % as well."""
    runs = criteria_over_seeds(benchmark_data, "--controller", controller, "--case", case)
    mean, spread = runs.mean(axis=0), runs.std(axis=0, ddof=1)
    for name, got, sd, want in zip(CRITERIA, mean, spread, row):
        print(f"seeds {SEEDS}: {name} {got:.3f}, sd {sd:.3f}, recomputed {want} ({got / want - 1.0:+.2%})")
        assert abs(got - want) < (3.0 * sd if name in PEAKS else 0.01 * want), name
        if controller == "pi":
            assert got == pytest.approx(want, rel=0.03), name


# The adaptive model-based rows; case 4 has none for perturbed plants.
ADAPTIVE = {1: [0.0, 2.55, 2.17, 3.19, 2.45, 1.85, 1.85, 1.10, 1.09],
            4: [0.0, 1.98, 1.92, 3.64, 2.86, 3.01, 3.02, 1.51, 1.50]}
ADAPTIVE_WORST_OF_20 = {1: [0.0, 2.56, 2.19, 3.24, 2.49, 1.92, 1.93, 1.16, 1.15], 4: ADAPTIVE[4]}


@pytest.mark.long
@pytest.mark.parametrize("case", [1, 4])
def test_the_firmware_is_better_than_the_adaptive_rows(benchmark_data, case):
    """Nominal and worst of 20 plants. J2 is the sensor's noise over the simulated motion: a loop that shakes the frame
    more than the earthquake does has a lower one, so it is held against the floor of its own run. The bands are
    two-sided: J2 below its floor would be a mistake in J2."""
    seed = 1
    told = run_benchmark(benchmark_data, "--controller", "firmware", "--case", case, "--perturbed", 20, "--seed", seed)
    for name, got, worst, row, worst_row in zip(CRITERIA, *([told[of][name] for name in CRITERIA]
                                                for of in ("nominal", "worst_of_perturbed")),
                                                ADAPTIVE[case], ADAPTIVE_WORST_OF_20[case]):
        print(f"seed {seed}: {name} {got:.3f}, worst of 20 {worst:.3f}; adaptive {row}, {worst_row}")
        if name != "J2_percent":
            assert got <= row and worst <= worst_row, name
    for run in (told["nominal"], *told["perturbed"]):
        assert 0.999 < run["J2_percent"] / run["noise_floor_percent"] < 1.01
    assert 0.0 < told["nominal"]["J6_percent"] < 0.1 and 0.0 < told["nominal"]["J7_percent"] < 0.1


@pytest.mark.long
@pytest.mark.parametrize("case", [1, 4])
def test_told_a_younger_force_than_it_is_every_figure_is_that_of_the_adaptive_rows_or_better(benchmark_data, case):
    """J2 included: the frame then moves a little more. To the rows' two digits; case 4 has none for perturbed plants."""
    seed = 1
    told = run_benchmark(benchmark_data, "--controller", "firmware", "--force-age", 0.1, "--case", case,
                         "--perturbed", 20, "--seed", seed)
    for of, row in (("nominal", ADAPTIVE[case]), ("worst_of_perturbed", ADAPTIVE_WORST_OF_20[case])):
        for name, at_most in zip(CRITERIA, row):
            got = round(told[of][name], 2)
            print(f"seed {seed}: {of} {name} {got}, adaptive {at_most}")
            assert got <= at_most, name
    assert told["nominal"]["J2_percent"] < 1.1 * told["nominal"]["noise_floor_percent"]
    assert told["nominal"]["J6_percent"] > 1.0  # the price: exactly the frame's motion is not got this way


@pytest.mark.slow
def test_the_peak_of_the_tracking_error_is_that_of_the_noise(benchmark_data):
    """So the worst of 20 plants is a matter of luck: it is 2.19 or less in 6 of 10 sets of them, and so is the noise
    alone."""
    seed = 1
    told = run_benchmark(benchmark_data, "--controller", "firmware", "--perturbed", 200, "--seed", seed)
    found, noise = (np.array([run[name] for run in told["perturbed"]]) for name in ("J3_percent", "noise_peak_percent"))
    sets = [(values.reshape(10, 20).max(axis=1) <= 2.19).sum() for values in (found, noise)]
    print(f"seed {seed}: in {sets} of 10 sets; J3 over the noise's peak {np.median(found / noise):.3f} in the middle")
    assert sets[0] == pytest.approx(sets[1], abs=1)
    assert np.median(found / noise) == pytest.approx(1.0, abs=0.01)


@pytest.mark.long
def test_with_the_late_force_tracking_alone_is_better_than_the_adaptive_row(benchmark_data):
    """Case 1, in every figure, J2 too: both frames move too much, by the same cause."""
    mean = criteria_over_seeds(benchmark_data, "--controller", "firmware-late").mean(axis=0)
    print(f"seeds {SEEDS}:", *(f"{got:.3f} ({row})" for got, row in zip(mean, ADAPTIVE[1])))
    assert all(got <= row for got, row in zip(mean, ADAPTIVE[1]))
    assert mean[CRITERIA.index("J6_percent")] == pytest.approx(1.68, rel=0.03)


@pytest.mark.parametrize("case, floor", [(1, 2.09), (4, 1.36)])
def test_noise_floor_of_j2(benchmark_data, case, floor):
    told = run_benchmark(benchmark_data, "--case", case)
    assert told["nominal"]["noise_floor_percent"] == pytest.approx(floor, rel=0.01)
