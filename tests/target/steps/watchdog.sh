#!/bin/sh
# The loop and the kernel's software watchdog, which fires after 2 s and is told not to reboot: fed, given back at SIGTERM
# in motion, and not fed by a loop that stands still while the thread that feeds goes on.
# shellcheck source=tests/target/guest.sh
. "$TOOLS"
rmmod softdog
modprobe softdog soft_margin=2 soft_noboot=1
setting='--set target.watchdog_device=/dev/watchdog --set target.cpu=0'

# phase NAME: what the kernel has said since the phase before.
phase() { /bin/busybox dmesg -c >"$1.kernel"; }

phase before
rig_start ess --robot can2 --sensor can3
# shellcheck disable=SC2086 # words
loop_start ess terminated.ulg --until-stopped $setting
at 6 kill -TERM "$loop"
loop_wait
mv loop.exit_code terminated.exit_code
mv loop.stdout terminated.stdout
phase fed
sleep 4
phase given_back
rig_wait

rig_start ess --robot can2 --sensor can3
# shellcheck disable=SC2086
loop_start ess --set run.duration_s=6 $setting
within 10 loop_is_running
for thread in /proc/"$loop"/task/*; do
    echo "$(basename "$thread") $(cat "$thread/comm")" >>threads
done
chrt -f -p 40 "$(sed -n 's/ watchdog$//p' threads)"
chrt -o -p 0 "$loop" # and now it can be starved
chrt -f 35 timeout 4 chrt -f 30 sha256sum /dev/zero || true
phase starved
loop_wait
mv loop.stdout starved.stdout
rig_wait

rig_start ess --robot can2 --sensor can3
# shellcheck disable=SC2086
loop_start ess --set run.duration_s=6 $setting
within 10 loop_is_running
kill -9 "$loop"
loop_wait
phase killed
sleep 4
phase after_killing
rig_wait
