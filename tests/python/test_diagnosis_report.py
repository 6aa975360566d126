"""scripts/diagnosis_report.py: tells what diagnosis.json tells, draws it in a browser, and is complete in itself.
The records are made here: a robot that follows its command 7 ticks late, with noise and a fault that is known."""

import copy
import json
import re
import shutil
import subprocess
import sys

import matplotlib.image
import numpy as np
import pytest
import scipy.signal
from browser import Browser
from conftest import EXIT_DONE, EXIT_INPUT, ROOT, command, play
from test_report import Page

sys.path.insert(0, str(ROOT / "scripts"))
import json_schema  # noqa: E402

SIZE_MAX_BYTES = 10e6
SEED = 20
RATE_Hz, DELAY_TICKS, NOISE_m = 400, 7, 2e-6  # the dead time of `ess` is 17.5 ms
BACKLASH_m = 4e-4
SCHEMA = json.loads((ROOT / "scripts" / "diagnosis.schema.json").read_text())
SIZES = {"m": 1.0, "mm": 1e-3, "µm": 1e-6, "nm": 1e-9, "pm": 1e-12, "kN": 1e3, "N": 1.0, "mN": 1e-3, "µN": 1e-6}


def no_law(reference):
    """A fault that no effect of the library describes: even in the position, with a comb on it."""
    return reference + 3e-4 * np.abs(np.sin(reference / 1.3e-3)) ** 0.3


FAULTS = {"named": lambda reference: play(reference, BACKLASH_m), "unknown": no_law,
          "nothing_detectable": lambda reference: reference}


def write_record(path, fault, duration_s=40.0):
    """A record of the robot alone; the true error of the rig `ess` about it, in m."""
    rng = np.random.default_rng(SEED)
    t_s = np.arange(int(duration_s * RATE_Hz)) / RATE_Hz
    command_m = sum(4e-3 / (k + 1) * np.sin(2 * np.pi * (0.11 + 0.37 * k) * t_s + 1.7 * k) for k in range(6))
    command_m = np.round((command_m - command_m[0]) * 1e11) / 1e11
    late_m = np.concatenate((np.full(DELAY_TICKS, command_m[0]), command_m[:-DELAY_TICKS]))
    robot_m = fault(late_m) + NOISE_m * rng.standard_normal(len(t_s))
    np.savetxt(path, np.column_stack((t_s, command_m, robot_m)), delimiter=",", comments="", fmt="%.12g",
               header="t_s,command_position_m,robot_position_m")
    return robot_m - late_m


def report(*arguments):
    words = [sys.executable, ROOT / "scripts" / "diagnosis_report.py", *map(str, arguments)]
    return subprocess.run(words, capture_output=True, text=True)


@pytest.fixture(scope="module", params=FAULTS)
def made(request, tmp_path_factory):
    """(verdict, folder with the report, true error as given)"""
    folder = tmp_path_factory.mktemp(request.param)
    record = folder / "record.csv"
    error_m = write_record(record, FAULTS[request.param])
    done = command("diagnose", record, "--rig", "ess", "--out", folder / "out")
    assert done.returncode == EXIT_DONE, done.stderr.decode()
    assert f"scripts/diagnosis_report.py {folder / 'out'}" in done.stdout.decode()
    made = report(folder / "out")
    assert made.returncode == EXIT_DONE, made.stderr
    assert str(folder / "out" / "report.html") in made.stdout and str(folder / "out" / "report.png") in made.stdout
    return request.param, folder / "out", error_m


def told(folder):
    return json.loads((folder / "diagnosis.json").read_text())


def test_the_verdict_is_said_in_words(made):
    verdict, folder, error_m = made
    found = told(folder)
    assert found["verdict"] == verdict, f"seed {SEED}"
    text = Page(folder / "report.html").text
    headline = {"named": "The rig file is wrong in the robot: robot.backlash.",
                "unknown": "The simulation is wrong in the robot (from the command to its position), and nothing in "
                           "the library explains it.",
                "nothing_detectable": "Measured and simulated agree down to the noise"}[verdict]
    assert headline in text
    # An oracle of its own: the rig as given is the pure delay, so its error is what was put in.
    used = error_m[2 * RATE_Hz:]
    before = found["residual"]["robot_position_m"]["fit"]["before"]
    assert before == pytest.approx(np.sqrt(np.mean(used ** 2)), rel=0.1)
    if verdict == "unknown":
        assert "most of it from" in text and "the quarter of the rows" in text
        assert f"By class it is {found['blocks'][0]['left']['depends']}" in text
    if verdict == "nothing_detectable":
        assert "would have shown from about" in text
    if verdict == "named":
        parameter = found["causes"][0]["parameters"][0]
        assert parameter["value"] == pytest.approx(BACKLASH_m, rel=0.02)


