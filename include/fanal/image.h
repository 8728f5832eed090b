/* SPDX-License-Identifier: MIT */
/** Pictures in memory: reading, writing, comparing and compressing them. */
#ifndef FANAL_IMAGE_H
#define FANAL_IMAGE_H

#include "fanal/device.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum fnl_pixel_format {
    FNL_PIXEL_FORMAT_RGBA8 = 0, /**< 4 x uint8_t, 0..255 */
    FNL_PIXEL_FORMAT_RGBA16,    /**< 4 x uint16_t in host byte order, 0..65535 */
    FNL_PIXEL_FORMAT_RGBA32F,   /**< 4 x float */
} fnl_pixel_format;

/** A picture; rows from top to bottom, tightly packed. `pixels` is owned by whoever made the image. */
typedef struct fnl_image {
    uint32_t width, height;
    fnl_pixel_format format;
    void *pixels;
} fnl_image;

/** Bytes of one pixel of a format; 0 for values that are none. */
static inline size_t fnl_pixel_size(fnl_pixel_format format) {
    switch (format) {
    case FNL_PIXEL_FORMAT_RGBA8:
        return 4;
    case FNL_PIXEL_FORMAT_RGBA16:
        return 8;
    case FNL_PIXEL_FORMAT_RGBA32F:
        return 16;
    }
    return 0;
}

/**
 * Reads a PNG (8 or 16 bits), JPEG, WebP, Radiance HDR or OpenEXR file, recognised by its contents. PNG of more than 8
 * bits gives RGBA16; HDR and EXR give RGBA32F (EXR: channels R, G, B, A; a lone Y fills R, G and B; missing alpha is 1, a missing color 0, with a
 * warning). An EXR gives its display window, black and transparent where there is no data. `chromaticities` of EXR and `PRIMARIES` of HDR are converted to
 * Rec. 709, white to D65. EXR with DWAA or DWAB gives FNL_ERROR_UNSUPPORTED if OpenEXR's C library cannot read it (3.1 cannot).
 * DDS and KTX2 files give the greatest mip, those of BC6H or RGBA floats as RGBA32F, of 8 bits a channel (BC1, BC3, BC4, BC5, BC7, ETC1S, UASTC, R8, RG8,
 * RGBA8, BGRA8) as RGBA8; the six faces of a cube map stand one below the other.
 * The pixels come from the host's allocator; free them with fnl_image_free. A picture that needs more than half of the machine's memory gives FNL_ERROR_MEMORY.
 */
FNL_API fnl_result fnl_image_load(const fnl_host *host, const char *path, fnl_image *out);
/** Like fnl_image_load with a limit: a picture whose pixels need more than `max_bytes` is refused before anything is allocated. UINT64_MAX: no limit. */
FNL_API fnl_result fnl_image_load_within(const fnl_host *host, const char *path, uint64_t max_bytes, fnl_image *out);
FNL_API void fnl_image_free(const fnl_host *host, fnl_image *image);

/**
 * Writes a picture; the extension picks the format: .png (RGBA8 or RGBA16), .exr (RGBA32F, 32-bit channels, ZIP) or
 * .hdr (RGBA32F). The file appears complete or not at all.
 */
FNL_API fnl_result fnl_image_save(const fnl_host *host, const char *path, const fnl_image *image);

/** One named plane of a multi-channel EXR file; `stride` is the distance in floats between neighbouring pixels. */
typedef struct fnl_exr_channel {
    const char *name; /**< such as "R" or "normal.X" */
    const float *values;
    uint32_t stride;
} fnl_exr_channel;

/** Writes an OpenEXR file of 32-bit float channels, all of width x height pixels. The names must differ. */
FNL_API fnl_result fnl_exr_save(const fnl_host *host, const char *path, uint32_t width, uint32_t height,
                                const fnl_exr_channel *channels, uint32_t channel_count);

