/* SPDX-License-Identifier: MIT */
#include "render/shadows.h"

#include "passes/shadow/dark.h"
#include "passes/shadow/fill.h"
#include "passes/shadow/guide.h"
#include "passes/shadow/maps.h"
#include "render/orders/order.h"
#include "render/probes.h"
#include "render/surfaces.h"
#include "render/temporal.h"
#include "render/step.h"

/* ---- what finds them ---- */

static uint64_t row_count(const fnl_renderer *r) {
    return r->scene->suns.count * (uint64_t)SHADOW_SUN_ROWS + r->scene->light_slot_end;
}

static bool takes_maps(const fnl_frame *frame) { return frame->shadows == FNL_SHADOWS_MAPS || frame->shadows == FNL_SHADOWS_HYBRID; }

/* More rows of maps than there is room for: rays find all shadows. */
static bool has_maps(const fnl_renderer *r, const fnl_frame *frame) {
    const uint64_t rows = row_count(r);
    return takes_maps(frame) && gpu_info(r->device)->clip_distances && rows > 0 && rows <= SHADOW_MOST_ROWS;
}

static uint32_t atlas_side(const fnl_frame *frame) {
    const double cells = frame->shadow.memory * (1048576.0 / (SHADOW_PAGE * SHADOW_PAGE * 4));
    return SHADOW_PAGE * (uint32_t)sqrt(cells);
}

/* Lights that cast shadows and have no maps: capsules and rectangles. */
static bool has_mapless(fnl_renderer *r) {
    const fnl_scene *scene = r->scene;
    if (r->mapless_version == scene->light_version + 1) return r->mapless;
    r->mapless = false;
    for (uint32_t i = 0; i < scene->lights.count && !r->mapless; i++) {
        const fnl_light_params *light = &scene->lights.data[i].params;
        r->mapless = light->casts_shadows && (light->kind == FNL_LIGHT_CAPSULE || light->kind == FNL_LIGHT_RECTANGLE);
    }
    r->mapless_version = scene->light_version + 1;
    return r->mapless;
}

/* Whether rays find some shadows: those of capsules and rectangles, and of any light where the atlas may not hold the coarsest pages of all; or are compared
   with maps. */
static bool has_traced(fnl_renderer *r, const fnl_frame *frame) {
    if (frame->shadows == FNL_SHADOWS_RAYS || frame->shadows == FNL_SHADOWS_HYBRID || !has_maps(r, frame) || frame->debug == FNL_DEBUG_SHADOW_ERRORS) return true;
    const uint64_t cells = atlas_side(frame) / SHADOW_PAGE, smallest = SHADOW_PAGE / SHADOW_UNIT;
    return has_mapless(r) || row_count(r) * SHADOW_FACES > cells * cells * smallest * smallest;
}

/* Whether rays go through the device's own structures. `auto` walks the trees on the CPU, where no hardware helps. */
static bool queries(const fnl_renderer *r, const fnl_frame *frame) {
    const fnl_device_info *info = gpu_info(r->device);
    if (frame->shadows == FNL_SHADOWS_CUBEMAP) return false; /* the trees know what moves, and what is a wall */
    if (!info->ray_query || r->device_scene->item_count > RAY_QUERY_MOST_ITEMS) return false;
    return frame->shadow.ray_backend == FNL_RAY_BACKEND_RAY_QUERY ||
           (frame->shadow.ray_backend == FNL_RAY_BACKEND_AUTO && info->type != FNL_DEVICE_CPU);
}

static struct device_rays_use rays_use_of(fnl_renderer *r, const fnl_frame *frame) {
    const bool traces = has_traced(r, frame), query = traces && queries(r, frame);
    return (struct device_rays_use){.trees = traces && !query, .query = query, .items = has_maps(r, frame)};
}

