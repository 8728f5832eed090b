/* SPDX-License-Identifier: MIT */
/** A light behind a triangle adds nothing, in every path and in the tracer, even if vertex normals or a normal map lean toward it. */
#include "tests/coarse_cases.h"
#include "tests/render_test.h"

enum { SIDE = 16 };

enum surface {
    SURFACE_VERTICES,
    SURFACE_MAP,
    SURFACE_MIRRORED,
    SURFACE_BACK,
    SURFACE_COAT,
    SURFACE_PAPER,
    SURFACE_COUNT,
    SURFACE_FLAT = SURFACE_COUNT,
    SURFACE_COAT_MAP, /* only the coat leans */
    SURFACE_DECAL     /* by its normal map */
};

enum place { PLACE_BEHIND, PLACE_FAR_BEHIND, PLACE_GRAZING, PLACE_FRONT, PLACE_COUNT }; /* behind the triangle; and behind its normals too */

static const fnl_light_kind kinds[] = {FNL_LIGHT_POINT, FNL_LIGHT_DIRECTIONAL, FNL_LIGHT_RECTANGLE};

static const vec3 places[PLACE_COUNT] = {{2, 0.2f, -0.5f}, {-0.5f, 0.2f, -1.5f}, {2, 0.2f, 0.4f}, {1.2f, 0.2f, 1.5f}};

static fnl_light_params lamp(fnl_light_kind kind, enum place place) {
    fnl_light_params light = fnl_light_params_default();
    light.kind = kind;
    light.position = places[place];
    light.direction = vec3_scale(light.position, -1);
    light.intensity = kind == FNL_LIGHT_DIRECTIONAL ? 2.0f : 8.0f;
    light.range = INFINITY;
    light.rectangle_size[0] = light.rectangle_size[1] = 0.2f;
    return light;
}

static fnl_image_id add_normal_map(fnl_scene *scene) {
    uint8_t texel[4] = {230, 128, 204, 255}; /* (0.8, 0, 0.6), nearly */
    fnl_image image = {1, 1, FNL_PIXEL_FORMAT_RGBA8, texel};
    fnl_image_id id;
    assert_int_equal(fnl_scene_add_image(scene, &image, false, &id), FNL_OK);
    return id;
}

/* A wall that fills the picture and faces the viewer; its shading normal is (0.8, 0, 0.6). */
static void add_wall(fnl_scene *scene, enum surface kind) {
    static const float positions[12] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0}, flat[12] = {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1},
                       leaning[12] = {0.8f, 0, 0.6f, 0.8f, 0, 0.6f, 0.8f, 0, 0.6f, 0.8f, 0, 0.6f}, uv[8] = {0, 1, 1, 1, 1, 0, 0, 0},
                       tangents[16] = {1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1};
    static const uint32_t indices[] = {0, 1, 2, 0, 2, 3};
    fnl_material_params material = fnl_material_params_default();
    fnl_mesh_params mesh = {.vertex_count = 4, .index_count = 6, .positions = positions, .normals = leaning, .uv = uv, .indices = indices};
    fnl_mat4 matrix = mat4_identity();
    fnl_mesh_id id;
    fnl_instance_id instance;
    material.metallic = 0;
    material.roughness = 0.6f;
    if (kind == SURFACE_COAT || kind == SURFACE_COAT_MAP) material.clearcoat = (fnl_clearcoat_params){.strength = 1, .roughness = 0.4f};
    if (kind == SURFACE_MAP) material.normal_image = add_normal_map(scene);
    if (kind == SURFACE_COAT_MAP) material.clearcoat.normal_image = add_normal_map(scene);
    if (kind == SURFACE_MAP || kind >= SURFACE_FLAT) {
        mesh.normals = flat;
        mesh.tangents = tangents;
    }
    if (kind == SURFACE_MIRRORED || kind == SURFACE_BACK) { /* normals turn with the instance, and to the viewer where the back is seen */
        matrix.m[0] = -1;
        if (kind == SURFACE_BACK) matrix.m[10] = -1;
        material.double_sided = kind == SURFACE_BACK;
    }
    if (kind == SURFACE_PAPER) material.diffuse_transmission = (fnl_diffuse_transmission_params){.strength = 0.7f, .color = {1, 0.5f, 0.2f}};
    assert_int_equal(fnl_scene_add_material(scene, &material, &mesh.material), FNL_OK);
    assert_int_equal(fnl_scene_add_mesh(scene, &mesh, &id), FNL_OK);
    assert_int_equal(fnl_scene_add_instance(scene, id, &matrix, &instance), FNL_OK);
    if (kind != SURFACE_DECAL) return;
    fnl_decal_params decal = fnl_decal_params_default();
    fnl_decal_id decal_id;
    decal.transform.m[0] = decal.transform.m[5] = 4;
    decal.normal_image = add_normal_map(scene);
    decal.channels = FNL_DECAL_NORMAL;
    assert_int_equal(fnl_scene_add_decal(scene, &decal, &decal_id), FNL_OK);
}

