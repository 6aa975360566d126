#!/bin/sh
# CLOSED_LOOP_s (60 s) of the reference case over the kernel's CAN stack, under load, with other people's tools beside it: candump on
# the rig's ends of the buses, and cyclictest at the loop's priority, interval and CPU, 1 ms after it: so that both meet
# the kernel's own tick, every 4 ms, equally often.
# shellcheck source=tests/target/guest.sh
. "$TOOLS"
dump_start can2 robot.candump
dump_start can3 sensor.candump
seconds=${CLOSED_LOOP_s:-60}
rig_start ess --robot can2 --sensor can3 --set run.duration_s="$seconds"
load_start
loop_start ess run.ulg --jitter jitter.json --set target.cpu=0 --set run.duration_s="$seconds"
at 1 cyclictest --quiet --mlockall --priority=80 --interval=2500 --affinity=0 --secaligned=1000 --duration=$((seconds - 4)) \
    --histogram=20000 --json=cyclictest.json >cyclictest.stdout
loop_wait
rig_wait
dumps_stop
load_stop
rm load.bin
