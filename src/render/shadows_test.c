/* SPDX-License-Identifier: MIT */
/* Frames with shadows by rays: against shadows whose edges are known, against the tracer, in all shading paths, and what the trees cost. */
#include "tests/render_harness.h"
#include "tests/shadow_cases.h"
#include "tests/shadow_leak.h"
#include "tests/shadow_paths.h"

#include "fanal/trace.h"
#include "gpu/specialise.h"
#include "lighting/lighting_shared.h"
#include "render/renderer_internal.h"
#include "shaders.h"

/* ---- shadows whose edges are known ---- */

static void measure(fnl_scene *scene, const fnl_trace_params *view, float *out) {
    struct stage s = shadow_stage(scene, view);
    s.frame.shadows = FNL_SHADOWS_RAYS;
    shadow_parts(&s, out);
    stage_close(&s);
}

static void test_known_shadows(void **state) {
    UNUSED(state);
    shadow_cases(&(struct shadow_cases){measure, 1e-3, 1e-3, true}); /* radiance is kept in 16 bits */
}

/* A sun from the left above: the shadow of a square one metre up is shifted by half a metre. */
static void test_shadow_of_a_sun(void **state) {
    UNUSED(state);
    fnl_scene *scene = world_create(NULL);
    fnl_material_params white = matt(1);
    add_square(scene, &white, (vec3){10, 1, 10}, (vec3){0, 0, 0});
    add_square(scene, &white, (vec3){1, 1, 1}, (vec3){0, 1, 0});
    fnl_light_params sun = fnl_light_params_default();
    fnl_light_id id;
    sun.kind = FNL_LIGHT_DIRECTIONAL;
    sun.direction = (vec3){0.5f, -1, 0};
    sun.intensity = 10;
    assert_int_equal(fnl_scene_add_light(scene, &sun, &id), FNL_OK);
    const fnl_trace_params view = look_down((vec3){0, 0, 0}, 8, 0.5f, SHADOW_SIZE);
    float seen[SHADOW_SIZE * SHADOW_SIZE];
    measure(scene, &view, seen);
    for (uint32_t i = 0; i < SHADOW_SIZE * SHADOW_SIZE; i++) {
        double x = (i % SHADOW_SIZE + 0.5) / SHADOW_SIZE * 8 - 4, z = (double)(i / SHADOW_SIZE + 0.5f) / SHADOW_SIZE * 8 - 4;
        double inside = fmin(1 - fabs(x - 0.5), 1 - fabs(z));
        if (fabs(inside) > 1e-3) assert_float_equal(seen[i], inside > 0 ? 0 : 1, 1e-3);
    }
}

/* ---- against the tracer, which is another program with other trees in double precision ---- */

/* Decibels of the pictures, and the part of pixels that differ by more than 8 of 255: those at the edges of shadows. */
static void expect_traced(const char *source, double seconds, uint32_t scattered, double psnr, double edges) {
    struct stage s = stage_open(source, scattered);
    s.frame.shading = FNL_SHADING_FORWARD;
    s.frame.transparency = FNL_TRANSPARENCY_LINKED;
    s.frame.shadows = FNL_SHADOWS_RAYS;
    if (seconds > 0) { /* after a frame in another pose */
        assert_int_equal(fnl_renderer_render(s.renderer, &s.frame), FNL_OK);
        assert_int_equal(fnl_scene_set_time(s.scene, 0, seconds), FNL_OK);
    }
    struct shot shot = stage_shoot(&s, &s.frame);
    fnl_trace_params p = trace_plain();
    p.width = s.frame.width, p.height = s.frame.height, p.camera = s.frame.camera;
    p.exposure = s.frame.exposure, p.ev = s.frame.ev, p.tonemap = s.frame.tonemap;
    fnl_trace trace;
    assert_int_equal(fnl_scene_trace(s.scene, &p, &trace), FNL_OK);
    fnl_image_difference difference;
    assert_int_equal(fnl_image_compare(NULL, &trace.color, &shot.color, &difference), FNL_OK);
    double beyond = (double)count_beyond(&trace.color, &shot.color, 8) / (s.frame.width * s.frame.height);
    if (difference.psnr < psnr || beyond > edges)
        fail_msg("%s: %.1f dB, %.4f of the pixels differ; must be %g and %g", source, difference.psnr, beyond, psnr, edges);
    fnl_trace_free(&s.scene->host, &trace);
    shot_free(&shot);
    stage_close(&s);
}

