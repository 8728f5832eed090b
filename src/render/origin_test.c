/* SPDX-License-Identifier: MIT */
/**
 * Pictures do not depend on the origin (fnl_scene_set_origin), near 0, 0, 0 and on the far side of the planet. A
 * renderer keeps its lights, shadows, captures and history while the origin moves.
 */
#include "tests/render_harness.h"

static const double home[3] = {0, 0, 0}, far[3] = {6371000, 1024, -3000000};

/* Less than any move of an origin that follows a camera, but enough to change the scene's floats. */
static const double step[3] = {48, -16, 32};

/* Moves the whole scene together with the origin, so its floats stay the same. */
static void carry(fnl_scene *scene, const double by[3]) {
    for (int i = 0; i < 3; i++) {
        scene->origin[i] += by[i];
        for (uint32_t n = 0; n < scene->nodes.count; n++) {
            struct scene_node *node = &scene->nodes.data[n];
            if (node->parent == SCENE_NONE) node->local_exact.m[9 + i] += by[i];
            if (node->parent == SCENE_NONE && !node->has_matrix) node->translation[i] += by[i];
        }
        for (uint32_t n = 0; n < scene->lights.count; n++) {
            scene->lights.data[n].place[i] += by[i];
            if (scene->lights.data[n].hull) scene->lights.data[n].hull->place[i] += by[i];
        }
        for (uint32_t n = 0; n < scene->decals.count; n++) scene->decals.data[n].place[i] += by[i];
        for (uint32_t n = 0; n < scene->probes.count; n++) scene->probes.data[n].place[i] += by[i];
        for (uint32_t n = 0; n < scene->cameras.count; n++) scene->cameras.data[n].place[i] += by[i];
    }
    scene_update_transforms(scene);
}

/* Moves the origin to `base` + `by`. The camera, which is `from` relative to `base`, stays in place. */
static void move_origin(struct stage *s, const double base[3], const double by[3], const fnl_camera *from) {
    double to[3];
    fnl_camera *c = &s->frame.camera;
    *c = *from;
    for (int i = 0; i < 3; i++) {
        to[i] = base[i] + by[i];
        (&c->position.x)[i] -= (float)by[i];
        (&c->target.x)[i] -= (float)by[i];
    }
    assert_int_equal(fnl_scene_set_origin(s->scene, to), FNL_OK);
}

static const float hull[] = {-3, 0, 0, 3, 0, 0, 0, 5, 0, 0, 1, 6};

/* Lights of all kinds, decals, and reflection probes. */
static struct stage open_world(const char *source) {
    struct stage s = stage_open(source, 0);
    s.frame.width = 96;
    s.frame.height = 54;
    fnl_probe_params probe = fnl_probe_params_default();
    fnl_scatter_params scatter = fnl_scatter_params_default();
    fnl_light_params light = fnl_light_params_default();
    fnl_light_id id;
    scatter.count = 24;
    for (int i = 0; i < FNL_LIGHT_KIND_COUNT; i++) scatter.shares[i] = i == FNL_LIGHT_DIRECTIONAL ? 0 : 1;
    probe.face_size = 16;
    probe.reflection = true;
    light.position = vec3_make(0, 3, 0);
    light.range = 8;
    assert_int_equal(fnl_scene_scatter_light_shapes(s.scene, &scatter), FNL_OK);
    assert_int_equal(fnl_scene_add_light(s.scene, &light, &id), FNL_OK);
    assert_int_equal(fnl_scene_set_light_hull(s.scene, id, (const fnl_vec3 *)(const void *)hull, 4), FNL_OK);
    assert_int_equal(fnl_scene_scatter_decals(s.scene, 12, 1), FNL_OK);
    assert_int_equal(fnl_scene_place_probes(s.scene, &probe, 2, NULL), FNL_OK);
    return s;
}

