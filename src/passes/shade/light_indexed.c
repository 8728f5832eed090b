/* SPDX-License-Identifier: MIT */
#include "passes/shade/light_indexed.h"

#include "passes/shade/light_indexed_samples_shared.h"
#include "passes/shade/light_sets.h"
#include "shaders.h"

struct indexed_data {
    struct volumes volumes;
    VkDeviceAddress view;
    graph_image depth, attached, first; /* what is read of the surfaces, and what the depth test is against */
    graph_buffer counts, slots;
    VkDeviceAddress sets;
    uint32_t packing, capacity, batch, layers, step, samples;
    uint32_t width, height;
};

#define STENCIL_FORMAT VK_FORMAT_S8_UINT

bool light_indexed_stencil_supported(const gpu_device *device) {
    return gpu_format_supports(device, STENCIL_FORMAT, VK_FORMAT_FEATURE_2_DEPTH_STENCIL_ATTACHMENT_BIT);
}

/* The stencil counts down with each light that reaches the pixel. It begins one higher each time, so that the next light is the one that finds 1. */
static void draw_by_stencil(const struct graph_context *context, const struct indexed_data *d, struct gpu_graphics_params *state,
                            struct gpu_indexed_push push) {
    state->fragment = &shader_light_indexed_late_frag;
    state->depth_format = STENCIL_FORMAT;
    state->stencil = (struct gpu_stencil){.test = 1, .compare = VK_COMPARE_OP_EQUAL, .pass = VK_STENCIL_OP_DECREMENT_AND_CLAMP, .reference = 1, .fail = VK_STENCIL_OP_DECREMENT_AND_CLAMP};
    for (push.step = 0; push.step < INDEXED_LAYER_LIGHTS; push.step++) {
        gpu_clear_stencil(context->commands, d->width, d->height, push.step + 1);
        volumes_draw(context, &d->volumes, state, &push.head, sizeof push);
    }
}

static void execute_ids(const struct graph_context *context, const void *data) {
    const struct indexed_data *d = data;
    bool images = d->packing != INDEXED_IDS;
    struct gpu_graphics_params state = {.fragment = &shader_light_indexed_frag,
                                        .constant_count = 15,
                                        .constants = {[LIGHTING_ID] = d->volumes.lighting.bits, [SAMPLES_ID] = d->samples, [INDEXED_PACKING_ID] = d->packing, [INDEXED_STEP_ID] = d->step},
                                        .color_count = images,
                                        .color_formats = {images ? VK_FORMAT_R8G8B8A8_UNORM : VK_FORMAT_UNDEFINED},
                                        .blends = {d->packing == INDEXED_SHIFT ? GPU_BLEND_QUARTER
                                                   : images                    ? GPU_BLEND_MAX
                                                                               : GPU_BLEND_NONE}};
    struct gpu_indexed_push push = {.head = {.view = d->view},
                                    .counts = graph_address(context, d->counts),
                                    .slots = d->slots.id ? graph_address(context, d->slots) : 0,
                                    .depth = graph_sampled(context, d->depth),
                                    .capacity = d->capacity,
                                    .batch = d->batch,
                                    .layers = d->layers,
                                    .sets = d->sets,
                                    .first = d->first.id ? graph_sampled(context, d->first) : 0};
    if (d->packing == INDEXED_STENCIL)
        draw_by_stencil(context, d, &state, push);
    else
        volumes_draw(context, &d->volumes, &state, &push.head, sizeof push);
}

static void add_ids(struct graph *graph, const char *name, const struct indexed_data *data, graph_image target,
                    VkAttachmentLoadOp load) {
    struct graph_pass *pass = graph_add_pass(graph, name, GRAPH_QUEUE_GRAPHICS, execute_ids, data, sizeof *data);
    volumes_use(pass, &data->volumes);
    graph_use_image(pass, data->depth, GRAPH_SAMPLE_FRAGMENT);
    graph_use_buffer(pass, data->counts, GRAPH_READ_WRITE_FRAGMENT);
    if (data->slots.id) graph_use_buffer(pass, data->slots, GRAPH_READ_WRITE_FRAGMENT);
    if (data->first.id) graph_use_image(pass, data->first, GRAPH_SAMPLE_FRAGMENT);
    static const float zero[4];
    if (target.id) graph_color(pass, target, load, zero);
    if (data->packing == INDEXED_STENCIL)
        graph_depth(pass, data->attached, VK_ATTACHMENT_LOAD_OP_CLEAR, 0);
    else
        graph_depth_read_only(pass, data->attached);
}

