/* SPDX-License-Identifier: MIT */
/** The stage (fanal/stage.h): pictures show it, the scene does not know of it, and it costs nothing where it is off. */
#include "render/shading.h"
#include "fanal/options.h"
#include "tests/coarse_cases.h"

#include <unistd.h>

/* A white ball of radius 1 on nothing, without light. */
static struct stage open_ball(void) {
    fnl_scene *scene = coarse_scene();
    coarse_add_sphere(scene, coarse_plain(scene), 1);
    struct stage s = stage_open_scene(scene);
    s.frame.camera = fnl_camera_default();
    s.frame.camera.position = (fnl_vec3){0, 2.5f, 5};
    s.frame.camera.target = (fnl_vec3){0, -0.5f, 0};
    s.frame.exposure = FNL_EXPOSURE_NONE;
    s.frame.outputs = FNL_OUTPUT_RADIANCE;
    return s;
}

static fnl_frame staged(const struct stage *s) {
    fnl_frame frame = s->frame;
    frame.studio = true;
    frame.ground = FNL_GROUND_AUTO;
    frame.background = FNL_BACKGROUND_AUTO;
    frame.shadows = FNL_SHADOWS_MAPS;
    return frame;
}

static const float *pixel(const struct shot *shot, uint32_t x, uint32_t y) {
    return (const float *)shot->radiance.pixels + 4 * ((size_t)y * shot->radiance.width + x);
}

static bool same(const struct shot *a, const struct shot *b) {
    return memcmp(a->radiance.pixels, b->radiance.pixels, 16ull * a->radiance.width * a->radiance.height) == 0;
}

static double mean_of(const struct shot *shot) {
    double sum = 0;
    const size_t count = (size_t)shot->radiance.width * shot->radiance.height;
    for (size_t i = 0; i < count; i++) sum += (double)((const float *)shot->radiance.pixels)[4 * i + 1];
    return sum / (double)count;
}

/* ---- what a scene knows of it ---- */

struct known {
    fnl_scene_info info;
    uint32_t counts[FNL_ENTITY_COUNT];
    fnl_camera framing;
    uint64_t saved;
};

static struct known know(const fnl_scene *scene) {
    struct known k;
    memset(&k, 0, sizeof k);
    char path[64];
    struct file_view file;
    assert_int_equal(fnl_scene_query_info(scene, &k.info), FNL_OK);
    for (int kind = 0; kind < FNL_ENTITY_COUNT; kind++) {
        k.counts[kind] = fnl_scene_count(scene, (fnl_entity)kind);
        for (uint32_t i = 0; i < k.counts[kind]; i++) {
            fnl_entity_info entity;
            assert_int_equal(fnl_scene_query_entity(scene, (fnl_entity)kind, i, &entity), FNL_OK);
            assert_true(strcmp(entity.name, "ground") != 0);
        }
    }
    assert_int_equal(fnl_scene_query_framing_camera(scene, 1.5f, &k.framing), FNL_OK);
    snprintf(path, sizeof path, "/tmp/fanal-stage-%d.glb", (int)getpid());
    assert_int_equal(fnl_scene_save(scene, path, NULL), FNL_OK);
    assert_int_equal(file_load(&scene->host, path, &file), FNL_OK);
    k.saved = hash_bytes(file.data, file.size, HASH_SEED);
    file_free(&scene->host, &file);
    unlink(path);
    return k;
}

