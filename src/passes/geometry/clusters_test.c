/* SPDX-License-Identifier: MIT */
/** Culling by clusters and by triangles: pictures against drawing whole items, counts against the CPU. */
#include "tests/view_cases.h"
#include "render/device/clusters.h"
#include "tests/render_test.h"
#include "render/shading.h"

static uint32_t add_shape(fnl_scene *scene, struct scene_primitive primitive) {
    assert_int_equal(mesh_complete(&scene->arena, &primitive), FNL_OK);
    uint32_t mesh = scene_add_mesh(scene, "", &primitive, 1);
    assert_int_not_equal(mesh, SCENE_NONE);
    return mesh;
}

/* A square whose alpha falls from one side to the other: half of it is cut away. */
static uint32_t leaf_mesh(fnl_scene *scene, uint32_t material) {
    static const vec3 positions[4] = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
    static const vec4 colors[4] = {{1, 1, 1, 0}, {1, 0.5f, 1, 1}, {1, 1, 0.5f, 1}, {0.5f, 1, 1, 0}};
    static const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
    return add_shape(scene, (struct scene_primitive){.material = material,
                                                     .vertex_count = 4,
                                                     .index_count = 6,
                                                     .indices = indices,
                                                     .positions = positions,
                                                     .colors = colors});
}

static uint32_t star_mesh(fnl_scene *scene, uint32_t material, enum scene_topology topology) {
    static const vec3 positions[6] = {{-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}};
    static const uint32_t indices[6] = {0, 1, 2, 3, 4, 5};
    return add_shape(scene, (struct scene_primitive){.material = material,
                                                     .topology = topology,
                                                     .vertex_count = 6,
                                                     .index_count = 6,
                                                     .indices = indices,
                                                     .positions = positions});
}

/*
 * Spheres and squares in random places: opaque, cutout and blended, single- and double-sided, mirrored, stretched, as small as a pixel and
 * less; lines and points; a floor that reaches behind the camera.
 */
static fnl_scene *crowd(uint32_t count) {
    fnl_scene *scene = test_scene();
    struct random_state random = {7};
    uint32_t meshes[8];
    for (uint32_t i = 0; i < COUNT_OF(meshes); i++) {
        struct scene_material material = scene_material_default();
        material.base_color = (vec4){0.1f + 0.1f * (float)i, 0.6f, 0.9f - 0.1f * (float)i, i == 7 ? 0.5f : 1};
        material.alpha_mode = i == 7 ? FNL_ALPHA_BLEND : i & 1 ? FNL_ALPHA_MASK : FNL_ALPHA_OPAQUE;
        material.double_sided = i & 2;
        material.roughness = 0.5f;
        material.metallic = 0;
        uint32_t m = scene_add_material(scene, &material);
        meshes[i] = i == 5   ? star_mesh(scene, m, SCENE_TOPOLOGY_LINES)
                    : i == 6 ? star_mesh(scene, m, SCENE_TOPOLOGY_POINTS)
                    : i & 1  ? leaf_mesh(scene, m)
                             : test_sphere_mesh(scene, m, 6 + 5 * i);
    }
    for (uint32_t i = 0; i < count; i++) {
        vec3 axis =
            vec3_normalize((vec3){random_range(&random, -1, 1), random_range(&random, -1, 1), random_range(&random, -1, 1)});
        float size = i % 3 ? random_range(&random, 0.2f, 1) : random_range(&random, 0.01f, 0.1f);
        mat4 matrix =
            mat4_from_trs((vec3){random_range(&random, -7, 7), random_range(&random, -3, 3), random_range(&random, -7, 7)},
                          quat_axis_angle(axis, random_range(&random, 0, 6)),
                          (vec3){i & 1 ? size : -size, i % 5 ? size : size * random_range(&random, 0.3f, 2), size});
        scene_add_node(scene, "", SCENE_NONE, &matrix, meshes[random_bits(&random) % COUNT_OF(meshes)]);
    }
    mat4 floor_matrix = mat4_from_trs((vec3){0, -2, 0}, quat_axis_angle((vec3){1, 0, 0}, -PI / 2), (vec3){30, 30, 1});
    scene_add_node(scene, "", SCENE_NONE, &floor_matrix, test_quad_mesh(scene, SCENE_NONE));
    for (uint32_t i = 0; i < 6; i++) {
        fnl_light_params light = test_point((vec3){random_range(&random, -6, 6), 2, random_range(&random, -6, 6)}, 30, 12);
        fnl_light_id id;
        assert_int_equal(fnl_scene_add_light(scene, &light, &id), FNL_OK);
    }
    assert_int_equal(fnl_scene_set_ambient(scene, (vec3){0.2f, 0.2f, 0.3f}, (vec3){0.1f, 0.1f, 0.1f}), FNL_OK);
    return scene;
}

static fnl_frame crowd_frame(uint32_t view) {
    fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE);
    frame.width = 77;
    frame.height = 53;
    frame.shading = FNL_SHADING_FORWARD;
    frame.lists = FNL_LISTS_ALL;
    view_cases_look(&frame, view);
    return frame;
}

static fnl_image shoot(fnl_renderer *renderer, const fnl_frame *frame) {
    test_render_frame(renderer, frame);
    return test_read(renderer, FNL_OUTPUT_RADIANCE);
}

static fnl_frame_stats stats_of(fnl_renderer *renderer) {
    fnl_frame_stats stats;
    assert_int_equal(fnl_renderer_query_stats(renderer, &stats), FNL_OK);
    return stats;
}

