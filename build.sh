#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
set -euo pipefail
cd "$(dirname "$0")"

usage() {
    cat <<'EOF'
usage: ./build.sh VERB [OPTIONS]

  setup             installs the packages that are missing (apt, as root or through sudo; other systems: lists them)
  build             setup, then builds everything into build/: the command build/fanal, the library, the tests
  demo              setup, builds the command, renders the city with 4096 lights to demo.png
  test              setup, builds, runs every test
       -R REGEX       only tests whose name matches
       --coverage     also says of each checklist line whether tests show it, wholly or in part
       --sanitize     in build/sanitize, with AddressSanitizer and UndefinedBehaviorSanitizer
       --clang        in build/clang, compiled by clang
  bench             setup, builds the command, measures the likely pairs of shading order and light lists on the hall, two minutes without a GPU:
                    build/bench/report.html (build/fanal bench --all measures every pair)
  fuzz [SECONDS]    setup, builds the fuzzers into build/fuzz (clang, sanitizers), runs them that long together (60)
  bundle            setup, builds, makes build/bundle/fanal-VERSION: a folder that runs on other Linux machines
  clean             removes build/ and demo.png
  help              this text

  --no-install      any verb: installs nothing
EOF
}

fail() { echo "build.sh: $*" >&2; exit 2; }

verb=${1:-help}
[ $# -gt 0 ] && shift
install=yes sanitize='' clang='' coverage='' regex='' seconds=60
while [ $# -gt 0 ]; do
    case $verb:$1 in
    *:--no-install) install= ;;
    test:--sanitize) sanitize=yes ;;
    test:--clang) clang=yes ;;
    test:--coverage) coverage=yes ;;
    test:-R) [ $# -gt 1 ] || fail "-R needs a regular expression"; regex=$2; shift ;;
    fuzz:[1-9]*) seconds=$1 ;;
    *) fail "'$verb' has no option '$1' (see ./build.sh help)" ;;
    esac
    shift
done

setup() { [ -z "$install" ] || tools/setup.sh "$@"; }

# build FOLDER TARGET [-DOPTION…]: configures quietly, shows errors.
build() {
    local folder=$1 target=$2 log
    shift 2
    log=$(cmake -S . -B "$folder" -G Ninja "$@" 2>&1) || { echo "$log" >&2; exit 1; }
    cmake --build "$folder" --target "$target"
}

case $verb in
setup) setup ;;
build) setup; build build all ;;
demo)
    setup
    build build fanal_cli
    build/fanal render "builtin:city?lights=4096" --size 1280x720 --msaa 4 --exposure 2.7 -o demo.png
    ;;
test)
    setup --page ${clang:+--clang}
    folder=build options=()
    if [ -n "$clang" ]; then folder+=/clang; options+=(-DCMAKE_C_COMPILER=clang -DCMAKE_CXX_COMPILER=clang++); fi
    if [ -n "$sanitize" ]; then folder+=/sanitize; options+=("-DFANAL_SANITIZE=address,undefined"); fi
    build $folder all "${options[@]}"
    [ -z "$coverage" ] || tools/checklist.sh
    ctest --test-dir $folder --output-on-failure --no-tests=error -j 2 ${regex:+-R "$regex"}
    ;;
fuzz) setup --clang; build build/fuzz fuzzers -DCMAKE_C_COMPILER=clang -DFANAL_TESTS=OFF -DFANAL_FUZZ=ON \
    -DFANAL_SANITIZE=address,undefined; tools/fuzz.sh build/fuzz "$seconds" ;;
bench) setup; build build fanal_cli; build/fanal bench builtin:hall --overwrite -o build/bench ;;
bundle) setup; build build fanal_cli; tools/bundle.sh build ;;
clean) rm -rf build demo.png ;;
help | -h | --help) usage ;;
*) usage >&2; exit 2 ;;
esac
