"""Every kind of page as a reader sees it, in headless Chromium: on a phone and a desk's screen, light and dark. Nothing
is wider than the screen, no text lies on another, every plot is drawn, every axis has a unit, no curve hides another."""

import html
import itertools
import json
import os
import pathlib
import re
import subprocess
import sys

import numpy as np
import pytest
from browser import Browser
from conftest import BERTH, EXIT_DONE, EXIT_INPUT, ROOT, command, one_json_object, settings
from matplotlib.image import imread
from test_report import made as made_report
from test_report import report

sys.path.insert(0, str(ROOT / "scripts"))
import page_data  # noqa: E402
import report_signals  # noqa: E402
from berth_log import read_log  # noqa: E402
from berth_map import read_map  # noqa: E402
from claims import Claim  # noqa: E402
from figures_page import build_page as build_figures  # noqa: E402
from paper_figures import Contour, Curve, Figure, Plot, Surface  # noqa: E402

CHECKS = (pathlib.Path(__file__).parent / "page_checks.js").read_text()
SCREENS = list(itertools.product((390, 1400), ("light", "dark")))
RUN_MAX_BYTES = 1e6
# A stiff object on a robot of long dead time: it fails within the first second of sixty.
FAILING = ["ess", "--robot", "abb-egm", "--set", "object.stiffness_N_per_m=200000"]


def ran(folder, *arguments):
    done = command("run", *arguments, "--out", folder)
    assert done.returncode == EXIT_DONE, done.stderr.decode()
    return next(folder.glob("*.ulg"))


@pytest.fixture(scope="module")
def failing(tmp_path_factory):
    log = ran(tmp_path_factory.mktemp("failing"), *FAILING)
    made_report(log)
    return log


@pytest.fixture(scope="module")
def arm(tmp_path_factory):
    log = ran(tmp_path_factory.mktemp("arm"), "concept-arm-copper", "--set", "run.duration_s=8")
    made_report(log)
    return log


@pytest.fixture(scope="module")
def diagnosis(tmp_path_factory):
    """The example of `make diagnose`, shortened."""
    folder = tmp_path_factory.mktemp("diagnosis")
    log = ran(folder, "ess", "--set", "robot.transfer_frequency_Hz=12", "--set", "run.duration_s=15", "--set",
              "profile.kind=multisine", "--set", "profile.amplitude_m=0.01", "--set", "profile.duration_s=10")
    assert command("diagnose", log, "--rig", "ess", "--out", folder).returncode == EXIT_DONE
    script = ROOT / "scripts" / "diagnosis_report.py"
    done = subprocess.run([sys.executable, script, folder], capture_output=True, text=True)
    assert done.returncode == EXIT_DONE, done.stderr
    return folder / "report.html"


def map_of(folder, *arguments):
    done = command("map", "ess", "--vary", "elasticity", "--json", "--out", folder, *arguments)
    return read_map(one_json_object(done.stdout)["csv"])


@pytest.fixture(scope="module")
def maps(tmp_path_factory):
    """Of eigenvalues, and in the time domain with points that a fault ended."""
    folder = tmp_path_factory.mktemp("maps")
    return [map_of(folder / "plain", "--grid", "40x30"),
            map_of(folder / "passivity", "--grid", "12x9", "--y-range", "0.01:0.15", "--set", "passivity.action=damping")]


