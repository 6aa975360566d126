"""Commands that people expect: init, runs that are kept, compare, report, names, colours, progress."""

import json
import os
import pathlib
import pty
import re
import shutil
import signal
import subprocess
import sys
import tomllib

import jsonschema
import pytest
from conftest import (BERTH, EXIT_DIFFERENT, EXIT_DONE, EXIT_INPUT, ROOT, command, data_folder, one_json_object,
                      settings)

sys.path.insert(0, str(ROOT / "scripts"))
from page_data import PLOTLY  # noqa: E402
from report_words import four_digits  # noqa: E402

ROBOTS = sorted(path.stem for path in (ROOT / "sim_hal" / "robots").glob("*.toml"))
SENSORS = ("one-axis", "six-axis", "unfiltered")
OBJECTS = ("gripped", "contact", "beam", "none")
SHORT = {"run.duration_s": 2.0}
ESCAPE = b"\033["


def berth(folder, *arguments, **options):
    """The program in a folder of its own, where it keeps its runs."""
    return subprocess.run([str(word) for word in (BERTH, *arguments)], cwd=folder, capture_output=True, text=True,
                          timeout=600, **options)


# --- init ---------------------------------------------------------------------------------------------------------
def initialised(folder, robot, sensor, kind):
    file = folder / f"{robot or 'usual'}-{sensor}-{kind}.toml"
    words = ["--robot", robot] if robot else []
    done = command("init", file, "--sensor", sensor, "--object", kind, *words)
    assert done.returncode == EXIT_DONE, done.stderr.decode()
    return file


@pytest.mark.long
def test_every_file_that_init_writes_validates_and_gets_a_verdict(tmp_path):
    for robot in (None, *ROBOTS):
        for sensor in SENSORS:
            for kind in OBJECTS:
                file = initialised(tmp_path, robot, sensor, kind)
                lines = file.read_text().splitlines()
                schema = tmp_path / lines[0].removeprefix("#:schema ")
                jsonschema.Draft202012Validator(json.loads(schema.read_text())).validate(
                    tomllib.loads(file.read_text()))
                assert all("#" in line for line in lines if " = " in line and line[0] not in "#nd")
                checked = command("check", file, "--json")
                assert checked.returncode in (EXIT_DONE, EXIT_DIFFERENT), (file, checked.stderr.decode())
                assert one_json_object(checked.stdout)["verdict"] in ("stable", "unstable", "undetermined")


@pytest.mark.parametrize("sensor, kind", list(zip((*SENSORS, "one-axis"), OBJECTS)))
def test_a_file_of_init_runs(sensor, kind, tmp_path):
    file = initialised(tmp_path, "krenn-400hz", sensor, kind)
    done = command("run", file, "--no-log", "--json", *settings(SHORT))
    assert done.returncode == EXIT_DONE, done.stderr.decode()
    result = one_json_object(done.stdout)
    assert result["rig"] == file.stem and result["ticks"] == 800


