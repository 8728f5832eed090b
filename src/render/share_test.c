/* SPDX-License-Identifier: MIT */
/**
 * Several renderers of one scene on one device: they share what they upload, and each shows what it would show alone. The oracle of a
 * renderer is a lone one, which shares nothing and renders the same frames (test_renderer).
 */
#include "graph/graph_internal.h"
#include "tests/edit_world.h"

/* ---- a renderer that shares, and the one that it must not differ from ---- */

struct pair {
    fnl_renderer *shares, *lone;
    fnl_frame frame;
};

static fnl_renderer *open_renderers[8]; /* those of a test that fails go before its scene */

static fnl_renderer *note(fnl_renderer *renderer) {
    uint32_t place = 0;
    while (place < COUNT_OF(open_renderers) && open_renderers[place]) place++;
    assert_true(place < COUNT_OF(open_renderers));
    open_renderers[place] = renderer;
    harness_hooks(renderer)->poison = true;
    return renderer;
}

static void close_renderer(fnl_renderer **renderer) {
    for (uint32_t i = 0; i < COUNT_OF(open_renderers); i++)
        if (open_renderers[i] == *renderer) open_renderers[i] = NULL;
    fnl_renderer_destroy(renderer);
}

static int check(void **state) {
    test_device_memory.fail_at = 0;
    for (uint32_t i = 0; i < COUNT_OF(open_renderers); i++) fnl_renderer_destroy(&open_renderers[i]);
    return harness_check(state);
}

static fnl_renderer *open_lone(const struct world *w) { return note(test_renderer(w->stage.scene)); }

static fnl_renderer *open_shared(const struct world *w) {
    fnl_renderer *renderer;
    assert_int_equal(fnl_renderer_create(harness_device(), w->stage.scene, &renderer), FNL_OK);
    return note(renderer);
}

static struct pair open_pair(const struct world *w) { return (struct pair){open_shared(w), open_lone(w), w->stage.frame}; }

static void close_pair(struct pair *p) {
    close_renderer(&p->shares);
    close_renderer(&p->lone);
}

static void compare(const struct pair *p, fnl_output output, const char *what, uint32_t round) {
    if (!(p->frame.outputs & (uint32_t)output)) return;
    fnl_image a = test_read(p->shares, output), b = test_read(p->lone, output);
    const uint64_t wrong = count_differing(&a, &b);
    if (wrong) fail_msg("round %u: %llu pixels of %s differ from a lone renderer's", round, (unsigned long long)wrong, what);
    free_picture(&a);
    free_picture(&b);
}

/* What the last frames of both have made. */
static void check_pair(const struct pair *p, uint32_t round) {
    compare(p, FNL_OUTPUT_MOTION, "motion", round);
    compare(p, FNL_OUTPUT_RADIANCE, "the picture", round);
    const fnl_frame_stats a = harness_stats(p->shares), b = harness_stats(p->lone);
    assert_int_equal(a.items, b.items);
    assert_int_equal(a.items_visible, b.items_visible);
    assert_int_equal(a.lights_in_view, b.lights_in_view);
    assert_int_equal(a.triangles_visible, b.triangles_visible);
}

static void shoot_pair(struct pair *p, uint32_t round) {
    test_render_frame(p->shares, &p->frame);
    test_render_frame(p->lone, &p->frame);
    check_pair(p, round);
}

static struct device_scene *shared(const struct pair *p) { return p->shares->device_scene; }

/* The stage's renderer shares, too, and never renders. */
static struct world open_world(void) {
    struct world w = world_open();
    w.stage.frame.shading = FNL_SHADING_DEFERRED;
    fnl_material_params look = world_look(&w, true);
    look.base_color_image = w.images[0];
    assert_int_equal(fnl_scene_set_material(w.stage.scene, w.materials[1], &look), FNL_OK);
    return w;
}

static void close_world(struct world *w) { stage_close(&w->stage); }

/* ---- what the second costs ---- */

