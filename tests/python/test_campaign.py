"""Campaigns end to end: numbers are those of one rig at a time, and whatever dies, the table is the same."""

import json
import os
import re
import shlex
import shutil
import signal
import socket
import subprocess
import time

import berth
import numpy as np
import psutil
import pytest
from berth.campaign import Spec, report
from berth.campaign.evaluation import evaluate, version
from berth.campaign.report import Share
from campaigns import TOLERANCES, campaign, dask, rows_of, with_preload, written
from conftest import BERTH, EXIT_DIFFERENT, EXIT_DONE, EXIT_INPUT, command, limit_file_size

FIXED = '[set]\n"object.damping_N_s_per_m" = 3\n'
PLACES = [("ess", ""), ("ess", FIXED), ("ess", '[set]\n"prediction.enabled" = true\n'), ("ess-pose", ""), ("ess-beam", ""),
          ("concept-copper", ""), ("ess", '[set]\n"robot.backlash_m" = 0.001\n'),
          ("ess", '[set]\n"run.dead_time_jump_s" = 5\n"run.dead_time_jump_ms" = 15\n')]


@pytest.mark.parametrize("rig, more", PLACES)
def test_growth_is_that_of_each_rig_by_itself(rig, more):
    """Bit for bit, whether C++ varies the rig in place or each is read anew."""
    vary = "object.beam_damping_ratio" if rig == "ess-beam" else "manipulator.damping_N_s_per_m" if rig == "concept-copper" \
        else "object.mass_kg"
    own = berth.Rig.load(rig)[vary]
    spec = Spec.parse(f'rig = "{rig}"\n[sample]\ncount = 8\n[vary]\n"{vary}" = {{ from = {own * 0.8}, to = {own * 1.2} }}\n'
                      '"robot.dead_time_ms" = { from = 17, to = 30 }\n' + more)
    table = evaluate(spec, 0, 8, version)
    assert set(table["state"].to_pylist()) == {"done"}, table["reason"].to_pylist()
    for row in table.to_pylist():
        rig_of_row = berth.Rig.load(rig, {**spec.fixed, **{one.name: row[one.name] for one in spec.inputs}})
        found = rig_of_row.eigenvalues()
        assert (row["growth_per_s"], row["spectral_radius"], row["stable"]) == (
            found.growth_per_s, found.spectral_radius, found.stable)
        assert row["commit"] == berth.__version__


def test_presets_and_words_vary_too():
    spec = Spec.parse('rig = "ess"\n[sample]\nmethod = "grid"\n[vary]\npreset = ["ur10e-servoj", "abb-egm"]\n'
                      '"robot.interpolation" = ["hold", "linear"]\n"object.mass_kg" = [20, 120]\n')
    table = evaluate(spec, 0, spec.count, version)
    for row in table.to_pylist():
        found = berth.Rig.load("ess", {key: row[key] for key in ("robot.interpolation", "object.mass_kg")},
                               robot=row["preset"]).eigenvalues()
        assert row["growth_per_s"] == found.growth_per_s


def test_each_question_has_the_answer_of_the_package():
    spec = Spec.parse('rig = "ess"\nask = ["growth", "verdict", "margins", "peak_force", "restitution", "fidelity", '
                      '"compensation"]\n[set]\n"run.duration_s" = 3\n"sensor.noise_N" = 1\n[sample]\ncount = 1\n[vary]\n'
                      '"object.mass_kg" = { from = 100, to = 140 }\n')
    row = evaluate(spec, 0, 1, version).to_pylist()[0]
    rig = berth.Rig.load("ess", {**spec.fixed, "object.mass_kg": row["object.mass_kg"], "run.seed": row["seed"]})
    verdict, ran, best = rig.verdict(), rig.run(), rig.compensate()
    assert (row["verdict"], row["dead_time_margin_ms"], row["modulus"]) == (
        verdict.kind, verdict.dead_time_margin_ms, verdict.modulus)
    assert (row["run_verdict"], row["peak_force_N"], row["run_growth_per_s"]) == (
        ran.verdict.kind, ran.measured_peak_N, ran.verdict.growth_per_s)
    assert row["compensation"] == best.recommended
    assert row["motion_error"] == next(one.error for one in best.methods if one.method == "none")


