/* SPDX-License-Identifier: MIT */
/** The masks of tiles and depth bins, bit by bit: built on the device, compared with geometry in double precision. */
#include "tests/list_bench.h"

#include "passes/lights/zbin_shared.h"
#include "tests/frame_plain.h"

enum { LIGHTS = 1500, LIGHTS_MAX = 40000, WIDTH = 157, HEIGHT = 93 };

static fnl_light_params params[LIGHTS_MAX];
static struct list_light lights[LIGHTS_MAX];

/* What the builder has made, unpacked: for each cell whether it holds each light. */
struct masks {
    struct gpu_light_list grid;
    uint32_t tile_count, first_bin, cell_count, visible_count; /* cells: tiles of each zone, then bins */
    uint32_t zone_bins;
    uint8_t *holds; /* cell * light_count + light */
    uint32_t *ids;  /* of lights in view */
    bool *all;      /* cells that use all lights */
    struct light_totals totals;
    uint64_t words;
};

static void masks_free(struct masks *m) {
    free(m->holds);
    free(m->all);
    free(m->ids);
}

static struct masks unpack(const struct gpu_light_list *grid, uint32_t light_count, const uint32_t *table,
                           const uint32_t *pool, const uint32_t *ids, struct light_totals totals) {
    struct masks m = {.grid = *grid, .tile_count = grid->tiles_x * grid->tiles_y, .totals = totals};
    m.zone_bins = grid->zone_slices;
    m.first_bin = m.tile_count * DIVIDE_UP(grid->slices, m.zone_bins);
    m.cell_count = m.first_bin + grid->slices;
    m.visible_count = table[0];
    m.holds = calloc((size_t)m.cell_count * MAX(light_count, 1u), 1);
    m.all = calloc(m.cell_count, sizeof *m.all);
    m.ids = malloc(MAX(light_count, 1u) * sizeof *m.ids);
    assert_true(m.holds && m.all && m.ids);
    memcpy(m.ids, ids, light_count * sizeof *m.ids);
    assert_int_equal(m.visible_count, totals.in_view);
    assert_int_equal(table[1], DIVIDE_UP(m.visible_count, ZBIN_GROUP));
    assert_int_equal(table[2], DIVIDE_UP(table[1], 32u));
    uint32_t tops = table[2], groups = table[1], all_count = 0;
    for (uint32_t i = 1; i < m.visible_count; i++) assert_true(ids[i - 1] < ids[i]);
    for (uint32_t c = 0; c < m.cell_count; c++) {
        const uint32_t *state = table + 4 + c * (tops + 1),
                       *records = table + 4 + m.cell_count * (tops + 1) + c * groups * 2;
        m.all[c] = *state != 0;
        all_count += m.all[c];
        for (uint32_t g = 0; g < groups; g++) {
            assert_int_equal(state[1 + g / 32] >> g % 32 & 1, records[g * 2 + 1] != 0);
            if (m.all[c]) {
                memset(m.holds + (size_t)c * light_count, 1, light_count);
                continue;
            }
            uint32_t place = records[g * 2];
            assert_true(c + g == 0 || all_count || place == m.words);
            for (uint32_t w = 0; w < 32; w++) {
                if (!(records[g * 2 + 1] >> w & 1)) continue;
                assert_true(pool[place] != 0);
                for (uint32_t b = 0; b < 32; b++)
                    if (pool[place] >> b & 1) {
                        uint32_t slot = g * 1024 + w * 32 + b;
                        assert_true(slot < m.visible_count);
                        m.holds[(size_t)c * light_count + ids[slot]] = 1;
                    }
                place++;
                m.words++;
            }
        }
    }
    assert_int_equal(totals.overflow_cells, all_count);
    if (!all_count) assert_int_equal(totals.entries, m.words);
    return m;
}

