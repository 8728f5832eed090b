#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The pictures of docs/viewer.md: viewer_pictures.sh FANAL.
set -euo pipefail
fanal=$(realpath "$1")
cd "$(dirname "$0")/.."
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cat >"$work/events" <<END
set lists=clustered
key 341 down 2
move 640 330
button 0 down 2
button 0 up 2
key 341 up 0
panel options
panel inspect
frames 4
capture viewer.png
set debug=lights
frames 3
capture viewer-debug.png
END
(cd "$work" && "$fanal" view builtin:hall --lights 1280 --size 1280x720 --headless --replay events)
cat >"$work/events" <<END
set lists=clustered
setb lists=tiled
setb debug=lights
compare split
frames 3
capture viewer-compare.png
END
(cd "$work" && "$fanal" view builtin:interior --size 1280x720 --headless --replay events)
cat >"$work/events" <<END
frames 3
set lists=tiled
frames 3
set lists=clustered
move 800 200
button 0 down 0
move 860 210
frames 3
button 0 up 0
frames 3
key 291 down 0
key 291 up 0
frames 2
click pass deferred
frames 1
capture viewer-timeline.png
key 292 down 0
key 292 up 0
frames 2
click pass gbuffer
capture viewer-graph.png
END
(cd "$work" && "$fanal" view builtin:lamps --size 1280x720 --headless --replay events)
cat >"$work/events" <<END
set lists=clustered
key 76 down 0
key 76 up 0
move 527 465
button 0 down 2
button 0 up 2
move 440 200
panel inspect
frames 3
capture viewer-pick.png
END
(cd "$work" && "$fanal" view builtin:spheres --shadows off --size 1280x720 --headless --replay events)
printf 'frames 3\ncapture viewer-start.png\n' >"$work/events"
(cd "$work" && "$fanal" view --size 1280x720 --headless --replay events)
for picture in "$work"/*.png; do pngquant --force --output "docs/images/${picture##*/}" 224 "$picture"; done
