/* SPDX-License-Identifier: MIT */
/**
 * Drawing the scene from GPU-culled lists. Items (primitives of instances) are sorted into buckets of equal pipeline state; each
 * bucket is one multi-draw-indirect whose draws are groups of items of one primitive. Culling keeps the items in order, so
 * every frame draws the same triangles in the same order.
 */
#ifndef FNL_PASSES_GEOMETRY_H
#define FNL_PASSES_GEOMETRY_H

#include "graph/graph.h"
#include "passes/geometry/geometry_shared.h"
#include "scene_shared.h"

/* Bits of geometry_scene.attributes: what surfaces look at besides the first set of texture coordinates. */
enum { GEOMETRY_UV1 = 1, GEOMETRY_COLORS = 2 };

/* Bits of gpu_material.forward_layouts and geometry_bucket.forward_layouts behind those of the G-buffer layouts and VIRTUAL_FORWARD: the materials
 * have layers; the items have a light mask (buckets only); what is behind shows through them. */
enum { GEOMETRY_LAYERED = 10, GEOMETRY_MASKED = 11, GEOMETRY_TRANSMISSIVE = 12 };

struct geometry_bucket {
    VkPrimitiveTopology topology;
    bool mask, blend, double_sided, mirrored;
    uint32_t forward_layouts; /* a bit for each G-buffer layout that cannot hold its materials (gbuffer_layouts.h) */
    uint32_t first_item, item_count, first_group, group_count;
};

/** Opaque or cutout: neither blended nor transmissive, which are drawn over it. */
static inline bool geometry_bucket_opaque(const struct geometry_bucket *bucket) {
    return !bucket->blend && !(bucket->forward_layouts >> GEOMETRY_TRANSMISSIVE & 1);
}
/** Whether clusters_add culls the bucket by clusters: it has triangles, opaque or cutout. */
static inline bool geometry_bucket_clustered(const struct geometry_bucket *bucket) {
    return geometry_bucket_opaque(bucket) && bucket->topology == VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
}

/** The scene on the device, as the passes of one frame see it. Blended triangles are the last items and groups. */
struct geometry_scene {
    VkDeviceAddress scene;            /* struct gpu_scene */
    VkDeviceAddress material_entries; /* of the G-buffer layouts with material IDs (gbuffer_shared.h) */
    const struct gpu_buffer *indices; /* and behind them, where some are asked for, those that culling writes */
    graph_buffer
        vertices; /* imported; stands for positions, attributes and instances: written by updates and skin_add, read by culling and draws */
    const struct geometry_bucket *buckets;
    uint32_t bucket_count, item_count, group_count;
    uint32_t unit_count;                         /* of struct gpu_group, of all of them */
    uint32_t attributes;                         /* GEOMETRY_… */
    float gradient_taps;                         /* constant GRADIENT_TAPS of shaders/material.glsl */
    uint32_t most_triangles;                     /* of one item; lines and points count too */
    uint32_t material_count, material_classes;   /* classes: bit 1 << c, some material is of GPU_CLASS_… bits c */
    uint32_t blend_first_item, blend_item_count; /* triangles of FNL_ALPHA_BLEND materials, drawn back to front */
    uint32_t caster_count;                       /* items before this one cast shadows, if they are triangles of a material that does */
    uint32_t features;                           /* GPU_FEATURE_… of scene_shared.h: what its shaders do besides */
    graph_buffer feature_buffers[6];             /* what they read for it; id 0: none */
    uint64_t cluster_count, triangle_count;      /* of all items that are culled by clusters */
    uint32_t index_count, pool_triangles;        /* indices of the scene, and triangles of a view for which there is room behind them */
};

/** How draws for several views go to the layers of these views. */
enum geometry_layers {
    GEOMETRY_LAYERS_MULTIVIEW,
    GEOMETRY_LAYERS_DRAWS,    /* one draw after the other, with the same states; where gpu_info()->vertex_layers */
    GEOMETRY_LAYERS_INSTANCES /* an instance for each in one draw: after cull_repeat_add; likewise */
};

/** Result of culling: which items are drawn, as indirect draws. */
struct geometry_draws {
    graph_buffer sums; /* item_count + 1 prefix sums of visibility; the last is the number of visible items */
    graph_buffer visible, draws;
    graph_buffer blend_visible, blend_draws; /* id 0 when nothing blends */
    /* Of clusters_add; id 0: opaque triangles are drawn as items. */
    graph_buffer item_draws, totals, triangles, indices;
    graph_buffer mesh_draws, mesh_list, mesh_slots, mesh_sums,
        mesh_masks;           /* in place of item_draws, triangles and indices */
    uint32_t mesh_draw_count; /* of each bucket */
    uint32_t view_mask;       /* of cull_views_add and cull_union_add: passes draw into these layers at once; 0: one view */
    enum geometry_layers layers; /* how */
    bool counts_vertices; /* of the opaque set, by geometry_query_count queries from first_query on (gpu_begin_vertex_count) */
    uint32_t first_query;
    bool depth_begun; /* the depth target holds what nothing is drawn over (passes/stereo/hidden_area.h): passes that would clear it for the opaque set do not */
    graph_buffer hidden; /* of occlusion_add, one per item and their number; id 0: nothing is hidden */
};

/**
 * Culls items against the view and writes draws; sorts the blended ones by the depth of their centre, farthest first.
 * `view` is the address of a struct gpu_view. Cost: a few reads and writes per item; sorting 8 passes over blended items.
 */
