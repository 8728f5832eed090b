/* SPDX-License-Identifier: MIT */
/**
 * Fine-pruned tiles (M. Mikkelsen, "Fine Pruned Tiled Light Lists", GPU Pro 7, II.2): a tile keeps a light only when the light's true
 * volume, of whatever shape, holds the position of one of its pixels. In three steps: lights get tight boxes in screen space and depth
 * (fine_bounds); boxes against boxes, first for blocks of tiles, then for tiles; and what passes against the pixels. Which pixels of the
 * tile a light holds is kept as a bit mask, so that a pixel visits hardly more lights than reach it.
 *
 * Positions are those that deferred shading makes from depth, and volumes are widened by a 10^-5 of the distances from the world's origin.
 * Shading that interpolates positions, or shades partly covered pixels elsewhere (MSAA), is told the tested positions too: a point that is
 * not near enough to its pixel's looks lights up in a list without depth, or where there is none takes all lights.
 *
 * No number of lights, per tile or in all, is too many: see fine_tile.glsl. Cost: 8 bytes a tile; 4 for an entry and one bit for each
 * entry and pixel (or quad) of its tile; with positions 12 a pixel; while building a bit for each light and block.
 *
 * Packed as in the source, a tile and list takes 32 bytes and nothing else: no masks, no pool. Up to 24 lights fit, of the first 1024 in
 * view; a tile with others counts as overflown and uses all lights in view.
 */
#ifndef FNL_PASSES_FINE_H
#define FNL_PASSES_FINE_H

#include "passes/lights/fine_shared.h"
#include "passes/lights/light_list.h"

struct fine_params {
    uint32_t tile_size; /* pixels: 8, 16, 32 or 64; default 16 */
    /* Threads along the side of the group that a tile gets, 8 or 16, and no more than pixels; default 16. With few pixels for each a GPU holds
     * many groups at a time; CPU drivers pay for each thread at each barrier. */
    uint32_t group_side;
    bool pruning;       /* test pixels; false: boxes alone, and no masks; default true */
    uint32_t mask_size; /* side of the squares of pixels that share a mask: 1, 2, or 0: no masks; default 1 */
    bool
        packed; /* three places of 10 bits a word, eight words a tile; mask_size and pool_capacity mean nothing then; default false */
    bool
        exact_positions; /* shading makes its positions from depth as well, so that none have to be compared; default true */
    bool blend;          /* a second list for blended surfaces; default false */
    graph_image
        blend_depth; /* of the nearest of them; id 0 (default): they may be anywhere before what is opaque, and are not pruned */
    float eye_distance;     /* metres of the eye from the world's origin; default 0 */
    uint32_t pool_capacity; /* default 2^20 */
};
struct fine_params fine_params_default(void);

struct fine_lists {
    struct light_list lights, blend; /* of the least kind of light_input.kinds; these and the others share their buffers */
    struct light_list others[GPU_ENTITY_KINDS]; /* by GPU_ENTITY_…: of each further kind. What there is no list of has no header */
    graph_buffer boxes;                         /* struct gpu_fine_box for each light in view */
};

/**
 * Each kind of light_input.kinds gets a list of its own, all from the same dispatches. `depth`: of everything opaque; id 0: none, then tiles
 * reach from the viewer to infinity, nothing is pruned, and `lights` serves blended surfaces too.
 */
struct fine_lists fine_add(struct graph *graph, gpu_device *device, const struct light_input *input,
                           const struct lights_in_view *in_view, graph_image depth, const struct fine_params *params);

#endif
