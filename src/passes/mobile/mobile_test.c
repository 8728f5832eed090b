/* SPDX-License-Identifier: MIT */
/** The order mobile: merged or not the same pixels, what it stores, its layouts, glass and tone mapping inside the scope. */
#include "passes/shade/reference.h"
#include "tests/render_harness.h"

#include <math.h>

static const char *const SCENE = "builtin:glass?lights=48";

static fnl_frame mobile_frame(const struct stage *stage) {
    fnl_frame frame = stage->frame;
    frame.shading = FNL_SHADING_MOBILE;
    frame.outputs = FNL_OUTPUT_COLOR;
    return frame;
}

static void assert_same(const fnl_image *a, const fnl_image *b, const char *what) {
    uint64_t differing = count_differing(a, b);
    if (differing) fail_msg("%s: %llu pixels differ", what, (unsigned long long)differing);
}

static double mean_difference(const fnl_image *a, const fnl_image *b) {
    const uint8_t *p = a->pixels, *q = b->pixels;
    double sum = 0;
    for (size_t i = 0; i < (size_t)a->width * a->height * 4; i++) sum += abs(p[i] - q[i]);
    return sum / ((double)a->width * a->height * 3);
}

/* ---- the same picture in all modes ---- */

static void test_merged_and_separate_are_equal_MB_1(void **state) {
    UNUSED(state);
    struct stage stage = stage_open(SCENE, 0);
    fnl_frame frame = mobile_frame(&stage);
    frame.shading = FNL_SHADING_FORWARD_PREPASS;
    struct shot forward = stage_shoot(&stage, &frame);
    for (int layout = 0; layout < FNL_MOBILE_LAYOUT_COUNT; layout++)
        for (int light = 0; light < FNL_MOBILE_LIGHT_COUNT; light++) {
            frame = mobile_frame(&stage);
            frame.mobile.layout = (fnl_mobile_layout)layout;
            frame.mobile.light = (fnl_mobile_light)light;
            frame.mobile.gamma = (fnl_mobile_gamma)((layout + light) % FNL_MOBILE_GAMMA_COUNT);
            struct shot merged = stage_shoot(&stage, &frame);
            frame.mobile.separate = true;
            struct shot separate = stage_shoot(&stage, &frame);
            assert_true(merged.stats.mobile_merged && merged.stats.mobile_tonemapped && !separate.stats.mobile_merged);
            assert_same(&merged.color, &separate.color, fnl_mobile_layout_name(frame.mobile.layout));
            bool wide = layout >= FNL_MOBILE_METALLIC_256;
            double mean = mean_difference(&merged.color, &forward.color);
            print_message("%s, %s light: %.3f/255 from forward in the mean, %d at most\n",
                          fnl_mobile_layout_name(frame.mobile.layout), fnl_mobile_light_name(frame.mobile.light), mean,
                          greatest_difference(&merged.color, &forward.color));
            assert_true(mean < (wide || !light ? 1.0 : 6.0)); /* ten bits up to eight times white are few for a dark room */
            shot_free(&merged);
            shot_free(&separate);
        }
    shot_free(&forward);
    stage_close(&stage);
}

/* Sky, no lights, cutouts, odd and tiny sizes, an orthographic camera, a depth prepass. */
static void test_odd_frames_MB_1(void **state) {
    UNUSED(state);
    static const char *const sources[] = {"builtin:sky", "builtin:grass?lights=12", "builtin:spheres?lights=0"};
    for (uint32_t i = 0; i < COUNT_OF(sources); i++) {
        struct stage stage = stage_open(sources[i], 0);
        for (int variant = 0; variant < 4; variant++) {
            fnl_frame frame = mobile_frame(&stage);
            frame.width = variant == 1 ? 1 : 67;
            frame.height = variant == 1 ? 1 : 37;
            frame.mobile.layout = variant == 2 ? FNL_MOBILE_SPECULAR_256 : FNL_MOBILE_METALLIC_128;
            frame.gbuffer_prepass = variant == 3;
            if (variant == 2) {
                frame.camera.orthographic = true;
                frame.camera.vertical_extent = 8;
                frame.camera.far_distance = 60;
            }
            struct shot merged = stage_shoot(&stage, &frame);
            frame.mobile.separate = true;
            struct shot separate = stage_shoot(&stage, &frame);
            assert_same(&merged.color, &separate.color, sources[i]);
            frame.mobile.separate = false;
            frame.outputs |= FNL_OUTPUT_RADIANCE;
            struct shot radiance = stage_shoot(&stage, &frame);
            assert_int_equal(count_broken(&radiance.radiance), 0);
            shot_free(&merged);
            shot_free(&separate);
            shot_free(&radiance);
        }
        stage_close(&stage);
    }
}

/* Lights are added once, so every list leaves the same bits; and a list made with the depth of a prepass, too. */
static void test_every_list_leaves_the_same_bits_MB_1(void **state) {
    UNUSED(state);
    struct stage stage = stage_open(SCENE, 0);
    fnl_frame frame = mobile_frame(&stage);
    frame.lists = FNL_LISTS_ALL;
    frame.outputs |= FNL_OUTPUT_RADIANCE;
    struct shot all = stage_shoot(&stage, &frame);
    static const fnl_light_lists lists[] = {FNL_LISTS_TILED, FNL_LISTS_CLUSTERED, FNL_LISTS_ZBIN, FNL_LISTS_FINE,
                                            FNL_LISTS_BVH};
    for (uint32_t i = 0; i < 2 * COUNT_OF(lists); i++) {
        frame.lists = lists[i / 2];
        frame.gbuffer_prepass = i & 1;
        struct shot shot = stage_shoot(&stage, &frame);
        assert_same(&all.radiance, &shot.radiance, fnl_light_lists_name(frame.lists));
        shot_free(&shot);
    }
    shot_free(&all);
    stage_close(&stage);
}

/* ---- what is stored ---- */

