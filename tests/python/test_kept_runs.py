"""Runs that are kept: their names, their list, compare and report, and logs of somebody else."""

import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys

import pytest
from conftest import BERTH, EXIT_DONE, EXIT_INPUT, ROOT, SHORT, berth, one_json_object, settings

sys.path.insert(0, str(ROOT / "scripts"))
from page_data import PLOTLY  # noqa: E402
from report_words import four_digits  # noqa: E402


def test_two_runs_of_one_rig_are_both_there(kept):
    folder, runs = kept
    logs = [folder / run["log"] for run in runs]
    assert logs[0] != logs[1] and all(log.exists() for log in logs)
    assert all(re.fullmatch(r"build/runs/ess/\d{4}-\d\d-\d\dT\d\d-\d\d-\d\d(-\d+)?/ess.ulg", run["log"])
               for run in runs)
    latest = folder / "build" / "runs" / "ess" / "latest"
    assert latest.is_symlink() and latest.resolve() == logs[1].parent.resolve()


def test_the_page_lists_all_runs_with_what_they_found(kept):
    folder, runs = kept
    page = (folder / "build" / "runs" / "index.html").read_text()
    rows = json.loads(re.search(r"^const runs = (.*);$", page, re.MULTILINE)[1])
    for key in ("verdict", "stable", "growth"):
        assert [row[key] for row in rows] == [run[key] for run in reversed(runs)] and rows[0][key] is not None
    assert [row["peak_force_N"] for row in rows] == [run["peak_force_N"] for run in reversed(runs)]
    assert {row["version"] for row in rows} == {runs[0]["version"]}
    assert [row["settings"].get("robot.dead_time_ms") for row in rows] == ["25.0", None]
    assert all((folder / "build" / "runs" / row["folder"] / f"{row['rig']}.ulg").exists() for row in rows)


@pytest.mark.parametrize("name", ["latest", "latest/", "latest/ess.ulg", "../ess/latest/ess.ulg"])
def test_what_is_named_through_latest_is_told_by_the_name_of_its_run(name, kept):
    """A later run moves the link."""
    folder, runs = kept
    told = one_json_object(subprocess.run([BERTH, "summary", name, "--json"], cwd=folder / "build" / "runs" / "ess",
                                          capture_output=True).stdout)["log"]
    assert told.removeprefix("../ess/") == runs[1]["log"].removeprefix("build/runs/ess/")


def test_a_run_says_which_page_lists_it_and_no_other_run_does(tmp_path):
    shown = berth(tmp_path, "run", "ess", *settings(SHORT)).stdout
    [page] = re.findall(r"^  all runs +(\S+)$", shown, re.MULTILINE)
    assert page == "build/runs/index.html" and (tmp_path / page).exists()
    for words in (["--no-log"], ["--out", "x"]):
        assert "all runs" not in berth(tmp_path, "run", "ess", *words, *settings(SHORT)).stdout


def test_out_still_names_the_folder(tmp_path):
    result = json.loads(berth(tmp_path, "run", "ess", "--json", "--out", "there", *settings(SHORT)).stdout)
    assert result["log"] == "there/ess.ulg" and not (tmp_path / "build").exists()


def test_keep_leaves_the_newest_runs_of_this_rig(tmp_path):
    logs = [json.loads(berth(tmp_path, "run", "ess", "--json", "--keep", "2", *settings(SHORT)).stdout)["log"]
            for _ in range(3)]
    berth(tmp_path, "run", "ess-50hz", *settings(SHORT))
    assert [(tmp_path / log).exists() for log in logs] == [False, True, True]
    page = (tmp_path / "build" / "runs" / "index.html").read_text()
    assert page.count('"folder":"ess/') == 2 and page.count('"folder":"ess-50hz/') == 1
    assert berth(tmp_path, "run", "ess", "--keep", "2", "--out", "x").returncode == EXIT_INPUT


def test_a_folder_that_is_named_latest_stays_and_nothing_is_left_beside_it(tmp_path):
    rig = tmp_path / "build" / "runs" / "ess"
    (rig / "latest").mkdir(parents=True)
    run = json.loads(berth(tmp_path, "run", "ess", "--json", "--no-advice").stdout)["log"]
    assert {path.name for path in rig.iterdir()} == {"latest", pathlib.Path(run).parent.name}
    assert not (rig / "latest").is_symlink()


