/* SPDX-License-Identifier: MIT */
/**
 * The Vulkan device as the rest of the library sees it. Vulkan's enums and flags are used as they are; its functions are
 * called in this folder only. Recording calls are void: the first error sticks to the device and comes out at submit.
 */
#ifndef FNL_GPU_GPU_H
#define FNL_GPU_GPU_H

#include "base/base.h"
#include "base/file.h"
#include "fanal/device.h"
#include "gpu/shader.h"

#include <pthread.h>
#include <vulkan/vulkan_core.h>

struct fnl_vulkan_import;
struct fnl_device; /* the public handle is the device itself */
typedef struct fnl_device gpu_device;

enum {
    GPU_FRAMES_IN_FLIGHT = 2,
    GPU_PUSH_BYTES = 128,
    GPU_MAX_COLORS = 8,
    GPU_MAX_CONSTANTS = 16,
    GPU_FEATURES_ID = 31, /* specialisation constant of graphics pipelines beside the numbered ones */
    GPU_MAX_CHUNKS = 16,  /* command buffers that may be recorded at once */
    GPU_MAX_INPUTS = 8,   /* attachments that a step of a scope reads */
    GPU_MAX_SCOPE_ATTACHMENTS = 16,
    GPU_MAX_SCOPE_STEPS = 8,
};

#define GPU_NO_INDEX UINT32_MAX

/* ---- device ---- */

const fnl_host *gpu_host(const gpu_device *device);
struct jobs *gpu_jobs(gpu_device *device);
const fnl_device_info *gpu_info(const gpu_device *device);
/** True where textureGrad() filters without anisotropy whatever the sampler says: shaders then take several samples along the longer gradient. */
bool gpu_isotropic_gradients(const gpu_device *device);
/** Whether samples lie where Vulkan's standard locations are. */
bool gpu_standard_samples(const gpu_device *device);
/** Bits of a pixel's fraction that a rasteriser keeps of a vertex's place. */
uint32_t gpu_subpixel_bits(const gpu_device *device);
bool gpu_format_supports(const gpu_device *device, VkFormat format, VkFormatFeatureFlags2 features);
/** Sample counts, as bits, of colour targets of this format that are sampled later. */
uint32_t gpu_target_samples(const gpu_device *device, VkFormat format);
/** Waits until all submitted work is done. */
fnl_result gpu_wait_idle(gpu_device *device);
/** The sticky error, FNL_OK when none. Logged when it was set. */
fnl_result gpu_status(const gpu_device *device);
/** Makes an error stick (the first wins). */
void gpu_fail(gpu_device *device, fnl_result result);

/** What memory is for, in the accounts alone. */
enum gpu_use {
    GPU_USE_OTHER,    /* whatever says nothing else */
    GPU_USE_GEOMETRY, /* vertices, clusters, instances, materials, acceleration structures */
    GPU_USE_TEXTURES, /* images of materials and decals */
    GPU_USE_LIGHTS,   /* lights, decals, probes, the environment, and lists that outlive frames */
    GPU_USE_SHADOWS,  /* pages of shadow maps and what says where they are */
    GPU_USE_FRAME,    /* what lives within a frame: its images, its light lists and other buffers */
    GPU_USE_HISTORY,  /* images that one frame hands on to the next */
    GPU_USE_TRANSFER, /* between the CPU and the device, both ways */
    GPU_USE_COUNT
};
/** Such as "geometry". */
const char *gpu_use_name(enum gpu_use use);

struct gpu_memory_stats {
    uint64_t used_bytes, reserved_bytes, peak_used_bytes;
    uint64_t use_bytes[GPU_USE_COUNT]; /* of used_bytes: together all of them */
    uint64_t structure_bytes; /* of used_bytes: acceleration structures */
};
/**
 * Files beside the pipeline cache, one per stem, device and driver. Load is false when there is none; save fails silently, as
 * what cannot be kept is no error.
 */
bool gpu_cache_load(gpu_device *device, const char *stem, struct file_view *out);
/** The same of a large file, to be read in pieces and closed; NULL where there is none. */
FILE *gpu_cache_open(gpu_device *device, const char *stem);
void gpu_cache_save(gpu_device *device, const char *stem, const void *data, size_t size);
/** Whether there is a folder that files are kept in. */
bool gpu_cache_has_folder(const gpu_device *device);
/** Of all files whose names start with `stem`, of whatever device, removes those that were not saved or opened for longest until the rest has `most_bytes`. */
void gpu_cache_trim(gpu_device *device, const char *stem, uint64_t most_bytes);

