/* SPDX-License-Identifier: MIT */
/** What a renderer keeps of reflection probes (reflections.h). */
#ifndef FNL_RENDER_REFLECTIONS_STATE_H
#define FNL_RENDER_REFLECTIONS_STATE_H

#include "passes/lights/light_list.h"
#include "render/device/scene.h"

/** One of a renderer. */
struct renderer_reflection {
    fnl_probe_params params;
    uint32_t slot;     /* of the scene */
    uint64_t version;  /* of the scene's probe */
    struct environment_maps maps;
    bool is_due, is_captured; /* is_captured: the maps hold something */
};

struct renderer_reflections {
    ARRAY(struct renderer_reflection) list; /* highest priority first, then as in the scene */
    uint64_t version;                       /* of the scene's probes, which `list` is of */
    struct device_array probes, bounds;     /* struct gpu_reflection, gpu_entity_bounds */
    struct gpu_buffer diffuse;              /* struct gpu_environment of each */
    bool gathered;                          /* `diffuse` holds that of all maps, in the order of `list` */
    struct fnl_renderer *capturer;          /* NULL: none is needed */
    uint32_t turn;                          /* the next of those that are captured again and again */
    uint32_t captures;                      /* of the last frame */
};

#endif
