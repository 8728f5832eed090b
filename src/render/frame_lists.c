/* SPDX-License-Identifier: MIT */
/** Light lists in a frame: users, inputs and pool sizes. */
#include "passes/lights/sprites.h"
#include "render/orders/order.h"
#include "render/step.h"
#include "render/stereo.h"
#include "render/surfaces.h"

/* ---- the step ---- */

static fnl_result check(const struct call *call, fnl_renderer *r, const fnl_frame *frame) {
    UNUSED(r);
    const fnl_cluster_options *o = &frame->clusters;
    if (isinf(o->near) || isinf(o->far)) return FNL_OK;
    return check_above(call, "clusters.far", (double)o->far, (double)o->near, (double)INFINITY, " metres (clusters.near)");
}

enum { POOL_START = 1 << 18, POOL_LIMIT = 1 << 28 };

static void init(fnl_renderer *r) {
    r->lists.pool_capacity = POOL_START;
    lists_shared_init(&r->lists.shared, &r->host);
}

static uint64_t pool_limit(const fnl_renderer *r) { return MAX(MIN(gpu_info(r->device)->memory_bytes / 32, (uint64_t)POOL_LIMIT), (uint64_t)POOL_START); }

uint32_t lists_pool_limit(const fnl_renderer *r) { return renderer_tests(r).fixed_pools ? r->lists.pool_capacity : (uint32_t)pool_limit(r); }

/*
 * After an overflow the pool takes what the frame needed and a quarter more, but never so much that the device could run out: cells beyond that go on
 * using all lights.
 */
static void grow(fnl_renderer *r, const struct frame_counts *counts) {
    const struct lists_counts *c = COUNTS(counts, lists);
    const uint64_t needed = MAX(MAX(c->lights.entries, c->blend_lights.entries), c->surface_lights.entries);
    if (needed > r->lists.pool_capacity) r->lists.pool_capacity = (uint32_t)MIN(needed + needed / 4, pool_limit(r));
}

static void forget(fnl_renderer *r) { r->lists.shared.world.version = r->lists.shared.grid2d.version = UINT64_MAX; }

/* Small lights fade. */
static fnl_result begin_view(struct frame_state *f) {
    struct device_scene_user *user = f->input->user;
    const float lod = f->frame->light_lod;
    graph_set_role(f->graph, GRAPH_ROLE_LISTS);
    TRY(device_lights_fade(user, &f->view, lod, lists_cull_on_cpu(f->frame->lists)));
    f->lists.whole_lights = f->lighting.lights;
    if (lod > 0) light_fade_add(f->graph, f->r->device, f->view_address, &f->lighting.lights, &user->faded_lights, &user->faded_bounds, lod);
    return FNL_OK;
}

static void destroy(fnl_renderer *r) {
    for (uint32_t i = 0; i < r->lists.views.count; i++) lists_finish(&r->lists.views.data[i], r->device);
    array_free(&r->host, &r->lists.views);
    lists_shared_finish(&r->lists.shared, r->device);
}

static const struct counter rows[] = {
    {"lights.behind", "lights", "lights in view that are behind the surfaces of every tile they touch", COUNTED(lists, behind), .needs = "lists=backface"},
};
const struct counter_table counters_lists = COUNTER_TABLE_COUNTED(rows, lists);

const struct frame_step step_lists = {.name = "lists",
                                      .init = init,
                                      .check = check,
                                      .begin_view = begin_view,
                                      .forget = forget,
                                      .grow = grow,
                                      .destroy = destroy,
                                      .counters = &counters_lists};

/* ---- lists of a view ---- */

static struct light_input input_of(const struct frame_state *f) {
    struct light_input input = lighting_input(&f->lighting);
    input.width = f->frame->width;
    input.height = f->frame->height;
    return input;
}

static struct lists_context lists_context(struct frame_state *f, struct light_input *input) {
    return (struct lists_context){.graph = f->graph,
                                  .device = f->r->device,
                                  .frame = f->frame,
                                  .view = &f->view,
                                  .device_scene = f->r->device_scene,
                                  .scene = &f->scene->geometry,
                                  .draws = &f->draws,
                                  .input = input,
                                  .shared = f->input->shared_lists,
                                  .state = &f->input->lists[f->view_index],
                                  .fallback = &f->lists.fallback,
                                  .has_blend = surfaces_have_blend(f),
                                  .layered = f->lighting.layered,
                                  .estimates = !frame_is_dry(f),
                                  .pool_capacity = f->r->lists.pool_capacity,
                                  .pool_limit = lists_pool_limit(f->r)};
}

/* One list for all eyes, made with the first. */
static void add_head_lists(struct frame_state *f) {
    struct frame_display *display = f->group.display;
    if (!display->lights.header) {
        struct light_input input = input_of(f);
        struct lists_context context = lists_context(f, &input);
        fnl_frame frame = *f->frame;
        frame.width = input.width = display->head.size.x;
        frame.height = input.height = display->head.size.y;
        frame.camera.near_distance = display->head.near_distance;
        input.view = display->head_address;
        context.frame = &frame;
        context.view = &display->head;
        context.of_head = true;
        lists_add(&context);
        display->lights = context.lights;
    }
    f->lights = f->blend_lights = lighting_add(f->graph, f->r->device, &f->lighting, &display->lights);
}

static void add_lists(struct frame_state *f, graph_image depth, const struct gbuffer *gbuffer) {
    if (stereo_shares_list(f, f->frame->lists)) {
        add_head_lists(f);
        return;
    }
    struct light_input input = input_of(f);
    struct lists_context context = lists_context(f, &input);
    context.depth = depth;
    context.gbuffer = gbuffer;
    context.of_head = stereo_asks_list(f, f->frame->lists);
    lists_add(&context);
    const bool one = context.blend_lights.header == context.lights.header, dark = f->shadows.surface_lights.header != 0;
    f->lights = lighting_add(f->graph, f->r->device, &f->lighting, dark ? &f->shadows.surface_lights : &context.lights);
    f->blend_lights = (dark ? !context.has_blend : one) ? f->lights : lighting_add(f->graph, f->r->device, &f->lighting, &context.blend_lights);
}

void order_add_lists(struct frame_state *f, graph_image depth, const struct gbuffer *gbuffer) {
    graph_set_role(f->graph, GRAPH_ROLE_LISTS);
    add_lists(f, depth, gbuffer);
    graph_set_role(f->graph, GRAPH_ROLE_SHADING);
}

struct lighting order_light_by_all(struct frame_state *f) {
    const struct light_input input = input_of(f);
    const struct light_list list = light_list_all_add(f->graph, f->r->device, &input);
    return lighting_add(f->graph, f->r->device, &f->lighting, &list);
}

struct lighting order_light_by_suns(struct frame_state *f) {
    struct lighting scopes = f->lighting;
    scopes.lights.local_count = 0;
    const struct light_input input = lighting_input(&scopes);
    const struct light_list list = light_list_all_add(f->graph, f->r->device, &input);
    return lighting_add(f->graph, f->r->device, &scopes, &list);
}

struct lighting order_add_fallback_lists(struct frame_state *f) {
    struct light_input input = input_of(f);
    const struct lists_context context = lists_context(f, &input);
    const struct light_list list = lists_add_fallback(&context);
    return lighting_add(f->graph, f->r->device, &f->lighting, &list);
}

struct light_list order_add_surface_lists(struct frame_state *f, graph_image depth) {
    struct light_input input = input_of(f);
    struct lists_context context = lists_context(f, &input);
    context.depth = depth;
    return lists_add_surfaces(&context);
}