struct gpu_memory_stats gpu_memory_stats(const gpu_device *device);

/** A place for what those who use the device share, and free before it; NULL at first. */
void **gpu_shared(gpu_device *device);

/* ---- buffers ---- */

enum gpu_memory_kind {
    GPU_MEMORY_DEVICE,   /* device-local; filled by gpu_upload or shaders */
    GPU_MEMORY_UPLOAD,   /* mapped, written by the CPU once per use, read by the GPU */
    GPU_MEMORY_READBACK, /* mapped and cached, written by the GPU */
};

struct gpu_buffer {
    VkBuffer handle;
    VkDeviceAddress address;
    uint64_t size;
    void *mapped; /* not for GPU_MEMORY_DEVICE */
    struct gpu_allocation {
        uint32_t block, type;
        enum gpu_use use;
        uint64_t offset, size;
    } allocation;
};

/** Usable as storage (by address), index, indirect and transfer buffer. Size 0 is rounded up to 16. Not cleared. */
fnl_result gpu_buffer_create(gpu_device *device, const char *name, uint64_t size, enum gpu_memory_kind kind,
                             struct gpu_buffer *out);
/** The same with an account; without one it is that of GPU_USE_TRANSFER for memory that is mapped, and of GPU_USE_OTHER. */
fnl_result gpu_buffer_create_for(gpu_device *device, enum gpu_use use, const char *name, uint64_t size, enum gpu_memory_kind kind, struct gpu_buffer *out);
/** Freed once the frames in flight are over. Clears the struct; an all-zero struct is accepted. */
void gpu_buffer_destroy(gpu_device *device, struct gpu_buffer *buffer);

/* ---- acceleration structures, which rays walk through: only where fnl_device_info.ray_query ---- */

struct gpu_structure {
    VkAccelerationStructureKHR handle;
    VkDeviceAddress address; /* instances name the structure of a mesh by it, shaders that of the instances */
    struct gpu_buffer buffer;
};

/** What a structure is built of: triangles, or instances of structures of triangles. All of it can let rays through: shaders decide. */
struct gpu_structure_input {
    uint32_t count;            /* triangles or instances */
    VkDeviceAddress instances; /* VkAccelerationStructureInstanceKHR[count]; 0: triangles */
    VkDeviceAddress positions; /* vec3[vertex_count] */
    VkDeviceAddress indices;   /* uint32_t[3 * count] */
    uint32_t vertex_count;
    bool of_instances;
    bool changes; /* vertices move, and the structure may be updated; else it may be compacted */
};
struct gpu_structure_sizes {
    uint64_t size, build_scratch, update_scratch; /* scratch: a multiple of its alignment */
};
/** For at most so many triangles or instances; addresses do not matter. */
struct gpu_structure_sizes gpu_structure_sizes(gpu_device *device, const struct gpu_structure_input *input);
fnl_result gpu_structure_create(gpu_device *device, const char *name, bool of_instances, uint64_t size, struct gpu_structure *out);
/** As gpu_buffer_destroy. */
void gpu_structure_destroy(gpu_device *device, struct gpu_structure *structure);

/** What a scratch buffer must have beyond the sum of its parts. */
uint64_t gpu_scratch_padding(const gpu_device *device);

/** Sizes that structures would have if they were compacted, measured in a frame. */
struct gpu_structure_queries {
    VkQueryPool handle;
    uint32_t count;
};
fnl_result gpu_structure_queries_create(gpu_device *device, uint32_t count, struct gpu_structure_queries *out);
void gpu_structure_queries_destroy(gpu_device *device, struct gpu_structure_queries *queries);
/** When the frame that measured is over; false: nothing is known. */
bool gpu_structure_queries_read(gpu_device *device, const struct gpu_structure_queries *queries, uint64_t *sizes);

/* ---- images ---- */

struct gpu_extent {
    uint32_t width, height;
};

