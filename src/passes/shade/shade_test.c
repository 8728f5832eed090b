/* SPDX-License-Identifier: MIT */
/** Shading on the GPU against the double-precision reference. */
#include "fanal/trace.h"
#include "passes/post/post_shared.h"
#include "tests/frame_plain.h"
#include "tests/shade_reference.h"
#include "tests/render_test.h"

#define TOLERANCE 1e-3 /* relative; of a thousandth of the brightest channel at least */

/* ---- comparing pixels ---- */

struct scene_setup {
    const struct scene_material *materials; /* by draw item */
    const fnl_light_params *lights;
    uint32_t light_count;
    vec3 sky, ground;
};

static void view_direction(const fnl_camera *camera, const double position[3], double out[3]) {
    double from[3] = {camera->position.x, camera->position.y, camera->position.z};
    double to[3] = {camera->target.x, camera->target.y, camera->target.z}, length = 0;
    for (int i = 0; i < 3; i++) {
        out[i] = from[i] - (camera->orthographic ? to[i] : position[i]);
        length += out[i] * out[i];
    }
    for (int i = 0; i < 3; i++) out[i] /= sqrt(length);
}

static struct reference_surface surface_of(const struct scene_material *m) {
    struct reference_surface s = reference_surface_default();
    const float base[3] = {m->base_color.x, m->base_color.y, m->base_color.z},
                tint[3] = {m->specular_color.x, m->specular_color.y, m->specular_color.z};
    const float emissive[3] = {m->emissive.x, m->emissive.y, m->emissive.z};
    for (int i = 0; i < 3; i++) {
        s.base_color[i] = base[i];
        s.specular_color[i] = tint[i];
        s.emissive[i] = emissive[i];
    }
    s.metallic = m->metallic;
    s.roughness = m->roughness;
    s.ior = m->ior;
    s.specular = m->specular;
    return s;
}

/* Across two neighbors of a pixel, unit; false at the border and where they show something else. */
static bool normal_across(const fnl_image *position, uint32_t x, uint32_t y, int side, double out[3]) {
    const int64_t right = (int64_t)x + side, down = (int64_t)y + side;
    if (right < 0 || down < 0 || right >= position->width || down >= position->height) return false;
    const float *p = test_pixel(position, x, y), *a = test_pixel(position, (uint32_t)right, y), *b = test_pixel(position, x, (uint32_t)down);
    if (a[3] != p[3] || b[3] != p[3]) return false;
    double u[3], v[3], length = 0;
    for (int c = 0; c < 3; c++) u[c] = (double)a[c] - (double)p[c], v[c] = (double)b[c] - (double)p[c];
    for (int c = 0; c < 3; c++) out[c] = u[(c + 1) % 3] * v[(c + 2) % 3] - u[(c + 2) % 3] * v[(c + 1) % 3], length += out[c] * out[c];
    for (int c = 0; c < 3; c++) out[c] /= sqrt(length);
    return length > 0;
}

/* The geometric normal, where the neighbors on both sides lie on the same triangle. */
static bool find_geometric(const fnl_image *position, uint32_t x, uint32_t y, double out[3]) {
    double other[3];
    if (!normal_across(position, x, y, 1, out) || !normal_across(position, x, y, -1, other)) return false;
    return out[0] * other[0] + out[1] * other[1] + out[2] * other[2] > 1 - 1e-7;
}

/* Largest relative error over the covered pixels whose triangle is known; prints where. */
static double compare_with_reference(fnl_renderer *renderer, const fnl_camera *camera, const struct scene_setup *setup,
                                     double floor_part, uint32_t *out_covered) {
    fnl_image radiance = test_read(renderer, FNL_OUTPUT_RADIANCE), normal = test_read(renderer, FNL_OUTPUT_NORMAL);
    fnl_image position = test_read(renderer, FNL_OUTPUT_POSITION), surface = test_read(renderer, FNL_OUTPUT_SURFACE);
    double worst = 0, brightest = 0;
    *out_covered = 0;
    for (uint32_t i = 0; i < radiance.width * radiance.height; i++)
        for (int c = 0; c < 3; c++) brightest = fmax(brightest, ((float *)radiance.pixels)[i * 4 + (uint32_t)c]);
    for (uint32_t y = 0; y < radiance.height; y++)
        for (uint32_t x = 0; x < radiance.width; x++) {
            const float *p = test_pixel(&position, x, y), *n = test_pixel(&normal, x, y), *b = test_pixel(&surface, x, y),
                        *r = test_pixel(&radiance, x, y);
            if (p[3] == 0) continue;
            const struct scene_material *material = &setup->materials[(uint32_t)p[3] - 1];
            struct reference_surface s = surface_of(material);
            if (!find_geometric(&position, x, y, s.geometric)) continue;
            ++*out_covered;
            double length = sqrt((double)n[0] * n[0] + (double)n[1] * n[1] + (double)n[2] * n[2]), to_view[3], expected[3];
            assert_true(fabs(length - 1) < 1e-5);
            for (int c = 0; c < 3; c++) {
                s.position[c] = p[c];
                s.normal[c] = n[c] / length;
                assert_true(fabs(s.base_color[c] - (double)b[c]) < 1e-6);
            }
            assert_true(fabs(s.roughness - (double)b[3]) < 1e-6);
            view_direction(camera, s.position, to_view);
            if (s.geometric[0] * to_view[0] + s.geometric[1] * to_view[1] + s.geometric[2] * to_view[2] < 0)
                for (int c = 0; c < 3; c++) s.geometric[c] *= -1;
            reference_shade(&s, to_view, setup->lights, setup->light_count, setup->sky, setup->ground, expected);
            for (int c = 0; c < 3; c++) {
                assert_true(isfinite(r[c]));
                double error = fabs(r[c] - expected[c]) / fmax(expected[c], brightest * floor_part);
                if (error > worst) {
                    worst = error;
                    if (error > TOLERANCE)
                        print_message("pixel %u, %u channel %d: %.9g, reference %.9g, roughness %g, metallic %g\n", x, y, c,
                                      (double)r[c], expected[c], s.roughness, s.metallic);
                }
            }
        }
    free_picture(&radiance);
    free_picture(&normal);
    free_picture(&position);
    free_picture(&surface);
    return worst;
}

