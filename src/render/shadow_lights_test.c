/* SPDX-License-Identifier: MIT */
/* What single lights say of their shadows: whether they cast any, and how large their source is. Against the tracer, with rays and maps. */
#include "tests/render_harness.h"
#include "tests/shadow_cases.h"
#include "tests/shadow_leak.h"
#include "tests/shadow_paths.h"

enum { SIZE = 40 };

/* ---- a light of each kind over a floor that a half-plane covers from above ---- */

static fnl_light_params lamp_of(fnl_light_kind kind) {
    fnl_light_params lamp = fnl_light_params_default();
    lamp.kind = kind;
    lamp.position = (vec3){0, kind == FNL_LIGHT_BOX ? 1.5f : 3, 0};
    lamp.direction = kind == FNL_LIGHT_CAPSULE ? (vec3){1, 0, 0} : (vec3){0, -1, 0};
    lamp.up = (vec3){0, 0, 1};
    lamp.intensity = 20;
    if (kind != FNL_LIGHT_DIRECTIONAL && kind != FNL_LIGHT_BOX) lamp.range = 20;
    lamp.outer_cone_angle = lamp.inner_cone_angle = 1.2f;
    lamp.wedge_angles[0] = lamp.wedge_angles[1] = 1.1f;
    lamp.box_size = (vec3){8, 8, 4}; /* from below the floor */
    lamp.inner_fraction = 1;
    return lamp;
}

/* The half-plane covers x > 0, a metre above the floor. */
static fnl_scene *half_covered(const fnl_light_params *lamp, fnl_light_id *out) {
    fnl_scene *scene = world_create(NULL);
    const fnl_material_params white = matt(1);
    add_square(scene, &white, (vec3){10, 1, 10}, (vec3){0, 0, 0});
    add_square(scene, &white, (vec3){10, 1, 10}, (vec3){10, 1, 0});
    assert_int_equal(fnl_scene_add_light(scene, lamp, out), FNL_OK);
    return scene;
}

static struct stage open_half_covered(const fnl_light_params *lamp, fnl_light_id *out) {
    struct stage s = stage_open_scene(half_covered(lamp, out));
    s.frame.width = s.frame.height = SIZE;
    s.frame.camera = look_down((vec3){0, 0, 0}, 3, 0.5f, SIZE).camera; /* from below the half-plane */
    s.frame.outputs = FNL_OUTPUT_RADIANCE;
    return s;
}

static fnl_trace trace_of(const struct stage *s, uint32_t samples) {
    fnl_trace_params p = look_down((vec3){0, 0, 0}, 3, 0.5f, SIZE);
    p.visibility = true;
    p.samples = samples;
    return trace_scene(s->scene, &p);
}

/* ---- lights that cast none ---- */

static void test_lights_that_cast_no_shadow(void **state) {
    UNUSED(state);
    for (fnl_light_kind kind = 0; kind < FNL_LIGHT_KIND_COUNT; kind++) {
        const char *name = fnl_value_name(FNL_ENUM_LIGHT_KIND, kind);
        fnl_light_params lamp = lamp_of(kind);
        fnl_light_id id;
        struct stage s = open_half_covered(&lamp, &id);
        struct shot open = stage_shoot(&s, &s.frame);
        for (int casts = 1; casts >= 0; casts--) { /* the light changes its mind between frames */
            lamp.casts_shadows = casts;
            assert_int_equal(fnl_scene_set_light(s.scene, id, &lamp), FNL_OK);
            for (fnl_shadows shadows = FNL_SHADOWS_RAYS; shadows <= FNL_SHADOWS_MAPS; shadows++) {
                s.frame.shadows = shadows;
                struct shot shot = stage_shoot(&s, &s.frame);
                const uint64_t differing = count_differing(&open.radiance, &shot.radiance);
                if (casts ? differing < SIZE * SIZE / 3 : differing > 0)
                    fail_msg("%s, shadows %s %s: %u pixels differ", name, casts ? "cast" : "not cast", fnl_value_name(FNL_ENUM_SHADOWS, shadows),
                             (uint32_t)differing);
                if (shadows == FNL_SHADOWS_MAPS && kind != FNL_LIGHT_DIRECTIONAL && kind != FNL_LIGHT_CAPSULE && kind != FNL_LIGHT_RECTANGLE)
                    assert_int_equal(counter(&shot.stats, "shadows.wanted") > 0, casts);
                shot_free(&shot);
            }
            fnl_trace trace = trace_of(&s, 1);
            const double mean = mean_of(&trace.visibility, 0);
            if (casts ? mean > 0.7 : mean < 1) fail_msg("%s: the tracer lets %g through", name, mean);
            fnl_trace_free(NULL, &trace);
        }
        shot_free(&open);
        stage_close(&s);
    }
}

