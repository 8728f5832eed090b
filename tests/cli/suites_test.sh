#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The experiments of `fanal bench --suite` at a small size: which way each ratio points. The numbers of the publications come from GPUs and large
# pictures; those are printed by the suites and not demanded here. Usage: suites_test.sh FANAL
#
# Lines of the checklist, read by tools/checklist.sh:
# shows TD-7: tests 1-4 of the thesis: lights in view as constructed; which of light volumes, tiles and back faces is faster
# shows FP-6: fine pruning makes deferred lighting faster, and leaves at most a quarter of the lights per pixel
# shows FP-7: building lists with fine pruning takes at most 3.4 times as long
# shows CL-6: clusters of 24x12x128 have fewer lights per pixel than 96x48 tiles, clearly so with spot lights
# shows CL-7: finer clusters get fewer entries than they are more, and entries grow at most as the lights do
# shows CL-8: clusters of 48x24x128 evaluate at most 63 % of the lights of 24x12x64, and take up to 7.5 times the memory
# shows CP-15: the sweep over shading costs prints every column for both scenes; evaluations saved
# shows DI-15: the times of the passes of attribute interpolation for scenes of large and of small triangles, and where the orders cross
set -u
fanal=$1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failures=0
fail() { echo "FAILED: $*" >&2; failures=$((failures + 1)); }

suite() { # NAME OPTIONS…: $work/NAME/results.json
    local name=$1
    shift
    "$fanal" bench --suite "$name" "$@" -o "$work/$name" --overwrite >"$work/out" 2>&1 || fail "bench --suite $name: $(tail -c 600 "$work/out")"
}
holds() { # FILE MESSAGE FILTER: the filter is true of the file
    jq -e "$3" "$1" >/dev/null || fail "$2: $(jq -c "${4:-$3}" "$1" 2>&1 | head -c 1200)"
}

# Of each row of a suite that RATIOS (an object of jq) names: [the least that `ours` must reach, or the most]. A row is shown when it is on the right
# side by more than its spread. The spread is that of single frames, and the machine does other things as well: rows that are not shown are measured again
# with more frames. The last time a row fails only if it is on the wrong side by two standard errors: a busy machine alone breaks no test, and what makes
# a technique slow is seen through the noise. (The standard error of the median of n frames is sqrt(pi / 2) * 1.4826 * MAD / sqrt(n), and `spread` adds up
# the relative MADs.)
rows='def rows: .suite.rows[] | . as $row | $ratios[.quantity] | select(.) | $row + {bound: .};
    def beyond($doubt): if .comparison == ">=" then .ours - $doubt > .bound else .ours + $doubt < .bound end;
    def shown($frames): .ours != null and (if $frames < 40 then beyond(.spread) else beyond(-.spread * 2 * 1.2533 * 1.4826 / ($frames | sqrt)) end);'
point() { # SUITE RATIOS OPTIONS…
    local name=$1 ratios=$2
    shift 2
    for frames in 3 12 40; do
        suite "$name" "$@" --frames $frames
        jq -e --argjson ratios "$ratios" --argjson frames $frames "$rows"' [rows] | length == ($ratios | length) and all(shown($frames))' \
            "$work/$name/results.json" >/dev/null && return
    done
    fail "$name: ratios on the wrong side of their bounds: $(jq -c --argjson ratios "$ratios" --argjson frames $frames \
        "$rows"' [rows | select(shown($frames) | not) | {quantity, ours, spread, bound}]' "$work/$name/results.json")"
}

# ---- Ishmukhametov: volumes against tiles against tiles that drop what is behind their surfaces ----
# Test 1 has no light behind the walls, so dropping can only cost there: no more than half as much again. Its few lights are as fast as volumes on a CPU.
point thesis '{
    "test 1: tiled with back faces / tiled": 1.5,
    "test 2: light volumes / tiled": 1, "test 2: light volumes / tiled with back faces": 1,
    "test 3: light volumes / tiled": 1, "test 3: tiled with back faces / tiled": 1, "test 3: light volumes / tiled with back faces": 1,
    "test 4: light volumes / tiled": 1, "test 4: tiled with back faces / tiled": 1, "test 4: light volumes / tiled with back faces": 1
    }' --sizes 320x180
