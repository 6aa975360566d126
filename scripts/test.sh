#!/usr/bin/env bash
# Runs the tests of a tier. Ends with the ten that took longest, the time of the whole, and one line that says how many
# passed and failed.
#
#   test.sh quick    C++ tests, and the Python tests that are neither long nor slow
#   test.sh test     adds the long Python tests, sanitizers over the C++ tests, replays on arm64 under qemu-user, one
#                    real-time kernel with real CAN and GPIO drivers in QEMU, the committed codec, lint
#   test.sh full     adds the slow Python tests, the C++ tests that take longest with sanitizers, both kernels, the score
#                    of hidden effects, and all of quick in a Debian 13 root
# shellcheck disable=SC2030,SC2031 # what is counted beside, `together` counts in
set -uo pipefail
cd "$(dirname "$0")/.." || exit
unset MAKEFLAGS MAKELEVEL # the builds below make their own jobs
export WERROR=1
mode=${1:?usage: test.sh quick|test|full}
at_once=(-n "$(nproc)" --dist loadfile) # what a file's tests share is made once
passed=0 failed=0 skipped=0 failures=() is_beside=
times=build/test_times.txt # of each test and step: seconds and name
mkdir -p build
: >"$times"

# part NAME: a heading, and how long it took to get there.
part() {
    echo "--- $1 (after ${SECONDS} s)"
}

# step NAME COMMAND...: one pass or failure; output is shown only if it fails.
step() {
    local name=$1 output begin_s=$SECONDS
    shift
    part "$name"
    output=$("$@" 2>&1)
    local status=$?
    echo "$((SECONDS - begin_s)) $name" >>"$times"
    if [ "$status" = 0 ]; then
        passed=$((passed + 1))
    else
        printf '%s\n' "$output"
        failed=$((failed + 1)) failures+=("$name")
    fi
}