static void test_frames_are_what_rays_show(void **state) {
    UNUSED(state);
    expect_traced("builtin:interior?lights=40", 0, 0, 30, 0.01); /* all shapes of lights */
    expect_traced("builtin:glass?lights=40&crossing=1", 0, 0, 30, 0.02);
    expect_traced("builtin:hall?lights=24", 0, 0, 30, 0.02); /* cutouts, a sun, many instances */
}

static void test_animated_frames(void **state) {
    UNUSED(state);
    expect_traced("Fox.glb", 0.4, 60, 35, 0.01);
}

/* ---- paths and lists ---- */

static void test_lists_give_the_same_shadows_ES_69(void **state) {
    UNUSED(state);
    expect_lists_alike(FNL_SHADOWS_RAYS);
}

static void test_paths_give_the_same_shadows(void **state) {
    UNUSED(state);
    expect_paths_alike(FNL_SHADOWS_RAYS, 1);
}

/* Surfaces of one pixel each have shadows of their own. */
static void test_samples_have_shadows(void **state) {
    UNUSED(state);
    struct stage s = stage_open("builtin:interior?lights=40", 0);
    s.frame.msaa = 4, s.frame.ev = 1;
    s.frame.shadows = FNL_SHADOWS_RAYS;
    s.frame.shading = FNL_SHADING_FORWARD;
    struct shot forward = stage_shoot(&s, &s.frame);
    s.frame.shading = FNL_SHADING_DEFERRED;
    struct shot deferred = stage_shoot(&s, &s.frame);
    const uint64_t differing = count_beyond(&forward.color, &deferred.color, 8);
    if (differing > 113 * 65 / 25) fail_msg("%u of %d pixels differ", (uint32_t)differing, 113 * 65);
    shot_free(&forward);
    shot_free(&deferred);
    stage_close(&s);
}

/* A floor of many squares with nothing on it, far from the origin of the world and seen at an angle: where their edges cross a pixel, positions are taken
 * beside its middle, and must still lie in the floor. */
static void test_edges_in_a_floor_cast_no_shadow(void **state) {
    UNUSED(state);
    fnl_scene *scene = world_create(NULL);
    fnl_material_params white = matt(0.5f);
    fnl_mesh_id mesh = add_square_mesh(scene, add_material(scene, &white));
    for (int i = 0; i < 64; i++)
        add_instance(scene, mesh, mat4_mul(mat4_translation((vec3){0.5f * (i % 8) - 1.75f, 20, -0.5f * (i / 8)}), mat4_scaling((vec3){0.25f, 1, 0.25f})));
    add_point_light(scene, (vec3){0, 22, -2}, 200);
    struct stage s = stage_open_scene(scene);
    s.frame.camera.position = (vec3){0.3f, 20.5f, 1};
    s.frame.camera.target = (vec3){-0.2f, 20.1f, -2};
    s.frame.msaa = 4;
    static const fnl_shading paths[] = {FNL_SHADING_FORWARD, FNL_SHADING_FORWARD_PREPASS, FNL_SHADING_DEFERRED};
    static const fnl_shadows kinds[] = {FNL_SHADOWS_RAYS, FNL_SHADOWS_MAPS};
    for (size_t i = 0; i < COUNT_OF(paths); i++) {
        s.frame.shading = paths[i];
        s.frame.shadows = FNL_SHADOWS_OFF;
        struct shot lit = stage_shoot(&s, &s.frame);
        for (size_t k = 0; k < COUNT_OF(kinds); k++) {
            s.frame.shadows = kinds[k];
            struct shot shot = stage_shoot(&s, &s.frame);
            const uint64_t differing = count_beyond(&lit.color, &shot.color, 8);
            if (differing > 0) fail_msg("path %u, shadows %u: %u pixels are in shadow", (uint32_t)paths[i], (uint32_t)kinds[k], (uint32_t)differing);
            shot_free(&shot);
        }
        shot_free(&lit);
    }
    stage_close(&s);
}

/* What part of the light the tracer sees at each pixel. */
static void measure_traced(const fnl_scene *scene, const fnl_trace_params *view, float *out) {
    fnl_trace_params p = *view;
    p.visibility = true;
    fnl_trace trace;
    assert_int_equal(fnl_scene_trace(scene, &p, &trace), FNL_OK);
    for (uint32_t i = 0; i < SHADOW_SIZE * SHADOW_SIZE; i++) out[i] = pixel_at(&trace.visibility, i % SHADOW_SIZE, i / SHADOW_SIZE)[0];
    fnl_trace_free(&scene->host, &trace);
}

