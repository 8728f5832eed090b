/* SPDX-License-Identifier: MIT */
/* fnl_image_compress: a picture or a cube map with mips, by the CPU or a device, into a file. */
#include "base/jobs.h"
#include "fanal/image.h"
#include "image/bc6h.h"
#include "image/environment.h"
#include "image/image.h"
#include "image/texture.h"
#include "passes/compress/bc6h.h"
#include "scene/scene_environment.h"

enum { CUBE_SIZE_MAX = 4096, PARTS_MAX = 6 * TEXTURE_MIPS_MAX };

/* RGB floats of all faces and mips, in the order of struct texture. */
struct levels {
    const fnl_host *host;
    struct texture texture;
    float *pixels;
    size_t pixel_count, starts[PARTS_MAX + 1]; /* in pixels */
    uint32_t part_count;
};

static uint32_t part_width(const struct levels *l, uint32_t part) { return texture_side(l->texture.width, part / l->texture.faces); }
static uint32_t part_height(const struct levels *l, uint32_t part) { return texture_side(l->texture.height, part / l->texture.faces); }

static fnl_result levels_init(const fnl_host *host, uint32_t width, uint32_t height, const fnl_compress_params *params, struct levels *out) {
    *out = (struct levels){.host = host};
    out->texture = (struct texture){.format = params->is_signed ? TEXTURE_BC6H_SIGNED : TEXTURE_BC6H,
                                    .width = width,
                                    .height = height,
                                    .faces = params->cube_size ? 6 : 1,
                                    .mips = params->mips ? texture_mips(width, height) : 1};
    out->part_count = out->texture.mips * out->texture.faces;
    for (uint32_t i = 0; i < out->part_count; i++) out->starts[i + 1] = out->starts[i] + (size_t)part_width(out, i) * part_height(out, i);
    out->pixel_count = out->starts[out->part_count];
    out->pixels = host_allocate(host, out->pixel_count * 4 * sizeof(float));
    if (!out->pixels) return FNL_ERROR_MEMORY;
    return texture_allocate(host, &out->texture);
}

static void levels_finish(struct levels *l) {
    if (l->pixels) host_free(l->host, l->pixels, l->pixel_count * 4 * sizeof(float));
    texture_free(l->host, &l->texture);
}

/* ---- the source ---- */

static void take_pixel(const fnl_image *image, size_t i, float out[4]) {
    for (int c = 0; c < 4; c++) {
        if (image->format == FNL_PIXEL_FORMAT_RGBA32F)
            out[c] = ((const float *)image->pixels)[i * 4 + c];
        else if (image->format == FNL_PIXEL_FORMAT_RGBA16)
            out[c] = decode_srgb(((const uint16_t *)image->pixels)[i * 4 + c] / 65535.0f);
        else
            out[c] = decode_srgb(((const uint8_t *)image->pixels)[i * 4 + c] / 255.0f);
    }
    out[3] = 1;
}

/* Bilinear; the left edge meets the right one. Directions as in environments (fanal/environment.h). */
static void sample_panorama(const fnl_image *image, vec3 direction, float sum[3]) {
    const struct panorama panorama = {.width = image->width, .height = image->height};
    float x, y;
    panorama_place(&panorama, direction, &x, &y);
    y = CLAMP(y, 0.0f, (float)(image->height - 1));
    float fx = x - floorf(x), fy = y - floorf(y);
    uint32_t x0 = (uint32_t)((int64_t)floorf(x) + image->width) % image->width, x1 = (x0 + 1) % image->width;
    uint32_t y0 = (uint32_t)y, y1 = MIN(y0 + 1, image->height - 1);
    const size_t at[4] = {(size_t)y0 * image->width + x0, (size_t)y0 * image->width + x1, (size_t)y1 * image->width + x0,
                          (size_t)y1 * image->width + x1};
    const float weights[4] = {(1 - fx) * (1 - fy), fx * (1 - fy), (1 - fx) * fy, fx * fy};
    for (int k = 0; k < 4; k++) {
        float pixel[4];
        if (weights[k] == 0) continue;
        take_pixel(image, at[k], pixel);
        for (int c = 0; c < 3; c++) sum[c] += weights[k] * pixel[c];
    }
}

