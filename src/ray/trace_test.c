/* SPDX-License-Identifier: MIT */
/* Light that is reflected, against what can be computed by hand; and that pictures repeat. */
#include "tests/trace_world.h"

#include "ray/ray_scene.h"
#include "tests/test_memory.h"
#include "tests/frame_plain.h"

/* ---- furnaces: what is seen does not depend on chance ---- */

/* Six walls of a box of 2 m around the origin, seen from inside or from outside. */
static void add_box(fnl_scene *scene, const fnl_material_params *material, bool inside) {
    fnl_mesh_id square = add_square_mesh(scene, add_material(scene, material));
    for (int axis = 0; axis < 3; axis++)
        for (int side = -1; side <= 1; side += 2) {
            quat turn =
                axis == 1 ? quat_identity() : quat_axis_angle(axis == 0 ? vec3_make(0, 0, 1) : vec3_make(1, 0, 0), PI / 2);
            mat4 m = mat4_from_trs(vec3_make(0, 0, 0), turn, vec3_make(1, 1, 1));
            vec3 up = mat4_direction(&m, vec3_make(0, 1, 0));
            float at = (float)side * (axis == 0 ? up.x : axis == 1 ? up.y : up.z);
            vec3 place = {axis == 0 ? (float)side : 0, axis == 1 ? (float)side : 0, axis == 2 ? (float)side : 0};
            if ((at < 0) != inside)
                m = mat4_mul(m,
                             mat4_from_trs(vec3_make(0, 0, 0), quat_axis_angle(vec3_make(1, 0, 0), PI), vec3_make(1, 1, 1)));
            add_instance(scene, square, mat4_mul(mat4_translation(place), m));
        }
}

/* A white surface in a white sky cannot be seen, whatever its shape. */
static void test_white_furnace(void **state) {
    UNUSED(state);
    fnl_scene *scene = world_create(NULL);
    fnl_material_params white = matt(1);
    add_box(scene, &white, false);
    add_square(scene, &white, vec3_make(2, 1, 2),
               vec3_make(0, -1, 0)); /* the box stands on it: corners that reflect one another */
    assert_int_equal(fnl_scene_set_ambient(scene, (fnl_vec3){3, 3, 3}, (fnl_vec3){3, 3, 3}), FNL_OK);
    assert_int_equal(fnl_scene_set_background(scene, (fnl_vec3){3, 3, 3}), FNL_OK);
    fnl_trace_params p = trace_plain();
    p.width = 32, p.height = 24, p.bounces = 60;
    p.camera.position = (vec3){2, 2.2f, 2.6f};
    fnl_trace trace = trace_scene(scene, &p);
    for (uint32_t y = 0; y < p.height; y++)
        for (uint32_t x = 0; x < p.width; x++)
            for (int c = 0; c < 3; c++) assert_float_equal(pixel_at(&trace.radiance, x, y)[c], 3, 1e-5);
    assert_true(trace.ray_count > 32 * 24 + 200);
    fnl_trace_free(NULL, &trace);
    fnl_scene_destroy(&scene);
}

/* ---- glass ---- */

static fnl_mesh_id add_sphere_mesh(fnl_scene *scene, const fnl_material_params *material, float radius, bool inward) {
    enum { RINGS = 24, VERTICES = (RINGS + 1) * (2 * RINGS + 1), TRIANGLES = 4 * RINGS * RINGS };
    static float positions[3 * VERTICES], normals[3 * VERTICES];
    static uint32_t indices[3 * TRIANGLES];
    uint32_t count = 0;
    for (uint32_t i = 0; i < VERTICES; i++) {
        const float theta = PI * (float)(i / (2 * RINGS + 1)) / RINGS, phi = PI * (float)(i % (2 * RINGS + 1)) / RINGS;
        const float n[3] = {sinf(theta) * cosf(phi), cosf(theta), sinf(theta) * sinf(phi)};
        for (int c = 0; c < 3; c++) positions[3 * i + (uint32_t)c] = radius * n[c], normals[3 * i + (uint32_t)c] = inward ? -n[c] : n[c];
    }
    for (uint32_t i = 0; i < RINGS; i++)
        for (uint32_t k = 0; k < 2 * RINGS; k++) {
            const uint32_t a = i * (2 * RINGS + 1) + k, b = a + 2 * RINGS + 1, square[6] = {a, a + 1, b, b, a + 1, b + 1};
            for (int c = 0; c < 6; c++) indices[count++] = square[inward ? 5 - c : c];
        }
    const fnl_mesh_params params = {.vertex_count = VERTICES, .index_count = count, .positions = positions, .normals = normals, .indices = indices, .material = add_material(scene, material)};
    fnl_mesh_id id;
    assert_int_equal(fnl_scene_add_mesh(scene, &params, &id), FNL_OK);
    return id;
}

static fnl_material_params glass(float roughness, float thickness, float dispersion) {
    fnl_material_params m = fnl_material_params_default();
    m.metallic = 0;
    m.roughness = roughness;
    m.transmission.strength = 1;
    m.volume.thickness = thickness;
    m.dispersion = dispersion;
    m.double_sided = thickness == 0;
    return m;
}