fnl_result shadows_prepare_view(fnl_renderer *r, const fnl_frame *frame, struct renderer_view *view) {
    if (!has_maps(r, frame)) return FNL_OK;
    const struct device_scene *d = r->device_scene;
    const uint64_t drawn[] = {d->material_version, d->texture_version, d->arrived_before + d->arrived.count, d->ray_key},
                   placed[] = {d->structure_version, d->scene->transform_version};
    struct renderer_shadows *s = &view->shadows;
    const uint64_t bytes = shadow_fill_kept_bytes(d->item_count);
    s->all_changed |= memcmp(drawn, s->drawn, sizeof drawn) != 0 || s->kept.size < bytes;
    s->moved |= memcmp(placed, s->placed, sizeof placed) != 0;
    memcpy(s->drawn, drawn, sizeof drawn);
    memcpy(s->placed, placed, sizeof placed);
    if (s->kept.size < bytes) {
        gpu_buffer_destroy(r->device, &s->kept);
        TRY(gpu_buffer_create_for(r->device, GPU_USE_SHADOWS, "shadow items", bytes + bytes / 4, GPU_MEMORY_DEVICE, &s->kept));
    }
    return shadow_pages_prepare(r->device, &s->pages, (uint32_t)row_count(r), atlas_side(frame));
}

/* Once for each renderer. */
static void tell_of_rays(fnl_renderer *r) {
    if (r->told_of_maps) return;
    r->told_of_maps = true;
    if (!gpu_info(r->device)->clip_distances)
        log_warning(&r->host, "shadows: this device has no clip_distances, which maps need: rays find all shadows");
    else
        log_warning(&r->host, "shadows: the scene has %u local and %u directional lights, more than may have maps: rays find all shadows",
                    r->scene->light_slot_end, r->scene->suns.count);
}

static void tell_of_trees(fnl_renderer *r) {
    if (r->told_of_trees) return;
    r->told_of_trees = true;
    if (!gpu_info(r->device)->ray_query)
        log_warning(&r->host, "shadows: this device has no ray_query, which shadow.ray-backend=ray-query needs: rays go through bounding volume hierarchies");
    else
        log_warning(&r->host, "shadows: the scene has %u items, more than ray queries can number: rays go through bounding volume hierarchies",
                    r->device_scene->item_count);
}

static fnl_result prepare(fnl_renderer *r, const fnl_frame *frame) {
    if (frame->shadows == FNL_SHADOWS_OFF) return FNL_OK;
    const struct device_rays_use use = rays_use_of(r, frame);
    if (use.trees && frame->shadow.ray_backend == FNL_RAY_BACKEND_RAY_QUERY) tell_of_trees(r);
    if (takes_maps(frame) && row_count(r) > 0 && !has_maps(r, frame)) tell_of_rays(r);
    TRY(device_rays_prepare(r->device_scene, use));
    if (frame->shadows == FNL_SHADOWS_CUBEMAP) TRY(probes_prepare(r));
    return shadows_prepare_view(r, frame, &r->views.data[0]);
}

void shadows_begin(struct frame_state *shared, struct device_scene_frame *scene) {
    if (shared->frame->shadows == FNL_SHADOWS_OFF) return;
    const struct device_rays_use use = rays_use_of(shared->r, shared->frame);
    shared->rays = device_rays_add(shared->r->device_scene, shared->graph, &scene->geometry, use);
    if (use.trees || use.query) scene->lights.rays = shared->rays;
    if (shared->frame->shadows == FNL_SHADOWS_CUBEMAP) probes_add(shared, scene);
    scene->lights.soft = shared->frame->shadow.samples > 1;
    scene->lights.filtered = shared->frame->shadow.filter != FNL_SHADOW_FILTER_HARD;
}

/* ---- maps ---- */

/* What is shaded without a depth that is known before gets one for this alone. */
static graph_image depth_of(struct frame_state *f) {
    if (frame_is(f->frame, SHADING_PREPASS) || shading_order(f->frame->shading)->draw) return f->depth;
    graph_image depth = frame_create_image(f, "shadow depth", GEOMETRY_DEPTH_FORMAT, f->frame->msaa);
    geometry_depth_add(f->graph, "shadow depth", &f->scene->geometry, &f->draws, f->view_address, depth);
    return depth;
}

