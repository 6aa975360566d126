#!/usr/bin/env bash
# Unpacks Debian's libgpiod for a cross compiler; nothing is installed.
#
#   sysroot.sh DIRECTORY TRIPLET    as build/aarch64-linux-gnu/sysroot aarch64-linux-gnu
set -euo pipefail
cd "$(dirname "$0")/.."
directory=${1:?usage: sysroot.sh DIRECTORY TRIPLET}
case ${2:?usage: sysroot.sh DIRECTORY TRIPLET} in
    aarch64-linux-gnu) architecture=arm64 ;;
    x86_64-linux-gnu) architecture=amd64 ;;
    *)
        echo "sysroot.sh: $2: aarch64-linux-gnu or x86_64-linux-gnu" >&2
        exit 2
        ;;
esac
# shellcheck source=scripts/guest/packages.sh
. scripts/guest/packages.sh
package_lists
archive=$(package_file "libgpiod-dev:$architecture")
mkdir -p "$directory"
dpkg-deb -x "$archive" "$directory"
