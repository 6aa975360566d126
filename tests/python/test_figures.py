"""`make figures`: a page that is complete in itself and draws every plot in a browser, a picture of each figure."""

import html
import re
import subprocess
import sys

import matplotlib.image
import numpy as np
import pytest
from browser import Browser
from conftest import EXIT_INPUT, ROOT
from test_report import Page, is_beside

pytestmark = pytest.mark.slow  # the page takes minutes
SIZE_MAX_BYTES = 1e6
OF_THE_PAPER = ["fig-04", "fig-05", "fig-06", *(f"fig-{n}" for n in range(10, 18)), "refinement"]
MAPS = OF_THE_PAPER[5:11]
PANELS = {"fig-04": 3, "fig-05": 1, "fig-06": 1, "fig-10": 3, "fig-11": 3, "refinement": 2} | dict.fromkeys(MAPS, 2)
PANELS |= {"compensated": 1, "fig-04-compensated": 3, "fig-10-compensated": 2, "fig-11-compensated": 2}
PANELS |= {f"{name}-compensated": 3 for name in MAPS}
FIGURES = OF_THE_PAPER + list(PANELS)[-10:]
SURFACES = [f"{name}-0" for name in MAPS]

# What is to be seen in each plot of the page.
PROBE = """(async () => {
  function share(image, isWanted) {
    const canvas = document.createElement("canvas");
    canvas.width = image.width;
    canvas.height = image.height;
    const context = canvas.getContext("2d", { willReadFrequently: true });
    context.drawImage(image, 0, 0);
    const rgba = context.getImageData(0, 0, canvas.width, canvas.height).data;
    let found = 0;
    for (let i = 0; i < rgba.length; i += 4) found += isWanted(rgba[i], rgba[i + 2]);
    return found / (rgba.length / 4);
  }
  const seen = {};
  for (const plot of document.querySelectorAll(".plot")) {
    const image = new Image();
    image.src = await Plotly.toImage(plot, { format: "png", width: 500, height: 400 });
    await image.decode();
    const box = plot.getBoundingClientRect();
    const count = (selector) => plot.querySelectorAll(selector).length;
    seen[plot.id] = {
      width: box.width, height: box.height, text: plot.parentElement.textContent,
      traces: plot.data.filter((trace) => !(trace.x.length === 1 && trace.x[0] === null)).length,
      red: share(image, (red, blue) => red > blue + 60), blue: share(image, (red, blue) => blue > red + 20),
      marks: count("path.js-line, path.point"), heatmaps: count(".cartesianlayer image"),
      limits: count(".cartesianlayer .contourlevel path"), canvases: count(".gl-container canvas"),
    };
  }
  return seen;
})()"""


def figures(*arguments):
    words = [sys.executable, ROOT / "scripts" / "figures.py", *map(str, arguments)]
    return subprocess.run(words, capture_output=True, text=True)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("figures")
    done = figures("--out", made)
    assert done.returncode == 0, done.stderr
    assert str(made / "figures.html") in done.stdout
    return made


@pytest.fixture(scope="module")
def in_browser(folder, tmp_path_factory):
    """What is to be seen in each plot, and the console once all are drawn, before they are looked at."""
    with Browser(folder / "figures.html", tmp_path_factory.mktemp("profile")) as browser:
        browser.evaluate("allDrawn.then(() => true)")
        console = list(browser.console)
        return browser.evaluate(PROBE), console


def test_every_plot_is_drawn_in_a_browser(in_browser):
    seen, _ = in_browser
    assert sorted(seen) == sorted(f"{name}-{i}" for name, count in PANELS.items() for i in range(count))
    for name, plot in seen.items():
        assert plot["width"] > 300 and plot["height"] > 300, (name, plot)
        if name in SURFACES:
            continue
        if name.startswith(tuple(f"{of}-compensated" for of in MAPS)):
            assert plot["heatmaps"] == 1 + ("a fault" in plot["text"]) and "without compensation" in plot["text"], (name, plot)
            continue
        assert plot["marks"] >= plot["traces"] - 2 > -2, (name, plot)


def test_every_surface_is_drawn_with_its_stable_and_its_unstable_part(in_browser):
    seen, _ = in_browser
    for name in SURFACES:
        plot = seen[name]
        assert plot["canvases"] >= 1 and "WebGL" not in plot["text"], plot
        assert plot["red"] > 0.01 and plot["blue"] > 0.003, (name, plot["red"], plot["blue"])


