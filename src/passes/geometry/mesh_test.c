/* SPDX-License-Identifier: MIT */
/**
 * Drawing clusters by mesh shaders: pictures and counts against those of vertex shaders. Sizes are powers of two where pictures are compared to the
 * bit: Mesa's CPU driver scales to pixels with one rounding after vertex shaders and with two after mesh shaders, which is the same there alone.
 */
#include "tests/view_cases.h"
#include "passes/geometry/clusters_shared.h"
#include "render/device/clusters.h"
#include "tests/render_test.h"
#include "render/shading.h"
#include "shaders.h"
#include "tests/vulkan_spy.h"

static uint32_t add_shape(fnl_scene *scene, struct scene_primitive primitive) {
    assert_int_equal(mesh_complete(&scene->arena, &primitive), FNL_OK);
    uint32_t mesh = scene_add_mesh(scene, "", &primitive, 1);
    assert_int_not_equal(mesh, SCENE_NONE);
    return mesh;
}

/* A fan of leaves, half of each cut away. */
static uint32_t leaf_mesh(fnl_scene *scene, uint32_t material) {
    static const vec3 positions[6] = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}, {0, -1, 1}, {0, 1, 1}};
    static const vec4 colors[6] = {{1, 1, 1, 0},    {1, 0.5f, 1, 1}, {1, 1, 0.5f, 1},
                                   {0.5f, 1, 1, 0}, {1, 1, 1, 1},    {1, 0, 1, 0}};
    static const uint32_t indices[12] = {0, 1, 2, 0, 2, 3, 4, 1, 2, 4, 2, 5};
    return add_shape(scene, (struct scene_primitive){.material = material,
                                                     .vertex_count = 6,
                                                     .index_count = 12,
                                                     .indices = indices,
                                                     .positions = positions,
                                                     .colors = colors});
}

static uint32_t line_mesh(fnl_scene *scene, uint32_t material) {
    static const vec3 positions[4] = {{-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}};
    static const uint32_t indices[4] = {0, 1, 2, 3};
    return add_shape(scene, (struct scene_primitive){.material = material,
                                                     .topology = SCENE_TOPOLOGY_LINES,
                                                     .vertex_count = 4,
                                                     .index_count = 4,
                                                     .indices = indices,
                                                     .positions = positions});
}

/*
 * Spheres of many clusters and leaves of one, in random places: opaque, cutout and blended, single- and double-sided, mirrored, stretched; lines;
 * a floor that reaches behind the camera, twice, so that of equal depths the last one drawn shows.
 */
