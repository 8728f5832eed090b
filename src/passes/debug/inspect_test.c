/* SPDX-License-Identifier: MIT */
/** The pixel that a frame is asked for: against lights found on the CPU, the counters of shading, the picture, and shadows whose edges are known. */
#include "render/shading.h"
#include "tests/render_test.h"

enum { WIDTH = 57, HEIGHT = 33, LIGHTS = 120 };

static fnl_pixel_info ask(fnl_renderer *renderer, const fnl_frame *frame, uint32_t x, uint32_t y) {
    fnl_frame asking = *frame;
    fnl_pixel_info info;
    asking.pixel.asked = true;
    asking.pixel.x = x;
    asking.pixel.y = y;
    assert_int_equal(fnl_renderer_render(renderer, &asking), FNL_OK);
    assert_int_equal(fnl_renderer_query_pixel(renderer, &info), FNL_OK);
    assert_true(info.query.asked && info.query.x == x && info.query.y == y && info.query.view == asking.pixel.view);
    return info;
}

/* Whether a light reaches a point: 1 yes, 0 no, -1 too close to tell. */
static int reaches(const fnl_light_params *light, fnl_vec3 p) {
    const double d[3] = {(double)p.x - (double)light->position.x, (double)p.y - (double)light->position.y, (double)p.z - (double)light->position.z};
    const double distance = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]), range = (double)fnl_light_range(light, 1, 0.05f);
    if (fabs(distance / range - 1) < 1e-4) return -1;
    if (distance > range || light->intensity <= 0) return 0;
    if (light->kind != FNL_LIGHT_SPOT) return 1;
    const double angle =
        acos((d[0] * (double)light->direction.x + d[1] * (double)light->direction.y + d[2] * (double)light->direction.z) / fmax(distance, 1e-9));
    if (fabs(angle - (double)light->outer_cone_angle) < 1e-3) return -1;
    return angle < (double)light->outer_cone_angle;
}

static const fnl_pixel_light *find_light(const fnl_pixel_info *info, uint32_t index) {
    for (uint32_t i = 0; i < info->light_count; i++)
        if (info->lights[i].index == index) return &info->lights[i];
    return NULL;
}

/* Its lights are those that the CPU finds; their sum is what is told, and they are in order. */
static void check_lights(const fnl_scene *scene, const fnl_pixel_info *info, const char *what) {
    uint32_t found = 0, contributing = 0;
    double sum[3] = {0};
    for (uint32_t i = 0; i < fnl_scene_count(scene, FNL_ENTITY_LIGHT); i++) {
        fnl_light_params light;
        assert_int_equal(fnl_scene_query_light(scene, i, &light), FNL_OK);
        const fnl_pixel_light *told = find_light(info, i);
        const bool endless = light.kind == FNL_LIGHT_DIRECTIONAL;
        const int wanted = endless ? 1 : reaches(&light, info->position);
        if (wanted >= 0 && (told != NULL) != (wanted == 1)) fail_msg("%s: light %u is %s", what, i, told ? "told, but does not reach" : "missing");
        if (!told) continue;
        fnl_entity_info entity;
        assert_int_equal(fnl_scene_query_entity(scene, FNL_ENTITY_LIGHT, i, &entity), FNL_OK);
        assert_true(told->id.index == entity.id.light.index && told->id.generation == entity.id.light.generation && told->directional == endless);
        if (told->luminance > 0 && !told->listed) fail_msg("%s: light %u, which gives %g, is not in the list", what, i, (double)told->luminance);
        found += !endless;
        contributing += told->luminance > 0;
        for (int c = 0; c < 3; c++) sum[c] += (double)told->radiance[c];
    }
    assert_int_equal(info->lights_reaching, found);
    assert_int_equal(info->lights_contributing, contributing);
    assert_int_equal(info->lights_untold, 0);
    for (int c = 0; c < 3; c++)
        if (fabs(sum[c] - (double)info->lit[c]) > 1e-5 * (1e-6 + sum[c])) fail_msg("%s: lights give %g, not %g", what, sum[c], (double)info->lit[c]);
    for (uint32_t i = 1; i < info->light_count; i++) assert_true(info->lights[i].luminance <= info->lights[i - 1].luminance);
}

