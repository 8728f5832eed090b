/* SPDX-License-Identifier: MIT */
#include "passes/shade/coarse.h"

#include "passes/shade/gbuffer_layouts.h"
#include "shaders.h"

#include <math.h>

_Static_assert((uint32_t)FNL_COARSE_CRITERION_MINMAX == COARSE_CRITERION_MINMAX && FNL_COARSE_CRITERION_COUNT == 3 &&
                   (uint32_t)FNL_COARSE_SPLIT_SHARP == COARSE_SPLIT_SHARP && FNL_COARSE_SPLIT_COUNT == 4,
               "coarse_shared.h has the values of fnl_coarse_criterion and fnl_coarse_split");

#define BOUND_FORMAT VK_FORMAT_R32_SFLOAT

bool coarse_has_samplers(const gpu_device *device) {
    return gpu_minmax_supported(device, BOUND_FORMAT) && gpu_minmax_supported(device, GEOMETRY_DEPTH_FORMAT);
}

/* ---- the G-buffer ---- */

/* Whether blocks have a base colour of their own, filtered in this way; split by the base colour, each pixel has its own. */
static bool has_color(const fnl_coarse_options *o, fnl_coarse_filter filter) {
    return o->filter == filter && o->size > 1 && o->split != FNL_COARSE_SPLIT_ALBEDO;
}

static struct gbuffer_extras extras_of(const fnl_coarse_options *o) {
    struct gbuffer_extras e = {.fragment = &shader_coarse_gbuffer_z_frag};
    if (o->criterion == FNL_COARSE_CRITERION_ID) {
        e.fragment = &shader_coarse_gbuffer_ids_frag;
        e.targets[e.count].name = "coarse ids";
        e.targets[e.count++].format = VK_FORMAT_R32G32_UINT;
    }
    if (o->criterion == FNL_COARSE_CRITERION_MINMAX) {
        e.fragment = &shader_coarse_gbuffer_bounds_frag;
        for (uint32_t i = 0; i < 2; i++) {
            e.targets[e.count].name = i ? "coarse height" : "coarse azimuth";
            e.targets[e.count++].format = BOUND_FORMAT;
        }
    }
    float bias = -1;
    if (has_color(o, FNL_COARSE_FILTER_SAMPLED)) {
        bias = log2f((float)o->size);
        e.targets[e.count].name = "coarse color";
        e.targets[e.count++].format = gbuffer_layouts[FNL_GBUFFER_DEFAULT].targets[0].format;
    }
    memcpy(&e.constant, &bias, sizeof bias);
    return e;
}

uint32_t coarse_extra_bytes(const fnl_coarse_options *options) {
    struct gbuffer_extras e = extras_of(options);
    uint32_t bytes = 0;
    for (uint32_t i = 0; i < e.count; i++) bytes += gpu_texel_bytes(e.targets[i].format);
    return bytes;
}

struct gbuffer coarse_gbuffer_add(struct graph *graph, const struct shade_input *input, const struct coarse_params *params,
                                  bool prepass, graph_image radiance, graph_image depth) {
    struct gbuffer_extras extras = extras_of(&params->options);
    return gbuffer_add_with(graph, input, prepass, radiance, depth, &extras);
}

/* ---- blocks ---- */

struct coarse_data {
    struct gbuffer gbuffer;
    graph_image target, ao;
    graph_buffer counts, blocks, words, counters;
    VkDeviceAddress lighting, settings;
    struct coarse_params params;
    uint32_t bits, groups_x, groups_y;
};

static bool has_samplers(const struct coarse_params *p) {
    return p->options.criterion == FNL_COARSE_CRITERION_MINMAX && p->samplers && p->options.size > 1;
}

static bool has_fovea(const fnl_coarse_options *o) { return o->fovea > 0 && o->size > 1; }

static uint32_t sampler(gpu_device *device, VkFilter filter, VkSamplerReductionMode reduction) {
    struct gpu_sampler_params params = {.mag = filter,
                                        .min = filter,
                                        .mip = VK_SAMPLER_MIPMAP_MODE_NEAREST,
                                        .wrap_u = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                        .wrap_v = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                        .anisotropy = 1,
                                        .reduction = reduction};
    return gpu_sampler_index(device, &params);
}