def place_in(found, path):
    for name in path.split("."):
        found = found[int(name) if name.isdigit() else name]
    return found


def cells(page):
    """(place in diagnosis.json, text shown) of every cell that shows a number of it."""
    found = re.findall(r'<td class="number" data-of="([^"]+)">([^<]*)</td>', page.read_text(encoding="utf-8"))
    assert len(found) >= 7
    return found


def test_figures_shown_are_those_of_the_json(made):
    verdict, folder, _ = made
    found = told(folder)
    shown = cells(folder / "report.html")
    for place, text in shown:
        value, unit = re.match(r"(−?[\d.]+(?:e[+−]?\d+)?) ?(\S*)", text).groups()
        value = float(value.replace("−", "-"))
        wanted = place_in(found, place)
        if place.startswith("blocks") and ".residual." in place:
            assert value * SIZES[unit] == pytest.approx(wanted, rel=6e-3), (place, text)
        elif unit == "%":
            assert value == pytest.approx(100.0 * min(wanted, 1.0), abs=0.051), (place, text)
        else:
            assert value == pytest.approx(wanted, rel=6e-3, abs=0.051), (place, text)
    places = [place for place, _ in shown]
    for part in ("fit", "held_out"):
        assert all(f"blocks.0.residual.{part}.{key}" in places for key in ("before", "retuned", "after"))
    sizes = [f"detectable.{i}.value" for i, one in enumerate(found["detectable"]) if one["value"] is not None]
    assert all(place in places for place in sizes) and (len(sizes) > 8) == (verdict == "nothing_detectable")
    if found["next_experiment"] and found["next_experiment"]["file"]:
        assert "next_experiment.predicted_gap" in places and found["next_experiment"]["excitation"] in \
            Page(folder / "report.html").text
    if verdict == "named":
        gain = found["causes"][0]["held_out_gain"]
        text = dict(shown)["causes.0.held_out_gain.value"]
        numbers = [float(part) for part in re.findall(r"[\d.]+", text)]
        assert numbers == pytest.approx([100.0 * gain["value"], *(100.0 * end for end in gain["ci95"])], abs=0.051)
        half = re.search(r"± (\S+)", dict(shown)["causes.0.parameters.0.value"])[1].replace("−", "-")
        low, high = found["causes"][0]["parameters"][0]["ci95"]
        assert float(half) == pytest.approx(0.5 * (high - low), rel=0.06)
    for one in found["inputs"]:
        assert one["hash"] in Page(folder / "report.html").text
    assert found["versions"]["berth"] in Page(folder / "report.html").text


PROBE = """({
  panels: Object.fromEntries(panels.map((p) => [p.name, {
    traces: p.plot.data.length, lines: p.plot.querySelectorAll(".scatterlayer path.js-line").length,
    height: p.plot.getBoundingClientRect().height, points: p.plot.data.map((d) => d.x.length)}])),
  plots: Object.fromEntries([...document.querySelectorAll(".plot")].map((p) => [p.id, {
    traces: p.data.length, marks: p.querySelectorAll(
      ".scatterlayer path.js-line, .scatterlayer path.js-fill, .barlayer g.point path").length,
    height: p.getBoundingClientRect().height, width: p.getBoundingClientRect().width}])),
})"""


def test_every_plot_is_drawn_in_a_browser(made, tmp_path):
    verdict, folder, _ = made
    with Browser(folder / "report.html", tmp_path) as browser:
        browser.evaluate("allDrawn.then(() => true)")
        console = list(browser.console)
        seen = browser.evaluate(PROBE)
        zoomed = browser.evaluate("""(async () => {
          await Plotly.relayout(panels[0].plot, {"xaxis.range": [5, 6]});
          while (!panels.every((p) => p.plot.layout.xaxis.range[1] === 6)) await new Promise(requestAnimationFrame);
          return panels.map((p) => [p.plot.layout.xaxis.range, p.plot.data[0].x.length]);
        })()""")
    assert console == []
    traces = {name: panel["traces"] for name, panel in seen["panels"].items()}
    assert traces == {"robot-signals": 3, "robot-errors": 2}
    for name, panel in seen["panels"].items():
        assert panel["lines"] == panel["traces"] and panel["height"] > 200, (name, panel)
        assert min(panel["points"]) > 2000
    wanted = {"robot-position": 4, "robot-velocity": 4, "robot-spectrum": 3}
    ranking = told(folder)["blocks"][0]["ranking"]
    if ranking:
        wanted["robot-ranking"] = 2
    assert {name: plot["traces"] for name, plot in seen["plots"].items()} == wanted
    for name, plot in seen["plots"].items():
        marks = 2 * len(ranking) if name.endswith("ranking") else wanted[name]
        assert plot["marks"] >= marks and plot["height"] > 250 and plot["width"] > 300, (name, plot)
    assert verdict != "named" or ranking
    for span, points in zoomed:  # all zoom together, and show every row
        assert span == [5, 6] and points == pytest.approx(RATE_Hz, abs=3)