/* What is told adds up to the picture. */
static void check_radiance(fnl_renderer *renderer, const fnl_pixel_info *info, double tolerance, const char *what) {
    fnl_image image = test_read(renderer, FNL_OUTPUT_RADIANCE);
    const float *shown = test_pixel(&image, info->query.x, info->query.y);
    for (int c = 0; c < 3; c++) {
        const double told = (double)info->lit[c] + (double)info->rest[c];
        if (fabs((double)shown[c] - told) > tolerance * fmax((double)shown[c], 1e-3))
            fail_msg("%s: channel %d of pixel %u %u is %g, told %g", what, c, info->query.x, info->query.y, (double)shown[c], told);
    }
    free_picture(&image);
}

/* What count_lights counted for the pixel. */
static void check_counts(const fnl_renderer *renderer, const fnl_pixel_info *info, const char *what) {
    const uint32_t *counters = renderer->views.data[info->query.view].counters.mapped;
    const uint32_t *own = counters + 2 * ((size_t)info->query.y * renderer->frame.width + info->query.x);
    if (own[0] != info->lights_visited || own[1] != info->lights_reaching - info->lights_left_out)
        fail_msg("%s: shading counted %u lights visited and %u useful, told %u and %u", what, own[0], own[1], info->lights_visited,
                 info->lights_reaching - info->lights_left_out);
}

static const uint32_t places[][2] = {{28, 16}, {13, 18}};

static struct stage open_spheres(void) {
    struct stage stage = stage_open("builtin:spheres", LIGHTS);
    fnl_light_params sun = fnl_light_params_default();
    fnl_light_id id;
    sun.kind = FNL_LIGHT_DIRECTIONAL;
    sun.direction = (vec3){0.3f, -1, -0.4f};
    sun.intensity = 2;
    assert_int_equal(fnl_scene_add_light(stage.scene, &sun, &id), FNL_OK);
    stage.frame.width = WIDTH;
    stage.frame.height = HEIGHT;
    stage.frame.count_lights = true;
    return stage;
}

/* ---- lists and paths ---- */

static void test_all_lists(void **state) {
    UNUSED(state);
    struct stage stage = open_spheres();
    fnl_pixel_light first[COUNT_OF(places)][FNL_PIXEL_LIGHTS];
    fnl_pixel_info oracle[COUNT_OF(places)];
    uint32_t most = 0, left_out = 0;
    for (fnl_light_lists lists = 0; lists < FNL_LISTS_AUTO; lists++)
        for (uint32_t i = 0; i < COUNT_OF(places); i++) {
            const char *what = fnl_value_name(FNL_ENUM_LISTS, lists);
            fnl_frame frame = stage.frame;
            frame.lists = lists;
            frame.shading = fnl_shading_supports(FNL_SHADING_DEFERRED, lists, 1) ? FNL_SHADING_DEFERRED : FNL_SHADING_FORWARD_PREPASS;
            const fnl_pixel_info info = ask(stage.renderer, &frame, places[i][0], places[i][1]);
            assert_true(info.hit && info.has_list && !info.unserved);
            check_lights(stage.scene, &info, what);
            check_counts(stage.renderer, &info, what);
            check_radiance(stage.renderer, &info, 0.02, what); /* a G-buffer rounds */
            /* Two kinds leave out lights behind all surfaces of a cell. */
            assert_true(lists == FNL_LISTS_BACKFACE || lists == FNL_LISTS_SPARSE || info.lights_left_out == 0);
            left_out |= info.lights_left_out;
            assert_true(info.lights_visited >= info.lights_reaching - info.lights_left_out && info.cell_place[0] < WIDTH && info.cell_place[1] < HEIGHT);
            if (lists == FNL_LISTS_ALL) {
                assert_true(info.cell == FNL_PIXEL_NONE && info.lights_visited == fnl_scene_count(stage.scene, FNL_ENTITY_LIGHT) - 1);
                oracle[i] = info;
                memcpy(first[i], info.lights, info.light_count * sizeof *info.lights);
                most = MAX(most, info.lights_reaching);
                continue;
            }
            if (lists != FNL_LISTS_GRID2D) assert_true(info.cell != FNL_PIXEL_NONE);
            assert_int_equal(info.light_count, oracle[i].light_count);
            for (uint32_t k = 0; k < info.light_count; k++) first[i][k].listed = info.lights[k].listed;
            assert_memory_equal(info.lights, first[i], info.light_count * sizeof *info.lights);
            assert_memory_equal(info.lit, oracle[i].lit, sizeof info.lit);
        }
    assert_true(most >= 4 && left_out);
    stage_close(&stage);
}

