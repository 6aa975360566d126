#!/bin/sh
# In the guest: the loop logs to a disk until somebody cuts the power. How many setpoints have come to the robot goes to
# the console all the time; the kernel counts them for a candump that listens to nothing else.
#
#   power_cut.sh PROGRAMS    PROGRAMS: folder of the programs built for the guest
export TOOLS=/src/tests/target/guest.sh
export PATH="$1:$PATH"
# shellcheck source=tests/target/guest.sh
. "$TOOLS"
make_lines
modprobe -a virtio_blk ext4
mkdir /tmp/disk
mount -t ext4 /dev/vda /tmp/disk
cd /tmp || exit
candump can2,010:7FF >/dev/null &
rig_start ess --robot can2 --sensor can3 --set run.duration_s=60
loop_start ess /tmp/disk/run.ulg --set target.cpu=0 --set run.duration_s=60
while kill -0 "$loop" 2>/dev/null; do
    awk '$1 == "can2" && $2 == "010" { print "setpoints", $6 }' /proc/net/can/rcvlist_sff | tail -n 1
    sleep 0.05
done
cat loop.stdout loop.stderr
echo "nobody cut the power"
exit 1
