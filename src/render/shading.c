/* SPDX-License-Identifier: MIT */
#include "render/shading.h"
#include "render/decals.h"

#include "passes/lights/sprites.h"
#include "passes/mobile/mobile.h"
#include "passes/shade/classify.h"
#include "passes/shade/deferred.h"
#include "passes/shade/deferred_msaa.h"
#include "passes/shade/deferred_screen.h"
#include "passes/shade/gbuffer_layouts.h"
#include "passes/shade/inferred.h"
#include "passes/shade/light_indexed.h"
#include "passes/shade/pre_lighting.h"
#include "passes/shade/regroup.h"
#include "passes/shade/volumes.h"
#include "passes/shade/zioma.h"
#include "passes/visibility/visibility.h"

static bool has_blend(const struct frame_state *f) {
    for (uint32_t i = 0; i < f->scene->geometry.bucket_count; i++)
        if (f->scene->geometry.buckets[i].blend) return true;
    return false;
}

static void add_lists(struct frame_state *f, graph_image depth, const struct gbuffer *gbuffer) {
    struct lists_context context = {.graph = f->graph,
                                    .device = f->r->device,
                                    .frame = f->frame,
                                    .view = &f->view,
                                    .device_scene = &f->r->device_scene,
                                    .scene = &f->scene->geometry,
                                    .draws = &f->draws,
                                    .input = &f->scene->lights,
                                    .state = &f->r->lists,
                                    .depth = depth,
                                    .gbuffer = gbuffer,
                                    .has_blend = has_blend(f),
                                    .pool_capacity = f->r->pool_capacity};
    lists_add(&context);
    f->lights = context.lights;
    f->blend_lights = context.blend_lights;
}

/* ---- forward ---- */

/* Batches and passes per light draw in an order of their own; what they are not for is shaded as with lists of objects. */
static bool draws_batches(const struct frame_state *f) {
    return f->frame->lists == FNL_LISTS_BATCHES && f->frame->msaa == 1 && f->lights.kind == GPU_LIST_ITEMS;
}

static bool draws_per_light(const struct frame_state *f) {
    return f->frame->lists == FNL_LISTS_MULTIPASS && f->frame->msaa == 1 && f->lights.kind == GPU_LIST_ITEMS &&
           multipass_fits(f->r->device, &f->scene->geometry, f->scene->lights.local_count);
}

/* The log is told once by each renderer that mesh lists stand in for others, the statistics with every frame. */
static void tell_of_mesh_lists(struct frame_state *f) {
    bool own = f->frame->lists == FNL_LISTS_BATCHES || f->frame->lists == FNL_LISTS_MULTIPASS;
    if (!own || f->lights.kind != GPU_LIST_ITEMS || draws_batches(f) || draws_per_light(f)) return;
    f->drawn_lists = FNL_LISTS_MESH;
    if (f->r->told_of_mesh_lists) return;
    f->r->told_of_mesh_lists = true;
    const char *name = fnl_light_lists_name(f->frame->lists);
    if (f->frame->msaa > 1)
        log_warning(&f->r->host, "%s lists have no MSAA: with %u samples per pixel objects are drawn with mesh lists", name,
                    f->frame->msaa);
    else
        log_warning(&f->r->host,
                    "%s lists: %u lights times %u groups of objects are too many passes, or this device cannot add 32-bit "
                    "floats: objects are drawn with mesh lists",
                    name, f->scene->lights.local_count, f->scene->geometry.group_count);
}

static void add_forward(struct frame_state *f, struct shade_input *input, bool prepass) {
    const struct light_input *lights = &f->scene->lights;
    add_lists(f, prepass ? f->depth : (graph_image){0}, NULL); /* a single pass knows no depth beforehand */
    if (draws_batches(f))
        batches_add(f->graph, input, f->radiance, f->depth);
    else if (draws_per_light(f))
        multipass_add(f->graph, input, lights->local_count, lights->directional_count, f->r->pool_capacity, f->radiance,
                      f->depth);
    else
        forward_add(f->graph, input, GEOMETRY_OPAQUE, prepass, f->radiance, f->depth);
    tell_of_mesh_lists(f);
}

/* ---- deferred ---- */

