/* SPDX-License-Identifier: MIT */
/**
 * Whole scenes by deferred attribute interpolation against forward shading. Textures are filtered without anisotropy, as drivers place its
 * samples in their own ways. At edges of pixels with several samples a triangle is shaded in the middle of the samples that show it, forward
 * where the driver chooses: only PSNR is asked for there.
 */
#include "passes/dais/dais_shared.h"
#include "tests/render_harness.h"

struct scene_case {
    const char *source;
    uint32_t scattered;
    float ev;
    double time; /* of the first animation; below 0: at rest */
};

static void open_case(const struct scene_case *c, struct stage *stage) {
    *stage = stage_open(c->source, c->scattered);
    assert_int_equal(fnl_scene_set_anisotropy(stage->scene, 1), FNL_OK);
    if (c->time >= 0) assert_int_equal(fnl_scene_set_time(stage->scene, 0, c->time), FNL_OK);
    stage->frame.ev = c->ev;
    stage->frame.lists = FNL_LISTS_CLUSTERED;
}

static void test_scene(void **state) {
    const struct scene_case *c = *state;
    struct stage stage;
    open_case(c, &stage);
    fnl_frame frame = stage.frame;
    frame.count_lights = true;
    frame.shading = FNL_SHADING_FORWARD_PREPASS;
    struct shot forward = stage_shoot(&stage, &frame);
    frame.shading = FNL_SHADING_DAIS;
    struct shot dais = stage_shoot(&stage, &frame);
    assert_int_equal(count_broken(&dais.radiance), 0);
    fnl_image_difference difference;
    assert_int_equal(fnl_image_compare(NULL, &forward.color, &dais.color, &difference), FNL_OK);
    uint64_t beyond = count_beyond(&forward.color, &dais.color, 2);
    print_message("%s: %.1f dB, %llu pixels beyond 2/255, %d/255 at most; %u triangles, %u different\n", c->source,
                  difference.psnr, (unsigned long long)beyond, greatest_difference(&forward.color, &dais.color),
                  (uint32_t)counter(&dais.stats, "dais.triangles"), (uint32_t)counter(&dais.stats, "dais.unique"));
    assert_true(beyond * 500 <= frame.width * frame.height);
    assert_true(difference.psnr >= 56);
    /* DI-4: hardly a triangle twice. */
    assert_true(counter(&dais.stats, "dais.unique") > 0 &&
                counter(&dais.stats, "dais.triangles") <= counter(&dais.stats, "dais.unique") * 1.02 + 8);
    assert_int_equal(counter(&dais.stats, "dais.overflow"), 0);
    shot_free(&forward);
    shot_free(&dais);
    stage_close(&stage);
}

/* DI-3: against deferred shading and forward shading at all sample counts. */
static void test_samples(void **state) {
    UNUSED(state);
    static const struct scene_case cases[] = {{"builtin:hall?lights=24", 0, 5, -1}, {"FlightHelmet/FlightHelmet.gltf", 12, 5, -1}};
    /* With one sample and more, from forward and from deferred shading; the helmet's normal map is fine, and its edges are many. */
    static const double least[COUNT_OF(cases)][2][2] = {{{72, 66}, {58, 63}}, {{63, 62}, {42, 45}}};
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        struct stage stage;
        open_case(&cases[i], &stage);
        stage.frame.width = 128;
        stage.frame.height = 72;
        for (uint32_t samples = 1; samples <= 8; samples *= 2) {
            fnl_device_info info;
            fnl_device_query_info(harness_device(), &info);
            if (!(info.msaa_counts & samples)) {
                print_message("  %u samples: not on this device\n", samples);
                continue;
            }
            fnl_frame frame = stage.frame;
            frame.msaa = samples;
            static const fnl_shading orders[] = {FNL_SHADING_DAIS, FNL_SHADING_FORWARD_PREPASS, FNL_SHADING_DEFERRED};
            struct shot shots[COUNT_OF(orders)];
            double psnr[COUNT_OF(orders)];
            for (uint32_t k = 0; k < COUNT_OF(orders); k++) {
                frame.shading = orders[k];
                shots[k] = stage_shoot(&stage, &frame);
                fnl_image_difference difference;
                assert_int_equal(fnl_image_compare(NULL, &shots[0].color, &shots[k].color, &difference), FNL_OK);
                psnr[k] = difference.psnr;
            }
            print_message("  %s, %u samples: %.1f dB from forward, %.1f dB from deferred\n", cases[i].source, samples, psnr[1],
                          psnr[2]);
            assert_true(psnr[1] >= least[i][samples > 1][0]);
            assert_true(psnr[2] >= least[i][samples > 1][1]);
            for (uint32_t k = 0; k < COUNT_OF(orders); k++) shot_free(&shots[k]);
        }
        stage_close(&stage);
    }
}