def test_a_run_that_was_removed_leaves_its_name_to_nobody(tmp_path):
    """Many runs a second: each has a later name than those before it, so that the last ones stay."""
    short = settings({"run.duration_s": 1.0})
    logs = [json.loads(berth(tmp_path, "run", "ess", "--json", "--no-advice", "--keep", "2", *short).stdout)["log"]
            for _ in range(40)]
    names = [pathlib.Path(log).parent.name for log in logs]
    assert len({name[:19] for name in names}) < 20, "too few runs a second for this test"
    assert len(set(names)) == 40
    rig = tmp_path / "build" / "runs" / "ess"
    assert {path.name for path in rig.iterdir()} == {*names[-2:], "latest"} and os.readlink(rig / "latest") == names[-1]


def test_compare_says_which_parameters_differ_and_both_verdicts(kept):
    folder, runs = kept
    a, b = (run["log"] for run in runs)
    told = json.loads(berth(folder, "compare", a, b, "--json").stdout)
    assert told["differences"] == [{"key": "robot.dead_time_ms", "unit": "ms", "a": "17.5", "b": "25.0"}]
    for side, run in zip("ab", runs):
        assert told[side]["growth_per_s"] == run["growth_per_s"]
        assert told[side]["verdict"] == run["verdict"] and told[side]["growth"] == run["growth"]
    shown = berth(folder, "compare", pathlib.Path(a).parent, "build/runs/ess/latest").stdout
    assert re.search(r"robot.dead_time_ms +17.5 +25\n", shown) and a in shown
    same = berth(folder, "compare", a, a).stdout
    assert "no parameter differs" in same
    assert berth(folder, "compare", a, "build/runs").returncode == EXIT_INPUT
    no_page = berth(folder, "compare", a, b, "--page", "x.txt")
    assert no_page.returncode == EXIT_INPUT and "end in .html" in no_page.stderr and not (folder / "x.txt").exists()


@pytest.mark.long
def test_compare_and_report_draw_pages_and_the_list_links_the_report(kept):
    folder, runs = kept
    a, b = (run["log"] for run in runs)
    done = berth(folder, "compare", a, b, "--page", "build/runs/compare.html")
    assert done.returncode == EXIT_DONE, done.stderr
    page = (folder / "build" / "runs" / "compare.html").read_text()
    assert "<td>robot.<wbr>dead_<wbr>time_<wbr>ms</td><td>17.5</td><td>25</td>" in page and len(page) < 1e6
    assert page.count('"name":"A"') == page.count('"name":"B"') == 3 and "force (N)" in page
    assert f'src="../assets/{PLOTLY}"' in page and (folder / "build" / "assets" / PLOTLY).exists()
    rig = folder / "build" / "runs" / "ess"
    for words in (["report", "latest"], ["compare", "latest", "latest/ess.ulg", "--page", "page.html"]):
        done = subprocess.run([BERTH, *words], cwd=rig, capture_output=True, text=True)
        [page] = re.findall(r"^(\S+\.html) \(", done.stdout, re.MULTILINE)
        text = (rig / page).read_text()
        assert pathlib.Path(b).parent.name in text and "latest/" not in text
    done = berth(folder, "report", pathlib.Path(a).parent)
    assert done.returncode == EXIT_DONE, done.stderr
    assert f'src="../../../assets/{PLOTLY}"' in (folder / a).with_suffix(".html").read_text()
    assert len(list(folder.rglob(PLOTLY))) == 1
    assert '"report":"ess.html"' in (folder / "build" / "runs" / "index.html").read_text()
    assert berth(folder, "report", "none.ulg").returncode == EXIT_INPUT
    newest = berth(folder, "report", "ess").stdout
    assert f"build/runs/ess/{pathlib.Path(b).parent.name}/ess.html" in newest
    assert f"build/runs/ess/{pathlib.Path(b).parent.name}/ess.ulg" in berth(folder, "compare", a, "ess").stdout


