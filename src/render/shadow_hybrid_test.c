/* SPDX-License-Identifier: MIT */
/* Hybrid shadows: each light has the shadow that costs less, that of maps or that of rays, and keeps it. And auto. */
#include "render/shadow_costs.h"
#include "tests/render_harness.h"
#include "tests/shadow_cases.h"

enum { LAMPS = 24, PAGE_RAYS = 64, GRID = 6 };

/* A floor with a square above it, one light over all of it, and tiny ones just above the floor, each of which reaches some dozen pixels. */
struct world {
    struct stage s;
    fnl_light_params lamps[LAMPS];
    fnl_light_id ids[LAMPS];
    fnl_instance_id square;
};

static void move_lamps(struct world *w, float by) {
    for (uint32_t i = 0; i < LAMPS; i++) {
        w->lamps[i].position.x += by;
        assert_int_equal(fnl_scene_set_light(w->s.scene, w->ids[i], &w->lamps[i]), FNL_OK);
    }
}

static struct world world_open(bool big, bool tiny) {
    struct world w = {0};
    const fnl_material_params material = matt(1);
    fnl_scene *scene = big ? shadow_floor() : world_create(NULL);
    if (!big) add_square(scene, &material, (vec3){10, 1, 10}, (vec3){0, 0, 0});
    w.square = add_square(scene, &material, (vec3){0.5f, 1, 0.5f}, (vec3){0, 0.45f, 0});
    for (uint32_t i = 0; i < LAMPS; i++) { /* half of one is in the shadow of a stick */
        fnl_light_params *lamp = &w.lamps[i];
        *lamp = fnl_light_params_default();
        lamp->position = (vec3){-3.25f + 1.3f * (float)(i % GRID), 0.2f, -2.6f + 1.7f * (float)(i / GRID)};
        lamp->intensity = 1;
        lamp->range = 0.5f;
        if (tiny) assert_int_equal(fnl_scene_add_light(scene, lamp, &w.ids[i]), FNL_OK);
        add_square(scene, &material, (vec3){0.03f, 1, 0.07f}, (vec3){lamp->position.x + 0.11f, 0.1f, lamp->position.z + 0.02f});
    }
    w.s = stage_open_scene(scene);
    const fnl_trace_params view = look_down((vec3){0, 0, 0}, 8, 0.4f, SHADOW_SIZE);
    w.s.frame.width = view.width, w.s.frame.height = view.height;
    w.s.frame.camera = view.camera;
    w.s.frame.outputs = FNL_OUTPUT_RADIANCE;
    w.s.frame.shadows = FNL_SHADOWS_HYBRID;
    w.s.frame.shadow.page_rays = PAGE_RAYS;
    return w;
}

static fnl_frame_stats after_frame(struct stage *s) {
    assert_int_equal(fnl_renderer_render(s->renderer, &s->frame), FNL_OK);
    return harness_stats(s->renderer);
}

/* ---- which light gets what ---- */

static void test_lights_split_by_their_cost_ES_69(void **state) {
    UNUSED(state);
    struct world w = world_open(true, true);
    for (int i = 0; i < 12; i++) { /* moving */
        if (i > 0) move_lamps(&w, 0.005f);
        const fnl_frame_stats stats = after_frame(&w.s);
        if (i == 0)
            print_message("rays at most %u, pages %u of %u\n", (uint32_t)counter(&stats, "shadows.reached"), (uint32_t)counter(&stats, "shadows.drawn"),
                          (uint32_t)counter(&stats, "shadows.wanted"));
        assert_int_equal(counter(&stats, "shadows.by-rays"), LAMPS);
        assert_int_equal(counter(&stats, "shadows.by-maps"), 1);
        assert_int_equal(counter(&stats, "shadows.switched"), 0);
        assert_int_equal(counter(&stats, "shadows.traced"), 0);
        assert_int_equal(counter(&stats, "shadows.page-rays"), PAGE_RAYS);
        assert_true((counter(&stats, "shadows.drawn") > 0) == (i == 0)); /* those of the light that stands still */
    }
    uint64_t switched = 0, last = 0; /* standing still, maps are cheaper before long */
    for (uint64_t i = 0; i < 24; i++) {
        const fnl_frame_stats stats = after_frame(&w.s);
        switched += counter(&stats, "shadows.switched");
        if (counter(&stats, "shadows.switched") > 0) last = i;
        if (i == 23) assert_int_equal(counter(&stats, "shadows.by-maps"), LAMPS + 1);
        if (i == 23) assert_int_equal(counter(&stats, "shadows.drawn"), 0);
    }
    print_message("still: the last light has maps after %u frames\n", (uint32_t)last + 1);
    assert_int_equal(switched, LAMPS);
    assert_true(last > 2 && last < 20);
    switched = 0;
    for (int i = 0; i < 12; i++) { /* and rays again */
        move_lamps(&w, -0.005f);
        const fnl_frame_stats stats = after_frame(&w.s);
        switched += counter(&stats, "shadows.switched");
        if (i == 11) assert_int_equal(counter(&stats, "shadows.by-rays"), LAMPS);
    }
    assert_int_equal(switched, LAMPS);
    stage_close(&w.s);
}