def test_records_are_diagnosed(tmp_path):
    hidden = {"robot.transfer_frequency_Hz": 12, "run.duration_s": 10, "profile.kind": "multisine",
              "profile.amplitude_m": 0.01, "profile.duration_s": 9, "sensor.noise_N": 0.3}
    berth.Rig.load("ess", hidden).run(log=tmp_path / "record.ulg", advice=False)
    (tmp_path / "empty.ulg").write_bytes(b"")
    file = tmp_path / "records.toml"
    file.write_text('rig = "ess"\nask = ["diagnosis"]\n[sample]\nmethod = "grid"\n[vary]\nrecord = { files = ["*.ulg"] }\n')
    spec = Spec.load(file)
    broken, good = evaluate(spec, 0, 2, version).to_pylist()
    assert broken["state"] == "refused" and "empty.ulg" in broken["reason"]
    found = berth.diagnose(tmp_path / "record.ulg", berth.Rig.load("ess"))
    assert (good["diagnosis"], good["cause"], good["cause_value"]) == (
        found.verdict, found.causes[0].effect, found.causes[0].parameters[0].value)


def test_a_refused_rig_is_a_row_with_its_reason():
    spec = Spec.parse('rig = "ess"\n[sample]\ncount = 32\n[vary]\n"object.mass_kg" = { mean = 10, sigma = 10 }\n')
    rows = evaluate(spec, 0, 32, version).to_pylist()
    refused = [row for row in rows if row["object.mass_kg"] <= 0]
    assert 2 < len(refused) < 16
    for row in rows:
        if row in refused:
            assert row["state"] == "refused" and "object.mass_kg" in row["reason"] and row["growth_per_s"] is None
            assert row["stable"] is None
        else:
            assert row["state"] == "done" and row["reason"] is None and math_is_finite(row["growth_per_s"])


def math_is_finite(value):
    return value is not None and np.isfinite(value)


def wilson(stable, known, z=1.959963984540054):
    middle = (stable + z * z / 2) / (known + z * z)
    reach = z / (known + z * z) * np.sqrt(stable * (known - stable) / known + z * z / 4)
    return middle - reach, middle + reach


@pytest.mark.parametrize("stable, known", [(0, 10), (3, 10), (10, 10), (762, 1000), (999_999, 1_000_000)])
def test_the_interval_is_wilsons(stable, known):
    found = Share.of(stable, known)
    np.testing.assert_allclose((found.low, found.high), wilson(stable, known), rtol=1e-9, atol=1e-12)


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """A campaign that nothing happens to, by the command: its file, its folder and what it printed."""
    folder = tmp_path_factory.mktemp("undisturbed")
    file = written(folder, 1024)
    done = campaign(file, "--out", folder / "out")
    assert done.returncode == EXIT_DONE, done.stderr.decode()
    return file, folder / "out", done.stdout.decode()


def test_the_table_has_each_sample_once_in_order(undisturbed):
    _, folder, printed = undisturbed
    table = rows_of(folder)
    assert table.column_names == ["sample", "seed", "object.mass_kg", "robot.dead_time_ms", "stable", "growth_per_s",
                                  "spectral_radius", "state", "reason", "commit"]
    assert table["sample"].to_pylist() == list(range(1024))
    assert not (folder / "parts").exists()
    assert f"{np.mean(table['stable'].to_pylist()):.4f}" in printed


