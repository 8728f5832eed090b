/* SPDX-License-Identifier: MIT */
/** Pictures and cube maps with mips, as GPUs hold them: in memory, and as DDS and KTX2 files. */
#ifndef FNL_IMAGE_TEXTURE_H
#define FNL_IMAGE_TEXTURE_H

#include "base/base.h"

enum texture_format {
    TEXTURE_BC6H,
    TEXTURE_BC6H_SIGNED,
    TEXTURE_RGBA16F,
    TEXTURE_RGBA32F,
    TEXTURE_BYTES, /* from here on formats of 8 bits a channel, which are read, not written */
    TEXTURE_R8 = TEXTURE_BYTES,
    TEXTURE_RG8,
    TEXTURE_RGBA8,
    TEXTURE_BGRA8,
    TEXTURE_BC1,       /* opaque */
    TEXTURE_BC1_ALPHA, /* … or clear */
    TEXTURE_BC3,
    TEXTURE_BC4,
    TEXTURE_BC5,
    TEXTURE_BC7,
    TEXTURE_UASTC,
    TEXTURE_FORMATS
};

/** How a file says that its colours are stored. */
enum texture_transfer { TEXTURE_TRANSFER_UNKNOWN, TEXTURE_LINEAR, TEXTURE_SRGB };

enum { TEXTURE_MIPS_MAX = 16 };

/** `bytes` holds mip after mip, in each of them face after face (+X -X +Y -Y +Z -Z), tightly packed; the host's memory. */
struct texture {
    enum texture_format format;
    uint32_t width, height, faces, mips; /* faces: 1, or 6 of a cube map */
    enum texture_transfer transfer;
    unsigned char *bytes;
};

/** Texels of a side of a mip. */
static inline uint32_t texture_side(uint32_t side, uint32_t mip) { return MAX(side >> mip, 1u); }
/** Floats, of high dynamic range. */
static inline bool texture_is_float(enum texture_format format) { return format < TEXTURE_BYTES; }
/** How many mips there can be. */
uint32_t texture_mips(uint32_t width, uint32_t height);
/** Of one face of a mip. */
size_t texture_face_bytes(const struct texture *texture, uint32_t mip);
/** Where a face begins in `bytes`; mip `mips`, face 0: the size of all. */
size_t texture_offset(const struct texture *texture, uint32_t mip, uint32_t face);

/** Zeroed bytes for what the other members say. */
fnl_result texture_allocate(const fnl_host *host, struct texture *texture);
void texture_free(const fnl_host *host, struct texture *texture);

/** Logs what is wrong with a file, with its name. `name` stands for the file in messages. ETC1S comes as RGBA8. */
fnl_result texture_read(const fnl_host *host, const void *bytes, size_t size, const char *name, struct texture *out);
fnl_result texture_load(const fnl_host *host, const char *path, struct texture *out);
struct texture_use {
    bool mips;     /* all of them down to 1 x 1, if the file has all; else one */
    bool normals;  /* of two channels (RG8, BC5) blue becomes the z of the normal */
    uint32_t keep; /* bit 1 << format: formats of blocks that may stay as they are, where the file has all mips; BC7: UASTC and ETC1S become that */
};
/** A picture of any kind of file as materials use it, RGBA8. Those of floats and cube maps are refused. Logs as image_decode() does. Thread-safe. */
fnl_result texture_decode(const fnl_host *host, const void *bytes, size_t size, const char *name, const struct texture_use *use, struct texture *out);

/** The greatest mip of a texture of 8 bits a channel as RGBA8. */
fnl_result texture_unpack(const fnl_host *host, const struct texture *texture, struct texture *out);
/** The blue of all texels of all its mips, or -1 where it varies. */
int16_t texture_common_blue(const struct texture *texture);

/** The extension picks the format: .dds or .ktx2. BC6H alone. The file appears complete or not at all. */
fnl_result texture_save(const fnl_host *host, const char *path, const struct texture *texture);

#endif
