/* SPDX-License-Identifier: MIT */
/** The view `overshading` against squares of 2x2 pixels counted on the CPU, over meshes of ever smaller triangles. */
#include "tests/render_test.h"

enum { SIZE = 128, AREA = 96, STEPS = 256, MESHES = 3, LIGHTS = 3, LEGEND_TOP = SIZE - 14, NOBODY = -1, UNSURE = -2 };

/* Positions in 1/256 pixel, which every device's rasteriser holds exactly. */
struct corner {
    int x, y;
};

/* A square of `side` x `side` cells of two triangles; corners are moved a little, so that edges miss the middles of pixels. */
struct mesh {
    uint32_t vertex_count, index_count;
    struct corner *corners;
    uint32_t *indices;
};

static struct mesh make_mesh(fnl_scene *scene, int first, int size, uint32_t side) {
    struct mesh m = {(side + 1) * (side + 1), side * side * 6, NULL, NULL};
    struct random_state random = {side};
    m.corners = ARENA_ARRAY(&scene->arena, struct corner, m.vertex_count);
    m.indices = ARENA_ARRAY(&scene->arena, uint32_t, m.index_count);
    uint32_t at = 0;
    for (uint32_t y = 0; y <= side; y++)
        for (uint32_t x = 0; x <= side; x++) {
            uint32_t v = y * (side + 1) + x;
            m.corners[v].x = first + (int)(x * (uint32_t)size / side) + (int)random_range(&random, -30, 30);
            m.corners[v].y = first + (int)(y * (uint32_t)size / side) + (int)random_range(&random, -30, 30);
            if (x == side || y == side) continue;
            uint32_t cell[6] = {v, v + side + 1, v + side + 2, v, v + side + 2, v + 1};
            memcpy(m.indices + at, cell, sizeof cell);
            at += 6;
        }
    return m;
}

/* Pixel (x, y) is seen at world (x - SIZE / 2, SIZE / 2 - y). */
static void place_mesh(fnl_scene *scene, const struct mesh *m, float z) {
    vec3 *positions = ARENA_ARRAY(&scene->arena, vec3, m->vertex_count),
         *normals = ARENA_ARRAY(&scene->arena, vec3, m->vertex_count);
    vec2 *uv = ARENA_ARRAY(&scene->arena, vec2, m->vertex_count);
    for (uint32_t i = 0; i < m->vertex_count; i++) {
        positions[i] = (vec3){(float)m->corners[i].x / STEPS - SIZE / 2, SIZE / 2 - (float)m->corners[i].y / STEPS, z};
        normals[i] = (vec3){0, 0, 1};
        uv[i] = (vec2){0, 0};
    }
    struct scene_material material = scene_material_default();
    struct scene_primitive primitive = {.material = scene_add_material(scene, &material),
                                        .vertex_count = m->vertex_count,
                                        .index_count = m->index_count,
                                        .indices = m->indices,
                                        .positions = positions,
                                        .normals = normals,
                                        .uv = {uv, NULL}};
    assert_int_equal(mesh_complete(&scene->arena, &primitive), FNL_OK);
    mat4 matrix = mat4_identity();
    scene_add_node(scene, "", SCENE_NONE, &matrix, scene_add_mesh(scene, "", &primitive, 1));
}

