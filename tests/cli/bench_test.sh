#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# `fanal bench` as a user meets it: messages, files, resuming, Ctrl-C and SIGTERM. Usage: bench_test.sh FANAL CHECK_SCHEMA
set -u
fanal=$1 check_schema=$2
here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failures=0
fail() { echo "FAILED: $*" >&2; failures=$((failures + 1)); }

# expect STATUS PATTERN ARGUMENTS…: the status, and a line of stderr or stdout that matches.
expect() {
    local status=$1 pattern=$2 got
    shift 2
    # Half of the work, unless shadows are what is tested, or a suite, which has its own.
    [[ " $* " == *" --shadows "* || " $* " == *" --suite "* ]] || set -- --shadows off "$@"
    "$fanal" bench "$@" >"$work/out" 2>&1
    got=$?
    [ $got = "$status" ] || fail "bench $*: exit $got, not $status: $(head -c 400 "$work/out")"
    [ -z "$pattern" ] || grep -qE -- "$pattern" "$work/out" || fail "bench $*: no line with '$pattern': $(head -c 400 "$work/out")"
}
# check FOLDER KEY=VALUE…: what check_bench.jq finds in the results.
check() {
    local folder=$1 pair options=() faults
    shift
    for pair in "$@"; do options+=(--argjson "${pair%%=*}" "${pair#*=}"); done
    faults=$(jq -r --rawfile csv "$folder/results.csv" "${options[@]}" -f "$here/check_bench.jq" "$folder/results.json" 2>&1) || faults+=" (jq failed)"
    [ -z "$faults" ] || fail "$folder: not as it should be ($*): $faults"
}

# What fails is named with its reason, and the others are measured without it.
expect 1 'fanal: error: builtin:onetile, forward with tiled lists \(stereo.eyes=2\): not measured: .*view_count is 0' builtin:onetile --sizes 16x16 --frames 1 --warm-up 0 --quiet \
    --shading forward --lists tiled --vary stereo.eyes=0,2 -o "$work/fails"
jq -e '(.results | length) == 1 and (.skipped | length) == 1 and .skipped[0].failed' "$work/fails/results.json" >/dev/null || fail "not what failed alone is left out"
"$check_schema" "$here/../../docs/bench.schema.json" "$work/fails/results.json" >"$work/out" 2>&1 || fail "the results of a failure break the schema: $(head -c 300 "$work/out")"

# Bad options name themselves and what they take; nothing is measured or written.
out="$work/none"
expect 0 'Examples:' --help
expect 0 'Lists: brute-force tiled' --help
expect 2 'at least one scene' -o "$out"
expect 2 'give -o DIR' builtin:spheres
expect 2 "shading: 'x' is not one of forward forward-prepass deferred" builtin:spheres --shading x -o "$out"
expect 2 "lists: 'x' is not one of brute-force tiled" builtin:spheres --lists tiled,x -o "$out"
expect 2 "reference: 'x' is not one of brute-force tiled" builtin:spheres --reference x -o "$out"
expect 2 "lights: '-1' is not a whole number from 0 to" builtin:spheres --lights 4,-1 -o "$out"
expect 2 "lights: '' is not a whole number" builtin:spheres --lights 4, -o "$out"
expect 2 "sizes: '12' is not a size" builtin:spheres --sizes 12 -o "$out"
expect 2 "sizes: '64x0' is not a size" builtin:spheres --sizes 64x64,64x0 -o "$out"
expect 2 "msaa: '3' is not one of 1 2 4 8" builtin:spheres --msaa 1,3 -o "$out"
expect 2 "--gbuffer is 'x', must be one of default, siege" builtin:spheres --gbuffer default,x -o "$out"
expect 2 "--transparency is 'x', must be one of sorted, weighted, linked" builtin:spheres --transparency x -o "$out"
expect 2 "--decals is 'x', must be one of lists, gbuffer, off" builtin:spheres --decals x -o "$out"
expect 2 "--msaa-method is 'x', must be one of all, tiles" builtin:spheres --msaa-method x -o "$out"
expect 2 "vary: dais.mode is 'x', must be one of target, list" builtin:spheres --vary dais.mode=x -o "$out"
expect 2 "vary: dais.multirate is 'x', must be on or off" builtin:spheres --vary dais.multirate=x -o "$out"
expect 2 "vary: there is no option 'x'" builtin:spheres --vary x=1 -o "$out"
expect 2 "vary: 'x' is not KEY=VALUES" builtin:spheres --vary x -o "$out"
expect 2 "vary: shading cannot be set here" builtin:spheres --vary shading=deferred -o "$out"
expect 2 "vary: coarse.tolerance has too many values for 'all'" builtin:spheres --vary coarse.tolerance=all -o "$out"
expect 2 "set: width cannot be set here" builtin:spheres --set width=8 -o "$out"
expect 2 'chooses shading' --suite thesis --gbuffer all -o "$out"
expect 2 'more than 1048576 combinations' builtin:spheres --gbuffer all --transparency all --decals all --msaa-method all --vary visibility.sort=all \
    --vary mobile.layout=all --vary mobile.lights=all --vary mobile.gamma=all --vary dais.mode=all --cull all --geometry all --occlusion all -o "$out"
