"""The four commands that answer "will my rig blow up?", asked by tests."""

import json

from conftest import EXIT_DIFFERENT, EXIT_DONE, command

COMMANDS = ("run", "eigen", "limits", "check")


def ask(name, path, *more):
    """The JSON answer of a command, and its exit code."""
    extra = {"run": ["--no-log", "--check"], "check": []}.get(name, ["--check"])
    done = command(name, path, "--json", *extra, *more)
    assert done.returncode in (EXIT_DONE, EXIT_DIFFERENT), done.stderr.decode()
    return json.loads(done.stdout), done.returncode


def answers(path, *more, commands=COMMANDS):
    """They agree whether the rig is stable. `check` also refuses what is implausible, and a run that a fault ends."""
    told = {name: ask(name, path, *more) for name in commands}
    doubtful = {name for name, (answer, _) in told.items() if answer.get("implausible") or answer.get("start", {}).get("because")}
    stable = {name: (answer["stable"], EXIT_DONE if name in doubtful and answer["stable"] else code)
              for name, (answer, code) in told.items()}
    assert len(set(stable.values())) == 1, stable
    return {name: answer for name, (answer, _) in told.items()}
