/* SPDX-License-Identifier: MIT */
/** Pages of shadow maps against rays from the light through each texel, and what was done to draw them. */
#include "passes/shadow/fill.h"

#include "passes/shadow/fill_reference.h"
#include "tests/vulkan_spy.h"

enum { MOST_ITEMS = 64, MOST_ROWS = 64 };
#define UNTOUCHED 0.25f /* what the atlas holds where nothing was drawn */

struct world {
    fnl_scene *scene;
    struct device_scene_user user;
    struct graph *graph;
    struct gpu_image atlas;
    struct gpu_buffer kept;
    bool has_atlas_contents, all_changed, moved; /* the last two: of the next frame */
    struct triangles triangles;
    struct pages pages;
    uint32_t flags[MOST_PAGES]; /* after the last frame */
    float *texels;              /* of the atlas */
    struct gpu_shadow_counts counts;
    struct gpu_fill_totals totals;
    struct gpu_fill_pair *pairs; /* those of the last frame that were drawn */
    uint32_t pair_count;
};

/* ---- frames ---- */

static void world_open(struct world *w, fnl_scene *scene) {
    *w = (struct world){.scene = scene};
    scene_update_transforms(scene);
    assert_int_equal(device_scene_open(test_device, scene, &w->user), FNL_OK);
    fnl_host host = test_host(&test_device_memory);
    assert_int_equal(graph_create(&host, test_device, &w->graph), FNL_OK);
    const struct gpu_image_params params = {.name = "atlas",
                                            .format = VK_FORMAT_D32_SFLOAT,
                                            .width = SIDE,
                                            .height = SIDE,
                                            .layers = 1,
                                            .mips = 1,
                                            .samples = 1,
                                            .usage = VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT |
                                                     VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT};
    assert_int_equal(gpu_image_create(test_device, &params, &w->atlas), FNL_OK);
}

static void world_close(struct world *w) {
    assert_int_equal(gpu_wait_idle(test_device), FNL_OK);
    gpu_image_destroy(test_device, &w->atlas);
    gpu_buffer_destroy(test_device, &w->kept);
    graph_destroy(&w->graph);
    device_scene_close(&w->user);
    fnl_scene_destroy(&w->scene);
    free(w->triangles.data);
    free(w->texels);
    free(w->pairs);
}

struct read_data {
    graph_buffer from[4], to;
    graph_image atlas;
    uint64_t sizes[4];
};

static void execute_read(const struct graph_context *context, const void *data) {
    const struct read_data *d = data;
    uint64_t at = 0;
    for (int i = 0; i < 4; at += d->sizes[i++])
        gpu_copy_buffer(context->commands, graph_get_buffer(context, d->from[i]), 0, graph_get_buffer(context, d->to), at,
                        d->sizes[i]);
    gpu_copy_image_to_buffer(context->commands, graph_get_image(context, d->atlas), graph_get_buffer(context, d->to), at);
}

static graph_buffer import_with(struct world *w, const char *name, const void *data, uint64_t size, struct gpu_buffer *out) {
    assert_int_equal(gpu_buffer_create(test_device, name, size, GPU_MEMORY_DEVICE, out), FNL_OK);
    assert_int_equal(gpu_upload_buffer(test_device, out, 0, data, size), FNL_OK);
    return graph_import_buffer(w->graph, name, out);
}

