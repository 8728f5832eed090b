/* SPDX-License-Identifier: MIT */
/** Frames of materials with layers: energy, every shading order, against rays, and what the others pay for them. */
#include "fanal/trace.h"
#include "render/shading.h"
#include "tests/coarse_cases.h"
#include "tests/gltf_test_file.h"
#include "tests/render_harness.h"
#include "tests/vulkan_spy.h"

/* ---- balls ---- */

enum { RINGS = 24, SEGMENTS = 48, VERTICES = (RINGS + 1) * (SEGMENTS + 1) };

/* Of radius 0.5; tangents run along its circles of latitude. */
static void add_ball(fnl_scene *scene, fnl_material_id material, float x, float y) {
    static float positions[VERTICES * 3], normals[VERTICES * 3], tangents[VERTICES * 4], uv[VERTICES * 2];
    static uint32_t indices[RINGS * SEGMENTS * 6];
    uint32_t count = 0;
    for (uint32_t i = 0; i < VERTICES; i++) {
        const float u = (float)(i % (SEGMENTS + 1)) / SEGMENTS, v = (float)(i / (SEGMENTS + 1)) / RINGS, phi = 2 * PI * u, theta = PI * v;
        const vec3 n = {sinf(theta) * cosf(phi), cosf(theta), -sinf(theta) * sinf(phi)};
        const float tangent[4] = {-sinf(phi), 0, -cosf(phi), 1};
        memcpy(&normals[i * 3], &n, sizeof n);
        for (int c = 0; c < 3; c++) positions[i * 3 + (uint32_t)c] = 0.5f * (&n.x)[c];
        memcpy(&tangents[i * 4], tangent, sizeof tangent);
        uv[i * 2] = u, uv[i * 2 + 1] = v;
    }
    for (uint32_t i = 0; i < RINGS * SEGMENTS; i++) {
        const uint32_t a = i / SEGMENTS * (SEGMENTS + 1) + i % SEGMENTS, b = a + SEGMENTS + 1, quad[6] = {a, b, a + 1, a + 1, b, b + 1};
        memcpy(&indices[count], quad, sizeof quad);
        count += 6;
    }
    const fnl_mesh_params mesh = {VERTICES, count, positions, normals, tangents, uv, NULL, indices, material};
    const fnl_mat4 place = mat4_translation((vec3){x, y, 0});
    fnl_mesh_id id;
    fnl_instance_id instance;
    assert_int_equal(fnl_scene_add_mesh(scene, &mesh, &id), FNL_OK);
    assert_int_equal(fnl_scene_add_instance(scene, id, &place, &instance), FNL_OK);
}

enum ball { CORE, COAT, CLOTH, SOAP, STEEL, BRUSHED, ALL, BALLS };

static fnl_material_params material_of(enum ball ball) {
    fnl_material_params p = fnl_material_params_default();
    const float colors[BALLS][3] = {{0.7f, 0.5f, 0.3f}, {0.6f, 0.05f, 0.05f}, {0.1f, 0.2f, 0.5f}, {0.1f, 0.1f, 0.1f}, {0.8f, 0.8f, 0.8f}, {0.9f, 0.8f, 0.6f}, {0.5f, 0.4f, 0.3f}};
    memcpy(p.base_color, colors[ball], sizeof colors[ball]);
    p.metallic = ball == STEEL || ball == BRUSHED ? 1 : ball == ALL ? 0.5f : 0;
    p.roughness = ball == BRUSHED || ball == ALL ? 0.4f : 0.6f;
    if (ball == COAT || ball == ALL) p.clearcoat = (fnl_clearcoat_params){.strength = 0.9f, .roughness = 0.25f};
    if (ball == CLOTH || ball == ALL) p.sheen = (fnl_sheen_params){.color = {0.9f, 0.6f, 0.8f}, .roughness = 0.4f};
    if (ball == SOAP || ball == STEEL || ball == ALL) p.iridescence = (fnl_iridescence_params){.strength = 1, .ior = 1.4f, .thickness_maximum = 450};
    if (ball == BRUSHED || ball == ALL) p.anisotropy = (fnl_anisotropy_params){.strength = 0.8f, .rotation = 0.6f};
    return p;
}

