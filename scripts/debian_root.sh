#!/usr/bin/env bash
# The README's commands in a clean root of another Debian release: set-up, build, run and quick tests of what is
# committed. Needs root.
#
#   debian_root.sh SUITE [COMMAND]     as debian_root.sh trixie; COMMAND replaces `make run && make quick-test`
# shellcheck disable=SC2016 # what stands in single quotes is for other programs
set -euo pipefail
cd "$(dirname "$0")/.."
suite=${1:?usage: debian_root.sh SUITE [COMMAND]}
command=${2:-make run && make quick-test}
[ "$(id -u)" = 0 ] || {
    echo "debian_root.sh: a root of its own needs the rights of root; run it with sudo" >&2
    exit 2
}
command -v mmdebstrap >/dev/null || DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends mmdebstrap >/dev/null
root=$PWD/build/debian/$suite
if [ ! -e "$root/made" ]; then
    rm -rf "$root"
    mkdir -p "$root"
    # From where this machine has its own packages.
    source=$(apt-get indextargets --format '$(REPO_URI) $(ORIGIN)' 'Created-By: Packages' | sed -n 's/ Debian$//p' | head -1)
    mmdebstrap --quiet --mode=unshare --variant=apt "$suite" "$root" "deb $source $suite main" ||
        mmdebstrap --quiet --mode=root --variant=apt "$suite" "$root" "deb $source $suite main"
    touch "$root/made"
fi
cp /etc/resolv.conf "$root/etc/resolv.conf"
for settings in /etc/pip.conf /etc/apt/apt.conf.d/*proxy*; do
    [ ! -e "$settings" ] || install -D "$settings" "$root$settings"
done
# Beside the place where the root's own set-up writes those of its package.
certificates=/etc/ssl/certs/ca-certificates.crt
[ ! -e "$certificates" ] || install -D "$certificates" "$root/etc/ssl/certificates-of-the-host.crt"
rm -rf "$root/berth"
git clone --quiet . "$root/berth"
export root command
# Mounts of its own, which end with it.
unshare --mount bash -ec '
    mount --bind /dev "$root/dev"
    mount -t proc proc "$root/proc"
    mount -t sysfs sysfs "$root/sys"
    chroot "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 PIP_CERT=/etc/ssl/certificates-of-the-host.crt \
        bash -ec "apt-get update -qq; apt-get install -y -qq --no-install-recommends make git >/dev/null; cd /berth; $command"'