results=$work/thesis/results.json
holds "$results" 'thesis: lights in view are not 55, 183, 583, 1083' '[.results[].lights_in_view] | unique == [55, 183, 583, 1083]'
# What makes them fast: the lights that a pixel looks at. A volume touches what lies behind or before its light as well; dropping takes all behind the walls.
holds "$results" 'thesis: lights per pixel' '
    [.results | group_by(.scene)[] | [.[] | {key: .lists, value: .per_pixel}] | from_entries] as $tests |
    ([range(1; 4)] | all($tests[.] | .backface < 0.5 * .tiled)) and ($tests | all(.backface <= .tiled)) and $tests[3].backface < 0.1 * $tests[3].tiled'\
    '[.results[] | {scene, lists, per_pixel}]'
holds "$results" 'thesis: a picture differs' '[.results[].equal] | all'

# ---- Mikkelsen: fine pruning ----
point fine-pruned '{
    "deferred lighting, coarse / fine, 80 lights": 1, "deferred lighting, coarse / fine, 120 lights": 1,
    "lights per pixel, coarse / fine, 40 lights": 4, "lights per pixel, coarse / fine, 80 lights": 4,
    "lights per pixel, coarse / fine, 120 lights": 4,
    "list build, fine / coarse, 40 lights": 3.4, "list build, fine / coarse, 80 lights": 3.4, "list build, fine / coarse, 120 lights": 3.4
    }' --sizes 320x180
results=$work/fine-pruned/results.json
holds "$results" 'fine pruning: a picture differs' '[.results[].equal] | all'

# ---- Ortegren, Persson: clusters by rasterised meshes; that suite takes minutes, so these are counts of its grids at a half and a quarter of its size ----
count() { # NAME SCENE SIZE OPTIONS…: adds the counts of a frame to $work/counts.json
    local name=$1 scene=$2 size=$3
    shift 3
    "$fanal" render "$scene" --size "$size" --shadows off --exposure 0 -q --stats "$work/stats.json" "$@" >"$work/out" 2>&1 || fail "render $name: $(tail -c 600 "$work/out")"
    jq --arg name "$name" '{($name): .lights}' "$work/stats.json" >>"$work/counts"
}
clusters() { # NAME SCENE SIZE PIXELS SLICES OPTIONS…
    local name=$1 scene=$2 size=$3 pixels=$4 slices=$5
    shift 5
    count "$name" "$scene" "$size" --lists raster --set "clusters.size=$pixels" --set "clusters.slices=$slices" "$@"
}
points='builtin:hall?lights=4096' none='builtin:hall?lights=0'
tiles=(--lists tiled --set tiles.size=8) # 96x48 of them
spots=(--lights 4096 --light-shapes spot) scattered=(--lights 4096 --light-seed 1)
clusters points "$points" 768x384 32 128
count points_in_tiles "$points" 768x384 "${tiles[@]}"
clusters spots "$none" 768x384 32 128 "${spots[@]}"
count spots_in_tiles "$none" 768x384 "${tiles[@]}" --set list.cone-tests=off "${spots[@]}" # spheres, as the tiles of the source test them
clusters wide32 "$none" 384x192 16 32 "${scattered[@]}" # 24x12 clusters
clusters wide64 "$none" 384x192 16 64 "${scattered[@]}"
clusters fine32 "$none" 384x192 8 32 "${scattered[@]}" # 48x24
clusters fine128 "$none" 384x192 8 128 "${scattered[@]}"
# Scattered lights become smaller as they become more; scaled, they keep their size.
clusters half "$none" 384x192 16 128 --lights 2048 --light-seed 1
clusters whole "$none" 384x192 16 128 --lights 4096 --light-scale 1.26
jq -s add "$work/counts" >"$work/counts.json"
numbers='to_entries[] | [.key, .value.in_view, .value.list_entries, .value.list_used_bytes, .value.mean_per_pixel]'
counted() { holds "$work/counts.json" "clusters: $1" "$2" "$numbers"; } # MESSAGE FILTER
counted 'something overflowed' 'all(.overflow_cells == 0 and .dropped == 0)'
counted 'lights per pixel against tiles' '.points.mean_per_pixel < .points_in_tiles.mean_per_pixel'
counted 'lights per pixel against tiles, spots' '.spots.mean_per_pixel < 0.8 * .spots_in_tiles.mean_per_pixel'
counted 'entries of four times the tiles' '.fine32.list_entries < 3.9 * .wide32.list_entries and .fine32.list_entries > .wide32.list_entries'
counted 'entries of 16 times the clusters' '.fine128.list_entries / .wide32.list_entries | . > 8 and . < 14.5'
counted 'entries of twice the lights' '.whole.list_entries / .half.list_entries / (.whole.in_view / .half.in_view) | . > 0.85 and . < 1.15'
counted 'evaluations of finer clusters' '.fine128.mean_per_pixel < 0.63 * .wide64.mean_per_pixel' # the time of the source came down to 0.717
counted 'memory of finer clusters' '.fine128.list_used_bytes / .wide64.list_used_bytes | . > 6 and . < 7.5'

