#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The scenes that other renderers are measured with (bench/peers): read back, they give the picture of the built-in scene. Usage: peers_test.sh SCENE_GLB FANAL
set -u
writer=$1 fanal=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failures=0
fail() { echo "FAILED: $*" >&2; failures=$((failures + 1)); }

numbers() { # STATS: what a scene consists of
    sed -n '/^ *"scene": *{/,/}/p' "$1" | grep -vE '"(source|meshes|materials|images)"'
}
check() { # SCENE
    rm -f "$work"/*
    "$writer" "$1" "$work/scene.glb" || { fail "$1 is not written"; return; }
    for source in "$1" "$work/scene.glb"; do
        name=$([ "$source" = "$1" ] && echo builtin || echo file)
        "$fanal" render "$source" --camera 0 --size 160x90 --shadows off --shading forward-prepass --lists clustered --exposure 3 --ambient 0.3,0.3,0.3 --background 0.1,0.1,0.1 \
            -q --stats "$work/$name.json" -o "$work/$name.png" || { fail "$source is not rendered"; return; }
    done
    diff <(numbers "$work/builtin.json") <(numbers "$work/file.json") || fail "$1: other numbers"
    "$fanal" compare "$work/builtin.png" "$work/file.png" --psnr 75 >"$work/compared" || fail "$1: another picture: $(cat "$work/compared")"
}
check 'builtin:hall?lights=48'
check 'builtin:glass?lights=8'

for bad in 'builtin:interior?lights=40' "$work/none.gltf" 'builtin:nonsense'; do
    "$writer" "$bad" "$work/bad.glb" 2>/dev/null && fail "$bad is written"
    [ -e "$work/bad.glb" ] && fail "$bad leaves a file behind"
done
[ $failures = 0 ]