static uint64_t device_bytes(void) {
    assert_int_equal(gpu_wait_idle(harness_device()), FNL_OK);
    return gpu_memory_stats(harness_device()).used_bytes;
}

static uint64_t geometry_bytes(const struct device_scene *d) {
    const struct gpu_buffer *buffers[] = {&d->positions,  &d->attributes,       &d->indices,          &d->clusters,
                                          &d->instances,  &d->primitives.buffer, &d->materials.buffer, &d->items.buffer,
                                          &d->lights,     &d->bound_buffer};
    uint64_t bytes = 0;
    for (uint32_t i = 0; i < COUNT_OF(buffers); i++) bytes += buffers[i]->size;
    for (uint32_t i = 0; i < d->images.count; i++)
        if (d->images.data[i].gpu.handle) bytes += d->images.data[i].gpu.params.width * d->images.data[i].gpu.params.height * 4ull;
    return bytes;
}

static void test_second_renderer_uploads_nothing(void **state) {
    UNUSED(state);
    struct world w = open_world();
    world_add_mesh(&w, 150, true);
    fnl_instance_id id;
    const fnl_mat4 identity = mat4_identity();
    assert_int_equal(fnl_scene_add_instance(w.stage.scene, w.meshes[w.mesh_count - 1], &identity, &id), FNL_OK);
    struct pair first = open_pair(&w);
    for (uint32_t i = 0; i < 3; i++) shoot_pair(&first, i);
    const struct device_scene *d = shared(&first);
    const uint64_t bytes = d->bytes_uploaded, images = d->image_upload_count, structures = d->upload_count;
    assert_true(bytes > 1 << 20 && images > 0);
    uint64_t took[2];
    for (int alone = 0; alone < 2; alone++) {
        uint64_t before = device_bytes();
        fnl_renderer *second = alone ? open_lone(&w) : open_shared(&w);
        test_render_frame(second, &first.frame);
        fnl_image picture = test_read(second, FNL_OUTPUT_RADIANCE), expected = test_read(first.lone, FNL_OUTPUT_RADIANCE);
        assert_true(test_equal(&picture, &expected));
        free_picture(&picture);
        free_picture(&expected);
        took[alone] = device_bytes() - before;
        assert_true((second->device_scene == d) == !alone);
        assert_int_equal(d->bytes_uploaded, bytes);
        assert_int_equal(d->image_upload_count, images);
        assert_int_equal(d->upload_count, structures);
        if (!alone) assert_int_equal(d->light_bytes_sent, 0);
        close_renderer(&second);
    }
    print_message("a second renderer takes %llu bytes of device memory; one that shares nothing %llu; the scene has %llu\n",
                  (unsigned long long)took[0], (unsigned long long)took[1], (unsigned long long)geometry_bytes(d));
    assert_true(took[1] >= took[0] + geometry_bytes(d));
    close_pair(&first);
    close_world(&w);
}

static void test_either_goes_first(void **state) {
    UNUSED(state);
    uint64_t left = 0;
    for (uint32_t order = 0; order < 4; order++) {
        struct world w = open_world();
        struct pair pairs[2] = {open_pair(&w), open_pair(&w)};
        assert_ptr_equal(shared(&pairs[0]), shared(&pairs[1]));
        for (uint32_t i = 0; i < 4; i++) {
            world_edit(&w);
            shoot_pair(&pairs[i % 2], i);
        }
        close_pair(&pairs[order % 2]); /* with its last frame under way */
        struct pair *stays = &pairs[1 - order % 2];
        const uint64_t images = shared(stays)->image_upload_count;
        shoot_pair(stays, 4);
        for (uint32_t i = 0; i < 4; i++) world_edit_instance(&w);
        shoot_pair(stays, 5);
        assert_int_equal(shared(stays)->image_upload_count, images);
        close_pair(stays);
        close_world(&w);
        assert_null(*gpu_shared(harness_device()));
        if (order == 1) left = device_bytes(); /* the first rounds warm what the device keeps */
        if (order > 1) assert_int_equal(device_bytes(), left);
    }
}