@pytest.fixture(scope="module")
def figures(maps, tmp_path_factory):
    """A page with a panel of each kind."""
    plain, faulted = maps
    x = np.linspace(0.0, 1.0, 50)
    curves = [Curve("measured", "#D55E00", x, x**2), Curve("closed form", "#0072B2", x, x**2, "dash")]
    found = [Figure("Fig. 5", "Amplitude", "In words.", [Plot("", "frequency (Hz)", "amplitude ratio (1)", curves)]),
             Figure("Fig. 14", "Area", "In words.", [Surface(plain), Contour(plain)]),
             Figure("Fig. 14 compensated", "Area", "In words.", [Contour(faulted, "passivity", plain)] * 3)]
    path = tmp_path_factory.mktemp("figures") / "figures.html"
    claims = [Claim("1", "It is so", "Fig. 5", -0.1, "0.9 of 1", remark="With more of it, it would be.")]
    path.write_text(build_figures(found, claims, "ess", path))
    return path


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """A folder of kept runs with a report, and two of them compared: the first is stopped, the other is not."""
    folder = tmp_path_factory.mktemp("runs")

    def berth(*arguments):
        done = subprocess.run([str(word) for word in (BERTH, *arguments)], cwd=folder, capture_output=True, text=True)
        assert done.returncode == EXIT_DONE, done.stderr
        return done.stdout
    logs = [json.loads(berth("run", *rig, "--json"))["log"] for rig in (FAILING, ["ess"], ["concept-arm-copper"])]
    berth("report", logs[0])
    berth("compare", *logs[:2], "--page", "build/runs/compare.html")
    return folder / "build" / "runs"


@pytest.fixture(scope="module")
def compared(runs):
    return runs / "compare.html"


@pytest.fixture(scope="module")
def index(runs):
    return runs / "index.html"


@pytest.mark.long
@pytest.mark.parametrize("width_px", [320, 768, 1024])
def test_a_diagnosis_is_whole_on_screens_between(diagnosis, width_px, tmp_path):
    """No text is cut off, and no column of a table is hidden; the last label of an axis is not on the one before."""
    with Browser(diagnosis, tmp_path) as browser:
        browser.look(width_px, "light")
        browser.evaluate(READY)
        assert browser.evaluate(CHECKS) == []
        assert browser.evaluate("document.body.textContent.includes('inf Hz')") is False
        keys = browser.evaluate("[...document.querySelectorAll('#parameters tbody td:first-child')].map((one) => one.textContent)")
        assert len(keys) == len(set(keys)) and "robot.dead_time_ms" in keys


@pytest.fixture(params=["failing", "arm", "diagnosis", "figures", "compared", "index"])
def page(request):
    return request.getfixturevalue(request.param).with_suffix(".html")


# Ready when this has a value: the list of runs has no plot, and compares the two that are ticked.
READY = """(typeof allDrawn !== "undefined" ? allDrawn : typeof panelsDrawn !== "undefined" ? panelsDrawn
  : Promise.resolve([...document.querySelectorAll("#runs input")].slice(0, 2).forEach((box) => box.click())))
  .then(() => true)"""


@pytest.mark.long
def test_a_page_is_readable_on_every_screen(page, tmp_path):
    with Browser(page, tmp_path) as browser:
        for width_px, scheme in SCREENS:
            browser.look(width_px, scheme)
            browser.evaluate(READY)
            has_plots = page.name != "index.html"
            assert browser.evaluate(CHECKS) == ([] if has_plots else ["there is no plot"]), (width_px, scheme)
            folder = os.environ.get("BERTH_PICTURES")
            shot = (pathlib.Path(folder) if folder else tmp_path) / f"{page.parent.name}-{page.stem}-{width_px}-{scheme}.png"
            browser.picture(shot)
            corner = imread(shot)[:8, :8, :3].mean()
            assert corner > 0.95 if scheme == "light" else corner < 0.15, (width_px, scheme, corner)
        assert browser.console == []


