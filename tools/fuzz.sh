#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# fuzz.sh BUILD SECONDS: runs each fuzzer in BUILD/fuzz for its share of the time. Seeds are tests/fuzz/seeds/NAME and, for
# the readers of models and pictures, $FANAL_SCENES where there is such a folder. What was found lies in BUILD/fuzz/found/NAME.
set -euo pipefail
build=$1 seconds=$2
scenes=${FANAL_SCENES:-../shared/scenes}
export ASAN_OPTIONS=allocator_may_return_null=1:detect_leaks=1
export LSAN_OPTIONS=suppressions=tests/lsan.supp:print_suppressions=0
TMPDIR=$(mktemp -d -p "$([ -w /dev/shm ] && echo /dev/shm || echo /tmp)") # some write files, again and again
export TMPDIR
trap 'rm -rf "$TMPDIR"' EXIT
fuzzers=("$build"/fuzz/fuzz_*)
[ -x "${fuzzers[0]}" ] || { echo "fuzz: no fuzzers in $build/fuzz" >&2; exit 1; }
for fuzzer in "${fuzzers[@]}"; do
    [ -d "$fuzzer" ] && continue
    name=$(basename "$fuzzer")
    found=$build/fuzz/found/${name#fuzz_}
    mkdir -p "$found"
    seeds=("tests/fuzz/seeds/${name#fuzz_}") limits=(-timeout=10 -rss_limit_mb=2048)
    case $name in
    fuzz_gltf | fuzz_image) if [ -d "$scenes" ]; then seeds+=("$scenes"); fi ;;
    fuzz_render) limits=(-timeout=120 -rss_limit_mb=8192) ;; # pipelines are made on the way
    esac
    echo "fuzz: $name, $((seconds / ${#fuzzers[@]})) s"
    "$fuzzer" -max_total_time=$((seconds / ${#fuzzers[@]})) "${limits[@]}" -max_len=65536 -verbosity=0 \
        -close_fd_mask=3 -print_final_stats=1 -artifact_prefix="$found/" "$found" "${seeds[@]}" 2>&1 | grep -vE '^("|####)' || {
        echo "fuzz: $name failed; the input lies in $found" >&2
        exit 1
    }
done
echo "fuzz: no failures"
