/* SPDX-License-Identifier: MIT */
/** Lists of draw items: the sets, what splitting a mesh does to them, and pictures. */
#include "passes/lights/mesh_lists.h"
#include "tests/list_bench.h"
#include "tests/vulkan_spy.h"

/* Corners and outward faces of a box, counter-clockwise from outside. */
static const uint32_t box_indices[36] = {0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4,
                                         2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5};

static void add_corners(float *out, vec3 center, vec3 half) {
    for (int i = 0; i < 8; i++) {
        out[i * 3] = center.x + (i & 1 ? half.x : -half.x);
        out[i * 3 + 1] = center.y + (i & 2 ? half.y : -half.y);
        out[i * 3 + 2] = center.z + (i & 4 ? half.z : -half.z);
    }
}

static fnl_mesh_id add_boxes(fnl_scene *scene, const vec3 *centers, uint32_t count, vec3 half) {
    float positions[64 * 24];
    uint32_t indices[64 * 36];
    assert_true(count <= 64);
    for (uint32_t b = 0; b < count; b++) {
        add_corners(positions + b * 24, centers[b], half);
        for (uint32_t i = 0; i < 36; i++) indices[b * 36 + i] = b * 8 + box_indices[i];
    }
    fnl_mesh_params params = {
        .vertex_count = count * 8, .index_count = count * 36, .positions = positions, .indices = indices};
    fnl_mesh_id mesh;
    assert_int_equal(fnl_scene_add_mesh(scene, &params, &mesh), FNL_OK);
    return mesh;
}

static void add_instance(fnl_scene *scene, fnl_mesh_id mesh, const mat4 *transform) {
    fnl_instance_id id;
    fnl_mat4 m;
    memcpy(&m, transform, sizeof m);
    assert_int_equal(fnl_scene_add_instance(scene, mesh, &m, &id), FNL_OK);
}

static void add_light(fnl_scene *scene, vec3 position, float range) {
    fnl_light_params light = fnl_light_params_default();
    fnl_light_id id;
    light.position = position;
    light.range = range;
    light.intensity = 40;
    assert_int_equal(fnl_scene_add_light(scene, &light, &id), FNL_OK);
}

static struct stage open_empty(void) {
    fnl_scene *scene;
    assert_int_equal(fnl_scene_create(gpu_host(harness_device()), &scene), FNL_OK);
    struct stage stage = stage_open_scene(scene);
    stage.frame.camera.position = (fnl_vec3){0, 6, 14};
    stage.frame.camera.target = (fnl_vec3){0, 0, 0};
    stage.frame.shading = FNL_SHADING_FORWARD_PREPASS;
    stage.frame.lists = FNL_LISTS_MESH;
    return stage;
}

/* The items' lists as a frame of the stage has them. */
static struct list_copy read_lists_from(struct stage *stage, uint32_t *item_count, uint32_t tree_lights) {
    struct shot shot = stage_shoot(stage, &stage->frame);
    shot_free(&shot); /* now the scene is on the device */
    gpu_device *device = harness_device();
    fnl_renderer *r = stage->renderer;
    assert_int_equal(gpu_wait_idle(device), FNL_OK);
    assert_int_equal(gpu_frame_begin(device), FNL_OK);
    graph_begin(r->graph);
    struct device_scene_frame scene;
    assert_int_equal(device_scene_add(&r->scene_user, r->graph, &scene), FNL_OK);
    struct gpu_view view = view_from_camera(&stage->frame.camera, stage->frame.width, stage->frame.height);
    struct gpu_slice slice = gpu_frame_allocate(device, sizeof view);
    assert_non_null(slice.data);
    memcpy(slice.data, &view, sizeof view);
    const struct light_input input = {.set = scene.lights,
                                      .kinds = 1u << GPU_ENTITY_LIGHT,
                                      .view = slice.address,
                                      .width = stage->frame.width,
                                      .height = stage->frame.height};
    struct lights_in_view in_view = lights_in_view_add(r->graph, device, &input);
    struct mesh_lists_params params = mesh_lists_params_default();
    params.grid.pool_capacity = 1 << 18;
    params.tree_lights = tree_lights;
    struct light_list list = mesh_lists_add(r->graph, device, &input, &in_view, &scene.geometry, &params);
    struct list_readback readback;
    list_readback_add(r->graph, &list, &readback);
    assert_int_equal(graph_compile(r->graph), FNL_OK);
    bool has_tree = false;
    for (uint32_t i = 0; i < r->graph->passes.count; i++)
        has_tree = has_tree || strcmp(r->graph->passes.data[i]->name, "mesh groups") == 0;
    assert_int_equal(has_tree, scene.lights.local_count >= tree_lights);
    assert_int_equal(graph_execute_frame(r->graph, NULL), FNL_OK);
    assert_int_equal(gpu_wait_idle(device), FNL_OK);
    *item_count = scene.geometry.item_count;
    struct gpu_light_list grid = {
        .local_count = scene.lights.local_count, .tiles_x = *item_count, .tiles_y = 1, .slices = 1};
    return list_readback_take(&readback, &grid);
}

