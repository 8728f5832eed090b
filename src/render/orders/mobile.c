/* SPDX-License-Identifier: MIT */
#include "render/decals.h"
#include "render/orders/order.h"

#include "render/debug_views.h"
#include "render/shading.h"

#include "passes/mobile/mobile.h"

/* What the device can do of what was asked for. */
static bool resolve(const gpu_device *device, const fnl_frame *frame, struct mobile_params *out) {
    const fnl_mobile_options *o = &frame->mobile;
    *out = (struct mobile_params){.layout = o->layout,
                                  .gamma = o->gamma,
                                  .float_light = o->light == FNL_MOBILE_LIGHT_FLOAT || frame->exposure == FNL_EXPOSURE_AUTO,
                                  .separate = o->separate,
                                  .sum_format = volumes_format(device),
                                  .recycle = o->recycle};
    bool supported = mobile_supported(device, out);
    if (!supported && frame->exposure != FNL_EXPOSURE_AUTO) { /* fractions need to know what white is */
        out->float_light = !out->float_light;
        supported = mobile_supported(device, out);
    }
    out->scale = mobile_scale(out, frame_exposure(frame), o->range);
    return supported;
}

static uint32_t adjust(const fnl_frame *frame, uint32_t traits) {
    return frame->mobile.lights == FNL_MOBILE_LIGHTS_VOLUMES ? traits | SHADING_VOLUMES : traits;
}

static fnl_result check(const struct call *call, const fnl_renderer *r, const fnl_frame *frame) {
    struct mobile_params params;
    if (resolve(r->device, frame, &params)) return FNL_OK;
    return unsupported(call, "this device cannot draw to the formats of layout %s", fnl_value_name(FNL_ENUM_MOBILE_LAYOUT, frame->mobile.layout));
}

static void begin(struct frame_state *f) {
    struct mobile_params params;
    if (!resolve(f->r->device, f->frame, &params)) return; /* checked before */
    f->shared.light_scale = params.scale.scale;
    f->shared.light_max = params.scale.most;
}

static void note_once(const struct frame_state *f, uint32_t note, const char *text) {
    if (FRAME_TELLS(f, mobile[note])) log_warning(&f->r->host, "mobile shading: %s", text);
}

/* Whether nothing but the picture is wanted, and all that makes it is known before the scope begins. */
static bool tonemaps(struct frame_state *f, bool blend_inside) {
    const fnl_frame *frame = f->frame;
    if (!f->input->target && !(frame->outputs & FNL_OUTPUT_COLOR)) return false;
    if (frame->debug != FNL_DEBUG_NONE || frame->aa == FNL_ANTIALIASING_TAA) return false;
    if (frame->outputs & FNL_OUTPUT_RADIANCE) return false;
    if (frame->exposure == FNL_EXPOSURE_AUTO) return false; /* metering wants the whole frame first */
    return blend_inside || !surfaces_have_blend(f);
}

struct tap_data {
    graph_image targets[MOBILE_TARGETS];
    graph_buffer buffer;
    uint64_t bytes; /* of a target */
    uint32_t count;
};

static void execute_tap(const struct graph_context *context, const void *data) {
    const struct tap_data *d = data;
    for (uint32_t i = 0; i < d->count; i++)
        gpu_copy_image_to_buffer(context->commands, graph_get_image(context, d->targets[i]),
                                 graph_get_buffer(context, d->buffer), i * d->bytes);
}

/* For tests: what the scope leaves at each pixel. */
static void add_tap(struct frame_state *f, const struct mobile_result *result) {
    struct tap_data data = {.buffer = graph_import_buffer(f->graph, "mobile tap", renderer_tests(f->r).mobile_tap),
                            .bytes = (uint64_t)f->frame->width * f->frame->height * 4,
                            .count = result->target_count};
    memcpy(data.targets, result->targets, sizeof data.targets);
    struct graph_pass *pass = graph_add_pass(f->graph, "mobile tap", GRAPH_QUEUE_GRAPHICS, execute_tap, &data, sizeof data);
    for (uint32_t i = 0; i < data.count; i++) graph_use_image(pass, data.targets[i], GRAPH_COPY_FROM);
    graph_use_buffer(pass, data.buffer, GRAPH_COPY_TO);
    pass = graph_add_pass(f->graph, "mobile tap to host", GRAPH_QUEUE_GRAPHICS, NULL, NULL, 0);
    graph_keep(pass);
    graph_use_buffer(pass, data.buffer, GRAPH_READ_HOST);
}

