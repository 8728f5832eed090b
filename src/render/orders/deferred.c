/* SPDX-License-Identifier: MIT */
#include "render/decals.h"
#include "render/shadows/sampled.h"
#include "render/temporal.h"
#include "render/orders/order.h"

#include "render/debug_views.h"
#include "render/shading.h"

#include "passes/shade/classify.h"
#include "passes/shade/deferred.h"
#include "passes/shade/deferred_msaa.h"
#include "passes/shade/deferred_screen.h"
#include "passes/shade/gbuffer_view.h"

_Static_assert((uint32_t)FNL_MSAA_ALL == MSAA_ALL && (uint32_t)FNL_MSAA_COMPACT == MSAA_COMPACT &&
                   (uint32_t)FNL_MSAA_AGGREGATE == MSAA_AGGREGATE && FNL_MSAA_METHOD_COUNT == FNL_MSAA_AGGREGATE + 1,
               "deferred_msaa_shared.h has the values of fnl_msaa_method");

/* What the GPU counts. */
struct deferred_counts {
    uint32_t blocks[9]; /* by class (passes/shade/classify_shared.h) */
    struct gpu_denoise_counts denoise;
};
static const struct counter_table counters_deferred;

static fnl_result check(const struct call *call, const fnl_renderer *r, const fnl_frame *frame) {
    UNUSED(r);
    if (frame->deferred.pass == FNL_DEFERRED_FRAGMENT && (frame->deferred.class_blocks || frame->msaa > 1))
        return unsupported(call, "deferred.pass=fragment needs deferred.class-blocks=0 and 1 sample per pixel");
    if (frame->msaa > 1 && frame->deferred.class_blocks)
        return unsupported(call, "deferred.class-blocks needs 1 sample per pixel; use 0 with MSAA");
    if ((shadows_denoised(frame) || shadows_guided(frame)) && (frame->msaa > 1 || frame->deferred.class_blocks || frame->deferred.pass != FNL_DEFERRED_COMPUTE))
        return unsupported(call, "shadow.%s needs 1 sample per pixel, deferred.class-blocks=0 and deferred.pass=compute", shadows_denoised(frame) ? "denoise" : "guide");
    return FNL_OK;
}

/* What the layout cannot hold is shaded forward. */
static void add_rest(struct frame_state *f, const struct shade_input *input, const struct gbuffer *gbuffer) {
    hybrid_add(f->graph, input, gbuffer, f->radiance);
    f->forward_layouts = 1u << input->layout;
    f->calls.opaque += geometry_draw_count(input->scene, GEOMETRY_NOT_IN(input->layout));
}

/* Lists see all samples of the depth, but no normals. */
static void add_deferred_samples(struct frame_state *f, struct shade_input *input) {
    order_add_lists(f, f->depth, NULL);
    struct deferred_msaa_params params = {.method = (uint32_t)f->frame->deferred.msaa_method,
                                          .groups = f->frame->deferred.msaa_groups,
                                          .tolerance = f->frame->deferred.msaa_method == FNL_MSAA_ALL ? 0 : f->frame->deferred.msaa_tolerance};
    order_note_gbuffer(f, 0);
    struct edges edges = deferred_msaa_add(f->graph, input, &f->stored.gbuffer, &params, f->radiance);
    add_rest(f, input, &f->stored.gbuffer);
    f->stored.surfaces = edges.surfaces;
    COUNTERS_COPY(f, edges.counts, 0, shading, edges);
}

static void draw(struct frame_state *f, struct shade_input *input, bool prepass) {
    f->stored.gbuffer = gbuffer_add(f->graph, input, prepass, f->radiance, f->depth);
}

static void add(struct frame_state *f, struct shade_input *input, bool prepass) {
    UNUSED(prepass);
    if (f->frame->msaa > 1) {
        add_deferred_samples(f, input);
        return;
    }
    const struct gbuffer *gbuffer = &f->stored.gbuffer;
    decals_on_gbuffer_add(f, input, gbuffer);
    order_add_lists(f, f->depth, gbuffer);
    const bool sampled = f->lights.bits & GPU_LIGHTING_SAMPLED, denoised = shadows_denoised(f->frame) && sampled;
    if (shadows_guided(f->frame) && sampled) input->guide = shadow_sampled_guide(f);
    if (denoised) input->apart = denoise_begin(f->graph, f->radiance);
    struct shade_classes classes = {0};
    if (f->frame->deferred.class_blocks) {
        classes = classify_add(f->graph, input, gbuffer, f->frame->deferred.class_blocks);
        COUNTERS_COPY(f, classes.counts, 0, deferred, blocks);
    }
    if (f->frame->deferred.pass == FNL_DEFERRED_FRAGMENT && deferred_screen_supported(f->r->device))
        f->radiance = deferred_screen_add(f->graph, input, gbuffer, f->radiance);
    else
        deferred_add(f->graph, input, gbuffer, f->frame->deferred.class_blocks ? &classes : NULL, f->radiance);
    if (denoised) shadow_sampled_denoise(f, &input->apart);
    COUNTERS_COPY(f, f->shadows.denoise.counts, 0, deferred, denoise);
    add_rest(f, input, gbuffer);
    order_note_gbuffer(f, 0);
}