_Static_assert((uint32_t)FNL_MSAA_ALL == MSAA_ALL && (uint32_t)FNL_MSAA_COMPACT == MSAA_COMPACT &&
                   (uint32_t)FNL_MSAA_AGGREGATE == MSAA_AGGREGATE && FNL_MSAA_METHOD_COUNT == FNL_MSAA_AGGREGATE + 1,
               "deferred_msaa_shared.h has the values of fnl_msaa_method");

/* Lists see all samples of the depth, but no normals. */
static void add_deferred_samples(struct frame_state *f, struct shade_input *input, bool prepass) {
    struct gbuffer gbuffer = gbuffer_add(f->graph, input, prepass, f->radiance, f->depth);
    add_lists(f, f->depth, NULL);
    struct deferred_msaa_params params = {.method = (uint32_t)f->frame->msaa_method,
                                          .groups = f->frame->msaa_groups,
                                          .tolerance = f->frame->msaa_method == FNL_MSAA_ALL ? 0 : f->frame->msaa_tolerance};
    f->gbuffer = gbuffer;
    struct edges edges = deferred_msaa_add(f->graph, input, &gbuffer, &params, f->radiance);
    f->surfaces = edges.surfaces;
    f->edge_counts = edges.counts;
}

static void add_deferred(struct frame_state *f, struct shade_input *input, bool prepass) {
    if (f->frame->msaa > 1) {
        add_deferred_samples(f, input, prepass);
        return;
    }
    struct gbuffer gbuffer = gbuffer_add(f->graph, input, prepass, f->radiance, f->depth);
    decals_on_gbuffer_add(f, input, &gbuffer);
    add_lists(f, f->depth, &gbuffer);
    struct shade_classes classes = {0};
    if (f->frame->class_blocks) {
        classes = classify_add(f->graph, input, &gbuffer, f->frame->class_blocks);
        f->class_counts = classes.counts;
    }
    if (f->frame->deferred_pass == FNL_DEFERRED_FRAGMENT && deferred_screen_supported(f->r->device))
        f->radiance = deferred_screen_add(f->graph, input, &gbuffer, f->radiance);
    else
        deferred_add(f->graph, input, &gbuffer, f->frame->class_blocks ? &classes : NULL, f->radiance);
    hybrid_add(f->graph, input, &gbuffer, f->radiance);
    f->gbuffer = gbuffer;
}

_Static_assert((int)FNL_VOLUME_SOLIDS == VOLUME_SOLIDS && (int)FNL_VOLUME_SHAPE_COUNT == VOLUME_DEPTH_BOUNDS + 1,
               "volumes_shared.h has the values of fnl_volume_shape");

static struct volumes prepare_volumes(struct frame_state *f, uint32_t shape) {
    struct volumes_input input = {&f->scene->lights, f->view_address, f->frame->list_options.frustum_cull, shape};
    return volumes_prepare(f->graph, f->r->device, &input);
}

/* The lights in view are those whose volumes are drawn, where no lists count them. */
static void count_volumes(struct frame_state *f, const struct volumes *volumes) {
    f->lights.totals = f->blend_lights.totals = volumes->totals;
    f->lights.totals_known = false;
}

/* Everything but local lights in one pass over the screen, then a volume for each of those. */
static void add_volumes(struct frame_state *f, struct shade_input *input, bool prepass) {
    struct gbuffer gbuffer = gbuffer_add(f->graph, input, prepass, f->radiance, f->depth);
    decals_on_gbuffer_add(f, input, &gbuffer);
    struct light_list own = {0}; /* of what is lit forward */
    bool has_lists = has_blend(f) || gbuffer.mask.id;
    if (has_lists) {
        add_lists(f, f->depth, gbuffer.mask.id ? &gbuffer : NULL);
        own = f->lights;
        if (!gbuffer.mask.id) f->lights = f->blend_lights; /* opaque surfaces need none: what makes them is not run */
    } else {
        f->lights = f->blend_lights = light_list_all_add(f->graph, f->r->device, &f->scene->lights);
    }
    struct light_input none = f->scene->lights;
    none.local_count = 0;
    struct light_list base = light_list_all_add(f->graph, f->r->device, &none);
    input->lights = &base;
    deferred_add(f->graph, input, &gbuffer, NULL, f->radiance);
    struct volumes volumes = prepare_volumes(f, (uint32_t)f->frame->list_options.volume_shape);
    volumes_add(f->graph, input, &volumes, &gbuffer, f->radiance);
    if (gbuffer.mask.id) {
        input->lights = &own;
        hybrid_add(f->graph, input, &gbuffer, f->radiance);
    }
    f->gbuffer = gbuffer;
    if (!has_lists) count_volumes(f, &volumes);
}

