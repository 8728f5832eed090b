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

enum { LIGHT_VALUES = 23 };

static void light_values(const fnl_light_params *l, float out[LIGHT_VALUES]) {
    const float values[LIGHT_VALUES] = {
        (float)l->kind, l->position.x, l->position.y, l->position.z, l->direction.x, l->direction.y, l->direction.z, l->color[0], l->color[1],
        l->color[2], l->intensity, l->range, l->inner_cone_angle, l->outer_cone_angle, l->up.x, l->up.y, l->up.z, l->length, l->box_size.x,
        l->box_size.y, l->box_size.z, l->wedge_angles[0], l->wedge_angles[1]};
    memcpy(out, values, sizeof values);
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
        float values[LIGHT_VALUES];
        light_values(&scene->lights.data[i].params, values);
        h = hash_bytes(values, sizeof values, h);
    }
    return h;
}

/* ---- what the scenes are ---- */

/** Sum of a scene's numbers, with varying weights so that order matters; `most`: absolute, unweighted. */
struct sum {
    double total, most;
    uint32_t count;
};

static void sum_floats(struct sum *sum, const float *values, uint32_t count) {
    for (uint32_t i = 0; i < count; i++) {
        const double weight = 1 + (sum->count++ * 40503u & 0xffff) / 65536.0;
        sum->total += weight * (double)values[i];
        sum->most += fabs((double)values[i]);
    }
}

enum { MESHES, PLACES, MATERIALS, IMAGES, LIGHTS, DECALS, SUMS };

static void sum_scene(const fnl_scene *scene, struct sum sums[SUMS]) {
    memset(sums, 0, SUMS * sizeof *sums);
    for (uint32_t i = 0; i < scene->primitives.count; i++) {
        const struct scene_primitive *p = &scene->primitives.data[i];
        const float numbers[3] = {(float)p->index_count, (float)p->vertex_count, (float)p->material};
        sum_floats(&sums[MESHES], numbers, 3);
        for (uint32_t v = 0; v < p->vertex_count; v++) {
            const float values[8] = {p->positions[v].x, p->positions[v].y, p->positions[v].z, p->normals[v].x, p->normals[v].y, p->normals[v].z, p->uv[0][v].x, p->uv[0][v].y};
            sum_floats(&sums[MESHES], values, 8);
        }
    }
    for (uint32_t i = 0; i < scene->nodes.count; i++) {
        const struct scene_node *node = &scene->nodes.data[i];
        if (node->mesh == SCENE_NONE) continue;
        const float mesh = (float)node->mesh;
        sum_floats(&sums[PLACES], &mesh, 1);
        sum_floats(&sums[PLACES], node->world.m, 16);
        for (uint32_t k = 0; k < node->instance_count && node->instances; k++) sum_floats(&sums[PLACES], node->instances[k].m, 16);
    }
    for (uint32_t i = 0; i < scene->materials.count; i++) {
        const struct scene_material *m = &scene->materials.data[i];
        const float values[] = {m->base_color.x, m->base_color.y, m->base_color.z, m->base_color.w, m->metallic, m->roughness, m->emissive.x, m->emissive.y, m->emissive.z,
                                (float)m->alpha_mode, m->alpha_cutoff, m->double_sided, m->normal_scale, m->clearcoat.strength, m->transmission.strength};
        sum_floats(&sums[MATERIALS], values, COUNT_OF(values));
    }
    for (uint32_t i = 0; i < scene->images.count; i++) {
        const struct scene_image *image = &scene->images.data[i];
        for (uint32_t k = 0; k < image->width * image->height * 4; k++) {
            const float value = (float)((const uint8_t *)image->pixels)[k];
            sum_floats(&sums[IMAGES], &value, 1);
        }
    }
    for (uint32_t i = 0; i < scene->lights.count; i++) {
        float values[LIGHT_VALUES];
        light_values(&scene->lights.data[i].params, values);
        for (int k = 0; k < LIGHT_VALUES; k++) values[k] = fminf(values[k], 1e5f); /* a sun reaches everywhere */
        sum_floats(&sums[LIGHTS], values, LIGHT_VALUES);
    }
    for (uint32_t i = 0; i < scene->decals.count; i++) {
        const fnl_decal_params *d = &scene->decals.data[i].params;
        const float values[] = {(float)d->kind, d->color[0], d->color[1], d->color[2], d->color[3], (float)d->channels, scene->decals.data[i].node == SCENE_NONE ? -1 : (float)scene->decals.data[i].node};
        sum_floats(&sums[DECALS], values, COUNT_OF(values));
        sum_floats(&sums[DECALS], d->transform.m, 16);
    }
    for (uint32_t i = 0; i < scene->cameras.count; i++) {
        fnl_camera camera;
        assert_int_equal(fnl_scene_query_camera(scene, i, &camera), FNL_OK);
        const float values[] = {camera.position.x, camera.position.y, camera.position.z, camera.target.x, camera.target.y, camera.target.z, camera.vertical_fov};
        sum_floats(&sums[PLACES], values, COUNT_OF(values));
    }
}

/*
 * Pictures of built-in scenes are compared over years, so a scene change fails here and belongs in the changelog.
 * Tolerance: 2e-6 of the absolute sum, as sinf varies in the last bit between systems. To accept a change, copy the
 * printed row.
 */
