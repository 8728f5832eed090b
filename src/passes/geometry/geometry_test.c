/* SPDX-License-Identifier: MIT */
/** Prefix sums, culling and sorting, with their buffers read back and compared with the CPU. */
#include "passes/debug/debug.h"
#include "passes/geometry/prefix_sum.h"
#include "passes/shade/gbuffer.h"
#include "tests/render_test.h"

/* ---- frames made by hand ---- */

enum { MAX_READS = 8 };

struct frame_maker {
    struct graph *graph;
    struct gpu_buffer buffers[MAX_READS];
    graph_buffer from[MAX_READS];
    uint64_t sizes[MAX_READS];
    uint32_t count;
};

static struct frame_maker maker_open(void) {
    struct frame_maker m = {0};
    fnl_host host = test_host(&test_device_memory);
    assert_int_equal(graph_create(&host, test_device, &m.graph), FNL_OK);
    return m;
}

static void maker_begin(struct frame_maker *m) {
    for (uint32_t i = 0; i < m->count; i++) gpu_buffer_destroy(test_device, &m->buffers[i]);
    m->count = 0;
    assert_int_equal(gpu_frame_begin(test_device), FNL_OK);
    graph_begin(m->graph);
}

static void maker_close(struct frame_maker *m) {
    for (uint32_t i = 0; i < m->count; i++) gpu_buffer_destroy(test_device, &m->buffers[i]);
    graph_destroy(&m->graph);
}

struct read_data {
    graph_buffer from, to;
    uint64_t size;
};

static void execute_read(const struct graph_context *context, const void *data) {
    const struct read_data *d = data;
    gpu_copy_buffer(context->commands, graph_get_buffer(context, d->from), 0, graph_get_buffer(context, d->to), 0, d->size);
}

/* The contents after maker_end. */
static const void *maker_read(struct frame_maker *m, graph_buffer buffer, uint64_t size) {
    static const char *const names[MAX_READS] = {"read 0", "read 1", "read 2", "read 3",
                                                 "read 4", "read 5", "read 6", "read 7"};
    struct gpu_buffer *to = &m->buffers[m->count];
    assert_int_equal(gpu_buffer_create(test_device, names[m->count], size, GPU_MEMORY_READBACK, to), FNL_OK);
    struct read_data data = {buffer, graph_import_buffer(m->graph, names[m->count], to), size};
    struct graph_pass *pass =
        graph_add_pass(m->graph, names[m->count], GRAPH_QUEUE_GRAPHICS, execute_read, &data, sizeof data);
    graph_use_buffer(pass, data.from, GRAPH_COPY_FROM);
    graph_use_buffer(pass, data.to, GRAPH_COPY_TO);
    m->from[m->count++] = data.to;
    return to->mapped;
}

struct read_image_data {
    graph_image from;
    graph_buffer to;
};

static void execute_read_image(const struct graph_context *context, const void *data) {
    const struct read_image_data *d = data;
    gpu_copy_image_to_buffer(context->commands, graph_get_image(context, d->from), graph_get_buffer(context, d->to), 0);
}

static const void *maker_read_image(struct frame_maker *m, graph_image image, uint64_t size) {
    static const char *const names[MAX_READS] = {"image 0", "image 1", "image 2", "image 3",
                                                 "image 4", "image 5", "image 6", "image 7"};
    struct gpu_buffer *to = &m->buffers[m->count];
    assert_int_equal(gpu_buffer_create(test_device, names[m->count], size, GPU_MEMORY_READBACK, to), FNL_OK);
    struct read_image_data data = {image, graph_import_buffer(m->graph, names[m->count], to)};
    struct graph_pass *pass =
        graph_add_pass(m->graph, names[m->count], GRAPH_QUEUE_GRAPHICS, execute_read_image, &data, sizeof data);
    graph_use_image(pass, data.from, GRAPH_COPY_FROM);
    graph_use_buffer(pass, data.to, GRAPH_COPY_TO);
    m->from[m->count++] = data.to;
    return to->mapped;
}