static void surround(fnl_scene *scene, float value) {
    float pixels[4 * 2 * 4];
    for (uint32_t i = 0; i < COUNT_OF(pixels); i++) pixels[i] = value;
    const fnl_image image = {4, 2, FNL_PIXEL_FORMAT_RGBA32F, pixels};
    fnl_environment_params params = fnl_environment_params_default();
    params.image = &image;
    params.lights = false;
    assert_int_equal(fnl_scene_set_environment(scene, &params), FNL_OK);
}

/* What surrounds a white ball in light of 1 from everywhere. */
enum glass_kind { GLASS_PANE, GLASS_SHEET, GLASS_SHELL, GLASS_BALL, GLASS_ALONE, GLASS_KINDS };

static fnl_trace trace_glass(enum glass_kind kind, float roughness, float dispersion, uint32_t bounces, uint32_t samples) {
    fnl_scene *scene = world_create(NULL);
    fnl_material_params white = matt(1), around = glass(roughness, kind < GLASS_SHELL ? 0 : 0.05f, dispersion);
    const mat4 here = mat4_translation(vec3_make(0, 0, 0));
    if (kind != GLASS_ALONE) add_instance(scene, add_sphere_mesh(scene, &white, 0.5f, false), here);
    if (kind == GLASS_PANE) add_instance(scene, add_square_mesh(scene, add_material(scene, &around)), mat4_mul(mat4_translation(vec3_make(0, 0, 0.8f)), mat4_from_trs(vec3_make(0, 0, 0), quat_axis_angle(vec3_make(1, 0, 0), PI / 2), vec3_make(2, 2, 2))));
    if (kind != GLASS_PANE) add_instance(scene, add_sphere_mesh(scene, &around, 0.8f, false), here);
    if (kind == GLASS_SHELL) add_instance(scene, add_sphere_mesh(scene, &around, 0.7f, true), here);
    surround(scene, 1);
    fnl_trace_params p = trace_plain();
    p.width = p.height = 8, p.samples = samples, p.bounces = bounces;
    p.camera.position = (vec3){0, 0, 4};
    p.camera.target = (vec3){0, 0, 0};
    p.camera.vertical_fov = 0.4f;
    fnl_trace trace = trace_scene(scene, &p);
    fnl_scene_destroy(&scene);
    return trace;
}

/* Light finds its way through glass in both directions, so nothing can be seen: refracted, reflected in full, scattered or in colors. */
static void test_glass_in_a_white_furnace(void **state) {
    UNUSED(state);
    for (int kind = 0; kind < GLASS_KINDS; kind++)
        for (int rough = 0; rough < 2; rough++) {
            const float dispersion = kind >= GLASS_SHELL ? 3.0f * (float)rough : 0;
            fnl_trace trace = trace_glass((enum glass_kind)kind, 0.3f * (float)rough, dispersion, 64, rough ? 400 : 200);
            const double all = (mean_of(&trace.radiance, 0) + mean_of(&trace.radiance, 1) + mean_of(&trace.radiance, 2)) / 3; /* of dispersion each has a third */
            if (!(fabs(all - 1) < (rough ? 0.02 : 0.01))) fail_msg("kind %d, roughness %g: %g, must be 1", kind, 0.3 * rough, all);
            fnl_trace_free(NULL, &trace);
            /* Without bounces the light that glass reflects is missing, and no more: a ball behind a face is not black. */
            trace = trace_glass((enum glass_kind)kind, 0.3f * (float)rough, dispersion, 0, 128);
            const double direct = mean_of(&trace.radiance, 1);
            if (!(direct > 0.85 && direct < 1.02)) fail_msg("kind %d, roughness %g: %g without bounces", kind, 0.3 * rough, direct);
            fnl_trace_free(NULL, &trace);
        }
}

/* Straight through the middle of a ball of glass of 1.6 m: what is left after that way. */
static void test_glass_absorbs_along_the_way(void **state) {
    UNUSED(state);
    static const float tint[3] = {0.5f, 1, 0.1f};
    fnl_scene *scene = world_create(NULL);
    fnl_material_params ball = glass(0, 0.05f, 0);
    ball.volume.attenuation_distance = 1;
    memcpy(ball.volume.attenuation_color, tint, sizeof tint);
    ball.ior = 1; /* straight on, and nothing is reflected */
    add_instance(scene, add_sphere_mesh(scene, &ball, 0.8f, false), mat4_translation(vec3_make(0, 0, 0)));
    surround(scene, 1);
    fnl_trace_params p = trace_plain();
    p.width = p.height = 2, p.samples = 4;
    p.camera.position = (vec3){0, 0, 4};
    p.camera.target = (vec3){0, 0, 0};
    p.camera.vertical_fov = 0.01f;
    fnl_trace trace = trace_scene(scene, &p);
    for (int c = 0; c < 3; c++) assert_float_equal(mean_of(&trace.radiance, c), pow((double)tint[c], 1.6), 0.02);
    fnl_trace_free(NULL, &trace);
    fnl_scene_destroy(&scene);
}