#define SURFACE_OUTPUTS (FNL_OUTPUT_RADIANCE | FNL_OUTPUT_SURFACE | FNL_OUTPUT_NORMAL | FNL_OUTPUT_POSITION)

enum { MATERIALS = 9, LIGHTS = 50 };

/* Eight spheres on a plane; draw items come in the order of their meshes. */
static void add_spheres(fnl_scene *scene, struct scene_material materials[MATERIALS]) {
    static const float metallic[MATERIALS] = {0, 0, 0, 0, 0.5f, 1, 1, 0.5f, 0},
                       roughness[MATERIALS] = {0.6f, 0.2f, 0.5f, 1, 0.35f, 0.25f, 1, 0.7f, 0.4f};
    for (uint32_t i = 0; i < MATERIALS; i++) {
        struct scene_material *m = &materials[i];
        *m = scene_material_default();
        m->base_color = (vec4){0.2f + 0.08f * (float)i, 0.9f - 0.07f * (float)i, 0.5f, 1};
        m->metallic = metallic[i];
        m->roughness = roughness[i];
        if (i == 2) m->ior = 1.33f;
        if (i == 3) m->specular = 0.5f;
        if (i == 8) {
            m->ior = 2.2f;
            m->specular_color = (vec3){3, 0.5f, 0.25f};
            m->specular = 0.8f;
        }
        if (i == 4) m->emissive = (vec3){0.1f, 0.2f, 0.3f};
        uint32_t material = scene_add_material(scene, m);
        if (i == 0) {
            mat4 lie = mat4_from_trs((vec3){0, -1, 0}, quat_axis_angle((vec3){1, 0, 0}, -PI / 2), (vec3){8, 8, 1});
            scene_add_node(scene, "", SCENE_NONE, &lie, test_quad_mesh(scene, material));
        } else {
            test_place(scene, test_sphere_mesh(scene, material, 12),
                       (vec3){(float)((i - 1) % 4) * 2.2f - 3.3f, 0.1f, (float)((i - 1) / 4) * -2.6f}, (vec3){1, 1, 1});
        }
    }
}

static void add_mixed_lights(fnl_scene *scene, fnl_light_params lights[LIGHTS]) {
    static const fnl_light_kind kinds[] = {FNL_LIGHT_SPOT, FNL_LIGHT_POINT, FNL_LIGHT_CAPSULE, FNL_LIGHT_WEDGE,
                                           FNL_LIGHT_BOX};
    struct random_state random = {20};
    for (uint32_t i = 0; i < LIGHTS; i++) {
        fnl_light_params *l = &lights[i];
        *l = fnl_light_params_default();
        l->kind = i % 10 == 0 ? FNL_LIGHT_DIRECTIONAL : kinds[i % COUNT_OF(kinds)];
        l->position = (vec3){random_range(&random, -5, 5), random_range(&random, 0, 3), random_range(&random, -5, 3)};
        l->direction = vec3_normalize(
            (vec3){random_range(&random, -1, 1), random_range(&random, -1.5f, -0.2f), random_range(&random, -1, 1)});
        for (int c = 0; c < 3; c++) l->color[c] = random_range(&random, 0.2f, 1);
        l->intensity = l->kind == FNL_LIGHT_DIRECTIONAL ? 0.5f : random_range(&random, 1, 8);
        if (l->kind == FNL_LIGHT_BOX) l->intensity *= 0.2f;
        l->range = i % 3 == 0 ? INFINITY : random_range(&random, 1.5f, 6);
        l->outer_cone_angle = random_range(&random, 0.3f, PI / 2);
        l->inner_cone_angle = i % 4 == 0 ? l->outer_cone_angle : random_range(&random, 0, l->outer_cone_angle);
        l->up = (vec3){random_range(&random, -1, 1), random_range(&random, -1, 1), random_range(&random, -1, 1)};
        l->length = i % 3 == 0 ? 0 : random_range(&random, 0.1f, 4);
        for (int k = 0; k < 2; k++) l->wedge_angles[k] = random_range(&random, 0.2f, 1.4f);
        l->box_size = (vec3){random_range(&random, 0.5f, 4), random_range(&random, 0.5f, 4), random_range(&random, 1, 9)};
        l->inner_fraction = random_range(&random, 0, 0.95f);
        fnl_light_id id;
        assert_int_equal(fnl_scene_add_light(scene, l, &id), FNL_OK);
    }
}