static void add(struct frame_state *f, struct shade_input *input, bool prepass) {
    struct mobile_params params;
    if (!resolve(f->r->device, f->frame, &params)) return; /* checked before */
    if (params.layout <= FNL_MOBILE_SPECULAR_160 && params.float_light != (f->frame->mobile.light == FNL_MOBILE_LIGHT_FLOAT))
        note_once(f, 0,
                  params.float_light ? "light adds up in floats: fractions need an exposure that is known beforehand"
                                     : "light adds up in fractions: the device cannot blend packed floats");
    bool by_volumes = frame_is(f->frame, SHADING_VOLUMES), has_blend = surfaces_have_blend(f);
    if (!by_volumes || has_blend)
        order_add_lists(f, prepass ? f->depth : (graph_image){0}, NULL); /* the scope knows no depth beforehand */
    graph_set_role(f->graph, GRAPH_ROLE_SHADING);
    struct lighting base;
    struct volumes volumes;
    if (by_volumes) {
        base = order_light_by_suns(f);
        input->lighting = base.lights.directional_count ? &base : NULL;
        uint32_t shape = (uint32_t)f->frame->volume_shape;
        if (shape == VOLUME_STENCIL) shape = VOLUME_DEPTH_BOUNDS; /* the scope has no stencil */
        volumes = order_prepare_volumes(f, shape, 1);
        if (!has_blend) f->blend_lights = order_light_by_all(f);
        f->lights = f->blend_lights;
        if (!has_blend) order_count_volumes(f, &volumes);
    }
    struct shade_input blend_input = *input;
    blend_input.lighting = &f->blend_lights;
    if (!f->frame->count_lights) blend_input.counters = (graph_buffer){0};
    const struct mobile_blend blend = {.input = &blend_input,
                                       .weighted = f->frame->transparency == FNL_TRANSPARENCY_WEIGHTED,
                                       .half = renderer_tests(f->r).weighted_half || weighted_needs_half(f->r->device)};
    params.separate |= renderer_tests(f->r).cannot_merge;
    /* What is drawn over opaque surfaces comes before blended ones. */
    bool more = shading_shows_sky(f) || surfaces_have_glass(f) || surfaces_over(f) || f->frame->light_lod > 0 || decals_redraws(f);
    f->done.blended = has_blend && !more && f->frame->transparency != FNL_TRANSPARENCY_LINKED;
    if (f->done.blended && blend.weighted)
        counters_note(f, "transparency.bytes", (uint64_t)f->frame->width * f->frame->height * weighted_bytes(blend.half));
    const struct mobile_decals decals = {&f->decals.list, f->decals.buffers.decals};
    struct picture picture = frame_picture(f);
    bool tonemapped = !more && tonemaps(f, f->done.blended);
    struct mobile_finish finish = {.format = picture.format, .picture = true, .tonemap = picture.tonemap};
    if (!tonemapped) finish = (struct mobile_finish){.format = shading_format(f), .target = f->radiance};
    struct mobile_result result = mobile_add(f->graph, input, f->done.blended ? &blend : NULL, by_volumes ? &volumes : NULL,
                                             prepass, f->depth, &params, decals_in_gbuffer(f) ? &decals : NULL, &finish);
    if (tonemapped) f->color = result.target;
    counters_note(f, "mobile.merged", result.merged);
    counters_note(f, "mobile.tonemapped-inside", result.merged && tonemapped);
    if (renderer_tests(f->r).mobile_tap) add_tap(f, &result);
    if (!result.merged && !f->frame->mobile.separate)
        note_once(f, 1,
                  "the device cannot keep so many attachments in one scope: passes are separate and the G-buffer is stored");
}

static const struct counter rows[] = {
    {"mobile.merged", "", "whether all passes shared one scope", .kind = FNL_COUNTER_SWITCH},
    {"mobile.tonemapped-inside", "", "whether tone mapping was in that scope too", .kind = FNL_COUNTER_SWITCH},
};
static const struct counter_table counters_mobile = COUNTER_TABLE(rows);

const struct order order_mobile = {.traits = SHADING_VIEWS | SHADING_FULL_RASTER | SHADING_MAY_PREPASS | SHADING_LISTS_FIRST |
                                             SHADING_POSITIONS | SHADING_APPROXIMATE | SHADING_DECALS | SHADING_DECAL_STEP,
                                   .adjust = adjust,
                                   .check = check,
                                   .begin = begin,
                                   .add = add,
                                   .counters = &counters_mobile};
