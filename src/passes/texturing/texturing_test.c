/* SPDX-License-Identifier: MIT */
/** Deferred texturing with bindless textures: what its targets hold, and surfaces of every kind. Whole scenes: texturing_scenes_test.c. */
#include "passes/texturing/texturing.h"
#include "tests/render_test.h"
#include "shaders.h"

/* ---- pictures ---- */

static fnl_frame wide_frame(void) {
    fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE | FNL_OUTPUT_COLOR);
    frame.width = 131;
    frame.height = 77;
    frame.camera = fnl_camera_default();
    frame.camera.position = (vec3){0.3f, 0.4f, 5};
    frame.camera.target = (vec3){0, 0, 0};
    return frame;
}

/* Of texturing against forward; `out_bytes`: of a pixel of the G-buffer. */
static double psnr_against_forward(fnl_scene *scene, fnl_frame frame, fnl_shading shading, uint32_t *out_bytes) {
    fnl_renderer *renderer = test_renderer(scene);
    fnl_image colors[2];
    fnl_frame_stats stats;
    for (int k = 0; k < 2; k++) {
        frame.shading = k ? shading : FNL_SHADING_FORWARD;
        test_render_frame(renderer, &frame);
        colors[k] = test_read(renderer, FNL_OUTPUT_COLOR);
        assert_int_equal(fnl_renderer_query_stats(renderer, &stats), FNL_OK);
    }
    *out_bytes = (uint32_t)(counter(&stats, "gbuffer.bytes") / (frame.width * frame.height));
    fnl_image_difference difference;
    assert_int_equal(fnl_image_compare(NULL, &colors[0], &colors[1], &difference), FNL_OK);
    uint32_t lit = 0;
    for (uint32_t y = 0; y < frame.height; y++)
        for (uint32_t x = 0; x < frame.width; x++) lit += test_pixel8(&colors[0], x, y)[1] > 8;
    assert_true(lit > 2000);
    for (int k = 0; k < 2; k++) free_picture(&colors[k]);
    fnl_renderer_destroy(&renderer);
    return difference.psnr;
}

/* ---- surfaces of every kind ---- */

static fnl_image_id pattern(fnl_scene *scene, uint32_t side, uint32_t seed, bool color) {
    uint8_t *texels = malloc(side * side * 4);
    assert_non_null(texels);
    struct random_state random = {seed};
    uint8_t tint[4] = {(uint8_t)(60 + seed * 37 % 190), (uint8_t)(60 + seed * 91 % 190), (uint8_t)(60 + seed * 53 % 190),
                       255};
    for (uint32_t i = 0; i < side * side; i++) {
        bool dark = ((i % side / (side / 4)) ^ (i / side / (side / 4))) & 1;
        for (uint32_t k = 0; k < 4; k++) texels[i * 4 + k] = (uint8_t)(dark ? tint[k] / 3 : tint[k]);
        if (!color) { /* a normal map */
            texels[i * 4] = (uint8_t)random_range(&random, 90, 165);
            texels[i * 4 + 1] = (uint8_t)random_range(&random, 90, 165);
            texels[i * 4 + 2] = 240;
        }
        texels[i * 4 + 3] = dark ? 60 : 255;
    }
    fnl_image image = {side, side, FNL_PIXEL_FORMAT_RGBA8, texels};
    fnl_image_id id;
    assert_int_equal(fnl_scene_add_image(scene, &image, color, &id), FNL_OK);
    free(texels);
    return id;
}

enum { WITH_UV1 = 1, WITH_COLORS = 2, WITH_DECALS = 4, WITH_MESH_DECALS = 8, WITH_LIKE_NORMALS = 16 };

