/* SPDX-License-Identifier: MIT */
/**
 * Lists and shading of real scenes, looked at from inside: the test declares a frame of its own from the same passes, and
 * reads cells, ids, counters, depths and positions of that very frame.
 */
#include "passes/debug/debug.h"
#include "passes/shade/deferred.h"
#include "tests/list_bench.h"

enum lists { ALL, TILES, TILES_WITHOUT_DEPTH, CLUSTERS, CLUSTERS_CPU, LISTS };
static const char *const list_names[LISTS] = {"all", "tiles", "tiles without depth", "clusters", "clusters of the CPU"};

/* What a frame left behind. */
struct traces {
    uint32_t width, height;
    struct list_copy list; /* empty for ALL */
    uint32_t *counters;    /* of each pixel */
    vec4 *normals;         /* w: view depth */
    vec4 *positions;       /* w: 0 where there is nothing */
};

static void *copy_mapped(const struct gpu_buffer *buffer) {
    void *copy = malloc(buffer->size);
    assert_non_null(copy);
    memcpy(copy, buffer->mapped, buffer->size);
    return copy;
}

struct clear_data {
    graph_buffer buffer;
};
static void execute_clear(const struct graph_context *context, const void *data) {
    const struct gpu_buffer *buffer = graph_get_buffer(context, ((const struct clear_data *)data)->buffer);
    gpu_fill_buffer(context->commands, buffer, 0, buffer->size, 0);
}

struct copy_data {
    graph_image normal, position;
    graph_buffer normals, positions;
};
static void execute_copy(const struct graph_context *context, const void *data) {
    const struct copy_data *d = data;
    gpu_copy_image_to_buffer(context->commands, graph_get_image(context, d->normal), graph_get_buffer(context, d->normals),
                             0);
    gpu_copy_image_to_buffer(context->commands, graph_get_image(context, d->position),
                             graph_get_buffer(context, d->positions), 0);
}

static void execute_nothing(const struct graph_context *context, const void *data) {
    UNUSED(context);
    UNUSED(data);
}

static graph_buffer import_readback(struct graph *graph, const char *name, uint64_t size, struct gpu_buffer *buffer) {
    assert_int_equal(gpu_buffer_create(harness_device(), name, size, GPU_MEMORY_READBACK, buffer), FNL_OK);
    return graph_import_buffer(graph, name, buffer);
}

/* Deferred shading with the given lists. The stage has rendered before: its scene is on the device. */
static struct traces trace(struct stage *stage, const fnl_frame *frame, enum lists kind) {
    enum { POOL = 1 << 20 };
    gpu_device *device = harness_device();
    fnl_renderer *r = stage->renderer;
    struct graph *graph = r->graph;
    struct traces t = {.width = frame->width, .height = frame->height};
    uint64_t pixels = (uint64_t)t.width * t.height;
    struct list_readback readback = {0};
    struct gpu_light_list grid = {0};
    struct gpu_buffer counters, normals, positions;

    assert_int_equal(gpu_wait_idle(device), FNL_OK);
    assert_int_equal(gpu_frame_begin(device), FNL_OK);
    graph_begin(graph);
    struct device_scene_frame scene;
    assert_int_equal(device_scene_add(&r->scene_user, graph, &scene), FNL_OK);
    struct gpu_view view = view_from_camera(&frame->camera, t.width, t.height);
    struct gpu_frame shared = {.hdr_max = FLT_MAX};
    struct gpu_slice shared_slice = gpu_frame_allocate(device, sizeof shared), slice = gpu_frame_allocate(device, sizeof view);
    memcpy(shared_slice.data, &shared, sizeof shared);
    view.frame = shared_slice.address;
    memcpy(slice.data, &view, sizeof view);
    const struct lighting scopes = {.lights = scene.lights, .layered = scene.layered, .environment = scene.environment, .view = slice.address};
    struct light_input whole = lighting_input(&scopes);
    const struct light_input *input = &whole;
    whole.width = t.width;
    whole.height = t.height;
    struct geometry_draws draws = cull_add(graph, &scene.geometry, slice.address);

