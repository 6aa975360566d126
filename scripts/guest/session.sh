#!/bin/sh
# In the guest, when it is ready: runs /command, whose exit code goes to the console between marks that run.py knows;
# then off.
mark=$(sed -n 's/.*berth\.mark=\([^ ]*\).*/\1/p' /proc/cmdline)
cd /src || exit
{
    echo
    echo "$mark start $(cut -d' ' -f1 /proc/uptime)"
    /bin/sh /command </dev/null
    code=$?
    sync
    umount /results
    echo
    echo "$mark exit $code $(cut -d' ' -f1 /proc/uptime)"
} >/dev/console 2>&1
/bin/busybox poweroff -f