/* Without a light that casts a shadow of which maps know nothing, the trees of rays hold no triangles. */
static void test_rays_are_made_for_lights_that_cast(void **state) {
    UNUSED(state);
    for (int casts = 0; casts < 2; casts++) {
        fnl_light_params lamp = lamp_of(FNL_LIGHT_DIRECTIONAL);
        fnl_light_id id;
        struct stage s = open_half_covered(&lamp, &id);
        lamp = lamp_of(FNL_LIGHT_CAPSULE);
        lamp.casts_shadows = casts;
        assert_int_equal(fnl_scene_add_light(s.scene, &lamp, &id), FNL_OK);
        s.frame.shadows = FNL_SHADOWS_MAPS;
        assert_int_equal(fnl_renderer_render(s.renderer, &s.frame), FNL_OK);
        assert_int_equal(s.renderer->device_scene->ray_meshes.handle != VK_NULL_HANDLE, casts);
        stage_close(&s);
    }
}

/* In all shading paths: where no light casts a shadow, there is none. */
static void test_paths_know_lights_that_cast_none(void **state) {
    UNUSED(state);
    struct stage s = stage_open("builtin:interior?lights=40", 0);
    s.frame.width = 64, s.frame.height = 36, s.frame.ev = 1;
    for (uint32_t i = 0; i < s.scene->lights.count; i++) s.scene->lights.data[i].params.casts_shadows = false;
    for (uint32_t k = 0; k < SHADOW_PATH_KINDS; k++) {
        const fnl_shading shading = shadow_path_kinds[k];
        s.frame.shading = shading;
        s.frame.shadows = FNL_SHADOWS_OFF;
        struct shot open = stage_shoot(&s, &s.frame);
        for (fnl_shadows shadows = FNL_SHADOWS_RAYS; shadows <= FNL_SHADOWS_MAPS; shadows++) {
            s.frame.shadows = shadows;
            struct shot shot = stage_shoot(&s, &s.frame);
            if (greatest_difference(&open.color, &shot.color) > 1)
                fail_msg("%s, %s", fnl_value_name(FNL_ENUM_SHADING, shading), fnl_value_name(FNL_ENUM_SHADOWS, shadows));
            shot_free(&shot);
        }
        shot_free(&open);
    }
    stage_close(&s);
}

/* ---- soft shadows ---- */

/* Of what is seen and what is true; bias: of the whole picture. */
struct error {
    double rms, bias;
};
static struct error error_of(const float *seen, const fnl_image *truth) {
    struct error error = {0};
    for (uint32_t i = 0; i < SIZE * SIZE; i++) {
        const double difference = (double)seen[i] - (double)pixel_at(truth, i % SIZE, i / SIZE)[0];
        error.rms += difference * difference / (SIZE * SIZE);
        error.bias += difference / (SIZE * SIZE);
    }
    error.rms = sqrt(error.rms);
    return error;
}

static fnl_light_params soft_lamp_of(fnl_light_kind kind) {
    fnl_light_params lamp = lamp_of(kind);
    lamp.source_angle = 0.3f;
    lamp.source_radius = kind == FNL_LIGHT_CAPSULE ? 0.1f : 0.5f;
    return lamp;
}

