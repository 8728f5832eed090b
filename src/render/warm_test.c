/* SPDX-License-Identifier: MIT */
/* Pipelines that are made before the first frame that needs them. */
#include "fanal/options.h"
#include "fanal/vulkan.h"
#include "render/reflections.h"
#include "tests/render_harness.h"

#include <time.h>

static const struct {
    fnl_shading shading;
    fnl_light_lists lists;
    uint32_t msaa, outputs;
    fnl_antialiasing aa;
    bool count;
    uint32_t views, eyes;
} cases[] = {
    {FNL_SHADING_FORWARD, FNL_LISTS_TILED, 4, FNL_OUTPUT_COLOR, FNL_ANTIALIASING_NONE, false, 0, 0},
    {FNL_SHADING_DEFERRED, FNL_LISTS_CLUSTERED, 1, FNL_OUTPUT_COLOR | FNL_OUTPUT_NORMAL, FNL_ANTIALIASING_SMAA, true, 0, 0},
    {FNL_SHADING_VISIBILITY, FNL_LISTS_BVH, 1, FNL_OUTPUT_RADIANCE, FNL_ANTIALIASING_TAA, false, 0, 0},
    {FNL_SHADING_AUTO, FNL_LISTS_AUTO, 1, FNL_OUTPUT_COLOR, FNL_ANTIALIASING_NONE, false, 0, 0},
    {FNL_SHADING_DEFERRED, FNL_LISTS_TILED, 1, FNL_OUTPUT_COLOR, FNL_ANTIALIASING_NONE, false, 8, 0}, /* 6 at once, and then 2 */
    {FNL_SHADING_DEFERRED, FNL_LISTS_CLUSTERED, 1, FNL_OUTPUT_COLOR, FNL_ANTIALIASING_NONE, false, 2, 2}, /* one list for both */
};

/* After it the first frame makes none; without it, it makes them all. The pictures are the same. */
static void test_the_first_frame_makes_no_pipeline(void **state) {
    UNUSED(state);
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        fnl_image cold_color = {0};
        for (int warm = 0; warm < 2; warm++) {
            fnl_device_params params = fnl_device_params_default();
            params.cache_folder = "";
            params.host = *gpu_host(harness_device());
            fnl_device *device;
            fnl_scene *scene;
            fnl_renderer *renderer;
            assert_int_equal(fnl_device_create(&params, &device), FNL_OK);
            assert_int_equal(scene_load_plain(&params.host, "builtin:spheres?lights=20", NULL, &scene), FNL_OK);
            assert_int_equal(fnl_renderer_create(device, scene, &renderer), FNL_OK);
            fnl_frame frame = frame_plain();
            frame.width = 48;
            frame.height = 27;
            frame.shading = cases[i].shading;
            frame.lists = cases[i].lists;
            frame.msaa = cases[i].msaa;
            frame.outputs = cases[i].outputs;
            frame.aa = cases[i].aa;
            frame.count_lights = cases[i].count;
            const fnl_camera cameras[8] = {frame.camera, frame.camera, frame.camera, frame.camera,
                                           frame.camera, frame.camera, frame.camera, frame.camera};
            frame.views = cameras;
            frame.view_count = cases[i].views;
            frame.multiview = cases[i].eyes ? FNL_MULTIVIEW_AUTO : FNL_MULTIVIEW_ON;
            frame.stereo.eyes = cases[i].eyes;
            fnl_frame_stats stats;
            if (warm) {
                uint32_t pending = 99;
                fnl_frame other = frame; /* size and camera do not count */
                other.width = 96;
                other.camera.position.x += 1;
                assert_int_equal(fnl_renderer_warm(renderer, &other, NULL, true, &pending), FNL_OK);
                assert_int_equal(pending, 0);
                assert_true(gpu_pipeline_stats(device).made > 10);
                assert_int_equal(gpu_pipeline_stats(device).late, 0);
            }
            uint64_t made = gpu_pipeline_stats(device).made;
            assert_int_equal(fnl_renderer_render(renderer, &frame), FNL_OK);
            assert_int_equal(fnl_renderer_query_stats(renderer, &stats), FNL_OK);
            if (warm) {
                assert_int_equal(stats.pipelines_made, 0);
                assert_int_equal(stats.pipelines_total, made);
            } else
                assert_true(stats.pipelines_made > 10);
            if (frame.outputs & FNL_OUTPUT_COLOR) {
                fnl_image color;
                assert_int_equal(fnl_renderer_read(renderer, FNL_OUTPUT_COLOR, &color), FNL_OK);
                if (warm) {
                    assert_int_equal(count_differing(&cold_color, &color), 0);
                    fnl_image_free(&params.host, &cold_color);
                    fnl_image_free(&params.host, &color);
                } else
                    cold_color = color;
            }
            fnl_renderer_destroy(&renderer);
            fnl_scene_destroy(&scene);
            fnl_device_destroy(&device);
        }
    }
}

