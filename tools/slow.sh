#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# slow.sh [LOG [LIST]]: rewrites tests/slow.txt (LIST) from what the last run of CTest printed (LOG). Each test, and each part of test_render, that took
# more than eight seconds gets a line; the mark `all` stays. What was not run, or failed, keeps the line that it has.
set -euo pipefail
cd "$(dirname "$0")/.."
log=${1:-build/Testing/Temporary/LastTest.log} list=${2:-tests/slow.txt}
[ -r "$log" ] || { echo "slow.sh: $log cannot be read; run ./build.sh test first" >&2; exit 1; }
new=$(mktemp "$list.XXXXXX")
trap 'rm -f "$new"' EXIT
grep '^#' "$list" >"$new" || true
awk '
    FNR == NR && /^[a-z]/ { old[$1] = $2; mark[$1] = $3 == "all" ? " all" : "" }
    FNR == NR { next }
    $1 ~ /^[0-9]+\/[0-9]+$/ && $2 == "Test:" { test = $3; seconds = ""; parts = 0 }
    # == PART: 0 failed, 12.3 s (11.9 s of processors)
    /^== [a-z0-9_]+: [0-9]+ failed, .* s of processors\)/ {
        part = substr($2, 1, length($2) - 1)
        if ($3 == 0) took[part] = substr($7, 2) + 0
        parts++
    }
    /^Test time = / { seconds = $4 }
    /^Test Passed\./ && !parts { took[test] = seconds + 0 }
    END {
        for (name in took) if (took[name] > 8) printf "%s %.0f%s\n", name, took[name], mark[name]
        for (name in old) if (!(name in took)) printf "%s %s%s\n", name, old[name], mark[name]
    }' "$list" "$log" | LC_ALL=C sort >>"$new"
chmod --reference="$list" "$new"
mv "$new" "$list"
