/* SPDX-License-Identifier: MIT */
/* Cubemap shadows in a room of 4 x 3 x 5 metres with a window in its ceiling, seen from above its floor: shadows whose edges are known, rays, and the tracer. */
#include "tests/render_harness.h"
#include "tests/shadow_cases.h"
#include "tests/shadow_leak.h"
#include "tests/shadow_paths.h"
#include "tests/trace_world.h"

enum { SIZE = 64, SIDE = 64 };
#define EXTENT 2.8f /* metres of the floor that are seen */
static const vec3 half = {2, 1.5f, 2.5f}, centre = {0, 1.5f, 0};
/* Across the border between two faces of the cube. */
static const struct {
    float x0, x1, z0, z1;
} window = {-0.6f, 1.7f, -0.5f, 0.7f};

struct room {
    struct stage s;
    fnl_probe_params probe;
    fnl_probe_id probe_id;
    fnl_light_params light;
    fnl_light_id light_id;
};

static void add_slab(fnl_scene *scene, float x0, float x1, float y, float z0, float z1) {
    const fnl_material_params white = matt(1);
    add_square(scene, &white, (vec3){0.5f * (x1 - x0), 1, 0.5f * (z1 - z0)}, (vec3){0.5f * (x0 + x1), y, 0.5f * (z0 + z1)});
}

static void add_wall(fnl_scene *scene, vec3 at, vec3 axis, float angle, vec3 scale) {
    const fnl_material_params white = matt(1);
    add_instance(scene, add_square_mesh(scene, add_material(scene, &white)), mat4_from_trs(at, quat_axis_angle(axis, angle), scale));
}

/* The ceiling is so many metres below where the box has it. */
static struct room room_open(float lower) {
    struct room r = {.probe = fnl_probe_params_default(), .light = fnl_light_params_default()};
    fnl_scene *scene = world_create(NULL);
    const float top = 2 * half.y - lower;
    add_slab(scene, -half.x, half.x, 0, -half.z, half.z);
    add_slab(scene, -half.x, window.x0, top, -half.z, half.z);
    add_slab(scene, window.x1, half.x, top, -half.z, half.z);
    add_slab(scene, window.x0, window.x1, top, -half.z, window.z0);
    add_slab(scene, window.x0, window.x1, top, window.z1, half.z);
    for (int side = -1; side <= 1; side += 2) {
        add_wall(scene, (vec3){(float)side * half.x, 1.5f, 0}, (vec3){0, 0, 1}, (float)side * PI / 2, (vec3){1.5f, 1, half.z});
        add_wall(scene, (vec3){0, 1.5f, (float)side * half.z}, (vec3){1, 0, 0}, (float)-side * PI / 2, (vec3){half.x, 1, 1.5f});
    }
    r.probe.centre = centre;
    r.probe.half_size = half;
    r.probe.face_size = SIDE;
    r.probe.wall = 0.02f + lower;
    assert_int_equal(fnl_scene_add_probe(scene, &r.probe, &r.probe_id), FNL_OK);
    r.light.kind = FNL_LIGHT_DIRECTIONAL;
    r.light.direction = (vec3){0, -1, 0};
    r.light.intensity = 10;
    assert_int_equal(fnl_scene_add_light(scene, &r.light, &r.light_id), FNL_OK);
    const fnl_trace_params view = look_down((vec3){0, 0, 0}, EXTENT, 0.05f, SIZE);
    r.s = shadow_stage(scene, &view);
    r.s.frame.shadows = FNL_SHADOWS_CUBEMAP;
    r.s.frame.shading = FNL_SHADING_FORWARD;
    r.s.frame.lists = FNL_LISTS_ALL;
    return r;
}

static void set_light(struct room *r) { assert_int_equal(fnl_scene_set_light(r->s.scene, r->light_id, &r->light), FNL_OK); }

static void set_sun(struct room *r, vec3 to_light) {
    r->light.kind = FNL_LIGHT_DIRECTIONAL;
    r->light.intensity = 10;
    r->light.direction = vec3_scale(vec3_normalize(to_light), -1);
    set_light(r);
}

static void set_lamp(struct room *r, vec3 at) {
    r->light.kind = FNL_LIGHT_POINT;
    r->light.position = at;
    r->light.intensity = 200;
    r->light.range = 50;
    set_light(r);
}

static void set_probe(struct room *r) { assert_int_equal(fnl_scene_set_probe(r->s.scene, r->probe_id, &r->probe), FNL_OK); }

static vec3 floor_at(uint32_t i) {
    const float pixel = EXTENT / SIZE;
    return (vec3){((float)(i % SIZE) + 0.5f) * pixel - EXTENT / 2, 0, ((float)(i / SIZE) + 0.5f) * pixel - EXTENT / 2};
}

static vec3 way_to_light(const struct room *r, vec3 v) {
    return r->light.kind == FNL_LIGHT_DIRECTIONAL ? vec3_scale(r->light.direction, -1) : vec3_sub(r->light.position, v);
}

/* Metres from where a pixel's ray meets the height of the ceiling to the edge of the window there; positive inside. */
static float inside_window(const struct room *r, vec3 v, float top, vec3 *out) {
    const vec3 way = way_to_light(r, v), p = vec3_add(v, vec3_scale(way, top / way.y));
    *out = p;
    return fminf(fminf(p.x - window.x0, window.x1 - p.x), fminf(p.z - window.z0, window.z1 - p.z));
}

struct verdict {
    uint32_t lit, dark, wrong; /* pixels that should be, and those of them that are not; none at the edge */
};

