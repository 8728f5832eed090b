/* SPDX-License-Identifier: MIT */
/* Textures and panoramas from noise, and two encoders that share no code with those of the library. */
#include "base/maths.h"
#include "tests/stand_in.h"

#include <stdlib.h>
#include <string.h>

/* ---- noise ---- */

static float lattice(uint32_t x, uint32_t y, uint32_t seed) {
    uint32_t h = x * 0x9e3779b1u ^ y * 0x85ebca77u ^ seed * 0xc2b2ae3du;
    h = (h ^ h >> 15) * 0x2c1b3c6du;
    h = (h ^ h >> 12) * 0x297a2d39u;
    return (float)((h ^ h >> 15) >> 8) / 16777216;
}

/** Smooth noise, 0 .. 1, that repeats after `period` cells in x; `x` and `y` in cells, not negative. */
static float noise(float x, float y, uint32_t period, uint32_t seed) {
    const uint32_t i = (uint32_t)x, j = (uint32_t)y;
    float u = x - (float)i, v = y - (float)j;
    u *= u * (3 - 2 * u), v *= v * (3 - 2 * v);
    const uint32_t left = i % period, right = (i + 1) % period;
    const float top = lattice(left, j, seed) * (1 - u) + lattice(right, j, seed) * u, low = lattice(left, j + 1, seed) * (1 - u) + lattice(right, j + 1, seed) * u;
    return top * (1 - v) + low * v;
}

/** Four octaves; 0 .. 1. */
static float rough(float u, float v, uint32_t cells, uint32_t seed) {
    float sum = 0, part = 0.5f;
    for (uint32_t i = 0; i < 4; i++, cells *= 2, part *= 0.5f) sum += part * noise(u * (float)cells, v * (float)cells, cells, seed + i);
    return sum / 0.9375f;
}

/* ---- textures ---- */

static void texel(enum stand_in_texture texture, float u, float v, float step, uint32_t seed, float out[4]) {
    static const float cloths[][3] = {{0.78f, 0.72f, 0.62f}, {0.68f, 0.74f, 0.80f}, {0.76f, 0.62f, 0.52f}, {0.70f, 0.76f, 0.62f}, {0.80f, 0.70f, 0.74f}};
    const float stain = rough(u, v, 6, seed);
    float blot = 0;
    out[0] = out[1] = out[2] = 0, out[3] = 1;
    switch (texture) {
    case STAND_IN_COLOR:
    case STAND_IN_CLEAR:
    case STAND_IN_HOLES:
        for (int c = 0; c < 3; c++) {
            const float cloth = cloths[seed % COUNT_OF(cloths)][c];
            out[c] = (((int)(u * 8) + (int)(v * 8)) % 2 ? cloth : 0.75f * cloth) * (0.8f + 0.4f * stain);
        }
        if (texture == STAND_IN_CLEAR) out[3] = 0.2f + 0.2f * stain;
        if (texture == STAND_IN_HOLES) out[3] = fmaxf(0, 1 - 4 * ((u - 0.5f) * (u - 0.5f) + (v - 0.5f) * (v - 0.5f)));
        break;
    case STAND_IN_NORMAL: {
        const vec3 n = vec3_normalize((vec3){0.05f / step * (stain - rough(u + step, v, 6, seed)), 0.05f / step * (rough(u, v + step, 6, seed) - stain), 1});
        out[0] = 0.5f + 0.5f * n.x, out[1] = 0.5f + 0.5f * n.y, out[2] = 0.5f + 0.5f * n.z;
        break;
    }
    case STAND_IN_SURFACE:
        out[0] = 0.7f + 0.3f * stain;
        out[1] = 0.35f + 0.5f * rough(u, v, 4, seed + 17);
        out[2] = fminf(1, fmaxf(0, 8 * rough(u, v, 3, seed + 31) - 4.6f));
        break;
    case STAND_IN_GLOW:
        blot = fmaxf(0, 1 - 25 * ((u * 4 - floorf(u * 4) - 0.5f) * (u * 4 - floorf(u * 4) - 0.5f) + (v * 4 - floorf(v * 4) - 0.5f) * (v * 4 - floorf(v * 4) - 0.5f)));
        if (lattice((uint32_t)(u * 4), (uint32_t)(v * 4), seed) > 0.6f) out[0] = 0.4f * blot, out[1] = 0.6f * blot, out[2] = 0.9f * blot;
        break;
    case STAND_IN_DIRECTIONS: {
        const float angle = 6.2831853f * v;
        out[0] = 0.5f + 0.5f * cosf(angle), out[1] = 0.5f + 0.5f * sinf(angle), out[2] = 0.5f + 0.5f * stain;
        break;
    }
    }
}