    struct clear_data clear = {import_readback(graph, "test counters", pixels * 8, &counters)};
    struct graph_pass *pass = graph_add_pass(graph, "test clear", GRAPH_QUEUE_GRAPHICS, execute_clear, &clear, sizeof clear);
    graph_use_buffer(pass, clear.buffer, GRAPH_COPY_TO);

    struct graph_image_params image = {
        .name = "test radiance", .format = VK_FORMAT_R32G32B32A32_SFLOAT, .width = t.width, .height = t.height};
    graph_image radiance = graph_create_image(graph, &image);
    image.name = "test depth";
    image.format = GEOMETRY_DEPTH_FORMAT;
    graph_image depth = graph_create_image(graph, &image);
    struct light_list list;
    struct shade_input shade = {.scene = &scene.geometry,
                                .draws = &draws,
                                .view = slice.address,
                                .width = t.width,
                                .height = t.height,
                                .counters = clear.buffer};
    struct gbuffer gbuffer = gbuffer_add(graph, &shade, false, radiance, depth);

    struct tiled_params tiled = tiled_params_default();
    tiled.pool_capacity = POOL;
    struct clustered_params clustered = clustered_params_default();
    clustered.tile_size = 32;
    clustered.pool_capacity = POOL;
    struct list_request request = {.builder = kind == TILES || kind == TILES_WITHOUT_DEPTH ? LIST_TILED : LIST_CLUSTERED,
                                   .view = view,
                                   .light_count = input->set.local_count,
                                   .tiled = tiled,
                                   .clustered = clustered};
    if (kind != ALL) grid = list_grid(&request);
    struct lights_in_view in_view;
    if (kind == TILES || kind == TILES_WITHOUT_DEPTH || kind == CLUSTERS) in_view = lights_in_view_add(graph, device, input);
    if (kind == ALL) {
        list = light_list_all_add(graph, device, input);
    } else if (kind == CLUSTERS) {
        list = clustered_add(graph, device, input, &in_view, &clustered);
    } else if (kind == CLUSTERS_CPU) {
        struct clustered_cpu_view cpu_view = {view.ndc_scale, view.ndc_offset, frame->camera.orthographic, t.width,
                                              t.height};
        list = clustered_cpu_add(&r->lists.views.data[0].clustered_cpu, device, input,
                                 r->device_scene->light_bounds.data, &view.world_to_view, &cpu_view,
                                 &clustered);
    } else {
        list = tiled_add(graph, device, input, &in_view, kind == TILES ? depth : (graph_image){0}, &tiled);
    }
    if (list.cells.id) list_readback_add(graph, &list, &readback);
    const struct lighting lighting = lighting_add(graph, device, &scopes, &list);
    shade.lighting = &lighting;
    deferred_add(graph, &shade, &gbuffer, NULL, radiance);

    struct aov_images aov = aov_add(graph, &scene.geometry, &draws, slice.address, t.width, t.height);
    struct copy_data copy = {aov.normal, aov.position, import_readback(graph, "test normals", pixels * 16, &normals),
                             import_readback(graph, "test positions", pixels * 16, &positions)};
    pass = graph_add_pass(graph, "test copy", GRAPH_QUEUE_GRAPHICS, execute_copy, &copy, sizeof copy);
    graph_use_image(pass, copy.normal, GRAPH_COPY_FROM);
    graph_use_image(pass, copy.position, GRAPH_COPY_FROM);
    graph_use_buffer(pass, copy.normals, GRAPH_COPY_TO);
    graph_use_buffer(pass, copy.positions, GRAPH_COPY_TO);
    pass = graph_add_pass(graph, "points to host", GRAPH_QUEUE_GRAPHICS, execute_nothing, NULL, 0);
    graph_use_buffer(pass, clear.buffer, GRAPH_READ_HOST);
    graph_use_buffer(pass, copy.normals, GRAPH_READ_HOST);
    graph_use_buffer(pass, copy.positions, GRAPH_READ_HOST);