/*
 * Holes are in the prepass alone: as where each fragment looks at its alpha, with several samples too. A leaf shades where it is seen, so with
 * one sample a pixel lights are visited as often as by forward shading behind the same prepass.
 */
static void test_holes(void **state) {
    UNUSED(state);
    static const struct scene_case cases[] = {{"builtin:grass?lights=6", 0, 5, -1},
                                              {"builtin:city?lights=12", 0, 1, -1},
                                              {"builtin:hall?lights=6", 0, 5, -1},
                                              {"materials/AlphaBlendModeTest.glb", 6, 5, -1}};
    static const double least[COUNT_OF(cases)] = {42, 32, 42, 42}; /* with samples; the city's far leaves are all edge */
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        struct stage stage;
        open_case(&cases[i], &stage);
        for (uint32_t samples = 1; samples <= 4; samples *= 4) {
            fnl_frame frame = stage.frame;
            frame.msaa = samples;
            frame.count_lights = samples == 1;
            frame.width = 161; /* the decibels above are of this size */
            frame.height = 91;
            frame.shading = FNL_SHADING_FORWARD_PREPASS;
            struct shot forward = stage_shoot(&stage, &frame);
            frame.shading = FNL_SHADING_DAIS;
            struct shot dais = stage_shoot(&stage, &frame);
            fnl_image_difference difference;
            assert_int_equal(fnl_image_compare(NULL, &forward.color, &dais.color, &difference), FNL_OK);
            print_message("  %s, %u samples: %.1f dB, %llu evaluations, forward %llu\n", cases[i].source, samples, difference.psnr,
                          (unsigned long long)dais.stats.evaluations, (unsigned long long)forward.stats.evaluations);
            assert_true(difference.psnr >= (samples == 1 ? 56 : least[i]));
            /* Triangles that meet at equal depth are shaded twice by forward shading, or once. */
            long long more = (long long)(dais.stats.evaluations - forward.stats.evaluations);
            assert_true(llabs(more) * 500 <= (long long)forward.stats.evaluations);
            shot_free(&forward);
            shot_free(&dais);
        }
        stage_close(&stage);
    }
}

/* However finely what is not seen is left out: the same picture, to the bit, of the same triangles; with decals and with what others hide. */
static void test_culling(void **state) {
    UNUSED(state);
    struct stage stage;
    open_case(&(struct scene_case){"builtin:hall?lights=12&decals=200", 0, 5, -1}, &stage);
    fnl_frame frame = stage.frame;
    frame.width = 129;
    frame.height = 73;
    frame.shading = FNL_SHADING_FORWARD_PREPASS;
    struct shot forward = stage_shoot(&stage, &frame);
    frame.shading = FNL_SHADING_DAIS;
    struct shot plain = {0};
    for (uint32_t i = 0; i < 12; i++) {
        frame.culling = (fnl_culling)(i % 3);
        frame.occlusion = i / 3 & 1;
        frame.dais.mode = (fnl_dais_mode)(i / 6);
        struct shot first = stage_shoot(&stage, &frame), dais = stage_shoot(&stage, &frame); /* the second knows what the first has seen */
        if (i == 0) {
            plain = dais;
            shot_free(&first);
            fnl_image_difference difference;
            assert_int_equal(fnl_image_compare(NULL, &forward.color, &dais.color, &difference), FNL_OK);
            print_message("  %.1f dB; %u triangles\n", difference.psnr, (uint32_t)counter(&dais.stats, "dais.triangles"));
            assert_true(difference.psnr >= 56 && counter(&dais.stats, "decals.in-view") > 10);
            continue;
        }
        assert_int_equal(count_differing(&plain.radiance, &first.radiance), 0);
        assert_int_equal(count_differing(&plain.radiance, &dais.radiance), 0);
        assert_int_equal(counter(&dais.stats, "dais.triangles"), counter(&plain.stats, "dais.triangles"));
        if (frame.culling != FNL_CULLING_INSTANCES)
            assert_true(dais.stats.triangles_drawn > 0 && dais.stats.triangles_drawn < dais.stats.triangles_total);
        shot_free(&first);
        shot_free(&dais);
    }
    shot_free(&plain);
    shot_free(&forward);
    stage_close(&stage);
}

