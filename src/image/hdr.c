/* SPDX-License-Identifier: MIT */
/*
 * Radiance pictures in RGBE: Ward, "Real Pixels", Graphics Gems II, 1991, and the Radiance file format manual. A
 * mantissa m stands for m / 256 (without the half that Radiance adds), as in Walter's RGBE routines of 1995, so that
 * values written and read again stay as they are.
 */
#include "image/codec.h"

#include <float.h>
#include <math.h>

#define RGBE_BIAS 128
#define RUN_MIN 4 /* shorter runs are written as they are */

struct header {
    uint32_t width, height;
    bool bottom_up, right_to_left;
    float scale[3]; /* what the stored values are multiplied by to give radiance */
    enum primaries primaries;
    float to_rec709[9];
    const unsigned char *pixels;
};

bool image_is_hdr(const void *bytes, size_t size) {
    return (size >= 10 && memcmp(bytes, "#?RADIANCE", 10) == 0) || (size >= 6 && memcmp(bytes, "#?RGBE", 6) == 0);
}

/* Copies the next line, cut to the capacity; NULL at the end of the file. */
static const unsigned char *read_line(const unsigned char *at, const unsigned char *end, char *line, size_t capacity) {
    const unsigned char *stop = at < end ? memchr(at, '\n', (size_t)(end - at)) : NULL;
    if (!stop) return NULL;
    size_t length = MIN((size_t)(stop - at), capacity - 1);
    memcpy(line, at, length);
    line[length] = 0;
    if (length && line[length - 1] == '\r') line[length - 1] = 0;
    return stop + 1;
}

/* False: there are fewer numbers in the line, or something else. */
static bool read_numbers(const char *text, float *values, int count) {
    for (int i = 0; i < count; i++) {
        char *rest;
        values[i] = (float)number_read(text, &rest);
        if (rest == text) return false;
        text = rest;
    }
    return text[strspn(text, " \t")] == 0;
}

/* EXPOSURE and COLORCORR say by what the pixels have been multiplied; several of them add up. */
static fnl_result read_variable(const struct image_source *source, const char *line, struct header *header) {
    if (strncmp(line, "FORMAT=", 7) == 0 && strcmp(line + 7, "32-bit_rle_rgbe") != 0)
        return image_fail(source, FNL_ERROR_UNSUPPORTED, "Radiance HDR of format '%.40s' (only 32-bit_rle_rgbe is read)",
                          line + 7);
    if (strncmp(line, "PRIMARIES=", 10) == 0) {
        float values[8];
        header->primaries = read_numbers(line + 10, values, 8) ? primaries_matrix(values, header->to_rec709) : PRIMARIES_BAD;
        return header->primaries != PRIMARIES_BAD ? FNL_OK : image_fail(source, FNL_ERROR_FORMAT, "broken Radiance HDR: '%.90s' is not usable", line);
    }
    bool exposure = strncmp(line, "EXPOSURE=", 9) == 0, correction = strncmp(line, "COLORCORR=", 10) == 0;
    if (!exposure && !correction) return FNL_OK;
    float factors[3];
    bool usable = exposure ? read_numbers(line + 9, factors, 1) : read_numbers(line + 10, factors, 3);
    for (int c = 0; c < 3 && usable; c++) {
        header->scale[c] /= factors[exposure ? 0 : c];
        usable = isfinite(header->scale[c]) && header->scale[c] > 0;
    }
    return usable ? FNL_OK : image_fail(source, FNL_ERROR_FORMAT, "broken Radiance HDR: '%.60s' is not usable", line);
}

