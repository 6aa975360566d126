"""A Python program that a page of the guide shows, as a module."""

import importlib.util

from conftest import ROOT
from test_readme import readme


def page_program(page, name):
    """The program build/NAME.py of a how-to page."""
    readme.write_files((ROOT / "scripts" / "docs" / "how-to" / page).read_text())
    spec = importlib.util.spec_from_file_location(name, ROOT / "build" / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
