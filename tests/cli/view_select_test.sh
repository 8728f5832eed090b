#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# view_select_test.sh BUILD: picks objects, lights and decals in the window, drags and edits them, and takes that back. Exit status 77: built without
# the window.
set -u
build=$(cd "$1" && pwd)
fanal=$build/fanal
"$fanal" view --help >/dev/null 2>&1 || { echo "SKIPPED: built without 'fanal view' (Debian: libglfw3-dev libimgui-dev)"; exit 77; }
work=$(mktemp -d)
failures=0
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
fail() { echo "FAILED: $*" >&2; [ ! -s out ] || head -c 2000 out >&2; failures=$((failures + 1)); }
replay() { # NAME OPTION…: replays NAME.txt with validation
    local name=$1
    shift
    timeout 900 "$fanal" view --no-cache --validate --device 0 --headless --shadows off --shading forward --lists all --exposure 0 --replay "$name.txt" "$@" >out 2>&1 ||
        fail "$name: the replay ended with an error"
}
# field FILE KEY N: the N-th value of the first line that begins with KEY.
field() { awk -F'\t' -v key="$2" -v n="$3" '$1 == key { print $(n + 1); exit }' "$1"; }
# is WHAT FILE KEY N WANTED: a number, to a thousandth.
is() { awk -v a="$(field "$2" "$3" "$4")" -v b="$5" 'BEGIN { d = a - b; exit !(a != "" && d < 1e-3 && d > -1e-3) }' || fail "$1: $3 $4 is '$(field "$2" "$3" "$4")', not $5"; }
# picked WHAT FILE KIND INDEX NAME
picked() { [ "$(field "$2" picked 1)/$(field "$2" picked 2)/$(field "$2" picked 3)" = "$3/$4/$5" ] || fail "$1: picked is $(grep ^picked "$2"), not $3 $4 $5"; }
pick() { printf 'move %s %s\nbutton 0 down 2\nbutton 0 up 2\nframes 1\n' "$1" "$2"; }
# In two steps, which are one edit.
drag() { printf 'move %s %s\nbutton 0 down 0\nmove %s %s\nframes 1\nmove %s %s\nbutton 0 up 0\nframes 1\n' "$1" "$2" "$(awk "BEGIN { print ($1 + $3) / 2 }")" "$(awk "BEGIN { print ($2 + $4) / 2 }")" "$3" "$4"; }
key() { printf 'key %s down %s\nkey %s up %s\nframes 1\n' "$1" "${2:-0}" "$1" "${2:-0}"; }
L=76 R=82 T=84 Z=90 Y=89 ESCAPE=256 TAB=258 DELETE=261