_Static_assert((int)FNL_VOLUME_SOLIDS == VOLUME_SOLIDS && (int)FNL_VOLUME_SHAPE_COUNT == VOLUME_STENCIL + 1,
               "volumes_shared.h has the values of fnl_volume_shape");

/* The base of volumes: everything but local lights. Several samples a pixel: each surface once. */
static struct surface_layers add_base(struct frame_state *f, struct shade_input *input, const struct gbuffer *gbuffer) {
    struct surface_layers layers = {.count = f->frame->msaa};
    if (f->frame->msaa == 1) {
        deferred_add(f->graph, input, gbuffer, NULL, f->radiance);
        return layers;
    }
    struct deferred_msaa_params params = {.method = MSAA_COMPACT, .groups = 2};
    struct edges edges = deferred_msaa_add(f->graph, input, gbuffer, &params, f->radiance);
    f->stored.surfaces = edges.surfaces;
    COUNTERS_COPY(f, edges.counts, 0, shading, edges);
    layers.surfaces = edges.surfaces;
    return layers;
}

/* Everything but local lights in one pass over the screen, then a volume for each of those. */
static void add_with_volumes(struct frame_state *f, struct shade_input *input, bool prepass) {
    struct gbuffer gbuffer = gbuffer_add(f->graph, input, prepass, f->radiance, f->depth);
    decals_on_gbuffer_add(f, input, &gbuffer);
    struct lighting own = {0}; /* of what is lit forward */
    bool has_lists = surfaces_have_blend(f) || gbuffer.mask.id;
    if (has_lists) {
        order_add_lists(f, f->depth, gbuffer.mask.id && f->frame->msaa == 1 ? &gbuffer : NULL);
        own = f->lights;
        if (!gbuffer.mask.id) f->lights = f->blend_lights; /* opaque surfaces need none: what makes them is not run */
    } else {
        f->lights = f->blend_lights = order_light_by_all(f);
        graph_set_role(f->graph, GRAPH_ROLE_SHADING);
    }
    const struct lighting base = order_light_by_suns(f);
    input->lighting = &base;
    struct surface_layers layers = add_base(f, input, &gbuffer);
    uint32_t shape = (uint32_t)f->frame->volume_shape;
    if (shape == VOLUME_STENCIL && !volumes_stencil_supported(f->r->device)) shape = VOLUME_DEPTH_BOUNDS;
    struct volumes volumes = order_prepare_volumes(f, shape, f->frame->volume_batch);
    if (layers.count > 1)
        volumes_add_samples(f->graph, input, &volumes, &gbuffer, &layers, f->radiance);
    else
        volumes_add(f->graph, input, &volumes, &gbuffer, f->radiance);
    counters_note(f, "volumes.draws", layers.count * (2 + 2 * volumes.alone));
    if (gbuffer.mask.id) {
        input->lighting = &own;
        add_rest(f, input, &gbuffer);
    }
    f->stored.gbuffer = gbuffer;
    order_note_gbuffer(f, 0);
    if (!has_lists) order_count_volumes(f, &volumes);
}

/* ---- views of what the G-buffer holds ---- */

static fnl_result check_view(const struct call *call, const fnl_renderer *r, const fnl_frame *frame) {
    UNUSED(r);
    if (frame->msaa == 1) return FNL_OK;
    return unsupported(call, "the debug view %s needs 1 sample per pixel, not %u",
                       fnl_value_name(FNL_ENUM_DEBUG_VIEW, frame->debug), frame->msaa);
}

static fnl_result check_target(const struct call *call, const fnl_renderer *r, const fnl_frame *frame) {
    fnl_gbuffer_info info;
    uint32_t index = (uint32_t)(frame->debug - FNL_DEBUG_GBUFFER_0);
    TRY(check_view(call, r, frame));
    TRY(fnl_gbuffer_query_info(frame->gbuffer.layout, &info));
    if (index < info.target_count + (frame->gbuffer.normals == FNL_NORMALS_FLOAT)) return FNL_OK;
    return unsupported(call, "G-buffer layout %s has no render target %u", fnl_value_name(FNL_ENUM_GBUFFER, frame->gbuffer.layout), index);
}

static fnl_result check_material(const struct call *call, const fnl_renderer *r, const fnl_frame *frame) {
    fnl_gbuffer_info info;
    TRY(check_view(call, r, frame));
    TRY(fnl_gbuffer_query_info(frame->gbuffer.layout, &info));
    if (info.material_count) return FNL_OK;
    return unsupported(call, "G-buffer layout %s has no material ID", fnl_value_name(FNL_ENUM_GBUFFER, frame->gbuffer.layout));
}

static void add_target(struct frame_state *f, bool swap) {
    gbuffer_view_target_add(f->graph, &f->stored.gbuffer, (uint32_t)(f->frame->debug - FNL_DEBUG_GBUFFER_0), f->color, swap);
}
static void add_material(struct frame_state *f, bool swap) {
    gbuffer_view_field_add(f->graph, &f->stored.gbuffer, GBUFFER_SEEN_MATERIAL, f->color, swap);
}
static void add_forward(struct frame_state *f, bool swap) {
    gbuffer_view_field_add(f->graph, &f->stored.gbuffer, GBUFFER_SEEN_FORWARD, f->color, swap);
}

