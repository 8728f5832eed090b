/* SPDX-License-Identifier: MIT */
/** Fine-pruned tiles, entry by entry and bit by bit, against the lights' volumes in double precision at the pixels' positions. */
#include "tests/fine_bench.h"

#include "passes/lights/fine_shared.h"
#include "passes/lights/light_proxy.h"
#include "tests/light_reference.h"
#include "tests/vulkan_spy.h"

/* ---- the sets ---- */

static void test_sets_FP_2_FP_3_FP_14_ES_47(void **state) {
    UNUSED(state);
    static const struct { uint32_t tile_size, mask_size; } sizes[] = {{16, 1}, {16, 2}, {8, 1}, {32, 2}, {64, 1}};
    enum { LIGHTS = 150 };
    struct random_state random = {3};
    uint64_t lit = 0, fine_entries = 0, coarse_entries = 0;
    for (uint32_t kind = 0; kind < LIST_VIEWS; kind++) {
        struct gpu_view view = list_random_view(kind, &random, FINE_WIDTH + kind, FINE_HEIGHT);
        fine_random_lights(&view, &random, LIGHTS);
        float *depth = list_random_depth(&view, &random);
        struct fine_params p = fine_params_default();
        p.tile_size = sizes[kind].tile_size;
        p.mask_size = sizes[kind].mask_size;
        p.pool_capacity = 1 << 16; /* so that masks for tiles of 64 pixels stay small enough to be made */
        struct fine_copy fine = fine_build(&view, LIGHTS, depth, NULL, &p),
                         again = fine_build(&view, LIGHTS, depth, NULL, &p);
        p.pruning = false;
        struct fine_copy coarse = fine_build(&view, LIGHTS, depth, NULL, &p);
        fine_check_form(&fine, LIGHTS);
        fine_check_form(&coarse, LIGHTS);
        assert_true(fine_is_equal(&fine, &again, &view));
        lit += fine_check_sets(&view, depth, LIGHTS, &fine);
        assert_int_equal(fine.cell_count, coarse.cell_count);
        for (uint32_t cell = 0; cell < fine.cell_count; cell++) {
            assert_true(fine_cell_at(&fine, cell).count <= fine_cell_at(&coarse, cell).count);
            for (uint32_t i = 0; i < fine_cell_at(&fine, cell).count; i++)
                assert_true(fine_holds(&coarse, cell, fine_ids_at(&fine, cell)[i]));
        }
        fine_entries += fine.totals.entries;
        coarse_entries += coarse.totals.entries;
        fine_copy_free(&fine);
        fine_copy_free(&again);
        fine_copy_free(&coarse);
        free(depth);
    }
    print_message("entries: %llu by boxes, %llu by pixels\n", (unsigned long long)coarse_entries,
                  (unsigned long long)fine_entries);
    assert_true(lit > 30000);
    assert_true((double)fine_entries < 0.8 * (double)coarse_entries);
}

/* Sizes that no tile divides, tiles of nothing but sky, no lights. */
static void test_sizes_and_sky_FP_11(void **state) {
    UNUSED(state);
    static const uint32_t sizes[][2] = {{1, 1}, {1, 67}, {15, 16}, {33, 1}};
    struct random_state random = {5};
    for (uint32_t s = 0; s < COUNT_OF(sizes); s++)
        for (uint32_t count = 0; count <= 40; count += 40) {
            struct gpu_view view = list_random_view(0, &random, sizes[s][0], sizes[s][1]);
            fine_random_lights(&view, &random, count);
            float *depth = list_random_depth(&view, &random);
            struct fine_params p = fine_params_default();
            struct fine_copy c = fine_build(&view, count, depth, NULL, &p);
            fine_check_form(&c, count);
            fine_check_sets(&view, depth, count, &c);
            fine_copy_free(&c);
            for (uint32_t i = 0; i < sizes[s][0] * sizes[s][1]; i++) depth[i] = 0;
            c = fine_build(&view, count, depth, NULL, &p);
            assert_int_equal(c.totals.entries, 0);
            fine_copy_free(&c);
            free(depth);
        }
}

