/* SPDX-License-Identifier: MIT */
#include "scene/builtin.h"
#include "scene/builtin_mesh.h"

#include <setjmp.h>

#include <cmocka.h>

static char last_error[2048];

static void keep_error(void *user, fnl_log_level level, const char *line) {
    UNUSED(user);
    if (level == FNL_LOG_ERROR) snprintf(last_error, sizeof last_error, "%s", line);
}

static fnl_scene *load(const char *text) {
    fnl_scene *scene;
    assert_int_equal(builtin_load(NULL, text, &scene), FNL_OK);
    assert_non_null(scene);
    return scene;
}

static bool unit(vec3 v) { return fabsf(vec3_dot(v, v) - 1) < 1e-3f; }

static void check_primitive(const fnl_scene *scene, const struct scene_primitive *p) {
    assert_true(p->vertex_count > 0 && p->index_count >= 3 && p->index_count % 3 == 0);
    assert_true(p->material < scene->materials.count);
    for (uint32_t i = 0; i < p->index_count; i++) assert_true(p->indices[i] < p->vertex_count);
    for (uint32_t i = 0; i < p->vertex_count; i++) {
        vec3 n = p->normals[i], t = {p->tangents[i].x, p->tangents[i].y, p->tangents[i].z};
        assert_true(vec3_finite(p->positions[i]) && isfinite(p->uv[0][i].x) && isfinite(p->uv[0][i].y));
        assert_true(unit(n) && unit(t) && fabsf(vec3_dot(n, t)) < 2e-3f);
        assert_true(fabsf(p->tangents[i].w) == 1);
    }
    uint32_t turned = 0, faces = p->index_count / 3;
    for (uint32_t f = 0; f < faces; f++) {
        const uint32_t *v = p->indices + 3 * (size_t)f;
        vec3 a = p->positions[v[0]], n = vec3_cross(vec3_sub(p->positions[v[1]], a), vec3_sub(p->positions[v[2]], a));
        turned += vec3_dot(n, vec3_add(p->normals[v[0]], vec3_add(p->normals[v[1]], p->normals[v[2]]))) < 0;
    }
    assert_int_equal(turned, 0); /* faces are seen from where their normals point */
}

static void check_scene(const fnl_scene *scene) {
    for (uint32_t i = 0; i < scene->primitives.count; i++) check_primitive(scene, &scene->primitives.data[i]);
    for (uint32_t i = 0; i < scene->materials.count; i++)
        for (int k = 0; k < SCENE_TEXTURE_SLOT_COUNT; k++) {
            uint32_t image = scene->materials.data[i].textures[k].image;
            assert_true(image == SCENE_NONE || (image < scene->images.count && scene->images.data[image].pixels));
        }
    for (uint32_t i = 0; i < scene->lights.count; i++) {
        const fnl_light_params *light = &scene->lights.data[i].params;
        assert_true(vec3_finite(light->position) && isfinite(light->range) && light->range > 0 && light->intensity > 0);
        assert_true(light->kind == FNL_LIGHT_POINT || unit(light->direction));
        if (light->kind == FNL_LIGHT_WEDGE || light->kind == FNL_LIGHT_BOX)
            assert_true(unit(light->up) && fabsf(vec3_dot(light->up, light->direction)) < 1e-5f);
    }
    assert_true(scene->cameras.count > 0 && scene->nodes.count > 0);
    struct box bounds = scene_bounds(scene);
    assert_true(vec3_finite(bounds.low) && vec3_finite(bounds.high) && bounds.low.x < bounds.high.x);
}