/* ---- hybrid ---- */

static float page_rays(const fnl_renderer *r, const fnl_frame *frame) {
    if (frame->shadow.page_rays > 0) return frame->shadow.page_rays;
    return shadow_costs_page_rays(&r->shadow_costs, gpu_info(r->device)->type == FNL_DEVICE_CPU);
}

bool shadows_timed(const fnl_frame *frame) { return frame->shadows == FNL_SHADOWS_HYBRID && !(frame->shadow.page_rays > 0) && !frame->count_lights; }

static bool ends_with(const char *name, const char *end) {
    const size_t length = strlen(name), most = strlen(end);
    return length >= most && strcmp(name + length - most, end) == 0;
}

void shadows_note(fnl_renderer *r, uint32_t slot) {
    const struct frame_counts *counts = r->counts[slot].mapped;
    for (uint32_t i = 0; i < r->slot_views[slot]; i++) {
        const struct gpu_shadow_counts *c = &counts[i].shadows;
        if ((c->drawn | c->evicted | c->pairs) == 0) r->views.data[i].shadows.settled = r->slot_frames[slot];
    }
    r->shadow_counts.frame = r->shadow_counts.drawn = 0;
    if (r->slot_views[slot] == 0 || counts->split.maps + counts->split.rays == 0) return;
    r->shadow_counts.frame = r->slot_frames[slot];
    r->shadow_counts.probed = counts->split.probed;
    for (uint32_t i = 0; i < r->slot_views[slot]; i++) r->shadow_counts.drawn += counts[i].shadows.drawn;
}

static void submitted(fnl_renderer *r, const fnl_frame *frame) {
    UNUSED(frame);
    const struct graph_timer *timers;
    uint32_t count;
    if (r->shadow_counts.frame == 0 || !graph_query_timers(r->graph, r->shadow_counts.frame, &timers, &count)) return;
    double fill = 0, probe = 0;
    for (uint32_t i = 0; i < count; i++) {
        if (ends_with(timers[i].name, "shadow fill")) fill += timers[i].milliseconds;
        if (ends_with(timers[i].name, "shadow probe")) probe += timers[i].milliseconds;
    }
    shadow_costs_feed(&r->shadow_costs, (struct shadow_times){fill, r->shadow_counts.drawn, probe, r->shadow_counts.probed});
}

/* ---- auto ---- */

enum { FEW_LIGHTS = 4, FILTERED_LIGHTS = 8 };

void shadows_settle(const fnl_renderer *r, fnl_frame *frame) {
    const fnl_scene *scene = r->scene;
    const fnl_device_info *info = gpu_info(r->device);
    const uint32_t count = scene->suns.count + scene->light_slots.count - scene->free_light_slots.count;
    if (count == 0 && takes_maps(frame) && frame->debug == FNL_DEBUG_NONE) frame->shadows = FNL_SHADOWS_OFF; /* without a pass, or code in shaders */
    if (frame->shadow.filter == FNL_SHADOW_FILTER_AUTO) frame->shadow.filter = count <= FILTERED_LIGHTS ? FNL_SHADOW_FILTER_PCF : FNL_SHADOW_FILTER_HARD;
    if (frame->shadows != FNL_SHADOWS_AUTO) return;
    const bool moves = r->moving_frames > 0 || (r->frame_number > 0 && r->light_version != scene->light_version);
    frame->shadows = FNL_SHADOWS_MAPS;
    if (count == 0)
        frame->shadows = FNL_SHADOWS_OFF;
    else if (!has_maps(r, frame) || (count <= FEW_LIGHTS && info->ray_query && info->type != FNL_DEVICE_CPU))
        frame->shadows = FNL_SHADOWS_RAYS;
    else if (moves && scene->lights.count > 0)
        frame->shadows = FNL_SHADOWS_HYBRID;
}