static uint32_t sphere(fnl_scene *scene, const struct scene_material *material, uint32_t kinds) {
    uint32_t mesh = test_sphere_mesh(scene, scene_add_material(scene, material), 8);
    struct scene_primitive *p = &scene->primitives.data[scene->meshes.data[mesh].first_primitive];
    vec2 *uv1 = ARENA_ARRAY(&scene->arena, vec2, p->vertex_count);
    vec4 *colors = ARENA_ARRAY(&scene->arena, vec4, p->vertex_count);
    for (uint32_t v = 0; v < p->vertex_count; v++) {
        uv1[v] = (vec2){p->positions[v].x * 0.9f, p->positions[v].y * 0.7f + 100};
        colors[v] = (vec4){0.5f + 0.5f * p->positions[v].x, 0.7f, 0.5f - 0.5f * p->positions[v].z, 1};
    }
    if (kinds & WITH_UV1) p->uv[1] = uv1;
    if (kinds & WITH_COLORS) p->colors = colors;
    return mesh;
}

/* Spheres and squares: tiled far beyond 1, turned and shifted, clamped and mirrored; normal maps on mirrored instances; cut out, seen from both
 * sides, unlit. */
static fnl_scene *variety(uint32_t kinds) {
    fnl_scene *scene = test_scene();
    assert_int_equal(fnl_scene_set_anisotropy(scene, 1), FNL_OK);
    struct scene_sampler sampler = {.mag = SCENE_FILTER_LINEAR,
                                    .min = SCENE_FILTER_LINEAR,
                                    .mip = SCENE_FILTER_LINEAR,
                                    .mipmapped = true,
                                    .wrap_u = SCENE_WRAP_MIRROR,
                                    .wrap_v = SCENE_WRAP_CLAMP};
    uint32_t clamped = scene_add_sampler(scene, &sampler);
    sampler.wrap_v = sampler.wrap_u = SCENE_WRAP_REPEAT;
    uint32_t repeated = scene_add_sampler(scene, &sampler);
    uint32_t color = pattern(scene, 128, 1, true).index, normal = pattern(scene, 64, 2, false).index;
    fnl_instance_id first = {0};
    for (uint32_t i = 0; i < 6; i++) {
        struct scene_material m = scene_material_default();
        m.roughness = 0.6f;
        m.metallic = 0;
        m.textures[SCENE_TEXTURE_BASE_COLOR] =
            (struct scene_texture){color,
                                   i == 2 ? clamped : repeated,
                                   i == 1 && kinds & WITH_UV1,
                                   {i == 0 ? 1 : 2.37f, 0.3f, i == 3 ? 1000.5f : -0.7f, i == 4 ? 0.1f : -0.3f, 1.7f, 0.1f}};
        if (i != 2) m.textures[SCENE_TEXTURE_NORMAL] = (struct scene_texture){normal, repeated, 0, {4, 0, 0, 0, 4, 0}};
        if (i != 2 && kinds & WITH_LIKE_NORMALS) {
            m.textures[SCENE_TEXTURE_NORMAL] = m.textures[SCENE_TEXTURE_BASE_COLOR];
            m.textures[SCENE_TEXTURE_NORMAL].image = normal;
        }
        m.double_sided = i == 3;
        m.unlit = i == 4;
        m.alpha_mode = i == 3 ? FNL_ALPHA_MASK : FNL_ALPHA_OPAQUE;
        m.alpha_cutoff = 0.5f;
        vec3 scale = {i % 2 ? -0.8f : 0.8f, 0.8f, i == 5 ? 0.3f : 0.8f};
        uint32_t node =
            test_place(scene, i == 0 ? test_quad_mesh(scene, scene_add_material(scene, &m)) : sphere(scene, &m, kinds),
                       (vec3){(float)(i % 3) * 2 - 2, (float)(i / 3) * 1.8f - 0.9f, 0}, scale);
        if (i == 4) first = (fnl_instance_id){node, scene->nodes.data[node].generation};
    }
    fnl_light_params light = test_point((vec3){2, 3, 5}, 60, 40);
    fnl_light_id id;
    assert_int_equal(fnl_scene_add_light(scene, &light, &id), FNL_OK);
    assert_int_equal(fnl_scene_set_ambient(scene, (vec3){0.5f, 0.5f, 0.5f}, (vec3){0.2f, 0.2f, 0.2f}), FNL_OK);
    scene_update_transforms(scene);
    if (kinds & (WITH_DECALS | WITH_MESH_DECALS)) {
        fnl_decal_params p = fnl_decal_params_default();
        p.color_image = pattern(scene, 64, 9, true);
        p.color[1] = 0.1f;
        fnl_decal_id decal;
        if (kinds & WITH_DECALS) {
            mat4 box = mat4_from_trs((vec3){1, 0, 0.4f}, quat_identity(), (vec3){3, 2, 2});
            p.transform = box;
            assert_int_equal(fnl_scene_add_decal(scene, &p, &decal), FNL_OK);
        }
        if (kinds & WITH_MESH_DECALS) {
            p.kind = FNL_DECAL_MESH;
            p.instance = first;
            p.transform = mat4_from_trs((vec3){0, 0.1f, 0.8f}, quat_identity(), (vec3){1.2f, 1.2f, 1});
            assert_int_equal(fnl_scene_add_decal(scene, &p, &decal), FNL_OK);
        }
    }
    return scene;
}