static void test_only_the_picture_is_stored_MB_2_MB_3_ES_68(void **state) {
    UNUSED(state);
    struct stage stage = stage_open(SCENE, 0);
    static const uint64_t bytes[] = {16, 20, 32, 32}; /* of a pixel's targets */
    for (int layout = 0; layout < FNL_MOBILE_LAYOUT_COUNT; layout++) {
        fnl_frame frame = mobile_frame(&stage);
        frame.lists = FNL_LISTS_CLUSTERED;
        frame.mobile.layout = (fnl_mobile_layout)layout;
        const uint64_t pixels = (uint64_t)frame.width * frame.height;
        struct shot merged = stage_shoot(&stage, &frame);
        char table[8192];
        assert_true(fnl_renderer_print_traffic(stage.renderer, table, sizeof table) < sizeof table);
        uint32_t stores = 0, loads = 0, in_tiles = 0;
        for (const char *at = table; (at = strstr(at, " store ")); at++) stores++;
        for (const char *at = strchr(table, '\n'); (at = strstr(at, " load ")); at++) loads++;
        for (const char *at = table; (at = strstr(at, " in tiles")); at++) in_tiles++;
        assert_int_equal(stores, 2); /* one of them in the head of the table */
        assert_int_equal(loads, 0);
        fnl_mobile_target targets[8];
        assert_int_equal(in_tiles, fnl_mobile_layout_targets(frame.mobile.layout, targets, 8) + 1); /* and depth */
        assert_int_equal(merged.stats.image_bytes_written, 4 * pixels);
        assert_int_equal(merged.stats.image_bytes_read, 0);
        assert_int_equal(merged.stats.tile_bytes, (bytes[layout] + 4) * pixels);
        assert_true(merged.stats.lazy_committed_bytes <= merged.stats.lazy_bytes);
        frame.mobile.separate = true;
        struct shot separate = stage_shoot(&stage, &frame);
        double read = 1 - (double)merged.stats.image_bytes_read / (double)separate.stats.image_bytes_read;
        double written = 1 - (double)merged.stats.image_bytes_written / (double)separate.stats.image_bytes_written;
        print_message("%s: separate reads %.0f and writes %.0f bytes a pixel; merged %.0f %% and %.0f %% less\n",
                      fnl_mobile_layout_name(frame.mobile.layout), (double)separate.stats.image_bytes_read / (double)pixels,
                      (double)separate.stats.image_bytes_written / (double)pixels, 100 * read, 100 * written);
        assert_true(read >= 0.53 && written >= 0.54);
        shot_free(&merged);
        shot_free(&separate);
    }
    /* Every order has such numbers: deferred writes and reads its G-buffer. */
    fnl_frame frame = stage.frame;
    frame.outputs = FNL_OUTPUT_COLOR;
    frame.shading = FNL_SHADING_DEFERRED;
    struct shot deferred = stage_shoot(&stage, &frame);
    assert_true(deferred.stats.image_bytes_written >= 32ull * frame.width * frame.height);
    assert_true(deferred.stats.image_bytes_read >= 32ull * frame.width * frame.height);
    shot_free(&deferred);
    stage_close(&stage);
}

/* What a comparison plots: the time of the scope, and the bytes of the frame. No device here tells its power. */
static void test_time_and_bytes_of_a_frame_MB_17(void **state) {
    UNUSED(state);
    struct stage stage = stage_open(SCENE, 0);
    fnl_frame frame = mobile_frame(&stage);
    frame.timers = true;
    for (int separate = 0; separate < 2; separate++) {
        frame.mobile.separate = separate;
        assert_int_equal(fnl_renderer_render(stage.renderer, &frame), FNL_OK);
        fnl_frame_stats stats;
        assert_int_equal(fnl_renderer_query_stats(stage.renderer, &stats), FNL_OK);
        uint32_t scopes = 0, steps = 0;
        double milliseconds = 0;
        for (uint32_t i = 0; i < stats.pass_count; i++) {
            if (strncmp(stats.passes[i].name, "mobile", 6) != 0) continue;
            scopes += strcmp(stats.passes[i].name, "mobile") == 0;
            steps++;
            milliseconds += stats.passes[i].milliseconds;
        }
        if (stats.pass_count) { /* it has timestamps */
            assert_int_equal(scopes, separate ? 0 : 1);
            assert_int_equal(steps, separate ? 4 : 1);
            assert_true(milliseconds > 0 && milliseconds <= stats.gpu_milliseconds);
        }
        print_message("%s: %.2f ms, %llu bytes read, %llu written\n", separate ? "separate" : "merged", milliseconds,
                      (unsigned long long)stats.image_bytes_read, (unsigned long long)stats.image_bytes_written);
        assert_true(stats.image_bytes_written > 0 && (stats.image_bytes_read > 0) == separate);
    }
    stage_close(&stage);
}

static void test_bits_of_the_layouts_MB_4(void **state) {
    UNUSED(state);
    static const uint32_t bits[] = {128, 160, 256, 256}, used[] = {126, 142, 256, 256};
    for (int layout = 0; layout < FNL_MOBILE_LAYOUT_COUNT; layout++) {
        fnl_mobile_target targets[8];
        uint32_t count = fnl_mobile_layout_targets((fnl_mobile_layout)layout, targets, 8), sum = 0, sum_used = 0;
        assert_true(count <= 8);
        for (uint32_t i = 0; i < count; i++) {
            assert_non_null(targets[i].name);
            sum += targets[i].bits;
            sum_used += targets[i].used_bits;
        }
        assert_int_equal(sum, bits[layout]);
        assert_int_equal(sum_used, used[layout]);
    }
    assert_int_equal(fnl_mobile_layout_targets(FNL_MOBILE_LAYOUT_COUNT, NULL, 0), 0);
}

/* ---- inside the scope ---- */

