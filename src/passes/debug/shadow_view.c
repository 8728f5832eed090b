/* SPDX-License-Identifier: MIT */
#include "passes/debug/debug.h"

#include "passes/debug/shadow_view_shared.h"

#include "fanal/renderer.h"
#include "shaders.h"

_Static_assert((uint32_t)FNL_DEBUG_SHADOW_PAGES == GPU_DEBUG_SHADOW_PAGES && (uint32_t)FNL_DEBUG_SHADOW_LEVELS == GPU_DEBUG_SHADOW_LEVELS &&
                   (uint32_t)FNL_DEBUG_SHADOW_TEXELS == GPU_DEBUG_SHADOW_TEXELS &&
                   (uint32_t)FNL_DEBUG_SHADOW_ERRORS == GPU_DEBUG_SHADOW_ERRORS && (uint32_t)FNL_DEBUG_PROBE_LOOKUP == GPU_DEBUG_PROBE_LOOKUP &&
                   (uint32_t)FNL_DEBUG_PROBE_LEVELS == GPU_DEBUG_PROBE_LEVELS && (uint32_t)FNL_DEBUG_SHADOW_RAYS == GPU_DEBUG_SHADOW_RAYS &&
                   (uint32_t)FNL_DEBUG_SHADOW_AGE == GPU_DEBUG_SHADOW_AGE && (uint32_t)FNL_DEBUG_SHADOW_CLASSES == GPU_DEBUG_SHADOW_CLASSES,
               "shadow_view_shared.h has the values of fnl_debug_view");

void shadow_view_add(struct graph *graph, uint32_t mode, const struct aov_images *aov, const struct lighting *lighting, graph_buffer classes,
                     VkDeviceAddress view, graph_image target, bool swap) {
    const struct graph_image_params image = graph_image_info(graph, target);
    struct gpu_shadow_view_push push = {.view = view, .lighting = lighting->address, .swap = swap, .mode = mode};
    uint32_t heeded = GPU_LIST_KINDS | GPU_LIGHTING_MAPS | GPU_LIGHTING_CUBEMAP | GPU_LIGHTING_AREA_LIGHTS;
    if (mode == GPU_DEBUG_SHADOW_ERRORS || mode == GPU_DEBUG_SHADOW_RAYS) heeded |= GPU_LIGHTING_RAYS | GPU_LIGHTING_RAY_QUERY;
    if (mode == GPU_DEBUG_SHADOW_RAYS) heeded |= GPU_LIGHTING_SOFT;
    struct graph_pass *pass =
        graph_dispatch(graph, &(struct graph_dispatch){.name = "debug view",
                                                       .pipeline = {&shader_shadow_view_comp, 1, {lighting->bits & heeded}},
                                                       .groups = {DIVIDE_UP(image.width, 8u), DIVIDE_UP(image.height, 8u)},
                                                       GRAPH_PUSH(push),
                                                       GRAPH_ROWS(graph_samples(&push.albedo, aov->albedo),
                                                                  graph_samples(&push.normal, aov->normal),
                                                                  graph_samples(&push.position, aov->position),
                                                                  graph_row_if(classes.id > 0, graph_reads(&push.classes, classes)),
                                                                  graph_stores(&push.target, target))});
    lighting_use(pass, lighting, GRAPH_READ_COMPUTE);
}
