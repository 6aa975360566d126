#!/bin/sh
# In the guest: runs steps one after the other, each in an empty folder of its own, and hands what they leave to the
# host: /results/STEP with its files, stdout, stderr and exit_code.
#
#   run_steps.sh PROGRAMS STEP...    PROGRAMS: folder of the programs built for the guest
export PROGRAMS="$1"
export TOOLS=/src/tests/target/guest.sh
shift
# shellcheck source=tests/target/guest.sh
. "$TOOLS"

# The largest step leaves 16 MB, and its programs need some memory to run in.
step_kB=65536

# All of it is the guest's memory: what /tmp may still take of it, and what there is.
room_kB() {
    {
        df -kP /tmp | awk 'NR == 2 { print $4 }'
        awk '$1 == "MemAvailable:" { print $2 }' /proc/meminfo
    } | sort -n | head -n 1
}

# need KILOBYTES WHAT: ends everything here if there is no room for it.
need() {
    room=$(room_kB)
    [ "$room" -lt "$1" ] || return 0
    echo "run_steps.sh: no room in the guest's /tmp: $room kB left, $1 kB wanted for $2; give the guest more memory" \
        "(-m in scripts/guest/run.py) or make the programs smaller" >&2
    exit 1
}

make_lines
programs=''
for program in berth-target berth-rig target_tests target_tests_gpiod2; do
    if [ -e "$PROGRAMS/$program" ]; then
        programs="$programs $PROGRAMS/$program"
    fi
done
# shellcheck disable=SC2086 # words
programs_kB=$(du -ckL $programs | awk 'END { print $1 }')
need $((programs_kB + step_kB)) "the programs ($programs_kB kB) and a step ($step_kB kB)"
mkdir /tmp/programs
# shellcheck disable=SC2086
cp $programs /tmp/programs || exit
export PATH="/tmp/programs:$PATH"

for step; do
    name=$(basename "$step" .sh)
    folder=/tmp/steps/$name
    need $step_kB "step $name"
    mkdir -p "$folder"
    cd "$folder" || exit
    from=$(cut -d. -f1 /proc/uptime)
    setsid sh -eu "$step" >stdout 2>stderr &
    wait $!
    code=$?
    kill -9 -- -$! 2>/dev/null # what the step has left running
    if ! echo $code 2>/dev/null >exit_code; then
        echo "run_steps.sh: step $name has filled the guest's /tmp: $(du -sk . | cut -f1) kB, $(room_kB) kB left" >&2
        exit 1
    fi
    cp -r "$folder" /results/ || exit
    echo "$name: exit code $code, $(($(cut -d. -f1 /proc/uptime) - from)) s of the guest's time"
    cd /
    rm -rf "$folder"
done
