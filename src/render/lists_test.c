/* SPDX-License-Identifier: MIT */
/**
 * Every light list gives the same picture: bit-equal radiance for one shading order at any sample count, and 2/255 after tone mapping
 * between the orders. With multisampling, where in a pixel an edge is shaded may depend on what the depth test has left of it, so only
 * pictures of one order are compared.
 */
#include "render/shading.h"
#include "tests/render_harness.h"

enum { ALLOWED = 2 };

static const char *pair_name(const fnl_frame *frame) {
    static char text[96];
    snprintf(text, sizeof text, "%s + %s at %ux%u, %u samples", fnl_value_name(FNL_ENUM_SHADING, frame->shading),
             fnl_value_name(FNL_ENUM_LISTS, frame->lists), frame->width, frame->height, frame->msaa);
    return text;
}

/* Which pairs were compared, with one sample a pixel and with several. */
static uint32_t tried[2][FNL_SHADING_AUTO][FNL_LISTS_COUNT];

static bool is_comparable(fnl_shading shading, fnl_light_lists lists, uint32_t msaa) {
    if (!fnl_lists_supported(shading, lists) || (msaa > 1 && !fnl_msaa_supported(shading))) return false;
    /* Lists of blended surfaces alone, which all orders draw alike. */
    if (shading_is(shading, SHADING_VOLUMES)) return lists == FNL_LISTS_TILED || lists == FNL_LISTS_CLUSTERED;
    return msaa == 1 || (lists != FNL_LISTS_BATCHES && lists != FNL_LISTS_MULTIPASS); /* for which mesh lists stand in */
}

/* Shoots what the others are compared with. */
static struct shot shoot_all(struct stage *stage, fnl_frame frame) {
    frame.lists = FNL_LISTS_ALL;
    struct shot all = stage_shoot(stage, &frame);
    assert_int_equal(count_broken(&all.radiance), 0);
    if (frame.shading == FNL_SHADING_VIRTUAL_TEXTURING) /* pages come with the frames that want them */
        for (int i = 0; i < 3; i++) {
            shot_free(&all);
            all = stage_shoot(stage, &frame);
        }
    return all;
}

static void check_list(struct stage *stage, fnl_frame frame, fnl_light_lists lists, const struct shot *all) {
    frame.lists = lists;
    if (lists == FNL_LISTS_MULTIPASS && all->stats.lights_total > 256) return; /* draws all that overflows once per light */
    tried[frame.msaa > 1][frame.shading][lists]++;
    struct shot shot = stage_shoot(stage, &frame);
    if (shot.stats.overflow_cells) { /* right already, but the pool has to grow first */
        assert_int_equal(count_differing(&all->radiance, &shot.radiance), 0);
        shot_free(&shot);
        shot = stage_shoot(stage, &frame);
    }
    uint64_t differing = count_differing(&all->radiance, &shot.radiance);
    if (differing)
        fail_msg("%s: %llu pixels differ from all, %d/255 at most", pair_name(&frame), (unsigned long long)differing,
                 greatest_difference(&all->color, &shot.color));
    /* Lights that volumes write into pixels have so many layers; pixels with more are counted, and take all lights. */
    if (shot.stats.overflow_cells && !shading_is(frame.shading, SHADING_VOLUMES))
        fail_msg("%s: %u cells overflow", pair_name(&frame), shot.stats.overflow_cells);
    assert_int_equal(shot.stats.lights_total, all->stats.lights_total);
    shot_free(&shot);
}

/* Compares every `step`-th list of a shading order with `all`, whose picture is handed out. */
static struct shot check_lists(struct stage *stage, fnl_frame frame, uint32_t step, uint32_t phase) {
    struct shot all = shoot_all(stage, frame);
    for (uint32_t l = FNL_LISTS_TILED; l < FNL_LISTS_COUNT; l++)
        if (l % step == phase % step && is_comparable(frame.shading, (fnl_light_lists)l, frame.msaa))
            check_list(stage, frame, (fnl_light_lists)l, &all);
    return all;
}

