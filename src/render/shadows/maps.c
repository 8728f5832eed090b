/* SPDX-License-Identifier: MIT */
#include "render/shadows/maps.h"

#include "passes/shadow/dark.h"
#include "passes/shadow/oblong.h"
#include "passes/shadow/requests.h"
#include "render/orders/order.h"
#include "render/shadows/method.h"
#include "render/step.h"
#include "render/surfaces.h"

uint64_t shadow_maps_rows(const fnl_renderer *r) {
    return r->scene->suns.count * (uint64_t)SHADOW_SUN_ROWS + r->scene->light_slot_end;
}

bool shadow_maps_possible(const fnl_renderer *r, const fnl_frame *frame) {
    const uint64_t rows = shadow_maps_rows(r);
    return shadows_have(frame, SHADOWS_MAPS) && gpu_info(r->device)->clip_distances && rows > 0 && rows <= SHADOW_MOST_ROWS;
}

uint32_t shadow_maps_side(const fnl_frame *frame) {
    const double cells = frame->shadow.memory * (1048576.0 / (SHADOW_PAGE * SHADOW_PAGE * 4));
    return SHADOW_PAGE * (uint32_t)sqrt(cells);
}

/* Texels across the finest level that has at most as many as local lights may have. */
static float widest_level(const fnl_frame *frame) {
    static const uint32_t widths[SHADOW_LEVELS] = {1920, 960, 480, 240, 120, 56, 24, 8};
    uint32_t level = 0;
    while (level + 1 < SHADOW_LEVELS && widths[level] > frame->shadow.texels_max) level++;
    return (float)widths[level];
}

static fnl_result need_buffer(fnl_renderer *r, const char *name, uint64_t bytes, struct gpu_buffer *buffer) {
    if (buffer->size >= bytes) return FNL_OK;
    gpu_buffer_destroy(r->device, buffer);
    return gpu_buffer_create_for(r->device, GPU_USE_SHADOWS, name, bytes, GPU_MEMORY_DEVICE, buffer);
}

/* Whether suns may have oblong pages. The filter disks of soft shadows reach beyond what oblong pages show. */
static bool frame_has_oblongs(const fnl_renderer *r, const fnl_frame *frame) {
    return r->scene->suns.count > 0 && frame->shadow.filter != FNL_SHADOW_FILTER_PCSS;
}
static uint64_t planes_bytes(const fnl_frame *frame) { return (uint64_t)frame->width * frame->height * 4; }
static uint64_t keys_bytes(const fnl_renderer *r) { return r->scene->suns.count * (uint64_t)(SHADOW_SUN_OBLONGS * SHADOW_OBLONG_WORDS) * 4; }

static fnl_result prepare_oblongs(fnl_renderer *r, const fnl_frame *frame, struct renderer_shadows *s) {
    if (!frame_has_oblongs(r, frame)) return FNL_OK;
    TRY(need_buffer(r, "shadow planes", planes_bytes(frame), &s->planes));
    return need_buffer(r, "shadow keys", keys_bytes(r), &s->keys);
}

/* Whether suns have oblong pages in the maps of `count` views. Eyes of a display share maps but see other planes. */
static bool views_have_oblongs(const struct frame_state *f, uint32_t count) {
    const struct renderer_shadows *s = &f->kept->shadows;
    return count == 1 && !f->group.display && frame_has_oblongs(f->r, f->frame) && s->planes.size >= planes_bytes(f->frame) && s->keys.size >= keys_bytes(f->r);
}

