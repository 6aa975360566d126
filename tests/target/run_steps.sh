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
make_lines
mkdir /tmp/programs
for program in berth-target berth-rig target_tests target_tests_gpiod2; do
    if [ -e "$PROGRAMS/$program" ]; then
        cp "$PROGRAMS/$program" /tmp/programs
    fi
done
export PATH="/tmp/programs:$PATH"

for step; do
    name=$(basename "$step" .sh)
    folder=/tmp/steps/$name
    mkdir -p "$folder"
    cd "$folder" || exit
    from=$(cut -d. -f1 /proc/uptime)
    setsid sh -eu "$step" >stdout 2>stderr &
    wait $!
    echo $? >exit_code
    kill -9 -- -$! 2>/dev/null # what the step has left running
    cp -r "$folder" /results/
    echo "$name: exit code $(cat exit_code), $(($(cut -d. -f1 /proc/uptime) - from)) s of the guest's time"
    cd /
    rm -rf "$folder"
done