#define FIELDS "each field of the target in a quarter of the picture, as lighting reads it"
static const struct debug_legend_color forward[] = {{{1, 1, 1}, "shaded forward"}, {{0.25f, 0.25f, 0.25f}, "in the G-buffer"}};

static const struct debug_view views[] = {
    {FNL_DEBUG_GBUFFER_0, LEGEND_TEXT(FIELDS), .add = add_target, .check = check_target},   {FNL_DEBUG_GBUFFER_1, LEGEND_TEXT(FIELDS), .add = add_target, .check = check_target},
    {FNL_DEBUG_GBUFFER_2, LEGEND_TEXT(FIELDS), .add = add_target, .check = check_target},   {FNL_DEBUG_GBUFFER_3, LEGEND_TEXT(FIELDS), .add = add_target, .check = check_target},
    {FNL_DEBUG_GBUFFER_4, LEGEND_TEXT(FIELDS), .add = add_target, .check = check_target},   {FNL_DEBUG_MATERIAL_ID, LEGEND_TEXT("each material id in a colour of its own"), .add = add_material, .check = check_material},
    {FNL_DEBUG_LIT_FORWARD, LEGEND_COLORS("whether the layout holds the material", forward), .add = add_forward, .check = check_view},
};

/* ---- numbers ---- */

#define BLOCKS(key_, what, class_)                                                                                          \
    {                                                                                                                       \
        "shading-blocks." key_, "blocks", "blocks of the class: " what, COUNTED(deferred, blocks[class_]),                            \
            .needs = "deferred.class-blocks"                                                                                \
    }
#define DENOISED(key_, help, member) {"shadows." key_, "pixels", help, COUNTED(deferred, denoise.member), .needs = "shadow.denoise"}
static bool find_frames(const struct counted *counted, uint64_t *value) {
    const struct gpu_denoise_counts *c = &COUNTS(counted->counts, deferred)->denoise;
    if (!COUNTED_HAS(counted, deferred, denoise)) return false;
    *value = c->pixels ? ((c->frames[0] | (uint64_t)c->frames[1] << 32) + c->pixels / 2) / c->pixels : 0;
    return true;
}

static const struct counter rows[] = {
    BLOCKS("plain", "neither lights nor metal, some pixels need no shading", 0),
    BLOCKS("lights", "lights, no metal, some pixels need no shading", SHADE_LIGHTS),
    BLOCKS("metal", "metal, no lights, some pixels need no shading", SHADE_METAL),
    BLOCKS("lights-metal", "lights and metal, some pixels need no shading", SHADE_LIGHTS | SHADE_METAL),
    BLOCKS("full", "neither lights nor metal, every pixel is shaded", SHADE_FULL),
    BLOCKS("lights-full", "lights, no metal, every pixel is shaded", SHADE_LIGHTS | SHADE_FULL),
    BLOCKS("metal-full", "metal, no lights, every pixel is shaded", SHADE_METAL | SHADE_FULL),
    BLOCKS("lights-metal-full", "lights and metal, every pixel is shaded", SHADE_LIGHTS | SHADE_METAL | SHADE_FULL),
    BLOCKS("empty", "nothing to shade", SHADE_NOTHING),
    DENOISED("denoised", "pixels whose shadows are noisy and are denoised: those with more lights than rays", pixels),
    DENOISED("fresh", "of them, without history", fresh),
    DENOISED("refuted", "of them, whose history was shortened because this frame shows other shadows", refuted),
    {"shadows.frames", "frames", "frames in a pixel's history, on average", .find = find_frames, .needs = "shadow.denoise"},
};
static const struct counter_table counters_deferred = COUNTER_TABLE_COUNTED(rows, deferred);

static const struct counter volume_counters[] = {
    {"volumes.draws", "draws", "draw calls of light volumes: 2, and 2 for each light that the shape stencil draws by itself",
     NOTED},
};
static const struct counter_table counters_volumes = COUNTER_TABLE(volume_counters);

enum { TRAITS = SHADING_LAYERS | SHADING_FULL_RASTER | SHADING_GBUFFER | SHADING_MAY_PREPASS | SHADING_LAYOUTS | SHADING_DECALS | SHADING_SAMPLES };
const struct order order_deferred = {.traits = TRAITS | SHADING_POSITIONS | SHADING_SURFACES | SHADING_HIDDEN | SHADING_VIEWS | SHADING_MULTIVIEW,
                                     .check = check,
                                     .draw = draw,
                                     .add = add,
                                     .views = views,
                                     .view_count = COUNT_OF(views),
                                     .counters = &counters_deferred};
const struct order order_deferred_volumes = {.traits = TRAITS | SHADING_BLENDS | SHADING_VOLUMES | SHADING_VIEWS,
                                             .add = add_with_volumes,
                                             .views = views,
                                             .view_count = COUNT_OF(views),
                                             .counters = &counters_volumes};
