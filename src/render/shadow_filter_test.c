/* SPDX-License-Identifier: MIT */
/* Filtered shadow maps: penumbras against the tracer, edges that are known, surfaces that must not shadow themselves, and the pages they cost. */
#include "tests/render_harness.h"
#include "tests/shadow_cases.h"
#include "tests/shadow_leak.h"
#include "tests/shadow_paths.h"

enum { SIZE = 48 };

static const char *name_of(fnl_shadow_filter filter) { return fnl_value_name(FNL_ENUM_SHADOW_FILTER, filter); }

/* ---- penumbras ---- */

static fnl_light_params lamp_of(fnl_light_kind kind, float radius) {
    fnl_light_params lamp = fnl_light_params_default();
    lamp.kind = kind;
    lamp.position = (vec3){0.2f, kind == FNL_LIGHT_BOX ? 1.5f : 4, 0.1f};
    lamp.direction = (vec3){0, -1, 0};
    lamp.up = (vec3){0, 0, 1};
    lamp.intensity = 20;
    if (kind != FNL_LIGHT_BOX) lamp.range = 20;
    lamp.outer_cone_angle = lamp.inner_cone_angle = 1.2f;
    lamp.wedge_angles[0] = lamp.wedge_angles[1] = 1.1f;
    lamp.box_size = (vec3){8, 8, 5};
    lamp.inner_fraction = 1;
    lamp.source_radius = radius;
    lamp.source_angle = atanf(radius / 4);
    return lamp;
}

/* A half-plane at a height covers one side of a floor, seen from below it. */
static struct stage open_half_covered(const fnl_light_params *lamp, float height, fnl_trace_params *view) {
    fnl_scene *scene = world_create(NULL);
    const fnl_material_params white = matt(1);
    fnl_light_id id;
    add_square(scene, &white, (vec3){10, 1, 10}, (vec3){0, 0, 0});
    add_square(scene, &white, (vec3){10, 1, 10}, (vec3){10, height, 0});
    assert_int_equal(fnl_scene_add_light(scene, lamp, &id), FNL_OK);
    struct stage s = stage_open_scene(scene);
    *view = look_down((vec3){0, 0, 0}, 3, 0.2f, SIZE);
    s.frame.width = s.frame.height = SIZE;
    s.frame.camera = view->camera;
    s.frame.outputs = FNL_OUTPUT_RADIANCE;
    s.frame.shadows = FNL_SHADOWS_MAPS;
    return s;
}

struct penumbra {
    double columns[SIZE]; /* mean visibility of the columns, which run along the edge */
    double width;         /* metres from where nine tenths of the source are seen to where one is */
};

static struct penumbra penumbra_of(const float *seen) {
    struct penumbra p = {0};
    double at[2] = {0};
    for (uint32_t x = 0; x < SIZE; x++) {
        for (uint32_t y = 0; y < SIZE; y++) p.columns[x] += (double)seen[y * SIZE + x] / SIZE;
        for (int i = 0; i < 2; i++) {
            const double limit = i ? 0.1 : 0.9;
            if (x && p.columns[x - 1] >= limit && p.columns[x] < limit)
                at[i] = x - 1 + (p.columns[x - 1] - limit) / (p.columns[x - 1] - p.columns[x]);
        }
    }
    p.width = (at[1] - at[0]) * 3 / SIZE;
    return p;
}

static double distance_of(const struct penumbra *a, const struct penumbra *b) {
    double sum = 0;
    for (uint32_t x = 0; x < SIZE; x++) sum += (a->columns[x] - b->columns[x]) * (a->columns[x] - b->columns[x]) / SIZE;
    return sqrt(sum);
}

