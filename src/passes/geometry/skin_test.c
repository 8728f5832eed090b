/* SPDX-License-Identifier: MIT */
/** Morphing and skinning against vertices that the CPU moves in double precision. */
#include "passes/geometry/skin_shared.h"
#include "tests/stand_in.h"
#include "tests/render_test.h"

struct moved {
    double position[3], normal[3];
};

/* glTF 2.0, 3.7.2.2 and 3.7.3: morph targets first, then the weighted sum of joint matrices. */
static struct moved move_vertex(const struct scene_primitive *p, uint32_t v, const float *weights, const mat4 *joints,
                                const mat4 *world) {
    const vec3 *sources[2] = {p->positions, p->normals};
    double values[2][3];
    for (int k = 0; k < 2; k++) {
        const float base[3] = {sources[k][v].x, sources[k][v].y, sources[k][v].z};
        for (int c = 0; c < 3; c++) values[k][c] = base[c];
        for (uint32_t t = 0; t < p->morph_target_count; t++) {
            const vec3 *target = k ? p->morph_targets[t].normals : p->morph_targets[t].positions;
            if (!target) continue;
            const float difference[3] = {target[v].x, target[v].y, target[v].z};
            for (int c = 0; c < 3; c++) values[k][c] += (double)weights[t] * difference[c];
        }
    }
    double m[16] = {0};
    if (joints)
        for (uint32_t j = 0; j < p->joint_count; j++)
            for (int c = 0; c < 16; c++)
                m[c] += (double)p->weights[v * p->joint_count + j] * joints[p->joints[v * p->joint_count + j]].m[c];
    else
        for (int c = 0; c < 16; c++) m[c] = world->m[c];
    struct moved out;
    for (int r = 0; r < 3; r++)
        out.position[r] = m[r] * values[0][0] + m[4 + r] * values[0][1] + m[8 + r] * values[0][2] + m[12 + r];
    /* The cofactor matrix is the inverse transpose up to a factor. */
    double cofactor[3][3], length = 0;
    for (int c = 0; c < 3; c++) {
        const double *a = m + (c + 1) % 3 * 4, *b = m + (c + 2) % 3 * 4;
        for (int r = 0; r < 3; r++) cofactor[c][r] = a[(r + 1) % 3] * b[(r + 2) % 3] - a[(r + 2) % 3] * b[(r + 1) % 3];
    }
    double determinant = m[0] * cofactor[0][0] + m[1] * cofactor[0][1] + m[2] * cofactor[0][2];
    for (int r = 0; r < 3; r++) {
        out.normal[r] = (cofactor[0][r] * values[1][0] + cofactor[1][r] * values[1][1] + cofactor[2][r] * values[1][2]) *
                        (determinant < 0 ? -1 : 1);
        length += out.normal[r] * out.normal[r];
    }
    for (int r = 0; r < 3; r++) out.normal[r] /= length > 0 ? sqrt(length) : 1;
    return out;
}

static vec3 decode_normal(uint32_t bits) {
    float x = fmaxf((float)(int16_t)(bits & 0xffff) / 32767, -1), y = fmaxf((float)(int16_t)(bits >> 16) / 32767, -1),
          z = 1 - fabsf(x) - fabsf(y);
    if (z < 0) {
        float folded = (1 - fabsf(y)) * (x < 0 ? -1 : 1);
        y = (1 - fabsf(x)) * (y < 0 ? -1 : 1);
        x = folded;
    }
    return vec3_normalize((vec3){x, y, z});
}

static uint32_t clamp_pixel(double x) { return (uint32_t)CLAMP(x, 0, 127); }

