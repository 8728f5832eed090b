/* SPDX-License-Identifier: MIT */
#include "render/overlay.h"

#include "passes/post/overlay.h"
#include "render/step.h"

#include <inttypes.h>

static fnl_result check_draw(const struct call *call, const fnl_overlay *o, uint32_t number) {
    const fnl_overlay_draw *draw = &o->draws[number];
    if ((uint64_t)draw->first_index + draw->index_count > o->index_count)
        return misuse(call, "overlay.draws[%u] uses indices %u .. %" PRIu64 ", but there are %u", number, draw->first_index,
                      (uint64_t)draw->first_index + draw->index_count, o->index_count);
    if (draw->index_count % 3)
        return misuse(call, "overlay.draws[%u].index_count is %u, must be a multiple of 3", number, draw->index_count);
    if (draw->image >= FNL_OVERLAY_IMAGES_MAX)
        return misuse(call, "overlay.draws[%u].image is %u, but there are %d", number, draw->image, FNL_OVERLAY_IMAGES_MAX);
    for (uint32_t i = 0; i < draw->index_count; i++) {
        const uint64_t vertex = (uint64_t)o->indices[draw->first_index + i] + draw->first_vertex;
        if (vertex >= o->vertex_count)
            return misuse(call, "overlay.draws[%u]: index %u is that of vertex %" PRIu64 ", but there are %u", number, i, vertex, o->vertex_count);
    }
    return FNL_OK;
}

static fnl_result check_image(const struct call *call, const fnl_image *image, uint32_t index) {
    if (!image->pixels) return misuse(call, "overlay.images[%u].pixels is NULL", index);
    if (image->width < 1 || image->width > 16384 || image->height < 1 || image->height > 16384)
        return misuse(call, "overlay.images[%u] has %u x %u pixels, must have 1 .. 16384 in each direction", index, image->width, image->height);
    if (image->format != FNL_PIXEL_FORMAT_RGBA8) return misuse(call, "overlay.images[%u] is not RGBA8", index);
    return FNL_OK;
}

static fnl_result check(const struct call *call, fnl_renderer *r, const fnl_frame *frame) {
    UNUSED(r);
    const fnl_overlay *o = frame->overlay;
    if (!o) return FNL_OK;
    if (frame->view_count > 1) return unsupported(call, "an overlay goes over frames of one view, not of %u", frame->view_count);
    if (o->vertex_count) TRY(check_pointer(call, "overlay.vertices", o->vertices));
    if (o->index_count) TRY(check_pointer(call, "overlay.indices", o->indices));
    if (o->draw_count) TRY(check_pointer(call, "overlay.draws", o->draws));
    for (uint32_t i = 0; i < o->draw_count; i++) TRY(check_draw(call, o, i));
    for (uint32_t i = 0; i < FNL_OVERLAY_IMAGES_MAX; i++)
        if (o->images[i].image) TRY(check_image(call, o->images[i].image, i));
    return FNL_OK;
}

static void drop(fnl_renderer *r, struct renderer_overlay *kept) {
    if (kept->image.handle) gpu_image_destroy(r->device, &kept->image);
    *kept = (struct renderer_overlay){0};
}

static fnl_result send(fnl_renderer *r, struct renderer_overlay *kept, const fnl_overlay_image *from) {
    const fnl_image *image = from->image;
    if (!image || (kept->image.handle && kept->version == from->version)) return FNL_OK;
    drop(r, kept);
    const struct gpu_image_params params = {.name = "overlay image",
                                            .format = VK_FORMAT_R8G8B8A8_UNORM,
                                            .width = image->width,
                                            .height = image->height,
                                            .layers = 1,
                                            .mips = 1,
                                            .samples = 1,
                                            .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT};
    TRY(gpu_image_create(r->device, &params, &kept->image));
    fnl_result result = gpu_upload_image(r->device, &kept->image, image->pixels, 4ull * image->width * image->height, false, false);
    if (result != FNL_OK) drop(r, kept);
    kept->version = from->version;
    return result;
}

fnl_result overlay_prepare(fnl_renderer *r, const fnl_frame *frame) {
    for (uint32_t i = 0; i < FNL_OVERLAY_IMAGES_MAX && frame->overlay; i++) TRY(send(r, &r->overlays[i], &frame->overlay->images[i]));
    return FNL_OK;
}

static void destroy(fnl_renderer *r) {
    for (uint32_t i = 0; i < FNL_OVERLAY_IMAGES_MAX; i++) drop(r, &r->overlays[i]);
}

const struct frame_step step_overlay = {.name = "overlay", .check = check, .destroy = destroy};

void overlay_draw(struct frame_state *f) {
    const struct picture picture = frame_picture(f);
    const bool fitted = f->input->target && f->input->target->part.fitted;
    struct overlay_params params = {.overlay = f->frame->overlay,
                                    .linear = picture.tonemap.linear && (picture.display == DISPLAY_LINEAR || f->frame->debug == FNL_DEBUG_NONE),
                                    .swap = picture.tonemap.swap,
                                    .x = fitted ? (int32_t)f->input->target->part.x : 0,
                                    .y = fitted ? (int32_t)f->input->target->part.y : 0};
    for (uint32_t i = 0; i < FNL_OVERLAY_IMAGES_MAX; i++)
        params.images[i] = params.overlay->images[i].image ? f->r->overlays[i].image.sampled_index : GPU_NO_INDEX;
    overlay_add(f->r->device, f->graph, f->color, &params);
}
