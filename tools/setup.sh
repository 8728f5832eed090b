#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Installs the Debian packages that the command needs and that are missing; with --tests those of the tests too, with --clang the
# other compiler, with --page a browser. Part of build.sh, which says how to skip it.
set -euo pipefail

packages=(
    gcc libc6-dev cmake ninja-build pkg-config glslang-tools spirv-tools             # to build
    libvulkan-dev libjansson-dev libzstd-dev libmeshoptimizer-dev                    # what it is made of
    libspng-dev libjpeg-dev libwebp-dev zlib1g-dev libopenexr-dev libembree-dev
    libdraco-dev g++                                                                 # to read KHR_draco_mesh_compression; all else is C,
    libglfw3-dev libimgui-dev fonts-dejavu-core                                      # but for the window of 'fanal view'
    libopenxr-dev libopenxr-loader1                                                  # the headset of 'fanal xr'
    libjs-chart.js                                                                   # the plots of 'fanal bench'
    libvulkan1 mesa-vulkan-drivers                                                   # to run, without a GPU too
)

say() { echo "setup: $*"; }

. /etc/os-release 2>/dev/null || ID=unknown
for option in "$@"; do
    case $option in
    --tests)
        packages+=(libcmocka-dev vulkan-validationlayers jq xvfb python3-pil libopenmpi-dev openmpi-bin) # windows without a screen; a reader of BC6H; ranks of 'fanal cave'
        [ "$ID:${VERSION_ID:-0}" != debian:13 ] || packages+=(monado-service libopenxr1-monado)          # a simulated headset; Debian 12 has none
        ;;
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

log=$(mktemp)
trap 'rm -f "$log"' EXIT
# apt COMMAND…: waits up to five minutes for another apt to finish. By itself apt waits for dpkg's lock, not for those of its lists and archives.
apt() {
    local begun=$SECONDS told=
    until "${root[@]}" env LC_ALL=C DEBIAN_FRONTEND=noninteractive apt-get -q -o DPkg::Lock::Timeout=300 "$@" >"$log" 2>&1; do
        grep -qE 'Could not get lock|Unable to (lock|acquire)' "$log" && [ $((SECONDS - begun)) -lt 300 ] || return 1
        [ -n "$told" ] || say "waiting for another apt to finish"
        told=yes
        sleep 3
    done
}
failed() {
    tail -n 25 "$log" >&2
    say "'apt-get $*' failed" >&2
    exit 1
}
install=(install --no-install-recommends "${missing[@]}")
say "missing: ${missing[*]}"
apt update || failed update
apt --assume-no "${install[@]}" || grep -q ' newly installed' "$log" || failed "${install[@]}" # apt fails where the answer is no
sed -n -E 's/^([0-9]+ upgraded|Need to get|After this operation)/setup: \1/p' "$log"
apt -y "${install[@]}" || failed "${install[@]}"
say "installed"