/* Whether items ask all lights or a tree of them, their lists are the same. */
static struct list_copy read_lists(struct stage *stage, uint32_t *item_count) {
    struct list_copy flat = read_lists_from(stage, item_count, UINT32_MAX), tree = read_lists_from(stage, item_count, 0);
    assert_true(list_equal(&flat, &tree));
    list_free(&tree);
    return flat;
}

static void check_pictures(struct stage *stage) {
    for (uint32_t s = FNL_SHADING_FORWARD; s <= FNL_SHADING_FORWARD_PREPASS; s++) {
        fnl_frame frame = stage->frame;
        frame.shading = (fnl_shading)s;
        struct shot lists = stage_shoot(stage, &frame);
        frame.lists = FNL_LISTS_ALL;
        struct shot all = stage_shoot(stage, &frame);
        assert_int_equal(count_differing(&lists.radiance, &all.radiance), 0);
        shot_free(&lists);
        shot_free(&all);
    }
}

/* The source's example: O1: L1, O2: L2, O3: L2, O4: L2 and L4, O5: L3 and L4. */
static void test_table_MP_16(void **state) {
    UNUSED(state);
    struct stage stage = open_empty();
    static const vec3 origin = {0, 0, 0};
    fnl_mesh_id mesh = add_boxes(stage.scene, &origin, 1, vec3_make(0.5f, 0.5f, 0.5f));
    static const vec3 objects[5] = {{-6, 0, 0}, {-1, 0, 2}, {-1, 0, -2}, {1, 0, 0}, {4, 0, 0}};
    for (int i = 0; i < 5; i++) {
        mat4 at = mat4_from_trs(objects[i], quat_identity(), vec3_make(1, 1, 1));
        add_instance(stage.scene, mesh, &at);
    }
    add_light(stage.scene, vec3_make(-6, 1.5f, 0), 2);
    add_light(stage.scene, vec3_make(-1, 0.5f, 0), 1.9f);
    add_light(stage.scene, vec3_make(5, 1.5f, 0), 2);
    add_light(stage.scene, vec3_make(2.5f, 0.5f, 0), 1.4f);
    uint32_t item_count;
    struct list_copy list = read_lists(&stage, &item_count);
    assert_int_equal(item_count, 5);
    list_check_form(&list, 4);
    static const uint32_t expected[5] = {1, 2, 2, 2 | 8, 4 | 8}; /* bits of L1 .. L4 */
    for (uint32_t i = 0; i < 5; i++) {
        uint32_t bits = 0;
        for (uint32_t k = 0; k < list.cells[i].count; k++) bits |= 1u << list.ids[list.cells[i].offset + k];
        assert_int_equal(bits, expected[i]);
    }
    list_free(&list);
    check_pictures(&stage);
    stage_close(&stage);
}