static void test_scenes_do_not_know_of_it(void **state) {
    UNUSED(state);
    struct stage s = open_ball();
    const struct known before = know(s.scene);
    fnl_frame frame = staged(&s);
    frame.outputs |= FNL_OUTPUT_OBJECT;
    struct shot shot = stage_shoot(&s, &frame);
    const struct known after = know(s.scene);
    assert_memory_equal(&before.info, &after.info, sizeof before.info);
    assert_memory_equal(before.counts, after.counts, sizeof before.counts);
    assert_memory_equal(&before.framing, &after.framing, sizeof before.framing);
    assert_int_equal(before.saved, after.saved);
    fnl_environment_params environment;
    assert_int_equal(fnl_scene_query_environment(s.scene, &environment), FNL_ERROR_INVALID);
    /* The floor shows, but is no object; the ball is. */
    fnl_image objects;
    assert_int_equal(fnl_renderer_read(s.renderer, FNL_OUTPUT_OBJECT, &objects), FNL_OK);
    const float *floor = (const float *)objects.pixels + 4 * (50 * 113 + 10), *ball = (const float *)objects.pixels + 4 * (25 * 113 + 56);
    assert_true(floor[0] == 0 && ball[0] == 1 && ball[2] == 0);
    fnl_image_free(gpu_host(harness_device()), &objects);
    shot_free(&shot);

    /* What is added later has the index that follows, for all calls and outputs. */
    fnl_scene_info info;
    fnl_material_params look = fnl_material_params_default();
    fnl_material_id material;
    look.base_color[0] = 0.25f;
    assert_int_equal(fnl_scene_add_material(s.scene, &look, &material), FNL_OK);
    coarse_add_plane(s.scene, material, -3, 3, -1, 0, 0);
    assert_int_equal(fnl_scene_query_info(s.scene, &info), FNL_OK);
    assert_int_equal(info.material_count, before.info.material_count + 1);
    assert_int_equal(info.mesh_count, before.info.mesh_count + 1);
    fnl_material_params found;
    fnl_mesh_info mesh;
    assert_int_equal(fnl_scene_query_material(s.scene, info.material_count - 1, &found), FNL_OK);
    assert_true(found.base_color[0] == 0.25f);
    assert_int_equal(fnl_scene_query_material(s.scene, info.material_count, &found), FNL_ERROR_INVALID);
    assert_int_equal(fnl_scene_query_mesh(s.scene, info.mesh_count - 1, 0, &mesh), FNL_OK);
    assert_int_equal(mesh.params.material.index, material.index);
    shot = stage_shoot(&s, &frame);
    assert_int_equal(fnl_renderer_read(s.renderer, FNL_OUTPUT_OBJECT, &objects), FNL_OK);
    uint32_t walls = 0;
    for (uint32_t i = 0; i < 113 * 65; i++) {
        const float *found_object = (const float *)objects.pixels + 4 * i;
        assert_true(found_object[0] <= 2);
        if (found_object[0] == 2) assert_true(found_object[2] == (float)(info.material_count - 1)), walls++;
    }
    assert_true(walls > 100);
    fnl_image_free(gpu_host(harness_device()), &objects);
    shot_free(&shot);
    stage_close(&s);
}

/* ---- the studio ---- */

