/* SPDX-License-Identifier: MIT */
/** Motion vectors and temporal antialiasing: against projection on the CPU, against supersampling, in motion, over cuts. */
#include "fanal/options.h"
#include "passes/aa/taa.h"
#include "tests/temporal_cases.h"
#include "render/view.h"

static double decode(double c) { return c <= 0.04045 ? c / 12.92 : pow((c + 0.055) / 1.055, 2.4); }
static double encode(double c) { return c <= 0.0031308 ? 12.92 * c : 1.055 * pow(c, 1 / 2.4) - 0.055; }

/* ---- pictures of several frames ---- */

/* The mean of tone-mapped light of frames at jittered places, as an RGBA8 picture. */
static fnl_image supersample(fnl_scene *scene, fnl_frame frame, uint32_t count) {
    fnl_renderer *renderer = test_renderer(scene);
    size_t values = (size_t)frame.width * frame.height * 4;
    double *sum = calloc(values, sizeof *sum);
    frame.aa = FNL_ANTIALIASING_NONE;
    frame.outputs = FNL_OUTPUT_COLOR;
    fnl_image image = {0};
    for (uint32_t i = 0; i < count; i++) {
        free_picture(&image);
        frame.jitter = fnl_jitter(i);
        test_render_frame(renderer, &frame);
        image = test_read(renderer, FNL_OUTPUT_COLOR);
        for (size_t k = 0; k < values; k++) sum[k] += decode(((uint8_t *)image.pixels)[k] / 255.0);
    }
    for (size_t k = 0; k < values; k++) ((uint8_t *)image.pixels)[k] = (uint8_t)lrint(encode(sum[k] / count) * 255);
    free(sum);
    fnl_renderer_destroy(&renderer);
    return image;
}

static double mean_difference(const fnl_image *a, const fnl_image *b) {
    size_t values = (size_t)a->width * a->height * 4;
    double sum = 0;
    for (size_t i = 0; i < values; i++) sum += abs(((uint8_t *)a->pixels)[i] - ((uint8_t *)b->pixels)[i]);
    return sum / (double)(values / 4 * 3);
}

/* ---- jitter ---- */

static void test_jitter_fills_the_pixel_ES_21(void **state) {
    UNUSED(state);
    assert_true(fabsf(pixel_jitter(0).x) < 1e-6f && fabsf(pixel_jitter(0).y) < 1e-6f);
    uint32_t cells[8][8] = {{0}}, empty = 0;
    double x = 0, y = 0;
    for (uint32_t i = 0; i < 64; i++) {
        fnl_vec2 j = fnl_jitter(i);
        assert_true(j.x >= -0.5f && j.x < 0.5f && j.y >= -0.5f && j.y < 0.5f);
        cells[(int)((j.x + 0.5f) * 8)][(int)((j.y + 0.5f) * 8)]++;
        x += j.x;
        y += j.y;
    }
    for (int i = 0; i < 64; i++) empty += cells[i / 8][i % 8] == 0;
    assert_true(fabs(x / 64) < 0.02 && fabs(y / 64) < 0.02);
    assert_true(empty < 20); /* of random points 23 would be */
}