@pytest.mark.long
def test_a_comparison_shows_what_the_command_prints(compared, runs, tmp_path):
    """The same figures with the same digits, and two lines without gaps."""
    logs = [html.unescape(found) for found in re.findall(r"<code>([^<]*\.ulg)</code>", compared.read_text())]
    done = subprocess.run([str(BERTH), "compare", *logs], cwd=runs.parents[1], capture_output=True, text=True, check=True)
    printed = dict(re.findall(r"^  (verdict|growth|frequency|peak force|in the sensor's spring)(?: \(\S+\))? +(.*)$", done.stdout, re.M))
    assert len(printed) == 5
    with Browser(compared, tmp_path) as browser:
        rows = browser.evaluate("[...document.querySelectorAll('.compared tbody tr')].map((row) => [...row.cells].map((cell) => cell.textContent))")
        browser.evaluate(READY)
        dashes = browser.evaluate("panels.flatMap((panel) => panel.plot.data.map((trace) => trace.line.dash || 'solid'))")
    assert set(dashes) == {"solid"}
    shown = {name: [re.sub(r" (N|Hz|1/s)$", "", cell).replace("\u2212", "-") for cell in two] for name, *two in rows}
    for name, values in printed.items():
        assert re.split(r" {2,}", values.strip()) == shown[name], name


@pytest.mark.long
def test_the_list_tells_runs_of_a_sweep_apart_and_filters_them(tmp_path):
    def keep(rig, *words):
        done = subprocess.run([BERTH, "run", rig, "--no-advice", "--set", "run.duration_s=1", *words], cwd=tmp_path,
                              capture_output=True, text=True)
        assert done.returncode == EXIT_DONE, done.stderr
    for mass_kg in (100, 120, 140):
        keep("ess", "--set", f"object.mass_kg={mass_kg}")
    keep("ess-50hz")
    with Browser(tmp_path / "build" / "runs" / "index.html", tmp_path) as browser:
        rows = """[...document.querySelectorAll('#runs tbody tr')].filter((row) => !row.hidden)
                  .map((row) => row.querySelector('.differs').textContent)"""
        assert sorted(browser.evaluate(rows)) == ["", *(f"object.mass_kg = {mass_kg}" for mass_kg in (100, 120, 140))]
        browser.evaluate("""(() => { const box = document.querySelector('#filter'); box.value = 'mass_kg=120';
                         box.dispatchEvent(new Event('input')); return true; })()""")
        assert browser.evaluate(rows) == [""]
        for width_px in (641, 700, 800, 900, 1020, 1100, 1101):
            browser.look(width_px, "light")
            browser.evaluate("(() => { const box = document.querySelector('#filter'); box.value = '';"
                             " box.dispatchEvent(new Event('input')); return true; })()")
            wide = browser.evaluate("[document.documentElement, document.querySelector('.wide')]"
                                    ".map((part) => part.scrollWidth - part.clientWidth)")
            assert wide == [0, 0], width_px


@pytest.mark.long
def test_two_ticked_runs_are_compared_in_their_list(index, tmp_path):
    with Browser(index, tmp_path) as browser:
        browser.look(1400, "light")
        browser.evaluate("document.querySelectorAll('#runs input').forEach((box, i) => runs[i].rig === 'ess' && box.click())")
        rows = browser.evaluate("[...document.querySelectorAll('#difference tr')].map((row) => [...row.cells].map((cell) => "
                                "cell.textContent.replaceAll('\\u200b', '')))")
        told = {key: values for key, *values in rows}
        assert told["verdict"] == ["unstable", "stable"] and told["peak force (N)"][1] == "30.37"
        assert told["object.stiffness_N_per_m"] == ["200000", "2368.71"] and told["robot.dead_time_ms"] == ["80", "17.5"]
        assert set(told) == {"", "verdict", "growth (1/s)", "peak force (N)", "object.stiffness_N_per_m",
                             "robot.dead_time_ms", "loop.rate_Hz"}
        words = browser.evaluate("document.querySelector('#difference pre').textContent").split()
        assert words[:2] == ["berth", "compare"] and all((index.parents[2] / word).exists() for word in words[2:4])


@pytest.mark.long
def test_a_third_tick_takes_the_place_of_the_first(index, tmp_path):
    with Browser(index, tmp_path) as browser:
        for width_px in (390, 1400):
            browser.look(width_px, "light")
            ticked = browser.evaluate("(() => { const boxes = [...document.querySelectorAll('#runs input')];"
                                      " boxes.forEach((box) => box.click()); return boxes.map((box) => box.checked); })()")
            assert ticked == [False, True, True]
            assert browser.evaluate("(() => { const box = document.querySelector('#difference pre');"
                                    " return box.scrollWidth - box.clientWidth; })()") <= 0


