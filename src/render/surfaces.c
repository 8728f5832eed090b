/* SPDX-License-Identifier: MIT */
#include "render/surfaces.h"

#include "render/traits.h"

bool surfaces_have_blend(const struct frame_state *f) {
    for (uint32_t i = 0; i < f->scene->geometry.bucket_count; i++)
        if (f->scene->geometry.buckets[i].blend) return true;
    return false;
}

bool surfaces_have_glass(const struct frame_state *f) { return geometry_draw_count(&f->scene->geometry, GEOMETRY_GLASS) > 0; }

uint32_t surfaces_over(const struct frame_state *f) {
    const bool masks = frame_is(f->frame, SHADING_ITEMS) || shading_is(f->frame->shading, SHADING_LAYOUTS); /* a G-buffer marks what is shaded forward */
    const uint32_t layout = !frame_is(f->frame, SHADING_LAYERS) ? GEOMETRY_LAYERED : masks ? 0 : GEOMETRY_MASKED;
    return layout && geometry_draw_count(&f->scene->geometry, GEOMETRY_NOT_IN(layout)) > 0 ? layout : 0;
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