/* Compares all deformed vertices of the last frame, and that pictures show them. `extent`: the size of the scene. */
static void check_vertices(fnl_renderer *renderer, double extent) {
    const struct device_scene *d = renderer->device_scene;
    const fnl_scene *scene = d->scene;
    uint32_t deform_index = 0;
    double worst = 0, worst_angle = 0;
    for (uint32_t i = 0; i < d->deformed.count; i++) {
        const struct device_deform *deform = &d->deformed.data[i];
        const struct scene_node *node = &scene->nodes.data[deform->node];
        const struct scene_mesh *mesh = &scene->meshes.data[node->mesh];
        mat4 *joints = node->skin != SCENE_NONE ? malloc(scene->skins.data[node->skin].joint_count * sizeof *joints) : NULL,
             identity = mat4_identity();
        if (joints) skin_matrices(scene, node->skin, joints);
        const float *weights = node->morph_weights ? node->morph_weights : mesh->morph_weights;
        for (uint32_t k = 0; k < mesh->primitive_count; k++) {
            const struct scene_primitive *p = &scene->primitives.data[mesh->first_primitive + k];
            bool skinned = joints && p->joint_count;
            if (!skinned && !p->morph_target_count) continue;
            struct gpu_deform record;
            assert_int_equal(gpu_read_buffer(test_device, &d->deforms.buffer, deform_index * sizeof record, &record, sizeof record),
                             FNL_OK);
            assert_int_equal(record.count, p->vertex_count);
            vec3 *positions = malloc(p->vertex_count * sizeof *positions);
            struct gpu_attributes *attributes = malloc(p->vertex_count * sizeof *attributes);
            assert_int_equal(
                gpu_read_buffer(test_device, &d->positions, record.target * 12ull, positions, p->vertex_count * 12ull),
                FNL_OK);
            assert_int_equal(gpu_read_buffer(test_device, &d->attributes, record.target * sizeof *attributes, attributes,
                                             p->vertex_count * sizeof *attributes),
                             FNL_OK);
            for (uint32_t v = 0; v < p->vertex_count; v++) {
                struct moved m = move_vertex(p, v, weights, skinned ? joints : NULL, &identity);
                worst = fmax(worst, fmax(fabs(m.position[0] - positions[v].x),
                                         fmax(fabs(m.position[1] - positions[v].y), fabs(m.position[2] - positions[v].z))));
                vec3 n = decode_normal(attributes[v].normal);
                double along = n.x * m.normal[0] + n.y * m.normal[1] + n.z * m.normal[2];
                worst_angle = fmax(worst_angle, acos(fmin(along, 1)));
            }
            free(positions);
            free(attributes);
            deform_index++;
        }
        free(joints);
    }
    assert_true(deform_index > 0 && deform_index == d->deform_vertex_counts.count);
    print_message("vertices off by %.2g of the scene's size, normals by %.2g degrees\n", worst / extent,
                  worst_angle * 57.29578);
    assert_true(worst < 2e-6 * extent);
    assert_true(worst_angle * 57.29578 < 0.05); /* twice 16-bit octahedral */
}

/* Every covered pixel's position lies in the box of the moved vertices, and each of its sides is nearly reached. */
static void check_picture(fnl_renderer *renderer, const fnl_image *position, double slack) {
    struct box box = box_empty(), moved = scene_bounds(renderer->scene);
    for (uint32_t i = 0; i < position->width * position->height; i++) {
        const float *p = (const float *)position->pixels + i * 4;
        if (p[3] > 0) box_add_point(&box, (vec3){p[0], p[1], p[2]});
    }
    assert_false(box_is_empty(&box));
    assert_true(box.low.x > moved.low.x - slack && box.low.y > moved.low.y - slack && box.high.x < moved.high.x + slack &&
                box.high.y < moved.high.y + slack);
}