struct gpu_image_params {
    const char *name;
    VkFormat format;
    uint32_t width, height, layers, mips, samples; /* each at least 1 */
    bool cube;                                     /* layers = 6: also seen as a cube map */
    bool srgb_view;                                /* 8-bit UNORM, BC1, BC3, BC7: also seen as sRGB (image.srgb_index) */
    /* SAMPLED and STORAGE get bindless indices. STORAGE of a compressed format: shaders store whole blocks to its parts (gpu_image_part), where
       gpu_block_stores_supported() */
    VkImageUsageFlags usage;
    enum gpu_use use; /* its account */
};

struct gpu_image {
    VkImage handle;
    VkImageView view;            /* all mips and layers; for attachments: mip 0 */
    VkImageView attachment_view; /* mip 0, layer 0..layers-1 */
    VkImageView srgb_view;       /* with params.srgb_view */
    struct gpu_image_params params;
    uint32_t first_layer, first_mip; /* of the Vulkan image: 0 but for gpu_image_layer and gpu_image_part */
    uint32_t sampled_index, storage_index, srgb_index; /* in the bindless set, GPU_NO_INDEX when not of that usage */
    struct gpu_allocation allocation;
    bool owns_memory, imported;
};

fnl_result gpu_image_create(gpu_device *device, const struct gpu_image_params *params, struct gpu_image *out);
/** Freed, with its views and bindless indices, once the frames in flight are over. */
void gpu_image_destroy(gpu_device *device, struct gpu_image *image);
/** Wraps a caller's image: makes views and bindless indices, owns no memory. */
fnl_result gpu_image_import(gpu_device *device, VkImage handle, const struct gpu_image_params *params,
                            struct gpu_image *out);

/** One layer of an image, seen as an image of its own that owns no memory; destroyed before the frame in which `image` is, or in the same one. */
fnl_result gpu_image_layer(gpu_device *device, const struct gpu_image *image, uint32_t layer, struct gpu_image *out);

/**
 * One mip of one layer, seen as an image of its own; as gpu_image_layer. With `as_blocks`, of an image of a compressed format with
 * usage STORAGE: one of R32G32B32A32_UINT to store to, of which a texel is a block of 4 x 4.
 */
fnl_result gpu_image_part(gpu_device *device, const struct gpu_image *image, uint32_t layer, uint32_t mip, bool as_blocks,
                          struct gpu_image *out);
/** Whether images of this compressed format can have usage STORAGE. */
bool gpu_block_stores_supported(gpu_device *device, VkFormat format);

/** Size and alignment that an image or a buffer would take, without making one that stays. */
struct gpu_requirements {
    uint64_t size, alignment;
    uint32_t memory_types;
};
struct gpu_requirements gpu_image_requirements(gpu_device *device, const struct gpu_image_params *params);
struct gpu_requirements gpu_buffer_requirements(gpu_device *device, uint64_t size);

/** A piece of device-local memory in which several images and buffers may lie over one another. */
struct gpu_heap {
    VkDeviceMemory memory;
    uint64_t size;
    uint32_t memory_types;
    bool lazy; /* of lazily allocated memory: only images of usage TRANSIENT_ATTACHMENT ask for such types */
};
fnl_result gpu_heap_create(gpu_device *device, const char *name, uint64_t size, uint32_t memory_types, struct gpu_heap *out);
void gpu_heap_destroy(gpu_device *device, struct gpu_heap *heap);
/** Bytes that stand behind the heap: of a lazy one, what the driver could not keep on the chip. */
uint64_t gpu_heap_committed(gpu_device *device, const struct gpu_heap *heap);
/** Of one texel; 0 for compressed formats, and formats that Fanal does not use. */
uint32_t gpu_texel_bytes(VkFormat format);
/** Of so many texels, tightly packed; compressed formats too. */
uint64_t gpu_texels_bytes(VkFormat format, uint32_t width, uint32_t height);
fnl_result gpu_image_create_in(gpu_device *device, const struct gpu_heap *heap, uint64_t offset,
                               const struct gpu_image_params *params, struct gpu_image *out);
fnl_result gpu_buffer_create_in(gpu_device *device, const struct gpu_heap *heap, uint64_t offset, const char *name,
                                uint64_t size, struct gpu_buffer *out);