/* The penumbra is that of the tracer, for all kinds of lights, and the error falls as rays become more. */
static void test_soft_rays_converge_to_the_tracer_MP_8(void **state) {
    UNUSED(state);
    static float seen[SIZE * SIZE];
    for (fnl_light_kind kind = 0; kind < FNL_LIGHT_KIND_COUNT; kind++) {
        const char *name = fnl_value_name(FNL_ENUM_LIGHT_KIND, kind);
        const fnl_light_params lamp = soft_lamp_of(kind);
        fnl_light_id id;
        struct stage s = open_half_covered(&lamp, &id);
        fnl_trace truth = trace_of(&s, 512);
        s.frame.shadows = FNL_SHADOWS_RAYS;
        struct error error = {1, 0};
        for (uint32_t samples = 1; samples <= 16; samples *= 4) {
            s.frame.shadow.samples = samples;
            shadow_parts(&s, seen);
            const struct error now = error_of(seen, &truth.visibility);
            print_message("%s, %u rays: error %.4f, bias %.4f\n", name, samples, now.rms, now.bias);
            if (now.rms > error.rms * (samples == 1 ? 1 : 0.7)) fail_msg("%s, %u rays: an error of %g after %g", name, samples, now.rms, error.rms);
            error = now;
        }
        /* a rectangle's is a ratio of two sums, whose mean is right but for a part of 1 / rays */
        if (error.rms > 0.035 || fabs(error.bias) > (kind == FNL_LIGHT_RECTANGLE ? 0.006 : 0.003)) fail_msg("%s: an error of %g, %g on the whole", name, error.rms, error.bias);
        fnl_trace_free(NULL, &truth);
        stage_close(&s);
    }
}

/* ---- maps know nothing of capsules and rectangles ---- */

enum { LEAN = 2 }; /* kinds */

/* Lights that lean, and a square that leans between them and the floor. */
static struct stage open_leaning(const fnl_light_params *lamps, uint32_t count) {
    fnl_scene *scene = world_create(NULL);
    const fnl_material_params white = matt(1);
    add_square(scene, &white, (vec3){10, 1, 10}, (vec3){0, 0, 0});
    add_instance(scene, add_square_mesh(scene, add_material(scene, &white)),
                 mat4_from_trs((vec3){0.2f, 1, -0.1f}, quat_axis_angle((vec3){0.6f, 0, 0.8f}, 0.5f), (vec3){0.6f, 1, 0.4f}));
    for (uint32_t i = 0; i < count; i++) {
        fnl_light_id id;
        assert_int_equal(fnl_scene_add_light(scene, &lamps[i], &id), FNL_OK);
    }
    struct stage s = stage_open_scene(scene);
    s.frame.width = s.frame.height = SIZE;
    s.frame.camera = look_down((vec3){0, 0, 0}, 3, 0.3f, SIZE).camera; /* from below the square */
    s.frame.outputs = FNL_OUTPUT_RADIANCE;
    s.frame.shadows = FNL_SHADOWS_MAPS;
    return s;
}

static fnl_light_params leaning_lamp_of(fnl_light_kind kind) {
    fnl_light_params lamp = lamp_of(kind);
    lamp.position = (vec3){-0.3f, 2.5f, 0.2f};
    lamp.direction = kind == FNL_LIGHT_CAPSULE ? (vec3){1, 0.3f, 0.5f} : (vec3){0.3f, -1, -0.4f};
    lamp.up = (vec3){0.3f, 0.1f, 1};
    lamp.rectangle_size[0] = 1.2f;
    lamp.rectangle_size[1] = 0.5f;
    return lamp;
}

static fnl_trace trace_leaning(const struct stage *s, uint32_t samples) {
    fnl_trace_params p = look_down((vec3){0, 0, 0}, 3, 0.3f, SIZE);
    p.visibility = true;
    p.samples = samples;
    return trace_scene(s->scene, &p);
}

/* Whether the tracer gives a neighbour another part of the light than this pixel. */
static bool is_edge(const fnl_image *truth, uint32_t i) {
    const int x = (int)(i % SIZE), y = (int)(i / SIZE);
    for (int v = MAX(y - 1, 0); v <= MIN(y + 1, SIZE - 1); v++)
        for (int u = MAX(x - 1, 0); u <= MIN(x + 1, SIZE - 1); u++)
            if (fabsf(pixel_at(truth, (uint32_t)u, (uint32_t)v)[0] - pixel_at(truth, (uint32_t)x, (uint32_t)y)[0]) > 0.01f) return true;
    return false;
}