/* The two tables of the sets: of each light its set and place, whose address goes to `codes`, and the lights in them. */
static struct gpu_slice send_sets(gpu_device *device, uint32_t count, const struct indexed_params *params, uint32_t layers, VkDeviceAddress *codes,
                                  uint32_t *without) {
    const uint32_t member_count = layers * INDEXED_LAYER_LIGHTS << 8;
    const fnl_host *host = gpu_host(device);
    struct gpu_slice slice = gpu_frame_allocate(device, (count + member_count) * sizeof(uint32_t));
    uint32_t *found = slice.data ? host_allocate_zero(host, (count + member_count) * sizeof(uint32_t)) : NULL;
    if (!found) return (struct gpu_slice){0};
    const struct light_sets_input input = {.bounds = params->bounds, .count = count, .planes = params->planes, .plane_count = params->plane_count, .set_count = layers * INDEXED_LAYER_LIGHTS};
    *without = light_sets_find(&input, found + member_count, found);
    memcpy(slice.data, found, (count + member_count) * sizeof(uint32_t));
    host_free(host, found, (count + member_count) * sizeof(uint32_t));
    *codes = slice.address + member_count * sizeof(uint32_t);
    return slice;
}

struct lighting light_indexed_add(struct graph *graph, gpu_device *device, const struct shade_input *input,
                                    const struct volumes *volumes, const struct lighting *scopes, graph_image depth,
                                    const struct indexed_params *params, struct indexed_samples *samples) {
    const uint64_t pixels = (uint64_t)input->width * input->height;
    bool images = params->packing != INDEXED_IDS;
    const bool sets = params->packing == INDEXED_SETS_PACKING;
    /* No more layers than lights could fill. */
    uint32_t layers = images ? MIN(params->layers, MAX(DIVIDE_UP(scopes->lights.local_count, sets ? INDEXED_LAYER_LIGHTS : INDEXED_BATCH), 1u)) : params->layers;
    uint32_t capacity = layers * INDEXED_LAYER_LIGHTS;
    uint64_t count_bytes = pixels * 4 * (images ? layers : 1), slot_bytes = images ? 0 : pixels * (capacity + 1) / 2 * 4;
    graph_buffer counts = graph_create_buffer(graph, "light id counts", count_bytes), slots = {0};
    if (!images) slots = graph_create_buffer(graph, "light id slots", slot_bytes);
    graph_add_clear(graph, "clear light ids", GRAPH_QUEUE_GRAPHICS, (struct graph_clear){.buffers = {counts, slots}});

    graph_image id_images[INDEXED_LAYERS] = {{0}};
    const uint32_t sample_count = MAX(graph_image_info(graph, depth).samples, 1u);
    if (sample_count > 1) samples->bounds = sample_bounds_add(graph, input, depth);
    struct indexed_data ids = {.volumes = *volumes,
                               .view = input->view,
                               .depth = sample_count > 1 ? samples->bounds.ranges : depth,
                               .attached = sample_count > 1 ? samples->bounds.nearest : depth,
                               .samples = sample_count,
                               .counts = counts,
                               .slots = slots,
                               .packing = params->packing,
                               .capacity = capacity,
                               .layers = layers,
                               .width = input->width,
                               .height = input->height};
    const struct gpu_slice members = sets ? send_sets(device, scopes->lights.local_count, params, layers, &ids.sets, &samples->without_set) : (struct gpu_slice){0};
    if (params->packing == INDEXED_STENCIL)
        ids.attached = graph_create_image(
            graph, &(struct graph_image_params){
                       .name = "light id stencil", .format = STENCIL_FORMAT, .width = input->width, .height = input->height});
    struct graph_image_params image = {
        .name = "light ids", .format = VK_FORMAT_R8G8B8A8_UNORM, .width = input->width, .height = input->height};
    if (!images) add_ids(graph, "light ids", &ids, (graph_image){0}, VK_ATTACHMENT_LOAD_OP_LOAD);
    for (uint32_t i = 0; images && i < layers; i++) {
        const char *name = graph_numbered_name(graph, "light ids", i),
                   *again = graph_numbered_name(graph, "light ids again", i);
        image.name = name;
        id_images[i] = graph_create_image(graph, &image);
        ids.batch = i;
        graph_image first = {0};
        if (params->packing == INDEXED_MAX) { /* what the second step reads, it cannot write: that is another image */
            image.name = again;
            first = graph_create_image(graph, &image);
            add_ids(graph, again, &ids, first, VK_ATTACHMENT_LOAD_OP_CLEAR);
            ids.first = first;
            ids.step = 1;
        }
        add_ids(graph, name, &ids, id_images[i], VK_ATTACHMENT_LOAD_OP_CLEAR);
        ids.first = (graph_image){0};
        ids.step = 0;
    }

    struct light_list out = {.kind = GPU_LIST_TILES,
                             .lights = scopes->lights.buffer,
                             .cell_count = (uint32_t)pixels,
                             .byte_count = pixels * (sizeof(struct gpu_cell) + 4ull * capacity) + count_bytes + slot_bytes +
                                           (images ? pixels * 4 * layers : 0),
                             .totals = volumes->totals};
    out.fixed_bytes = out.byte_count;
    graph_buffer cells = graph_create_buffer(graph, "light id cells", (pixels + 1) * sizeof(struct gpu_cell));
    graph_buffer lists = graph_create_buffer(graph, "light id lists", pixels * capacity * 4);
    const struct light_input lights = lighting_input(scopes);
    struct gpu_light_list *header = light_list_header(device, &lights, &out.header);
    if (header) {
        header->tiles_x = input->width;
        header->tiles_y = input->height;
        graph_put_address(graph, &header->cells, cells);
        graph_put_address(graph, &header->ids, lists);
    }
    struct light_list all_lights = {0};
    struct gpu_light_list *all = sample_count > 1 ? light_list_header(device, &lights, &all_lights.header) : NULL;
    if (all) { /* the last cell, which has all lights */
        graph_put_address_at(graph, &all->cells, cells, pixels * sizeof(struct gpu_cell));
        graph_put_address(graph, &all->ids, lists);
    }
    if (sample_count > 1) samples->all = lighting_add(graph, device, scopes, &all_lights).address;
    out.cells = cells;
    out.ids = lists;
    struct gpu_indexed_list_push push = {.view = input->view, .slots = members.address, .layers = layers};
    struct graph_pass *pass = graph_dispatch(
        graph, &(struct graph_dispatch){.name = "light id lists",
                                        .pipeline = {&shader_light_indexed_list_comp, 3, {[2] = params->packing}},
                                        .groups = {DIVIDE_UP(input->width, 8u), DIVIDE_UP(input->height, 8u)},
                                        GRAPH_PUSH(push),
                                        GRAPH_ROWS(graph_reads(&push.ids, volumes->ids), graph_reads(&push.counts, counts),
                                                   graph_row_if(slots.id, graph_reads(&push.slots, slots)),
                                                   graph_writes(&push.cells, cells), graph_writes(&push.list, lists),
                                                   graph_changes(&push.totals, volumes->totals))});
    for (uint32_t i = 0; i < INDEXED_LAYERS && id_images[i].id; i++)
        graph_add_row(pass, graph_samples(&push.images[i], id_images[i]));
    return lighting_add(graph, device, scopes, &out);
}

