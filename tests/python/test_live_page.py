"""The page of the live view in headless Chromium: it warns before the supervisor stops a run that diverges, it fits a phone
and a desk, light and dark, and nothing that it keeps grows without end."""

import itertools
import time

import pytest
from browser import Browser
from live_view import LiveView

# Grows by 0.6 /s from the release on; the position limit stops it after 6.4 s.
DIVERGES = ["ess", "--robot", "abb-egm", "--set", "object.stiffness_N_per_m=12000"]
WORD, LOOK = "document.getElementById('word').textContent", "document.getElementById('sign').className"
FITS = """(() => {
  const wrong = [], wide = document.documentElement.scrollWidth - innerWidth;
  if (wide > 0) wrong.push(`the page is ${wide} px wider than the screen`);
  for (const one of document.querySelectorAll("h1, h2, p, li, dt, dd, button, span"))
    if (one.scrollWidth > one.clientWidth + 1 && getComputedStyle(one).display !== "inline") wrong.push(`"${one.textContent}" is cut off`);
  const word = document.getElementById("word").getBoundingClientRect();
  if (word.height < 50 || word.right > innerWidth) wrong.push(`the verdict is ${word.height} px high`);
  for (const plot of document.querySelectorAll("canvas")) {
    const box = plot.getBoundingClientRect(), pen = plot.getContext("2d");
    if (box.width < 250 || box.height < 120) wrong.push(`${plot.id}: ${box.width} x ${box.height} px`);
    const colours = new Set(new Uint32Array(pen.getImageData(0, 0, plot.width, plot.height).data.buffer));
    if (colours.size < 20) wrong.push(`${plot.id} is empty`);
  }
  return wrong;
})()"""


def wait_until(browser, condition, seconds=60.0):
    end_s = time.monotonic() + seconds
    while not browser.evaluate(condition):
        assert time.monotonic() < end_s, (condition, browser.evaluate(WORD), browser.console)
        time.sleep(0.05)


def test_it_is_red_before_the_supervisor_stops_the_run(tmp_path):
    """The page notes each verdict with the time of its loop; the log says when the fault came."""
    from berth import read_log
    note = """(() => { window.seen = []; const tell = tellState; tellState = (now) => { tell(now);
        seen.push([now.time_s, now.state, document.getElementById('sign').className, document.getElementById('word').textContent]); }; })()"""
    with LiveView(*DIVERGES, "--out", tmp_path / "run") as view, Browser(view.url, tmp_path / "profile") as browser:
        browser.evaluate(note)
        wait_until(browser, f"{WORD} === 'stopped'")
        seen = browser.evaluate("seen")
        assert browser.console == []
    log = read_log(tmp_path / "run" / "ess.ulg")
    fault_s = log.time_s[(log["state"] == 4).argmax()]
    first_s, state, _, word = next(one for one in seen if one[2] == "bad")
    assert state == "running" and word == "growing" and first_s < fault_s - 1.0
    assert all(look == "bad" for time_s, _, look, _ in seen if time_s and time_s >= first_s)
    assert seen[-1][1:] == ["fault", "bad", "stopped"]


def test_pause_zoom_and_marks(tmp_path):
    with LiveView("ess", "--out", tmp_path / "run") as view, Browser(view.url, tmp_path / "profile") as browser:
        wait_until(browser, "state.history.length > 250")
        browser.evaluate("document.getElementById('pause').click()")
        shown = "document.getElementById('range').textContent"
        before = browser.evaluate(shown)
        count = browser.evaluate("state.history.length")
        wait_until(browser, f"state.history.length > {count} + 100")
        assert browser.evaluate(shown) == before  # the plots stand, the loop goes on
        drag = """for (const [kind, x] of [["pointerdown", 150], ["pointermove", 300], ["pointerup", 300]]) {
            const plot = document.getElementById("force"), box = plot.getBoundingClientRect();
            plot.setPointerCapture = () => {};
            plot.dispatchEvent(new PointerEvent(kind, {clientX: box.left + x, clientY: box.top + 50, pointerId: 1, bubbles: true})); }"""
        browser.evaluate(drag)
        wait_until(browser, "state.view !== null")
        near, far = browser.evaluate("state.view")
        assert 0 <= near < far and far - near < 5
        browser.evaluate("document.getElementById('out').click()")
        wider = browser.evaluate("state.view")
        assert wider[0] <= near and wider[1] >= far and wider != [near, far]
        browser.evaluate("document.getElementById('follow').click()")
        assert browser.evaluate("state.view === null && state.paused === null")
        browser.evaluate("document.getElementById('text').value = 'bumped the table'; "
                         "document.getElementById('marking').requestSubmit()")
        told = "document.getElementById('events').textContent.includes('bumped the table')"
        wait_until(browser, told)
        browser.ask("Page.reload")
        wait_until(browser, f"document.readyState === 'complete' && {told}")  # a page that comes later has it, too
        assert browser.console == []
    assert "bumped the table" in (tmp_path / "run" / "ess.events.jsonl").read_text()


