"""What `berth diagnose` writes is as its schema says, and a folder that is not is refused by the report."""

import copy
import json
import shutil
import sys

import numpy as np
import pytest
from conftest import EXIT_DONE, EXIT_INPUT, ROOT, command
from known_faults import FAULTS, made, place_in, report, told, write_record  # noqa: F401
from test_report import Page

sys.path.insert(0, str(ROOT / "scripts"))
import diagnosis_data  # noqa: E402
import diagnosis_words  # noqa: E402
import json_schema  # noqa: E402

SCHEMA = json.loads((ROOT / "scripts" / "diagnosis.schema.json").read_text())


def damage_missing(folder):
    (folder / "diagnosis.json").unlink()


def damage_cut(folder):
    path = folder / "diagnosis.json"
    path.write_text(path.read_text()[:500])


def damage_verdict(folder):
    path = folder / "diagnosis.json"
    path.write_text(path.read_text().replace('"nothing_detectable"', '"all well"'))


def damage_series(folder):
    path = folder / "series.csv"
    path.write_text(path.read_text()[:1003])


def damage_columns(folder):
    path = folder / "series.csv"
    path.write_text(path.read_text().replace("robot_error_after_m", "other", 1))


def damage_rig(folder):
    (folder / "extended.toml").unlink()


@pytest.fixture(scope="module")
def good(tmp_path_factory):
    """A folder of `berth diagnose` without a report."""
    folder = tmp_path_factory.mktemp("good")
    write_record(folder / "record.csv", FAULTS["nothing_detectable"], 20.0)
    assert command("diagnose", folder / "record.csv", "--rig", "ess", "--out", folder).returncode == EXIT_DONE
    return folder


@pytest.mark.parametrize("damage, words", [(damage_missing, "diagnosis.json"), (damage_cut, "no JSON"),
                                           (damage_verdict, "all well"), (damage_series, "series.csv"),
                                           (damage_columns, "robot_error_after_m"), (damage_rig, "extended.toml")])
def test_a_bad_folder_is_named(good, tmp_path, damage, words):
    folder = tmp_path / "bad"
    shutil.copytree(good, folder)
    damage(folder)
    done = report(folder)
    assert done.returncode == EXIT_INPUT and words in done.stderr and "Traceback" not in done.stderr, done.stderr
    assert not (folder / "report.html").exists() and not list(folder.glob("*.partial"))


def test_a_rig_that_eigen_refuses_is_said(good, tmp_path):
    folder = tmp_path / "refused"
    shutil.copytree(good, folder)
    program = tmp_path / "berth"
    program.write_text("#!/bin/sh\necho 'there is no model of this yet' >&2\nexit 2\n")
    program.chmod(0o755)
    done = report(folder, "--berth", program)
    assert done.returncode == EXIT_DONE, done.stderr
    text = Page(folder / "report.html").text
    assert "Cannot be told:" in text and "there is no model of this yet" in text


@pytest.mark.long
def test_a_folder_that_is_none_and_a_missing_program_are_named(tmp_path, made):
    _, folder, _ = made
    for arguments, words in (((tmp_path / "nowhere",), "nowhere"), ((folder, "--berth", tmp_path / "no"), "no")):
        done = report(*arguments)
        assert done.returncode == EXIT_INPUT and words in done.stderr and "Traceback" not in done.stderr


# --- the schema ---------------------------------------------------------------------------------------------------


def test_outputs_are_as_the_schema_says(made):
    _, folder, _ = made
    assert json_schema.errors_of(told(folder), SCHEMA) == []


def changed(found, place, value):
    """A copy with one value changed; None: taken out."""
    found = copy.deepcopy(found)
    *way, last = place.split(".")
    parent = place_in(found, ".".join(way)) if way else found
    last = int(last) if last.isdigit() else last
    if value is None:
        del parent[last]
    else:
        parent[last] = value
    return found


DAMAGES = [("verdict", "certain"), ("verdict", None), ("blocks", []), ("period_ms", 0), ("period_ms", "2.5"),
           ("schema", 2), ("schema", True), ("inputs.0.hash", "xyz"), ("inputs.0.role", "other"),
           ("block", "sensor"), ("surprise", 1), ("residual.robot_position_m.fit.after", -1.0),
           ("residual.robot_position_m.fit.floor", None), ("residual.wheel", {}), ("blocks.0.left.share", 1.5),
           ("blocks.0.base.0.value", "many"), ("blocks.0.floor_noise.ar", [None]), ("notes", "none")]
OF_CAUSES = [("causes", []), ("causes.0.effect", "backlash"), ("causes.0.parameters", []),
             ("causes.0.held_out_gain.ci95", [0.1]), ("causes.0.held_out_gain.value", 1.2),
             ("causes.0.parameters.0.ci95", [1.0]), ("verdict", "nothing_detectable"), ("verdict", "one_of"),
             ("blocks.0.ranking.0.round", 0.5)]


OF_NOTHING = [("detectable.0.value", "much"), ("detectable.0.unit", None), ("detectable.0.key", "backlash"),
              ("detectable.0.others", [{"name": "pitch_m"}]), ("verdict", "unknown"), ("detectable", None)]


def test_damaged_outputs_are_refused(made):
    verdict, folder, _ = made
    found = told(folder)
    for place, value in DAMAGES + {"named": OF_CAUSES, "nothing_detectable": OF_NOTHING}.get(verdict, []):
        errors = json_schema.errors_of(changed(found, place, value), SCHEMA)
        assert errors, (place, value)
        assert place.split(".")[-1] in " ".join(errors) or "causes" in " ".join(errors) or \
            "detectable" in " ".join(errors) or "alternatives" in " ".join(errors) or place.split(".")[0] in " ".join(errors), (place, errors)


def test_the_checker_refuses_what_it_does_not_know():
    with pytest.raises(ValueError, match="multipleOf"):
        json_schema.errors_of(3, {"multipleOf": 2})


def test_parts_that_each_count_from_the_start_stand_one_after_another():
    period_s = 0.02
    time_s = np.concatenate([np.arange(50) * period_s, np.arange(30) * period_s, np.arange(40) * period_s])
    laid_s = diagnosis_data.one_after_another(time_s, period_s)
    assert (np.diff(laid_s) > 0.99 * period_s).all()
    gaps = np.flatnonzero(np.diff(laid_s) > 1.5 * period_s)
    assert list(gaps) == [49, 79]
    assert np.diff(laid_s)[:49] == pytest.approx(period_s) and laid_s[0] == 0.0
    # A jump from one part to the next is no velocity.
    position_m = np.concatenate([0.3 * time_s[:50], 7.0 + 0.3 * time_s[50:80], -2.0 + 0.3 * time_s[80:]])
    assert diagnosis_data.velocity(position_m, laid_s, period_s) == pytest.approx(0.3)


def test_a_rival_that_fits_better_is_said_to_fail_on_unseen_data():
    assert diagnosis_words.rival_text({"delta_bic": 3.14}) == "worse by 3.1"
    assert diagnosis_words.rival_text({"delta_bic": -7.4}) == "better by 7.4"
    assert diagnosis_words.rival_text({"delta_bic": -212.5}) == "better by 212.5, but not proven on unseen data"
