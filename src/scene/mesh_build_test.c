/* SPDX-License-Identifier: MIT */
/* Completing meshes, animation, skins, and scattering lights, against closed forms. */
#include "scene/scene.h"
#include "tests/gltf_test_file.h"
#include "tests/stand_in.h"

#include <setjmp.h>
#include <unistd.h>

#include <cmocka.h>

static fnl_scene *new_scene(void) {
    fnl_scene *scene;
    assert_int_equal(scene_create(NULL, "test", &scene), FNL_OK);
    return scene;
}

static void assert_near(vec3 a, vec3 b, float tolerance) {
    if (!(vec3_distance(a, b) <= tolerance))
        fail_msg("(%g %g %g) is not (%g %g %g)", (double)a.x, (double)a.y, (double)a.z, (double)b.x, (double)b.y,
                 (double)b.z);
}

static vec3 xyz(vec4 v) { return vec3_make(v.x, v.y, v.z); }

/* ---- meshes ---- */

/** A triangle soup of a cube has 12 faces; each normal is an axis, and each face gets its own vertices. */
/* Whatever the size of the mesh. Of lines no normal is that of a triangle. */
static void test_normals_that_lean(void **state) {
    UNUSED(state);
    static const float sizes[] = {1, 1e-15f, 1e15f};
    static const vec3 leaning = {0, 0.1f, 0.995f};
    for (uint32_t i = 0; i < COUNT_OF(sizes); i++) {
        vec3 positions[4] = {{0, 0, 0}, {sizes[i], 0, 0}, {sizes[i], sizes[i], 0}, {0, sizes[i], 0}}, normals[4] = {{0, 0, 1}, {0, 0, 2}, {0, 0, 1}, {0, 0, 1}};
        static const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
        struct scene_primitive p = {.vertex_count = 4, .index_count = 6, .positions = positions, .indices = indices};
        assert_false(primitive_leans(&p));
        p.normals = normals;
        assert_false(primitive_leans(&p));
        for (int k = 0; k < 4; k++) {
            const vec3 kept = normals[k];
            normals[k] = leaning;
            assert_true(primitive_leans(&p));
            normals[k] = vec3_scale(kept, -1);
            assert_true(primitive_leans(&p));
            normals[k] = kept;
        }
        positions[3] = positions[2]; /* a triangle without a plane has no normal to lean from */
        assert_false(primitive_leans(&p));
        p.joint_count = 4; /* bones bend flat faces */
        assert_true(primitive_leans(&p));
        normals[0] = leaning;
        p.topology = SCENE_TOPOLOGY_LINES;
        assert_false(primitive_leans(&p));
    }
}

static void test_flat_normals_split_vertices(void **state) {
    UNUSED(state);
    fnl_scene *scene = new_scene();
    const vec3 corners[] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const uint32_t indices[] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
    const vec3 moves[] = {{0, 0, 0}, {2, 0, 0}, {0, 0, 0}, {0, -3, 0}};
    const struct scene_morph_target target = {.positions = moves};
    struct scene_primitive p = {.vertex_count = 4,
                                .index_count = 12,
                                .positions = corners,
                                .indices = indices,
                                .morph_targets = &target,
                                .morph_target_count = 1};
    assert_int_equal(mesh_complete(&scene->arena, &p), FNL_OK);
    assert_int_equal(p.vertex_count, 12);
    assert_int_equal(p.index_count, 12);
    assert_near(p.normals[0], vec3_make(0, 0, -1), 1e-6f);
    assert_near(p.normals[4], vec3_make(0, -1, 0), 1e-6f);
    assert_near(p.normals[8], vec3_make(-1, 0, 0), 1e-6f);
    assert_near(p.normals[11], vec3_scale(vec3_make(1, 1, 1), 0.57735027f), 1e-6f);
    assert_near(p.positions[5], corners[3], 0);
    assert_near(p.morph_targets[0].positions[5], moves[3], 0);
    assert_null(p.tangents); /* no uvs */
    struct box bounds = primitive_bounds(&p);
    assert_near(bounds.low, vec3_make(0, -3, 0), 0);
    assert_near(bounds.high, vec3_make(3, 1, 1), 0);
    fnl_scene_destroy(&scene);
}

