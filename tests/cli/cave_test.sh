#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# cave_test.sh BUILD: `fanal cave` as a command: options, names of pictures, tracks, and ranks of MPI on this machine, one of which is late, lost, shows
# something else, or has other files. Where MPI is not there, the part about ranks is left out, loudly, with exit status 77.
# shows VR-17: the same frame and pose hash at every swap, a late rank, a lost rank, a rank with other files
set -u
build=$(cd "$1" && pwd)
source=$(cd "$(dirname "$0")/../.." && pwd)
fanal=$build/fanal
work=$(mktemp -d)
failures=0
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
fail() { echo "FAILED: $*" >&2; [ ! -s out ] || head -c 2000 out >&2; failures=$((failures + 1)); }
method=(--shading forward --lists all --shadows off --exposure 0 --size 32x18 --no-cache --device 0)
cave() { timeout 900 "$fanal" cave builtin:onetile "${method[@]}" "$@" >out 2>&1; }
# refuses WORDS OPTION…
refuses() {
    local words=$1
    shift
    cave "$@" && fail "taken: $*"
    [ "$(grep -c . out)" = 1 ] && grep -qF -- "$words" out || fail "not '$words' for $*"
}

# ---- options ----

refuses '--displays FILE is needed' -o a.png
refuses 'there is no example' --displays builtin:castle -o a.png
refuses 'none.json: cannot be read' --displays none.json -o a.png
refuses '/dev/zero: cannot be read: it is a device, not a regular file' --displays /dev/zero -o a.png
refuses 'needs %w' --displays builtin:cave -o a-%e.png
refuses 'needs %e' --displays builtin:three -o a-%w.png
refuses 'needs %d' --displays builtin:mono --frames 2 -o a.png
refuses 'stands before w' --displays builtin:mono -o a-%s.png
refuses 'stands before w' --displays builtin:mono -o a-%3w.png
refuses 'once each' --displays builtin:mono -o a-%w-%w.png
refuses 'ends in .png or .exr' --displays builtin:mono -o a.jpg
refuses 'no output was asked for' --displays builtin:mono
refuses '--fov has no effect' --displays builtin:mono -o a.png --fov 60
refuses '--start-frame must be below --frames' --displays builtin:mono -o a.png --start-frame 1
refuses 'belong together' --displays builtin:mono -o a.png --eye 0,0,1
refuses 'a drill' --displays builtin:mono -o a.png --fault 1,2,sleepy
for fault in +0,0,lost ' 0,0,lost' 0,0x0,lost -1,0,lost 0,-1,lost 0,0, 0,0 99,0,lost; do refuses 'a drill' --displays builtin:mono -o a.png --fault="$fault"; done
refuses 'there is no rank 9; there is 1, from 0' --displays builtin:mono -o a.png --fault 9,0,lost
refuses 'there is no frame 9; there are 0 to 1' --displays builtin:mono --frames 2 -o a-%d.png --fault 0,9,pose
refuses '%% is a percent sign' --displays builtin:mono -o 5%.png
cave --displays builtin:mono -o 5%%.png && [ -s 5%.png ] || fail 'a percent sign in a name'
refuses 'needs an .exr' --displays builtin:mono -o a.png --aov depth
"$fanal" cave --displays builtin:cave --print >cave.json || fail 'an example is not printed'
cp cave.json cave.copy
refuses 'would overwrite an input' --displays cave.json -o a-%w-%e.png --stats ./cave.json
cmp cave.json cave.copy || fail 'the displays were overwritten'

# ---- one process: a track on three displays, one of which is of another size ----

