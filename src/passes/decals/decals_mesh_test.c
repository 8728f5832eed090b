/* SPDX-License-Identifier: MIT */
/** Decals that belong to meshes: on what moves and deforms, as triangles drawn again, baked into textures. */
#include "tests/render_test.h"

#include "tests/decals_cases.h"

/* A strip of two quads on two joints. Its decal is at its middle before it deforms. */
static fnl_scene *strip_scene(uint32_t *out_node, uint32_t joints[2]) {
    fnl_scene *scene = test_scene();
    static const vec3 positions[6] = {{-1, -0.5f, 0}, {0, -0.5f, 0}, {1, -0.5f, 0},
                                      {-1, 0.5f, 0},  {0, 0.5f, 0},  {1, 0.5f, 0}};
    static const uint32_t indices[12] = {0, 1, 4, 0, 4, 3, 1, 2, 5, 1, 5, 4};
    static const uint16_t influences[24] = {0, 0, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0};
    static const float weights[24] = {1, 0, 0, 0, 0.5f, 0.5f, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0.5f, 0.5f, 0, 0, 1, 0, 0, 0};
    struct scene_primitive strip = {.material = add_grey(scene),
                                    .vertex_count = 6,
                                    .index_count = 12,
                                    .indices = indices,
                                    .positions = positions,
                                    .joints = influences,
                                    .weights = weights,
                                    .joint_count = 4};
    assert_int_equal(mesh_complete(&scene->arena, &strip), FNL_OK);
    uint32_t mesh = scene_add_mesh(scene, "", &strip, 1);
    mat4 identity = mat4_identity();
    *out_node = scene_add_node(scene, "", SCENE_NONE, &identity, mesh);
    uint32_t *list = ARENA_ARRAY(&scene->arena, uint32_t, 2);
    mat4 *inverse_bind = ARENA_ARRAY(&scene->arena, mat4, 2);
    for (int i = 0; i < 2; i++) {
        list[i] = joints[i] = scene_add_node(scene, "", SCENE_NONE, &identity, SCENE_NONE);
        inverse_bind[i] = identity;
    }
    struct scene_skin skin = {.name = "", .joints = list, .inverse_bind = inverse_bind, .joint_count = 2};
    assert_true(array_push(&scene->host, &scene->skins, skin));
    scene->nodes.data[*out_node].skin = 0;
    scene_update_transforms(scene);
    return scene;
}

/* One joint goes aside: the strip stretches, and the decal stays on the same vertices, as wide again. */
static void test_mesh_decals_do_not_slide_ES_27(void **state) {
    (void)state;
    uint32_t node, joints[2];
    fnl_scene *scene = strip_scene(&node, joints);
    fnl_decal_params p = plain(1, 0, 0, 1, box_at((vec3){0.5f, 0, 0}, quat_identity(), (vec3){0.5f, 0.4f, 0.2f}));
    p.kind = FNL_DECAL_MESH;
    p.instance = (fnl_instance_id){node, scene->nodes.data[node].generation};
    add(scene, &p);
    fnl_renderer *r = test_renderer(scene);
    for (int step = 0; step < 4; step++)
        for (int way = 0; way < 3; way++) {
            float moved = 0.3f * (float)step;
            mat4 aside = mat4_translation((vec3){moved, 0.1f * (float)step, 0});
            scene_move_nodes(scene, &(fnl_instance_id){.index = joints[1]}, &aside, 1);
            fnl_frame frame =
                frame_with(way ? FNL_SHADING_DEFERRED : FNL_SHADING_FORWARD,
                           way == 2 ? FNL_DECALS_GBUFFER : FNL_DECALS_LISTS, FNL_OUTPUT_SURFACE | FNL_OUTPUT_POSITION);
            frame.camera.vertical_extent = 4;
            test_render_frame(r, &frame);
            fnl_image surface = test_read(r, FNL_OUTPUT_SURFACE), position = test_read(r, FNL_OUTPUT_POSITION);
            uint32_t red = 0;
            for (uint32_t i = 0; i < SIDE * SIDE; i++) {
                const float *at = test_pixel(&position, i % SIDE, i / SIDE),
                            *seen = test_pixel(&surface, i % SIDE, i / SIDE);
                if (at[3] == 0 || at[0] < 0.51f * moved) continue; /* the right half: from moved / 2 to 1 + moved */
                double u =
                    ((double)at[0] - (double)moved / 2) / (1 + (double)moved / 2); /* 0 .. 1 before it was stretched */
                double v = (double)at[1] - 0.1 * step * (0.5 + 0.5 * u), far = fmax(fabs(u - 0.5) / 0.25, fabs(v) / 0.2);
                if (fabs(far - 1) < 1e-3) continue;
                bool is_red = seen[1] < 0.1f;
                if (is_red != (far < 1)) fail_msg("step %d, way %d, pixel %u", step, way, i);
                red += is_red;
            }
            assert_true(red > 40);
            free_picture(&surface);
            free_picture(&position);
        }
    fnl_renderer_destroy(&r);
    fnl_scene_destroy(&scene);
}