# cpp NAME PROGRAM...: a doctest program; each test case counts.
cpp() {
    local name=$1 output cases
    shift
    part "$name"
    output=$("$@" --duration=true 2>&1)
    local status=$?
    sed -nE 's/^([0-9.]+) s: (.*)/\1 \2/p' <<<"$output" >>"$times"
    output=$(sed -E '/^[0-9.]+ s: /d' <<<"$output")
    printf '%s\n' "$output"
    cases=$(sed -n 's/.*test cases: *[0-9]* *| *\([0-9]*\) passed *| *\([0-9]*\) failed.*/\1 \2/p' <<<"$output" | tail -1)
    if [ -z "$cases" ]; then
        failed=$((failed + 1)) failures+=("$name")
        return
    fi
    passed=$((passed + ${cases% *})) failed=$((failed + ${cases#* }))
    [ "$status" = 0 ] || failures+=("$name")
}

# py NAME ARGUMENTS...: pytest; each test counts, and what was skipped is said.
py() {
    local name=$1 output last
    shift
    part "$name"
    output=$(.venv/bin/python -m pytest -q -ra -p no:cacheprovider --durations=0 --durations-min=1 "$@" 2>&1)
    local status=$?
    sed -nE 's/^([0-9.]+)s (call|setup|teardown) +(.*)/\1 \3/p' <<<"$output" >>"$times"
    output=$(sed -E '/^[0-9.]+s (call|setup|teardown) /d' <<<"$output")
    printf '%s\n' "$output"
    last=$(tail -1 <<<"$output")
    count() { grep -oE "[0-9]+ $1" <<<"$last" | grep -oE '[0-9]+' || echo 0; }
    passed=$((passed + $(count passed))) skipped=$((skipped + $(count skipped)))
    failed=$((failed + $(count failed) + $(count 'errors?')))
    [ "$status" = 0 ] || failures+=("$name")
    if [ "$status" != 0 ] && [ "$(count failed)" = 0 ] && [ "$(count 'errors?')" = 0 ]; then
        failed=$((failed + 1))
    fi
}

# beside FUNCTION: its parts in the background, in a process group of their own, which ends with this script.
beside() {
    is_beside=yes
    : >build/beside.counts
    set -m
    (
        passed=0 failed=0 skipped=0 failures=()
        "$1" >build/beside.txt 2>&1 </dev/null
        printf '%s\n' "$passed $failed $skipped" "${failures[@]}" >build/beside.counts
    ) &
    set +m
    # shellcheck disable=SC2064 # the process of now
    trap "kill -- -$! 2>/dev/null" EXIT
}

# together: waits for these parts, if there are any, shows what they said and counts them.
together() {
    local lines counts
    [ -n "$is_beside" ] || return
    wait
    trap - EXIT
    is_beside=
    cat build/beside.txt
    mapfile -t lines <build/beside.counts
    [ ${#lines[@]} -gt 0 ] || lines=("0 1 0" "what runs beside ended early")
    read -ra counts <<<"${lines[0]}"
    passed=$((passed + counts[0])) failed=$((failed + counts[1])) skipped=$((skipped + counts[2]))
    failures+=("${lines[@]:1}")
}

in_cpp() {
    cpp "C++ tests" build/cpp_tests
    cpp "C++ tests of the Linux side, those that need no bus" build/target_tests -tce='contract*,bus*'
}

# on_kernels ARCHITECTURE TRIPLET...
on_kernels() {
    local name=$1
    shift
    step "build for the guests" make target-programs GUEST_TRIPLETS="$*"
    py "tests on a real-time kernel in QEMU" -k "$name" tests/target
}
# A guest under load computes for several minutes of the host's time a minute of its own.
on_one_kernel() { BERTH_CLOSED_LOOP_s=20 on_kernels arm64 aarch64-linux-gnu; }
on_both_kernels() { BERTH_POWER_CUTS=20 on_kernels "arm64 or amd64" aarch64-linux-gnu x86_64-linux-gnu; }

# What sanitizers leave to the full tier, as it takes longest, and what counts what is instrumented there.
long_with_sanitizers='*theory/chooser_*,*theory/claims_*,*theory/concept_*,*theory/describing_*,*theory/growth_test*,*theory/lyapunov_*,*theory/map_*,*theory/restitution_*,*theory/solver_*,*theory/stability_*'
not_with_sanitizers='no_side_effects*,axes in trouble: all stop*'
with_sanitizers() {
    step "build with sanitizers" make SANITIZE=1 build/sanitize/berth-loop build/sanitize/cpp_tests build/sanitize/target_tests build/sanitize/parsers
    if [ "$mode" = full ]; then
        cpp "C++ tests with sanitizers" build/sanitize/cpp_tests -tce="$not_with_sanitizers"
    else
        cpp "C++ tests with sanitizers" build/sanitize/cpp_tests -tce="reduction: small free swings*,$not_with_sanitizers" \
            -sfe="$long_with_sanitizers"
    fi
    cpp "C++ tests of the Linux side with sanitizers" build/sanitize/target_tests -tce='contract*,bus*'
    step "reference case with sanitizers" build/sanitize/berth-loop ess
    step "broken files for every reader of files" .venv/bin/python scripts/fuzz.py --runs 5000
}

step "build" make all build/cpp_tests build/berth-target build/target_tests build/peer
step "build the Python package" make python
if [ "$mode" = quick ]; then
    in_cpp
    py "Python tests" "${at_once[@]}" -m "not arm64 and not long and not slow" tests/python
else
    beside in_cpp # they keep one core busy
    step "build for arm64" make CROSS_COMPILE=aarch64-linux-gnu- build/aarch64-linux-gnu/berth-loop build/aarch64-linux-gnu/replay
    step "the committed codec is what the DBC gives" scripts/codec.sh build/codec
    step "codec: berth_can.c" cmp build/codec/berth_can.c firmware/can/berth_can.c
    step "codec: berth_can.h" cmp build/codec/berth_can.h firmware/can/berth_can.h
    together
    # Guests keep their own time, and may wait for the others.
    if scripts/setup.sh target; then
        beside "$([ "$mode" = full ] && echo on_both_kernels || echo on_one_kernel)"
    else
        echo "SKIPPED: the tests on real-time kernels (tests/target): their packages cannot be installed, see above"
        skipped=$((skipped + 1))
    fi
    with_sanitizers
    step "lint" make lint
    if [ "$mode" = full ]; then
        py "Python tests" "${at_once[@]}" tests/python
        step "hidden effects, a fixed record of each kind" .venv/bin/python tests/hidden_effects/score.py --fixed
        step "score of hidden effects" make score COUNT=60
        step "broken files for every reader of files, 60 s each" make fuzz
        step "set-up, build, run and quick tests on Debian 13" scripts/debian_root.sh trixie
    else
        py "Python tests" "${at_once[@]}" -m "not slow" tests/python
    fi
    together
fi

part "end"
echo "what took longest, in seconds:"
sort -rn "$times" | head -10
for name in "${failures[@]}"; do
    echo "FAILED: $name"
done
echo "$mode: $((SECONDS / 60)) min $((SECONDS % 60)) s"
echo "$passed passed, $failed failed, $skipped skipped"
[ ${#failures[@]} = 0 ] && [ "$failed" = 0 ]