@pytest.mark.long
def test_the_checks_can_fail(failing, tmp_path):
    """Each fault that is put on a page is told."""
    faults = {"wider than the screen": "document.querySelector('h1').style.width = '2000px'",
              "lies on": "document.querySelector('h1').style.marginBottom = '-40px'",
              "is cut off": "Plotly.relayout(panels[0].plot, {'xaxis.title.text': 'time '.repeat(80) + '(s)'})",
              "has no unit": "Plotly.relayout(panels[0].plot, {'yaxis.title.text': 'position'})",
              "traces are drawn": "document.querySelector('.scatterlayer').replaceChildren()",
              "there is no plot": "document.querySelector('#panels').replaceChildren()"}
    with Browser(failing.with_suffix(".html"), tmp_path) as browser:
        for told, fault in faults.items():
            browser.look(1400, "light")
            browser.evaluate("panelsDrawn.then(() => true)")
            browser.evaluate(f"Promise.resolve({fault}).then(() => true)")
            assert any(told in one for one in browser.evaluate(CHECKS)), told


# Of each panel: its frame, and name and colour of each curve that is drawn there.
CURVES = """panels.filter((panel) => panel.curves.length).map((panel) => {
  const box = panel.plot.querySelector(".nsewdrag").getBoundingClientRect();
  return [panel.name, [box.left, box.top + scrollY, box.right, box.bottom + scrollY],
          tracesShown(panel.view).filter((trace) => trace.line).map((trace) => [trace.name, trace.line.color, trace.line.width])];
})"""


@pytest.mark.long
def test_no_curve_hides_another(failing, tmp_path):
    """Pixels of every curve's colour are on the picture, and of curves that may coincide the upper is the narrower."""
    with Browser(failing.with_suffix(".html"), tmp_path / "profile") as browser:
        browser.look(1400, "light")
        browser.evaluate("panelsDrawn.then(() => true)")
        panels = browser.evaluate(CURVES)
        browser.picture(tmp_path / "page.png")
    pixels = imread(tmp_path / "page.png")[..., :3]
    assert len(panels) >= 6
    for name, (left, top, right, bottom), curves in panels:
        inside = pixels[int(top):int(bottom), int(left):int(right)]
        widths = [width for *_, width in curves]
        assert all(below > above for below, above in zip(widths, widths[1:])), (name, widths)
        for label, colour, _ in curves:
            rgb = np.array([int(colour[i:i + 2], 16) for i in (1, 3, 5)]) / 255.0
            assert (np.abs(inside - rgb).max(axis=2) < 0.15).sum() > 40, (name, label)


def test_a_page_opens_on_what_failed(failing):
    """At 0.5 s of 60: the page shows from the start to shortly after, and tells verdict, margin, advice and delay first."""
    page, _ = made_report(failing)
    told = one_json_object(command("summary", failing, "--json").stdout)
    from_s, to_s = page.data["shown"]
    assert told["state"] == "fault" and page.data["range"][1] > 59
    assert from_s == 0.0 and 0.5 < to_s < 1.2
    places = [page.text.index(words) for words in ("Unstable", "doubles every", "Margin none", f"Advice {told['advice'][:20]}",
                                                   f"Delay budget: {told['delay_budget']['total_ms']:.4g} ms", "Time shown",
                                                   "The run in numbers")]
    assert places == sorted(places)


@pytest.fixture(scope="module")
def cycling(tmp_path_factory):
    """Grows until limits hold it, and swings on for a minute."""
    log = ran(tmp_path_factory.mktemp("cycling"), "ess", "--set", "object.mass_kg=210")
    made_report(log)
    return log