/* The viewer inside of every shape, at its middle and at its rim. */
static void test_camera_inside_FP_11(void **state) {
    UNUSED(state);
    struct random_state random = {8};
    for (uint32_t kind = 0; kind < LIST_VIEWS; kind++) {
        struct gpu_view view = list_random_view(kind, &random, 48, 32);
        float *depth = list_random_depth(&view, &random);
        enum { LIGHTS = 60 };
        fine_random_lights(&view, &random, LIGHTS);
        for (uint32_t i = 0; i < LIGHTS; i++) {
            double t = i < 20 ? 0 : i < 40 ? 0.5 : 0.97;
            params[i].range = 4 + (float)(i % 7) * 6;
            params[i].position = vec3_add_scaled(view.eye, params[i].direction, (float)-t * params[i].range);
            params[i].outer_cone_angle = 0.3f + 0.2f * (float)(i % 5);
            params[i].box_size = vec3_make(params[i].range, params[i].range, 2 * params[i].range);
            lights[i] = list_light_of(&params[i], i);
        }
        struct fine_params p = fine_params_default();
        struct fine_copy c = fine_build(&view, LIGHTS, depth, NULL, &p);
        fine_check_form(&c, LIGHTS);
        assert_true(fine_check_sets(&view, depth, LIGHTS, &c) > 1000);
        fine_copy_free(&c);
        free(depth);
    }
}

/* Groups of 64 and of 256 threads, with masks of pixels and of squares, that the count keeps or the fill makes: the same lists. */
static void test_groups_are_equal(void **state) {
    UNUSED(state);
    struct random_state random = {21};
    const uint32_t counts[] = {30, 80, 500};
    static const uint32_t tile_sizes[] = {8, 16, 16, 32}, mask_sizes[] = {1, 1, 2, 2};
    for (uint32_t i = 0; i < 3 * COUNT_OF(tile_sizes); i++) {
        struct gpu_view view = list_random_view(i % LIST_VIEWS, &random, 70, 52);
        fine_random_lights(&view, &random, counts[i % 3]);
        float *depth = list_random_depth(&view, &random);
        struct fine_params p = fine_params_default();
        p.tile_size = tile_sizes[i / 3];
        p.mask_size = mask_sizes[i / 3];
        struct fine_copy many = fine_build(&view, counts[i % 3], depth, NULL, &p);
        p.group_side = 8;
        struct fine_copy few = fine_build(&view, counts[i % 3], depth, NULL, &p);
        fine_check_form(&many, counts[i % 3]);
        if (p.mask_size == 1) fine_check_sets(&view, depth, counts[i % 3], &many);
        assert_true(fine_is_equal(&many, &few, &view));
        fine_copy_free(&many);
        fine_copy_free(&few);
        free(depth);
    }
}

/* One light's broken numbers do not take others along. */
static void test_broken_lights(void **state) {
    UNUSED(state);
    struct random_state random = {9};
    enum { LIGHTS = 60 };
    struct gpu_view view = list_random_view(0, &random, 64, 48);
    fine_random_lights(&view, &random, LIGHTS);
    float *depth = list_random_depth(&view, &random);
    struct fine_params p = fine_params_default();
    struct list_light dark = lights[7], lost = lights[12], endless = lights[20];
    lights[7].bounds.radius = lights[12].bounds.radius = lights[20].bounds.radius = 0;
    struct fine_copy without = fine_build(&view, LIGHTS, depth, NULL, &p);
    lights[12] = lost;
    lights[20] = endless;
    lights[12].shape.position.y = lights[12].bounds.center.y = NAN;
    lights[20].shape.range = lights[20].bounds.radius = INFINITY;
    struct fine_copy with = fine_build(&view, LIGHTS, depth, NULL, &p);
    fine_check_form(&with, LIGHTS);
    for (uint32_t cell = 0; cell < with.cell_count; cell++)
        for (uint32_t i = 0; i < LIGHTS; i++)
            if (i != 12 && i != 20) assert_int_equal(fine_holds(&with, cell, i), fine_holds(&without, cell, i));
    lights[7] = dark;
    fine_copy_free(&with);
    fine_copy_free(&without);
    free(depth);
}

/* ---- boxes ---- */

