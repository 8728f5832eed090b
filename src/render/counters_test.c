/* SPDX-License-Identifier: MIT */
/** The rows of the techniques' numbers, and which frames have which. */
#include "fanal/options.h"
#include "render/orders/order.h"
#include "tests/render_test.h"

enum { ROWS_MAX = 128 };

/* "dais.mode=list", or several with commas, or a key alone: of an option that must not be off or 0. Returns the values, or NULL. */
static const char *split(const char *needs, char key[64]) {
    const char *value = strchr(needs, '=');
    snprintf(key, 64, "%.*s", (int)strcspn(needs, "="), needs);
    return value ? value + 1 : NULL;
}

/* Whether the frame has what a row needs. */
static bool meets(const fnl_frame *frame, const fnl_counter *c) {
    char key[64], own[64];
    const char *value = split(c->needs, key);
    if (!*c->needs) return true;
    assert_true(fnl_frame_get(frame, key, own, sizeof own) > 0);
    if (value && strchr(value, ',')) return strstr(value, own) != NULL;
    return value ? strcmp(own, value) == 0 : strcmp(own, "off") != 0 && strcmp(own, "0") != 0;
}

static void meet(fnl_frame *frame, const fnl_counter *c) {
    char key[64];
    const char *value = split(c->needs, key);
    fnl_option option = {0};
    if (!*c->needs) return;
    assert_true(fnl_option_find(key, &option));
    char first[64];
    if (value) {
        snprintf(first, sizeof first, "%.*s", (int)strcspn(value, ","), value);
        value = first;
    }
    if (!value) value = option.kind == FNL_OPTION_SWITCH ? "on" : option.choice_count ? "8" : "1";
    assert_int_equal(fnl_frame_set(NULL, frame, key, value), FNL_OK);
}

static void test_rows_are_complete(void **state) {
    UNUSED(state);
    fnl_counter c, other;
    uint32_t count = 0;
    for (; fnl_counter_query(count, &c); count++) {
        size_t group = strspn(c.key, "abcdefghijklmnopqrstuvwxyz-");
        bool formed = group > 0 && c.key[group] == '.' &&
                      strspn(c.key + group + 1, "abcdefghijklmnopqrstuvwxyz-") + group + 1 == strlen(c.key);
        if (!formed || !c.key[group + 1]) fail_msg("%s is no key: group.name, of small letters and dashes", c.key);
        if (strlen(c.help) < 8 || !c.unit || !c.shadings || c.kind > FNL_COUNTER_SWITCH || c.value != 0)
            fail_msg("the row of %s is wrong", c.key);
        for (uint32_t i = 0; i < count; i++) assert_true(fnl_counter_query(i, &other) && strcmp(other.key, c.key) != 0);
        fnl_frame frame = frame_plain(); /* what it needs is an option, and a value that this takes */
        meet(&frame, &c);
        assert_true(meets(&frame, &c));
    }
    assert_int_equal(count, counters_total());
    assert_true(count > 50 && count <= ROWS_MAX);
    assert_false(fnl_counter_query(count, &c));
}

static uint32_t seen[ROWS_MAX]; /* by which paths, in bits */

static void look(struct stage *stage, const fnl_frame *frame) {
    fnl_counter c;
    assert_int_equal(fnl_renderer_render(stage->renderer, frame), FNL_OK);
    fnl_frame_stats stats = harness_stats(stage->renderer);
    uint32_t found = 0;
    for (uint32_t i = 0; fnl_counter_query(i, &c); i++) {
        const fnl_counter *own = fnl_counter_find(&stats, c.key);
        if (own && (!(c.shadings >> frame->shading & 1) || !meets(frame, &c)))
            fail_msg("%s shading has %s, which it does not apply to", fnl_value_name(FNL_ENUM_SHADING, frame->shading),
                     c.key);
        if (!own) continue;
        assert_ptr_equal(own, &stats.counters[found]); /* in the order of the rows */
        assert_true(own->kind != FNL_COUNTER_SWITCH || own->value <= 1);
        assert_string_equal(own->help, c.help);
        seen[i] |= 1u << frame->shading;
        found++;
    }
    assert_int_equal(found, stats.counter_count);
}