static void test_the_picture_recycles_the_normals_MB_14(void **state) {
    UNUSED(state);
    struct stage stage = stage_open(SCENE, 0);
    for (int layout = FNL_MOBILE_METALLIC_128; layout <= FNL_MOBILE_SPECULAR_160; layout++)
        for (int separate = 0; separate < 2; separate++) {
            fnl_frame frame = mobile_frame(&stage);
            frame.mobile.layout = (fnl_mobile_layout)layout;
            frame.mobile.separate = separate;
            struct shot plain = stage_shoot(&stage, &frame);
            frame.mobile.recycle = true;
            struct shot recycled = stage_shoot(&stage, &frame);
            assert_same(&plain.color, &recycled.color, "recycled");
            const uint64_t pixels = (uint64_t)frame.width * frame.height;
            if (!separate) assert_int_equal(recycled.stats.tile_bytes + 4 * pixels, plain.stats.tile_bytes);
            assert_int_equal(recycled.stats.image_bytes_written, plain.stats.image_bytes_written);
            shot_free(&plain);
            shot_free(&recycled);
        }
    stage_close(&stage);
}

/* The radiance output takes tone mapping out of the scope: radiance is stored and a pass of its own makes the picture. */
static void test_tone_mapping_inside_equals_tone_mapping_after_MB_15(void **state) {
    UNUSED(state);
    struct stage stage = stage_open(SCENE, 0);
    for (int tonemap = 0; tonemap < FNL_TONEMAP_COUNT; tonemap++) {
        fnl_frame frame = mobile_frame(&stage);
        frame.tonemap = (fnl_tonemap)tonemap;
        frame.mobile.layout = (fnl_mobile_layout)tonemap;
        struct shot inside = stage_shoot(&stage, &frame);
        frame.outputs |= FNL_OUTPUT_RADIANCE;
        struct shot after = stage_shoot(&stage, &frame);
        assert_true(inside.stats.mobile_tonemapped && !after.stats.mobile_tonemapped && after.stats.mobile_merged);
        assert_int_equal(greatest_difference(&inside.color, &after.color), 0);
        shot_free(&inside);
        shot_free(&after);
    }
    stage_close(&stage);
}

/* Metering wants the whole frame first; the picture is that of deferred then, too. */
static void test_automatic_exposure_MB_15(void **state) {
    UNUSED(state);
    struct stage stage = stage_open(SCENE, 0);
    fnl_frame frame = mobile_frame(&stage);
    frame.exposure = FNL_EXPOSURE_AUTO;
    frame.mobile.light = FNL_MOBILE_LIGHT_UNORM; /* floats take over */
    struct shot mobile = stage_shoot(&stage, &frame);
    assert_true(mobile.stats.mobile_merged && !mobile.stats.mobile_tonemapped);
    frame.shading = FNL_SHADING_DEFERRED;
    struct shot deferred = stage_shoot(&stage, &frame);
    assert_true(fabsf(mobile.stats.ev - deferred.stats.ev) < 0.05f);
    assert_true(mean_difference(&mobile.color, &deferred.color) < 1);
    shot_free(&mobile);
    shot_free(&deferred);
    stage_close(&stage);
}

/* Makes all blended materials opaque or leaves them away. */
static fnl_scene *glass_scene(bool with_glass) {
    fnl_scene *scene = NULL;
    assert_int_equal(fnl_scene_load(NULL, "builtin:glass?lights=48", &scene), FNL_OK);
    if (!with_glass)
        for (uint32_t i = 0; i < scene->materials.count; i++)
            if (scene->materials.data[i].alpha_mode == FNL_ALPHA_BLEND) scene->materials.data[i].base_color.w = 0;
    return scene;
}

/* Blended surfaces are drawn between lights and tone mapping: over the accumulated light, which stays what it was elsewhere. */
static void test_glass_between_lights_and_tone_mapping_MB_16(void **state) {
    UNUSED(state);
    struct stage with = stage_open_scene(glass_scene(true)), without = stage_open_scene(glass_scene(false));
    for (int layout = 0; layout < FNL_MOBILE_LAYOUT_COUNT; layout++) {
        fnl_frame frame = mobile_frame(&with);
        frame.mobile.layout = (fnl_mobile_layout)layout;
        frame.outputs |= FNL_OUTPUT_RADIANCE;
        struct shot a = stage_shoot(&with, &frame), b = stage_shoot(&without, &frame);
        frame.shading = FNL_SHADING_FORWARD_PREPASS;
        struct shot forward = stage_shoot(&with, &frame), forward_without = stage_shoot(&without, &frame);
        uint64_t seen = 0, kept = 0, wrong = 0;
        const float *fa = forward.radiance.pixels, *fb = forward_without.radiance.pixels;
        const float *ma = a.radiance.pixels, *mb = b.radiance.pixels;
        for (size_t i = 0; i < (size_t)frame.width * frame.height; i++) {
            bool glass = memcmp(fa + 4 * i, fb + 4 * i, 12) != 0, changed = memcmp(ma + 4 * i, mb + 4 * i, 12) != 0;
            seen += glass && changed;
            kept += !glass && !changed;
            wrong += !glass && changed;
        }
        assert_true(seen > 100 && kept > 100);
        assert_int_equal(wrong, 0);
        assert_true(mean_difference(&a.color, &forward.color) < 1.5);
        shot_free(&a);
        shot_free(&b);
        shot_free(&forward);
        shot_free(&forward_without);
    }
    stage_close(&with);
    stage_close(&without);
}

/* Other kinds of transparency, points for small lights and debug views go on from radiance, after the scope. */
static void test_what_does_not_fit_inside_follows_MB_16(void **state) {
    UNUSED(state);
    struct stage stage = stage_open(SCENE, 0);
    for (int variant = 0; variant < 3; variant++) {
        fnl_frame frame = mobile_frame(&stage);
        if (variant == 0) frame.transparency = FNL_TRANSPARENCY_WEIGHTED;
        if (variant == 1) frame.light_lod = 3;
        if (variant == 2) frame.debug = FNL_DEBUG_LIGHTS;
        struct shot mobile = stage_shoot(&stage, &frame);
        assert_true(mobile.stats.mobile_merged && !mobile.stats.mobile_tonemapped);
        frame.shading = FNL_SHADING_DEFERRED;
        struct shot deferred = stage_shoot(&stage, &frame);
        if (variant < 2) assert_true(mean_difference(&mobile.color, &deferred.color) < 1.5);
        shot_free(&mobile);
        shot_free(&deferred);
    }
    stage_close(&stage);
}

