/* SPDX-License-Identifier: MIT */
#include "render/lists.h"

#include "passes/lights/backface.h"
#include "passes/lights/fine.h"
#include "passes/lights/mesh_lists.h"
#include "render/light_reach.h"
#include "render/traits.h"
#include "render/view.h"

/* ---- life ---- */

void lists_shared_init(struct lists_shared *shared, const fnl_host *host) {
    world_grid_init(&shared->world, host);
    world_grid_init(&shared->grid2d, host);
}

void lists_shared_finish(struct lists_shared *shared, gpu_device *device) {
    world_grid_finish(&shared->world, device);
    world_grid_finish(&shared->grid2d, device);
}

void lists_init(struct lists_state *state, const fnl_host *host) {
    *state = (struct lists_state){0};
    clustered_cpu_init(&state->clustered_cpu, host);
    light_tree_init(&state->tree, host);
}

void lists_finish(struct lists_state *state, gpu_device *device) {
    clustered_cpu_finish(&state->clustered_cpu);
    light_tree_finish(&state->tree);
    raster_state_finish(&state->raster, device);
}

/* ---- the builders ---- */

enum {
    ZBIN_BINS_PER_SLICE = 4
}; /* bins cost a mask each, not a cell for each tile: there may be more than slices of clusters */

static struct lights_in_view in_view(struct lists_context *c, bool reaches) {
    c->input->spheres_only = !reaches;
    return lights_in_view_add(c->graph, c->device, c->input);
}

static void add_all(struct lists_context *c) { c->lights = light_list_all_add(c->graph, c->device, c->input); }

/* Room for so many entries, in steps of a quarter: views that change a little keep the same buffers. */
static uint32_t pool_for(const struct lists_context *c, double entries) {
    uint32_t pool = MAX(c->pool_capacity, MIN(c->room->pool, c->pool_limit));
    while (pool < c->pool_limit && pool < entries) pool = MIN(pool + pool / 4 + 1, c->pool_limit);
    return c->room->pool = pool;
}

/* Begins anew where other lights or sizes are to be given room. */
static bool estimates_room(struct lists_context *c) {
    const fnl_frame *frame = c->frame;
    struct lists_room *room = c->room;
    bool known = room->light_count == c->input->set.local_count && room->width == frame->width &&
                 room->height == frame->height && room->tile_size == frame->tiles.size &&
                 memcmp(&room->clusters, &frame->clusters, sizeof room->clusters) == 0;
    if (!known)
        *room = (struct lists_room){frame->clusters, frame->tiles.size, c->input->set.local_count, frame->width, frame->height, 0};
    return !known;
}

static const struct gpu_entity_bounds *local_bounds(const struct lists_context *c) {
    return c->input->set.local_count ? c->device_scene->light_bounds.data : NULL;
}

static struct light_reach reach_of(const struct lists_context *c, const struct clustered_params *grid) {
    if (!c->estimates) return (struct light_reach){0};
    return light_reach_estimate(c->view, local_bounds(c), c->input->set.local_count, grid);
}

static uint32_t tile_pool(const struct lists_context *c, uint32_t tile_size, double lists) {
    struct clustered_params grid = clustered_params_default();
    grid.tile_size = tile_size;
    return pool_for(c, lists * reach_of(c, &grid).tiles);
}

static struct tiled_params tiled_params(const struct lists_context *c, uint32_t tile_size, double lists) {
    struct tiled_params params = tiled_params_default();
    params.tile_size = tile_size;
    params.bounds = (enum tile_bounds)c->frame->tiles.bounds;
    params.cone_tests = c->frame->list.cone_tests;
    params.min_depth = c->frame->tiles.min_depth;
    params.max_depth = c->frame->tiles.max_depth;
    params.pool_capacity = tile_pool(c, tile_size, lists);
    return params;
}