fnl_result shadow_maps_prepare_view(fnl_renderer *r, const fnl_frame *frame, struct renderer_view *view) {
    if (!shadow_maps_possible(r, frame)) return FNL_OK;
    const struct device_scene *d = r->device_scene;
    const uint64_t drawn[] = {d->material_version, d->texture_version, d->arrived_before + d->arrived.count, d->ray_key},
                   placed[] = {d->structure_version, d->scene->transform_version};
    struct renderer_shadows *s = &view->shadows;
    const uint64_t bytes = shadow_fill_kept_bytes(d->item_count);
    s->all_changed |= memcmp(drawn, s->drawn, sizeof drawn) != 0 || s->kept.size < bytes;
    s->moved |= memcmp(placed, s->placed, sizeof placed) != 0;
    memcpy(s->drawn, drawn, sizeof drawn);
    memcpy(s->placed, placed, sizeof placed);
    if (s->kept.size < bytes) TRY(need_buffer(r, "shadow items", bytes + bytes / 4, &s->kept));
    TRY(prepare_oblongs(r, frame, s));
    return shadow_pages_prepare(r->device, &s->pages, (uint32_t)shadow_maps_rows(r), shadow_maps_side(frame));
}

/* For passes that do not shade; requests depend on the filter. */
static struct lighting without_shadows(struct lighting lighting) {
    lighting.bits &= ~GPU_LIGHTING_SHADOWED | GPU_LIGHTING_FILTERED;
    lighting.shadows.rays = (struct rays){0};
    lighting.shadows.maps = (struct shadow_maps){0};
    lighting.shadows.contact = (graph_image){0};
    return lighting;
}

/* Batches and passes per light draw objects by lists of their own. */
bool shadow_maps_classify(const fnl_frame *frame) {
    return shadows_have(frame, SHADOWS_MAPS) && frame->shadow.classify && frame_is(frame, SHADING_SURFACES) && frame->msaa == 1 && frame->shadow.filter == FNL_SHADOW_FILTER_HARD &&
           frame->lists != FNL_LISTS_BATCHES && frame->lists != FNL_LISTS_MULTIPASS;
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
    const struct light_set *lights = &f->lighting.lights;
    if (!f->r->scene->has_requested) return 0;
    struct gpu_slice updates = gpu_frame_allocate(f->r->device, (lights->directional_count + lights->local_count) * sizeof(uint32_t));
    if (updates.data) device_lights_updates(f->r->device_scene, updates.data); /* else the frame fails */
    return updates.address;
}

/*
 * Whether this frame can reuse the last frame's pages: cameras, surfaces, lights and options are unchanged, and a frame since the last change is known to
 * have drawn and evicted nothing. Counts come back a few frames later; until then pages are chosen again, with the same result.
 */
static bool are_settled(const struct frame_state *views, uint32_t count) {
    const struct frame_state *f = views;
    const struct renderer_shadows *s = &f->kept->shadows;
    bool same = !s->all_changed && !s->moved && !frame_is_dry(f);
    for (uint32_t i = 0; i < count; i++) same = same && views[i].temporal.same;
    f->made->shadows.same = same;
    return same && s->settled > s->changed && s->pages.last.known && !shadows_have(f->frame, SHADOWS_SPLIT) && !shadow_maps_classify(f->frame) &&
           f->frame->debug != FNL_DEBUG_SHADOW_AGE;
}

/* What a set of maps is made from. */
struct asked {
    graph_buffer suns, planes, keys; /* id 0 of the last two: no oblong blocks */
    const struct lighting *lighting; /* of the view that asks; maps have their address only */
    uint32_t pairs; /* that there is room for */
    graph_image depths[GROUP_MOST + GROUP_FAR];
    struct light_list surfaces[GROUP_MOST + GROUP_FAR];
};