def test_init_does_not_overwrite_without_force(tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text("mine = true\n")
    refused = command("init", file)
    assert refused.returncode == EXIT_INPUT and b"--force" in refused.stderr
    assert file.read_text() == "mine = true\n"
    assert command("init", file, "--force").returncode == EXIT_DONE
    assert file.read_text().startswith("#:schema ./berth-rig.schema.json\n")
    lost = command("init", tmp_path / "none" / "mine.toml")
    assert lost.returncode == EXIT_INPUT and f"the folder {tmp_path}/none does not exist" in lost.stderr.decode()
    assert b"mkdir -p" in lost.stderr
    assert command("init", tmp_path / "mine.txt").returncode == EXIT_INPUT
    assert command("init", tmp_path / "other.toml", "--object", "wall").returncode == EXIT_INPUT


# --- runs that are kept -------------------------------------------------------------------------------------------
@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    """Two runs of one rig and the folder where the program was called."""
    folder = tmp_path_factory.mktemp("kept")
    runs = [json.loads(berth(folder, "run", "ess", "--json", *settings({**SHORT, **values})).stdout)
            for values in ({}, {"robot.dead_time_ms": 25.0})]
    return folder, runs


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
    done = berth(folder, "report", pathlib.Path(a).parent)
    assert done.returncode == EXIT_DONE, done.stderr
    assert f'src="../../../assets/{PLOTLY}"' in (folder / a).with_suffix(".html").read_text()
    assert len(list(folder.rglob(PLOTLY))) == 1
    assert '"report":"ess.html"' in (folder / "build" / "runs" / "index.html").read_text()
    assert berth(folder, "report", "none.ulg").returncode == EXIT_INPUT


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


# --- names --------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("words, answer", [
    (["eigne", "ess"], "did you mean eigen?"),
    (["compnsate", "ess"], "did you mean compensate?"),
    (["eigen", "ess", "--robot", "ur10e"], "the nearest is ur10e-servoj"),
    (["eigen", "ess", "--robot", "dx200"], "the nearest is yaskawa-dx200"),
    (["eigen", "es"], "did you mean ess?"),
    (["eigen", "concept_foam"], "did you mean concept-foam?"),
    (["run", "ess", "--with", "preduction"], "did you mean prediction?"),
    (["run", "ess", "--set", "robot.dead_tme_ms=3"], "the nearest known one is robot.dead_time_ms"),
    (["eigen", "ess", "--amplitud", "3"], "berth: --amplitud: berth eigen has no such option; did you mean --amplitude?"),
    (["eigen", "ess", "--ampl=3"], "berth: --ampl: berth eigen has no such option; did you mean --amplitude?"),
    (["run", "ess", "--sett", "x"], "berth: --sett: berth run has no such option; did you mean --set?; see berth run"),
    (["run", "ess", "--set", "x", "--rob", "abb-egm"], "--rob: berth run has no such option; did you mean --robot?"),
    (["run", "ess", "--amplitude", "3"], "--amplitude: berth run has no such option; these have it: eigen, map, limits"),
    (["rigs", "--object", "beam"], "--object: berth rigs has no such option; these have it: init"),
    (["run", "ess", "--quick"], "berth: --quick: berth run has no such option; see berth run --help"),
    (["run", "ess", "a", "b", "c"], "berth: a b c: too many words; berth run takes RIG; see"),
    (["run", "ess", "a"], "berth: a: one word too many; berth run takes RIG; see"),
    (["compare", "a", "b", "c"], "berth: c: one word too many; berth compare takes A B; see"),
    (["rigs", "ess"], "berth: ess: one word too many; berth rigs takes nothing; see"),
    (["map", "ess", "--vary", "mas"], "must be elasticity or mass (is \"mas\"); did you mean mass?"),
    (["map", "ess", "--x", "object.mas_kg=1:2:3", "--y", "robot.dead_time_ms=1:2:3"], "one is object.mass_kg"),
    (["diagnose", "x.ulg", "--rig", "ess", "--without", "robot.backlas"], "did you mean robot.backlash? berth effects"),
    (["diagnose", "x.ulg", "--rig", "es"], "did you mean ess?"),
    (["run", "ess", "--set", "object.kind=contct"], "did you mean contact?"),
    (["run", "ess", "--set", "compensation.method=tank"], "unknown key, and none is near; `berth schema` lists all"),
    (["rths", "data", "--earthquake", "kob"], "did you mean kobe?"),
    (["init", "x.toml", "--robot", "ur10"], "the nearest is ur10e-servoj"),
    (["arm", "es"], "did you mean ess?"),
    (["--verison"], "did you mean --version?"),
    (["-v"], "did you mean --version?"),
    (["--hlp"], "did you mean --help?"),
    (["--jsn", "run", "ess"], "did you mean --json?"),
    (["--json", "run", "ess"], "options stand behind the subcommand, as berth run ... --json"),
    (["init", "x.toml", "--object", "beem"], "did you mean beam?"),
    (["completion", "BASH"], "did you mean bash?"),
    (["compare"], "A is missing: a .ulg file written by `berth run`, or the folder of one run; see berth compare --help"),
    (["run", "none/x.toml"], "none/x.toml: cannot be read: there is no folder none"),
    (["run", "./none.toml"], "none.toml: cannot be read: there is no such file"),
    (["check", "."], ".: cannot be read: it is a folder"),
    (["summary", "scripts"], "scripts: cannot be read: it is a folder with 0 logs"),
    (["man", "rum"], "there are run, replay"),
    (["man", "rum"], "did you mean run?"),
])
def test_the_nearest_name_is_told(words, answer):
    done = command(*words)
    assert done.returncode == EXIT_INPUT
    assert answer in done.stderr.decode()


@pytest.mark.parametrize("words", [(), ("run",), ("eigen",)])
def test_help_is_a_word_too(words):
    asked = command("help", *words)
    assert asked.returncode == 0 and asked.stdout == command(*words, "--help").stdout and b"Usage: " in asked.stdout


