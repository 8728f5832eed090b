/* SPDX-License-Identifier: MIT */
/** Virtual texturing: places and frames there and back, levels of detail, residency, an atlas that is too small. */
#include "passes/texturing/virtual.h"
#include "graph/graph_internal.h"
#include "passes/texturing/virtual_test_shared.h"
#include "shaders.h"
#include "tests/render_harness.h"

/* ---- places in the atlas, and tangent frames ---- */

enum { SIDE = 64, CASES = 4096 };

static struct gpu_virtual_case cases[CASES];
static struct gpu_virtual_result results[CASES];
static struct gpu_virtual_page pages[SIDE * SIDE];

struct ask {
    struct gpu_virtual_test_push push;
};

static void execute_ask(const struct graph_context *context, const void *data) {
    const struct ask *ask = data;
    struct gpu_compute_params params = {.shader = &shader_virtual_test_comp};
    gpu_bind(context->commands, gpu_compute_pipeline(context->device, &params));
    gpu_push(context->commands, &ask->push, sizeof ask->push);
    gpu_dispatch_linear(context->commands, CASES / 64);
}

static void execute_nothing(const struct graph_context *context, const void *data) {
    UNUSED(context);
    UNUSED(data);
}

static void ask_device(struct virtual_atlas *atlas) {
    gpu_device *device = harness_device();
    struct graph *graph;
    struct gpu_buffer buffers[2];
    assert_int_equal(graph_create(gpu_host(device), device, &graph), FNL_OK);
    assert_int_equal(gpu_buffer_create(device, "cases", sizeof cases, GPU_MEMORY_UPLOAD, &buffers[0]), FNL_OK);
    assert_int_equal(gpu_buffer_create(device, "results", sizeof results, GPU_MEMORY_READBACK, &buffers[1]), FNL_OK);
    memcpy(buffers[0].mapped, cases, sizeof cases);
    graph_begin(graph);
    assert_int_equal(gpu_frame_begin(device), FNL_OK);
    struct virtual_frame frame = virtual_begin(graph, device, atlas, 0);
    struct ask ask = {{.pages = frame.address, .cases = buffers[0].address, .results = buffers[1].address, .count = CASES}};
    graph_buffer in = graph_import_buffer(graph, "cases", &buffers[0]),
                 out = graph_import_buffer(graph, "results", &buffers[1]);
    struct graph_pass *pass = graph_add_pass(graph, "ask", GRAPH_QUEUE_GRAPHICS, execute_ask, &ask, sizeof ask);
    graph_use_buffer(pass, in, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, frame.table, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, frame.wanted, GRAPH_WRITE_COMPUTE);
    graph_use_buffer(pass, out, GRAPH_WRITE_COMPUTE);
    struct graph_pass *host = graph_add_pass(graph, "to host", GRAPH_QUEUE_GRAPHICS, execute_nothing, NULL, 0);
    graph_keep(host);
    graph_use_buffer(host, out, GRAPH_READ_HOST);
    assert_int_equal(graph_compile(graph), FNL_OK);
    assert_int_equal(graph_execute_frame(graph, NULL), FNL_OK);
    assert_int_equal(gpu_wait_idle(device), FNL_OK);
    memcpy(results, buffers[1].mapped, sizeof results);
    graph_destroy(&graph);
    for (int i = 0; i < 2; i++) gpu_buffer_destroy(device, &buffers[i]);
}

static vec3 random_direction(struct random_state *random) {
    for (;;) {
        vec3 v = {random_range(random, -1, 1), random_range(random, -1, 1), random_range(random, -1, 1)};
        float length = vec3_length(v);
        if (length > 0.1f && length < 1) return vec3_scale(v, 1 / length);
    }
}

