/* SPDX-License-Identifier: MIT */
/**
 * BC6H: 4 x 4 texels of high dynamic range in 16 bytes (Vulkan's "BC6H", the Khronos Data Format Specification 1.3, chapter 20.2). The decoder
 * knows all 14 modes. The encoder is Narkowicz's, "Real-Time BC6H Compression on GPU", GPU Pro 7, V.2, with his later quality mode; a slow search
 * is there to judge them by. src/passes/compress has the same encoders for the GPU.
 *
 * Codes: a value's half as a whole number, with a sign (-0x7bff .. 0x7bff). They rise about as the logarithm of the value, and BC6H interpolates
 * them, not the values.
 */
#ifndef FNL_IMAGE_BC6H_H
#define FNL_IMAGE_BC6H_H

#include "base/base.h"

struct jobs;

enum { BC6H_MODES = 14, BC6H_PATTERNS = 32, BC6H_CODE_MAX = 0x7bff, BC6H_BLOCK_BYTES = 16 };

/** Bit i of a block is bit i % 32 of word i / 32; in files the words are little endian. */
struct bc6h_block {
    uint32_t words[4];
};

/** What the bits of a block say. */
struct bc6h_fields {
    uint32_t mode;           /* 1 .. 14; 0: one of the reserved modes */
    int32_t endpoints[4][3]; /* w x y z: those of region 0, then of region 1; as stored: in delta modes the last three are differences to the first */
    uint32_t pattern;        /* modes 1 .. 10 */
    uint8_t indices[16];
};
/** Of a mode 1 .. 14. */
struct bc6h_mode {
    uint8_t header_bits, header;
    uint8_t bits;     /* of an endpoint */
    uint8_t delta[3]; /* bits of a difference, by channel; 0: endpoints are stored as they are */
};
struct bc6h_mode bc6h_mode(uint32_t mode);
/** Bit i: texel i is in region 1. */
uint32_t bc6h_pattern(uint32_t pattern);
/** The texel of region 1 whose index has one bit less, as texel 0 has in region 0: its highest bit must be 0. */
uint32_t bc6h_anchor(uint32_t pattern);

struct bc6h_fields bc6h_unpack(const struct bc6h_block *block);
/** Bits that do not fit in their field are left off. */
struct bc6h_block bc6h_pack(const struct bc6h_fields *fields);

/** The codes of the texels, row by row; all 0 for reserved modes. */
void bc6h_decode_codes(const struct bc6h_fields *fields, bool is_signed, int32_t codes[16][3]);
/** The same as halves. */
void bc6h_decode(const struct bc6h_block *block, bool is_signed, uint16_t halves[16][3]);

/** The nearest finite code; NaN is 0, and so is what is negative unless `is_signed`. */
int32_t bc6h_code(float value, bool is_signed);
/** What a value becomes before: finite, and not negative unless `is_signed`. */
float bc6h_limit(float value, bool is_signed);
float bc6h_value(int32_t code);
/** The endpoint of so many bits into whose step a code falls, and the number that the decoder interpolates for an endpoint. */
int32_t bc6h_quantise(int32_t code, uint32_t bits, bool is_signed);
int32_t bc6h_unquantise(int32_t endpoint, uint32_t bits, bool is_signed);
/** The decoder's last step: the code of an interpolated number. */
int32_t bc6h_finish(int32_t number, bool is_signed);

enum bc6h_quality {
    BC6H_FAST,    /* mode 11 */
    BC6H_QUALITY, /* 2, 6, 10 .. 14: the one of least error of the codes; never more than that of BC6H_FAST */
    BC6H_BEST,    /* a slow search over all modes */
};
enum bc6h_inset {
    BC6H_INSET_REFINED, /* to the next colour, by a 16th of the box at most */
    BC6H_INSET_FIXED,   /* by a 16th of the box */
    BC6H_INSET_NONE,
};
struct bc6h_params {
    enum bc6h_quality quality;
    bool is_signed;
    /* The rest is for comparisons: */
    enum bc6h_inset inset; /* of the box of colours, on each side */
    bool exhaustive;       /* mode 11 takes for each texel the index of least error of the values */
    bool linear;           /* BC6H_BEST: least squared error of the values, not of the codes */
    uint32_t modes;        /* BC6H_QUALITY and BC6H_BEST: bit m allows mode m; 0 (default): all. Mode 11 is always allowed */
};
struct bc6h_block bc6h_encode(const struct bc6h_params *params, const float texels[16][3]);

/** Pixels of `channels` (3 or 4) floats; blocks that reach over the edge repeat the last column and row. `blocks`: bc6h_block_count of them. */
struct bc6h_picture {
    const float *pixels;
    uint32_t width, height, channels;
};
static inline size_t bc6h_block_count(uint32_t width, uint32_t height) {
    return (size_t)DIVIDE_UP(width, 4u) * DIVIDE_UP(height, 4u);
}
/** `jobs` NULL: on this thread. */
void bc6h_encode_picture(struct jobs *jobs, const struct bc6h_params *params, const struct bc6h_picture *picture, struct bc6h_block *blocks);
/** To RGBA floats, alpha 1. `blocks` may stand anywhere in a file. */
void bc6h_decode_picture(const void *blocks, bool is_signed, uint32_t width, uint32_t height, float *rgba);
/** Texels of a picture that a block holds, edges repeated. */
void bc6h_fetch(const struct bc6h_picture *picture, uint32_t block_x, uint32_t block_y, float texels[16][3]);

/** Of pictures of one size, over R, G and B: root of the mean squared difference of the values, and of log(value + 1) (of negative values,
    -log(1 - value)). */
struct bc6h_error {
    double rmse, rmsle;
};
struct bc6h_error bc6h_compare(const struct bc6h_picture *a, const struct bc6h_picture *b);

#endif
