/* SPDX-License-Identifier: MIT */
/**
 * The atlas of virtual texturing, 128 x 128 texels a page, filled on the GPU with the pages that frames want (after AC Unity: Haar and Aaltonen,
 * "GPU-Driven Rendering Pipelines", SIGGRAPH 2015; RTR 4, 20.5).
 */
#ifndef FNL_PASSES_VIRTUAL_H
#define FNL_PASSES_VIRTUAL_H

#include "graph/graph.h"
#include "passes/texturing/virtual_shared.h"

/* Bit of gpu_material.forward_layouts, behind those of the G-buffer layouts: the atlas cannot hold the material. */
enum { VIRTUAL_FORWARD = 9 };

/** What is kept from frame to frame. */
struct virtual_atlas {
    struct gpu_buffer materials, pages, table, owners, wanted, places, commands;
    struct gpu_image layers[VIRTUAL_LAYERS]; /* handle 0: the scene has no such textures */
    uint32_t page_count, always, across;
    uint64_t bytes;   /* of the layers */
    bool fresh;       /* no frame has been drawn with it: what it wants is found by drawing the geometry once more */
    uint64_t version;  /* device_scene.texture_version; UINT64_MAX: there is none */
    uint64_t arrivals; /* device_scene.image_arrivals */
    uint32_t asked;   /* side that was asked for */
};

/**
 * Makes atlas and tables for `page_count` pages, `layers` a bit each; `side` texels at most, fewer where all pages fit in less or memory is short.
 * FNL_ERROR_UNSUPPORTED where not even the first `always` pages fit. Blocks; call outside of frames.
 */
struct virtual_contents {
    const struct gpu_virtual_material *materials;
    const struct gpu_virtual_page *pages;
    uint32_t material_count, page_count, always, layers, side;
};
fnl_result virtual_create(gpu_device *device, const struct virtual_contents *contents, struct virtual_atlas *out);
void virtual_destroy(gpu_device *device, struct virtual_atlas *atlas);
/** Its pages are to be filled anew: their textures have other contents. Call outside of frames. */
fnl_result virtual_empty(gpu_device *device, const struct virtual_atlas *atlas);

/** The atlas in one frame. */
struct virtual_frame {
    VkDeviceAddress address; /* struct gpu_virtual */
    graph_buffer table, owners, wanted, places, commands;
    graph_image layers[VIRTUAL_LAYERS];
};
/** `scene_materials`: gpu_scene.materials. `address` 0 after a sticky error. */
struct virtual_frame virtual_begin(struct graph *graph, gpu_device *device, const struct virtual_atlas *atlas,
                                   VkDeviceAddress scene_materials);
/** Makes resident what was wanted since the last time, and fills it. Cost: a read of each page of the scene, and the texels filled. */
void virtual_update_add(struct graph *graph, const struct virtual_frame *frame);
/** Declares what virtual_locate.glsl and virtual_sample.glsl touch. */
void virtual_use_locate(struct graph_pass *pass, const struct virtual_frame *frame);
void virtual_use_sample(struct graph_pass *pass, const struct virtual_frame *frame);

/** Draws a view, VIRTUAL_VIEW_…, to a storage image. `uv` and `depth`: of one sample, for VIRTUAL_VIEW_PAGES alone. */
void virtual_view_add(struct graph *graph, const struct virtual_frame *frame, uint32_t mode, graph_image uv,
                      graph_image depth, VkDeviceAddress view, graph_image target, bool swap);

#endif
