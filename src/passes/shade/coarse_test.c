/* SPDX-License-Identifier: MIT */
/** Coarse shading: which blocks are lit once, what their pixels get, and what is counted. */
#include "tests/render_harness.h"

/* ---- scenes ---- */

static fnl_scene *empty_scene(void) {
    fnl_scene *scene;
    assert_int_equal(fnl_scene_create(gpu_host(harness_device()), &scene), FNL_OK);
    return scene;
}

static fnl_material_id add_material(fnl_scene *scene, float roughness, fnl_image_id image) {
    fnl_material_params params = fnl_material_params_default();
    fnl_material_id id;
    params.base_color[0] = 0.8f;
    params.base_color[1] = 0.6f;
    params.base_color[2] = 0.5f;
    params.metallic = 0;
    params.roughness = roughness;
    params.double_sided = true;
    params.base_color_image = image;
    assert_int_equal(fnl_scene_add_material(scene, &params, &id), FNL_OK);
    return id;
}
static fnl_material_id plain(fnl_scene *scene) { return add_material(scene, 0.7f, (fnl_image_id){0}); }

static void add_mesh(fnl_scene *scene, const fnl_mesh_params *mesh) {
    fnl_mesh_id mesh_id;
    fnl_instance_id instance;
    fnl_mat4 matrix = mat4_identity();
    assert_int_equal(fnl_scene_add_mesh(scene, mesh, &mesh_id), FNL_OK);
    assert_int_equal(fnl_scene_add_instance(scene, mesh_id, &matrix, &instance), FNL_OK);
}

/* The part x0 .. x1 of the plane z = at + a x + b y, -3 <= y <= 3; uv are x and y. */
static void add_plane(fnl_scene *scene, fnl_material_id material, float x0, float x1, float at, float a, float b) {
    static const uint32_t indices[] = {0, 1, 2, 0, 2, 3};
    float positions[12], uv[8];
    for (int i = 0; i < 4; i++) {
        float x = i == 1 || i == 2 ? x1 : x0, y = i < 2 ? -3 : 3;
        memcpy(&positions[3 * i], (float[3]){x, y, at + a * x + b * y}, 12);
        memcpy(&uv[2 * i], (float[2]){x, y}, 8);
    }
    add_mesh(scene, &(fnl_mesh_params){.vertex_count = 4,
                                       .index_count = 6,
                                       .positions = positions,
                                       .uv = uv,
                                       .indices = indices,
                                       .material = material});
}

enum { RINGS = 12 };
static void add_sphere(fnl_scene *scene, fnl_material_id material, float radius) {
    float positions[3 * (RINGS + 1) * (2 * RINGS + 1)], normals[COUNT_OF(positions)];
    uint32_t indices[6 * RINGS * 2 * RINGS], count = 0;
    for (int i = 0; i <= RINGS; i++)
        for (int k = 0; k <= 2 * RINGS; k++) {
            float theta = PI * (float)i / RINGS, phi = PI * (float)k / RINGS;
            float n[3] = {sinf(theta) * cosf(phi), cosf(theta), sinf(theta) * sinf(phi)};
            for (int c = 0; c < 3; c++) {
                normals[3 * (i * (2 * RINGS + 1) + k) + c] = n[c];
                positions[3 * (i * (2 * RINGS + 1) + k) + c] = radius * n[c];
            }
        }
    for (uint32_t i = 0; i < RINGS; i++)
        for (uint32_t k = 0; k < 2 * RINGS; k++) {
            uint32_t a = i * (2 * RINGS + 1) + k, b = a + 2 * RINGS + 1;
            const uint32_t quad[6] = {a, a + 1, b, b, a + 1, b + 1};
            memcpy(&indices[count], quad, sizeof quad);
            count += 6;
        }
    add_mesh(scene, &(fnl_mesh_params){.vertex_count = (RINGS + 1) * (2 * RINGS + 1),
                                       .index_count = count,
                                       .positions = positions,
                                       .normals = normals,
                                       .indices = indices,
                                       .material = material});
}

static void add_light(fnl_scene *scene, fnl_light_kind kind, vec3 position, float intensity) {
    fnl_light_params light = fnl_light_params_default();
    fnl_light_id id;
    light.kind = kind;
    light.position = position;
    light.intensity = intensity;
    light.range = 8;
    light.outer_cone_angle = 0.3f;
    light.inner_cone_angle = 0.299f;
    assert_int_equal(fnl_scene_add_light(scene, &light, &id), FNL_OK);
}

/* ---- frames ---- */

/* 64x64 from z = 5 on the square -1 .. 1: a pixel is 1/32 wide. */
static fnl_frame coarse_frame(const struct stage *stage) {
    fnl_frame frame = stage->frame;
    frame.shading = FNL_SHADING_COARSE;
    frame.width = frame.height = 64;
    frame.exposure = FNL_EXPOSURE_NONE;
    return frame;
}
static fnl_frame front_frame(const struct stage *stage) {
    fnl_frame frame = coarse_frame(stage);
    frame.camera = fnl_camera_default();
    frame.camera.position = vec3_make(0, 0, 5);
    frame.camera.target = vec3_make(0, 0, 0);
    frame.camera.orthographic = true;
    frame.camera.vertical_extent = 2;
    frame.camera.far_distance = 20;
    return frame;
}
static fnl_frame hall_frame(const struct stage *stage, uint32_t width, uint32_t height) {
    fnl_frame frame = stage->frame;
    frame.shading = FNL_SHADING_COARSE;
    frame.width = width;
    frame.height = height;
    return frame;
}

