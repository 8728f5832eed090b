/* SPDX-License-Identifier: MIT */
/* The readers of DDS and KTX2: whatever the bytes, a texture or an error, and all memory given back. */
#include "image/image.h"
#include "image/texture.h"
#include "tests/fuzz/fuzz.h"

#define PIXELS_MAX (1u << 22) /* larger ones are slow, not different */

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size) {
    fnl_host host = fuzz_host();
    struct image_file_info info;
    if (image_peek(&host, bytes, size, "input", &info) != FNL_OK || info.kind != IMAGE_FILE_TEXTURE ||
        (uint64_t)info.width * info.height > PIXELS_MAX)
        return 0;
    struct texture texture;
    if (texture_read(&host, bytes, size, "input", &texture) != FNL_OK) abort(); /* what has a header that is whole can be read */
    if (texture.width != info.width || texture.height * texture.faces != info.height) abort();
    if (texture_offset(&texture, texture.mips, 0) > size) abort();
    texture_free(&host, &texture);
    return 0;
}