/** Samplers are made once per description; the index is into the bindless sampler array. */
struct gpu_sampler_params {
    VkFilter mag, min;
    VkSamplerMipmapMode mip;
    bool mipmapped;
    VkSamplerAddressMode wrap_u, wrap_v;
    float anisotropy; /* 1: off; clamped to what the device has */
    float bias;       /* added to the level of detail; clamped to what the device has */
    VkSamplerReductionMode reduction; /* MIN or MAX of the texels instead of their mean: where gpu_minmax_supported() */
};
uint32_t gpu_sampler_index(gpu_device *device, const struct gpu_sampler_params *params);
/** Whether images of this format can be sampled with a reduction. */
bool gpu_minmax_supported(const gpu_device *device, VkFormat format);

/* ---- uploads outside of frames: complete when gpu_upload_flush returns ---- */

/** Copies through a staging ring; blocks only when the ring is full. Thread-safe. */
fnl_result gpu_upload_buffer(gpu_device *device, const struct gpu_buffer *buffer, uint64_t offset, const void *data,
                             uint64_t size);
/** Fills mip 0 of layer 0 and, with `generate_mips`, the smaller ones by 2x2 blits; `color` averages through the sRGB view. Leaves the image in SHADER_READ_ONLY_OPTIMAL. Thread-safe. */
fnl_result gpu_upload_image(gpu_device *device, const struct gpu_image *image, const void *pixels, uint64_t size,
                            bool generate_mips, bool color);
/** The same in parts, from the top down without gaps: `count` rows from `first` on. The last part makes the mips and leaves the layout; nobody may use the image before. */
fnl_result gpu_upload_image_rows(gpu_device *device, const struct gpu_image *image, const void *pixels, uint64_t size,
                                 uint32_t first, uint32_t count, bool generate_mips, bool color);
/**
 * The same of one mip, `pixels`: mip after mip from 0 on, of compressed formats in rows of blocks. The last part of the last mip leaves the layout.
 * gpu_mip_rows() says how many rows a mip has.
 */
fnl_result gpu_upload_image_mip(gpu_device *device, const struct gpu_image *image, uint32_t mip, const void *pixels, uint64_t size, uint32_t first,
                                uint32_t count);
uint32_t gpu_mip_rows(const struct gpu_image *image, uint32_t mip);
/**
 * Makes a device buffer larger: its first `used` bytes are copied on the device, and the old memory goes when the frames under way are over.
 * `buffer` may have no handle; then it is created. On errors it stays what it was.
 */
fnl_result gpu_grow_buffer(gpu_device *device, enum gpu_use use, const char *name, struct gpu_buffer *buffer, uint64_t used, uint64_t size);
/** Hands uploads to the device: frames that are submitted later see them. */
fnl_result gpu_upload_submit(gpu_device *device);
/** Waits until all uploads are done and visible to later submissions. */
fnl_result gpu_upload_flush(gpu_device *device);
/** Copies a device buffer back; waits. For tests and one-off reads outside frames. */
fnl_result gpu_read_buffer(gpu_device *device, const struct gpu_buffer *buffer, uint64_t offset, void *data, uint64_t size);

/* ---- pipelines: made on first use and kept; all share one layout (bindless set 0, 128 bytes of push constants) ---- */

struct gpu_pipeline;
struct gpu_scope;

struct gpu_compute_params {
    const struct gpu_shader *shader;
    uint32_t constant_count; /* specialisation constants with ids 0 .. constant_count - 1, 4 bytes each */
    uint32_t constants[GPU_MAX_CONSTANTS];
};

enum gpu_blend {
    GPU_BLEND_NONE,
    GPU_BLEND_ALPHA, /* premultiplied: source + destination * (1 - source alpha) */
    GPU_BLEND_ADD,
    GPU_BLEND_MAX,     /* of each channel */
    GPU_BLEND_QUARTER, /* source + destination / 4 */
    GPU_BLEND_KEEP,    /* nothing is written */
};

/** Compares all bits of the stencil with a reference. Fragments that pass or fail change the stencil if its format is not read-only. */
struct gpu_stencil {
    uint32_t test; /* 1, or 0: none */
    VkCompareOp compare;
    VkStencilOp pass;
    uint32_t reference; /* or GPU_STENCIL_SET: what gpu_stencil_reference says */
    VkStencilOp fail;   /* default VK_STENCIL_OP_KEEP */
};
#define GPU_STENCIL_SET UINT32_MAX

