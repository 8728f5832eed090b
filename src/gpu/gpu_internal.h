/* SPDX-License-Identifier: MIT */
/** What the files of this folder share. */
#ifndef FNL_GPU_INTERNAL_H
#define FNL_GPU_INTERNAL_H

#include "base/jobs.h"
#include "gpu/functions.h"
#include "gpu/gpu.h"

#include <pthread.h>
#include <stdatomic.h>

enum {
    GPU_QUEUE_COUNT = 2,
    GPU_SAMPLED_MAX = 65536, /* array sizes of the bindless set, unless the device has less */
    GPU_STORAGE_MAX = 16384,
    GPU_SAMPLER_MAX = 256,
    GPU_SLICE_BUFFERS = 32,
    GPU_UPLOAD_SEGMENTS = 4,
    GPU_PIPELINE_WORKERS = 8,
    GPU_UPLOAD_SEGMENT_BYTES = 8 << 20,
    GPU_SURFACE_EXTENSIONS = 8,
};

/* ---- instance.c: the loader, the instance and its messages ---- */

struct gpu_instance {
    fnl_host host;
    void *library; /* NULL for an imported instance */
    PFN_vkGetInstanceProcAddr get_proc;
    VkInstance handle;
    bool owned;
    struct gpu_instance_functions vk;
    VkDebugUtilsMessengerEXT messenger;
    atomic_ullong message_count;
    uint32_t layer_version; /* with validation: Vulkan's version as the layer knows it */
};

/**
 * Opens the loader and makes an instance. `out` has its final address, for messages keep a pointer to it. Without a loader
 * or a driver FNL_ERROR_DEVICE; with `quiet` that logs nothing. Close it even after a failure.
 */
struct gpu_instance_params {
    bool validate, presentation, quiet;
};
fnl_result gpu_instance_open(struct gpu_instance *out, const fnl_host *host, const struct gpu_instance_params *params);
fnl_result gpu_instance_import(struct gpu_instance *out, const fnl_host *host, PFN_vkGetInstanceProcAddr get_proc,
                               VkInstance handle, bool validate);
void gpu_instance_close(struct gpu_instance *instance);

/* ---- device_pick.c: what a physical device has ---- */

/** Feature structs in one chain; the same members as the public fnl_vulkan_requirements. */
struct gpu_features {
    VkPhysicalDeviceFeatures2 features;
    VkPhysicalDeviceVulkan11Features features_11;
    VkPhysicalDeviceVulkan12Features features_12;
    VkPhysicalDeviceVulkan13Features features_13;
};

/** All features off, and linked to one chain. */
void gpu_features_clear(struct gpu_features *features);
/** The required ones on. */
void gpu_features_require(struct gpu_features *features);
/** Appends the names of the required ones that are off to a comma-separated list. */
void gpu_features_missing(const struct gpu_features *features, char *list, size_t capacity);

struct gpu_physical {
    VkPhysicalDevice handle;
    fnl_device_info info;
    struct gpu_features supported;
    bool isotropic_gradients;
    bool swapchain;
    bool structures, deferred_operations; /* VK_KHR_acceleration_structure, and the extension that it asks for */
    uint32_t families[GPU_QUEUE_COUNT], queue_indices[GPU_QUEUE_COUNT]; /* the second is valid with info.async_compute */
};

/** `out` must not be moved: its features are linked. */
void gpu_physical_query(const struct gpu_instance *instance, VkPhysicalDevice handle, struct gpu_physical *out);
/** Chooses as params say; logs the reason for each device that does not do. */
fnl_result gpu_physical_pick(const struct gpu_instance *instance, const fnl_device_params *params, struct gpu_physical *out);

/* ---- retire.c: objects that wait for the frames that may use them ---- */

struct gpu_retired {
    VkBuffer buffer;
    VkImage image;
    VkImageView views[3];
    VkFramebuffer framebuffer;
    VkAccelerationStructureKHR structure; /* in the buffer */
    VkQueryPool queries;
    VkDeviceMemory memory; /* a heap, of heap_size bytes */
    uint64_t heap_size;
    uint32_t sampled_index, storage_index, srgb_index; /* GPU_NO_INDEX: none */
    struct gpu_allocation allocation;                  /* size 0: none */
};

struct gpu_retire_list {
    ARRAY(struct gpu_retired) items;
    uint64_t upload_value; /* uploads that may touch the items */
};

/** Makes sure that a later gpu_retire cannot fail: call it once for each object made. */
bool gpu_retire_reserve(gpu_device *device);
/** Takes a reservation back. */
void gpu_retire_cancel(gpu_device *device);
void gpu_retire(gpu_device *device, const struct gpu_retired *item);
/** Frees what one slot's list holds. */
void gpu_retire_release(gpu_device *device, uint32_t slot);
/** Frees an object that no submitted work uses. Does not touch reservations. */
void gpu_retired_free(gpu_device *device, const struct gpu_retired *item);

