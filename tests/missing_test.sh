#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# `cmake -B build` where packages are missing names all of them at once, with the packages of Debian that have them, which are those that
# tools/setup.sh installs. Usage: missing_test.sh CC
set -u
compiler=$(command -v "$1")
source=$(cd "$(dirname "$0")/.." && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failures=0
fail() { echo "FAILED: $*" >&2; failures=$((failures + 1)); }
configure() { # OPTIONS…: fails, and leaves the packages that it asks for in $work/packages
    rm -rf "$work/build"
    cmake -S "$source" -B "$work/build" -G Ninja -DCMAKE_MAKE_PROGRAM="$(command -v ninja)" -DCMAKE_C_COMPILER="$compiler" \
        "$@" >"$work/out" 2>&1 && fail "configured with $*"
    grep -q 'These are missing' "$work/out" || fail "no list with $*: $(tail -n 20 "$work/out")"
    sed -n 's/.*(Debian and Ubuntu: \([a-z0-9.+-]*\))$/\1/p' "$work/out" | sort -u >"$work/packages"
}

# Nothing is found outside of CMake and the compiler.
configure -DFANAL_TESTS=ON -DCMAKE_FIND_USE_CMAKE_SYSTEM_PATH=OFF -DCMAKE_FIND_USE_SYSTEM_ENVIRONMENT_PATH=OFF \
    -DCMAKE_DISABLE_FIND_PACKAGE_OpenEXR=ON -DCMAKE_DISABLE_FIND_PACKAGE_meshoptimizer=ON -DCMAKE_DISABLE_FIND_PACKAGE_embree=ON
while read -r package; do
    grep -qE "(^|[ (])${package//+/\\+}([ )]|$)" "$source/tools/setup.sh" || fail "tools/setup.sh does not install $package"
done <"$work/packages"
# What setup.sh calls the packages that the library is made of, and those that tests need.
for package in $(sed -n '/to build$/,/to run/p' "$source/tools/setup.sh" | sed 's/#.*//' | tr ' ' '\n' | grep -E '^(lib.*-dev|glslang-tools|spirv-tools|pkg-config)$') libcmocka-dev g++; do
    case $package in libc6-dev | libdraco-dev | libglfw3-dev | libimgui-dev | libopenxr-dev) continue ;; esac # the first is the compiler's; the build does without the others
    grep -qxF "$package" "$work/packages" || fail "nothing says that $package is missing: $(tr '\n' ' ' <"$work/packages")"
done

# One that is missing is named alone; a build without tests does not ask for what they need.
configure -DCMAKE_DISABLE_FIND_PACKAGE_OpenEXR=ON -DCMAKE_DISABLE_FIND_PACKAGE_MPI=ON
tr -s '\n ' ' ' <"$work/out" | grep -q "'fanal cave' will not run under mpirun: there is no MPI (Debian and Ubuntu: libopenmpi-dev openmpi-bin" || fail 'nothing says that MPI is missing'
[ "$(cat "$work/packages")" = libopenexr-dev ] || fail "without OpenEXR: $(cat "$work/packages")"
configure -DFANAL_TESTS=OFF -DFANAL_PROGRAMS=OFF -DCMAKE_FIND_USE_CMAKE_SYSTEM_PATH=OFF -DCMAKE_FIND_USE_SYSTEM_ENVIRONMENT_PATH=OFF
grep -qE '^(libcmocka-dev|g\+\+)$' "$work/packages" && fail "a build without tests asks for $(tr '\n' ' ' <"$work/packages")"

# Fuzzers are made of the command's files, whether or not the command is asked for.
rm -rf "$work/build"
cmake -S "$source" -B "$work/build" -G Ninja -DCMAKE_MAKE_PROGRAM="$(command -v ninja)" -DCMAKE_C_COMPILER="$compiler" -DFANAL_FUZZ=ON -DFANAL_TESTS=OFF \
    -DFANAL_PROGRAMS=OFF >"$work/out" 2>&1 || fail "the fuzzers alone are not configured: $(grep -A 5 Error "$work/out" | head -n 20)"

[ $failures = 0 ] && echo 'what is missing is named'
exit $((failures > 0))
