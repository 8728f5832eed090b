/* SPDX-License-Identifier: MIT */
#include "render/decals.h"

#include "passes/decals/decals.h"
#include "passes/decals/decals_gbuffer.h"
#include "passes/decals/decals_redraw.h"
#include "passes/lights/bvh.h"
#include "render/step.h"
#include "render/surfaces.h"
#include "render/traits.h"

/* Of the list, and of decals over the G-buffer. */
struct decals_counts {
    struct light_totals list;
    struct decals_gbuffer_totals gbuffer;
};
static const struct counter_table counters_decals;

static const struct device_decals *decals_of(const struct frame_state *f) { return &f->r->device_scene->decals; }
static bool is_on(const struct frame_state *f) {
    return f->frame->decals != FNL_DECALS_OFF && decals_of(f)->order.count > 0;
}

bool decals_in_gbuffer(const struct frame_state *f) {
    if (!is_on(f) || decals_of(f)->count == 0 || f->frame->decals != FNL_DECALS_GBUFFER || f->frame->msaa > 1) return false;
    if (frame_is(f->frame, SHADING_DECAL_STEP) && decals_of(f)->masks) return false;
    return frame_is(f->frame, SHADING_DECALS);
}

/* The log is told once by each renderer. */
static void tell_of_lists(struct frame_state *f) {
    const fnl_frame *frame = f->frame;
    if (frame->decals != FNL_DECALS_GBUFFER || decals_of(f)->count == 0 || decals_in_gbuffer(f)) return;
    if (!FRAME_TELLS(f, decal_lists)) return;
    if (frame->msaa > 1)
        log_warning(&f->r->host, "decals=gbuffer needs 1 sample per pixel: with %u samples, lists are used", frame->msaa);
    else
        log_warning(&f->r->host, "decals=gbuffer does not work with %s shading: lists are used",
                    fnl_value_name(FNL_ENUM_SHADING, frame->shading));
}

/* Uploads changed decals. */
static fnl_result begin_frame(struct frame_state *shared) {
    if (!is_on(shared)) return FNL_OK;
    tell_of_lists(shared);
    return device_decals_add(shared->r->device_scene, shared->graph, &shared->decals.buffers);
}

/* As for the clusters of lights: slices reach as far as the scene does. */
static struct clustered_params cluster_params(const struct frame_state *f) {
    struct clustered_params params = clustered_params_default();
    float far = view_reach(&f->view, &f->r->device_scene->bounds);
    params.far = fminf(far, 1e6f);
    params.near = fminf(fmaxf(f->frame->camera.near_distance, params.far / 128), params.far * 0.5f);
    params.tile_size = 32;
    params.cone_tests = false;
    params.pool_capacity = f->r->decals.capacity;
    return params;
}

static bool needs_list(const struct frame_state *f) {
    if (decals_of(f)->count == 0) return false;
    if (frame_is(f->frame, SHADING_DECAL_STEP)) return true;
    /* Materials that a layout cannot hold are lit forward. */
    if (surfaces_layout(f) != FNL_GBUFFER_DEFAULT) return true;
    if (!decals_in_gbuffer(f) || f->frame->debug != FNL_DEBUG_NONE || f->frame->outputs & FNL_OUTPUT_SURFACE) return true;
    return surfaces_have_blend(f);
}

static void add_list(struct frame_state *f) {
    const struct device_decals *all = decals_of(f);
    counters_note(f, "decals.total", all->order.count);
    struct geometry_scene *geometry = &f->scene->geometry;
    struct frame_decals *d = &f->decals;
    struct light_input input = {.set = {.buffer = d->buffers.bounds, .entities = all->bounds.address, .local_count = all->count},
                                .kinds = 1u << GPU_ENTITY_DECAL,
                                .view = f->view_address,
                                .width = f->frame->width,
                                .height = f->frame->height,
                                .spheres_only = true,
                                .queue = GRAPH_QUEUE_ASYNC};
    d->input = input;
    if (all->count) d->in_view = lights_in_view_add(f->graph, f->r->device, &input);
    *d->set = (struct gpu_decal_set){.decals = all->decals.address,
                                     .mesh_ranges = all->mesh_ranges.address,
                                     .mesh_ids = all->mesh_ids.address,
                                     .count = all->count,
                                     .sampler_index = all->sampler,
                                     .in_gbuffer = decals_in_gbuffer(f),
                                     .mip_fix = f->frame->decal_mip_fix};
    geometry->features |= all->mesh_count ? GPU_FEATURE_MESH_DECALS : 0;
    if (all->count + all->mesh_count) geometry->features |= GPU_FEATURE_LEANING; /* their normal maps */
    const graph_buffer uses[] = {d->buffers.decals, d->buffers.mesh_ranges, d->buffers.mesh_ids};
    memcpy(geometry->feature_buffers, uses, sizeof uses);
    if (!needs_list(f)) return;
    struct clustered_params params = cluster_params(f);
    d->list = all->count < f->r->decals.tree_from ? clustered_add(f->graph, f->r->device, &input, &d->in_view, &params)
                                            : bvh_add(f->graph, f->r->device, &input, &d->in_view, &params);
    COUNTERS_COPY(f, d->list.totals, 0, decals, list);
    d->set->list = d->list.header;
    geometry->features |= GPU_FEATURE_DECALS;
    geometry->feature_buffers[3] = d->list.cells;
    geometry->feature_buffers[4] = d->list.ids;
    geometry->feature_buffers[5] = d->list.spare;
}

