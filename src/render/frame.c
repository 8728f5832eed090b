/* SPDX-License-Identifier: MIT */
/** The whole frame, in order. Read it as a table of contents; docs/overview.md tells the same story in words. */
#include "passes/aa/morphological.h"
#include "passes/geometry/clusters.h"
#include "passes/geometry/occlusion.h"
#include "passes/lights/sprites.h"
#include "passes/post/post.h"
#include "passes/post/post_shared.h"
#include "passes/shade/gbuffer_view.h"
#include "passes/texturing/virtual_view_shared.h"
#include "render/decals.h"
#include "render/shading.h"

static fnl_result add_view(struct frame_state *f) {
    fnl_camera camera = f->frame->camera;
    temporal_begin(f);
    camera.shift.x -= 2 * f->temporal.jitter.x / (float)f->frame->width;
    camera.shift.y += 2 * f->temporal.jitter.y / (float)f->frame->height;
    f->view = view_from_camera(&camera, f->frame->width, f->frame->height);
    f->view.samples = f->frame->msaa;
    f->view.ambient_sky = f->r->scene->ambient_sky;
    f->view.ambient_ground = f->r->scene->ambient_ground;
    shading_begin(f);
    f->view.shade_cost = f->frame->shade_cost;
    f->view.hdr_max = shading_format(f) == VK_FORMAT_R32G32B32A32_SFLOAT ? FLT_MAX : 65504.0f;
    TRY(decals_begin(f));
    struct gpu_slice slice = gpu_frame_allocate(f->r->device, sizeof f->view);
    if (!slice.data) return gpu_status(f->r->device);
    memcpy(slice.data, &f->view, sizeof f->view);
    f->view_address = slice.address;
    f->scene->lights.view = slice.address;
    f->scene->lights.width = f->frame->width;
    f->scene->lights.height = f->frame->height;
    return FNL_OK;
}

/* ---- light lists ---- */

static fnl_result fade_lights(struct frame_state *f) {
    struct device_scene *d = &f->r->device_scene;
    float lod = f->frame->light_lod;
    TRY(device_lights_fade(d, &f->view, lod, lists_cull_on_cpu(f->frame->lists)));
    f->whole_lights = f->scene->lights;
    if (lod > 0) light_fade_add(f->graph, &f->scene->lights, &d->faded_lights, lod);
    return FNL_OK;
}

/* ---- counters ---- */

static void add_counters(struct frame_state *f) {
    if (!f->frame->count_lights && !shading_shows_volumes(f->frame)) return;
    f->counters = f->frame->count_lights
                      ? graph_import_buffer(f->graph, "light counters", &f->r->counters)
                      : graph_create_buffer(f->graph, "light counters", f->frame->width * f->frame->height * 8ull + 4);
    graph_add_clear(f->graph, "clear counters", GRAPH_QUEUE_GRAPHICS, (struct graph_clear){.buffers = {f->counters}});
}

/* ---- the picture ---- */

static bool frame_shows_gbuffer(const fnl_frame *frame) {
    return frame->debug >= FNL_DEBUG_GBUFFER_0 && frame->debug <= FNL_DEBUG_LIT_FORWARD;
}

static bool frame_shows_dais(const fnl_frame *frame) {
    return frame->debug >= FNL_DEBUG_DAIS_ADDRESSES && frame->debug <= FNL_DEBUG_DAIS_FAILURES;
}

static bool frame_shows_atlas(const fnl_frame *frame) {
    return frame->debug == FNL_DEBUG_ATLAS || frame->debug == FNL_DEBUG_PAGES;
}

static bool needs_aov(const fnl_frame *frame) {
    bool own = frame_shows_gbuffer(frame) || frame_shows_dais(frame) || frame_shows_atlas(frame);
    return (frame->debug != FNL_DEBUG_NONE && !own) ||
           (frame->outputs & (FNL_OUTPUT_SURFACE | FNL_OUTPUT_NORMAL | FNL_OUTPUT_POSITION));
}