/* ---- visibility ---- */

static void add_visibility(struct frame_state *f, struct shade_input *input, bool prepass) {
    UNUSED(prepass);
    struct visibility visibility = visibility_add(f->graph, input, f->r->visibility_bits, f->depth);
    add_lists(f, f->depth, NULL);
    visibility_shade_add(f->graph, input, &visibility, f->radiance);
}

/* ---- mobile ---- */

/* What the device can do of what was asked for. */
static bool mobile_resolve(const gpu_device *device, const fnl_frame *frame, struct mobile_params *out) {
    const fnl_mobile_options *o = &frame->mobile;
    *out = (struct mobile_params){.layout = o->layout,
                                  .gamma = o->gamma,
                                  .float_light = o->light == FNL_MOBILE_LIGHT_FLOAT || frame->exposure == FNL_EXPOSURE_AUTO,
                                  .separate = o->separate,
                                  .recycle = o->recycle};
    bool supported = mobile_supported(device, out);
    if (!supported && frame->exposure != FNL_EXPOSURE_AUTO) { /* fractions need to know what white is */
        out->float_light = !out->float_light;
        supported = mobile_supported(device, out);
    }
    out->scale = mobile_scale(out, frame_exposure(frame), o->range);
    return supported;
}

bool shading_supported(fnl_renderer *r, const fnl_frame *frame) {
    struct mobile_params params;
    if (frame->shading != FNL_SHADING_MOBILE || mobile_resolve(r->device, frame, &params)) return true;
    log_error(&r->host, "this device cannot draw to the formats of layout %s", fnl_mobile_layout_name(frame->mobile.layout));
    return false;
}

void shading_scale_light(struct frame_state *f) {
    struct mobile_params params;
    f->view.light_scale = f->view.light_max = 1;
    if (f->frame->shading != FNL_SHADING_MOBILE || !mobile_resolve(f->r->device, f->frame, &params)) return;
    f->view.light_scale = params.scale.scale;
    f->view.light_max = params.scale.most;
}

static void note_once(fnl_renderer *r, uint32_t bit, const char *text) {
    if (r->mobile_notes >> bit & 1) return;
    r->mobile_notes |= 1u << bit;
    log_warning(&r->host, "mobile shading: %s", text);
}

/* Whether nothing but the picture is wanted, and all that makes it is known before the scope begins. */
static bool mobile_tonemaps(struct frame_state *f, bool blend_inside) {
    const fnl_frame *frame = f->frame;
    if (!f->target && !(frame->outputs & FNL_OUTPUT_COLOR)) return false;
    if (frame->debug != FNL_DEBUG_NONE || frame->aa == FNL_ANTIALIASING_TAA) return false;
    if (frame->outputs & FNL_OUTPUT_RADIANCE) return false;
    if (frame->exposure == FNL_EXPOSURE_AUTO) return false; /* metering wants the whole frame first */
    return blend_inside || !has_blend(f);
}

