"""Asks the host command: what it says with --json, and the logs and maps that it writes."""
import json
import subprocess
from pathlib import Path

from berth_log import InputError, read_log
from berth_map import read_map

ROOT = Path(__file__).resolve().parents[1]


class Berth:
    """The host command, with a folder for what it writes."""

    def __init__(self, folder, program=ROOT / "build" / "berth"):
        self.folder = Path(folder)
        self.program = Path(program).resolve()
        self.answers = {}

    def ask(self, subcommand, rig, values=None, *options):
        """The object that `berth SUBCOMMAND RIG --json` prints, keys of the rig overridden by `values`; the
        same question is asked once. Raises InputError."""
        words = [str(self.program), subcommand, rig, "--json", *map(str, options)]
        for key, value in (values or {}).items():
            words += ["--set", f"{key}={value}"]
        question = tuple(words)
        if question not in self.answers:
            try:
                done = subprocess.run(words, capture_output=True, text=True)
            except OSError as error:
                raise InputError(f"{self.program}: cannot be started ({error.strerror}); build it with `make all`") \
                    from error
            if done.returncode != 0:
                raise InputError(f"{' '.join(words)}: {done.stderr.strip()}")
            self.answers[question] = json.loads(done.stdout)
        return self.answers[question]

    def run(self, name, rig, values=None):
        """What `berth run --no-advice` says, and the log of the run. A name stands for one rig and its values."""
        result = self.ask("run", rig, values, "--no-advice", "--out", self.folder / "runs" / name)
        return result, read_log(result["log"])

    def map(self, name, rig, vary, grid, values=None, *options):
        """The map of `berth map RIG --vary`. A name stands for one set of values and options."""
        result = self.ask("map", rig, values, "--vary", vary, "--grid", grid, "--out", self.folder / "maps" / name,
                          *options)
        return read_map(result["csv"])
