/* SPDX-License-Identifier: MIT */
/** A Vulkan device to render with. */
#ifndef FANAL_DEVICE_H
#define FANAL_DEVICE_H

#include "fanal/base.h"
#include "fanal/values.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct fnl_device fnl_device;

typedef struct fnl_device_params {
    fnl_host host; /**< memory, log and jobs for everything made with this device; default all built in */
    int32_t index; /**< as `fanal devices` numbers them; -1 (default) picks the best: discrete, integrated, virtual, CPU */
    const char *name; /**< part of a device name, case-insensitive; used when index is -1; NULL (default): any */
    bool validate;    /**< Vulkan validation and synchronisation validation; messages go to the log; default false */
    /**
     * Folder in which pipelines, the choices of `auto` and the maps of environments are kept between runs; NULL (default): $XDG_CACHE_HOME/fanal or
     * ~/.cache/fanal; "": none. Of environments those used last stay, 256 MiB at most. Files that are broken or of another driver are made anew.
     */
    const char *cache_folder;
    /** For windows (fnl_swapchain_create in fanal/vulkan.h): switches on the kinds of surfaces that the machine has, and swapchains. FNL_ERROR_UNSUPPORTED
        where there are none. Default false. */
    bool presentation;
} fnl_device_params;

FNL_API fnl_device_params fnl_device_params_default(void);

/** Creates a device; `params` may be NULL. FNL_ERROR_DEVICE if none can be used; the log gives the reason for each. */
FNL_API fnl_result fnl_device_create(const fnl_device_params *params, fnl_device **out);
/** Waits for its work, and for a pipeline that is being compiled in the background. Renderers of the device must be destroyed first. */
FNL_API void fnl_device_destroy(fnl_device **device);

typedef enum fnl_device_type {
    FNL_DEVICE_DISCRETE = 0,
    FNL_DEVICE_INTEGRATED,
    FNL_DEVICE_VIRTUAL,
    FNL_DEVICE_CPU,
    FNL_DEVICE_OTHER
} fnl_device_type;

typedef struct fnl_device_info {
    char name[256], driver[256];
    fnl_device_type type;
    uint32_t api_version_major, api_version_minor;
    bool usable;           /**< has all that Fanal needs */
    char missing[512];     /**< what it lacks, comma-separated; empty when usable */
    uint64_t memory_bytes; /**< largest device-local heap */
    uint32_t msaa_counts;  /**< sample counts that work for colour and depth, as bits: 1, 2, 4, 8 */
    uint32_t max_msaa;     /**< highest sample count for colour and depth */
    bool async_compute;    /**< has a second queue that can compute */
    /* Optional features; `fanal devices` says what uses each. */
    bool timestamps, ray_query, mesh_shader, conservative_raster, barycentrics, sample_locations, fragment_shading_rate, multiview;
    bool primitive_ids;       /**< fragment shaders know the number of their triangle */
    bool minmax_samplers;     /**< samplers can return the minimum and the maximum of four texels */
    bool post_depth_coverage; /**< fragment shaders know which samples pass the depth test */
    bool vertex_layers;       /**< vertex shaders can choose the layer that they draw into */
    bool vertex_counts;       /**< counts how often vertex shaders run */
    bool clip_distances;      /**< vertex shaders can cut triangles off along planes */
    bool quad_operations;     /**< fragment shaders can share values within 2x2 squares of pixels */
    bool texture_compression; /**< samples pictures that are compressed in blocks (BC1 to BC7) */
    uint32_t subgroup_size;
    uint32_t max_views; /**< how many views one draw call can go to: 6 or more with multiview, else 1 */
} fnl_device_info;

FNL_API fnl_result fnl_device_query_info(const fnl_device *device, fnl_device_info *out);
/** Describes at most `capacity` Vulkan devices of this machine and counts all of them: 0 without a Vulkan loader. `host` may be NULL. */
FNL_API fnl_result fnl_enumerate_devices(const fnl_host *host, fnl_device_info *out, uint32_t capacity, uint32_t *out_count);

/** Number of validation messages (warnings and errors) so far; 0 without validation. */
FNL_API uint64_t fnl_device_validation_count(const fnl_device *device);

#ifdef __cplusplus
}
#endif
#endif
