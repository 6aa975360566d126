"""scripts/diagnosis_report.py: tells what diagnosis.json tells, draws it in a browser, and is complete in itself."""

import json
import re
import sys
import types

import matplotlib.image
import numpy as np
import pytest
import scipy.signal
from browser import Browser
from conftest import EXIT_DONE, ROOT, command
from known_faults import BACKLASH_m, FAULTS, RATE_Hz, SEED, made, place_in, report, told, write_record  # noqa: F401
from test_report import Page, is_beside

sys.path.insert(0, str(ROOT / "scripts"))
import diagnosis_page  # noqa: E402

SIZE_MAX_BYTES = 1e6
SIZES = {"m": 1.0, "mm": 1e-3, "µm": 1e-6, "nm": 1e-9, "pm": 1e-12, "kN": 1e3, "N": 1.0, "mN": 1e-3, "µN": 1e-6}


@pytest.mark.long
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
        assert "most of it from" in text
        left = found["blocks"][0]["left"]
        assert (f"the quarter of the rows {left['where']['rows']} holds" in text) == (left["where"]["share"] > 0.3)
        assert (f"By class it is {left['depends']}" in text) == (left["share"] > 0.001)
        assert f"Why it is not fully explained: {'; '.join(found['blocks'][0]['doubts'])}." in text
    if verdict == "nothing_detectable":
        assert "would have shown from about" in text
    if verdict == "named":
        parameter = found["causes"][0]["parameters"][0]
        assert parameter["value"] == pytest.approx(BACKLASH_m, rel=0.02)


def error_left(folder, block):
    """Of the rows in use: error in the extended rig, time, position and velocity, from series.csv."""
    with (folder / "series.csv").open() as file:
        names = file.readline().strip().split(",")
        series = dict(zip(names, np.loadtxt(file, delimiter=",").T))
    used = series[f"{block['block']}_use"] > 0
    position_m = series["command_position_m"]
    velocity_m_per_s = np.gradient(position_m, series["t_s"])
    error = series[f"{block['block']}_error_after_{block['residual']['unit']}"]
    return error[used], series["t_s"][used], position_m[used], velocity_m_per_s[used]


def test_where_the_rest_lives_is_where_scipy_finds_it(made):
    verdict, folder, _ = made
    block = told(folder)["blocks"][0]
    left = block["left"]
    if verdict != "unknown":
        assert left["band_Hz"] is None and left["where"] is None
        return
    error, t_s, position_m, velocity_m_per_s = error_left(folder, block)
    rows = 2048
    frequency_Hz, power = scipy.signal.welch(error, RATE_Hz, np.hanning(rows), detrend=False)
    _, filtered = scipy.signal.freqz([1.0], [1.0, *(-a for a in block["floor_noise"]["ar"])], frequency_Hz, fs=RATE_Hz)
    floor = 2.0 / RATE_Hz * block["floor_noise"]["sigma"] ** 2 * np.abs(filtered) ** 2
    share = np.cumsum(np.maximum(power - floor, 0.0)[1:])
    ends = frequency_Hz[1:][np.searchsorted(share / share[-1], (0.1, 0.9))]
    assert left["band_Hz"] == pytest.approx(list(ends), abs=1.01 * RATE_Hz / rows)
    acceleration = np.abs(np.gradient(velocity_m_per_s))
    middle_m = np.abs(position_m - np.median(position_m))
    of = {"farthest from the middle position": middle_m, "nearest to the middle position": -middle_m,
          "with the fastest motion": np.abs(velocity_m_per_s), "with the slowest motion": -np.abs(velocity_m_per_s),
          "fastest on the way up": velocity_m_per_s, "fastest on the way down": -velocity_m_per_s,
          "with the strongest acceleration": acceleration, "with the weakest acceleration": -acceleration,
          "at the highest positions": position_m, "at the lowest positions": -position_m,
          "at the end of the record": t_s, "at the start of the record": -t_s}
    shares = {words: np.sum(error[state >= np.quantile(state, 0.75)] ** 2) / np.sum(error**2)
              for words, state in of.items()}
    assert left["where"]["rows"] == max(shares, key=shares.get)
    assert left["where"]["share"] == pytest.approx(max(shares.values()), abs=2e-3)


