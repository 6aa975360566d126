"""Writes a C++ source that holds the rigs, robot presets and arms given, so that the program finds them wherever it is
installed. Their folder says which they are: rigs, robots or arms.

usage: embed_rigs.py OUTPUT FILE.toml...
"""

import sys
from pathlib import Path


def function(name, files):
    """The C++ function `name` that returns the files, short names first."""
    kind = "const std::vector<shipped_file>"
    lines = [f"{kind} &{name}()", "{", f"    static {kind} files = {{"]
    for file in sorted(files, key=lambda path: (len(path.stem), path)):
        lines.append(f'        {{"{file.stem}", R"toml({file.read_text()})toml"}},')
    return lines + ["    };", "    return files;", "}", ""]


def main(output, *paths):
    files = [Path(path) for path in paths]
    lines = ['#include "hal/rig/robot_file.h"', "", "namespace berth {", ""]
    for kind in ("rigs", "robots", "arms"):
        lines += function(f"shipped_{kind}", [file for file in files if file.parent.name == kind])
    lines += ["} // namespace berth", ""]
    Path(output).write_text("\n".join(lines))


if __name__ == "__main__":
    main(*sys.argv[1:])