/* ---- memory.c ---- */

struct gpu_range {
    uint64_t offset, size;
};

struct gpu_block {
    VkDeviceMemory memory; /* VK_NULL_HANDLE: this entry is free */
    uint64_t size;
    void *mapped;
    uint32_t type, allocation_count;
    bool optimal, dedicated;
    ARRAY(struct gpu_range) free; /* sorted by offset, never touching; room for allocation_count + 1 */
};

struct gpu_memory {
    pthread_mutex_t mutex;
    VkPhysicalDeviceMemoryProperties properties;
    uint64_t granularity;
    ARRAY(struct gpu_block) blocks;
    struct gpu_memory_stats stats;
};

/** `optimal`: for images. The name is for the message. `mapped` may be NULL. */
fnl_result gpu_memory_allocate(gpu_device *device, const char *name, const VkMemoryRequirements *requirements,
                               enum gpu_memory_kind kind, enum gpu_use use, bool optimal, struct gpu_allocation *out, VkDeviceMemory *memory,
                               void **mapped);
/** Memory types that do, best first; returns their number. Mapped kinds are coherent always. */
uint32_t gpu_memory_order_types(const struct gpu_memory *memory, enum gpu_memory_kind kind, uint32_t mask,
                                uint32_t types[VK_MAX_MEMORY_TYPES]);
/** The first lazily allocated type of the mask, if there is one. */
bool gpu_memory_lazy_type(const struct gpu_memory *memory, uint32_t mask, uint32_t *type);
void gpu_memory_free(gpu_device *device, const struct gpu_allocation *allocation);
/** Counts bytes in use as those of an acceleration structure, or not any more. */
void gpu_memory_count_structure(gpu_device *device, uint64_t size, bool made);
void gpu_memory_free_heap(gpu_device *device, VkDeviceMemory memory, uint64_t size);
void gpu_memory_finish(gpu_device *device);

/* ---- buffer.c ---- */

/** What stays in a buffer is an acceleration structure, and counts as such. */
fnl_result gpu_structure_buffer_create(gpu_device *device, const char *name, uint64_t size, struct gpu_buffer *out);

/* ---- bindless.c ---- */

enum gpu_binding { GPU_BINDING_SAMPLED, GPU_BINDING_SAMPLER, GPU_BINDING_STORAGE, GPU_BINDING_COUNT };

struct gpu_index_pool {
    uint32_t capacity, next; /* indices from next on were never taken */
    ARRAY(uint32_t) free;    /* room for `next` */
};

struct gpu_bindless {
    pthread_mutex_t mutex;
    struct gpu_index_pool pools[GPU_BINDING_COUNT];
    VkDescriptorSetLayout set_layout;
    VkDescriptorPool pool;
    VkDescriptorSet set;
    VkPipelineLayout layout;
    struct gpu_sampler_params samplers[GPU_SAMPLER_MAX];
    VkSampler sampler_handles[GPU_SAMPLER_MAX];
};

fnl_result gpu_bindless_init(gpu_device *device);
void gpu_bindless_finish(gpu_device *device);
/** Takes an index and writes the view there. FNL_ERROR_MEMORY when the array is full. */
fnl_result gpu_bindless_add(gpu_device *device, enum gpu_binding binding, VkImageView view, VkImageLayout layout,
                            uint32_t *out);
void gpu_bindless_remove(gpu_device *device, enum gpu_binding binding, uint32_t index);

/* ---- pipeline.c, pipeline_cache.c ---- */

enum gpu_pipeline_state {
    GPU_PIPELINE_NEW,   /* for the first who needs it to make */
    GPU_PIPELINE_ASKED, /* the same, and in line for the worker */
    GPU_PIPELINE_BEING_MADE,
    GPU_PIPELINE_MADE,
};

struct gpu_pipeline {
    atomic_int state;  /* changes under the mutex; from MADE on nothing below changes */
    VkPipeline handle; /* VK_NULL_HANDLE: could not be made, for the reason of `result` */
    fnl_result result;
    struct gpu_pipeline *next_asked;
    uint64_t asked; /* its number in line, from 1 on */
    VkPipelineBindPoint point;
    uint64_t hash;
    union gpu_pipeline_key {
        struct gpu_compute_params compute;
        struct gpu_graphics_params graphics;
    } key;
};