enum { ORDERS = FNL_SHADING_AUTO };

/*
 * The order that tries a list in a turn. Each turn sees each list once. The orders go round: as many turns as there are orders see every pair
 * that can be compared.
 */
static fnl_shading order_of_list(fnl_light_lists lists, uint32_t turn, uint32_t msaa) {
    for (uint32_t k = 0; k < ORDERS; k++) {
        fnl_shading shading = (fnl_shading)(((uint32_t)lists + turn + k) % ORDERS);
        if (is_comparable(shading, lists, msaa)) return shading;
    }
    return FNL_SHADING_AUTO;
}

/* Every list once, with the orders of so many turns, and every order with all lights, which agree where they have one sample a pixel. */
static void check_orders(struct stage *stage, fnl_frame frame, uint32_t turns) {
    static uint32_t turn[2]; /* of one sample and several */
    uint32_t now = turn[frame.msaa > 1];
    turn[frame.msaa > 1] += turns;
    struct shot first = {0};
    for (uint32_t s = 0; s < ORDERS; s++) {
        frame.shading = (fnl_shading)s;
        if (frame.msaa > 1 && !fnl_msaa_supported(frame.shading)) continue;
        struct shot all = shoot_all(stage, frame);
        for (uint32_t l = FNL_LISTS_TILED; l < FNL_LISTS_COUNT; l++)
            for (uint32_t t = now; t < now + turns; t++)
                if (order_of_list((fnl_light_lists)l, t, frame.msaa) == frame.shading) {
                    check_list(stage, frame, (fnl_light_lists)l, &all);
                    break;
                }
        if (s == 0) {
            first = all;
            continue;
        }
        int difference = greatest_difference(&first.color, &all.color);
        if (difference > ALLOWED && frame.msaa == 1 && !shading_is(frame.shading, SHADING_APPROXIMATE))
            fail_msg("%s: %d/255 from forward", pair_name(&frame), difference);
        shot_free(&all);
    }
    shot_free(&first);
}

/* ---- EQ: every scene, shading order and list ---- */

struct scene_case {
    const char *source;
    uint32_t scattered;
    float ev;
    uint32_t msaa, turns; /* with several samples each list is tried with the orders of so many turns */
};

static void test_scene(void **state) {
    const struct scene_case *c = *state;
    struct stage stage = stage_open(c->source, c->scattered);
    fnl_frame frame = stage.frame;
    frame.ev = c->ev;
    frame.width = 113;
    frame.height = 65;
    check_orders(&stage, frame, 1);
    if (c->msaa > 1) {
        frame.msaa = c->msaa;
        frame.width = 61;
        frame.height = 37;
        check_orders(&stage, frame, c->turns);
    }
    stage_close(&stage);
}

/* A few pairs at a size that divides by nothing. */
static void test_odd_size(void **state) {
    UNUSED(state);
    static const struct {
        fnl_shading shading;
        fnl_light_lists lists;
    } pairs[] = {{FNL_SHADING_DEFERRED, FNL_LISTS_TILED},
                 {FNL_SHADING_DEFERRED, FNL_LISTS_CLUSTERED},
                 {FNL_SHADING_FORWARD_PREPASS, FNL_LISTS_TILED},
                 {FNL_SHADING_FORWARD_PREPASS, FNL_LISTS_CLUSTERED_CPU}};
    struct stage stage = stage_open("builtin:spheres?lights=24", 0);
    fnl_frame frame = stage.frame;
    frame.width = 641;
    frame.height = 359;
    struct shot all = {0};
    for (uint32_t i = 0; i < COUNT_OF(pairs); i++) {
        frame.shading = pairs[i].shading;
        if (i % 2 == 0) {
            shot_free(&all);
            frame.lists = FNL_LISTS_ALL;
            all = stage_shoot(&stage, &frame);
        }
        frame.lists = pairs[i].lists;
        struct shot shot = stage_shoot(&stage, &frame);
        if (count_differing(&all.radiance, &shot.radiance)) fail_msg("%s differs from all", pair_name(&frame));
        shot_free(&shot);
    }
    shot_free(&all);
    stage_close(&stage);
}