/* The cell of tiles is where the pixel is. */
static void test_cells(void **state) {
    UNUSED(state);
    struct stage stage = open_spheres();
    fnl_frame frame = stage.frame;
    frame.lists = FNL_LISTS_TILED;
    fnl_pixel_info info = ask(stage.renderer, &frame, 41, 22);
    const uint32_t tiles_x = DIVIDE_UP(WIDTH, 16u);
    assert_true(info.cell_place[0] == 2 && info.cell_place[1] == 1 && info.cell_place[2] == 0 && info.cell == tiles_x + 2);
    frame.lists = FNL_LISTS_CLUSTERED;
    frame.clusters.size = 16;
    frame.clusters.slices = 10;
    frame.clusters.near = 1;
    frame.clusters.far = 11;
    frame.clusters.distribution = FNL_SLICES_LINEAR;
    info = ask(stage.renderer, &frame, 41, 22);
    assert_int_equal(info.cell_place[2], (uint32_t)fminf(info.view_depth - 1, 9));
    assert_int_equal(info.cell, (info.cell_place[2] * DIVIDE_UP(HEIGHT, 16u) + 1) * tiles_x + 2);
    harness_set_pool(&stage, 1);
    harness_hooks(stage.renderer)->fixed_pools = true;
    info = ask(stage.renderer, &frame, 41, 22);
    assert_true(info.unserved && info.lights_visited >= info.lights_reaching);
    check_lights(stage.scene, &info, "overflow");
    check_counts(stage.renderer, &info, "overflow");
    stage_close(&stage);
}

static void test_all_paths(void **state) {
    UNUSED(state);
    struct stage stage = open_spheres();
    for (fnl_shading shading = 0; shading < FNL_SHADING_AUTO; shading++) {
        const char *what = fnl_value_name(FNL_ENUM_SHADING, shading);
        const bool lower = shading == FNL_SHADING_INFERRED || shading == FNL_SHADING_LOW_RES, shared = shading == FNL_SHADING_COARSE;
        fnl_frame frame = stage.frame;
        frame.shading = shading;
        frame.lists = FNL_LISTS_TILED;
        if (shading == FNL_SHADING_VISIBILITY && !gpu_info(harness_device())->primitive_ids) continue;
        const fnl_pixel_info info = ask(stage.renderer, &frame, places[0][0], places[0][1]);
        assert_true(info.hit && info.has_list == !shading_is(shading, SHADING_VOLUMES));
        check_lights(stage.scene, &info, what);
        if (!lower && !shared && shading != FNL_SHADING_FORWARD) check_counts(stage.renderer, &info, what);
        const double rounding = shading == FNL_SHADING_MOBILE ? 0.1 : 0.03; /* mobile finds geometric normals in quads */
        check_radiance(stage.renderer, &info, lower ? 0.5 : shading == FNL_SHADING_FORWARD ? 1e-5 : rounding, what);
        assert_true(info.lights_visited >= info.lights_reaching);
    }
    stage_close(&stage);
}

/* ---- surfaces ---- */

