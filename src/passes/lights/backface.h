/* SPDX-License-Identifier: MIT */
/**
 * Tiles that drop the lights behind all of their surfaces (Ishmukhametov, "Efficient Tile-Based Deferred Shading Pipeline", DigiPen
 * 2013, chapter 4). Needs a G-buffer's depth and normals, single-sampled, and a BRDF that is exactly zero for light from behind.
 */
#ifndef FNL_PASSES_BACKFACE_H
#define FNL_PASSES_BACKFACE_H

#include "passes/lights/light_list.h"
#include "passes/shade/gbuffer.h"

/** Where the axis of the cone round a tile's normals comes from. Any does: the angle is measured from it. */
enum backface_axis {
    BACKFACE_SAMPLES, /* mean of four pixels */
    BACKFACE_SUM,     /* mean of all pixels of those tiles that need one, by atomics */
    BACKFACE_PYRAMID, /* mean of all pixels of all tiles: a level of a pyramid of the normals */
};

struct backface_params {
    struct tiled_params tiles; /* default tiled_params_default() */
    enum backface_axis axis;   /* default BACKFACE_SAMPLES */
    uint32_t least;  /* tiles with fewer lights, or with a third as many behind four of their pixels, are left alone: finding
                                  the cone costs about as much as these do; default 12 */
    bool every_tile; /* cones are found even so, for the debug view; lists stay the same; default false */
    bool tally; /* lights behind the surfaces of every tile they touch are counted in light_list.culled; default false */
};
struct backface_params backface_params_default(void);
/**
 * Tiled lists without the lights behind all normals of a tile. Looks at the depth and normals of `gbuffer`.
 * Cost: that of tiled lists; per tile with lights behind four of its pixels a read of its normals and one more test per light.
 */
struct light_list backface_add(struct graph *graph, gpu_device *device, const struct light_input *input,
                               const struct lights_in_view *in_view, const struct gbuffer *gbuffer,
                               const struct backface_params *params);

#endif
