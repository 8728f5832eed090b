/* SPDX-License-Identifier: MIT */
/**
 * Blended surfaces against what each pixel shows by geometry: flat squares of plain colours, seen straight on from +Z, blended on the CPU
 * in the order of their depths at every sample. Lit glass is in transparency_lights_test.c.
 */
#include "render/shading.h"
#include "tests/render_test.h"

enum { SIZE = 64, SQUARES_MAX = 256 };

struct square {
    mat4 place; /* of the unit square from -1 to 1 */
    vec4 color; /* alpha 1: opaque */
};

static struct square square(vec3 position, vec3 axis, float angle, vec3 scale, vec4 color) {
    return (struct square){mat4_from_trs(position, quat_axis_angle(vec3_normalize(axis), angle), scale), color};
}

static void add_square(fnl_scene *scene, const struct square *s) {
    struct scene_material material = test_unlit(s->color.x, s->color.y, s->color.z);
    material.base_color.w = s->color.w;
    material.alpha_mode = s->color.w < 1 ? FNL_ALPHA_BLEND : FNL_ALPHA_OPAQUE;
    material.double_sided = true;
    scene_add_node(scene, "", SCENE_NONE, &s->place, test_quad_mesh(scene, scene_add_material(scene, &material)));
}

static fnl_scene *scene_of(const struct square *squares, uint32_t count) {
    fnl_scene *scene = test_scene();
    scene->background = (vec3){0.05f, 0.1f, 0.2f};
    for (uint32_t i = 0; i < count; i++) add_square(scene, &squares[i]);
    return scene;
}

/* ---- the oracle ---- */

struct hit {
    double z;
    vec4 color;
};

/* Height of the square above (x, y). 0: missed, -1: too near to an edge to tell. */
static int hit_square(const struct square *s, double x, double y, double *z) {
    vec3 o = mat4_point(&s->place, (vec3){0, 0, 0}), a = vec3_sub(mat4_point(&s->place, (vec3){1, 0, 0}), o),
         b = vec3_sub(mat4_point(&s->place, (vec3){0, 1, 0}), o);
    double det = (double)a.x * b.y - (double)a.y * b.x, px = x - o.x, py = y - o.y;
    if (fabs(det) < 1e-3) return -1;
    double u = (px * b.y - py * b.x) / det, v = (a.x * py - a.y * px) / det, outside = fmax(fabs(u), fabs(v)) - 1;
    *z = o.z + u * a.z + v * b.z;
    if (fabs(outside) < 0.02) return -1; /* rasterisers round corners to 1/256 pixel */
    return outside < 0;
}

/* What is seen at a point; false where squares are too close to tell. `layers` is increased by blended squares that show. */
static bool look(const struct square *squares, uint32_t count, double x, double y, double out[3], uint32_t *layers) {
    static struct hit hits[SQUARES_MAX];
    const vec3 background = {0.05f, 0.1f, 0.2f};
    double opaque_z = -1e9;
    vec4 opaque = {background.x, background.y, background.z, 1};
    uint32_t n = 0;
    for (uint32_t i = 0; i < count; i++) {
        double z;
        int met = hit_square(&squares[i], x, y, &z);
        if (met < 0) return false;
        if (!met) continue;
        hits[n++] = (struct hit){z, squares[i].color};
        if (squares[i].color.w == 1 && z > opaque_z) {
            opaque_z = z;
            opaque = squares[i].color;
        }
    }
    out[0] = opaque.x, out[1] = opaque.y, out[2] = opaque.z;
    for (uint32_t i = 1; i < n; i++)
        for (uint32_t j = i; j > 0 && hits[j].z < hits[j - 1].z; j--) {
            struct hit h = hits[j];
            hits[j] = hits[j - 1];
            hits[j - 1] = h;
        }
    for (uint32_t i = 0; i < n; i++) {
        if (i > 0 && hits[i].z - hits[i - 1].z < 1e-4 && hits[i].z > opaque_z - 1e-3) return false;
        if (hits[i].color.w == 1 || hits[i].z < opaque_z) continue;
        double a = hits[i].color.w, c[3] = {hits[i].color.x, hits[i].color.y, hits[i].color.z};
        for (int k = 0; k < 3; k++) out[k] += a * (c[k] - out[k]);
        (*layers)++;
    }
    return true;
}

/*
 * The same as weighted blending defines it: what is left open of the opaque surface, and the mean of the blended ones by coverage over the square
 * of the view depth, which is that in the middle of the pixel, (mid_x, mid_y).
 */