/* In a closed box whose walls glow and reflect a part r, N bounces give e (1 + r + … + r^(N + 1)). */
static void test_energy_in_a_closed_box(void **state) {
    UNUSED(state);
    fnl_scene *scene = world_create(NULL);
    fnl_material_params wall = matt(0.5f);
    for (int i = 0; i < 3; i++) wall.emissive[i] = 2;
    add_box(scene, &wall, true);
    fnl_trace_params p = trace_plain();
    p.width = p.height = 16;
    p.camera.position = (vec3){0.3f, 0.2f, 0.9f};
    p.light_sampling = false; /* then every path carries the same light */
    for (p.bounces = 1; p.bounces < 6; p.bounces++) {
        double wanted = 2 * (1 - pow(0.5, p.bounces + 2)) / 0.5;
        fnl_trace trace = trace_scene(scene, &p);
        for (uint32_t y = 0; y < p.height; y++)
            for (uint32_t x = 0; x < p.width; x++)
                if (fabs((double)pixel_at(&trace.radiance, x, y)[1] - wanted) > 1e-5)
                    fail_msg("%u bounces: %g at %u, %u, must be %g", p.bounces, (double)pixel_at(&trace.radiance, x, y)[1],
                             x, y, wanted);
        fnl_trace_free(NULL, &trace);
    }
    /* Ending paths by chance keeps the mean. */
    p.bounces = 60, p.samples = 400, p.russian_roulette = p.light_sampling = true;
    p.width = p.height = 8;
    fnl_trace trace = trace_scene(scene, &p);
    assert_float_equal(mean_of(&trace.radiance, 1), 4, 0.03);
    uint64_t rays = trace.ray_count;
    fnl_trace_free(NULL, &trace);
    assert_true(rays < 8ull * 8 * 400 * 24); /* instead of 123 each */
    fnl_scene_destroy(&scene);
}

/* A lamp of 2 x 2 m, 1 m above a matt floor: the form factor of a rectangle over one of its corners is known (four of them here). */
static double corner_factor(double a, double b) { /* sides over the height */
    double x = sqrt(1 + a * a), y = sqrt(1 + b * b);
    return (a / x * atan(b / x) + b / y * atan(a / y)) / (2 * DPI);
}

static void test_area_light_has_its_form_factor(void **state) {
    UNUSED(state);
    fnl_scene *scene = world_create(NULL);
    fnl_material_params floor = matt(0.6f), lamp = matt(0);
    for (int i = 0; i < 3; i++) lamp.emissive[i] = 10;
    lamp.double_sided = true;
    add_square(scene, &floor, vec3_make(5, 1, 5), vec3_make(0, 0, 0));
    add_square(scene, &lamp, vec3_make(1, 1, 1), vec3_make(0, 1, 0));
    static const struct {
        float x, z;
        double factor;
    } places[] = {{0, 0, 0}, {1, 1, 0}, {3, 0, 0}};
    for (uint32_t i = 0; i < COUNT_OF(places); i++) {
        double x = (double)places[i].x, z = (double)places[i].z;
        /* Signed sums of the rectangles that have a corner above the point. */
        double factor = corner_factor(1 - x, 1 - z) + corner_factor(1 - x, 1 + z) + corner_factor(1 + x, 1 - z) +
                        corner_factor(1 + x, 1 + z);
        fnl_trace_params p = look_down(vec3_make(places[i].x, 0, places[i].z), 0.01f, 0.5f, 8);
        for (int sampled = 0; sampled < 2; sampled++) {
            p.samples = sampled ? 64 : 1600, p.bounces = 1, p.light_sampling = sampled;
            fnl_trace trace = trace_scene(scene, &p);
            double wanted = 0.6 * 10 * factor, got = mean_of(&trace.radiance, 0);
            if (fabs(got / wanted - 1) > (sampled ? 0.01 : 0.02)) fail_msg("at %g, %g: %g, must be %g", x, z, got, wanted);
            fnl_trace_free(NULL, &trace);
        }
    }
    fnl_scene_destroy(&scene);
}

/* What a red wall sends on to the floor, against the integral over the wall. */
static void test_one_bounce_off_a_red_wall(void **state) {
    UNUSED(state);
    enum { STEPS = 200 };
    fnl_scene *scene = world_create(NULL);
    fnl_material_params floor = matt(0.8f), red = matt(0);
    red.base_color[0] = 0.5f;
    add_square(scene, &floor, vec3_make(5, 1, 5), vec3_make(0, 0, 0));
    fnl_mesh_id wall = add_square_mesh(scene, add_material(scene, &red)); /* x = 2, 0 < y < 2, -1 < z < 1 */
    add_instance(scene, wall,
                 mat4_from_trs(vec3_make(2, 1, 0), quat_axis_angle(vec3_make(0, 0, 1), PI / 2), vec3_make(1, 1, 1)));
    const dvec3 light = {0, 1.5, 0}, at = {0.5, 0, 0.25};
    add_point_light(scene, (vec3){0, 1.5f, 0}, 10);
    double wanted = 0;
    for (int i = 0; i < STEPS; i++)
        for (int k = 0; k < STEPS; k++) {
            dvec3 p = {2, 2 * (i + 0.5) / STEPS, 2 * (k + 0.5) / STEPS - 1}, to_light = dvec3_sub(light, p),
                  to_floor = dvec3_sub(at, p);
            double l2 = dvec3_dot(to_light, to_light), f2 = dvec3_dot(to_floor, to_floor), area = 4.0 / (STEPS * STEPS);
            double sent = 0.5 / DPI * 10 * (-to_light.x / sqrt(l2)) / l2;
            wanted += 0.8 / DPI * sent * (-to_floor.x / sqrt(f2)) * (-to_floor.y / sqrt(f2)) / f2 * area;
        }
    fnl_trace_params p = look_down((vec3){0.5f, 0, 0.25f}, 0.01f, 0.5f, 8);
    p.samples = 1600;
    fnl_trace direct = trace_scene(scene, &p);
    p.bounces = 1;
    fnl_trace all = trace_scene(scene, &p);
    double got = mean_of(&all.radiance, 0) - mean_of(&direct.radiance, 0);
    if (fabs(got / wanted - 1) > 0.02) fail_msg("the wall sends %g, must be %g", got, wanted);
    assert_float_equal(mean_of(&all.radiance, 1), mean_of(&direct.radiance, 1), 1e-5); /* no green */
    fnl_trace_free(NULL, &direct);
    fnl_trace_free(NULL, &all);
    fnl_scene_destroy(&scene);
}