/* The same light as that of the environment of this name, to the bit; and surroundings of the scene's own end it. */
static void test_studio_is_the_environment_of_that_name(void **state) {
    UNUSED(state);
    struct stage s = open_ball(), own = open_ball();
    fnl_environment_params params = fnl_environment_params_default();
    params.source = "builtin:studio";
    params.background = false;
    assert_int_equal(fnl_scene_set_environment(own.scene, &params), FNL_OK);
    fnl_frame frame = staged(&s), plain = s.frame;
    frame.ground = FNL_GROUND_OFF;
    frame.background = FNL_BACKGROUND_SCENE;
    plain.shadows = FNL_SHADOWS_MAPS;
    struct shot dark = stage_shoot(&s, &plain), a = stage_shoot(&s, &frame), b = stage_shoot(&own, &plain);
    assert_true(mean_of(&dark) == 0 && mean_of(&a) > 0.01);
    assert_true(same(&a, &b));
    const struct { bool light, ambient, environment; } gives[] = {{true, true, false}, {false, true, false}, {true, false, true}};
    for (uint32_t i = 0; i < COUNT_OF(gives); i++) {
        fnl_light_params light = fnl_light_params_default();
        fnl_light_id id = {0};
        light.position = (fnl_vec3){0, 3, 3};
        light.intensity = 10;
        for (int k = 0; k < 2; k++) {
            fnl_scene *scene = k ? own.scene : s.scene;
            if (k && !gives[i].environment) assert_int_equal(fnl_scene_set_environment(scene, NULL), FNL_OK);
            if (gives[i].light) assert_int_equal(fnl_scene_add_light(scene, &light, &id), FNL_OK);
            if (gives[i].ambient) assert_int_equal(fnl_scene_set_ambient(scene, (fnl_vec3){1, 2, 3}, (fnl_vec3){1, 1, 1}), FNL_OK);
            params.source = "builtin:overcast";
            if (gives[i].environment) assert_int_equal(fnl_scene_set_environment(scene, &params), FNL_OK);
            struct shot lit = stage_shoot(k ? &own : &s, k ? &plain : &frame);
            if (k) assert_true(same(&lit, &b));
            shot_free(k ? &lit : &b);
            if (!k) b = lit;
            if (gives[i].light) assert_int_equal(fnl_scene_remove_light(scene, id), FNL_OK);
            if (gives[i].ambient) assert_int_equal(fnl_scene_set_ambient(scene, (fnl_vec3){0, 0, 0}, (fnl_vec3){0, 0, 0}), FNL_OK);
            if (gives[i].environment) assert_int_equal(fnl_scene_set_environment(scene, NULL), FNL_OK);
        }
        struct shot again = stage_shoot(&s, &frame);
        assert_true(same(&again, &a));
        shot_free(&again);
    }
    shot_free(&dark);
    shot_free(&a);
    shot_free(&b);
    stage_close(&own);
    stage_close(&s);
}