/** A hash of everything that a picture depends on. */
static uint64_t scene_hash(const fnl_scene *scene) {
    uint64_t h = HASH_SEED;
    for (uint32_t i = 0; i < scene->images.count; i++)
        h = hash_bytes(scene->images.data[i].pixels, (size_t)scene->images.data[i].width * scene->images.data[i].height * 4,
                       h);
    for (uint32_t i = 0; i < scene->primitives.count; i++) {
        const struct scene_primitive *p = &scene->primitives.data[i];
        h = hash_bytes(p->positions, sizeof(vec3) * p->vertex_count, h);
        h = hash_bytes(p->normals, sizeof(vec3) * p->vertex_count, h);
        h = hash_bytes(p->tangents, sizeof(vec4) * p->vertex_count, h);
        h = hash_bytes(p->uv[0], sizeof(vec2) * p->vertex_count, h);
        h = hash_bytes(p->indices, sizeof(uint32_t) * p->index_count, h);
    }
    for (uint32_t i = 0; i < scene->nodes.count; i++) {
        const struct scene_node *node = &scene->nodes.data[i];
        h = hash_bytes(&node->world, sizeof(mat4), h);
        if (node->instances) h = hash_bytes(node->instances, sizeof(mat4) * node->instance_count, h);
    }
    for (uint32_t i = 0; i < scene->lights.count; i++) {
        const fnl_light_params *l = &scene->lights.data[i].params;
        float values[] = {(float)l->kind,
                          l->position.x,
                          l->position.y,
                          l->position.z,
                          l->direction.x,
                          l->direction.y,
                          l->direction.z,
                          l->color[0],
                          l->color[1],
                          l->color[2],
                          l->intensity,
                          l->range,
                          l->inner_cone_angle,
                          l->outer_cone_angle,
                          l->up.x,
                          l->up.y,
                          l->up.z,
                          l->length,
                          l->box_size.x,
                          l->box_size.y,
                          l->box_size.z,
                          l->wedge_angles[0],
                          l->wedge_angles[1]};
        h = hash_bytes(values, sizeof values, h);
    }
    return h;
}

static uint64_t hash_of(const char *text) {
    fnl_scene *scene = load(text);
    uint64_t hash = scene_hash(scene);
    fnl_scene_destroy(&scene);
    return hash;
}

static void test_every_scene_is_sound_and_the_same_twice(void **state) {
    UNUSED(state);
    const struct builtin_scene *what;
    for (uint32_t i = 0; (what = builtin_scene_at(i)); i++) {
        fnl_scene *scene = load(what->name);
        check_scene(scene);
        assert_true(scene->lights.count > 0);
        uint64_t hash = scene_hash(scene);
        char source[64];
        snprintf(source, sizeof source, "builtin:%s", what->name);
        assert_string_equal(scene->source, source);
        fnl_scene_destroy(&scene);
        assert_true(hash == hash_of(what->name));
        char text[64];
        snprintf(text, sizeof text, "%s?seed=7", what->name);
        assert_true(hash != hash_of(text) || strcmp(what->name, "lamps") == 0); /* a row has nothing random */
    }
}

static void test_light_counts_are_exact(void **state) {
    UNUSED(state);
    const struct builtin_scene *what;
    const uint32_t counts[] = {0, 1, 17, 300};
    for (uint32_t i = 0; (what = builtin_scene_at(i)); i++)
        for (uint32_t k = 0; k < COUNT_OF(counts); k++) {
            char text[64];
            snprintf(text, sizeof text, "%s?lights=%u", what->name, counts[k]);
            fnl_scene *scene = load(text);
            assert_int_equal(scene->lights.count, counts[k]);
            fnl_scene_destroy(&scene);
        }
}

static void test_wrong_names_and_keys_are_explained(void **state) {
    UNUSED(state);
    const struct {
        const char *text, *message;
    } cases[] = {
        {"cty", "there is no built-in scene 'cty'; there are: "},
        {"", "there is no built-in scene ''"},
        {"?lights=3", "there is no built-in scene ''"},
        {"pole?lihgts=3", "'lihgts=3' is not a key of pole with a value; there are: lights=0..1048576, seed=0..4294967295"},
        {"pole?lights", "'lights' is not a key of pole with a value"},
        {"pole?lights=", "lights= is not a whole number from 0 to 1048576"},
        {"pole?lights=1048577", "lights=1048577 is not a whole number"},
        {"pole?lights=99999999999999999999999", "is not a whole number"},
        {"pole?seed=1&lights=-1", "lights=-1 is not a whole number"},
        {"pole?seed=1&&lights=1", "'' is not a key of pole"},
    };
    fnl_host host = fnl_host_default();
    host.log = keep_error;
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        fnl_scene *scene;
        last_error[0] = 0;
        assert_int_equal(builtin_load(&host, cases[i].text, &scene), FNL_ERROR_INVALID);
        assert_null(scene);
        if (!strstr(last_error, cases[i].message)) fail_msg("'%s' gave '%s'", cases[i].text, last_error);
    }
}

