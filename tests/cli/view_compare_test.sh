#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# view_compare_test.sh BUILD: two methods in one window: split, side by side, and their difference; as captures, and on the screen.
set -u
build=$(cd "$1" && pwd)
fanal=$build/fanal
"$fanal" view --help >/dev/null 2>&1 || { echo "SKIPPED: built without 'fanal view' (Debian: libglfw3-dev libimgui-dev)"; exit 77; }
work=$(mktemp -d)
display='' failures=0
trap '[ -z "$display" ] || kill $display; rm -rf "$work"' EXIT
cd "$work" || exit 1
fail() { echo "FAILED: $*" >&2; [ ! -s out ] || head -c 2000 out >&2; failures=$((failures + 1)); }
replay() {
    local name=$1
    shift
    timeout 900 "$fanal" view --no-cache --validate --device 0 --headless --scale 0.5 --shading deferred --lists clustered --shadows off --replay "$name.txt" "$@" >out 2>&1
}
value() { awk -F'\t' -v key="$2" '$1 == key { print $2; exit }' "$1"; }
part() { "$build/tests/picture_part" "$@" || fail "picture_part $*"; }
# equal A B WHAT
equal() { "$fanal" compare "$1" "$2" --max-diff 0 >out 2>&1 || fail "$3"; }

# ---- every mode, of pictures that differ ----

width=97 height=60 middle=49
cat >all.txt <<'EOF'
key 258 down 0
key 258 up 0
capture a.png
report off.tsv
set debug=normal
capture b.png
report legend.tsv
set debug=none
setb debug=normal
compare split
slider 0.5
frames 2
capture split.png
report split.tsv
slider 0
frames 1
capture right.png
slider 1
frames 1
capture left.png
# The line is dragged; the camera stays.
slider 0.5
move 47 30
button 0 down 0
move 24 30
button 0 up 0
report dragged.tsv
capture dragged.png
compare side
frames 2
capture side.png
# The same pixel of both halves.
key 341 down 2
move 20 40
button 0 down 2
button 0 up 2
frames 1
report pick-a.tsv
move 68 40
button 0 down 2
button 0 up 2
key 341 up 0
frames 1
report pick-b.tsv
# Escape lets go of what was picked.
key 256 down 0
key 256 up 0
compare difference
frames 2
capture difference.png
report difference.tsv
# The same by the panels, and what cannot be drawn is taken back, of B as of A.
size 400 240
key 258 down 0
key 258 up 0
frames 2
click Compare
click swap
frames 2
report swapped.tsv
click copy A to B
frames 2
report copied.tsv
click difference
click split
setb msaa=8
setb shading=mobile
frames 3
report taken_b.tsv
setb msaa=1
setb shading=deferred
set msaa=8
set shading=mobile
frames 3
report taken_a.tsv
compare difference
setb msaa=8
setb shading=mobile
frames 3
report taken_difference.tsv
# Nothing differs.
click copy A to B
size 97 60
key 258 down 0
key 258 up 0
frames 2
capture equal.png
report equal.tsv
# Another scene: B goes on with it.
compare split
slider 0.5
setb debug=none
drop builtin:spheres
settle
capture spheres.png
compare off
frames 1
capture off.png
EOF
replay all builtin:onetile --size ${width}x$height || fail 'the replay ended with an error'
for name in a split; do
    part $name.png 0 0 $middle $height $name-left.png
    part $name.png $middle 0 $((width - middle)) $height $name-right.png
done
part b.png $middle 0 $((width - middle)) $height b-right.png
equal a-left.png split-left.png 'left of the line A is not'
equal b-right.png split-right.png 'right of the line B is not'
"$fanal" compare a-right.png split-right.png >/dev/null && "$fanal" compare a-right.png split-right.png --max-diff 0 >/dev/null && fail 'both sides show A'
equal a.png left.png 'with the slider at 1 all is not A'
equal b.png right.png 'with the slider at 0 all is not B'
[ "$(value off.tsv compare)" = off ] && [ "$(value split.tsv compare)" = split ] || fail 'the mode is not told'
[ "$(value split.tsv method_a)" = debug=none ] && [ "$(value split.tsv method_b)" = debug=normal ] || fail "the methods are not told: $(grep method split.tsv)"
for report in split difference; do
    awk -F'\t' '/^method/ && $3 > 0 { n++ } END { exit n != 2 }' $report.tsv || fail "$report: a side has no milliseconds: $(grep method $report.tsv)"
done
for side in a b; do # of this side's frames alone, in order
    awk -F'\t' -v key=times_$side '$1 == key && $2 == 2 && $3 > 0 && $3 <= $4 && $4 <= $5 { n++ } END { exit n != 1 }' split.tsv || fail "the spread of times: $(grep times split.tsv)"