def test_the_terminal_says_where_the_rest_lives(made, tmp_path):
    verdict, folder, _ = made
    done = command("diagnose", folder.parent / "record.csv", "--rig", "ess", "--out", tmp_path)
    text = done.stdout.decode()
    left = told(folder)["blocks"][0]["left"]
    assert ("  left " in text) == (verdict == "unknown")
    if verdict == "unknown":
        low_Hz, high_Hz = left["band_Hz"]
        assert f"most of it from {low_Hz:.3g} to {high_Hz:.3g} Hz" in text and "times the noise" in text
        where, more_than_its_share = left["where"], 0.3
        line = f"the quarter of the rows {where['rows']} has {100 * where['share']:.0f} %"
        assert (line in text) == (where["share"] > more_than_its_share)
        assert (f"by its class it is {left['depends']}" in text) == (left["share"] > 0.001)
    doubts = told(folder)["blocks"][0]["doubts"]
    assert bool(doubts) == ("  open " in text) == (verdict == "unknown") and all(one in text for one in doubts)


def test_words_do_not_contradict_each_other():
    """All of an error is never explained where some of it is left."""
    import diagnosis_words
    shares = {0.3: "30.0 %", 0.99: "99.0 %", 0.99973: "99.97 %", 0.999996: "99.9996 %", 0.9999999: "nearly all",
              1.0: "nearly all", 1.2: "nearly all"}
    for share, text in shares.items():
        assert diagnosis_words.share_text(share, "partly_explained") == text
        assert diagnosis_words.share_text(share, "named") == f"{min(100.0, 100.0 * share):.1f} %"


def test_what_chance_explains_is_no_share():
    """Of an error that is all noise a candidate may take "100 %" of next to nothing."""
    import diagnosis_words
    chance = {"delta_bic": -16.0, "share_explained": 1.0}
    assert diagnosis_words.ranked_share(chance) == (0.0, "as chance")
    assert diagnosis_words.ranked_share(chance | {"delta_bic": 16.0}) == (1.0, "100.0 %")
    assert diagnosis_words.ranked_share(chance | {"delta_bic": 16.0, "share_explained": 1.2}) == \
        (1.0, "with noise")


@pytest.mark.parametrize("shown_by, of", [("robot", ""), ("force", " of the force")])
def test_a_share_of_the_error_of_the_force_is_told_as_that(shown_by, of):
    import diagnosis_words
    lost = {"effect": "robot.lost_commands", "parameters": [], "delta_bic": None, "held_out_gain": None,
            "share_explained": 0.9, "shown_by": shown_by}
    assert f" 90.0 % of the explainable error{of}. " in diagnosis_words.cause_sentence(lost, "named")


def test_a_parameter_that_was_not_fitted_stands_as_given():
    import diagnosis_words
    one = {"name": "stale_probability", "key": "sensor.stale_probability", "value": 0.0, "ci95": [0.0, 0.0],
           "unit": "1", "fitted": False}
    assert diagnosis_words.estimate(one) == "0, as given"
    cut = one | {"value": 0.001, "ci95": [0.0, 0.003], "fitted": True}
    assert diagnosis_words.estimate(cut) == "0.001 (0 to 0.003)"
    assert diagnosis_words.estimate(cut | {"ci95": [-0.001, 0.003]}) == "0.0010 ± 0.0020"


@pytest.mark.parametrize("value, half, unit, text", [
    (12.006, 0.062, "Hz", "12.006 ± 0.062 Hz"), (12.0, 0.05, "Hz", "12.000 ± 0.050 Hz"),
    (11.99999998, 4.2e-8, "Hz", "12.0000 ± < 0.0001 Hz"), (2368.705, 6e-9, "N_per_m", "2368.70 ± < 0.01 N/m"),
    (100.0, 12.0, "kg", "100 ± 12 kg"), (-0.7, 1e-9, "1", "−0.700000 ± < 1e−06")])
