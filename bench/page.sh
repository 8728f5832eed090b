#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# docs/performance.md is made from bench/results/*/*.csv and bench/experiments.txt. Usage: page.sh update|check
set -eu
cd "$(dirname "$0")/.."

# One table for each scene, size and number of samples: a row for each candidate, a column for each number of lights.
tables() {
    awk '
    function split_csv(line, into,    count, quoted, i, c) { # fields may be quoted
        for (i in into) delete into[i]
        count = 1; quoted = 0; into[1] = ""
        for (i = 1; i <= length(line); i++) {
            c = substr(line, i, 1)
            if (c == "\"") quoted = !quoted
            else if (c == "," && !quoted) into[++count] = ""
            else into[count] = into[count] c
        }
        return count
    }
    function shown(ms) { return ms < 10 ? sprintf("%.2f", ms) : ms < 100 ? sprintf("%.1f", ms) : sprintf("%.0f", ms) }
    FNR == 1 { pass++; seen_head = 0 }
    /^#/ { next }
    !seen_head { seen_head = 1; columns = split_csv($0, head); for (i = 1; i <= columns; i++) at[head[i]] = i; next }
    pass == 1 { # which columns differ from line to line
        split_csv($0, f)
        for (i = 1; i <= columns; i++) { if (i in one && one[i] != f[i]) differs[i] = 1; one[i] = f[i] }
        next
    }
    {
        split_csv($0, f)
        title = f[at["scene"]] " at " f[at["width"]] "x" f[at["height"]] (f[at["msaa"]] > 1 ? ", " f[at["msaa"]] " samples per pixel" : "")
        if (!(title in cases)) { cases[title] = ++case_count; titles[case_count] = title }
        k = cases[title]
        lists = f[at["lists"]]
        # What is set stands in one column (older files), or in those between lists and lights, of which those that differ tell rows apart.
        options = "options" in at ? f[at["options"]] : ""
        if (!("options" in at))
            for (i = at["lists"] + 1; i < at["lights"]; i++)
                if (differs[i]) options = options (options == "" ? "" : ",") head[i] "=" f[i]
        if (lists == "brute-force") lists = "brute force"
        name = "`" f[at["shading"]] "` | " (lists == "brute force" ? lists : "`" lists "`") (options == "" ? "" : ", " options)
        if (!((k, name) in rows)) { rows[k, name] = ++row_count[k]; names[k, row_count[k]] = name }
        lights = f[at["lights"]]
        if (!((k, lights) in seen)) { seen[k, lights] = ++light_count[k]; lights_of[k, light_count[k]] = lights }
        r = rows[k, name]; ms = f[at["frame_ms_median"]] + 0
        time[k, r, lights] = ms; spread[k, r, lights] = f[at["frame_ms_mad"]] + 0; equal[k, r, lights] = f[at["equal"]] != "false"
        if (!((k, lights) in best) || ms < best[k, lights]) best[k, lights] = ms
        ideal = "ideal_ms" in at ? f[at["ideal_ms"]] + 0 : 0
        if (ideal > 0 && (!((k, lights) in ideals) || ideal < ideals[k, lights])) { ideals[k, lights] = ideal; has_ideal[k] = 1 }
    }
    END {
        for (k = 1; k <= case_count; k++) {
            printf "%s, ms per frame:\n\n| path | lists |", titles[k]
            for (l = 1; l <= light_count[k]; l++) printf " %d lights |", lights_of[k, l]
            printf "\n|---|---|"
            for (l = 1; l <= light_count[k]; l++) printf "---|"
            printf "\n"
            last = lights_of[k, light_count[k]]
            for (i = 1; i <= row_count[k]; i++) order[i] = i
            for (i = 2; i <= row_count[k]; i++) # the fastest with most lights first
                for (j = i; j > 1 && key(k, order[j], last) < key(k, order[j - 1], last); j--) { t = order[j]; order[j] = order[j - 1]; order[j - 1] = t }
            for (i = 1; i <= row_count[k]; i++) {
                r = order[i]
                printf "| %s |", names[k, r]
                for (l = 1; l <= light_count[k]; l++) {
                    lights = lights_of[k, l]
                    if (!((k, r, lights) in time)) { printf " |"; continue }
                    ms = time[k, r, lights]; ratio = ms / best[k, lights]
                    printf " %s", (ratio == 1 ? "**" shown(ms) "**" : sprintf("%s (%.2fx)", shown(ms), ratio))
                    if (spread[k, r, lights] > ms / 10) printf " ±%s", shown(spread[k, r, lights])
                    if (!equal[k, r, lights]) printf ", WRONG PICTURE"
                    printf " |"
                }
                printf "\n"
            }
            if (has_ideal[k]) {
                printf "| *ideal* | |"
                for (l = 1; l <= light_count[k]; l++)
                    if ((k, lights_of[k, l]) in ideals) printf " *%s* (%.2fx) |", shown(ideals[k, lights_of[k, l]]), ideals[k, lights_of[k, l]] / best[k, lights_of[k, l]]
                    else printf " |"
                printf "\n"
            }
            printf "\n"
        }
    }
    function key(k, r, lights) { return (k, r, lights) in time ? time[k, r, lights] : 1e30 }' "$1" "$1"
}