/* The image moves against the jitter by as much, whatever the projection; lists give brute force's bits there too. */
static void test_jitter_moves_the_picture_ES_21(void **state) {
    UNUSED(state);
    fnl_scene *scene = fence();
    for (int projection = 0; projection < 3; projection++) {
        fnl_frame frame = fence_frame(FNL_OUTPUT_RADIANCE | FNL_OUTPUT_POSITION);
        if (projection == 1) frame.camera.shift = (vec2){0.2f, -0.3f};
        if (projection == 2) {
            frame.camera.orthographic = true;
            frame.camera.vertical_extent = 5;
            frame.camera.far_distance = 30;
        }
        fnl_renderer *renderer = test_renderer(scene);
        frame.jitter = (vec2){3, -2}; /* whole pixels, to compare with neighbours */
        test_render_frame(renderer, &frame);
        fnl_image moved = test_read(renderer, FNL_OUTPUT_POSITION);
        frame.jitter = (vec2){0, 0};
        test_render_frame(renderer, &frame);
        fnl_image plain = test_read(renderer, FNL_OUTPUT_POSITION);
        uint32_t compared = 0, off = 0;
        for (uint32_t y = 2; y < HEIGHT - 2; y++)
            for (uint32_t x = 3; x < WIDTH - 3; x++) {
                const float *a = test_pixel(&moved, x, y), *b = test_pixel(&plain, x + 3, y - 2);
                if (a[3] == 0 && b[3] == 0) continue;
                compared++;
                off += a[3] != b[3] || vec3_distance((vec3){a[0], a[1], a[2]}, (vec3){b[0], b[1], b[2]}) >
                                           1e-3f; /* edges may fall either way */
            }
        assert_true(compared > 300);
        assert_true(off < compared / 50);
        free_picture(&moved);
        free_picture(&plain);
        frame.jitter = (vec2){0.31f, -0.23f};
        frame.outputs = FNL_OUTPUT_RADIANCE;
        fnl_image all = {0};
        for (int lists = 0; lists < FNL_LISTS_AUTO; lists++) {
            frame.lists = (fnl_light_lists)lists;
            frame.shading = FNL_SHADING_FORWARD_PREPASS;
            test_render_frame(renderer, &frame);
            fnl_image image = test_read(renderer, FNL_OUTPUT_RADIANCE);
            if (lists == 0) {
                all = image;
                continue;
            }
            assert_true(test_equal(&all, &image));
            free_picture(&image);
        }
        free_picture(&all);
        fnl_renderer_destroy(&renderer);
    }
    fnl_scene_destroy(&scene);
}

/* ---- a camera at rest ---- */

static fnl_image collect(fnl_scene *scene, fnl_frame frame, uint32_t count) {
    fnl_renderer *renderer = test_renderer(scene);
    frame.aa = FNL_ANTIALIASING_TAA;
    for (uint32_t i = 0; i < count; i++) test_render_frame(renderer, &frame);
    fnl_image image = test_read(renderer, FNL_OUTPUT_COLOR);
    fnl_renderer_destroy(&renderer);
    return image;
}

static void test_still_converges_to_supersampling_ES_21(void **state) {
    UNUSED(state);
    fnl_scene *scene = fence();
    for (int i = 0; i < FNL_SHADING_AUTO; i++) {
        fnl_frame frame = fence_frame(FNL_OUTPUT_COLOR);
        frame.shading = (fnl_shading)i;
        if (i == 1) frame.camera.shift = (vec2){0.2f, 0.1f};
        /* The first three have 64 frames; means of fewer are means too. One order shows the way there. */
        uint32_t most = i <= FNL_SHADING_DEFERRED ? 64 : 8;
        fnl_image reference = supersample(scene, frame, most);
        double error[4] = {3, 2, 1.5, 0};
        const uint32_t counts[4] = {1, 4, 16, most};
        for (int k = i ? 3 : 0; k < 4; k++) {
            fnl_image image = collect(scene, frame, counts[k]);
            error[k] = mean_difference(&image, &reference);
            free_picture(&image);
        }
        if (i == 0)
            print_message("off 64x supersampling by %.2f, %.2f, %.2f of 255 after 1, 4, 16 frames\n", error[0], error[1],
                          error[2]);
        print_message("%s: by %.2f after %u\n", fnl_value_name(FNL_ENUM_SHADING, (fnl_shading)i), error[3], most);
        assert_true(error[3] < 1);
        assert_true(error[2] < error[1] && error[1] < error[0]);
        free_picture(&reference);
    }
    fnl_scene_destroy(&scene);
}