cat >walk.txt <<'T'
0 0 1.7 0
1 0.2 1.7 -0.3
T
"$fanal" cave --displays builtin:three --print | jq '.head = "walk.txt" | .ipd = 0.07 | .origin = {position: [1, 0, 2], scale: 2}' >three.json
cave --displays three.json --frames 3 --start-frame 1 --frame-time 0.25 -o 'p-%w-%e-%03d.png' -o 'q-%d-%e-%w.exr' --aov depth,position --stats walk.json --validate || fail 'a track'
wanted='p-front-left-001.png p-front-left-002.png p-front-right-001.png p-front-right-002.png p-left-mono-001.png p-left-mono-002.png p-right-mono-001.png p-right-mono-002.png'
[ "$(echo p-*)" = "$wanted" ] || fail "the pictures of a track are $(echo p-*)"
[ "$(echo q-* | wc -w)" = 8 ] || fail "the .exr files of a track are $(echo q-*)"
cmp -s p-front-left-001.png p-front-right-001.png && fail 'both eyes see the same'
cmp -s p-front-left-001.png p-front-left-002.png && fail 'the head does not move'
jq -e '[.frames[].frame] == [1, 2] and ([.frames[].head.position] == [[0.05, 1.7, -0.075], [0.1, 1.7, -0.15]]) and [.frames[].time] == [0.25, 0.5] and .ranks == 1 and
    (.views | length) == 4 and .origin.scale == 2 and .origin.position == [1, 0, 2] and (.frames[0].renderers[0] | .copy_bytes == 4 * 32 * 18 * (4 + 3 * 16) and .copy_ms >= 0)' \
    walk.json >out || fail "the numbers of a track: $(jq -c . walk.json)"
echo '2 0 1.7 -1.2' >>walk.txt
refuses "'front/left': the eye at -0.035, 1.7, -1.2 (frame 8, 2 s) is 0.2 m behind the wall" --displays three.json --frames 9 --frame-time 0.25 -o 'r-%w-%e-%d.png'
[ "$(echo r-*)" = 'r-*' ] || fail 'pictures of a track that ends behind a wall'

# Neither picture nor radiance changes where both are wanted.
spheres() { timeout 900 "$fanal" cave builtin:spheres "${method[@]}" --displays builtin:mono --lights 40 --exposure auto --msaa 1 "$@" >out 2>&1; }
spheres -o alone.png || fail 'a .png alone'
spheres -o alone.exr --aov depth || fail 'an .exr alone'
spheres -o both.png -o both.exr --aov depth || fail 'a .png and an .exr'
cmp alone.png both.png || fail 'a .png is another with an .exr beside it'
cmp alone.exr both.exr || fail 'an .exr is another with a .png beside it'

# ---- ranks ----

if [ ! -e "$build/fanal_mpi.so" ] || ! command -v mpirun >/dev/null; then
    OMPI_COMM_WORLD_SIZE=2 cave --displays builtin:mono -o a.png && fail 'ranks without MPI'
    grep -q 'built without MPI' out || fail 'it is not said that MPI is missing'
    [ $failures = 0 ] || exit 1
    echo 'SKIPPED: the ranks of fanal cave: built without MPI (Debian: libopenmpi-dev openmpi-bin)'
    exit 77
fi
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_btl_vader_single_copy_mechanism=none
[ -z "${ASAN_OPTIONS-}" ] && ! grep -q __asan_init "$fanal" || export ASAN_OPTIONS=${ASAN_OPTIONS:+$ASAN_OPTIONS:}detect_leaks=0 # MPI leaks
ranks() { # N OPTION…
    local count=$1
    shift
    timeout 900 mpirun --allow-run-as-root --oversubscribe -n "$count" "$fanal" cave builtin:onetile "${method[@]}" --displays cave.json "$@" >out 2>&1
}
none() { [ "$(echo $1)" = "$1" ] || fail "$2: there is $(echo $1)"; }