/* A shade below a lamp, whose material casts no shadow for a while, and one beside it that always does. Maps that are kept follow the material. */
static void test_SH_60_materials_cast_shadows_or_not(void **state) {
    UNUSED(state);
    enum { MAPS, TREES, QUERIES, TRACED, COUNT };
    fnl_scene *scene = world_create(NULL);
    fnl_material_params white = matt(1), shade = matt(1);
    add_square(scene, &white, (vec3){10, 1, 10}, (vec3){0, 0, 0});
    fnl_material_id material = add_material(scene, &shade);
    add_instance(scene, add_square_mesh(scene, material), mat4_mul(mat4_translation((vec3){0, 1, 0}), mat4_scaling((vec3){0.4f, 1, 0.4f})));
    add_square(scene, &white, (vec3){0.15f, 1, 0.15f}, (vec3){0.8f, 1, 0});
    add_point_light(scene, (vec3){0, 2, 0}, 100);
    const fnl_trace_params view = look_down((vec3){0, 0, 0}, 4, 0.5f, SHADOW_SIZE);
    struct stage s = shadow_stage(scene, &view);
    for (int step = 0; step < 3; step++) {
        shade.casts_shadows = step != 1;
        assert_int_equal(fnl_scene_set_material(scene, material, &shade), FNL_OK);
        for (int kind = 0; kind < COUNT; kind++) {
            float seen[SHADOW_SIZE * SHADOW_SIZE];
            s.frame.shadows = kind == MAPS ? FNL_SHADOWS_MAPS : FNL_SHADOWS_RAYS;
            s.frame.shadow.ray_backend = kind == QUERIES ? FNL_RAY_BACKEND_RAY_QUERY : FNL_RAY_BACKEND_BVH;
            if (kind == TRACED) measure_traced(scene, &view, seen);
            else shadow_parts(&s, seen);
            for (uint32_t i = 0; i < SHADOW_SIZE * SHADOW_SIZE; i++) {
                double x = (i % SHADOW_SIZE + 0.5) / SHADOW_SIZE * 4 - 2, z = (double)(i / SHADOW_SIZE + 0.5f) / SHADOW_SIZE * 4 - 2;
                double below = fmax(fabs(x), fabs(z)) - 0.8, beside = fmax(fabs(x - 1.6), fabs(z)) - 0.3; /* shadows are twice as wide as what casts them */
                const bool dark = (below < 0 && shade.casts_shadows) || beside < 0;
                if (fmin(fabs(below), fabs(beside)) > 0.1 && fabsf(seen[i] - (dark ? 0.0f : 1.0f)) > 1e-3f)
                    fail_msg("step %d, kind %d: %g of the light at %.2f, %.2f", step, kind, (double)seen[i], x, z);
            }
        }
    }
    stage_close(&s);
}

/* ---- the trees ---- */

enum { MADE_MESHES = 1, MADE_ITEMS = 2 };

/* Which trees the next frame makes. */
static int makes(struct stage *s) {
    int made = 0;
    s->frame.timers = true;
    s->frame.shadows = FNL_SHADOWS_RAYS;
    assert_int_equal(fnl_renderer_render(s->renderer, &s->frame), FNL_OK);
    fnl_frame_stats stats = harness_stats(s->renderer);
    for (uint32_t i = 0; i < stats.pass_count; i++) {
        if (strcmp(stats.passes[i].name, "ray meshes boxes") == 0) made |= MADE_MESHES;
        if (strcmp(stats.passes[i].name, "ray items boxes") == 0) made |= MADE_ITEMS;
    }
    return made;
}

