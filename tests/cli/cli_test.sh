#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The command as a user meets it: exit codes, messages, files. Usage: cli_test.sh FANAL
set -u
fanal=$1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export MESA_SHADER_CACHE_DIR=${MESA_SHADER_CACHE_DIR:-${XDG_CACHE_HOME:-${HOME:-$work}/.cache}} # what the driver has compiled stays
export XDG_CACHE_HOME="$work/cache" # what auto remembers starts empty
failures=0
fail() { echo "FAILED: $*" >&2; failures=$((failures + 1)); }

# expect STATUS PATTERN ARGUMENTS…: the status, and a line of stderr or stdout that matches.
expect() {
    local status=$1 pattern=$2 got
    shift 2
    "$fanal" "$@" >"$work/out" 2>&1
    got=$?
    [ $got = "$status" ] || fail "fanal $*: exit $got, not $status: $(head -c 300 "$work/out")"
    [ -z "$pattern" ] || grep -qE -- "$pattern" "$work/out" || fail "fanal $*: no line with '$pattern': $(head -c 300 "$work/out")"
}
absent() { for file in "$@"; do [ ! -e "$file" ] || fail "$file was left behind"; done; }
small="--size 64x36"
plain="$small --shadows off" # of pictures that shadows are not the subject of

expect 0 'fanal COMMAND' --help
expect 2 "error: --stats needs a value; '-q', which follows, is an option" render builtin:spheres --stats -q -o "$work/picture.png"
absent -- ./-q
expect 2 'no command .foo.' foo
expect 0 '^fanal [0-9]+\.[0-9]+\.[0-9]+$' --version
for command in render cave trace info devices compare; do expect 0 'Examples?:' $command --help; done

# Bad options name themselves; nothing is written.
expect 2 'one scene is needed' render -o "$work/a.png"
expect 2 'no output was asked for' render builtin:spheres
expect 2 "size: '12' is not a size" render builtin:spheres --size 12 -o "$work/a.png"
expect 2 "exposure: '65' is not auto, none, or an EV100 from -64 to 64" render builtin:spheres --exposure 65 -o "$work/a.png"
expect 2 "--shading is 'x', must be one of forward, forward-prepass, deferred" render builtin:spheres --shading x -o "$work/a.png"
expect 2 "--lists is 'x', must be one of brute-force, tiled" render builtin:spheres --lists x -o "$work/a.png"
expect 2 "--msaa is 3, must be 1, 2, 4 or 8" render builtin:spheres --msaa 3 -o "$work/a.png"
expect 2 "--aa is 'x', must be one of none, mlaa, smaa, taa" render builtin:spheres --aa x -o "$work/a.png"
expect 2 'supersample and --aa taa cannot be combined' render builtin:spheres --supersample 4 --aa taa -o "$work/a.png"
expect 2 'each output of a sequence' render builtin:spheres -o "$work/a-%s.png"
expect 2 'each output of a sequence' render builtin:spheres -o "$work/a-%d-%d.png"
expect 2 "pixel: '3' is not a pixel" render builtin:spheres --pixel 3
expect 2 "pixel: '3,-4' is not a pixel" render builtin:spheres --pixel 3,-4
expect 2 'pixel is outside of the picture' render builtin:onetile $plain --pixel 64,0
expect 2 'pixel.view is 1, must be 0 .. 0' render builtin:onetile $plain --pixel 3,4,1 --frames 0
expect 2 'pixel is for single pictures' render builtin:spheres --pixel 3,4 -o "$work/a-%d.png"
expect 2 'frame-time is for sequences' render builtin:spheres --frame-time 0.1 -o "$work/a.png"
expect 2 "--tonemap is 'x'" render builtin:spheres --tonemap x -o "$work/a.png"
expect 2 "exposure: 'bright'" render builtin:spheres --exposure bright -o "$work/a.png"
expect 2 'ends in .png or .exr' render builtin:spheres -o "$work/a.jpg"
expect 2 'belong together' render builtin:spheres --eye 1,2,3 -o "$work/a.png"
expect 2 'camera.target is the position, must be another point' render builtin:spheres $plain --eye 1,2,3 --look-at 1,2,3 -o "$work/a.png"
expect 2 'aov needs an .exr' render builtin:spheres --aov depth -o "$work/a.png"
expect 2 "error: there is no option '--nonsense'; see 'fanal render --help'" render builtin:spheres --nonsense -o "$work/a.png"
expect 2 'nowhere' render builtin:nowhere -o "$work/a.png"
expect 2 'camera' render builtin:spheres --camera nobody $plain -o "$work/a.png"
expect 2 'animation' render builtin:spheres --animation 7 $plain -o "$work/a.png"
expect 2 'missing.gltf: cannot be opened' render "$work/missing.gltf" -o "$work/a.png"
echo '{"asset": {"version": "2.0"' >"$work/cut.gltf"
expect 2 'cut.gltf' render "$work/cut.gltf" -o "$work/a.png"
expect 2 'mobile shading has no MSAA' render builtin:spheres $plain --shading mobile --msaa 4 -o "$work/a.png"
expect 2 "set: coarse.tolerance is 2, must be 0 .. 1" render builtin:spheres $plain --set coarse.tolerance=2 -o "$work/a.png"
expect 2 'visibility.grid needs 1 sample' render builtin:spheres $plain --shading visibility --set visibility.grid=on --msaa 4 -o "$work/a.png"
expect 2 'gbuffer, normals and chroma are of deferred' render builtin:spheres $plain --shading coarse --gbuffer siege -o "$work/a.png"
absent "$work"/a.*
expect 2 'one scene is needed' trace -o "$work/a.png"
expect 2 'no output was asked for' trace builtin:spheres
expect 2 'ends in .png or .exr' trace builtin:spheres -o "$work/a.jpg"
expect 2 'aov needs an .exr' trace builtin:spheres --aov visibility -o "$work/a.png"
expect 2 "aov: 'depth' is not one of visibility" trace builtin:spheres --aov depth -o "$work/a.exr"
expect 2 "samples: '0' is not a whole number from 1" trace builtin:spheres --samples 0 -o "$work/a.png"
expect 2 "shadows: 'soft' is not one of off on" trace builtin:spheres --shadows soft -o "$work/a.png"
expect 2 "light-radius: '-1' is not a length" trace builtin:spheres --light-radius -1 -o "$work/a.png"
expect 2 "sun-angle: '90' is not an angle" trace builtin:spheres --sun-angle 90 -o "$work/a.png"
expect 2 'belong together' trace builtin:spheres --eye 1,2,3 -o "$work/a.png"
expect 2 'would be written twice' trace builtin:spheres -o "$work/a.png" -o "$work/./a.png"
expect 2 'nowhere' trace builtin:nowhere -o "$work/a.png"
expect 2 'cannot be written|cannot be opened|No such file' trace builtin:spheres $small -o "$work/a.png" -o "$work/none/b.exr"
absent "$work"/a.* "$work"/none

