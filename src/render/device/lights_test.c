/* SPDX-License-Identifier: MIT */
/**
 * Lights that change are sent alone: the bytes of a frame are those of the lights that changed since the last and of their bounds, and
 * pictures equal those of a renderer that has just sent everything.
 */
#include "tests/render_harness.h"
#include "tests/render_test.h"

/* Directional lights have no bounds. */
enum { LIGHTS = 400, SUN_BYTES = sizeof(struct gpu_light), LIGHT_BYTES = SUN_BYTES + sizeof(struct gpu_entity_bounds) };
_Static_assert(LIGHT_BYTES == 116, "what the edit of a light sends");

static fnl_light_id ids[4 * LIGHTS];

static fnl_light_params some_light(uint32_t i) {
    fnl_light_params light = fnl_light_params_default();
    light.kind = (fnl_light_kind)(FNL_LIGHT_POINT + (i + i / 6) % 6); /* of any third light, too */
    uint32_t at = i * 61 % LIGHTS; /* a few are all over the scene, too */
    light.position = vec3_make((float)(at % 20) * 0.5f - 5, 0.5f + (float)(i % 3) * 0.4f, (float)(at / 20) * 0.5f - 5);
    light.direction = vec3_make(0.6f, -0.8f, 0);
    light.intensity = 20;
    light.range = 1.5f;
    return light;
}

static struct stage open_lights(uint32_t count) {
    struct stage s = stage_open("builtin:spheres?lights=0", 0);
    s.frame.width = 65;
    s.frame.height = 37;
    s.frame.lists = FNL_LISTS_TILED;
    s.frame.exposure = FNL_EXPOSURE_NONE;
    for (uint32_t i = 0; i < count; i++) {
        fnl_light_params light = some_light(i);
        assert_int_equal(fnl_scene_add_light(s.scene, &light, &ids[i]), FNL_OK);
    }
    return s;
}

static void move(struct stage *s, uint32_t i, float by) {
    fnl_light_params light = some_light(i);
    light.position.y += by;
    light.position.x += 0.3f * by;
    light.color[1] = 0.2f;
    assert_int_equal(fnl_scene_set_light(s->scene, ids[i], &light), FNL_OK);
}

/* Renders a frame that must send so many bytes, and the same with a renderer of its own. */
static void check_frame(struct stage *s, uint64_t bytes) {
    struct shot shot = stage_shoot(s, &s->frame);
    if (s->renderer->device_scene->light_bytes_sent != bytes)
        fail_msg("%llu bytes of lights sent, not %llu", (unsigned long long)s->renderer->device_scene->light_bytes_sent,
                 (unsigned long long)bytes);
    struct stage fresh = *s;
    fresh.renderer = test_renderer(s->scene);
    struct shot other = stage_shoot(&fresh, &fresh.frame);
    assert_int_equal(count_differing(&shot.radiance, &other.radiance), 0);
    assert_int_equal(shot.stats.list_entries, other.stats.list_entries);
    fnl_renderer_destroy(&fresh.renderer);
    shot_free(&shot);
    shot_free(&other);
}

static void test_few_lights_move(void **state) {
    UNUSED(state);
    struct stage s = open_lights(LIGHTS);
    check_frame(&s, LIGHTS * LIGHT_BYTES);
    check_frame(&s, 0);
    static const uint32_t counts[] = {1, 2, 3, 17, LIGHTS / 2, LIGHTS / 2 + 1, LIGHTS};
    for (uint32_t c = 0; c < COUNT_OF(counts); c++) {
        for (uint32_t k = 0; k < counts[c]; k++) move(&s, (k * 7 + c) % LIGHTS, 0.1f * (float)(c + 1));
        move(&s, c % LIGHTS, 0.7f);                                                   /* a second time */
        check_frame(&s, (counts[c] > LIGHTS / 2 ? LIGHTS : counts[c]) * LIGHT_BYTES); /* most of them: all in one piece */
    }
    check_frame(&s, 0);
    assert_int_equal(fnl_scene_set_ambient(s.scene, (fnl_vec3){1, 2, 3}, (fnl_vec3){1, 1, 1}), FNL_OK);
    check_frame(&s, 0);
    stage_close(&s);
}

