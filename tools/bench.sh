#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Renders the hall with every shading order and light list, one after the other, and prints times and light evaluations side by
# side; the full numbers of each run stay in the folder. Usage: bench.sh FANAL FOLDER [SCENE [WxH [FRAMES]]]
set -euo pipefail
fanal=$1 folder=$2 scene=${3:-builtin:hall} size=${4:-1280x720} frames=${5:-3}
mkdir -p "$folder"
printf '%s, %s, medians of %s frames\n\n' "$scene" "$size" "$frames"
printf '%-16s %-14s %12s %12s %12s %16s\n' shading lists 'frame, ms' 'lists, ms' 'CPU, ms' 'lights per pixel'
for shading in forward forward-prepass deferred; do
    for lists in all tiled clustered clustered-cpu; do
        report=$folder/$shading-$lists
        "$fanal" render "$scene" --size "$size" --shading $shading --lists $lists --frames "$frames" --exposure 4 \
            -o "$report.png" --stats "$report.json" >"$report.txt"
        # Sums the passes of light lists in the JSON, which has one key a line.
        awk -v shading=$shading -v lists=$lists '
            /"name":/ { name = $2 }
            /"gpu_ms_median":/ { if (name ~ /^"(light|tiled|clustered)/ && !in_frame) sum += $2 }
            /"frame":/ { in_frame = 1 }
            in_frame && /"gpu_ms_median":/ { frame = $2 + 0 }
            /"cpu_ms_median":/ { cpu = $2 + 0 }
            /"mean_per_pixel":/ { mean = $2 + 0 }
            END { printf "%-16s %-14s %12.1f %12.1f %12.2f %16.1f\n", shading, lists, frame, sum, cpu, mean }' "$report.json"
    done
done
