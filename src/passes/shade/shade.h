/* SPDX-License-Identifier: MIT */
/** The shading orders: each turns geometry and a light list into radiance through the same shade_surface() (shaders/shade.glsl). */
#ifndef FNL_PASSES_SHADE_H
#define FNL_PASSES_SHADE_H

#include "constants_shared.h"
#include "fanal/renderer.h"
#include "passes/geometry/geometry.h"
#include "passes/lighting/lighting.h"

/** Where a pass puts what shade_surface() of shade.glsl keeps apart (light_apart), which is then not in the radiance. open.id 0: it keeps nothing apart. */
struct shade_apart {
    graph_image open, seen, drawn;
    struct graph_history field;
};

/** What guides the choice of lights (passes/shadow/guide.h): the images of shadows/guide_shared.h. weights.id 0: nothing does. */
struct shade_guide {
    graph_image weights, seen; /* shading adds its rays to `seen` */
};

struct shade_input {
    const struct geometry_scene *scene;
    const struct geometry_draws *draws;
    const struct lighting *lighting;
    VkDeviceAddress view;
    uint32_t width, height;
    uint32_t light_count; /* a pixel visits no more local lights */
    graph_image glass;     /* with GPU_LIGHTING_BEHIND_GLASS: gpu_lighting.glass */
    graph_buffer counters; /* one uint per pixel, added to by each shaded fragment; id 0: not counted */
    struct environment_light environment; /* for passes without lighting; or ids 0 */
    float background[4]; /* what radiance is cleared to: no coverage */
    fnl_gbuffer layout; /* of the G-buffer, in orders that have one: see fnl_frame */
    fnl_normal_encoding normals;
    bool chroma;
    struct shade_apart apart; /* of deferred_add() without classes, as the next */
    struct shade_guide guide;
};

/**
 * Forward shading of a set into `radiance` (cd/m^2) with `depth`, both single- or multisampled. The opaque set either clears and
 * fills depth itself, or with `prepass` tests for equality against a depth that is complete. The blended set is drawn over
 * what is there, premultiplied, without writing depth; so are, with a prepass, parts of the opaque set (GEOMETRY_NOT_IN). Cost: all fragments that pass the depth test are shaded.
 */
void forward_add(struct graph *graph, const struct shade_input *input, enum geometry_set set, bool prepass,
                 graph_image radiance, graph_image depth);

#endif
