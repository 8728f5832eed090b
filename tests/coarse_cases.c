/* SPDX-License-Identifier: MIT */
#include "tests/coarse_cases.h"

/* ---- scenes ---- */

fnl_scene *coarse_scene(void) {
    fnl_scene *scene;
    assert_int_equal(fnl_scene_create(gpu_host(harness_device()), &scene), FNL_OK);
    return scene;
}

fnl_material_id coarse_material(fnl_scene *scene, float roughness, fnl_image_id image) {
    fnl_material_params params = fnl_material_params_default();
    fnl_material_id id;
    params.base_color[0] = 0.8f;
    params.base_color[1] = 0.6f;
    params.base_color[2] = 0.5f;
    params.metallic = 0;
    params.roughness = roughness;
    params.double_sided = true;
    params.base_color_image = image;
    assert_int_equal(fnl_scene_add_material(scene, &params, &id), FNL_OK);
    return id;
}

fnl_material_id coarse_plain(fnl_scene *scene) { return coarse_material(scene, 0.7f, (fnl_image_id){0}); }

static void add_mesh(fnl_scene *scene, const fnl_mesh_params *mesh) {
    fnl_mesh_id mesh_id;
    fnl_instance_id instance;
    fnl_mat4 matrix = mat4_identity();
    assert_int_equal(fnl_scene_add_mesh(scene, mesh, &mesh_id), FNL_OK);
    assert_int_equal(fnl_scene_add_instance(scene, mesh_id, &matrix, &instance), FNL_OK);
}

void coarse_add_plane(fnl_scene *scene, fnl_material_id material, float x0, float x1, float at, float a, float b) {
    static const uint32_t indices[] = {0, 1, 2, 0, 2, 3};
    float positions[12], uv[8];
    for (int i = 0; i < 4; i++) {
        float x = i == 1 || i == 2 ? x1 : x0, y = i < 2 ? -3 : 3;
        memcpy(&positions[3 * i], (float[3]){x, y, at + a * x + b * y}, 12);
        memcpy(&uv[2 * i], (float[2]){x, y}, 8);
    }
    add_mesh(scene, &(fnl_mesh_params){.vertex_count = 4,
                                       .index_count = 6,
                                       .positions = positions,
                                       .uv = uv,
                                       .indices = indices,
                                       .material = material});
}

enum { RINGS = 12 };
void coarse_add_sphere(fnl_scene *scene, fnl_material_id material, float radius) {
    float positions[3 * (RINGS + 1) * (2 * RINGS + 1)], normals[COUNT_OF(positions)];
    uint32_t indices[6 * RINGS * 2 * RINGS], count = 0;
    for (int i = 0; i <= RINGS; i++)
        for (int k = 0; k <= 2 * RINGS; k++) {
            float theta = PI * (float)i / RINGS, phi = PI * (float)k / RINGS;
            float n[3] = {sinf(theta) * cosf(phi), cosf(theta), sinf(theta) * sinf(phi)};
            for (int c = 0; c < 3; c++) {
                normals[3 * (i * (2 * RINGS + 1) + k) + c] = n[c];
                positions[3 * (i * (2 * RINGS + 1) + k) + c] = radius * n[c];
            }
        }
    for (uint32_t i = 0; i < RINGS; i++)
        for (uint32_t k = 0; k < 2 * RINGS; k++) {
            uint32_t a = i * (2 * RINGS + 1) + k, b = a + 2 * RINGS + 1;
            const uint32_t quad[6] = {a, a + 1, b, b, a + 1, b + 1};
            memcpy(&indices[count], quad, sizeof quad);
            count += 6;
        }
    add_mesh(scene, &(fnl_mesh_params){.vertex_count = (RINGS + 1) * (2 * RINGS + 1),
                                       .index_count = count,
                                       .positions = positions,
                                       .normals = normals,
                                       .indices = indices,
                                       .material = material});
}

void coarse_add_light(fnl_scene *scene, fnl_light_kind kind, vec3 position, float intensity) {
    fnl_light_params light = fnl_light_params_default();
    fnl_light_id id;
    light.kind = kind;
    light.position = position;
    light.intensity = intensity;
    light.range = 8;
    light.outer_cone_angle = 0.3f;
    light.inner_cone_angle = 0.299f;
    assert_int_equal(fnl_scene_add_light(scene, &light, &id), FNL_OK);
}

/* ---- frames ---- */