/* Bounds on the screen (pixels) and in depth of a sphere before the near plane; false when it is not wholly there. */
static bool sphere_box(const struct gpu_view *view, const struct list_light *light, double out[6]) {
    double c[3] = {0}, r = (double)light->bounds.radius;
    const float at[3] = {light->bounds.center.x, light->bounds.center.y, light->bounds.center.z};
    for (int i = 0; i < 3; i++) {
        c[i] = (double)view->world_to_view.m[12 + i];
        for (int k = 0; k < 3; k++) c[i] += (double)view->world_to_view.m[k * 4 + i] * (double)at[k];
    }
    double z = -c[2];
    if (z - r <= (double)view->near_distance) return false;
    const double scale[2] = {view->ndc_scale.x, view->ndc_scale.y}, offset[2] = {view->ndc_offset.x, view->ndc_offset.y},
                 size[2] = {view->size.x, view->size.y};
    for (int i = 0; i < 2; i++) {
        double low = c[i] - r, high = c[i] + r;
        if (view->orthographic < 0.5f) {
            double root = sqrt(c[i] * c[i] + z * z - r * r);
            low = (c[i] * z - r * root) / (z * z - r * r);
            high = (c[i] * z + r * root) / (z * z - r * r);
        }
        low = ((low - offset[i]) / scale[i] + 1) / 2 * size[i];
        high = ((high - offset[i]) / scale[i] + 1) / 2 * size[i];
        out[i] = i ? size[i] - high : low;
        out[i + 3] = i ? size[i] - low : high;
    }
    out[2] = z - r;
    out[5] = z + r;
    return true;
}

static double area_of(const struct gpu_fine_box *box) {
    return fmax(0, (double)box->rect.z - (double)box->rect.x) * fmax(0, (double)box->rect.w - (double)box->rect.y);
}

static void test_boxes_FP_4(void **state) {
    UNUSED(state);
    enum { LIGHTS = 400, POINTS = 400 };
    struct random_state random = {13};
    uint32_t seen_points = 0, spheres = 0, narrow = 0;
    double narrow_area = 0, narrow_sphere_area = 0;
    for (uint32_t kind = 0; kind < LIST_VIEWS; kind++) {
        struct gpu_view view = list_random_view(kind, &random, FINE_WIDTH, FINE_HEIGHT);
        fine_random_lights(&view, &random, LIGHTS);
        struct fine_params p = fine_params_default();
        struct fine_copy c = fine_build(&view, LIGHTS, NULL, NULL, &p);
        const uint32_t *visible = c.data[COPY_VISIBLE];
        const struct gpu_fine_box *boxes = c.data[COPY_BOXES];
        for (uint32_t v = 0; v < c.totals.in_view; v++) {
            const struct list_light *light = &lights[visible[v]];
            const struct gpu_fine_box *box = &boxes[v];
            vec3 corners[8];
            shape_corners(&light->shape, &light->bounds, corners);
            for (uint32_t k = 0; k < POINTS; k++) { /* points of the proxy in the view are in the box */
                float weights[3], seen[3], world[3] = {0};
                for (int i = 0; i < 3; i++) weights[i] = k % 3 == 0 ? roundf(random_float(&random)) : random_float(&random);
                for (uint32_t i = 0; i < 8; i++) {
                    float w = (i & 1 ? weights[0] : 1 - weights[0]) * (i & 2 ? weights[1] : 1 - weights[1]) *
                              (i & 4 ? weights[2] : 1 - weights[2]);
                    world[0] += w * corners[i].x;
                    world[1] += w * corners[i].y;
                    world[2] += w * corners[i].z;
                }
                vec3 in_view = mat4_point(&view.world_to_view, vec3_make(world[0], world[1], world[2]));
                if (vec3_distance(vec3_make(world[0], world[1], world[2]), light->bounds.center) > light->bounds.radius)
                    continue;
                seen[2] = -in_view.z;
                if (seen[2] < view.near_distance) continue;
                float spread = view.orthographic > 0.5f ? 1 : seen[2];
                seen[0] = ((in_view.x / spread - view.ndc_offset.x) / view.ndc_scale.x + 1) / 2 * (float)view.size.x;
                seen[1] = (1 - (in_view.y / spread - view.ndc_offset.y) / view.ndc_scale.y) / 2 * (float)view.size.y;
                if (!(seen[0] >= 0 && seen[1] >= 0 && seen[0] <= (float)view.size.x && seen[1] <= (float)view.size.y))
                    continue;
                seen_points++;
                if (seen[0] < box->rect.x || seen[0] > box->rect.z || seen[1] < box->rect.y || seen[1] > box->rect.w ||
                    seen[2] < box->depth.x || seen[2] > box->depth.y)
                    fail_msg("%s: the box of light %u misses pixel %.2f %.2f at %.3f m", list_view_names[kind], visible[v],
                             (double)seen[0], (double)seen[1], (double)seen[2]);
            }
            double sphere[6];
            if (box->rect.x > box->rect.z || !sphere_box(&view, light, sphere)) continue;
            spheres++;
            double margin = 0.05 + 1e-3 * (sphere[3] - sphere[0] + sphere[4] - sphere[1]);
            assert_true((double)box->rect.x >= fmin(sphere[0], view.size.x) - margin &&
                        (double)box->rect.z <= sphere[3] + margin);
            assert_true((double)box->rect.y >= fmin(sphere[1], view.size.y) - margin &&
                        (double)box->rect.w <= sphere[4] + margin);
            assert_true((double)box->depth.x >= sphere[2] * 0.999 - 0.01 &&
                        (double)box->depth.y <= sphere[5] * 1.001 + 0.01);
            if (params[visible[v]].kind == FNL_LIGHT_SPOT && params[visible[v]].outer_cone_angle < 0.3f) {
                struct gpu_fine_box of_sphere = {.rect = {fmaxf((float)sphere[0], 0), fmaxf((float)sphere[1], 0),
                                                          fminf((float)sphere[3], (float)view.size.x),
                                                          fminf((float)sphere[4], (float)view.size.y)}};
                narrow++;
                narrow_area += area_of(box);
                narrow_sphere_area += area_of(&of_sphere);
            }
        }
        fine_copy_free(&c);
    }
    print_message("%u points, %u whole spheres; %u narrow spots take %.2f of their spheres' area\n", seen_points, spheres,
                  narrow, narrow_area / narrow_sphere_area);
    assert_true(seen_points > 50000 && spheres > 100 && narrow > 5);
    assert_true(narrow_area < 0.6 * narrow_sphere_area);
}