/* A pass that goes over the blocks. */
static struct graph_pass *add_pass(struct graph *graph, const struct coarse_data *d, const char *name,
                                   const struct gpu_shader *shader, enum graph_use blocks, enum graph_use target) {
    const fnl_coarse_options *o = &d->params.options;
    bool minmax = o->criterion == FNL_COARSE_CRITERION_MINMAX, id = o->criterion == FNL_COARSE_CRITERION_ID,
         color = has_color(o, FNL_COARSE_FILTER_SAMPLED);
    uint32_t flags = (color ? COARSE_COLOR : 0) | (has_color(o, FNL_COARSE_FILTER_MEAN) ? COARSE_MEAN : 0) |
                     (o->gather ? COARSE_GATHER : 0) | (d->words.id ? COARSE_WORDS : 0) |
                     (has_samplers(&d->params) ? COARSE_SAMPLERS : 0) | (d->ao.id ? COARSE_AO : 0) |
                     (o->albedo_tolerance < 1 ? COARSE_ALBEDO : 0) | (has_fovea(o) ? COARSE_FOVEA : 0);
    struct gpu_compute_params pipeline = {
        .shader = shader,
        .constant_count = 10,
        .constants = {[LIGHTING_ID] = d->bits,
                      [COUNT_LIGHTS_ID] = d->counters.id != 0,
                      [HAS_LIGHTS_ID] = 1,
                      [HAS_METAL_ID] = 1,
                      [COARSE_SIZE_ID] = o->size,
                      [COARSE_FIND_ID] = (uint32_t)o->criterion,
                      [COARSE_SPLIT_ID] = (uint32_t)o->split,
                      [COARSE_FLAGS_ID] = flags}};
    gbuffer_specialise(&d->gbuffer, pipeline.constants, &pipeline.constant_count);
    const graph_image *extras = d->gbuffer.extras;
    struct gpu_coarse_push push = {.lighting = d->lighting, .gbuffer = gbuffer_block(&d->gbuffer), .settings = d->settings};
    _Static_assert(sizeof push <= GPU_PUSH_BYTES, "it is pushed");
    struct graph_pass *pass = graph_dispatch(
        graph, &(struct graph_dispatch){.name = name,
                                        .pipeline = pipeline,
                                        .groups = {d->groups_x, d->groups_y},
                                        GRAPH_PUSH(push),
                                        GRAPH_ROWS(graph_row_if(d->counters.id, graph_changes(&push.counters, d->counters)),
                                                   graph_buffer_row(&push.blocks, d->blocks, blocks),
                                                   graph_row_if(d->words.id, graph_writes(&push.words, d->words)),
                                                   graph_image_row(&push.target, d->target, target),
                                                   graph_row_if(color, graph_samples(&push.color, extras[minmax ? 2 : id])),
                                                   graph_row_if(id, graph_samples(&push.geometry, extras[0])),
                                                   graph_row_if(minmax, graph_samples(&push.azimuth, extras[0])),
                                                   graph_row_if(minmax, graph_samples(&push.height, extras[1])),
                                                   graph_row_if(d->ao.id, graph_samples(&push.ao, d->ao)))});
    gbuffer_add_rows(pass, &push.gbuffer, &d->gbuffer, GRAPH_SAMPLE_COMPUTE);
    return pass;
}

/* That all directions pass at 180 degrees, whatever rounding makes of theirs. */
static float cosine_of(float degrees) { return degrees < 180 ? cosf(degrees * (PI / 180)) : -2; }

