/* SPDX-License-Identifier: MIT */
/** Level of detail for lights: what fades, what it costs, and what is drawn instead. */
#include "passes/lights/sprites.h"
#include "passes/lights/sprites_shared.h"
#include "render/device/light_shapes.h"
#include "render/shading.h"
#include "tests/render_harness.h"

static double energy_of(const fnl_image *radiance) {
    double sum = 0;
    const float *p = radiance->pixels;
    for (size_t i = 0; i < (size_t)radiance->width * radiance->height; i++)
        sum += (double)p[4 * i] + (double)p[4 * i + 1] + (double)p[4 * i + 2];
    return sum;
}

/* Lists that are made for the world and not for a view go on naming lights that are gone. */
static bool is_for_the_view(uint32_t lists) {
    return lists != FNL_LISTS_ALL && lists != FNL_LISTS_GRID2D && lists != FNL_LISTS_WORLD;
}

/* A grey floor of 400 m, a camera at a height, and a lamp on the axis at distance 100. */
static struct stage floor_stage(fnl_light_params *lamp, fnl_light_id *id) {
    fnl_scene *scene;
    assert_int_equal(fnl_scene_create(gpu_host(harness_device()), &scene), FNL_OK);
    fnl_material_params grey = fnl_material_params_default();
    grey.metallic = 0;
    grey.base_color[0] = grey.base_color[1] = grey.base_color[2] = (float)SPRITE_ALBEDO;
    grey.specular = 0;
    fnl_material_id material;
    assert_int_equal(fnl_scene_add_material(scene, &grey, &material), FNL_OK);
    static const float positions[] = {-200, 0, 200, 200, 0, 200, 200, 0, -200, -200, 0, -200};
    static const uint32_t indices[] = {0, 1, 2, 0, 2, 3};
    fnl_mesh_params params = {
        .vertex_count = 4, .index_count = 6, .positions = positions, .indices = indices, .material = material};
    fnl_mesh_id mesh;
    fnl_instance_id instance;
    fnl_mat4 identity = {{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}};
    assert_int_equal(fnl_scene_add_mesh(scene, &params, &mesh), FNL_OK);
    assert_int_equal(fnl_scene_add_instance(scene, mesh, &identity, &instance), FNL_OK);
    *lamp = fnl_light_params_default();
    lamp->position = vec3_make(0, 1, 0);
    lamp->intensity = 100;
    lamp->range = 8;
    assert_int_equal(fnl_scene_add_light(scene, lamp, id), FNL_OK);
    struct stage stage = stage_open_scene(scene);
    stage.frame.width = 131;
    stage.frame.height = 73;
    stage.frame.outputs = FNL_OUTPUT_RADIANCE;
    stage.frame.count_lights = true;
    stage.frame.camera = fnl_camera_default();
    stage.frame.camera.position = vec3_make(0, 60, 80);
    stage.frame.camera.target = vec3_make(0, 0, 0);
    return stage;
}

static float pixel_radius(const struct stage *stage, const fnl_light_params *lamp) {
    struct gpu_view view = view_from_camera(&stage->frame.camera, stage->frame.width, stage->frame.height);
    struct gpu_light light;
    struct gpu_entity_bounds bounds;
    device_light(lamp, 0, &light, &bounds);
    float spread = stage->frame.camera.orthographic ? 1 : vec3_distance(bounds.center, view.eye);
    return bounds.radius / (spread * view.ndc_scale.y) * (float)stage->frame.height / 2;
}