/* ---- the figure: nine lights in a tile's box, one of them at its surfaces ---- */

static void test_nine_lights_FP_5(void **state) {
    UNUSED(state);
    enum { SIDE = 48 };
    fnl_camera camera = fnl_camera_default();
    camera.position = vec3_make(1, 2, 3);
    camera.target = vec3_make(1, 2, 2);
    struct gpu_view view = view_from_camera(&camera, SIDE, SIDE);
    float depth[SIDE * SIDE];
    for (uint32_t i = 0; i < SIDE * SIDE; i++) depth[i] = depth_of_view_depth(&view, i % SIDE % 16 < 8 ? 10 : 30);
    for (uint32_t i = 0; i < 6; i++) fine_place(&view, i, 24, 24, 13 + 2.0 * i, 0.2f, false);
    for (uint32_t i = 6; i < 9; i++) fine_place(&view, i, 22, 26, 12 + 4.0 * i - 24, 0.3f, true);
    fine_place(&view, 4, 20, 24, 10.1, 0.2f, false); /* this one touches the near half */
    struct fine_params p = fine_params_default();
    struct fine_copy fine = fine_build(&view, 9, depth, NULL, &p);
    p.pruning = false;
    struct fine_copy coarse = fine_build(&view, 9, depth, NULL, &p);
    assert_int_equal(fine_cell_at(&coarse, 4).count, 9);
    assert_int_equal(fine_cell_at(&fine, 4).count, 1);
    assert_int_equal(fine_ids_at(&fine, 4)[0], 4);
    fine_copy_free(&fine);
    fine_copy_free(&coarse);
}

/* ---- blocks ---- */

struct marked {
    uint32_t *marks, *visible, in_view;
    struct gpu_fine_box *boxes;
    struct list_copy list;
};

/* Lists, with the marks of the blocks and the boxes that they come from; `spoiled`: the first word of this block's marks is emptied before tiles
   look at it, or UINT32_MAX. */
