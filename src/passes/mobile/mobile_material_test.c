/* SPDX-License-Identifier: MIT */
/** What the layouts of the order mobile make of materials: workflows, furnace, lobe, halos, gamma. */
#include "tests/mobile_cases.h"
#include "tests/shade_reference.h"

/* ---- materials ---- */

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
    struct stage stage = edited_stage("builtin:spheres?lights=60", make_pure);
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
            struct stage stage = edited_stage("builtin:spheres?lights=0", make_white);
            assert_int_equal(fnl_scene_set_background(stage.scene, (vec3){1, 1, 1}), FNL_OK);
            assert_int_equal(fnl_scene_set_ambient(stage.scene, (vec3){1, 1, 1}, (vec3){1, 1, 1}), FNL_OK);
            fnl_frame frame = mobile_frame(&stage);
            frame.width = 81;
            frame.height = 45;
            frame.mobile.layout = FNL_MOBILE_METALLIC_256;
            frame.energy = FNL_ENERGY_CONSERVING;
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
            assert_true(ambient <= 1.01f && mean <= 1.01 && suns <= 1.2f);
            if (roughness >= 2) assert_true(mean > 0.9);
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

static fnl_frame border_frame(const struct stage *stage) {
    fnl_frame frame = mobile_frame(stage);
    frame.width = frame.height = 128;
    frame.camera = fnl_camera_default();
    frame.camera.position = (vec3){0, 0, 5};
    frame.camera.target = (vec3){0, 0, 0};
    frame.camera.orthographic = true;
    frame.camera.vertical_extent = 1.6f;
    frame.camera.far_distance = 20;
    return frame;
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
        fnl_frame frame = border_frame(&stage);
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

/* Red by as much as the halo shines; metal is blue, paint grey. In every order, and with the picture's debug view alone. */
static void test_the_view_of_halos_MB_6(void **state) {
    UNUSED(state);
    static const fnl_shading orders[] = {FNL_SHADING_MOBILE, FNL_SHADING_FORWARD};
    for (uint32_t grown = 0; grown <= 2; grown += 2)
        for (uint32_t order = 0; order < COUNT_OF(orders); order++) {
            fnl_scene *scene = painted_metal();
            assert_int_equal(fnl_scene_grow_metal(scene, grown), FNL_OK);
            struct stage stage = stage_open_scene(scene);
            fnl_frame frame = border_frame(&stage);
            frame.shading = orders[order];
            frame.debug = FNL_DEBUG_HALOS;
            struct shot shot = stage_shoot(&stage, &frame);
            const uint8_t *row = (const uint8_t *)shot.color.pixels + 4 * (size_t)64 * 128;
            int reddest = 0, flagged = 0;
            for (int x = 0; x < 128; x++) {
                const uint8_t *p = row + 4 * x;
                bool red = p[0] > 2 * p[2] + 8;
                flagged += red;
                if (red) reddest = MAX(reddest, p[0]);
            }
            const uint8_t *paint = row + 4 * 24, *metal = row + 4 * 104;
            print_message("%s, grown by %u: %d pixels are flagged, the reddest %d\n", fnl_value_name(FNL_ENUM_SHADING, frame.shading), grown,
                          flagged, reddest);
            assert_true(paint[0] == paint[1] && paint[1] == paint[2]);
            assert_true(metal[2] > metal[0] + 50);
            assert_true(flagged > 4 && flagged < 20); /* eight of ten parts of a texel, which is 10 pixels wide */
            assert_true(grown ? reddest < 130 : reddest > 200);
            shot_free(&shot);
            stage_close(&stage);
        }
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
        struct stage stage = edited_stage("builtin:wall?lights=0", make_lobe);
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
                      fnl_value_name(FNL_ENUM_MOBILE_GAMMA, (fnl_mobile_gamma)gamma), worst[gamma], dark_step[gamma]);
        assert_true(worst[gamma] < 0.0047 && dark_step[gamma] < 0.0012); /* plain bytes: steps of 0.0039 */
    }
    /* And so do the shaders: a lit wall is as bright as the grey that eight bits make of it, to what the light's floats keep. */
    for (int i = 0; i < 6; i++) {
        furnace_metallic = (float)(0.004 + 0.16 * i);
        struct stage stage = edited_stage("builtin:spheres?lights=0", make_grey);
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
                fail_msg("%s, %g: %g instead of %g", fnl_value_name(FNL_ENUM_MOBILE_GAMMA, (fnl_mobile_gamma)gamma), value, kept / sum,
                         expected);
            shot_free(&shot);
        }
        shot_free(&exact);
        stage_close(&stage);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_metallic_and_specular_layouts_agree_MB_5, harness_check),
        cmocka_unit_test_teardown(test_white_furnace_MB_7, harness_check),
        cmocka_unit_test_teardown(test_metal_that_reaches_farther_has_no_halo_MB_6, harness_check),
        cmocka_unit_test_teardown(test_the_view_of_halos_MB_6, harness_check),
        cmocka_unit_test_teardown(test_the_lobe_is_the_references_MB_8, harness_check),
        cmocka_unit_test_teardown(test_gamma_of_colours_MB_11, harness_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
