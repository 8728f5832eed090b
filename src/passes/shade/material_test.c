/* SPDX-License-Identifier: MIT */
/** What glTF 2.0 says about materials, on pixels: a unit square fills the picture, a point of it is known in closed form. */
#include "render/device/scene.h"
#include "render/renderer_internal.h"
#include "shaders.h"
#include "tests/shade_reference.h"
#include "tests/render_test.h"

#define EXACT 2e-6

static uint32_t add_image(fnl_scene *scene, uint32_t width, uint32_t height, const uint8_t *pixels, bool color) {
    fnl_image image = {width, height, FNL_PIXEL_FORMAT_RGBA8, (void *)(uintptr_t)pixels};
    fnl_image_id id;
    assert_int_equal(fnl_scene_add_image(scene, &image, color, &id), FNL_OK);
    return id.index;
}

static uint32_t nearest_sampler(fnl_scene *scene, enum scene_wrap u, enum scene_wrap v) {
    struct scene_sampler sampler = {
        .mag = SCENE_FILTER_NEAREST, .min = SCENE_FILTER_NEAREST, .mip = SCENE_FILTER_NEAREST, .wrap_u = u, .wrap_v = v};
    return scene_add_sampler(scene, &sampler);
}

static struct scene_texture texture_of(fnl_scene *scene, uint32_t image) {
    struct scene_texture t = scene_texture_none();
    t.image = image;
    t.sampler = nearest_sampler(scene, SCENE_WRAP_REPEAT, SCENE_WRAP_REPEAT);
    return t;
}

static uint32_t place_square(fnl_scene *scene, const struct scene_material *material, vec3 position) {
    return test_place(scene, test_quad_mesh(scene, material ? scene_add_material(scene, material) : SCENE_NONE), position,
                      (vec3){1, 1, 1});
}

static fnl_image render_square(fnl_scene *scene, fnl_output output) {
    fnl_frame frame = test_frame((uint32_t)output);
    return test_render(scene, &frame, output);
}

static double srgb_decode(double c) { return c <= 0.04045 ? c / 12.92 : pow((c + 0.055) / 1.055, 2.4); }

static void add_front_light(fnl_scene *scene) {
    fnl_light_params light = fnl_light_params_default();
    light.kind = FNL_LIGHT_DIRECTIONAL;
    light.direction = (vec3){0.2f, -0.1f, -1};
    light.intensity = 2;
    fnl_light_id id;
    assert_int_equal(fnl_scene_add_light(scene, &light, &id), FNL_OK);
}

/* ---- alpha ---- */

static void test_cutout_holes(void **state) {
    UNUSED(state);
    fnl_scene *scene = test_scene();
    uint8_t texels[4 * 4 * 4];
    for (int i = 0; i < 16; i++) {
        static const uint8_t alphas[4] = {0, 127, 128, 255};
        texels[i * 4] = texels[i * 4 + 1] = texels[i * 4 + 2] = 255;
        texels[i * 4 + 3] = alphas[(i + i / 4) % 4];
    }
    struct scene_material leaf = test_unlit(1, 0.5f, 0);
    leaf.alpha_mode = FNL_ALPHA_MASK;
    leaf.alpha_cutoff = 128.0f / 255;
    leaf.textures[SCENE_TEXTURE_BASE_COLOR] = texture_of(scene, add_image(scene, 4, 4, texels, true));
    struct scene_material wall = test_unlit(0, 0.25f, 0.75f);
    place_square(scene, &leaf, (vec3){0, 0, 1});
    place_square(scene, &wall, (vec3){0, 0, 0});
    place_square(scene, &leaf, (vec3){0, 0, -1}); /* hidden: shaded by nobody who knows the depth */
    fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE | FNL_OUTPUT_POSITION);
    frame.count_lights = true;
    fnl_light_params light = test_point((vec3){0, 0, 3}, 1, 9);
    fnl_light_id id;
    assert_int_equal(fnl_scene_add_light(scene, &light, &id), FNL_OK);
    fnl_renderer *renderer = test_renderer(scene);
    for (uint32_t shading = 0; shading < FNL_SHADING_DEFERRED + 2; shading++) {
        frame.shading = shading < FNL_SHADING_DEFERRED + 1 ? (fnl_shading)shading : FNL_SHADING_DEFERRED;
        frame.gbuffer.prepass = shading == FNL_SHADING_DEFERRED + 1;
        test_render_frame(renderer, &frame);
        fnl_image radiance = test_read(renderer, FNL_OUTPUT_RADIANCE), position = test_read(renderer, FNL_OUTPUT_POSITION);
        for (uint32_t y = 0; y < 64; y++)
            for (uint32_t x = 0; x < 64; x++) {
                bool solid = texels[(y / 16 * 4 + x / 16) * 4 + 3] >= 128;
                assert_pixel(&radiance, x, y, solid ? 1 : 0, solid ? 0.5 : 0.25, solid ? 0 : 0.75, EXACT);
                assert_true((test_pixel(&position, x, y)[2] > 0.5f) == solid);
            }
        fnl_frame_stats stats;
        assert_int_equal(fnl_renderer_query_stats(renderer, &stats), FNL_OK);
        if (frame.shading != FNL_SHADING_FORWARD)
            assert_int_equal(stats.evaluations, 64 * 64); /* one shaded fragment a pixel */
        free_picture(&radiance);
        free_picture(&position);
    }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