/* Adds the page requests of a view to `wanted`; creates `wanted` if its id is 0. */
static void add_requests(struct frame_state *f, const struct asked *asked, graph_image depth, const struct light_list *surfaces, graph_buffer *wanted) {
    struct lighting lighting = without_shadows(lighting_add(f->graph, f->r->device, &f->lighting, surfaces));
    COUNTERS_COPY(f, surfaces->totals, 0, lists, surface_lights);
    const struct shadow_maps places = {.suns = asked->suns, .keys = asked->keys, .planes = asked->planes};
    const bool splits = shadows_have(f->frame, SHADOWS_SPLIT);
    if (wanted->id)
        shadow_requests_more_add(f->graph, &lighting, &places, *wanted, depth, splits);
    else
        *wanted = shadow_requests_add(f->graph, &lighting, &places, shadow_row_count(&f->lighting.lights), depth, splits);
    const struct geometry_scene *scene = &f->scene->geometry;
    const bool blend = surfaces_have_blend(f), glass = surfaces_have_glass(f);
    if (blend || glass) lighting = without_shadows(order_add_fallback_lists(f)); /* in front of what depth shows */
    if (blend) shadow_requests_blend_add(f->graph, &lighting, &places, *wanted, scene, &f->draws, false, f->view_address, depth, splits);
    if (glass) shadow_requests_blend_add(f->graph, &lighting, &places, *wanted, scene, &f->draws, true, f->view_address, depth, splits);
}

/* Finds the pages that the views need and draws those that are not there. */
static struct shadow_pages add_pages(struct frame_state *views, uint32_t count, struct asked *asked, struct shadow_fill *out_filled) {
    struct frame_state *f = views;
    graph_buffer wanted = {0};
    for (uint32_t i = 0; i < count; i++) {
        push_view(&views[i], count);
        asked->depths[i] = shadows_depth(&views[i]);
        asked->surfaces[i] = order_add_surface_lists(&views[i], asked->depths[i]);
        if (asked->planes.id) shadow_oblong_add(f->graph, asked->lighting, asked->suns, asked->depths[i], asked->planes, asked->keys);
        add_requests(&views[i], asked, asked->depths[i], &asked->surfaces[i], &wanted);
        pop_view(&views[i], count);
    }
    const struct shadow_split_input split = {.page_rays = shadow_hybrid_page_rays(f->r, f->frame)};
    const struct shadow_pages_input input = {.wanted = wanted,
                                             .suns = asked->suns,
                                             .keys = asked->keys,
                                             .lighting = asked->lighting,
                                             .updates = add_updates(f),
                                             .split = shadows_have(f->frame, SHADOWS_SPLIT) ? &split : NULL};
    const struct shadow_pages pages = shadow_pages_add(f->graph, f->r->device, &f->kept->shadows.pages, &input, &f->made->shadows.turn);
    const struct shadow_fill_input fill = {.shapes = pages.shapes,
                                           .scene = &f->scene->geometry,
                                           .rays = &f->shadows.rays,
                                           .pages = pages.pages,
                                           .counts = pages.counts,
                                           .page_limit = pages.page_limit,
                                           .atlas = pages.atlas,
                                           .kept = &f->kept->shadows.kept,
                                           .all_changed = f->kept->shadows.all_changed,
                                           .moved = f->kept->shadows.moved,
                                           .pair_capacity = asked->pairs};
    *out_filled = shadow_fill_add(f->graph, f->r->device, &fill);
    shadow_least_add(f->graph, &pages, out_filled);
    return pages;
}

/* Takes lights that are in shadow out of the lists of a view. */
static void add_dark(struct frame_state *f, uint32_t count, const struct shadow_pages *pages, const struct lighting *surfaces, graph_image depth) {
    if (!shadow_maps_classify(f->frame) || list_kind(&surfaces->list) != GPU_LIST_TILES) return;
    push_view(f, count);
    if (f->frame->debug == FNL_DEBUG_SHADOW_CLASSES)
        f->shadows.classes = graph_create_buffer(f->graph, "shadow classes", DIVIDE_UP(f->frame->width, 8u) * DIVIDE_UP(f->frame->height, 8u) * 8ull);
    shadow_dark_add(f->graph, pages, surfaces, depth, f->shadows.classes);
    f->shadows.surface_lights = surfaces->list;
    pop_view(f, count);
}