# Of other renderers, measured by hand: a row for each of them, a column for each number of lights, and over the fastest of ours with the same filter.
peers() {
    cat <<'END'

### How do other renderers compare?

The same hall, written as glTF and loaded by each, without shadows, on the same driver ([how to repeat it](../bench/peers/README.md)). The others filter textures without anisotropy unless told
otherwise, while Fanal's default is 8, so Fanal was measured with both. Limits on the lights in a cell were raised to what the scene needs: with the defaults of the others lights are missing,
and their frames are faster.

END
    awk '
    /^#/ { next }
    !seen_head { seen_head = 1; next }
    {
        line = $0; n = 0
        while (match(line, /^("[^"]*"|[^,]*),?/)) { t = substr(line, 1, RLENGTH); line = substr(line, RLENGTH + 1); sub(/,$/, "", t); gsub(/"/, "", t); f[++n] = t; if (line == "") break }
        row = f[1] " | " f[2] " | " f[3]
        if (!(row in rows)) { rows[row] = ++row_count; names[row_count] = row }
        if (!(f[4] in columns)) { columns[f[4]] = ++column_count; lights[column_count] = f[4] }
        time[rows[row], columns[f[4]]] = f[5]
        if (f[1] !~ /^Fanal/ && (!(f[4] in best) || f[5] + 0 < best[f[4]])) best[f[4]] = f[5] + 0
    }
    END {
        printf "| ms per frame, 1280x720 | settings | anisotropy |"
        for (c = 1; c <= column_count; c++) printf " %d lights |", lights[c]
        printf "\n|---|---|---|"
        for (c = 1; c <= column_count; c++) printf "---|"
        printf "\n"
        for (r = 1; r <= row_count; r++) {
            printf "| %s |", names[r]
            for (c = 1; c <= column_count; c++) printf (names[r] ~ /^Fanal/ ? " %d (%.1fx) |" : " %d |"), time[r, c], best[lights[c]] / time[r, c]
            printf "\n"
        }
    }' "$1"
    printf '\nIn brackets: how many times as fast as the fastest of the others. Measured at commit %s, one run on a quiet machine.\n' "$(sed -n 's/^# commit //p' "$1")"
}

page() {
    cat <<'END'
<!-- SPDX-License-Identifier: MIT -->
<!-- Made by bench/page.sh from bench/results; do not edit. -->
# Performance

Recorded measurements. `./build.sh bench --record` runs these experiments on your machine, keeps the numbers under `bench/results/`, in a folder named
after the device, and writes this page again, so you can check a claim about speed by comparing two commits.

A time is the median over the frames of one candidate; the candidates of a table took turns frame by frame. In brackets: the ratio to the fastest of the
column, which is bold. ± is the median absolute deviation, shown where it exceeds a tenth of the time. On a CPU driver trust the ratios, not the
milliseconds. *ideal* is the fastest of these frames with perfect lists that cost nothing. [bench.md](bench.md) says how `fanal bench` measures; every picture was compared with brute force.
END
    local folder file name title text arguments compiled=''
    for folder in bench/results/*/; do
        file=$(printf '%s\n' "$folder"*.csv | head -n 1)
        [ -e "$file" ] && [[ $folder != */radv-* ]] || continue
        printf '\n## %s\n\nDriver: %s.\n' "$(sed -n 's/^# device //p' "$file")" "$(sed -n 's/^# driver //p' "$file")"
        while IFS='|' read -r name title text arguments; do
            name=${name// /}
            case $name in '' | '#'*) continue ;; esac
            file=$folder$name.csv
            [ -e "$file" ] || continue
            printf '\n###%s\n\n%s\n\n' "${title% }" "$(sed -E 's/^ +| +$//g' <<<"$text")"
            printf '    %s\n\n' "$(sed -n 's/^# command //p' "$file")"
            tables "$file"
            printf 'Measured at commit %s.\n' "$(sed -n 's/^# commit //p' "$file")"
        done <bench/experiments.txt
        [ ! -e "${folder}peers.csv" ] || peers "${folder}peers.csv"
    done
    for file in bench/results/radv-*/pipelines.csv; do
        [ -e "$file" ] || continue
        if [ -z "$compiled" ]; then
            compiled=yes
            cat <<'END'

