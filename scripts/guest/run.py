#!/usr/bin/env python3
"""Runs a command on a PREEMPT_RT Debian kernel with SocketCAN and simulated GPIO, in QEMU; ends with its exit code.

usage: run.py [--arch arm64|amd64] [--icount] [--systemd] [--results DIRECTORY] [--timeout SECONDS] COMMAND...
       run.py [--arch arm64|amd64] [--icount] [--systemd] --shell

In the guest the repository is read-only at /src, which is the working directory, and DIRECTORY is /results. There are
two CAN buses with an emulated SJA1000 controller at each end, can0 to can2 and can1 to can3, and two virtual ones,
vcan0 and vcan1; gpio-sim is loaded.
--icount: virtual time, one instruction a nanosecond, independent of what else this machine does.
--systemd: a small Debian boots first, with dpkg; the loop's buses, can0 and can1, are left as a board finds them.
--shell: lines typed here are run there, until exit.

Exit code: the command's, 124 timeout, 125 the guest died, 126 there is no guest.
"""

import argparse
import gzip
import os
import re
import secrets
import shlex
import shutil
import subprocess
import sys
import tempfile
import threading
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
CACHE = Path(os.environ.get("BERTH_GUEST_CACHE", ROOT / "build" / "guest")).absolute()
TIMED_OUT, GUEST_DIED, NO_GUEST = 124, 125, 126
MACHINES = {
    "arm64": (["qemu-system-aarch64", "-M", "virt,gic-version=3", "-cpu", "cortex-a72"], "ttyAMA0"),
    "amd64": (["qemu-system-x86_64", "-M", "q35", "-cpu", "max"], "ttyS0"),
}
# nokaslr: where the kernel lies at random it isolates its page tables on every arm64 processor, needed or not, and that
# is some 3 us of each tick of the loop.
# getty_auto: a login prompt would take half of what is typed in a shell.
KERNEL_OPTIONS = "panic=-1 quiet loglevel=1 nokaslr systemd.getty_auto=no"
SHELL = "stty -echo </dev/console; setsid -c sh -i </dev/console >/dev/console 2>&1\n"
CAN_CARDS = ["-object", "can-bus,id=robot", "-object", "can-bus,id=sensor"] + 2 * [
    "-device", "kvaser_pci,canbus=robot", "-device", "kvaser_pci,canbus=sensor"]


class NoGuest(Exception):
    """The guest could not be made or started."""


def make_image(arch, systemd):
    """Folder with kernel and archives of the root, made if need be."""
    for script in ["image.sh"] + ["systemd.sh"] * systemd:
        made = subprocess.run([ROOT / "scripts" / "guest" / script, arch], check=False)
        if made.returncode != 0:
            raise NoGuest(f"{script} {arch} failed")
    return CACHE / arch


def initramfs_with(image, script, systemd, folder):
    """The image's archives and, behind them, one more with init and the command: the kernel unpacks all."""
    own = ROOT / "scripts" / "guest"
    root = folder / "root"
    units = root / "etc" / "systemd" / "system"
    wanted = units / "default.target.wants" / "session.service"
    wanted.parent.mkdir(parents=True)
    for name, place in (("init", root), ("session.sh", root), ("session.service", units)):
        shutil.copy(own / name, place)
    wanted.symlink_to("../session.service")
    (root / "command").write_text(script)
    names = "".join(f"{path.relative_to(root)}\n" for path in sorted(root.rglob("*")))
    archive = subprocess.run(["cpio", "-o", "-H", "newc", "--quiet", "--owner=+0:+0"], cwd=root, input=names.encode(),
                             capture_output=True, check=True).stdout
    path = folder / "initramfs"
    debian = (image / "systemd.cpio").read_bytes() if systemd else b""
    path.write_bytes(debian + (image / "initramfs.gz").read_bytes() + gzip.compress(archive))
    return path