static bool look_weighted(const struct square *squares, uint32_t count, double x, double y, double mid_x, double mid_y, bool half,
                          double out[3]) {
    double opaque_z = -1e9, sum[4] = {0}, open = 1;
    uint32_t layers = 0;
    if (!look(squares, count, x, y, out, &layers)) return false;
    vec3 background = {0.05f, 0.1f, 0.2f};
    const float *behind = &background.x;
    for (uint32_t i = 0; i < count; i++) {
        double z;
        if (squares[i].color.w < 1 || !hit_square(&squares[i], x, y, &z) || z <= opaque_z) continue;
        opaque_z = z;
        behind = &squares[i].color.x;
    }
    for (uint32_t i = 0; i < count; i++) {
        double z, middle, alpha = squares[i].color.w;
        if (alpha == 1 || !hit_square(&squares[i], x, y, &z) || z < opaque_z) continue;
        hit_square(&squares[i], mid_x, mid_y, &middle);
        double weight = 1 / ((5 - middle) * (5 - middle)); /* the camera is at z = 5 */
        if (half) weight = fmin(fmax(weight, 1.0 / 512), 8);
        for (int k = 0; k < 3; k++) sum[k] += weight * alpha * (double)(&squares[i].color.x)[k];
        sum[3] += weight * alpha;
        open *= 1 - alpha;
    }
    for (int k = 0; k < 3; k++) out[k] = sum[3] > 0 ? sum[k] / sum[3] * (1 - open) + (double)behind[k] * open : (double)behind[k];
    return true;
}

/* Vulkan's standard sample locations, in 1/16 pixel. */
static const uint8_t *sample_places(uint32_t samples) {
    static const uint8_t one[] = {8, 8}, two[] = {12, 12, 4, 4}, four[] = {6, 2, 14, 6, 2, 10, 10, 14},
                         eight[] = {9, 5, 7, 11, 13, 9, 5, 3, 3, 13, 1, 7, 11, 15, 15, 1};
    return samples == 1 ? one : samples == 2 ? two : samples == 4 ? four : eight;
}

struct verdict {
    uint32_t sure, wrong;
    double worst;
    uint32_t layers; /* at one sample a pixel: of all sure pixels */
};

enum judged_as { JUDGED_SORTED, JUDGED_WEIGHTED, JUDGED_WEIGHTED_HALF };

static struct verdict judge_as(enum judged_as as, double tolerance, const fnl_image *radiance, const struct square *squares,
                               uint32_t count, uint32_t samples) {
    struct verdict v = {0};
    const uint8_t *places = sample_places(samples);
    for (uint32_t y = 0; y < radiance->height; y++)
        for (uint32_t x = 0; x < radiance->width; x++) {
            double sum[3] = {0};
            bool sure = true;
            uint32_t layers = 0;
            for (uint32_t s = 0; s < samples && sure; s++) {
                double c[3], px = x + places[2 * s] / 16.0, py = y + places[2 * s + 1] / 16.0;
                double at_x = px * 2 / radiance->width - 1, at_y = 1 - py * 2 / radiance->height;
                if (as == JUDGED_SORTED)
                    sure = look(squares, count, at_x, at_y, c, &layers);
                else
                    sure = look_weighted(squares, count, at_x, at_y, (x + 0.5) * 2 / radiance->width - 1,
                                         1 - (y + 0.5) * 2 / radiance->height, as == JUDGED_WEIGHTED_HALF, c);
                for (int k = 0; k < 3; k++) sum[k] += c[k] / samples;
            }
            if (!sure) continue;
            double error = 0;
            for (int k = 0; k < 3; k++) error = fmax(error, fabs(test_pixel(radiance, x, y)[k] - sum[k]));
            v.sure++;
            v.wrong += error > tolerance;
            v.worst = fmax(v.worst, error);
            v.layers += layers;
        }
    return v;
}

static struct verdict judge(const fnl_image *radiance, const struct square *squares, uint32_t count, uint32_t samples) {
    return judge_as(JUDGED_SORTED, 1e-4, radiance, squares, count, samples);
}

static fnl_frame square_frame(fnl_transparency transparency) {
    fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE);
    frame.transparency = transparency;
    return frame;
}

static fnl_image shoot(fnl_renderer *renderer, const fnl_frame *frame, fnl_frame_stats *stats) {
    test_render_frame(renderer, frame);
    if (stats) *stats = harness_stats(renderer);
    return test_read(renderer, FNL_OUTPUT_RADIANCE);
}

static bool has_samples(uint32_t samples) {
    fnl_device_info info;
    assert_int_equal(fnl_device_query_info(test_device, &info), FNL_OK);
    return (info.msaa_counts & samples) != 0;
}

/* ---- linked: exact ---- */