    assert_int_equal(graph_compile(graph), FNL_OK);
    assert_int_equal(graph_execute_frame(graph, NULL), FNL_OK);
    assert_int_equal(gpu_wait_idle(device), FNL_OK);
    if (list.cells.id)
        t.list = list_readback_take(&readback, &grid);
    else if (kind == CLUSTERS_CPU)
        t.list = list_copy_of_cpu(&r->lists.views.data[0].clustered_cpu, &grid);
    if (kind != ALL) list_check_form(&t.list, input->set.local_count);
    t.counters = copy_mapped(&counters);
    t.normals = copy_mapped(&normals);
    t.positions = copy_mapped(&positions);
    gpu_buffer_destroy(device, &counters);
    gpu_buffer_destroy(device, &normals);
    gpu_buffer_destroy(device, &positions);
    return t;
}

static void free_traces(struct traces *t) {
    list_free(&t->list);
    free(t->counters);
    free(t->normals);
    free(t->positions);
}

/* The local lights of a scene, in the order in which lists number them. */
static fnl_light_params *local_lights(const fnl_scene *scene, uint32_t *out_count) {
    fnl_scene_info info;
    assert_int_equal(fnl_scene_query_info(scene, &info), FNL_OK);
    fnl_light_params *lights = malloc((info.light_count + 1) * sizeof *lights);
    assert_non_null(lights);
    *out_count = 0;
    for (uint32_t i = 0; i < info.light_count; i++) {
        assert_int_equal(fnl_scene_query_light(scene, i, &lights[*out_count]), FNL_OK);
        *out_count += lights[*out_count].kind != FNL_LIGHT_DIRECTIONAL;
    }
    return lights;
}

/* SUP: the list of each pixel holds all lights that reach its surface. Returns the pairs that are lit. */
static uint64_t check_pixels(const struct traces *t, const fnl_light_params *lights, uint32_t light_count) {
    uint64_t lit = 0, missing = 0;
    for (uint32_t i = 0; i < t->width * t->height; i++) {
        const vec4 *p = &t->positions[i];
        if (p->w == 0) continue;
        double point[3] = {p->x, p->y, p->z};
        uint32_t cells[2];
        list_cells_of(&t->list, i % t->width, i / t->width, t->normals[i].w, cells);
        for (uint32_t l = 0; l < light_count; l++) {
            if (!light_reaches(&lights[l], point)) continue;
            lit++;
            if (!list_holds(&t->list, cells[0], l) || !list_holds(&t->list, cells[1], l)) {
                if (missing++ < 5) print_error("pixel %u, %u: light %u is missing\n", i % t->width, i / t->width, l);
            }
        }
    }
    assert_int_equal(missing, 0);
    return lit;
}

/* CNT: what the shader counted is the length of the pixel's list. Returns the sum. */
static uint64_t check_counters(const struct traces *t, bool has_list, uint32_t light_count) {
    uint64_t sum = 0;
    for (uint32_t i = 0; i < t->width * t->height; i++) {
        uint32_t cells[2];
        sum += t->counters[2 * i];
        if (t->positions[i].w == 0) {
            assert_int_equal(t->counters[2 * i], 0);
        } else if (!has_list) {
            assert_int_equal(t->counters[2 * i], light_count);
        } else {
            list_cells_of(&t->list, i % t->width, i / t->width, t->normals[i].w, cells);
            if (t->counters[2 * i] != t->list.cells[cells[0]].count)
                assert_int_equal(t->counters[2 * i], t->list.cells[cells[1]].count);
        }
    }
    return sum;
}

struct scene_case {
    const char *source;
    uint32_t scattered;
};