/* ---- rays that are sent to lights ---- */

enum { AROUND_WIDTH = 64, AROUND_HEIGHT = 32 };

/* A dim panorama with a square of bright texels, turned by `rotation`. */
static void surround_by_lamp(fnl_scene *scene, uint32_t column, uint32_t row, uint32_t side, float bright, float dim, float rotation) {
    static float pixels[4 * AROUND_WIDTH * AROUND_HEIGHT];
    for (uint32_t i = 0; i < AROUND_WIDTH * AROUND_HEIGHT; i++) {
        const uint32_t x = i % AROUND_WIDTH - column, y = i / AROUND_WIDTH - row;
        for (uint32_t c = 0; c < 4; c++) pixels[4 * i + c] = x < side && y < side ? bright : dim;
    }
    const fnl_image image = {AROUND_WIDTH, AROUND_HEIGHT, FNL_PIXEL_FORMAT_RGBA32F, pixels};
    fnl_environment_params params = fnl_environment_params_default();
    params.image = &image;
    params.lights = false;
    params.rotation = rotation;
    assert_int_equal(fnl_scene_set_environment(scene, &params), FNL_OK);
}

/* The same light from everywhere needs no rays to lights, and every path carries all of it. */
static void test_white_furnace_in_an_environment(void **state) {
    UNUSED(state);
    fnl_scene *scene = world_create(NULL);
    fnl_material_params white = matt(1);
    add_box(scene, &white, false);
    add_square(scene, &white, vec3_make(2, 1, 2), vec3_make(0, -1, 0));
    surround(scene, 3);
    fnl_trace_params p = trace_plain();
    p.width = 32, p.height = 24, p.bounces = 60;
    p.camera.position = (vec3){2, 2.2f, 2.6f};
    fnl_trace trace = trace_scene(scene, &p);
    for (uint32_t y = 0; y < p.height; y++)
        for (uint32_t x = 0; x < p.width; x++)
            for (int c = 0; c < 3; c++) assert_float_equal(pixel_at(&trace.radiance, x, y)[c], 3, 1e-5);
    fnl_trace_free(NULL, &trace);
    fnl_scene_destroy(&scene);
}

/* Light that grows evenly from below to above: a matt floor gets its mean, weighed by the cosine. */
static void test_sky_and_ground_light_a_floor(void **state) {
    UNUSED(state);
    fnl_scene *scene = world_create(NULL);
    fnl_material_params floor = matt(0.5f);
    add_square(scene, &floor, vec3_make(5, 1, 5), vec3_make(0, 0, 0));
    assert_int_equal(fnl_scene_set_ambient(scene, (fnl_vec3){6, 6, 6}, (fnl_vec3){1, 1, 1}), FNL_OK);
    fnl_trace_params p = look_down((vec3){0, 0, 0}, 0.01f, 0.5f, 4);
    p.samples = 256, p.bounces = 1;
    fnl_trace trace = trace_scene(scene, &p);
    for (uint32_t i = 0; i < 16; i++) assert_float_equal(pixel_at(&trace.radiance, i % 4, i / 4)[1], 0.5 * (1 + 5 * 5 / 6.0), 0.002);
    fnl_trace_free(NULL, &trace);
    fnl_scene_destroy(&scene);
}

/* Two squares, each with a lamp of its own above both: each is lit by one of them, a third by none, and a lamp for all adds to each. */
static void test_lights_heed_masks(void **state) {
    UNUSED(state);
    fnl_scene *scene = world_create(NULL);
    fnl_material_params floor = matt(0.5f);
    for (uint32_t i = 0; i < 3; i++) {
        add_square(scene, &floor, vec3_make(0.4f, 1, 0.4f), vec3_make((float)i, 0, 0));
        fnl_entity_info info;
        assert_int_equal(fnl_scene_query_entity(scene, FNL_ENTITY_INSTANCE, i, &info), FNL_OK);
        assert_int_equal(fnl_scene_set_instance_light_mask(scene, info.id.instance, 1u << i), FNL_OK);
    }
    static const uint32_t masks[] = {1, 2, 255};
    static const float lux[] = {1, 4, 16};
    for (uint32_t i = 0; i < 3; i++) {
        fnl_light_params light = fnl_light_params_default();
        fnl_light_id id;
        light.kind = FNL_LIGHT_DIRECTIONAL;
        light.direction = (fnl_vec3){0, -1, 0};
        light.intensity = lux[i];
        light.mask = masks[i];
        assert_int_equal(fnl_scene_add_light(scene, &light, &id), FNL_OK);
    }
    static const double sums[] = {17, 20, 16};
    for (uint32_t i = 0; i < 3; i++) {
        fnl_trace_params p = look_down(vec3_make((float)i, 0, 0), 0.1f, 0.5f, 2);
        p.samples = 1, p.bounces = 0;
        fnl_trace trace = trace_scene(scene, &p);
        assert_float_equal(mean_of(&trace.radiance, 0), sums[i] * 0.5 * 0.96 / DPI, sums[i] * 0.02);
        fnl_trace_free(NULL, &trace);
    }
    fnl_scene_destroy(&scene);
}