/* ---- light that is more than the accumulator holds ---- */

static void test_light_beyond_the_accumulator_MB_13(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:spheres?lights=400", 0);
    for (int layout = 0; layout < FNL_MOBILE_LAYOUT_COUNT; layout++)
        for (int light = 0; light < FNL_MOBILE_LIGHT_COUNT; light++) {
            fnl_frame frame = mobile_frame(&stage);
            frame.mobile.layout = (fnl_mobile_layout)layout;
            frame.mobile.light = (fnl_mobile_light)light;
            frame.mobile.range = 4;
            frame.ev = -30; /* every light is far too bright */
            frame.outputs |= FNL_OUTPUT_RADIANCE;
            struct shot shot = stage_shoot(&stage, &frame);
            assert_int_equal(count_broken(&shot.radiance), 0);
            float most = 0;
            const float *p = shot.radiance.pixels;
            for (size_t i = 0; i < (size_t)frame.width * frame.height * 4; i++)
                if (i % 4 < 3) most = fmaxf(most, p[i]);
            double factor = 1 / (1.2 * exp2((double)frame.ev));
            double limit = (layout >= FNL_MOBILE_METALLIC_256 ? 65504 : light ? 4 : 64512) / factor;
            assert_true((double)most <= limit * 1.0001 && (double)most > limit * 0.98);
            shot_free(&shot);
        }
    stage_close(&stage);
}

/* ---- materials ---- */

/* Spheres whose materials are `edit`ed, in even light from all around and in that of lights. */
static struct stage edited_spheres(const char *source, void (*edit)(struct scene_material *material, uint32_t index)) {
    fnl_scene *scene = NULL;
    assert_int_equal(fnl_scene_load(NULL, source, &scene), FNL_OK);
    for (uint32_t i = 0; i < scene->materials.count; i++) edit(&scene->materials.data[i], i);
    return stage_open_scene(scene);
}

static void make_pure(struct scene_material *m, uint32_t index) {
    for (uint32_t t = 0; t < COUNT_OF(m->textures); t++) m->textures[t].image = SCENE_NONE;
    m->metallic = (float)(index % 2);
    m->specular = 1;
    m->ior = 1.5f;
    m->specular_color = (vec3){1, 1, 1};
}

/* Metals and dielectrics come out alike whether their colour and metalness are kept or their diffuse and specular colours. */
static void test_metallic_and_specular_layouts_agree_MB_5(void **state) {
    UNUSED(state);
    struct stage stage = edited_spheres("builtin:spheres?lights=60", make_pure);
    for (int wide = 0; wide < 2; wide++) {
        fnl_frame frame = mobile_frame(&stage);
        frame.ev = 3;
        frame.mobile.layout = wide ? FNL_MOBILE_METALLIC_256 : FNL_MOBILE_METALLIC_128;
        struct shot metallic = stage_shoot(&stage, &frame);
        frame.mobile.layout = wide ? FNL_MOBILE_SPECULAR_256 : FNL_MOBILE_SPECULAR_160;
        struct shot specular = stage_shoot(&stage, &frame);
        double mean = mean_difference(&metallic.color, &specular.color);
        print_message("%s bits: %d/255 at most, %.3f in the mean\n", wide ? "256" : "128 and 160",
                      greatest_difference(&metallic.color, &specular.color), mean);
        /* Packed floats keep normals in six bits and less, which moves highlights. */
        assert_true(mean < (wide ? 0.5 : 0.05));
        assert_true(wide ? count_beyond(&metallic.color, &specular.color, 16) < 150
                         : greatest_difference(&metallic.color, &specular.color) <= 3);
        shot_free(&metallic);
        shot_free(&specular);
    }
    stage_close(&stage);
}

static float furnace_metallic, furnace_roughness;

static void make_white(struct scene_material *m, uint32_t index) {
    UNUSED(index);
    for (uint32_t t = 0; t < COUNT_OF(m->textures); t++) m->textures[t].image = SCENE_NONE;
    m->base_color = (vec4){1, 1, 1, 1};
    m->emissive = (vec3){0, 0, 0};
    m->metallic = furnace_metallic;
    m->roughness = furnace_roughness;
    m->specular = 1;
    m->ior = 1.5f;
    m->specular_color = (vec3){1, 1, 1};
    m->occlusion_strength = 0;
}

/* The brightest pixel, and the mean of those that are not black. */
static float brightest(struct stage *stage, fnl_frame frame, double *mean) {
    frame.exposure = FNL_EXPOSURE_NONE;
    frame.outputs = FNL_OUTPUT_RADIANCE;
    float most = 0;
    struct shot shot = stage_shoot(stage, &frame);
    assert_int_equal(count_broken(&shot.radiance), 0);
    const float *p = shot.radiance.pixels;
    double sum = 0, count = 0;
    for (size_t i = 0; i < (size_t)frame.width * frame.height; i++) {
        most = fmaxf(most, fmaxf(p[4 * i], fmaxf(p[4 * i + 1], p[4 * i + 2])));
        sum += (double)p[4 * i];
        count += p[4 * i] > 0;
    }
    *mean = sum / fmax(count, 1);
    shot_free(&shot);
    return most;
}

