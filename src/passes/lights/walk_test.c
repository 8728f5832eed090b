/* SPDX-License-Identifier: MIT */
/**
 * The walks by which shaders find lights in trees, in masks and in the spare list, run on the device: what they find, and that they do not
 * look below a node or a word that leaves a point out.
 */
#include "passes/lights/clustered.h"
#include "passes/lights/tree.h"
#include "passes/lights/walk_test.h"
#include "shaders.h"
#include "tests/vulkan_spy.h"

enum { LIGHTS = 1100, POINTS = WALK_POINTS, SIDE = 48, ROW = WALK_ROW };

static fnl_light_params params[LIGHTS];
static struct list_light lights[LIGHTS];
struct gpu_walk_point points[POINTS];

/* ---- the device's answers ---- */

struct walk_data {
    struct gpu_walk_push push;
    uint32_t kind;
};

static void execute_walk(const struct graph_context *context, const void *data) {
    const struct walk_data *d = data;
    struct gpu_compute_params pipeline = {.shader = &shader_walk_test_comp, .constant_count = 1, .constants = {d->kind}};
    gpu_bind(context->commands, gpu_compute_pipeline(context->device, &pipeline));
    gpu_push(context->commands, &d->push, sizeof d->push);
    gpu_dispatch_linear(context->commands, DIVIDE_UP(POINTS, 64u));
}

uint32_t *walk(struct list_lab *lab, const struct light_list *list, const graph_buffer *reads, uint32_t read_count) {
    struct gpu_buffer asked, found;
    gpu_device *device = harness_device();
    assert_int_equal(gpu_buffer_create(device, "asked points", sizeof points, GPU_MEMORY_UPLOAD, &asked), FNL_OK);
    assert_int_equal(gpu_buffer_create(device, "found lights", POINTS * ROW * 4ull, GPU_MEMORY_READBACK, &found), FNL_OK);
    memcpy(asked.mapped, points, sizeof points);
    graph_buffer handles[2] = {graph_import_buffer(lab->graph, "asked points", &asked),
                               graph_import_buffer(lab->graph, "found lights", &found)};
    struct walk_data data = {{list->header, asked.address, found.address, POINTS}, list->kind};
    struct graph_pass *pass = graph_add_pass(lab->graph, "walk", GRAPH_QUEUE_GRAPHICS, execute_walk, &data, sizeof data);
    light_list_use(pass, list, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, handles[0], GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, handles[1], GRAPH_WRITE_COMPUTE);
    graph_buffer all[LIST_READS] = {handles[1]}; /* keeps the walk, which nothing else depends on */
    if (read_count) memcpy(all + 1, reads, read_count * sizeof *reads);
    list_lab_run(lab, all, read_count + 1);
    uint32_t *rows = list_reads_take(&lab->reads, 0);
    gpu_buffer_destroy(device, &asked);
    gpu_buffer_destroy(device, &found);
    return rows;
}

/* ---- made-up lights ---- */

/* A small square of the screen, and lights all over it in no order of depth. */
static struct gpu_view many_lights(struct random_state *random) {
    fnl_camera camera = fnl_camera_default();
    camera.vertical_fov = 0.1f;
    struct gpu_view view = view_from_camera(&camera, SIDE, SIDE);
    for (uint32_t i = 0; i < LIGHTS; i++) {
        double at[3], world[3];
        view_of_pixel(&view, (double)random_range(random, 0, SIDE), (double)random_range(random, 0, SIDE),
                      exp2((double)random_range(random, 1, 8)), at);
        view_to_world(&view, at, world);
        params[i] = fnl_light_params_default();
        params[i].position = vec3_make((float)world[0], (float)world[1], (float)world[2]);
        params[i].range = (i % 4 ? 0.02f : 0.1f) * -(float)at[2];
        lights[i] = list_light_of(&params[i], i);
    }
    for (uint32_t i = 0; i < POINTS; i++) {
        points[i].pixel.x = random_bits(random) % SIDE;
        points[i].pixel.y = random_bits(random) % SIDE;
        points[i].view_depth = exp2f(random_range(random, 0.5f, 8.5f));
        double at[3], world[3];
        view_of_pixel(&view, points[i].pixel.x + 0.5, points[i].pixel.y + 0.5, (double)points[i].view_depth, at);
        view_to_world(&view, at, world);
        points[i].position = vec3_make((float)world[0], (float)world[1], (float)world[2]);
    }
    return view;
}

