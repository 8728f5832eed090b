/* SPDX-License-Identifier: MIT */
/* FNL_OUTPUT_OBJECT against every triangle of the scene, one by one, and the same of all that draws it. */
#include "tests/render_test.h"

enum { SIDE = 72 };

static const vec3 corners[4] = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
static const vec4 fading[4] = {{1, 1, 1, 0}, {1, 1, 1, 1}, {1, 1, 1, 1}, {1, 1, 1, 0}}; /* alpha from 0 at the left to 1 at the right */
static const uint32_t two[6] = {0, 1, 2, 0, 2, 3};

static struct scene_primitive square(uint32_t material) {
    return (struct scene_primitive){.material = material, .vertex_count = 4, .index_count = 6, .indices = two, .positions = corners};
}

static uint32_t add_mesh(fnl_scene *scene, struct scene_primitive *primitives, uint32_t count) {
    for (uint32_t i = 0; i < count; i++) assert_int_equal(mesh_complete(&scene->arena, &primitives[i]), FNL_OK);
    return scene_add_mesh(scene, "", primitives, count);
}

static uint32_t add_material(fnl_scene *scene, fnl_alpha_mode mode, float transmission) {
    struct scene_material m = scene_material_default();
    m.alpha_mode = mode;
    m.transmission.strength = transmission;
    m.double_sided = mode == FNL_ALPHA_MASK;
    return scene_add_material(scene, &m);
}

/* A square that a joint carries to the upper left; where its own node stands does not matter. */
static void add_skinned(fnl_scene *scene, uint32_t material) {
    struct scene_primitive p = square(material);
    uint16_t *joints = ARENA_ARRAY(&scene->arena, uint16_t, 16);
    float *weights = ARENA_ARRAY(&scene->arena, float, 16);
    uint32_t *bones = ARENA_ARRAY(&scene->arena, uint32_t, 1);
    mat4 *inverse = ARENA_ARRAY(&scene->arena, mat4, 1), place = mat4_from_trs((vec3){-0.7f, 0.7f, 0.4f}, quat_identity(), (vec3){0.2f, 0.2f, 0.2f});
    for (uint32_t i = 0; i < 16; i++) joints[i] = 0, weights[i] = i % 4 == 0;
    p.joints = joints;
    p.weights = weights;
    p.joint_count = 4;
    const uint32_t node = test_place(scene, add_mesh(scene, &p, 1), (vec3){30, 40, 50}, (vec3){3, 3, 3});
    bones[0] = scene_add_node(scene, "", SCENE_NONE, &place, SCENE_NONE);
    inverse[0] = mat4_identity();
    struct scene_skin skin = {.name = "", .joints = bones, .inverse_bind = inverse, .joint_count = 1};
    assert_true(array_push(&scene->host, &scene->skins, skin));
    scene->nodes.data[node].skin = 0;
}

/* A square that a morph target moves down. */
static void add_morphed(fnl_scene *scene, uint32_t material) {
    static const vec3 moves[4] = {{0, -1, 0}, {0, -1, 0}, {0, -1, 0}, {0, -1, 0}};
    static const struct scene_morph_target target = {moves, NULL, NULL};
    struct scene_primitive p = square(material);
    p.morph_targets = &target;
    p.morph_target_count = 1;
    const uint32_t mesh = add_mesh(scene, &p, 1), node = test_place(scene, mesh, (vec3){0.75f, -0.5f, 0.3f}, (vec3){0.2f, 0.2f, 0.2f});
    scene->meshes.data[mesh].morph_target_count = 1;
    scene->nodes.data[node].morph_weights = ARENA_ARRAY(&scene->arena, float, 1);
    scene->nodes.data[node].morph_weights[0] = 1;
}

struct world {
    fnl_scene *scene;
    uint32_t removed, hidden, sphere;
};