static struct stage open_wall(enum surface kind, fnl_light_id *light) {
    fnl_scene *scene = coarse_scene();
    add_wall(scene, kind);
    fnl_light_params first = lamp(FNL_LIGHT_POINT, PLACE_FRONT);
    assert_int_equal(fnl_scene_add_light(scene, &first, light), FNL_OK);
    struct stage s = stage_open_scene(scene);
    s.frame.width = s.frame.height = SIDE;
    s.frame.outputs = FNL_OUTPUT_RADIANCE;
    s.frame.studio = false;
    s.frame.shadows = FNL_SHADOWS_OFF;
    s.frame.camera = fnl_camera_default();
    s.frame.camera.position = vec3_make(0, 0, 4);
    s.frame.camera.target = vec3_make(0, 0, 0);
    s.frame.camera.vertical_fov = 0.3f;
    return s;
}

static double mean_of(const fnl_image *image) {
    const float *pixels = image->pixels;
    double sum = 0;
    for (size_t i = 0; i < SIDE * SIDE; i++) sum += (double)pixels[4 * i];
    return sum / (SIDE * SIDE);
}

static double drawn(struct stage *s) {
    struct shot shot = stage_shoot(s, &s->frame);
    const double mean = mean_of(&shot.radiance);
    shot_free(&shot);
    return mean;
}

static double traced(const struct stage *s) {
    fnl_trace_params p = trace_plain();
    fnl_trace trace;
    p.width = p.height = SIDE, p.camera = s->frame.camera;
    p.shadows = false;
    p.samples = 16;
    assert_int_equal(fnl_scene_trace(s->scene, &p, &trace), FNL_OK);
    const double mean = mean_of(&trace.radiance);
    fnl_trace_free(&s->scene->host, &trace);
    return mean;
}

/* The same surface in other forms gives the same light, in frames and traced; paper lets through what its other side gets. */
static void test_surfaces_of_all_kinds(void **state) {
    UNUSED(state);
    double first[COUNT_OF(kinds)][PLACE_COUNT];
    for (int surface = 0; surface < SURFACE_COUNT; surface++) {
        fnl_light_id light;
        struct stage s = open_wall((enum surface)surface, &light);
        s.frame.shading = FNL_SHADING_FORWARD;
        for (uint32_t kind = 0; kind < COUNT_OF(kinds); kind++)
            for (int place = 0; place < PLACE_COUNT; place++) {
                fnl_light_params params = lamp(kinds[kind], (enum place)place);
                if (surface == SURFACE_MIRRORED) params.position.x *= -1, params.direction.x *= -1;
                assert_int_equal(fnl_scene_set_light(s.scene, light, &params), FNL_OK);
                const double frame = drawn(&s), truth = traced(&s);
                print_message("surface %d, light %u, place %d: %.6f, traced %.6f\n", surface, kind, place, frame, truth);
                if (surface == 0) first[kind][place] = frame;
                if (place == PLACE_BEHIND || (place == PLACE_FAR_BEHIND && surface != SURFACE_PAPER)) assert_true(frame == 0 && truth == 0);
                else assert_true(frame > 0.01 && fabs(frame / truth - 1) < 0.02);
                if (surface == SURFACE_MAP || surface == SURFACE_MIRRORED || surface == SURFACE_BACK)
                    assert_true(fabs(frame - first[kind][place]) <= (surface == SURFACE_MAP ? 0.01 : 1e-5) * first[kind][place]);
            }
        stage_close(&s);
    }
}

static void expect_places(struct stage *s, fnl_light_id light, fnl_light_kind kind, double allowed, const char *what, const double truth[PLACE_COUNT]) {
    for (int place = 0; place < PLACE_COUNT; place++) {
        fnl_light_params params = lamp(kind, (enum place)place);
        assert_int_equal(fnl_scene_set_light(s->scene, light, &params), FNL_OK);
        const double frame = drawn(s);
        if (!(place <= PLACE_FAR_BEHIND ? frame == 0 : fabs(frame / truth[place] - 1) < allowed)) fail_msg("%s, place %d: %g, not %g", what, place, frame, truth[place]);
    }
}