/* One mesh of many boxes collects every light; each box by itself has its own few. The picture is the same. */
static void test_splitting_lowers_the_mean_ES_7(void **state) {
    UNUSED(state);
    vec3 centers[49];
    for (int i = 0; i < 49; i++) centers[i] = vec3_make((float)(i % 7 - 3) * 2, 0, (float)(i / 7 - 3) * 2);
    double means[2];
    struct shot shots[2];
    for (int split = 0; split < 2; split++) {
        struct stage stage = open_empty();
        mat4 identity = mat4_identity();
        for (uint32_t i = 0; i < (split ? 49u : 1u); i++) {
            fnl_mesh_id mesh = add_boxes(stage.scene, centers + i, split ? 1 : 49, vec3_make(0.6f, 0.3f, 0.6f));
            add_instance(stage.scene, mesh, &identity);
        }
        for (int i = 0; i < 49; i++) add_light(stage.scene, vec3_add(centers[i], vec3_make(0.3f, 1, 0.2f)), 1.5f);
        uint32_t item_count;
        struct list_copy list = read_lists(&stage, &item_count);
        list_check_form(&list, 49);
        means[split] = (double)list_entries(&list) / item_count;
        list_free(&list);
        check_pictures(&stage);
        stage.frame.count_lights = true;
        shots[split] = stage_shoot(&stage, &stage.frame);
        stage_close(&stage);
    }
    print_message("mean length of a list: %.1f merged, %.1f split; evaluations %llu and %llu\n", means[0], means[1],
                  (unsigned long long)shots[0].stats.evaluations, (unsigned long long)shots[1].stats.evaluations);
    assert_true(means[0] == 49 && means[1] < 10);
    assert_true(shots[1].stats.evaluations * 5 < shots[0].stats.evaluations);
    assert_int_equal(count_differing(&shots[0].radiance, &shots[1].radiance), 0);
    shot_free(&shots[0]);
    shot_free(&shots[1]);
}

/* A box at a place, turned and stretched: half sizes along its own axes. */
struct placed_box {
    vec3 place, axes[3];
    float half[3];
};

static double along_axis(vec3 axis, vec3 v) {
    return (double)axis.x * (double)v.x + (double)axis.y * (double)v.y + (double)axis.z * (double)v.z;
}

static double distance_from_box(const struct placed_box *b, vec3 point) {
    double square = 0;
    for (int k = 0; k < 3; k++) {
        double outside = fmax(fabs(along_axis(b->axes[k], vec3_sub(point, b->place))) - (double)b->half[k], 0);
        square += outside * outside;
    }
    return sqrt(square);
}

/* What items claim to be bounded by: a box along the axes of the view, and the slabs of their own two thinner sides. */
static bool in_claimed_bounds(const struct placed_box *b, const struct gpu_view *view, vec3 light, double radius) {
    int longest = 0;
    double square = 0;
    vec3 to = vec3_sub(light, b->place);
    for (int k = 1; k < 3; k++)
        if (b->half[k] > b->half[longest]) longest = k;
    for (int k = 0; k < 3; k++)
        if (k != longest && fabs(along_axis(b->axes[k], to)) > (double)b->half[k] + radius) return false;
    for (int row = 0; row < 3; row++) {
        const float *m = view->world_to_view.m;
        vec3 axis = {m[row], m[4 + row], m[8 + row]};
        double extent = 0;
        for (int k = 0; k < 3; k++) extent += fabs(along_axis(axis, b->axes[k])) * (double)b->half[k];
        double outside = fmax(fabs(along_axis(axis, to)) - extent, 0);
        square += outside * outside;
    }
    return sqrt(square) <= radius;
}

/* Slanted, stretched, mirrored and flat boxes against lights: held are those that touch, and of the others only what the box along the view and
   two slabs cannot tell. */