/* Lists with which nothing is shaded; requests must know of filters. */
static struct light_list without_shadows(struct light_list list) {
    list.kind &= ~GPU_LIST_SHADOWED | GPU_LIST_FILTERED;
    list.rays = (struct rays){0};
    list.maps = (struct shadow_maps){0};
    return list;
}

/* Adds the pages that a view asks for to `wanted`; id 0: makes that. */
static void add_requests(struct frame_state *f, graph_buffer suns, graph_image depth, const struct light_list *surfaces, graph_buffer *wanted) {
    struct light_list list = without_shadows(*surfaces);
    COUNTERS_COPY(f, list.totals, 0, surface_lights);
    const bool splits = f->frame->shadows == FNL_SHADOWS_HYBRID;
    if (wanted->id)
        shadow_requests_more_add(f->graph, &list, suns, *wanted, depth, splits);
    else
        *wanted = shadow_requests_add(f->graph, &list, suns, shadow_row_count(&f->scene->lights), depth, splits);
    const struct geometry_scene *scene = &f->scene->geometry;
    const bool blend = surfaces_have_blend(f), glass = surfaces_have_glass(f);
    if (blend || glass) list = without_shadows(order_add_fallback_lists(f)); /* in front of what depth shows */
    if (blend) shadow_requests_blend_add(f->graph, &list, suns, *wanted, scene, &f->draws, false, f->view_address, depth, splits);
    if (glass) shadow_requests_blend_add(f->graph, &list, suns, *wanted, scene, &f->draws, true, f->view_address, depth, splits);
}

/* What the next frames decide by. */
static void add_split(struct frame_state *f, const struct shadow_pages *pages, const struct shadow_fill *filled, const struct light_list *surfaces, graph_image depth) {
    struct shadow_costs *costs = &f->r->shadow_costs;
    shadow_drawn_add(f->graph, pages, filled);
    if (f->view_index == 0 && f->frame->msaa == 1 && shadows_timed(f->frame) && shadow_costs_probe(costs))
        shadow_probe_add(f->graph, pages, surfaces, depth, costs->frames);
    COUNTERS_COPY(f, pages->split_counts, 0, split);
    counters_note(f, "shadows.page-rays", (uint64_t)lroundf(page_rays(f->r, f->frame)));
}

/* Batches and passes per light draw objects by lists of their own. */
bool shadows_classify(const fnl_frame *frame) {
    return takes_maps(frame) && frame->shadow.classify && frame_is(frame, SHADING_SURFACES) && frame->msaa == 1 && frame->shadow.filter == FNL_SHADOW_FILTER_HARD &&
           frame->lists != FNL_LISTS_BATCHES && frame->lists != FNL_LISTS_MULTIPASS;
}

/* The first view has what all share. */
static void note_structures(struct frame_state *f) {
    const struct device_structures *s = &f->r->device_scene->structures;
    if (!f->rays.top.id) return;
    const bool first = f->view_index == 0;
    counters_note(f, "shadows.instances", s->frame.instances);
    counters_note(f, "shadows.structures-built", first ? s->frame.built + s->frame.placed : 0);
    counters_note(f, "shadows.structures-refitted", first ? s->frame.updated : 0);
    counters_note(f, "shadows.structures-compacted", first ? s->frame.compacted : 0);
    counters_note(f, "shadows.structure-bytes", gpu_memory_stats(f->r->device).structure_bytes);
}

/* What of shadows needs no maps. */
static void begin(struct frame_state *f) {
    struct light_input *lights = &f->scene->lights;
    note_structures(f);
    if (f->frame->shadows == FNL_SHADOWS_CUBEMAP) probes_note(f);
    if (f->frame->shadows == FNL_SHADOWS_SAMPLED) {
        lights->shadow_rays = f->frame->shadow.rays;
        lights->shadow_seed = f->frame->shadow.seed + MAX(f->temporal.index, f->temporal.sequence);
    }
    f->shadowed = true;
}