/* One bright texel of 2048: what a floor gets of it, by the integral over the four cells into which it is interpolated. Few paths would ever meet it. */
static void test_one_bright_texel_needs_few_samples(void **state) {
    UNUSED(state);
    enum { STEPS = 400, COLUMN = 11, ROW = 6 };
    fnl_scene *scene = world_create(NULL);
    fnl_material_params floor = matt(0.5f);
    add_square(scene, &floor, vec3_make(5, 1, 5), vec3_make(0, 0, 0));
    surround_by_lamp(scene, COLUMN, ROW, 1, 5000, 0, 0.4f);
    double wanted = 0;
    for (int i = 0; i < STEPS; i++) { /* rows: the turn about the axis changes nothing */
        const double off = 2 * (i + 0.5) / STEPS - 1, latitude = DPI * (ROW + 0.5 + off) / AROUND_HEIGHT;
        wanted += 0.5 / DPI * 5000 * (1 - fabs(off)) * (2 * DPI / AROUND_WIDTH) * cos(latitude) * sin(latitude) * (2.0 / STEPS) * (DPI / AROUND_HEIGHT);
    }
    fnl_trace_params p = look_down((vec3){0, 0, 0}, 0.01f, 0.5f, 4);
    p.samples = 64;
    fnl_trace trace = trace_scene(scene, &p);
    for (uint32_t i = 0; i < 16; i++) {
        const double got = (double)pixel_at(&trace.radiance, i % 4, i / 4)[0];
        if (!(fabs(got / wanted - 1) < 0.05)) fail_msg("pixel %u: %g, must be %g", i, got, wanted);
    }
    if (!(fabs(mean_of(&trace.radiance, 0) / wanted - 1) < 0.01)) fail_msg("%g, must be %g", mean_of(&trace.radiance, 0), wanted);
    fnl_trace_free(NULL, &trace);
    fnl_scene_destroy(&scene);
}

/* What stands between a floor and its light. */
enum between { BETWEEN_NOTHING, BETWEEN_HALF, BETWEEN_BLENDED, BETWEEN_CUTOUT, BETWEEN_SHEET, BETWEEN_GLASS, BETWEEN_UNSHADOWED, BETWEEN_KINDS };

static void add_between(fnl_scene *scene, enum between kind) {
    fnl_material_params m = matt(0.3f);
    const bool sheet = kind == BETWEEN_SHEET;
    if (kind == BETWEEN_NOTHING) return;
    if (sheet || kind == BETWEEN_GLASS) m = glass(0.2f, sheet ? 0 : 0.05f, 0);
    if (kind == BETWEEN_BLENDED) m.alpha_mode = FNL_ALPHA_BLEND, m.base_color[3] = 0.4f;
    if (kind == BETWEEN_UNSHADOWED) m.casts_shadows = false;
    if (kind == BETWEEN_CUTOUT) {
        static uint8_t texels[16] = {255, 255, 255, 255, 255, 255, 255, 0, 255, 255, 255, 0, 255, 255, 255, 255};
        const fnl_image picture = {2, 2, FNL_PIXEL_FORMAT_RGBA8, texels};
        m.alpha_mode = FNL_ALPHA_MASK;
        assert_int_equal(fnl_scene_add_image(scene, &picture, true, &m.base_color_image), FNL_OK);
    }
    if (kind == BETWEEN_GLASS) {
        add_instance(scene, add_sphere_mesh(scene, &m, 0.3f, false), mat4_translation(vec3_make(0.3f, 0.6f, 0)));
        return;
    }
    m.double_sided = true;
    add_square(scene, &m, vec3_make(0.4f, 1, 0.4f), vec3_make(kind == BETWEEN_HALF || kind == BETWEEN_UNSHADOWED ? 0.5f : 0, 0.6f, 0));
}

