/* SPDX-License-Identifier: MIT */
/** Occupied clusters: which there are, what they hold, and what they leave out. */
#include "passes/lights/sparse.h"

#include "passes/lights/clustered.h"
#include "tests/list_bench.h"

enum { LIGHTS = 400, MOST = 5000, WIDTH = 157, HEIGHT = 93, BUCKETS = 54 };

static fnl_light_params params[MOST];
static struct list_light lights[MOST];

/* ---- building ---- */

struct scene_data {
    struct gpu_view view;
    float *depth;      /* reversed */
    uint16_t *normals; /* four a pixel, as in the G-buffer; or NULL */
    uint32_t light_count;
    struct clustered_params grid;
    bool keeps_bounds; /* as for scattered points: sparse_copy.bounds */
};

struct sparse_copy {
    struct list_copy list; /* of the occupied cells */
    uint32_t buckets, key_count, cell_limit;
    uint32_t *table;
    struct gpu_cell_bounds *bounds; /* or NULL */
};

static struct sparse_copy build(const struct scene_data *s) {
    struct list_lab lab = list_lab_open(&s->view, lights, s->light_count);
    struct sparse_params p = {.grid = s->grid, .depth = list_lab_depth(&lab, s->depth)};
    struct gbuffer gbuffer = {
        .depth = p.depth, .target_count = 2, .form = GBUFFER_FORM(GBUFFER_DEFAULT, NORMALS_OCTAHEDRAL)};
    if (s->normals) {
        gbuffer.normal = gbuffer.targets[1] = list_lab_image(&lab, VK_FORMAT_R16G16B16A16_UNORM, 8, s->normals);
        p.gbuffer = &gbuffer;
    }
    list_lab_begin(&lab);
    lab.input.scattered = s->keeps_bounds;
    struct light_list list = sparse_add(lab.graph, harness_device(), &lab.input, &lab.in_view, &p).lights;
    assert_int_equal(list.kind, GPU_LIST_SPARSE);
    list_lab_run(&lab, (graph_buffer[]){list.extra, list.cells, list.ids, list.totals, list.bounds},
                 s->keeps_bounds ? 5 : 4);

    struct sparse_copy copy = {.buckets = s->normals ? BUCKETS : 1, .cell_limit = list.cell_count};
    struct gpu_light_list *grid = &copy.list.grid;
    clustered_grid(grid, s->view.size.x, s->view.size.y, &s->grid);
    copy.key_count = grid->tiles_x * grid->tiles_y * grid->slices * copy.buckets;
    assert_int_equal(lab.reads.buffers[0].size, (copy.key_count + 1) * 4ull);
    copy.table = list_reads_take(&lab.reads, 0);
    copy.list.cells = list_reads_take(&lab.reads, 1);
    copy.list.ids = list_reads_take(&lab.reads, 2);
    if (s->keeps_bounds) copy.bounds = list_reads_take(&lab.reads, 4);
    copy.list.cell_count = copy.table[copy.key_count];
    memcpy(&copy.list.totals, lab.reads.buffers[3].mapped, sizeof copy.list.totals);
    list_lab_close(&lab);
    return copy;
}

static void copy_free(struct sparse_copy *c) {
    list_free(&c->list);
    free(c->table);
    free(c->bounds);
}

static bool occupied(const struct sparse_copy *c, uint32_t key) { return c->table[key] != c->table[key + 1]; }

static bool holds(const struct sparse_copy *c, uint32_t key, uint32_t light) {
    return list_holds(&c->list, c->table[key], light);
}

/* Cells follow each other in the pool and ascend; totals are exact. */
static uint64_t check_form(const struct sparse_copy *c, uint32_t light_count) {
    assert_true(c->list.cell_count <= c->cell_limit);
    list_check_form(&c->list, light_count);
    return list_entries(&c->list);
}

/* ---- made-up surfaces ---- */