/* ---- edits between frames of both ---- */

struct way {
    fnl_shading shading;
    fnl_light_lists lists;
    fnl_culling culling;
    fnl_antialiasing aa;
    uint32_t msaa;
    float light_lod;
    bool motion, counts;
};

static void go(struct pair *p, const struct way *way) {
    p->frame.shading = way->shading;
    p->frame.lists = way->lists;
    p->frame.culling = way->culling;
    p->frame.aa = way->aa;
    p->frame.msaa = MAX(way->msaa, 1u);
    p->frame.light_lod = way->light_lod;
    p->frame.count_lights = way->counts;
    p->frame.outputs = FNL_OUTPUT_RADIANCE | (way->motion ? FNL_OUTPUT_MOTION : 0);
}

/* By round, for each of two. The first asks for motion in every frame, so that what its last one drew is known. */
static const struct way ways[][2] = {
    {{FNL_SHADING_DEFERRED, FNL_LISTS_TILED, FNL_CULLING_TRIANGLES, FNL_ANTIALIASING_TAA, .motion = true},
     {FNL_SHADING_FORWARD, FNL_LISTS_CLUSTERED, FNL_CULLING_INSTANCES, .msaa = 4, .light_lod = 8}},
    {{FNL_SHADING_DEFERRED, FNL_LISTS_CLUSTERED_CPU, FNL_CULLING_CLUSTERS, FNL_ANTIALIASING_TAA, .motion = true},
     {FNL_SHADING_DEFERRED, FNL_LISTS_CLUSTERED_CPU, FNL_CULLING_TRIANGLES, .light_lod = 8, .counts = true}},
    {{FNL_SHADING_DEFERRED, FNL_LISTS_WORLD, FNL_CULLING_TRIANGLES, .motion = true},
     {FNL_SHADING_VIRTUAL_TEXTURING, FNL_LISTS_ALL, FNL_CULLING_CLUSTERS, .msaa = 1}}};

/*
 * One who shares everything, one who renders now and then, and a witness who shares nothing and renders whenever one of them does: what the
 * two send together is what it sends.
 */
static void test_edits_are_sent_once_and_shown_by_both(void **state) {
    UNUSED(state);
    struct world w = open_world();
    struct pair pairs[2] = {open_pair(&w), open_pair(&w)};
    struct pair witness = {.lone = open_lone(&w), .frame = w.stage.frame};
    witness.frame.width = 17;
    witness.frame.height = 9;
    struct random_state random = {5};
    uint32_t missed = 0, longest = 0;
    for (uint32_t round = 0; round < 36; round++) {
        for (uint32_t i = 0; i < 1 + round % 5; i++) world_edit(&w);
        const uint32_t who = random_bits(&random) % 3 == 0;
        missed = who ? 0 : missed + 1;
        longest = MAX(longest, missed);
        struct pair *p = &pairs[who];
        go(p, &ways[round % COUNT_OF(ways)][who]);
        harness_hooks(p->shares)->force_async = round % 2;
        /* What goes and comes back while a renderer makes no frame is new to it, if another makes one meanwhile. */
        assert_int_equal(device_scene_prepare(pairs[!who].lone->device_scene), FNL_OK);
        shoot_pair(p, round);
        test_render_frame(witness.lone, &witness.frame);
        const struct device_scene *d = shared(p), *all = witness.lone->device_scene;
        assert_true(d != all && d != p->lone->device_scene);
        assert_int_equal(d->bytes_uploaded, all->bytes_uploaded);
        assert_int_equal(d->image_upload_count, all->image_upload_count);
        assert_int_equal(d->upload_count, all->upload_count);
        assert_int_equal(d->light_bytes_sent, all->light_bytes_sent);
    }
    assert_true(longest >= 3);
    for (int i = 0; i < 2; i++) close_pair(&pairs[i]);
    close_pair(&witness);
    close_world(&w);
}

/* ---- what the last frame drew ---- */