/* A lamp of triangles, or bright texels: light that rays are sent to and light that paths meet are the same, and none counts twice. */
static void test_light_sampling_keeps_the_mean(void **state) {
    UNUSED(state);
    for (int lamp = 0; lamp < 2; lamp++)
        for (int kind = 0; kind < BETWEEN_KINDS; kind++)
            for (int surface = 0; surface < (kind == BETWEEN_NOTHING ? 4 : 1); surface++) { /* matt, gloss, mirror, paper */
                fnl_scene *scene = world_create(NULL);
                fnl_material_params floor = matt(0.6f), lit = matt(0);
                for (int i = 0; i < 3; i++) lit.emissive[i] = 40;
                lit.emissive[1] = 5;
                if (surface == 1) floor = fnl_material_params_default(), floor.metallic = 0, floor.roughness = 0.4f, floor.base_color[0] = 0.4f;
                if (surface == 2) floor = fnl_material_params_default(), floor.metallic = 1, floor.roughness = 0.15f;
                if (surface == 3) floor.diffuse_transmission = (fnl_diffuse_transmission_params){.strength = 0.7f, .color = {1, 0.9f, 0.8f}};
                add_square(scene, &floor, vec3_make(2, 1, 2), vec3_make(0, 0, 0));
                add_between(scene, (enum between)kind);
                if (lamp) add_instance(scene, add_square_mesh(scene, add_material(scene, &lit)), mat4_from_trs(vec3_make(0.2f, surface == 3 ? -1.2f : 1.2f, 0.1f), quat_axis_angle(vec3_make(1, 0, 0), 0.3f), vec3_make(0.3f, 1, 0.2f)));
                else surround_by_lamp(scene, 20, surface == 3 ? 26 : 1, 5, 30, 0.3f, 0.8f);
                fnl_trace_params p = look_down((vec3){0, 0, 0}, 0.4f, 0.5f, 8);
                p.bounces = lamp;
                p.samples = 1024, p.light_sampling = false;
                const double most = kind == BETWEEN_SHEET || kind == BETWEEN_GLASS ? 0.09 : 0.03; /* only paths go through glass */
                fnl_trace met = trace_scene(scene, &p);
                p.samples = 256, p.light_sampling = true;
                fnl_trace sent = trace_scene(scene, &p);
                for (int c = 0; c < 2; c++) {
                    const double a = mean_of(&met.radiance, c), b = mean_of(&sent.radiance, c);
                    if (!(a > 0 && fabs(b / a - 1) < most)) fail_msg("lamp %d, between %d, surface %d: %g with rays to lights, %g without", lamp, kind, surface, b, a);
                }
                fnl_trace_free(NULL, &met);
                fnl_trace_free(NULL, &sent);
                fnl_scene_destroy(&scene);
            }
}

/* ---- pictures ---- */

/* A floor of squares seen from the side: samples of a pixel have its parts of the texture, so they see what the pixels of a larger picture see. */
static void test_samples_are_as_sharp_as_a_larger_picture(void **state) {
    UNUSED(state);
    enum { SIDE = 256, WIDTH = 40, HEIGHT = 20, FINER = 8 };
    static uint8_t texels[SIDE * SIDE * 4];
    for (int i = 0; i < SIDE * SIDE * 4; i++) texels[i] = i % 4 == 3 || (i / 4 % SIDE / 8 + i / 4 / SIDE / 8) % 2 ? 255 : 0;
    const fnl_image squares = {SIDE, SIDE, FNL_PIXEL_FORMAT_RGBA8, texels};
    fnl_scene *scene = world_create(NULL);
    fnl_material_params floor = matt(1);
    assert_int_equal(fnl_scene_add_image(scene, &squares, true, &floor.base_color_image), FNL_OK);
    add_square(scene, &floor, vec3_make(1, 1, 1), vec3_make(0, 0, 0));
    assert_int_equal(fnl_scene_set_ambient(scene, (fnl_vec3){1, 1, 1}, (fnl_vec3){1, 1, 1}), FNL_OK);
    fnl_trace_params p = trace_plain();
    p.width = WIDTH, p.height = HEIGHT, p.samples = FINER * FINER;
    p.camera.position = (vec3){0, 0.3f, 0.9f};
    p.camera.target = (vec3){0, 0, 0.1f};
    p.camera.vertical_fov = 0.35f;
    fnl_trace small = trace_scene(scene, &p);
    p.width *= FINER, p.height *= FINER, p.samples = 1;
    fnl_trace large = trace_scene(scene, &p);
    double error = 0, contrast = 0;
    for (uint32_t y = 0; y < HEIGHT; y++)
        for (uint32_t x = 0; x < WIDTH; x++) {
            double mean = 0;
            for (uint32_t k = 0; k < FINER * FINER; k++) mean += (double)pixel_at(&large.radiance, FINER * x + k % FINER, FINER * y + k / FINER)[0] / (FINER * FINER);
            error += pow((double)pixel_at(&small.radiance, x, y)[0] - mean, 2) / (WIDTH * HEIGHT);
            contrast += pow(mean - 0.5, 2) / (WIDTH * HEIGHT);
        }
    if (!(error < 0.004 * contrast)) fail_msg("samples differ from the larger picture by %g of its contrast", error / contrast);
    fnl_trace_free(NULL, &small);
    fnl_trace_free(NULL, &large);
    fnl_scene_destroy(&scene);
}

