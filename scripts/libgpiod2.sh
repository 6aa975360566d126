#!/usr/bin/env bash
# Builds libgpiod 2 as a static library, from the sources that come with its Python package: Debian 12 has version 1.
#
#   libgpiod2.sh DIRECTORY [CROSS_COMPILE]    leaves libgpiod.a and include/gpiod.h
set -euo pipefail
top=$(cd "$(dirname "$0")/.." && pwd)
directory=${1:?usage: libgpiod2.sh DIRECTORY [CROSS_COMPILE]}
cross=${2:-}
package=gpiod==2.5.0
mkdir -p "$directory"
cd "$directory"
if [ ! -d source ]; then
    "$top/.venv/bin/pip" download --quiet --disable-pip-version-check --no-deps --no-build-isolation \
        --no-binary gpiod "$package"
    mkdir source
    tar -xzf gpiod-*.tar.gz --strip-components=1 -C source
    ln -sfn source/include include
fi
version=$(cat source/libgpiod-version.txt)
for file in source/lib/*.c; do
    "${cross}gcc" -O2 -g -D_GNU_SOURCE "-DGPIOD_API_VERSION_STR=\"$version\"" -Isource/include -Isource/lib -c "$file" \
        -o "$(basename "$file" .c).o"
done
"${cross}ar" rcs libgpiod.a ./*.o
rm ./*.o
