/* SPDX-License-Identifier: MIT */
/* Rectangle lights in frames: what a surface gets is the integral in double precision, in every list and with several samples a pixel, shadowed or not. */
#include "tests/list_pairs.h"
#include "tests/shade_reference.h"
#include "tests/shadow_cases.h"
#include "tests/shadow_leak.h"

enum { WIDTH = 48, HEIGHT = 36, STEP = 4 };

static fnl_light_params panel(vec3 position, vec3 direction, float width, float height) {
    fnl_light_params light = fnl_light_params_default();
    light.kind = FNL_LIGHT_RECTANGLE;
    light.position = position;
    light.direction = direction;
    light.up = (vec3){0.1f, 1, 0.3f};
    light.rectangle_size[0] = width;
    light.rectangle_size[1] = height;
    light.intensity = 10;
    light.range = 40;
    return light;
}

static struct stage open_floor(const fnl_material_params *material, const fnl_light_params *light, vec3 eye) {
    fnl_scene *scene = world_create(NULL);
    fnl_light_id id;
    add_square(scene, material, (vec3){30, 1, 30}, (vec3){0, 0, 0});
    assert_int_equal(fnl_scene_add_light(scene, light, &id), FNL_OK);
    struct stage s = stage_open_scene(scene);
    s.frame.width = WIDTH, s.frame.height = HEIGHT;
    s.frame.shading = FNL_SHADING_FORWARD;
    s.frame.outputs = FNL_OUTPUT_RADIANCE;
    s.frame.camera = fnl_camera_default();
    s.frame.camera.position = eye;
    s.frame.camera.target = (vec3){0, 0, 0};
    s.frame.camera.vertical_fov = 0.7f;
    return s;
}

/* Where the middle of a pixel sees the floor, and the direction back to the eye. */
static bool floor_at(const fnl_camera *camera, uint32_t x, uint32_t y, double place[3], double to_view[3]) {
    const vec3 forward = vec3_normalize(vec3_sub(camera->target, camera->position)), right = vec3_normalize(vec3_cross(forward, camera->up)),
               up = vec3_cross(right, forward);
    const float tangent = tanf(0.5f * camera->vertical_fov), a = (2 * ((float)x + 0.5f) / WIDTH - 1) * tangent * WIDTH / HEIGHT, b = (1 - 2 * ((float)y + 0.5f) / HEIGHT) * tangent;
    const vec3 ray = vec3_normalize(vec3_add_scaled(vec3_add_scaled(forward, right, a), up, b)), eye = camera->position;
    if (!(ray.y < -1e-3f)) return false;
    const vec3 at = vec3_add_scaled(eye, ray, -eye.y / ray.y);
    place[0] = (double)at.x, place[1] = 0, place[2] = (double)at.z;
    to_view[0] = -(double)ray.x, to_view[1] = -(double)ray.y, to_view[2] = -(double)ray.z;
    return fabsf(at.x) < 14 && fabsf(at.z) < 14;
}

struct panel_case {
    const char *name;
    vec3 position, direction;
    float size[2];
    bool two_sided;
    float roughness, metallic;
    vec3 eye;
    double rms, worst; /* allowed, in parts of the brightest pixel */
};