static void test_trees_are_made_when_something_changes(void **state) {
    UNUSED(state);
    fnl_scene *scene = shadow_floor();
    fnl_material_params material = matt(1);
    fnl_mesh_id mesh = add_square_mesh(scene, add_material(scene, &material));
    fnl_instance_id instance = add_instance(scene, mesh, mat4_translation((vec3){0, 1, 0}));
    struct stage s = stage_open_scene(scene);
    s.frame.shadows = FNL_SHADOWS_OFF;
    assert_int_equal(fnl_renderer_render(s.renderer, &s.frame), FNL_OK);
    assert_null(s.renderer->device_scene->ray_meshes.handle); /* frames without shadows pay nothing */
    assert_int_equal(makes(&s), MADE_MESHES | MADE_ITEMS);
    assert_int_equal(makes(&s), 0);
    s.frame.camera.position.x += 1;
    assert_int_equal(makes(&s), 0);
    mat4 moved = mat4_translation((vec3){1, 1, 0});
    assert_int_equal(fnl_scene_set_instance_transform(scene, instance, &moved), FNL_OK);
    assert_int_equal(makes(&s), MADE_ITEMS);
    assert_int_equal(makes(&s), 0);
    add_instance(scene, mesh, mat4_translation((vec3){3, 1, 0}));
    assert_int_equal(makes(&s), MADE_ITEMS);
    assert_int_equal(makes(&s), 0);
    mesh = add_square_mesh(scene, add_material(scene, &material));
    assert_int_equal(makes(&s), MADE_MESHES | MADE_ITEMS);
    assert_int_equal(makes(&s), 0);
    device_scene_forget(s.renderer->device_scene); /* as after an error: everything comes anew */
    assert_int_equal(makes(&s), MADE_MESHES | MADE_ITEMS);
    stage_close(&s);
    s = stage_open("Fox.glb", 1);
    assert_int_equal(makes(&s), MADE_MESHES | MADE_ITEMS);
    assert_int_equal(makes(&s), 0);
    assert_int_equal(fnl_scene_set_time(s.scene, 0, 0.4), FNL_OK);
    assert_int_equal(makes(&s), MADE_MESHES | MADE_ITEMS);
    stage_close(&s);
}

/* What stands in a tree, as the device has it. */
struct tree {
    struct gpu_ray_node *nodes;
    uint32_t *next, *ids;
    uint32_t count;
};

static double area(const struct gpu_ray_node *n) {
    double x = (double)(n->high.x - n->low.x), y = (double)(n->high.y - n->low.y), z = (double)(n->high.z - n->low.z);
    return x * y + y * z + z * x;
}

/* Goes through what is below a reference, from leaf `first` on; returns the last leaf. Boxes are in those of their parents. Sums areas up. */
static uint32_t walk(const struct tree *t, uint32_t reference, uint32_t first, const struct gpu_ray_node *parent, bool *seen, double *sum) {
    if (reference & RAY_LEAF) {
        assert_int_equal(reference & ~RAY_LEAF, first);
        assert_true(t->ids[first] < t->count && !seen[t->ids[first]]);
        seen[t->ids[first]] = true;
        return first;
    }
    const struct gpu_ray_node *n = &t->nodes[reference];
    assert_true(n->low.x <= n->high.x && n->low.y <= n->high.y && n->low.z <= n->high.z);
    if (parent)
        assert_true(n->low.x >= parent->low.x && n->low.y >= parent->low.y && n->low.z >= parent->low.z &&
                    n->high.x <= parent->high.x && n->high.y <= parent->high.y && n->high.z <= parent->high.z);
    *sum += area(n);
    uint32_t middle = walk(t, n->first, first, n, seen, sum), last = walk(t, t->next[middle], middle + 1, n, seen, sum);
    assert_int_equal(n->last, last);
    return last;
}

