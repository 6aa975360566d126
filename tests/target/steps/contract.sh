#!/bin/sh
# The tests of what hal.h promises, on real buses and lines, with both of libgpiod's interfaces.
folder=$PWD
cd /src || exit # they look for files of the repository
for program in target_tests target_tests_gpiod2; do
    code=0
    $program >"$folder/$program.report" 2>&1 || code=$?
    echo $code >"$folder/$program.exit_code"
done
