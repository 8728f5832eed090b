/* SPDX-License-Identifier: MIT */
/* Shadow rays through the device's own acceleration structures: the picture is that of the trees, and each frame does no more than it must. */
#include "tests/render_harness.h"
#include "tests/shadow_cases.h"

#include "lighting/lighting_shared.h"
#include "render/renderer_internal.h"

static bool has_queries(void) { return gpu_info(harness_device())->ray_query; }

static void use(struct stage *s, fnl_ray_backend backend) {
    s->frame.width = 64, s->frame.height = 36;
    s->frame.shadows = FNL_SHADOWS_RAYS;
    s->frame.shadow.ray_backend = backend;
}

/* Pixels that differ: rays that meet the edge of a triangle, of which the device thinks otherwise. */
static void expect_same(struct stage *s, const char *what, uint64_t most) {
    use(s, FNL_RAY_BACKEND_BVH);
    struct shot trees = stage_shoot(s, &s->frame);
    assert_false(has_counter(&trees.stats, "shadows.instances"));
    use(s, FNL_RAY_BACKEND_RAY_QUERY);
    struct shot queries = stage_shoot(s, &s->frame);
    assert_true(has_counter(&queries.stats, "shadows.instances"));
    s->frame.shadows = FNL_SHADOWS_OFF;
    struct shot none = stage_shoot(s, &s->frame);
    const uint64_t differing = count_differing(&trees.radiance, &queries.radiance), shadowed = count_differing(&trees.radiance, &none.radiance);
    print_message("%s: %u of %u shadowed pixels differ\n", what, (uint32_t)differing, (uint32_t)shadowed);
    if (differing > most || shadowed < 10) fail_msg("%s: %u pixels differ, %u at most may", what, (uint32_t)differing, (uint32_t)most);
    shot_free(&trees);
    shot_free(&queries);
    shot_free(&none);
}

static void test_pictures_are_those_of_the_trees(void **state) {
    UNUSED(state);
    if (!has_queries()) skip();
    struct stage s = stage_open("builtin:hall?lights=96", 0); /* cutouts, a sun, many instances, in compute shaders */
    s.frame.shading = FNL_SHADING_DEFERRED;
    expect_same(&s, "hall", 4);
    stage_close(&s);
    s = stage_open("builtin:glass?lights=24&crossing=1", 0); /* what lets a part through, in fragment shaders */
    s.frame.shading = FNL_SHADING_FORWARD;
    expect_same(&s, "glass", 2);
    stage_close(&s);
    s = stage_open("Fox.glb", 20);
    s.frame.shading = FNL_SHADING_DEFERRED;
    expect_same(&s, "Fox", 2);
    assert_int_equal(fnl_scene_set_time(s.scene, 0, 0.4), FNL_OK);
    expect_same(&s, "Fox in another pose", 2);
    stage_close(&s);
}

/* Fragments that are discarded walk on where they are neighbours of others. */
static void test_cutouts_in_forward_shading(void **state) {
    UNUSED(state);
    if (!has_queries()) skip();
    struct stage s = stage_open("builtin:hall?lights=64", 0);
    s.frame.shading = FNL_SHADING_FORWARD;
    expect_same(&s, "hall, forward", 4);
    stage_close(&s);
}

/* What a frame does. */
struct work {
    uint64_t built, refitted, compacted, bytes;
};

static struct work work(struct stage *s) {
    use(s, FNL_RAY_BACKEND_RAY_QUERY);
    assert_int_equal(fnl_renderer_render(s->renderer, &s->frame), FNL_OK);
    const fnl_frame_stats stats = harness_stats(s->renderer);
    return (struct work){counter(&stats, "shadows.structures-built"), counter(&stats, "shadows.structures-refitted"),
                         counter(&stats, "shadows.structures-compacted"), counter(&stats, "shadows.structure-bytes")};
}

static void expect(struct stage *s, uint64_t built, uint64_t refitted) {
    const struct work w = work(s);
    if (w.built != built || w.refitted != refitted || w.compacted != 0)
        fail_msg("%u built, %u refitted, %u compacted; expected %u and %u", (uint32_t)w.built, (uint32_t)w.refitted, (uint32_t)w.compacted,
                 (uint32_t)built, (uint32_t)refitted);
}

/* Frames of a still scene build nothing but, once, the structure over the instances of what was compacted. Returns how many were. */
static uint64_t settle(struct stage *s) {
    uint64_t compacted = 0, built = 0;
    for (uint32_t i = 0; i < 2 * GPU_FRAMES_IN_FLIGHT + 2; i++) {
        const struct work w = work(s);
        compacted += w.compacted;
        built += w.built;
        assert_int_equal(w.refitted, 0);
        assert_int_equal(w.built, w.compacted > 0);
    }
    assert_true(built <= 1);
    expect(s, 0, 0);
    return compacted;
}

/* As if a structure had been measured: Mesa's CPU driver says of all that nothing can be gained. */
static void expect_compaction(struct stage *s) {
    struct device_structures *structures = &s->renderer->device_scene->structures;
    struct device_structure *row = structures->rows.data;
    while (!row->made.handle) row++;
    const uint64_t before = work(s).bytes;
    const VkDeviceAddress address = row->made.address;
    assert_true(row->measured);
    assert_int_equal(gpu_structure_create(harness_device(), "smaller", false, row->made.buffer.size, &row->smaller), FNL_OK);
    structures->copies = 1;
    structures->structure = UINT64_MAX; /* addresses are sent anew */
    const struct work w = work(s);
    assert_true(w.compacted == 1 && w.built == 1 && w.refitted == 0);
    expect(s, 0, 0);
    for (row = structures->rows.data; !row->made.handle;) row++;
    assert_true(row->made.address != address && !row->smaller.handle);
    settle(s);
    assert_int_equal(work(s).bytes, before); /* what it was made of is gone */
    expect_same(s, "compacted", 0);
}