/* After it no frame makes a pipeline, in the background either, and nothing of the scene is uploaded. */
static void test_frames_after_it_make_and_upload_nothing(void **state) {
    UNUSED(state);
    static const struct {
        const char *scene;
        fnl_shading shading;
        fnl_light_lists lists;
        uint32_t msaa;
        fnl_antialiasing aa;
        fnl_shadows shadows;
    } all[] = {
        {"builtin:spheres?lights=4", FNL_SHADING_DEFERRED, FNL_LISTS_AUTO, 1, FNL_ANTIALIASING_NONE, FNL_SHADOWS_OFF},
        {"builtin:spheres?lights=4", FNL_SHADING_AUTO, FNL_LISTS_CLUSTERED, 1, FNL_ANTIALIASING_NONE, FNL_SHADOWS_OFF},
        {"builtin:spheres?lights=4", FNL_SHADING_DEFERRED, FNL_LISTS_CLUSTERED, 1, FNL_ANTIALIASING_NONE, FNL_SHADOWS_HYBRID}, /* times rays in its third frame */
        {"builtin:spheres?lights=0", FNL_SHADING_FORWARD_PREPASS, FNL_LISTS_AUTO, 4, FNL_ANTIALIASING_NONE, FNL_SHADOWS_MAPS},
        {"builtin:room?lights=4", FNL_SHADING_FORWARD_PREPASS, FNL_LISTS_TILED, 4, FNL_ANTIALIASING_SMAA, FNL_SHADOWS_MAPS},
        {"builtin:spheres?lights=20", FNL_SHADING_VISIBILITY, FNL_LISTS_CLUSTERED, 1, FNL_ANTIALIASING_TAA, FNL_SHADOWS_SAMPLED},
    };
    for (size_t i = 0; i < COUNT_OF(all); i++) {
        fnl_device_params params = fnl_device_params_default();
        params.cache_folder = "";
        params.host = *gpu_host(harness_device());
        fnl_device *device;
        fnl_scene *scene;
        fnl_renderer *renderer;
        assert_int_equal(fnl_device_create(&params, &device), FNL_OK);
        assert_int_equal(scene_load_plain(&params.host, all[i].scene, NULL, &scene), FNL_OK);
        assert_int_equal(fnl_renderer_create(device, scene, &renderer), FNL_OK);
        fnl_frame frame = frame_plain();
        frame.width = 48;
        frame.height = 27;
        frame.shading = all[i].shading;
        frame.lists = all[i].lists;
        frame.msaa = all[i].msaa;
        frame.aa = all[i].aa;
        frame.shadows = all[i].shadows;
        assert_int_equal(fnl_renderer_warm(renderer, &frame, NULL, true, NULL), FNL_OK);
        const uint64_t bytes = renderer->device_scene->bytes_uploaded;
        const struct gpu_pipeline_stats warm = gpu_pipeline_stats(device);
        assert_true(bytes > 0 && warm.made > (strstr(all[i].scene, "lights=0") ? 6u : 10u));
        assert_int_equal(warm.done, warm.asked);
        for (int k = 0; k < 4; k++) {
            fnl_frame_stats stats;
            assert_int_equal(fnl_renderer_render(renderer, &frame), FNL_OK);
            assert_int_equal(fnl_renderer_query_stats(renderer, &stats), FNL_OK);
            assert_int_equal(stats.pipelines_made, 0);
            assert_int_equal(stats.pipelines_total, warm.made);
            assert_int_equal(gpu_pipeline_stats(device).asked, warm.asked);
            assert_int_equal(renderer->device_scene->bytes_uploaded, bytes);
        }
        fnl_renderer_destroy(&renderer);
        fnl_scene_destroy(&scene);
        fnl_device_destroy(&device);
    }
}

