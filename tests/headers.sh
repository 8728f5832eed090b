#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# headers.sh CC CXX: compiles each public header alone as C11 and as C++17, warnings being errors.
set -euo pipefail
cd "$(dirname "$0")/.."
status=0
for header in include/fanal/*.h; do
    "$1" -std=c11 -Iinclude -Wall -Wextra -Wpedantic -Werror -fsyntax-only -x c - <<<"#include \"${header#include/}\"
typedef int not_empty;" || status=1
    "$2" -std=c++17 -Iinclude -Wall -Wextra -Wpedantic -Werror -fsyntax-only -x c++ - <<<"#include \"${header#include/}\"" || status=1
done
exit $status
