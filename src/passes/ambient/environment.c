/* SPDX-License-Identifier: MIT */
#include "passes/ambient/environment.h"

#include "passes/ambient/environment_maps_shared.h"
#include "passes/compress/bc6h.h"
#include "shaders.h"
#include "view_shared.h"

/* Texels of the mips before this one, all faces. */
static uint32_t first_texel(uint32_t side, uint32_t mip) {
    uint32_t first = 0;
    for (uint32_t i = 0; i < mip; i++) first += 6 * (side >> i) * (side >> i);
    return first;
}

static uint32_t mip_count(uint32_t side) {
    uint32_t count = 1;
    while (side >> count) count++;
    return count;
}

enum { ENVIRONMENT_TABLE_MIP = 4 }; /* the last mip that a table is for that no environment has: of cubes of 128 texels a side */

uint32_t environment_side(uint32_t picture_width) {
    uint32_t side = 128;
    while (side < 1024 && side * 3 < picture_width) side *= 2;
    return side;
}

float environment_roughness(uint32_t mip, uint32_t last_mip) { return powf((float)mip / (float)last_mip, ENVIRONMENT_ROUGHNESS_POWER); }

/* ---- memory ---- */

static struct gpu_image_params image_params(const char *name, VkFormat format, uint32_t width, uint32_t height) {
    return (struct gpu_image_params){.name = name,
                                     .format = format,
                                     .width = width,
                                     .height = height,
                                     .layers = 1,
                                     .mips = 1,
                                     .samples = 1,
                                     .use = GPU_USE_LIGHTS,
                                     .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT};
}

static fnl_result create_cube(gpu_device *device, const char *name, VkFormat format, uint32_t side, uint32_t mips, struct gpu_image *out) {
    struct gpu_image_params params = image_params(name, format, side, side);
    params.layers = 6;
    params.cube = true;
    params.mips = mips;
    return gpu_image_create(device, &params, out);
}

uint64_t environment_cube_bytes(const struct environment_maps *maps) {
    const bool compressed = maps->cube.params.format == VK_FORMAT_BC6H_UFLOAT_BLOCK;
    uint64_t texels = 0;
    for (uint32_t mip = 0; maps->side && mip <= environment_last_mip(maps->side); mip++) texels += 6ull * (maps->side >> mip) * (maps->side >> mip);
    return texels * (compressed ? 1 : 8);
}

void environment_release(gpu_device *device, struct environment_maps *maps) {
    for (uint32_t i = 0; i < COUNT_OF(maps->parts); i++) gpu_image_destroy(device, &maps->parts[i]);
    gpu_image_destroy(device, &maps->levels);
    gpu_image_destroy(device, &maps->picture);
}

void environment_finish_maps(gpu_device *device, struct environment_maps *maps) {
    environment_release(device, maps);
    gpu_image_destroy(device, &maps->cube);
    gpu_image_destroy(device, &maps->table);
    gpu_buffer_destroy(device, &maps->light);
    *maps = (struct environment_maps){0};
}

fnl_result environment_prepare_table(gpu_device *device, struct environment_maps *maps) {
    const struct gpu_image_params table = image_params("reflectance", VK_FORMAT_R16G16B16A16_SFLOAT, ENVIRONMENT_TABLE_SIDE, ENVIRONMENT_TABLE_SIDE);
    return maps->table.handle ? FNL_OK : gpu_image_create(device, &table, &maps->table);
}

fnl_result environment_prepare_cube(gpu_device *device, uint32_t side, bool compressed, struct environment_maps *maps) {
    const VkFormat half = VK_FORMAT_R16G16B16A16_SFLOAT, format = compressed ? VK_FORMAT_BC6H_UFLOAT_BLOCK : half;
    const uint32_t mips = environment_last_mip(side) + 1;
    environment_release(device, maps);
    if (maps->side != side || maps->cube.params.format != format) {
        gpu_image_destroy(device, &maps->cube);
        maps->side = side;
        TRY(create_cube(device, "environment", format, side, mips, &maps->cube));
    }
    TRY(create_cube(device, "environment levels", half, side, mip_count(side), &maps->levels));
    for (uint32_t i = 0; compressed && i < 6 * mips; i++) TRY(gpu_image_part(device, &maps->levels, i % 6, i / 6, false, &maps->parts[i]));
    return FNL_OK;
}