/* Their hard shadows in frames with maps are the tracer's, of a rectangle those of a tiny one in its middle; no page is asked for. */
static void test_hard_shadows_without_maps_are_the_tracers(void **state) {
    UNUSED(state);
    static const fnl_light_kind kinds[LEAN] = {FNL_LIGHT_CAPSULE, FNL_LIGHT_RECTANGLE};
    static float seen[SIZE * SIZE];
    for (int k = 0; k < LEAN; k++) {
        fnl_light_params lamp = leaning_lamp_of(kinds[k]);
        struct stage s = open_leaning(&lamp, 1);
        const fnl_frame_stats stats = shadow_parts(&s, seen);
        assert_int_equal(counter(&stats, "shadows.wanted"), 0);
        lamp.rectangle_size[0] = lamp.rectangle_size[1] = 1e-3f;
        struct stage middle = open_leaning(&lamp, 1);
        fnl_trace truth = trace_leaning(&middle, 1);
        uint32_t dark = 0, lit = 0, edges = 0;
        for (uint32_t i = 0; i < SIZE * SIZE; i++) {
            const float wanted = pixel_at(&truth.visibility, i % SIZE, i / SIZE)[0];
            if (is_edge(&truth.visibility, i)) {
                edges++;
                continue;
            }
            if (fabsf(seen[i] - wanted) > 1e-3f)
                fail_msg("%s: pixel %u, %u sees %g of the light, must be %g", fnl_value_name(FNL_ENUM_LIGHT_KIND, kinds[k]), i % SIZE, i / SIZE, (double)seen[i], (double)wanted);
            dark += wanted < 0.5f;
            lit += wanted > 0.5f;
        }
        assert_true(dark > 50 && lit > SIZE * SIZE / 2 && edges < SIZE * SIZE / 8);
        fnl_trace_free(NULL, &truth);
        stage_close(&middle);
        stage_close(&s);
    }
}

/* Their soft shadows too, alone and in one frame with a spot light, whose map is filtered. */
static void test_soft_shadows_without_maps_are_the_tracers_MP_8(void **state) {
    UNUSED(state);
    static const fnl_light_kind kinds[LEAN + 1] = {FNL_LIGHT_CAPSULE, FNL_LIGHT_RECTANGLE, FNL_LIGHT_SPOT};
    static float seen[SIZE * SIZE];
    fnl_light_params lamps[LEAN + 1];
    for (int k = 0; k <= LEAN; k++) {
        lamps[k] = leaning_lamp_of(kinds[k]);
        if (kinds[k] != FNL_LIGHT_RECTANGLE) lamps[k].source_radius = 0.1f;
    }
    lamps[LEAN].position = (vec3){0.8f, 3, -0.6f};
    lamps[LEAN].direction = (vec3){-0.2f, -1, 0.2f};
    for (int k = 0; k <= LEAN; k++) {
        const bool all = k == LEAN;
        struct stage s = open_leaning(all ? lamps : &lamps[k], all ? LEAN + 1 : 1);
        s.frame.shadow.filter = FNL_SHADOW_FILTER_PCSS;
        fnl_trace truth = trace_leaning(&s, 512);
        struct error error = {1, 0}, hard = {0};
        for (uint32_t samples = 1; samples <= 16; samples *= 16) {
            s.frame.shadow.samples = samples;
            shadow_parts(&s, seen);
            hard = error;
            error = error_of(seen, &truth.visibility);
            print_message("%s, %u rays: error %.4f, bias %.4f\n", all ? "all" : fnl_value_name(FNL_ENUM_LIGHT_KIND, kinds[k]), samples, error.rms, error.bias);
        }
        if (error.rms > (all ? 0.02 : 0.035) || fabs(error.bias) > 0.006 || !(error.rms < 0.5 * hard.rms))
            fail_msg("%s: an error of %g, %g on the whole; hard %g", all ? "all" : fnl_value_name(FNL_ENUM_LIGHT_KIND, kinds[k]), error.rms, error.bias, hard.rms);
        fnl_trace_free(NULL, &truth);
        stage_close(&s);
    }
}

