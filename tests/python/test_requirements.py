"""The Python packages that we pin can be installed where the README says that berth runs."""

import importlib.metadata

import pytest
from conftest import ROOT
from packaging.requirements import Requirement
from packaging.specifiers import SpecifierSet

PINNED = [Requirement(line) for line in (ROOT / "scripts" / "requirements.txt").read_text().splitlines()
          if line and not line.startswith("#")]


@pytest.mark.parametrize("python", ["3.11.2", "3.13.5"])  # of Debian 12 and 13
def test_every_package_takes_the_python_of_debian(python):
    wanted = {pin.name: importlib.metadata.metadata(pin.name)["Requires-Python"] for pin in PINNED
              if pin.marker is None or pin.marker.evaluate()}
    assert len(wanted) > 50
    refused = {name: versions for name, versions in wanted.items() if versions and python not in SpecifierSet(versions)}
    assert refused == {}
