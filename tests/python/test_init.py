"""`berth init`: every file that it writes is a rig that runs, and none is lost."""

import json
import re
import subprocess
import tomllib

import jsonschema
import pytest
from conftest import BERTH, EXIT_DONE, EXIT_INPUT, ROOT, SHORT, berth, command, one_json_object, settings

ROBOTS = sorted(path.stem for path in (ROOT / "sim_hal" / "robots").glob("*.toml"))
SENSORS = ("one-axis", "six-axis", "unfiltered")
OBJECTS = ("gripped", "contact", "beam", "none")


def initialised(folder, robot, sensor, kind):
    file = folder / f"{robot or 'usual'}-{sensor}-{kind}.toml"
    words = ["--robot", robot] if robot else []
    done = command("init", file, "--sensor", sensor, "--object", kind, *words)
    assert done.returncode == EXIT_DONE, done.stderr.decode()
    return file


@pytest.mark.long
def test_every_file_that_init_writes_validates(tmp_path):
    """And passes `check`: test_init_rigs.py."""
    for robot in (None, *ROBOTS):
        for sensor in SENSORS:
            for kind in OBJECTS:
                file = initialised(tmp_path, robot, sensor, kind)
                lines = file.read_text().splitlines()
                schema = tmp_path / lines[0].removeprefix("#:schema ")
                jsonschema.Draft202012Validator(json.loads(schema.read_text())).validate(
                    tomllib.loads(file.read_text()))
                assert all("#" in line for line in lines if " = " in line and line[0] not in "#nd")


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


@pytest.mark.parametrize("name", ["new\nline", "tab\there", "a" * 300])
def test_init_refuses_a_name_that_no_rig_may_have(name, tmp_path):
    refused = berth(tmp_path, "init", f"{name}.toml")
    assert refused.returncode == EXIT_INPUT and refused.stderr.count("\n") == 1 and not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["my.toml", "my rig.toml", "it's.toml", "-x.toml"])
def test_init_prints_the_next_command_and_it_works(name, tmp_path):
    lines = berth(tmp_path, "init", "--", name).stdout.splitlines()
    assert lines[0] == name and lines[-1].startswith("next: ")
    words = lines[-1].partition("berth ")[2]
    assert subprocess.run(f"{BERTH} {words}", shell=True, cwd=tmp_path, capture_output=True).returncode == EXIT_DONE


def test_a_comment_of_init_lists_the_words_of_a_key_once(tmp_path):
    [line] = [line for line in initialised(tmp_path, None, "one-axis", "beam").read_text().splitlines()
              if line.startswith("kind = ")]
    assert {word: len(re.findall(rf"\b{word}\b", line.partition("#")[2])) for word in OBJECTS} == dict.fromkeys(OBJECTS, 1)