struct gpu_pipelines {
    pthread_rwlock_t lock;       /* of the table */
    struct gpu_pipeline **table; /* open addressing; the capacity is a power of two */
    uint32_t count, capacity;
    pthread_mutex_t mutex;  /* of new entries, states and what is below */
    pthread_cond_t changed; /* a state, the line, or stop */
    struct gpu_pipeline_worker {
        gpu_device *device;
        pthread_t thread;
        uint64_t at; /* number in line of what it is making, 0: at rest */
    } workers[GPU_PIPELINE_WORKERS]; /* take what was asked for, in that order */
    uint32_t worker_count;           /* they are started when first asked */
    bool stop;
    struct gpu_pipeline *first_asked, *last_asked;
    struct gpu_pipeline_stats stats; /* of `done`: what was taken from the line */
    bool asking, asking_missed; /* between gpu_ask_begin and end; something was not there */
    VkPipelineCache cache;
    char *cache_path; /* NULL: not kept */
    size_t cache_path_size, loaded_size;
    uint64_t loaded_hash; /* of what the driver was given of the file */
};

fnl_result gpu_pipelines_init(gpu_device *device, const char *cache_folder);
void gpu_pipelines_finish(gpu_device *device);
/** Makes pipelines.cache, from the file where there is a good one. */
fnl_result gpu_pipeline_cache_load(gpu_device *device, const char *cache_folder);
/** Writes the file if the cache grew, with what other processes have put there since it was loaded. */
void gpu_pipeline_cache_save(gpu_device *device);

/* ---- rehearse.c ---- */

/** Uses a pipeline of another device on this one, with nothing to draw or to compute, and waits for it. False: it could not. */
bool gpu_rehearse(gpu_device *stage, const struct gpu_pipeline *pipeline);

/* ---- scope.c ---- */

enum { GPU_SCOPE_FRAMEBUFFERS = 4, GPU_SCOPE_SETS = 64 }; /* kept of a scope; of steps in a frame */

/** A framebuffer without images: what it needs to know of them. */
struct gpu_framebuffer {
    VkFramebuffer handle;
    uint32_t width, height, layers;
    VkImageUsageFlags usages[GPU_MAX_SCOPE_ATTACHMENTS];
    uint64_t last_use;
};

struct gpu_scope {
    struct gpu_scope_params params;
    uint64_t hash;
    VkRenderPass handle; /* VK_NULL_HANDLE: could not be made, for the reason of `result` */
    fnl_result result;
    struct gpu_framebuffer framebuffers[GPU_SCOPE_FRAMEBUFFERS];
};

struct gpu_scopes {
    pthread_mutex_t mutex; /* of all of it */
    ARRAY(struct gpu_scope *) items;
    uint32_t input_count; /* at most, in a step */
    VkDescriptorSetLayout set_layout;
    VkPipelineLayout layout; /* the bindless one with set 1 for inputs */
    VkDescriptorPool pools[GPU_FRAMES_IN_FLIGHT];
    VkDescriptorSet sets[GPU_FRAMES_IN_FLIGHT][GPU_SCOPE_SETS];
    uint32_t used[GPU_FRAMES_IN_FLIGHT];
    uint64_t uses;
};

fnl_result gpu_scopes_init(gpu_device *device);
void gpu_scopes_finish(gpu_device *device);
/** The sets of the slot's last frame are free again. */
void gpu_scopes_begin_frame(gpu_device *device, uint32_t slot);

/* ---- commands.c ---- */

struct gpu_commands {
    gpu_device *device;
    VkCommandBuffer handle; /* VK_NULL_HANDLE: recording does nothing */
    enum gpu_queue queue;
    uint32_t slot;
    const struct gpu_pipeline *pipeline;
    bool set_bound[2]; /* by VkPipelineBindPoint: graphics 0, compute 1 */
    const struct gpu_scope *scope;
    uint32_t scope_step;
    VkImageView scope_views[GPU_MAX_SCOPE_ATTACHMENTS];
    bool scope_skipped; /* it could not be begun: draws do nothing */
};

struct gpu_command_pool {
    VkCommandPool handle;
    ARRAY(struct gpu_commands *) buffers;
    uint32_t used;
};

fnl_result gpu_command_pool_init(gpu_device *device, struct gpu_command_pool *pool, enum gpu_queue queue);
void gpu_command_pool_finish(gpu_device *device, struct gpu_command_pool *pool);
VkImageAspectFlags gpu_format_aspect(VkFormat format);
/** What the attachment view of an image of this usage is for. */
VkImageUsageFlags gpu_view_usage(VkImageUsageFlags usage);

/* ---- frame.c, slices.c ---- */

struct gpu_slices {
    struct gpu_buffer buffers[GPU_SLICE_BUFFERS]; /* each at least twice as big as the one before */
    uint32_t count;
    uint64_t used; /* of the last buffer */
};

void gpu_slices_reset(gpu_device *device, struct gpu_slices *slices);
void gpu_slices_finish(gpu_device *device, struct gpu_slices *slices);