/* One material fills all 64 x 64 pages of the atlas. */
static void test_round_trip(void **state) {
    UNUSED(state);
    gpu_device *device = harness_device();
    struct gpu_virtual_material material = {
        .tiers = 1, .width = SIDE * VIRTUAL_INNER, .height = SIDE * VIRTUAL_INNER, .transform = {1, 0, 0, 0, 1, 0}};
    uint32_t table[SIDE * SIDE];
    for (uint32_t i = 0; i < SIDE * SIDE; i++) {
        pages[i] = (struct gpu_virtual_page){0, i % SIDE | i / SIDE << 14};
        table[i] = SIDE * SIDE - i; /* the atlas is filled from its end */
    }
    struct virtual_contents contents = {
        .materials = &material, .pages = pages, .material_count = 1, .page_count = SIDE * SIDE, .always = 1, .side = 8192};
    struct virtual_atlas atlas;
    assert_int_equal(virtual_create(device, &contents, &atlas), FNL_OK);
    assert_int_equal(atlas.across, SIDE);
    assert_int_equal(gpu_upload_buffer(device, &atlas.table, 0, table, sizeof table), FNL_OK);
    assert_int_equal(gpu_upload_flush(device), FNL_OK);
    struct random_state random = {5};
    for (uint32_t i = 0; i < CASES; i++) {
        struct gpu_virtual_case *c = &cases[i];
        c->uv = (vec2){random_range(&random, -2, 3), random_range(&random, -2, 3)};
        if (i < 16) c->uv = (vec2){(float)(i & 3) * (1.0f / SIDE), (float)(i >> 2) * (1.0f / 3)}; /* seams */
        c->change = 1e-5f;
        vec3 n = random_direction(&random), t = vec3_normalize(vec3_cross(n, random_direction(&random)));
        c->normal = (vec4){n.x, n.y, n.z, 0};
        c->tangent = (vec4){t.x, t.y, t.z, i & 1 ? -1 : 1};
    }
    ask_device(&atlas);
    double worst = 0, worst_normal = 0, worst_tangent = 0;
    for (uint32_t i = 0; i < CASES; i++) {
        const struct gpu_virtual_result *r = &results[i];
        double x = (r->packed & 0xffff) / 8.0, y = (r->packed >> 16) / 8.0;
        uint32_t place = (uint32_t)x / VIRTUAL_PAGE + (uint32_t)y / VIRTUAL_PAGE * SIDE, page = SIDE * SIDE - 1 - place;
        const double at[2] = {
            x - (uint32_t)x / VIRTUAL_PAGE * (double)VIRTUAL_PAGE - VIRTUAL_BORDER + page % SIDE * (double)VIRTUAL_INNER,
            y - (uint32_t)y / VIRTUAL_PAGE * (double)VIRTUAL_PAGE - VIRTUAL_BORDER + page / SIDE * (double)VIRTUAL_INNER};
        const double uv[2] = {(double)cases[i].uv.x, (double)cases[i].uv.y};
        for (int k = 0; k < 2; k++) {
            double expected = (uv[k] - floor(uv[k])) * SIDE * VIRTUAL_INNER, error = fabs(at[k] - expected);
            worst = fmax(worst, fmin(error, SIDE * VIRTUAL_INNER - error));
        }
        vec3 n = {cases[i].normal.x, cases[i].normal.y, cases[i].normal.z}, m = {r->normal.x, r->normal.y, r->normal.z};
        vec3 t = {cases[i].tangent.x, cases[i].tangent.y, cases[i].tangent.z},
             s = {r->tangent.x, r->tangent.y, r->tangent.z};
        worst_normal = fmax(worst_normal, (double)vec3_distance(n, m));
        worst_tangent = fmax(worst_tangent, (double)vec3_distance(t, s));
        assert_true(r->tangent.w == cases[i].tangent.w);
    }
    print_message("64 x 64 pages: %.3f texels off; normals by %.2f, tangents by %.2f degrees at most\n", worst,
                  worst_normal * 180 / M_PI, worst_tangent * 180 / M_PI);
    assert_true(worst <= 0.125);
    assert_true(worst_normal < 0.006 && worst_tangent < 0.006);
    virtual_destroy(device, &atlas);
    gpu_wait_idle(device);
}

/* ---- scenes ---- */

static uint32_t chequer = 16; /* texels */

static fnl_image_id add_image(fnl_scene *scene, uint32_t side, uint32_t seed, bool plain) {
    uint8_t *texels = malloc((size_t)side * side * 4);
    assert_non_null(texels);
    for (uint32_t i = 0; i < side * side; i++) {
        bool dark = !plain && ((i % side / chequer) ^ (i / side / chequer)) & 1;
        const uint8_t tint[4] = {(uint8_t)(40 + seed * 37 % 200), (uint8_t)(40 + seed * 91 % 200),
                                 (uint8_t)(40 + seed * 53 % 200), 255};
        for (uint32_t k = 0; k < 4; k++) texels[i * 4 + k] = (uint8_t)(dark && k < 3 ? tint[k] / 4 : tint[k]);
    }
    fnl_image image = {side, side, FNL_PIXEL_FORMAT_RGBA8, texels};
    fnl_image_id id;
    assert_int_equal(fnl_scene_add_image(scene, &image, true, &id), FNL_OK);
    free(texels);
    return id;
}

/* Unit squares side by side at z = 0, `count` of them in rows of `across`, each with a texture of its own. */
static fnl_scene *squares(uint32_t count, uint32_t across, uint32_t side, bool plain) {
    fnl_scene *scene;
    assert_int_equal(fnl_scene_create(gpu_host(harness_device()), &scene), FNL_OK);
    assert_int_equal(fnl_scene_set_anisotropy(scene, 1), FNL_OK);
    static const vec3 corners[4] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    static const uint32_t order[6] = {0, 1, 2, 0, 2, 3};
    for (uint32_t i = 0; i < count; i++) {
        vec3 *positions = ARENA_ARRAY(&scene->arena, vec3, 4);
        vec2 *uv = ARENA_ARRAY(&scene->arena, vec2, 4);
        uint32_t *indices = ARENA_ARRAY(&scene->arena, uint32_t, 6);
        memcpy(indices, order, sizeof order);
        for (uint32_t v = 0; v < 4; v++) {
            positions[v] = (vec3){corners[v].x + (float)(i % across), corners[v].y + (float)(i / across), 0};
            uv[v] = (vec2){corners[v].x + 0.37f * (float)i, 1 - corners[v].y}; /* jumps from square to square */
        }
        struct scene_material m = scene_material_default();
        m.unlit = true;
        m.textures[SCENE_TEXTURE_BASE_COLOR].image = add_image(scene, side, i + 1, plain).index;
        struct scene_primitive p = {.material = scene_add_material(scene, &m),
                                    .topology = SCENE_TOPOLOGY_TRIANGLES,
                                    .vertex_count = 4,
                                    .index_count = 6,
                                    .indices = indices,
                                    .positions = positions};
        p.uv[0] = uv;
        assert_int_equal(mesh_complete(&scene->arena, &p), FNL_OK);
        mat4 identity = mat4_identity();
        scene_add_node(scene, "", SCENE_NONE, &identity, scene_add_mesh(scene, "", &p, 1));
    }
    scene_update_transforms(scene);
    return scene;
}