static void execute_nothing(const struct graph_context *context, const void *data) {
    UNUSED(context);
    UNUSED(data);
}

static void maker_end(struct frame_maker *m) {
    struct graph_pass *pass = graph_add_pass(m->graph, "host", GRAPH_QUEUE_GRAPHICS, execute_nothing, NULL, 0);
    for (uint32_t i = 0; i < m->count; i++) graph_use_buffer(pass, m->from[i], GRAPH_READ_HOST);
    assert_int_equal(graph_compile(m->graph), FNL_OK);
    assert_int_equal(graph_execute_frame(m->graph, NULL), FNL_OK);
    assert_int_equal(gpu_frame_wait(test_device, gpu_frame_number(test_device)), FNL_OK);
}

static VkDeviceAddress send_view(const struct gpu_view *view) {
    struct gpu_frame shared = {.hdr_max = FLT_MAX};
    struct gpu_view sent = *view;
    struct gpu_slice shared_slice = gpu_frame_allocate(test_device, sizeof shared), slice = gpu_frame_allocate(test_device, sizeof sent);
    assert_true(shared_slice.data && slice.data);
    memcpy(shared_slice.data, &shared, sizeof shared);
    sent.frame = shared_slice.address;
    memcpy(slice.data, &sent, sizeof sent);
    return slice.address;
}

/* ---- prefix sum ---- */

static void test_prefix_sum(void **state) {
    UNUSED(state);
    static const uint32_t sizes[] = {1, 2, 1023, 1024, 1025, 5000, (1u << 20) + 3};
    struct frame_maker m = maker_open();
    for (uint32_t s = 0; s < COUNT_OF(sizes); s++) {
        uint32_t count = sizes[s];
        uint32_t *values = malloc((count + 1) * 4ull);
        struct random_state random = {s};
        for (uint32_t i = 0; i < count; i++)
            values[i] = (uint32_t)random_bits(&random) >> (s % 2 ? 0 : 20); /* the large ones saturate */
        values[count] = 0xabcdef01;
        struct gpu_buffer buffer;
        assert_int_equal(gpu_buffer_create(test_device, "values", (count + 1) * 4ull, GPU_MEMORY_DEVICE, &buffer), FNL_OK);
        assert_int_equal(gpu_upload_buffer(test_device, &buffer, 0, values, (count + 1) * 4ull), FNL_OK);
        assert_int_equal(gpu_upload_flush(test_device), FNL_OK);
        maker_begin(&m);
        graph_buffer handle = graph_import_buffer(m.graph, "values", &buffer);
        prefix_sum_add(m.graph, "test", GRAPH_QUEUE_GRAPHICS, handle, count);
        const uint32_t *sums = maker_read(&m, handle, (count + 1) * 4ull);
        maker_end(&m);
        uint32_t sum = 0;
        for (uint32_t i = 0; i < count; i++) {
            if (sums[i] != sum) fail_msg("size %u: sum %u is %u, expected %u", count, i, sums[i], sum);
            sum += MIN(values[i], UINT32_MAX - sum);
        }
        assert_int_equal(sums[count], 0xabcdef01); /* nothing is written past the end */
        gpu_buffer_destroy(test_device, &buffer);
        free(values);
    }
    maker_close(&m);
}

/* ---- culling ---- */

struct culled {
    const uint32_t *sums, *visible, *blend_visible;
    const struct gpu_draw *draws, *blend_draws;
};

static struct culled add_cull(struct frame_maker *m, const struct device_scene_frame *scene, VkDeviceAddress view,
                              struct geometry_draws *out) {
    *out = cull_add(m->graph, &scene->geometry, view);
    struct culled c = {0};
    c.sums = maker_read(m, out->sums, (scene->geometry.item_count + 1) * 4ull);
    c.visible = maker_read(m, out->visible, scene->geometry.item_count * 4ull);
    c.draws = maker_read(m, out->draws, scene->geometry.group_count * sizeof(struct gpu_draw));
    if (scene->geometry.blend_item_count) {
        c.blend_visible = maker_read(m, out->blend_visible, scene->geometry.blend_item_count * 4ull);
        c.blend_draws = maker_read(m, out->blend_draws, scene->geometry.blend_item_count * sizeof(struct gpu_draw));
    }
    return c;
}