static fnl_scene *balls(bool layered) {
    fnl_scene *scene = coarse_scene();
    for (int ball = 0; ball < BALLS; ball++) {
        fnl_material_params p = material_of((enum ball)ball);
        const fnl_material_params plain = {.clearcoat = {0}};
        fnl_material_id id;
        if (!layered) p.clearcoat = plain.clearcoat, p.sheen = plain.sheen, p.iridescence = plain.iridescence, p.anisotropy = plain.anisotropy;
        assert_int_equal(fnl_scene_add_material(scene, &p, &id), FNL_OK);
        add_ball(scene, id, -1.8f + 1.2f * (float)(ball % 4), ball < 4 ? 0.65f : -0.65f);
    }
    return scene;
}

static void add_lights(fnl_scene *scene) {
    for (int i = 0; i < 8; i++)
        coarse_add_light(scene, i % 2 ? FNL_LIGHT_POINT : FNL_LIGHT_SPOT, (vec3){-2.4f + 0.7f * (float)i, i % 3 ? 1.6f : -1.5f, 1.2f + 0.2f * (float)(i % 4)}, 6);
    assert_int_equal(fnl_scene_set_ambient(scene, (fnl_vec3){0.5f, 0.6f, 0.8f}, (fnl_vec3){0.3f, 0.2f, 0.1f}), FNL_OK);
}

static struct stage open_balls(fnl_scene *scene) {
    struct stage s = stage_open_scene(scene);
    s.frame.width = 96, s.frame.height = 54;
    s.frame.outputs = FNL_OUTPUT_RADIANCE;
    s.frame.camera = fnl_camera_default();
    s.frame.camera.position = (fnl_vec3){0, 0, 4};
    s.frame.camera.target = (fnl_vec3){0, 0, 0};
    s.frame.camera.vertical_fov = 0.65f;
    return s;
}

/* Root of the squared differences over that of the squares; of the columns and rows of one ball. Edges may be a pixel off: what is black in
 * one of them is left out. */
static double difference(const fnl_image *a, const fnl_image *b, int ball) {
    const float *x = a->pixels, *y = b->pixels;
    double error = 0, sum = 0;
    for (uint32_t i = 0; i < a->width * a->height; i++) {
        const uint32_t column = i % a->width, row = i / a->width;
        if ((int)(column * 4 / a->width) != ball % 4 || (int)(row * 2 / a->height) != ball / 4) continue;
        if (x[4 * i] == 0 || y[4 * i] == 0) continue;
        for (uint32_t c = 0; c < 3; c++) {
            error += pow((double)x[4 * i + c] - (double)y[4 * i + c], 2);
            sum += pow((double)y[4 * i + c], 2);
        }
    }
    return sqrt(error / sum);
}

/* ---- the same as in double precision ---- */

static void compare_with_rays(fnl_energy energy) {
    static const char *const names[BALLS] = {"core", "clearcoat", "sheen", "film on plastic", "film on metal", "anisotropy", "all"};
    fnl_scene *scene = balls(true);
    add_lights(scene);
    struct stage s = open_balls(scene);
    s.frame.shading = FNL_SHADING_FORWARD;
    s.frame.energy = energy;
    struct shot shot = stage_shoot(&s, &s.frame);
    fnl_trace_params p = trace_plain();
    p.energy = energy;
    p.width = s.frame.width, p.height = s.frame.height, p.camera = s.frame.camera;
    p.shadows = false;
    fnl_trace trace;
    assert_int_equal(fnl_scene_trace(s.scene, &p, &trace), FNL_OK);
    for (int ball = 0; ball < BALLS; ball++) {
        const double off = difference(&shot.radiance, &trace.radiance, ball);
        print_message("%s: %.4f off\n", names[ball], off);
        assert_true(off < 0.01);
    }
    fnl_trace_free(&s.scene->host, &trace);
    shot_free(&shot);
    stage_close(&s);
}

