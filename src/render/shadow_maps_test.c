/* SPDX-License-Identifier: MIT */
/* Frames with shadow maps: against shadows whose edges are known, against rays, in all shading paths, on any budget, and the work they cost. */
#include "tests/render_harness.h"
#include "tests/shadow_cases.h"
#include "tests/shadow_leak.h"
#include "tests/shadow_paths.h"

/* ---- shadows whose edges are known ---- */

static void measure(fnl_scene *scene, const fnl_trace_params *view, float *out) {
    struct stage s = shadow_stage(scene, view);
    s.frame.shadows = FNL_SHADOWS_MAPS;
    const fnl_frame_stats stats = shadow_parts(&s, out);
    assert_int_equal(counter(&stats, "shadows.coarsened"), 0);
    assert_int_equal(counter(&stats, "shadows.traced"), 0);
    stage_close(&s);
}

/* A pixel is an eighth of a metre wide, a texel at most as much: a texel and a half, seen a metre above the floor. */
static void test_known_shadows(void **state) {
    UNUSED(state);
    shadow_cases(&(struct shadow_cases){measure, 1e-3, 1.5 / 8 / 1.5, false});
}

/* ---- against rays ---- */

static void expect_leak(const char *source, double seconds, uint32_t scattered, double most, double dark) {
    struct stage s = stage_open(source, scattered);
    s.frame.width = 160, s.frame.height = 90;
    s.frame.shadow.memory = 256;
    if (seconds > 0) { /* after a frame in another pose */
        s.frame.shadows = FNL_SHADOWS_MAPS;
        assert_int_equal(fnl_renderer_render(s.renderer, &s.frame), FNL_OK);
        assert_int_equal(fnl_scene_set_time(s.scene, 0, seconds), FNL_OK);
    }
    const struct shadow_leak leak = shadow_leak_of(&s, 2);
    print_message("%s: %.2f %% of the light is wrong, %.1f %% is in shadow, %u pixels are wrong far from edges\n", source, 100 * leak.error,
                  100 * leak.dark, leak.far_off);
    if (leak.error > most || leak.far_off > 160 * 90 / 500) fail_msg("%s: at most %.2f %%", source, 100 * most);
    assert_true(leak.dark > dark);
    stage_close(&s);
}

static void test_maps_are_what_rays_show_MP_6(void **state) {
    UNUSED(state);
    expect_leak("builtin:hall?lights=256", 0, 0, 0.04, 0.18);
    expect_leak("builtin:interior?lights=40", 0, 0, 0.02, 0.1); /* all shapes */
    expect_leak("CornellBox.glb", 0, 8, 0.02, 0.05);
    expect_leak("Fox.glb", 0.4, 40, 0.02, 0.006);
}

/* ---- paths and lists ---- */

static void test_lists_give_the_same_maps(void **state) {
    UNUSED(state);
    expect_lists_alike(FNL_SHADOWS_MAPS);
}

static void test_paths_give_the_same_maps(void **state) {
    UNUSED(state);
    expect_paths_alike(FNL_SHADOWS_MAPS, 1);
    expect_paths_alike(FNL_SHADOWS_MAPS, 4);
}

/* ---- the budget ---- */

/* However little memory there is, every light keeps its shadow: what is wrong grows, nothing is lost. */
static void test_small_budgets_make_maps_coarser_MP_6_ES_69(void **state) {
    UNUSED(state);
    struct stage s = stage_open("builtin:hall?lights=256", 0);
    s.frame.width = 65, s.frame.height = 37;
    static const uint32_t budgets[] = {256, 1};
    double last = 0;
    for (uint32_t i = 0; i < COUNT_OF(budgets); i++) {
        s.frame.shadow.memory = budgets[i];
        const struct shadow_leak leak = shadow_leak_of(&s, 2);
        const fnl_frame_stats stats = harness_stats(s.renderer);
        print_message("%u MiB: %.2f %% wrong, %.1f %% dark; pages %u of %u, cells %u, coarser %u, traced %u\n", budgets[i], 100 * leak.error,
                      100 * leak.dark, (uint32_t)counter(&stats, "shadows.pages"), (uint32_t)counter(&stats, "shadows.wanted"),
                      (uint32_t)counter(&stats, "shadows.cells"), (uint32_t)counter(&stats, "shadows.coarsened"),
                      (uint32_t)counter(&stats, "shadows.traced"));
        assert_true(counter(&stats, "shadows.cells") * 65536 <= budgets[i] * 1048576ull);
        assert_true((counter(&stats, "shadows.coarsened") > 0) == (i > 0));
        assert_int_equal(counter(&stats, "shadows.traced"), 0);
        assert_true(leak.error < leak.dark / 2 && leak.error >= last * 0.9);
        last = leak.error;
    }
    stage_close(&s);
}

