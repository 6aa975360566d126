#!/usr/bin/env bash
# Makes the Debian package of the loop for a target: program, service, DBC, example rig, access to lines and real time.
#
#   target_image.sh BUILD     as build/aarch64-linux-gnu, with CROSS_COMPILE; leaves BUILD/berth_VERSION_ARCHITECTURE.deb
set -euo pipefail
cd "$(dirname "$0")/.."
build=${1:?usage: target_image.sh BUILD}
case $("${CROSS_COMPILE:-}gcc" -dumpmachine) in
aarch64-*) architecture=arm64 ;;
x86_64-*) architecture=amd64 ;;
*) echo "target_image.sh: only for arm64 and amd64" >&2 && exit 2 ;;
esac
root=$build/image
version=0~$(git log -1 --format=%cd --date=format:%Y%m%d%H%M 2>/dev/null || echo 0)+$(tr - + <"$build/commit")

rm -rf "$root"
place() { install -D -m "$1" "$2" "$root/$3"; }
place 755 "$build/berth-target" usr/bin/berth-target
"${CROSS_COMPILE:-}strip" "$root/usr/bin/berth-target"
place 644 firmware/can/berth.dbc usr/share/berth/berth.dbc
place 644 sim_hal/rigs/ess.toml etc/berth/rig.toml
place 644 scripts/image/berth.service usr/lib/systemd/system/berth.service
place 644 scripts/image/60-berth.rules usr/lib/udev/rules.d/60-berth.rules
place 644 scripts/image/can.network usr/lib/systemd/network/80-berth-can.network
place 644 scripts/image/sysctl.conf usr/lib/sysctl.d/60-berth.conf
place 644 scripts/image/sysusers.conf usr/lib/sysusers.d/berth.conf
place 644 scripts/image/limits.conf etc/security/limits.d/berth.conf
place 644 LICENSE usr/share/doc/berth/copyright
place 755 scripts/image/postinst DEBIAN/postinst
place 755 scripts/image/prerm DEBIAN/prerm

cat scripts/image/target.toml >>"$root/etc/berth/rig.toml"
printf '/etc/berth/rig.toml\n/etc/security/limits.d/berth.conf\n' >"$root/DEBIAN/conffiles"
cat >"$root/DEBIAN/control" <<CONTROL
Package: berth
Version: $version
Architecture: $architecture
Maintainer: berth
Section: science
Priority: optional
Depends: systemd, udev
Recommends: linux-image-rt-$architecture, can-utils, gpiod, rt-tests
Installed-Size: $(du -sk --exclude=DEBIAN "$root" | cut -f1)
Description: real-time hybrid simulator, the loop for a target
 Displays the motion of a simulated space manipulator with a robot and feeds the measured force back, over CAN.
CONTROL
package=$build/berth_${version}_$architecture.deb
rm -f "$build"/berth_*.deb
dpkg-deb --root-owner-group --build "$root" "$package" >/dev/null
echo "$package"
