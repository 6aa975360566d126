#!/bin/sh
# What the loop's program says of this machine; as root, and as someone who may not have real-time scheduling.
# shellcheck source=tests/target/guest.sh
. "$TOOLS"
code=0
berth-target --check ess >check || code=$?
echo $code >check.exit_code

code=0
setpriv --reuid=1000 --regid=1000 --clear-groups berth-target --check ess >check_user || code=$?
echo $code >check_user.exit_code

code=0
berth-target --check ess --set target.robot_interface=can9 --set target.fault_line=NOWHERE >check_wrong || code=$?
echo $code >check_wrong.exit_code