static struct world make_world(void) {
    struct world w = {.scene = test_scene()};
    fnl_scene *s = w.scene;
    const uint32_t plain = add_material(s, FNL_ALPHA_OPAQUE, 0), cutout = add_material(s, FNL_ALPHA_MASK, 0), blended = add_material(s, FNL_ALPHA_BLEND, 0),
                   glass = add_material(s, FNL_ALPHA_OPAQUE, 0.9f), sphere = test_sphere_mesh(s, plain, 9), wall = test_quad_mesh(s, SCENE_NONE);
    test_place(s, wall, (vec3){0.05f, 0.03f, -1}, (vec3){0.93f, 0.93f, 1}); /* the sky shows round it */
    w.removed = test_place(s, wall, (vec3){0, 0, 3}, (vec3){1, 1, 1});
    w.sphere = test_place(s, sphere, (vec3){-0.5f, 0.1f, 0}, (vec3){0.35f, 0.35f, 0.35f});
    test_place(s, sphere, (vec3){0.4f, 0.45f, 0}, (vec3){-0.4f, 0.3f, 0.3f}); /* mirrored */
    struct scene_primitive pair[2] = {square(plain), square(cutout)};
    vec3 *apart = ARENA_ARRAY(&s->arena, vec3, 4);
    for (uint32_t i = 0; i < 4; i++) apart[i] = vec3_add(corners[i], (vec3){2.5f, 0, 0});
    pair[1].positions = apart;
    pair[1].colors = fading;
    test_place(s, add_mesh(s, pair, 2), (vec3){-0.6f, -0.6f, 0.1f}, (vec3){0.25f, 0.2f, 1});
    struct scene_primitive pane = square(blended);
    pane.colors = fading;
    test_place(s, add_mesh(s, &pane, 1), (vec3){0.3f, 0.4f, 0.8f}, (vec3){0.3f, 0.1f, 1});
    test_place(s, test_quad_mesh(s, glass), (vec3){-0.5f, 0.2f, 0.9f}, (vec3){0.2f, 0.1f, 1});
    const uint32_t many = test_place(s, test_quad_mesh(s, plain), (vec3){0.2f, -0.2f, 0.5f}, (vec3){1, 1, 1});
    mat4 *places = ARENA_ARRAY(&s->arena, mat4, 3);
    for (int i = 0; i < 3; i++) places[i] = mat4_from_trs((vec3){0.2f * (float)i, 0, 0.01f * (float)i}, quat_identity(), (vec3){0.12f, 0.05f, 1});
    s->nodes.data[many].instances = places;
    s->nodes.data[many].instance_count = 3;
    w.hidden = test_place(s, wall, (vec3){0, 0, 2}, (vec3){1, 1, 1});
    add_skinned(s, plain);
    add_morphed(s, plain);
    scene_structure_changed(s);
    scene_update_transforms(s);
    assert_int_equal(fnl_scene_remove_instance(s, (fnl_instance_id){w.removed, s->nodes.data[w.removed].generation}), FNL_OK);
    assert_int_equal(fnl_scene_set_instance_visible(s, (fnl_instance_id){w.hidden, s->nodes.data[w.hidden].generation}, false), FNL_OK);
    return w;
}

/* ---- the reference ---- */

struct seen {
    double depth;
    float object[3];
    uint32_t primitive, triangle; /* of the scene, and in the mesh's order */
    bool near_edge; /* some edge is so near that either side may be right */
};

static vec3 vertex_of(const fnl_scene *scene, const struct scene_node *node, const struct scene_primitive *p, const mat4 *matrix, uint32_t vertex) {
    vec3 v = p->positions[vertex];
    if (p->morph_target_count) v = vec3_add(v, vec3_scale(p->morph_targets[0].positions[vertex], node->morph_weights[0]));
    return mat4_point(node->skin == SCENE_NONE ? matrix : &scene->nodes.data[scene->skins.data[node->skin].joints[0]].world, v);
}

/* What the vertical line through a point of the picture meets, from above. */
static void look_at(const fnl_scene *scene, const struct scene_node *node, const struct scene_primitive *p, const mat4 *matrix, double x, double y,
                    const float found[3], struct seen *out) {
    const struct scene_material standard = scene_material_default(), *m = p->material == SCENE_NONE ? &standard : &scene->materials.data[p->material];
    for (uint32_t t = 0; t < p->index_count / 3; t++) {
        const uint32_t *own = p->indices + 3 * t;
        double c[3][3], part[3], alpha = 0, z = 0;
        for (int i = 0; i < 3; i++) {
            const vec3 v = vertex_of(scene, node, p, matrix, own[i]);
            c[i][0] = (double)v.x, c[i][1] = (double)v.y, c[i][2] = (double)v.z;
        }
        double area = (c[1][0] - c[0][0]) * (c[2][1] - c[0][1]) - (c[2][0] - c[0][0]) * (c[1][1] - c[0][1]);
        const double facing = mat4_determinant3(matrix) < 0 && node->skin == SCENE_NONE ? -area : area;
        if (fabs(area) < 1e-9 || (facing < 0 && !m->double_sided)) continue;
        bool inside = true, edge = false;
        for (int i = 0; i < 3; i++) {
            const double *a = c[(i + 1) % 3], *b = c[(i + 2) % 3];
            part[i] = ((b[0] - a[0]) * (y - a[1]) - (x - a[0]) * (b[1] - a[1])) / area;
            const double distance = part[i] * fabs(area) / hypot(b[0] - a[0], b[1] - a[1]);
            inside = inside && distance > -1e-3;
            edge = edge || fabs(distance) < 1e-3;
            alpha += part[i] * (double)(p->colors ? p->colors[own[i]].w : 1);
            z += part[i] * c[i][2];
        }
        if (!inside || z < out->depth) continue;
        const double least = m->alpha_mode == FNL_ALPHA_MASK ? (double)m->alpha_cutoff : m->alpha_mode == FNL_ALPHA_BLEND ? 1.0 / 16 : -1;
        if (alpha < least - 1e-3) continue;
        out->depth = z;
        out->near_edge = edge || fabs(alpha - least) < 1e-3;
        memcpy(out->object, found, 3 * sizeof *found);
        out->primitive = (uint32_t)(p - scene->primitives.data);
        out->triangle = t;
    }
}