def test_the_report_says_what_the_table_says(undisturbed):
    file, folder, _ = undisturbed
    done = command("campaign", "report", folder)
    printed = done.stdout.decode()
    assert done.returncode == EXIT_DONE and not done.stderr, done.stderr.decode()
    assert (folder / "report.html").stat().st_size > 20_000 and (folder / "report.png").stat().st_size > 5_000
    found = report(folder)
    table = rows_of(folder)
    growth = np.array(table["growth_per_s"])
    assert [one.sample for one in found.worst] == np.argsort(-growth, kind="stable")[:5].tolist()
    mass = np.array(table["object.mass_kg"])
    stable = np.array(table["stable"].to_pylist())
    over = next(one for one in found.over if one.name == "object.mass_kg")
    for low, high, share in zip(over.edges, over.edges[1:], over.shares):
        inside = (mass >= low) & ((mass < high) | (high == over.edges[-1]))
        assert (share.stable, share.known) == (stable[inside].sum(), inside.sum())
    assert "object.mass_kg" in printed and "robot.dead_time_ms" in printed


def test_the_printed_command_repeats_the_worst_sample(undisturbed):
    _, folder, printed = undisturbed
    line = re.search(r"^ +berth (eigen .+)$", printed, re.M)[1]
    done = command(*shlex.split(line), "--json")
    assert json.loads(done.stdout)["growth_per_s"] == max(rows_of(folder)["growth_per_s"].to_pylist())


def test_an_estimate_holds_the_probability_that_is_known():
    """Uniform mass: the rig's limit cuts the range where it does."""
    limit_kg = berth.Rig.load("ess").limits()["object.mass_kg"].above
    spec = Spec.parse('rig = "ess"\n[sample]\ncount = 512\n[vary]\n"object.mass_kg" = { from = 150, to = 230 }\n')
    stable = np.array(evaluate(spec, 0, 512, version)["stable"].to_pylist())
    known = (limit_kg - 150) / 80
    share = Share.of(stable.sum(), 512)
    assert share.low < known < share.high and share.value == pytest.approx(known, abs=2 / 512)


def test_saltelli_gives_sobols_indices(tmp_path):
    """Of an output that is known: growth is replaced by Ishigami's function, whose indices are closed forms."""
    from berth.campaign import sensitivity
    import pyarrow as pa
    text = 'rig = "ess"\n[sample]\nmethod = "saltelli"\ncount = 20480\n[vary]\n' + "".join(
        f'"{key}" = {{ from = 100, to = 200 }}\n' for key in ("object.mass_kg", "manipulator.mass_kg", "robot.dead_time_ms"))
    spec = Spec.parse(text)
    from berth.campaign.sampling import rows
    inputs = rows(spec, 0, spec.count)
    x = [(values - 150) / 50 * np.pi for values in inputs.values()]
    y = np.sin(x[0]) + 7 * np.sin(x[1]) ** 2 + 0.1 * x[2] ** 4 * np.sin(x[0])
    found = {one.name: one for one in sensitivity.influences(spec, pa.table({**inputs, "growth_per_s": y}), True)}
    for name, first, total in (("object.mass_kg", 0.3139, 0.5576), ("manipulator.mass_kg", 0.4424, 0.4424),
                               ("robot.dead_time_ms", 0.0, 0.2437)):
        assert found[name].method == "sobol"
        assert found[name].first == pytest.approx(first, abs=0.02) and found[name].other == pytest.approx(total, abs=0.02)


# --- what may happen on the way -------------------------------------------------------------------------------------
def test_a_full_disk_loses_nothing(undisturbed, tmp_path):
    file, folder, _ = undisturbed
    done = campaign(file, "--out", tmp_path / "out", preexec_fn=limit_file_size(20_000))
    assert done.returncode == EXIT_INPUT and b"cannot be written" in done.stderr and b"--resume" in done.stderr
    assert not list((tmp_path / "out").rglob("*.unfinished"))
    again = campaign(file, "--out", tmp_path / "out", "--resume")
    assert again.returncode == EXIT_DONE, again.stderr.decode()
    assert (tmp_path / "out" / "samples.parquet").read_bytes() == (folder / "samples.parquet").read_bytes()