static fnl_instance_id instance_of(const fnl_scene *scene, uint32_t node) {
    return (fnl_instance_id){node, scene->nodes.data[node].generation};
}

/* A decal with the default fade lies on the front of its instance, which may be mirrored. */
static void test_mirrored_instances_ES_27_ES_28(void **state) {
    (void)state;
    for (uint32_t i = 0; i < 4; i++) {
        fnl_scene *scene = test_scene();
        uint32_t node =
            test_place(scene, test_quad_mesh(scene, add_grey(scene)), (vec3){0, 0, 0}, (vec3){i % 2 ? -1 : 1, 1, 1});
        assert_int_equal(fnl_scene_set_ambient(scene, (vec3){1, 1, 1}, (vec3){1, 1, 1}), FNL_OK);
        scene_update_transforms(scene);
        fnl_decal_params p = plain(1, 0, 0, 1, box_at((vec3){0, 0, 0}, quat_identity(), (vec3){1, 1, 0.2f}));
        p.kind = i / 2 ? FNL_DECAL_REDRAW : FNL_DECAL_MESH;
        p.instance = instance_of(scene, node);
        add(scene, &p);
        fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE);
        fnl_image radiance = test_render(scene, &frame, FNL_OUTPUT_RADIANCE);
        const float *seen = test_pixel(&radiance, SIDE / 2, SIDE / 2);
        if (seen[0] < 10 * seen[1]) fail_msg("case %u: %g %g %g", i, (double)seen[0], (double)seen[1], (double)seen[2]);
        free_picture(&radiance);
        fnl_scene_destroy(&scene);
    }
}

/* A redrawn decal has the light mask of its instance: a light that does not affect that leaves both as if it were off. */
static void test_redrawn_decals_have_light_masks(void **state) {
    (void)state;
    fnl_image pictures[3];
    for (uint32_t i = 0; i < 3; i++) { /* a light that affects the sphere, one that does not, and one that is off */
        fnl_scene *scene = test_scene();
        uint32_t node = test_place(scene, test_sphere_mesh(scene, add_grey(scene), 24), (vec3){0, 0, 0}, (vec3){0.9f, 0.9f, 0.9f});
        scene_update_transforms(scene);
        assert_int_equal(fnl_scene_set_ambient(scene, (vec3){0.1f, 0.1f, 0.1f}, (vec3){0.1f, 0.1f, 0.1f}), FNL_OK);
        fnl_decal_params p = plain(1, 0, 0, 1, box_at((vec3){0.1f, 0.2f, 0.9f}, quat_identity(), (vec3){1, 1, 0.9f}));
        p.kind = FNL_DECAL_REDRAW;
        p.instance = instance_of(scene, node);
        p.fade_start = p.fade_end = PI;
        add(scene, &p);
        fnl_light_params light = fnl_light_params_default();
        fnl_light_id id;
        light.kind = FNL_LIGHT_DIRECTIONAL;
        light.intensity = i == 2 ? 0 : 10;
        light.mask = i ? 2 : 1;
        assert_int_equal(fnl_scene_add_light(scene, &light, &id), FNL_OK);
        assert_int_equal(fnl_scene_set_instance_light_mask(scene, p.instance, 1), FNL_OK);
        fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE);
        frame.shading = FNL_SHADING_FORWARD;
        fnl_renderer *renderer = test_renderer(scene);
        test_render_frame(renderer, &frame);
        pictures[i] = test_read(renderer, FNL_OUTPUT_RADIANCE);
        if (i == 1) { /* masks may change after the decals are on the device */
            assert_int_equal(fnl_scene_set_instance_light_mask(scene, p.instance, 3), FNL_OK);
            test_render_frame(renderer, &frame);
            fnl_image changed = test_read(renderer, FNL_OUTPUT_RADIANCE);
            assert_memory_equal(changed.pixels, pictures[0].pixels, SIDE * SIDE * 4 * sizeof(float));
            free_picture(&changed);
        }
        fnl_renderer_destroy(&renderer);
        fnl_scene_destroy(&scene);
    }
    const float *lit = test_pixel(&pictures[0], SIDE / 2, SIDE / 2), *masked = test_pixel(&pictures[1], SIDE / 2, SIDE / 2);
    assert_true(lit[0] > 5 * lit[1] && lit[0] > 10 * masked[0] && masked[0] > 5 * masked[1]); /* the decal is red */
    assert_memory_equal(pictures[1].pixels, pictures[2].pixels, SIDE * SIDE * 4 * sizeof(float));
    for (uint32_t i = 0; i < 3; i++) free_picture(&pictures[i]);
}