/* Of a picture of the floor: right but for a texel of the cube map on either side of the edge, `more` metres wider. */
static struct verdict judge(const struct room *r, const float *seen, float more, float lit) {
    struct verdict v = {0};
    for (uint32_t i = 0; i < SIZE * SIZE; i++) {
        vec3 p;
        const float depth = inside_window(r, floor_at(i), 2 * half.y, &p);
        const vec3 from = vec3_sub(p, vec3_add(centre, r->probe.capture));
        const float most = fmaxf(fabsf(from.x), fmaxf(fabsf(from.y), fabsf(from.z)));
        const float texel = 2 * most / (float)r->probe.face_size * most / fabsf(from.y); /* on the ceiling, where it is seen at an angle */
        const bool in_ceiling = fabsf(p.x) < half.x - 0.01f && fabsf(p.z) < half.z - 0.01f;
        if (fabsf(depth) < 1.1f * texel + more) continue; /* at the border of two faces theirs differ */
        const float wanted = depth > 0 && in_ceiling ? lit : 0;
        v.lit += wanted > 0;
        v.dark += wanted == 0;
        v.wrong += !(fabsf(seen[i] - wanted) < 0.02f);
    }
    return v;
}

static float seen[SIZE * SIZE], other[SIZE * SIZE];

static fnl_frame_stats expect_edges(struct room *r, float lit, const char *what) {
    const fnl_frame_stats stats = shadow_parts(&r->s, seen);
    const struct verdict v = judge(r, seen, 0, lit);
    if (v.wrong || v.lit < 200 || v.dark < 200) fail_msg("%s: %u pixels are wrong of %u lit and %u dark", what, v.wrong, v.lit, v.dark);
    return stats;
}

/* ---- edges that are known ---- */

static void test_suns_shine_through_the_window_LC_1(void **state) {
    UNUSED(state);
    static const vec3 ways[] = {{0, 1, 0}, {0.3f, 1, -0.2f}, {-0.5f, 1, 0.3f}, {0.1f, 1, 0.5f}};
    struct room r = room_open(0);
    for (uint32_t i = 0; i < COUNT_OF(ways); i++) {
        set_sun(&r, ways[i]);
        const fnl_frame_stats stats = expect_edges(&r, 1, "sun");
        assert_int_equal(counter(&stats, "probes.count"), 1);
        assert_int_equal(counter(&stats, "probes.baked"), i == 0);
    }
    /* A box that is turned, its sides the other way round, is the same box. */
    r.probe.rotation = quat_axis_angle((vec3){0, 0, 1}, PI / 2);
    r.probe.half_size = (vec3){half.y, half.x, half.z};
    set_probe(&r);
    const fnl_frame_stats stats = expect_edges(&r, 1, "turned box");
    assert_int_equal(counter(&stats, "probes.baked"), 1);
    stage_close(&r.s);
}

static void test_lamps_outside_move_without_a_bake_LC_2(void **state) {
    UNUSED(state);
    static const vec3 places[] = {{0.3f, 9, 0.1f}, {-1.2f, 6, 0.4f}, {2.5f, 8, -1.5f}, {-0.9f, 3.6f, 0.2f}};
    struct room r = room_open(0);
    for (uint32_t i = 0; i < COUNT_OF(places); i++) {
        set_lamp(&r, places[i]);
        const fnl_frame_stats stats = expect_edges(&r, 1, "lamp");
        assert_int_equal(counter(&stats, "probes.baked"), i == 0);
        assert_int_equal(counter(&stats, "probes.lights-inside"), 0);
    }
    stage_close(&r.s);
}

static void test_the_capture_may_be_anywhere_LC_4(void **state) {
    UNUSED(state);
    static const vec3 places[] = {{0.5f, 0.2f, -0.6f}, {-0.8f, -0.7f, 0.9f}, {0.9f, 0.3f, 1.1f}};
    struct room r = room_open(0);
    set_sun(&r, (vec3){0.3f, 1, -0.2f});
    r.probe.face_size = SIDE / 2; /* or pixels are wider than texels, and shadows softer */
    for (uint32_t i = 0; i < COUNT_OF(places); i++) {
        r.probe.capture = places[i];
        set_probe(&r);
        const fnl_frame_stats stats = expect_edges(&r, 1, "capture");
        assert_int_equal(counter(&stats, "probes.baked"), 1);
    }
    stage_close(&r.s);
}

/* Without the correction a lamp's light lies elsewhere. */
static void test_uncorrected_look_ups_are_wrong_LC_5(void **state) {
    UNUSED(state);
    struct room r = room_open(0);
    set_sun(&r, (vec3){0.3f, 1, -0.2f});
    r.s.frame.shadow.cubemap_correct = false;
    shadow_parts(&r.s, seen);
    const struct verdict v = judge(&r, seen, 0, 1);
    assert_true(v.wrong > SIZE * SIZE / 10);
    stage_close(&r.s);
}

/* Lights along the axes, on surfaces in the planes of the box. */
static void test_planes_and_axes_give_no_nan_LC_3(void **state) {
    UNUSED(state);
    struct room r = room_open(0);
    static const vec3 ways[] = {{0, 1, 0}, {1, 0, 0}, {0, 0, -1}, {1, 1, 0}, {0, 1, -1}};
    r.s.frame.camera.orthographic = false;
    r.s.frame.camera.position = (vec3){1.5f, 1.2f, 2};
    r.s.frame.camera.target = (vec3){-1, 1.5f, -1};
    for (uint32_t i = 0; i < COUNT_OF(ways); i++) {
        set_sun(&r, ways[i]);
        struct shot shot = stage_shoot(&r.s, &r.s.frame);
        assert_int_equal(count_broken(&shot.radiance), 0);
        shot_free(&shot);
    }
    stage_close(&r.s);
}

/* ---- softness ---- */

/* Metres between where a tenth and nine tenths of the light are seen, along x at the window's left edge; the mean over rows well inside. */
static double penumbra_width(const float *parts) {
    double at[2] = {0};
    for (uint32_t x = 1; x < SIZE / 2; x++) {
        double before = 0, now = 0;
        for (uint32_t y = SIZE / 2 - 6; y < SIZE / 2 + 6; y++) {
            before += (double)parts[y * SIZE + x - 1] / 12;
            now += (double)parts[y * SIZE + x] / 12;
        }
        for (int i = 0; i < 2; i++) {
            const double limit = i ? 0.9 : 0.1;
            if (before < limit && now >= limit && at[i] == 0) at[i] = x - (now - limit) / (now - before);
        }
    }
    return (at[1] - at[0]) * (double)EXTENT / SIZE;
}

