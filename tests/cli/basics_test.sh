#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# What a newcomer meets first: scenes, numbers of lights, what is printed, what is refused. Usage: basics_test.sh FANAL
set -u
fanal=$1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export MESA_SHADER_CACHE_DIR=${MESA_SHADER_CACHE_DIR:-${XDG_CACHE_HOME:-${HOME:-$work}/.cache}} # what the driver has compiled stays
export XDG_CACHE_HOME="$work/cache" TMPDIR="$work"
failures=0
fail() { echo "FAILED: $*" >&2; failures=$((failures + 1)); }
cd "$work" || exit 2

# expect STATUS PATTERN ARGUMENTS…: the status, and a line of stdout or stderr that matches; they are in out and err.
expect() {
    local status=$1 pattern=$2 got
    shift 2
    "$fanal" "$@" >out 2>err
    got=$?
    [ $got = "$status" ] || fail "fanal $*: exit $got, not $status: $(head -c 400 err)"
    [ -z "$pattern" ] || grep -qE -- "$pattern" out err || fail "fanal $*: no line with '$pattern': $(head -c 400 out err)"
}
absent() { for file in "$@"; do [ ! -e "$file" ] || fail "$file was left behind"; done; }
same() { cmp -s "$1" "$2" || fail "$3"; }
plain="--shadows off --lists clustered"
small="--size 64x36 $plain"
triangle='"scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
 "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [-1, -1, 0], "max": [1, 1, 0]}],
 "bufferViews": [{"buffer": 0, "byteLength": 36}],
 "buffers": [{"byteLength": 36, "uri": "data:application/octet-stream;base64,AACAvwAAgL8AAAAAAACAPwAAgL8AAAAAAAAAAAAAgD8AAAAA"}]'