struct cube {
    const fnl_image *image;
    struct levels *levels;
    struct environment places; /* without texels: finer than the faces where the panorama is */
    uint32_t samples;          /* along a side of a texel */
};

static void fill_row(void *context, uint32_t row) {
    const struct cube *cube = context;
    uint32_t size = cube->levels->texture.width, face = row / size, y = row % size, n = cube->samples;
    for (uint32_t x = 0; x < size; x++) {
        float sum[3] = {0}, *out = cube->levels->pixels + 4 * ((size_t)row * size + x);
        for (uint32_t i = 0; i < n * n; i++)
            sample_panorama(cube->image, environment_direction(&cube->places, 0, face, x * n + i % n, y * n + i / n), sum);
        for (int c = 0; c < 3; c++) out[c] = sum[c] / (float)(n * n);
        out[3] = 1;
    }
}

static void fill_cube(struct jobs *jobs, const fnl_image *image, struct levels *l) {
    uint32_t size = l->texture.width, samples = CLAMP(DIVIDE_UP(image->width, 4 * size), 1u, 16u);
    struct cube cube = {image, l, {.size = size * samples, .mips = 1}, samples};
    jobs_parallel_for(jobs, 6 * size, fill_row, &cube);
}

/* The mean over the part of the larger level that a pixel covers. */
static void shrink(const float *from, uint32_t from_width, uint32_t from_height, float *to, uint32_t width, uint32_t height) {
    for (uint32_t y = 0; y < height; y++)
        for (uint32_t x = 0; x < width; x++, to += 4) {
            double x0 = (double)x * from_width / width, x1 = (double)(x + 1) * from_width / width, sum[3] = {0};
            double y0 = (double)y * from_height / height, y1 = (double)(y + 1) * from_height / height;
            for (uint32_t j = (uint32_t)y0; j < y1; j++)
                for (uint32_t i = (uint32_t)x0; i < x1; i++) {
                    double area = (fmin(i + 1, x1) - fmax(i, x0)) * (fmin(j + 1, y1) - fmax(j, y0));
                    for (int c = 0; c < 3; c++) sum[c] += area * (double)from[4 * ((size_t)j * from_width + i) + c];
                }
            for (int c = 0; c < 3; c++) to[c] = (float)(sum[c] / ((x1 - x0) * (y1 - y0)));
            to[3] = 1;
        }
}

static void fill(struct jobs *jobs, const fnl_image *image, struct levels *l) {
    uint32_t faces = l->texture.faces;
    if (faces == 6)
        fill_cube(jobs, image, l);
    else
        for (size_t i = 0; i < (size_t)image->width * image->height; i++) take_pixel(image, i, l->pixels + 4 * i);
    /* An infinity would spread over all mips. */
    for (size_t i = 0; i < 4 * l->starts[faces]; i++) l->pixels[i] = bc6h_limit(l->pixels[i], l->texture.format == TEXTURE_BC6H_SIGNED);
    for (uint32_t i = faces; i < l->part_count; i++)
        shrink(l->pixels + 4 * l->starts[i - faces], part_width(l, i - faces), part_height(l, i - faces), l->pixels + 4 * l->starts[i],
               part_width(l, i), part_height(l, i));
}

/* ---- compressing ---- */

static void compress_on_cpu(struct jobs *jobs, struct levels *l, fnl_compress_quality quality, fnl_compress_stats *stats) {
    struct bc6h_params params = {.quality = (enum bc6h_quality)quality, .is_signed = l->texture.format == TEXTURE_BC6H_SIGNED};
    double start = time_now();
    for (uint32_t i = 0; i < l->part_count; i++) {
        struct bc6h_picture picture = {l->pixels + 4 * l->starts[i], part_width(l, i), part_height(l, i), 4};
        void *blocks = l->texture.bytes + texture_offset(&l->texture, i / l->texture.faces, i % l->texture.faces);
        bc6h_encode_picture(jobs, &params, &picture, blocks);
    }
    stats->seconds = time_now() - start;
}

struct read_data {
    graph_buffer from, to;
    uint64_t size;
};

