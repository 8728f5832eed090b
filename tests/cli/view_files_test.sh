#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# view_files_test.sh BUILD: files in and out of `fanal view`: the scene is saved and loaded again when it changes, the browser of folders, two animations
# at once, pictures of any size and sequences. Exit status 77: built without the window.
set -u
build=$(cd "$1" && pwd)
fanal=$build/fanal
"$fanal" view --help >/dev/null 2>&1 || { echo "SKIPPED: built without 'fanal view' (Debian: libglfw3-dev libimgui-dev)"; exit 77; }
work=$(mktemp -d)
viewer='' display='' failures=0
trap '[ -z "$viewer" ] || kill $viewer 2>/dev/null; [ -z "$display" ] || kill $display; [ -n "${KEEP-}" ] || rm -rf "$work"' EXIT
cd "$work" || exit 1
export XDG_CACHE_HOME=$work/cache # pipelines are compiled once
plain="--shading deferred --lists tiled --set shadows=off"
fail() { echo "FAILED: $*" >&2; [ ! -s out ] || head -c 2000 out >&2; failures=$((failures + 1)); }

validate=--validate
replay() {
    local name=$1
    shift
    timeout 900 "$fanal" view $validate --device 0 --headless --replay "$name.txt" $plain "$@" >out 2>&1
}
value() { awk -F'\t' -v key="$2" '$1 == key { print $2; exit }' "$1"; }
run() { (fanal() { "$fanal_" "$@" --device 0 -q; }; fanal_=$fanal; . "./$1") >out 2>&1 || fail "the command does not run: $(cat "$1")"; }
same() { "$fanal" compare "$1" "$2" --max-diff 0 >out 2>&1 || fail "$3: $1 and $2 differ"; }