static void look_at_height(struct room *r, float y) {
    r->s.frame.camera = look_down((vec3){0, y, 0}, EXTENT, 0.05f, SIZE).camera;
}

static void test_penumbras_grow_with_distance_LC_6(void **state) {
    UNUSED(state);
    struct room r = room_open(0);
    add_slab(r.s.scene, -1.9f, 1.9f, 1.8f, -2.4f, 2.4f); /* shelves, which are passed by */
    add_slab(r.s.scene, -1.9f, 1.9f, 1, -2.4f, 2.4f);
    r.s.frame.shadow.cubemap_inside = FNL_CUBEMAP_INSIDE_NONE;
    static const float heights[] = {1.8f, 1, 0};
    for (int physical = 0; physical < 2; physical++) {
        r.s.frame.shadow.cubemap_lod = physical ? FNL_CUBEMAP_LOD_PHYSICAL : FNL_CUBEMAP_LOD_LINEAR;
        r.light.source_angle = physical ? 0.12f : 0;
        set_sun(&r, (vec3){0, 1, 0});
        r.probe.softness = 0.6f;
        set_probe(&r);
        double last = 0;
        for (uint32_t i = 0; i < COUNT_OF(heights); i++) {
            look_at_height(&r, heights[i]);
            shadow_parts(&r.s, seen);
            const double width = penumbra_width(seen), distance = 3 - (double)heights[i], disk = 2 * tan(0.12) * distance * 0.69;
            if (!(width > last * 1.2)) fail_msg("%g m below the ceiling the penumbra is %g m wide, less than %g", distance, width, last);
            /* Of a disk's shadow, 0.69 of its diameter lie between a tenth and nine tenths. */
            if (physical && !(fabs(width - disk) < 0.25 * disk)) fail_msg("%g m below the ceiling the penumbra is %g m wide, not %g", distance, width, disk);
            last = width;
        }
    }
    /* Lights without a size, and softness 0, are hard alike. */
    r.light.source_angle = 0;
    set_sun(&r, (vec3){0, 1, 0});
    struct shot physical = stage_shoot(&r.s, &r.s.frame);
    r.s.frame.shadow.cubemap_lod = FNL_CUBEMAP_LOD_LINEAR;
    r.probe.softness = 0;
    set_probe(&r);
    struct shot linear = stage_shoot(&r.s, &r.s.frame);
    assert_int_equal(count_differing(&physical.radiance, &linear.radiance), 0);
    shot_free(&physical);
    shot_free(&linear);
    stage_close(&r.s);
}

static void test_penumbras_are_those_of_the_tracer_LC_6(void **state) {
    UNUSED(state);
    struct room r = room_open(0);
    r.s.frame.shadow.cubemap_lod = FNL_CUBEMAP_LOD_PHYSICAL;
    for (int lamp = 0; lamp < 2; lamp++) {
        if (lamp) r.light.source_radius = 0.3f, r.light.source_angle = 0;
        else r.light.source_angle = 0.1f;
        if (lamp) set_lamp(&r, (vec3){0.3f, 6, 0.1f});
        else set_sun(&r, (vec3){0.1f, 1, 0});
        shadow_parts(&r.s, seen);
        fnl_trace_params p = look_down((vec3){0, 0, 0}, EXTENT, 0.05f, SIZE);
        p.visibility = true;
        p.samples = 64;
        fnl_trace trace = trace_scene(r.s.scene, &p);
        double soft = 0, hard = 0;
        for (uint32_t i = 0; i < SIZE * SIZE; i++) {
            vec3 at;
            const double truth = (double)pixel_at(&trace.visibility, i % SIZE, i / SIZE)[0];
            soft += ((double)seen[i] - truth) * ((double)seen[i] - truth) / (SIZE * SIZE);
            const double edge = inside_window(&r, floor_at(i), 3, &at) > 0;
            hard += (edge - truth) * (edge - truth) / (SIZE * SIZE);
        }
        if (!(sqrt(soft) < 0.05 && soft < hard / 6)) fail_msg("%s: the error is %g, that of hard shadows %g", lamp ? "lamp" : "sun", sqrt(soft), sqrt(hard));
        fnl_trace_free(NULL, &trace);
    }
    stage_close(&r.s);
}

/* ---- glass ---- */

static void test_glass_colours_the_light_LC_7(void **state) {
    UNUSED(state);
    for (int coloured = 0; coloured < 2; coloured++) {
        struct room r = room_open(0);
        fnl_material_params glass = matt(0.8f);
        glass.alpha_mode = FNL_ALPHA_BLEND;
        glass.base_color[3] = 0.4f;
        if (coloured) glass.base_color[1] = 0.4f, glass.base_color[2] = 0.2f;
        add_square(r.s.scene, &glass, (vec3){0.5f * (window.x1 - window.x0), 1, 0.5f * (window.z1 - window.z0)},
                   (vec3){0.5f * (window.x0 + window.x1), 3, 0.5f * (window.z0 + window.z1)});
        set_sun(&r, (vec3){0.1f, 1, 0});
        expect_edges(&r, coloured ? 0.3f : 0.6f, "glass"); /* of green light */
        struct shot tinted = stage_shoot(&r.s, &r.s.frame);
        r.s.frame.shadow.cubemap_tint = false;
        expect_edges(&r, 0.6f, "glass without colour"); /* as bright as with rays */
        struct shot plain = stage_shoot(&r.s, &r.s.frame);
        const float *a = pixel_at(&tinted.radiance, SIZE / 2, SIZE / 2), *b = pixel_at(&plain.radiance, SIZE / 2, SIZE / 2);
        for (int c = 0; c < 3; c++)
            assert_true(fabsf(a[c] / b[c] - (coloured ? c == 0 ? 1 : c == 1 ? 0.5f : 0.25f : 1)) < 0.02f);
        shot_free(&tinted);
        shot_free(&plain);
        stage_close(&r.s);
    }
}

