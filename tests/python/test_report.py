"""The report of a run: made for every kind of log, complete in itself, telling what `berth summary` tells."""
import base64
import json
import re
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from browser import Browser
from conftest import without_checksums
from plotly.offline import get_plotlyjs
from test_summary import BERTH, CASES, run, summary

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
import report_figure  # noqa: E402
from berth_log import read_log, read_summary  # noqa: E402
from report_page import height_ticks  # noqa: E402
from report_words import four_digits, typeset  # noqa: E402

SIZE_MAX_BYTES = 1e6
CASES = CASES | {"concept-foam": ("concept-foam", []), "force interface": ("ess", ["operator.interface=force",
                                                                                  "run.duration_s=10"])}
VERDICTS = {"concept-copper": "Unstable", "never released": "Undetermined", "one tick": "Undetermined"}


def report(*arguments):
    words = [sys.executable, ROOT / "scripts" / "report.py", *arguments]
    return subprocess.run(list(map(str, words)), capture_output=True, text=True)


class Page(HTMLParser):
    """Text and elements of a page, and what stands in its scripts and styles."""

    def __init__(self, path):
        super().__init__()
        self.elements, self.words, self.scripts, self.inside = [], [], [], ""
        self.feed(path.read_text(encoding="utf-8"))
        self.text = " ".join(" ".join(self.words).split())

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))
        self.inside = tag
        if tag in ("script", "style"):
            self.scripts.append("")

    def handle_endtag(self, tag):
        self.inside = ""

    def handle_data(self, data):
        if self.inside in ("script", "style"):
            self.scripts[-1] += data
        else:
            self.words.append(data)

    @property
    def data(self):
        """What the page's script draws."""
        return json.loads(next(text for text in self.scripts if text.startswith('{"clocks"')))

    def curve(self, panel_name, curve_name):
        """Times and values of one curve, as the page holds them."""
        panel = next(panel for panel in self.data["panels"] if panel["name"] == panel_name)
        curve = next(curve for curve in panel["curves"] if curve["trace"]["name"] == curve_name)
        clock = self.data["clocks"][curve["clock"]]
        values = np.frombuffer(base64.b64decode(curve["samples"]), "<f4")
        if "samples" in clock:
            return np.frombuffer(base64.b64decode(clock["samples"]), "<f8"), values
        steps = np.frombuffer(base64.b64decode(clock["deltas"]), f"<{clock['kind']}").astype(np.int64)
        return clock["start"] + clock["step"] * np.cumsum(steps), values


def png_size(path):
    content = path.read_bytes()
    assert content.startswith(b"\x89PNG\r\n\x1a\n")
    return int.from_bytes(content[16:20], "big"), int.from_bytes(content[20:24], "big")


def made(log):
    done = report(log)
    assert done.returncode == 0, done.stderr
    page, picture = log.with_suffix(".html"), log.with_suffix(".png")
    assert str(page) in done.stdout and str(picture) in done.stdout
    assert not list(log.parent.glob("*.partial"))
    return Page(page), picture


@pytest.mark.long
@pytest.mark.parametrize("description", ["short", "a long description of the rig " * 20])
def test_the_head_of_the_picture_stays_within_it(tmp_path, monkeypatch, description):
    """Facts of a run in which limits act fill more than a line; a long description does so, too."""
    path, _ = run(tmp_path, "ess", ["object.mass_kg=210", "run.duration_s=20", "limits.velocity_m_per_s=0.05"])
    log, told = read_log(path), read_summary(path, BERTH)
    log.config["description"] = description
    drawn = []
    monkeypatch.setattr(report_figure.plt, "close", drawn.append)
    report_figure.build_figure(log, told)
    figure = drawn[0]
    boxes = [text.get_window_extent() for text in figure.texts]
    assert all(box.x0 >= 0 and box.x1 <= report_figure.RIGHT * figure.bbox.width + 10 for box in boxes)
    lowest = min(box.y0 for box in boxes if box.y0 > 0.5 * figure.bbox.height)
    assert all(axes.get_tightbbox().y1 < lowest for axes in figure.axes)