def test_drawn_errors_are_those_of_the_record(made):
    """The residual as given, read back from the page, against the fault that was put in."""
    _, folder, error_m = made
    page = Page(folder / "report.html")
    time_s, drawn = page.curve("robot-errors", "as given")
    _, after = page.curve("robot-errors", "extended")
    panel = next(panel for panel in page.data["panels"] if panel["name"] == "robot-errors")
    unit = re.search(r"error \((.*)\)", panel["layout"]["yaxis"]["title"]["text"])[1]
    rows = np.rint(time_s * RATE_Hz).astype(int)
    assert len(rows) > 0.9 * len(error_m)
    late = rows > 2 * RATE_Hz
    assert np.allclose(SIZES[unit] * drawn[late], error_m[rows[late]], atol=1e-9)
    assert np.sqrt(np.mean(after**2)) <= 1.01 * np.sqrt(np.mean(drawn**2))  # as fits weigh it: about 0
    measured, given, extended = (page.curve("robot-signals", name)[1]
                                 for name in ("measured", "simulated, rig as given", "simulated, extended"))
    assert np.allclose(1e-3 * (measured - given), SIZES[unit] * drawn, atol=1e-8)
    assert np.allclose(1e-3 * (measured - extended), SIZES[unit] * after, atol=1e-8)


def test_the_spectrum_is_scipys(made):
    import diagnosis_data
    _, folder, _ = made
    block = diagnosis_data.read_diagnosis(folder).blocks[0]
    frequency_Hz, power = diagnosis_data.power_density(block.before, block.period_s)
    rows = 2 * (len(frequency_Hz) - 1)
    wanted_Hz, wanted = scipy.signal.welch(block.before, RATE_Hz, np.hanning(rows), detrend=False)
    assert np.allclose(frequency_Hz, wanted_Hz) and np.allclose(power, wanted, rtol=1e-9)


def test_the_floors_spectrum_holds_its_variance():
    import diagnosis_data
    frequency_Hz = np.linspace(0.0, 200.0, 4001)
    floor = diagnosis_data.floor_density({"ar": [0.6], "sigma": 2.0}, frequency_Hz, 1.0 / RATE_Hz)
    assert np.trapezoid(floor, frequency_Hz) == pytest.approx(4.0 / (1.0 - 0.36), rel=1e-4)


def test_the_page_is_complete_and_small(made):
    _, folder, _ = made
    path = folder / "report.html"
    assert path.stat().st_size < SIZE_MAX_BYTES
    page = Page(path)
    for tag, attributes in page.elements:
        assert tag not in ("link", "img", "iframe", "object", "embed", "base"), (tag, attributes)
        assert not {"src", "srcset", "data", "action"} & set(attributes), (tag, attributes)
    ours = [text for text in page.scripts if "plotly.js v" not in text[:400]]
    assert not re.search(r"url\(|https?:|@import|fetch\(|XMLHttpRequest", "".join(ours))
    pixels = matplotlib.image.imread(folder / "report.png")[..., :3]
    assert pixels.shape == (1000, 1600, 3) and 0.02 < np.mean(pixels.min(axis=2) < 0.9) < 0.6


def test_stability_is_that_of_eigen_and_says_what_it_does_not_know(made):
    verdict, folder, _ = made
    text = Page(folder / "report.html").text
    for name in ("given", "extended"):
        growth = json.loads(command("eigen", folder / f"{name}.toml", "--json").stdout)["growth_per_s"]
        assert f"(growth {growth:+.6g} /s)".replace("-", "−") in text
    if verdict != "named":
        return
    extended = (folder / "extended.toml").read_text()
    without = folder / "without.toml"
    without.write_text(re.sub(r"backlash_m = .*\n", "", extended))
    assert without.read_text() != extended
    eigen = [json.loads(command("eigen", path, "--json").stdout)["eigenvalues"]
             for path in (folder / "extended.toml", without)]
    assert ("do not account for robot.backlash" in text) == (eigen[0] == eigen[1])