/* ---- EQ: cameras ---- */

static fnl_frame small_frame(const struct stage *stage) {
    fnl_frame frame = stage->frame;
    frame.width = 97;
    frame.height = 55;
    return frame;
}

static void test_cameras(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:spheres?lights=200", 0);
    fnl_camera scene_camera = stage.frame.camera;
    for (uint32_t kind = 0; kind < 5; kind++) {
        fnl_frame frame = small_frame(&stage);
        fnl_camera *camera = &frame.camera;
        if (kind == 0) { /* inside of many lights, one of them a hair away */
            fnl_light_params light;
            assert_int_equal(fnl_scene_query_light(stage.scene, 5, &light), FNL_OK);
            camera->position = light.position;
            camera->position.x += 1e-3f;
        } else if (kind == 1) {
            camera->orthographic = true;
            camera->vertical_extent = 8;
            camera->far_distance = 40;
        } else if (kind == 2) {
            camera->shift = (fnl_vec2){0.7f, -0.4f};
        } else if (kind == 3) { /* upside down, very wide */
            camera->up = (fnl_vec3){0.2f, -1, 0};
            camera->vertical_fov = 2.6f;
        } else { /* looks away: nothing but sky */
            camera->target = (fnl_vec3){scene_camera.position.x, scene_camera.position.y + 10, scene_camera.position.z + 10};
        }
        check_orders(&stage, frame, 1);
    }
    stage_close(&stage);
}

/* Lights of all shapes, a third of them cut by hulls, seen from outside and from inside of one of each shape. */
static void test_light_shapes(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:spheres?lights=0", 0);
    fnl_scatter_params scatter = fnl_scatter_params_default();
    scatter.count = 60;
    for (int k = FNL_LIGHT_POINT; k < FNL_LIGHT_KIND_COUNT; k++) scatter.shares[k] = 1;
    assert_int_equal(fnl_scene_scatter_light_shapes(stage.scene, &scatter), FNL_OK);
    struct random_state random = {6};
    for (uint32_t i = 0; i < scatter.count; i += 3) {
        fnl_light_id id = {i, stage.scene->lights.data[i].generation};
        const fnl_light_params *light = &stage.scene->lights.data[i].params;
        vec3 corners[20];
        for (uint32_t k = 0; k < COUNT_OF(corners); k++)
            corners[k] = vec3_add(light->position, vec3_make(random_range(&random, -2, 2), random_range(&random, -2, 2),
                                                             random_range(&random, -2, 2)));
        assert_int_equal(fnl_scene_set_light_hull(stage.scene, id, corners, COUNT_OF(corners)), FNL_OK);
    }
    check_orders(&stage, small_frame(&stage), 1);
    for (uint32_t i = 1; i <= 5; i++) { /* without hulls: 1, 2, 4, 5, 7 */
        const fnl_light_params *light = &stage.scene->lights.data[i + (i > 2) + (i > 4)].params;
        fnl_frame frame = stage.frame;
        frame.width = 75;
        frame.height = 53;
        frame.shading = i & 1 ? FNL_SHADING_DEFERRED : FNL_SHADING_FORWARD_PREPASS;
        frame.camera.position =
            vec3_add_scaled(light->position, light->direction, light->kind == FNL_LIGHT_BOX ? 0 : 0.2f * light->range);
        struct shot all = check_lists(&stage, frame, 4, i);
        shot_free(&all);
    }
    stage_close(&stage);
}