static void add_mobile(struct frame_state *f, struct shade_input *input, bool prepass) {
    struct mobile_params params;
    if (!mobile_resolve(f->r->device, f->frame, &params)) return; /* checked before */
    if (params.layout <= FNL_MOBILE_SPECULAR_160 && params.float_light != (f->frame->mobile.light == FNL_MOBILE_LIGHT_FLOAT))
        note_once(f->r, 0,
                  params.float_light ? "light adds up in floats: fractions need an exposure that is known beforehand"
                                     : "light adds up in fractions: the device cannot blend packed floats");
    add_lists(f, prepass ? f->depth : (graph_image){0}, NULL); /* the scope knows no depth beforehand */
    struct shade_input blend = *input;
    blend.lights = &f->blend_lights;
    if (!f->frame->count_lights) blend.counters = (graph_buffer){0};
    params.separate |= f->r->cannot_merge;
    /* What is drawn over opaque surfaces comes before blended ones. */
    bool more = f->frame->light_lod > 0 || decals_redraws(f);
    f->blended = has_blend(f) && !more && f->frame->transparency == FNL_TRANSPARENCY_SORTED;
    const struct mobile_decals decals = {&f->decals.list, f->decals.buffers.decals};
    struct picture picture = frame_picture(f);
    f->mobile_tonemapped = !more && mobile_tonemaps(f, f->blended);
    struct mobile_finish finish = {.format = picture.format, .picture = true, .tonemap = picture.tonemap};
    if (!f->mobile_tonemapped) finish = (struct mobile_finish){.format = shading_format(f), .target = f->radiance};
    struct mobile_result result = mobile_add(f->graph, input, f->blended ? &blend : NULL, prepass, f->depth, &params,
                                             decals_in_gbuffer(f) ? &decals : NULL, &finish);
    if (f->mobile_tonemapped) f->color = result.target;
    f->mobile_merged = result.merged;
    if (!result.merged && !f->frame->mobile.separate)
        note_once(f->r, 1,
                  "the device cannot keep so many attachments in one scope: passes are separate and the G-buffer is stored");
}

/* ---- blended surfaces ---- */

static void add_transparency(struct frame_state *f, const struct shade_input *input) {
    fnl_renderer *r = f->r;
    if (f->frame->transparency == FNL_TRANSPARENCY_LINKED) {
        struct linked_params params = {r->blend_capacity};
        f->linked = linked_add(f->graph, input, &params, f->radiance, f->depth);
        f->blend_bytes = f->linked.byte_count;
    } else if (f->frame->transparency == FNL_TRANSPARENCY_WEIGHTED) {
        bool half = r->weighted_half || weighted_needs_half(r->device);
        weighted_add(f->graph, input, half, f->radiance, f->depth);
        f->blend_bytes = (uint64_t)f->frame->width * f->frame->height * f->frame->msaa * weighted_bytes(half);
    } else {
        forward_add(f->graph, input, GEOMETRY_BLEND, false, f->radiance, f->depth);
    }
}

static uint32_t blend_draw_count(const struct frame_state *f) {
    uint32_t draws = geometry_draw_count(&f->scene->geometry, GEOMETRY_BLEND);
    if (!has_blend(f) || f->frame->transparency == FNL_TRANSPARENCY_SORTED) return draws;
    return (f->frame->transparency == FNL_TRANSPARENCY_LINKED ? 2 : 1) * draws + f->frame->msaa;
}

/* ---- light apart from materials ---- */

_Static_assert((int)FNL_LIGHT_BUFFER_RGBA == LIGHT_BUFFER_RGBA && (int)FNL_LIGHT_BUFFER_FOUR == LIGHT_BUFFER_FOUR,
               "the shaders' values are the options'");

static uint32_t light_buffer(const struct frame_state *f, uint32_t automatic) {
    fnl_light_buffer buffer = f->frame->list_options.light_buffer;
    return buffer == FNL_LIGHT_BUFFER_AUTO ? automatic : (uint32_t)buffer;
}

/* Bytes of the targets of sums, and with them of the surfaces that they were made for. */
static uint64_t light_bytes(const struct frame_state *f, const struct light_sums *sums, uint64_t surface_bytes) {
    uint32_t texel = graph_image_info(f->graph, sums->targets[0]).format == VK_FORMAT_R32G32B32A32_SFLOAT ? 16 : 8;
    return surface_bytes + (uint64_t)sums->width * sums->height * (sums->target_count * texel + (sums->samples.id ? 4 : 0));
}

static void add_light_sums(struct frame_state *f, struct shade_input *input, bool prepass, uint32_t buffer, uint32_t scale) {
    struct light_surfaces surfaces = light_surfaces_add(f->graph, input, prepass, buffer, f->depth);
    struct gbuffer normals = light_surfaces_normals(&surfaces);
    add_lists(f, f->depth, &normals);
    struct light_sums sums =
        light_sums_create(f->graph, input, buffer, scale, graph_image_info(f->graph, f->radiance).format);
    light_sums_add(f->graph, input, &surfaces, &sums);
    light_material_add(f->graph, input, &surfaces, &sums, f->radiance);
    f->light_bytes = light_bytes(f, &sums, (buffer == LIGHT_BUFFER_TWO ? 12ull : 8ull) * input->width * input->height);
}

