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
