/* SPDX-License-Identifier: MIT */
/* The readers of image files: whatever the bytes, a picture or an error, and all memory given back. */
#include "image/image.h"
#include "tests/fuzz/fuzz.h"

#define PIXELS_MAX (1u << 22) /* larger pictures are slow, not different */

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size) {
    fnl_host host = fuzz_host();
    struct image_file_info info;
    if (image_peek(&host, bytes, size, "input", &info) != FNL_OK || (uint64_t)info.width * info.height > PIXELS_MAX)
        return 0;
    fnl_image image;
    if (image_decode(&host, bytes, size, "input", size % 2, &image) != FNL_OK) {
        if (image.pixels) abort();
        return 0;
    }
    if (image.width != info.width || image.height != info.height) abort();
    fnl_image_free(&host, &image);
    return 0;
}