_Static_assert((int)TILE_BOX == FNL_TILE_BOUNDS_BOX && (int)TILE_RECTANGLE == FNL_TILE_BOUNDS_PROJECTED &&
                   FNL_TILE_BOUNDS_COUNT == FNL_TILE_BOUNDS_PROJECTED + 1,
               "tile_bounds has the values of fnl_tile_bounds");

static bool tile_reaches(const struct lists_context *c) {
    return c->frame->list.cone_tests || c->frame->tiles.bounds == FNL_TILE_BOUNDS_PROJECTED;
}

static graph_image add_blend_depth(struct lists_context *c) {
    struct graph_image_params params = graph_image_info(c->graph, c->depth);
    params.name = "blend depth";
    graph_image image = graph_create_image(c->graph, &params);
    blend_depth_add(c->graph, c->scene, c->draws, c->input->view, image);
    return image;
}

/* Glass stands in front of what the depth shows: it gets tiles of its own (ES-44). */
static void add_blend_tiles(struct lists_context *c, const struct lights_in_view *visible,
                            const struct tiled_params *opaque) {
    if (!c->depth.id || !c->has_blend) return;
    struct tiled_params params = *opaque;
    params.front = add_blend_depth(c);
    c->blend_lights = tiled_add(c->graph, c->device, c->input, visible, c->depth, &params);
}

static void add_tiled(struct lists_context *c) {
    struct lights_in_view visible = in_view(c, tile_reaches(c));
    struct tiled_params params = tiled_params(c, c->frame->tiles.size, 1);
    c->lights = tiled_add(c->graph, c->device, c->input, &visible, c->depth, &params);
    add_blend_tiles(c, &visible, &params);
}

static void add_halfz(struct lists_context *c) {
    struct lights_in_view visible = in_view(c, tile_reaches(c));
    struct tiled_params params = tiled_params(c, c->frame->tiles.size, 2);
    c->lights = halfz_add(c->graph, c->device, c->input, &visible, c->depth, &params);
    add_blend_tiles(c, &visible, &params);
}

static void add_25d(struct lists_context *c) {
    struct lights_in_view visible = in_view(c, tile_reaches(c));
    struct tiled_params params = tiled_params(c, c->frame->tiles.size, 1);
    c->lights = tiled25d_add(c->graph, c->device, c->input, &visible, c->depth, &params);
    add_blend_tiles(c, &visible, &params);
}

static void add_enhanced(struct lists_context *c) {
    struct lights_in_view visible = in_view(c, c->frame->list.cone_tests);
    struct tiled_params params = tiled_params(c, c->frame->tiles.size, 1);
    c->lights = enhanced_add(c->graph, c->device, c->input, &visible, &params);
}

static void add_tree(struct lists_context *c) {
    struct light_tree_params params = {.tile_size = c->frame->tiles.size,
                                       .hybrid = c->frame->list.tree_hybrid};
    c->lights = light_tree_add(&c->state->tree, c->device, c->input, local_bounds(c), c->view, &params);
}

/* Slices reach as far as the scene does; nearer than a 128th of that they would be thin for nothing. */
static struct clustered_params cluster_params(const struct lists_context *c) {
    const fnl_cluster_options *options = &c->frame->clusters;
    struct clustered_params params = clustered_params_default();
    params.tile_size = options->size;
    params.slices = options->slices;
    float far = view_reach(c->view, &c->device_scene->bounds);
    params.far = isinf(options->far) ? fminf(far, 1e6f) : options->far;
    params.near =
        isinf(options->near) ? fmaxf(c->frame->camera.near_distance, params.far / 128) : options->near;
    params.near = fminf(params.near, params.far * 0.5f);
    params.linear = options->distribution == FNL_SLICES_LINEAR;
    params.cone_tests = c->frame->list.cone_tests;
    params.pool_capacity = pool_for(c, reach_of(c, &params).clusters);
    return params;
}

enum { FALLBACK_TREE_LIGHTS = 1024, FALLBACK_TILE = 32 };

