/* SPDX-License-Identifier: MIT */
/**
 * The cube maps of probes: what light the walls of a room let in, seen from one point (shaders/shadows/cubemap_shared.h). Baked by a ray for each texel through
 * the trees of rays.h, then filtered down to one texel a face, across the edges of faces. Two bakes of one scene give the same bytes.
 */
#ifndef FNL_PASSES_SHADOW_CUBEMAP_H
#define FNL_PASSES_SHADOW_CUBEMAP_H

#include "graph/graph.h"
#include "shadows/cubemap_shared.h"

/** Those of a frame, for shaders that look them up. */
struct probes {
    graph_image images[PROBES_MOST];
    uint32_t count;
    VkDeviceAddress address; /* struct gpu_probes; 0: there are none */
};
/** Declares that a pass looks them up. */
void probes_use(struct graph_pass *pass, const struct probes *probes, enum graph_use use);

/** The levels of a cube map, down to one texel a face. */
uint32_t cubemap_levels(uint32_t side);
/** Bytes of all levels. As BC3 they take a quarter, except levels smaller than a block of 4 x 4 texels. */
uint64_t cubemap_bytes(uint32_t side, bool compressed);
/** An image for a cube map; `compressed`: of BC3, which needs fnl_device_info.texture_compression. */
fnl_result cubemap_create(gpu_device *device, uint32_t side, bool compressed, struct gpu_image *out);

struct rays;
/** Fills the image of one probe, which graph_import_image() gave. Its struct gpu_probe is there. `kept`: receives a copy of the bytes; or NULL. */
void cubemap_bake_add(struct graph *graph, const struct rays *rays, VkDeviceAddress probes, uint32_t probe, graph_image image,
                      const struct gpu_buffer *kept);

#endif
