/* SPDX-License-Identifier: MIT */
#include "tests/vulkan_spy.h"

#include "gpu/gpu_internal.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

enum { MAX_IMAGES = 4096, MAX_VIEWS = 8192, MAX_PASSES = 64, MAX_DEPTH = 8 };

struct spy spy;

struct known_image {
    VkImage handle;
    VkFormat format;
    VkImageUsageFlags usage;
    uint32_t samples;
    char name[64];
};
struct known_view {
    VkImageView handle;
    VkImage image;
};
struct known_pass {
    VkRenderPass handle;
    uint32_t count;
    VkAttachmentDescription2 attachments[GPU_MAX_SCOPE_ATTACHMENTS];
};

static gpu_device *spied;
static struct gpu_device_functions driver;
static struct known_image images[MAX_IMAGES];
static struct known_view views[MAX_VIEWS];
static struct known_pass passes[MAX_PASSES];
static uint32_t image_count, view_count, pass_count, depth;
static char labels[MAX_DEPTH][64];
static const struct gpu_pipeline *bound;
static struct tap {
    const struct graph *graph;
    const char *pass, *buffer;
    uint64_t offset, size;
    const struct gpu_buffer *ours; /* NULL: there is none */
} capture, overwrite;

/* ---- what is known ---- */

static struct known_image *find_image(VkImage handle) {
    for (uint32_t i = 0; i < image_count; i++)
        if (images[i].handle == handle) return &images[i];
    return NULL;
}

static VKAPI_ATTR VkResult VKAPI_CALL create_image(VkDevice device, const VkImageCreateInfo *info,
                                                   const VkAllocationCallbacks *allocator, VkImage *out) {
    VkResult result = driver.CreateImage(device, info, allocator, out);
    if (result != VK_SUCCESS) return result;
    assert_true(image_count < MAX_IMAGES);
    images[image_count++] = (struct known_image){*out, info->format, info->usage, (uint32_t)info->samples, ""};
    return result;
}

static VKAPI_ATTR void VKAPI_CALL destroy_image(VkDevice device, VkImage image, const VkAllocationCallbacks *allocator) {
    struct known_image *known = find_image(image);
    if (known) *known = images[--image_count];
    driver.DestroyImage(device, image, allocator);
}

static VKAPI_ATTR VkResult VKAPI_CALL create_view(VkDevice device, const VkImageViewCreateInfo *info,
                                                  const VkAllocationCallbacks *allocator, VkImageView *out) {
    VkResult result = driver.CreateImageView(device, info, allocator, out);
    if (result != VK_SUCCESS) return result;
    assert_true(view_count < MAX_VIEWS);
    views[view_count++] = (struct known_view){*out, info->image};
    return result;
}

static VKAPI_ATTR void VKAPI_CALL destroy_view(VkDevice device, VkImageView view, const VkAllocationCallbacks *allocator) {
    for (uint32_t i = 0; i < view_count; i++)
        if (views[i].handle == view) {
            views[i] = views[--view_count];
            break;
        }
    driver.DestroyImageView(device, view, allocator);
}

static VKAPI_ATTR VkResult VKAPI_CALL name_object(VkDevice device, const VkDebugUtilsObjectNameInfoEXT *info) {
    struct known_image *known =
        info->objectType == VK_OBJECT_TYPE_IMAGE ? find_image((VkImage)(uintptr_t)info->objectHandle) : NULL;
    if (known) snprintf(known->name, sizeof known->name, "%s", info->pObjectName);
    return driver.SetDebugUtilsObjectNameEXT(device, info);
}

static VKAPI_ATTR VkResult VKAPI_CALL create_pass(VkDevice device, const VkRenderPassCreateInfo2 *info,
                                                  const VkAllocationCallbacks *allocator, VkRenderPass *out) {
    VkResult result = driver.CreateRenderPass2(device, info, allocator, out);
    if (result != VK_SUCCESS) return result;
    assert_true(pass_count < MAX_PASSES && info->attachmentCount <= GPU_MAX_SCOPE_ATTACHMENTS);
    struct known_pass *pass = &passes[pass_count++];
    pass->handle = *out;
    pass->count = info->attachmentCount;
    memcpy(pass->attachments, info->pAttachments, info->attachmentCount * sizeof *pass->attachments);
    return result;
}

/* ---- attachments ---- */

static void use_contents(VkImage image) {
    for (uint32_t i = 0; i < spy.attachment_count; i++)
        if (spy.attachments[i].image == image) spy.attachments[i].is_used = true;
}