static struct masks build(const struct gpu_view *view, uint32_t light_count, const struct zbin_params *zbin) {
    struct list_lab lab = list_lab_open(view, lights, light_count);
    list_lab_begin(&lab);
    struct light_list list = zbin_add(lab.graph, harness_device(), &lab.input, &lab.in_view, zbin);
    assert_int_equal(list.kind, GPU_LIST_BINS);
    const uint32_t tiles = DIVIDE_UP(view->size.x, zbin->tile_size) * DIVIDE_UP(view->size.y, zbin->tile_size);
    const uint32_t zones = (list.cell_count - zbin->bins) / tiles, zone_slices = DIVIDE_UP(zbin->bins, zones);
    assert_int_equal(list.cell_count, tiles * zones + zbin->bins);
    list_lab_run(&lab, (graph_buffer[]){list.cells, list.ids, list.extra, list.totals}, 4);
    struct gpu_light_list grid = {.local_count = light_count, .zone_slices = zone_slices};
    clustered_grid(&grid, view->size.x, view->size.y,
                   &(struct clustered_params){
                       .tile_size = zbin->tile_size, .slices = zbin->bins, .near = zbin->near, .far = zbin->far});
    struct light_totals totals;
    const struct gpu_buffer *reads = lab.reads.buffers;
    memcpy(&totals, reads[3].mapped, sizeof totals);
    struct masks m = unpack(&grid, light_count, reads[0].mapped, reads[1].mapped, reads[2].mapped, totals);
    list_lab_close(&lab);
    return m;
}

/* ---- the reference ---- */

static double bin_start(const struct masks *m, uint32_t bin) {
    return exp2(((double)bin - (double)m->grid.slice_bias) / (double)m->grid.slice_scale);
}

/* The part of a tile that is as deep as the light, and a little more. */
static struct reference_cell tile_beside_light(const struct list_request *r, const struct gpu_light_list *grid,
                                               uint32_t tile, uint32_t light) {
    struct reference_cell c = reference_cell_of(r, grid, tile, 1e-3);
    const double world[3] = {(double)lights[light].bounds.center.x, (double)lights[light].bounds.center.y,
                             (double)lights[light].bounds.center.z};
    double at[3], reach;
    world_to_view(&r->view, world, at);
    reach = (double)lights[light].bounds.radius * 1.002 + 2e-3 + 2e-3 * fabs(at[2]);
    bool orthographic = r->view.orthographic > 0.5f;
    double near = orthographic ? -at[2] - reach : fmax(-at[2] - reach, 0), far = fmax(-at[2] + reach, near);
    for (int axis = 0; axis < 2; axis++) {
        double ends[2] = {orthographic ? 1 : near, orthographic ? 1 : far};
        c.low[axis] = fmin(c.edges[axis * 2] * ends[0], c.edges[axis * 2] * ends[1]);
        c.high[axis] = fmax(c.edges[axis * 2 + 1] * ends[0], c.edges[axis * 2 + 1] * ends[1]);
    }
    c.low[2] = -far;
    c.high[2] = -near;
    return c;
}

/* In a zone whose mask is known. */
static bool tile_holds(const struct masks *m, uint32_t light_count, uint32_t tile, uint32_t light) {
    for (uint32_t c = tile; c < m->first_bin; c += m->tile_count)
        if (m->holds[(size_t)c * light_count + light] && !m->all[c]) return true;
    return false;
}

/* Bins hold what their depths meet; tiles hold nothing beyond their four planes, nor beyond the box of what is as deep as the light. */
static void check_masks(const struct gpu_view *view, uint32_t light_count, const struct masks *m) {
    struct list_request tiles = {
        .builder = LIST_TILED, .view = *view, .lights = lights, .light_count = light_count, .tiled = tiled_params_default()};
    tiles.tiled.tile_size = m->grid.tile_size;
    struct gpu_light_list grid = list_grid(&tiles);
    for (uint32_t i = 0; i < light_count; i++) {
        if (!reference_in_view(&tiles, i)) continue;
        double seen[3],
            at[3] = {(double)lights[i].bounds.center.x, (double)lights[i].bounds.center.y, (double)lights[i].bounds.center.z};
        world_to_view(view, at, seen);
        double radius = (double)lights[i].bounds.radius, low = -seen[2] - radius, high = -seen[2] + radius;
        for (uint32_t b = 0; b < m->grid.slices; b++) {
            double start = b ? bin_start(m, b) : -1e30, end = b + 1 < m->grid.slices ? bin_start(m, b + 1) : 1e30;
            bool holds = m->holds[(size_t)(m->first_bin + b) * light_count + i];
            if (low < end && high > start) assert_true(holds);
            double slack = 1e-3 * (1 + fabs(low) + fabs(high) + radius);
            if (low - slack > end || high + slack < start) assert_false(holds && !m->all[m->first_bin + b]);
        }
    }
    for (uint32_t t = 0; t < m->tile_count; t++) {
        struct reference_cell wide = reference_cell_of(&tiles, &grid, t, 1e-3);
        for (uint32_t i = 0; i < light_count; i++)
            if (tile_holds(m, light_count, t, i)) {
                assert_true(reference_touches(&wide, &tiles, i, 2e-3, false));
                struct reference_cell beside = tile_beside_light(&tiles, &grid, t, i);
                assert_true(reference_touches(&beside, &tiles, i, 2e-3, true));
            }
    }
}