/** In any unit that floats can have, and for each target as well: the differences lead to its own flat normals and tangents. */
static void test_flat_normals_of_any_size_and_of_targets(void **state) {
    UNUSED(state);
    static const float sizes[] = {1, 1e11f, 1e-11f, 1e18f, 1e-18f};
    for (uint32_t i = 0; i < COUNT_OF(sizes); i++) {
        fnl_scene *scene = new_scene();
        const float s = sizes[i];
        const vec3 corners[] = {{0, 0, 0}, {s, 0, 0}, {0, s, 0}}, moves[] = {{0, 0, 0}, {-s, 0, s}, {0, 0, 0}};
        const vec2 uv[] = {{0, 0}, {1, 0}, {0, 1}};
        const struct scene_morph_target targets[2] = {{.positions = moves}, {0}};
        struct scene_primitive p = {.vertex_count = 3, .positions = corners, .uv = {uv}, .morph_targets = targets, .morph_target_count = 2};
        assert_int_equal(mesh_complete(&scene->arena, &p), FNL_OK);
        assert_near(p.normals[1], vec3_make(0, 0, 1), 1e-6f);
        assert_near(vec3_add(p.normals[1], p.morph_targets[0].normals[1]), vec3_make(-1, 0, 0), 1e-6f);
        assert_near(vec3_add(xyz(p.tangents[2]), p.morph_targets[0].tangents[2]), vec3_make(0, 0, 1), 1e-6f);
        assert_null(p.morph_targets[1].normals);
        fnl_scene_destroy(&scene);
    }
}

/** Without indices, vertices are used in order, and a rest of one or two is left out. */
static void test_missing_indices_are_numbered(void **state) {
    UNUSED(state);
    fnl_scene *scene = new_scene();
    const vec3 corners[] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {5, 5, 5}};
    struct scene_primitive p = {.vertex_count = 4, .positions = corners};
    assert_int_equal(mesh_complete(&scene->arena, &p), FNL_OK);
    assert_int_equal(p.index_count, 3);
    assert_near(p.normals[p.indices[2]], vec3_make(0, 0, 1), 0);
    struct scene_primitive lines = {.topology = SCENE_TOPOLOGY_LINES, .vertex_count = 4, .positions = corners};
    assert_int_equal(mesh_complete(&scene->arena, &lines), FNL_OK);
    assert_null(lines.normals);
    fnl_scene_destroy(&scene);
}

/**
 * Two quads in the plane z = 0 that share an edge, the right one with mirrored u. The tangent follows u, the handedness
 * is +1 where the picture shows upright (v runs down), and the shared vertices are split.
 */
static void test_tangents_follow_u_and_split_where_it_mirrors(void **state) {
    UNUSED(state);
    fnl_scene *scene = new_scene();
    const vec3 positions[] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {2, 0, 0}, {2, 1, 0}};
    const vec3 normals[] = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {0, 0, 1}};
    const vec2 uv[] = {{0, 1}, {1, 1}, {1, 0}, {0, 0}, {0, 1}, {0, 0}};
    const uint32_t indices[] = {0, 1, 2, 0, 2, 3, 1, 4, 5, 1, 5, 2};
    struct scene_primitive p = {
        .vertex_count = 6, .index_count = 12, .positions = positions, .normals = normals, .uv = {uv}, .indices = indices};
    assert_int_equal(mesh_complete(&scene->arena, &p), FNL_OK);
    assert_int_equal(p.vertex_count, 8);
    for (uint32_t i = 0; i < 12; i++) {
        float sign = i < 6 ? 1.0f : -1.0f;
        vec4 t = p.tangents[p.indices[i]];
        assert_near(xyz(t), vec3_make(sign, 0, 0), 1e-6f);
        assert_true(t.w == sign);
        assert_near(p.positions[p.indices[i]], positions[indices[i]], 0);
        assert_true(p.uv[0][p.indices[i]].x == uv[indices[i]].x);
        /* In both, the bitangent points up the picture. */
        assert_near(vec3_scale(vec3_cross(p.normals[p.indices[i]], xyz(t)), t.w), vec3_make(0, 1, 0), 1e-6f);
    }
    fnl_scene_destroy(&scene);
}