static void test_mixed_lights(void **state) {
    UNUSED(state);
    fnl_scene *scene = test_scene();
    struct scene_material materials[MATERIALS];
    fnl_light_params lights[LIGHTS];
    add_spheres(scene, materials);
    add_mixed_lights(scene, lights);
    struct scene_setup setup = {materials, lights, LIGHTS, {0.05f, 0.08f, 0.2f}, {0.1f, 0.06f, 0.03f}};
    assert_int_equal(fnl_scene_set_ambient(scene, setup.sky, setup.ground), FNL_OK);
    fnl_frame frame = test_frame(SURFACE_OUTPUTS);
    frame.width = 120;
    frame.height = 67;
    frame.camera = fnl_camera_default();
    frame.camera.position = (vec3){0.5f, 2.5f, 7};
    frame.camera.target = (vec3){0, -0.2f, 0};
    fnl_renderer *renderer = test_renderer(scene);
    for (uint32_t lists = 0; lists < FNL_LISTS_COUNT; lists++) {
        frame.lists = (fnl_light_lists)lists;
        if (!fnl_shading_supports(frame.shading, frame.lists, frame.msaa)) continue;
        test_render_frame(renderer, &frame);
        uint32_t covered;
        double error = compare_with_reference(renderer, &frame.camera, &setup, 1e-4, &covered);
        print_message("50 mixed lights of six kinds, %s: largest relative error %.2g over %u pixels\n",
                      fnl_value_name(FNL_ENUM_LISTS, frame.lists), error, covered);
        assert_true(covered > 2500 && error < TOLERANCE);
    }
    /* Orthographic and off-axis views see along other directions. */
    frame.lists = FNL_LISTS_CLUSTERED;
    frame.camera.orthographic = true;
    frame.camera.vertical_extent = 6;
    frame.camera.shift = (vec2){0.1f, -0.2f};
    test_render_frame(renderer, &frame);
    uint32_t covered;
    double error = compare_with_reference(renderer, &frame.camera, &setup, 1e-4, &covered);
    assert_true(covered > 2500 && error < TOLERANCE);
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* ---- one plane, known in closed form ---- */

/* The square -1..1 in the xy plane from above; pixel centres are its points. */
static fnl_scene *plane_scene(const struct scene_material *material, const fnl_light_params *light, fnl_light_id *id) {
    fnl_scene *scene = test_scene();
    test_place(scene, test_quad_mesh(scene, scene_add_material(scene, material)), (vec3){0, 0, 0}, (vec3){1, 1, 1});
    assert_int_equal(fnl_scene_add_light(scene, light, id), FNL_OK);
    return scene;
}

static void pixel_position(uint32_t x, uint32_t y, double out[3]) {
    out[0] = (x + 0.5) / 32 - 1;
    out[1] = 1 - (y + 0.5) / 32;
    out[2] = 0;
}

/* Largest error relative to the reference and a part of its brightest pixel. */
static double compare_plane(const fnl_image *radiance, const struct scene_material *material, const fnl_light_params *light,
                            double *brightest) {
    static double expected[64][64][3];
    double worst = 0, to_view[3] = {0, 0, 1};
    *brightest = 0;
    for (uint32_t y = 0; y < 64; y++)
        for (uint32_t x = 0; x < 64; x++) {
            struct reference_surface s = surface_of(material);
            pixel_position(x, y, s.position);
            reference_shade(&s, to_view, light, 1, (fnl_vec3){0, 0, 0}, (fnl_vec3){0, 0, 0}, expected[y][x]);
            for (int c = 0; c < 3; c++) *brightest = fmax(*brightest, expected[y][x][c]);
        }
    for (uint32_t y = 0; y < 64; y++)
        for (uint32_t x = 0; x < 64; x++)
            for (int c = 0; c < 3; c++) {
                double value = test_pixel(radiance, x, y)[c], wanted = expected[y][x][c];
                assert_true(isfinite(value) && value >= 0);
                if (wanted == 0)
                    assert_true(value == 0); /* exactly: this is what lets lists leave lights out */
                else
                    worst = fmax(worst, fabs(value - wanted) / fmax(wanted, *brightest * 1e-4));
            }
    return worst;
}

static void test_materials_in_closed_form(void **state) {
    UNUSED(state);
    static const float roughnesses[] = {0, 0.05f, 0.3f, 1}, metallics[] = {0, 0.5f, 1};
    static const float heights[] = {0.01f, 0.5f, 3}; /* the first grazes */
    for (uint32_t r = 0; r < COUNT_OF(roughnesses); r++) {
        double worst = 0;
        for (uint32_t m = 0; m < COUNT_OF(metallics); m++) {
            struct scene_material material = scene_material_default();
            material.base_color = (vec4){0.8f, 0.4f, 0.1f, 1};
            material.roughness = roughnesses[r];
            material.metallic = metallics[m];
            fnl_light_params light = test_point((vec3){0, 0, 1}, 2, INFINITY);
            fnl_light_id id;
            fnl_scene *scene = plane_scene(&material, &light, &id);
            fnl_renderer *renderer = test_renderer(scene);
            fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE);
            for (uint32_t h = 0; h < COUNT_OF(heights); h++) {
                light.position = (vec3){0.31f, -0.2f, heights[h]};
                assert_int_equal(fnl_scene_set_light(scene, id, &light), FNL_OK);
                test_render_frame(renderer, &frame);
                fnl_image radiance = test_read(renderer, FNL_OUTPUT_RADIANCE);
                double brightest;
                worst = fmax(worst, compare_plane(&radiance, &material, &light, &brightest));
                assert_true(brightest > 0);
                free_picture(&radiance);
            }
            fnl_renderer_destroy(&renderer);
            fnl_scene_destroy(&scene);
        }
        /* Near a mirror's peak float rounding of the half vector is magnified by 1 / alpha. */
        print_message("plane, roughness %g: largest relative error %.2g\n", (double)roughnesses[r], worst);
        assert_true(worst < (roughnesses[r] < 0.1f ? 1e-2 : TOLERANCE));
    }
}