/* Every triangle and every item is in its tree once, and boxes are small: halving space costs a few times the root for each level. */
static void test_trees_hold_everything_in_small_boxes(void **state) {
    UNUSED(state);
    struct stage s = stage_open("builtin:hall?lights=16", 0);
    assert_int_equal(makes(&s), MADE_MESHES | MADE_ITEMS);
    const struct device_scene *d = s.renderer->device_scene;
    uint32_t primitive = 0; /* the largest */
    const struct gpu_ray_mesh *table = (const struct gpu_ray_mesh *)(const void *)d->ray_table.sent.data;
    for (uint32_t i = 0; i < d->ray_primitives; i++)
        if (table[i].count > table[primitive].count) primitive = i;
    for (int meshes = 0; meshes < 2; meshes++) {
        const struct gpu_buffer *buffer = meshes ? &d->ray_meshes : &d->ray_items;
        struct tree t = {.count = meshes ? d->ray_triangles : d->item_count};
        assert_true(t.count > 100);
        char *bytes = malloc(buffer->size);
        assert_int_equal(gpu_wait_idle(d->device), FNL_OK);
        assert_int_equal(gpu_read_buffer(d->device, buffer, 0, bytes, buffer->size), FNL_OK);
        t.nodes = (struct gpu_ray_node *)(void *)bytes;
        t.next = (uint32_t *)(void *)(bytes + t.count * sizeof *t.nodes);
        t.ids = t.next + t.count;
        bool *seen = calloc(t.count, 1);
        double sum = 0;
        assert_int_equal(walk(&t, 0, 0, NULL, seen, &sum), t.count - 1);
        assert_int_equal(t.next[t.count - 1], RAY_END);
        if (meshes) { /* the root of a primitive holds its triangles, and no others */
            const uint32_t *roots = t.ids + t.count;
            const struct gpu_ray_mesh *m = &table[primitive];
            const struct gpu_ray_node *root = &t.nodes[roots[primitive]];
            assert_int_equal(root->last, m->first + m->count - 1);
            for (uint32_t i = 0; i < m->count; i++)
                assert_true(t.ids[m->first + i] >= m->first && t.ids[m->first + i] < m->first + m->count);
            sum = 0;
            memset(seen, 0, t.count);
            walk(&t, roots[primitive], m->first, NULL, seen, &sum);
            print_message("%u triangles: %.1f times the root's area\n", m->count, sum / area(root));
            assert_true(sum < 24 * area(root));
        } else {
            print_message("%u items: %.1f times the root's area\n", t.count, sum / area(&t.nodes[0]));
            assert_true(sum < 42 * area(&t.nodes[0]));
        }
        free(seen);
        free(bytes);
    }
    stage_close(&s);
}

static size_t specialised_words(const struct gpu_shader *shader, uint32_t bits) {
    const fnl_host host = fnl_host_default();
    uint32_t *code = gpu_shader_code(&host, shader);
    assert_non_null(code);
    struct gpu_spirv spirv;
    assert_int_equal(gpu_specialise(&host, code, shader->size / 4, 1, &(struct gpu_constant){0, bits}, &spirv), FNL_OK);
    const size_t count = spirv.count;
    host_free(&host, spirv.words, spirv.size);
    host_free(&host, code, shader->size);
    return count;
}

/* What drivers are given of a shader that lights has no code for shadows where the list has none, nor for kinds of shadow that nobody asked for. */
static void test_shaders_are_small_without_shadows(void **state) {
    UNUSED(state);
    static const struct gpu_shader *const shaders[] = {&shader_forward_early_frag, &shader_deferred_comp,      &shader_light_prepass_lights_comp,
                                                       &shader_coarse_comp,        &shader_texturing_shade_comp, &shader_visibility_shade_comp,
                                                       &shader_dais_shade_comp,    &shader_weighted_frag,      &shader_mobile_glass_wide_frag};
    for (uint32_t i = 0; i < COUNT_OF(shaders); i++) {
        const size_t all = shaders[i]->size / 4, none = specialised_words(shaders[i], GPU_LIST_TILES), maps = specialised_words(shaders[i], GPU_LIST_TILES | GPU_LIGHTING_MAPS),
                     rays = specialised_words(shaders[i], GPU_LIST_TILES | GPU_LIGHTING_RAYS);
        print_message("%s: %zu words; without shadows %zu, maps %zu, rays %zu\n", shaders[i]->name, all, none, maps, rays);
        assert_true(none * 5 < all * 3 && none < maps && none < rays && maps * 10 < all * 9 && rays * 10 < all * 9);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_known_shadows, harness_check),
        cmocka_unit_test_teardown(test_shadow_of_a_sun, harness_check),
        cmocka_unit_test_teardown(test_frames_are_what_rays_show, harness_check),
        cmocka_unit_test_teardown(test_animated_frames, harness_check),
        cmocka_unit_test_teardown(test_lists_give_the_same_shadows_ES_69, harness_check),
        cmocka_unit_test_teardown(test_paths_give_the_same_shadows, harness_check),
        cmocka_unit_test_teardown(test_samples_have_shadows, harness_check),
        cmocka_unit_test_teardown(test_edges_in_a_floor_cast_no_shadow, harness_check),
        cmocka_unit_test_teardown(test_SH_60_materials_cast_shadows_or_not, harness_check),
        cmocka_unit_test_teardown(test_trees_are_made_when_something_changes, harness_check),
        cmocka_unit_test_teardown(test_trees_hold_everything_in_small_boxes, harness_check),
        cmocka_unit_test(test_shaders_are_small_without_shadows),
    };
    return cmocka_run_group_tests_name("shadows", tests, harness_begin, harness_end);
}
