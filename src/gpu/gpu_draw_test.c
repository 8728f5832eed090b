/* SPDX-License-Identifier: MIT */
#include "tests/gpu_test.h"
#include "base/maths.h"
#include "shaders.h"

#include <math.h>
#include <time.h>

enum { SIDE = 16, MAX_VERTICES = 64 };

struct vertex {
    float position[4], color[4];
};

/** A target of SIDE x SIDE pixels and vertices to draw into it. */
struct canvas {
    gpu_device *device;
    struct gpu_image color, depth, resolved; /* resolved: with more than one sample */
    struct gpu_buffer vertices, indices, commands, pixels, depths;
    uint32_t vertex_count, samples;
    struct gpu_graphics_params pipeline;
    VkClearColorValue clear;
    void (*draw)(struct gpu_commands *commands, struct canvas *canvas);
};

static void canvas_init(struct canvas *canvas, gpu_device *device, uint32_t samples) {
    *canvas = (struct canvas){.device = device, .samples = samples};
    struct gpu_image_params color = {"color", VK_FORMAT_R32G32B32A32_SFLOAT,
                                     SIDE,    SIDE,
                                     1,       1,
                                     samples, false,
                                     false,   VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT, GPU_USE_OTHER};
    struct gpu_image_params depth = {"depth", VK_FORMAT_D32_SFLOAT,
                                     SIDE,    SIDE,
                                     1,       1,
                                     samples, false,
                                     false,   VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT, GPU_USE_OTHER};
    if (samples > 1) color.format = VK_FORMAT_R16G16B16A16_SFLOAT;
    assert_int_equal(gpu_image_create(device, &color, &canvas->color), FNL_OK);
    assert_int_equal(gpu_image_create(device, &depth, &canvas->depth), FNL_OK);
    color.samples = 1;
    if (samples > 1) assert_int_equal(gpu_image_create(device, &color, &canvas->resolved), FNL_OK);
    assert_int_equal(
        gpu_buffer_create(device, "vertices", MAX_VERTICES * sizeof(struct vertex), GPU_MEMORY_UPLOAD, &canvas->vertices),
        FNL_OK);
    assert_int_equal(gpu_buffer_create(device, "indices", 256, GPU_MEMORY_UPLOAD, &canvas->indices), FNL_OK);
    assert_int_equal(gpu_buffer_create(device, "indirect", 256, GPU_MEMORY_UPLOAD, &canvas->commands), FNL_OK);
    assert_int_equal(gpu_buffer_create(device, "pixels", SIDE * SIDE * 16, GPU_MEMORY_READBACK, &canvas->pixels), FNL_OK);
    assert_int_equal(gpu_buffer_create(device, "depths", SIDE * SIDE * 16, GPU_MEMORY_READBACK, &canvas->depths), FNL_OK);
    canvas->pipeline.vertex = &shader_gpu_test_vert;
    canvas->pipeline.fragment = &shader_gpu_test_frag;
    canvas->pipeline.constant_count = 1;
    memcpy(&canvas->pipeline.constants[0], &(float){1}, 4);
    canvas->pipeline.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
    canvas->pipeline.color_count = 1;
    canvas->pipeline.color_formats[0] = color.format;
    canvas->pipeline.depth_format = VK_FORMAT_D32_SFLOAT;
    canvas->pipeline.samples = samples;
}

static void canvas_finish(struct canvas *canvas) {
    gpu_image_destroy(canvas->device, &canvas->color);
    gpu_image_destroy(canvas->device, &canvas->depth);
    if (canvas->samples > 1) gpu_image_destroy(canvas->device, &canvas->resolved);
    gpu_buffer_destroy(canvas->device, &canvas->vertices);
    gpu_buffer_destroy(canvas->device, &canvas->indices);
    gpu_buffer_destroy(canvas->device, &canvas->commands);
    gpu_buffer_destroy(canvas->device, &canvas->pixels);
    gpu_buffer_destroy(canvas->device, &canvas->depths);
}

static void add_vertex(struct canvas *canvas, float x, float y, float z, float r, float g, float b, float a) {
    struct vertex *vertices = canvas->vertices.mapped;
    assert_true(canvas->vertex_count < MAX_VERTICES);
    vertices[canvas->vertex_count++] = (struct vertex){{x, y, z, 1}, {r, g, b, a}};
}

