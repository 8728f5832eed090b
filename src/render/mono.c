/* SPDX-License-Identifier: MIT */
#include "render/mono.h"

#include "passes/stereo/mono.h"
#include "passes/stereo/mono_shared.h"
#include "render/step.h"
#include "render/traits.h"

/* passes/stereo/mono_shared.h */
struct mono_counts {
    uint32_t pixels[MONO_COUNTS];
};
static const struct counter_table counters_mono;

/* ---- what a frame may ask for ---- */

static const char *find_problem(const fnl_frame *frame) {
    if (frame->stereo.eyes == 0) return "needs eyes (stereo.eyes)";
    if (frame->msaa > 1) return "needs 1 sample per pixel (msaa)";
    if (frame->occlusion == FNL_OCCLUSION_ON) return "does not go together with occlusion";
    if (frame->culling != FNL_CULLING_INSTANCES) return "does not go together with culling by clusters or triangles";
    if (frame->aa == FNL_ANTIALIASING_TAA) return "does not go together with aa=taa";
    if (frame->debug != FNL_DEBUG_NONE) return "does not go together with debug views";
    if (frame->pixel.asked) return "does not go together with queries of pixels";
    if (frame->outputs & ~(uint32_t)(FNL_OUTPUT_COLOR | FNL_OUTPUT_RADIANCE)) return "does not go together with outputs other than COLOR and RADIANCE";
    if (shadows_denoised(frame)) return "does not go together with shadow.denoise";
    if (shadows_guided(frame)) return "does not go together with shadow.guide";
    if (frame->view_count + frame->view_count / frame->stereo.eyes > FNL_VIEWS_MAX) return "needs a view more for each display: there are too many";
    for (uint32_t i = 0; i < frame->view_count; i++)
        if (frame->views[i].orthographic) return "needs perspective cameras";
    return NULL;
}

static fnl_result check(const struct call *call, fnl_renderer *r, const fnl_frame *frame) {
    UNUSED(r);
    if (!(frame->stereo.mono_distance > 0)) return FNL_OK;
    const char *problem = find_problem(frame);
    if (problem) return unsupported(call, "stereo.mono_distance %s", problem);
    const bool deferred = frame->shading == FNL_SHADING_AUTO; /* which that is in frames of several views */
    if (!deferred && !(shading_is(frame->shading, SHADING_MULTIVIEW) && frame_is(frame, SHADING_HIDDEN)))
        return shading_refuse(call, "stereo.mono_distance", frame, SHADING_HIDDEN | SHADING_MULTIVIEW);
    if (frame->lists == FNL_LISTS_BATCHES || frame->lists == FNL_LISTS_MULTIPASS)
        return unsupported(call, "stereo.mono_distance does not go together with the lists %s", fnl_value_name(FNL_ENUM_LISTS, frame->lists));
    return FNL_OK;
}

/* ---- the view ---- */

void mono_frame(const fnl_frame *frame, const struct view_group *group, fnl_frame *out) {
    *out = *frame;
    out->views = NULL;
    out->view_count = 0;
    out->hidden_areas = NULL;
    out->overlay = NULL;
    out->outputs &= FNL_OUTPUT_RADIANCE; /* which decides about the format */
    out->aa = FNL_ANTIALIASING_NONE;
    out->camera = group->far_camera;
    out->width = group->has_far ? group->far_width : 1;
    out->height = group->has_far ? group->far_height : 1;
}

static struct mono_eye eye_of(const struct frame_state *f) {
    const bool far = f->group.eyes;
    return (struct mono_eye){f->view_address, far ? f->view_address : f->group.mono->view_address, far ? 0 : f->frame->stereo.mono_distance};
}

void mono_begin_depth(struct frame_state *f) {
    if (f->group.eyes) {
        graph_image depths[GROUP_MOST];
        for (uint32_t i = 0; i < f->group.eye_count; i++) depths[i] = f->group.eyes[i].depth;
        mono_block_add(f->graph, f->view_address, f->group.eyes->view_address, depths, f->group.eye_count, f->depth);
        return;
    }
    const uint32_t layers = MAX(graph_image_info(f->graph, f->depth).layers, 1u);
    for (uint32_t i = 0; i < layers; i++) {
        const struct frame_state *view = f->group.layers ? &f->group.layers[MIN(i, f->group.layer_count - 1)] : f;
        const struct mono_eye eye = eye_of(view);
        mono_plane_add(f->graph, graph_numbered_name(f->graph, "mono plane", i), &eye, graph_image_layer(f->graph, f->depth, i));
    }
}

void mono_open(struct frame_state *f) {
    const struct mono_eye eye = eye_of(f);
    graph_buffer counts = {0};
    if (f->frame->count_lights) {
        counts = graph_create_buffer(f->graph, "mono counts", 4 * MONO_COUNTS);
        graph_add_clear(f->graph, "mono clear counts", GRAPH_QUEUE_GRAPHICS, (struct graph_clear){.buffers = {counts}});
        COUNTERS_COPY(f, counts, 0, mono, pixels);
    }
    f->depth = mono_open_add(f->graph, &eye, f->depth, counts);
    if (f->stored.gbuffer.depth.id) f->stored.gbuffer.depth = f->depth;
    if (f->stored.visibility.depth.id) f->stored.visibility.depth = f->depth;
}

void mono_composite(struct frame_state *f) {
    const struct mono_eye eye = eye_of(f);
    mono_composite_add(f->graph, &eye, f->group.mono->radiance, f->group.mono->depth, f->radiance, f->depth);
}

static const struct counter rows[] = {
    {"stereo.pixels", "pixels", "shaded by the view: by an eye those nearer than stereo.mono-distance, by the mono view those beyond it", COUNTED_SUM(mono, pixels[MONO_SHADED], 1),
     .needs = "count-lights"},
    {"stereo.pixels-spared", "pixels", "not shaded by the view: by an eye those beyond stereo.mono-distance and the sky, by the mono view those that no eye needs", COUNTED_SUM(mono, pixels[MONO_SPARED], 1),
     .needs = "count-lights"},
};
static const struct counter_table counters_mono = COUNTER_TABLE_COUNTED(rows, mono);
const struct frame_step step_mono = {.name = "mono", .check = check, .counters = &counters_mono};