/** Fails the allocation number `limit` and all later ones. */
static void *limited_reallocate(void *user, void *old, size_t old_size, size_t new_size) {
    UNUSED(old_size);
    int64_t *left = user;
    if (new_size == 0) {
        free(old);
        return NULL;
    }
    return (*left)-- > 0 ? realloc(old, new_size) : NULL;
}

static void test_running_out_of_memory_is_an_error(void **state) {
    UNUSED(state);
    fnl_host host = fnl_host_default();
    host.log = keep_error;
    host.reallocate = limited_reallocate;
    host.thread_count = 1;
    uint32_t failures = 0;
    for (int64_t limit = 0; limit < 400; limit += limit < 40 ? 1 : 17) {
        int64_t left = limit;
        host.user = &left;
        fnl_scene *scene;
        fnl_result result = builtin_load(&host, "sky?lights=40", &scene);
        assert_true(result == FNL_OK || (result == FNL_ERROR_MEMORY && !scene));
        failures += result != FNL_OK;
        fnl_scene_destroy(&scene);
    }
    assert_true(failures > 10);
}

static uint64_t triangle_count(const char *text) {
    fnl_scene *scene = load(text);
    fnl_scene_info info;
    assert_int_equal(fnl_scene_query_info(scene, &info), FNL_OK);
    fnl_scene_destroy(&scene);
    return info.triangle_count;
}

static void test_hall_is_of_the_stated_size(void **state) {
    UNUSED(state);
    uint64_t count = triangle_count("hall");
    assert_in_range(count, 200000, 300000);
}

enum { WAYS = 64 }; /* evenly spread over the sphere */

static vec3 way_at(int k) {
    float y = 1 - (2 * (float)k + 1) / WAYS, across = sqrtf(1 - y * y), turn = 2.3999632f * (float)k;
    return vec3_make(across * cosf(turn), y, across * sinf(turn));
}

/* Which of the ways from a point a triangle bars within a distance, as bits. */
static uint64_t barred(vec3 from, float reach, const vec3 corners[3]) {
    vec3 low = vec3_min(vec3_min(corners[0], corners[1]), corners[2]);
    vec3 high = vec3_max(vec3_max(corners[0], corners[1]), corners[2]);
    vec3 beside = vec3_max(vec3_max(vec3_sub(low, from), vec3_sub(from, high)), vec3_make(0, 0, 0));
    if (vec3_dot(beside, beside) > reach * reach) return 0;
    uint64_t bits = 0;
    vec3 a = vec3_sub(corners[1], corners[0]), b = vec3_sub(corners[2], corners[0]), p = vec3_sub(from, corners[0]);
    for (int k = 0; k < WAYS; k++) {
        vec3 way = way_at(k), q = vec3_cross(way, b), r = vec3_cross(p, a);
        float d = vec3_dot(a, q), u = vec3_dot(p, q) / d, v = vec3_dot(way, r) / d, t = vec3_dot(b, r) / d;
        if (d != 0 && u >= 0 && v >= 0 && u + v <= 1 && t > 0 && t < reach) bits |= 1ull << k;
    }
    return bits;
}

static uint64_t barred_by_node(const fnl_scene *scene, const struct scene_node *node, vec3 from, float reach) {
    uint64_t bits = 0;
    const struct scene_mesh *mesh = &scene->meshes.data[node->mesh];
    for (uint32_t i = 0; i < node->instance_count; i++) {
        mat4 world = node->instances ? mat4_mul(node->world, node->instances[i]) : node->world;
        vec3 middle = vec3_scale(vec3_add(mesh->bounds.low, mesh->bounds.high), 0.5f),
             half = vec3_sub(mesh->bounds.high, middle);
        vec3 away = vec3_sub(mat4_point(&world, middle), from);
        if (sqrtf(vec3_dot(away, away)) > sqrtf(vec3_dot(half, half)) * 1.5f + reach)
            continue; /* nothing is scaled by more */
        for (uint32_t k = 0; k < mesh->primitive_count; k++) {
            const struct scene_primitive *p = &scene->primitives.data[mesh->first_primitive + k];
            if (p->material != SCENE_NONE && !scene->materials.data[p->material].casts_shadows) continue;
            for (uint32_t f = 0; f + 2 < p->index_count; f += 3) {
                vec3 corners[3];
                for (int c = 0; c < 3; c++) corners[c] = mat4_point(&world, p->positions[p->indices[f + (uint32_t)c]]);
                bits |= barred(from, reach, corners);
            }
        }
    }
    return bits;
}