/** Vertices stored twice are averaged as one, by the faces' angles: a flat fan's centre has what its faces' sum has. */
static void test_tangents_are_averaged_over_equal_vertices(void **state) {
    UNUSED(state);
    fnl_scene *scene = new_scene();
    /* At the origin meet a face of 90 degrees whose u runs along X, and one of 45 degrees whose u runs between X and Y. */
    const vec3 positions[] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {0, 1, 0}, {-1, 1, 0}};
    const vec3 normals[] = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {0, 0, 1}};
    const vec2 uv[] = {{0, 0}, {1, 0}, {0, -1}, {0, 0}, {0, -1}, {-1, -2}};
    struct scene_primitive p = {.vertex_count = 6, .positions = positions, .normals = normals, .uv = {uv}};
    assert_int_equal(mesh_complete(&scene->arena, &p), FNL_OK);
    vec3 expected = vec3_normalize(vec3_make(PI / 2 + PI / 4 * sqrtf(0.5f), PI / 4 * sqrtf(0.5f), 0));
    assert_near(xyz(p.tangents[0]), expected, 1e-6f);
    assert_near(xyz(p.tangents[3]), expected, 1e-6f);
    assert_near(xyz(p.tangents[1]), vec3_make(1, 0, 0), 1e-6f);
    fnl_scene_destroy(&scene);
}

static void test_tangents_survive_uvs_without_area(void **state) {
    UNUSED(state);
    fnl_scene *scene = new_scene();
    const vec3 positions[] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
    const vec2 uv[6] = {{0.5f, 0.5f}, {0.5f, 0.5f}, {0.5f, 0.5f}, {0, 0}, {1, 0}, {0, 1}};
    struct scene_primitive p = {.vertex_count = 6, .positions = positions, .uv = {NULL, uv}};
    assert_int_equal(mesh_complete(&scene->arena, &p), FNL_OK);
    for (int i = 0; i < 6; i++) {
        vec3 t = xyz(p.tangents[i]);
        assert_true(fabsf(vec3_dot(t, t) - 1) < 1e-5f && fabsf(vec3_dot(t, p.normals[i])) < 1e-5f);
    }
    fnl_scene_destroy(&scene);
}

/* ---- animation ---- */

static const float times[] = {1, 2, 4};

static fnl_scene *animated_scene(const struct scene_channel *channels, uint32_t count) {
    fnl_scene *scene = new_scene();
    mat4 local = mat4_identity();
    assert_int_equal(scene_add_node(scene, "node", SCENE_NONE, &local, SCENE_NONE), 0);
    struct scene_node *node = &scene->nodes.data[0];
    node->has_matrix = false;
    struct scene_animation animation = {.name = "a", .channels = channels, .channel_count = count, .duration = 4};
    assert_true(array_push(&scene->host, &scene->animations, animation));
    return scene;
}

static vec3 translation_at(fnl_scene *scene, double seconds) {
    assert_int_equal(fnl_scene_set_time(scene, 0, seconds), FNL_OK);
    const float *m = scene->nodes.data[0].world.m;
    return vec3_make(m[12], m[13], m[14]);
}

static void test_steps_and_lines_are_clamped_at_their_ends(void **state) {
    UNUSED(state);
    const float values[] = {0, 0, 0, 10, 0, -2, 20, 4, 0};
    struct scene_channel channel = {.path = SCENE_PATH_TRANSLATION,
                                    .interpolation = SCENE_INTERPOLATION_LINEAR,
                                    .key_count = 3,
                                    .width = 3,
                                    .times = times,
                                    .values = values};
    fnl_scene *scene = animated_scene(&channel, 1);
    assert_near(translation_at(scene, -5), vec3_make(0, 0, 0), 0);
    assert_near(translation_at(scene, 1.25), vec3_make(2.5f, 0, -0.5f), 1e-6f);
    assert_near(translation_at(scene, 2), vec3_make(10, 0, -2), 0);
    assert_near(translation_at(scene, 3.5), vec3_make(17.5f, 3, -0.5f), 1e-6f);
    assert_near(translation_at(scene, 99), vec3_make(20, 4, 0), 0);
    channel.interpolation = SCENE_INTERPOLATION_STEP;
    assert_near(translation_at(scene, 1.999), vec3_make(0, 0, 0), 0);
    assert_near(translation_at(scene, 2), vec3_make(10, 0, -2), 0);
    assert_near(translation_at(scene, 3.999), vec3_make(10, 0, -2), 0);
    assert_int_equal(fnl_scene_set_time(scene, 1, 0), FNL_ERROR_INVALID);
    assert_int_equal(fnl_scene_set_time(scene, 0, (double)NAN), FNL_ERROR_INVALID);
    fnl_scene_destroy(&scene);
}

