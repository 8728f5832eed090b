/* SPDX-License-Identifier: MIT */
#include "passes/texturing/virtual.h"

#include "passes/geometry/geometry.h"
#include "passes/texturing/virtual_view_shared.h"
#include "scene_shared.h"
#include "shaders.h"

_Static_assert(VIRTUAL_PAGE == VIRTUAL_INNER + 2 * VIRTUAL_BORDER, "a page is what it shows and its border");

/* ---- what is kept ---- */

void virtual_destroy(gpu_device *device, struct virtual_atlas *atlas) {
    struct gpu_buffer *buffers[] = {&atlas->materials, &atlas->pages,  &atlas->table,   &atlas->owners,
                                    &atlas->wanted,    &atlas->places, &atlas->commands};
    for (uint32_t i = 0; i < COUNT_OF(buffers); i++) gpu_buffer_destroy(device, buffers[i]);
    for (uint32_t i = 0; i < VIRTUAL_LAYERS; i++)
        if (atlas->layers[i].handle) gpu_image_destroy(device, &atlas->layers[i]);
    *atlas = (struct virtual_atlas){.version = UINT64_MAX};
}

static fnl_result clear_buffer(gpu_device *device, const struct gpu_buffer *buffer) {
    static const uint32_t zeros[4096];
    for (uint64_t at = 0; at < buffer->size; at += sizeof zeros)
        TRY(gpu_upload_buffer(device, buffer, at, zeros, MIN(buffer->size - at, sizeof zeros)));
    return FNL_OK;
}

static fnl_result make_buffer(gpu_device *device, const char *name, const void *data, uint64_t size,
                              struct gpu_buffer *out) {
    TRY(gpu_buffer_create_for(device, GPU_USE_TEXTURES, name, size, GPU_MEMORY_DEVICE, out));
    return data ? gpu_upload_buffer(device, out, 0, data, size) : clear_buffer(device, out);
}

/* What the last frame wanted is still wanted. */
fnl_result virtual_empty(gpu_device *device, const struct virtual_atlas *atlas) {
    TRY(clear_buffer(device, &atlas->table));
    TRY(clear_buffer(device, &atlas->owners));
    return gpu_upload_submit(device);
}

/* Pages along the side: as many as the scene needs and may have. */
static uint32_t choose_across(gpu_device *device, const struct virtual_contents *contents, uint32_t layer_count) {
    uint32_t across = 1, most = MAX(contents->side / VIRTUAL_PAGE, 1u);
    while (across < most && across * across < contents->page_count) across++;
    uint64_t texels = VIRTUAL_PAGE * VIRTUAL_PAGE * 3 / 2 * 4ull * layer_count; /* bytes of a page */
    while (across > 1 && (uint64_t)across * across * texels > gpu_info(device)->memory_bytes / 4) across--;
    return across;
}

static fnl_result create_all(gpu_device *device, const struct virtual_contents *contents, struct virtual_atlas *atlas) {
    static const char *const names[VIRTUAL_LAYERS] = {"atlas base color", "atlas normal", "atlas params", "atlas emissive",
                                                      "atlas specular"};
    uint32_t layer_count = 0;
    for (uint32_t i = 0; i < VIRTUAL_LAYERS; i++) layer_count += contents->layers >> i & 1;
    uint32_t across = atlas->across = choose_across(device, contents, layer_count);
    if (contents->always > across * across) {
        log_error(gpu_host(device), "%u materials need a page each, and an atlas of %ux%u texels has %u", contents->always,
                  across * VIRTUAL_PAGE, across * VIRTUAL_PAGE, across * across);
        return FNL_ERROR_UNSUPPORTED;
    }
    uint64_t pages = contents->page_count * 4ull, places = (uint64_t)across * across * 4;
    TRY(make_buffer(device, "virtual materials", contents->materials, contents->material_count * sizeof *contents->materials,
                    &atlas->materials));
    TRY(make_buffer(device, "virtual pages", contents->pages, contents->page_count * sizeof *contents->pages,
                    &atlas->pages));
    TRY(make_buffer(device, "virtual table", NULL, pages, &atlas->table));
    TRY(make_buffer(device, "virtual wanted", NULL, pages, &atlas->wanted));
    TRY(make_buffer(device, "virtual owners", NULL, places, &atlas->owners));
    TRY(make_buffer(device, "virtual places", NULL, places, &atlas->places));
    TRY(make_buffer(device, "virtual commands", NULL, 16 + sizeof(struct gpu_virtual_counts), &atlas->commands));
    for (uint32_t i = 0; i < VIRTUAL_LAYERS; i++) {
        if (!(contents->layers >> i & 1)) continue;
        struct gpu_image_params params = {.name = names[i],
                                          .format = VK_FORMAT_R8G8B8A8_UNORM,
                                          .width = across * VIRTUAL_PAGE * 3 / 2,
                                          .height = across * VIRTUAL_PAGE,
                                          .layers = 1,
                                          .mips = 1,
                                          .samples = 1,
                                          .use = GPU_USE_TEXTURES,
                                          .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_STORAGE_BIT};
        TRY(gpu_image_create(device, &params, &atlas->layers[i]));
        atlas->bytes += 4ull * params.width * params.height;
    }
    return gpu_upload_flush(device);
}

fnl_result virtual_create(gpu_device *device, const struct virtual_contents *contents, struct virtual_atlas *out) {
    *out = (struct virtual_atlas){.page_count = contents->page_count,
                                  .always = contents->always,
                                  .fresh = true,
                                  .version = UINT64_MAX,
                                  .asked = contents->side};
    fnl_result result = create_all(device, contents, out);
    if (result != FNL_OK) virtual_destroy(device, out);
    return result;
}

