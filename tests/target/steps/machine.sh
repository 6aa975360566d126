#!/bin/sh
# The machine itself, with other people's tools: kernel, buses, lines, and how late it wakes a thread when idle.
# shellcheck source=tests/target/guest.sh
. "$TOOLS"
uname -a >kernel
cat /sys/kernel/realtime >realtime
/bin/ip -details -json link >links.json

for pair in can0:can2 can2:can0 can1:can3 can3:can1; do
    candump -L -n 20 -T 2000 "${pair#*:}" >"$pair.candump" &
    receiver=$!
    within 10 is_heard "${pair#*:}"
    cangen "${pair%:*}" -n 20 -g 1 -I 123 -L 8 -D i
    wait $receiver
done

gpioinfo >lines
is_taken() { gpioinfo | grep -q "\"$1\" *\"$2\""; }
gpiomon --num-events=4 "$(gpiofind EMERGENCY_STOP | cut -d' ' -f1)" 0 >edges &
monitor=$!
within 10 is_taken EMERGENCY_STOP gpiomon
for direction in down up down up; do
    pull EMERGENCY_STOP $direction
    sleep 0.01
done
wait $monitor
for value in 1 0 1; do
    # shellcheck disable=SC2046 # chip and offset
    gpioset --mode=signal $(gpiofind FAULT)=$value &
    holder=$!
    within 10 is_taken FAULT gpioset
    level FAULT >>fault_levels
    kill $holder
    wait $holder
done
cyclictest --quiet --mlockall --priority=80 --interval=2500 --duration=3 --histogram=1000 --json=cyclictest.json
