/* SPDX-License-Identifier: MIT */
/** Lists of what a visibility buffer shows: by class and by material, and the triangles of multisampled pixels. */
#include "passes/visibility/visible.h"

#include "passes/geometry/radix_shared.h"
#include "passes/visibility/visible_shared.h"
#include "tests/render_test.h"
#include "scene_shared.h"
#include "shaders.h"
#include "tests/vulkan_spy.h"

static uint32_t visited(const fnl_renderer *renderer, uint32_t pixel) {
    return ((const uint32_t *)renderer->views.data[0].counters.mapped)[2 * pixel];
}

/* ---- sorting ---- */

static struct scene_material varied(fnl_scene *scene, uint32_t i, uint32_t image, uint32_t sampler_index) {
    UNUSED(scene);
    struct random_state random = {i + 1};
    struct scene_material material = scene_material_default();
    material.base_color = (vec4){random_float(&random), random_float(&random), random_float(&random), 1};
    material.metallic = i % 3 ? 0 : random_float(&random);
    material.roughness = random_range(&random, 0.2f, 1);
    material.unlit = i % 7 == 3;
    material.double_sided = i % 2;
    for (int slot = 0; slot < SCENE_TEXTURE_SLOT_COUNT; slot++) {
        bool has = (i % 5 == 1 && slot == SCENE_TEXTURE_BASE_COLOR) || (i % 5 == 2 && slot == SCENE_TEXTURE_NORMAL) ||
                   (i % 5 == 4 && slot == SCENE_TEXTURE_METALLIC_ROUGHNESS);
        if (!has) continue;
        material.textures[slot] = scene_texture_none();
        material.textures[slot].image = image;
        material.textures[slot].sampler = sampler_index;
    }
    return material;
}

/* `count` squares side by side, each of a material of its own, before a hole in the middle of the rows. */
static fnl_scene *patches(uint32_t count, uint32_t lights) {
    fnl_scene *scene = test_scene();
    assert_int_equal(fnl_scene_set_ambient(scene, (fnl_vec3){0.5f, 0.55f, 0.65f}, (fnl_vec3){0.25f, 0.22f, 0.2f}), FNL_OK);
    enum { SIDE = 16 };
    static uint8_t texels[SIDE * SIDE * 4];
    for (uint32_t i = 0; i < sizeof texels; i++) texels[i] = i % 4 == 3 ? 255 : (uint8_t)(100 + i * 37 % 120);
    fnl_image image = {SIDE, SIDE, FNL_PIXEL_FORMAT_RGBA8, texels};
    fnl_image_id id;
    assert_int_equal(fnl_scene_add_image(scene, &image, true, &id), FNL_OK);
    struct scene_sampler sampler = {.mag = SCENE_FILTER_LINEAR, .min = SCENE_FILTER_LINEAR, .mipmapped = true};
    uint32_t sampler_index = scene_add_sampler(scene, &sampler), side = 1;
    while (side * side < count) side++;
    for (uint32_t i = 0; i < count; i++) {
        struct scene_material material = varied(scene, i, id.index, sampler_index);
        float x = ((float)(i % side) + 0.5f) * 2 / (float)side - 1, y = ((float)(i / side) + 0.5f) * 2 / (float)side - 1;
        vec3 scale = {0.8f / (float)side, 0.7f / (float)side, 1};
        test_place(scene, test_quad_mesh(scene, scene_add_material(scene, &material)), (vec3){x, y, 0.2f * sinf(x * 9)},
                   scale);
    }
    for (uint32_t i = 0; i < lights; i++) {
        fnl_light_params light = test_point((vec3){(float)i - 1, 0.5f, 1.5f}, 3, 20);
        fnl_light_id light_id;
        assert_int_equal(fnl_scene_add_light(scene, &light, &light_id), FNL_OK);
    }
    return scene;
}

static fnl_frame patches_frame(uint32_t width, uint32_t height) {
    fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE);
    frame.width = width;
    frame.height = height;
    frame.shading = FNL_SHADING_VISIBILITY;
    frame.count_lights = true;
    return frame;
}