/* Light comes out of every kind of lamp, whose body casts shadows: most ways from it are free, half a metre far. */
static void test_lamps_let_their_light_out(void **state) {
    UNUSED(state);
    const struct {
        const char *scene;
        uint32_t first, end, step;
        int most; /* ways that may be barred */
    } runs[] = {
        {"hall?lights=600", 0, 3, 1, 16},     /* chandelier */
        {"hall?lights=600", 96, 160, 14, 20}, /* torches: beside a wall, above a bowl */
        {"hall?lights=600", 97, 160, 14, 32}, /* lanterns: under a roof */
        {"hall?lights=600", 320, 344, 1, 16}, /* candles of all sizes */
        {"interior", 28, 29, 1, 24},          /* a globe that hangs from a brass cap */
        {"lamps", 0, 4, 1, 16},               /* globes on masts */
        {"city?lights=64", 0, 64, 9, 32},
    };
    fnl_scene *scene = NULL;
    for (size_t i = 0; i < COUNT_OF(runs); i++) {
        if (i == 0 || strcmp(runs[i].scene, runs[i - 1].scene) != 0) {
            fnl_scene_destroy(&scene);
            scene = load(runs[i].scene);
        }
        for (uint32_t light = runs[i].first; light < runs[i].end; light += runs[i].step) {
            uint64_t bits = 0;
            for (uint32_t k = 0; k < scene->nodes.count; k++)
                if (scene_node_draws(&scene->nodes.data[k]))
                    bits |= barred_by_node(scene, &scene->nodes.data[k], scene->lights.data[light].params.position, 0.5f);
            int count = 0;
            for (; bits; bits &= bits - 1) count++;
            if (count > runs[i].most) fail_msg("%s, light %u: %d of %d ways are barred", runs[i].scene, light, count, WAYS);
        }
    }
    fnl_scene_destroy(&scene);
}

static uint64_t peak_bytes, live_bytes;

static void *counting_reallocate(void *user, void *old, size_t old_size, size_t new_size) {
    UNUSED(user);
    live_bytes += new_size - old_size;
    if (live_bytes > peak_bytes) peak_bytes = live_bytes;
    if (new_size == 0) {
        free(old);
        return NULL;
    }
    return realloc(old, new_size);
}

static void test_city_grows_to_what_is_asked(void **state) {
    UNUSED(state);
    const uint32_t lights[] = {4096, 65536};
    for (uint32_t i = 0; i < COUNT_OF(lights); i++) {
        char text[64];
        snprintf(text, sizeof text, "city?blocks=2&lights=%u", lights[i]);
        fnl_scene *scene = load(text);
        assert_int_equal(scene->lights.count, lights[i]);
        fnl_scene_destroy(&scene);
    }
    /* Memory is that of matrices: 64 bytes of each instance, and what an array of them grows by. */
    static const struct {
        const char *text;
        uint64_t instances, triangles, bytes; /* at least so many; at most so many bytes */
    } great[] = {{"city?blocks=1&instances=20000", 20000, 0, 60000000},
                 {"city?instances=1000000", 1000000, 0, 500000000},
                 {"city?blocks=1&triangles=1500000", 0, 1500000, 60000000},
                 {"city?triangles=100000000", 0, 100000000, 700000000}};
    for (uint32_t i = 0; i < COUNT_OF(great); i++) {
        fnl_host host = fnl_host_default();
        host.reallocate = counting_reallocate;
        fnl_scene *scene;
        peak_bytes = 0;
        assert_int_equal(builtin_load(&host, great[i].text, &scene), FNL_OK);
        fnl_scene_info info;
        assert_int_equal(fnl_scene_query_info(scene, &info), FNL_OK);
        print_message("%s: %llu instances, %llu triangles, %.0f MB\n", great[i].text,
                      (unsigned long long)info.instance_count, (unsigned long long)info.triangle_count,
                      (double)peak_bytes / 1e6);
        if (great[i].instances) assert_int_equal(info.instance_count, great[i].instances);
        /* The last thing leads beyond by less than its own triangles; the rest of the first three rings has five things a block. */
        if (great[i].triangles)
            assert_in_range(info.triangle_count, great[i].triangles, great[i].triangles + 5000);
        assert_true(info.node_count < 200);
        assert_true(peak_bytes < great[i].bytes);
        fnl_scene_destroy(&scene);
        assert_int_equal(live_bytes, 0);
    }
    fnl_scene *none;
    assert_int_equal(builtin_load(NULL, "city?triangles=1000000001", &none), FNL_ERROR_INVALID);
    assert_int_equal(builtin_load(NULL, "city?instances=16777217", &none), FNL_ERROR_INVALID);
}

