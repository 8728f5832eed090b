/* SPDX-License-Identifier: MIT */
/* Frames with shadow maps of directional lights: against shadows whose edges are known, against rays, and the work they cost. */
#include "tests/render_harness.h"
#include "tests/shadow_leak.h"
#include "tests/trace_world.h"

static fnl_light_id add_sun(fnl_scene *scene, vec3 direction, float lux) {
    fnl_light_params sun = fnl_light_params_default();
    sun.kind = FNL_LIGHT_DIRECTIONAL;
    sun.direction = vec3_normalize(direction);
    sun.intensity = lux;
    fnl_light_id id;
    assert_int_equal(fnl_scene_add_light(scene, &sun, &id), FNL_OK);
    return id;
}

static fnl_frame_stats after_frame(struct stage *s) {
    assert_int_equal(fnl_renderer_render(s->renderer, &s->frame), FNL_OK);
    return harness_stats(s->renderer);
}

static uint64_t counter_of_frame(struct stage *s, const char *key) {
    const fnl_frame_stats stats = after_frame(s);
    return counter(&stats, key);
}

/* ---- shadows whose edges are known ---- */

enum { SIZE = 64 };

/* A floor at a place, seen from just above it, and over it a square, 2 metres wide, a metre high. */
struct yard {
    struct stage s;
    vec3 at;
    float extent; /* metres of the floor that are seen, round `seen` */
    vec3 seen;
};

static struct yard yard_open(vec3 at, float floor_size) {
    fnl_scene *scene = world_create(NULL);
    const fnl_material_params white = matt(1);
    add_square(scene, &white, (vec3){floor_size, 1, floor_size}, at);
    add_square(scene, &white, (vec3){1, 1, 1}, vec3_add(at, (vec3){0, 1, 0}));
    struct yard y = {.s = stage_open_scene(scene), .at = at, .extent = 8, .seen = at};
    y.s.frame.width = y.s.frame.height = SIZE;
    y.s.frame.outputs = FNL_OUTPUT_RADIANCE;
    return y;
}

/* What part of the light of all suns, which are alike but for their directions, reaches each pixel. */
static void expect_shadows(struct yard *y, const vec3 *suns, uint32_t sun_count, double slack, const char *what) {
    y->s.frame.camera = look_down(y->seen, y->extent, 0.5f, SIZE).camera;
    y->s.frame.shadows = FNL_SHADOWS_OFF;
    struct shot open = stage_shoot(&y->s, &y->s.frame);
    y->s.frame.shadows = FNL_SHADOWS_MAPS;
    struct shot shadowed = stage_shoot(&y->s, &y->s.frame);
    assert_int_equal(counter(&shadowed.stats, "shadows.coarsened"), 0);
    uint32_t dark = 0, lit = 0;
    double all = 0;
    for (uint32_t i = 0; i < sun_count; i++) all += fmax(-(double)vec3_normalize(suns[i]).y, 0);
    for (uint32_t py = 0; py < SIZE; py++)
        for (uint32_t px = 0; px < SIZE; px++) {
            const double floor[2] = {(double)(y->seen.x - y->at.x) + ((px + 0.5) / SIZE - 0.5) * (double)y->extent,
                                     (double)(y->seen.z - y->at.z) + ((py + 0.5) / SIZE - 0.5) * (double)y->extent};
            double wanted = 0, edge = INFINITY;
            for (uint32_t i = 0; i < sun_count; i++) {
                const vec3 d = vec3_normalize(suns[i]);
                if (d.y >= 0) continue;
                /* Where the way to the sun is at the height of the square. */
                const double x = floor[0] + (double)(d.x / d.y), z = floor[1] + (double)(d.z / d.y),
                             inside = fmin(1 - fabs(x), 1 - fabs(z));
                edge = fmin(edge, fabs(inside));
                if (inside < 0) wanted -= (double)d.y / all;
            }
            if (edge < 0.8 * (double)y->extent / SIZE + slack) continue; /* half a texel, seen at an angle */
            const double got = (double)pixel_at(&shadowed.radiance, px, py)[1] / (double)pixel_at(&open.radiance, px, py)[1];
            if (!(fabs(got - wanted) <= 1e-3)) fail_msg("%s: at %g, %g visibility is %g, must be %g", what, floor[0], floor[1], got, wanted);
            *(wanted < 0.99 ? &dark : &lit) += 1;
        }
    assert_true(dark > 20 && lit > 20);
    shot_free(&open);
    shot_free(&shadowed);
}