/* One set of maps for `count` views; those of eyes lie as the head's view asks for. The names of the first view's maps are pushed. */
void shadow_maps_add(struct frame_state *views, uint32_t count) {
    struct frame_state *f = views;
    const struct light_set *lights = &f->lighting.lights;
    struct lighting scopes = f->lighting;
    if (!shadow_maps_possible(f->r, f->frame) || shadow_row_count(lights) == 0) return;
    struct asked asked = {.pairs = MAX(f->r->shadows.pairs, f->scene->geometry.item_count)};
    struct gpu_slice slice = gpu_frame_allocate(f->r->device, sizeof(struct gpu_shadow_maps));
    struct gpu_shadow_maps *maps = slice.data;
    if (!maps) return; /* the frame fails */
    if (f->group.display && f->group.display->head_address) scopes.view = f->group.display->head_address;
    graph_push_names(f->graph, "shadows");
    const struct gpu_sampler_params point = {.wrap_u = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                             .wrap_v = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                             .anisotropy = 1};
    *maps = (struct gpu_shadow_maps){.point = gpu_sampler_index(f->r->device, &point),
                                     .texel = 1.0f / (float)shadow_maps_side(f->frame),
                                     .widest = widest_level(f->frame),
                                     .first_row = lights->directional_count * (SHADOW_SUN_ROWS - 1)};
    const struct lighting shared = lighting_add(f->graph, f->r->device, &scopes, NULL);
    asked.lighting = &shared;
    asked.suns = shadow_suns_add(f->graph, &shared, &f->shadows.rays);
    if (asked.suns.id) graph_put_address(f->graph, &maps->suns, asked.suns);
    if (asked.suns.id && views_have_oblongs(f, count)) {
        asked.planes = graph_import_buffer(f->graph, "shadow planes", &f->kept->shadows.planes);
        asked.keys = graph_import_buffer(f->graph, "shadow keys", &f->kept->shadows.keys);
        graph_put_address(f->graph, &maps->planes, asked.planes);
        graph_put_address(f->graph, &maps->keys, asked.keys);
        maps->planes_across = f->frame->width;
    }
    for (uint32_t i = 0; i < count; i++) views[i].lighting.shadows.maps.address = slice.address;
    const bool settled = are_settled(views, count);
    f->made->shadows.has_pages = true;
    struct shadow_fill filled = {0};
    const struct shadow_pages pages = settled ? shadow_pages_again(f->graph, &f->kept->shadows.pages, &f->made->shadows.turn) : add_pages(views, count, &asked, &filled);
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
                                         .keys = asked.keys,
                                         .planes = asked.planes,
                                         .atlas = pages.atlas,
                                         .address = slice.address};
        views[i].lighting.shadows.maps = made;
        if (settled) continue;
        const struct lighting surfaces = lighting_add(f->graph, f->r->device, &views[i].lighting, &asked.surfaces[i]);
        if (i == 0 && pages.split.id) shadow_hybrid_add(f, &pages, &filled, &surfaces, asked.depths[0]);
        add_dark(&views[i], count, &pages, &surfaces, asked.depths[i]);
    }
    graph_pop_names(f->graph);
    COUNTERS_COPY(f, pages.counts, 0, shadow_maps, pages);
    counters_note(f, "shadows.waiting", asked.pairs);
}

static void counted(fnl_renderer *r, uint32_t slot) {
    for (uint32_t i = 0; i < r->slots.views[slot]; i++) {
        const struct gpu_shadow_counts *c = &COUNTS(renderer_counts(r, slot, i), shadow_maps)->pages;
        if ((c->drawn | c->evicted | c->pairs) == 0) r->views.data[i].shadows.settled = r->slots.frames[slot];
    }
}

static void submitted(fnl_renderer *r, const fnl_frame *frame) {
    for (uint32_t i = 0; i < frame_camera_count(frame); i++) {
        struct renderer_shadows *s = &r->views.data[i].shadows;
        if (!r->last.data[i].shadows.has_pages) continue;
        if (!r->last.data[i].shadows.same) {
            s->changed = r->frame_number;
            s->all_changed = s->moved = false;
        }
        s->pages.last = r->last.data[i].shadows.turn;
    }
}

/* ---- numbers ---- */

