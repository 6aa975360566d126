"""The notebooks of the guide run to their end, and show what they speak of."""

import sys

import pytest
from conftest import ROOT

sys.path.insert(0, str(ROOT / "scripts"))
import notebooks  # noqa: E402

# Words that the outputs hold, in this order, and pictures.
SHOWN = {
    "my-rig": (["stable", "object.mass_kg", "limit cycle", "stable"], 2),
    "map-and-campaign": (["P(stable) = 0.", "robot.dead_time_ms", "berth eigen ess --set"], 2),
    "diagnose-a-record": (["named", "robot.transfer", "hidden were 12"], 1),
    "open-a-log": (["Log of ess", "fields: ", "largest force", "stable"], 2),
}


def outputs_of(book):
    """(all text of the outputs, number of pictures)"""
    text, pictures = [], 0
    for cell in book.cells:
        for output in cell.get("outputs", []):
            data = output.get("data", {})
            text += [output.get("text", ""), data.get("text/html", data.get("text/plain", ""))]
            pictures += "image/png" in data
    return "\n".join(text), pictures


def test_every_notebook_is_tested():
    assert {source.stem for source in notebooks.sources()} == set(SHOWN)


@pytest.mark.long
@pytest.mark.parametrize("name", SHOWN)
def test_a_notebook_runs_and_shows(name, tmp_path):
    book = notebooks.executed(notebooks.SOURCES / f"{name}.ipynb")
    text, pictures = outputs_of(book)
    words, expected = SHOWN[name]
    at = 0
    for word in words:
        assert word in text[at:], (word, text[at:])
        at = text.index(word, at)
    assert pictures == expected
    notebooks.write_page(book, name, tmp_path)
    page = (tmp_path / f"{name}.md").read_text()
    assert page.startswith("# ") and page.count("![png](") == expected == len(list(tmp_path.glob("*.png")))