/* A white half-plane whose border leans by one pixel in eight rows: each row is lighter than the last, by an eighth. */
static void test_near_vertical_edge_ramps_ES_21(void **state) {
    UNUSED(state);
    fnl_scene *scene = test_scene();
    struct scene_material white = test_unlit(1, 1, 1);
    uint32_t mesh = test_quad_mesh(scene, scene_add_material(scene, &white));
    mat4 m = mat4_mul(mat4_from_trs((vec3){0, 0, 0}, quat_axis_angle((vec3){0, 0, 1}, -atanf(1.0f / 8)), (vec3){1, 1, 1}),
                      mat4_from_trs((vec3){1, 0, 0}, quat_identity(), (vec3){1, 4, 1}));
    scene_add_node(scene, "", SCENE_NONE, &m, mesh);
    fnl_frame frame = test_frame(FNL_OUTPUT_COLOR); /* 64 x 64, two units wide */
    fnl_image image = collect(scene, frame, 64);
    for (uint32_t y = 8; y < 56; y++) {
        double covered = 0, exact = 0;
        for (uint32_t x = 0; x < 48; x++) covered += decode(test_pixel8(&image, x, y)[0] / 255.0);
        exact = 48 - (32 + (31.5 - y) / 8.0);
        assert_true(fabs(covered - exact) < 0.06);
    }
    uint32_t x = 31;
    for (uint32_t y = 33; y < 39; y++) { /* where the border crosses this column */
        double a = decode(test_pixel8(&image, x, y)[0] / 255.0), b = decode(test_pixel8(&image, x, y + 1)[0] / 255.0);
        assert_true(b > a + 0.06 && b < a + 0.19);
    }
    free_picture(&image);
    fnl_scene_destroy(&scene);
}

/* ---- motion ---- */

/* What stands still, by where the CPU sees its positions in the last frame. */
static void test_motion_of_the_camera_ES_21(void **state) {
    UNUSED(state);
    fnl_scene *scene = fence();
    for (int projection = 0; projection < 3; projection++) {
        fnl_frame frame = fence_frame(FNL_OUTPUT_MOTION | FNL_OUTPUT_POSITION | FNL_OUTPUT_NORMAL | FNL_OUTPUT_COLOR);
        fnl_renderer *renderer = test_renderer(scene);
        frame.aa = projection == 0 ? FNL_ANTIALIASING_TAA : FNL_ANTIALIASING_NONE;
        if (projection == 1) frame.camera.shift = (vec2){0.2f, -0.3f};
        if (projection == 2) {
            frame.camera.orthographic = true;
            frame.camera.vertical_extent = 5;
            frame.camera.far_distance = 30;
        }
        test_render_frame(renderer, &frame);
        fnl_image first = test_read(renderer, FNL_OUTPUT_MOTION);
        for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) assert_true(test_pixel(&first, i % WIDTH, i / WIDTH)[3] == 0);
        free_picture(&first);
        struct gpu_view before = view_from_camera(&frame.camera, WIDTH, HEIGHT);
        frame.camera.position = (vec3){0.6f, 0.5f, 5.7f};
        frame.camera.target = (vec3){0.05f, 0, 0};
        frame.camera.vertical_fov *= 1.05f;
        vec2 jitter = projection == 0 ? pixel_jitter(1) : (vec2){0, 0};
        test_render_frame(renderer, &frame);
        fnl_image motion = test_read(renderer, FNL_OUTPUT_MOTION), position = test_read(renderer, FNL_OUTPUT_POSITION);
        double worst = 0, fastest = 0;
        for (uint32_t y = 0; y < HEIGHT; y++)
            for (uint32_t x = 0; x < WIDTH; x++) {
                const float *m = test_pixel(&motion, x, y), *p = test_pixel(&position, x, y);
                assert_true(m[3] == 1);
                fastest = fmax(fastest, hypot(m[0], m[1]));
                if (p[3] == 0) {
                    if (projection < 2) assert_true(m[2] == 1e30f);
                    continue;
                }
                vec3 v = mat4_point(&before.world_to_view, (vec3){p[0], p[1], p[2]});
                float spread = projection == 2 ? 1 : -v.z;
                double qx = ((v.x / spread - before.ndc_offset.x) / before.ndc_scale.x * 0.5 + 0.5) * WIDTH,
                       qy = (0.5 - (v.y / spread - before.ndc_offset.y) / before.ndc_scale.y * 0.5) * HEIGHT;
                worst = fmax(worst, hypot(qx - (x + 0.5 + jitter.x) - m[0], qy - (y + 0.5 + jitter.y) - m[1]));
                worst = fmax(worst, fabs(m[2] + v.z));
            }
        print_message("motion of up to %.2f pixels is off by %.2g\n", fastest, worst);
        assert_true(worst < 0.01 && fastest > 2);
        free_picture(&motion);
        free_picture(&position);
        fnl_renderer_destroy(&renderer);
    }
    fnl_scene_destroy(&scene);
}

