/* SPDX-License-Identifier: MIT */
/**
 * Two views in one graph: culling, G-buffer, every kind of light lists, shading, metering, antialiasing and tone mapping are added
 * twice, each time under names of their own, and give what each view gives by itself, to the bit.
 */
#include "passes/aa/morphological.h"
#include "passes/aa/motion.h"
#include "passes/aa/taa.h"
#include "passes/geometry/clusters.h"
#include "passes/geometry/occlusion.h"
#include "passes/post/post.h"
#include "passes/post/post_shared.h"
#include "passes/shade/deferred.h"
#include "passes/shade/regroup.h"
#include "tests/render_harness.h"

enum { WIDTH = 96, HEIGHT = 54, POOL = 1 << 16 };

/* What a view leaves behind, and what comes with it from frame to frame. */
struct eye {
    const char *name;
    fnl_vec3 step; /* from where the scene's camera stands, and again with each frame */
    struct lists_shared shared;
    struct lists_state lists;
    struct gpu_view view;
    bool drawn; /* in the last frame, with `view` */
    struct gpu_buffer picture, counts;
};

struct eye_counts {
    uint32_t visible, hidden;
    float exposure[2];
    struct light_totals lights, blend, fallback;
};

struct copies {
    graph_image picture;
    graph_buffer from[6], target, counts;
    uint64_t offsets[6], sizes[6], places[6];
    uint32_t count;
};

static void add_copy(struct copies *copies, graph_buffer from, uint64_t offset, uint64_t size, uint64_t place) {
    if (!from.id) return;
    copies->from[copies->count] = from;
    copies->offsets[copies->count] = offset;
    copies->sizes[copies->count] = size;
    copies->places[copies->count++] = place;
}

static void execute_copies(const struct graph_context *context, const void *data) {
    const struct copies *c = data;
    gpu_copy_image_to_buffer(context->commands, graph_get_image(context, c->picture), graph_get_buffer(context, c->target), 0);
    for (uint32_t i = 0; i < c->count; i++)
        gpu_copy_buffer(context->commands, graph_get_buffer(context, c->from[i]), c->offsets[i],
                        graph_get_buffer(context, c->counts), c->places[i], c->sizes[i]);
}

static void execute_nothing(const struct graph_context *context, const void *data) {
    UNUSED(context);
    UNUSED(data);
}

static graph_image create_image(struct graph *graph, const char *name, VkFormat format) {
    return graph_create_image(
        graph, &(struct graph_image_params){.name = name, .format = format, .width = WIDTH, .height = HEIGHT});
}