/* Beside lamps: the environment of that name without its key light, as bright as the lamps on average, and it follows them. */
static void test_studio_fills_in_beside_lamps(void **state) {
    UNUSED(state);
    struct stage s = open_ball(), own = open_ball();
    fnl_frame frame = staged(&s), plain = s.frame;
    frame.ground = FNL_GROUND_OFF;
    frame.background = FNL_BACKGROUND_SCENE;
    plain.shadows = FNL_SHADOWS_MAPS;
    struct shot studio = stage_shoot(&s, &frame);
    fnl_light_params lamp = fnl_light_params_default();
    fnl_light_id ids[2];
    lamp.kind = FNL_LIGHT_DIRECTIONAL;
    lamp.direction = (fnl_vec3){0.6f, -0.8f, 0};
    lamp.intensity = 10;
    assert_int_equal(fnl_scene_add_light(s.scene, &lamp, &ids[0]), FNL_OK);
    /* The same in other words. */
    fnl_environment_params params = fnl_environment_params_default();
    params.source = "builtin:studio";
    params.background = false;
    assert_int_equal(fnl_scene_set_environment(own.scene, &params), FNL_OK);
    assert_int_equal(fnl_scene_count(own.scene, FNL_ENTITY_LIGHT), 1);
    for (int step = 0; step < 4; step++) {
        if (step == 1) lamp.intensity = 40;
        if (step >= 2) { /* from afar like a sun; from within in all directions, over the six faces of the ball's box */
            lamp.kind = FNL_LIGHT_POINT;
            lamp.position = step == 2 ? (fnl_vec3){2, 3, 2} : (fnl_vec3){0.3f, 0.2f, 0.1f};
        }
        assert_int_equal(fnl_scene_set_light(s.scene, ids[0], &lamp), FNL_OK);
        struct shot alone = stage_shoot(&s, &plain), filled = stage_shoot(&s, &frame);
        const double mean = panorama_flux(&s.scene->environment.panorama) / (4 * (double)PI), lux = step < 2 ? (double)lamp.intensity / 4 : step == 2 ? 40 / (4 * 17.0) : 40 * 4 * (double)PI / 24;
        params.intensity = s.scene->environment.intensity;
        assert_true(fabs((double)params.intensity * mean * (double)PI / lux - 1) < 1e-3);
        assert_int_equal(fnl_scene_set_environment(own.scene, &params), FNL_OK);
        fnl_entity_info key;
        for (uint32_t i = fnl_scene_count(own.scene, FNL_ENTITY_LIGHT); i-- > 0;) {
            assert_int_equal(fnl_scene_query_entity(own.scene, FNL_ENTITY_LIGHT, i, &key), FNL_OK);
            assert_int_equal(fnl_scene_remove_light(own.scene, key.id.light), FNL_OK);
        }
        assert_int_equal(fnl_scene_add_light(own.scene, &lamp, &ids[1]), FNL_OK);
        struct shot same_light = stage_shoot(&own, &plain);
        assert_true(same(&filled, &same_light));
        assert_true(mean_of(&filled) > 1.02 * mean_of(&alone));
        fnl_trace_params p = trace_plain();
        fnl_trace trace;
        p.width = 113, p.height = 65, p.camera = s.frame.camera, p.exposure = FNL_EXPOSURE_NONE, p.samples = 64;
        p.studio = true;
        p.background = FNL_BACKGROUND_SCENE;
        assert_int_equal(fnl_scene_trace(s.scene, &p, &trace), FNL_OK);
        double sum = 0;
        for (uint32_t i = 0; i < 113 * 65; i++) sum += (double)((const float *)trace.radiance.pixels)[4 * i + 1] / (113 * 65);
        print_message("intensity %.4f: frame %.4f, lamp alone %.4f, paths %.4f\n", (double)params.intensity, mean_of(&filled), mean_of(&alone), sum);
        assert_true(fabs(sum / mean_of(&filled) - 1) < 0.03);
        fnl_trace_free(&s.scene->host, &trace);
        shot_free(&filled);
        shot_free(&alone);
        shot_free(&same_light);
    }
    /* Too many lamps: none. None: the whole studio, as before. */
    struct shot few = stage_shoot(&s, &frame);
    assert_true(s.scene->environment.staged);
    shot_free(&few);
    assert_int_equal(fnl_scene_scatter_lights(s.scene, FNL_STUDIO_FILL_LIGHTS, 1), FNL_OK);
    struct shot many = stage_shoot(&s, &frame);
    assert_true(!s.scene->environment.staged && s.scene->environment.panorama.width == 0);
    shot_free(&many);
    while (fnl_scene_count(s.scene, FNL_ENTITY_LIGHT) > 0) {
        fnl_entity_info light;
        assert_int_equal(fnl_scene_query_entity(s.scene, FNL_ENTITY_LIGHT, 0, &light), FNL_OK);
        assert_int_equal(fnl_scene_remove_light(s.scene, light.id.light), FNL_OK);
    }
    struct shot again = stage_shoot(&s, &frame);
    assert_true(same(&again, &studio));
    shot_free(&again);
    shot_free(&studio);
    stage_close(&own);
    stage_close(&s);
}

static uint64_t plan_of(const struct stage *s) {
    char text[65536];
    const size_t length = fnl_renderer_print(s->renderer, FNL_PRINT_PLAN, text, sizeof text);
    assert_true(length < sizeof text);
    return hash_bytes(text, length, HASH_SEED);
}

/* A scene that has light and surroundings: the same passes, bytes and pictures with the stage as without. */
static void test_it_costs_nothing_where_it_is_not_needed(void **state) {
    UNUSED(state);
    struct stage s = open_ball();
    coarse_add_light(s.scene, FNL_LIGHT_POINT, (vec3){2, 3, 2}, 50);
    assert_int_equal(fnl_scene_set_ambient(s.scene, (fnl_vec3){0.1f, 0.1f, 0.1f}, (fnl_vec3){0.1f, 0.1f, 0.1f}), FNL_OK);
    fnl_frame with = staged(&s), without = s.frame;
    without.shadows = with.shadows;
    struct shot a = stage_shoot(&s, &without);
    for (int i = 0; i < 2; i++) { /* until pools have their sizes */
        shot_free(&a);
        a = stage_shoot(&s, &without);
    }
    const uint64_t plan = plan_of(&s), bytes = a.stats.device_bytes;
    struct shot b = stage_shoot(&s, &with);
    assert_true(same(&a, &b));
    assert_true(plan_of(&s) == plan);
    assert_int_equal(b.stats.device_bytes, bytes);
    shot_free(&a);
    shot_free(&b);
    stage_close(&s);
}