static void test_lights_past_their_detail_cost_nothing(void **state) {
    UNUSED(state);
    fnl_light_params lamp;
    fnl_light_id id;
    struct stage stage = floor_stage(&lamp, &id);
    float size = pixel_radius(&stage, &lamp);
    assert_true(size > 4 && size < 40);
    for (uint32_t shading = 0; shading < FNL_SHADING_AUTO; shading++)
        for (uint32_t lists = 0; lists < FNL_LISTS_AUTO; lists++) {
            fnl_frame frame = stage.frame;
            frame.shading = (fnl_shading)shading;
            frame.lists = (fnl_light_lists)lists;
            if (!harness_tries(frame.shading, frame.lists, 23)) continue;
            bool exact = !shading_is(frame.shading, SHADING_APPROXIMATE); /* others may light fewer points */
            uint64_t least = exact ? 20 : 4;
            struct shot near = stage_shoot(&stage, &frame);
            if (near.stats.evaluations == 0 || near.stats.evaluations_useful <= least)
                fail_msg("%s + %s: %llu evaluations, %llu useful", fnl_value_name(FNL_ENUM_SHADING, frame.shading),
                         fnl_value_name(FNL_ENUM_LISTS, frame.lists), (unsigned long long)near.stats.evaluations,
                         (unsigned long long)near.stats.evaluations_useful);
            frame.light_lod = size * 0.5001f; /* hardly whole any more */
            struct shot fading = stage_shoot(&stage, &frame);
            assert_true(fading.stats.evaluations_useful > least);
            frame.light_lod = size * 1.001f;
            struct shot far = stage_shoot(&stage, &frame);
            if (far.stats.evaluations_useful || (is_for_the_view(lists) && far.stats.evaluations))
                fail_msg("%s + %s: %llu evaluations of a light past its detail, %llu useful",
                         fnl_value_name(FNL_ENUM_SHADING, frame.shading), fnl_value_name(FNL_ENUM_LISTS, frame.lists),
                         (unsigned long long)far.stats.evaluations, (unsigned long long)far.stats.evaluations_useful);
            assert_true(energy_of(&far.radiance) > 0); /* its sprite */
            frame.light_lod = 0;
            struct shot again = stage_shoot(&stage, &frame);
            assert_int_equal(count_differing(&near.radiance, &again.radiance), 0);
            frame.light_lod = size * 0.4999f; /* all whole: no pixel knows of the option */
            struct shot whole = stage_shoot(&stage, &frame);
            assert_int_equal(count_differing(&near.radiance, &whole.radiance), 0);
            shot_free(&near);
            shot_free(&fading);
            shot_free(&far);
            shot_free(&again);
            shot_free(&whole);
        }
    stage_close(&stage);
}

/* Greatest difference of a channel, and the greatest channel. */
static double step_between(const fnl_image *a, const fnl_image *b, double *out_greatest) {
    double step = 0;
    const float *p = a->pixels, *q = b->pixels;
    for (size_t i = 0; i < (size_t)a->width * a->height * 4; i++) {
        if (i % 4 == 3) continue;
        step = fmax(step, fabs((double)p[i] - (double)q[i]));
        *out_greatest = fmax(*out_greatest, (double)p[i]);
    }
    return step;
}