static void test_every_kind_of_surface(void **state) {
    UNUSED(state);
    static const struct {
        uint32_t kinds, stored, derived; /* bytes of a pixel; 0: not tried */
    } cases[] = {
        {0, 30, 22},          {WITH_UV1, 46, 0},         {WITH_COLORS, 38, 0},
        {WITH_DECALS, 30, 0}, {WITH_MESH_DECALS, 54, 0}, {WITH_UV1 | WITH_COLORS | WITH_DECALS | WITH_MESH_DECALS, 78, 62}};
    for (uint32_t i = 0; i < COUNT_OF(cases); i++)
        for (int derived = 0; derived < (cases[i].derived ? 2 : 1); derived++) {
            fnl_scene *scene = variety(cases[i].kinds);
            fnl_frame frame = wide_frame();
            frame.texturing.gradients = derived ? FNL_GRADIENTS_DERIVED : FNL_GRADIENTS_STORED;
            uint32_t bytes;
            double psnr = psnr_against_forward(scene, frame, FNL_SHADING_TEXTURING, &bytes);
            print_message("kinds %u, %s: %.1f dB, %u bytes a pixel\n", cases[i].kinds, fnl_value_name(FNL_ENUM_GRADIENTS, frame.texturing.gradients),
                          psnr, bytes);
            assert_int_equal(bytes, derived ? cases[i].derived : cases[i].stored);
            assert_true(psnr > (derived ? 38 : 58));
            fnl_scene_destroy(&scene);
        }
}

/* ---- derived gradients ---- */

/* `side` black and white squares of a texel along either edge: grey from the second level on. */
static fnl_image_id chequers(fnl_scene *scene, uint32_t side) {
    uint8_t *texels = malloc((size_t)side * side * 4);
    assert_non_null(texels);
    for (uint32_t i = 0; i < side * side; i++) {
        memset(texels + 4 * (size_t)i, ((i % side) ^ (i / side)) & 1 ? 255 : 0, 3);
        texels[4 * (size_t)i + 3] = 255;
    }
    fnl_image image = {side, side, FNL_PIXEL_FORMAT_RGBA8, texels};
    fnl_image_id id;
    assert_int_equal(fnl_scene_add_image(scene, &image, false, &id), FNL_OK);
    free(texels);
    return id;
}

/* A rectangle at depth z with u = `u0` + `slope` * x and v = 0.5 * y. */
static void add_strip(fnl_scene *scene, uint32_t material, float x0, float x1, float z, float u0, float slope) {
    vec3 *positions = ARENA_ARRAY(&scene->arena, vec3, 4);
    vec2 *uv = ARENA_ARRAY(&scene->arena, vec2, 4);
    uint32_t *indices = ARENA_ARRAY(&scene->arena, uint32_t, 6);
    const uint32_t order[6] = {0, 1, 2, 1, 3, 2};
    memcpy(indices, order, sizeof order);
    for (uint32_t v = 0; v < 4; v++) {
        positions[v] = (vec3){v & 1 ? x1 : x0, v & 2 ? 1.2f : -1.2f, z};
        uv[v] = (vec2){u0 + slope * positions[v].x, 0.5f * positions[v].y};
    }
    struct scene_primitive p = {.material = material,
                                .vertex_count = 4,
                                .index_count = 6,
                                .indices = indices,
                                .positions = positions,
                                .uv = {uv, NULL}};
    assert_int_equal(mesh_complete(&scene->arena, &p), FNL_OK);
    test_place(scene, scene_add_mesh(scene, "", &p, 1), (vec3){0, 0, 0}, (vec3){1, 1, 1});
}