/* Without sorting, unlit surfaces ask for lights as well. */
static uint32_t pixels_seen(fnl_scene *scene, fnl_frame frame, uint32_t lights) {
    fnl_renderer *renderer = test_renderer(scene);
    frame.visibility.sort = FNL_VISIBILITY_SORT_OFF;
    test_render_frame(renderer, &frame);
    fnl_image radiance = test_read(renderer, FNL_OUTPUT_RADIANCE);
    uint32_t seen = 0;
    for (uint32_t i = 0; i < frame.width * frame.height; i++) {
        seen += visited(renderer, i) != 0;
        assert_true(visited(renderer, i) == 0 || visited(renderer, i) == lights);
    }
    free_picture(&radiance);
    fnl_renderer_destroy(&renderer);
    return seen;
}

static void check_sorts(uint32_t material_count, uint32_t width, uint32_t height) {
    enum { LIGHTS = 3 };
    fnl_scene *scene = patches(material_count, LIGHTS);
    fnl_renderer *renderer = test_renderer(scene);
    fnl_frame frame = patches_frame(width, height);
    uint32_t seen = pixels_seen(scene, frame, LIGHTS);
    fnl_image plain = {0};
    for (int sort = FNL_VISIBILITY_SORT_OFF; sort < FNL_VISIBILITY_SORT_COUNT; sort++) {
        frame.visibility.sort = (fnl_visibility_sort)sort;
        harness_hooks(renderer)->poison = true;
        test_render_frame(renderer, &frame);
        fnl_image radiance = test_read(renderer, FNL_OUTPUT_RADIANCE);
        if (sort == FNL_VISIBILITY_SORT_OFF) {
            plain = radiance;
            continue;
        }
        if (!test_equal(&plain, &radiance))
            fail_msg("%u materials, %ux%u: %s differs", material_count, width, height,
                     fnl_value_name(FNL_ENUM_VISIBILITY_SORT, (fnl_visibility_sort)sort));
        free_picture(&radiance);
        fnl_frame_stats stats;
        assert_int_equal(fnl_renderer_query_stats(renderer, &stats), FNL_OK);
        assert_int_equal(counter(&stats, "visibility.entries"), seen);
        uint32_t once = 0, never = 0;
        for (uint32_t i = 0; i < width * height; i++) {
            once += visited(renderer, i) == LIGHTS;
            never += visited(renderer, i) == 0;
        }
        assert_int_equal(once + never, width * height); /* none twice */
        assert_true(material_count < 20 || once > 0);
        assert_true(stats.evaluations == (uint64_t)once * LIGHTS);
        if (material_count > 1000)
            assert_true(counter(&stats, "visibility.classes") >= 6 && once < seen); /* unlit ones ask no light */
        if (material_count == 1) assert_int_equal(counter(&stats, "visibility.classes"), 1);
    }
    free_picture(&plain);
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

static void test_sorts(void **state) {
    UNUSED(state);
    check_sorts(1200, 161, 91);
    check_sorts(1, 37, 23);
    check_sorts(20, 8, 8);
    check_sorts(0, 33, 9);
    check_sorts(2, 1, 1);
}

/* The dispatches are one for each class of the scene's materials, and the passes hold no other. */
static void test_plan(void **state) {
    UNUSED(state);
    fnl_scene *scene = patches(30, 1);
    fnl_renderer *renderer = test_renderer(scene);
    fnl_frame frame = patches_frame(40, 30);
    test_render_frame(renderer, &frame);
    char plan[32768];
    assert_true(fnl_renderer_print(renderer, FNL_PRINT_PLAN, plan, sizeof plan) < sizeof plan);
    assert_null(strstr(plan, "visible sort"));
    frame.visibility.sort = FNL_VISIBILITY_SORT_CLASS;
    test_render_frame(renderer, &frame);
    assert_true(fnl_renderer_print(renderer, FNL_PRINT_PLAN, plan, sizeof plan) < sizeof plan);
    assert_non_null(strstr(plan, "visible sort count 1"));
    assert_null(strstr(plan, "visible sort count 2"));
    frame.visibility.sort = FNL_VISIBILITY_SORT_MATERIAL; /* 31 materials: 5 bits more */
    test_render_frame(renderer, &frame);
    assert_true(fnl_renderer_print(renderer, FNL_PRINT_PLAN, plan, sizeof plan) < sizeof plan);
    assert_non_null(strstr(plan, "visible sort count 3"));
    assert_null(strstr(plan, "visible sort count 4"));
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

static const struct {
    uint32_t constant;
    const char *name;
} parts[] = {{2, "lights"}, {3, "metals"}, {10, "textures"}, {11, "normal maps"}};
static uint32_t left_out;

static const struct gpu_pipeline *leave_out(gpu_device *device, const struct gpu_pipeline *bound) {
    if (!spy_compute_params(bound) || spy_compute_params(bound)->shader != &shader_visibility_shade_comp) return bound;
    struct gpu_compute_params params;
    memcpy(&params, spy_compute_params(bound), sizeof params);
    params.constants[parts[left_out].constant] = 0;
    return gpu_compute_pipeline(device, &params);
}

/*
 * The list itself: each pixel that shows a square once, its key the class and the number of the square's material, keys ascending; so each
 * material is one run. And the work that follows: one dispatch for each class that occurs in the scene, with a pipeline of its own.
 */
static void test_order_of_the_list(void **state) {
    UNUSED(state);
    enum { COUNT = 30, SIDE = 6, WIDTH = 75, HEIGHT = 75 };
    fnl_scene *scene = patches(COUNT, 1);
    struct gpu_buffer list;
    assert_int_equal(gpu_buffer_create(test_device, "list", WIDTH * HEIGHT * 8, GPU_MEMORY_READBACK, &list), FNL_OK);
    spy_begin(test_device);
    fnl_renderer *renderer = test_renderer(scene);
    fnl_frame frame = patches_frame(WIDTH, HEIGHT);
    for (int sort = FNL_VISIBILITY_SORT_CLASS; sort <= FNL_VISIBILITY_SORT_MATERIAL; sort++) {
        frame.visibility.sort = (fnl_visibility_sort)sort;
        uint32_t bits = sort == FNL_VISIBILITY_SORT_MATERIAL ? 5 : 0; /* of 31 materials */
        char sorted[32];
        snprintf(sorted, sizeof sorted, "visible sort pairs %u", DIVIDE_UP(4 + bits, (uint32_t)RADIX_BITS));
        spy_clear();
        spy_capture(renderer->graph, "visible ranges", sorted, &list);
        test_render_frame(renderer, &frame);
        fnl_image radiance = test_read(renderer, FNL_OUTPUT_RADIANCE);
        fnl_frame_stats stats;
        assert_int_equal(fnl_renderer_query_stats(renderer, &stats), FNL_OK);
        const uint32_t *pairs = list.mapped;
        static bool listed[WIDTH * HEIGHT];
        memset(listed, 0, sizeof listed);
        uint32_t runs = 0, classes = 0, last_material = 0;
        for (uint32_t i = 0; i < counter(&stats, "visibility.entries"); i++) {
            uint32_t key = pairs[2 * i], pixel = pairs[2 * i + 1];
            assert_true(pixel < WIDTH * HEIGHT && !listed[pixel]);
            listed[pixel] = true;
            float x = ((float)(pixel % WIDTH) + 0.5f) * 2 / WIDTH - 1, y = 1 - ((float)(pixel / WIDTH) + 0.5f) * 2 / HEIGHT;
            uint32_t square = (uint32_t)((x + 1) / 2 * SIDE) + (uint32_t)((y + 1) / 2 * SIDE) * SIDE;
            uint32_t material = scene->primitives.data[square].material;
            if (bits) assert_int_equal(key & 31, material);
            if (i) assert_true(pairs[2 * i - 2] <= key);
            runs += i == 0 || material != last_material;
            classes += i == 0 || pairs[2 * i - 2] >> bits != key >> bits;
            last_material = material;
        }
        print_message("%s: %u pixels, %u classes, %u runs of one material\n",
                      fnl_value_name(FNL_ENUM_VISIBILITY_SORT, (fnl_visibility_sort)sort),
                      (uint32_t)counter(&stats, "visibility.entries"), classes, runs);
        assert_true(counter(&stats, "visibility.entries") > 1500);
        assert_int_equal(classes, counter(&stats, "visibility.classes"));
        if (bits) assert_int_equal(runs, COUNT);
        if (!bits) assert_true(runs > COUNT); /* blocks of pixels cross from square to square */
        /* Each class has its part of the list shaded by what its materials need and no more. */
        uint32_t dispatches = 0;
        for (uint32_t i = 0; i < spy.work_count; i++) {
            if (strcmp(spy.work[i].label, "visibility shade")) continue;
            static const uint32_t needs[] = {GPU_CLASS_LIT, GPU_CLASS_METAL, GPU_CLASS_TEXTURES, GPU_CLASS_NORMAL_MAP};
            assert_true(spy.work[i].indirect);
            uint32_t class_bits = (uint32_t)spy.work[i].offset / 12;
            for (uint32_t k = 0; k < COUNT_OF(needs); k++)
                assert_int_equal(spy_compute_params(spy.work[i].pipeline)->constants[parts[k].constant] != 0,
                                 (class_bits & needs[k]) != 0);
            dispatches++;
        }
        assert_true(dispatches == classes && classes >= 6);
        /* And these constants leave code out: without them pixels that need it are wrong. */
        for (left_out = 0; left_out < COUNT_OF(parts); left_out++) {
            spy.replace = leave_out;
            test_render_frame(renderer, &frame);
            spy.replace = NULL;
            fnl_image less = test_read(renderer, FNL_OUTPUT_RADIANCE);
            uint64_t differing = count_differing(&radiance, &less);
            print_message("without %s: %llu pixels\n", parts[left_out].name, (unsigned long long)differing);
            assert_true(differing > 50);
            free_picture(&less);
        }
        free_picture(&radiance);
    }
    spy_capture(NULL, NULL, NULL, NULL);
    fnl_renderer_destroy(&renderer);
    assert_int_equal(gpu_wait_idle(test_device), FNL_OK);
    spy_end();
    gpu_buffer_destroy(test_device, &list);
    fnl_scene_destroy(&scene);
}

/* ---- samples ---- */

enum { TRIANGLES = 40, SAMPLES = 4 };

struct flat {
    vec2 corners[3];
    float z;
    vec3 color, along, up; /* at the origin, and what it changes to the right and up */
};

static vec3 flat_color(const struct flat *t, vec2 p) {
    return vec3_add(t->color, vec3_add(vec3_scale(t->along, p.x), vec3_scale(t->up, p.y)));
}

static bool flat_holds(const struct flat *t, vec2 p, float *margin) {
    float least = INFINITY;
    for (int i = 0; i < 3; i++) {
        vec2 a = t->corners[i], b = t->corners[(i + 1) % 3];
        float length = hypotf(b.x - a.x, b.y - a.y);
        float d = ((b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x)) / length;
        least = fminf(least, d);
    }
    *margin = fminf(*margin, fabsf(least));
    return least > 0;
}

/* Triangles before one another. With `slopes` their colours change along them, by colours of their corners. */
static fnl_scene *flat_scene(struct flat *triangles, bool slopes) {
    fnl_scene *scene = test_scene();
    struct random_state random = {11};
    for (uint32_t i = 0; i < TRIANGLES; i++) {
        struct flat *t = &triangles[i];
        float size = i % 4 ? 0.15f : 0.6f;
        vec2 center = {random_range(&random, -0.9f, 0.9f), random_range(&random, -0.9f, 0.9f)};
        float turn = random_range(&random, 0, 6);
        for (int c = 0; c < 3; c++) {
            float angle = turn + 2 * PI * (float)c / 3 + random_range(&random, -0.5f, 0.5f);
            t->corners[c] = (vec2){center.x + size * cosf(angle), center.y + size * sinf(angle)};
        }
        t->z = 0.02f * (float)i;
        t->color = (vec3){random_float(&random), random_float(&random), random_float(&random)};
        t->along = t->up = (vec3){0, 0, 0};
        vec3 *positions = ARENA_ARRAY(&scene->arena, vec3, 3);
        uint32_t *indices = ARENA_ARRAY(&scene->arena, uint32_t, 3);
        vec4 *colors = NULL;
        if (slopes) { /* 0.5 at the centre; at the corners within 0 .. 1, which colours are stored in */
            float steep = 0.4f / (size * 1.5f), sign = i % 2 ? 1 : -1;
            t->along = (vec3){steep * sign, 0, -steep};
            t->up = (vec3){0, steep, steep * 0.3f};
            t->color = vec3_sub((vec3){0.5f, 0.5f, 0.5f},
                                vec3_add(vec3_scale(t->along, center.x), vec3_scale(t->up, center.y)));
            colors = ARENA_ARRAY(&scene->arena, vec4, 3);
        }
        for (uint32_t c = 0; c < 3; c++) {
            positions[c] = (vec3){t->corners[c].x, t->corners[c].y, t->z};
            indices[c] = c;
            vec3 color = flat_color(t, t->corners[c]);
            if (slopes) colors[c] = (vec4){color.x, color.y, color.z, 1};
        }
        struct scene_material material =
            slopes ? test_unlit(1, 1, 1) : test_unlit(t->color.x, t->color.y, t->color.z);
        struct scene_primitive primitive = {.material = scene_add_material(scene, &material),
                                            .vertex_count = 3,
                                            .index_count = 3,
                                            .indices = indices,
                                            .positions = positions,
                                            .colors = colors};
        assert_int_equal(mesh_complete(&scene->arena, &primitive), FNL_OK);
        test_place(scene, scene_add_mesh(scene, "", &primitive, 1), (vec3){0, 0, 0}, (vec3){1, 1, 1});
    }
    for (uint32_t i = 0; i < 2; i++) {
        fnl_light_params light = test_point((vec3){(float)i, 0, 2}, 1, 20);
        fnl_light_id light_id;
        assert_int_equal(fnl_scene_add_light(scene, &light, &light_id), FNL_OK);
    }
    return scene;
}

/*
 * Each triangle of a pixel is shaded once, and weighs as many samples as show it: against a point-in-triangle test for each sample. Where
 * colours change along the triangle, it is shaded at the middle of those samples: the mean of what is linear at each. (Deferred texturing
 * has the colours of one of the samples and is left out.)
 */
static void check_samples(bool slopes) {
    static const vec2 places[SAMPLES] = {{0.375f, 0.125f}, {0.875f, 0.375f}, {0.125f, 0.625f}, {0.625f, 0.875f}};
    struct flat triangles[TRIANGLES];
    fnl_scene *scene = flat_scene(triangles, slopes);
    fnl_renderer *renderer = test_renderer(scene);
    fnl_frame frame = patches_frame(61, 47);
    frame.msaa = SAMPLES;
    for (int way = 0; way < FNL_VISIBILITY_SORT_COUNT + (slopes ? 0 : 2); way++) {
        bool plain = way >= FNL_VISIBILITY_SORT_COUNT; /* the orders of deferred texturing, which do not sort */
        int sort = plain ? FNL_VISIBILITY_SORT_OFF : way;
        frame.shading = !plain                             ? FNL_SHADING_VISIBILITY
                        : way == FNL_VISIBILITY_SORT_COUNT ? FNL_SHADING_TEXTURING
                                                           : FNL_SHADING_VIRTUAL_TEXTURING;
        frame.visibility.sort = (fnl_visibility_sort)sort;
        harness_hooks(renderer)->visibility_bits = sort == FNL_VISIBILITY_SORT_CLASS ? 64 : 32;
        harness_hooks(renderer)->poison = true;
        test_render_frame(renderer, &frame);
        fnl_image radiance = test_read(renderer, FNL_OUTPUT_RADIANCE);
        fnl_frame_stats stats;
        assert_int_equal(fnl_renderer_query_stats(renderer, &stats), FNL_OK);
        uint32_t checked = 0, mixed = 0;
        uint64_t shades = 0;
        float aspect = (float)frame.width / (float)frame.height;
        for (uint32_t y = 0; y < frame.height; y++)
            for (uint32_t x = 0; x < frame.width; x++) {
                uint32_t seen[SAMPLES], distinct = 0;
                float margin = INFINITY;
                vec3 sum = {0, 0, 0};
                for (uint32_t s = 0; s < SAMPLES; s++) {
                    vec2 p = {(((float)x + places[s].x) * 2 / (float)frame.width - 1) * aspect,
                              1 - ((float)y + places[s].y) * 2 / (float)frame.height};
                    uint32_t nearest = UINT32_MAX;
                    for (uint32_t i = 0; i < TRIANGLES; i++)
                        if (flat_holds(&triangles[i], p, &margin)) nearest = i;
                    if (nearest == UINT32_MAX) continue;
                    bool known = false;
                    for (uint32_t k = 0; k < distinct; k++) known = known || seen[k] == nearest;
                    if (!known) seen[distinct++] = nearest;
                    sum = vec3_add(sum, vec3_scale(flat_color(&triangles[nearest], p), 1.0f / SAMPLES));
                }
                shades += visited(renderer, y * frame.width + x) / 2;
                if (margin < 2e-4f) continue; /* too near an edge to call: 1/256 of a pixel is 1.7e-4 */
                checked++;
                mixed += distinct > 1;
                if (sort == FNL_VISIBILITY_SORT_OFF) assert_int_equal(visited(renderer, y * frame.width + x), 2 * distinct);
                assert_pixel(&radiance, x, y, (double)sum.x, (double)sum.y, (double)sum.z, slopes ? 1e-4 : 1e-5);
            }
        print_message("%u pixels checked, %u with several triangles\n", checked, mixed);
        assert_true(checked > frame.width * frame.height * 9 / 10 && mixed > 150);
        if (!plain) assert_int_equal(counter(&stats, "visibility.entries"), counter(&stats, "msaa.surfaces"));
        assert_int_equal(counter(&stats, "msaa.shaded"), counter(&stats, "msaa.surfaces"));
        if (sort == FNL_VISIBILITY_SORT_OFF) assert_true(shades == counter(&stats, "msaa.surfaces"));
        free_picture(&radiance);
    }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

static void test_samples(void **state) {
    UNUSED(state);
    check_samples(false);
    check_samples(true);
}

/* Edges: nearer to 32 samples a pixel, each shaded, than forward shading is, and much nearer than one sample. */
static fnl_scene *turned(void) {
    fnl_scene *scene = test_scene();
    fnl_material_params params = fnl_material_params_default();
    for (int i = 0; i < 5; i++) {
        params.base_color[0] = 0.2f + 0.15f * (float)i;
        params.base_color[1] = 0.9f - 0.15f * (float)i;
        uint32_t mesh = test_sphere_mesh(scene, test_material(scene, &params).index, 7);
        test_place(scene, mesh, (vec3){0.7f * (float)(i - 2), 0.3f * (float)(i % 2), 0.3f * (float)i},
                   (vec3){0.5f, 0.7f, 0.4f});
    }
    for (int i = 0; i < 3; i++) {
        fnl_light_params light = test_point((vec3){2 * (float)(i - 1), 2, 3}, 12, 30);
        fnl_light_id light_id;
        assert_int_equal(fnl_scene_add_light(scene, &light, &light_id), FNL_OK);
    }
    return scene;
}

static double error_of(const fnl_image *image, const double *truth) {
    double sum = 0;
    for (uint32_t i = 0; i < image->width * image->height * 4; i++) {
        double d = (double)((const uint8_t *)image->pixels)[i] - truth[i];
        sum += i % 4 == 3 ? 0 : d * d;
    }
    return sqrt(sum / (image->width * image->height * 3));
}

static void test_edges(void **state) {
    UNUSED(state);
    fnl_scene *scene = turned();
    fnl_renderer *renderer = test_renderer(scene);
    fnl_frame frame = test_frame(FNL_OUTPUT_COLOR);
    frame.width = 97;
    frame.height = 55;
    frame.camera = fnl_camera_default();
    frame.camera.position = (vec3){0.3f, 0.4f, 5};
    frame.camera.target = (vec3){0, 0, 0};
    enum { TIMES = 32 };
    uint32_t count = frame.width * frame.height * 4;
    double *truth = calloc(count, sizeof *truth);
    assert_non_null(truth);
    for (uint32_t i = 0; i < TIMES; i++) {
        frame.jitter = fnl_jitter(i);
        test_render_frame(renderer, &frame);
        fnl_image color = test_read(renderer, FNL_OUTPUT_COLOR);
        for (uint32_t k = 0; k < count; k++) truth[k] += (double)((const uint8_t *)color.pixels)[k] / TIMES;
        free_picture(&color);
    }
    frame.jitter = (fnl_vec2){0, 0};
    static const struct {
        fnl_shading shading;
        uint32_t msaa;
    } cases[] = {{FNL_SHADING_VISIBILITY, 1}, {FNL_SHADING_VISIBILITY, 4}, {FNL_SHADING_FORWARD_PREPASS, 4},
                 {FNL_SHADING_DEFERRED, 4},   {FNL_SHADING_TEXTURING, 4},  {FNL_SHADING_VIRTUAL_TEXTURING, 4}};
    double errors[COUNT_OF(cases)];
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        frame.shading = cases[i].shading;
        frame.msaa = cases[i].msaa;
        test_render_frame(renderer, &frame);
        fnl_image color = test_read(renderer, FNL_OUTPUT_COLOR);
        errors[i] = error_of(&color, truth);
        print_message("%s, %u samples: %.3f of 255\n", fnl_value_name(FNL_ENUM_SHADING, frame.shading), frame.msaa, errors[i]);
        free_picture(&color);
    }
    assert_true(errors[1] < 0.9 * errors[0]);
    assert_true(errors[1] < 1.02 * errors[2]);
    assert_true(errors[1] < 1.02 * errors[3]);
    assert_true(errors[4] < errors[3] && errors[5] < errors[3]);
    free(truth);
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* ---- the grid ---- */

/* Each pixel is that of a plain frame sampled where the grid has the pixel's sample; a quarter of the fragments. */
static void check_grid(fnl_scene *scene, fnl_frame frame, uint32_t bits, double most_fragments) {
    static const fnl_vec2 places[4] = {{0.25f, -0.25f}, {0.25f, 0.25f}, {-0.25f, -0.25f}, {-0.25f, 0.25f}};
    fnl_renderer *renderer = test_renderer(scene);
    fnl_image plain[4];
    fnl_frame_stats stats;
    frame.shading = FNL_SHADING_VISIBILITY;
    frame.count_lights = true;
    harness_hooks(renderer)->visibility_bits = bits;
    for (uint32_t i = 0; i < 4; i++) {
        frame.jitter = places[i];
        test_render_frame(renderer, &frame);
        plain[i] = test_read(renderer, FNL_OUTPUT_RADIANCE);
    }
    assert_int_equal(fnl_renderer_query_stats(renderer, &stats), FNL_OK);
    uint32_t fragments = counter(&stats, "visibility.fragments"), wrong = 0, unlike_centers = 0;
    frame.jitter = (fnl_vec2){0, 0};
    frame.visibility.grid = true;
    fnl_image gridded[FNL_VISIBILITY_SORT_COUNT];
    for (int sort = 0; sort < FNL_VISIBILITY_SORT_COUNT; sort++) {
        frame.visibility.sort = (fnl_visibility_sort)sort;
        test_render_frame(renderer, &frame);
        gridded[sort] = test_read(renderer, FNL_OUTPUT_RADIANCE);
        assert_true(sort == 0 || test_equal(&gridded[0], &gridded[sort]));
    }
    assert_int_equal(fnl_renderer_query_stats(renderer, &stats), FNL_OK);
    for (uint32_t y = 0; y < frame.height; y++)
        for (uint32_t x = 0; x < frame.width; x++) {
            double error = 0, other = 0;
            for (int c = 0; c < 3; c++) {
                double value = (double)test_pixel(&gridded[0], x, y)[c];
                uint32_t own = (y & 1) * 2 + (x & 1);
                error = fmax(error, fabs(value - (double)test_pixel(&plain[own], x, y)[c]));
                other = fmax(other, fabs(value - (double)test_pixel(&plain[3 - own], x, y)[c]));
            }
            wrong += error > 1e-3;
            unlike_centers += other > 1e-3;
        }
    print_message("%ux%u: %u pixels differ (from the opposite places %u), %u fragments of %u\n", frame.width, frame.height,
                  wrong, unlike_centers, (uint32_t)counter(&stats, "visibility.fragments"), fragments);
    assert_true(wrong * 1000 <= frame.width * frame.height);
    if (fragments > 100) assert_true(unlike_centers > 20 * wrong + 20);
    assert_true(counter(&stats, "visibility.fragments") <= most_fragments * fragments);
    assert_true(counter(&stats, "visibility.fragments") * 4 >= fragments);
    for (int i = 0; i < 4; i++) free_picture(&plain[i]);
    for (int i = 0; i < FNL_VISIBILITY_SORT_COUNT; i++) free_picture(&gridded[i]);
    fnl_renderer_destroy(&renderer);
}

static void test_grid(void **state) {
    UNUSED(state);
    struct flat triangles[TRIANGLES];
    fnl_scene *scene = flat_scene(triangles, false);
    fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE);
    frame.width = 160;
    frame.height = 120;
    check_grid(scene, frame, 32, 0.33);
    frame.width = 61;
    frame.height = 47;
    check_grid(scene, frame, 64, 0.45);
    frame.width = frame.height = 1;
    check_grid(scene, frame, 48, 1);
    fnl_scene_destroy(&scene);
    scene = turned();
    frame.width = 97;
    frame.height = 55;
    frame.camera = fnl_camera_default();
    frame.camera.position = (vec3){0.3f, 0.4f, 5};
    frame.camera.target = (vec3){0, 0, 0};
    check_grid(scene, frame, 32, 0.8); /* small triangles reach into more pixels than they cover */
    fnl_renderer *renderer = test_renderer(scene);
    frame.shading = FNL_SHADING_VISIBILITY;
    frame.visibility.grid = true;
    frame.msaa = 4;
    assert_int_equal(fnl_renderer_render(renderer, &frame), FNL_ERROR_UNSUPPORTED);
    frame.msaa = 1;
    frame.visibility.barycentrics = true;
    assert_int_equal(fnl_renderer_render(renderer, &frame), FNL_ERROR_UNSUPPORTED);
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        {"ES-78: sorted by class or material, each pixel is shaded once, to the same bits", test_sorts, NULL, NULL, NULL},
        {"ES-78: keys have as many bits as there are materials", test_plan, NULL, NULL, NULL},
        {"ES-78: the list is in order of classes and materials, and each class has its shader", test_order_of_the_list, NULL,
         spy_tear_down, NULL},
        {"ES-75: each triangle of a pixel is shaded once and weighs its samples", test_samples, NULL, NULL, NULL},
        {"ES-72: a grid of samples has the edges of all pixels, and a quarter of the fragments", test_grid, NULL, NULL,
         NULL},
        {"ES-75: edges are as smooth as forward shading makes them", test_edges, NULL, NULL, NULL}};
    return cmocka_run_group_tests(tests, test_group_begin, test_group_end);
}