"$fanal" info builtin:onetile >/dev/null & # the command itself neither links nor loads MPI
ldd "$fanal" | grep -q libmpi && fail 'the command needs MPI'
wait
cave --displays cave.json --frames 3 -o 'one-%w-%e-%d.png' --stats one.json || fail 'one process'
for count in 2 5; do
    ranks $count --frames 3 -o "n$count-%w-%e-%d.png" --stats "n$count.json" --validate || fail "$count ranks"
    for file in one-*.png; do cmp -s "$file" "n$count-${file#one-}" || fail "$count ranks: ${file#one-} is not that of one process"; done
    jq -s -e --argjson count $count '.[1].ranks == $count and ([.[].frames | map([.frame, .pose_hash])] | .[0] == .[1]) and ([.[1].frames[] | (.rank_ms | length) == $count] | all) and
        ([.[1].frames[].renderers | map(.views[]) | sort == (["front", "left", "right", "floor", "ceiling"] | map(. + "/left", . + "/right") | sort)] | all) and
        ([.[1].frames[1].renderers[].rank] | unique | length == $count)' one.json "n$count.json" >/dev/null || fail "the numbers of $count ranks: $(jq -c .frames "n$count.json")"
done
# Rank 0 writes what others have rendered, .exr files too; an eye each; the file says who renders what.
jq '.walls[0].rank = [1, 0] | .walls[1:][].rank = 1' cave.json >eyes.json
ranks 2 --displays eyes.json --gather -o 'g-%w-%e-%d.png' -o 'g-%w-%e.exr' --aov position --stats who.json || fail 'an eye each'
cave --displays cave.json -o 'h-%w-%e-%d.png' -o 'h-%w-%e.exr' --aov position || fail 'one process, .exr'
for file in g-*; do cmp -s "$file" "h-${file#g-}" || fail "an eye each: $file is another picture"; done
jq -e '[.frames[0].renderers[] | [.rank, (.views | length)]] == [[0, 1], [1, 9]]' who.json >/dev/null || fail "who rendered what: $(jq -c .frames[0].renderers who.json)"
ranks 1 --displays eyes.json -o 'x-%w-%e.png' && fail 'a rank that is not there'
grep -q '/walls/0/rank: is 1, but there are 1 ranks: mpirun -n 2' out || fail 'a rank that is not there'

# One exposure, which the rank of the first view measures: rank 1. A rank more than there are walls has nothing to render.
cave --displays cave.json --exposure auto -o 'auto-%w-%e.png' --stats auto.json || fail 'exposure of one process'
ranks 3 --displays eyes.json --exposure auto -o 'autos-%w-%e.png' --stats autos.json || fail 'exposure of ranks'
jq -s -e '.[0].ev == .[1].ev and .[0].ev != 0' auto.json autos.json >out || fail 'exposures differ'
for file in auto-*.png; do cmp -s "$file" "autos-${file#auto-}" || fail "exposure of ranks: ${file#auto-} differs"; done

# Late: all wait. Longer than --timeout, or killed: all end, though the rank would wait for an hour.
ranks 3 --frames 3 -o 'late-%w-%e-%d.png' --stats late.json --fault 2,1,late=4 || fail 'a late rank'
grep -q 'rank 2 is late in frame 1' out || fail 'nobody says that a rank is late'
for file in one-*.png; do cmp -s "$file" "late-${file#one-}" || fail "a late rank: ${file#one-} differs"; done
jq -e '.frames[1] | .rank_ms[2] >= 4000 and .swap_wait_ms >= 0' late.json >/dev/null || fail "a late rank: $(jq -c .frames[1] late.json)"
ranks 3 --frames 3 -o 'hang-%w-%e-%d.png' --stats hang.json --fault 2,1,late=3600 --timeout 8 && fail 'a rank that hangs'
grep -q 'rank 0: rank 2 has not answered for [.0-9]* s in frame 1 (--timeout): it is lost' out || fail 'a rank that hangs'
ranks 3 --frames 3 -o 'lost-%w-%e-%d.png' --stats lost.json --fault 1,1,lost && fail 'a lost rank'
grep -q 'rank [02]: told to end by a signal in frame 1' out || fail 'a lost rank'
for kind in hang lost; do
    none "$kind-*-[12].png" "a rank that is $kind"
    none "$kind.json" "a rank that is $kind"
    [ "$(echo $kind-*-0.png | wc -w)" = 10 ] || fail "a rank that is $kind: frame 0 is not whole: $(echo $kind-*-0.png)"
done
none '*.part' 'after all'