/*
 * Where two charts of one material meet, the gradient is that of the neighbour on the pixel's own chart; where another surface of the same
 * material has the coordinates of the neighbour, none is taken from there. A texture of single black and white texels shows each wrong
 * level: sharp where it should be grey, or grey where it should be sharp. Seen without perspective, gradients are the same all over a
 * strip, and so are those that hardware takes: every pixel is compared with stored gradients.
 */
static void test_derived_at_seams(void **state) {
    UNUSED(state);
    enum { SIDE = 64, PIXELS = 64 };
    static const struct {
        const char *name;
        bool two_materials;
        float z, u0, slope; /* of the right strip */
        float left;         /* slope of the left one; its pixels are at middles of texels */
    } cases[] = {
        /* A texel a pixel on both sides; u jumps by many texels at the seam. */
        {"charts in one plane", false, 0, 20.3f, 0.5f, 0.5f},
        /* Four texels a pixel along u on both sides, the same u at the pixels beside the border: of another plane. */
        {"a step", false, -0.5f, 1.0f / 128 - 1.0f / 16, 2, 2},
        /* The same in one plane, of another material. */
        {"two materials", true, 0, 1.0f / 128 - 1.0f / 16, 2, 2},
    };
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        fnl_scene *scene = test_scene();
        assert_int_equal(fnl_scene_set_anisotropy(scene, 1), FNL_OK);
        struct scene_sampler sampler = {.mag = SCENE_FILTER_LINEAR,
                                        .min = SCENE_FILTER_LINEAR,
                                        .mip = SCENE_FILTER_LINEAR,
                                        .mipmapped = true,
                                        .wrap_u = SCENE_WRAP_REPEAT,
                                        .wrap_v = SCENE_WRAP_REPEAT};
        struct scene_material material = test_unlit(1, 1, 1);
        material.textures[SCENE_TEXTURE_BASE_COLOR] = scene_texture_none();
        material.textures[SCENE_TEXTURE_BASE_COLOR].image = chequers(scene, SIDE).index;
        material.textures[SCENE_TEXTURE_BASE_COLOR].sampler = scene_add_sampler(scene, &sampler);
        uint32_t left = scene_add_material(scene, &material),
                 right = cases[i].two_materials ? scene_add_material(scene, &material) : left;
        add_strip(scene, left, -1.2f, 0.01f, 0, cases[i].left < 1 ? 0 : 1.0f / 128, cases[i].left);
        add_strip(scene, right, 0.01f, 1.2f, cases[i].z, cases[i].u0, cases[i].slope);
        scene_update_transforms(scene);
        fnl_renderer *renderer = test_renderer(scene);
        fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE);
        frame.width = frame.height = PIXELS;
        frame.shading = FNL_SHADING_TEXTURING;
        fnl_image shown[2];
        for (int derived = 0; derived < 2; derived++) {
            frame.texturing.gradients = derived ? FNL_GRADIENTS_DERIVED : FNL_GRADIENTS_STORED;
            test_render_frame(renderer, &frame);
            shown[derived] = test_read(renderer, FNL_OUTPUT_RADIANCE);
        }
        double low = 1e9, high = 0;
        uint32_t off = 0;
        for (uint32_t y = 0; y < PIXELS; y++)
            for (uint32_t x = 0; x < PIXELS; x++) {
                double stored = (double)test_pixel(&shown[0], x, y)[0], derived = (double)test_pixel(&shown[1], x, y)[0];
                low = fmin(low, stored);
                high = fmax(high, stored);
                off += !(fabs(stored - derived) <= 0.02);
            }
        print_message("%s: %.2f .. %.2f, %u pixels off\n", cases[i].name, low, high, off);
        if (cases[i].left < 1)
            assert_true(high - low > 0.3); /* sharp */
        else
            assert_true(high - low < 0.1); /* grey */
        assert_int_equal(off, 0);
        for (int k = 0; k < 2; k++) free_picture(&shown[k]);
        fnl_renderer_destroy(&renderer);
        fnl_scene_destroy(&scene);
    }
}