struct gpu_graphics_params {
    const struct gpu_shader *vertex, *fragment; /* fragment NULL: depth only */
    const struct gpu_shader *geometry;          /* or NULL; needs fnl_device_info.primitive_ids */
    const struct gpu_shader *mesh;              /* in place of both, or NULL; needs fnl_device_info.mesh_shader */
    uint32_t features;                          /* specialisation constant GPU_FEATURES_ID of all stages */
    uint32_t constant_count;                    /* the same constants go to all stages */
    uint32_t constants[GPU_MAX_CONSTANTS];
    VkPrimitiveTopology topology;
    VkCullModeFlags cull; /* front faces are counter-clockwise as seen with +Y up. This and the next make no other pipeline in Vulkan: gpu_bind sets them */
    bool mirrored;        /* the other winding is the front */
    uint32_t color_count;
    VkFormat color_formats[GPU_MAX_COLORS];
    enum gpu_blend blends[GPU_MAX_COLORS];
    VkFormat depth_format; /* UNDEFINED: none; S8_UINT: a stencil and no depth; D32_SFLOAT_S8_UINT: both */
    struct gpu_stencil stencil;
    bool depth_test, depth_write, depth_clamp;
    bool conservative; /* rasterises every pixel that a primitive touches; needs fnl_device_info.conservative_raster */
    VkCompareOp depth_compare;
    uint32_t samples; /* 1, 2, 4, 8 */
    uint32_t view_mask; /* that of the rendering: each draw goes to these layers, and shaders know which by gl_ViewIndex; 0: one */
    const struct gpu_scope
        *scope; /* the pipeline draws in this step of a scope; NULL: between gpu_begin_rendering and its end */
    uint32_t scope_step;
};

/** NULL after a logged, sticky error. Hash lookups; no allocation when it exists. Thread-safe. Params must be zeroed before filling: they are hashed as bytes. */
const struct gpu_pipeline *gpu_compute_pipeline(gpu_device *device, const struct gpu_compute_params *params);
const struct gpu_pipeline *gpu_graphics_pipeline(gpu_device *device, const struct gpu_graphics_params *params);

struct gpu_commands;
/**
 * Asks for pipelines ahead of their use: until gpu_ask_end the functions above make nothing and return NULL; what is not there is made by
 * threads in the background, as many as the job pool has, unless a frame that needs it is faster. The commands, which record nothing, are for
 * code that asks by recording. On the thread that makes frames, while nothing is being recorded.
 */
struct gpu_commands *gpu_ask_begin(gpu_device *device);
/** A ticket: all that was asked for is there as soon as gpu_pipeline_stats().done is no less. 0: it is all there. */
uint64_t gpu_ask_end(gpu_device *device);
/** Waits until what the ticket stands for is there. */
void gpu_ask_wait(gpu_device *device, uint64_t ticket);

struct gpu_pipeline_stats {
    uint64_t asked, done; /* so many were put in line; so many, from the first on, are made. Equal when the background is at rest */
    uint64_t ahead, rehearsed; /* made in the background; and used there on a second device (rehearse.c) */
    uint64_t late;             /* that a frame needed and had to make or to wait for */
    uint64_t made, cached;     /* all that were made; and of these what the driver says that it found in the cache */
};
struct gpu_pipeline_stats gpu_pipeline_stats(gpu_device *device);

/* ---- commands ---- */

enum gpu_queue { GPU_QUEUE_GRAPHICS, GPU_QUEUE_COMPUTE };

/** A command buffer of the frame being made; each chunk is recorded by one thread at a time. */
struct gpu_commands *gpu_commands_begin(gpu_device *device, enum gpu_queue queue, uint32_t chunk);
void gpu_commands_end(struct gpu_commands *commands);
gpu_device *gpu_commands_device(struct gpu_commands *commands);

void gpu_bind(
    struct gpu_commands *commands,
    const struct gpu_pipeline *pipeline); /* also binds set 0 when needed; NULL: later draws and dispatches are skipped */
void gpu_push(struct gpu_commands *commands, const void *data, uint32_t size);
void gpu_dispatch(struct gpu_commands *commands, uint32_t x, uint32_t y, uint32_t z);
/** At least `groups` work groups, in two dimensions where one does not hold them: shaders number them by LINEAR_GROUP (common.glsl) and leave
    the surplus alone. */