static void add_light_prepass(struct frame_state *f, struct shade_input *input, bool prepass) {
    add_light_sums(f, input, prepass, light_buffer(f, LIGHT_BUFFER_TWO), 1);
}

/* Lists of blended surfaces alone, where opaque ones find their lights without. */
static void add_blend_lists(struct frame_state *f) {
    if (has_blend(f)) {
        add_lists(f, f->depth, NULL);
        f->lights = f->blend_lights;
    } else {
        f->lights = f->blend_lights = light_list_all_add(f->graph, f->r->device, &f->scene->lights);
    }
}

static void add_pre_lighting(struct frame_state *f, struct shade_input *input, bool prepass) {
    struct light_surfaces surfaces = light_surfaces_add(f->graph, input, prepass, LIGHT_BUFFER_TWO, f->depth);
    add_blend_lists(f);
    struct light_input none = f->scene->lights;
    none.local_count = 0;
    struct light_list base = light_list_all_add(f->graph, f->r->device, &none);
    input->lights = &base;
    struct light_sums sums = light_sums_create(f->graph, input, LIGHT_BUFFER_TWO, 1, volumes_format(f->r->device));
    light_sums_add(f->graph, input, &surfaces, &sums);
    struct volumes volumes = prepare_volumes(f, VOLUME_QUADS);
    pre_lighting_add(f->graph, input, &volumes, &surfaces, &sums);
    light_material_add(f->graph, input, &surfaces, &sums, f->radiance);
    f->light_bytes = light_bytes(f, &sums, 12ull * input->width * input->height);
    if (!has_blend(f)) count_volumes(f, &volumes);
}

/* ---- lights written into pixels ---- */

_Static_assert((int)FNL_LIGHT_PACKING_SHIFT == INDEXED_SHIFT && (int)FNL_LIGHT_PACKING_MAX == INDEXED_MAX,
               "light_indexed_shared.h has the values of fnl_light_packing");

static void add_light_indexed(struct frame_state *f, struct shade_input *input, bool prepass) {
    UNUSED(prepass);
    add_blend_lists(f);
    struct volumes volumes = prepare_volumes(f, VOLUME_DEPTH_BOUNDS);
    struct indexed_params params = {(uint32_t)f->frame->list_options.light_packing, f->frame->list_options.light_layers};
    f->lights = light_indexed_add(f->graph, f->r->device, input, &volumes, &f->scene->lights, f->depth, &params);
    input->lights = &f->lights;
    forward_add(f->graph, input, GEOMETRY_OPAQUE, true, f->radiance, f->depth);
}

static void add_zioma(struct frame_state *f, struct shade_input *input, bool prepass) {
    UNUSED(prepass);
    add_blend_lists(f);
    struct volumes volumes = prepare_volumes(f, VOLUME_SOLIDS);
    uint32_t layers = MIN(f->frame->list_options.light_layers, ZIOMA_LAYERS);
    zioma_add(f->graph, input, &volumes, layers, f->radiance, f->depth);
    f->light_bytes = 36ull * layers * input->width * input->height;
    f->lights.totals = volumes.totals;
    f->lights.totals_known = false;
}