static void add_eye(const struct stage *stage, struct graph *graph, struct device_scene_frame *scene, uint32_t number,
                    const fnl_frame *frame, struct eye *eye) {
    fnl_renderer *r = stage->renderer;
    gpu_device *device = harness_device();
    const struct gpu_view previous = eye->view;
    fnl_frame here = *frame;
    fnl_vec3 *at = &here.camera.position;
    *at = vec3_add(*at, vec3_scale(eye->step, 1 + (float)number));
    eye->view = view_from_camera(&here.camera, WIDTH, HEIGHT);
    eye->view.samples = 1;
    struct gpu_frame shared = {.hdr_max = FLT_MAX, .light_scale = 1};
    struct gpu_slice shared_slice = gpu_frame_allocate(device, sizeof shared), slice = gpu_frame_allocate(device, sizeof eye->view);
    assert_non_null(shared_slice.data);
    assert_non_null(slice.data);
    memcpy(shared_slice.data, &shared, sizeof shared);
    eye->view.frame = shared_slice.address;
    memcpy(slice.data, &eye->view, sizeof eye->view);
    const struct lighting scopes = {.lights = scene->lights, .layered = scene->layered, .environment = scene->environment, .view = slice.address};
    struct light_input input = lighting_input(&scopes);
    input.width = WIDTH;
    input.height = HEIGHT;

    struct hierarchy occluders;
    struct geometry_draws draws = occlusion_add(graph, device, &scene->geometry, &eye->view, eye->drawn ? &previous : NULL,
                                                slice.address, 1, &occluders);
    struct clusters_params clusters = {.by_triangle = true,
                                       .full_raster = true,
                                       .samples = 1,
                                       .centers = true,
                                       .cluster_capacity = r->culling.cluster_capacity,
                                       .occluders = &occluders};
    clusters_add(graph, device, &scene->geometry, &eye->view, slice.address, &clusters, &draws);
    graph_image depth = create_image(graph, "depth", GEOMETRY_DEPTH_FORMAT);
    prepass_add(graph, &scene->geometry, &draws, slice.address, depth);

    bool by_items = frame->lists == FNL_LISTS_MESH || frame->lists == FNL_LISTS_BATCHES || frame->lists == FNL_LISTS_MULTIPASS;
    graph_image radiance = create_image(graph, "radiance", VK_FORMAT_R32G32B32A32_SFLOAT);
    struct shade_input shade = {.scene = &scene->geometry,
                                .draws = &draws,
                                .view = slice.address,
                                .width = WIDTH,
                                .height = HEIGHT,
                                .light_count = input.set.local_count,
                                .background = {0.1f, 0.2f, 0.3f}};
    struct gbuffer gbuffer = {0};
    if (!by_items) gbuffer = gbuffer_add(graph, &shade, true, radiance, depth);
    struct lists_fallback fallback_made = {.width = 0};
    struct lists_context c = {.graph = graph,
                              .device = device,
                              .frame = &here,
                              .view = &eye->view,
                              .device_scene = r->device_scene,
                              .scene = &scene->geometry,
                              .draws = &draws,
                              .input = &input,
                              .shared = &eye->shared,
                              .state = &eye->lists,
                              .depth = depth,
                              .gbuffer = by_items ? NULL : &gbuffer,
                              .has_blend = scene->geometry.blend_item_count > 0,
                              .pool_capacity = POOL,
                              .pool_limit = POOL,
                              .fallback = &fallback_made};
    lists_add(&c);
    struct light_list fallback = lists_add_fallback(&c);
    const struct lighting lights = lighting_add(graph, device, &scopes, &c.lights), blend_lights = lighting_add(graph, device, &scopes, &c.blend_lights);
    shade.lighting = &lights;
    if (frame->lists == FNL_LISTS_BATCHES)
        batches_add(graph, &shade, radiance, depth);
    else if (frame->lists == FNL_LISTS_MULTIPASS)
        multipass_add(graph, &shade, input.set.local_count, input.set.directional_count, POOL, radiance, depth);
    else if (by_items)
        forward_add(graph, &shade, GEOMETRY_OPAQUE, true, radiance, depth);
    else
        deferred_add(graph, &shade, &gbuffer, NULL, radiance);
    shade.lighting = &blend_lights;
    forward_add(graph, &shade, GEOMETRY_BLEND, false, radiance, depth);

    struct tonemap_params tonemap = {.tonemap = GPU_TONEMAP_KHRONOS_NEUTRAL, .exposure = exposure_add(graph, &radiance, &depth, 1)};
    struct motion_input motion = {.view = slice.address,
                                  .current = &eye->view,
                                  .previous = eye->drawn ? &previous : NULL,
                                  .depth = depth,
                                  .objects = {.scene = &scene->geometry, .draws = &draws}};
    struct taa_params temporal = {.view = slice.address,
                                  .depth = depth,
                                  .motion = motion_add(graph, device, &motion),
                                  .exposure = tonemap.exposure,
                                  .tonemap = tonemap.tonemap,
                                  .keeps = eye->drawn};
    radiance = taa_add(graph, radiance, &temporal);
    struct morphological_params shapes = {0};
    graph_image mapped = create_image(graph, "color", VK_FORMAT_R8G8B8A8_UNORM);
    tonemap_add(graph, radiance, mapped, &tonemap);
    struct copies copies = {.picture = smaa_add(graph, mlaa_add(graph, mapped, &shapes), &shapes),
                            .target = graph_import_buffer(graph, "picture", &eye->picture),
                            .counts = graph_import_buffer(graph, "counts", &eye->counts)};
    uint64_t last = scene->geometry.item_count * 4ull;
    add_copy(&copies, draws.sums, last, 4, offsetof(struct eye_counts, visible));
    add_copy(&copies, draws.hidden, last, 4, offsetof(struct eye_counts, hidden));
    add_copy(&copies, tonemap.exposure, 0, 8, offsetof(struct eye_counts, exposure));
    add_copy(&copies, c.lights.totals, 0, sizeof(struct light_totals), offsetof(struct eye_counts, lights));
    if (c.blend_lights.totals.id != c.lights.totals.id)
        add_copy(&copies, c.blend_lights.totals, 0, sizeof(struct light_totals), offsetof(struct eye_counts, blend));
    add_copy(&copies, fallback.totals, 0, sizeof(struct light_totals), offsetof(struct eye_counts, fallback));
    memset(eye->counts.mapped, 0, sizeof(struct eye_counts));
    struct graph_pass *pass = graph_add_pass(graph, "read", GRAPH_QUEUE_GRAPHICS, execute_copies, &copies, sizeof copies);
    graph_use_image(pass, copies.picture, GRAPH_COPY_FROM);
    graph_use_buffer(pass, copies.target, GRAPH_COPY_TO);
    graph_use_buffer(pass, copies.counts, GRAPH_COPY_TO);
    for (uint32_t i = 0; i < copies.count; i++) graph_use_buffer(pass, copies.from[i], GRAPH_COPY_FROM);
    struct graph_pass *host = graph_add_pass(graph, "to host", GRAPH_QUEUE_GRAPHICS, execute_nothing, NULL, 0);
    graph_use_buffer(host, copies.target, GRAPH_READ_HOST);
    graph_use_buffer(host, copies.counts, GRAPH_READ_HOST);
    eye->drawn = true;
}