static void test_paths_and_layouts(void **state) {
    UNUSED(state);
    fnl_light_id light;
    struct stage s = open_wall(SURFACE_VERTICES, &light);
    double truth[PLACE_COUNT];
    for (int place = 0; place < PLACE_COUNT; place++) {
        fnl_light_params params = lamp(FNL_LIGHT_POINT, (enum place)place);
        assert_int_equal(fnl_scene_set_light(s.scene, light, &params), FNL_OK);
        truth[place] = traced(&s);
    }
    for (uint32_t shading = 0; shading < FNL_SHADING_AUTO; shading++) {
        s.frame.shading = (fnl_shading)shading;
        /* A block of coarse shading is lit at one of its pixels. */
        expect_places(&s, light, FNL_LIGHT_POINT, shading == FNL_SHADING_COARSE ? 0.06 : 0.02, fnl_value_name(FNL_ENUM_SHADING, shading), truth);
    }
    static const fnl_shading several[] = {FNL_SHADING_FORWARD, FNL_SHADING_DEFERRED, FNL_SHADING_LIGHT_PREPASS, FNL_SHADING_TEXTURING, FNL_SHADING_VISIBILITY};
    s.frame.msaa = 4;
    for (uint32_t i = 0; i < COUNT_OF(several); i++) {
        s.frame.shading = several[i];
        expect_places(&s, light, FNL_LIGHT_POINT, 0.02, fnl_value_name(FNL_ENUM_SHADING, several[i]), truth);
    }
    s.frame.msaa = 1;
    s.frame.shading = FNL_SHADING_VISIBILITY;
    s.frame.visibility.barycentrics = true;
    expect_places(&s, light, FNL_LIGHT_POINT, 0.02, "stored barycentrics", truth);
    s.frame.shading = FNL_SHADING_DEFERRED;
    for (uint32_t layout = 0; layout < FNL_GBUFFER_COUNT; layout++) {
        s.frame.gbuffer.layout = (fnl_gbuffer)layout;
        expect_places(&s, light, FNL_LIGHT_POINT, 0.04, fnl_value_name(FNL_ENUM_GBUFFER, layout), truth);
    }
    stage_close(&s);
}

/* A coat or a decal alone makes deferred paths keep the geometric normal. */
static void test_flat_walls_with_bumps(void **state) {
    UNUSED(state);
    static const fnl_shading paths[] = {FNL_SHADING_FORWARD, FNL_SHADING_DEFERRED, FNL_SHADING_TEXTURING};
    for (int surface = SURFACE_COAT_MAP; surface <= SURFACE_DECAL; surface++) {
        fnl_light_id light;
        struct stage s = open_wall((enum surface)surface, &light);
        double first[PLACE_COUNT] = {0};
        for (uint32_t i = 0; i < COUNT_OF(paths); i++)
            for (int place = 0; place < PLACE_COUNT; place++) {
                const fnl_light_params params = lamp(FNL_LIGHT_POINT, (enum place)place);
                assert_int_equal(fnl_scene_set_light(s.scene, light, &params), FNL_OK);
                s.frame.shading = paths[i];
                const double frame = drawn(&s);
                print_message("surface %d, path %u, place %d: %.6f\n", surface, i, place, frame);
                if (i == 0) first[place] = frame;
                assert_true(place <= PLACE_FAR_BEHIND ? frame == 0 : fabs(frame / first[place] - 1) < 0.02);
            }
        stage_close(&s);
    }
}