/* ---- the floor ---- */

static struct shot shoot_lit(struct stage *s, fnl_ground ground, fnl_shading shading, fnl_shadows shadows) {
    fnl_frame frame = s->frame;
    frame.ground = ground;
    frame.shading = shading;
    frame.shadows = shadows;
    return stage_shoot(s, &frame);
}

/* Where a point of the world is in the picture. */
static const float *pixel_at(const struct shot *shot, const fnl_camera *camera, vec3 point) {
    const mat4 view = mat4_look_at(camera->position, camera->target, camera->up);
    const vec3 p = mat4_point(&view, point);
    const float y = p.y / (-p.z * tanf(camera->vertical_fov / 2)), x = p.x / (-p.z * tanf(camera->vertical_fov / 2) * 113 / 65.0f);
    return pixel(shot, (uint32_t)((x + 1) / 2 * 113), (uint32_t)((1 - y) / 2 * 65));
}

/* A sun from the left: the floor is lit on that side, in shadow on the other; on every path, and for rays on the CPU. */
static void test_floor_catches_shadows_on_every_path(void **state) {
    UNUSED(state);
    struct stage s = open_ball();
    fnl_light_params sun = fnl_light_params_default();
    fnl_light_id id;
    sun.kind = FNL_LIGHT_DIRECTIONAL;
    sun.direction = (fnl_vec3){0.6f, -0.8f, 0};
    sun.intensity = 10;
    assert_int_equal(fnl_scene_add_light(s.scene, &sun, &id), FNL_OK);
    struct shot reference = shoot_lit(&s, FNL_GROUND_ON, FNL_SHADING_FORWARD, FNL_SHADOWS_RAYS);
    const fnl_camera *camera = &s.frame.camera;
    const vec3 here = {-2.5f, -1, 0.5f}, hidden = {1.5f, -1, 0.3f};
    const float *lit = pixel_at(&reference, camera, here), *shadow = pixel_at(&reference, camera, hidden), *above = pixel(&reference, 10, 2);
    const size_t lit_at = (size_t)(lit - (const float *)reference.radiance.pixels), shadow_at = (size_t)(shadow - (const float *)reference.radiance.pixels);
    print_message("floor %g, in shadow %g\n", (double)lit[1], (double)shadow[1]);
    assert_true(lit[1] > 0.4f && shadow[1] < 0.02f * lit[1] && above[1] == 0);
    for (int shading = 0; shading < FNL_SHADING_AUTO; shading++) {
        if (!fnl_shading_supports((fnl_shading)shading, FNL_LISTS_CLUSTERED, 1)) continue;
        struct shot shot = shoot_lit(&s, FNL_GROUND_ON, (fnl_shading)shading, FNL_SHADOWS_MAPS);
        const float *there = pixel_at(&shot, camera, here), *dark = pixel_at(&shot, camera, hidden);
        if (fabsf(there[1] / lit[1] - 1) > 0.02f || dark[1] > (shading == FNL_SHADING_INFERRED ? 0.1f : 0.02f) * lit[1]) /* which interpolates light */
            fail_msg("%s: the floor is %g, in shadow %g, must be %g and about 0", fnl_value_name(FNL_ENUM_SHADING, (uint32_t)shading), (double)there[1], (double)dark[1], (double)lit[1]);
        shot_free(&shot);
    }
    fnl_trace_params p = trace_plain();
    fnl_trace trace;
    p.width = 113, p.height = 65, p.camera = s.frame.camera, p.exposure = FNL_EXPOSURE_NONE;
    p.ground = FNL_GROUND_ON;
    assert_int_equal(fnl_scene_trace(s.scene, &p, &trace), FNL_OK);
    const float *traced = (const float *)trace.radiance.pixels;
    assert_true(fabsf(traced[lit_at + 1] / lit[1] - 1) < 0.01f && traced[shadow_at + 1] < 0.02f * lit[1]);
    fnl_trace_free(&s.scene->host, &trace);
    /* Off again: nothing of it is left. */
    struct shot off = shoot_lit(&s, FNL_GROUND_OFF, FNL_SHADING_FORWARD, FNL_SHADOWS_RAYS);
    assert_true(pixel_at(&off, camera, here)[1] == 0 && pixel_at(&off, camera, hidden)[1] == 0);
    shot_free(&off);
    shot_free(&reference);
    stage_close(&s);
}