def test_the_version_is_semantic_and_names_the_commit():
    shown = command("--version").stdout.decode()
    assert re.fullmatch(r"berth \d+\.\d+\.\d+(-[0-9a-z.]+)? \(([0-9a-f]{12}(-dirty)?|unknown)\)\n", shown), shown


# --- colours ------------------------------------------------------------------------------------------------------
def on_terminal(words, **environment):
    """What a command writes to a terminal."""
    leader, follower = pty.openpty()
    variables = {**os.environ, "TERM": "xterm", **environment}
    variables = {name: value for name, value in variables.items() if value is not None}
    with subprocess.Popen([str(word) for word in (BERTH, *words)], stdout=follower, stderr=follower, cwd=ROOT,
                          env=variables) as process:
        os.close(follower)
        shown = b""
        while True:
            try:
                part = os.read(leader, 65536)
            except OSError:
                break
            if not part:
                break
            shown += part
        process.wait()
    os.close(leader)
    return shown


RED, GREEN, YELLOW = (f"\033[{number}m{{}}\033[0m".format for number in (31, 32, 33))


@pytest.mark.parametrize("words, shown", [
    (["eigen", "ess"], GREEN("stable")),
    (["check", "ess"], GREEN("values")),
    (["check", "ess", *settings({"object.stiffness_N_per_m": 5e7})], YELLOW("implausible")),
    (["check", "ess", *settings({"limits.position_min_m": -0.002})], RED("stops")),
    (["compare", "LOG", "UNSTABLE"], f"{GREEN('stable')}                   {RED('unstable')}"),
    (["map", "ess", "--vary", "mass", "--grid", "4x4", "--out", "FOLDER"], GREEN("stable")),
    (["eigen", "nothing"], RED("berth:")),
    (["eigen"], RED("berth:")),
    (["eigne"], RED("berth:")),
])
def test_colours_are_on_a_terminal_only(words, shown, kept, tmp_path):
    folder, runs = kept
    if "UNSTABLE" in words:
        unstable = berth(tmp_path, "run", "ess", "--out", ".", *settings({**SHORT, "object.mass_kg": 210}))
        assert unstable.returncode == EXIT_DONE
    names = {"LOG": folder / runs[0]["log"], "UNSTABLE": tmp_path / "ess.ulg", "FOLDER": tmp_path}
    words = [names.get(word, word) for word in words]
    assert shown in on_terminal(words, NO_COLOR=None).decode()
    assert ESCAPE not in on_terminal(words, NO_COLOR="1")
    assert ESCAPE not in on_terminal(words, NO_COLOR=None, TERM="dumb")
    piped = command(*words)
    assert ESCAPE not in piped.stdout + piped.stderr


# --- width --------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("words", [
    ["run", "ess", "--no-log", *settings(SHORT)], ["check", "ess", "--robot", "ur10e-servoj"], ["limits", "ess", "--help"],
    ["--help"], ["eigen", "ess", "--robot", "abb-egm"], ["effects"], ["robots"], ["rigs"], ["eigne"], ["check", "es"],
], ids=" ".join)
@pytest.mark.parametrize("width", [80, 100])
def test_lines_of_prose_fit_the_terminal(words, width):
    """Each line of a pipe is there whole, in lines of the terminal that end at blanks; rows of tables stay."""
    shown = re.sub(rb"\033\[[0-9;]*[mK]", b"", on_terminal(words, COLUMNS=str(width))).decode().replace("\r\n", "\n")
    shown = re.sub(r"\r[^\n]*\r", "", shown)
    piped = command(*words)
    whole = (piped.stdout + piped.stderr).decode()
    long = [line for line in shown.splitlines() if len(line) > width]
    assert all(re.search(r"\S  +\S.*  +\S", line) or " " not in line.strip() for line in long), long
    assert len(shown.splitlines()) > len(whole.splitlines()) or max(map(len, whole.splitlines())) <= width

    def same(text):
        return re.sub(r"\d+ times real time \([\d.]+ ms\)", "", " ".join(text.split()))

    assert same(shown) == same(whole)


def test_a_wrapped_line_goes_on_under_its_text():
    shown = on_terminal(["check", "ess"], COLUMNS="80", NO_COLOR="1").decode().splitlines()
    at = next(i for i, line in enumerate(shown) if line.startswith("  delay"))
    assert re.match(r" {17}\S", shown[at + 1]), shown[at:at + 2]