static fnl_frame_stats shoot_stats(struct stage *stage, const fnl_frame *frame) {
    struct shot shot = stage_shoot(stage, frame);
    fnl_frame_stats stats = shot.stats;
    shot_free(&shot);
    return stats;
}

static struct shot shoot_deferred(struct stage *stage, fnl_frame frame) {
    frame.shading = FNL_SHADING_DEFERRED;
    return stage_shoot(stage, &frame);
}

static double psnr(const fnl_image *a, const fnl_image *b) {
    fnl_image_difference d;
    assert_int_equal(fnl_image_compare(gpu_host(harness_device()), a, b, &d), FNL_OK);
    return d.psnr;
}

/* Largest relative difference of two radiances, at pixels whose coordinates are multiples of `step`. */
static double worst_ratio(const fnl_image *a, const fnl_image *b, uint32_t step) {
    const float *p = a->pixels, *q = b->pixels;
    double worst = 0;
    for (uint32_t y = 0; y < a->height; y += step)
        for (uint32_t x = 0; x < a->width; x += step)
            for (uint32_t c = 0; c < 3; c++) {
                size_t i = 4 * ((size_t)y * a->width + x) + c;
                worst = fmax(worst, fabs((double)p[i] - q[i]) / (1e-3 + fabs((double)q[i])));
            }
    return worst;
}

/* From the view coarse-reason: 0 nothing, 1 lit once, 2 depth, 3 normal, 4 material. */
static uint32_t kind_at(const fnl_image *view, uint32_t x, uint32_t y) {
    const uint8_t *p = (const uint8_t *)view->pixels + 4 * ((size_t)y * view->width + x);
    return p[1] > p[0] + 50 ? 1 : p[0] > p[1] + 50 ? 2 : p[2] > p[0] + 50 ? 3 : p[0] > p[2] + 50 ? 4 : 0;
}
static struct shot shoot_view(struct stage *stage, fnl_frame frame, fnl_debug_view view) {
    frame.debug = view;
    frame.outputs = FNL_OUTPUT_COLOR;
    return stage_shoot(stage, &frame);
}

/* ---- the G-buffer and the criterion z ---- */

/*
 * On a plane the depths of a block differ from the first by at most (size - 1) (|dz/dx| + |dz/dy|), or by the larger of the two where they
 * have different signs; so the factor at which blocks begin to be lit once measures the stored gradient.
 */
static void test_gradient_is_the_slope_of_a_plane_CP_1(void **state) {
    UNUSED(state);
    static const float slopes[][2] = {{0.4f, 0}, {0, 0.7f}, {0.3f, -0.5f}, {0.3f, 0.5f}, {-0.9f, 0.2f}, {0.05f, -0.08f}};
    for (uint32_t i = 0; i < COUNT_OF(slopes); i++) {
        float a = slopes[i][0], b = slopes[i][1];
        fnl_scene *scene = empty_scene();
        add_plane(scene, plain(scene), -3, 3, 0, a, b);
        struct stage stage = stage_open_scene(scene);
        fnl_frame frame = front_frame(&stage);
        for (uint32_t size = 2; size <= 4; size += 2) {
            /* The view depth grows by -a to the right and by b down, a pixel's width each. */
            float away = -a * b >= 0 ? fabsf(a) + fabsf(b) : fmaxf(fabsf(a), fabsf(b));
            float factor = (float)(size - 1) * away / ((float)size * sqrtf(2) * (fabsf(a) + fabsf(b)));
            frame.coarse.size = size;
            frame.coarse.depth_factor = factor * 0.995f;
            fnl_frame_stats below = shoot_stats(&stage, &frame);
            frame.coarse.depth_factor = factor * 1.005f;
            fnl_frame_stats above = shoot_stats(&stage, &frame);
            assert_int_equal(below.coarse_blocks, 64 * 64 / (size * size));
            assert_int_equal(below.coarse_shared, 0);
            assert_int_equal(below.coarse_by_depth, below.coarse_blocks);
            assert_int_equal(above.coarse_shared, above.coarse_blocks);
        }
        stage_close(&stage);
    }
}

static void test_size_1_is_deferred_CP_2(void **state) {
    UNUSED(state);
    static const char *const sources[] = {"builtin:hall?lights=200&decals=40", "builtin:glass", "builtin:sky?lights=30"};
    for (uint32_t i = 0; i < COUNT_OF(sources); i++) {
        struct stage stage = stage_open(sources[i], 0);
        fnl_frame frame = hall_frame(&stage, 101, 67);
        frame.coarse.size = 1;
        struct shot a = stage_shoot(&stage, &frame), b = shoot_deferred(&stage, frame);
        assert_int_equal(count_differing(&a.radiance, &b.radiance), 0);
        assert_int_equal(a.stats.coarse_shaded, a.stats.coarse_pixels);
        shot_free(&a);
        shot_free(&b);
        stage_close(&stage);
    }
}

