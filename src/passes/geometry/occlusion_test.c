/* SPDX-License-Identifier: MIT */
/** What occlusion culling does to come to its result: the last frame's depth chooses occluders, and levels suit what is looked up. */
#include "passes/geometry/cull.h"
#include "tests/render_test.h"
#include "shaders.h"
#include "tests/vulkan_spy.h"

enum { SMALL = 8, LARGE = 3, BEFORE = 4 };

/* A wall; behind it squares of 13 and of 64 pixels a side, of 128; before it a few. */
static fnl_scene *wall_and_squares(uint32_t *out_wall) {
    fnl_scene *scene = test_scene();
    uint32_t quad = test_quad_mesh(scene, SCENE_NONE);
    *out_wall = test_place(scene, quad, (vec3){0, 0, 2}, (vec3){4, 4, 1});
    for (int i = 0; i < SMALL; i++)
        test_place(scene, quad, (vec3){-0.7f + 0.2f * (float)i, 0.3f - 0.1f * (float)i, 0}, (vec3){0.1f, 0.1f, 1});
    for (int i = 0; i < LARGE; i++)
        test_place(scene, quad, (vec3){-0.3f + 0.3f * (float)i, 0.1f * (float)i, -1}, (vec3){0.5f, 0.5f, 1});
    for (int i = 0; i < BEFORE; i++)
        test_place(scene, quad, (vec3){-0.6f + 0.4f * (float)i, -0.7f, 3}, (vec3){0.1f, 0.1f, 1});
    scene_update_transforms(scene);
    return scene;
}

static fnl_frame squares_frame(void) {
    fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE);
    frame.width = frame.height = 128;
    frame.occlusion = true;
    return frame;
}

static fnl_frame_stats render(fnl_renderer *renderer, const fnl_frame *frame) {
    fnl_frame_stats stats;
    test_render_frame(renderer, frame);
    assert_int_equal(fnl_renderer_query_stats(renderer, &stats), FNL_OK);
    return stats;
}

/* How many items the last frame's depth keeps from being occluders: at rest, in a pan, and when what hid them has gone. */
static void test_last_frame_chooses_occluders(void **state) {
    UNUSED(state);
    uint32_t wall;
    fnl_scene *scene = wall_and_squares(&wall);
    struct gpu_buffer hidden;
    assert_int_equal(gpu_buffer_create(test_device, "hidden", 256, GPU_MEMORY_READBACK, &hidden), FNL_OK);
    const uint32_t *early = hidden.mapped;
    const uint32_t count = 1 + SMALL + LARGE + BEFORE;
    spy_begin(test_device);
    fnl_renderer *renderer = test_renderer(scene);
    fnl_frame frame = squares_frame();
    fnl_frame_stats stats = render(renderer, &frame); /* has no past: everything is an occluder */
    assert_int_equal(stats.items, count);
    assert_int_equal(stats.items_occluded, SMALL + LARGE);
    spy_capture(renderer->graph, "cull occluders mark", "cull occluders hidden", &hidden);
    stats = render(renderer, &frame);
    assert_int_equal(stats.items_occluded, SMALL + LARGE);
    assert_int_equal(early[count], SMALL + LARGE);
    for (int i = 0; i < 3; i++) { /* two tiles a frame: behind the edge that comes into view nothing is known */
        frame.camera.position.x = frame.camera.target.x = 0.25f * (float)(i + 1);
        stats = render(renderer, &frame);
        print_message("a pan: %u of %llu hidden items are no occluders\n", early[count],
                      (unsigned long long)stats.items_occluded);
        assert_true(stats.items_occluded >= SMALL && early[count] + 2 >= stats.items_occluded &&
                    early[count] <= stats.items_occluded);
    }
    mat4 away = mat4_from_trs((vec3){0, 20, 2}, quat_identity(), (vec3){1, 1, 1});
    scene_move_nodes(scene, &(fnl_instance_id){.index = wall}, &away, 1);
    stats = render(renderer, &frame);
    assert_true(early[count] > SMALL / 2);
    assert_true(stats.items_occluded < LARGE); /* the squares before one another hide little */
    spy_capture(NULL, NULL, NULL, NULL);
    fnl_renderer_destroy(&renderer);
    assert_int_equal(gpu_wait_idle(test_device), FNL_OK);
    spy_end();
    gpu_buffer_destroy(test_device, &hidden);
    fnl_scene_destroy(&scene);
}