@pytest.mark.parametrize("rig, word", [(["ess"], "decaying"), (DIVERGES, "growing")], ids=["good", "bad"])
def test_it_fits_every_screen(rig, word, tmp_path):
    """Pictures of each go to the test's folder."""
    with LiveView(*rig, "--out", tmp_path / "run", "--speed", "0.7") as view, Browser(view.url, tmp_path / "profile") as browser:
        wait_until(browser, f"{WORD} === '{word}'")
        browser.evaluate("document.getElementById('text').value = 'seen'; document.getElementById('marking').requestSubmit()")
        for width, scheme in itertools.product((390, 1400), ("light", "dark")):
            browser.look(width, scheme)
            wait_until(browser, "state.verdict !== null && state.history.length > 50")
            browser.evaluate("new Promise(requestAnimationFrame)")
            browser.evaluate("draw()")
            assert browser.evaluate(FITS) == []
            browser.picture(tmp_path / f"{word}-{width}-{scheme}.png")
        assert browser.console == []


def test_the_page_says_when_nothing_comes_any_more(tmp_path):
    with Browser("about:blank", tmp_path / "profile") as browser:
        with LiveView("ess", "--out", tmp_path / "run") as view:
            browser.ask("Page.navigate", url=view.url)
            wait_until(browser, "document.readyState === 'complete' && typeof state !== 'undefined' && state.verdict !== null")
        wait_until(browser, f"{WORD} === 'no data' && {LOOK} === 'unsure'")


def test_what_the_page_keeps_is_bounded(tmp_path):
    with LiveView("ess", "--out", tmp_path / "run") as view, Browser(view.url, tmp_path / "profile") as browser:
        wait_until(browser, "state.history.length > 10")
        fill = """(() => { const one = state.newest, many = [];
            for (let i = 1; i <= 150000; i++) many.push({...one, time_s: one.time_s + i / 100, sequence: one.sequence + i});
            for (let i = 0; i < many.length; i += 1000) take({samples: many.slice(i, i + 1000)});
            for (let i = 0; i < 1000; i++) take({events: [{time_s: i, text: "x"}]});
            return [state.history.length, state.events.length, document.getElementById("events").children.length]; })()"""
        assert browser.evaluate(fill) == [60000, 200, 200]


@pytest.mark.parametrize("seconds", [pytest.param(60, marks=pytest.mark.long), pytest.param(1800, marks=pytest.mark.slow)])
def test_memory_does_not_grow(seconds, tmp_path):
    """With a page and a Foxglove client that come and go. What Python keeps at first is there after a quarter."""
    import asyncio

    from live_view import FoxgloveClient

    async def watch(view):
        sizes, begin_s = [], time.monotonic()
        while time.monotonic() - begin_s < seconds:
            client = await FoxgloveClient.connect(view)
            await client.subscribe("/loop", "/verdict")
            for _ in range(200):
                await client.next()
            client.connection.close()
            sizes.append((time.monotonic() - begin_s, view.resident_bytes()))
        return sizes

    with LiveView("ess", "--set", f"run.duration_s={seconds + 60}", "--out", tmp_path / "run") as view, \
            Browser(view.url, tmp_path / "profile") as browser:
        sizes = asyncio.run(watch(view))
        assert browser.console == []
    early = [size for at_s, size in sizes if 0.25 * seconds < at_s < 0.5 * seconds]
    late = [size for at_s, size in sizes if at_s > 0.75 * seconds]
    growth_bytes = sum(late) / len(late) - sum(early) / len(early)
    print(f"{seconds} s: {sum(early) / len(early) / 1e6:.1f} MB in the second quarter, {growth_bytes / 1e6:+.2f} MB in the last")
    assert growth_bytes < 2e6