/* Faces have no more texels than was asked for: fewer pages, coarser shadows, and none that rays find. */
static void test_faces_have_few_texels_LC_14(void **state) {
    UNUSED(state);
    static const uint32_t most[] = {1920, 119, 56, 24, 8}, alike[] = {1920, 56, 56, 24, 8};
    uint64_t first = 0;
    double error = 0;
    for (uint32_t i = 0; i < COUNT_OF(most); i++) {
        struct stage s = stage_open("builtin:hall?lights=64", 0); /* without pages of the last one */
        s.frame.width = 130, s.frame.height = 74;
        s.frame.shadow.memory = 256;
        s.frame.shadow.texels_max = most[i];
        const struct shadow_leak leak = shadow_leak_of(&s, 2);
        const fnl_frame_stats stats = harness_stats(s.renderer);
        const uint64_t cells = counter(&stats, "shadows.cells"), wanted = counter(&stats, "shadows.wanted");
        print_message("%u texels: %.2f %% wrong, %.1f %% dark, %u pages in %u cells\n", most[i], 100 * leak.error, 100 * leak.dark, (uint32_t)wanted,
                      (uint32_t)cells);
        assert_int_equal(counter(&stats, "shadows.traced"), 0);
        assert_int_equal(counter(&stats, "shadows.coarsened"), 0);
        assert_true(leak.error < leak.dark && (i > 0 && alike[i] == alike[i - 1] ? leak.error == error : leak.error > error));
        /* A page for each face and level, the largest a quarter of a cell. */
        const uint64_t levels = alike[i] == 56 ? 3 : alike[i] == 24 ? 2 : 1;
        assert_true(alike[i] == 1920 || (wanted <= 64 * 6 * levels && cells < first * 2 / 3));
        if (alike[i] != most[i]) {
            struct shot a = stage_shoot(&s, &s.frame);
            s.frame.shadow.texels_max = alike[i];
            struct shot b = stage_shoot(&s, &s.frame);
            assert_memory_equal(a.color.pixels, b.color.pixels, (size_t)a.color.width * a.color.height * 4);
            shot_free(&a);
            shot_free(&b);
        }
        if (i == 0) first = cells;
        error = leak.error;
        stage_close(&s);
    }
}

/* ---- work ---- */

static fnl_frame_stats after_frame(struct stage *s) {
    assert_int_equal(fnl_renderer_render(s->renderer, &s->frame), FNL_OK);
    return harness_stats(s->renderer);
}

static uint64_t counter_of_frame(struct stage *s, const char *key) {
    const fnl_frame_stats stats = after_frame(s);
    return counter(&stats, key);
}

static void test_only_what_is_new_is_drawn(void **state) {
    UNUSED(state);
    struct stage s = stage_open("builtin:hall?lights=64", 0);
    s.frame.shadows = FNL_SHADOWS_MAPS;
    fnl_frame_stats stats = after_frame(&s);
    const uint64_t first = counter(&stats, "shadows.drawn"), pairs = counter(&stats, "shadows.pairs");
    assert_true(first > 50 && first == counter(&stats, "shadows.pages") && pairs >= first / 2);
    /* Few of the items stand before a light. */
    assert_true(pairs < first * stats.items / 4);
    stats = after_frame(&s);
    assert_int_equal(counter(&stats, "shadows.drawn"), 0);
    assert_int_equal(counter(&stats, "shadows.pairs"), 0);
    assert_int_equal(counter(&stats, "shadows.pages"), first);
    s.frame.camera.position.x += 0.05f;
    stats = after_frame(&s);
    assert_true(counter(&stats, "shadows.drawn") < first / 2);
    stage_close(&s);
}