/* Lights that come, go or become directional, with some that move beside them: each is sent alone, to or from the place that it keeps. */
static void test_lights_come_and_go(void **state) {
    UNUSED(state);
    struct stage s = open_lights(LIGHTS);
    check_frame(&s, LIGHTS * LIGHT_BYTES);
    move(&s, 3, 1);
    assert_int_equal(fnl_scene_remove_light(s.scene, ids[5]), FNL_OK);
    move(&s, 9, 1);
    check_frame(&s, 3 * LIGHT_BYTES);
    move(&s, LIGHTS - 1, 1); /* behind the hole */
    check_frame(&s, LIGHT_BYTES);
    fnl_light_params sun = fnl_light_params_default();
    sun.kind = FNL_LIGHT_DIRECTIONAL;
    sun.direction = vec3_make(0, -1, 0);
    assert_int_equal(fnl_scene_set_light(s.scene, ids[40], &sun), FNL_OK); /* to the front; its place is free */
    check_frame(&s, SUN_BYTES + LIGHT_BYTES);
    sun.intensity = 3;
    assert_int_equal(fnl_scene_set_light(s.scene, ids[40], &sun), FNL_OK);
    move(&s, 41, 0.5f);
    check_frame(&s, SUN_BYTES + LIGHT_BYTES);
    fnl_light_id more[5]; /* directional lights are sent together; the fifth finds the room for them full */
    for (uint32_t i = 0; i < 5; i++) {
        assert_int_equal(fnl_scene_add_light(s.scene, &sun, &more[i]), FNL_OK);
        check_frame(&s, (2 + i) * SUN_BYTES + (i == 3 ? LIGHTS * LIGHT_BYTES : 0));
    }
    assert_int_equal(fnl_scene_remove_light(s.scene, more[1]), FNL_OK);
    check_frame(&s, 5 * SUN_BYTES);
    for (uint32_t i = 0; i < 5; i++)
        if (i != 1) assert_int_equal(fnl_scene_remove_light(s.scene, more[i]), FNL_OK);
    move(&s, 40, 0.5f);
    check_frame(&s, LIGHT_BYTES);
    fnl_light_params light = some_light(5);
    assert_int_equal(fnl_scene_add_light(s.scene, &light, &ids[5]), FNL_OK);
    check_frame(&s, LIGHT_BYTES);
    for (uint32_t i = 0; i < 3; i++) { /* the first does not fit: what is there is copied on the device */
        assert_int_equal(fnl_scene_add_light(s.scene, &light, &ids[LIGHTS + i]), FNL_OK);
        check_frame(&s, LIGHT_BYTES);
    }
    assert_int_equal(fnl_scene_set_light_cutoff(s.scene, 0.5f, 0.1f), FNL_OK);
    check_frame(&s, (LIGHTS + 3) * LIGHT_BYTES);
    stage_close(&s);
}

/* A light keeps its place whatever comes and goes around it. A place that is free is taken again, the lowest first. */
static void test_places_last(void **state) {
    UNUSED(state);
    enum { FEW = 64, ROUNDS = 40 };
    struct stage s = open_lights(FEW);
    check_frame(&s, FEW * LIGHT_BYTES);
    struct random_state random = {7};
    uint32_t owners[FEW], slots[FEW], count = FEW; /* the light at each place, and the other way round; FEW: none */
    for (uint32_t i = 0; i < FEW; i++) owners[i] = slots[i] = i;
    for (uint32_t round = 0; round < ROUNDS; round++) {
        uint32_t changes = 1 + random_bits(&random) % 9;
        for (uint32_t k = 0; k < changes; k++) {
            uint32_t i = random_bits(&random) % FEW, least = 0;
            if (slots[i] < FEW) {
                assert_int_equal(fnl_scene_remove_light(s.scene, ids[i]), FNL_OK);
                owners[slots[i]] = FEW;
                slots[i] = FEW;
                count--;
                continue;
            }
            while (owners[least] < FEW) least++;
            fnl_light_params light = some_light(i);
            uint32_t generation = ids[i].generation;
            assert_int_equal(fnl_scene_add_light(s.scene, &light, &ids[i]), FNL_OK);
            assert_int_not_equal(ids[i].generation, generation);
            owners[least] = i;
            slots[i] = least;
            count++;
        }
        uint32_t end = 0;
        for (uint32_t place = 0; place < FEW; place++) {
            if (owners[place] == FEW) continue;
            fnl_light_id id = ids[owners[place]];
            assert_int_equal(s.scene->lights.data[id.index].slot, place);
            assert_int_equal(s.scene->light_slots.data[place].light, id.index);
            end = place + 1;
        }
        assert_int_equal(s.scene->light_slot_end, end);
        struct shot shot = stage_shoot(&s, &s.frame);
        assert_int_equal(shot.stats.lights_total, count);
        assert_true(s.renderer->device_scene->light_bytes_sent <= changes * LIGHT_BYTES);
        shot_free(&shot);
    }
    stage_close(&s);
}

