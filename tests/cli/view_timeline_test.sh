#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# view_timeline_test.sh BUILD: the timeline, the frame graph and traces of the window, by replays. Exit status 77: built without the window.
set -u
build=$(cd "$1" && pwd)
fanal=$build/fanal
"$fanal" view --help >/dev/null 2>&1 || { echo "SKIPPED: built without 'fanal view' (Debian: libglfw3-dev libimgui-dev)"; exit 77; }
work=$(mktemp -d)
failures=0
display=
trap '[ -z "$display" ] || kill $display; rm -rf "$work"' EXIT
cd "$work" || exit 1
fail() { echo "FAILED: $*" >&2; [ ! -s out ] || head -c 2000 out >&2; failures=$((failures + 1)); }
# value FILE KEY [FIELD [WORD]]: from the first line of a report that begins with KEY, and has WORD as its second field.
value() { awk -F'\t' -v key="$2" -v field="${3:-2}" -v word="${4:-}" '$1 == key && (word == "" || $2 == word) { print $field; exit }' "$1"; }
lines() { awk -F'\t' -v key="$2" '$1 == key { n++ } END { print n + 0 }' "$1"; }

# Everything fits into a small picture with small letters. The large one after twelve small ones is a spike. Passes are clicked in a frame that is held: bars
# are as wide as passes take long, and those of the next frame would lie elsewhere.
cat >all.txt <<'EOF'
frames 12
report none.tsv
size 480 300
key 291 down 0
key 291 up 0
frames 1
report timeline.tsv
click frame 0 back
click pass gbuffer
report pass.tsv
click cpu wait for the frame
report cpu.tsv
click live
frames 1
click frame 3 back
report frozen.tsv
frames 3
report still.tsv
click live
frames 1
report live.tsv
click save trace
click save trace
trace all.trace
capture timeline.png
key 292 down 0
key 292 up 0
frames 2
report graph.tsv
capture graph.png
click pass gbuffer
report chosen.tsv
click resource depth
report resource.tsv
click find
character 109
character 101
character 116
character 101
character 114
frames 2
report filter.tsv
key 292 down 0
key 292 up 0
report typed.tsv
click show the timeline
set shading=forward
frames 3
report forward.tsv
key 341 down 2
key 341 up 0
panel statistics
click timeline
frames 1
report closed.tsv
set timers=off
click graph
frames 2
report untimed.tsv
set timers=on
set lists=tiled
set shading=deferred
drop builtin:spheres
settle
report other.tsv
trace other.trace
EOF
timeout 900 "$fanal" view --no-cache --validate --device 0 builtin:onetile --shadows off --shading deferred --lists clustered --headless --size 64x36 --scale 0.5 --replay all.txt >out 2>&1 ||
    fail 'the replay ended with an error'

# ---- the timeline ----

[ "$(value none.tsv wide)" = none ] && [ "$(lines none.tsv pass)" -gt 5 ] || fail "the wide panel is open at first: $(value none.tsv wide)"
[ "$(value timeline.tsv wide)" = timeline ] || fail 'F2 does not open the timeline'
for name in 'update the scene' 'declare passes' record submit; do
    [ -n "$(value timeline.tsv cpu 3 "$name")" ] || fail "the CPU's work lacks '$name'"
done
for name in panels render 'wait for the frame'; do [ -n "$(value timeline.tsv window 3 "$name")" ] || fail "the window's work lacks '$name'"; done
# Passes add up to the frame, by their purposes too; they begin one after the other; the CPU's parts but the first two are what the frame says.
awk -F'\t' '
    $1 == "pass" { sum += $3; if ($4 + 0.0002 < end) { print "passes overlap: " $2; bad = 1 } end = $4 + $3; if ($5 != "graphics") { print "queue " $5; bad = 1 } }
    $1 == "purpose" { purposes += $3 }
    $1 == "cpu" { if (parts++ >= 2) own += $3 }
    $1 == "cpu_ms" { cpu = $2 }
    $1 == "passes_ms" { whole = $2 }
    function near(a, b) { return a - b < 0.01 && b - a < 0.01 }
    END { if (!near(sum, whole) || !near(purposes, whole)) { print "passes " sum ", purposes " purposes ", frame " whole; bad = 1 }
          if (!near(own, cpu) || parts < 9) { print "parts " own ", CPU " cpu; bad = 1 } exit bad }' timeline.tsv >out || fail 'the times do not fit'