static void test_alpha_modes(void **state) {
    UNUSED(state);
    /* alpha equal to the cutoff stays; OPAQUE ignores alpha; MASK keeps no translucency. */
    static const struct {
        fnl_alpha_mode mode;
        float alpha, cutoff;
        double expected;
    } cases[] = {{FNL_ALPHA_OPAQUE, 0.25f, 0.5f, 0.8}, {FNL_ALPHA_MASK, 0.5f, 0.5f, 0.8},
                 {FNL_ALPHA_MASK, 0.49f, 0.5f, 0.1},   {FNL_ALPHA_MASK, 0.75f, 0, 0.8},
                 {FNL_ALPHA_MASK, 1, 1.5f, 0.1},       {FNL_ALPHA_BLEND, 0.25f, 0.5f, 0.8 * 0.25 + 0.1 * 0.75},
                 {FNL_ALPHA_BLEND, 0, 0.5f, 0.1},      {FNL_ALPHA_BLEND, 1, 0.5f, 0.8}};
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        fnl_scene *scene = test_scene();
        assert_int_equal(fnl_scene_set_background(scene, (vec3){0.1f, 0.1f, 0.1f}), FNL_OK);
        struct scene_material material = test_unlit(0.8f, 0.8f, 0.8f);
        material.alpha_mode = cases[i].mode;
        material.base_color.w = cases[i].alpha;
        material.alpha_cutoff = cases[i].cutoff;
        place_square(scene, &material, (vec3){0, 0, 0});
        fnl_image radiance = render_square(scene, FNL_OUTPUT_RADIANCE);
        assert_pixel(&radiance, 9, 40, cases[i].expected, cases[i].expected, cases[i].expected, EXACT);
        free_picture(&radiance);
        fnl_scene_destroy(&scene);
    }
}

/* Three panes, added in a jumbled order, over a wall; one more behind it. Sizes differ, so that every stack appears. */
static void test_blend_order(void **state) {
    UNUSED(state);
    static const struct {
        float color[3], alpha, z, scale;
    } panes[4] = {{{0, 0, 1}, 0.5f, 1.0f, 0.8f},
                  {{1, 0, 0}, 0.25f, 3.0f, 0.3f},
                  {{9, 9, 9}, 0.9f, -1, 1},
                  {{0, 1, 0}, 0.75f, 2.0f, 0.5f}};
    fnl_scene *scene = test_scene();
    for (int i = 0; i < 4; i++) {
        struct scene_material pane = test_unlit(1, 1, 1);
        pane.unlit = false; /* emission is covered by alpha too */
        pane.base_color = (vec4){0, 0, 0, panes[i].alpha};
        pane.specular = 0;
        pane.metallic = 0;
        pane.emissive = (vec3){panes[i].color[0], panes[i].color[1], panes[i].color[2]};
        pane.alpha_mode = FNL_ALPHA_BLEND;
        pane.double_sided = i == 1;
        test_place(scene, test_quad_mesh(scene, scene_add_material(scene, &pane)), (vec3){0, 0, panes[i].z},
                   (vec3){panes[i].scale, panes[i].scale, 1});
    }
    struct scene_material wall = test_unlit(0.5f, 0.5f, 0.5f);
    place_square(scene, &wall, (vec3){0, 0, 0});
    fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE);
    fnl_renderer *renderer = test_renderer(scene);
    for (uint32_t shading = 0; shading < FNL_SHADING_DEFERRED + 1; shading++) {
        frame.shading = (fnl_shading)shading;
        test_render_frame(renderer, &frame);
        fnl_image radiance = test_read(renderer, FNL_OUTPUT_RADIANCE);
        for (uint32_t x = 0; x < 64; x++) {
            static const int order[3] = {0, 3, 1}; /* farthest first */
            double expected[3] = {0.5, 0.5, 0.5}, at = fabs((x + 0.5) / 32 - 1);
            for (int k = 0; k < 3; k++)
                if (at < panes[order[k]].scale)
                    for (int c = 0; c < 3; c++)
                        expected[c] += panes[order[k]].alpha * (panes[order[k]].color[c] - expected[c]);
            assert_pixel(&radiance, x, 32, expected[0], expected[1], expected[2], EXACT);
        }
        free_picture(&radiance);
    }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* ---- sides, mirrors, normal maps ---- */