ranks 2 --frames 3 -o 'none-%w-%e-%d.png' --fault 9,9,lost && fail 'a drill of a rank that is not there'
grep -q 'there is no rank 9; there are 2, from 0' out || fail 'a drill of a rank that is not there'
none 'none-*.png' 'a drill of a rank that is not there'

# The swap tells poses apart.
ranks 3 --frames 3 -o 'pose-%w-%e-%d.png' --fault 1,2,pose && fail 'another pose'
grep -qE 'at the swap rank 1 on [^ ]+ has frame 2 with pose [0-9a-f]{16}, rank 0 frame 2 with' out || fail 'another pose'
none 'pose-*-2.png' 'another pose'

# A rank that cannot write, which is seen first at the picture, as the folder's name holds the eye: all remove what they have of that frame.
timeout 900 mpirun --allow-run-as-root --oversubscribe -n 1 "$fanal" cave builtin:onetile "${method[@]}" --displays cave.json -o 'full-%w-%e.png' : -n 1 "$fanal" cave builtin:onetile "${method[@]}" \
    --displays cave.json -o 'gone-%e/full-%w.png' >out 2>&1 && fail 'a rank without a folder'
grep -q 'rank 1 on .* could not write frame 0' out || fail 'a rank without a folder'
none 'full-*' 'a rank without a folder'

ranks 2 --gather -o 'gone-%e/full-%w.png' && fail 'rank 0 without a folder'
grep -q 'gone-left/full-front.png' out && ! grep -q 'something else' out || fail 'rank 0 without a folder'

# Other files, other options, another version.
differs() { # WORDS, then: PROGRAM SCENE OPTION… of rank 1
    local words=$1 program=$2 scene=$3
    shift 3
    timeout 900 mpirun --allow-run-as-root --oversubscribe -n 1 "$fanal" cave a.gltf "${method[@]}" --displays cave.json -o 'other-%w-%e.png' : -n 1 "$program" cave "$scene" "${method[@]}" \
        --displays cave.json -o 'other-%w-%e.png' "$@" >out 2>&1 && fail "it goes on: $words"
    grep -qE "rank 1 on [^ ]+ $words than rank 0" out || fail "nobody says: $words"
    none 'other-*' "$words"
}
cat >a.gltf <<'G'
{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
 "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}],
 "bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"byteLength": 36, "uri": "a.bin"}]}
G
printf '\0\0\0\0\0\0\0\0\0\0\0\0\0\0\200\77\0\0\0\0\0\0\0\0\0\0\0\0\0\0\200\77\0\0\0\0' >a.bin
mkdir b
cp a.gltf b
printf '\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\77\0\0\0\0\0\0\0\0\0\0\0\0\0\0\200\77\0\0\0\0' >b/a.bin # the same but for the vertices
jq '.ipd = 0.065' cave.json >other.json
differs 'has another scene file' "$fanal" b/a.gltf
differs 'has other displays' "$fanal" a.gltf --displays other.json
differs 'was given other options' "$fanal" a.gltf --ambient 1,1,1
timeout 900 mpirun --allow-run-as-root --oversubscribe -n 1 "$fanal" cave a.gltf "${method[@]}" --displays cave.json -o 'other-%w-%e.png' : -n 1 "$fanal" cave none.gltf "${method[@]}" \
    --displays cave.json -o 'other-%w-%e.png' >out 2>&1 && fail 'it goes on without a scene'
grep -qE 'none.gltf: .*' out && grep -qE 'rank 0: rank 1 on [^ ]+ could not begin: all end' out || fail 'a rank without a scene'
none 'other-*' 'a rank without a scene'
commit=$(jq -r .program.commit one.json)
if [ "$commit" != unknown ]; then
    LC_ALL=C sed "s/$commit/$(tr '0-9a-f' '1-9a-g' <<<"$commit")/" "$fanal" >fanal
    chmod 755 fanal
    ln -s "$build/fanal_mpi.so" .
    differs 'is another version of fanal' "$PWD/fanal" a.gltf
fi

[ $failures = 0 ] && echo 'all checks of fanal cave passed'
exit $((failures > 0))
