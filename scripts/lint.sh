#!/usr/bin/env bash
# clang-format, clang-tidy and shellcheck over the sources given (generated code is not among them).
#
#   lint.sh FILE...
set -euo pipefail
cd "$(dirname "$0")/.."

clang-format --dry-run --Werror "$@"
shellcheck scripts/*.sh scripts/guest/*.sh scripts/guest/init scripts/image/postinst scripts/image/prerm tests/target/*.sh tests/target/steps/*.sh .ci/run

flags=(-I. -isystem /usr/include/eigen3 -DEIGEN_DONT_VECTORIZE -DEIGEN_RUNTIME_NO_MALLOC -DBERTH_WITH_SUNDIALS
    -DBERTH_WITH_ZLIB "-DBERTH_COMMIT=\"lint\"" -D_GNU_SOURCE)
# What libgpiod 2 declares is not there where version 1 is installed.
printf '%s\n' "$@" | grep '\.c$' | grep -v gpio_v2 | xargs -P "$(nproc)" -n 4 sh -c 'clang-tidy --quiet "$@" 2>/dev/null -- -std=c11 '"${flags[*]@Q}" tidy
printf '%s\n' "$@" | grep '\.cpp$' | xargs -P "$(nproc)" -n 2 sh -c 'clang-tidy --quiet "$@" 2>/dev/null -- -std=c++17 '"${flags[*]@Q}" tidy
