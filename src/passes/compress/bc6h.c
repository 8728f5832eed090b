/* SPDX-License-Identifier: MIT */
#include "passes/compress/bc6h.h"

#include "passes/compress/bc6h_shared.h"
#include "shaders.h"

/* One dispatch a source, all in one pass. `parts` NULL: to `blocks`. */
static void add(struct graph *graph, gpu_device *device, const char *name, const struct bc6h_source *sources, const struct gpu_image *const *parts,
                uint32_t count, graph_buffer blocks, graph_image target, const struct bc6h_gpu_params *params) {
    const struct gpu_sampler_params nearest = {.wrap_u = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                               .wrap_v = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                               .anisotropy = 1};
    struct graph_pass *pass = NULL;
    uint32_t first = 0, sampler_index = gpu_sampler_index(device, &nearest);
    for (uint32_t i = 0; i < count; i++) {
        struct graph_image_params info = graph_image_info(graph, sources[i].image);
        const struct gpu_image *part = sources[i].part;
        struct gpu_bc6h_push push = {.first_block = first,
                                     .source = part ? part->sampled_index : GPU_NO_INDEX,
                                     .sampler_index = sampler_index,
                                     .target = parts ? parts[i]->storage_index : GPU_NO_INDEX,
                                     .width = part ? part->params.width : info.width,
                                     .height = part ? part->params.height : info.height};
        uint32_t across = DIVIDE_UP(push.width, 4u), down = DIVIDE_UP(push.height, 4u);
        pass = graph_dispatch(graph, &(struct graph_dispatch){.pass = pass,
                                                              .name = name,
                                                              .pipeline = {params->quality ? &shader_bc6h_quality_comp : &shader_bc6h_comp, 2,
                                                                           {params->is_signed, parts != NULL}},
                                                              .groups = {DIVIDE_UP(across, 8u), DIVIDE_UP(down, 8u), 1},
                                                              GRAPH_PUSH(push),
                                                              GRAPH_ROWS(graph_samples(part ? NULL : &push.source, sources[i].image),
                                                                         graph_row_if(!parts, graph_writes(&push.blocks, blocks)),
                                                                         graph_row_if(parts != NULL, graph_stores(NULL, target)))});
        first += across * down;
    }
}

graph_buffer bc6h_add(struct graph *graph, gpu_device *device, const char *name, const struct bc6h_source *sources, uint32_t count,
                      const struct bc6h_gpu_params *params) {
    uint64_t bytes = 0;
    for (uint32_t i = 0; i < count; i++) {
        struct graph_image_params info = graph_image_info(graph, sources[i].image);
        const struct gpu_image *part = sources[i].part;
        bytes += gpu_texels_bytes(VK_FORMAT_BC6H_UFLOAT_BLOCK, part ? part->params.width : info.width, part ? part->params.height : info.height);
    }
    graph_buffer blocks = graph_create_buffer(graph, graph_name(graph, "%s blocks", name), bytes);
    add(graph, device, name, sources, NULL, count, blocks, (graph_image){0}, params);
    return blocks;
}

void bc6h_store_add(struct graph *graph, gpu_device *device, const char *name, const struct bc6h_source *sources,
                    const struct gpu_image *const *parts, uint32_t count, graph_image target, const struct bc6h_gpu_params *params) {
    add(graph, device, name, sources, parts, count, (graph_buffer){0}, target, params);
}

struct copy_data {
    graph_buffer blocks;
    graph_image target;
};

static void execute_copy(const struct graph_context *context, const void *data) {
    const struct copy_data *d = data;
    gpu_copy_buffer_to_image(context->commands, graph_get_buffer(context, d->blocks), 0, graph_get_image(context, d->target));
}

void bc6h_copy_add(struct graph *graph, const char *name, graph_buffer blocks, graph_image target) {
    struct copy_data data = {blocks, target};
    struct graph_pass *pass = graph_add_pass(graph, name, GRAPH_QUEUE_GRAPHICS, execute_copy, &data, sizeof data);
    graph_use_buffer(pass, blocks, GRAPH_COPY_FROM);
    graph_use_image(pass, target, GRAPH_COPY_TO);
}