/* Paints the numbers of triangles, from `number` on, over those that were there; pixels whose middle lies on an edge are unsure. */
static void paint(const struct mesh *m, int number, int owners[SIZE][SIZE]) {
    for (uint32_t t = 0; t < m->index_count; t += 3) {
        struct corner c[3];
        int low_x = INT32_MAX, low_y = INT32_MAX, high_x = 0, high_y = 0;
        for (int k = 0; k < 3; k++) {
            c[k] = m->corners[m->indices[t + (uint32_t)k]];
            low_x = MIN(low_x, c[k].x / STEPS);
            low_y = MIN(low_y, c[k].y / STEPS);
            high_x = MAX(high_x, c[k].x / STEPS);
            high_y = MAX(high_y, c[k].y / STEPS);
        }
        for (int y = low_y; y <= high_y; y++)
            for (int x = low_x; x <= high_x; x++) {
                int inside = 0, touching = 0;
                for (int k = 0; k < 3; k++) {
                    struct corner a = c[k], b = c[(k + 1) % 3];
                    int64_t side = (int64_t)(b.x - a.x) * (y * STEPS + STEPS / 2 - a.y) -
                                   (int64_t)(b.y - a.y) * (x * STEPS + STEPS / 2 - a.x);
                    inside += side < 0;
                    touching += side == 0;
                }
                if (inside == 3)
                    owners[y][x] = number + (int)(t / 3);
                else if (inside + touching == 3)
                    owners[y][x] = UNSURE;
            }
    }
}

/* Invocations at a pixel: four for each triangle that shows in its square, spread over the pixels where it shows. 0: nothing, -1: unsure. */
static double wanted(int owners[SIZE][SIZE], int x, int y) {
    int same = 0;
    for (int k = 0; k < 4; k++) {
        int other = owners[(y & ~1) + k / 2][(x & ~1) + k % 2];
        if (other == UNSURE) return -1;
        same += other == owners[y][x];
    }
    return owners[y][x] == NOBODY ? 0 : 4.0 / same;
}

/* The colour scale of counts at 1, 4/3, 2 and 4; docs/techniques/debug-views.md. */
static double invocations(const uint8_t *p) {
    static const double counts[] = {0, 1, 4.0 / 3, 2, 4};
    for (uint32_t i = 0; i < COUNT_OF(counts); i++) {
        static const vec3 stops[5] = {{68, 1, 84}, {71, 45, 123}, {59, 82, 139}, {44, 114, 142}, {33, 144, 140}};
        float at = (float)(log2(counts[i]) + 1) / 9 * 8;
        vec3 color = i == 0 ? (vec3){0, 0, 0} : vec3_lerp(stops[(int)at], stops[(int)at + 1], at - floorf(at));
        if (fabsf(color.x - p[0]) < 1.5f && fabsf(color.y - p[1]) < 1.5f && fabsf(color.z - p[2]) < 1.5f)
            return counts[i];
    }
    fail_msg("no count has the colour %d %d %d", p[0], p[1], p[2]);
    return 0;
}

static fnl_frame pixel_frame(void) {
    fnl_frame frame = test_frame(FNL_OUTPUT_COLOR);
    frame.width = frame.height = SIZE;
    frame.camera.vertical_extent = SIZE;
    return frame;
}

static fnl_scene *lit_scene(void) {
    fnl_scene *scene = test_scene();
    for (int i = 0; i < LIGHTS; i++) {
        fnl_light_params light = test_point((vec3){(float)i, 0, 3}, 1, 900);
        fnl_light_id id;
        assert_int_equal(fnl_scene_add_light(scene, &light, &id), FNL_OK);
    }
    return scene;
}

/* Every pixel shows what was counted; returns the mean of those that show something, the legend's rows aside. */
static double check(const fnl_image *image, int owners[SIZE][SIZE]) {
    double sum = 0;
    int covered = 0, unsure = 0;
    for (int y = 0; y < LEGEND_TOP; y++)
        for (int x = 0; x < SIZE; x++) {
            double count = wanted(owners, x, y), shown = invocations(test_pixel8(image, (uint32_t)x, (uint32_t)y));
            if (count >= 0 && fabs(count - shown) > 1e-6) fail_msg("pixel %d, %d: %g, expected %g", x, y, shown, count);
            unsure += count < 0;
            covered += shown > 0;
            sum += shown;
        }
    assert_true(unsure * 50 < covered);
    return sum / covered;
}

/* Triangles of about 100, 10 and 1 pixels, of one area: forward shading spends more and more, deferred lighting one evaluation per
   pixel and light. */