static uint16_t *random_normals(const struct gpu_view *view, struct random_state *random) {
    uint16_t *normals = calloc((size_t)view->size.x * view->size.y, 8);
    assert_non_null(normals);
    double n[3] = {0, 1, 0};
    for (uint32_t i = 0; i < view->size.x * view->size.y; i++) {
        if (i % 11 == 0)
            for (int k = 0; k < 3; k++) n[k] = (double)random_range(random, -1, 1);
        if (i % 50 == 0) { /* on a border between thirds */
            n[0] = 1;
            n[1] = 1.0 / 3;
            n[2] = i % 100 ? -1.0 / 3 : 1;
        }
        pack_normal(n, normals + 4 * (size_t)i);
    }
    return normals;
}

static uint32_t bucket_of(const double n[3]) {
    int axis = fabs(n[0]) >= fabs(n[1]) && fabs(n[0]) >= fabs(n[2]) ? 0 : fabs(n[1]) >= fabs(n[2]) ? 1 : 2, parts[2];
    double whole = fabs(n[axis]), others[2] = {axis == 0 ? n[1] : n[0], axis == 2 ? n[1] : n[2]};
    for (int i = 0; i < 2; i++) parts[i] = 3 * others[i] < -whole ? 0 : 3 * others[i] > whole ? 2 : 1;
    return (uint32_t)(((axis * 2 + (n[axis] < 0)) * 3 + parts[0]) * 3 + parts[1]);
}

static double depth_at(const struct scene_data *s, uint32_t x, uint32_t y) {
    double d = s->depth[(size_t)y * s->view.size.x + x];
    const vec4 *m = &s->view.depth_decode;
    return d <= 0 ? 0 : ((double)m->x + (double)m->y * d) / ((double)m->z + (double)m->w * d);
}

/* Keys that pixels must occupy, and those that rounding allows them to. */
static void mark_keys(const struct scene_data *s, const struct sparse_copy *c, bool *must, bool *may) {
    const struct gpu_light_list *g = &c->list.grid;
    for (uint32_t y = 0; y < s->view.size.y; y++)
        for (uint32_t x = 0; x < s->view.size.x; x++) {
            double depth = depth_at(s, x, y);
            if (depth <= 0) continue;
            uint32_t tile = y / g->tile_size * g->tiles_x + x / g->tile_size, tiles = g->tiles_x * g->tiles_y;
            double n[3] = {0, 0, 1};
            if (s->normals) unpack_normal(s->normals + 4 * ((size_t)y * s->view.size.x + x), n);
            for (int shift = 0; shift < 9; shift++) {
                double m[3] = {n[0], n[1], n[2]}, slack = shift == 8 ? 0 : 2e-4;
                for (int k = 0; k < 3; k++) m[k] += (shift >> k & 1 ? 1 : -1) * slack;
                uint32_t bucket = s->normals ? bucket_of(m) : 0;
                for (int side = -1; side <= 1; side++) {
                    uint32_t key = (list_slice_at(g, depth * (1 + 2e-4 * side)) * tiles + tile) * c->buckets + bucket;
                    may[key] = true;
                    double exact[3] = {n[0], n[1], n[2]};
                    if (shift == 8 && side == 0 && bucket == (s->normals ? bucket_of(exact) : 0)) must[key] = true;
                }
            }
        }
}