/* With places that are free between others, all kinds of lists give the same bits, and those that a scene gives where they are not. */
static void test_free_places_are_in_no_list(void **state) {
    UNUSED(state);
    struct stage s = open_lights(LIGHTS), packed = open_lights(0);
    check_frame(&s, LIGHTS * LIGHT_BYTES);
    for (uint32_t i = 0; i < LIGHTS; i++) {
        fnl_light_params light = some_light(i);
        fnl_light_id id;
        if (i % 3 == 1)
            assert_int_equal(fnl_scene_remove_light(s.scene, ids[i]), FNL_OK);
        else
            assert_int_equal(fnl_scene_add_light(packed.scene, &light, &id), FNL_OK);
    }
    s.frame.lists = packed.frame.lists = FNL_LISTS_ALL;
    struct shot all = stage_shoot(&s, &s.frame);
    for (uint32_t lists = 0; lists < FNL_LISTS_AUTO; lists++) {
        if (!fnl_shading_supports(s.frame.shading, (fnl_light_lists)lists, 1)) continue;
        s.frame.lists = packed.frame.lists = (fnl_light_lists)lists;
        struct shot shot = stage_shoot(&s, &s.frame), other = stage_shoot(&packed, &packed.frame);
        assert_int_equal(count_differing(&shot.radiance, &all.radiance), 0);
        assert_int_equal(count_differing(&shot.radiance, &other.radiance), 0);
        assert_int_equal(shot.stats.list_entries, other.stats.list_entries);
        assert_int_equal(shot.stats.lights_in_view, other.stats.lights_in_view);
        assert_int_equal(shot.stats.lights_total, other.stats.lights_total);
        shot_free(&shot);
        shot_free(&other);
    }
    shot_free(&all);
    stage_close(&packed);
    stage_close(&s);
}

/* Renders a frame, which makes so many new programs at least, or none, and compares it with a renderer of its own. */
static void check_programs(struct stage *s, uint32_t made, uint32_t shaped) {
    struct stage fresh = *s;
    struct shot shot = stage_shoot(s, &s->frame);
    if (made) assert_in_range(shot.stats.pipelines_made, made, 1000);
    else assert_int_equal(shot.stats.pipelines_made, 0);
    assert_int_equal(s->renderer->device_scene->shaped_count, shaped);
    fresh.renderer = test_renderer(s->scene);
    struct shot other = stage_shoot(&fresh, &fresh.frame);
    assert_int_equal(count_differing(&shot.radiance, &other.radiance), 0);
    fnl_renderer_destroy(&fresh.renderer);
    shot_free(&shot);
    shot_free(&other);
}

