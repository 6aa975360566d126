"""What `berth diagnose` proposes to measure next: played on a rig with the true effect, it decides; and where no
experiment can, a calibration is named."""

import json
import sys

import numpy as np
import pytest
from conftest import EXIT_DONE, EXIT_INPUT, ROOT, command, settings

sys.path.insert(0, str(ROOT / "scripts"))
import json_schema  # noqa: E402

SCHEMA = json.loads((ROOT / "scripts" / "diagnosis.schema.json").read_text())
NOISE = {"sensor.noise_N": 0.2, "robot.feedback_noise_m": 5e-6}
SMALL = {"run.duration_s": 20, "profile.kind": "multisine", "profile.frequency_end_Hz": 3}


def run(folder, keys, *more):
    done = command("run", "ess", *settings(keys), *more, "--out", folder)
    assert done.returncode == EXIT_DONE, done.stderr.decode()
    return folder / "ess.ulg"


def diagnose(record, out, keys):
    done = command("diagnose", record, "--rig", "ess", *settings(keys), "--out", out)
    assert done.returncode == EXIT_DONE, done.stderr.decode()
    found = json.loads((out / "diagnosis.json").read_text())
    assert json_schema.errors_of(found, SCHEMA) == []
    return found, done.stdout.decode()


def names(entries):
    return [entry["effect"] for entry in entries]


@pytest.mark.long
@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.first(1)
def test_the_proposed_experiment_decides(tmp_path, seed):
    """About 10 mm and within 0.5 mm of it, a spring that hardens is like one that is stiffer on one side."""
    told = {"manipulator.initial_position_m": 0.01, "profile.offset_m": 0.01}
    true = {"object.cubic_stiffness_N_per_m3": 1e6}
    record = run(tmp_path, {**SMALL, **NOISE, **told, **true, "profile.amplitude_m": 5e-4, "run.seed": seed})
    found, terminal = diagnose(record, tmp_path / "first", told)
    rivals = {"object.cubic_stiffness", "object.quadratic_stiffness"}
    assert found["verdict"] == "one_of" and set(names(found["causes"] + found["alternatives"])) == rivals, seed
    proposed = found["next_experiment"]
    assert set(proposed["rivals"]) == rivals and proposed["calibration"] is None
    assert proposed["predicted_delta_bic"] > 1000.0 and proposed["excitation"] in terminal
    # The profile starts and stays within six times the way that the record went.
    profile = tmp_path / "first" / proposed["file"]
    columns = np.genfromtxt(profile, delimiter=",", names=True)
    assert columns.dtype.names == ("t_s", "operator_position_m")
    assert columns["t_s"][-1] == pytest.approx(proposed["duration_s"])
    assert 5e-4 < np.abs(columns["operator_position_m"]).max() < 0.05

    keys = {**NOISE, **told, **true, "run.seed": seed + 10, "run.duration_s": proposed["duration_s"] + 0.1}
    second = run(tmp_path / "second", keys, "--profile", profile)
    decided, _ = diagnose(second, tmp_path / "second", told)
    assert decided["verdict"] == "named" and names(decided["causes"]) == ["object.cubic_stiffness"], seed
    assert decided["next_experiment"] is None
    # The rivals' distance is what was predicted, by the new record's own ranking, within a factor of 2.
    ranking = {one["effect"]: one["delta_bic"] for one in decided["blocks"][-1]["ranking"] if one["round"] == 1}
    gap = ranking["object.cubic_stiffness"] - ranking["object.quadratic_stiffness"]
    assert 0.5 < gap / proposed["predicted_delta_bic"] < 2.0, (gap, proposed["predicted_delta_bic"])


@pytest.mark.long
@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.first(1)
def test_rivals_that_the_force_was_asked_about_are_told_apart(tmp_path, seed):
    """A robot that is later by 3 ms, seen up to 2 Hz: a dead time, or what a fast resonance does there."""
    keys = {**SMALL, **NOISE, "profile.amplitude_m": 0.01, "profile.frequency_end_Hz": 2, "run.seed": seed}
    found, terminal = diagnose(run(tmp_path, {**keys, "robot.dead_time_ms": 20.5}), tmp_path / "out", {})
    assert "robot.dead_time" in names(found["causes"] + found["alternatives"]), seed
    if found["verdict"] == "one_of":
        assert set(found["next_experiment"]["rivals"]) == set(names(found["causes"] + found["alternatives"])), seed
        assert "no effect of the library comes near" not in terminal, seed
    else:
        assert found["verdict"] == "named" and found["next_experiment"] is None, seed


@pytest.mark.long
def test_where_no_experiment_can_a_calibration_is_named(tmp_path):
    """What a sensor with a wrong gain shows, an object with more of everything shows as well."""
    record = run(tmp_path, {**SMALL, **NOISE, "profile.amplitude_m": 0.01, "sensor.gain_error": 0.1})
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "next_experiment.csv").write_text("of an earlier diagnosis")
    found, terminal = diagnose(record, tmp_path / "out", {})
    assert found["verdict"] == "one_of"
    assert set(names(found["causes"] + found["alternatives"])) == {"sensor.gain", "object.parameters"}
    proposed = found["next_experiment"]
    assert proposed["file"] is None and proposed["predicted_delta_bic"] < 60.0
    assert "known mass" in proposed["calibration"] and proposed["calibration"] in terminal
    assert not (tmp_path / "out" / "next_experiment.csv").exists()


@pytest.mark.long
def test_a_record_that_shows_nothing_is_followed_by_one_that_shows_more(tmp_path):
    """The sizes that the second record would have shown are smaller by about what was promised."""
    told = {"manipulator.initial_position_m": 0.001}
    record = run(tmp_path, {**SMALL, **NOISE, **told, "profile.amplitude_m": 0.001})
    first, _ = diagnose(record, tmp_path / "first", told)
    assert first["verdict"] == "nothing_detectable"
    proposed = first["next_experiment"]
    keys = {**NOISE, **told, "run.seed": 5, "run.duration_s": proposed["duration_s"] + 0.1}
    second, _ = diagnose(run(tmp_path / "second", keys, "--profile", tmp_path / "first" / proposed["file"]),
                         tmp_path / "second", told)
    assert second["verdict"] == "nothing_detectable"
    sizes = [{one["key"]: one["value"] for one in found["detectable"]} for found in (first, second)]
    for key in ("object.cubic_stiffness_N_per_m3", "object.quadratic_stiffness_N_per_m2", "robot.gain_error"):
        assert sizes[1][key] < 0.5 * sizes[0][key], key


def test_a_profile_that_cannot_be_played(tmp_path):
    for text, what in (("t_s,operator_position_m\n0,0\n0,1\n", "does not increase"), ("t_s\n0\n", "columns"),
                       ("t_s,operator_position_m\n0,zero\n1,1\n", "finite number")):
        (tmp_path / "bad.csv").write_text(text)
        done = command("run", "ess", "--profile", tmp_path / "bad.csv", "--out", tmp_path / "out")
        assert done.returncode == EXIT_INPUT and what in done.stderr.decode(), done.stderr.decode()
        assert "bad.csv" in done.stderr.decode() and not (tmp_path / "out").exists()
