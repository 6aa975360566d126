#!/bin/sh
# 60 s of the reference case with the robot as a CiA 402 drive: CANopen over the kernel's CAN stack.
# shellcheck source=tests/target/guest.sh
. "$TOOLS"
dump_start can2 robot.candump
rig_start ess-cia402 --robot can2 --sensor can3
loop_start ess-cia402 run.ulg --jitter jitter.json
loop_wait
rig_wait
dumps_stop