cat >scene.gltf <<'E'
{"asset": {"version": "2.0"}, "extensionsUsed": ["KHR_lights_punctual", "FNL_decal"], "scene": 0, "scenes": [{"nodes": [0, 1, 3, 4, 5, 6, 7]}],
 "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 20, "name": "lamp"}, {"type": "spot", "intensity": 20, "name": "beam", "spot": {}}]}},
 "nodes": [{"name": "board", "mesh": 0},
   {"name": "group", "translation": [1.5, 0, 0.2], "rotation": [0, 0, 0.70710678, 0.70710678], "scale": [0.5, 0.5, 0.5], "children": [2]},
   {"name": "small", "mesh": 0, "scale": [0.6, 0.6, 0.6]},
   {"translation": [0, 0.5, 2], "extensions": {"KHR_lights_punctual": {"light": 0}}},
   {"translation": [-0.5, 0.9, 2], "extensions": {"KHR_lights_punctual": {"light": 1}}},
   {"name": "perspective", "camera": 0, "translation": [0, 0, 6]}, {"name": "parallel", "camera": 1, "translation": [0, 0, 6]},
   {"name": "sticker", "translation": [0.3, -0.5, 0], "scale": [0.4, 0.4, 0.4], "extensions": {"FNL_decal": {"decal": {"baseColorFactor": [1, 0, 0, 1]}}}}],
 "cameras": [{"type": "perspective", "perspective": {"yfov": 0.9, "znear": 0.1}}, {"type": "orthographic", "orthographic": {"xmag": 2, "ymag": 2, "znear": 0.1, "zfar": 100}}],
 "materials": [{"name": "paint", "doubleSided": true, "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.5, 0.5, 1], "metallicFactor": 0.5, "roughnessFactor": 0.5}}],
 "meshes": [{"name": "square", "primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
 "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-1, -1, 0], "max": [1, 1, 0]}, {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"}],
 "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 12}],
 "buffers": [{"byteLength": 60, "uri": "data:application/octet-stream;base64,AACAvwAAgL8AAAAAAACAPwAAgL8AAAAAAACAPwAAgD8AAAAAAACAvwAAgD8AAAAAAAABAAIAAAACAAMA"}]}
E

# ---- what `fanal info` calls the sphere in the middle ----

{ pick 80 45; echo report middle.tsv; pick 80 89; echo report floor.tsv; } >middle.txt
replay middle 'builtin:spheres?lights=2' --size 160x90 --no-panels
name=$("$fanal" info 'builtin:spheres' --json | jq -r '.names.meshes[22] // empty' 2>/dev/null)
picked 'the sphere in the middle' middle.tsv object 22 'metallic 0.50 roughness 0.50'
[ -z "$name" ] || [ "$name" = "$(field middle.tsv picked 3)" ] || fail "'fanal info' calls it $name"
[ "$(field middle.tsv picked_material 2)" = 'metallic 0.50 roughness 0.50' ] || fail 'its material is another'
picked 'the floor' floor.tsv object 45 floor

# ---- objects; a panel takes part of the window while it is shown ----
# At depth d, a metre has 180 / (d tan 0.45) pixels; handles are 45 pixels long.

{ pick 310 190; printf 'report board.tsv\nsave board.png\npanel inspect\nkey 341 up 0\nclick roughness\nreport rough.tsv\nsave rough.png\n'; key $TAB; key $Z 2; printf 'report undone.tsv\nsave undone.png\n'; key $Y 2; echo report redone.tsv
  key $Z 2; printf 'panel inspect\nclick visible\nreport hidden.tsv\nsave hidden.png\n'; key $TAB; pick 310 190; echo report through.tsv; key $Z 2; pick 310 190; echo report again.tsv
  key $R; drag 351.8198 148.1802 288.1802 148.1802; echo report turned.tsv; key $T; key $Z 2; echo report straight.tsv
  pick 416 185; echo report small.tsv; drag 441 180 461 180; printf 'report moved.tsv\n'; pick 436 185; echo report there.tsv
  printf 'move 461 180\nbutton 0 down 0\nmove 500 180\nframes 1\nreport held.tsv\nkey %s down 0\nbutton 0 up 0\nframes 1\nreport gave-up.tsv\n' $ESCAPE
  pick 200 340; echo report sky.tsv; } >objects.txt
replay objects scene.gltf --camera 0 --size 640x360 --scale 0.5 --no-panels
picked 'the board' board.tsv object 0 board
[ "$(field board.tsv picked_mesh 2)/$(field board.tsv picked_material 2)" = square/paint ] || fail 'mesh or material of the board'
is 'as in the file' board.tsv picked_roughness 1 0.5
is 'a click at the slider begin' rough.tsv picked_roughness 1 0
"$fanal" compare board.png rough.png --max-diff 0 >out 2>&1 && fail 'another roughness gives the same picture'
is 'undone' undone.tsv picked_roughness 1 0.5
"$fanal" compare board.png undone.png --max-diff 0 >out 2>&1 || fail 'undone, the picture is another'
is 'redone' redone.tsv picked_roughness 1 "$(field rough.tsv picked_roughness 1)"
[ "$(field hidden.tsv picked_visible 1)" = 0 ] || fail 'the board is not hidden'
"$fanal" compare board.png hidden.png --max-diff 0 >out 2>&1 && fail 'what is hidden is in the picture'
picked 'through what is hidden' through.tsv nothing '' ''
picked 'shown again' again.tsv object 0 board
is 'a quarter turn' turned.tsv picked_transform 1 0
is 'a quarter turn' turned.tsv picked_transform 2 1
is 'turned back' straight.tsv picked_transform 1 1
picked 'the child' small.tsv object 2 small
is 'in the space of its parent' moved.tsv picked_transform 14 "$(awk 'BEGIN { print -2 * 20 * 5.8 * sin(0.45) / cos(0.45) / 180 }')"
is 'and not sideways' moved.tsv picked_transform 13 0
picked 'where it was moved to' there.tsv object 2 small
[ "$(field held.tsv picked_transform 14)" != "$(field there.tsv picked_transform 14)" ] || fail 'the drag moves nothing'
is 'given up' gave-up.tsv picked_transform 14 "$(field there.tsv picked_transform 14)"
[ "$(field gave-up.tsv edits 1)" = 1 ] || fail "what was given up can be undone: $(grep ^edits gave-up.tsv)"
picked 'the sky' sky.tsv nothing '' ''

# ---- lights and decals ----

{ pick 320 133; echo report before.tsv; key $L; pick 320 133; echo report lamp.tsv; drag 320 103 320 73; echo report up.tsv
  key $Z 2; echo report down.tsv; drag 320 127 320 107; echo report away.tsv; key $Z 2; key $DELETE; echo report gone.tsv; key $Z 2; echo report back.tsv
  drag 340 133.4 350 133.4; key $DELETE; key $Z 2; key $Z 2; echo report other.tsv; key $Y 2; key $Y 2; echo report once-more.tsv
  pick 273.4 96.2; key $R; echo report beam.tsv; drag 277.09 73.44 277.09 53.44; echo report bent.tsv; key $T
  pick 338.6 211; echo report decal.tsv; drag 360 211.05 370 211.05; echo report decal-moved.tsv; key $DELETE; echo report no-decal.tsv; key $Z 2; key $ESCAPE; echo report nothing.tsv; } >lights.txt
replay lights scene.gltf --camera 0 --size 640x360 --scale 0.5 --no-panels
picked 'without icons' before.tsv object 0 board
picked 'the lamp' lamp.tsv light 0 lamp
[ "$(field lamp.tsv icons 1)" = 3 ] || fail "$(field lamp.tsv icons 1) icons, not 3"
metre=$(awk 'BEGIN { print 180 / (4 * sin(0.45) / cos(0.45)) }')
is 'along y' up.tsv picked_position 2 "$(awk -v m="$metre" 'BEGIN { print 0.5 + 30 / m }')"
is 'along y alone' up.tsv picked_position 1 0
is 'undone' down.tsv picked_position 2 0.5
is 'along the line of sight' away.tsv picked_position 3 "$(awk -v m="$metre" 'BEGIN { print 2 - 20 / m }')"
is 'and no other' away.tsv picked_position 2 0.5
[ "$(field gone.tsv lights 1)/$(field gone.tsv picked 1)" = 1/nothing ] || fail 'Delete does not remove the light'
[ "$(field back.tsv lights 1)/$(field back.tsv picked 1)" = 2/light ] || fail 'it does not come back'
is 'it comes back where it was' back.tsv picked_position 2 0.5
is 'an edit before it was removed, undone' other.tsv picked_position 1 0
[ "$(field once-more.tsv lights 1)" = 1 ] || fail 'removing it again does not find it'
[ "$(field beam.tsv picked 1)/$(field beam.tsv picked_light 1)" = light/spot ] || fail "the beam: $(grep ^picked beam.tsv)"
is 'about x' bent.tsv picked_direction 1 0
is 'by half a radian' bent.tsv picked_direction 2 0.5023
[ "$(field decal.tsv picked 1)/$(field decal.tsv picked_decal 1)" = decal/box ] || fail "the decal: $(grep ^picked decal.tsv)"
is 'its size' decal.tsv picked_size 2 0.4
is 'the decal along x' decal-moved.tsv picked_position 1 "$(awk 'BEGIN { print 0.3 + 10 * 6 * sin(0.45) / cos(0.45) / 180 }')"
picked 'no decal' no-decal.tsv nothing '' ''
picked 'Escape' nothing.tsv nothing '' ''

# ---- the panel of lights: what a light is, several at once, on and off ----

{ printf 'panel lights\nclick 0 lamp\nclick kind\nclick spot\nclick no range limit\nreport spot.tsv\n'
  printf 'key 341 down 2\nclick 1 beam\nkey 341 up 0\nclick casts shadows\nclick on\nreport off.tsv\nclick 0 lamp\nreport lamp-off.tsv\nclick on\nreport lamp-on.tsv\n'; } >panel.txt
replay panel scene.gltf --camera 0 --size 640x360 --scale 0.5
[ "$(field spot.tsv picked_light 1)" = spot ] || fail "its kind is $(field spot.tsv picked_light 1)"
[ "$(field spot.tsv picked_range 1)" != inf ] || fail 'its range is not its own'
picked 'the second light' off.tsv light 1 beam
is 'switched off' off.tsv picked_intensity 1 0
picked 'the first light' lamp-off.tsv light 0 lamp
is 'switched off with the other' lamp-off.tsv picked_intensity 1 0
is 'as bright as before' lamp-on.tsv picked_intensity 1 20
{ printf 'panel lights\nclick 0 lamp\nkey 341 down 2\nclick 1 beam\nkey 341 up 0\nclick on\n'; key $Z 2; printf 'report back.tsv\nclick 0 lamp\nreport lamp-back.tsv\n'; } >together.txt
replay together scene.gltf --camera 0 --size 640x360 --scale 0.5
is 'undone' back.tsv picked_intensity 1 20
is 'undone with the other' lamp-back.tsv picked_intensity 1 20

# ---- an orthographic camera: 30 pixels a metre ----

{ key $L; pick 100 45; drag 112 45 127 45; drag 115 33 115 18; drag 115 30 115 15; echo report parallel.tsv; } >parallel.txt
replay parallel scene.gltf --camera 1 --size 200x120 --no-panels
for axis in '1 0.5' '2 1' '3 1.5'; do is 'parallel' parallel.tsv picked_position $axis; done

# Of two pictures side by side the left one has icons and handles; objects are picked from either.
{ echo compare side; key $L; pick 100 45; echo report left.tsv; drag 112 45 127 45; echo report left-moved.tsv; pick 310 62; echo report right-board.tsv; } >side.txt
replay side scene.gltf --camera 1 --size 400x120 --no-panels
picked 'in the left picture' left.tsv light 0 lamp
is 'in the left picture' left-moved.tsv picked_position 1 0.5
picked 'in the right picture' right-board.tsv object 0 board

# ---- icons that overlap: the one in front, though it is the second light, wherever it is drawn ----
# The lights are at 4 and 2 meters; the farther icon is 6 pixels to the left, and picked where only it is drawn.

sed -e 's/"translation": \[0, 0.5, 2\]/"translation": [-0.0644073, 0, 2]/; s/"translation": \[-0.5, 0.9, 2\]/"translation": [0, 0, 4]/' scene.gltf >stack.gltf
{ key $L; for x in 320 316 313 325; do pick $x 180; echo "report stack-$x.tsv"; done; } >stack.txt
replay stack stack.gltf --camera 0 --size 640x360 --no-panels
for x in 320 316 325; do picked "at $x, in front" stack-$x.tsv light 1 beam; done
picked 'beside it, behind' stack-313.tsv light 0 lamp

# ---- more lights than icons ----

{ key $L; echo report many.tsv; } >many.txt
replay many 'builtin:onetile?lights=2200' --size 64x36 --no-panels --lists clustered
[ "$(field many.tsv icons 1)" = 2048 ] || fail "$(field many.tsv icons 1) icons of 2200 lights"
[ $failures = 0 ] && echo 'all checks of picking and editing passed'
exit $((failures > 0))
