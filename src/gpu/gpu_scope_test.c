/* SPDX-License-Identifier: MIT */
#include "tests/gpu_test.h"
#include "shaders.h"

enum { SIDE = 9 };

struct vertex {
    float position[4], color[4];
};

struct canvas {
    gpu_device *device;
    struct gpu_image below, above, depth;
    struct gpu_buffer vertices, pixels;
    struct gpu_scope_params params;
    uint32_t width, height;
};

static const VkImageUsageFlags input_usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_INPUT_ATTACHMENT_BIT;

static void create_images(struct canvas *canvas, uint32_t width, uint32_t height) {
    struct gpu_image_params params = {.name = "below",
                                      .format = VK_FORMAT_R16G16B16A16_SFLOAT,
                                      .width = width,
                                      .height = height,
                                      .layers = 1,
                                      .mips = 1,
                                      .samples = 1,
                                      .usage = input_usage | VK_IMAGE_USAGE_TRANSIENT_ATTACHMENT_BIT};
    canvas->width = width;
    canvas->height = height;
    assert_int_equal(gpu_image_create(canvas->device, &params, &canvas->below), FNL_OK);
    params.name = "above";
    params.format = VK_FORMAT_R32G32B32A32_SFLOAT;
    params.usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
    assert_int_equal(gpu_image_create(canvas->device, &params, &canvas->above), FNL_OK);
    params.name = "depth";
    params.format = VK_FORMAT_D32_SFLOAT;
    params.usage = VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT;
    assert_int_equal(gpu_image_create(canvas->device, &params, &canvas->depth), FNL_OK);
}

static void destroy_images(struct canvas *canvas) {
    gpu_image_destroy(canvas->device, &canvas->below);
    gpu_image_destroy(canvas->device, &canvas->above);
    gpu_image_destroy(canvas->device, &canvas->depth);
}

/* Rectangle `index` of the vertex buffer. */
static void put_quad(struct canvas *canvas, uint32_t index, float x0, float x1, float z, float color) {
    struct vertex *at = (struct vertex *)canvas->vertices.mapped + 6 * index;
    const float x[] = {x0, x1, x1, x1, x0, x0}, y[] = {-1, -1, 1, 1, 1, -1};
    for (uint32_t i = 0; i < 6; i++) at[i] = (struct vertex){{x[i], y[i], z, 1}, {color, color, color, color}};
}

static void canvas_init(struct canvas *canvas, gpu_device *device) {
    *canvas = (struct canvas){.device = device};
    create_images(canvas, SIDE, SIDE);
    assert_int_equal(gpu_buffer_create(device, "vertices", 24 * sizeof(struct vertex), GPU_MEMORY_UPLOAD, &canvas->vertices),
                     FNL_OK);
    assert_int_equal(gpu_buffer_create(device, "pixels", 64 * 64 * 16, GPU_MEMORY_READBACK, &canvas->pixels), FNL_OK);
    put_quad(canvas, 0, -1, 0, 0.5f, 3);  /* the left half, near */
    put_quad(canvas, 1, -1, 1, 0.25f, 5); /* all, far: hidden on the left */
    put_quad(canvas, 2, -1, 1, 0.5f, 0.25f);
    struct gpu_scope_params *params = &canvas->params;
    memset(params, 0, sizeof *params);
    params->attachment_count = 3;
    params->attachments[0].format = VK_FORMAT_R16G16B16A16_SFLOAT;
    params->attachments[1].format = VK_FORMAT_D32_SFLOAT;
    params->attachments[2].format = VK_FORMAT_R32G32B32A32_SFLOAT;
    for (uint32_t i = 0; i < 3; i++) {
        params->attachments[i].load = VK_ATTACHMENT_LOAD_OP_CLEAR;
        params->attachments[i].store = i == 2 ? VK_ATTACHMENT_STORE_OP_STORE : VK_ATTACHMENT_STORE_OP_DONT_CARE;
    }
    params->step_count = 3;
    params->steps[0] = (struct gpu_scope_step){.color_count = 1, .colors = {0}, .depth = 1};
    params->steps[1] = (struct gpu_scope_step){
        .color_count = 1, .colors = {0}, .input_count = 2, .inputs = {GPU_NO_INDEX, 0}, .depth = GPU_NO_INDEX};
    params->steps[2] = (struct gpu_scope_step){
        .color_count = 1, .colors = {2}, .input_count = 2, .inputs = {GPU_NO_INDEX, 0}, .depth = 1, .depth_read_only = true};
}

