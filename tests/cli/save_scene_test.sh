#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# save_scene_test.sh FANAL STAND_IN_FILE: what `fanal render --save-scene` writes gives the same picture, to the bit, and blended animations do what they say.
set -u
fanal=$1
stand_in=$2 # writes what replaces a missing sample
scenes=${FANAL_SCENES:-$(dirname "$0")/../../../shared/scenes}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failures=0
fail() { echo "FAILED: $*" >&2; failures=$((failures + 1)); }
picture() { # SOURCE FILE OPTION…
    local source=$1 file=$2
    shift 2
    "$fanal" render "$source" --size 96x54 --frames 0 -q -o "$file" "$@" 2>"$work/log" || fail "$source is not rendered: $(cat "$work/log")"
}
same() { "$fanal" compare "$1" "$2" --max-diff 0 >"$work/log" 2>&1 || fail "$3: another picture: $(cat "$work/log")"; }

check() { # SOURCE OPTIONS_OF_BOTH OPTION…: the others add to the scene
    local source=$1 both=$2
    shift 2
    "$fanal" render "$source" -q $both --save-scene "$work/scene.glb" "$@" 2>"$work/log" || { fail "$source is not saved: $(cat "$work/log")"; return; }
    picture "$source" "$work/a.png" $both "$@"
    picture "$work/scene.glb" "$work/b.png" $both
    same "$work/a.png" "$work/b.png" "$source $*"
}
eye='--eye 3,2.5,5 --look-at 0,1,0 --shadows off'
check builtin:spheres "$eye"
check 'builtin:hall?lights=40' "$eye"
check builtin:onetile "$eye" --lights 20 --light-shapes point,spot,capsule,wedge,box,rectangle --ambient 0.2,0.3,0.4 --background 0.1,0,0.3
check builtin:onetile "$eye" --environment builtin:sky --environment-rotation 40 --environment-intensity 0.5
check_sample() { # NAME OPTIONS_OF_BOTH
    local file=$scenes/$1
    if [ ! -e "$file" ]; then
        file=$work/sample.glb
        "$stand_in" "$1" "$file" || fail "nothing replaces $1"
    fi
    check "$file" "$2"
}
check_sample CesiumMan.glb '--time 0.7 --shadows off'
check_sample FlightHelmet/FlightHelmet.gltf '--shadows off --time 0'

# ---- what is refused leaves nothing behind ----

refused() { # WORDS OPTION…
    local words=$1
    shift
    "$fanal" render builtin:onetile "$@" >"$work/log" 2>&1 && fail "taken: $*"
    grep -q -e "$words" "$work/log" || fail "no word of '$words': $(cat "$work/log")"
}
refused "$work/none/x.glb" --save-scene "$work/none/x.glb"
refused 'ends in .glb' --save-scene "$work/x.gltf"
refused 'one file' --save-scene "$work/x.glb" -o "$work/x.png" --stats "$work/x.glb"
[ -e "$work/x.glb" ] && fail 'a refused command leaves a file'
cp "$work/scene.glb" "$work/x.glb" # it cannot be written over itself
"$fanal" render "$work/x.glb" --save-scene "$work/x.glb" >"$work/log" 2>&1 && fail 'the scene was written over itself'

# ---- several animations ----

cat >"$work/swing.gltf" <<'EOF'
{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
 "buffers": [{"byteLength": 68, "uri": "data:application/octet-stream;base64,AACAvwAAgL8AAAAAAACAPwAAgL8AAAAAAAAAAAAAgD8AAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAABAAAAAAAAAAAA="}],
 "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 8}, {"buffer": 0, "byteOffset": 44, "byteLength": 24}],
 "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [-1, -1, 0], "max": [1, 1, 0]},
  {"bufferView": 1, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [1]}, {"bufferView": 2, "componentType": 5126, "count": 2, "type": "VEC3"}],
 "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
 "animations": [{"name": "move", "samplers": [{"input": 1, "output": 2}], "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}]},
  {"name": "still", "samplers": [{"input": 1, "output": 2, "interpolation": "STEP"}], "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}]}]}
EOF
view='--eye 0,0,6 --look-at 0,0,0 --ambient 1,1,1 --exposure 0'
picture "$work/swing.gltf" "$work/a.png" $view --time 0.2 --animation move
picture "$work/swing.gltf" "$work/b.png" $view --time 0.4 --animation move:1,still:1
same "$work/a.png" "$work/b.png" 'half of one animation'
picture "$work/swing.gltf" "$work/b.png" $view --time 0.2 --animation move:0.5,1:0
same "$work/a.png" "$work/b.png" 'a weight of 0'
picture "$work/swing.gltf" "$work/b.png" $view --time 0.2 --animation move:1,still:3
"$fanal" compare "$work/a.png" "$work/b.png" --max-diff 0 >/dev/null 2>&1 && fail 'weights make no difference'
for bad in nothing move:x move:1,nothing:1 move:-1 move:0 move:1,,still:1; do
    "$fanal" render "$work/swing.gltf" --frames 0 -o "$work/c.png" --animation "$bad" >"$work/log" 2>&1 && fail "taken: --animation $bad"
    grep -q "$bad" "$work/log" || fail "no word of $bad"
done
[ $failures = 0 ]