def test_report_draws_a_diagnosis(kept, tmp_path):
    folder, runs = kept
    done = berth(folder, "diagnose", runs[0]["log"], "--rig", "ess", "--out", tmp_path)
    assert done.returncode == EXIT_DONE and done.stdout.endswith(f"report: build/berth report {tmp_path}\n"), done.stderr
    done = berth(folder, "report", tmp_path)
    assert f"{tmp_path}/report.html (" in done.stdout and (tmp_path / "report.png").exists(), done.stderr
    done = berth(folder, "report", tmp_path, "--no-poses")
    assert done.returncode == EXIT_INPUT and "takes no options" in done.stderr


def test_a_pipe_that_is_closed_ends_a_drawing_without_a_word(kept, tmp_path):
    folder, runs = kept
    words = [str(BERTH), "export", str(folder / runs[0]["log"]), "--csv"]
    reader, writer = os.pipe()
    os.close(reader)
    done = subprocess.run(words, stdout=writer, stderr=subprocess.PIPE, cwd=tmp_path, restore_signals=True)
    os.close(writer)
    assert done.stderr == b"" and done.returncode == 128 + signal.SIGPIPE


@pytest.mark.parametrize("stiffness_N_per_m", [2000.0, 2e5, 1e6])
def test_a_peak_force_has_four_digits_wherever_it_is_told(stiffness_N_per_m, tmp_path):
    """From tens to ten thousands of N."""
    log = json.loads(berth(tmp_path, "run", "ess", "--robot", "abb-egm", "--json", *settings(
        {**SHORT, "object.stiffness_N_per_m": stiffness_N_per_m})).stdout)["log"]
    told = json.loads(berth(tmp_path, "summary", log, "--json").stdout)
    places = {"summary": r"peak force +(\S+) N measured", "compare": r"peak force \(N\) +(\S+) "}
    found = {}
    for name, pattern in places.items():
        shown = berth(tmp_path, name, log, *([log] if name == "compare" else [])).stdout
        found[name] = re.search(pattern, shown)[1]
    found["page"] = four_digits(told["peak_force_N"])
    assert len(set(found.values())) == 1, found
    text = found["page"]
    assert float(text) == float(f"{told['peak_force_N']:.4g}") and "e" not in text
    assert len(text.replace(".", "").lstrip("0")) == max(4, len(text.partition(".")[0]))


@pytest.mark.parametrize("rig, line, other, key", [
    ("ess-berthing", "at_s = 1.0", "at_s = 1.5", "orders"),
    ("ess-pose", "robot_dead_time_ms = 20.0", "robot_dead_time_ms = 25.0", "axis, wrench"),
    ("ess-pose", "roll_rad = 0.1", "roll_rad = 0.2", "axis, wrench"),
])
def test_compare_tells_parts_that_are_no_single_keys(rig, line, other, key, tmp_path):
    """Two files that differ in nothing but a list or a table."""
    text = (ROOT / "sim_hal" / "rigs" / f"{rig}.toml").read_text()
    assert text.count(line) == 1
    logs = []
    for name, content in (("one", text), ("other", text.replace(line, other))):
        file = tmp_path / f"{name}.toml"
        file.write_text(content)
        done = berth(tmp_path, "run", file, "--json", "--out", name, *settings(SHORT))
        assert done.returncode == EXIT_DONE, done.stderr
        logs.append(json.loads(done.stdout)["log"])
    told = json.loads(berth(tmp_path, "compare", *logs, "--json").stdout)
    assert [one["key"] for one in told["differences"]] == [key]