/* ---- trees ---- */

static VkDeviceAddress send(const void *data, uint64_t size) {
    struct gpu_slice slice = gpu_frame_allocate(harness_device(), size);
    assert_non_null(slice.data);
    memcpy(slice.data, data, size);
    return slice.address;
}

/*
 * Entries of a cell that a walk finds at a depth: leaves whose range holds it, and of no inner node above of which the range does not. Without
 * recursion: whatever lies between a node and the end of its subtree is below it.
 */
static void expect_of_tree(const struct light_tree *tree, uint32_t cell, float view_depth, bool expected[LIGHTS]) {
    struct gpu_cell c = tree->cells.data[cell];
    uint32_t code = light_tree_depth_code(view_depth);
    memset(expected, 0, LIGHTS * sizeof *expected);
    for (uint32_t first = 0; first < c.count; first += GPU_TREE_LIGHTS) {
        const uint32_t *nodes = tree->nodes.data + 4 * ((size_t)c.offset + first);
        bool hidden[2 * GPU_TREE_LIGHTS + 1] = {false};
        for (uint32_t node = 1; node <= nodes[0]; node++) {
            uint32_t range = nodes[2 * node], link = nodes[2 * node + 1];
            bool holds = code >= (range & 0xffff) && code <= range >> 16;
            if (!(link & GPU_TREE_LEAF)) {
                for (uint32_t below = node + 1; !holds && below < link; below++) hidden[below] = true;
            } else if (holds && !hidden[node]) {
                expected[tree->ids.data[c.offset + first + (link & ~GPU_TREE_LEAF)]] = true;
            }
        }
    }
}

/* In each tree one inner node loses its range: nothing below it is found then, and all else is. A walk that goes on to the next node
   where it should skip to the end of the subtree would find it. */
static void test_walks_skip_subtrees_ES_66(void **state) {
    UNUSED(state);
    struct random_state random = {14};
    struct gpu_view view = many_lights(&random);
    gpu_device *device = harness_device();
    uint32_t totals[2] = {0};
    for (uint32_t spoiled = 0; spoiled < 2; spoiled++) {
        struct list_lab lab = list_lab_open(&view, lights, LIGHTS);
        list_lab_begin(&lab);
        struct light_list list = {.kind = GPU_LIST_TREE, .lights = lab.input.set.buffer};
        struct gpu_light_list *header = light_list_header(device, &lab.input, &list.header);
        assert_non_null(header);
        header->tile_size = 16;
        header->tiles_x = header->tiles_y = DIVIDE_UP(SIDE, 16);
        struct light_tree tree;
        light_tree_init(&tree, gpu_host(device));
        struct gpu_entity_bounds *bounds = list_bounds_of(lights, LIGHTS);
        assert_int_equal(light_tree_see(&tree, bounds, LIGHTS, 1u << GPU_ENTITY_LIGHT, &view), FNL_OK);
        free(bounds);
        assert_int_equal(light_tree_build(&tree, gpu_jobs(device), header, &view, false), FNL_OK);
        for (uint32_t c = 0; c < tree.cells.count && spoiled; c++)
            for (uint32_t first = 0; first < tree.cells.data[c].count; first += GPU_TREE_LIGHTS) {
                uint32_t *nodes = tree.nodes.data + 4 * ((size_t)tree.cells.data[c].offset + first), node = 2;
                assert_true(nodes[0] > 8);
                for (uint32_t steps = random_bits(&random) % 4; steps > 0 || nodes[2 * node + 1] & GPU_TREE_LEAF; node++)
                    steps -= steps > 0;
                nodes[2 * node] = 0xffff; /* from the farthest to the nearest */
            }
        header->cells = send(tree.cells.data, tree.cells.count * sizeof *tree.cells.data);
        header->ids = send(tree.ids.data, tree.ids.count * 4ull);
        header->extra = send(tree.nodes.data, tree.nodes.count * 4ull);
        uint32_t *rows = walk(&lab, &list, NULL, 0);
        for (uint32_t i = 0; i < POINTS; i++) {
            bool expected[LIGHTS];
            uint32_t count = 0;
            expect_of_tree(&tree, points[i].pixel.y / 16 * header->tiles_x + points[i].pixel.x / 16, points[i].view_depth,
                           expected);
            for (uint32_t light = 0; light < LIGHTS; light++)
                if (expected[light]) {
                    assert_true(count < rows[i * ROW]);
                    assert_int_equal(rows[i * ROW + 1 + count++], light);
                }
            assert_int_equal(rows[i * ROW], count);
            totals[spoiled] += count;
        }
        free(rows);
        light_tree_finish(&tree);
        list_lab_close(&lab);
    }
    print_message("trees: %u lights found, %u with one inner node of each tree spoiled\n", totals[0], totals[1]);
    assert_true(totals[1] > 100 && totals[1] * 10 < totals[0] * 9);
}