static void test_small_triangles_MP_15(void **state) {
    UNUSED(state);
    static const uint32_t sides[MESHES] = {7, 21, 68};
    static int owners[SIZE][SIZE];
    double means[MESHES];
    for (int i = 0; i < MESHES; i++) {
        fnl_scene *scene = lit_scene();
        struct mesh mesh = make_mesh(scene, 9 * STEPS + 77, AREA * STEPS, sides[i]);
        place_mesh(scene, &mesh, 0);
        memset(owners, NOBODY, sizeof owners);
        paint(&mesh, 0, owners);
        fnl_renderer *renderer = test_renderer(scene);
        for (uint32_t shading = 0; shading < FNL_SHADING_DEFERRED + 1; shading++) {
            fnl_frame frame = pixel_frame();
            frame.shading = (fnl_shading)shading;
            frame.debug = FNL_DEBUG_OVERSHADING;
            test_render_frame(renderer, &frame);
            fnl_image image = test_read(renderer, FNL_OUTPUT_COLOR);
            means[i] = check(&image, owners);
            free_picture(&image);
        }
        fnl_frame frame = pixel_frame();
        frame.shading = FNL_SHADING_DEFERRED;
        frame.count_lights = true;
        frame.outputs = FNL_OUTPUT_NORMAL;
        test_render_frame(renderer, &frame);
        fnl_image normal = test_read(renderer, FNL_OUTPUT_NORMAL);
        uint64_t covered = 0;
        for (uint32_t p = 0; p < SIZE * SIZE; p++) covered += ((const float *)normal.pixels)[p * 4 + 3] > 0;
        fnl_frame_stats stats;
        assert_int_equal(fnl_renderer_query_stats(renderer, &stats), FNL_OK);
        print_message("  triangles of %.1f pixels: %.2f invocations a pixel, deferred lighting %.2f\n",
                      (double)AREA * AREA / (2.0 * sides[i] * sides[i]), means[i],
                      (double)stats.evaluations / (double)(covered * LIGHTS));
        assert_int_equal(stats.evaluations, covered * LIGHTS);
        assert_int_equal(stats.max_per_pixel, LIGHTS);
        free_picture(&normal);
        fnl_renderer_destroy(&renderer);
        fnl_scene_destroy(&scene);
    }
    assert_true(means[0] > 1 && means[0] < 1.4);
    assert_true(means[1] > means[0] + 0.3 && means[2] > means[1] + 0.5);
    assert_true(means[2] > 2.5 && means[2] <= 4);
}

/* What another surface hides costs nothing, drawn before it or after it; at its edge both cost. */
static void test_hidden_surfaces_MP_15(void **state) {
    UNUSED(state);
    static int owners[SIZE][SIZE];
    for (int last = 0; last < 2; last++) {
        fnl_scene *scene = lit_scene();
        struct mesh mesh = make_mesh(scene, 9 * STEPS + 77, AREA * STEPS, 21),
                    near = make_mesh(scene, 40 * STEPS + 101, 41 * STEPS, 1);
        if (!last) place_mesh(scene, &near, 1);
        place_mesh(scene, &mesh, 0);
        if (last) place_mesh(scene, &near, 1);
        memset(owners, NOBODY, sizeof owners);
        paint(&mesh, 0, owners);
        paint(&near, 1 << 20, owners);
        fnl_frame frame = pixel_frame();
        frame.debug = FNL_DEBUG_OVERSHADING;
        fnl_image image = test_render(scene, &frame, FNL_OUTPUT_COLOR);
        check(&image, owners);
        free_picture(&image);
        fnl_scene_destroy(&scene);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_small_triangles_MP_15),
        cmocka_unit_test(test_hidden_surfaces_MP_15),
    };
    return cmocka_run_group_tests_name("overshading", tests, test_group_begin, test_group_end);
}