static void test_occupied_clusters_ES_54(void **state) {
    UNUSED(state);
    struct random_state random = {3};
    for (uint32_t kind = 0; kind < LIST_VIEWS; kind++)
        for (int with_normals = 0; with_normals < 2; with_normals++) {
            struct scene_data s = {.view = list_random_view(kind, &random, WIDTH + kind, HEIGHT),
                                   .light_count = 33,
                                   .grid = clustered_params_default()};
            s.grid.tile_size = 16;
            s.grid.linear = kind == 2;
            list_random_lights(&s.view, &random, s.light_count, params, lights);
            s.depth = list_random_depth(&s.view, &random);
            if (with_normals) s.normals = random_normals(&s.view, &random);
            struct sparse_copy c = build(&s);
            bool *must = calloc(c.key_count, 1), *may = calloc(c.key_count, 1);
            assert_non_null(must);
            assert_non_null(may);
            mark_keys(&s, &c, must, may);
            uint32_t wanted = 0, found = 0;
            for (uint32_t k = 0; k < c.key_count; k++) {
                wanted += must[k];
                found += occupied(&c, k);
                assert_true(occupied(&c, k) || !must[k]);
                assert_true(may[k] || !occupied(&c, k));
                assert_true(c.table[k + 1] - c.table[k] <= 1);
            }
            print_message("%s%s: %u of %u keys occupied, %u by the pixels without rounding\n", list_view_names[kind],
                          with_normals ? ", normals" : "", found, c.key_count, wanted);
            assert_true(wanted > 20 && found == c.table[c.key_count] && found < c.key_count);
            free(must);
            free(may);
            free(s.depth);
            free(s.normals);
            copy_free(&c);
        }
}

/* Lists are parts of the cluster's own, and miss no light that reaches a pixel (in front of its surface, with normals). */
static void test_tight_lists_ES_54_ES_56(void **state) {
    UNUSED(state);
    struct random_state random = {31};
    for (uint32_t kind = 0; kind < LIST_VIEWS; kind++) {
        struct scene_data s = {.view = list_random_view(kind, &random, WIDTH, HEIGHT + kind),
                               .light_count = LIGHTS,
                               .grid = clustered_params_default()};
        s.grid.tile_size = 32;
        list_random_lights(&s.view, &random, LIGHTS, params, lights);
        s.depth = list_random_depth(&s.view, &random);
        uint16_t *normals = random_normals(&s.view, &random);
        struct list_request dense = {.builder = LIST_BVH,
                                     .view = s.view,
                                     .lights = lights,
                                     .light_count = LIGHTS,
                                     .tiled = tiled_params_default(),
                                     .clustered = s.grid};
        struct list_copy all = list_build(&dense);
        uint64_t lit = 0, behind_dropped = 0, entries[2] = {0}, dense_entries = 0;
        for (int with_normals = 0; with_normals < 2; with_normals++) {
            s.normals = with_normals ? normals : NULL;
            struct sparse_copy c = build(&s), again = build(&s);
            entries[with_normals] = check_form(&c, LIGHTS);
            assert_memory_equal(c.table, again.table, (c.key_count + 1) * 4ull);
            assert_memory_equal(c.list.cells, again.list.cells, c.table[c.key_count] * sizeof *c.list.cells);
            assert_memory_equal(c.list.ids, again.list.ids, entries[with_normals] * 4);
            for (uint32_t k = 0; k < c.key_count; k++) {
                if (!occupied(&c, k)) continue;
                struct gpu_cell cell = c.list.cells[c.table[k]];
                for (uint32_t i = 0; i < cell.count; i++)
                    assert_true(list_holds(&all, k / c.buckets, c.list.ids[cell.offset + i]));
                if (!with_normals) dense_entries += all.cells[k].count;
            }
            for (uint32_t y = 0; y < s.view.size.y; y++)
                for (uint32_t x = 0; x < s.view.size.x; x++) {
                    double depth = depth_at(&s, x, y), seen[3], point[3], n[3] = {0, 0, 1};
                    if (depth <= 0) continue;
                    view_of_pixel(&s.view, x + 0.5, y + 0.5, depth, seen);
                    view_to_world(&s.view, seen, point);
                    if (with_normals) unpack_normal(normals + 4 * ((size_t)y * s.view.size.x + x), n);
                    uint32_t tile = y / c.list.grid.tile_size * c.list.grid.tiles_x + x / c.list.grid.tile_size;
                    uint32_t key =
                        (list_slice_at(&c.list.grid, depth) * c.list.grid.tiles_x * c.list.grid.tiles_y + tile) * c.buckets;
                    if (with_normals) key += bucket_of(n);
                    for (uint32_t i = 0; i < LIGHTS; i++) {
                        if (!light_reaches(&params[i], point)) continue;
                        double facing = n[0] * ((double)params[i].position.x - point[0]) +
                                        n[1] * ((double)params[i].position.y - point[1]) +
                                        n[2] * ((double)params[i].position.z - point[2]);
                        bool held = holds(&c, key, i);
                        if (with_normals && facing <= 0) {
                            behind_dropped += !held;
                            continue;
                        }
                        lit++;
                        assert_true(held);
                    }
                }
            copy_free(&c);
            copy_free(&again);
        }
        print_message(
            "%s: %llu entries in those clusters, %llu tight, %llu with normals; %llu pairs lit, %llu behind left out\n",
            list_view_names[kind], (unsigned long long)dense_entries, (unsigned long long)entries[0],
            (unsigned long long)entries[1], (unsigned long long)lit, (unsigned long long)behind_dropped);
        assert_true(lit > 1000 && behind_dropped > 100);
        assert_true(entries[0] < dense_entries);
        list_free(&all);
        free(s.depth);
        free(normals);
    }
}