static void turn_all(struct world *w, float by) {
    for (uint32_t i = 0; i < INSTANCES; i++) {
        if (!w->instance_there[i]) continue;
        const mat4 turned = mat4_mul(w->stage.scene->nodes.data[w->instances[i].index].world,
                                     mat4_from_trs((vec3){by, 0, 0}, quat_identity(), (vec3){1, 1, 1}));
        assert_int_equal(fnl_scene_set_instance_transform(w->stage.scene, w->instances[i], &turned), FNL_OK);
    }
}

/* Passes of the last frame whose names begin so. */
static uint32_t count_passes(fnl_renderer *renderer, const char *begin) {
    static char plan[1 << 20];
    char quoted[64];
    uint32_t count = 0;
    assert_true(fnl_renderer_print(renderer, FNL_PRINT_PLAN, plan, sizeof plan) < sizeof plan);
    snprintf(quoted, sizeof quoted, "'%s", begin);
    for (const char *at = plan; (at = strstr(at, quoted)); at++) count++;
    return count;
}

/* Those that copy what frames drew. */
static uint32_t count_keeps(fnl_renderer *renderer) { return count_passes(renderer, "keep previous"); }

/* It is kept once, for those who will ask, and only when a frame is about to overwrite it. */
static void test_what_is_kept(void **state) {
    UNUSED(state);
    struct world w = open_world();
    struct pair asks = open_pair(&w), other = open_pair(&w);
    asks.frame.outputs |= FNL_OUTPUT_MOTION;
    shoot_pair(&asks, 0);
    assert_int_equal(count_keeps(asks.shares), 0);
    shoot_pair(&other, 1);
    assert_int_equal(count_keeps(other.shares), 0); /* nothing moves */
    for (uint32_t i = 0; i < 3; i++) {
        turn_all(&w, 0.02f);
        shoot_pair(&other, 2 + i);
        assert_int_equal(count_keeps(other.shares), i == 0);
    }
    shoot_pair(&asks, 5);
    assert_int_equal(count_keeps(asks.shares), 0); /* another has done it */
    assert_int_equal(count_passes(asks.shares, "update ") + count_passes(asks.shares, "skin"), 0); /* and sent and deformed all */
    assert_int_equal(count_passes(asks.lone, "update instances"), 1);
    assert_int_equal(count_passes(asks.lone, "skin"), 1);
    turn_all(&w, 0.02f);
    shoot_pair(&asks, 6);
    assert_int_equal(count_keeps(asks.shares), 1);
    asks.frame.outputs = FNL_OUTPUT_RADIANCE;
    shoot_pair(&asks, 7);
    turn_all(&w, 0.02f);
    shoot_pair(&other, 8);
    assert_int_equal(count_keeps(other.shares), 0); /* the last frame did not ask */

    /* So what that drew is not known, and it was as good as the first. */
    asks.frame.outputs |= FNL_OUTPUT_MOTION;
    test_render_frame(asks.shares, &asks.frame);
    fnl_frame reset = asks.frame;
    reset.reset_history = true;
    test_render_frame(asks.lone, &reset);
    check_pair(&asks, 9);
    turn_all(&w, 0.02f);
    shoot_pair(&asks, 10);
    close_pair(&asks);
    close_pair(&other);
    close_world(&w);
}

