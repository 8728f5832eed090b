/* SPDX-License-Identifier: MIT */
/**
 * Clusters filled by conservative rasterisation of light meshes (K. Ortegren & E. Persson, "Clustered Shading: Assigning Lights Using
 * Conservative Rasterization in DirectX 12", GPU Pro 7). Each light is drawn as a low mesh that encloses it onto the grid of tiles; its
 * shell, the nearest and farthest slice in each tile, is then filled with entries. The shell of a sphere is computed without a mesh, exactly.
 *
 * Cost: a thread for each light in view, a group for each that covers more than one tile (of spheres the tiles of their rectangle, of meshes
 * triangles times the tiles each covers), and tiles times lights in view tests of rectangles, twice. Work grows with the number of lights, not with lights times clusters.
 */
#ifndef FNL_PASSES_RASTER_H
#define FNL_PASSES_RASTER_H

#include "passes/lights/light_list.h"
#include "passes/lights/raster_shared.h"

enum raster_path {
    RASTER_PATH_AUTO,     /* hardware where there is conservative rasterisation */
    RASTER_PATH_HARDWARE, /* draws; falls back to compute where the device cannot, unless `centers` allows plain rasterisation */
    RASTER_PATH_SOFTWARE, /* compute */
};

struct raster_params {
    struct clustered_params grid; /* pool_capacity counts entries of arrays or nodes of linked lists */
    enum raster_path path;        /* default auto */
    uint32_t nodes; /* GPU_NODES_…; default array. 32-bit nodes become 64-bit ones where their limits are passed */
    uint32_t
        slot_capacity; /* (tile, light) pairs that shells may take; default 2^18. A light whose shell does not fit counts as if it
                                     filled the box of its tiles and slices */
    bool
        gradient; /* slices of a triangle in a tile by its plane, not by what it covers (ES-61); software path; default false */
    bool centers; /* for comparison: rasterise by the middles of tiles, which misses lights; hardware path; default false */
    float near;   /* metres; no surface is nearer */
    VkDeviceAddress meshes, points; /* meshes of single lights (struct gpu_raster_mesh[local_count], vec3[]), or 0 */
};
struct raster_params raster_params_default(void);

/** What the list takes, in bytes: digest, 2.1 and section 4. */
struct raster_memory {
    uint64_t offsets, list, shells;
};
struct raster_memory raster_memory(const struct raster_params *params, uint32_t width, uint32_t height,
                                   uint32_t light_count);

/** Whether light meshes will be drawn. */
bool raster_on_hardware(const gpu_device *device, const struct raster_params *params);
/** The node layout that will be used. */
uint32_t raster_nodes(const struct raster_params *params, uint32_t light_count);

struct raster_list {
    struct light_list list; /* of GPU_LIST_CLUSTERS or GPU_LIST_LINKS */
    graph_buffer slots, slot_sums, rectangles;
    uint64_t slot_total_offset; /* in slot_sums: the number of slots that this frame wants */
};
struct raster_list raster_add(struct graph *graph, gpu_device *device, const struct light_input *input,
                              const struct lights_in_view *in_view, const struct raster_params *params);

/** Slots, kept large enough from frame to frame: what a frame wanted is known when its turn in flight comes again. */
struct raster_state {
    struct gpu_buffer wanted[GPU_FRAMES_IN_FLIGHT];
    uint32_t slot_capacity;
    bool warned, warned_path; /* about 32-bit nodes, about hardware */
};
void raster_state_finish(struct raster_state *state, gpu_device *device);
/** raster_add with slots by the state. */
struct light_list raster_add_kept(struct raster_state *state, struct graph *graph, gpu_device *device,
                                  const struct light_input *input, const struct lights_in_view *in_view,
                                  struct raster_params *params);

#endif
