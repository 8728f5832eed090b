#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# check.sh EXAMPLE BUILD: runs an example of the build and compares its picture with the command's, byte for byte; then
# shows that the picture is lit: without lights it would be another.
set -euo pipefail
example=$1 build=$2
work=$build/examples/check-$example
rm -rf "$work"
mkdir -p "$work"
size=320x180
case $example in
hello) # lights the scene itself
    scene='builtin:spheres?lights=0' size=640x360 options=(--lights 200 --light-seed 1) ;;
import_device) # takes the first device
    scene='builtin:spheres' options=(--device 0 --shadows rays) ;; # it enables no clip distances, which shadow maps need
foveated) # parts of the picture, joined: sharp in the middle, coarser at the edges
    scene='builtin:room'
    "$build/fanal" render "$scene" --size 480x480 --eye 0,1.7,0 --look-at 0,1.7,-1 --fov 90 -q -o "$work/command.png"
    "$build/fanal" render "$scene" --size 480x480 --eye 0.05,1.7,0 --look-at 0.05,1.7,-1 --fov 90 -q -o "$work/other.png"
    for kind in cells quadrants; do
        "$build/examples/foveated" "$scene" "$work/$kind.png" $kind
        "$build/fanal" compare "$work/$kind.png" "$work/command.png" --psnr 38
    done
    status=0
    "$build/fanal" compare "$work/cells.png" "$work/other.png" --psnr 38 || status=$?
    [ $status -eq 1 ]
    exit 0 ;;
async_load) # a file with images; they are all there in the end
    scene=$(dirname "$0")/decals.gltf options=(--lights 20) ;;
esac
"$build/examples/$example" "$scene" "$work/example.png"
"$build/fanal" render "$scene" --size $size "${options[@]}" -q -o "$work/command.png"
"$build/fanal" compare "$work/example.png" "$work/command.png" --max-diff 0
"$build/fanal" render 'builtin:spheres?lights=0' --size $size --ambient 0,0,0 --studio off --exposure 5 -q -o "$work/dark.png"
status=0
"$build/fanal" compare "$work/example.png" "$work/dark.png" --mean-diff 0.05 || status=$?
[ $status -eq 1 ] # over the limit; 2 would be an error