/* Draws the eyes for some frames, in a new graph, and forgets what was kept between frames. */
static void draw_eyes(const struct stage *stage, const fnl_frame *frame, struct eye *eyes, uint32_t count,
                      uint32_t frames, bool scoped) {
    gpu_device *device = harness_device();
    struct graph *graph;
    assert_int_equal(graph_create(gpu_host(device), device, &graph), FNL_OK);
    for (uint32_t i = 0; i < count; i++) {
        lists_init(&eyes[i].lists, gpu_host(device));
        lists_shared_init(&eyes[i].shared, gpu_host(device));
        eyes[i].drawn = false;
        memset(eyes[i].picture.mapped, 0, eyes[i].picture.size);
    }
    for (uint32_t number = 0; number < frames; number++) {
        struct device_scene_frame scene;
        assert_int_equal(gpu_frame_begin(device), FNL_OK);
        graph_begin(graph);
        assert_int_equal(device_scene_add(&stage->renderer->scene_user, graph, &scene), FNL_OK);
        for (uint32_t i = 0; i < count; i++) {
            if (scoped) graph_push_names(graph, eyes[i].name);
            add_eye(stage, graph, &scene, number, frame, &eyes[i]);
            if (scoped) graph_pop_names(graph);
        }
        assert_int_equal(graph_compile(graph), FNL_OK);
        assert_int_equal(graph_execute_frame(graph, NULL), FNL_OK);
    }
    assert_int_equal(gpu_wait_idle(device), FNL_OK);
    for (uint32_t i = 0; i < count; i++) lists_finish(&eyes[i].lists, device);
    for (uint32_t i = 0; i < count; i++) lists_shared_finish(&eyes[i].shared, device);
    graph_destroy(&graph);
}