/* ---- bounds ---- */

/* What a cell's pixels span: positions in view space, where normals pierce the bucket's face of the cube, and the least way along the four
   corners of these. */
struct extent {
    double low[3], high[3], parts_low[2], parts_high[2], least[4];
};

static void bucket_axes(uint32_t bucket, int out[3]) { /* that across the face, and the two in it */
    uint32_t face = bucket / 9;
    out[0] = face < 2 ? 0 : face < 4 ? 1 : 2;
    out[1] = face < 2 ? 1 : 0;
    out[2] = face < 4 ? 2 : 1;
}

static void add_to_extent(struct extent *e, uint32_t bucket, const double seen[3], const double n[3]) {
    int axes[3];
    bucket_axes(bucket, axes);
    for (int k = 0; k < 3; k++) {
        e->low[k] = fmin(e->low[k], seen[k]);
        e->high[k] = fmax(e->high[k], seen[k]);
    }
    for (int k = 0; k < 2; k++) {
        e->parts_low[k] = fmin(e->parts_low[k], n[axes[1 + k]] / fabs(n[axes[0]]));
        e->parts_high[k] = fmax(e->parts_high[k], n[axes[1 + k]] / fabs(n[axes[0]]));
    }
}

/* Of the four corners of the normals, in view space. */
static void corner_of(const struct gpu_view *view, const struct extent *e, uint32_t bucket, uint32_t corner, double out[3]) {
    int axes[3];
    double n[3], length = 0;
    bucket_axes(bucket, axes);
    n[axes[0]] = bucket / 9 & 1 ? -1 : 1;
    for (int k = 0; k < 2; k++) n[axes[1 + k]] = corner >> k & 1 ? e->parts_high[k] + 1e-4 : e->parts_low[k] - 1e-4;
    for (int k = 0; k < 3; k++) length += n[k] * n[k];
    for (int row = 0; row < 3; row++) {
        out[row] = 0;
        for (int k = 0; k < 3; k++) out[row] += (double)view->world_to_view.m[4 * k + row] * n[k] / sqrt(length);
    }
}

/* Goes over the keys that each pixel may be in, so that rounding does not matter: `step` 0 spans positions and normals, 1 the way along
   corners. `must`: over the pixels' own keys alone. */
