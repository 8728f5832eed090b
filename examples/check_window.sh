#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# check_window.sh BUILD: starts a display of its own (Xvfb), runs the example window in it, with validation, and compares the screen with the picture
# that the command renders; then closes the window. Skipped where there is no Xvfb.
set -u
build=$1
command -v Xvfb >/dev/null || { echo 'SKIPPED: no Xvfb (Debian: xvfb)'; exit 77; }
work=$(mktemp -d)
display='' program=''
finish() {
    for process in $program $display; do kill "$process" 2>/dev/null; done
    wait 2>/dev/null
    rm -rf "$work"
}
trap finish EXIT
fail() { echo "FAILED: $*" >&2; head -c 2000 "$work/out" >&2; exit 1; }

# Xvfb looks for a free number itself and tells it.
Xvfb -displayfd 3 -screen 0 800x500x24 -fbdir "$work" -nolisten tcp 3>"$work/number" 2>"$work/xvfb" &
display=$!
for _ in $(seq 9000); do [ -s "$work/number" ] && break; sleep 0.1; done
[ -s "$work/number" ] || { cat "$work/xvfb" >&2; echo 'FAILED: Xvfb does not start' >&2; exit 1; }

export DISPLAY=:$(<"$work/number")
"$build/fanal" render builtin:spheres --device 0 --size 640x360 --shadows off --lists clustered -q -o "$work/command.png" || exit 1
export VK_INSTANCE_LAYERS=VK_LAYER_KHRONOS_validation # synchronisation inside of Fanal has tests of its own
"$build/examples/window" builtin:spheres >"$work/out" 2>&1 &
program=$!
arrived=
while [ $SECONDS -lt 900 ]; do
    kill -0 $program 2>/dev/null || fail 'the program ended'
    "$build/tests/screen_picture" "$work/Xvfb_screen0" 640 360 "$work/screen.png" || fail 'the screen cannot be read'
    "$build/fanal" compare "$work/screen.png" "$work/command.png" --max-diff 0 >/dev/null && { arrived=yes; break; }
    sleep 0.2
done
[ -n "$arrived" ] || fail "no frame arrived in the window: $("$build/fanal" compare "$work/screen.png" "$work/command.png")"
kill $program
wait $program 2>/dev/null
program=

# Enough frames for semaphores and images to come round again, and everything destroyed in order.
timeout 900 "$build/examples/window" builtin:spheres 12 >>"$work/out" 2>&1 || fail 'twelve frames and the end'
grep -E 'VUID|Validation Error' "$work/out" >/dev/null && fail 'validation sent messages'
echo 'the frame is in the window'
