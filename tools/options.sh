#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# docs/options.md and docs/counters.md are what `fanal render --options|--counters --markdown` prints: options.sh update|check FANAL
set -eu
cd "$(dirname "$0")/.."
status=0
for page in options counters; do
    case $1 in
    update) "$2" render --$page --markdown >docs/$page.md ;;
    check)
        "$2" render --$page --markdown | diff docs/$page.md - && continue
        echo "docs/$page.md does not match the program: run tools/options.sh update $2" >&2
        status=1
        ;;
    esac
done
exit $status
