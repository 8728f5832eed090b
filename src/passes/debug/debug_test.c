/* SPDX-License-Identifier: MIT */
/** Debug views at probed pixels. */
#include "fanal/legend.h"
#include "tests/shade_reference.h"
#include "tests/render_test.h"

enum { WIDTH = 200, HEIGHT = 100, LEGEND_HEIGHT = 14, BOX = 16 };

static fnl_frame debug_frame(fnl_debug_view view) {
    fnl_frame frame = test_frame(FNL_OUTPUT_COLOR);
    frame.width = WIDTH;
    frame.height = HEIGHT;
    frame.debug = view;
    frame.exposure = FNL_EXPOSURE_AUTO; /* must not matter */
    return frame;
}

static void assert_color(const fnl_image *image, uint32_t x, uint32_t y, double r, double g, double b) {
    const uint8_t *p = test_pixel8(image, x, y);
    const double wanted[3] = {r, g, b};
    for (int c = 0; c < 3; c++)
        if (fabs(p[c] - wanted[c] * 255) > 1.01)
            fail_msg("pixel %u, %u is %d %d %d, expected %g %g %g", x, y, p[0], p[1], p[2], r * 255, g * 255, b * 255);
    assert_int_equal(p[3], 255);
}

/* The scale of counts: viridis, whose lightness only grows; 1, 2, 4 … 256 in equal steps. */
static vec3 heat(double count) {
    static const vec3 stops[9] = {{68, 1, 84}, {71, 45, 123}, {59, 82, 139}, {44, 114, 142}, {33, 144, 140},
                                  {39, 173, 129}, {93, 200, 99}, {170, 220, 50}, {253, 231, 37}};
    if (count == 0) return (vec3){0, 0, 0};
    float x = (float)fmin((log2(count) + 1) / 9, 1) * 8;
    int i = MIN((int)x, 7);
    return vec3_scale(vec3_lerp(stops[i], stops[i + 1], x - (float)i), 1 / 255.0f);
}

/* ---- surfaces ---- */

/* A square at z = 1 in the middle, tilted about y; nothing around it. */
static fnl_scene *tilted(struct scene_material *material) {
    *material = scene_material_default();
    material->base_color = (vec4){0.8f, 0.2f, 0.05f, 1};
    material->roughness = 0.3f;
    fnl_scene *scene = test_scene();
    mat4 matrix = mat4_from_trs((vec3){0, 0, 1}, quat_axis_angle((vec3){0, 1, 0}, 0.5f), (vec3){0.8f, 0.8f, 1});
    scene_add_node(scene, "", SCENE_NONE, &matrix, test_quad_mesh(scene, scene_add_material(scene, material)));
    assert_int_equal(fnl_scene_set_background(scene, (vec3){9, 9, 9}), FNL_OK);
    return scene;
}