/* Everything of light at a lower resolution, lists included: the frame, for as long as they are made, is a smaller one. */
static void add_inferred(struct frame_state *f, struct shade_input *input, bool prepass) {
    UNUSED(prepass);
    const fnl_frame *frame = f->frame;
    struct gpu_view view = f->view;
    struct light_input *lights = &f->scene->lights;
    const struct light_input whole = *lights;
    fnl_frame low_frame = *frame;
    lights->width = low_frame.width = f->view.size.x = DIVIDE_UP(frame->width, frame->list_options.light_scale);
    lights->height = low_frame.height = f->view.size.y = DIVIDE_UP(frame->height, frame->list_options.light_scale);
    f->view.inverse_size = (vec2){1 / (float)low_frame.width, 1 / (float)low_frame.height};
    struct gpu_slice slice = gpu_frame_allocate(f->r->device, sizeof f->view);
    if (slice.data) memcpy(slice.data, &f->view, sizeof f->view);
    lights->view = slice.address;
    f->frame = &low_frame;

    bool blend = has_blend(f) && frame->transparency == FNL_TRANSPARENCY_SORTED;
    struct shade_input low = *input;
    low.view = slice.address;
    low.width = low_frame.width;
    low.height = low_frame.height;
    struct inferred inferred = inferred_surfaces_add(f->graph, &low, blend);
    struct gbuffer normals = light_surfaces_normals(&inferred.surfaces);
    add_lists(f, inferred.surfaces.depth, &normals);
    uint32_t buffer = light_buffer(f, LIGHT_BUFFER_FOUR) == LIGHT_BUFFER_RGBA ? LIGHT_BUFFER_RGBA : LIGHT_BUFFER_FOUR;
    struct light_sums sums = light_sums_create(f->graph, &low, buffer, 1, graph_image_info(f->graph, f->radiance).format);
    light_sums_add(f->graph, &low, &inferred.surfaces, &sums);

    f->view = view;
    f->frame = frame;
    lights->width = whole.width;
    lights->height = whole.height;
    lights->view = whole.view;
    f->blend_lights = light_list_all_add(f->graph, f->r->device, lights);
    input->lights = &f->blend_lights;
    inferred_material_add(f->graph, input, GEOMETRY_OPAQUE, &inferred, &sums, f->radiance, f->depth);
    if (blend) inferred_material_add(f->graph, input, GEOMETRY_BLEND, &inferred, &sums, f->radiance, f->depth);
    f->blended = blend;
    f->light_bytes = light_bytes(f, &sums, 16ull * low.width * low.height); /* its depth is not the frame's */
    if (frame->debug == FNL_DEBUG_LIGHTS || frame->debug == FNL_DEBUG_CELLS)
        f->lights = f->blend_lights; /* the view would look for pixels where there are texels */
}

static void add_low_res(struct frame_state *f, struct shade_input *input, bool prepass) {
    add_light_sums(f, input, prepass, light_buffer(f, LIGHT_BUFFER_FOUR), f->frame->list_options.light_scale);
}

/* ---- the table ---- */

static const struct order {
    /* Declares lists and opaque surfaces; f->depth is complete with `prepass`. `input` is a copy that the order may change. */
    void (*add)(struct frame_state *f, struct shade_input *input, bool prepass);
    uint32_t traits;
} orders[FNL_SHADING_COUNT] = {
    [FNL_SHADING_FORWARD] = {add_forward, SHADING_FORWARD | SHADING_ITEMS | SHADING_SAMPLES},
    [FNL_SHADING_FORWARD_PREPASS] = {add_forward, SHADING_FORWARD | SHADING_ITEMS | SHADING_PREPASS | SHADING_SAMPLES},
    [FNL_SHADING_DEFERRED] = {add_deferred, SHADING_GBUFFER | SHADING_POSITIONS | SHADING_SAMPLES | SHADING_LAYOUTS},
    [FNL_SHADING_DEFERRED_VOLUMES] = {add_volumes, SHADING_GBUFFER | SHADING_BLENDS | SHADING_LAYOUTS | SHADING_VOLUMES},
    [FNL_SHADING_LIGHT_PREPASS] = {add_light_prepass, SHADING_GBUFFER | SHADING_POSITIONS | SHADING_REDRAW},
    [FNL_SHADING_PRE_LIGHTING] = {add_pre_lighting, SHADING_GBUFFER | SHADING_REDRAW | SHADING_VOLUMES},
    [FNL_SHADING_INFERRED] = {add_inferred,
                              SHADING_GBUFFER | SHADING_PREPASS | SHADING_POSITIONS | SHADING_REDRAW | SHADING_APPROXIMATE},
    [FNL_SHADING_LIGHT_INDEXED] = {add_light_indexed, SHADING_PREPASS | SHADING_VOLUMES},
    [FNL_SHADING_ZIOMA] = {add_zioma, SHADING_PREPASS | SHADING_VOLUMES},
    [FNL_SHADING_LOW_RES] = {add_low_res, SHADING_GBUFFER | SHADING_POSITIONS | SHADING_REDRAW | SHADING_APPROXIMATE},
    /* Drivers filter explicit gradients in ways of their own: passes/visibility/scenes_test.c compares it without anisotropy. */
    [FNL_SHADING_VISIBILITY] = {add_visibility, SHADING_ITEMS | SHADING_APPROXIMATE},
    [FNL_SHADING_MOBILE] = {add_mobile, SHADING_POSITIONS | SHADING_APPROXIMATE},
};