/* With an atlas: the textures of each material have the same coordinates, as it demands. */
static void test_every_kind_by_the_atlas(void **state) {
    UNUSED(state);
    static const uint32_t cases[][2] = {{0, 12},
                                        {WITH_UV1, 12},
                                        {WITH_COLORS, 20},
                                        {WITH_DECALS, 14},
                                        {WITH_UV1 | WITH_COLORS | WITH_DECALS | WITH_MESH_DECALS, 46}};
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        fnl_scene *scene = variety(cases[i][0] | WITH_LIKE_NORMALS);
        uint32_t bytes;
        double psnr = psnr_against_forward(scene, wide_frame(), FNL_SHADING_VIRTUAL_TEXTURING, &bytes);
        print_message("kinds %u: %.1f dB, %u bytes a pixel\n", cases[i][0], psnr, bytes);
        assert_int_equal(bytes, cases[i][1]);
        assert_true(psnr > 38);
        fnl_scene_destroy(&scene);
    }
}

/* 4 samples: each has all that one has, in formats that devices have samples of. */
static void test_every_kind_with_samples(void **state) {
    UNUSED(state);
    static const struct {
        uint32_t kinds, bytes, paged; /* bytes of a sample */
    } cases[] = {{0, 32, 16}, {WITH_UV1, 48, 16}, {WITH_UV1 | WITH_COLORS | WITH_DECALS | WITH_MESH_DECALS, 80, 48}};
    for (uint32_t i = 0; i < COUNT_OF(cases); i++)
        for (int paged = 0; paged < 2; paged++) {
            fnl_scene *scene = variety(cases[i].kinds | (paged ? WITH_LIKE_NORMALS : 0));
            fnl_frame frame = wide_frame();
            frame.msaa = 4;
            uint32_t bytes;
            double psnr =
                psnr_against_forward(scene, frame, paged ? FNL_SHADING_VIRTUAL_TEXTURING : FNL_SHADING_TEXTURING, &bytes);
            print_message("kinds %u, %s, 4 samples: %.1f dB, %u bytes a pixel\n", cases[i].kinds,
                          paged ? "by the atlas" : "stored", psnr, bytes);
            assert_int_equal(bytes, 4 * (paged ? cases[i].paged : cases[i].bytes));
            assert_true(psnr > (paged ? 36 : 41));
            fnl_scene_destroy(&scene);
        }
    fnl_scene *scene = variety(WITH_UV1 | WITH_COLORS | WITH_DECALS | WITH_MESH_DECALS);
    fnl_frame frame = wide_frame();
    frame.msaa = 4;
    frame.texturing.gradients = FNL_GRADIENTS_DERIVED;
    uint32_t bytes;
    double psnr = psnr_against_forward(scene, frame, FNL_SHADING_TEXTURING, &bytes);
    print_message("derived, 4 samples: %.1f dB, %u bytes a pixel\n", psnr, bytes);
    assert_int_equal(bytes, 4 * 64);
    assert_true(psnr > 36);
    fnl_scene_destroy(&scene);
}