/* Against sums over points of the rectangle by the tracer's BRDF. */
static void test_surfaces_get_the_integral_MP_8(void **state) {
    UNUSED(state);
    static const struct panel_case cases[] = {
        {"rough", {0.3f, 1.5f, 0}, {0.2f, -1, 0.1f}, {2, 1}, false, 0.8f, 0, {0, 3, 3}, 0.0005, 0.001},
        {"smooth", {0, 1.5f, -1.5f}, {0, -1, 1}, {2, 1}, false, 0.25f, 0, {0, 3, 3}, 0.0015, 0.006},
        {"rough metal", {0.5f, 1, -1}, {0, -1, 0.5f}, {1, 1}, false, 0.6f, 1, {0, 3, 3}, 0.003, 0.012},
        {"smooth metal", {0, 1, -1}, {0, -0.5f, 1}, {1, 0.5f}, false, 0.2f, 1, {0, 3, 3}, 0.001, 0.008},
        {"grazing", {0, 1, -2}, {0, -0.3f, 1}, {2, 1}, false, 0.4f, 1, {0, 0.7f, 4}, 0.04, 0.2},
        {"through the horizon", {0, 0.2f, -1}, {0, 0, 1}, {3, 2}, false, 0.5f, 0, {0, 3, 3}, 0.006, 0.025},
        {"two sides", {0, 0.5f, 0}, {0, 0.1f, 1}, {1, 1}, true, 0.5f, 0.5f, {0.5f, 4, 2}, 0.005, 0.03},
        {"near", {0, 0.1f, 0}, {0, -1, 0}, {1, 1}, false, 0.7f, 0, {0, 4, 2}, 0.0005, 0.002},
        {"small", {1, 2, 0}, {-0.2f, -1, 0}, {0.02f, 0.01f}, false, 0.5f, 0.5f, {0, 3, 3}, 1e-4, 5e-4},
        {"tiny", {1, 2, 0}, {-0.2f, -1, 0}, {1e-6f, 1e-6f}, false, 0.5f, 0.5f, {0, 3, 3}, 1e-4, 5e-4},
        {"in its plane", {0, 0, 0}, {0, 1, 0}, {4, 4}, false, 0.5f, 0, {0, 3, 3}, 0, 0},
        {"in its plane, two sides", {0, 0, 0}, {0, 1, 0}, {4, 4}, true, 0.5f, 0, {0, 3, 3}, 0, 0},
        {"from behind", {0, 1, 0}, {0, 1, 0}, {1, 1}, false, 0.5f, 0, {0, 3, 3}, 0, 0},
    };
    for (uint32_t c = 0; c < COUNT_OF(cases); c++) {
        const struct panel_case *k = &cases[c];
        fnl_material_params material = matt(0.7f);
        material.roughness = k->roughness;
        material.metallic = k->metallic;
        material.specular = 1;
        fnl_light_params light = panel(k->position, k->direction, k->size[0], k->size[1]);
        light.two_sided = k->two_sided;
        light.range = c == 2 ? 2.0f : 40;
        struct stage s = open_floor(&material, &light, k->eye);
        struct shot shot = stage_shoot(&s, &s.frame);
        double brightest = 0, squares = 0, worst = 0, count = 0;
        double seen[WIDTH * HEIGHT / STEP / STEP], wanted[WIDTH * HEIGHT / STEP / STEP];
        uint32_t points = 0;
        for (uint32_t y = STEP / 2; y < HEIGHT; y += STEP)
            for (uint32_t x = STEP / 2; x < WIDTH; x += STEP) {
                struct reference_surface surface = reference_surface_default();
                double to_view[3], out[3];
                if (!floor_at(&s.frame.camera, x, y, surface.position, to_view)) continue;
                surface.normal[0] = surface.normal[2] = 0, surface.normal[1] = 1;
                for (int i = 0; i < 3; i++) surface.base_color[i] = (double)material.base_color[i];
                surface.roughness = (double)material.roughness, surface.metallic = (double)material.metallic;
                reference_shade(&surface, to_view, &light, 1, (fnl_vec3){0, 0, 0}, (fnl_vec3){0, 0, 0}, out);
                seen[points] = (double)pixel_at(&shot.radiance, x, y)[1];
                wanted[points] = out[1];
                brightest = fmax(brightest, out[1]);
                points++;
            }
        assert_true(points > 40);
        for (uint32_t i = 0; i < points; i++) {
            const double error = fabs(seen[i] - wanted[i]) / fmax(brightest, 1e-30);
            if (brightest == 0 ? seen[i] != 0 : wanted[i] == 0 && seen[i] != 0) fail_msg("%s: %g where there is no light", k->name, seen[i]);
            squares += brightest > 0 ? error * error : 0;
            worst = fmax(worst, brightest > 0 ? error : 0);
            count++;
        }
        print_message("%-24s mean square error %.4f, greatest %.4f of %.3g\n", k->name, sqrt(squares / count), worst, brightest);
        if (!(sqrt(squares / count) <= k->rms && worst <= k->worst)) fail_msg("%s: errors of %g, %g at most", k->name, sqrt(squares / count), worst);
        if (k->rms > 0) assert_true(brightest > 1e-4);
        shot_free(&shot);
        stage_close(&s);
    }
}

/* Kinds of lists that look their lights up in different ways give the same bits, with one and with several samples. */
static void test_lists_stay_exact(void **state) {
    UNUSED(state);
    static const fnl_light_lists lists[] = {FNL_LISTS_TILED, FNL_LISTS_FINE, FNL_LISTS_BACKFACE, FNL_LISTS_BVH};
    struct stage s = stage_open("builtin:spheres?lights=0", 0);
    fnl_scatter_params scatter = fnl_scatter_params_default();
    scatter.count = 40;
    scatter.shares[FNL_LIGHT_SPOT] = 0;
    scatter.shares[FNL_LIGHT_RECTANGLE] = 3;
    assert_int_equal(fnl_scene_scatter_light_shapes(s.scene, &scatter), FNL_OK);
    s.frame.width = 65, s.frame.height = 37;
    s.frame.shading = FNL_SHADING_DEFERRED;
    for (uint32_t msaa = 1; msaa <= 4; msaa += 3) {
        s.frame.msaa = msaa;
        s.frame.lists = FNL_LISTS_ALL;
        struct shot all = stage_shoot(&s, &s.frame);
        for (uint32_t i = 0; i < (msaa == 1 ? COUNT_OF(lists) : 1); i++) {
            s.frame.lists = lists[i];
            struct shot shot = stage_shoot(&s, &s.frame);
            if (count_differing(&all.radiance, &shot.radiance)) fail_msg("%s differs from all", pair_name(&s.frame));
            shot_free(&shot);
        }
        shot_free(&all);
    }
    stage_close(&s);
}