static void execute_read(const struct graph_context *context, const void *data) {
    const struct read_data *d = data;
    gpu_copy_buffer(context->commands, graph_get_buffer(context, d->from), 0, graph_get_buffer(context, d->to), 0, d->size);
}

static fnl_result upload(gpu_device *device, const struct levels *l, struct gpu_image *images) {
    for (uint32_t i = 0; i < l->part_count; i++) {
        struct gpu_image_params params = {.name = "picture to compress",
                                          .format = VK_FORMAT_R32G32B32A32_SFLOAT,
                                          .width = part_width(l, i),
                                          .height = part_height(l, i),
                                          .layers = 1,
                                          .mips = 1,
                                          .samples = 1,
                                          .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT};
        TRY(gpu_image_create(device, &params, &images[i]));
        TRY(gpu_upload_image(device, &images[i], l->pixels + 4 * l->starts[i], (l->starts[i + 1] - l->starts[i]) * 16, false, false));
    }
    return gpu_upload_flush(device);
}

static fnl_result run(gpu_device *device, struct graph *graph, const struct levels *l, const struct gpu_image *images,
                      const struct gpu_buffer *out, bool quality, fnl_compress_stats *stats) {
    struct bc6h_source sources[PARTS_MAX];
    struct bc6h_gpu_params params = {quality, l->texture.format == TEXTURE_BC6H_SIGNED};
    const VkImageLayout layout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
    graph_begin(graph);
    TRY(gpu_frame_begin(device));
    for (uint32_t i = 0; i < l->part_count; i++) sources[i] = (struct bc6h_source){graph_import_image(graph, &images[i], layout, layout), NULL};
    struct read_data read = {bc6h_add(graph, device, "compress", sources, l->part_count, &params), graph_import_buffer(graph, "blocks", out), out->size};
    struct graph_pass *pass = graph_add_pass(graph, "read blocks", GRAPH_QUEUE_GRAPHICS, execute_read, &read, sizeof read);
    graph_use_buffer(pass, read.from, GRAPH_COPY_FROM);
    graph_use_buffer(pass, read.to, GRAPH_COPY_TO);
    struct graph_pass *host = graph_add_pass(graph, "to host", GRAPH_QUEUE_GRAPHICS, NULL, NULL, 0);
    graph_keep(host);
    graph_use_buffer(host, read.to, GRAPH_READ_HOST);
    fnl_result compiled = graph_compile(graph), executed = graph_execute_frame(graph, &(struct graph_execute_params){.timers = true});
    TRY(compiled);
    TRY(executed);
    TRY(gpu_frame_wait(device, gpu_frame_number(device)));
    const struct graph_timer *timers;
    uint32_t count;
    if (graph_query_timers(graph, gpu_frame_number(device), &timers, &count))
        for (uint32_t i = 0; i < count; i++)
            if (strcmp(timers[i].name, "compress") == 0) stats->seconds = timers[i].milliseconds * 1e-3;
    memcpy(l->texture.bytes, out->mapped, out->size);
    return FNL_OK;
}

static fnl_result compress_on_device(gpu_device *device, const struct levels *l, bool quality, fnl_compress_stats *stats) {
    struct gpu_image images[PARTS_MAX];
    memset(images, 0, sizeof images);
    struct gpu_buffer out = {0};
    struct graph *graph = NULL;
    fnl_result result = graph_create(gpu_host(device), device, &graph);
    if (result == FNL_OK) result = gpu_buffer_create(device, "blocks", texture_offset(&l->texture, l->texture.mips, 0), GPU_MEMORY_READBACK, &out);
    if (result == FNL_OK) result = upload(device, l, images);
    /* Twice: the time of the first would be that of making the pipeline where a driver does that at the first use. */
    for (int i = 0; i < 2 && result == FNL_OK; i++) result = run(device, graph, l, images, &out, quality, stats);
    graph_destroy(&graph);
    gpu_buffer_destroy(device, &out);
    for (uint32_t i = 0; i < l->part_count; i++) gpu_image_destroy(device, &images[i]);
    fnl_result idle = gpu_wait_idle(device); /* frees them */
    return result == FNL_OK ? idle : result;
}

