/* SPDX-License-Identifier: MIT */
#include "render/inspect.h"

#include "base/check.h"
#include "passes/debug/inspect.h"
#include "render/orders/order.h"
#include "render/surfaces.h"
#include "render/step.h"

#include <stdlib.h>

static fnl_result check(const struct call *call, fnl_renderer *r, const fnl_frame *frame) {
    UNUSED(r);
    if (!frame->pixel.asked) return FNL_OK;
    TRY(check_count(call, "pixel.x", frame->pixel.x, 0, frame->width - 1));
    TRY(check_count(call, "pixel.y", frame->pixel.y, 0, frame->height - 1));
    return check_count(call, "pixel.view", frame->pixel.view, 0, frame_view_count(frame) - 1);
}

fnl_result inspect_prepare(fnl_renderer *r, const fnl_frame *frame) {
    if (!frame->pixel.asked) return FNL_OK;
    struct renderer_pixel *p = &r->pixel;
    if (r->outputs.pixel.size == 0) TRY(gpu_buffer_create(r->device, "pixel", sizeof(struct inspected), GPU_MEMORY_READBACK, &r->outputs.pixel));
    const uint32_t suns = r->scene->suns.count;
    if (!array_reserve(&r->host, &p->suns, suns)) return FNL_ERROR_MEMORY;
    if (suns) memcpy(p->suns.data, r->scene->suns.data, suns * sizeof *p->suns.data);
    p->suns.count = suns;
    p->next_generation = r->scene->next_generation;
    return FNL_OK;
}

static void destroy(fnl_renderer *r) {
    gpu_buffer_destroy(r->device, &r->outputs.pixel);
    array_free(&r->host, &r->pixel.suns);
    array_free(&r->host, &r->pixel.lights);
}

/* Only in the view that the pixel query names. */
static void finish_view(struct frame_state *f) {
    const fnl_pixel_query *query = &f->frame->pixel;
    if (!query->asked || query->view != f->view_index) return;
    graph_set_role(f->graph, GRAPH_ROLE_REST);
    graph_push_names(f->graph, "pixel");
    const struct lighting whole = order_add_fallback_lists(f);
    const bool volumes = frame_is(f->frame, SHADING_VOLUMES);
    inspect_add(f->graph, f->r->device,
                &(struct inspect_input){.scene = &f->scene->geometry,
                                        .draws = &f->draws,
                                        .view = &f->view,
                                        .view_address = f->view_address,
                                        .x = query->x,
                                        .y = query->y,
                                        .layered = f->lighting.layered,
                                        .whole = &whole,
                                        .own = volumes ? NULL : &f->lights,
                                        .own_skips_layered = surfaces_over(f) != 0,
                                        .counters = volumes ? f->counters : (graph_buffer){0},
                                        .out = graph_import_buffer(f->graph, "pixel", &f->input->outputs->pixel)});
    struct graph_pass *host = graph_add_pass(f->graph, "to host", GRAPH_QUEUE_GRAPHICS, NULL, NULL, 0);
    graph_keep(host);
    graph_use_buffer(host, graph_import_buffer(f->graph, "pixel", &f->input->outputs->pixel), GRAPH_READ_HOST);
    graph_pop_names(f->graph);
}

const struct frame_step step_inspect = {.name = "inspect", .check = check, .finish_view = finish_view, .destroy = destroy};

/* ---- the answer ---- */

static int by_luminance(const void *a, const void *b) {
    const fnl_pixel_light *x = a, *y = b;
    if (x->luminance != y->luminance) return x->luminance < y->luminance ? 1 : -1;
    return (x->index > y->index) - (x->index < y->index);
}

/* The light among those of the scene with its holes; SCENE_NONE: it is not there any more. */
static uint32_t light_of(const fnl_renderer *r, uint32_t light) {
    const fnl_scene *scene = r->scene;
    const uint32_t suns = r->pixel.suns.count, slot = light - suns;
    uint32_t at = SCENE_NONE;
    if (light < suns)
        at = r->pixel.suns.data[light];
    else if (slot < scene->light_slots.count)
        at = scene->light_slots.data[slot].light;
    if (at == SCENE_NONE || at >= scene->lights.count || scene->lights.data[at].removed) return SCENE_NONE;
    return scene->lights.data[at].generation <= r->pixel.next_generation ? at : SCENE_NONE; /* else another has come in its place */
}