static void test_layers_are_those_of_rays_MA_1(void **state) {
    UNUSED(state);
    for (int energy = 0; energy < FNL_ENERGY_COUNT; energy++) compare_with_rays((fnl_energy)energy);
}

/* ---- energy ---- */

/* White in white light: nothing gets lost between the layers, and nothing comes from nowhere. */
static void test_layers_keep_a_white_furnace_white_MA_2(void **state) {
    UNUSED(state);
    for (int i = 0; i < 8; i++) {
        fnl_scene *scene = coarse_scene();
        fnl_material_params m = fnl_material_params_default();
        const float roughness = 0.2f + 0.4f * (float)(i % 3);
        fnl_material_id id;
        float texel[8] = {1, 1, 1, 1, 1, 1, 1, 1};
        fnl_image image = {2, 1, FNL_PIXEL_FORMAT_RGBA32F, texel};
        fnl_environment_params even = fnl_environment_params_default();
        m.metallic = 0;
        m.roughness = i % 2 ? 0.3f : 0.8f;
        m.clearcoat = (fnl_clearcoat_params){.strength = 1, .roughness = roughness};
        if (i >= 3) m.sheen = (fnl_sheen_params){.color = {1, 1, 1}, .roughness = roughness};
        if (i >= 6) m.anisotropy = (fnl_anisotropy_params){.strength = 0.8f, .rotation = 0.6f};
        if (i >= 7) m.iridescence = (fnl_iridescence_params){.strength = 1, .ior = 1.4f, .thickness_maximum = 450};
        even.image = &image;
        assert_int_equal(fnl_scene_add_material(scene, &m, &id), FNL_OK);
        add_ball(scene, id, 0, 0);
        assert_int_equal(fnl_scene_set_environment(scene, &even), FNL_OK);
        struct stage s = open_balls(scene);
        s.frame.width = s.frame.height = 40;
        s.frame.energy = FNL_ENERGY_CONSERVING;
        s.frame.camera.position.z = 2;
        struct shot shot = stage_shoot(&s, &s.frame);
        const float *pixels = shot.radiance.pixels;
        double least = INFINITY, most = 0;
        for (uint32_t k = 0; k < 40 * 40 * 4; k++) {
            if (k % 4 == 3) continue;
            least = fmin(least, (double)pixels[k]);
            most = fmax(most, (double)pixels[k]);
        }
        print_message("coat of roughness %.1f%s%s%s: %.4f .. %.4f\n", (double)roughness, i >= 3 ? ", fibres" : "", i >= 6 ? ", anisotropy" : "", i >= 7 ? ", film" : "", least, most);
        assert_true(most < 1.02);
        /* Below a coloured film gets what its strongest colour leaves, as the specification says: a film dims. */
        assert_true(least > (i >= 7 ? 0.7 : 0.98));
        shot_free(&shot);
        stage_close(&s);
    }
}

/* ---- orders ---- */

