#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# tools/setup.sh on a machine that has nothing, with an apt that only says what it would do: which packages are asked for, that the cost is
# told before, and that a lock of another apt is waited for. Usage: setup_test.sh
set -u
setup=$(cd "$(dirname "$0")/.." && pwd)/tools/setup.sh
command -v dpkg >/dev/null || { echo 'SKIPPED: no Debian'; exit 77; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failures=0
fail() { echo "FAILED: $*" >&2; failures=$((failures + 1)); }

mkdir "$work/bin"
stub() { printf '#!/bin/bash\n%s\n' "$2" >"$work/bin/$1"; chmod +x "$work/bin/$1"; }
stub dpkg-query 'exit 1'
stub id 'echo 0'
stub sleep 'echo "sleep $*" >>'"$work/log"
stub apt-get '
case "$*" in indextargets*) echo "bookworm-backports main http://mirror.example"; exit ;; esac
echo "apt-get $*" >>'"$work/log"'
case "$*" in
*update) if [ -e '"$work/locked"' ]; then rm '"$work/locked"'; echo "E: Could not get lock /var/lib/apt/lists/lock. It is held by process 7 (apt-get)"; exit 100; fi
    if [ -e '"$work/broken"' ]; then echo "E: The repository is gone"; exit 100; fi ;;
*--assume-no*) printf "0 upgraded, 40 newly installed, 0 to remove and 1 not upgraded.\nNeed to get 87.5 MB of archives.\nAfter this operation, 402 MB of additional disk space will be used.\nAbort.\n"; exit 1 ;;
esac'

# run OPTION…: what it says is in out, what it asks of apt in log.
run() {
    rm -f "$work/log"
    PATH="$work/bin:$PATH" "$setup" "$@" >"$work/out" 2>&1
}
asks() { grep -E -- ' -y install ' "$work/log" | grep -qE "[ ]$1([ /]|\$)"; }

touch "$work/locked"
run || fail "setup: $(cat "$work/out")"
for package in gcc cmake glslang-tools libjansson-dev libdraco-dev 'g\+\+' libglfw3-dev libimgui-dev libopenxr-dev fonts-dejavu-core mesa-vulkan-drivers; do asks $package || fail "$package is not asked for"; done
for package in libcmocka-dev vulkan-validationlayers xvfb python3-pil libopenmpi-dev clang chromium; do
    asks "${package//+/\\+}" && fail "the command alone gets $package"
done
grep -q 'waiting for another apt' "$work/out" && grep -q '^sleep' "$work/log" || fail 'the lock is not waited for'
grep -v -- '-o DPkg::Lock::Timeout=[1-9]' "$work/log" | grep '^apt-get' && fail 'apt is called without waiting for its lock'
cost=$(grep -n 'Need to get 87.5 MB' "$work/out" | cut -d: -f1)
disk=$(grep -n 'After this operation, 402 MB' "$work/out" | cut -d: -f1)
[ -n "$cost" ] && [ -n "$disk" ] || fail "the cost is not told: $(cat "$work/out")"
tail -n 2 "$work/log" | head -n 1 | grep -q -- --assume-no || fail 'the cost is not asked for before the installation'

run --tests || fail "setup --tests: $(cat "$work/out")"
for package in libcmocka-dev vulkan-validationlayers xvfb python3-pil libopenmpi-dev openmpi-bin; do asks $package || fail "--tests does not get $package"; done

touch "$work/broken"
run && fail 'a broken apt is taken for success'
grep -q 'The repository is gone' "$work/out" && grep -q "'apt-get update' failed" "$work/out" || fail "what apt said is lost: $(cat "$work/out")"
grep -q -- ' -y install ' "$work/log" && fail 'something is installed from a broken apt'
[ $failures = 0 ] && echo 'all checks of the set-up passed'
exit $((failures > 0))