static void test_plane_is_lit_once_per_block_CP_3(void **state) {
    UNUSED(state);
    fnl_scene *scene = empty_scene();
    add_plane(scene, plain(scene), -3, 3, 0, 0.2f, -0.1f);
    add_light(scene, FNL_LIGHT_POINT, vec3_make(0.4f, 0.3f, 2), 20);
    struct stage stage = stage_open_scene(scene);
    fnl_frame frame = front_frame(&stage);
    struct shot full = shoot_deferred(&stage, frame);
    for (uint32_t size = 2; size <= 4; size += 2)
        for (uint32_t criterion = 0; criterion < FNL_COARSE_CRITERION_COUNT; criterion++) {
            frame.coarse.size = size;
            frame.coarse.criterion = (fnl_coarse_criterion)criterion;
            struct shot shot = stage_shoot(&stage, &frame);
            double error = worst_ratio(&shot.radiance, &full.radiance, 1);
            uint32_t blocks = 64 * 64 / (size * size);
            assert_int_equal(shot.stats.coarse_blocks, blocks);
            if (criterion != FNL_COARSE_CRITERION_ID) {
                assert_int_equal(shot.stats.coarse_shared, blocks);
                assert_int_equal(shot.stats.coarse_shaded, blocks);
            } else { /* but for the edge between the two triangles */
                assert_in_range(blocks - shot.stats.coarse_shared, 1, 3 * 64 / size);
            }
            /* Light changes by less than 4 % from a pixel to the next diagonally, and the farthest is size - 1 away. */
            print_message("size %u, %s: off by %.3g\n", size, fnl_coarse_criterion_name(frame.coarse.criterion), error);
            assert_true(error > 1e-3 && error < 0.04 * (size - 1));
            shot_free(&shot);
        }
    shot_free(&full);
    stage_close(&stage);
}

static void test_curved_surface_is_lit_by_pixels_at_0_degrees_CP_4(void **state) {
    UNUSED(state);
    fnl_scene *scene = empty_scene();
    add_sphere(scene, plain(scene), 1.6f);
    add_light(scene, FNL_LIGHT_POINT, vec3_make(0.4f, 0.3f, 4), 20);
    struct stage stage = stage_open_scene(scene);
    fnl_frame frame = front_frame(&stage);
    struct shot full = shoot_deferred(&stage, frame);
    for (uint32_t criterion = 0; criterion < FNL_COARSE_CRITERION_COUNT; criterion++)
        for (uint32_t size = 2; size <= 4; size += 2) {
            frame.coarse = fnl_coarse_options_default();
            frame.coarse.size = size;
            frame.coarse.criterion = (fnl_coarse_criterion)criterion;
            frame.coarse.normal_degrees = 8;
            assert_true(shoot_stats(&stage, &frame).coarse_shared > 0);
            frame.coarse.normal_degrees = 0;
            struct shot shot = stage_shoot(&stage, &frame);
            assert_int_equal(shot.stats.coarse_shared, 0);
            assert_int_equal(count_differing(&shot.radiance, &full.radiance), 0);
            shot_free(&shot);
        }
    shot_free(&full);
    stage_close(&stage);
}

/* The kinds of all blocks of a picture that straddle column `x`, and that do not. */
static void check_column(struct stage *stage, fnl_frame frame, uint32_t x, uint32_t kind) {
    for (uint32_t size = 2; size <= 4; size += 2) {
        frame.coarse.size = size;
        struct shot view = shoot_view(stage, frame, FNL_DEBUG_COARSE_REASON);
        for (uint32_t v = 0; v < 64; v++)
            for (uint32_t u = 0; u < 64; u++) assert_int_equal(kind_at(&view.color, u, v), u / size == x / size ? kind : 1);
        shot_free(&view);
    }
}

static void test_depth_edge_between_parallel_planes_CP_5(void **state) {
    UNUSED(state);
    fnl_scene *scene = empty_scene();
    fnl_material_id material = plain(scene);
    add_plane(scene, material, -3, 1 / 32.0f, 0, 0, 0); /* to the middle of an odd column's left edge: 32 | 33 */
    add_plane(scene, material, 1 / 32.0f, 3, -0.5f, 0, 0);
    struct stage stage = stage_open_scene(scene);
    fnl_frame frame = front_frame(&stage);
    for (uint32_t criterion = 0; criterion < FNL_COARSE_CRITERION_COUNT; criterion += 2) {
        frame.coarse.criterion = (fnl_coarse_criterion)criterion;
        check_column(&stage, frame, 33, 2);
    }
    stage_close(&stage);
}

static void test_crease_CP_6(void **state) {
    UNUSED(state);
    fnl_scene *scene = empty_scene();
    fnl_material_id material = plain(scene);
    add_plane(scene, material, -3, 1 / 32.0f, -0.3f / 32, 0.3f, 0); /* both meet at depth 0 */
    add_plane(scene, material, 1 / 32.0f, 3, 0.3f / 32, -0.3f, 0);
    struct stage stage = stage_open_scene(scene);
    fnl_frame frame = front_frame(&stage);
    for (uint32_t criterion = 0; criterion < FNL_COARSE_CRITERION_COUNT; criterion += 2) {
        frame.coarse.criterion = (fnl_coarse_criterion)criterion;
        check_column(&stage, frame, 33, 3);
        frame.coarse.normal_degrees = 40; /* the planes make an angle of 33 degrees */
        frame.coarse.criterion = FNL_COARSE_CRITERION_Z;
        check_column(&stage, frame, 33, 1);
        frame.coarse.normal_degrees = 2;
    }
    stage_close(&stage);
}

/* One plane, two materials: nothing but the tolerances tells them apart. */
static void test_materials_apart_CP_5(void **state) {
    UNUSED(state);
    fnl_scene *scene = empty_scene();
    add_plane(scene, add_material(scene, 0.7f, (fnl_image_id){0}), -3, 1 / 32.0f, 0, 0, 0);
    add_plane(scene, add_material(scene, 0.5f, (fnl_image_id){0}), 1 / 32.0f, 3, 0, 0, 0);
    struct stage stage = stage_open_scene(scene);
    fnl_frame frame = front_frame(&stage);
    check_column(&stage, frame, 33, 4);
    frame.coarse.tolerance = 0.25f;
    check_column(&stage, frame, 33, 1);
    stage_close(&stage);
}

/* ---- sizes, counts, lists ---- */