static void test_surface_views(void **state) {
    UNUSED(state);
    struct scene_material m;
    fnl_scene *scene = tilted(&m);
    fnl_renderer *renderer = test_renderer(scene);
    static const fnl_debug_view views[] = {FNL_DEBUG_ALBEDO, FNL_DEBUG_NORMAL, FNL_DEBUG_DEPTH, FNL_DEBUG_ROUGHNESS};
    for (uint32_t v = 0; v < COUNT_OF(views); v++)
        for (uint32_t shading = 0; shading < FNL_SHADING_DEFERRED + 1; shading++) {
            fnl_frame frame = debug_frame(views[v]);
            frame.shading = (fnl_shading)shading;
            test_render_frame(renderer, &frame);
            fnl_image image = test_read(renderer, FNL_OUTPUT_COLOR);
            for (uint32_t x = 70; x < 130; x += 9) {
                double world_x = (x + 0.5) / 50 - 2, z = 1 - world_x * tan(0.5), depth = 5 - z, r = 0.3;
                if (views[v] == FNL_DEBUG_ALBEDO)
                    assert_color(&image, x, 50, reference_srgb(0.8), reference_srgb(0.2), reference_srgb(0.05));
                if (views[v] == FNL_DEBUG_NORMAL)
                    assert_color(&image, x, 50, sin(0.5) * 0.5 + 0.5, 0.5, cos(0.5) * 0.5 + 0.5);
                if (views[v] == FNL_DEBUG_DEPTH)
                    assert_color(&image, x, 50, 1 / (1 + 0.05 * depth), 1 / (1 + 0.05 * depth), 1 / (1 + 0.05 * depth));
                if (views[v] == FNL_DEBUG_ROUGHNESS) assert_color(&image, x, 50, r, r, r);
            }
            assert_color(&image, 5, 5, 0, 0, 0); /* the sky is black in each */
            free_picture(&image);
        }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* ---- counts ---- */

/* The digits that the legend needs, as anyone would draw them on 3 x 5 dots. */
static const char *const digit_rows[10][5] = {{"###", "#.#", "#.#", "#.#", "###"}, {".#.", "##.", ".#.", ".#.", "###"},
                                              {"###", "..#", "###", "#..", "###"}, {"###", "..#", "###", "..#", "###"},
                                              {"#.#", "#.#", "###", "..#", "..#"}, {"###", "#..", "###", "..#", "###"},
                                              {"###", "#..", "###", "#.#", "###"}, {"###", "..#", "..#", "..#", "..#"},
                                              {"###", "#.#", "###", "#.#", "###"}, {"###", "#.#", "###", "..#", "###"}};

/* More is brighter, by a step that is seen, so that the map is read without telling hues apart. */
static void check_lightness(const fnl_image *image) {
    double before = 0;
    for (uint32_t box = 0; box < 10; box++) {
        const uint8_t *p = test_pixel8(image, box * BOX + 14, image->height - LEGEND_HEIGHT + 1);
        double luminance = 0, weights[3] = {0.2126, 0.7152, 0.0722};
        for (int c = 0; c < 3; c++) luminance += weights[c] * pow((p[c] / 255.0 + 0.055) / 1.055, 2.4);
        double light = cbrt(luminance); /* as CIE lightness, but for its scale */
        assert_true(box == 0 || light > before + 0.04);
        before = light;
    }
}

/* Ten boxes in the lower left corner: 0 and the powers of two, each with its number in ink that stands out. */
static void check_legend(const fnl_image *image) {
    fnl_debug_legend told; /* the ramp of the public legend goes from 1 to 256 in 32 steps: a power of two is 4 */
    assert_true(fnl_debug_legend_query(FNL_DEBUG_LIGHTS, &told));
    assert_int_equal(told.color_count, 33);
    for (uint32_t box = 1; box < 10; box++) {
        const fnl_vec3 color = told.colors[4 * (box - 1)];
        assert_color(image, box * BOX, HEIGHT - 1, color.x, color.y, color.z);
    }
    for (uint32_t box = 0; box < 10; box++) {
        uint32_t value = box ? 1u << (box - 1) : 0, digits[3] = {value / 100, value / 10 % 10, value % 10};
        vec3 color = heat(value);
        float luma = 0.2126f * color.x + 0.7152f * color.y + 0.0722f * color.z, ink = luma > 0.4f ? 0 : 1;
        for (uint32_t y = 0; y < LEGEND_HEIGHT; y++)
            for (uint32_t x = 0; x < BOX; x++) {
                bool inked = false;
                for (uint32_t d = 0; d < 3; d++) {
                    int dx = (int)x - 2 - (int)d * 4, dy = (int)y - 5;
                    bool shown = d == 2 || value >= (d == 0 ? 100u : 10u);
                    inked =
                        inked || (shown && dx >= 0 && dx < 3 && dy >= 0 && dy < 5 && digit_rows[digits[d]][dy][dx] == '#');
                }
                vec3 wanted = inked ? (vec3){ink, ink, ink} : color;
                assert_color(image, box * BOX + x, HEIGHT - LEGEND_HEIGHT + y, wanted.x, wanted.y, wanted.z);
            }
    }
}

static double grey_of(const struct scene_material *m, double normal_y) {
    return 0.12 +
           0.88 * (0.2126 * m->base_color.x + 0.7152 * m->base_color.y + 0.0722 * m->base_color.z) * (0.6 + 0.4 * normal_y);
}

static bool is_one_of(fnl_light_lists lists, const fnl_light_lists *set, uint32_t count) {
    for (uint32_t i = 0; i < count; i++)
        if (set[i] == lists) return true;
    return false;
}

static void test_light_counts(void **state) {
    UNUSED(state);
    fnl_scene *scene = test_scene();
    struct scene_material m = scene_material_default();
    m.base_color = (vec4){0.5f, 0.5f, 0.5f, 1};
    test_place(scene, test_quad_mesh(scene, scene_add_material(scene, &m)), (vec3){0, 0, 0}, (vec3){1.9f, 1, 1});
    for (int i = 0; i < 5; i++) { /* all on the left */
        fnl_light_params light = test_point((vec3){-1.5f, 0, 0.2f}, 1, 0.3f);
        fnl_light_id id;
        assert_int_equal(fnl_scene_add_light(scene, &light, &id), FNL_OK);
    }
    fnl_renderer *renderer = test_renderer(scene);
    /* Those that know no places on the square: it is one item, and smaller than the grid's squares of 4 metres. */
    static const fnl_light_lists whole[] = {FNL_LISTS_ALL, FNL_LISTS_MESH, FNL_LISTS_BATCHES, FNL_LISTS_MULTIPASS,
                                            FNL_LISTS_GRID2D};
    for (uint32_t lists = 0; lists < FNL_LISTS_AUTO; lists++)
        for (uint32_t shading = 0; shading < FNL_SHADING_DEFERRED + 1; shading++) {
            fnl_frame frame = debug_frame(FNL_DEBUG_LIGHTS);
            frame.shading = (fnl_shading)shading;
            frame.lists = (fnl_light_lists)lists;
            if (!fnl_shading_supports(frame.shading, frame.lists, frame.msaa)) continue;
            frame.count_lights = true;
            test_render_frame(renderer, &frame);
            fnl_image image = test_read(renderer, FNL_OUTPUT_COLOR);
            double grey = grey_of(&m, 0);
            vec3 five = heat(5);
            bool everywhere = is_one_of((fnl_light_lists)lists, whole, COUNT_OF(whole));
            double far = everywhere ? 5 : 0;
            vec3 there = heat(far);
            assert_color(&image, 25, 50, grey * 0.2 + five.x * 0.8, grey * 0.2 + five.y * 0.8, grey * 0.2 + five.z * 0.8);
            /* Not at the height of the lights: cells at the border of a grid in the world reach on. */
            assert_color(&image, 180, 10, grey * 0.2 + there.x * 0.8, grey * 0.2 + there.y * 0.8,
                         grey * 0.2 + there.z * 0.8);
            check_lightness(&image);
            check_legend(&image);
            /* The map shows what the shading visits. */
            fnl_frame_stats stats;
            assert_int_equal(fnl_renderer_query_stats(renderer, &stats), FNL_OK);
            assert_int_equal(stats.max_per_pixel, 5);
            if (everywhere)
                assert_int_equal(stats.evaluations, 5ull * 190 * 100);
            else
                assert_true(stats.evaluations < 5ull * 100 * 100);
            free_picture(&image);
        }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

static void test_cells(void **state) {
    UNUSED(state);
    fnl_scene *scene = test_scene();
    struct scene_material m = scene_material_default();
    m.base_color = (vec4){0.5f, 0.5f, 0.5f, 1};
    uint32_t mesh = test_quad_mesh(scene, scene_add_material(scene, &m));
    test_place(scene, mesh, (vec3){-1, 0, 3}, (vec3){1, 1, 1});  /* left: near */
    test_place(scene, mesh, (vec3){1, 0, -12}, (vec3){1, 1, 1}); /* right: far */
    fnl_light_params light = test_point((vec3){0, 0, 3}, 1, 90);
    fnl_light_id id;
    assert_int_equal(fnl_scene_add_light(scene, &light, &id), FNL_OK);
    fnl_renderer *renderer = test_renderer(scene);
    /* Tiles have the colour of their count, others hues of their own; those by place have no grid on the screen. */
    static const fnl_light_lists tiled[] = {FNL_LISTS_TILED,    FNL_LISTS_BACKFACE, FNL_LISTS_FINE,
                                            FNL_LISTS_ENHANCED, FNL_LISTS_TREE,     FNL_LISTS_25D},
                                 places[] = {FNL_LISTS_GRID2D, FNL_LISTS_WORLD},
                                 others16[] = {FNL_LISTS_HALFZ, FNL_LISTS_ZBIN};
    for (uint32_t lists = FNL_LISTS_ALL; lists < FNL_LISTS_AUTO; lists++) {
        fnl_frame frame = debug_frame(FNL_DEBUG_CELLS);
        frame.shading = FNL_SHADING_DEFERRED;
        frame.lists = (fnl_light_lists)lists;
        if (!fnl_shading_supports(frame.shading, frame.lists, frame.msaa)) continue;
        test_render_frame(renderer, &frame);
        fnl_image image = test_read(renderer, FNL_OUTPUT_COLOR);
        bool tiles = is_one_of(frame.lists, tiled, COUNT_OF(tiled)),
             by_place = is_one_of(frame.lists, places, COUNT_OF(places));
        uint32_t size = tiles || is_one_of(frame.lists, others16, COUNT_OF(others16)) ? 16 : 64;
        const uint8_t *inside = test_pixel8(&image, size + 5, 70), *line = test_pixel8(&image, size, 70),
                      *far = test_pixel8(&image, 150, 70);
        double half_grey = grey_of(&m, 0) * 0.5;
        if (lists == FNL_LISTS_ALL) { /* no cells */
            assert_color(&image, size + 5, 70, half_grey, half_grey, half_grey);
            assert_color(&image, size, 70, half_grey, half_grey, half_grey);
        } else {
            const uint8_t *cell = by_place ? test_pixel8(&image, size + 1, 70) : inside;
            for (int c = 0; c < 3; c++)
                if (fabs(line[c] - (by_place ? cell[c] : cell[c] * 0.65 + 255 * 0.35)) > 1.5)
                    fail_msg("%s: the grid", fnl_value_name(FNL_ENUM_LISTS, frame.lists));
            bool same = memcmp(inside, far, 4) == 0;
            if (same != tiles && lists != FNL_LISTS_HALFZ) /* which half a lone surface is in does not matter */
                fail_msg("%s: the hues", fnl_value_name(FNL_ENUM_LISTS, frame.lists));
            vec3 one = heat(1);
            if (tiles)
                assert_color(&image, 150, 70, half_grey * 0.55 + one.x * 0.45, half_grey * 0.55 + one.y * 0.45,
                             half_grey * 0.55 + one.z * 0.45);
        }
        free_picture(&image);
    }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

static void test_overdraw(void **state) {
    UNUSED(state);
    static const uint8_t hole[4] = {255, 255, 255, 0};
    fnl_scene *scene = test_scene();
    struct scene_material m = scene_material_default();
    uint32_t mesh = test_quad_mesh(scene, scene_add_material(scene, &m));
    test_place(scene, mesh, (vec3){-0.5f, 0, 1}, (vec3){1, 1, 1});
    test_place(scene, mesh, (vec3){0, 0, 0}, (vec3){1, 1, 1}); /* hidden behind the others */
    test_place(scene, mesh, (vec3){0.5f, 0, 2}, (vec3){1, 1, 1});
    fnl_image texel = {1, 1, FNL_PIXEL_FORMAT_RGBA8, (void *)(uintptr_t)hole};
    fnl_image_id id;
    assert_int_equal(fnl_scene_add_image(scene, &texel, true, &id), FNL_OK);
    m.alpha_mode = FNL_ALPHA_MASK;
    m.textures[SCENE_TEXTURE_BASE_COLOR].image = id.index;
    test_place(scene, test_quad_mesh(scene, scene_add_material(scene, &m)), (vec3){0, 0, 3},
               (vec3){1, 1, 1}); /* nothing but a hole */
    fnl_frame frame = debug_frame(FNL_DEBUG_OVERDRAW);
    fnl_image image = test_render(scene, &frame, FNL_OUTPUT_COLOR);
    static const struct {
        uint32_t x, count;
    } probes[] = {{10, 0}, {35, 1}, {60, 2}, {100, 3}, {140, 2}, {165, 1}, {190, 0}};
    for (uint32_t i = 0; i < COUNT_OF(probes); i++) {
        vec3 color = heat(probes[i].count);
        assert_color(&image, probes[i].x, 40, color.x, color.y, color.z);
    }
    check_legend(&image);
    free_picture(&image);
    fnl_scene_destroy(&scene);
}

/* Tiles that show a near and a far quad have a color, by the ratio of their depths; others have none. */
static void test_depth_jumps(void **state) {
    UNUSED(state);
    fnl_scene *scene = test_scene();
    struct scene_material m = scene_material_default();
    const uint32_t mesh = test_quad_mesh(scene, scene_add_material(scene, &m));
    test_place(scene, mesh, (vec3){0, 0, -9}, (vec3){100, 100, 1});
    test_place(scene, mesh, (vec3){0, 0, 4}, (vec3){0.4f, 0.4f, 1});
    fnl_frame frame = debug_frame(FNL_DEBUG_DEPTH_JUMPS);
    frame.lists = FNL_LISTS_TILED;
    fnl_image image = test_render(scene, &frame, FNL_OUTPUT_COLOR);
    uint32_t colored = 0, by_row[64] = {0};
    for (uint32_t y = 8; y < image.height; y += 16)
        for (uint32_t x = 8; x < image.width; x += 16) {
            const uint8_t *c = test_pixel8(&image, x, y);
            const bool has_color = abs(c[0] - c[1]) > 8 || abs(c[1] - c[2]) > 8;
            colored += has_color;
            by_row[y / 16] += has_color;
        }
    print_message("%u tiles jump\n", colored);
    assert_true(colored >= 8 && colored <= 40 && by_row[0] == 0);
    free_picture(&image);
    fnl_scene_destroy(&scene);
}

/* A quad has two triangles, each of one color. */
static void test_triangles(void **state) {
    UNUSED(state);
    fnl_scene *scene = test_scene();
    struct scene_material m = scene_material_default();
    test_place(scene, test_quad_mesh(scene, scene_add_material(scene, &m)), (vec3){0, 0, 0}, (vec3){1, 1, 1});
    fnl_frame frame = debug_frame(FNL_DEBUG_TRIANGLES);
    fnl_image image = test_render(scene, &frame, FNL_OUTPUT_COLOR);
    const uint8_t *first = test_pixel8(&image, 80, 30), *second = test_pixel8(&image, 120, 70);
    assert_memory_not_equal(first, second, 3);
    for (uint32_t i = 0; i < 4; i++) {
        assert_memory_equal(test_pixel8(&image, 70 + 5 * i, 25 + 3 * i), first, 3);
        assert_memory_equal(test_pixel8(&image, 115 + 5 * i, 65 + 3 * i), second, 3);
    }
    free_picture(&image);
    fnl_scene_destroy(&scene);
}

static bool is_gray(const uint8_t *c) { return abs(c[0] - c[1]) <= 2 && abs(c[1] - c[2]) <= 2; }

/* Two lights before a wall, each with a disk on it: a hue of its own inside, another where both are, gray outside, and a line around each. */
static void test_light_volumes(void **state) {
    UNUSED(state);
    fnl_scene *scene = test_scene();
    struct scene_material m = scene_material_default();
    test_place(scene, test_quad_mesh(scene, scene_add_material(scene, &m)), (vec3){0, 0, 0}, (vec3){100, 100, 1});
    for (int i = 0; i < 2; i++) {
        fnl_light_params light = fnl_light_params_default();
        light.position = (fnl_vec3){i ? 0.6f : -0.6f, 0, 0.3f};
        light.range = 0.9f; /* a disk of radius sqrt(0.72) */
        fnl_light_id id;
        assert_int_equal(fnl_scene_add_light(scene, &light, &id), FNL_OK);
    }
    for (uint32_t k = 0; k < 3; k++) {
        fnl_frame frame = debug_frame(FNL_DEBUG_LIGHT_VOLUMES);
        frame.lists = k == 0 ? FNL_LISTS_TILED : k == 1 ? FNL_LISTS_CLUSTERED : FNL_LISTS_ALL;
        if (k == 2) frame.shading = FNL_SHADING_DEFERRED_VOLUMES;
        fnl_image image = test_render(scene, &frame, FNL_OUTPUT_COLOR);
        uint32_t lines = 0, wrong = 0;
        const uint8_t *only[2] = {test_pixel8(&image, 45, 50), test_pixel8(&image, 155, 50)}, *both = test_pixel8(&image, 100, 50);
        assert_memory_not_equal(only[0], only[1], 3);
        assert_memory_not_equal(only[0], both, 3);
        for (uint32_t y = 0; y < HEIGHT; y++)
            for (uint32_t x = 0; x < WIDTH; x++) {
                const double px = (x + 0.5) / 50 - 2, py = 1 - (y + 0.5) / 50;
                double nearest = 9;
                bool inside[2];
                for (int i = 0; i < 2; i++) {
                    const double away = hypot(px - (i ? 0.6 : -0.6), py) - sqrt(0.72);
                    inside[i] = away < 0;
                    nearest = fmin(nearest, fabs(away));
                }
                const uint8_t *c = test_pixel8(&image, x, y);
                const bool line = MAX(MAX(c[0], c[1]), c[2]) == 255 && MIN(MIN(c[0], c[1]), c[2]) <= 66;
                lines += line;
                if (line) wrong += nearest > 2.5 / 50;
                if (nearest < 2.5 / 50) continue;
                if (!inside[0] && !inside[1]) wrong += !is_gray(c);
                if (inside[0] != inside[1]) wrong += memcmp(c, only[inside[1]], 3) != 0;
                if (inside[0] && inside[1]) wrong += memcmp(c, both, 3) != 0;
            }
        print_message("  %u pixels of lines, %u wrong\n", lines, wrong);
        assert_int_equal(wrong, 0);
        assert_in_range(lines, 200, 700);
        free_picture(&image);
    }
    fnl_scene_destroy(&scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_surface_views),
        cmocka_unit_test(test_light_counts),
        cmocka_unit_test(test_cells),
        cmocka_unit_test(test_overdraw),
        cmocka_unit_test(test_triangles),
        cmocka_unit_test(test_depth_jumps),
        cmocka_unit_test(test_light_volumes),
    };
    return cmocka_run_group_tests_name("debug views", tests, test_group_begin, test_group_end);
}
