#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# origin_test.sh FANAL: distant files render as they do near 0, 0, 0, and all positions are in the file's coordinates.
set -u
fanal=$1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failures=0
fail() { echo "FAILED: $*" >&2; failures=$((failures + 1)); }
size='--size 96x54'
say() { # FILE X Y Z [EXTRA]: a red triangle before a large one, a lamp and a camera, at this place; and one more root
    cat >"$work/$1" <<END
{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0${5:+, 5}]}],
 "extensionsUsed": ["KHR_lights_punctual"], "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 40, "range": 20}]}},
 "nodes": [{"children": [1, 2, 3, 4], "translation": [$2, $3, $4]}, {"mesh": 0}, {"mesh": 1, "translation": [0, -1, -1], "scale": [5, 5, 1]},
  {"translation": [-1, 2, 2], "extensions": {"KHR_lights_punctual": {"light": 0}}}, {"camera": 0, "translation": [0.2, 0.3, 3]}${5:+, $5}],
 "cameras": [{"type": "perspective", "perspective": {"yfov": 0.9, "znear": 0.1}}],
 "buffers": [{"byteLength": 36, "uri": "data:application/octet-stream;base64,AACAvwAAgL8AAAAAAACAPwAAgL8AAAAAAAAAAAAAgD8AAAAA"}],
 "bufferViews": [{"buffer": 0, "byteLength": 36}],
 "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [-1, -1, 0], "max": [1, 1, 0]}],
 "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [0.8, 0.2, 0.1, 1], "metallicFactor": 0}}],
 "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}, {"primitives": [{"attributes": {"POSITION": 0}}]}]}
END
}
same() { "$fanal" compare "$work/$1" "$work/$2" --max-diff 2/255 >"$work/log" 2>&1 || fail "$3: the pictures differ: $(cat "$work/log")"; }
picture() { # FILE OUT OPTION…
    local file=$1 out=$2
    shift 2
    "$fanal" render "$work/$file" $size --studio off --shadows off --ambient 0.2,0.2,0.2 --exposure 1 --msaa 1 --aa none -q -o "$work/$out" "$@" >"$work/log" 2>&1 || fail "$file is not rendered: $(cat "$work/log")"
}

say near.gltf 0 0 0
say far.gltf 6371000.3 -20000.1 3000000.7
# A planet: the triangle on its other side makes the scene so large that the file gets no origin.
say planet.gltf 6371000.3 -20000.1 3000000.7 '{"mesh": 0, "translation": [-6371000.3, 0, 0]}'

"$fanal" info "$work/near.gltf" | grep -q origin && fail 'a near file has an origin'
"$fanal" info "$work/planet.gltf" | grep -q origin && fail 'a planet has an origin'
"$fanal" info "$work/far.gltf" >"$work/info" || fail 'info'
grep -q 'origin       (6371008, -20000, 3000000)' "$work/info" || fail "info does not print the origin: $(cat "$work/info")"
grep -q 'to (6371005.3, -19996.1, 3000000.7)' "$work/info" || fail "info does not print the extent in file coordinates: $(cat "$work/info")"
grep -q 'at 6370999.300 -19998.100 3000002.700' "$work/info" || fail "info does not print the lamp's place: $(cat "$work/info")"
[ "$("$fanal" info "$work/far.gltf" --json | jq -c '[.origin, (.cameras[0].position | map(. * 10 | round / 10))]')" = \
    '[[6371008,-20000,3000000],[6371000.5,-19999.8,3000003.7]]' ] || fail 'info --json'

# The cameras of the file, the options and a path; the planet's two ends; a saved scene keeps its positions.
picture near.gltf near.png
picture planet.gltf planet.png --pixel 50,30 --stats "$work/stats.json"
same near.png planet.png 'the camera of planet.gltf'
jq -e '.pixel.position | (.[0] - 6371000.3 | fabs) < 2 and (.[1] + 20000.1 | fabs) < 2 and (.[2] - 3000000.7 | fabs) < 2' "$work/stats.json" >"$work/log" ||
    fail "--pixel: $(jq -c .pixel.position "$work/stats.json")"
jq -e '.view.camera.position | (.[0] - 6371000.5 | fabs) < 0.01' "$work/stats.json" >"$work/log" || fail "the camera of --stats: $(jq -c .view.camera "$work/stats.json")"
echo '0 0.6 0.3 2.5 -0.1 -0.2 0' >"$work/near.txt"
printf '0 -6371000.3 0.2 3 -6371000.3 0 0\n1 6371000.9 -19999.8 3000003.2 6371000.2 -20000.3 3000000.7\n' >"$work/far.txt"
picture near.gltf near-%d.png --camera-path "$work/near.txt" --frames 1
picture planet.gltf planet-%d.png --camera-path "$work/far.txt" --frames 2
same near-0.png planet-1.png '--camera-path in planet.gltf'
picture planet.gltf eye.png --eye 6371000.9,-19999.8,3000003.2 --look-at 6371000.2,-20000.3,3000000.7
same near-0.png eye.png '--eye in planet.gltf'
say other.gltf 12742000.6 0 0 '{"mesh": 0}'
picture other.gltf other.png --eye 0,0.2,3 --look-at 0,0,0
same other.png planet-0.png 'the other end of the planet'
"$fanal" render "$work/planet.gltf" -q --save-scene "$work/saved.glb" >"$work/log" 2>&1 || fail "--save-scene failed: $(cat "$work/log")"
picture saved.glb saved.png
same near.png saved.png 'the saved planet'
for file in near planet; do
    "$fanal" trace "$work/$file.gltf" $size --studio off --samples 4 -q -o "$work/t-$file.png" >"$work/log" 2>&1 || fail "trace: $(cat "$work/log")"
done
same t-near.png t-planet.png 'trace of the planet'
[ $failures = 0 ]