/* ---- several lights ---- */

static void test_lights_share_one_cube_map_LC_8(void **state) {
    UNUSED(state);
    struct room r = room_open(0);
    static double sum[SIZE * SIZE];
    r.s.frame.shadow.cubemap_inside = FNL_CUBEMAP_INSIDE_MOVING;
    r.s.frame.count_lights = true;
    uint32_t count = 0;
    memset(sum, 0, sizeof sum);
    uint64_t bytes = 0;
    for (uint32_t wanted = 1; wanted <= 16; wanted *= 2) {
        for (; count < wanted; count++) { /* what each gives by itself */
            set_lamp(&r, (vec3){-1.5f + 0.2f * (float)count, 4.5f, 0.6f - 0.1f * (float)count});
            for (uint32_t i = 0; i < r.s.scene->lights.count; i++) {
                r.s.scene->lights.data[i].params.intensity = i == 0 ? 200 : 0;
                scene_light_changed(r.s.scene, i);
            }
            struct shot one = stage_shoot(&r.s, &r.s.frame);
            for (uint32_t i = 0; i < SIZE * SIZE; i++) sum[i] += (double)pixel_at(&one.radiance, i % SIZE, i / SIZE)[0];
            shot_free(&one);
            fnl_light_id id;
            fnl_light_params copy = r.light;
            if (count > 0) assert_int_equal(fnl_scene_add_light(r.s.scene, &copy, &id), FNL_OK);
        }
        for (uint32_t i = 0; i < r.s.scene->lights.count; i++) {
            r.s.scene->lights.data[i].params.intensity = 200;
            if (i == 0) r.s.scene->lights.data[i].params.position = (vec3){-1.5f, 4.5f, 0.6f};
            scene_light_changed(r.s.scene, i);
        }
        struct shot all = stage_shoot(&r.s, &r.s.frame);
        assert_int_equal(counter(&all.stats, "shadows.rays"), 0); /* nothing but look-ups */
        assert_int_equal(counter(&all.stats, "probes.count"), 1);
        assert_int_equal(counter(&all.stats, "probes.baked"), 0);
        if (bytes) assert_int_equal(counter(&all.stats, "probes.bytes"), bytes);
        bytes = counter(&all.stats, "probes.bytes");
        for (uint32_t i = 0; i < SIZE * SIZE; i++) {
            const double got = (double)pixel_at(&all.radiance, i % SIZE, i / SIZE)[0];
            if (fabs(got - sum[i]) > 1e-4 * (1 + sum[i])) fail_msg("%u lights, pixel %u: %g, not %g", wanted, i, got, sum[i]);
        }
        shot_free(&all);
    }
    stage_close(&r.s);
}

/* ---- what moves, and what stands in the room ---- */

static void test_what_moves_casts_too_LC_9(void **state) {
    UNUSED(state);
    struct room r = room_open(0);
    const fnl_material_params white = matt(1);
    fnl_material_params glass = matt(0.8f);
    glass.alpha_mode = FNL_ALPHA_BLEND;
    glass.base_color[3] = 0.5f;
    add_square(r.s.scene, &glass, (vec3){0.5f * (window.x1 - window.x0), 1, 0.5f * (window.z1 - window.z0)},
               (vec3){0.5f * (window.x0 + window.x1), 3, 0.5f * (window.z0 + window.z1)});
    const fnl_instance_id moves = add_square(r.s.scene, &white, (vec3){0.3f, 1, 0.2f}, (vec3){0.5f, 1, 0.1f});
    set_sun(&r, (vec3){0, 1, 0});
    for (uint32_t frame = 0; frame < 5; frame++) {
        r.s.frame.shadow.cubemap_inside = frame % 2 ? FNL_CUBEMAP_INSIDE_MOVING : FNL_CUBEMAP_INSIDE_ALL;
        const float x = 0.5f - 0.2f * (float)frame;
        const mat4 place = mat4_mul(mat4_translation((vec3){x, 1, 0.1f}), mat4_scaling((vec3){0.3f, 1, 0.2f}));
        if (frame) assert_int_equal(fnl_scene_set_instance_transform(r.s.scene, moves, &place), FNL_OK);
        const fnl_frame_stats stats = shadow_parts(&r.s, seen);
        assert_int_equal(counter(&stats, "probes.baked"), frame < 2); /* without it, once it is known to move */
        uint32_t covered = 0;
        for (uint32_t i = 0; i < SIZE * SIZE; i++) {
            vec3 p;
            const vec3 v = floor_at(i);
            const float edge = inside_window(&r, v, 3, &p), shade = fminf(0.3f - fabsf(v.x - x), 0.2f - fabsf(v.z - 0.1f));
            if (fabsf(edge) < 0.07f || fabsf(shade) < 0.02f) continue;
            const float wanted = edge > 0 && shade < 0 ? 0.5f : 0; /* the product: glass dims once, walls and square do not darken twice */
            covered += edge > 0 && shade > 0;
            if (!(fabsf(seen[i] - wanted) < 0.02f)) fail_msg("frame %u, pixel %u: %g of the light, not %g", frame, i, (double)seen[i], (double)wanted);
        }
        assert_true(covered > 30);
    }
    /* It receives the shadow of the walls itself. */
    look_at_height(&r, 1);
    r.s.frame.shadow.cubemap_inside = FNL_CUBEMAP_INSIDE_ALL;
    const mat4 place = mat4_mul(mat4_translation((vec3){-0.6f, 1, 0.1f}), mat4_scaling((vec3){0.3f, 1, 0.2f}));
    assert_int_equal(fnl_scene_set_instance_transform(r.s.scene, moves, &place), FNL_OK);
    shadow_parts(&r.s, seen);
    const uint32_t row = SIZE / 2 + 2, left = (uint32_t)((-0.75f / EXTENT + 0.5f) * SIZE), right = (uint32_t)((-0.4f / EXTENT + 0.5f) * SIZE);
    assert_true(seen[row * SIZE + left] < 0.02f && fabsf(seen[row * SIZE + right] - 0.5f) < 0.02f);
    stage_close(&r.s);
}