/* Pushes the names of a view of several, and pops them. */
static void push_view(const struct frame_state *f, uint32_t count) {
    if (count > 1) graph_push_names(f->graph, graph_name(f->graph, "view %u", f->view_index));
}

static void pop_view(const struct frame_state *f, uint32_t count) {
    if (count > 1) graph_pop_names(f->graph);
}

/* Which lights' maps are drawn on request, and which request it is; address 0: no light's. */
static VkDeviceAddress add_updates(const struct frame_state *f) {
    const struct light_input *lights = &f->scene->lights;
    if (!f->r->scene->has_requested) return 0;
    struct gpu_slice updates = gpu_frame_allocate(f->r->device, (lights->directional_count + lights->local_count) * sizeof(uint32_t));
    if (updates.data) device_lights_updates(f->r->device_scene, updates.data); /* else the frame fails */
    return updates.address;
}

/*
 * Whether the last frame's pages are this one's as they are: cameras, surfaces, lights and options are the same, and of a frame since they last were not
 * it is known that it drew and evicted nothing. Counts come back some frames later; in between pages are chosen anew, and stay the same.
 */
static bool are_settled(const struct frame_state *views, uint32_t count) {
    const struct frame_state *f = views;
    struct renderer_shadows *s = &f->kept->shadows;
    bool same = !s->all_changed && !s->moved && f->graph != f->r->asking_graph;
    for (uint32_t i = 0; i < count; i++) same = same && views[i].temporal.same;
    if (!same) s->changed = gpu_frame_number(f->r->device);
    return same && s->settled > s->changed && s->pages.known && f->frame->shadows == FNL_SHADOWS_MAPS && !shadows_classify(f->frame) &&
           f->frame->debug != FNL_DEBUG_SHADOW_AGE;
}

/* What a set of maps is made from. */
struct asked {
    graph_buffer suns;
    const struct light_input *lights;
    uint32_t pairs; /* that there is room for */
    graph_image depths[GROUP_MOST + GROUP_FAR];
    struct light_list surfaces[GROUP_MOST + GROUP_FAR];
};

/* Finds the pages that the views need and draws those that are not there. */
static struct shadow_pages add_pages(struct frame_state *views, uint32_t count, struct asked *asked, struct shadow_fill *out_filled) {
    struct frame_state *f = views;
    graph_buffer wanted = {0};
    for (uint32_t i = 0; i < count; i++) {
        push_view(&views[i], count);
        asked->depths[i] = depth_of(&views[i]);
        asked->surfaces[i] = order_add_surface_lists(&views[i], asked->depths[i]);
        add_requests(&views[i], asked->suns, asked->depths[i], &asked->surfaces[i], &wanted);
        pop_view(&views[i], count);
    }
    const struct shadow_split_input split = {.page_rays = page_rays(f->r, f->frame)};
    const struct shadow_pages_input input = {.wanted = wanted,
                                             .suns = asked->suns,
                                             .lights = asked->lights,
                                             .updates = add_updates(f),
                                             .split = f->frame->shadows == FNL_SHADOWS_HYBRID ? &split : NULL};
    const struct shadow_pages pages = shadow_pages_add(f->graph, f->r->device, &f->kept->shadows.pages, &input);
    const struct shadow_fill_input fill = {.shapes = pages.shapes,
                                           .scene = &f->scene->geometry,
                                           .rays = &f->rays,
                                           .pages = pages.pages,
                                           .counts = pages.counts,
                                           .page_limit = pages.page_limit,
                                           .atlas = pages.atlas,
                                           .kept = &f->kept->shadows.kept,
                                           .all_changed = f->kept->shadows.all_changed,
                                           .moved = f->kept->shadows.moved,
                                           .pair_capacity = asked->pairs};
    *out_filled = shadow_fill_add(f->graph, f->r->device, &fill);
    f->kept->shadows.all_changed = f->kept->shadows.moved = false;
    shadow_least_add(f->graph, &pages, out_filled);
    return pages;
}