static void test_structures_are_built_when_something_changes(void **state) {
    UNUSED(state);
    if (!has_queries()) skip();
    fnl_scene *scene = shadow_floor();
    fnl_material_params material = matt(1);
    fnl_mesh_id mesh = add_square_mesh(scene, add_material(scene, &material));
    fnl_instance_id instance = add_instance(scene, mesh, mat4_translation((vec3){0, 1, 0}));
    struct stage s = stage_open_scene(scene);
    s.frame.shading = FNL_SHADING_DEFERRED;
    const struct device_structures *structures = NULL;
    use(&s, FNL_RAY_BACKEND_AUTO);
    assert_int_equal(fnl_renderer_render(s.renderer, &s.frame), FNL_OK);
    structures = &s.renderer->device_scene->structures;
    if (gpu_info(harness_device())->type == FNL_DEVICE_CPU) assert_int_equal(structures->rows.count, 0);
    expect(&s, 3, 0); /* two squares and what is over them */
    assert_int_equal(counter_of(s.renderer, "shadows.instances"), 2);
    settle(&s);
    s.frame.camera.position.x += 1;
    expect(&s, 0, 0);
    mat4 moved = mat4_translation((vec3){1, 1, 0});
    assert_int_equal(fnl_scene_set_instance_transform(scene, instance, &moved), FNL_OK);
    expect(&s, 1, 0);
    expect(&s, 0, 0);
    add_instance(scene, mesh, mat4_translation((vec3){3, 1, 0}));
    expect(&s, 1, 0);
    const uint64_t before = work(&s).bytes;
    mesh = add_square_mesh(scene, add_material(scene, &material));
    instance = add_instance(scene, mesh, mat4_translation((vec3){-3, 1, 0}));
    const uint64_t scratch = structures->rows.data[0].build_scratch;
    expect(&s, 2, 0); /* what was there stays, and knows what it takes to build it */
    assert_true(scratch > 0);
    for (uint32_t i = 0; i < structures->rows.count; i++)
        if (structures->rows.data[i].made.handle) assert_int_equal(structures->rows.data[i].build_scratch, scratch); /* all are squares */
    settle(&s);
    expect_same(&s, "squares", 0);
    const uint64_t most = work(&s).bytes;
    assert_true(most > before);
    assert_int_equal(fnl_scene_remove_instance(scene, instance), FNL_OK);
    expect(&s, 1, 0);
    settle(&s);
    assert_true(work(&s).bytes < most); /* the mesh that nothing shows has none */
    expect_same(&s, "squares, one gone", 0);
    expect_compaction(&s);
    device_scene_forget(s.renderer->device_scene); /* as after an error: everything comes anew */
    expect(&s, 3, 0);
    stage_close(&s);
    assert_int_equal(gpu_wait_idle(harness_device()), FNL_OK);
    assert_int_equal(gpu_memory_stats(harness_device()).structure_bytes, 0);
}

/* A frame that is declared for its pipelines alone leaves the next one all its work. */
static void test_frames_that_are_not_submitted_build_nothing(void **state) {
    UNUSED(state);
    if (!has_queries()) skip();
    struct stage s = stage_open_scene(shadow_floor());
    s.frame.shading = FNL_SHADING_DEFERRED;
    use(&s, FNL_RAY_BACKEND_RAY_QUERY);
    assert_int_equal(fnl_renderer_warm(s.renderer, &s.frame, NULL, true, NULL), FNL_OK);
    expect(&s, 2, 0);
    settle(&s);
    stage_close(&s);
}

static void test_what_deforms_is_refitted(void **state) {
    UNUSED(state);
    if (!has_queries()) skip();
    enum { FRAMES = 34 };
    struct stage s = stage_open("Fox.glb", 1);
    s.frame.shading = FNL_SHADING_DEFERRED;
    fnl_material_params material = matt(1);
    add_square(s.scene, &material, (vec3){100, 1, 100}, (vec3){0, 0, 0}); /* which does not deform */
    expect(&s, 3, 0);
    settle(&s);
    uint64_t built = 0, refitted = 0;
    for (int i = 0; i < FRAMES; i++) {
        assert_int_equal(fnl_scene_set_time(s.scene, 0, 0.01 * (i + 1)), FNL_OK);
        const struct work w = work(&s);
        assert_int_equal(w.built + w.refitted, 2); /* the fox, and what is over both */
        built += w.built;
        refitted += w.refitted;
    }
    assert_int_equal(built, FRAMES + 1); /* one of 33 is built anew */
    assert_int_equal(refitted, FRAMES - 1);
    expect(&s, 0, 0);
    expect_same(&s, "Fox, refitted", 2);
    stage_close(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_pictures_are_those_of_the_trees, harness_check),
        cmocka_unit_test_teardown(test_cutouts_in_forward_shading, harness_check),
        cmocka_unit_test_teardown(test_structures_are_built_when_something_changes, harness_check),
        cmocka_unit_test_teardown(test_frames_that_are_not_submitted_build_nothing, harness_check),
        cmocka_unit_test_teardown(test_what_deforms_is_refitted, harness_check),
    };
    return cmocka_run_group_tests_name("ray_query", tests, harness_begin, harness_end);
}
