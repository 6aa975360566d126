"""Tests on a real kernel: a guest is booted once for each architecture and runs the steps of tests/target/steps, and
what they leave is judged here, on the host.

Run from the repository root: make target, or .venv/bin/python -m pytest -q tests/target
A step on its own: scripts/guest/run.py --icount sh tests/target/run_steps.sh /src/PROGRAMS /src/STEP
"""

import json
import os
import pathlib
import shutil
import subprocess
import sys
import tomllib
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts" / "guest"))
import run as guest_run  # noqa: E402

PROGRAMS = {"arm64": "build/aarch64-linux-gnu", "amd64": "build/x86_64-linux-gnu"}
STEPS = ["machine", "preflight", "contract", "closed_loop", "closed_loop_cia402", "without_realtime", "sensor_layouts",
         "arm_pose", "berthing", "concept", "watchdog", "image"]
BOARD_STEPS = ["package"]
SCENARIOS = {path.stem: tomllib.loads(path.read_text())
             for path in sorted((ROOT / "tests" / "scenarios").glob("*.toml"))}
GUESTS_AT_ONCE = int(os.environ.get("BERTH_GUESTS_AT_ONCE", min(2, os.cpu_count())))
BERTH = ROOT / "build" / "berth"
CLOSED_LOOP_s = int(os.environ.get("BERTH_CLOSED_LOOP_s", 60))  # of the reference case under load, the dearest step
TIMEOUT_s = 3600  # of the host's time, for a machine that is busy with other things


def berth(*arguments):
    """The JSON object that the host command prints."""
    done = subprocess.run([BERTH, *arguments, "--json"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@dataclass
class Step:
    """What a step has left."""

    folder: pathlib.Path

    def text(self, name):
        return (self.folder / name).read_text(errors="replace")

    def lines(self, name):
        return self.text(name).splitlines()

    def json(self, name):
        return json.loads(self.text(name))

    def number(self, name):
        return int(self.text(name))

    def path(self, name):
        return self.folder / name

    def check_replays(self, name):
        """The log replays on the host, bit for bit."""
        done = subprocess.run([BERTH, "replay", self.path(name)], capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout + done.stderr

    def check_loop_done(self):
        """Of a step that runs the loop: the step and the loop have ended well."""
        self.check_done()
        assert self.number("loop.exit_code") == 0, self.text("loop.stdout") + self.text("loop.stderr")

    def check_done(self):
        assert self.number("exit_code") == 0, f"{self.folder.name}: {self.text('stdout')}{self.text('stderr')}"


def write_scenario(path, scenario):
    """The step that plays a scenario."""
    start = (f"scenario_start {scenario.get('buses', 'real')} {scenario.get('log', 'disk')} "
             f"{scenario.get('profile', 'berth')}")
    events = [f"at {event['at_s']} {event['do']}" for event in scenario["events"]]
    lines = [". /src/tests/target/actions.sh", start, *events, "scenario_end"]
    path.write_text("\n".join(lines) + "\n")


def boot_with(arch, results, steps, **options):
    """Runs steps in a guest."""
    command = f"CLOSED_LOOP_s={CLOSED_LOOP_s} sh tests/target/run_steps.sh /src/{PROGRAMS[arch]} {' '.join(steps)}\n"
    with (results / "console").open("w") as console:
        code = guest_run.run(command, arch=arch, icount=True, results=results, timeout_s=TIMEOUT_s, output=console,
                             **options)
    assert code == 0, f"the {arch} guest ended with {code}:\n" + (results / "console").read_text()


def boot(arch, results):
    """All steps and scenarios, in a guest that has nothing beside them."""
    shutil.rmtree(results, ignore_errors=True)
    (results / "scenarios").mkdir(parents=True)
    for name, scenario in SCENARIOS.items():
        write_scenario(results / "scenarios" / f"{name}.sh", scenario)
    boot_with(arch, results, [*(f"/src/tests/target/steps/{name}.sh" for name in STEPS),
                              *(f"/results/scenarios/{name}.sh" for name in SCENARIOS)])


def boot_board(arch, results):
    """The steps of a board: in a small Debian with systemd."""
    shutil.rmtree(results, ignore_errors=True)
    results.mkdir(parents=True)
    boot_with(arch, results, [f"/src/tests/target/steps/{name}.sh" for name in BOARD_STEPS], systemd=True)


BOOTS = {"guest": boot, "board": boot_board}


def results_of(arch, kind="guest"):
    return guest_run.CACHE / "results" / (arch if kind == "guest" else f"{arch}-{kind}")


@pytest.fixture(scope="session")
def booted(request):
    """Boots the guests that the chosen tests ask for, side by side; {(kind, architecture): its outcome}."""
    asked = {(kind, item.callspec.params[kind]) for item in request.session.items if hasattr(item, "callspec")
             for kind in BOOTS if kind in item.callspec.params}
    with ThreadPoolExecutor(GUESTS_AT_ONCE) as pool:
        return {(kind, arch): pool.submit(BOOTS[kind], arch, results_of(arch, kind))
                for kind, arch in sorted(asked, reverse=True)}


def steps_of(kind, arch, booted):
    """A function STEP -> what it has left in a guest, which is booted once."""
    booted[kind, arch].result()
    results = results_of(arch, kind)

    def step(name):
        found = Step(results / name)
        assert found.folder.is_dir(), f"the guest has not run {name}"
        return found

    step.arch = arch
    return step


@pytest.fixture(scope="session", params=PROGRAMS)
def guest(request, booted):
    return steps_of("guest", request.param, booted)


@pytest.fixture(scope="session", params=PROGRAMS)
def board(request, booted):
    return steps_of("board", request.param, booted)


def pytest_terminal_summary(terminalreporter):
    """How the loop and cyclictest beside it kept time, in each guest that has run: table, ratio and picture."""
    nodes = [report.nodeid for reports in terminalreporter.stats.values() for report in reports
             if hasattr(report, "nodeid")]
    for arch in PROGRAMS:
        files = [results_of(arch) / "closed_loop" / name for name in ("jitter.json", "cyclictest.json")]
        if any(arch in node for node in nodes) and all(file.is_file() for file in files):
            terminalreporter.write_sep("-", f"timing in the {arch} guest")
            done = subprocess.run([sys.executable, ROOT / "scripts" / "jitter_plot.py", *files], capture_output=True,
                                  text=True, check=False)
            terminalreporter.write(done.stdout + done.stderr)
