#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# bundle.sh BUILD: makes BUILD/bundle/fanal-VERSION and its .tar.gz, a folder with the built command and every library
# it needs but those of libc and the GPU driver. It runs where the C library is as new as this machine's.
set -euo pipefail
build=$(cd "$1" && pwd)
version=$(sed -n 's/^CMAKE_PROJECT_VERSION:[A-Z]*=//p' "$build/CMakeCache.txt")
name=fanal-$version
bundle=$build/bundle/$name
rm -rf "$bundle" "$bundle.tar.gz"
cmake --install "$build" --component program --strip --prefix "$bundle" >/dev/null

# Part of the C library: comes with the system, like the GPU driver.
libc='^(linux-vdso|ld-linux.*|libc|libm|libdl|librt|libpthread|libresolv|libutil|libanl)\.so'
# Graphics drivers link these too and may need newer ones than ours, so the system's copy wins where there is one.
shared='^(libstdc\+\+|libgcc_s|libz|libzstd|libvulkan)\.so'

loader=$(ldconfig -p 2>/dev/null | awk '$1 == "libvulkan.so.1" && /x86-64|AArch64/ { print $NF; exit }')
[ -n "$loader" ] || { echo "bundle: libvulkan.so.1 is not installed" >&2; exit 1; }
{ ldd "$bundle/bin/fanal"; ldd "$loader"; echo "libvulkan.so.1 => $loader"; } | awk '/=> \// { print $1, $3 }' | sort -u |
    while read -r soname path; do
        if [[ $soname =~ $libc || $path == "$bundle"/* ]]; then
            continue
        elif [[ $soname =~ $shared ]]; then
            install -D -m 644 "$path" "$bundle/lib/fallback/$soname/$soname"
        else
            install -D -m 644 "$path" "$bundle/lib/$soname"
        fi
    done

cat >"$bundle/fanal" <<'EOF'
#!/bin/sh
# SPDX-License-Identifier: MIT
# Starts Fanal with the libraries beside it; those in lib/fallback only where the system has none of that name.
here=$(dirname "$(readlink -f "$0")")
path=$here/lib
system=$(PATH=$PATH:/sbin:/usr/sbin ldconfig -p 2>/dev/null | grep -E 'x86-64|AArch64')
for folder in "$here"/lib/fallback/*; do
    case $system in
    *"$(basename "$folder") "*) ;;
    *) path=$path:$folder ;;
    esac
done
LD_LIBRARY_PATH=$path${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH} exec "$here/bin/fanal" "$@"
EOF
chmod 755 "$bundle/fanal"
install -m 644 LICENSE "$bundle/LICENSE"
tar -C "$build/bundle" --owner 0 --group 0 --sort name -czf "$bundle.tar.gz" "$name"
echo "bundle: $bundle ($(du -sh "$bundle" | cut -f 1)), $bundle.tar.gz ($(du -h "$bundle.tar.gz" | cut -f 1))"
