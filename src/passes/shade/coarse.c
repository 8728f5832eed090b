/* SPDX-License-Identifier: MIT */
#include "passes/shade/coarse.h"

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

/* Blocks with a base colour of their own read it from a target; split by the base colour, each pixel has its own. */
static bool has_color(const fnl_coarse_options *o) { return o->bias && o->size > 1 && o->split != FNL_COARSE_SPLIT_ALBEDO; }

static struct gbuffer_extras extras_of(const fnl_coarse_options *o) {
    struct gbuffer_extras e = {.count = 1, .targets = {{"coarse gradient", VK_FORMAT_R16G16_SFLOAT}}};
    float bias = log2f((float)o->size);
    memcpy(&e.constant, &bias, sizeof bias);
    e.fragment = o->criterion == FNL_COARSE_CRITERION_ID       ? &shader_coarse_gbuffer_ids_frag
                 : o->criterion == FNL_COARSE_CRITERION_MINMAX ? &shader_coarse_gbuffer_bounds_frag
                                                               : &shader_coarse_gbuffer_z_frag;
    if (o->criterion == FNL_COARSE_CRITERION_ID) {
        e.targets[0].name = "coarse ids";
        e.targets[0].format = VK_FORMAT_R32G32_UINT;
    }
    if (o->criterion == FNL_COARSE_CRITERION_MINMAX) {
        for (uint32_t i = 0; i < 2; i++) {
            e.targets[e.count].name = i ? "coarse height" : "coarse azimuth";
            e.targets[e.count++].format = BOUND_FORMAT;
        }
    }
    if (has_color(o)) {
        e.targets[e.count].name = "coarse color";
        e.targets[e.count++].format = VK_FORMAT_R8G8B8A8_SRGB;
    }
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
    graph_buffer counts, words, counters;
    VkDeviceAddress lights, settings;
    struct coarse_params params;
    uint32_t kind, width, height;
    const struct gpu_shader *shader;
};

static void execute_clear(const struct graph_context *context, const void *data) {
    const struct coarse_data *d = data;
    gpu_fill_buffer(context->commands, graph_get_buffer(context, d->counts), 0, COARSE_COUNTS * 4, 0);
    if (d->words.id)
        gpu_fill_buffer(context->commands, graph_get_buffer(context, d->words), 0, (uint64_t)d->width * d->height * 4, 0);
}

static uint32_t sampler(gpu_device *device, VkSamplerReductionMode reduction) {
    struct gpu_sampler_params params = {.mag = VK_FILTER_LINEAR,
                                        .min = VK_FILTER_LINEAR,
                                        .mip = VK_SAMPLER_MIPMAP_MODE_NEAREST,
                                        .wrap_u = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                        .wrap_v = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                        .anisotropy = 1,
                                        .reduction = reduction};
    return gpu_sampler_index(device, &params);
}

static void execute_blocks(const struct graph_context *context, const void *data) {
    const struct coarse_data *d = data;
    const fnl_coarse_options *o = &d->params.options;
    bool minmax = o->criterion == FNL_COARSE_CRITERION_MINMAX, samplers = minmax && d->params.samplers && o->size > 1;
    uint32_t flags = (has_color(o) ? COARSE_COLOR : 0) | (o->gather ? COARSE_GATHER : 0) | (d->words.id ? COARSE_WORDS : 0) |
                     (samplers ? COARSE_SAMPLERS : 0) | (d->ao.id ? COARSE_AO : 0);
    struct gpu_compute_params params = {
        .shader = d->shader,
        .constant_count = 10,
        .constants = {d->kind, d->counters.id != 0, 1, 1, o->size, (uint32_t)o->criterion, 0, (uint32_t)o->split, 0, flags}};
    gbuffer_specialise(&d->gbuffer, params.constants, &params.constant_count);
    const graph_image *extras = d->gbuffer.extras;
    struct gpu_coarse_push push = {
        .lights = d->lights,
        .counters = d->counters.id ? graph_address(context, d->counters) : 0,
        .gbuffer = gbuffer_handles(context, &d->gbuffer),
        .settings = d->settings,
        .counts = graph_address(context, d->counts),
        .words = d->words.id ? graph_address(context, d->words) : 0,
        .target = graph_storage(context, d->target),
        .color = has_color(o) ? graph_sampled(context, extras[minmax ? 3 : 1]) : 0,
        .geometry = graph_sampled(context, extras[0]),
        .azimuth = minmax ? graph_sampled(context, extras[1]) : 0,
        .height = minmax ? graph_sampled(context, extras[2]) : 0,
        .ao = d->ao.id ? graph_sampled(context, d->ao) : 0,
        .least = samplers ? sampler(context->device, VK_SAMPLER_REDUCTION_MODE_MIN) : 0,
        .greatest = samplers ? sampler(context->device, VK_SAMPLER_REDUCTION_MODE_MAX) : 0,
    };
    _Static_assert(sizeof push <= GPU_PUSH_BYTES, "it is pushed");
    gpu_bind(context->commands, gpu_compute_pipeline(context->device, &params));
    gpu_push(context->commands, &push, sizeof push);
    uint32_t side = 8 * o->size;
    gpu_dispatch(context->commands, DIVIDE_UP(d->width, side), DIVIDE_UP(d->height, side), 1);
}

