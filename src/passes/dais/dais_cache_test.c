/* SPDX-License-Identifier: MIT */
/** Deferred attribute interpolation: the cache of stored triangles. */
#include "tests/render_test.h"

#include "tests/dais_cases.h"

static void test_cache(void **state) {
    UNUSED(state);
    fnl_scene *scene = soup_scene(&confetti);
    fnl_renderer *renderer = test_renderer(scene);
    for (uint32_t samples = 1; samples <= 4; samples *= 4) {
        fnl_frame frame = wide_frame(0);
        frame.count_lights = true;
        frame.msaa = samples;
        fnl_image first = {0};
        static const uint32_t buckets[] = {1 << 16, 64, 2, 1};
        for (uint32_t i = 0; i < COUNT_OF(buckets); i++) {
            frame.dais.cache_buckets = buckets[i];
            fnl_image radiance = shoot(renderer, &frame);
            fnl_frame_stats stats = harness_stats(renderer);
            print_message("%u samples, %u buckets: %u triangles for %u, %u failures\n", samples, buckets[i],
                          (uint32_t)counter(&stats, "dais.triangles"), (uint32_t)counter(&stats, "dais.unique"),
                          (uint32_t)counter(&stats, "dais.cache-failures"));
            assert_true(counter(&stats, "dais.unique") > 400 &&
                        counter(&stats, "dais.triangles") >= counter(&stats, "dais.unique"));
            assert_int_equal(counter(&stats, "dais.overflow"), 0);
            /* Locks are given back: but for threads that lose the processor in the middle, nobody waits in vain. */
            assert_true(counter(&stats, "dais.cache-failures") * 2 < counter(&stats, "dais.triangles"));
            if (i == 0) {
                assert_true(counter(&stats, "dais.triangles") <= counter(&stats, "dais.unique") * 1.02 + 4);
                first = radiance;
                continue;
            }
            assert_true(test_equal(&first, &radiance));
            free_picture(&radiance);
        }
        free_picture(&first);
    }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/*
 * Strips of two triangles across the picture, triangle s and s + STRIPS each: fragments of both come in turns wherever the picture is drawn
 * in parts. With STRIPS buckets these two share one, which holds both, so each is stored once whatever the order; with twice as many each
 * has its own. With one bucket for all eight most are stored again and again.
 */
static void test_buckets_keep_two(void **state) {
    UNUSED(state);
    enum { STRIPS = 4 };
    fnl_scene *scene = test_scene();
    struct scene_material white = test_unlit(1, 1, 1);
    vec3 *positions = ARENA_ARRAY(&scene->arena, vec3, 4 * STRIPS);
    uint32_t *indices = ARENA_ARRAY(&scene->arena, uint32_t, 6 * STRIPS);
    for (uint32_t i = 0; i < STRIPS; i++) {
        for (uint32_t v = 0; v < 4; v++)
            positions[4 * i + v] = (vec3){v & 1 ? 2.6f : -2.6f, (float)(i + v / 2) * 0.8f - 1.6f, 0};
        const uint32_t corners[6] = {0, 1, 2, 1, 3, 2};
        for (uint32_t v = 0; v < 3; v++) {
            indices[3 * i + v] = 4 * i + corners[v];
            indices[3 * (i + STRIPS) + v] = 4 * i + corners[3 + v];
        }
    }
    struct scene_primitive primitive = {.material = scene_add_material(scene, &white),
                                        .vertex_count = 4 * STRIPS,
                                        .index_count = 6 * STRIPS,
                                        .indices = indices,
                                        .positions = positions};
    assert_int_equal(mesh_complete(&scene->arena, &primitive), FNL_OK);
    test_place(scene, scene_add_mesh(scene, "", &primitive, 1), (vec3){0, 0, 0}, (vec3){1, 1, 1});
    fnl_renderer *renderer = test_renderer(scene);
    for (uint32_t samples = 1; samples <= 4; samples *= 4)
        for (uint32_t buckets = 1; buckets <= 4 * STRIPS; buckets *= 2) {
            fnl_frame frame = wide_frame(0);
            frame.width = 300; /* five tiles of the CPU driver */
            frame.count_lights = true;
            frame.msaa = samples;
            frame.dais.cache_buckets = buckets;
            fnl_image radiance = shoot(renderer, &frame);
            uint32_t triangles = (uint32_t)counter_of(renderer, "dais.triangles"),
                     failures = (uint32_t)counter_of(renderer, "dais.cache-failures");
            print_message("%u samples, %u buckets: %u triangles stored, %u for locks\n", samples, buckets, triangles,
                          failures);
            assert_int_equal(counter_of(renderer, "dais.unique"), 2 * STRIPS);
            if (buckets >= STRIPS) assert_int_equal(triangles - failures, 2 * STRIPS);
            free_picture(&radiance);
        }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* Who cannot lock a bucket stores the triangle for itself: the same picture, to the bit, and every record is told of. */
static void test_locked(void **state) {
    UNUSED(state);
    fnl_scene *scene = soup_scene(&confetti);
    fnl_renderer *renderer = test_renderer(scene);
    for (uint32_t i = 0; i < 4; i++) {
        fnl_frame frame = wide_frame(0);
        frame.count_lights = true;
        frame.msaa = i & 1 ? 4 : 1;
        frame.dais.mode = (fnl_dais_mode)(i >> 1);
        fnl_image usual = shoot(renderer, &frame);
        uint32_t unique = counter_of(renderer, "dais.unique"), shaded = counter_of(renderer, "dais.shaded");
        harness_hooks(renderer)->dais_impatient = true;
        fnl_image locked = shoot(renderer, &frame);
        for (uint32_t turns = 0; counter_of(renderer, "dais.overflow") && turns < 12; turns++) {
            free_picture(&locked);
            locked = shoot(renderer, &frame);
        }
        fnl_frame_stats stats = harness_stats(renderer);
        print_message("%u samples, %s: %u triangles stored for %u\n", frame.msaa,
                      fnl_value_name(FNL_ENUM_DAIS_MODE, frame.dais.mode), (uint32_t)counter(&stats, "dais.triangles"),
                      (uint32_t)counter(&stats, "dais.unique"));
        assert_true(test_equal(&usual, &locked));
        assert_true(counter(&stats, "dais.overflow") == 0 && counter(&stats, "dais.unique") == unique &&
                    counter(&stats, "dais.shaded") == shaded);
        assert_true(counter(&stats, "dais.cache-failures") == counter(&stats, "dais.triangles") &&
                    counter(&stats, "dais.triangles") > unique * 2);
        frame.outputs |= FNL_OUTPUT_COLOR;
        frame.debug = FNL_DEBUG_DAIS_FAILURES;
        test_render_frame(renderer, &frame);
        fnl_image view = test_read(renderer, FNL_OUTPUT_COLOR);
        uint32_t red = 0, other = 0;
        for (uint32_t y = 0; y < frame.height; y++)
            for (uint32_t x = 0; x < frame.width; x++) {
                const uint8_t *p = test_pixel8(&view, x, y);
                red += p[0] > p[1];
                other += p[0] == p[1] && p[0] > 0;
            }
        assert_true(red > 2000 && other == 0);
        free_picture(&view);
        free_picture(&usual);
        free_picture(&locked);
        harness_hooks(renderer)->dais_impatient = false;
    }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        {"DI-4, DI-5: caches of any size, a single bucket too", test_cache, NULL, NULL, NULL},
        {"DI-4: a bucket holds two triangles, each stored once", test_buckets_keep_two, NULL, NULL, NULL},
        {"DI-5: buckets that stay locked cost memory, not the picture", test_locked, NULL, NULL, NULL}};
    return cmocka_run_group_tests(tests, test_group_begin, test_group_end);
}
