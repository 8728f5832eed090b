/* SPDX-License-Identifier: MIT */
#include "render/debug_views.h"

#include "passes/debug/colors_shared.h"
#include "render/decals.h"
#include "render/orders/order.h"
#include "render/shadows/maps.h"
#include "render/shading.h"
#include "render/step.h"

/* ---- views that go with every order ---- */

static void add_view(struct frame_state *f, struct debug_counts counts, graph_image metal, bool swap) {
    debug_view_add(f->graph, (uint32_t)f->frame->debug, &f->nearest.aov, &f->lights.list, counts, metal, f->view_address, f->color, swap);
}

void debug_views_add_counts(struct frame_state *f, struct debug_counts counts, bool swap) {
    add_view(f, counts, (graph_image){0}, swap);
}

static void add_plain(struct frame_state *f, bool swap) { debug_views_add_counts(f, (struct debug_counts){0}, swap); }

static void add_lights(struct frame_state *f, bool swap) {
    bool volumes = shading_shows_volumes(f->frame);
    debug_views_add_counts(f, volumes ? (struct debug_counts){f->counters, 2} : (struct debug_counts){0}, swap);
}

/* What passes of their own count for each pixel. */
typedef graph_buffer counting(struct graph *graph, const struct geometry_scene *scene, const struct geometry_draws *draws,
                              VkDeviceAddress view, uint32_t width, uint32_t height);
static void add_counted(struct frame_state *f, counting *count, bool swap) {
    graph_buffer counts = count(f->graph, &f->scene->geometry, &f->draws, f->view_address, f->frame->width, f->frame->height);
    debug_views_add_counts(f, (struct debug_counts){counts, 1}, swap);
}

static void add_overdraw(struct frame_state *f, bool swap) { add_counted(f, overdraw_add, swap); }
static void add_overshading(struct frame_state *f, bool swap) { add_counted(f, overshading_add, swap); }
static void add_layers(struct frame_state *f, bool swap) { add_counted(f, layers_add, swap); }
static void add_clusters(struct frame_state *f, bool swap) { add_counted(f, cluster_view_add, swap); }
static void add_triangles(struct frame_state *f, bool swap) { add_counted(f, triangle_view_add, swap); }

static void add_light_volumes(struct frame_state *f, bool swap) {
    light_volumes_view_add(f->graph, &f->nearest.aov, &f->lights, f->view_address, f->color, swap);
}

static void add_decals(struct frame_state *f, bool swap) {
    debug_views_add_counts(f, (struct debug_counts){decals_count_add(f), 1}, swap);
}

static void add_edges(struct frame_state *f, bool swap) {
    debug_views_add_counts(f, (struct debug_counts){f->stored.surfaces, f->stored.surfaces.id ? 1 : 0}, swap);
}

static void add_halos(struct frame_state *f, bool swap) {
    graph_image metal = halos_add(f->graph, &f->scene->geometry, &f->draws, f->view_address, f->frame->width, f->frame->height);
    add_view(f, (struct debug_counts){0}, metal, swap);
}

static void add_motion(struct frame_state *f, bool swap) { motion_view_add(f->graph, f->temporal.motion, f->color, swap); }

/* By lists of its own: some orders have theirs for other points than pixels. */
static void add_shadows(struct frame_state *f, bool swap) {
    graph_push_names(f->graph, "debug view");
    const struct lighting lights = order_add_fallback_lists(f);
    graph_pop_names(f->graph);
    shadow_view_add(f->graph, (uint32_t)f->frame->debug, &f->nearest.aov, &lights, (graph_buffer){0}, f->view_address, f->color, swap);
}

static void add_classes(struct frame_state *f, bool swap) {
    if (!f->shadows.classes.id) { /* no lights, or more than may have maps: black */
        add_plain(f, swap);
        return;
    }
    const struct lighting lights = lighting_add(f->graph, f->r->device, &f->lighting, &f->shadows.surface_lights);
    shadow_view_add(f->graph, (uint32_t)f->frame->debug, &f->nearest.aov, &lights, f->shadows.classes, f->view_address, f->color, swap);
}

static fnl_result check_shadows(const struct call *call, const fnl_renderer *r, const fnl_frame *frame) {
    UNUSED(r);
    if (shadows_have(frame, SHADOWS_MAPS) || (shadows_have(frame, SHADOWS_ROOMS) && frame->debug == FNL_DEBUG_SHADOW_ERRORS)) return FNL_OK;
    return unsupported(call, "the debug view %s needs shadows maps or hybrid, not %s", fnl_value_name(FNL_ENUM_DEBUG_VIEW, frame->debug),
                       fnl_value_name(FNL_ENUM_SHADOWS, frame->shadows));
}