# A picture of rays is that of a frame; the same bytes for any number of threads; Ctrl-C leaves what was traced.
expect 0 '64 x 36, 1 sample, 0 bounces: [0-9]+ rays' trace builtin:spheres $small --ambient 1,1,1 --shadows off --exposure 5 -o "$work/trace.png" -o "$work/trace.exr" --aov visibility
expect 0 '' render builtin:spheres $plain --ambient 1,1,1 --msaa 1 --aa none --exposure 5 --frames 0 -q -o "$work/frame.png"
expect 0 'psnr' compare "$work/trace.png" "$work/frame.png" --psnr 40
for threads in 1 3; do expect 0 '' trace builtin:spheres $small --samples 3 --bounces 2 --threads $threads -q -o "$work/threads-$threads.exr"; done
cmp -s "$work/threads-1.exr" "$work/threads-3.exr" || fail 'three threads trace another picture than one'
[ ! -s "$work/out" ] || fail 'trace -q prints something'
"$fanal" trace builtin:spheres $small --samples 1000000 --bounces 4 -o "$work/ended.png" >"$work/out" 2>&1 &
traced=$!
for _ in $(seq 6000); do [ $((0x$(awk '$1 == "SigCgt:" { print $2 }' /proc/$traced/status) & 2)) != 0 ] && break; sleep 0.1; done # until it listens
sleep 1
kill -INT $traced
wait $traced
[ $? = 130 ] && grep -q 'interrupted' "$work/out" || fail "trace does not end by Ctrl-C: $(head -c 300 "$work/out")"
expect 0 '' compare "$work/ended.png" "$work/ended.png"