/* ---- a frame ---- */

struct virtual_frame virtual_begin(struct graph *graph, gpu_device *device, const struct virtual_atlas *atlas,
                                   VkDeviceAddress scene_materials) {
    struct virtual_frame frame = {.table = graph_import_buffer(graph, "virtual table", &atlas->table),
                                  .owners = graph_import_buffer(graph, "virtual owners", &atlas->owners),
                                  .wanted = graph_import_buffer(graph, "virtual wanted", &atlas->wanted),
                                  .places = graph_import_buffer(graph, "virtual places", &atlas->places),
                                  .commands = graph_import_buffer(graph, "virtual commands", &atlas->commands)};
    struct gpu_sampler_params sampler = {.mag = VK_FILTER_LINEAR,
                                         .min = VK_FILTER_LINEAR,
                                         .mip = VK_SAMPLER_MIPMAP_MODE_NEAREST,
                                         .wrap_u = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                         .wrap_v = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                         .anisotropy = 1};
    struct gpu_virtual all = {.materials = atlas->materials.address,
                              .pages = atlas->pages.address,
                              .table = atlas->table.address,
                              .owners = atlas->owners.address,
                              .wanted = atlas->wanted.address,
                              .places = atlas->places.address,
                              .commands = atlas->commands.address,
                              .scene_materials = scene_materials,
                              .page_count = atlas->page_count,
                              .always = atlas->always,
                              .capacity = atlas->across * atlas->across,
                              .across = atlas->across,
                              .sampler_index = gpu_sampler_index(device, &sampler)};
    for (uint32_t i = 0; i < VIRTUAL_LAYERS; i++) {
        all.sampled[i] = all.storage[i] = GPU_TEXTURE_NONE;
        if (!atlas->layers[i].handle) continue;
        VkImageLayout layout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
        frame.layers[i] =
            graph_import_image(graph, &atlas->layers[i], atlas->fresh ? VK_IMAGE_LAYOUT_UNDEFINED : layout, layout);
        all.sampled[i] = atlas->layers[i].sampled_index;
        all.storage[i] = atlas->layers[i].storage_index;
    }
    struct gpu_slice slice = gpu_frame_allocate(device, sizeof all);
    if (!slice.data) return frame;
    memcpy(slice.data, &all, sizeof all);
    frame.address = slice.address;
    return frame;
}

static void add_layers(struct graph_pass *pass, const struct virtual_frame *frame, enum graph_use use) {
    for (uint32_t i = 0; i < VIRTUAL_LAYERS; i++)
        if (frame->layers[i].id) graph_use_image(pass, frame->layers[i], use);
}

/* All resources are in the block: rows have no members. */
void virtual_update_add(struct graph *graph, const struct virtual_frame *frame) {
    struct gpu_virtual_push push = {.pages = frame->address};
    graph_dispatch(graph, &(struct graph_dispatch){
                              .name = "texturing pages",
                              .pipeline = {.shader = &shader_virtual_pages_comp},
                              .groups = {1},
                              GRAPH_PUSH(push),
                              GRAPH_ROWS(graph_changes(NULL, frame->table), graph_changes(NULL, frame->owners),
                                         graph_changes(NULL, frame->wanted), graph_changes(NULL, frame->places),
                                         graph_writes(NULL, frame->commands))});
    struct graph_pass *pass =
        graph_dispatch(graph, &(struct graph_dispatch){
                                  .name = "texturing fill",
                                  .pipeline = {.shader = &shader_virtual_fill_comp},
                                  .indirect = frame->commands,
                                  GRAPH_PUSH(push),
                                  GRAPH_ROWS(graph_reads(NULL, frame->owners), graph_reads(NULL, frame->places))});
    add_layers(pass, frame, GRAPH_WRITE_COMPUTE);
}

void virtual_use_locate(struct graph_pass *pass, const struct virtual_frame *frame) {
    graph_use_buffer(pass, frame->table, GRAPH_READ_FRAGMENT);
    graph_use_buffer(pass, frame->wanted, GRAPH_WRITE_FRAGMENT);
}

void virtual_use_sample(struct graph_pass *pass, const struct virtual_frame *frame) {
    graph_use_buffer(pass, frame->owners, GRAPH_READ_COMPUTE);
    add_layers(pass, frame, GRAPH_SAMPLE_COMPUTE);
}

/* ---- debug views ---- */

void virtual_view_add(struct graph *graph, const struct virtual_frame *frame, uint32_t mode, graph_image uv,
                      graph_image depth, VkDeviceAddress view, graph_image target, bool swap) {
    const struct graph_image_params image = graph_image_info(graph, target);
    const bool pages = mode == VIRTUAL_VIEW_PAGES;
    struct gpu_virtual_view_push push = {.view = view,
                                         .pages = frame->address,
                                         .uv = GPU_TEXTURE_NONE,
                                         .depth = GPU_TEXTURE_NONE,
                                         .swap = swap,
                                         .mode = mode};
    struct graph_pass *pass = graph_dispatch(
        graph, &(struct graph_dispatch){.name = "texturing view",
                                        .pipeline = {.shader = &shader_virtual_view_comp},
                                        .groups = {DIVIDE_UP(image.width, 8u), DIVIDE_UP(image.height, 8u)},
                                        GRAPH_PUSH(push),
                                        GRAPH_ROWS(graph_stores(&push.target, target),
                                                   graph_row_if(pages, graph_samples(&push.uv, uv)),
                                                   graph_row_if(pages, graph_samples(&push.depth, depth)))});
    virtual_use_sample(pass, frame);
}