/* In rays: those that were sent, and pages for what they cost. */
static uint64_t work_of(fnl_shadows shadows) {
    struct world w = world_open(true, true);
    w.s.frame.shadows = shadows;
    w.s.frame.count_lights = true;
    uint64_t rays = 0, pages = 0;
    for (int i = 0; i < 10; i++) {
        const fnl_frame_stats stats = after_frame(&w.s);
        rays += counter(&stats, "shadows.rays");
        if (has_counter(&stats, "shadows.drawn")) pages += counter(&stats, "shadows.drawn");
        if (has_counter(&stats, "shadows.reached")) assert_true(counter(&stats, "shadows.rays") <= counter(&stats, "shadows.reached"));
        move_lamps(&w, 0.005f);
    }
    print_message("%s: %u rays, %u pages\n", fnl_value_name(FNL_ENUM_SHADOWS, shadows), (uint32_t)rays, (uint32_t)pages);
    stage_close(&w.s);
    return rays + PAGE_RAYS * pages;
}

static void test_it_costs_less_than_either_ES_69(void **state) {
    UNUSED(state);
    const uint64_t hybrid = work_of(FNL_SHADOWS_HYBRID), maps = work_of(FNL_SHADOWS_MAPS), rays = work_of(FNL_SHADOWS_RAYS);
    assert_true(hybrid * 2 < maps && hybrid * 2 < rays);
}

/* Something moves before lights that stand still: their maps would be drawn in each frame, which only shows once they are there. They come back to rays, and
   try again after ever longer times. */
static void test_lights_do_not_flicker(void **state) {
    UNUSED(state);
    struct world w = world_open(false, true);
    const fnl_material_params material = matt(1);
    const fnl_mesh_id mesh = add_square_mesh(w.s.scene, add_material(w.s.scene, &material));
    const fnl_instance_id mover = add_instance(w.s.scene, mesh, mat4_translation((vec3){0, 0.45f, 0}));
    uint64_t switched = 0, late = 0, by_rays = 0;
    for (uint32_t i = 0; i < 96; i++) {
        const mat4 place = mat4_mul(mat4_translation((vec3){0.001f * (float)i, 0.45f, 0}), mat4_scaling((vec3){4, 1, 4}));
        assert_int_equal(fnl_scene_set_instance_transform(w.s.scene, mover, &place), FNL_OK);
        const fnl_frame_stats stats = after_frame(&w.s);
        switched += counter(&stats, "shadows.switched");
        if (i >= 48) late += counter(&stats, "shadows.switched");
        by_rays += counter(&stats, "shadows.by-rays");
    }
    print_message("%.2f switches for each light in 96 frames, %.2f in the later half; rays in %.0f %% of frames\n", (double)switched / LAMPS,
                  (double)late / LAMPS, 100.0 * (double)by_rays / LAMPS / 96);
    assert_true(switched <= 10 * LAMPS && late <= 4 * LAMPS);
    assert_true(by_rays > 48 * LAMPS);
    stage_close(&w.s);
}

/* ---- pictures ---- */