/* Draws w->pages and reads everything back. */
static void fill(struct world *w, uint32_t capacity) {
    assert_int_equal(device_scene_prepare(w->user.scene), FNL_OK);
    assert_int_equal(device_rays_prepare(w->user.scene, (struct device_rays_use){.items = true}), FNL_OK);
    assert_int_equal(gpu_frame_begin(test_device), FNL_OK);
    graph_begin(w->graph);
    struct device_scene_frame frame;
    assert_int_equal(device_scene_add(&w->user, w->graph, &frame), FNL_OK);
    if (!w->kept.handle) {
        const uint64_t size = shadow_fill_kept_bytes(w->user.scene->item_count + 2);
        assert_int_equal(gpu_buffer_create(test_device, "kept", size, GPU_MEMORY_DEVICE, &w->kept), FNL_OK);
    }
    struct rays rays = device_rays_add(w->user.scene, w->graph, &frame.geometry, (struct device_rays_use){.items = true});
    struct gpu_shadow_page rows[MOST_PAGES] = {{0}};
    for (uint32_t i = 0; i < w->pages.count; i++) {
        const struct page *p = &w->pages.data[i];
        rows[i] = (struct gpu_shadow_page){.row = p->row,
                                           .bit = page_bit(p),
                                           .place = p->place_x / SHADOW_UNIT | p->place_y / SHADOW_UNIT << 16,
                                           .flags = p->draw ? SHADOW_PAGE_DRAW : 0};
    }
    for (uint32_t i = w->pages.count; i < MOST_PAGES; i++)
        rows[i].flags = SHADOW_PAGE_DRAW; /* what is behind does not count */
    const struct gpu_shadow_counts counts = {.pages = w->pages.count, .pairs = 12345};
    struct gpu_shape shapes[MOST_ROWS] = {{.kind = 0}};
    assert_true(frame.lights.local_count <= MOST_ROWS);
    for (uint32_t i = 0; i < frame.lights.local_count; i++) shapes[i] = w->user.scene->light_data.data[i].shape;
    struct gpu_buffer page_buffer, count_buffer, shape_buffer, read_buffer;
    struct shadow_fill_input input = {.shapes = import_with(w, "shapes", shapes, sizeof shapes, &shape_buffer),
                                      .scene = &frame.geometry,
                                      .rays = &rays,
                                      .pages = import_with(w, "pages", rows, sizeof rows, &page_buffer),
                                      .counts = import_with(w, "counts", &counts, sizeof counts, &count_buffer),
                                      .page_limit = MOST_PAGES,
                                      .kept = &w->kept,
                                      .all_changed = w->all_changed,
                                      .moved = w->moved,
                                      .pair_capacity = capacity};
    assert_int_equal(gpu_upload_flush(test_device), FNL_OK);
    input.atlas = graph_import_image(
        w->graph, &w->atlas, w->has_atlas_contents ? VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL : VK_IMAGE_LAYOUT_UNDEFINED,
        VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
    if (!w->has_atlas_contents) {
        struct graph_pass *pass = graph_add_pass(w->graph, "atlas clear", GRAPH_QUEUE_GRAPHICS, NULL, NULL, 0);
        graph_depth(pass, input.atlas, VK_ATTACHMENT_LOAD_OP_CLEAR, UNTOUCHED);
        w->has_atlas_contents = true;
    }
    const struct shadow_fill out = shadow_fill_add(w->graph, test_device, &input);
    struct read_data read = {
        .from = {input.pages, input.counts, out.totals, out.pairs},
        .atlas = input.atlas,
        .sizes = {sizeof rows, sizeof counts, sizeof(struct gpu_fill_totals), graph_buffer_size(w->graph, out.pairs)}};
    const uint64_t size = read.sizes[0] + read.sizes[1] + read.sizes[2] + read.sizes[3], texel_bytes = SIDE * SIDE * 4ull;
    assert_int_equal(gpu_buffer_create(test_device, "read", size + texel_bytes, GPU_MEMORY_READBACK, &read_buffer), FNL_OK);
    read.to = graph_import_buffer(w->graph, "read", &read_buffer);
    struct graph_pass *pass = graph_add_pass(w->graph, "read", GRAPH_QUEUE_GRAPHICS, execute_read, &read, sizeof read);
    for (int i = 0; i < 4; i++) graph_use_buffer(pass, read.from[i], GRAPH_COPY_FROM);
    graph_use_image(pass, read.atlas, GRAPH_COPY_FROM);
    graph_use_buffer(pass, read.to, GRAPH_COPY_TO);
    pass = graph_add_pass(w->graph, "host", GRAPH_QUEUE_GRAPHICS, NULL, NULL, 0);
    graph_use_buffer(pass, read.to, GRAPH_READ_HOST);
    assert_int_equal(graph_compile(w->graph), FNL_OK);
    assert_int_equal(graph_execute_frame(w->graph, &(struct graph_execute_params){.record_threads = 1, .poison = true}),
                     FNL_OK);
    device_scene_submitted(&w->user);
    assert_int_equal(gpu_frame_wait(test_device, gpu_frame_number(test_device)), FNL_OK);

    const char *bytes = read_buffer.mapped;
    memcpy(rows, bytes, sizeof rows);
    for (uint32_t i = 0; i < MOST_PAGES; i++) w->flags[i] = rows[i].flags;
    memcpy(&w->counts, bytes + read.sizes[0], sizeof w->counts);
    memcpy(&w->totals, bytes + read.sizes[0] + read.sizes[1], sizeof w->totals);
    w->pair_count = (uint32_t)(read.sizes[3] / sizeof *w->pairs);
    w->pairs = realloc(w->pairs, read.sizes[3]);
    memcpy(w->pairs, bytes + size - read.sizes[3], read.sizes[3]);
    if (!w->texels) w->texels = malloc(texel_bytes);
    memcpy(w->texels, bytes + size, texel_bytes);
    gpu_buffer_destroy(test_device, &page_buffer);
    gpu_buffer_destroy(test_device, &count_buffer);
    gpu_buffer_destroy(test_device, &shape_buffer);
    gpu_buffer_destroy(test_device, &read_buffer);
    triangles_gather(&w->triangles, w->user.scene);
}

static float texel(const struct world *w, const struct page *p, uint32_t x, uint32_t y) {
    return w->texels[(size_t)(p->place_y + y) * SIDE + p->place_x + x];
}

/* ---- scenes ---- */

/* A box, or two opposite sides of it, which has the same bounds. */
static uint32_t box_mesh(fnl_scene *scene, uint32_t material, bool sides) {
    static vec3 positions[8];
    static const uint32_t indices[36] = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                         2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
    for (uint32_t i = 0; i < 8; i++) positions[i] = (vec3){i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1};
    struct scene_primitive p = {
        .material = material, .vertex_count = 8, .index_count = sides ? 12 : 36, .indices = indices, .positions = positions};
    assert_int_equal(mesh_complete(&scene->arena, &p), FNL_OK);
    return scene_add_mesh(scene, "", &p, 1);
}

/* A square in which alpha rises from left to right. */
static uint32_t sheet_mesh(fnl_scene *scene, fnl_alpha_mode mode, enum scene_topology topology,
                           const struct scene_morph_target *morph) {
    static const vec3 positions[4] = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
    static const vec4 colors[4] = {{1, 1, 1, 0}, {1, 1, 1, 1}, {1, 1, 1, 1}, {1, 1, 1, 0}};
    static const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
    static const float weight = 0.75f;
    struct scene_material material = scene_material_default();
    material.alpha_mode = mode;
    material.alpha_cutoff = 0.375f;
    material.base_color.w = 0.9f;
    struct scene_primitive p = {.material = scene_add_material(scene, &material),
                                .topology = topology,
                                .vertex_count = 4,
                                .index_count = 6,
                                .indices = indices,
                                .positions = positions,
                                .colors = mode == FNL_ALPHA_OPAQUE ? NULL : colors,
                                .morph_targets = morph,
                                .morph_target_count = morph ? 1 : 0};
    assert_int_equal(mesh_complete(&scene->arena, &p), FNL_OK);
    uint32_t mesh = scene_add_mesh(scene, "", &p, 1);
    if (morph) {
        scene->meshes.data[mesh].morph_target_count = 1;
        scene->meshes.data[mesh].morph_weights = &weight;
    }
    return mesh;
}

static void put(fnl_scene *scene, uint32_t mesh, vec3 position, vec3 axis, float angle, vec3 scale) {
    mat4 matrix = mat4_from_trs(position, quat_axis_angle(vec3_normalize(axis), angle), scale);
    scene_add_node(scene, "", SCENE_NONE, &matrix, mesh);
}

/* Boxes round the origin at all angles, some mirrored and some flattened, none within 1.2 metres. */
static void put_boxes(fnl_scene *scene, uint32_t count, uint64_t seed) {
    struct random_state random = {seed};
    const uint32_t mesh = box_mesh(scene, SCENE_NONE, false);
    for (uint32_t i = 0; i < count; i++) {
        vec3 way =
            vec3_normalize((vec3){random_range(&random, -1, 1), random_range(&random, -1, 1), random_range(&random, -1, 1)});
        const float size = random_range(&random, 0.1f, 0.5f), flat = i % 5 == 4 ? 0 : random_range(&random, 0.3f, 1);
        put(scene, mesh, vec3_scale(way, random_range(&random, 2.2f, 9)),
            (vec3){random_range(&random, -1, 1), random_range(&random, -1, 1), random_range(&random, -1, 1)},
            random_range(&random, 0, 6), (vec3){i % 3 ? size : -size, size * 1.5f, size * flat});
    }
}

static fnl_light_id put_light(fnl_scene *scene, fnl_light_kind kind, vec3 position) {
    fnl_light_params p = fnl_light_params_default();
    fnl_light_id id;
    p.kind = kind;
    p.position = position;
    p.range = 8;
    p.direction = vec3_normalize((vec3){0.6f, -0.5f, 0.4f});
    p.box_size = (vec3){5, 4, 6};
    assert_int_equal(fnl_scene_add_light(scene, &p, &id), FNL_OK);
    return id;
}

static fnl_scene *crowded_scene(void) {
    static const vec3 moved[4] = {{0, 0, 4}, {0, 0, 4}, {0.5f, 0, 4}, {0, 0, 4}};
    static const struct scene_morph_target morph = {.positions = moved};
    fnl_scene *scene = test_scene();
    put_boxes(scene, 40, 5);
    put(scene, sheet_mesh(scene, FNL_ALPHA_MASK, SCENE_TOPOLOGY_TRIANGLES, NULL), (vec3){1.5f, 0.2f, 0.3f},
        (vec3){0, 1, 0.2f}, 1.4f, (vec3){1, 1, 1});
    put(scene, sheet_mesh(scene, FNL_ALPHA_BLEND, SCENE_TOPOLOGY_TRIANGLES, NULL), (vec3){0, 1.2f, 0}, (vec3){1, 0, 0}, 1.5f,
        (vec3){2, 2, 2});
    put(scene, sheet_mesh(scene, FNL_ALPHA_OPAQUE, SCENE_TOPOLOGY_LINES, NULL), (vec3){0, 0, 1.2f}, (vec3){1, 0, 0}, 0.1f,
        (vec3){1, 1, 1});
    put(scene, sheet_mesh(scene, FNL_ALPHA_OPAQUE, SCENE_TOPOLOGY_TRIANGLES, &morph), (vec3){0.3f, -0.6f, -6},
        (vec3){0, 0, 1}, 0.3f, (vec3){1, 1, 1});
    /* A floor that all faces but the upper one see, and a square through the near end of the first light's faces. */
    put(scene, test_quad_mesh(scene, SCENE_NONE), (vec3){0.5f, -2.5f, 0}, (vec3){1, 0.1f, 0}, -1.5f, (vec3){40, 40, 1});
    put(scene, test_quad_mesh(scene, SCENE_NONE), (vec3){-1.2e-4f, 0, 0}, (vec3){0, 1, 0}, 1.2f, (vec3){4e-4f, 3e-4f, 1});
    put_light(scene, FNL_LIGHT_DIRECTIONAL, (vec3){0, 0, 0});
    put_light(scene, FNL_LIGHT_POINT, (vec3){0, 0, 0});
    put_light(scene, FNL_LIGHT_SPOT, (vec3){0.2f, 0.7f, -0.4f});
    put_light(scene, FNL_LIGHT_WEDGE, (vec3){-0.6f, 0.1f, 0.3f});
    put_light(scene, FNL_LIGHT_BOX, (vec3){0.5f, 0.5f, 0.5f});
    return scene;
}

/* For each light a page of each face, and some of all levels. */
static void spread_pages(struct world *w, uint32_t rows, uint32_t more) {
    struct random_state random = {77};
    w->pages.count = w->pages.cell = w->pages.used = 0;
    for (uint32_t row = 0; row < rows; row++) {
        const uint32_t faces = w->user.scene->light_data.data[row].shape.kind == GPU_SHAPE_BOX ? 1 : 6;
        for (uint32_t face = 0; face < faces; face++)
            pages_put(&w->pages, (struct page){.row = row, .face = face, .level = 4, .draw = true});
        for (uint32_t i = 0; i < more; i++) {
            struct page p = {
                .row = row, .face = (uint32_t)random_bits(&random) % faces, .level = i % SHADOW_LEVELS, .draw = true};
            p.x = (uint32_t)random_bits(&random) % page_side(p.level);
            p.y = (uint32_t)random_bits(&random) % page_side(p.level);
            pages_put(&w->pages, p);
        }
    }
}

/* ---- tests ---- */

struct found {
    uint32_t texels, covered, edges, beyond, pairs;
};

/* Compares each texel of a page with rays through it and through four points beside it: what is drawn may be off by so much of a texel. */
static void check_page(const struct world *w, uint32_t index, struct found *found) {
    static const double beside[5][2] = {
        {0, 0}, {1. / 64, 1. / 64}, {-1. / 64, 1. / 64}, {1. / 64, -1. / 64}, {-1. / 64, -1. / 64}};
    const struct page *p = &w->pages.data[index];
    const struct face f = face_of(&w->user.scene->light_data.data[p->row].shape, p->face);
    uint32_t items;
    struct triangles shown = triangles_of_page(&w->triangles, p, &f, &items);
    found->pairs += items;
    for (uint32_t y = 0; y < page_size(p); y++)
        for (uint32_t x = 0; x < page_size(p); x++) {
            double low = INFINITY, high = 0, at[2];
            struct hit hits[5];
            bool is_edge = false, is_beyond = false;
            for (int k = 0; k < 5; k++) {
                texel_on_face(p, x + 0.5 + beside[k][0], y + 0.5 + beside[k][1], at);
                hits[k] = hit_nearest(&shown, &f, at);
                low = fmin(low, hits[k].depth);
                high = fmax(high, hits[k].depth);
                is_edge |= hits[k].item != hits[0].item;
                is_beyond |= hits[k].is_beyond;
            }
            if (is_beyond) low = 0; /* it need not be drawn */
            const double seen = texel(w, p, x, y),
                         tolerance = is_edge ? 1e-2 : 1e-5; /* edges of what is seen from its side */
            const double steep = is_edge ? 0 : (high - low) / 4; /* of planes seen from their side */
            if (!(seen >= low * (1 - tolerance) - steep && seen <= high * (1 + tolerance) + steep))
                fail_msg("page %u (row %u, face %u, level %u, %u %u), texel %u %u: %.9g, should be %.9g .. %.9g (item %u)",
                         index, p->row, p->face, p->level, p->x, p->y, x, y, seen, low, high, hits[0].item);
            found->texels++;
            found->covered += hits[0].depth > 0;
            found->edges += is_edge;
            found->beyond += is_beyond;
        }
    free(shown.data);
}

static struct found check_pages(const struct world *w) {
    struct found found = {0};
    for (uint32_t i = 0; i < w->pages.count; i++) check_page(w, i, &found);
    print_message("%u texels of %u pages: %u covered, %u at edges, %u beyond the range; %u pairs, where %u items may touch "
                  "pages; %u in all\n",
                  found.texels, w->pages.count, found.covered, found.edges, found.beyond, w->counts.pairs, found.pairs,
                  w->user.scene->item_count * w->pages.count);
    return found;
}

/* Outside of pages, and in those that were not to be drawn, the atlas is as it was. */
static void check_untouched(const struct world *w, const float *before) {
    bool *drawn = calloc(SIDE * SIDE, sizeof *drawn);
    for (uint32_t i = 0; i < w->pages.count; i++) {
        const struct page *p = &w->pages.data[i];
        for (uint32_t y = 0; p->draw && y < page_size(p); y++)
            memset(drawn + (size_t)(p->place_y + y) * SIDE + p->place_x, true, page_size(p));
    }
    for (uint32_t i = 0; i < SIDE * SIDE; i++)
        if (!drawn[i] && w->texels[i] != (before ? before[i] : UNTOUCHED))
            fail_msg("texel %u %u has changed", i % SIDE, i / SIDE);
    free(drawn);
}

/* The pairs are those of what was drawn: by group, each once, where no item is in clusters. */
static void check_pairs(const struct world *w) {
    const struct device_scene *d = w->user.scene;
    uint32_t drawn = 0, group = 0;
    bool *seen = calloc(w->user.scene->item_count * MOST_PAGES + 1, sizeof *seen);
    assert_true(w->counts.pairs <= w->pair_count);
    for (uint32_t i = 0; i < w->counts.pairs; i++) {
        const struct gpu_fill_pair *p = &w->pairs[i];
        assert_true(p->item < d->item_count && p->page < w->pages.count && w->pages.data[p->page].draw);
        while (group < d->group_list.count && p->item - d->group_list.data[group].first >= d->group_list.data[group].count) group++;
        assert_true(group < d->group_list.count);
        bool *place = &seen[p->item * MOST_PAGES + p->page];
        assert_false(*place);
        *place = true;
    }
    for (uint32_t i = 0; i < MOST_PAGES; i++) {
        assert_int_equal(w->flags[i] & SHADOW_PAGE_DRAW, i < w->pages.count ? 0 : SHADOW_PAGE_DRAW);
        drawn += i < w->pages.count && w->pages.data[i].draw;
    }
    assert_int_equal(w->totals.clear.instance_count, drawn);
    free(seen);
}

/*
 * Points, cones, wedges and boxes of light among boxes at all angles, mirrored and flat ones, a cutout, what casts nothing, what deforms, a floor
 * that crosses faces, and a square through the near end of the faces.
 */
static void test_pages_show_what_rays_find(void **state) {
    UNUSED(state);
    static struct world w;
    world_open(&w, crowded_scene());
    fill(&w, 1 << 16); /* no pages; the lights come to the device */
    assert_null(w.user.scene->ray_meshes.handle); /* pages need no tree over triangles */
    check_pairs(&w);
    check_untouched(&w, NULL);
    assert_int_equal(w.counts.pairs, 0);
    assert_int_equal(w.totals.draw_counts[0] + w.totals.draw_counts[1], 0);
    spread_pages(&w, 4, 10);
    fill(&w, 1 << 16);
    const struct found found = check_pages(&w);
    assert_true(found.covered > found.texels / 4 && found.edges < found.texels / 500 && found.beyond < found.texels / 10);
    /* Culling sees boxes, the reference planes and triangles; both keep a little too much. */
    assert_true(w.counts.pairs <= found.pairs && w.counts.pairs > found.pairs / 2);
    check_pairs(&w);
    check_untouched(&w, NULL);
    world_close(&w);
}

/* Whether some of the points on a grid over a page sees a triangle in the light's range; the grid reaches the page's edges. */
static bool page_sees(const struct world *w, const struct page *p) {
    const struct face f = face_of(&w->user.scene->light_data.data[p->row].shape, p->face);
    enum { STEPS = 33 };
    for (uint32_t i = 0; i < STEPS * STEPS; i++) {
        double at[2];
        texel_on_face(p, i % STEPS * (double)page_size(p) / (STEPS - 1), i / STEPS * (double)page_size(p) / (STEPS - 1), at);
        const struct hit hit = hit_nearest(&w->triangles, &f, at);
        if (hit.depth > 0 && !hit.is_beyond) return true;
    }
    return false;
}

/* Every page of a level, one item: what is listed is what the page sees, but for one at most, for a wide slanted square and for a box near the end of the range. */
static void test_pages_list_what_they_see(void **state) {
    UNUSED(state);
    for (uint32_t k = 0; k < 2; k++) {
        static struct world w;
        fnl_scene *scene = test_scene();
        if (k == 0)
            put(scene, test_quad_mesh(scene, SCENE_NONE), (vec3){-1, -1.5f, 1.2f}, (vec3){1, 0.4f, 0.3f}, 0.8f,
                (vec3){6, 5, 1});
        else
            put(scene, box_mesh(scene, SCENE_NONE, false), (vec3){5.3f, 5.2f, 5.1f}, (vec3){1, 0, 0}, 0.3f,
                (vec3){0.2f, 0.2f, 0.2f});
        put_light(scene, FNL_LIGHT_POINT, (vec3){0, 0, 0});
        world_open(&w, scene);
        fill(&w, 0);
        w.pages = (struct pages){0};
        for (uint32_t i = 0; i < 6 * 4; i++)
            pages_put(&w.pages, (struct page){.face = i / 4, .level = 3, .x = i % 2, .y = i / 2 % 2, .draw = true});
        fill(&w, 1 << 10);
        uint32_t seen = 0;
        for (uint32_t i = 0; i < w.pages.count; i++) seen += page_sees(&w, &w.pages.data[i]);
        print_message("%u of %u pages see it; %u list it\n", seen, w.pages.count, w.counts.pairs);
        assert_true(w.counts.pairs >= seen && w.counts.pairs <= seen + 1); /* some that pass by an edge of the square stay */
        assert_true(k == 0 ? seen > 3 && seen < w.pages.count - 3 : seen == 0);
        world_close(&w);
    }
}

/* A wavy square of many triangles, across x and y. */
static uint32_t wave_mesh(fnl_scene *scene) {
    enum { ACROSS = 32, POINTS = ACROSS + 1 };
    static vec3 positions[POINTS * POINTS];
    static uint32_t indices[ACROSS * ACROSS * 6];
    for (uint32_t i = 0; i < POINTS * POINTS; i++) {
        const float x = (float)(i % POINTS) * (2.f / ACROSS) - 1, y = (float)(i / POINTS) * (2.f / ACROSS) - 1;
        positions[i] = (vec3){x, y, 0.1f * sinf(7 * x) * cosf(5 * y)};
    }
    for (uint32_t i = 0; i < ACROSS * ACROSS; i++) {
        const uint32_t first = i / ACROSS * POINTS + i % ACROSS, corners[6] = {0, 1, POINTS, POINTS, 1, POINTS + 1};
        for (uint32_t k = 0; k < 6; k++) indices[i * 6 + k] = first + corners[k];
    }
    struct scene_primitive p = {.material = SCENE_NONE,
                                .vertex_count = POINTS * POINTS,
                                .index_count = COUNT_OF(indices),
                                .indices = indices,
                                .positions = positions};
    assert_int_equal(mesh_complete(&scene->arena, &p), FNL_OK);
    return scene_add_mesh(scene, "", &p, 1);
}

/*
 * Of a large mesh a page draws the clusters that it shows, and what it shows as a whole it draws at once: a wide floor that is turned, stretched
 * and mirrored, and the same mesh, small, in one page of the finest of these levels.
 */
static void test_pages_draw_clusters_SH_69(void **state) {
    UNUSED(state);
    static struct world w;
    fnl_scene *scene = test_scene();
    const uint32_t mesh = wave_mesh(scene);
    put(scene, mesh, (vec3){0.4f, -1.6f, -0.3f}, (vec3){1, 0.2f, 0.1f}, -1.4f, (vec3){-6, 4, 2});
    put(scene, mesh, (vec3){0.6f, 1.9f, 0.55f}, (vec3){1, 0, 0}, -1.6f, (vec3){0.1f, 0.1f, 0.1f});
    put_light(scene, FNL_LIGHT_POINT, (vec3){0, 0, 0});
    world_open(&w, scene);
    fill(&w, 0);
    const struct device_scene *d = w.user.scene;
    const uint32_t large = d->item_nodes.data[0] == 0 ? 0 : 1, mesh_triangles = w.triangles.count / 2;
    for (uint32_t level = 2; level <= 4; level += 2) {
        const uint32_t across = page_side(level);
        w.pages = (struct pages){0};
        for (uint32_t face = 2; face < 4; face++) /* up and down */
            for (uint32_t i = 0; i < across * across; i++)
                pages_put(&w.pages, (struct page){.face = face, .level = level, .x = i % across, .y = i / across, .draw = true});
        w.all_changed = true;
        fill(&w, 1 << 16);
        uint32_t may_show = 0, whole = 0, of_small[MOST_PAGES] = {0}, large_pages = 0;
        bool shows_large[MOST_PAGES] = {false};
        for (uint32_t i = 0; i < w.pages.count; i++) {
            const struct page *p = &w.pages.data[i];
            const struct face f = face_of(&d->light_data.data[p->row].shape, p->face);
            uint32_t items;
            struct triangles shown = triangles_of_page(&w.triangles, p, &f, &items);
            may_show += shown.count;
            free(shown.data);
        }
        for (uint32_t i = 0; i < w.counts.pairs; i++)
            if (w.pairs[i].item == large) shows_large[w.pairs[i].page] = true;
            else of_small[w.pairs[i].page]++;
        for (uint32_t i = 0; i < w.pages.count; i++) {
            large_pages += shows_large[i];
            whole += of_small[i] == 1;
        }
        print_message("level %u: %u triangles in %u pairs; %u may show, %u pages show the floor of %u triangles\n", level,
                      w.totals.triangles, w.counts.pairs, may_show, large_pages, mesh_triangles);
        assert_true(whole == 1); /* it lies within a page of each level: one pair draws it */
        assert_true(large_pages > across * across / 2);
        assert_true(w.totals.triangles >= may_show && w.totals.triangles <= may_show * 3);
        if (level == 2) assert_true(w.totals.triangles < large_pages * mesh_triangles / 3);
        struct found found = {0};
        for (uint32_t i = 0; i < w.pages.count; i += level == 2 ? 3 : 1) check_page(&w, i, &found);
        assert_true(found.covered > found.texels / 50);
        for (uint32_t only = 0; only < w.pages.count; only++) { /* with room for whole items alone no page waits for ever */
            for (uint32_t i = 0; i < w.pages.count; i++) w.pages.data[i].draw = i == only;
            w.all_changed = false;
            fill(&w, 0);
            assert_true(w.counts.pairs <= d->item_count);
            assert_int_equal(w.flags[only] & SHADOW_PAGE_DRAW, 0);
        }
    }
    world_close(&w);
}

/* Below a node of the tree that a page does not touch nothing is looked at: with the root's box spoiled nothing is found. */
static void test_culling_stops_at_nodes(void **state) {
    UNUSED(state);
    static struct world w;
    struct gpu_ray_node spoiled;
    world_open(&w, crowded_scene());
    fill(&w, 1 << 16);
    spread_pages(&w, 2, 0);
    fill(&w, 1 << 16);
    assert_true(w.counts.pairs > 40);
    assert_int_equal(gpu_read_buffer(test_device, &w.user.scene->ray_items, 0, &spoiled, sizeof spoiled), FNL_OK);
    spoiled.low = spoiled.high = (vec3){1e6f, 1e6f, 1e6f};
    assert_int_equal(gpu_upload_buffer(test_device, &w.user.scene->ray_items, 0, &spoiled, sizeof spoiled), FNL_OK);
    assert_int_equal(gpu_upload_flush(test_device), FNL_OK);
    fill(&w, 1 << 16);
    assert_int_equal(w.counts.pairs, 0);
    world_close(&w);
}

/* Half of the pages are drawn, then something moves and the others are: each half is as it was in its frame. */
static void test_other_pages_keep_their_texels(void **state) {
    UNUSED(state);
    static struct world w;
    world_open(&w, crowded_scene());
    fill(&w, 1 << 16);
    spread_pages(&w, 3, 3);
    for (uint32_t i = 0; i < w.pages.count; i++) w.pages.data[i].draw = i % 2;
    fill(&w, 1 << 16);
    check_untouched(&w, NULL);
    check_pairs(&w);
    float *before = malloc(SIDE * SIDE * sizeof *before);
    memcpy(before, w.texels, SIDE * SIDE * sizeof *before);
    for (uint32_t i = 0; i < 40; i++) {
        const mat4 moved = mat4_from_trs((vec3){(float)i * 0.2f - 4, 2, 0}, quat_identity(), (vec3){0.1f, 0.2f, 0.1f});
        scene_move_nodes(w.scene, &(fnl_instance_id){.index = i}, &moved, 1);
    }
    for (uint32_t i = 0; i < w.pages.count; i++) w.pages.data[i].draw = !w.pages.data[i].draw;
    fill(&w, 1 << 16);
    check_untouched(&w, before);
    check_pairs(&w);
    struct found found = {0};
    for (uint32_t i = 0; i < w.pages.count; i += 2) check_page(&w, i, &found);
    free(before);
    world_close(&w);
}

/* Every page is drawn; says which of them show each item. */
static void draw_all(struct world *w, bool (*shown)[MOST_PAGES]) {
    w->all_changed = true;
    fill(w, 1 << 16);
    w->all_changed = false;
    assert_int_equal(w->counts.drawn, w->pages.count);
    assert_int_equal(w->totals.clear.instance_count, w->pages.count);
    memset(shown, 0, MOST_ITEMS * sizeof *shown);
    for (uint32_t i = 0; i < w->counts.pairs; i++) shown[w->pairs[i].item][w->pairs[i].page] = true;
}

static uint32_t item_of(const struct world *w, uint32_t node) {
    for (uint32_t i = 0; i < w->user.scene->item_count; i++)
        if (w->user.scene->item_nodes.data[i] == node) return i;
    fail_msg("node %u is not drawn", node);
    return 0;
}

static void move(struct world *w, uint32_t node, vec3 by) {
    mat4 moved = scene_node_local(w->scene, &w->scene->nodes.data[node]);
    moved.m[12] += by.x, moved.m[13] += by.y, moved.m[14] += by.z;
    scene_move_nodes(w->scene, &(fnl_instance_id){.index = node}, &moved, 1);
}

/* One of many moves: those pages are drawn that show it where it was or where it is, and what deforms; then all are as if all had been drawn. */
static void test_only_what_changed_is_drawn(void **state) {
    UNUSED(state);
    enum { CUTOUT = 40, BLENDED, LINES, DEFORMS };
    static const uint32_t nodes[] = {3, 4, 17, CUTOUT, BLENDED, LINES, DEFORMS};
    static bool before[MOST_ITEMS][MOST_PAGES], after[MOST_ITEMS][MOST_PAGES];
    static struct world w;
    world_open(&w, crowded_scene());
    fill(&w, 1 << 16);
    spread_pages(&w, 4, 10);
    for (uint32_t i = 0; i < w.pages.count; i++) w.pages.data[i].draw = false;
    draw_all(&w, before);
    fill(&w, 1 << 16);
    assert_int_equal(w.counts.drawn + w.counts.pairs + w.totals.clear.instance_count + w.totals.draw_counts[0], 0);
    float *texels = malloc(SIDE * SIDE * sizeof *texels);
    uint32_t most = 0;
    for (uint32_t k = 0; k < COUNT_OF(nodes); k++) {
        const uint32_t item = item_of(&w, nodes[k]), deforms = item_of(&w, DEFORMS);
        memcpy(texels, w.texels, SIDE * SIDE * sizeof *texels);
        move(&w, nodes[k], (vec3){0.4f, 0.7f, -0.3f});
        w.moved = true;
        fill(&w, 1 << 16);
        w.moved = false;
        const uint32_t drawn = w.counts.drawn, pairs = w.counts.pairs;
        assert_int_equal(w.totals.clear.instance_count, drawn);
        float *once = malloc(SIDE * SIDE * sizeof *once);
        memcpy(once, w.texels, SIDE * SIDE * sizeof *once);
        draw_all(&w, after);
        assert_memory_equal(once, w.texels, SIDE * SIDE * sizeof *once);
        uint32_t expected = 0, expected_pairs = 0;
        for (uint32_t i = 0; i < w.pages.count; i++) {
            const bool draws = before[item][i] || after[item][i] || before[deforms][i] || after[deforms][i];
            expected += draws;
            for (uint32_t other = 0; other < w.user.scene->item_count; other++) expected_pairs += draws && after[other][i];
            w.pages.data[i].draw = draws;
        }
        check_untouched(&w, texels);
        for (uint32_t i = 0; i < w.pages.count; i++) w.pages.data[i].draw = false;
        print_message("node %u: %u pages and %u pairs are drawn, should be %u and %u of %u\n", nodes[k], drawn, pairs,
                      expected, expected_pairs, w.pages.count);
        assert_int_equal(drawn, expected);
        assert_int_equal(pairs, expected_pairs);
        most = MAX(most, drawn);
        memcpy(before, after, sizeof before);
        free(once);
    }
    assert_true(most < w.pages.count * 2 / 3);
    free(texels);
    world_close(&w);
}

static void show(struct world *w, uint32_t node, bool shown) {
    const fnl_instance_id id = {.index = node, .generation = w->scene->nodes.data[node].generation};
    assert_int_equal(fnl_scene_set_instance_visible(w->scene, id, shown), FNL_OK);
}

/*
 * What comes or goes changes numbers of items, and the last of them; and one takes the place of another with the same bounds. No page is left that
 * shows what was, and none is drawn in the frame that follows.
 */
static void test_items_come_and_go(void **state) {
    UNUSED(state);
    enum { BOXES = 6, SIDES = BOXES, LAST = 3 }; /* of the items: mirrored ones are behind the others */
    static const struct {
        uint32_t hide, show;
    } steps[] = {{SIDES, SCENE_NONE}, {2, SCENE_NONE},         {SCENE_NONE, 2},    {BOXES - 1, SIDES},
                 {SIDES, SCENE_NONE}, {SCENE_NONE, BOXES - 1}, {LAST, SCENE_NONE}, {SCENE_NONE, LAST}};
    static bool shown[MOST_ITEMS][MOST_PAGES];
    static struct world w;
    fnl_scene *scene = test_scene();
    put_boxes(scene, BOXES, 12);
    const mat4 matrix = scene_node_local(scene, &scene->nodes.data[BOXES - 1]);
    scene_add_node(scene, "", SCENE_NONE, &matrix, box_mesh(scene, SCENE_NONE, true));
    put_light(scene, FNL_LIGHT_POINT, (vec3){0, 0, 0});
    world_open(&w, scene);
    fill(&w, 1 << 10);
    spread_pages(&w, 1, 40);
    for (uint32_t i = 0; i < w.pages.count; i++) w.pages.data[i].draw = false;
    draw_all(&w, shown);
    float *once = malloc(SIDE * SIDE * sizeof *once);
    w.moved = true;
    for (uint32_t k = 0; k < COUNT_OF(steps); k++) {
        if (steps[k].hide != SCENE_NONE) show(&w, steps[k].hide, false);
        if (steps[k].show != SCENE_NONE) show(&w, steps[k].show, true);
        fill(&w, 1 << 10);
        print_message("%u of %u pages are drawn\n", w.counts.drawn, w.pages.count);
        assert_true(w.counts.drawn > 0 && w.counts.drawn < w.pages.count);
        memcpy(once, w.texels, SIDE * SIDE * sizeof *once);
        fill(&w, 1 << 10);
        assert_int_equal(w.counts.drawn, 0);
        draw_all(&w, shown);
        assert_memory_equal(once, w.texels, SIDE * SIDE * sizeof *once);
    }
    free(once);
    world_close(&w);
}

/* With room for a part of the pairs, some pages wait with their flag and their texels; in the end all are as if they had been drawn at once. */
static void test_what_does_not_fit_waits(void **state) {
    UNUSED(state);
    static struct world w;
    world_open(&w, crowded_scene());
    fill(&w, 1 << 16);
    spread_pages(&w, 2, 4);
    fill(&w, 1 << 16);
    const uint32_t all = w.counts.pairs, items = w.user.scene->item_count;
    float *expected = malloc(SIDE * SIDE * sizeof *expected), *before = malloc(SIDE * SIDE * sizeof *before);
    memcpy(expected, w.texels, SIDE * SIDE * sizeof *expected);
    assert_true(all > 2 * items);
    w.has_atlas_contents = false;
    uint32_t frames = 0, left = w.pages.count;
    for (uint32_t i = 0; i < SIDE * SIDE; i++) before[i] = UNTOUCHED;
    for (; left > 0; frames++) {
        uint32_t waiting = 0;
        fill(&w, 1); /* as many as there are items */
        if (frames == 0) assert_int_equal(w.counts.pairs, all);
        assert_int_equal(w.pair_count, items);
        for (uint32_t i = 0; i < w.pages.count; i++) {
            struct page *p = &w.pages.data[i];
            const bool waits = w.flags[i] & SHADOW_PAGE_DRAW;
            assert_true(p->draw || !waits);
            waiting += waits;
            p->draw = p->draw && !waits; /* those that were drawn */
        }
        check_untouched(&w, before);
        assert_true(waiting < left);
        left = waiting;
        memcpy(before, w.texels, SIDE * SIDE * sizeof *before);
        for (uint32_t i = 0; i < w.pages.count; i++) w.pages.data[i].draw = w.flags[i] & SHADOW_PAGE_DRAW;
    }
    assert_true(frames > 2 && frames <= DIVIDE_UP(all, items) * 2);
    assert_memory_equal(w.texels, expected, SIDE * SIDE * sizeof *expected);
    free(expected);
    free(before);
    world_close(&w);
}

/* Draw calls are the same whatever there is; draws are those groups that some page shows. */
static void test_draw_calls_do_not_depend_on_pages(void **state) {
    UNUSED(state);
    static struct world w;
    spy_begin(test_device);
    world_open(&w, crowded_scene());
    const uint32_t counts[3] = {0, 1, 4};
    for (uint32_t k = 0; k < COUNT_OF(counts); k++) {
        uint32_t groups = 0;
        if (k) spread_pages(&w, counts[k], counts[k]);
        spy_clear();
        fill(&w, 1 << 16);
        assert_int_equal(spy_count_work("shadow fill"), 3);
        const struct device_scene *d = w.user.scene;
        for (uint32_t g = 0; g < d->group_list.count; g++) {
            bool is_drawn = false;
            for (uint32_t i = 0; i < w.counts.pairs; i++)
                is_drawn |= w.pairs[i].item - d->group_list.data[g].first < d->group_list.data[g].count;
            groups += is_drawn;
        }
        assert_int_equal(w.totals.draw_counts[0] + w.totals.draw_counts[1], groups);
        assert_int_equal(w.totals.draw_counts[1], k > 0);
        assert_true(k == 0 || groups > 2);
    }
    world_close(&w);
    spy_end();
}

/* Pages of what is empty, and of one item, which is a tree without nodes. */
static void test_least_scenes(void **state) {
    UNUSED(state);
    for (uint32_t count = 0; count < 2; count++) {
        static struct world w;
        fnl_scene *scene = test_scene();
        if (count)
            put(scene, box_mesh(scene, SCENE_NONE, false), (vec3){0.1f, 0.3f, 2}, (vec3){1, 1, 0}, 0.5f,
                (vec3){-0.5f, 0.6f, 0.7f});
        put_light(scene, FNL_LIGHT_POINT, (vec3){0, 0, 0});
        world_open(&w, scene);
        fill(&w, 0);
        spread_pages(&w, 1, 4);
        fill(&w, 0);
        if (!count) assert_int_equal(w.counts.pairs, 0);
        check_pages(&w);
        check_untouched(&w, NULL);
        world_close(&w);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_pages_show_what_rays_find),
        cmocka_unit_test(test_pages_list_what_they_see),
        cmocka_unit_test(test_pages_draw_clusters_SH_69),
        cmocka_unit_test(test_culling_stops_at_nodes),
        cmocka_unit_test(test_other_pages_keep_their_texels),
        cmocka_unit_test(test_only_what_changed_is_drawn),
        cmocka_unit_test(test_items_come_and_go),
        cmocka_unit_test(test_what_does_not_fit_waits),
        cmocka_unit_test_teardown(test_draw_calls_do_not_depend_on_pages, spy_tear_down),
        cmocka_unit_test(test_least_scenes),
    };
    return cmocka_run_group_tests_name("fill", tests, test_group_begin, test_group_end);
}