/* What has changed is drawn in the next frame, and nothing in the one after it: a place, a material, a light. */
static void test_changes_are_drawn(void **state) {
    UNUSED(state);
    fnl_scene *scene = shadow_floor();
    fnl_material_params leaf = matt(1);
    leaf.alpha_mode = FNL_ALPHA_MASK;
    const fnl_material_id material = add_material(scene, &leaf);
    const fnl_instance_id instance = add_instance(scene, add_square_mesh(scene, material), mat4_translation((vec3){0, 1, 0}));
    fnl_light_params lamp = fnl_light_params_default();
    lamp.position = (vec3){30, 3, 0};
    lamp.intensity = 5;
    lamp.range = 2;
    struct stage s = stage_open_scene(scene);
    const fnl_trace_params view = look_down((vec3){0, 0, 0}, 8, 0.5f, SHADOW_SIZE);
    s.frame.width = view.width, s.frame.height = view.height;
    s.frame.camera = view.camera;
    s.frame.shadows = FNL_SHADOWS_MAPS;
    const uint64_t pages = counter_of_frame(&s, "shadows.drawn");
    assert_true(pages > 2);
    assert_int_equal(counter_of_frame(&s, "shadows.drawn"), 0);
    const mat4 moved = mat4_translation((vec3){0.5f, 1, 0});
    assert_int_equal(fnl_scene_set_instance_transform(scene, instance, &moved), FNL_OK);
    const uint64_t touched = counter_of_frame(&s, "shadows.drawn");
    assert_true(touched > 0 && touched < pages);
    assert_int_equal(counter_of_frame(&s, "shadows.drawn"), 0);
    leaf.base_color[3] = 0; /* one hole */
    assert_int_equal(fnl_scene_set_material(scene, material, &leaf), FNL_OK);
    assert_int_equal(counter_of_frame(&s, "shadows.drawn"), pages);
    assert_int_equal(counter_of_frame(&s, "shadows.drawn"), 0);
    fnl_light_id id;
    assert_int_equal(fnl_scene_add_light(scene, &lamp, &id), FNL_OK); /* out of the view */
    assert_int_equal(counter_of_frame(&s, "shadows.drawn"), 0);
    lamp.position = (vec3){0, 1, 2};
    assert_int_equal(fnl_scene_set_light(scene, id, &lamp), FNL_OK);
    const uint64_t of_lamp = counter_of_frame(&s, "shadows.drawn");
    assert_true(of_lamp > 0 && of_lamp < counter_of_frame(&s, "shadows.pages"));
    assert_int_equal(counter_of_frame(&s, "shadows.drawn"), 0);
    stage_close(&s);
}

/* ---- frames in which nothing changes ---- */

/* Whether the last frame asked for pages. Otherwise it did nothing for its maps but to look them up. */
static bool has_asked(const fnl_frame_stats *stats, const char *view) {
    bool asked = false, worked = false;
    for (uint32_t i = 0; i < stats->pass_count; i++) {
        const char *name = stats->passes[i].name;
        if (strncmp(name, view, strlen(view)) != 0 || !strstr(name, "shadows/")) continue;
        worked = worked || !strstr(name, "shadow suns");
        asked = asked || strstr(name, "shadow requests");
    }
    assert_int_equal(worked, asked);
    return asked;
}

static bool asks(struct stage *s) {
    const fnl_frame_stats stats = after_frame(s);
    return has_asked(&stats, "");
}

/* Frames until none asks for pages: those that counts take to come back, and two in which pages that are gone may be evicted. */
static void settle(struct stage *s) {
    for (int i = 0; i < GPU_FRAMES_IN_FLIGHT + 2; i++) after_frame(s);
    const fnl_frame_stats stats = after_frame(s);
    assert_false(has_asked(&stats, ""));
    assert_int_equal(counter(&stats, "shadows.drawn") + counter(&stats, "shadows.evicted") + counter(&stats, "shadows.pairs"), 0);
    assert_true(counter(&stats, "shadows.pages") > 3 && counter(&stats, "shadows.wanted") > 3 && counter(&stats, "shadows.cells") > 0);
}

static void never_settles(struct stage *s) {
    for (int i = 0; i < GPU_FRAMES_IN_FLIGHT + 4; i++) assert_true(asks(s));
}

/* A frame with something else asks for its pages; then the frames come to rest. */
#define EXPECT_ASKS(s, change)   \
    do {                         \
        settle(s);               \
        change;                  \
        assert_true(asks(s));    \
    } while (0)

struct rest {
    struct stage stage;
    fnl_material_id material;
    fnl_instance_id square;
    fnl_light_id light;
    fnl_light_params lamp;
};

static struct rest open_rest(void) {
    struct rest r = {.lamp = fnl_light_params_default()};
    fnl_scene *scene = shadow_floor();
    const fnl_material_params white = matt(1);
    r.material = add_material(scene, &white);
    r.square = add_instance(scene, add_square_mesh(scene, r.material), mat4_translation((vec3){0, 1, 0}));
    r.lamp.position = (vec3){0.4f, 2, 0.3f};
    r.lamp.intensity = 5;
    r.lamp.range = 20;
    r.lamp.shadow_update = FNL_SHADOW_UPDATE_ON_REQUEST;
    assert_int_equal(fnl_scene_add_light(scene, &r.lamp, &r.light), FNL_OK);
    r.stage = stage_open_scene(scene);
    const fnl_trace_params view = look_down((vec3){0, 0, 0}, 8, 0.5f, SHADOW_SIZE);
    r.stage.frame.width = view.width, r.stage.frame.height = view.height;
    r.stage.frame.camera = view.camera;
    r.stage.frame.shadows = FNL_SHADOWS_MAPS;
    r.stage.frame.timers = true;
    return r;
}