/* What is lit, from the view: blocks once, other pixels each. */
static void check_counts(struct stage *stage, const fnl_frame *frame) {
    struct shot view = shoot_view(stage, *frame, FNL_DEBUG_COARSE_REASON);
    uint32_t size = frame->coarse.size, blocks[5] = {0}, pixels = 0, shaded = 0;
    for (uint32_t y = 0; y < frame->height; y += size)
        for (uint32_t x = 0; x < frame->width; x += size) {
            uint32_t kind = 0, inside = 0;
            for (uint32_t v = y; v < MIN(y + size, frame->height); v++)
                for (uint32_t u = x; u < MIN(x + size, frame->width); u++) {
                    uint32_t k = kind_at(&view.color, u, v);
                    if (k) assert_true(kind == 0 || kind == k);
                    kind = MAX(kind, k);
                    inside += k != 0;
                }
            blocks[kind]++;
            pixels += inside;
            shaded += kind == 1 ? 1 : inside;
        }
    const fnl_frame_stats *s = &view.stats;
    assert_int_equal(s->coarse_pixels, pixels);
    assert_int_equal(s->coarse_shared, blocks[1]);
    assert_int_equal(s->coarse_by_depth, blocks[2]);
    assert_int_equal(s->coarse_by_normal, blocks[3]);
    assert_int_equal(s->coarse_by_material, blocks[4]);
    assert_int_equal(s->coarse_blocks, blocks[1] + blocks[2] + blocks[3] + blocks[4]);
    assert_int_equal(s->coarse_shaded, shaded);
    shot_free(&view);
}

static void test_odd_sizes_CP_7(void **state) {
    UNUSED(state);
    static const uint32_t sizes[][2] = {{1, 1}, {3, 5}, {37, 23}, {65, 33}};
    fnl_scene *scene = empty_scene();
    add_sphere(scene, plain(scene), 0.9f); /* sky round it */
    add_light(scene, FNL_LIGHT_POINT, vec3_make(0.4f, 0.3f, 4), 20);
    assert_int_equal(fnl_scene_set_background(scene, vec3_make(0.1f, 0.2f, 0.3f)), FNL_OK);
    struct stage stage = stage_open_scene(scene);
    for (uint32_t i = 0; i < COUNT_OF(sizes); i++)
        for (uint32_t size = 2; size <= 4; size += 2)
            for (uint32_t criterion = 0; criterion < FNL_COARSE_CRITERION_COUNT; criterion++) {
                fnl_frame frame = front_frame(&stage);
                frame.width = sizes[i][0];
                frame.height = sizes[i][1];
                frame.coarse.size = size;
                frame.coarse.criterion = (fnl_coarse_criterion)criterion;
                check_counts(&stage, &frame);
                frame.coarse.normal_degrees = 0;
                frame.coarse.depth_factor = 0; /* not even the smallest picture has a block of one pixel's width */
                struct shot fine = stage_shoot(&stage, &frame), full = shoot_deferred(&stage, frame);
                if (i > 0) assert_int_equal(count_differing(&fine.radiance, &full.radiance), 0);
                assert_int_equal(count_broken(&fine.radiance), 0);
                shot_free(&fine);
                shot_free(&full);
            }
    stage_close(&stage);
}

static void test_lists_give_one_picture_CP_8(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:hall?lights=1024", 0);
    fnl_frame frame = hall_frame(&stage, 81, 45);
    frame.lists = FNL_LISTS_ALL;
    for (uint32_t split = 0; split < FNL_COARSE_SPLIT_COUNT; split += 2) {
        frame.coarse.split = (fnl_coarse_split)split;
        frame.lists = FNL_LISTS_ALL;
        struct shot all = stage_shoot(&stage, &frame);
        static const fnl_light_lists kinds[] = {FNL_LISTS_TILED, FNL_LISTS_CLUSTERED, FNL_LISTS_BACKFACE, FNL_LISTS_ZBIN};
        for (uint32_t i = 0; i < COUNT_OF(kinds); i++) {
            frame.lists = kinds[i];
            struct shot shot = stage_shoot(&stage, &frame);
            if (count_differing(&shot.radiance, &all.radiance))
                fail_msg("%s, split %u: not the picture of all", fnl_light_lists_name(frame.lists), split);
            shot_free(&shot);
        }
        shot_free(&all);
    }
    stage_close(&stage);
}

static void test_counts_CP_9(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:hall?lights=32", 0);
    for (uint32_t size = 2; size <= 4; size += 2) {
        fnl_frame frame = hall_frame(&stage, 96, 64); /* walls all round, and whole blocks */
        frame.coarse.size = size;
        frame.count_lights = true;
        frame.lists = FNL_LISTS_ALL;
        fnl_frame_stats s = shoot_stats(&stage, &frame);
        uint32_t blocks = 96 * 64 / (size * size), list = s.coarse_blocks - s.coarse_shared;
        assert_int_equal(s.coarse_blocks, blocks);
        assert_true(list > 0 && s.coarse_shared > 0);
        assert_int_equal(s.coarse_shaded, blocks + list * (size * size - 1));
        assert_int_equal(s.evaluations, (uint64_t)s.coarse_shaded * 32); /* lights are visited as often */
        frame.count_lights = false;
        frame.width = 95;
        frame.height = 61;
        check_counts(&stage, &frame);
    }
    stage_close(&stage);
}

/* ---- what blocks share ---- */