static void test_thousand_textures(void **state) {
    UNUSED(state);
    enum { ACROSS = 40, DOWN = 25 };
    fnl_scene *scene = test_scene();
    for (uint32_t i = 0; i < ACROSS * DOWN; i++) {
        struct scene_material m = test_unlit(1, 1, 1);
        m.textures[SCENE_TEXTURE_BASE_COLOR] = scene_texture_none();
        m.textures[SCENE_TEXTURE_BASE_COLOR].image = pattern(scene, 16, i, true).index;
        m.textures[SCENE_TEXTURE_BASE_COLOR].sampler = 0;
        test_place(scene, test_quad_mesh(scene, scene_add_material(scene, &m)),
                   (vec3){((float)(i % ACROSS) + 0.5f) / ACROSS * 2 - 1, ((float)(i / ACROSS) + 0.5f) / DOWN * 2 - 1, 0},
                   (vec3){0.9f / ACROSS, 0.9f / DOWN, 1});
    }
    assert_int_equal(fnl_scene_set_anisotropy(scene, 1), FNL_OK);
    fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE | FNL_OUTPUT_COLOR);
    frame.width = frame.height = 200;
    uint32_t bytes;
    double psnr = psnr_against_forward(scene, frame, FNL_SHADING_TEXTURING, &bytes);
    print_message("1000 textures: %.1f dB\n", psnr);
    assert_true(psnr > 48); /* what drivers make of explicit gradients: the visibility buffer gives as much */
    psnr = psnr_against_forward(scene, frame, FNL_SHADING_VIRTUAL_TEXTURING, &bytes);
    print_message("by the atlas: %.1f dB\n", psnr);
    assert_true(psnr > 34);
    fnl_scene_destroy(&scene);
}

/* ---- odd textures ---- */

static fnl_image_id odd_pattern(fnl_scene *scene, uint32_t width, uint32_t height, uint32_t seed) {
    uint8_t *texels = malloc((size_t)width * height * 4);
    assert_non_null(texels);
    for (uint32_t i = 0; i < width * height; i++) {
        double x = (i % width + 0.5) / width, y = (i / width + 0.5) / height;
        double wave = 0.5 + 0.25 * sin(2 * M_PI * (2 * x + seed)) + 0.25 * sin(2 * M_PI * (3 * y + 0.3));
        for (uint32_t k = 0; k < 3; k++) texels[i * 4 + k] = (uint8_t)(40 + 180 * wave * (k == seed % 3 ? 1 : 0.4));
        texels[i * 4 + 3] = 255;
    }
    fnl_image image = {width, height, FNL_PIXEL_FORMAT_RGBA8, texels};
    fnl_image_id id;
    assert_int_equal(fnl_scene_add_image(scene, &image, true, &id), FNL_OK);
    free(texels);
    return id;
}

