#!/bin/sh
# Touch and push two materials, until the softer one has come to rest and the harder one has thrown the robot out:
# with the manipulator as one mode, then as a whole arm.
# shellcheck source=tests/target/guest.sh
. "$TOOLS"
for material in foam copper arm-foam arm-copper; do
    setting='--set run.duration_s=10'
    # shellcheck disable=SC2086 # words
    rig_start concept-$material --robot can2 --sensor can3 $setting
    # shellcheck disable=SC2086
    loop_start concept-$material $material.ulg $setting
    loop_wait
    mv loop.exit_code $material.exit_code
    mv loop.stdout $material.stdout
    rig_wait
done
