/* SPDX-License-Identifier: MIT */
/** Renders a scene on a device, frame by frame. */
#ifndef FANAL_RENDERER_H
#define FANAL_RENDERER_H

#include "fanal/device.h"
#include "fanal/image.h"
#include "fanal/stats.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct fnl_renderer fnl_renderer;
struct fnl_vulkan_target;

/** Both must outlive the renderer. The scene is uploaded by the first frame. */
FNL_API fnl_result fnl_renderer_create(fnl_device *device, fnl_scene *scene, fnl_renderer **out);
FNL_API void fnl_renderer_destroy(fnl_renderer **renderer);

/** Submits one frame; `frame` NULL means defaults. Changes of the scene since the last frame are taken along. */
FNL_API fnl_result fnl_renderer_render(fnl_renderer *renderer, const fnl_frame *frame);
/**
 * Makes the pipelines of frames like `frame` ahead of them, on as many threads as the device has for jobs (eight at most), so that the first
 * such frame compiles none (fnl_frame_stats.pipelines_made is 0). Nothing is rendered and the results of the last frame stay; the scene is
 * uploaded if it has changed. What counts of the frame is what is rendered and how (size and camera do not), `auto` being what it is with
 * pin_choice. `target` (fanal/vulkan.h; or NULL): frames for fnl_renderer_render_to images of its format; nothing else of it is read.
 * With `wait` it returns when all are made. Otherwise they are made in the background, and `out_pending` (may be NULL) is how many are
 * missing: ask again until it is 0. A frame that is rendered before makes what it needs itself.
 */
FNL_API fnl_result fnl_renderer_warm(fnl_renderer *renderer, const fnl_frame *frame, const struct fnl_vulkan_target *target,
                                     bool wait, uint32_t *out_pending);
/**
 * Waits for the last frame and hands out one of its outputs (exactly one bit); free with fnl_image_free. The pictures of a frame with several views
 * stand one below the other, the first view at the top: the image is fnl_frame.view_count times as high as the frame.
 */
FNL_API fnl_result fnl_renderer_read(fnl_renderer *renderer, fnl_output output, fnl_image *out);

/** Waits for the last frame and describes it. */
FNL_API fnl_result fnl_renderer_query_stats(fnl_renderer *renderer, fnl_frame_stats *out);
/** The compiled frame graph of the last frame as text, zero-terminated; returns the length it wants. */
FNL_API size_t fnl_renderer_print_plan(const fnl_renderer *renderer, char *text, size_t capacity);
/** The same way: what the passes of the last frame move between images and memory, as a table. */
FNL_API size_t fnl_renderer_print_traffic(const fnl_renderer *renderer, char *text, size_t capacity);

#ifdef __cplusplus
}
#endif
#endif