/* What was kept knows neither instances nor vertices that came later, and a mesh that was replaced meanwhile has not moved. */
static void test_growth_after_keeping(void **state) {
    UNUSED(state);
    struct world w = open_world();
    struct pair asks = open_pair(&w), other = open_pair(&w);
    asks.frame.outputs |= FNL_OUTPUT_MOTION;
    shoot_pair(&asks, 0);
    fnl_mesh_params mesh = world_sheet(&w, 12); /* behind the vertices that deform */
    float *larger = malloc(mesh.vertex_count * 12);
    for (uint32_t i = 0; i < 3 * mesh.vertex_count; i++) larger[i] = 1.3f * mesh.positions[i];
    mesh.material = w.materials[0];
    fnl_mesh_id id;
    fnl_instance_id instance;
    const mat4 stands = mat4_from_trs((vec3){0.3f, 0, 0.6f}, quat_identity(), (vec3){0.7f, 0.7f, 1});
    assert_int_equal(fnl_scene_add_mesh(w.stage.scene, &mesh, &id), FNL_OK);
    assert_int_equal(fnl_scene_add_instance(w.stage.scene, id, &stands, &instance), FNL_OK);
    shoot_pair(&asks, 1);
    const struct device_scene *d = shared(&asks);
    const uint32_t first = d->primitive_places.data[w.stage.scene->meshes.data[id.index].first_primitive].first_vertex;
    assert_true(first >= d->first_deformed && first < d->first_deformed + d->deformed_vertex_count);
    turn_all(&w, 0.02f);
    shoot_pair(&other, 2);
    assert_int_equal(asks.shares->scene_user.last, DEVICE_LAST_KEPT);
    const fnl_mesh_params replaced = {.vertex_count = mesh.vertex_count, .index_count = mesh.index_count,
                                      .positions = larger, .uv = mesh.uv, .indices = mesh.indices, .material = mesh.material};
    assert_int_equal(fnl_scene_set_mesh(w.stage.scene, id, 0, &replaced), FNL_OK);
    for (uint32_t i = 0; i < 400; i++) {
        const mat4 small = mat4_from_trs((vec3){-1.5f + 0.15f * (float)(i % 20), -1 + 0.1f * (float)(i / 20), 1}, quat_identity(),
                                         (vec3){0.05f, 0.05f, 1});
        assert_int_equal(fnl_scene_add_instance(w.stage.scene, w.meshes[i % 4], &small, &instance), FNL_OK);
    }
    shoot_pair(&asks, 3);
    assert_true(asks.shares->scene_user.kept.instance_count < d->instances_taken.end);
    world_free_sheet(&mesh);
    free(larger);
    close_pair(&asks);
    close_pair(&other);
    close_world(&w);
}

/* One that sleeps while thousands of instances come, in places apart, begins anew; what is remembered of them does not grow for ever. */
static void test_one_that_misses_thousands(void **state) {
    UNUSED(state);
    enum { MANY = 8400 };
    struct world w = open_world();
    fnl_instance_id *ids = malloc(MANY * sizeof *ids);
    const fnl_mat4 away = mat4_from_trs((vec3){500, 0, 0}, quat_identity(), (vec3){1, 1, 1});
    for (uint32_t i = 0; i < MANY; i++)
        assert_int_equal(fnl_scene_add_instance(w.stage.scene, w.meshes[0], &away, &ids[i]), FNL_OK);
    struct pair sleeps = open_pair(&w), other = open_pair(&w);
    sleeps.frame.outputs |= FNL_OUTPUT_MOTION;
    sleeps.frame.aa = FNL_ANTIALIASING_TAA;
    for (uint32_t i = 0; i < 2; i++) shoot_pair(&sleeps, i);
    uint32_t most = 0;
    for (uint32_t round = 0; round < 2; round++) {
        for (uint32_t i = 0; i < MANY; i += 2)
            assert_int_equal(fnl_scene_set_instance_visible(w.stage.scene, ids[i], round % 2), FNL_OK);
        shoot_pair(&other, 2 + round);
        most = MAX(most, shared(&other)->arrived.count);
    }
    assert_true(most > MANY / 2 - 8 && most < MANY / 2 + 8);
    assert_int_not_equal(sleeps.shares->scene_user.last, DEVICE_LAST_UNKNOWN); /* until more arrive */
    world_add_instance(&w, 20);
    shoot_pair(&other, 6);
    assert_int_equal(sleeps.shares->scene_user.last, DEVICE_LAST_UNKNOWN);
    assert_true(shared(&other)->arrived.count <= 1);
    fnl_frame reset = sleeps.frame;
    reset.reset_history = true;
    test_render_frame(sleeps.shares, &sleeps.frame);
    test_render_frame(sleeps.lone, &reset);
    check_pair(&sleeps, 7);
    turn_all(&w, 0.02f);
    shoot_pair(&sleeps, 8);
    free(ids);
    close_pair(&sleeps);
    close_pair(&other);
    close_world(&w);
}