static fnl_result read_header(const struct image_source *source, struct header *out) {
    *out = (struct header){.scale = {1, 1, 1}};
    const unsigned char *at = source->bytes, *end = source->bytes + source->size;
    char line[256];
    do {
        at = read_line(at, end, line, sizeof line);
        if (!at) return image_fail(source, FNL_ERROR_FORMAT, "broken Radiance HDR: the header is cut off");
        TRY(read_variable(source, line, out));
    } while (line[0]);
    at = read_line(at, end, line, sizeof line);
    if (!at) return image_fail(source, FNL_ERROR_FORMAT, "broken Radiance HDR: the header is cut off");
    char y_sign, x_sign, y_axis, x_axis, rest, high[10], wide[10]; /* digits alone: %llu takes signs too */
    if (sscanf(line, "%c%c %9[0-9] %c%c %9[0-9] %c", &y_sign, &y_axis, high, &x_sign, &x_axis, wide, &rest) != 6 ||
        !strchr("+-", y_sign) || !strchr("+-", x_sign))
        return image_fail(source, FNL_ERROR_FORMAT, "broken Radiance HDR: '%.60s' is not a resolution", line);
    if (y_axis != 'Y' || x_axis != 'X')
        return image_fail(source, FNL_ERROR_UNSUPPORTED, "Radiance HDR stored by columns ('%.60s')", line);
    const unsigned long long height = strtoull(high, NULL, 10), width = strtoull(wide, NULL, 10);
    TRY(image_check_size(source, width, height));
    out->width = (uint32_t)width;
    out->height = (uint32_t)height;
    out->bottom_up = y_sign == '+';
    out->right_to_left = x_sign == '-';
    out->pixels = at;
    return FNL_OK;
}

fnl_result image_hdr_peek(const struct image_source *source, struct image_file_info *out) {
    struct header header;
    TRY(read_header(source, &header));
    *out = (struct image_file_info){.kind = IMAGE_FILE_HDR, .width = header.width, .height = header.height, .pixel_bytes = 16};
    return FNL_OK;
}

/* Since 1991: the four components one after the other, each in runs. */
static const unsigned char *read_component_runs(const unsigned char *at, const unsigned char *end, uint32_t width,
                                                unsigned char *rgbe) {
    for (uint32_t c = 0; c < 4; c++) {
        for (uint32_t x = 0; x < width;) {
            if (end - at < 2) return NULL;
            uint32_t count = *at++;
            bool run = count > 128;
            if (run) count -= 128;
            if (count == 0 || count > width - x || (!run && (size_t)(end - at) < count)) return NULL;
            for (uint32_t i = 0; i < count; i++, x++) rgbe[x * 4 + c] = run ? *at : at[i];
            at += run ? 1 : count;
        }
    }
    return at;
}

/* Before: whole pixels; 1, 1, 1, n repeats the pixel before n times, times 256 for each such mark directly before. */
static const unsigned char *read_pixel_runs(const unsigned char *at, const unsigned char *end, uint32_t width,
                                            unsigned char *rgbe) {
    uint32_t shift = 0;
    for (uint32_t x = 0; x < width; at += 4) {
        if (end - at < 4) return NULL;
        if (at[0] == 1 && at[1] == 1 && at[2] == 1) {
            if (x == 0 || shift > 16) return NULL;
            uint32_t count = (uint32_t)at[3] << shift;
            if (count > width - x) return NULL;
            for (uint32_t i = 0; i < count; i++, x++) memcpy(rgbe + (size_t)x * 4, rgbe + (size_t)x * 4 - 4, 4);
            shift += 8;
        } else {
            memcpy(rgbe + (size_t)x++ * 4, at, 4);
            shift = 0;
        }
    }
    return at;
}

static const unsigned char *read_scanline(const unsigned char *at, const unsigned char *end, uint32_t width,
                                          unsigned char *rgbe) {
    if (width >= 8 && width <= 0x7fff && end - at >= 4 && at[0] == 2 && at[1] == 2 && at[2] < 128) {
        if (((uint32_t)at[2] << 8 | at[3]) != width) return NULL;
        return read_component_runs(at + 4, end, width, rgbe);
    }
    return read_pixel_runs(at, end, width, rgbe);
}

static void store_row(const struct header *header, const float *powers, const unsigned char *rgbe, float *row) {
    for (uint32_t x = 0; x < header->width; x++, rgbe += 4) {
        float *pixel = row + (size_t)(header->right_to_left ? header->width - 1 - x : x) * 4;
        for (int c = 0; c < 3; c++) pixel[c] = (float)rgbe[c] * powers[rgbe[3]] * header->scale[c];
        pixel[3] = 1;
    }
}