/* Items in random places: spheres and squares, opaque and cutout, single- and double-sided, mirrored and not. */
static fnl_scene *crowd(uint32_t count, uint64_t seed) {
    fnl_scene *scene = test_scene();
    uint32_t meshes[6];
    for (uint32_t i = 0; i < COUNT_OF(meshes); i++) {
        struct scene_material material = scene_material_default();
        material.base_color = (vec4){0.1f * (float)i, 0.5f, 1 - 0.1f * (float)i, 1};
        material.alpha_mode = i & 1 ? FNL_ALPHA_MASK : FNL_ALPHA_OPAQUE;
        material.double_sided = i & 2;
        uint32_t m = scene_add_material(scene, &material);
        meshes[i] = i < 3 ? test_sphere_mesh(scene, m, 3 + i) : test_quad_mesh(scene, m);
    }
    struct random_state random = {seed};
    for (uint32_t i = 0; i < count; i++) {
        vec3 axis =
            vec3_normalize((vec3){random_range(&random, -1, 1), random_range(&random, -1, 1), random_range(&random, -1, 1)});
        float size = random_range(&random, 0.05f, 1.5f);
        mat4 matrix = mat4_from_trs(
            (vec3){random_range(&random, -12, 12), random_range(&random, -12, 12), random_range(&random, -12, 12)},
            quat_axis_angle(axis, random_range(&random, 0, 6)),
            (vec3){random_bits(&random) & 1 ? size : -size, size * random_range(&random, 0.3f, 2), size});
        scene_add_node(scene, "", SCENE_NONE, &matrix, meshes[random_bits(&random) % COUNT_OF(meshes)]);
    }
    return scene;
}

static fnl_camera random_camera(struct random_state *random, uint32_t i) {
    fnl_camera camera = fnl_camera_default();
    camera.position = (vec3){random_range(random, -10, 10), random_range(random, -10, 10), random_range(random, -10, 10)};
    camera.target = (vec3){random_range(random, -10, 10), random_range(random, -10, 10), random_range(random, -10, 10)};
    camera.vertical_fov = random_range(random, 0.2f, 2.2f);
    camera.shift = i % 3 == 2 ? (vec2){random_range(random, -1, 1), random_range(random, -1, 1)} : (vec2){0, 0};
    if (i % 4 == 3) {
        camera.orthographic = true;
        camera.vertical_extent = random_range(random, 2, 15);
        camera.far_distance = 100;
    }
    return camera;
}

/* +1: some vertex is well inside of the view; -1: all of its box is well outside of one plane; 0: too near to say. */
static int classify(const struct gpu_view *view, const mat4 *world, const struct scene_primitive *p) {
    for (uint32_t v = 0; v < p->vertex_count; v++) {
        vec3 w = mat4_point(world, p->positions[v]);
        bool inside = true;
        for (int k = 0; k < 5; k++)
            inside =
                inside &&
                vec3_dot((vec3){view->planes[k].x, view->planes[k].y, view->planes[k].z}, w) + view->planes[k].w > 1e-3f;
        if (inside) return 1;
    }
    struct box box = box_transform(&p->bounds, world);
    for (int k = 0; k < 5; k++) {
        vec3 n = {view->planes[k].x, view->planes[k].y, view->planes[k].z};
        vec3 nearest = {n.x > 0 ? box.high.x : box.low.x, n.y > 0 ? box.high.y : box.low.y,
                        n.z > 0 ? box.high.z : box.low.z};
        if (vec3_dot(n, nearest) + view->planes[k].w < -2e-2f) return -1;
    }
    return 0;
}

