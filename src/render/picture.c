/* SPDX-License-Identifier: MIT */
/** From radiance to the picture, or to a debug view in its place. */
#include "passes/aa/morphological.h"
#include "passes/geometry/clusters.h"
#include "passes/post/post.h"
#include "passes/shade/gbuffer_view.h"
#include "passes/texturing/virtual_view_shared.h"
#include "render/decals.h"
#include "render/frame_steps.h"
#include "render/shading.h"

static bool frame_shows_gbuffer(const fnl_frame *frame) {
    return frame->debug >= FNL_DEBUG_GBUFFER_0 && frame->debug <= FNL_DEBUG_LIT_FORWARD;
}

static bool frame_shows_dais(const fnl_frame *frame) {
    return frame->debug >= FNL_DEBUG_DAIS_ADDRESSES && frame->debug <= FNL_DEBUG_DAIS_FAILURES;
}

static bool frame_shows_atlas(const fnl_frame *frame) {
    return frame->debug == FNL_DEBUG_ATLAS || frame->debug == FNL_DEBUG_PAGES;
}

bool frame_shows_surfaces(const fnl_frame *frame) {
    bool own = frame_shows_gbuffer(frame) || frame_shows_dais(frame) || frame_shows_atlas(frame);
    return (frame->debug != FNL_DEBUG_NONE && !own) ||
           (frame->outputs & (FNL_OUTPUT_SURFACE | FNL_OUTPUT_NORMAL | FNL_OUTPUT_POSITION));
}

void frame_add_picture(struct frame_state *f) {
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
    uint32_t layer;
};

static void execute_copy_image(const struct graph_context *context, const void *data) {
    const struct copy_image_data *d = data;
    gpu_copy_image(context->commands, graph_get_image(context, d->from), graph_get_image(context, d->to), d->layer);
}

void frame_add_target(struct frame_state *f) {
    struct copy_image_data copy = {
        f->color, graph_import_image(f->graph, f->target->image, f->target->initial_layout, f->target->final_layout),
        f->view_index};
    struct graph_pass *pass =
        graph_add_pass(f->graph, "copy to target", GRAPH_QUEUE_GRAPHICS, execute_copy_image, &copy, sizeof copy);
    graph_use_image(pass, copy.from, GRAPH_COPY_FROM);
    graph_use_image(pass, copy.to, GRAPH_COPY_TO);
}
