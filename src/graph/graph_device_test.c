/* SPDX-License-Identifier: MIT */
/** Graphs that run on a device, with validation and synchronisation validation. */
#include "base/jobs.h"
#include "graph/graph_internal.h"
#include "shaders.h"
#include "tests/graph_world.h"

#include <sched.h>
#include <stdatomic.h>

enum { WIDTH = 37, HEIGHT = 21, PIXELS = WIDTH * HEIGHT, STEPS = 6, BYTES = PIXELS * 4 };
enum mode { FILL, TO_IMAGE, STEP, TO_BUFFER, ADD };

static atomic_llong allocation_count;
static char logged[4096];

static void *count_allocations(void *user, void *old, size_t old_size, size_t new_size) {
    UNUSED(user);
    UNUSED(old_size);
    if (new_size == 0) {
        free(old);
        return NULL;
    }
    atomic_fetch_add(&allocation_count, 1);
    return realloc(old, new_size);
}

static void keep_log(void *user, fnl_log_level level, const char *line) {
    UNUSED(user);
    if (level < FNL_LOG_WARNING) return;
    if (strncmp(line, "validation", 10) == 0) print_error("%s\n", line);
    size_t length = strlen(logged);
    snprintf(logged + length, sizeof logged - length, "%s\n", line);
}

/* ---- one device and graph for each test ---- */

struct world {
    struct graph_world base;
    graph_buffer output; /* of this frame */
    graph_image images[STEPS + 1];
};

static int set_up(void **state) {
    static struct world world;
    memset(&world, 0, sizeof world);
    logged[0] = 0;
    fnl_host host = fnl_host_default();
    host.reallocate = count_allocations;
    host.log = keep_log;
    host.thread_count = 4;
    graph_world_open(&world.base, &host, 2 * BYTES);
    *state = &world;
    return 0;
}

static int tear_down(void **state) {
    struct world *world = *state;
    graph_world_close(&world->base);
    return 0;
}

/* ---- passes ---- */

struct dispatch {
    enum mode mode;
    graph_buffer from, to;
    graph_image from_image, to_image;
    float value;
};

struct push {
    uint64_t from, to;
    uint32_t from_image, to_image, width, count;
    float value;
};

static void add_dispatch(struct graph *graph, const char *name, enum graph_queue queue, const struct dispatch *d) {
    struct push push = {.width = WIDTH, .count = PIXELS, .value = d->value};
    enum graph_use write = d->mode == ADD ? GRAPH_READ_WRITE_COMPUTE : GRAPH_WRITE_COMPUTE;
    graph_dispatch(graph,
                   &(struct graph_dispatch){.name = name,
                                            .queue = queue,
                                            .pipeline = {&shader_graph_test_comp, 1, {d->mode}},
                                            .groups = {DIVIDE_UP(PIXELS, 64)},
                                            GRAPH_PUSH(push),
                                            GRAPH_ROWS(graph_row_if(d->from.id, graph_reads(&push.from, d->from)),
                                                       graph_row_if(d->to.id, graph_buffer_row(&push.to, d->to, write)),
                                                       graph_row_if(d->from_image.id, graph_samples(&push.from_image, d->from_image)),
                                                       graph_row_if(d->to_image.id, graph_image_row(&push.to_image, d->to_image, write)))});
}

struct draw {
    bool shades, tests_depth;
    uint32_t samples, mode;
    graph_image first, second;
};

static void execute_draw(const struct graph_context *context, const void *data) {
    const struct draw *draw = data;
    struct gpu_graphics_params params;
    memset(&params, 0, sizeof params);
    params.vertex = &shader_graph_test_vert;
    params.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
    params.samples = draw->samples;
    params.constant_count = 1;
    params.constants[0] = draw->mode;
    if (draw->shades) {
        params.fragment = &shader_graph_test_frag;
        params.color_count = 1;
        params.color_formats[0] = VK_FORMAT_R32_SFLOAT;
    }
    if (draw->tests_depth || !draw->shades) {
        params.depth_format = VK_FORMAT_D32_SFLOAT;
        params.depth_test = true;
        params.depth_write = !draw->shades;
        params.depth_compare = VK_COMPARE_OP_GREATER_OR_EQUAL;
    }
    gpu_bind(context->commands, gpu_graphics_pipeline(context->device, &params));
    if (draw->shades) {
        uint32_t push[2] = {graph_sampled(context, draw->first), draw->second.id ? graph_sampled(context, draw->second) : 0};
        gpu_push(context->commands, push, sizeof push);
    }
    gpu_draw(context->commands, 3, 1, 0, 0);
}