/* What an order cannot hold is drawn over its picture: all show the same. */
static void test_every_order_shades_layers_MA_3(void **state) {
    UNUSED(state);
    fnl_scene *scene = balls(true);
    add_lights(scene);
    struct stage s = open_balls(scene);
    for (uint32_t msaa = 1; msaa <= 4; msaa += 3) {
        s.frame.msaa = msaa;
        s.frame.shading = FNL_SHADING_FORWARD;
        struct shot want = stage_shoot(&s, &s.frame);
        for (int shading = 0; shading < FNL_SHADING_AUTO; shading++) {
            s.frame.shading = (fnl_shading)shading;
            const bool some = shading == FNL_SHADING_DEFERRED || shading == FNL_SHADING_LIGHT_PREPASS; /* visibility resolves edges otherwise, layers or not */
            if (msaa > 1 && !some) continue;
            struct shot shot = stage_shoot(&s, &s.frame);
            double worst = 0;
            for (int ball = COAT; ball < BALLS; ball++) worst = fmax(worst, difference(&shot.radiance, &want.radiance, ball));
            print_message("%s, %u samples: %.5f off\n", fnl_value_name(FNL_ENUM_SHADING, s.frame.shading), msaa, worst);
            /* texturing rounds tangents; with several samples deferred shading lights a surface at the middle of them, forward shading the centroid:
               the core's matt highlight moves a little, those of coats and of brushed metal more. */
            assert_true(worst < (shading == FNL_SHADING_TEXTURING ? 0.003 : fmax(0.001, 5 * difference(&shot.radiance, &want.radiance, CORE))));
            shot_free(&shot);
        }
        shot_free(&want);
    }
    stage_close(&s);
}

/* Beside them a core material keeps its bits, whatever is asked of the pipelines. */
static void test_core_materials_keep_their_bits_MA_4(void **state) {
    UNUSED(state);
    static const fnl_shading shadings[] = {FNL_SHADING_FORWARD, FNL_SHADING_DEFERRED, FNL_SHADING_VISIBILITY};
    fnl_scene *scenes[2] = {balls(false), balls(true)};
    struct shot shots[COUNT_OF(shadings)];
    for (int layered = 0; layered < 2; layered++) {
        add_lights(scenes[layered]);
        struct stage s = open_balls(scenes[layered]);
        for (uint32_t i = 0; i < COUNT_OF(shadings); i++) {
            s.frame.shading = shadings[i];
            struct shot shot = stage_shoot(&s, &s.frame);
            if (layered) {
                assert_true(difference(&shots[i].radiance, &shot.radiance, CORE) == 0);
                for (int ball = COAT; ball < BALLS; ball++) assert_true(difference(&shots[i].radiance, &shot.radiance, ball) > 0.02);
                shot_free(&shots[i]);
                shot_free(&shot);
            } else {
                shots[i] = shot;
            }
        }
        stage_close(&s);
    }
}

static bool has_pass(const struct stage *s, const char *name) {
    fnl_frame_stats stats;
    assert_int_equal(fnl_renderer_query_stats(s->renderer, &stats), FNL_OK);
    for (uint32_t i = 0; i < stats.pass_count; i++)
        if (strstr(stats.passes[i].name, name)) return true;
    return false;
}

/* Without layers no pass is added; with them one forward pass where the order cannot hold them, and the table is made once. */
static void test_layers_cost_only_where_they_are_MA_5(void **state) {
    UNUSED(state);
    for (int layered = 0; layered < 2; layered++) {
        fnl_scene *scene = balls(layered);
        add_lights(scene);
        struct stage s = open_balls(scene);
        s.frame.shading = FNL_SHADING_LIGHT_PREPASS;
        s.frame.timers = true;
        for (int frame = 0; frame < 2; frame++) {
            struct shot shot = stage_shoot(&s, &s.frame);
            assert_int_equal(has_pass(&s, "forward layers"), layered);
            assert_int_equal(has_pass(&s, "reflectance"), layered && frame == 0);
            shot_free(&shot);
        }
        stage_close(&s);
    }
}

static fnl_scene *some_balls(const enum ball *kinds, uint32_t count) {
    fnl_scene *scene = coarse_scene();
    for (uint32_t i = 0; i < count; i++) {
        const fnl_material_params p = material_of(kinds[i]);
        fnl_material_id id;
        assert_int_equal(fnl_scene_add_material(scene, &p, &id), FNL_OK);
        add_ball(scene, id, -1.8f + 1.2f * (float)(kinds[i] % 4), kinds[i] < 4 ? 0.65f : -0.65f);
    }
    add_lights(scene);
    return scene;
}

