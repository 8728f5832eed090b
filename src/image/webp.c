/* SPDX-License-Identifier: MIT */
/* WebP through libwebp: lossy and lossless stills. */
#include "image/codec.h"

#include <webp/decode.h>

static const char *status_text(VP8StatusCode status) {
    switch (status) {
    case VP8_STATUS_OUT_OF_MEMORY:
        return "out of memory";
    case VP8_STATUS_UNSUPPORTED_FEATURE:
        return "unsupported feature";
    case VP8_STATUS_NOT_ENOUGH_DATA:
        return "the file is cut off";
    default:
        return "the data are damaged";
    }
}

static fnl_result fail(const struct image_source *source, VP8StatusCode status) {
    fnl_result result = status == VP8_STATUS_OUT_OF_MEMORY         ? FNL_ERROR_MEMORY
                        : status == VP8_STATUS_UNSUPPORTED_FEATURE ? FNL_ERROR_UNSUPPORTED
                                                                   : FNL_ERROR_FORMAT;
    return image_fail(source, result, "broken WebP: %s", status_text(status));
}

static fnl_result read_features(const struct image_source *source, WebPBitstreamFeatures *features) {
    VP8StatusCode status = WebPGetFeatures(source->bytes, source->size, features);
    if (status != VP8_STATUS_OK) return fail(source, status);
    if (features->has_animation)
        return image_fail(source, FNL_ERROR_UNSUPPORTED, "is an animated WebP, not a still picture");
    return image_check_size(source, (uint64_t)features->width, (uint64_t)features->height);
}

fnl_result image_webp_peek(const struct image_source *source, struct image_file_info *out) {
    WebPBitstreamFeatures features;
    TRY(read_features(source, &features));
    *out = (struct image_file_info){.kind = IMAGE_FILE_WEBP, .width = (uint32_t)features.width, .height = (uint32_t)features.height, .pixel_bytes = 4};
    return FNL_OK;
}

fnl_result image_webp_decode(const struct image_source *source, fnl_image *out) {
    WebPDecoderConfig config;
    if (!WebPInitDecoderConfig(&config)) return image_fail(source, FNL_ERROR_UNSUPPORTED, "libwebp's version does not fit");
    TRY(read_features(source, &config.input));
    fnl_image image;
    /* A lossless file of one colour has a few bytes for any size: nothing to judge by. */
    TRY(image_allocate(source, (uint32_t)config.input.width, (uint32_t)config.input.height, FNL_PIXEL_FORMAT_RGBA8,
                       IMAGE_PIXELS_MAX, &image));
    config.output.colorspace = MODE_RGBA;
    config.output.is_external_memory = 1;
    config.output.u.RGBA = (WebPRGBABuffer){
        .rgba = image.pixels, .stride = (int)image.width * 4, .size = (size_t)image.width * image.height * 4};
    VP8StatusCode status = WebPDecode(source->bytes, source->size, &config);
    WebPFreeDecBuffer(&config.output);
    if (status != VP8_STATUS_OK) {
        fnl_image_free(source->host, &image);
        return fail(source, status);
    }
    *out = image;
    return FNL_OK;
}