static void test_known_shadows(void **state) {
    UNUSED(state);
    static const vec3 directions[] = {{0, -1, 0}, {0.5f, -1, 0.25f}, {-0.7f, -1, 0.9f}, {0.01f, -0.4f, -0.3f}};
    for (uint32_t i = 0; i < COUNT_OF(directions); i++) {
        struct yard y = yard_open((vec3){0, 0, 0}, 10);
        add_sun(y.s.scene, directions[i], 100);
        expect_shadows(&y, &directions[i], 1, 0, "one sun");
        stage_close(&y.s);
    }
    struct yard y = yard_open((vec3){0, 0, 0}, 10);
    for (uint32_t i = 0; i < 3; i++) add_sun(y.s.scene, directions[i], 100);
    add_sun(y.s.scene, (vec3){0, 1, 0}, 100); /* from below */
    expect_shadows(&y, directions, 3, 0, "three suns");
    stage_close(&y.s);
}

/* Far from the origin positions are rounded, to 0.06 mm at a kilometre. What casts may be far away, and what is seen far beyond it. */
static void test_shadows_reach_far(void **state) {
    UNUSED(state);
    const vec3 direction = {0.3f, -1, 0.2f};
    struct yard y = yard_open((vec3){900, -40, 1200}, 10);
    add_sun(y.s.scene, direction, 100);
    expect_shadows(&y, &direction, 1, 1e-3, "far from the origin");
    stage_close(&y.s);
    y = yard_open((vec3){0, 0, 0}, 4000);
    add_sun(y.s.scene, direction, 100);
    expect_shadows(&y, &direction, 1, 0, "a large floor");
    stage_close(&y.s);
    /* A square between the sun and the whole yard, a kilometre up: all of it is dark. */
    y = yard_open((vec3){0, 0, 0}, 10);
    const fnl_material_params white = matt(1);
    add_square(y.s.scene, &white, (vec3){20, 1, 20}, (vec3){-300, 1000, -200});
    add_sun(y.s.scene, direction, 100);
    y.s.frame.camera = look_down(y.seen, y.extent, 0.5f, SIZE).camera;
    y.s.frame.shadows = FNL_SHADOWS_MAPS;
    struct shot dark = stage_shoot(&y.s, &y.s.frame);
    for (uint32_t i = 0; i < SIZE * SIZE; i++) assert_true(pixel_at(&dark.radiance, i % SIZE, i / SIZE)[1] == 0);
    shot_free(&dark);
    stage_close(&y.s);
}

/* Pages that are kept while the viewer moves show what they should, wherever it goes, and however near it looks. */
static void test_shadows_stay_while_the_viewer_moves(void **state) {
    UNUSED(state);
    const vec3 direction = {0.5f, -1, 0.25f};
    struct yard y = yard_open((vec3){0, 0, 0}, 500);
    add_sun(y.s.scene, direction, 100);
    static const struct {
        float x, z, extent;
    } views[] = {{0, 0, 8}, {0.37f, -0.2f, 8}, {1, 0.4f, 6}, {0, 0.5f, 5}, {40, 3, 100}, {-150, 100, 400}, {2, 2, 7}, {0, 0, 8}};
    for (uint32_t i = 0; i < COUNT_OF(views); i++) {
        y.seen = (vec3){views[i].x, 0, views[i].z};
        y.extent = views[i].extent;
        if (y.extent < 20) expect_shadows(&y, &direction, 1, 0, "moving");
        else counter_of_frame(&y.s, "shadows.pages");
    }
    stage_close(&y.s);
}

/* Wherever the viewer has been before, the picture is the same, but for what rounds at another place in the atlas. */
static void test_pages_of_other_places_do_no_harm(void **state) {
    UNUSED(state);
    struct stage s = stage_open("builtin:city?lights=16&sun=1000", 0);
    s.frame.shadows = FNL_SHADOWS_MAPS;
    s.frame.outputs = FNL_OUTPUT_RADIANCE;
    const fnl_camera start = s.frame.camera;
    static const vec3 ways[] = {{0, 0, 0}, {0.3f, 0, -0.5f}, {2, 0.5f, -3}, {10, 30, 60}, {-200, 100, 300}, {1, 0, 0}};
    for (uint32_t i = 0; i < COUNT_OF(ways); i++) {
        s.frame.camera.position = vec3_add(start.position, ways[i]);
        s.frame.camera.target = vec3_add(start.target, ways[i]);
        assert_int_equal(fnl_renderer_render(s.renderer, &s.frame), FNL_OK);
    }
    struct shot after = stage_shoot(&s, &s.frame);
    assert_true(counter(&after.stats, "shadows.pages") > counter(&after.stats, "shadows.wanted")); /* of the other places */
    fnl_renderer_destroy(&s.renderer);
    assert_int_equal(fnl_renderer_create(harness_device(), s.scene, &s.renderer), FNL_OK);
    struct shot alone = stage_shoot(&s, &s.frame);
    assert_true(count_differing(&after.radiance, &alone.radiance) < 8);
    shot_free(&after);
    shot_free(&alone);
    stage_close(&s);
}