/* A source without size gets one ray, a light without radius takes that of the frame, and one that has its own keeps it. */
static void test_radius_of_a_frame(void **state) {
    UNUSED(state);
    for (fnl_light_kind kind = 0; kind < FNL_LIGHT_RECTANGLE; kind++) { /* whose own size counts */
        const fnl_light_params hard = lamp_of(kind), soft = soft_lamp_of(kind);
        fnl_light_id id;
        struct stage s = open_half_covered(&hard, &id);
        s.frame.shadows = FNL_SHADOWS_RAYS;
        struct shot one = stage_shoot(&s, &s.frame);
        s.frame.shadow.samples = 16;
        struct shot many = stage_shoot(&s, &s.frame);
        assert_int_equal(count_differing(&one.radiance, &many.radiance), 0);
        s.frame.shadow.light_radius = soft.source_radius;
        s.frame.shadow.sun_degrees = soft.source_angle * (180 / PI);
        struct shot given = stage_shoot(&s, &s.frame);
        assert_true(count_differing(&one.radiance, &given.radiance) > SIZE * 4);
        assert_int_equal(fnl_scene_set_light(s.scene, id, &soft), FNL_OK);
        s.frame.shadow.light_radius = 7;
        s.frame.shadow.sun_degrees = 50;
        struct shot own = stage_shoot(&s, &s.frame);
        uint64_t differing = 0; /* angles are rounded on their way through degrees */
        for (uint32_t i = 0; i < SIZE * SIZE; i++)
            differing += fabsf(pixel_at(&own.radiance, i % SIZE, i / SIZE)[1] - pixel_at(&given.radiance, i % SIZE, i / SIZE)[1]) > 1e-4f;
        assert_true(differing <= 4);
        shot_free(&one);
        shot_free(&many);
        shot_free(&given);
        shot_free(&own);
        stage_close(&s);
    }
}

/* Stills repeat to the byte; frames that are collected turn their points, so that together they see more of the source. */
static void test_points_turn_in_collected_frames(void **state) {
    UNUSED(state);
    static float seen[SIZE * SIZE];
    const fnl_light_params lamp = soft_lamp_of(FNL_LIGHT_POINT);
    fnl_light_id id;
    struct stage s = open_half_covered(&lamp, &id);
    fnl_trace truth = trace_of(&s, 512);
    s.frame.shadows = FNL_SHADOWS_RAYS;
    s.frame.shadow.samples = 4;
    struct shot first = stage_shoot(&s, &s.frame), second = stage_shoot(&s, &s.frame);
    assert_int_equal(count_differing(&first.radiance, &second.radiance), 0);
    shadow_parts(&s, seen);
    const struct error still = error_of(seen, &truth.visibility);
    s.frame.aa = FNL_ANTIALIASING_TAA;
    double mean[SIZE * SIZE] = {0};
    enum { FRAMES = 16 };
    for (int i = 0; i < FRAMES; i++) {
        struct shot frame = stage_shoot(&s, &s.frame);
        for (uint32_t k = 0; k < SIZE * SIZE; k++) mean[k] += (double)pixel_at(&frame.radiance, k % SIZE, k / SIZE)[1] / FRAMES;
        shot_free(&frame);
    }
    fnl_frame open = s.frame;
    open.shadows = FNL_SHADOWS_OFF;
    open.aa = FNL_ANTIALIASING_NONE;
    struct shot plain = stage_shoot(&s, &open);
    for (uint32_t k = 0; k < SIZE * SIZE; k++) seen[k] = (float)(mean[k] / (double)pixel_at(&plain.radiance, k % SIZE, k / SIZE)[1]);
    const struct error collected = error_of(seen, &truth.visibility);
    print_message("4 rays: error %.4f of one frame, %.4f of %d\n", still.rms, collected.rms, FRAMES);
    assert_true(collected.rms < still.rms / 2);
    shot_free(&first);
    shot_free(&second);
    shot_free(&plain);
    fnl_trace_free(NULL, &truth);
    stage_close(&s);
}

/* ---- sampled ---- */