static struct marked build_marked(const struct gpu_view *view, uint32_t light_count, const float *depth, bool pruning,
                                  uint32_t block_words, uint32_t spoiled) {
    gpu_device *device = harness_device();
    struct marked m = {0};
    struct list_lab lab = list_lab_open(view, lights, light_count);
    struct fine_params p = fine_params_default();
    p.eye_distance = vec3_length(view->eye);
    p.pruning = pruning;
    graph_image image = list_lab_depth(&lab, depth);
    list_lab_begin(&lab);
    struct fine_lists lists = fine_add(lab.graph, device, &lab.input, &lab.in_view, image, &p);
    struct gpu_buffer captured, nothing;
    assert_int_equal(gpu_buffer_create(device, "captured", 1 << 16, GPU_MEMORY_READBACK, &captured), FNL_OK);
    assert_int_equal(gpu_buffer_create(device, "an empty word", 4, GPU_MEMORY_UPLOAD, &nothing), FNL_OK);
    memset(nothing.mapped, 0, 4);
    spy_begin(device);
    spy_capture(lab.graph, "fine mark", "fine marks", &captured);
    if (spoiled != UINT32_MAX)
        spy_overwrite(lab.graph, "fine mark", "fine marks", spoiled * block_words * 4ull, 4, &nothing);
    list_lab_run(
        &lab, (graph_buffer[]){lists.lights.cells, lists.lights.ids, lists.boxes, lab.in_view.ids, lists.lights.totals}, 5);
    spy_end();
    m.list.cells = list_reads_take(&lab.reads, 0);
    m.list.ids = list_reads_take(&lab.reads, 1);
    m.boxes = list_reads_take(&lab.reads, 2);
    m.visible = list_reads_take(&lab.reads, 3);
    memcpy(&m.list.totals, lab.reads.buffers[4].mapped, sizeof m.list.totals);
    m.list.cell_count = lists.lights.cell_count;
    m.in_view = m.list.totals.in_view;
    m.marks = malloc(captured.size);
    assert_non_null(m.marks);
    memcpy(m.marks, captured.mapped, captured.size);
    list_lab_close(&lab);
    gpu_buffer_destroy(device, &captured);
    gpu_buffer_destroy(device, &nothing);
    return m;
}

static void marked_free(struct marked *m) {
    list_free(&m->list);
    free(m->marks);
    free(m->boxes);
    free(m->visible);
}

/* Without pruning a tile holds the lights whose box touches it and its depths, not those of its block. */
static void test_tiles_by_boxes_FP_3(void **state) {
    UNUSED(state);
    enum { LIGHTS = 200, TILE = 16 };
    struct random_state random = {43};
    uint64_t held = 0;
    for (uint32_t kind = 0; kind < LIST_VIEWS; kind++) {
        struct gpu_view view = list_random_view(kind, &random, FINE_WIDTH, FINE_HEIGHT);
        fine_random_lights(&view, &random, LIGHTS);
        float *depth = list_random_depth(&view, &random);
        struct marked m = build_marked(&view, LIGHTS, depth, false, 0, UINT32_MAX);
        uint32_t across = DIVIDE_UP(FINE_WIDTH, TILE);
        for (uint32_t c = 0; c < m.list.cell_count; c++) {
            uint32_t x0 = c % across * TILE, y0 = c / across * TILE, x1 = MIN(x0 + TILE, FINE_WIDTH),
                     y1 = MIN(y0 + TILE, FINE_HEIGHT);
            double near = INFINITY, far = 0;
            for (uint32_t y = y0; y < y1; y++)
                for (uint32_t x = x0; x < x1; x++) {
                    float d = depth[y * FINE_WIDTH + x];
                    if (d <= 0) continue;
                    near = fmin(near, view_depth_of_depth(&view, d));
                    far = fmax(far, view_depth_of_depth(&view, d));
                }
            for (uint32_t i = 0; i < m.in_view; i++) {
                const struct gpu_fine_box *box = &m.boxes[i];
                bool holds = list_holds(&m.list, c, m.visible[i]),
                     on_tile = box->rect.x <= box->rect.z && box->rect.x <= (float)x1 && box->rect.z >= (float)x0 &&
                               box->rect.y <= (float)y1 && box->rect.w >= (float)y0;
                if (on_tile && far > 0 && (double)box->depth.x < far && (double)box->depth.y > near) assert_true(holds);
                if (!holds) continue;
                held++;
                assert_true(on_tile && far > 0 && (double)box->depth.x <= far * 1.001 &&
                            (double)box->depth.y >= near * 0.999);
            }
        }
        marked_free(&m);
        free(depth);
    }
    assert_true(held > 1000);
}

/*
 * A block of 64 x 64 pixels is marked with the lights whose box touches it, between its nearest and its farthest surface; its tiles look at no
 * others: without the marks of the first 32 lights they hold none of these.
 */