static void span_pixels(const struct scene_data *s, const struct sparse_copy *c, int step, struct extent *may,
                        struct extent *must) {
    const struct gpu_light_list *g = &c->list.grid;
    for (uint32_t y = 0; y < s->view.size.y; y++)
        for (uint32_t x = 0; x < s->view.size.x; x++) {
            double depth = depth_at(s, x, y), seen[3], n[3] = {0, 0, 1};
            if (depth <= 0) continue;
            view_of_pixel(&s->view, x + 0.5, y + 0.5, depth, seen);
            uint32_t tile = y / g->tile_size * g->tiles_x + x / g->tile_size, tiles = g->tiles_x * g->tiles_y;
            if (s->normals) unpack_normal(s->normals + 4 * ((size_t)y * s->view.size.x + x), n);
            for (int shift = 0; shift < (s->normals ? 9 : 1); shift++) {
                double m[3];
                for (int k = 0; k < 3; k++) m[k] = n[k] + (shift == 8 ? 0 : shift >> k & 1 ? 2e-4 : -2e-4);
                uint32_t bucket = s->normals ? bucket_of(m) : 0;
                for (int side = -1; side <= 1; side++) {
                    uint32_t key = (list_slice_at(g, depth * (1 + 2e-4 * side)) * tiles + tile) * c->buckets + bucket;
                    if (step == 0) {
                        add_to_extent(&may[key], bucket, seen, n);
                        if (side == 0 && bucket == (s->normals ? bucket_of(n) : 0))
                            add_to_extent(&must[key], bucket, seen, n);
                        continue;
                    }
                    for (uint32_t corner = 0; corner < 4; corner++) {
                        double normal[3], along = 0;
                        corner_of(&s->view, &may[key], bucket, corner, normal);
                        for (int k = 0; k < 3; k++) along += normal[k] * seen[k];
                        may[key].least[corner] = fmin(may[key].least[corner], along);
                    }
                }
            }
        }
}

/*
 * The box of a cell is that of its own pixels, on all three axes; a light of its list touches that box, and with normals it is not behind
 * all of the cell's surfaces, measured by their own positions and normals.
 */
static void test_bounds_ES_54_ES_56(void **state) {
    UNUSED(state);
    struct random_state random = {37};
    static const struct extent none = {{INFINITY, INFINITY, INFINITY},
                                       {-INFINITY, -INFINITY, -INFINITY},
                                       {INFINITY, INFINITY},
                                       {-INFINITY, -INFINITY},
                                       {INFINITY, INFINITY, INFINITY, INFINITY}};
    for (uint32_t kind = 0; kind < LIST_VIEWS; kind++)
        for (int with_normals = 0; with_normals < 2; with_normals++) {
            struct scene_data s = {.view = list_random_view(kind, &random, WIDTH + kind, HEIGHT),
                                   .light_count = LIGHTS,
                                   .grid = clustered_params_default(),
                                   .keeps_bounds = true};
            s.grid.tile_size = 32;
            list_random_lights(&s.view, &random, LIGHTS, params, lights);
            s.depth = list_random_depth(&s.view, &random);
            if (with_normals) s.normals = random_normals(&s.view, &random);
            struct sparse_copy c = build(&s);
            struct extent *may = malloc(c.key_count * sizeof *may), *must = malloc(c.key_count * sizeof *must);
            assert_true(may && must);
            for (uint32_t k = 0; k < c.key_count; k++) may[k] = must[k] = none;
            span_pixels(&s, &c, 0, may, must);
            if (with_normals) span_pixels(&s, &c, 1, may, must);
            uint64_t held = 0;
            for (uint32_t k = 0; k < c.key_count; k++) {
                if (!occupied(&c, k)) continue;
                const struct gpu_cell_bounds *b = &c.bounds[c.table[k]];
                const struct extent *e = &may[k];
                double slack = 1e-5;
                for (int a = 0; a < 3; a++) slack += 3e-4 * fmax(fabs(e->low[a]), fabs(e->high[a]));
                for (int a = 0; a < 3; a++) {
                    double low = (double)(&b->low.x)[a], high = (double)(&b->high.x)[a];
                    assert_true(low <= must[k].low[a] && high >= must[k].high[a]);
                    assert_true(low >= e->low[a] - slack && high <= e->high[a] + slack);
                }
                struct gpu_cell cell = c.list.cells[c.table[k]];
                for (uint32_t i = 0; i < cell.count; i++, held++) {
                    const struct list_light *light = &lights[c.list.ids[cell.offset + i]];
                    const double world[2][3] = {
                        {(double)light->bounds.center.x, (double)light->bounds.center.y, (double)light->bounds.center.z},
                        {(double)light->shape.position.x, (double)light->shape.position.y, (double)light->shape.position.z}};
                    double center[3], apex[3], outside2 = 0, radius = (double)light->bounds.radius;
                    world_to_view(&s.view, world[0], center);
                    world_to_view(&s.view, world[1], apex);
                    for (int a = 0; a < 3; a++) {
                        double out = fmax(fmax(e->low[a] - center[a], center[a] - e->high[a]), 0);
                        outside2 += out * out;
                    }
                    double far = sqrt(center[0] * center[0] + center[1] * center[1] + center[2] * center[2]);
                    assert_true(sqrt(outside2) <= radius + 2 * slack + 1e-3 * (radius + 0.01 * far));
                    bool faces = !with_normals;
                    for (uint32_t corner = 0; corner < 4 && !faces; corner++) {
                        double normal[3], along = 0;
                        corner_of(&s.view, e, k % c.buckets, corner, normal);
                        for (int a = 0; a < 3; a++) along += normal[a] * apex[a];
                        faces = along - e->least[corner] > -2 * slack - 2e-3 * ((double)light->shape.range + 0.01 * far);
                    }
                    assert_true(faces);
                }
            }
            assert_true(held > 20);
            free(may);
            free(must);
            free(s.depth);
            free(s.normals);
            copy_free(&c);
        }
}