static const struct gpu_pipeline *without_levels(gpu_device *device, const struct gpu_pipeline *bound) {
    const struct gpu_compute_params *params = spy_compute_params(bound);
    if (!params || params->shader != &shader_occlusion_levels_comp) return bound;
    return gpu_compute_pipeline(device, &(struct gpu_compute_params){.shader = &shader_occlusion_test_comp});
}

/*
 * What covers at most 4 x 4 squares of 8 pixels is looked up in the first level, and everything else in one where it does: with the others
 * far, small squares are hidden and large ones are not. So no item ever reads more than 16 values, nor a coarser level than it must.
 */
static void test_levels_suit_the_size(void **state) {
    UNUSED(state);
    uint32_t wall;
    fnl_scene *scene = wall_and_squares(&wall);
    spy_begin(test_device);
    fnl_renderer *renderer = test_renderer(scene);
    fnl_frame frame = squares_frame();
    assert_int_equal(render(renderer, &frame).items_occluded, SMALL + LARGE);
    spy.replace = without_levels;
    for (int i = 0; i < 2; i++) assert_int_equal(render(renderer, &frame).items_occluded, SMALL);
    spy.replace = NULL;
    assert_int_equal(render(renderer, &frame).items_occluded, SMALL + LARGE);
    fnl_renderer_destroy(&renderer);
    assert_int_equal(gpu_wait_idle(test_device), FNL_OK);
    spy_end();
    fnl_scene_destroy(&scene);
}

/*
 * Levels of odd sizes: what is large, and seen in the last column or row of squares alone, is not hidden; nor is anything where one pixel of the
 * picture lies in that column. When the wall covers it all it is. A frame without and one with a past.
 */
static void test_levels_of_odd_sizes(void **state) {
    UNUSED(state);
    static const uint32_t sides[] = {65, 72, 36, 88, 101}; /* 9, 9, 5, 11 and 13 squares: 9 5 3 2, 9 5 3 2, 5 3 2, 11 6 3 2, 13 7 4 2 */
    for (uint32_t i = 0; i < COUNT_OF(sides); i++)
        for (uint32_t open = 0; open < 5; open++) { /* nothing, the last column, row, first column, row */
            const uint32_t side = sides[i], gap = open == 0 ? 0 : open > 2 ? 8 : (side - 1) % 8 + 1;
            fnl_scene *scene = test_scene();
            struct scene_material red = test_unlit(1, 0, 0), green = test_unlit(0, 1, 0);
            const uint32_t far = test_quad_mesh(scene, scene_add_material(scene, &green)), wall = test_quad_mesh(scene, scene_add_material(scene, &red));
            const float middle = (open == 1 || open == 4 ? -1 : 1) * (0.5f + 2 * (float)gap / (float)side); /* of the wall: x grows to the right, y upward */
            test_place(scene, far, (vec3){0, 0, 0}, (vec3){0.999f, 0.999f, 1});
            const bool column = open % 2, row = open > 0 && !column;
            test_place(scene, wall, (vec3){column ? middle : 0, row ? middle : 0, 2}, (vec3){column ? 1.5f : 3, row ? 1.5f : 3, 1});
            scene_update_transforms(scene);
            fnl_renderer *renderer = test_renderer(scene);
            fnl_frame frame = squares_frame();
            frame.width = frame.height = side;
            for (uint32_t k = 0; k < 2; k++) {
                const fnl_frame_stats stats = render(renderer, &frame);
                fnl_image picture = test_read(renderer, FNL_OUTPUT_RADIANCE);
                uint32_t seen = 0;
                for (uint32_t p = 0; p < side * side; p++) seen += test_pixel(&picture, p % side, p / side)[1] > 0;
                if (stats.items_occluded != (open == 0) || seen != gap * side)
                    fail_msg("%u pixels a side, open %u, frame %u: %u hidden, %u pixels are seen", side, open, k, (uint32_t)stats.items_occluded, seen);
                free_picture(&picture);
            }
            fnl_renderer_destroy(&renderer);
            fnl_scene_destroy(&scene);
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        {"ES-79: the last frame's depth chooses what occludes", test_last_frame_chooses_occluders, NULL, spy_tear_down, NULL},
        {"ES-79: levels of odd sizes hide nothing that is seen", test_levels_of_odd_sizes, NULL, NULL, NULL},
        {"ES-79: levels suit what is looked up", test_levels_suit_the_size, NULL, spy_tear_down, NULL}};
    return cmocka_run_group_tests(tests, test_group_begin, test_group_end);
}
