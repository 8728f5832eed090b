#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# shows BC-13: what `fanal compress` writes opens in a program that is not ours
# DDS files of BC6H in Pillow, which has a decoder of its own and clips to 8 bits: each byte against what we decode. Usage: compress_viewers_test.sh FANAL
set -u
fanal=$1
python=
for candidate in /usr/bin/python3 python3; do
    [ -n "$python" ] || ! "$candidate" -c 'import PIL.DdsImagePlugin as d; d.DXGI_FORMAT_BC6H_UF16' 2>/dev/null &&
        ! "$candidate" -c 'import PIL.DdsImagePlugin as d; d.DXGI_FORMAT.BC6H_UF16' 2>/dev/null || python=${python:-$candidate}
done
if [ -z "$python" ]; then
    echo 'SKIPPED: there is no Pillow here that opens BC6H (Debian: python3-pil)'
    exit 77
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cat >"$work/check.py" <<'PYTHON'
import struct, sys
from PIL import Image

def load_hdr(path):
    data = open(path, 'rb').read()
    at = data.index(b'\n\n') + 2
    end = data.index(b'\n', at)
    words = data[at:end].split()
    height, width, at, rows = int(words[1]), int(words[3]), end + 1, []
    for _ in range(height):
        planes = [bytearray() for _ in range(4)]
        if data[at] == 2 and data[at + 1] == 2:
            at += 4
            for plane in planes:
                while len(plane) < width:
                    count = data[at]
                    if count > 128:
                        plane.extend(data[at + 1:at + 2] * (count - 128)); at += 2
                    else:
                        plane.extend(data[at + 1:at + 1 + count]); at += 1 + count
        else:
            for x in range(width):
                for c in range(4): planes[c].append(data[at + 4 * x + c])
            at += 4 * width
        rows.append([[planes[c][x] * 2.0 ** (planes[3][x] - 136) for c in range(3)] + [2.0 ** (planes[3][x] - 136)] for x in range(width)])
    return width, height, rows

width, height, rows = load_hdr(sys.argv[2])
picture = Image.open(sys.argv[1])
picture.load()
assert picture.size == (width, height), picture.size
pixels, most, lit = picture.convert('RGB').load(), 0, 0
for y in range(height):
    for x in range(width):
        for c in range(3):
            ours = min(rows[y][x][c], 1.0) * 255
            most = max(most, abs(pixels[x, y][c] - ours) - 255 * rows[y][x][3]) # a step of the HDR file
            lit += 8 < ours < 247
print('%u x %u, at most %.2f of 255 and a step of the HDR file off, %u values between black and white' % (width, height, most, lit))
assert most <= 1.01 and lit > 3000 # Pillow cuts fractions off
PYTHON
"$fanal" render builtin:onetile --size 94x61 --shadows off -o "$work/source.exr" >"$work/log" 2>&1 || { cat "$work/log" >&2; exit 1; }
failures=0
for options in "--quality fast" "--quality quality" "--signed" "--quality best" "--mips"; do
    # shellcheck disable=SC2086
    { "$fanal" compress $options "$work/source.exr" -o "$work/a.dds" && "$fanal" compress "$work/a.dds" -o "$work/a.hdr" &&
        "$python" "$work/check.py" "$work/a.dds" "$work/a.hdr"; } >"$work/log" 2>&1 || { echo "FAILED: $options" >&2; failures=$((failures + 1)); }
    tail -n 1 "$work/log"
done
exit $((failures > 0))
