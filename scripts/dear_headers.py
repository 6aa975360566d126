#!/usr/bin/env python3
"""Which files may include the headers that take a second or more to compile.

    dear_headers.py FILE...

Prints a line for each include that is not allowed, with what to do instead; exits with 1 if there is one.
"""
import re
import sys
from fnmatch import fnmatch
from pathlib import Path

DECOMPOSITIONS = "decompose matrices through sim_hal/solver/decompositions.h and factors.h, which are compiled once"
# Of each header: where it may stand, and what other files do.
RULES = {
    "CLI/*": (["sim_hal/cli/options.h", "sim_hal/cli/usage_error.*", "sim_hal/cli/main.cpp", "sim_hal/cli/command_table.cpp",
               "sim_hal/cli/completion_command.cpp", "sim_hal/far_end/main.cpp",
               "hal/linux/options.cpp"],
              "declare options in sim_hal/cli/options.h, define them in options.cpp"),
    "nlohmann/json.hpp": (["sim_hal/cli/*", "sim_hal/arm/arm_at_states.cpp", "sim_hal/arm/urdf_model.cpp",
                           "sim_hal/hil/wake_histogram.cpp", "hal/linux/loop_timing.cpp",
                           "hal/rig/commissioning_file.cpp",  # the record, which target and host write
                           "tests/linux/loop_timing_test.cpp", "tests/linux/live_sender_test.cpp"],
                          "hand over structures, and let sim_hal/cli write the JSON; in headers use json_fwd.hpp"),
    "toml++/*": (["hal/rig/toml_file.h", "tests/scenarios/scenario_test.cpp"],
                 "read TOML in hal/rig, through toml_file.h"),
    "doctest/*": (["tests/*"], "doctest is for tests"),
    "Eigen/Geometry": (["firmware/arm/vectors.h", "sim_hal/arm/urdf*.cpp", "tests/*"],
                       "turn vectors through firmware/arm/vectors.h"),
    "Eigen/Cholesky": (["firmware/arm/factors.cpp", "sim_hal/solver/factors.cpp"], DECOMPOSITIONS),
    "Eigen/LU": (["sim_hal/solver/factors.cpp"], DECOMPOSITIONS),
    "Eigen/QR": (["sim_hal/solver/decompositions.cpp"], DECOMPOSITIONS),
    "Eigen/Eigenvalues": (["sim_hal/solver/decompositions.cpp"], DECOMPOSITIONS),
    "Eigen/SVD": (["sim_hal/solver/decompositions.cpp"], DECOMPOSITIONS),
    "Eigen/Dense": (["hal/rig/wrench.cpp"], "include Eigen/Core; " + DECOMPOSITIONS),
    "unsupported/Eigen/FFT": (["sim_hal/diagnosis/noise/fourier.cpp"], "call sim_hal/diagnosis/noise/fourier.h"),
    "unsupported/Eigen/MatrixFunctions": (["sim_hal/solver/exponential.cpp"], "call sim_hal/solver/exponential.h"),
}
INCLUDE = re.compile(r"^\s*#\s*include\s*[<\"]([^>\"]+)[>\"]", re.MULTILINE)


def problems(path, text):
    """A line for each include of a file that is not allowed there."""
    for include in INCLUDE.finditer(text):
        for header, (places, instead) in RULES.items():
            if fnmatch(include[1], header) and not any(fnmatch(path, place) for place in places):
                line = text.count("\n", 0, include.start(1)) + 1
                yield f"{path}:{line}: <{include[1]}> takes long to compile and is not allowed here: {instead}"


def main():
    found = [problem for path in sys.argv[1:] for problem in problems(path, Path(path).read_text())]
    print("\n".join(found), end="\n" if found else "")
    sys.exit(bool(found))


if __name__ == "__main__":
    main()