static bool has_fallback(const struct lists_context *c) {
    const struct lists_fallback *f = c->fallback;
    return f->list.header && f->width == c->input->width && f->height == c->input->height;
}

static void add_clustered(struct lists_context *c) {
    const bool serves_all = !c->of_head && c->input->set.local_count < FALLBACK_TREE_LIGHTS; /* it is what the fallback would be */
    if (serves_all && has_fallback(c)) {
        c->lights = c->fallback->list;
        c->lights.kind = list_kind(&c->lights);
        return;
    }
    struct lights_in_view visible = in_view(c, c->frame->list.cone_tests);
    struct clustered_params params = cluster_params(c);
    c->lights = clustered_add(c->graph, c->device, c->input, &visible, &params);
    if (serves_all && !c->fallback->list.header) *c->fallback = (struct lists_fallback){c->lights, c->input->width, c->input->height};
}

/* Words of 32 lights: a tile or bin has no more of them than lights, and no more than there are. */
static uint32_t zbin_pool(const struct lists_context *c, const struct clustered_params *grid, uint32_t zones) {
    struct light_reach reach = reach_of(c, grid);
    double words = ceil(reach.in_view / 32) + 1;
    double tiles = (double)DIVIDE_UP(c->input->width, grid->tile_size) * DIVIDE_UP(c->input->height, grid->tile_size);
    struct clustered_params by_zones = *grid;
    by_zones.slices = zones;
    double touched = zones > 1 ? reach_of(c, &by_zones).clusters : reach.tiles;
    return pool_for(c, fmin(touched, tiles * zones * words) + fmin(reach.slices, grid->slices * words));
}

static void add_zbin(struct lists_context *c) {
    struct lights_in_view visible = in_view(c, false);
    struct clustered_params grid = cluster_params(c);
    grid.tile_size = c->frame->tiles.size;
    grid.slices *= ZBIN_BINS_PER_SLICE;
    struct zbin_params params = {.tile_size = grid.tile_size,
                                 .bins = grid.slices,
                                 .near = grid.near,
                                 .far = grid.far,
                                 .linear = grid.linear};
    params.pool_capacity = zbin_pool(c, &grid, zbin_zones(c->input, &params));
    c->lights = zbin_add(c->graph, c->device, c->input, &visible, &params);
}

static void add_bvh(struct lists_context *c) {
    struct lights_in_view visible = in_view(c, c->frame->list.cone_tests);
    struct clustered_params params = cluster_params(c);
    c->lights = bvh_add(c->graph, c->device, c->input, &visible, &params);
}

static void add_sparse(struct lists_context *c) {
    if (!c->depth.id) { /* any cluster may be occupied */
        add_bvh(c);
        return;
    }
    struct lights_in_view visible =
        in_view(c, c->frame->list.cone_tests || (c->frame->list.normal_cones && c->gbuffer));
    struct sparse_params params = {.grid = cluster_params(c),
                                   .depth = c->depth,
                                   .gbuffer = c->frame->list.normal_cones ? c->gbuffer : NULL,
                                   .blend = c->has_blend};
    struct sparse_lists lists = sparse_add(c->graph, c->device, c->input, &visible, &params);
    c->lights = lists.lights;
    c->blend_lights = lists.blend;
}

static void add_clustered_cpu(struct lists_context *c) {
    const struct light_input *input = c->input;
    struct clustered_params params = cluster_params(c);
    struct clustered_cpu_view view = {c->view->ndc_scale, c->view->ndc_offset, c->frame->camera.orthographic,
                                      c->frame->width, c->frame->height};
    c->lights = clustered_cpu_add(&c->state->clustered_cpu, c->device, input,
                                  local_bounds(c),
                                  &c->view->world_to_view, &view, &params);
}