struct copy {
    graph_buffer output, readback;
    graph_image lit;
};

static void execute_copy(const struct graph_context *context, const void *data) {
    const struct copy *copy = data;
    const struct gpu_buffer *readback = graph_get_buffer(context, copy->readback);
    gpu_copy_buffer(context->commands, graph_get_buffer(context, copy->output), 0, readback, 0, BYTES);
    if (copy->lit.id) gpu_copy_image_to_buffer(context->commands, graph_get_image(context, copy->lit), readback, BYTES);
}

static graph_image float_image(struct graph *graph, const char *name, uint32_t samples) {
    return graph_create_image(
        graph, &(struct graph_image_params){
                   .name = name, .format = VK_FORMAT_R32_SFLOAT, .width = WIDTH, .height = HEIGHT, .samples = samples});
}

static void add_copy(struct world *world, graph_buffer output, graph_image lit) {
    struct copy copy = {output, graph_import_buffer(world->base.graph, "readback", &world->base.readback), lit};
    struct graph_pass *pass = graph_add_pass(world->base.graph, "copy", GRAPH_QUEUE_GRAPHICS, execute_copy, &copy, sizeof copy);
    graph_use_buffer(pass, output, GRAPH_COPY_FROM);
    if (lit.id) graph_use_image(pass, lit, GRAPH_COPY_FROM);
    graph_use_buffer(pass, copy.readback, GRAPH_COPY_TO);
    graph_use_buffer(pass, copy.readback, GRAPH_READ_HOST);
}

/* Numbers, through a buffer, a chain of images that alias each other, a resolve and two draws, to the host. */
static const char *const pass_names[] = {"fill",   "to image", "step 1", "step 2", "step 3", "step 4", "step 5",
                                         "step 6", "prepass",  "draw",   "light",  "gather", "copy"};

static void declare_all(struct world *world, float seed) {
    struct graph *graph = world->base.graph;
    static const char *const image_names[STEPS + 1] = {"image 0", "image 1", "image 2", "image 3",
                                                       "image 4", "image 5", "image 6"};
    graph_begin(graph);
    graph_buffer input = graph_create_buffer(graph, "input", BYTES), output = graph_create_buffer(graph, "output", BYTES);
    for (uint32_t i = 0; i <= STEPS; i++) world->images[i] = float_image(graph, image_names[i], 1);
    graph_image color = float_image(graph, "color 4x", 4), resolved = float_image(graph, "resolved", 1),
                lit = float_image(graph, "lit", 1);
    graph_image depth = graph_create_image(
        graph,
        &(struct graph_image_params){.name = "depth", .format = VK_FORMAT_D32_SFLOAT, .width = WIDTH, .height = HEIGHT});

    add_dispatch(graph, "fill", GRAPH_QUEUE_GRAPHICS, &(struct dispatch){.mode = FILL, .to = input, .value = seed});
    add_dispatch(graph, "to image", GRAPH_QUEUE_ASYNC,
                 &(struct dispatch){.mode = TO_IMAGE, .from = input, .to_image = world->images[0]});
    for (uint32_t i = 1; i <= STEPS; i++)
        add_dispatch(graph, pass_names[i + 1], i % 3 == 0 ? GRAPH_QUEUE_ASYNC : GRAPH_QUEUE_GRAPHICS,
                     &(struct dispatch){
                         .mode = STEP, .from_image = world->images[i - 1], .to_image = world->images[i], .value = (float)i});

    struct draw prepass = {.samples = 1}, draw = {.shades = true, .samples = 4, .first = world->images[STEPS]};
    struct draw light = {.shades = true, .tests_depth = true, .samples = 1, .mode = 1, .first = resolved, .second = depth};
    struct graph_pass *pass = graph_add_pass(graph, "prepass", GRAPH_QUEUE_GRAPHICS, execute_draw, &prepass, sizeof prepass);
    graph_depth(pass, depth, VK_ATTACHMENT_LOAD_OP_CLEAR, 0);
    pass = graph_add_pass(graph, "draw", GRAPH_QUEUE_GRAPHICS, execute_draw, &draw, sizeof draw);
    graph_use_image(pass, world->images[STEPS], GRAPH_SAMPLE_FRAGMENT);
    graph_color(pass, color, VK_ATTACHMENT_LOAD_OP_CLEAR, (float[4]){7, 7, 7, 7});
    graph_resolve(pass, 0, resolved);
    pass = graph_add_pass(graph, "light", GRAPH_QUEUE_GRAPHICS, execute_draw, &light, sizeof light);
    graph_use_image(pass, resolved, GRAPH_SAMPLE_FRAGMENT);
    graph_use_image(pass, depth, GRAPH_SAMPLE_FRAGMENT);
    graph_depth_read_only(pass, depth);
    graph_color(pass, lit, VK_ATTACHMENT_LOAD_OP_DONT_CARE, NULL);
    add_dispatch(graph, "gather", GRAPH_QUEUE_ASYNC, &(struct dispatch){.mode = TO_BUFFER, .from_image = lit, .to = output});
    add_copy(world, output, lit);
}