/* Each number is there with every path that has it, and never where it does not apply. */
static void test_frames_have_what_they_do(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:glass?lights=8", 0);
    assert_int_equal(fnl_scene_scatter_decals(stage.scene, 8, 1), FNL_OK);
    fnl_device_info info;
    assert_int_equal(fnl_device_query_info(harness_device(), &info), FNL_OK);
    fnl_counter c;
    fnl_frame usual = stage.frame;
    usual.width = 40;
    usual.height = 24;
    usual.outputs = 0;
    usual.lists = FNL_LISTS_CLUSTERED;
    for (uint32_t s = 0; s < FNL_SHADING_AUTO; s++) {
        fnl_frame frame = usual;
        bool has_rows = s == FNL_SHADING_FORWARD, has_needs = false; /* a path without numbers of its own is enough */
        frame.shading = (fnl_shading)s;
        for (uint32_t i = 0; fnl_counter_query(i, &c); i++) {
            has_rows = has_rows || (c.shadings != UINT32_MAX && c.shadings >> s & 1);
            has_needs = has_needs || (c.shadings != UINT32_MAX && c.shadings >> s & 1 && *c.needs);
        }
        if (!has_rows) continue;
        if (has_needs) look(&stage, &frame);
        for (uint32_t i = 0; fnl_counter_query(i, &c); i++) /* now everything that some row needs */
            if (c.shadings >> s & 1) meet(&frame, &c);
        if (!fnl_shading_supports(frame.shading, frame.lists, 1)) frame.lists = usual.lists;
        frame.visibility.sort = FNL_VISIBILITY_SORT_CLASS;
        look(&stage, &frame);
        if (s != FNL_SHADING_DEFERRED) continue;
        frame.deferred.class_blocks = 0;
        frame.shadows = FNL_SHADOWS_SAMPLED; /* with shadow.denoise */
        frame.shadow.ray_backend = FNL_RAY_BACKEND_RAY_QUERY;
        look(&stage, &frame);
        frame.shadow.denoise = false;
        frame.shadows = FNL_SHADOWS_CUBEMAP;
        look(&stage, &frame);
        frame.shadows = FNL_SHADOWS_HYBRID;
        look(&stage, &frame);
        frame.shadow.filter = FNL_SHADOW_FILTER_PCF;
        look(&stage, &frame);
        frame.shadows = FNL_SHADOWS_SAMPLED;
        if (!(info.msaa_counts & 4)) continue;
        frame.msaa = 4;
        look(&stage, &frame);
    }
    fnl_probe_params probe = fnl_probe_params_default();
    fnl_probe_id id;
    probe.reflection = true;
    probe.face_size = 16;
    for (int i = 0; i < 5; i++) assert_int_equal(fnl_scene_add_probe(stage.scene, &probe, &id), FNL_OK); /* more than do without a list */
    fnl_material_params glass;
    fnl_entity_info entity;
    assert_int_equal(fnl_scene_query_entity(stage.scene, FNL_ENTITY_MATERIAL, 0, &entity), FNL_OK);
    assert_int_equal(fnl_scene_query_material(stage.scene, 0, &glass), FNL_OK);
    glass.transmission.strength = 1;
    assert_int_equal(fnl_scene_set_material(stage.scene, entity.id.material, &glass), FNL_OK);
    fnl_environment_params environment = fnl_environment_params_default();
    environment.source = "builtin:overcast";
    assert_int_equal(fnl_scene_set_environment(stage.scene, &environment), FNL_OK);
    usual.shading = FNL_SHADING_FORWARD;
    look(&stage, &usual);
    fnl_frame two = usual;
    fnl_camera eyes[2] = {usual.camera, usual.camera};
    eyes[1].position.x += 0.06f;
    two.shading = FNL_SHADING_DEFERRED;
    two.views = eyes;
    two.view_count = two.stereo.eyes = 2;
    two.stereo.mono_distance = 10;
    two.count_lights = true;
    look(&stage, &two);
    for (uint32_t i = 0; fnl_counter_query(i, &c); i++) {
        if (!(info.msaa_counts & 4) && strncmp(c.key, "msaa.", 5) == 0) continue;
        if (!info.ray_query && (strncmp(c.key, "shadows.structure", 17) == 0 || strcmp(c.key, "shadows.instances") == 0)) continue;
        uint32_t wanted = c.shadings == UINT32_MAX ? seen[i] : c.shadings;
        if (seen[i] != wanted || !wanted) fail_msg("%s is missing: paths %x have it, not %x", c.key, seen[i], c.shadings);
    }
    stage_close(&stage);
}

/* Without glass nothing is told of it; lists of blended surfaces count beside those of opaque ones. */
static void test_what_is_not_there(void **state) {
    UNUSED(state);
    uint64_t entries[2];
    for (int blends = 0; blends < 2; blends++) {
        struct stage stage = stage_open("builtin:glass?lights=8", 0);
        stage.frame.width = 40;
        stage.frame.height = 24;
        stage.frame.shading = FNL_SHADING_DEFERRED;
        stage.frame.lists = FNL_LISTS_TILED;
        fnl_entity_info entity;
        fnl_material_params material;
        for (uint32_t i = 0; fnl_scene_query_material(stage.scene, i, &material) == FNL_OK; i++) {
            if (blends || material.alpha_mode != FNL_ALPHA_BLEND) continue;
            material.alpha_mode = FNL_ALPHA_OPAQUE;
            assert_int_equal(fnl_scene_query_entity(stage.scene, FNL_ENTITY_MATERIAL, i, &entity), FNL_OK);
            assert_int_equal(fnl_scene_set_material(stage.scene, entity.id.material, &material), FNL_OK);
        }
        assert_int_equal(fnl_renderer_render(stage.renderer, &stage.frame), FNL_OK);
        const fnl_frame_stats stats = harness_stats(stage.renderer);
        assert_false(has_counter(&stats, "transmission.overflow-layers"));
        entries[blends] = stats.list_entries;
        stage_close(&stage);
    }
    print_message("%u entries of opaque surfaces, %u with those of blended ones\n", (uint32_t)entries[0], (uint32_t)entries[1]);
    assert_true(entries[0] > 0 && entries[1] > entries[0] && entries[1] < 20 * entries[0]);
}

static void test_find(void **state) {
    UNUSED(state);
    const fnl_counter counters[] = {{.key = "a.b", .value = 3}, {.key = "a.c", .value = 4}};
    const fnl_frame_stats stats = {.counters = counters, .counter_count = 2}, none = {0};
    assert_ptr_equal(fnl_counter_find(&stats, "a.c"), &counters[1]);
    assert_null(fnl_counter_find(&stats, "a"));
    assert_null(fnl_counter_find(&none, "a.b"));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_rows_are_complete),
        cmocka_unit_test_teardown(test_frames_have_what_they_do, harness_check),
        cmocka_unit_test(test_what_is_not_there),
        cmocka_unit_test(test_find),
    };
    return cmocka_run_group_tests_name("counters", tests, test_group_begin, test_group_end);
}
