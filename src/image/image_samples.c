/* SPDX-License-Identifier: MIT */
#include "image/image_samples.h"

#include <math.h>

#include <jpeglib.h>
#include <openexr.h>
#include <spng.h>
#include <webp/encode.h>

#define CHECK(expression)                                                                                                   \
    do {                                                                                                                    \
        if (!(expression)) {                                                                                                \
            fprintf(stderr, "%s:%d: '%s' does not hold\n", __FILE__, __LINE__, #expression);                                \
            abort();                                                                                                        \
        }                                                                                                                   \
    } while (0)

struct maker {
    struct image_sample *samples;
    uint32_t count, width, height;
};

static struct image_sample *add(struct maker *maker, const char *name, enum image_file_kind kind, fnl_pixel_format format) {
    CHECK(maker->count < IMAGE_SAMPLES_MAX);
    struct image_sample *sample = &maker->samples[maker->count++];
    *sample = (struct image_sample){.name = name, .kind = kind};
    sample->expected = (fnl_image){.width = maker->width, .height = maker->height, .format = format};
    sample->expected.pixels = calloc((size_t)maker->width * maker->height, fnl_pixel_size(format));
    CHECK(sample->expected.pixels != NULL);
    return sample;
}

/* Smooth, so that lossy files stay near it; in [0, 1]. */
static double pattern(uint32_t x, uint32_t y, uint32_t channel) {
    return 0.5 + 0.45 * sin(0.11 * x + 0.5 * channel) * cos(0.07 * y + 0.3 * channel);
}

static uint32_t level(uint32_t x, uint32_t y, uint32_t channel, uint32_t greatest) {
    return (uint32_t)(pattern(x, y, channel) * greatest + 0.5);
}

/* ---- PNG ---- */

static void add_png(struct maker *maker, const char *name, uint8_t color_type, uint8_t depth, bool transparent) {
    bool wide = depth == 16;
    struct image_sample *sample = add(maker, name, IMAGE_FILE_PNG, wide ? FNL_PIXEL_FORMAT_RGBA16 : FNL_PIXEL_FORMAT_RGBA8);
    static const uint32_t channels_of[] = {1, 0, 3, 1, 2, 0, 4};
    uint32_t channels = channels_of[color_type], greatest = (1u << depth) - 1, full = wide ? 65535 : 255;
    bool indexed = color_type == SPNG_COLOR_TYPE_INDEXED, grey = channels <= 2 && !indexed, alpha = channels % 2 == 0;
    size_t row_bytes = ((size_t)maker->width * channels * depth + 7) / 8;
    unsigned char *data = calloc(row_bytes, maker->height);
    CHECK(data != NULL);
    for (uint32_t y = 0; y < maker->height; y++)
        for (uint32_t x = 0; x < maker->width; x++) {
            uint32_t values[4] = {0};
            for (uint32_t c = 0; c < channels; c++) {
                values[c] = level(x, y, c, greatest);
                unsigned char *row = data + y * row_bytes;
                size_t bit = ((size_t)x * channels + c) * depth;
                if (wide)
                    memcpy(row + bit / 8, &(uint16_t){(uint16_t)values[c]}, 2);
                else
                    row[bit / 8] |= (unsigned char)(values[c] << (8 - depth - bit % 8));
            }
            for (uint32_t c = 0; c < 4; c++) {
                uint32_t value = c == 3 ? (alpha ? values[channels - 1] : greatest) : values[grey ? 0 : c];
                uint32_t shown = value * (full / greatest);
                if (indexed) shown = c == 3 ? (transparent && values[0] == 1 ? 77 : 255) : (values[0] * 10 + c) & 255;
                if (transparent && !indexed && c == 3 && values[0] == level(0, 0, 0, greatest)) shown = 0;
                size_t at = ((size_t)y * maker->width + x) * 4 + c;
                if (wide)
                    ((uint16_t *)sample->expected.pixels)[at] = (uint16_t)shown;
                else
                    ((uint8_t *)sample->expected.pixels)[at] = (uint8_t)shown;
            }
        }
    spng_ctx *png = spng_ctx_new(SPNG_CTX_ENCODER);
    CHECK(png != NULL && spng_set_option(png, SPNG_ENCODE_TO_BUFFER, 1) == 0);
    struct spng_ihdr header = {.width = maker->width, .height = maker->height, .bit_depth = depth, .color_type = color_type};
    CHECK(spng_set_ihdr(png, &header) == 0);
    if (indexed) {
        struct spng_plte palette = {.n_entries = 1u << depth};
        for (uint32_t i = 0; i < palette.n_entries; i++)
            palette.entries[i] = (struct spng_plte_entry){
                .red = (uint8_t)(i * 10), .green = (uint8_t)(i * 10 + 1), .blue = (uint8_t)(i * 10 + 2)};
        CHECK(spng_set_plte(png, &palette) == 0);
    }
    if (transparent) {
        struct spng_trns trns = {.gray = (uint16_t)level(0, 0, 0, greatest), .n_type3_entries = 2, .type3_alpha = {255, 77}};
        CHECK(spng_set_trns(png, &trns) == 0);
    }
    CHECK(spng_encode_image(png, data, row_bytes * maker->height, SPNG_FMT_PNG, SPNG_ENCODE_FINALIZE) == 0);
    int error;
    sample->bytes = spng_get_png_buffer(png, &sample->size, &error);
    CHECK(sample->bytes != NULL);
    spng_ctx_free(png);
    free(data);
}

/* ---- JPEG ---- */

struct jpeg_kind {
    J_COLOR_SPACE input, stored;
    bool progressive, subsampled, restarts, arithmetic;
};

static void add_jpeg(struct maker *maker, const char *name, struct jpeg_kind kind) {
    struct image_sample *sample = add(maker, name, IMAGE_FILE_JPEG, FNL_PIXEL_FORMAT_RGBA8);
    sample->tolerance = 12 / 255.0;
    struct jpeg_compress_struct jpeg;
    struct jpeg_error_mgr errors;
    jpeg.err = jpeg_std_error(&errors);
    jpeg_create_compress(&jpeg);
    unsigned char *bytes = NULL;
    unsigned long size = 0;
    jpeg_mem_dest(&jpeg, &bytes, &size);
    jpeg.image_width = maker->width;
    jpeg.image_height = maker->height;
    jpeg.in_color_space = kind.input;
    jpeg.input_components = kind.input == JCS_GRAYSCALE ? 1 : kind.input == JCS_CMYK ? 4 : 3;
    jpeg_set_defaults(&jpeg);
    jpeg_set_colorspace(&jpeg, kind.stored);
    jpeg_set_quality(&jpeg, 95, TRUE);
    if (kind.progressive) jpeg_simple_progression(&jpeg);
    if (!kind.subsampled) jpeg.comp_info[0].h_samp_factor = jpeg.comp_info[0].v_samp_factor = 1;
    if (kind.stored == JCS_YCCK) jpeg.comp_info[3].h_samp_factor = jpeg.comp_info[3].v_samp_factor = 1;
    if (kind.restarts) jpeg.restart_interval = 1;
    jpeg.arith_code = kind.arithmetic;
    if (kind.arithmetic) sample->result = FNL_ERROR_UNSUPPORTED;
    jpeg_start_compress(&jpeg, TRUE);
    unsigned char *row = malloc((size_t)maker->width * 4);
    CHECK(row != NULL);
    for (uint32_t y = 0; y < maker->height; y++) {
        for (uint32_t x = 0; x < maker->width; x++) {
            uint8_t *pixel = (uint8_t *)sample->expected.pixels + ((size_t)y * maker->width + x) * 4;
            uint32_t light = 200; /* Adobe's CMYK is inverted: 255 is no ink */
            for (uint32_t c = 0; c < 3; c++) {
                uint32_t value = level(x, y, kind.input == JCS_GRAYSCALE ? 0 : c, 255);
                row[x * (uint32_t)jpeg.input_components + (kind.input == JCS_GRAYSCALE ? 0 : c)] = (uint8_t)value;
                pixel[c] = (uint8_t)(kind.input == JCS_CMYK ? (value * light + 127) / 255 : value);
            }
            if (kind.input == JCS_CMYK) row[x * 4 + 3] = (uint8_t)light;
            pixel[3] = 255;
        }
        jpeg_write_scanlines(&jpeg, &row, 1);
    }
    free(row);
    jpeg_finish_compress(&jpeg);
    jpeg_destroy_compress(&jpeg);
    sample->bytes = bytes;
    sample->size = size;
}

/* ---- WebP ---- */

static void add_webp(struct maker *maker, const char *name, bool lossless) {
    struct image_sample *sample = add(maker, name, IMAGE_FILE_WEBP, FNL_PIXEL_FORMAT_RGBA8);
    uint8_t *pixels = sample->expected.pixels;
    for (uint32_t i = 0; i < maker->width * maker->height * 4; i++)
        pixels[i] = (uint8_t)level(i / 4 % maker->width, i / 4 / maker->width, i % 4, 255) | (i % 4 == 3 ? 128 : 0);
    sample->tolerance = lossless ? 0 : 40 / 255.0;
    int width = (int)maker->width, height = (int)maker->height;
    uint8_t *bytes = NULL;
    sample->size = lossless ? WebPEncodeLosslessRGBA(pixels, width, height, width * 4, &bytes)
                            : WebPEncodeRGBA(pixels, width, height, width * 4, 100, &bytes);
    CHECK(sample->size > 0);
    sample->bytes = malloc(sample->size);
    CHECK(sample->bytes != NULL);
    memcpy(sample->bytes, bytes, sample->size);
    WebPFree(bytes);
}

/* ---- Radiance HDR ---- */

enum hdr_kind { HDR_FLAT, HDR_OLD_RUNS, HDR_NEW_RUNS };

static void add_hdr(struct maker *maker, const char *name, enum hdr_kind kind, const char *axes, double exposure) {
    struct image_sample *sample = add(maker, name, IMAGE_FILE_HDR, FNL_PIXEL_FORMAT_RGBA32F);
    uint32_t width = maker->width, height = maker->height;
    unsigned char *bytes = malloc(256 + (size_t)width * height * 8), *at = bytes;
    CHECK(bytes != NULL);
    at += sprintf((char *)at, "#?RADIANCE\n# a comment\nEXPOSURE=%g\nFORMAT=32-bit_rle_rgbe\n\n%cY %u %cX %u\n", exposure,
                  axes[0], height, axes[1], width);
    bool new_runs = kind == HDR_NEW_RUNS && width >= 8;
    for (uint32_t y = 0; y < height; y++) {
        if (new_runs) at += (*at = 2, at[1] = 2, at[2] = (unsigned char)(width >> 8), at[3] = (unsigned char)width, 4);
        unsigned char *row = malloc((size_t)width * 4);
        CHECK(row != NULL);
        for (uint32_t x = 0; x < width; x++) {
            uint32_t column = x / 5; /* makes runs */
            unsigned char rgbe[4] = {(unsigned char)(128 + level(column, y, 0, 127)),
                                     (unsigned char)level(column, y, 1, 255), (unsigned char)level(column, y, 2, 255),
                                     (unsigned char)(120 + column % 16)};
            memcpy(row + (size_t)x * 4, rgbe, 4);
            uint32_t shown_x = axes[1] == '+' ? x : width - 1 - x, shown_y = axes[0] == '-' ? y : height - 1 - y;
            float *pixel = (float *)sample->expected.pixels + ((size_t)shown_y * width + shown_x) * 4;
            for (int c = 0; c < 3; c++) pixel[c] = (float)(ldexp(rgbe[c], rgbe[3] - 136) / exposure);
            pixel[3] = 1;
        }
        for (uint32_t c = 0; new_runs && c < 4; c++)
            for (uint32_t x = 0; x < width;) {
                uint32_t run = 1;
                while (x + run < width && run < 127 && row[(x + run) * 4 + c] == row[x * 4 + c]) run++;
                *at++ = (unsigned char)(run > 2 ? 128 + run : run);
                for (uint32_t i = 0; i < (run > 2 ? 1 : run); i++) *at++ = row[x * 4 + c];
                x += run;
            }
        for (uint32_t x = 0; !new_runs && x < width;) {
            uint32_t run = 1;
            while (kind == HDR_OLD_RUNS && x + run < width && memcmp(row + (x + run) * 4, row + x * 4, 4) == 0) run++;
            memcpy(at, row + x * 4, 4);
            at += 4;
            if (run > 1) {
                const unsigned char mark[4] = {1, 1, 1, (unsigned char)(run - 1)};
                memcpy(at, mark, 4);
                at += 4;
            }
            x += run;
        }
        free(row);
    }
    sample->bytes = bytes;
    sample->size = (size_t)(at - bytes);
}

/* ---- OpenEXR ---- */

struct exr_kind {
    exr_compression_t compression;
    exr_pixel_type_t type;
    const char *channels; /* one letter each, sorted */
    int tile;             /* side of the tiles, 0: scanlines */
    int32_t left, top;    /* of the data window */
    bool multipart, deep;
    double tolerance;
};

struct memory_file {
    unsigned char *bytes;
    size_t size, capacity;
};

static int64_t write_memory(exr_const_context_t exr, void *user, const void *buffer, uint64_t size, uint64_t offset,
                            exr_stream_error_func_ptr_t fail) {
    (void)exr;
    (void)fail;
    struct memory_file *file = user;
    if (offset + size > file->capacity) {
        file->capacity = (size_t)(offset + size) * 2;
        file->bytes = realloc(file->bytes, file->capacity);
        CHECK(file->bytes != NULL);
    }
    memcpy(file->bytes + offset, buffer, (size_t)size);
    file->size = MAX(file->size, (size_t)(offset + size));
    return (int64_t)size;
}

static void say_nothing(exr_const_context_t exr, exr_result_t code, const char *message) {
    (void)exr;
    (void)code;
    (void)message;
}

/* False when this version of the library lacks the compression. */
static bool write_exr_chunk(exr_context_t exr, int part, const exr_chunk_info_t *chunk, const void *pixels, uint32_t x,
                            uint32_t y, uint32_t width) {
    exr_encode_pipeline_t pipeline = EXR_ENCODE_PIPELINE_INITIALIZER;
    CHECK(exr_encoding_initialize(exr, part, chunk, &pipeline) == 0);
    for (int i = 0; i < pipeline.channel_count; i++) {
        exr_coding_channel_info_t *channel = &pipeline.channels[i];
        channel->encode_from_ptr = (const uint8_t *)pixels + (((size_t)y * width + x) * 4 + (size_t)i) * 4;
        channel->user_pixel_stride = 16;
        channel->user_line_stride = (int32_t)width * 16;
        channel->user_bytes_per_element = 4;
        channel->user_data_type = channel->data_type == EXR_PIXEL_UINT ? EXR_PIXEL_UINT : EXR_PIXEL_FLOAT;
    }
    CHECK(exr_encoding_choose_default_routines(exr, part, &pipeline) == 0);
    exr_result_t error = exr_encoding_run(exr, part, &pipeline);
    CHECK(error == 0 || error == EXR_ERR_FEATURE_NOT_IMPLEMENTED);
    CHECK(exr_encoding_destroy(exr, &pipeline) == 0);
    return error == 0;
}

static bool write_exr_part(exr_context_t exr, int part, struct exr_kind kind, const void *pixels, uint32_t width,
                           uint32_t height) {
    exr_chunk_info_t chunk;
    bool written = true;
    if (kind.tile) {
        for (uint32_t y = 0; y * (uint32_t)kind.tile < height; y++)
            for (uint32_t x = 0; x * (uint32_t)kind.tile < width; x++) {
                CHECK(exr_write_tile_chunk_info(exr, part, (int)x, (int)y, 0, 0, &chunk) == 0);
                written &=
                    write_exr_chunk(exr, part, &chunk, pixels, x * (uint32_t)kind.tile, y * (uint32_t)kind.tile, width);
            }
        return written;
    }
    int32_t step;
    CHECK(exr_get_scanlines_per_chunk(exr, part, &step) == 0);
    for (uint32_t y = 0; written && y < height; y += (uint32_t)step) {
        CHECK(exr_write_scanline_chunk_info(exr, part, kind.top + (int)y, &chunk) == 0);
        written = write_exr_chunk(exr, part, &chunk, pixels, 0, y, width);
    }
    return written;
}

static void add_exr_part(exr_context_t exr, const char *name, struct exr_kind kind, uint32_t width, uint32_t height) {
    int part;
    exr_storage_t storage = kind.deep ? EXR_STORAGE_DEEP_SCANLINE : kind.tile ? EXR_STORAGE_TILED : EXR_STORAGE_SCANLINE;
    CHECK(exr_add_part(exr, name, storage, &part) == 0);
    CHECK(exr_initialize_required_attr_simple(exr, part, (int32_t)width, (int32_t)height, kind.compression) == 0);
    exr_attr_box2i_t window;
    window.min.x = kind.left;
    window.min.y = kind.top;
    window.max.x = kind.left + (int32_t)width - 1;
    window.max.y = kind.top + (int32_t)height - 1;
    CHECK(exr_set_data_window(exr, part, &window) == 0);
    CHECK(exr_set_display_window(exr, part, &window) == 0);
    if (kind.tile)
        CHECK(exr_set_tile_descriptor(exr, part, (uint32_t)kind.tile, (uint32_t)kind.tile, EXR_TILE_ONE_LEVEL,
                                      EXR_TILE_ROUND_DOWN) == 0);
    for (const char *c = kind.channels; *c; c++)
        CHECK(exr_add_channel(exr, part, (char[]){*c, 0}, kind.type, EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1) == 0);
}

static void add_exr(struct maker *maker, const char *name, struct exr_kind kind) {
    struct image_sample *sample = add(maker, name, IMAGE_FILE_EXR, FNL_PIXEL_FORMAT_RGBA32F);
    sample->tolerance = kind.tolerance;
    if (kind.deep) sample->result = FNL_ERROR_UNSUPPORTED;
    uint32_t width = maker->width, height = maker->height;
    uint32_t *stored = calloc((size_t)width * height * 4, 4);
    CHECK(stored != NULL);
    for (uint32_t i = 0; i < width * height; i++) {
        float *pixel = (float *)sample->expected.pixels + (size_t)i * 4;
        pixel[3] = 1;
        for (uint32_t k = 0; kind.channels[k]; k++) {
            float value = (float)level(i % width, i / width, k, 2047) * (kind.type == EXR_PIXEL_UINT ? 1000 : 0x1p-8f);
            if (kind.type == EXR_PIXEL_UINT)
                stored[i * 4 + k] = (uint32_t)value;
            else
                memcpy(&stored[i * 4 + k], &value, 4);
            const char *target = strchr("RGBA", kind.channels[k]);
            if (target) pixel[target - "RGBA"] = value;
            if (kind.channels[k] == 'Y') pixel[0] = pixel[1] = pixel[2] = value;
        }
    }
    struct memory_file file = {0};
    exr_context_initializer_t start = EXR_DEFAULT_CONTEXT_INITIALIZER;
    start.user_data = &file;
    start.write_fn = write_memory;
    start.error_handler_fn = say_nothing;
    exr_context_t exr = NULL;
    CHECK(exr_start_write(&exr, name, EXR_WRITE_FILE_DIRECTLY, &start) == 0);
    add_exr_part(exr, kind.multipart ? "first" : NULL, kind, width, height);
    if (kind.multipart) add_exr_part(exr, "second", kind, width, height);
    if (kind.deep) CHECK(exr_set_version(exr, 0, 1) == 0);
    CHECK(exr_write_header(exr) == 0);
    /* The deep file has no chunks: its header is enough to be refused. */
    bool written = kind.deep || write_exr_part(exr, 0, kind, stored, width, height);
    if (kind.multipart) write_exr_part(exr, 1, kind, sample->expected.pixels, width, height);
    exr_result_t error = exr_finish(&exr);
    CHECK(error == 0 || kind.deep || !written);
    sample->bytes = file.bytes;
    sample->size = file.size;
    free(stored);
    if (!written) {
        image_samples_free(sample, 1);
        maker->count--;
    }
}

/* ---- all ---- */

uint32_t image_samples_make(struct image_sample samples[IMAGE_SAMPLES_MAX], uint32_t width, uint32_t height) {
    struct maker maker = {samples, 0, width, height};
    add_png(&maker, "grey1.png", SPNG_COLOR_TYPE_GRAYSCALE, 1, false);
    add_png(&maker, "grey4.png", SPNG_COLOR_TYPE_GRAYSCALE, 4, false);
    add_png(&maker, "grey8.png", SPNG_COLOR_TYPE_GRAYSCALE, 8, false);
    add_png(&maker, "grey8-key.png", SPNG_COLOR_TYPE_GRAYSCALE, 8, true);
    add_png(&maker, "grey-alpha8.png", SPNG_COLOR_TYPE_GRAYSCALE_ALPHA, 8, false);
    add_png(&maker, "palette2.png", SPNG_COLOR_TYPE_INDEXED, 2, true);
    add_png(&maker, "palette8.png", SPNG_COLOR_TYPE_INDEXED, 8, false);
    add_png(&maker, "rgb8.png", SPNG_COLOR_TYPE_TRUECOLOR, 8, false);
    add_png(&maker, "rgba8.png", SPNG_COLOR_TYPE_TRUECOLOR_ALPHA, 8, false);
    add_png(&maker, "grey16.png", SPNG_COLOR_TYPE_GRAYSCALE, 16, false);
    add_png(&maker, "rgb16.png", SPNG_COLOR_TYPE_TRUECOLOR, 16, false);
    add_png(&maker, "rgba16.png", SPNG_COLOR_TYPE_TRUECOLOR_ALPHA, 16, false);
    add_jpeg(&maker, "444.jpg", (struct jpeg_kind){.input = JCS_RGB, .stored = JCS_YCbCr});
    add_jpeg(&maker, "420-restarts.jpg", (struct jpeg_kind){JCS_RGB, JCS_YCbCr, .subsampled = true, .restarts = true});
    add_jpeg(&maker, "progressive.jpg", (struct jpeg_kind){JCS_RGB, JCS_YCbCr, .progressive = true, .subsampled = true});
    add_jpeg(&maker, "rgb.jpg", (struct jpeg_kind){.input = JCS_RGB, .stored = JCS_RGB});
    add_jpeg(&maker, "grey.jpg", (struct jpeg_kind){.input = JCS_GRAYSCALE, .stored = JCS_GRAYSCALE});
    add_jpeg(&maker, "cmyk.jpg", (struct jpeg_kind){.input = JCS_CMYK, .stored = JCS_CMYK});
    add_jpeg(&maker, "ycck.jpg", (struct jpeg_kind){.input = JCS_CMYK, .stored = JCS_YCCK});
    add_jpeg(&maker, "arithmetic.jpg", (struct jpeg_kind){JCS_RGB, JCS_YCbCr, .arithmetic = true});
    add_webp(&maker, "lossless.webp", true);
    add_webp(&maker, "lossy-alpha.webp", false);
    add_hdr(&maker, "flat.hdr", HDR_FLAT, "-+", 1);
    add_hdr(&maker, "old-runs.hdr", HDR_OLD_RUNS, "-+", 1);
    add_hdr(&maker, "new-runs.hdr", HDR_NEW_RUNS, "-+", 1);
    add_hdr(&maker, "turned.hdr", HDR_NEW_RUNS, "+-", 0.25);
    static const struct {
        const char *name;
        exr_compression_t compression;
        double tolerance;
    } schemes[] = {
        {"none.exr", EXR_COMPRESSION_NONE, 0},   {"rle.exr", EXR_COMPRESSION_RLE, 0},
        {"zips.exr", EXR_COMPRESSION_ZIPS, 0},   {"zip.exr", EXR_COMPRESSION_ZIP, 0},
        {"piz.exr", EXR_COMPRESSION_PIZ, 0},     {"pxr24.exr", EXR_COMPRESSION_PXR24, 0},
        {"b44.exr", EXR_COMPRESSION_B44, 0.5},   {"b44a.exr", EXR_COMPRESSION_B44A, 0.5},
        {"dwaa.exr", EXR_COMPRESSION_DWAA, 0.5}, {"dwab.exr", EXR_COMPRESSION_DWAB, 0.5},
    };
    for (uint32_t i = 0; i < COUNT_OF(schemes); i++)
        add_exr(&maker, schemes[i].name,
                (struct exr_kind){.compression = schemes[i].compression,
                                  .type = EXR_PIXEL_HALF,
                                  .channels = "ABGR",
                                  .tolerance = schemes[i].tolerance});
    struct exr_kind kind = {.compression = EXR_COMPRESSION_ZIP, .type = EXR_PIXEL_FLOAT, .channels = "BGR"};
    add_exr(&maker, "float.exr", kind);
    kind.left = -100;
    kind.top = 37;
    add_exr(&maker, "offset.exr", kind);
    kind.tile = 16;
    add_exr(&maker, "tiled-offset.exr", kind);
    kind = (struct exr_kind){.compression = EXR_COMPRESSION_ZIP, .type = EXR_PIXEL_HALF, .channels = "BGR", .tile = 16};
    add_exr(&maker, "half-tiled.exr", kind);
    kind = (struct exr_kind){.compression = EXR_COMPRESSION_ZIPS, .type = EXR_PIXEL_UINT, .channels = "BGR"};
    add_exr(&maker, "uint.exr", kind);
    kind = (struct exr_kind){.compression = EXR_COMPRESSION_PIZ, .type = EXR_PIXEL_HALF, .channels = "Y", .tile = 8};
    add_exr(&maker, "grey-tiled.exr", kind);
    kind =
        (struct exr_kind){.compression = EXR_COMPRESSION_RLE, .type = EXR_PIXEL_FLOAT, .channels = "RXZ", .multipart = true};
    add_exr(&maker, "multipart.exr", kind);
    kind = (struct exr_kind){.compression = EXR_COMPRESSION_ZIPS, .type = EXR_PIXEL_FLOAT, .channels = "BGR", .deep = true};
    add_exr(&maker, "deep.exr", kind);
    return maker.count;
}

void image_samples_free(struct image_sample *samples, uint32_t count) {
    for (uint32_t i = 0; i < count; i++) {
        free(samples[i].bytes);
        free(samples[i].expected.pixels);
    }
}