fnl_result environment_prepare(gpu_device *device, const uint16_t *pixels, uint32_t width, uint32_t height, bool compressed,
                               struct environment_maps *maps) {
    TRY(environment_prepare_cube(device, environment_side(width), compressed, maps));
    TRY(environment_prepare_table(device, maps));
    if (!maps->light.handle) TRY(gpu_buffer_create_for(device, GPU_USE_LIGHTS, "environment light", sizeof(struct gpu_environment), GPU_MEMORY_DEVICE, &maps->light));
    const struct gpu_image_params picture = image_params("environment picture", VK_FORMAT_R16G16B16A16_SFLOAT, width, height);
    TRY(gpu_image_create(device, &picture, &maps->picture));
    return gpu_upload_image(device, &maps->picture, pixels, (uint64_t)width * height * 8, false, false);
}

/* ---- passes ---- */

struct copy_data {
    graph_buffer from;
    graph_image to;
};

static void execute_copy(const struct graph_context *context, const void *data) {
    const struct copy_data *d = data;
    gpu_copy_buffer_to_image(context->commands, graph_get_buffer(context, d->from), 0, graph_get_image(context, d->to));
}

static void add_copy(struct graph *graph, const char *name, const struct copy_data *data) {
    struct graph_pass *pass = graph_add_pass(graph, name, GRAPH_QUEUE_GRAPHICS, execute_copy, data, sizeof *data);
    graph_use_buffer(pass, data->from, GRAPH_COPY_FROM);
    graph_use_image(pass, data->to, GRAPH_COPY_TO);
}

static uint32_t linear_sampler(gpu_device *device, bool mipmapped, bool wraps) {
    return gpu_sampler_index(device, &(struct gpu_sampler_params){.mag = VK_FILTER_LINEAR,
                                                                  .min = VK_FILTER_LINEAR,
                                                                  .mip = mipmapped ? VK_SAMPLER_MIPMAP_MODE_LINEAR : VK_SAMPLER_MIPMAP_MODE_NEAREST,
                                                                  .mipmapped = mipmapped,
                                                                  .wrap_u = wraps ? VK_SAMPLER_ADDRESS_MODE_REPEAT
                                                                                  : VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                                                  .wrap_v = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                                                  .anisotropy = 1});
}

/* The picture as a cube map, in `texels`. */
static void add_faces(struct graph *graph, gpu_device *device, const struct environment_maps *maps, graph_image picture, graph_buffer texels) {
    const uint32_t side = maps->side, width = maps->picture.params.width;
    struct gpu_environment_faces_push faces = {
        .side = side, .taps = MAX(2u, DIVIDE_UP(width, 2 * side)), .sampler_index = linear_sampler(device, false, true)};
    graph_dispatch(graph, &(struct graph_dispatch){.name = "environment faces",
                                                   .pipeline = {.shader = &shader_environment_faces_comp},
                                                   .groups = {DIVIDE_UP(6 * side * side, 64u)},
                                                   GRAPH_PUSH(faces),
                                                   GRAPH_ROWS(graph_samples(&faces.picture, picture), graph_writes(&faces.texels, texels))});
}

/* The mips below the first. */
static void add_levels(struct graph *graph, uint32_t side, graph_buffer texels) {
    for (uint32_t mip = 1; side >> mip; mip++) {
        struct gpu_environment_level_push level = {
            .side = side >> mip, .from = first_texel(side, mip - 1), .to = first_texel(side, mip)};
        graph_dispatch(graph, &(struct graph_dispatch){.name = graph_name(graph, "environment level %u", mip),
                                                       .pipeline = {.shader = &shader_environment_levels_comp},
                                                       .groups = {DIVIDE_UP(6 * level.side * level.side, 64u)},
                                                       GRAPH_PUSH(level),
                                                       GRAPH_ROWS(graph_changes(&level.texels, texels))});
    }
}