static struct penumbra truth_of(const fnl_scene *scene, const fnl_trace_params *view) {
    static float seen[SIZE * SIZE];
    fnl_trace_params p = *view;
    p.visibility = true;
    p.samples = 256;
    fnl_trace trace = trace_scene(scene, &p);
    for (uint32_t i = 0; i < SIZE * SIZE; i++) seen[i] = pixel_at(&trace.visibility, i % SIZE, i / SIZE)[0];
    fnl_trace_free(NULL, &trace);
    return penumbra_of(seen);
}

/* Penumbras widen with the distance of blocker and receiver, and are those of the tracer. */
static void test_penumbras_are_those_of_the_tracer_MP_8(void **state) {
    UNUSED(state);
    static const fnl_light_kind kinds[] = {FNL_LIGHT_POINT, FNL_LIGHT_SPOT, FNL_LIGHT_WEDGE, FNL_LIGHT_BOX, FNL_LIGHT_DIRECTIONAL};
    static const float heights[] = {1, 2, 2.8f};
    static float seen[SIZE * SIZE];
    for (uint32_t k = 0; k < COUNT_OF(kinds); k++) {
        double last = 0;
        for (uint32_t i = 0; i < COUNT_OF(heights); i += kinds[k] == FNL_LIGHT_POINT ? 1 : 3) {
            const fnl_light_params lamp = lamp_of(kinds[k], 0.3f);
            fnl_trace_params view;
            struct stage s = open_half_covered(&lamp, heights[i], &view);
            const struct penumbra truth = truth_of(s.scene, &view);
            shadow_parts(&s, seen);
            const struct penumbra hard = penumbra_of(seen);
            s.frame.shadow.filter = FNL_SHADOW_FILTER_PCSS;
            shadow_parts(&s, seen);
            const struct penumbra soft = penumbra_of(seen);
            const double error = distance_of(&soft, &truth), before = distance_of(&hard, &truth);
            print_message("%s, %g m: %.2f m wide, true %.2f m; error %.3f, of hard shadows %.3f\n", fnl_value_name(FNL_ENUM_LIGHT_KIND, kinds[k]),
                          (double)heights[i], soft.width, truth.width, error, before);
            if (error > fmax(0.03, before * 0.6)) fail_msg("an error of %g", error);
            if (fabs(soft.width - truth.width) > 0.02 + 0.1 * truth.width) fail_msg("%g m wide, must be %g", soft.width, truth.width);
            assert_true(soft.width > last);
            last = soft.width;
            stage_close(&s);
        }
    }
}

/* ---- edges that are known ---- */

static fnl_shadow_filter measured;

static void measure(fnl_scene *scene, const fnl_trace_params *view, float *out) {
    struct stage s = shadow_stage(scene, view);
    s.frame.shadows = FNL_SHADOWS_MAPS;
    s.frame.shadow.filter = measured;
    if (measured == FNL_SHADOW_FILTER_PCSS) s.frame.shadow.light_radius = 0.02f;
    shadow_parts(&s, out);
    stage_close(&s);
}

/*
 * As without a filter (shadow_maps), with a strip for the disk of texels; a texel is at most a pixel of an eighth of a metre. PCF: a texel and a half more. A
 * source of 2 cm casts a penumbra of 1 cm to each side, in which the disk is that of the blockers' mean. One tap of 16 may err: triangles in whose plane
 * the light lies leave single texels in the borders of pages.
 */
static void test_known_shadows(void **state) {
    UNUSED(state);
    measured = FNL_SHADOW_FILTER_PCF;
    shadow_cases(&(struct shadow_cases){measure, 0.07, 3.0 / 8 / 1.5, false});
    measured = FNL_SHADOW_FILTER_PCSS;
    shadow_cases(&(struct shadow_cases){measure, 0.07, 2.0 / 8 / 1.5, false});
}

