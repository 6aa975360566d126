"""The rule of scripts/dear_headers.py: headers that take long to compile stand in few files."""

import sys

import pytest
from conftest import ROOT

sys.path.insert(0, str(ROOT / "scripts"))
from dear_headers import problems  # noqa: E402


@pytest.mark.parametrize("path, text, lines", [
    ("sim_hal/verdict.cpp", "#include <Eigen/Core>\n", []),
    ("sim_hal/verdict.cpp", "#include <Eigen/Core>\n#include <Eigen/SVD>\n", [2]),
    ("sim_hal/verdict.h", "\n# include <toml++/toml.h>\n#include \"CLI/CLI.hpp\"\n", [2, 3]),
    ("sim_hal/verdict.h", "#include <nlohmann/json_fwd.hpp>\n", []),
    ("sim_hal/cli/options.h", "#include <CLI/CLI.hpp>\n", []),
    ("sim_hal/cli/map_report.h", "#include <CLI/CLI.hpp>\n", [1]),
    ("tests/unit/some_test.cpp", "#include <doctest/doctest.h>\n#include <unsupported/Eigen/FFT>\n", [2]),
])
def test_dear_headers_stand_where_they_may(path, text, lines):
    found = list(problems(path, text))
    assert [int(problem.split(":")[1]) for problem in found] == lines
    assert all(problem.startswith(path) and "not allowed here: " in problem for problem in found)