static fnl_scene *garden(uint32_t count) {
    fnl_scene *scene = test_scene();
    struct random_state random = {11};
    uint32_t meshes[6];
    for (uint32_t i = 0; i < COUNT_OF(meshes); i++) {
        struct scene_material material = scene_material_default();
        material.base_color = (vec4){0.1f + 0.15f * (float)i, 0.6f, 0.9f - 0.15f * (float)i, i == 5 ? 0.5f : 1};
        material.alpha_mode = i == 5 ? FNL_ALPHA_BLEND : i & 1 ? FNL_ALPHA_MASK : FNL_ALPHA_OPAQUE;
        material.double_sided = i & 2;
        material.roughness = 0.5f;
        material.metallic = 0;
        uint32_t m = scene_add_material(scene, &material);
        meshes[i] = i == 4 ? line_mesh(scene, m) : i & 1 ? leaf_mesh(scene, m) : test_sphere_mesh(scene, m, 6 + 5 * i);
    }
    for (uint32_t i = 0; i < count; i++) {
        vec3 axis =
            vec3_normalize((vec3){random_range(&random, -1, 1), random_range(&random, -1, 1), random_range(&random, -1, 1)});
        float size = random_range(&random, 0.2f, 1);
        mat4 matrix =
            mat4_from_trs((vec3){random_range(&random, -7, 7), random_range(&random, -3, 3), random_range(&random, -7, 7)},
                          quat_axis_angle(axis, random_range(&random, 0, 6)),
                          (vec3){i & 1 ? size : -size, i % 5 ? size : size * random_range(&random, 0.3f, 2), size});
        scene_add_node(scene, "", SCENE_NONE, &matrix, meshes[i % COUNT_OF(meshes)]);
    }
    mat4 ground = mat4_from_trs((vec3){0, -2, 0}, quat_axis_angle((vec3){1, 0, 0}, -PI / 2), (vec3){30, 30, 1});
    for (uint32_t i = 0; i < 2; i++) {
        struct scene_material material = scene_material_default();
        material.base_color = (vec4){i ? 0.1f : 0.9f, 0.5f, i ? 0.9f : 0.1f, 1};
        scene_add_node(scene, "", SCENE_NONE, &ground, test_quad_mesh(scene, scene_add_material(scene, &material)));
    }
    for (uint32_t i = 0; i < 4; i++) {
        fnl_light_params light = test_point((vec3){random_range(&random, -6, 6), 2, random_range(&random, -6, 6)}, 30, 12);
        fnl_light_id id;
        assert_int_equal(fnl_scene_add_light(scene, &light, &id), FNL_OK);
    }
    assert_int_equal(fnl_scene_set_ambient(scene, (vec3){0.2f, 0.2f, 0.3f}, (vec3){0.1f, 0.1f, 0.1f}), FNL_OK);
    return scene;
}

static fnl_frame garden_frame(uint32_t view) {
    fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE);
    frame.width = 64;
    frame.height = 64;
    frame.shading = FNL_SHADING_VISIBILITY;
    frame.culling = FNL_CULLING_TRIANGLES;
    view_cases_look(&frame, view);
    return frame;
}

static fnl_image shoot(fnl_renderer *renderer, fnl_frame frame, fnl_geometry geometry, fnl_frame_stats *out) {
    frame.geometry = geometry;
    test_render_frame(renderer, &frame);
    *out = harness_stats(renderer);
    return test_read(renderer, FNL_OUTPUT_RADIANCE);
}

static void check_counts(const fnl_frame_stats *a, const fnl_frame_stats *b) {
    assert_int_equal(a->triangles_drawn, b->triangles_drawn);
    assert_int_equal(a->triangles_outside, b->triangles_outside);
    assert_int_equal(a->triangles_back, b->triangles_back);
    assert_int_equal(a->triangles_small, b->triangles_small);
    assert_int_equal(a->triangles_occluded, b->triangles_occluded);
    assert_int_equal(a->clusters_drawn, b->clusters_drawn);
    assert_int_equal(b->triangles_drawn + b->triangles_outside + b->triangles_back + b->triangles_small +
                         b->triangles_occluded,
                     b->triangles_total);
}

/* Radiance and counts of the frame by vertex and by mesh shaders. */
static void compare(fnl_renderer *renderer, fnl_frame frame, const char *what) {
    fnl_frame_stats vertex, mesh;
    fnl_image expected = shoot(renderer, frame, FNL_GEOMETRY_VERTEX, &vertex),
              drawn = shoot(renderer, frame, FNL_GEOMETRY_MESH, &mesh);
    if (!test_equal(&expected, &drawn))
        fail_msg("%s, %s, %u samples, culling by %s: mesh shaders change the picture by %g", what,
                 fnl_value_name(FNL_ENUM_SHADING, frame.shading), frame.msaa, fnl_value_name(FNL_ENUM_CULLING, frame.culling),
                 test_difference(&expected, &drawn));
    assert_int_equal(vertex.geometry, FNL_GEOMETRY_VERTEX);
    assert_int_equal(mesh.geometry, FNL_GEOMETRY_MESH);
    assert_int_equal(mesh.items_whole, 0);
    assert_true(mesh.triangles_drawn > 0 && mesh.triangles_drawn < mesh.triangles_total);
    check_counts(&vertex, &mesh);
    free_picture(&expected);
    free_picture(&drawn);
}