done
awk -v x="$(value dragged.tsv slider)" 'BEGIN { exit !(x > 0.24 && x < 0.26) }' || fail "the slider was not dragged: $(value dragged.tsv slider)"
part dragged.png 0 0 24 $height dragged-left.png
part a.png 0 0 24 $height a-24.png
equal dragged-left.png a-24.png 'the slider was dragged and the camera moved'
part dragged.png 24 0 73 $height dragged-right.png
part b.png 24 0 73 $height b-24.png
equal dragged-right.png b-24.png 'B does not begin at the slider'

# Side by side: each half is a picture of its own, of that size.
printf 'key 258 down 0\nkey 258 up 0\ncapture half-a.png\nsize %d %d\nset debug=normal\ncapture half-b.png\n' $middle $height >half.txt
replay half builtin:onetile --size $((width / 2))x$height || fail 'the halves'
part side.png 0 0 $((width / 2)) $height side-left.png
part side.png $((width / 2)) 0 $middle $height side-right.png
equal side-left.png half-a.png 'the left half is not A'
equal side-right.png half-b.png 'the right half is not B'

# B is one column wider, so that the places are half a pixel apart.
awk -F'\t' '$1 == "pixel" { n++; for (i = 5; i <= 7; i++) p[n, i] = $i } END { for (i = 5; i <= 7; i++) { d = p[1, i] - p[2, i]; if (d > 0.2 || d < -0.2) bad = 1 } exit n != 2 || bad }' \
    pick-a.tsv pick-b.tsv || fail "not the same place: $(grep -h ^pixel pick-a.tsv pick-b.tsv)"

# The difference: the numbers of `fanal compare`, and its picture.
"$fanal" compare a.png b.png --json -o expected.png >numbers.json || fail 'fanal compare'
number() { sed -n "s/.*\"$1\": \([-0-9.e]*\),*/\1/p" numbers.json | head -1; }
for pair in psnr:psnr max_difference:max differing_pixels:differing_pixels; do
    awk -v a="$(value difference.tsv "${pair%:*}")" -v b="$(number "${pair#*:}")" 'BEGIN { d = a - b; exit !(a != "" && b != "" && d < 1e-4 && d > -1e-4) }' ||
        fail "${pair%:*} is $(value difference.tsv "${pair%:*}"), not $(number "${pair#*:}")"
done
equal difference.png expected.png 'the picture of the difference is another one'
[ "$(value equal.tsv differing_pixels)" = 0 ] && [ "$(value equal.tsv psnr)" = inf ] && [ "$(value equal.tsv max_difference)" = 0 ] ||
    fail "equal pictures differ: $(grep -E 'psnr|pixels|max' equal.tsv)"
awk '!/^method/' equal.tsv | grep -q compare || fail 'no report'
[ -z "$(value equal.tsv method_b)" ] || fail "a copy has another method: $(value equal.tsv method_b)"

# What the colours of a debug view mean; memory by kind is all of it.
[ "$(value legend.tsv legend)" = normal ] && grep -q $'^legend.*+Y up (#80ff80)' legend.tsv || fail "no legend: $(grep legend legend.tsv)"
grep -q '^legend' off.tsv && fail 'a legend of nothing'
awk -F'\t' '$1 == "memory" { sum += $3; n++ } $1 == "device_bytes" { all = $2 } END { exit !(n == 8 && sum == all && all > 0) }' split.tsv ||
    fail "memory by kind is not all: $(grep -E '^memory|^device' split.tsv)"

# The panel.
[ "$(value swapped.tsv method_a)" = debug=normal ] && [ "$(value swapped.tsv method_b)" = debug=none ] || fail "not swapped: $(grep method swapped.tsv)"
[ -z "$(value copied.tsv method_a)" ] && [ "$(value copied.tsv differing_pixels)" = 0 ] || fail "not copied: $(grep method copied.tsv)"
[ "$(value taken_b.tsv compare)" = split ] || fail 'the mode was not chosen in the panel'
[ -z "$(value taken_b.tsv method_b | grep mobile)" ] && grep -q $'^message.*MSAA' taken_b.tsv || fail "B was not taken back: $(grep method taken_b.tsv)"
[ -z "$(value taken_a.tsv method_a | grep mobile)" ] && grep -q $'^method_b' taken_a.tsv || fail "A was not taken back: $(grep method taken_a.tsv)"
[ -z "$(value taken_difference.tsv method_b | grep mobile)" ] || fail "B was not taken back in a difference: $(grep method taken_difference.tsv)"
"$fanal" compare spheres.png off.png --max-diff 0 >/dev/null && fail 'B is gone with the old scene'
part spheres.png 0 0 $middle $height spheres-left.png
part off.png 0 0 $middle $height off-left.png
equal spheres-left.png off-left.png 'off is not A'

# ---- modes that change all the time, scenes and sizes that come and go ----

awk 'BEGIN { srand(11); split("off split side difference", m, " "); for (i = 0; i < 300; i++) { r = rand();
    if (r < 0.35) print "move", int(rand() * 200) - 20, int(rand() * 120) - 20
    else if (r < 0.4) print "wheel", 0, int(rand() * 5) - 2
    else if (r < 0.55) print "button", int(rand() * 4), rand() < 0.5 ? "down" : "up", int(rand() * 8)
    else if (r < 0.7) print "compare", m[1 + int(rand() * 4)]
    else if (r < 0.76) print "slider", rand()
    else if (r < 0.82) print rand() < 0.5 ? "set" : "setb", "msaa=" 2 ^ int(rand() * 4)
    else if (r < 0.88) print rand() < 0.5 ? "setb debug=lights" : "setb debug=none"
    else if (r < 0.93) print "setb shading=" (rand() < 0.3 ? "mobile" : rand() < 0.5 ? "forward" : "deferred")
    else if (r < 0.95) print "drop", rand() < 0.5 ? "builtin:onetile" : "builtin:pole"
    else print "size", int(rand() * 60), int(rand() * 40) } print "size 64 36\nset msaa=1\nsettle\nreport soak.tsv" }' >soak.txt