/* Takes lights that are in shadow out of the lists of a view. */
static void add_dark(struct frame_state *f, uint32_t count, const struct shadow_pages *pages, struct light_list *surfaces, graph_image depth) {
    if (!shadows_classify(f->frame) || list_kind(surfaces) != GPU_LIST_TILES) return;
    push_view(f, count);
    if (f->frame->debug == FNL_DEBUG_SHADOW_CLASSES)
        f->shadow_classes = graph_create_buffer(f->graph, "shadow classes", DIVIDE_UP(f->frame->width, 8u) * DIVIDE_UP(f->frame->height, 8u) * 8ull);
    shadow_dark_add(f->graph, pages, surfaces, depth, f->shadow_classes);
    f->surface_lights = *surfaces;
    pop_view(f, count);
}

/* One set of maps for `count` views; those of eyes lie as the head's view asks for. The names of the first view's maps are pushed. */
static void add_maps(struct frame_state *views, uint32_t count) {
    struct frame_state *f = views;
    struct light_input *lights = &f->scene->lights, shared = *lights;
    if (!has_maps(f->r, f->frame) || shadow_row_count(lights) == 0) return;
    struct asked asked = {.lights = &shared, .pairs = MAX(f->r->shadow_pairs, f->scene->geometry.item_count)};
    struct gpu_slice slice = gpu_frame_allocate(f->r->device, sizeof(struct gpu_shadow_maps));
    struct gpu_shadow_maps *maps = slice.data;
    if (!maps) return; /* the frame fails */
    if (f->display && f->display->head_address) shared.view = f->display->head_address;
    graph_push_names(f->graph, "shadows");
    const struct gpu_sampler_params point = {.wrap_u = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                             .wrap_v = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                             .anisotropy = 1};
    *maps = (struct gpu_shadow_maps){.point = gpu_sampler_index(f->r->device, &point),
                                     .texel = 1.0f / (float)atlas_side(f->frame),
                                     .first_row = lights->directional_count * (SHADOW_SUN_ROWS - 1)};
    asked.suns = shadow_suns_add(f->graph, f->r->device, &shared, &f->rays);
    if (asked.suns.id) graph_put_address(f->graph, &maps->suns, asked.suns);
    for (uint32_t i = 0; i < count; i++) views[i].scene->lights.maps.address = slice.address;
    shared.maps.address = slice.address;
    const bool settled = are_settled(views, count);
    struct shadow_fill filled = {0};
    const struct shadow_pages pages = settled ? shadow_pages_again(f->graph, &f->kept->shadows.pages) : add_pages(views, count, &asked, &filled);
    graph_put_address(f->graph, &maps->held, pages.held);
    graph_put_address(f->graph, &maps->before, pages.before);
    graph_put_address(f->graph, &maps->pages, pages.pages);
    graph_put_address(f->graph, &maps->biases, pages.biases);
    graph_put_address(f->graph, &maps->shapes, pages.shapes);
    graph_put_sampled(f->graph, &maps->atlas, pages.atlas);
    for (uint32_t i = 0; i < count; i++) {
        const struct shadow_maps made = {.held = pages.held,
                                         .before = pages.before,
                                         .pages = pages.pages,
                                         .biases = pages.biases,
                                         .shapes = pages.shapes,
                                         .suns = asked.suns,
                                         .atlas = pages.atlas,
                                         .address = slice.address};
        views[i].scene->lights.maps = made;
        if (settled) continue;
        asked.surfaces[i].maps = made;
        if (i == 0 && pages.split.id) add_split(f, &pages, &filled, asked.surfaces, asked.depths[0]);
        add_dark(&views[i], count, &pages, &asked.surfaces[i], asked.depths[i]);
    }
    graph_pop_names(f->graph);
    COUNTERS_COPY(f, pages.counts, 0, shadows);
    counters_note(f, "shadows.waiting", asked.pairs);
}