/* ---- culling ---- */

/* What hides a sample is known for the samples of the frame's own pixels alone. */
static bool culls_hidden(const fnl_frame *frame) {
    return frame->occlusion && frame_is(frame, SHADING_FULL_RASTER) && (frame->msaa == 1 || !needs_aov(frame));
}

/*
 * Vertex and mesh shaders put vertices in the same places, but Vulkan does not promise that depths are the same to the bit: all that is drawn of
 * the opaque scene in a frame goes one way or the other. So no pass may have vertex shaders of its own, or a geometry shader.
 */
bool frame_draws_meshes(const fnl_renderer *r, const fnl_frame *frame) {
    bool regrouped = frame->lists == FNL_LISTS_BATCHES || frame->lists == FNL_LISTS_MULTIPASS,
         redrawn = frame->decals != FNL_DECALS_OFF && r->device_scene.decals.draw_count > 0;
    bool wanted = frame->geometry == FNL_GEOMETRY_MESH ||
                  (frame->geometry == FNL_GEOMETRY_AUTO && (gpu_info(r->device)->type != FNL_DEVICE_CPU || r->auto_meshes));
    return wanted && frame->culling != FNL_CULLING_INSTANCES && gpu_info(r->device)->mesh_shader && !r->no_meshes &&
           !frame_is(frame, SHADING_VERTICES) && !regrouped && !redrawn && !temporal_needs_motion(frame);
}

static void cull(struct frame_state *f) {
    const fnl_frame *frame = f->frame;
    const struct geometry_scene *scene = &f->scene->geometry;
    struct hierarchy occluders = {0};
    if (culls_hidden(frame))
        f->draws = occlusion_add(f->graph, f->r->device, scene, &f->view, f->r->temporal.valid ? &f->r->temporal.view : NULL,
                                 f->view_address, frame->msaa, &occluders);
    else
        f->draws = cull_add(f->graph, scene, f->view_address);
    if (frame->culling == FNL_CULLING_INSTANCES) return;
    struct clusters_params params = {.by_triangle = frame->culling == FNL_CULLING_TRIANGLES,
                                     .full_raster = frame_is(frame, SHADING_FULL_RASTER),
                                     .samples = frame->msaa,
                                     .centers = true,
                                     .cluster_capacity = f->r->cluster_capacity,
                                     .meshes = f->r->meshes,
                                     .mesh_row = f->r->mesh_row ? f->r->mesh_row : 65535,
                                     .mesh_rows = f->r->mesh_rows ? f->r->mesh_rows : 64,
                                     .occluders = occluders.levels.id ? &occluders : NULL};
    clusters_add(f->graph, f->r->device, scene, &f->view, f->view_address, &params, &f->draws);
}