static void run(struct world *world, const struct graph_execute_params *params) {
    assert_int_equal(graph_compile(world->base.graph), FNL_OK);
    assert_int_equal(gpu_frame_begin(world->base.device), FNL_OK);
    assert_int_equal(graph_execute_frame(world->base.graph, params), FNL_OK);
}

static void check_all(struct world *world, float seed) {
    assert_int_equal(gpu_frame_wait(world->base.device, gpu_frame_number(world->base.device)), FNL_OK);
    const float *found = world->base.readback.mapped;
    for (uint32_t i = 0; i < PIXELS; i++) {
        float expected = (float)i + seed;
        for (uint32_t step = 1; step <= STEPS; step++) expected = expected * 2 + (float)step;
        expected += 0.5f + 0.5f + 0.25f;
        if (found[i] != expected || found[PIXELS + i] != expected)
            fail_msg("pixel %u is %g and %g, not %g", i, (double)found[i], (double)found[PIXELS + i], (double)expected);
    }
    memset(world->base.readback.mapped, 0xff, 2 * BYTES);
}

/* ---- tests ---- */

static void test_results_are_right_with_aliasing(void **state) {
    struct world *world = *state;
    for (uint32_t frame = 0; frame < 5; frame++) {
        declare_all(world, (float)frame);
        run(world, NULL);
        check_all(world, (float)frame);
    }
    struct graph_stats stats = graph_query_stats(world->base.graph);
    assert_int_equal(stats.pass_count, COUNT_OF(pass_names));
    assert_true(4 * stats.transient_bytes < 3 * stats.transient_bytes_unaliased);
}

static void test_batches_of_the_compute_queue(void **state) {
    struct world *world = *state;
    for (uint32_t frame = 0; frame < 5; frame++) {
        declare_all(world, (float)frame);
        run(world,
            &(struct graph_execute_params){.force_async_on_graphics = true, .timers = true, .record_threads = 1 + frame});
        assert_true(graph_query_stats(world->base.graph).batch_count >= 8);
        check_all(world, (float)frame);
    }
}

static void test_frames_in_flight_do_not_disturb_each_other(void **state) {
    struct world *world = *state;
    for (uint32_t frame = 0; frame < 12; frame++) {
        declare_all(world, (float)frame);
        run(world, &(struct graph_execute_params){.force_async_on_graphics = frame % 2});
    }
    check_all(world, 11);
}

static void test_threads_do_not_change_the_bytes(void **state) {
    struct world *world = *state;
    static char first[2 * BYTES];
    for (uint32_t threads = 1; threads <= 20; threads += threads < 4 ? 1 : 8) {
        declare_all(world, 3);
        run(world, &(struct graph_execute_params){.record_threads = threads});
        assert_int_equal(gpu_frame_wait(world->base.device, gpu_frame_number(world->base.device)), FNL_OK);
        if (threads == 1) memcpy(first, world->base.readback.mapped, sizeof first);
        assert_memory_equal(first, world->base.readback.mapped, sizeof first);
        check_all(world, 3);
    }
}