/* A renderer that goes from one size, sample count, mode and view to another gives what a new one would; poses move in between. */
static void test_changes(void **state) {
    UNUSED(state);
    static const struct {
        uint32_t width, height, msaa;
        fnl_dais_mode mode;
        bool multirate, orthographic;
        double time;
    } steps[] = {{97, 55, 1, FNL_DAIS_TARGET, false, false, 0.1}, {33, 17, 4, FNL_DAIS_LIST, true, false, 0.3},
                 {131, 79, 4, FNL_DAIS_TARGET, true, true, 0.5},  {64, 1, 1, FNL_DAIS_LIST, false, false, 0.7},
                 {1, 1, 4, FNL_DAIS_TARGET, false, false, 0.9},   {97, 55, 1, FNL_DAIS_TARGET, false, false, 0.1}};
    struct stage stage;
    struct shot begin = {0};
    open_case(&(struct scene_case){"Fox.glb", 9, 5, 0}, &stage);
    for (uint32_t i = 0; i < COUNT_OF(steps); i++) {
        fnl_frame frame = stage.frame;
        frame.shading = FNL_SHADING_DAIS;
        frame.width = steps[i].width;
        frame.height = steps[i].height;
        frame.msaa = steps[i].msaa;
        frame.dais.mode = steps[i].mode;
        frame.dais.multirate = steps[i].multirate;
        if (steps[i].orthographic) {
            frame.camera.orthographic = true;
            frame.camera.vertical_extent = 120;
        }
        assert_int_equal(fnl_scene_set_time(stage.scene, 0, steps[i].time), FNL_OK);
        struct shot shot = stage_shoot(&stage, &frame);
        struct stage fresh;
        open_case(&(struct scene_case){"Fox.glb", 9, 5, steps[i].time}, &fresh);
        struct shot other = stage_shoot(&fresh, &frame);
        stage_close(&fresh);
        assert_int_equal(count_differing(&shot.radiance, &other.radiance), 0);
        assert_int_equal(count_broken(&shot.radiance), 0);
        shot_free(&other);
        if (i == 0) {
            begin = shot;
            continue;
        }
        if (i + 1 == COUNT_OF(steps)) assert_int_equal(count_differing(&begin.radiance, &shot.radiance), 0);
        shot_free(&shot);
    }
    shot_free(&begin);
    stage_close(&stage);
}

int main(void) {
    static struct scene_case cases[] = {{"FlightHelmet/FlightHelmet.gltf", 40, 5, -1},
                                        {"DamagedHelmet.glb", 40, 5, -1},
                                        {"Fox.glb", 40, 5, 0.4},
                                        {"CesiumMan.glb", 40, 5, 0.7},
                                        {"builtin:hall?lights=64", 0, 5, -1},
                                        {"builtin:interior?lights=40", 0, 5, -1},
                                        {"builtin:city?lights=64&instances=20000", 0, 1, -1},
                                        {"builtin:grass?lights=24", 0, 5, -1},
                                        {"builtin:glass?lights=24", 0, 5, -1},
                                        {"builtin:hall?lights=0", 0, 5, -1},
                                        {"builtin:sky?lights=30", 0, 5, -1}};
    struct CMUnitTest tests[COUNT_OF(cases) + 4];
    char names[COUNT_OF(cases)][96];
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        bool cutouts = strstr(cases[i].source, "grass");
        snprintf(names[i], sizeof names[i], "DI-2%s: %s as in forward shading", cutouts ? ", DI-8" : "", cases[i].source);
        tests[i] = (struct CMUnitTest){names[i], test_scene, NULL, harness_check, &cases[i]};
    }
    tests[COUNT_OF(cases)] =
        (struct CMUnitTest){"DI-3: close to deferred shading at all sample counts", test_samples, NULL, harness_check, NULL};
    tests[COUNT_OF(cases) + 1] = (struct CMUnitTest){"DI-8: holes as fragments cut them", test_holes, NULL, harness_check, NULL};
    tests[COUNT_OF(cases) + 2] =
        (struct CMUnitTest){"clusters, triangles and what is hidden left out; decals", test_culling, NULL, harness_check, NULL};
    tests[COUNT_OF(cases) + 3] =
        (struct CMUnitTest){"other sizes, samples, modes, views and poses", test_changes, NULL, harness_check, NULL};
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