static void add_attachment(VkImageView view, const VkRect2D *area, uint32_t layers, VkAttachmentLoadOp load,
                           VkAttachmentStoreOp store, bool is_resolve, bool is_scope) {
    if (!view) return;
    const struct known_image *image = NULL;
    for (uint32_t i = 0; i < view_count && !image; i++)
        if (views[i].handle == view) image = find_image(views[i].image);
    assert_non_null(image); /* made before spy_begin */
    if (load == VK_ATTACHMENT_LOAD_OP_LOAD) use_contents(image->handle);
    assert_true(spy.attachment_count < COUNT_OF(spy.attachments));
    struct spy_attachment *a = &spy.attachments[spy.attachment_count++];
    *a = (struct spy_attachment){.image = image->handle,
                                 .format = image->format,
                                 .bytes = (uint64_t)area->extent.width * area->extent.height * layers * image->samples *
                                          gpu_texel_bytes(image->format),
                                 .load = load,
                                 .store = store,
                                 .is_resolve = is_resolve,
                                 .is_scope = is_scope,
                                 .is_transient = image->usage & VK_IMAGE_USAGE_TRANSIENT_ATTACHMENT_BIT};
    memcpy(a->name, image->name, sizeof a->name);
    if (depth) memcpy(a->label, labels[depth - 1], sizeof a->label);
}

static void add_rendering_attachment(const VkRenderingInfo *info, const VkRenderingAttachmentInfo *attachment) {
    if (!attachment) return;
    add_attachment(attachment->imageView, &info->renderArea, info->layerCount, attachment->loadOp, attachment->storeOp,
                   false, false);
    if (attachment->resolveMode != VK_RESOLVE_MODE_NONE)
        add_attachment(attachment->resolveImageView, &info->renderArea, info->layerCount, VK_ATTACHMENT_LOAD_OP_DONT_CARE,
                       VK_ATTACHMENT_STORE_OP_STORE, true, false);
}

static VKAPI_ATTR void VKAPI_CALL begin_rendering(VkCommandBuffer commands, const VkRenderingInfo *info) {
    for (uint32_t i = 0; i < info->colorAttachmentCount; i++) add_rendering_attachment(info, &info->pColorAttachments[i]);
    const VkRenderingAttachmentInfo *depth_info = info->pDepthAttachment, *stencil = info->pStencilAttachment;
    add_rendering_attachment(info, depth_info);
    /* An image of both is one attachment of the graph. */
    if (!depth_info || (stencil && stencil->imageView != depth_info->imageView)) add_rendering_attachment(info, stencil);
    driver.CmdBeginRendering(commands, info);
}

static VKAPI_ATTR void VKAPI_CALL begin_render_pass(VkCommandBuffer commands, const VkRenderPassBeginInfo *info,
                                                    const VkSubpassBeginInfo *contents) {
    const VkRenderPassAttachmentBeginInfo *given = info->pNext;
    uint32_t p = 0;
    while (p < pass_count && passes[p].handle != info->renderPass) p++;
    assert_true(p < pass_count); /* made before spy_begin */
    for (uint32_t i = 0; i < given->attachmentCount; i++)
        add_attachment(given->pAttachments[i], &info->renderArea, 1, passes[p].attachments[i].loadOp,
                       passes[p].attachments[i].storeOp, false, true);
    driver.CmdBeginRenderPass2(commands, info, contents);
}

static VKAPI_ATTR void VKAPI_CALL pipeline_barrier(VkCommandBuffer commands, const VkDependencyInfo *info) {
    spy.barrier_calls++;
    spy.image_barriers += info->imageMemoryBarrierCount;
    spy.memory_barriers += info->memoryBarrierCount;
    for (uint32_t i = 0; i < info->imageMemoryBarrierCount; i++)
        if (info->pImageMemoryBarriers[i].oldLayout != VK_IMAGE_LAYOUT_UNDEFINED)
            use_contents(info->pImageMemoryBarriers[i].image);
    driver.CmdPipelineBarrier2(commands, info);
}

/* ---- work ---- */

static VKAPI_ATTR void VKAPI_CALL begin_label(VkCommandBuffer commands, const VkDebugUtilsLabelEXT *label) {
    assert_true(depth < MAX_DEPTH);
    snprintf(labels[depth++], sizeof labels[0], "%s", label->pLabelName);
    driver.CmdBeginDebugUtilsLabelEXT(commands, label);
}

static void full_barrier(VkCommandBuffer commands) {
    const VkAccessFlags2 all = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT;
    VkMemoryBarrier2 memory = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
                               .srcStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                               .srcAccessMask = all,
                               .dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT | VK_PIPELINE_STAGE_2_HOST_BIT,
                               .dstAccessMask = all | VK_ACCESS_2_HOST_READ_BIT};
    VkDependencyInfo info = {
        .sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO, .memoryBarrierCount = 1, .pMemoryBarriers = &memory};
    driver.CmdPipelineBarrier2(commands, &info);
}