: >out
[ "$(value timeline.tsv history)" = "$(value timeline.tsv frames)" ] || fail "of $(value timeline.tsv frames) frames $(value timeline.tsv history) are kept"
[ "$(value none.tsv spikes)" -lt "$(value timeline.tsv spikes)" ] || fail "a frame a hundred times as large is no spike: $(value none.tsv spikes), $(value timeline.tsv spikes)"
[ -z "$(value timeline.tsv times)" ] && [ "$(value pass.tsv times)" = gbuffer ] || fail "a click does not choose a pass: $(value pass.tsv times)"
[ "$(value pass.tsv times 3)" = "$(value pass.tsv history)" ] || fail "the pass is known in $(value pass.tsv times 3) frames"
awk -F'\t' '$1 == "times" { exit !($4 > 0 && $4 <= $5 && $5 <= $6) }' pass.tsv || fail "least, median and most: $(grep ^times pass.tsv)"
[ "$(value cpu.tsv times)" = 'wait for the frame' ] || fail "a click does not choose a part of the CPU's work: $(value cpu.tsv times)"
at=$(value frozen.tsv timeline 3) last=$(value frozen.tsv timeline 4)
[ "$(value frozen.tsv timeline)" = frozen ] && [ $((last - at)) -ge 3 ] && [ $((last - at)) -le 6 ] || fail "frozen is $(grep ^timeline frozen.tsv)"
[ "$(value still.tsv timeline 3)" = "$at" ] && [ "$(value still.tsv timeline 4)" -gt "$last" ] || fail "it does not stay: $(grep ^timeline still.tsv)"
[ "$(value live.tsv timeline)" = live ] && [ "$(value live.tsv timeline 3)" = "$(value live.tsv timeline 4)" ] || fail "not live again: $(grep ^timeline live.tsv)"
"$fanal" compare timeline.png graph.png --max-diff 0 >/dev/null 2>&1 && fail 'the panels show the same'

# ---- traces ----

traced=$("$build/tests/check_trace" all.trace 'frame 3' gbuffer 'compile the graph' panels render 'wait for the frame' 'lights in view' 2>out) || fail 'the trace'
[ "${traced:-0}" -ge "$(value live.tsv frames)" ] || fail "the trace has $traced frames, of $(value live.tsv frames)"
"$build/tests/check_trace" trace.json gbuffer >/dev/null 2>out || fail 'the trace that the button writes'
[ -s trace.json ] && [ -s trace-1.json ] || fail 'a second trace takes the place of the first'
"$build/tests/check_trace" other.trace tonemap >/dev/null 2>out || fail 'the trace after another scene'
: >out

# ---- the graph: what the command prints ----

[ "$(value graph.tsv wide)" = graph ] || fail 'F3 does not show the graph'
[ "$(value graph.tsv graph)" = "$(lines graph.tsv pass)" ] || fail "the graph has $(value graph.tsv graph) passes, the frame $(lines graph.tsv pass)"
[ "$(value graph.tsv graph 4)" -gt 10 ] && [ "$(value graph.tsv shown)" = "$(value graph.tsv graph 3)" ] || fail "the graph: $(grep ^graph graph.tsv)"
grep -q $'^use\tgbuffer\twrites\tdepth\tDEPTH_ATTACHMENT_OPTIMAL' chosen.tsv || fail "what the chosen pass uses: $(grep ^use chosen.tsv)"
[ "$(lines graph.tsv use)" = 0 ] || fail 'a pass is chosen before the click'
[ "$(value resource.tsv resource)" = depth ] && [ "$(lines resource.tsv use)" = 0 ] || fail "a click does not choose a resource: $(value resource.tsv resource)"
[ "$(value filter.tsv shown)" -lt "$(value graph.tsv shown)" ] && [ "$(value filter.tsv shown)" -gt 0 ] || fail "the filter leaves $(value filter.tsv shown)"
[ "$(value untimed.tsv resource)" = depth ] && [ "$(value other.tsv resource)" = depth ] || fail 'another plan loses the resource that was chosen'
[ "$(value typed.tsv wide)" = graph ] || fail 'a key that is typed into a field closes the panel'
[ "$(value forward.tsv wide)" = timeline ] && [ -n "$(value forward.tsv pass 3 forward)" ] || fail 'the timeline does not follow'
[ "$(value closed.tsv wide)" = none ] || fail "the button does not close the panel: $(value closed.tsv wide)"
[ "$(lines untimed.tsv pass)" = 0 ] && [ "$(value untimed.tsv graph)" -gt 5 ] || fail 'without timers there is no graph'
[ "$(value other.tsv scene)" = builtin:spheres ] && [ "$(value other.tsv graph)" = "$(lines other.tsv pass)" ] && [ "$(value other.tsv graph)" != "$(value untimed.tsv graph)" ] ||
    fail "the graph of another scene: $(grep ^graph other.tsv), before $(grep ^graph untimed.tsv)"

