#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Links and pictures of the pages exist, headings too; the indexes leave no page out; pictures are used; README names every family of techniques.
# Usage: docs_test.sh
set -u
cd "$(dirname "$0")/.." || exit 2
failures=0
fail() { echo "FAILED: $*" >&2; failures=$((failures + 1)); }

# The anchors of a page's headings: small letters, digits, -, _; blanks become -.
anchors() { sed -n -E '/^```/,/^```/d; s/^#+ +//p' "$1" | sed -E 's/\[([^]]*)\]\([^)]*\)/\1/g' | tr 'A-Z' 'a-z' | sed -E 's/[^a-z0-9 _-]//g; s/ /-/g'; }

for page in README.md CONTRIBUTING.md docs/*.md docs/techniques/*.md; do
    folder=$(dirname "$page")
    while IFS= read -r link; do
        case $link in http*|mailto:*) continue ;; esac
        file=${link%%#*} anchor=''
        [[ $link != *'#'* ]] || anchor=${link#*#}
        target=$folder/$file
        [ -n "$file" ] || target=$page
        if [ ! -e "$target" ]; then
            fail "$page: there is no $link"
        elif [ -n "$anchor" ] && ! anchors "$target" | grep -qxF -- "$anchor"; then
            fail "$page: $link has no such heading"
        fi
    done < <(grep -oE '\]\([^) ]+\)' "$page" | sed -E 's/^\]\((.*)\)$/\1/')
done
for page in docs/techniques/*.md; do
    name=$(basename "$page")
    [ "$name" = README.md ] || grep -qE "\]\($name[)#]" docs/techniques/README.md || fail "docs/techniques/README.md leaves out $name"
done
for page in docs/*.md; do
    grep -qF "]($page" README.md || grep -qF "](../$(basename "$page")" docs/techniques/README.md || fail "neither README.md nor the index of techniques links $page"
done
for picture in docs/images/*; do
    grep -qF "images/$(basename "$picture"))" README.md docs/*.md docs/techniques/*.md || fail "no page shows $picture"
done
families=$(cd src/passes && printf '%s\n' */ | tr -d /)
named=$(sed -n 's/^| `src\/passes\/` |//p' README.md | grep -oE '`[a-z]+`' | tr -d '`')
[ "$families" = "$named" ] || fail "README.md names the families" $named "and src/passes has" $families
[ $failures = 0 ] && echo 'all links lead somewhere'
exit $((failures > 0))