def test_a_finished_campaign_is_not_begun_again(undisturbed, tmp_path):
    file, folder, _ = undisturbed
    assert b"--resume" in campaign(file, "--out", folder).stderr
    assert campaign(file, "--out", folder, "--resume").returncode == EXIT_DONE
    other = written(tmp_path, 512)
    done = campaign(other, "--out", folder, "--resume")
    assert done.returncode == EXIT_INPUT and b"another campaign file" in done.stderr
    assert (folder / "samples.parquet").exists()


def test_begun_anew_is_the_new_campaign_alone(tmp_path):
    from berth.campaign.table import Table
    file, other = written(tmp_path, 4), written(tmp_path, 2, name="other.toml")
    with Table(Spec.load(file), tmp_path / "out") as table:
        table.add(evaluate(table.spec, 0, 3, version))
        assert table.missing() == [(3, 1)]
        with pytest.raises(berth.InputError, match="another process"):
            Table(table.spec, tmp_path / "out")
    with Table(Spec.load(other), tmp_path / "out", anew=True) as table:
        assert table.missing() == [(0, 2)]


SLOW = """
def instead(spec, inputs, count):
    time.sleep(0.01 * count)
    return whole(spec, inputs, count)
"""


def workers_of(process):
    """Dask's workers, which its nannies start anew as they die."""
    return [one for one in psutil.Process(process.pid).children() if "spawn_main" in " ".join(one.cmdline())]


@pytest.mark.long
def test_ten_killed_workers_change_no_bit(undisturbed, tmp_path):
    file, folder, _ = undisturbed
    out = tmp_path / "out"
    process = subprocess.Popen([BERTH, "campaign", file, "--workers", "2", "--out", out], stderr=subprocess.PIPE,
                               stdout=subprocess.DEVNULL, env=with_preload(tmp_path, SLOW))
    killed = 0
    while process.poll() is None and killed < 10:
        time.sleep(0.2)
        if list((out / "parts").glob("*.parquet")) and (workers := workers_of(process)):
            workers[killed % len(workers)].send_signal(signal.SIGKILL)
            killed += 1
    _, stderr = process.communicate(timeout=120)
    assert process.returncode == EXIT_DONE and killed == 10, (killed, stderr.decode())
    assert (out / "samples.parquet").read_bytes() == (folder / "samples.parquet").read_bytes()


FATAL = """
def instead(spec, inputs, count):
    if abs(inputs["object.mass_kg"] - {mass!r}).min() < 1e-12:
        {what}
    return whole(spec, inputs, count)
"""


@pytest.mark.long
@pytest.mark.parametrize("what, state, words", [("os._exit(9)", "lost", "its worker died 3 times"),
                                                ("raise KeyError('loose')", "failed", "KeyError: 'loose'")])
def test_a_rig_that_ends_its_worker_costs_that_sample_alone(what, state, words, tmp_path):
    file = written(tmp_path, 64)
    whole = evaluate(Spec.load(file), 0, 64, version)
    fatal = FATAL.format(mass=whole["object.mass_kg"][40].as_py(), what=what)
    done = campaign(file, "--out", tmp_path / "out", env=with_preload(tmp_path, fatal))
    assert done.returncode == EXIT_DONE, done.stderr.decode()
    table = rows_of(tmp_path / "out")
    assert table["state"][40].as_py() == state and words in table["reason"][40].as_py()
    assert table.slice(0, 40).equals(whole.slice(0, 40)) and table.slice(41).equals(whole.slice(41))
    assert words in done.stdout.decode()


