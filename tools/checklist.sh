#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Says of each checklist line whether tests show it:
#   shown     a test's function or given name holds its id (ES_43, ES-43), and tests/checklist.txt says nothing against it
#   partial   some of it is shown, or the code is tested but not used in a frame; tests/checklist.txt says what is missing and why
#   open      not shown; tests/checklist.txt may say why
# The lines themselves are those of the digests: the table in README.md of $FANAL_SPEC (default ../shared/spec) has a row for each family,
# | prefix | file | number of lines | about |. `--check` prints only faults: ids that no digest has, notes without a reason, notes that tests
# contradict. Exits with 1 if there are any.
set -euo pipefail
cd "$(dirname "$0")/.."

spec=${FANAL_SPEC:-../shared/spec}
notes=tests/checklist.txt
if [ ! -r "$spec/README.md" ]; then
    echo "checklist: skipped: the digests are not in '$spec' (set FANAL_SPEC)"
    exit 0
fi

# "ES-43<TAB>name of the test"
shown() {
    find src tests cli -name '*.c' -print0 | sort -z |
        xargs -0 grep -ohE '\btest_[A-Za-z0-9_]*[A-Z]{2}_[0-9]+[A-Za-z0-9_]*|"[^"]*\b[A-Z]{2}-[0-9]+[^"]*"' |
        awk -v families="$1" '
            {
                name = $0; gsub(/^"|"$/, "", name); rest = name
                while (match(rest, "(" families ")[-_][0-9]+")) {
                    line = substr(rest, RSTART, RLENGTH); rest = substr(rest, RSTART + RLENGTH)
                    sub("_", "-", line)
                    if (!seen[line, name]++) print line "\t" name
                }
            }'
    find tests cli -name '*.sh' -print0 | xargs -0 grep -ohE "^# shows ($1)-[0-9]+: .*" | sed -E 's/^# shows ([A-Z]+-[0-9]+): (.*)/\1\t\2/' || true
}

rows=$(awk -F '|' '$2 ~ /^ *[A-Z][A-Z] *$/ && $4 + 0 > 0 { gsub(/ /, "", $2); gsub(/ /, "", $3); print $2, $4 + 0, $3 }' "$spec/README.md")
[ -n "$rows" ] || { echo "checklist: $spec/README.md has no table of families" >&2; exit 1; }
families=$(awk '{ printf "%s%s", sep, $1; sep = "|" }' <<<"$rows")

awk -F '\t' -v mode="${1:-}" -v notes="$notes" '
    FILENAME == "-" { # tests
        names[$1] = names[$1] (names[$1] ? "; " : "") $2
        next
    }
    FILENAME == notes {
        if ($0 ~ /^#/ || $0 ~ /^ *$/) next
        if (!match($0, /^[A-Z][A-Z]-[0-9]+ (partial|open): ./)) { fault(notes ":" FNR ": not \"LINE partial|open: reason\": " $0); next }
        split($0, words, " ")
        if (words[1] in state) fault(notes ":" FNR ": " words[1] " has two notes")
        state[words[1]] = words[2] == "partial:" ? "partial" : "open"
        reason[words[1]] = substr($0, length(words[1]) + length(words[2]) + 3)
        next
    }
    { # families
        split($0, f, " "); order[++family_count] = f[1]; count[f[1]] = f[2]
    }
    function fault(text) { print "checklist: " text; faults++ }
    function known(line, parts) { split(line, parts, "-"); return parts[2] >= 1 && parts[2] <= count[parts[1]] }
    END {
        for (line in names) if (!known(line)) fault("no digest has line " line ", which a test names: " names[line])
        for (line in state) {
            if (!known(line)) fault("no digest has line " line " of " notes)
            if (state[line] == "open" && line in names) fault(line " is noted as open, but a test names it: " names[line])
            if (state[line] == "partial" && !(line in names)) fault(line " is noted as partial, but no test names it")
        }
        if (mode == "--check") exit (faults > 0)
        for (i = 1; i <= family_count; i++) {
            p = order[i]; s = partial = 0; missing = ""
            for (n = 1; n <= count[p]; n++) {
                line = p "-" n
                if (state[line] == "partial") { partial++; printf "%-7s partial  %s\n        tests    %s\n", line, reason[line], names[line] }
                else if (line in names) { s++; printf "%-7s shown    %s\n", line, names[line] }
                else if (state[line] == "open") printf "%-7s open     %s\n", line, reason[line]
                else missing = missing " " line
            }
            if (missing && s + partial) print "        open    " missing
            sum[p] = sprintf("%-4s %3d of %3d shown, %d partial", p, s, count[p], partial)
            total += count[p]; all_shown += s; all_partial += partial
        }
        print ""
        for (i = 1; i <= family_count; i++) print sum[order[i]]
        printf "all  %3d of %3d shown, %d partial\n", all_shown, total, all_partial
        exit (faults > 0)
    }' <(echo "$rows") "$notes" - < <(shown "$families")
