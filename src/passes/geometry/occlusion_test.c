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

int main(void) {
    const struct CMUnitTest tests[] = {
        {"ES-79: the last frame's depth chooses what occludes", test_last_frame_chooses_occluders, NULL, spy_tear_down, NULL},
        {"ES-79: levels suit what is looked up", test_levels_suit_the_size, NULL, spy_tear_down, NULL}};
    return cmocka_run_group_tests(tests, test_group_begin, test_group_end);
}