def test_a_campaign_that_takes_years_asks_first(tmp_path):
    file = written(tmp_path, 10**13)
    done = campaign(file, "--out", tmp_path / "out")
    told = done.stderr.decode()
    assert done.returncode == EXIT_INPUT
    assert re.search(r"sample.count: 10,000,000,000,000 samples take about [\d.e+]+ years on 2 workers", told), told
    assert "--yes" in told and " GB" in told and not list((tmp_path / "out" / "parts").glob("*"))


# --- a scheduler that is there, or is not ---------------------------------------------------------------------------
def test_a_scheduler_that_is_not_there_is_named(tmp_path):
    done = command("campaign", written(tmp_path), "--scheduler", "tcp://127.0.0.1:1", "--out", tmp_path / "out")
    assert done.returncode == EXIT_INPUT
    assert b"--scheduler tcp://127.0.0.1:1: no scheduler answers" in done.stderr and b"dask worker" in done.stderr


def test_slurm_that_is_not_there_is_named(tmp_path):
    done = command("campaign", written(tmp_path), "--slurm", "--out", tmp_path / "out", env={**os.environ, "PATH": "/usr/bin"})
    assert done.returncode == EXIT_INPUT and b"--slurm: sbatch is not on this machine" in done.stderr


def test_without_the_package_one_line_says_how_to_install_it(tmp_path):
    """A copy of the program, away from the repository, with a Python that has no berth."""
    shutil.copy(BERTH, tmp_path / "berth")
    done = command("campaign", written(tmp_path), program=(tmp_path / "berth",), env={**os.environ, "PATH": "/usr/bin:/bin"})
    assert done.returncode == EXIT_INPUT
    lines = done.stderr.decode().splitlines()
    assert len(lines) == 1 and "the Python package of berth is missing for python3: install it with `make wheel`" in lines[0]


@pytest.fixture
def scheduler():
    """A scheduler on its own: its process and its address."""
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    process = dask("scheduler", "--host", "127.0.0.1", "--port", port, "--no-dashboard", "--no-show")
    yield process, f"tcp://127.0.0.1:{port}"
    process.kill()
    process.wait()


@pytest.fixture
def worker():
    """A function that starts a worker: (address of its scheduler, environment)."""
    started = []

    def start(address, folder, **options):
        started.append(dask("worker", address, "--nthreads", 1, "--no-dashboard", "--no-nanny", "--local-directory", folder,
                            **options))
    yield start
    for process in started:
        process.kill()
        process.wait()


@pytest.mark.long
def test_a_scheduler_that_dies_loses_nothing(undisturbed, scheduler, worker, tmp_path):
    file, folder, _ = undisturbed
    process, address = scheduler
    worker(address, tmp_path, env=with_preload(tmp_path, SLOW))
    out = tmp_path / "out"
    with subprocess.Popen([BERTH, "campaign", file, "--scheduler", address, "--out", out], stderr=subprocess.PIPE,
                          stdout=subprocess.DEVNULL) as client:
        while client.poll() is None and not list((out / "parts").glob("*.parquet")):
            time.sleep(0.1)
        process.kill()
        _, stderr = client.communicate(timeout=120)
    assert client.returncode == EXIT_DIFFERENT, stderr.decode()
    assert b"the scheduler is gone" in stderr and b"--resume" in stderr
    done = campaign(file, "--out", out, "--resume")
    assert done.returncode == EXIT_DONE and b"samples are there already" in done.stderr, done.stderr.decode()
    assert (out / "samples.parquet").read_bytes() == (folder / "samples.parquet").read_bytes()


@pytest.mark.long
def test_two_versions_of_berth_are_refused(scheduler, worker, tmp_path):
    _, address = scheduler
    worker(address, tmp_path, env=with_preload(tmp_path, "evaluation.version = 'another'\ndef instead(): pass\n"))
    done = command("campaign", written(tmp_path), "--scheduler", address, "--out", tmp_path / "out")
    assert done.returncode == EXIT_INPUT, done.stderr.decode()
    assert b"another berth" in done.stderr and b": another, and the campaign " in done.stderr
