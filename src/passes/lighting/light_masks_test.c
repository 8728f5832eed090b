/* SPDX-License-Identifier: MIT */
/* Light masks: each instance looks as if the lights that do not affect it were off, whatever the path, the list and the shadows. */
#include "tests/render_harness.h"

#include <math.h>

enum { WIDTH = 97, HEIGHT = 61 };
static const uint32_t instance_masks[] = {255, 1, 2}, light_masks[] = {255, 1, 2, 3, 0};
enum { CLASSES = COUNT_OF(instance_masks) };

static uint32_t instance_mask(uint32_t i) { return instance_masks[i % CLASSES]; }
static uint32_t light_mask(uint32_t i) { return light_masks[i % COUNT_OF(light_masks)]; }

static void set_instances(fnl_scene *scene, bool masked) {
    for (uint32_t i = 0; i < fnl_scene_count(scene, FNL_ENTITY_INSTANCE); i++) {
        fnl_entity_info info;
        assert_int_equal(fnl_scene_query_entity(scene, FNL_ENTITY_INSTANCE, i, &info), FNL_OK);
        assert_int_equal(fnl_scene_set_instance_light_mask(scene, info.id.instance, masked ? instance_mask(i) : 255), FNL_OK);
    }
}

/* `masked`: with their masks; else with those off that do not affect `class`. */
static void set_lights(fnl_scene *scene, const fnl_light_params *lights, uint32_t count, bool masked, uint32_t class) {
    for (uint32_t i = 0; i < count; i++) {
        fnl_light_params light = lights[i];
        fnl_entity_info info;
        if (masked) light.mask = light_mask(i);
        else if (!(light_mask(i) & instance_masks[class])) light.intensity = 0;
        assert_int_equal(fnl_scene_query_entity(scene, FNL_ENTITY_LIGHT, i, &info), FNL_OK);
        assert_int_equal(fnl_scene_set_light(scene, info.id.light, &light), FNL_OK);
    }
}

/* Every fifth light is directional or another shape. */
static void vary_lights(fnl_scene *scene) {
    for (uint32_t i = 0; i < fnl_scene_count(scene, FNL_ENTITY_LIGHT); i += 5) {
        fnl_light_params light;
        fnl_entity_info info;
        assert_int_equal(fnl_scene_query_light(scene, i, &light), FNL_OK);
        assert_int_equal(fnl_scene_query_entity(scene, FNL_ENTITY_LIGHT, i, &info), FNL_OK);
        light.kind = i % 10 ? FNL_LIGHT_DIRECTIONAL : FNL_LIGHT_CAPSULE;
        light.direction = (fnl_vec3){0.3f, -1, -0.2f};
        if (i % 10) light.intensity = 2;
        assert_int_equal(fnl_scene_set_light(scene, info.id.light, &light), FNL_OK);
    }
}

struct world {
    struct stage stage;
    fnl_light_params *lights;
    uint32_t light_count;
    uint8_t *classes; /* of each pixel; CLASSES: sky */
};

static struct world open_world(const char *source) {
    struct world w = {.stage = stage_open(source, 0)};
    fnl_scene *scene = w.stage.scene;
    vary_lights(scene);
    w.light_count = fnl_scene_count(scene, FNL_ENTITY_LIGHT);
    w.lights = test_malloc(w.light_count * sizeof *w.lights);
    for (uint32_t i = 0; i < w.light_count; i++) assert_int_equal(fnl_scene_query_light(scene, i, &w.lights[i]), FNL_OK);
    w.stage.frame.width = WIDTH;
    w.stage.frame.height = HEIGHT;
    fnl_frame frame = w.stage.frame;
    frame.outputs = FNL_OUTPUT_OBJECT;
    fnl_image objects = {0};
    assert_int_equal(fnl_renderer_render(w.stage.renderer, &frame), FNL_OK);
    assert_int_equal(fnl_renderer_read(w.stage.renderer, FNL_OUTPUT_OBJECT, &objects), FNL_OK);
    w.classes = test_malloc(WIDTH * HEIGHT);
    uint32_t seen[CLASSES + 1] = {0};
    for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) {
        const float object = ((const float *)objects.pixels)[4 * i];
        w.classes[i] = object > 0 ? (uint8_t)(((uint32_t)object - 1) % CLASSES) : CLASSES;
        seen[w.classes[i]]++;
    }
    for (uint32_t i = 0; i < CLASSES; i++) assert_true(seen[i] > 100);
    fnl_image_free(gpu_host(harness_device()), &objects);
    return w;
}

static void close_world(struct world *w) {
    test_free(w->lights);
    test_free(w->classes);
    stage_close(&w->stage);
}

static struct shot shoot_masked(struct world *w, const fnl_frame *frame) {
    set_instances(w->stage.scene, true);
    set_lights(w->stage.scene, w->lights, w->light_count, true, 0);
    return stage_shoot(&w->stage, frame);
}