/** Signed volume inside a closed mesh. */
static float volume(const struct scene_primitive *p) {
    double sum = 0;
    for (uint32_t i = 0; i < p->index_count; i += 3) {
        const vec3 *a = p->positions;
        const uint32_t *v = p->indices + i;
        sum += (double)vec3_dot(a[v[0]], vec3_cross(a[v[1]], a[v[2]])) / 6;
    }
    return (float)sum;
}

static void check_volume(struct mesh_builder *m, float expected) {
    fnl_scene *scene = m->builtin->scene;
    uint32_t mesh = mesh_end(m, "shape");
    const struct scene_primitive *p = &scene->primitives.data[scene->meshes.data[mesh].first_primitive];
    check_primitive(scene, p);
    float v = volume(p);
    if (fabsf(v - expected) > 1e-3f * fabsf(expected)) fail_msg("volume %g, expected %g", (double)v, (double)expected);
}

/** Closed shapes hold their closed-form volume; a hole or a turned face would change it. */
static void test_shapes_are_closed(void **state) {
    UNUSED(state);
    struct builtin b = {0};
    assert_int_equal(scene_create(NULL, "test", &b.scene), FNL_OK);
    struct mesh_builder m;
    mesh_begin(&m, &b);
    mesh_material(&m, builtin_plain(&b, "m", vec3_make(1, 1, 1), 0, 1));
    mesh_box(&m, vec3_make(1, 2, 3), vec3_make(2, 4, 7), FACE_ALL);
    check_volume(&m, 8);
    mesh_material(&m, 0);
    mesh_bevel_box(&m, vec3_make(-1, 0, 0), vec3_make(1, 2, 2), 0.25f);
    /* Each edge loses a triangular prism; at a corner the three prisms and the tip add up to 5/6 of a cube's eighth. */
    check_volume(&m, 8 - 12 * (1.5f * 0.25f * 0.25f / 2) - 8 * (0.25f * 0.25f * 0.25f * 5 / 6));
    mesh_material(&m, 0);
    mesh_cylinder(&m, vec3_make(3, 1, 2), 1, 0, 3, 6);
    check_volume(&m, 2.5980762f);
    mesh_material(&m, 0);
    m.transform = mat4_scaling(vec3_make(-2, 1, 1)); /* mirrored */
    mesh_cylinder(&m, vec3_make(3, 1, 2), 1, 1, 2, 4);
    check_volume(&m, 8);
    mesh_material(&m, 0);
    mesh_sphere(&m, vec3_make(1, 1, 1), 1, 256);
    check_volume(&m, 4.18879f);
    mesh_material(&m, 0);
    const vec2 outline[] = {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};
    mesh_prism(&m, outline, 6, -1, 2, true);
    check_volume(&m, 9);
    fnl_scene_destroy(&b.scene);
}

/** Every sphere of influence of `onetile` shows inside tile (40, 22) of a 1280x720 picture. */
static void test_onetile_stays_in_its_tile(void **state) {
    UNUSED(state);
    fnl_scene *scene = load("onetile");
    assert_int_equal(scene->lights.count, 1000);
    float scale = 360 / tanf(0.45f);
    for (uint32_t i = 0; i < scene->lights.count; i++) {
        const fnl_light_params *l = &scene->lights.data[i].params;
        /* Half the angle under which the sphere is seen, around its centre's direction; near the axis one pixel is 1/scale.
         */
        float depth = -l->position.z, x = 640 + l->position.x / depth * scale, y = 360 - l->position.y / depth * scale;
        float radius = asinf(l->range / vec3_length(l->position)) * scale * 1.001f;
        assert_true(x - radius >= 640 && x + radius <= 656 && y - radius >= 352 && y + radius <= 368);
    }
    fnl_scene_destroy(&scene);
}