/* Frames that repeat the last one look up what that has made, and nothing more; whatever may change what they look up, they ask for pages again. */
static void test_SH_70_still_frames_look_up_alone(void **state) {
    UNUSED(state);
    struct rest r = open_rest();
    struct stage *s = &r.stage;
    fnl_frame *f = &s->frame;
    assert_true(asks(s) && asks(s)); /* that nothing was drawn is not known yet */
    EXPECT_ASKS(s, f->camera.position.x += 0.05f);
    EXPECT_ASKS(s, f->camera.vertical_extent *= 0.99f);
    EXPECT_ASKS(s, f->jitter.x = 0.25f);
    EXPECT_ASKS(s, f->width--);
    EXPECT_ASKS(s, f->msaa = 4);
    EXPECT_ASKS(s, f->msaa = 1);
    EXPECT_ASKS(s, f->shadow.memory = 8);
    EXPECT_ASKS(s, f->shadow.texels_max = 240);
    EXPECT_ASKS(s, f->shadow.filter = FNL_SHADOW_FILTER_PCSS);
    EXPECT_ASKS(s, f->shadow.light_radius = 0.1f);
    EXPECT_ASKS(s, f->shading = FNL_SHADING_FORWARD);
    EXPECT_ASKS(s, f->debug = FNL_DEBUG_SHADOW_PAGES);
    EXPECT_ASKS(s, f->debug = FNL_DEBUG_NONE);
    f->shadow.filter = FNL_SHADOW_FILTER_HARD;
    const mat4 moved = mat4_translation((vec3){0.3f, 1, 0});
    EXPECT_ASKS(s, assert_int_equal(fnl_scene_set_instance_transform(s->scene, r.square, &moved), FNL_OK));
    EXPECT_ASKS(s, assert_int_equal(fnl_scene_refresh_shadows(s->scene, &r.light, 1), FNL_OK));
    EXPECT_ASKS(s, assert_int_equal(fnl_scene_set_instance_visible(s->scene, r.square, false), FNL_OK));
    EXPECT_ASKS(s, assert_int_equal(fnl_scene_set_instance_visible(s->scene, r.square, true), FNL_OK));
    fnl_material_params holes = matt(1);
    holes.alpha_mode = FNL_ALPHA_MASK;
    holes.base_color[3] = 0;
    EXPECT_ASKS(s, assert_int_equal(fnl_scene_set_material(s->scene, r.material, &holes), FNL_OK));
    holes.base_color[3] = 1; /* a number in a table */
    EXPECT_ASKS(s, assert_int_equal(fnl_scene_set_material(s->scene, r.material, &holes), FNL_OK));
    r.lamp.intensity = 3;
    EXPECT_ASKS(s, assert_int_equal(fnl_scene_set_light(s->scene, r.light, &r.lamp), FNL_OK));
    r.lamp.position.x += 0.1f;
    EXPECT_ASKS(s, assert_int_equal(fnl_scene_set_light(s->scene, r.light, &r.lamp), FNL_OK));
    EXPECT_ASKS(s, f->reset_history = true);
    f->reset_history = false;
    settle(s);
    f->shadows = FNL_SHADOWS_OFF;
    after_frame(s);
    f->shadows = FNL_SHADOWS_MAPS;
    assert_true(asks(s));
    stage_close(s);
}

/* What changes in every frame, or counts by frames, never rests. */
static void test_SH_70_what_never_rests(void **state) {
    UNUSED(state);
    struct rest r = open_rest();
    fnl_frame *f = &r.stage.frame;
    settle(&r.stage);
    f->shadows = FNL_SHADOWS_HYBRID;
    f->shadow.page_rays = 64;
    never_settles(&r.stage);
    f->shadows = FNL_SHADOWS_MAPS;
    f->aa = FNL_ANTIALIASING_TAA;
    never_settles(&r.stage);
    f->aa = FNL_ANTIALIASING_NONE;
    f->debug = FNL_DEBUG_SHADOW_AGE;
    never_settles(&r.stage);
    f->debug = FNL_DEBUG_NONE;
    f->shadow.classify = true;
    never_settles(&r.stage);
    stage_close(&r.stage);
}

static struct shot shoot_color(struct stage *s) {
    s->frame.outputs = FNL_OUTPUT_COLOR | FNL_OUTPUT_RADIANCE;
    return stage_shoot(s, &s->frame);
}