static void check_sum(const fnl_frame_stats *s) {
    assert_int_equal(s->triangles_drawn + s->triangles_outside + s->triangles_back + s->triangles_small +
                         s->triangles_occluded,
                     s->triangles_total);
}

/* Every shading order draws what it drew: radiance is equal to the bit. With several samples the orders take turns in how they cull. */
static void check_order(fnl_renderer *renderer, fnl_shading shading, uint32_t view, uint32_t samples) {
    fnl_frame frame = crowd_frame(view);
    frame.shading = shading;
    frame.msaa = samples;
    fnl_image whole = shoot(renderer, &frame);
    for (uint32_t culling = FNL_CULLING_CLUSTERS; culling < FNL_CULLING_COUNT; culling++) {
        if (samples > 1 && (shading + culling) % 2) continue;
        frame.culling = (fnl_culling)culling;
        fnl_image culled = shoot(renderer, &frame);
        if (!test_equal(&whole, &culled))
            fail_msg("%s, view %u, %u samples: culling by %s changes the picture by %g", fnl_value_name(FNL_ENUM_SHADING, shading), view,
                     samples, fnl_value_name(FNL_ENUM_CULLING, frame.culling), test_difference(&whole, &culled));
        fnl_frame_stats stats = stats_of(renderer);
        check_sum(&stats);
        assert_int_equal(stats.items_whole, 0);
        assert_true(stats.triangles_drawn < stats.triangles_total);
        free_picture(&culled);
    }
    free_picture(&whole);
}