/* Node of each item: in a bucket by primitive, then handedness, then node. Found from the item's instance on the device. */
static void check_culled(const struct device_scene *d, const struct culled *c, const struct gpu_view *view,
                         const struct gpu_item *items, uint32_t *seen) {
    const fnl_scene *scene = d->scene;
    uint32_t visible = 0;
    for (uint32_t i = 0; i < d->item_count; i++) {
        assert_int_equal(c->sums[i], visible);
        bool marked = c->sums[i + 1] != c->sums[i];
        if (marked) assert_int_equal(c->visible[visible++], i);
        const struct scene_node *node = &scene->nodes.data[items[i].instance]; /* every node draws one instance */
        int expected = classify(view, &node->world, &scene->primitives.data[items[i].primitive]);
        if (expected > 0 && !marked) fail_msg("item %u is lost", i);
        if (expected < 0 && marked) fail_msg("item %u is kept far outside of the view", i);
    }
    assert_int_equal(c->sums[d->item_count], visible);
    uint32_t drawn = 0;
    for (uint32_t b = 0; b < d->buckets.count; b++) {
        const struct geometry_bucket *bucket = &d->buckets.data[b];
        for (uint32_t g = bucket->first_group; g < bucket->first_group + bucket->group_count; g++) {
            const struct gpu_draw *draw = &c->draws[g];
            assert_int_equal(draw->first_instance, drawn);
            for (uint32_t i = drawn; i < drawn + draw->instance_count; i++) {
                const struct gpu_item *item = &items[c->visible[i]];
                const struct scene_primitive *p = &scene->primitives.data[item->primitive];
                const struct scene_material *material = &scene->materials.data[p->material];
                bool mirrored = mat4_determinant3(&scene->nodes.data[item->instance].world) < 0;
                assert_int_equal(draw->index_count, p->index_count);
                assert_int_equal(bucket->double_sided, material->double_sided);
                assert_int_equal(bucket->mask, material->alpha_mode == FNL_ALPHA_MASK);
                if (!bucket->double_sided) assert_int_equal(bucket->mirrored, mirrored);
                seen[b]++;
            }
            drawn += draw->instance_count;
        }
    }
    assert_int_equal(drawn, visible);
}

static void test_culling(void **state) {
    UNUSED(state);
    enum { SIDE = 48, CAMERAS = 24 };
    fnl_scene *scene = crowd(700, 3);
    struct device_scene_user user;
    assert_int_equal(device_scene_open(test_device, scene, &user), FNL_OK);
    const struct device_scene *d = user.scene;
    assert_int_equal(device_scene_prepare(user.scene), FNL_OK);
    assert_int_equal(d->item_count, 700);
    struct gpu_item *items = malloc(d->item_count * sizeof *items);
    assert_int_equal(gpu_read_buffer(test_device, &d->items.buffer, 0, items, d->item_count * sizeof *items), FNL_OK);
    struct frame_maker m = maker_open();
    struct random_state random = {99};
    uint32_t seen[16] = {0}, least = UINT32_MAX, most = 0;
    for (uint32_t k = 0; k < CAMERAS; k++) {
        fnl_camera camera = random_camera(&random, k);
        struct gpu_view view = view_from_camera(&camera, SIDE, SIDE);
        struct device_scene_frame frame;
        struct geometry_draws draws;
        maker_begin(&m);
        assert_int_equal(device_scene_add(&user, m.graph, &frame), FNL_OK);
        VkDeviceAddress address = send_view(&view);
        struct culled c = add_cull(&m, &frame, address, &draws);
        struct aov_images aov = aov_add(m.graph, &frame.geometry, &draws, address, SIDE, SIDE);
        const void *picture = maker_read_image(&m, aov.position, SIDE * SIDE * 16);
        maker_end(&m);
        check_culled(d, &c, &view, items, seen);
        least = MIN(least, c.sums[d->item_count]);
        most = MAX(most, c.sums[d->item_count]);
        float *culled_picture = malloc(SIDE * SIDE * 16);
        memcpy(culled_picture, picture, SIDE * SIDE * 16);

        /* Planes of zeros cull nothing: the picture must be the same to the bit. */
        memset(view.planes, 0, sizeof view.planes);
        maker_begin(&m);
        assert_int_equal(device_scene_add(&user, m.graph, &frame), FNL_OK);
        address = send_view(&view);
        draws = cull_add(m.graph, &frame.geometry, address);
        aov = aov_add(m.graph, &frame.geometry, &draws, address, SIDE, SIDE);
        const uint32_t *sums = maker_read(&m, draws.sums, (d->item_count + 1) * 4ull);
        picture = maker_read_image(&m, aov.position, SIDE * SIDE * 16);
        maker_end(&m);
        assert_int_equal(sums[d->item_count], d->item_count);
        assert_memory_equal(picture, culled_picture, SIDE * SIDE * 16);
        free(culled_picture);
    }
    print_message("%u to %u of %u items visible; items drawn by bucket:", least, most, d->item_count);
    for (uint32_t b = 0; b < d->buckets.count; b++) {
        print_message(" %u", seen[b]);
        assert_true(seen[b] > 0);
    }
    print_message("\n");
    assert_int_equal(d->buckets.count, 6); /* opaque and cutout: plain, mirrored, double-sided */
    assert_true(least < 300 && most > 0);
    maker_close(&m);
    free(items);
    device_scene_close(&user);
    fnl_scene_destroy(&scene);
}

