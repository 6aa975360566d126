"""Builds the documentation site: gathers the pages in build/docs-src, generates the reference, calls mkdocs.

usage: docs.py     (from anywhere; build/berth must be there)

Pages lie in scripts/docs/, or as README.md beside the code that they describe. Links in them go from file to file, so
that they work in the repository as well. A link to a file that is no page, such as a source file, keeps its text only; one
to a file or a heading that does not exist is an error. A generated page is no file of the repository: its link leads to
its row in reference/index.md, whose anchor is the page's name, and on the site to the page itself.
"""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import docs_reference
import notebooks
import readme
import yaml

ROOT = readme.ROOT
SOURCES = ROOT / "scripts" / "docs"
GATHERED = ROOT / "build" / "docs-src"
CONFIG = ROOT / "build" / "mkdocs.yml"

# Titles of the menu and what comes first in each; other pages follow by name.
SECTIONS = {
    "tutorials": ("Tutorials", ["index", "docking-stability", "wrong-simulation", "empty-board", "hybrid-testing"]),
    "notebooks": ("Notebooks", ["my-rig", "map-and-campaign", "diagnose-a-record", "open-a-log"]),
    "how-to": ("How-to guides", [  # in the order of the work with a rig
        "index", "start-a-rig-file", "describe-my-rig", "describe-my-robot", "describe-my-sensor", "arm-from-urdf",
        "run-and-read", "watch-a-loop-live", "keep-and-compare-runs", "read-pages", "use-from-python", "complete-commands",
        "read-a-stability-map", "run-a-campaign", "choose-a-compensation", "record-data", "cia402", "build-a-gateway",
        "build-an-operator-station", "commission", "close-a-loop-in-stages", "add-an-effect", "add-a-rig-key",
        "add-a-can-message", "add-a-robot-profile", "upgrade"]),
    "reference": ("Reference", ["index", "rig-keys", "cli"]),
    "explanation": ("Explanation", ["index", "the-loop", "one-tick", "stability"]),
    "code": ("Beside the code", ["firmware", "hal"]),
}
REFERENCE = SOURCES / "reference" / "index.md"
SINGLE = ["glossary.md", "verification.md", "changelog.md", "contributing.md"]

# How much more the search counts what it finds on a page. Titles count 1000: a word of the glossary is found there first, and
# a list of the tests last.
BOOST = {"glossary.md": 1000, "reference/oracles.md": 0.01}

ANCHOR = re.compile(r'<a id="([\w-]+)"></a>')
LINK = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\]]*\])*)\]\(([^)\s]+)\)")
FENCE = re.compile(r"^```.*?^```", re.S | re.M)


def site_name(page):
    """Where a page of the repository goes on the site; None: it is no page."""
    if page.is_relative_to(SOURCES):
        return page.relative_to(SOURCES)
    if page.name == "README.md" and page.parent != ROOT:
        return Path("code") / ("-".join(page.parent.relative_to(ROOT).parts) + ".md")
    return Path("index.md") if page == ROOT / "README.md" else None


def heading_anchors(text):
    """What the headings of a page are called in links: as on GitHub, and by the site's table of contents."""
    headings = re.findall(r"^#+ (.+)$", FENCE.sub("", text), re.M)
    return {re.sub(r"\s", "-", re.sub(r"[^\w\s-]", "", heading.lower()).strip()) for heading in headings}


def relative(target, page):
    """From one page of the site to another place of it."""
    return Path("/".join([".."] * (len(page.parts) - 1)) or ".") / target