/* A quad that moves before one at rest, through three frames; and rest again. */
static void test_motion_of_objects_ES_21(void **state) {
    UNUSED(state);
    fnl_scene *scene = test_scene();
    struct scene_material white = test_unlit(1, 1, 1);
    uint32_t mesh = test_quad_mesh(scene, scene_add_material(scene, &white));
    uint32_t moving = test_place(scene, mesh, (vec3){-0.5f, 0, 0.5f}, (vec3){0.2f, 0.2f, 1});
    test_place(scene, mesh, (vec3){0, 0, 0}, (vec3){0.9f, 0.9f, 1});
    scene_update_transforms(scene);
    for (int order = FNL_SHADING_FORWARD; order <= FNL_SHADING_DEFERRED; order++) {
        fnl_renderer *renderer = test_renderer(scene);
        fnl_frame frame = test_frame(FNL_OUTPUT_MOTION);
        frame.shading = (fnl_shading)order;
        static const float places[] = {-0.5f, -0.25f, 0, 0, -0.5f};
        static const float expected[] = {0, -8, -8, 0, 16};
        for (int i = 0; i < 5; i++) {
            mat4 m = mat4_from_trs((vec3){places[i], 0, 0.5f}, quat_identity(), (vec3){0.2f, 0.2f, 1});
            scene_move_nodes(scene, &(fnl_instance_id){.index = moving}, &m, 1);
            test_render_frame(renderer, &frame);
            fnl_image motion = test_read(renderer, FNL_OUTPUT_MOTION);
            assert_pixel(&motion, (uint32_t)(32 + places[i] * 32), 32, expected[i], 0, 4.5, 1e-4);
            float own = test_pixel(&motion, (uint32_t)(32 + places[i] * 32), 32)[3];
            assert_true(fabs(own - (i ? 1 + fabsf(expected[i]) : 0)) < 1e-3);
            assert_pixel(&motion, 5, 5, 0, 0, 5, 1e-4);
            free_picture(&motion);
        }
        fnl_renderer_destroy(&renderer);
    }
    fnl_scene_destroy(&scene);
}


