/* SPDX-License-Identifier: MIT */
/* Light profiles in frames: what each direction gets is what rays in double precision say, in every list and order, and where no light has one
   nothing changes. */
#include "tests/list_pairs.h"

#include "fanal/trace.h"
#include "tests/coarse_cases.h"
#include "tests/frame_plain.h"

/* Nothing alike anywhere: 45 degrees across, 30 down, values of their own. */
static const char lamp[] = "IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 7 9 1 2 0 0 0\n1 1 0\n0 30 60 90 120 150 180\n0 45 90 135 180 225 270 315 360\n"
                           "50 90 10 30 5 60 20\n50 10 80 70 35 9 20\n50 100 40 2 60 30 20\n50 20 20 90 10 80 20\n50 70 60 15 45 5 20\n"
                           "50 5 95 40 25 50 20\n50 60 30 65 80 15 20\n50 35 75 12 50 70 20\n50 90 10 30 5 60 20\n";

static fnl_light_profile_id add_lamp(fnl_scene *scene) {
    fnl_light_profile_id id;
    float candela;
    assert_int_equal(fnl_scene_add_light_profile(scene, "lamp.ies", lamp, sizeof lamp - 1, &id, &candela), FNL_OK);
    assert_true(candela == 100);
    return id;
}

/* Every second light gets the profile, turned some way. */
static void give(fnl_scene *scene, fnl_light_profile_id profile) {
    struct random_state random = {4};
    for (uint32_t i = 0; i < scene->lights.count; i++) {
        const fnl_light_id id = {i, scene->lights.data[i].generation};
        fnl_light_params light = scene->lights.data[i].params;
        if (light.kind == FNL_LIGHT_POINT) light.direction = vec3_make(random_range(&random, -1, 1), random_range(&random, -1, 1), -0.3f);
        light.up = vec3_make(random_range(&random, -1, 1), 1, 0.5f);
        if (i % 2) light.profile = profile;
        assert_int_equal(fnl_scene_set_light(scene, id, &light), FNL_OK);
    }
}

static struct stage open_small(const char *source) {
    struct stage s = stage_open(source, 0);
    s.frame.width = 81;
    s.frame.height = 47;
    return s;
}

static fnl_trace trace_of(const struct stage *s) {
    fnl_trace_params p = trace_plain();
    p.width = s->frame.width, p.height = s->frame.height, p.camera = s->frame.camera;
    p.shadows = false;
    p.exposure = s->frame.exposure, p.ev = s->frame.ev, p.tonemap = s->frame.tonemap;
    fnl_trace trace;
    assert_int_equal(fnl_scene_trace(s->scene, &p, &trace), FNL_OK);
    return trace;
}

/* Inside of a white box, all six walls of which one light reaches: every direction, pixel by pixel, point and spot. */
static void test_every_direction_is_that_of_rays_MA_11(void **state) {
    UNUSED(state);
    for (int kind = FNL_LIGHT_POINT; kind <= FNL_LIGHT_SPOT; kind++) {
        fnl_scene *scene = coarse_scene();
        fnl_material_params white = fnl_material_params_default();
        fnl_material_id id;
        white.base_color[0] = white.base_color[1] = white.base_color[2] = 0.8f;
        white.double_sided = true;
        assert_int_equal(fnl_scene_add_material(scene, &white, &id), FNL_OK);
        const vec3 corners[8] = {{-1, -1, -1}, {1, -1, -1}, {-1, 1, -1}, {1, 1, -1}, {-1, -1, 1}, {1, -1, 1}, {-1, 1, 1}, {1, 1, 1}};
        static const uint32_t faces[36] = {0, 1, 2, 2, 1, 3, 4, 6, 5, 5, 6, 7, 0, 2, 4, 4, 2, 6, 1, 5, 3, 3, 5, 7, 0, 4, 1, 1, 4, 5, 2, 3, 6, 6, 3, 7};
        const fnl_mesh_params box = {.positions = &corners[0].x, .vertex_count = 8, .indices = faces, .index_count = 36, .material = id};
        fnl_mesh_id mesh;
        fnl_instance_id instance;
        const mat4 identity = mat4_identity();
        assert_int_equal(fnl_scene_add_mesh(scene, &box, &mesh), FNL_OK);
        assert_int_equal(fnl_scene_add_instance(scene, mesh, &identity, &instance), FNL_OK);
        fnl_light_params light = fnl_light_params_default();
        fnl_light_id light_id;
        light.kind = (fnl_light_kind)kind;
        light.position = (fnl_vec3){0.1f, -0.05f, 0.08f};
        light.direction = (fnl_vec3){0.3f, -1, 0.2f};
        light.up = (fnl_vec3){0.5f, 0.1f, 1};
        light.outer_cone_angle = 1.5f;
        light.intensity = 20;
        light.profile = add_lamp(scene);
        assert_int_equal(fnl_scene_add_light(scene, &light, &light_id), FNL_OK);
        struct stage s = stage_open_scene(scene);
        s.frame.width = 48, s.frame.height = 48;
        s.frame.shading = FNL_SHADING_FORWARD;
        s.frame.camera = fnl_camera_default();
        s.frame.camera.position = (fnl_vec3){0, 0, 0};
        s.frame.camera.vertical_fov = 2.2f;
        static const fnl_vec3 looks[] = {{1, 0.1f, 0.2f}, {-1, 0.2f, 0.1f}, {0.1f, -1, 0.2f}, {0.2f, 1, 0.1f}};
        for (uint32_t i = 0; i < COUNT_OF(looks); i++) {
            s.frame.camera.target = looks[i];
            struct shot shot = stage_shoot(&s, &s.frame);
            fnl_trace trace = trace_of(&s);
            const float *x = shot.radiance.pixels, *y = trace.radiance.pixels;
            uint32_t off = 0;
            for (uint32_t p = 0; p < 48 * 48; p++) off += fabsf(x[p * 4] - y[p * 4]) > 2e-3f * y[p * 4] + 1e-4f;
            if (off > 10) fail_msg("kind %d, view %u: %u pixels are off", kind, i, off); /* edges between walls */
            fnl_trace_free(&scene->host, &trace);
            shot_free(&shot);
        }
        stage_close(&s);
    }
}

