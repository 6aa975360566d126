# shellcheck shell=sh
# In the guest: what may go wrong in a scenario, by the names that tests/scenarios uses. To be sourced.
# shellcheck source=tests/target/guest.sh
. "$TOOLS"

press_emergency_stop() { pull EMERGENCY_STOP down; } # low means pressed
release_emergency_stop() { pull EMERGENCY_STOP up; }
tap_emergency_stop() { press_emergency_stop && usleep 1000 && release_emergency_stop; }
enable_off() { pull ENABLE down; }
enable_on() { pull ENABLE up; }

interface() { /bin/ip link set "$1" "$2"; }
robot_silent() { interface can2 down; } # the rig's ends of the buses
robot_back() { interface can2 up; }
sensor_silent() { interface can3 down; }
sensor_back() { interface can3 up; }
robot_interface_down() { interface can0 down; } # the loop's ends
robot_interface_up() { interface can0 up; }
sensor_interface_down() { interface can1 down; }
sensor_interface_up() { interface can1 up; }

# No emulated controller leaves its bus by itself. On a real one a module of the guest says that it has, and the kernel
# restarts it; on a virtual bus, the error frames that the kernel makes of it.
robot_bus_off() { echo can0 >/sys/module/can_bus_off/parameters/interface; }
sensor_bus_off() { echo can1 >/sys/module/can_bus_off/parameters/interface; }
bus_off() { cansend vcan0 20000040#0000000000000000; }
error_passive() { cansend vcan0 20000004#0010000000000000; }

# The controller's receive buffer has 64 bytes: eleven frames in a row, while the sending controller's interrupt goes
# before the receiving one's.
interrupt_priority() { ps | awk -v name="[i]rq/[0-9]*-$1" '$0 ~ name { print $1 }' | xargs chrt -f -p "$2"; }
overflow_burst() {
    interrupt_priority can3 60
    chrt -f 59 cangen can3 -n 20 -g 0 -i -I 7FF -L 8
    interrupt_priority can3 50
}

# As if it came from the drive, node 1.
drive_emergency() { cansend can2 081#1023030000000000; }
drive_boot_up() { cansend can2 701#00; }

kill_rig() { kill -9 "$rig"; }
# shellcheck disable=SC2086 # words
restart_rig() { rig_start ess $ends $profile; }

# The sensor as a process of its own: what the rig sends on vcan1, brought to the sensor's bus by can-utils.
sensor_start() {
    rm -f /tmp/sensor.pipe
    mkfifo /tmp/sensor.pipe
    chrt -f 65 canplayer -t -I /tmp/sensor.pipe can3=vcan1 >/dev/null &
    sensor=$!
    chrt -f 65 candump -L vcan1 >/tmp/sensor.pipe &
    sensor="$sensor $!"
}
# shellcheck disable=SC2086 # words
kill_sensor() { kill -9 $sensor; }
restart_sensor() { sensor_start; }

# Frames that are not for the loop, as many as fit beside its own.
foreign_frames() {
    cangen can2 -g 1 -n 800 -I 7F0 -L 8 -D r &
    cangen can3 -g 1 -n 800 -I 7F1 -L 8 -D r &
}

clock_forward() { date -s "@$(($(date +%s) + 3600))"; }
clock_back() { date -s "@$(($(date +%s) - 86400))"; }

stop_process() {
    kill -STOP "$loop"
    usleep "$1"
    kill -CONT "$loop"
}
stop_process_20ms() { stop_process 20000; }
stop_process_50ms() { stop_process 50000; }
stop_process_100ms() { stop_process 100000; }

# A log goes to $log. scenario_start BUSES LOG PROFILE: "real", "virtual" or "sensor_process", "disk" or "small_disk",
# the robot channel's.
scenario_start() {
    buses='--set target.robot_interface=can0 --set target.sensor_interface=can1'
    ends='--robot can2 --sensor can3'
    if [ "$1" = virtual ]; then
        buses='--set target.robot_interface=vcan0 --set target.sensor_interface=vcan1'
        ends='--robot vcan0 --sensor vcan1'
    fi
    if [ "$1" = sensor_process ]; then
        ends='--robot can2 --sensor vcan1'
        sensor_start
    fi
    profile="--set robot_channel.profile=$3"
    log=run.ulg
    if [ "$2" = small_disk ]; then
        mkdir -p /tmp/small
        mount -t tmpfs -o size=200k small /tmp/small
        log=/tmp/small/run.ulg
    fi
    # shellcheck disable=SC2086 # words
    rig_start ess $ends $profile
    # shellcheck disable=SC2086
    loop_start ess "$log" --set run.duration_s=3 $buses $profile
}

scenario_end() {
    loop_wait
    if [ "$log" != run.ulg ]; then
        cp "$log" run.ulg
        umount /tmp/small
    fi
    rig_wait
}