static void add_fine(struct lists_context *c) {
    struct lights_in_view visible = in_view(c, false);
    struct fine_params params = fine_params_default();
    params.tile_size = c->frame->tiles.size;
    params.group_side = gpu_info(c->device)->type == FNL_DEVICE_CPU ? 8 : 16;
    params.pruning = c->frame->fine.pruning;
    params.mask_size = c->frame->fine.masks;
    params.packed = c->frame->fine.packed;
    params.exact_positions = shading_is(c->frame->shading, SHADING_POSITIONS) && c->frame->msaa == 1;
    params.blend = c->has_blend;
    if (c->depth.id && c->has_blend && c->frame->msaa == 1) params.blend_depth = add_blend_depth(c);
    params.eye_distance = vec3_length(c->view->eye);
    params.pool_capacity = tile_pool(c, c->frame->tiles.size, c->has_blend || c->frame->msaa > 1 ? 2 : 1);
    struct fine_lists lists = fine_add(c->graph, c->device, c->input, &visible, c->depth, &params);
    c->lights = lists.lights;
    c->blend_lights = lists.blend;
}

_Static_assert((int)FNL_RASTER_LINKS64 == (int)GPU_NODES_64 && (int)FNL_RASTER_LINKS32 == (int)GPU_NODES_32 &&
                   (int)RASTER_PATH_SOFTWARE == (int)FNL_RASTER_SOFTWARE &&
                   FNL_RASTER_COUNT == FNL_RASTER_SOFTWARE + 1 && FNL_RASTER_NODES_COUNT == FNL_RASTER_LINKS32 + 1,
               "the builder's values are the options'");

static void add_raster(struct lists_context *c) {
    struct lights_in_view visible = in_view(c, false);
    struct raster_params params = raster_params_default();
    params.grid = cluster_params(c);
    params.path = (enum raster_path)c->frame->raster.path;
    params.nodes = (uint32_t)c->frame->raster.nodes;
    params.near = c->view->near_distance;
    c->lights = raster_add_kept(&c->state->raster, c->graph, c->device, c->input, &visible, &params);
}

static void add_world_grid(struct lists_context *c, struct world_grid *grid, bool flat) {
    const struct light_input *input = c->input;
    struct world_grid_params params = world_grid_params_default();
    params.flat = flat;
    /* As for pools: a 32nd of the device's memory. */
    params.entry_limit = MIN(params.entry_limit, MAX(gpu_info(c->device)->memory_bytes / 32 / 4, 1u << 18));
    c->lights = world_grid_add(grid, c->graph, c->device, input, local_bounds(c), c->device_scene->sent.lights,
                               &c->device_scene->bounds, &params);
}

static void add_world(struct lists_context *c) { add_world_grid(c, &c->shared->world, false); }
static void add_grid2d(struct lists_context *c) { add_world_grid(c, &c->shared->grid2d, true); }

static void add_mesh(struct lists_context *c) {
    struct lights_in_view visible = in_view(c, false);
    struct mesh_lists_params params = mesh_lists_params_default();
    params.grid = cluster_params(c);
    double pairs = 0;
    if (c->estimates) pairs = light_reach_items(c->view, local_bounds(c), c->input->set.local_count, c->device_scene->scene);
    params.grid.pool_capacity = pool_for(c, pairs);
    c->lights = mesh_lists_add(c->graph, c->device, c->input, &visible, c->scene, &params);
}

_Static_assert((int)BACKFACE_PYRAMID == FNL_BACKFACE_AXIS_MIPS && (int)BACKFACE_SUM == FNL_BACKFACE_AXIS_SUM &&
                   FNL_BACKFACE_AXIS_COUNT == FNL_BACKFACE_AXIS_MIPS + 1,
               "backface_axis has the values of fnl_backface_axis");