static void test_sizes_and_counts_ES_54(void **state) {
    UNUSED(state);
    static const uint32_t sizes[][2] = {{1, 1}, {1, 95}, {65, 3}, {131, 83}}, counts[] = {0, 1, 33, MOST};
    struct random_state random = {8};
    for (uint32_t z = 0; z < COUNT_OF(sizes); z++)
        for (uint32_t c = 0; c < COUNT_OF(counts); c++) {
            struct scene_data s = {.view = list_random_view(0, &random, sizes[z][0], sizes[z][1]),
                                   .light_count = counts[c],
                                   .grid = clustered_params_default()};
            list_random_lights(&s.view, &random, counts[c], params, lights);
            s.depth = list_random_depth(&s.view, &random);
            struct sparse_copy copy = build(&s);
            check_form(&copy, counts[c]);
            copy_free(&copy);
            memset(s.depth, 0, sizeof *s.depth * sizes[z][0] * sizes[z][1]); /* nothing but sky */
            copy = build(&s);
            assert_int_equal(copy.table[copy.key_count], 0);
            assert_int_equal(copy.list.totals.entries, 0);
            copy_free(&copy);
            free(s.depth);
        }
}

static void test_overflow_CL_10(void **state) {
    UNUSED(state);
    struct random_state random = {5};
    struct scene_data s = {
        .view = list_random_view(0, &random, WIDTH, HEIGHT), .light_count = LIGHTS, .grid = clustered_params_default()};
    list_random_lights(&s.view, &random, LIGHTS, params, lights);
    s.depth = list_random_depth(&s.view, &random);
    struct sparse_copy full = build(&s);
    uint32_t entries = (uint32_t)check_form(&full, LIGHTS);
    assert_true(entries > 100);
    const uint32_t capacities[] = {0, 1, entries / 2, entries - 1, entries};
    for (uint32_t k = 0; k < COUNT_OF(capacities); k++) {
        s.grid.pool_capacity = capacities[k];
        struct sparse_copy c = build(&s);
        assert_int_equal(c.list.totals.entries, entries);
        uint32_t overflow = 0;
        for (uint32_t i = 0; i < full.table[full.key_count]; i++) {
            struct gpu_cell want = full.list.cells[i];
            if (want.offset + want.count > capacities[k]) {
                assert_int_equal(c.list.cells[i].count, GPU_CELL_ALL);
                overflow++;
            } else {
                assert_int_equal(c.list.cells[i].count, want.count);
                assert_memory_equal(c.list.ids + want.offset, full.list.ids + want.offset, want.count * 4ull);
            }
        }
        assert_int_equal(c.list.totals.overflow_cells, overflow);
        copy_free(&c);
    }
    copy_free(&full);
    free(s.depth);
}