/* Two panes that cross, before a wall and behind a pillar that cuts through both. */
static const struct square *crossing(uint32_t *count) {
    static struct square s[4];
    s[0] = square((vec3){0, 0, -1}, (vec3){0, 0, 1}, 0, (vec3){0.9f, 0.9f, 1}, (vec4){0.8f, 0.8f, 0.7f, 1});
    s[1] = square((vec3){0.02f, 0.03f, 0}, (vec3){0, 1, 0.05f}, 0.6f, (vec3){0.9f, 0.8f, 1}, (vec4){0.9f, 0.1f, 0.1f, 0.5f});
    s[2] = square((vec3){0, 0, 0}, (vec3){0, 1, -0.03f}, -0.7f, (vec3){0.95f, 0.7f, 1}, (vec4){0.1f, 0.2f, 0.9f, 0.6f});
    s[3] = square((vec3){0.4f, 0, 0}, (vec3){1, 0.2f, 0}, 0.4f, (vec3){0.12f, 1.2f, 1}, (vec4){0.2f, 0.6f, 0.2f, 1});
    *count = 4;
    return s;
}

static void test_crossing_panes(void **state) {
    UNUSED(state);
    uint32_t count;
    const struct square *squares = crossing(&count);
    fnl_scene *scene = scene_of(squares, count);
    fnl_renderer *renderer = test_renderer(scene);
    for (uint32_t samples = 1; samples <= 8; samples *= 2) {
        if (!has_samples(samples)) continue;
        struct verdict v[FNL_TRANSPARENCY_COUNT];
        for (int t = 0; t < FNL_TRANSPARENCY_COUNT; t++) {
            fnl_frame frame = square_frame((fnl_transparency)t);
            frame.msaa = samples;
            fnl_frame_stats stats;
            fnl_image image = shoot(renderer, &frame, &stats);
            v[t] = judge(&image, squares, count, samples);
            assert_int_equal(has_counter(&stats, "transparency.fragments"), t == FNL_TRANSPARENCY_LINKED);
            assert_true(t != FNL_TRANSPARENCY_LINKED || counter(&stats, "transparency.fragments") > 0);
            assert_true(t != FNL_TRANSPARENCY_LINKED || counter(&stats, "transparency.overflow-pixels") == 0);
            free_picture(&image);
        }
        print_message("%u samples, %u pixels: sorted is wrong in %u (%.3f), weighted in %u (%.3f), linked in %u (%.1e)\n",
                      samples, v[0].sure, v[0].wrong, v[0].worst, v[1].wrong, v[1].worst, v[2].wrong, v[2].worst);
        assert_true(v[2].sure > 2500);
        assert_int_equal(v[2].wrong, 0);
        assert_true(v[0].wrong > 500 && v[0].worst > 0.1); /* the scene asks something */
    }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* Squares at random, which reach into one another, before and behind opaque ones; the count is exact where the oracle is sure. */
static void test_random_squares(void **state) {
    UNUSED(state);
    struct random_state random = {5};
    for (int round = 0; round < 3; round++) {
        struct square squares[24];
        for (uint32_t i = 0; i < COUNT_OF(squares); i++) {
            vec3 axis = {random_range(&random, -1, 1), random_range(&random, -1, 1), random_range(&random, -1, 1)};
            squares[i] = square(
                (vec3){random_range(&random, -0.7f, 0.7f), random_range(&random, -0.7f, 0.7f), random_range(&random, -1, 1)},
                axis, random_range(&random, -1, 1),
                (vec3){random_range(&random, 0.2f, 0.7f), random_range(&random, 0.2f, 0.7f), 1},
                (vec4){random_range(&random, 0, 1), random_range(&random, 0, 1), random_range(&random, 0, 1),
                       i % 6 == 5 ? 1 : random_range(&random, 0.1f, 0.9f)});
        }
        fnl_scene *scene = scene_of(squares, COUNT_OF(squares));
        fnl_renderer *renderer = test_renderer(scene);
        for (uint32_t samples = 1; samples <= 4; samples += 3) {
            if (!has_samples(samples)) continue;
            for (int shading = 0; shading < FNL_SHADING_AUTO; shading++) {
                fnl_frame frame = square_frame(FNL_TRANSPARENCY_LINKED);
                frame.width = frame.height = 61;
                frame.shading = (fnl_shading)shading;
                frame.msaa = samples;
                if (fnl_renderer_render(renderer, &frame) != FNL_OK) continue; /* an order without MSAA */
                fnl_frame_stats stats;
                fnl_image image = shoot(renderer, &frame, &stats);
                struct verdict v = judge(&image, squares, COUNT_OF(squares), samples);
                if (shading < FNL_SHADING_DEFERRED) {
                    assert_true(v.sure > 1000);
                    if (v.wrong)
                        fail_msg("%s, %u samples: %u of %u pixels", fnl_value_name(FNL_ENUM_SHADING, frame.shading), samples, v.wrong,
                                 v.sure);
                } else {
                    /* Opaque colours have 8 bits; approximate orders may round what is behind the glass more coarsely. */
                    double allowed = shading_is(frame.shading, SHADING_APPROXIMATE) ? 0.05 : 0.005;
                    if (v.worst > allowed) fail_msg("%s: off by %g", fnl_value_name(FNL_ENUM_SHADING, frame.shading), v.worst);
                }
                if (samples == 1)
                    assert_true(counter(&stats, "transparency.fragments") >= v.layers &&
                                counter(&stats, "transparency.longest") <= 20);
                free_picture(&image);
            }
        }
        fnl_renderer_destroy(&renderer);
        fnl_scene_destroy(&scene);
    }
}

/* Two hundred panes behind one another; every count is known. */
static void test_two_hundred_layers(void **state) {
    UNUSED(state);
    enum { LAYERS = 200 };
    static struct square squares[LAYERS];
    struct random_state random = {9};
    for (uint32_t i = 0; i < LAYERS; i++) {
        float z = -2 + 4 * (float)(i * 77 % LAYERS) / LAYERS; /* in another order than they are added */
        squares[i] = square((vec3){0, 0, z}, (vec3){0, 0, 1}, 0, (vec3){1.2f, 1.2f, 1},
                            (vec4){random_range(&random, 0, 1), random_range(&random, 0, 1), random_range(&random, 0, 1),
                                   random_range(&random, 0.01f, 0.2f)});
    }
    fnl_scene *scene = scene_of(squares, LAYERS);
    fnl_renderer *renderer = test_renderer(scene);
    for (uint32_t samples = 1; samples <= 4; samples += 3) {
        if (!has_samples(samples)) continue;
        fnl_frame frame = square_frame(FNL_TRANSPARENCY_LINKED);
        frame.width = frame.height = 21;
        frame.msaa = samples;
        fnl_frame_stats stats;
        fnl_image image = shoot(renderer, &frame, &stats);
        if (counter(&stats, "transparency.overflow-pixels")) { /* the pool learns its size */
            free_picture(&image);
            image = shoot(renderer, &frame, &stats);
        }
        struct verdict v = judge(&image, squares, LAYERS, samples);
        print_message("%u samples: off by %.1e\n", samples, v.worst);
        assert_true(v.sure == 21 * 21 && v.wrong == 0);
        /* The two triangles of a square share the pixels of its diagonal where these have several samples. */
        assert_int_equal(counter(&stats, "transparency.longest"), samples == 1 ? LAYERS : 2 * LAYERS);
        assert_int_equal(counter(&stats, "transparency.fragments"), LAYERS * (21 * 21 + (samples == 1 ? 0 : 21)));
        assert_int_equal(counter(&stats, "transparency.overflow-pixels"), 0);
        free_picture(&image);
    }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* ---- linked: the pool ---- */

static bool same_pixel(const fnl_image *a, const fnl_image *b, uint32_t x, uint32_t y) {
    return memcmp(test_pixel(a, x, y), test_pixel(b, x, y), 16) == 0;
}

static void test_small_pool(void **state) {
    UNUSED(state);
    uint32_t count;
    const struct square *squares = crossing(&count);
    fnl_scene *scene = scene_of(squares, count);
    for (uint32_t samples = 1; samples <= 4; samples += 3) {
        if (!has_samples(samples)) continue;
        fnl_renderer *renderer = test_renderer(scene);
        fnl_frame sorted_frame = square_frame(FNL_TRANSPARENCY_SORTED), frame = square_frame(FNL_TRANSPARENCY_LINKED);
        sorted_frame.msaa = frame.msaa = samples;
        fnl_frame_stats stats, whole;
        fnl_image sorted = shoot(renderer, &sorted_frame, NULL), linked = shoot(renderer, &frame, &whole);
        assert_int_equal(counter(&whole, "transparency.overflow-pixels"), 0);
        const uint32_t capacities[] = {1, (uint32_t)counter(&whole, "transparency.fragments") / 2,
                                       (uint32_t)counter(&whole, "transparency.fragments") - 1};
        for (uint32_t i = 0; i < COUNT_OF(capacities); i++) {
            for (int k = 0; k < GPU_FRAMES_IN_FLIGHT; k++)
                test_render_frame(renderer, &sorted_frame); /* that has not grown yet */
            renderer->shading.blend_capacity = capacities[i];
            fnl_image image = shoot(renderer, &frame, &stats);
            uint32_t as_sorted = 0, as_linked = 0, differ = 0;
            bool over = false; /* pixels get their pieces of the pool from the top left on */
            for (uint32_t y = 0; y < SIZE; y++)
                for (uint32_t x = 0; x < SIZE; x++) {
                    bool is_linked = same_pixel(&image, &linked, x, y), is_sorted = same_pixel(&image, &sorted, x, y);
                    assert_true(is_linked || is_sorted);
                    over = over || !is_linked;
                    as_sorted += over && !is_linked;
                    as_linked += !over && !is_sorted;
                    differ += over && !is_sorted;
                }
            print_message("pool of %u for %llu: %u pixels overflow, %u look linked, %u sorted\n", capacities[i],
                          (unsigned long long)counter(&whole, "transparency.fragments"),
                          (uint32_t)counter(&stats, "transparency.overflow-pixels"), as_linked, as_sorted);
            assert_int_equal(differ, 0);
            assert_true(counter(&stats, "transparency.overflow-pixels") > 0 &&
                        counter(&stats, "transparency.fragments") == counter(&whole, "transparency.fragments"));
            if (i == 0) assert_true(test_equal(&image, &sorted));
            if (i == 1) assert_true(as_linked > 100 && as_sorted > 100);
            free_picture(&image);
            image = shoot(renderer, &frame, &stats); /* it has grown */
            assert_int_equal(counter(&stats, "transparency.overflow-pixels"), 0);
            assert_true(test_equal(&image, &linked));
            free_picture(&image);
        }
        free_picture(&sorted);
        free_picture(&linked);
        fnl_renderer_destroy(&renderer);
    }
    fnl_scene_destroy(&scene);
}

/* Surfaces in one plane, some of one item: two runs and many threads give the same bytes, whatever lay in the memory. */
static void test_same_bytes(void **state) {
    UNUSED(state);
    uint32_t count;
    struct square squares[8];
    memcpy(squares, crossing(&count), 4 * sizeof *squares);
    for (uint32_t i = 4; i < 8; i++) {
        squares[i] = squares[1];
        squares[i].color = (vec4){(float)(i % 2), 0.2f * (float)i - 0.8f, (float)(i / 6), 0.3f};
    }
    fnl_scene *scene = scene_of(squares, 8);
    fnl_image first[3][2] = {{{0}}};
    for (int run = 0; run < 3; run++) {
        fnl_renderer *renderer = test_renderer(scene);
        harness_hooks(renderer)->poison = run == 1;
        for (int t = 1; t < FNL_TRANSPARENCY_COUNT; t++)
            for (uint32_t k = 0; k < 2 && has_samples(4); k++) {
                fnl_frame frame = square_frame((fnl_transparency)t);
                frame.msaa = k ? 4 : 1;
                frame.record_threads = 1 + (uint32_t)run;
                fnl_image image = shoot(renderer, &frame, NULL);
                if (run == 0) {
                    first[t][k] = image;
                } else {
                    assert_true(test_equal(&first[t][k], &image));
                    free_picture(&image);
                }
            }
        fnl_renderer_destroy(&renderer);
    }
    for (int t = 1; t < 3; t++)
        for (int k = 0; k < 2; k++) free_picture(&first[t][k]);
    fnl_scene_destroy(&scene);
}

/* At equal depth the later item lies on top, whatever the order of drawing: the first item has a flap beside the picture that brings its
 * centre nearer, so that it is drawn last. */
static void test_equal_depths(void **state) {
    UNUSED(state);
    fnl_scene *scene = test_scene();
    struct scene_material material = test_unlit(1, 0, 0);
    material.base_color.w = 0.5f;
    material.alpha_mode = FNL_ALPHA_BLEND;
    static const vec3 positions[8] = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0},
                                      {-1, 2, 1},  {1, 2, 1},  {1, 3, 1}, {-1, 3, 1}};
    static const uint32_t indices[12] = {0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7};
    struct scene_primitive flap = {.material = scene_add_material(scene, &material),
                                   .vertex_count = 8,
                                   .index_count = 12,
                                   .indices = indices,
                                   .positions = positions};
    assert_int_equal(mesh_complete(&scene->arena, &flap), FNL_OK);
    test_place(scene, scene_add_mesh(scene, "", &flap, 1), (vec3){0, 0, 0}, (vec3){1, 1, 1});
    material.base_color = (vec4){0, 1, 0, 0.5f};
    test_place(scene, test_quad_mesh(scene, scene_add_material(scene, &material)), (vec3){0, 0, 0}, (vec3){1, 1, 1});
    fnl_renderer *renderer = test_renderer(scene);
    for (uint32_t samples = 1; samples <= 4; samples += 3) {
        if (!has_samples(samples)) continue;
        fnl_frame frame = square_frame(FNL_TRANSPARENCY_SORTED);
        frame.msaa = samples;
        fnl_image sorted = shoot(renderer, &frame, NULL);
        frame.transparency = FNL_TRANSPARENCY_LINKED;
        fnl_image linked = shoot(renderer, &frame, NULL);
        assert_pixel(&sorted, 20, 30, 0.5, 0.25, 0, 1e-6);
        assert_pixel(&linked, 20, 30, 0.25, 0.5, 0, 1e-6);
        free_picture(&sorted);
        free_picture(&linked);
    }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* ---- weighted ---- */

/* One pane per pixel, lit, from 20 cm to 10 km: the mean of one is that one. */
static void test_weighted_single_layer(void **state) {
    UNUSED(state);
    fnl_scene *scene = test_scene();
    scene->ambient_sky = (vec3){0.6f, 0.7f, 0.8f};
    scene->ambient_ground = (vec3){0.3f, 0.2f, 0.1f};
    scene->background = (vec3){0.1f, 0.3f, 0.2f};
    static const float distances[6] = {0.2f, 2, 20, 200, 2000, 10000};
    for (int i = 0; i < 6; i++) {
        struct scene_material material = scene_material_default();
        material.alpha_mode = FNL_ALPHA_BLEND;
        material.base_color = (vec4){0.2f + 0.15f * (float)i, 0.9f - 0.1f * (float)i, 0.5f, 0.15f * (float)(i + 1)};
        material.metallic = 0;
        float d = distances[i];
        test_place(scene, test_quad_mesh(scene, scene_add_material(scene, &material)),
                   (vec3){d * (-0.35f + 0.35f * (float)(i % 3)), d * (i < 3 ? -0.22f : 0.22f), -d},
                   (vec3){0.16f * d, 0.2f * d, 1});
    }
    fnl_light_params sun = fnl_light_params_default();
    sun.kind = FNL_LIGHT_DIRECTIONAL;
    sun.direction = (fnl_vec3){0.1f, -0.3f, -1};
    sun.intensity = 2;
    fnl_light_id id;
    assert_int_equal(fnl_scene_add_light(scene, &sun, &id), FNL_OK);
    fnl_renderer *renderer = test_renderer(scene);
    fnl_frame frame = test_frame(FNL_OUTPUT_COLOR);
    frame.camera = fnl_camera_default();
    frame.camera.position = (fnl_vec3){0, 0, 0};
    frame.camera.target = (fnl_vec3){0, 0, -1};
    frame.camera.near_distance = 0.1f;
    for (uint32_t samples = 1; samples <= 4; samples += 3) {
        if (!has_samples(samples)) continue;
        frame.msaa = samples;
        frame.transparency = FNL_TRANSPARENCY_SORTED;
        test_render_frame(renderer, &frame);
        fnl_image sorted = test_read(renderer, FNL_OUTPUT_COLOR);
        uint32_t seen = 0;
        for (uint32_t i = 0; i < SIZE * SIZE; i++) seen += test_pixel8(&sorted, i % SIZE, i / SIZE)[2] > 130;
        assert_true(seen > 500);
        frame.transparency = FNL_TRANSPARENCY_WEIGHTED;
        for (int half = 0; half < 2; half++) {
            harness_hooks(renderer)->weighted_half = half;
            test_render_frame(renderer, &frame);
            fnl_image weighted = test_read(renderer, FNL_OUTPUT_COLOR);
            print_message("%u samples, %d-bit sums: off by %g/255\n", samples, half ? 16 : 32,
                          test_difference(&sorted, &weighted));
            assert_true(test_difference(&sorted, &weighted) <= 1);
            free_picture(&weighted);
        }
        free_picture(&sorted);
    }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* Panes that cross and panes far behind one another: at each sample the mean that the definition gives, by 32-bit and by 16-bit sums. */
static void test_weighted_means(void **state) {
    UNUSED(state);
    uint32_t count;
    struct square squares[8];
    memcpy(squares, crossing(&count), 4 * sizeof *squares);
    for (uint32_t i = 0; i < 4; i++) /* from 60 cm to 45 m before the camera: the farthest and the nearest beyond what 16 bits weigh */
        squares[4 + i] = square((vec3){0.1f * (float)i - 0.2f, 0.3f - 0.15f * (float)i, (const float[]){4.7f, 3, -7, -40}[i]},
                                (vec3){0, 0, 1}, 0.3f * (float)i, (vec3){0.55f, 0.5f, 1},
                                (vec4){(float)(i % 2), 0.9f - 0.2f * (float)i, (float)(i / 2), 0.3f + 0.1f * (float)i});
    squares[0].place.m[14] = -45; /* the wall is behind all */
    fnl_scene *scene = scene_of(squares, COUNT_OF(squares));
    fnl_renderer *renderer = test_renderer(scene);
    for (uint32_t samples = 1; samples <= 8; samples *= 2) {
        if (!has_samples(samples)) continue;
        for (int half = 0; half < 2; half++) {
            fnl_frame frame = square_frame(FNL_TRANSPARENCY_WEIGHTED);
            frame.camera.near_distance = 0.1f;
            frame.camera.far_distance = 100;
            frame.msaa = samples;
            harness_hooks(renderer)->weighted_half = half;
            fnl_image image = shoot(renderer, &frame, NULL);
            /* Where the middle of a pixel is not covered drivers may take the depth elsewhere. */
            double tolerance = half ? 4e-3 : samples > 1 ? 1e-3 : 1e-4;
            struct verdict v = judge_as(half ? JUDGED_WEIGHTED_HALF : JUDGED_WEIGHTED, tolerance, &image, squares,
                                        COUNT_OF(squares), samples);
            print_message("%u samples, %d-bit sums: %u of %u pixels wrong, off by %.1e\n", samples, half ? 16 : 32, v.wrong, v.sure,
                          v.worst);
            assert_true(v.sure > 1000);
            assert_int_equal(v.wrong, 0);
            free_picture(&image);
        }
    }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* Two crossing panes with one centre are drawn in the order that they were added in. */
static void test_weighted_order(void **state) {
    UNUSED(state);
    uint32_t count;
    const struct square *squares = crossing(&count);
    struct square orders[2][3] = {{squares[0], squares[1], squares[2]}, {squares[0], squares[2], squares[1]}};
    for (int k = 0; k < 2; k++)
        for (int i = 1; i < 3; i++) orders[k][i].place.m[12] = orders[k][i].place.m[13] = orders[k][i].place.m[14] = 0;
    fnl_image images[FNL_TRANSPARENCY_COUNT][2];
    for (int k = 0; k < 2; k++) {
        fnl_scene *scene = scene_of(orders[k], 3);
        fnl_renderer *renderer = test_renderer(scene);
        for (int t = 0; t < FNL_TRANSPARENCY_COUNT; t++) {
            fnl_frame frame = square_frame((fnl_transparency)t);
            images[t][k] = shoot(renderer, &frame, NULL);
        }
        fnl_renderer_destroy(&renderer);
        fnl_scene_destroy(&scene);
    }
    assert_false(test_equal(&images[FNL_TRANSPARENCY_SORTED][0], &images[FNL_TRANSPARENCY_SORTED][1]));
    assert_true(test_equal(&images[FNL_TRANSPARENCY_WEIGHTED][0], &images[FNL_TRANSPARENCY_WEIGHTED][1]));
    assert_true(test_equal(&images[FNL_TRANSPARENCY_LINKED][0], &images[FNL_TRANSPARENCY_LINKED][1]));
    for (int t = 0; t < FNL_TRANSPARENCY_COUNT; t++)
        for (int k = 0; k < 2; k++) free_picture(&images[t][k]);
}

/* ---- all of them ---- */

/* Nothing blends: the plans are the same, and so are the bytes. */
static void test_nothing_blended(void **state) {
    UNUSED(state);
    uint32_t count;
    const struct square *squares = crossing(&count);
    fnl_scene *scene = scene_of(squares, 1);
    fnl_renderer *renderer = test_renderer(scene);
    static char plans[FNL_TRANSPARENCY_COUNT][32768];
    fnl_image images[FNL_TRANSPARENCY_COUNT];
    for (int i = 0; i < 3; i++) { /* plans hold the waits for the frame before: from here on each has one */
        fnl_frame frame = square_frame(FNL_TRANSPARENCY_SORTED);
        fnl_image image = shoot(renderer, &frame, NULL);
        free_picture(&image);
    }
    for (int t = 0; t < FNL_TRANSPARENCY_COUNT; t++) {
        fnl_frame frame = square_frame((fnl_transparency)t);
        fnl_frame_stats stats;
        images[t] = shoot(renderer, &frame, &stats);
        assert_true(fnl_renderer_print(renderer, FNL_PRINT_PLAN, plans[t], sizeof plans[t]) < sizeof plans[t]);
        assert_string_equal(plans[0], plans[t]);
        assert_true(test_equal(&images[0], &images[t]));
        assert_false(has_counter(&stats, "transparency.bytes") || has_counter(&stats, "transparency.fragments"));
    }
    for (int t = 0; t < FNL_TRANSPARENCY_COUNT; t++) free_picture(&images[t]);
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* From inside of a glass ball one sees its far side alone: one layer, which all ways agree about. */
static void test_inside_glass(void **state) {
    UNUSED(state);
    static const uint32_t sizes[][2] = {{1, 1}, {33, 17}, {70, 3}};
    for (int sided = 0; sided < 2; sided++) {
        fnl_scene *scene = test_scene();
        scene->ambient_sky = scene->ambient_ground = (vec3){0.8f, 0.7f, 0.6f};
        struct scene_material material = scene_material_default();
        material.alpha_mode = FNL_ALPHA_BLEND;
        material.base_color = (vec4){0.3f, 0.9f, 0.6f, 0.4f};
        material.double_sided = sided;
        test_place(scene, test_sphere_mesh(scene, scene_add_material(scene, &material), 12), (vec3){0, 0, 0},
                   (vec3){2, 2, 2});
        fnl_renderer *renderer = test_renderer(scene);
        for (uint32_t i = 0; i < COUNT_OF(sizes); i++) {
            fnl_image images[FNL_TRANSPARENCY_COUNT];
            for (int t = 0; t < FNL_TRANSPARENCY_COUNT; t++) {
                fnl_frame frame = square_frame((fnl_transparency)t);
                frame.width = sizes[i][0];
                frame.height = sizes[i][1];
                frame.camera = fnl_camera_default();
                frame.camera.position = (fnl_vec3){0.3f, 0.2f, 0.1f};
                frame.camera.target = (fnl_vec3){1, 0, 0};
                fnl_frame_stats stats;
                images[t] = shoot(renderer, &frame, &stats);
                if (t == FNL_TRANSPARENCY_LINKED)
                    assert_int_equal(counter(&stats, "transparency.fragments"), sided ? frame.width * frame.height : 0);
                assert_true(test_pixel(&images[t], 0, 0)[1] > 0.01f || !sided);
                assert_true(test_difference(&images[0], &images[t]) < 1e-5);
            }
            for (int t = 0; t < FNL_TRANSPARENCY_COUNT; t++) free_picture(&images[t]);
        }
        fnl_renderer_destroy(&renderer);
        fnl_scene_destroy(&scene);
    }
}

/* The view of layers: as many as there are, by the colours of its legend; what is hidden does not count. */
static void test_layers_view(void **state) {
    UNUSED(state);
    struct square squares[8];
    uint32_t count = 0;
    for (int i = 0; i < 7; i++) /* columns of 1, 2 and 4 */
        squares[count++] = square((vec3){i < 1   ? -0.6f
                                         : i < 3 ? 0
                                                 : 0.6f,
                                         0.3f, 0.1f * (float)i},
                                  (vec3){0, 0, 1}, 0, (vec3){0.25f, 0.25f, 1}, (vec4){1, 1, 1, 0.5f});
    squares[count++] = square((vec3){0.6f, 0.3f, 0.45f}, (vec3){0, 0, 1}, 0, (vec3){0.1f, 0.1f, 1}, (vec4){0, 0, 0, 1});
    fnl_scene *scene = scene_of(squares, count);
    fnl_renderer *renderer = test_renderer(scene);
    fnl_frame frame = test_frame(FNL_OUTPUT_COLOR);
    frame.width = frame.height = 180;
    frame.debug = FNL_DEBUG_LAYERS;
    for (int t = 0; t < FNL_TRANSPARENCY_COUNT; t++) {
        frame.transparency = (fnl_transparency)t;
        test_render_frame(renderer, &frame);
        fnl_image image = test_read(renderer, FNL_OUTPUT_COLOR);
        static const struct {
            uint32_t x, y, box; /* of the legend: 0 is none, n is 2^(n-1) */
            double gray;        /* of what is behind: none, or what is black there */
        } probes[] = {{10, 10, 0, 0}, {36, 63, 1, 0}, {90, 63, 2, 0}, {130, 63, 3, 0}, {144, 63, 2, 0.12}};
        for (uint32_t i = 0; i < COUNT_OF(probes); i++) {
            const uint8_t *is = test_pixel8(&image, probes[i].x, probes[i].y),
                          *key = test_pixel8(&image, probes[i].box * 16 + 1, 178);
            for (int c = 0; c < 3; c++) {
                double wanted = probes[i].box == 0 ? 0 : 0.8 * key[c] + 0.2 * 255 * probes[i].gray;
                if (fabs(is[c] - wanted) > 2) fail_msg("probe %u: %d, wanted %g", i, is[c], wanted);
            }
        }
        free_picture(&image);
    }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_crossing_panes),
        cmocka_unit_test(test_random_squares),
        cmocka_unit_test(test_two_hundred_layers),
        cmocka_unit_test(test_small_pool),
        cmocka_unit_test(test_same_bytes),
        cmocka_unit_test(test_equal_depths),
        cmocka_unit_test(test_weighted_single_layer),
        cmocka_unit_test(test_weighted_means),
        cmocka_unit_test(test_weighted_order),
        cmocka_unit_test(test_nothing_blended),
        cmocka_unit_test(test_inside_glass),
        cmocka_unit_test(test_layers_view),
    };
    return cmocka_run_group_tests_name("transparency", tests, test_group_begin, test_group_end);
}
