/* SPDX-License-Identifier: MIT */
/** The order mobile: merged or not the same pixels, what it stores, its layouts, glass and tone mapping inside the scope. */
#include "passes/mobile/mobile.h"
#include "tests/mobile_cases.h"

/* ---- the same picture in all modes ---- */

static void test_merged_and_separate_are_equal_MB_1(void **state) {
    UNUSED(state);
    struct stage stage = stage_open(MOBILE_SCENE, 0);
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
            assert_true(counter(&merged.stats, "mobile.merged") && counter(&merged.stats, "mobile.tonemapped-inside") &&
                        !counter(&separate.stats, "mobile.merged"));
            assert_same(&merged.color, &separate.color, fnl_value_name(FNL_ENUM_MOBILE_LAYOUT, frame.mobile.layout));
            bool wide = layout >= FNL_MOBILE_METALLIC_256;
            double mean = mean_difference(&merged.color, &forward.color);
            print_message("%s, %s light: %.3f/255 from forward in the mean, %d at most\n",
                          fnl_value_name(FNL_ENUM_MOBILE_LAYOUT, frame.mobile.layout), fnl_value_name(FNL_ENUM_MOBILE_LIGHT, frame.mobile.light), mean,
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
            frame.gbuffer.prepass = variant == 3;
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
    struct stage stage = stage_open(MOBILE_SCENE, 0);
    fnl_frame frame = mobile_frame(&stage);
    frame.lists = FNL_LISTS_ALL;
    frame.outputs |= FNL_OUTPUT_RADIANCE;
    struct shot all = stage_shoot(&stage, &frame);
    static const fnl_light_lists lists[] = {FNL_LISTS_TILED, FNL_LISTS_CLUSTERED, FNL_LISTS_ZBIN, FNL_LISTS_FINE,
                                            FNL_LISTS_BVH};
    for (uint32_t i = 0; i < 2 * COUNT_OF(lists); i++) {
        frame.lists = lists[i / 2];
        frame.gbuffer.prepass = i & 1;
        struct shot shot = stage_shoot(&stage, &frame);
        assert_same(&all.radiance, &shot.radiance, fnl_value_name(FNL_ENUM_LISTS, frame.lists));
        shot_free(&shot);
    }
    shot_free(&all);
    stage_close(&stage);
}

/*
 * Lights as volumes: of every layout the picture of lists but for the order in which floats were added, the same bits merged and separate, no
 * light more or less than reaches a pixel, nothing stored besides. All shapes; with suns, whose sum is added first; no lights at all.
 */
static void test_lights_as_volumes_MB_1_MB_2_MB_13(void **state) {
    UNUSED(state);
    static const char *const sources[] = {"builtin:glass?lights=48", "builtin:interior?lights=60", "builtin:sky",
                                          "builtin:spheres?lights=0"};
    for (uint32_t i = 0; i < COUNT_OF(sources); i++) {
        struct stage stage = stage_open(sources[i], 0);
        for (int variant = 0; variant < (i == 0 ? FNL_MOBILE_LAYOUT_COUNT : 2); variant++) {
            fnl_frame frame = mobile_frame(&stage);
            frame.width = 97;
            frame.height = 55;
            frame.lists = FNL_LISTS_ALL;
            frame.mobile.layout = (fnl_mobile_layout)(i == 0 ? variant : 2 * variant);
            frame.mobile.light = variant == 1 ? FNL_MOBILE_LIGHT_UNORM : FNL_MOBILE_LIGHT_FLOAT;
            frame.gbuffer.prepass = variant == 1;
            frame.count_lights = true;
            struct shot lists = stage_shoot(&stage, &frame);
            frame.mobile.lights = FNL_MOBILE_LIGHTS_VOLUMES;
            frame.volume_shape = (fnl_volume_shape)((i + (uint32_t)variant) % FNL_VOLUME_SHAPE_COUNT);
            struct shot volumes = stage_shoot(&stage, &frame);
            assert_true(counter(&volumes.stats, "mobile.merged") && counter(&volumes.stats, "mobile.tonemapped-inside"));
            frame.mobile.separate = true;
            struct shot separate = stage_shoot(&stage, &frame);
            assert_same(&volumes.color, &separate.color, sources[i]);
            print_message(
                "%s, %s, %s: %llu of %u pixels are not those of lists, by %d at most; %llu evaluations instead of %llu\n",
                sources[i], fnl_value_name(FNL_ENUM_MOBILE_LAYOUT, frame.mobile.layout),
                fnl_value_name(FNL_ENUM_VOLUME_SHAPE, frame.volume_shape),
                (unsigned long long)count_differing(&lists.color, &volumes.color), frame.width * frame.height,
                greatest_difference(&lists.color, &volumes.color), (unsigned long long)volumes.stats.evaluations,
                (unsigned long long)lists.stats.evaluations);
            assert_true(count_beyond(&lists.color, &volumes.color, 1) <=
                        3); /* a step of six-bit floats may be more than one */
            assert_true(count_differing(&lists.color, &volumes.color) <= 10);
            assert_int_equal(volumes.stats.evaluations_useful, lists.stats.evaluations_useful);
            if (i < 2) assert_true(volumes.stats.evaluations_useful > 0);
            const uint64_t pixels = (uint64_t)frame.width * frame.height;
            assert_int_equal(volumes.stats.image_bytes_written, lists.stats.image_bytes_written);
            assert_int_equal(volumes.stats.image_bytes_read, lists.stats.image_bytes_read);
            uint64_t more = volumes.stats.tile_bytes - lists.stats.tile_bytes;
            assert_true(more == 16 * pixels || more == 8 * pixels);
            shot_free(&lists);
            shot_free(&volumes);
            shot_free(&separate);
        }
        stage_close(&stage);
    }
}

/* ---- what is stored ---- */

static void test_only_the_picture_is_stored_MB_2_MB_3_ES_68(void **state) {
    UNUSED(state);
    struct stage stage = stage_open(MOBILE_SCENE, 0);
    static const uint64_t bytes[] = {16, 20, 32, 32}; /* of a pixel's targets */
    for (int layout = 0; layout < FNL_MOBILE_LAYOUT_COUNT; layout++) {
        fnl_frame frame = mobile_frame(&stage);
        frame.lists = FNL_LISTS_CLUSTERED;
        frame.mobile.layout = (fnl_mobile_layout)layout;
        const uint64_t pixels = (uint64_t)frame.width * frame.height;
        struct shot merged = stage_shoot(&stage, &frame);
        char table[8192];
        assert_true(fnl_renderer_print(stage.renderer, FNL_PRINT_TRAFFIC, table, sizeof table) < sizeof table);
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
                      fnl_value_name(FNL_ENUM_MOBILE_LAYOUT, frame.mobile.layout), (double)separate.stats.image_bytes_read / (double)pixels,
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
    struct stage stage = stage_open(MOBILE_SCENE, 0);
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
        /* Separate: four targets, light again, light and depth for glass, the picture; back come the targets, light for the picture,
           light and depth for glass. */
        const uint64_t pixels = (uint64_t)frame.width * frame.height;
        assert_int_equal(stats.image_bytes_written, (separate ? 32 : 4) * pixels);
        assert_int_equal(stats.image_bytes_read, (separate ? 28 : 0) * pixels);
    }
    stage_close(&stage);
}

/* Bits of a format that hold something: its alpha is padding where the layout has none. */
static uint32_t used_bits(VkFormat format, bool alpha) {
    switch (format) {
    case VK_FORMAT_A2B10G10R10_UNORM_PACK32:
        return 30 + (alpha ? 2 : 0);
    case VK_FORMAT_R8G8B8A8_UNORM:
    case VK_FORMAT_R8G8B8A8_SRGB:
        return 24 + (alpha ? 8 : 0);
    case VK_FORMAT_R32_SFLOAT:
    case VK_FORMAT_R16G16_SFLOAT:
    case VK_FORMAT_B10G11R11_UFLOAT_PACK32:
        return 32;
    default:
        return 0;
    }
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
        /* What is drawn to is what was said of it. */
        struct mobile_layout drawn = mobile_layout((fnl_mobile_layout)layout, FNL_MOBILE_GAMMA_SRGB, false);
        assert_int_equal(drawn.target_count, count);
        for (uint32_t i = 0; i < count; i++) {
            bool alpha = strcmp(targets[i].name, "mobile normal") == 0 || strcmp(targets[i].name, "mobile color") == 0;
            assert_string_equal(drawn.targets[i].name, targets[i].name);
            assert_int_equal(gpu_texel_bytes(drawn.targets[i].format) * 8, targets[i].bits);
            assert_int_equal(used_bits(drawn.targets[i].format, alpha), targets[i].used_bits);
        }
    }
    assert_int_equal(fnl_mobile_layout_targets(FNL_MOBILE_LAYOUT_COUNT, NULL, 0), 0);
}