def test_an_effect_that_eigen_knows_is_not_called_ignored(tmp_path):
    """The example of `make diagnose`, shortened: a transfer behaviour changes the eigenvalues."""
    done = command("run", "ess", "--set", "robot.transfer_frequency_Hz=12", "--set", "run.duration_s=15", "--set",
                   "profile.kind=multisine", "--set", "profile.amplitude_m=0.01", "--set", "profile.duration_s=10",
                   "--out", tmp_path)
    assert done.returncode == EXIT_DONE, done.stderr
    assert command("diagnose", tmp_path / "ess.ulg", "--rig", "ess", "--out", tmp_path).returncode == EXIT_DONE
    assert report(tmp_path).returncode == EXIT_DONE
    assert told(tmp_path)["causes"][0]["effect"] == "robot.resonance"
    text = Page(tmp_path / "report.html").text
    assert "What the extension does to the stability limit" in text and "do not account for" not in text


def test_a_long_record_stays_small_and_keeps_its_extremes(tmp_path):
    write_record(tmp_path / "record.csv", FAULTS["nothing_detectable"])
    assert command("diagnose", tmp_path / "record.csv", "--rig", "ess", "--out", tmp_path).returncode == EXIT_DONE
    lines = (tmp_path / "series.csv").read_text().splitlines()
    names = lines[0].split(",")
    rows = np.loadtxt(lines[1:], delimiter=",")
    long = np.tile(rows, (20, 1))
    long[:, 0] = np.arange(len(long)) / RATE_Hz
    spike = len(long) // 3
    long[spike, names.index("robot_use")] = 1
    long[spike, names.index("robot_error_after_m")] = 1.0
    np.savetxt(tmp_path / "series.csv", long, delimiter=",", comments="", header=lines[0], fmt="%.9g")
    done = report(tmp_path)
    assert done.returncode == EXIT_DONE, done.stderr
    assert (tmp_path / "report.html").stat().st_size < SIZE_MAX_BYTES
    page = Page(tmp_path / "report.html")
    assert "the lowest and the highest are shown" in page.text
    time_s, drawn = page.curve("robot-errors", "extended")
    assert len(drawn) < 0.1 * len(long)
    assert time_s[np.nanargmax(drawn)] == pytest.approx(spike / RATE_Hz, abs=1e-6)


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


def test_a_folder_that_is_none_and_a_missing_program_are_named(tmp_path, made):
    _, folder, _ = made
    for arguments, words in (((tmp_path / "nowhere",), "nowhere"), ((folder, "--berth", tmp_path / "no"), "no")):
        done = report(*arguments)
        assert done.returncode == EXIT_INPUT and words in done.stderr and "Traceback" not in done.stderr


def test_a_record_without_a_command_is_refused(tmp_path):
    write_record(tmp_path / "record.csv", FAULTS["nothing_detectable"], 20.0)
    text = (tmp_path / "record.csv").read_text()
    (tmp_path / "record.csv").write_text(text.replace("command_position_m,robot_position_m",
                                                      "robot_position_m,force_N"))
    done = command("diagnose", tmp_path / "record.csv", "--rig", "ess", "--out", tmp_path)
    assert done.returncode == EXIT_INPUT and b"no block can be replayed" in done.stderr


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


DAMAGES = [("verdict", "certain"), ("verdict", None), ("blocks", []), ("period_s", 0), ("period_s", "0.0025"),
           ("versions.schema", 2), ("versions.schema", True), ("inputs.0.hash", "xyz"), ("inputs.0.role", "other"),
           ("block", "sensor"), ("surprise", 1), ("residual.robot_position_m.fit.after", -1.0),
           ("residual.robot_position_m.fit.floor", None), ("residual.wheel", {}), ("blocks.0.left.share", 1.5),
           ("blocks.0.base.0.value", "many"), ("blocks.0.floor_noise.ar", [None]), ("notes", "none")]
OF_CAUSES = [("causes", []), ("causes.0.effect", "backlash"), ("causes.0.parameters", []),
             ("causes.0.held_out_gain.ci95", [0.1]), ("causes.0.held_out_gain.value", 1.2),
             ("causes.0.parameters.0.ci95", [1.0]), ("verdict", "nothing_detectable"), ("verdict", "one_of"),
             ("blocks.0.ranking.0.round", 0.5)]


OF_NOTHING = [("detectable.0.value", "much"), ("detectable.0.parameter", None), ("detectable.0.key", "backlash"),
              ("detectable.0.others", [{"parameter": "pitch_m"}]), ("verdict", "unknown"), ("detectable", None)]


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
