#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# fuzz.sh BUILD SECONDS: runs each fuzzer in BUILD/fuzz for its share of the time, two of them at once. Seeds are tests/fuzz/seeds/NAME and, for
# the readers of models and pictures, $FANAL_SCENES where there is such a folder. What was found lies in BUILD/fuzz/found/NAME.
set -euo pipefail
build=$1 seconds=$2
scenes=${FANAL_SCENES:-../shared/scenes}
export ASAN_OPTIONS=allocator_may_return_null=1:detect_leaks=1
export LSAN_OPTIONS=suppressions=tests/lsan.supp:print_suppressions=0
TMPDIR=$(mktemp -d -p "$([ -w /dev/shm ] && echo /dev/shm || echo /tmp)") # some write files, again and again
export TMPDIR
trap 'wait; rm -rf "$TMPDIR"' EXIT

fuzz() { # PROGRAM: for its share
    local name found seeds limits log
    name=$(basename "$1")
    found=$build/fuzz/found/${name#fuzz_} log=$TMPDIR/$name.log
    mkdir -p "$found"
    seeds=("tests/fuzz/seeds/${name#fuzz_}") limits=(-timeout=10 -rss_limit_mb=2048)
    case $name in
    fuzz_save) seeds=(tests/fuzz/seeds/gltf) limits=(-timeout=60 -rss_limit_mb=2048) ;; # loaded and saved several times
    fuzz_gltf | fuzz_image) if [ -d "$scenes" ]; then seeds+=("$scenes"); fi ;;
    fuzz_render) limits=(-timeout=120 -rss_limit_mb=8192) ;; # pipelines are made on the way
    fuzz_mixtures) # more of them: a short run tries the seeds alone
        limits=(-timeout=300 -rss_limit_mb=8192)
        if [ "$share" -lt 20 ]; then limits+=(-runs=0); fi ;;
    esac
    if "$1" -max_total_time="$share" "${limits[@]}" -max_len=65536 -verbosity=0 -close_fd_mask=3 -print_final_stats=1 \
        -artifact_prefix="$found/" "$found" "${seeds[@]}" >"$log" 2>&1; then
        echo "fuzz: $name, $share s, $(sed -n 's/^stat::number_of_executed_units: *//p' "$log") runs"
    else
        grep -vE '^("|####)' "$log"
        echo "fuzz: $name failed; the input lies in $found" >&2
        return 1
    fi
}

fuzzers=("$build"/fuzz/fuzz_*)
[ -x "${fuzzers[0]}" ] || { echo "fuzz: no fuzzers in $build/fuzz" >&2; exit 1; }
share=$((seconds / ${#fuzzers[@]}))
running=0
for fuzzer in "${fuzzers[@]}"; do
    fuzz "$fuzzer" &
    running=$((running + 1))
    [ $running -lt 2 ] || { wait -n; running=$((running - 1)); }
done
while [ $running -gt 0 ]; do wait -n; running=$((running - 1)); done
echo "fuzz: no failures"
