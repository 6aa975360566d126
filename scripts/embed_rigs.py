"""Writes a C++ source that holds the rig files given, so that the program finds them wherever it is installed.

usage: embed_rigs.py OUTPUT RIG.toml...
"""

import sys
from pathlib import Path


def main(output, *rigs):
    lines = ['#include "hal/rig/rig_file.h"', "", "namespace berth {", ""]
    lines += ["const std::vector<shipped_rig> &shipped_rigs()", "{", "    static const std::vector<shipped_rig> rigs = {"]
    for rig in sorted(rigs, key=lambda path: (len(Path(path).stem), path)):
        lines.append(f'        {{"{Path(rig).stem}", R"toml({Path(rig).read_text()})toml"}},')
    lines += ["    };", "    return rigs;", "}", "", "} // namespace berth", ""]
    Path(output).write_text("\n".join(lines))


if __name__ == "__main__":
    main(*sys.argv[1:])