static void test_surface(void **state) {
    UNUSED(state);
    fnl_scene *scene = test_scene();
    struct scene_material m = scene_material_default(), glow = test_unlit(0.2f, 0.4f, 0.6f);
    m.base_color = (vec4){0.8f, 0.2f, 0.05f, 1};
    m.roughness = 0.3f;
    m.metallic = 0.25f;
    mat4 matrix = mat4_from_trs((vec3){-0.5f, 0, 1}, quat_axis_angle((vec3){0, 1, 0}, 0.5f), (vec3){0.4f, 0.9f, 1});
    scene_add_node(scene, "", SCENE_NONE, &matrix, test_quad_mesh(scene, scene_add_material(scene, &m)));
    test_place(scene, test_quad_mesh(scene, scene_add_material(scene, &glow)), (vec3){0.6f, 0, 0}, (vec3){0.2f, 0.9f, 1});
    const fnl_light_params light = test_point((vec3){-0.4f, 0, 2}, 3, 4);
    fnl_light_id id;
    assert_int_equal(fnl_scene_add_light(scene, &light, &id), FNL_OK);
    fnl_renderer *renderer = test_renderer(scene);
    fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE);
    for (uint32_t x = 8; x < 22; x += 3) { /* odd and even places */
        const fnl_pixel_info info = ask(renderer, &frame, x, 31);
        const double at = (x + 0.5) / 32 - 1, z = 1 - (at + 0.5) * tan(0.5);
        assert_true(info.hit && !info.unlit && info.light_count == 1);
        assert_true(fabs((double)info.position.x - at) < 1e-5 && fabs((double)info.position.y - 0.5 / 32) < 1e-5 && fabs((double)info.position.z - z) < 1e-5);
        assert_true(fabs((double)info.normal.x - sin(0.5)) < 1e-5 && fabs((double)info.normal.z - cos(0.5)) < 1e-5);
        assert_true(fabs((double)info.view_depth - (5 - z)) < 1e-4);
        assert_true(info.base_color[0] == 0.8f && info.base_color[2] == 0.05f && info.roughness == 0.3f && info.metallic == 0.25f);
        check_radiance(renderer, &info, 1e-5, "a square");
    }
    fnl_pixel_info info = ask(renderer, &frame, 51, 20);
    assert_true(info.hit && info.unlit && info.base_color[1] == 0.4f && info.lights_contributing == 0 && info.rest[1] == 0.4f);
    info = ask(renderer, &frame, 63, 63);
    const fnl_pixel_info nothing = {.query = {true, 63, 63, 0}};
    assert_memory_equal(&info, &nothing, sizeof info); /* the sky */
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* Layers over the material, in paths that shade them and in one over whose picture they are drawn, by a list of their own. */
static void test_layers(void **state) {
    UNUSED(state);
    static const fnl_shading shadings[] = {FNL_SHADING_FORWARD, FNL_SHADING_DEFERRED, FNL_SHADING_LIGHT_PREPASS};
    fnl_scene *scene = test_scene();
    for (int i = 0; i < 2; i++) {
        fnl_material_params p = fnl_material_params_default();
        p.roughness = 0.4f;
        p.metallic = 0.3f;
        if (i == 0) p.clearcoat = (fnl_clearcoat_params){.strength = 0.9f, .roughness = 0.25f};
        if (i == 0) p.sheen = (fnl_sheen_params){.color = {0.9f, 0.6f, 0.8f}, .roughness = 0.4f};
        if (i == 1) p.iridescence = (fnl_iridescence_params){.strength = 1, .ior = 1.4f, .thickness_maximum = 450};
        if (i == 1) p.anisotropy = (fnl_anisotropy_params){.strength = 0.8f, .rotation = 0.6f};
        const fnl_material_id id = test_material(scene, &p);
        test_place(scene, test_sphere_mesh(scene, id.index, 16), (vec3){i ? 0.5f : -0.5f, 0, 0}, (vec3){0.45f, 0.45f, 0.45f});
    }
    for (int i = 0; i < 6; i++) {
        const fnl_light_params light = test_point((vec3){0.5f * (float)(i % 3) - 0.5f, i < 3 ? 0.5f : -0.5f, 1.2f}, 2, 2);
        fnl_light_id id;
        assert_int_equal(fnl_scene_add_light(scene, &light, &id), FNL_OK);
    }
    fnl_renderer *renderer = test_renderer(scene);
    for (uint32_t s = 0; s < COUNT_OF(shadings); s++)
        for (uint32_t x = 17; x < 64; x += 31) {
            const char *what = fnl_value_name(FNL_ENUM_SHADING, shadings[s]);
            fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE);
            frame.shading = shadings[s];
            frame.lists = FNL_LISTS_TILED;
            const fnl_pixel_info info = ask(renderer, &frame, x, 29);
            assert_true(info.hit && info.lights_contributing > 1 && info.lights_visited >= info.lights_reaching);
            check_lights(scene, &info, what);
            check_radiance(renderer, &info, 1e-4, what);
        }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* With samples the surface is that of the pixel's centre, and its list serves it. */
static void test_samples(void **state) {
    UNUSED(state);
    static const fnl_shading shadings[] = {FNL_SHADING_FORWARD_PREPASS, FNL_SHADING_DEFERRED};
    struct stage stage = open_spheres();
    for (uint32_t s = 0; s < COUNT_OF(shadings); s++) {
        fnl_frame frame = stage.frame;
        frame.shading = shadings[s];
        frame.lists = FNL_LISTS_TILED;
        frame.count_lights = false;
        const fnl_pixel_info one = ask(stage.renderer, &frame, places[0][0], places[0][1]);
        frame.msaa = 4;
        frame.occlusion = FNL_OCCLUSION_ON;
        const fnl_pixel_info four = ask(stage.renderer, &frame, places[0][0], places[0][1]);
        assert_memory_equal(&one.position, &four.position, sizeof one.position);
        assert_memory_equal(one.lit, four.lit, sizeof one.lit);
        check_lights(stage.scene, &four, "4 samples");
    }
    stage_close(&stage);
}