static void test_scenes_are_what_they_were(void **state) {
    UNUSED(state);
    static const struct {
        const char *text;
        uint32_t counts[SUMS];
        double sums[SUMS];
    } rows[] = {
        {"city", {348527, 327222, 1230, 24117248, 94208, 0}, {574519.8396, 366170.7829, 7213.681419, 5882491902, 2090426.097, 0}},
        {"city?seed=7&blocks=2&lights=500&decals=40&sun=50000", {348527, 96902, 1230, 27262976, 11523, 920}, {574519.8396, 107684.7112, 7213.681419, 6463698141, 690734.9038, -718.2261654}},
        {"city?instances=20000&triangles=3000000", {348527, 454535, 1230, 24117248, 94208, 0}, {574519.8396, -110394.5639, 7213.681419, 5882491902, 2090426.097, 0}},
        {"hall", {207696, 14680, 270, 14155776, 23552, 0}, {290826.7484, 10627.78174, 2215.205276, 3790790071, 44920.64986, 0}},
        {"hall?overdraw=1&lights=30", {10556625, 23464, 270, 14155776, 690, 0}, {19065412.3, 1472790.523, 2215.205276, 3790790071, 1612.84295, 0}},
        {"hall?decals=200&lights=3&sun=1000", {207696, 4423, 270, 17301504, 92, 4600}, {290826.7484, 3312.390453, 2215.205276, 4369728762, 146193.6384, 5645.562638}},
        {"interior", {135157, 2954, 330, 11010048, 2208, 0}, {114690.9478, -2650.381946, 889.6972434, 2957570492, 71370.23862, 0}},
        {"interior?overlap=3", {135157, 2954, 330, 11010048, 2208, 0}, {114690.9478, -2650.381946, 889.6972434, 2957570492, 211932.8595, 0}},
        {"wall", {9810, 578, 90, 11010048, 34500, 0}, {14670.60512, 650.477332, 66.04926067, 2882750871, 235195.2598, 0}},
        {"wall?test=2", {9810, 578, 90, 11010048, 36800, 0}, {14670.60512, 650.477332, 66.04926067, 2882750871, 262569.2021, 0}},
        {"wall?test=3", {9810, 578, 90, 11010048, 46000, 0}, {14670.60512, 650.477332, 66.04926067, 2882750871, 375047.8652, 0}},
        {"wall?test=4", {9810, 578, 90, 11010048, 57500, 0}, {14670.60512, 650.477332, 66.04926067, 2882750871, 517936.7549, 0}},
        {"room", {3250, 92, 90, 1572864, 69, 0}, {2659.193289, 50.0473258, 58.72898124, 423403848.7, 41942.73676, 0}},
        {"room?cave=50&moving=1", {100917, 109, 90, 1572864, 69, 0}, {175858.4065, 61.3642873, 58.72898124, 423403848.7, 41942.73676, 0}},
        {"spheres", {846925, 806, 705, 3932160, 1472, 0}, {721453.9145, 2048.173042, 386.904205, 1014552581, 3147.495985, 0}},
        {"spheres?segments=9&lights=7", {29005, 806, 705, 3932160, 161, 0}, {22446.07624, 2048.173042, 386.904205, 1014552581, 499.9372159, 0}},
        {"pole", {1641, 58, 45, 4718592, 5888, 0}, {1295.489135, 9.049263124, 32.01929174, 1260059188, 59306.07586, 0}},
        {"lamps", {1833, 4137, 45, 3932160, 5888, 0}, {-542.2510123, -193400.2102, 1097.392009, 921938155.1, -127767.7536, 0}},
        {"grass", {134, 384041, 30, 1572864, 11776, 0}, {211.1021416, -664330.8098, 24.48305511, 350276268.2, 17349.615, 0}},
        {"grass?lights=17&sun=900", {134, 384041, 30, 1572864, 414, 0}, {211.1021416, -664330.8098, 24.48305511, 350276268.2, 146748.1049, 0}},
        {"onetile", {35, 24, 15, 786432, 23000, 0}, {82.14752197, 6.509474153, 10.27685547, 231734338.9, -8283.153532, 0}},
        {"nearplane", {18889, 138, 45, 9437184, 5888, 0}, {16285.69068, 17.11878503, 32.91458893, 2503249665, 6442.034433, 0}},
        {"sky", {9222, 136, 30, 1572864, 5888, 0}, {7403.46515, -232.845288, 18.99957002, 416240768.1, 53684.16727, 0}},
        {"glass", {12662, 177, 165, 4718592, 5888, 0}, {8477.15991, 40.91273586, 114.5084022, 1238064605, 6893.73801, 0}},
        {"glass?crossing=1", {22338, 245, 225, 4718592, 5888, 0}, {16700.35843, 111.2553842, 154.316088, 1238064605, 6893.73801, 0}},
    };
    static const char *const names[SUMS] = {"meshes", "places", "materials", "images", "lights", "decals"};
    bool good = true;
    for (uint32_t i = 0; i < COUNT_OF(rows); i++) {
        struct sum sums[SUMS];
        fnl_scene *scene = load(rows[i].text);
        sum_scene(scene, sums);
        fnl_scene_destroy(&scene);
        bool same = true;
        for (int k = 0; k < SUMS; k++) {
            const bool as_before = sums[k].count == rows[i].counts[k] && fabs(sums[k].total - rows[i].sums[k]) <= 2e-6 * sums[k].most;
            if (!as_before) print_error("%s: other %s: %.10g, not %.10g, of %.4g\n", rows[i].text, names[k], sums[k].total, rows[i].sums[k], sums[k].most);
            same = same && as_before;
        }
        good = good && same;
        if (!same)
            print_error("{\"%s\", {%u, %u, %u, %u, %u, %u}, {%.10g, %.10g, %.10g, %.10g, %.10g, %.10g}},\n", rows[i].text, sums[0].count, sums[1].count, sums[2].count,
                        sums[3].count, sums[4].count, sums[5].count, sums[0].total, sums[1].total, sums[2].total, sums[3].total, sums[4].total, sums[5].total);
    }
    assert_true(good);
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
        cmocka_unit_test(test_scenes_are_what_they_were),
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
