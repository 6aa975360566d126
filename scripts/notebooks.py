"""Executes the notebooks of the guide and writes each as a page of the site, with its pictures.

usage: notebooks.py     (the Python package must be there: make python)

scripts/docs/notebooks/NAME.ipynb -> build/notebooks/NAME.md and NAME_*.png. One that is newer than its notebook stays.
"""
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SOURCES = ROOT / "scripts" / "docs" / "notebooks"
PAGES = ROOT / "build" / "notebooks"
TIMEOUT_s = 600


def sources():
    return sorted(SOURCES.glob("*.ipynb"))


def executed(source):
    """The notebook with its outputs. Raises nbclient's CellExecutionError where a cell fails."""
    import nbformat
    from nbclient import NotebookClient
    from traitlets.config import Config
    book = nbformat.read(source, as_version=4)
    NotebookClient(book, timeout=TIMEOUT_s, kernel_name="python3", config=Config({"KernelManager": {"transport": "ipc"}}),
                   resources={"metadata": {"path": str(ROOT)}}).execute()
    return book


def write_page(book, name, folder=PAGES):
    from nbconvert import MarkdownExporter
    text, resources = MarkdownExporter().from_notebook_node(book, {"unique_key": name, "output_files_dir": "."})
    folder.mkdir(parents=True, exist_ok=True)
    for picture, data in resources["outputs"].items():
        (folder / picture).write_bytes(data)
    (folder / f"{name}.md").write_text(text.replace("](./", "]("), encoding="utf-8")


def renew():
    """Every page that is older than its notebook, or missing."""
    for source in sources():
        page = PAGES / f"{source.stem}.md"
        if not page.exists() or page.stat().st_mtime < source.stat().st_mtime:
            write_page(executed(source), source.stem)


if __name__ == "__main__":
    renew()
