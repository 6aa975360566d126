"""Every rig that `berth init` writes is stable as written: all robots, sensors and objects."""

import itertools
import json
import tomllib

import pytest
from conftest import EXIT_DONE, ROOT, command

ROBOTS = [None, *sorted(path.stem for path in (ROOT / "sim_hal" / "robots").glob("*.toml"))]
SENSORS = ("one-axis", "six-axis", "unfiltered")
OBJECTS = ("gripped", "contact", "beam", "none")


@pytest.mark.long
@pytest.mark.parametrize("robot", ROBOTS)
def test_each_rig_of_init_passes_check(tmp_path, robot):
    for sensor, kind in itertools.product(SENSORS, OBJECTS):
        path = tmp_path / f"{sensor}-{kind}.toml"
        words = ["--robot", robot] if robot else []
        command("init", path, "--sensor", sensor, "--object", kind, *words, check=True)
        done = command("check", path, "--json")
        told = json.loads(done.stdout)
        assert done.returncode == EXIT_DONE, (sensor, kind, told["because"], told["implausible"])
        margin = told["margin"]
        dead_time_ms = tomllib.loads(path.read_text())["robot"]["dead_time_ms"]
        assert margin["unlimited"] or margin["dead_time_margin_ms"] > 0.1 * dead_time_ms, (sensor, kind, margin)


def test_init_says_what_it_scaled(tmp_path):
    path = tmp_path / "my.toml"
    command("init", path, "--robot", "franka-fci", "--sensor", "unfiltered", check=True)
    assert "Scaled to" in path.read_text() and "grows by +" in path.read_text()
    command("init", path, "--force", check=True)
    assert "Scaled to" not in path.read_text()
