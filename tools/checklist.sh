#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Lists the checklist lines that tests show, with the tests' names, then those of tests/checklist.txt that none shows.
# A test shows line ES-43 when its function's or its given name holds ES_43 or ES-43.
set -euo pipefail
cd "$(dirname "$0")/.."

shown=$(mktemp)
trap 'rm -f "$shown"' EXIT
prefixes='ES|MP|TD|CL|FP|DI|CP|MF|VT|LC|MB|BC|SN|CC|VC|FL|PA|CM|LB|OM|VR'
find src tests cli -name '*.c' -print0 | sort -z |
    xargs -0 grep -ohE "\\btest_[A-Za-z0-9_]*(${prefixes})_[0-9]+[A-Za-z0-9_]*|\"[^\"]*\\b(${prefixes})-[0-9]+[^\"]*\"" |
    awk -v prefixes="$prefixes" '
        {
            name = $0; gsub(/^"|"$/, "", name); rest = name
            while (match(rest, "(" prefixes ")[-_][0-9]+([a-z]([^a-z]|$))?")) {
                line = substr(rest, RSTART, RLENGTH); rest = substr(rest, RSTART + RLENGTH)
                sub("_", "-", line); sub(/[^a-z0-9]$/, "", line)
                if (!seen[line, name]++) print line "\t" name
            }
        }' | sort -t- -k1,1 -k2,2V >"$shown" || true
awk -F '\t' '{ printf "%-7s %s\n", $1, $2 }' "$shown"
wanted=$(grep -v '^#' tests/checklist.txt)
missing=$(for line in $wanted; do cut -f 1 "$shown" | grep -qx -- "$line" || echo "$line"; done)
echo "$(cut -f 1 "$shown" | sort -u | wc -l) lines shown; of tests/checklist.txt missing:" ${missing:-none}
