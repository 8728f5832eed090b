# SPDX-License-Identifier: MIT
# Checks what the page found when it looked at itself against $results[0], in a window $WIDTH pixels wide; at least $PLOTS plots (none: 0), and $ZEROS
# axes with a 0. Prints what is wrong; nothing if all is right.
def empty_list($key; $why): select(getpath([$key]) != []) | "\($why): \(getpath([$key]))";
def rows($name): .tables[$name].rows;

$results[0] as $files | ([$files.results[].lists] | length) as $count |
empty_list("errors"; "errors of the script"),
empty_list("requests"; "requests to somewhere"),
empty_list("wide"; "elements that reach beyond the right edge"),
(select(.width != $WIDTH or .scroll > .width) | "the page is \(.scroll) pixels wide in a window of \(.width), not \($WIDTH)"),
(.canvases | select(length < $PLOTS or ($PLOTS == 0 and length > 0)) | "\(length) plots, not \($PLOTS)"),
(.canvases[] | select((.pixels >= 1000 and .colors >= 10 and .width >= 200) | not) |
    "'\(.label)' is as good as empty: \(.pixels) pixels in \(.colors) colours, \(.width) wide"),
(.images | select(length < 2) | "only \(length) pictures"),
(.images | to_entries[] | select(.value | not) | "picture \(.key) does not show"),
# The answer comes first: in words, or how many ratios of a suite were reached.
(.lead | select(test("was fastest: [0-9.]+ ms|alone was measured|[0-9]+ of [0-9]+ ratios? reached|WRONG PICTURE") | not) |
    "the page does not begin with an answer: \(.)"),
(select(.text | test("all lists")) | "brute force is called 'all lists'"),
# Tables that do not fit say that they scroll, those that fit do not.
(select(.mute != 0 or ($WIDTH < 400 and .scrolled < 3)) | "\(.mute) tables do not say what they do, \(.scrolled) scroll in \($WIDTH) pixels"),
(select(.bare != 0) | "\(.bare) logarithmic axes have less than two numbers"),
(select(.ranges != 0) | "\(.ranges) of 4000 ranges would leave a logarithmic axis with less than two numbers"),
# 0 has a place of its own on logarithmic axes, with a name, apart from the least value.
(.zeros | select(length < $ZEROS) | "\(length) axes show a 0, not \($ZEROS)"),
(.zeros[] | select((.apart >= 15 and .labelled and .points >= 1) | not) |
    "'\(.name)': 0 is \(.apart) pixels from the least value, labelled \(.labelled), with \(.points) points"),
# A name in the legend hides its scheme.
(select($PLOTS > 0) | .legend | select((.[1] < .[0]) | not) | "the legend hides nothing: \(.)"),
(select(rows("numbers") != $count) | "the table of all numbers has \(rows("numbers")) rows, there are \($count) results"),
(select(($files.skipped | length) > 0 and rows("skipped") != ($files.skipped | length)) |
    "the table of what was left out has \(rows("skipped")) rows, not \($files.skipped | length)"),
# A row for each case, one for each order of the case at hand.
(([$files.results[] | [.scene, .width, .msaa, .lights, .settings.shadows]] | unique | length) as $wanted | select(rows("cases") != $wanted) |
    "the table of cases has \(rows("cases")) rows, not \($wanted)"),
(([$files.results[].shading] | unique | length) as $wanted | select((rows("orders-fastest") | . >= 1 and . <= $wanted) | not) |
    "the table of orders has \(rows("orders-fastest")) rows for \($wanted) orders"),
# Under each plot as many rows as there are schemes.
(rows("time") as $schemes | ("passes", "balance", "memory", "evaluations") as $name | select(rows($name) != $schemes or $schemes < 1) |
    "the table '\($name)' has \(rows($name)) rows for \($schemes) schemes")