/* The steps of texels are smoothed: pixels at an edge see a part of the light, those of hard shadows all of it or nothing. */
static void test_pcf_is_a_mean_of_16_looks_MP_7(void **state) {
    UNUSED(state);
    static float seen[SIZE * SIZE];
    for (fnl_shadow_filter filter = FNL_SHADOW_FILTER_HARD; filter <= FNL_SHADOW_FILTER_PCF; filter++) {
        const fnl_light_params lamp = lamp_of(FNL_LIGHT_POINT, 0);
        fnl_trace_params view;
        struct stage s = open_half_covered(&lamp, 1, &view);
        s.frame.shadow.filter = filter;
        shadow_parts(&s, seen);
        uint32_t between = 0, rows = 0;
        for (uint32_t y = 0; y < SIZE; y++) {
            uint32_t in_row = 0;
            for (uint32_t x = 0; x < SIZE; x++) { /* each look is lit or not: no depth is blurred before it is compared */
                const float lit = 16 * seen[y * SIZE + x];
                assert_true(fabsf(lit - roundf(lit)) < 0.02f);
            }
            for (uint32_t x = 0; x < SIZE; x++) in_row += seen[y * SIZE + x] > 0.01f && seen[y * SIZE + x] < 0.99f;
            between += in_row;
            rows += in_row > 0;
        }
        print_message("%s: %u pixels in %u rows see a part\n", name_of(filter), between, rows);
        assert_true(filter == FNL_SHADOW_FILTER_HARD ? between == 0 : rows == SIZE && between < SIZE * 6);
        stage_close(&s);
    }
}

/* ---- surfaces that nothing hides ---- */

/*
 * Planes at all angles to the light: none shadows itself. Where normals lean by up to 27 degrees from a plane that is steep already, a few of the taps may
 * take it for another.
 */
static void test_surfaces_do_not_shadow_themselves(void **state) {
    UNUSED(state);
    static uint8_t texels[16] = {128, 128, 255, 255, 180, 128, 235, 255, 128, 70, 240, 255, 150, 160, 240, 255}; /* up to 27 degrees */
    static float seen[SIZE * SIZE];
    for (int angle = 0; angle <= 75; angle += 15)
        for (int bent = 0; bent < 2; bent++) {
            fnl_scene *scene = world_create(NULL);
            fnl_material_params white = matt(1);
            fnl_image image = {2, 2, FNL_PIXEL_FORMAT_RGBA8, texels};
            if (bent) assert_int_equal(fnl_scene_add_image(scene, &image, false, &white.normal_image), FNL_OK);
            add_instance(scene, add_square_mesh(scene, add_material(scene, &white)),
                         mat4_from_trs((vec3){0, 0, 0}, quat_axis_angle((vec3){0.6f, 0, 0.8f}, (float)angle * (PI / 180)), (vec3){4, 1, 4}));
            add_point_light(scene, (vec3){0.3f, 3.5f, -0.2f}, 50);
            struct stage s = stage_open_scene(scene);
            s.frame.width = s.frame.height = SIZE;
            s.frame.camera = look_down((vec3){0, 0, 0}, 1.6f, 6, SIZE).camera;
            s.frame.outputs = FNL_OUTPUT_RADIANCE;
            s.frame.shadows = FNL_SHADOWS_MAPS;
            s.frame.shadow.light_radius = 0.2f;
            for (fnl_shadow_filter filter = FNL_SHADOW_FILTER_PCF; filter <= FNL_SHADOW_FILTER_PCSS; filter++) {
                s.frame.shadow.filter = filter;
                shadow_parts(&s, seen);
                float least = 1;
                for (uint32_t i = 0; i < SIZE * SIZE; i++) least = fminf(least, seen[i]);
                if (least < (bent && angle > 45 ? 0.7f : 0.999f))
                    fail_msg("%s, %d degrees, normals %s: %g of the light", name_of(filter), angle, bent ? "bent" : "straight", (double)least);
            }
            stage_close(&s);
        }
}

/* ---- real scenes ---- */

