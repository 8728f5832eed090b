#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# api.sh check LIBFANAL.so: fails unless the exported symbols, the functions that include/fanal declares and docs/api.txt
# are the same. api.sh update LIBFANAL.so: writes docs/api.txt anew; the change is part of the commit that makes it.
set -euo pipefail
library=$(realpath "$2")
cd "$(dirname "$0")/.."
exported=$(nm -D --defined-only "$library" | awk '{ print $NF }' | LC_ALL=C sort)
declared=$(cat include/fanal/*.h | tr '\n' ' ' | grep -oE 'FNL_API [^;{]*' | grep -oE 'fnl_[a-z0-9_]+ ?\(' | tr -d ' (' | LC_ALL=C sort)
case $1 in
update) echo "$exported" >docs/api.txt ;;
check)
    status=0
    diff --label declared --label exported -U0 <(echo "$declared") <(echo "$exported") || status=1
    diff --label docs/api.txt --label exported -U0 docs/api.txt <(echo "$exported") || status=1
    [ $status -eq 0 ] || echo "If the interface is meant to change: tools/api.sh update $2" >&2
    exit $status
    ;;
*) exit 2 ;;
esac
