#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# docs/options.md is what `fanal render --options --markdown` prints: options.sh update|check FANAL
set -eu
cd "$(dirname "$0")/.."
case $1 in
update) "$2" render --options --markdown >docs/options.md ;;
check)
    "$2" render --options --markdown | diff docs/options.md - && exit
    echo "docs/options.md is not what the program has: tools/options.sh update $2" >&2
    exit 1
    ;;
esac