/* White things before white, lit by white: nothing may be brighter than what lights it. Once by ambient light, once by suns all around. */
static void test_white_furnace_MB_7(void **state) {
    UNUSED(state);
    enum { SUNS = 300 };
    for (int metallic = 0; metallic <= 2; metallic++)
        for (int roughness = 0; roughness <= 4; roughness++) {
            furnace_metallic = 0.5f * (float)metallic;
            furnace_roughness = 0.25f * (float)roughness;
            struct stage stage = edited_spheres("builtin:spheres?lights=0", make_white);
            assert_int_equal(fnl_scene_set_background(stage.scene, (vec3){1, 1, 1}), FNL_OK);
            assert_int_equal(fnl_scene_set_ambient(stage.scene, (vec3){1, 1, 1}, (vec3){1, 1, 1}), FNL_OK);
            fnl_frame frame = mobile_frame(&stage);
            frame.width = 81;
            frame.height = 45;
            frame.mobile.layout = FNL_MOBILE_METALLIC_256;
            double mean = 0;
            float ambient = brightest(&stage, frame, &mean), suns = 0;
            if (roughness >= 2) { /* smooth surfaces show each sun */
                assert_int_equal(fnl_scene_set_ambient(stage.scene, (vec3){0, 0, 0}, (vec3){0, 0, 0}), FNL_OK);
                assert_int_equal(fnl_scene_set_background(stage.scene, (vec3){0, 0, 0}), FNL_OK);
                for (int i = 0; i < SUNS; i++) { /* Fibonacci's spiral */
                    float y = 1 - (2 * (float)i + 1) / SUNS, ring = sqrtf(1 - y * y), turn = 2.3999632f * (float)i;
                    fnl_light_params sun = fnl_light_params_default();
                    fnl_light_id id;
                    sun.kind = FNL_LIGHT_DIRECTIONAL;
                    sun.direction = (vec3){ring * cosf(turn), y, ring * sinf(turn)};
                    sun.intensity = 4 * PI / SUNS;
                    assert_int_equal(fnl_scene_add_light(stage.scene, &sun, &id), FNL_OK);
                }
                suns = brightest(&stage, frame, &mean);
            }
            print_message("metalness %g, roughness %g: %g of ambient light, %g of suns, %g in the mean\n",
                          (double)furnace_metallic, (double)furnace_roughness, (double)ambient, (double)suns, mean);
            /* glTF's dielectric takes from diffuse light what is reflected at the half vector, less than is reflected on the whole where
               one looks along the surface: it gains there, a hundredth on the whole. */
            assert_true(ambient <= 1.001f && mean <= (metallic == 2 ? 1.001 : 1.02) &&
                        suns <= (metallic == 2 ? 1.1f : 1.3f));
            if (roughness >= 2) assert_true(mean > 0.3);
            stage_close(&stage);
        }
}

/* ---- halos ---- */

/* Dark paint beside bright metal; their border is magnified, so that colour and mask fade over many pixels. */
static fnl_scene *painted_metal(void) {
    enum { SIDE = 16 };
    static const float positions[] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0}, uv[] = {0, 1, 1, 1, 1, 0, 0, 0};
    static const uint32_t indices[] = {0, 1, 2, 0, 2, 3};
    uint8_t colors[SIDE * SIDE][4], masks[SIDE * SIDE][4];
    for (int i = 0; i < SIDE * SIDE; i++) {
        bool metal = i % SIDE >= SIDE / 2;
        memset(colors[i], metal ? 250 : 40, 3);
        memcpy(masks[i], (uint8_t[]){0, 70, metal ? 255 : 0, 255}, 4);
        colors[i][3] = 255;
    }
    fnl_scene *scene;
    assert_int_equal(fnl_scene_create(gpu_host(harness_device()), &scene), FNL_OK);
    fnl_material_params material = fnl_material_params_default();
    const fnl_image color = {SIDE, SIDE, FNL_PIXEL_FORMAT_RGBA8, colors}, mask = {SIDE, SIDE, FNL_PIXEL_FORMAT_RGBA8, masks};
    assert_int_equal(fnl_scene_add_image(scene, &color, true, &material.base_color_image), FNL_OK);
    assert_int_equal(fnl_scene_add_image(scene, &mask, false, &material.metallic_roughness_image), FNL_OK);
    fnl_mesh_params mesh = {.vertex_count = 4, .index_count = 6, .positions = positions, .uv = uv, .indices = indices};
    fnl_mesh_id mesh_id;
    fnl_instance_id instance;
    fnl_mat4 matrix = mat4_identity();
    assert_int_equal(fnl_scene_add_material(scene, &material, &mesh.material), FNL_OK);
    assert_int_equal(fnl_scene_add_mesh(scene, &mesh, &mesh_id), FNL_OK);
    assert_int_equal(fnl_scene_add_instance(scene, mesh_id, &matrix, &instance), FNL_OK);
    fnl_light_params sun = fnl_light_params_default(); /* from the side, so that metal shows little of it */
    fnl_light_id id;
    sun.kind = FNL_LIGHT_DIRECTIONAL;
    sun.direction = (vec3){0, -0.9f, -0.3f};
    sun.intensity = 10;
    assert_int_equal(fnl_scene_add_light(scene, &sun, &id), FNL_OK);
    assert_int_equal(fnl_scene_set_ambient(scene, (vec3){0, 0, 0}, (vec3){0, 0, 0}), FNL_OK);
    return scene;
}

static void test_metal_that_reaches_farther_has_no_halo_MB_6(void **state) {
    UNUSED(state);
    double halo[4];
    float paint[4], metal[4];
    for (uint32_t grown = 0; grown < 4; grown++) {
        fnl_scene *scene = painted_metal();
        assert_int_equal(fnl_scene_grow_metal(scene, 65), FNL_ERROR_INVALID);
        assert_int_equal(fnl_scene_grow_metal(scene, grown), FNL_OK);
        struct stage stage = stage_open_scene(scene);
        fnl_frame frame = mobile_frame(&stage);
        frame.width = frame.height = 128;
        frame.camera = fnl_camera_default();
        frame.camera.position = (vec3){0, 0, 5};
        frame.camera.target = (vec3){0, 0, 0};
        frame.camera.orthographic = true;
        frame.camera.vertical_extent = 1.6f;
        frame.camera.far_distance = 20;
        frame.outputs = FNL_OUTPUT_RADIANCE;
        frame.mobile.layout = FNL_MOBILE_METALLIC_256;
        struct shot shot = stage_shoot(&stage, &frame);
        const float *row = (const float *)shot.radiance.pixels + 4 * (size_t)64 * 128;
        paint[grown] = row[4 * 24];
        metal[grown] = row[4 * 104];
        double sides = fmax((double)row[4 * 24], (double)row[4 * 104]), most = 0;
        for (int x = 24; x <= 104; x++) most = fmax(most, (double)row[4 * x]);
        halo[grown] = most / sides;
        print_message("metal grown by %u texels: the border is %.2f times as bright as its sides\n", grown, halo[grown]);
        shot_free(&shot);
        stage_close(&stage);
    }
    for (int i = 1; i < 4; i++) assert_true(paint[i] == paint[0] && metal[i] == metal[0]); /* the sides stay what they are */
    assert_true(halo[0] > 1.25 && halo[2] < 1.02 && halo[3] < 1.02);
}