expect 2 "frames: '0' is not a whole number from 1" builtin:spheres --frames 0 -o "$out"
expect 2 "warm-up: 'x' is not a whole number" builtin:spheres --warm-up x -o "$out"
expect 2 "checks: 'x' is not a whole number" builtin:spheres --checks x -o "$out"
expect 2 "suite: 'x' is not one of thesis clustered aa coarse fine-pruned" --suite x -o "$out"
expect 2 'give one of them' builtin:spheres --resume --overwrite -o "$out"
expect 2 'chooses shading' --suite thesis --all -o "$out"
expect 2 'no device .*99|99' builtin:spheres --device 99 -o "$out"
expect 2 'chooses shading' --suite shadows --lights 16 -o "$out"
expect 2 'brings its own scenes' builtin:spheres --suite thesis -o "$out"
expect 2 'chooses shading' --suite thesis --lists tiled -o "$out"
expect 2 "set: there is no option 'x'" builtin:spheres --set x=1 -o "$out"
expect 2 "error: there is no option '--nonsense'; see 'fanal bench --help'" builtin:spheres --nonsense -o "$out"
expect 2 'nowhere' builtin:spheres builtin:nowhere -o "$out"
expect 2 'missing.gltf: cannot be opened' "$work/missing.gltf" -o "$out"
expect 2 'nobody' builtin:spheres --camera nobody -o "$out"
expect 2 'path.txt: cannot be read' builtin:spheres --camera-path "$work/path.txt" -o "$out"
printf '# a path\n0 0 2 10  0 1 0\n0.5 1 2\n' >"$work/path.txt"
expect 2 'path.txt:3: not .seconds eye.x' builtin:spheres --camera-path "$work/path.txt" -o "$out"
mkfifo "$work/pipe"
expect 2 'pipe: cannot be read: it is a pipe' builtin:spheres --camera-path "$work/pipe" -o "$out"
expect 2 'device' builtin:spheres --device 99 -o "$out"
[ ! -e "$out" ] || fail 'a folder was made for nothing'
touch "$work/file"
expect 2 'file/x: cannot be written' builtin:spheres -o "$work/file/x"
expect 2 'file.*: cannot be written' builtin:spheres -o "$work/file"
tiny="--sizes 32x18 --shading deferred --lists brute,tiled --frames 2"
# shellcheck disable=SC2086
{
    # A matrix: zero lights and glass too, and a name with a comma for the CSV.
    expect 0 'On builtin:spheres with 16 lights at 33x17, .* was fastest: [0-9.]+ ms(,|[.] Its lead,) [0-9.]+ times as fast as ' builtin:spheres "builtin:glass?seed=2&lights=5" --sizes 33x17 --lights 0,16 \
        --shading deferred,forward --lists brute,tiled,clustered --set tiles.size=8 --set clusters.slices=16 --frames 3 -o "$work/a"
    check "$work/a" RESULTS=24 SKIPPED=0 EQUAL=24 FRAMES=3
    ls "$work/a" | tr '\n' ' ' | grep -qx 'report.html results.csv results.json ' || fail "more files than three: $(ls "$work/a")"

    # Results are not overwritten by chance.
    cp "$work/a/results.json" "$work/before.json"
    expect 2 'a/results.json: there are results already: --resume goes on with them, --overwrite replaces' builtin:spheres $tiny -o "$work/a"
    cmp -s "$work/before.json" "$work/a/results.json" || fail 'results were touched without --overwrite'
    # Brute force goes by its name on the command line.
    [ "$(grep -c ',deferred,brute-force,' "$work/a/results.csv")" = 4 ] || fail "brute force in results.csv: $(cat "$work/a/results.csv")"
    grep -q 'options' <(head -n 1 "$work/a/results.csv") && fail "packed options in results.csv: $(head -n 1 "$work/a/results.csv")"
    # Where the numbers come from, by the schema that is installed.
    "$check_schema" "$here/../../docs/bench.schema.json" "$work/a/results.json" >"$work/schema" 2>&1 || fail "results.json is not by its schema: $(cat "$work/schema")"
    jq -e '.command | startswith("fanal bench --shadows off builtin:spheres '"'"'builtin:glass?seed=2&lights=5'"'"' --sizes 33x17 ") and endswith("/a")' \
        "$work/a/results.json" >/dev/null || fail "the command in results.json: $(grep '"command"' "$work/a/results.json")"
    jq -e --arg cores "$(getconf _NPROCESSORS_ONLN)" --arg kernel "$(uname -sr)" '.machine | (.cores | tostring) == $cores and .kernel == $kernel and .processor != ""' \
        "$work/a/results.json" >/dev/null || fail "the machine in results.json: $(jq -c .machine "$work/a/results.json")"
    grep -q '"command"' "$work/a/report.html" && fail 'the page tells of folders'
    # With shadows as `fanal render` draws them and without: cases of their own, by their headlines; without lights there is nothing to cast them.
    expect 0 'On builtin:spheres with 4 lights at 32x18, shadows by maps, deferred with' builtin:spheres --shadows off,maps --lights 4 \
        --sizes 32x18 --shading deferred --lists tiled --frames 1 -o "$work/w"
    "$fanal" bench builtin:spheres --lights 0,4 --sizes 32x18 --shading deferred --lists tiled --frames 1 -o "$work/w" --overwrite >"$work/out" 2>&1
    check "$work/w" RESULTS=3 SKIPPED=0 EQUAL=3 FRAMES=1
    [ "$(jq -c '[.results[] | [.lights, .settings.shadows // "off"]] | sort' "$work/w/results.json")" = '[[0,"off"],[4,"maps"],[4,"off"]]' ] ||
        fail "shadows that are measured: $(jq -c '[.results[] | [.lights, .settings]]' "$work/w/results.json")"
    grep -q 'with 4 lights at 32x18, without shadows, ' "$work/out" && grep -q 'with 4 lights at 32x18, shadows by maps, ' "$work/out" || fail "headlines: $(cat "$work/out")"
    grep -q '"lists": "brute-force"' "$work/a/results.json" || fail 'the key of brute force in results.json'

    # Again with --resume: nothing is measured, no number changes.
    cp "$work/a/results.json" "$work/before.json"
    matrix='builtin:spheres builtin:glass?seed=2&lights=5 --sizes 33x17 --lights 0,16 --set tiles.size=8 --set clusters.slices=16 --frames 3'
    expect 0 '' $matrix --shading deferred,forward --lists brute,tiled,clustered -o "$work/a" --resume
    grep -q '^case' "$work/out" && fail 'resuming measured something'
    diff <(grep -vE "\"(date|command|load_before)\"" "$work/before.json") <(grep -vE "\"(date|command|load_before)\"" "$work/a/results.json") >/dev/null || fail 'resuming changed results'
    # What is new or was cut off is measured, and only that.
    expect 0 'case 1 of 4.* 2 ways' $matrix --shading deferred,forward --lists brute,tiled,clustered,clustered-cpu -o "$work/a" --resume
    check "$work/a" RESULTS=32 SKIPPED=0 EQUAL=32 FRAMES=3
    sed -i '0,/"complete": true/s//"complete": false/' "$work/a/results.json"
    expect 0 'case 1 of 4.* 1 ways' $matrix --shading deferred,forward --lists brute,tiled,clustered -o "$work/a" --resume
    [ "$(grep -c '^case' "$work/out")" = 1 ] || fail 'resuming measured more than what was cut off'
    check "$work/a" RESULTS=32 SKIPPED=0 EQUAL=32 FRAMES=3
    # Other settings, another device, something else in the file: refused, and the file stays.
    cp "$work/a/results.json" "$work/before.json"
    expect 2 'settings frames was 3, now it is 4' $matrix --frames 4 -o "$work/a" --resume
    expect 2 'settings environment was "", now it is "builtin:studio"' $matrix --environment builtin:studio -o "$work/a" --resume
    expect 2 'nowhere.hdr.*cannot be opened' $matrix --environment nowhere.hdr -o "$work/none"
    sed -i '/"device"/,/}/s/"name": "[^"]*"/"name": "another"/' "$work/a/results.json"
    expect 2 'device name was "another", now it is' $matrix -o "$work/a" --resume
    grep -q '"another"' "$work/a/results.json" || fail 'a refused file was overwritten'
    echo '{"results": 1}' >"$work/a/results.json"
    expect 2 'these are no results of fanal bench' $matrix -o "$work/a" --resume
    # A picture that was wrong stays wrong, in words and in the exit status.
    cp "$work/before.json" "$work/a/results.json"
    sed -i '0,/"equal": true/s//"equal": false/' "$work/a/results.json"
    expect 1 'WRONG PICTURE on .*pixels differ' $matrix --shading deferred,forward --lists brute,tiled,clustered -o "$work/a" --resume
    grep -q 'WRONG PICTURE' "$work/a/report.html" || fail 'the page does not tell of a wrong picture'

    # Pairs that do not fit are listed with a reason; MSAA pictures are compared too.
    expect 0 'mobile with tiled lists.*: this shading path has no MSAA' builtin:spheres $tiny --msaa 1,4 --shading mobile,forward -o "$work/m"
    check "$work/m" RESULTS=6 SKIPPED=2 EQUAL=6 FRAMES=2
    expect 0 'not compared' builtin:spheres $tiny --checks 0 -o "$work/m" --overwrite
    check "$work/m" RESULTS=2 SKIPPED=0 EQUAL=0 FRAMES=2

    # G-buffers, transparency, decals and MSAA methods: each where the order heeds it, with a reference of its own, told apart in the files.
    ways='builtin:glass?lights=6 --sizes 33x17 --shading forward,deferred --lists tiled --frames 2'
    expect 0 'deferred with tiled lists \(transparency=linked,gbuffer.layout=siege\)' $ways --gbuffer default,siege --transparency sorted,linked -o "$work/g"
    check "$work/g" RESULTS=6 SKIPPED=0 EQUAL=6 FRAMES=2 # forward has no G-buffer: 2 + 2 x 2
    # A column for each option that something sets, behind the lists, with the default where nothing does.
    head -n 1 "$work/g/results.csv" | tr -d '\r' | grep -qE ',lists,(gbuffer.layout,transparency|transparency,gbuffer.layout),lights,' || fail "columns: $(head -n 1 "$work/g/results.csv")"
    tr -d '\r' <"$work/g/results.csv" | grep -qE ',forward,tiled,(default,linked|linked,default),' || fail "options in results.csv"
    tr -d '\r' <"$work/g/results.csv" | grep -qE ',deferred,tiled,(siege,linked|linked,siege),' || fail "options in results.csv"
    tr -d '\r' <"$work/g/results.csv" | grep -qE ',deferred,tiled,(default,sorted|sorted,default),' || fail "defaults in results.csv"
    expect 0 '' $ways --gbuffer default,siege --transparency sorted,linked -o "$work/g" --resume
    grep -q '^case' "$work/out" && fail 'resuming measured ways again'
    expect 0 '' $ways --msaa 1,4 --gbuffer default,siege --decals all --msaa-method tiles,all -o "$work/h"
    # One sample: forward 2 (lists, off), deferred 2 x 3; four: forward 2, deferred 2 x 2, and as many left out.
    check "$work/h" RESULTS=18 SKIPPED=0 EQUAL=18 FRAMES=2

    # The ways of dais multiply it alone.
    expect 0 'dais with tiled lists \(dais.mode=list,dais.multirate=on\)' builtin:spheres --sizes 33x17 --shading dais,visibility --lists tiled \
        --vary dais.mode=all --vary dais.multirate=all --msaa 4 --frames 1 -o "$work/d"
    check "$work/d" RESULTS=5 SKIPPED=0 EQUAL=5 FRAMES=1

    # Culling leaves the picture as it is: one reference for all its ways.
    expect 0 'On builtin:spheres .* was fastest' builtin:spheres $tiny --lists tiled --cull all --occlusion all -o "$work/c"
    check "$work/c" RESULTS=6 SKIPPED=0 EQUAL=6 FRAMES=2

    # Suites that are a matrix: scenes and options are theirs, unless others are given; tables.
    expect 0 'visibility \(culling=triangles,occlusion=on\): [0-9.]+ times the triangles' --suite geometry --frames 2 --sizes 32x18 \
        "builtin:city?blocks=1&instances=2000" "builtin:city?blocks=1&triangles=400000" -o "$work/s"
    check "$work/s" RESULTS=12 SKIPPED=0 EQUAL=12 FRAMES=2
    grep -q '"name": "geometry"' "$work/s/results.json" || fail 'no table of geometry'
    expect 0 'wins [0-9] of 1|wins nowhere' --suite visibility --frames 2 --sizes 32x18 --msaa 1 --lights 8 \
        "builtin:hall?overdraw=1" -o "$work/v"
    check "$work/v" RESULTS=5 SKIPPED=0 EQUAL=5 FRAMES=2
    grep -qE 'builtin:hall\?overdraw=1 +32x18 .* (reached|missed|undecided)' "$work/out" || fail "no ids against a G-buffer: $(cat "$work/out")"

    # Paths: from a file, and around the scene.
    printf '# a path\n0 0 2 10  0 1 0\n0.5 1 2 9  0 1 0 # nearer\n\n1 2 2 8  0 1 0\n' >"$work/path.txt"
    expect 0 '' builtin:spheres $tiny --camera-path "$work/path.txt" -o "$work/p"
    # The validation layer itself leaks, which a sanitised build must not mind.
    ASAN_OPTIONS=detect_leaks=0 expect 0 '' builtin:spheres $tiny --camera-path orbit --frames 4 --validate -o "$work/o"
    grep -q '"pictures_compared": 3' "$work/o/results.json" || fail 'three points of a path should be compared'

    # What is not asked for goes by the device, which is a CPU here.
    expect 0 '' "builtin:spheres?lights=4" --lists tiled --shading deferred -o "$work/u"
    check "$work/u" RESULTS=1 SKIPPED=0 EQUAL=1
    jq -e '.results[0].frames | . >= 4 and . <= 16' "$work/u/results.json" >/dev/null || fail 'a CPU does not take 4 frames, or a busy one up to 16'
    grep -q '"width": 640' "$work/u/results.json" || fail 'a CPU is not given a smaller picture'

    # Ctrl-C: what was measured is there, the exit status tells, and --resume goes on, frame by frame. Meanwhile lines tell how far it is.
    first_sample() { awk '/"samples"/ { s = 1 } s && /"frame_ms": \[/ { getline; print; exit }' "$1/results.json"; }
    begin() { # FOLDER PATTERN ARGUMENTS…: measures in the background until a line of the output, or of the results, matches
        local folder=$1 pattern=$2
        shift 2
        : >"$work/out" # the command behind & may empty it only after the first look: what the run before wrote is not its answer
        "$fanal" bench --shadows off "$@" -o "$folder" >"$work/out" 2>&1 &
        bench=$!
        for _ in $(seq 6000); do cat "$work/out" "$folder/results.json" 2>/dev/null | grep -qE "$pattern" && return; sleep 0.1; done
        fail "bench $*: never '$pattern': $(cat "$work/out")"
    }
    finish() { # SIGNAL
        kill "-$1" $bench
        wait $bench
        status=$?
        [ $status = 130 ] || fail "SIG$1: exit $status, not 130: $(cat "$work/out")"
        grep -q 'Interrupted' "$work/out" || fail "SIG$1 was not told of"
    }
    endless="builtin:spheres --sizes 16x9,17x9 --shading deferred --lists brute,tiled --frames 100000 --checks 0"
    begin "$work/i" 'case 1 of 2, way [12] of 2: deferred with (brute force|tiled lists), frame [0-9]+ of 100000, .*about [0-9:]+( s)? left' $endless
    finish INT
    check "$work/i" RESULTS=2 SKIPPED=0 EQUAL=0
    [ -e "$work/i/report.html" ] || fail 'no page after Ctrl-C'
    grep -q '"complete": false' "$work/i/results.json" || fail 'a case that was cut off is not marked'
    sample=$(first_sample "$work/i")
    begin "$work/i" '^case 1 of 2.* 2 ways' $endless --resume
    finish TERM
    [ -n "$sample" ] && [ "$sample" = "$(first_sample "$work/i")" ] || fail 'resuming forgot frames that were timed'
    # Way by way: the first ones are there while others are still to be opened, and are compared once.
    kinds='builtin:spheres --sizes 16x9 --frames 2 --shading deferred --lists brute,tiled,clustered,zbin,bvh,world,halfz,2.5d'
    begin "$work/k" '"equal": true' $kinds
    finish TERM
    some=$(grep -c '"equal": true' "$work/k/results.json")
    [ "$some" -ge 1 ] && [ "$some" -lt 8 ] || fail "SIGTERM left $some ways"
    expect 0 '' $kinds --resume -o "$work/k"
    check "$work/k" RESULTS=8 SKIPPED=0 EQUAL=8 FRAMES=2
}
[ $failures = 0 ] && echo 'all checks of fanal bench passed'
exit $((failures > 0))