static void add_picture(struct frame_state *f) {
    struct picture picture = frame_picture(f);
    bool linear = picture.tonemap.linear, swap = picture.tonemap.swap, done = f->color.id; /* by the shading order */
    if (!done) f->color = frame_create_image(f, "color", picture.format, 1);
    picture.tonemap.exposure = f->exposure;
    if (f->frame->debug == FNL_DEBUG_NONE) {
        if (!done) tonemap_add(f->graph, f->radiance, f->color, &picture.tonemap);
        struct morphological_params shapes = {linear, swap};
        if (f->frame->aa == FNL_ANTIALIASING_MLAA) f->color = mlaa_add(f->graph, f->color, &shapes);
        if (f->frame->aa == FNL_ANTIALIASING_SMAA) f->color = smaa_add(f->graph, f->color, &shapes);
    } else if (frame_shows_gbuffer(f->frame)) {
        fnl_debug_view view = f->frame->debug;
        if (view <= FNL_DEBUG_GBUFFER_4)
            gbuffer_view_target_add(f->graph, &f->gbuffer, (uint32_t)(view - FNL_DEBUG_GBUFFER_0), f->color, swap);
        else
            gbuffer_view_field_add(f->graph, &f->gbuffer,
                                   view == FNL_DEBUG_MATERIAL_ID ? GBUFFER_SEEN_MATERIAL : GBUFFER_SEEN_FORWARD, f->color,
                                   swap);
    } else if (frame_shows_dais(f->frame)) {
        const struct shade_input input = {.scene = &f->scene->geometry, .view = f->view_address};
        dais_view_add(f->graph, &input, &f->dais, (uint32_t)(f->frame->debug - FNL_DEBUG_DAIS_ADDRESSES), f->color, swap);
    } else if (frame_shows_atlas(f->frame)) {
        uint32_t mode = f->frame->debug == FNL_DEBUG_ATLAS ? VIRTUAL_VIEW_ATLAS : VIRTUAL_VIEW_PAGES;
        virtual_view_add(f->graph, &f->texturing.pages, mode, f->texturing.targets[1], f->depth, f->view_address, f->color,
                         swap);
    } else if (f->frame->debug == FNL_DEBUG_MOTION) {
        motion_view_add(f->graph, f->temporal.motion, f->color, swap);
    } else {
        struct debug_counts counts = {0};
        if (f->frame->debug == FNL_DEBUG_OVERDRAW)
            counts = (struct debug_counts){
                overdraw_add(f->graph, &f->scene->geometry, &f->draws, f->view_address, f->frame->width, f->frame->height),
                1};
        if (f->frame->debug == FNL_DEBUG_OVERSHADING)
            counts = (struct debug_counts){overshading_add(f->graph, &f->scene->geometry, &f->draws, f->view_address,
                                                           f->frame->width, f->frame->height),
                                           1};
        if (f->frame->debug == FNL_DEBUG_CLUSTERS)
            counts = (struct debug_counts){cluster_view_add(f->graph, &f->scene->geometry, &f->draws, f->view_address,
                                                            f->frame->width, f->frame->height),
                                           1};
        if (f->frame->debug == FNL_DEBUG_LAYERS)
            counts = (struct debug_counts){
                layers_add(f->graph, &f->scene->geometry, &f->draws, f->view_address, f->frame->width, f->frame->height), 1};
        if (f->frame->debug == FNL_DEBUG_DECALS) counts = (struct debug_counts){decals_count_add(f), 1};
        if (f->frame->debug == FNL_DEBUG_EDGES && f->surfaces.id) counts = (struct debug_counts){f->surfaces, 1};
        graph_image metal = {0};
        if (f->frame->debug == FNL_DEBUG_HALOS)
            metal = halos_add(f->graph, &f->scene->geometry, &f->draws, f->view_address, f->frame->width, f->frame->height);
        if (f->coarse_words.id) counts = (struct debug_counts){f->coarse_words, 1};
        if (shading_shows_volumes(f->frame)) counts = (struct debug_counts){f->counters, 2};
        debug_view_add(f->graph, (uint32_t)f->frame->debug, &f->aov, &f->lights, counts, metal, f->view_address, f->color,
                       swap);
    }
}

struct copy_image_data {
    graph_image from, to;
};

static void execute_copy_image(const struct graph_context *context, const void *data) {
    const struct copy_image_data *d = data;
    gpu_copy_image(context->commands, graph_get_image(context, d->from), graph_get_image(context, d->to));
}

static void add_target(struct frame_state *f, const struct frame_target *target) {
    struct copy_image_data copy = {
        f->color, graph_import_image(f->graph, target->image, target->initial_layout, target->final_layout)};
    struct graph_pass *pass =
        graph_add_pass(f->graph, "copy to target", GRAPH_QUEUE_GRAPHICS, execute_copy_image, &copy, sizeof copy);
    graph_use_image(pass, copy.from, GRAPH_COPY_FROM);
    graph_use_image(pass, copy.to, GRAPH_COPY_TO);
}