/* ---- the lobe against double precision ---- */

static float lobe_roughness, lobe_metallic;

static void make_lobe(struct scene_material *m, uint32_t index) {
    make_white(m, index);
    m->base_color = (vec4){0.5f, 0.25f, 1, 1}; /* packed floats hold these */
    m->roughness = lobe_roughness;
    m->metallic = lobe_metallic;
}

static void test_the_lobe_is_the_references_MB_8(void **state) {
    UNUSED(state);
    for (int i = 0; i < 6; i++) {
        lobe_roughness = 0.25f + 0.25f * (float)(i % 3);
        lobe_metallic = i < 3 ? 0 : 1;
        struct stage stage = edited_spheres("builtin:wall?lights=0", make_lobe);
        fnl_frame frame = mobile_frame(&stage);
        fnl_light_params light = fnl_light_params_default();
        fnl_light_id id;
        light.position = (vec3){2, 7, -15};
        light.intensity = 100;
        light.range = 200;
        assert_int_equal(fnl_scene_set_ambient(stage.scene, (vec3){0, 0, 0}, (vec3){0, 0, 0}), FNL_OK);
        assert_int_equal(fnl_scene_add_light(stage.scene, &light, &id), FNL_OK);
        frame.mobile.layout = FNL_MOBILE_METALLIC_256;
        frame.exposure = FNL_EXPOSURE_NONE;
        frame.outputs = FNL_OUTPUT_RADIANCE | FNL_OUTPUT_POSITION;
        struct shot shot = stage_shoot(&stage, &frame);
        const float *radiance = shot.radiance.pixels, *position = shot.position.pixels;
        double worst = 0, most = 0;
        for (size_t k = 0; k < (size_t)frame.width * frame.height; k++) {
            if (position[4 * k + 3] == 0 || fabsf(position[4 * k + 2] + 20) > 1e-3f) continue;
            struct reference_surface s = reference_surface_default();
            double to_view[3], length = 0, expected[3];
            const float eye[3] = {frame.camera.position.x, frame.camera.position.y, frame.camera.position.z};
            for (int c = 0; c < 3; c++) {
                s.position[c] = (double)position[4 * k + (size_t)c];
                s.normal[c] = c == 2;
                to_view[c] = (double)eye[c] - s.position[c];
                length += to_view[c] * to_view[c];
            }
            for (int c = 0; c < 3; c++) to_view[c] /= sqrt(length);
            memcpy(s.base_color, (double[]){0.5, 0.25, 1}, sizeof s.base_color);
            s.metallic = (double)lobe_metallic;
            s.roughness = (double)lobe_roughness;
            reference_shade(&s, to_view, &light, 1, (fnl_vec3){0, 0, 0}, (fnl_vec3){0, 0, 0}, expected);
            for (int c = 0; c < 3; c++) {
                worst = fmax(worst, fabs((double)radiance[4 * k + (size_t)c] - expected[c]));
                most = fmax(most, expected[c]);
            }
        }
        print_message("roughness %g, metalness %g: off by %.5f of the brightest\n", (double)lobe_roughness,
                      (double)lobe_metallic, worst / most);
        assert_true(most > 0.1 && worst / most < 0.002); /* 16-bit floats */
        shot_free(&shot);
        stage_close(&stage);
    }
}

/* ---- colours ---- */

static double decoded(fnl_mobile_gamma gamma, double value) { /* what eight bits make of it */
    double encoded = gamma == FNL_MOBILE_GAMMA_SQRT    ? sqrt(value)
                     : gamma == FNL_MOBILE_GAMMA_POWER ? pow(value, 1 / 2.2)
                     : value <= 0.0031308              ? 12.92 * value
                                                       : 1.055 * pow(value, 1 / 2.4) - 0.055;
    encoded = round(encoded * 255) / 255;
    return gamma == FNL_MOBILE_GAMMA_SQRT    ? encoded * encoded
           : gamma == FNL_MOBILE_GAMMA_POWER ? pow(encoded, 2.2)
           : encoded <= 0.04045              ? encoded / 12.92
                                             : pow((encoded + 0.055) / 1.055, 2.4);
}

/* A wall of one grey after another under ambient light: the radiance is its colour, as the layout keeps it, times a constant. */
static void make_grey(struct scene_material *m, uint32_t index) {
    make_white(m, index);
    m->base_color = (vec4){furnace_metallic, furnace_metallic, furnace_metallic, 1};
    m->metallic = 0;
    m->roughness = 1;
}