static fnl_result check_rays(const struct call *call, const fnl_renderer *r, const fnl_frame *frame) {
    UNUSED(r);
    if (shadows_have(frame, SHADOWS_EXACT)) return FNL_OK;
    return unsupported(call, "the debug view %s needs shadows rays, maps, hybrid or cubemap, not %s", fnl_value_name(FNL_ENUM_DEBUG_VIEW, frame->debug),
                       fnl_value_name(FNL_ENUM_SHADOWS, frame->shadows));
}

static fnl_result check_classes(const struct call *call, const fnl_renderer *r, const fnl_frame *frame) {
    UNUSED(r);
    if (shadow_maps_classify(frame)) return FNL_OK;
    return unsupported(call, "the debug view %s needs shadows maps or hybrid, shadow.classify, and a frame that it applies to", fnl_value_name(FNL_ENUM_DEBUG_VIEW, frame->debug));
}

static fnl_result check_probes(const struct call *call, const fnl_renderer *r, const fnl_frame *frame) {
    UNUSED(r);
    if (shadows_have(frame, SHADOWS_ROOMS)) return FNL_OK;
    return unsupported(call, "the debug view %s needs shadows cubemap, not %s", fnl_value_name(FNL_ENUM_DEBUG_VIEW, frame->debug),
                       fnl_value_name(FNL_ENUM_SHADOWS, frame->shadows));
}

static void add_reflections(struct frame_state *f, bool swap) {
    reflections_view_add(f->graph, &f->nearest.aov, &f->lighting.environment, f->view_address, f->color, swap);
}

static void add_denoise(struct frame_state *f, bool swap) {
    denoise_view_add(f->graph, &f->shadows.denoise, f->frame->debug == FNL_DEBUG_SHADOW_HISTORY, f->view_address, f->color, swap);
}

static fnl_result check_denoise(const struct call *call, const fnl_renderer *r, const fnl_frame *frame) {
    UNUSED(r);
    if (shadows_denoised(frame)) return FNL_OK;
    return unsupported(call, "the debug view %s needs shadows sampled and shadow.denoise", fnl_value_name(FNL_ENUM_DEBUG_VIEW, frame->debug));
}

static fnl_result check_primitive_ids(const struct call *call, const fnl_renderer *r, const fnl_frame *frame) {
    if (gpu_info(r->device)->primitive_ids) return FNL_OK;
    return unsupported(call, "the debug view %s needs primitive_ids, which this device does not support",
                       fnl_value_name(FNL_ENUM_DEBUG_VIEW, frame->debug));
}

static const struct debug_legend_color directions[] = {{{1, 0.5f, 0.5f}, "+X"}, {{0, 0.5f, 0.5f}, "-X"},    {{0.5f, 1, 0.5f}, "+Y up"},
                                                      {{0.5f, 0, 0.5f}, "-Y"}, {{0.5f, 0.5f, 1}, "+Z"}, {{0.5f, 0.5f, 0}, "-Z"}};
static const struct debug_legend_color edges[] = {{DEBUG_EDGE_SKY(LEGEND_COLOR), "one surface and sky"},
                                                  {DEBUG_EDGE_2(LEGEND_COLOR), "2 surfaces"},
                                                  {DEBUG_EDGE_3(LEGEND_COLOR), "3 surfaces"},
                                                  {DEBUG_EDGE_4(LEGEND_COLOR), "4 and more"}};
static const struct debug_legend_color movements[] = {{{128.0f / 255, 128.0f / 255, 128.0f / 255}, "stands still"}, {{0, 0, 0}, "not seen in the last frame"}};
static const struct debug_legend_color halos[] = {{DEBUG_METAL(LEGEND_COLOR), "metal"},
                                                  {DEBUG_HALO_DARK(LEGEND_COLOR), "0.1 to 0.9 with a dark base colour"},
                                                  {DEBUG_HALO_BRIGHT(LEGEND_COLOR), "0.1 to 0.9 with a bright one"}};
static const struct debug_legend_color without_pages[] = {{DEBUG_SHADOW_RAYS(LEGEND_COLOR), "rays find the shadow"}};
static const struct debug_legend_color texels[] = {{DEBUG_TEXEL_QUARTER(LEGEND_COLOR), "1/4 and less"},
                                                   {DEBUG_TEXEL_PIXEL(LEGEND_COLOR), "1"},
                                                   {DEBUG_TEXEL_WIDER(LEGEND_COLOR), "wider than 1"},
                                                   {DEBUG_TEXEL_8(LEGEND_COLOR), "8 and more"}};