/* Auto: not under a plane, nor in a scene with surroundings of its own; and it stays where it is while things move. */
static void test_floor_by_itself(void **state) {
    UNUSED(state);
    struct stage s = open_ball();
    fnl_frame frame = staged(&s);
    struct shot shot = stage_shoot(&s, &frame);
    const struct scene_node *floor = &s.scene->nodes.data[s.scene->stage.node];
    const mat4 place = floor->world;
    assert_true(scene_node_draws(floor) && fabsf(place.m[13] + 1) < 0.01f);
    shot_free(&shot);
    const fnl_instance_id ball = {0, s.scene->nodes.data[0].generation};
    const fnl_mat4 up = mat4_translation(vec3_make(0, 3, 0));
    assert_int_equal(fnl_scene_set_instance_transforms(s.scene, &ball, &up, 1), FNL_OK);
    shot = stage_shoot(&s, &frame);
    assert_memory_equal(&s.scene->nodes.data[s.scene->stage.node].world, &place, sizeof place);
    shot_free(&shot);
    /* Its own floor, a little larger than the ball. */
    const float positions[] = {-2, 0, -2, 2, 0, -2, 2, 0, 2, -2, 0, 2};
    const uint32_t indices[] = {0, 2, 1, 0, 3, 2};
    const fnl_mesh_params plane = {.vertex_count = 4, .index_count = 6, .positions = positions, .indices = indices};
    const fnl_mat4 identity = mat4_identity();
    fnl_mesh_id mesh;
    fnl_instance_id instance;
    assert_int_equal(fnl_scene_add_mesh(s.scene, &plane, &mesh), FNL_OK);
    assert_int_equal(fnl_scene_add_instance(s.scene, mesh, &identity, &instance), FNL_OK);
    shot = stage_shoot(&s, &frame);
    assert_false(scene_node_draws(&s.scene->nodes.data[s.scene->stage.node]));
    shot_free(&shot);
    assert_int_equal(fnl_scene_remove_instance(s.scene, instance), FNL_OK);
    shot = stage_shoot(&s, &frame);
    assert_true(scene_node_draws(&s.scene->nodes.data[s.scene->stage.node]));
    assert_true(s.scene->nodes.data[s.scene->stage.node].world.m[13] > 1.9f); /* under the ball as it is now */
    shot_free(&shot);
    /* A plane at half the height is no floor, wherever the scene is. */
    const fnl_mat4 away = mat4_translation(vec3_make(-200, 3, 0));
    assert_int_equal(fnl_scene_set_instance_transforms(s.scene, &ball, &away, 1), FNL_OK);
    assert_int_equal(fnl_scene_add_instance(s.scene, mesh, &away, &instance), FNL_OK);
    shot = stage_shoot(&s, &frame);
    assert_true(scene_node_draws(&s.scene->nodes.data[s.scene->stage.node]));
    shot_free(&shot);
    assert_int_equal(fnl_scene_remove_instance(s.scene, instance), FNL_OK);
    assert_int_equal(fnl_scene_set_instance_transforms(s.scene, &ball, &up, 1), FNL_OK);
    coarse_add_light(s.scene, FNL_LIGHT_POINT, (vec3){2, 3, 2}, 50);
    shot = stage_shoot(&s, &frame);
    assert_true(scene_node_draws(&s.scene->nodes.data[s.scene->stage.node]));
    shot_free(&shot);
    assert_int_equal(fnl_scene_set_ambient(s.scene, (fnl_vec3){1, 1, 1}, (fnl_vec3){1, 1, 1}), FNL_OK);
    shot = stage_shoot(&s, &frame);
    assert_false(scene_node_draws(&s.scene->nodes.data[s.scene->stage.node]));
    shot_free(&shot);
    stage_close(&s);
}