class Gathering:
    """One build: knows which pages there are, and collects links that lead nowhere."""

    def __init__(self):
        self.reference = docs_reference.pages()
        self.made = {Path(name).stem for name in self.reference}
        self.broken = []
        for name in self.reference:
            if (SOURCES / "reference" / name).exists():
                raise SystemExit(f"{SOURCES / 'reference' / name}: a generated page has this name")

    def link(self, source, match):
        mark, text, target = match.groups()
        if re.match(r"[a-z]+:|#", target):
            return match[0]
        path, _, anchor = target.partition("#")
        file = (source.parent / path).resolve()
        here = site_name(source)
        if mark:
            if not file.is_file():
                self.broken.append(f"{source}: no picture {target}")
                return match[0]
            place = Path("pictures") / file.name
            (GATHERED / place).parent.mkdir(exist_ok=True)
            shutil.copy(file, GATHERED / place)
            picture = relative(place, here)
            return f"[![{text}]({picture})]({picture})"
        if file == REFERENCE and anchor in self.made:
            return f"[{text}]({relative(Path('reference') / f'{anchor}.md', here)})"
        if file.suffix == ".md" and file.is_file() and site_name(file):
            if anchor and anchor not in heading_anchors(file.read_text()):
                self.broken.append(f"{source}: no heading {target}")
            return f"[{text}]({relative(site_name(file), here)}{'#' + anchor if anchor else ''})"
        if not file.exists():
            is_made = file.parent == REFERENCE.parent and file.stem in self.made
            remedy = f"; it is generated: link to reference/index.md#{file.stem}" if is_made else ""
            self.broken.append(f"{source}: no file {target}{remedy}")
        return text

    def page(self, source, text):
        """Text of a page with the links of the site; code blocks stay as they are."""
        parts, at = [], 0
        for fence in FENCE.finditer(text):
            parts += [LINK.sub(lambda match: self.link(source, match), text[at:fence.start()]), fence[0]]
            at = fence.end()
        parts.append(LINK.sub(lambda match: self.link(source, match), text[at:]))
        target = GATHERED / site_name(source)
        target.parent.mkdir(parents=True, exist_ok=True)
        boost = BOOST.get(str(site_name(source)))
        head = f"---\nsearch:\n  boost: {boost}\n---\n\n" if boost else ""
        target.write_text(head + "".join(parts))

    def gather(self):
        shutil.rmtree(GATHERED, ignore_errors=True)
        shutil.copytree(SOURCES / "assets", GATHERED / "assets")
        notebooks.renew()
        shutil.copytree(notebooks.PAGES, GATHERED / "notebooks")
        for source in readme.pages():
            if site_name(source):
                self.page(source, source.read_text())
        if rowless := self.made - set(ANCHOR.findall(REFERENCE.read_text())):
            self.broken.append(f"{REFERENCE}: no row with an anchor for {sorted(rowless)}")
        for name, text in self.reference.items():
            self.page(SOURCES / "reference" / name, text)
        if self.broken:
            raise SystemExit("\n".join(self.broken))


def title(page):
    """A page's first heading."""
    return re.search(r"^# (.+)$", page.read_text(), re.M)[1].strip()


def menu():
    nav = [{"Overview": "index.md"}]
    for folder, (name, first) in SECTIONS.items():
        order = {stem: at for at, stem in enumerate(first)}
        pages = sorted((GATHERED / folder).glob("*.md"), key=lambda page: (order.get(page.stem, 99), page.stem))
        nav.append({name: [f"{folder}/{page.name}" if page.stem == "index" else {title(page): f"{folder}/{page.name}"}
                           for page in pages]})
    return nav + [{title(GATHERED / name): name} for name in SINGLE]


def main():
    gathering = Gathering()
    gathering.gather()
    config = yaml.safe_load((SOURCES / "mkdocs.yml").read_text())
    config["nav"] = menu()
    CONFIG.write_text(yaml.safe_dump(config, sort_keys=False, allow_unicode=True))
    words = [sys.executable, "-m", "mkdocs", "build", "--quiet", "--strict", "--clean", "--config-file", str(CONFIG)]
    done = subprocess.run(words, cwd=ROOT, env={"NO_MKDOCS_2_WARNING": "1", "PATH": "/usr/bin:/bin"}, check=False)
    if done.returncode != 0:
        raise SystemExit(done.returncode)
    print(f"{ROOT / 'build/docs/index.html'}: {len(list((ROOT / 'build/docs').rglob('*.html')))} pages")


if __name__ == "__main__":
    main()