static void test_sets_MP_16_ES_7(void **state) {
    UNUSED(state);
    enum { BOXES = 40, LIGHTS = 120 };
    struct random_state random = {17};
    struct stage stage = open_empty();
    static const vec3 origin = {0, 0, 0};
    fnl_mesh_id mesh = add_boxes(stage.scene, &origin, 1, vec3_make(1, 1, 1));
    struct placed_box boxes[BOXES];
    for (int i = 0; i < BOXES; i++) {
        vec3 axis = vec3_normalize(
            vec3_make(random_range(&random, -1, 1), random_range(&random, 0.1f, 1), random_range(&random, -1, 1)));
        quat turn = quat_axis_angle(axis, random_range(&random, 0, 6));
        vec3 size = vec3_make(random_range(&random, 0.05f, 2), i % 5 ? random_range(&random, 0.05f, 2) : 0.001f,
                              random_range(&random, 0.05f, 2) * (i % 3 ? 1.0f : -1.0f));
        vec3 place = vec3_make(random_range(&random, -6, 6), random_range(&random, -2, 3), random_range(&random, -6, 6));
        mat4 transform = mat4_from_trs(place, turn, size);
        add_instance(stage.scene, mesh, &transform);
        boxes[i].place = place;
        for (int k = 0; k < 3; k++) {
            vec3 column = {transform.m[4 * k], transform.m[4 * k + 1], transform.m[4 * k + 2]};
            boxes[i].half[k] = vec3_length(column);
            boxes[i].axes[k] = vec3_normalize(column);
        }
    }
    vec3 at[LIGHTS];
    float ranges[LIGHTS];
    for (int i = 0; i < LIGHTS; i++) {
        at[i] = vec3_make(random_range(&random, -7, 7), random_range(&random, -3, 4), random_range(&random, -7, 7));
        ranges[i] = random_range(&random, 0.1f, 2);
        add_light(stage.scene, at[i], ranges[i]);
    }
    uint32_t item_count;
    struct list_copy list = read_lists(&stage, &item_count);
    assert_int_equal(item_count, BOXES);
    list_check_form(&list, LIGHTS);
    /* Items are sorted by state: mirrored ones lie apart, each kind in order. */
    uint32_t next[2] = {0, 0}, lit = 0, held = 0, near_enough = 0;
    uint32_t plain = 0;
    for (int i = 0; i < BOXES; i++) plain += i % 3 != 0;
    struct gpu_view view = view_from_camera(&stage.frame.camera, stage.frame.width, stage.frame.height);
    for (int order = 0; order < 2; order++) { /* which kind comes first is found out */
        bool right = true;
        next[0] = order ? BOXES - plain : 0;
        next[1] = order ? 0 : plain;
        lit = held = near_enough = 0;
        for (int i = 0; i < BOXES && right; i++) {
            uint32_t item = next[i % 3 == 0]++;
            for (int l = 0; l < LIGHTS; l++) {
                bool in_view = true;
                for (int p = 0; p < 5; p++) {
                    vec4 plane = view.planes[p];
                    in_view = in_view && plane.x * at[l].x + plane.y * at[l].y + plane.z * at[l].z + plane.w > -ranges[l];
                }
                if (!in_view) continue;
                bool holds = list_holds(&list, item, (uint32_t)l);
                held += holds;
                double distance = distance_from_box(&boxes[i], at[l]);
                near_enough += distance < (double)ranges[l];
                if (distance < (double)ranges[l] && !holds) right = false;
                if (holds && !in_claimed_bounds(&boxes[i], &view, at[l], (double)ranges[l] * 1.001 + 1e-3)) right = false;
                lit += distance < (double)ranges[l];
            }
        }
        if (right) break;
        assert_int_equal(order, 0);
    }
    print_message("%u pairs held, %u touch\n", held, near_enough);
    assert_true(lit > 100);
    assert_true(held * 2 < near_enough * 3); /* 1.25 times as many */
    list_free(&list);
    check_pictures(&stage);
    stage_close(&stage);
}

