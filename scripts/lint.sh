#!/usr/bin/env bash
# clang-format, clang-tidy and shellcheck over the sources given (generated code is not among them).
#
#   lint.sh FILE...
set -euo pipefail
cd "$(dirname "$0")/.."

clang-format --dry-run --Werror "$@"
shellcheck scripts/*.sh scripts/guest/*.sh scripts/guest/init scripts/image/postinst scripts/image/prerm tests/target/*.sh tests/target/steps/*.sh .ci/run

scripts/tidy.py "$@"
