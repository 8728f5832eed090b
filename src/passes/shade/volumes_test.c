/* SPDX-License-Identifier: MIT */
/** Deferred shading by light volumes against deferred shading by one loop, and the solids themselves. */
#include "tests/order_cases.h"
#include "passes/shade/volumes.h"
#include "passes/shade/volumes_shared.h"
#include "render/view.h"

/* ---- the solids ---- */

static vec3 unfold(float x, float y) { /* octahedral_decode() of shaders/common.glsl */
    vec3 n = {x, y, 1 - fabsf(x) - fabsf(y)};
    if (n.z < 0) {
        n.x = (1 - fabsf(y)) * (x < 0 ? -1.0f : 1.0f);
        n.y = (1 - fabsf(x)) * (y < 0 ? -1.0f : 1.0f);
    }
    return vec3_normalize(n);
}

static vec3 vertex_of(uint32_t vertex, float tangent) {
    const int side = (int)VOLUME_SIDE, row = side + 1;
    if (vertex < VOLUME_SPHERE_VERTICES)
        return unfold((float)(2 * ((int)vertex % row) - side) / (float)side,
                      (float)(2 * ((int)vertex / row) - side) / (float)side);
    vertex -= VOLUME_SPHERE_VERTICES;
    float angle = (float)(vertex % VOLUME_RING) * (2 * PI / (float)VOLUME_RING);
    bool far = vertex >= VOLUME_RING;
    float across = (far ? tangent : 0) + 0.002f;
    /* side, up = side x direction, direction of a light that shines along -z */
    return (vec3){across * cosf(angle), across * sinf(angle), far ? -1.0f : 0.001f};
}

/* Both are closed, convex and turned outwards: a ray that enters meets one back face, so a pixel is never lit twice by one light. */
static void test_solids(void **state) {
    UNUSED(state);
    uint32_t indices[VOLUME_INDEX_COUNT];
    volumes_indices(indices);
    for (int cone = 0; cone < 2; cone++) {
        const uint32_t first = cone ? VOLUME_SPHERE_INDICES : 0, end = cone ? VOLUME_INDEX_COUNT : VOLUME_SPHERE_INDICES;
        const vec3 inside = {0, 0, cone ? -0.5f : 0};
        double nearest = 9;
        uint32_t twins = 0;
        for (uint32_t i = first; i < end; i += 3) {
            vec3 p[3];
            for (int k = 0; k < 3; k++) p[k] = vertex_of(indices[i + (uint32_t)k], 0.5f);
            vec3 normal = vec3_cross(vec3_sub(p[1], p[0]), vec3_sub(p[2], p[0]));
            assert_true(vec3_length(normal) > 1e-9f);
            normal = vec3_normalize(normal);
            double distance = (double)vec3_dot(normal, vec3_sub(p[0], inside));
            assert_true(distance > 0);
            nearest = fmin(nearest, distance);
            for (uint32_t j = first; j < end; j++)
                assert_true((double)vec3_dot(normal, vec3_sub(vertex_of(indices[j], 0.5f), inside)) < distance + 1e-5);
            for (int k = 0; k < 3; k++) /* each edge is some other face's, the other way round, to the bit */
                for (uint32_t j = first; j < end; j += 3)
                    for (uint32_t m = 0; m < 3; m++) {
                        vec3 a = vertex_of(indices[j + m], 0.5f), b = vertex_of(indices[j + (m + 1) % 3], 0.5f);
                        vec3 c = p[(k + 1) % 3], d = p[k];
                        twins += a.x == c.x && a.y == c.y && a.z == c.z && b.x == d.x && b.y == d.y && b.z == d.z;
                    }
        }
        assert_int_equal(twins, end - first);
        if (!cone) assert_true(nearest >= (double)VOLUME_SPHERE_INSIDE && nearest < (double)VOLUME_SPHERE_INSIDE + 1e-4);
    }
    assert_true((double)VOLUME_CONE_INSIDE <= cos(3.14159265358979 / VOLUME_RING));
}

/* ---- pictures ---- */

