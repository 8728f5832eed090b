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
frames 4
capture viewer.png
set debug=lights
frames 3
capture viewer-debug.png
END
(cd "$work" && "$fanal" view builtin:hall --lights 256 --size 1280x720 --headless --replay events)
cat >"$work/events" <<END
set lists=clustered
setb lists=tiled
setb debug=lights
compare split
frames 3
capture viewer-compare.png
END
(cd "$work" && "$fanal" view builtin:interior --size 1280x720 --headless --replay events)
for name in viewer viewer-debug viewer-compare; do convert "$work/$name.png" -colors 224 -define png:compression-level=9 "docs/images/$name.png"; done