/* SUP: points within each light; its tile's mask and its bin's have the light. */
static uint64_t check_points(const struct gpu_view *view, uint32_t light_count, const struct masks *m,
                             struct random_state *random) {
    uint64_t lit = 0;
    for (uint32_t i = 0; i < light_count; i++)
        for (uint32_t n = 0; n < 60; n++) {
            double point[3], seen[3], off[3];
            const float *center = &lights[i].bounds.center.x;
            for (int k = 0; k < 3; k++) {
                off[k] = (double)lights[i].bounds.radius * (double)random_range(random, -1, 1);
                point[k] = (double)center[k] + off[k];
            }
            if (sqrt(off[0] * off[0] + off[1] * off[1] + off[2] * off[2]) > (double)lights[i].bounds.radius) continue;
            if (!light_reaches(&params[i], point)) continue;
            world_to_view(view, point, seen);
            double depth = -seen[2], spread = view->orthographic > 0.5f ? 1 : depth;
            if (depth < (double)view->near_distance) continue;
            double x = (seen[0] / spread - (double)view->ndc_offset.x) / (double)view->ndc_scale.x * 0.5 + 0.5;
            double y = 0.5 - (seen[1] / spread - (double)view->ndc_offset.y) / (double)view->ndc_scale.y * 0.5;
            if (!(x >= 0 && x < 1 && y >= 0 && y < 1)) continue;
            uint32_t column = (uint32_t)(x * view->size.x) / m->grid.tile_size,
                     row = (uint32_t)(y * view->size.y) / m->grid.tile_size;
            double slice = log2(depth) * (double)m->grid.slice_scale + (double)m->grid.slice_bias;
            uint32_t bin = (uint32_t)fmin(fmax(slice, 0), m->grid.slices - 1);
            lit++;
            uint32_t tile = bin / m->zone_bins * m->tile_count + row * m->grid.tiles_x + column;
            assert_true(m->holds[(size_t)tile * light_count + i]);
            assert_true(m->holds[(size_t)(m->first_bin + bin) * light_count + i]);
        }
    return lit;
}

static void test_masks_ES_64(void **state) {
    UNUSED(state);
    struct random_state random = {5};
    uint64_t lit = 0;
    for (uint32_t kind = 0; kind < LIST_VIEWS; kind++) {
        struct gpu_view view = list_random_view(kind, &random, WIDTH + kind, HEIGHT);
        list_random_lights(&view, &random, LIGHTS, params, lights);
        struct zbin_params zbin = zbin_params_default();
        if (kind == 1) zbin.bins = 7;
        if (kind == 2) zbin.tile_size = 8;
        struct masks m = build(&view, LIGHTS, &zbin), again = build(&view, LIGHTS, &zbin);
        assert_int_equal(m.totals.overflow_cells, 0);
        assert_int_equal(m.words, again.words);
        assert_memory_equal(m.holds, again.holds, (size_t)m.cell_count * LIGHTS);
        check_masks(&view, LIGHTS, &m);
        lit += check_points(&view, LIGHTS, &m, &random);
        masks_free(&m);
        masks_free(&again);
    }
    print_message("%llu points lit\n", (unsigned long long)lit);
    assert_true(lit > 5000);
}