static void test_views(void **state) {
    UNUSED(state);
    struct stage stage = open_spheres();
    fnl_camera cameras[3] = {stage.frame.camera, stage.frame.camera, stage.frame.camera};
    cameras[1].position.x += 0.7f;
    cameras[2].position.y += 0.9f;
    for (uint32_t view = 0; view < 3; view++) {
        fnl_frame frame = stage.frame;
        frame.lists = FNL_LISTS_CLUSTERED;
        frame.camera = cameras[view];
        const fnl_pixel_info alone = ask(stage.renderer, &frame, places[0][0], places[0][1]);
        frame.views = cameras;
        frame.view_count = 3;
        frame.pixel.view = view;
        const fnl_pixel_info among = ask(stage.renderer, &frame, places[0][0], places[0][1]);
        assert_memory_equal(&alone.position, &among.position, sizeof alone.position);
        assert_memory_equal(alone.lit, among.lit, sizeof alone.lit);
        assert_true(alone.cell == among.cell && alone.lights_visited == among.lights_visited);
        check_counts(stage.renderer, &among, "a view");
    }
    stage_close(&stage);
}

/* Nothing to see; a picture of one pixel, without a light. */
static void test_least(void **state) {
    UNUSED(state);
    for (int i = 0; i < 2; i++) {
        fnl_scene *scene = test_scene();
        struct scene_material m = scene_material_default();
        if (i) test_place(scene, test_quad_mesh(scene, scene_add_material(scene, &m)), (vec3){0, 0, 0}, (vec3){2, 2, 1});
        fnl_renderer *renderer = test_renderer(scene);
        fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE);
        frame.width = frame.height = 1;
        frame.shading = FNL_SHADING_DEFERRED;
        for (fnl_light_lists lists = 0; lists <= FNL_LISTS_AUTO; lists++) {
            frame.lists = lists;
            if (!fnl_shading_supports(frame.shading, lists, 1)) continue;
            const fnl_pixel_info info = ask(renderer, &frame, 0, 0);
            assert_true(info.hit == (i == 1) && info.light_count == 0 && info.lights_visited == 0 && info.lights_reaching == 0);
            assert_true(!info.hit || fabsf(info.position.x) < 1e-5f);
        }
        fnl_renderer_destroy(&renderer);
        fnl_scene_destroy(&scene);
    }
}

/* ---- shadows ---- */

/* A floor, a square above its right half, and a light over each; the camera looks past the square. */
static fnl_scene *roofed(fnl_light_id ids[2]) {
    fnl_scene *scene = test_scene();
    struct scene_material m = scene_material_default();
    const uint32_t mesh = test_quad_mesh(scene, scene_add_material(scene, &m));
    test_place(scene, mesh, (vec3){0, 0, 0}, (vec3){4, 4, 1});
    test_place(scene, mesh, (vec3){2.5f, 0, 2}, (vec3){1, 3, 1});
    const fnl_light_params lights[2] = {test_point((vec3){-1, 0, 3}, 4, 20), test_point((vec3){2.5f, 0, 3}, 4, 20)};
    for (int i = 0; i < 2; i++) assert_int_equal(fnl_scene_add_light(scene, &lights[i], &ids[i]), FNL_OK);
    return scene;
}