/* ---- backgrounds ---- */

/* Each kind on every path is what rays see; a blur of no angle is the environment, one of all around nearly even. */
static void test_backgrounds_are_those_of_rays(void **state) {
    UNUSED(state);
    struct stage s = open_ball();
    fnl_environment_params params = fnl_environment_params_default();
    params.source = "builtin:overcast";
    assert_int_equal(fnl_scene_set_environment(s.scene, &params), FNL_OK);
    s.frame.camera.target = (fnl_vec3){0, 2.5f, 0};
    const struct { fnl_background kind; float blur; } kinds[] = {{FNL_BACKGROUND_SCENE, 0}, {FNL_BACKGROUND_GRADIENT, 0}, {FNL_BACKGROUND_BLUR, 0}, {FNL_BACKGROUND_BLUR, 0.5f}, {FNL_BACKGROUND_BLUR, 3}};
    struct shot first = {0};
    for (uint32_t k = 0; k < COUNT_OF(kinds); k++) {
        fnl_trace_params p = trace_plain();
        fnl_trace trace;
        p.width = 113, p.height = 65, p.camera = s.frame.camera, p.exposure = FNL_EXPOSURE_NONE, p.samples = 16;
        p.background = kinds[k].kind, p.background_blur = kinds[k].blur;
        assert_int_equal(fnl_scene_trace(s.scene, &p, &trace), FNL_OK);
        for (int shading = 0; shading < FNL_SHADING_AUTO; shading += k == 1 ? 1 : 5) {
            fnl_frame frame = s.frame;
            frame.shading = (fnl_shading)shading;
            frame.background = kinds[k].kind, frame.background_blur = kinds[k].blur;
            if (!fnl_shading_supports((fnl_shading)shading, frame.lists, 1)) continue;
            struct shot shot = stage_shoot(&s, &frame);
            double worst = 0, sum = 0;
            for (uint32_t y = 1; y < 64; y += 6)
                for (uint32_t x = 1; x < 20; x += 6) {
                    const double here = (double)pixel(&shot, x, y)[1], there = (double)((const float *)trace.radiance.pixels)[4 * (y * 113 + x) + 1];
                    worst = fmax(worst, fabs(here / there - 1));
                    sum += here;
                }
            if (worst > (kinds[k].kind == FNL_BACKGROUND_BLUR ? 0.25 : 0.03) || !(sum > 0)) /* mips have texels of degrees */
                fail_msg("%s, %s %g: up to %g off", fnl_value_name(FNL_ENUM_SHADING, (uint32_t)shading), fnl_value_name(FNL_ENUM_BACKGROUND, kinds[k].kind), (double)kinds[k].blur, worst);
            if (k == 0 && shading == 0) first = shot;
            else {
                if (k == 2 && shading == 0) assert_true(same(&first, &shot));
                if (k == 4) { /* the horizon is no edge any more */
                    const float sharp = pixel(&first, 5, 20)[1] / pixel(&first, 5, 44)[1], soft = pixel(&shot, 5, 20)[1] / pixel(&shot, 5, 44)[1];
                    print_message("across the horizon: %g, blurred %g\n", (double)sharp, (double)soft);
                    assert_true(sharp > 1.5f && soft - 1 < 0.5f * (sharp - 1));
                }
                shot_free(&shot);
            }
        }
        fnl_trace_free(&s.scene->host, &trace);
    }
    shot_free(&first);
    stage_close(&s);
}

/* ---- samples ---- */

