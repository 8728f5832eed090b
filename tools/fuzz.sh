#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# fuzz.sh BUILD SECONDS: runs each fuzzer in BUILD/fuzz for its share of the time. Seeds are tests/fuzz/seeds/NAME and,
# where there is such a folder, the models in $FANAL_SCENES. What was found lies in BUILD/fuzz/NAME.
set -euo pipefail
build=$1 seconds=$2
scenes=${FANAL_SCENES:-../shared/scenes}
export ASAN_OPTIONS=allocator_may_return_null=1:detect_leaks=1
fuzzers=("$build"/fuzz/fuzz_*)
[ -x "${fuzzers[0]}" ] || { echo "fuzz: no fuzzers in $build/fuzz" >&2; exit 1; }
for fuzzer in "${fuzzers[@]}"; do
    [ -d "$fuzzer" ] && continue
    name=$(basename "$fuzzer")
    found=$build/fuzz/found/${name#fuzz_}
    mkdir -p "$found"
    seeds=()
    for folder in "tests/fuzz/seeds/${name#fuzz_}" "$scenes"; do [ -d "$folder" ] && seeds+=("$folder"); done
    echo "fuzz: $name, $((seconds / ${#fuzzers[@]})) s"
    "$fuzzer" -max_total_time=$((seconds / ${#fuzzers[@]})) -timeout=10 -rss_limit_mb=2048 -max_len=65536 -verbosity=0 \
        -print_final_stats=1 -artifact_prefix="$found/" "$found" "${seeds[@]}" 2>&1 | grep -vE '^("|####)' || {
        echo "fuzz: $name failed; the input lies in $found" >&2
        exit 1
    }
done
echo "fuzz: no failures"