/* A shutter in the window, which is baked until it moves. */
static void test_what_moves_leaves_the_wall_LC_9(void **state) {
    UNUSED(state);
    struct room r = room_open(0);
    const fnl_material_params white = matt(1);
    const fnl_instance_id shutter = add_square(r.s.scene, &white, (vec3){0.5f, 1, 1}, (vec3){0.1f, 3, 0});
    r.s.frame.shadow.cubemap_inside = FNL_CUBEMAP_INSIDE_MOVING;
    set_sun(&r, (vec3){0, 1, 0});
    for (uint32_t frame = 0; frame < 4; frame++) {
        const float x = 0.1f + 0.4f * (float)frame;
        const mat4 place = mat4_mul(mat4_translation((vec3){x, 3, 0}), mat4_scaling((vec3){0.5f, 1, 1}));
        if (frame) assert_int_equal(fnl_scene_set_instance_transform(r.s.scene, shutter, &place), FNL_OK);
        const fnl_frame_stats stats = shadow_parts(&r.s, seen);
        assert_int_equal(counter(&stats, "probes.baked"), frame < 2);
        for (uint32_t i = 0; i < SIZE * SIZE; i++) {
            vec3 p;
            const vec3 v = floor_at(i);
            const float edge = inside_window(&r, v, 3, &p), shade = 0.5f - fabsf(v.x - x);
            if (fabsf(edge) < 0.08f || fabsf(shade) < 0.07f) continue;
            const float wanted = edge > 0 && shade < 0;
            if (!(fabsf(seen[i] - wanted) < 0.02f)) fail_msg("frame %u, pixel %u: %g of the light, not %g", frame, i, (double)seen[i], (double)wanted);
        }
    }
    stage_close(&r.s);
}

/* ---- walls beside the box ---- */

/* The share of the light that is wrong, against rays. */
static double error_of(struct room *r) {
    double wrong = 0, all = 0;
    shadow_parts(&r->s, seen);
    r->s.frame.shadows = FNL_SHADOWS_RAYS;
    shadow_parts(&r->s, other);
    r->s.frame.shadows = FNL_SHADOWS_CUBEMAP;
    for (uint32_t i = 0; i < SIZE * SIZE; i++) {
        wrong += fabs((double)seen[i] - (double)other[i]);
        all += (double)other[i];
    }
    return wrong / all;
}

static void test_errors_grow_with_the_distance_of_walls_LC_10(void **state) {
    UNUSED(state);
    static const float lower[] = {0, 0.1f, 0.2f, 0.4f};
    double even = 0;
    for (uint32_t i = 0; i < COUNT_OF(lower); i++) {
        struct room r = room_open(lower[i]);
        set_sun(&r, (vec3){0.5f, 1, -0.3f});
        const double error = error_of(&r);
        /* An edge moves by the distance times the tangent of the angle, and by what the capture's own view of it differs: less than twice that of the height. */
        struct verdict v = judge(&r, seen, 2.2f * lower[i], 1);
        print_message("ceiling %g m below the box: %.3f of the light is wrong\n", (double)lower[i], error);
        if (i == 0) even = error;
        if (v.wrong || error > 0.04 + 0.9 * (double)lower[i] || (i > 0 && !(error > 1.5 * even)))
            fail_msg("%g m below the box: error %g after %g, %u pixels are wrong", (double)lower[i], error, even, v.wrong);
        stage_close(&r.s);
    }
}

/* ---- lights that come in ---- */

static void test_lights_in_the_room_are_left_to_rays_LC_11(void **state) {
    UNUSED(state);
    struct room r = room_open(0);
    for (int i = 0; i < 12; i++) {
        const float y = 3.6f - 0.22f * (float)i;
        set_lamp(&r, (vec3){0.2f, y, 0.1f});
        struct shot cube = stage_shoot(&r.s, &r.s.frame);
        const bool inside = y <= 3 + r.probe.wall;
        assert_int_equal(count_broken(&cube.radiance), 0);
        assert_int_equal(counter(&cube.stats, "probes.lights-inside"), inside);
        fnl_frame rays = r.s.frame;
        rays.shadows = FNL_SHADOWS_RAYS;
        struct shot truth = stage_shoot(&r.s, &rays);
        const uint64_t differing = count_differing(&cube.radiance, &truth.radiance);
        if (inside ? differing > 0 : differing > SIZE * SIZE / 8) fail_msg("at %g m %u pixels differ from rays", (double)y, (uint32_t)differing);
        shot_free(&cube);
        shot_free(&truth);
    }
    stage_close(&r.s);
}

/* ---- what is baked ---- */

struct texels {
    uint32_t *data;
    uint64_t bytes;
};

static struct texels bake(bool compressed) {
    struct room r = room_open(0);
    r.s.frame.shadow.cubemap_compress = compressed;
    fnl_material_params glass = matt(0.8f);
    glass.alpha_mode = FNL_ALPHA_BLEND;
    glass.base_color[1] = 0.3f;
    glass.base_color[3] = 0.4f;
    add_square(r.s.scene, &glass, (vec3){0.4f, 1, 0.3f}, (vec3){0.1f, 3, 0.1f});
    struct texels t = {.bytes = cubemap_bytes(SIDE, compressed)};
    struct gpu_buffer buffer;
    assert_int_equal(gpu_buffer_create(harness_device(), "texels", t.bytes, GPU_MEMORY_READBACK, &buffer), FNL_OK);
    harness_hooks(r.s.renderer)->probe_tap = &buffer;
    struct shot shot = stage_shoot(&r.s, &r.s.frame);
    harness_hooks(r.s.renderer)->probe_tap = NULL;
    t.data = malloc(t.bytes);
    assert_non_null(t.data);
    memcpy(t.data, buffer.mapped, t.bytes);
    shot_free(&shot);
    assert_int_equal(gpu_wait_idle(harness_device()), FNL_OK);
    gpu_buffer_destroy(harness_device(), &buffer);
    stage_close(&r.s);
    return t;
}

