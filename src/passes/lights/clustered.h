/* SPDX-License-Identifier: MIT */
/** The cluster grid, and the builder that fills it on the CPU. */
#ifndef FNL_PASSES_CLUSTERED_H
#define FNL_PASSES_CLUSTERED_H

#include "base/jobs.h"
#include "base/maths.h"
#include "passes/lights/light_list.h"

/** Fills in tile size, grid and slice mapping of a header. */
void clustered_grid(struct gpu_light_list *header, uint32_t width, uint32_t height, const struct clustered_params *params);

struct clustered_cpu_sphere {
    vec3 center;
    float radius;
}; /* view space; radius <= 0: reaches nothing */

/** The view as the CPU builder needs it: gpu_view's ndc_scale, ndc_offset and orthographic, and the picture's size. */
struct clustered_cpu_view {
    vec2 ndc_scale, ndc_offset;
    bool orthographic;
    uint32_t width, height;
};

/**
 * Memory of the CPU builder, kept from frame to frame. After clustered_cpu_build `cells` and `ids` hold the lists, ascending, and
 * `entry_count` their exact number.
 */
struct clustered_cpu {
    const fnl_host *host;
    ARRAY(struct gpu_cell) cells;
    ARRAY(uint32_t) ids;
    ARRAY(struct clustered_cpu_sphere) spheres;
    uint32_t capacity; /* entries that may be stored; cells beyond use all lights; 2^26 */
    uint32_t overflow_cells;
    uint64_t entry_count;
    uint32_t in_view;
};

void clustered_cpu_init(struct clustered_cpu *builder, const fnl_host *host);
void clustered_cpu_finish(struct clustered_cpu *builder);
/**
 * Assigns `spheres` to the clusters of `header` by voxelising them: per slice and per row the sphere shrinks onto the plane that
 * faces its centre (Persson 2013). One job per slice; the lists do not depend on the number of threads. Conservative.
 */
fnl_result clustered_cpu_build(struct clustered_cpu *builder, struct jobs *jobs, const struct gpu_light_list *header,
                               const struct clustered_cpu_view *view);

/** Builds on the CPU and uploads cells and ids with the frame. `bounds` are those of `input`. */
struct light_list clustered_cpu_add(struct clustered_cpu *builder, gpu_device *device, const struct light_input *input,
                                    const struct gpu_entity_bounds *bounds, const mat4 *world_to_view,
                                    const struct clustered_cpu_view *view, const struct clustered_params *params);

#endif