/* Whatever is drawn instead of solids: the same picture, again without a light missing anywhere, none twice. */
static void check_shapes(struct stage *stage, const struct shot *all, const struct shot *solids, const char *what) {
    static uint32_t shapes_checked;
    uint64_t evaluations[FNL_VOLUME_SHAPE_COUNT] = {solids->stats.evaluations};
    fnl_frame frame = stage->frame;
    frame.count_lights = true;
    frame.lists = FNL_LISTS_ALL;
    frame.shading = FNL_SHADING_DEFERRED_VOLUMES;
    for (uint32_t i = 1; i < FNL_VOLUME_SHAPE_COUNT; i++) {
        frame.volume_shape = (fnl_volume_shape)i;
        struct shot shape = stage_shoot(stage, &frame);
        evaluations[i] = shape.stats.evaluations;
        print_message("  %s, %s: %d/255, %llu evaluations\n", what, fnl_value_name(FNL_ENUM_VOLUME_SHAPE, (fnl_volume_shape)i),
                      greatest_difference(&all->color, &shape.color), (unsigned long long)shape.stats.evaluations);
        assert_int_equal(count_broken(&shape.radiance), 0);
        assert_true(greatest_difference(&all->color, &shape.color) <= 2);
        assert_int_equal(shape.stats.evaluations_useful, all->stats.evaluations_useful);
        assert_true(shape.stats.evaluations >= shape.stats.evaluations_useful);
        assert_true(shape.stats.evaluations <= all->stats.evaluations);
        if (i == 1 + shapes_checked % (FNL_VOLUME_SHAPE_COUNT - 1)) { /* two runs */
            struct shot again = stage_shoot(stage, &frame);
            assert_int_equal(count_differing(&shape.radiance, &again.radiance), 0);
            shot_free(&again);
        }
        /* The same solids in the same order: the bits, for what the stencil holds off is not lit. */
        if (i == FNL_VOLUME_STENCIL || i == FNL_VOLUME_DEPTH_BOUNDS)
            assert_int_equal(count_differing(&solids->radiance, &shape.radiance), 0);
        shot_free(&shape);
    }
    shapes_checked++;
    frame.volume_shape = FNL_VOLUME_FULLSCREEN; /* several lights a draw: the same evaluations, the same light */
    frame.volume_batch = shapes_checked % 3 == 0 ? 64 : shapes_checked % 3 == 1 ? 5 : 2;
    struct shot batched = stage_shoot(stage, &frame);
    assert_true(greatest_difference(&all->color, &batched.color) <= 2);
    assert_int_equal(batched.stats.evaluations_useful, all->stats.evaluations_useful);
    assert_int_equal(batched.stats.evaluations, evaluations[FNL_VOLUME_FULLSCREEN]);
    shot_free(&batched);
    /* Whatever the view, one shape lies within the other. */
    assert_true(evaluations[FNL_VOLUME_FULLSCREEN] >= evaluations[FNL_VOLUME_QUADS]);
    assert_true(evaluations[FNL_VOLUME_QUADS] >= evaluations[FNL_VOLUME_ELLIPSE]);
    assert_true(evaluations[FNL_VOLUME_SOLIDS] >= evaluations[FNL_VOLUME_DEPTH_BOUNDS]);
    assert_true(evaluations[FNL_VOLUME_SOLIDS] >= evaluations[FNL_VOLUME_STENCIL]);
}

/* Shoots both orders. Every light that reaches a surface is found there (SUP): the useful evaluations are the same. */
static void check(struct stage *stage, const char *what) {
    fnl_frame frame = stage->frame;
    frame.count_lights = true;
    frame.lists = FNL_LISTS_ALL;
    frame.shading = FNL_SHADING_DEFERRED;
    struct shot all = stage_shoot(stage, &frame);
    frame.shading = FNL_SHADING_DEFERRED_VOLUMES;
    struct shot volumes = stage_shoot(stage, &frame), again = stage_shoot(stage, &frame);
    print_message("  %s: %d/255, %llu evaluations of %llu, %llu of use\n", what,
                  greatest_difference(&all.color, &volumes.color), (unsigned long long)volumes.stats.evaluations,
                  (unsigned long long)all.stats.evaluations, (unsigned long long)volumes.stats.evaluations_useful);
    assert_int_equal(count_broken(&volumes.radiance), 0);
    assert_true(greatest_difference(&all.color, &volumes.color) <= 1);
    assert_int_equal(volumes.stats.evaluations_useful, all.stats.evaluations_useful);
    assert_true(volumes.stats.evaluations >= volumes.stats.evaluations_useful);
    assert_true(volumes.stats.evaluations <= all.stats.evaluations);
    assert_int_equal(count_differing(&volumes.radiance, &again.radiance), 0);
    frame.list.frustum_cull = false;
    struct shot unculled = stage_shoot(stage, &frame);
    assert_int_equal(count_differing(&volumes.radiance, &unculled.radiance), 0);
    assert_true(unculled.stats.lights_in_view >= volumes.stats.lights_in_view);
    check_shapes(stage, &all, &volumes, what);
    shot_free(&all);
    shot_free(&volumes);
    shot_free(&again);
    shot_free(&unculled);
}

