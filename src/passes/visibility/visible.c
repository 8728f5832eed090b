/* SPDX-License-Identifier: MIT */
#include "passes/visibility/visible.h"

#include "passes/geometry/radix_sort.h"
#include "passes/shade/samples_shared.h"
#include "scene_shared.h"
#include "shaders.h"

struct visible_data {
    struct visibility visibility;
    struct visible_list list;
    graph_image radiance;
    graph_buffer results;
    VkFormat format;
    VkDeviceAddress view, scene;
    uint32_t width, height, samples, material_bits;
    float background[3];
};

static void set_constants(const struct visible_data *d, uint32_t *count, uint32_t *constants) {
    const uint32_t values[15] = {
        [VISIBLE_LISTED_ID] = d->list.listed, [VISIBLE_SAMPLES_ID] = d->samples, [VISIBLE_FLOATS_ID] = d->format == VK_FORMAT_R32G32B32A32_SFLOAT};
    *count = COUNT_OF(values);
    memcpy(constants, values, sizeof values);
}

static uint32_t places_of(const struct visible_data *d) { return DIVIDE_UP(d->width, 8u) * DIVIDE_UP(d->height, 8u) * 64; }

static struct gpu_visible_push push_of(const struct visible_data *d) {
    return (struct gpu_visible_push){.view = d->view,
                                     .scene = d->scene,
                                     .triangle_bits = d->visibility.triangle_bits,
                                     .material_bits = d->material_bits,
                                     .places = places_of(d),
                                     .background = {d->background[0], d->background[1], d->background[2]}};
}

/* ---- lists ---- */

/* A pass over the pixels of the id images. */
static void add_pixels(struct graph *graph, const char *name, const struct visible_data *d,
                       const struct gpu_shader *shader) {
    const bool counts = shader == &shader_visible_count_comp, several = d->samples > 1;
    const enum graph_use use = counts ? GRAPH_WRITE_COMPUTE : GRAPH_READ_COMPUTE;
    const struct visibility *v = &d->visibility;
    struct gpu_compute_params pipeline = {.shader = shader};
    set_constants(d, &pipeline.constant_count, pipeline.constants);
    struct gpu_visible_push push = push_of(d);
    push.ids = push.ids_high = GPU_TEXTURE_NONE;
    graph_dispatch(graph, &(struct graph_dispatch){
                              .name = name,
                              .pipeline = pipeline,
                              .groups = {DIVIDE_UP(d->width, 8u), DIVIDE_UP(d->height, 8u)},
                              GRAPH_PUSH(push),
                              GRAPH_ROWS(graph_row_if(v->ids.id, graph_samples(&push.ids, v->ids)),
                                         graph_row_if(v->ids_high.id, graph_samples(&push.ids_high, v->ids_high)),
                                         graph_buffer_row(&push.sums, d->list.sums, use),
                                         graph_row_if(d->list.words.id, graph_buffer_row(&push.words, d->list.words, use)),
                                         graph_row_if(counts && several, graph_changes(&push.counts, d->list.counts)),
                                         graph_row_if(counts && !several, graph_stores(&push.radiance, d->radiance)),
                                         graph_row_if(!counts, graph_writes(&push.entries, d->list.entries)))});
}

static struct visible_data data_of(struct graph *graph, const struct shade_input *input, graph_image radiance) {
    struct graph_image_params target = graph_image_info(graph, radiance);
    return (struct visible_data){.radiance = radiance,
                                 .format = target.format,
                                 .view = input->view,
                                 .scene = input->scene->scene,
                                 .width = input->width,
                                 .height = input->height,
                                 .samples = MAX(target.samples, 1u),
                                 .background = {input->background[0], input->background[1], input->background[2]}};
}

static void create_counts(struct graph *graph, struct visible_data *data) {
    data->list.sums = graph_create_buffer(graph, "visible places", (places_of(data) + 1ull) * 4);
    if (data->samples == 1) return;
    data->list.words = graph_create_buffer(graph, "visible words", (uint64_t)data->width * data->height * 4);
    data->list.counts = graph_create_buffer(graph, "visible counts", EDGES_COUNTS * 4ull);
    graph_add_clear(graph, "visible clear", GRAPH_QUEUE_GRAPHICS, (struct graph_clear){.buffers = {data->list.counts}});
}

/* Of the classes that some material has: sorting takes a pass for four bits. */
static uint32_t class_bits(uint32_t classes) {
    _Static_assert(GPU_CLASSES == 32, "five bits");
    return classes >> 16 ? 5 : 4;
}