/* ---- what is off ---- */

/* Each extension with nothing in it, in a file: the bits of a core material, and nothing that it had not. */
static void test_extensions_at_their_defaults_are_core_MA_24(void **state) {
    UNUSED(state);
    static const char *const names[] = {"clearcoat", "sheen", "iridescence", "anisotropy", "transmission", "volume", "dispersion", "diffuse_transmission",
                                        "ior", "specular", "emissive_strength"};
    static const vec3 positions[3] = {{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}};
    static const fnl_shading shadings[] = {FNL_SHADING_FORWARD, FNL_SHADING_DEFERRED};
    static struct test_log log;
    struct shot core[COUNT_OF(shadings)];
    for (uint32_t i = 0; i <= COUNT_OF(names); i++) {
        char json[1200], extension[100] = "";
        fnl_scene *scene;
        if (i) snprintf(extension, sizeof extension, ",\"extensions\":{\"KHR_materials_%s\":{}}", names[i - 1]);
        snprintf(json, sizeof json,
                 "{\"asset\":{\"version\":\"2.0\"},\"extensionsUsed\":[\"KHR_materials_%s\"],\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.7,0.4,0.2,1],"
                 "\"metallicFactor\":0.3,\"roughnessFactor\":0.4},\"emissiveFactor\":[0.01,0.02,0.03]%s}],\"buffers\":[{\"byteLength\":36}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],"
                 "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC3\",\"count\":3,\"min\":[-1,-1,0],\"max\":[1,1,0]}],"
                 "\"meshes\":[{\"primitives\":[{\"material\":0,\"attributes\":{\"POSITION\":0}}]}],\"nodes\":[{\"mesh\":0}]}",
                 i ? names[i - 1] : "ior", extension);
        assert_int_equal(test_load(&log, json, positions, sizeof positions, &scene), FNL_OK);
        if (log.count) fail_msg("%s", log.text);
        scene->host = fnl_host_default(); /* the log is not the file's any more */
        add_lights(scene);
        struct stage s = open_balls(scene);
        for (uint32_t k = 0; k < COUNT_OF(shadings); k++) {
            s.frame.shading = shadings[k];
            struct shot shot = stage_shoot(&s, &s.frame);
            if (i == 0) {
                core[k] = shot;
                continue;
            }
            if (count_differing(&core[k].radiance, &shot.radiance)) fail_msg("%s changes the picture", names[i - 1]);
            assert_int_equal(shot.stats.pipelines_made, 0); /* the device has those of the core material */
            assert_int_equal(shot.stats.pass_count, core[k].stats.pass_count);
            if (shadings[k] == FNL_SHADING_DEFERRED) assert_int_equal(counter(&shot.stats, "gbuffer.bytes"), 16 * 96 * 54);
            shot_free(&shot);
        }
        stage_close(&s);
    }
    for (uint32_t k = 0; k < COUNT_OF(shadings); k++) shot_free(&core[k]);
}

/* The same of the API: values of a layer without strength are nothing. */
static void test_layers_without_strength_are_core_MA_24(void **state) {
    UNUSED(state);
    struct shot shots[2];
    for (int i = 0; i < 2; i++) {
        fnl_scene *scene = coarse_scene();
        fnl_material_params p = material_of(CORE);
        fnl_material_id id;
        if (i) {
            p.clearcoat = (fnl_clearcoat_params){.roughness = 0.5f};
            p.sheen = (fnl_sheen_params){.roughness = 0.4f};
            p.iridescence = (fnl_iridescence_params){.ior = 1.6f, .thickness_maximum = 300};
            p.anisotropy = (fnl_anisotropy_params){.rotation = 0.6f};
            p.volume.thickness = 2;
            p.dispersion = 0.5f;
            p.diffuse_transmission.color[0] = 0.3f;
        }
        assert_int_equal(fnl_scene_add_material(scene, &p, &id), FNL_OK);
        add_ball(scene, id, 0, 0);
        add_lights(scene);
        struct stage s = open_balls(scene);
        s.frame.shading = FNL_SHADING_FORWARD;
        shots[i] = stage_shoot(&s, &s.frame);
        stage_close(&s);
    }
    assert_int_equal(count_differing(&shots[0].radiance, &shots[1].radiance), 0);
    assert_int_equal(shots[0].stats.pass_count, shots[1].stats.pass_count);
    for (int i = 0; i < 2; i++) shot_free(&shots[i]);
}