/* ---- whole frames ---- */

/* A floor with lamps above and as many below: the latter are gone, and the picture is the same. */
static void test_lights_below_the_floor_ES_56(void **state) {
    UNUSED(state);
    static const float positions[] = {-20, 0, -20, 20, 0, -20, 20, 0, 20, -20, 0, 20};
    static const uint32_t indices[] = {0, 2, 1, 0, 3, 2};
    struct stage stage = stage_open("builtin:spheres?lights=0", 0);
    fnl_mesh_params mesh_params = {.vertex_count = 4, .index_count = 6, .positions = positions, .indices = indices};
    fnl_mesh_id mesh;
    fnl_instance_id instance;
    fnl_mat4 identity = {{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 30, 0, 1}};
    assert_int_equal(fnl_scene_add_mesh(stage.scene, &mesh_params, &mesh), FNL_OK);
    assert_int_equal(fnl_scene_add_instance(stage.scene, mesh, &identity, &instance), FNL_OK);
    for (uint32_t i = 0; i < 400; i++) {
        fnl_light_params light = fnl_light_params_default();
        fnl_light_id id;
        light.kind = (fnl_light_kind)(FNL_LIGHT_POINT + i / 2 % 5);
        light.position = (fnl_vec3){(float)(i / 2 % 20) * 2 - 19, i % 2 ? 32 : 28, (float)(i / 40) * 4 - 19};
        light.direction = (fnl_vec3){0, i % 2 ? -1 : 1, 0};
        light.up = (fnl_vec3){1, 0, 0};
        light.range = 4;
        light.length = 1;
        light.box_size = (fnl_vec3){2, 2, 5};
        light.intensity = 20;
        assert_int_equal(fnl_scene_add_light(stage.scene, &light, &id), FNL_OK);
    }
    fnl_frame frame = stage.frame;
    frame.camera.position = (fnl_vec3){0, 38, 18};
    frame.camera.target = (fnl_vec3){0, 30, 0};
    frame.shading = FNL_SHADING_DEFERRED;
    frame.count_lights = true;
    frame.lists = FNL_LISTS_ALL;
    struct shot all = stage_shoot(&stage, &frame);
    frame.lists = FNL_LISTS_SPARSE;
    frame.list.normal_cones = true;
    struct shot with = stage_shoot(&stage, &frame);
    frame.list.normal_cones = false;
    struct shot without = stage_shoot(&stage, &frame);
    print_message("evaluations %llu, with normals %llu, of which %llu light a surface; at most %u and %u a pixel\n",
                  (unsigned long long)without.stats.evaluations, (unsigned long long)with.stats.evaluations,
                  (unsigned long long)with.stats.evaluations_useful, without.stats.max_per_pixel, with.stats.max_per_pixel);
    assert_int_equal(count_differing(&all.radiance, &with.radiance), 0);
    assert_int_equal(count_differing(&all.radiance, &without.radiance), 0);
    assert_true(with.stats.evaluations > 0 && (double)with.stats.evaluations < 0.6 * (double)without.stats.evaluations);
    shot_free(&all);
    shot_free(&with);
    shot_free(&without);
    stage_close(&stage);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_occupied_clusters_ES_54, harness_check),
        cmocka_unit_test_teardown(test_tight_lists_ES_54_ES_56, harness_check),
        cmocka_unit_test_teardown(test_bounds_ES_54_ES_56, harness_check),
        cmocka_unit_test_teardown(test_sizes_and_counts_ES_54, harness_check),
        cmocka_unit_test_teardown(test_overflow_CL_10, harness_check),
        cmocka_unit_test_teardown(test_lights_below_the_floor_ES_56, harness_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