static struct stage open_squares(uint32_t count, uint32_t across, uint32_t side, bool plain) {
    struct stage stage = stage_open_scene(squares(count, across, side, plain));
    fnl_frame *frame = &stage.frame;
    frame->width = 161; /* pages and levels are counted */
    frame->height = 91;
    frame->camera = fnl_camera_default();
    frame->camera.target = (vec3){(float)across * 0.5f, (float)(count / across) * 0.5f, 0};
    frame->camera.position = vec3_add(frame->camera.target, (vec3){0, 0, (float)across});
    frame->exposure = FNL_EXPOSURE_NONE;
    frame->tonemap = FNL_TONEMAP_NONE;
    frame->shading = FNL_SHADING_VIRTUAL_TEXTURING;
    frame->lists = FNL_LISTS_ALL;
    return stage;
}

/* ---- levels of detail ---- */

/* Squares seen at a slant: what the hardware would take follows from positions, as u and v are x and -y in metres. */
static void test_levels(void **state) {
    UNUSED(state);
    enum { TEXELS = 1024 };
    struct stage stage = open_squares(4, 2, TEXELS, false);
    fnl_frame frame = stage.frame;
    frame.camera.position = (vec3){0.2f, -0.9f, 1.1f};
    frame.camera.target = (vec3){1.1f, 1.2f, 0};
    frame.outputs |= FNL_OUTPUT_POSITION;
    harness_hooks(stage.renderer)->show_levels = true;
    struct shot shot = stage_shoot(&stage, &frame);
    const float *levels = shot.radiance.pixels, *positions = shot.position.pixels;
    uint32_t seen = 0, inside[2] = {0}, seams = 0;
    double worst = 0;
    for (uint32_t y = 0; y + 1 < frame.height; y++)
        for (uint32_t x = 0; x + 1 < frame.width; x++) {
            uint32_t cx = x & ~1u, cy = y & ~1u;
            const float *p = &positions[(cy * frame.width + cx) * 4], *right = p + 4, *down = p + frame.width * 4;
            if (cx + 1 >= frame.width || cy + 1 >= frame.height) continue;
            if (positions[(y * frame.width + x) * 4 + 3] < 1 || p[3] < 1 || right[3] < 1 || down[3] < 1) continue;
            double along = hypot((double)(right[0] - p[0]), (double)(right[1] - p[1])) * TEXELS,
                   across = hypot((double)(down[0] - p[0]), (double)(down[1] - p[1])) * TEXELS;
            double hardware = fmax(log2(fmax(along, across)), 0), level = (double)levels[(y * frame.width + x) * 4];
            bool seam = right[3] != p[3] || down[3] != p[3];
            seen++;
            seams += seam;
            double error = fabs(level - hardware);
            inside[0] += error <= 0.25;
            inside[1] += error <= 1;
            worst = fmax(worst, error);
        }
    print_message("levels of %u pixels, %u at seams: %u within 1/4, %u within 1, %.2f at most\n", seen, seams, inside[0],
                  inside[1], worst);
    assert_true(seen > 3000 && seams > 50);
    assert_int_equal(inside[1], seen);
    assert_true(inside[0] * 20 > seen * 19);
    shot_free(&shot);
    stage_close(&stage);
}

/*
 * Two charts of one material side by side, along which coordinates change by 3 texels a pixel, and across by a half: the level follows from the 3
 * in the first and last column (row) of each as well, where one neighbour is of the other chart, or is the background.
 */