/* ---- against rays ---- */

static void expect_leak(struct stage *s, const char *what, double most, double dark) {
    s->frame.shadow.memory = 256;
    s->frame.width = 160, s->frame.height = 90;
    const struct shadow_leak leak = shadow_leak_of(s, 2);
    print_message("%s: %.2f %% of the light is wrong, %.1f %% is in shadow, %u pixels are wrong far from edges\n", what, 100 * leak.error,
                  100 * leak.dark, leak.far_off);
    if (leak.error > most || leak.far_off > 160 * 90 / 500) fail_msg("%s: at most %.2f %%", what, 100 * most);
    assert_true(leak.dark > dark);
}

static void test_maps_are_what_rays_show(void **state) {
    UNUSED(state);
    struct stage s = stage_open("builtin:city?lights=0&sun=1000", 0);
    expect_leak(&s, "city", 0.07, 0.2);
    s.frame.camera.orthographic = true;
    s.frame.camera.vertical_extent = 20;
    expect_leak(&s, "city, orthographic", 0.03, 0.05);
    stage_close(&s);
    s = stage_open("builtin:spheres?lights=8&sun=1000", 0);
    expect_leak(&s, "spheres", 0.01, 0.01);
    stage_close(&s);
    s = stage_open("Fox.glb", 0); /* one item, which moves */
    add_sun(s.scene, (vec3){0.3f, -1, -0.4f}, 1000);
    s.frame.shadows = FNL_SHADOWS_MAPS;
    after_frame(&s);
    assert_int_equal(fnl_scene_set_time(s.scene, 0, 0.4), FNL_OK);
    expect_leak(&s, "Fox", 0.03, 0.01);
    stage_close(&s);
}

/* ---- work ---- */

static void test_pages_are_few_and_are_kept(void **state) {
    UNUSED(state);
    struct stage s = stage_open("builtin:city?lights=0&sun=1000", 0);
    s.frame.width = 320, s.frame.height = 180;
    s.frame.shadows = FNL_SHADOWS_MAPS;
    fnl_frame_stats stats = after_frame(&s);
    const uint64_t pages = counter(&stats, "shadows.wanted");
    /* Texels are no wider than pixels and more than half as wide. */
    print_message("%u pages\n", (uint32_t)pages);
    assert_true(pages >= 320 * 180 / (120 * 120) && pages < 100);
    assert_int_equal(counter(&stats, "shadows.drawn"), pages);
    assert_true(counter(&stats, "shadows.pairs") < pages * stats.items / 20);
    stats = after_frame(&s);
    assert_int_equal(counter(&stats, "shadows.drawn"), 0);
    assert_int_equal(counter(&stats, "shadows.pages"), pages);
    const fnl_camera before = s.frame.camera;
    s.frame.camera.position.x += 0.2f;
    s.frame.camera.target.x += 0.2f;
    const uint64_t fresh = counter_of_frame(&s, "shadows.drawn");
    print_message("%u are drawn when the viewer moves\n", (uint32_t)fresh);
    assert_true(fresh < pages / 2);
    s.frame.camera = before;
    assert_int_equal(counter_of_frame(&s, "shadows.drawn"), 0);
    stage_close(&s);
}

