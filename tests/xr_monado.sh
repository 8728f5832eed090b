#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# xr_monado.sh BUILD: 300 frames of `fanal xr` in Monado's simulated headset, with its null compositor (no display). Exit status 77: Monado is not installed
# (Debian 13: monado-service libopenxr1-monado), or the build has no 'fanal xr'.
set -u
build=$(cd "$1" && pwd)
fanal=$build/fanal
skip() { echo "SKIPPED: $*"; exit 77; }
"$fanal" xr --help >/dev/null 2>&1 || skip "built without 'fanal xr' (Debian: libopenxr-dev)"
command -v monado-service >/dev/null || skip "monado-service is not installed (Debian 13: monado-service libopenxr1-monado): nothing was tried with a real OpenXR runtime"
runtime=$(find /usr/share/openxr/1 /etc/xdg/openxr/1 /usr/local/share/openxr/1 -name 'openxr_monado*.json' 2>/dev/null | head -n 1)
[ -n "$runtime" ] || skip "Monado's openxr_monado.json was not found (Debian 13: libopenxr1-monado)"
work=$(mktemp -d)
service=''
trap '[ -z "$service" ] || kill "$service" 2>/dev/null; wait; rm -rf "$work"' EXIT
mkdir -m 700 "$work/run"
export XDG_RUNTIME_DIR=$work/run XR_RUNTIME_JSON=$runtime XDG_CACHE_HOME=$work/cache
export XRT_COMPOSITOR_NULL=1 SIMULATED_ENABLE=1 XRT_NO_STDIN=1
monado-service >"$work/service" 2>&1 </dev/null &
service=$!
for _ in {1..100}; do [ -S "$XDG_RUNTIME_DIR/monado_comp_ipc" ] && break; sleep 0.1; done
[ -S "$XDG_RUNTIME_DIR/monado_comp_ipc" ] || { echo "FAILED: monado-service does not start:"; tail -n 20 "$work/service"; exit 1; }
timeout 900 "$fanal" xr builtin:onetile --frames 300 --shading forward --lists all --shadows off --exposure 5 --validate --stats "$work/stats.json" >"$work/out" 2>&1
status=$?
cat "$work/out"
[ $status = 0 ] || { echo "FAILED: exit status $status"; tail -n 20 "$work/service"; exit 1; }
jq -e '.frames.rendered >= 300 and (.sessions.states | index("focused") != null) and .sessions.states[-1] == "exiting" and .sessions.lost == 0' "$work/stats.json" >/dev/null ||
    { echo 'FAILED: the session was not as it should be:'; cat "$work/stats.json"; exit 1; }