static void test_scene(void **state) {
    const struct scene_case *c = *state;
    struct stage stage = stage_open(c->source, c->scattered);
    struct shot shot = stage_shoot(&stage, &stage.frame);
    shot_free(&shot);
    uint32_t light_count;
    fnl_light_params *lights = local_lights(stage.scene, &light_count);
    struct random_state random = {99};
    struct box bounds = scene_bounds(stage.scene);
    for (uint32_t view = 0; view < 4; view++) {
        fnl_frame frame = stage.frame;
        frame.width = 121 + view;
        frame.height = 67;
        if (view > 0) { /* somewhere in the scene, looking anywhere */
            frame.camera.position =
                vec3_make(random_range(&random, bounds.low.x, bounds.high.x) * 0.5f, random_range(&random, 0.5f, 3),
                          random_range(&random, bounds.low.z, bounds.high.z) * 0.5f);
            frame.camera.target =
                vec3_add(frame.camera.position, vec3_make(random_range(&random, -1, 1), random_range(&random, -0.6f, 0.2f),
                                                          random_range(&random, -1, 1)));
        }
        uint64_t sums[LISTS], lit = 0;
        for (uint32_t kind = ALL; kind < LISTS; kind++) {
            struct traces t = trace(&stage, &frame, (enum lists)kind);
            sums[kind] = check_counters(&t, kind != ALL, light_count);
            if (kind != ALL) lit = check_pixels(&t, lights, light_count);
            if (kind != ALL) assert_true(sums[kind] >= lit);
            free_traces(&t);
        }
        print_message("%s, view %u: %llu lit pairs; %llu evaluations for all", c->source, view, (unsigned long long)lit,
                      (unsigned long long)sums[ALL]);
        for (uint32_t kind = TILES; kind < LISTS; kind++)
            print_message(", %llu %s", (unsigned long long)sums[kind], list_names[kind]);
        print_message("\n");
        for (uint32_t kind = TILES; kind < LISTS; kind++) assert_true(sums[kind] <= sums[ALL]);
        assert_true(sums[TILES] <= sums[TILES_WITHOUT_DEPTH]);
        if (view > 0) continue;
        assert_true(sums[TILES] < sums[TILES_WITHOUT_DEPTH]);
        for (uint32_t kind = TILES; kind < LISTS; kind++)
            if (kind != TILES_WITHOUT_DEPTH) assert_true(sums[kind] * 3 < sums[ALL]);
    }
    free(lights);
    stage_close(&stage);
}

/* The stats of the renderer say what its shader counted; tiles do far less than one quad per light over the whole screen. */
static void test_stats_ES_41(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:hall?lights=256", 0);
    stage.frame.count_lights = true;
    stage.frame.shading = FNL_SHADING_DEFERRED;
    uint64_t quads = (uint64_t)stage.frame.width * stage.frame.height * 256;
    for (uint32_t l = FNL_LISTS_ALL; l < FNL_LISTS_COUNT; l++) {
        stage.frame.lists = (fnl_light_lists)l;
        if (!fnl_shading_supports(stage.frame.shading, stage.frame.lists, stage.frame.msaa)) continue;
        struct shot shot = stage_shoot(&stage, &stage.frame);
        assert_true(shot.stats.evaluations_counted && shot.stats.evaluations > 0);
        if (l == FNL_LISTS_ALL)
            assert_true(shot.stats.evaluations <= quads);
        else
            assert_true(shot.stats.evaluations * 3 < quads);
        assert_true(
            fabs(shot.stats.mean_per_pixel * stage.frame.width * stage.frame.height - (double)shot.stats.evaluations) < 1);
        assert_true(shot.stats.max_per_pixel >= shot.stats.mean_per_pixel && shot.stats.max_per_pixel <= 256);
        assert_true(l == FNL_LISTS_ALL || shot.stats.list_entries > 0);
        shot_free(&shot);
    }
    stage_close(&stage);
}

/* Largest difference of two pixels' colour, grey left out. */
static int hue_difference(const fnl_image *image, uint32_t x0, uint32_t y0, uint32_t x1, uint32_t y1) {
    const uint8_t *a = (const uint8_t *)image->pixels + 4 * ((size_t)y0 * image->width + x0);
    const uint8_t *b = (const uint8_t *)image->pixels + 4 * ((size_t)y1 * image->width + x1);
    return MAX(abs((a[0] - a[1]) - (b[0] - b[1])), abs((a[1] - a[2]) - (b[1] - b[2])));
}