/* A patch on a sphere: few triangles are drawn again, each pixel of the patch shows it, with MSAA too, and the rest keeps its bits. */
static void test_redrawn_triangles_ES_28(void **state) {
    (void)state;
    fnl_scene *scene = test_scene();
    uint32_t node =
        test_place(scene, test_sphere_mesh(scene, add_grey(scene), 24), (vec3){0, 0, 0}, (vec3){0.9f, 0.9f, 0.9f});
    scene_update_transforms(scene);
    assert_int_equal(fnl_scene_set_ambient(scene, (vec3){1, 1, 1}, (vec3){1, 1, 1}), FNL_OK);
    fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE | FNL_OUTPUT_POSITION);
    mat4 box = box_at((vec3){0.3f, 0.2f, 0.9f}, quat_identity(), (vec3){0.5f, 0.4f, 0.6f}), inverse;
    assert_true(mat4_inverse(&box, &inverse));
    static const struct {
        fnl_shading shading;
        uint32_t msaa;
    } cases[3] = {{FNL_SHADING_FORWARD, 1}, {FNL_SHADING_DEFERRED, 1}, {FNL_SHADING_FORWARD, 4}};
    fnl_image bare[3];
    for (int i = 0; i < 3; i++) {
        frame.shading = cases[i].shading;
        frame.msaa = cases[i].msaa;
        bare[i] = test_render(scene, &frame, FNL_OUTPUT_RADIANCE);
    }
    fnl_decal_params p = plain(1, 0, 0, 1, box);
    p.kind = FNL_DECAL_REDRAW;
    p.instance = instance_of(scene, node);
    p.fade_start = p.fade_end = PI;
    add(scene, &p);
    for (int i = 0; i < 3; i++) {
        frame.shading = cases[i].shading;
        frame.msaa = cases[i].msaa;
        fnl_renderer *r = test_renderer(scene);
        test_render_frame(r, &frame);
        uint64_t indices = r->device_scene->decals.redraw_indices.size / 4;
        assert_true(indices > 0 && indices < scene->primitives.data[0].index_count / 8);
        fnl_image seen = test_read(r, FNL_OUTPUT_RADIANCE), position = test_read(r, FNL_OUTPUT_POSITION);
        uint32_t red = 0;
        for (uint32_t k = 0; k < SIDE * SIDE; k++) {
            const float *at = test_pixel(&position, k % SIDE, k / SIDE), *c = test_pixel(&seen, k % SIDE, k / SIDE),
                        *b = test_pixel(&bare[i], k % SIDE, k / SIDE);
            float local[3] = {at[0] / 0.9f, at[1] / 0.9f, at[2] / 0.9f};
            double nearest = 0;
            bool inside = at[3] > 0 && holds(&inverse, local, &nearest);
            if (at[3] == 0 || nearest < (cases[i].msaa > 1 ? 0.1 : 1e-4)) continue;
            if (inside ? !(c[1] < 0.2f * c[0]) : memcmp(b, c, 12) != 0)
                fail_msg("case %d, pixel %u: %g %g %g, inside %d", i, k, (double)c[0], (double)c[1], (double)c[2], inside);
            red += inside;
        }
        assert_true(red > 60);
        free_picture(&seen);
        free_picture(&position);
        free_picture(&bare[i]);
        fnl_renderer_destroy(&r);
    }
    fnl_scene_destroy(&scene);
}

static void white_texel(uint32_t x, uint32_t y, uint8_t out[4]) {
    (void)x;
    (void)y;
    memset(out, 255, 4);
}