def qemu_command(arch, image, initramfs, results, mark, icount, disk):
    program, console = MACHINES[arch]

    def share(tag, path, *options):
        return ["-fsdev", ",".join((f"local,id={tag},path={path},security_model=none", *options)),
                "-device", f"virtio-9p-pci,fsdev={tag},mount_tag={tag}"]

    return [
        *program, "-accel", "tcg", "-smp", "1", "-m", "768", *CAN_CARDS,
        *(["-icount", "shift=0,sleep=off"] if icount else []),
        *(["-drive", f"file={disk},format=raw,if=none,id=disk", "-device", "virtio-blk-pci,drive=disk"] if disk else []),
        *share("source", ROOT, "readonly=on"), *share("results", results),
        "-display", "none", "-nodefaults", "-no-reboot", "-serial", "stdio", "-monitor", "none",
        "-kernel", str(image / "kernel"), "-initrd", str(initramfs),
        "-append", f"console={console} {KERNEL_OPTIONS} berth.mark={mark}",
    ]  # fmt: skip


def run(script, *, arch="arm64", icount=False, systemd=False, results, timeout_s=300, output=sys.stdout,
        disk=None):
    """Runs a shell script in the guest; its exit code. What it prints goes line by line to `output`; without one, the
    guest has the terminal. What `output` raises ends the guest at once, as a power cut does. `disk`: a file that is the
    guest's /dev/vda."""
    image = make_image(arch, systemd)
    results = Path(results).absolute()
    results.mkdir(parents=True, exist_ok=True)
    mark = "guest-" + secrets.token_hex(6)
    with tempfile.TemporaryDirectory(prefix="berth-guest-") as folder:
        initramfs = initramfs_with(image, script, systemd, Path(folder))
        command = qemu_command(arch, image, initramfs, results, mark, icount, disk)
        try:
            if output is None:
                return subprocess.run(command, check=False).returncode
            guest = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                     stderr=subprocess.STDOUT, text=True, errors="replace")
        except FileNotFoundError as missing:
            raise NoGuest(f"{missing.filename} is missing: scripts/setup.sh target") from missing
        return follow(guest, mark, timeout_s, output)


def follow(guest, mark, timeout_s, output):
    """Copies what the guest's command prints, until its exit code comes."""
    timed_out = threading.Event()

    def stop():
        timed_out.set()
        guest.kill()

    timer = threading.Timer(timeout_s, stop)
    timer.start()
    console, started, code = [], False, None
    try:
        for line in guest.stdout:
            line = line.replace("\r", "")
            console.append(line)
            if line.startswith(mark + " start"):
                started = True
            elif ended := re.match(re.escape(mark) + r" exit (\d+)", line):
                code = int(ended[1])
            elif started and code is None:
                output.write(line)
                output.flush()
        guest.wait()
    finally:
        timer.cancel()
        guest.kill()
    if code is not None:
        return code
    sys.stderr.writelines(["the guest's last words:\n", *console[-20:]])
    return TIMED_OUT if timed_out.is_set() else GUEST_DIED


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--arch", choices=MACHINES, default="arm64")
    parser.add_argument("--icount", action="store_true")
    parser.add_argument("--systemd", action="store_true")
    parser.add_argument("--results", type=Path, default=CACHE / "results")
    parser.add_argument("--timeout", type=float, default=300, metavar="SECONDS")
    parser.add_argument("--shell", action="store_true")
    parser.add_argument("command", nargs=argparse.REMAINDER)
    given = parser.parse_args()
    words = given.command[given.command[:1] == ["--"]:]
    if bool(words) == given.shell:
        parser.error("either COMMAND or --shell")
    script = words[0] if len(words) == 1 else shlex.join(words)
    try:
        if given.shell:
            return run(SHELL, arch=given.arch, icount=given.icount, systemd=given.systemd, results=given.results, output=None)
        return run(script + "\n", arch=given.arch, icount=given.icount, systemd=given.systemd,
                   results=given.results, timeout_s=given.timeout)
    except NoGuest as problem:
        print(f"run.py: {problem}", file=sys.stderr)
        return NO_GUEST


if __name__ == "__main__":
    sys.exit(main())