/* ---- sorting ---- */

struct sort_key {
    float depth;
    uint32_t item;
    bool visible;
};

static int compare_keys(const void *a, const void *b) {
    const struct sort_key *x = a, *y = b;
    if (x->visible != y->visible) return x->visible ? -1 : 1;
    if (x->visible && x->depth != y->depth) return x->depth > y->depth ? -1 : 1;
    return x->item < y->item ? -1 : x->item > y->item;
}

static void test_sorting(void **state) {
    UNUSED(state);
    static const uint32_t counts[] = {1, 2, 31, 32, 33, 64, 65, 513, 1000, 5000};
    struct frame_maker m = maker_open();
    for (uint32_t k = 0; k < COUNT_OF(counts); k++) {
        uint32_t count = counts[k];
        fnl_scene *scene = test_scene();
        struct scene_material material = scene_material_default();
        material.alpha_mode = FNL_ALPHA_BLEND;
        uint32_t mesh = test_quad_mesh(scene, scene_add_material(scene, &material)), wall_material;
        struct random_state random = {count};
        struct sort_key *keys = calloc(count, sizeof *keys);
        material.alpha_mode = FNL_ALPHA_OPAQUE; /* opaque items stand before the blended ones */
        wall_material = scene_add_material(scene, &material);
        for (int i = 0; i < 3; i++)
            test_place(scene, test_quad_mesh(scene, wall_material), (vec3){0, 0, -50}, (vec3){1, 1, 1});
        for (uint32_t i = 0; i < count; i++) {
            /* Depths are exact multiples of 1/4, many are equal. Some items are behind the camera, some aside. */
            float z = (float)(random_bits(&random) % 400) * -0.25f + 5;
            float x = random_bits(&random) % 8 == 0 ? 400.0f : random_range(&random, -1, 1);
            test_place(scene, mesh, (vec3){x, 0, z}, (vec3){0.25f, 0.25f, 1});
            keys[i] = (struct sort_key){-z, 3 + i, z < -1 && x < 200};
            if (z >= -1 && z < 0) keys[i].visible = false; /* nearer than the near plane */
        }
        fnl_camera camera = fnl_camera_default();
        camera.position = (vec3){0, 0, 0};
        camera.target = (vec3){0, 0, -1};
        camera.orthographic = true;
        camera.vertical_extent = 100;
        camera.near_distance = 1;
        camera.far_distance = 1000;
        struct gpu_view view = view_from_camera(&camera, 64, 64);
        struct device_scene_user user;
        assert_int_equal(device_scene_open(test_device, scene, &user), FNL_OK);
        const struct device_scene *d = user.scene;
        assert_int_equal(device_scene_prepare(user.scene), FNL_OK);
        assert_int_equal(d->blend_item_count, count);
        assert_int_equal(d->blend_first_item, 3);
        maker_begin(&m);
        struct device_scene_frame frame;
        struct geometry_draws draws;
        assert_int_equal(device_scene_add(&user, m.graph, &frame), FNL_OK);
        struct culled c = add_cull(&m, &frame, send_view(&view), &draws);
        maker_end(&m);
        /* Items exactly on the near plane may go either way: take the device's word, which the test of culling checks. */
        uint32_t visible = 0;
        for (uint32_t i = 0; i < count; i++) {
            bool marked = c.sums[keys[i].item + 1] != c.sums[keys[i].item];
            if (keys[i].depth != 1) assert_int_equal(marked, keys[i].visible);
            keys[i].visible = marked;
            visible += marked;
        }
        qsort(keys, count, sizeof *keys, compare_keys);
        for (uint32_t i = 0; i < count; i++) {
            if (i < visible && c.blend_visible[i] != keys[i].item)
                fail_msg("%u items: place %u holds item %u, expected %u", count, i, c.blend_visible[i], keys[i].item);
            assert_int_equal(c.blend_draws[i].instance_count, i < visible);
            assert_int_equal(c.blend_draws[i].first_instance, i);
            assert_int_equal(c.blend_draws[i].index_count, 6);
        }
        free(keys);
        device_scene_close(&user);
        fnl_scene_destroy(&scene);
    }
    maker_close(&m);
}