static uint32_t pass_count(fnl_renderer *r) {
    static char plan[1 << 16];
    fnl_renderer_print(r, FNL_PRINT_PLAN, plan, sizeof plan);
    uint32_t count = 0;
    for (const char *c = plan; (c = strstr(c, "\n  pass ")) != NULL; c++) count++;
    return count;
}

/* Two walls share mesh, material and picture; one is painted on. The frame's plan stays as it was, and taking it off restores the bits. */
static void test_baked_decals_cost_nothing_ES_29(void **state) {
    (void)state;
    fnl_scene *scene = test_scene();
    fnl_material_params m = fnl_material_params_default();
    m.metallic = 0;
    m.base_color_image = add_picture(scene, 64, 64, true, white_texel);
    uint32_t mesh = test_quad_mesh(scene, test_material(scene, &m).index);
    uint32_t left = test_place(scene, mesh, (vec3){-0.5f, 0, 0}, (vec3){0.45f, 0.9f, 1});
    test_place(scene, mesh, (vec3){0.5f, 0, 0}, (vec3){0.45f, 0.9f, 1});
    scene_update_transforms(scene);
    fnl_renderer *r = test_renderer(scene);
    fnl_frame frame = test_frame(FNL_OUTPUT_SURFACE);
    test_render_frame(r, &frame);
    uint32_t passes = pass_count(r);
    fnl_image before = test_read(r, FNL_OUTPUT_SURFACE);
    fnl_decal_params p = plain(1, 0, 0, 1, box_at((vec3){0, 0, 0}, quat_identity(), (vec3){1, 1, 0.2f}));
    p.kind = FNL_DECAL_BAKED;
    p.instance = instance_of(scene, left);
    fnl_decal_id id = add(scene, &p);
    test_render_frame(r, &frame);
    assert_int_equal(pass_count(r), passes);
    fnl_image painted = test_read(r, FNL_OUTPUT_SURFACE);
    assert_pixel(&painted, 16, 32, 1, 0, 0, 0.01); /* the middle of the left wall */
    assert_pixel(&painted, 5, 32, 1, 1, 1, 0.01);
    for (uint32_t i = 0; i < SIDE * SIDE; i++)
        if (i % SIDE >= SIDE / 2)
            assert_memory_equal(test_pixel(&before, i % SIDE, i / SIDE), test_pixel(&painted, i % SIDE, i / SIDE), 16);
    assert_int_equal(fnl_scene_remove_decal(scene, id), FNL_OK);
    test_render_frame(r, &frame);
    fnl_image after = test_read(r, FNL_OUTPUT_SURFACE);
    assert_true(test_equal(&before, &after));
    free_picture(&before);
    free_picture(&painted);
    free_picture(&after);
    fnl_renderer_destroy(&r);
    fnl_scene_destroy(&scene);
}

static void tilted_texel(uint32_t x, uint32_t y, uint8_t out[4]) {
    (void)x, (void)y;
    const uint8_t tilted[4] = {176, 104, 220, 255};
    memcpy(out, tilted, 4);
}

static void tilted_back_texel(uint32_t x, uint32_t y, uint8_t out[4]) {
    (void)x, (void)y;
    const uint8_t tilted[4] = {100, 140, 240, 255};
    memcpy(out, tilted, 4);
}

/* Each channel, and all of them, upon materials with and without textures of their own, flattened or not, mirrored, fading: what is
   baked looks like the decal on the mesh. Materials whose factors are less than what is painted keep what is beside it. */