/* ---- shading of several samples ---- */

struct samples_data {
    const struct geometry_scene *scene;
    struct geometry_draws draws;
    struct indexed_samples samples;
    VkDeviceAddress view, lighting;
    graph_buffer counters;
    struct gpu_graphics_params state;
};

static void execute_samples(const struct graph_context *context, const void *data) {
    const struct samples_data *d = data;
    struct gpu_indexed_samples_push push = {
        .geometry = {.view = d->view,
                     .lighting = d->lighting,
                     .counters = d->counters.id ? graph_address(context, d->counters) : 0},
        .all = d->samples.all,
        .ranges = graph_sampled(context, d->samples.bounds.ranges)};
    geometry_draw_with(context, d->scene, &d->draws, GEOMETRY_OPAQUE, &d->state, NULL, &push.geometry, sizeof push);
}

void light_indexed_samples_add(struct graph *graph, const struct shade_input *input, const struct indexed_samples *samples,
                               graph_image radiance, graph_image depth) {
    struct graph_image_params target = graph_image_info(graph, radiance);
    struct samples_data data = {.scene = input->scene,
                                .draws = *input->draws,
                                .samples = *samples,
                                .view = input->view,
                                .lighting = input->lighting->address,
                                .counters = input->counters};
    data.state = (struct gpu_graphics_params){.fragment = &shader_light_indexed_samples_frag,
                                              .constant_count = 2,
                                              .constants = {[LIGHTING_ID] = input->lighting->bits, [COUNT_LIGHTS_ID] = input->counters.id != 0},
                                              .color_count = 1,
                                              .color_formats = {target.format},
                                              .depth_format = GEOMETRY_DEPTH_FORMAT,
                                              .depth_test = true,
                                              .depth_compare = VK_COMPARE_OP_EQUAL,
                                              .samples = target.samples};
    struct graph_pass *pass = graph_add_pass(graph, "forward", GRAPH_QUEUE_GRAPHICS, execute_samples, &data, sizeof data);
    geometry_use(pass, input->scene, input->draws, GEOMETRY_OPAQUE);
    lighting_use(pass, input->lighting, GRAPH_READ_FRAGMENT);
    graph_use_image(pass, samples->bounds.ranges, GRAPH_SAMPLE_FRAGMENT);
    if (input->counters.id) graph_use_buffer(pass, input->counters, GRAPH_READ_WRITE_FRAGMENT);
    graph_color(pass, radiance, VK_ATTACHMENT_LOAD_OP_CLEAR, input->background);
    graph_depth_read_only(pass, depth);
}
