/* SPDX-License-Identifier: MIT */
#include "passes/shadow/denoise.h"

#include "shaders.h"

/* Like `like`, in another format. */
static graph_image create(struct graph *graph, graph_image like, const char *name, VkFormat format) {
    struct graph_image_params image = graph_image_info(graph, like);
    return graph_create_image(graph, &(struct graph_image_params){.name = name, .format = format, .width = image.width, .height = image.height});
}

static struct graph_history keep(struct graph *graph, graph_image like, const char *name) {
    struct graph_image_params image = graph_image_info(graph, like);
    return graph_history(graph, &(struct graph_image_params){
                                    .name = name, .format = VK_FORMAT_R16G16B16A16_SFLOAT, .width = image.width, .height = image.height});
}

struct shade_apart denoise_begin(struct graph *graph, graph_image radiance) {
    return (struct shade_apart){.open = create(graph, radiance, "open light", graph_image_info(graph, radiance).format),
                                .seen = create(graph, radiance, "seen light", VK_FORMAT_R16G16B16A16_SFLOAT),
                                .drawn = create(graph, radiance, "drawn light", VK_FORMAT_R16G16B16A16_SFLOAT),
                                .field = keep(graph, radiance, "kept light field")};
}

static struct graph_dispatch over(struct graph *graph, graph_image image, const char *name, const struct gpu_shader *shader) {
    const struct graph_image_params info = graph_image_info(graph, image);
    return (struct graph_dispatch){.name = name,
                                   .pipeline = {.shader = shader},
                                   .groups = {DIVIDE_UP(info.width, DENOISE_GROUP), DIVIDE_UP(info.height, DENOISE_GROUP)}};
}

static void run(struct graph *graph, struct graph_dispatch dispatch, const void *push, size_t size, const struct graph_row *rows, uint32_t count) {
    dispatch.push = push;
    dispatch.push_size = size;
    dispatch.rows = rows;
    dispatch.row_count = count;
    graph_dispatch(graph, &dispatch);
}
#define RUN(graph, dispatch, push, ...)                                                                                     \
    run(graph, dispatch, &(push), sizeof(push), (const struct graph_row[]){__VA_ARGS__},                                    \
        (uint32_t)(sizeof((const struct graph_row[]){__VA_ARGS__}) / sizeof(struct graph_row)))

struct denoise denoise_add(struct graph *graph, gpu_device *device, const struct denoise_input *input, graph_image radiance) {
    const struct shade_apart *a = input->apart;
    const VkFormat half = VK_FORMAT_R16G16B16A16_SFLOAT;
    const struct graph_history seen = keep(graph, radiance, "kept seen"), drawn = keep(graph, radiance, "kept drawn"),
                               surface = keep(graph, radiance, "kept surface");
    const bool keeps = input->previous && seen.previous.id && drawn.previous.id && surface.previous.id && a->field.previous.id;
    const bool settled = input->whole || input->still >= DENOISE_SETTLED;
    const graph_image collected = create(graph, radiance, "denoise collected", half), collected_drawn = create(graph, radiance, "denoise drawn", half),
                      guessed = create(graph, radiance, "denoise guessed", half);
    struct denoise d = {.collected = seen.current,
                        .variance = create(graph, radiance, "denoise variance", half),
                        .places = create(graph, radiance, "denoise places", VK_FORMAT_R32G32B32A32_SFLOAT),
                        .counts = graph_create_buffer(graph, "denoise counts", sizeof(struct gpu_denoise_counts))};
    graph_add_clear(graph, "denoise clear", GRAPH_QUEUE_GRAPHICS, (struct graph_clear){.buffers = {d.counts}});

