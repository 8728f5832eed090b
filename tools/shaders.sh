#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# What GPUs' compilers make of the shaders, without a GPU (tools/shader_report.c), against bench/results/radv-FAMILY/pipelines.csv.
#   shaders.sh show SHADER_REPORT     compiles for both families; a table, the least occupied first, and what differs from the files
#   shaders.sh record SHADER_REPORT   the same, and replaces the files
#   shaders.sh check SHADER_REPORT    one family; fails if a shader lost occupancy or got more spills or scratch memory than in the file,
#                                     or if shaders were added or removed. Nothing is compiled when the file was made of the same pipelines by
#                                     the same compilers. Exit status 77: this machine has no driver to compile with
set -euo pipefail
verb=$1 report=$(realpath "$2")
cd "$(dirname "$0")/.."
driver=$(ls /usr/share/vulkan/icd.d/radeon_icd*.json 2>/dev/null | head -n 1)
[ -n "$driver" ] || { echo 'SKIPPED: there is no radv here (Debian: mesa-vulkan-drivers)'; exit 77; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# What the shaders were compiled with before the driver got them: other versions give other code.
tools="glslang $(glslangValidator --version | sed -n 's/^Glslang Version: //p'), spirv-opt $(spirv-opt --version 2>&1 | grep -oE 'v[0-9]+\.[0-9]+[^ ]*' | head -n 1)"

compile() { # FAMILY [OPTION]: into $work/FAMILY.csv
    RADV_FORCE_FAMILY=$1 VK_DRIVER_FILES=$driver VK_ICD_FILENAMES=$driver MESA_SHADER_CACHE_DISABLE=true "$report" "${@:2}" >"$work/$1.csv" 2>"$work/log" ||
        { cat "$work/log" >&2; exit 1; }
    sed -i "1s|\$|; $tools|" "$work/$1.csv"
}

compilers() { sed -n -E '1s/.*(Mesa [0-9.]+)[^;]*;.*(; glslang.*)/\1\2/p' "$1"; } # of a file
inputs() { sed -n -E '1s/.*; (inputs [0-9a-f]+);.*/\1/p' "$1"; }

# compare OLD NEW: what differs; fails where something became worse. Other versions of the compilers
# give other code: then only spills and scratch count.
compare() {
    local strict=1
    [ "$(compilers "$1")" = "$(compilers "$2")" ] || strict=0
    awk -F, -v strict=$strict '
    /^#/ { next }
    $1 == "shader" { for (i = 1; i <= NF; i++) { at[$i] = i; name[i] = $i } count = at["code_bytes"]; next }
    FNR == NR { for (i = 2; i <= count; i++) old[$1, i] = $i; known[$1] = 1; next }
    {
        seen[$1] = 1
        if (!known[$1]) { print "  " $1 ": new, " $at["waves"] " waves, " $at["vgprs"] " vgprs"; worse++; next }
        text = ""; bad = 0
        for (i = 2; i <= count; i++) {
            if ($i == old[$1, i]) continue
            if (strict) text = text " " name[i] " " old[$1, i] " -> " $i
            if (name[i] ~ /spilled|scratch/ && $i > old[$1, i] || strict && name[i] == "waves" && $i < old[$1, i]) { bad++; if (!strict) text = text " " name[i] " " old[$1, i] " -> " $i }
        }
        if (text != "") print (bad ? "W " : "  ") $1 ":" text
        worse += bad
    }
    END {
        for (s in known) if (!seen[s]) { print "  " s ": gone"; worse++ }
        if (!strict) print "  (compiled by other versions of Mesa or glslang than the file: only spills and scratch memory are compared)"
        exit worse > 0
    }' "$1" "$2"
}

families='navi31 navi21'
[ "$verb" != check ] || families=navi31
status=0
for family in $families; do
    file=bench/results/radv-$family/pipelines.csv
    if [ "$verb" = check ] && [ -n "$(inputs "$file")" ]; then
        compile $family --inputs
        if [ "$(inputs "$file")$(compilers "$file")" = "$(inputs "$work/$family.csv")$(compilers "$work/$family.csv")" ]; then
            echo "$file was made of the same pipelines, by the same compilers"
            continue
        fi
    fi
    compile $family
    if [ "$verb" = show ]; then
        echo "$(sed -n 's/^# //p' "$work/$family.csv"): the 40 shaders with the fewest waves"
        { sed -n 2p "$work/$family.csv"; sed 1,2d "$work/$family.csv" | sort -t, -k3,3n -k4,4nr | head -n 40; } | cut -d, -f1-11 | column -s, -t
    fi
    if [ ! -e "$file" ]; then
        echo "$file does not exist yet"
        [ "$verb" = record ] || status=1
    else
        echo "radv-$family, compared with $file (W: worse):"
        compare "$file" "$work/$family.csv" >"$work/differences" || [ "$verb" != check ] || status=1
        cat "$work/differences"
        [ -s "$work/differences" ] || echo '  the same'
    fi
    if [ "$verb" = record ]; then
        mkdir -p "$(dirname "$file")"
        cp "$work/$family.csv" "$file.new"
        mv "$file.new" "$file"
        echo "wrote $file"
    fi
done
[ "$verb" != record ] || bench/page.sh update
[ $status = 0 ] || echo 'If that is meant, run ./build.sh shaders --record and commit the files with the change.' >&2
exit $status