/** Is a sphere at least partly within the view of a 16:9 picture? Six-plane test without a far plane. */
static bool in_view(const fnl_camera *camera, vec3 centre, float radius) {
    mat4 view = mat4_look_at(camera->position, camera->target, camera->up);
    vec3 p = mat4_point(&view, centre);
    float up = camera->vertical_fov / 2, right = atanf(tanf(up) * 16 / 9);
    return -p.z - camera->near_distance > -radius && cosf(right) * fabsf(p.x) + sinf(right) * p.z < radius &&
           cosf(up) * fabsf(p.y) + sinf(up) * p.z < radius;
}

static void test_wall_holds_the_counts_of_the_thesis(void **state) {
    UNUSED(state);
    const uint32_t expected[4][3] = {{1500, 55, 0}, {1600, 183, 100}, {2000, 583, 500}, {2500, 1083, 1000}};
    for (uint32_t test = 0; test < 4; test++) {
        char text[32];
        snprintf(text, sizeof text, "wall?test=%u", test + 1);
        fnl_scene *scene = load(text);
        fnl_camera camera;
        assert_int_equal(fnl_scene_query_camera(scene, 0, &camera), FNL_OK);
        uint32_t visible = 0, behind = 0;
        for (uint32_t i = 0; i < scene->lights.count; i++) {
            const fnl_light_params *l = &scene->lights.data[i].params;
            if (!in_view(&camera, l->position, l->range)) continue;
            visible++;
            bool hidden = l->position.z < -20;
            behind += hidden;
            /* It reaches through the wall, and nothing else that the camera sees: the ground, the posts at z = -12. */
            if (hidden)
                assert_true(l->position.z + l->range > -20 && l->position.z + l->range < -14 && l->position.y > l->range);
        }
        assert_int_equal(scene->lights.count, expected[test][0]);
        assert_int_equal(visible, expected[test][1]);
        assert_int_equal(behind, expected[test][2]);
        fnl_scene_destroy(&scene);
    }
}

/* Few lights are already of all shapes, and most reach through their room and beyond. */
static void test_interior_has_large_lights_of_all_shapes(void **state) {
    UNUSED(state);
    static const char *const texts[] = {"interior?lights=40", "interior", "interior?lights=120",
                                        "interior?lights=120&overlap=3"};
    for (uint32_t i = 0; i < COUNT_OF(texts); i++) {
        fnl_scene *scene = load(texts[i]);
        uint32_t kinds[FNL_LIGHT_KIND_COUNT] = {0}, large = 0;
        for (uint32_t k = 0; k < scene->lights.count; k++) {
            const fnl_light_params *l = &scene->lights.data[k].params;
            kinds[l->kind]++;
            large += l->range + (l->kind == FNL_LIGHT_CAPSULE ? 0.5f * l->length : 0) >= 5;
        }
        for (int kind = FNL_LIGHT_POINT; kind < FNL_LIGHT_KIND_COUNT; kind++) assert_true(kinds[kind] >= 4 || kind == FNL_LIGHT_RECTANGLE);
        assert_true(kinds[FNL_LIGHT_DIRECTIONAL] == 0 && large * 10 >= scene->lights.count * 7);
        fnl_scene_destroy(&scene);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_scene_is_sound_and_the_same_twice),
        cmocka_unit_test(test_light_counts_are_exact),
        cmocka_unit_test(test_wrong_names_and_keys_are_explained),
        cmocka_unit_test(test_running_out_of_memory_is_an_error),
        cmocka_unit_test(test_hall_is_of_the_stated_size),
        cmocka_unit_test(test_lamps_let_their_light_out),
        cmocka_unit_test(test_city_grows_to_what_is_asked),
        cmocka_unit_test(test_shapes_are_closed),
        cmocka_unit_test(test_onetile_stays_in_its_tile),
        cmocka_unit_test(test_wall_holds_the_counts_of_the_thesis),
        cmocka_unit_test(test_interior_has_large_lights_of_all_shapes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
