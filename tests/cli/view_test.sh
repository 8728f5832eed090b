#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# view_test.sh BUILD: replays what somebody does in the window, without one and (where Xvfb is there) in one, and compares what is saved with what
# `fanal render` makes. Exit status 77: built without the window.
set -u
build=$(cd "$1" && pwd)
fanal=$build/fanal
"$fanal" view --help >/dev/null 2>&1 || { echo "SKIPPED: built without 'fanal view' (Debian: libglfw3-dev libimgui-dev)"; exit 77; }
work=$(mktemp -d)
display='' failures=0
trap '[ -z "$display" ] || kill $display; rm -rf "$work"' EXIT
cd "$work" || exit 1
fail() { echo "FAILED: $*" >&2; [ ! -s out ] || head -c 2000 out >&2; failures=$((failures + 1)); }

# replay NAME OPTION…: replays NAME.txt with validation.
replay() {
    local name=$1
    shift
    timeout 900 "$fanal" view --no-cache --validate --device 0 --replay "$name.txt" "$@" >out 2>&1
}
# same NAME: NAME.png is to the bit what the command in NAME.sh renders.
same() {
    (fanal() { "$build/fanal" "$@" --no-cache --device 0 -q; }; . "./$1.sh") >out 2>&1 || { fail "$1: the command does not run: $(cat "$1.sh")"; return; }
    "$fanal" compare picture.png "$1.png" --max-diff 0 >out 2>&1 || fail "$1: the saved picture is not what the command makes"
}
# value FILE KEY: from a report.
value() { awk -F'\t' -v key="$2" '$1 == key { print $2; exit }' "$1"; }

# ---- without a window: orbit, resize, another order, a light, a pixel, broken and good files ----

printf 'not a scene' >broken.glb
printf 'glTF\2\0\0\0\377\377\0\0\10\0\0\0JSON{"a":' >short.glb
printf '#?RADIANCE\n\n-Y 4 +X' >broken.hdr
cat >all.txt <<'EOF'
# the mouse is on the picture
move 200 60
button 0 down 0
move 230 75
button 0 up 0
wheel 0 1
settle
save orbit.png
command orbit.sh
size 201 133
set shading=visibility
key 70 down 0
key 70 up 0
settle
save size.png
command size.sh
report before.tsv
set debug=normal
frames 2
capture normal.png
set msaa=8
set shading=mobile
frames 2
report refused.tsv
set debug=none
set shading=deferred
size 720 300
panel lights
click add a light
capture panels.png
key 258 down 0
key 258 up 0
key 341 down 2
move 360 150
button 0 down 2
button 0 up 2
key 341 up 0
frames 2
report light.tsv
drop broken.glb
settle
drop short.glb
settle
drop broken.hdr
drop .
settle
drop missing.gltf
settle
report broken.tsv
size 160 90
drop builtin:onetile
settle
save dropped.png
command dropped.sh
scale 2
save plain.png
capture bare.png
close
save never.png
EOF
replay all builtin:spheres --shadows off --headless --size 160x90 || fail 'the replay ended with an error'
same orbit
same size
same dropped
[ "$(value before.tsv shading)" = visibility ] || fail 'the path was not switched'
"$fanal" compare orbit.png size.png >/dev/null 2>&1 && fail 'another size gives the same picture'
grep -q 'MSAA' refused.tsv || fail 'what cannot be drawn is not told'
[ "$(value refused.tsv shading)" = visibility ] || fail "what cannot be drawn was not taken back: $(value refused.tsv shading)"
[ $(($(value light.tsv lights) - $(value before.tsv lights))) = 1 ] || fail 'no light was added'
grep -q $'^pixel\t360\t150\thit' light.tsv || fail "nothing was picked: $(grep ^pixel light.tsv)"
for name in broken.glb short.glb broken.hdr missing.gltf; do grep -q "^message.*$name" broken.tsv || fail "$name is not told"; done
[ "$(value broken.tsv scene)" = builtin:spheres ] || fail 'the broken file took the scene away'
"$fanal" compare bare.png plain.png --max-diff 0 >/dev/null 2>&1 || fail 'without panels something lies over the picture'
[ -e never.png ] && fail 'the window did not close'
"$fanal" compare panels.png normal.png >/dev/null 2>&1 && fail 'the panels show nothing'

# ---- how it moves, and what stands around it: the command says all of it ----

