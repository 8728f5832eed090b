/* SPDX-License-Identifier: MIT */
#include "passes/shadow/ray_query.h"

#include "passes/shadow/rays.h"
#include "passes/shadow/rays_build_shared.h"
#include "shaders.h"

_Static_assert(sizeof(struct gpu_ray_instance) == sizeof(VkAccelerationStructureInstanceKHR) &&
                   offsetof(struct gpu_ray_instance, rows) == offsetof(VkAccelerationStructureInstanceKHR, transform) &&
                   offsetof(struct gpu_ray_instance, index_and_mask) == sizeof(VkTransformMatrixKHR) &&
                   offsetof(struct gpu_ray_instance, offset_and_flags) == sizeof(VkTransformMatrixKHR) + 4 &&
                   offsetof(struct gpu_ray_instance, structure) == offsetof(VkAccelerationStructureInstanceKHR, accelerationStructureReference),
               "instances are laid out as Vulkan wants them");

enum { SCRATCH_BYTES = 32 << 20 }; /* what builds go on at once, unless a single one needs more */

uint64_t ray_query_instance_bytes(uint32_t item_count) { return MAX(item_count, 1u) * (uint64_t)sizeof(struct gpu_ray_instance); }

struct build_data {
    const struct gpu_structure_build *builds;
    uint32_t count;
    graph_buffer scratch;
};

static void execute_build(const struct graph_context *context, const void *data) {
    const struct build_data *d = data;
    gpu_build_structures(context->commands, d->builds, d->count, graph_get_buffer(context, d->scratch));
}

/* The builds that go on at once, from the first on: as many as find room for scratch. Gives them their offsets. */
static uint32_t fit(struct gpu_structure_build *builds, uint32_t count, uint64_t *out_bytes) {
    uint64_t bytes = 0;
    uint32_t fitting = 0;
    for (; fitting < count && (fitting == 0 || bytes + builds[fitting].scratch <= SCRATCH_BYTES); fitting++) {
        const uint64_t needed = builds[fitting].scratch;
        builds[fitting].scratch = bytes;
        bytes += needed;
    }
    *out_bytes = bytes;
    return fitting;
}

static void add_bottoms(struct graph *graph, gpu_device *device, const struct ray_query_input *in, graph_buffer vertices, graph_buffer bottoms) {
    for (uint32_t first = 0, number = 0; first < in->build_count; number++) {
        uint64_t bytes;
        struct build_data data = {.builds = in->builds + first, .count = fit(in->builds + first, in->build_count - first, &bytes)};
        data.scratch = graph_create_buffer(graph, graph_numbered_name(graph, "ray scratch", number), bytes + gpu_scratch_padding(device));
        struct graph_pass *pass = graph_add_pass(graph, graph_numbered_name(graph, "ray structures", number), GRAPH_QUEUE_GRAPHICS, execute_build,
                                                 &data, sizeof data);
        graph_use_buffer(pass, vertices, GRAPH_BUILD_INPUT);
        graph_use_buffer(pass, data.scratch, GRAPH_BUILD_SCRATCH);
        graph_use_buffer(pass, bottoms, GRAPH_BUILD);
        first += data.count;
    }
}

struct move_data {
    struct ray_query_input in;
};

static void execute_copies(const struct graph_context *context, const void *data) {
    const struct move_data *d = data;
    for (uint32_t i = 0; i < d->in.copy_count; i++) gpu_compact_structure(context->commands, &d->in.copies[i].from, &d->in.copies[i].to);
}

static void execute_measure(const struct graph_context *context, const void *data) {
    const struct move_data *d = data;
    gpu_measure_structures(context->commands, d->in.queries, 0, d->in.measured, d->in.measured_count);
}

struct top_data {
    struct gpu_structure_build build;
    struct gpu_structure top;
    graph_buffer scratch;
};

static void execute_top(const struct graph_context *context, const void *data) {
    const struct top_data *d = data;
    struct gpu_structure_build build = d->build;
    build.to = &d->top;
    gpu_build_structures(context->commands, &build, 1, graph_get_buffer(context, d->scratch));
}

static void add_top(struct graph *graph, gpu_device *device, const struct rays_input *input, VkDeviceAddress placed, const struct rays *rays) {
    const struct ray_query_input *in = input->query;
    graph_buffer instances = graph_import_buffer(graph, "ray instances", in->instances);
    struct gpu_ray_instances_push push = {.scene = input->scene, .placed = placed, .structures = in->structures, .item_count = input->item_count};
    graph_dispatch(graph, &(struct graph_dispatch){.name = "ray instances",
                                                   .pipeline = {.shader = &shader_rays_instances_comp},
                                                   .groups = {DIVIDE_UP(input->item_count, 64u)},
                                                   GRAPH_PUSH(push),
                                                   GRAPH_ROWS(graph_reads(NULL, input->vertices), graph_changes(NULL, rays->items),
                                                              graph_writes(&push.instances, instances))});
    const struct top_data data = {
        .build = {.input = {.count = input->item_count, .instances = in->instances->address, .of_instances = true}},
        .top = *in->top,
        .scratch = graph_create_buffer(graph, "ray top scratch", in->top_scratch + gpu_scratch_padding(device))};
    struct graph_pass *pass = graph_add_pass(graph, "ray top", GRAPH_QUEUE_GRAPHICS, execute_top, &data, sizeof data);
    graph_use_buffer(pass, instances, GRAPH_BUILD_INPUT);
    graph_use_buffer(pass, data.scratch, GRAPH_BUILD_SCRATCH);
    graph_use_buffer(pass, rays->bottoms, GRAPH_BUILD_READ);
    graph_use_buffer(pass, rays->top, GRAPH_BUILD);
}

void ray_query_add(struct graph *graph, gpu_device *device, const struct rays_input *input, VkDeviceAddress placed, struct rays *rays) {
    const struct ray_query_input *in = input->query;
    rays->bottoms = graph_import_buffer(graph, "ray structures", in->bottoms);
    rays->top = graph_import_buffer(graph, "ray top", &in->top->buffer);
    const struct move_data move = {*in};
    if (in->build_count > 0) add_bottoms(graph, device, in, input->vertices, rays->bottoms);
    if (in->copy_count > 0)
        graph_use_buffer(graph_add_pass(graph, "ray compaction", GRAPH_QUEUE_GRAPHICS, execute_copies, &move, sizeof move), rays->bottoms, GRAPH_BUILD);
    if (in->measured_count > 0)
        graph_use_buffer(graph_add_pass(graph, "ray sizes", GRAPH_QUEUE_GRAPHICS, execute_measure, &move, sizeof move), rays->bottoms, GRAPH_BUILD);
    if (in->place) add_top(graph, device, input, placed, rays);
}