static void test_sides(void **state) {
    UNUSED(state);
    for (int blend = 0; blend < 2; blend++)
        for (int mirrored = 0; mirrored < 2; mirrored++)
            for (int double_sided = 0; double_sided < 2; double_sided++)
                for (int back = 0; back < 2; back++) {
                    fnl_scene *scene = test_scene();
                    add_front_light(scene);
                    struct scene_material material = scene_material_default();
                    material.metallic = 0;
                    material.double_sided = double_sided;
                    material.alpha_mode = blend ? FNL_ALPHA_BLEND : FNL_ALPHA_OPAQUE;
                    mat4 turn = mat4_from_trs((vec3){0, 0, 0}, quat_axis_angle((vec3){0, 1, 0}, back ? PI : 0),
                                              (vec3){mirrored ? -1.0f : 1, 1, 1});
                    scene_add_node(scene, "", SCENE_NONE, &turn,
                                   test_quad_mesh(scene, scene_add_material(scene, &material)));
                    fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE | FNL_OUTPUT_NORMAL);
                    fnl_renderer *renderer = test_renderer(scene);
                    test_render_frame(renderer, &frame);
                    fnl_image radiance = test_read(renderer, FNL_OUTPUT_RADIANCE),
                              normal = test_read(renderer, FNL_OUTPUT_NORMAL);
                    bool visible = !back || double_sided;
                    if ((test_pixel(&radiance, 20, 20)[0] > 0.1f) != visible)
                        fail_msg("blend %d, mirrored %d, double-sided %d, back %d: wrong side", blend, mirrored,
                                 double_sided, back);
                    if (!blend && visible) assert_pixel(&normal, 20, 20, 0, 0, 1, 1e-4);
                    free_picture(&radiance);
                    free_picture(&normal);
                    fnl_renderer_destroy(&renderer);
                    fnl_scene_destroy(&scene);
                }
}

/* The mapped normal of the object, moved by each transform: scaled and mirrored, tangent frames stay right. */
static void test_normal_maps(void **state) {
    UNUSED(state);
    static const uint8_t texel[4] = {191, 96, 230, 255};
    static const struct {
        vec3 scale;
        float roll, normal_scale;
    } cases[] = {{{1, 1, 1}, 0, 1},   {{1, 1, 1}, 0, 0.5f},          {{1, 1, 1}, 0, 2},   {{1, 1, 1}, 0, -1},
                 {{3, 3, 3}, 0, 1},   {{0.2f, 0.2f, 0.2f}, 0.4f, 1}, {{-1, 1, 1}, 0, 1},  {{1, -1, 1}, 0, 1},
                 {{-1, -1, 1}, 0, 1}, {{-2, 2, 2}, 1.1f, 0.7f},      {{1, 1, 1}, 2.5f, 1}};
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        fnl_scene *scene = test_scene();
        struct scene_material material = scene_material_default();
        material.normal_scale = cases[i].normal_scale;
        material.textures[SCENE_TEXTURE_NORMAL] = texture_of(scene, add_image(scene, 1, 1, texel, false));
        mat4 matrix = mat4_from_trs((vec3){0, 0, 0}, quat_axis_angle((vec3){0, 0, 1}, cases[i].roll), cases[i].scale);
        scene_add_node(scene, "", SCENE_NONE, &matrix, test_quad_mesh(scene, scene_add_material(scene, &material)));
        fnl_image normal = render_square(scene, FNL_OUTPUT_NORMAL);
        /* The scale is even but for its signs, so tangent space moves like the object. */
        vec3 mapped = {((float)texel[0] / 255 * 2 - 1) * cases[i].normal_scale,
                       ((float)texel[1] / 255 * 2 - 1) * cases[i].normal_scale, (float)texel[2] / 255 * 2 - 1};
        vec3 expected = vec3_normalize(mat4_direction(&matrix, mapped));
        const float *n = test_pixel(&normal, 32, 32);
        if (fabsf(n[0] - expected.x) + fabsf(n[1] - expected.y) + fabsf(n[2] - expected.z) > 1e-3f)
            fail_msg("case %u: normal %g %g %g, expected %g %g %g", i, (double)n[0], (double)n[1], (double)n[2],
                     (double)expected.x, (double)expected.y, (double)expected.z);
        free_picture(&normal);
        fnl_scene_destroy(&scene);
    }
}