/* ---- frames that fail, or are only declared ---- */

static void test_failed_frames_harm_nobody(void **state) {
    UNUSED(state);
    struct world w = open_world();
    struct pair fails = open_pair(&w), other = open_pair(&w);
    other.frame.outputs |= FNL_OUTPUT_MOTION;
    other.frame.aa = FNL_ANTIALIASING_TAA;
    fails.frame.outputs |= FNL_OUTPUT_MOTION; /* so each keeps what the other overwrites */
    uint32_t whole = 0, spared = 0;
    test_device_memory.loud = false;
    for (uint32_t n = 0; n < 24; n++) {
        const bool edits = n % 2; /* else nothing is uploaded, and memory runs out while the frame is declared */
        shoot_pair(&fails, n);
        shoot_pair(&other, n);
        for (uint32_t i = 0; edits && i < 3; i++) world_edit(&w);
        turn_all(&w, 0.01f);
        fails.frame.light_lod = 8; /* two arrays that need memory while the frame is declared, the second after lights and moves: */
        fails.frame.lists = FNL_LISTS_CLUSTERED_CPU;
        struct graph *graph = fails.shares->graph;
        array_free(&graph->host, &graph->passes);
        array_free(&shared(&fails)->host, &shared(&fails)->bound_radii);
        test_device_memory.fail_at = test_device_memory.allocations + 1 + n / (edits ? 2 : 8);
        const fnl_result result = fnl_renderer_render(fails.shares, &fails.frame);
        test_device_memory.fail_at = 0;
        const bool failed = result != FNL_OK;
        struct device_scene *d = shared(&other);
        const bool lost = d->structure_version == UINT64_MAX;
        const uint64_t bytes = d->bytes_uploaded, structures = d->upload_count;
        fnl_frame frame = other.frame;
        frame.reset_history = lost; /* all that was there is uploaded again */
        test_render_frame(other.shares, &other.frame);
        test_render_frame(other.lone, &frame);
        check_pair(&other, n);
        if (failed && !lost) {
            assert_int_equal(d->bytes_uploaded, bytes);
            assert_int_equal(d->upload_count, structures);
        }
        whole += failed && lost;
        spared += failed && !lost;
        frame = fails.frame;
        frame.reset_history = failed;
        if (failed) test_render_frame(fails.shares, &frame);
        test_render_frame(fails.lone, &frame);
        check_pair(&fails, n);
    }
    test_device_memory.loud = true;
    print_message("after %u failures all was uploaded again, after %u nothing\n", whole, spared);
    assert_true(whole >= 3 && spared >= 6);
    close_pair(&fails);
    close_pair(&other);
    close_world(&w);
}

/* Warming declares a frame that sends nothing; what it uploads is there. Nor does it disturb what frames drew. */
static void test_warming_harms_nobody(void **state) {
    UNUSED(state);
    struct world w = open_world();
    struct pair warms = open_pair(&w), other = open_pair(&w);
    warms.frame.outputs = other.frame.outputs |= FNL_OUTPUT_MOTION;
    for (uint32_t round = 0; round < 6; round++) {
        for (uint32_t i = 0; i < 3; i++) world_edit(&w);
        turn_all(&w, 0.01f);
        fnl_frame frame = warms.frame;
        frame.outputs = FNL_OUTPUT_RADIANCE;
        assert_int_equal(fnl_renderer_warm(warms.shares, &frame, NULL, true, NULL), FNL_OK);
        const uint64_t bytes = shared(&warms)->bytes_uploaded;
        if (round % 2 == 0) turn_all(&w, 0.01f);
        shoot_pair(&other, round);
        assert_int_equal(shared(&warms)->bytes_uploaded, bytes);
        if (round > 2) shoot_pair(&warms, round);
    }
    close_pair(&warms);
    close_pair(&other);
    close_world(&w);
}

