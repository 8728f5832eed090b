/* SPDX-License-Identifier: MIT */
/**
 * What really reaches Vulkan. A spy stands between src/gpu and the driver: it reads the structures of calls that make images and render
 * passes and record commands, and then makes the calls. Tests compare it with what the frame graph and the stats claim.
 *
 *     spy_begin(device);     before the images and render passes that it shall know are made
 *     spy_clear();
 *     …                      a frame with record_threads 1: calls come in the order in which they are executed
 *     spy_sum(spy_stored)
 *     spy_end();
 *
 * One device at a time, one thread.
 */
#ifndef FNL_TESTS_VULKAN_SPY_H
#define FNL_TESTS_VULKAN_SPY_H

#include "graph/graph_internal.h"

/** An attachment that vkCmdBeginRendering got, or vkCmdBeginRenderPass2: then with the operations its render pass was made with. */
struct spy_attachment {
    char label[64], name[64]; /* the debug label that is open; the image's name */
    VkImage image;
    VkFormat format;
    uint64_t bytes; /* of the rendered area, all samples and layers */
    VkAttachmentLoadOp load;
    VkAttachmentStoreOp store; /* STORE for what a resolve writes */
    bool is_resolve, is_scope, is_transient;
    bool is_used; /* after it was stored a later attachment loaded it, or a barrier carried its contents to another use */
};

/** A draw or a dispatch. */
struct spy_work {
    char label[64];
    const struct gpu_pipeline *pipeline;
    bool indirect;
    uint64_t offset;   /* indirect: into the buffer */
    uint32_t count[3]; /* groups; vertices, instances and 0; draws of an indirect call (at most), 0 and 0 */
};

struct spy {
    struct spy_attachment attachments[256];
    struct spy_work work[2048];
    uint32_t attachment_count, work_count;
    uint32_t barrier_calls, image_barriers, memory_barriers;
    uint64_t filled_bytes, copied_bytes; /* of buffers */
    /** What is bound in place of a pipeline; NULL: nothing is replaced. */
    const struct gpu_pipeline *(*replace)(gpu_device *device, const struct gpu_pipeline *bound);
    /** What is culled in place of what was asked for; NULL: that. */
    VkCullModeFlags (*cull)(const struct gpu_pipeline *bound, VkCullModeFlags asked);
};
extern struct spy spy;

void spy_begin(gpu_device *device);
/** Once more does no harm. */
void spy_end(void);
/** Tear-down of a test that spies: ends it where a failure has not. */
int spy_tear_down(void **state);
/** Forgets what was recorded; `replace` and `cull` stay. */
void spy_clear(void);

/** What a pipeline was made of; NULL for one of the other kind. */
const struct gpu_compute_params *spy_compute_params(const struct gpu_pipeline *pipeline);
const struct gpu_graphics_params *spy_graphics_params(const struct gpu_pipeline *pipeline);
/** From now on copies what the graph's buffer of a name holds after a pass to `out`, mapped for reading; NULL: no more. */
void spy_capture(const struct graph *graph, const char *pass, const char *buffer, const struct gpu_buffer *out);
/**
 * From now on writes the first `size` bytes of `from` over those that the graph's buffer of a name holds after a pass, at `offset`; NULL: no
 * more. So a test can spoil one link of a chain and see that what comes behind depends on it.
 */
void spy_overwrite(const struct graph *graph, const char *pass, const char *buffer, uint64_t offset, uint64_t size,
                   const struct gpu_buffer *from);

/** What an attachment moves: what is loaded from memory, stored to it, or neither although something was drawn. */
uint64_t spy_loaded(const struct spy_attachment *attachment);
uint64_t spy_stored(const struct spy_attachment *attachment);
uint64_t spy_discarded(const struct spy_attachment *attachment);
uint64_t spy_sum(uint64_t (*bytes)(const struct spy_attachment *attachment));
/** Draws and dispatches under a label. */
uint32_t spy_count_work(const char *label);

#endif
