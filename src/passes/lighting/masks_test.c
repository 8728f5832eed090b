/* SPDX-License-Identifier: MIT */
/* Masks of lights and views: compared with pictures in which the excluded lights are off, or the excluded instances are hidden. */
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

static bool is_coarse(fnl_shading shading) {
    return shading == FNL_SHADING_COARSE || shading == FNL_SHADING_LOW_RES || shading == FNL_SHADING_INFERRED || shading == FNL_SHADING_MOBILE ||
           shading == FNL_SHADING_VIRTUAL_TEXTURING || shading == FNL_SHADING_TEXTURING;
}

static float tolerance_of(fnl_shading shading) { return is_coarse(shading) ? 0.25f : 0.05f; }
static uint32_t allowed_of(fnl_shading shading) { return WIDTH * HEIGHT / (is_coarse(shading) ? 20 : 50); }

/* Paths that store surfaces, or shade without access to the item, draw masked instances forward: equal within rounding. */
static void test_every_path_heeds_masks(void **state) {
    UNUSED(state);
    struct world w = open_world("builtin:spheres?lights=40");
    for (fnl_shading shading = 0; shading < FNL_SHADING_AUTO; shading++) {
        fnl_frame frame = w.stage.frame;
        frame.shading = shading;
        frame.lists = FNL_LISTS_CLUSTERED;
        if (!fnl_shading_supports(shading, frame.lists, 1)) continue;
        expect_masked(&w, &frame, tolerance_of(shading), allowed_of(shading));
    }
    close_world(&w);
}

/* A mask of 0, of an instance or of all lights, is as if the lights were off: along every path, whatever other masks are. */
static void test_masks_of_zero_meet_none(void **state) {
    UNUSED(state);
    for (fnl_shading shading = 0; shading < FNL_SHADING_AUTO; shading++) {
        if (!fnl_shading_supports(shading, FNL_LISTS_CLUSTERED, 1)) continue;
        struct stage stage = stage_open("builtin:spheres?lights=20", 0); /* without masks so far */
        stage.frame.width = WIDTH;
        stage.frame.height = HEIGHT;
        fnl_frame frame = stage.frame;
        frame.shading = shading;
        const uint32_t instances = fnl_scene_count(stage.scene, FNL_ENTITY_INSTANCE), lights = fnl_scene_count(stage.scene, FNL_ENTITY_LIGHT);
        struct shot lit = stage_shoot(&stage, &frame), none[2], off[2];
        for (uint32_t way = 0; way < 2; way++) {
            for (uint32_t i = 0; i < instances; i++) {
                fnl_entity_info info;
                assert_int_equal(fnl_scene_query_entity(stage.scene, FNL_ENTITY_INSTANCE, i, &info), FNL_OK);
                assert_int_equal(fnl_scene_set_instance_light_mask(stage.scene, info.id.instance, way ? 255 : 0), FNL_OK);
            }
            for (uint32_t i = 0; i < lights && way; i++) {
                fnl_light_params light;
                fnl_entity_info info;
                assert_int_equal(fnl_scene_query_light(stage.scene, i, &light), FNL_OK);
                assert_int_equal(fnl_scene_query_entity(stage.scene, FNL_ENTITY_LIGHT, i, &info), FNL_OK);
                light.mask = 0;
                assert_int_equal(fnl_scene_set_light(stage.scene, info.id.light, &light), FNL_OK);
            }
            none[way] = stage_shoot(&stage, &frame);
        }
        for (uint32_t i = lights; i-- > 0;) {
            fnl_entity_info info;
            assert_int_equal(fnl_scene_query_entity(stage.scene, FNL_ENTITY_LIGHT, i, &info), FNL_OK);
            assert_int_equal(fnl_scene_remove_light(stage.scene, info.id.light), FNL_OK);
        }
        off[1] = stage_shoot(&stage, &frame);
        frame.shading = FNL_SHADING_FORWARD_PREPASS; /* as many paths draw instances with masks */
        off[0] = stage_shoot(&stage, &frame);
        const uint32_t by_instances = MIN(count_off(&none[0].radiance, &off[0].radiance, 0.05f), count_off(&none[0].radiance, &off[1].radiance, 0.05f)),
                       by_lights = count_off(&none[1].radiance, &off[1].radiance, 0.01f);
        if (by_instances > WIDTH * HEIGHT / 50 || by_lights > 0)
            fail_msg("%s: %u pixels are lit with instances of mask 0, %u with lights of mask 0", fnl_value_name(FNL_ENUM_SHADING, shading), by_instances, by_lights);
        assert_true(count_off(&lit.radiance, &off[1].radiance, 1) > 1000);
        shot_free(&lit), shot_free(&off[0]), shot_free(&off[1]), shot_free(&none[0]), shot_free(&none[1]);
        stage_close(&stage);
    }
}

/* Instances cast shadows even of lights that do not affect them. */
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

/* Unused masks cost nothing, and neither do masks that are reset to 255. */
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

/* ---- masks of views ---- */

