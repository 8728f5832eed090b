/* SPDX-License-Identifier: MIT */
/**
 * One array of bounds that lights, decals and probes (boxes that only this test makes) fill in turn, through every builder, for one kind or
 * for all: asked on the device, a point of a surface gets everything of those kinds that holds it, in order, and nothing of another kind.
 */
#include "passes/lights/backface.h"
#include "passes/lights/clustered.h"
#include "passes/lights/fine.h"
#include "passes/lights/raster.h"
#include "passes/lights/sparse.h"
#include "passes/lights/tree.h"
#include "passes/lights/walk_test.h"
#include "passes/lights/world_grid.h"

enum { COUNT = 360, SIDE = 64 };
enum { PROBE = GPU_ENTITY_DECAL + 1 };

enum builder {
    ALL,
    TILED,
    TILED_SPARE, /* no pool: every cell uses the spare list */
    HALFZ,
    TILES_25D,
    ENHANCED,
    BACKFACE,
    TREE,
    FINE,
    CLUSTERED,
    CLUSTERED_CPU,
    BVH,
    SPARSE,
    SPARSE_NORMALS,
    RASTER,
    RASTER_LINKS,
    ZBIN,
    WORLD,
    GRID2D,
    BUILDERS
};
static const char *const builder_names[BUILDERS] = {
    "all",       "tiled",         "spare", "halfz",  "25d",            "enhanced", "backface",     "tree", "fine",
    "clustered", "clustered_cpu", "bvh",   "sparse", "sparse normals", "raster",   "raster links", "zbin", "world",
    "grid2d"};

static fnl_light_params params[COUNT]; /* of lights, and of probes as if they were lights with the shape of a box */
static struct {
    mat4 to_cube;
} decals[COUNT];
static struct list_light entities[COUNT];
static struct gpu_view view;
static float *depth;
static uint16_t (*normals)[4];

/* ---- a made-up place ---- */

static vec3 random_unit(struct random_state *random) {
    return vec3_normalize(
        vec3_make(random_range(random, -1, 1), random_range(random, -1, 1), random_range(random, -1, 1)));
}

/* Sizes are parts of the view depth. */
static void make_light(struct random_state *random, uint32_t i, vec3 at, float view_depth) {
    fnl_light_params *p = &params[i];
    *p = fnl_light_params_default();
    p->kind = (fnl_light_kind)(FNL_LIGHT_POINT + i / 3 % 5);
    p->range = view_depth * exp2f(random_range(random, -4, -1));
    p->position = vec3_add_scaled(at, random_unit(random), p->range * random_range(random, 0, 1.5f));
    p->direction = vec3_normalize(vec3_add_scaled(vec3_sub(at, p->position), random_unit(random), 0.2f));
    p->outer_cone_angle = random_range(random, 0.1f, 1.5f);
    p->inner_cone_angle = 0.5f * p->outer_cone_angle;
    p->length = view_depth * random_range(random, 0, 0.3f);
    p->wedge_angles[0] = random_range(random, 0.1f, 1.2f);
    p->wedge_angles[1] = random_range(random, 0.1f, 1.2f);
    p->box_size = vec3_make(p->range, p->range * random_range(random, 0.1f, 2), p->range * random_range(random, 0.1f, 2));
}

/* A skewed box; the point is just within one of its corners, or anywhere in it. */
static void make_decal(struct random_state *random, uint32_t i, vec3 at, float view_depth, uint32_t user) {
    mat4 m = mat4_scaling(vec3_make(1, 1, 1));
    for (int axis = 0; axis < 3; axis++) {
        vec3 side = vec3_scale(random_unit(random), view_depth * exp2f(random_range(random, -4, 0)));
        m.m[axis * 4] = side.x, m.m[axis * 4 + 1] = side.y, m.m[axis * 4 + 2] = side.z;
        float part = i % 2 ? random_range(random, -0.4f, 0.4f) : random_bits(random) % 2 ? 0.4999f : -0.4999f;
        at = vec3_add_scaled(at, side, part);
    }
    m.m[12] = at.x, m.m[13] = at.y, m.m[14] = at.z;
    if (!mat4_inverse(&m, &decals[i].to_cube)) decals[i].to_cube = mat4_scaling(vec3_make(0, 0, 0));
    entities[i].bounds = device_decal_bounds(&m, user);
}