static void test_baked_channels_ES_29(void **state) {
    (void)state;
    static const uint32_t channels[] = {FNL_DECAL_COLOR,    FNL_DECAL_NORMAL,   FNL_DECAL_ROUGHNESS,
                                        FNL_DECAL_METALLIC, FNL_DECAL_EMISSION, FNL_DECAL_ALL};
    for (uint32_t textured = 0; textured < 2; textured++)
        for (uint32_t i = 0; i < 2 * COUNT_OF(channels); i++) {
            fnl_scene *scene = test_scene();
            fnl_material_params m = fnl_material_params_default();
            m.metallic = 0.2f;
            m.roughness = textured ? 0.8f : 0.4f;
            m.emissive[0] = 0.1f;
            m.normal_scale = 0.8f;
            if (textured) {
                m.normal_image = add_picture(scene, 128, 128, false, tilted_back_texel);
                m.metallic_roughness_image = add_picture(scene, 128, 128, false, tilted_back_texel);
                m.emissive_image = add_picture(scene, 128, 128, true, tilted_texel);
            }
            uint32_t node =
                test_place(scene, test_quad_mesh(scene, test_material(scene, &m).index), (vec3){0, 0, 0}, (vec3){1, 1, 1});
            fnl_light_params light = test_point((vec3){0.6f, 0.4f, 0.9f}, 4, 6);
            scene_add_light(scene, &light, SCENE_NONE);
            assert_int_equal(fnl_scene_set_ambient(scene, (vec3){0.3f, 0.3f, 0.4f}, (vec3){0.1f, 0.1f, 0.1f}), FNL_OK);
            scene_update_transforms(scene);
            fnl_decal_params p = plain(0.9f, 0.3f, 0.2f, 0.75f,
                                       box_at((vec3){0, 0, 0}, quat_axis_angle((vec3){0, 0, 1}, 0.6f), (vec3){1, 1, 0.2f}));
            p.channels = channels[i / 2];
            if (textured && i % 2) /* seen from the side, so that it fades */
                p.transform = box_at((vec3){0, 0, 0}, quat_axis_angle((vec3){0, 1, 0}, 1.25f), (vec3){0.6f, 1, 0.95f});
            else if (textured) /* mirrored */
                p.transform = box_at((vec3){0, 0, 0}, quat_axis_angle((vec3){0, 0, 1}, 0.6f), (vec3){-1, 1, 0.2f});
            p.flatten = i % 2 == 1;
            p.roughness = 0.9f;
            p.metallic = 0.8f;
            p.normal_image = add_picture(scene, 8, 8, false, tilted_texel);
            p.emissive[0] = 0.05f;
            p.emissive[1] = 0.7f;
            p.instance = instance_of(scene, node);
            fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE);
            fnl_image seen[4];
            fnl_renderer *r = test_renderer(scene);
            for (int k = 0; k < 4; k++) { /* bare, on the mesh, baked, taken off again */
                fnl_decal_id id = {0};
                p.kind = k == 1 ? FNL_DECAL_MESH : FNL_DECAL_BAKED;
                if (k == 1 || k == 2) id = add(scene, &p);
                test_render_frame(r, &frame);
                seen[k] = test_read(r, FNL_OUTPUT_RADIANCE);
                if (id.generation) assert_int_equal(fnl_scene_remove_decal(scene, id), FNL_OK);
            }
            double off = 0, changed = 0, beside = 0;
            for (uint32_t y = 0; y < SIDE; y++)
                for (uint32_t x = 0; x < SIDE; x++)
                    for (int c = 0; c < 3; c++) {
                        double bare = (double)test_pixel(&seen[0], x, y)[c], mesh = (double)test_pixel(&seen[1], x, y)[c],
                               baked = (double)test_pixel(&seen[2], x, y)[c];
                        bool inside = hypot((double)x - 31.5, (double)y - 31.5) < 10;
                        bool outside = hypot((double)x - 31.5, (double)y - 31.5) > 26;
                        if (inside) off = fmax(off, fabs(mesh - baked) / (mesh + 0.05));
                        if (inside) changed = fmax(changed, fabs(mesh - bare) / (bare + 0.05));
                        if (outside) beside = fmax(beside, fabs(baked - bare) / (bare + 0.05));
                    }
            print_message("  channels %u, flatten %d, textured %u: %.4f off, %.3f changed, %.4f beside\n", p.channels,
                          p.flatten, textured, off, changed, beside);
            double most = p.channels & FNL_DECAL_NORMAL ? 0.06 : 0.02; /* eight bits have no level direction: 1/510 off */
            assert_true(off < most && changed > 0.02 && beside < most);
            assert_true(test_equal(&seen[0], &seen[3]));
            for (int k = 0; k < 4; k++) free_picture(&seen[k]);
            fnl_renderer_destroy(&r);
            fnl_scene_destroy(&scene);
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_mesh_decals_do_not_slide_ES_27),
        cmocka_unit_test(test_mirrored_instances_ES_27_ES_28),
        cmocka_unit_test(test_redrawn_triangles_ES_28),
        cmocka_unit_test(test_redrawn_decals_have_light_masks),
        cmocka_unit_test(test_baked_decals_cost_nothing_ES_29),
        cmocka_unit_test(test_baked_channels_ES_29),
    };
    return cmocka_run_group_tests(tests, test_group_begin, test_group_end);
}