/* A mirrored instance among lights. */
static void test_mirrored_instance(void **state) {
    UNUSED(state);
    static const float positions[] = {-3, 0, 0, 3, 0, 0, 3, 4, 0, -3, 4, 0};
    static const uint32_t indices[] = {0, 1, 2, 0, 2, 3};
    struct stage stage = stage_open("builtin:spheres?lights=60", 0);
    fnl_mesh_params params = {.vertex_count = 4, .index_count = 6, .positions = positions, .indices = indices};
    fnl_mesh_id mesh;
    fnl_instance_id instance;
    fnl_mat4 mirror = {{-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0.5f, 0, 1.2f, 1}};
    assert_int_equal(fnl_scene_add_mesh(stage.scene, &params, &mesh), FNL_OK);
    assert_int_equal(fnl_scene_add_instance(stage.scene, mesh, &mirror, &instance), FNL_OK);
    check_orders(&stage, small_frame(&stage), 1);
    stage_close(&stage);
}

/* After the tests above: between them they have seen every pair that can be compared, with one sample a pixel and with several. */
static void test_every_pair_was_tried(void **state) {
    UNUSED(state);
    for (uint32_t msaa = 1; msaa <= 4; msaa += 3)
        for (uint32_t s = 0; s < ORDERS; s++)
            for (uint32_t l = FNL_LISTS_TILED; l < FNL_LISTS_COUNT; l++)
                if (is_comparable((fnl_shading)s, (fnl_light_lists)l, msaa) && !tried[msaa > 1][s][l])
                    fail_msg("%s + %s at %u samples was not tried", fnl_value_name(FNL_ENUM_SHADING, (fnl_shading)s),
                             fnl_value_name(FNL_ENUM_LISTS, (fnl_light_lists)l), msaa);
}

/* ---- numbers of lights ---- */

static void test_light_counts(void **state) {
    UNUSED(state);
    static const uint32_t counts[] = {0, 1, 255, 256, 257, 4096, 65536};
    for (uint32_t i = 0; i < COUNT_OF(counts); i++) {
        struct stage stage = stage_open("builtin:spheres?lights=0", counts[i]);
        fnl_frame frame = stage.frame;
        frame.width = 39;
        frame.height = 23;
        frame.shading = FNL_SHADING_DEFERRED;
        struct shot shot = check_lists(&stage, frame, 1, 0);
        assert_int_equal(shot.stats.lights_total, counts[i]);
        shot_free(&shot);
        stage_close(&stage);
    }
}

/* ---- decals ---- */

/* The list of decals with several samples: clusters, a tree and the spare list, which serves cells that overflow, give the same bits. */
static void test_decals_and_samples(void **state) {
    UNUSED(state);
    static const fnl_shading orders[] = {FNL_SHADING_FORWARD_PREPASS, FNL_SHADING_DEFERRED, FNL_SHADING_VISIBILITY};
    struct stage stage = stage_open("builtin:hall?lights=16&decals=300", 0);
    fnl_frame frame = small_frame(&stage);
    frame.ev = 3;
    frame.msaa = 4;
    frame.lists = FNL_LISTS_CLUSTERED;
    const uint32_t capacity = stage.renderer->decal_capacity, tree = stage.renderer->decal_tree;
    for (uint32_t s = 0; s < COUNT_OF(orders); s++) {
        frame.shading = orders[s];
        struct shot shots[3];
        for (uint32_t way = 0; way < COUNT_OF(shots); way++) {
            stage.renderer->decal_capacity = way == 2 ? 1 : capacity;
            stage.renderer->decal_tree = way == 1 ? 1 : tree;
            memset(stage.renderer->slot_frames, 0, sizeof stage.renderer->slot_frames);
            shots[way] = stage_shoot(&stage, &frame);
            assert_int_equal(shots[way].stats.decal_overflow > 0, way == 2);
            uint64_t differing = count_differing(&shots[0].radiance, &shots[way].radiance);
            if (differing) fail_msg("%s, way %u: %llu pixels differ", pair_name(&frame), way, (unsigned long long)differing);
        }
        frame.decals = FNL_DECALS_OFF;
        struct shot none = stage_shoot(&stage, &frame);
        frame.decals = FNL_DECALS_LISTS;
        assert_true(count_differing(&none.radiance, &shots[0].radiance) > 100);
        shot_free(&none);
        for (uint32_t way = 0; way < COUNT_OF(shots); way++) shot_free(&shots[way]);
    }
    stage_close(&stage);
}

