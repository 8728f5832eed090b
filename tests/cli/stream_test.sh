#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Sequences, stdout as a place for pictures and numbers, and the numbers against their schema. Usage: stream_test.sh FANAL CHECK_SCHEMA CHECK_TRACE
set -u
fanal=$1 check_schema=$2 check_trace=$3
source=$(cd "$(dirname "$0")/../.." && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export MESA_SHADER_CACHE_DIR=${MESA_SHADER_CACHE_DIR:-${XDG_CACHE_HOME:-${HOME:-$work}/.cache}} # what the driver has compiled stays
export XDG_CACHE_HOME="$work/cache" TMPDIR="$work"
failures=0
fail() { echo "FAILED: $*" >&2; failures=$((failures + 1)); }
cd "$work" || exit 2

size=33x17
# run STATUS PATTERN ARGUMENTS…: stdout in out, stderr in err, where a line matches.
run() {
    local status=$1 pattern=$2 got
    shift 2
    timeout 900 "$fanal" render --shadows off "$@" --size $size >out 2>err
    got=$?
    [ $got = "$status" ] || fail "render $*: exit $got, not $status: $(head -c 300 err)"
    [ -z "$pattern" ] || grep -qE -- "$pattern" err || fail "render $*: no line with '$pattern': $(head -c 300 err)"
}
bytes() { stat -c %s "$1"; }
same() { cmp -s "$1" "$2" || fail "$3"; }
spheres="builtin:spheres --lists clustered"
# Lists of words: the scene and its options.
# shellcheck disable=SC2086
{
    # What cannot be meant says so, and nothing is written.
    run 2 'format is for -o -' $spheres --format raw -o a.png
    run 2 'given once' $spheres -o - -o -
    run 2 'not both' $spheres -o - --stats -
    run 2 'goes to stdout as --format raw, y4m or y4m444' $spheres --camera-path orbit:2 -o - --format png
    run 2 'each output of a sequence has one %d' $spheres --camera-path orbit:2 -o a.png
    run 2 'need --frames' $spheres --camera-path turntable -o a-%d.png
    run 2 'cannot be combined' $spheres --camera-path orbit:2 --eye 1,2,3 --look-at 0,0,0 -o a-%d.png
    run 2 'start-frame is for sequences' $spheres --start-frame 1 -o a.png
    run 2 'no picture 2; it ends after 1' $spheres --camera-path orbit:2 --start-frame 2 -o a-%d.png
    run 2 "format: 'x' is not one of png exr raw y4m y4m444" $spheres --format x -o -
    run 2 'path.txt: cannot be read' $spheres --camera-path path.txt -o a-%d.png
    for line in '+1 0 0 1 0 0 0' '1 0x1 0 1 0 0 0' '1 0 0 inf 0 0 0' '1 0 0 1 0 0 0x' '1 0 0 1 0 0' '1 0 0 1 0 0 0 2'; do
        printf '0 0 0 1 0 0 0 # first\n\n\t%s\n' "$line" >bad.txt
        run 2 "bad.txt:3: not 'seconds eye.x" $spheres --camera-path bad.txt -o a-%d.png
    done
    printf '0 0 0 1e39 0 0 0\n' >bad.txt
    run 2 'bad.txt:1: a number is too large' $spheres --camera-path bad.txt -o a-%d.png
    for file in a*; do [ ! -e "$file" ] || fail "$file was left behind"; done

    # A still to stdout has the bytes of the file; what is printed otherwise goes to stderr.
    run 0 'light evaluations' $spheres --verbose -o - -o still.png
    same out still.png 'a PNG on stdout differs from the file'
    run 0 '' $spheres -q -o - --format exr -o still.exr
    same out still.exr 'an EXR on stdout differs from the file'
    ls -d fanal-?????? 2>/dev/null && fail 'a temporary folder was left behind'
    run 0 'light evaluations' $spheres --probe 0,2,0,6,2.5,7 --probe auto --probe-reflections --ies "$source/examples/lamp.ies" --stats - -o still.png
    mv out still.json

    # A sequence: as many pictures as the path has points, each where the path says; parts of it have the bytes of the whole.
    run 0 '' $spheres -q --camera-path orbit:4 -o walk-%02d.png -o - --format raw --stats walk.json --trace-file walk.trace
    [ "$(bytes out)" = $((4 * 33 * 17 * 4)) ] || fail "raw pictures have $(bytes out) bytes"
    mv out whole.raw
    for i in 0 1 2; do cmp -s walk-0$i.png walk-0$((i + 1)).png && fail "pictures $i and $((i + 1)) of an orbit are the same"; done
    [ -e walk-04.png ] && fail 'there is a fifth picture'
    run 0 '' $spheres -q --camera-path orbit:4 --start-frame 2 --frames 3 -o part-%02d.png -o - --format raw
    same part-02.png walk-02.png 'picture 2 differs when the sequence begins with it'
    [ "$(ls part-* | tr '\n' ' ')" = 'part-02.png ' ] || fail "a part has the pictures $(ls part-*)"
    tail -c +$((2 * 33 * 17 * 4 + 1)) whole.raw | head -c $((33 * 17 * 4)) | cmp -s - out || fail 'picture 2 differs on stdout'
    printf '0 3 3 9  0 1 0\n0.5 -4 3 9  0 1 0\n' >path.txt
    run 0 '' $spheres -q --camera-path path.txt --fov 40 --exposure auto -o path-%d.png
    run 0 '' $spheres -q --eye -4,3,9 --look-at 0,1,0 --fov 40 -o eye.png
    same path-1.png eye.png 'a point of a path is not where --eye and --look-at are'
    [ -e path-0.png ] && [ ! -e path-2.png ] || fail 'a file of two points is not two pictures'
    # What a picture shows of the one before is there too when a sequence begins in the middle.
    run 0 '' $spheres -q --camera-path orbit:4 --aov motion -o motion-%d.exr
    run 0 '' $spheres -q --camera-path orbit:4 --aov motion --start-frame 3 -o later-%d.exr
    same motion-3.exr later-3.exr 'motion differs when a sequence begins in the middle'

    # YUV4MPEG2: a header, then for each picture a line and three planes: of even sizes, or with the chroma of each pixel.
    run 2 'y4m requires an even width and height, not 33x17: use 34x18, or --format y4m444' builtin:nowhere --camera-path orbit:4 -o -
    [ ! -s out ] || fail 'pictures of an odd size are begun'
    run 0 '' $spheres -q --camera-path orbit:4 --frame-time 0.04 -o - --format y4m444
    head -n 1 out | grep -qx 'YUV4MPEG2 W33 H17 F25:1 Ip A1:1 C444 XCOLORRANGE=LIMITED' || fail "y4m444 begins with $(head -c 80 out | head -n 1)"
    [ "$(bytes out)" = $(($(head -n 1 out | wc -c) + 4 * (6 + 3 * 33 * 17))) ] || fail "y4m444 has $(bytes out) bytes"
    size=34x18
    run 0 '' $spheres -q --camera-path orbit:4 --frame-time 0.04 -o - --format y4m
    head -n 1 out | grep -qx 'YUV4MPEG2 W34 H18 F25:1 Ip A1:1 C420jpeg XCOLORRANGE=LIMITED' || fail "y4m begins with $(head -c 80 out | head -n 1)"
    [ "$(bytes out)" = $(($(head -n 1 out | wc -c) + 4 * (6 + 3 * 34 * 18 / 2))) ] || fail "y4m has $(bytes out) bytes"
    mv out walk.y4m
    run 0 '' $spheres -q --camera-path orbit:4 --frame-time 0.04 -o -
    same out walk.y4m 'a sequence on stdout is not y4m by itself'
    size=33x17
    # The recipe of the pages makes a file that players read.
    if command -v ffmpeg >/dev/null && command -v ffprobe >/dev/null; then
        ffmpeg -v error -i - -colorspace bt709 -color_primaries bt709 -color_trc iec61966-2-1 walk.mp4 <walk.y4m || fail 'ffmpeg does not read y4m'
        seen=$(ffprobe -v error -count_frames -show_entries stream=width,height,pix_fmt,color_range,color_space,nb_read_frames -of csv=p=0 walk.mp4)
        [ "$seen" = 34,18,yuv420p,tv,bt709,4 ] || fail "a player finds $seen in the video"
    else
        echo 'SKIPPED in part: no ffmpeg, which makes a video of y4m'
    fi

    # A sequence keeps the exposure of its first picture, in parts too; where auto is given, each picture is metered.
    ev() { sed 's/.*"ev":\([-0-9.]*\).*/\1/' "$1" | sort | uniq | wc -l; }
    run 0 '' $spheres -q --camera-path orbit:3 -o even-%d.png --stats even.json
    run 0 '' $spheres -q --camera-path orbit:3 --exposure auto -o wander-%d.png --stats wander.json
    [ "$(ev even.json)" = 1 ] && [ "$(ev wander.json)" -gt 1 ] || fail "a sequence has $(ev even.json) exposures, with --exposure auto $(ev wander.json)"
    same even-0.png wander-0.png 'the first picture of a sequence is not metered'
    cmp -s even-1.png wander-1.png && fail 'each picture of a sequence is metered'

    # A reader that goes away, and a full device, end the run with a message and a status.
    timeout 900 "$fanal" render $spheres --size 320x180 --shadows off -q --camera-path orbit:50 -o - --format raw 2>err | head -c 100000 >/dev/null
    [ "${PIPESTATUS[0]}" = 2 ] || fail "a closed pipe gave status ${PIPESTATUS[0]}"
    grep -qE 'closed by its reader after [0-9]+ bytes, [0-9]+ whole pictures' err || fail "a closed pipe: $(cat err)"
    timeout 900 "$fanal" render $spheres --size 33x17 --shadows off -q -o - -o full.png >/dev/full 2>err
    [ $? = 2 ] && grep -q 'standard output cannot be written: No space' err && [ ! -e full.png ] || fail "a full device: $(cat err)"

    # The numbers: by the schema, and each property of it in one of these.
    run 0 '' builtin:spheres -q --shading dais --set dais.mode=list --stats dais.json # auto lists
    run 0 '' builtin:spheres -q --lists backface --shading coarse --transparency linked --shadows maps --pixel 16,10 --stats coarse.json --frames 2 --trace-file still.trace
    run 2 'no-folder/a.trace' $spheres -q -o left.png --stats left.json --trace-file no-folder/a.trace
    [ ! -e left.png ] && [ ! -e left.json ] || fail 'a trace that cannot be written leaves other files behind'
    run 0 '' $spheres -q --shading visibility --set visibility.sort=class --stats visibility.json
    run 0 '' $spheres -q --shading virtual-texturing --stats atlas.json
    run 0 '' $spheres -q --shading mobile --stats mobile.json
    run 0 '' $spheres -q --shading deferred --msaa 4 --cull clusters --occlusion on --set deferred.class-blocks=0 --stats msaa.json
    run 0 '' builtin:hall --lists clustered -q --views all --stats views.json -o view-%d.png
}
"$check_schema" "$source/docs/stats.schema.json" still.json walk.json dais.json coarse.json visibility.json atlas.json mobile.json msaa.json views.json ||
    fail 'the numbers are not by docs/stats.schema.json'
# Traces: of the pictures of a sequence, and of the timed frames.
[ "$("$check_trace" walk.trace 'frame 3' gbuffer 'compile the graph' submit pose render 'wait for the frame')" = 4 ] || fail 'the trace of a sequence'
[ "$("$check_trace" still.trace 'frame 1' gbuffer record render)" = 2 ] || fail 'the trace of two frames'
[ "$(wc -l <walk.json)" = 4 ] || fail "the numbers of four pictures have $(wc -l <walk.json) lines"
for i in 0 1 2 3; do sed -n $((i + 1))p walk.json | grep -q "\"picture\":$i," || fail "line $((i + 1)) is not of picture $i"; done
tr -d ' \n' <still.json | grep -qF '"probe":[[0.0,2.0,0.0,6.0,2.5,7.0,0.0]]' || fail 'the settings do not tell the probe'
grep -q '"ies": *".*examples/lamp.ies"' still.json || fail 'the settings do not tell the light profile'
grep -q '"probe_auto": *true' still.json && grep -q '"probe_reflections": *true' still.json && grep -q '"captures": *[0-9]' still.json || fail 'the probe has captured nothing'
# What was not counted is null, and what was is a number.
grep -q '"evaluations":null' walk.json && grep -qE '"evaluations": [1-9]' still.json || fail 'evaluations are not null where they were not counted'
grep -qE '"triangles_drawn": null' still.json && grep -qE '"triangles_drawn": [0-9]' msaa.json || fail 'triangles are not null where they were not counted'
# The commit: as git has it, "unknown" without a repository of one's own; the file is left alone while it is the same.
commit() { cmake -DSOURCE="$work/copy" -DOUTPUT="$work/commit.c" -P "$source/cmake/commit.cmake" && grep -o '"[^"]*";' commit.c; }
grep -qE '"commit": "([0-9a-f]{7,40}(-dirty)?|unknown)"' still.json || fail "the commit is $(grep '"commit"' still.json)"
mkdir copy && [ "$(commit)" = '"unknown";' ] || fail "a folder outside of git has the commit $(commit)"
if command -v git >/dev/null; then
    in_copy() { git -C copy -c user.name=x -c user.email=x@example.org -c commit.gpgsign=false "$@" >/dev/null 2>&1; }
    in_copy init && touch copy/file && in_copy add file && in_copy commit -m x
    [ "$(commit)" = "\"$(git -C copy rev-parse --short=12 HEAD)\";" ] || fail "a repository has the commit $(commit)"
    touch -d '2001-01-01' commit.c && commit >/dev/null
    [ "$(stat -c %Y commit.c)" -lt 1000000000 ] || fail 'the same commit is written again'
    echo x >copy/file
    [ "$(commit)" = "\"$(git -C copy rev-parse --short=12 HEAD)-dirty\";" ] || fail "a changed repository has the commit $(commit)"
fi
# Each option of the help has its value in the settings, under "options" by its key, and so has each option of a frame.
named='shading|lists|shadows|msaa|msaa-method|gbuffer|transparency|decals|aa|cull|geometry|occlusion|light-lod|stereo-path|tonemap|debug|ground|studio|size|exposure|contact-shadows|energy'
for option in $("$fanal" render --help | grep -oE -- '--[a-z][a-z-]*' | sort -u | grep -vxE -- "--(help|gbuffers|set|options|counters|json|markdown|$named)"); do
    key=${option#--}
    grep -q "^    \"${key//-/_}\":" still.json || fail "the settings leave out $option"
done
count=0
for key in $("$fanal" render --options | grep -oE '^[a-z][a-z0-9.-]*='); do
    grep -q "^      \"${key%=}\":" still.json || fail "the settings leave out $key"
    count=$((count + 1))
done
[ $count -gt 70 ] || fail "only $count options"
# So has the object of each counter's technique, and it holds the counter where it is not null.
count=0
for key in $("$fanal" render --counters | grep -oE '^[a-z0-9-]+\.[a-z0-9-]+' | tr - _); do
    group=${key%.*}
    grep -qE "^  \"$group\": (null|\{)" still.json || fail "the statistics leave out $group"
    for file in still dais coarse visibility atlas mobile msaa; do
        members=$(sed -n "/^  \"$group\": {/,/^  }/p" $file.json)
        [ -z "$members" ] || grep -qE "^    \"${key#*.}\": (null|true|false|[0-9]+),?$" <<<"$members" || fail "$file.json leaves out $key"
        grep -qE "^    \"${key#*.}\": (true|false|[0-9]+)" <<<"$members" && count=$((count + 1))
    done
done
[ $count -gt 30 ] || fail "only $count counters have values"
[ $failures = 0 ] && echo 'all checks of streams and numbers passed'
exit $((failures > 0))