/* ---- normals in the G-buffer ---- */

/* shaders/common.glsl in C. */
static void encode_direction(const double n[3], double out[2]) {
    double sum = fabs(n[0]) + fabs(n[1]) + fabs(n[2]), x = n[0] / sum, y = n[1] / sum;
    out[0] = n[2] < 0 ? (1 - fabs(y)) * (x < 0 ? -1 : 1) : x;
    out[1] = n[2] < 0 ? (1 - fabs(x)) * (y < 0 ? -1 : 1) : y;
}

static void decode_direction(const double e[2], double out[3]) {
    double x = e[0], y = e[1], z = 1 - fabs(x) - fabs(y);
    if (z < 0) {
        double folded = (1 - fabs(y)) * (x < 0 ? -1 : 1);
        y = (1 - fabs(x)) * (y < 0 ? -1 : 1);
        x = folded;
    }
    double length = sqrt(x * x + y * y + z * z);
    out[0] = x / length;
    out[1] = y / length;
    out[2] = z / length;
}

/* Degrees; exact for small angles. */
static double angle_between(const double a[3], const double b[3]) {
    double c[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    return atan2(sqrt(c[0] * c[0] + c[1] * c[1] + c[2] * c[2]), a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) * 57.29577951308232;
}

static double worst_octahedral_error(uint32_t bits) {
    struct random_state random = {12};
    double worst = 0, steps = (double)((1u << bits) - 1);
    for (uint32_t i = 0; i < 1000000; i++) {
        double n[3], e[2], back[3], length = 0;
        if (i < 27) { /* axes, edges and corners */
            for (uint32_t c = 0, k = i; c < 3; c++, k /= 3) n[c] = (double)(k % 3) - 1;
            if (i == 13) n[0] = 1;
        } else {
            double z = random_range(&random, -1, 1), phi = random_range(&random, 0, 2 * PI), r = sqrt(1 - z * z);
            n[0] = r * cos(phi);
            n[1] = r * sin(phi);
            n[2] = z;
        }
        for (int c = 0; c < 3; c++) length += n[c] * n[c];
        for (int c = 0; c < 3; c++) n[c] /= sqrt(length);
        encode_direction(n, e);
        for (int c = 0; c < 2; c++) e[c] = round((e[c] * 0.5 + 0.5) * steps) / steps * 2 - 1;
        decode_direction(e, back);
        worst = fmax(worst, angle_between(n, back));
    }
    return worst;
}

static void test_octahedral_normals(void **state) {
    UNUSED(state);
    enum { SIDE = 128 };
    double twelve = worst_octahedral_error(12), sixteen = worst_octahedral_error(16), on_device = 0;
    assert_true(twelve < 0.06 && sixteen < 0.004);
    /* A sphere from eight sides: what the G-buffer holds against the normals that were put in. */
    fnl_scene *scene = test_scene();
    struct scene_material material = scene_material_default();
    material.metallic = 0.2f;
    material.roughness = 0.6f;
    test_place(scene, test_sphere_mesh(scene, scene_add_material(scene, &material), 16), (vec3){0, 0, 0}, (vec3){1, 1, 1});
    struct device_scene_user user;
    assert_int_equal(device_scene_open(test_device, scene, &user), FNL_OK);
    assert_int_equal(device_scene_prepare(user.scene), FNL_OK);
    struct frame_maker m = maker_open();
    uint32_t covered = 0;
    for (uint32_t k = 0; k < 8; k++) {
        fnl_camera camera = test_front_camera();
        camera.position = (vec3){k & 1 ? 3.0f : -3.0f, k & 2 ? 3.0f : -2.5f, k & 4 ? 2.8f : -3.0f};
        struct gpu_view view = view_from_camera(&camera, SIDE, SIDE);
        struct device_scene_frame frame;
        maker_begin(&m);
        assert_int_equal(device_scene_add(&user, m.graph, &frame), FNL_OK);
        VkDeviceAddress address = send_view(&view);
        struct geometry_draws draws = cull_add(m.graph, &frame.geometry, address);
        struct shade_input input = {
            .scene = &frame.geometry, .draws = &draws, .view = address, .width = SIDE, .height = SIDE};
        struct graph_image_params params = {
            .name = "radiance", .format = VK_FORMAT_R16G16B16A16_SFLOAT, .width = SIDE, .height = SIDE};
        graph_image radiance = graph_create_image(m.graph, &params);
        params.name = "depth";
        params.format = GEOMETRY_DEPTH_FORMAT;
        graph_image depth = graph_create_image(m.graph, &params);
        struct gbuffer gbuffer = gbuffer_add(m.graph, &input, false, radiance, depth);
        struct aov_images aov = aov_add(m.graph, &frame.geometry, &draws, address, SIDE, SIDE);
        const uint16_t *packed = maker_read_image(&m, gbuffer.normal, SIDE * SIDE * 8);
        const float *normals = maker_read_image(&m, aov.normal, SIDE * SIDE * 16);
        maker_end(&m);
        for (uint32_t i = 0; i < SIDE * SIDE; i++) {
            const float *n = normals + i * 4;
            if (n[3] <= 0) continue;
            double e[2] = {packed[i * 4] / 65535.0 * 2 - 1, packed[i * 4 + 1] / 65535.0 * 2 - 1}, back[3],
                   given[3] = {n[0], n[1], n[2]};
            decode_direction(e, back);
            on_device = fmax(on_device, angle_between(given, back));
            assert_true(abs((int)packed[i * 4 + 2] - (int)(0.6 * 65535 + 0.5)) <= 1);
            assert_int_equal(packed[i * 4 + 3], 51 * 256 + 255); /* metalness 0.2, no occlusion */
            covered++;
        }
    }
    print_message("octahedral normals off by at most %.4f degrees at 2x12 bits, %.5f at 2x16; %.5f in the G-buffer\n",
                  twelve, sixteen, on_device);
    assert_true(covered > 50000 && on_device < 0.004);
    maker_close(&m);
    device_scene_close(&user);
    fnl_scene_destroy(&scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_prefix_sum),
        cmocka_unit_test(test_culling),
        cmocka_unit_test(test_sorting),
        {"ES-12: octahedral normals keep their directions", test_octahedral_normals, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests_name("geometry", tests, test_group_begin, test_group_end);
}