static const struct way {
    fnl_shading shading;
    fnl_light_lists lists;
    fnl_shadows shadows;
} ways[] = {
    {FNL_SHADING_DEFERRED, FNL_LISTS_CLUSTERED, FNL_SHADOWS_MAPS},
    {FNL_SHADING_FORWARD, FNL_LISTS_WORLD, FNL_SHADOWS_RAYS},
    {FNL_SHADING_DEFERRED, FNL_LISTS_CLUSTERED, FNL_SHADOWS_CUBEMAP},
};

static void expect_near(const char *what, const struct shot *a, const struct shot *b, uint32_t way) {
    const uint64_t pixels = (uint64_t)a->color.width * a->color.height, off = count_beyond(&a->color, &b->color, 2);
    const fnl_image *c = &a->color;
    uint64_t lit = 0;
    for (uint64_t i = 0; i < pixels; i++) lit += ((const uint8_t *)c->pixels)[4 * i + 1] > 8;
    print_message("%s, way %u: %llu of %llu pixels off, %llu lit\n", what, way, (unsigned long long)off, (unsigned long long)pixels, (unsigned long long)lit);
    assert_true(lit > pixels / 4);
    if (off * 1000 > pixels + 999) fail_msg("%s, way %u: %llu of %llu pixels are off", what, way, (unsigned long long)off, (unsigned long long)pixels);
}

/* One renderer: before the origin moves, after, and once it is back. The last picture equals the first to the bit. */
static void check_way(const char *source, const double base[3], uint32_t number) {
    const struct way *way = &ways[number];
    struct stage s = open_world(source);
    carry(s.scene, base);
    s.frame.shading = way->shading;
    s.frame.lists = way->lists;
    s.frame.shadows = way->shadows;
    const fnl_camera camera = s.frame.camera;
    struct shot first = stage_shoot(&s, &s.frame);
    shot_free(&first);
    first = stage_shoot(&s, &s.frame);
    const struct box bounds = s.renderer->device_scene->bounds;
    move_origin(&s, base, step, &camera);
    struct shot moved = stage_shoot(&s, &s.frame);
    expect_near("moved", &first, &moved, number);
    assert_int_equal(counter(&moved.stats, "reflections.captures"), 0);
    const struct box now = s.renderer->device_scene->bounds;
    for (int i = 0; i < 3; i++) { /* the bounds have moved along, and have not grown */
        assert_true(fabs((double)(&now.low.x)[i] + step[i] - (double)(&bounds.low.x)[i]) < 1e-4);
        assert_true(fabs((double)(&now.high.x)[i] + step[i] - (double)(&bounds.high.x)[i]) < 1e-4);
    }
    move_origin(&s, base, home, &camera);
    struct shot back = stage_shoot(&s, &s.frame);
    assert_int_equal(count_differing(&first.radiance, &back.radiance), 0);
    shot_free(&first);
    shot_free(&moved);
    shot_free(&back);
    stage_close(&s);
}

static void test_pictures_with_any_origin(void **state) {
    UNUSED(state);
    for (uint32_t i = 0; i < COUNT_OF(ways); i++) check_way(ways[i].shadows == FNL_SHADOWS_CUBEMAP ? "builtin:room" : "builtin:hall?lights=8", i % 2 ? far : home, i);
}