struct gpu_frame {
    uint64_t values[GPU_QUEUE_COUNT]; /* of the queues' timelines, when the frame is over */
    struct gpu_command_pool pools[GPU_QUEUE_COUNT][GPU_MAX_CHUNKS];
    VkQueryPool queries;
    atomic_uint timestamp_count; /* highest index written, plus 1 */
    bool timestamps_pending;     /* submitted and not fetched */
    uint64_t ticks[GPU_MAX_TIMESTAMPS];
    uint32_t tick_count; /* ticks 0 .. tick_count - 1 were written */
    VkQueryPool vertex_counts; /* null: the device has none */
    atomic_bool vertices_counted; /* in this frame; queries must be reset before the next use */
    struct gpu_slices slices;
    struct gpu_retire_list retired;
};

struct gpu_queue_state {
    VkQueue handle;
    uint32_t family;
    VkSemaphore timeline;
    uint64_t value;       /* last one submitted */
    uint64_t upload_seen; /* uploads that later batches need not wait for */
};

fnl_result gpu_frames_init(gpu_device *device);
void gpu_frames_finish(gpu_device *device);
fnl_result gpu_semaphore_create(gpu_device *device, const char *name, VkSemaphore *out);
fnl_result gpu_semaphore_wait(gpu_device *device, VkSemaphore semaphore, uint64_t value);

/* ---- upload.c ---- */

struct gpu_upload_segment {
    VkCommandPool pool;
    VkCommandBuffer commands;
    uint64_t value; /* its last submission */
};

struct gpu_uploads {
    pthread_mutex_t mutex;
    struct gpu_buffer ring, readback;
    struct gpu_upload_segment segments[GPU_UPLOAD_SEGMENTS];
    uint32_t segment;
    uint64_t used;    /* bytes of the current segment */
    bool open, ready; /* the current segment's command buffer is recording; all of this struct was made */
    VkSemaphore timeline;
    atomic_ullong submitted; /* written under the device's queue mutex */
    atomic_ullong recorded;  /* submitted, plus 1 while a segment is open */
};

void gpu_uploads_finish(gpu_device *device);
/** Submits what is needed and waits until the timeline has reached the value. */
fnl_result gpu_uploads_wait(gpu_device *device, uint64_t value);

/* ---- device.c ---- */

struct fnl_device {
    fnl_host host;
    struct jobs *jobs;
    struct gpu_instance instance;
    VkPhysicalDevice physical;
    VkDevice handle;
    bool imported;
    struct gpu_device_functions vk;
    bool names; /* debug utils are there */
    fnl_device_info info;
    VkPhysicalDeviceProperties properties;
    uint64_t max_buffer_size;
    uint64_t timestamp_mask; /* 0: no timestamps */
    bool isotropic_gradients;
    uint64_t scratch_alignment; /* of building acceleration structures */
    bool keeps_draw_counts; /* the driver's fault that gpu_draw_indexed_indirect_count mends */
    bool compiles_late;     /* the driver's way that rehearse.c is for */

    atomic_int status;
    pthread_mutex_t queue_mutex; /* of both queues */
    struct gpu_queue_state queues[GPU_QUEUE_COUNT];

    pthread_mutex_t retire_mutex;
    uint32_t object_count; /* reservations */

    struct gpu_memory memory;
    struct gpu_bindless bindless;
    struct gpu_pipelines pipelines;
    struct gpu_scopes scopes;
    struct gpu_uploads uploads;

    struct gpu_frame frames[GPU_FRAMES_IN_FLIGHT];
    uint64_t frame_number;
    bool in_frame;
    struct gpu_commands dead_commands; /* what gpu_commands_begin gives after a failure */
    ARRAY(VkCommandBufferSubmitInfo) submit_infos;
    ARRAY(uint64_t) batch_values;
    pthread_mutex_t slice_mutex;
    struct gpu_last_uses last_uses;
    void *shared;
};

/** The parts that own and imported devices share: everything above the VkDevice. */
fnl_result gpu_device_start(gpu_device *device, const char *cache_folder);
/** Allocates the struct with host, locks and job pool. */
fnl_result gpu_device_new(const fnl_device_params *params, gpu_device **out);
/** Another device of the same instance and driver, with a quiet log and no cache folder. NULL after a failure. */
fnl_result gpu_device_create_beside(const gpu_device *device, gpu_device **out);
/** What a VkResult means here; failures are logged as "<what>: VK_ERROR_…", and device loss sticks. */
fnl_result gpu_check(gpu_device *device, VkResult result, const char *format, ...) __attribute__((format(printf, 3, 4)));
const char *gpu_result_text(VkResult result);
fnl_result gpu_result_meaning(VkResult result);
void gpu_name(gpu_device *device, VkObjectType type, uint64_t handle, const char *name);
/** Fills in sharing between the queue families of the device. */
void gpu_sharing(const gpu_device *device, VkSharingMode *mode, uint32_t *count, uint32_t families[GPU_QUEUE_COUNT]);

#endif
