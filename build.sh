#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
set -euo pipefail
cd "$(dirname "$0")"

usage() {
    cat <<'EOF'
usage: ./build.sh VERB [OPTIONS]

  setup             installs the packages that are missing (apt, as root or through sudo; other systems: lists them)
  build             setup, then builds everything into build/: the command build/fanal, the library, the tests
  demo              installs what the command alone needs, builds it, renders the city with 4096 lights to demo.png
  test              setup, builds, runs the tests
       -R REGEX       only tests whose name matches, marked or not
       --all          also tests marked `all` in tests/slow.txt: long tables of combinations, and timing comparisons (on an idle machine)
       --quick        only those that take a few seconds (not those in tests/slow.txt): all within two minutes
       --coverage     also says of each checklist line whether tests show it, wholly or in part
       --sanitize     in build/sanitize, with AddressSanitizer and UndefinedBehaviorSanitizer
       --clang        in build/clang, compiled by clang
  bench             as demo, but measures the likely pairs of shading order and light lists on the hall, a few minutes without a GPU:
                    build/bench/report.html (build/fanal bench --all measures every pair)
       --record       instead, the experiments of bench/experiments.txt, kept in bench/results/ and shown in docs/performance.md
  shaders           what GPUs' compilers make of the shaders, without a GPU: registers, occupancy, spills; and what changed since the last record
       --record       keeps it in bench/results/ and docs/performance.md
  fuzz [SECONDS]    setup, builds the fuzzers into build/fuzz (clang, sanitizers), runs them that long together (60), two at once
  bundle            as demo, but makes build/bundle/fanal-VERSION: a folder that runs on other Linux machines
  clean             removes build/ and demo.png
  help              this text

  --no-install      any verb: installs nothing
EOF
}

fail() { echo "build.sh: $*" >&2; exit 2; }

verb=${1:-help}
[ $# -gt 0 ] && shift
install=yes sanitize='' clang='' coverage='' skip='[0-9]+ all' regex='' record='' seconds=60
while [ $# -gt 0 ]; do
    case $verb:$1 in
    *:--no-install) install= ;;
    test:--sanitize) sanitize=yes ;;
    test:--clang) clang=yes ;;
    test:--coverage) coverage=yes ;;
    test:--quick) skip='[0-9]+( all)?' ;;
    test:--all) skip='' ;;
    test:-R) [ $# -gt 1 ] || fail "-R needs a regular expression"; regex=$2 skip=''; shift ;;
    fuzz:[1-9]*) seconds=$1 ;;
    bench:--record | shaders:--record) record=yes ;;
    *) fail "'$verb' has no option '$1' (see ./build.sh help)" ;;
    esac
    shift
done

setup() { [ -z "$install" ] || tools/setup.sh "$@"; }

# Ninja's lines [DONE/ALL] become one that is rewritten, or off a terminal one every few seconds; all others stay.
follow() {
    local line count all elapsed left shown=0 begun=$SECONDS terminal=''
    [ -t 1 ] && terminal=yes
    while IFS= read -r line; do
        if ! [[ $line =~ ^\[([0-9]+)/([0-9]+)\] ]]; then
            printf '%s%s\n' "${terminal:+$'\r\e[K'}" "$line"
            continue
        fi
        count=${BASH_REMATCH[1]} all=${BASH_REMATCH[2]} elapsed=$((SECONDS - begun))
        [ -n "$terminal" ] || [ $((elapsed - shown)) -ge 5 ] || continue
        shown=$elapsed left=$((elapsed * (all - count) / count))
        line="building $count/$all, $elapsed s, about $left s left"
        if [ -n "$terminal" ]; then printf '\r%s\e[K' "$line"; else echo "$line"; fi
    done
    [ -z "$terminal" ] || printf '\r\e[K'
}

# build FOLDER TARGET [-DOPTION…]: configures quietly, shows errors.
build() {
    local folder=$1 target=$2 log
    shift 2
    log=$(cmake -S . -B "$folder" -G Ninja "$@" 2>&1) || { echo "$log" >&2; exit 1; }
    cmake --build "$folder" --target "$target" | follow
}

# What does not need cmocka, the command unless another target is named: without tests, unless the folder has them already.
build_command() {
    local options=()
    [ -e build/CMakeCache.txt ] || options=(-DFANAL_TESTS=OFF)
    build build "${1:-fanal_cli}" "${options[@]}"
}

case $verb in
setup) setup --tests ;;
build) setup --tests; build build all -DFANAL_TESTS=ON ;;
demo)
    echo "demo: 1. packages, 2. building the command into build/, 3. rendering a city with 4096 lights into demo.png"
    setup
    build_command
    build/fanal render "builtin:city?lights=4096" --size 1280x720 -o demo.png
    cat <<'EOF'
wrote demo.png

Try next:
  build/fanal render "builtin:city?lights=4096" --camera above --debug lights -o lights.png    # lights that each pixel visits
  build/fanal render builtin:hall --lists tiled -o hall.png                                    # with the times of all passes
  build/fanal bench builtin:spheres --sizes 320x180 --shading deferred -o bench                # all lists: bench/report.html
EOF
    ;;
test)
    setup --tests --page ${clang:+--clang}
    folder=build options=(-DFANAL_TESTS=ON)
    if [ -n "$clang" ]; then folder+=/clang; options+=(-DCMAKE_C_COMPILER=clang -DCMAKE_CXX_COMPILER=clang++); fi
    if [ -n "$sanitize" ]; then folder+=/sanitize; options+=("-DFANAL_SANITIZE=address,undefined"); fi
    build $folder all "${options[@]}"
    [ -z "$coverage" ] || tools/checklist.sh
    FANAL_SKIP=$([ -z "$skip" ] || sed -nE "s/^([a-z].*) +$skip\$/\1/p" tests/slow.txt | paste -sd ' ') # parts of test_render
    export FANAL_SKIP
    ctest --test-dir $folder --output-on-failure --no-tests=error -j 3 ${regex:+-R "$regex"} ${FANAL_SKIP:+-E "^(${FANAL_SKIP// /|})\$"}
    ;;
shaders) setup --tests; build build shader_report -DFANAL_TESTS=ON; if [ -n "$record" ]; then what=record; else what=show; fi; tools/shaders.sh $what build/tests/shader_report ;;
fuzz)
    setup --clang
    build_command fanal_shader_files
    # As is usual for fuzzers: what the sanitizers add is not worth more optimisation, and they name lines.
    flags='-O1 -gline-tables-only -DNDEBUG'
    build build/fuzz fuzzers -DCMAKE_C_COMPILER=clang -DCMAKE_CXX_COMPILER=clang++ -DFANAL_TESTS=OFF -DFANAL_FUZZ=ON -DFANAL_SANITIZE=address,undefined \
        "-DFANAL_SHADERS=$PWD/build/generated" "-DCMAKE_C_FLAGS_RELWITHDEBINFO=$flags" "-DCMAKE_CXX_FLAGS_RELWITHDEBINFO=$flags"
    tools/fuzz.sh build/fuzz "$seconds"
    ;;
bench)
    setup
    build_command
    if [ -n "$record" ]; then bench/record.sh build/fanal; else build/fanal bench builtin:hall --overwrite -o build/bench; fi
    ;;
bundle) setup; build_command; tools/bundle.sh build ;;
clean) rm -rf build demo.png ;;
help | -h | --help) usage ;;
*) usage >&2; exit 2 ;;
esac