# ---- Sathe, Janczak: the sweep over what shading costs; Schied, Dachsbacher: the passes and the crossing ----
suite coarse --sizes 128x72 --frames 4 --warm-up 1
results=$work/coarse/results.json
holds "$results" 'coarse: rows' '[.coarse[] | [.scene, .cost]] | unique == [("builtin:hall?lights=1024", "builtin:interior?lights=96") as $scene | (0, 100, 500) | [$scene, .]]'
holds "$results" 'coarse: columns' '.coarse | length == 18 and all((.pixel_ms, .coarse_ms) > 0 and ([.saving, .gbuffer_ms, .net] | all(type == "number")) and
    .shared > 5 and .shared < 95 and .evaluations_saved > 5 and .evaluations_saved < 95 and .psnr > 20 and .psnr < 60)'
# Of blocks of 2x2 with the thresholds of the source; more pixels have more blocks that are alike.
holds "$results" 'coarse: evaluations saved' '[.coarse[] | select(.way == "2x2, 2 degrees") | .evaluations_saved > {i: 40, h: 12}[.scene[8:9]]] | length == 6 and all' \
    '[.coarse[] | [.scene, .way, .evaluations_saved]]'
# What is shared does not depend on what shading costs.
holds "$results" 'coarse: sharing changes with the cost' '[.coarse | group_by([.scene, .way])[] | ([.[].shared] | unique | length == 1)] | all'
grep -qE 'pixel, ms +coarse, ms +saving, % +source +blocks, % .*G-buffer, ms +net, % +PSNR' "$work/out" || fail "coarse: the table: $(head -c 600 "$work/out")"

suite dais --sizes 96x54 --frames 1 --warm-up 1
results=$work/dais/results.json
holds "$results" 'dais: times of passes' '.dais | length == 10 and all([.prepass_ms, .visibility_ms, .derivatives_ms, .shade_ms] | all(. > 0)) and
    ([.[] | select(.scene | startswith("builtin:hall")) | .shared_ms > 0] == [true, true])'
# All ways on the hall alone, what the crossings need on the others.
holds "$results" 'dais: ratios' '[.. | objects] | [map(select(has("of_deferred_prepass"))), map(select(has("list_of_target")))] | map(length) == [10, 2]'
holds "$results" 'dais: bytes of smaller and smaller triangles' '[.dais[] | select(.series == "spheres" and .msaa == 1)] |
    [.[].samples_per_triangle] == ([.[].samples_per_triangle] | sort | reverse) and .[0].bytes_of_deferred < 1 and .[-1].bytes_of_deferred > 1'