/* Boxes with so many lights each are drawn by the shader whose loop has just enough turns, and by no other. */
static void test_batches_by_number_of_lights_MP_17(void **state) {
    UNUSED(state);
    enum { CLASSES = 7 };
    static const uint32_t counts[] = {0, 0, 1, 2, 2, 3, 4, 5, 8, 8, 9, 16, 17, 30}, turns[CLASSES] = {0, 1, 2, 4, 8, 16, 0},
                          expected[CLASSES] = {2, 1, 2, 2, 3, 2, 2};
    struct gpu_buffer draws;
    assert_int_equal(
        gpu_buffer_create(harness_device(), "draws", CLASSES * sizeof(struct gpu_draw), GPU_MEMORY_READBACK, &draws),
        FNL_OK);
    spy_begin(harness_device());
    struct stage stage = open_empty();
    static const vec3 origin = {0, 0, 0};
    fnl_mesh_id mesh = add_boxes(stage.scene, &origin, 1, vec3_make(0.5f, 0.5f, 0.5f));
    for (uint32_t i = 0; i < COUNT_OF(counts); i++) {
        vec3 at = vec3_make((float)i * 3 - 20, 0, -20);
        mat4 transform = mat4_from_trs(at, quat_identity(), vec3_make(1, 1, 1));
        add_instance(stage.scene, mesh, &transform);
        for (uint32_t l = 0; l < counts[i]; l++)
            add_light(stage.scene, vec3_add(at, vec3_make(0, 0.02f * (float)l, 0.8f)), 1);
    }
    stage.frame.camera.position = (fnl_vec3){0, 2, 30};
    stage.frame.lists = FNL_LISTS_BATCHES;
    stage.frame.record_threads = 1;
    struct shot shot = stage_shoot(&stage, &stage.frame); /* now the graph is there */
    shot_free(&shot);
    spy_clear();
    spy_capture(stage.renderer->graph, "batches draws", "batches draw list", &draws);
    shot = stage_shoot(&stage, &stage.frame);
    const struct gpu_draw *list = draws.mapped;
    for (uint32_t c = 0; c < CLASSES; c++) assert_int_equal(list[c].instance_count, expected[c]);
    uint32_t drawn = 0;
    for (uint32_t i = 0; i < spy.work_count; i++) {
        const struct spy_work *w = &spy.work[i];
        if (strcmp(w->label, "forward batches") != 0) continue;
        const struct gpu_graphics_params *p = spy_graphics_params(w->pipeline);
        assert_true(p && w->indirect && drawn < CLASSES);
        assert_int_equal(w->offset, drawn * sizeof(struct gpu_draw));
        assert_int_equal(p->constants[2], drawn > 0); /* whether there are lights at all */
        assert_int_equal(p->constants[6], turns[drawn]);
        drawn++;
    }
    assert_int_equal(drawn, CLASSES);
    shot_free(&shot);
    spy_end();
    gpu_buffer_destroy(harness_device(), &draws);
    stage_close(&stage);
}

/* What deforms has no bounds: all lights in view are in its list. Blended items have lists too. */
static void test_scenes_ES_7(void **state) {
    UNUSED(state);
    static const char *const sources[] = {"builtin:glass?lights=100", "CesiumMan.glb"};
    for (uint32_t i = 0; i < COUNT_OF(sources); i++) {
        struct stage stage = stage_open(sources[i], i ? 60 : 0);
        stage.frame.lists = FNL_LISTS_MESH;
        stage.frame.shading = FNL_SHADING_FORWARD;
        check_pictures(&stage);
        if (i) {
            uint32_t item_count;
            struct list_copy list = read_lists(&stage, &item_count);
            assert_int_equal(item_count, 1);
            assert_int_equal(list.cells[0].count, list.totals.in_view);
            list_free(&list);
        }
        stage_close(&stage);
    }
}

static void test_overflow_CL_10_ES_7(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:glass?lights=300", 0);
    stage.frame.lists = FNL_LISTS_MESH;
    stage.frame.shading = FNL_SHADING_FORWARD;
    struct shot fits = stage_shoot(&stage, &stage.frame);
    harness_set_pool(&stage, 100);
    struct shot over = stage_shoot(&stage, &stage.frame), next = stage_shoot(&stage, &stage.frame);
    assert_int_equal(fits.stats.overflow_cells, 0);
    assert_true(over.stats.overflow_cells > 0);
    assert_int_equal(next.stats.overflow_cells, 0);
    assert_int_equal(over.stats.list_entries, fits.stats.list_entries);
    assert_int_equal(next.stats.list_entries, fits.stats.list_entries);
    assert_int_equal(count_differing(&fits.radiance, &over.radiance), 0);
    assert_int_equal(count_differing(&fits.radiance, &next.radiance), 0);
    shot_free(&fits);
    shot_free(&over);
    shot_free(&next);
    stage_close(&stage);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_table_MP_16, harness_check),
        cmocka_unit_test_teardown(test_splitting_lowers_the_mean_ES_7, harness_check),
        cmocka_unit_test_teardown(test_sets_MP_16_ES_7, harness_check),
        cmocka_unit_test_teardown(test_batches_by_number_of_lights_MP_17, harness_check),
        cmocka_unit_test_teardown(test_scenes_ES_7, harness_check),
        cmocka_unit_test_teardown(test_overflow_CL_10_ES_7, harness_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
