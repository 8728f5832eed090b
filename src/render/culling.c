/* SPDX-License-Identifier: MIT */
/** What of the opaque scene is drawn, and by which kind of shaders. */
#include "passes/geometry/clusters.h"
#include "passes/geometry/occlusion.h"
#include "passes/geometry/order.h"
#include "render/frame_steps.h"
#include "render/shading.h"
#include "render/step.h"
#include "render/temporal.h"

/* What hides a sample is known for the samples of the frame's own pixels alone. */
bool frame_culls_hidden(const fnl_frame *frame) {
    const bool whole = frame_shows_surfaces(frame) || frame->outputs & FNL_OUTPUT_OBJECT || frame->pixel.asked;
    return frame->occlusion == FNL_OCCLUSION_ON && frame_is(frame, SHADING_FULL_RASTER) && (frame->msaa == 1 || !whole);
}

/*
 * The test draws in two parts and makes a pyramid of depths, which takes the same time in all scenes: it pays where there is much to hide, in parts
 * that can be hidden one by one. Debug views show what is drawn without it; of several views eyes alone are drawn together with it.
 */
fnl_occlusion frame_choose_occlusion(const fnl_renderer *r, const fnl_frame *frame) {
    enum { TRIANGLES = 1000000, PARTS = 256 };
    if (frame->occlusion != FNL_OCCLUSION_AUTO) return frame->occlusion;
    const struct device_scene *d = r->device_scene;
    bool pays = d->triangle_count >= TRIANGLES && d->item_count >= PARTS && (frame_view_count(frame) == 1 || frame->stereo.eyes) && frame->debug == FNL_DEBUG_NONE &&
                frame_far_count(frame) == 0; /* which does not go together with it */
    return pays ? FNL_OCCLUSION_ON : FNL_OCCLUSION_OFF;
}

/*
 * Vertex and mesh shaders put vertices in the same places, but Vulkan does not promise that depths are the same to the bit: all that is drawn of
 * the opaque scene in a frame goes one way or the other. So no pass may have vertex shaders of its own, or a geometry shader.
 */
bool frame_draws_meshes(const fnl_renderer *r, const fnl_frame *frame) {
    const struct renderer_tests tests = renderer_tests(r);
    bool regrouped = frame->lists == FNL_LISTS_BATCHES || frame->lists == FNL_LISTS_MULTIPASS,
         redrawn = frame->decals != FNL_DECALS_OFF && r->device_scene->decals.draw_count > 0;
    bool wanted = frame->geometry == FNL_GEOMETRY_MESH ||
                  (frame->geometry == FNL_GEOMETRY_AUTO && (gpu_info(r->device)->type != FNL_DEVICE_CPU || tests.auto_meshes));
    return wanted && frame->culling != FNL_CULLING_INSTANCES && gpu_info(r->device)->mesh_shader && !tests.no_meshes &&
           !frame_is(frame, SHADING_VERTICES) && !regrouped && !redrawn && !temporal_needs_motion(frame);
}

void frame_cull(struct frame_state *f) {
    graph_set_role(f->graph, GRAPH_ROLE_GEOMETRY);
    const fnl_frame *frame = f->frame;
    const struct renderer_tests tests = renderer_tests(f->r);
    const struct geometry_scene *scene = &f->scene->geometry;
    struct hierarchy occluders = {0};
    if (frame_culls_hidden(frame))
        f->draws = occlusion_add(f->graph, f->r->device, scene, &f->view, f->kept->temporal.valid ? &f->temporal.previous : NULL,
                                 f->view_address, frame->msaa, &occluders);
    else
        f->draws = cull_add(f->graph, scene, f->view_address);
    if (frame->culling == FNL_CULLING_INSTANCES) {
        if (frame->front_to_back) order_front_to_back(f->graph, f->r->device, scene, f->view_address, &f->draws);
        return;
    }
    struct clusters_params params = {.by_triangle = frame->culling == FNL_CULLING_TRIANGLES,
                                     .full_raster = frame_is(frame, SHADING_FULL_RASTER),
                                     .samples = frame->msaa,
                                     .centers = true,
                                     .cluster_capacity = f->r->culling.cluster_capacity,
                                     .pool = f->group.display ? f->view_index % frame->stereo.eyes : 0,
                                     .meshes = frame_draws_meshes(f->r, frame),
                                     .mesh_row = tests.mesh_row ? tests.mesh_row : 65535,
                                     .mesh_rows = tests.mesh_rows ? tests.mesh_rows : 64,
                                     .occluders = occluders.levels.id ? &occluders : NULL};
    clusters_add(f->graph, f->r->device, scene, &f->view, f->view_address, &params, &f->draws);
}

/* ---- the step ---- */

enum { CLUSTER_POOL_START = 1 << 14, TRIANGLE_POOL_START = 1 << 18 };

static fnl_result check(const struct call *call, fnl_renderer *r, const fnl_frame *frame) {
    if (frame->geometry != FNL_GEOMETRY_MESH) return FNL_OK;
    if (!gpu_info(r->device)->mesh_shader || renderer_tests(r).no_meshes)
        return unsupported(call, "this device has no mesh shaders; use geometry=vertex or geometry=auto");
    if (frame->culling == FNL_CULLING_INSTANCES)
        return unsupported(call, "geometry=mesh needs culling=clusters or culling=triangles, not instances");
    return FNL_OK;
}

/* Pools of clusters and triangles grow as far as the scene can fill them. */
static void enlarge(fnl_renderer *r, uint32_t clusters, uint32_t triangles) {
    const struct device_scene *d = r->device_scene;
    if (renderer_tests(r).cluster_limit) return;
    const uint64_t limit = MAX(gpu_info(r->device)->memory_bytes / 128, (uint64_t)CLUSTER_POOL_START);
    const uint64_t cluster_room = MIN(MAX(CLUSTER_POOL_START, clusters + clusters / 4ull), limit);
    uint64_t triangle_room = MIN(MAX(TRIANGLE_POOL_START, triangles + triangles / 4ull), limit);
    triangle_room = MIN(triangle_room, (UINT32_MAX - (uint64_t)d->index_count) / 3);
    r->culling.cluster_capacity = (uint32_t)MAX(MIN(cluster_room, d->cluster_count), (uint64_t)r->culling.cluster_capacity);
    r->culling.triangle_capacity = (uint32_t)MAX(MIN(triangle_room, d->triangle_count), (uint64_t)r->culling.triangle_capacity);
}

static void grow(fnl_renderer *r, const struct frame_counts *counts) {
    const struct gpu_cluster_totals *c = &COUNTS(counts, culling)->clusters;
    enlarge(r, c->clusters, c->triangles);
}

static fnl_result prepare(fnl_renderer *r, const fnl_frame *frame) {
    if (frame->culling == FNL_CULLING_INSTANCES || r->device_scene->triangle_count == 0) return FNL_OK;
    if (r->culling.triangle_capacity == 0) enlarge(r, 0, 0); /* the scene's size is known now */
    if (frame_draws_meshes(r, frame)) return FNL_OK;
    return device_scene_reserve_triangles(&r->scene_user, r->culling.triangle_capacity, frame->view_count > 0 ? MAX(frame->stereo.eyes, 1u) : 1);
}

const struct counter_table counters_culling = {.counts_size = sizeof(struct culling_counts)};

const struct frame_step step_culling = {.name = "culling", .check = check, .prepare = prepare, .grow = grow, .counters = &counters_culling};
