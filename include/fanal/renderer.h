/* SPDX-License-Identifier: MIT */
/** Renders a scene on a device, frame by frame. */
#ifndef FANAL_RENDERER_H
#define FANAL_RENDERER_H

#include "fanal/device.h"
#include "fanal/image.h"
#include "fanal/pixel.h"
#include "fanal/stats.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct fnl_renderer fnl_renderer;
struct fnl_vulkan_target;

/**
 * The device and the scene must outlive the renderer. The first frame uploads the scene. Renderers of one scene on one device share what is
 * uploaded: geometry, images, materials, lights, decals, posed vertices. An edit is sent with the next frame of any of them, and each shows
 * it; the last to be destroyed frees it. History is a renderer's own: motion is since its own last frame. Calls on a device and all its
 * renderers must not overlap, on whatever threads.
 */
FNL_API fnl_result fnl_renderer_create(fnl_device *device, fnl_scene *scene, fnl_renderer **out);
FNL_API void fnl_renderer_destroy(fnl_renderer **renderer);

/** Submits one frame, with all changes of the scene since the last one. `frame` NULL: defaults. */
FNL_API fnl_result fnl_renderer_render(fnl_renderer *renderer, const fnl_frame *frame);
/**
 * Uploads the scene and compiles the pipelines of frames like `frame` ahead of time, on the device's job threads (at
 * most eight), so that the first such frame compiles none (fnl_frame_stats.pipelines_made is 0). Nothing is rendered
 * and the results of the last frame stay. Size and camera of the frame do not matter. `target` (fanal/vulkan.h; or
 * NULL): for frames that fnl_renderer_render_to will draw to images of its format and size, with depth if `depth` is
 * not VK_NULL_HANDLE; its other fields are not read.
 *
 * With `wait` the call returns when all pipelines are compiled, including those of the candidates of `auto` (unless the
 * frame has pin_choice), and meshes and textures are on the device; images of files that were loaded with `async` still
 * arrive with later frames. If both shading and lists are `auto`, the lists for the winning path are compiled later, in
 * the background.
 *
 * Without `wait` pipelines are compiled in the background, and `out_pending` (may be NULL) is the number still missing:
 * call again until it is 0. `auto` is then resolved as with pin_choice. A frame that is rendered before that compiles
 * the pipelines it needs itself.
 */
FNL_API fnl_result fnl_renderer_warm(fnl_renderer *renderer, const fnl_frame *frame, const struct fnl_vulkan_target *target,
                                     bool wait, uint32_t *out_pending);
/**
 * Waits for the last frame and returns one of its outputs (exactly one bit); free it with fnl_image_free. The pictures of a frame with several
 * views stand one below the other, the first view at the top: the image is fnl_frame.view_count times as high as the frame.
 */
FNL_API fnl_result fnl_renderer_read(fnl_renderer *renderer, fnl_output output, fnl_image *out);

/**
 * Whether the device has finished the last frame, so that the calls below do not wait; true before the first frame.
 * This call never waits.
 * FNL_ERROR_DEVICE if the device is lost.
 */
FNL_API fnl_result fnl_renderer_query_done(fnl_renderer *renderer, bool *out);
/** Waits for the last frame and describes it. */
FNL_API fnl_result fnl_renderer_query_stats(fnl_renderer *renderer, fnl_frame_stats *out);
/** Waits for the last frame and tells what it did at the pixel that it was asked for (fnl_frame.pixel). */
FNL_API fnl_result fnl_renderer_query_pixel(fnl_renderer *renderer, fnl_pixel_info *out);
/** What fnl_renderer_print() writes about the last frame. */
typedef enum fnl_print {
    FNL_PRINT_PLAN = 0,  /**< the compiled frame graph */
    FNL_PRINT_TRAFFIC,   /**< a table of what the passes move between images and memory */
    FNL_PRINT_PLAN_JSON, /**< the plan as one JSON object, for programs: docs/frame-graph.md; the same text for the same plan */
    FNL_PRINT_COUNT
} fnl_print;

/**
 * Writes as much of the text as fits, zero-terminated; returns the length of the whole text, without the zero, and 0 on misuse. `text` may be NULL
 * where `capacity` is 0.
 */
FNL_API size_t fnl_renderer_print(const fnl_renderer *renderer, fnl_print what, char *text, size_t capacity);

#ifdef __cplusplus
}
#endif
#endif