## What a GPU's compiler says

Mesa's radv can compile for GPUs that are not in the machine. `./build.sh shaders` makes it compile every pipeline and shows the result; a test fails if a shader has
fewer waves, more spilled registers or more scratch memory than in `bench/results/radv-*/pipelines.csv`. The tables show the shaders with the fewest waves. A row has the
worst value of each number over all *programs* that one shader was specialised to: *waves* that fit on a SIMD at once (16 or 32 with few enough registers; more of them hide more latency), vector
*registers*, *scratch* and *shared* memory in bytes, *instructions*, and *latency*, an estimate of cycles in which each loop runs a fixed number of times.

The 19 456 bytes of scratch memory are no array of ours: fragment shaders that trace rays by ray queries have them, and it is what radv's traversal keeps, 76 words for
each of 64 threads. In compute shaders it uses 4096 bytes of shared memory instead.

No result depends on the size of subgroups. The only subgroup operations are those of `dais` on quads, which are four pixels on every device; and bounds of tiles take as
many rows of threads as a subgroup has, with the same lists (a test builds them for subgroups of 4 to 128). There are no rows for sizes: radv lets programs ask for one
in compute and mesh shaders, and `dais` uses quads in fragment shaders.

Shaders that build lists are to have 24 of 32 waves (navi31), which is 60 registers and 2048 bytes of shared memory for 64 threads. The compiler takes as many registers as the waves that
shared memory allows: `backface_cull` went from 108 to 48 when it took 2 KB instead of 4.5. These have fewer waves, without tracing rays or shading:

| shader | waves | why |
|---|---|---|
| `fine_bounds` | 16 | A thread clips the six sides of a light's solid against the view: eight corners and a polygon of nine points are 51 registers. One thread a light: 65 536 lights are 1024 waves, five for each SIMD of navi31. |
| `raster_shell` | 16 | Triangles cut by the near plane ([raster](techniques/raster.md)) |
| `fill_count`, `fill_list`, `fill_mark` | 12 to 16 | A page's volume, its six planes and eight corners, is 52 registers; the first two look at clusters too. Computed from half as many numbers they get 18 to 20 waves and 4 % more instructions. Not done: one thread a page, and a few thousand pages are less than a wave for each SIMD. |
| `bvh_sort` | 22 | It needs 2112 bytes of shared memory, and gets 3072: 64 bytes too many, which hold where each digit begins |
| `requests` | 22 | With one sample; with several 32. It keeps the pixels' positions beside the pairs that it found. With 12 instead of 16 bytes a position and pairs of one byte instead of four it gets 32 waves, but takes 1.3 to 1.4 times as long on the CPU driver (hall, 400 lights, 320x180). |
| `dais_derive` | 18 | 9 registers for a triangle's weights, 8 for their derivatives, 12 for three tangents, 9 to turn them; 16 of 16 waves on navi21 |
| `edges_find` | 18 | Where materials have layers: it compares two whole surfaces; 24 without layers |
| `bc6h_quality` | 6 | 16 texels of three numbers are in registers throughout, beside the best block and the one that is tried. It runs once for an environment. |
| `bc6h`, `cubemap_bake` | 20, 18 | They run once for an environment or a probe. |
| `clusters_slots`, `dais_arguments`, `exposure`, `pages_fit`, `split_drawn`, `visible_ranges` | 16 | Groups of 32 threads or fewer: a wave of 32 is half of one of 64, and 16 of those are all that fit |

The estimated latency of `bvh_query` (65 000) is three loops in one another, over words of leaves, leaves and their lights, each counted with the same number of turns; it has 24 waves.
END
        fi
        printf '\n### %s\n\n| shader | programs | waves | registers | scratch | shared | instructions | latency |\n|---|---|---|---|---|---|---|---|\n' "$(sed -n 's/^# \([^;]*\);.*/\1/p' "$file")"
        sed 1,2d "$file" | sort -t, -k3,3n -k4,4nr -k1,1 | head -n 16 | awk -F, '{ print "| `" $1 "` | " $2 " | " $3 " | " $4 " | " $7 " | " $8 " | " $9 " | " $10 " |" }'
    done
}

case ${1:-} in
update) page >docs/performance.md.new; mv docs/performance.md.new docs/performance.md ;;
check)
    page | diff docs/performance.md - && exit
    echo 'docs/performance.md does not match bench/results: run bench/page.sh update' >&2
    exit 1
    ;;
*) echo 'usage: bench/page.sh update|check' >&2; exit 2 ;;
esac