/* `masked`: by view masks; else those are hidden that a camera with the mask 1 does not show. */
static void part_instances(fnl_scene *scene, bool masked) {
    for (uint32_t i = 0; i < fnl_scene_count(scene, FNL_ENTITY_INSTANCE); i++) {
        fnl_entity_info info;
        assert_int_equal(fnl_scene_query_entity(scene, FNL_ENTITY_INSTANCE, i, &info), FNL_OK);
        assert_int_equal(fnl_scene_set_instance_view_mask(scene, info.id.instance, masked ? instance_mask(i) : 255), FNL_OK);
        assert_int_equal(fnl_scene_set_instance_visible(scene, info.id.instance, masked || instance_mask(i) & 1), FNL_OK);
    }
}

static void test_cameras_show_what_their_mask_meets(void **state) {
    UNUSED(state);
    static const char *const sources[] = {"builtin:spheres?lights=20", "builtin:glass?lights=20"};
    for (uint32_t k = 0; k < COUNT_OF(sources); k++) {
        struct stage stage = stage_open(sources[k], 0);
        stage.frame.lists = FNL_LISTS_CLUSTERED;
        stage.frame.width = WIDTH;
        stage.frame.height = HEIGHT;
        for (fnl_shading shading = 0; shading < FNL_SHADING_AUTO; shading++) {
            fnl_frame frame = stage.frame;
            frame.shading = shading;
            if (!fnl_shading_supports(shading, frame.lists, 1)) continue;
            part_instances(stage.scene, false);
            struct shot hidden = stage_shoot(&stage, &frame);
            part_instances(stage.scene, true);
            struct shot all = stage_shoot(&stage, &frame);
            frame.camera.view_mask = 1;
            struct shot masked = stage_shoot(&stage, &frame);
            assert_true(count_differing(&all.radiance, &masked.radiance) > 300);
            const bool rough = shading == FNL_SHADING_INFERRED;
            const uint32_t off = count_off(&hidden.radiance, &masked.radiance, rough ? 0.3f : 0);
            if (off > (rough ? WIDTH * HEIGHT / 20 : 0)) fail_msg("%s, %s: %u pixels are not as if they were hidden", sources[k], fnl_value_name(FNL_ENUM_SHADING, shading), off); /* inferred: where blended surfaces are lit depends on their numbers */
            shot_free(&hidden), shot_free(&all), shot_free(&masked);
        }
        stage_close(&stage);
    }
}

/* Where the same surface shows, its light and shadow are the same. */
static void test_instances_out_of_view_cast_shadows(void **state) {
    UNUSED(state);
    static const fnl_shadows methods[] = {FNL_SHADOWS_RAYS, FNL_SHADOWS_MAPS};
    struct stage stage = stage_open("builtin:spheres?lights=20", 0);
    stage.frame.outputs |= FNL_OUTPUT_POSITION;
    stage.frame.shading = FNL_SHADING_FORWARD_PREPASS;
    stage.frame.lists = FNL_LISTS_CLUSTERED;
    stage.frame.shadow.ray_backend = FNL_RAY_BACKEND_BVH;
    part_instances(stage.scene, true);
    for (uint32_t m = 0; m < COUNT_OF(methods); m++) {
        fnl_frame frame = stage.frame;
        frame.shadows = methods[m];
        struct shot all = stage_shoot(&stage, &frame);
        frame.camera.view_mask = 1;
        struct shot masked = stage_shoot(&stage, &frame);
        uint32_t same = 0, off = 0;
        const uint32_t pixels = frame.width * frame.height;
        for (uint32_t i = 0; i < pixels; i++) {
            if (memcmp((const float *)all.position.pixels + 4 * i, (const float *)masked.position.pixels + 4 * i, 3 * sizeof(float)) != 0) continue;
            same++;
            off += memcmp((const float *)all.radiance.pixels + 4 * i, (const float *)masked.radiance.pixels + 4 * i, 3 * sizeof(float)) != 0;
        }
        assert_true(same > pixels / 3 && same < pixels);
        if (off > (m ? pixels / 50 : 0)) fail_msg("shadows %s: %u of %u pixels differ", fnl_value_name(FNL_ENUM_SHADOWS, methods[m]), off, same); /* maps: other pages */
        shot_free(&all), shot_free(&masked);
    }
    stage_close(&stage);
}

/* A settled view whose mask changes shows surfaces for which no shadow map was drawn yet. */
static void test_shadows_follow_the_mask_of_a_still_view(void **state) {
    UNUSED(state);
    enum { FRAMES = 6 };
    struct shot shots[2];
    for (uint32_t way = 0; way < 2; way++) { /* with the mask at the end, and from the start */
        struct stage stage = stage_open("builtin:spheres?lights=20", 0);
        stage.frame.shading = FNL_SHADING_FORWARD_PREPASS;
        stage.frame.shadows = FNL_SHADOWS_MAPS;
        part_instances(stage.scene, true);
        fnl_frame frame = stage.frame;
        for (uint32_t i = 0; i < 2 * FRAMES; i++) {
            frame.camera.view_mask = way || i >= FRAMES ? 1 : 4; /* 4: no instance */
            assert_int_equal(fnl_renderer_render(stage.renderer, &frame), FNL_OK);
        }
        shots[way] = stage_shoot(&stage, &frame);
        stage_close(&stage);
    }
    assert_int_equal(count_differing(&shots[0].radiance, &shots[1].radiance), 0);
    shot_free(&shots[0]), shot_free(&shots[1]);
}