def test_every_flat_map_shows_both_sides_and_the_limit(in_browser):
    seen, _ = in_browser
    for name in MAPS:
        plot = seen[f"{name}-1"]
        assert plot["heatmaps"] >= 1 and plot["limits"] >= 1, (name, plot)
        assert plot["red"] > 0.05 and plot["blue"] > 0.02, (name, plot["red"], plot["blue"])
        assert "limit of stability" in plot["text"] and ("wall" in plot["text"]) == (name in MAPS[::2])


def test_the_console_stays_empty(in_browser):
    _, console = in_browser
    assert console == []


def test_an_error_on_the_page_would_be_seen(tmp_path):
    """The test above can fail."""
    page = tmp_path / "broken.html"
    page.write_text("<script>console.error('wrong'); noSuchFunction();</script>")
    with Browser(page, tmp_path / "profile") as browser:
        browser.evaluate("1")
        assert len(browser.console) == 2, browser.console
        assert browser.console[0] == "wrong" and "noSuchFunction" in browser.console[1]


def test_the_page_fetches_nothing_and_is_not_too_large(folder):
    path = folder / "figures.html"
    assert path.stat().st_size < SIZE_MAX_BYTES
    page = Page(path)
    for tag, attributes in page.elements:
        assert tag not in ("link", "img", "iframe", "object", "embed", "base", "video", "audio"), (tag, attributes)
        assert not {"srcset", "data", "action", "poster"} & set(attributes), (tag, attributes)
        assert "src" not in attributes or tag == "script" and is_beside(path, attributes["src"]), (tag, attributes)
        assert attributes.get("href", "#").startswith("#"), (tag, attributes)
    ours = "".join(page.scripts)
    assert not re.search(r"url\(|https?:(?!//www.w3.org/2000/svg)|@import|fetch\(|XMLHttpRequest|import\(", ours)


def test_each_claim_stands_under_its_figure_with_its_number(folder):
    sys.path.insert(0, str(ROOT / "scripts"))
    import claims
    from report_words import typeset
    from berth_program import Berth
    from paper_data import PaperData
    text = (folder / "figures.html").read_text(encoding="utf-8")
    sections = dict(re.findall(r'<section id="([^"]+)">(.*?)</section>', text, re.S))
    assert list(sections) == FIGURES
    found = claims.measure(PaperData(Berth(folder / "again")))
    for claim in found:
        name = re.sub(r"\bfig (\d)$", r"fig-0\1", claim.figure.lower().replace(".", "")).replace(" ", "-")
        lines = re.findall(r'<li class="(met|missed)">(.*?)</li>', sections[name], re.S)
        own = [(kind, line) for kind, line in lines if html.escape(claim.sentence) in line]
        assert len(own) == 1, claim
        kind, line = own[0]
        assert kind == ("met" if claim.met else "missed") and f"<strong>{claim.verdict.lower()}</strong>" in line
        assert html.escape(typeset(claim.measured)) in line and html.escape(claim.remark) in line
    assert sum(section.count("<li class=") for section in sections.values()) == len(found)
    assert f"{sum(claim.met for claim in found)} of {len(found)} claims are met" in text


def test_minus_is_one_sign(folder):
    page = (folder / "figures.html").read_text()
    for caption in re.findall(r'<p class="caption">(.*?)</p>', page, re.S):
        assert not re.search(r"(?<![\w.])-\d", caption), caption


def test_each_figure_has_a_picture(folder):
    assert sorted(path.stem for path in folder.glob("*.png")) == sorted(FIGURES)
    for name in FIGURES:
        pixels = matplotlib.image.imread(folder / f"{name}.png")[..., :3]
        height, width, _ = pixels.shape
        assert width >= 900 and height >= 600
        assert 0.02 < np.mean(pixels.min(axis=2) < 0.9) < 0.9, name
        margin = np.concatenate([part.ravel() for part in (pixels[:2], pixels[-2:], pixels[:, :2], pixels[:, -2:])])
        assert (margin == 1.0).all(), f"{name} is cut at its edge"
        if name in MAPS:
            assert (pixels[..., 0] > pixels[..., 2] + 0.3).mean() > 0.05
            assert (pixels[..., 2] > pixels[..., 0] + 0.05).mean() > 0.02


def test_a_missing_program_is_named(tmp_path):
    done = figures("--out", tmp_path / "out", "--berth", tmp_path / "no-such-program")
    assert done.returncode == EXIT_INPUT and "no-such-program" in done.stderr and "Traceback" not in done.stderr
    assert not list((tmp_path / "out").glob("*.html"))


def test_a_folder_that_cannot_be_written_is_named(tmp_path):
    (tmp_path / "file").write_text("")
    done = figures("--out", tmp_path / "file" / "figures")
    assert done.returncode == EXIT_INPUT and "file" in done.stderr and "Traceback" not in done.stderr