# The cache folder is the user's unless it is not wanted.
rm -f "$XDG_CACHE_HOME"/fanal/pipelines-* # of the commands above, which failed after they had made a device
expect 0 '' render builtin:spheres $plain --no-cache -o "$work/no-cache.png"
absent "$XDG_CACHE_HOME"/fanal/pipelines-*
expect 0 '' render builtin:spheres $plain -o "$work/cache.png"
ls "$XDG_CACHE_HOME"/fanal/pipelines-* >/dev/null 2>&1 || fail "no pipelines were kept in $XDG_CACHE_HOME"
cmp -s "$work/no-cache.png" "$work/cache.png" || fail "the picture without a cache is another"

# Files from strangers: what they require, which files they read, and how much memory, in every command that loads.
mkdir "$work/place"
asset='"asset": {"version": "2.0"}'
echo "{$asset, \"extensionsUsed\": [\"KHR_materials_pbrSpecularGlossiness\"], \"extensionsRequired\": [\"KHR_materials_pbrSpecularGlossiness\"]}" >"$work/place/requires.gltf"
echo "{$asset, \"extensionsUsed\": [\"KHR_materials_variants\"], \"extensions\": {\"KHR_materials_variants\": {\"variants\": [{\"name\": \"y\"}]}}}" >"$work/place/variants.gltf"
echo "{$asset, \"buffers\": [{\"byteLength\": 4, \"uri\": \"nowhere.bin\"}]}" >"$work/place/missing.gltf"
echo "{$asset, \"buffers\": [{\"byteLength\": 4, \"uri\": \"../cut.gltf\"}]}" >"$work/place/outside.gltf"
echo "{$asset, \"buffers\": [{\"byteLength\": 4, \"uri\": \"data:application/octet-stream;base64,AAAAAAAA\"}]}" >"$work/place/inside.gltf"
for command in "render $plain --lists all -o $work/a.png" "bench --sizes 64x36 --shading forward --lists brute --frames 1 --warm-up 0 -o $work/strangers" info; do
    # shellcheck disable=SC2086
    {
        expect 2 'requires.gltf: /extensionsRequired/0: .*KHR_materials_pbrSpecularGlossiness' $command "$work/place/requires.gltf"
        expect 2 'missing.gltf: /buffers/0/uri: .*nowhere.bin: cannot be opened' $command "$work/place/missing.gltf"
        expect 2 "outside.gltf: /buffers/0/uri: '../cut.gltf' is outside" $command "$work/place/outside.gltf" --confine
        expect 2 'inside.gltf: /buffers/0/uri: needs 9 bytes of memory; of the limit of 8' $command "$work/place/inside.gltf" --max-memory 8
        expect 2 "max-memory: '1T' is not a number of bytes" $command "$work/place/inside.gltf" --max-memory 1T
        expect 2 "variant: the scene has no variant 'x'; it has 0 'y'" $command "$work/place/variants.gltf" --variant x
        absent "$work/a.png" "$work/strangers"
        expect 0 '' $command "$work/place/requires.gltf" --lenient
        rm -rf "$work/a.png" "$work/strangers"
    }
done
expect 2 "variant: the scene has no variant 'x'; it has 0 'y'" trace $plain "$work/place/variants.gltf" --variant x -o "$work/a.png"
expect 0 "is outside of the file's folder; it is read all the same" info "$work/place/outside.gltf"
expect 0 '' info "$work/place/inside.gltf" --max-memory 1K --confine

