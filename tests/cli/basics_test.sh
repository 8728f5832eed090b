#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# What a newcomer meets first: scenes, numbers of lights, what is printed, what is refused. Usage: basics_test.sh FANAL
set -u
fanal=$1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export MESA_SHADER_CACHE_DIR=${MESA_SHADER_CACHE_DIR:-${XDG_CACHE_HOME:-${HOME:-$work}/.cache}} # what the driver has compiled stays
export XDG_CACHE_HOME="$work/cache" TMPDIR="$work"
failures=0
fail() { echo "FAILED: $*" >&2; failures=$((failures + 1)); }
cd "$work" || exit 2

# expect STATUS PATTERN ARGUMENTS…: the status, and a line of stdout or stderr that matches; they are in out and err.
expect() {
    local status=$1 pattern=$2 got
    shift 2
    "$fanal" "$@" >out 2>err
    got=$?
    [ $got = "$status" ] || fail "fanal $*: exit $got, not $status: $(head -c 400 err)"
    [ -z "$pattern" ] || grep -qE -- "$pattern" out err || fail "fanal $*: no line with '$pattern': $(head -c 400 out err)"
}
absent() { for file in "$@"; do [ ! -e "$file" ] || fail "$file was left behind"; done; }
same() { cmp -s "$1" "$2" || fail "$3"; }
small='--size 64x36 --shadows off --lists clustered'
triangle='"scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
 "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [-1, -1, 0], "max": [1, 1, 0]}],
 "bufferViews": [{"buffer": 0, "byteLength": 36}],
 "buffers": [{"byteLength": 36, "uri": "data:application/octet-stream;base64,AACAvwAAgL8AAAAAAACAPwAAgL8AAAAAAAAAAAAAgD8AAAAA"}]'
echo "{\"asset\": {\"version\": \"2.0\"}, $triangle}" >triangle.gltf
# Lists of words: options.
# shellcheck disable=SC2086
{
    # --lights N: altogether in a built-in scene, more in a file.
    lights() { grep -A 20 '"scene": {' "$1" | sed -n 's/^ *"lights": *\([0-9]*\),*$/\1/p'; }
    expect 0 '' render 'builtin:spheres?lights=20&seed=3' $small -q -o named.png
    expect 0 '' render 'builtin:spheres?seed=3&lights=9' --lights 20 $small -q -o option.png --stats option.json
    same named.png option.png '--lights 20 is not what ?lights=20 shows'
    [ "$(lights option.json)" = 20 ] || fail "--lights 20 gives a built-in scene $(lights option.json) lights"
    expect 0 '' trace 'builtin:spheres?lights=5' --size 32x18 --shadows off --exposure 4 -q -o named.png
    expect 0 '' trace builtin:spheres --lights 5 --size 32x18 --shadows off --exposure 4 -q -o option.png
    same named.png option.png '--lights 5 is not what ?lights=5 shows to trace'
    expect 0 '' render builtin:spheres --lights 0 $small -q --stats option.json
    [ "$(lights option.json)" = 0 ] || fail "--lights 0 gives a built-in scene $(lights option.json) lights"
    expect 0 '' render builtin:spheres --lights 20 --light-shapes capsule $small -q --stats option.json -o shapes.png
    [ "$(lights option.json)" = 20 ] || fail "--lights 20 --light-shapes gives a built-in scene $(lights option.json) lights"
    cmp -s shapes.png named.png && fail '--light-shapes changes nothing in a built-in scene'
    expect 0 '' render triangle.gltf --lights 7 $small -q --stats option.json
    [ "$(lights option.json)" = 7 ] || fail "--lights 7 gives a file $(lights option.json) lights"
    expect 2 'lights=1048577 is not a whole number from 0 to 1048576' render builtin:spheres --lights 1048577 $small -o a.png
    absent a.png
}
[ $failures = 0 ] && echo 'all checks of the basics passed'
exit $((failures > 0))