/* Sizes that are no powers of two, 1x1, strips; a thousand tiles; no coordinates; no texture; every wrap. */
static void test_odd_textures(void **state) {
    UNUSED(state);
    static const struct {
        uint32_t width, height; /* 0: no texture */
        float scale, shift;
        enum scene_wrap wrap;
        bool bare; /* no coordinates */
    } cases[] = {{1, 1, 1, 0, SCENE_WRAP_REPEAT, false},         {3, 5, 1, 0, SCENE_WRAP_CLAMP, false},
                 {257, 63, 2, 0.25f, SCENE_WRAP_REPEAT, false},  {640, 1, 1, 0, SCENE_WRAP_MIRROR, false},
                 {130, 250, 3, -1.5f, SCENE_WRAP_MIRROR, false}, {100, 60, 2, -0.5f, SCENE_WRAP_CLAMP, false},
                 {33, 17, 1000, 0, SCENE_WRAP_REPEAT, false},    {64, 64, 1, 999.5f, SCENE_WRAP_REPEAT, false},
                 {64, 64, 1, -4000, SCENE_WRAP_MIRROR, false},   {48, 48, 1, 0, SCENE_WRAP_REPEAT, true},
                 {0, 0, 1, 0, SCENE_WRAP_REPEAT, false},         {0, 0, 1, 0, SCENE_WRAP_REPEAT, true}};
    fnl_scene *scene = test_scene();
    assert_int_equal(fnl_scene_set_anisotropy(scene, 1), FNL_OK);
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        struct scene_material m = test_unlit(1, 1, 1);
        if (cases[i].width) {
            struct scene_sampler sampler = {SCENE_FILTER_LINEAR, SCENE_FILTER_LINEAR, SCENE_FILTER_LINEAR, true,
                                            cases[i].wrap,       cases[i].wrap};
            struct scene_texture *t = &m.textures[SCENE_TEXTURE_BASE_COLOR];
            *t = scene_texture_none();
            t->image = odd_pattern(scene, cases[i].width, cases[i].height, i).index;
            t->sampler = scene_add_sampler(scene, &sampler);
            const float transform[6] = {cases[i].scale, 0, cases[i].shift, 0, cases[i].scale, cases[i].shift};
            memcpy(t->transform, transform, sizeof transform);
        }
        uint32_t mesh = test_quad_mesh(scene, scene_add_material(scene, &m));
        if (cases[i].bare) scene->primitives.data[scene->meshes.data[mesh].first_primitive].uv[0] = NULL;
        test_place(scene, mesh, (vec3){(float)(i % 4) * 0.5f - 0.75f, (float)(i / 4) * 0.6f - 0.6f, 0},
                   (vec3){0.23f, 0.28f, 1});
    }
    fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE | FNL_OUTPUT_COLOR);
    frame.width = frame.height = 151;
    fnl_renderer *renderer = test_renderer(scene);
    for (uint32_t k = 0; k < 4; k++) {
        fnl_image colors[2];
        for (int order = 0; order < 2; order++) {
            frame.msaa = k < 2 ? 1 : 4;
            frame.shading = !order ? FNL_SHADING_FORWARD : k & 1 ? FNL_SHADING_VIRTUAL_TEXTURING : FNL_SHADING_TEXTURING;
            test_render_frame(renderer, &frame);
            colors[order] = test_read(renderer, FNL_OUTPUT_COLOR);
        }
        for (uint32_t i = 0; i < COUNT_OF(cases); i++) { /* each square but for its rim */
            double sum = 0;
            uint32_t count = 0, x0 = (uint32_t)(((float)(i % 4) * 0.5f + 0.06f) * 75.5f),
                     y0 = (uint32_t)((1.36f - (float)(i / 4) * 0.6f) * 75.5f);
            for (uint32_t y = y0; y < y0 + 36; y++)
                for (uint32_t x = x0; x < x0 + 28; x++)
                    for (int c = 0; c < 3; c++, count++) {
                        double d = (double)test_pixel8(&colors[0], x, y)[c] - (double)test_pixel8(&colors[1], x, y)[c];
                        sum += d * d;
                    }
            double rms = sqrt(sum / count);
            /* Where coordinates are clamped along one axis, the other alone tells the atlas' level: 100x60 gets more detail. */
            if (rms > (k & 1 ? 6 : 3))
                fail_msg("%s, %u samples, case %u: off by %.2f of 255", fnl_value_name(FNL_ENUM_SHADING, frame.shading), frame.msaa, i, rms);
        }
        for (int order = 0; order < 2; order++) free_picture(&colors[order]);
    }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* ---- the first pass ---- */

/* OpImageSampleImplicitLod .. OpImageRead */
static uint32_t count_image_reads(const struct gpu_shader *shader) { return test_count_operations(shader, 87, 98); }

static void test_first_pass_reads_alpha_alone(void **state) {
    UNUSED(state);
    assert_int_equal(count_image_reads(&shader_texturing_frag), 0);
    assert_int_equal(count_image_reads(&shader_texturing_mask_frag), 1);
    assert_true(count_image_reads(&shader_texturing_shade_comp) > 7);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        {"ES-76: surfaces of every kind as in forward shading", test_every_kind_of_surface, NULL, NULL, NULL},
        {"ES-76: derived gradients are those of the own chart", test_derived_at_seams, NULL, NULL, NULL},
        {"ES-70: surfaces of every kind by the atlas", test_every_kind_by_the_atlas, NULL, NULL, NULL},
        {"ES-76, ES-70: surfaces of every kind with 4 samples", test_every_kind_with_samples, NULL, NULL, NULL},
        {"ES-76: 1000 textures", test_thousand_textures, NULL, NULL, NULL},
        {"ES-76, ES-70: odd textures, wraps and coordinates", test_odd_textures, NULL, NULL, NULL},
        {"ES-76, ES-79: the first pass reads no texture but the alpha of cutouts", test_first_pass_reads_alpha_alone, NULL,
         NULL, NULL}};
    return cmocka_run_group_tests(tests, test_group_begin, test_group_end);
}