/**
 * How far two pictures of equal size are apart, over R, G, B and A. Integer formats are compared as value / maximum in
 * [0, 1]; floats as they are. A NaN on one side only counts as an infinite difference; equal infinities and NaN on
 * both sides count as equal.
 */
typedef struct fnl_image_difference {
    double max;  /**< largest absolute difference of one channel */
    double mean; /**< mean absolute difference */
    double rmse; /**< root of the mean squared difference */
    /** 20 log10(peak / rmse) in dB, infinite for equal pictures; peak is 1, for floats at least the greatest finite value. */
    double psnr;
    /**
     * Mean structural similarity of luma (Rec. 709 weights), 11x11 Gaussian window, sigma 1.5 (Wang et al. 2004), over the
     * windows that lie in the picture; 1 is equal. Windows with an infinite difference count as 0.
     */
    double ssim;
    uint32_t max_x, max_y; /**< where `max` is found first, in reading order */
    uint64_t differing_pixels;
} fnl_image_difference;

/** FNL_ERROR_INVALID when the sizes differ. Different pixel formats are compared in [0, 1]. */
FNL_API fnl_result fnl_image_compare(const fnl_host *host, const fnl_image *a, const fnl_image *b,
                                     fnl_image_difference *out);

/**
 * A picture of the differences: absolute difference per channel times `gain` (0: scaled so that the greatest is white),
 * opaque RGBA8, free with fnl_image_free. A difference of alpha shows in all three channels; an infinite one is white.
 */
FNL_API fnl_result fnl_image_difference_picture(const fnl_host *host, const fnl_image *a, const fnl_image *b, float gain,
                                                fnl_image *out);

typedef enum fnl_compress_quality {
    FNL_COMPRESS_FAST = 0, /**< one of the format's modes; for what is compressed anew in each frame */
    FNL_COMPRESS_QUALITY,  /**< seven modes; for what a device compresses once */
    FNL_COMPRESS_BEST,     /**< a search through all modes, on the CPU alone, thousands of times slower */
} fnl_compress_quality;

typedef struct fnl_compress_params {
    fnl_compress_quality quality; /**< default FNL_COMPRESS_QUALITY */
    bool is_signed;               /**< keeps negative values, at half the precision; default false: they become 0 */
    bool mips;                    /**< all smaller levels too, each the mean of the one before; default false */
    /**
     * The picture is a panorama as an environment's (fanal/environment.h): twice as wide as high, +Y at the top, +X in the middle, +Z a quarter of the
     * width to the right. Of it a cube map with faces of so many pixels is made, 1 .. 4096, in the order +X -X +Y -Y +Z -Z; 0 (default): it is taken as
     * it is.
     */
    uint32_t cube_size;
    fnl_device *device; /**< compresses; NULL (default): the CPU */
} fnl_compress_params;

static inline fnl_compress_params fnl_compress_params_default(void) {
    fnl_compress_params params = {FNL_COMPRESS_QUALITY, false, false, 0, 0};
    return params;
}

typedef struct fnl_compress_stats {
    double rmse;         /**< root of the mean squared difference to the source over R, G, B, of the greatest mip; the source limited to halves */
    double rmsle;        /**< the same of log(value + 1) */
    double seconds;      /**< of compressing alone; on a device without timers 0 */
    uint64_t pixels;     /**< of all faces and mips */
    uint64_t blocks[15]; /**< by mode, 1 .. 14 */
    uint32_t width, height, faces, mips;
} fnl_compress_stats;

/**
 * Compresses a picture as BC6H: 16 bytes for 4 x 4 pixels of high dynamic range, without alpha, up to 65504. Integer pixels are taken as sRGB. Writes
 * it to `path`, .dds or .ktx2 (NULL: nowhere, for the numbers). `params` NULL: defaults; `stats` may be NULL.
 */
FNL_API fnl_result fnl_image_compress(const fnl_host *host, const char *path, const fnl_image *image, const fnl_compress_params *params,
                                      fnl_compress_stats *stats);

#ifdef __cplusplus
}
#endif
#endif