/* What the masked picture should be, put together from one picture for each class. */
static struct shot shoot_expected(struct world *w, const fnl_frame *frame) {
    struct shot expected = {0};
    set_instances(w->stage.scene, false);
    for (uint32_t c = 0; c < CLASSES; c++) {
        set_lights(w->stage.scene, w->lights, w->light_count, false, c);
        struct shot own = stage_shoot(&w->stage, frame);
        if (c == 0) {
            expected = own;
            continue;
        }
        float *to = expected.radiance.pixels;
        for (uint32_t i = 0; i < WIDTH * HEIGHT; i++)
            if (w->classes[i] == c) memcpy(to + 4 * i, (const float *)own.radiance.pixels + 4 * i, 4 * sizeof *to);
        shot_free(&own);
    }
    return expected;
}

/* Pixels that differ by more than `part` of their value. */
static uint32_t count_off(const fnl_image *a, const fnl_image *b, float part) {
    const float *x = a->pixels, *y = b->pixels;
    uint32_t off = 0;
    for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) {
        bool is_off = false;
        for (uint32_t k = 0; k < 3; k++) is_off = is_off || !(fabsf(x[4 * i + k] - y[4 * i + k]) <= part * (fabsf(y[4 * i + k]) + 0.01f));
        off += is_off;
    }
    return off;
}

static void expect_masked(struct world *w, const fnl_frame *frame, float part, uint32_t allowed) {
    struct shot expected = shoot_expected(w, frame), masked = shoot_masked(w, frame);
    const uint32_t off = count_off(&masked.radiance, &expected.radiance, part);
    if (off > allowed)
        fail_msg("%s, %s lists, shadows %s: %u pixels are not as if lights were off", fnl_value_name(FNL_ENUM_SHADING, frame->shading),
                 fnl_value_name(FNL_ENUM_LISTS, frame->lists), fnl_value_name(FNL_ENUM_SHADOWS, frame->shadows), off);
    shot_free(&expected);
    shot_free(&masked);
}

/* Paths that shade every surface by the same code: equal to the bit. */
static void test_instances_lack_the_lights_of_other_masks(void **state) {
    UNUSED(state);
    struct world w = open_world("builtin:spheres?lights=40");
    static const fnl_shading exact[] = {FNL_SHADING_FORWARD, FNL_SHADING_FORWARD_PREPASS, FNL_SHADING_VISIBILITY, FNL_SHADING_DAIS, FNL_SHADING_LIGHT_INDEXED};
    static const fnl_light_lists lists[] = {FNL_LISTS_ALL, FNL_LISTS_TILED, FNL_LISTS_CLUSTERED, FNL_LISTS_MESH, FNL_LISTS_BATCHES, FNL_LISTS_MULTIPASS, FNL_LISTS_FINE};
    for (uint32_t s = 0; s < COUNT_OF(exact); s++)
        for (uint32_t l = 0; l < COUNT_OF(lists); l++) {
            fnl_frame frame = w.stage.frame;
            frame.shading = exact[s];
            frame.lists = lists[l];
            if (!fnl_shading_supports(frame.shading, frame.lists, 1) || (l && s > 2)) continue;
            expect_masked(&w, &frame, 0, 0);
        }
    close_world(&w);
}

/* Paths that store surfaces, or light without knowing the item, draw masked instances forward: within what they round. */
static void test_every_path_heeds_masks(void **state) {
    UNUSED(state);
    struct world w = open_world("builtin:spheres?lights=40");
    for (fnl_shading shading = 0; shading < FNL_SHADING_AUTO; shading++) {
        fnl_frame frame = w.stage.frame;
        frame.shading = shading;
        frame.lists = FNL_LISTS_CLUSTERED;
        if (!fnl_shading_supports(shading, frame.lists, 1)) continue;
        const bool coarse = shading == FNL_SHADING_COARSE || shading == FNL_SHADING_LOW_RES || shading == FNL_SHADING_INFERRED || shading == FNL_SHADING_MOBILE ||
                            shading == FNL_SHADING_VIRTUAL_TEXTURING || shading == FNL_SHADING_TEXTURING;
        expect_masked(&w, &frame, coarse ? 0.25f : 0.05f, WIDTH * HEIGHT / (coarse ? 20 : 50));
    }
    close_world(&w);
}

/* Lights without effect on an instance still lie in its shadow. */
static void test_masked_instances_cast_shadows(void **state) {
    UNUSED(state);
    struct world w = open_world("builtin:spheres?lights=20");
    static const fnl_shadows shadows[] = {FNL_SHADOWS_RAYS, FNL_SHADOWS_MAPS};
    for (uint32_t i = 0; i < COUNT_OF(shadows); i++) {
        fnl_frame frame = w.stage.frame;
        frame.shading = FNL_SHADING_FORWARD_PREPASS;
        frame.lists = FNL_LISTS_CLUSTERED;
        frame.shadows = shadows[i];
        frame.shadow.ray_backend = FNL_RAY_BACKEND_BVH;
        expect_masked(&w, &frame, i ? 0.02f : 0, i ? WIDTH * HEIGHT / 50 : 0); /* another set of lights may get coarser maps */
    }
    close_world(&w);
}

