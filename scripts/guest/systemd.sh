#!/usr/bin/env bash
# Makes the root of a small Debian with systemd and dpkg, to be unpacked over the guest's own: an archive for the kernel.
#
#   systemd.sh arm64|amd64
#
# Leaves systemd.cpio in build/guest/ARCH, beside what image.sh makes, and does nothing if it is there and newer than
# these scripts. APT finds out what systemd depends on, so the database says of every package here that it is installed,
# and `dpkg --install` on it checks dependencies in earnest. Nothing of another architecture is run on this machine:
# packages are unpacked, and of their scripts' work only what a boot needs is done, here and in init.
set -euo pipefail
arch=${1:?usage: systemd.sh arm64|amd64}
here=$(cd "$(dirname "$0")" && pwd)
cd "$here/../.."
# shellcheck source=scripts/guest/packages.sh
source "$here/packages.sh"

guest=$guest_cache/$arch
archive=$guest/systemd.cpio
root=$guest/systemd-root
database=$root/var/lib/dpkg
packages=(usr-is-merged systemd-sysv udev dpkg libc-bin coreutils sed grep findutils diffutils dash base-files base-passwd kmod libpam-runtime
    login sudo util-linux)

# What APT would have done with each package: files, and the entry in dpkg's database.
install_package() {
    local file=$1 name
    dpkg-deb --fsys-tarfile "$file" | tar -x --keep-directory-symlink -C "$root"
    # shellcheck disable=SC2016 # dpkg's own variables
    name=$(dpkg-deb --show --showformat '${Package} ${Multi-Arch}' "$file")
    name=${name/% same/:$arch} # these may be there for several architectures
    name=${name%% *}
    dpkg-deb --fsys-tarfile "$file" | tar -t | sed 's,^\.,,; s,/$,,; s,^$,/.,' >"$database/info/$name.list"
    {
        dpkg-deb --field "$file"
        printf 'Status: install ok installed\n\n'
    } >>"$database/status"
}

# The scripts of base-passwd, libpam-runtime and systemd would have made these.
configure() {
    local part
    cp "$root/usr/share/base-passwd/passwd.master" "$root/etc/passwd"
    cp "$root/usr/share/base-passwd/group.master" "$root/etc/group"
    for part in account auth password session session-noninteractive; do
        printf '%s required pam_permit.so\n' "${part%%-*}" >"$root/etc/pam.d/common-$part"
    done
    echo 'root:*:19000:0:99999:7:::' >"$root/etc/shadow"
    echo '127.0.0.1 localhost guest' >"$root/etc/hosts"
    : >"$root/etc/machine-id" # systemd makes one
    ln -sfn /run "$root/var/run"
    ln -sf /usr/bin/dash "$root/usr/bin/sh"
    ln -sf /usr/lib/systemd/system/multi-user.target "$root/etc/systemd/system/default.target"
}

exec 9>"$guest_cache/lock"
flock 9
if [ "$archive" -nt "$here/systemd.sh" ] && [ "$archive" -nt "$here/packages.sh" ]; then
    exit 0
fi
echo "guest $arch: a Debian with systemd" >&2
package_lists
rm -rf "$root"
mkdir -p "$database"/{info,updates,triggers} "$root"/usr/{bin,sbin,lib,lib64}
for folder in bin sbin lib lib64; do
    ln -sfn "usr/$folder" "$root/$folder"
done
echo 1 >"$database/info/format"
package_closure "$arch" "$guest_cache/packages/$arch/systemd" "${packages[@]}"
for file in "$guest_cache/packages/$arch/systemd"/*.deb; do
    install_package "$file"
done
configure
rm -rf "$root"/usr/{share/{doc,man,locale,info},lib/udev/hwdb.d,lib/modules}
(cd "$root" && find . | cpio -o -H newc --quiet --owner=+0:+0) >"$archive.part"
rm -rf "$root"
mv "$archive.part" "$archive"
echo "guest $arch: done: $(du -h "$archive" | cut -f1) in $SECONDS s" >&2