static fnl_trace trace_hall(uint32_t threads, uint64_t seed) {
    fnl_host host = fnl_host_default();
    host.thread_count = threads;
    fnl_scene *scene = NULL;
    assert_int_equal(scene_load_plain(&host, "builtin:glass?lights=12", NULL, &scene), FNL_OK);
    fnl_trace_params p = trace_plain();
    p.width = 67, p.height = 35, p.samples = 2, p.bounces = 2, p.visibility = true, p.light_radius = 0.1f, p.seed = seed;
    assert_int_equal(fnl_scene_query_framing_camera(scene, 67 / 35.0f, &p.camera), FNL_OK);
    fnl_trace trace = trace_scene(scene, &p);
    fnl_scene_destroy(&scene);
    return trace;
}

static void test_threads_do_not_change_a_byte(void **state) {
    UNUSED(state);
    fnl_trace one = trace_hall(1, 1), four = trace_hall(4, 1), other = trace_hall(4, 2);
    const size_t count = (size_t)67 * 35;
    assert_memory_equal(one.radiance.pixels, four.radiance.pixels, count * 16);
    assert_memory_equal(one.visibility.pixels, four.visibility.pixels, count * 16);
    assert_memory_equal(one.color.pixels, four.color.pixels, count * 4);
    assert_true(one.ray_count == four.ray_count && one.ray_count > count * 2);
    assert_true(memcmp(one.radiance.pixels, other.radiance.pixels, count * 16) != 0);
    fnl_trace_free(NULL, &one);
    fnl_trace_free(NULL, &four);
    fnl_trace_free(NULL, &other);
}

static bool stop_after(void *user, uint64_t done, uint64_t total) {
    assert_int_equal(total, 2 * 4 * 3);
    assert_true(done <= total);
    return done < *(uint64_t *)user;
}

/* What was traced is there, the rest is transparent. */
static void test_ended_early(void **state) {
    UNUSED(state);
    fnl_host host = fnl_host_default();
    host.thread_count = 1;
    fnl_scene *scene = world_create(&host);
    assert_int_equal(fnl_scene_set_background(scene, (fnl_vec3){5, 6, 7}), FNL_OK);
    fnl_trace_params p = trace_plain();
    uint64_t limit = 4;
    p.width = 64, p.height = 48, p.samples = 2, p.progress = stop_after, p.user = &limit;
    fnl_trace trace = trace_scene(scene, &p);
    assert_false(trace.complete);
    for (uint32_t y = 0; y < p.height; y++) {
        const bool done = y < 16; /* a row of four tiles */
        assert_float_equal(pixel_at(&trace.radiance, 9, y)[2], done ? 7 : 0, 0);
        assert_float_equal(pixel_at(&trace.radiance, 9, y)[3], done ? 1 : 0, 0);
        assert_int_equal(((uint8_t *)trace.color.pixels)[(y * p.width + 9) * 4 + 3], done ? 255 : 0);
    }
    fnl_trace_free(&host, &trace);
    limit = 14; /* in the second sample: the mean is that of those that a pixel has */
    trace = trace_scene(scene, &p);
    assert_false(trace.complete);
    for (uint32_t y = 0; y < p.height; y++) assert_float_equal(pixel_at(&trace.radiance, 9, y)[0], 5, 0);
    fnl_trace_free(&host, &trace);
    limit = UINT64_MAX;
    trace = trace_scene(scene, &p);
    assert_true(trace.complete);
    fnl_trace_free(&host, &trace);
    fnl_scene_destroy(&scene);
}

/* Whichever allocation fails: an error, nothing is left behind, and sizes are those that were asked for. */
static void count_errors(void *user, fnl_log_level level, const char *line) {
    UNUSED(line);
    if (level == FNL_LOG_ERROR) atomic_fetch_add(&((struct test_memory *)user)->errors, 1);
}

static void test_memory_that_runs_out(void **state) {
    UNUSED(state);
    struct test_memory memory = {0};
    fnl_host host = fnl_host_default();
    host.user = &memory;
    host.reallocate = test_memory_reallocate;
    host.log = count_errors;
    host.thread_count = 1;
    fnl_scene *scene = world_create(&host);
    fnl_material_params glass = matt(1);
    glass.alpha_mode = FNL_ALPHA_BLEND;
    glass.base_color[3] = 0.5f;
    static uint8_t texels[16] = {255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 9, 9, 9, 255};
    fnl_image picture = {2, 2, FNL_PIXEL_FORMAT_RGBA8, texels};
    assert_int_equal(fnl_scene_add_image(scene, &picture, true, &glass.base_color_image), FNL_OK);
    add_square(scene, &glass, vec3_make(1, 1, 1), vec3_make(0, 0, 0));
    add_point_light(scene, vec3_make(0, 1, 0), 1);
    fnl_trace_params p = look_down(vec3_make(0, 0, 0), 1, 2, 16);
    p.visibility = true;
    long long before = atomic_load(&memory.live_bytes), failures = 0;
    fnl_result result = FNL_ERROR_MEMORY;
    for (long long n = 1; result == FNL_ERROR_MEMORY; n++) {
        fnl_trace trace;
        atomic_store(&memory.allocations, 0);
        atomic_store(&memory.fail_at, n);
        result = fnl_scene_trace(scene, &p, &trace);
        atomic_store(&memory.fail_at, 0);
        if (result == FNL_OK) fnl_trace_free(&host, &trace);
        failures += result == FNL_ERROR_MEMORY;
        assert_true(result == FNL_OK || atomic_exchange(&memory.errors, 0) > 0);
        assert_true(atomic_load(&memory.live_bytes) == before);
    }
    assert_int_equal(result, FNL_OK);
    assert_true(failures > 10);
    fnl_scene_destroy(&scene);
    assert_true(atomic_load(&memory.live_bytes) == 0 && atomic_load(&memory.wrong_sizes) == 0);
}