/* What auto comes to with each path and option, in the numbers of the frame: never an error that the same frame with 1 sample does not have. */
static void test_samples_by_themselves(void **state) {
    UNUSED(state);
    struct stage s = open_ball();
    for (int shading = 0; shading < FNL_SHADING_AUTO; shading++) {
        fnl_frame frame = s.frame;
        frame.shading = (fnl_shading)shading;
        frame.msaa = FNL_MSAA_AUTO;
        frame.aa = FNL_ANTIALIASING_AUTO;
        if (!fnl_shading_supports((fnl_shading)shading, frame.lists, 1)) continue;
        struct shot shot = stage_shoot(&s, &frame);
        const bool several = fnl_shading_supports((fnl_shading)shading, frame.lists, 4);
        assert_int_equal(s.renderer->frame.msaa, several ? 4 : 1);
        assert_int_equal(s.renderer->frame.aa, several ? FNL_ANTIALIASING_NONE : FNL_ANTIALIASING_SMAA);
        shot_free(&shot);
    }
    const struct { const char *key, *value; uint32_t msaa; fnl_antialiasing aa; } options[] = {
        {"aa", "taa", 1, FNL_ANTIALIASING_TAA},   {"aa", "none", 4, FNL_ANTIALIASING_NONE}, {"aa", "smaa", 4, FNL_ANTIALIASING_SMAA},
        {"msaa", "1", 1, FNL_ANTIALIASING_SMAA},  {"msaa", "4", 4, FNL_ANTIALIASING_NONE},  {"debug", "motion", 1, FNL_ANTIALIASING_SMAA},
        {"decals", "gbuffer", 1, FNL_ANTIALIASING_SMAA}};
    for (uint32_t i = 0; i < COUNT_OF(options); i++) {
        fnl_frame frame = s.frame;
        frame.shading = FNL_SHADING_DEFERRED;
        frame.msaa = FNL_MSAA_AUTO;
        frame.aa = FNL_ANTIALIASING_AUTO;
        assert_int_equal(fnl_frame_set(NULL, &frame, options[i].key, options[i].value), FNL_OK);
        struct shot shot = stage_shoot(&s, &frame);
        assert_int_equal(s.renderer->frame.msaa, options[i].msaa);
        assert_int_equal(s.renderer->frame.aa, options[i].aa);
        shot_free(&shot);
    }
    stage_close(&s);
}

/* What the default frame of C shows of a model without light: as the command does. */
static void test_default_frame_shows_a_model(void **state) {
    UNUSED(state);
    struct stage s = open_ball();
    fnl_frame frame = fnl_frame_default();
    frame.width = 113, frame.height = 65;
    frame.lists = FNL_LISTS_CLUSTERED;
    frame.timers = false;
    assert_int_equal(fnl_scene_query_framing_camera(s.scene, 113 / 65.0f, &frame.camera), FNL_OK);
    struct shot shot = stage_shoot(&s, &frame);
    uint64_t sum = 0;
    uint32_t count = 0;
    for (uint32_t y = 0; y < 65; y++)
        for (uint32_t x = 0; x < 113; x++) {
            const int dx = (int)x - 56, dy = (int)y - 32;
            if (dx * dx + dy * dy > 22 * 22) continue;
            sum += ((const uint8_t *)shot.color.pixels)[4 * (y * 113 + x) + 1];
            count++;
        }
    print_message("mean of the ball: %g of 255\n", (double)sum / count);
    assert_true(sum > 70ull * count && sum < 150ull * count);
    assert_int_equal(s.renderer->frame.msaa, 4);
    shot_free(&shot);
    stage_close(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_scenes_do_not_know_of_it, harness_check),
        cmocka_unit_test_teardown(test_studio_is_the_environment_of_that_name, harness_check),
        cmocka_unit_test_teardown(test_studio_fills_in_beside_lamps, harness_check),
        cmocka_unit_test_teardown(test_it_costs_nothing_where_it_is_not_needed, harness_check),
        cmocka_unit_test_teardown(test_floor_catches_shadows_on_every_path, harness_check),
        cmocka_unit_test_teardown(test_floor_by_itself, harness_check),
        cmocka_unit_test_teardown(test_backgrounds_are_those_of_rays, harness_check),
        cmocka_unit_test_teardown(test_samples_by_themselves, harness_check),
        cmocka_unit_test_teardown(test_default_frame_shows_a_model, harness_check),
    };
    return cmocka_run_group_tests_name("stage", tests, harness_begin, harness_end);
}