static void test_levels_at_the_edges_of_charts(void **state) {
    UNUSED(state);
    enum { TEXELS = 1024, CHART = 32, MARGIN = 4 };
    for (int turned = 0; turned < 2; turned++) {
        fnl_scene *scene;
        assert_int_equal(fnl_scene_create(gpu_host(harness_device()), &scene), FNL_OK);
        assert_int_equal(fnl_scene_set_anisotropy(scene, 1), FNL_OK);
        struct scene_material m = scene_material_default();
        m.unlit = true;
        m.textures[SCENE_TEXTURE_BASE_COLOR].image = add_image(scene, TEXELS, 1, false).index;
        const uint32_t material = scene_add_material(scene, &m);
        static const uint32_t order[6] = {0, 1, 2, 0, 2, 3};
        for (uint32_t chart = 0; chart < 2; chart++) {
            vec3 *positions = ARENA_ARRAY(&scene->arena, vec3, 4);
            vec2 *uv = ARENA_ARRAY(&scene->arena, vec2, 4);
            uint32_t *indices = ARENA_ARRAY(&scene->arena, uint32_t, 6);
            memcpy(indices, order, sizeof order);
            for (uint32_t v = 0; v < 4; v++) {
                const float x = v == 1 || v == 2 ? 1 : 0, y = v > 1 ? 1 : 0, long_way = CHART * 3.0f / TEXELS, short_way = CHART * 0.5f / TEXELS;
                positions[v] = turned ? (vec3){x, y + (float)chart, 0} : (vec3){x + (float)chart, y, 0};
                uv[v] = (vec2){0.1f + 0.3f * (float)chart + x * (turned ? short_way : long_way), 0.2f + 0.35f * (float)chart + y * (turned ? long_way : short_way)};
            }
            struct scene_primitive p = {.material = material, .topology = SCENE_TOPOLOGY_TRIANGLES, .vertex_count = 4, .index_count = 6, .indices = indices, .positions = positions};
            p.uv[0] = uv;
            assert_int_equal(mesh_complete(&scene->arena, &p), FNL_OK);
            const mat4 identity = mat4_identity();
            scene_add_node(scene, "", SCENE_NONE, &identity, scene_add_mesh(scene, "", &p, 1));
        }
        scene_update_transforms(scene);
        struct stage stage = stage_open_scene(scene);
        fnl_frame *frame = &stage.frame;
        const uint32_t width = turned ? CHART : 2 * CHART, height = 3 * CHART - width; /* of both charts */
        frame->width = width + 2 * MARGIN, frame->height = height + 2 * MARGIN;
        frame->camera = fnl_camera_default();
        frame->camera.target = (vec3){turned ? 0.5f : 1, turned ? 1 : 0.5f, 0};
        frame->camera.position = vec3_add(frame->camera.target, (vec3){0, 0, 1});
        frame->camera.orthographic = true;
        frame->camera.vertical_extent = (float)frame->height / CHART;
        frame->exposure = FNL_EXPOSURE_NONE;
        frame->tonemap = FNL_TONEMAP_NONE;
        frame->shading = FNL_SHADING_VIRTUAL_TEXTURING;
        frame->lists = FNL_LISTS_ALL;
        harness_hooks(stage.renderer)->show_levels = true;
        struct shot shot = stage_shoot(&stage, frame);
        for (uint32_t y = 0; y < height; y++)
            for (uint32_t x = 0; x < width; x++) {
                const float level = ((const float *)shot.radiance.pixels)[((y + MARGIN) * frame->width + x + MARGIN) * 4];
                if (fabsf(level - log2f(3)) > 0.2f) fail_msg("turned %d: level %g in column %u, row %u", turned, (double)level, x, y);
            }
        shot_free(&shot);
        stage_close(&stage);
    }
}

/* Pages hold what mipmaps hold: chequers far away are the grey that forward shading shows, where one of their colours would alias. */
static void test_pages_are_filtered(void **state) {
    UNUSED(state);
    chequer = 5; /* so that texels of coarse pages do not fall on single ones */
    struct stage stage = open_squares(4, 2, 2048, false);
    chequer = 16;
    fnl_frame frame = stage.frame;
    for (int i = 0; i < 3; i++) {
        frame.camera.position.z = (const float[]){4, 12, 40}[i];
        frame.shading = FNL_SHADING_VIRTUAL_TEXTURING;
        struct shot first = stage_shoot(&stage, &frame), atlas = stage_shoot(&stage, &frame);
        frame.shading = FNL_SHADING_FORWARD;
        struct shot forward = stage_shoot(&stage, &frame);
        fnl_image_difference difference;
        assert_int_equal(fnl_image_compare(NULL, &forward.color, &atlas.color, &difference), FNL_OK);
        print_message("from %g m: %.1f dB\n", (double)frame.camera.position.z, difference.psnr);
        assert_true(difference.psnr > 45);
        shot_free(&first);
        shot_free(&atlas);
        shot_free(&forward);
    }
    stage_close(&stage);
}

/* ---- residency ---- */

/* The camera goes near: one frame shows less detail, the next what a new renderer shows; nothing is filled twice. */
static void test_pages_follow_the_view(void **state) {
    UNUSED(state);
    struct stage stage = open_squares(4, 2, 2048, false), fresh = open_squares(4, 2, 2048, false);
    fnl_frame far = stage.frame, near = stage.frame;
    far.camera.position.z = 30;
    near.camera.position = (vec3){0.8f, 0.7f, 0.3f};
    near.camera.target = (vec3){0.8f, 0.7f, 0};
    struct shot first = stage_shoot(&stage, &far), again = stage_shoot(&stage, &far);
    assert_int_equal(count_differing(&first.radiance, &again.radiance), 0);
    assert_true(counter(&first.stats, "atlas.filled") == counter(&first.stats, "atlas.wanted") &&
                counter(&first.stats, "atlas.wanted") >= 4);
    assert_int_equal(counter(&again.stats, "atlas.filled"), 0);
    assert_int_equal(counter(&first.stats, "atlas.evicted"), 0);
    assert_int_equal(counter(&first.stats, "atlas.pages"),
                     4 * (18 * 18 + 5 * 5 + 2 * 2 + 1 + 3) + 1); /* and one that nothing has */
    struct shot blurred = stage_shoot(&stage, &near), sharp = stage_shoot(&stage, &near), truth = stage_shoot(&fresh, &near);
    assert_int_equal(counter(&blurred.stats, "atlas.filled"), 0);
    assert_true(counter(&sharp.stats, "atlas.filled") > 0 && counter(&sharp.stats, "atlas.missing") == 0);
    assert_int_equal(count_differing(&sharp.radiance, &truth.radiance), 0);
    assert_true(count_differing(&sharp.radiance, &blurred.radiance) > 100);
    fnl_image_difference difference;
    assert_int_equal(fnl_image_compare(NULL, &sharp.color, &blurred.color, &difference), FNL_OK);
    print_message("far: %u pages; near: %u, %u new; the frame between %.1f dB\n",
                  (uint32_t)counter(&first.stats, "atlas.resident"), (uint32_t)counter(&sharp.stats, "atlas.resident"),
                  (uint32_t)counter(&sharp.stats, "atlas.filled"), difference.psnr);
    struct shot *shots[] = {&first, &again, &blurred, &sharp, &truth};
    for (uint32_t i = 0; i < COUNT_OF(shots); i++) shot_free(shots[i]);
    stage_close(&stage);
    stage_close(&fresh);
}