static void test_scenes_ES_14_ES_15_ES_17_TD_3_MP_22(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:wall?test=2", 0);
    stage.frame.ev = 4;
    check(&stage, "builtin:wall?test=2");
    stage_close(&stage);
    order_scenes(check);
}

static void test_cameras_TD_3_ES_14_ES_15_ES_16_ES_17_MP_22(void **state) {
    UNUSED(state);
    order_cameras(check);
}

/* Hard edges of cones and of the other shapes, wide cones, lights without end. */
/* Narrow spots are drawn as pyramids: far fewer pixels than their spheres cover are asked. */
static void test_narrow_spots_ES_16(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:spheres?lights=0", 0);
    for (uint32_t i = 0; i < 12; i++) {
        fnl_light_params light = fnl_light_params_default();
        fnl_light_id id;
        light.kind = FNL_LIGHT_SPOT;
        light.position = (fnl_vec3){-3.5f + 2.2f * (float)(i % 4), 3, -2.5f + 2 * (float)(i / 4)};
        light.direction = vec3_normalize((vec3){0.1f, -1, 0.05f});
        light.range = 4;
        light.intensity = 10;
        light.outer_cone_angle = 0.15f;
        light.inner_cone_angle = 0.1f;
        assert_int_equal(fnl_scene_add_light(stage.scene, &light, &id), FNL_OK);
    }
    fnl_frame frame = stage.frame;
    frame.count_lights = true;
    frame.lists = FNL_LISTS_ALL;
    frame.shading = FNL_SHADING_DEFERRED_VOLUMES;
    struct shot solids = stage_shoot(&stage, &frame);
    frame.volume_shape = FNL_VOLUME_QUADS;
    struct shot quads = stage_shoot(&stage, &frame);
    print_message("  %llu evaluations by pyramids, %llu by rectangles, %llu of use\n", (unsigned long long)solids.stats.evaluations,
                  (unsigned long long)quads.stats.evaluations, (unsigned long long)solids.stats.evaluations_useful);
    assert_true(solids.stats.evaluations_useful > 100);
    assert_true(solids.stats.evaluations * 4 < quads.stats.evaluations);
    shot_free(&solids);
    shot_free(&quads);
    stage_close(&stage);
}

static void test_shapes_TD_3_ES_16_MP_22(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:spheres?lights=0", 0);
    struct random_state random = {4};
    for (uint32_t i = 0; i < 60; i++) {
        fnl_light_params light = fnl_light_params_default();
        fnl_light_id id;
        light.kind = (fnl_light_kind)(FNL_LIGHT_POINT + i % (FNL_LIGHT_KIND_COUNT - FNL_LIGHT_POINT));
        light.position =
            (fnl_vec3){random_range(&random, -4, 4), random_range(&random, 0.2f, 4), random_range(&random, -4, 4)};
        light.direction = vec3_normalize(
            (vec3){random_range(&random, -1, 1), random_range(&random, -1, 0.2f), random_range(&random, -1, 1)});
        light.range = i == 7 ? 1e6f : i == 10 ? 1e9f : random_range(&random, 1, 7);
        light.intensity = light.kind == FNL_LIGHT_BOX ? 2 : random_range(&random, 1, 5);
        light.outer_cone_angle = random_range(&random, 0.05f, 1.5f);
        light.inner_cone_angle = light.outer_cone_angle * 0.999f;
        assert_int_equal(fnl_scene_add_light(stage.scene, &light, &id), FNL_OK);
    }
    check(&stage, "all shapes");
    stage.frame.width = 77;
    stage.frame.height = 119;
    check(&stage, "all shapes, odd size");
    stage.frame.camera.orthographic = true; /* the solid of what has no end reaches round the viewer, and has no front */
    stage.frame.camera.vertical_extent = 8;
    check(&stage, "all shapes, orthographic");
    stage_close(&stage);
}