/* Alpha, 0 .. 255, in the direction of a place beside or on a face of a level. */
static double alpha_beside(const struct texels *t, uint32_t side, uint32_t face, int x, int y) {
    static const float axes[6][3][3] = {/* across, down, out of each face */
                                        {{0, 0, -1}, {0, -1, 0}, {1, 0, 0}}, {{0, 0, 1}, {0, -1, 0}, {-1, 0, 0}}, {{1, 0, 0}, {0, 0, 1}, {0, 1, 0}},
                                        {{1, 0, 0}, {0, 0, -1}, {0, -1, 0}}, {{1, 0, 0}, {0, -1, 0}, {0, 0, 1}},  {{-1, 0, 0}, {0, -1, 0}, {0, 0, -1}}};
    const float u = 2 * ((float)x + 0.5f) / (float)side - 1, v = 2 * ((float)y + 0.5f) / (float)side - 1;
    float d[3], at[2] = {0};
    for (int k = 0; k < 3; k++) d[k] = axes[face][2][k] + u * axes[face][0][k] + v * axes[face][1][k];
    uint32_t best = 0;
    float most = 0;
    for (uint32_t f = 0; f < 6; f++) {
        float out = 0;
        for (int k = 0; k < 3; k++) out += d[k] * axes[f][2][k];
        if (out > most * 1.00001f) most = out, best = f;
    }
    for (int a = 0; a < 2; a++)
        for (int k = 0; k < 3; k++) at[a] += d[k] * axes[best][a][k] / most;
    uint32_t first = 0;
    for (uint32_t s = SIDE; s > side; s /= 2) first += 6 * s * s;
    const int px = (int)((at[0] * 0.5f + 0.5f) * (float)side), py = (int)((at[1] * 0.5f + 0.5f) * (float)side);
    const uint32_t clamped[2] = {(uint32_t)MIN(MAX(px, 0), (int)side - 1), (uint32_t)MIN(MAX(py, 0), (int)side - 1)};
    return t->data[first + (best * side + clamped[1]) * side + clamped[0]] >> 24;
}

static void test_bakes_are_the_same_and_have_no_seams_LC_15(void **state) {
    UNUSED(state);
    struct texels a = bake(false), b = bake(false);
    assert_memory_equal(a.data, b.data, a.bytes);
    uint32_t open = 0, opaque = 0;
    for (uint32_t i = 0; i < 6 * SIDE * SIDE; i++) {
        open += a.data[i] >> 24 == 255;
        opaque += a.data[i] >> 24 == 0;
    }
    assert_true(open > 200 && opaque > 15000);
    /* Steps over the edge between the faces that the window crosses are no higher than on either side of it. */
    for (uint32_t side = SIDE / 2; side >= 8; side /= 2) {
        double over = 0, beside = 0;
        for (uint32_t y = 0; y < side; y++) {
            const int last = (int)side - 1, row = (int)y;
            const double t[4] = {alpha_beside(&a, side, 2, last - 1, row), alpha_beside(&a, side, 2, last, row), alpha_beside(&a, side, 2, last + 1, row),
                                 alpha_beside(&a, side, 2, last + 2, row)};
            over = fmax(over, fabs(t[2] - t[1]));
            beside = fmax(beside, fmax(fabs(t[1] - t[0]), fabs(t[3] - t[2])));
        }
        if (over > beside * 1.1 + 2) fail_msg("faces of %u texels: a step of %g over the edge, of %g beside it", side, over, beside);
    }
    free(a.data);
    free(b.data);
}

/* What a block of BC3 holds, RGBA, 0 .. 255 (Khronos Data Format Specification). */
static void bc3_decode(const uint8_t block[16], double out[16][4]) {
    uint64_t codes = 0;
    for (int i = 0; i < 6; i++) codes |= (uint64_t)block[2 + i] << (8 * i);
    double alphas[8] = {block[0], block[1]}, colors[4][3];
    for (int k = 1; k < 7; k++) alphas[k + 1] = block[0] > block[1] ? ((7 - k) * alphas[0] + k * alphas[1]) / 7 : NAN;
    for (int e = 0; e < 2; e++) {
        const uint32_t packed = block[8 + 2 * e] | (uint32_t)block[9 + 2 * e] << 8;
        colors[e][0] = (packed >> 11) * 255 / 31.0, colors[e][1] = (packed >> 5 & 63) * 255 / 63.0, colors[e][2] = (packed & 31) * 255 / 31.0;
    }
    for (int c = 0; c < 3; c++) colors[2][c] = (2 * colors[0][c] + colors[1][c]) / 3, colors[3][c] = (colors[0][c] + 2 * colors[1][c]) / 3;
    for (int i = 0; i < 16; i++) {
        memcpy(out[i], colors[block[12 + i / 4] >> (2 * (i % 4)) & 3], sizeof colors[0]);
        out[i][3] = alphas[codes >> (3 * i) & 7];
    }
}