/* Normals follow the cofactor matrix under uneven scales. */
static void test_uneven_scale(void **state) {
    UNUSED(state);
    fnl_scene *scene = test_scene();
    struct scene_material material = scene_material_default();
    uint32_t mesh = test_sphere_mesh(scene, scene_add_material(scene, &material), 24);
    test_place(scene, mesh, (vec3){0, 0, 0}, (vec3){0.9f, -0.5f, 2});
    fnl_frame frame = test_frame(FNL_OUTPUT_NORMAL | FNL_OUTPUT_POSITION);
    fnl_renderer *renderer = test_renderer(scene);
    test_render_frame(renderer, &frame);
    fnl_image normal = test_read(renderer, FNL_OUTPUT_NORMAL), position = test_read(renderer, FNL_OUTPUT_POSITION);
    uint32_t covered = 0;
    for (uint32_t i = 0; i < 64 * 64; i++) {
        const float *p = (float *)position.pixels + i * 4, *n = (float *)normal.pixels + i * 4;
        if (p[3] == 0) continue;
        vec3 expected =
            vec3_normalize((vec3){p[0] / (0.9f * 0.9f), p[1] / (0.5f * 0.5f), p[2] / 4}); /* gradient of the ellipsoid */
        covered++;
        assert_true(vec3_dot(expected, (vec3){n[0], n[1], n[2]}) > 0.98f);
    }
    assert_true(covered > 1000);
    free_picture(&normal);
    free_picture(&position);
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* ---- textures ---- */

static int wrapped(int texel, int count, enum scene_wrap wrap) {
    if (wrap == SCENE_WRAP_CLAMP) return CLAMP(texel, 0, count - 1);
    int m = ((texel % (2 * count)) + 2 * count) % (2 * count);
    if (wrap == SCENE_WRAP_MIRROR) return m < count ? m : 2 * count - 1 - m;
    return m % count;
}

/* Wraps, transform and the second uv set: every pixel shows the texel that the formulas name. */
static void test_texture_coordinates(void **state) {
    UNUSED(state);
    uint8_t texels[4 * 2 * 4];
    for (int i = 0; i < 8; i++)
        memcpy(texels + i * 4, (uint8_t[4]){(uint8_t)(i * 30 + 10), (uint8_t)(250 - i * 30), 77, 255}, 4);
    static const float transforms[][6] = {
        {1, 0, 0, 0, 1, 0}, {3, 0, -1, 0, 3, -1}, {0.8f, 0.6f, 0.13f, -0.6f, 0.8f, 0.21f}, {2, 0, 0.5f, 0, -1.5f, 0.3f}};
    for (uint32_t k = 0; k < COUNT_OF(transforms); k++)
        for (int wrap = 0; wrap < 9; wrap++) {
            enum scene_wrap u_wrap = (enum scene_wrap)(wrap % 3), v_wrap = (enum scene_wrap)(wrap / 3);
            fnl_scene *scene = test_scene();
            struct scene_material material = test_unlit(1, 1, 1);
            struct scene_texture *t = &material.textures[SCENE_TEXTURE_BASE_COLOR];
            *t = scene_texture_none();
            t->image = add_image(scene, 4, 2, texels, true);
            t->sampler = nearest_sampler(scene, u_wrap, v_wrap);
            t->uv_set = wrap & 1;
            memcpy(t->transform, transforms[k], sizeof t->transform);
            static const vec3 positions[4] = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
            static const vec2 uv[4] = {{0, 1}, {1, 1}, {1, 0}, {0, 0}}, elsewhere[4] = {{7, 7}, {7, 7}, {7, 7}, {7, 7}};
            static const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
            struct scene_primitive p = {.material = scene_add_material(scene, &material),
                                        .vertex_count = 4,
                                        .index_count = 6,
                                        .indices = indices,
                                        .positions = positions,
                                        .uv = {t->uv_set ? elsewhere : uv, t->uv_set ? uv : elsewhere}};
            assert_int_equal(mesh_complete(&scene->arena, &p), FNL_OK);
            test_place(scene, scene_add_mesh(scene, "", &p, 1), (vec3){0, 0, 0}, (vec3){1, 1, 1});
            fnl_image radiance = render_square(scene, FNL_OUTPUT_RADIANCE);
            uint32_t compared = 0;
            for (uint32_t y = 0; y < 64; y += 3)
                for (uint32_t x = 0; x < 64; x += 3) {
                    const float *m = transforms[k];
                    double u0 = (x + 0.5) / 64, v0 = (y + 0.5) / 64, u = (m[0] * u0 + m[1] * v0 + m[2]) * 4,
                           v = (m[3] * u0 + m[4] * v0 + m[5]) * 2;
                    if (fabs(u - round(u)) < 1e-2 || fabs(v - round(v)) < 1e-2) continue; /* too near to the next texel */
                    const uint8_t *texel =
                        texels + (wrapped((int)floor(v), 2, v_wrap) * 4 + wrapped((int)floor(u), 4, u_wrap)) * 4;
                    assert_pixel(&radiance, x, y, srgb_decode(texel[0] / 255.0), srgb_decode(texel[1] / 255.0),
                                 srgb_decode(77 / 255.0), 2e-3);
                    compared++;
                }
            assert_true(compared > 200);
            free_picture(&radiance);
            fnl_scene_destroy(&scene);
        }
}

static void test_vertex_colors(void **state) {
    UNUSED(state);
    fnl_scene *scene = test_scene();
    fnl_material_params params = fnl_material_params_default();
    params.unlit = true;
    params.base_color[1] = 0.5f;
    static const float positions[] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0},
                       colors[] = {0, 0, 1, 1, 1, 0, 1, 1, 1, 1, 1, 1, 0, 1, 1, 1};
    static const uint32_t indices[] = {0, 1, 2, 0, 2, 3};
    fnl_mesh_params mesh_params = {.vertex_count = 4,
                                   .index_count = 6,
                                   .positions = positions,
                                   .colors = colors,
                                   .indices = indices,
                                   .material = test_material(scene, &params)};
    fnl_mesh_id mesh;
    fnl_instance_id instance;
    mat4 identity = mat4_identity();
    assert_int_equal(fnl_scene_add_mesh(scene, &mesh_params, &mesh), FNL_OK);
    assert_int_equal(fnl_scene_add_instance(scene, mesh, &identity, &instance), FNL_OK);
    fnl_image radiance = render_square(scene, FNL_OUTPUT_RADIANCE);
    for (uint32_t i = 1; i < 64; i += 9)
        assert_pixel(&radiance, i, i / 2, (i + 0.5) / 64, (1 - (i / 2 + 0.5) / 64) * 0.5, 1, 1e-4);
    free_picture(&radiance);
    fnl_scene_destroy(&scene);
}