static struct seen reference(const fnl_scene *scene, double x, double y) {
    struct seen seen = {.depth = -1e30};
    float index = 0;
    for (uint32_t n = 0; n < scene->nodes.count; n++) {
        const struct scene_node *node = &scene->nodes.data[n];
        if (node->removed) continue;
        index++;
        if (node->hidden || node->mesh == SCENE_NONE) continue;
        const struct scene_mesh *mesh = &scene->meshes.data[node->mesh];
        for (uint32_t k = 0; k < node->instance_count; k++) {
            const mat4 matrix = node->instances ? mat4_mul(node->world, node->instances[k]) : node->world;
            for (uint32_t i = 0; i < mesh->primitive_count; i++) {
                const struct scene_primitive *p = &scene->primitives.data[mesh->first_primitive + i];
                const float found[3] = {index, (float)i, p->material == SCENE_NONE ? -1 : (float)p->material};
                look_at(scene, node, p, &matrix, x, y, found, &seen);
            }
        }
    }
    return seen;
}

/* Each triangle has a number of its own, and only one. */
enum { TRIANGLES = 512 };
static void check_triangle(uint32_t numbers[16][TRIANGLES][2], const struct seen *seen, float found) {
    const uint32_t number = (uint32_t)found;
    assert_true(found >= 0 && found == floorf(found) && number < TRIANGLES && seen->triangle < TRIANGLES && seen->primitive < 16);
    uint32_t *triangle_of = &numbers[seen->primitive][number][0], *number_of = &numbers[seen->primitive][seen->triangle][1];
    if (*triangle_of == 0) *triangle_of = seen->triangle + 1;
    if (*number_of == 0) *number_of = number + 1;
    assert_true(*triangle_of == seen->triangle + 1 && *number_of == number + 1);
}

/* Every pixel that is not on an edge. `out_seen`: of each instance, how many pixels show it. */
static void check_picture(const fnl_scene *scene, const fnl_image *image, uint32_t out_seen[32]) {
    static uint32_t numbers[16][TRIANGLES][2];
    uint32_t compared = 0;
    memset(numbers, 0, sizeof numbers);
    memset(out_seen, 0, 32 * sizeof *out_seen);
    for (uint32_t y = 0; y < image->height; y++)
        for (uint32_t x = 0; x < image->width; x++) {
            const struct seen seen = reference(scene, (x + 0.5) / SIDE * 2 - 1, 1 - (y + 0.5) / SIDE * 2);
            if (seen.near_edge) continue;
            const float *p = test_pixel(image, x, y);
            compared++;
            out_seen[(uint32_t)seen.object[0]]++;
            for (int i = 0; i < 3; i++)
                if (p[i] != seen.object[i])
                    fail_msg("pixel %u, %u: %g %g %g, not %g %g %g", x, y, (double)p[0], (double)p[1], (double)p[2], (double)seen.object[0],
                             (double)seen.object[1], (double)seen.object[2]);
            if (seen.object[0] > 0) check_triangle(numbers, &seen, p[3]);
        }
    assert_true(compared > SIDE * SIDE * 4 / 5);
}

static fnl_frame objects_frame(void) {
    fnl_frame frame = test_frame(FNL_OUTPUT_OBJECT);
    frame.width = frame.height = SIDE;
    return frame;
}

/* ---- tests ---- */

static void test_every_pixel_names_its_object(void **state) {
    UNUSED(state);
    struct world w = make_world();
    fnl_renderer *renderer = test_renderer(w.scene);
    const fnl_frame frame = objects_frame();
    uint32_t seen[32];
    test_render_frame(renderer, &frame);
    fnl_image image = test_read(renderer, FNL_OUTPUT_OBJECT);
    check_picture(w.scene, &image, seen);
    /* Sky, wall, both spheres, the pair, pane, glass, the three, the skinned and the morphed one. */
    static const uint32_t there[] = {0, 1, 2, 3, 4, 5, 6, 7, 9, 11};
    for (uint32_t i = 0; i < COUNT_OF(there); i++) assert_true(seen[there[i]] > 20);
    /* After edits the indices are others. */
    free_picture(&image);
    assert_int_equal(fnl_scene_set_instance_visible(w.scene, (fnl_instance_id){w.sphere, w.scene->nodes.data[w.sphere].generation}, false), FNL_OK);
    assert_int_equal(fnl_scene_remove_instance(w.scene, (fnl_instance_id){0, w.scene->nodes.data[0].generation}), FNL_OK);
    test_render_frame(renderer, &frame);
    image = test_read(renderer, FNL_OUTPUT_OBJECT);
    check_picture(w.scene, &image, seen);
    assert_int_equal(seen[1], 0);
    assert_true(seen[2] > 20 && seen[0] > SIDE * SIDE / 4);
    free_picture(&image);
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&w.scene);
}