static const struct debug_legend_color errors[] = {{DEBUG_SHADOW_EXTRA(LEGEND_COLOR), "light that should not be"},
                                                   {DEBUG_SHADOW_MISSING(LEGEND_COLOR), "light is missing"}};

static const struct debug_legend_color classes[] = {{DEBUG_CLASS_LEFT(LEGEND_COLOR), "left the list"},
                                                    {DEBUG_CLASS_DARK(LEGEND_COLOR), "light no pixel"},
                                                    {DEBUG_CLASS_SOME(LEGEND_COLOR), "light some"},
                                                    {DEBUG_CLASS_ALL(LEGEND_COLOR), "light all"}};

static const struct debug_view views[] = {
    {FNL_DEBUG_ALBEDO, LEGEND_TEXT("base colour; black: nothing"), .surfaces = true, .add = add_plain},
    {FNL_DEBUG_NORMAL, LEGEND_COLORS("the direction of the normal; black: nothing", directions), .surfaces = true, .add = add_plain},
    {FNL_DEBUG_DEPTH, LEGEND_GREY("depth z in metres, as 1 / (1 + 0.05 z): 20 m is halfway", "far away", "0 m"), .surfaces = true, .add = add_plain},
    {FNL_DEBUG_ROUGHNESS, LEGEND_GREY("perceptual roughness", "0 mirror", "1 dull"), .surfaces = true, .add = add_plain},
    {FNL_DEBUG_LIGHTS, LEGEND_COUNTS("lights that the pixel visits, without directional ones; no colour: none"), .surfaces = true, .add = add_lights},
    {FNL_DEBUG_CELLS, LEGEND_TEXT("tiles are coloured by the number of their lights, as in lights; slices and cells each in a hue; white: the grid"), .surfaces = true, .add = add_plain},
    {FNL_DEBUG_OVERDRAW, LEGEND_COUNTS("opaque fragments drawn at the pixel; black: none"), .surfaces = true, .add = add_overdraw},
    {FNL_DEBUG_TILE_NORMALS, LEGEND_COLORS("the axis of the tile's normals; black: too many directions", directions), .surfaces = true, .add = add_plain},
    {FNL_DEBUG_BACKFACES, LEGEND_COUNTS("lights that the tile drops; no colour: none"), .surfaces = true, .add = add_plain},
    {FNL_DEBUG_OVERSHADING, LEGEND_COUNTS("fragment shader invocations for the pixel; black: none"), .surfaces = true, .add = add_overshading},
    {FNL_DEBUG_LAYERS, LEGEND_COUNTS("blended surfaces at the pixel; no colour: none"), .surfaces = true, .add = add_layers},
    {FNL_DEBUG_DECALS, LEGEND_COUNTS("decals that hold the surface; no colour: none"), .surfaces = true, .add = add_decals},
    {FNL_DEBUG_EDGES, LEGEND_COLORS("what the samples of the pixel show; grey: one surface", edges), .surfaces = true, .add = add_edges},
    {FNL_DEBUG_MOTION, LEGEND_COLORS("hue: the direction of the movement; the more colour, the faster", movements), .add = add_motion},
    {FNL_DEBUG_HALOS, LEGEND_COLORS("metalness; grey: dielectrics", halos), .surfaces = true, .add = add_halos},
    {FNL_DEBUG_CLUSTERS, LEGEND_TEXT("each cluster of triangles in a colour of its own; grey: none"), .surfaces = true, .add = add_clusters, .check = check_primitive_ids},
    {FNL_DEBUG_TRIANGLES, LEGEND_TEXT("each triangle in its own color; gray: points and lines"), .surfaces = true, .add = add_triangles, .check = check_primitive_ids},
    {FNL_DEBUG_DEPTH_JUMPS, LEGEND_RAMP("largest depth of a tile over its smallest; gray: below 1.5", "1.5", "64 and more", 0.1f, 1), .surfaces = true, .add = add_plain},
    {FNL_DEBUG_LIGHT_VOLUMES, LEGEND_TEXT("each light in its own hue; bright lines: where a light's volume ends; gray: no light"), .surfaces = true, .add = add_light_volumes},
    {FNL_DEBUG_SHADOW_PAGES, LEGEND_COLORS("each page in a colour of its own, with its edges; grey: no light with a map", without_pages), .surfaces = true, .add = add_shadows, .check = check_shadows},
    {FNL_DEBUG_SHADOW_LEVELS, LEGEND_RAMP("level of the page, 0 is the finest; magenta: rays find the shadow", "7", "0", 1.0f / 8, 1), .surfaces = true, .add = add_shadows, .check = check_shadows},
    {FNL_DEBUG_SHADOW_TEXELS, LEGEND_COLORS("width of a texel of the map in pixels; magenta: rays find the shadow", texels), .surfaces = true, .add = add_shadows, .check = check_shadows},
    {FNL_DEBUG_SHADOW_ERRORS, LEGEND_COLORS("maps against rays, stronger where it is more of the pixel's light; grey: less than a fiftieth", errors), .surfaces = true, .add = add_shadows, .check = check_shadows},
    {FNL_DEBUG_PROBE_LOOKUP, LEGEND_TEXT("texels of the cube map, a hue for each face; grey: none"), .surfaces = true, .add = add_shadows, .check = check_probes},
    {FNL_DEBUG_PROBE_LEVELS, LEGEND_RAMP("level of the cube map, 0 is the finest; grey: none", "7", "0", 1.0f / 8, 1), .surfaces = true, .add = add_shadows, .check = check_probes},
    {FNL_DEBUG_REFLECTIONS, LEGEND_TEXT("each reflection probe in a hue, by its part of the light; grey: none"), .surfaces = true, .add = add_reflections},
    {FNL_DEBUG_SHADOW_RAYS, LEGEND_COUNTS("shadow rays that the pixel sends; no colour: none"), .surfaces = true, .add = add_shadows, .check = check_rays},
    {FNL_DEBUG_SHADOW_AGE, LEGEND_RAMP("frames since the page was drawn; magenta: rays find the shadow; stripes: a finer page is wanted", "63 and more", "0", 0, 1), .surfaces = true, .add = add_shadows, .check = check_shadows},
    {FNL_DEBUG_SHADOW_CLASSES, LEGEND_COLORS("the lights of a tile, each colour by its part of them", classes), .surfaces = true, .add = add_classes, .check = check_classes},
    {FNL_DEBUG_SHADOW_VARIANCE, LEGEND_RAMP("standard deviation of the part of the light that is seen", "0", "0.5 and more", 0, 1), .add = add_denoise, .check = check_denoise},
    {FNL_DEBUG_SHADOW_HISTORY, LEGEND_RAMP("frames that the pixel has collected", "0", "32 and more", 0, 1), .add = add_denoise, .check = check_denoise},
};