/* Sums up what has been counted, and lists it. */
static void add_entries(struct graph *graph, struct visible_data *data) {
    uint32_t places = places_of(data);
    bool sorts = data->list.listed == VISIBLE_SORTED;
    prefix_sum_add(graph, "visible", GRAPH_QUEUE_GRAPHICS, data->list.sums, places + 1);
    data->list.entries = graph_create_buffer(graph, "visible entries", (uint64_t)data->list.capacity * (sorts ? 8 : 4));
    add_pixels(graph, "visible fill", data, &shader_visible_fill_comp);
    if (sorts)
        data->list.entries = radix_sort_add(graph, &(struct radix_sort_params){.what = "visible",
                                                                               .queue = GRAPH_QUEUE_GRAPHICS,
                                                                               .pairs = data->list.entries,
                                                                               .capacity = data->list.capacity,
                                                                               .bits = class_bits(data->list.classes) + data->material_bits,
                                                                               .count = data->list.sums,
                                                                               .count_offset = places * 4ull});
    data->list.ranges = graph_create_buffer(graph, "visible ranges", GPU_CLASSES * 8ull);
    data->list.dispatches = graph_create_buffer(graph, "visible dispatches", GPU_CLASSES * 12ull);
    struct gpu_compute_params pipeline = {.shader = &shader_visible_ranges_comp};
    set_constants(data, &pipeline.constant_count, pipeline.constants);
    struct gpu_visible_push push = push_of(data);
    graph_dispatch(graph, &(struct graph_dispatch){.name = "visible ranges",
                                                   .pipeline = pipeline,
                                                   .groups = {1},
                                                   GRAPH_PUSH(push),
                                                   GRAPH_ROWS(graph_reads(&push.sums, data->list.sums),
                                                              graph_reads(&push.entries, data->list.entries),
                                                              graph_writes(&push.ranges, data->list.ranges),
                                                              graph_writes(&push.dispatches, data->list.dispatches))});
}

struct visible_list visible_list_add(struct graph *graph, const struct shade_input *input,
                                     const struct visibility *visibility, enum visibility_sort sort, graph_image radiance) {
    struct visible_data data = data_of(graph, input, radiance);
    data.visibility = *visibility;
    uint64_t capacity = (uint64_t)input->width * input->height * data.samples;
    bool sorts = sort != VISIBILITY_SORT_OFF && capacity < 1u << 31; /* what radix_sort_add takes */
    data.list.classes = sorts ? input->scene->material_classes : 1;
    if (sort == VISIBILITY_SORT_MATERIAL) {
        while ((input->scene->material_count - 1) >> data.material_bits) data.material_bits++;
        data.material_bits = MIN(data.material_bits, 32 - class_bits(data.list.classes));
    }
    data.list.capacity = (uint32_t)capacity;
    data.list.listed = sorts ? VISIBLE_SORTED : VISIBLE_LIST;
    create_counts(graph, &data);
    add_pixels(graph, "visible count", &data, &shader_visible_count_comp);
    add_entries(graph, &data);
    return data.list;
}

struct visible_list visible_surfaces_begin(struct graph *graph, const struct shade_input *input, graph_image radiance) {
    struct visible_data data = data_of(graph, input, radiance);
    data.list.capacity = input->width * input->height * data.samples;
    data.list.listed = VISIBLE_LIST;
    data.list.classes = 1;
    create_counts(graph, &data);
    return data.list;
}

void visible_surfaces_end(struct graph *graph, const struct shade_input *input, graph_image radiance,
                          struct visible_list *list) {
    struct visible_data data = data_of(graph, input, radiance);
    data.list = *list;
    add_entries(graph, &data);
    *list = data.list;
}

/* ---- spreading ---- */

static void execute_spread(const struct graph_context *context, const void *data) {
    const struct visible_data *d = data;
    struct gpu_graphics_params params = {.vertex = &shader_deferred_msaa_spread_vert,
                                         .fragment = &shader_visible_spread_frag,
                                         .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST,
                                         .color_count = 1,
                                         .color_formats = {d->format},
                                         .samples = d->samples};
    set_constants(d, &params.constant_count, params.constants);
    struct gpu_visible_push push = push_of(d);
    push.words = graph_address(context, d->list.words);
    push.sums = graph_address(context, d->list.sums);
    push.results = graph_address(context, d->results);
    gpu_bind(context->commands, gpu_graphics_pipeline(context->device, &params));
    gpu_push(context->commands, &push, sizeof push);
    gpu_draw(context->commands, 3, d->samples, 0, 0);
}

void visible_spread_add(struct graph *graph, const struct shade_input *input, const struct visible_list *list,
                        graph_buffer results, graph_image radiance) {
    struct visible_data data = data_of(graph, input, radiance);
    data.list = *list;
    data.results = results;
    struct graph_pass *pass =
        graph_add_pass(graph, "visible spread", GRAPH_QUEUE_GRAPHICS, execute_spread, &data, sizeof data);
    graph_use_buffer(pass, list->words, GRAPH_READ_FRAGMENT);
    graph_use_buffer(pass, list->sums, GRAPH_READ_FRAGMENT);
    graph_use_buffer(pass, results, GRAPH_READ_FRAGMENT);
    graph_color(pass, radiance, VK_ATTACHMENT_LOAD_OP_CLEAR, input->background);
}