@pytest.mark.long
@pytest.mark.parametrize("case", CASES)
def test_report_tells_the_run(tmp_path, case):
    log, _ = run(tmp_path, *CASES[case])
    told = summary(log)
    page, picture = made(log)
    assert png_size(picture) == (1600, 1000)
    assert log.with_suffix(".html").stat().st_size < SIZE_MAX_BYTES

    assert f" {VERDICTS.get(case, 'Stable')} " in page.text
    assert typeset(told["because"][1:]) in page.text
    assert f"peak force {four_digits(told['peak_force_N'])} N" in page.text
    assert f"overruns {told['overruns']} missed" in page.text
    assert f"supervisor {told['state']}" in page.text
    frames = (told["frames_rejected"], told["frames_lost"], told["error_frames"])
    assert "{} rejected, {} lost, {} error".format(*frames) in page.text
    for name, ticks in told["limit_ticks"].items():
        assert (f"{name.replace('_', ' ')} {ticks}" in page.text) == (ticks > 0)
    if told["state"] == "fault":
        assert f"Fault: {told['stop_cause'].replace('_', ' ')}" in page.text
    assert told["config_hash"] in page.text and told["version"] in page.text
    assert f"berth replay {log}" in page.text
    assert f"dead_time_ms {40.0 if case == 'ess-50hz' else 17.5} command to motion" in page.text


@pytest.mark.long
def test_report_names_the_robot_preset(tmp_path):
    log = tmp_path / "ess.ulg"
    ran = [BERTH, "run", "ess", "--robot", "abb-egm", "--set", "run.duration_s=2", "--out", tmp_path]
    subprocess.run(list(map(str, ran)), check=True, capture_output=True)
    page, _ = made(log)
    assert ("robot preset abb-egm period 4 ms, dead time 80 ms, the upper end of the reported 40 to 80 ms growth rate"
            in page.text)

    log, _ = run(tmp_path / "own", "ess", ["run.duration_s=2"])
    assert "preset" not in made(log)[0].text


def is_beside(page, address):
    """A file that a page names by a relative path."""
    return not re.match(r"[a-z]+:|/", address) and (page.parent / address).is_file()


def test_page_fetches_nothing_but_its_script(tmp_path):
    """One script lies beside the page; no other element or style sheet names anything outside of the file; our own
    script asks for nothing."""
    log, _ = run(tmp_path, "ess", ["run.duration_s=2"])
    page, _ = made(log)
    scripts = [attributes["src"] for tag, attributes in page.elements if tag == "script" and "src" in attributes]
    assert len(scripts) == 1 and is_beside(log, scripts[0])
    for tag, attributes in page.elements:
        assert tag not in ("link", "img", "iframe", "object", "embed", "base", "video", "audio"), (tag, attributes)
        assert tag == "script" or not {"src", "href", "srcset", "data", "action", "poster"} & set(attributes), (tag, attributes)
    assert len(page.scripts) == 6  # style, plotly, data, plots, data of the arm, script
    ours = "".join(page.scripts)
    assert "url(" not in ours
    assert not re.search(r"https?:(?!//www.w3.org/2000/svg)|@import|fetch\(|XMLHttpRequest|import\(", ours)


def test_page_holds_every_sample_of_the_part_that_it_opens_on(tmp_path):
    """Of 60 s at 400 Hz: there all samples are the log's. Of the rest each that is there is the log's, and so are the
    lowest and the highest."""
    from pyulog import ULog
    log, told = run(tmp_path, "ess", ["object.stiffness_N_per_m=60000"])
    page, _ = made(log)
    tick = ULog(str(log), ["tick"]).get_dataset("tick").data
    from_s, to_s = page.data["shown"]
    assert told["ticks"] == 24000
    for panel, curve, field, scale in (("positions", "manipulator", "manipulator_position_m", 1e3),
                                       ("positions", "command", "command_position_m", 1e3),
                                       ("forces", "used by the loop", "used_force_N", 1.0)):
        time_s, values = page.curve(panel, curve)
        ticks = np.rint(time_s * 400).astype(int)
        assert np.allclose(time_s, 1e-9 * tick["scheduled_ns"][ticks], atol=1e-9)
        assert np.array_equal(values, (scale * tick[field]).astype(np.float32)[ticks])
        assert len(values) < 6000 and values.max() == np.float32((scale * tick[field]).max())
        assert values.min() == np.float32((scale * tick[field]).min())
        shown = (time_s >= from_s) & (time_s < to_s)
        assert shown.sum() == pytest.approx(400 * (to_s - from_s), abs=1) and to_s - from_s < 6


@pytest.mark.long
def test_dead_time_is_shown(tmp_path):
    for rig, dead_time_ms in (("ess", 17.5), ("ess-50hz", 40.0), ("ess-half-dead-time", 7.5)):
        log, _ = run(tmp_path, rig, ["run.duration_s=3"])
        page, _ = made(log)
        assert f"command to motion {dead_time_ms:.2f} ms" in page.text


def test_a_long_run_is_thinned_and_says_so(tmp_path):
    log, _ = run(tmp_path, "ess", ["run.duration_s=200"])
    page, _ = made(log)
    assert log.with_suffix(".html").stat().st_size < SIZE_MAX_BYTES
    assert re.search(r"The page is thinned: .*of every \d+ .*the lowest and the highest are drawn. The log holds all",
                     page.text)