enum { PIPELINES_MAX = 8 };

/* The pipelines of the pass "forward", each once. */
static uint32_t forward_pipelines(const struct gpu_pipeline *out[PIPELINES_MAX]) {
    uint32_t count = 0;
    for (uint32_t i = 0; i < spy.work_count; i++) {
        uint32_t k = 0;
        if (!strstr(spy.work[i].label, "forward") || !spy_graphics_params(spy.work[i].pipeline)) continue;
        while (k < count && out[k] != spy.work[i].pipeline) k++;
        if (k < count) continue;
        assert_true(count < PIPELINES_MAX);
        out[count++] = spy.work[i].pipeline;
    }
    return count;
}

/* Core materials beside layered ones are drawn by the very pipelines that they have alone; one more knows layers. */
static void test_core_materials_keep_their_pipelines_MA_25(void **state) {
    UNUSED(state);
    static const enum ball kinds[] = {CORE, COAT, CLOTH, BRUSHED};
    const struct gpu_pipeline *alone[PIPELINES_MAX], *beside[PIPELINES_MAX];
    uint32_t count[2] = {0};
    for (uint32_t i = 0; i < 2; i++) {
        struct stage s = open_balls(some_balls(kinds, i ? COUNT_OF(kinds) : 1));
        s.frame.shading = FNL_SHADING_FORWARD;
        s.frame.record_threads = 1;
        spy_begin(harness_device());
        spy_clear();
        struct shot shot = stage_shoot(&s, &s.frame);
        count[i] = forward_pipelines(i ? beside : alone);
        spy_end();
        shot_free(&shot);
        stage_close(&s);
    }
    assert_true(count[0] >= 1 && count[1] == count[0] + 1);
    uint32_t same = 0;
    for (uint32_t i = 0; i < count[1]; i++) {
        bool known = false;
        for (uint32_t k = 0; k < count[0]; k++) known |= beside[i] == alone[k];
        assert_int_equal((spy_graphics_params(beside[i])->constants[LIGHTING_ID] & GPU_LIGHTING_LAYERS) != 0, !known);
        same += known;
    }
    assert_int_equal(same, count[0]);
}

/* ---- G-buffers ---- */

static uint64_t items_forward(const fnl_frame_stats *stats) { return has_counter(stats, "gbuffer.items-forward") ? counter(stats, "gbuffer.items-forward") : 0; }

