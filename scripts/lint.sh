#!/usr/bin/env bash
# clang-format, clang-tidy, shellcheck and the rule of dear headers over the sources given (generated code is not among
# them); banned phrases in README, pages, --help and messages.
#
#   lint.sh FILE...
set -euo pipefail
cd "$(dirname "$0")/.."

clang-format --dry-run --Werror "$@"
shellcheck scripts/*.sh scripts/guest/*.sh scripts/guest/init scripts/image/postinst scripts/image/prerm tests/target/*.sh tests/target/steps/*.sh .ci/run
scripts/dear_headers.py "$@"
# Phrases that hide who does what.
make build/berth
.venv/bin/python scripts/readability.py --check

scripts/tidy.py "$@"