/* ---- what the CPU reads ---- */

static const char *const output_names[OUTPUT_COUNT] = {"read color",  "read radiance", "read surface",
                                                       "read normal", "read position", "read motion"};

struct read_image_data {
    graph_image image;
    graph_buffer buffer;
};

static void execute_read_image(const struct graph_context *context, const void *data) {
    const struct read_image_data *d = data;
    gpu_copy_image_to_buffer(context->commands, graph_get_image(context, d->image), graph_get_buffer(context, d->buffer), 0);
}

static void execute_nothing(const struct graph_context *context, const void *data) {
    UNUSED(context);
    UNUSED(data);
}

/* Copies results into host-visible buffers; one last pass makes them visible to the CPU. */
static void add_outputs(struct frame_state *f) {
    graph_image images[OUTPUT_COUNT] = {f->color,      f->radiance,     f->aov.albedo,
                                        f->aov.normal, f->aov.position, f->temporal.motion};
    if (f->frame->msaa > 1 && (f->frame->outputs & FNL_OUTPUT_RADIANCE)) {
        images[1] = frame_create_image(f, "radiance average", VK_FORMAT_R32G32B32A32_SFLOAT, 1);
        resolve_add(f->graph, f->radiance, images[1]);
    }
    graph_buffer buffers[OUTPUT_COUNT] = {0};
    for (uint32_t i = 0; i < OUTPUT_COUNT; i++) {
        if (!(f->frame->outputs & 1u << i)) continue;
        struct read_image_data data = {images[i], graph_import_buffer(f->graph, output_names[i], &f->r->outputs[i])};
        struct graph_pass *pass =
            graph_add_pass(f->graph, output_names[i], GRAPH_QUEUE_GRAPHICS, execute_read_image, &data, sizeof data);
        graph_use_image(pass, data.image, GRAPH_COPY_FROM);
        graph_use_buffer(pass, data.buffer, GRAPH_COPY_TO);
        buffers[i] = data.buffer;
    }
    struct graph_pass *host = graph_add_pass(f->graph, "to host", GRAPH_QUEUE_GRAPHICS, execute_nothing, NULL, 0);
    graph_keep(host);
    for (uint32_t i = 0; i < OUTPUT_COUNT; i++)
        if (buffers[i].id) graph_use_buffer(host, buffers[i], GRAPH_READ_HOST);
}

struct count_copy {
    graph_buffer from, to;
    uint64_t from_offset, to_offset, size;
};
struct counts_data {
    struct count_copy copies[16]; /* more than there are kinds of counts */
    uint32_t count;
};

static void execute_counts(const struct graph_context *context, const void *data) {
    const struct counts_data *d = data;
    for (uint32_t i = 0; i < d->count; i++) {
        const struct count_copy *c = &d->copies[i];
        gpu_copy_buffer(context->commands, graph_get_buffer(context, c->from), c->from_offset,
                        graph_get_buffer(context, c->to), c->to_offset, c->size);
    }
}