static void add_backface(struct lists_context *c) {
    /* No normals are known before shading; and a coat has others, and paper shows lights behind it. */
    if (!c->gbuffer || c->layered) {
        add_tiled(c);
        return;
    }
    struct lights_in_view visible = in_view(c, tile_reaches(c));
    struct backface_params params = backface_params_default();
    params.tiles = tiled_params(c, c->frame->tiles.size, 1);
    params.axis = (enum backface_axis)c->frame->list.backface_axis;
    params.every_tile = c->frame->debug == FNL_DEBUG_TILE_NORMALS;
    params.tally = c->frame->count_lights;
    c->lights = backface_add(c->graph, c->device, c->input, &visible, c->gbuffer, &params);
    add_blend_tiles(c, &visible, &params.tiles);
}

static void mark(struct light_list *list, const struct light_input *input) {
    if (input->scattered && list_kind(list) != GPU_LIST_ALL) list->kind |= GPU_LIST_SCATTERED;
}

static struct light_list add_all_beside(const struct lists_context *c) {
    return light_list_all_add(c->graph, c->device, c->input);
}

struct light_list lists_add_surfaces(const struct lists_context *context) {
    enum { SURFACE_TILE = 8 };
    if (context->frame->lists == FNL_LISTS_ALL) return add_all_beside(context);
    struct light_input input = *context->input;
    struct lists_context c = *context;
    input.queue = GRAPH_QUEUE_GRAPHICS;
    input.keep_unseen = !c.frame->list.frustum_cull;
    input.scattered = false; /* what depth shows is what is looked up */
    c.input = &input;
    c.room = &c.state->surface_room;
    c.estimates = c.estimates && estimates_room(&c);
    graph_push_names(c.graph, "surfaces");
    struct lights_in_view visible = in_view(&c, tile_reaches(&c));
    struct tiled_params params = tiled_params(&c, SURFACE_TILE, 1);
    struct light_list list = tiled_add(c.graph, c.device, &input, &visible, c.depth, &params);
    graph_pop_names(c.graph);
    mark(&list, &input);
    return list;
}

struct light_list lists_add_fallback(const struct lists_context *context) {
    if (context->frame->lists == FNL_LISTS_ALL) return add_all_beside(context);
    struct lists_context copy = *context;
    const struct lists_context *c = &copy;
    struct light_input input = *c->input;
    copy.room = &copy.state->rooms[c->frame->lists];
    input.queue = GRAPH_QUEUE_ASYNC;
    input.keep_unseen = !c->frame->list.frustum_cull;
    input.spheres_only = !c->frame->list.cone_tests;
    input.scattered = c->frame->msaa > 1;
    if (has_fallback(c)) {
        struct light_list again = c->fallback->list;
        again.kind = list_kind(&again);
        mark(&again, &input);
        return again;
    }
    graph_push_names(c->graph, "fallback");
    struct lights_in_view visible = lights_in_view_add(c->graph, c->device, &input);
    struct clustered_params params = cluster_params(c);
    /* These lists are read here and there, at edges, so small cells pay off. Clusters that the frame makes anyway are free and keep their size. */
    if (c->frame->lists != FNL_LISTS_CLUSTERED) params.tile_size = MIN(params.tile_size, (uint32_t)FALLBACK_TILE);
    struct light_list list = input.set.local_count < FALLBACK_TREE_LIGHTS ? clustered_add(c->graph, c->device, &input, &visible, &params)
                                                                      : bvh_add(c->graph, c->device, &input, &visible, &params);
    graph_pop_names(c->graph);
    mark(&list, &input);
    *c->fallback = (struct lists_fallback){list, input.width, input.height};
    return list;
}

/* ---- the table ---- */

enum { FORWARD_ONLY = 1, PREPASS_ONLY = 2, CULLS_ON_CPU = 4 };