cat >moves.txt <<'EOF'
move 80 40
button 1 down 0
move 80 60
button 1 up 0
report start.tsv
pad 1 -1
frames 6
pad 1 0
report flown.tsv
key 78 down 0
key 78 up 0
key 78 down 0
key 78 up 0
pad 1 -0.5
frames 6
pad 1 0
report walked.tsv
pad 2 1
frames 2
pad 2 0
report turned.tsv
key 77 down 0
key 77 up 0
move 20 20
move 60 20
key 256 down 0
key 256 up 0
report looked.tsv
move 100 20
report released.tsv
size 380 420
key 258 down 0
key 258 up 0
click Environment
click Overcast
click show as background
size 160 90
settle
save moved.png
command moved.sh
EOF
replay moves builtin:onetile --headless --no-panels --size 160x90 --shadows off --lights 5 --environment builtin:sky --environment-rotation 40 || fail 'the replay of moves ended with an error'
same moved
grep -q -e '--lights 5' moved.sh && grep -q -e '--environment builtin:overcast' moved.sh && grep -q -e '--environment-hidden' moved.sh || fail "the command does not say all: $(cat moved.sh)"
# moved FROM TO: how far the camera went, up and along the ground, in all.
moved() { awk -F'\t' '$1 == "camera" { if (seen++) printf "%.6f %.6f\n", $3 - y, sqrt(($2 - x) ^ 2 + ($4 - z) ^ 2); x = $2; y = $3; z = $4 }' "$1" "$2"; }
read -r up along < <(moved start.tsv flown.tsv)
awk "BEGIN { exit !($along > 0.01 && ($up < -0.001 || $up > 0.001)) }" || fail "flying went $up up and $along along"
read -r walk_up walk_along < <(moved flown.tsv walked.tsv)
awk "BEGIN { exit !($walk_up == 0 && $walk_along > 0.01) }" || fail "walking went $walk_up up and $walk_along along"
awk "BEGIN { flown = sqrt(($up) ^ 2 + $along ^ 2); exit !(flown / $walk_along > 1.99 && flown / $walk_along < 2.01) }" || fail 'half a stick is not half as fast'
moved=$(moved walked.tsv turned.tsv)
[ "$moved" = '0.000000 0.000000' ] || fail "looking around moved the camera: $moved"
[ "$(grep ^camera walked.tsv)" != "$(grep ^camera turned.tsv)" ] || fail 'the right stick does nothing'
[ "$(grep ^camera turned.tsv)" != "$(grep ^camera looked.tsv)" ] || fail 'the captured mouse does nothing'
[ "$(grep ^camera looked.tsv)" = "$(grep ^camera released.tsv)" ] || fail 'the mouse was not released'

# ---- hundreds of events, of which many make no sense; FANAL_SOAK: how many ----

awk -v count="${FANAL_SOAK:-300}" 'BEGIN { srand(7); for (i = 0; i < count; i++) { r = rand();
    if (r < 0.5) print "move", int(rand() * 200) - 20, int(rand() * 120) - 20
    else if (r < 0.6) print "wheel", 0, int(rand() * 5) - 2
    else if (r < 0.75) print "button", int(rand() * 4), rand() < 0.5 ? "down" : "up", int(rand() * 8)
    else if (r < 0.9) { k = int(rand() * 511); if (k != 81 && k != 80) print "key", k, rand() < 0.5 ? "down" : "up", int(rand() * 8) }
    else if (r < 0.95) print "character", int(rand() * 300)
    else print "size", int(rand() * 60), int(rand() * 40) } print "size 64 36\nsettle\nreport soak.tsv" }' >soak.txt
replay soak builtin:onetile --headless --size 64x36 --shadows off || fail 'random events'
[ "$(value soak.tsv scene)" = builtin:onetile ] || fail 'the scene is gone'

# ---- what is refused ----

refused() {
    local words=$1
    shift
    timeout 900 "$fanal" view "$@" >out 2>&1 && fail "taken: $*"
    grep -q -e "$words" out || fail "no word of '$words': $*"
}
printf 'move 1\n' >bad.txt
refused 'bad.txt:1: not an event' --headless --size 16x16 --replay bad.txt --no-cache --device 0
printf 'click nothing like it\n' >bad.txt
refused 'no widget in sight' --headless --size 16x16 --replay bad.txt --no-cache --device 0
refused 'cannot be read' --headless --size 16x16 --replay missing.txt --no-cache --device 0
mkfifo pipe.txt # nobody writes to it
refused 'pipe.txt: cannot be read: it is a pipe' --headless --size 16x16 --replay pipe.txt --no-cache --device 0
refused '. cannot be read: it is a folder' --headless --size 16x16 --replay . --no-cache --device 0
refused '/dev/zero: cannot be read: it is a device' --headless --size 16x16 --replay /dev/zero --no-cache --device 0
for event in report command; do
    echo "$event /dev/full" >full.txt
    refused '/dev/full: cannot be written: No space' builtin:onetile --headless --size 16x16 --replay full.txt --no-cache --device 0
done
refused 'needs --replay' --headless
refused 'cannot be combined' --replay a --record b
refused 'fifo, mailbox or immediate' --present sometimes
refused 'srgb, scrgb or hdr10' --color rgb
refused 'no window can be opened' --no-cache DISPLAY
unset DISPLAY WAYLAND_DISPLAY
refused -- '--headless draws without one' builtin:onetile --no-cache

# ---- in a window ----

