#!/bin/sh
# Each layout of a force sensor over the kernel's CAN stack, at a rate that is not the loop's, with candump beside it. In
# the midst of each run a foreign frame with the sensor's identifier, and with a value that no frame of its own has: the
# sample that it falls into is torn. Without a number it is a second frame, which does not change the force.
# shellcheck source=tests/target/guest.sh
. "$TOOLS"
run_with() {
    name=$1 rate_Hz=$2 foreign=$3
    setting="--set sensor_channel.layout=$name --set sensor.rate_Hz=$rate_Hz"
    dump_start can3 "$name.candump"
    # shellcheck disable=SC2086 # words
    rig_start ess --robot can2 --sensor can3 $setting
    # shellcheck disable=SC2086
    loop_start ess "$name.ulg" --set run.duration_s=3 $setting
    at 1.6 cansend can3 "$foreign"
    loop_wait
    mv loop.exit_code "$name.exit_code"
    mv loop.stdout "$name.stdout"
    rig_wait
    dumps_stop
}
run_with two_frames_intel 1000 051#0100000000003412
run_with two_frames_motorola 250 053#0001000000000034
run_with three_frames_intel 333 055#0000000100000034
run_with three_frames_motorola 1000 058#0000010000000004
run_with two_frames_unnumbered 333 01B#8001800080001234
run_with two_frames_unnumbered_split 1000 002#0100000000001234
