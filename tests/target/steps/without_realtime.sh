#!/bin/sh
# The loop without real-time scheduling under the same load: it refuses to move, and if told to move all the same, it
# wakes late.
# shellcheck source=tests/target/guest.sh
. "$TOOLS"
chmod a+rw /dev/gpiochip*
chmod a+rwx .
as_user() { setpriv --reuid=1000 --regid=1000 --clear-groups "$@"; }

rig_start ess --robot can2 --sensor can3
code=0
as_user berth-target ess refused.ulg --set run.duration_s=1 >refused.stdout 2>refused.stderr || code=$?
echo $code >refused.exit_code
rig_wait

load_start
rig_start ess --robot can2 --sensor can3
pull ENABLE down
give_enable &
code=0
as_user berth-target ess allowed.ulg --set run.duration_s=5 --without-realtime --jitter jitter.json >allowed.stdout \
    2>allowed.stderr || code=$?
echo $code >allowed.exit_code
rig_wait
load_stop
rm load.bin