void shadows_add(struct frame_state *f) {
    begin(f);
    add_maps(f, 1);
}

void shadows_add_display(struct frame_state *views, uint32_t count) {
    for (uint32_t i = 0; i < count; i++) begin(&views[i]);
    add_maps(views, count);
}

/* ---- guided ---- */

struct shade_guide shadows_guide(struct frame_state *f) {
    const bool moves = f->temporal.keeps && !f->temporal.still;
    if (moves) temporal_add_motion(f);
    const struct guide_input input = {.view = f->view_address,
                                      .width = f->frame->width,
                                      .height = f->frame->height,
                                      .motion = moves ? f->temporal.motion : (graph_image){0},
                                      .keeps = f->temporal.keeps,
                                      .adverse = renderer_tests(f->r).guide_adverse};
    return guide_add(f->graph, &input);
}

/* ---- denoised ---- */

void shadows_denoise(struct frame_state *f, const struct shade_apart *apart) {
    temporal_add_motion(f);
    const struct denoise_input input = {.view = f->view_address,
                                        .previous = f->temporal.keeps ? &f->kept->temporal.view : NULL,
                                        .depth = f->depth,
                                        .motion = f->temporal.motion,
                                        .apart = apart,
                                        .still = f->temporal.still_frames,
                                        .whole = f->temporal.still_frames >= f->temporal.sequence};
    f->denoise = denoise_add(f->graph, f->r->device, &input, f->radiance);
    COUNTERS_COPY(f, f->denoise.counts, 0, denoise);
}

/* ---- numbers ---- */

/* What was noted is the room that there was. */
static bool find_waiting(const struct counted *counted, uint64_t *value) {
    const uint64_t pairs = counted->counts->shadows.pairs;
    *value = pairs > *value ? pairs - *value : 0;
    return true;
}

/* Behind the counts of light evaluations. */
static bool find_rays_at(const struct counted *counted, uint64_t from_end, uint64_t *value) {
    const fnl_frame *frame = &counted->r->frame;
    *value = ((const uint32_t *)counted->view->counters.mapped)[counted->view->counter_count - from_end];
    return frame->shadows != FNL_SHADOWS_OFF;
}
static bool find_rays(const struct counted *counted, uint64_t *value) { return find_rays_at(counted, 2, value); }
static bool find_rays_passed(const struct counted *counted, uint64_t *value) { return find_rays_at(counted, 1, value); }

