#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Enforces the layers: who may include whom, Vulkan calls in src/gpu only, barriers in src/gpu and src/graph only, shaders
# that work the same for every size of subgroups, output of the command that no name from a file can break, and a licence line on every source file. Prints each offence as FILE:LINE; exits 1 if there is any.
set -u # not -e: a search that finds nothing is good news
cd "$(dirname "$0")/.." || exit

# What a layer may include besides its own folder, the public headers, and the structs in shaders/.
allowed() {
    case $1 in
    base) echo "" ;;
    gpu | image) echo "base" ;;
    graph) echo "base gpu" ;;
    scene) echo "base image" ;;
    ray) echo "base scene image" ;;
    passes) echo "base gpu graph" ;;
    render) echo "base gpu graph image scene ray passes" ;;
    *) echo "unknown" ;;
    esac
}

offences=$(mktemp)
trap 'rm -f "$offences"' EXIT
# Tests stand above all layers.
sources() { find "$@" -name '*_test.c' -prune -o \( -name '*.c' -o -name '*.h' \) -print; }

for folder in src/*/; do
    layer=$(basename "$folder")
    may=" $layer $(allowed "$layer") "
    [[ $may != *unknown* ]] || echo "src/$layer: is no layer known to tools/check_layers.sh" >>"$offences"
    files=$(sources "$folder")
    [ -n "$files" ] || continue
    grep -nHE '^[[:space:]]*#[[:space:]]*include[[:space:]]*"' $files | sed -E 's/^([^:]*:[0-9]+):[^"]*"([^"]*)".*/\1 \2/' |
        while read -r place header; do
            top=${header%%/*}
            case $header in
            *..*) echo "$place: includes \"$header\" by a way up" >>"$offences" ;;
            fanal/*) ;;
            */*) [ ! -d "src/$top" ] || [[ $may == *" $top "* ]] || echo "$place: $layer must not include $header" >>"$offences" ;;
            esac
        done
    # Names that only Vulkan gives: calls, and outside gpu and graph barriers.
    code='^[^:]*:[0-9]+:[[:space:]]*(/?\*|//)'
    if [ "$layer" != gpu ]; then
        grep -nHE '\bvk[A-Z][A-Za-z0-9]*[[:space:]]*\(' $files | grep -vE "$code" | sed 's/$/   <- Vulkan call outside src\/gpu/' >>"$offences" || true
    fi
    if [ "$layer" != gpu ] && [ "$layer" != graph ]; then
        grep -nHiE '\b(Vk[A-Za-z]*Barrier|vkCmdPipelineBarrier|gpu_[a-z_]*barrier)' $files | grep -vE "$code" |
            sed 's/$/   <- barrier outside src\/gpu and src\/graph/' >>"$offences" || true
    fi
done

# No include cycles within a layer. A module is a .c and .h of one name, or a lone header. Known cycles must go.
known='graph/graph>graph/graph_internal ray/ray_internal>ray/ray_scene image/bc6h_encode>image/bc6h image/blocks>image/texture image/codec>image/image image/codec>image/texture scene/scene_environment>scene/scene
passes/shadow/ray_query>passes/shadow/rays passes/shadow/maps>passes/lights/light_list passes/shadow/split>passes/shadow/pages
passes/visibility/visible>passes/visibility/visibility passes/geometry/occlusion>passes/geometry/cull'
cycles=$(grep -nHE '^[[:space:]]*#[[:space:]]*include[[:space:]]*"' $(sources src) | awk -F'[:"]' -v known="$known" '
    function module(path) { sub(/^src\//, "", path); sub(/\.[ch]$/, "", path); return path }
    BEGIN { count = split(known, rows, /[ \n]+/); for (i = 1; i <= count; i++) skip[rows[i]] = 1 }
    { from = module($1); to = module($4); if (from != to && $4 ~ /\// && !((from ">" to) in skip)) print from, to }' | tsort 2>&1 >/dev/null | sed -n 's/^tsort: \([a-z].*\/.*\)/\1/p')
[ -z "$cycles" ] || echo "$cycles" | sed 's/^/src\//; s/$/   <- in a cycle of includes/' >>"$offences"

# Numbers as text: what C's functions read and write depends on the locale.
grep -rnE '\b(strto(f|d|ld)|atof|v[a-z]*printf)(_l)?[[:space:]]*\(|\bs?n?f?printf[[:space:]]*\(.*%[-+ #0-9.*]*l?[aefgAEFG]\b|scanf[[:space:]]*\(.*%\*?[0-9]*l?[aefg]' \
    --include='*.c' --include='*.h' src | grep -vE '^src/base/number\.c:|_test\.c:|/image_samples\.c:' | sed 's/$/   <- text of numbers outside src\/base\/number.c/' >>"$offences" || true

# The command uses the public headers and its own.
[ ! -d cli ] || { grep -nHE '^[[:space:]]*#[[:space:]]*include[[:space:]]*"' $(sources cli) /dev/null || true; } |
    sed -E 's/^([^:]*:[0-9]+):[^"]*"([^"]*)".*/\1 \2/' | while read -r place header; do
    case $header in
    fanal/*) ;;
    *) [ -e "cli/${header#cli/}" ] || echo "$place: the command must not include $header" >>"$offences" ;;
    esac
done

# What the command prints goes through cli/print.h, and its JSON through cli/json_text.h: names of files, and from them, must not reach a terminal as they are.
# puts() and fputs() are for literals; where a variable has only Fanal's own text, its line says so.
for file in $(sources cli | grep -vE '^cli/(print|json_text)\.[ch]$') $(find cli -name '*.cpp'); do
    grep -q '#include "print.h"' "$file" ||
        grep -nHE '(^|[^a-z_])v?f?printf[[:space:]]*\(' "$file" | sed 's/$/   <- prints without print.h/' >>"$offences"
    grep -nHE '(^|[^a-z_])(vprintf|vdprintf|dprintf|perror|psignal|warnx?|errx?)[[:space:]]*\(' "$file" | sed 's/$/   <- prints past print.h/' >>"$offences"
    grep -nHE '(^|[^a-z_])f?puts[[:space:]]*\([^"A-Z]' "$file" | grep -vE '/\* own text \*/|puts\([^"]*\? "' | sed 's/$/   <- printf() with "%s" is for text that is not a literal/' >>"$offences"
    grep -nHE '(^|[^a-z_])json_dump[a-z_]*[[:space:]]*\(' "$file" | sed 's/$/   <- json_text.h writes JSON/' >>"$offences"
done

# Quads have four invocations everywhere. What other operations on subgroups give depends on their size, unless it is shown that it does not.
grep -rnHE '#[[:space:]]*extension[[:space:]]+GL_[A-Z]+_shader_(subgroup|ballot|group)' --include='*.glsl' src shaders | grep -v GL_KHR_shader_subgroup_quad |
    sed 's/$/   <- depends on the size of subgroups/' >>"$offences" || true

find CMakeLists.txt build.sh .ci cmake include src shaders cli examples tests tools bench -type f \
    \( -name '*.[ch]' -o -name '*.cpp' -o -name '*.glsl' -o -name '*.sh' -o -name '*.cmake' -o -name '*.in' -o -name CMakeLists.txt \
    -o -name run \) -print0 2>/dev/null | xargs -0 awk '
    FNR == 1 { if (file && !found) print file ": has no SPDX line"; file = FILENAME; found = 0 }
    FNR <= 2 && /SPDX-License-Identifier: MIT/ { found = 1 }
    END { if (file && !found) print file ": has no SPDX line" }' >>"$offences"

if [ -s "$offences" ]; then
    cat "$offences" >&2
    exit 1
fi