/* Exact counts of this very frame. */
static void add_counts(struct frame_state *f) {
    uint32_t slot = gpu_frame_slot(f->r->device);
    graph_buffer counts = graph_import_buffer(f->graph, "frame counts", &f->r->counts[slot]), draws = {0};
    struct counts_data data = {.count = 1};
    data.copies[0] = (struct count_copy){f->draws.sums, counts, f->scene->geometry.item_count * 4ull,
                                         offsetof(struct frame_counts, visible_items), 4};
    if (f->lights.totals.id)
        data.copies[data.count++] = (struct count_copy){f->lights.totals, counts, 0, offsetof(struct frame_counts, lights),
                                                        sizeof(struct light_totals)};
    if (f->blend_lights.totals.id && f->blend_lights.totals.id != f->lights.totals.id)
        data.copies[data.count++] = (struct count_copy){
            f->blend_lights.totals, counts, 0, offsetof(struct frame_counts, blend_lights), sizeof(struct light_totals)};
    if (f->class_counts.id)
        data.copies[data.count++] = (struct count_copy){f->class_counts, counts, 0, offsetof(struct frame_counts, blocks),
                                                        sizeof f->r->stats.shading_blocks};
    if (f->edge_counts.id)
        data.copies[data.count++] =
            (struct count_copy){f->edge_counts, counts, 0, offsetof(struct frame_counts, edges), EDGES_COUNTS * 4};
    if (f->visible_ranges.id)
        data.copies[data.count++] = (struct count_copy){f->visible_ranges, counts, 0, offsetof(struct frame_counts, visible),
                                                        sizeof(((struct frame_counts *)0)->visible)};
    if (f->coarse_counts.id)
        data.copies[data.count++] =
            (struct count_copy){f->coarse_counts, counts, 0, offsetof(struct frame_counts, coarse), COARSE_COUNTS * 4};
    if (f->visible_fragments.id)
        data.copies[data.count++] =
            (struct count_copy){f->visible_fragments, counts, 0, offsetof(struct frame_counts, visible_fragments), 4};
    if (f->dais.counts.id)
        data.copies[data.count++] =
            (struct count_copy){f->dais.counts, counts, 0, offsetof(struct frame_counts, dais), DAIS_COUNTS * 4};
    if (f->lights.culled.id)
        data.copies[data.count++] =
            (struct count_copy){f->lights.culled, counts, 0, offsetof(struct frame_counts, lights_behind), 4};
    if (f->decals.list.totals.id)
        data.copies[data.count++] = (struct count_copy){f->decals.list.totals, counts, 0,
                                                        offsetof(struct frame_counts, decals), sizeof(struct light_totals)};
    if (f->decals.fragments.id)
        data.copies[data.count++] =
            (struct count_copy){f->decals.fragments, counts, 0, offsetof(struct frame_counts, decal_fragments), 12};
    if (f->draws.totals.id)
        data.copies[data.count++] = (struct count_copy){f->draws.totals, counts, 0, offsetof(struct frame_counts, clusters),
                                                        sizeof(struct gpu_cluster_totals)};
    if (f->draws.hidden.id)
        data.copies[data.count++] = (struct count_copy){f->draws.hidden, counts, f->scene->geometry.item_count * 4ull,
                                                        offsetof(struct frame_counts, hidden_items), 4};
    if (f->linked.totals.id)
        data.copies[data.count++] = (struct count_copy){f->linked.totals, counts, 0, offsetof(struct frame_counts, blend),
                                                        sizeof(struct linked_totals)};
    if (f->page_commands.id)
        data.copies[data.count++] = (struct count_copy){f->page_commands, counts, 16, offsetof(struct frame_counts, pages),
                                                        sizeof(struct gpu_virtual_counts)};
    if (f->exposure.id)
        data.copies[data.count++] = (struct count_copy){f->exposure, counts, 0, offsetof(struct frame_counts, exposure), 8};
    if (f->frame->count_lights) {
        draws = graph_import_buffer(f->graph, "read draws", &f->r->draws);
        data.copies[data.count++] = (struct count_copy){f->draws.draws, draws, 0, 0,
                                                        MAX(f->scene->geometry.group_count, 1u) * sizeof(struct gpu_draw)};
    }
    struct graph_pass *pass =
        graph_add_pass(f->graph, "read counts", GRAPH_QUEUE_GRAPHICS, execute_counts, &data, sizeof data);
    for (uint32_t i = 0; i < data.count; i++) graph_use_buffer(pass, data.copies[i].from, GRAPH_COPY_FROM);
    graph_use_buffer(pass, counts, GRAPH_COPY_TO);
    if (draws.id) graph_use_buffer(pass, draws, GRAPH_COPY_TO);
    struct graph_pass *host = graph_add_pass(f->graph, "counts to host", GRAPH_QUEUE_GRAPHICS, execute_nothing, NULL, 0);
    graph_keep(host);
    graph_use_buffer(host, counts, GRAPH_READ_HOST);
    if (draws.id) graph_use_buffer(host, draws, GRAPH_READ_HOST);
    if (f->frame->count_lights) graph_use_buffer(host, f->counters, GRAPH_READ_HOST);
}