/* Motion vectors in pixels. The camera and the animation move between two frames, and the origin moves by `by`. */
static fnl_image motion(const char *source, const double by[3], uint32_t *moving) {
    struct stage s = stage_open(source, 0);
    s.frame.outputs = FNL_OUTPUT_COLOR | FNL_OUTPUT_MOTION;
    s.frame.width = 120;
    s.frame.height = 68;
    s.frame.shading = FNL_SHADING_DEFERRED;
    s.frame.lists = FNL_LISTS_CLUSTERED;
    assert_int_equal(fnl_scene_set_time(s.scene, 0, 0.1), FNL_OK);
    assert_int_equal(fnl_renderer_render(s.renderer, &s.frame), FNL_OK);
    assert_int_equal(fnl_scene_set_time(s.scene, 0, 0.2), FNL_OK);
    s.frame.camera.position.x += 0.01f * vec3_distance(s.frame.camera.position, s.frame.camera.target);
    const fnl_camera camera = s.frame.camera;
    move_origin(&s, home, by, &camera);
    assert_int_equal(fnl_renderer_render(s.renderer, &s.frame), FNL_OK);
    fnl_image image = {0};
    assert_int_equal(fnl_renderer_read(s.renderer, FNL_OUTPUT_MOTION, &image), FNL_OK);
    *moving = 0;
    for (uint32_t i = 0; i < image.width * image.height; i++) {
        const float *v = (const float *)image.pixels + 4 * (size_t)i;
        *moving += fabsf(v[0]) + fabsf(v[1]) > 0.05f;
    }
    stage_close(&s);
    return image;
}

static void test_motion_over_a_moved_origin(void **state) {
    UNUSED(state);
    static const char *const sources[] = {"builtin:room", "Fox.glb"};
    for (size_t i = 0; i < COUNT_OF(sources); i++) {
        uint32_t moving, moving_too, off = 0;
        fnl_image a = motion(sources[i], home, &moving), b = motion(sources[i], step, &moving_too);
        assert_true(a.width == b.width && moving > 200);
        for (uint32_t p = 0; p < a.width * a.height; p++) {
            const float *x = (const float *)a.pixels + 4 * (size_t)p, *y = (const float *)b.pixels + 4 * (size_t)p;
            off += !(fabsf(x[0] - y[0]) < 0.02f && fabsf(x[1] - y[1]) < 0.02f);
        }
        print_message("%s: motion of %u pixels, %u off\n", sources[i], moving, off);
        assert_true(off <= a.width * a.height / 1000);
        fnl_image_free(gpu_host(harness_device()), &a);
        fnl_image_free(gpu_host(harness_device()), &b);
    }
}

/* Temporal antialiasing keeps its history: the picture matches frames without a move, not a reset history. */
static void test_history_over_a_moved_origin(void **state) {
    UNUSED(state);
    enum { FRAMES = 12 };
    fnl_image pictures[3] = {0};
    for (int run = 0; run < 3; run++) { /* 0: at rest; 1: the origin moves before the last frame; 2: a reset there */
        struct stage s = stage_open("builtin:room", 0);
        s.frame.aa = FNL_ANTIALIASING_TAA;
        s.frame.outputs = FNL_OUTPUT_COLOR;
        s.frame.shading = FNL_SHADING_DEFERRED;
        s.frame.lists = FNL_LISTS_CLUSTERED;
        for (int i = 0; i < FRAMES; i++) {
            const fnl_camera camera = s.frame.camera;
            if (run == 1 && i == FRAMES - 1) move_origin(&s, home, step, &camera);
            s.frame.reset_history = run == 2 && i == FRAMES - 1;
            assert_int_equal(fnl_renderer_render(s.renderer, &s.frame), FNL_OK);
        }
        assert_int_equal(fnl_renderer_read(s.renderer, FNL_OUTPUT_COLOR, &pictures[run]), FNL_OK);
        stage_close(&s);
    }
    const uint64_t moved = count_beyond(&pictures[0], &pictures[1], 4), lost = count_beyond(&pictures[0], &pictures[2], 4);
    print_message("moved: %llu pixels off, history lost: %llu\n", (unsigned long long)moved, (unsigned long long)lost);
    assert_true(lost > 100 && moved * 10 < lost);
    for (int i = 0; i < 3; i++) fnl_image_free(gpu_host(harness_device()), &pictures[i]);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_pictures_with_any_origin, harness_check),
        cmocka_unit_test_teardown(test_motion_over_a_moved_origin, harness_check),
        cmocka_unit_test_teardown(test_history_over_a_moved_origin, harness_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