/* Asked again and again it says how much is missing, and in the end nothing. */
static void test_in_the_background(void **state) {
    UNUSED(state);
    struct stage s = stage_open("builtin:spheres?lights=20", 0);
    fnl_device *device = harness_device();
    fnl_frame frame = s.frame;
    frame.shading = FNL_SHADING_DAIS;
    uint32_t pending, first;
    assert_int_equal(fnl_renderer_warm(s.renderer, &frame, NULL, false, &first), FNL_OK);
    assert_true(first > 5);
    uint64_t asked = gpu_pipeline_stats(device).asked;
    do {
        assert_int_equal(fnl_renderer_warm(s.renderer, &frame, NULL, false, &pending), FNL_OK);
        assert_true(pending <= first);
        nanosleep(&(struct timespec){.tv_nsec = 2000000}, NULL);
    } while (pending);
    assert_int_equal(gpu_pipeline_stats(device).asked, asked); /* nothing stands in line twice */
    struct shot shot = stage_shoot(&s, &frame);
    assert_int_equal(shot.stats.pipelines_made, 0);
    shot_free(&shot);
    stage_close(&s);
}

/* Pictures for a caller's image take other pipelines. */
static void test_for_a_target(void **state) {
    UNUSED(state);
    struct stage s = stage_open("builtin:spheres?lights=20", 0);
    fnl_frame frame = s.frame;
    fnl_vulkan_target linear = {.format = VK_FORMAT_R16G16B16A16_SFLOAT, .final_layout = VK_IMAGE_LAYOUT_GENERAL},
                      wrong = {.format = VK_FORMAT_R8_UNORM};
    uint32_t pending;
    frame.shading = FNL_SHADING_MOBILE; /* which tone maps in its scope */
    frame.outputs = FNL_OUTPUT_COLOR;
    assert_int_equal(fnl_renderer_warm(s.renderer, &frame, NULL, true, NULL), FNL_OK);
    assert_int_equal(fnl_renderer_warm(s.renderer, &frame, NULL, false, &pending), FNL_OK);
    assert_int_equal(pending, 0);
    uint64_t asked = gpu_pipeline_stats(harness_device()).asked;
    assert_int_equal(fnl_renderer_warm(s.renderer, &frame, &linear, true, NULL), FNL_OK);
    assert_true(gpu_pipeline_stats(harness_device()).asked > asked);
    assert_int_equal(fnl_renderer_warm(s.renderer, &frame, &wrong, true, NULL), FNL_ERROR_UNSUPPORTED);
    struct gpu_image image;
    struct gpu_image_params params = {"target", linear.format, frame.width, frame.height, 1, 1, 1, false, false,
                                      VK_IMAGE_USAGE_TRANSFER_DST_BIT, GPU_USE_OTHER};
    assert_int_equal(gpu_image_create(harness_device(), &params, &image), FNL_OK);
    linear.image = image.handle;
    fnl_frame_stats stats;
    assert_int_equal(fnl_renderer_render_to(s.renderer, &frame, &linear), FNL_OK);
    assert_int_equal(fnl_renderer_query_stats(s.renderer, &stats), FNL_OK);
    assert_int_equal(stats.pipelines_made, 0);
    gpu_image_destroy(harness_device(), &image);
    stage_close(&s);
}

