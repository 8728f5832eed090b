/* SPDX-License-Identifier: MIT */
/* The writers of pictures: what they write is read again as it was. */
#include "fanal/image.h"
#include "tests/fuzz/fuzz.h"

enum { SIDE_MAX = 40 };
static uint8_t pixels[SIDE_MAX * SIDE_MAX * 16];

static void fill(struct fuzz_input *in, bool floats) {
    uint8_t some[64];
    if (floats) {
        float values[32];
        fuzz_floats(in, values, COUNT_OF(values));
        for (size_t i = 0; i < sizeof pixels / 4; i++) memcpy(pixels + 4 * i, &values[(i + i / 32) % 32], 4);
    } else {
        fuzz_take(in, some, sizeof some);
        for (size_t i = 0; i < sizeof pixels; i++) pixels[i] = some[(i + i / 64) % 64];
    }
}

/* RGBE: half a step of the pixel's greatest component, and alpha is gone. */
static void check_hdr(const float *was, const float *is) {
    float greatest = 0;
    for (int c = 0; c < 3; c++) {
        if (!isfinite(is[c]) || is[c] < 0) abort();
        if (!isfinite(was[c]) || was[c] > 1e38f) return;
        greatest = fmaxf(greatest, was[c]);
    }
    for (int c = 0; c < 3 && greatest > 1e-30f; c++)
        if (fabsf(fmaxf(was[c], 0) - is[c]) > greatest / 127) abort();
}

static void check_image(const fnl_host *host, fnl_pixel_format format, const char *extension, uint32_t width,
                        uint32_t height) {
    char path[320];
    fnl_image image = {width, height, format, pixels}, back;
    snprintf(path, sizeof path, "%s/picture.%s", fuzz_folder(), extension);
    bool floats = format == FNL_PIXEL_FORMAT_RGBA32F, fits = width && height && floats == (strcmp(extension, "png") != 0);
    if ((fnl_image_save(host, path, &image) == FNL_OK) != fits) abort();
    if (!fits) return;
    if (fnl_image_load(host, path, &back) != FNL_OK || back.width != width || back.height != height || back.format != format)
        abort();
    size_t bytes = (size_t)width * height * fnl_pixel_size(format);
    if (strcmp(extension, "hdr") != 0 && memcmp(back.pixels, pixels, bytes) != 0) abort();
    for (size_t i = 0; strcmp(extension, "hdr") == 0 && i < (size_t)width * height; i++)
        check_hdr((const float *)(const void *)pixels + 4 * i, (const float *)back.pixels + 4 * i);
    fnl_image_free(host, &back);
}

static void check_channels(const fnl_host *host, struct fuzz_input *in, uint32_t width, uint32_t height) {
    char path[320], names[4][300];
    fnl_exr_channel channels[4];
    uint32_t count = fuzz_byte(in) % 5;
    for (uint32_t i = 0; i < count; i++) {
        size_t length = fuzz_byte(in) % 4 ? fuzz_byte(in) % 8 : fuzz_byte(in);
        fuzz_take(in, names[i], length);
        names[i][length] = 0;
        channels[i] = (fnl_exr_channel){names[i], (const float *)(const void *)pixels + i, 1 + fuzz_byte(in) % 4};
    }
    snprintf(path, sizeof path, "%s/channels.exr", fuzz_folder());
    if (fnl_exr_save(host, path, width, height, channels, count) != FNL_OK) return;
    fnl_image back;
    if (fnl_image_load(host, path, &back) == FNL_OK) {
        if (back.width != width || back.height != height) abort();
        fnl_image_free(host, &back);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size) {
    static const char *const extensions[] = {"png", "exr", "hdr"};
    static const fnl_pixel_format formats[] = {FNL_PIXEL_FORMAT_RGBA8, FNL_PIXEL_FORMAT_RGBA16, FNL_PIXEL_FORMAT_RGBA32F};
    fnl_host host = fuzz_host();
    struct fuzz_input in = {bytes, size};
    uint8_t what = fuzz_byte(&in);
    uint32_t width = fuzz_byte(&in) % (SIDE_MAX + 1), height = fuzz_byte(&in) % (SIDE_MAX + 1);
    fnl_pixel_format format = formats[what / 4 % 3];
    fill(&in, what % 4 == 3 || format == FNL_PIXEL_FORMAT_RGBA32F);
    if (what % 4 == 3)
        check_channels(&host, &in, width, height);
    else
        check_image(&host, format, extensions[what % 4], width, height);
    return 0;
}
