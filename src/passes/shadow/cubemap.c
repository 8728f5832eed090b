/* SPDX-License-Identifier: MIT */
#include "passes/shadow/cubemap.h"

#include "passes/shadow/cubemap_push_shared.h"
#include "passes/shadow/rays.h"
#include "shaders.h"

void probes_use(struct graph_pass *pass, const struct probes *probes, enum graph_use use) {
    for (uint32_t i = 0; i < probes->count; i++)
        graph_use_image(pass, probes->images[i], use == GRAPH_READ_COMPUTE ? GRAPH_SAMPLE_COMPUTE : GRAPH_SAMPLE_FRAGMENT);
}

uint32_t cubemap_levels(uint32_t side) {
    uint32_t levels = 1;
    while (side >> levels) levels++;
    return levels;
}

/* Texels of all levels before this one. */
static uint32_t words_before(uint32_t side, uint32_t level) {
    uint32_t words = 0;
    for (uint32_t i = 0; i < level; i++) words += 6 * (side >> i) * (side >> i);
    return words;
}

/* The same for compressed levels: four words per block. */
static uint32_t block_words_before(uint32_t side, uint32_t level) {
    uint32_t words = 0;
    for (uint32_t i = 0; i < level; i++) words += 4 * 6 * DIVIDE_UP(side >> i, 4u) * DIVIDE_UP(side >> i, 4u);
    return words;
}

uint64_t cubemap_bytes(uint32_t side, bool compressed) {
    const uint32_t levels = cubemap_levels(side);
    return 4ull * (compressed ? block_words_before(side, levels) : words_before(side, levels));
}

fnl_result cubemap_create(gpu_device *device, uint32_t side, bool compressed, struct gpu_image *out) {
    return gpu_image_create(device,
                            &(struct gpu_image_params){.name = "probe",
                                                       .format = compressed ? VK_FORMAT_BC3_UNORM_BLOCK : VK_FORMAT_R8G8B8A8_UNORM,
                                                       .width = side,
                                                       .height = side,
                                                       .layers = 6,
                                                       .mips = cubemap_levels(side),
                                                       .samples = 1,
                                                       .cube = true,
                                                       .use = GPU_USE_SHADOWS,
                                                       .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT},
                            out);
}

struct copy_data {
    graph_buffer texels, kept;
    graph_image image;
    uint64_t bytes;
};

static void execute_copy(const struct graph_context *context, const void *data) {
    const struct copy_data *d = data;
    const struct gpu_buffer *texels = graph_get_buffer(context, d->texels);
    gpu_copy_buffer_to_image(context->commands, texels, 0, graph_get_image(context, d->image));
    if (d->kept.id) gpu_copy_buffer(context->commands, texels, 0, graph_get_buffer(context, d->kept), 0, d->bytes);
}

static graph_buffer add_blocks(struct graph *graph, uint32_t probe, uint32_t side, graph_buffer texels) {
    graph_buffer blocks = graph_create_buffer(graph, graph_name(graph, "probe %u blocks", probe), cubemap_bytes(side, true));
    struct graph_pass *pass = NULL;
    for (uint32_t level = 0; level < cubemap_levels(side); level++) {
        struct gpu_cubemap_push push = {.from = words_before(side, level), .to = block_words_before(side, level), .side = side >> level};
        const uint32_t across = DIVIDE_UP(push.side, 4u);
        pass = graph_dispatch(graph, &(struct graph_dispatch){.pass = pass,
                                                              .name = graph_name(graph, "probe %u compress", probe),
                                                              .pipeline = {.shader = &shader_cubemap_compress_comp},
                                                              .groups = {DIVIDE_UP(6 * across * across, 64u)},
                                                              GRAPH_PUSH(push),
                                                              GRAPH_ROWS(graph_reads(&push.texels, texels), graph_writes(&push.blocks, blocks))});
    }
    return blocks;
}

void cubemap_bake_add(struct graph *graph, const struct rays *rays, VkDeviceAddress probes, uint32_t probe, graph_image image,
                      const struct gpu_buffer *kept) {
    const struct graph_image_params info = graph_image_info(graph, image);
    const uint32_t side = info.width;
    const bool compressed = info.format == VK_FORMAT_BC3_UNORM_BLOCK;
    struct copy_data copy = {.texels = graph_create_buffer(graph, graph_name(graph, "probe %u texels", probe), cubemap_bytes(side, false)),
                             .image = image,
                             .bytes = cubemap_bytes(side, compressed)};
    for (uint32_t level = 0; level < cubemap_levels(side); level++) {
        struct gpu_cubemap_push push = {.rays = rays->address,
                                        .probes = probes,
                                        .probe = probe,
                                        .from = words_before(side, level ? level - 1 : 0),
                                        .to = words_before(side, level),
                                        .side = side >> level};
        const uint32_t groups = DIVIDE_UP(6 * push.side * push.side, 64u);
        struct graph_pass *pass =
            graph_dispatch(graph, &(struct graph_dispatch){.name = level ? graph_name(graph, "probe %u mip %u", probe, level) : graph_name(graph, "probe %u bake", probe),
                                                           .pipeline = {.shader = level ? &shader_cubemap_mip_comp : &shader_cubemap_bake_comp},
                                                           .groups = {groups},
                                                           GRAPH_PUSH(push),
                                                           GRAPH_ROWS(level ? graph_changes(&push.texels, copy.texels)
                                                                            : graph_writes(&push.texels, copy.texels))});
        if (level == 0) rays_use(pass, rays, GRAPH_READ_COMPUTE);
    }
    if (compressed) copy.texels = add_blocks(graph, probe, side, copy.texels);
    if (kept) copy.kept = graph_import_buffer(graph, "probe texels kept", kept);
    struct graph_pass *pass =
        graph_add_pass(graph, graph_name(graph, "probe %u copy", probe), GRAPH_QUEUE_GRAPHICS, execute_copy, &copy, sizeof copy);
    if (kept) graph_use_buffer(pass, copy.kept, GRAPH_COPY_TO);
    graph_use_buffer(pass, copy.texels, GRAPH_COPY_FROM);
    graph_use_image(pass, image, GRAPH_COPY_TO);
    if (!kept) return;
    pass = graph_add_pass(graph, graph_name(graph, "probe %u to host", probe), GRAPH_QUEUE_GRAPHICS, NULL, NULL, 0);
    graph_keep(pass);
    graph_use_buffer(pass, copy.kept, GRAPH_READ_HOST);
}