static void test_split_sums_CP_10(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:hall?lights=300", 0);
    fnl_frame frame = hall_frame(&stage, 81, 45);
    frame.coarse.filter = FNL_COARSE_FILTER_NONE;
    struct shot full = shoot_deferred(&stage, frame);
    for (uint32_t split = 0; split < FNL_COARSE_SPLIT_COUNT; split++)
        for (uint32_t size = 2; size <= 4; size += 2) {
            frame.coarse.size = size;
            frame.coarse.split = (fnl_coarse_split)split;
            struct shot shot = stage_shoot(&stage, &frame);
            /* At its own pixel a block has what this pixel has at the full rate. */
            double worst = worst_ratio(&shot.radiance, &full.radiance, size);
            if (worst > (split ? 2e-4 : 0)) fail_msg("split %u, size %u: off by %g", split, size, worst);
            assert_true(worst_ratio(&shot.radiance, &full.radiance, 1) > 0.01);
            shot_free(&shot);
        }
    shot_free(&full);
    stage_close(&stage);
}

static fnl_image_id add_noise(fnl_scene *scene) {
    enum { SIDE = 128 };
    static uint8_t texels[SIDE * SIDE * 4];
    struct random_state random = {3};
    for (uint32_t i = 0; i < SIDE * SIDE; i++) {
        uint8_t grey = (uint8_t)random_range(&random, 0, 255);
        memcpy(&texels[4 * i], (uint8_t[4]){grey, grey, grey, 255}, 4);
    }
    fnl_image_id id;
    assert_int_equal(fnl_scene_add_image(scene, &(fnl_image){SIDE, SIDE, FNL_PIXEL_FORMAT_RGBA8, texels}, true, &id),
                     FNL_OK);
    return id;
}

/* What a split makes for each pixel is right at each pixel; without the split it is not. */
static void test_split_pixel_rate_CP_10(void **state) {
    UNUSED(state);
    for (uint32_t split = 1; split < FNL_COARSE_SPLIT_COUNT; split++) {
        fnl_scene *scene = empty_scene();
        float roughness = split == FNL_COARSE_SPLIT_HIGHLIGHTS ? 0.2f : 1;
        bool noise = split == FNL_COARSE_SPLIT_ALBEDO;
        add_plane(scene, add_material(scene, roughness, noise ? add_noise(scene) : (fnl_image_id){0}), -3, 3, 0, 0, 0);
        fnl_light_kind kinds[] = {FNL_LIGHT_POINT, FNL_LIGHT_DIRECTIONAL, FNL_LIGHT_POINT, FNL_LIGHT_SPOT};
        add_light(scene, kinds[split], vec3_make(0, 0, split == FNL_COARSE_SPLIT_SHARP ? 2 : 0.5f), 5);
        struct stage stage = stage_open_scene(scene);
        fnl_frame frame = front_frame(&stage);
        struct shot full = shoot_deferred(&stage, frame), none = stage_shoot(&stage, &frame);
        frame.coarse.split = (fnl_coarse_split)split;
        struct shot shot = stage_shoot(&stage, &frame);
        assert_int_equal(shot.stats.coarse_shared, shot.stats.coarse_blocks);
        double worst = worst_ratio(&shot.radiance, &full.radiance, 1),
               without = worst_ratio(&none.radiance, &full.radiance, 1);
        print_message("split %s: off by %.3g, without by %.3g\n", fnl_coarse_split_name(frame.coarse.split), worst, without);
        if (split == FNL_COARSE_SPLIT_HIGHLIGHTS)
            assert_true(worst < 0.5 * without); /* the diffuse light is still the block's */
        else
            assert_true(worst < 1e-3 && without > 0.1);
        shot_free(&full);
        shot_free(&none);
        shot_free(&shot);
        stage_close(&stage);
    }
}

static void test_splat_and_gather_CP_11(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:hall?lights=100", 0);
    fnl_frame frame = hall_frame(&stage, 81, 45);
    for (uint32_t split = 0; split < FNL_COARSE_SPLIT_COUNT; split++) {
        frame.coarse.split = (fnl_coarse_split)split;
        frame.coarse.gather = false;
        struct shot splat = stage_shoot(&stage, &frame);
        frame.coarse.gather = true;
        struct shot gather = stage_shoot(&stage, &frame);
        assert_int_equal(count_differing(&splat.radiance, &gather.radiance), 0);
        assert_int_equal(splat.stats.coarse_shaded, gather.stats.coarse_shaded);
        assert_true(splat.stats.coarse_shared > 0);
        shot_free(&splat);
        shot_free(&gather);
    }
    stage_close(&stage);
}

/* ---- motion ---- */

/* Mean change of a pixel from frame to frame while the camera moves on by parts of a pixel. */
static double flicker(struct stage *stage, fnl_frame frame) {
    enum { FRAMES = 8 };
    fnl_image last = {0};
    double sum = 0;
    for (int i = 0; i < FRAMES; i++) {
        frame.camera.position.x = frame.camera.target.x = 0.37f / 32 * (float)i;
        struct shot shot = stage_shoot(stage, &frame);
        const float *p = shot.radiance.pixels, *q = last.pixels;
        for (uint32_t k = 0; q && k < 64 * 64; k++) sum += fabs((double)p[4 * k] - q[4 * k]);
        fnl_image_free(gpu_host(harness_device()), &last);
        last = shot.radiance;
        shot.radiance = (fnl_image){0};
        shot_free(&shot);
    }
    fnl_image_free(gpu_host(harness_device()), &last);
    return sum / (64 * 64 * (FRAMES - 1));
}

