#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# text_test.sh FANAL: text of files and arguments reaches neither a terminal's control functions nor a shell: names, URIs, keys, arguments, lines of a
# replay, and the command that the window copies.
set -u
fanal=$(cd "$(dirname "$1")" && pwd)/$(basename "$1")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 2
export XDG_CACHE_HOME=$work/cache
failures=0
fail() { echo "FAILED: $*" >&2; failures=$((failures + 1)); }
# What was printed, with all but blanks to letters as escapes.
shown() { head -c 600 "$1" | od -An -c | head -n 20; }
# clean NAME FILE: lines of UTF-8 without a control character; none begins as a name from a file wants it to.
clean() {
    iconv -f UTF-8 -t UTF-8 "$2" >/dev/null 2>&1 || fail "$1: prints what is not UTF-8: $(shown "$2")"
    LC_ALL=C grep -qP '[\x00-\x08\x0b-\x1f\x7f]|\xc2[\x80-\x9f]|\xd8\x9c|\xe2\x80[\x8e\x8f\xa8-\xae]|\xe2\x81[\xa6-\xa9]' "$2" && fail "$1: prints control characters: $(shown "$2")"
    grep -q '^forged' "$2" && fail "$1: a name makes a line of its own: $(shown "$2")"
}
# says STATUS WORDS ARGUMENTS…: the status, words in what is printed, and that it is clean.
says() {
    local status=$1 words=$2 got
    shift 2
    timeout 600 "$fanal" "$@" >out 2>&1
    got=$?
    [ $got = "$status" ] || fail "fanal ${*@Q}: exit $got, not $status: $(shown out)"
    [ -z "$words" ] || grep -qF -- "$words" out || fail "fanal ${*@Q}: does not say '$words': $(shown out)"
    clean "fanal ${*@Q}" out
}
# As bash and JSON write it: ESC, OSC 52, CR, a line break, DEL, C1, and a change of direction.
evil=$'a\e[31m\e]52;c;Zm9yZ2Vk\a\rb\nforged\x7f\u009b1m\u202ec'
evil_json='a\u001b[31m\u001b]52;c;Zm9yZ2Vk\u0007\rb\nforged\u007f\u009b1m\u202ec'
seen='a?[31m?]52;c;Zm9yZ2Vk??b?forged??1m?c' # of it
broken=$'\xff\xc3(' # not UTF-8

