#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# view_layout_test.sh BUILD: the toolbar, its menus and the panels: where they are, what they leave of the window, and that nothing is lost by a click.
set -u
build=$(cd "$1" && pwd)
fanal=$build/fanal
"$fanal" view --help >/dev/null 2>&1 || { echo "SKIPPED: built without 'fanal view' (Debian: libglfw3-dev libimgui-dev)"; exit 77; }
work=$(mktemp -d)
failures=0
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
fail() { echo "FAILED: $*" >&2; [ ! -s out ] || head -c 2000 out >&2; failures=$((failures + 1)); }
replay() { # NAME OPTION…
    local name=$1
    shift
    timeout 900 "$fanal" view --device 0 --headless --msaa 1 --aa none --ground off --replay "$name.txt" "$@" >out 2>&1 || fail "$name: the replay ended with an error"
}
value() { awk -F'\t' -v key="$2" -v field="${3:-2}" '$1 == key { print $field; exit }' "$1"; }
# area REPORT CONDITION: of x, y, w, h.
area() { awk -F'\t' '$1 == "area" { x = $2; y = $3; w = $4; h = $5; n++ } END { exit !(n == 1 && '"$2"') }' "$1" || fail "$1: the area is $(grep ^area "$1"), not $2"; }
key() { printf 'key %s down %s\nkey %s up %s\nframes 1\n' "$1" "${2:-0}" "$1" "${2:-0}"; }
pick() { printf 'move %s %s\nbutton 0 down 2\nbutton 0 up 2\nframes 1\n' "$1" "$2"; }
ESCAPE=256 ENTER=257 TAB=258 O=79 P=80

# ---- what is left of the window, at sizes and scales ----

{ echo 'report start.tsv'; key $TAB; echo 'report bare.tsv'; key $TAB; printf 'panel options\nframes 2\nreport left.tsv\npanel statistics\nframes 2\nreport both.tsv\n'
  pick 320 195; echo 'report picked.tsv'
  key 291; echo 'frames 2'; echo 'report below.tsv'; key 291
  # Narrow: one dock. Letters become twice as large while it runs.
  printf 'size 400 250\nframes 2\nreport narrow.tsv\nscale 1\nframes 2\nreport large.tsv\n'; } >layout.txt
replay layout 'builtin:onetile?lights=1' --size 640x360 --scale 0.5 --shadows off --lists all
area start.tsv 'x == 0 && w == 640 && y > 8 && y < 20 && y + h == 360'
area bare.tsv 'x == 0 && y == 0 && w == 640 && h == 360'
area left.tsv 'x > 100 && x < 240 && x + w == 640'
area both.tsv 'x > 100 && w > 280 && w < 640 - x - 100'
[ "$(value picked.tsv picked)" = object ] || fail 'in the middle of what is left there is nothing'
area below.tsv 'h < 200 && h > 100'
area narrow.tsv 'x + w == 400 && w > 200'
area large.tsv 'x + w == 400 && w > 140 && h > 150'

# What framing puts into the middle stays there when panels take the sides.
cat >point.gltf <<'E'
{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
 "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-1, -1, 0], "max": [1, 1, 0]}, {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"}],
 "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 12}],
 "buffers": [{"byteLength": 60, "uri": "data:application/octet-stream;base64,AACAvwAAgL8AAAAAAACAPwAAgL8AAAAAAACAPwAAgD8AAAAAAACAvwAAgD8AAAAAAAABAAIAAAACAAMA"}]}
E
{ printf 'panel options\nframes 3\nreport there.tsv\n'; pick 402 186; echo 'report middle.tsv'; pick 176 186; echo 'report side.tsv'; } >framed.txt
replay framed point.gltf --size 640x360 --scale 0.5 --shadows off --lists all
area there.tsv 'x + w / 2 > 398 && x + w / 2 < 406'
[ "$(value middle.tsv picked)" = object ] || fail 'the model is not in the middle of what is left'
[ "$(value side.tsv picked)" = nothing ] || fail 'the model reaches behind the panel'

# Every menu can be reached where the window is small for its letters (as 800x500 at 200 %), and Escape closes it.
for menu in Open 'Reset view' Camera Environment Exposure Antialiasing Shadows Debug Compare Save Panels Help; do printf 'click %s\n' "$menu"; key $ESCAPE; done >menus.txt
printf 'click Shadows\nclick Antialiasing\nclick 4\nframes 1\nreport switched.tsv\nclick Antialiasing\nframes 1\n' >>menus.txt
replay menus 'builtin:onetile?lights=1' --size 200x125 --scale 0.5 --shadows off --lists all

# ---- an empty window, and the dialog that opens files ----

printf 'frames 2\nclick Spheres\nsettle\nreport spheres.tsv\n' >start.txt
replay start --size 320x180 --scale 0.5
[ "$(value spheres.tsv scene)" = builtin:spheres ] || fail "a built-in scene was not opened: $(value spheres.tsv scene)"
mkdir models
cp point.gltf models/square.gltf
cp point.gltf models/other.gltf
{ key $O 2; key 341; printf 'click models/\nframes 2\n'; for c in 81 85; do echo "character $c"; echo 'frames 1'; done; key $ENTER; printf 'settle\nreport typed.tsv\n'
  key $O 2; key 341; echo 'character 120'; key $ESCAPE; printf 'frames 1\nclick Shadows\nframes 1\n'; key $ESCAPE; } >typed.txt
replay typed 'builtin:onetile?lights=1' --size 320x180 --scale 0.5 --shadows off --lists all
[ "$(value typed.tsv scene)" = "$work/models/square.gltf" ] || fail "part of a name opened '$(value typed.tsv scene)'"

# ---- nothing is written over ----

{ key $P; key $P; printf 'click Save\nclick save scene\nframes 1\nclick save scene\nframes 1\n'; } >saves.txt
replay saves point.gltf --size 320x240 --scale 0.5 --shadows off --lists all
[ -s picture.png ] && [ -s picture-1.png ] || fail "the picture was written over: $(ls)"
echo precious >scene.glb
printf 'click Save\nclick save scene\nframes 2\nclick keep it\nframes 1\n' >keeps.txt
replay keeps point.gltf --size 320x240 --scale 0.5 --shadows off --lists all
[ "$(cat scene.glb)" = precious ] || fail 'a click writes over a file'
printf 'click Save\nclick save scene\nframes 2\nclick overwrite it\nframes 1\n' >writes.txt
replay writes point.gltf --size 320x240 --scale 0.5 --shadows off --lists all
[ "$(head -c 4 scene.glb)" = glTF ] || fail 'two clicks do not write the file'

# ---- a light that is added casts a shadow, unless shadows were chosen ----

printf 'report dark.tsv\npanel lights\nclick add a light\nframes 1\nreport lit.tsv\n' >light.txt
replay light point.gltf --size 320x240 --scale 0.5
[ "$(value lit.tsv shadows)" = maps ] || fail "with the first light shadows are $(value lit.tsv shadows)"
replay light point.gltf --size 320x240 --scale 0.5 --shadows off
[ "$(value lit.tsv shadows)" = off ] || fail "shadows were chosen, and are $(value lit.tsv shadows)"

[ $failures = 0 ] && echo 'all checks of the layout passed'
exit $((failures > 0))