static void test_gamma_of_colours_MB_11(void **state) {
    UNUSED(state);
    double worst[FNL_MOBILE_GAMMA_COUNT] = {0}, dark_step[FNL_MOBILE_GAMMA_COUNT] = {0};
    for (int gamma = 0; gamma < FNL_MOBILE_GAMMA_COUNT; gamma++) {
        double before = -1;
        for (int i = 0; i <= 20000; i++) {
            double value = i / 20000.0, kept = decoded((fnl_mobile_gamma)gamma, value);
            worst[gamma] = fmax(worst[gamma], fabs(kept - value));
            if (value < 0.02 && kept != before) dark_step[gamma] = fmax(dark_step[gamma], before < 0 ? 0 : kept - before);
            before = kept;
        }
        print_message("%s: off by %.5f at most, steps of %.5f in the darkest fiftieth\n",
                      fnl_mobile_gamma_name((fnl_mobile_gamma)gamma), worst[gamma], dark_step[gamma]);
        assert_true(worst[gamma] < 0.0047 && dark_step[gamma] < 0.0012); /* plain bytes: steps of 0.0039 */
    }
    /* And so do the shaders: a lit wall is as bright as the grey that eight bits make of it, to what the light's floats keep. */
    for (int i = 0; i < 6; i++) {
        furnace_metallic = (float)(0.004 + 0.16 * i);
        struct stage stage = edited_spheres("builtin:spheres?lights=0", make_grey);
        fnl_frame frame = mobile_frame(&stage);
        fnl_light_params sun = fnl_light_params_default();
        fnl_light_id id;
        sun.kind = FNL_LIGHT_DIRECTIONAL;
        sun.direction = (vec3){0, -1, 0};
        sun.intensity = 100;
        assert_int_equal(fnl_scene_set_ambient(stage.scene, (vec3){0, 0, 0}, (vec3){0, 0, 0}), FNL_OK);
        assert_int_equal(fnl_scene_add_light(stage.scene, &sun, &id), FNL_OK);
        frame.outputs = FNL_OUTPUT_RADIANCE;
        frame.mobile.layout = FNL_MOBILE_METALLIC_256; /* keeps colours in floats */
        struct shot exact = stage_shoot(&stage, &frame);
        frame.mobile.layout = FNL_MOBILE_SPECULAR_160;
        for (int gamma = 0; gamma < FNL_MOBILE_GAMMA_COUNT; gamma++) {
            frame.mobile.gamma = (fnl_mobile_gamma)gamma;
            struct shot shot = stage_shoot(&stage, &frame);
            const float *p = exact.radiance.pixels, *q = shot.radiance.pixels;
            double sum = 0, kept = 0;
            for (size_t k = 0; k < (size_t)frame.width * frame.height; k++) {
                sum += (double)p[4 * k];
                kept += (double)q[4 * k];
            }
            double value = (double)furnace_metallic, expected = decoded((fnl_mobile_gamma)gamma, value) / value;
            double off = kept / sum / expected;
            if (value > 0.1 && (off < 0.97 || off > 1.03))
                fail_msg("%s, %g: %g instead of %g", fnl_mobile_gamma_name((fnl_mobile_gamma)gamma), value, kept / sum,
                         expected);
            shot_free(&shot);
        }
        shot_free(&exact);
        stage_close(&stage);
    }
}

/* ---- decals ---- */

/* A box on the wall, or before it. */
static void add_decal(struct stage *stage, vec3 at, vec3 size, fnl_decal_params params) {
    fnl_decal_id id;
    params.transform = mat4_from_trs(at, quat_axis_angle((vec3){0, 0, 1}, at.x), size);
    assert_int_equal(fnl_scene_add_decal(stage->scene, &params, &id), FNL_OK);
}

static const vec3 on_wall = {0, 6, -20};

/*
 * The step after geometry rewrites what the targets hold. Each channel, each blend mode: as where surfaces look decals up while they are
 * drawn, to what the targets' bits round; nothing beside the box; nothing where the surface is behind it; and as in separate passes.
 */
static void check_decal(struct stage *stage, const struct shot *off, fnl_mobile_layout layout, const char *what,
                        bool changes) {
    fnl_frame frame = mobile_frame(stage);
    frame.ev = 3;
    frame.mobile.layout = layout;
    frame.decals = FNL_DECALS_LISTS;
    struct shot lists = stage_shoot(stage, &frame);
    frame.decals = FNL_DECALS_GBUFFER;
    struct shot step = stage_shoot(stage, &frame), again = stage_shoot(stage, &frame);
    assert_true(step.stats.mobile_merged && step.stats.mobile_tonemapped);
    assert_true(step.stats.image_bytes_read == 0);
    frame.mobile.separate = true;
    struct shot separate = stage_shoot(stage, &frame);
    assert_same(&step.color, &again.color, what);
    assert_same(&step.color, &separate.color, what);
    const uint8_t *p = step.color.pixels, *q = off->color.pixels, *l = lists.color.pixels;
    uint64_t changed = 0, stray = 0;
    for (size_t i = 0; i < (size_t)frame.width * frame.height * 4; i += 4) {
        changed += memcmp(p + i, q + i, 4) != 0;
        for (int c = 0; c < 3; c++) stray += l[i + c] == q[i + c] && abs(p[i + c] - q[i + c]) > 2;
    }
    int most = greatest_difference(&step.color, &lists.color);
    if (changes != (changed > 200) || (!changes && changed) || stray || most > 4)
        fail_msg("%s, %s: %llu pixels change, %llu of them only here; %d/255 from lists", what,
                 fnl_mobile_layout_name(layout), (unsigned long long)changed, (unsigned long long)stray, most);
    shot_free(&lists);
    shot_free(&step);
    shot_free(&again);
    shot_free(&separate);
}