fnl_result image_hdr_decode(const struct image_source *source, fnl_image *out) {
    struct header header;
    TRY(read_header(source, &header));
    const unsigned char *at = header.pixels, *end = source->bytes + source->size;
    /* A row takes at least a pixel and, when it is longer, a repetition. */
    uint64_t rows = (uint64_t)(end - at) / (header.width > 1 ? 8 : 4);
    fnl_image image;
    TRY(image_allocate(source, header.width, header.height, FNL_PIXEL_FORMAT_RGBA32F, rows * header.width, &image));
    size_t row_size = (size_t)header.width * 4;
    unsigned char *rgbe = host_allocate(source->host, row_size);
    fnl_result result = rgbe ? FNL_OK : image_fail(source, FNL_ERROR_MEMORY, "out of memory");
    float powers[256] = {0}; /* exponent 0 is black */
    for (int e = 1; e < 256; e++) powers[e] = ldexpf(1, e - RGBE_BIAS - 8);
    for (uint32_t y = 0; result == FNL_OK && y < header.height; y++) {
        at = read_scanline(at, end, header.width, rgbe);
        if (!at) {
            result = image_fail(source, FNL_ERROR_FORMAT, "broken Radiance HDR: row %u is damaged or cut off", y);
            break;
        }
        uint32_t row = header.bottom_up ? header.height - 1 - y : y;
        store_row(&header, powers, rgbe, (float *)image.pixels + row * row_size);
    }
    host_free(source->host, rgbe, row_size);
    if (result == FNL_OK && header.primaries == PRIMARIES_OTHER) primaries_convert(header.to_rec709, image.pixels, (size_t)image.width * image.height);
    if (result == FNL_OK)
        *out = image;
    else
        fnl_image_free(source->host, &image);
    return result;
}

/* ---- writing ---- */

static float representable(float value) { return value > 0 ? fminf(value, FLT_MAX) : 0; /* NaN too */ }

static void encode_pixel(const float *pixel, unsigned char *rgbe) {
    float value[3] = {representable(pixel[0]), representable(pixel[1]), representable(pixel[2])};
    float greatest = fmaxf(value[0], fmaxf(value[1], value[2]));
    int exponent;
    frexpf(greatest, &exponent); /* greatest < 2^exponent */
    if (rintf(ldexpf(greatest, 8 - exponent)) > 255) exponent++;
    exponent = MIN(exponent, 255 - RGBE_BIAS);
    if (greatest == 0 || exponent + RGBE_BIAS < 1) {
        memset(rgbe, 0, 4);
        return;
    }
    for (int c = 0; c < 3; c++) rgbe[c] = (unsigned char)fminf(rintf(ldexpf(value[c], 8 - exponent)), 255);
    rgbe[3] = (unsigned char)(exponent + RGBE_BIAS);
}

static uint32_t run_length(const unsigned char *rgbe, uint32_t x, uint32_t width) {
    uint32_t length = 1;
    while (x + length < width && length < 127 && rgbe[(size_t)(x + length) * 4] == rgbe[(size_t)x * 4]) length++;
    return length;
}

static void write_component(FILE *stream, const unsigned char *rgbe, uint32_t width) {
    for (uint32_t x = 0; x < width;) {
        uint32_t run = run_length(rgbe, x, width);
        if (run >= RUN_MIN) {
            putc((int)(128 + run), stream);
            putc(rgbe[(size_t)x * 4], stream);
            x += run;
            continue;
        }
        uint32_t end = x;
        while (end < width && end - x < 128 && run_length(rgbe, end, width) < RUN_MIN) end++;
        putc((int)(end - x), stream);
        for (; x < end; x++) putc(rgbe[(size_t)x * 4], stream);
    }
}

fnl_result image_hdr_write(struct file_writer *writer, const fnl_image *image) {
    size_t row_size = (size_t)image->width * 4;
    unsigned char *rgbe = host_allocate(&writer->host, row_size);
    if (!rgbe) return FNL_ERROR_MEMORY;
    FILE *stream = writer->stream;
    fprintf(stream, "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %u +X %u\n", image->height, image->width);
    for (uint32_t y = 0; y < image->height; y++) {
        const float *row = (const float *)image->pixels + (size_t)y * image->width * 4;
        for (uint32_t x = 0; x < image->width; x++) encode_pixel(row + (size_t)x * 4, rgbe + (size_t)x * 4);
        if (image->width < 8 || image->width > 0x7fff) {
            /* Flat: the greatest mantissa is at least 128, so that no pixel looks like a mark. */
            fwrite(rgbe, 1, row_size, stream);
            continue;
        }
        const unsigned char mark[4] = {2, 2, (unsigned char)(image->width >> 8), (unsigned char)(image->width & 255)};
        fwrite(mark, 1, 4, stream);
        for (uint32_t c = 0; c < 4; c++) write_component(stream, rgbe + c, image->width);
    }
    host_free(&writer->host, rgbe, row_size);
    return FNL_OK;
}