static void test_pictures_are_those_of_rays_MA_11(void **state) {
    UNUSED(state);
    struct stage s = open_small("builtin:spheres?lights=40");
    s.frame.shading = FNL_SHADING_FORWARD;
    struct shot without = stage_shoot(&s, &s.frame);
    give(s.scene, add_lamp(s.scene));
    struct shot shot = stage_shoot(&s, &s.frame);
    fnl_trace trace = trace_of(&s);
    fnl_image_difference difference, change;
    assert_int_equal(fnl_image_compare(NULL, &trace.color, &shot.color, &difference), FNL_OK);
    assert_int_equal(fnl_image_compare(NULL, &without.color, &shot.color, &change), FNL_OK);
    print_message("%.1f dB from rays, %.1f dB from the picture without profiles\n", difference.psnr, change.psnr);
    assert_true(difference.psnr > 48 && change.psnr < 36);
    fnl_trace_free(&s.scene->host, &trace);
    shot_free(&shot);
    shot_free(&without);
    stage_close(&s);
}

/* A profile that no light has costs no pipeline and changes no bit; nor does one that was taken away again. */
static void test_without_profiles_nothing_changes_MA_11(void **state) {
    UNUSED(state);
    struct stage s = open_small("builtin:spheres?lights=40");
    s.frame.shading = FNL_SHADING_FORWARD;
    struct shot before = stage_shoot(&s, &s.frame);
    const fnl_light_profile_id profile = add_lamp(s.scene);
    struct shot unused = stage_shoot(&s, &s.frame);
    assert_int_equal(count_differing(&before.radiance, &unused.radiance), 0);
    assert_int_equal(unused.stats.pipelines_made, 0);
    const fnl_light_id id = {3, s.scene->lights.data[3].generation};
    const fnl_light_params plain = s.scene->lights.data[3].params;
    fnl_light_params light = plain;
    light.profile = profile;
    assert_int_equal(fnl_scene_set_light(s.scene, id, &light), FNL_OK);
    struct shot used = stage_shoot(&s, &s.frame);
    assert_true(count_differing(&before.radiance, &used.radiance) > 0);
    assert_int_equal(fnl_scene_set_light(s.scene, id, &plain), FNL_OK);
    struct shot again = stage_shoot(&s, &s.frame);
    assert_int_equal(count_differing(&before.radiance, &again.radiance), 0);
    shot_free(&before);
    shot_free(&unused);
    shot_free(&used);
    shot_free(&again);
    stage_close(&s);
}

/* One of each way to walk through lights, and an order that draws them. */
static void test_lists_stay_exact_MA_11(void **state) {
    UNUSED(state);
    static const struct {
        fnl_shading shading;
        fnl_light_lists lists;
    } pairs[] = {{FNL_SHADING_FORWARD, FNL_LISTS_MESH},  {FNL_SHADING_FORWARD_PREPASS, FNL_LISTS_MULTIPASS}, {FNL_SHADING_FORWARD_PREPASS, FNL_LISTS_BATCHES},
                 {FNL_SHADING_FORWARD, FNL_LISTS_CLUSTERED}, {FNL_SHADING_FORWARD, FNL_LISTS_FINE},      {FNL_SHADING_FORWARD, FNL_LISTS_ZBIN}};
    struct stage s = open_small("builtin:spheres?lights=40");
    give(s.scene, add_lamp(s.scene));
    s.frame.shading = FNL_SHADING_FORWARD;
    s.frame.lists = FNL_LISTS_ALL;
    struct shot all = stage_shoot(&s, &s.frame);
    for (uint32_t i = 0; i < COUNT_OF(pairs); i++) {
        s.frame.shading = pairs[i].shading;
        s.frame.lists = pairs[i].lists;
        struct shot shot = stage_shoot(&s, &s.frame);
        if (count_differing(&all.radiance, &shot.radiance)) fail_msg("%s differs from all", pair_name(&s.frame));
        shot_free(&shot);
    }
    s.frame.lists = FNL_LISTS_ALL;
    s.frame.shading = FNL_SHADING_DEFERRED_VOLUMES;
    struct shot volumes = stage_shoot(&s, &s.frame);
    assert_true(greatest_difference(&all.color, &volumes.color) <= PAIRS_ALLOWED);
    shot_free(&volumes);
    shot_free(&all);
    stage_close(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_direction_is_that_of_rays_MA_11),
        cmocka_unit_test(test_pictures_are_those_of_rays_MA_11),
        cmocka_unit_test(test_without_profiles_nothing_changes_MA_11),
        cmocka_unit_test(test_lists_stay_exact_MA_11),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
