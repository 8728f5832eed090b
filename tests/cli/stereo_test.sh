#!/bin/bash
# SPDX-License-Identifier: MIT
# Two eyes on the command line: how pictures are put together, headsets from files, and what is wrong with these.
# Usage: stereo_test.sh FANAL FOLDER
set -eu
fanal=$1
mkdir -p "$2" && cd "$2" && rm -rf ./*
fail() { echo "stereo: $*" >&2; exit 1; }
draw() { "$fanal" render builtin:onetile --size 33x21 --shading deferred --lists tiled --exposure 4 --frames 0 -q "$@" || fail "render $*"; }
# Bytes of a picture without a header.
raw() { draw --frames 1 --format raw -o - "$@"; }

# ---- one below the other, beside one another, mixed ----
raw --stereo left >left.raw; raw --stereo right >right.raw
[ "$(stat -c %s left.raw)" = $((33 * 21 * 4)) ] || fail "the picture of an eye has another size"
cmp -s left.raw right.raw && fail "both eyes see the same"
raw --stereo top-bottom | cmp - <(cat left.raw right.raw) || fail "top-bottom is not left, then right"
raw --stereo side-by-side >both.raw
raw --stereo side-by-side --stereo-path instances | cmp - both.raw || fail "instances draw another picture"
for y in 0 7 20; do
    cmp <(tail -c +$((y * 264 + 1)) both.raw | head -c 132) <(tail -c +$((y * 132 + 1)) left.raw | head -c 132) || fail "row $y, left"
    cmp <(tail -c +$((y * 264 + 133)) both.raw | head -c 132) <(tail -c +$((y * 132 + 1)) right.raw | head -c 132) || fail "row $y, right"
done
channels() { od -An -v -t u1 -w4 "$1" | awk "{ print $2 }"; }
raw --stereo anaglyph >anaglyph.raw
diff <(channels anaglyph.raw '$1') <(channels left.raw '$1') >/dev/null || fail "red of an anaglyph is the left eye's"
diff <(channels anaglyph.raw '$2 " " $3') <(channels right.raw '$2 " " $3') >/dev/null || fail "green and blue are the right eye's"
raw --stereo side-by-side --ipd 0 2>/dev/null >same.raw
cmp <(head -c 132 same.raw) <(tail -c +133 same.raw | head -c 132) || fail "eyes at one place see different things"

# ---- files ----
draw --stereo layers -o eye-%d.png
draw --stereo left -o left.png
cmp eye-0.png left.png || fail "layer 0 is the left eye"
[ -e eye-1.png ] || fail "layer 1 is missing"
draw --stereo side-by-side -o both.exr --aov depth,position
draw --stereo anaglyph -o one.exr --aov depth
"$fanal" compare one.exr both.exr >/dev/null 2>&1 && fail "an anaglyph is as wide as one eye"

# ---- a headset, whose head moves ----
cat >head.json <<'JSON'
{"name": "test", "resolution": [40, 32], "eyes": [
  {"tangents": [-1.2, 0.8, -1, 1], "position": [-0.03, 0, 0], "hidden": [[-1.2, -1], [-1, -1], [-1.2, -0.8]]},
  {"degrees": [-38.66, 50.19, -45, 45], "position": [0.03, 0, 0], "cant": 4, "lens": {"red": [0.1], "green": [0.1, 0.2], "blue": [0.3]}}],
 "poses": [{"time": 0}, {"time": 1, "position": [0, 0, 0.5], "rotation": [0, 0.0871557, 0, 0.9961947]}]}
JSON
"$fanal" render builtin:onetile --stereo layers --hmd head.json --frames 0 -q --exposure 4 -o hmd-%d.png
file hmd-0.png | grep -q "40 x 32" || fail "the size of the headset"
moved() { draw --stereo left --hmd head.json --time "$1" -o "$2"; }
moved 0 t0.png; moved 0.5 t1.png; moved 1 t2.png; moved 9 t3.png
cmp -s t0.png t1.png && fail "the head does not move"
cmp -s t1.png t2.png && fail "the head does not move on"
cmp t2.png t3.png || fail "the head goes on after its last pose"
"$fanal" render builtin:onetile --stereo side-by-side --hmd head.json --frames 2 --frame-time 0.5 --exposure 4 -q -o walk-%d.png
cmp -s walk-0.png walk-1.png && fail "a sequence stands still"
for name in simple asymmetric canted; do draw --stereo side-by-side --hmd builtin:$name -o $name.png; done

# ---- the eyes move ----
for gaze in '-0.4, 0.2, -1' '0.4, 0, -1'; do
    echo '{"resolution": [40, 32], "ipd": 0.06, "eyes": [{"tangents": [-1, 1, -1, 1]}, {"tangents": [-1, 1, -1, 1]}],
           "poses": [{"time": 0, "gaze": ['"$gaze"'], "rotation": [0, 0.0871557, 0, 0.9961947]}, {"time": 1, "gaze": [0, 0, -2]}]}' >gaze.json
    fovea() { draw --shading coarse --set coarse.size=4 --set coarse.fovea=9 --set coarse.fovea-far=16 --debug coarse --stereo left --hmd gaze.json "$@"; }
    # The middle of the pixels that are shaded each, which the view shows in magenta.
    middle() {
        fovea --time "$1" --size 40x32 --frames 1 --format raw -o - | od -An -v -t u1 -w4 |
            awk '$1 > $2 + 40 && $3 > $2 + 40 { x += (NR - 1) % 40 + 0.5; y += int((NR - 1) / 40) + 0.5; n++ } END { printf "%d %d\n", x / n, y / n }'
    }
    middle 0; middle 1
done >middles
# tangents 1 to a half of the picture; the eye is 3 cm beside the head
awk 'BEGIN { split("12 20 28 20", x); split("13 16 16 16", y) } ($1 - x[NR]) ^ 2 > 9 || ($2 - y[NR]) ^ 2 > 9 { bad = 1 } END { exit bad || NR != 4 }' middles ||
    { cat middles >&2; fail "the pixels that are shaded each are not where the eyes look"; }

# ---- what is wrong ----
refuse() { # MESSAGE ARGUMENTS...
    local message=$1; shift
    if "$fanal" render builtin:onetile --frames 0 --size 16x16 -o no.png "$@" 2>error; then fail "accepted: $*"; fi
    grep -qF -- "$message" error || { cat error >&2; fail "no '$message' for $*"; }
    [ ! -e no.png ] || fail "a picture in spite of $*"
}
bad() { printf '%s' "$2" >bad.json; refuse "bad.json$1" --stereo left --hmd bad.json; }
eyes='{"tangents":[-1,1,-1,1]},{"tangents":[-1,1,-1,1]}'
bad ':1:' '{"eyes":'
bad ': /eyes: must be' '{"ipd":0.06}'
bad ': /eyes/1: must have' '{"ipd":0.06,"eyes":[{"tangents":[-1,1,-1,1]},{}]}'
bad ': /eyes/0/tangents: left' '{"ipd":0.06,"eyes":[{"tangents":[1,-1,-1,1]},{}]}'
bad ': /eyes/0/tangents/2: must be a number' '{"ipd":0.06,"eyes":[{"tangents":[-1,1,"a",1]},{}]}'
bad ': /eyes/0/degrees/1: is 95' '{"ipd":0.06,"eyes":[{"degrees":[-1,95,-1,1]},{}]}'
bad ': /eyes/0/wide: is not known' '{"ipd":0.06,"eyes":[{"wide":1},{}]}'
bad ': /eyes/0: has no' "{\"eyes\":[$eyes]}"
bad ': /ipd: is -1' "{\"ipd\":-1,\"eyes\":[$eyes]}"
bad ': /poses/1: its time' "{\"ipd\":0.06,\"eyes\":[$eyes],\"poses\":[{\"time\":1},{\"time\":1}]}"
bad ': /poses/0/rotation: must be a unit' "{\"ipd\":0.06,\"eyes\":[$eyes],\"poses\":[{\"time\":1,\"rotation\":[0,0,0,0.5]}]}"
bad ': /poses/0/gaze: must be an array of 3' "{\"ipd\":0.06,\"eyes\":[$eyes],\"poses\":[{\"time\":1,\"gaze\":[0,0]}]}"
bad ': /eyes/0/hidden: must be' '{"ipd":0.06,"eyes":[{"tangents":[-1,1,-1,1],"hidden":[[0,0]]},{}]}'
bad ': /eyes/0/lens: has no' '{"ipd":0.06,"eyes":[{"tangents":[-1,1,-1,1],"lens":{"red":[1]}},{}]}'
bad ': /resolution: must be whole' "{\"ipd\":0.06,\"resolution\":[1.5,2],\"eyes\":[$eyes]}"
refuse 'nowhere.json' --stereo left --hmd nowhere.json
mkfifo pipe.json # nobody writes to it
mkdir folder.json
refuse 'pipe.json: cannot be read: it is a pipe' --stereo left --hmd pipe.json
refuse 'folder.json: cannot be read: it is a folder' --stereo left --hmd folder.json
refuse '/dev/zero: cannot be read: it is a device' --stereo left --hmd /dev/zero
refuse 'builtin:canted' --stereo left --hmd builtin:none
refuse '--ipd' --stereo left --ipd -1
refuse 'stereo.path' --stereo side-by-side --set multiview=off
refuse '--stereo-path' --stereo left --stereo-path both
refuse '--stereo' --stereo both
refuse 'belong to --stereo' --ipd 0.06
refuse 'cannot be combined' --stereo left --views cube
refuse '%d' --stereo layers
refuse '--fov' --stereo left --hmd builtin:simple --fov 50

# ---- comfort (VR-22) ----
lint() { "$fanal" render builtin:onetile --size 16x16 --frames 0 --stereo left -o lint.png "$@" 2>&1 >/dev/null; }
lint --ipd 0.03 | grep -q "52 to 78 mm: the world looks larger" || fail "VR-22: no warning about eyes 30 mm apart"
lint --ipd 0.09 | grep -q "smaller" || fail "VR-22: no warning about eyes 90 mm apart"
# No file of a headset scales the world, and no headset changes its field of view while it is shown: such members are not known.
bad ': /scale: is not known' "{\"ipd\":0.06,\"scale\":2,\"eyes\":[$eyes]}"
bad ': /eyes/0/scale: is not known' '{"ipd":0.06,"eyes":[{"tangents":[-1,1,-1,1],"scale":2},{}]}'
bad ': /poses/0/degrees: is not known' "{\"ipd\":0.06,\"eyes\":[$eyes],\"poses\":[{\"time\":1,\"degrees\":[-40,40,-40,40]}]}"
bad ': /poses/0/scale: is not known' "{\"ipd\":0.06,\"eyes\":[$eyes],\"poses\":[{\"time\":1,\"scale\":2}]}"
refuse 'world-scale' --stereo left --set world-scale=2
[ -z "$(lint --ipd 0.0635 | grep -i "mm apart")" ] || fail "VR-22: a warning about usual eyes"
echo "stereo: ok"