def test_a_page_of_a_cycle_opens_on_the_growth_and_a_few_periods(cycling):
    page, _ = made_report(cycling)
    from_s, to_s = page.data["shown"]
    assert from_s == 0.0 and 2.5 < to_s < 6.0
    envelope = next(panel for panel in page.data["panels"] if panel["name"] == "envelope")
    assert "a period of the cycle" in [curve["trace"]["name"] for curve in envelope["curves"]]
    told = one_json_object(command("summary", cycling, "--json").stdout)
    height_mm = float(told["because"].split("height of ")[1].split()[0])
    low, high = envelope["layout"]["yaxis"]["range"]
    assert 10**low < height_mm < 10**high
    held = report_signals.cycle(read_log(cycling), told)
    assert np.median(held.heights_mm) == pytest.approx(height_mm, rel=0.1) and held.from_s < to_s


def test_a_page_of_a_motion_that_goes_on_opens_on_as_many_swings_as_can_be_told_apart_about_the_peak_force(tmp_path):
    """A minute in which 2 Hz lie over a free swing of 0.93 Hz that dies down."""
    log = ran(tmp_path, "ess", *settings({"profile.kind": "triangle", "profile.amplitude_m": 0.002,
                                          "profile.duration_s": 0.5}))
    page, _ = made_report(log)
    from_s, to_s = page.data["shown"]
    peak_s = one_json_object(command("summary", log, "--json").stdout)["peak_force"]["measured"]["at_s"]
    swings = report_signals.SWINGS_SHOWN
    assert 0.99 * swings / 2.0 < to_s - from_s < swings / 0.93 and from_s <= peak_s <= to_s


def test_a_page_leaves_out_what_shows_nothing_and_says_so(cycling):
    page, _ = made_report(cycling)
    assert "Loop health" not in [panel["title"] for panel in page.data["panels"]]
    assert "Not drawn, as all of it is 0 throughout: Loop health." in page.text
    band = next(panel for panel in page.data["panels"] if panel["name"] == "band")
    assert "enable off" not in band["layout"]["yaxis"]["categoryarray"]
    energy = next(panel for panel in page.data["panels"] if panel["name"] == "energy")
    colours = {curve["trace"]["name"]: curve["trace"]["line"]["color"] for curve in energy["curves"]}
    assert colours["stored"] != colours["damping took"] and len(colours) >= 5


@pytest.mark.parametrize("ci95, words", [(0.2, "1.59 Hz"), (5e-6, "1.5879 Hz"), (8.0, "2 Hz"), (0.0, "1.588 Hz")])
def test_a_frequency_has_the_digits_that_the_growth_has(ci95, words):
    from report_words import frequency_words
    assert frequency_words({"frequency_Hz": 1.58789, "growth_ci95_per_s": ci95}) == words


@pytest.mark.parametrize("stable_Hz, failing_end_s, to_s", [(1.0, 3.0, 4.0), (10.0, 3.0, 3.0), (0.1, 3.0, 15.0)])
def test_two_runs_are_opened_on_what_matters_of_both(stable_Hz, failing_end_s, to_s, monkeypatch):
    import compare
    monkeypatch.setattr(compare, "part_that_matters", lambda log, summary: log)
    summaries = [{"stable": False, "frequency_Hz": None}, {"stable": True, "frequency_Hz": stable_Hz}]
    assert compare.span_shown([(0.0, failing_end_s), (0.0, 15.0)], summaries) == (0.0, to_s)


def test_a_page_of_a_stable_run_opens_on_its_motion(tmp_path):
    log = ran(tmp_path, "ess")
    page, _ = made_report(log)
    from_s, to_s = page.data["shown"]
    told = one_json_object(command("summary", log, "--json").stdout)
    halvings = np.log2(100.0)  # the motion is seen down to a hundredth
    assert from_s == 0.0 and to_s == pytest.approx(halvings * np.log(2.0) / -told["growth_per_s"], rel=0.25)
    assert f"Margin {told['margin']['sentence']}" in page.text and "at least" in told["margin"]["sentence"]
    assert "dead time margin at least 157.5 ms more until" in page.text


