"""Commands that people expect: init, check, runs that are kept, compare, report, names, colours, completion, man."""

import json
import os
import pathlib
import pty
import re
import shutil
import subprocess
import tomllib

import jsonschema
import pytest
from conftest import BERTH, EXIT_DIFFERENT, EXIT_DONE, EXIT_INPUT, RIGS, ROOT, command, one_json_object, settings

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
    assert command("init", tmp_path / "mine.txt").returncode == EXIT_INPUT
    assert command("init", tmp_path / "other.toml", "--object", "wall").returncode == EXIT_INPUT


# --- check --------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("values, key", [
    ({"object.stiffness_N_per_m": 5e7}, "object.stiffness_N_per_m"),
    ({"object.stiffness_N_per_m": 5e7}, "sensor.stiffness_N_per_m"),
    ({"sensor.stiffness_N_per_m": 2e3}, "sensor.stiffness_N_per_m"),
    ({"loop.rate_Hz": 10, "robot.dead_time_ms": 100}, "loop.rate_Hz"),
    ({"sensor.low_pass_frequency_Hz": 1.0}, "sensor.low_pass_frequency_Hz"),
    ({"robot.dead_time_ms": 400}, "robot.dead_time_ms"),
    ({"object.damping_N_s_per_m": 1e5}, "object.damping_N_s_per_m"),
    ({"manipulator.damping_N_s_per_m": 0}, "manipulator.damping_N_s_per_m"),
    ({"object.mass_kg": 1e5}, "object.mass_kg"),
    ({"object.stiffness_N_per_m": 3e6}, "manipulator.initial_position_m"),
])
def test_check_names_an_implausible_value_why_and_what_to_do(values, key):
    done = command("check", "ess", "--json", *settings(values))
    assert done.returncode == EXIT_DIFFERENT, done.stderr.decode()
    found = {one["key"]: one for one in one_json_object(done.stdout)["implausible"]}
    assert key in found and found[key]["why"] and found[key]["advice"]
    shown = command("check", "ess", *settings(values)).stdout.decode()
    assert f"implausible    {key}: " in shown and "delay " in shown


@pytest.mark.parametrize("rig", [rig for rig in RIGS if "berthing" not in rig and "arm" not in rig])
def test_the_shipped_rigs_are_plausible(rig):
    done = command("check", rig, "--json")
    result = one_json_object(done.stdout)
    assert result["implausible"] == [], result["implausible"]
    assert done.returncode == (EXIT_DONE if result["stable"] else EXIT_DIFFERENT)


def test_check_of_a_file_that_cannot_be_read_has_an_exit_code_of_its_own(tmp_path):
    assert command("check", tmp_path / "none.toml").returncode == EXIT_INPUT
    assert command("check", "ess", "--set", "object.mass_kg=-1").returncode == EXIT_INPUT
    assert command("check", "ess").returncode == EXIT_DONE


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
    assert [row["growth_per_s"] for row in rows] == [run["growth_per_s"] for run in reversed(runs)]
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
        assert told[side]["verdict"] == run["verdict"]
    shown = berth(folder, "compare", pathlib.Path(a).parent, "build/runs/ess/latest").stdout
    assert re.search(r"robot.dead_time_ms +17.5 +25.0", shown) and a in shown
    same = berth(folder, "compare", a, a).stdout
    assert "no parameter differs" in same
    assert berth(folder, "compare", a, "build/runs").returncode == EXIT_INPUT


@pytest.mark.long
def test_compare_and_report_draw_pages_and_the_list_links_the_report(kept):
    folder, runs = kept
    a, b = (run["log"] for run in runs)
    done = berth(folder, "compare", a, b, "--page", "build/runs/compare.html")
    assert done.returncode == EXIT_DONE, done.stderr
    page = (folder / "build" / "runs" / "compare.html").read_text()
    assert "<td>robot.dead_time_ms</td><td>17.5</td><td>25.0</td>" in page and len(page) < 1e6
    assert page.count('"legendgroup":"A"') == 3 and "force (N)" in page
    done = berth(folder, "report", a)
    assert done.returncode == EXIT_DONE, done.stderr
    assert (folder / a).with_suffix(".html").exists()
    assert '"report":"ess.html"' in (folder / "build" / "runs" / "index.html").read_text()
    assert berth(folder, "report", "none.ulg").returncode == EXIT_INPUT


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
    (["eigen", "ess", "--amplitud", "3"], "--amplitud 3: are not expected; did you mean --amplitude?"),
    (["run", "ess", "a", "b", "c"], "berth: a b c: are not expected"),
    (["run", "ess", "a"], "berth: a: is not expected"),
    (["arm", "es"], "did you mean ess?"),
])
def test_the_nearest_name_is_told(words, answer):
    done = command(*words)
    assert done.returncode == EXIT_INPUT
    assert answer in done.stderr.decode()


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


@pytest.mark.parametrize("words", [["eigen", "ess"], ["check", "ess"], ["eigen", "nothing"]])
def test_colours_are_on_a_terminal_only(words):
    assert ESCAPE in on_terminal(words, NO_COLOR=None)
    assert ESCAPE not in on_terminal(words, NO_COLOR="1")
    assert ESCAPE not in on_terminal(words, NO_COLOR=None, TERM="dumb")
    piped = command(*words)
    assert ESCAPE not in piped.stdout + piped.stderr