/** A rectangle of two triangles, counter-clockwise with +Y up. */
static void add_quad(struct canvas *canvas, float x0, float y0, float x1, float y1, float z, float r, float g, float b,
                     float a) {
    add_vertex(canvas, x0, y0, z, r, g, b, a);
    add_vertex(canvas, x1, y0, z, r, g, b, a);
    add_vertex(canvas, x1, y1, z, r, g, b, a);
    add_vertex(canvas, x1, y1, z, r, g, b, a);
    add_vertex(canvas, x0, y1, z, r, g, b, a);
    add_vertex(canvas, x0, y0, z, r, g, b, a);
}

static void record_canvas(struct gpu_commands *commands, void *context) {
    struct canvas *canvas = context;
    test_transition(commands, &canvas->color, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
    test_transition(commands, &canvas->depth, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL);
    const struct gpu_image *result = &canvas->color;
    struct gpu_rendering rendering = {
        .width = SIDE,
        .height = SIDE,
        .layers = 1,
        .color_count = 1,
        .colors[0] = {.image = &canvas->color,
                      .load = VK_ATTACHMENT_LOAD_OP_CLEAR,
                      .store = VK_ATTACHMENT_STORE_OP_STORE,
                      .clear.color = canvas->clear},
        .depth = {.image = &canvas->depth, .load = VK_ATTACHMENT_LOAD_OP_CLEAR, .store = VK_ATTACHMENT_STORE_OP_STORE},
    };
    if (canvas->samples > 1) {
        result = rendering.colors[0].resolve = &canvas->resolved;
        test_transition(commands, result, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
    }
    gpu_begin_rendering(commands, &rendering);
    gpu_bind(commands, gpu_graphics_pipeline(canvas->device, &canvas->pipeline));
    gpu_push(commands, &canvas->vertices.address, 8);
    if (canvas->draw)
        canvas->draw(commands, canvas);
    else
        gpu_draw(commands, canvas->vertex_count, 1, 0, 0);
    gpu_end_rendering(commands);
    test_transition(commands, result, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
    gpu_copy_image_to_buffer(commands, result, &canvas->pixels, 0);
    if (canvas->samples == 1) {
        test_transition(commands, &canvas->depth, VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL,
                        VK_IMAGE_LAYOUT_DEPTH_READ_ONLY_OPTIMAL);
        test_dispatch(
            commands, TEST_FETCH, 0,
            &(struct test_push){
                .to = canvas->depths.address, .count = SIDE * SIDE, .width = SIDE, .image = canvas->depth.sampled_index});
    }
}

static void canvas_draw(struct canvas *canvas) { test_run(canvas->device, record_canvas, canvas); }

/** Column and row from the top left. */
static const float *pixel_at(const struct canvas *canvas, uint32_t x, uint32_t y) {
    return (const float *)canvas->pixels.mapped + 4 * (y * SIDE + x);
}
static float depth_at(const struct canvas *canvas, uint32_t x, uint32_t y) {
    return ((const float *)canvas->depths.mapped)[4 * (y * SIDE + x)];
}

static void check_pixel(const struct canvas *canvas, uint32_t x, uint32_t y, float r, float g, float b, float a) {
    const float *pixel = pixel_at(canvas, x, y), expected[] = {r, g, b, a};
    for (int i = 0; i < 4; i++) {
        if (fabsf(pixel[i] - expected[i]) > 1e-3f) {
            print_error("pixel %u, %u is %g %g %g %g\n", x, y, (double)pixel[0], (double)pixel[1], (double)pixel[2],
                        (double)pixel[3]);
            fail();
        }
    }
}

static void test_y_is_up_and_fronts_are_counter_clockwise(void **state) {
    UNUSED(state);
    gpu_device *device = test_device_create(NULL);
    struct canvas canvas;
    canvas_init(&canvas, device, 1);
    add_quad(&canvas, -1, 0, 0, 1, 0.5f, 1, 0, 0, 1); /* red: top left, counter-clockwise */
    add_vertex(&canvas, 0, -1, 0.5f, 0, 1, 0, 1);     /* green: bottom right, clockwise */
    add_vertex(&canvas, 0, 0, 0.5f, 0, 1, 0, 1);
    add_vertex(&canvas, 1, -1, 0.5f, 0, 1, 0, 1);
    canvas_draw(&canvas);
    const uint64_t made = gpu_pipeline_stats(device).made;
    for (int mirrored = 0; mirrored < 2; mirrored++) {
        for (VkCullModeFlags cull = VK_CULL_MODE_NONE; cull <= VK_CULL_MODE_BACK_BIT; cull++) {
            canvas.pipeline.cull = cull;
            canvas.pipeline.mirrored = mirrored;
            canvas_draw(&canvas);
            bool red = !(cull & (mirrored ? VK_CULL_MODE_BACK_BIT : VK_CULL_MODE_FRONT_BIT));
            bool green = !(cull & (mirrored ? VK_CULL_MODE_FRONT_BIT : VK_CULL_MODE_BACK_BIT));
            check_pixel(&canvas, 1, 1, red, 0, 0, red);
            check_pixel(&canvas, 7, 7, red, 0, 0, red);
            check_pixel(&canvas, 9, 14, 0, green, 0, green);
            check_pixel(&canvas, 1, 14, 0, 0, 0, 0);
            check_pixel(&canvas, 14, 1, 0, 0, 0, 0);
        }
    }
    assert_int_equal(gpu_pipeline_stats(device).made, made); /* Vulkan has one for all */
    canvas_finish(&canvas);
    test_device_destroy(&device);
}

static void test_depth_is_reversed_written_and_clamped(void **state) {
    UNUSED(state);
    gpu_device *device = test_device_create(NULL);
    struct canvas canvas;
    canvas_init(&canvas, device, 1);
    canvas.pipeline.depth_test = canvas.pipeline.depth_write = true;
    canvas.pipeline.depth_compare = VK_COMPARE_OP_GREATER;
    add_quad(&canvas, -1, -1, 1, 1, 0.75f, 1, 0, 0, 1); /* near */
    add_quad(&canvas, -1, -1, 1, 1, 0.25f, 0, 1, 0, 1); /* far, drawn later */
    add_quad(&canvas, 0, -1, 1, 1, 1.5f, 0, 0, 1, 1);   /* right half: before the near plane */
    canvas_draw(&canvas);
    check_pixel(&canvas, 3, 3, 1, 0, 0, 1);
    check_pixel(&canvas, 12, 3, 1, 0, 0, 1); /* clipped */
    assert_true(depth_at(&canvas, 3, 3) == 0.75f);
    canvas.pipeline.depth_clamp = true;
    canvas_draw(&canvas);
    check_pixel(&canvas, 12, 3, 0, 0, 1, 1);
    assert_true(depth_at(&canvas, 12, 3) == 1.0f);
    canvas.pipeline.depth_clamp = canvas.pipeline.depth_write = false;
    canvas_draw(&canvas);
    check_pixel(&canvas, 3, 3, 0, 1, 0, 1); /* nothing was written to test against */
    assert_true(depth_at(&canvas, 3, 3) == 0);
    canvas.pipeline.depth_write = true;
    canvas.pipeline.fragment = NULL; /* depth only */
    canvas.pipeline.color_count = 1;
    canvas_draw(&canvas);
    assert_true(depth_at(&canvas, 3, 3) == 0.75f);
    canvas_finish(&canvas);
    test_device_destroy(&device);
}

static PFN_vkCmdBeginRendering real_begin_rendering;
static VkRenderingAttachmentInfo last_depth;

static VKAPI_ATTR void VKAPI_CALL spy_on_rendering(VkCommandBuffer commands, const VkRenderingInfo *info) {
    last_depth = *info->pDepthAttachment;
    real_begin_rendering(commands, info);
}

static void draw_with_depth_read_only(struct gpu_commands *commands, struct canvas *canvas) {
    canvas->pipeline.depth_write = true;
    gpu_bind(commands, gpu_graphics_pipeline(canvas->device, &canvas->pipeline));
    gpu_draw(commands, 6, 1, 0, 0);
    gpu_end_rendering(commands);
    test_barrier(commands);
    test_transition(commands, &canvas->depth, VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL,
                    VK_IMAGE_LAYOUT_DEPTH_READ_ONLY_OPTIMAL);
    struct gpu_rendering rendering = {
        .width = SIDE,
        .height = SIDE,
        .layers = 1,
        .color_count = 1,
        .colors[0] = {.image = &canvas->color, .load = VK_ATTACHMENT_LOAD_OP_LOAD, .store = VK_ATTACHMENT_STORE_OP_STORE},
        .depth = {.image = &canvas->depth,
                  .load = VK_ATTACHMENT_LOAD_OP_LOAD,
                  .store = VK_ATTACHMENT_STORE_OP_STORE,
                  .read_only = true},
    };
    real_begin_rendering = canvas->device->vk.CmdBeginRendering;
    canvas->device->vk.CmdBeginRendering = spy_on_rendering;
    gpu_begin_rendering(commands, &rendering);
    canvas->device->vk.CmdBeginRendering = real_begin_rendering;
    assert_int_equal(last_depth.imageLayout, VK_IMAGE_LAYOUT_DEPTH_READ_ONLY_OPTIMAL);
    assert_int_equal(last_depth.storeOp, VK_ATTACHMENT_STORE_OP_NONE); /* old layers do not see a store as the write it is */
    canvas->pipeline.depth_write = false;
    gpu_bind(commands, gpu_graphics_pipeline(canvas->device, &canvas->pipeline));
    gpu_draw(commands, canvas->vertex_count - 6, 1, 6, 0);
    gpu_end_rendering(commands);
    test_transition(commands, &canvas->depth, VK_IMAGE_LAYOUT_DEPTH_READ_ONLY_OPTIMAL,
                    VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL);
    rendering.depth.read_only = false;
    test_barrier(commands);
    gpu_begin_rendering(commands, &rendering); /* record_canvas ends one */
}

static void test_depth_read_only_still_tests(void **state) {
    UNUSED(state);
    gpu_device *device = test_device_create(NULL);
    struct canvas canvas;
    canvas_init(&canvas, device, 1);
    canvas.pipeline.depth_test = true;
    canvas.pipeline.depth_compare = VK_COMPARE_OP_GREATER_OR_EQUAL;
    canvas.draw = draw_with_depth_read_only;
    add_quad(&canvas, -1, -1, 0, 1, 0.5f, 1, 0, 0, 1);
    add_quad(&canvas, -1, -1, 1, 1, 0.25f, 0, 1, 0, 1); /* hidden on the left */
    canvas_draw(&canvas);
    check_pixel(&canvas, 3, 3, 1, 0, 0, 1);
    check_pixel(&canvas, 12, 3, 0, 1, 0, 1);
    assert_true(depth_at(&canvas, 3, 3) == 0.5f && depth_at(&canvas, 12, 3) == 0);
    canvas_finish(&canvas);
    test_device_destroy(&device);
}

static void test_blending_is_premultiplied(void **state) {
    UNUSED(state);
    gpu_device *device = test_device_create(NULL);
    struct canvas canvas;
    canvas_init(&canvas, device, 1);
    canvas.clear = (VkClearColorValue){.float32 = {0.5f, 1, 0, 0.5f}};
    add_quad(&canvas, -1, -1, 1, 1, 0.5f, 0.25f, 0, 2, 0.75f);
    canvas_draw(&canvas);
    check_pixel(&canvas, 5, 5, 0.25f, 0, 2, 0.75f);
    canvas.pipeline.blends[0] = GPU_BLEND_ALPHA;
    canvas_draw(&canvas);
    check_pixel(&canvas, 5, 5, 0.375f, 0.25f, 2, 0.875f);
    canvas.pipeline.blends[0] = GPU_BLEND_ADD;
    canvas_draw(&canvas);
    check_pixel(&canvas, 5, 5, 0.75f, 1, 2, 1.25f);
    canvas.pipeline.blends[0] = GPU_BLEND_NONE;
    memcpy(&canvas.pipeline.constants[0], &(float){3}, 4);
    canvas_draw(&canvas);
    check_pixel(&canvas, 5, 5, 0.75f, 0, 6, 2.25f);
    canvas_finish(&canvas);
    test_device_destroy(&device);
}

static void test_msaa_is_resolved(void **state) {
    UNUSED(state);
    gpu_device *device = test_device_create(NULL);
    if (gpu_info(device)->max_msaa < 4) skip();
    struct canvas canvas;
    canvas_init(&canvas, device, 4);
    add_vertex(&canvas, -1, -1, 0.5f, 1, 1, 1, 1);
    add_vertex(&canvas, 1, -1, 0.5f, 1, 1, 1, 1);
    add_vertex(&canvas, -1, 0.7f, 0.5f, 1, 1, 1, 1);
    canvas_draw(&canvas);
    uint32_t partial = 0, full = 0;
    for (uint32_t i = 0; i < SIDE * SIDE; i++) {
        float value = half_to_float(((const uint16_t *)canvas.pixels.mapped)[4 * i]);
        assert_true(value == 0 || value == 0.25f || value == 0.5f || value == 0.75f || value == 1);
        full += value == 1;
        partial += value > 0 && value < 1;
    }
    assert_true(full > 80 && partial >= 8);
    canvas_finish(&canvas);
    test_device_destroy(&device);
}

static void draw_indirect(struct gpu_commands *commands, struct canvas *canvas) {
    gpu_bind_indices(commands, &canvas->indices, 4);
    gpu_draw_indexed_indirect_count(commands, &canvas->commands, 52, &canvas->commands, 4, 3);
    gpu_draw_indexed_indirect(commands, &canvas->commands, 32, 1); /* which that count does not limit */
}

static void test_indirect_draws_are_counted_on_the_gpu(void **state) {
    UNUSED(state);
    gpu_device *device = test_device_create(NULL);
    struct canvas canvas;
    canvas_init(&canvas, device, 1);
    canvas.draw = draw_indirect;
    for (uint32_t i = 0; i < 4; i++)
        add_quad(&canvas, -1 + 0.5f * (float)i, -1, -0.5f + 0.5f * (float)i, 1, 0.5f, 1, (float)i, 0, 1);
    uint32_t *indices = canvas.indices.mapped;
    for (uint32_t i = 0; i < 6; i++) indices[1 + i] = i;
    VkDrawIndexedIndirectCommand *draws = (VkDrawIndexedIndirectCommand *)((char *)canvas.commands.mapped + 32);
    for (uint32_t i = 0; i < 4; i++) draws[i] = (VkDrawIndexedIndirectCommand){6, 1, 0, (int32_t)(6 * i), 0};
    for (uint32_t count = 0; count <= 4; count++) {
        ((uint32_t *)canvas.commands.mapped)[1] = count;
        canvas_draw(&canvas);
        uint32_t drawn = 1 + MIN(count, 3u);
        for (uint32_t i = 0; i < 4; i++) {
            if (i < drawn)
                check_pixel(&canvas, 2 + 4 * i, 5, 1, (float)i, 0, 1);
            else
                check_pixel(&canvas, 2 + 4 * i, 5, 0, 0, 0, 0);
        }
    }
    canvas_finish(&canvas);
    test_device_destroy(&device);
}

enum { HEAVY_WORDS = 4000000 };

struct timed {
    struct canvas canvas;
    struct gpu_buffer words;
};

static void record_timed(struct gpu_commands *commands, void *context) {
    struct timed *timed = context;
    test_transition(commands, &timed->canvas.color, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
    struct gpu_rendering rendering = {
        .width = SIDE,
        .height = SIDE,
        .layers = 1,
        .color_count = 1,
        .colors[0] = {.image = &timed->canvas.color,
                      .load = VK_ATTACHMENT_LOAD_OP_CLEAR,
                      .store = VK_ATTACHMENT_STORE_OP_STORE},
    };
    gpu_timestamp(commands, 0);
    gpu_begin_rendering(commands, &rendering);
    gpu_bind(commands, gpu_graphics_pipeline(timed->canvas.device, &timed->canvas.pipeline));
    gpu_push(commands, &timed->canvas.vertices.address, 8);
    gpu_draw(commands, timed->canvas.vertex_count, 1, 0, 0);
    gpu_end_rendering(commands);
    gpu_timestamp(commands, 1);
    gpu_timestamp(commands, 2);
    test_dispatch(
        commands, TEST_MULTIPLY, 3,
        &(struct test_push){.from = timed->words.address, .to = timed->words.address, .count = HEAVY_WORDS, .width = 1});
    gpu_timestamp(commands, 3);
}

static void test_a_draws_time_is_not_that_of_the_next_dispatch(void **state) {
    UNUSED(state);
    gpu_device *device = test_device_create(NULL);
    struct timed timed;
    canvas_init(&timed.canvas, device, 1);
    timed.canvas.pipeline.depth_format = VK_FORMAT_UNDEFINED;
    add_quad(&timed.canvas, -1, -1, 1, 1, 0.5f, 1, 1, 1, 1);
    assert_int_equal(gpu_buffer_create(device, "words", HEAVY_WORDS * 4, GPU_MEMORY_DEVICE, &timed.words), FNL_OK);
    uint64_t times[4];
    for (uint32_t round = 0; round < 2; round++) test_run(device, record_timed, &timed); /* the first compiles */
    assert_true(gpu_frame_timestamps(device, gpu_frame_slot(device), COUNT_OF(times), times));
    assert_true(times[3] - times[2] > 4 * (times[1] - times[0]));
    gpu_buffer_destroy(device, &timed.words);
    canvas_finish(&timed.canvas);
    test_device_destroy(&device);
}

static void record_counted(struct gpu_commands *commands, void *context) {
    struct canvas *canvas = context;
    test_transition(commands, &canvas->color, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
    const struct gpu_rendering rendering = {
        .width = SIDE,
        .height = SIDE,
        .layers = 1,
        .color_count = 1,
        .colors[0] = {.image = &canvas->color, .load = VK_ATTACHMENT_LOAD_OP_CLEAR, .store = VK_ATTACHMENT_STORE_OP_STORE},
    };
    gpu_begin_rendering(commands, &rendering);
    gpu_bind(commands, gpu_graphics_pipeline(canvas->device, &canvas->pipeline));
    gpu_push(commands, &canvas->vertices.address, 8);
    for (uint32_t i = 0; i < 3; i++) { /* the last one is beyond those that there are */
        const uint32_t query = i < 2 ? GPU_MAX_VERTEX_COUNTS - 2 + i : GPU_MAX_VERTEX_COUNTS;
        gpu_begin_vertex_count(commands, query, 1);
        gpu_draw(commands, canvas->vertex_count, 1 + i, 0, 0);
        gpu_end_vertex_count(commands, query, 1);
    }
    gpu_end_rendering(commands);
}

static void test_vertices_are_counted(void **state) {
    UNUSED(state);
    enum { FIRST = GPU_MAX_VERTEX_COUNTS - 2 };
    gpu_device *device = test_device_create(NULL);
    struct canvas canvas;
    canvas_init(&canvas, device, 1);
    canvas.pipeline.depth_format = VK_FORMAT_UNDEFINED;
    add_quad(&canvas, -1, -1, 1, 1, 0.5f, 1, 1, 1, 1);
    uint64_t count = 0;
    for (uint32_t round = 0; round < GPU_FRAMES_IN_FLIGHT + 1 && gpu_info(device)->vertex_counts; round++) { /* queries are reset */
        test_run(device, record_counted, &canvas);
        const uint64_t frame = gpu_frame_number(device);
        assert_true(gpu_frame_vertex_count(device, frame, FIRST, 1, &count));
        assert_int_equal(count, canvas.vertex_count);
        assert_true(gpu_frame_vertex_count(device, frame, FIRST, 2, &count));
        assert_int_equal(count, 3 * canvas.vertex_count);
        assert_false(gpu_frame_vertex_count(device, frame, FIRST, 3, &count));
        assert_false(gpu_frame_vertex_count(device, frame, FIRST, 0, &count));
        assert_false(gpu_frame_vertex_count(device, 0, FIRST, 1, &count));
        if (frame > GPU_FRAMES_IN_FLIGHT) assert_false(gpu_frame_vertex_count(device, frame - GPU_FRAMES_IN_FLIGHT, FIRST, 1, &count));
    }
    canvas_finish(&canvas);
    test_device_destroy(&device);
}

static void test_pipelines_are_made_once(void **state) {
    UNUSED(state);
    gpu_device *device = test_device_create(NULL);
    struct canvas canvas;
    canvas_init(&canvas, device, 1);
    const struct gpu_pipeline *first = gpu_graphics_pipeline(device, &canvas.pipeline);
    assert_non_null(first);
    assert_ptr_equal(gpu_graphics_pipeline(device, &canvas.pipeline), first);
    canvas.pipeline.cull = VK_CULL_MODE_BACK_BIT;
    assert_ptr_not_equal(gpu_graphics_pipeline(device, &canvas.pipeline), first);
    assert_true(gpu_graphics_pipeline(device, &canvas.pipeline)->handle == first->handle);
    struct gpu_compute_params params;
    memset(&params, 0, sizeof params);
    params.shader = &shader_gpu_test_comp;
    params.constant_count = 2;
    const struct gpu_pipeline *kept[70];
    for (uint32_t round = 0; round < 2; round++) {
        for (uint32_t i = 0; i < COUNT_OF(kept); i++) { /* past the table's first size */
            params.constants[1] = i;
            const struct gpu_pipeline *pipeline = gpu_compute_pipeline(device, &params);
            assert_non_null(pipeline);
            if (round) assert_ptr_equal(pipeline, kept[i]);
            kept[i] = pipeline;
        }
    }
    assert_ptr_not_equal(kept[0], kept[1]);
    canvas_finish(&canvas);
    test_device_destroy(&device);
}

/* Whatever they draw to: validation says if the second device uses one wrongly. */
static void test_pipelines_of_all_kinds_are_made_ahead(void **state) {
    UNUSED(state);
    gpu_device *device = test_device_create(NULL);
    struct canvas canvas;
    canvas_init(&canvas, device, 1);
    struct gpu_graphics_params kinds[8];
    for (uint32_t i = 0; i < COUNT_OF(kinds); i++) memcpy(&kinds[i], &canvas.pipeline, sizeof kinds[i]);
    kinds[1].blends[0] = GPU_BLEND_ALPHA;
    kinds[1].color_formats[0] = VK_FORMAT_R8G8B8A8_UNORM;
    kinds[2].fragment = NULL;
    kinds[2].color_count = 0;
    kinds[2].depth_test = kinds[2].depth_write = true;
    kinds[3].samples = 4;
    kinds[3].color_formats[0] = VK_FORMAT_R16G16B16A16_SFLOAT;
    kinds[4].depth_format = VK_FORMAT_UNDEFINED;
    kinds[5].depth_format = VK_FORMAT_D32_SFLOAT_S8_UINT;
    kinds[5].stencil = (struct gpu_stencil){.test = 1, .compare = VK_COMPARE_OP_EQUAL, .pass = VK_STENCIL_OP_REPLACE, .reference = GPU_STENCIL_SET};
    kinds[6].depth_format = VK_FORMAT_S8_UINT;
    kinds[6].stencil = (struct gpu_stencil){.test = 1, .compare = VK_COMPARE_OP_ALWAYS, .pass = VK_STENCIL_OP_REPLACE, .reference = 3};
    kinds[7].cull = VK_CULL_MODE_BACK_BIT;
    assert_int_equal(gpu_frame_begin(device), FNL_OK);
    gpu_ask_begin(device);
    for (uint32_t i = 0; i < COUNT_OF(kinds); i++) assert_null(gpu_graphics_pipeline(device, &kinds[i]));
    uint64_t ticket = gpu_ask_end(device);
    assert_int_equal(gpu_frame_end(device, NULL, 0, NULL), FNL_OK);
    assert_int_equal(ticket, COUNT_OF(kinds));
    while (gpu_pipeline_stats(device).done < ticket) nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
    for (uint32_t i = 0; i < COUNT_OF(kinds); i++) assert_non_null(gpu_graphics_pipeline(device, &kinds[i]));
    assert_int_equal(gpu_pipeline_stats(device).late, 0);
    assert_int_equal(gpu_pipeline_stats(device).ahead, COUNT_OF(kinds));
    assert_int_equal(gpu_pipeline_stats(device).made, COUNT_OF(kinds) - 1); /* the last is the first but for culling */
    assert_int_equal(gpu_pipeline_stats(device).rehearsed, device->compiles_late ? COUNT_OF(kinds) : 0);
    canvas_finish(&canvas);
    test_device_destroy(&device);
}

const struct CMUnitTest draw_tests[] = {
    cmocka_unit_test(test_y_is_up_and_fronts_are_counter_clockwise),
    cmocka_unit_test(test_depth_is_reversed_written_and_clamped),
    cmocka_unit_test(test_depth_read_only_still_tests),
    cmocka_unit_test(test_blending_is_premultiplied),
    cmocka_unit_test(test_msaa_is_resolved),
    cmocka_unit_test(test_indirect_draws_are_counted_on_the_gpu),
    cmocka_unit_test(test_vertices_are_counted),
        cmocka_unit_test(test_a_draws_time_is_not_that_of_the_next_dispatch),
    cmocka_unit_test(test_pipelines_are_made_once),
    cmocka_unit_test(test_pipelines_of_all_kinds_are_made_ahead),
};
const size_t draw_test_count = COUNT_OF(draw_tests);