/* Each kind of lists except auto: FNL_LISTS_…, and the rest of its row. */
#define BUILDERS(ROW)                                             \
    ROW(ALL, add_all, GRAPHICS, 0)                                \
    ROW(TILED, add_tiled, GRAPHICS, 0)                            \
    ROW(CLUSTERED, add_clustered, ASYNC, 0)                       \
    ROW(CLUSTERED_CPU, add_clustered_cpu, GRAPHICS, CULLS_ON_CPU) \
    ROW(MESH, add_mesh, GRAPHICS, FORWARD_ONLY)                   \
    ROW(BATCHES, add_mesh, GRAPHICS, PREPASS_ONLY)                \
    ROW(MULTIPASS, add_mesh, GRAPHICS, PREPASS_ONLY)              \
    ROW(GRID2D, add_grid2d, GRAPHICS, 0)                          \
    ROW(WORLD, add_world, GRAPHICS, 0)                            \
    ROW(HALFZ, add_halfz, GRAPHICS, 0)                            \
    ROW(25D, add_25d, GRAPHICS, 0)                                \
    ROW(ENHANCED, add_enhanced, ASYNC, 0)                         \
    ROW(TREE, add_tree, GRAPHICS, CULLS_ON_CPU)                   \
    ROW(BACKFACE, add_backface, GRAPHICS, 0)                      \
    ROW(FINE, add_fine, GRAPHICS, 0)                              \
    ROW(SPARSE, add_sparse, GRAPHICS, 0)                          \
    ROW(BVH, add_bvh, ASYNC, 0)                                   \
    ROW(RASTER, add_raster, ASYNC, 0)                             \
    ROW(ZBIN, add_zbin, ASYNC, 0)
#define BUILDER_ROW(lists, add, queue, flags) [FNL_LISTS_##lists] = {add, GRAPH_QUEUE_##queue, flags},
#define COUNT_BUILDER(lists, add, queue, flags) +1
_Static_assert(0 BUILDERS(COUNT_BUILDER) == FNL_LISTS_AUTO, "each kind of lists has its row");

static const struct builder {
    void (*add)(struct lists_context *context);
    enum graph_queue queue; /* async for those that need nothing of the frame: they are built beside the drawing */
    uint32_t flags;
} builders[FNL_LISTS_AUTO] = {BUILDERS(BUILDER_ROW)};

bool fnl_shading_supports(fnl_shading shading, fnl_light_lists lists, uint32_t msaa) {
    if (shading == FNL_SHADING_AUTO) { /* some order */
        bool any = false;
        for (uint32_t i = 0; i < FNL_SHADING_AUTO; i++) any = any || fnl_shading_supports((fnl_shading)i, lists, msaa);
        return any;
    }
    if (msaa != 1 && msaa != 2 && msaa != 4 && msaa != 8) return false;
    if (msaa > 1 && !shading_is(shading, SHADING_SAMPLES)) return false;
    if (lists == FNL_LISTS_AUTO) lists = FNL_LISTS_ALL;
    if ((uint32_t)shading >= FNL_SHADING_COUNT || (uint32_t)lists >= FNL_LISTS_AUTO) return false;
    if (builders[lists].flags & FORWARD_ONLY) return shading_is(shading, SHADING_ITEMS);
    if (builders[lists].flags & PREPASS_ONLY) return shading_is(shading, SHADING_FORWARD | SHADING_PREPASS);
    return true;
}

bool lists_cull_on_cpu(fnl_light_lists lists) { return (builders[lists].flags & CULLS_ON_CPU) != 0; }

void lists_add(struct lists_context *c) {
    const struct builder *builder = &builders[c->frame->lists];
    c->input->scattered = c->of_head || c->frame->msaa > 1;
    c->input->queue = builder->queue;
    c->input->keep_unseen = !c->frame->list.frustum_cull;
    c->blend_lights = (struct light_list){0};
    c->room = &c->state->rooms[c->frame->lists];
    c->estimates = c->estimates && estimates_room(c);
    builder->add(c);
    mark(&c->lights, c->input);
    mark(&c->blend_lights, c->input);
    if (!c->blend_lights.header) c->blend_lights = c->lights;
}