def messages(content):
    """(start, end) of each ULog message after the file's header."""
    at = 16
    while at < len(content):
        end = at + 3 + int.from_bytes(content[at:at + 2], "little")
        yield at, end
        at = end


@pytest.mark.long
def test_cut_log(tmp_path):
    """A log that is cut among its records gives a report of what is there, one cut in its header a clear error."""
    log, told = run(tmp_path, "ess", ["run.duration_s=5"])
    content = without_checksums(log.read_bytes())
    log.write_bytes(content[:-1])
    page, _ = made(log)
    assert "The log is cut" in page.text and f"ticks {told['ticks'] - 1:,}".replace(",", " ") in page.text

    header_end = next(start for start, _ in messages(content) if content[start + 2:start + 3] == b"D")
    log.write_bytes(content[:header_end])
    page, picture = made(log)
    assert "No ticks" in page.text and png_size(picture) == (1600, 1000)

    for path in tmp_path.glob("ess.[hp]*"):
        path.unlink()
    for size in (0, 7, 16, 300):
        log.write_bytes(content[:size])
        done = report(log)
        assert done.returncode == 2 and str(log) in done.stderr and "Traceback" not in done.stderr, size
    assert sorted(path.suffix for path in tmp_path.glob("ess.*")) == [".log", ".log", ".ulg"]


@pytest.mark.long
def test_missing_ticks(tmp_path):
    """Records that a full disk cost: the curves have a gap, and the page says so."""
    log, _ = run(tmp_path, "ess", ["run.duration_s=5"])
    content = without_checksums(log.read_bytes())
    kept = bytearray(content[:16])
    for start, end in messages(content):
        is_data = content[start + 2:start + 3] == b"D"
        timestamp_us = int.from_bytes(content[start + 5:start + 13], "little") if is_data else 0
        if not 2_000_000 <= timestamp_us < 2_500_000:
            kept += content[start:end]
    log.write_bytes(kept)
    page, _ = made(log)
    assert "200 ticks are missing" in page.text and "command to motion 17.50 ms" in page.text
    time_s, values = page.curve("positions", "robot")
    assert np.isnan(values).sum() == 1 and 2.0 < time_s[np.isnan(values)][0] < 2.5


@pytest.mark.parametrize("make, word", [
    (lambda path: None, "cannot be read"),
    (lambda path: path.mkdir(), "cannot be read"),
    (lambda path: path.write_bytes(b"no log of any kind, whatever its name says"), "is not a ULog"),
])
def test_wrong_file_is_named(tmp_path, make, word):
    path = tmp_path / "some.ulg"
    make(path)
    done = report(path)
    assert done.returncode == 2 and done.stdout == ""
    assert str(path) in done.stderr and word in done.stderr and "Traceback" not in done.stderr
    assert not list(tmp_path.glob("*.html*"))


def test_missing_command_is_named(tmp_path):
    log, _ = run(tmp_path, "ess", ["run.duration_s=1"])
    done = report(log, "--berth", tmp_path / "no-such-program")
    assert done.returncode == 2 and "no-such-program" in done.stderr and "Traceback" not in done.stderr


@pytest.mark.long
def test_rig_text_is_escaped(tmp_path):
    """A description cannot break out of the page."""
    rig = subprocess.run([BERTH, "run", "ess", "--print-config"], capture_output=True, text=True).stdout
    evil = tmp_path / "evil.toml"
    evil.write_text(re.sub("description = .*", "description = '</script><b id=\"evil\">&amp;'", rig))
    log, _ = run(tmp_path, evil, ["run.duration_s=1"])
    page, _ = made(log)
    assert not any(attributes.get("id") == "evil" for _, attributes in page.elements)
    assert '</script><b id="evil">&amp;' in page.text


def names_of(source, pattern):
    text = (ROOT / "firmware" / source).read_text()
    return tuple(re.findall(r'"(\w+)"', re.search(pattern, text, re.DOTALL)[1]))


def test_names_are_the_firmware_s():
    """The tables of names here are copies; the firmware's are the originals."""
    sys.path.insert(0, str(ROOT / "scripts"))
    import berth_log
    assert berth_log.STATES == names_of("supervisor.c", r"state_names\[\] = \{(.*?)\};")
    assert berth_log.STOP_CAUSES == names_of("supervisor.c", r"cause_names\[\] = \{(.*?)\};")
    assert berth_log.LIMITS == names_of("limits.c", r"limit_names\[LIMIT_COUNT\] = \{(.*?)\};")


def are_of(curve, expected, rate_Hz=400):
    """The samples that a page holds of a signal are the signal's, at their ticks."""
    time_s, values = curve
    picked = expected[np.rint(time_s * rate_Hz).astype(int)]
    return len(values) > 500 and np.allclose(values, picked, rtol=1e-6, atol=1e-12)