/* 55, 183, 583 and 1083 lights of the four walls are in view, no more, with culling, and all without. */
static void test_walls_in_view_TD_8(void **state) {
    UNUSED(state);
    static const uint32_t visible[] = {55, 183, 583, 1083}, total[] = {1500, 1600, 2000, 2500};
    for (uint32_t test = 0; test < 4; test++) {
        char source[32];
        snprintf(source, sizeof source, "builtin:wall?test=%u", test + 1);
        struct stage stage = stage_open(source, 0);
        stage.frame.width = 160;
        stage.frame.height = 90;
        for (int tiled = 0; tiled < 2; tiled++) {
            fnl_frame frame = stage.frame;
            frame.shading = tiled ? FNL_SHADING_DEFERRED : FNL_SHADING_DEFERRED_VOLUMES;
            frame.lists = FNL_LISTS_TILED;
            struct shot culled = stage_shoot(&stage, &frame);
            frame.list.frustum_cull = false;
            struct shot all = stage_shoot(&stage, &frame);
            assert_int_equal(culled.stats.lights_in_view, visible[test]);
            assert_int_equal(all.stats.lights_in_view, total[test]);
            assert_int_equal(count_differing(&culled.radiance, &all.radiance), 0);
            shot_free(&culled);
            shot_free(&all);
        }
        stage_close(&stage);
    }
}

/* ---- rectangles ---- */

/* What a light may cost at least and at most: the surfaces in its rectangle that are not nearer than its nearest point. */
struct limits {
    uint64_t least, most;
};

/* The rectangle comes from points all over the sphere, so it is a hair too small, and pixels near its edges may go either way. */
static void add_limits(const fnl_frame *frame, const fnl_image *normals, vec3 position, float radius, struct limits *sum) {
    struct gpu_view view = view_from_camera(&frame->camera, frame->width, frame->height);
    vec3 center = mat4_point(&view.world_to_view, position);
    float low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
    bool flat = frame->camera.orthographic, inside = !flat && vec3_length(center) <= radius;
    const int side = 300;
    for (int i = 0; i < side * side; i++) {
        vec3 p = vec3_add(center, vec3_scale(unfold((float)(i % side) / (float)(side - 1) * 2 - 1,
                                                    (float)(i / side) / (float)(side - 1) * 2 - 1),
                                             radius));
        if (!flat && -p.z < view.near_distance) continue;
        float across[2] = {p.x, p.y}, scale[2] = {view.ndc_scale.x, view.ndc_scale.y},
              offset[2] = {view.ndc_offset.x, view.ndc_offset.y};
        for (int k = 0; k < 2; k++) {
            float ndc = (across[k] / (flat ? 1 : -p.z) - offset[k]) / scale[k];
            low[k] = fminf(low[k], ndc);
            high[k] = fmaxf(high[k], ndc);
        }
    }
    float nearest = -center.z - radius;
    for (uint32_t y = 0; y < frame->height; y++)
        for (uint32_t x = 0; x < frame->width; x++) {
            float depth = ((const float *)normals->pixels)[((size_t)y * frame->width + x) * 4 + 3];
            if (depth <= 0) continue;
            float at[2] = {((float)x + 0.5f) / (float)frame->width * 2 - 1,
                           1 - ((float)y + 0.5f) / (float)frame->height * 2};
            float edge = INFINITY; /* pixels from the nearest edge, negative outside */
            for (int k = 0; k < 2; k++) {
                float pixels = (float)(k ? frame->height : frame->width) * 0.5f;
                edge = fminf(edge, fminf(at[k] - low[k], high[k] - at[k]) * pixels);
            }
            sum->least += inside || (edge > 0 && depth > nearest);
            sum->most += inside || (edge > -1 && depth > nearest - 0.002f * (radius + fabsf(nearest)));
        }
}