#define MAPS(key, unit, help, member) {"shadows." key, unit, help, COUNTED(shadows.member), .needs = "shadows=maps,hybrid"}
#define SPLIT(key, unit, help, member) {"shadows." key, unit, help, COUNTED(split.member), .needs = "shadows=hybrid"}
static const struct counter counters[] = {
    MAPS("wanted", "pages", "pages of shadow maps that pixels ask for", wanted),
    MAPS("pages", "pages", "pages that there are: fewer where lights were made coarser", pages),
    MAPS("drawn", "pages", "of them, drawn in this frame", drawn),
    MAPS("evicted", "pages", "pages of the last frame that this one does not have", evicted),
    MAPS("coarsened", "lights", "lights whose maps are coarser than pixels ask for, to fit into shadow.memory", coarsened),
    MAPS("traced", "lights", "lights whose shadows rays find because there is no room for a map", traced),
    MAPS("cells", "cells", "squares of 128x128 texels of shadow maps that are in use", cells),
    MAPS("entries", "lights", "lights in the lists of all tiles before those in shadow leave them; 0 without shadow.classify", entries),
    MAPS("dark", "lights", "of them, those that left: in shadow all over the tile, or too far away from what it shows", dark),
    MAPS("pairs", "draws", "items times pages into which they are to be drawn", pairs),
    SPLIT("by-maps", "lights", "hybrid: local lights that pixels look up in maps", maps),
    SPLIT("by-rays", "lights", "hybrid: local lights that rays are sent to as that costs less", rays),
    SPLIT("reached", "pixels", "hybrid: pixels that these may reach, added up: so many rays at most", reached),
    SPLIT("switched", "lights", "hybrid: lights that went from maps to rays or back in this frame", switched),
    {"shadows.page-rays", "rays", "hybrid: how many take as long as drawing a page, given or measured", NOTED, .needs = "shadows=hybrid"},
    {"shadows.rays", "rays", "shadow rays that surfaces send", .find = find_rays, .needs = "count-lights"},
    {"shadows.rays-passed", "rays", "of them, those that find at least half of their light", .find = find_rays_passed, .needs = "count-lights"},
    {"shadows.instances", "items", "items in the device's acceleration structure, with ray queries", NOTED},
    {"shadows.structures-built", "structures", "acceleration structures built in this frame: of meshes, and one of the instances when any has moved", NOTED},
    {"shadows.structures-refitted", "structures", "of meshes that deform, adapted to this frame's vertices without being built anew", NOTED},
    {"shadows.structures-compacted", "structures", "of meshes, made smaller in this frame", NOTED},
    {"shadows.structure-bytes", "bytes", "memory of all acceleration structures on the device", NOTED},
    {"probes.count", "probes", "probes by whose cube maps shadows are found", NOTED, .needs = "shadows=cubemap"},
    {"probes.baked", "probes", "of them, baked in this frame", NOTED, .needs = "shadows=cubemap"},
    {"probes.bytes", "bytes", "memory of their cube maps", NOTED, .needs = "shadows=cubemap"},
    {"probes.lights-inside", "lights", "lights in a box of a probe, whose shadows rays find", NOTED, .needs = "shadows=cubemap"},
    {"shadows.waiting", "draws", "of them, without room in this frame: until their pages are drawn, coarser ones or rays stand in, or there is no shadow",
     .find = find_waiting, .needs = "shadows=maps,hybrid", .kind = FNL_COUNTER_OVERFLOW},
};
/* ---- the step ---- */

enum { PAIRS_START = 1 << 19, PAIRS_LIMIT = 1 << 28 };

static void init(fnl_renderer *r) { r->shadow_pairs = PAIRS_START; }

static fnl_result check(const struct call *call, fnl_renderer *r, const fnl_frame *frame) {
    UNUSED(r);
    const bool denoised = shadows_denoised(frame);
    if (!(denoised || shadows_guided(frame)) || frame->shading == FNL_SHADING_DEFERRED) return FNL_OK;
    return unsupported(call, "shadow.%s needs deferred shading, not %s", denoised ? "denoise" : "guide", fnl_value_name(FNL_ENUM_SHADING, frame->shading));
}

/* Pages without room are drawn in the next frame. */
static void grow(fnl_renderer *r, const struct frame_counts *counts) {
    const uint64_t needed = counts->shadows.pairs, limit = MAX(gpu_info(r->device)->memory_bytes / 64 / 20, (uint64_t)PAIRS_START);
    if (needed > r->shadow_pairs) r->shadow_pairs = (uint32_t)MIN(needed + needed / 4, MIN(limit, (uint64_t)PAIRS_LIMIT));
}

static void forget(fnl_renderer *r) {
    for (uint32_t i = 0; i < r->views.count; i++) {
        shadow_state_forget(&r->views.data[i].shadows.pages);
        r->views.data[i].shadows.all_changed = true;
    }
}

static void finish(fnl_renderer *r) {
    for (uint32_t i = 0; i < r->views.count; i++) {
        shadow_state_finish(r->device, &r->views.data[i].shadows.pages);
        gpu_buffer_destroy(r->device, &r->views.data[i].shadows.kept);
    }
}

const struct frame_step step_shadows = {.name = "shadows",
                                        .init = init,
                                        .check = check,
                                        .prepare = prepare,
                                        .submitted = submitted,
                                        .forget = forget,
                                        .grow = grow,
                                        .finish = finish,
                                        .counters = counters,
                                        .counter_count = COUNT_OF(counters)};