static void test_orders(void **state) {
    UNUSED(state);
    fnl_scene *scene = crowd(90);
    fnl_renderer *renderer = test_renderer(scene);
    harness_hooks(renderer)->poison = true;
    for (uint32_t shading = 0; shading < FNL_SHADING_AUTO; shading++) {
        check_order(renderer, (fnl_shading)shading, shading % VIEW_COUNT, 1);
        if (shading_is((fnl_shading)shading, SHADING_SAMPLES))
            check_order(renderer, (fnl_shading)shading, (shading + 1) % VIEW_COUNT, 4);
    }
    for (uint32_t view = 0; view < VIEW_COUNT; view++) check_order(renderer, FNL_SHADING_VISIBILITY, view, 1);
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* Surfaces, motion and the picture of a skinned figure, which culling knows by the vertices of each frame. */
static void test_skinned(void **state) {
    UNUSED(state);
    fnl_scene *scene = test_load("Fox.glb", true);
    fnl_renderer *renderer = test_renderer(scene);
    fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE | FNL_OUTPUT_MOTION | FNL_OUTPUT_POSITION);
    frame.width = 83;
    frame.height = 61;
    frame.camera = fnl_camera_default();
    frame.camera.position = (vec3){120, 90, 160};
    frame.camera.target = (vec3){0, 40, 0};
    frame.shading = FNL_SHADING_VISIBILITY;
    for (int step = 0; step < 3; step++) {
        fnl_image images[2][3];
        for (int k = 0; k < 2; k++) {
            fnl_renderer *own = test_renderer(scene);
            frame.culling = k ? FNL_CULLING_TRIANGLES : FNL_CULLING_INSTANCES;
            for (int i = 0; i < 2; i++) { /* the second has motion */
                assert_int_equal(fnl_scene_set_time(scene, 0, 0.3 * step + 0.1 * i), FNL_OK);
                test_render_frame(own, &frame);
            }
            images[k][0] = test_read(own, FNL_OUTPUT_RADIANCE);
            images[k][1] = test_read(own, FNL_OUTPUT_MOTION);
            images[k][2] = test_read(own, FNL_OUTPUT_POSITION);
            if (k) {
                fnl_frame_stats stats = stats_of(own);
                check_sum(&stats);
                assert_true(stats.triangles_back * 4 > stats.triangles_total); /* it is looked at triangle by triangle */
                assert_true(stats.triangles_drawn > 0);
            }
            fnl_renderer_destroy(&own);
        }
        for (int i = 0; i < 3; i++) {
            assert_true(test_equal(&images[0][i], &images[1][i]));
            free_picture(&images[0][i]);
            free_picture(&images[1][i]);
        }
    }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* ---- counts ---- */

/* What the rules say of a triangle: 1: it stays; -1: it goes; 0: too near to say. */
static int classify(const struct gpu_view *view, const mat4 *world, const struct scene_primitive *p, uint32_t t,
                    bool double_sided) {
    double x[3], y[3];
    int before = 0, near_plane = 0;
    for (int k = 0; k < 3; k++) {
        vec3 w = mat4_point(world, p->positions[p->indices[3 * t + (uint32_t)k]]);
        const float *m = view->world_to_clip.m;
        double clip[4];
        for (int r = 0; r < 4; r++)
            clip[r] = (double)m[r] * w.x + (double)m[4 + r] * w.y + (double)m[8 + r] * w.z + m[12 + r];
        before += clip[2] > clip[3] * 1.001;
        near_plane += clip[2] > clip[3] * 0.999;
        x[k] = (clip[0] / clip[3] * 0.5 + 0.5) * view->size.x;
        y[k] = (0.5 - clip[1] / clip[3] * 0.5) * view->size.y;
    }
    if (near_plane) return before == 3 ? -1 : 0;
    double area = (y[1] - y[0]) * (x[2] - x[0]) - (x[1] - x[0]) * (y[2] - y[0]), edges = 0;
    for (int k = 0; k < 3; k++) edges += hypot(x[(k + 1) % 3] - x[k], y[(k + 1) % 3] - y[k]);
    if (mat4_determinant3(world) < 0) area = -area;
    double low_x = fmin(x[0], fmin(x[1], x[2])), high_x = fmax(x[0], fmax(x[1], x[2])), low_y = fmin(y[0], fmin(y[1], y[2])),
           high_y = fmax(y[0], fmax(y[1], y[2]));
    const double near = 0.01;
    if (high_x < -near || high_y < -near || low_x > view->size.x + near || low_y > view->size.y + near) return -1;
    double doubt = 0.03 * edges + 0.001;
    if (!double_sided && area < -doubt) return -1;
    if (floor(high_x + near - 0.5) < ceil(low_x - near - 0.5) || floor(high_y + near - 0.5) < ceil(low_y - near - 0.5))
        return -1;
    bool sees =
        floor(high_x - near - 0.5) >= ceil(low_x + near - 0.5) && floor(high_y - near - 0.5) >= ceil(low_y + near - 0.5);
    bool meets = high_x > near && high_y > near && low_x < view->size.x - near && low_y < view->size.y - near;
    return sees && meets && (double_sided || area > doubt);
}

static void test_counts(void **state) {
    UNUSED(state);
    fnl_scene *scene = crowd(150);
    fnl_renderer *renderer = test_renderer(scene);
    for (uint32_t v = 0; v < VIEW_INSIDE; v++) {
        fnl_frame frame = crowd_frame(v);
        frame.jitter = (vec2){0, 0};
        frame.culling = FNL_CULLING_TRIANGLES;
        fnl_image image = shoot(renderer, &frame);
        free_picture(&image);
        fnl_frame_stats stats = stats_of(renderer);
        struct gpu_view view = view_from_camera(&frame.camera, frame.width, frame.height);
        uint64_t least = 0, most = 0, total = 0;
        for (uint32_t n = 0; n < scene->nodes.count; n++) {
            const struct scene_node *node = &scene->nodes.data[n];
            if (node->mesh == SCENE_NONE) continue;
            const struct scene_primitive *p = &scene->primitives.data[scene->meshes.data[node->mesh].first_primitive];
            struct scene_material standard = scene_material_default();
            const struct scene_material *m = p->material == SCENE_NONE ? &standard : &scene->materials.data[p->material];
            if (p->topology != SCENE_TOPOLOGY_TRIANGLES || m->alpha_mode == FNL_ALPHA_BLEND) continue;
            total += p->index_count / 3;
            for (uint32_t t = 0; t < p->index_count / 3; t++) {
                int kind = classify(&view, &node->world, p, t, m->double_sided);
                least += kind > 0;
                most += kind >= 0;
            }
        }
        print_message("view %u: %llu of %llu triangles drawn, %llu to %llu expected; out %llu, back %llu, small %llu\n", v,
                      (unsigned long long)stats.triangles_drawn, (unsigned long long)total, (unsigned long long)least,
                      (unsigned long long)most, (unsigned long long)stats.triangles_outside,
                      (unsigned long long)stats.triangles_back, (unsigned long long)stats.triangles_small);
        assert_int_equal(stats.triangles_total, total);
        check_sum(&stats);
        assert_in_range(stats.triangles_drawn, least, most);
        assert_true(most * 2 < total && least > 0 && most - least < total / 25);
        assert_true(stats.triangles_back * 12 > total && stats.triangles_small * 20 > total && stats.triangles_outside > 0);
        assert_true(stats.clusters_drawn > 0 && stats.clusters_drawn < stats.clusters_total);
    }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/*
 * Upright squares, two fifths of a pixel wide: hundreds have an edge so near to a sample that the rasteriser, which moves vertices to the next
 * 1/256 of a pixel, may cover it though their corners say that they miss. None of those goes.
 */
static void test_small_squares_at_samples(void **state) {
    UNUSED(state);
    enum { COUNT = 15000 };
    fnl_scene *scene = test_scene();
    struct random_state random = {11};
    struct scene_material white = test_unlit(1, 1, 1);
    struct scene_primitive p = {.material = scene_add_material(scene, &white), .vertex_count = 4 * COUNT, .index_count = 6 * COUNT};
    vec3 *positions = ARENA_ARRAY(&scene->arena, vec3, 4 * COUNT);
    uint32_t *indices = ARENA_ARRAY(&scene->arena, uint32_t, 6 * COUNT);
    for (uint32_t i = 0; i < COUNT; i++) {
        const float side = 0.4f / 100, x = random_range(&random, -1, 1), y = random_range(&random, -1, 1);
        for (uint32_t k = 0; k < 4; k++) positions[4 * i + k] = (vec3){x + (k % 3 ? side : 0), y + (k > 1 ? side : 0), 0};
        for (uint32_t k = 0; k < 6; k++) indices[6 * i + k] = 4 * i + (const uint32_t[]){0, 1, 2, 0, 2, 3}[k];
    }
    p.positions = positions;
    p.indices = indices;
    test_place(scene, add_shape(scene, p), (vec3){0, 0, 0}, (vec3){1, 1, 1});
    fnl_renderer *renderer = test_renderer(scene);
    for (uint32_t samples = 1; samples <= 4; samples += 3) {
        fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE);
        frame.width = frame.height = 200;
        frame.msaa = samples;
        fnl_image whole = shoot(renderer, &frame);
        frame.culling = FNL_CULLING_TRIANGLES;
        fnl_image culled = shoot(renderer, &frame);
        assert_true(test_equal(&whole, &culled));
        fnl_frame_stats stats = stats_of(renderer);
        assert_true(stats.triangles_small * (samples == 1 ? 2 : 4) > stats.triangles_total);
        free_picture(&whole);
        free_picture(&culled);
    }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* ---- counts by clusters ---- */

/* Spheres before, beside and beyond the edges of the view, some of them mirrored; and small ones whose clusters lie between pixels. */
static fnl_scene *shoal(void) {
    fnl_scene *scene = test_scene();
    struct random_state random = {5};
    uint32_t sphere = test_sphere_mesh(scene, SCENE_NONE, 24);
    for (uint32_t i = 0; i < 60; i++) {
        bool small = i % 2;
        float size = small ? random_range(&random, 0.03f, 0.06f) : random_range(&random, 0.7f, 1.2f);
        test_place(scene, sphere,
                   (vec3){random_range(&random, -10, 10), random_range(&random, -6, 6), random_range(&random, -2, 4)},
                   (vec3){i % 4 < 2 ? size : -size, size, size});
    }
    return scene;
}

enum { SAYS_OUTSIDE, SAYS_BACK, SAYS_SMALL, SAYS_COUNT };

static int certain(double value, double doubt) { return value > doubt ? 1 : value < -doubt ? -1 : 0; }

/* Beyond a plane of the view by its half size along that plane's normal? */
static int says_outside(const struct gpu_view *view, vec3 center, vec3 half) {
    int beyond = -1;
    for (int i = 0; i < 5; i++) {
        const vec4 *p = &view->planes[i];
        double distance = (double)p->x * center.x + (double)p->y * center.y + (double)p->z * center.z + p->w,
               reach = fabs((double)p->x) * half.x + fabs((double)p->y) * half.y + fabs((double)p->z) * half.z;
        beyond = MAX(beyond, certain(-distance - reach, 2e-3 * reach + 1e-4));
    }
    return beyond;
}

/* What the rules say of a cluster of a sphere (1: so, -1: not so, 0: too near to say) that is placed without being turned. */
static void classify_cluster(const struct gpu_view *view, const struct gpu_cluster *cluster, vec3 place, vec3 size,
                             int out[SAYS_COUNT]) {
    const double scale = fabs((double)size.y), sine = 0.1, cosine = sqrt(1 - 0.01), slack = 1.0 / 256;
    vec3 center = {place.x + size.x * cluster->center.x, place.y + size.y * cluster->center.y,
                   place.z + size.z * cluster->center.z};
    double radius = cluster->radius * scale;
    int beyond = -1;
    for (int i = 0; i < 5; i++) {
        const vec4 *p = &view->planes[i];
        double distance = (double)p->x * center.x + (double)p->y * center.y + (double)p->z * center.z + p->w;
        beyond = MAX(beyond, certain(-distance - radius, 2e-3 * radius + 1e-4));
    }
    out[SAYS_OUTSIDE] = beyond;
    double cutoff =
        cluster->cone_cutoff * cosine + sqrt(fmax(1 - (double)cluster->cone_cutoff * cluster->cone_cutoff, 0)) * sine;
    double pixels =
        0.5 * fmin(fabs(view->size.x / (double)view->ndc_scale.x), fabs(view->size.y / (double)view->ndc_scale.y));
    double away, reach = pixels;
    if (view->orthographic > 0.5f) {
        vec3 d = {-view->back.x * size.x / (float)scale, -view->back.y, -view->back.z};
        away = vec3_dot(d, cluster->cone_axis) - cutoff;
    } else {
        vec3 eye = {(view->eye.x - place.x) / size.x, (view->eye.y - place.y) / size.y, (view->eye.z - place.z) / size.z};
        vec3 to = vec3_sub(cluster->center, eye);
        away = (vec3_dot(to, cluster->cone_axis) - cluster->radius) / vec3_length(to) - cutoff;
        reach = pixels / (vec3_distance(center, view->eye) + radius);
    }
    out[SAYS_BACK] = MIN(certain(away, 3e-3), certain(cluster->thinnest * scale * reach * sine - 8 * slack, 2e-4));
    vec3 seen = mat4_point(&view->world_to_view, center);
    double low[2], high[2], z = -seen.z, near = 0.02;
    const float at[2] = {seen.x, seen.y}, scales[2] = {view->ndc_scale.x, view->ndc_scale.y},
                offsets[2] = {view->ndc_offset.x, view->ndc_offset.y};
    const uint32_t sizes[2] = {view->size.x, view->size.y};
    int small = -1;
    for (int k = 0; k < 2; k++) {
        low[k] = at[k] - radius;
        high[k] = at[k] + radius;
        if (view->orthographic < 0.5f) {
            low[k] = fmin(low[k] / (z - radius), low[k] / (z + radius));
            high[k] = fmax(high[k] / (z - radius), high[k] / (z + radius));
        }
        double p = ((low[k] - offsets[k]) / scales[k] * (k ? -0.5 : 0.5) + 0.5) * sizes[k],
               q = ((high[k] - offsets[k]) / scales[k] * (k ? -0.5 : 0.5) + 0.5) * sizes[k];
        low[k] = fmin(p, q) - 0.5;
        high[k] = fmax(p, q) - 0.5;
        int between = floor(high[k] + near) < ceil(low[k] - near)    ? 1
                      : floor(high[k] - near) >= ceil(low[k] + near) ? -1
                                                                     : 0;
        small = MAX(small, between);
    }
    out[SAYS_SMALL] = z - radius > view->near_distance * 1.01 ? small
                      : z - radius < view->near_distance      ? -1
                                                              : MIN(small, 0);
}

/* Of each test of clusters at least what the CPU is sure of goes, and at most what it cannot rule out. */
static void test_cluster_counts(void **state) {
    UNUSED(state);
    fnl_scene *scene = shoal();
    fnl_renderer *renderer = test_renderer(scene);
    const struct scene_primitive *p = &scene->primitives.data[0];
    fnl_host host = test_host(&test_device_memory);
    gpu_cluster_list clusters = {0};
    uint32_t *indices = malloc(p->index_count * sizeof *indices);
    assert_int_equal(device_clusters_build(&host, p, &clusters, indices, NULL), FNL_OK);
    for (uint32_t v = 0; v < VIEW_INSIDE; v++) {
        fnl_frame frame = crowd_frame(v);
        frame.width = 240;
        frame.height = 150;
        frame.jitter = (vec2){0, 0};
        if (v == VIEW_ORTHOGRAPHIC) frame.camera.near_distance = 9; /* it cuts through them */
        frame.shading = FNL_SHADING_VISIBILITY;
        frame.culling = FNL_CULLING_CLUSTERS;
        fnl_image image = shoot(renderer, &frame);
        free_picture(&image);
        fnl_frame_stats stats = stats_of(renderer);
        struct gpu_view view = view_from_camera(&frame.camera, frame.width, frame.height);
        uint64_t least[SAYS_COUNT + 1] = {0}, most[SAYS_COUNT + 1] = {0}, total = 0;
        for (uint32_t n = 0; n < scene->nodes.count; n++) {
            const struct scene_node *node = &scene->nodes.data[n];
            if (node->mesh == SCENE_NONE) continue;
            const float *m = node->world.m;
            vec3 size = {m[0], m[5], m[10]}, place = {m[12], m[13], m[14]};
            int item = says_outside(&view, place, (vec3){fabsf(size.x), size.y, size.z});
            for (uint32_t c = 0; c < clusters.count; c++) {
                int says[SAYS_COUNT];
                uint32_t triangles = clusters.data[c].triangle_count;
                classify_cluster(&view, &clusters.data[c], place, size, says);
                says[SAYS_OUTSIDE] = MAX(says[SAYS_OUTSIDE], item);
                bool earlier_sure = false, earlier_maybe = false; /* went already; may have */
                for (int k = 0; k < SAYS_COUNT; k++) {
                    if (says[k] > 0 && !earlier_maybe) least[k] += triangles;
                    if (says[k] >= 0 && !earlier_sure) most[k] += triangles;
                    earlier_sure = earlier_sure || says[k] > 0;
                    earlier_maybe = earlier_maybe || says[k] >= 0;
                }
                least[SAYS_COUNT] += earlier_maybe ? 0 : triangles;
                most[SAYS_COUNT] += earlier_sure ? 0 : triangles;
                total += triangles;
            }
        }
        const uint64_t counts[SAYS_COUNT + 1] = {stats.triangles_outside, stats.triangles_back, stats.triangles_small,
                                                 stats.triangles_drawn};
        static const char *const names[SAYS_COUNT + 1] = {"out of view", "facing away", "too small", "drawn"};
        assert_int_equal(stats.triangles_total, total);
        check_sum(&stats);
        for (int k = 0; k <= SAYS_COUNT; k++) {
            print_message("view %u: %llu of %llu triangles %s, %llu to %llu expected\n", v, (unsigned long long)counts[k],
                          (unsigned long long)total, names[k], (unsigned long long)least[k], (unsigned long long)most[k]);
            if (counts[k] < least[k] || counts[k] > most[k]) fail_msg("view %u: %s", v, names[k]);
            assert_true(most[k] - least[k] < total / 25 && least[k] > total / 50);
        }
    }
    free(indices);
    array_free(&host, &clusters);
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* Pools that are too small: what does not fit is drawn whole, in its place, and they grow. */
static void test_overflow(void **state) {
    UNUSED(state);
    fnl_scene *scene = crowd(90);
    fnl_renderer *renderer = test_renderer(scene);
    fnl_frame frame = crowd_frame(VIEW_PLAIN);
    frame.shading = FNL_SHADING_VISIBILITY;
    fnl_image whole = shoot(renderer, &frame);
    static const uint32_t capacities[][2] = {{1, 1}, {30, 100000}, {40, 700}};
    for (uint32_t i = 0; i < COUNT_OF(capacities); i++)
        for (uint32_t culling = FNL_CULLING_CLUSTERS; culling < FNL_CULLING_COUNT; culling++) {
            fnl_renderer *own = test_renderer(scene);
            harness_hooks(own)->poison = true;
            harness_hooks(own)->cluster_limit = true;
            own->culling.cluster_capacity = capacities[i][0];
            own->culling.triangle_capacity = capacities[i][1];
            frame.culling = (fnl_culling)culling;
            fnl_image culled = shoot(own, &frame);
            fnl_frame_stats stats = stats_of(own);
            assert_true(test_equal(&whole, &culled));
            assert_true(stats.items_whole > 0);
            if (i == 0) assert_true(stats.items_whole > 20);
            free_picture(&culled);
            harness_hooks(own)->cluster_limit = false;
            for (int k = 0; k < 3; k++) { /* its counts are heeded when its slot comes round */
                culled = shoot(own, &frame);
                assert_true(test_equal(&whole, &culled));
                free_picture(&culled);
            }
            assert_int_equal(stats_of(own).items_whole, 0);
            fnl_renderer_destroy(&own);
        }
    free_picture(&whole);
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

static void test_repeats(void **state) {
    UNUSED(state);
    fnl_scene *scene = crowd(60);
    fnl_frame frame = crowd_frame(VIEW_PLAIN);
    frame.culling = FNL_CULLING_TRIANGLES;
    fnl_frame_stats stats[2];
    fnl_image images[2];
    for (int i = 0; i < 2; i++) {
        fnl_renderer *renderer = test_renderer(scene);
        images[i] = shoot(renderer, &frame);
        stats[i] = stats_of(renderer);
        fnl_renderer_destroy(&renderer);
    }
    assert_true(test_equal(&images[0], &images[1]));
    assert_int_equal(stats[0].triangles_drawn, stats[1].triangles_drawn);
    assert_int_equal(stats[0].triangles_small, stats[1].triangles_small);
    assert_int_equal(stats[0].clusters_drawn, stats[1].clusters_drawn);
    free_picture(&images[0]);
    free_picture(&images[1]);
    fnl_scene_destroy(&scene);
    /* Nothing, and nothing but lines. */
    for (int i = 0; i < 2; i++) {
        scene = test_scene();
        if (i) test_place(scene, star_mesh(scene, SCENE_NONE, SCENE_TOPOLOGY_LINES), (vec3){0, 0, 0}, (vec3){1, 1, 1});
        fnl_renderer *renderer = test_renderer(scene);
        fnl_image image = shoot(renderer, &frame);
        assert_int_equal(stats_of(renderer).triangles_drawn, 0);
        assert_int_equal(stats_of(renderer).clusters_total, 0);
        free_picture(&image);
        fnl_renderer_destroy(&renderer);
        fnl_scene_destroy(&scene);
    }
}

/* ---- occlusion ---- */

/* A crowd behind walls, and a hole to look through. */
static fnl_scene *walled_crowd(uint32_t *out_wall) {
    fnl_scene *scene = crowd(160);
    struct scene_material material = scene_material_default();
    material.double_sided = true;
    uint32_t quad = test_quad_mesh(scene, scene_add_material(scene, &material));
    *out_wall = test_place(scene, quad, (vec3){-3.5f, 0, 8}, (vec3){4, 3.5f, 1});
    test_place(scene, quad, (vec3){6, 0, 8}, (vec3){4, 3.5f, 1});
    return scene;
}

static void compare_occlusion(fnl_renderer *hides, fnl_renderer *shows, fnl_frame frame, const char *what) {
    frame.occlusion = false;
    fnl_image all = shoot(shows, &frame);
    frame.occlusion = true;
    fnl_image left = shoot(hides, &frame);
    if (!test_equal(&all, &left))
        fail_msg("%s, %s, culling by %s: occlusion changes the picture by %g", what, fnl_value_name(FNL_ENUM_SHADING, frame.shading),
                 fnl_value_name(FNL_ENUM_CULLING, frame.culling), test_difference(&all, &left));
    fnl_frame_stats stats = stats_of(hides);
    if (frame.culling != FNL_CULLING_INSTANCES) check_sum(&stats);
    free_picture(&all);
    free_picture(&left);
}

/*
 * What a frame without a past hides, since all that is in view occludes, a frame with one hides too: what the last frame shows of this one
 * leaves out hidden things alone, and where it shows nothing all occlude.
 */
static void check_hidden(fnl_scene *scene, fnl_renderer *hides, fnl_frame frame, const char *what) {
    fnl_renderer *fresh = test_renderer(scene);
    frame.occlusion = true;
    fnl_image image = shoot(fresh, &frame);
    free_picture(&image);
    uint64_t all = stats_of(fresh).items_occluded, hidden = stats_of(hides).items_occluded;
    print_message("%s: %llu items hidden, %llu without a past\n", what, (unsigned long long)hidden, (unsigned long long)all);
    if (hidden > all || hidden * 20 < all * 19) fail_msg("%s: the last frame misleads", what);
    fnl_renderer_destroy(&fresh);
}

/* Whatever camera and objects do between frames, nothing visible goes. */
static void test_occlusion_moves(void **state) {
    UNUSED(state);
    for (uint32_t culling = 0; culling < FNL_CULLING_COUNT; culling++) {
        uint32_t wall;
        fnl_scene *scene = walled_crowd(&wall);
        fnl_renderer *hides = test_renderer(scene), *shows = test_renderer(scene);
        harness_hooks(hides)->poison = true;
        fnl_frame frame = crowd_frame(VIEW_PLAIN);
        frame.culling = (fnl_culling)culling;
        compare_occlusion(hides, shows, frame, "the first frame");
        uint64_t first = stats_of(hides).items_occluded;
        compare_occlusion(hides, shows, frame, "at rest");
        fnl_frame_stats rest = stats_of(hides);
        print_message("%s: %llu of %llu items hidden, %llu triangles\n", fnl_value_name(FNL_ENUM_CULLING, frame.culling),
                      (unsigned long long)rest.items_occluded, (unsigned long long)rest.items,
                      (unsigned long long)rest.triangles_occluded);
        assert_true(first > 20 && rest.items_occluded > 20); /* the whole scene hides as much as what was seen does */
        if (culling) assert_true(rest.triangles_occluded > rest.triangles_total / 20);
        for (int i = 0; i < 4; i++) { /* a fast pan: a third of the picture a frame */
            frame.camera.target = (vec3){4.0f * (float)i - 6, -0.5f, 0};
            compare_occlusion(hides, shows, frame, "a pan");
            if (culling == 0) check_hidden(scene, hides, frame, "a pan");
        }
        frame.camera.position = (vec3){-1, 1, -12};
        frame.camera.target = (vec3){0, 0, 0};
        compare_occlusion(hides, shows, frame, "a jump to the other side");
        if (culling == 0) check_hidden(scene, hides, frame, "a jump to the other side");
        frame.camera.target = (vec3){-1, 8, -40}; /* the next frame knows nothing */
        compare_occlusion(hides, shows, frame, "nothing in view");
        frame = crowd_frame(VIEW_PLAIN);
        frame.culling = (fnl_culling)culling;
        compare_occlusion(hides, shows, frame, "a jump back");
        if (culling == 0) check_hidden(scene, hides, frame, "a jump back");
        for (int i = 0; i < 3; i++) { /* the wall gives way */
            mat4 matrix = mat4_from_trs((vec3){-3.5f, 3.0f * (float)i, 8}, quat_identity(), (vec3){4, 3.5f, 1});
            scene_move_nodes(scene, &(fnl_instance_id){.index = wall}, &matrix, 1);
            compare_occlusion(hides, shows, frame, "a wall that moves");
        }
        frame.width = 131;
        frame.height = 45;
        compare_occlusion(hides, shows, frame, "another size");
        frame.camera.orthographic = true;
        frame.camera.vertical_extent = 8;
        frame.camera.far_distance = 40;
        compare_occlusion(hides, shows, frame, "an orthographic view");
        compare_occlusion(hides, shows, frame, "an orthographic view at rest");
        frame.msaa = 4;
        compare_occlusion(hides, shows, frame, "four samples");
        fnl_renderer_destroy(&hides);
        fnl_renderer_destroy(&shows);
        fnl_scene_destroy(&scene);
    }
}

/* A square that is moved and stretched along X and Y, or, turned, along Y and X. */
static void move_flat(fnl_scene *scene, uint32_t node, float x, float y, float z, float width, float height, bool turned) {
    mat4 matrix = mat4_from_trs((vec3){turned ? y : x, turned ? x : y, z}, quat_identity(),
                                (vec3){turned ? height : width, turned ? width : height, 1});
    scene_move_nodes(scene, &(fnl_instance_id){.index = node}, &matrix, 1);
}

/*
 * Bars of many lengths behind two walls: what shows through the gap between them stays, however coarse the level that a bar is looked up in,
 * and all go when the gap closes. Of a sphere that a wall hides in part some clusters go.
 */
static void test_occlusion_gaps(void **state) {
    UNUSED(state);
    enum { BARS = 6 };
    fnl_scene *scene = test_scene();
    struct scene_material material = scene_material_default();
    material.double_sided = true;
    material.emissive = (vec3){1, 2, 3};
    uint32_t quad = test_quad_mesh(scene, scene_add_material(scene, &material));
    uint32_t sphere = test_place(scene, test_sphere_mesh(scene, SCENE_NONE, 24), (vec3){0, 0, 60}, (vec3){1, 1, 1});
    uint32_t walls[2] = {test_place(scene, quad, (vec3){-11, 0, 2}, (vec3){10, 10, 1}),
                         test_place(scene, quad, (vec3){11, 0, 2}, (vec3){10, 10, 1})};
    uint32_t bars[BARS];
    for (uint32_t i = 0; i < BARS; i++) bars[i] = test_place(scene, quad, (vec3){0, 0, 0}, (vec3){1, 1, 1});
    fnl_renderer *hides = test_renderer(scene), *shows = test_renderer(scene);
    fnl_frame frame = crowd_frame(VIEW_PLAIN);
    frame.width = 250;
    frame.height = 141;
    frame.camera.position = (vec3){0, 0, 11};
    frame.camera.target = (vec3){0, 0, 0};
    for (int i = 0; i < 36; i++) {
        bool turned = i >= 18, closed = i % 9 == 8; /* turned: the gap runs across */
        for (int k = 0; k < BARS; k++)
            move_flat(scene, bars[k], 0, 1.2f * (float)k - 3, 0, 0.4f * (float)(1 << k), 0.1f, turned);
        /* With samples, half a pixel: some samples look through, the others of their pixels do not. */
        frame.msaa = i % 18 < 9 ? 1 : 4;
        float gap = closed ? -0.5f : frame.msaa == 1 ? 0.08f : 0.012f, at = (turned ? 0.61f : 0.91f) * (float)(i % 9 - 4);
        for (int k = 0; k < 2; k++) move_flat(scene, walls[k], at + (k ? 10 + gap : -10 - gap), 0, 2, 10, 10, turned);
        compare_occlusion(hides, shows, frame, "a gap");
        uint64_t hidden = stats_of(hides).items_occluded;
        if (closed)
            assert_int_equal(hidden, BARS);
        else
            assert_true(hidden < BARS); /* the longest shows */
    }
    frame.msaa = 1;
    mat4 matrix = mat4_from_trs((vec3){-4, 0, -4}, quat_identity(), (vec3){3.8f, 3.8f, 3.8f});
    scene_move_nodes(scene, &(fnl_instance_id){.index = sphere}, &matrix, 1);
    move_flat(scene, walls[0], -10, 0, 2, 10, 10, false);
    move_flat(scene, walls[1], 30, 0, 2, 10, 10, false);
    for (uint32_t culling = FNL_CULLING_CLUSTERS; culling < FNL_CULLING_COUNT; culling++) {
        frame.culling = (fnl_culling)culling;
        compare_occlusion(hides, shows, frame, "half a sphere");
        fnl_frame_stats stats = stats_of(hides);
        uint64_t squares = 2ull * stats.items_occluded;
        print_message("%llu triangles of a sphere of 2304 and %llu items hidden\n",
                      (unsigned long long)(stats.triangles_occluded - squares), (unsigned long long)stats.items_occluded);
        assert_true(stats.triangles_occluded - squares > 600 && stats.triangles_occluded - squares < 2304);
    }
    fnl_renderer_destroy(&hides);
    fnl_renderer_destroy(&shows);
    fnl_scene_destroy(&scene);
}

static void test_occlusion_orders(void **state) {
    UNUSED(state);
    uint32_t wall;
    fnl_scene *scene = walled_crowd(&wall);
    fnl_renderer *hides = test_renderer(scene), *shows = test_renderer(scene);
    for (uint32_t shading = 0; shading < FNL_SHADING_AUTO; shading++)
        for (uint32_t step = 0; step < 2; step++) {
            fnl_frame frame = crowd_frame(VIEW_SHIFTED);
            frame.shading = (fnl_shading)shading;
            frame.camera.position.x += 0.5f * (float)step;
            frame.culling = step ? FNL_CULLING_TRIANGLES : FNL_CULLING_INSTANCES;
            frame.msaa = step && shading_is((fnl_shading)shading, SHADING_SAMPLES) ? 4 : 1;
            compare_occlusion(hides, shows, frame, "an order");
            uint64_t hidden = stats_of(hides).items_occluded;
            assert_int_equal(hidden > 0, shading_is((fnl_shading)shading, SHADING_FULL_RASTER));
        }
    fnl_renderer_destroy(&hides);
    fnl_renderer_destroy(&shows);
    fnl_scene_destroy(&scene);
}

static uint32_t colors_in(const fnl_image *picture) {
    bool found[512] = {false};
    uint32_t count = 0;
    for (uint32_t y = 0; y < picture->height; y++)
        for (uint32_t x = 0; x < picture->width; x++) {
            const uint8_t *c = test_pixel8(picture, x, y);
            bool *color = &found[c[0] >> 5 << 6 | c[1] >> 5 << 3 | c[2] >> 5];
            count += !*color;
            *color = true;
        }
    return count;
}

/* The views of clusters and triangles: the same whatever is left out, and of many colors. */
static void expect_view(fnl_debug_view view) {
    fnl_scene *scene = crowd(60);
    fnl_renderer *renderer = test_renderer(scene);
    fnl_frame frame = crowd_frame(VIEW_PLAIN);
    frame.outputs = FNL_OUTPUT_COLOR;
    frame.debug = view;
    test_render_frame(renderer, &frame);
    fnl_image whole = test_read(renderer, FNL_OUTPUT_COLOR);
    frame.culling = FNL_CULLING_TRIANGLES;
    frame.occlusion = true;
    test_render_frame(renderer, &frame);
    fnl_image culled = test_read(renderer, FNL_OUTPUT_COLOR);
    assert_true(test_equal(&whole, &culled));
    assert_true(colors_in(&whole) > 40);
    free_picture(&whole);
    free_picture(&culled);
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

static void test_view(void **state) {
    UNUSED(state);
    expect_view(FNL_DEBUG_CLUSTERS);
    expect_view(FNL_DEBUG_TRIANGLES);
}

/* ---- cutting ---- */

/* Clusters hold each triangle once, corners in order, and their bounds hold. */
static void test_cutting(void **state) {
    UNUSED(state);
    fnl_host host = test_host(&test_device_memory);
    fnl_scene *scene = test_scene();
    uint32_t mesh = test_sphere_mesh(scene, SCENE_NONE, 40);
    const struct scene_primitive *p = &scene->primitives.data[scene->meshes.data[mesh].first_primitive];
    gpu_cluster_list clusters = {0};
    uint32_t *indices = malloc(p->index_count * sizeof *indices), count = p->index_count / 3, seen = 0;
    assert_int_equal(device_clusters_build(&host, p, &clusters, indices, NULL), FNL_OK);
    bool *found = calloc(count, sizeof *found);
    for (uint32_t c = 0; c < clusters.count; c++) {
        const struct gpu_cluster *cluster = &clusters.data[c];
        assert_int_equal(cluster->first_triangle, seen);
        assert_in_range(cluster->triangle_count, 1, CLUSTERS_MOST_TRIANGLES);
        for (uint32_t t = 0; t < cluster->triangle_count; t++, seen++) {
            uint32_t i = 0;
            while (i < count && (found[i] || memcmp(&p->indices[3 * i], &indices[3 * seen], 12) != 0)) i++;
            assert_true(i < count);
            found[i] = true;
            for (int k = 0; k < 3; k++)
                assert_true(vec3_distance(p->positions[indices[3 * seen + (uint32_t)k]], cluster->center) <=
                            cluster->radius);
        }
    }
    assert_int_equal(seen, count);
    print_message("%u triangles, %u clusters\n", count, clusters.count);
    assert_true(clusters.count * 45 < count);
    free(found);
    free(indices);
    array_free(&host, &clusters);
    fnl_scene_destroy(&scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        {"clusters hold every triangle once", test_cutting, NULL, NULL, NULL},
        {"ES-77: every shading order draws the same picture", test_orders, NULL, NULL, NULL},
        {"ES-77: skinned figures", test_skinned, NULL, NULL, NULL},
        {"ES-77: counts against the CPU", test_counts, NULL, NULL, NULL},
        {"ES-77: small squares at samples stay", test_small_squares_at_samples, NULL, NULL, NULL},
        {"ES-77: counts by clusters against the CPU", test_cluster_counts, NULL, NULL, NULL},
        {"ES-77: overflowing pools draw items whole", test_overflow, NULL, NULL, NULL},
        {"ES-79: pans, jumps and moving walls drop nothing", test_occlusion_moves, NULL, NULL, NULL},
        {"ES-79: gaps show what is behind them", test_occlusion_gaps, NULL, NULL, NULL},
        {"ES-79: every shading order draws the same picture", test_occlusion_orders, NULL, NULL, NULL},
        {"the view of clusters", test_view, NULL, NULL, NULL},
        {"ES-77: two runs, and nothing to cull", test_repeats, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests(tests, test_group_begin, test_group_end);
}