/* The results of the last frame can still be read, its stats too, and the next frame goes on from it. */
static void test_the_last_frame_stays(void **state) {
    UNUSED(state);
    struct stage s = stage_open("builtin:spheres?lights=20", 0), t = stage_open("builtin:spheres?lights=20", 0);
    s.frame.aa = t.frame.aa = FNL_ANTIALIASING_TAA;
    s.frame.count_lights = t.frame.count_lights = true;
    fnl_frame other = frame_plain();
    other.width = 3 * s.frame.width;
    other.height = 2 * s.frame.height;
    other.shading = FNL_SHADING_DEFERRED;
    other.lists = FNL_LISTS_CLUSTERED;
    other.count_lights = true;
    other.outputs = s.frame.outputs;
    for (int i = 0; i < 3; i++) {
        fnl_image a, b;
        fnl_frame_stats of_a, of_b;
        assert_int_equal(fnl_renderer_render(s.renderer, &s.frame), FNL_OK);
        assert_int_equal(fnl_renderer_render(t.renderer, &t.frame), FNL_OK);
        assert_int_equal(fnl_renderer_warm(s.renderer, &other, NULL, false, NULL), FNL_OK);
        assert_int_equal(fnl_renderer_query_stats(s.renderer, &of_a), FNL_OK);
        assert_int_equal(fnl_renderer_query_stats(t.renderer, &of_b), FNL_OK);
        assert_int_equal(of_a.list_bytes, of_b.list_bytes);
        assert_int_equal(of_a.list_entries, of_b.list_entries);
        assert_int_equal(of_a.evaluations, of_b.evaluations);
        assert_int_equal(of_a.lights_in_view, of_b.lights_in_view);
        assert_int_equal(of_a.shading, s.frame.shading);
        assert_int_equal(fnl_renderer_read(s.renderer, FNL_OUTPUT_COLOR, &a), FNL_OK);
        assert_int_equal(fnl_renderer_read(t.renderer, FNL_OUTPUT_COLOR, &b), FNL_OK);
        assert_int_equal(count_differing(&a, &b), 0);
        fnl_image_free(gpu_host(harness_device()), &a);
        fnl_image_free(gpu_host(harness_device()), &b);
    }
    stage_close(&s);
    stage_close(&t);
}

/* ---- what dry declarations leave alone ---- */

/* All that a renderer keeps, as bytes. */
struct kept {
    unsigned char *bytes;
    size_t size;
};

static void keep(struct kept *k, const void *data, size_t size) {
    k->bytes = realloc(k->bytes, k->size + size + 1);
    assert_non_null(k->bytes);
    if (size) memcpy(k->bytes + k->size, data, size);
    k->size += size;
}

static struct kept kept_by(const fnl_renderer *r) {
    struct kept k = {0};
    keep(&k, r, sizeof *r);
    keep(&k, r->views.data, r->views.count * sizeof *r->views.data);
    keep(&k, r->lists.views.data, r->lists.views.count * sizeof *r->lists.views.data);
    keep(&k, r->last.data, r->views.count * sizeof *r->last.data);
    keep(&k, r->probes.list.data, r->probes.list.count * sizeof *r->probes.list.data);
    keep(&k, r->reflections.list.data, r->reflections.list.count * sizeof *r->reflections.list.data);
    return k;
}

/* Declaring a frame only for its pipelines changes no state that later frames depend on. */
static void test_dry_declarations_leave_no_trace(void **state) {
    UNUSED(state);
    static const struct {
        const char *scene, *options[6];
    } all[] = {
        {"builtin:glass?lights=9", {"shading=deferred", "lists=tiled", "shadows=maps", "shadow.classify=on"}},
        {"builtin:glass?lights=9", {"shading=forward", "lists=tree", "shadows=hybrid", "transparency=linked"}},
        {"builtin:spheres?lights=9", {"shading=deferred", "lists=clustered-cpu", "shadows=sampled", "shadow.denoise=on", "shadow.guide=on"}},
        {"builtin:room?lights=9", {"shading=deferred", "lists=world", "shadows=cubemap", "aa=taa"}},
        {"builtin:spheres?lights=9", {"shading=visibility", "lists=raster", "shadows=rays", "occlusion=on"}},
        {"builtin:spheres?lights=9", {"shading=dais", "lists=grid2d", "culling=triangles"}},
        {"builtin:spheres?lights=9", {"shading=virtual-texturing", "lists=bvh"}},
        {"builtin:spheres?lights=9", {"shading=mobile", "lists=clustered"}},
        {"builtin:glass?lights=9", {"shading=forward-prepass", "lists=multipass", "msaa=4"}},
    };
    for (size_t i = 0; i < COUNT_OF(all); i++) {
        struct stage s = stage_open(all[i].scene, 0);
        fnl_probe_params probe = fnl_probe_params_default();
        probe.half_size = (fnl_vec3){0.5f, 0.5f, 0.5f};
        probe.reflection = strstr(all[i].options[0], "deferred");
        assert_int_equal(fnl_scene_add_probe(s.scene, &probe, &(fnl_probe_id){0}), FNL_OK);
        for (int k = 0; k < 6 && all[i].options[k]; k++) {
            char key[64];
            snprintf(key, sizeof key, "%s", all[i].options[k]);
            char *value = strchr(key, '=');
            *value++ = 0;
            assert_int_equal(fnl_frame_set(NULL, &s.frame, key, value), FNL_OK);
        }
        /* Once for what is prepared, then for what the frame after a first one does otherwise. */
        for (int frame = 0; frame < 3; frame++) {
            assert_int_equal(fnl_renderer_warm(s.renderer, &s.frame, NULL, true, NULL), FNL_OK);
            if (frame == 0) assert_false(s.renderer->notes.mesh_lists);
            struct shot shot = stage_shoot(&s, &s.frame);
            assert_true(s.renderer->notes.mesh_lists == (s.frame.lists == FNL_LISTS_MULTIPASS));
            shot_free(&shot);
            fnl_frame settled = s.frame;
            uint64_t ticket;
            assert_int_equal(renderer_settle(s.renderer, &settled), FNL_OK);
            assert_int_equal(gpu_frame_begin(harness_device()), FNL_OK);
            const struct kept before = kept_by(s.renderer);
            assert_int_equal(renderer_ask_pipelines(s.renderer, &settled, NULL, &ticket), FNL_OK);
            const struct kept after = kept_by(s.renderer);
            assert_int_equal(before.size, after.size);
            for (size_t at = 0; at < before.size; at++)
                if (before.bytes[at] != after.bytes[at]) fail_msg("%s, case %zu, after frame %d: byte %zu of what the renderer keeps changes", all[i].scene, i, frame, at);
            free(before.bytes);
            free(after.bytes);
            assert_int_equal(gpu_frame_end(harness_device(), NULL, 0, NULL), FNL_OK);
        }
        stage_close(&s);
    }
}

