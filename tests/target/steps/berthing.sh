#!/bin/sh
# A whole arm on its satellite approaches, grips the generator 20 s later and berths it, attitude control at work.
# shellcheck source=tests/target/guest.sh
. "$TOOLS"
rig_start ess-berthing --robot can2 --sensor can3
loop_start ess-berthing run.ulg --jitter jitter.json
loop_wait
rig_wait