echo "{\"asset\": {\"version\": \"2.0\"}, $triangle}" >triangle.gltf
# Lists of words: options.
# shellcheck disable=SC2086
{
    # The first word: a command, help about one, or a scene, which needs a screen.
    expect 0 '^fanal [0-9]+\.[0-9]+\.[0-9]+$' version
    expect 0 'fanal COMMAND' help
    expect 0 '^Usage: fanal render ' help render
    expect 0 '^Usage: fanal bench ' help bench
    expect 2 "no command 'rendr'; see 'fanal help'" rendr
    expect 2 "no command 'rendr'" help rendr
    expect 2 "no command 'triangle.gltf'" help triangle.gltf
    unset DISPLAY WAYLAND_DISPLAY
    for scene in builtin:hall triangle.gltf nowhere.glb; do
        expect 2 "(no display for|built without) the viewer. To render a picture: fanal render $scene -o picture.png" $scene --lights 3
    done
    [ ! -s out ] || fail 'a scene without a display prints to stdout'
    if command -v Xvfb >/dev/null && "$fanal" view --help >/dev/null 2>&1; then
        mkfifo screen
        Xvfb -displayfd 5 -screen 0 640x480x24 -nolisten tcp 5>screen >/dev/null 2>&1 &
        server=$!
        read -r number <screen
        DISPLAY=:$number timeout 900 "$fanal" builtin:onetile --exit-after 1 --size 160x90 --no-cache --no-settings --no-panels $plain >out 2>&1 ||
            fail "a scene with a display: $(head -c 400 out)"
        kill $server
    fi

    # What looks like a number, a size or a list, and is none; empty values.
    bad() { # OPTION VALUE…
        local option=$1 value
        shift
        for value in "$@"; do expect 2 "^fanal: error: .*$option" render triangle.gltf $small "$option=$value" -o bad.png; done
    }
    bad --size +32x32 32x+32 ' 32x32' '32 x32' 32x32x 32x 0x10 -3x3 32X32
    bad --frames +3 ' 3' '3 ' 0x3 3.0 1e2 99999999999999999999
    bad --frame-time +1 ' 1' 0x1 inf nan 1e999 1,5
    bad --eye 1,2 1,2,3, +1,2,3 1,,3 ' 1,2,3' 1,2,0x3 1,2,1e39 nan,0,0
    bad --exposure +3 ' 3' 0x3 3ev
    bad --light-shapes point,,spot point, point=+3 point=0x3 'point= 3' point=
    bad --aov , depth, ,depth depth,,normal
    bad --pixel 1,2, +1,2 1,-2 ' 1,2'
    bad --probe 0,0,0,1,1 0,0,0,1,1,1,1,1 +0,0,0,1,1,1 0,0,0,1,1,1, ' 0,0,0,1,1,1'
    bad --max-memory +3 ' 3' 3m
    expect 2 'set: gbuffer.fullness is .*must be|set: there is no option' render triangle.gltf --set gbuffer.fullness=+1 -o bad.png
    for value in +0.5 ' 0.5' 0x1 nan inf 0.5x; do expect 2 "coarse.tolerance is '.*', must be a number" render triangle.gltf $small --set "coarse.tolerance=$value" -o bad.png; done
    for value in +8 ' 8' 0x8 -8; do expect 2 "tiles.size is '.*', must be a whole number" render triangle.gltf $small --set "tiles.size=$value" -o bad.png; done
    for option in aov device size output stats environment camera variant animation set hmd format camera-path; do expect 2 "the value of --$option is empty; see 'fanal render --help'" render triangle.gltf $small "--$option=" -o bad.png; done
    expect 2 'the value of -o is empty' render triangle.gltf -o ''
    expect 2 "max-diff: '\\+1' is not" compare triangle.gltf triangle.gltf --max-diff +1
    for value in 1/ 1/0 1/+2 ' 1' 0x1 nan; do expect 2 "max-diff: '.*' is not" compare triangle.gltf triangle.gltf --max-diff "$value"; done
    expect 2 "cube: '\\+64' is not a whole number" compress a.exr --cube +64 -o a.dds
    for path in orbit: orbit:+3 'turntable: 3' orbit:3x orbit:0; do expect 2 "${path/+/.}: cannot be read" render triangle.gltf $small --camera-path "$path" --frames 2 -o 'bad-%d.png'; done
    absent bad*.png

    # A percent sign in a name.
    expect 2 '%% is a percent sign' render triangle.gltf $small -o 50%.png
    expect 2 '%% is a percent sign' render triangle.gltf $small -o 50%%-%.png
    mkdir '9%'
    expect 0 'wrote 9%/50%.png$' render triangle.gltf $small -o 9%%/50%%.png
    expect 0 'wrote 9%/%-0.png to 9%/%-1.png$' render triangle.gltf $small --frames 2 --frame-time 0 -o 9%%/%%-%d.png
    for name in 50% %-0 %-1; do [ -s "9%/$name.png" ] || fail "no 9%/$name.png: $(ls 9%)"; done
    expect 2 'there is no folder none%' render triangle.gltf $small -o none%%/a-%d.png
    expect 2 'are one file' render triangle.gltf $small -o a%%.png -o ./a%%.png

    # A folder with one scene, and what is no glTF.
    mkdir model
    expect 2 'model: is a folder without a scene' info model
    cp triangle.gltf model/
    expect 0 'triangles' info model
    cp triangle.gltf model/other.gltf
    expect 2 'model: is a folder with 2 scenes, other.gltf, triangle.gltf: name one of them' render model $small -o a.png
    echo 'v 0 0 0' >model.obj
    expect 2 "model.obj: is a Wavefront OBJ file. Fanal reads glTF 2.0, as .gltf or .glb: convert it by 'assimp export model.obj model.glb'" render model.obj $small -o a.png
    [ "$(grep -cE 'error|JSON' err)" = 1 ] || fail "more than a line about a format: $(cat err)"
    absent a.png

    # --lights N: altogether in a built-in scene, more in a file.
    lights() { grep -A 20 '"scene": {' "$1" | sed -n 's/^ *"lights": *\([0-9]*\),*$/\1/p'; }
    expect 0 '' render 'builtin:spheres?lights=20&seed=3' $small -q -o named.png
    expect 0 '' render 'builtin:spheres?seed=3&lights=9' --lights 20 $small -q -o option.png --stats option.json
    same named.png option.png '--lights 20 is not what ?lights=20 shows'
    [ "$(lights option.json)" = 20 ] || fail "--lights 20 gives a built-in scene $(lights option.json) lights"
    expect 0 '' trace 'builtin:spheres?lights=5' --size 32x18 --shadows off --exposure 4 -q -o named.png
    expect 0 '' trace builtin:spheres --lights 5 --size 32x18 --shadows off --exposure 4 -q -o option.png
    same named.png option.png '--lights 5 is not what ?lights=5 shows to trace'
    expect 0 '' render builtin:spheres --lights 0 $small -q --stats option.json
    [ "$(lights option.json)" = 0 ] || fail "--lights 0 gives a built-in scene $(lights option.json) lights"
    expect 0 '' render builtin:spheres --lights 20 --light-shapes capsule $small -q --stats option.json -o shapes.png
    [ "$(lights option.json)" = 20 ] || fail "--lights 20 --light-shapes gives a built-in scene $(lights option.json) lights"
    cmp -s shapes.png named.png && fail '--light-shapes changes nothing in a built-in scene'
    expect 0 '' render triangle.gltf --lights 7 $small -q --stats option.json
    [ "$(lights option.json)" = 7 ] || fail "--lights 7 gives a file $(lights option.json) lights"
    expect 2 'lights=1048577 is not a whole number from 0 to 1048576' render builtin:spheres --lights 1048577 $small -o a.png
    absent a.png

    # Folders of outputs are looked at before anything is loaded or rendered: the scene of these commands does not exist.
    for output in '-o none/a.png' '-o a.png --stats none/a.json' '-o a.png --trace-file none/a.trace' '-o a.png --save-scene none/a.glb' '-o none/a-%d.png'; do
        expect 2 'none/a[^:]*: cannot be written: there is no folder none' render builtin:nowhere $output
    done
    expect 2 'none/a.exr: cannot be written: there is no folder none' trace builtin:nowhere -o none/a.exr
    expect 2 'none/a: cannot be written: there is no folder none' bench builtin:nowhere -o none/a
    expect 2 'none/a.dds: cannot be written: there is no folder none' compress nowhere.hdr -o none/a.dds
    expect 2 'none/a.png: cannot be written: there is no folder none' compare nowhere.png nowhere.png -o none/a.png
    expect 2 'none/%w-%e.png: cannot be written: there is no folder none' cave builtin:nowhere --displays builtin:mono -o none/%w-%e.png
    mkdir folder.png
    expect 2 'folder.png: cannot be written: Is a directory' render builtin:nowhere -o folder.png
    grep -q nowhere err && fail 'a scene is loaded before its outputs are looked at'

    # What is printed: a line about the picture and one for each file; the table where it is asked for.
    expect 0 '' render builtin:spheres $small -o line.png
    [ "$(wc -l <out)" = 2 ] && grep -qE '^64x36, deferred, clustered lists, 64 lights: [0-9.]+ s for the frame on ' out && grep -qx 'wrote line.png' out ||
        fail "a picture prints $(cat out)"
    grep -qE 'warning|error' err && fail "a picture warns: $(cat err)" # progress may be there, on a busy machine
    expect 0 'pass, ms' render builtin:spheres $small --verbose -o table.png
    same table.png line.png 'another picture with --verbose'
    expect 0 'pass, ms' render builtin:spheres $small --frames 1 -o table.png
    same table.png line.png 'another picture with --frames 1'
    expect 0 'pass, ms' render builtin:spheres $small --stats table.json -o table.png
    grep -qx 'wrote table.json' out || fail 'the statistics are not said to be written'
    expect 0 'pixel 32, 18: at ' render builtin:spheres $small --pixel 32,18 -q
    expect 2 'cannot be combined' render builtin:spheres $small --verbose --quiet -o a.png
    expect 2 'verbose is for single pictures' render builtin:spheres $small --verbose --camera-path orbit:2 -o a-%d.png
    expect 0 'wrote lit.glb' render triangle.gltf --lights 7 --save-scene lit.glb
    # A file with lamps alone: the studio fills in, and this is said; not where there are surroundings.
    expect 0 'has no environment or ambient light: builtin:studio fills in the shadows' render lit.glb $small -o own.png
    for without in '--environment builtin:studio' '--studio off' '--ambient 1,1,1'; do
        expect 0 '' render lit.glb $small $without -o without.png
        grep -q 'fills in' out && fail "the studio fills in with $without"
        "$fanal" compare own.png without.png --max-diff 0 >/dev/null 2>&1 && fail "the same picture with $without"
    done
    "$fanal" info lit.glb | grep -q 'environment' && fail 'the scene knows of the studio'
    expect 0 '^wrote view-0.png to view-5.png$' render builtin:spheres $small --size 16x16 --views cube -o view-%d.png
    expect 0 'wrote traced.png' trace builtin:spheres --size 16x9 --shadows off -o traced.png
    expect 0 'wrote difference.png' compare line.png table.png -o difference.png
    expect 0 '^wrote cave-%w-%e.png: 1 picture$' cave builtin:spheres --displays builtin:mono --size 32x18 --shadows off -o cave-%w-%e.png

    # Brute force has its name, and "all" is read as before.
    expect 0 '^64x36, deferred, brute force, 64 lights: ' render builtin:spheres --size 64x36 --shadows off --lists brute-force -o brute.png
    expect 0 '^64x36, deferred, brute force, 64 lights: ' render builtin:spheres --size 64x36 --shadows off --lists all -o all.png
    same brute.png all.png '--lists all is not brute force'
    expect 0 '' render builtin:spheres --size 64x36 --shadows off --set lists=all -q --stats all.json
    grep -q '"lists": "brute-force"' all.json || fail 'statistics do not call brute force by its name'

    # A sequence says how it went. Phases have names, on a terminal each of them.
    expect 0 '^64x36, deferred, clustered lists, 64 lights: 3 pictures on ' render builtin:spheres $small --camera-path orbit:3 -o walk-%02d.png
    grep -qx 'wrote walk-00.png to walk-02.png' out || fail "a sequence prints $(cat out)"
    if command -v script >/dev/null; then
        script -qec "'$fanal' render builtin:spheres $small -o terminal.png" /dev/null </dev/null >phases 2>&1
        for phase in 'loading the scene' 'uploading the scene' 'compiling pipelines' 'rendering'; do
            grep -q "$phase" phases || fail "a terminal is not told of $phase"
        done
    fi
    # Ctrl-C keeps what there is: pictures and their numbers, and says how to go on. The third picture waits for its reader, so the signal comes between.
    mkfifo pipe
    "$fanal" render builtin:spheres $small --camera-path orbit:200 -o stop-%03d.png -o - --format raw --stats stop.json >pipe 2>err &
    rendering=$!
    exec 3<pipe
    head -c $((2 * 64 * 36 * 4)) <&3 >first.raw
    kill -INT $rendering
    cat <&3 >rest.raw
    exec 3<&-
    wait $rendering
    [ $? = 130 ] || fail "a sequence that is interrupted does not end with status 130: $(cat err)"
    next=$(sed -n 's/^fanal: interrupted: continue with --start-frame \([0-9]*\).*/\1/p' err)
    [ "${next:-0}" -ge 2 ] && [ "$next" -lt 200 ] || fail "an interrupted sequence does not say how to go on: $(cat err)"
    [ "$(find . -name 'stop-*.png' | wc -l)" = "$next" ] && [ "$(wc -l <stop.json)" = "$next" ] && [ "$(cat first.raw rest.raw | wc -c)" = $((next * 64 * 36 * 4)) ] ||
        fail "of $next pictures there are $(find . -name 'stop-*.png' | wc -l) files and $(wc -l <stop.json) lines"
    grep -q "wrote stop-000.png to stop-$(printf %03d $((next - 1))).png" err || fail "an interrupted sequence does not say what it wrote: $(cat err)"
}
[ $failures = 0 ] && echo 'all checks of the basics passed'
exit $((failures > 0))