static void test_decals_rewrite_the_targets_MB_12(void **state) {
    UNUSED(state);
    static const struct {
        const char *what;
        uint32_t channels;
        fnl_decal_blend blend;
        float z;
        bool changes;
    } cases[] = {{"colour", FNL_DECAL_COLOR, FNL_DECAL_BLEND_ALPHA, -20, true},
                 {"multiply", FNL_DECAL_COLOR, FNL_DECAL_BLEND_MULTIPLY, -20, true},
                 {"add", FNL_DECAL_COLOR, FNL_DECAL_BLEND_ADD, -20, true},
                 {"overlay", FNL_DECAL_COLOR, FNL_DECAL_BLEND_OVERLAY, -20, true},
                 {"roughness", FNL_DECAL_ROUGHNESS, FNL_DECAL_BLEND_ALPHA, -20, true},
                 {"metalness", FNL_DECAL_METALLIC, FNL_DECAL_BLEND_ALPHA, -20, true},
                 {"glow", FNL_DECAL_EMISSION, FNL_DECAL_BLEND_ALPHA, -20, true},
                 {"flat normals", FNL_DECAL_NORMAL, FNL_DECAL_BLEND_ALPHA, -20, false}, /* no map: none is changed */
                 {"before the wall", FNL_DECAL_ALL, FNL_DECAL_BLEND_ALPHA, -17, false}};
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        struct stage stage = stage_open("builtin:wall?lights=12", 0);
        fnl_mobile_layout layout = (fnl_mobile_layout)(i % FNL_MOBILE_LAYOUT_COUNT);
        fnl_frame frame = mobile_frame(&stage);
        frame.ev = 3;
        frame.mobile.layout = layout;
        struct shot off = stage_shoot(&stage, &frame);
        fnl_decal_params params = fnl_decal_params_default();
        params.channels = cases[i].channels;
        params.blend = cases[i].blend;
        memcpy(params.color, (float[]){0.9f, 0.2f, 0.4f, 0.8f}, sizeof params.color);
        memcpy(params.emissive, (float[]){0.5f, 1, 2}, sizeof params.emissive);
        params.metallic = 1;
        params.roughness = 0.15f;
        vec3 at = on_wall;
        at.z = cases[i].z;
        add_decal(&stage, at, (vec3){16, 10, 2}, params);
        check_decal(&stage, &off, layout, cases[i].what, cases[i].changes);
        shot_free(&off);
        stage_close(&stage);
    }
}

static void test_many_decals_over_one_another_MB_12(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:wall?lights=12", 0);
    fnl_frame frame = mobile_frame(&stage);
    frame.ev = 3;
    struct shot off = stage_shoot(&stage, &frame);
    struct random_state random = {4};
    for (int i = 0; i < 120; i++) {
        fnl_decal_params params = fnl_decal_params_default();
        params.blend = (fnl_decal_blend)(i % FNL_DECAL_BLEND_COUNT);
        for (int c = 0; c < 4; c++) params.color[c] = random_float(&random);
        vec3 at = {random_range(&random, -9, 9), random_range(&random, 1, 11), -20};
        add_decal(&stage, at, (vec3){random_range(&random, 4, 14), random_range(&random, 4, 14), 1}, params);
    }
    for (int layout = 0; layout < FNL_MOBILE_LAYOUT_COUNT; layout++) {
        frame.mobile.layout = (fnl_mobile_layout)layout;
        check_decal(&stage, &off, (fnl_mobile_layout)layout, "120 decals", true);
    }
    /* One that is not for everything: surfaces look decals up as they are drawn, for the targets do not know what receives them. */
    fnl_decal_params params = fnl_decal_params_default();
    params.receivers = 2;
    add_decal(&stage, on_wall, (vec3){4, 4, 2}, params);
    frame.decals = FNL_DECALS_GBUFFER;
    struct shot step = stage_shoot(&stage, &frame);
    frame.decals = FNL_DECALS_LISTS;
    struct shot lists = stage_shoot(&stage, &frame);
    assert_same(&step.color, &lists.color, "masks");
    shot_free(&step);
    shot_free(&lists);
    shot_free(&off);
    stage_close(&stage);
}

/* ---- without what it needs ---- */

static void test_without_inputs_the_passes_are_separate_MB_18(void **state) {
    UNUSED(state);
    struct stage stage = stage_open(SCENE, 0);
    fnl_frame frame = mobile_frame(&stage);
    struct shot merged = stage_shoot(&stage, &frame);
    assert_int_equal(stage.renderer->mobile_notes, 0);
    stage.renderer->cannot_merge = true;
    struct shot fallback = stage_shoot(&stage, &frame);
    assert_true(merged.stats.mobile_merged && !fallback.stats.mobile_merged);
    assert_int_equal(stage.renderer->mobile_notes, 2); /* and it said so */
    assert_same(&merged.color, &fallback.color, "fallback");
    frame.msaa = 4;
    assert_int_equal(fnl_renderer_render(stage.renderer, &frame), FNL_ERROR_UNSUPPORTED);
    shot_free(&merged);
    shot_free(&fallback);
    stage_close(&stage);
}

int main(int count, char **arguments) {
    if (count > 1) cmocka_set_test_filter(arguments[1]);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_merged_and_separate_are_equal_MB_1, harness_check),
        cmocka_unit_test_teardown(test_odd_frames_MB_1, harness_check),
        cmocka_unit_test_teardown(test_every_list_leaves_the_same_bits_MB_1, harness_check),
        cmocka_unit_test_teardown(test_only_the_picture_is_stored_MB_2_MB_3_ES_68, harness_check),
        cmocka_unit_test_teardown(test_time_and_bytes_of_a_frame_MB_17, harness_check),
        cmocka_unit_test_teardown(test_bits_of_the_layouts_MB_4, harness_check),
        cmocka_unit_test_teardown(test_the_picture_recycles_the_normals_MB_14, harness_check),
        cmocka_unit_test_teardown(test_tone_mapping_inside_equals_tone_mapping_after_MB_15, harness_check),
        cmocka_unit_test_teardown(test_automatic_exposure_MB_15, harness_check),
        cmocka_unit_test_teardown(test_glass_between_lights_and_tone_mapping_MB_16, harness_check),
        cmocka_unit_test_teardown(test_what_does_not_fit_inside_follows_MB_16, harness_check),
        cmocka_unit_test_teardown(test_light_beyond_the_accumulator_MB_13, harness_check),
        cmocka_unit_test_teardown(test_metallic_and_specular_layouts_agree_MB_5, harness_check),
        cmocka_unit_test_teardown(test_white_furnace_MB_7, harness_check),
        cmocka_unit_test_teardown(test_the_lobe_is_the_references_MB_8, harness_check),
        cmocka_unit_test_teardown(test_metal_that_reaches_farther_has_no_halo_MB_6, harness_check),
        cmocka_unit_test_teardown(test_gamma_of_colours_MB_11, harness_check),
        cmocka_unit_test_teardown(test_decals_rewrite_the_targets_MB_12, harness_check),
        cmocka_unit_test_teardown(test_many_decals_over_one_another_MB_12, harness_check),
        cmocka_unit_test_teardown(test_without_inputs_the_passes_are_separate_MB_18, harness_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