if command -v Xvfb >/dev/null; then
    Xvfb -displayfd 3 -screen 0 800x500x24 -fbdir "$work" -nolisten tcp 3>number 2>xvfb &
    display=$!
    for _ in $(seq 6000); do [ -s number ] && break; sleep 0.1; done
    export DISPLAY=:$(<number)
    printf 'frames 3\nsave window.png\nframes 4\n' >window.txt
    replay window builtin:onetile --size 320x180 || fail 'the window'
    printf 'size 320 180\nframes 2\nsave headless.png\n' >headless.txt
    replay headless builtin:onetile --headless --size 320x180 || fail 'the same without it'
    "$fanal" compare window.png headless.png --max-diff 0 >out 2>&1 || fail 'the window saves another picture'
    # The whole of the first replay in a window of another size: the same pictures.
    mkdir window
    cp all.txt broken.glb short.glb broken.hdr window
    (cd window && replay all builtin:spheres --shadows off --size 160x90) || fail 'the first replay, in a window'
    for name in orbit size dropped plain; do "$fanal" compare $name.png window/$name.png --max-diff 0 >out 2>&1 || fail "$name.png is another picture in a window"; done
    timeout 900 "$fanal" view builtin:onetile --record /dev/full --exit-after 3 --shading deferred --lists clustered --shadows off --size 64x36 --no-cache --no-settings --device 0 >out 2>&1 && fail 'a record on a full disk is no error'
    grep -q '/dev/full: cannot be written: No space' out || fail 'a record on a full disk: no word of it'
    timeout 900 "$fanal" view builtin:onetile --record record.txt --exit-after 3 --shading deferred --lists clustered --shadows off --size 64x36 --no-cache --no-settings --device 0 >out 2>&1 || fail 'a record'
    grep -q '^frames 1$' record.txt || fail 'the record has no frame'
    # What stands on the screen.
    "$fanal" view builtin:onetile --no-cache --no-settings --device 0 --size 320x180 --no-panels >out 2>&1 &
    program=$!
    arrived=
    for _ in $(seq 2000); do
        kill -0 $program 2>/dev/null || break
        "$build/tests/screen_picture" "$work/Xvfb_screen0" 320 180 screen.png
        "$fanal" compare screen.png window.png --max-diff 0 >out2 2>&1 && { arrived=yes; break; }
        sleep 0.3
    done
    [ -n "$arrived" ] || fail "the screen does not show what is saved: $(cat out2)"
    # Nothing happens: no picture is drawn. Ctrl-C closes the window, which then says how many there were.
    sleep 5
    kill -INT $program
    wait $program || fail "Ctrl-C: $(cat out)"
    pictures=$(sed -n 's/^[0-9]* frames of the scene in \([0-9]*\) pictures of the window$/\1/p' out)
    [ "${pictures:-1000}" -lt 30 ] || fail "at rest it draws: $(cat out)"
    # Panels do not wait for a slow scene: the window shows many pictures while its device works on a frame, until the last of three is finished.
    "$fanal" view builtin:spheres --no-cache --no-settings --device 0 --size 400x240 --shading forward --lists brute-force --shadows off --msaa 1 --lights 300 --exit-after 3 --validate >out 2>&1 || fail 'a slow scene'
    [ "$(sed -n 's/^3 frames of the scene in \([0-9]*\) pictures of the window$/\1/p' out)" -gt 6 ] || fail "panels wait for the scene: $(cat out)"
    # What is remembered: read, kept, and written; what makes no sense is left out with a warning.
    export XDG_CONFIG_HOME=$work/config
    mkdir -p config/fanal
    printf 'width 200\nheight 120\npresent 7\nnonsense\ndark 0\nrecent /somewhere.glb\n' >config/fanal/view
    "$fanal" view builtin:onetile --no-cache --device 0 --scale 1.5 --no-panels --exit-after 2 --shading deferred --lists clustered --shadows off >out 2>&1 || fail 'a window with settings'
    grep -q 'view:3: not a setting' out && grep -q 'view:4: not a setting' out || fail 'bad settings are not told'
    printf '%s\n' 'width 200' 'height 120' 'scale 1.5' 'dark 0' 'panels 0' 'present 0' 'color 0' 'navigation 0' 'recent builtin:onetile' 'recent /somewhere.glb' >wanted
    diff wanted config/fanal/view >out || fail 'the settings are not what was written'
    printf 'width 333\n' >config/fanal/view
    "$fanal" view builtin:onetile --no-cache --device 0 --no-settings --size 100x80 --exit-after 1 --shading deferred --lists clustered --shadows off >out 2>&1 || fail 'a window without settings'
    [ "$(cat config/fanal/view)" = 'width 333' ] || fail '--no-settings writes settings'
else
    echo 'SKIPPED in part: no Xvfb (Debian: xvfb)'
fi
[ $failures = 0 ] && echo 'all checks of the window passed'
exit $((failures > 0))