void gpu_dispatch_linear(struct gpu_commands *commands, uint32_t groups);
void gpu_dispatch_indirect(struct gpu_commands *commands, const struct gpu_buffer *buffer, uint64_t offset);
void gpu_bind_indices(struct gpu_commands *commands, const struct gpu_buffer *buffer, uint64_t offset); /* 32-bit */
void gpu_draw(struct gpu_commands *commands, uint32_t vertex_count, uint32_t instance_count, uint32_t first_vertex,
              uint32_t first_instance);
/** `count` VkDrawIndexedIndirectCommand, tightly packed. */
void gpu_draw_indexed_indirect(struct gpu_commands *commands, const struct gpu_buffer *buffer, uint64_t offset,
                               uint32_t count);
/** The count is read from a buffer, at most `max_count`. */
void gpu_draw_indexed_indirect_count(struct gpu_commands *commands, const struct gpu_buffer *buffer, uint64_t offset,
                                     const struct gpu_buffer *count_buffer, uint64_t count_offset, uint32_t max_count);
/** With a pipeline that has a mesh shader: one VkDrawMeshTasksIndirectCommandEXT of at most 65535 x 64 work groups. */
void gpu_draw_mesh_indirect(struct gpu_commands *commands, const struct gpu_buffer *buffer, uint64_t offset);
void gpu_copy_buffer(struct gpu_commands *commands, const struct gpu_buffer *from, uint64_t from_offset,
                     const struct gpu_buffer *to, uint64_t to_offset, uint64_t size);
void gpu_fill_buffer(struct gpu_commands *commands, const struct gpu_buffer *buffer, uint64_t offset, uint64_t size,
                     uint32_t value);
/** Mip 0, the first layer, tightly packed rows. The image is in TRANSFER_SRC_OPTIMAL. */
void gpu_copy_image_to_buffer(struct gpu_commands *commands, const struct gpu_image *from, const struct gpu_buffer *to,
                              uint64_t offset);
/** All mips, each with all its layers, tightly packed one after the other, from the finest on. The image is in TRANSFER_DST_OPTIMAL. */
void gpu_copy_buffer_to_image(struct gpu_commands *commands, const struct gpu_buffer *from, uint64_t offset, const struct gpu_image *to);
/** A rectangle of the first layer to one of `layer`, mip 0. */
struct gpu_image_copy {
    uint32_t from_x, from_y, to_x, to_y, width, height, layer;
};
/** TRANSFER_SRC_OPTIMAL to TRANSFER_DST_OPTIMAL; formats of equal texel size. `copy` NULL: all of `from`, to the first layer of an image of its size. */
void gpu_copy_image(struct gpu_commands *commands, const struct gpu_image *from, const struct gpu_image *to, const struct gpu_image_copy *copy);

struct gpu_structure_build {
    struct gpu_structure_input input;
    const struct gpu_structure *to;
    bool update; /* vertices have moved since it was built; counts are those of then */
    uint64_t scratch; /* offset in the scratch buffer: the sum of the parts before */
};
/** Builds that do not wait for each other. */
void gpu_build_structures(struct gpu_commands *commands, const struct gpu_structure_build *builds, uint32_t count,
                          const struct gpu_buffer *scratch);
/** Query `first` and those that follow. */
void gpu_measure_structures(struct gpu_commands *commands, const struct gpu_structure_queries *queries, uint32_t first,
                            const struct gpu_structure *structures, uint32_t count);
/** Compacts `from` into `to`, which is of the size that was measured. */
void gpu_compact_structure(struct gpu_commands *commands, const struct gpu_structure *from, const struct gpu_structure *to);