/* Words, groups and top words that are just full, and just begun; screens of one pixel. */
static void test_sizes_and_counts_ES_64(void **state) {
    UNUSED(state);
    static const uint32_t counts[] = {0, 1, 31, 32, 33, 1023, 1024, 1025, 2049, 33000};
    static const uint32_t sizes[][2] = {{1, 1}, {17, 1}, {1, 33}, {67, 43}};
    struct random_state random = {3};
    for (uint32_t c = 0; c < COUNT_OF(counts); c++) {
        const uint32_t *size = sizes[c % COUNT_OF(sizes)];
        struct gpu_view view = list_random_view(0, &random, size[0], size[1]);
        list_random_lights(&view, &random, counts[c], params, lights);
        /* All in view, so that the words are full. */
        for (uint32_t i = 0; i < counts[c] && c % 2; i++) {
            lights[i].bounds.center = view.eye;
            lights[i].bounds.radius = 1;
        }
        struct zbin_params zbin = zbin_params_default();
        zbin.bins = 5;
        struct masks m = build(&view, counts[c], &zbin);
        if (c % 2) assert_int_equal(m.visible_count, counts[c]);
        assert_int_equal(m.totals.overflow_cells, 0);
        check_masks(&view, counts[c], &m);
        masks_free(&m);
    }
}

/* The words that pixels walk through, over all tiles and bins: those that both masks have. Whether the tile's mask is of the zone, or of all. */
static uint64_t common_words(const struct masks *m, uint32_t light_count, bool zones) {
    uint64_t sum = 0;
    for (uint32_t tile = 0; tile < m->tile_count; tile++)
        for (uint32_t bin = 0; bin < m->grid.slices; bin++)
            for (uint32_t word = 0; word < DIVIDE_UP(m->visible_count, 32u); word++) {
                bool in_tile = false, in_bin = false;
                for (uint32_t slot = word * 32; slot < MIN(word * 32 + 32, m->visible_count); slot++) {
                    in_bin |= m->holds[(size_t)(m->first_bin + bin) * light_count + m->ids[slot]];
                    in_tile |= zones ? m->holds[(size_t)(bin / m->zone_bins * m->tile_count + tile) * light_count + m->ids[slot]]
                                     : tile_holds(m, light_count, tile, m->ids[slot]);
                }
                sum += in_tile && in_bin;
            }
    return sum;
}

/* Of many small lights a tile holds some at each depth: with zones pixels walk through a part of its words. Few lights need none. */
static void test_zones(void **state) {
    UNUSED(state);
    enum { MANY = 32768 };
    struct random_state random = {17};
    struct gpu_view view = list_random_view(0, &random, 67, 43);
    list_random_lights(&view, &random, MANY, params, lights);
    for (uint32_t i = 0; i < MANY; i++) lights[i].bounds.radius = fminf(lights[i].bounds.radius, 0.05f);
    struct zbin_params zbin = zbin_params_default();
    zbin.bins = 32;
    struct masks m = build(&view, MANY, &zbin);
    assert_int_equal(m.zone_bins, 4);
    check_masks(&view, MANY, &m);
    assert_true(check_points(&view, MANY, &m, &random) > 5000);
    uint64_t zones = common_words(&m, MANY, true), whole = common_words(&m, MANY, false);
    print_message("zones of %u bins: %.3f of the words\n", m.zone_bins, (double)zones / (double)whole);
    assert_true(zones > 0 && (double)zones < 0.5 * (double)whole);
    masks_free(&m);
    m = build(&view, LIGHTS, &zbin);
    assert_int_equal(m.first_bin, m.tile_count);
    masks_free(&m);
}

/* A light without a place is in every tile and bin: nothing hangs, nothing is lost. */
static void test_broken_lights_ES_64(void **state) {
    UNUSED(state);
    struct random_state random = {9};
    struct gpu_view view = list_random_view(0, &random, 67, 43);
    list_random_lights(&view, &random, 40, params, lights);
    lights[7].bounds.center.x = NAN;
    lights[21].bounds.center = (vec3){NAN, NAN, NAN};
    lights[33].bounds.radius = INFINITY;
    struct zbin_params zbin = zbin_params_default();
    struct masks m = build(&view, 40, &zbin);
    for (uint32_t c = 0; c < m.cell_count; c++) {
        assert_true(m.holds[c * 40u + 21]);
        assert_true(m.holds[c * 40u + 33]);
        if (c < m.first_bin) assert_true(m.holds[c * 40u + 7]);
    }
    masks_free(&m);
}