/* ---- light and emission ---- */

/* All texture channels at once, against the reference that is given the products. */
static void test_texture_channels(void **state) {
    UNUSED(state);
    static const uint8_t base[4] = {200, 100, 50, 255}, rough[4] = {9, 128, 200, 9}, occlusion[4] = {64, 9, 9, 9},
                         emissive[4] = {20, 188, 90, 9};
    static const uint8_t specular[4] = {9, 9, 9, 120}, specular_color[4] = {255, 128, 30, 9};
    fnl_scene *scene = test_scene();
    struct scene_material m = scene_material_default();
    m.base_color = (vec4){0.9f, 0.8f, 0.7f, 1};
    m.metallic = 0.5f;
    m.roughness = 0.9f;
    m.occlusion_strength = 0.6f;
    m.emissive = (vec3){1, 2, 3};
    m.specular = 0.75f;
    m.specular_color = (vec3){1, 0.9f, 2};
    m.ior = 1.8f;
    m.textures[SCENE_TEXTURE_BASE_COLOR] = texture_of(scene, add_image(scene, 1, 1, base, true));
    m.textures[SCENE_TEXTURE_METALLIC_ROUGHNESS] = texture_of(scene, add_image(scene, 1, 1, rough, false));
    m.textures[SCENE_TEXTURE_OCCLUSION] = texture_of(scene, add_image(scene, 1, 1, occlusion, false));
    m.textures[SCENE_TEXTURE_EMISSIVE] = texture_of(scene, add_image(scene, 1, 1, emissive, true));
    m.textures[SCENE_TEXTURE_SPECULAR] = texture_of(scene, add_image(scene, 1, 1, specular, false));
    m.textures[SCENE_TEXTURE_SPECULAR_COLOR] = texture_of(scene, add_image(scene, 1, 1, specular_color, true));
    place_square(scene, &m, (vec3){0, 0, 0});
    add_front_light(scene);
    fnl_light_params light;
    assert_int_equal(fnl_scene_query_light(scene, 0, &light), FNL_OK);
    fnl_vec3 sky = {0.4f, 0.5f, 0.6f}, ground = {0.3f, 0.1f, 0.2f};
    assert_int_equal(fnl_scene_set_ambient(scene, sky, ground), FNL_OK);

    struct reference_surface s = reference_surface_default();
    const double tints[3] = {1, 0.9, 2}, factors[3] = {0.9, 0.8, 0.7};
    for (int c = 0; c < 3; c++) {
        s.base_color[c] = factors[c] * srgb_decode(base[c] / 255.0);
        s.emissive[c] = (c + 1) * srgb_decode(emissive[c] / 255.0);
        s.specular_color[c] = tints[c] * srgb_decode(specular_color[c] / 255.0);
    }
    s.metallic = 0.5 * rough[2] / 255;
    s.roughness = 0.9 * rough[1] / 255;
    s.occlusion = 1 + 0.6 * (occlusion[0] / 255.0 - 1);
    s.specular = 0.75 * specular[3] / 255;
    s.ior = 1.8;
    double to_view[3] = {0, 0, 1}, expected[3];
    reference_shade(&s, to_view, &light, 1, sky, ground, expected);
    fnl_image radiance = render_square(scene, FNL_OUTPUT_RADIANCE);
    /* Drivers may decode sRGB a little differently: up to a per cent, as llvmpipe approximates the curve. */
    for (int c = 0; c < 3; c++) {
        double value = test_pixel(&radiance, 30, 30)[c];
        if (fabs(value - expected[c]) >= 1e-2 * expected[c])
            fail_msg("channel %d is %g, reference %g", c, value, expected[c]);
    }
    free_picture(&radiance);

    /* Deferred keeps all of it to the bits of its G-buffer. */
    fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE);
    frame.shading = FNL_SHADING_DEFERRED;
    radiance = test_render(scene, &frame, FNL_OUTPUT_RADIANCE);
    for (int c = 0; c < 3; c++) {
        double value = test_pixel(&radiance, 30, 30)[c];
        if (fabs(value - expected[c]) >= 1.5e-2 * expected[c])
            fail_msg("deferred: channel %d is %g, reference %g", c, value, expected[c]);
    }
    free_picture(&radiance);
    fnl_scene_destroy(&scene);
}