/* Blocks against the texels that they were made of, in each level: a quarter of the bytes, and little error. */
static void test_compression_keeps_alpha_LC_12(void **state) {
    UNUSED(state);
    fnl_device_info info;
    assert_int_equal(fnl_device_query_info(harness_device(), &info), FNL_OK);
    if (!info.texture_compression) skip();
    struct texels t = bake(false), packed = bake(true);
    assert_in_range(packed.bytes, t.bytes / 4, t.bytes / 4 + 6 * 16 * 2);
    const uint8_t *block = (const uint8_t *)packed.data;
    for (uint32_t side = SIDE, first = 0; side >= 1; first += 6 * side * side, side /= 2) {
        const uint32_t across = DIVIDE_UP(side, 4u);
        double sums[2] = {0};
        uint32_t alphas[256] = {0}, different = 0;
        for (uint32_t b = 0; b < 6 * across * across; b++, block += 16) {
            double out[16][4];
            bc3_decode(block, out);
            for (uint32_t i = 0; i < 16; i++) {
                const uint32_t x = b % across * 4 + i % 4, y = b / across % across * 4 + i / 4;
                if (x >= side || y >= side) continue;
                const uint32_t word = t.data[first + (b / (across * across) * side + y) * side + x];
                for (int c = 0; c < 4; c++) {
                    const double off = out[i][c] - (word >> (8 * c) & 255);
                    sums[c == 3] += off * off;
                }
                different += alphas[word >> 24]++ == 0;
            }
        }
        const double color = sqrt(sums[0] / (18.0 * side * side)) / 255, alpha = sqrt(sums[1] / (6.0 * side * side)) / 255;
        print_message("BC3, %3u texels: RMSE of color %.5f, of alpha %.5f (%u values)\n", side, color, alpha, different);
        assert_true(color < 0.03 && alpha < 0.02);
        if (side == SIDE) assert_true(different > 2);
    }
    assert_ptr_equal(block, (const uint8_t *)packed.data + packed.bytes);
    free(t.data);
    free(packed.data);
}

static double relative_difference(const fnl_image *a, const fnl_image *b) {
    double off = 0, sum = 0;
    for (size_t i = 0; i < (size_t)a->width * a->height * 4; i++) {
        off += fabs((double)((const float *)a->pixels)[i] - (double)((const float *)b->pixels)[i]);
        sum += (double)((const float *)b->pixels)[i];
    }
    return off / sum;
}

/* What is seen of it: little at the edges of shadows, for a quarter of the memory; and the option is heeded from frame to frame. */
static void test_compression_shows_little_LC_12(void **state) {
    UNUSED(state);
    fnl_device_info info;
    assert_int_equal(fnl_device_query_info(harness_device(), &info), FNL_OK);
    if (!info.texture_compression) skip();
    for (int soft = 0; soft < 2; soft++) {
        struct room r = room_open(0);
        r.probe.softness = soft ? 0.7f : 0;
        set_probe(&r);
        set_lamp(&r, (vec3){-0.4f, 5, 0.3f});
        struct shot shots[3];
        uint64_t bytes[3];
        for (int i = 0; i < 3; i++) {
            r.s.frame.shadow.cubemap_compress = i == 1;
            shots[i] = stage_shoot(&r.s, &r.s.frame);
            bytes[i] = counter(&shots[i].stats, "probes.bytes");
        }
        const double off = relative_difference(&shots[1].radiance, &shots[0].radiance);
        print_message("%s shadows: %.5f off, %u of %u bytes\n", soft ? "soft" : "hard", off, (uint32_t)bytes[1], (uint32_t)bytes[0]);
        assert_true(off < (soft ? 0.03 : 0.005) && (!soft || off > 0));
        assert_in_range(bytes[1], bytes[0] / 4, bytes[0] / 3);
        assert_int_equal(bytes[0], bytes[2]);
        assert_int_equal(count_differing(&shots[0].radiance, &shots[2].radiance), 0);
        for (int i = 0; i < 3; i++) shot_free(&shots[i]);
        stage_close(&r.s);
    }
}

/* ---- moving viewers, lists and paths ---- */

/* The view moves by a pixel: what it shows is the same, a pixel on. */
static void test_shadows_do_not_shimmer_LC_13(void **state) {
    UNUSED(state);
    struct room r = room_open(0);
    r.probe.softness = 0.7f;
    set_probe(&r);
    set_lamp(&r, (vec3){-0.4f, 5, 0.3f});
    shadow_parts(&r.s, seen);
    for (uint32_t step = 1; step < 4; step++) {
        r.s.frame.camera = look_down((vec3){(float)step * EXTENT / SIZE, 0, 0}, EXTENT, 0.05f, SIZE).camera;
        shadow_parts(&r.s, other);
        for (uint32_t i = 0; i < SIZE * SIZE; i++)
            if (i % SIZE + step < SIZE && fabsf(other[i] - seen[i + step]) > 2e-3f)
                fail_msg("%u pixels on, pixel %u is %g, not %g", step, i, (double)other[i], (double)seen[i + step]);
    }
    stage_close(&r.s);
}

/* ---- two rooms ---- */

#define WALL 0.02f

/*
 * The floor of two rooms whose boxes share x = -1 .. 1, under a sun above: that of the first has a ceiling, the other is higher and has none. `first` and
 * `second`: 0 or 1, the probes in their order; 2: none.
 */
static void see_two_rooms(uint32_t first, uint32_t second, float *out) {
    fnl_scene *scene = world_create(NULL);
    fnl_probe_params probes[2] = {fnl_probe_params_default(), fnl_probe_params_default()};
    add_slab(scene, -5, 5, 0, -3, 3);
    add_slab(scene, -4.5f, 1.5f, 3, -3, 3);
    probes[0].centre = (vec3){-1.5f, 1.5f, 0};
    probes[0].half_size = (vec3){2.5f, 1.5f, 2};
    probes[1].centre = (vec3){1.5f, 2.5f, 0};
    probes[1].half_size = (vec3){2.5f, 2.5f, 2};
    for (uint32_t i = 0; i < 2; i++) {
        const uint32_t which = i ? second : first;
        fnl_probe_id id;
        if (which == 2) continue;
        probes[which].face_size = SIDE;
        probes[which].wall = WALL;
        assert_int_equal(fnl_scene_add_probe(scene, &probes[which], &id), FNL_OK);
    }
    fnl_light_params sun = fnl_light_params_default();
    fnl_light_id id;
    sun.kind = FNL_LIGHT_DIRECTIONAL;
    sun.direction = (vec3){0, -1, 0};
    assert_int_equal(fnl_scene_add_light(scene, &sun, &id), FNL_OK);
    const fnl_trace_params view = look_down((vec3){0, 0, 0}, EXTENT, 0.05f, SIZE);
    struct stage s = shadow_stage(scene, &view);
    s.frame.shadows = FNL_SHADOWS_CUBEMAP;
    s.frame.shading = FNL_SHADING_FORWARD;
    s.frame.lists = FNL_LISTS_ALL;
    s.frame.shadow.cubemap_inside = FNL_CUBEMAP_INSIDE_NONE;
    shadow_parts(&s, out);
    stage_close(&s);
}