# An output that cannot be written leaves none of its siblings behind.
expect 2 'cannot be written' render builtin:spheres $plain -o "$work/a.png" -o "$work/none/b.exr"
absent "$work/a.png" "$work"/*part*
expect 2 'cannot be written' render builtin:spheres $plain -o "$work/a.png" --stats "$work/none/s.json"
absent "$work/a.png"

# What was printed and did not arrive is an error, and then nothing is written; a stream that is closed lends its number to no file.
for arguments in --help --version 'render --help' 'bench --help' 'render --options' 'info builtin:spheres' 'info builtin:spheres --json' \
    'info --gbuffers' devices 'devices --json' "render builtin:spheres $plain --lists all -o $work/a.png --stats $work/a.json" \
    "render builtin:spheres $plain --lists all --plan"; do
    # shellcheck disable=SC2086
    "$fanal" $arguments >/dev/full 2>"$work/out"
    [ $? = 2 ] && grep -q 'standard output cannot be written' "$work/out" || fail "fanal $arguments says nothing of a full disk"
    # shellcheck disable=SC2086
    "$fanal" $arguments >&- 2>"$work/out"
    [ $? = 2 ] && grep -q 'standard output cannot be written' "$work/out" || fail "fanal $arguments says nothing of a closed output"
done
absent "$work"/a.* "$work"/*part*
"$fanal" render builtin:spheres $plain --lists all -q -o "$work/a.png" >&- 2>/dev/null || fail 'a quiet command needs no output'
"$fanal" compare "$work/a.png" "$work/a.png" >/dev/full 2>&1
[ $? = 2 ] || fail 'compare says nothing of a full disk'
rm "$work/a.png"

# No file is written twice, by whatever name, nor in place of the scene.
mkdir "$work/folder"
ln -s folder "$work/other"
ln -s new.png "$work/folder/link.png"
twice='are one file, which would be written twice'
expect 2 "$twice" render builtin:spheres $plain -o "$work/a.png" -o "$work/a.png"
expect 2 "$twice" render builtin:spheres $plain -o "$work/folder/a.png" -o "$work/other/../folder/./a.png"
expect 2 "$twice" render builtin:spheres $plain -o "$work/folder/new.png" -o "$work/other/link.png"
expect 2 "$twice" render builtin:spheres $plain -o "$work/a.png" -o "$work/b.exr" --stats "$work/b.exr"
expect 2 "$twice" render builtin:spheres $plain --frames 2 -o "$work/a-%d.png" -o "$work/a-%02d.png"
cp "$work/cut.gltf" "$work/scene.gltf"
expect 2 'the scene would be overwritten' render "$work/scene.gltf" $plain --stats "$work/folder/../scene.gltf"
cmp -s "$work/cut.gltf" "$work/scene.gltf" || fail 'the scene was overwritten'
absent "$work"/a* "$work/b.exr" "$work"/folder/*.png

# What is replaced keeps its mode, and a link stays one.
touch "$work/folder/new.png" "$work/folder/numbers"
chmod 640 "$work/folder/new.png" "$work/folder/numbers"
ln -s folder/numbers "$work/numbers"
expect 0 '' render builtin:spheres $plain --lists all -q -o "$work/folder/link.png" --stats "$work/numbers"
for file in new.png numbers; do [ "$(stat -c %a "$work/folder/$file")" = 640 ] && [ -s "$work/folder/$file" ] || fail "$file has another mode"; done
[ -L "$work/numbers" ] && [ -L "$work/folder/link.png" ] || fail 'a link was replaced'

# Pipes are no scenes and no pictures, and nobody waits for what they might hold.
mkfifo "$work/pipe.glb" "$work/pipe.png" "$work/pipe.bin"
ln -s /dev/null "$work/null.png"
echo '{"asset":{"version":"2.0"},"buffers":[{"uri":"pipe.bin","byteLength":4}]}' >"$work/pipe.gltf"
patient=$fanal fanal=$work/impatient
printf '#!/bin/sh\nexec timeout 900 %s "$@"\n' "'$patient'" >"$fanal"
chmod +x "$fanal"
expect 2 'pipe.glb: is a pipe, not a regular file' info "$work/pipe.glb"
expect 2 'pipe.png: is a pipe, not a regular file' compare "$work/pipe.png" "$work/pipe.png"
expect 2 'buffers/0/uri: .*pipe.bin: is a pipe, not a regular file' info "$work/pipe.gltf"
expect 2 'folder: is a folder without a scene' info "$work/folder"
expect 2 'pipe.png: cannot be written: it is a pipe' render builtin:spheres $plain --lists all -o "$work/pipe.png"
expect 2 'null.png: cannot be written: it is a device' render builtin:spheres $plain --lists all -o "$work/null.png"
fanal=$patient
[ -p "$work/pipe.png" ] && [ -c /dev/null ] || fail 'a picture took the place of a pipe'

# Settings of another order are harmless, but not passed over in silence.
expect 0 'coarse.size has no effect with --shading deferred' render builtin:spheres $plain --lists all --set coarse.size=4 -o "$work/unused.png"
expect 0 'occlusion has no effect with --shading low-res' render builtin:spheres $plain --lists all --shading low-res --occlusion on -o "$work/unused.png"
expect 0 '' render builtin:spheres $plain --lists all --set coarse.size=4 -q -o "$work/unused.png"
[ ! -s "$work/out" ] || fail 'a quiet command warns'

# Collected frames come near the mean of as many; a sequence has a picture for each frame, and its names are what was asked for.
expect 0 '' render builtin:spheres $plain --lists clustered --supersample 16 -q -o "$work/mean.png"
expect 0 '' render builtin:spheres $plain --lists clustered --aa taa -q -o "$work/taa.png"
expect 0 '' compare "$work/mean.png" "$work/taa.png" --mean-diff 1/255
expect 0 '' render builtin:spheres $plain --lists clustered --aa smaa -q -o "$work/smaa.png" -o "$work/motion.exr" --aov motion
expect 0 '' render builtin:spheres $plain --lists clustered --frames 3 --frame-time 0.1 -q -o "$work/walk-%03d.png"
for i in 0 1 2; do [ -s "$work/walk-00$i.png" ] || fail "picture $i of a sequence is missing"; done
absent "$work/walk-003.png"

# Several views in one frame: one picture each, the very bytes of frames with one camera.
cat >"$work/cameras.gltf" <<'END'
{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1, 2]}],
 "nodes": [{"mesh": 0}, {"camera": 0, "translation": [0, 0, 3]}, {"camera": 1, "translation": [0.5, 0.2, 6]}],
 "cameras": [{"name": "near", "type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}},
  {"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}}],
 "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
 "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [-1, -1, 0], "max": [1, 1, 0]}],
 "bufferViews": [{"buffer": 0, "byteLength": 36}],
 "buffers": [{"byteLength": 36, "uri": "data:application/octet-stream;base64,AACAvwAAgL8AAAAAAACAPwAAgL8AAAAAAAAAAAAAgD8AAAAA"}]}
END
expect 0 '2 views' render "$work/cameras.gltf" $plain --lists tiled --views near,1 -o "$work/view-%d.png" -o "$work/view-%02d.exr"
for i in 0 1; do
    expect 0 '' render "$work/cameras.gltf" $plain --lists tiled --camera $i -q -o "$work/camera.png" -o "$work/camera.exr"
    cmp -s "$work/view-$i.png" "$work/camera.png" && cmp -s "$work/view-0$i.exr" "$work/camera.exr" || fail "view $i is not what its camera sees"
done
cmp -s "$work/view-0.png" "$work/view-1.png" && fail 'two cameras see the same'
expect 0 '' render "$work/cameras.gltf" $plain --lists tiled --views all -q -o "$work/all-%d.png" -o "$work/all-%d.exr"
cmp -s "$work/all-0.png" "$work/view-0.png" && cmp -s "$work/all-1.png" "$work/view-1.png" || fail '--views all is not the cameras of the scene'
expect 0 '' render builtin:spheres --size 24x24 --shadows off --lists tiled --exposure 4 --eye 0,1,0 --look-at 1,1,0 --views cube -q -o "$work/face%d.png"
expect 0 '' render builtin:spheres --size 24x24 --shadows off --lists tiled --exposure 4 --eye 0,1,0 --look-at 0,1,-1 --fov 90 -q -o "$work/front.png"
cmp -s "$work/face5.png" "$work/front.png" || fail 'the last face of a cube is not its front'
absent "$work/face6.png"
expect 2 'faces of --views cube are square' render builtin:spheres $plain --views cube -o "$work/f%d.png"
expect 2 'each output of --views has one' render builtin:spheres $plain --views all -o "$work/f.png"
sed 's/"cameras"/"extras"/; s/"camera": [01], //g' "$work/cameras.gltf" >"$work/blind.gltf"
expect 2 "--views: the scene has no camera 'nope'; it has 0 .'near'., 1 .'camera1'.\$" render "$work/cameras.gltf" $plain --views near,nope -o "$work/f%d.png"
expect 2 "--camera: the scene has no camera '2'; it has 0 .'near'., 1 .'camera1'.\$" render "$work/cameras.gltf" $plain --camera 2 -o "$work/f.png"
expect 2 "--views: the scene has no camera 'nope'; it has no cameras\$" render "$work/blind.gltf" $plain --views nope -o "$work/f%d.png"
expect 2 'the scene has no cameras' render "$work/blind.gltf" $plain --views all -o "$work/f%d.png"
expect 2 'light_lod takes one view' render "$work/cameras.gltf" $plain --views all --set light-lod=2 -o "$work/f%d.png"
expect 2 'virtual-texturing shading takes one view' render "$work/cameras.gltf" $plain --views all --shading virtual-texturing -o "$work/f%d.png"
expect 2 'do not go with --views' render "$work/cameras.gltf" $plain --views all --camera 0 -o "$work/f%d.png"
absent "$work/f0.png" "$work/f%d.png"

# The main job, twice: equal bytes; every output at once; numbers that are there.
expect 0 'light evaluations' render builtin:spheres $plain --lists clustered -o "$work/a.png" -o "$work/a.exr" --aov depth,normal,albedo,roughness,id,position,object --stats "$work/a.json" --frames 2
expect 0 '' render builtin:spheres $plain -o "$work/b.png" -o "$work/b.exr" --aov depth,normal,albedo,roughness,id,position,object --quiet
cmp -s "$work/a.png" "$work/b.png" || fail 'two runs gave different PNG bytes'
cmp -s "$work/a.exr" "$work/b.exr" || fail 'two runs gave different EXR bytes'
# No picture depends on what is written beside it, single or in a sequence, averaged or not.
for options in '' '--supersample 2' '--frames 2 --camera-path orbit:4'; do
    number=0
    [ "${options#--frames}" = "$options" ] || number=%d
    for outputs in png exr 'png exr'; do
        files=
        for kind in $outputs; do files="$files -o $work/beside-${#outputs}-$number.$kind"; done
        expect 0 '' render 'builtin:glass?lights=20' $plain --msaa 1 --aa none $options -q $files
    done
    for kind in png exr; do cmp -s "$work/beside-3-0.$kind" "$work/beside-7-0.$kind" || fail "another .$kind beside it changes a .$kind ($options)"; done
done
# The picture alone: the same bytes, a line that says how long it took, no table.
expect 0 '[0-9.]+ s for the frame on ' render builtin:spheres $plain --lists clustered --frames 0 -o "$work/alone.png"
grep -qE 'evaluations|median' "$work/out" && fail '--frames 0 counts and measures'
expect 0 '' render builtin:spheres $plain --lists clustered --frames 2 -q -o "$work/timed.png"
cmp -s "$work/alone.png" "$work/timed.png" || fail '--frames 0 gave other bytes'
expect 2 'frames 0 cannot be combined' render builtin:spheres $plain --frames 0 --stats "$work/none.json" -o "$work/none.png"
absent "$work/none.json" "$work/none.png"
expect 0 'lights: 1 \(#472877\) to 256 and more \(#fde725\): lights that' render builtin:onetile $plain --lists all --debug lights -o "$work/m.png"
# memory KIND: what the last statistics say of it.
memory() { sed -n "s/^ *\"$1\": \([0-9]*\),*$/\1/p" "$work/memory.json"; }
expect 0 '' render builtin:onetile $plain --shadows off -o "$work/m.png" --stats "$work/memory.json"
[ "$(memory shadows)" = 0 ] && [ "$(memory history)" = 0 ] || fail 'without shadows and history there is memory for them'
expect 0 '' render builtin:onetile $plain --shadows maps --aa taa -o "$work/m.png" --stats "$work/memory.json"
[ "$(memory shadows)" -gt 1000000 ] && [ "$(memory history)" -gt 10000 ] || fail 'shadow maps and history take no memory'
cmake -DSTATS="$work/a.json" -P "$(dirname "$0")/check_stats.cmake" || fail 'the stats are not as documented'
# A pipe or a device stays one.
mkfifo "$work/pipe"
timeout 900 cat "$work/pipe" >"$work/piped.json" &
expect 0 '' render builtin:spheres $plain --lists all -o "$work/piped.png" --stats "$work/pipe"
wait $!
[ -p "$work/pipe" ] && grep -q '"shading"' "$work/piped.json" || fail 'stats do not go through a pipe'
expect 0 'auto: (fastest of|likely the best)|auto has not decided' render builtin:spheres $plain --lists auto --frames 2 -o "$work/b.png" -o "$work/b.exr"
grep -q 'auto: fastest' "$work/out" && { grep -qE '^  \* deferred +[a-z0-9.-]+ +[0-9.]+ ms, [0-9] frames?$' "$work/out" || fail 'what auto measured is not told'; }
cmp -s "$work/a.png" "$work/b.png" || fail 'the lists that auto took gave other bytes'
expect 0 'auto: (remembered|likely|fastest of)|auto has not decided' render builtin:spheres $plain --verbose -o "$work/b.png"
expect 0 'auto has not decided within 0 s' render builtin:spheres --size 33x19 --shadows off --lists auto --choose-seconds 0 --frames 2 -o "$work/c.png"
expect 2 "choose-seconds: '-1' is not" render builtin:spheres --choose-seconds -1 -o "$work/c.png"
expect 2 "set: there is no option 'tiles'" render builtin:spheres --set tiles=3 -o "$work/b.png"
expect 2 "set: tiles.size is 24, must be 8, 16, 32 or 64" render builtin:spheres --set tiles.size=24 -o "$work/b.png"
expect 2 'clusters.far is 3, must be above 9 metres' render builtin:spheres --set clusters.near=9 --set clusters.far=3 -o "$work/b.png"
expect 0 'clusters.size=64' render --options
expect 0 '"key": "clusters.size"' render --options --json
expect 2 'belong to --options' render --json
expect 0 'tiles.size has no effect with --lists clustered' render builtin:spheres $plain --lists clustered --set tiles.size=8 -o "$work/unused.png"
expect 2 "set: 'tiles.size' is not KEY=VALUE" render builtin:spheres --set tiles.size -o "$work/b.png"
expect 2 "set: clusters.near is '1e99', must be a number or auto" render builtin:spheres --set clusters.near=1e99 -o "$work/b.png"
expect 2 'mesh lists do not work with deferred' render builtin:spheres --lists mesh -o "$work/b.png"
expect 2 "set: deferred.class-blocks is 5, must be 0, 4 or 8" render builtin:spheres --set deferred.class-blocks=5 -o "$work/b.png"
expect 0 'tonemap' render builtin:spheres $plain --plan
expect 0 '"name":"tonemap","queue":"graphics"' render builtin:spheres $plain --plan=json
expect 2 "plan.*xml" render builtin:spheres $plain --plan=xml
expect 2 'cannot be combined' render builtin:spheres $plain -o a.png --trace-file a.trace --supersample 2
expect 2 'cannot write to stdout' render builtin:spheres $plain -o a.png --trace-file -
expect 0 'size' compare "$work/a.png" "$work/b.png"
expect 1 'max-diff|max' compare "$work/a.png" "$work/a.exr" --max-diff 0
expect 2 'missing.png' compare "$work/a.png" "$work/missing.png"
expect 0 '"usable"' devices --json
expect 0 'triangles' info builtin:spheres
expect 0 '"triangle' info builtin:spheres --json
expect 2 'cut.gltf' info "$work/cut.gltf"

# Shadows, unless they are switched off or there are no lights.
scene="builtin:spheres?lights=5"
expect 0 '' render "$scene" $small -q -o "$work/shadows.png" --stats "$work/shadows.json"
sed -n '/^ *"shadows": {/,/}/p' "$work/shadows.json" | grep -qE '"wanted": *[1-9]' || fail 'a scene with lights has no shadow maps'
expect 0 '' render "$scene" $small --shadows maps --frames 0 -q -o "$work/shadows-maps.png"
expect 0 '' render "$scene" $plain --frames 0 -q -o "$work/shadows-off.png"
cmp -s "$work/shadows.png" "$work/shadows-maps.png" || fail 'a picture has other shadows than those of maps'
cmp -s "$work/shadows.png" "$work/shadows-off.png" && fail 'a scene with lights casts no shadows'
expect 0 '' render "builtin:spheres?lights=0" $small -q -o "$work/dark.png" --stats "$work/dark.json"
grep -qE '"shadows": *null' "$work/dark.json" || fail 'a scene without lights has shadow maps'
expect 0 'no shadows: the scene has more than the 65536 lights' render "builtin:onetile?lights=65537" --size 8x8 --lists clustered --frames 0 -o "$work/many.png"
expect 0 'shadows KIND +[^(]*\(maps where the scene has lights\)' render --help

# Each way to choose exposure, tone mapper and camera gives a picture of its own.
for option in '--exposure 2' '--exposure none' '--tonemap none' '--tonemap aces' '--tonemap agx' '--eye 0,3,9 --look-at 0,1,0 --fov 30' \
    '--background 3,0,0' '--ambient 2,2,2' '--lights 20' '--lights 20 --light-seed 2' '--environment builtin:studio' '--environment builtin:sky' \
    '--environment builtin:studio --environment-rotation 90' '--environment builtin:studio --environment-intensity 2' '--debug albedo' '--debug normal' '--debug depth' \
    '--debug roughness' '--debug lights' '--debug cells' '--debug overdraw' '--debug overshading'; do
    # shellcheck disable=SC2086
    expect 0 '' render builtin:spheres $plain $option -o "$work/c.png" --quiet
    [ -e "$work/c.png" ] || continue
    for other in "$work"/kept-*; do [ -e "$other" ] && cmp -s "$work/c.png" "$other" && fail "$option gives the same picture as ${other##*/}"; done
    mv "$work/c.png" "$work/kept-${option// /}"