/* Each light is evaluated where its rectangle is, but for surfaces that are nearer. */
static void test_rectangles_MP_22(void **state) {
    UNUSED(state);
    static const char *const names[] = {"outside", "orthographic", "off axis", "in a light", "at the near plane"};
    struct stage stage = stage_open("builtin:spheres?lights=0", 0);
    struct random_state random = {11};
    fnl_light_params lights[24];
    for (uint32_t i = 0; i < COUNT_OF(lights); i++) {
        fnl_light_id id;
        lights[i] = fnl_light_params_default();
        lights[i].position =
            (fnl_vec3){random_range(&random, -5, 5), random_range(&random, -2, 4), random_range(&random, -6, 4)};
        lights[i].range = random_range(&random, 0.2f, 1.5f);
        assert_int_equal(fnl_scene_add_light(stage.scene, &lights[i], &id), FNL_OK);
    }
    const fnl_frame start = stage.frame;
    for (uint32_t kind = 0; kind < COUNT_OF(names); kind++) {
        fnl_frame frame = start;
        frame.count_lights = true;
        frame.outputs |= FNL_OUTPUT_NORMAL;
        frame.shading = FNL_SHADING_DEFERRED_VOLUMES;
        frame.volume_shape = FNL_VOLUME_QUADS;
        if (kind == 1) {
            frame.camera.orthographic = true;
            frame.camera.vertical_extent = 8;
        } else if (kind == 2) {
            frame.camera.shift = (fnl_vec2){0.4f, -0.3f};
        } else if (kind > 2) { /* the first light is round the viewer, or just before him and through the near plane */
            frame.camera.position = lights[0].position;
            if (kind == 4) frame.camera.near_distance = lights[0].range * 0.5f;
            frame.camera.position.z += lights[0].range * (kind == 3 ? 0.5f : 1.2f);
        }
        struct shot shot = stage_shoot(&stage, &frame);
        struct limits limits = {0, 0};
        for (uint32_t i = 0; i < COUNT_OF(lights); i++)
            add_limits(&frame, &shot.normal, lights[i].position, lights[i].range, &limits);
        print_message("  %s: %llu evaluations, from %llu to %llu\n", names[kind], (unsigned long long)shot.stats.evaluations,
                      (unsigned long long)limits.least, (unsigned long long)limits.most);
        assert_true(limits.least > 0);
        assert_in_range(shot.stats.evaluations, limits.least, limits.most);
        shot_free(&shot);
    }
    stage_close(&stage);
}

/* Lights in the open: all pixels, rectangles, solids, from most to least. Lights behind a wall: rectangles cost nothing, solids do. */
static void test_order_of_evaluations_ES_14_ES_15_ES_17_MP_22(void **state) {
    UNUSED(state);
    for (int hidden = 0; hidden < 2; hidden++) {
        struct stage stage = stage_open("builtin:wall?test=1&lights=0", 0);
        struct random_state random = {3};
        const vec3 eye = stage.frame.camera.position;
        for (uint32_t i = 0; i < 40; i++) { /* the wall is at z = -20 */
            fnl_light_params light = fnl_light_params_default();
            fnl_light_id id;
            light.range = random_range(&random, 1, 3);
            light.position = (fnl_vec3){eye.x + random_range(&random, -12, 12), random_range(&random, 2, 14),
                                        hidden ? -26 - light.range : random_range(&random, -22, -17)};
            assert_int_equal(fnl_scene_add_light(stage.scene, &light, &id), FNL_OK);
        }
        fnl_frame frame = stage.frame;
        frame.count_lights = true;
        frame.shading = FNL_SHADING_DEFERRED;
        frame.lists = FNL_LISTS_ALL;
        struct shot all = stage_shoot(&stage, &frame);
        frame.shading = FNL_SHADING_DEFERRED_VOLUMES;
        struct shot solids = stage_shoot(&stage, &frame);
        frame.volume_shape = FNL_VOLUME_DEPTH_BOUNDS;
        struct shot bounds = stage_shoot(&stage, &frame);
        frame.volume_shape = FNL_VOLUME_STENCIL;
        struct shot stencil = stage_shoot(&stage, &frame);
        frame.volume_shape = FNL_VOLUME_FULLSCREEN;
        struct shot screen = stage_shoot(&stage, &frame);
        frame.volume_shape = FNL_VOLUME_ELLIPSE;
        struct shot ellipses = stage_shoot(&stage, &frame);
        frame.volume_shape = FNL_VOLUME_QUADS;
        struct shot quads = stage_shoot(&stage, &frame);
        print_message("  %s: screen %llu, rectangles %llu, ellipses %llu, solids %llu, depth bounds %llu, stencil %llu\n",
                      hidden ? "hidden" : "open", (unsigned long long)screen.stats.evaluations,
                      (unsigned long long)quads.stats.evaluations, (unsigned long long)ellipses.stats.evaluations,
                      (unsigned long long)solids.stats.evaluations, (unsigned long long)bounds.stats.evaluations,
                      (unsigned long long)stencil.stats.evaluations);
        print_message("  %s: all %llu, rectangles %llu, solids %llu evaluations\n", hidden ? "hidden" : "open",
                      (unsigned long long)all.stats.evaluations, (unsigned long long)quads.stats.evaluations,
                      (unsigned long long)solids.stats.evaluations);
        assert_true(greatest_difference(&all.color, &quads.color) <= 2 &&
                    greatest_difference(&all.color, &solids.color) <= 2);
        assert_true(all.stats.evaluations > 10 * quads.stats.evaluations);
        assert_true(screen.stats.evaluations > quads.stats.evaluations);
        if (hidden) {
            assert_int_equal(bounds.stats.evaluations, 0);
            assert_int_equal(stencil.stats.evaluations, 0);
            assert_int_equal(quads.stats.evaluations, 0);
            assert_true(solids.stats.evaluations > 1000);
        } else {
            assert_true(quads.stats.evaluations >= solids.stats.evaluations && solids.stats.evaluations > 1000);
            assert_true(quads.stats.evaluations > ellipses.stats.evaluations);
            assert_true(ellipses.stats.evaluations >= solids.stats.evaluations);
            assert_true(solids.stats.evaluations > bounds.stats.evaluations && bounds.stats.evaluations > 1000);
            assert_true(solids.stats.evaluations > stencil.stats.evaluations && stencil.stats.evaluations > 1000);
            /* Surfaces fill the screen: every pixel for every light in view. */
            assert_int_equal(screen.stats.evaluations, (uint64_t)screen.stats.lights_in_view * frame.width * frame.height);
        }
        shot_free(&stencil);
        shot_free(&bounds);
        shot_free(&screen);
        shot_free(&ellipses);
        shot_free(&all);
        shot_free(&solids);
        shot_free(&quads);
        stage_close(&stage);
    }
}