/* Lights, decals and probes take turns without a rule; each kind numbers its own. */
static void make_place(struct random_state *random) {
    uint32_t users[GPU_ENTITY_KINDS] = {0};
    view = list_random_view(0, random, SIDE, SIDE - 5);
    depth = list_random_depth(&view, random);
    normals = calloc((size_t)SIDE * SIDE, sizeof *normals);
    assert_non_null(normals);
    const double back[3] = {(double)view.back.x, (double)view.back.y, (double)view.back.z};
    uint16_t packed[4];
    pack_normal(back, packed);
    double unpacked[3];
    unpack_normal(packed, unpacked);
    for (uint32_t i = 0; i < SIDE * SIDE; i++) memcpy(normals[i], packed, sizeof packed);
    for (uint32_t i = 0; i < WALK_POINTS; i++) {
        struct gpu_walk_point *p = &points[i];
        double at[3];
        do p->pixel = (uvec2){random_bits(random) % view.size.x, random_bits(random) % view.size.y};
        while (!list_position_of(&view, depth, p->pixel.x, p->pixel.y, at));
        p->position = vec3_make((float)at[0], (float)at[1], (float)at[2]);
        p->view_depth = (float)view_depth_of_depth(&view, depth[p->pixel.y * view.size.x + p->pixel.x]);
        p->normal = vec3_make((float)unpacked[0], (float)unpacked[1], (float)unpacked[2]);
    }
    for (uint32_t i = 0; i < COUNT; i++) {
        const struct gpu_walk_point *p = &points[random_bits(random) % WALK_POINTS];
        uint32_t kind = random_bits(random) % 3, user = users[kind]++;
        make_light(random, i, p->position, p->view_depth);
        if (kind == PROBE) params[i].kind = FNL_LIGHT_BOX;
        entities[i] = list_light_of(&params[i], user);
        entities[i].bounds.kind = kind;
        if (kind == GPU_ENTITY_DECAL) make_decal(random, i, p->position, p->view_depth, user);
    }
}

/* ---- what holds a point ---- */

static bool holds(uint32_t i, const struct gpu_walk_point *p) {
    const double at[3] = {(double)p->position.x, (double)p->position.y, (double)p->position.z};
    if (entities[i].bounds.kind != GPU_ENTITY_DECAL) return light_reaches(&params[i], at);
    vec3 q = mat4_point(&decals[i].to_cube, p->position);
    return fmaxf(fmaxf(fabsf(q.x), fabsf(q.y)), fabsf(q.z)) <= 0.5f;
}

static bool sphere_holds(uint32_t i, const struct gpu_walk_point *p, float slack) {
    return vec3_distance(entities[i].bounds.center, p->position) <= entities[i].bounds.radius * (1 + slack) + slack;
}

/* A light that is behind the surface gives it nothing: backface lists leave it out. Nothing else is ever behind. */
static bool is_behind(uint32_t i, const struct gpu_walk_point *p) {
    if (entities[i].bounds.kind != GPU_ENTITY_LIGHT) return false;
    const struct gpu_shape *s = &entities[i].shape;
    float best = -INFINITY;
    for (int end = -1; end <= 1; end += 2) {
        vec3 from = vec3_add_scaled(s->position, s->direction, s->kind == GPU_SHAPE_CAPSULE ? (float)end * s->size.x : 0);
        vec3 ray = s->kind == GPU_SHAPE_BOX ? vec3_scale(s->direction, -1) : vec3_sub(from, p->position);
        best = fmaxf(best, vec3_dot(ray, p->normal));
    }
    return best <= 0;
}

/* ---- the builders ---- */

struct cpu_builders {
    struct clustered_cpu clustered;
    struct light_tree tree;
    struct world_grid grid;
};