done

# The options of environments act on that of a file too.
first=iVBORw0KGgoAAAANSUhEUgAAAAQAAAAECAYAAACp8Z5+AAAAEklEQVR42mN4ZiPyHxkzkC4AALAII1EqyS8ZAAAAAElFTkSuQmCC
second=iVBORw0KGgoAAAANSUhEUgAAAAQAAAAECAYAAACp8Z5+AAAAEklEQVR42mMQsXn2HxkzkC4AAJXII1FQW4umAAAAAElFTkSuQmCC
cat >"$work/own.gltf" <<END
{"asset":{"version":"2.0"},"extensionsUsed":["EXT_lights_image_based"],"scene":0,"scenes":[{"nodes":[0],"extensions":{"EXT_lights_image_based":{"light":0}}}],
"nodes":[{"camera":0}],"cameras":[{"type":"perspective","perspective":{"yfov":1.5,"znear":0.1}}],
"images":[{"uri":"data:image/png;base64,$first"},{"uri":"data:image/png;base64,$second"}],
"extensions":{"EXT_lights_image_based":{"lights":[{"intensity":2,"irradianceCoefficients":[[1,1,1],[0,0,0],[0,0,0],[0,0,0],[0,0,0],[0,0,0],[0,0,0],[0,0,0],[0,0,0]],
"specularImageSize":4,"specularImages":[[0,1,0,1,0,1]]}]}}}
END
for option in '' '--environment-rotation 90' '--environment-intensity 0.5' '--environment-hidden'; do
    # shellcheck disable=SC2086
    expect 0 '' render "$work/own.gltf" $plain --exposure 0 $option -o "$work/c.png" --quiet
    for other in "$work"/own-*.png; do [ -e "$other" ] && cmp -s "$work/c.png" "$other" && fail "$option of a file's own environment gives the same picture as ${other##*/}"; done
    mv "$work/c.png" "$work/own-${option// /}.png"
