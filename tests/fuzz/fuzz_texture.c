/* SPDX-License-Identifier: MIT */
/* The readers of DDS and KTX2: whatever the bytes, a texture or an error, and all memory given back. */
#include "image/image.h"
#include "image/texture.h"
#include "tests/fuzz/fuzz.h"

#define PIXELS_MAX (1u << 22) /* larger ones are slow, not different */

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size) {
    fnl_host host = fuzz_host();
    struct image_file_info info;
    if (image_peek(&host, bytes, size, "input", &info) != FNL_OK || (info.kind != IMAGE_FILE_DDS && info.kind != IMAGE_FILE_KTX2) ||
        (uint64_t)info.width * info.height > PIXELS_MAX)
        return 0;
    const bool packed = info.kind == IMAGE_FILE_KTX2 && bytes[44]; /* supercompressed */
    struct texture texture;
    fnl_result result = texture_read(&host, bytes, size, "input", &texture);
    if (result != FNL_OK && !packed) abort(); /* what has a header that is whole can be read */
    if (result != FNL_OK && texture.bytes) abort();
    if (result == FNL_OK && (texture.width != info.width || texture.height * texture.faces != info.height)) abort();
    if (result == FNL_OK && !packed && texture_offset(&texture, texture.mips, 0) > size) abort();
    texture_free(&host, &texture);
    result = texture_decode(&host, bytes, size, "input", &(struct texture_use){.mips = true, .normals = bytes[size - 1] & 2, .keep = bytes[size - 1] & 1 ? UINT32_MAX : bytes[size - 1] & 4 ? 1u << TEXTURE_BC7 : 0}, &texture);
    if (result == FNL_OK && (info.cube || info.is_float)) abort();
    if (result == FNL_OK && texture.mips > 1 && texture.mips != texture_mips(info.width, info.height)) abort();
    texture_free(&host, &texture);
    fnl_image image;
    if (image_decode(&host, bytes, size, "input", false, &image) == FNL_OK) fnl_image_free(&host, &image);
    return 0;
}
