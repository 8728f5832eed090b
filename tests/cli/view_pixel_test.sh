#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# view_pixel_test.sh BUILD: a click on the picture tells the same as `fanal render --pixel`, and what the panel of the frame says of lists and shadows adds up.
# Exit status 77: built without the window.
set -u
build=$(cd "$1" && pwd)
fanal=$build/fanal
"$fanal" view --help >/dev/null 2>&1 || { echo "SKIPPED: built without 'fanal view' (Debian: libglfw3-dev libimgui-dev)"; exit 77; }
work=$(mktemp -d)
failures=0
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
fail() { echo "FAILED: $*" >&2; failures=$((failures + 1)); }
# value FILE KEY COLUMN: of the first such line of a report.
value() { awk -F'\t' -v key="$2" -v column="${3:-2}" '$1 == key { print $column; exit }' "$1"; }
# near A B: within a ten-thousandth.
near() { awk -v a="$1" -v b="$2" 'BEGIN { d = a - b; exit !(a != "" && b != "" && d * d <= 1e-8 * (a * a + b * b) + 1e-12) }'; }

cat >pixel.txt <<'END'
key 258 down 0
key 258 up 0
set lists=tiled
set shadows=maps
set count-lights=on
frames 2
report before.tsv
key 341 down 2
move 60 34
button 0 down 2
button 0 up 2
key 341 up 0
frames 2
report one.tsv
command one.sh
wheel 0 3
frames 2
report two.tsv
set count-lights=off
set shadows=off
set lists=all
frames 2
key 258 down 0
key 258 up 0
size 300 200
frames 1
capture panels.png
report three.tsv
size 40 20
frames 2
report four.tsv
END
timeout 900 "$fanal" view --no-cache --validate --device 0 --headless --size 120x68 --replay pixel.txt 'builtin:onetile?lights=600' >out 2>&1 || fail "the replay: $(head -c 1000 out)"
grep -q '^pixel' before.tsv && fail 'a pixel that nobody asked for'
[ "$(value one.tsv pixel 4)" = hit ] || fail "nothing was picked: $(grep ^pixel one.tsv | head -3)"
(fanal() { "$build/fanal" "$@" --no-cache --device 0 -q --pixel 60,34 --stats one.json; }; . ./one.sh) >out 2>&1 || fail "the command does not run: $(cat one.sh out)"
# number KEY [INDEX]: of the pixel in the JSON that the command wrote, from its line on, or of the lines after it.
number() {
    awk -v key="\"$1\":" -v index_="${2:--1}" '/^  "pixel": / { inside = 1 } inside && !at && index($0, key) { at = NR }
        at && NR == at + index_ + 1 { sub(/.*: /, ""); gsub(/[ ,]/, ""); print; exit }' one.json
}
for i in 0 1 2; do
    near "$(value one.tsv pixel $((i + 5)))" "$(number position $i)" || fail "place $i: $(value one.tsv pixel $((i + 5))), not $(number position $i)"
    near "$(value one.tsv pixel-lit $((i + 2)))" "$(number lit $i)" || fail "light $i: $(value one.tsv pixel-lit $((i + 2))), not $(number lit $i)"
done
[ "$(value one.tsv pixel-visited)" = "$(number lights_visited)" ] || fail "visited: $(value one.tsv pixel-visited), not $(number lights_visited)"
[ "$(value one.tsv pixel-cell)" = "$(number cell)" ] || fail "cell: $(value one.tsv pixel-cell), not $(number cell)"
[ "$(grep -c ^pixel-light one.tsv)" = "$(value one.tsv pixel-reaching)" ] && [ "$(value one.tsv pixel-reaching)" -gt 0 ] ||
    fail "$(grep -c ^pixel-light one.tsv) lights, $(value one.tsv pixel-reaching) reach it"
# Index, luminance, visibility, shadow: a line a light.
lights() {
    awk -F': ' '{ gsub(/[",]/, "", $2) } /^  "pixel": / { inside = 1 } inside && /"light"/ { line = $2 } inside && /"(luminance|visibility|shadow)"/ { line = line " " $2 }
        inside && /"shadow"/ { print line }' one.json
}
awk -F'\t' '$1 == "pixel-light" { sub(/:.*/, "", $6); print $2, $4, $5, $6 }' one.tsv >told
paste -d' ' told <(lights) | awk '{ d = $2 - $6; e = $3 - $7; bad += NF != 8 || $1 != $5 || $4 != $8 || d * d > 1e-8 * $2 * $2 + 1e-18 || e * e > 1e-8 } END { exit bad > 0 || NR == 0 }' ||
    fail "the lights are not those of the command: $(paste -d' ' told <(lights) | head -5)"
near "$(value two.tsv pixel 5)" "$(value one.tsv pixel 5)" && fail 'the pixel is not told anew when the camera moves'
# The panel of the frame.
awk -F'\t' '$1 == "visits-per-pixel" { v = $2 } $1 == "useful-per-pixel" { u = $2 } $1 == "visits-ratio" { r = $2 }
    END { exit !(u > 0 && v >= u && r >= 1 && (v / u - r) ^ 2 < 1e-6) }' two.tsv || fail "visits: $(grep -E '^(visits|useful)' two.tsv)"
awk -F'\t' '$1 == "list-bytes" && $2 > 0 && $2 <= $3 { n++ } $1 == "shadow-atlas" && $2 > 0 && $2 <= $3 { n++ } $1 == "shadow-pages" && $2 > 0 { n++ }
    $1 == "overflow-cells" && $2 == 0 && $3 > 0 { n++ } END { exit n != 4 }' two.tsv || fail "what is held: $(grep -E '^(list|shadow|overflow)' two.tsv)"
[ "$(value two.tsv shadow-pages)" = "$(awk -F'\t' '$2 == "shadows.pages" { print $3 }' two.tsv)" ] || fail 'pages are not those of the counter'
grep -qE '^(visits|shadow-)' three.tsv && fail "numbers that the frame does not have: $(grep -E '^(visits|shadow-)' three.tsv)"
[ -n "$(value three.tsv pixel-visited)" ] && grep -q '^pixel-cell' three.tsv && fail 'all lights have a cell'
grep -q '^pixel' four.tsv && fail 'a pixel outside of the window'
[ $failures = 0 ] && echo 'all checks of the pixel passed'
exit $((failures > 0))
