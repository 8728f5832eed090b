#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# What bash completes: completion_test.sh FANAL
cd "$(dirname "$0")/../.." || exit
source cli/completion/fanal.bash
failures=0
program=$1

# completes LINE WANTED…: all of them, and with a last argument of "!" nothing else.
completes() {
    local line=$1 word only=''
    shift
    [ "${!#}" != '!' ] || { only=yes; set -- "${@:1:$#-1}"; }
    COMP_LINE="fanal $line" COMP_POINT=$((${#line} + 6))
    read -ra COMP_WORDS <<<"$program $line"
    [[ $line != *' ' ]] || COMP_WORDS+=('')
    COMP_CWORD=$((${#COMP_WORDS[@]} - 1))
    _fanal
    for word; do
        printf '%s\n' "${COMPREPLY[@]}" | grep -qxF -- "$word" || { echo "FAILED: '$line' does not become $word, but ${COMPREPLY[*]}"; failures=$((failures + 1)); }
    done
    [ -z "$only" ] || [ ${#COMPREPLY[@]} = $# ] || { echo "FAILED: '$line' becomes ${COMPREPLY[*]}"; failures=$((failures + 1)); }
}
completes 're' render !
completes 'he' help !
completes 'help tra' trace !
completes 'builtin:ha' hall !
completes 'render builtin:hall --shadi' --shading !
completes 'bench --war' --warm-up !
completes 'render --shading vi' visibility virtual-texturing !
completes 'render --lists 2' 2.5d !
completes 'render --msaa ' 1 2 4 8 !
completes 'render --gbuffer s' siege stalker !
completes 'render --set coarse.n' coarse.normal-degrees= !
completes 'render --set tiles.size=' 8 16 32 64 !
completes 'render --set coarse.split=a' albedo !
completes 'bench --vary dais.mode=' target list all !
completes 'render --set visibility.grid=o' on off !
completes 'render builtin:gl' glass !
completes 'tr' trace !
completes 'trace builtin:hall --bou' --bounces !
completes 'trace builtin:ci' city !
completes 'xr builtin:ci' city !
completes 'info READ' README.md !
completes 'ca' cave !
completes 'cave builtin:hall --displ' --displays !
completes 'cave builtin:hall --displays builtin:th' three !
completes 'cave builtin:ha' hall !
[ $failures = 0 ] && echo 'all completions are right'
exit $((failures > 0))