/* What was noted is the room that there was. */
static bool find_waiting(const struct counted *counted, uint64_t *value) {
    const uint64_t pairs = COUNTS(counted->counts, shadow_maps)->pages.pairs;
    *value = pairs > *value ? pairs - *value : 0;
    return true;
}

#define MAPS(key, unit, help, member) {"shadows." key, unit, help, COUNTED(shadow_maps, pages.member), .needs = "shadows=maps,hybrid"}
static const struct counter rows[] = {
    MAPS("wanted", "pages", "pages of shadow maps that pixels ask for", wanted),
    MAPS("oblong", "pages", "of them, pages of directional lights with oblong texels, for surfaces at grazing angles", oblong),
    MAPS("pages", "pages", "pages that there are: fewer where lights were made coarser", pages),
    MAPS("drawn", "pages", "of them, drawn in this frame", drawn),
    MAPS("evicted", "pages", "pages of the last frame that this one does not have", evicted),
    MAPS("coarsened", "lights", "lights whose maps are coarser than pixels ask for, to fit into shadow.memory", coarsened),
    MAPS("traced", "lights", "lights whose shadows rays find because there is no room for a map", traced),
    MAPS("cells", "cells", "squares of 128x128 texels of shadow maps that are in use", cells),
    MAPS("cells-wanted", "cells", "cells that all requested pages would take; 16 cells are 1 MiB of shadow.memory", cells_wanted),
    MAPS("entries", "lights", "lights in the lists of all tiles before those in shadow leave them; 0 without shadow.classify", entries),
    MAPS("dark", "lights", "of them, removed: the whole tile is in their shadow, or they are too far from its surfaces", dark),
    MAPS("pairs", "draws", "items times pages into which they are to be drawn", pairs),
    {"shadows.waiting", "draws", "of them, without room in this frame; until their pages are drawn, coarser pages or rays replace them, or there is no shadow",
     .find = find_waiting, .needs = "shadows=maps,hybrid", .kind = FNL_COUNTER_OVERFLOW},
};
const struct counter_table counters_shadow_maps = COUNTER_TABLE_COUNTED(rows, shadow_maps);

/* ---- the method ---- */

enum { PAIRS_START = 1 << 19, PAIRS_LIMIT = 1 << 28 };

static void init(fnl_renderer *r) { r->shadows.pairs = PAIRS_START; }

/* Pages without room are drawn in the next frame. */
static void grow(fnl_renderer *r, const struct frame_counts *counts) {
    const uint64_t needed = COUNTS(counts, shadow_maps)->pages.pairs, limit = MAX(gpu_info(r->device)->memory_bytes / 64 / 20, (uint64_t)PAIRS_START);
    if (needed > r->shadows.pairs) r->shadows.pairs = (uint32_t)MIN(needed + needed / 4, MIN(limit, (uint64_t)PAIRS_LIMIT));
}

static void forget(fnl_renderer *r) {
    for (uint32_t i = 0; i < r->views.count; i++) {
        shadow_state_forget(&r->views.data[i].shadows.pages);
        r->views.data[i].shadows.all_changed = true;
    }
}

static void destroy(fnl_renderer *r) {
    for (uint32_t i = 0; i < r->views.count; i++) {
        shadow_state_finish(r->device, &r->views.data[i].shadows.pages);
        gpu_buffer_destroy(r->device, &r->views.data[i].shadows.kept);
        gpu_buffer_destroy(r->device, &r->views.data[i].shadows.planes);
        gpu_buffer_destroy(r->device, &r->views.data[i].shadows.keys);
    }
}

const struct shadow_method shadow_method_maps = {.traits = SHADOWS_MAPS | SHADOWS_EXACT,
                                                 .captured_as = FNL_SHADOWS_MAPS,
                                                 .init = init,
                                                 .counted = counted,
                                                 .submitted = submitted,
                                                 .forget = forget,
                                                 .grow = grow,
                                                 .destroy = destroy,
                                                 .prepare_view = shadow_maps_prepare_view,
                                                 .add = shadow_maps_add,
                                                 .counters = &counters_shadow_maps};