static void test_light_limits(void **state) {
    UNUSED(state);
    struct scene_material material = scene_material_default();
    material.metallic = 0;
    fnl_light_params light = test_point((vec3){0, 0, 0.6f}, 3, 0.9f);
    fnl_light_id id;
    fnl_scene *scene = plane_scene(&material, &light, &id);
    fnl_renderer *renderer = test_renderer(scene);
    fnl_light_params lights[] = {light,                                   /* the range cuts a disc out of the plane */
                                 test_point((vec3){0, 0, 0.6f}, 3, 0.6f), /* touches in one point at most */
                                 test_point((vec3){0, 0, -0.5f}, 3, 9),   /* behind the surface */
                                 test_point((vec3){0, 0, 0}, 3, 9),       /* in the surface */
                                 test_point((vec3){1 / 64.0f, 1 / 64.0f, 0}, 3, 9), /* in the surface, at a pixel's centre */
                                 test_point((vec3){0.2f, 0, 0.5f}, 0, INFINITY),    /* dark: the derived range is 0 */
                                 test_point((vec3){0, 0, 1}, 1e-30f, 1e-3f),
                                 test_point((vec3){0, 0, 1e4f}, 1e9f, INFINITY),
                                 light,
                                 light,
                                 light,
                                 light};
    for (uint32_t i = 8; i < COUNT_OF(lights); i++) {
        lights[i].kind = FNL_LIGHT_SPOT;
        lights[i].range = 5;
        lights[i].direction = (vec3){0.2f, 0.1f, -1};
        lights[i].outer_cone_angle = 0.7f;
    }
    lights[9].inner_cone_angle = 0.7f;
    lights[10].outer_cone_angle = PI / 2;
    lights[11].outer_cone_angle = 0.2f;
    for (uint32_t i = 0; i < COUNT_OF(lights); i++) {
        assert_int_equal(fnl_scene_set_light(scene, id, &lights[i]), FNL_OK);
        for (uint32_t lists = 0; lists < FNL_LISTS_COUNT; lists++) {
            fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE);
            frame.lists = (fnl_light_lists)lists;
            if (!fnl_shading_supports(frame.shading, frame.lists, frame.msaa)) continue;
            test_render_frame(renderer, &frame);
            fnl_image radiance = test_read(renderer, FNL_OUTPUT_RADIANCE);
            double brightest, error = 0;
            if (i == 4) { /* at distance 0 the direction is undefined: only finite is asked for */
                for (uint32_t p = 0; p < 64 * 64 * 4; p++) assert_true(isfinite(((float *)radiance.pixels)[p]));
            } else {
                error = compare_plane(&radiance, &material, &lights[i], &brightest);
            }
            /* The ramp of a hard edge is a thousandth of the cosine wide and magnifies its rounding. */
            if (error >= (i == 9 ? 1e-2 : TOLERANCE))
                fail_msg("light %u, %s: error %g", i, fnl_value_name(FNL_ENUM_LISTS, frame.lists), error);
            free_picture(&radiance);
        }
    }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

static void test_directional_light(void **state) {
    UNUSED(state);
    struct scene_material material = scene_material_default();
    material.roughness = 0.4f;
    material.metallic = 0.5f;
    fnl_light_params light = fnl_light_params_default();
    light.kind = FNL_LIGHT_DIRECTIONAL;
    light.direction = (vec3){0.3f, -0.5f, -0.4f};
    light.intensity = 1e5f;
    fnl_light_id id;
    fnl_scene *scene = plane_scene(&material, &light, &id);
    fnl_renderer *renderer = test_renderer(scene);
    fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE);
    for (int below = 0; below < 2; below++) {
        if (below) light.direction.z = 0.4f;
        assert_int_equal(fnl_scene_set_light(scene, id, &light), FNL_OK);
        test_render_frame(renderer, &frame);
        fnl_image radiance = test_read(renderer, FNL_OUTPUT_RADIANCE);
        double brightest, error = compare_plane(&radiance, &material, &light, &brightest);
        assert_true(error < TOLERANCE && (brightest > 0) == !below);
        free_picture(&radiance);
    }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* A smooth metal in an even ambient light must not give back more than came in, and a rough white dielectric most of it. */
static void test_furnace(void **state) {
    UNUSED(state);
    for (int i = 0; i < 6; i++) {
        struct scene_material material = scene_material_default();
        material.metallic = i % 2 ? 1.0f : 0.0f;
        material.roughness = (float)(i / 2) * 0.5f;
        fnl_scene *scene = test_scene();
        test_place(scene, test_quad_mesh(scene, scene_add_material(scene, &material)), (vec3){0, 0, 0}, (vec3){1, 1, 1});
        assert_int_equal(fnl_scene_set_ambient(scene, (vec3){1, 1, 1}, (vec3){1, 1, 1}), FNL_OK);
        fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE);
        fnl_image radiance = test_render(scene, &frame, FNL_OUTPUT_RADIANCE);
        struct reference_surface s = surface_of(&material);
        double expected[3], to_view[3] = {0, 0, 1};
        reference_shade(&s, to_view, NULL, 0, (vec3){1, 1, 1}, (vec3){1, 1, 1}, expected);
        assert_pixel(&radiance, 20, 30, expected[0], expected[1], expected[2], TOLERANCE);
        assert_true(test_pixel(&radiance, 20, 30)[0] < 1.02f && test_pixel(&radiance, 20, 30)[0] > 0.3f);
        free_picture(&radiance);
        fnl_scene_destroy(&scene);
    }
}