/* More than fits: of textures of one colour each nothing is seen of that, so any wrong material is; of others the detail goes. */
static void test_overflow(void **state) {
    UNUSED(state);
    for (int plain = 0; plain < 2; plain++) {
        struct stage stage = open_squares(12, 4, 1024, plain);
        fnl_frame frame = stage.frame;
        frame.camera.position.z = 1;
        frame.shading = FNL_SHADING_FORWARD;
        struct shot forward = stage_shoot(&stage, &frame);
        frame.shading = FNL_SHADING_VIRTUAL_TEXTURING;
        struct shot whole = stage_shoot(&stage, &frame);
        assert_int_equal(counter(&whole.stats, "atlas.missing"), 0);
        frame.texturing.atlas_size = 512;
        struct shot first = stage_shoot(&stage, &frame), later = stage_shoot(&stage, &frame);
        assert_true(counter(&first.stats, "atlas.missing") > 0);
        assert_int_equal(counter(&first.stats, "atlas.resident"), 16);
        assert_int_equal(counter(&later.stats, "atlas.filled"), 0);
        assert_int_equal(count_differing(&first.radiance, &later.radiance), 0);
        fnl_image_difference difference;
        assert_int_equal(fnl_image_compare(NULL, &forward.color, &first.color, &difference), FNL_OK);
        print_message("%s: %u pages wanted, room for %u: %.1f dB\n", plain ? "plain" : "checkered",
                      (uint32_t)counter(&first.stats, "atlas.wanted"), (uint32_t)counter(&first.stats, "atlas.capacity"),
                      difference.psnr);
        if (plain)
            assert_true(greatest_difference(&forward.color, &first.color) <= 1);
        else
            assert_true(difference.psnr > 15);
        shot_free(&forward);
        shot_free(&whole);
        shot_free(&first);
        shot_free(&later);
        /* Elsewhere, and back: pages give way to others, and come again. */
        for (int step = 0; step < 2; step++) {
            frame.camera.position.x += step ? -1.3f : 1.3f;
            frame.camera.target.x += step ? -1.3f : 1.3f;
            frame.shading = FNL_SHADING_FORWARD;
            forward = stage_shoot(&stage, &frame);
            frame.shading = FNL_SHADING_VIRTUAL_TEXTURING;
            first = stage_shoot(&stage, &frame);
            later = stage_shoot(&stage, &frame);
            assert_int_equal(counter(&first.stats, "atlas.filled"), 0);
            assert_int_equal(counter(&later.stats, "atlas.resident"), 16);
            assert_true(counter(&later.stats, "atlas.filled") > 0);
            assert_int_equal(counter(&later.stats, "atlas.evicted"),
                             counter(&later.stats, "atlas.filled")); /* there was no empty place */
            if (plain) {
                assert_true(greatest_difference(&forward.color, &first.color) <= 1);
                assert_true(greatest_difference(&forward.color, &later.color) <= 1);
            }
            shot_free(&forward);
            shot_free(&first);
            shot_free(&later);
        }
        stage_close(&stage);
    }
    struct stage stage = open_squares(12, 4, 64, true); /* not even a page for each material */
    stage.frame.texturing.atlas_size = 256;
    assert_int_equal(fnl_renderer_render(stage.renderer, &stage.frame), FNL_ERROR_UNSUPPORTED);
    stage_close(&stage);
}

/* A material whose textures have coordinates of their own, and one that is not filtered, are lit forward. */
static void test_what_the_atlas_cannot_hold(void **state) {
    UNUSED(state);
    fnl_scene *scene = squares(4, 2, 128, false);
    scene->materials.data[1].textures[SCENE_TEXTURE_EMISSIVE] = scene->materials.data[0].textures[SCENE_TEXTURE_BASE_COLOR];
    scene->materials.data[1].textures[SCENE_TEXTURE_EMISSIVE].transform[0] = 3.3f;
    scene->materials.data[1].emissive = (vec3){0.5f, 0.5f, 0.5f};
    scene->materials.data[1].unlit = false;
    struct scene_sampler nearest = {SCENE_FILTER_NEAREST, SCENE_FILTER_NEAREST, SCENE_FILTER_NEAREST, false,
                                    SCENE_WRAP_CLAMP,     SCENE_WRAP_CLAMP};
    scene->materials.data[2].textures[SCENE_TEXTURE_BASE_COLOR].sampler = scene_add_sampler(scene, &nearest);
    struct stage stage = stage_open_scene(scene);
    fnl_frame frame = stage.frame;
    frame.camera = fnl_camera_default();
    frame.camera.target = (vec3){1, 1, 0};
    frame.camera.position = (vec3){1.1f, 0.9f, 3};
    frame.count_lights = true;
    struct shot forward = stage_shoot(&stage, &frame);
    frame.shading = FNL_SHADING_VIRTUAL_TEXTURING;
    struct shot shot = stage_shoot(&stage, &frame);
    assert_int_equal(counter(&shot.stats, "gbuffer.items-forward"), 2);
    assert_int_equal(counter(&shot.stats, "gbuffer.bytes"), 8ull * frame.width * frame.height);
    fnl_image_difference difference;
    assert_int_equal(fnl_image_compare(NULL, &forward.color, &shot.color, &difference), FNL_OK);
    print_message("two of four materials forward: %.1f dB\n", difference.psnr);
    assert_true(difference.psnr > 40);
    shot_free(&forward);
    shot_free(&shot);
    stage_close(&stage);
}