def test_a_value_has_the_digits_of_its_interval(value, half, unit, text):
    import diagnosis_words
    assert diagnosis_words.estimate({"value": value, "ci95": [value - half, value + half], "unit": unit,
                                     "fitted": True}) == text


def test_the_picture_tells_every_cause_within_its_edges(made):
    """However many there are: the sentences stay on the picture and above the plots."""
    import diagnosis_picture
    from diagnosis_data import read_diagnosis
    from matplotlib import pyplot
    verdict, folder, _ = made
    found = read_diagnosis(folder)
    if verdict != "named":
        return
    names = ["robot.backlash", "manipulator.quadratic_stiffness", "sensor.periodic_disturbance",
             "object.impact_damping"]
    cause = found.told["causes"][0]
    found.told.update(verdict="partly_explained", causes=[cause | {"effect": name} for name in names])
    figure = pyplot.figure(figsize=(16, 10), dpi=100)
    end = diagnosis_picture.write_head(figure, found)
    boxes = [text.get_window_extent() for text in figure.texts]
    words = "".join(text.get_text() for text in figure.texts)
    pyplot.close(figure)
    assert all(words.count(name) == 2 for name in names)  # in the headline and in a sentence
    assert all(0.0 <= box.x0 and box.x1 <= 1600.0 and box.y1 <= 1000.0 for box in boxes)
    assert min(box.y0 for box in boxes if box.y0 > 100.0) >= 1000.0 * end - 5.0
    title, _, headline, text, _ = sorted(boxes, key=lambda box: -box.y0)
    assert title.y0 > headline.y1 > headline.y0 > text.y1


def cells(page):
    """(place in diagnosis.json, text shown) of every cell that shows a number of it."""
    found = re.findall(r'<td class="number" data-of="([^"]+)"[^>]*>([^<]*)</td>', page.read_text(encoding="utf-8"))
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
        assert "next_experiment.predicted_delta_bic" in places and found["next_experiment"]["excitation"] in \
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
    assert found["version"] in Page(folder / "report.html").text


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
        assert min(panel["points"]) > 1000
    wanted = {"robot-position": 4, "robot-velocity": 4, "robot-spectrum": 3}
    ranking = told(folder)["blocks"][0]["ranking"]
    if ranking:
        wanted["robot-ranking"] = 2
    assert {name: plot["traces"] for name, plot in seen["plots"].items()} == wanted
    for name, plot in seen["plots"].items():
        marks = 2 * len(ranking) if name.endswith("ranking") else wanted[name]
        assert plot["marks"] >= marks and plot["height"] > 250 and plot["width"] > 300, (name, plot)
    assert verdict != "named" or ranking
    for span, points in zoomed:  # all zoom together, and show what the page holds there
        assert span == [5, 6] and 50 < points < RATE_Hz + 3


def test_drawn_errors_are_those_of_the_record(made):
    """The residual as given, read back from the page, against the fault that was put in."""
    _, folder, error_m = made
    page = Page(folder / "report.html")
    time_s, drawn = page.curve("robot-errors", "as given")
    _, after = page.curve("robot-errors", "extended")
    panel = next(panel for panel in page.data["panels"] if panel["name"] == "robot-errors")
    unit = re.search(r"error \((.*)\)", panel["layout"]["yaxis"]["title"]["text"])[1]
    rows = np.rint(time_s * RATE_Hz).astype(int)
    late = rows > 2 * RATE_Hz
    assert late.sum() > 1000
    assert np.allclose(SIZES[unit] * drawn[late], error_m[rows[late]], atol=1e-9)
    assert SIZES[unit] * drawn[late].max() == pytest.approx(error_m[rows[late][0]:rows[-1]].max(), abs=1e-9)
    assert np.sqrt(np.mean(after**2)) <= 1.01 * np.sqrt(np.mean(drawn**2))  # as fits weigh it: about 0
    signals = {name: dict(zip(np.rint(RATE_Hz * times_s).astype(int), values)) for name in
               ("measured", "simulated, rig as given", "simulated, extended")
               for times_s, values in (page.curve("robot-signals", name),)}
    for name, error in (("simulated, rig as given", "as given"), ("simulated, extended", "extended")):
        errors = {row: value for times_s, values in (page.curve("robot-errors", error),)
                  for row, value in zip(np.rint(RATE_Hz * times_s).astype(int), values)}
        common = [row for row in errors if row in signals["measured"] and row in signals[name]]
        assert len(common) > 20
        differences = [1e-3 * (signals["measured"][row] - signals[name][row]) for row in common]
        assert np.allclose(differences, [SIZES[unit] * errors[row] for row in common], atol=1e-8)


