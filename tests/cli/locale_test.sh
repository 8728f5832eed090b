#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The command reads and writes the same numbers when a library it loads sets a locale with a decimal comma. Usage: locale_test.sh FANAL COMMA_LIBRARY
set -u
fanal=$1 library=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export XDG_CACHE_HOME="$work/cache" FANAL_TEST_FOLDER="$work" ASAN_OPTIONS="${ASAN_OPTIONS:+$ASAN_OPTIONS:}verify_asan_link_order=0"
failures=0
fail() { echo "FAILED: $*" >&2; failures=$((failures + 1)); }
cd "$work" || exit 2

# both NAME ARGUMENTS…: NAME.plain and NAME.comma, what the command prints, are the same; so are the pictures, if it writes a picture.exr.
both() {
    local name=$1
    shift
    "$fanal" "$@" >"$name.plain" 2>&1 || fail "fanal $*: $(head -c 400 "$name.plain")"
    [ ! -e picture.exr ] || mv picture.exr plain.exr
    LD_PRELOAD=$library "$fanal" "$@" >"$name.comma" 2>&1 || fail "fanal $*, with a decimal comma: $(head -c 400 "$name.comma")"
    cmp "$name.plain" "$name.comma" || fail "fanal $*: $(diff "$name.plain" "$name.comma" | head -5)"
    [ ! -e plain.exr ] || cmp plain.exr picture.exr || fail "fanal $*: the pictures differ"
    rm -f plain.exr picture.exr
}

both options render --options --json
grep -q '[0-9]\.[0-9]' options.comma || fail 'the options have no number with a point'
both options render --options
both info info builtin:spheres --json
if "$fanal" trace --help | grep -q -- --samples; then
    both trace trace builtin:spheres --size 16x9 --samples 1 -q --lights 3 --light-scale 0.5 --light-shapes point=1.5,spot=0.5 --environment 'builtin:sky?elevation=40.5&turbidity=2.5' \
        --eye 0.5,1.5,6.25 --look-at 0,1.25,0 --fov 50.5 --exposure 1.5 -o picture.exr
fi
[ $failures = 0 ]