/* The layout for them is taken where it helps, and holds them: no forward pass, no mask, the picture of forward shading within its rounding. */
static void test_a_gbuffer_holds_coats_and_anisotropy_MA_22(void **state) {
    UNUSED(state);
    static const enum ball held[] = {CORE, COAT, BRUSHED}, others[] = {CORE, COAT, CLOTH, BRUSHED, ALL}, cores[] = {CORE};
    static const struct {
        const enum ball *kinds;
        uint32_t count, forward, bytes;
    } scenes[] = {{held, 3, 0, 32}, {others, 5, 2, 33}, {cores, 1, 0, 20}};
    static const struct {
        fnl_shading shading;
        uint32_t msaa;
        fnl_msaa_method method;
        fnl_deferred_pass pass;
        uint32_t blocks;
        double most; /* off from forward shading */
    } ways[] = {{FNL_SHADING_DEFERRED, 1, FNL_MSAA_COMPACT, FNL_DEFERRED_COMPUTE, 0, 0.001}, {FNL_SHADING_DEFERRED, 1, FNL_MSAA_COMPACT, FNL_DEFERRED_COMPUTE, 8, 0.001},
                {FNL_SHADING_DEFERRED, 1, FNL_MSAA_COMPACT, FNL_DEFERRED_FRAGMENT, 0, 0.001}, {FNL_SHADING_DEFERRED, 4, FNL_MSAA_COMPACT, FNL_DEFERRED_COMPUTE, 0, 0.025},
                {FNL_SHADING_DEFERRED, 4, FNL_MSAA_AGGREGATE, FNL_DEFERRED_COMPUTE, 0, 0.05}, {FNL_SHADING_DEFERRED_VOLUMES, 1, FNL_MSAA_COMPACT, FNL_DEFERRED_COMPUTE, 0, 0.001}};
    for (uint32_t k = 0; k < COUNT_OF(scenes); k++) {
        struct stage s = open_balls(some_balls(scenes[k].kinds, scenes[k].count));
        s.frame.timers = true; /* passes are known by them */
        for (uint32_t w = 0; w < (k ? 1 : COUNT_OF(ways)); w++) {
            s.frame.msaa = ways[w].msaa;
            s.frame.shading = FNL_SHADING_FORWARD;
            struct shot want = stage_shoot(&s, &s.frame);
            s.frame.shading = ways[w].shading;
            s.frame.deferred.msaa_method = ways[w].method;
            s.frame.deferred.pass = ways[w].pass;
            s.frame.deferred.class_blocks = ways[w].blocks;
            s.frame.count_lights = true;
            struct shot shot = stage_shoot(&s, &s.frame);
            double worst = 0, core = difference(&shot.radiance, &want.radiance, CORE);
            for (uint32_t i = 0; i < scenes[k].count; i++) worst = fmax(worst, difference(&shot.radiance, &want.radiance, (int)scenes[k].kinds[i]));
            print_message("scene %u, %s, %u samples, way %u: %.5f off, core %.5f\n", k, fnl_value_name(FNL_ENUM_SHADING, s.frame.shading), s.frame.msaa, w, worst, core);
            assert_true(worst < ways[w].most);
            assert_int_equal(items_forward(&shot.stats), scenes[k].forward);
            assert_int_equal(counter(&shot.stats, "gbuffer.bytes"), (uint64_t)scenes[k].bytes * s.frame.msaa * 96 * 54);
            assert_int_equal(has_pass(&s, "lit forward"), scenes[k].forward > 0);
            s.frame.count_lights = false;
            shot_free(&shot);
            shot_free(&want);
        }
        s.frame.msaa = 1;
        s.frame.shading = FNL_SHADING_DEFERRED;
        s.frame.deferred = frame_plain().deferred;
        struct shot automatic = stage_shoot(&s, &s.frame);
        s.frame.gbuffer.layout = FNL_GBUFFER_LAYERS;
        struct shot asked = stage_shoot(&s, &s.frame);
        assert_int_equal(count_differing(&automatic.radiance, &asked.radiance), 0);
        assert_int_equal(counter(&asked.stats, "gbuffer.bytes"), (uint64_t)(scenes[k].forward ? 33 : 32) * 96 * 54);
        s.frame.gbuffer.normals = FNL_NORMALS_FLOAT;
        assert_int_equal(fnl_renderer_render(s.renderer, &s.frame), FNL_ERROR_UNSUPPORTED);
        s.frame.gbuffer = frame_plain().gbuffer;
        s.frame.gbuffer.chroma = true; /* another default: they are lit forward, as in each published layout */
        struct shot chroma = stage_shoot(&s, &s.frame);
        assert_int_equal(has_pass(&s, "lit forward"), scenes[k].kinds != cores);
        assert_int_equal(counter(&chroma.stats, "gbuffer.bytes"), (uint64_t)(scenes[k].kinds == cores ? 18 : 19) * 96 * 54);
        shot_free(&automatic);
        shot_free(&asked);
        shot_free(&chroma);
        stage_close(&s);
    }
}