/* ---- naive forward: cost and picture ---- */

static void test_naive_cost(void **state) {
    UNUSED(state);
    fnl_scene *scene = test_scene();
    struct scene_material materials[MATERIALS];
    fnl_light_params lights[LIGHTS];
    add_spheres(scene, materials);
    add_mixed_lights(scene, lights);
    uint32_t directional = 0;
    for (uint32_t i = 0; i < LIGHTS; i++) directional += lights[i].kind == FNL_LIGHT_DIRECTIONAL;
    fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE | FNL_OUTPUT_POSITION);
    frame.camera = fnl_camera_default();
    frame.camera.position = (vec3){0, 9, 0.5f}; /* from above nothing overlaps: one fragment a pixel */
    frame.camera.target = (vec3){0, 0, 0};
    frame.camera.up = (vec3){0, 0, -1};
    frame.count_lights = true;
    fnl_renderer *renderer = test_renderer(scene);
    for (uint32_t shading = 0; shading < FNL_SHADING_DEFERRED + 1; shading++) {
        frame.shading = (fnl_shading)shading;
        if (shading == FNL_SHADING_FORWARD) continue; /* depends on the order of draws: see below */
        test_render_frame(renderer, &frame);
        fnl_image position = test_read(renderer, FNL_OUTPUT_POSITION);
        uint64_t covered = 0;
        for (uint32_t i = 0; i < 64 * 64; i++) covered += ((float *)position.pixels)[i * 4 + 3] > 0;
        fnl_frame_stats stats;
        assert_int_equal(fnl_renderer_query_stats(renderer, &stats), FNL_OK);
        assert_true(covered > 3000 && stats.evaluations_counted);
        assert_int_equal(stats.evaluations, covered * (LIGHTS - directional));
        assert_int_equal(stats.max_per_pixel, LIGHTS - directional);
        assert_int_equal(stats.lights_total, LIGHTS);
        free_picture(&position);
    }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* F is the number of fragments shaded: forward shades each of three layers that are drawn back to front, for every
   light, but only the first of those that are drawn front to back. */
static void check_layers(bool back_to_front) {
    fnl_scene *scene = test_scene();
    struct scene_material material = scene_material_default();
    uint32_t mesh = test_quad_mesh(scene, scene_add_material(scene, &material));
    for (int i = 0; i < 3; i++)
        test_place(scene, mesh, (vec3){0, 0, (float)(back_to_front ? i : 2 - i) * 0.3f}, (vec3){1, 1, 1});
    for (int i = 0; i < 7; i++) {
        fnl_light_params light = test_point((vec3){(float)i * 0.1f, 0, 2}, 1, 5);
        fnl_light_id id;
        assert_int_equal(fnl_scene_add_light(scene, &light, &id), FNL_OK);
    }
    fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE);
    frame.count_lights = true;
    fnl_renderer *renderer = test_renderer(scene);
    const uint64_t layers[FNL_SHADING_DEFERRED + 1] = {back_to_front ? 3 : 1, 1, 1};
    fnl_image pictures[FNL_SHADING_DEFERRED + 1];
    for (uint32_t shading = 0; shading < FNL_SHADING_DEFERRED + 1; shading++) {
        frame.shading = (fnl_shading)shading;
        test_render_frame(renderer, &frame);
        fnl_frame_stats stats;
        assert_int_equal(fnl_renderer_query_stats(renderer, &stats), FNL_OK);
        print_message("%s: %llu evaluations of 7 lights on 4096 pixels of three layers\n", fnl_value_name(FNL_ENUM_SHADING, frame.shading),
                      (unsigned long long)stats.evaluations);
        assert_int_equal(stats.evaluations, layers[shading] * 64 * 64 * 7);
        pictures[shading] = test_read(renderer, FNL_OUTPUT_RADIANCE);
    }
    assert_true(test_equal(&pictures[0], &pictures[1]));
    for (uint32_t i = 0; i < FNL_SHADING_DEFERRED + 1; i++) free_picture(&pictures[i]);
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

static void test_naive_fragments(void **state) {
    UNUSED(state);
    check_layers(true);
    check_layers(false);
}

/* ---- tone mapping ---- */