static void test_history_goes_back_and_forth(void **state) {
    struct world *world = *state;
    struct graph *graph = world->base.graph;
    struct graph_image_params params = {.name = "history", .format = VK_FORMAT_R32_SFLOAT, .width = WIDTH, .height = HEIGHT};
    float expected = 0;
    for (uint32_t frame = 0; frame < 9; frame++) {
        graph_begin(graph);
        struct graph_history history = graph_history(graph, &params);
        graph_buffer buffer = graph_create_buffer(graph, "buffer", BYTES);
        assert_int_equal(history.previous.id != 0, frame != 0 && frame != 6);
        if (history.previous.id) {
            add_dispatch(
                graph, "step", GRAPH_QUEUE_GRAPHICS,
                &(struct dispatch){.mode = STEP, .from_image = history.previous, .to_image = history.current, .value = 1});
            expected = expected * 2 + 1;
        } else {
            add_dispatch(graph, "fill", GRAPH_QUEUE_GRAPHICS,
                         &(struct dispatch){.mode = FILL, .to = buffer, .value = (float)frame});
            add_dispatch(graph, "start", GRAPH_QUEUE_GRAPHICS,
                         &(struct dispatch){.mode = TO_IMAGE, .from = buffer, .to_image = history.current});
            expected = (float)frame;
        }
        add_dispatch(graph, "gather", GRAPH_QUEUE_GRAPHICS,
                     &(struct dispatch){.mode = TO_BUFFER, .from_image = history.current, .to = buffer});
        add_copy(world, buffer, (graph_image){0});
        run(world, NULL);
        assert_int_equal(gpu_frame_wait(world->base.device, gpu_frame_number(world->base.device)), FNL_OK);
        assert_true(((const float *)world->base.readback.mapped)[0] == expected);
        if (frame == 5) {
            /* A frame without it loses the contents. */
            declare_all(world, 1);
            run(world, NULL);
            check_all(world, 1);
        }
    }
}

