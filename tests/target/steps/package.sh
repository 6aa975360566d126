#!/bin/sh
# The package on a Debian with systemd, step by step as the tutorial says: installed, checked, started, stopped, hung, installed
# again and removed while it runs. The simulated rig is at the other end of the buses.
# shellcheck source=tests/target/guest.sh
. "$TOOLS"
package=$(find "$PROGRAMS" -maxdepth 1 -name 'berth_*.deb')
log=/var/log/berth/run.ulg

is_up() { /bin/ip link show "$1" | grep -q '[<,]UP[,>]'; }
is_in_state() { [ "$(systemctl show --value --property ActiveState berth)" = "$1" ]; }
service() { systemctl show berth >"$1.unit"; }
as_its_user() { sudo -u berth "$@"; }
start_loop() {
    rig_start ess --robot can2 --sensor can3
    pull ENABLE down
    systemctl start berth
    give_enable &
}

package_files() { find /etc /usr -path '*berth*' | sort; }

# With a board's programs, and none of the guest's own.
on_board() { PATH=/usr/sbin:/usr/bin "$@"; }

/bin/ip link set can0 txqueuelen 1000 # as somebody may have left it
on_board dpkg --install "$package" >install 2>&1
udevadm settle
on_board dpkg --verify berth >verify
id berth >user
stat -c '%n %G %a' /dev/gpiochip* /dev/cpu_dma_latency /dev/watchdog* >access
cat /sys/class/net/can0/tx_queue_len >queue
cat /proc/sys/kernel/sched_rt_runtime_us >throttling
systemd-analyze verify berth.service >unit_verify 2>&1
systemd-analyze security --no-pager berth.service >exposure 2>&1

systemctl enable --now systemd-networkd
for bus in can0 can1; do
    within 10 is_up $bus
done
/bin/ip -details -json link >links.json
code=0
/usr/lib/systemd/systemd-networkd-wait-online --timeout=10 >online 2>&1 || code=$?
echo $code >online.exit_code
code=0
as_its_user berth-target --check /etc/berth/rig.toml >check 2>&1 || code=$?
echo $code >check.exit_code

start_loop
service running
process=$(systemctl show --value --property MainPID berth)
cat "/proc/$process/status" >status
cat "/proc/$process/limits" >limits
cat /proc/"$process"/task/*/stat >threads
within 10 loop_is_running
sleep 4 # twice WatchdogSec
level FAULT >fault_level
systemctl stop berth
service stopped
journalctl --unit berth --output cat >stopped.journal
cp $log stopped.ulg
stat -c '%U %G %a' $log >log_mode
rig_wait

/bin/ip link set can0 down # as at boot, where the loop may be there before the bus
(sleep 1 && /bin/ip link set can0 up) &
start_loop
within 10 loop_is_running
systemctl stop berth
cp $log early.ulg
rig_wait

start_loop
within 10 loop_is_running
kill -STOP "$(systemctl show --value --property MainPID berth)"
within 30 is_in_state failed
service hung
systemctl reset-failed berth
rig_wait

echo '# my own rig' >>/etc/berth/rig.toml
start_loop
within 10 loop_is_running
on_board dpkg --install "$package" >reinstall 2>&1
service reinstalled
cp $log reinstalled.ulg
tail -n 1 /etc/berth/rig.toml >reinstalled.rig
rig_wait

systemctl enable berth 2>enabled
start_loop
within 10 loop_is_running
on_board dpkg --remove berth >remove 2>&1
service removed
cp $log removed.ulg
package_files >removed.files
on_board dpkg --purge berth >purge 2>&1
package_files >purged.files
ls /var/log/berth >logs
rig_wait
