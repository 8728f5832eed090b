#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# run.sh cmake|pkgconfig BUILD CC [CFLAG…]: installs BUILD into a prefix, moves the prefix, builds the consumer and
# examples/hello.c against it and runs them; by pkg-config it builds the example of README.md too.
# run.sh subproject BUILD CC: configures a project that has Fanal's sources as a part, compiles its program, and looks whether anything
# of Fanal's leaks into it. The library is not built once more: whether all that it links is known shows when the build is generated.
set -euo pipefail
kind=$1 build=$2 compiler=$3
shift 3
source=$(cd "$(dirname "$0")" && pwd)
work=$build/consumer/$kind
rm -rf "$work"
mkdir -p "$work"
if [ "$kind" = subproject ]; then
    fail() { echo "subproject: $*" >&2; exit 1; }
    cmake -S "$source/subproject" -B "$work/build" -G Ninja -DCMAKE_C_COMPILER="$compiler" -DCMAKE_EXPORT_COMPILE_COMMANDS=ON >"$work/configure.log"
    ! grep -i cmocka "$work/build/CMakeCache.txt" || fail "it looks for cmocka"
    tests=$(ctest --test-dir "$work/build" -N)
    grep -q 'Total Tests: 1$' <<<"$tests" || fail "there are other tests than its own: $tests"
    ! grep -r 'file(INSTALL' "$work/build/fanal" --include=cmake_install.cmake || fail "Fanal installs itself"
    command=$(sed -n 's/^ *"command": "\(.*consumer\.c\)",$/\1/p' "$work/build/compile_commands.json")
    [ -n "$command" ] || fail "consumer.c is not compiled"
    ! grep -E -- '-Wall|-fvisibility|-ffp-contract|-fno-math-errno|-fPIC|_GNU_SOURCE|-O|-g|-std' <<<"$command" || fail "it is compiled with flags of Fanal's"
    mkdir -p "$work/build/CMakeFiles/consumer.dir$source"
    (cd "$work/build" && eval "$command")
    exit
fi
cmake --install "$build" --prefix "$work/first" >"$work/install.log"
mv "$work/first" "$work/prefix"
wanted=(share/doc/fanal/LICENSE)
[ ! -e "$work/prefix/bin/fanal" ] || wanted+=(share/man/man1/fanal.1 share/fanal/stats.schema.json)
! "$work/prefix/bin/fanal" view --help >/dev/null 2>&1 || wanted+=(share/applications/fanal.desktop)
for file in "${wanted[@]}"; do [ -s "$work/prefix/$file" ] || { echo "$file is not installed" >&2; exit 1; }; done
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
    awk '/^```/ { inside = $0 == "```c"; next } inside' "$source/../../README.md" >"$work/readme.c" # its example is a whole program
    for file in "$source/consumer.c" "$source/../../examples/hello.c" "$work/readme.c"; do
        "$compiler" -std=c11 "$@" "$file" -o "$programs/$(basename "$file" .c)" $(pkg-config $static --cflags --libs fanal) \
            -Wl,-rpath,"$(pkg-config --variable=libdir fanal)"
    done
    ;;
esac
unset LD_LIBRARY_PATH # programs know where the library is, as docs/embedding.md tells
"$programs/consumer"
"$programs/hello" "builtin:spheres?lights=0" "$work/hello.png"
[ -s "$work/hello.png" ]