struct geometry_draws cull_add(struct graph *graph, const struct geometry_scene *scene, VkDeviceAddress view);

/** The same of what cull_items_add() has found for a wider view: only sorts the blended items anew. */
void cull_sort_add(struct graph *graph, const struct geometry_scene *scene, VkDeviceAddress view, struct geometry_draws *draws);

/**
 * The same for several views at once, as many structs gpu_view one after the other: what some view sees is drawn for all of them, in the
 * order in which each alone would draw it. Passes that know (their comments say so) draw with it into the layers of their targets, by multiview unless
 * geometry_draws.layers says otherwise. Blended items are left out: their order is that of one view.
 */
struct geometry_draws cull_views_add(struct graph *graph, const struct geometry_scene *scene, VkDeviceAddress views,
                                     uint32_t view_count);

/**
 * The same of views that have been culled by themselves, 1 .. 6 of them, of which occlusion may have hidden different items; draws go to `together` views.
 */
struct geometry_draws cull_union_add(struct graph *graph, const struct geometry_scene *scene, const struct geometry_draws *const views[],
                                     uint32_t view_count, uint32_t together);

/** Draws for several views: each instance is drawn once for each of them, in a row. */
void cull_repeat_add(struct graph *graph, const struct geometry_scene *scene, struct geometry_draws *draws);

enum geometry_set {
    GEOMETRY_OPAQUE, /* opaque and cutout items */
    GEOMETRY_BLEND,  /* blended items, back to front */
    GEOMETRY_NOT_IN_FIRST
};
/* Opaque and cutout items that a G-buffer layout (fnl_gbuffer) cannot hold. */
#define GEOMETRY_NOT_IN(layout) ((enum geometry_set)(GEOMETRY_NOT_IN_FIRST + (int)(layout)))
/* Items that what is behind shows through, in the order of opaque ones; in no other set. */
#define GEOMETRY_GLASS GEOMETRY_NOT_IN(GEOMETRY_TRANSMISSIVE)

/** Declares the buffers that a drawing pass reads. */
void geometry_use(struct graph_pass *pass, const struct geometry_scene *scene, const struct geometry_draws *draws,
                  enum geometry_set set);

/** The part of it that shaders with decals read, for passes that shade without drawing. */
void geometry_use_features(struct graph_pass *pass, const struct geometry_scene *scene, enum graph_use use);

/**
 * Inside a pass: draws a set. `state` gives everything but culling and topology; `state->fragment` may be NULL for depth only.
 * A geometry shader takes triangles alone. Where draws->mesh_draws is there, mesh shaders draw the clusters: `state` may have no vertex or
 * geometry shader of its own then. Cutouts use `mask_fragment` where it is not NULL. push->visible is filled in here.
 */
void geometry_draw(const struct graph_context *context, const struct geometry_scene *scene,
                   const struct geometry_draws *draws, enum geometry_set set, const struct gpu_graphics_params *state,
                   const struct gpu_shader *mask_fragment, struct gpu_geometry_push push);
/** The same for fragment shaders whose push constants begin with these and go on: `push` has `size` bytes and is changed. */
void geometry_draw_with(const struct graph_context *context, const struct geometry_scene *scene,
                        const struct geometry_draws *draws, enum geometry_set set, const struct gpu_graphics_params *state,
                        const struct gpu_shader *mask_fragment, struct gpu_geometry_push *push, uint32_t size);
/** Tells a pass into which layers its draws go. */
void geometry_set_layers(struct graph_pass *pass, const struct geometry_draws *draws);
/** Views that the draws go to. */
static inline uint32_t geometry_view_count(const struct geometry_draws *draws) {
    return draws->view_mask ? (uint32_t)__builtin_popcount(draws->view_mask) : 1;
}
/** Queries that a pass takes which counts vertices. */
static inline uint32_t geometry_query_count(const struct geometry_draws *draws) {
    return draws->layers == GEOMETRY_LAYERS_MULTIVIEW ? geometry_view_count(draws) : 1;
}
/** Number of indirect draw calls that geometry_draw makes for one view, and of pipelines that it binds. */
uint32_t geometry_draw_count(const struct geometry_scene *scene, enum geometry_set set);

/** Depth of the opaque set, single- or multisampled; clears first. Draws into several views at once if `draws` has them. */
void prepass_add(struct graph *graph, const struct geometry_scene *scene, const struct geometry_draws *draws,
                 VkDeviceAddress view, graph_image depth);

/** The same as a pass of another name. */
void geometry_depth_add(struct graph *graph, const char *name, const struct geometry_scene *scene,
                        const struct geometry_draws *draws, VkDeviceAddress view, graph_image depth);

/** Depth of the nearest blended surfaces alone, whatever is opaque before them; clears first. */
void blend_depth_add(struct graph *graph, const struct geometry_scene *scene, const struct geometry_draws *draws,
                     VkDeviceAddress view, graph_image depth);

/** How the pass that draws the opaque set first takes its depth target. */
static inline VkAttachmentLoadOp geometry_depth_load(const struct geometry_draws *draws) {
    return draws->depth_begun ? VK_ATTACHMENT_LOAD_OP_LOAD : VK_ATTACHMENT_LOAD_OP_CLEAR;
}

/** The depth format of all passes and its reversed comparison. */
#define GEOMETRY_DEPTH_FORMAT VK_FORMAT_D32_SFLOAT

#endif