static void canvas_finish(struct canvas *canvas) {
    destroy_images(canvas);
    gpu_buffer_destroy(canvas->device, &canvas->vertices);
    gpu_buffer_destroy(canvas->device, &canvas->pixels);
}

static void bind(struct gpu_commands *commands, struct canvas *canvas, const struct gpu_scope *scope, uint32_t step,
                 float scale) {
    struct gpu_graphics_params params = {.vertex = &shader_gpu_test_vert,
                                         .fragment = step ? &shader_gpu_test_scope_frag : &shader_gpu_test_frag,
                                         .constant_count = 1,
                                         .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST,
                                         .color_count = 1,
                                         .depth_test = step != 1,
                                         .depth_write = step == 0,
                                         .depth_compare = step == 0 ? VK_COMPARE_OP_GREATER : VK_COMPARE_OP_EQUAL,
                                         .samples = 1,
                                         .scope = scope,
                                         .scope_step = step};
    memcpy(&params.constants[0], &scale, 4);
    gpu_bind(commands, gpu_graphics_pipeline(canvas->device, &params));
    gpu_push(commands, &canvas->vertices.address, 8);
}

static void record(struct gpu_commands *commands, void *context) {
    struct canvas *canvas = context;
    test_transition(commands, &canvas->below, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
    test_transition(commands, &canvas->above, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
    test_transition(commands, &canvas->depth, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL);
    const struct gpu_scope *scope = gpu_scope_find(canvas->device, &canvas->params);
    assert_non_null(scope);
    assert_ptr_equal(scope, gpu_scope_find(canvas->device, &canvas->params));
    const struct gpu_image *images[] = {&canvas->below, &canvas->depth, &canvas->above};
    const VkClearValue clears[] = {
        {.color.float32 = {1, 1, 1, 1}}, {.depthStencil = {0, 0}}, {.color.float32 = {7, 7, 7, 7}}};
    gpu_begin_scope(commands, scope, images, clears);
    bind(commands, canvas, scope, 0, 1);
    gpu_draw(commands, 12, 1, 0, 0);
    gpu_next_step(commands);
    bind(commands, canvas, scope, 1, 2); /* twice what is there, plus a quarter; and so again */
    gpu_draw(commands, 6, 1, 12, 0);
    gpu_scope_barrier(commands);
    gpu_draw(commands, 6, 1, 12, 0);
    gpu_next_step(commands);
    bind(commands, canvas, scope, 2, 10); /* where depth is a half: on the left */
    gpu_draw(commands, 6, 1, 12, 0);
    gpu_end_scope(commands);
    test_transition(commands, &canvas->above, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                    VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
    gpu_copy_image_to_buffer(commands, &canvas->above, &canvas->pixels, 0);
}

static void check(const struct canvas *canvas) {
    const float *pixels = canvas->pixels.mapped;
    for (uint32_t y = 0; y < canvas->height; y++)
        for (uint32_t x = 0; x < canvas->width; x++) {
            /* ((3 * 2 + 1/4) * 2 + 1/4) * 10 + 1/4 */
            float expected = 2 * x + 1 < canvas->width ? 127.75f : 7;
            if (2 * x + 1 != canvas->width) assert_true(pixels[4 * (y * canvas->width + x)] == expected);
        }
}

/* Later steps read what earlier ones drew, also where a step rewrites what it reads; sizes change from frame to frame. */
static void test_steps_read_what_was_drawn_before(void **state) {
    UNUSED(state);
    gpu_device *device = test_device_create(NULL);
    assert_true(gpu_scope_supports(device, 4, 4));
    assert_false(gpu_scope_supports(device, GPU_MAX_COLORS + 1, 0));
    assert_false(gpu_scope_supports(device, 1, GPU_MAX_INPUTS + 1));
    struct canvas canvas;
    canvas_init(&canvas, device);
    test_run(device, record, &canvas);
    check(&canvas);
    for (uint32_t size = 1; size < 8; size++) { /* more sizes than framebuffers are kept */
        destroy_images(&canvas);
        create_images(&canvas, 2 * size + 1, size);
        test_run(device, record, &canvas);
        check(&canvas);
    }
    canvas_finish(&canvas);
    test_device_destroy(&device);
}

/* In a steady state scopes allocate nothing. */
static void test_scopes_are_made_once(void **state) {
    UNUSED(state);
    struct test_memory memory = {0};
    gpu_device *device = test_device_create(&memory);
    struct canvas canvas;
    canvas_init(&canvas, device);
    for (uint32_t i = 0; i < 3; i++) test_run(device, record, &canvas);
    long long before = atomic_load(&memory.allocations);
    for (uint32_t i = 0; i < 40; i++) test_run(device, record, &canvas); /* more steps than a frame may have */
    assert_int_equal(atomic_load(&memory.allocations), before);
    check(&canvas);
    canvas_finish(&canvas);
    test_device_destroy(&device);
}

static void record_bad(struct gpu_commands *commands, void *context) {
    struct canvas *canvas = context;
    canvas->params.steps[0].colors[0] = 5; /* there are three */
    const struct gpu_scope *scope = gpu_scope_find(canvas->device, &canvas->params);
    assert_null(scope);
    gpu_begin_scope(commands, scope, NULL, NULL);
    gpu_draw(commands, 6, 1, 12, 0);
    gpu_next_step(commands);
    gpu_end_scope(commands);
}

static void test_a_bad_scope_is_misuse(void **state) {
    UNUSED(state);
    struct test_memory memory = {0};
    gpu_device *device = test_device_create(&memory);
    struct canvas canvas;
    canvas_init(&canvas, device);
    assert_int_equal(gpu_frame_begin(device), FNL_OK);
    struct gpu_commands *commands = gpu_commands_begin(device, GPU_QUEUE_GRAPHICS, 0);
    record_bad(commands, &canvas);
    gpu_commands_end(commands);
    const struct gpu_batch batch = {.commands = &commands, .command_count = 1, .wait_batch = GPU_NO_INDEX};
    assert_int_equal(gpu_frame_end(device, &batch, 1, NULL), FNL_ERROR_INVALID);
    canvas_finish(&canvas);
    test_device_destroy(&device);
}

/* Transient attachments go to lazily allocated memory where there is such a type, and nothing else does. */
static void test_lazy_memory_is_for_transient_attachments(void **state) {
    UNUSED(state);
    struct gpu_memory memory = {.properties = {.memoryTypeCount = 3, .memoryHeapCount = 1}};
    memory.properties.memoryTypes[0].propertyFlags =
        VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT | VK_MEMORY_PROPERTY_LAZILY_ALLOCATED_BIT;
    memory.properties.memoryTypes[1].propertyFlags = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
    memory.properties.memoryTypes[2].propertyFlags =
        VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    uint32_t types[VK_MAX_MEMORY_TYPES], type = 99;
    assert_true(gpu_memory_lazy_type(&memory, 7, &type));
    assert_int_equal(type, 0);
    assert_false(gpu_memory_lazy_type(&memory, 6, &type)); /* what an image without TRANSIENT usage asks for */
    assert_int_equal(gpu_memory_order_types(&memory, GPU_MEMORY_DEVICE, 7, types), 2);
    assert_int_equal(types[0], 1);
}

const struct CMUnitTest scope_tests[] = {
    cmocka_unit_test(test_steps_read_what_was_drawn_before),
    cmocka_unit_test(test_scopes_are_made_once),
    cmocka_unit_test(test_a_bad_scope_is_misuse),
    cmocka_unit_test(test_lazy_memory_is_for_transient_attachments),
};
const size_t scope_test_count = COUNT_OF(scope_tests);