def test_latest_is_the_newest_by_its_start_and_never_dangles(tmp_path):
    """Runs of one rig at the same time, while a reader follows the link."""
    short = settings({"run.duration_s": 1.0})
    assert berth(tmp_path, "run", "ess", "--json", *short).returncode == EXIT_DONE
    rig = tmp_path / "build" / "runs" / "ess"
    late = subprocess.Popen([str(word) for word in (BERTH, "run", "ess", "--json", *settings({"run.duration_s": 400.0}))],
                            cwd=tmp_path, stdout=subprocess.PIPE, text=True)
    while len(list(rig.glob("2*"))) < 2:  # it has begun
        assert late.poll() is None
    runs = [subprocess.Popen([str(word) for word in (BERTH, "run", "ess", "--json", *short)], cwd=tmp_path,
                             stdout=subprocess.PIPE, text=True) for _ in range(12)]
    seen = 0
    while any(run.poll() is None for run in (*runs, late)):
        assert (rig / "latest" / "run.json").exists()
        seen += 1
    told = [json.loads(run.communicate()[0])["log"] for run in (*runs, late)]
    assert seen > 10 and len(set(told)) == 13 and not list(rig.glob("*.partial"))
    starts = sorted((name[:19], int(name[20:] or 1)) for name in (pathlib.Path(log).parent.name for log in told))
    newest = starts[-1][0] + (f"-{starts[-1][1]}" if starts[-1][1] > 1 else "")
    assert os.readlink(rig / "latest") == newest
    rows = json.loads(re.search(r"^const runs = (.*);$", (rig.parent / "index.html").read_text(), re.MULTILINE)[1])
    assert [row["folder"].rpartition("/")[2] for row in rows][0] == newest and len(rows) == 14


def test_a_copied_program_says_where_it_looks_for_scripts(kept, tmp_path):
    folder, runs = kept
    log = (folder / runs[0]["log"]).resolve()
    shutil.copy(BERTH, tmp_path / "copy")
    for words in (["report", log], ["compare", log, log, "--page", tmp_path / "page.html"], ["export", log, "--csv"]):
        done = subprocess.run([tmp_path / "copy", *words], capture_output=True, text=True)
        assert done.returncode == EXIT_INPUT
        assert str(tmp_path / "scripts") in done.stderr and "ln -sf" in done.stderr, done.stderr
    (tmp_path / "link").symlink_to(BERTH)
    assert subprocess.run([tmp_path / "link", "export", log, "--csv"], capture_output=True).returncode == EXIT_DONE


def test_without_its_python_the_report_says_what_to_do(kept, tmp_path):
    folder, runs = kept
    (tmp_path / "build").mkdir()
    (tmp_path / "scripts").mkdir()
    shutil.copy(BERTH, tmp_path / "build" / "berth")
    (tmp_path / "scripts" / "report.py").touch()
    done = subprocess.run([tmp_path / "build" / "berth", "report", folder / runs[0]["log"]], capture_output=True,
                          text=True)
    assert done.returncode == EXIT_INPUT and "make setup" in done.stderr


# Who may read all, wherever the Python of the environment lies, and write nothing of others.
AS_NOBODY = ["setpriv", "--securebits=+no_setuid_fixup", "--reuid=65534", "--regid=65534", "--clear-groups",
             "--inh-caps=-all,+dac_read_search", "--ambient-caps=-all,+dac_read_search"]


@pytest.mark.long
@pytest.mark.skipif(os.geteuid() != 0, reason="only root can act for another user")
def test_the_log_of_another_user_gets_its_page_elsewhere(tmp_path_factory):
    folder = tmp_path_factory.mktemp("theirs")
    assert berth(folder, "run", "ess", "--out", ".", *settings(SHORT)).returncode == EXIT_DONE
    mine, home = folder / "mine", folder / "home"
    for own in (mine, home):
        own.mkdir()
        os.chown(own, 65534, 65534)
    for parent in (folder, folder.parent, folder.parent.parent):  # tmp_path is for its owner alone
        parent.chmod(0o755)

    def report(*words):
        return subprocess.run([*AS_NOBODY, BERTH, "report", folder / "ess.ulg", *words], capture_output=True, text=True,
                              cwd="/", env={**os.environ, "HOME": str(home), "MPLCONFIGDIR": str(home)})

    refused = report()
    assert refused.returncode == EXIT_INPUT
    assert f"{folder}: you may not write there" in refused.stderr and "--out" in refused.stderr
    assert refused.stderr.count("\n") == 1 and not list(folder.glob("*.html"))
    done = report("--out", mine / "page.html")
    assert done.returncode == EXIT_DONE and done.stderr == "", done.stderr
    assert {path.name for path in mine.iterdir()} == {"page.html", "page.png", "assets"}
    missing = report("--out", folder / "none" / "page.html")
    assert missing.returncode == EXIT_INPUT and "mkdir -p" in missing.stderr
    assert report("--out", mine / "page.txt").returncode == EXIT_INPUT