static void test_blocks_FP_3(void **state) {
    UNUSED(state);
    enum { LIGHTS = 300, WIDTH = 200, HEIGHT = 140, BLOCK = 64, ACROSS = 4, BLOCKS = 12, WORDS = 10 };
    struct random_state random = {41};
    fnl_camera camera = fnl_camera_default();
    struct gpu_view view = view_from_camera(&camera, WIDTH, HEIGHT);
    fine_random_lights(&view, &random, LIGHTS);
    for (uint32_t i = 0; i < LIGHTS; i++) { /* small ones: a block has few of them */
        params[i].range *= 0.5f;
        params[i].box_size = vec3_scale(params[i].box_size, 0.5f);
        params[i].length *= 0.5f;
        lights[i] = list_light_of(&params[i], i);
    }
    float *depth = list_random_depth(&view, &random);
    struct marked full = build_marked(&view, LIGHTS, depth, true, WORDS, UINT32_MAX);
    uint32_t marked = 0, spoiled = 0, most = 0;
    for (uint32_t b = 0; b < BLOCKS; b++) {
        double x0 = b % ACROSS * BLOCK, y0 = b / ACROSS * BLOCK, near = INFINITY, far = 0;
        double x1 = fmin(x0 + BLOCK, WIDTH), y1 = fmin(y0 + BLOCK, HEIGHT);
        for (uint32_t y = (uint32_t)y0; y < y1; y++)
            for (uint32_t x = (uint32_t)x0; x < x1; x++) {
                float d = depth[y * WIDTH + x];
                if (d <= 0) continue;
                near = fmin(near, view_depth_of_depth(&view, d));
                far = fmax(far, view_depth_of_depth(&view, d));
            }
        uint32_t first_word = 0;
        for (uint32_t i = 0; i < full.in_view; i++) {
            const struct gpu_fine_box *box = &full.boxes[i];
            bool bit = full.marks[b * WORDS + i / 32] >> i % 32 & 1;
            bool on_screen = box->rect.x <= box->rect.z && (double)box->rect.x <= x1 && (double)box->rect.z >= x0 &&
                             (double)box->rect.y <= y1 && (double)box->rect.w >= y0;
            double slack = 1e-3 * far;
            if (on_screen && (double)box->depth.x < far && (double)box->depth.y > near && !bit)
                fail_msg("block %u, %g .. %g m, is not marked with light %u of %u: %g .. %g m, from pixel %g %g to %g %g", b,
                         near, far, i, full.in_view, (double)box->depth.x, (double)box->depth.y, (double)box->rect.x,
                         (double)box->rect.y, (double)box->rect.z, (double)box->rect.w);
            if (bit) assert_true(on_screen && (double)box->depth.x <= far + slack && (double)box->depth.y >= near - slack);
            marked += bit;
            first_word += bit && i < 32;
        }
        if (first_word > most) most = first_word, spoiled = b;
    }
    print_message("%u lights in view; a block is marked with %.1f\n", full.in_view, (double)marked / BLOCKS);
    assert_true(full.in_view > 100 && marked * 2 < full.in_view * BLOCKS); /* 0.13 of all pairs; 1 if blocks are ignored */
    struct marked spoiled_lists = build_marked(&view, LIGHTS, depth, true, WORDS, spoiled);
    uint32_t gone = 0, left = 0, across = DIVIDE_UP(WIDTH, 16u);
    for (uint32_t c = 0; c < full.list.cell_count; c++)
        for (uint32_t i = 0; i < full.list.cells[c].count; i++) {
            uint32_t light = full.list.ids[full.list.cells[c].offset + i];
            bool hidden = c / across / 4 * ACROSS + c % across / 4 == spoiled && light < full.visible[32];
            assert_int_equal(list_holds(&spoiled_lists.list, c, light), !hidden);
            *(hidden ? &gone : &left) += 1;
        }
    print_message("%u entries, %u without 32 lights in one block\n", gone + left, left);
    assert_true(gone > 5 && left > 100);
    marked_free(&full);
    marked_free(&spoiled_lists);
    free(depth);
}

/* ---- more than the source's limits ---- */