static void test_shadows(void **state) {
    UNUSED(state);
    fnl_light_id ids[2];
    fnl_scene *scene = roofed(ids);
    fnl_renderer *renderer = test_renderer(scene);
    static const fnl_shadows kinds[] = {FNL_SHADOWS_OFF, FNL_SHADOWS_RAYS, FNL_SHADOWS_SAMPLED, FNL_SHADOWS_MAPS};
    static const fnl_pixel_shadow wanted[] = {FNL_PIXEL_SHADOW_NONE, FNL_PIXEL_SHADOW_RAYS, FNL_PIXEL_SHADOW_RAYS, FNL_PIXEL_SHADOW_MAP};
    for (uint32_t k = 0; k < COUNT_OF(kinds); k++)
        for (uint32_t classify = 0; classify <= (kinds[k] == FNL_SHADOWS_MAPS); classify++) {
            fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE);
            frame.shading = FNL_SHADING_DEFERRED;
            frame.lists = FNL_LISTS_TILED;
            frame.shadows = kinds[k];
            frame.shadow.classify = classify;
            frame.shadow.rays = 8; /* one to each light: no chance */
            const fnl_pixel_info info = ask(renderer, &frame, 40, 31); /* x = 0.27: the square hides the second light there */
            const fnl_pixel_light *lit = find_light(&info, 0), *hidden = find_light(&info, 1);
            assert_true(info.light_count == 2 && lit && hidden && lit->shadow == wanted[k] && hidden->shadow == wanted[k]);
            assert_true(lit->visibility == 1 && hidden->visibility == (float)(k == 0));
            assert_true(info.lights_reaching == 2 && info.lights_contributing == (k == 0 ? 2 : 1));
            assert_true(lit->listed && hidden->listed == !classify && info.lights_left_out == classify && info.lights_visited == 2 - classify);
            check_radiance(renderer, &info, 0.01, "a shadow");
            if (kinds[k] != FNL_SHADOWS_MAPS) continue;
            assert_true(lit->shadow_face == 5 && hidden->shadow_face == 5); /* both are 3 metres above, and less far to the side */
            assert_true(lit->shadow_level < 8 && lit->shadow_page[0] < 16u >> MIN(lit->shadow_level, 4u) && lit->shadow_atlas[0] % SHADOW_UNIT == 0);
        }
    /* From behind. */
    fnl_light_params below = test_point((vec3){0.2f, 0, -1}, 4, 20);
    assert_int_equal(fnl_scene_set_light(scene, ids[1], &below), FNL_OK);
    fnl_frame frame = test_frame(0);
    frame.shadows = FNL_SHADOWS_RAYS;
    fnl_pixel_info info = ask(renderer, &frame, 40, 31);
    const fnl_pixel_light *behind = find_light(&info, 1);
    assert_true(behind && behind->shadow == FNL_PIXEL_SHADOW_BEHIND && behind->visibility == 0 && behind->luminance == 0);
    below.casts_shadows = false;
    below.position.z = 1;
    assert_int_equal(fnl_scene_set_light(scene, ids[1], &below), FNL_OK);
    info = ask(renderer, &frame, 40, 31);
    behind = find_light(&info, 1);
    assert_true(behind && behind->shadow == FNL_PIXEL_SHADOW_NONE && behind->visibility == 1 && behind->luminance > 0);
    /* What is gone when one looks. */
    assert_int_equal(fnl_renderer_query_pixel(renderer, &info), FNL_OK);
    assert_int_equal(fnl_scene_remove_light(scene, ids[0]), FNL_OK);
    fnl_light_params other = test_point((vec3){0, 0, 2}, 1, 1);
    for (int again = 0; again < 2; again++) {
        assert_int_equal(fnl_renderer_query_pixel(renderer, &info), FNL_OK);
        uint32_t gone = 0;
        for (uint32_t i = 0; i < info.light_count; i++) gone += info.lights[i].index == FNL_PIXEL_NONE && info.lights[i].id.generation == 0;
        assert_true(info.light_count == 2 && gone == 1 && find_light(&info, again));
        assert_int_equal(fnl_scene_add_light(scene, &other, &ids[0]), FNL_OK); /* takes its place */
    }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* ---- more lights than are told ---- */

