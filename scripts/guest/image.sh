#!/usr/bin/env bash
# Makes the guest: Debian's PREEMPT_RT kernel, an initramfs with CAN and GPIO tools, and the kernel's own GPIO
# simulator, which Debian does not build.
#
#   image.sh arm64|amd64
#
# Leaves kernel and initramfs.gz in build/guest/ARCH, and does nothing if they are there and newer than these scripts.
# $BERTH_GUEST_CACHE puts it elsewhere.
set -euo pipefail
arch=${1:?usage: image.sh arm64|amd64}
here=$(cd "$(dirname "$0")" && pwd)
cd "$here/../.."
# shellcheck source=scripts/guest/packages.sh
source "$here/packages.sh"

case $arch in
arm64) cross=aarch64-linux-gnu- ;;
amd64) cross='' ;;
*) echo "image.sh: no guest for architecture $arch; arm64 or amd64" >&2 && exit 2 ;;
esac

guest=$guest_cache/$arch
# dash, because the shell of busybox takes its own ip and the like before Debian's.
tools=(busybox-static dash libc6 libgcc-s1 libstdc++6 libgpiod2 gpiod can-utils rt-tests libnuma1 iproute2 libbpf1 libelf1
    libmnl0 libbsd0 libmd0 libcap2 libtirpc3 libgssapi-krb5-2 libkrb5-3 libk5crypto3 libcom-err2 libkrb5support0
    libkeyutils1 libxtables12 libselinux1 libpcre2-8-0 libdb5.3 zlib1g util-linux libcap-ng0 libsmartcols1)
modules=(can-raw can-bcm can-gw vcan kvaser_pci softdog configfs virtio_pci virtio_blk ext4 9pnet_virtio 9p)

say() { echo "guest $arch: $*" >&2; }

# The real-time kernel and the headers to build a module for it.
unpack_kernel() {
    local image headers_common
    image=$(package_depends "linux-image-rt-$arch:$arch" | grep -m1 '^linux-image-')
    release=${image#linux-image-}
    headers_common=linux-headers-${release%-rt-*}-common-rt
    version=$(cut -d. -f1,2 <<<"$release")
    say "kernel $release"
    package_trees "$guest/kernel-tree" "$image:$arch"
    package_trees "$guest/headers" "linux-headers-$release:$arch" "$headers_common" "linux-kbuild-$version:amd64"
}

# The three files of the kernel's source that make the GPIO simulator: one download serves every architecture.
gpio_sim_source() {
    local source=$guest_cache/gpio-sim-$version package
    local files=(drivers/gpio/gpio-sim.c drivers/gpio/gpiolib.h kernel/irq/irq_sim.c)
    if [ ! -e "$source/done" ]; then
        mkdir -p "$source"
        package=$(package_file "linux-source-$version")
        # tar stops reading when it has all of them; the writers before it may not mind
        (set +o pipefail
            dpkg-deb --fsys-tarfile "$package" 2>/dev/null |
                tar -xO "./usr/src/linux-source-$version.tar.xz" 2>/dev/null |
                tar -xJ -C "$source" --strip-components=1 --occurrence=1 "${files[@]/#/linux-source-$version/}")
        rm "$package"
        touch "$source/done"
    fi
    cp "${files[@]/#/$source/}" "$1"
}

# The kernel's GPIO simulator, and what takes a CAN controller off its bus.
build_modules() {
    local build=$guest/modules headers=$guest/headers/usr/src/linux-headers-$release
    mkdir -p "$build"
    gpio_sim_source "$build"
    # The module has the name of its source file, and irq_to_desc() is not exported to modules.
    mv "$build/gpio-sim.c" "$build/gpio_sim_main.c"
    sed -i 's/irq_to_desc(irqnum)/irq_data_to_desc(irq_get_irq_data(irqnum))/' "$build/irq_sim.c"
    cp "$here/can_bus_off.c" "$build/can-bus-off.c"
    printf 'obj-m := gpio-sim.o can-bus-off.o\ngpio-sim-y := gpio_sim_main.o irq_sim.o\n' >"$build/Kbuild"
    sed -i "s,include /usr/src/,include $guest/headers/usr/src/," "$headers/Makefile"
    make -s -C "$headers" M="$build" CROSS_COMPILE="$cross" CC="${cross}gcc-12" modules >"$guest/modules.log" 2>&1 ||
        { say "the guest's own modules do not build; see $guest/modules.log" && exit 1; }
}

# Only what is named, and what that depends on: everything in an initramfs costs time at every boot.
copy_modules() {
    local from=$guest/kernel-tree to=$guest/root/usr/lib/modules/$release
    mkdir -p "$to"
    /sbin/depmod -b "$from" "$release"
    /sbin/modprobe -d "$from" -S "$release" -a --show-depends "${modules[@]}" | sed -n 's/^insmod //p' | sort -u |
        xargs cp -t "$to"
    cp "$guest"/modules/{gpio-sim,can-bus-off}.ko "$from/lib/modules/$release"/modules.{builtin,builtin.modinfo,order} "$to"
    /sbin/depmod -b "$guest/root" "$release"
}

pack_initramfs() {
    local root=$guest/root
    rm -rf "${root:?}"/{var,usr/share,usr/include,usr/lib/*/gconv,usr/lib/*/engines-*}
    find "$root" -name '*.a' -delete
    mkdir -p "$root"/{proc,sys,dev,tmp,run,root,etc,src,results}
    (cd "$root" && find . | cpio -o -H newc --quiet | gzip -6) >"$guest/initramfs.gz.part"
}

# amd64: the uncompressed kernel inside of the bzImage, which QEMU starts as it is: saves seconds of decompression.
extract_kernel() {
    local image=$guest/kernel-tree/boot/vmlinuz-$release sectors offset length
    if [ "$arch" = arm64 ]; then
        cp "$image" "$guest/kernel"
        return
    fi
    sectors=$(od -An -tu1 -j 497 -N 1 "$image")
    offset=$(od -An -tu4 -j 584 -N 4 "$image")
    length=$(od -An -tu4 -j 588 -N 4 "$image")
    head -c $(((sectors + 1) * 512 + offset + length)) "$image" | tail -c $((length)) | xz -dc --single-stream \
        >"$guest/kernel"
}

current() {
    local script
    for script in "$here"/{image.sh,packages.sh,can_bus_off.c}; do
        [ "$guest/initramfs.gz" -nt "$script" ] || return 1
    done
}

exec 9>"$guest_cache/lock"
flock 9
if current; then
    exit 0
fi
say "making the guest in $guest"
rm -rf "$guest"
mkdir -p "$guest"
package_lists
unpack_kernel
build_modules
say "tools"
package_trees "$guest/root" "${tools[@]/%/:$arch}"
copy_modules
extract_kernel
pack_initramfs
rm -rf "$guest"/{kernel-tree,headers,root}
mv "$guest/initramfs.gz.part" "$guest/initramfs.gz"
say "done: $(du -ch "$guest/kernel" "$guest/initramfs.gz" | tail -1 | cut -f1) in $SECONDS s"