/* 65 and more by boxes, 25 and more by pixels, 1025 and more in view: nothing is lost, whatever is kept for later or flushed between. */
static void test_many_lights_FP_10(void **state) {
    UNUSED(state);
    static const uint32_t counts[] = {24, 25, 33, 64, 65, 128, 129, 1025, 3100, FINE_LIGHTS_MAX};
    struct random_state random = {21};
    fnl_camera camera = fnl_camera_default();
    struct gpu_view view = view_from_camera(&camera, 24, 20);
    float depth[24 * 20];
    for (uint32_t i = 0; i < COUNT_OF(depth); i++) depth[i] = depth_of_view_depth(&view, 10 + 0.05 * (i % 7));
    for (uint32_t n = 0; n < COUNT_OF(counts); n++) {
        for (uint32_t i = 0; i < counts[n]; i++)
            fine_place(&view, i, 3 + 10 * (double)random_float(&random), 3 + 10 * (double)random_float(&random), 10, 0.4f,
                       i % 3 == 0);
        struct fine_params p = fine_params_default();
        struct fine_copy c = fine_build(&view, counts[n], depth, NULL, &p);
        fine_check_form(&c, counts[n]);
        fine_check_sets(&view, depth, counts[n], &c);
        assert_true(fine_cell_at(&c, 0).count > counts[n] / 2);
        fine_copy_free(&c);
        p.pruning = false;
        c = fine_build(&view, counts[n], depth, NULL, &p);
        assert_int_equal(fine_cell_at(&c, 0).count, counts[n]);
        fine_copy_free(&c);
    }
}

static struct gpu_buffer no_volumes;

static void spoil_volumes(const struct graph *graph) {
    spy_overwrite(graph, "fine count", "fine volumes", 0, no_volumes.size, &no_volumes);
}

/* Up to 512 lights that touch a tile are tested against its pixels once: the fill makes the same masks when there are no volumes any more. With
   more it has to test them, and finds nothing. */
static void test_lights_are_tested_once(void **state) {
    UNUSED(state);
    static const uint32_t counts[] = {90, 300, 512, 513};
    static const uint32_t tile_sizes[] = {16, 16, 32}, mask_sizes[] = {1, 2, 1};
    struct random_state random = {23};
    fnl_camera camera = fnl_camera_default();
    struct gpu_view view = view_from_camera(&camera, 24, 20);
    float depth[24 * 20];
    for (uint32_t i = 0; i < COUNT_OF(depth); i++) depth[i] = depth_of_view_depth(&view, 10 + 0.05 * (i % 7));
    for (uint32_t n = 0; n < COUNT_OF(counts) * COUNT_OF(tile_sizes); n++) {
        const uint32_t count = counts[n % COUNT_OF(counts)];
        struct fine_params p = fine_params_default();
        p.tile_size = tile_sizes[n / COUNT_OF(counts)];
        p.mask_size = mask_sizes[n / COUNT_OF(counts)];
        for (uint32_t i = 0; i < count; i++)
            fine_place(&view, i, 3 + 10 * (double)random_float(&random), 3 + 10 * (double)random_float(&random), 10, 0.4f, i % 3 == 0);
        struct fine_copy whole = fine_build(&view, count, depth, NULL, &p);
        assert_int_equal(gpu_buffer_create(harness_device(), "nothing", count * sizeof(struct gpu_fine_volume), GPU_MEMORY_UPLOAD, &no_volumes),
                         FNL_OK);
        memset(no_volumes.mapped, 0, no_volumes.size);
        spy_begin(harness_device());
        fine_spoil = spoil_volumes;
        struct fine_copy spoiled = fine_build(&view, count, depth, NULL, &p);
        fine_spoil = NULL;
        spy_end();
        gpu_buffer_destroy(harness_device(), &no_volumes);
        assert_true(fine_cell_at(&whole, 0).count > count / 2);
        assert_true(fine_is_equal(&whole, &spoiled, &view) == (count <= 512));
        fine_copy_free(&whole);
        fine_copy_free(&spoiled);
    }
}

static struct gpu_buffer found;

static void capture_found(const struct graph *graph) { spy_capture(graph, "fine count", "fine found", &found); }

/* Lights that hover over a floor, a little higher than they reach: tiles see them within their depths and on the screen, and a sphere round a tile's
   positions meets many of them, but the box round these none. So no pixel is tested. */