/* ---- feedback: which pages a frame wants, against the same from positions ---- */

enum { SQUARES = 4, TEXELS = 1024, MAX_PAGES = 1024 };

struct marks {
    bool certain[MAX_PAGES], possible[MAX_PAGES]; /* pages that some pixel must want, and that rounding may make it want */
};

static void mark_tier(const struct gpu_virtual_material *m, uint32_t tier, double u, double v, bool certain, struct marks *out) {
    double texels = (double)MAX(TEXELS >> (VIRTUAL_STEP * tier), 1), margin = certain ? 0.05 : 0;
    uint32_t across = DIVIDE_UP((uint32_t)texels, VIRTUAL_INNER);
    uint32_t number[2] = {0, 0};
    for (int i = 0; i < 4; i++) { /* seams are near: either page may be meant */
        double x = (u - floor(u)) * texels + (i & 1 ? margin : -margin), y = (v - floor(v)) * texels + (i & 2 ? margin : -margin);
        uint32_t column = (uint32_t)(fmax(x, 0) / VIRTUAL_INNER), row = (uint32_t)(fmax(y, 0) / VIRTUAL_INNER);
        uint32_t page = m->first_page[tier] + MIN(row, across - 1) * across + MIN(column, across - 1);
        assert_true(page < MAX_PAGES);
        out->possible[page] = true;
        if (i == 0) number[0] = number[1] = page;
        number[0] = MIN(number[0], page);
        number[1] = MAX(number[1], page);
    }
    if (certain && number[0] == number[1]) out->certain[number[0]] = true;
}

/* The page of the level that the hardware would take, and all coarser ones up to that which holds the whole texture. */
static void mark_chain(const struct gpu_virtual_material *m, uint32_t finest, double u, double v, bool certain, struct marks *out) {
    finest = MIN(finest, m->tiers - 1);
    for (uint32_t tier = MIN(finest, m->whole); tier <= MAX(finest, m->whole); tier++)
        if (finest <= m->whole || tier == finest || tier == m->whole) mark_tier(m, tier, u, v, certain, out);
}

/* Squares at z = 0 in rows of two; u and v are x and 1 - y within each, u shifted by 0.37 from square to square. */
static void mark_picture(const struct shot *shot, const fnl_scene *scene, const struct gpu_virtual_material *materials, struct marks *out) {
    uint32_t width = shot->position.width, height = shot->position.height;
    const float *positions = shot->position.pixels;
    for (uint32_t y = 0; y < height; y++)
        for (uint32_t x = 0; x < width; x++) {
            const float *p = positions + 4 * (y * width + x);
            if (p[3] < 1) continue;
            uint32_t column = (uint32_t)fmaxf(p[0], 0), row = (uint32_t)fmaxf(p[1], 0), square = row * 2 + column;
            /* On the border of a square the position may be the neighbour's. */
            double fx = (double)p[0] - column, fy = (double)p[1] - row;
            bool inside = square < SQUARES && column < 2 && fx > 1e-4 && fx < 1 - 1e-4 && fy > 1e-4 && fy < 1 - 1e-4;
            const struct gpu_virtual_material *m = &materials[scene->primitives.data[MIN(square, SQUARES - 1u)].material];
            double u = fx + 0.37 * square, v = 1 - fy;
            const float *first = positions + 4 * ((y & ~1u) * width + (x & ~1u));
            bool whole = (x | 1) < width && (y | 1) < height;
            const float *right = whole ? first + 4 : first, *below = whole ? first + 4 * width : first;
            whole = whole && first[3] >= 1 && right[3] >= 1 && below[3] >= 1;
            double along = hypot((double)(right[0] - first[0]), (double)(right[1] - first[1])) * TEXELS,
                   down = hypot((double)(below[0] - first[0]), (double)(below[1] - first[1])) * TEXELS;
            double level = log2(fmax(fmax(along, down), 1)), band = 0.3;
            if (!whole) { /* where squares end: about as its other neighbours */
                band = 1.5;
                for (int i = 0; i < 4; i++) {
                    uint32_t nx = x + (i == 0) - (i == 1), ny = y + (i == 2) - (i == 3);
                    if (nx >= width || ny >= height || positions[4 * (ny * width + nx) + 3] < 1) continue;
                    const float *q = positions + 4 * (ny * width + nx);
                    level = fmax(level, log2(fmax(hypot((double)(q[0] - p[0]), (double)(q[1] - p[1])) * TEXELS, 1)));
                }
            }
            uint32_t low = (uint32_t)fmax((level - band) / VIRTUAL_STEP, 0), high = (uint32_t)((level + band) / VIRTUAL_STEP);
            bool certain = whole && inside && low == high;
            for (uint32_t tier = low; tier <= MIN(high, m->tiers - 1); tier++) mark_chain(m, tier, u, v, certain, out);
        }
}