static void add_diffuse(struct graph *graph, const struct environment_maps *maps, graph_buffer texels, graph_buffer light) {
    enum { SIDE = 32 }; /* nine functions do not tell it from more */
    uint32_t mip = 0;
    while (maps->side >> mip > SIDE) mip++;
    struct gpu_environment_light_push push = {.side = maps->side >> mip, .first = first_texel(maps->side, mip)};
    graph_dispatch(graph, &(struct graph_dispatch){.name = "environment light",
                                                   .pipeline = {.shader = &shader_environment_light_comp},
                                                   .groups = {1},
                                                   GRAPH_PUSH(push),
                                                   GRAPH_ROWS(graph_reads(&push.texels, texels), graph_writes(&push.light, light))});
}

/* All mips for their roughness; the first is a mirror's. */
static void add_filter(struct graph *graph, gpu_device *device, const struct environment_maps *maps, graph_image levels, graph_buffer texels) {
    const uint32_t last = environment_last_mip(maps->side), sampler = linear_sampler(device, true, false);
    struct graph_pass *pass = NULL;
    for (uint32_t mip = 1; mip <= last; mip++) {
        const uint32_t side = maps->side >> mip;
        const float roughness = environment_roughness(mip, last);
        struct gpu_environment_filter_push push = {.first = first_texel(maps->side, mip),
                                                   .side = side,
                                                   .sampler_index = sampler,
                                                   .samples = CLAMP(1048576u / (side * side), 16u, 1024u),
                                                   .cube_side = maps->side,
                                                   .alpha = roughness * roughness};
        pass = graph_dispatch(graph, &(struct graph_dispatch){.pass = pass,
                                                              .name = "environment filter",
                                                              .pipeline = {.shader = &shader_environment_filter_comp},
                                                              .groups = {DIVIDE_UP(6 * side * side, 64u)},
                                                              GRAPH_PUSH(push),
                                                              GRAPH_ROWS(graph_samples(&push.cube, levels), graph_changes(&push.texels, texels))});
    }
}

/* The levels are filtered by now, and take the texels once more: blocks are made of images. Modes with coarse ends would be off by a percent where
 * light is even. */
static graph_buffer add_blocks(struct graph *graph, gpu_device *device, const struct environment_maps *maps, graph_image levels, graph_buffer texels,
                               graph_image cube) {
    struct bc6h_source sources[COUNT_OF(maps->parts)];
    const uint32_t count = 6 * (environment_last_mip(maps->side) + 1);
    const struct bc6h_gpu_params params = {.quality = true};
    for (uint32_t i = 0; i < count; i++) sources[i] = (struct bc6h_source){levels, &maps->parts[i]};
    add_copy(graph, "environment filtered copy", &(struct copy_data){texels, levels});
    graph_buffer blocks = bc6h_add(graph, device, "environment compress", sources, count, &params);
    bc6h_copy_add(graph, "environment copy", blocks, cube);
    return blocks;
}

static void add_table(struct graph *graph, struct environment_maps *maps, graph_image table, uint32_t last_mip) {
    maps->table_mip = last_mip;
    graph_buffer texels = graph_create_buffer(graph, "reflectance texels", ENVIRONMENT_TABLE_SIDE * ENVIRONMENT_TABLE_SIDE * 8ull);
    struct gpu_environment_table_push push = {.last_mip = (float)last_mip};
    graph_dispatch(graph, &(struct graph_dispatch){.name = "reflectance",
                                                   .pipeline = {.shader = &shader_environment_table_comp},
                                                   .groups = {ENVIRONMENT_TABLE_SIDE / 8, ENVIRONMENT_TABLE_SIDE / 8},
                                                   GRAPH_PUSH(push),
                                                   GRAPH_ROWS(graph_writes(&push.texels, texels))});
    add_copy(graph, "reflectance copy", &(struct copy_data){texels, table});
}

graph_buffer environment_texels_create(struct graph *graph, uint32_t side) {
    return graph_create_buffer(graph, "environment texels", first_texel(side, mip_count(side)) * 8ull);
}

