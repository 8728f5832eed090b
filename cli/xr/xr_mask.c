/* SPDX-License-Identifier: MIT */
/* What the lenses hide. */
#include "xr/xr.h"

#include <stdlib.h>

static void free_mask(struct xr_mask *mask) {
    free(mask->vertices);
    free(mask->indices);
    free(mask->corners);
    mask->corners = NULL;
    mask->vertices = NULL;
    mask->indices = NULL;
    mask->vertex_count = mask->index_count = 0;
}

void xr_free_masks(struct xr *x) {
    for (uint32_t i = 0; i < XR_VIEWS; i++) {
        free_mask(&x->masks[i]);
        x->masks[i].version = 0;
    }
}

/* All inside; a runtime that says otherwise is not to be drawn from. */
static bool is_sound(const struct xr_mask *mask) {
    for (uint32_t i = 0; i < mask->index_count; i++)
        if (mask->indices[i] >= mask->vertex_count) return false;
    for (uint32_t i = 0; i < mask->vertex_count; i++)
        if (!isfinite(mask->vertices[i].x) || !isfinite(mask->vertices[i].y)) return false;
    return mask->index_count % 3 == 0;
}

void xr_read_mask(struct xr *x, uint32_t view) {
    enum { MOST = 1 << 20 };
    struct xr_mask *mask = &x->masks[view];
    XrVisibilityMaskKHR out = {.type = XR_TYPE_VISIBILITY_MASK_KHR};
    free_mask(mask);
    mask->version++;
    x->numbers.mask_reads++;
    XrResult result = x->get_mask(x->session, x->configuration, view, XR_VISIBILITY_MASK_TYPE_HIDDEN_TRIANGLE_MESH_KHR, &out);
    if (!xr_may(x, "xrGetVisibilityMaskKHR", result, "the visibility mask")) return;
    if (out.vertexCountOutput == 0 || out.indexCountOutput == 0) return; /* all is seen */
    if (out.vertexCountOutput <= MOST && out.indexCountOutput <= MOST) {
        mask->vertices = calloc(out.vertexCountOutput, sizeof *mask->vertices);
        mask->indices = calloc(out.indexCountOutput, sizeof *mask->indices);
        mask->corners = calloc(out.indexCountOutput, sizeof *mask->corners);
    }
    if (!mask->vertices || !mask->indices || !mask->corners) {
        xr_may(x, "xrGetVisibilityMaskKHR", XR_ERROR_OUT_OF_MEMORY, "the visibility mask");
        free_mask(mask);
        return;
    }
    out.vertexCapacityInput = out.vertexCountOutput;
    out.indexCapacityInput = out.indexCountOutput;
    out.vertices = mask->vertices;
    out.indices = mask->indices;
    result = x->get_mask(x->session, x->configuration, view, XR_VISIBILITY_MASK_TYPE_HIDDEN_TRIANGLE_MESH_KHR, &out);
    mask->vertex_count = out.vertexCountOutput;
    mask->index_count = out.indexCountOutput;
    if (!xr_may(x, "xrGetVisibilityMaskKHR", result, "the visibility mask")) free_mask(mask);
    else if (!is_sound(mask)) {
        xr_may(x, "xrGetVisibilityMaskKHR", XR_ERROR_VALIDATION_FAILURE, "the visibility mask, whose triangles are broken");
        free_mask(mask);
    }
    for (uint32_t i = 0; i < mask->index_count; i++) mask->corners[i] = (fnl_vec2){mask->vertices[mask->indices[i]].x, mask->vertices[mask->indices[i]].y};
}

double xr_mask_area(const struct xr_mask *mask, const XrFovf *fov) {
    const double width = tan((double)fov->angleRight) - tan((double)fov->angleLeft), height = tan((double)fov->angleUp) - tan((double)fov->angleDown);
    double sum = 0;
    for (uint32_t i = 0; i + 2 < mask->index_count; i += 3) {
        const XrVector2f a = mask->vertices[mask->indices[i]], b = mask->vertices[mask->indices[i + 1]], c = mask->vertices[mask->indices[i + 2]];
        sum += fabs((double)(b.x - a.x) * (double)(c.y - a.y) - (double)(c.x - a.x) * (double)(b.y - a.y)) / 2;
    }
    return sum / (width * height);
}

/* What fnl_frame.hidden_areas says. */
static bool takes_masks(const fnl_frame *frame) {
    if (frame->lists == FNL_LISTS_BATCHES || frame->lists == FNL_LISTS_MULTIPASS) return false;
    return frame->shading == FNL_SHADING_FORWARD || frame->shading == FNL_SHADING_FORWARD_PREPASS || frame->shading == FNL_SHADING_DEFERRED ||
           (frame->shading == FNL_SHADING_VISIBILITY && !frame->visibility.grid);
}

void xr_use_masks(struct xr *x, const struct xr_group *group, fnl_frame *frame) {
    uint32_t count = 0;
    if (!takes_masks(frame)) return;
    for (uint32_t i = group->first; i < group->first + group->count; i++) {
        x->hidden[i] = (fnl_hidden_area){x->masks[i].corners, x->masks[i].index_count};
        count += x->masks[i].index_count;
    }
    if (count == 0) return;
    frame->hidden_areas = &x->hidden[group->first];
    x->numbers.mask_frames++;
}