/* ---- masks ---- */

enum spoil { SPOIL_NOTHING, SPOIL_TILE_TOP, SPOIL_BIN_TOP, SPOIL_TILE_WORDS, SPOIL_BIN_WORDS, SPOIL_COUNT };

/*
 * One word of the table is emptied once it is made: the top word of a tile or of a bin, or which words its first group has. Points in that tile
 * or bin then find nothing, or nothing of the first 1024 lights; all others find what they did.
 */
static void test_walks_and_masks_ES_64(void **state) {
    UNUSED(state);
    enum { TILE = 4, BIN = 60, BINS = 128, TILES = 9, HEAD = 4 };
    struct random_state random = {15};
    struct gpu_view view = many_lights(&random);
    gpu_device *device = harness_device();
    struct zbin_params zbin = zbin_params_default();
    zbin.near = 1;
    zbin.far = 400;
    for (uint32_t i = 0; i < POINTS; i += 3) points[i].view_depth = powf(400, 59.5f / 126); /* the middle of the bin */
    for (uint32_t i = 0; i < POINTS; i += 6) points[i].pixel.x = points[i].pixel.y = 20;    /* in the tile */
    uint32_t *plain = NULL;
    for (uint32_t spoil = 0; spoil < SPOIL_COUNT; spoil++) {
        struct list_lab lab = list_lab_open(&view, lights, LIGHTS);
        list_lab_begin(&lab);
        struct light_list list = zbin_add(lab.graph, device, &lab.input, &lab.in_view, &zbin);
        bool of_bin = spoil == SPOIL_BIN_TOP || spoil == SPOIL_BIN_WORDS, tops = spoil <= SPOIL_BIN_TOP;
        /* As shaders/lights/bins.glsl lays the table out: two groups of lights in view, one top word. */
        uint32_t cell = of_bin ? TILES + BIN : TILE,
                 word = tops ? HEAD + cell * 2 + 1 : HEAD + (TILES + BINS) * 2 + cell * 4 + 1;
        struct gpu_buffer nothing;
        assert_int_equal(gpu_buffer_create(device, "an empty word", 4, GPU_MEMORY_UPLOAD, &nothing), FNL_OK);
        memset(nothing.mapped, 0, 4);
        spy_begin(device);
        if (spoil) spy_overwrite(lab.graph, "zbin fill", "zbin table", word * 4ull, 4, &nothing);
        uint32_t *rows = walk(&lab, &list, (graph_buffer[]){list.cells, list.extra}, 2), lost = 0, spared = 0;
        spy_end();
        const uint32_t *table = lab.reads.buffers[1].mapped, *visible = lab.reads.buffers[2].mapped;
        assert_true(table[0] > 1024 && table[1] == 2 && table[2] == 1);
        for (uint32_t i = 0; i < POINTS && spoil; i++) {
            bool in_tile = points[i].pixel.y / 16 * 3 + points[i].pixel.x / 16 == TILE;
            double slice = log2((double)points[i].view_depth) / log2(400) * 126 + 1;
            bool hit = of_bin ? slice >= BIN && slice < BIN + 1 : in_tile;
            uint32_t count = 0;
            for (uint32_t k = 0; k < plain[i * ROW]; k++) {
                uint32_t light = plain[i * ROW + 1 + k];
                if (hit && (tops || light < visible[1024])) {
                    lost++;
                    continue;
                }
                assert_true(count < rows[i * ROW]);
                assert_int_equal(rows[i * ROW + 1 + count++], light);
            }
            assert_int_equal(rows[i * ROW], count);
            spared += count;
        }
        assert_true(!spoil || (lost > 30 && spared > 30));
        gpu_buffer_destroy(device, &nothing);
        list_lab_close(&lab);
        if (spoil)
            free(rows);
        else
            plain = rows;
    }
    free(plain);
}