static void test_many(void **state) {
    UNUSED(state);
    enum { MANY = 700 };
    fnl_scene *scene = test_scene();
    struct scene_material m = scene_material_default();
    test_place(scene, test_quad_mesh(scene, scene_add_material(scene, &m)), (vec3){0, 0, 0}, (vec3){2, 2, 1});
    double intensities[MANY];
    for (uint32_t i = 0; i < (uint32_t)MANY; i++) {
        fnl_light_id id;
        intensities[i] = 1 + (i * 37 % 101) * 0.001; /* many are alike */
        const fnl_light_params light = test_point((vec3){0, 0, 1}, (float)intensities[i], 5);
        assert_int_equal(fnl_scene_add_light(scene, &light, &id), FNL_OK);
    }
    fnl_renderer *renderer = test_renderer(scene);
    fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE);
    frame.lists = FNL_LISTS_TILED;
    fnl_pixel_light before[FNL_PIXEL_LIGHTS];
    for (int again = 0; again < 2; again++) {
        const fnl_pixel_info info = ask(renderer, &frame, 30, 30);
        assert_true(info.lights_reaching == (uint32_t)MANY && info.light_count == FNL_PIXEL_LIGHTS && info.lights_untold == (uint32_t)MANY - FNL_PIXEL_LIGHTS);
        check_radiance(renderer, &info, 1e-4, "many lights");
        const fnl_pixel_light *last = &info.lights[FNL_PIXEL_LIGHTS - 1];
        for (uint32_t i = 0; i < (uint32_t)MANY; i++) { /* stronger than the last, or as strong and before it: told */
            const double at = intensities[last->index];
            const bool wanted = intensities[i] > at + 1e-9 || (fabs(intensities[i] - at) < 1e-9 && i <= last->index);
            if ((find_light(&info, i) != NULL) != wanted) fail_msg("light %u of %g is %s; the last is %u of %g", i, intensities[i], wanted ? "missing" : "told", last->index, at);
        }
        if (again) assert_memory_equal(before, info.lights, sizeof before);
        memcpy(before, info.lights, sizeof before);
    }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* ---- what asking costs, and what is refused ---- */

static void test_asking(void **state) {
    UNUSED(state);
    struct stage stage = open_spheres();
    fnl_pixel_info info;
    fnl_frame_stats stats;
    fnl_frame frame = stage.frame;
    frame.count_lights = false;
    frame.timers = true;
    assert_int_equal(fnl_renderer_query_pixel(stage.renderer, &info), FNL_ERROR_INVALID); /* no frame yet */
    struct shot plain = stage_shoot(&stage, &frame);
    assert_int_equal(fnl_renderer_query_pixel(stage.renderer, &info), FNL_ERROR_INVALID); /* not asked */
    assert_int_equal(fnl_renderer_query_stats(stage.renderer, &stats), FNL_OK);
    for (uint32_t i = 0; i < stats.pass_count; i++) assert_null(strstr(stats.passes[i].name, "pixel/"));
    const uint32_t passes = stats.pass_count;
    frame.pixel = (fnl_pixel_query){true, WIDTH - 1, HEIGHT - 1, 0};
    struct shot asked = stage_shoot(&stage, &frame);
    assert_int_equal(count_differing(&plain.color, &asked.color) + count_differing(&plain.radiance, &asked.radiance), 0);
    assert_int_equal(fnl_renderer_query_pixel(stage.renderer, &info), FNL_OK);
    assert_int_equal(fnl_renderer_query_stats(stage.renderer, &stats), FNL_OK);
    assert_true(stats.pass_count > passes);
    shot_free(&plain);
    shot_free(&asked);
    const fnl_pixel_query wrong[] = {{true, WIDTH, 0, 0}, {true, 0, HEIGHT, 0}, {true, 0, 0, 1}};
    for (uint32_t i = 0; i < COUNT_OF(wrong); i++) {
        frame.pixel = wrong[i];
        assert_int_equal(fnl_renderer_render(stage.renderer, &frame), FNL_ERROR_INVALID);
        frame.pixel.asked = false;
        assert_int_equal(fnl_renderer_render(stage.renderer, &frame), FNL_OK);
    }
    frame.pixel = (fnl_pixel_query){true, 3, 3, 0}; /* ahead of time */
    uint32_t pending;
    assert_int_equal(fnl_renderer_warm(stage.renderer, &frame, NULL, true, &pending), FNL_OK);
    ask(stage.renderer, &frame, 3, 3);
    assert_int_equal(fnl_renderer_query_stats(stage.renderer, &stats), FNL_OK);
    assert_int_equal(stats.pipelines_made, 0);
    stage_close(&stage);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_all_lists, harness_check), cmocka_unit_test_teardown(test_cells, harness_check),
        cmocka_unit_test_teardown(test_all_paths, harness_check), cmocka_unit_test_teardown(test_surface, harness_check),
        cmocka_unit_test_teardown(test_layers, harness_check),   cmocka_unit_test_teardown(test_least, harness_check),
        cmocka_unit_test_teardown(test_samples, harness_check),   cmocka_unit_test_teardown(test_views, harness_check),
        cmocka_unit_test_teardown(test_shadows, harness_check),   cmocka_unit_test_teardown(test_many, harness_check),
        cmocka_unit_test_teardown(test_asking, harness_check)};
    return cmocka_run_group_tests(tests, test_group_begin, test_group_end);
}