static fnl_result measure(const struct levels *l, fnl_compress_stats *stats) {
    const struct texture *t = &l->texture;
    const struct bc6h_block *blocks = (const void *)t->bytes;
    for (size_t i = 0, count = texture_offset(t, t->mips, 0) / BC6H_BLOCK_BYTES; i < count; i++) stats->blocks[bc6h_unpack(&blocks[i]).mode]++;
    stats->pixels = l->pixel_count;
    stats->width = t->width;
    stats->height = t->height;
    stats->faces = t->faces;
    stats->mips = t->mips;
    size_t bytes = (size_t)t->width * t->height * 4 * sizeof(float);
    float *decoded = host_allocate(l->host, bytes);
    if (!decoded) return FNL_ERROR_MEMORY;
    for (uint32_t face = 0; face < t->faces; face++) {
        struct bc6h_picture a = {l->pixels + 4 * l->starts[face], t->width, t->height, 4}, b = {decoded, t->width, t->height, 4};
        bc6h_decode_picture((const void *)(t->bytes + texture_offset(t, 0, face)), t->format == TEXTURE_BC6H_SIGNED, t->width, t->height, decoded);
        struct bc6h_error error = bc6h_compare(&a, &b);
        stats->rmse += error.rmse * error.rmse / t->faces;
        stats->rmsle += error.rmsle * error.rmsle / t->faces;
    }
    stats->rmse = sqrt(stats->rmse);
    stats->rmsle = sqrt(stats->rmsle);
    host_free(l->host, decoded, bytes);
    return FNL_OK;
}

fnl_result fnl_image_compress(const fnl_host *host, const char *path, const fnl_image *image, const fnl_compress_params *given,
                              fnl_compress_stats *stats) {
    fnl_host resolved = host_resolve(host);
    fnl_compress_params params = given ? *given : fnl_compress_params_default();
    fnl_compress_stats numbers = {0};
    TRY(image_check(CALL(&resolved), "image", image));
    TRY(check_enum(CALL(&resolved), "params.quality", (int)params.quality, FNL_COMPRESS_BEST + 1, "fnl_compress_quality"));
    TRY(check_count(CALL(&resolved), "params.cube_size", params.cube_size, 0, CUBE_SIZE_MAX));
    if (params.device && params.quality == FNL_COMPRESS_BEST) {
        log_error(&resolved, "fnl_image_compress: params.device: FNL_COMPRESS_BEST is for the CPU alone");
        return FNL_ERROR_INVALID;
    }
    if (params.cube_size && image->width != 2 * image->height) {
        log_error(&resolved, "fnl_image_compress: a panorama is twice as wide as high; this picture has %ux%u pixels", image->width, image->height);
        return FNL_ERROR_INVALID;
    }
    if (path && !path_has_extension(path, "dds") && !path_has_extension(path, "ktx2")) {
        log_error(&resolved, "%s: compressed pictures are written as .dds or .ktx2, not as '.%s'", path, path_extension(path));
        return FNL_ERROR_UNSUPPORTED;
    }
    struct jobs *jobs = NULL;
    struct levels levels = {0};
    fnl_result result = jobs_create(&resolved, &jobs);
    if (result == FNL_OK) {
        uint32_t size = params.cube_size;
        result = levels_init(&resolved, size ? size : image->width, size ? size : image->height, &params, &levels);
    }
    if (result == FNL_OK) {
        fill(jobs, image, &levels);
        if (params.device)
            result = compress_on_device(params.device, &levels, params.quality == FNL_COMPRESS_QUALITY, &numbers);
        else
            compress_on_cpu(jobs, &levels, params.quality, &numbers);
    }
    if (result == FNL_OK) result = measure(&levels, &numbers);
    if (result == FNL_OK && path) result = texture_save(&resolved, path, &levels.texture);
    if (result == FNL_ERROR_MEMORY) log_error(&resolved, "%s: out of memory", path ? path : "fnl_image_compress");
    levels_finish(&levels);
    jobs_destroy(&jobs);
    if (stats) *stats = numbers;
    return result;
}