/* Ten thousand random spheres round the viewer, many through the near plane: no pixel that one covers is outside of its shape. */
static void test_random_spheres_ES_15_ES_16(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:spheres?lights=0", 0);
    struct random_state random = {21};
    const vec3 eye = stage.frame.camera.position;
    for (uint32_t i = 0; i < 10000; i++) {
        fnl_light_params light = fnl_light_params_default();
        fnl_light_id id;
        float spread = i % 3 ? 12 : 2;
        light.position =
            (fnl_vec3){eye.x + random_range(&random, -spread, spread), eye.y + random_range(&random, -spread, spread),
                       eye.z + random_range(&random, -spread, spread)};
        light.range = random_range(&random, 0.1f, i % 7 ? 2 : 6);
        light.intensity = 0.01f;
        assert_int_equal(fnl_scene_add_light(stage.scene, &light, &id), FNL_OK);
    }
    fnl_frame frame = stage.frame;
    frame.width = 64;
    frame.height = 37;
    frame.count_lights = true;
    frame.lists = FNL_LISTS_ALL;
    frame.shading = FNL_SHADING_DEFERRED;
    struct shot all = stage_shoot(&stage, &frame);
    frame.shading = FNL_SHADING_DEFERRED_VOLUMES;
    uint64_t evaluations[FNL_VOLUME_SHAPE_COUNT];
    struct shot solids = {0};
    for (uint32_t i = 0; i < FNL_VOLUME_SHAPE_COUNT; i++) {
        frame.volume_shape = (fnl_volume_shape)i;
        struct shot shape = stage_shoot(&stage, &frame);
        evaluations[i] = shape.stats.evaluations;
        print_message("  %s: %llu evaluations, %llu of use\n", fnl_value_name(FNL_ENUM_VOLUME_SHAPE, (fnl_volume_shape)i),
                      (unsigned long long)shape.stats.evaluations, (unsigned long long)shape.stats.evaluations_useful);
        assert_int_equal(shape.stats.evaluations_useful, all.stats.evaluations_useful);
        if (i == FNL_VOLUME_STENCIL) { /* more lights than are drawn alone, and far more than the stencil has marks */
            assert_in_range(shape.stats.lights_in_view, VOLUME_STENCIL_LIGHTS + 100, 10000);
            assert_int_equal(counter(&shape.stats, "volumes.draws"), 2 + 2 * VOLUME_STENCIL_LIGHTS);
            assert_int_equal(count_differing(&solids.radiance, &shape.radiance), 0);
        } else {
            assert_int_equal(counter(&shape.stats, "volumes.draws"), 2);
        }
        if (i == FNL_VOLUME_SOLIDS)
            solids = shape;
        else
            shot_free(&shape);
    }
    assert_true(evaluations[FNL_VOLUME_STENCIL] < evaluations[FNL_VOLUME_SOLIDS]);
    shot_free(&solids);
    assert_true(all.stats.evaluations_useful > 20000);
    assert_true(evaluations[FNL_VOLUME_ELLIPSE] < evaluations[FNL_VOLUME_QUADS]);
    assert_true(evaluations[FNL_VOLUME_QUADS] < evaluations[FNL_VOLUME_FULLSCREEN]);
    shot_free(&all);
    stage_close(&stage);
}