/* ---- inside the scope ---- */

static void test_the_picture_recycles_the_normals_MB_14(void **state) {
    UNUSED(state);
    struct stage stage = stage_open(MOBILE_SCENE, 0);
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
    struct stage stage = stage_open(MOBILE_SCENE, 0);
    for (int tonemap = 0; tonemap < FNL_TONEMAP_COUNT; tonemap++) {
        fnl_frame frame = mobile_frame(&stage);
        frame.tonemap = (fnl_tonemap)tonemap;
        frame.mobile.layout = (fnl_mobile_layout)tonemap;
        struct shot inside = stage_shoot(&stage, &frame);
        frame.outputs |= FNL_OUTPUT_RADIANCE;
        struct shot after = stage_shoot(&stage, &frame);
        assert_true(counter(&inside.stats, "mobile.tonemapped-inside") &&
                    !counter(&after.stats, "mobile.tonemapped-inside") && counter(&after.stats, "mobile.merged"));
        assert_int_equal(greatest_difference(&inside.color, &after.color), 0);
        shot_free(&inside);
        shot_free(&after);
    }
    stage_close(&stage);
}

/* Metering wants the whole frame first; the picture is that of deferred then, too. */
static void test_automatic_exposure_MB_15(void **state) {
    UNUSED(state);
    struct stage stage = stage_open(MOBILE_SCENE, 0);
    fnl_frame frame = mobile_frame(&stage);
    frame.exposure = FNL_EXPOSURE_AUTO;
    frame.mobile.light = FNL_MOBILE_LIGHT_UNORM; /* floats take over */
    struct shot mobile = stage_shoot(&stage, &frame);
    assert_true(counter(&mobile.stats, "mobile.merged") && !counter(&mobile.stats, "mobile.tonemapped-inside"));
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
    assert_int_equal(scene_load_plain(NULL, "builtin:glass?lights=48", NULL, &scene), FNL_OK);
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

/* Weighted sums have targets of their own in the scope; their mean goes over the light as the pass after it puts it over radiance. */
static void test_weighted_glass_inside_MB_16(void **state) {
    UNUSED(state);
    struct stage with = stage_open_scene(glass_scene(true)), without = stage_open_scene(glass_scene(false));
    for (int layout = 0; layout < FNL_MOBILE_LAYOUT_COUNT; layout++) {
        fnl_frame frame = mobile_frame(&with);
        frame.transparency = FNL_TRANSPARENCY_WEIGHTED;
        frame.mobile.layout = (fnl_mobile_layout)layout;
        frame.mobile.lights = layout & 1 ? FNL_MOBILE_LIGHTS_VOLUMES : FNL_MOBILE_LIGHTS_LISTS;
        struct shot inside = stage_shoot(&with, &frame), none = stage_shoot(&without, &frame);
        assert_true(counter(&inside.stats, "mobile.merged") && counter(&inside.stats, "mobile.tonemapped-inside"));
        assert_int_equal(inside.stats.image_bytes_written, 4ull * frame.width * frame.height);
        assert_int_equal(inside.stats.image_bytes_read, 0);
        assert_true(counter(&inside.stats, "transparency.bytes") >= 10ull * frame.width * frame.height);
        frame.mobile.separate = true;
        struct shot separate = stage_shoot(&with, &frame);
        assert_same(&inside.color, &separate.color, fnl_value_name(FNL_ENUM_MOBILE_LAYOUT, frame.mobile.layout));
        frame.mobile.separate = false;
        frame.light_lod =
            1e-3f; /* points for small lights, of which there are none: blended surfaces follow after the scope */
        struct shot after = stage_shoot(&with, &frame);
        assert_true(!counter(&after.stats, "mobile.tonemapped-inside"));
        frame.light_lod = 0;
        frame.shading = FNL_SHADING_FORWARD_PREPASS;
        struct shot forward = stage_shoot(&with, &frame), forward_none = stage_shoot(&without, &frame);
        frame.transparency = FNL_TRANSPARENCY_SORTED;
        struct shot sorted = stage_shoot(&with, &frame);
        uint64_t seen = 0, stray = 0;
        const uint8_t *fa = forward.color.pixels, *fb = forward_none.color.pixels, *a = inside.color.pixels,
                      *b = none.color.pixels;
        for (size_t i = 0; i < (size_t)frame.width * frame.height * 4; i += 4) {
            bool glass = memcmp(fa + i, fb + i, 3) != 0, changed = memcmp(a + i, b + i, 3) != 0;
            seen += glass && changed;
            stray += !glass && changed;
        }
        double off = mean_difference(&inside.color, &forward.color), wrong = mean_difference(&inside.color, &sorted.color);
        print_message("%s: %.3f/255 from forward weighted, %.3f from sorted; %d from weighted after the scope\n",
                      fnl_value_name(FNL_ENUM_MOBILE_LAYOUT, frame.mobile.layout), off, wrong,
                      greatest_difference(&inside.color, &after.color));
        assert_true(seen > 100 && stray < 5); /* of which forward may round away what six bits do not */
        assert_true(off < 1 && off < wrong);
        assert_true(mean_difference(&inside.color, &after.color) < 0.3);
        struct shot *all[] = {&inside, &none, &separate, &after, &forward, &forward_none, &sorted};
        for (uint32_t i = 0; i < COUNT_OF(all); i++) shot_free(all[i]);
    }
    stage_close(&with);
    stage_close(&without);
}

/* Other kinds of transparency, points for small lights and debug views go on from radiance, after the scope. */
static void test_what_does_not_fit_inside_follows_MB_16(void **state) {
    UNUSED(state);
    struct stage stage = stage_open(MOBILE_SCENE, 0);
    for (int variant = 0; variant < 3; variant++) {
        fnl_frame frame = mobile_frame(&stage);
        if (variant == 0) frame.transparency = FNL_TRANSPARENCY_LINKED;
        if (variant == 1) frame.light_lod = 3;
        if (variant == 2) frame.debug = FNL_DEBUG_LIGHTS;
        struct shot mobile = stage_shoot(&stage, &frame);
        assert_true(counter(&mobile.stats, "mobile.merged") && !counter(&mobile.stats, "mobile.tonemapped-inside"));
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

/* ---- without what it needs ---- */

static void test_without_inputs_the_passes_are_separate_MB_18(void **state) {
    UNUSED(state);
    struct stage stage = stage_open(MOBILE_SCENE, 0);
    fnl_frame frame = mobile_frame(&stage);
    struct shot merged = stage_shoot(&stage, &frame);
    assert_false(stage.renderer->notes.mobile[0] || stage.renderer->notes.mobile[1]);
    harness_hooks(stage.renderer)->cannot_merge = true;
    struct shot fallback = stage_shoot(&stage, &frame);
    assert_true(counter(&merged.stats, "mobile.merged") && !counter(&fallback.stats, "mobile.merged"));
    assert_true(!stage.renderer->notes.mobile[0] && stage.renderer->notes.mobile[1]); /* and it said so */
    assert_same(&merged.color, &fallback.color, "fallback");
    frame.msaa = 4;
    assert_int_equal(fnl_renderer_render(stage.renderer, &frame), FNL_ERROR_UNSUPPORTED);
    shot_free(&merged);
    shot_free(&fallback);
    stage_close(&stage);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_merged_and_separate_are_equal_MB_1, harness_check),
        cmocka_unit_test_teardown(test_odd_frames_MB_1, harness_check),
        cmocka_unit_test_teardown(test_every_list_leaves_the_same_bits_MB_1, harness_check),
        cmocka_unit_test_teardown(test_lights_as_volumes_MB_1_MB_2_MB_13, harness_check),
        cmocka_unit_test_teardown(test_only_the_picture_is_stored_MB_2_MB_3_ES_68, harness_check),
        cmocka_unit_test_teardown(test_time_and_bytes_of_a_frame_MB_17, harness_check),
        cmocka_unit_test_teardown(test_bits_of_the_layouts_MB_4, harness_check),
        cmocka_unit_test_teardown(test_the_picture_recycles_the_normals_MB_14, harness_check),
        cmocka_unit_test_teardown(test_tone_mapping_inside_equals_tone_mapping_after_MB_15, harness_check),
        cmocka_unit_test_teardown(test_automatic_exposure_MB_15, harness_check),
        cmocka_unit_test_teardown(test_glass_between_lights_and_tone_mapping_MB_16, harness_check),
        cmocka_unit_test_teardown(test_weighted_glass_inside_MB_16, harness_check),
        cmocka_unit_test_teardown(test_what_does_not_fit_inside_follows_MB_16, harness_check),
        cmocka_unit_test_teardown(test_light_beyond_the_accumulator_MB_13, harness_check),
        cmocka_unit_test_teardown(test_without_inputs_the_passes_are_separate_MB_18, harness_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