/* Moves the threshold over the light in small steps: no pixel may jump. Then moves the camera away: nor may the whole. */
static void test_sweep_has_no_pop(void **state) {
    UNUSED(state);
    enum { STEPS = 60 };
    fnl_light_params lamp;
    fnl_light_id id;
    struct stage stage = floor_stage(&lamp, &id);
    stage.frame.count_lights = false;
    stage.frame.lists = FNL_LISTS_CLUSTERED;
    float size = pixel_radius(&stage, &lamp);
    struct shot last = {0};
    double greatest = 0, worst = 0, first_energy = 0, last_energy = 0, least = INFINITY, most = 0;
    for (uint32_t i = 0; i <= STEPS; i++) {
        stage.frame.light_lod = size * (0.45f + 0.65f * (float)i / STEPS); /* from whole to gone */
        struct shot shot = stage_shoot(&stage, &stage.frame);
        double energy = energy_of(&shot.radiance);
        if (i > 0) worst = fmax(worst, step_between(&last.radiance, &shot.radiance, &greatest));
        if (i == 0) first_energy = energy;
        least = fmin(least, energy);
        most = fmax(most, energy);
        last_energy = energy;
        shot_free(&last);
        last = shot;
    }
    print_message(
        "threshold: a step changes a pixel by %.3f of the brightest at most; energy %.3g whole, %.3g as a sprite\n",
        worst / greatest, first_energy, last_energy);
    assert_true(worst < 0.06 * greatest && worst > 0);
    assert_true(last_energy > first_energy / 2 && last_energy < first_energy * 2);
    assert_true(least > 0.9 * fmin(first_energy, last_energy) && most < 1.1 * fmax(first_energy, last_energy));
    shot_free(&last);

    double previous = 0, previous_off = 0;
    stage.frame.light_lod = size * 0.7f;
    for (uint32_t i = 0; i <= STEPS;
         i++) { /* pixels are sampled at their centres: what that does is there without fading too */
        float away = 0.5f * powf(4, (float)i / STEPS);
        fnl_frame frame = stage.frame;
        frame.camera.position = vec3_scale(vec3_make(0, 60, 80), away);
        struct shot shot = stage_shoot(&stage, &frame);
        frame.light_lod = 0;
        struct shot off = stage_shoot(&stage, &frame);
        double energy = energy_of(&shot.radiance) * (double)(away * away),
               energy_off = energy_of(&off.radiance) * (double)(away * away);
        if (i > 0 && fabs(energy / previous - 1) > 0.06 + fabs(energy_off / previous_off - 1))
            fail_msg("step %u of the way changes the energy by %g", i, energy / previous);
        previous = energy;
        previous_off = energy_off;
        shot_free(&shot);
        shot_free(&off);
    }
    stage_close(&stage);
}

/* With lights whole, fading and gone, every list gives the bits of brute force, and visits fewer lights than without. */
static void test_lists_agree_on_faded_lights(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:city?lights=256&blocks=1", 0);
    stage.frame.outputs = FNL_OUTPUT_RADIANCE;
    stage.frame.width = 67;
    stage.frame.height = 39;
    for (uint32_t shading = FNL_SHADING_FORWARD_PREPASS; shading < FNL_SHADING_AUTO; shading++) {
        fnl_frame frame = stage.frame;
        frame.shading = (fnl_shading)shading;
        frame.lists = FNL_LISTS_ALL;
        struct shot off = stage_shoot(&stage, &frame);
        frame.light_lod = 6;
        struct shot all = stage_shoot(&stage, &frame);
        assert_true(count_differing(&off.radiance, &all.radiance) > 50);
        assert_int_equal(count_broken(&all.radiance), 0);
        for (uint32_t lists = FNL_LISTS_TILED; lists < FNL_LISTS_AUTO; lists++) {
            frame.lists = (fnl_light_lists)lists;
            if (!harness_tries(frame.shading, frame.lists, 13)) continue;
            frame.light_lod = 0;
            struct shot whole = stage_shoot(&stage, &frame);
            frame.light_lod = 6;
            struct shot shot = stage_shoot(&stage, &frame);
            if (count_differing(&all.radiance, &shot.radiance))
                fail_msg("%s + %s: %llu pixels differ from all", fnl_value_name(FNL_ENUM_SHADING, frame.shading),
                         fnl_value_name(FNL_ENUM_LISTS, frame.lists),
                         (unsigned long long)count_differing(&all.radiance, &shot.radiance));
            if (is_for_the_view(lists) && shot.stats.lights_in_view >= whole.stats.lights_in_view)
                fail_msg("%s + %s: %u lights in view, %u without fading", fnl_value_name(FNL_ENUM_SHADING, frame.shading),
                         fnl_value_name(FNL_ENUM_LISTS, frame.lists), shot.stats.lights_in_view, whole.stats.lights_in_view);
            shot_free(&whole);
            shot_free(&shot);
        }
        shot_free(&off);
        shot_free(&all);
    }
    stage_close(&stage);
}

