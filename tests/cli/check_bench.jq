# SPDX-License-Identifier: MIT
# Checks the files of `fanal bench` against one another: results.json, and results.csv, which is $csv. There are $RESULTS results, $SKIPPED pairs
# left out, $EQUAL pictures, and $FRAMES frames of each (not given: at least one). Prints what is wrong; nothing if all is right.
def keys: ["scene", "width", "height", "msaa", "shading", "lists", "lights", "frames", "lists_ms.median", "frame_ms.median",
    "evaluations", "equal"];
def fields: gsub("\"[^\"]*\""; "quoted") | split(","); # no key above has a quoted name
# As the CSV spells a value.
def spelt($key): if . == null then "" else tostring end;
# What the numbers of a result must keep, whatever they are.
def numbers($index): "result \($index): " + (
    (select(.lists == "brute-force" and .lists_ms.median != 0) | "brute force spent \(.lists_ms.median) ms on lists: a pass is taken for one that builds lists"),
    (.frame_ms | select((.median > 0 and .min <= .median and .p95 >= .median) | not) | "the median \(.median) ms is not between \(.min) and \(.p95)"),
    (select(.evaluations_useful > .evaluations or .lights == 0 and .evaluations != 0 or .dropped != 0) |
        "\(.lights) lights, \(.evaluations) evaluations, \(.evaluations_useful) of them useful, \(.dropped) dropped"),
    (select($ARGS.named.FRAMES as $frames | $frames != null and .frames != $frames or .frames < 1) | "\(.frames) frames were timed"));

.results as $results | ($csv | split("\r\n")) as $lines | ($lines[0] | fields) as $header |
if ($results | length) != $RESULTS or (.skipped | length) != $SKIPPED then
    "\($results | length) results, \(.skipped | length) left out; \($RESULTS) and \($SKIPPED) were expected"
elif ($lines | length) != $RESULTS + 2 or $lines[-1] != "" or ($csv | gsub("\r\n"; "") | test("[\r\n]")) then
    "results.csv has not \($RESULTS + 1) lines that end in CR LF"
else
    range($RESULTS) as $index | $results[$index] |
    ($lines[$index + 1] | fields) as $row |
    if ($row | length) != ($header | length) then "line \($index) of results.csv has \($row | length) fields, not \($header | length)"
    else
        (keys[] as $key | getpath($key | split(".")) as $value |
            ($key | gsub("[.]"; "_")) as $column | ($header | index($column)) as $place |
            if $place == null then "results.csv has no column \($column)"
            else $row[$place] as $got |
                # numbers of times may be spelt differently
                select($got != "quoted" and ($got == "" or ($key | test("ms") | not)) and $got != ($value | spelt($key))) |
                "line \($index) of results.csv: \($column) is '\($got)', in results.json '\($value)'"
            end),
        numbers($index)
    end
end,
(.results | map(select(.equal == true)) | length | select(. != $EQUAL) | "\(.) pictures are equal, not \($EQUAL)")
