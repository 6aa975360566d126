#!/usr/bin/env bash
# Measures how late this machine wakes the loop, beside cyclictest with the same priority and interval in the same run;
# reports and asserts nothing: on a machine without a real-time kernel milliseconds are normal.
#
#   jitter.sh [SECONDS]      histograms, table and picture in build/jitter
set -euo pipefail
cd "$(dirname "$0")/.."
duration_s=${1:-30}
out=build/jitter
mkdir -p "$out"

policy=(--priority=80)
[ "$(id -u)" = 0 ] || policy=(--policy=other)
cyclictest --quiet --mlockall "${policy[@]}" --interval=2500 --affinity=0 --secaligned=1000 --duration="$duration_s" \
    --histogram=20000 --json="$out/cyclictest.json" >"$out/cyclictest.txt" &
build/berth-target ess --without-buses --without-realtime --set target.cpu=0 --set target.priority=80 \
    --set run.duration_s="$duration_s" --jitter "$out/berth.json" >"$out/berth.txt"
wait
.venv/bin/python scripts/jitter_plot.py "$out/berth.json" "$out/cyclictest.json"