static void test_filters_calm_motion_CP_12(void **state) {
    UNUSED(state);
    fnl_scene *scene = empty_scene();
    add_plane(scene, add_material(scene, 1, add_noise(scene)), -3, 3, 0, 0, 0); /* 4 texels a pixel */
    assert_int_equal(fnl_scene_set_ambient(scene, vec3_make(1, 1, 1), vec3_make(1, 1, 1)), FNL_OK);
    struct stage stage = stage_open_scene(scene);
    for (uint32_t size = 2; size <= 4; size += 2) {
        fnl_frame frame = front_frame(&stage);
        frame.outputs = FNL_OUTPUT_RADIANCE;
        frame.coarse.size = size;
        frame.coarse.filter = FNL_COARSE_FILTER_NONE;
        double without = flicker(&stage, frame);
        for (uint32_t filter = FNL_COARSE_FILTER_MEAN; filter <= FNL_COARSE_FILTER_SAMPLED; filter++) {
            frame.coarse.filter = (fnl_coarse_filter)filter;
            double with = flicker(&stage, frame);
            print_message("size %u: a pixel changes by %.4f with the base colour %s, by %.4f with the first pixel's\n", size,
                          with, fnl_coarse_filter_name(frame.coarse.filter), without);
            assert_true(with < 0.8 * without);
        }
    }
    stage_close(&stage);
}

/* ---- the other criteria ---- */

/* A plane of two triangles: but for the blocks on the edge between them, z and id find the same. */
static void test_triangles_of_a_plane_CP_13(void **state) {
    UNUSED(state);
    fnl_scene *scene = empty_scene();
    add_plane(scene, plain(scene), -3, 3, 0, 0, 0); /* they meet along the diagonal of the view */
    struct stage stage = stage_open_scene(scene);
    for (uint32_t size = 2; size <= 4; size += 2) {
        fnl_frame frame = front_frame(&stage);
        frame.coarse.size = size;
        frame.coarse.criterion = FNL_COARSE_CRITERION_ID;
        fnl_frame_stats s = shoot_stats(&stage, &frame);
        assert_int_equal(s.coarse_by_depth, 64 / size);
        assert_int_equal(s.coarse_shared, s.coarse_blocks - s.coarse_by_depth);
    }
    stage_close(&stage);
}

static void test_ids_CP_13(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:hall?lights=8", 0);
    fnl_frame frame = hall_frame(&stage, 160, 90);
    struct shot z = shoot_view(&stage, frame, FNL_DEBUG_COARSE_REASON);
    frame.coarse.criterion = FNL_COARSE_CRITERION_ID;
    struct shot id = shoot_view(&stage, frame, FNL_DEBUG_COARSE_REASON);
    uint32_t z_alone = 0, id_alone = 0, both = 0;
    for (uint32_t y = 0; y < 90; y += 2)
        for (uint32_t x = 0; x < 160; x += 2) {
            uint32_t a = kind_at(&z.color, x, y), b = kind_at(&id.color, x, y);
            both += a == 1 && b == 1;
            z_alone += a == 1 && b != 1;
            id_alone += a != 1 && b == 1;
            if (a == 1 && b != 1) assert_int_equal(b, 2); /* smooth across the edge of a triangle, and nothing else */
        }
    print_message("blocks lit once: both %u, z alone %u, id alone %u\n", both, z_alone, id_alone);
    assert_true(both > 100 && z_alone > 0 && id_alone <= both / 200);
    check_counts(&stage, &frame);
    shot_free(&z);
    shot_free(&id);
    stage_close(&stage);
}

static void test_minmax_CP_14(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:hall?lights=8", 0);
    for (uint32_t size = 2; size <= 4; size += 2) {
        fnl_frame frame = hall_frame(&stage, 161, 91);
        frame.coarse.size = size;
        struct shot z = shoot_view(&stage, frame, FNL_DEBUG_COARSE_REASON);
        frame.coarse.criterion = FNL_COARSE_CRITERION_MINMAX;
        struct shot samplers = shoot_view(&stage, frame, FNL_DEBUG_COARSE_REASON);
        stage.renderer->no_minmax = true;
        struct shot loads = shoot_view(&stage, frame, FNL_DEBUG_COARSE_REASON);
        stage.renderer->no_minmax = false;
        uint32_t both = 0, z_alone = 0, beyond = 0;
        for (uint32_t y = 0; y < 91; y += size)
            for (uint32_t x = 0; x < 161; x += size) {
                uint32_t a = kind_at(&z.color, x, y), b = kind_at(&samplers.color, x, y);
                both += a == 1 && b == 1;
                z_alone += a == 1 && b != 1;
                beyond += a != 1 && b == 1;
            }
        print_message("size %u, blocks lit once: both %u, z alone %u, minmax alone %u; the device's samplers: %s\n", size,
                      both, z_alone, beyond, gpu_info(harness_device())->minmax_samplers ? "yes" : "no");
        assert_true(both > 20);
        assert_int_equal(beyond, 0);
        assert_int_equal(count_differing(&samplers.color, &loads.color), 0);
        check_counts(&stage, &frame);
        shot_free(&z);
        shot_free(&samplers);
        shot_free(&loads);
    }
    stage_close(&stage);
}

/* ---- cost, views, occlusion ---- */

/* The least time of a few frames; their picture goes to `out`. */
static double least_time(struct stage *stage, const fnl_frame *frame, struct shot *out) {
    double least = INFINITY;
    for (int i = 0; i < 3; i++) {
        if (i) shot_free(out);
        *out = stage_shoot(stage, frame);
        least = fmin(least, out->stats.gpu_milliseconds);
    }
    return least;
}