@pytest.mark.parametrize("rig, changes", [("ess", ()), ("concept-foam", ())])
def test_all_of_the_fit_is_seen_and_the_axis_holds_what_is_seen(tmp_path, rig, changes):
    log = ran(tmp_path, rig, *changes)
    page, _ = made_report(log)
    fit = one_json_object(command("summary", log, "--json").stdout)["envelope"]
    envelope = next(panel for panel in page.data["panels"] if panel["name"] == "envelope")
    from_s, to_s = envelope.get("range", page.data["shown"])
    assert from_s <= fit["fit_from_s"] and fit["fit_to_s"] <= to_s
    inside = [1e3 * height for time, height in zip(fit["time_s"], fit["height_m"]) if from_s <= time <= to_s]
    low, high = envelope["layout"]["yaxis"]["range"]
    assert min(inside) / 3 < 10**low < min(inside) and max(inside) < 10**high < 3 * max(inside)


@pytest.mark.parametrize("name", ["failing", "arm", "diagnosis", "compared"])
def test_a_page_is_below_a_megabyte(name, request):
    assert request.getfixturevalue(name).with_suffix(".html").stat().st_size < RUN_MAX_BYTES


def test_pages_of_the_build_folder_share_one_script(tmp_path):
    """Wherever they lie in it; of a page elsewhere the script is beside it."""
    deep = page_data.BUILD / "runs" / "ess" / "today" / "ess.html"
    assert page_data.plotly_address(deep) == f"../../../assets/{page_data.PLOTLY}"
    assert (page_data.BUILD / "assets" / page_data.PLOTLY).stat().st_size > 4e6
    assert page_data.plotly_address(tmp_path / "a.html") == f"assets/{page_data.PLOTLY}"
    script = tmp_path / "assets" / page_data.PLOTLY
    whole = script.read_bytes()
    script.write_bytes(whole[:1000])  # as a full disk leaves it
    page_data.plotly_address(tmp_path / "b.html")
    assert script.read_bytes() == whole


def test_assets_that_cannot_be_written_are_named(tmp_path):
    log = ran(tmp_path, "ess", "--set", "run.duration_s=1")
    (tmp_path / "assets").write_text("")
    done = report(log)
    assert done.returncode == EXIT_INPUT and "assets" in done.stderr and "Traceback" not in done.stderr


@pytest.mark.long
def test_a_page_without_its_script_says_what_is_missing(failing, tmp_path):
    alone = tmp_path / "alone.html"
    alone.write_text(failing.with_suffix(".html").read_text())
    with Browser(alone, tmp_path / "profile") as browser:
        text = browser.evaluate("document.body.textContent")
        assert f"The plots need the file assets/{page_data.PLOTLY}" in text and "Unstable" in text


def test_thinning_keeps_peaks_gaps_and_ends():
    seed = 11
    random = np.random.default_rng(seed)
    values = random.normal(size=100_000)
    values[random.integers(len(values), size=20)] = np.nan
    values[41_234], values[77_777] = 50.0, -60.0
    picked, stretch = page_data.extremes(values, 2400)
    assert stretch > 1 and len(picked) < 2500 and picked[0] == 0 and picked[-1] == len(values) - 1, f"seed {seed}"
    assert {41_234, 77_777} <= set(picked.tolist()) and np.isin(np.flatnonzero(np.isnan(values)), picked).all()
    for start in range(0, len(values), 10 * stretch):
        inside = picked[(picked >= start) & (picked < start + 10 * stretch)]
        part = values[start:start + 10 * stretch]
        assert np.nanmax(values[inside]) == np.nanmax(part) and np.nanmin(values[inside]) == np.nanmin(part), f"seed {seed}"
    assert page_data.extremes(values[:2400], 2400)[1] == 1


