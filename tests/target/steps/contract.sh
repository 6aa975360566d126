#!/bin/sh
# The tests of what hal.h promises, on real buses and lines.
folder=$PWD
cd /src || exit # they look for files of the repository
target_tests >"$folder/report"