/* Flat meshes take no target for normals that they have already. Edits that let normals lean, by the mesh or by the material, are followed. */
static void test_edits_are_followed(void **state) {
    UNUSED(state);
    for (int by_map = 0; by_map < 2; by_map++) {
        fnl_light_id light;
        struct stage flat = open_wall(SURFACE_FLAT, &light), fresh = open_wall(by_map ? SURFACE_MAP : SURFACE_VERTICES, &light);
        const fnl_light_params grazing = lamp(FNL_LIGHT_POINT, PLACE_GRAZING);
        assert_int_equal(fnl_scene_set_light(flat.scene, light, &grazing), FNL_OK);
        assert_int_equal(fnl_scene_set_light(fresh.scene, light, &grazing), FNL_OK);
        flat.frame.shading = fresh.frame.shading = FNL_SHADING_DEFERRED;
        const double before = drawn(&flat), wanted = drawn(&fresh);
        fnl_entity_info mesh, material;
        assert_int_equal(fnl_scene_query_entity(flat.scene, FNL_ENTITY_MESH, 0, &mesh), FNL_OK);
        assert_int_equal(fnl_scene_query_entity(flat.scene, FNL_ENTITY_MATERIAL, 0, &material), FNL_OK);
        if (by_map) {
            fnl_material_params params;
            assert_int_equal(fnl_scene_query_material(flat.scene, 0, &params), FNL_OK);
            params.normal_image = add_normal_map(flat.scene);
            assert_int_equal(fnl_scene_set_material(flat.scene, material.id.material, &params), FNL_OK);
        } else {
            fnl_mesh_info info;
            assert_int_equal(fnl_scene_query_mesh(flat.scene, 0, 0, &info), FNL_OK);
            static const float leaning[12] = {0.8f, 0, 0.6f, 0.8f, 0, 0.6f, 0.8f, 0, 0.6f, 0.8f, 0, 0.6f};
            info.params.normals = leaning;
            assert_int_equal(fnl_scene_set_mesh(flat.scene, mesh.id.mesh, 0, &info.params), FNL_OK);
        }
        const double after = drawn(&flat);
        print_message("%s: %.6f, then %.6f, fresh %.6f\n", by_map ? "map" : "mesh", before, after, wanted);
        assert_true(fabs(after - wanted) < 1e-4 * wanted && fabs(before - wanted) > 0.1 * wanted);
        stage_close(&flat);
        stage_close(&fresh);
    }
}

/* Without alpha, of a picture whose brightest value is about 1. */
static double psnr_of(const fnl_image *a, const fnl_image *b) {
    const float *p = a->pixels, *q = b->pixels;
    const size_t count = (size_t)a->width * a->height * 4;
    double sum = 0;
    for (size_t i = 0; i < count; i++)
        if (i % 4 != 3) sum += pow((double)p[i] - (double)q[i], 2);
    return -10 * log10(sum / (double)(count / 4 * 3));
}

/* A ball of few triangles: frames match the tracer, and deferred matches forward. */
static void test_coarse_balls_fade(void **state) {
    UNUSED(state);
    fnl_scene *scene = coarse_scene();
    coarse_add_sphere(scene, coarse_plain(scene), 1);
    fnl_light_params sun = fnl_light_params_default();
    fnl_light_id id;
    sun.kind = FNL_LIGHT_DIRECTIONAL;
    sun.direction = vec3_make(-1, 0.1f, -0.2f);
    sun.intensity = 3;
    assert_int_equal(fnl_scene_add_light(scene, &sun, &id), FNL_OK);
    struct stage s = stage_open_scene(scene);
    s.frame = coarse_front_frame(&s);
    s.frame.shadows = FNL_SHADOWS_OFF;
    s.frame.outputs = FNL_OUTPUT_RADIANCE;
    s.frame.width = s.frame.height = 96;
    s.frame.shading = FNL_SHADING_FORWARD;
    struct shot forward = stage_shoot(&s, &s.frame);
    fnl_trace_params p = trace_plain();
    fnl_trace trace;
    p.width = p.height = 96, p.camera = s.frame.camera, p.shadows = false;
    assert_int_equal(fnl_scene_trace(s.scene, &p, &trace), FNL_OK);
    s.frame.shading = FNL_SHADING_DEFERRED;
    struct shot deferred = stage_shoot(&s, &s.frame);
    const double to_trace = psnr_of(&forward.radiance, &trace.radiance), to_deferred = psnr_of(&forward.radiance, &deferred.radiance);
    print_message("%.1f dB to the tracer, %.1f to deferred shading\n", to_trace, to_deferred);
    assert_true(to_trace > 50 && to_deferred > 50);
    fnl_trace_free(&s.scene->host, &trace);
    shot_free(&forward);
    shot_free(&deferred);
    stage_close(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_surfaces_of_all_kinds, harness_check),
        cmocka_unit_test_teardown(test_paths_and_layouts, harness_check),
        cmocka_unit_test_teardown(test_flat_walls_with_bumps, harness_check),
        cmocka_unit_test_teardown(test_edits_are_followed, harness_check),
        cmocka_unit_test_teardown(test_coarse_balls_fade, harness_check),
    };
    return cmocka_run_group_tests_name("facing", tests, test_group_begin, test_group_end);
}