bool shading_is(fnl_shading shading, uint32_t traits) { return (orders[shading].traits & traits) == traits; }

bool shading_has_prepass(const fnl_frame *frame) {
    return shading_is(frame->shading, SHADING_PREPASS) ||
           ((shading_is(frame->shading, SHADING_GBUFFER) || frame->shading == FNL_SHADING_MOBILE) && frame->gbuffer_prepass);
}

bool shading_shows_volumes(const fnl_frame *frame) {
    return shading_is(frame->shading, SHADING_VOLUMES) && frame->debug == FNL_DEBUG_LIGHTS;
}

VkFormat shading_format(const struct frame_state *f) {
    if (f->frame->outputs & FNL_OUTPUT_RADIANCE) return VK_FORMAT_R32G32B32A32_SFLOAT;
    return shading_is(f->frame->shading, SHADING_BLENDS) ? volumes_format(f->r->device) : VK_FORMAT_R16G16B16A16_SFLOAT;
}

void shading_add(struct frame_state *f) {
    f->radiance = frame_create_image(f, "radiance", shading_format(f), f->frame->msaa);
    f->depth = frame_create_image(f, "depth", GEOMETRY_DEPTH_FORMAT, f->frame->msaa);
    vec3 background = f->r->scene->background;
    const struct shade_input input = {.scene = &f->scene->geometry,
                                      .draws = &f->draws,
                                      .lights = &f->lights,
                                      .view = f->view_address,
                                      .width = f->frame->width,
                                      .height = f->frame->height,
                                      .counters = f->counters,
                                      .background = {background.x, background.y, background.z},
                                      .layout = f->frame->gbuffer,
                                      .normals = f->frame->normals,
                                      .chroma = f->frame->chroma};
    bool prepass = shading_has_prepass(f->frame);
    if (prepass) prepass_add(f->graph, &f->scene->geometry, &f->draws, f->view_address, f->depth);
    struct shade_input opaque = input, blend = input;
    orders[f->frame->shading].add(f, &opaque, prepass);
    decals_redraw(f, &input);
    if (f->frame->light_lod > 0) sprites_add(f->graph, &f->whole_lights, f->frame->light_lod, f->radiance, f->depth);
    if (has_blend(f) && !f->blended) {
        blend.lights = &f->blend_lights;
        if (!f->frame->count_lights) blend.counters = (graph_buffer){0};
        add_transparency(f, &blend);
    }
}

uint64_t shading_gbuffer_bytes(const struct frame_state *f) {
    const struct gbuffer *g = &f->gbuffer;
    if (!g->depth.id) return 0;
    uint64_t bytes = gbuffer_bytes(f->frame->gbuffer, f->frame->normals, f->frame->chroma) + (g->mask.id ? 1 : 0);
    return bytes * f->frame->width * f->frame->height * f->frame->msaa;
}

uint32_t shading_draw_count(const struct frame_state *f) {
    const struct geometry_scene *scene = &f->scene->geometry;
    uint32_t opaque = geometry_draw_count(scene, GEOMETRY_OPAQUE), prepass = shading_has_prepass(f->frame) ? opaque : 0;
    if (draws_batches(f)) opaque = batches_draw_count(scene);
    if (draws_per_light(f))
        opaque = multipass_draw_count(scene, f->scene->lights.local_count, f->scene->lights.directional_count);
    if (shading_is(f->frame->shading, SHADING_REDRAW)) opaque *= 2;
    if (f->gbuffer.mask.id) opaque += geometry_draw_count(scene, GEOMETRY_NOT_IN(f->frame->gbuffer));
    return prepass + opaque + blend_draw_count(f);
}