/* Blocks of pixels that need no light are skipped; what is black but for its coat needs it. */
static void test_a_black_surface_with_a_coat_is_shaded_in_classes_MA_22(void **state) {
    UNUSED(state);
    fnl_scene *scene = coarse_scene();
    fnl_material_params p = material_of(COAT);
    fnl_material_id id;
    p.specular = p.base_color[0] = p.base_color[1] = p.base_color[2] = 0;
    assert_int_equal(fnl_scene_add_material(scene, &p, &id), FNL_OK);
    add_ball(scene, id, 0, 0);
    add_lights(scene);
    struct stage s = open_balls(scene);
    s.frame.shading = FNL_SHADING_DEFERRED;
    struct shot want = stage_shoot(&s, &s.frame);
    s.frame.deferred.class_blocks = 8;
    struct shot shot = stage_shoot(&s, &s.frame);
    assert_int_equal(count_differing(&want.radiance, &shot.radiance), 0);
    assert_true(((const float *)shot.radiance.pixels)[4 * (27 * 96 + 48)] > 0);
    shot_free(&want);
    shot_free(&shot);
    stage_close(&s);
}

/* These paths have no G-buffer of materials: what it cannot hold is no exception to them, and nothing is drawn over their picture. */
static void test_paths_without_its_limits_draw_nothing_over_MA_23(void **state) {
    UNUSED(state);
    static const fnl_shading shadings[] = {FNL_SHADING_VISIBILITY, FNL_SHADING_TEXTURING, FNL_SHADING_DAIS, FNL_SHADING_LIGHT_PREPASS};
    fnl_scene *scene = balls(true);
    add_lights(scene);
    struct stage s = open_balls(scene);
    s.frame.timers = s.frame.count_lights = true;
    for (uint32_t i = 0; i < COUNT_OF(shadings); i++) {
        s.frame.shading = shadings[i];
        struct shot shot = stage_shoot(&s, &s.frame);
        const bool over = shadings[i] == FNL_SHADING_LIGHT_PREPASS;
        assert_int_equal(has_pass(&s, "forward"), over);
        assert_int_equal(items_forward(&shot.stats), over ? BALLS - 1 : 0);
        shot_free(&shot);
    }
    stage_close(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_layers_are_those_of_rays_MA_1, harness_check),
        cmocka_unit_test_teardown(test_layers_keep_a_white_furnace_white_MA_2, harness_check),
        cmocka_unit_test_teardown(test_every_order_shades_layers_MA_3, harness_check),
        cmocka_unit_test_teardown(test_core_materials_keep_their_bits_MA_4, harness_check),
        cmocka_unit_test_teardown(test_layers_cost_only_where_they_are_MA_5, harness_check),
        cmocka_unit_test_teardown(test_extensions_at_their_defaults_are_core_MA_24, harness_check),
        cmocka_unit_test_teardown(test_layers_without_strength_are_core_MA_24, harness_check),
        cmocka_unit_test_teardown(test_core_materials_keep_their_pipelines_MA_25, spy_tear_down),
        cmocka_unit_test_teardown(test_a_gbuffer_holds_coats_and_anisotropy_MA_22, harness_check),
        cmocka_unit_test_teardown(test_a_black_surface_with_a_coat_is_shaded_in_classes_MA_22, harness_check),
        cmocka_unit_test_teardown(test_paths_without_its_limits_draw_nothing_over_MA_23, harness_check),
    };
    return cmocka_run_group_tests_name("layers", tests, harness_begin, harness_end);
}