def test_levels_of_a_map_are_the_same_on_both_sides_of_zero(maps):
    for found in maps:
        levels = found.levels_per_s()
        assert levels[len(levels) // 2] == 0.0 and np.array_equal(levels, -levels[::-1]) and (np.diff(levels) > 0).all()
        reach = np.nanpercentile(np.abs(found.measured_growth_per_s()), 99)
        assert levels[-1] <= 1.3 * reach < 5 * levels[-1]
        places = found.place_on_scale(levels)
        assert np.allclose(places, np.arange(len(levels)) - len(levels) // 2)


def test_faulted_points_are_those_that_a_run_stops_at(maps):
    """The growth that `berth map` writes for them is no growth: the page hatches them."""
    plain, faulted = maps
    assert not plain.is_faulted.any() and faulted.is_faulted.any()
    assert np.isnan(faulted.measured_growth_per_s()[faulted.is_faulted]).all()
    assert not (faulted.is_faulted & faulted.is_impossible).any()


def test_a_map_is_packed_to_a_thousandth_of_a_level(maps):
    import base64

    import figures_page
    packed = figures_page.Maps()
    for found in [*maps, maps[0]]:
        one = packed.packed[packed.number(found)]
        places = np.frombuffer(base64.b64decode(one["places"]), "<i2").reshape(len(one["y"]), len(one["x"]))
        growth = figures_page.thinned_map(found.measured_growth_per_s())
        has_value = places != -2**15
        assert np.array_equal(has_value, np.isfinite(growth))
        assert np.abs(places[has_value] / 1000 - found.place_on_scale(growth[has_value])).max() < 6e-4
    assert len(packed.packed) == 2 and json.dumps(packed.packed)


def test_hatches_cover_the_gaps_that_faulted_points_leave(maps):
    """Strokes reach the neighbours on all sides, where the map begins again, and none lies where no object is possible."""
    import figures_page
    _, found = maps
    x, y = figures_page.hatched_places(found, found.is_faulted)
    rows, columns = found.x.shape
    column, row = np.interp(x, found.x[0], np.arange(columns)), np.interp(y, found.y[:, 0], np.arange(rows))
    gaps = np.argwhere(found.is_faulted)
    away = np.maximum(np.abs(row[:, None] - gaps[:, 0]), np.abs(column[:, None] - gaps[:, 1]))
    assert away.min(axis=1).max() < 1
    for gap in gaps:  # each side and each corner has a stroke, if it is on the map and possible
        for way in itertools.product((-0.6, 0.6), repeat=2):
            place = gap + way
            nearest = tuple(np.rint(place).astype(int))
            if 0 <= place[0] <= rows - 1 and 0 <= place[1] <= columns - 1 and not found.is_impossible[nearest]:
                assert (np.hypot(row - place[0], column - place[1]) < 0.3).any(), (gap, way)
    assert not found.is_impossible[np.rint(row).astype(int), np.rint(column).astype(int)].any()


@pytest.mark.parametrize("low, high", [(0.0, 0.3), (0.8, 3.2), (0.01, 0.15), (1.0, 5.7)])
def test_labels_of_a_surface_stay_away_from_the_corners(low, high):
    import figures_page
    found = figures_page.inner_ticks(low, high)
    assert len(found["tickvals"]) >= 2 and len(found["tickvals"]) == len(found["ticktext"])
    assert min(found["tickvals"]) >= low + 0.1 * (high - low) and max(found["tickvals"]) <= high - 0.1 * (high - low)


@pytest.mark.parametrize("key, title", [("object.mass_kg", "object mass (kg)"), ("robot.dead_time_ms", "robot dead time (ms)"),
                                        ("object.stiffness_N_per_m", "object stiffness (N/m)"),
                                        ("sensor.loss_probability", "sensor loss probability (1)")])
def test_axes_over_keys_have_their_unit_in_brackets(key, title):
    import berth_map
    assert berth_map.key_title(key) == title
