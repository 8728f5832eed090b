/* SPDX-License-Identifier: MIT */
/** What the frame graph says that a frame moves, against what Vulkan was told: load and store operations, barriers. */
#include "graph/graph_internal.h"
#include "tests/render_harness.h"
#include "tests/vulkan_spy.h"

static int begin(void **state) {
    if (harness_begin(state) != 0) return -1;
    spy_begin(harness_device());
    return 0;
}

static int end(void **state) {
    spy_end();
    return harness_end(state);
}

static const struct graph_resource *resource_of(const struct graph *graph, VkImage image) {
    for (uint32_t i = 0; i < graph->resources.count; i++) {
        const struct graph_resource *resource = &graph->resources.data[i];
        if (resource->is_image && resource->image && resource->image->handle == image && resource->first_use) return resource;
    }
    return NULL;
}

static uint32_t compare_rows(const struct graph *graph, const char *what) {
    static struct graph_traffic rows[512];
    uint32_t count = graph_query_traffic(graph, rows, COUNT_OF(rows)), at = 0;
    assert_true(count <= COUNT_OF(rows));
    for (uint32_t i = 0; i < count; i++) {
        if (!rows[i].attachment) continue;
        assert_true(at < spy.attachment_count);
        const struct spy_attachment *real = &spy.attachments[at++];
        if (strcmp(real->name, rows[i].image) || real->format != rows[i].format || real->load != rows[i].load ||
            (!real->is_resolve && real->store != rows[i].store) || spy_loaded(real) != rows[i].bytes_read ||
            spy_stored(real) != rows[i].bytes_written || real->is_transient != rows[i].transient)
            fail_msg("%s, '%s' of '%s' has load %d, store %d, %llu bytes loaded, %llu stored%s; declared are '%s', %d, %d, "
                     "%llu, %llu%s",
                     what, real->name, real->label, (int)real->load, (int)real->store,
                     (unsigned long long)spy_loaded(real), (unsigned long long)spy_stored(real),
                     real->is_transient ? ", transient" : "", rows[i].image, (int)rows[i].load, (int)rows[i].store,
                     (unsigned long long)rows[i].bytes_read, (unsigned long long)rows[i].bytes_written,
                     rows[i].transient ? ", transient" : "");
    }
    assert_int_equal(at, spy.attachment_count);
    return at;
}

/* Nothing is stored that the frame does not use again or that does not outlive it, and all else is. */
static uint32_t check_stores(const struct graph *graph, const char *what) {
    uint32_t discarded = 0;
    for (uint32_t i = 0; i < spy.attachment_count; i++) {
        const struct spy_attachment *real = &spy.attachments[i];
        const struct graph_resource *resource = resource_of(graph, real->image);
        assert_non_null(resource);
        bool outlives = resource->imported || resource->role != GRAPH_HISTORY_NONE;
        if (spy_stored(real) && !real->is_used && !outlives)
            fail_msg("%s stores '%s' after '%s' for nobody", what, real->name, real->label);
        if (spy_discarded(real) && (real->is_used || outlives))
            fail_msg("%s discards '%s' after '%s', which is needed", what, real->name, real->label);
        discarded += spy_discarded(real) > 0;
    }
    return discarded;
}

static void check_barriers(const struct graph *graph) {
    uint32_t images = 0, memories = 0, calls = 0; /* nothing but what the plan says: no barrier for the frame as a whole */
    for (uint32_t i = 0; i < graph->plan.step_count + graph->plan.batch_count; i++) {
        const struct graph_barriers *barriers = i < graph->plan.step_count
                                                    ? &graph->plan.steps[i].before
                                                    : &graph->plan.batches[i - graph->plan.step_count].after;
        uint32_t own = 0;
        for (const struct graph_barrier *b = barriers->first; b; b = b->next) own++;
        images += own;
        memories += barriers->from_stages != 0;
        calls += DIVIDE_UP(MAX(own, (uint32_t)(barriers->from_stages != 0)), 16u);
    }
    assert_int_equal(spy.image_barriers, images);
    assert_int_equal(spy.memory_barriers, memories);
    assert_int_equal(spy.barrier_calls, calls);
    assert_int_equal(graph_query_stats(graph).barrier_count, images + memories);
}