/* A square moves on one side of the lamps in the first column, which come back to rays. Pages on their other side are still there and true, but rays find all of the shadow. */
static void test_pages_that_are_left_over_are_not_looked_up(void **state) {
    UNUSED(state);
    struct world w = world_open(false, true);
    const fnl_material_params material = matt(1);
    const fnl_instance_id mover = add_instance(w.s.scene, add_square_mesh(w.s.scene, add_material(w.s.scene, &material)), mat4_translation((vec3){0, 0.45f, 0}));
    struct stage other = w.s;
    assert_int_equal(fnl_renderer_create(harness_device(), w.s.scene, &other.renderer), FNL_OK);
    other.frame.shadows = FNL_SHADOWS_RAYS;
    bool had_maps = false, seen = false;
    for (uint32_t i = 0; i < 40 && !seen; i++) {
        const mat4 place = mat4_mul(mat4_translation((vec3){-5.7f - 0.001f * (float)i, 0.45f, 0}), mat4_scaling((vec3){2.4f, 1, 4}));
        assert_int_equal(fnl_scene_set_instance_transform(w.s.scene, mover, &place), FNL_OK);
        const fnl_frame_stats stats = after_frame(&w.s);
        had_maps = had_maps || counter(&stats, "shadows.by-maps") == LAMPS;
        seen = had_maps && counter(&stats, "shadows.by-rays") == LAMPS / GRID;
    }
    assert_true(seen);
    struct shot rays = stage_shoot(&other, &other.frame);
    fnl_image image = {0};
    assert_int_equal(fnl_renderer_read(w.s.renderer, FNL_OUTPUT_RADIANCE, &image), FNL_OK);
    for (uint32_t y = 0; y < SHADOW_SIZE; y++)
        for (uint32_t x = 0; x < 11; x++) /* what no other column reaches */
            if (pixel_at(&image, x, y)[1] != pixel_at(&rays.radiance, x, y)[1]) fail_msg("%u %u is not what rays show", x, y);
    fnl_image_free(&w.s.renderer->host, &image);
    shot_free(&rays);
    fnl_renderer_destroy(&other.renderer);
    stage_close(&w.s);
}

static struct shot shot_of(bool big, bool tiny, fnl_shadows shadows) {
    struct world w = world_open(big, tiny);
    w.s.frame.shadows = shadows;
    struct shot shot = stage_shoot(&w.s, &w.s.frame);
    stage_close(&w.s);
    return shot;
}

static void test_each_light_has_the_shadow_of_maps_or_rays_ES_69(void **state) {
    UNUSED(state);
    struct shot big = shot_of(true, false, FNL_SHADOWS_HYBRID), big_maps = shot_of(true, false, FNL_SHADOWS_MAPS),
                tiny = shot_of(false, true, FNL_SHADOWS_HYBRID), tiny_rays = shot_of(false, true, FNL_SHADOWS_RAYS),
                tiny_maps = shot_of(false, true, FNL_SHADOWS_MAPS), open = shot_of(false, true, FNL_SHADOWS_OFF), all = shot_of(true, true, FNL_SHADOWS_HYBRID),
                again = shot_of(true, true, FNL_SHADOWS_HYBRID);
    assert_int_equal(count_differing(&big.radiance, &big_maps.radiance), 0);
    assert_int_equal(count_differing(&tiny.radiance, &tiny_rays.radiance), 0);
    assert_true(count_differing(&tiny.radiance, &tiny_maps.radiance) > 0); /* the test could tell */
    assert_true(count_differing(&tiny.radiance, &open.radiance) > 0);
    assert_int_equal(count_differing(&all.radiance, &again.radiance), 0);
    for (uint32_t y = 0; y < SHADOW_SIZE; y++)
        for (uint32_t x = 0; x < SHADOW_SIZE; x++) {
            const float got = pixel_at(&all.radiance, x, y)[1],
                        wanted = pixel_at(&big_maps.radiance, x, y)[1] + pixel_at(&tiny_rays.radiance, x, y)[1];
            if (!(fabsf(got - wanted) <= 1e-5f * fmaxf(wanted, 1))) fail_msg("%u %u: %g, must be %g", x, y, (double)got, (double)wanted);
        }
    struct shot *const shots[] = {&big, &big_maps, &tiny, &tiny_rays, &tiny_maps, &open, &all, &again};
    for (uint32_t i = 0; i < COUNT_OF(shots); i++) shot_free(shots[i]);
}