/* Cells that the pool cannot hold use all lights; the count says what would have been needed. */
static void test_overflow_CL_10_ES_64(void **state) {
    UNUSED(state);
    struct random_state random = {13};
    struct gpu_view view = list_random_view(0, &random, WIDTH, HEIGHT);
    list_random_lights(&view, &random, LIGHTS, params, lights);
    struct zbin_params zbin = zbin_params_default();
    struct masks fits = build(&view, LIGHTS, &zbin);
    zbin.pool_capacity = fits.totals.entries - 1;
    struct masks tight = build(&view, LIGHTS, &zbin);
    assert_true(tight.totals.overflow_cells >= 1 && tight.totals.overflow_cells < tight.cell_count);
    assert_int_equal(tight.totals.entries, fits.totals.entries);
    zbin.pool_capacity = 0;
    struct masks none = build(&view, LIGHTS, &zbin);
    assert_int_equal(none.totals.entries, fits.totals.entries);
    uint32_t apart = 0;
    for (uint32_t c = 0; c < fits.cell_count; c++) {
        uint32_t held = 0;
        for (uint32_t i = 0; i < LIGHTS; i++) held += fits.holds[(size_t)c * LIGHTS + i];
        if (held > 0) assert_true(none.all[c]);
        if (held == 0 && none.all[c]) apart++;
        if (!tight.all[c]) assert_memory_equal(tight.holds + (size_t)c * LIGHTS, fits.holds + (size_t)c * LIGHTS, LIGHTS);
    }
    /* An empty cell fits anywhere, unless its tile and its bin have different lights in one word. */
    if (apart > fits.cell_count / 50) fail_msg("%u of %u cells", apart, fits.cell_count);
    masks_free(&fits);
    masks_free(&tight);
    masks_free(&none);
}

/* Many lights that overlap: masks are a fraction of what clusters of twice the size take, for about the same evaluations. */
static void test_memory_ES_64(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:hall?lights=0", 0);
    fnl_scatter_params scatter = fnl_scatter_params_default();
    scatter.count = 4096;
    scatter.radius_scale = 8;
    assert_int_equal(fnl_scene_scatter_light_shapes(stage.scene, &scatter), FNL_OK);
    fnl_frame frame = stage.frame;
    frame.width = 160;
    frame.height = 90;
    frame.count_lights = true;
    frame.shading = FNL_SHADING_DEFERRED;
    frame.lists = FNL_LISTS_CLUSTERED;
    frame.clusters.size = 32;
    struct shot clusters = stage_shoot(&stage, &frame);
    shot_free(&clusters);
    clusters = stage_shoot(&stage, &frame); /* the pool has grown */
    frame.lists = FNL_LISTS_ZBIN;
    frame.clusters = frame_plain().clusters;
    struct shot bins = stage_shoot(&stage, &frame);
    assert_int_equal(count_differing(&clusters.radiance, &bins.radiance), 0);
    assert_int_equal(clusters.stats.overflow_cells + bins.stats.overflow_cells, 0);
    double memory = (double)clusters.stats.list_used_bytes / (double)bins.stats.list_used_bytes;
    double evaluations = (double)bins.stats.evaluations / (double)clusters.stats.evaluations;
    print_message("4096 overlapping lights: clusters of 32 pixels take %.1f times the memory of tiles of 16 and bins, which "
                  "visit %.3f "
                  "times the lights\n",
                  memory, evaluations);
    assert_true(memory >= 20);
    assert_true(evaluations <= 1.15);
    shot_free(&clusters);
    shot_free(&bins);
    stage_close(&stage);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_masks_ES_64, harness_check),
        cmocka_unit_test_teardown(test_sizes_and_counts_ES_64, harness_check),
        cmocka_unit_test_teardown(test_zones, harness_check),
        cmocka_unit_test_teardown(test_broken_lights_ES_64, harness_check),
        cmocka_unit_test_teardown(test_overflow_CL_10_ES_64, harness_check),
        cmocka_unit_test_teardown(test_memory_ES_64, harness_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