/* ---- what lists share ---- */

/* Cones and rectangles of lights are made for the lists that test them, and for no others; the pictures stay the same. */
static void test_reaches_for_those_who_use_them(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:spheres?lights=60", 0);
    fnl_frame frame = stage.frame;
    frame.width = 65;
    frame.height = 37;
    frame.lists = FNL_LISTS_ALL;
    struct shot all = stage_shoot(&stage, &frame);
    char plan[65536];
    uint32_t with = 0, without = 0;
    for (uint32_t l = FNL_LISTS_TILED; l < FNL_LISTS_AUTO; l++) {
        frame.lists = (fnl_light_lists)l;
        if (!fnl_lists_supported(frame.shading, frame.lists)) continue;
        for (uint32_t v = 0; v < 3; v++) {
            frame.list = fnl_frame_default().list;
            frame.list.cone_tests = v == 0;
            frame.list.normal_cones = v == 0;
            frame.tiles.bounds = v == 2 ? FNL_TILE_BOUNDS_PROJECTED : FNL_TILE_BOUNDS_BOX;
            bool clusters = l == FNL_LISTS_CLUSTERED || l == FNL_LISTS_BVH || l == FNL_LISTS_SPARSE;
            bool tiles = l == FNL_LISTS_TILED || l == FNL_LISTS_HALFZ || l == FNL_LISTS_25D || l == FNL_LISTS_ENHANCED ||
                         l == FNL_LISTS_BACKFACE;
            bool uses = (clusters && v == 0) || (tiles && v != 1);
            struct shot shot = stage_shoot(&stage, &frame);
            assert_int_equal(count_differing(&all.radiance, &shot.radiance), 0);
            assert_true(fnl_renderer_print_plan(stage.renderer, plan, sizeof plan) < sizeof plan);
            if ((strstr(plan, "light reaches") != NULL) != uses)
                fail_msg("%s, variant %u: reaches %s", pair_name(&frame), v, uses ? "are missing" : "for nobody");
            with += uses;
            without += !uses && strstr(plan, "lights gather");
            shot_free(&shot);
        }
    }
    assert_true(with >= 10 && without >= 10);
    shot_free(&all);
    stage_close(&stage);
}

/* ---- overflow ---- */

static void check_overflow(struct stage *stage, fnl_frame frame, uint32_t capacity) {
    frame.lists = FNL_LISTS_ALL;
    struct shot all = stage_shoot(stage, &frame);
    for (uint32_t l = FNL_LISTS_TILED; l < FNL_LISTS_COUNT; l++) {
        frame.lists = (fnl_light_lists)l;
        /* These count before they store, and need no pool. */
        if (l == FNL_LISTS_TREE || l == FNL_LISTS_CLUSTERED_CPU || l == FNL_LISTS_GRID2D || l == FNL_LISTS_WORLD) continue;
        if (l == FNL_LISTS_AUTO || !fnl_lists_supported(frame.shading, frame.lists)) continue;
        uint32_t small = l == FNL_LISTS_ZBIN ? capacity / 40 : capacity; /* entries of z-bins are words of 32 lights */
        harness_set_pool(stage, 1u << 22);
        struct shot fits = stage_shoot(stage, &frame);
        assert_int_equal(fits.stats.overflow_cells, 0);
        if (fits.stats.list_entries <= small) fail_msg("%s: nothing can overflow", pair_name(&frame));
        assert_int_equal(count_differing(&all.radiance, &fits.radiance), 0);

        harness_set_pool(stage, small);
        struct shot over = stage_shoot(stage, &frame);
        if (count_differing(&all.radiance, &over.radiance)) fail_msg("%s differs in overflow", pair_name(&frame));
        if (over.stats.overflow_cells == 0 || over.stats.list_entries != fits.stats.list_entries)
            fail_msg("%s: %u cells overflow, %llu entries instead of %llu", pair_name(&frame), over.stats.overflow_cells,
                     (unsigned long long)over.stats.list_entries, (unsigned long long)fits.stats.list_entries);

        struct shot next = stage_shoot(stage, &frame); /* the pool has grown */
        assert_true(stage->renderer->pool_capacity >= fits.stats.list_entries / 2);
        if (next.stats.overflow_cells) fail_msg("%s: the pool has not grown", pair_name(&frame));
        assert_int_equal(next.stats.list_entries, fits.stats.list_entries);
        assert_int_equal(count_differing(&all.radiance, &next.radiance), 0);
        shot_free(&fits);
        shot_free(&over);
        shot_free(&next);
    }
    shot_free(&all);
}