# A triangle that two animations move, its positions in a file of their own. triangle WIDTH
triangle() {
    cat >swing.gltf <<'EOF'
{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}], "buffers": [{"byteLength": 36, "uri": "swing.bin"},
  {"byteLength": 32, "uri": "data:application/octet-stream;base64,AAAAAAAAgD8AAAAAAAAAAAAAAAAAAABAAAAAAAAAAAA="}],
 "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 1, "byteLength": 8}, {"buffer": 1, "byteOffset": 8, "byteLength": 24}],
 "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [-1, -1, 0], "max": [1, 1, 0]},
  {"bufferView": 1, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [1]}, {"bufferView": 2, "componentType": 5126, "count": 2, "type": "VEC3"}],
 "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], "extensionsUsed": ["KHR_lights_punctual"],
 "extensions": {"KHR_lights_punctual": {"lights": [{"type": "directional", "intensity": 3}]}},
 "animations": [{"name": "move", "samplers": [{"input": 1, "output": 2}], "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}]},
  {"name": "still", "samplers": [{"input": 1, "output": 2, "interpolation": "STEP"}], "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}]}]}
EOF
    sed -i 's/"nodes": \[{"mesh": 0}\]/"nodes": [{"mesh": 0, "extensions": {"KHR_lights_punctual": {"light": 0}}}]/' swing.gltf
    positions "$1"
}
positions() { # -1 -1 0, X -1 0, 0 1 0
    { printf '\0\0\200\277\0\0\200\277\0\0\0\0'; printf "$1"; printf '\0\0\200\277\0\0\0\0\0\0\0\0\0\0\200\077\0\0\0\0'; } >swing.bin
}
narrow='\0\0\0\077' wide='\0\0\200\077' # 0.5, 1
triangle "$narrow"

# ---- the scene is saved; pictures of another size; sequences ----

cat >save.txt <<'EOF'
key 87 down 0
frames 1
key 87 up 0
panel lights
click add a light
savescene changed.glb
settle
save small.png 80 50
command small.sh
save large.png 0 0
report save.tsv
EOF
replay save builtin:onetile --size 500x450 --scale 0.5 || fail 'the replay ended with an error'
"$fanal" render changed.glb --device 0 -q --set shadows=off --set shading=deferred --set lists=tiled $(sed -n 's/.* --size [^ ]*\( --eye [^ ]* --look-at [^ ]* --fov [^ ]* --near [^ ]*\).*/--size 80x50\1/p' small.sh) -o changed.png >out 2>&1 || fail 'the saved scene is not rendered'
same changed.png small.png 'the saved scene'
grep -q -- '--size 80x50' small.sh || fail "the command has another size: $(cat small.sh)"
"$fanal" info changed.glb --json >info.json
[ "$(value save.tsv lights)" = "$(sed -n 's/^ *"lights": \([0-9]*\),/\1/p' info.json | head -1)" ] || fail 'the saved scene has other lights'
echo 'savescene none/x.glb' >bad.txt
replay bad builtin:onetile --size 64x36 && fail 'a scene was saved in a folder that is not there'
grep -q 'none/x.glb' out || fail 'no word of the file'
echo 'savescene x.png' >bad.txt
replay bad builtin:onetile --size 64x36 && fail 'a scene was saved as a picture'

# Lights of the command line are not added again to a scene that has them.
printf 'report five.tsv\nsavescene lit.glb\ndrop lit.glb\nsettle\nreport again.tsv\ncommand again.sh\n' >again.txt
replay again builtin:onetile --lights 5 --size 64x36 || fail 'the replay ended with an error'
[ "$(value again.tsv lights)" = "$(value five.tsv lights)" ] || fail "$(value five.tsv lights) lights were saved, $(value again.tsv lights) opened"
grep -q -e --lights again.sh && fail "the command adds lights to those that were saved: $(cat again.sh)"

# Sequences are those of the command, to the bit.
cat >sequence.txt <<'EOF'
size 96 54
settle
turntable 3
command turn.sh
EOF
rm -f picture-*
replay sequence swing.gltf --size 96x54 || fail 'a turntable'
for i in 0 1 2; do mv picture-000$i.png turn-$i.png || fail "picture $i of the turntable is not there"; done
sed -n 's/^# fanal/fanal/p' turn.sh >turned.sh
run turned.sh
for i in 0 1 2; do same picture-000$i.png turn-$i.png 'the turntable'; done
"$fanal" compare turn-0.png turn-1.png --max-diff 0 >/dev/null 2>&1 && fail 'the turntable does not turn'
cat >fly.txt <<'EOF'
save small.png 96 54
click Save
click sequences
key 86 down 0
key 86 up 0
key 87 down 0
frames 1
key 87 up 0
key 86 down 0
key 86 up 0
click render the path
command path.sh
EOF
rm -f picture-*
replay fly swing.gltf --size 500x450 --scale 0.5 || fail 'the way of the camera'
sed -n 's/^# fanal/fanal/p' path.sh >flown.sh
last=$(ls picture-*.png | tail -1)
[ "$last" != picture-0000.png ] || fail 'the way of the camera is one picture'
mv picture-0000.png fly-first.png
mv "$last" fly-last.png
run flown.sh
same picture-0000.png fly-first.png 'the way of the camera'
same "$last" fly-last.png 'the way of the camera'
"$fanal" compare fly-first.png fly-last.png --max-diff 0 >/dev/null 2>&1 && fail 'the camera stands still on its way'

validate= # what is drawn from here on is nothing new to Vulkan

# ---- two animations ----

cat >blend.txt <<'EOF'
size 500 450
settle
click Animation
click blend with
click with still
click seconds
click part of it
settle
save blend.png 96 54
command blend.sh
click blend with
click nothing
settle
save alone.png
command alone.sh
EOF
replay blend swing.gltf --size 500x450 --scale 0.5 || fail 'two animations'
grep -q -- '--animation 0:[0-9.e-]*,1:[0-9.e-]* ' blend.sh || fail "no weights in the command: $(cat blend.sh)"
run blend.sh
same picture.png blend.png 'two animations'
run alone.sh
same picture.png alone.png 'one animation'

# ---- the browser ----

mkdir -p sub/deeper
cp changed.glb sub/model.glb
printf x >sub/notes.txt
cat >browse.txt <<'EOF'
size 500 450
key 341 down 2
key 79 down 2
key 79 up 2
key 341 up 0
frames 2
click sub/
frames 2
capture browser.png
click model.glb
settle
report browse.tsv
click Open
frames 2
click up
click sub/
click deeper/
click up
click up
click swing.gltf
settle
report browsed.tsv
click Save
click save scene as
frames 2
click save here
settle
EOF
replay browse builtin:onetile --size 500x450 --scale 0.5 || fail 'the browser'
[ "$(value browse.tsv scene)" = "$(realpath sub/model.glb)" ] || fail "the browser opened '$(value browse.tsv scene)'"
[ "$(value browsed.tsv scene)" = "$(realpath swing.gltf)" ] || fail "the browser opened '$(value browsed.tsv scene)'"
[ -s scene.glb ] || fail 'the browser saved nothing'
printf 'click Open\nframes 2\nclick notes.txt\n' >bad.txt
sed -i '1i size 500 450' bad.txt
(cd sub && timeout 900 "$fanal" view --device 0 --headless --replay ../bad.txt $plain >out 2>&1) && fail 'the browser shows what is no scene'

# ---- files that change ----

mkfifo live.txt
timeout 900 "$fanal" view swing.gltf --validate --device 0 --headless --size 96x54 $plain --replay - <live.txt >out 2>&1 &
viewer=$!
exec 4>live.txt
tell() { printf '%s\n' "$@" >&4; }
wait_for() { for _ in $(seq 6000); do [ -s "$1" ] && return; kill -0 $viewer 2>/dev/null || break; sleep 0.1; done; fail "$1 is not written"; }
tell 'wheel 0 2' settle 'save first.png' 'set shading=visibility' settle 'report first.tsv'
wait_for first.tsv
positions "$wide" # in the buffer's file alone
tell poll settle 'save second.png' 'command second.sh' 'report second.tsv'
wait_for second.tsv
printf 'broken' >swing.gltf
tell poll settle 'save third.png' 'report third.tsv'
wait_for third.tsv
triangle "$narrow"
tell poll settle 'set shading=deferred' settle 'save fourth.png' 'report fourth.tsv' poll poll settle 'report fifth.tsv'
wait_for fifth.tsv
# While it is being loaded, or has been read but is not yet shown.
tell 'drop swing.gltf' 'report sixth.tsv'
wait_for sixth.tsv
sleep 0.1 # the clock of files has coarse ticks
positions "$wide"
tell settle poll settle 'report seventh.tsv'
wait_for seventh.tsv
exec 4>&-
wait $viewer || fail 'the window with files that change ended with an error'
viewer=''
"$fanal" compare first.png second.png --max-diff 0 >/dev/null 2>&1 && fail 'what changed is not shown'
same second.png third.png 'a broken file took the scene away'
same first.png fourth.png 'the mended file'
[ "$(value second.tsv shading)" = visibility ] || fail 'the options of the frame were lost'
grep -q 'has changed: loading it again' second.tsv || fail 'nothing is told of the change'
grep -q 'stays as it was' third.tsv || fail 'nothing is told of the broken file'
[ "$(grep -c 'loading it again' fifth.tsv)" = 3 ] || fail "it was loaded $(grep -c 'loading it again' fifth.tsv) times again, not 3"
[ $(($(grep -c 'loading it again' seventh.tsv) - $(grep -c 'loading it again' sixth.tsv))) = 1 ] || fail 'a change while the scene is loaded is not seen'
triangle "$wide"
run second.sh
same picture.png second.png 'the scene after the change'

# By itself, in a window: about two seconds after the file was written.
if command -v Xvfb >/dev/null; then
    Xvfb -displayfd 3 -screen 0 400x300x24 -nolisten tcp 3>number 2>xvfb &
    display=$!
    for _ in $(seq 6000); do [ -s number ] && break; sleep 0.1; done
    broken_after() { # SECONDS: the file is broken so long after the window was started; the window tells of it and stays
        triangle "$wide"
        : >window.log # the command behind & may empty it only after the first look
        DISPLAY=:$(<number) timeout 900 "$fanal" view swing.gltf --device 0 --size 96x54 --no-panels >window.log 2>&1 &
        viewer=$!
        sleep "$1"
        printf 'broken' >swing.gltf
        for _ in $(seq 6000); do { grep -q 'swing.gltf' window.log || ! kill -0 $viewer; } && break; sleep 0.1; done
        sleep 0.5
        local told=1
        grep -q 'swing.gltf' window.log && kill -0 $viewer && told=0
        kill $viewer
        wait $viewer 2>/dev/null
        viewer=''
        return $told
    } 2>/dev/null
    # On a busy machine the window may not have read the file after 4 seconds; then it finds a broken one, and ends.
    broken_after 4 || broken_after 30 || fail "a change is not seen, or the window ended: $(cat window.log)"
else
    echo 'SKIPPED in part: no Xvfb (Debian: xvfb)'
fi
[ $failures = 0 ] && echo 'all checks of files in the window passed'
exit $((failures > 0))