/* Pictures and numbers are those of frames that do all the work, and so are the ages of pages when they are shown. */
static void test_SH_70_still_frames_tell_the_truth(void **state) {
    UNUSED(state);
    struct rest still = open_rest(), busy = open_rest();
    busy.stage.frame.debug = FNL_DEBUG_SHADOW_AGE; /* which asks in all frames */
    settle(&still.stage);
    for (int i = 0; i < GPU_FRAMES_IN_FLIGHT + 3; i++) assert_true(asks(&busy.stage));
    static const char *const keys[] = {"shadows.wanted", "shadows.pages",     "shadows.drawn",  "shadows.evicted", "shadows.coarsened",
                                       "shadows.cells",  "shadows.traced", "shadows.waiting", "shadows.pairs"};
    for (int step = 0; step < 2; step++) {
        struct shot a = shoot_color(&still.stage), b = shoot_color(&busy.stage);
        for (uint32_t k = 0; k < COUNT_OF(keys); k++) assert_int_equal(counter(&a.stats, keys[k]), counter(&b.stats, keys[k]));
        assert_int_equal(count_differing(&a.radiance, &b.radiance), 0);
        still.stage.frame.debug = FNL_DEBUG_SHADOW_AGE;
        if (step) assert_memory_equal(a.color.pixels, b.color.pixels, (size_t)a.color.width * a.color.height * 4);
        shot_free(&a);
        shot_free(&b);
    }
    stage_close(&still.stage);
    stage_close(&busy.stage);
}

/* Pages that wait for room are drawn in the frames that follow, however still these are. */
static void test_SH_70_pages_that_wait_are_not_forgotten(void **state) {
    UNUSED(state);
    struct stage s = stage_open("builtin:hall?lights=16", 0);
    s.frame.width = 65, s.frame.height = 37;
    s.frame.shadows = FNL_SHADOWS_MAPS;
    s.frame.timers = true;
    s.renderer->shadows.pairs = 1; /* room for as many as items, until the first frame's counts are back */
    fnl_frame_stats stats = after_frame(&s);
    assert_true(counter(&stats, "shadows.waiting") > 0);
    do {
        stats = after_frame(&s);
        assert_true(has_asked(&stats, ""));
    } while (counter(&stats, "shadows.drawn") > 0);
    assert_int_equal(counter(&stats, "shadows.waiting"), 0);
    settle(&s);
    stage_close(&s);
}

/* Each view rests by itself, but eyes, which share their maps. */
static void test_SH_70_views_rest_by_themselves(void **state) {
    UNUSED(state);
    for (uint32_t eyes = 0; eyes <= 2; eyes += 2) {
        struct rest r = open_rest();
        fnl_camera cameras[2] = {r.stage.frame.camera, r.stage.frame.camera};
        cameras[1].position.x += 0.06f;
        cameras[1].target.x += 0.06f;
        r.stage.frame.views = cameras;
        r.stage.frame.view_count = 2;
        r.stage.frame.stereo.eyes = eyes;
        const char *const first = eyes ? "" : "view 0";
        for (int i = 0; i < GPU_FRAMES_IN_FLIGHT + 2; i++) after_frame(&r.stage);
        assert_false(asks(&r.stage));
        cameras[1].position.x += 0.01f;
        fnl_frame_stats stats = after_frame(&r.stage);
        assert_int_equal(has_asked(&stats, first), eyes > 0);
        if (!eyes) assert_true(has_asked(&stats, "view 1"));
        stage_close(&r.stage);
    }
}

/* A pose is another picture, and an animation that stands still is not. */
static void test_SH_70_what_is_animated_asks(void **state) {
    UNUSED(state);
    struct stage s = stage_open("Fox.glb", 8);
    s.frame.width = 64, s.frame.height = 36;
    s.frame.shadows = FNL_SHADOWS_MAPS;
    s.frame.timers = true;
    EXPECT_ASKS(&s, assert_int_equal(fnl_scene_set_time(s.scene, 0, 0.3), FNL_OK));
    EXPECT_ASKS(&s, assert_int_equal(fnl_scene_set_time(s.scene, 0, 0.4), FNL_OK));
    stage_close(&s);
}

/* A floor, a square that moves above it, and two lights: the first draws its maps by a policy, the other's see nothing of the square. */
struct policy {
    struct stage stage;
    fnl_instance_id square;
    fnl_light_id lights[2];
    fnl_light_params lamp;
};

static struct policy open_policy(fnl_light_kind kind, fnl_shadow_update update) {
    fnl_scene *scene = world_create(NULL);
    const fnl_material_params white = matt(1);
    struct policy p = {.lamp = fnl_light_params_default()};
    add_square(scene, &white, (vec3){10, 1, 10}, (vec3){0, 0, 0});
    p.square = add_square(scene, &white, (vec3){1, 1, 1}, (vec3){0, 1, 0});
    p.lamp.kind = kind;
    p.lamp.direction = (vec3){0.2f, -1, 0.1f};
    p.lamp.position = SHADOW_LIGHT;
    p.lamp.intensity = 50;
    p.lamp.range = kind == FNL_LIGHT_DIRECTIONAL ? INFINITY : 1000;
    p.lamp.shadow_update = update;
    fnl_light_params other = fnl_light_params_default();
    other.position = (vec3){-3, 0.3f, -3};
    other.range = 0.6f;
    assert_int_equal(fnl_scene_add_light(scene, &p.lamp, &p.lights[0]), FNL_OK);
    assert_int_equal(fnl_scene_add_light(scene, &other, &p.lights[1]), FNL_OK);
    p.stage = stage_open_scene(scene);
    const fnl_trace_params view = look_down((vec3){0, 0, 0}, 8, 0.5f, SHADOW_SIZE);
    p.stage.frame.width = view.width, p.stage.frame.height = view.height;
    p.stage.frame.camera = view.camera;
    p.stage.frame.outputs = FNL_OUTPUT_RADIANCE;
    p.stage.frame.shadows = FNL_SHADOWS_MAPS;
    return p;
}