/* Between the graph's buffer and ours. */
static void copy_tapped(VkCommandBuffer commands, const struct tap *tap, bool to_ours) {
    const struct gpu_buffer *theirs = NULL;
    for (uint32_t i = 0; i < tap->graph->resources.count; i++) {
        const struct graph_resource *resource = &tap->graph->resources.data[i];
        if (!resource->is_image && resource->buffer && strcmp(resource->name, tap->buffer) == 0) theirs = resource->buffer;
    }
    assert_non_null(theirs);
    VkBufferCopy region = {.size = MIN(theirs->size - tap->offset, tap->size)};
    *(to_ours ? &region.srcOffset : &region.dstOffset) = tap->offset;
    VkBuffer from = to_ours ? theirs->handle : tap->ours->handle, to = to_ours ? tap->ours->handle : theirs->handle;
    full_barrier(commands);
    driver.CmdCopyBuffer(commands, from, to, 1, &region);
    full_barrier(commands);
}

static VKAPI_ATTR void VKAPI_CALL end_label(VkCommandBuffer commands) {
    assert_true(depth > 0);
    depth--;
    driver.CmdEndDebugUtilsLabelEXT(commands);
    if (overwrite.ours && strcmp(labels[depth], overwrite.pass) == 0) copy_tapped(commands, &overwrite, false);
    if (capture.ours && strcmp(labels[depth], capture.pass) == 0) copy_tapped(commands, &capture, true);
}

const struct gpu_compute_params *spy_compute_params(const struct gpu_pipeline *pipeline) {
    return pipeline && pipeline->point == VK_PIPELINE_BIND_POINT_COMPUTE ? &pipeline->key.compute : NULL;
}

const struct gpu_graphics_params *spy_graphics_params(const struct gpu_pipeline *pipeline) {
    return pipeline && pipeline->point == VK_PIPELINE_BIND_POINT_GRAPHICS ? &pipeline->key.graphics : NULL;
}

void spy_capture(const struct graph *graph, const char *pass, const char *buffer, const struct gpu_buffer *out) {
    capture = (struct tap){graph, pass, buffer, 0, out ? out->size : 0, out};
}

void spy_overwrite(const struct graph *graph, const char *pass, const char *buffer, uint64_t offset, uint64_t size,
                   const struct gpu_buffer *from) {
    overwrite = (struct tap){graph, pass, buffer, offset, size, from};
}

static VKAPI_ATTR void VKAPI_CALL bind_pipeline(VkCommandBuffer commands, VkPipelineBindPoint point, VkPipeline handle) {
    bound = NULL;
    for (uint32_t i = 0; i < spied->pipelines.capacity && !bound; i++)
        if (spied->pipelines.table[i] && spied->pipelines.table[i]->handle == handle) bound = spied->pipelines.table[i];
    if (spy.replace && bound) bound = spy.replace(spied, bound);
    driver.CmdBindPipeline(commands, point, bound ? bound->handle : handle);
}

static VKAPI_ATTR void VKAPI_CALL set_cull_mode(VkCommandBuffer commands, VkCullModeFlags cull) {
    driver.CmdSetCullMode(commands, spy.cull ? spy.cull(bound, cull) : cull);
}

static void add_work(bool indirect, uint64_t offset, uint32_t x, uint32_t y, uint32_t z) {
    assert_true(spy.work_count < COUNT_OF(spy.work));
    struct spy_work *w = &spy.work[spy.work_count++];
    *w = (struct spy_work){.pipeline = bound, .indirect = indirect, .offset = offset, .count = {x, y, z}};
    if (depth) memcpy(w->label, labels[depth - 1], sizeof w->label);
}

static VKAPI_ATTR void VKAPI_CALL dispatch(VkCommandBuffer commands, uint32_t x, uint32_t y, uint32_t z) {
    add_work(false, 0, x, y, z);
    driver.CmdDispatch(commands, x, y, z);
}

static VKAPI_ATTR void VKAPI_CALL dispatch_indirect(VkCommandBuffer commands, VkBuffer buffer, VkDeviceSize offset) {
    add_work(true, offset, 1, 0, 0);
    driver.CmdDispatchIndirect(commands, buffer, offset);
}

static VKAPI_ATTR void VKAPI_CALL draw(VkCommandBuffer commands, uint32_t vertices, uint32_t instances, uint32_t first_vertex,
                                       uint32_t first_instance) {
    add_work(false, 0, vertices, instances, 0);
    driver.CmdDraw(commands, vertices, instances, first_vertex, first_instance);
}