/* Paths that shade in ways of their own: by volumes, by sums of light, by lights in layers and in pixels. */
static void test_paths_are_alike(void **state) {
    UNUSED(state);
    static const fnl_shading paths[] = {FNL_SHADING_DEFERRED_VOLUMES, FNL_SHADING_LIGHT_PREPASS, FNL_SHADING_ZIOMA, FNL_SHADING_LIGHT_INDEXED};
    struct stage s = stage_open("builtin:spheres?lights=0", 0);
    fnl_scatter_params scatter = fnl_scatter_params_default();
    scatter.count = 8;
    scatter.shares[FNL_LIGHT_SPOT] = 0;
    scatter.shares[FNL_LIGHT_RECTANGLE] = 3;
    assert_int_equal(fnl_scene_scatter_light_shapes(s.scene, &scatter), FNL_OK);
    s.frame.width = 65, s.frame.height = 37;
    s.frame.lists = FNL_LISTS_ALL;
    s.frame.shading = FNL_SHADING_FORWARD;
    struct shot forward = stage_shoot(&s, &s.frame);
    for (uint32_t i = 0; i < COUNT_OF(paths); i++) {
        s.frame.shading = paths[i];
        struct shot shot = stage_shoot(&s, &s.frame);
        const int difference = (int)greatest_difference(&forward.color, &shot.color);
        if (difference > PAIRS_ALLOWED) fail_msg("%s differs by %d", fnl_value_name(FNL_ENUM_SHADING, paths[i]), difference);
        shot_free(&shot);
    }
    shot_free(&forward);
    stage_close(&s);
}

/* A rectangle that is taken away again leaves the picture as it was, and the shaders of before. */
static void test_without_rectangles_nothing_changes(void **state) {
    UNUSED(state);
    const fnl_material_params material = matt(0.7f);
    fnl_light_params light = fnl_light_params_default();
    light.position = (vec3){0, 2, 0};
    light.intensity = 5;
    struct stage s = open_floor(&material, &light, (vec3){0, 3, 3});
    struct shot before = stage_shoot(&s, &s.frame);
    assert_int_equal(s.renderer->device_scene->lobes.buffer.size, 0);
    const fnl_light_params more = panel((vec3){0.5f, 1, 0}, (vec3){0, -1, 0}, 1, 1);
    fnl_light_id id;
    assert_int_equal(fnl_scene_add_light(s.scene, &more, &id), FNL_OK);
    struct shot with = stage_shoot(&s, &s.frame);
    assert_true(count_differing(&before.radiance, &with.radiance) > WIDTH * HEIGHT / 2);
    assert_int_equal(fnl_scene_remove_light(s.scene, id), FNL_OK);
    struct shot after = stage_shoot(&s, &s.frame);
    assert_int_equal(after.stats.pipelines_made, 0);
    assert_int_equal(count_differing(&before.radiance, &after.radiance), 0);
    shot_free(&before);
    shot_free(&with);
    shot_free(&after);
    stage_close(&s);
}

/* A wall between a panel and all of the floor lets nothing through, however many rays there are; beside it there is light. */
static void test_no_light_comes_through_walls(void **state) {
    UNUSED(state);
    const fnl_material_params material = matt(0.7f);
    for (int walled = 0; walled < 2; walled++) {
        const fnl_light_params light = panel((vec3){0, 1, 0}, (vec3){0.4f, -1, 0.2f}, 3, 2);
        struct stage s = open_floor(&material, &light, (vec3){0, 3, 0.1f});
        fnl_material_params wall = matt(0.5f);
        wall.double_sided = true;
        if (walled) add_square(s.scene, &wall, (vec3){28, 1, 28}, (vec3){0, 0.05f, 0});
        s.frame.camera.position = (vec3){0, 0.04f, 3}; /* from below the wall */
        s.frame.camera.target = (vec3){0, 0, 0};
        for (fnl_shadows shadows = FNL_SHADOWS_RAYS; shadows <= FNL_SHADOWS_SAMPLED; shadows++)
            for (uint32_t samples = 1; samples <= 4; samples += 3) {
                s.frame.shadows = shadows;
                s.frame.shadow.samples = samples;
                struct shot shot = stage_shoot(&s, &s.frame);
                float most = 0;
                for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) most = fmaxf(most, pixel_at(&shot.radiance, i % WIDTH, i / WIDTH)[1]);
                if (walled ? most != 0 : !(most > 0.1f)) fail_msg("shadows %s, %u rays: %g", fnl_value_name(FNL_ENUM_SHADOWS, shadows), samples, (double)most);
                shot_free(&shot);
            }
        stage_close(&s);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_surfaces_get_the_integral_MP_8, harness_check),
        cmocka_unit_test_teardown(test_lists_stay_exact, harness_check),
        cmocka_unit_test_teardown(test_paths_are_alike, harness_check),
        cmocka_unit_test_teardown(test_without_rectangles_nothing_changes, harness_check),
        cmocka_unit_test_teardown(test_no_light_comes_through_walls, harness_check),
    };
    return cmocka_run_group_tests_name("rectangle_lights", tests, harness_begin, harness_end);
}