static bool has_meshes(void) {
    if (gpu_info(harness_device())->mesh_shader) return true;
    print_message("this device has no mesh shaders\n");
    return false;
}

static void test_orders(void **state) {
    UNUSED(state);
    if (!has_meshes()) skip();
    fnl_scene *scene = garden(60);
    fnl_renderer *renderer = test_renderer(scene);
    harness_hooks(renderer)->poison = true;
    for (uint32_t shading = 0; shading < FNL_SHADING_AUTO; shading++)
        for (uint32_t samples = 1; samples <= 4; samples += 3) {
            if (samples > 1 && !shading_is((fnl_shading)shading, SHADING_SAMPLES)) continue;
            fnl_frame frame = garden_frame(shading % VIEW_COUNT);
            frame.shading = (fnl_shading)shading;
            frame.msaa = samples;
            frame.culling = shading & 1 ? FNL_CULLING_CLUSTERS : FNL_CULLING_TRIANGLES;
            compare(renderer, frame, "an order");
        }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

static void test_views(void **state) {
    UNUSED(state);
    if (!has_meshes()) skip();
    fnl_scene *scene = garden(80);
    fnl_renderer *renderer = test_renderer(scene);
    static const char *const views[] = {"plain", "off-axis", "orthographic", "inside"};
    for (uint32_t view = 0; view < VIEW_COUNT; view++)
        for (uint32_t culling = FNL_CULLING_CLUSTERS; culling < FNL_CULLING_COUNT; culling++)
            for (uint32_t occlusion = 0; occlusion < 2; occlusion++) {
                fnl_frame frame = garden_frame(view);
                frame.culling = (fnl_culling)culling;
                frame.occlusion = occlusion;
                compare(renderer, frame, views[view]);
            }
    /* The view of clusters, which goes by the numbers of triangles. */
    fnl_frame frame = garden_frame(VIEW_PLAIN);
    frame.outputs = FNL_OUTPUT_COLOR;
    frame.debug = FNL_DEBUG_CLUSTERS;
    fnl_image images[2];
    for (int i = 0; i < 2; i++) {
        frame.geometry = i ? FNL_GEOMETRY_MESH : FNL_GEOMETRY_VERTEX;
        test_render_frame(renderer, &frame);
        images[i] = test_read(renderer, FNL_OUTPUT_COLOR);
    }
    assert_true(test_equal(&images[0], &images[1]));
    free_picture(&images[0]);
    free_picture(&images[1]);
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

static void test_skinned(void **state) {
    UNUSED(state);
    if (!has_meshes()) skip();
    fnl_scene *scene = test_load("Fox.glb", true);
    fnl_renderer *renderer = test_renderer(scene);
    fnl_frame frame = garden_frame(VIEW_PLAIN);
    frame.camera.position = (vec3){120, 90, 160};
    frame.camera.target = (vec3){0, 40, 0};
    for (int step = 0; step < 3; step++) {
        assert_int_equal(fnl_scene_set_time(scene, 0, 0.3 * step), FNL_OK);
        frame.shading = step == 1 ? FNL_SHADING_FORWARD : FNL_SHADING_VISIBILITY;
        frame.msaa = step == 1 ? 4 : 1;
        compare(renderer, frame, "Fox");
    }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* At other sizes the rasteriser may see some vertices a rounding error away, no more. */
static void test_odd_sizes(void **state) {
    UNUSED(state);
    if (!has_meshes()) skip();
    fnl_scene *scene = garden(60);
    fnl_renderer *renderer = test_renderer(scene);
    static const uint32_t sizes[][2] = {{1, 1}, {77, 53}, {131, 45}};
    static const fnl_shading orders[] = {FNL_SHADING_FORWARD_PREPASS, FNL_SHADING_DAIS, FNL_SHADING_LIGHT_PREPASS};
    for (uint32_t i = 0; i < COUNT_OF(sizes) * COUNT_OF(orders); i++) {
        fnl_frame frame = garden_frame(VIEW_PLAIN);
        frame.width = sizes[i / COUNT_OF(orders)][0];
        frame.height = sizes[i / COUNT_OF(orders)][1];
        frame.shading = orders[i % COUNT_OF(orders)];
        fnl_frame_stats vertex, mesh;
        fnl_image a = shoot(renderer, frame, FNL_GEOMETRY_VERTEX, &vertex),
                  b = shoot(renderer, frame, FNL_GEOMETRY_MESH, &mesh);
        check_counts(&vertex, &mesh);
        uint32_t different = 0;
        for (uint32_t y = 0; y < frame.height; y++)
            for (uint32_t x = 0; x < frame.width; x++)
                for (uint32_t c = 0; c < 3; c++)
                    if (!(fabsf(test_pixel(&a, x, y)[c] - test_pixel(&b, x, y)[c]) <= 1e-4f)) {
                        different++;
                        break;
                    }
        print_message("%s, %u x %u: %u pixels differ, by %g at most\n", fnl_value_name(FNL_ENUM_SHADING, frame.shading), frame.width,
                      frame.height, different, test_difference(&a, &b));
        assert_true(different * 100 <= frame.width * frame.height);
        free_picture(&a);
        free_picture(&b);
    }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* A pool of clusters that is too small: what does not fit is drawn whole, in its place, and it grows. */
static void test_overflow(void **state) {
    UNUSED(state);
    if (!has_meshes()) skip();
    fnl_scene *scene = garden(60);
    fnl_renderer *renderer = test_renderer(scene);
    static const uint32_t capacities[] = {1, 7, 60};
    for (uint32_t culling = FNL_CULLING_CLUSTERS; culling < FNL_CULLING_COUNT; culling++) {
        fnl_frame frame = garden_frame(VIEW_PLAIN);
        frame.culling = (fnl_culling)culling;
        fnl_frame_stats vertex, mesh;
        fnl_image expected = shoot(renderer, frame, FNL_GEOMETRY_VERTEX, &vertex);
        for (uint32_t i = 0; i < COUNT_OF(capacities); i++) {
            fnl_renderer *own = test_renderer(scene);
            harness_hooks(own)->poison = true;
            harness_hooks(own)->cluster_limit = true;
            own->culling.cluster_capacity = capacities[i];
            own->culling.triangle_capacity = 1; /* which mesh shaders do without */
            fnl_image drawn = shoot(own, frame, FNL_GEOMETRY_MESH, &mesh);
            assert_true(test_equal(&expected, &drawn));
            assert_true(mesh.items_whole > 0 && mesh.triangles_drawn > vertex.triangles_drawn);
            if (i == 0) assert_true(mesh.items_whole > 20);
            assert_int_equal(mesh.triangles_drawn + mesh.triangles_outside + mesh.triangles_back + mesh.triangles_small,
                             mesh.triangles_total);
            free_picture(&drawn);
            harness_hooks(own)->cluster_limit = false;
            for (int k = 0; k < 3; k++) { /* its counts are heeded when its slot comes round */
                drawn = shoot(own, frame, FNL_GEOMETRY_MESH, &mesh);
                assert_true(test_equal(&expected, &drawn));
                free_picture(&drawn);
            }
            assert_int_equal(mesh.items_whole, 0);
            check_counts(&vertex, &mesh);
            fnl_renderer_destroy(&own);
        }
        free_picture(&expected);
    }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* More work groups than a row of them takes, more than a draw takes; and more than any device takes in one dimension. */
static void test_many_groups(void **state) {
    UNUSED(state);
    if (!has_meshes()) skip();
    fnl_scene *scene = garden(60);
    fnl_renderer *renderer = test_renderer(scene);
    static const uint32_t rows[][2] = {{1, 1}, {3, 2}, {5, 64}};
    for (uint32_t i = 0; i < COUNT_OF(rows); i++) {
        harness_hooks(renderer)->mesh_row = rows[i][0];
        harness_hooks(renderer)->mesh_rows = rows[i][1];
        fnl_frame frame = garden_frame(VIEW_PLAIN);
        frame.culling = i & 1 ? FNL_CULLING_CLUSTERS : FNL_CULLING_TRIANGLES;
        compare(renderer, frame, "short rows");
    }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
    scene = test_scene();
    uint32_t quad = test_quad_mesh(scene, SCENE_NONE);
    for (uint32_t i = 0; i < 66000; i++) {
        vec3 at = {((float)(i % 300) - 150) * 0.1f, ((float)(i / 300 % 220) - 110) * 0.1f, -0.001f * (float)(i % 7)};
        test_place(scene, quad, at, (vec3){0.8f, 0.8f, 0.8f});
    }
    renderer = test_renderer(scene);
    fnl_frame frame = garden_frame(VIEW_PLAIN);
    frame.culling = FNL_CULLING_CLUSTERS;
    frame.camera.position = (vec3){0, 0, 30};
    frame.camera.target = (vec3){0, 0, 0};
    fnl_frame_stats vertex, mesh;
    renderer->culling.cluster_capacity = 1 << 17;
    fnl_image a = shoot(renderer, frame, FNL_GEOMETRY_MESH, &mesh), b = shoot(renderer, frame, FNL_GEOMETRY_VERTEX, &vertex);
    assert_true(mesh.clusters_drawn > 65535);
    assert_int_equal(mesh.items_whole, 0);
    assert_true(test_equal(&a, &b));
    check_counts(&vertex, &mesh);
    free_picture(&a);
    free_picture(&b);
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* DAIS shades by a second draw of the scene what its pools cannot hold. */
static void test_gates(void **state) {
    UNUSED(state);
    if (!has_meshes()) skip();
    fnl_scene *scene = garden(60);
    fnl_frame frame = garden_frame(VIEW_PLAIN);
    frame.shading = FNL_SHADING_DAIS;
    fnl_renderer *renderer = test_renderer(scene);
    fnl_frame_stats stats;
    renderer->shading.dais_capacity = 8; /* for next to nothing */
    fnl_image cut = shoot(renderer, frame, FNL_GEOMETRY_MESH, &stats);
    assert_true(counter(&stats, "dais.overflow") > 0);
    assert_int_equal(stats.geometry, FNL_GEOMETRY_MESH);
    frame.shading = FNL_SHADING_FORWARD_PREPASS;
    fnl_image forward = shoot(renderer, frame, FNL_GEOMETRY_MESH, &stats);
    print_message("%g from forward shading\n", test_difference(&cut, &forward));
    assert_true(test_difference(&cut, &forward) < 2e-3);
    free_picture(&cut);
    free_picture(&forward);
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* What has no mesh shaders, or cannot have them in a frame, is drawn by vertex shaders or refused. */
static void test_fallback(void **state) {
    UNUSED(state);
    fnl_scene *scene = garden(40);
    fnl_renderer *renderer = test_renderer(scene);
    fnl_frame frame = garden_frame(VIEW_PLAIN);
    fnl_frame_stats stats;
    harness_hooks(renderer)->no_meshes = true;
    fnl_image expected = shoot(renderer, frame, FNL_GEOMETRY_VERTEX, &stats),
              drawn = shoot(renderer, frame, FNL_GEOMETRY_AUTO, &stats);
    assert_true(test_equal(&expected, &drawn));
    assert_int_equal(stats.geometry, FNL_GEOMETRY_VERTEX);
    assert_int_equal(stats.items_whole, 0);
    free_picture(&drawn);
    frame.geometry = FNL_GEOMETRY_MESH;
    assert_int_equal(fnl_renderer_render(renderer, &frame), FNL_ERROR_UNSUPPORTED);
    assert_non_null(strstr(test_device_memory.last_error, "mesh shaders"));
    frame.geometry = FNL_GEOMETRY_COUNT;
    assert_int_equal(fnl_renderer_render(renderer, &frame), FNL_ERROR_INVALID);
    harness_hooks(renderer)->no_meshes = false;
    if (has_meshes()) {
        frame.geometry = FNL_GEOMETRY_MESH;
        frame.culling = FNL_CULLING_INSTANCES;
        assert_int_equal(fnl_renderer_render(renderer, &frame), FNL_ERROR_UNSUPPORTED);
        assert_non_null(strstr(test_device_memory.last_error, "instances"));
        drawn = shoot(renderer, frame, FNL_GEOMETRY_AUTO, &stats);
        assert_int_equal(stats.geometry, FNL_GEOMETRY_VERTEX);
        assert_true(test_equal(&expected, &drawn));
        free_picture(&drawn);
        frame.culling = FNL_CULLING_TRIANGLES;
        for (int i = 0; i < 2; i++) {
            drawn = shoot(renderer, frame, FNL_GEOMETRY_AUTO, &stats);
            bool cpu = gpu_info(harness_device())->type == FNL_DEVICE_CPU && i == 0;
            assert_int_equal(stats.geometry, cpu ? FNL_GEOMETRY_VERTEX : FNL_GEOMETRY_MESH);
            assert_true(test_equal(&expected, &drawn));
            free_picture(&drawn);
            harness_hooks(renderer)->auto_meshes = true;
        }
        for (int i = 0; i < 3; i++) {
            fnl_frame other = frame;
            if (i == 0) other.visibility.barycentrics = true;
            if (i == 1) other.outputs |= FNL_OUTPUT_MOTION;
            if (i == 2) other.shading = FNL_SHADING_FORWARD_PREPASS, other.lists = FNL_LISTS_BATCHES;
            drawn = shoot(renderer, other, FNL_GEOMETRY_MESH, &stats);
            assert_int_equal(stats.geometry, FNL_GEOMETRY_VERTEX);
            assert_int_equal(stats.items_whole, 0);
            assert_true(stats.triangles_drawn < stats.triangles_total);
            free_picture(&drawn);
        }
    }
    free_picture(&expected);
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* The words of a cluster tell its indices again. */
static void test_words(void **state) {
    UNUSED(state);
    fnl_host host = test_host(&test_device_memory);
    fnl_scene *scene = test_scene();
    uint32_t mesh = test_sphere_mesh(scene, SCENE_NONE, 40);
    const struct scene_primitive *p = &scene->primitives.data[scene->meshes.data[mesh].first_primitive];
    gpu_cluster_list clusters = {0};
    gpu_word_list words = {0};
    uint32_t *indices = malloc(p->index_count * sizeof *indices);
    assert_int_equal(device_clusters_build(&host, p, &clusters, indices, &words), FNL_OK);
    uint32_t end = 0;
    for (uint32_t c = 0; c < clusters.count; c++) {
        const struct gpu_cluster *cluster = &clusters.data[c];
        assert_int_equal(cluster->first_word, end);
        assert_in_range(cluster->vertex_count, 3, CLUSTERS_MOST_VERTICES);
        end += cluster->vertex_count + cluster->triangle_count;
        for (uint32_t i = 0; i < cluster->triangle_count * 3; i++) {
            uint32_t word = words.data[cluster->first_word + cluster->vertex_count + i / 3],
                     corner = word >> i % 3 * 8 & 255;
            assert_true(word < 1u << 24 && corner < cluster->vertex_count);
            assert_int_equal(words.data[cluster->first_word + corner], indices[cluster->first_triangle * 3 + i]);
        }
    }
    assert_int_equal(words.count, end);
    print_message("%u triangles, %.1f bytes each\n", p->index_count / 3, (double)words.count * 4 * 3 / p->index_count);
    free(indices);
    array_free(&host, &clusters);
    array_free(&host, &words);
    fnl_scene_destroy(&scene);
}

/* ---- what reaches the rasteriser ---- */

/* The depth prepass without the rasteriser's own culling of back faces. */
static VkCullModeFlags both_sides(const struct gpu_pipeline *bound, VkCullModeFlags asked) {
    const struct gpu_graphics_params *params = spy_graphics_params(bound);
    return params && !params->fragment && params->depth_write ? VK_CULL_MODE_NONE : asked;
}

/*
 * Counts say what culling decides, not what is drawn after it. Here the rasteriser no longer drops what faces away: whatever of that still
 * reaches it leaves depths before the wall, which then has holes. Each way of drawing draws what culling has left and nothing else.
 */
static void test_what_faces_away_is_not_drawn(void **state) {
    UNUSED(state);
    fnl_scene *scene = test_scene();
    struct scene_material bright = test_unlit(1, 1, 1), dark = test_unlit(0.2f, 0.2f, 0.2f);
    test_place(scene, test_quad_mesh(scene, scene_add_material(scene, &bright)), (vec3){0, 0, -1.2f}, (vec3){4, 4, 1});
    /* The right half is turned away: one cluster, of which culling by triangles leaves the left half. */
    static const vec3 positions[6] = {{-1, -1, 0}, {0, -1, 0}, {1, -1, 0}, {-1, 1, 0}, {0, 1, 0}, {1, 1, 0}};
    static const uint32_t indices[12] = {0, 1, 4, 0, 4, 3, 1, 4, 5, 1, 5, 2};
    uint32_t mesh = add_shape(scene, (struct scene_primitive){.material = scene_add_material(scene, &dark),
                                                              .vertex_count = 6,
                                                              .index_count = 12,
                                                              .indices = indices,
                                                              .positions = positions});
    for (int i = 0; i < 4; i++)
        test_place(scene, mesh, (vec3){(float)(i % 2) - 0.5f, (float)(i / 2) - 0.5f, 0.5f}, (vec3){0.3f, 0.3f, 1});
    static const struct {
        fnl_culling culling;
        fnl_geometry geometry;
        uint32_t least, most; /* pixels with holes */
    } cases[] = {
        {FNL_CULLING_INSTANCES, FNL_GEOMETRY_VERTEX, 500, 64 * 64}, /* the rasteriser would have dropped them */
        {FNL_CULLING_TRIANGLES, FNL_GEOMETRY_VERTEX, 0, 0},
        {FNL_CULLING_TRIANGLES, FNL_GEOMETRY_MESH, 0, 0},
    };
    fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE);
    frame.shading = FNL_SHADING_FORWARD_PREPASS;
    fnl_frame_stats stats;
    spy_begin(test_device);
    fnl_renderer *renderer = test_renderer(scene);
    fnl_image plain = shoot(renderer, frame, FNL_GEOMETRY_VERTEX, &stats);
    spy.cull = both_sides;
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        frame.culling = cases[i].culling;
        fnl_image image = shoot(renderer, frame, cases[i].geometry, &stats);
        if (stats.geometry == cases[i].geometry) {
            uint64_t holes = count_differing(&plain, &image);
            print_message("%s, %s: %llu pixels\n", fnl_value_name(FNL_ENUM_CULLING, cases[i].culling),
                          stats.geometry == FNL_GEOMETRY_MESH ? "mesh" : "vertex", (unsigned long long)holes);
            assert_in_range(holes, cases[i].least, cases[i].most);
        }
        free_picture(&image);
    }
    free_picture(&plain);
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
    spy_end();
}

/* Vertex shaders: which variant draws how often in the passes of a label. Whatever they draw, they write all that is read. */
static uint32_t count_variants(const char *label, const struct gpu_shader *variant) {
    uint32_t count = 0;
    for (uint32_t i = 0; i < spy.work_count; i++) {
        const struct gpu_graphics_params *params = spy_graphics_params(spy.work[i].pipeline);
        if (!params || !params->fragment || !params->vertex) continue;
        if (params->fragment->inputs & ~params->vertex->outputs)
            fail_msg("%s reads what %s does not write", params->fragment->name, params->vertex->name);
        count += !strcmp(spy.work[i].label, label) && params->vertex == variant;
    }
    return count;
}

static void test_vertices_have_what_is_read(void **state) {
    UNUSED(state);
    static const struct {
        fnl_shading shading;
        fnl_light_lists lists;
        const char *label;
        const struct gpu_shader *variant, *cutout; /* of opaque surfaces and of cutouts */
    } cases[] = {
        {FNL_SHADING_VISIBILITY, FNL_LISTS_TILED, "visibility", &shader_geometry_ids_vert, &shader_geometry_cutout_vert},
        {FNL_SHADING_DEFERRED, FNL_LISTS_TILED, "gbuffer", &shader_geometry_surface_vert, &shader_geometry_surface_vert},
        {FNL_SHADING_FORWARD_PREPASS, FNL_LISTS_MULTIPASS, "multipass owners", &shader_geometry_vert, &shader_geometry_vert},
        {FNL_SHADING_FORWARD, FNL_LISTS_TILED, "forward", &shader_geometry_surface_vert, &shader_geometry_surface_vert},
    };
    fnl_scene *scene = garden(60);
    spy_begin(test_device);
    fnl_renderer *renderer = test_renderer(scene);
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        fnl_frame frame = garden_frame(0);
        frame.culling = FNL_CULLING_INSTANCES;
        frame.shading = cases[i].shading;
        frame.lists = cases[i].lists;
        spy_clear();
        test_render_frame(renderer, &frame);
        uint32_t all = 0, others = 0;
        for (uint32_t k = 0; k < spy.work_count; k++) all += !strcmp(spy.work[k].label, cases[i].label);
        uint32_t plain = count_variants(cases[i].label, cases[i].variant), cut = count_variants(cases[i].label, cases[i].cutout);
        others = all - plain - (cases[i].cutout == cases[i].variant ? 0 : cut);
        print_message("%s: %u draws, %u of them for cutouts\n", cases[i].label, all, cut);
        assert_true(plain > 0 && cut > 0);
        assert_int_equal(others, 0);
    }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
    spy_end();
}

int main(void) {
    const struct CMUnitTest tests[] = {
        {"vertex shaders write what fragment shaders read, and little besides", test_vertices_have_what_is_read, NULL, spy_tear_down,
         NULL},
        {"the words of clusters", test_words, NULL, NULL, NULL},
        {"ES-77: what culling leaves out does not reach the rasteriser", test_what_faces_away_is_not_drawn, NULL, spy_tear_down,
         NULL},
        {"ES-77, ES-79: mesh shaders in every view, with occlusion", test_views, NULL, NULL, NULL},
        {"ES-77: mesh shaders draw skinned figures", test_skinned, NULL, NULL, NULL},
        {"ES-77: mesh shaders at odd sizes", test_odd_sizes, NULL, NULL, NULL},
        {"ES-77: an overflowing pool draws items whole by mesh shaders", test_overflow, NULL, NULL, NULL},
        {"ES-77: more work groups than a draw takes", test_many_groups, NULL, NULL, NULL},
        {"ES-77: mesh shaders draw what DAIS has no room for", test_gates, NULL, NULL, NULL},
        {"ES-77: without mesh shaders", test_fallback, NULL, NULL, NULL},
        {"ES-77: mesh shaders draw the same picture in every shading order", test_orders, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests(tests, test_group_begin, test_group_end);
}