static void test_occlusion_dims_only_ambient(void **state) {
    UNUSED(state);
    static const uint8_t black[4] = {0, 0, 0, 255};
    fnl_image pictures[3];
    for (int i = 0; i < 3; i++) { /* direct light alone; with an ambient that is wholly occluded; with it half occluded */
        fnl_scene *scene = test_scene();
        add_front_light(scene);
        struct scene_material m = scene_material_default();
        m.metallic = 0;
        m.textures[SCENE_TEXTURE_OCCLUSION] = texture_of(scene, add_image(scene, 1, 1, black, false));
        m.occlusion_strength = i == 2 ? 0.5f : 1;
        place_square(scene, &m, (vec3){0, 0, 0});
        if (i > 0) assert_int_equal(fnl_scene_set_ambient(scene, (vec3){1, 1, 1}, (vec3){1, 1, 1}), FNL_OK);
        pictures[i] = render_square(scene, FNL_OUTPUT_RADIANCE);
        fnl_scene_destroy(&scene);
    }
    assert_true(test_pixel(&pictures[0], 8, 8)[0] > 0.1f);
    assert_true(test_equal(&pictures[0], &pictures[1]));
    assert_true(test_pixel(&pictures[2], 8, 8)[0] > test_pixel(&pictures[0], 8, 8)[0] + 0.3f);
    for (int i = 0; i < 3; i++) free_picture(&pictures[i]);
}

/* ---- how often textures are sampled ---- */

static void test_shaders_sample_each_texture_once(void **state) {
    UNUSED(state);
    enum { EVEN_GLASS = GPU_TEXTURE_COUNT + GPU_LAYER_TEXTURE_COUNT, ALL = EVEN_GLASS - 2 }; /* but transmission and thickness */
    static const struct {
        const struct gpu_shader *shader;
        uint32_t textures; /* that it looks at */
    } drawing[] = {{&shader_gbuffer_frag, GPU_TEXTURE_COUNT + 4}, /* and those of clearcoat and anisotropy, for the layout that holds them */
                   {&shader_forward_frag, ALL},
                   {&shader_forward_early_frag, ALL},
                   {&shader_light_prepass_surfaces_frag, GPU_TEXTURE_COUNT - 2}, /* no occlusion, no emission */
                   {&shader_light_prepass_material_frag, GPU_TEXTURE_COUNT},
                   {&shader_inferred_surfaces_frag, GPU_TEXTURE_COUNT - 2},
                   {&shader_inferred_material_frag, GPU_TEXTURE_COUNT},
                   {&shader_zioma_frag, ALL},
                   {&shader_batches_frag, ALL},
                   {&shader_multipass_frag, ALL},
                   {&shader_transmission_frag, EVEN_GLASS},
                   {&shader_mobile_gbuffer_metallic_128_frag, GPU_TEXTURE_COUNT},
                   {&shader_coarse_gbuffer_z_frag, GPU_TEXTURE_COUNT + 1}}; /* and the base colour of a block */
    for (uint32_t i = 0; i < COUNT_OF(drawing); i++) {
        uint32_t count = test_count_operations(drawing[i].shader, 87, 87); /* OpImageSampleImplicitLod */
        if (count != drawing[i].textures)
            fail_msg("%s samples %u times, expected %u", drawing[i].shader->name, count, drawing[i].textures);
    }
}

