/* SPDX-License-Identifier: MIT */
/**
 * Everything that lights a point, for passes that shade. Each part is written once, in its scope: the lights of a frame, the shadows of a group of views, the
 * environment and the reflection probes of a view, and a light list. A frame fills in each scope once its parts exist; lighting_add() then gives shaders one
 * lighting for each view and list. Shaders read it through shaders/lighting/.
 *
 * Cost: 128 bytes for each view and list.
 */
#ifndef FNL_PASSES_LIGHTING_H
#define FNL_PASSES_LIGHTING_H

#include "lighting/lighting_shared.h"
#include "passes/ambient/environment.h"
#include "passes/lights/light_list.h"
#include "passes/shadow/cubemap.h"
#include "passes/shadow/maps.h"
#include "passes/shadow/rays.h"

/** What finds shadows. */
struct shadows {
    struct rays rays;        /* address 0: none are sent */
    struct shadow_maps maps; /* address 0: there are none */
    struct probes rooms;     /* beside rays; address 0: there are none */
    uint32_t bits;           /* GPU_LIGHTING_… set by the shadow method; bits that need rays or maps are ignored without them */
    uint32_t ray_count;      /* that a point sends to its lights, with GPU_LIGHTING_SAMPLED */
    uint32_t seed;           /* frames with other seeds send them to other lights */
    graph_image contact;     /* depth of the view's opaque surfaces, along which points march; id 0: they do not */
    float contact_length;    /* meters */
};

struct lighting {
    struct light_set lights; /* scope: frame; with light-lod: view */
    bool layered;            /* scope: frame. Some material has layers: shaders get GPU_LIGHTING_LAYERS, and the environment's table is there */
    struct shadows shadows;  /* scope: group of views */
    struct environment_light environment; /* scope: frame; its reflections: view. ids 0: there is none */
    VkDeviceAddress view;    /* struct gpu_view */
    struct light_list list;  /* header 0: there is none, so points find no lights */
    uint32_t bits;           /* specialization constant LIGHTING_ID */
    VkDeviceAddress address; /* struct gpu_lighting; 0: lighting_add() was not called, or there is no memory, and the error sticks to the device */
    struct gpu_lighting *memory; /* the same; or NULL */
};

/** Makes the lighting for `list`, or without a list if it is NULL; `scopes` supplies all other parts. */
struct lighting lighting_add(struct graph *graph, gpu_device *device, const struct lighting *scopes, const struct light_list *list);

/** Declares that a pass shades in fragment or compute shaders (GRAPH_READ_FRAGMENT, GRAPH_READ_COMPUTE). */
void lighting_use(struct graph_pass *pass, const struct lighting *lighting, enum graph_use use);

/** What a list over the lights is built from; the size of the view is left to the caller. */
static inline struct light_input lighting_input(const struct lighting *scopes) {
    return (struct light_input){.set = scopes->lights, .kinds = 1u << GPU_ENTITY_LIGHT, .view = scopes->view};
}

#endif
