#!/usr/bin/env bash
# Fetches Debian packages of any architecture from the machine's own package sources without installing them. The
# machine's dpkg is left alone: lists and status of its own are kept in the cache. To be sourced.
#
#   package_lists                       read the lists, once per cache
#   package_depends PACKAGE             names of the packages that PACKAGE depends on
#   package_trees DIRECTORY PACKAGE...  unpack packages on top of each other, with /bin, /sbin and /lib in /usr
#   package_closure ARCHITECTURE DIRECTORY PACKAGE...    download packages and all that they depend on
#   package_file PACKAGE[:ARCHITECTURE] download one package, of all architectures if none is told, print its path

guest_cache=${BERTH_GUEST_CACHE:-build/guest}
mkdir -p "$guest_cache"
guest_cache=$(cd "$guest_cache" && pwd)

private_apt() {
    "$@" -qq -o Dir::State="$guest_cache/apt" -o Dir::State::status="$guest_cache/apt/status" \
        -o Dir::Cache="$guest_cache/apt/cache" -o Dir::Cache::pkgcache= -o Dir::Cache::srcpkgcache= \
        -o APT::Architecture="${native:-amd64}" -o APT::Architectures::=amd64 -o APT::Architectures::=arm64 \
        -o APT::Sandbox::User=root -o Acquire::Languages=none
}

package_lists() {
    [ ! -e "$guest_cache/apt/read" ] || return 0
    mkdir -p "$guest_cache"/apt/{lists/partial,cache/archives/partial}
    : >"$guest_cache/apt/status"
    private_apt apt-get update
    touch "$guest_cache/apt/read"
}

package_depends() {
    private_apt apt-cache depends "$1" | sed -n 's/^ *Depends: \([^:]*\).*/\1/p'
}

package_closure() {
    local native=$1 directory=$2
    shift 2
    mkdir -p "$directory"
    private_apt apt-get install --yes --download-only --no-install-recommends \
        -o "Dir::Cache::archives=$directory" "$@" >&2
}

package_file() {
    local architecture=all
    [[ $1 != *:* ]] || architecture=${1##*:}
    (cd "$guest_cache/apt/cache/archives" && private_apt apt-get download "$1" >&2)
    find "$guest_cache/apt/cache/archives" -name "${1%%:*}_*_$architecture.deb" | sort -V | tail -1
}

package_trees() {
    local tree=$1 downloads file
    shift
    mkdir -p "$tree"/usr/{bin,sbin,lib,lib64}
    for folder in bin sbin lib lib64; do
        ln -sfn "usr/$folder" "$tree/$folder"
    done
    downloads=$guest_cache/packages/${tree#"$guest_cache/"}
    mkdir -p "$downloads"
    (cd "$downloads" && private_apt apt-get download "$@" >&2)
    for file in "$downloads"/*.deb; do
        dpkg-deb --fsys-tarfile "$file" | tar -x --keep-directory-symlink -C "$tree"
    done
}
