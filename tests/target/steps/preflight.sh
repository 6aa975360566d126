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
berth-target --check ess --set target.gpio_chip=rig --set target.watchdog_device=/dev/watchdog0 >check_chip || code=$?
echo $code >check_chip.exit_code
code=0
berth-target --check ess --set target.gpio_chip=gpiochip9 --set target.watchdog_device=/dev/watchdog9 \
    >check_no_chip || code=$?
echo $code >check_no_chip.exit_code

/bin/ip link set can0 down
code=0
berth-target --check ess >check_down || code=$?
echo $code >check_down.exit_code
code=0
berth-target ess --set run.duration_s=1 >down.stdout 2>down.stderr || code=$?
echo $code >down.exit_code
berth-target ess --set run.duration_s=1 >down_stopped.stdout 2>down_stopped.stderr &
waiting=$!
within 5 grep -qs 'is down: waiting' down_stopped.stderr
kill $waiting
wait $waiting
/bin/ip link set can0 up

code=0
berth-target --check ess --set target.robot_interface=can9 --set target.fault_line=NOWHERE >check_wrong || code=$?
echo $code >check_wrong.exit_code