@pytest.mark.long
def test_the_units_of_compensation_show_their_states(tmp_path):
    """Panels of what is on, with the log's own numbers, and none of what is off."""
    from pyulog import ULog
    changes = {"object.stiffness_N_per_m": 40000, "prediction.enabled": "true", "identification.enabled": "true",
               "prediction.stiffness_N_per_m": 32000, "prediction.dead_time_ms": 20, "passivity.action": "damping",
               "passivity.credit_J": 0, "adaptive_inverse.enabled": "true", "run.duration_s": 8}
    log, _ = run(tmp_path, "ess", [f"{key}={value}" for key, value in changes.items()])
    page, _ = made(log)
    tick = ULog(str(log)).get_dataset("tick").data
    for panel, curve, expected in (
            ("prediction", "measured less predicted", tick["predicted_error_N"]),
            ("identified", "stiffness, given 32000", 100 * tick["believed_stiffness_N_per_m"] / 32000),
            ("identified", "damping (right axis)", tick["believed_damping_N_s_per_m"]),
            ("tracked", "tracked", tick["believed_dead_time_ms"]),
            ("inverse", "delay", 1e3 * tick["inverse_delay_s"]),
            ("inverse", "gain (right axis)", tick["inverse_gain"]),
            ("energy", "compensation made", tick["energy_compensation_J"]),
            ("passivity", "deficit (below 0: credit that is left)", tick["passivity_deficit_J"]),
            ("passivity", "force of the controller (right axis)", tick["passivity_force_N"])):
        assert are_of(page.curve(panel, curve), expected), curve
    assert (page.curve("tracked", "given")[1] == 20).all()
    assert tick["believed_dead_time_ms"][0] == 20 and abs(tick["believed_dead_time_ms"][-1] - 17.5) < 0.5
    assert abs(tick["believed_stiffness_N_per_m"][-1] - 40000) < 1000


@pytest.mark.long
def test_the_force_lead_shows_what_its_model_does_not_know(tmp_path):
    from pyulog import ULog
    log, _ = run(tmp_path, "ess", ["force_lead.enabled=true", "run.duration_s=3"])
    page, _ = made(log)
    tick = ULog(str(log)).get_dataset("tick").data
    assert are_of(page.curve("lead", "measured less model"), tick["lead_error_N"])


@pytest.mark.long
def test_without_compensation_there_are_no_panels_of_it(tmp_path):
    log, _ = run(tmp_path, "ess", ["run.duration_s=3"])
    names = {panel["name"] for panel in made(log)[0].data["panels"]}
    assert not names & {"prediction", "identified", "tracked", "inverse", "lead", "passivity"}


def test_the_picture_of_a_flat_envelope_shows_its_points(tmp_path, monkeypatch):
    """A bouncing tool loses little: all points lie within the axis, below the legend, with labels that tell their size."""
    log, _ = run(tmp_path, "concept-foam", ["object.stiffness_N_per_m=5000", "object.damping_N_s_per_m=20",
                                            "robot.dead_time_ms=34", "run.duration_s=15"])
    found, drawn = read_summary(log, BERTH), []
    monkeypatch.setattr(report_figure.plt, "close", drawn.append)
    report_figure.build_figure(read_log(log), found)
    axes = next(one for one in drawn[0].axes if one.get_title(loc="left") == "Envelope")
    heights_mm = 1e3 * np.array(found["envelope"]["height_m"])
    low, high = axes.get_ylim()
    assert len(heights_mm) > 5 and low < heights_mm.min() and heights_mm.max() < high
    assert sum(low <= tick <= high for tick in axes.get_yticks()) >= 2
    assert axes.get_legend().get_window_extent().y0 >= axes.get_window_extent().y1 - 1
    drawn[0].clear()


@pytest.mark.long
@pytest.mark.parametrize("low, high", [(1.2, 1.5), (0.0, 1.9), (-6.0, 1.0)])
def test_an_envelope_has_labels_however_flat_it_is(tmp_path, low, high):
    """Whole powers of ten may all lie outside an axis of less than a decade."""
    axis = json.dumps({"yaxis": {"type": "log"} | height_ticks(low, high)})
    page = tmp_path / "axis.html"
    page.write_text(f'<div id="plot"></div><script>{get_plotlyjs()}</script><script>'
                    f'Plotly.newPlot("plot", [{{"y": [{10**low}, {10**high}]}}], {axis});</script>')
    with Browser(page, tmp_path / "profile") as browser:
        labels = browser.evaluate("[...document.querySelectorAll('.ytick text')].map((text) => text.textContent)")
    assert len(labels) >= 2, labels