static void test_tone_mapping(void **state) {
    UNUSED(state);
    enum { COLUMNS = 16, ROWS = 4 };
    fnl_scene *scene = test_scene();
    double colors[ROWS][COLUMNS][3];
    struct random_state random = {7};
    for (int y = 0; y < ROWS; y++)
        for (int x = 0; x < COLUMNS; x++) {
            struct scene_material material = test_unlit(0, 0, 0);
            vec3 color = {0, 0, 0};
            float level = exp2f((float)x * 0.75f - 7); /* up to 19 */
            if (y == 0)
                color = (vec3){level, level, level};
            else if (y == 1)
                color = (vec3){level, level * 0.1f, 0};
            else
                color = (vec3){level * random_float(&random), level * random_float(&random), level * random_float(&random)};
            if (x == 0 && y == 1) color = (vec3){0, 0, 0};
            if (x == COLUMNS - 1 && y == 0) color = (vec3){6e4f, 6e4f, 6e4f};
            material.unlit = false; /* emission alone: black, without reflection */
            material.base_color = (vec4){0, 0, 0, 1};
            material.metallic = 0;
            material.emissive = color;
            test_place(scene, test_quad_mesh(scene, scene_add_material(scene, &material)),
                       (vec3){((float)x + 0.5f) / COLUMNS * 2 - 1, 1 - ((float)y + 0.5f) / ROWS * 2, 0},
                       (vec3){1.0f / COLUMNS, 1.0f / ROWS, 1});
            colors[y][x][0] = color.x;
            colors[y][x][1] = color.y;
            colors[y][x][2] = color.z;
        }
    fnl_renderer *renderer = test_renderer(scene);
    fnl_frame frame = test_frame(FNL_OUTPUT_COLOR | FNL_OUTPUT_RADIANCE);
    for (int mode = 0; mode < 3; mode++)
        for (uint32_t tonemap = 0; tonemap < FNL_TONEMAP_COUNT; tonemap++) {
            frame.tonemap = (fnl_tonemap)tonemap;
            frame.exposure = mode == 0 ? FNL_EXPOSURE_NONE : mode == 1 ? FNL_EXPOSURE_EV : FNL_EXPOSURE_AUTO;
            frame.ev = 1.5f;
            test_render_frame(renderer, &frame);
            fnl_image picture = test_read(renderer, FNL_OUTPUT_COLOR), radiance = test_read(renderer, FNL_OUTPUT_RADIANCE);
            fnl_frame_stats stats;
            assert_int_equal(fnl_renderer_query_stats(renderer, &stats), FNL_OK);
            double factor = mode == 0 ? 1 : 1 / (1.2 * exp2((double)stats.ev));
            if (mode == 1) assert_true(stats.ev == 1.5f);
            for (uint32_t y = 0; y < ROWS; y++)
                for (uint32_t x = 0; x < COLUMNS; x++) {
                    assert_pixel(&radiance, x * 4 + 2, y * 16 + 8, colors[y][x][0], colors[y][x][1], colors[y][x][2], 0);
                    double exposed[3], mapped[3];
                    for (int c = 0; c < 3; c++) exposed[c] = colors[y][x][c] * factor;
                    reference_tonemap(frame.tonemap, exposed, mapped);
                    const uint8_t *p = test_pixel8(&picture, x * 4 + 2, y * 16 + 8);
                    assert_int_equal(p[3], 255);
                    for (int c = 0; c < 3; c++) {
                        double wanted = reference_srgb(mapped[c]) * 255;
                        if (fabs(p[c] - wanted) > 0.75)
                            fail_msg("%s of %g %g %g: channel %d is %d, reference %g", fnl_value_name(FNL_ENUM_TONEMAP, frame.tonemap),
                                     exposed[0], exposed[1], exposed[2], c, p[c], wanted);
                    }
                }
            free_picture(&picture);
            free_picture(&radiance);
        }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* Metering an even picture finds EV100 = log2(L * 100 / 12.5), to half a bin of the histogram. */
static void test_automatic_exposure(void **state) {
    UNUSED(state);
    static const float levels[] = {1e-3f, 0.18f, 4, 1000};
    for (uint32_t i = 0; i < COUNT_OF(levels); i++) {
        fnl_scene *scene = test_scene();
        assert_int_equal(fnl_scene_set_background(scene, (vec3){levels[i], levels[i], levels[i]}), FNL_OK);
        fnl_frame frame = test_frame(FNL_OUTPUT_COLOR);
        frame.exposure = FNL_EXPOSURE_AUTO;
        fnl_renderer *renderer = test_renderer(scene);
        test_render_frame(renderer, &frame);
        fnl_frame_stats stats;
        assert_int_equal(fnl_renderer_query_stats(renderer, &stats), FNL_OK);
        assert_true(fabs((double)stats.ev - (log2((double)levels[i]) - log2(1.2 * 0.18))) <= 40.0 / 256 / 2 + 1e-3);
        fnl_renderer_destroy(&renderer);
        fnl_scene_destroy(&scene);
    }
}

struct metered {
    double level, weight;
    bool surface;
};
static int compare_metered(const void *a, const void *b) {
    const double x = ((const struct metered *)a)->level, y = ((const struct metered *)b)->level;
    return (x > y) - (x < y);
}

/*
 * Of an uneven picture the trimmed mean of the log luminances counts, of surfaces far more than of the background, in the middle more than at the
 * edges, black not at all; unless highlights would be lost: against what was read back. Sides that are no multiple of what a group takes.
 * `sparkle`: half the width of a light that is brighter than all else.
 */
static uint32_t meter_uneven(float sparkle) {
    enum { SQUARES = 12 };
    fnl_scene *scene = test_scene();
    struct random_state random = {7};
    uint32_t kept = 0;
    assert_int_equal(fnl_scene_set_background(scene, (vec3){0.2f, 0.3f, 0.4f}), FNL_OK);
    for (uint32_t i = 0; i < SQUARES; i++) {
        float level = i == 0 ? 3e4f : i == 1 ? 0 : exp2f(random_range(&random, -6, 1));
        struct scene_material material = test_unlit(1, 1, 1);
        material.base_color = (vec4){level, level * random_float(&random), level * 0.5f, 1};
        test_place(scene, test_quad_mesh(scene, scene_add_material(scene, &material)),
                   i == 0 ? (vec3){0.1f, 0.05f, 0.2f} : (vec3){random_range(&random, -1, 1), random_range(&random, -0.8f, 0.8f), (float)i * 0.01f},
                   i == 0 ? (vec3){sparkle, sparkle * 0.6f, 1} : (vec3){0.25f, 0.2f, 1});
    }
    fnl_renderer *renderer = test_renderer(scene);
    static const uint32_t sizes[][2] = {{75, 53}, {64, 64}, {131, 37}};
    double evs[COUNT_OF(sizes)];
    for (uint32_t s = 0; s < COUNT_OF(sizes); s++) {
        fnl_frame frame = test_frame(FNL_OUTPUT_COLOR | FNL_OUTPUT_RADIANCE | FNL_OUTPUT_NORMAL);
        frame.width = sizes[s][0];
        frame.height = sizes[s][1];
        frame.exposure = FNL_EXPOSURE_AUTO;
        test_render_frame(renderer, &frame);
        fnl_image radiance = test_read(renderer, FNL_OUTPUT_RADIANCE), normals = test_read(renderer, FNL_OUTPUT_NORMAL);
        fnl_frame_stats stats;
        assert_int_equal(fnl_renderer_query_stats(renderer, &stats), FNL_OK);
        /* Every pixel sorted by its level, the slow way to percentiles. */
        struct metered *metered = malloc(sizeof *metered * frame.width * frame.height);
        double total = 0, shown = 0;
        uint32_t count = 0, black = 0, backgrounds = 0;
        for (uint32_t y = 0; y < frame.height; y++)
            for (uint32_t x = 0; x < frame.width; x++) {
                const float *p = test_pixel(&radiance, x, y);
                const double luminance = 0.2126 * (double)p[0] + 0.7152 * (double)p[1] + 0.0722 * (double)p[2];
                const double across = (2 * x + 1.0) / frame.width - 1, down = (2 * y + 1.0) / frame.height - 1;
                const bool surface = test_pixel(&normals, x, y)[3] > 0;
                double weight = floor(1.5 + 3 * fmax(1 - across * across - down * down, 0));
                if (!surface) weight /= 32;
                backgrounds += !surface;
                if (luminance < 1e-6) black++;
                else metered[count++] = (struct metered){log2(luminance), weight, surface}, total += weight, shown += surface ? weight : 0;
            }
        qsort(metered, count, sizeof *metered, compare_metered);
        double sum = 0, weight = 0, seen = 0, seen_shown = 0, brightest = -20, broad = -20;
        for (uint32_t i = 0; i < count; i++) {
            const double inside = fmax(fmin(seen + metered[i].weight, 0.95 * total) - fmax(seen, 0.05 * total), 0);
            sum += inside * metered[i].level;
            weight += inside;
            seen += metered[i].weight;
            if (!metered[i].surface) continue;
            if (seen_shown < 0.99 * shown) brightest = metered[i].level;
            if (seen_shown < 0.9 * shown) broad = metered[i].level;
            seen_shown += metered[i].weight;
        }
        free(metered);
        const double by_most = fmax(sum / weight - log2(1.2 * 0.18), broad - log2(1.2 * 0.5)), by_highlights = brightest - log2(1.2 * 3);
        evs[s] = fmax(by_most, by_highlights);
        kept += by_highlights > by_most;
        print_message("%ux%u: EV %.4f, reference %.4f; %u of %u pixels black\n", frame.width, frame.height,
                      (double)stats.ev, evs[s], black, frame.width * frame.height);
        assert_true(black > 0 && backgrounds > 0 && count > 0);
        assert_true(fabs((double)stats.ev - evs[s]) < 40.0 / 256); /* a bin */
        free_picture(&radiance);
        free_picture(&normals);
    }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
    return kept;
}

static void test_exposure_of_uneven_pictures(void **state) {
    UNUSED(state);
    assert_int_equal(meter_uneven(0.02f), 0);
    assert_int_equal(meter_uneven(0.3f), 0); /* more than a tenth is bright, and decides */
    assert_int_equal(meter_uneven(0.12f), 3);
}

/* The middle of a bin of the histogram, log2: so the mean is exact. */
static double level_of_bin(uint32_t bin) { return -20 + 40.0 / 256 * (bin + 0.5); }

/* A thing before what is around it, each of one level; weights of pixels: a wall is a surface, the background counts a 32nd of that. */
struct before_wall {
    uint32_t thing, around; /* bins */
    float x, y, half;       /* of the thing, in pictures of 64 pixels -1 to 1 */
    bool is_wall;
};

static double metered_by_hand(const struct before_wall *c) {
    double weights[2] = {0}, total = 0, sum = 0, before = 0;
    for (uint32_t i = 0; i < 64 * 64; i++) {
        const double x = (2 * (i % 64) + 1.0) / 64 - 1, y = 1 - (2 * (i / 64) + 1.0) / 64;
        const bool is_thing = fabs(x - (double)c->x) < (double)c->half && fabs(y - (double)c->y) < (double)c->half;
        weights[!is_thing] += floor(1.5 + 3 * fmax(1 - x * x - y * y, 0)) / (is_thing || c->is_wall ? 1 : 32);
    }
    total = weights[0] + weights[1];
    const uint32_t bins[2] = {c->thing, c->around}, first = c->thing > c->around;
    for (uint32_t k = 0; k < 2; k++) { /* the darker first; a twentieth of the weight is left out at each end */
        const uint32_t i = k ^ first;
        sum += fmax(fmin(before + weights[i], 0.95 * total) - fmax(before, 0.05 * total), 0) * level_of_bin(bins[i]);
        before += weights[i];
    }
    double ev = sum / (0.9 * total) - log2(1.2 * 0.18);
    const double shares[2] = {0.99, 0.9}, shown_as[2] = {3, 0.5}, surfaces = c->is_wall ? total : weights[0];
    for (uint32_t k = 0; k < 2; k++) { /* of the surfaces alone */
        const double darker = c->is_wall ? weights[first] : 0, brighter = surfaces - darker;
        const uint32_t bright = c->is_wall ? bins[!first] : c->thing;
        const bool in_darker = darker >= shares[k] * surfaces;
        const double part = in_darker ? shares[k] * surfaces / darker : (shares[k] * surfaces - darker) / brighter;
        ev = fmax(ev, level_of_bin(in_darker ? bins[first] : bright) + 40.0 / 256 * (part - 0.5) - log2(1.2 * shown_as[k]));
    }
    return ev;
}

/* What is metered is the thing, however bright the background is; a wall behind it counts as much as it does. Traced the same. */
static void test_exposure_before_walls(void **state) {
    UNUSED(state);
    static const struct before_wall cases[] = {
        {100, 150, 0, 0, 0.5f, false},     {100, 150, 0, 0, 0.5f, true},      {150, 100, 0, 0, 0.5f, false},     {150, 100, 0, 0, 0.5f, true},
        {110, 140, 0.5f, -0.5f, 0.5f, false}, {110, 140, 0.5f, -0.5f, 0.5f, true}, {140, 110, 0, 0, 0.1875f, false}, {140, 110, 0, 0, 0.0625f, true},
        {100, 150, 0, 0, 0.125f, false},   {120, 128, 0, 0, 0.25f, true},
    };
    double evs[2] = {0};
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        const struct before_wall *c = &cases[i];
        const float levels[2] = {(float)exp2(level_of_bin(c->thing)), (float)exp2(level_of_bin(c->around))};
        fnl_scene *scene = test_scene();
        struct scene_material materials[2];
        for (int k = 0; k < 2; k++) {
            materials[k] = test_unlit(1, 1, 1);
            materials[k].base_color = (vec4){levels[k], levels[k], levels[k], 1};
        }
        if (c->is_wall) test_place(scene, test_quad_mesh(scene, scene_add_material(scene, &materials[1])), (vec3){0, 0, 0}, (vec3){2, 2, 1});
        else assert_int_equal(fnl_scene_set_background(scene, (vec3){levels[1], levels[1], levels[1]}), FNL_OK);
        test_place(scene, test_quad_mesh(scene, scene_add_material(scene, &materials[0])), (vec3){c->x, c->y, 1}, (vec3){c->half, c->half, 1});
        fnl_frame frame = test_frame(FNL_OUTPUT_COLOR);
        frame.exposure = FNL_EXPOSURE_AUTO;
        fnl_renderer *renderer = test_renderer(scene);
        test_render_frame(renderer, &frame);
        fnl_frame_stats stats;
        assert_int_equal(fnl_renderer_query_stats(renderer, &stats), FNL_OK);
        fnl_trace_params params = trace_plain();
        fnl_trace trace;
        params.width = params.height = 64, params.samples = 1, params.camera = frame.camera, params.exposure = FNL_EXPOSURE_AUTO;
        assert_int_equal(fnl_scene_trace(scene, &params, &trace), FNL_OK);
        const double wanted = metered_by_hand(c);
        print_message("case %u: EV %.3f, traced %.3f, by hand %.3f\n", i, (double)stats.ev, (double)trace.ev, wanted);
        if (fabs((double)stats.ev - wanted) > 0.01 || fabs((double)trace.ev - wanted) > 0.01) fail_msg("case %u: EV %.3f, traced %.3f, by hand %.3f", i, (double)stats.ev, (double)trace.ev, wanted);
        if (i < 2) evs[i] = (double)stats.ev;
        fnl_trace_free(&scene->host, &trace);
        fnl_renderer_destroy(&renderer);
        fnl_scene_destroy(&scene);
    }
    assert_true(evs[1] - evs[0] > 3); /* the same picture, whose wall is no background */
}

int main(void) {
    const struct CMUnitTest tests[] = {
        {"ES-1: 50 mixed lights of all shapes match the reference, with every list", test_mixed_lights, NULL, NULL, NULL},
        cmocka_unit_test(test_materials_in_closed_form),
        cmocka_unit_test(test_light_limits),
        cmocka_unit_test(test_directional_light),
        cmocka_unit_test(test_furnace),
        {"MP-14: all lights on all pixels cost pixels times lights", test_naive_cost, NULL, NULL, NULL},
        {"ES-3, MP-14: a prepass leaves one shaded fragment per covered pixel, whatever the order of draws",
         test_naive_fragments, NULL, NULL, NULL},
        cmocka_unit_test(test_tone_mapping),
        cmocka_unit_test(test_automatic_exposure),
        cmocka_unit_test(test_exposure_of_uneven_pictures),
        cmocka_unit_test(test_exposure_before_walls),
    };
    return cmocka_run_group_tests_name("shading", tests, test_group_begin, test_group_end);
}
