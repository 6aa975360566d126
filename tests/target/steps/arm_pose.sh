#!/bin/sh
# A whole arm whose tool's planar pose the robot shows, three axes with a dead time each, and a force sensor that is
# mounted askew: over the kernel's CAN stack, with the operator's orders as frames.
# shellcheck source=tests/target/guest.sh
. "$TOOLS"
dump_start can2 robot.candump
rig_start ess-pose --robot can2 --sensor can3
loop_start ess-pose run.ulg --jitter jitter.json
loop_wait
rig_wait
dumps_stop