/* ---- the view of a frame ---- */

static const struct debug_view *find_among(const struct debug_view *rows, uint32_t count, fnl_debug_view view) {
    for (uint32_t i = 0; i < count; i++)
        if (rows[i].view == view) return &rows[i];
    return NULL;
}

const struct debug_view *debug_views_find(fnl_shading shading, fnl_debug_view view) {
    const struct debug_view *found = find_among(views, COUNT_OF(views), view);
    if (found || shading == FNL_SHADING_AUTO) return found;
    const struct order *order = shading_order(shading);
    return find_among(order->views, order->view_count, view);
}

static fnl_result check(const struct call *call, fnl_renderer *r, const fnl_frame *frame) {
    if (frame->debug == FNL_DEBUG_NONE) return FNL_OK;
    const struct debug_view *view = debug_views_find(frame->shading, frame->debug);
    if (view) return view->check ? view->check(call, r, frame) : FNL_OK;
    const char *name = fnl_value_name(FNL_ENUM_DEBUG_VIEW, frame->debug), *others = "";
    char paths[256] = "";
    for (uint32_t i = 0; i < FNL_SHADING_AUTO; i++) {
        if (!debug_views_find((fnl_shading)i, frame->debug)) continue;
        size_t length = strlen(paths);
        snprintf(paths + length, sizeof paths - length, "%s%s", others, fnl_value_name(FNL_ENUM_SHADING, i));
        others = " or ";
    }
    return unsupported(call, "the debug view %s needs %s shading, not %s", name, paths, fnl_value_name(FNL_ENUM_SHADING, frame->shading));
}

bool debug_views_need_surfaces(const fnl_frame *frame) {
    return frame->debug != FNL_DEBUG_NONE && debug_views_find(frame->shading, frame->debug)->surfaces;
}

void debug_views_add(struct frame_state *f, bool swap) { debug_views_find(f->frame->shading, f->frame->debug)->add(f, swap); }

const struct frame_step step_debug_views = {.name = "debug views", .check = check};
