#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# tools/slow.sh writes tests/slow.txt anew from what CTest printed.
set -eu
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cat >"$work/slow.txt" <<'END'
# A comment,
# of two lines.
became_fast 20
failed_part 30 all
failed_test 12
marked 50 all
not_run 11 all
quick_part 9
slow_part 10
END
test() { # NAME OUTPUT SECONDS RESULT: as CTest's log has it
    printf '1/9 Testing: %s\n1/9 Test: %s\nCommand: "/x/%s"\n"%s" start time: now\nOutput:\n---\n%b\n<end of output>\nTest time = %7s sec\n---\nTest %s.\n"%s" end time: now\n\n' \
        "$1" "$1" "$1" "$1" "$2" "$3" "$4" "$1"
}
{
    test became_fast 'all is well' 7.99 Passed
    test failed_test 'no' 0.10 Failed
    test marked 'fine' 61.70 Passed
    test render_some '== slow_part: 0 failed, 90.0 s (44.4 s of processors)\n== quick_part: 0 failed, 12.0 s (3.0 s of processors)\n== new_part: 0 failed, 9.0 s (9.5 s of processors)\n== failed_part: 1 failed, 1.0 s (1.0 s of processors)' 200.00 Failed
    test slow_new '' 8.60 Passed
    test quick_new '' 0.01 Passed
} >"$work/log"
cat >"$work/expected" <<'END'
# A comment,
# of two lines.
failed_part 30 all
failed_test 12
marked 62 all
new_part 10
not_run 11 all
slow_new 9
slow_part 44
END
"$(dirname "$0")/../tools/slow.sh" "$work/log" "$work/slow.txt"
diff "$work/expected" "$work/slow.txt"
"$(dirname "$0")/../tools/slow.sh" "$work/log" "$work/slow.txt" # a second time it changes nothing
diff "$work/expected" "$work/slow.txt"
