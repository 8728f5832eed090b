#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The page of `fanal bench` in headless Chromium: it looks at itself (report.html?selftest), once as wide as a phone, once as a desktop;
# what it finds must agree with the other files. Usage: bench_page_test.sh FANAL
set -u
fanal=$1
here=$(cd "$(dirname "$0")" && pwd)
chromium=$(command -v chromium || command -v chromium-browser || command -v google-chrome || true)
if [ -z "$chromium" ]; then
    echo 'SKIPPED: there is no Chromium here to open the page with (Debian: chromium)'
    exit 77
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failures=0
fail() { echo "FAILED: $*" >&2; failures=$((failures + 1)); }

# The page knows its width only in a frame: a window has a least width of its own.
look() { # FOLDER WIDTH [PLOTS [ZEROS]]
    cat >"$work/frame.html" <<HTML
<!doctype html><body style="margin:0"><iframe style="border:0" width="$2" height="844" src="file://$1/report.html?selftest"></iframe>
<script>addEventListener('message', (event) => { const out = document.createElement('pre'); out.id = 'out'; out.textContent = event.data; document.body.append(out); });</script>
HTML
    timeout 900 "$chromium" --headless --no-sandbox --disable-gpu --hide-scrollbars --virtual-time-budget=60000 \
        --user-data-dir="$work/profile" --window-size=1200,1000 --dump-dom "file://$work/frame.html" >"$work/dom.html" 2>"$work/browser.log"
    sed -n 's/.*<pre id="out">\(.*\)<\/pre>.*/\1/p' "$work/dom.html" | sed 's/&lt;/</g; s/&gt;/>/g; s/&amp;/\&/g' >"$work/found.json"
    [ -s "$work/found.json" ] || { fail "$1 at $2 pixels: the page said nothing: $(tail -n 3 "$work/browser.log")"; return 1; }
    local wrong
    wrong=$(jq -r --slurpfile results "$1/results.json" --argjson WIDTH "$2" --argjson PLOTS "${3-6}" --argjson ZEROS "${4-0}" -f "$here/check_page.jq" \
        "$work/found.json" 2>&1) && [ -z "$wrong" ] || { fail "$1 at $2 pixels: $wrong"; return 1; }
    jq -r '.tables.numbers.text[][4]' "$work/found.json" >"$work/numbers"
    # The table of all numbers against the CSV: as many rows, three digits of every median of a whole frame.
    tr -d '\r' <"$1/results.csv" | awk -F, 'FNR == 1 { for (i = 1; i <= NF; i++) if ($i == "frame_ms_median") column = i; next }
        { gsub(/"[^"]*"/, "quoted"); print $column }' >"$work/csv"
    paste "$work/csv" "$work/numbers" | awk '{ off = ($1 - $2) / $1; if (off > 0.006 || off < -0.006) bad++; rows++ }
        END { if (bad || rows == 0) { print bad " of " rows " rows differ from the CSV"; exit 1 } }' || fail "$1: the table of all numbers"
}

run() { # FOLDER STATUS ARGUMENTS…
    local folder=$work/$1 wanted=$2
    shift 2
    [[ " $* " == *" --suite "* || " $* " == *" --shadows "* ]] || set -- --shadows off "$@"
    "$fanal" bench "$@" -o "$folder" >"$work/out" 2>&1
    local status=$?
    [ $status = "$wanted" ] || fail "bench $*: exit $status: $(head -c 400 "$work/out")"
}

# Many lights and schemes; one number of lights; a suite; a wrong picture; nothing at all.
run many 0 builtin:spheres --sizes 48x27,32x18 --lights 0,4,16,64 --shading deferred,forward --lists brute,tiled,clustered --frames 2 \
    --set clusters.size=32 --set clusters.slices=16
run one 0 "builtin:sky?seed=3" --sizes 64x36 --msaa 1,4 --shading deferred,visibility,mobile --lists brute,clustered,clustered-cpu --frames 2
# Axes that show a 0: lights in each plot of lines; lists of brute force in the balance and in memory, its lights per pixel.
for width in 390 1100; do look "$work/many" $width 6 5; done
look "$work/one" 390
# Several cases: their table comes before the sentences, with shadows and without apart. A busy machine is told of first.
run shadows 0 builtin:spheres --sizes 32x18 --lights 4 --shading deferred,forward --lists brute,tiled --shadows off,maps --frames 2
look "$work/shadows" 390
jq -e '.tables.cases.rows == 2 and ([.tables.cases.text[][0]] | join(" ") | contains("without shadows") and contains("shadows by maps")) and
    (.lead | index("fastestmsbetween") < index("was fastest"))' "$work/found.json" >/dev/null || fail "the table of cases does not come first: $(jq -c '.lead' "$work/found.json")"
jq '.warnings = ["The machine was busy: a made-up load."]' "$work/shadows/results.json" >"$work/results.json"
awk -v json="$(jq -c . "$work/results.json" | sed 's/\\/\\\\/g')" '/id="data">/ { print; getline; print json "</script>"; next } { print }' \
    "$work/shadows/report.html" >"$work/busy.html" && mv "$work/busy.html" "$work/shadows/report.html"
look "$work/shadows" 390
jq -e '.lead | startswith("The machine was busy: a made-up load.")' "$work/found.json" >/dev/null || fail "the page does not begin with its warning: $(jq -c '.lead' "$work/found.json")"
run tables 0 --suite visibility "builtin:hall?overdraw=1" --sizes 32x18 --msaa 1 --lights 4 --shading deferred,visibility --frames 2
look "$work/tables" 390
grep -qE '"orders": *\{' "$work/found.json" && grep -qE '"ids": *\{' "$work/found.json" || fail 'the tables of a suite are not on the page'
grep -q 'report.html' <<<"$(ls "$work/many")" && ! grep -qE '(src|href)="?(https?:)?//' "$work/many/report.html" || fail 'the page refers to the outside'

sed -i '0,/"equal": true/s//"equal": false/' "$work/one/results.json"
run one 1 "builtin:sky?seed=3" --sizes 64x36 --msaa 1,4 --shading deferred,visibility,mobile --lists brute,clustered,clustered-cpu --frames 2 --resume
look "$work/one" 390
# A suite begins with what it reached, and warns of a CPU.
run suite 0 --suite fine-pruned --sizes 32x18 --frames 2
look "$work/suite" 390 7
grep -qE '"lead":"Mikkelsen 2016: fine pruned tiles[0-9]+ of 9 ratios reached' "$work/found.json" || fail 'the page of a suite does not begin with its headline'
grep -q 'This device is a CPU' "$work/found.json" || fail 'the page does not warn of a CPU'
# Without the charting library the page has tables alone.
mkdir "$work/plain"
cp "$work/many/results.json" "$work/many/results.csv" "$work/plain"
awk '/^<script>$/ { scripts++ } /^<\/script>$/ { print; skip = 0; next } !skip { print } /^<script>$/ && scripts == 1 { skip = 1 }' \
    "$work/many/report.html" >"$work/plain/report.html"
look "$work/plain" 390 0
# Names of files may hold anything: they must stay text.
evil=$work/'<img src=x onerror=alert(1)>&"</script>.gltf'
mkdir -p "$(dirname "$evil")"
cat >"$evil" <<'GLTF'
{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}], "meshes": [{"primitives": [{"attributes":
{"POSITION": 0}}]}], "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}],
"bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"byteLength": 36,
"uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]}
GLTF
run evil 0 "$evil" --sizes 32x18 --lights 3 --shading deferred --lists brute,tiled --frames 2
look "$work/evil" 390
# Pages are handed around: files go by their names. Pictures are found again all the same.
printf '0 0 2 10  0 1 0\n' >"$work/path.txt"
for folder in one two; do mkdir "$work/$folder-scene" && cp "$evil" "$work/$folder-scene/scene.gltf"; done
run named 0 "$work/one-scene/scene.gltf" "$work/two-scene/scene.gltf" --sizes 32x18 --lights 3 --shading deferred --lists brute,tiled --frames 2 --camera-path "$work/path.txt"
look "$work/named" 390
grep -q "$work" "$work/named/report.html" "$work/evil/report.html" && fail 'the page tells of folders'
grep -q 'one-scene/scene.gltf' "$work/named/report.html" || fail 'scenes with one name are not told apart'
cp "$work/named/report.html" "$work/before.html"
run named 0 "$work/one-scene/scene.gltf" "$work/two-scene/scene.gltf" --sizes 32x18 --lights 3 --shading deferred --lists brute,tiled --frames 2 --camera-path "$work/path.txt" --resume
cmp -s <(grep -o 'scene.gltf|3[^"]*":"data:[^"]*' "$work/before.html") <(grep -o 'scene.gltf|3[^"]*":"data:[^"]*' "$work/named/report.html") ||
    fail 'resuming lost pictures of the page'
[ $failures = 0 ] && echo 'all checks of the page passed'
exit $((failures > 0))