/* With `sampled` a light gets one ray, to one of its points: the mean of frames with other seeds is the penumbra of the tracer, and that of rays to all points. */
static void test_mean_of_sampled_points_is_the_tracers_MP_8_SH_68(void **state) {
    UNUSED(state);
    static const fnl_light_kind kinds[] = {FNL_LIGHT_POINT, FNL_LIGHT_CAPSULE, FNL_LIGHT_RECTANGLE};
    enum { FRAMES = 32, POINTS = 64 };
    static float parts[SIZE * SIZE], mean[SIZE * SIZE];
    for (uint32_t k = 0; k < COUNT_OF(kinds); k++) {
        const char *name = fnl_value_name(FNL_ENUM_LIGHT_KIND, kinds[k]);
        const fnl_light_params lamp = soft_lamp_of(kinds[k]);
        fnl_light_id id;
        struct stage s = open_half_covered(&lamp, &id);
        s.frame.count_lights = true;
        s.frame.shadow.samples = POINTS;
        fnl_trace truth = trace_of(&s, 512);
        s.frame.shadows = FNL_SHADOWS_RAYS;
        shadow_parts(&s, parts);
        const struct error all = error_of(parts, &truth.visibility);
        s.frame.shadows = FNL_SHADOWS_SAMPLED;
        memset(mean, 0, sizeof mean);
        struct error one = {0};
        for (uint32_t n = 0; n < FRAMES; n++) {
            s.frame.shadow.seed = n;
            const fnl_frame_stats stats = shadow_parts(&s, parts);
            assert_true(counter(&stats, "shadows.rays") <= SIZE * SIZE);
            if (n == 0) one = error_of(parts, &truth.visibility);
            for (uint32_t i = 0; i < SIZE * SIZE; i++) mean[i] += parts[i] / FRAMES;
        }
        const struct error error = error_of(mean, &truth.visibility);
        print_message("%s: error %.4f of one ray, %.4f of %d; bias %.4f, of rays to all points %.4f, %.4f\n", name, one.rms, error.rms, FRAMES, error.bias, all.rms, all.bias);
        if (error.rms > 0.035 || error.rms > one.rms / 5 || fabs(error.bias - all.bias) > 0.0015) fail_msg("%s: an error of %g, %g on the whole", name, error.rms, error.bias);
        fnl_trace_free(NULL, &truth);
        stage_close(&s);
    }
}

/* A light without size has the shadow that it has with one ray, to the bit. */
static void test_sampled_points_are_as_they_were(void **state) {
    UNUSED(state);
    const fnl_light_params lamp = lamp_of(FNL_LIGHT_POINT);
    fnl_light_id id;
    struct stage s = open_half_covered(&lamp, &id);
    for (int i = 0; i < 4; i++) assert_int_equal(fnl_scene_add_light(s.scene, &lamp, &id), FNL_OK);
    s.frame.shadows = FNL_SHADOWS_SAMPLED;
    struct shot hard = stage_shoot(&s, &s.frame);
    s.frame.shadow.samples = 16;
    struct shot soft = stage_shoot(&s, &s.frame);
    assert_int_equal(count_differing(&hard.radiance, &soft.radiance), 0);
    shot_free(&hard);
    shot_free(&soft);
    stage_close(&s);
}

static void test_paths_and_lists_give_the_same_soft_shadows(void **state) {
    UNUSED(state);
    fnl_frame soft = frame_plain();
    soft.shadow.samples = 4;
    soft.shadow.light_radius = 0.1f;
    soft.shadow.sun_degrees = 2;
    expect_lists_alike_with(FNL_SHADOWS_RAYS, &soft.shadow);
    expect_path_kinds_alike(FNL_SHADOWS_RAYS, &soft.shadow);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_lights_that_cast_no_shadow, harness_check),
        cmocka_unit_test_teardown(test_rays_are_made_for_lights_that_cast, harness_check),
        cmocka_unit_test_teardown(test_paths_know_lights_that_cast_none, harness_check),
        cmocka_unit_test_teardown(test_soft_rays_converge_to_the_tracer_MP_8, harness_check),
        cmocka_unit_test_teardown(test_hard_shadows_without_maps_are_the_tracers, harness_check),
        cmocka_unit_test_teardown(test_soft_shadows_without_maps_are_the_tracers_MP_8, harness_check),
        cmocka_unit_test_teardown(test_radius_of_a_frame, harness_check),
        cmocka_unit_test_teardown(test_points_turn_in_collected_frames, harness_check),
        cmocka_unit_test_teardown(test_mean_of_sampled_points_is_the_tracers_MP_8_SH_68, harness_check),
        cmocka_unit_test_teardown(test_sampled_points_are_as_they_were, harness_check),
        cmocka_unit_test_teardown(test_paths_and_lists_give_the_same_soft_shadows, harness_check),
    };
    return cmocka_run_group_tests_name("shadow_lights", tests, harness_begin, harness_end);
}
