/* SPDX-License-Identifier: MIT */
#include "image/blocks.h"

uint32_t block_bytes(enum texture_format format) {
    switch (format) {
    case TEXTURE_BC1:
    case TEXTURE_BC1_ALPHA:
    case TEXTURE_BC4:
        return 8;
    case TEXTURE_BC6H:
    case TEXTURE_BC6H_SIGNED:
    case TEXTURE_BC3:
    case TEXTURE_BC5:
    case TEXTURE_BC7:
    case TEXTURE_UASTC:
        return 16;
    default:
        return 0;
    }
}

static uint32_t little16(const unsigned char *bytes) { return bytes[0] | (uint32_t)bytes[1] << 8; }

/* Numbers of 5 and 6 bits as 8: their high bits follow below. */
static void unpack_565(uint32_t packed, uint8_t out[3]) {
    uint32_t r = packed >> 11, g = packed >> 5 & 63, b = packed & 31;
    out[0] = (uint8_t)(r << 3 | r >> 2);
    out[1] = (uint8_t)(g << 2 | g >> 4);
    out[2] = (uint8_t)(b << 3 | b >> 2);
}

/* `four`: whatever the order of the ends, there are four colours (BC3); `clear`: the fourth of three is transparent (BC1 with alpha). */
static void decode_color(const unsigned char *block, bool four, bool clear, uint8_t texels[16][4]) {
    uint32_t first = little16(block), second = little16(block + 2), indices = little16(block + 4) | little16(block + 6) << 16;
    uint8_t colors[4][4] = {{0, 0, 0, 255}, {0, 0, 0, 255}, {0, 0, 0, 255}, {0, 0, 0, 255}};
    unpack_565(first, colors[0]);
    unpack_565(second, colors[1]);
    for (int c = 0; c < 3; c++) {
        uint32_t a = colors[0][c], b = colors[1][c];
        colors[2][c] = (uint8_t)(four || first > second ? (2 * a + b + 1) / 3 : (a + b + 1) / 2);
        colors[3][c] = (uint8_t)(four || first > second ? (a + 2 * b + 1) / 3 : 0);
    }
    if (clear && !four && first <= second) colors[3][3] = 0;
    for (int i = 0; i < 16; i++) memcpy(texels[i], colors[indices >> 2 * i & 3], 4);
}

/* One channel: two ends and what lies between them, or also 0 and 255. */
static void decode_channel(const unsigned char *block, int channel, uint8_t texels[16][4]) {
    uint32_t a = block[0], b = block[1], steps = a > b ? 7 : 5;
    uint8_t values[8] = {(uint8_t)a, (uint8_t)b, 0, 0, 0, 0, 0, 255};
    for (uint32_t i = 1; i < steps; i++) values[i + 1] = (uint8_t)(((steps - i) * a + i * b + steps / 2) / steps);
    uint64_t indices = 0;
    for (int i = 7; i >= 2; i--) indices = indices << 8 | block[i];
    for (int i = 0; i < 16; i++) texels[i][channel] = values[indices >> 3 * i & 7];
}

bool block_decode(enum texture_format format, const unsigned char *block, uint8_t texels[16][4]) {
    switch (format) {
    case TEXTURE_BC1:
    case TEXTURE_BC1_ALPHA:
        decode_color(block, false, format == TEXTURE_BC1_ALPHA, texels);
        return true;
    case TEXTURE_BC3:
        decode_color(block + 8, true, false, texels);
        decode_channel(block, 3, texels);
        return true;
    case TEXTURE_BC4:
    case TEXTURE_BC5:
        for (int i = 0; i < 16; i++) memcpy(texels[i], (const uint8_t[4]){0, 0, 0, 255}, 4);
        decode_channel(block, 0, texels);
        if (format == TEXTURE_BC5) decode_channel(block + 8, 1, texels);
        return true;
    case TEXTURE_BC7:
        bc7_decode(block, texels);
        return true;
    case TEXTURE_UASTC:
        return uastc_decode(block, texels, NULL);
    default:
        return false;
    }
}