/* Several samples per pixel, blended and transmissive surfaces: paths agree about them. */
static void test_paths_agree_on_glass(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:glass?lights=30", 0);
    set_instances(stage.scene, true);
    for (uint32_t i = 0; i < fnl_scene_count(stage.scene, FNL_ENTITY_LIGHT); i++) {
        fnl_light_params light;
        fnl_entity_info info;
        assert_int_equal(fnl_scene_query_light(stage.scene, i, &light), FNL_OK);
        assert_int_equal(fnl_scene_query_entity(stage.scene, FNL_ENTITY_LIGHT, i, &info), FNL_OK);
        light.mask = light_mask(i);
        assert_int_equal(fnl_scene_set_light(stage.scene, info.id.light, &light), FNL_OK);
    }
    stage.frame.width = WIDTH;
    stage.frame.height = HEIGHT;
    stage.frame.lists = FNL_LISTS_CLUSTERED;
    for (uint32_t msaa = 1; msaa <= 4; msaa += 3) {
        stage.frame.msaa = msaa;
        stage.frame.shading = FNL_SHADING_FORWARD;
        struct shot forward = stage_shoot(&stage, &stage.frame);
        static const fnl_shading others[] = {FNL_SHADING_FORWARD_PREPASS, FNL_SHADING_DEFERRED, FNL_SHADING_VISIBILITY};
        for (uint32_t i = 0; i < COUNT_OF(others); i++) {
            stage.frame.shading = others[i];
            struct shot other = stage_shoot(&stage, &stage.frame);
            const uint32_t off = count_off(&other.radiance, &forward.radiance, 0.1f);
            if (off > WIDTH * HEIGHT / 25) fail_msg("%s with %u samples: %u pixels differ", fnl_value_name(FNL_ENUM_SHADING, others[i]), msaa, off);
            shot_free(&other);
        }
        shot_free(&forward);
    }
    stage_close(&stage);
}

/* Masks that nothing uses cost nothing, and those that are taken back again neither. */
static void test_unused_masks_cost_nothing(void **state) {
    UNUSED(state);
    struct world w = open_world("builtin:spheres?lights=20");
    fnl_frame frame = w.stage.frame;
    frame.shading = FNL_SHADING_DEFERRED;
    frame.lists = FNL_LISTS_CLUSTERED;
    struct shot before = stage_shoot(&w.stage, &frame);
    shot_free(&before);
    before = stage_shoot(&w.stage, &frame); /* now everything is on the device */
    assert_int_equal(w.stage.renderer->device_scene->masks.size, 0);
    set_instances(w.stage.scene, true); /* every light affects all of them */
    struct shot instances = stage_shoot(&w.stage, &frame);
    assert_int_equal(count_differing(&before.radiance, &instances.radiance), 0);
    assert_int_equal(instances.stats.image_bytes_written, before.stats.image_bytes_written);
    assert_int_equal(w.stage.renderer->device_scene->masks.size, 0);
    set_lights(w.stage.scene, w.lights, w.light_count, true, 0);
    struct shot masked = stage_shoot(&w.stage, &frame);
    assert_true(count_differing(&before.radiance, &masked.radiance) > 500);
    shot_free(&masked);
    masked = stage_shoot(&w.stage, &frame);
    assert_true(masked.stats.image_bytes_written > before.stats.image_bytes_written); /* what is to be shaded forward is marked */
    set_instances(w.stage.scene, false);
    for (uint32_t i = 0; i < w.light_count; i++) w.lights[i].mask = 255;
    for (uint32_t i = 0; i < w.light_count; i++) {
        fnl_entity_info info;
        assert_int_equal(fnl_scene_query_entity(w.stage.scene, FNL_ENTITY_LIGHT, i, &info), FNL_OK);
        assert_int_equal(fnl_scene_set_light(w.stage.scene, info.id.light, &w.lights[i]), FNL_OK);
    }
    struct shot after = stage_shoot(&w.stage, &frame);
    assert_int_equal(count_differing(&before.radiance, &after.radiance), 0);
    assert_int_equal(after.stats.image_bytes_written, before.stats.image_bytes_written);
    shot_free(&before);
    shot_free(&instances);
    shot_free(&masked);
    shot_free(&after);
    close_world(&w);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_instances_lack_the_lights_of_other_masks, harness_check),
        cmocka_unit_test_teardown(test_every_path_heeds_masks, harness_check),
        cmocka_unit_test_teardown(test_masked_instances_cast_shadows, harness_check),
        cmocka_unit_test_teardown(test_paths_agree_on_glass, harness_check),
        cmocka_unit_test_teardown(test_unused_masks_cost_nothing, harness_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