/* The cube and what diffuse surfaces reflect, from the first mip; returns the blocks, where the cube has them. */
static graph_buffer add_cube(struct graph *graph, gpu_device *device, const struct environment_maps *maps, graph_buffer texels, graph_image cube,
                             graph_buffer light) {
    graph_image levels = graph_import_image(graph, &maps->levels, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
    add_levels(graph, maps->side, texels);
    add_diffuse(graph, maps, texels, light);
    add_copy(graph, "environment levels copy", &(struct copy_data){texels, levels});
    add_filter(graph, device, maps, levels, texels);
    if (maps->parts[0].handle) return add_blocks(graph, device, maps, levels, texels, cube);
    add_copy(graph, "environment copy", &(struct copy_data){texels, cube});
    return (graph_buffer){0};
}

struct environment_light environment_add(struct graph *graph, gpu_device *device, struct environment_maps *maps, bool filter) {
    const VkImageLayout sampled = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL, before = filter ? VK_IMAGE_LAYOUT_UNDEFINED : sampled;
    struct environment_light out = {.cube = graph_import_image(graph, &maps->cube, before, sampled),
                                    .table = graph_import_image(graph, &maps->table, before, sampled),
                                    .light = graph_import_buffer(graph, "environment light", &maps->light)};
    if (!filter) return out;
    graph_image picture = graph_import_image(graph, &maps->picture, sampled, sampled);
    out.texels = environment_texels_create(graph, maps->side);
    add_faces(graph, device, maps, picture, out.texels);
    out.blocks = add_cube(graph, device, maps, out.texels, out.cube, out.light);
    add_table(graph, maps, out.table, environment_last_mip(maps->side));
    return out;
}

void environment_face_add(struct graph *graph, gpu_device *device, uint32_t side, uint32_t face, graph_image picture, graph_buffer texels) {
    struct gpu_reflections_face_push push = {.side = side, .face = face, .sampler_index = linear_sampler(device, false, false)};
    graph_dispatch(graph, &(struct graph_dispatch){.name = graph_name(graph, "environment face %u", face),
                                                   .pipeline = {.shader = &shader_reflections_face_comp},
                                                   .groups = {DIVIDE_UP(side * side, 64u)},
                                                   GRAPH_PUSH(push),
                                                   GRAPH_ROWS(graph_samples(&push.picture, picture), graph_writes(&push.texels, texels))});
}

void environment_faces_filter(struct graph *graph, gpu_device *device, const struct environment_maps *maps, graph_buffer texels) {
    graph_image cube = graph_import_image(graph, &maps->cube, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
    add_cube(graph, device, maps, texels, cube, graph_import_buffer(graph, "environment light", &maps->light));
}

struct environment_light environment_add_table(struct graph *graph, struct environment_maps *maps, bool fill) {
    const VkImageLayout sampled = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
    struct environment_light out = {.table = graph_import_image(graph, &maps->table, fill ? VK_IMAGE_LAYOUT_UNDEFINED : sampled, sampled)};
    if (fill) add_table(graph, maps, out.table, ENVIRONMENT_TABLE_MIP);
    return out;
}

void environment_use(struct graph_pass *pass, const struct environment_light *light, enum graph_use use) {
    const enum graph_use sample = use == GRAPH_READ_COMPUTE ? GRAPH_SAMPLE_COMPUTE : GRAPH_SAMPLE_FRAGMENT;
    if (light->table.id) graph_use_image(pass, light->table, sample);
    if (light->reflections.set) {
        const struct environment_reflections *r = &light->reflections;
        const graph_buffer used[] = {r->reflections, r->bounds, r->diffuse, r->cells, r->ids, r->spare};
        for (uint32_t i = 0; i < COUNT_OF(used); i++)
            if (used[i].id) graph_use_buffer(pass, used[i], use);
    }
    if (!light->cube.id) return;
    graph_use_image(pass, light->cube, sample);
    graph_use_buffer(pass, light->light, use);
}

void environment_tell(gpu_device *device, struct gpu_frame *out) {
    out->environment_sampler = linear_sampler(device, true, false);
}

void environment_put(struct graph *graph, const struct environment_light *light, struct gpu_frame *out) {
    graph_put_sampled(graph, &out->environment_table, light->table);
    if (!light->cube.id) return;
    graph_put_address(graph, &out->environment, light->light);
    graph_put_sampled(graph, &out->environment_cube, light->cube);
}
