#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Installs the Debian packages that Fanal needs and that are missing: tools/setup.sh [--clang] [--page]. Part of build.sh, which
# says how to skip it.
set -euo pipefail

packages=(
    gcc g++ cmake ninja-build pkg-config glslang-tools spirv-tools                  # to build
    libvulkan-dev libjansson-dev libzstd-dev libmeshoptimizer-dev # what it is made of
    libspng-dev libjpeg-dev libwebp-dev libopenexr-dev
    libjs-chart.js                                                                   # the plots of 'fanal bench'
    libvulkan1 mesa-vulkan-drivers                                                   # to run, without a GPU too
    libcmocka-dev vulkan-validationlayers                                            # to test
)

say() { echo "setup: $*"; }

. /etc/os-release 2>/dev/null || ID=unknown
for option in "$@"; do
    case $option in
    --clang) packages+=(clang libclang-rt-dev) ;;            # for the fuzzers and `test --clang`
    --page) [ "$ID" != debian ] || packages+=(chromium) ;;   # to test the page of 'fanal bench'; Ubuntu has none as a package
    esac
done
if ! command -v apt-get >/dev/null || ! command -v dpkg-query >/dev/null; then
    say "this system (${PRETTY_NAME:-$ID}) has no apt; it needs what Debian calls:"
    say "  ${packages[*]}"
    exit 0
fi

present=$( (dpkg-query -W -f '${Package} ${db:Status-Status}\n' "${packages[@]}" 2>/dev/null || true) |
    awk '$2 == "installed" { print $1 }')
missing=()
for package in "${packages[@]}"; do
    grep -qx -- "$package" <<<"$present" || missing+=("$package")
done

# Debian 12's Mesa 22.3 has no descriptor indexing on the CPU driver: that one package comes from backports.
backports=
if [ "${VERSION_CODENAME:-}" = bookworm ]; then
    version=$(dpkg-query -W -f '${Version}' mesa-vulkan-drivers 2>/dev/null || true)
    if ! dpkg --compare-versions "${version:-0}" ge 24; then
        backports=bookworm-backports
        for i in "${!missing[@]}"; do
            [ "${missing[$i]}" != mesa-vulkan-drivers ] || unset "missing[$i]"
        done
        missing+=("mesa-vulkan-drivers/$backports")
    fi
fi

if [ ${#missing[@]} -eq 0 ]; then
    say "all packages are there"
    exit 0
fi

root=()
if [ "$(id -u)" -ne 0 ]; then
    if ! command -v sudo >/dev/null; then
        say "cannot install without root or sudo: ${missing[*]}" >&2
        exit 1
    fi
    root=(sudo)
fi

# apt itself names the mirror: it reads every form of source list there is.
sources() { apt-get indextargets --no-release-info --format '$(RELEASE) $(COMPONENT) $(REPO_URI)' 'Created-By: Packages' | sort -u; }
if [ -n "$backports" ] && ! sources | grep -q "^$backports main "; then
    mirror=$(sources | awk '$1 == "bookworm" && $2 == "main" { print $3; exit }')
    if [ -z "$mirror" ]; then
        say "apt has no source for 'bookworm main', so none is known for $backports" >&2
        exit 1
    fi
    keyring=/usr/share/keyrings/debian-archive-keyring.gpg
    option=; [ -e $keyring ] && option="[signed-by=$keyring] "
    list=/etc/apt/sources.list.d/fanal-backports.list
    say "adding $list: deb $mirror $backports main (apt takes nothing from it unless asked to)"
    echo "deb $option$mirror $backports main" | "${root[@]}" tee $list >/dev/null
fi

say "installing ${missing[*]}"
log=$(mktemp)
trap 'rm -f "$log"' EXIT
apt() {
    "${root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -y -q "$@" >"$log" 2>&1 && return
    tail -n 25 "$log" >&2
    say "'apt-get $*' failed" >&2
    exit 1
}
apt update
apt install --no-install-recommends "${missing[@]}"
grep -E '^[0-9]+ upgraded|^Need to get|newly installed' "$log" | sed 's/^/setup: /' || true