/* ---- results, order on the device ---- */

/* Numbers are those of the frame, whatever others did to the scene since. */
static void test_numbers_stay_those_of_the_frame(void **state) {
    UNUSED(state);
    struct world w = open_world();
    struct pair counts = open_pair(&w), other = open_pair(&w);
    counts.frame.count_lights = true;
    shoot_pair(&counts, 0);
    const fnl_frame_stats before = harness_stats(counts.shares);
    assert_true(before.triangles_visible > 0);
    fnl_light_params sun = fnl_light_params_default();
    sun.kind = FNL_LIGHT_DIRECTIONAL;
    fnl_light_id id;
    assert_int_equal(fnl_scene_add_light(w.stage.scene, &sun, &id), FNL_OK);
    for (uint32_t i = 0; i < INSTANCES; i++) {
        if (!w.instance_there[i] || i % 3 == 0) continue;
        assert_int_equal(fnl_scene_remove_instance(w.stage.scene, w.instances[i]), FNL_OK);
        w.instance_there[i] = false;
    }
    shoot_pair(&other, 1);
    check_pair(&counts, 2);
    const fnl_frame_stats after = harness_stats(counts.shares);
    assert_int_equal(after.triangles_visible, before.triangles_visible);
    assert_int_equal(after.lights_in_view, before.lights_in_view);
    close_pair(&counts);
    close_pair(&other);
    close_world(&w);
}

/* Whether a pass of the last frame waits for earlier uses of a buffer. */
static bool waits(fnl_renderer *renderer, const char *pass, const char *buffer) {
    static char plan[1 << 20];
    char heading[64];
    assert_true(fnl_renderer_print(renderer, FNL_PRINT_PLAN, plan, sizeof plan) < sizeof plan);
    snprintf(heading, sizeof heading, " '%s' ", pass);
    char *at = strstr(plan, heading);
    if (!at) fail_msg("no pass %s", pass);
    char *end = strstr(at, "\n  pass ");
    if (end) *end = 0;
    at = strstr(at, "    barrier ");
    if (at && strchr(at, '\n')) *strchr(at, '\n') = 0;
    return at && strstr(at, buffer);
}

/* The first frame of one waits for what the other's last frame did to what they share: of validation, no rule looks at buffers by address. */
static void test_frames_wait_for_each_other(void **state) {
    UNUSED(state);
    struct world w = open_world();
    struct pair first = open_pair(&w), second = open_pair(&w);
    first.frame.culling = second.frame.culling = FNL_CULLING_CLUSTERS;
    shoot_pair(&first, 0);
    assert_false(waits(first.shares, "cull clusters fill", "indices"));
    turn_all(&w, 0.01f);
    shoot_pair(&second, 1);
    assert_true(waits(second.shares, "cull clusters fill", "indices"));
    assert_true(waits(second.shares, "update instances", "scene vertices"));
    assert_false(waits(second.lone, "cull clusters fill", "indices"));
    turn_all(&w, 0.01f);
    shoot_pair(&first, 2);
    assert_true(waits(first.shares, "cull clusters fill", "indices"));
    assert_true(waits(first.shares, "update instances", "scene vertices"));
    close_pair(&first);
    close_pair(&second);
    close_world(&w);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_second_renderer_uploads_nothing, check),
        cmocka_unit_test_teardown(test_either_goes_first, check),
        cmocka_unit_test_teardown(test_edits_are_sent_once_and_shown_by_both, check),
        cmocka_unit_test_teardown(test_what_is_kept, check),
        cmocka_unit_test_teardown(test_growth_after_keeping, check),
        cmocka_unit_test_teardown(test_one_that_misses_thousands, check),
        cmocka_unit_test_teardown(test_failed_frames_harm_nobody, check),
        cmocka_unit_test_teardown(test_warming_harms_nobody, check),
        cmocka_unit_test_teardown(test_numbers_stay_those_of_the_frame, check),
        cmocka_unit_test_teardown(test_frames_wait_for_each_other, check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