static void test_empty_scene_is_background(void **state) {
    UNUSED(state);
    fnl_scene *scene = world_create(NULL);
    assert_int_equal(fnl_scene_set_background(scene, (fnl_vec3){1, 2, 3}), FNL_OK);
    fnl_trace_params p = trace_plain();
    p.width = 5, p.height = 3, p.samples = 3, p.visibility = true;
    fnl_trace trace = trace_scene(scene, &p);
    assert_float_equal(pixel_at(&trace.radiance, 4, 2)[1], 2, 0);
    assert_float_equal(pixel_at(&trace.visibility, 4, 2)[0], 1, 0);
    assert_float_equal(pixel_at(&trace.visibility, 4, 2)[1], 0, 0);
    assert_true(trace.complete && trace.ray_count == 5 * 3 * 3);
    fnl_trace_free(NULL, &trace);
    fnl_scene_destroy(&scene);
}

/* ---- lights ---- */

/* The tree finds every light that reaches a point, in order, and few others. */
static void test_lights_that_reach_a_point_are_found(void **state) {
    UNUSED(state);
    fnl_host host = host_resolve(NULL);
    fnl_scene *scene = world_create(NULL);
    fnl_scatter_params scatter = fnl_scatter_params_default();
    struct jobs *jobs;
    struct ray_scene *rays;
    struct ray_walk walk = {0};
    const fnl_material_params white = matt(1);
    add_square(scene, &white, vec3_make(20, 1, 20), vec3_make(0, 0, 0));
    add_square(scene, &white, vec3_make(20, 1, 20), vec3_make(0, 10, 0));
    fnl_light_params sun = fnl_light_params_default();
    fnl_light_id id;
    sun.kind = FNL_LIGHT_DIRECTIONAL;
    scatter.count = 500;
    for (int i = 0; i < FNL_LIGHT_KIND_COUNT; i++) scatter.shares[i] = i != FNL_LIGHT_DIRECTIONAL;
    assert_int_equal(fnl_scene_scatter_light_shapes(scene, &scatter), FNL_OK);
    assert_int_equal(fnl_scene_add_light(scene, &sun, &id), FNL_OK);
    assert_int_equal(jobs_create(&host, &jobs), FNL_OK);
    assert_int_equal(ray_scene_create(scene, FNL_ENERGY_GLTF, jobs, &rays), FNL_OK);
    struct random_state random = {1};
    uint64_t found = 0, reaching = 0;
    for (int k = 0; k < 500; k++) {
        dvec3 p = {(double)random_range(&random, -25, 25), (double)random_range(&random, -2, 12),
                   (double)random_range(&random, -25, 25)};
        ray_scene_find_lights(rays, p, &walk);
        assert_false(walk.failed);
        found += walk.lights.count;
        assert_int_equal(walk.lights.data[0], 0); /* the sun */
        for (uint32_t i = 0, at = 0; i < 501; i++) {
            dvec3 to_light;
            double distance;
            const bool listed = at < walk.lights.count && walk.lights.data[at] == i,
                       reaches = ray_light_strength(ray_scene_light(rays, i), p, &to_light, &distance) > 0;
            if (reaches && !listed) fail_msg("light %u reaches %g, %g, %g and is not found", i, p.x, p.y, p.z);
            reaching += reaches;
            at += listed;
            if (i == 500) assert_int_equal(at, walk.lights.count); /* ascending, none twice */
        }
    }
    if (!(reaching > 1000 && found < 500 * 40)) /* of 500 * 501 */
        fail_msg("%llu are found, %llu reach", (unsigned long long)found, (unsigned long long)reaching);
    array_free(&host, &walk.lights);
    ray_scene_destroy(&rays);
    jobs_destroy(&jobs);
    fnl_scene_destroy(&scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_white_furnace),
        cmocka_unit_test(test_glass_in_a_white_furnace),
        cmocka_unit_test(test_glass_absorbs_along_the_way),
        cmocka_unit_test(test_energy_in_a_closed_box),
        cmocka_unit_test(test_area_light_has_its_form_factor),
        cmocka_unit_test(test_white_furnace_in_an_environment),
        cmocka_unit_test(test_sky_and_ground_light_a_floor),
        cmocka_unit_test(test_lights_heed_masks),
        cmocka_unit_test(test_one_bright_texel_needs_few_samples),
        cmocka_unit_test(test_light_sampling_keeps_the_mean),
        cmocka_unit_test(test_samples_are_as_sharp_as_a_larger_picture),
        cmocka_unit_test(test_threads_do_not_change_a_byte),
        cmocka_unit_test(test_ended_early),
        cmocka_unit_test(test_memory_that_runs_out),
        cmocka_unit_test(test_one_bounce_off_a_red_wall),
        cmocka_unit_test(test_empty_scene_is_background),
        cmocka_unit_test(test_lights_that_reach_a_point_are_found),
    };
    return cmocka_run_group_tests_name("trace", tests, NULL, NULL);
}