/** Keys taken from a cubic give back that cubic: y = t^3 - t^2 at x, its derivative as both tangents. */
static void test_cubic_splines_reproduce_a_cubic(void **state) {
    UNUSED(state);
    float values[27] = {0};
    for (int k = 0; k < 3; k++) {
        float t = times[k], *key = values + 9 * k;
        key[0] = key[6] = 3 * t * t - 2 * t;
        key[3] = t * t * t - t * t;
    }
    struct scene_channel channel = {.path = SCENE_PATH_TRANSLATION,
                                    .interpolation = SCENE_INTERPOLATION_CUBIC,
                                    .key_count = 3,
                                    .width = 3,
                                    .times = times,
                                    .values = values};
    fnl_scene *scene = animated_scene(&channel, 1);
    for (float t = 1; t <= 4; t += 0.125f)
        assert_near(translation_at(scene, (double)t), vec3_make(t * t * t - t * t, 0, 0), 1e-4f);
    assert_near(translation_at(scene, 7), vec3_make(48, 0, 0), 0);
    fnl_scene_destroy(&scene);
}

/** From 0 to 90 degrees about Y, the far way round written with the opposite sign: the short way is taken, evenly. */
static void test_rotations_turn_evenly_the_short_way(void **state) {
    UNUSED(state);
    float h = sqrtf(0.5f), values[] = {0, 0, 0, 1, 0, -h, 0, -h, 0, -h, 0, -h};
    struct scene_channel channel = {.path = SCENE_PATH_ROTATION,
                                    .interpolation = SCENE_INTERPOLATION_LINEAR,
                                    .key_count = 3,
                                    .width = 4,
                                    .times = times,
                                    .values = values};
    fnl_scene *scene = animated_scene(&channel, 1);
    for (int i = 0; i <= 10; i++) {
        assert_int_equal(fnl_scene_set_time(scene, 0, 1 + 0.1 * i), FNL_OK);
        float angle = PI / 2 * 0.1f * (float)i;
        assert_near(mat4_direction(&scene->nodes.data[0].world, vec3_make(0, 0, 1)), vec3_make(sinf(angle), 0, cosf(angle)),
                    1e-5f);
    }
    fnl_scene_destroy(&scene);
}

static void test_weights_go_to_the_node(void **state) {
    UNUSED(state);
    const float values[] = {0, 1, 1, 0, 0.5f, 0.25f}, defaults[] = {0.1f, 0.2f};
    struct scene_channel channel = {.path = SCENE_PATH_WEIGHTS,
                                    .interpolation = SCENE_INTERPOLATION_LINEAR,
                                    .key_count = 3,
                                    .width = 2,
                                    .times = times,
                                    .values = values};
    fnl_scene *scene = animated_scene(&channel, 1);
    struct scene_mesh mesh = {.morph_weights = defaults, .morph_target_count = 2};
    assert_true(array_push(&scene->host, &scene->meshes, mesh));
    scene->nodes.data[0].mesh = 0;
    uint64_t version = scene->transform_version;
    assert_int_equal(fnl_scene_set_time(scene, 0, 1.5), FNL_OK);
    assert_true(scene->nodes.data[0].morph_weights[0] == 0.5f && scene->nodes.data[0].morph_weights[1] == 0.5f);
    assert_true(scene->transform_version > version); /* renderers must see it */
    fnl_scene_destroy(&scene);
}

/** The joints of a posed skin: unit-scale rigid motions of bounded reach, and different at different times. */
static void test_fox_runs(void **state) {
    UNUSED(state);
    static struct test_log log;
    fnl_host host = test_host(&log);
    fnl_scene *scene;
    size_t size;
    unsigned char *glb = stand_in_figure("Fox.glb", &size);
    if (gltf_load_memory(&host, glb, size, "fox.glb", NULL, &scene) != FNL_OK || log.count) fail_msg("%s", log.text);
    free(glb);
    assert_true(scene->skins.count == 1 && scene->animations.count == 3);
    uint32_t count = scene->skins.data[0].joint_count;
    mat4 *first = calloc(count, sizeof(mat4)), *second = calloc(count, sizeof(mat4));
    assert_true(first && second);
    for (uint32_t a = 0; a < 3; a++) {
        double duration = (double)scene->animations.data[a].duration;
        assert_int_equal(fnl_scene_set_time(scene, a, 0), FNL_OK);
        skin_matrices(scene, 0, first);
        assert_int_equal(fnl_scene_set_time(scene, a, duration / 3), FNL_OK);
        skin_matrices(scene, 0, second);
        uint32_t moved = 0;
        for (uint32_t i = 0; i < count; i++) {
            assert_true(fabsf(mat4_determinant3(&second[i]) - 1) < 0.02f);
            vec3 shift = vec3_make(second[i].m[12], second[i].m[13], second[i].m[14]);
            assert_true(vec3_length(shift) < 300); /* the fox is about 150 units long */
            moved += memcmp(&first[i], &second[i], sizeof(mat4)) != 0;
        }
        assert_true(moved > count / 2);
    }
    free(first);
    free(second);
    fnl_scene_destroy(&scene);
}