/* Returns how many items were hidden in both views. */
static uint32_t compare(const char *source, uint32_t scattered, fnl_light_lists first, fnl_light_lists end,
                        uint32_t frames) {
    enum { EYES = 2 };
    uint32_t hidden = 0;
    struct stage stage = stage_open(source, scattered);
    stage.frame.culling = FNL_CULLING_TRIANGLES;
    stage.frame.occlusion = true;
    struct shot shot = stage_shoot(&stage, &stage.frame); /* the scene is on the device, and there is room for its clusters */
    shot_free(&shot);
    struct eye eyes[EYES] = {{.name = "left", .step = {-0.3f, 0, 0}}, {.name = "right", .step = {0.5f, 0.1f, 0}}};
    for (uint32_t i = 0; i < EYES; i++) {
        assert_int_equal(gpu_buffer_create(harness_device(), "picture", WIDTH * HEIGHT * 4, GPU_MEMORY_READBACK, &eyes[i].picture),
                         FNL_OK);
        assert_int_equal(
            gpu_buffer_create(harness_device(), "counts", sizeof(struct eye_counts), GPU_MEMORY_READBACK, &eyes[i].counts),
            FNL_OK);
    }
    uint8_t alone[EYES][WIDTH * HEIGHT * 4];
    struct eye_counts counts[EYES];
    for (uint32_t kind = first; kind < (uint32_t)end; kind++) {
        if (kind == FNL_LISTS_AUTO) continue;
        fnl_frame frame = stage.frame;
        frame.lists = (fnl_light_lists)kind;
        frame.width = WIDTH;
        frame.height = HEIGHT;
        for (uint32_t i = 0; i < EYES; i++) {
            draw_eyes(&stage, &frame, &eyes[i], 1, frames, false);
            memcpy(alone[i], eyes[i].picture.mapped, sizeof alone[i]);
            memcpy(&counts[i], eyes[i].counts.mapped, sizeof counts[i]);
        }
        draw_eyes(&stage, &frame, eyes, EYES, frames, true);
        for (uint32_t i = 0; i < EYES; i++) {
            const struct eye_counts *c = eyes[i].counts.mapped;
            if (memcmp(alone[i], eyes[i].picture.mapped, sizeof alone[i]) != 0)
                fail_msg("lists %u: the %s picture is another one", kind, eyes[i].name);
            if (memcmp(&counts[i], c, sizeof *c) != 0)
                fail_msg("lists %u, %s: %u items, %u hidden, %u lights, %u entries, %u and %u beside; alone %u, %u, %u, %u, %u, %u",
                         kind, eyes[i].name, c->visible, c->hidden, c->lights.in_view, c->lights.entries, c->blend.entries,
                         c->fallback.entries, counts[i].visible, counts[i].hidden, counts[i].lights.in_view,
                         counts[i].lights.entries, counts[i].blend.entries, counts[i].fallback.entries);
            assert_true(c->visible > 0 && c->exposure[0] > 0);
            hidden += c->hidden;
            assert_true(kind == FNL_LISTS_ALL || c->fallback.entries > 0);
        }
        assert_memory_not_equal(alone[0], alone[1], sizeof alone[0]);
    }
    for (uint32_t i = 0; i < EYES; i++) {
        gpu_buffer_destroy(harness_device(), &eyes[i].picture);
        gpu_buffer_destroy(harness_device(), &eyes[i].counts);
    }
    stage_close(&stage);
    print_message("%s: %u items hidden\n", source, hidden);
    return hidden;
}

static void test_two_views_of_all_lists(void **state) {
    UNUSED(state);
    compare("builtin:glass", 120, FNL_LISTS_ALL, FNL_LISTS_COUNT, 1);
}

/* Each view collects samples, and hides items, by its own frame before. */
static void test_two_views_remember_for_themselves(void **state) {
    UNUSED(state);
    assert_true(compare("builtin:city?lights=50&blocks=2", 0, FNL_LISTS_TILED, FNL_LISTS_TILED + 1, 3) > 1000);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test_teardown(test_two_views_of_all_lists, harness_check),
                                       cmocka_unit_test_teardown(test_two_views_remember_for_themselves, harness_check)};
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