static struct light_list add_list(struct list_lab *lab, enum builder builder, graph_image depth_image, graph_image normal_image,
                                  struct cpu_builders *cpu, uint32_t list_kind) {
    gpu_device *device = harness_device();
    const struct light_input *input = &lab->input;
    const struct lights_in_view *in_view = &lab->in_view;
    struct gpu_entity_bounds *bounds = list_bounds_of(entities, COUNT);
    struct tiled_params tiled = tiled_params_default();
    struct clustered_params clusters = clustered_params_default();
    struct gbuffer gbuffer = {.depth = depth_image,
                              .normal = normal_image,
                              .targets = {{0}, normal_image},
                              .target_count = 2,
                              .form = GBUFFER_FORM(GBUFFER_DEFAULT, NORMALS_OCTAHEDRAL),
                              .view = lab->input.view};
    struct light_list list = {0};
    clusters.tile_size = 32;
    clusters.slices = 16;
    tiled.pool_capacity = builder == TILED_SPARE ? 0 : tiled.pool_capacity;
    switch (builder) {
    case ALL:
        list = light_list_all_add(lab->graph, device, input);
        break;
    case TILED:
    case TILED_SPARE:
        list = tiled_add(lab->graph, device, input, in_view, depth_image, &tiled);
        break;
    case HALFZ:
        list = halfz_add(lab->graph, device, input, in_view, depth_image, &tiled);
        break;
    case TILES_25D:
        list = tiled25d_add(lab->graph, device, input, in_view, depth_image, &tiled);
        break;
    case ENHANCED:
        list = enhanced_add(lab->graph, device, input, in_view, &tiled);
        break;
    case BACKFACE: {
        struct backface_params p = backface_params_default();
        p.tiles = tiled;
        p.least = 1;
        list = backface_add(lab->graph, device, input, in_view, &gbuffer, &p);
        break;
    }
    case TREE:
        list = light_tree_add(&cpu->tree, device, input, bounds, &view, &(struct light_tree_params){.tile_size = 16});
        break;
    case FINE: {
        struct fine_params p = fine_params_default();
        p.eye_distance = vec3_length(view.eye);
        struct fine_lists lists = fine_add(lab->graph, device, input, in_view, depth_image, &p);
        list = lists.others[list_kind].header ? lists.others[list_kind] : lists.lights;
        break;
    }
    case CLUSTERED:
        list = clustered_add(lab->graph, device, input, in_view, &clusters);
        break;
    case CLUSTERED_CPU: {
        struct clustered_cpu_view seen = {view.ndc_scale, view.ndc_offset, view.orthographic > 0.5f, view.size.x, view.size.y};
        list = clustered_cpu_add(&cpu->clustered, device, input, bounds, &view.world_to_view, &seen, &clusters);
        break;
    }
    case BVH:
        list = bvh_add(lab->graph, device, input, in_view, &clusters);
        break;
    case SPARSE:
    case SPARSE_NORMALS: {
        struct sparse_params p = {
            .grid = clusters, .depth = depth_image, .gbuffer = builder == SPARSE_NORMALS ? &gbuffer : NULL};
        list = sparse_add(lab->graph, device, input, in_view, &p).lights;
        break;
    }
    case RASTER:
    case RASTER_LINKS: {
        struct raster_params p = raster_params_default();
        p.grid = clusters;
        p.nodes = builder == RASTER ? GPU_NODES_ARRAY : GPU_NODES_64;
        p.near = view.near_distance;
        list = raster_add(lab->graph, device, input, in_view, &p).list;
        break;
    }
    case ZBIN: {
        struct zbin_params p = zbin_params_default();
        list = zbin_add(lab->graph, device, input, in_view, &p);
        break;
    }
    default: {
        struct world_grid_params p = world_grid_params_default();
        struct box nowhere = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
        p.flat = builder == GRID2D;
        list = world_grid_add(&cpu->grid, lab->graph, device, input, bounds, 1, &nowhere, &p);
    }
    }
    free(bounds);
    return list;
}

struct counts {
    uint32_t held, visited, loose; /* pairs of a point and what is of the list's kinds; loose: visited, but not even the sphere comes near */
};