/* A square that its morph target and its node move at once, and one beside it that only its target moves. */
static void test_motion_of_deformed_vertices_ES_21(void **state) {
    UNUSED(state);
    fnl_scene *scene = test_scene();
    uint32_t mesh = morphed_square(scene), nodes[2];
    for (int i = 0; i < 2; i++) nodes[i] = test_place(scene, mesh, (vec3){-0.4f, i ? -0.5f : 0.3f, 0}, (vec3){1, 1, 1});
    scene_update_transforms(scene);
    fnl_renderer *renderer = test_renderer(scene);
    fnl_frame frame = test_frame(FNL_OUTPUT_MOTION);
    static const float weights[4] = {0, 0.5f, 1, 1};
    for (int i = 0; i < 4; i++) {
        float x = -0.4f + 0.125f * (float)i;
        for (int n = 0; n < 2; n++) set_weight(scene, nodes[n], weights[i]);
        mat4 m = mat4_from_trs((vec3){x, 0.3f, 0}, quat_identity(), (vec3){1, 1, 1});
        assert_int_equal(fnl_scene_set_instance_transform(scene, id_of(scene, nodes[0]), &m), FNL_OK);
        test_render_frame(renderer, &frame);
        fnl_image motion = test_read(renderer, FNL_OUTPUT_MOTION);
        /* 32 pixels a unit; a half of the target is 4 pixels to the right and 2 up, the node's step 4 to the right. */
        float morph = i == 1 || i == 2 ? 1.0f : 0.0f, shift = weights[i] * 0.25f, rise = weights[i] * 0.125f;
        assert_pixel(&motion, (uint32_t)(32 + (x + shift) * 32), (uint32_t)(32 - (0.3f + rise) * 32), i ? -4 - 4 * morph : 0,
                     2 * morph, 5, 1e-3);
        assert_pixel(&motion, (uint32_t)(32 + (-0.4f + shift) * 32), (uint32_t)(32 - (-0.5f + rise) * 32), -4 * morph,
                     2 * morph, 5, 1e-3);
        free_picture(&motion);
    }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* A bright square crosses a dark striped wall; four frames after it left a pixel, nothing of it is to be seen. */
static void test_no_trail_after_four_frames_ES_21(void **state) {
    UNUSED(state);
    for (int textured = 0; textured < 2; textured++) {
        fnl_scene *scene = test_scene();
        struct scene_material bright = test_unlit(20, 18, 15), dark = test_unlit(0.02f, 0.02f, 0.03f),
                              grey = test_unlit(0.08f, 0.07f, 0.05f);
        uint32_t moving = test_place(scene, test_quad_mesh(scene, scene_add_material(scene, &bright)),
                                     (vec3){-0.9f, 0, 0.5f}, (vec3){0.15f, 0.3f, 1});
        test_place(scene, test_quad_mesh(scene, scene_add_material(scene, &dark)), (vec3){0, 0, 0}, (vec3){1.5f, 1.5f, 1});
        uint32_t stripes = test_quad_mesh(scene, scene_add_material(scene, &grey));
        for (int i = 0; textured && i < 20; i++)
            test_place(scene, stripes, (vec3){-0.95f + 0.1f * (float)i, 0, 0.1f}, (vec3){0.02f, 1, 1});
        fnl_renderer *renderer = test_renderer(scene);
        fnl_frame frame = test_frame(FNL_OUTPUT_COLOR);
        frame.aa = FNL_ANTIALIASING_TAA;
        frame.tonemap = FNL_TONEMAP_KHRONOS_NEUTRAL;
        fnl_frame still = frame;
        enum { STEPS = 16 };
        float places[STEPS];
        for (int i = 0; i < STEPS; i++) places[i] = -0.9f + 0.09f * (float)i; /* about three pixels a frame */
        fnl_image last = {0};
        for (int i = 0; i < STEPS; i++) {
            mat4 m = mat4_from_trs((vec3){places[i], 0, 0.5f}, quat_identity(), (vec3){0.15f, 0.3f, 1});
            scene_move_nodes(scene, &(fnl_instance_id){.index = moving}, &m, 1);
            test_render_frame(renderer, &frame);
            free_picture(&last);
            last = test_read(renderer, FNL_OUTPUT_COLOR);
        }
        fnl_image reference = supersample(scene, still, 64);
        double worst = 0;
        /* Columns that the square left at least four frames ago. */
        float left = places[STEPS - 1 - 4] - 0.15f;
        for (uint32_t y = 10; y < 54; y++)
            for (uint32_t x = 1; x < (uint32_t)((left + 1) * 32) - 1; x++)
                for (int c = 0; c < 3; c++) {
                    int a = test_pixel8(&last, x, y)[c], b = test_pixel8(&reference, x, y)[c];
                    if (!textured) worst = fmax(worst, abs(a - b));
                    /* Stripes are still collecting samples: what remains of the square would be far brighter than them. */
                    if (textured) worst = fmax(worst, a - 255 * encode(0.08) > 0 ? a - 255 * encode(0.08) : 0);
                }
        print_message("%s wall: at most %.1f of 255 four frames later\n", textured ? "striped" : "plain", worst);
        assert_true(worst <= 2);
        free_picture(&last);
        free_picture(&reference);
        fnl_renderer_destroy(&renderer);
        fnl_scene_destroy(&scene);
    }
}

/* A grey square leaves a wall of black and white stripes, all within their spread of colours: depth alone tells that it is gone. */
static void test_no_trail_within_the_spread_ES_21(void **state) {
    UNUSED(state);
    fnl_scene *scene = test_scene();
    struct scene_material grey = test_unlit(0.25f, 0.25f, 0.25f), white = test_unlit(0.7f, 0.7f, 0.7f);
    uint32_t moving = test_place(scene, test_quad_mesh(scene, scene_add_material(scene, &grey)), (vec3){-0.6f, 0, 2},
                                 (vec3){0.2f, 0.9f, 1});
    uint32_t stripe = test_quad_mesh(scene, scene_add_material(scene, &white));
    for (int i = 0; i < 16; i++)
        test_place(scene, stripe, (vec3){-0.96875f + 0.125f * (float)i, 0, 0}, (vec3){0.03125f, 1, 1});
    fnl_renderer *renderer = test_renderer(scene);
    fnl_frame frame = test_frame(FNL_OUTPUT_COLOR);
    frame.aa = FNL_ANTIALIASING_TAA;
    fnl_image last = {0};
    for (int i = 0; i < 13; i++) {
        mat4 m =
            mat4_from_trs((vec3){i < 9 ? -0.6f + 0.0625f * (float)i : 0.5f, 0, 2}, quat_identity(), (vec3){0.2f, 0.9f, 1});
        scene_move_nodes(scene, &(fnl_instance_id){.index = moving}, &m, 1);
        test_render_frame(renderer, &frame);
        free_picture(&last);
        last = test_read(renderer, FNL_OUTPUT_COLOR);
    }
    /* Stripes are two pixels wide: their middle lies on the border of the two, and jitter never reaches the neighbours'. */
    for (uint32_t y = 12; y < 52; y++)
        for (uint32_t x = 26; x < 38; x++) {
            double value = decode(test_pixel8(&last, x, y)[0] / 255.0), expected = x % 4 < 2 ? 0.7 : 0;
            assert_true(fabs(value - expected) < 0.02);
        }
    free_picture(&last);
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* The camera moves past a pane at rest: what it uncovers of the wall has no history, and shows this frame's sample to the bit. */
static void test_uncovered_wall_has_no_history_ES_21(void **state) {
    UNUSED(state);
    fnl_scene *scene = test_scene();
    struct scene_material grey = test_unlit(0.25f, 0.25f, 0.25f), wall = test_unlit(0.1f, 0.3f, 0.2f);
    test_place(scene, test_quad_mesh(scene, scene_add_material(scene, &grey)), (vec3){0, 0, 2}, (vec3){0.4f, 1, 1});
    test_place(scene, test_quad_mesh(scene, scene_add_material(scene, &wall)), (vec3){0, 0, -3}, (vec3){9, 9, 1});
    fnl_renderer *renderer = test_renderer(scene), *plain = test_renderer(scene);
    fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE | FNL_OUTPUT_POSITION);
    frame.camera = fnl_camera_default();
    frame.camera.position = (vec3){0, 0, 5};
    frame.camera.target = (vec3){0, 0, 0};
    frame.aa = FNL_ANTIALIASING_TAA;
    test_render_frame(renderer, &frame);
    fnl_image before = test_read(renderer, FNL_OUTPUT_POSITION);
    struct gpu_view view = view_from_camera(&frame.camera, 64, 64);
    frame.camera.position.x = frame.camera.target.x = 0.6f;
    test_render_frame(renderer, &frame);
    fnl_image radiance = test_read(renderer, FNL_OUTPUT_RADIANCE), now = test_read(renderer, FNL_OUTPUT_POSITION);
    frame.aa = FNL_ANTIALIASING_NONE;
    frame.jitter = pixel_jitter(1);
    test_render_frame(plain, &frame);
    fnl_image sample = test_read(plain, FNL_OUTPUT_RADIANCE);
    uint32_t uncovered = 0, kept = 0;
    for (uint32_t y = 10; y < 54; y++)
        for (uint32_t x = 4; x < 60; x++) {
            const float *p = test_pixel(&now, x, y);
            vec3 v = mat4_point(&view.world_to_view, (vec3){p[0], p[1], p[2]});
            int qx = (int)floor((-v.x / v.z / view.ndc_scale.x * 0.5f + 0.5f) * 64),
                qy = (int)floor((0.5f + v.y / v.z / view.ndc_scale.y * 0.5f) * 64);
            if (qx < 3 || qx > 60 || qy < 3 || qy > 60) continue;
            bool wall_now = true, pane_before = true, wall_before = true;
            for (int k = 0; k < 25; k++) {
                float n = test_pixel(&now, x + (uint32_t)(k % 5) - 2, y + (uint32_t)(k / 5) - 2)[2],
                      b = test_pixel(&before, (uint32_t)(qx + k % 5 - 2), (uint32_t)(qy + k / 5 - 2))[2];
                wall_now = wall_now && n < 0;
                pane_before = pane_before && b > 0;
                wall_before = wall_before && b < 0;
            }
            bool same = memcmp(test_pixel(&radiance, x, y), test_pixel(&sample, x, y), 12) == 0;
            if (wall_now && pane_before) {
                uncovered++;
                assert_true(same);
            }
            kept += wall_now && wall_before;
        }
    assert_true(uncovered > 50 && kept > 500);
    free_picture(&before);
    free_picture(&radiance);
    free_picture(&now);
    free_picture(&sample);
    fnl_renderer_destroy(&renderer);
    fnl_renderer_destroy(&plain);
    fnl_scene_destroy(&scene);
}

/* While the camera moves pictures are nearer to supersampled ones than without. */
static void test_moving_camera_ES_21(void **state) {
    UNUSED(state);
    fnl_scene *scene = fence();
    fnl_renderer *renderer = test_renderer(scene), *plain = test_renderer(scene);
    double errors[2] = {0};
    for (int i = 0; i < 20; i++) {
        fnl_frame frame = fence_frame(FNL_OUTPUT_COLOR);
        frame.camera.position.x += 0.03f * (float)i;
        frame.camera.position.z -= 0.02f * (float)i;
        frame.aa = FNL_ANTIALIASING_TAA;
        test_render_frame(renderer, &frame);
        if (i % 5 != 4) continue;
        fnl_image with = test_read(renderer, FNL_OUTPUT_COLOR), reference = supersample(scene, frame, 32);
        frame.aa = FNL_ANTIALIASING_NONE;
        test_render_frame(plain, &frame);
        fnl_image without = test_read(plain, FNL_OUTPUT_COLOR);
        errors[0] += mean_difference(&without, &reference) / 4;
        errors[1] += mean_difference(&with, &reference) / 4;
        free_picture(&with);
        free_picture(&without);
        free_picture(&reference);
    }
    print_message("moving camera: off by %.2f of 255 with, by %.2f without\n", errors[1], errors[0]);
    assert_true(errors[1] < 0.6 * errors[0]);
    fnl_renderer_destroy(&plain);
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* One pixel, no lights, an empty scene, a background at infinity, every method, and what is refused. */
static void test_limits(void **state) {
    UNUSED(state);
    fnl_scene *scene = test_scene();
    fnl_renderer *renderer = test_renderer(scene);
    assert_int_equal(fnl_scene_set_background(scene, (vec3){6e4f, 0.5f, 0}), FNL_OK);
    for (uint32_t size = 1; size < 40; size += 17)
        for (int aa = 0; aa < FNL_ANTIALIASING_COUNT; aa++)
            for (int i = 0; i < 4; i++) {
                fnl_frame frame = fence_frame(FNL_OUTPUT_COLOR | FNL_OUTPUT_RADIANCE);
                frame.width = size;
                frame.height = size / 2 + 1;
                frame.aa = (fnl_antialiasing)aa;
                frame.camera.position.x += (float)i;
                frame.exposure = i % 2 ? FNL_EXPOSURE_AUTO : FNL_EXPOSURE_NONE;
                frame.debug = i == 3 ? FNL_DEBUG_MOTION : FNL_DEBUG_NONE;
                test_render_frame(renderer, &frame);
                fnl_image radiance = test_read(renderer, FNL_OUTPUT_RADIANCE);
                for (uint32_t p = 0; p < frame.width * frame.height; p++) {
                    const float *c = test_pixel(&radiance, p % frame.width, p / frame.width);
                    assert_true(fabs(c[0] / 6e4 - 1) < 1e-2 && fabs(c[1] - 0.5) < 6 && fabs(c[2]) < 6);
                }
                free_picture(&radiance);
            }
    fnl_frame frame = fence_frame(FNL_OUTPUT_COLOR);
    frame.aa = FNL_ANTIALIASING_COUNT;
    assert_int_equal(fnl_renderer_render(renderer, &frame), FNL_ERROR_INVALID);
    frame.aa = FNL_ANTIALIASING_TAA;
    frame.jitter.x = NAN;
    assert_int_equal(fnl_renderer_render(renderer, &frame), FNL_ERROR_INVALID);
    frame.jitter.x = 0;
    frame.msaa = 4;
    assert_int_equal(fnl_renderer_render(renderer, &frame), FNL_ERROR_UNSUPPORTED);
    assert_string_equal(fnl_value_name(FNL_ENUM_ANTIALIASING, FNL_ANTIALIASING_SMAA), "smaa");
    assert_null(fnl_value_name(FNL_ENUM_ANTIALIASING, FNL_ANTIALIASING_COUNT));
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* A view counts as still until something changes that its pixels show: any option, the scene's reflection probes. */
static void test_changes_end_stillness(void **state) {
    UNUSED(state);
    struct stage s = stage_open("builtin:room?lights=3", 0);
    fnl_probe_params probe = fnl_probe_params_default();
    fnl_probe_id id;
    probe.reflection = true;
    probe.half_size = (fnl_vec3){1, 1, 1};
    assert_int_equal(fnl_scene_add_probe(s.scene, &probe, &id), FNL_OK);
    s.frame.aa = FNL_ANTIALIASING_TAA;
    s.frame.shadows = FNL_SHADOWS_MAPS;
    const char *const changes[][2] = {{"shadow.contact-length", "0.1"}, {"shadows", "rays"}, {"reflections.parallax", "off"}, {"decals", "off"}, {NULL, NULL}, {"gbuffer.layout", "siege"}};
    for (size_t i = 0; i < COUNT_OF(changes); i++) {
        for (int k = 0; k < 4; k++) { /* neither of these is a change */
            fnl_frame frame = s.frame;
            frame.reset_history = k == 1;
            frame.jitter.x = 0.1f * (float)k;
            assert_int_equal(fnl_renderer_render(s.renderer, &frame), FNL_OK);
        }
        assert_int_equal(s.renderer->last.data[0].temporal.still, 2);
        probe.intensity += 0.1f;
        if (changes[i][0])
            assert_int_equal(fnl_frame_set(NULL, &s.frame, changes[i][0], changes[i][1]), FNL_OK);
        else
            assert_int_equal(fnl_scene_set_probe(s.scene, id, &probe), FNL_OK);
        assert_int_equal(fnl_renderer_render(s.renderer, &s.frame), FNL_OK);
        assert_int_equal(s.renderer->last.data[0].temporal.still, 0);
    }
    stage_close(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_jitter_fills_the_pixel_ES_21),
        cmocka_unit_test(test_jitter_moves_the_picture_ES_21),
        cmocka_unit_test(test_still_converges_to_supersampling_ES_21),
        cmocka_unit_test(test_near_vertical_edge_ramps_ES_21),
        cmocka_unit_test(test_motion_of_the_camera_ES_21),
        cmocka_unit_test(test_motion_of_objects_ES_21),
        cmocka_unit_test(test_motion_of_deformed_vertices_ES_21),
        cmocka_unit_test(test_no_trail_after_four_frames_ES_21),
        cmocka_unit_test(test_no_trail_within_the_spread_ES_21),
        cmocka_unit_test(test_uncovered_wall_has_no_history_ES_21),
        cmocka_unit_test(test_moving_camera_ES_21),
        cmocka_unit_test(test_changes_end_stillness),
        cmocka_unit_test(test_limits),
    };
    int failed = _cmocka_run_group_tests("temporal", tests, COUNT_OF(tests), test_group_begin, NULL);
    return failed + _cmocka_run_group_tests("temporal: history", history_tests, history_test_count, NULL, test_group_end); /* one device */
}
