/* SPDX-License-Identifier: MIT */
/** Which builder makes the light lists of a frame, and with what. One row per kind of lists in lists.c. */
#ifndef FNL_RENDER_LISTS_H
#define FNL_RENDER_LISTS_H

#include "fanal/renderer.h"
#include "passes/geometry/geometry.h"
#include "passes/lights/bvh.h"
#include "passes/lights/clustered.h"
#include "passes/lights/light_list.h"
#include "passes/lights/tree.h"
#include "passes/lights/raster.h"
#include "passes/lights/sparse.h"
#include "passes/shade/gbuffer.h"
#include "passes/lights/world_grid.h"
#include "render/device/scene.h"
#include "view_shared.h"

/** What builders keep from frame to frame for all views: lists of the world, which the first view of a frame brings up to date. */
struct lists_shared {
    struct world_grid world, grid2d;
};
void lists_shared_init(struct lists_shared *shared, const fnl_host *host);
/** The device is idle. */
void lists_shared_finish(struct lists_shared *shared, gpu_device *device);

/** What they keep for one view. */
struct lists_state {
    struct clustered_cpu clustered_cpu;
    struct light_tree tree;
    struct raster_state raster;
    /* The estimated pool of each kind of list, and what it was estimated for. It is kept until that changes, because estimating takes time. */
    struct lists_room {
        fnl_cluster_options clusters;
        uint32_t tile_size, light_count, width, height, pool;
    } rooms[FNL_LISTS_COUNT], surface_room;
};
void lists_init(struct lists_state *state, const fnl_host *host);
/** The device is idle. */
void lists_finish(struct lists_state *state, gpu_device *device);

/** Of the frame's lists, and of the tiles that lists_add_surfaces() adds. */
struct lists_counts {
    struct light_totals lights, blend_lights, surface_lights;
    uint32_t behind;
};
extern const struct counter_table counters_lists;

/** Entries that the pool of a list may have. */
uint32_t lists_pool_limit(const struct fnl_renderer *r);

/** Lists of a view that serve all pixels (lists_add_fallback()), and what they were made for. */
struct lists_fallback {
    struct light_list list; /* header 0: there are none */
    uint32_t width, height;
};

struct lists_context {
    struct graph *graph;
    gpu_device *device;
    const fnl_frame *frame;
    const struct gpu_view *view;
    const struct device_scene *device_scene;
    struct geometry_scene *scene;
    const struct geometry_draws *draws;
    struct light_input *input;
    struct lists_shared *shared;
    struct lists_state *state;
    struct lists_fallback *fallback; /* of the view: built once */
    graph_image depth;             /* of everything opaque; id 0: not known before shading */
    const struct gbuffer *gbuffer; /* single-sampled, for its normals; NULL: none */
    bool of_head; /* the view is not that of the pixels: points are looked up by their places */
    bool has_blend, layered;
    uint32_t pool_capacity, pool_limit; /* entries that pools have at least, and at most where the lights are thought to need more */
    bool estimates; /* pools may be estimated again; false where only pipelines are asked for */
    struct lists_room *room; /* of the list that is being made */
    struct light_list lights, blend_lights; /* out: of opaque and of blended surfaces; often the same */
};
void lists_add(struct lists_context *context);
/** Lights once more, beside a list that does not serve every pixel: clusters, whatever the frame's lists are but `all`, which stays so. */
struct light_list lists_add_fallback(const struct lists_context *context);
/** Lights once more, for all that `depth` shows: tiles of 8 pixels, whatever the frame's lists are but `all`, which stays so. */
struct light_list lists_add_surfaces(const struct lists_context *context);
/** Whether the builder looks at each light of the view on the CPU. */
bool lists_cull_on_cpu(fnl_light_lists lists);

#endif