/*
 * The pages that a frame asks for are those that its pixels see, at the level that the hardware would take, and the coarser ones: no fewer,
 * and no more. Seen as a floor, as a wall at the side and from above, so that levels follow the steeper of both gradients. With too little room
 * the coarse ones come first.
 */
static void test_wanted_pages(void **state) {
    UNUSED(state);
    struct stage stage = open_squares(SQUARES, 2, TEXELS, false);
    static const vec3 positions[] = {{0.3f, -0.2f, 0.3f}, {-0.2f, 0.4f, 0.3f}, {1, 1, 1}};
    for (uint32_t view = 0; view < COUNT_OF(positions); view++) {
        fnl_frame frame = stage.frame;
        frame.camera.position = positions[view];
        frame.camera.target = (vec3){1.1f, 1.2f, 0};
        if (view == 0) frame.camera.up = (vec3){0, 0, 1}; /* the squares are a floor: levels follow what changes downwards */
        if (view == 2) frame.camera.target = (vec3){1, 1, 0};
        frame.width = 320;
        frame.height = 180;
        frame.outputs |= FNL_OUTPUT_POSITION;
        struct shot shot = stage_shoot(&stage, &frame);
        const struct virtual_atlas *atlas = &stage.renderer->shading.atlas;
        static struct gpu_virtual_material materials[SQUARES + 2];
        static struct gpu_virtual_page numbered[MAX_PAGES];
        static uint32_t wanted[MAX_PAGES], table[MAX_PAGES];
        static struct marks marks;
        memset(&marks, 0, sizeof marks);
        uint32_t count = atlas->page_count, certain = 0, possible = 0, marked = 0, with_always = 0;
        assert_true(count <= MAX_PAGES);
        gpu_device *device = harness_device();
        assert_int_equal(gpu_read_buffer(device, &atlas->materials, 0, materials, (SQUARES + 1) * sizeof materials[0]), FNL_OK);
        assert_int_equal(gpu_read_buffer(device, &atlas->pages, 0, numbered, count * sizeof numbered[0]), FNL_OK);
        assert_int_equal(gpu_read_buffer(device, &atlas->wanted, 0, wanted, count * 4ull), FNL_OK);
        mark_picture(&shot, stage.scene, materials, &marks);
        uint32_t tiers[VIRTUAL_TIERS] = {0};
        for (uint32_t i = 0; i < count; i++) {
            uint32_t tier = numbered[i].place >> 28;
            if ((marks.certain[i] && !wanted[i]) || (wanted[i] && !marks.possible[i]))
                fail_msg("view %u: page %u, tier %u of material %u, is %s", view, i, tier, numbered[i].material,
                         wanted[i] ? "wanted by no pixel" : "not wanted");
            certain += marks.certain[i];
            possible += marks.possible[i];
            marked += wanted[i] != 0;
            with_always += wanted[i] || i < atlas->always;
            tiers[tier] += wanted[i] != 0;
        }
        print_message("view %u: %u pages wanted of %u, %u .. %u by positions; of tiers %u %u %u\n", view, marked, count, certain,
                      possible, tiers[0], tiers[1], tiers[2]);
        assert_true(marked > 20 && certain * 4 >= marked * 3 && possible <= marked * 2 && tiers[1] > 5 && (view == 2 || tiers[0] > 3));
        shot_free(&shot);
        struct shot later = stage_shoot(&stage, &frame);
        assert_int_equal(counter(&later.stats, "atlas.wanted"), with_always);
        assert_int_equal(counter(&later.stats, "atlas.missing"), 0);
        shot_free(&later);
        /* Room for 16: what is left out is as fine as anything that is there, or finer. */
        frame.texturing.atlas_size = 512;
        shot = stage_shoot(&stage, &frame);
        assert_int_equal(gpu_read_buffer(device, &atlas->wanted, 0, wanted, count * 4ull), FNL_OK);
        shot_free(&shot);
        later = stage_shoot(&stage, &frame);
        assert_int_equal(gpu_read_buffer(device, &atlas->table, 0, table, count * 4ull), FNL_OK);
        uint32_t finest_there = VIRTUAL_TIERS, coarsest_missing = 0, missing = 0;
        for (uint32_t i = 0; i < count; i++) {
            uint32_t tier = numbered[i].place >> 28;
            if (table[i] && i >= atlas->always) finest_there = MIN(finest_there, tier);
            if (wanted[i] && !table[i]) {
                coarsest_missing = MAX(coarsest_missing, tier);
                missing++;
            }
            if (i < atlas->always) assert_true(table[i] != 0);
        }
        print_message("  room for 16: %u missing, of tier %u at most; the finest that is there is of tier %u\n", missing, coarsest_missing, finest_there);
        assert_true(missing > 0 && coarsest_missing <= finest_there);
        assert_int_equal(counter(&later.stats, "atlas.missing"), missing);
        shot_free(&later);
    }
    stage_close(&stage);
}

/* ---- views ---- */