cat >evil.gltf <<END
{"asset": {"version": "2.0", "generator": "$evil_json"}, "scene": 0, "scenes": [{"nodes": [0, 1, 2], "name": "$evil_json"}],
 "nodes": [{"mesh": 0, "name": "$evil_json"}, {"camera": 0, "name": "$evil_json"}, {"name": "$evil_json", "extensions": {"KHR_lights_punctual": {"light": 0}}}],
 "cameras": [{"name": "$evil_json", "type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}],
 "materials": [{"name": "$evil_json", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}], "textures": [{"source": 0}],
 "images": [{"name": "$evil_json", "uri": "$evil_json.png"}], "extensionsUsed": ["KHR_lights_punctual", "KHR_materials_variants", "$evil_json"],
 "extensions": {"KHR_lights_punctual": {"lights": [{"name": "$evil_json", "type": "directional"}]}, "KHR_materials_variants": {"variants": [{"name": "$evil_json"}]}},
 "animations": [{"name": "$evil_json", "samplers": [{"input": 1, "output": 2}], "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}]}],
 "meshes": [{"name": "$evil_json", "primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
 "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [-1, -1, 0], "max": [1, 1, 0]},
  {"bufferView": 1, "componentType": 5126, "count": 1, "type": "SCALAR", "min": [0], "max": [0]}, {"bufferView": 2, "componentType": 5126, "count": 1, "type": "VEC3"}],
 "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 8, "byteLength": 4}, {"buffer": 0, "byteLength": 12}],
 "buffers": [{"byteLength": 36, "uri": "data:application/octet-stream;base64,AACAvwAAgL8AAAAAAACAPwAAgL8AAAAAAAAAAAAAgD8AAAAA"}]}
END
cp evil.gltf "$evil.gltf"
cp evil.gltf "$broken.gltf"

# ---- names in a scene ----

says 0 "$seen" info evil.gltf
says 0 "$seen" info "$evil.gltf"
says 0 '??(.gltf' info "$broken.gltf"
says 0 '\u202Ec' info --json "$evil.gltf"
says 0 '"source": "??(.gltf"' info --json "$broken.gltf"
small=(--size 16x9 --shading forward --lists brute-force --shadows off --no-cache --device 0)
says 2 "$seen" render evil.gltf --camera x "${small[@]}" -o a.png
says 2 "$seen" render evil.gltf --camera "$evil" --variant "$evil$evil" "${small[@]}" -o a.png
says 2 "$seen" render evil.gltf --animation "$evil$evil" "${small[@]}" -o a.png
says 0 "$seen" render evil.gltf --pixel 8,4 "${small[@]}"
says 0 '??(.gltf' render "$broken.gltf" --pixel 8,4 "${small[@]}" --stats -
says 0 '' render "$broken.gltf" --frames 1 -q "${small[@]}" --stats stats.json -o "$broken.png"
grep -qF '??(.gltf' stats.json || fail "--stats leaves the file out: $(shown stats.json)"
[ -s "$broken.png" ] || fail 'no picture was written under a name that is not UTF-8'
says 0 '"??(.png"' compare "$broken.png" "$broken.png" --json

if ! timeout 900 "$fanal" bench "$broken.gltf" --sizes 16x9 --frames 2 --warm-up 0 --shading forward --lists brute-force --shadows off --msaa 1 --device 0 --no-cache -o bench >out 2>&1; then
    fail "bench of a name that is not UTF-8: $(shown out)"
fi
clean bench out
for file in results.json results.csv report.html; do grep -qF '??(.gltf' bench/$file || fail "$file leaves the name out"; done

# ---- arguments ----

says 2 "there is no command '$seen'" "$evil"
says 2 "there is no option '--$seen'" render evil.gltf "--$evil" -o a.png
says 2 "there is no option '-?'" info $'-\e' evil.gltf
says 2 'needs a value' render evil.gltf -o
says 2 "--quiet takes no value" render evil.gltf "--quiet=$evil" -o a.png
says 2 "'--light-s' could be --light-s" render evil.gltf --light-s 1 -o a.png
for option in size exposure eye light-shapes aov tonemap shading lists set pixel msaa format; do says 2 "$seen" render evil.gltf "--$option" "$evil" -o a.png; done
says 2 "$seen" trace evil.gltf --samples "$evil" -o a.png
says 2 "$seen" bench evil.gltf --sizes "$evil" -o bench
says 2 "$seen" compare "$evil.png" none.png
says 2 "$seen" compress "$evil.png" -o a.dds
says 2 "$seen" devices "$evil"
says 2 "$seen" render evil.gltf "${small[@]}" -o "$evil/a.png"

# ---- displays and headsets ----

echo "{\"$evil_json\": 1}" >keys.json
says 2 "$seen" cave builtin:onetile --displays keys.json -o a.png
says 2 "${seen%Zm9*}" render builtin:onetile --hmd keys.json --stereo left -o a.png
echo "{\"name\": \"$evil_json\", \"walls\": \"$evil_json" >cut.json
says 2 'cut.json' cave builtin:onetile --displays cut.json -o a.png
says 2 'cut.json' render builtin:onetile --hmd cut.json --stereo left -o a.png

# ---- the window: replays, and the command that it copies ----

if "$fanal" view --help >/dev/null 2>&1; then
    printf '%s\n' "$evil" | tr -d '\n' >bad.txt
    says 2 'bad.txt:1: not an event: ' view builtin:onetile --headless --replay bad.txt "${small[@]}"
    # Each error begins as the errors of other commands do, and says what is wrong.
    view=(view builtin:onetile --headless --size 32x18 --shading forward --lists brute-force --shadows off --no-cache --device 0)
    printf 'drop missing.gltf\nsettle\n' >drop.txt
    says 0 'fanal: error: missing.gltf: ' "${view[@]}" --replay drop.txt
    grep -v '^fanal: error: \|^fanal: warning: \|frames of the scene in' out | grep '^fanal: ' && fail "an error without a prefix: $(shown out)"
    printf 'size 0 0\nsave none.png\n' >none.txt
    says 2 'fanal: error: none.png: not written: the picture has 0 x 0 pixels' "${view[@]}" --replay none.txt
    for number in nan inf -inf; do
        printf 'wheel 0 %s\n' $number >wheel.txt
        says 2 "wheel.txt:1: not an event: wheel 0 $number" "${view[@]}" --replay wheel.txt
    done
    # A line that does not fit is not taken for a shorter one and another behind it.
    printf 'drop %01100d\n' 0 >long.txt
    says 2 'long.txt:1: not an event: drop 0' "${view[@]}" --replay long.txt
    printf '#%01300d\nsettle\n' 0 >long.txt
    says 2 'long.txt:1: the line has more than' "${view[@]}" --replay long.txt
    # However far the wheel turns, there is a picture.
    printf 'wheel 0 1e9\nframes 2\nwheel 0 -1e9\nframes 2\nwheel 0 -1e30\nwheel 0 -1e9\nframes 2\nsave far.png\nreport far.tsv\n' >wheel.txt
    says 0 '' "${view[@]}" --replay wheel.txt
    grep -q '^camera' far.tsv && ! grep -qE '^camera.*(nan|inf)' far.tsv || fail "the wheel lost the camera: $(grep ^camera far.tsv)"
    [ -s far.png ] || fail 'nothing is seen from where the wheel leads'

    # The name of the scene and of the variant shown: a shell must find them again, and run nothing.
    hostile="v'\$(touch x)'\`touch x\`;touch x #\"\\"
    name=${hostile//\\/\\\\} name=${name//\"/\\\"}
    scene=$hostile$evil.gltf
    while IFS= read -r line; do printf '%s\n' "${line//"\"variants\": [{\"name\": \"$evil_json\"}]"/"\"variants\": [{\"name\": \"$name\"}, {\"name\": \"$evil_json\"}]"}"; done <evil.gltf >"$scene"
    printf 'command copied.sh\n' >copy.txt
    for variant in "$hostile" "$evil"; do
        rm -f x copied.sh
        says 0 '' view "$scene" --variant "$variant" --headless --replay copy.txt "${small[@]}"
        clean 'the copied command' copied.sh
        (fanal() { printf '%s\0' "$@"; }; . ./copied.sh) >words 2>err || fail "the copied command: $(shown err)"
        [ ! -s err ] || fail "the copied command: $(shown err)"
        [ ! -e x ] || fail 'the copied command runs what a name says'
        mapfile -d '' -t words <words
        [ "${words[1]-}" = "$scene" ] || fail "the copied command has another scene: $(shown copied.sh)"
        for ((i = 0; i < ${#words[@]}; i++)); do [ "${words[i]}" != --variant ] || break; done
        [ "${words[i + 1]-}" = "$variant" ] || fail "the copied command has another variant: $(shown copied.sh)"
    done
else
    echo 'SKIPPED: built without fanal view: what the window copies' >&2
fi
[ $failures = 0 ] && echo 'nothing reaches the terminal or the shell'
exit $((failures > 0))
