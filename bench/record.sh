#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Runs the experiments of bench/experiments.txt, or those named, and keeps the numbers in bench/results/DEVICE/NAME.csv; then writes docs/performance.md anew.
# A file begins with lines '# commit', '# device', '# driver', '# command'. It is replaced as a whole. Usage: record.sh FANAL [NAME...]
set -euo pipefail
fanal=$(realpath "$1")
cd "$(dirname "$0")/.."
shift
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

[ -z "$(git status --porcelain -- src shaders include cli)" ] || { echo 'record.sh: commit the program first: results name the commit they were measured with' >&2; exit 2; }
commit=$(git rev-parse --short=12 HEAD)
found=''
while IFS='|' read -r name title text arguments; do
    name=${name// /}
    case $name in '' | '#'*) continue ;; esac
    [ $# = 0 ] || [[ " $* " == *" $name "* ]] || continue
    found=yes
    read -ra arguments <<<"$arguments"
    echo "record: $name:$title"
    "$fanal" bench "${arguments[@]}" --no-cache -o "$work/$name"
    value() { grep -m1 "\"$1\": " "$work/$name/results.json" | sed -E 's/^ *"[a-z]+": "(.*)",?$/\1/'; }
    device=$(sed -n '/"device": {/,/}/p' "$work/$name/results.json" | grep -m1 '"name": ' | sed -E 's/^ *"name": "(.*)",?$/\1/')
    # The folder: the device's name without what stands in brackets.
    folder=bench/results/$(sed -E 's/\([^)]*\)//g; s/[^A-Za-z0-9]+/-/g; s/^-|-$//g' <<<"$device" | tr 'A-Z' 'a-z')
    mkdir -p "$folder"
    {
        printf '# commit %s\n# device %s\n# driver %s\n# command fanal bench %s\n' "$commit" "$device" "$(value driver)" "${arguments[*]}"
        tr -d '\r' <"$work/$name/results.csv"
    } >"$folder/$name.csv.new"
    mv "$folder/$name.csv.new" "$folder/$name.csv"
    echo "record: wrote $folder/$name.csv"
done <bench/experiments.txt
[ -n "$found" ] || { echo "record.sh: bench/experiments.txt has no such experiment: $*" >&2; exit 2; }
bench/page.sh update