/* Capturing a probe renders frames with a separate renderer: the frame's own renderer changes only what it keeps of reflection probes. */
static void test_captures_change_nothing_else(void **state) {
    UNUSED(state);
    struct stage s = stage_open("builtin:room?lights=9", 0);
    fnl_probe_params probe = fnl_probe_params_default();
    fnl_probe_id id;
    probe.half_size = (fnl_vec3){2, 2, 2};
    probe.reflection = true;
    s.frame.shadows = FNL_SHADOWS_MAPS;
    s.frame.aa = FNL_ANTIALIASING_TAA;
    assert_int_equal(fnl_scene_add_probe(s.scene, &probe, &id), FNL_OK);
    struct shot shot = stage_shoot(&s, &s.frame);
    shot_free(&shot);
    for (int i = 0; i < 2; i++) {
        probe.capture.x = 0.1f * (float)(i + 1);
        assert_int_equal(fnl_scene_set_probe(s.scene, id, &probe), FNL_OK);
        fnl_frame settled = s.frame;
        assert_int_equal(renderer_settle(s.renderer, &settled), FNL_OK);
        const struct renderer_reflections reflections = s.renderer->reflections;
        s.renderer->reflections = (struct renderer_reflections){0}; /* for the comparison */
        const struct kept before = kept_by(s.renderer);
        s.renderer->reflections = reflections;
        assert_int_equal(reflections_capture(s.renderer, &settled), FNL_OK);
        assert_int_equal(s.renderer->reflections.captures, 1);
        const struct renderer_reflections captured = s.renderer->reflections;
        s.renderer->reflections = (struct renderer_reflections){0};
        const struct kept after = kept_by(s.renderer);
        s.renderer->reflections = captured;
        assert_int_equal(before.size, after.size);
        assert_memory_equal(before.bytes, after.bytes, before.size);
        free(before.bytes);
        free(after.bytes);
    }
    stage_close(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_the_first_frame_makes_no_pipeline, harness_check),
        cmocka_unit_test_teardown(test_frames_after_it_make_and_upload_nothing, harness_check),
        cmocka_unit_test_teardown(test_in_the_background, harness_check),
        cmocka_unit_test_teardown(test_for_a_target, harness_check),
        cmocka_unit_test_teardown(test_the_last_frame_stays, harness_check),
        cmocka_unit_test_teardown(test_dry_declarations_leave_no_trace, harness_check),
        cmocka_unit_test_teardown(test_captures_change_nothing_else, harness_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