grep -q 'spheres, 96x54, 4 samples; time.*bytes even at [0-9.]* samples a triangle' "$work/out" || fail "dais: where the orders cross: $(tail -c 600 "$work/out")"

# ---- shadows: pages that are drawn once, and light on the wrong side ----
suite shadows --sizes 64x36 --frames 1 --warm-up 0
results=$work/shadows/results.json
of='def of($kind): .shadows[] | select(.shadows == $kind);'
holds "$results" 'shadows: rows' '[.shadows[] | [.scene, .lights, .shadows]] | unique | length == 6 * ([.[][2]] | unique | length) and
    ([.[][1]] | unique == [16, 64, 256]) and ([.[][2]] | contains(["off", "rays", "maps"]))' '[.shadows[] | [.scene, .lights, .shadows]]'
holds "$results" 'shadows: a result for each row' '[.shadows[] | [.scene, .lights, .frame_ms]] == [.results[] | [.scene, .asked_lights, .frame_ms.median]]'
holds "$results" 'shadows: pages of a still frame' "$of"'[of("maps") | .wanted > 50 and .pages == .wanted and .first_drawn == .pages and .drawn == 0 and
    .coarsened == 0 and .traced == 0 and .mebibytes > 0 and .mebibytes < 64] | length == 6 and all' "$of"'[of("maps")]'
holds "$results" 'shadows: pages of a moving camera' "$of"'[of("maps") | .moving_drawn > 0 and .moving_drawn < 0.25 * .pages and .moving_evicted == 0] | all' \
    "$of"'[of("maps") | {pages, moving_drawn, moving_evicted}]'
holds "$results" 'shadows: more lights, more pages' "$of"'[of("maps")] | group_by(.scene) | all([.[].wanted] | . == sort and .[2] > 2 * .[0])' "$of"'[of("maps").wanted]'
# At so few pixels shadow edges are everywhere.
holds "$results" 'shadows: light on the wrong side' "$of"'[of("rays").leak == 0] + [[.shadows[] | select(.shadows == "maps" or .shadows == "off")] | group_by(.scene)[] |
    group_by(.lights)[] | map({key: .shadows, value: .leak}) | from_entries | .maps > 0 and .maps < 0.1 and .maps < .off] | length == 12 and all' \
    '[.shadows[] | [.scene, .lights, .shadows, .leak]]'
head -n 1 "$work/shadows/results.csv" | grep -q 'shadows_ms_median.*shadows\.wanted' || fail 'shadows: the columns of the CSV'
# Near to rays in the same time, in the hall: rays without an error, more rays with less of it, and guides with less than without.
holds "$results" 'shadows: rows of equal times' '[.equal_time | group_by(.scene)[] | map(.way)] | length == 1 and all(length == 10 and (.[0] == "rays" and .[1] == "maps"))' \
    '[.equal_time[] | [.scene, .lights, .way]]'
holds "$results" 'shadows: errors in equal times' '[.equal_time | group_by(.scene)[] | map({key: .way, value: .}) | from_entries |
    .rays.rmse == 0 and .rays.flip == 0 and .rays.gain == null and .["sampled, 4 rays"].rmse < .["sampled, 1 ray"].rmse and .["guided, 4 rays"].rmse < .["guided, 1 ray"].rmse and
    .["guided, 1 ray"].rmse < .["sampled, 1 ray"].rmse and .["denoised, 1 ray"].rmse < .["sampled, 1 ray"].rmse and all(.[]; .rmse < 2 and .flip >= 0 and .flip < 1)] | all' \
    '[.equal_time[] | [.scene, .way, .rmse, .flip]]'
grep -qE 'shadows +frame, ms +shadows, ms +RMSE, % +FLIP +time x MSE +gain' "$work/out" || fail "shadows: the table of equal times: $(tail -c 600 "$work/out")"
grep -qE 'Of 672 lights with shadow maps 0 found no room' "$work/out" || fail "shadows: the table: $(tail -c 600 "$work/out")"

[ $failures = 0 ] && echo 'all suites point where they should'
exit $((failures > 0))