static void move_square(struct policy *p, int step) {
    const mat4 at = mat4_translation((vec3){0.4f * (float)step, 1, 0});
    assert_int_equal(fnl_scene_set_instance_transform(p->stage.scene, p->square, &at), FNL_OK);
}

static struct shot shoot_drawn(struct policy *p, uint64_t *drawn) {
    struct shot shot = stage_shoot(&p->stage, &p->stage.frame);
    *drawn = counter(&shot.stats, "shadows.drawn");
    return shot;
}

/* Maps that are drawn on request stay as they are while a caster moves, and are those of all others after a request, to the bit. */
static void test_maps_are_drawn_on_request(void **state) {
    UNUSED(state);
    static const fnl_light_kind kinds[] = {FNL_LIGHT_POINT, FNL_LIGHT_DIRECTIONAL};
    enum { STEPS = 4 };
    for (uint32_t k = 0; k < COUNT_OF(kinds); k++) {
        struct policy always = open_policy(kinds[k], FNL_SHADOW_UPDATE_ALWAYS), asked = open_policy(kinds[k], FNL_SHADOW_UPDATE_ON_REQUEST);
        uint64_t drawn[2], pages;
        struct shot first = shoot_drawn(&asked, &pages), moved = shoot_drawn(&always, &drawn[0]);
        assert_true(pages > 3 && pages == drawn[0]);
        assert_int_equal(count_differing(&first.radiance, &moved.radiance), 0);
        for (int step = 1; step <= STEPS; step++) {
            move_square(&always, step);
            move_square(&asked, step);
            shot_free(&moved);
            moved = shoot_drawn(&always, &drawn[0]);
            struct shot kept = shoot_drawn(&asked, &drawn[1]);
            assert_true(drawn[0] > 0 && drawn[0] < pages);
            assert_int_equal(drawn[1], 0);
            assert_int_equal(count_differing(&first.radiance, &kept.radiance), 0);
            assert_true(count_differing(&moved.radiance, &kept.radiance) > 20);
            shot_free(&kept);
            if (step == 1) assert_int_equal(fnl_scene_refresh_shadows(asked.stage.scene, &asked.lights[1], 1), FNL_OK); /* another light's */
        }
        assert_int_equal(fnl_scene_refresh_shadows(asked.stage.scene, asked.lights, 2), FNL_OK);
        struct shot fresh = shoot_drawn(&asked, &drawn[0]), again = shoot_drawn(&asked, &drawn[1]);
        assert_true(drawn[0] > 3 && drawn[0] < pages); /* not those of the other light, which sees nothing of it */
        assert_int_equal(drawn[1], 0);
        assert_int_equal(count_differing(&fresh.radiance, &moved.radiance), 0);
        assert_int_equal(count_differing(&fresh.radiance, &again.radiance), 0);
        /* What was kept is drawn again where the light moves, and where it is drawn always from now on. */
        for (int step = 0; step < 2; step++) {
            move_square(&asked, step);
            move_square(&always, step);
            shot_free(&again);
            again = shoot_drawn(&asked, &drawn[0]);
            assert_int_equal(drawn[0], 0);
            if (step == 0) {
                asked.lamp.position.x += 0.5f, asked.lamp.direction.x += 0.1f;
                assert_int_equal(fnl_scene_set_light(always.stage.scene, always.lights[0], &asked.lamp), FNL_OK);
                always.lamp = asked.lamp;
                always.lamp.shadow_update = FNL_SHADOW_UPDATE_ALWAYS;
                assert_int_equal(fnl_scene_set_light(always.stage.scene, always.lights[0], &always.lamp), FNL_OK);
            } else {
                asked.lamp.shadow_update = FNL_SHADOW_UPDATE_ALWAYS;
            }
            assert_int_equal(fnl_scene_set_light(asked.stage.scene, asked.lights[0], &asked.lamp), FNL_OK);
            shot_free(&again);
            shot_free(&moved);
            again = shoot_drawn(&asked, &drawn[0]);
            moved = shoot_drawn(&always, &drawn[1]);
            assert_true(drawn[0] > 3);
            assert_int_equal(count_differing(&again.radiance, &moved.radiance), 0);
        }
        shot_free(&first);
        shot_free(&moved);
        shot_free(&fresh);
        shot_free(&again);
        stage_close(&always.stage);
        stage_close(&asked.stage);
    }
}