static VkDeviceAddress write_settings(gpu_device *device, const struct coarse_params *params) {
    const fnl_coarse_options *o = &params->options;
    struct gpu_slice slice = gpu_frame_allocate(device, sizeof(struct gpu_coarse_settings));
    if (!slice.data) return 0; /* the device remembers */
    struct gpu_coarse_settings settings = {
        .depth_bound = o->depth_factor * (float)o->size * sqrtf(2),
        .normal_chord = 2 * sinf(o->normal_degrees * (PI / 360)),
        .tolerance = o->tolerance,
        .albedo_tolerance = o->albedo_tolerance,
        .ao_radius = o->ao_radius,
        .gaze = params->gaze,
        .fovea = cosine_of(o->fovea),
        .fovea_far = cosine_of(fmaxf(o->fovea, o->fovea_far)),
        .point = sampler(device, VK_FILTER_NEAREST, VK_SAMPLER_REDUCTION_MODE_WEIGHTED_AVERAGE)};
    if (has_samplers(params)) {
        settings.least = sampler(device, VK_FILTER_LINEAR, VK_SAMPLER_REDUCTION_MODE_MIN);
        settings.greatest = sampler(device, VK_FILTER_LINEAR, VK_SAMPLER_REDUCTION_MODE_MAX);
    }
    *(struct gpu_coarse_settings *)slice.data = settings;
    return slice.address;
}

/* Decides what each block is. */
static void find_blocks(struct graph *graph, struct coarse_data data) {
    graph_add_clear(graph, "coarse clear", GRAPH_QUEUE_GRAPHICS, (struct graph_clear){.buffers = {data.counts, data.words}});
    add_pass(graph, &data, "coarse blocks", &shader_coarse_find_comp, GRAPH_WRITE_COMPUTE, GRAPH_READ_COMPUTE);
    struct gpu_coarse_tiles_push push = {.tile_count = data.groups_x * data.groups_y};
    graph_dispatch(graph, &(struct graph_dispatch){.name = "coarse tiles",
                                                   .pipeline = {.shader = &shader_coarse_tiles_comp},
                                                   .groups = {DIVIDE_UP(push.tile_count, 64)},
                                                   GRAPH_PUSH(push),
                                                   GRAPH_ROWS(graph_changes(&push.blocks, data.blocks),
                                                              graph_changes(&push.counts, data.counts))});
}

static graph_image find_openness(struct graph *graph, const struct shade_input *input, struct coarse_data data) {
    struct graph_image_params image = {
        .name = "coarse ao", .format = VK_FORMAT_R32_SFLOAT, .width = input->width, .height = input->height};
    data.target = graph_create_image(graph, &image);
    data.counters = data.counts;
    data.words = (graph_buffer){0};
    add_pass(graph, &data, "coarse ao", &shader_coarse_ao_comp, GRAPH_READ_COMPUTE, GRAPH_WRITE_COMPUTE);
    return data.target;
}

struct coarse coarse_add(struct graph *graph, gpu_device *device, const struct shade_input *input,
                         const struct coarse_params *params, const struct gbuffer *gbuffer, graph_image radiance) {
    uint32_t side = 8 * params->options.size;
    struct coarse_data data = {.gbuffer = *gbuffer,
                               .settings = write_settings(device, params),
                               .params = *params,
                               .groups_x = DIVIDE_UP(input->width, side),
                               .groups_y = DIVIDE_UP(input->height, side),
                               .counts = graph_create_buffer(graph, "coarse counts", COARSE_COUNTS * 4)};
    data.blocks = graph_create_buffer(graph, "coarse blocks", (uint64_t)data.groups_x * data.groups_y * COARSE_GROUP * 4);
    if (params->words) data.words = graph_create_buffer(graph, "coarse words", (uint64_t)input->width * input->height * 4);
    struct coarse coarse = {.counts = data.counts, .words = data.words};
    data.target = radiance;
    find_blocks(graph, data);
    if (params->options.ao_radius > 0) data.ao = find_openness(graph, input, data);
    data.counts = data.words = (graph_buffer){0};
    data.lighting = input->lighting->address;
    data.bits = input->lighting->bits;
    data.counters = input->counters;
    struct graph_pass *pass =
        add_pass(graph, &data, "coarse", has_fovea(&params->options) ? &shader_coarse_fovea_comp : &shader_coarse_comp, GRAPH_READ_COMPUTE, GRAPH_READ_WRITE_COMPUTE);
    lighting_use(pass, input->lighting, GRAPH_READ_COMPUTE);
    return coarse;
}