static void test_changes_are_drawn(void **state) {
    UNUSED(state);
    struct yard y = yard_open((vec3){0, 0, 0}, 10);
    fnl_light_params sun = fnl_light_params_default();
    const fnl_light_id id = add_sun(y.s.scene, (vec3){0.1f, -1, 0}, 100);
    const fnl_material_params white = matt(1);
    const fnl_instance_id small = add_square(y.s.scene, &white, (vec3){0.1f, 1, 0.1f}, (vec3){3, 1, 3});
    y.s.frame.camera = look_down(y.seen, 16, 0.5f, 256).camera;
    y.s.frame.width = y.s.frame.height = 256;
    y.s.frame.shadows = FNL_SHADOWS_MAPS;
    const uint64_t pages = counter_of_frame(&y.s, "shadows.drawn");
    assert_true(pages >= 4);
    assert_int_equal(counter_of_frame(&y.s, "shadows.drawn"), 0);
    const mat4 moved = mat4_mul(mat4_translation((vec3){3.1f, 1, 3}), mat4_scaling((vec3){0.1f, 1, 0.1f}));
    assert_int_equal(fnl_scene_set_instance_transform(y.s.scene, small, &moved), FNL_OK);
    const uint64_t touched = counter_of_frame(&y.s, "shadows.drawn");
    assert_true(touched > 0 && touched < pages);
    assert_int_equal(counter_of_frame(&y.s, "shadows.drawn"), 0);
    const mat4 raised = mat4_mul(mat4_translation((vec3){3.1f, 1.02f, 3}), mat4_scaling((vec3){0.1f, 1, 0.1f})); /* above all else: the scene is larger */
    assert_int_equal(fnl_scene_set_instance_transform(y.s.scene, small, &raised), FNL_OK);
    const uint64_t larger = counter_of_frame(&y.s, "shadows.drawn");
    assert_true(larger > 0 && larger < pages);
    sun.kind = FNL_LIGHT_DIRECTIONAL;
    sun.direction = vec3_normalize((vec3){0.11f, -1, 0});
    sun.intensity = 100;
    assert_int_equal(fnl_scene_set_light(y.s.scene, id, &sun), FNL_OK);
    fnl_frame_stats stats = after_frame(&y.s);
    assert_int_equal(counter(&stats, "shadows.drawn"), counter(&stats, "shadows.wanted"));
    sun.intensity = 50; /* does not change the shadows */
    assert_int_equal(fnl_scene_set_light(y.s.scene, id, &sun), FNL_OK);
    assert_int_equal(counter_of_frame(&y.s, "shadows.drawn"), 0);
    sun.intensity = 0;
    assert_int_equal(fnl_scene_set_light(y.s.scene, id, &sun), FNL_OK);
    assert_int_equal(counter_of_frame(&y.s, "shadows.wanted"), 0);
    stage_close(&y.s);
}

/* A sun needs no rays: neither their pipelines nor the tree over triangles. */
static void test_suns_trace_no_rays(void **state) {
    UNUSED(state);
    struct stage s = stage_open("builtin:spheres?lights=4&sun=1000", 0);
    s.frame.shadows = FNL_SHADOWS_MAPS;
    after_frame(&s);
    assert_null(s.renderer->device_scene->ray_meshes.handle);
    s.frame.shadows = FNL_SHADOWS_RAYS;
    after_frame(&s);
    assert_non_null(s.renderer->device_scene->ray_meshes.handle);
    stage_close(&s);
}

/* With a megabyte for everything, the sun's shadow is coarser and is there. */
static void test_small_budgets_make_maps_coarser(void **state) {
    UNUSED(state);
    struct stage s = stage_open("builtin:city?lights=64&sun=1000", 0);
    static const uint32_t budgets[] = {256, 1};
    for (uint32_t i = 0; i < COUNT_OF(budgets); i++) {
        s.frame.shadow.memory = budgets[i];
        const struct shadow_leak leak = shadow_leak_of(&s, 2);
        const fnl_frame_stats stats = harness_stats(s.renderer);
        print_message("%u MiB: %.2f %% wrong, %.1f %% dark, %u coarser\n", budgets[i], 100 * leak.error, 100 * leak.dark,
                      (uint32_t)counter(&stats, "shadows.coarsened"));
        assert_true((counter(&stats, "shadows.coarsened") > 0) == (i > 0) && counter(&stats, "shadows.coarsened") <= 65);
        assert_int_equal(counter(&stats, "shadows.traced"), 0);
        assert_true(leak.error < leak.dark / 2);
    }
    stage_close(&s);
    s = stage_open("builtin:city?lights=0&sun=1000", 0);
    s.frame.shadow.memory = 1;
    s.frame.shadows = FNL_SHADOWS_MAPS;
    assert_int_equal(counter_of_frame(&s, "shadows.coarsened"), 1); /* one light, whatever the number of its rows */
    stage_close(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_known_shadows, harness_check),
        cmocka_unit_test_teardown(test_shadows_reach_far, harness_check),
        cmocka_unit_test_teardown(test_shadows_stay_while_the_viewer_moves, harness_check),
        cmocka_unit_test_teardown(test_pages_of_other_places_do_no_harm, harness_check),
        cmocka_unit_test_teardown(test_maps_are_what_rays_show, harness_check),
        cmocka_unit_test_teardown(test_pages_are_few_and_are_kept, harness_check),
        cmocka_unit_test_teardown(test_changes_are_drawn, harness_check),
        cmocka_unit_test_teardown(test_suns_trace_no_rays, harness_check),
        cmocka_unit_test_teardown(test_small_budgets_make_maps_coarser, harness_check),
    };
    return cmocka_run_group_tests_name("shadow_suns", tests, harness_begin, harness_end);
}
