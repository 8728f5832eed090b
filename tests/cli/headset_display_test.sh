#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The display of a headset: lenses, what they hide, and what goes on between. Usage: headset_display_test.sh FANAL
set -u
fanal=$(realpath "$1")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failures=0
fail() { echo "FAILED: $*" >&2; failures=$((failures + 1)); }
cd "$work" || exit 2

# run STATUS PATTERN ARGUMENTS…: where a line of stderr matches.
run() {
    local status=$1 pattern=$2 got
    shift 2
    timeout 900 "$fanal" render "builtin:spheres" --size 72x80 --lists clustered --shading deferred --shadows off --exposure 3 -q --no-cache --validate "$@" 2>err
    got=$?
    [ $got = "$status" ] || fail "$*: exit $got, not $status: $(head -c 300 err)"
    [ -z "$pattern" ] || grep -qE -- "$pattern" err || fail "$*: no line with '$pattern': $(head -c 300 err)"
}
differ() { ! cmp -s "$1" "$2" || fail "$1 is $2"; }
same() { "$fanal" compare "$1" "$2" --max-diff "$3" >/dev/null || fail "$1 is not $2"; }

headset="--hmd builtin:asymmetric --stereo side-by-side"
# shellcheck disable=SC2086
{
    run 2 'belong to --hmd' --lens mesh -o a.png
    run 2 'belong to --hmd' --hidden-mesh on --stereo side-by-side -o a.png
    run 2 'belongs to --lens' $headset --lens-view mask -o a.png
    run 2 'with --stereo side-by-side' --hmd builtin:asymmetric --stereo anaglyph --lens mesh -o a.png
    run 2 'must be PNG' $headset --lens mesh -o a.exr
    run 2 "'round' is not" $headset --lens round -o a.png
    run 2 'on or off' $headset --hidden-mesh yes -o a.png
    [ ! -e a.png ] || fail 'a picture was written all the same'

    run 0 '' $headset -o eyes.png
    run 0 '' $headset --lens off -o off.png
    same eyes.png off.png 0 # no lens: the display shows the eyes' pictures
    run 0 '' $headset --lens mesh -o mesh.png
    run 0 '' $headset --lens pixel -o pixel.png
    differ mesh.png eyes.png
    "$fanal" compare mesh.png pixel.png --psnr 30 >/dev/null || fail 'the mesh is not close to the polynomial'
    run 0 '' $headset --hidden-mesh on -o hidden.png
    differ hidden.png eyes.png
    run 0 '' $headset --hidden-mesh on --lens mesh --lens-view mask -o mask.png
    run 0 '' $headset --lens mesh --lens-view mesh -o lines.png
    run 0 '' $headset --lens mesh --lens-view fringes -o fringes.png
    for view in mask lines fringes; do differ $view.png mesh.png; done
    # One eye is the half of the display.
    run 0 '' --hmd builtin:asymmetric --stereo right --lens mesh -o right.png
    [ "$(head -c 24 right.png | od -An -tu1 -j16 -N8 | tr -d '\n')" = '   0   0   0  72   0   0   0  80' ] || fail 'the right eye has another size'
}
[ $failures = 0 ] && echo 'lenses and what they hide are as asked for'
exit $((failures > 0))