struct gpu_attachment {
    const struct gpu_image *image;
    VkAttachmentLoadOp load;
    VkAttachmentStoreOp store;
    VkClearValue clear;
    bool read_only;                  /* depth: DEPTH_READ_ONLY layout */
    const struct gpu_image *resolve; /* multisampled colour averaged into it, or NULL */
};
struct gpu_rendering {
    uint32_t width, height, layers, color_count;
    struct gpu_attachment colors[GPU_MAX_COLORS];
    struct gpu_attachment depth; /* image NULL: none; of S8_UINT: the stencil; of D32_SFLOAT_S8_UINT: both */
    uint32_t view_mask; /* bits below fnl_device_info.max_views: draws go to each of these layers (multiview); 0: to layer 0, or to the one that vertex shaders choose */
};
/** Dynamic rendering; the viewport covers the whole area with +Y up (negative height). */
void gpu_begin_rendering(struct gpu_commands *commands, const struct gpu_rendering *rendering);
void gpu_end_rendering(struct gpu_commands *commands);
/** Inside of it: the draws that follow touch only these pixels, which lie in the area; x and y from its upper left corner. */
void gpu_scissor(struct gpu_commands *commands, uint32_t x, uint32_t y, uint32_t width, uint32_t height);
/** Inside of it. For the draws that follow with pipelines of GPU_STENCIL_SET, and once before the first of them. */
void gpu_stencil_reference(struct gpu_commands *commands, uint32_t reference);
/** Inside of it: the whole stencil of the area, in the order of the draws. */
void gpu_clear_stencil(struct gpu_commands *commands, uint32_t width, uint32_t height, uint32_t value);

/*
 * ---- scopes: several steps of drawing, one over the other, of which later ones read what earlier ones drew at the same pixel ----
 *
 * A Vulkan render pass with a subpass for each step: a tile-based GPU keeps all attachments on the chip from the first step to the
 * last and stores only those that ask for it. Every Vulkan 1.3 device has them. A step's fragment shader reads input `i` as
 * `layout(set = 1, binding = i, input_attachment_index = i) uniform subpassInput`.
 */
struct gpu_scope_step {
    uint32_t color_count, input_count;
    uint32_t colors[GPU_MAX_COLORS], inputs[GPU_MAX_INPUTS]; /* attachments; inputs may have gaps of GPU_NO_INDEX */
    uint32_t depth;                                          /* attachment or GPU_NO_INDEX */
    bool depth_read_only;
};
/** Zeroed before it is filled in: it is hashed as bytes. An attachment may be input and colour of one step: each pixel may then be
    drawn once, or gpu_scope_barrier stands between the draws. */
struct gpu_scope_params {
    uint32_t attachment_count, step_count;
    struct {
        VkFormat format;
        VkAttachmentLoadOp load;
        VkAttachmentStoreOp store;
    } attachments[GPU_MAX_SCOPE_ATTACHMENTS]; /* single-sampled; colour is COLOR_ATTACHMENT_OPTIMAL before and after, depth
                                                 DEPTH_ATTACHMENT_OPTIMAL */
    struct gpu_scope_step steps[GPU_MAX_SCOPE_STEPS];
};
/** Can the device have steps with so many colours and inputs? */
bool gpu_scope_supports(const gpu_device *device, uint32_t color_count, uint32_t input_count);
/** NULL after a logged, sticky error. Made on first use and kept. Thread-safe. */
const struct gpu_scope *gpu_scope_find(gpu_device *device, const struct gpu_scope_params *params);
/** Begins the first step, all attachments in their order; the viewport is as gpu_begin_rendering's. NULL scope: what follows is skipped. */
void gpu_begin_scope(struct gpu_commands *commands, const struct gpu_scope *scope, const struct gpu_image *const *images,
                     const VkClearValue *clears);
void gpu_next_step(struct gpu_commands *commands);
/** What earlier draws of this step wrote can be read as input by later ones; for steps that have an attachment as input and colour. */
void gpu_scope_barrier(struct gpu_commands *commands);
void gpu_end_scope(struct gpu_commands *commands);

/* For the frame graph. */
struct gpu_image_barrier {
    const struct gpu_image *image;
    VkPipelineStageFlags2 from_stages, to_stages;
    VkAccessFlags2 from_access, to_access;
    VkImageLayout from_layout, to_layout;
};
/** One vkCmdPipelineBarrier2: image barriers and one global memory barrier (when its stages are not 0). */
void gpu_barrier(struct gpu_commands *commands, const struct gpu_image_barrier *images, uint32_t image_count,
                 VkPipelineStageFlags2 from_stages, VkAccessFlags2 from_access, VkPipelineStageFlags2 to_stages,
                 VkAccessFlags2 to_access);