def test_the_spectrum_is_scipys(made):
    import diagnosis_data
    _, folder, _ = made
    block = diagnosis_data.read_diagnosis(folder).blocks[0]
    frequency_Hz, power = diagnosis_data.power_density(block.before, block.period_s)
    rows = 2 * (len(frequency_Hz) - 1)
    wanted_Hz, wanted = scipy.signal.welch(block.before, RATE_Hz, np.hanning(rows), detrend=False)
    assert np.allclose(frequency_Hz, wanted_Hz) and np.allclose(power, wanted, rtol=1e-9)


# What is new has variance 4. Of a slow noise of decay a that a gain k follows: k of it is what is predicted, 1 - k white,
# and the slow noise has k (1 - a^2 (1 - k)) / (1 - a^2) of it.
@pytest.mark.parametrize("noise, variance", [
    ({"ar": [0.6], "slow_decay": 0.0, "slow_gain": 0.0}, 4.0 / (1.0 - 0.36)),
    ({"ar": [], "slow_decay": 0.9, "slow_gain": 0.2}, 4.0 * (0.8 + 0.2 * (1.0 - 0.81 * 0.8) / (1.0 - 0.81))),
])
def test_the_floors_spectrum_holds_its_variance(noise, variance):
    import diagnosis_data
    frequency_Hz = np.linspace(0.0, 200.0, 4001)
    floor = diagnosis_data.floor_density(noise | {"sigma": 2.0}, frequency_Hz, 1.0 / RATE_Hz)
    assert np.trapezoid(floor, frequency_Hz) == pytest.approx(variance, rel=1e-4)


def test_the_page_is_complete_and_small(made):
    _, folder, _ = made
    path = folder / "report.html"
    assert path.stat().st_size < SIZE_MAX_BYTES
    page = Page(path)
    for tag, attributes in page.elements:
        assert tag not in ("link", "img", "iframe", "object", "embed", "base"), (tag, attributes)
        assert not {"srcset", "data", "action"} & set(attributes), (tag, attributes)
        assert "src" not in attributes or tag == "script" and is_beside(path, attributes["src"]), (tag, attributes)
    assert not re.search(r"url\(|https?:(?!//www.w3.org/2000/svg)|@import|fetch\(|XMLHttpRequest", "".join(page.scripts))
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


@pytest.mark.long
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


@pytest.mark.slow
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
    assert "the lowest and the highest are drawn" in page.text
    time_s, drawn = page.curve("robot-errors", "extended")
    assert len(drawn) < 0.1 * len(long)
    assert time_s[np.nanargmax(drawn)] == pytest.approx(spike / RATE_Hz, abs=1e-6)


def test_what_makes_it_worse_has_its_number_right_of_the_names():
    one = {"round": 1, "delta_bic": 5000.0, "share_explained": 0.9, "effect": "robot.lag"}
    block = types.SimpleNamespace(told={"ranking": [one, one | {"delta_bic": -102.0, "effect": "robot.gain"}],
                                        "causes": [], "alternatives": []})
    drawn = diagnosis_page.ranking_plot(block)
    bars = drawn["data"][0]
    assert list(zip(bars["x"], bars["textposition"])) == [(0.0, "outside"), (5000.0, "auto")]
    assert "102" in bars["text"][0] and drawn["layout"]["xaxis"]["range"][0] == 0.0
