/* SPDX-License-Identifier: MIT */
/* KHR_meshopt_compression: whatever the bytes, nothing beyond them is read and nothing beyond the output written. */
#include "scene/meshcode.h"
#include "tests/fuzz/fuzz.h"

/* Mode, filter, stride, count; the rest is the data, in memory of its own size. */
int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size) {
    struct fuzz_input in = {bytes, size};
    const uint8_t mode = fuzz_byte(&in) % 3, filter = fuzz_byte(&in) % 5;
    size_t stride = mode ? 2u << fuzz_byte(&in) % 2 : 4u * (1 + fuzz_byte(&in) % 64), count = 1 + fuzz_u32(&in) % 5000;
    if (mode == 0 && filter && filter != 3) stride = filter == 2 || stride % 8 == 0 ? 8 : 4;
    if (mode == 1) count = (count + 2) / 3 * 3;
    uint8_t *data = malloc(MAX(in.size, 1)), *out = malloc(count * stride);
    if (!data || !out) abort();
    if (in.size) memcpy(data, in.bytes, in.size);
    bool good = mode == 0   ? meshcode_attributes(out, count, stride, data, in.size)
                : mode == 1 ? meshcode_triangles(out, count, stride, data, in.size)
                            : meshcode_indices(out, count, stride, data, in.size);
    if (!good) memset(out, bytes && size ? bytes[size - 1] : 0, count * stride); /* filters stand whatever is there */
    if (mode == 0 && filter == 1) meshcode_filter_octahedral(out, count, stride);
    if (mode == 0 && filter == 2) meshcode_filter_quaternion(out, count);
    if (mode == 0 && filter == 3) meshcode_filter_exponential(out, count, stride);
    if (mode == 0 && filter == 4) meshcode_filter_color(out, count, stride);
    free(data);
    free(out);
    return 0;
}