/* Shaders have no code for capsules, wedges, boxes and hulls until there are such lights, and none again when they are gone. First of all tests. */
static void test_simple_lights_have_simple_shaders(void **state) {
    UNUSED(state);
    struct stage s = open_lights(12);
    fnl_light_params light = some_light(5);
    for (uint32_t i = 0; i < 12; i++) {
        light = some_light(i);
        light.kind = i % 2 ? FNL_LIGHT_SPOT : FNL_LIGHT_POINT;
        light.outer_cone_angle = 0.5f;
        assert_int_equal(fnl_scene_set_light(s.scene, ids[i], &light), FNL_OK);
    }
    s.frame.shading = FNL_SHADING_DEFERRED;
    check_programs(&s, 1, 0);
    light.position.y += 0.4f;
    assert_int_equal(fnl_scene_set_light(s.scene, ids[3], &light), FNL_OK);
    check_programs(&s, 0, 0);
    const fnl_light_params spot = light;
    light.kind = FNL_LIGHT_CAPSULE;
    light.length = 1;
    assert_int_equal(fnl_scene_set_light(s.scene, ids[3], &light), FNL_OK);
    check_programs(&s, 1, 1);
    const fnl_vec3 corners[] = {{-9, -9, -9}, {9, -9, -9}, {0, 9, -9}, {0, 0, 9}};
    assert_int_equal(fnl_scene_set_light_hull(s.scene, ids[4], corners, 4), FNL_OK);
    check_programs(&s, 0, 2);
    assert_int_equal(fnl_scene_set_light(s.scene, ids[3], &spot), FNL_OK);
    check_programs(&s, 0, 1);
    assert_int_equal(fnl_scene_remove_light(s.scene, ids[4]), FNL_OK);
    check_programs(&s, 0, 0);
    assert_int_equal(fnl_scene_set_light(s.scene, ids[3], &light), FNL_OK);
    check_programs(&s, 0, 1);
    assert_int_equal(fnl_scene_remove_light(s.scene, ids[3]), FNL_OK);
    check_programs(&s, 0, 0);
    /* The builder of fine lists too: its count, its fill, and what shades. */
    s.frame.lists = FNL_LISTS_FINE;
    check_programs(&s, 3, 0);
    assert_int_equal(fnl_scene_set_light(s.scene, ids[7], &light), FNL_OK);
    check_programs(&s, 3, 1);
    /* And what has no lists: volumes, and those that other passes read. */
    static const struct {
        fnl_shading shading;
        uint32_t programs; /* that light, or ask whether a light reaches a point */
    } paths[] = {{FNL_SHADING_DEFERRED_VOLUMES, 1}, {FNL_SHADING_PRE_LIGHTING, 1}, {FNL_SHADING_LIGHT_INDEXED, 2},
                 {FNL_SHADING_ZIOMA, 2},            {FNL_SHADING_MOBILE, 1}};
    s.frame.mobile.lights = FNL_MOBILE_LIGHTS_VOLUMES;
    for (size_t i = 0; i < COUNT_OF(paths); i++) {
        s.frame.shading = paths[i].shading;
        assert_int_equal(fnl_scene_set_light(s.scene, ids[7], &spot), FNL_OK);
        check_programs(&s, paths[i].programs, 0);
        assert_int_equal(fnl_scene_set_light(s.scene, ids[7], &light), FNL_OK);
        check_programs(&s, paths[i].programs, 1);
    }
    stage_close(&s);
}

/* The planes of a hull are seen from the light: they are sent with it. */
static void test_hulls_move_with_their_lights(void **state) {
    UNUSED(state);
    enum { FEW = 30 };
    struct stage s = open_lights(FEW);
    for (uint32_t i = 0; i < FEW; i += 3) {
        vec3 at = some_light(i).position;
        fnl_vec3 corners[8];
        for (uint32_t k = 0; k < 8; k++)
            corners[k] = vec3_make(at.x + (k & 1 ? 1.f : -0.5f), at.y + (k & 2 ? 1.f : -1.f), at.z + (k & 4 ? 0.4f : -0.4f));
        assert_int_equal(fnl_scene_set_light_hull(s.scene, ids[i], corners, 8), FNL_OK);
    }
    check_frame(&s, FEW * LIGHT_BYTES + 10 * 6 * sizeof(vec4));
    struct shot before = stage_shoot(&s, &s.frame);
    for (uint32_t i = 0; i < FEW; i += 3) {
        fnl_light_params light = some_light(i);
        light.position.x += 0.7f;
        light.range = 4;
        assert_int_equal(fnl_scene_set_light(s.scene, ids[i], &light), FNL_OK);
    }
    move(&s, 10, 0.1f);
    check_frame(&s, 11 * LIGHT_BYTES + 10 * 6 * sizeof(vec4));
    struct shot after = stage_shoot(&s, &s.frame);
    assert_true(count_differing(&before.radiance, &after.radiance) > 100);
    shot_free(&before);
    shot_free(&after);
    assert_int_equal(fnl_scene_set_light_hull(s.scene, ids[6], NULL, 0), FNL_OK);
    check_frame(&s, LIGHT_BYTES);
    assert_int_equal(fnl_scene_remove_light(s.scene, ids[12]), FNL_OK);
    fnl_vec3 corners[6];
    for (uint32_t k = 0; k < 6; k++) { /* of 8 planes: with its own 6 there are three gaps, none wide enough */
        corners[k] = some_light(18).position;
        *(k / 2 == 0 ? &corners[k].x : k / 2 == 1 ? &corners[k].y : &corners[k].z) += k & 1 ? 1.f : -1.f;
    }
    assert_int_equal(fnl_scene_set_light_hull(s.scene, ids[18], corners, 6), FNL_OK);
    check_frame(&s, FEW * LIGHT_BYTES + (7 * 6 + 8) * sizeof(vec4)); /* all planes move together */
    move(&s, 15, 0.1f);
    check_frame(&s, LIGHT_BYTES + 6 * sizeof(vec4));
    stage_close(&s);
}

