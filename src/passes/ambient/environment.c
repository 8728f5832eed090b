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

static uint64_t cube_bytes(uint32_t side, bool compressed) {
    uint64_t texels = 0;
    for (uint32_t mip = 0; side && mip <= environment_last_mip(side); mip++) texels += 6ull * (side >> mip) * (side >> mip);
    return texels * (compressed ? 1 : 8);
}

static bool is_compressed(const struct environment_maps *maps) { return maps->cube.params.format == VK_FORMAT_BC6H_UFLOAT_BLOCK; }

uint64_t environment_cube_bytes(const struct environment_maps *maps) {
    return cube_bytes(maps->side, is_compressed(maps));
}

void environment_release(gpu_device *device, struct environment_maps *maps) {
    for (uint32_t i = 0; i < COUNT_OF(maps->parts); i++) gpu_image_destroy(device, &maps->parts[i]);
    gpu_image_destroy(device, &maps->levels);
    gpu_image_destroy(device, &maps->picture);
    gpu_buffer_destroy(device, &maps->kept);
    maps->is_kept = false;
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

/* The cube itself; nothing is left of what filtering another one needed. */
static fnl_result prepare_cube(gpu_device *device, uint32_t side, bool compressed, struct environment_maps *maps) {
    const VkFormat format = compressed ? VK_FORMAT_BC6H_UFLOAT_BLOCK : VK_FORMAT_R16G16B16A16_SFLOAT;
    environment_release(device, maps);
    if (maps->side == side && maps->cube.params.format == format) return FNL_OK;
    gpu_image_destroy(device, &maps->cube);
    maps->side = side;
    return create_cube(device, "environment", format, side, environment_last_mip(side) + 1, &maps->cube);
}

fnl_result environment_prepare_cube(gpu_device *device, uint32_t side, bool compressed, struct environment_maps *maps) {
    const VkFormat half = VK_FORMAT_R16G16B16A16_SFLOAT;
    const uint32_t mips = environment_last_mip(side) + 1;
    TRY(prepare_cube(device, side, compressed, maps));
    TRY(create_cube(device, "environment levels", half, side, mip_count(side), &maps->levels));
    for (uint32_t i = 0; compressed && i < 6 * mips; i++) TRY(gpu_image_part(device, &maps->levels, i % 6, i / 6, false, &maps->parts[i]));
    return FNL_OK;
}

static fnl_result prepare_rest(gpu_device *device, struct environment_maps *maps) {
    TRY(environment_prepare_table(device, maps));
    return maps->light.handle ? FNL_OK : gpu_buffer_create_for(device, GPU_USE_LIGHTS, "environment light", sizeof(struct gpu_environment), GPU_MEMORY_DEVICE, &maps->light);
}

fnl_result environment_prepare(gpu_device *device, const uint16_t *pixels, uint32_t width, uint32_t height, bool compressed,
                               struct environment_maps *maps) {
    TRY(environment_prepare_cube(device, environment_side(width), compressed, maps));
    TRY(prepare_rest(device, maps));
    const struct gpu_image_params picture = image_params("environment picture", VK_FORMAT_R16G16B16A16_SFLOAT, width, height);
    TRY(gpu_image_create(device, &picture, &maps->picture));
    return gpu_upload_image(device, &maps->picture, pixels, (uint64_t)width * height * 8, false, false);
}

/* ---- maps that were made before ---- */

enum { TABLE_BYTES = ENVIRONMENT_TABLE_SIDE * ENVIRONMENT_TABLE_SIDE * 8, KEPT_VERSION = 1 /* of what stands here, not in shaders */ };

/* Where the light and the table are, behind the cube. Images are copied from multiples of 16 bytes. */
static uint64_t kept_light(uint32_t side, bool compressed) { return cube_bytes(side, compressed); }
static uint64_t kept_table(uint32_t side, bool compressed) {
    return align_up(kept_light(side, compressed) + sizeof(struct gpu_environment), 16);
}
uint64_t environment_kept_bytes(uint32_t side, bool compressed) { return kept_table(side, compressed) + TABLE_BYTES; }

fnl_result environment_prepare_kept(gpu_device *device, uint32_t side, bool compressed, struct environment_maps *maps) {
    TRY(prepare_cube(device, side, compressed, maps));
    TRY(prepare_rest(device, maps));
    return gpu_buffer_create(device, "kept environment", environment_kept_bytes(side, compressed), GPU_MEMORY_UPLOAD, &maps->kept);
}

fnl_result environment_keep(gpu_device *device, struct environment_maps *maps) {
    return gpu_buffer_create(device, "kept environment", environment_kept_bytes(maps->side, is_compressed(maps)), GPU_MEMORY_READBACK, &maps->kept);
}

uint64_t environment_version(void) {
    const struct gpu_shader *const shaders[] = {&shader_environment_faces_comp, &shader_environment_levels_comp, &shader_environment_filter_comp,
                                                &shader_environment_light_comp, &shader_environment_table_comp, &shader_bc6h_quality_comp};
    uint64_t version = HASH_SEED + KEPT_VERSION;
    for (uint32_t i = 0; i < COUNT_OF(shaders); i++) version = hash_bytes(shaders[i]->packed, shaders[i]->packed_size, version);
    return version;
}

/* ---- passes ---- */

struct copy_data {
    graph_buffer from;
    graph_image to;
    uint64_t offset;
};

static void execute_copy(const struct graph_context *context, const void *data) {
    const struct copy_data *d = data;
    gpu_copy_buffer_to_image(context->commands, graph_get_buffer(context, d->from), d->offset, graph_get_image(context, d->to));
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

static void add_diffuse(struct graph *graph, const struct environment_maps *maps, graph_buffer texels, graph_buffer peak, graph_buffer light) {
    enum { SIDE = 32 }; /* nine functions do not tell it from more */
    uint32_t mip = 0;
    while (maps->side >> mip > SIDE) mip++;
    struct gpu_environment_light_push push = {.side = maps->side >> mip, .first = first_texel(maps->side, mip)};
    graph_dispatch(graph, &(struct graph_dispatch){.name = "environment light",
                                                   .pipeline = {.shader = &shader_environment_light_comp},
                                                   .groups = {1},
                                                   GRAPH_PUSH(push),
                                                   GRAPH_ROWS(graph_reads(&push.texels, texels), graph_writes(&push.light, light),
                                                              graph_row_if(peak.id != 0, graph_reads(&push.peak, peak)))});
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
    add_copy(graph, "environment filtered copy", &(struct copy_data){texels, levels, 0});
    graph_buffer blocks = bc6h_add(graph, device, "environment compress", sources, count, &params);
    bc6h_copy_add(graph, "environment copy", blocks, cube);
    return blocks;
}

static graph_buffer add_table(struct graph *graph, struct environment_maps *maps, graph_image table, uint32_t last_mip) {
    maps->table_mip = last_mip;
    graph_buffer texels = graph_create_buffer(graph, "reflectance texels", ENVIRONMENT_TABLE_SIDE * ENVIRONMENT_TABLE_SIDE * 8ull);
    struct gpu_environment_table_push push = {.last_mip = (float)last_mip};
    graph_dispatch(graph, &(struct graph_dispatch){.name = "reflectance",
                                                   .pipeline = {.shader = &shader_environment_table_comp},
                                                   .groups = {ENVIRONMENT_TABLE_SIDE / 8, ENVIRONMENT_TABLE_SIDE / 8},
                                                   GRAPH_PUSH(push),
                                                   GRAPH_ROWS(graph_writes(&push.texels, texels))});
    add_copy(graph, "reflectance copy", &(struct copy_data){texels, table, 0});
    return texels;
}

static graph_buffer create_texels(struct graph *graph, uint32_t side) {
    return graph_create_buffer(graph, "environment texels", first_texel(side, mip_count(side)) * 8ull);
}

/* The cube and what diffuse surfaces reflect, from the first mip; returns the blocks, where the cube has them. `peak`: texels are fractions. */
static graph_buffer add_cube(struct graph *graph, gpu_device *device, const struct environment_maps *maps, graph_buffer texels, graph_buffer peak,
                             graph_image cube, graph_buffer light) {
    graph_image levels = graph_import_image(graph, &maps->levels, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
    add_levels(graph, maps->side, texels);
    add_diffuse(graph, maps, texels, peak, light);
    add_copy(graph, "environment levels copy", &(struct copy_data){texels, levels, 0});
    add_filter(graph, device, maps, levels, texels);
    if (maps->parts[0].handle) return add_blocks(graph, device, maps, levels, texels, cube);
    add_copy(graph, "environment copy", &(struct copy_data){texels, cube, 0});
    return (graph_buffer){0};
}

/* Pieces of buffers into one, or out of it. */
struct pieces_data {
    struct piece {
        graph_buffer from, to;
        uint64_t from_offset, to_offset, size;
    } pieces[3];
    uint32_t count;
};

static void execute_pieces(const struct graph_context *context, const void *data) {
    const struct pieces_data *d = data;
    for (uint32_t i = 0; i < d->count; i++) {
        const struct piece *p = &d->pieces[i];
        gpu_copy_buffer(context->commands, graph_get_buffer(context, p->from), p->from_offset, graph_get_buffer(context, p->to), p->to_offset, p->size);
    }
}

static void add_pieces(struct graph *graph, const char *name, const struct pieces_data *data) {
    struct graph_pass *pass = graph_add_pass(graph, name, GRAPH_QUEUE_GRAPHICS, execute_pieces, data, sizeof *data);
    for (uint32_t i = 0; i < data->count; i++) {
        graph_use_buffer(pass, data->pieces[i].from, GRAPH_COPY_FROM);
        if (i == 0 || data->pieces[i].to.id != data->pieces[0].to.id) graph_use_buffer(pass, data->pieces[i].to, GRAPH_COPY_TO);
    }
}

/* What was filtered goes to `kept`, for the CPU. */
static void add_keep(struct graph *graph, const struct environment_maps *maps, graph_buffer cube, graph_buffer light, graph_buffer table) {
    const bool compressed = is_compressed(maps);
    graph_buffer to = graph_import_buffer(graph, "kept environment", &maps->kept);
    add_pieces(graph, "environment keep",
               &(struct pieces_data){{{cube, to, 0, 0, cube_bytes(maps->side, compressed)},
                                      {light, to, 0, kept_light(maps->side, compressed), sizeof(struct gpu_environment)},
                                      {table, to, 0, kept_table(maps->side, compressed), TABLE_BYTES}},
                                     3});
    graph_use_buffer(graph_add_pass(graph, "environment kept", GRAPH_QUEUE_GRAPHICS, NULL, NULL, 0), to, GRAPH_READ_HOST);
}

static void add_kept(struct graph *graph, struct environment_maps *maps, const struct environment_light *out) {
    const bool compressed = is_compressed(maps);
    graph_buffer kept = graph_import_buffer(graph, "kept environment", &maps->kept);
    maps->table_mip = environment_last_mip(maps->side);
    add_copy(graph, "environment copy", &(struct copy_data){kept, out->cube, 0});
    add_copy(graph, "reflectance copy", &(struct copy_data){kept, out->table, kept_table(maps->side, compressed)});
    add_pieces(graph, "environment light copy",
               &(struct pieces_data){{{kept, out->light, kept_light(maps->side, compressed), 0, sizeof(struct gpu_environment)}}, 1});
}

struct environment_light environment_add(struct graph *graph, gpu_device *device, struct environment_maps *maps, bool make) {
    const VkImageLayout sampled = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL, before = make ? VK_IMAGE_LAYOUT_UNDEFINED : sampled;
    struct environment_light out = {.cube = graph_import_image(graph, &maps->cube, before, sampled),
                                    .table = graph_import_image(graph, &maps->table, before, sampled),
                                    .light = graph_import_buffer(graph, "environment light", &maps->light)};
    if (!make) return out;
    if (maps->is_kept) {
        add_kept(graph, maps, &out);
        return out;
    }
    graph_image picture = graph_import_image(graph, &maps->picture, sampled, sampled);
    out.texels = create_texels(graph, maps->side);
    add_faces(graph, device, maps, picture, out.texels);
    out.blocks = add_cube(graph, device, maps, out.texels, (graph_buffer){0}, out.cube, out.light);
    graph_buffer table = add_table(graph, maps, out.table, environment_last_mip(maps->side));
    if (maps->kept.handle) add_keep(graph, maps, out.blocks.id ? out.blocks : out.texels, out.light, table);
    return out;
}

struct environment_faces environment_faces_create(struct graph *graph, uint32_t side) {
    const struct environment_faces out = {.radiances = graph_create_buffer(graph, "probe radiances", 6ull * side * side * sizeof(vec3)),
                                          .peak = graph_create_buffer(graph, "probe peak", 4)};
    graph_add_clear(graph, "probe clear", GRAPH_QUEUE_GRAPHICS, (struct graph_clear){.buffers = {out.peak}});
    return out;
}

void environment_face_add(struct graph *graph, gpu_device *device, uint32_t side, uint32_t face, graph_image picture,
                          const struct environment_faces *faces) {
    struct gpu_reflections_face_push push = {.side = side, .face = face, .sampler_index = linear_sampler(device, false, false)};
    graph_dispatch(graph, &(struct graph_dispatch){.name = graph_name(graph, "environment face %u", face),
                                                   .pipeline = {.shader = &shader_reflections_face_comp},
                                                   .groups = {DIVIDE_UP(side * side, 64u)},
                                                   GRAPH_PUSH(push),
                                                   GRAPH_ROWS(graph_samples(&push.picture, picture), graph_writes(&push.radiances, faces->radiances),
                                                              graph_changes(&push.peak, faces->peak))});
}

void environment_faces_filter(struct graph *graph, gpu_device *device, const struct environment_maps *maps, const struct environment_faces *faces) {
    graph_image cube = graph_import_image(graph, &maps->cube, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
    graph_buffer texels = create_texels(graph, maps->side);
    struct gpu_reflections_pack_push push = {.count = 6 * maps->side * maps->side};
    graph_dispatch(graph, &(struct graph_dispatch){.name = "environment faces",
                                                   .pipeline = {.shader = &shader_reflections_pack_comp},
                                                   .groups = {DIVIDE_UP(push.count, 64u)},
                                                   GRAPH_PUSH(push),
                                                   GRAPH_ROWS(graph_reads(&push.radiances, faces->radiances), graph_reads(&push.peak, faces->peak),
                                                              graph_writes(&push.texels, texels))});
    add_cube(graph, device, maps, texels, faces->peak, cube, graph_import_buffer(graph, "environment light", &maps->light));
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