/* Draw calls of the scene's objects: indirect ones, except those of light volumes. */
static uint32_t draws_of_objects(void) {
    uint32_t count = 0;
    for (uint32_t i = 0; i < spy.work_count; i++) {
        const char *label = spy.work[i].label;
        const bool of_lights = strstr(label, "volumes") || strcmp(label, "light ids") == 0 || strcmp(label, "light layer") == 0 || strncmp(label, "light layer ", 12) == 0;
        count += spy_graphics_params(spy.work[i].pipeline) && spy.work[i].indirect && !of_lights;
    }
    return count;
}

static void varnish(fnl_scene *scene) {
    fnl_entity_info entity;
    fnl_material_params params;
    assert_int_equal(fnl_scene_query_entity(scene, FNL_ENTITY_MATERIAL, 0, &entity), FNL_OK);
    assert_int_equal(fnl_scene_query_material(scene, 0, &params), FNL_OK);
    params.clearcoat.strength = 1;
    assert_int_equal(fnl_scene_set_material(scene, entity.id.material, &params), FNL_OK);
}

struct setup {
    const char *source;
    bool varnished; /* some surfaces have a layer, which G-buffers do not hold */
};

/* With glass and without: where nothing is drawn behind it, depth need not be kept. */
static void test_orders(void **state) {
    const struct setup *setup = *state;
    struct stage stage = stage_open(setup->source, 0);
    const bool glass = strstr(setup->source, "glass");
    if (setup->varnished) varnish(stage.scene);
    harness_hooks(stage.renderer)->poison = false; /* its barriers are not the plan's */
    stage.frame.record_threads = 1;
    stage.frame.width = 75;
    stage.frame.height = 53;
    stage.frame.outputs = FNL_OUTPUT_COLOR;
    for (int shading = 0; shading < FNL_SHADING_AUTO; shading++)
        for (uint32_t samples = 1; samples <= 4; samples += 3) {
            fnl_frame frame = stage.frame;
            frame.shading = (fnl_shading)shading;
            frame.msaa = samples;
            frame.visibility.barycentrics = shading == FNL_SHADING_VISIBILITY && samples == 1;
            if (!fnl_shading_supports(frame.shading, FNL_LISTS_AUTO, samples)) continue;
            if (glass && shading % 5) continue; /* a few will do */
            if (!fnl_shading_supports(frame.shading, frame.lists, samples)) frame.lists = FNL_LISTS_ALL;
            char what[64];
            snprintf(what, sizeof what, "%s, %u samples", fnl_value_name(FNL_ENUM_SHADING, frame.shading), samples);
            spy_clear();
            struct shot first = stage_shoot(&stage, &frame); /* uploads have barriers of their own, and atlases are filled */
            assert_int_equal(first.stats.draws, draws_of_objects());
            shot_free(&first);
            spy_clear();
            struct shot shot = stage_shoot(&stage, &frame);
            const struct graph *graph = stage.renderer->graph;
            uint32_t attachments = compare_rows(graph, what), discarded = check_stores(graph, what);
            assert_int_equal(shot.stats.draws, draws_of_objects());
            if (shading != FNL_SHADING_MOBILE) check_barriers(graph); /* there are barriers inside the scope as well */
            print_message("%s: %u attachments, %u discarded; %llu bytes loaded, %llu stored, %llu discarded; %u barriers\n",
                          what, attachments, discarded, (unsigned long long)spy_sum(spy_loaded),
                          (unsigned long long)spy_sum(spy_stored), (unsigned long long)spy_sum(spy_discarded),
                          spy.image_barriers + spy.memory_barriers);
            shot_free(&shot);
        }
    stage_close(&stage);
}

int main(void) {
    static struct setup setups[] = {{"builtin:glass?lights=9", false}, {"builtin:spheres?lights=9", false}, {"builtin:spheres?lights=9", true}};
    const struct CMUnitTest tests[] = {
        {"orders, glass", test_orders, NULL, harness_check, &setups[0]},
        {"orders, nothing transparent", test_orders, NULL, harness_check, &setups[1]},
        {"orders, varnish", test_orders, NULL, harness_check, &setups[2]},
    };
    return cmocka_run_group_tests_name("traffic", tests, begin, end);
}