static void test_floor_puts_lights_aside(void **state) {
    UNUSED(state);
    enum { WIDTH = 64, HEIGHT = 48, LIGHTS = 60, TILES = 12 };
    const uint32_t kept_words = 16, tile_words = FINE_FOUND_WORDS(kept_words * 32, kept_words, 256);
    fnl_camera camera = fnl_camera_default();
    camera.position = vec3_make(0, 1, 0);
    camera.target = vec3_make(0, 1, -1);
    struct gpu_view view = view_from_camera(&camera, WIDTH, HEIGHT);
    float depth[WIDTH * HEIGHT];
    for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) {
        double slope = (1 - 2 * (i / WIDTH + 0.5) / HEIGHT) * (double)view.ndc_scale.y;
        depth[i] = slope < -0.02 ? depth_of_view_depth(&view, -1 / slope) : 0;
    }
    struct fine_params p = fine_params_default();
    uint32_t tested[2] = {0}, entries[2];
    for (uint32_t low = 0; low < 2; low++) {
        struct random_state random = {29};
        for (uint32_t i = 0; i < LIGHTS; i++) {
            params[i] = fnl_light_params_default();
            params[i].position = vec3_make(4 * random_float(&random) - 2, low ? 0.28f : 0.32f, -2 - 6 * random_float(&random));
            params[i].range = 0.3f;
            lights[i] = list_light_of(&params[i], i);
        }
        assert_int_equal(gpu_buffer_create(harness_device(), "found", TILES * tile_words * 4ull, GPU_MEMORY_READBACK, &found), FNL_OK);
        spy_begin(harness_device());
        fine_spoil = capture_found;
        struct fine_copy c = fine_build(&view, LIGHTS, depth, NULL, &p);
        fine_spoil = NULL;
        spy_end();
        for (uint32_t cell = 0; cell < TILES; cell++) tested[low] += ((uint32_t *)found.mapped)[cell * tile_words + kept_words * 32];
        entries[low] = c.totals.entries;
        gpu_buffer_destroy(harness_device(), &found);
        fine_copy_free(&c);
    }
    print_message("words of lights tested by pixels: %u over the floor, %u that reach it\n", tested[0], tested[1]);
    assert_true(tested[0] == 0 && entries[0] == 0);
    assert_true(tested[1] > 3 && entries[1] > 10);
}

static void test_overflow_FP_10(void **state) {
    UNUSED(state);
    enum { LIGHTS = 200 };
    struct random_state random = {5};
    struct gpu_view view = list_random_view(0, &random, FINE_WIDTH, FINE_HEIGHT);
    fine_random_lights(&view, &random, LIGHTS);
    float *depth = list_random_depth(&view, &random);
    struct fine_params p = fine_params_default();
    struct fine_copy full = fine_build(&view, LIGHTS, depth, NULL, &p);
    uint32_t entries = full.totals.entries;
    assert_true(entries > 100);
    const uint32_t capacities[] = {0, 1, entries / 2, entries - 1, entries};
    for (uint32_t k = 0; k < COUNT_OF(capacities); k++) {
        p.pool_capacity = capacities[k];
        struct fine_copy c = fine_build(&view, LIGHTS, depth, NULL, &p);
        assert_int_equal(c.totals.entries, entries);
        uint32_t overflow = 0;
        for (uint32_t cell = 0; cell < full.cell_count; cell++) {
            struct gpu_cell want = fine_cell_at(&full, cell), is = fine_cell_at(&c, cell);
            if (want.offset + want.count > capacities[k]) {
                assert_int_equal(is.count, GPU_CELL_ALL);
                overflow++;
            } else {
                assert_int_equal(is.count, want.count);
                assert_memory_equal(fine_ids_at(&c, cell), fine_ids_at(&full, cell), want.count * 4ull);
            }
        }
        assert_int_equal(c.totals.overflow_cells, overflow);
        assert_true((overflow > 0) == (capacities[k] < entries));
        fine_copy_free(&c);
    }
    fine_copy_free(&full);
    free(depth);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_nine_lights_FP_5, harness_check),
        cmocka_unit_test_teardown(test_sets_FP_2_FP_3_FP_14_ES_47, harness_check),
        cmocka_unit_test_teardown(test_sizes_and_sky_FP_11, harness_check),
        cmocka_unit_test_teardown(test_camera_inside_FP_11, harness_check),
        cmocka_unit_test_teardown(test_broken_lights, harness_check),
        cmocka_unit_test_teardown(test_groups_are_equal, harness_check),
        cmocka_unit_test_teardown(test_boxes_FP_4, harness_check),
        cmocka_unit_test_teardown(test_tiles_by_boxes_FP_3, harness_check),
        cmocka_unit_test_teardown(test_blocks_FP_3, harness_check),
        cmocka_unit_test_teardown(test_many_lights_FP_10, harness_check),
        cmocka_unit_test_teardown(test_lights_are_tested_once, harness_check),
        cmocka_unit_test_teardown(test_floor_puts_lights_aside, harness_check),
        cmocka_unit_test_teardown(test_overflow_FP_10, harness_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
