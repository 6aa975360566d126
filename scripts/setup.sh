#!/usr/bin/env bash
# Sees to it that the Debian packages and the Python environment for a task are there.
#
#   setup.sh run|python|test|target
#
# Root installs what is missing; anyone else gets the one line to run. Installs nothing, and needs no network, if
# everything is there already.
set -euo pipefail
task=${1:?usage: setup.sh run|python|test|target}
top=$(cd "$(dirname "$0")/.." && pwd)
exec {lock}<"$0"
flock "$lock" # apt-get does not wait for another one, as of `make -j`

packages=(gcc g++ make pkg-config git python3 python3-venv libeigen3-dev libsundials-dev libtomlplusplus-dev
    libcli11-dev nlohmann-json3-dev libtinyxml2-dev libxxhash-dev zlib1g-dev)
# SUNDIALS 7 of Debian 13 is built with MPI, whose headers it wants.
if grep -q '^VERSION_ID="13"' /etc/os-release; then
    packages+=(mpi-default-dev)
fi
if [ "$task" != run ]; then
    packages+=(cmake ninja-build python3-dev)
fi
if [ "$task" = test ] || [ "$task" = target ]; then
    packages+=(doctest-dev ccache clang clang-format clang-tidy libclang-rt-dev gcc-aarch64-linux-gnu g++-aarch64-linux-gnu qemu-user-static
        clangd valgrind shellcheck can-utils libgpiod-dev mount chromium zsh fish man-db groff-base)
fi
if [ "$task" = target ]; then
    packages+=(qemu-system-arm qemu-system-x86 cpio kmod xz-utils rt-tests)
fi

missing=()
for package in "${packages[@]}"; do
    status=$(dpkg-query -W -f '${Status}' "$package" 2>/dev/null || true)
    [ "$status" = "install ok installed" ] || missing+=("$package")
done
if [ ${#missing[@]} -gt 0 ]; then
    install="apt-get update && apt-get install -y --no-install-recommends ${missing[*]}"
    if [ "$(id -u)" != 0 ]; then
        echo "packages are missing; run this once, then the same command again:" >&2
        echo "  sudo sh -c '$install'" >&2
        exit 2
    fi
    echo "installing ${missing[*]}"
    apt-get update -qq
    DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
fi

if ! cmp -s "$top/scripts/requirements.txt" "$top/.venv/requirements.txt"; then
    echo "making the Python environment in .venv"
    rm -rf "$top/.venv"
    python3 -m venv "$top/.venv"
    "$top/.venv/bin/pip" install --quiet --disable-pip-version-check --no-deps -r "$top/scripts/requirements.txt"
    cp "$top/scripts/requirements.txt" "$top/.venv/requirements.txt"
fi