/* Where both boxes are, both count, by how far their borders are; elsewhere each is as it is alone, to the bit. No step is larger than the slope. */
static void test_two_probes_are_blended_LC_16(void **state) {
    UNUSED(state);
    static float both[SIZE * SIZE], turned[SIZE * SIZE];
    see_two_rooms(0, 2, seen);
    see_two_rooms(1, 2, other);
    see_two_rooms(0, 1, both);
    see_two_rooms(1, 0, turned);
    const float reach = 1 + WALL;
    uint32_t alone[2] = {0}, shared = 0;
    for (uint32_t i = 0; i < SIZE * SIZE; i++) {
        const float x = floor_at(i).x, at = fminf(fmaxf((x + reach) / (2 * reach), 0), 1);
        const bool near_edge = x > 0.85f && x < 1.1f; /* texels across the edge of the ceiling's box, of which next to nothing is taken */
        if (fabsf(both[i] - at) > (near_edge ? 0.04f : 0.005f)) fail_msg("at %g: %g of the light, should be %g", (double)x, (double)both[i], (double)at);
        if (fabsf(both[i] - turned[i]) > 1e-5f) fail_msg("at %g: %g, in the other order %g", (double)x, (double)both[i], (double)turned[i]);
        if (fabsf(x) > reach) assert_true(both[i] == (x < 0 ? seen : other)[i] && both[i] == turned[i]);
        alone[0] += x < -reach;
        alone[1] += x > reach;
        shared += both[i] > 0.02f && both[i] < 0.98f;
        if (i % SIZE && fabsf(both[i] - both[i - 1]) > 0.04f) fail_msg("at %g: a step of %g", (double)x, (double)(both[i] - both[i - 1]));
    }
    assert_true(alone[0] > SIZE * 5 && alone[1] > SIZE * 5 && shared > SIZE * SIZE / 2);
}

static void test_paths_and_lists_agree_LC_8(void **state) {
    UNUSED(state);
    struct stage s = stage_open("builtin:glass?lights=12", 0);
    fnl_probe_params probe = fnl_probe_params_default();
    fnl_probe_id id;
    probe.centre = (vec3){0, 2, -5};
    probe.half_size = (vec3){4, 1.9f, 4};
    probe.face_size = 32;
    assert_int_equal(fnl_scene_add_probe(s.scene, &probe, &id), FNL_OK);
    s.frame.width = 48, s.frame.height = 27;
    s.frame.shadows = FNL_SHADOWS_CUBEMAP;
    s.frame.outputs = FNL_OUTPUT_RADIANCE;
    s.frame.lists = FNL_LISTS_ALL;
    struct shot all = stage_shoot(&s, &s.frame);
    s.frame.lists = FNL_LISTS_CLUSTERED;
    struct shot clustered = stage_shoot(&s, &s.frame);
    assert_int_equal(count_differing(&all.radiance, &clustered.radiance), 0);
    assert_int_equal(count_broken(&all.radiance), 0);
    shot_free(&all);
    shot_free(&clustered);
    stage_close(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_suns_shine_through_the_window_LC_1, harness_check),
        cmocka_unit_test_teardown(test_lamps_outside_move_without_a_bake_LC_2, harness_check),
        cmocka_unit_test_teardown(test_planes_and_axes_give_no_nan_LC_3, harness_check),
        cmocka_unit_test_teardown(test_the_capture_may_be_anywhere_LC_4, harness_check),
        cmocka_unit_test_teardown(test_uncorrected_look_ups_are_wrong_LC_5, harness_check),
        cmocka_unit_test_teardown(test_penumbras_grow_with_distance_LC_6, harness_check),
        cmocka_unit_test_teardown(test_penumbras_are_those_of_the_tracer_LC_6, harness_check),
        cmocka_unit_test_teardown(test_glass_colours_the_light_LC_7, harness_check),
        cmocka_unit_test_teardown(test_lights_share_one_cube_map_LC_8, harness_check),
        cmocka_unit_test_teardown(test_paths_and_lists_agree_LC_8, harness_check),
        cmocka_unit_test_teardown(test_two_probes_are_blended_LC_16, harness_check),
        cmocka_unit_test_teardown(test_what_moves_casts_too_LC_9, harness_check),
        cmocka_unit_test_teardown(test_what_moves_leaves_the_wall_LC_9, harness_check),
        cmocka_unit_test_teardown(test_errors_grow_with_the_distance_of_walls_LC_10, harness_check),
        cmocka_unit_test_teardown(test_lights_in_the_room_are_left_to_rays_LC_11, harness_check),
        cmocka_unit_test_teardown(test_compression_keeps_alpha_LC_12, harness_check),
        cmocka_unit_test_teardown(test_compression_shows_little_LC_12, harness_check),
        cmocka_unit_test_teardown(test_shadows_do_not_shimmer_LC_13, harness_check),
        cmocka_unit_test_teardown(test_bakes_are_the_same_and_have_no_seams_LC_15, harness_check),
    };
    return cmocka_run_group_tests_name("cubemap_shadows", tests, harness_begin, harness_end);
}
