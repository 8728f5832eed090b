/* SPDX-License-Identifier: MIT */
#include "render/surfaces.h"

#include "render/traits.h"

bool surfaces_have_blend(const struct frame_state *f) {
    for (uint32_t i = 0; i < f->scene->geometry.bucket_count; i++)
        if (f->scene->geometry.buckets[i].blend) return true;
    return false;
}

bool surfaces_have_glass(const struct frame_state *f) { return geometry_draw_count(&f->scene->geometry, GEOMETRY_GLASS) > 0; }

bool surfaces_have_layers_over(const struct frame_state *f) {
    return !frame_is(f->frame, SHADING_LAYERS) && geometry_draw_count(&f->scene->geometry, GEOMETRY_NOT_IN(GEOMETRY_LAYERED)) > 0;
}

fnl_gbuffer surfaces_layout(const struct frame_state *f) {
    const fnl_gbuffer_options *g = &f->frame->gbuffer;
    const struct geometry_scene *scene = &f->scene->geometry;
    if (!shading_is(f->frame->shading, SHADING_LAYOUTS) || g->layout != FNL_GBUFFER_DEFAULT || g->chroma || g->normals == FNL_NORMALS_FLOAT) return g->layout;
    for (uint32_t i = 0; i < scene->bucket_count; i++) {
        const uint32_t forward = scene->buckets[i].forward_layouts;
        if (geometry_bucket_opaque(&scene->buckets[i]) && (forward >> FNL_GBUFFER_DEFAULT & 1) && !(forward >> FNL_GBUFFER_LAYERS & 1)) return FNL_GBUFFER_LAYERS;
    }
    return g->layout;
}