/* Views of one frame, drawn at once or as eyes, show what each would alone. */
static void test_views_have_masks_of_their_own(void **state) {
    UNUSED(state);
    enum { VIEWS = 4 };
    static const uint32_t masks[VIEWS] = {255, 1, 2, 2};
    struct stage stage = stage_open("builtin:spheres?lights=20", 0);
    part_instances(stage.scene, true);
    fnl_camera views[VIEWS];
    for (uint32_t i = 0; i < VIEWS; i++) {
        views[i] = stage.frame.camera;
        views[i].position.x += 0.02f * (float)i;
        views[i].target.x += 0.02f * (float)i;
        views[i].view_mask = masks[i];
    }
    static const fnl_shading shadings[] = {FNL_SHADING_FORWARD_PREPASS, FNL_SHADING_DEFERRED, FNL_SHADING_VISIBILITY};
    for (uint32_t s = 0; s < COUNT_OF(shadings); s++)
        for (uint32_t eyes = 0; eyes <= 2; eyes += 2) {
            fnl_frame frame = stage.frame;
            frame.shading = shadings[s];
            frame.lists = FNL_LISTS_CLUSTERED;
            frame.views = views;
            frame.view_count = VIEWS;
            frame.multiview = eyes ? FNL_MULTIVIEW_AUTO : FNL_MULTIVIEW_ON;
            frame.stereo.eyes = eyes;
            assert_int_equal(fnl_renderer_render(stage.renderer, &frame), FNL_OK);
            fnl_image together = {0}; /* one view below the other */
            assert_int_equal(fnl_renderer_read(stage.renderer, FNL_OUTPUT_RADIANCE, &together), FNL_OK);
            const size_t bytes = (size_t)frame.width * frame.height * 4 * sizeof(float);
            for (uint32_t i = 0; i < VIEWS; i++) {
                fnl_frame alone = stage.frame;
                alone.shading = frame.shading;
                alone.lists = frame.lists;
                alone.camera = views[i];
                struct shot one = stage_shoot(&stage, &alone);
                if (memcmp(one.radiance.pixels, (const char *)together.pixels + i * bytes, bytes) != 0)
                    fail_msg("%s, %u eyes, view %u: not as it is alone", fnl_value_name(FNL_ENUM_SHADING, frame.shading), eyes, i);
                shot_free(&one);
            }
            fnl_image_free(gpu_host(harness_device()), &together);
        }
    stage_close(&stage);
}

static void test_traced_cameras_have_masks(void **state) {
    UNUSED(state);
    static const char *const sources[] = {"builtin:spheres?lights=10", "builtin:glass?lights=10"};
    for (uint32_t k = 0; k < COUNT_OF(sources); k++) {
        struct stage stage = stage_open(sources[k], 0);
        fnl_trace_params params = trace_plain();
        fnl_trace traces[3];
        params.width = 60, params.height = 40;
        params.camera = stage.frame.camera;
        params.shadows = false;
        for (uint32_t i = 0; i < 3; i++) { /* all, masked, hidden */
            params.camera.view_mask = i == 1 ? 1 : 255;
            part_instances(stage.scene, i < 2);
            assert_int_equal(fnl_scene_trace(stage.scene, &params, &traces[i]), FNL_OK);
        }
        assert_true(count_differing(&traces[0].radiance, &traces[1].radiance) > 100);
        assert_int_equal(count_differing(&traces[1].radiance, &traces[2].radiance), 0);
        for (uint32_t i = 0; i < 3; i++) fnl_trace_free(gpu_host(harness_device()), &traces[i]);
        stage_close(&stage);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_instances_lack_the_lights_of_other_masks, harness_check),
        cmocka_unit_test_teardown(test_every_path_heeds_masks, harness_check),
        cmocka_unit_test_teardown(test_masks_of_zero_meet_none, harness_check),
        cmocka_unit_test_teardown(test_masked_instances_cast_shadows, harness_check),
        cmocka_unit_test_teardown(test_paths_agree_on_glass, harness_check),
        cmocka_unit_test_teardown(test_unused_masks_cost_nothing, harness_check),
        cmocka_unit_test_teardown(test_cameras_show_what_their_mask_meets, harness_check),
        cmocka_unit_test_teardown(test_instances_out_of_view_cast_shadows, harness_check),
        cmocka_unit_test_teardown(test_shadows_follow_the_mask_of_a_still_view, harness_check),
        cmocka_unit_test_teardown(test_views_have_masks_of_their_own, harness_check),
        cmocka_unit_test_teardown(test_traced_cameras_have_masks, harness_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