/* Against rays to 32 points of each source: filtered maps are closer than hard ones. */
static void test_scenes_are_closer_to_soft_rays(void **state) {
    UNUSED(state);
    static const struct {
        const char *source;
        float radius; /* CornellBox is hundreds of metres wide */
    } scenes[] = {{"CornellBox.glb", 30}, {"builtin:spheres?lights=16", 0.3f}};
    for (uint32_t i = 0; i < COUNT_OF(scenes); i++) {
        struct stage s = stage_open(scenes[i].source, 8);
        s.frame.outputs = FNL_OUTPUT_RADIANCE;
        s.frame.shadow.memory = 256;
        s.frame.shadow.light_radius = scenes[i].radius;
        s.frame.shadow.samples = 32;
        s.frame.shadows = FNL_SHADOWS_RAYS;
        struct shot truth = stage_shoot(&s, &s.frame);
        double error[2], light = 0;
        for (int soft = 0; soft < 2; soft++) {
            s.frame.shadows = FNL_SHADOWS_MAPS;
            s.frame.shadow.filter = soft ? FNL_SHADOW_FILTER_PCSS : FNL_SHADOW_FILTER_HARD;
            struct shot shot = stage_shoot(&s, &s.frame);
            error[soft] = light = 0;
            for (uint32_t k = 0; k < s.frame.width * s.frame.height; k++) {
                const float *a = pixel_at(&truth.radiance, k % s.frame.width, k / s.frame.width),
                            *b = pixel_at(&shot.radiance, k % s.frame.width, k / s.frame.width);
                error[soft] += fabs((double)a[1] - (double)b[1]);
                light += (double)a[1];
            }
            shot_free(&shot);
        }
        print_message("%s: %.2f %% of the light is wrong, with hard shadows %.2f %%\n", scenes[i].source, 100 * error[1] / light, 100 * error[0] / light);
        if (!(error[1] < 0.8 * error[0])) fail_msg("%g is not less than %g", error[1], error[0]);
        shot_free(&truth);
        stage_close(&s);
    }
}

static void test_paths_and_lists_filter_alike(void **state) {
    UNUSED(state);
    fnl_frame soft = frame_plain();
    soft.shadow.light_radius = 0.05f;
    for (fnl_shadow_filter filter = FNL_SHADOW_FILTER_PCF; filter <= FNL_SHADOW_FILTER_PCSS; filter++) {
        soft.shadow.filter = filter;
        expect_lists_alike_with(FNL_SHADOWS_MAPS, &soft.shadow);
    }
    expect_path_kinds_alike(FNL_SHADOWS_MAPS, &soft.shadow);
}

/* ---- work ---- */

/* Only sources with a size ask for coarser pages besides, which are few; a still scene draws none, and no budget is too small. */
static void test_pages_of_penumbras(void **state) {
    UNUSED(state);
    struct stage s = stage_open("builtin:hall?lights=64", 0);
    s.frame.width = 81, s.frame.height = 47;
    s.frame.shadows = FNL_SHADOWS_MAPS;
    s.frame.outputs = FNL_OUTPUT_RADIANCE;
    struct shot hard = stage_shoot(&s, &s.frame);
    const uint64_t wanted = counter(&hard.stats, "shadows.wanted");
    s.frame.shadow.filter = FNL_SHADOW_FILTER_PCSS;
    struct shot points = stage_shoot(&s, &s.frame);
    assert_int_equal(counter(&points.stats, "shadows.wanted"), wanted);
    assert_int_equal(count_differing(&hard.radiance, &points.radiance), 0);
    s.frame.shadow.light_radius = 0.1f;
    struct shot soft = stage_shoot(&s, &s.frame), again = stage_shoot(&s, &s.frame);
    print_message("%u pages, with penumbras %u\n", (uint32_t)wanted, (uint32_t)counter(&soft.stats, "shadows.wanted"));
    assert_true(counter(&soft.stats, "shadows.wanted") > wanted && counter(&soft.stats, "shadows.wanted") < 3 * wanted);
    assert_true(counter(&soft.stats, "shadows.drawn") > 0);
    assert_int_equal(counter(&again.stats, "shadows.drawn"), 0);
    assert_int_equal(count_differing(&soft.radiance, &again.radiance), 0);
    assert_true(count_differing(&hard.radiance, &soft.radiance) > 81 * 47 / 10);
    s.frame.shadow.memory = 1;
    struct shot little = stage_shoot(&s, &s.frame);
    assert_true(counter(&little.stats, "shadows.coarsened") > 0);
    assert_int_equal(counter(&little.stats, "shadows.traced"), 0);
    fnl_image_difference difference;
    assert_int_equal(fnl_image_compare(NULL, &soft.radiance, &little.radiance, &difference), FNL_OK);
    print_message("1 MiB: %.1f dB\n", difference.psnr);
    shot_free(&hard);
    shot_free(&points);
    shot_free(&soft);
    shot_free(&again);
    shot_free(&little);
    stage_close(&s);
}