def test_json_on_a_terminal_is_one_line():
    assert len(on_terminal(["eigen", "ess", "--json"], COLUMNS="80").splitlines()) == 1


# --- the margin ---------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("rig, sentence", [
    ("ess", "the dead time may grow by at least 157.5 ms before the loop is unstable; modulus 0.5389 (0: unstable)"),
    ("ess-50hz", r"the dead time may grow by 170.9 ms before the loop is unstable; modulus 0.7320 (0: unstable)"),
])
def test_the_margin_is_the_same_sentence_everywhere(rig, sentence, tmp_path):
    """The page of a run prints the sentence of the JSON: see test_pages.py."""
    for words in (["run", rig, "--no-log", *settings(SHORT)], ["check", rig], ["eigen", rig], ["limits", rig],
                  ["map", rig, "--vary", "mass", "--grid", "4x4", "--out", tmp_path]):
        lines = command(*words).stdout.decode().splitlines()
        assert [line for line in lines if "margin  " in line][:1] == [f"  margin         {sentence}"], words
        assert one_json_object(command(*words, "--json").stdout)["margin"]["sentence"] == sentence


def test_a_loop_that_grows_has_no_margin(tmp_path):
    heavy = settings({"object.mass_kg": 210})
    for words in (["eigen", "ess"], ["limits", "ess"], ["map", "ess", "--vary", "mass", "--grid", "4x4", "--out", tmp_path]):
        done = command(*words, *heavy)
        assert done.returncode == EXIT_DONE and "  margin   " not in done.stdout.decode().split("most margin")[0]
        assert one_json_object(command(*words, *heavy, "--json").stdout)["margin"]["sentence"] is None


# --- a log of somebody else ---------------------------------------------------------------------------------------
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


@pytest.mark.long
@pytest.mark.parametrize("words, doing", [
    (["report", "LOG"], b"report: draws"),
    (["compare", "LOG", "LOG", "--page", "FOLDER/page.html"], b"compare: draws"),
    (["export", "LOG", "--mcap"], b"export: every message"),
    (["map", "ess", "--vary", "mass", "--grid", "4x4", "--out", "FOLDER", "--picture"], b"map: draws"),
    (["reduce", "ess", "--arm", "ess", "--sweep", "1=0:1:3", "--json"], b"reduce: pose 3 of 3"),
    (["rths", "DATA/rths", "--perturbed", "2"], b"rths: plant 2 of 2"),
])
def test_what_takes_seconds_says_on_a_terminal_what_it_does(words, doing, kept, tmp_path):
    """The line is erased before anything else is printed; in a pipe there is none."""
    folder, runs = kept
    names = {"LOG": folder / runs[0]["log"], "FOLDER": tmp_path, "DATA": data_folder()}
    if "DATA/rths" in words and names["DATA"] is None:
        pytest.skip("the benchmark's data are not here; BERTH_DATA names their folder")
    for name, value in names.items():
        words = [word.replace(name, str(value)) for word in words]
    shown = on_terminal(words)
    assert doing in shown
    assert all(line.startswith(b"\033[K") for line in shown.split(b"\r")[1:] if doing in line), shown
    last = shown.rindex(doing)
    assert b"\r\033[K" in shown[last:] and doing not in command(*words).stderr


def test_a_terminal_that_only_prints_has_no_line_to_erase():
    assert ESCAPE not in on_terminal(["reduce", "ess", "--arm", "ess", "--sweep", "1=0:1:3", "--json"], TERM="dumb")


def test_an_empty_no_color_counts_as_unset():
    """As https://no-color.org has it."""
    assert ESCAPE in on_terminal(["eigen", "ess"], NO_COLOR="")


@pytest.mark.parametrize("changes, says", [
    ({"object.kind": "none", "object.mass_kg": 30}, "object.mass_kg"),
    ({"robot.clock_drift_ppm": 100}, 'robot.clock_drift_ppm: without effect, because robot.clock = "locked"'),
    ({"robot.clock_drift_ppm": 100, "robot.clock": "free"}, ""),
    ({}, ""),
], ids=str)
def test_a_key_without_effect_is_told_in_one_line(changes, says):
    done = command("check", "ess", "--json", *settings(changes))
    told = [line for line in done.stderr.decode().splitlines() if "without effect" in line]
    assert len(told) == bool(says) and says in "".join(told)


def test_a_robot_that_touches_nothing_has_no_delay_of_a_force():
    assert b"low-pass" not in command("run", "ess", "--no-log", "--set", "object.kind=none").stdout