done

# Ways to put blended surfaces together: each is another picture where glass reaches into glass, and linked counts fragments.
expect 2 "--transparency is 'x', must be one of sorted, weighted, linked" render builtin:glass --transparency x -o "$work/c.png"
for kind in sorted weighted linked; do
    expect 0 '' render "builtin:glass?crossing=1&lights=8" $plain --transparency $kind -o "$work/glass-$kind.png" --quiet
done
# The lists of dais are too small in a renderer's first frame, and which fragments find room is a race: it is rendered again until they all do.
hall="builtin:hall?lights=16 --size 128x72 --shadows off --shading dais --lists all --msaa 4"
for name in list list-again; do
    # shellcheck disable=SC2086
    expect 0 '' render $hall --set dais.mode=list --frames 0 -o "$work/dais-$name.png" --quiet
done
# shellcheck disable=SC2086
expect 0 '' render $hall --set dais.mode=list --frames 1 --stats "$work/dais.json" -o "$work/dais-grown.png"
elements=$(grep -oE '"list_elements": *[0-9]+' "$work/dais.json" | grep -oE '[0-9]+$')
[ "${elements:-0}" -gt 16384 ] || fail "the first frame of dais has room for its $elements list elements: nothing is tested"
cmp -s "$work/dais-list.png" "$work/dais-list-again.png" || fail 'two runs with the lists of dais differ'
cmp -s "$work/dais-list.png" "$work/dais-grown.png" || fail 'the first frame of dais is another than later ones'
expect 0 'coarse-reason +why other blocks are not' render --debug help
expect 0 '^zbin$' render --lists help
expect 2 'coarse' render "builtin:glass?lights=8" $plain --shading deferred --debug coarse -o "$work/c.png"
expect 0 '^coarse.shared \(blocks\)' render --counters
expect 0 '"key": "coarse.shared"' render --counters --json
expect 0 'transparency.longest +[1-9][0-9]* ' render "builtin:glass?lights=8" $plain --verbose --transparency linked --debug layers -o "$work/c.png"
for kind in weighted linked; do cmp -s "$work/glass-sorted.png" "$work/glass-$kind.png" && fail "$kind gives the same picture as sorted"; done
[ $failures = 0 ] && echo 'all checks of the command passed'
exit $((failures > 0))