/* Lights in the air before far surfaces: rectangles cannot tell, tiles of 16 pixels with depth bounds can. */
static void test_tiles_against_rectangles_MP_23(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:hall?lights=256", 0);
    fnl_frame frame = stage.frame;
    frame.width = 320;
    frame.height = 180;
    frame.count_lights = true;
    frame.shading = FNL_SHADING_DEFERRED;
    frame.lists = FNL_LISTS_TILED;
    struct shot tiles = stage_shoot(&stage, &frame);
    frame.shading = FNL_SHADING_DEFERRED_VOLUMES;
    frame.volume_shape = FNL_VOLUME_QUADS;
    struct shot quads = stage_shoot(&stage, &frame);
    print_message("  rectangles %llu, tiles %llu, of use %llu\n", (unsigned long long)quads.stats.evaluations,
                  (unsigned long long)tiles.stats.evaluations, (unsigned long long)tiles.stats.evaluations_useful);
    assert_true(tiles.stats.evaluations < quads.stats.evaluations);
    shot_free(&tiles);
    shot_free(&quads);
    stage_close(&stage);
}

/* One light before a wall: the heat map of volumes shows a disc of ones. */
static void test_heat_map_TD_12(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:wall?test=1&lights=0", 0);
    fnl_light_params light = fnl_light_params_default();
    fnl_light_id id;
    light.position = (fnl_vec3){0, 9, -19};
    light.range = 2;
    assert_int_equal(fnl_scene_add_light(stage.scene, &light, &id), FNL_OK);
    stage.frame.outputs = FNL_OUTPUT_COLOR;
    stage.frame.shading = FNL_SHADING_DEFERRED_VOLUMES;
    stage.frame.debug = FNL_DEBUG_LIGHTS;
    struct shot view = stage_shoot(&stage, &stage.frame);
    stage.frame.count_lights = true;
    struct shot counted = stage_shoot(&stage, &stage.frame);
    assert_int_equal(count_differing(&view.color, &counted.color), 0);
    uint64_t ones = 0; /* violet, others are grey */
    for (uint32_t y = 0; y + 14 < view.color.height; y++)
        for (uint32_t x = 0; x < view.color.width; x++) {
            const uint8_t *p = (const uint8_t *)view.color.pixels + ((size_t)y * view.color.width + x) * 4;
            ones += p[2] > p[1] + 40;
        }
    assert_int_equal(ones, counted.stats.evaluations);
    assert_true(ones > counted.stats.evaluations_useful && counted.stats.evaluations_useful > 100);
    shot_free(&view);
    shot_free(&counted);
    stage_close(&stage);
}

/* ---- one light at a time ---- */

enum { HOOKED = 24 };

struct keeper {
    uint32_t next;     /* the light that comes next */
    uint32_t kept_off; /* a bit each */
    uint32_t width, height;
};

/* A light's shadow: nothing is left of it, or all. */
static graph_image keep_off(struct graph *graph, uint32_t light, void *user) {
    struct keeper *keeper = user;
    assert_int_equal(light, keeper->next++);
    const char *name = graph_name(graph, "mask of light %u;", light);
    graph_image mask = graph_create_image(graph, &(struct graph_image_params){.name = name,
                                                                              .format = VK_FORMAT_R32_SFLOAT,
                                                                              .width = keeper->width,
                                                                              .height = keeper->height});
    struct graph_pass *pass = graph_add_pass(graph, name, GRAPH_QUEUE_GRAPHICS, NULL, NULL, 0);
    graph_color(pass, mask, VK_ATTACHMENT_LOAD_OP_CLEAR, (float[4]){keeper->kept_off >> light & 1 ? 0.0f : 1.0f});
    return mask;
}

/* Each light's pass stands between its mask and the next light's; masks take one place in memory, however many there are; and the picture
   is that of the scene without the lights that are kept off. Lights beyond the hook's are drawn as ever. */