static VKAPI_ATTR void VKAPI_CALL draw_indexed_indirect(VkCommandBuffer commands, VkBuffer buffer, VkDeviceSize offset,
                                                        uint32_t count, uint32_t stride) {
    add_work(true, offset, count, 0, 0);
    driver.CmdDrawIndexedIndirect(commands, buffer, offset, count, stride);
}

static VKAPI_ATTR void VKAPI_CALL draw_indexed_indirect_count(VkCommandBuffer commands, VkBuffer buffer, VkDeviceSize offset,
                                                              VkBuffer count_buffer, VkDeviceSize count_offset,
                                                              uint32_t most, uint32_t stride) {
    if (most > 0) add_work(true, offset, most, 0, 0); /* else it mends the driver: gpu_draw_indexed_indirect_count */
    driver.CmdDrawIndexedIndirectCount(commands, buffer, offset, count_buffer, count_offset, most, stride);
}

static VKAPI_ATTR void VKAPI_CALL fill_buffer(VkCommandBuffer commands, VkBuffer buffer, VkDeviceSize offset,
                                              VkDeviceSize size, uint32_t value) {
    spy.filled_bytes += size;
    driver.CmdFillBuffer(commands, buffer, offset, size, value);
}

static VKAPI_ATTR void VKAPI_CALL copy_buffer(VkCommandBuffer commands, VkBuffer from, VkBuffer to, uint32_t count,
                                              const VkBufferCopy *regions) {
    for (uint32_t i = 0; i < count; i++) spy.copied_bytes += regions[i].size;
    driver.CmdCopyBuffer(commands, from, to, count, regions);
}

/* ---- on and off ---- */

void spy_begin(gpu_device *device) {
    assert_null(spied);
    assert_true(device->names); /* the labels tell the passes */
    spied = device;
    driver = device->vk;
    image_count = view_count = pass_count = depth = 0;
    bound = NULL;
    spy_capture(NULL, NULL, NULL, NULL);
    spy_overwrite(NULL, NULL, NULL, 0, 0, NULL);
    memset(&spy, 0, sizeof spy);
    struct gpu_device_functions *vk = &device->vk;
    vk->CreateImage = create_image;
    vk->DestroyImage = destroy_image;
    vk->CreateImageView = create_view;
    vk->DestroyImageView = destroy_view;
    vk->SetDebugUtilsObjectNameEXT = name_object;
    vk->CreateRenderPass2 = create_pass;
    vk->CmdBeginRendering = begin_rendering;
    vk->CmdBeginRenderPass2 = begin_render_pass;
    vk->CmdPipelineBarrier2 = pipeline_barrier;
    vk->CmdBeginDebugUtilsLabelEXT = begin_label;
    vk->CmdEndDebugUtilsLabelEXT = end_label;
    vk->CmdBindPipeline = bind_pipeline;
    vk->CmdSetCullMode = set_cull_mode;
    vk->CmdDispatch = dispatch;
    vk->CmdDispatchIndirect = dispatch_indirect;
    vk->CmdDraw = draw;
    vk->CmdDrawIndexedIndirect = draw_indexed_indirect;
    vk->CmdDrawIndexedIndirectCount = draw_indexed_indirect_count;
    vk->CmdFillBuffer = fill_buffer;
    vk->CmdCopyBuffer = copy_buffer;
}

void spy_end(void) {
    if (spied) spied->vk = driver;
    spied = NULL;
}

int spy_tear_down(void **state) {
    UNUSED(state);
    spy_end();
    return 0;
}

void spy_clear(void) {
    spy.attachment_count = spy.work_count = 0;
    spy.barrier_calls = spy.image_barriers = spy.memory_barriers = 0;
    spy.filled_bytes = spy.copied_bytes = 0;
}

/* ---- sums ---- */

uint64_t spy_loaded(const struct spy_attachment *a) { return a->load == VK_ATTACHMENT_LOAD_OP_LOAD ? a->bytes : 0; }
uint64_t spy_stored(const struct spy_attachment *a) { return a->store == VK_ATTACHMENT_STORE_OP_STORE ? a->bytes : 0; }
uint64_t spy_discarded(const struct spy_attachment *a) {
    return a->store == VK_ATTACHMENT_STORE_OP_DONT_CARE ? a->bytes : 0;
}

uint64_t spy_sum(uint64_t (*bytes)(const struct spy_attachment *attachment)) {
    uint64_t sum = 0;
    for (uint32_t i = 0; i < spy.attachment_count; i++) sum += bytes(&spy.attachments[i]);
    return sum;
}

uint32_t spy_count_work(const char *label) {
    uint32_t count = 0;
    for (uint32_t i = 0; i < spy.work_count; i++) count += strcmp(spy.work[i].label, label) == 0;
    return count;
}