fnl_image stand_in_picture(enum stand_in_texture texture, uint32_t side, uint32_t seed) {
    const fnl_image image = {side, side, FNL_PIXEL_FORMAT_RGBA8, malloc((size_t)side * side * 4)};
    const float step = 1 / (float)side;
    for (uint32_t y = 0; y < side; y++)
        for (uint32_t x = 0; x < side; x++) {
            float value[4];
            texel(texture, ((float)x + 0.5f) * step, ((float)y + 0.5f) * step, step, seed, value);
            for (uint32_t c = 0; c < 4; c++) ((uint8_t *)image.pixels)[4 * ((size_t)y * side + x) + c] = (uint8_t)(fminf(1, fmaxf(0, value[c])) * 255 + 0.5f);
        }
    return image;
}

/* ---- panoramas ---- */

struct lamp {
    float azimuth, elevation, radius, radiance; /* parts of a turn; radius in radians */
};

struct panorama {
    const char *name;
    uint32_t width;
    float zenith[3], horizon[3], ground[3], grain; /* grain: the part of the radiance that is noise */
    struct lamp lamps[6];
};

static const struct panorama panoramas[] = {
    {"peppermint_powerplant_1k.hdr", 1024, {0.25f, 0.24f, 0.22f}, {0.5f, 0.52f, 0.55f}, {0.22f, 0.2f, 0.17f}, 0.8f, {{0.1f, 0.14f, 0.05f, 60}, {0.3f, 0.13f, 0.06f, 40}, {0.62f, 0.15f, 0.05f, 50}, {0.8f, 0.12f, 0.04f, 80}, {0.5f, 0.04f, 0.06f, 4}}},
    {"spiaggia_di_mondello_1k.hdr", 1024, {0.35f, 0.6f, 1.1f}, {0.9f, 0.95f, 1}, {0.45f, 0.38f, 0.28f}, 0.5f, {{0.35f, 0.14f, 0.012f, 20000}}},
    {"venice_sunset_256.hdr", 256, {0.25f, 0.35f, 0.6f}, {1.1f, 0.8f, 0.5f}, {0.2f, 0.17f, 0.16f}, 0.6f, {{0.2f, 0.02f, 0.1f, 5}}},
};

static void sky(const struct panorama *p, float u, float v, float out[3]) {
    const float up = 1 - 2 * v, haze = 1 - fabsf(up), cloud = rough(u, v, 40, p->width + 3) - 0.5f;
    const float pitch = 1.5707963f * up, turn = 6.2831853f * u;
    const vec3 at = {cosf(pitch) * cosf(turn), sinf(pitch), cosf(pitch) * sinf(turn)};
    for (int c = 0; c < 3; c++) {
        const float far = up > 0 ? p->zenith[c] : p->ground[c], edge = up > 0 ? p->horizon[c] : 0.6f * p->horizon[c] + 0.4f * p->ground[c];
        out[c] = (far + (edge - far) * haze * haze * haze) * (1 + p->grain * (1.5f * cloud + 0.5f * (rough(u, v, 50, 97 * (uint32_t)c + p->width) - 0.5f)));
    }
    for (uint32_t i = 0; i < COUNT_OF(p->lamps) && p->lamps[i].radius > 0; i++) {
        const struct lamp *l = &p->lamps[i];
        const float height = 6.2831853f * l->elevation, place = 6.2831853f * l->azimuth;
        const float off = vec3_distance(at, (vec3){cosf(height) * cosf(place), sinf(height), cosf(height) * sinf(place)}) / l->radius;
        for (int c = 0; c < 3 && off < 4; c++) out[c] += l->radiance * (off < 1 ? 1 : 0.02f * (4 - off) / off) * (1 - 0.12f * (float)c);
    }
}

fnl_image stand_in_panorama(const char *name) {
    const struct panorama *p = NULL;
    for (size_t i = 0; i < COUNT_OF(panoramas); i++)
        if (strcmp(panoramas[i].name, name) == 0) p = &panoramas[i];
    if (!p) fprintf(stderr, "nothing replaces %s\n", name), abort();
    const uint32_t width = p->width, height = width / 2;
    const fnl_image image = {width, height, FNL_PIXEL_FORMAT_RGBA32F, malloc((size_t)width * height * 16)};
    for (uint32_t i = 0; i < width * height; i++) {
        float *pixel = (float *)image.pixels + 4 * (size_t)i;
        sky(p, ((float)(i % width) + 0.5f) / (float)width, ((float)(i / width) + 0.5f) / (float)height, pixel);
        pixel[3] = 1;
    }
    return image;
}

/* ---- PNG ---- */

static void put_big(unsigned char *at, uint32_t value) {
    for (int i = 0; i < 4; i++) at[i] = (unsigned char)(value >> 8 * (3 - i));
}