/* ---- the spare list ---- */

/* Whether a sphere, `slack` larger, lies in the point's tile of the screen and in its range of depth, as spare lists cut them. */
static bool spare_holds(const struct gpu_view *view, const struct list_light *light, const struct gpu_walk_point *point,
                        double slack) {
    const double world[3] = {(double)light->bounds.center.x, (double)light->bounds.center.y, (double)light->bounds.center.z};
    double at[3], radius = (double)light->bounds.radius, near = (double)view->near_distance;
    world_to_view(view, world, at);
    radius += slack * (radius + fabs(at[2]) * 0.01);
    if (-at[2] + radius < near) return false;
    double bins[3] = {-at[2] - radius, -at[2] + radius, (double)point->view_depth};
    for (int i = 0; i < 3; i++) bins[i] = fmin(fmax(2 * log2(fmax(bins[i], 1e-30) / near), 0), SPARE_BINS - 1);
    double own = floor(bins[2]);
    if (bins[0] - slack >= own + 1 || bins[1] + slack < own) return false;
    for (int axis = 0; axis < 2; axis++) {
        double slopes[2], pixels[2];
        reference_slopes(at[axis], -at[2], radius, near, slopes);
        for (int i = 0; i < 2; i++) {
            double scale = axis ? (double)view->ndc_scale.y : (double)view->ndc_scale.x;
            pixels[i] = ((axis ? -1 : 1) * slopes[i] / scale + 1) / 2 * SIDE;
        }
        double tile = axis ? point->pixel.y / 16 : point->pixel.x / 16;
        if (fmax(pixels[0], pixels[1]) < tile * 16 - 500 * slack ||
            fmin(pixels[0], pixels[1]) > tile * 16 + 16 + 500 * slack)
            return false;
    }
    return true;
}

/* Without a pool every cell uses the spare list: a point visits the lights in its tile of the screen that are in its half octave of depth, a
   small part of all. */
static void test_spare_list_ES_37(void **state) {
    UNUSED(state);
    struct random_state random = {16};
    struct gpu_view view = many_lights(&random);
    struct list_lab lab = list_lab_open(&view, lights, LIGHTS);
    list_lab_begin(&lab);
    struct tiled_params tiled = tiled_params_default();
    tiled.pool_capacity = 0;
    struct light_list list = tiled_add(lab.graph, harness_device(), &lab.input, &lab.in_view, (graph_image){0}, &tiled);
    uint32_t *rows = walk(&lab, &list, NULL, 0);
    uint64_t visited = 0, least = 0;
    for (uint32_t i = 0; i < POINTS; i++) {
        uint32_t next = 0, count = rows[i * ROW];
        for (uint32_t light = 0; light < LIGHTS; light++) {
            bool found = next < count && rows[i * ROW + 1 + next] == light;
            next += found;
            least += spare_holds(&view, &lights[light], &points[i], 0);
            assert_true(found || !spare_holds(&view, &lights[light], &points[i], 0));
            assert_true(!found || spare_holds(&view, &lights[light], &points[i], 2e-3));
        }
        assert_int_equal(next, count);
        visited += count;
    }
    print_message("spare list: a point visits %.1f of %u lights\n", (double)visited / POINTS, LIGHTS);
    assert_true(visited < least + least / 10 && visited * 20 < (uint64_t)POINTS * LIGHTS);
    free(rows);
    list_lab_close(&lab);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_walks_skip_subtrees_ES_66, harness_check),
        cmocka_unit_test_teardown(test_walks_and_masks_ES_64, harness_check),
        cmocka_unit_test_teardown(test_spare_list_ES_37, harness_check),
        {"every builder serves lights, decals and probes: what holds a point is found, nothing of another kind is", test_kinds, NULL,
         harness_check, NULL},
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