/* 64x64 from z = 5 on the square -1 .. 1: a pixel is 1/32 wide. */
static fnl_frame coarse_frame(const struct stage *stage) {
    fnl_frame frame = stage->frame;
    frame.shading = FNL_SHADING_COARSE;
    frame.width = frame.height = 64;
    frame.exposure = FNL_EXPOSURE_NONE;
    return frame;
}

fnl_frame coarse_front_frame(const struct stage *stage) {
    fnl_frame frame = coarse_frame(stage);
    frame.camera = fnl_camera_default();
    frame.camera.position = vec3_make(0, 0, 5);
    frame.camera.target = vec3_make(0, 0, 0);
    frame.camera.orthographic = true;
    frame.camera.vertical_extent = 2;
    frame.camera.far_distance = 20;
    return frame;
}

fnl_frame coarse_hall_frame(const struct stage *stage, uint32_t width, uint32_t height) {
    fnl_frame frame = stage->frame;
    frame.shading = FNL_SHADING_COARSE;
    frame.width = width;
    frame.height = height;
    return frame;
}

fnl_frame_stats coarse_stats(struct stage *stage, const fnl_frame *frame) {
    struct shot shot = stage_shoot(stage, frame);
    fnl_frame_stats stats = shot.stats;
    shot_free(&shot);
    return stats;
}

struct shot coarse_deferred(struct stage *stage, fnl_frame frame) {
    frame.shading = FNL_SHADING_DEFERRED;
    return stage_shoot(stage, &frame);
}

double coarse_psnr(const fnl_image *a, const fnl_image *b) {
    fnl_image_difference d;
    assert_int_equal(fnl_image_compare(gpu_host(harness_device()), a, b, &d), FNL_OK);
    return d.psnr;
}

double coarse_worst_ratio(const fnl_image *a, const fnl_image *b, uint32_t step) {
    const float *p = a->pixels, *q = b->pixels;
    double worst = 0;
    for (uint32_t y = 0; y < a->height; y += step)
        for (uint32_t x = 0; x < a->width; x += step)
            for (uint32_t c = 0; c < 3; c++) {
                size_t i = 4 * ((size_t)y * a->width + x) + c;
                worst = fmax(worst, fabs((double)p[i] - q[i]) / (1e-3 + fabs((double)q[i])));
            }
    return worst;
}

uint32_t coarse_kind_at(const fnl_image *view, uint32_t x, uint32_t y) {
    const uint8_t *p = (const uint8_t *)view->pixels + 4 * ((size_t)y * view->width + x);
    return p[1] > p[0] + 50 ? 1 : p[0] > p[1] + 50 ? 2 : p[2] > p[0] + 50 ? 3 : p[0] > p[2] + 50 ? 4 : 0;
}

struct shot coarse_view(struct stage *stage, fnl_frame frame, fnl_debug_view view) {
    frame.debug = view;
    frame.outputs = FNL_OUTPUT_COLOR;
    return stage_shoot(stage, &frame);
}

void coarse_check_counts(struct stage *stage, const fnl_frame *frame) {
    struct shot view = coarse_view(stage, *frame, FNL_DEBUG_COARSE_REASON);
    uint32_t size = frame->coarse.size, blocks[5] = {0}, pixels = 0, shaded = 0;
    for (uint32_t y = 0; y < frame->height; y += size)
        for (uint32_t x = 0; x < frame->width; x += size) {
            uint32_t kind = 0, inside = 0;
            for (uint32_t v = y; v < MIN(y + size, frame->height); v++)
                for (uint32_t u = x; u < MIN(x + size, frame->width); u++) {
                    uint32_t k = coarse_kind_at(&view.color, u, v);
                    if (k) assert_true(kind == 0 || kind == k);
                    kind = MAX(kind, k);
                    inside += k != 0;
                }
            blocks[kind]++;
            pixels += inside;
            shaded += kind == 1 ? 1 : inside;
        }
    const fnl_frame_stats *s = &view.stats;
    assert_int_equal(counter(s, "coarse.pixels"), pixels);
    assert_int_equal(counter(s, "coarse.shared"), blocks[1]);
    assert_int_equal(counter(s, "coarse.by-depth"), blocks[2]);
    assert_int_equal(counter(s, "coarse.by-normal"), blocks[3]);
    assert_int_equal(counter(s, "coarse.by-material"), blocks[4]);
    assert_int_equal(counter(s, "coarse.blocks"), blocks[1] + blocks[2] + blocks[3] + blocks[4]);
    assert_int_equal(counter(s, "coarse.shaded"), shaded);
    shot_free(&view);
}