/* Sprites of all kinds of lights in an empty scene: their energy, wherever they stand between pixels; occluded, none; many samples. */
static void test_sprites_have_the_light_they_replace(void **state) {
    UNUSED(state);
    fnl_light_params lamp;
    fnl_light_id id;
    struct stage stage = floor_stage(&lamp, &id);
    stage.frame.count_lights = false;
    struct random_state random = {3};
    for (uint32_t i = 0; i < 24; i++) {
        fnl_light_params l = lamp;
        l.kind = (fnl_light_kind)(FNL_LIGHT_POINT + i % 5);
        l.range = 0.5f;
        l.position = vec3_make(random_range(&random, -20, 20), random_range(&random, 1, 9), random_range(&random, -20, 20));
        l.direction = vec3_make(0, 1, 0);
        l.up = vec3_make(0, 0, 1);
        l.outer_cone_angle = random_range(&random, 0.3f, 1.2f);
        l.inner_cone_angle = l.outer_cone_angle * 0.999f;
        l.wedge_angles[0] = random_range(&random, 0.3f, 1.2f);
        l.wedge_angles[1] = random_range(&random, 0.3f, 1.2f);
        l.length = 0.3f;
        l.box_size = vec3_make(0.3f, 0.5f, 0.4f);
        l.inner_fraction = 0.999f;
        assert_int_equal(fnl_scene_set_light(stage.scene, id, &l), FNL_OK);
        fnl_frame frame = stage.frame;
        frame.light_lod = 30;
        frame.camera.orthographic = i >= 12;
        frame.camera.vertical_extent = 90;
        frame.msaa = i % 3 == 2 ? 4 : 1;
        frame.shading = i % 3 == 2 ? FNL_SHADING_FORWARD : i % 3 ? FNL_SHADING_DEFERRED : FNL_SHADING_DEFERRED_VOLUMES;
        struct gpu_view view = view_from_camera(&frame.camera, frame.width, frame.height);
        double part = 1, outer = cos((double)l.outer_cone_angle);
        if (l.kind == FNL_LIGHT_SPOT) part = 1 - outer;
        if (l.kind == FNL_LIGHT_WEDGE) /* solid angle of a pyramid */
            part = 4 * asin(sin((double)l.wedge_angles[0]) * sin((double)l.wedge_angles[1])) / (2 * (double)PI);
        if (l.kind == FNL_LIGHT_BOX) part = 0.3 * 0.5 / (2 * (double)PI);
        double distance = (double)vec3_distance(l.position, view.eye),
               depth = -(double)mat4_point(&view.world_to_view, l.position).z;
        double pixel = 4 * (double)view.ndc_scale.x * (double)view.ndc_scale.y / ((double)frame.width * frame.height);
        double solid = frame.camera.orthographic ? pixel : pixel * pow(depth, 3) / distance;
        double wanted = 3 * 100 * SPRITE_ALBEDO * part / solid;
        struct shot shot = stage_shoot(&stage, &frame);
        double energy = energy_of(&shot.radiance);
        if (fabs(energy / wanted - 1) > 4e-3) fail_msg("light %u of kind %d: %g, wanted %g", i, (int)l.kind, energy, wanted);
        shot_free(&shot);
        l.position.y = -9; /* under the floor */
        assert_int_equal(fnl_scene_set_light(stage.scene, id, &l), FNL_OK);
        shot = stage_shoot(&stage, &frame);
        assert_true(energy_of(&shot.radiance) == 0);
        shot_free(&shot);
    }
    stage_close(&stage);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        {"ES-6: lights past their detail cost no evaluation; off and whole the bytes stay",
         test_lights_past_their_detail_cost_nothing, NULL, harness_check, NULL},
        {"ES-6: nothing pops while lights fade", test_sweep_has_no_pop, NULL, harness_check, NULL},
        {"ES-6: every list gives the bits of brute force with faded lights", test_lists_agree_on_faded_lights, NULL,
         harness_check, NULL},
        {"ES-6: sprites have the light that they replace", test_sprites_have_the_light_they_replace, NULL, harness_check,
         NULL},
    };
    return cmocka_run_group_tests_name("light sprites", tests, harness_begin, harness_end);
}