/* Pixels are counted by groups, whatever lists and paths ask for: all decide alike. Glass and samples count as well. */
static void test_lists_and_paths_decide_alike(void **state) {
    UNUSED(state);
    struct world w = world_open(true, true);
    w.s.frame.shading = FNL_SHADING_FORWARD;
    static const fnl_light_lists lists[] = {FNL_LISTS_ALL, FNL_LISTS_TILED, FNL_LISTS_CLUSTERED, FNL_LISTS_ZBIN};
    struct shot first = {0};
    for (uint32_t i = 0; i < COUNT_OF(lists); i++) {
        fnl_renderer_destroy(&w.s.renderer);
        assert_int_equal(fnl_renderer_create(harness_device(), w.s.scene, &w.s.renderer), FNL_OK);
        w.s.frame.lists = lists[i];
        struct shot shot = stage_shoot(&w.s, &w.s.frame);
        assert_int_equal(counter(&shot.stats, "shadows.by-rays"), LAMPS);
        if (i == 0) {
            first = shot;
            continue;
        }
        assert_int_equal(count_differing(&first.radiance, &shot.radiance), 0);
        shot_free(&shot);
    }
    shot_free(&first);
    w.s.frame.lists = FNL_LISTS_CLUSTERED;
    w.s.frame.msaa = 4;
    w.s.frame.shadow.page_rays = 0; /* pixels with several samples are not timed */
    const fnl_frame_stats several = after_frame(&w.s);
    assert_int_equal(counter(&several, "shadows.by-rays") + counter(&several, "shadows.by-maps"), LAMPS + 1);
    w.s.frame.msaa = 1;
    fnl_material_params glass = matt(1);
    glass.alpha_mode = FNL_ALPHA_BLEND;
    glass.base_color[3] = 0.25f;
    const uint64_t without = counter_of(w.s.renderer, "shadows.reached");
    add_square(w.s.scene, &glass, (vec3){4, 1, 4}, (vec3){0, 0.3f, 0});
    w.s.frame.shadow.page_rays = 1e6f; /* rays for all */
    fnl_renderer_destroy(&w.s.renderer);
    assert_int_equal(fnl_renderer_create(harness_device(), w.s.scene, &w.s.renderer), FNL_OK);
    const fnl_frame_stats with = after_frame(&w.s);
    assert_int_equal(counter(&with, "shadows.by-rays"), LAMPS + 1);
    assert_true(counter(&with, "shadows.reached") > 2 * 64 * 64 && counter(&with, "shadows.reached") > without);
    stage_close(&w.s);
}

/* ---- what things cost ---- */

static void test_costs_are_learned(void **state) {
    UNUSED(state);
    struct shadow_costs c = {0};
    assert_true(shadow_costs_page_rays(&c, true) == 64 && shadow_costs_page_rays(&c, false) == 1024);
    shadow_costs_feed(&c, (struct shadow_times){5, 15, 1, 63}); /* too few of both */
    shadow_costs_feed(&c, (struct shadow_times){-1, 100, 0, 1000});
    assert_true(c.page == 0 && c.ray == 0);
    shadow_costs_feed(&c, (struct shadow_times){4000, 100, 2000, 1000}); /* the first of each */
    assert_true(c.page == 0 && c.ray == 0);
    shadow_costs_feed(&c, (struct shadow_times){4, 100, 2, 1000});
    assert_float_equal(shadow_costs_page_rays(&c, true), 20, 1e-3);
    shadow_costs_feed(&c, (struct shadow_times){400, 100, 0, 0}); /* one frame that was held up */
    assert_float_equal(shadow_costs_page_rays(&c, true), 20 * (1 + 99.0 / 4), 1);
    for (int i = 0; i < 40; i++) shadow_costs_feed(&c, (struct shadow_times){2, 100, 2, 1000});
    assert_float_equal(shadow_costs_page_rays(&c, false), 10, 0.1);
    for (int i = 0; i < 99; i++) shadow_costs_feed(&c, (struct shadow_times){1e-9, 100, 2, 100});
    assert_float_equal(shadow_costs_page_rays(&c, false), 1, 0);
    uint32_t probes = 0;
    for (uint32_t i = 1; i <= 128; i++) {
        const bool probe = shadow_costs_probe(&c);
        c.frames++;
        assert_int_equal(probe, i == 3 || i == 6 || i == 64 || i == 128);
        probes += probe;
    }
    assert_int_equal(probes, 4);
}