/* What is known before the GPU has run. */
static void note_stats(struct frame_state *f) {
    fnl_renderer *r = f->r;
    const struct geometry_scene *scene = &f->scene->geometry;
    fnl_frame_stats *s = &r->stats;
    const struct light_input *lights = &f->scene->lights;
    *s = (fnl_frame_stats){.lights_total = lights->local_count - lights->unlit_count + lights->directional_count,
                           .items = scene->item_count,
                           .triangles_total = scene->triangle_count,
                           .clusters_total = scene->cluster_count,
                           .geometry = f->draws.mesh_draws.id ? FNL_GEOMETRY_MESH : FNL_GEOMETRY_VERTEX,
                           .lists = f->drawn_lists};
    bool second = f->blend_lights.header != f->lights.header;
    s->list_bytes = f->lights.byte_count + (second ? f->blend_lights.byte_count : 0);
    s->cells = f->lights.cell_count + (second ? f->blend_lights.cell_count : 0);
    s->draws = shading_draw_count(f);
    r->forward_layouts = f->forward_layouts;
    s->gbuffer_bytes = shading_gbuffer_bytes(f);
    if (f->page_commands.id) {
        s->atlas_bytes = r->atlas.bytes;
        s->atlas_pages = r->atlas.page_count;
        s->atlas_capacity = r->atlas.across * r->atlas.across;
    }
    s->light_bytes = f->light_bytes;
    s->light_draws = f->light_draws;
    s->decals_total = f->decals.set ? f->r->device_scene.decals.order.count : 0;
    s->blend_bytes = f->blend_bytes;
    if (f->frame->exposure == FNL_EXPOSURE_EV) s->ev = f->frame->ev;
    s->mobile_merged = f->mobile_merged;
    s->mobile_tonemapped = f->mobile_merged && f->mobile_tonemapped;
    r->fixed_bytes = f->lights.fixed_bytes + (second ? f->blend_lights.fixed_bytes : 0);
    r->entry_bytes = f->lights.entry_bytes;
    r->blend_entry_bytes = f->blend_lights.entry_bytes;
    r->totals_known = f->lights.totals_known;
    r->known_totals = f->lights.known;
}

fnl_result frame_declare(fnl_renderer *r, const fnl_frame *frame, const struct frame_target *target) {
    struct frame_state f = {
        .r = r, .frame = frame, .graph = r->graph, .scene = &r->scene_frame, .drawn_lists = frame->lists, .target = target};
    graph_begin(r->graph);
    TRY(device_scene_add(&r->device_scene, r->graph, f.scene));
    TRY(add_view(&f));
    TRY(decals_add_list(&f));
    TRY(fade_lights(&f));
    cull(&f);
    add_counters(&f);
    shading_add(&f);
    if (needs_aov(frame))
        f.aov = aov_add(r->graph, &f.scene->geometry, &f.draws, f.view_address, frame->width, frame->height);
    bool wants_color = target || (frame->outputs & FNL_OUTPUT_COLOR);
    if (frame->exposure == FNL_EXPOSURE_AUTO && (wants_color || frame->aa == FNL_ANTIALIASING_TAA))
        f.exposure = exposure_add(f.graph, f.radiance);
    temporal_add(&f);
    if (wants_color) add_picture(&f);
    if (target) add_target(&f, target);
    add_outputs(&f);
    add_counts(&f);
    note_stats(&f);
    temporal_end(&f);
    return graph_compile(r->graph);
}