/* ---- lights ---- */

static void test_derived_ranges_end_at_a_twentieth_of_a_lux(void **state) {
    UNUSED(state);
    fnl_light_params light = fnl_light_params_default();
    light.intensity = 20;
    light.color[0] = 0.25f;
    light.color[1] = 1.25f;
    light.color[2] = 0;
    float range = fnl_light_range(&light, 1, 0.05f);
    assert_true(fabsf(light.intensity * 1.25f / (range * range) - 0.05f) < 1e-6f);
    light.range = 3;
    assert_true(fnl_light_range(&light, 1, 0.05f) == 3);
    light.kind = FNL_LIGHT_DIRECTIONAL;
    assert_true(isinf(fnl_light_range(&light, 1, 0.05f)));
}

static void test_ranges_grow_as_roughness_falls(void **state) {
    UNUSED(state);
    fnl_light_params light = fnl_light_params_default();
    light.intensity = 20;
    light.color[1] = 1.25f;
    float last = 0;
    for (int i = 100; i >= 0; i--) { /* twice as far for half the alpha, and finite for mirrors */
        float roughness = (float)i / 100, range = fnl_light_range(&light, roughness, 0.05f);
        assert_true(isfinite(range) && (roughness < 0.7f && roughness * roughness > 1e-3f ? range > last : range >= last));
        double alpha = fmax((double)roughness * (double)roughness, 0.001), peak = 1 / (4 * (double)PI * alpha * alpha);
        /* I * peak / range^2 is what the threshold is on matt white, or less where that is the brighter */
        double left = 25 * fmax(peak, 1 / (double)PI) / ((double)range * (double)range);
        assert_true(fabs(left / (0.05 / (double)PI) - 1) < 1e-4);
        last = range;
    }
    assert_true(last > 400 * fnl_light_range(&light, 1, 0.05f));
    assert_true(fabsf(fnl_light_range(&light, 1, 0.2f) * 2 - fnl_light_range(&light, 1, 0.05f)) < 1e-4f);
    light.intensity = FLT_MAX;
    assert_true(fnl_light_range(&light, 0, 1e-30f) <= 1e18f);
    light.range = 3;
    assert_true(fnl_light_range(&light, 0.1f, 0.05f) == 3);
    light.kind = FNL_LIGHT_BOX;
    light.box_size = vec3_make(2, 3, 6);
    assert_true(fnl_light_range(&light, 0.1f, 0.05f) == 3.5f);
    light.kind = FNL_LIGHT_DIRECTIONAL;
    assert_true(isinf(fnl_light_range(&light, 0.1f, 0.05f)));
}

/* Shares are kept to a light, the default is the plain call, and all of them are lights the scene would take. */
static void test_scattered_shapes(void **state) {
    UNUSED(state);
    fnl_scene *plain = new_scene(), *same = new_scene(), *mixed = new_scene();
    fnl_scatter_params params = fnl_scatter_params_default();
    params.count = 103;
    params.seed = 7;
    assert_int_equal(fnl_scene_scatter_lights(plain, 103, 7), FNL_OK);
    assert_int_equal(fnl_scene_scatter_light_shapes(same, &params), FNL_OK);
    for (uint32_t i = 0; i < 103; i++)
        assert_memory_equal(&plain->lights.data[i].params, &same->lights.data[i].params, sizeof(fnl_light_params));
    for (int k = FNL_LIGHT_POINT; k < FNL_LIGHT_KIND_COUNT; k++) params.shares[k] = (float)k;
    params.count = 210;
    params.radius_scale = 0.5f;
    assert_int_equal(fnl_scene_scatter_light_shapes(mixed, &params), FNL_OK);
    uint32_t given[FNL_LIGHT_KIND_COUNT] = {0};
    for (uint32_t i = 0; i < 210; i++) {
        fnl_light_id id;
        given[mixed->lights.data[i].params.kind]++;
        assert_int_equal(fnl_scene_add_light(plain, &mixed->lights.data[i].params, &id), FNL_OK);
    }
    for (uint32_t k = FNL_LIGHT_POINT; k < FNL_LIGHT_KIND_COUNT; k++) assert_int_equal(given[k], 10 * k);
    assert_true(mixed->lights.data[4].params.range < plain->lights.data[0].params.range);
    params.shares[FNL_LIGHT_DIRECTIONAL] = 1;
    assert_int_equal(fnl_scene_scatter_light_shapes(mixed, &params), FNL_ERROR_INVALID);
    params = fnl_scatter_params_default();
    params.radius_scale = 0;
    assert_int_equal(fnl_scene_scatter_light_shapes(mixed, &params), FNL_ERROR_INVALID);
    fnl_scene_destroy(&plain);
    fnl_scene_destroy(&same);
    fnl_scene_destroy(&mixed);
}