/* A renderer that slept through more changes than the scene lists; and one that saw some of them. */
static void test_renderers_that_missed_steps(void **state) {
    UNUSED(state);
    enum { MANY = 4 * LIGHTS };
    struct stage s = open_lights(MANY), late = s;
    late.renderer = test_renderer(s.scene);
    s.frame.lists = late.frame.lists = FNL_LISTS_CLUSTERED;
    check_frame(&s, MANY * LIGHT_BYTES);
    check_frame(&late, MANY * LIGHT_BYTES);
    for (uint32_t round = 0; round < 3; round++) {
        for (uint32_t k = 0; k < 700; k++) move(&s, (k * 2 + round) % MANY, 0.2f);
        check_frame(&s, 700 * LIGHT_BYTES);
    }
    for (uint32_t k = 0; k < 500; k++) move(&s, k, 0.3f); /* the list has begun anew: these are in it once */
    check_frame(&s, 500 * LIGHT_BYTES);
    check_frame(&late, MANY * LIGHT_BYTES); /* nearly all */
    move(&s, 8, 0.6f);
    check_frame(&late, LIGHT_BYTES);
    check_frame(&s, LIGHT_BYTES);
    fnl_renderer_destroy(&late.renderer);
    stage_close(&s);
}

/* Lights on nodes that move, and lists that the CPU makes from a copy whose far lights are faded out. */
static void test_nodes_and_faded_lights(void **state) {
    UNUSED(state);
    enum { NODES = 60 };
    struct stage s = open_lights(0);
    mat4 identity = mat4_scaling(vec3_make(1, 1, 1));
    uint32_t nodes[NODES];
    for (uint32_t i = 0; i < NODES; i++) {
        fnl_light_params light = some_light(i);
        nodes[i] = scene_add_node(s.scene, "lamp", SCENE_NONE, &identity, SCENE_NONE);
        place_from_vec3(light.position, s.scene->origin, s.scene->nodes.data[nodes[i]].translation);
        s.scene->nodes.data[nodes[i]].has_matrix = false;
        scene_pose_node(&s.scene->nodes.data[nodes[i]]);
        assert_int_not_equal(scene_add_light(s.scene, &light, nodes[i]), SCENE_NONE);
    }
    scene_update_transforms(s.scene);
    s.frame.lists = FNL_LISTS_CLUSTERED_CPU;
    for (uint32_t lod = 0; lod < 2; lod++) {
        s.frame.light_lod = lod ? 1000 : 0;
        check_frame(&s, lod ? 0 : NODES * LIGHT_BYTES);
        for (uint32_t i = 0; i < 5; i++) {
            struct scene_node *node = &s.scene->nodes.data[nodes[i * 3]];
            node->translation[1] += 0.3;
            scene_pose_node(node);
        }
        scene_update_transforms(s.scene);
        check_frame(&s, 5 * LIGHT_BYTES);
    }
    for (uint32_t i = 0; i < 9; i++) { /* of lights that were faded out */
        fnl_light_params light = s.scene->lights.data[i].params;
        light.range *= 3;
        assert_int_equal(fnl_scene_set_light(s.scene, (fnl_light_id){i, s.scene->lights.data[i].generation}, &light),
                         FNL_OK);
    }
    check_frame(&s, 9 * LIGHT_BYTES);
    s.frame.light_lod = 0;
    check_frame(&s, 0);
    device_scene_forget(s.renderer->device_scene);
    check_frame(&s, NODES * LIGHT_BYTES);
    stage_close(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_simple_lights_have_simple_shaders, harness_check),
        cmocka_unit_test_teardown(test_few_lights_move, harness_check),
        cmocka_unit_test_teardown(test_lights_come_and_go, harness_check),
        cmocka_unit_test_teardown(test_places_last, harness_check),
        cmocka_unit_test_teardown(test_free_places_are_in_no_list, harness_check),
        cmocka_unit_test_teardown(test_hulls_move_with_their_lights, harness_check),
        cmocka_unit_test_teardown(test_renderers_that_missed_steps, harness_check),
        cmocka_unit_test_teardown(test_nodes_and_faded_lights, harness_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