/* Where occlusion comes from: a picture of its own; that of roughness, but sampled in another way; the very texels of roughness. */
enum occlusion_case { OCCLUSION_OWN, OCCLUSION_SAMPLER, OCCLUSION_UV, OCCLUSION_TRANSFORM, OCCLUSION_SHARED, OCCLUSION_CASES };

static fnl_scene *occluded_scene(enum occlusion_case which, bool copied) {
    uint8_t texels[4 * 4 * 4];
    for (int i = 0; i < 64; i++) texels[i] = (uint8_t)(i * 37 + i / 4 * 11);
    fnl_scene *scene = test_scene();
    add_front_light(scene);
    assert_int_equal(fnl_scene_set_ambient(scene, (vec3){1, 2, 3}, (vec3){1, 2, 3}), FNL_OK);
    struct scene_material m = scene_material_default();
    struct scene_texture *rough = &m.textures[SCENE_TEXTURE_METALLIC_ROUGHNESS], *occlusion = &m.textures[SCENE_TEXTURE_OCCLUSION];
    *occlusion = *rough = texture_of(scene, add_image(scene, 4, 4, texels, false));
    if (which == OCCLUSION_OWN)
        for (int i = 0; i < 64; i++) texels[i] = (uint8_t)(255 - texels[i]);
    if (which == OCCLUSION_OWN || copied) occlusion->image = add_image(scene, 4, 4, texels, false);
    if (which == OCCLUSION_SAMPLER) {
        rough->sampler = nearest_sampler(scene, SCENE_WRAP_CLAMP, SCENE_WRAP_CLAMP);
        rough->transform[0] = occlusion->transform[0] = 3;
    }
    if (which == OCCLUSION_UV) occlusion->uv_set = 1;
    if (which == OCCLUSION_TRANSFORM) occlusion->transform[5] = 0.25f;
    static const vec3 positions[4] = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
    static const vec2 uv[4] = {{0, 1}, {1, 1}, {1, 0}, {0, 0}}, turned[4] = {{0, 0}, {0, 1}, {1, 1}, {1, 0}};
    static const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
    struct scene_primitive p = {.material = scene_add_material(scene, &m),
                                .vertex_count = 4,
                                .index_count = 6,
                                .indices = indices,
                                .positions = positions,
                                .uv = {uv, turned}};
    assert_int_equal(mesh_complete(&scene->arena, &p), FNL_OK);
    test_place(scene, scene_add_mesh(scene, "", &p, 1), (vec3){0, 0, 0}, (vec3){1, 1, 1});
    return scene;
}

static void test_shared_occlusion_is_sampled_once(void **state) {
    UNUSED(state);
    static const fnl_shading paths[] = {FNL_SHADING_FORWARD, FNL_SHADING_DEFERRED, FNL_SHADING_VISIBILITY};
    for (uint32_t which = 0; which < OCCLUSION_CASES; which++) {
        fnl_image pictures[2][COUNT_OF(paths)];
        for (int copied = 0; copied < 2; copied++) { /* a copy of the picture is a texture of its own, sampled by itself */
            fnl_scene *scene = occluded_scene((enum occlusion_case)which, copied);
            fnl_renderer *renderer = test_renderer(scene);
            for (uint32_t k = 0; k < COUNT_OF(paths); k++) {
                fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE);
                frame.shading = paths[k];
                test_render_frame(renderer, &frame);
                pictures[copied][k] = test_read(renderer, FNL_OUTPUT_RADIANCE);
            }
            const struct gpu_material *sent = (const void *)renderer->device_scene->materials.sent.data;
            bool shared = sent[0].flags & GPU_MATERIAL_SHARED_OCCLUSION;
            assert_int_equal(shared, which == OCCLUSION_SHARED && !copied);
            fnl_renderer_destroy(&renderer);
            fnl_scene_destroy(&scene);
        }
        for (uint32_t k = 0; k < COUNT_OF(paths); k++) {
            if (!test_equal(&pictures[0][k], &pictures[1][k])) fail_msg("case %u, path %u: a copy of the picture looks different", which, k);
            for (int i = 0; i < 2; i++) free_picture(&pictures[i][k]);
        }
    }
}