/* Whatever shades and culls, with MSAA, and with another output besides. */
static void test_all_that_draws_names_the_same(void **state) {
    UNUSED(state);
    struct world w = make_world();
    fnl_renderer *renderer = test_renderer(w.scene);
    fnl_frame frame = objects_frame();
    test_render_frame(renderer, &frame);
    fnl_image usual = test_read(renderer, FNL_OUTPUT_OBJECT);
    uint32_t tried = 0;
    for (uint32_t i = 0; i < FNL_SHADING_AUTO + 8; i++) {
        frame = objects_frame();
        if (i < FNL_SHADING_AUTO) frame.shading = (fnl_shading)i;
        if (!fnl_shading_supports(frame.shading, frame.lists, 1)) frame.lists = FNL_LISTS_CLUSTERED;
        const uint32_t k = i < FNL_SHADING_AUTO ? 0 : i - FNL_SHADING_AUTO + 1;
        if (k == 1 || k == 4) frame.culling = FNL_CULLING_CLUSTERS;
        if (k == 2 || k == 5) frame.culling = FNL_CULLING_TRIANGLES;
        if (k == 4 || k == 5) frame.geometry = FNL_GEOMETRY_MESH;
        if (k == 3 || k == 5 || k == 6) frame.occlusion = FNL_OCCLUSION_ON;
        if (k == 6 || k == 7) frame.msaa = 4;
        if (k == 8) frame.outputs |= FNL_OUTPUT_POSITION | FNL_OUTPUT_COLOR;
        const fnl_result result = fnl_renderer_render(renderer, &frame);
        if (result == FNL_ERROR_UNSUPPORTED) continue;
        assert_int_equal(result, FNL_OK);
        fnl_image image = test_read(renderer, FNL_OUTPUT_OBJECT);
        for (uint32_t y = 0; y < SIDE; y++)
            for (uint32_t x = 0; x < SIDE; x++)
                if (memcmp(test_pixel(&usual, x, y), test_pixel(&image, x, y), 16) != 0)
                    fail_msg("%s, case %u: pixel %u, %u shows %g, not %g", fnl_value_name(FNL_ENUM_SHADING, frame.shading), k, x, y,
                             (double)test_pixel(&image, x, y)[0], (double)test_pixel(&usual, x, y)[0]);
        free_picture(&image);
        tried++;
    }
    assert_true(tried >= 16);
    free_picture(&usual);
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&w.scene);
}

/* Several views each have their own; an empty scene has nothing. */
static void test_views_and_nothing(void **state) {
    UNUSED(state);
    struct world w = make_world();
    fnl_frame frame = objects_frame();
    fnl_image one = test_render(w.scene, &frame, FNL_OUTPUT_OBJECT);
    fnl_camera cameras[2] = {frame.camera, frame.camera};
    cameras[0].position.x += 0.25f;
    cameras[0].target.x += 0.25f;
    frame.views = cameras;
    frame.view_count = 2;
    fnl_image both = test_render(w.scene, &frame, FNL_OUTPUT_OBJECT);
    const size_t half = (size_t)SIDE * SIDE * 16;
    assert_int_equal(both.height, 2 * SIDE);
    assert_memory_equal((const char *)both.pixels + half, one.pixels, half);
    assert_memory_not_equal(both.pixels, one.pixels, half);
    free_picture(&one);
    free_picture(&both);
    fnl_scene_destroy(&w.scene);
    fnl_scene *nothing = test_scene();
    frame = objects_frame();
    one = test_render(nothing, &frame, FNL_OUTPUT_OBJECT);
    for (uint32_t i = 0; i < SIDE * SIDE * 4; i++) assert_true(((const float *)one.pixels)[i] == 0);
    free_picture(&one);
    fnl_scene_destroy(&nothing);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_every_pixel_names_its_object), cmocka_unit_test(test_all_that_draws_names_the_same),
                                       cmocka_unit_test(test_views_and_nothing)};
    return cmocka_run_group_tests_name("objects", tests, test_group_begin, test_group_end);
}