/* A pane over the floor is nearer to the light than what is seen through it, and asks for pages of its own. */
static void test_blended_surfaces_ask_for_pages(void **state) {
    UNUSED(state);
    fnl_scene *scene = shadow_floor();
    struct stage s = stage_open_scene(scene);
    const fnl_trace_params view = look_down((vec3){0, 0, 0}, 8, 2.5f, SHADOW_SIZE);
    s.frame.width = view.width, s.frame.height = view.height;
    s.frame.camera = view.camera;
    s.frame.shadows = FNL_SHADOWS_MAPS;
    const uint64_t without = counter_of_frame(&s, "shadows.wanted");
    fnl_material_params glass = matt(1);
    glass.alpha_mode = FNL_ALPHA_BLEND;
    glass.base_color[3] = 0.25f;
    add_square(scene, &glass, (vec3){3, 1, 3}, (vec3){0, 2, 0});
    assert_true(without > 0 && counter_of_frame(&s, "shadows.wanted") > without);
    stage_close(&s);
}

/* Glass through which light goes everywhere is not even drawn into maps; glass that is metal in part is. */
static void test_clear_glass_is_not_drawn(void **state) {
    UNUSED(state);
    uint64_t pairs[3];
    for (uint32_t kind = 0; kind < 3; kind++) { /* one that casts nothing, clear, metal */
        fnl_scene *scene = shadow_floor();
        fnl_material_params glass = matt(1);
        glass.transmission.strength = 1;
        glass.casts_shadows = kind > 0;
        glass.metallic = kind == 2 ? 1 : 0;
        add_square(scene, &glass, (vec3){1, 1, 1}, (vec3){0, 1, 0});
        struct stage s = stage_open_scene(scene);
        const fnl_trace_params view = look_down((vec3){0, 0, 0}, 8, 0.5f, SHADOW_SIZE);
        s.frame.width = view.width, s.frame.height = view.height;
        s.frame.camera = view.camera;
        s.frame.shadows = FNL_SHADOWS_MAPS;
        pairs[kind] = counter_of_frame(&s, "shadows.pairs");
        stage_close(&s);
    }
    assert_int_equal(pairs[1], pairs[0]);
    assert_true(pairs[2] > pairs[0]);
}

/* A lamp that reaches a pane and nothing opaque, far from the viewer: the pane finds it in the lights of its own depth. */
static void test_panes_ask_where_they_are(void **state) {
    UNUSED(state);
    for (uint32_t kind = 0; kind < 3; kind++) {
        fnl_scene *scene = world_create(NULL);
        fnl_light_params lamp = fnl_light_params_default();
        fnl_light_id id;
        lamp.position = (vec3){0, 1, 0};
        lamp.intensity = 10, lamp.range = 0.8f;
        assert_int_equal(fnl_scene_add_light(scene, &lamp, &id), FNL_OK);
        fnl_material_params pane = matt(1);
        add_square(scene, &pane, (vec3){10, 1, 10}, (vec3){0, 0, 0});
        if (kind == 1) pane.alpha_mode = FNL_ALPHA_BLEND, pane.base_color[3] = 0.25f;
        if (kind == 2) pane.transmission.strength = 1;
        if (kind > 0) add_square(scene, &pane, (vec3){1, 1, 1}, (vec3){0, 0.9f, 0});
        struct stage s = stage_open_scene(scene);
        s.frame.width = s.frame.height = SHADOW_SIZE;
        s.frame.camera = fnl_camera_default();
        s.frame.camera.position = (vec3){0, 20, 0}, s.frame.camera.target = (vec3){0, 0, 0}, s.frame.camera.up = (vec3){0, 0, -1};
        s.frame.camera.vertical_fov = 0.2f;
        s.frame.shadows = FNL_SHADOWS_MAPS;
        const uint64_t wanted = counter_of_frame(&s, "shadows.wanted");
        if ((wanted > 0) != (kind > 0)) fail_msg("%u pages are wanted with pane %u", (uint32_t)wanted, kind);
        stage_close(&s);
    }
}