static void test_unlit_and_emission(void **state) {
    UNUSED(state);
    for (uint32_t shading = 0; shading < FNL_SHADING_DEFERRED + 1; shading++) {
        fnl_scene *scene = test_scene();
        add_front_light(scene);
        assert_int_equal(fnl_scene_set_ambient(scene, (vec3){1, 1, 1}, (vec3){1, 1, 1}), FNL_OK);
        struct scene_material unlit = test_unlit(0.3f, 0.6f, 0.9f);
        unlit.emissive = (vec3){5, 5, 5}; /* KHR_materials_unlit: nothing but the base colour counts */
        struct scene_material lamp = scene_material_default();
        lamp.base_color = (vec4){0, 0, 0, 1};
        lamp.metallic = lamp.specular = 0;
        lamp.emissive = (vec3){1000, 2e5f, 0.25f};
        uint32_t a = test_quad_mesh(scene, scene_add_material(scene, &unlit)),
                 b = test_quad_mesh(scene, scene_add_material(scene, &lamp));
        test_place(scene, a, (vec3){-0.5f, 0, 0}, (vec3){0.5f, 1, 1});
        test_place(scene, b, (vec3){0.5f, 0, 0}, (vec3){0.5f, 1, 1});
        fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE);
        frame.shading = (fnl_shading)shading;
        fnl_image radiance = test_render(scene, &frame, FNL_OUTPUT_RADIANCE);
        assert_pixel(&radiance, 10, 32, 0.3, 0.6, 0.9, EXACT);
        const float *p = test_pixel(&radiance, 50, 32);
        assert_true(p[0] == 1000 && p[1] == 2e5f && p[2] == 0.25f); /* as it was given: no clamp to 16 bits */
        free_picture(&radiance);
        fnl_scene_destroy(&scene);
    }
}

static void test_default_material(void **state) {
    UNUSED(state);
    fnl_scene *scene = test_scene();
    place_square(scene, NULL, (vec3){0, 0, 0});
    fnl_image surface = render_square(scene, FNL_OUTPUT_SURFACE);
    const float *p = test_pixel(&surface, 1, 1);
    assert_true(p[0] == 1 && p[1] == 1 && p[2] == 1 && p[3] == 1);
    free_picture(&surface);
    fnl_scene_destroy(&scene);
}

/* ---- points and lines ---- */

static void test_points_and_lines(void **state) {
    UNUSED(state);
    static const vec3 positions[] = {{-0.984375f, -0.484375f, 0}, {0.984375f, -0.484375f, 0}, {0.515625f, 0.515625f, 0}};
    static const uint32_t line[] = {0, 1}, point[] = {2};
    for (uint32_t shading = 0; shading < FNL_SHADING_DEFERRED + 1; shading++)
        for (int blend = 0; blend < 2; blend++) {
            fnl_scene *scene = test_scene();
            struct scene_material material = test_unlit(0.25f, 1, 0.5f);
            material.alpha_mode = blend ? FNL_ALPHA_BLEND : FNL_ALPHA_OPAQUE;
            material.base_color.w = blend ? 0.5f : 1;
            double a = blend ? 0.5 : 1;
            struct scene_primitive primitives[2] = {{.material = scene_add_material(scene, &material),
                                                     .topology = SCENE_TOPOLOGY_LINES,
                                                     .vertex_count = 3,
                                                     .index_count = 2,
                                                     .indices = line,
                                                     .positions = positions},
                                                    {.material = 0,
                                                     .topology = SCENE_TOPOLOGY_POINTS,
                                                     .vertex_count = 3,
                                                     .index_count = 1,
                                                     .indices = point,
                                                     .positions = positions}};
            test_place(scene, scene_add_mesh(scene, "", primitives, 2), (vec3){0, 0, 0}, (vec3){1, 1, 1});
            fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE);
            frame.shading = (fnl_shading)shading;
            fnl_image radiance = test_render(scene, &frame, FNL_OUTPUT_RADIANCE);
            uint32_t lit = 0;
            for (uint32_t i = 0; i < 64 * 64; i++) lit += ((float *)radiance.pixels)[i * 4] > 0;
            assert_in_range(lit, 62, 66);
            for (uint32_t x = 2; x < 62; x++) assert_pixel(&radiance, x, 47, 0.25 * a, a, 0.5 * a, EXACT);
            assert_pixel(&radiance, 48, 15, 0.25 * a, a, 0.5 * a, EXACT);
            free_picture(&radiance);
            fnl_scene_destroy(&scene);
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        {"ES-4b, ES-4e: objects show through the holes of cutouts, in every order", test_cutout_holes, NULL, NULL, NULL},
        cmocka_unit_test(test_alpha_modes),
        cmocka_unit_test(test_blend_order),
        cmocka_unit_test(test_sides),
        cmocka_unit_test(test_normal_maps),
        cmocka_unit_test(test_uneven_scale),
        cmocka_unit_test(test_texture_coordinates),
        cmocka_unit_test(test_vertex_colors),
        cmocka_unit_test(test_texture_channels),
        cmocka_unit_test(test_occlusion_dims_only_ambient),
        cmocka_unit_test(test_shaders_sample_each_texture_once),
        cmocka_unit_test(test_shared_occlusion_is_sampled_once),
        cmocka_unit_test(test_unlit_and_emission),
        cmocka_unit_test(test_default_material),
        cmocka_unit_test(test_points_and_lines),
    };
    return cmocka_run_group_tests_name("materials", tests, test_group_begin, test_group_end);
}