static void test_cost_changes_time_alone_CP_15(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:onetile?lights=20", 0);
    fnl_frame frame = hall_frame(&stage, 64, 36);
    frame.timers = true;
    for (uint32_t i = 0; i < 4; i++) {
        frame.shading = i < 2 ? FNL_SHADING_DEFERRED : FNL_SHADING_COARSE;
        if (i == 1) frame.shading = FNL_SHADING_FORWARD;
        frame.coarse.split = i == 3 ? FNL_COARSE_SPLIT_ALBEDO : FNL_COARSE_SPLIT_NONE;
        struct shot cheap, dear;
        frame.shade_cost = 0;
        double before = least_time(&stage, &frame, &cheap);
        frame.shade_cost = 20000;
        double after = least_time(&stage, &frame, &dear);
        assert_int_equal(count_differing(&cheap.radiance, &dear.radiance), 0);
        assert_true(before == 0 || after > 1.5 * before); /* 20000 sines a pixel are not left out */
        shot_free(&cheap);
        shot_free(&dear);
    }
    stage_close(&stage);
}

static void test_views_CP_16(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:hall?lights=8", 0);
    fnl_frame frame = hall_frame(&stage, 80, 44);
    struct shot green = shoot_view(&stage, frame, FNL_DEBUG_COARSE),
                reason = shoot_view(&stage, frame, FNL_DEBUG_COARSE_REASON);
    uint32_t shared = 0, colors[5] = {0};
    for (uint32_t y = 0; y < 44; y++)
        for (uint32_t x = 0; x < 80; x++) {
            uint32_t kind = kind_at(&reason.color, x, y);
            colors[kind]++;
            assert_int_equal(kind_at(&green.color, x, y), kind == 1 ? 1 : 0);
            shared += kind == 1;
        }
    assert_int_equal(shared, 4 * green.stats.coarse_shared);
    for (uint32_t k = 1; k < 5; k++) assert_true(colors[k] > 0);
    frame.shading = FNL_SHADING_DEFERRED;
    frame.debug = FNL_DEBUG_COARSE;
    assert_int_equal(fnl_renderer_render(stage.renderer, &frame), FNL_ERROR_UNSUPPORTED);
    shot_free(&green);
    shot_free(&reason);
    stage_close(&stage);
}

/* The estimator of coarse_ao.comp.glsl in the valley z = 0.8 |x|, in the middle of a pixel of the view of front_frame(). */
static double valley_openness(uint32_t x, uint32_t y, double radius) {
    double px = (x + 0.5) / 32 - 1, py = 1 - (y + 0.5) / 32, pz = 0.8 * fabs(px), length = sqrt(0.8 * 0.8 + 1), sum = 0;
    double normal[2] = {px < 0 ? 0.8 / length : -0.8 / length, 1 / length}, reach = radius * 32;
    double bias = 0.002 * (5 - pz) + 0.01 * radius;
    for (int i = 0; i < 16; i++) {
        double along = (i + 0.5) / 16, turn = i * 2.39996323;
        double u = fmin(fmax(x + round(reach * along * cos(turn)), 0), 63),
               v = fmin(fmax(y + round(reach * along * sin(turn)), 0), 63);
        double qx = (u + 0.5) / 32 - 1, to[3] = {qx - px, 1 - (v + 0.5) / 32 - py, 0.8 * fabs(qx) - pz};
        double distance2 = to[0] * to[0] + to[1] * to[1] + to[2] * to[2], rest = fmax(1 - distance2 / (radius * radius), 0);
        sum += rest * rest * rest * fmax(to[0] * normal[0] + to[2] * normal[1] - bias, 0) /
               (distance2 + 0.01 * radius * radius);
    }
    return fmin(fmax(1 - 2 * radius / 16 * sum, 0), 1);
}

static void test_occlusion_at_coarse_rate_CP_17(void **state) {
    UNUSED(state);
    fnl_scene *scene = empty_scene();
    fnl_material_id material = plain(scene);
    add_plane(scene, material, -3, 0, 0, -0.8f, 0); /* a valley along x = 0 */
    add_plane(scene, material, 0, 3, 0, 0.8f, 0);
    assert_int_equal(fnl_scene_set_ambient(scene, vec3_make(1, 1, 1), vec3_make(1, 1, 1)), FNL_OK);
    struct stage stage = stage_open_scene(scene);
    fnl_frame frame = front_frame(&stage);
    frame.coarse.size = 1;
    struct shot off = stage_shoot(&stage, &frame);
    assert_int_equal(off.stats.coarse_ao_shaded, 0);
    frame.coarse.ao_radius = 0.4f;
    struct shot full = stage_shoot(&stage, &frame);
    assert_int_equal(full.stats.coarse_ao_shaded, 64 * 64);
    const float *a = off.radiance.pixels, *b = full.radiance.pixels;
    for (uint32_t y = 0; y < 64; y++)
        for (uint32_t x = 0; x < 64; x++) {
            size_t i = 4 * (y * 64 + x);
            float distance = fabsf(((float)x + 0.5f) / 32 - 1);
            if (distance < 0.05f) assert_true(b[i] < 0.9f * a[i]);
            if (distance > 0.5f) assert_true(b[i] > 0.99f * a[i]);
            assert_true(fabs((double)b[i] / a[i] - valley_openness(x, y, 0.4)) < 3e-3); /* there is but ambient light */
        }
    for (uint32_t size = 2; size <= 4; size += 2) {
        frame.coarse.size = size;
        frame.coarse.depth_factor = 0; /* no block is alike */
        struct shot fine = stage_shoot(&stage, &frame);
        assert_int_equal(fine.stats.coarse_ao_shaded, 64 * 64);
        assert_int_equal(count_differing(&fine.radiance, &full.radiance), 0);
        shot_free(&fine);
        frame.coarse.depth_factor = 1;
        struct shot shot = stage_shoot(&stage, &frame);
        assert_int_equal(shot.stats.coarse_ao_shaded, shot.stats.coarse_shaded);
        assert_true(shot.stats.coarse_ao_shaded < 64 * 64 / 3);
        double near = psnr(&shot.color, &full.color);
        print_message("size %u: occlusion found %u times for 4096 pixels, %.1f dB\n", size, shot.stats.coarse_ao_shaded,
                      near);
        assert_true(near > 28);
        /* Blocks have the occlusion of their first pixels, whatever else they share. */
        assert_true(worst_ratio(&shot.radiance, &full.radiance, size) < 1e-6);
        frame.coarse.split = FNL_COARSE_SPLIT_ALBEDO;
        struct shot split = stage_shoot(&stage, &frame);
        assert_true(worst_ratio(&split.radiance, &shot.radiance, 1) < 2e-3);
        frame.coarse.split = FNL_COARSE_SPLIT_NONE;
        shot_free(&split);
        shot_free(&shot);
    }
    shot_free(&off);
    shot_free(&full);
    stage_close(&stage);
}