/* The view of the counts, over the grey of the surfaces, shows tiles of 16 pixels; they cost less than quads. */
static void test_count_view_MP_23(void **state) {
    UNUSED(state);
    enum { TILE = 16, LEGEND = 14 };
    struct stage stage = stage_open("builtin:onetile?lights=60", 100);
    fnl_frame frame = stage.frame;
    frame.width = 323;
    frame.height = 181;
    frame.lists = FNL_LISTS_TILED;
    frame.shading = FNL_SHADING_DEFERRED;
    frame.debug = FNL_DEBUG_LIGHTS;
    frame.count_lights = true;
    frame.outputs = FNL_OUTPUT_COLOR;
    struct shot shot = stage_shoot(&stage, &frame);
    uint32_t steps = 0;
    for (uint32_t y = 1; y < frame.height - LEGEND; y++)
        for (uint32_t x = 1; x < frame.width; x++) {
            int across = hue_difference(&shot.color, x, y, x - 1, y), down = hue_difference(&shot.color, x, y, x, y - 1);
            if (x % TILE)
                assert_true(across <= 2);
            else
                steps += across > 2;
            if (y % TILE)
                assert_true(down <= 2);
            else
                steps += down > 2;
        }
    assert_true(steps > 1000);
    assert_true(shot.stats.evaluations > 0 && shot.stats.evaluations * 3 < 160ull * frame.width * frame.height);
    shot_free(&shot);
    stage_close(&stage);
}

/* Lamps on the view axis: one tile has them all, no cluster many, and walking along the row changes little. */
static void test_lamps_ES_50(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:lamps?lights=200", 0);
    struct shot shot = stage_shoot(&stage, &stage.frame);
    shot_free(&shot);
    uint32_t tile = 0, least = UINT32_MAX, most = 0;
    uint64_t least_sum = UINT64_MAX, most_sum = 0;
    for (uint32_t step = 0; step < 6; step++) {
        fnl_frame frame = stage.frame;
        frame.camera.position.z -= 0.7f * (float)step;
        frame.camera.target.z -= 0.7f * (float)step;
        struct traces tiles = trace(&stage, &frame, TILES_WITHOUT_DEPTH), clusters = trace(&stage, &frame, CLUSTERS);
        tile = MAX(tile, list_longest(&tiles.list));
        uint64_t sum = check_counters(&clusters, true, 200);
        least_sum = MIN(least_sum, sum);
        most_sum = MAX(most_sum, sum);
        uint32_t longest = 0; /* but for the open last slice */
        for (uint32_t c = 0; c < clusters.list.cell_count - clusters.list.grid.tiles_x * clusters.list.grid.tiles_y; c++)
            longest = MAX(longest, clusters.list.cells[c].count);
        least = MIN(least, longest);
        most = MAX(most, longest);
        free_traces(&tiles);
        free_traces(&clusters);
    }
    print_message("lamps: fullest tile %u, fullest cluster %u .. %u, %llu .. %llu evaluations\n", tile, least, most,
                  (unsigned long long)least_sum, (unsigned long long)most_sum);
    assert_true(tile >= 199 && most * 6 < tile && most <= least * 2);
    assert_true((double)most_sum < 1.3 * (double)least_sum);
    stage_close(&stage);
}

#define SCENE(name, source, scattered)                                                                                      \
    {                                                                                                                       \
        "SUP and CNT of all lists, ES-37 ES-41 ES-50 ES-53: " name, test_scene, NULL, harness_check, &(struct scene_case) { \
            source, scattered                                                                                               \
        }                                                                                                                   \
    }

int main(void) {
    const struct CMUnitTest tests[] = {
        SCENE("hall", "builtin:hall?lights=256", 200),
        SCENE("grass", "builtin:grass?lights=300", 100),
        SCENE("pole", "builtin:pole", 60),
        SCENE("nearplane", "builtin:nearplane", 60),
        cmocka_unit_test_teardown(test_stats_ES_41, harness_check),
        cmocka_unit_test_teardown(test_count_view_MP_23, harness_check),
        cmocka_unit_test_teardown(test_lamps_ES_50, harness_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