def test_an_empty_no_color_counts_as_unset():
    """As https://no-color.org has it."""
    assert ESCAPE in on_terminal(["eigen", "ess"], NO_COLOR="")


# --- completion and manual pages ----------------------------------------------------------------------------------
def subcommands():
    shown = command("--help").stdout.decode()
    return re.findall(r"^  ([a-z]+) ", shown[shown.index("Subcommands"):], re.MULTILINE)


@pytest.fixture(scope="module")
def scripts(tmp_path_factory):
    folder = tmp_path_factory.mktemp("completion")
    made = {}
    for shell in ("bash", "zsh", "fish"):
        done = command("completion", shell)
        assert done.returncode == EXIT_DONE
        made[shell] = folder / f"berth.{shell}"
        made[shell].write_bytes(done.stdout)
    return made


LINES = [
    ("berth ei", {"eigen"}, set()),
    ("berth ", {"run", "init", "check", "schema"}, {"--json"}),
    ("berth run ess-b", {"ess-beam", "ess-berthing"}, {"ess", "eigen"}),
    ("berth run ess --rob", {"--robot"}, {"--json"}),
    ("berth run ess --robot ur", {"ur10e-servoj", "ur5cb3-servoj"}, {"abb-egm"}),
    ("berth eigen ess --set robot.dead_time_m", {"robot.dead_time_ms="}, {"robot.clock="}),
    ("berth run ess --with pre", {"prediction"}, {"tank"}),
    ("berth init mine.toml --object be", {"beam"}, {"gripped"}),
    ("berth completion z", {"zsh"}, {"bash"}),
]


@pytest.mark.parametrize("line, there, absent", LINES)
def test_bash_completes(line, there, absent, scripts):
    words = line.split(" ")
    program = f"""source {scripts['bash']}
        COMP_WORDS=({' '.join(word or "''" for word in words)}); COMP_CWORD={len(words) - 1}; COMP_LINE='{line}'
        _berth berth; printf '%s\\n' "${{COMPREPLY[@]}}" """
    done = subprocess.run(["bash", "--norc", "-c", program], capture_output=True, text=True)
    assert done.stderr == ""
    found = set(done.stdout.split())
    assert there <= found and not absent & found, found


@pytest.mark.parametrize("line, there, absent", LINES)
def test_fish_completes(line, there, absent, scripts):
    done = subprocess.run(["fish", "--no-config", "-c", f"source {scripts['fish']}; complete -C '{line}'"],
                          capture_output=True, text=True, cwd=ROOT)
    assert done.stderr == ""
    found = {shown.split("\t")[0] for shown in done.stdout.splitlines()}
    assert there <= found and not absent & found, found


@pytest.mark.parametrize("line, there, absent", LINES)
def test_zsh_completes(line, there, absent, scripts):
    assert subprocess.run(["zsh", "-n", scripts["zsh"]], capture_output=True).returncode == 0
    found = zsh_completions(scripts["zsh"], line)
    assert there <= found and not absent & found, found


def zsh_completions(script, line):
    """What the function hands to zsh's own builtins, which need a line editor and stand in for here."""
    words = line.split(" ")
    program = f"""
        compdef() {{ :; }}
        _files() {{ :; }}
        compadd() {{ while [[ $1 == -* && $1 != -- ]]; do [[ $1 == -S ]] && shift; shift; done; shift; print -l -- "$@"; }}
        _describe() {{ local name=$2; print -l -- "${{(@P)name%%:*}}"; }}
        source {script}
        words=({' '.join(word or "''" for word in words)}); CURRENT={len(words)}; PREFIX='{words[-1]}'
        _berth"""
    done = subprocess.run(["zsh", "-f", "-c", program], capture_output=True, text=True)
    assert done.stderr == "", done.stderr
    return {word for word in done.stdout.split() if word.startswith(words[-1])}


@pytest.mark.parametrize("name", ["", *subcommands()] if BERTH.exists() else [""])
def test_a_manual_page_opens_without_warnings(name, tmp_path):
    done = command("man", *([name] if name else []))
    assert done.returncode == EXIT_DONE
    page = tmp_path / "berth.1"
    page.write_bytes(done.stdout)
    shown = subprocess.run(["man", "--warnings", "-l", page], capture_output=True, text=True,
                           env={**os.environ, "MANWIDTH": "100", "LC_ALL": "C.UTF-8", "PAGER": "cat"})
    assert shown.returncode == 0 and shown.stderr == "", shown.stderr
    text = re.sub(r".\x08", "", shown.stdout)
    assert "SYNOPSIS" in text and "EXIT STATUS" in text
    if name:
        options = re.findall(r"(--[a-z][a-z-]*)", command(name, "--help").stdout.decode().split("Options:")[-1])
        assert options and all(option in text for option in options)
    else:
        assert all(f"berth {one}" in text for one in subcommands())


def test_an_unknown_shell_or_page_is_refused():
    assert command("completion", "tcsh").returncode == EXIT_INPUT
    assert command("man", "walk").returncode == EXIT_INPUT
