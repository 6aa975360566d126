#!/bin/sh
# The package for a board, unpacked: its program and its example rig.
# shellcheck source=tests/target/guest.sh
. "$TOOLS"
dpkg-deb -x "$(find "$PROGRAMS" -maxdepth 1 -name 'berth_*.deb')" .
code=0
usr/bin/berth-target --check etc/berth/rig.toml >check || code=$?
echo $code >check.exit_code