replay soak builtin:onetile --size 64x36 || fail '300 random events'
[ -n "$(value soak.tsv compare)" ] || fail 'no report after random events'

# ---- what is refused ----

refused() {
    local words=$1
    shift
    timeout 900 "$fanal" view --headless --size 16x16 --no-cache --device 0 --replay bad.txt "$@" >out 2>&1 && fail "taken: $*"
    grep -q -e "$words" out || fail "no word of '$words': $*"
}
: >bad.txt
refused '--compare' --compare nonsense=1
refused '--compare' --compare lists
refused '--compare' --compare ''
printf 'slider 1.5\n' >bad.txt
refused 'bad.txt:1: not an event'
printf 'compare halves\n' >bad.txt
refused 'off, split, side, difference'
printf 'setb nothing=1\n' >bad.txt
refused 'nothing'

# ---- on the screen ----

# shows MODE FILE: the window shows to the bit what the capture has.
shows() {
    printf 'key 258 down 0\nkey 258 up 0\ncompare %s\nframes 100000\n' "$1" >window.txt
    "$fanal" view builtin:onetile --no-cache --device 0 --shading deferred --lists clustered --shadows off --size ${width}x$height --replay window.txt --compare debug=normal >out 2>&1 &
    local program=$! arrived=
    for _ in $(seq 2000); do
        kill -0 $program 2>/dev/null || break
        "$build/tests/screen_picture" "$work/Xvfb_screen0" $width $height screen.png
        "$fanal" compare screen.png "$2" --max-diff 0 >out2 2>&1 && { arrived=yes; break; }
        sleep 0.3
    done
    [ -n "$arrived" ] || fail "$1: the screen does not show what is captured: $(cat out2)"
    kill $program
    wait $program 2>/dev/null
}
if command -v Xvfb >/dev/null; then
    Xvfb -noreset -displayfd 3 -screen 0 400x300x24 -fbdir "$work" -nolisten tcp 3>number 2>xvfb &
    display=$!
    for _ in $(seq 6000); do [ -s number ] && break; sleep 0.1; done
    DISPLAY=:$(<number)
    export DISPLAY
    unset WAYLAND_DISPLAY
    # Every mode, at rest and while the camera moves, with validation.
    cat >all-window.txt <<'EOF'
key 258 down 0
key 258 up 0
frames 2
slider 0
frames 1
slider 1
frames 1
slider 0.3
button 0 down 0
move 60 20
frames 1
move 70 25
frames 2
button 0 up 0
frames 1
compare side
frames 2
compare difference
frames 2
setb msaa=8
setb shading=mobile
frames 3
compare off
frames 2
EOF
    timeout 900 "$fanal" view builtin:onetile --validate --no-cache --device 0 --shading deferred --lists clustered --shadows off --size ${width}x$height \
        --replay all-window.txt --compare debug=normal >out 2>&1 || fail 'the modes in a window'
    shows split split.png
    shows side side.png
    shows difference difference.png
else
    echo 'SKIPPED in part: no Xvfb (Debian: xvfb)'
fi
[ $failures = 0 ] && echo 'all checks of comparing in the window passed'
exit $((failures > 0))