static void check_animated(fnl_scene *scene, const double *times, uint32_t time_count) {
    fnl_scene_info info;
    fnl_renderer *renderer = test_renderer(scene);
    fnl_frame frame = test_frame(FNL_OUTPUT_POSITION);
    fnl_image last = {0};
    for (uint32_t i = 0; i < time_count; i++) {
        assert_int_equal(fnl_scene_set_time(scene, 0, times[i]), FNL_OK);
        assert_int_equal(fnl_scene_query_info(scene, &info), FNL_OK);
        double extent = vec3_distance(info.bounds_low, info.bounds_high);
        assert_int_equal(fnl_scene_query_framing_camera(scene, 1, &frame.camera), FNL_OK);
        test_render_frame(renderer, &frame);
        fnl_image position = test_read(renderer, FNL_OUTPUT_POSITION);
        check_vertices(renderer, extent);
        check_picture(renderer, &position, extent * 1e-3);
        if (last.pixels) {
            assert_true(test_difference(&last, &position) > 0); /* it moves */
            free_picture(&last);
        }
        last = position;
    }
    free_picture(&last);
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

static void test_fox(void **state) {
    UNUSED(state);
    check_animated(test_load("Fox.glb", true), (double[]){0, 0.31, 1.2, 2.5}, 4);
}

/* The first has fewer vertices than the second; each has records, influences and matrices of its own. */
static void test_two_in_a_scene(void **state) {
    UNUSED(state);
    fnl_scene *scene = test_load("Fox.glb", true);
    fnl_load_params params = fnl_load_params_default();
    const char *path = stand_in_sample("CesiumMan.glb");
    unsigned char *model = path ? NULL : stand_in_model("CesiumMan.glb", &params.size);
    params.data = model;
    assert_int_equal(fnl_scene_load_into(scene, (fnl_instance_id){0}, path ? path : "CesiumMan.glb", &params, NULL), FNL_OK);
    free(model);
    assert_true(scene->skins.count == 2 && scene->primitives.data[0].vertex_count < scene->primitives.data[scene->primitives.count - 1].vertex_count);
    check_animated(scene, (double[]){0, 0.5, 1.13}, 3);
}

static void test_cesium_man(void **state) {
    UNUSED(state);
    check_animated(test_load("CesiumMan.glb", true), (double[]){0, 0.5, 1.13}, 3);
}

/* ---- a morphed square: weights by a cubic spline that overshoots, far outside of 0..1 ---- */

static const vec3 moves[2][4] = {{{0, 0, 0}, {0.1f, 0, 0}, {0.1f, 0.2f, 0}, {0, 0.1f, 0}},
                                 {{0.05f, 0, 1}, {0, 0, 0.5f}, {0, 0, 0}, {0, 0, 0.25f}}};
static const vec3 turns[4] = {{0.5f, 0, 0}, {0, 0.5f, 0}, {0, 0, 0}, {-0.5f, 0, 0}};
static const struct scene_morph_target targets[2] = {{moves[0], NULL, NULL}, {moves[1], turns, NULL}};

static fnl_scene *morphed_scene(uint32_t *out_node) {
    static const vec3 positions[4] = {{-0.5f, -0.5f, 0}, {0.5f, -0.5f, 0}, {0.5f, 0.5f, 0}, {-0.5f, 0.5f, 0}};
    static const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
    static const float times[2] = {0, 2};
    /* in-tangent, value, out-tangent of both weights, twice */
    static const float values[12] = {0, 0, 0, 0, 6, -4, 6, 2, 0.5f, 1, 0, 0};
    fnl_scene *scene = test_scene();
    struct scene_material material = scene_material_default();
    material.double_sided = true;
    struct scene_primitive p = {.material = scene_add_material(scene, &material),
                                .vertex_count = 4,
                                .index_count = 6,
                                .indices = indices,
                                .positions = positions,
                                .morph_targets = targets,
                                .morph_target_count = 2};
    assert_int_equal(mesh_complete(&scene->arena, &p), FNL_OK);
    uint32_t mesh = scene_add_mesh(scene, "", &p, 1);
    scene->meshes.data[mesh].morph_target_count = 2;
    *out_node = test_place(scene, mesh, (vec3){0.1f, 0, 0}, (vec3){1, 1, 1});
    scene->nodes.data[*out_node].morph_weights = ARENA_ARRAY(&scene->arena, float, 2);
    static struct scene_channel channel;
    channel = (struct scene_channel){.node = *out_node,
                                     .path = SCENE_PATH_WEIGHTS,
                                     .interpolation = SCENE_INTERPOLATION_CUBIC,
                                     .key_count = 2,
                                     .width = 2,
                                     .times = times,
                                     .values = values};
    struct scene_animation animation = {.name = "", .channels = &channel, .channel_count = 1, .duration = 2};
    assert_true(array_push(&scene->host, &scene->animations, animation));
    return scene;
}

static void test_morph(void **state) {
    UNUSED(state);
    uint32_t node;
    fnl_scene *scene = morphed_scene(&node);
    fnl_renderer *renderer = test_renderer(scene);
    fnl_frame frame = test_frame(FNL_OUTPUT_POSITION);
    frame.width = frame.height = 128;
    frame.camera.vertical_extent = 8;
    for (double t = 0; t <= 2; t += 0.4) {
        assert_int_equal(fnl_scene_set_time(scene, 0, t), FNL_OK);
        /* glTF 2.0, appendix C: cubic Hermite, tangents scaled by the time between keys. */
        double s = t / 2, a = (2 * s * s * s - 3 * s * s + 1), b = (s * s * s - 2 * s * s + s) * 2,
               c = 3 * s * s - 2 * s * s * s, e = (s * s * s - s * s) * 2;
        double w[2] = {a * 0 + b * 6 + c * 0.5 + e * 6, a * 0 + b * -4 + c * 1 + e * 2};
        for (int k = 0; k < 2; k++) assert_true(fabs(scene->nodes.data[node].morph_weights[k] - w[k]) < 1e-5);
        test_render_frame(renderer, &frame);
        check_vertices(renderer, 2);
        /* The square's corners are where the weights put them, also where that is outside of any of the targets. */
        fnl_image position = test_read(renderer, FNL_OUTPUT_POSITION);
        double x = 0.1 + 0.5 + w[0] * 0.1, y = 0.5 + w[0] * 0.2;
        uint32_t px = clamp_pixel((x / 8 + 0.5) * 128 - 2.5), py = clamp_pixel((0.5 - y / 8) * 128 + 1.5);
        assert_true(test_pixel(&position, px, py)[3] > 0);
        free_picture(&position);
    }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* Morphing takes vertices beyond the targets' own box when weights leave 0..1; culling must know. */
static void test_morph_beyond_targets_is_not_culled(void **state) {
    UNUSED(state);
    uint32_t node;
    fnl_scene *scene = morphed_scene(&node);
    fnl_renderer *renderer = test_renderer(scene);
    fnl_frame frame = test_frame(FNL_OUTPUT_POSITION);
    frame.camera.position = (vec3){1.75f, 2.5f, 5}; /* sees x 1.25 .. 2.25 alone */
    frame.camera.target = (vec3){1.75f, 2.5f, 0};
    frame.camera.vertical_extent = 1;
    float *weights = scene->nodes.data[node].morph_weights;
    weights[0] = 12; /* the corner lies at 1.8, 2.9 */
    weights[1] = 0;
    scene->nodes.data[node].moved_version = scene->transform_version + 1;
    scene_update_transforms(scene);
    test_render_frame(renderer, &frame);
    fnl_image position = test_read(renderer, FNL_OUTPUT_POSITION);
    uint32_t covered = 0;
    for (uint32_t i = 0; i < 64 * 64; i++) covered += ((float *)position.pixels)[i * 4 + 3] > 0;
    assert_true(covered > 100);
    free_picture(&position);
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* ---- two joints that bend a strip; the mesh node's own transform must not count ---- */

static void test_hand_made_skin(void **state) {
    UNUSED(state);
    enum { SEGMENTS = 8, VERTICES = (SEGMENTS + 1) * 2 };
    fnl_scene *scene = test_scene();
    vec3 *positions = ARENA_ARRAY(&scene->arena, vec3, VERTICES), *normals = ARENA_ARRAY(&scene->arena, vec3, VERTICES);
    uint16_t *joints = ARENA_ARRAY(&scene->arena, uint16_t, VERTICES * 4);
    float *weights = ARENA_ARRAY(&scene->arena, float, VERTICES * 4);
    uint32_t *indices = ARENA_ARRAY(&scene->arena, uint32_t, SEGMENTS * 6);
    for (uint32_t v = 0; v < VERTICES; v++) {
        float along = (float)(v / 2) / SEGMENTS;
        positions[v] = (vec3){v % 2 ? 0.1f : -0.1f, along, 0};
        normals[v] = (vec3){0, 0, 1};
        joints[v * 4] = 0;
        joints[v * 4 + 1] = 1;
        weights[v * 4] = 1 - along;
        weights[v * 4 + 1] = along;
    }
    for (uint32_t s = 0; s < SEGMENTS; s++) {
        uint32_t v = s * 2, quad[6] = {v, v + 1, v + 3, v, v + 3, v + 2};
        memcpy(indices + s * 6, quad, sizeof quad);
    }
    struct scene_material material = scene_material_default();
    material.double_sided = true;
    struct scene_primitive p = {.material = scene_add_material(scene, &material),
                                .vertex_count = VERTICES,
                                .index_count = SEGMENTS * 6,
                                .indices = indices,
                                .positions = positions,
                                .normals = normals,
                                .joints = joints,
                                .weights = weights,
                                .joint_count = 4};
    assert_int_equal(mesh_complete(&scene->arena, &p), FNL_OK);
    uint32_t node =
        test_place(scene, scene_add_mesh(scene, "", &p, 1), (vec3){500, 600, 700}, (vec3){7, 7, 7}); /* ignored */
    mat4 root = mat4_translation((vec3){-0.2f, -0.4f, 0}),
         bend = mat4_from_trs((vec3){0, 0.5f, 0}, quat_axis_angle((vec3){0, 0, 1}, -0.9f), (vec3){1.2f, 1.2f, -1.2f});
    uint32_t *bones = ARENA_ARRAY(&scene->arena, uint32_t, 2);
    mat4 *inverse = ARENA_ARRAY(&scene->arena, mat4, 2);
    bones[0] = scene_add_node(scene, "", SCENE_NONE, &root, SCENE_NONE);
    bones[1] = scene_add_node(scene, "", bones[0], &bend, SCENE_NONE);
    inverse[0] = mat4_identity();
    inverse[1] = mat4_translation((vec3){0, -0.5f, 0});
    struct scene_skin skin = {.name = "", .joints = bones, .inverse_bind = inverse, .joint_count = 2};
    assert_true(array_push(&scene->host, &scene->skins, skin));
    scene->nodes.data[node].skin = 0;
    scene_structure_changed(scene);
    scene_update_transforms(scene);
    fnl_renderer *renderer = test_renderer(scene);
    fnl_frame frame = test_frame(FNL_OUTPUT_POSITION);
    test_render_frame(renderer, &frame);
    check_vertices(renderer, 2);
    /* The tip, by hand: joint 1 alone moves it: root * bend * (0, 0.5). */
    mat4 world = mat4_mul(root, bend);
    vec3 tip = mat4_point(&world, (vec3){0, 0.45f, 0});
    fnl_image position = test_read(renderer, FNL_OUTPUT_POSITION);
    assert_true(test_pixel(&position, clamp_pixel((tip.x + 1) * 32), clamp_pixel((1 - tip.y) * 32))[3] > 0);
    free_picture(&position);
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_morph),          cmocka_unit_test(test_morph_beyond_targets_is_not_culled),
        cmocka_unit_test(test_hand_made_skin), cmocka_unit_test(test_fox),
        cmocka_unit_test(test_cesium_man),
        cmocka_unit_test(test_two_in_a_scene),
    };
    return cmocka_run_group_tests_name("skin", tests, test_group_begin, test_group_end);
}