static void test_frames_measure_their_costs(void **state) {
    UNUSED(state);
    struct stage s = stage_open("builtin:hall?lights=64", 0);
    s.frame.shadows = FNL_SHADOWS_HYBRID;
    s.frame.outputs = 0;
    for (int i = 0; i < 9; i++) {
        assert_int_equal(fnl_renderer_render(s.renderer, &s.frame), FNL_OK);
        s.frame.camera.position.x += 0.3f; /* new pages */
    }
    const struct shadow_costs c = s.renderer->shadows.costs;
    print_message("%.1f us for a page, %.2f us for a ray\n", 1e3 * c.page, 1e3 * c.ray);
    assert_true(c.ray > 0);
    assert_true(c.page > 0);
    const uint64_t rays = counter_of(s.renderer, "shadows.page-rays");
    assert_true(rays >= 1 && rays <= 1000000);
    stage_close(&s);
}

/* ---- auto ---- */

static void test_auto_takes_what_suits(void **state) {
    UNUSED(state);
    fnl_device_info info;
    assert_int_equal(fnl_device_query_info(harness_device(), &info), FNL_OK);
    struct world w = world_open(true, true);
    w.s.frame.shadows = FNL_SHADOWS_MAPS;
    struct shot maps = stage_shoot(&w.s, &w.s.frame);
    w.s.frame.shadows = FNL_SHADOWS_AUTO;
    struct shot still = stage_shoot(&w.s, &w.s.frame);
    assert_int_equal(count_differing(&maps.radiance, &still.radiance), 0);
    assert_true(has_counter(&still.stats, "shadows.pages") && !has_counter(&still.stats, "shadows.by-rays"));
    shot_free(&maps);
    shot_free(&still);
    move_lamps(&w, 0.005f);
    fnl_frame_stats stats = after_frame(&w.s);
    assert_int_equal(counter(&stats, "shadows.by-rays"), LAMPS);
    stats = after_frame(&w.s);
    assert_true(has_counter(&stats, "shadows.by-rays")); /* for a second: it does not swing */
    for (int i = 0; i < 64; i++) stats = after_frame(&w.s);
    assert_true(has_counter(&stats, "shadows.pages") && !has_counter(&stats, "shadows.by-rays"));
    stage_close(&w.s);
    struct stage dark = stage_open_scene(world_create(NULL));
    dark.frame.shadows = FNL_SHADOWS_AUTO;
    stats = after_frame(&dark);
    assert_int_equal(dark.renderer->frame.shadows, FNL_SHADOWS_OFF);
    stage_close(&dark);
    w = world_open(true, false); /* one light */
    w.s.frame.shadows = FNL_SHADOWS_AUTO;
    after_frame(&w.s);
    assert_int_equal(w.s.renderer->frame.shadows, info.ray_query && info.type != FNL_DEVICE_CPU ? FNL_SHADOWS_RAYS : FNL_SHADOWS_MAPS);
    stage_close(&w.s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_lights_split_by_their_cost_ES_69, harness_check),
        cmocka_unit_test_teardown(test_it_costs_less_than_either_ES_69, harness_check),
        cmocka_unit_test_teardown(test_lights_do_not_flicker, harness_check),
        cmocka_unit_test_teardown(test_pages_that_are_left_over_are_not_looked_up, harness_check),
        cmocka_unit_test_teardown(test_each_light_has_the_shadow_of_maps_or_rays_ES_69, harness_check),
        cmocka_unit_test_teardown(test_lists_and_paths_decide_alike, harness_check),
        cmocka_unit_test(test_costs_are_learned),
        cmocka_unit_test_teardown(test_frames_measure_their_costs, harness_check),
        cmocka_unit_test_teardown(test_auto_takes_what_suits, harness_check),
    };
    return cmocka_run_group_tests_name("shadow_hybrid", tests, harness_begin, harness_end);
}