void gpu_begin_label(struct gpu_commands *commands, const char *name);
void gpu_end_label(struct gpu_commands *commands);
/** Writes timestamp `index` of the frame, below GPU_MAX_TIMESTAMPS. */
enum { GPU_MAX_TIMESTAMPS = 2048 };
void gpu_timestamp(struct gpu_commands *commands, uint32_t index);
/**
 * Around draws, inside of a rendering: counts how often vertex shaders run, where fnl_device_info.vertex_counts. Takes as many queries of the frame, from
 * `query` on, as the rendering's view mask has bits, one without; each once in a frame; all below GPU_MAX_VERTEX_COUNTS. Beyond, nothing is counted.
 */
enum { GPU_MAX_VERTEX_COUNTS = 256 };
void gpu_begin_vertex_count(struct gpu_commands *commands, uint32_t query, uint32_t views);
void gpu_end_vertex_count(struct gpu_commands *commands, uint32_t query, uint32_t views);

/*
 * ---- what a frame leaves for the next to wait for ----
 *
 * By handle of a buffer or image that outlives frames, for all who make frames of the device: what its last uses on the graphics queue
 * were. (What the compute queue did is over when a frame's last batch is.) Goes with the buffer or image.
 */
struct gpu_last_use {
    uint64_t handle; /* which an image and a buffer may have in common */
    bool is_image;
    VkPipelineStageFlags2 write_stages, visible_stages; /* of the last write, and what it was made visible to */
    VkAccessFlags2 write_access, visible_access;
    VkPipelineStageFlags2 read_stages; /* since then */
};
struct gpu_last_uses {
    pthread_mutex_t mutex;
    ARRAY(struct gpu_last_use) items;
};
struct gpu_last_uses *gpu_last_uses(gpu_device *device);
/**
 * Finds that of `use->handle`, or enters `use` as it is for one that is not known. False when memory ran out; what is entered can be
 * set without fail. Thread-safe, and so are the next two.
 */
bool gpu_last_use_find(struct gpu_last_uses *uses, const fnl_host *host, struct gpu_last_use *use);
/** Does nothing where the handle has gone meanwhile. */
void gpu_last_use_set(struct gpu_last_uses *uses, const struct gpu_last_use *use);
void gpu_last_use_remove(struct gpu_last_uses *uses, bool is_image, uint64_t handle);

/* ---- frames ---- */

/** Waits until the slot of this frame is free, then resets its pools. Deferred destruction happens here. */
fnl_result gpu_frame_begin(gpu_device *device);
/** 0 .. GPU_FRAMES_IN_FLIGHT - 1: which per-frame buffers may be written now. */
uint32_t gpu_frame_slot(const gpu_device *device);
/** Number of frames begun so far. */
uint64_t gpu_frame_number(const gpu_device *device);

struct gpu_batch {
    enum gpu_queue queue;
    struct gpu_commands *const *commands;
    uint32_t command_count;
    uint32_t wait_batch; /* an earlier batch on the other queue that this one waits for, or GPU_NO_INDEX */
};
struct gpu_external_semaphores {
    VkSemaphore wait, signal;
    uint64_t wait_value, signal_value;
};
/** Submits the batches in order and ends the frame. `external` may be NULL. The sticky error comes out here. */
fnl_result gpu_frame_end(gpu_device *device, const struct gpu_batch *batches, uint32_t batch_count,
                         const struct gpu_external_semaphores *external);
/** Waits for the frame with this number. */
fnl_result gpu_frame_wait(gpu_device *device, uint64_t frame_number);
/** Whether it is over. */
fnl_result gpu_frame_done(gpu_device *device, uint64_t frame_number, bool *out);
/** Timestamps of the last finished use of a slot, in nanoseconds from the earliest; false when the device has none or they were not written. */
bool gpu_frame_timestamps(gpu_device *device, uint32_t slot, uint32_t count, uint64_t *out);
/** Sum of `count` queries of gpu_begin_vertex_count; false when the device cannot count, the frame is not over, or another one has taken its slot since. */
bool gpu_frame_vertex_count(gpu_device *device, uint64_t frame_number, uint32_t first, uint32_t count, uint64_t *out);

/* ---- memory written by the CPU each frame ---- */

struct gpu_slice {
    void *data;
    VkDeviceAddress address;
    const struct gpu_buffer *buffer;
    uint64_t offset;
};
/** Takes mapped upload memory that lives until this frame is over; 256-byte aligned; grows by the frame after. data NULL after a sticky error. Thread-safe. */
struct gpu_slice gpu_frame_allocate(gpu_device *device, uint64_t size);

#endif