/* `clear` empties what the pass `name` counts in; `lit` is NULL where no lights are looked at. */
static void add_blocks(struct graph *graph, const struct coarse_data *data, const struct shade_input *lit, const char *clear,
                       const char *name) {
    struct graph_pass *pass = graph_add_pass(graph, clear, GRAPH_QUEUE_GRAPHICS, execute_clear, data, sizeof *data);
    graph_use_buffer(pass, data->counts, GRAPH_COPY_TO);
    if (data->words.id) graph_use_buffer(pass, data->words, GRAPH_COPY_TO);
    pass = graph_add_pass(graph, name, GRAPH_QUEUE_GRAPHICS, execute_blocks, data, sizeof *data);
    gbuffer_use(pass, &data->gbuffer, GRAPH_SAMPLE_COMPUTE);
    for (uint32_t i = 0; i < GBUFFER_EXTRAS; i++)
        if (data->gbuffer.extras[i].id) graph_use_image(pass, data->gbuffer.extras[i], GRAPH_SAMPLE_COMPUTE);
    if (data->ao.id) graph_use_image(pass, data->ao, GRAPH_SAMPLE_COMPUTE);
    graph_use_buffer(pass, data->counts, GRAPH_READ_WRITE_COMPUTE);
    if (data->words.id) graph_use_buffer(pass, data->words, GRAPH_WRITE_COMPUTE);
    graph_use_image(pass, data->target, lit ? GRAPH_READ_WRITE_COMPUTE : GRAPH_WRITE_COMPUTE);
    if (lit) light_list_use(pass, lit->lights, GRAPH_READ_COMPUTE);
    if (data->counters.id) graph_use_buffer(pass, data->counters, GRAPH_READ_WRITE_COMPUTE);
}

static VkDeviceAddress write_settings(gpu_device *device, const fnl_coarse_options *o) {
    struct gpu_slice slice = gpu_frame_allocate(device, sizeof(struct gpu_coarse_settings));
    if (!slice.data) return 0; /* the device remembers */
    *(struct gpu_coarse_settings *)slice.data =
        (struct gpu_coarse_settings){.depth_bound = o->depth_factor * (float)o->size * sqrtf(2),
                                     .normal_chord = 2 * sinf(o->normal_degrees * (PI / 360)),
                                     .tolerance = o->tolerance,
                                     .albedo_tolerance = o->albedo_tolerance,
                                     .ao_radius = o->ao_radius};
    return slice.address;
}

struct coarse coarse_add(struct graph *graph, gpu_device *device, const struct shade_input *input,
                         const struct coarse_params *params, const struct gbuffer *gbuffer, graph_image radiance) {
    struct coarse coarse = {.counts = graph_create_buffer(graph, "coarse counts", COARSE_COUNTS * 4)};
    struct coarse_data data = {.gbuffer = *gbuffer,
                               .settings = write_settings(device, &params->options),
                               .params = *params,
                               .width = input->width,
                               .height = input->height};
    if (params->options.ao_radius > 0) {
        coarse.ao_counts = graph_create_buffer(graph, "coarse ao counts", COARSE_COUNTS * 4);
        struct graph_image_params image = {
            .name = "coarse ao", .format = VK_FORMAT_R32_SFLOAT, .width = input->width, .height = input->height};
        struct coarse_data ao = data;
        ao.target = graph_create_image(graph, &image);
        ao.counts = coarse.ao_counts;
        ao.shader = &shader_coarse_ao_comp;
        add_blocks(graph, &ao, NULL, "coarse ao clear", "coarse ao");
        data.ao = ao.target;
    }
    if (params->words) coarse.words = graph_create_buffer(graph, "coarse words", (uint64_t)input->width * input->height * 4);
    data.target = radiance;
    data.counts = coarse.counts;
    data.words = coarse.words;
    data.shader = &shader_coarse_comp;
    data.lights = input->lights->header;
    data.kind = input->lights->kind;
    data.counters = input->counters;
    add_blocks(graph, &data, input, "coarse clear", "coarse");
    return coarse;
}