/* What is not seen and not drawn changes nothing, triangle numbers included. */
static void test_culling_changes_nothing_CP_8_ES_79(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:hall?lights=32", 0);
    fnl_frame frame = hall_frame(&stage, 161, 91);
    for (uint32_t criterion = 0; criterion < FNL_COARSE_CRITERION_COUNT; criterion++)
        for (uint32_t size = 2; size <= 4; size += 2) {
            frame.coarse.criterion = (fnl_coarse_criterion)criterion;
            frame.coarse.size = size;
            frame.culling = FNL_CULLING_INSTANCES;
            frame.occlusion = false;
            struct shot whole = stage_shoot(&stage, &frame);
            frame.culling = FNL_CULLING_TRIANGLES;
            for (int occlusion = 0; occlusion < 2; occlusion++) {
                frame.occlusion = occlusion;
                struct shot first = stage_shoot(&stage, &frame); /* the second knows what hid what */
                struct shot shot = stage_shoot(&stage, &frame);
                assert_int_equal(count_differing(&first.radiance, &whole.radiance), 0);
                assert_int_equal(count_differing(&shot.radiance, &whole.radiance), 0);
                assert_int_equal(shot.stats.coarse_shared, whole.stats.coarse_shared);
                assert_int_equal(shot.stats.coarse_shaded, whole.stats.coarse_shaded);
                assert_true(shot.stats.triangles_back > 0 &&
                            (!occlusion || shot.stats.triangles_occluded > 0 || shot.stats.items_occluded > 0));
                shot_free(&first);
                shot_free(&shot);
            }
            shot_free(&whole);
        }
    stage_close(&stage);
}

static void test_cameras_CP_7(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:spheres?lights=20", 0);
    for (uint32_t kind = 0; kind < 4; kind++) {
        fnl_frame frame = hall_frame(&stage, 75, 53);
        fnl_camera *camera = &frame.camera;
        frame.coarse.size = kind % 2 ? 4 : 2;
        frame.gbuffer_prepass = kind == 3;
        if (kind == 0) {
            camera->orthographic = true;
            camera->vertical_extent = 8;
            camera->far_distance = 40;
        } else if (kind == 1) {
            camera->shift = (fnl_vec2){0.7f, -0.4f};
        } else if (kind == 2) { /* nothing but sky */
            camera->target = vec3_add(camera->position, vec3_make(0, 10, 10));
        }
        check_counts(&stage, &frame);
        struct shot shot = stage_shoot(&stage, &frame), full = shoot_deferred(&stage, frame);
        assert_int_equal(count_broken(&shot.radiance), 0);
        double near = psnr(&shot.color, &full.color);
        print_message("camera %u: %u of %u blocks lit once, %.1f dB\n", kind, shot.stats.coarse_shared,
                      shot.stats.coarse_blocks, near);
        assert_true(near > 30);
        shot_free(&shot);
        shot_free(&full);
    }
    stage_close(&stage);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_gradient_is_the_slope_of_a_plane_CP_1, harness_check),
        cmocka_unit_test_teardown(test_size_1_is_deferred_CP_2, harness_check),
        cmocka_unit_test_teardown(test_plane_is_lit_once_per_block_CP_3, harness_check),
        cmocka_unit_test_teardown(test_curved_surface_is_lit_by_pixels_at_0_degrees_CP_4, harness_check),
        cmocka_unit_test_teardown(test_depth_edge_between_parallel_planes_CP_5, harness_check),
        cmocka_unit_test_teardown(test_materials_apart_CP_5, harness_check),
        cmocka_unit_test_teardown(test_crease_CP_6, harness_check),
        cmocka_unit_test_teardown(test_odd_sizes_CP_7, harness_check),
        cmocka_unit_test_teardown(test_cameras_CP_7, harness_check),
        cmocka_unit_test_teardown(test_lists_give_one_picture_CP_8, harness_check),
        cmocka_unit_test_teardown(test_counts_CP_9, harness_check),
        cmocka_unit_test_teardown(test_split_sums_CP_10, harness_check),
        cmocka_unit_test_teardown(test_split_pixel_rate_CP_10, harness_check),
        cmocka_unit_test_teardown(test_splat_and_gather_CP_11, harness_check),
        cmocka_unit_test_teardown(test_filters_calm_motion_CP_12, harness_check),
        cmocka_unit_test_teardown(test_triangles_of_a_plane_CP_13, harness_check),
        cmocka_unit_test_teardown(test_ids_CP_13, harness_check),
        cmocka_unit_test_teardown(test_minmax_CP_14, harness_check),
        cmocka_unit_test_teardown(test_cost_changes_time_alone_CP_15, harness_check),
        cmocka_unit_test_teardown(test_views_CP_16, harness_check),
        cmocka_unit_test_teardown(test_occlusion_at_coarse_rate_CP_17, harness_check),
        cmocka_unit_test_teardown(test_culling_changes_nothing_CP_8_ES_79, harness_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
