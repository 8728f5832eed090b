#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# run.sh cmake|pkgconfig BUILD CC [CFLAG…]: installs BUILD into a prefix, moves the prefix, builds the consumer and
# examples/hello.c against it and runs them.
set -euo pipefail
kind=$1 build=$2 compiler=$3
shift 3
source=$(cd "$(dirname "$0")" && pwd)
work=$build/consumer/$kind
rm -rf "$work"
mkdir -p "$work"
cmake --install "$build" --prefix "$work/first" >"$work/install.log"
mv "$work/first" "$work/prefix"
folder=$(dirname "$(find "$work/prefix" -name 'libfanal.*' -print -quit)")
case $kind in
cmake)
    cmake -S "$source" -B "$work/build" -DCMAKE_C_COMPILER="$compiler" -DCMAKE_C_FLAGS="$*" -DCMAKE_PREFIX_PATH="$work/prefix" >"$work/configure.log"
    cmake --build "$work/build" >"$work/build.log"
    programs=$work/build
    ;;
pkgconfig)
    export PKG_CONFIG_PATH=$folder/pkgconfig
    static=; [ -e "$folder/libfanal.so" ] || static=--static
    programs=$work
    for file in "$source/consumer.c" "$source/../../examples/hello.c"; do
        "$compiler" -std=c11 "$@" "$file" -o "$programs/$(basename "$file" .c)" $(pkg-config $static --cflags --libs fanal)
    done
    ;;
esac
export LD_LIBRARY_PATH=$folder
"$programs/consumer"
"$programs/hello" "builtin:spheres?lights=0" "$work/hello.png"
[ -s "$work/hello.png" ]