static void test_one_light_at_a_time_ES_18(void **state) {
    UNUSED(state);
    static char plan[1 << 17];
    struct keeper keeper = {.kept_off = 0x5a5a5a, .width = 161, .height = 91};
    struct shot shots[2];
    uint64_t bytes[3] = {0};
    for (int without = 0; without < 2; without++) {
        struct stage stage = stage_open("builtin:spheres?lights=0", 0);
        struct random_state random = {31};
        for (uint32_t i = 0; i < HOOKED + 10; i++) {
            fnl_light_params light = fnl_light_params_default();
            fnl_light_id id;
            light.kind = i % 3 ? FNL_LIGHT_POINT : FNL_LIGHT_SPOT;
            light.outer_cone_angle = 0.6f;
            light.inner_cone_angle = 0.4f;
            light.direction = (fnl_vec3){0, -1, 0};
            light.position =
                (fnl_vec3){random_range(&random, -4, 4), random_range(&random, 0.3f, 3), random_range(&random, -4, 4)};
            light.range = random_range(&random, 1, 4);
            light.intensity = without && i < HOOKED && keeper.kept_off >> i & 1 ? 0 : 3;
            assert_int_equal(fnl_scene_add_light(stage.scene, &light, &id), FNL_OK);
        }
        stage.frame.shading = FNL_SHADING_DEFERRED_VOLUMES;
        stage.frame.volume_shape = FNL_VOLUME_STENCIL;
        for (uint32_t count = 1; !without && count <= HOOKED; count += HOOKED - 1) {
            struct volumes_hook hook = {keep_off, &keeper, count};
            keeper.next = 0;
            harness_hooks(stage.renderer)->volume_hook = &hook;
            struct shot shot = stage_shoot(&stage, &stage.frame);
            assert_int_equal(keeper.next, count);
            bytes[count > 1] = graph_query_stats(stage.renderer->graph).transient_bytes;
            if (count == 1) {
                shot_free(&shot);
                continue;
            }
            shots[0] = shot;
            fnl_renderer_print(stage.renderer, FNL_PRINT_PLAN, plan, sizeof plan);
            const char *at = plan;
            for (uint32_t i = 0; i < count; i++) {
                char name[2][32];
                snprintf(name[0], sizeof name[0], "'mask of light %u;'", i);
                snprintf(name[1], sizeof name[1], "'volumes of light %u'", i);
                assert_non_null(at = strstr(at, name[0]));
                assert_non_null(at = strstr(at, name[1]));
            }
            harness_hooks(stage.renderer)->volume_hook = NULL;
        }
        if (without) shots[1] = stage_shoot(&stage, &stage.frame);
        stage_close(&stage);
    }
    print_message("  %llu bytes with a mask, %llu with %d; %d/255\n", (unsigned long long)bytes[0],
                  (unsigned long long)bytes[1], HOOKED, greatest_difference(&shots[0].color, &shots[1].color));
    assert_true(greatest_difference(&shots[0].color, &shots[1].color) <= 1);
    assert_true(bytes[1] < bytes[0] + 113 * 65 * 4 / 2); /* not one mask more */
    shot_free(&shots[0]);
    shot_free(&shots[1]);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_solids, harness_check),
        cmocka_unit_test_teardown(test_scenes_ES_14_ES_15_ES_17_TD_3_MP_22, harness_check),
        cmocka_unit_test_teardown(test_cameras_TD_3_ES_14_ES_15_ES_16_ES_17_MP_22, harness_check),
        cmocka_unit_test_teardown(test_shapes_TD_3_ES_16_MP_22, harness_check),
        cmocka_unit_test_teardown(test_narrow_spots_ES_16, harness_check),
        cmocka_unit_test_teardown(test_walls_in_view_TD_8, harness_check),
        cmocka_unit_test_teardown(test_rectangles_MP_22, harness_check),
        cmocka_unit_test_teardown(test_order_of_evaluations_ES_14_ES_15_ES_17_MP_22, harness_check),
        cmocka_unit_test_teardown(test_random_spheres_ES_15_ES_16, harness_check),
        cmocka_unit_test_teardown(test_tiles_against_rectangles_MP_23, harness_check),
        cmocka_unit_test_teardown(test_heat_map_TD_12, harness_check),
        cmocka_unit_test_teardown(test_one_light_at_a_time_ES_18, harness_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