static void test_imported_images_keep_their_contents(void **state) {
    struct world *world = *state;
    struct graph *graph = world->base.graph;
    struct gpu_image image;
    struct gpu_image_params params = {.name = "imported",
                                      .format = VK_FORMAT_R32_SFLOAT,
                                      .width = WIDTH,
                                      .height = HEIGHT,
                                      .layers = 1,
                                      .mips = 1,
                                      .samples = 1,
                                      .usage = VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_SAMPLED_BIT};
    assert_int_equal(gpu_image_create(world->base.device, &params, &image), FNL_OK);
    for (uint32_t frame = 0; frame < 4; frame++) {
        graph_begin(graph);
        graph_buffer buffer = graph_create_buffer(graph, "buffer", BYTES);
        graph_image imported =
            graph_import_image(graph, &image, frame ? VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL : VK_IMAGE_LAYOUT_UNDEFINED,
                               VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
        if (frame == 0) {
            add_dispatch(graph, "fill", GRAPH_QUEUE_GRAPHICS, &(struct dispatch){.mode = FILL, .to = buffer});
            add_dispatch(graph, "start", GRAPH_QUEUE_GRAPHICS,
                         &(struct dispatch){.mode = TO_IMAGE, .from = buffer, .to_image = imported});
        } else
            add_dispatch(graph, "add", GRAPH_QUEUE_ASYNC,
                         &(struct dispatch){.mode = ADD, .to_image = imported, .value = 10});
        add_dispatch(graph, "gather", GRAPH_QUEUE_GRAPHICS,
                     &(struct dispatch){.mode = TO_BUFFER, .from_image = imported, .to = buffer});
        add_copy(world, buffer, (graph_image){0});
        run(world, NULL);
    }
    assert_int_equal(gpu_frame_wait(world->base.device, gpu_frame_number(world->base.device)), FNL_OK);
    for (uint32_t i = 0; i < PIXELS; i++) assert_true(((const float *)world->base.readback.mapped)[i] == (float)i + 30);
    gpu_image_destroy(world->base.device, &image);
}

static void test_timers(void **state) {
    struct world *world = *state;
    const struct graph_timer *timers;
    uint32_t count;
    assert_false(graph_query_timers(world->base.graph, 0, &timers, &count));
    for (uint32_t frame = 0; frame < 3; frame++) {
        declare_all(world, 0);
        run(world, &(struct graph_execute_params){.timers = true});
        assert_false(graph_query_timers(world->base.graph, gpu_frame_number(world->base.device) + 1, &timers, &count));
        assert_true(graph_query_timers(world->base.graph, gpu_frame_number(world->base.device), &timers, &count));
        assert_int_equal(count, COUNT_OF(pass_names));
        double sum = 0;
        for (uint32_t i = 0; i < count; i++) {
            assert_string_equal(timers[i].name, pass_names[i]);
            assert_true(timers[i].milliseconds >= 0);
            assert_int_equal(timers[i].queue, gpu_info(world->base.device)->async_compute ? (int)timers[i].queue : GPU_QUEUE_GRAPHICS);
            assert_true(i > 0 || timers[i].begin_milliseconds == 0 || timers[i].queue == GPU_QUEUE_COMPUTE);
            for (uint32_t k = 0; k < i; k++) /* one after the other on a queue */
                if (timers[k].queue == timers[i].queue)
                    assert_true(timers[k].begin_milliseconds + timers[k].milliseconds <= timers[i].begin_milliseconds + 1e-6);
            sum += timers[i].milliseconds;
        }
        assert_true(sum > 0);
    }
    /* The two frames before are remembered, too; one without timers has none. */
    declare_all(world, 0);
    run(world, NULL);
    assert_true(graph_query_timers(world->base.graph, gpu_frame_number(world->base.device) - 1, &timers, &count));
    assert_true(graph_query_timers(world->base.graph, gpu_frame_number(world->base.device) - 2, &timers, &count));
    assert_int_equal(count, COUNT_OF(pass_names));
    assert_false(graph_query_timers(world->base.graph, gpu_frame_number(world->base.device) - 3, &timers, &count));
    assert_false(graph_query_timers(world->base.graph, gpu_frame_number(world->base.device), &timers, &count));
}

static void test_steady_state_allocates_nothing(void **state) {
    struct world *world = *state;
    struct gpu_memory_stats before = {0};
    for (uint32_t frame = 0; frame < 16; frame++) {
        if (frame == 6) {
            atomic_store(&allocation_count, 0);
            before = gpu_memory_stats(world->base.device);
        }
        declare_all(world, 0);
        run(world, &(struct graph_execute_params){.timers = true});
        const struct graph_timer *timers;
        uint32_t count;
        if (frame > 2) assert_true(graph_query_timers(world->base.graph, gpu_frame_number(world->base.device) - 2, &timers, &count));
    }
    assert_int_equal(atomic_load(&allocation_count), 0);
    struct gpu_memory_stats after = gpu_memory_stats(world->base.device);
    assert_int_equal(after.used_bytes, before.used_bytes);
    assert_int_equal(after.reserved_bytes, before.reserved_bytes);
}

/* Windows of other sizes: heaps grow at once and shrink again. */
static void test_memory_follows_the_plan(void **state) {
    struct world *world = *state;
    uint64_t small = 0, big = 0;
    for (uint32_t frame = 0; frame < 24; frame++) {
        uint32_t size = frame >= 8 && frame < 12 ? 2048 : 256;
        graph_begin(world->base.graph);
        struct graph_image_params params = {.name = "image", .format = VK_FORMAT_R32_SFLOAT, .width = size, .height = size};
        graph_image image = graph_create_image(world->base.graph, &params);
        struct graph_pass *pass = graph_add_pass(world->base.graph, "clear", GRAPH_QUEUE_GRAPHICS, NULL, NULL, 0);
        graph_color(pass, image, VK_ATTACHMENT_LOAD_OP_CLEAR, NULL);
        graph_keep(pass);
        run(world, NULL);
        if (frame == 7) small = gpu_memory_stats(world->base.device).used_bytes;
        if (frame == 11) big = gpu_memory_stats(world->base.device).used_bytes;
    }
    assert_true(big > small + (8 << 20));
    assert_int_equal(gpu_memory_stats(world->base.device).used_bytes, small);
}

/* A window that is resized all the time: images of the sizes before are let go. */
static void test_images_of_old_plans_are_released(void **state) {
    struct world *world = *state;
    for (uint32_t frame = 0; frame < 20; frame++) {
        graph_begin(world->base.graph);
        struct graph_image_params params = {
            .name = "image", .format = VK_FORMAT_R32_SFLOAT, .width = 200 - frame, .height = 100};
        graph_image image = graph_create_image(world->base.graph, &params);
        struct graph_pass *pass = graph_add_pass(world->base.graph, "clear", GRAPH_QUEUE_GRAPHICS, NULL, NULL, 0);
        graph_color(pass, image, VK_ATTACHMENT_LOAD_OP_CLEAR, NULL);
        graph_keep(pass);
        run(world, NULL);
        assert_int_equal(world->base.graph->physicals.count, MIN(frame, (uint32_t)GRAPH_KEEP_FRAMES) + 1);
    }
}

static VkDeviceAddress seen_address;
static VkImage seen_image;

static void execute_look(const struct graph_context *context, const void *data) {
    const struct dispatch *look = data;
    seen_address = graph_address(context, look->to);
    seen_image = graph_get_image(context, look->to_image)->handle;
}

/* A frame writes its buffers while the last one may still read those of its own; images, which wait, stay where they are. */
static void test_frames_in_flight_have_buffers_of_their_own(void **state) {
    struct world *world = *state;
    VkDeviceAddress addresses[6];
    VkImage images[6];
    uint64_t used = 0;
    for (uint32_t frame = 0; frame < COUNT_OF(addresses); frame++) {
        graph_begin(world->base.graph);
        struct dispatch look = {.to = graph_create_buffer(world->base.graph, "buffer", 1 << 20)};
        struct graph_image_params params = {.name = "image", .format = VK_FORMAT_R32_SFLOAT, .width = 64, .height = 64};
        look.to_image = graph_create_image(world->base.graph, &params);
        struct graph_pass *pass = graph_add_pass(world->base.graph, "look", GRAPH_QUEUE_GRAPHICS, execute_look, &look, sizeof look);
        graph_use_buffer(pass, look.to, GRAPH_WRITE_COMPUTE);
        graph_use_image(pass, look.to_image, GRAPH_WRITE_COMPUTE);
        graph_keep(pass);
        run(world, NULL);
        addresses[frame] = seen_address;
        images[frame] = seen_image;
        if (frame == 1) used = gpu_memory_stats(world->base.device).used_bytes;
        if (frame >= 1) assert_int_not_equal(addresses[frame], addresses[frame - 1]);
        if (frame >= 1) assert_ptr_equal(images[frame], images[frame - 1]);
        if (frame >= GPU_FRAMES_IN_FLIGHT) assert_int_equal(addresses[frame], addresses[frame - GPU_FRAMES_IN_FLIGHT]);
    }
    assert_int_equal(gpu_memory_stats(world->base.device).used_bytes, used);
}

static void execute_undeclared(const struct graph_context *context, const void *data) {
    const graph_image *image = data;
    assert_int_equal(graph_sampled(context, *image), GPU_NO_INDEX);
}

/* ---- rows ---- */

/* What a pass that is recorded by hand gets from its rows. */
struct seen {
    struct push push;
    struct push *out;
};

static void execute_see(const struct graph_context *context, const void *data) {
    const struct seen *seen = data;
    UNUSED(context);
    *seen->out = seen->push;
}

static void test_rows_write_addresses(void **state) {
    struct world *world = *state;
    struct graph *graph = world->base.graph;
    for (uint32_t frame = 0; frame < 3; frame++) {
        assert_int_equal(gpu_frame_begin(world->base.device), FNL_OK);
        graph_begin(graph);
        graph_buffer values = graph_create_buffer(graph, "values", BYTES), groups = graph_create_buffer(graph, "groups", 64);
        graph_buffer output = graph_import_buffer(graph, "output", &world->base.readback);
        graph_image image = float_image(graph, "image", 1);
        add_dispatch(graph, "values", GRAPH_QUEUE_ASYNC, &(struct dispatch){.mode = FILL, .to = values, .value = 7});
        add_dispatch(graph, "image", GRAPH_QUEUE_GRAPHICS, &(struct dispatch){.mode = TO_IMAGE, .from = values, .to_image = image});
        graph_add_clear(graph, "groups", GRAPH_QUEUE_GRAPHICS, (struct graph_clear){.buffers = {groups}, .word = 1});
        /* One group of 64, at word 8 of the output. */
        struct push push = {.width = WIDTH, .count = PIXELS};
        graph_dispatch(graph, &(struct graph_dispatch){
                                  .name = "indirect",
                                  .pipeline = {&shader_graph_test_comp, 1, {TO_BUFFER}},
                                  .indirect = groups,
                                  .indirect_offset = 12,
                                  GRAPH_PUSH(push),
                                  GRAPH_ROWS(graph_samples(&push.from_image, image), graph_row_at(32, graph_writes(&push.to, output)))});
        struct push seen = {0};
        struct seen data = {.out = &seen};
        struct graph_pass *pass = graph_add_pass(graph, "see", GRAPH_QUEUE_GRAPHICS, execute_see, &data, sizeof data);
        graph_add_row(pass, graph_row_at(16, graph_reads(&data.push.from, values)));
        graph_add_row(pass, graph_image_row(&data.push.to_image, image, GRAPH_READ_COMPUTE));
        graph_add_row(pass, graph_buffer_row(NULL, output, GRAPH_READ_HOST));
        uint64_t put = 1, unused = 1;
        graph_put_address(graph, &put, values);
        graph_put_address(graph, &unused, graph_create_buffer(graph, "unused", 64));
        assert_int_equal(graph_compile(graph), FNL_OK);
        memset(world->base.readback.mapped, 0, world->base.readback.size);
        if (frame == 1) {
            uint64_t ticket;
            assert_int_equal(graph_ask_pipelines(graph, &ticket), FNL_OK);
            assert_int_equal(ticket, 0); /* the frame before had them made */
            assert_true(put == 1 && seen.from == 16); /* no buffer has a place */
            assert_int_equal(gpu_frame_end(world->base.device, NULL, 0, NULL), FNL_OK);
            continue;
        }
        assert_int_equal(graph_execute_frame(graph, NULL), FNL_OK);
        assert_int_equal(gpu_wait_idle(world->base.device), FNL_OK);
        const float *out = world->base.readback.mapped;
        for (uint32_t i = 0; i < 80; i++) assert_true(out[i] == (i >= 8 && i < 72 ? (float)(i - 8) + 7 : 0));
        assert_true(put != 0 && put != 1 && seen.from == put + 16 && unused == 0);
        assert_true(seen.to_image != GPU_NO_INDEX && seen.width == 0 && seen.to == 0);
    }
}

/* Each with its own constants, size, push constants and rows; the one without groups does nothing. */
static void test_dispatches_of_one_pass(void **state) {
    struct world *world = *state;
    struct graph *graph = world->base.graph;
    assert_int_equal(gpu_frame_begin(world->base.device), FNL_OK);
    graph_begin(graph);
    graph_buffer values = graph_create_buffer(graph, "values", BYTES), groups = graph_create_buffer(graph, "groups", 64);
    graph_buffer output = graph_import_buffer(graph, "output", &world->base.readback);
    graph_image image = float_image(graph, "image", 1);
    add_dispatch(graph, "values", GRAPH_QUEUE_GRAPHICS, &(struct dispatch){.mode = FILL, .to = values, .value = 100});
    add_dispatch(graph, "image", GRAPH_QUEUE_GRAPHICS, &(struct dispatch){.mode = TO_IMAGE, .from = values, .to_image = image});
    graph_add_clear(graph, "clear", GRAPH_QUEUE_GRAPHICS, (struct graph_clear){.buffers = {groups, output}, .word = 1});
    struct graph_pass *pass = NULL;
    for (uint32_t i = 0; i < 4; i++) { /* the second one copies the image, the third is indirect, the last has no groups */
        struct push push = {.width = WIDTH, .count = 64, .value = (float)i};
        pass = graph_dispatch(graph, &(struct graph_dispatch){
                                         .pass = pass,
                                         .name = "several",
                                         .pipeline = {&shader_graph_test_comp, 1, {i == 1 ? TO_BUFFER : FILL}},
                                         .groups = {i < 2},
                                         .indirect = i == 2 ? groups : (graph_buffer){0},
                                         GRAPH_PUSH(push),
                                         GRAPH_ROWS(graph_row_if(i == 1, graph_samples(&push.from_image, image)))});
        graph_add_row(pass, graph_row_at(i * 64 * 4ull, graph_writes(&push.to, output)));
    }
    graph_use_buffer(pass, output, GRAPH_READ_HOST);
    assert_int_equal(graph_compile(graph), FNL_OK);
    assert_int_equal(graph_execute_frame(graph, NULL), FNL_OK);
    assert_int_equal(gpu_wait_idle(world->base.device), FNL_OK);
    const float *out = world->base.readback.mapped;
    for (uint32_t i = 0; i < 192; i++) {
        const float first[] = {0, 100, 2};
        assert_true(out[i] == first[i / 64] + (float)(i % 64));
    }
    for (uint32_t i = 192; i < 256; i++) assert_int_equal(((const uint32_t *)world->base.readback.mapped)[i], 1);
}

static void test_pipelines_of_dispatches_can_be_asked_for(void **state) {
    struct world *world = *state;
    struct graph *graph = world->base.graph;
    uint64_t ticket;
    for (uint32_t again = 0; again < 2; again++) {
        assert_int_equal(gpu_frame_begin(world->base.device), FNL_OK);
        graph_begin(graph);
        graph_buffer output = graph_import_buffer(graph, "output", &world->base.readback);
        add_dispatch(graph, "fill", GRAPH_QUEUE_GRAPHICS, &(struct dispatch){.mode = FILL, .to = output});
        assert_int_equal(graph_compile(graph), FNL_OK);
        assert_int_equal(graph_ask_pipelines(graph, &ticket), FNL_OK);
        assert_int_equal(gpu_frame_end(world->base.device, NULL, 0, NULL), FNL_OK);
        assert_true(again ? ticket == 0 : ticket != 0);
        while (gpu_pipeline_stats(world->base.device).done < ticket) sched_yield();
    }
}

static void test_errors_end_the_frame_and_the_next_one_works(void **state) {
    struct world *world = *state;
    struct graph *graph = world->base.graph;
    graph_begin(graph);
    assert_int_equal(gpu_frame_begin(world->base.device), FNL_OK);
    assert_int_equal(graph_execute_frame(graph, NULL), FNL_ERROR_INVALID);
    assert_non_null(strstr(logged, "not compiled"));

    graph_begin(graph);
    add_dispatch(graph, "bad", GRAPH_QUEUE_GRAPHICS,
                 &(struct dispatch){.mode = TO_BUFFER, .from_image = float_image(graph, "nothing", 1)});
    assert_int_equal(graph_compile(graph), FNL_ERROR_INVALID);
    assert_int_equal(gpu_frame_begin(world->base.device), FNL_OK);
    assert_int_equal(graph_execute_frame(graph, NULL), FNL_ERROR_INVALID);

    graph_begin(graph);
    graph_image image = float_image(graph, "image", 1);
    graph_keep(graph_add_pass(graph, "undeclared", GRAPH_QUEUE_GRAPHICS, execute_undeclared, &image, sizeof image));
    assert_int_equal(graph_compile(graph), FNL_OK);
    assert_int_equal(gpu_frame_begin(world->base.device), FNL_OK);
    assert_int_equal(graph_execute_frame(graph, NULL), FNL_ERROR_INVALID);
    assert_non_null(strstr(logged, "graph: pass 'undeclared' asks for 'image' without a declared use of it"));

    declare_all(world, 5);
    run(world, NULL);
    check_all(world, 5);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_results_are_right_with_aliasing, set_up, tear_down),
        cmocka_unit_test_setup_teardown(test_batches_of_the_compute_queue, set_up, tear_down),
        cmocka_unit_test_setup_teardown(test_frames_in_flight_do_not_disturb_each_other, set_up, tear_down),
        cmocka_unit_test_setup_teardown(test_threads_do_not_change_the_bytes, set_up, tear_down),
        cmocka_unit_test_setup_teardown(test_history_goes_back_and_forth, set_up, tear_down),
        cmocka_unit_test_setup_teardown(test_imported_images_keep_their_contents, set_up, tear_down),
        cmocka_unit_test_setup_teardown(test_timers, set_up, tear_down),
        cmocka_unit_test_setup_teardown(test_steady_state_allocates_nothing, set_up, tear_down),
        cmocka_unit_test_setup_teardown(test_memory_follows_the_plan, set_up, tear_down),
        cmocka_unit_test_setup_teardown(test_images_of_old_plans_are_released, set_up, tear_down),
        cmocka_unit_test_setup_teardown(test_rows_write_addresses, set_up, tear_down),
        cmocka_unit_test_setup_teardown(test_dispatches_of_one_pass, set_up, tear_down),
        cmocka_unit_test_setup_teardown(test_pipelines_of_dispatches_can_be_asked_for, set_up, tear_down),
        cmocka_unit_test_setup_teardown(test_frames_in_flight_have_buffers_of_their_own, set_up, tear_down),
        cmocka_unit_test_setup_teardown(test_errors_end_the_frame_and_the_next_one_works, set_up, tear_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