static void test_overflow_ES_37(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:onetile?lights=1000", 0);
    check_overflow(&stage, stage.frame, 100);
    stage_close(&stage);
    stage = stage_open("builtin:glass?lights=300", 0); /* two lists: opaque and transparent tiles */
    check_overflow(&stage, stage.frame, 100);
    stage_close(&stage);
}

/* Without waiting for stats in between, the pool still grows a few frames later. */
static void test_overflow_in_flight(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:onetile?lights=400", 0);
    stage.frame.lists = FNL_LISTS_TILED;
    harness_set_pool(&stage, 10);
    for (uint32_t i = 0; i <= GPU_FRAMES_IN_FLIGHT; i++)
        assert_int_equal(fnl_renderer_render(stage.renderer, &stage.frame), FNL_OK);
    assert_true(stage.renderer->pool_capacity > 10);
    fnl_frame_stats stats;
    assert_int_equal(fnl_renderer_query_stats(stage.renderer, &stats), FNL_OK);
    assert_int_equal(stats.overflow_cells, 0);
    stage_close(&stage);
}

static void test_4096_lights_in_one_cluster(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:onetile?lights=0", 0);
    for (uint32_t i = 0; i < 4096; i++) {
        fnl_light_params light = fnl_light_params_default();
        fnl_light_id id;
        light.position = (fnl_vec3){0.4f + 1e-5f * (float)i, 0.3f, -19.7f};
        light.range = 0.6f;
        light.intensity = 0.01f;
        assert_int_equal(fnl_scene_add_light(stage.scene, &light, &id), FNL_OK);
    }
    check_overflow(&stage, stage.frame, 4000);
    stage_close(&stage);
}

/* ---- determinism ---- */

static void test_two_runs_and_threads(void **state) {
    UNUSED(state);
    static const fnl_shading orders[] = {FNL_SHADING_FORWARD, FNL_SHADING_FORWARD_PREPASS, FNL_SHADING_DEFERRED};
    struct shot shots[2][COUNT_OF(orders)][FNL_LISTS_COUNT];
    for (uint32_t run = 0; run < 2; run++) {
        struct stage stage = stage_open("builtin:glass?lights=200", 0);
        stage.frame.width = 97;
        stage.frame.height = 55;
        for (uint32_t s = 0; s < COUNT_OF(orders); s++)
            for (uint32_t l = 0; l < FNL_LISTS_COUNT; l++) {
                stage.frame.shading = orders[s];
                stage.frame.lists = (fnl_light_lists)l;
                shots[run][s][l] = (struct shot){0};
                if (!fnl_lists_supported(orders[s], stage.frame.lists)) continue;
                stage.frame.record_threads = run == 0 ? 1 : 4;
                shots[run][s][l] = stage_shoot(&stage, &stage.frame);
            }
        stage_close(&stage);
    }
    for (uint32_t s = 0; s < COUNT_OF(orders); s++)
        for (uint32_t l = 0; l < FNL_LISTS_COUNT; l++) {
            if (!shots[0][s][l].color.pixels) continue;
            assert_int_equal(count_differing(&shots[0][s][l].color, &shots[1][s][l].color), 0);
            assert_int_equal(count_differing(&shots[0][s][l].radiance, &shots[1][s][l].radiance), 0);
            assert_int_equal(shots[0][s][l].stats.list_entries, shots[1][s][l].stats.list_entries);
        }
    for (uint32_t i = 0; i < 2 * COUNT_OF(orders) * FNL_LISTS_COUNT; i++) shot_free(&shots[0][0][0] + i);
}