    struct gpu_denoise_collect_push collect = {.view = input->view,
                                               .keeps = keeps,
                                               .still = keeps && input->still > 0,
                                               .longest = (float)(settled ? DENOISE_STILL : DENOISE_FRAMES) - 1};
    if (keeps) {
        struct gpu_slice slice = gpu_frame_allocate(device, sizeof *input->previous);
        if (!slice.data) return d; /* the frame fails */
        memcpy(slice.data, input->previous, sizeof *input->previous);
        collect.previous = slice.address;
    }
    RUN(graph, over(graph, radiance, "denoise collect", &shader_denoise_collect_comp), collect, graph_changes(&collect.counts, d.counts),
        graph_samples(&collect.depth, input->depth), graph_samples(&collect.motion, input->motion), graph_samples(&collect.open, a->open),
        graph_samples(&collect.now_seen, a->seen), graph_samples(&collect.now_drawn, a->drawn), graph_samples(&collect.now_field, a->field.current),
        graph_row_if(keeps, graph_samples(&collect.was_seen, seen.previous)), graph_row_if(keeps, graph_samples(&collect.was_drawn, drawn.previous)),
        graph_row_if(keeps, graph_samples(&collect.was_surface, surface.previous)),
        graph_row_if(keeps, graph_samples(&collect.was_field, a->field.previous)), graph_stores(&collect.seen, collected),
        graph_stores(&collect.drawn, collected_drawn), graph_stores(&collect.surface, surface.current), graph_stores(&collect.places, d.places));

    struct gpu_denoise_verify_push verify = {.view = input->view, .settled = settled};
    RUN(graph, over(graph, radiance, "denoise verify", &shader_denoise_verify_comp), verify, graph_changes(&verify.counts, d.counts),
        graph_samples(&verify.now_seen, a->seen), graph_samples(&verify.now_drawn, a->drawn), graph_samples(&verify.seen, collected),
        graph_samples(&verify.drawn, collected_drawn), graph_samples(&verify.places, d.places), graph_stores(&verify.kept_seen, seen.current),
        graph_stores(&verify.kept_drawn, drawn.current), graph_stores(&verify.to_seen, d.variance),
        graph_stores(&verify.to_drawn, guessed));

    graph_image from_seen = d.variance, from_drawn = guessed;
    for (uint32_t level = 0; level < DENOISE_LEVELS; level++) {
        const bool last = level + 1 == DENOISE_LEVELS;
        struct gpu_denoise_filter_push filter = {.view = input->view, .step = 1u << level};
        struct graph_dispatch dispatch = over(graph, radiance, graph_numbered_name(graph, "denoise filter", level), &shader_denoise_filter_comp);
        dispatch.pipeline.constant_count = 1;
        dispatch.pipeline.constants[0] = last;
        graph_image to_seen = {0}, to_drawn = {0};
        if (!last) {
            to_seen = create(graph, radiance, graph_numbered_name(graph, "denoise filtered seen", level), half);
            to_drawn = create(graph, radiance, graph_numbered_name(graph, "denoise filtered drawn", level), half);
        }
        RUN(graph, dispatch, filter, graph_samples(&filter.seen, from_seen), graph_samples(&filter.drawn, from_drawn),
            graph_samples(&filter.places, d.places), graph_row_if(last, graph_samples(&filter.open, a->open)),
            graph_row_if(last, graph_image_row(&filter.radiance, radiance, GRAPH_READ_WRITE_COMPUTE)),
            graph_row_if(!last, graph_stores(&filter.to_seen, to_seen)), graph_row_if(!last, graph_stores(&filter.to_drawn, to_drawn)));
        from_seen = to_seen;
        from_drawn = to_drawn;
    }
    return d;
}

void denoise_view_add(struct graph *graph, const struct denoise *denoise, bool history, VkDeviceAddress view, graph_image target, bool swap) {
    struct gpu_denoise_view_push push = {.view = view, .history = history, .swap = swap};
    RUN(graph, over(graph, target, "debug view", &shader_denoise_view_comp), push,
        graph_samples(&push.image, history ? denoise->collected : denoise->variance), graph_samples(&push.places, denoise->places),
        graph_stores(&push.target, target));
}
