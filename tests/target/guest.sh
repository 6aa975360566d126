# shellcheck shell=sh
# In the guest: what the steps share. To be sourced.

# A GPIO chip with the lines that a rig has, by the names that [target] gives them. Not pressed, and enabled: what
# starts a loop takes the enable away and gives it anew.
line_names='EMERGENCY_STOP ENABLE HEARTBEAT TICK FAULT'
sim=/sys/kernel/config/gpio-sim/rig

make_lines() {
    mkdir -p $sim/bank
    echo 5 >$sim/bank/num_lines
    echo rig >$sim/bank/label
    number=0
    for name in $line_names; do
        mkdir $sim/bank/line$number
        echo "$name" >$sim/bank/line$number/name
        number=$((number + 1))
    done
    echo 1 >$sim/live
    pull EMERGENCY_STOP up
    pull ENABLE up
}

line_folder() {
    number=0
    for name in $line_names; do
        [ "$name" != "$1" ] || break
        number=$((number + 1))
    done
    echo "/sys/devices/platform/$(cat $sim/dev_name)/$(cat $sim/bank/chip_name)/sim_gpio$number"
}

# pull LINE up|down: the input's level, from outside.
pull() { echo "pull-$2" >"$(line_folder "$1")/pull"; }

# level LINE: what the line shows outside.
level() { cat "$(line_folder "$1")/value"; }

# within SECONDS COMMAND...: tries it until it is well.
within() {
    tries=$(($1 * 10))
    shift
    until "$@"; do
        tries=$((tries - 1))
        [ $tries -gt 0 ] || { echo "in vain: $*" >&2 && return 1; }
        sleep 0.1
    done
}

# dump_start BUS FILE: everything on the bus, from here on. dumps_stop: until here.
dumps=''
dump_start() {
    chrt -f 30 candump -L "$1" >"$2" &
    dumps="$dumps $!"
    within 10 is_heard "$1"
}

is_heard() { grep -q "^ *$1 " /proc/net/can/rcvlist_all; }

# shellcheck disable=SC2086 # words
dumps_stop() {
    kill $dumps
    wait $dumps || true
    dumps=''
}

# load_start, load_stop: at normal priority, one that only computes, one that writes, one that forks.
load_start() {
    sha256sum /dev/zero &
    load=$!
    (while :; do
        dd if=/dev/zero of=load.bin bs=64k count=16 2>/dev/null
        sleep 0.05
    done) &
    load="$load $!"
    (while :; do
        usleep 5000
    done) &
    load="$load $!"
}

load_stop() {
    # shellcheck disable=SC2086 # three words
    kill $load
}

# loop_start ARGUMENTS...: the loop, and 'at' counts from here. loop_wait: its exit code is the step's, by loop_code.
loop_start() {
    pull ENABLE down
    berth-target "$@" >loop.stdout 2>loop.stderr &
    loop=$!
    began_cs=$(uptime_cs)
    give_enable &
}

# As a person does: an enable that is on before the loop's first tick does not count.
give_enable() {
    within 10 heart_beats && pull ENABLE up
}

# It rises, which it does in the first tick, and not while the program starts. Looked at again after another time each
# time: at even times it may stand alike at each.
heart_beats() {
    before=1
    for look in $(seq 20); do
        now=$(level HEARTBEAT)
        [ "$before$now" != 01 ] || return 0
        before=$now
        usleep $((look * 370))
    done
    return 1
}

loop_wait() {
    loop_code=0
    wait "$loop" || loop_code=$?
    echo "$loop_code" >loop.exit_code
}

# By the status that the loop sends: its first byte is the state, 2 is running.
loop_is_running() { candump -L -n 1 -T 100 can2,011:7FF | grep -q '011#02'; }

# The simulated rig on the other ends of the buses; it ends with the loop.
rig_start() {
    rm -f rig.stdout
    berth-rig "$@" >rig.stdout 2>>rig.stderr &
    rig=$!
    within 10 grep -qs 'waits for a loop' rig.stdout
}

rig_wait() {
    kill "$rig" 2>/dev/null || true
    wait "$rig" # ends well, or the step does not
}

uptime_cs() { sed 's/^\([0-9]*\)\.\([0-9]*\) .*/\1\2/' /proc/uptime; }

# at SECONDS COMMAND...: so long after the loop's start. What its fault line shows just before is written down.
at() {
    left_cs=$(($(echo "$1" | awk '{ printf "%d", 100 * $1 }') + began_cs - $(uptime_cs)))
    [ $left_cs -le 0 ] || sleep "$((left_cs / 100)).$(printf '%02d' $((left_cs % 100)))"
    shift
    echo "at $(uptime_cs): $*, fault line $(level FAULT)" >>events
    "$@"
}