/* ---- one set of lists for all orders ---- */

static void test_same_lists_forward_and_deferred_ES_58(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:hall?lights=256", 0);
    stage.frame.ev = 3;
    for (uint32_t l = FNL_LISTS_CLUSTERED; l <= FNL_LISTS_CLUSTERED_CPU; l++) {
        stage.frame.lists = (fnl_light_lists)l;
        struct shot shots[FNL_SHADING_DEFERRED + 1];
        for (uint32_t s = 0; s < FNL_SHADING_DEFERRED + 1; s++) {
            stage.frame.shading = (fnl_shading)s;
            shots[s] = stage_shoot(&stage, &stage.frame);
            assert_true(shots[s].stats.list_entries > 100);
            assert_int_equal(shots[s].stats.list_entries, shots[0].stats.list_entries);
            assert_int_equal(shots[s].stats.lights_in_view, shots[0].stats.lights_in_view);
            assert_int_equal(shots[s].stats.cells, shots[0].stats.cells);
            assert_true(greatest_difference(&shots[0].color, &shots[s].color) <= ALLOWED);
        }
        for (uint32_t s = 0; s < FNL_SHADING_DEFERRED + 1; s++) shot_free(&shots[s]);
    }
    stage_close(&stage);
}

#define SCENE(name, source, scattered, ev, msaa, turns)                                                                     \
    {                                                                                                                       \
        "EQ of all orders and lists, ES-41 ES-42 ES-58 MP-23: " name, test_scene, NULL, harness_check,                      \
            &(struct scene_case) {                                                                                          \
            source, scattered, ev, msaa, turns                                                                              \
        }                                                                                                                   \
    }

int main(void) {
    const struct CMUnitTest tests[] = {
        SCENE("hall", "builtin:hall?lights=256", 0, 3, 4, 3),
        SCENE("interior", "builtin:interior", 0, 5, 4, 2),
        SCENE("city", "builtin:city?lights=512", 0, 3, 4, 1),
        SCENE("spheres", "builtin:spheres", 0, 5, 4, 2),
        SCENE("pole", "builtin:pole", 0, 5, 4, 2),
        SCENE("lamps", "builtin:lamps", 0, 5, 1, 0),
        SCENE("grass", "builtin:grass", 0, 5, 4, 3),
        SCENE("onetile", "builtin:onetile", 0, 5, 1, 0),
        SCENE("nearplane", "builtin:nearplane", 0, 5, 1, 0),
        SCENE("sky", "builtin:sky", 0, 5, 1, 0),
        SCENE("glass", "builtin:glass", 0, 5, 4, 4),
        SCENE("FlightHelmet", "FlightHelmet/FlightHelmet.gltf", 500, 2, 1, 0),
        cmocka_unit_test_teardown(test_odd_size, harness_check),
        cmocka_unit_test_teardown(test_cameras, harness_check),
        {"ES-1: EQ of lights of all shapes and hulls, seen from within", test_light_shapes, NULL, harness_check, NULL},
        cmocka_unit_test_teardown(test_mirrored_instance, harness_check),
        cmocka_unit_test_teardown(test_every_pair_was_tried, harness_check),
        cmocka_unit_test_teardown(test_light_counts, harness_check),
        cmocka_unit_test_teardown(test_decals_and_samples, harness_check),
        cmocka_unit_test_teardown(test_reaches_for_those_who_use_them, harness_check),
        cmocka_unit_test_teardown(test_overflow_ES_37, harness_check),
        cmocka_unit_test_teardown(test_overflow_in_flight, harness_check),
        cmocka_unit_test_teardown(test_4096_lights_in_one_cluster, harness_check),
        cmocka_unit_test_teardown(test_two_runs_and_threads, harness_check),
        cmocka_unit_test_teardown(test_same_lists_forward_and_deferred_ES_58, harness_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