/** Mean number of lights over random points of the box, whatever the count and the box's shape; and the same twice. */
static void test_scattered_lights_overlap_eightfold(void **state) {
    UNUSED(state);
    const vec3 sizes[] = {{1, 1, 1}, {100, 100, 100}, {50, 0, 50}, {0.2f, 3, 40}};
    const uint32_t counts[] = {100, 3000};
    for (uint32_t s = 0; s < COUNT_OF(sizes); s++)
        for (uint32_t k = 0; k < COUNT_OF(counts); k++) {
            fnl_scene *scene[2];
            vec3 a = sizes[s];
            for (int i = 0; i < 2; i++) {
                scene[i] = new_scene();
                const float corners[] = {0, 0, 0, a.x, a.y, 0, a.x, a.y, a.z};
                fnl_mesh_params params = {.vertex_count = 3, .positions = corners};
                fnl_mesh_id mesh;
                fnl_instance_id instance;
                mat4 identity = mat4_identity();
                assert_int_equal(fnl_scene_add_mesh(scene[i], &params, &mesh), FNL_OK);
                assert_int_equal(fnl_scene_add_instance(scene[i], mesh, &identity, &instance), FNL_OK);
                assert_int_equal(fnl_scene_scatter_lights(scene[i], counts[k], 5), FNL_OK);
                assert_int_equal(scene[i]->lights.count, counts[k]);
            }
            struct random_state random = {9};
            uint64_t sum = 0, spots = 0;
            for (int i = 0; i < 2000; i++) {
                vec3 p = {a.x * random_float(&random), a.y * random_float(&random), a.z * random_float(&random)};
                for (uint32_t l = 0; l < counts[k]; l++)
                    sum +=
                        vec3_distance(p, scene[0]->lights.data[l].params.position) < scene[0]->lights.data[l].params.range;
            }
            for (uint32_t l = 0; l < counts[k]; l++) {
                const fnl_light_params *x = &scene[0]->lights.data[l].params, *y = &scene[1]->lights.data[l].params;
                spots += x->kind == FNL_LIGHT_SPOT;
                assert_true(x->position.x == y->position.x && x->range == y->range && x->intensity == y->intensity);
            }
            assert_int_equal(spots, counts[k] / 4);
            double mean = (double)sum / 2000;
            if (mean < 6.5 || mean > 9.5) fail_msg("box %u, %u lights: %g reach a point", s, counts[k], mean);
            fnl_scene_destroy(&scene[0]);
            fnl_scene_destroy(&scene[1]);
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_normals_that_lean),
        cmocka_unit_test(test_flat_normals_split_vertices),
        cmocka_unit_test(test_flat_normals_of_any_size_and_of_targets),
        cmocka_unit_test(test_missing_indices_are_numbered),
        cmocka_unit_test(test_tangents_follow_u_and_split_where_it_mirrors),
        cmocka_unit_test(test_tangents_are_averaged_over_equal_vertices),
        cmocka_unit_test(test_tangents_survive_uvs_without_area),
        cmocka_unit_test(test_steps_and_lines_are_clamped_at_their_ends),
        cmocka_unit_test(test_cubic_splines_reproduce_a_cubic),
        cmocka_unit_test(test_rotations_turn_evenly_the_short_way),
        cmocka_unit_test(test_weights_go_to_the_node),
        cmocka_unit_test(test_fox_runs),
        cmocka_unit_test(test_derived_ranges_end_at_a_twentieth_of_a_lux),
        {"ES-5: ranges grow as roughness falls", test_ranges_grow_as_roughness_falls, NULL, NULL, NULL},
        cmocka_unit_test(test_scattered_lights_overlap_eightfold),
        cmocka_unit_test(test_scattered_shapes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
