/* SPDX-License-Identifier: MIT */
/**
 * Deferred shading for tile-based GPUs (Smith and Einig 2016, "Physically Based Deferred Shading on Mobile", GPU Pro 7): G-buffer, lights,
 * blended surfaces and tone mapping are passes of one scope (graph.h), so that a tile's G-buffer and its light never leave the chip and
 * only the picture is stored. Where the device cannot merge them, or `separate` asks for it, they are passes of their own with the same
 * formats and the same pixels.
 *
 * Memory traffic of a pixel, metallic 128 bits: merged, 4 bytes written and none read; separate, 28 written and 28 read (mobile.md).
 */
#ifndef FNL_PASSES_MOBILE_H
#define FNL_PASSES_MOBILE_H

#include "fanal/renderer.h"
#include "passes/post/post.h"
#include "passes/shade/volumes.h"

enum { MOBILE_TARGETS = 8 }; /* at most */

/** What a layout keeps at a pixel. */
struct mobile_target {
    const char *name;
    VkFormat format;
    uint32_t bits, used_bits;
};
struct mobile_layout {
    struct mobile_target targets[MOBILE_TARGETS];
    uint32_t target_count;
    uint32_t lights[2], light_count; /* the targets that hold light */
    int32_t normal;                  /* the RGBA8 UNORM target of normal and roughness, or -1 */
    bool wide;                       /* positions are kept, and light in halves */
};
/** `float_light` and `gamma` decide formats. */
struct mobile_layout mobile_layout(fnl_mobile_layout layout, fnl_mobile_gamma gamma, bool float_light);

/** What the accumulator holds of radiance 1, and the most that it holds: light_scale and light_max of the view. */
struct mobile_scale {
    float scale, most;
};

struct mobile_params {
    fnl_mobile_layout layout;
    fnl_mobile_gamma gamma;
    bool float_light;    /* 128 and 160 bits: light as B10G11R11 floats instead of 10-bit fractions */
    bool separate;       /* not merged, whatever the device can do */
    bool recycle;        /* 128 and 160 bits: the picture takes the place of the normals; the target must be RGBA8 UNORM */
    VkFormat sum_format; /* of lights as volumes: volumes_format() */
    struct mobile_scale scale;
};

/** For pictures of `factor` times radiance; fractions hold up to `range` of that. */
struct mobile_scale mobile_scale(const struct mobile_params *params, float factor, float range);

/** True where the formats can be drawn to; `float_light` is taken back where only that one lacks. */
bool mobile_supported(const gpu_device *device, const struct mobile_params *params);

/** Boxes and volumes that are applied to the targets, in a step of their own. */
struct mobile_decals {
    const struct light_list *list; /* of clusters; the view has the address of the set */
    graph_buffer decals;
};

/** Blended surfaces. */
struct mobile_blend {
    const struct shade_input *input; /* with the lists for them */
    bool weighted, half;             /* as weighted_add() puts them together; else back to front */
};

/** Where it ends. */
struct mobile_finish {
    graph_image target; /* attachment of the frame's size; id 0: what mobile_add makes of `format` */
    VkFormat format;
    bool picture; /* tone-mapped as `tonemap` says (its exposure buffer is not heeded); else radiance */
    struct tonemap_params tonemap;
};

struct mobile_result {
    graph_image target;
    bool merged;
    uint32_t bits;                       /* of a pixel's targets */
    graph_image targets[MOBILE_TARGETS]; /* as the layout has them, in the end; whoever uses them has them stored */
    uint32_t target_count;
};

/**
 * Declares the whole scope. `blend` NULL: they are not drawn here. The view has params->scale. With `prepass`, `depth` is complete.
 * `decals` may be NULL. `volumes`: local lights are drawn, into a sum of volumes_format() in a target of its own, and added to the light once;
 * input->lights are directional ones alone, or NULL. `volumes` NULL: all lights are those of input->lights.
 */
struct mobile_result mobile_add(struct graph *graph, const struct shade_input *input, const struct mobile_blend *blend,
                                const struct volumes *volumes, bool prepass, graph_image depth,
                                const struct mobile_params *params, const struct mobile_decals *decals,
                                const struct mobile_finish *finish);

#endif