static void describe_light(const fnl_renderer *r, const struct inspected *found, uint32_t i, fnl_pixel_light *out) {
    const struct gpu_inspect_light *g = &found->lights[i];
    const uint32_t light = light_of(r, g->light);
    *out = (fnl_pixel_light){.index = FNL_PIXEL_NONE,
                             .directional = g->light < r->pixel.suns.count,
                             .listed = g->listed || !(found->pixel.flags & INSPECT_LISTED),
                             .radiance = {g->radiance.x, g->radiance.y, g->radiance.z},
                             .luminance = 0.2126f * g->radiance.x + 0.7152f * g->radiance.y + 0.0722f * g->radiance.z,
                             .visibility = g->visibility,
                             .shadow = (fnl_pixel_shadow)g->shadow};
    if (light != SCENE_NONE) {
        out->id = (fnl_light_id){light, r->scene->lights.data[light].generation};
        out->index = scene_entity_index(r->scene, FNL_ENTITY_LIGHT, light);
    }
    if (out->shadow != FNL_PIXEL_SHADOW_MAP) return;
    out->shadow_face = g->face;
    out->shadow_level = g->level;
    out->shadow_page[0] = g->page.x;
    out->shadow_page[1] = g->page.y;
    out->shadow_atlas[0] = (g->place & 0xffff) * SHADOW_UNIT;
    out->shadow_atlas[1] = (g->place >> 16) * SHADOW_UNIT;
}

static void describe(const fnl_renderer *r, const struct gpu_inspected *g, fnl_pixel_info *out) {
    out->hit = true;
    out->position = g->position;
    out->normal = g->normal;
    out->view_depth = g->view_depth;
    memcpy(out->base_color, &g->base_color, sizeof out->base_color);
    memcpy(out->emission, &g->emission, sizeof out->emission);
    out->metallic = g->metallic;
    out->roughness = g->roughness;
    out->unlit = (g->flags & INSPECT_UNLIT) != 0;
    if (out->unlit) memcpy(out->base_color, &g->emission, sizeof out->base_color); /* the surface is black and glows */
    out->has_list = !frame_is(&r->frame, SHADING_VOLUMES);
    out->cell = g->cell;
    out->cell_place[0] = g->cell_place.x;
    out->cell_place[1] = g->cell_place.y;
    out->cell_place[2] = g->cell_place.z;
    out->unserved = (g->flags & INSPECT_UNSERVED) != 0;
    out->lights_visited = g->visited;
    out->lights_reaching = g->reaching;
    if (g->flags & INSPECT_LISTED) out->lights_left_out = g->reaching - MIN(g->listed_reaching, g->reaching);
    out->lights_contributing = g->contributing;
    memcpy(out->lit, &g->lit, sizeof out->lit);
    memcpy(out->rest, &g->rest, sizeof out->rest);
    out->light_count = MIN(g->told, INSPECT_LIGHTS);
    out->lights_untold = g->total - MIN(out->light_count, g->total);
}

fnl_result fnl_renderer_query_pixel(fnl_renderer *r, fnl_pixel_info *out) {
    TRY(check_handle(__func__, "renderer", r));
    const struct call *call = CALL(&r->host);
    TRY(check_pointer(call, "out", out));
    *out = (fnl_pixel_info){0};
    if (r->frame_number == 0) return misuse(call, "no frame has been rendered");
    if (!r->frame.pixel.asked) return misuse(call, "the last frame was not asked for a pixel (fnl_frame.pixel)");
    TRY(gpu_frame_wait(r->device, r->frame_number));
    out->query = r->frame.pixel;
    const struct inspected *found = r->outputs.pixel.mapped;
    if (!(found->pixel.flags & INSPECT_HIT)) return FNL_OK;
    if (!array_reserve(&r->host, &r->pixel.lights, INSPECT_LIGHTS)) return FNL_ERROR_MEMORY;
    describe(r, &found->pixel, out);
    for (uint32_t i = 0; i < out->light_count; i++) describe_light(r, found, i, &r->pixel.lights.data[i]);
    qsort(r->pixel.lights.data, out->light_count, sizeof *r->pixel.lights.data, by_luminance);
    r->pixel.lights.count = out->light_count;
    out->lights = r->pixel.lights.data;
    return FNL_OK;
}