static unsigned char *put_chunk(unsigned char *at, const char *kind, const void *data, size_t size) {
    uint32_t crc = UINT32_MAX;
    put_big(at, (uint32_t)size);
    memcpy(at + 4, kind, 4);
    if (size) memcpy(at + 8, data, size);
    for (size_t i = 4; i < size + 8; i++) {
        crc ^= at[i];
        for (int bit = 0; bit < 8; bit++) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320 : 0);
    }
    put_big(at + 8 + size, ~crc);
    return at + 12 + size;
}

/** Each row has another filter: none, the pixel to the left, the one above. */
static unsigned char *filtered_rows(const fnl_image *image, uint32_t channels, size_t *size) {
    const size_t row = (size_t)image->width * channels;
    unsigned char *rows = malloc(*size = image->height * (row + 1)), *out = rows;
    for (uint32_t y = 0; y < image->height; y++) {
        *out++ = (unsigned char)(y % 3);
        for (size_t i = 0; i < row; i++) {
            const uint8_t *pixel = (const uint8_t *)image->pixels + 4 * (y * (size_t)image->width + i / channels) + i % channels;
            *out++ = (unsigned char)(*pixel - (y % 3 == 1 && i >= channels ? pixel[-4] : y % 3 == 2 ? pixel[-4 * (ptrdiff_t)image->width] : 0));
        }
    }
    return rows;
}

unsigned char *stand_in_png(const fnl_image *image, size_t *size) {
    const size_t count = (size_t)image->width * image->height;
    const uint8_t *pixels = image->pixels;
    bool opaque = true;
    for (size_t i = 0; i < count; i++) opaque = opaque && pixels[4 * i + 3] == 255;
    size_t rows_size, stored = 2;
    unsigned char *rows = filtered_rows(image, opaque ? 3 : 4, &rows_size), *stream = malloc(rows_size + rows_size / 65535 * 5 + 16);
    stream[0] = 0x78, stream[1] = 1;
    uint32_t a = 1, b = 0;
    for (size_t at = 0; at < rows_size;) {
        const size_t block = MIN(rows_size - at, 65535);
        const unsigned char head[5] = {at + block == rows_size, (unsigned char)block, (unsigned char)(block >> 8), (unsigned char)~block, (unsigned char)(~block >> 8)};
        memcpy(stream + stored, head, 5);
        memcpy(stream + stored + 5, rows + at, block);
        stored += 5 + block;
        at += block;
    }
    for (size_t i = 0; i < rows_size; i++) a = (a + rows[i]) % 65521, b = (b + a) % 65521;
    put_big(stream + stored, b << 16 | a);
    stored += 4;
    unsigned char *file = malloc(8 + 25 + 12 + stored + 12), *end = file + 8, header[13] = {0};
    memcpy(file, "\x89PNG\r\n\x1a\n", 8);
    put_big(header, image->width);
    put_big(header + 4, image->height);
    header[8] = 8, header[9] = opaque ? 2 : 6;
    end = put_chunk(end, "IHDR", header, 13);
    end = put_chunk(end, "IDAT", stream, stored);
    end = put_chunk(end, "IEND", NULL, 0);
    *size = (size_t)(end - file);
    free(rows), free(stream);
    return file;
}

/* ---- Radiance HDR ---- */

unsigned char *stand_in_hdr(const fnl_image *image, size_t *size) {
    const uint32_t width = image->width;
    unsigned char *file = malloc(128 + (size_t)image->height * (4 + 8 * (size_t)width)), *out = file, *row = malloc((size_t)width * 4);
    out += sprintf((char *)out, "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %u +X %u\n", image->height, width);
    for (uint32_t y = 0; y < image->height; y++) {
        const float *pixel = (const float *)image->pixels + (size_t)y * width * 4;
        for (uint32_t x = 0; x < width; x++, pixel += 4) {
            int exponent;
            const float most = fmaxf(pixel[0], fmaxf(pixel[1], pixel[2])), scale = 256 * frexpf(most, &exponent) / most;
            for (int c = 0; c < 3; c++) row[c * (int)width + (int)x] = most < 1e-32f ? 0 : (unsigned char)(pixel[c] * scale);
            row[3 * width + x] = most < 1e-32f ? 0 : (unsigned char)(exponent + 128);
        }
        *out++ = 2, *out++ = 2, *out++ = (unsigned char)(width >> 8), *out++ = (unsigned char)width;
        for (uint32_t c = 0; c < 4; c++)
            for (uint32_t x = 0, run = 1; x < width; x += run, run = 1) {
                const unsigned char *at = row + c * width + x;
                while (x + run < width && run < 127 && at[run] == *at) run++;
                *out++ = (unsigned char)(run > 1 ? 128 + run : 1);
                *out++ = *at;
            }
    }
    free(row);
    *size = (size_t)(out - file);
    return file;
}
