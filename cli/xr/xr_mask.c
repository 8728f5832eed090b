/* SPDX-License-Identifier: MIT */
/* What the lenses hide. */
#include "xr/xr.h"

#include <stdlib.h>
#include <string.h>

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

/* What fnl_frame.hidden_areas takes: anything else would end the session with the first frame. */
static bool is_sound(const struct xr_mask *mask) {
    const float most = 1e6f; /* tangents */
    for (uint32_t i = 0; i < mask->index_count; i++)
        if (mask->indices[i] >= mask->vertex_count) return false;
    for (uint32_t i = 0; i < mask->vertex_count; i++)
        if (!(fabsf(mask->vertices[i].x) <= most && fabsf(mask->vertices[i].y) <= most)) return false;
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

/* Leaves of a polygon what lies at `sign` * coordinate >= `sign` * `at`; the new number of corners, at most one more. */
static uint32_t clip(XrVector2f *corners, uint32_t count, bool by_y, float sign, float at) {
    XrVector2f out[8];
    uint32_t kept = 0;
    for (uint32_t i = 0; i < count; i++) {
        const XrVector2f p = corners[i], q = corners[(i + 1) % count];
        const float from = sign * ((by_y ? p.y : p.x) - at), to = sign * ((by_y ? q.y : q.x) - at);
        if (from >= 0) out[kept++] = p;
        if ((from >= 0) != (to >= 0)) out[kept++] = (XrVector2f){p.x + (q.x - p.x) * from / (from - to), p.y + (q.y - p.y) * from / (from - to)};
    }
    memcpy(corners, out, kept * sizeof *out);
    return kept;
}

double xr_mask_area(const struct xr_mask *mask, const XrFovf *fov) {
    const float left = tanf(fov->angleLeft), right = tanf(fov->angleRight), down = tanf(fov->angleDown), up = tanf(fov->angleUp);
    double sum = 0;
    for (uint32_t i = 0; i + 2 < mask->index_count; i += 3) {
        XrVector2f p[8] = {mask->vertices[mask->indices[i]], mask->vertices[mask->indices[i + 1]], mask->vertices[mask->indices[i + 2]]};
        uint32_t count = clip(p, 3, false, 1, left);
        count = clip(p, count, false, -1, right);
        count = clip(p, count, true, 1, down);
        count = clip(p, count, true, -1, up);
        double area = 0;
        for (uint32_t k = 1; k + 1 < count; k++)
            area += (double)(p[k].x - p[0].x) * (double)(p[k + 1].y - p[0].y) - (double)(p[k + 1].x - p[0].x) * (double)(p[k].y - p[0].y);
        sum += fabs(area) / 2;
    }
    return sum / ((double)(right - left) * (double)(up - down));
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
