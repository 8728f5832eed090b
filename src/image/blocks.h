/* SPDX-License-Identifier: MIT */
/**
 * Blocks of 4 x 4 texels of 8 bits a channel, decoded to RGBA8: BC1, BC3, BC4, BC5 and BC7 (Khronos Data Format Specification 1.3, chapters 18 to 20)
 * and UASTC (Basis Universal, "UASTC LDR 4x4 Texture Specification"). Channels that a format lacks are 0, alpha 255. Texels go row by row.
 */
#ifndef FNL_IMAGE_BLOCKS_H
#define FNL_IMAGE_BLOCKS_H

#include "image/texture.h"

/** Of a block; 0: the format has none. */
uint32_t block_bytes(enum texture_format format);
/** False: no such block exists, and it is all 0 (UASTC; BC7's reserved mode is a block of zeros). */
bool block_decode(enum texture_format format, const unsigned char *block, uint8_t texels[16][4]);

void bc7_decode(const unsigned char block[16], uint8_t texels[16][4]);

/** How a block is made up: texels of a subset lie on one line; the channel `lone` (0 to 3; 4: none) has indices of its own. */
struct block_structure {
    uint8_t subsets[16], lone;
};
/** `structure` may be NULL. */
bool uastc_decode(const unsigned char block[16], uint8_t texels[16][4], struct block_structure *structure);
/** A block of BC7 with the subsets or the channel of its own that `structure` has, or with one line, by least error. NULL: one line. */
void bc7_encode(const uint8_t texels[16][4], const struct block_structure *structure, unsigned char block[16]);

/** Bits of a block of 16 bytes, from the lowest one on. */
struct block_bits {
    uint64_t low, high;
    uint32_t at;
};
static inline struct block_bits block_bits(const unsigned char block[16]) {
    struct block_bits bits = {0};
    for (int i = 7; i >= 0; i--) {
        bits.low = bits.low << 8 | block[i];
        bits.high = bits.high << 8 | block[i + 8];
    }
    return bits;
}
/** `count`: 0 to 31. */
static inline uint32_t block_take(struct block_bits *bits, uint32_t count) {
    uint64_t from = bits->at >= 64 ? bits->high >> (bits->at - 64) : bits->at == 0 ? bits->low : bits->low >> bits->at | bits->high << (64 - bits->at);
    bits->at += count;
    return (uint32_t)from & ((1u << count) - 1);
}

#endif
