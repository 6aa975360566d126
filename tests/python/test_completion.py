"""Completion of commands in bash, zsh and fish, and the manual pages."""

import os
import pty
import re
import subprocess

import pytest
from conftest import BERTH, EXIT_DONE, EXIT_INPUT, ROOT, command


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


FILES = {"Makefile", "README.md"}  # as the shell offers them in the repository
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
    ("berth completion ", {"bash", "zsh", "fish"}, FILES),
    ("berth man ", {"run", "init", "man"}, {"ess"} | FILES),
    ("berth man com", {"compare", "compensate", "completion"}, {"run"}),
    ("berth rigs ", set(), FILES),
    ("berth run ", {"ess"} | FILES, {"eigen"}),
    ("berth compare ", {"ess"} | FILES, {"eigen"}),
    ("berth report ess-b", {"ess-beam"}, {"ess"}),
    ("berth run --json concept-c", {"concept-copper"}, {"--json"}),
    ("berth run --robot ur10e-servoj concept-fo", {"concept-foam"}, FILES),
    ("berth run --set object.mass_kg=40 --robot ur10e-servoj ess-b", {"ess-beam"}, {"ess"}),
    ("berth run ess concept-f", set(), {"concept-foam"}),
    ("berth map ess --model ", {"point", "rig", "tolerances"}, FILES),
    ("berth map ess --x object.ma", {"object.mass_kg="}, FILES),
    ("berth map ess --x object.ki", set(), {"object.kind="}),
    ("berth run ess --set object.kind=", {"gripped", "contact"}, FILES | {"object.mass_kg="}),
    ("berth run ess --set object.mass_kg=", set(), FILES),
    ("berth run ess --keep ", set(), FILES),
    ("berth eigen ess --margin-ms ", set(), FILES),
    ("berth run ess --jitter ", FILES, {"ess"}),
    ("berth map ess --vary mass --out ", FILES, {"ess"}),
    ("berth run ess --robot ", {"abb-egm"} | FILES, {"--json"}),
    ("berth diagnose a.csv --rig ess --without ", {"loop.clock_drift"}, FILES),
]


def value_of(words):
    """Completions of KEY=VALUE as the value alone, which is all that bash replaces."""
    return {word.split("=", 1)[-1] or word for word in words}


@pytest.mark.parametrize("line, there, absent", LINES)
def test_bash_completes(line, there, absent, scripts):
    words = [word for part in line.split(" ") for word in (re.findall(r"[=:]+|[^=:]+", part) or [""])]  # as readline does
    quoted = " ".join(f"'{word}'" for word in words)
    program = f"""source {scripts['bash']}
        COMP_WORDS=({quoted}); COMP_CWORD={len(words) - 1}; COMP_LINE='{line}'; COMP_POINT={len(line)}
        _berth berth; printf '%s\\n' "${{COMPREPLY[@]}}" """
    done = subprocess.run(["bash", "--norc", "-c", program], capture_output=True, text=True, cwd=ROOT)
    assert done.stderr == ""
    found = set(done.stdout.split())
    assert there <= found and not absent & found, found


def typed_in_bash(script, folder, line):
    """What stands on the line of an interactive bash after these keys, a tab among them; it is not run."""
    main, side = pty.openpty()
    shell = subprocess.Popen(["bash", "--norc", "--noprofile", "-i"], stdin=side, stdout=side, stderr=side, cwd=folder,
                             start_new_session=True, env=os.environ | {"PS1": "ready> ", "TERM": "dumb", "INPUTRC": "/dev/null"})
    os.close(side)
    keys = f"source {script}\nberth() {{ printf '<%s>' \"$@\"; echo; }}\n{line}\n exit\n"
    os.write(main, keys.encode())
    seen = b""
    try:
        while part := os.read(main, 4096):
            seen += part
    except OSError:
        pass  # the shell has ended
    os.close(main)
    assert shell.wait(10) == 0
    return re.findall(r"^<.*>", seen.decode().replace("\r", ""), re.MULTILINE)


@pytest.mark.parametrize("keys, given", [
    ("berth check my\t", "<check><my rig.toml>"),
    ("berth check 'my\t", "<check><my rig.toml>"),
    ("berth check my\\ r\t", "<check><my rig.toml>"),
    ("berth check --json my\t", "<check><--json><my rig.toml>"),
    ("berth run ess --set object.mass_k\t40", "<run><ess><--set><object.mass_kg=40>"),
    ("berth run ess --set object.kind=gri\t", "<run><ess><--set><object.kind=gripped>"),
    ("berth run ess --robot=ur10\t", "<run><ess><--robot=ur10e-servoj>"),
    ("berth run --json concept-fo\t", "<run><--json><concept-foam>"),
])
def test_bash_writes_what_berth_can_read(keys, given, scripts, tmp_path):
    (tmp_path / "my rig.toml").touch()
    assert typed_in_bash(scripts["bash"], tmp_path, keys) == [given]


@pytest.mark.parametrize("line, there, absent", LINES)
def test_fish_completes(line, there, absent, scripts):
    done = subprocess.run(["fish", "--no-config", "-c", f"source {scripts['fish']}; complete -C '{line}'"],
                          capture_output=True, text=True, cwd=ROOT)
    assert done.stderr == ""
    found = value_of(shown.split("\t")[0] for shown in done.stdout.splitlines())
    assert there <= found and not absent & found, found


@pytest.mark.parametrize("line, there, absent", LINES)
def test_zsh_completes(line, there, absent, scripts):
    assert subprocess.run(["zsh", "-n", scripts["zsh"]], capture_output=True).returncode == 0
    found = value_of(zsh_completions(scripts["zsh"], line))
    assert there <= found and not absent & found, found


def zsh_completions(script, line):
    """What the function hands to zsh's own builtins. They need a line editor, so functions with their names replace them."""
    words = line.split(" ")
    program = f"""
        compdef() {{ :; }}
        _files() {{ print -l -- {' '.join(FILES)}; }}
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
    assert "SYNOPSIS" in text and "EXIT STATUS" in text and "\u2010\n" not in text  # no name is broken by a hyphen
    if name:
        options = re.findall(r"(--[a-z][a-z-]*)", command(name, "--help").stdout.decode().split("Options:")[-1])
        assert options and all(option in text for option in options)
        defaults = re.findall(r"^  --[a-z-]+ [^ =]*=(\S*[a-z0-9]\S*)", command(name, "--help").stdout.decode(), re.MULTILINE)
        assert all(f"Default: {default}." in text for default in defaults)
    else:
        assert all(f"berth {one}" in text for one in subcommands()) and "--version" in text


def test_an_unknown_shell_or_page_is_refused():
    assert command("completion", "tcsh").returncode == EXIT_INPUT
    assert command("man", "walk").returncode == EXIT_INPUT