/* The list over the boxes of decals, and what shaders of the scene need for them. */
static fnl_result begin_view(struct frame_state *f) {
    if (!is_on(f)) return FNL_OK;
    struct gpu_slice slice = gpu_frame_allocate(f->r->device, sizeof(struct gpu_decal_set));
    if (!slice.data) return gpu_status(f->r->device);
    f->decals.set = slice.data;
    f->decals.set_address = slice.address;
    f->view.decals = (uvec2){(uint32_t)slice.address, (uint32_t)(slice.address >> 32)};
    graph_set_role(f->graph, GRAPH_ROLE_SHADING);
    graph_push_names(f->graph, "decals");
    add_list(f);
    graph_pop_names(f->graph);
    return FNL_OK;
}

graph_buffer decals_count_add(struct frame_state *f) {
    if (!f->decals.list.header) return (graph_buffer){0};
    struct decals_count_input input = {.list = &f->decals.list,
                                       .decals = f->decals.buffers.decals,
                                       .position = f->nearest.aov.position,
                                       .normal = f->nearest.aov.normal,
                                       .view = f->view_address,
                                       .width = f->frame->width,
                                       .height = f->frame->height};
    return decals_count_pass_add(f->graph, &input);
}

void decals_on_gbuffer_add(struct frame_state *f, const struct shade_input *input, const struct gbuffer *gbuffer) {
    if (!decals_in_gbuffer(f)) return;
    struct decals_gbuffer_input decals = {.boxes = f->decals.input,
                                          .in_view = f->decals.in_view,
                                          .decals = f->decals.buffers.decals,
                                          .set = f->decals.set_address,
                                          .emits = decals_of(f)->emits,
                                          .mip_fix = f->frame->decal_mip_fix,
                                          .pool_capacity = f->r->decals.capacity};
    graph_buffer totals = decals_gbuffer_add(f->graph, f->r->device, input, &decals, gbuffer, f->radiance);
    COUNTERS_COPY(f, totals, 0, decals, gbuffer);
}

bool decals_redraws(const struct frame_state *f) { return is_on(f) && decals_of(f)->draw_count > 0; }

void decals_redraw(struct frame_state *f, const struct shade_input *input) {
    const struct device_decals *all = decals_of(f);
    if (!is_on(f) || all->draw_count == 0) return;
    struct decals_redraw redraw = {.indices = &all->redraw_indices,
                                   .draws = f->decals.buffers.redraw_draws,
                                   .draw_count = all->draw_count,
                                   .table = all->redraw_table.address,
                                   .set = f->decals.set_address,
                                   .decals = f->decals.buffers.decals};
    decals_redraw_add(f->graph, input, &redraw, f->radiance, f->depth);
}

/* ---- numbers ---- */

/* Decals in lists, or decals over the G-buffer. */
static bool has_boxes(const struct counted *counted) { return COUNTED_HAS(counted, decals, list) || COUNTED_HAS(counted, decals, gbuffer); }
static bool find_in_view(const struct counted *counted, uint64_t *value) {
    const struct decals_counts *c = COUNTS(counted->counts, decals);
    *value = MAX(c->list.in_view, c->gbuffer.in_view);
    return has_boxes(counted);
}
static bool find_entries(const struct counted *counted, uint64_t *value) {
    const struct decals_counts *c = COUNTS(counted->counts, decals);
    *value = (uint64_t)c->list.entries + c->gbuffer.entries;
    return has_boxes(counted);
}
static bool find_overflow(const struct counted *counted, uint64_t *value) {
    const struct decals_counts *c = COUNTS(counted->counts, decals);
    *value = (uint64_t)c->list.overflow_cells + c->gbuffer.overflow_pixels;
    return has_boxes(counted);
}

static const struct counter rows[] = {
    {"decals.total", "decals", "decals that are shown, without baked ones", NOTED},
    {"decals.in-view", "decals", "boxes and volumes whose bounds touch the view", .find = find_in_view},
    {"decals.entries", "", "entries of the decal list, or of the tiles of decals over the G-buffer", .find = find_entries},
    {"decals.overflow", "", "cells, or pixels, that tested all decals because the pool was too small",
     .find = find_overflow, .kind = FNL_COUNTER_OVERFLOW},
};
static const struct counter_table counters_decals = COUNTER_TABLE_COUNTED(rows, decals);

/* ---- the step ---- */

enum { POOL_START = 1 << 17, POOL_LIMIT = 1 << 28 };

static void init(fnl_renderer *r) {
    r->decals.capacity = POOL_START;
    r->decals.tree_from = 1024; /* from about there on, each cell asking each box costs more than making the tree */
}

/* Entries of the list, or fragments of the G-buffer's way. */
static void grow(fnl_renderer *r, const struct frame_counts *counts) {
    const struct decals_counts *c = COUNTS(counts, decals);
    const uint64_t needed = MAX(c->list.entries, c->gbuffer.entries), limit = MIN(gpu_info(r->device)->memory_bytes / 32, (uint64_t)POOL_LIMIT);
    if (needed > r->decals.capacity) r->decals.capacity = (uint32_t)MIN(needed + needed / 4, MAX(limit, (uint64_t)POOL_START));
}

const struct frame_step step_decals = {.name = "decals", .init = init, .begin_frame = begin_frame, .begin_view = begin_view, .grow = grow, .counters = &counters_decals};