static uint32_t count_color(const fnl_image *image, int r, int g, int b, int tolerance) {
    const uint8_t *p = image->pixels;
    uint32_t count = 0;
    for (uint32_t i = 0; i < image->width * image->height; i++, p += 4)
        count += abs(p[0] - r) <= tolerance && abs(p[1] - g) <= tolerance && abs(p[2] - b) <= tolerance;
    return count;
}

/* The atlas shows each texture and its empty places; pages have colours of their own, and stripes where they are too coarse. */
static void test_views(void **state) {
    UNUSED(state);
    struct stage stage = open_squares(4, 2, 512, true);
    fnl_frame frame = stage.frame;
    frame.texturing.atlas_size = 1024;
    frame.camera.position.z = 1;
    frame.debug = FNL_DEBUG_ATLAS;
    struct shot atlas = stage_shoot(&stage, &frame);
    uint32_t side = MIN(frame.width, frame.height), places = counter(&atlas.stats, "atlas.capacity"), shown = 0;
    for (int seed = 1; seed <= 4; seed++) {
        uint32_t found = count_color(&atlas.color, 40 + seed * 37 % 200, 40 + seed * 91 % 200, 40 + seed * 53 % 200, 1);
        assert_true(found > 0);
        shown += found;
    }
    print_message("%u of %u places there, %u of %u pixels show their textures\n",
                  (uint32_t)counter(&atlas.stats, "atlas.resident"), places, shown, side * side);
    double share = (double)counter(&atlas.stats, "atlas.resident") / places, seen = (double)shown / (side * side);
    assert_true(seen > 0.7 * share && seen <= share);
    assert_int_equal(count_color(&atlas.color, 255, 0, 255, 0), 0);
    frame.debug = FNL_DEBUG_PAGES;
    struct shot shown_pages = stage_shoot(&stage, &frame);
    assert_int_equal(counter(&shown_pages.stats, "atlas.missing"), 0);
    assert_int_equal(count_color(&shown_pages.color, 255, 0, 255, 0), 0);
    frame.shading = FNL_SHADING_TEXTURING;
    assert_int_equal(fnl_renderer_render(stage.renderer, &frame), FNL_ERROR_UNSUPPORTED);
    frame.shading = FNL_SHADING_VIRTUAL_TEXTURING;
    frame.msaa = 4;
    assert_int_equal(fnl_renderer_render(stage.renderer, &frame), FNL_ERROR_UNSUPPORTED);
    shot_free(&atlas);
    shot_free(&shown_pages);
    stage_close(&stage);
    stage = open_squares(12, 4, 1024, true); /* more pages than 16 */
    frame = stage.frame;
    frame.camera.position.z = 1;
    frame.debug = FNL_DEBUG_PAGES;
    frame.texturing.atlas_size = 512;
    shown_pages = stage_shoot(&stage, &frame);
    uint32_t striped = count_color(&shown_pages.color, 255, 0, 255, 0), black = count_color(&shown_pages.color, 0, 0, 0, 0);
    print_message("%u stripes in %u pixels of pages\n", striped, frame.width * frame.height - black);
    assert_true(counter(&shown_pages.stats, "atlas.missing") > 0 && striped * 8 > frame.width * frame.height - black);
    shot_free(&shown_pages);
    stage_close(&stage);
}

/* Shaders reach the atlas by indices, so nothing else would see a layer that has no barriers. */
static void test_the_graph_knows_all_layers(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:interior?lights=4", 0);
    stage.frame.shading = FNL_SHADING_VIRTUAL_TEXTURING;
    struct shot shot = stage_shoot(&stage, &stage.frame);
    const struct graph *graph = stage.renderer->graph;
    uint32_t layers = 0, known = 0;
    for (uint32_t i = 0; i < VIRTUAL_LAYERS; i++) {
        const struct gpu_image *image = &stage.renderer->shading.atlas.layers[i];
        if (!image->handle) continue;
        layers++;
        for (uint32_t k = 0; k < graph->resources.count; k++) known += graph->resources.data[k].image == image && graph->resources.data[k].first_use;
    }
    assert_true(layers > 2);
    assert_int_equal(known, layers);
    shot_free(&shot);
    stage_close(&stage);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        {"the graph knows all layers of the atlas", test_the_graph_knows_all_layers, NULL, harness_check, NULL},
        {"ES-70: coordinates in 2 x 16 bits and frames in 32, in 64 x 64 pages", test_round_trip, NULL, harness_check, NULL},
        {"ES-71: levels are the hardware's inside charts and at seams", test_levels, NULL, harness_check, NULL},
        {"ES-71: levels at the edges of charts", test_levels_at_the_edges_of_charts, NULL, harness_check, NULL},
        {"ES-70: pages are filtered as mipmaps are", test_pages_are_filtered, NULL, harness_check, NULL},
        {"ES-70, ES-71: a frame wants the pages that its pixels see", test_wanted_pages, NULL, harness_check, NULL},
        {"ES-70: pages follow the view", test_pages_follow_the_view, NULL, harness_check, NULL},
        {"ES-70: more pages than fit cost detail, never the material", test_overflow, NULL, harness_check, NULL},
        {"ES-70: the atlas and its pages can be looked at", test_views, NULL, harness_check, NULL},
        {"ES-70: what the atlas cannot hold is lit forward", test_what_the_atlas_cannot_hold, NULL, harness_check, NULL}};
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