/* A strip that only the lower samples of a row of pixels see, above the floor, so that it needs other pages than what is under it. */
static void test_all_samples_ask_for_pages(void **state) {
    UNUSED(state);
    uint64_t wanted[2][2];
    for (uint32_t strip = 0; strip < 2; strip++)
        for (uint32_t several = 0; several < 2; several++) {
            fnl_scene *scene = shadow_floor();
            const fnl_material_params material = matt(1);
            if (strip) add_square(scene, &material, (vec3){4, 1, 0.028f}, (vec3){0, 2, 0.094f});
            struct stage s = stage_open_scene(scene);
            const fnl_trace_params view = look_down((vec3){0, 0, 0}, 8, 2.5f, SHADOW_SIZE);
            s.frame.width = view.width, s.frame.height = view.height;
            s.frame.camera = view.camera;
            s.frame.msaa = several ? 4 : 1;
            s.frame.shadows = FNL_SHADOWS_MAPS;
            wanted[strip][several] = counter_of_frame(&s, "shadows.wanted");
            stage_close(&s);
        }
    assert_int_equal(wanted[1][0], wanted[0][0]); /* no middle of a pixel sees it */
    assert_true(wanted[1][1] > wanted[0][1]);
}

/* Pages whose items find no room wait, and the frame says so; in the end all are drawn. */
static void test_pages_wait_for_room(void **state) {
    UNUSED(state);
    struct stage s = stage_open("builtin:hall?lights=16", 0);
    s.frame.shadows = FNL_SHADOWS_MAPS;
    s.frame.outputs = FNL_OUTPUT_RADIANCE;
    struct shot whole = stage_shoot(&s, &s.frame);
    assert_int_equal(counter(&whole.stats, "shadows.waiting"), 0);
    const uint64_t pairs = counter(&whole.stats, "shadows.pairs");
    fnl_renderer_destroy(&s.renderer);
    assert_int_equal(fnl_renderer_create(harness_device(), s.scene, &s.renderer), FNL_OK);
    s.renderer->shadows.pairs = 1; /* then there is room for as many as items */
    struct shot first = stage_shoot(&s, &s.frame);
    assert_true(pairs > first.stats.items);
    assert_int_equal(counter(&first.stats, "shadows.waiting"), counter(&first.stats, "shadows.pairs") - first.stats.items);
    for (int i = 0; i < GPU_FRAMES_IN_FLIGHT + 1; i++) assert_int_equal(fnl_renderer_render(s.renderer, &s.frame), FNL_OK);
    struct shot last = stage_shoot(&s, &s.frame);
    assert_int_equal(counter(&last.stats, "shadows.waiting"), 0);
    assert_int_equal(count_differing(&whole.radiance, &last.radiance), 0);
    shot_free(&whole);
    shot_free(&first);
    shot_free(&last);
    stage_close(&s);
}

/* Frames without lights, and those without shadows, have no pass more. */
static void test_nothing_is_added_without_lights(void **state) {
    UNUSED(state);
    struct stage s = stage_open("builtin:hall?lights=0", 0);
    s.frame.timers = true;
    const uint32_t plain = after_frame(&s).pass_count;
    s.frame.shadows = FNL_SHADOWS_MAPS;
    after_frame(&s);
    assert_int_equal(after_frame(&s).pass_count, plain);
    stage_close(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_known_shadows, harness_check),
        cmocka_unit_test_teardown(test_maps_are_what_rays_show_MP_6, harness_check),
        cmocka_unit_test_teardown(test_lists_give_the_same_maps, harness_check),
        cmocka_unit_test_teardown(test_paths_give_the_same_maps, harness_check),
        cmocka_unit_test_teardown(test_small_budgets_make_maps_coarser_MP_6_ES_69, harness_check),
        cmocka_unit_test_teardown(test_faces_have_few_texels_LC_14, harness_check),
        cmocka_unit_test_teardown(test_only_what_is_new_is_drawn, harness_check),
        cmocka_unit_test_teardown(test_changes_are_drawn, harness_check),
        cmocka_unit_test_teardown(test_SH_70_still_frames_look_up_alone, harness_check),
        cmocka_unit_test_teardown(test_SH_70_what_never_rests, harness_check),
        cmocka_unit_test_teardown(test_SH_70_still_frames_tell_the_truth, harness_check),
        cmocka_unit_test_teardown(test_SH_70_pages_that_wait_are_not_forgotten, harness_check),
        cmocka_unit_test_teardown(test_SH_70_views_rest_by_themselves, harness_check),
        cmocka_unit_test_teardown(test_SH_70_what_is_animated_asks, harness_check),
        cmocka_unit_test_teardown(test_maps_are_drawn_on_request, harness_check),
        cmocka_unit_test_teardown(test_blended_surfaces_ask_for_pages, harness_check),
        cmocka_unit_test_teardown(test_clear_glass_is_not_drawn, harness_check),
        cmocka_unit_test_teardown(test_panes_ask_where_they_are, harness_check),
        cmocka_unit_test_teardown(test_all_samples_ask_for_pages, harness_check),
        cmocka_unit_test_teardown(test_pages_wait_for_room, harness_check),
        cmocka_unit_test_teardown(test_nothing_is_added_without_lights, harness_check),
    };
    return cmocka_run_group_tests_name("shadow_maps", tests, harness_begin, harness_end);
}