static struct counts check(enum builder builder, uint32_t kinds, uint32_t list_kind) {
    struct cpu_builders cpu;
    const fnl_host *host = gpu_host(harness_device());
    clustered_cpu_init(&cpu.clustered, host);
    light_tree_init(&cpu.tree, host);
    world_grid_init(&cpu.grid, host);
    struct list_lab lab = list_lab_open(&view, entities, COUNT);
    lab.input.kinds = kinds;
    graph_image depth_image = list_lab_depth(&lab, depth);
    graph_image normal_image = list_lab_image(&lab, VK_FORMAT_R16G16B16A16_UNORM, 8, normals);
    list_lab_begin(&lab);
    struct light_list list = add_list(&lab, builder, depth_image, normal_image, &cpu, list_kind);
    uint32_t *rows = walk(&lab, &list, NULL, 0), of_list = builder == FINE ? 1u << list_kind : kinds;
    bool faces = builder == BACKFACE || builder == SPARSE_NORMALS;
    struct counts counts = {0};
    for (uint32_t k = 0; k < WALK_POINTS; k++) {
        const uint32_t *row = rows + (size_t)k * WALK_ROW, count = row[0];
        uint32_t next = 0;
        assert_true(count <= COUNT);
        for (uint32_t i = 0; i < COUNT; i++) {
            uint32_t kind = entities[i].bounds.kind;
            bool visited = next < count && row[1 + next] == i, asked = of_list >> kind & 1;
            next += visited;
            if (visited && !asked && builder != ALL)
                fail_msg("%s for kinds %u gives %u, which is of kind %u", builder_names[builder], of_list, i, kind);
            if (!asked || !holds(i, &points[k])) {
                counts.loose += visited && asked && !sphere_holds(i, &points[k], 1e-3f);
                counts.visited += visited;
                continue;
            }
            if (!visited && !(faces && is_behind(i, &points[k])))
                fail_msg("%s for kinds %u: point %u misses %u, which is of kind %u and shape %u", builder_names[builder], of_list, k,
                         i, kind, entities[i].bounds.shape == GPU_NO_SHAPE ? 0 : entities[i].shape.kind);
            counts.held++;
            counts.visited += visited;
        }
        assert_int_equal(next, count); /* in order, and nothing else */
    }
    free(rows);
    list_lab_close(&lab);
    clustered_cpu_finish(&cpu.clustered);
    light_tree_finish(&cpu.tree);
    world_grid_finish(&cpu.grid, harness_device());
    return counts;
}

void test_kinds(void **state) {
    UNUSED(state);
    struct random_state random = {77};
    make_place(&random);
    uint32_t visited[BUILDERS][GPU_ENTITY_KINDS];
    for (uint32_t builder = 0; builder < BUILDERS; builder++) {
        uint32_t sum = 0, every = 0;
        for (uint32_t kind = 0; kind < GPU_ENTITY_KINDS; kind++) {
            struct counts c = check((enum builder)builder, 1u << kind, kind);
            assert_true(c.held > 1000);
            sum += visited[builder][kind] = c.visited;
            every |= 1u << kind;
            if (builder != FINE) continue;
            /* Where pixels are tested hardly anything is visited in vain: shapes are looked at, each in its place. */
            assert_int_equal(c.loose, 0);
            if (kind != GPU_ENTITY_DECAL) assert_true(c.visited <= c.held + c.held / 50);
        }
        /* Together they are in one list, which is as tight as each alone; the fine builder makes one for each even so. */
        for (uint32_t kind = 0; kind < (builder == FINE ? GPU_ENTITY_KINDS : 1u); kind++) {
            struct counts c = check((enum builder)builder, every, kind);
            bool same_cells = builder != ALL && builder != WORLD && builder != GRID2D; /* grids in the world fit what they hold */
            if (same_cells) assert_int_equal(c.visited, builder == FINE ? visited[builder][kind] : sum);
        }
        print_message("%s: points visit %u lights, %u decals, %u probes\n", builder_names[builder],
                      visited[builder][GPU_ENTITY_LIGHT], visited[builder][GPU_ENTITY_DECAL], visited[builder][PROBE]);
        assert_true(builder == ALL || sum < WALK_POINTS * COUNT / 2);
    }
    /* Lights alone can be behind a surface. */
    static const enum builder facing[][2] = {{BACKFACE, TILED}, {SPARSE_NORMALS, SPARSE}};
    for (int i = 0; i < 2; i++) {
        const uint32_t *some = visited[facing[i][0]], *all = visited[facing[i][1]];
        assert_true(some[GPU_ENTITY_LIGHT] * 4 < all[GPU_ENTITY_LIGHT] * 3);
        assert_true(some[GPU_ENTITY_DECAL] == all[GPU_ENTITY_DECAL] && some[PROBE] == all[PROBE]);
    }
    free(depth);
    free(normals);
}
