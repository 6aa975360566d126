"""The documentation site: it builds without a warning, opens from files without a network, its search finds, and nothing of the
reference lacks its description."""

import itertools
import json
import re
import subprocess
import sys
import time
from pathlib import Path

import pytest
from browser import Browser
from conftest import ROOT

sys.path.insert(0, str(ROOT / "scripts"))
import docs  # noqa: E402
import docs_reference  # noqa: E402
import notebooks  # noqa: E402

SITE = ROOT / "build" / "docs"
BUILD_MAX_s = 60.0
PAGE_MAX_BYTES = 1e6
SEARCH_MAX_s = 60.0
SCREENS = list(itertools.product((390, 1400), ("light", "dark")))
# Search for a word, the page that comes first, and another one that is found.
FOUND = {"dead time": ("glossary", "explanation/the-loop"), "UR10e": ("tutorials/docking-stability", "how-to/describe-my-robot"),
         "bus-off": ("glossary", "code/hal-linux"), "coefficient of restitution": ("glossary", "explanation/compensation")}


@pytest.fixture(scope="module")
def site():
    """Path of the first page; the time that its build took is held against its aim."""
    notebooks.renew()
    begin_s = time.monotonic()
    done = subprocess.run([sys.executable, ROOT / "scripts" / "docs.py"], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    assert time.monotonic() - begin_s < BUILD_MAX_s
    return SITE / "index.html"


@pytest.fixture
def browser(site, tmp_path):
    with Browser(site, tmp_path) as opened:
        yield opened


def show_in(browser, scheme):
    browser.ask("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])


def open_page(browser, page):
    browser.events.clear()
    browser.ask("Page.navigate", url=page.as_uri())
    browser.wait_for("Page.loadEventFired")


@pytest.mark.long
@pytest.mark.parametrize("width, scheme", SCREENS)
def test_pages_fit_their_window_and_need_no_network(browser, width, scheme):
    pages = sorted(page for page in SITE.rglob("*.html") if page.name != "404.html")
    assert len(pages) > 50
    browser.ask("Emulation.setDeviceMetricsOverride", width=width, height=1000, deviceScaleFactor=1, mobile=False)
    show_in(browser, scheme)
    for page in pages:
        open_page(browser, page)
        assert page.stat().st_size < PAGE_MAX_BYTES, page
        content, window = browser.evaluate("[document.documentElement.scrollWidth, window.innerWidth]")
        assert content <= window, f"{page} is {content} px wide in a window of {width}"
        cut = browser.evaluate("[...document.images].filter(i => i.getBoundingClientRect().right > innerWidth).map(i => i.src)")
        assert cut == [], f"{page}: pictures are wider than a window of {width}"
        text = page.read_text()
        assert not re.search(r'<(?:script|link|img)[^>]*(?:src|href)="?(?:https?:)?//', text), page
        broken = browser.evaluate("[...document.images].filter(i => i.complete && !i.naturalWidth).map(i => i.src)")
        assert broken == [], page
    assert browser.console == []


# Of each kind of text on a page: the least contrast with what is behind it, by the formula of WCAG 2.
CONTRASTS = """(() => {
  const parsed = (colour) => (colour.match(/[\\d.]+/g) || []).map(Number);
  const over = (below, [r, g, b, a = 1]) => [r, g, b].map((value, i) => a * value + (1 - a) * below[i]);
  const behind = (element) => {
    const layers = [];
    for (let one = element; one; one = one.parentElement) layers.unshift(parsed(getComputedStyle(one).backgroundColor));
    return layers.reduce(over, [255, 255, 255]);
  };
  const light = (rgb) => rgb.map((value) => value / 255)
    .map((value) => value <= 0.03928 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4)
    .reduce((sum, value, i) => sum + value * [0.2126, 0.7152, 0.0722][i], 0);
  const contrast = (element) => {
    const ground = behind(element);
    const [a, b] = [light(over(ground, parsed(getComputedStyle(element).color))), light(ground)].sort((x, y) => y - x);
    return (a + 0.05) / (b + 0.05);
  };
  const kinds = ["article h1", "article h2", "article p", "article p a", "article td", "article th", "article td code",
                 "article li", "article pre code", "article pre code span", ".md-nav__link", ".md-header__topic"];
  return Object.fromEntries(kinds.map((kind) => [kind, [...document.querySelectorAll(kind)]
    .filter((one) => one.checkVisibility() && one.textContent.trim() && !one.matches(".headerlink, .md-nav__link--passed"))
    .map(contrast)]).filter(([, found]) => found.length).map(([kind, found]) => [kind, Math.min(...found)]));
})()"""
CONTRAST_MIN = 4.5


@pytest.mark.long
@pytest.mark.parametrize("width, scheme", SCREENS)
def test_text_can_be_read_in_both_schemes(browser, width, scheme):
    browser.ask("Emulation.setDeviceMetricsOverride", width=width, height=1000, deviceScaleFactor=1, mobile=False)
    show_in(browser, scheme)
    kinds = set()
    for name in ("tutorials/docking-stability", "tutorials/hybrid-testing", "reference/cli", "explanation/stability"):
        open_page(browser, SITE / f"{name}.html")
        found = browser.evaluate(CONTRASTS)
        assert {kind: contrast for kind, contrast in found.items() if contrast < CONTRAST_MIN} == {}, name
        kinds |= set(found)
    assert len(kinds) >= 10
    browser.evaluate("document.querySelector('article p').style.color = '#777'")
    assert browser.evaluate(CONTRASTS)["article p"] < CONTRAST_MIN


@pytest.mark.long
def test_a_page_follows_the_system_until_its_reader_chooses(browser):
    for scheme, name in (("light", "default"), ("dark", "slate"), ("light", "default")):
        show_in(browser, scheme)
        assert browser.evaluate(f"""new Promise((done) => {{
          const look = (left) => document.body.dataset.mdColorScheme === "{name}" || left === 0 ? done(left) : setTimeout(look, 50, left - 1);
          look(200);
        }})""") > 0, f"the page has not become {scheme}"
        open_page(browser, SITE / "glossary.html")
        assert browser.evaluate("document.body.dataset.mdColorScheme") == name


@pytest.mark.long
@pytest.mark.parametrize("words", FOUND)
def test_search_finds(browser, words):
    browser.evaluate("document.querySelector('[data-md-component=search-query]').focus()")
    browser.ask("Input.insertText", text=words)
    deadline_s = time.monotonic() + SEARCH_MAX_s
    found = []
    while not found and time.monotonic() < deadline_s:
        found = browser.evaluate("""[...document.querySelectorAll(".md-search-result__link")]
          .map(link => link.getAttribute("href"))""")
    first, other = FOUND[words]
    assert first in found[0] and any(other in link for link in found), found
    assert browser.console == []


def test_guides_are_in_the_order_of_the_work():
    """The menu names every guide, and the list of guides has the same order."""
    _, order = docs.SECTIONS["how-to"]
    folder = docs.SOURCES / "how-to"
    assert sorted(order) == sorted(page.stem for page in folder.glob("*.md"))
    listed = re.findall(r"\]\(([\w-]+)\.md\)", (folder / "index.md").read_text())
    assert ["index", *listed] == order


@pytest.mark.parametrize("change", [
    ("the words of a cause", '"bus off" = ', '"bus on" = '),
    ("a log field", "woke_ns = ", "# woke_ns = "),
    ("a description that is empty", re.compile(r'^velocity = ".*"', re.M), 'velocity = ""'),
    ("a name that is gone", '"bus off" = ', '"wheel off" = "gone"\n"bus off" = '),
    ("a pattern of the arm", '"tool_[xyz]_m"', '"tool_[xy]_m"'),
], ids=lambda change: change[0])
def test_a_name_without_description_fails(change, tmp_path, monkeypatch):
    _, old, new = change
    text = docs_reference.DESCRIPTIONS.read_text()
    changed = re.sub(old, lambda match: new, text) if isinstance(old, re.Pattern) else text.replace(old, new)
    assert changed != text
    (tmp_path / "descriptions.toml").write_text(changed)
    monkeypatch.setattr(docs_reference, "DESCRIPTIONS", tmp_path / "descriptions.toml")
    with pytest.raises(docs_reference.Undescribed):
        docs_reference.faults()
        docs_reference.log()


def emptied(member):
    """The output of berth with one description emptied."""
    real = docs_reference.berth

    def answer(*words):
        text = real(*words)
        return text if words[-1] not in ("--json", "schema") else json.dumps(member(json.loads(text)))
    return answer


def without_physics(effects):
    effects[7]["physics"] = ""
    return effects


def without_meaning(effects):
    effects[3]["parameters"][0]["meaning"] = ""
    return effects


def without_description(schema):
    schema["properties"]["robot"]["properties"]["dead_time_ms"]["description"] = ""
    return schema


@pytest.mark.parametrize("page, member", [(docs_reference.effects, without_physics), (docs_reference.effects, without_meaning),
                                          (docs_reference.rig_keys, without_description)])
def test_an_effect_or_a_key_without_description_fails(page, member, monkeypatch):
    monkeypatch.setattr(docs_reference, "berth", emptied(member))
    with pytest.raises(docs_reference.Undescribed):
        page()


def test_a_message_without_comment_fails(tmp_path, monkeypatch):
    dbc = (ROOT / "firmware" / "can" / "berth.dbc").read_text()
    folder = tmp_path / "firmware" / "can"
    folder.mkdir(parents=True)
    (folder / "berth.dbc").write_text(re.sub(r'^CM_ BO_ 64 .*$', "", dbc, flags=re.M))
    monkeypatch.setattr(docs_reference, "ROOT", tmp_path)
    with pytest.raises(docs_reference.Undescribed, match="force"):
        docs_reference.can()


def test_a_command_without_a_line_fails(monkeypatch):
    monkeypatch.setattr(docs_reference, "berth", lambda *words: "Subcommands:\n  run    does\n  eigen                       \n")
    with pytest.raises(docs_reference.Undescribed):
        docs_reference.cli()


EXIT_CODE = re.compile(r"(?:\bexit_\w+|\bEXIT_\w+) = (\d+)|^\s*return (\d+);", re.M)
PROGRAMS = ["sim_hal/cli/*.cpp", "sim_hal/far_end/main.cpp", "firmware/main.c"]


def described_codes(page):
    """{exit code: its words} of the page's table."""
    return dict(re.findall(r"^\| (\d+)(?: \+ n)? \| *(\S.*?) *\|$", page, re.M))


def test_every_exit_code_is_described():
    page = (docs.SOURCES / "reference" / "exit-codes.md").read_text()
    manual = (ROOT / "sim_hal" / "cli" / "man_page.cpp").read_text()
    sources = [path for pattern in PROGRAMS for path in ROOT.glob(pattern)]
    codes = {code for path in sources for pair in EXIT_CODE.findall(path.read_text()) for code in pair if code}
    assert codes == set(described_codes(page)) >= {"0", "1", "2", "3", "128"}
    assert all(f".TP\\n{code}" in manual for code in codes)
    assert "3" not in described_codes(re.sub(r"^\| 3 \|.*$", "| 3 | |", page, flags=re.M))


def test_every_command_key_and_effect_is_there():
    commands = subprocess.run([docs_reference.BERTH, "--help"], capture_output=True, text=True, check=True).stdout
    pages = docs_reference.pages()
    for name in re.findall(r"^  ([a-z]+) {2,}\S", commands.split("Subcommands:")[1], re.M):
        assert f"\n## {name}\n" in pages["cli.md"], name
    for effect in json.loads(docs_reference.berth("effects", "--json")):
        assert f"## {effect['effect']}\n" in pages["effects.md"]
        for parameter in effect["parameters"]:
            section, key = parameter["key"].split(".", 1)
            assert re.search(rf"^## \[{section}\].*?^\| `{key}` ", pages["rig-keys.md"], re.M | re.S), parameter["key"]
    printed = docs_reference.berth("run", "ess-berthing-pose", "--print-config")
    for key in re.findall(r"^(\w+) = .*# (?:given|assumed)", printed, re.M):
        assert f"| `{key}` |" in pages["rig-keys.md"], key


def test_a_link_that_leads_nowhere_is_an_error():
    gathering = docs.Gathering.__new__(docs.Gathering)
    gathering.made, gathering.broken = {"faults"}, []
    source = docs.SOURCES / "glossary.md"

    def link(text):
        return gathering.link(source, docs.LINK.match(text))

    for text in ("[a](no-such-page.md)", "![a](no-such-picture.png)", "[a](explanation/the-loop.md#no-such-heading)",
                 "[a](reference/index.md#no-such-row)", "[a](reference/faults.md)"):
        link(text)
    assert len(gathering.broken) == 5 and "link to reference/index.md#faults" in gathering.broken[-1]
    assert link("[the loop](explanation/the-loop.md)") == "[the loop](explanation/the-loop.md)"
    assert link("[faults](reference/index.md#faults)") == "[faults](reference/faults.md)"
    assert link("[code](../../hal/hal.h)") == "code"
    assert len(gathering.broken) == 5


def test_links_work_where_a_page_is_read_in_the_repository():
    """Every link of every page leads to a file that is in the repository, and to a heading or an anchor in it."""
    kept = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.split()
    folders = {str(parent) for name in kept for parent in Path(name).parents}
    dead, count = [], 0
    for page in docs.readme.pages():
        for _, _, target in docs.LINK.findall(docs.FENCE.sub("", page.read_text())):
            path, _, anchor = target.partition("#")
            if re.match("[a-z]+:", path):
                continue
            count += 1
            file = (page.parent / path).resolve() if path else page
            if str(file.relative_to(ROOT)) not in folders | set(kept):
                dead.append(f"{page}: {target}")
            elif anchor and anchor not in docs.heading_anchors(file.read_text()) | set(docs.ANCHOR.findall(file.read_text())):
                dead.append(f"{page}: no heading {target}")
    assert dead == []
    assert count > 150