# ---- what auto measured ----

cat >auto.txt <<'EOF'
frames 1
report first.tsv
frames 60
size 480 300
panel statistics
click candidates
frames 1
report later.tsv
EOF
timeout 900 "$fanal" view --no-cache --validate --device 0 builtin:onetile --shadows off --shading deferred --lists auto --headless --size 48x27 --scale 0.5 --replay auto.txt >out 2>&1 ||
    fail 'the replay with auto'
[ "$(lines first.tsv candidate)" -gt 2 ] || fail 'the candidates are not told'
[ "$(lines none.tsv candidate)" = 0 ] || fail 'candidates without auto'
# It decides when the pipelines are there, which may take longer; what it tells fits together at any time.
awk -F'\t' '$1 == "candidate" { if (($4 > 0) != ($5 > 0)) bad = 1; if ($6 == "chosen") { chosen++; lists = $3; best = $4 } if ($4 > 0 && (least == "" || $4 < least)) least = $4 }
    $1 == "lists" { used = $2 } END { exit bad || chosen > 1 || (chosen == 1 && (lists != used || best != least)) }' later.tsv ||
    fail "auto after 60 frames: $(grep ^candidate later.tsv)"

# ---- nothing to see ----

printf 'key 291 down 0\nkey 291 up 0\nframes 2\nkey 292 down 0\nkey 292 up 0\nframes 2\nreport empty.tsv\ntrace empty.trace\nsize 1 1\nframes 1\nsize 0 0\nframes 1\n' >empty.txt
timeout 900 "$fanal" view --no-cache --validate --device 0 --headless --size 97x61 --scale 0.5 --light --replay empty.txt >out 2>&1 || fail 'without a scene'
[ "$(value empty.tsv graph)" = "$(lines empty.tsv pass)" ] && "$build/tests/check_trace" empty.trace >/dev/null 2>out || fail 'without a scene'

# ---- what cannot be written ----

printf 'frames 1\ntrace no-folder/a.trace\n' >bad.txt
timeout 900 "$fanal" view --no-cache --device 0 builtin:onetile --shadows off --shading deferred --lists clustered --headless --size 16x16 --replay bad.txt >out 2>&1 && fail 'a trace into no folder'
grep -q 'no-folder/a.trace' out || fail 'no word of the trace that was not written'
# ---- in a window ----

if command -v Xvfb >/dev/null; then
    Xvfb -displayfd 3 -screen 0 400x300x24 -nolisten tcp 3>number 2>xvfb &
    display=$!
    for _ in $(seq 6000); do [ -s number ] && break; sleep 0.1; done
    printf 'frames 2\nkey 291 down 0\nkey 291 up 0\nframes 2\nreport window.tsv\ntrace window.trace\n' >window.txt
    DISPLAY=:$(<number) timeout 900 "$fanal" view --no-cache --validate --device 0 builtin:onetile --shadows off --shading deferred --lists clustered --size 160x90 --scale 0.5 --replay window.txt >out 2>&1 || fail 'the window'
    "$build/tests/check_trace" window.trace acquire render present 'wait for the frame' >/dev/null 2>out || fail 'the trace of a window'
    [ "$(value window.tsv wide)" = timeline ] && [ -n "$(value window.tsv window 3 present)" ] || fail 'the timeline of a window'
else
    echo 'SKIPPED in part: no Xvfb (Debian: xvfb)'
fi
[ $failures = 0 ] && echo 'all checks of the timeline passed'
exit $((failures > 0))