/* ---- what is all light or all shadow takes no filtering ---- */

/* Of a floor before a lamp all points are settled by the first taps, in light and far in the shadow; at the edge, and only there, none is. */
static void test_even_places_take_few_taps_ES_49(void **state) {
    UNUSED(state);
    for (uint32_t kind = 0; kind < 3; kind++) {
        const fnl_light_kind kinds[3] = {FNL_LIGHT_POINT, FNL_LIGHT_SPOT, FNL_LIGHT_DIRECTIONAL};
        const fnl_light_params lamp = lamp_of(kinds[kind], 0);
        for (uint32_t place = 0; place < 3; place++) {
            fnl_trace_params view;
            struct stage s = open_half_covered(&lamp, 1, &view);
            const float x = place == 0 ? -4 : place == 1 ? 0.03f : 4; /* open, the edge, covered: seen from between floor and cover */
            s.frame.camera.position.x += x;
            s.frame.camera.target.x += x;
            s.frame.shadow.filter = FNL_SHADOW_FILTER_PCF;
            s.frame.count_lights = true;
            struct shot shot = stage_shoot(&s, &s.frame);
            const uint64_t filtered = counter(&shot.stats, "shadows.filtered"), settled = counter(&shot.stats, "shadows.settled");
            print_message("%s, %s: %u of %u settled\n", fnl_value_name(FNL_ENUM_LIGHT_KIND, kinds[kind]), place == 0 ? "open" : place == 1 ? "edge" : "covered", (uint32_t)settled, (uint32_t)filtered);
            assert_true(filtered >= SIZE * SIZE / 2);
            if (place == 1) assert_true(settled < filtered && settled > filtered / 2);
            else assert_int_equal(settled, filtered);
            s.frame.shadow.filter = FNL_SHADOW_FILTER_HARD;
            struct shot hard = stage_shoot(&s, &s.frame);
            assert_false(has_counter(&hard.stats, "shadows.filtered"));
            if (place != 1) assert_int_equal(count_differing(&shot.radiance, &hard.radiance), 0);
            shot_free(&shot);
            shot_free(&hard);
            stage_close(&s);
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_even_places_take_few_taps_ES_49, harness_check),
        cmocka_unit_test_teardown(test_penumbras_are_those_of_the_tracer_MP_8, harness_check),
        cmocka_unit_test_teardown(test_known_shadows, harness_check),
        cmocka_unit_test_teardown(test_pcf_is_a_mean_of_16_looks_MP_7, harness_check),
        cmocka_unit_test_teardown(test_surfaces_do_not_shadow_themselves, harness_check),
        cmocka_unit_test_teardown(test_scenes_are_closer_to_soft_rays, harness_check),
        cmocka_unit_test_teardown(test_paths_and_lists_filter_alike, harness_check),
        cmocka_unit_test_teardown(test_pages_of_penumbras, harness_check),
    };
    return cmocka_run_group_tests_name("shadow_filter", tests, harness_begin, harness_end);
}
