/* SPDX-License-Identifier: MIT */
/* What glTF can say in several ways is shown the same, in frames and traced. */
#include "tests/gltf_test_file.h"
#include "tests/render_harness.h"

#include "fanal/trace.h"

#include <unistd.h>

#define ASSET "\"asset\":{\"version\":\"2.0\"}"
enum { SIDE = 9, POINTS = SIDE * SIDE, CORNERS = (SIDE - 1) * (SIDE - 1) * 6 };

/* ---- files ---- */

struct file {
    char views[2048], accessors[4096], json[16384];
    unsigned char binary[1 << 16];
    size_t size;
    uint32_t view_count, accessor_count;
};
static struct file file;
static struct test_log lines;

static void add_view(const void *data, size_t size) {
    char text[128];
    snprintf(text, sizeof text, "%s{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu}", file.view_count++ ? "," : "", file.size, size);
    strcat(file.views, text);
    assert_true(file.size + size + 4 < sizeof file.binary);
    memcpy(file.binary + file.size, data, size);
    file.size = (file.size + size + 3) / 4 * 4;
}

static void add_accessor(const void *data, size_t size, uint32_t component, const char *type, uint32_t count) {
    char text[160];
    add_view(data, size);
    snprintf(text, sizeof text, "%s{\"bufferView\":%u,\"componentType\":%u,\"type\":\"%s\",\"count\":%u}", file.accessor_count++ ? "," : "", file.view_count - 1,
             component, type, count);
    strcat(file.accessors, text);
}

static float height(float x, float y, float bend) { return bend * (0.2f * sinf(3 * x) * cosf(2 * y) - 0.1f * y * y); }

/* A bent sheet about the origin that faces +Z, `scale` as large: accessors positions 0, normals 1, uvs 2 (turned by a 2x2 matrix), indices 3. */
static void add_sheet(float bend, float scale, const float turn[4]) {
    static vec3 positions[POINTS], normals[POINTS];
    static vec2 uv[POINTS];
    static uint32_t indices[CORNERS];
    uint32_t *index = indices;
    for (uint32_t i = 0; i < POINTS; i++) {
        const float s = (float)(i % SIDE) / (SIDE - 1), t = (float)(i / SIDE) / (SIDE - 1), x = 2 * s - 1, y = 1 - 2 * t, e = 1e-3f;
        const vec3 along = {2 * e, 0, height(x + e, y, bend) - height(x - e, y, bend)}, up = {0, 2 * e, height(x, y + e, bend) - height(x, y - e, bend)};
        positions[i] = vec3_scale(vec3_make(x, y, height(x, y, bend)), scale);
        normals[i] = vec3_normalize(vec3_cross(along, up));
        uv[i] = vec2_make(turn[0] * s + turn[1] * t, turn[2] * s + turn[3] * t);
    }
    for (uint32_t y = 0; y + 1 < SIDE; y++)
        for (uint32_t x = 0; x + 1 < SIDE; x++) {
            const uint32_t a = y * SIDE + x, corners[6] = {a, a + SIDE, a + 1, a + 1, a + SIDE, a + SIDE + 1};
            memcpy(index, corners, sizeof corners);
            index += 6;
        }
    add_accessor(positions, sizeof positions, 5126, "VEC3", POINTS);
    add_accessor(normals, sizeof normals, 5126, "VEC3", POINTS);
    add_accessor(uv, sizeof uv, 5126, "VEC2", POINTS);
    add_accessor(indices, sizeof indices, 5125, "SCALAR", CORNERS);
}

static const float straight[4] = {1, 0, 0, 1};
static void begin_with(float bend, float scale, const float turn[4]) {
    memset(&file, 0, sizeof file);
    add_sheet(bend, scale, turn);
}
static void begin(void) { begin_with(1, 1, straight); }

/* A picture of 4 x 4 texels as the next buffer view. */
static void add_picture(uint8_t texels[64]) {
    char path[] = "/tmp/fanal-picture-XXXXXX.png";
    const int handle = mkstemps(path, 4);
    assert_true(handle >= 0);
    close(handle);
    assert_int_equal(fnl_image_save(NULL, path, &(fnl_image){4, 4, FNL_PIXEL_FORMAT_RGBA8, texels}), FNL_OK);
    const fnl_host host = host_resolve(NULL);
    struct file_view view;
    assert_int_equal(file_load(&host, path, &view), FNL_OK);
    add_view(view.data, view.size);
    file_free(&host, &view);
    unlink(path);
}

/* The rest of the document: what stands beside buffers, views and accessors. A lamp is added to its scene. */
static fnl_scene *finish(const char *rest) {
    fnl_scene *scene = NULL;
    snprintf(file.json, sizeof file.json, "{" ASSET ",\"buffers\":[{\"byteLength\":%zu}],\"bufferViews\":[%s],\"accessors\":[%s],%s}", file.size, file.views,
             file.accessors, rest);
    if (test_load(&lines, file.json, file.binary, file.size, &scene) != FNL_OK) fail_msg("%s", lines.text);
    fnl_light_params lamp = fnl_light_params_default();
    fnl_light_id id;
    lamp.position = vec3_make(1, 1.5f, 2);
    lamp.intensity = 60;
    lamp.range = 100;
    assert_int_equal(fnl_scene_add_light(scene, &lamp, &id), FNL_OK);
    return scene;
}

/* ---- pictures ---- */

static fnl_camera camera_at(vec3 position, vec3 target) {
    fnl_camera camera = fnl_camera_default();
    camera.position = position;
    camera.target = target;
    return camera;
}

static struct stage open_stage(fnl_scene *scene) {
    struct stage s = stage_open_scene(scene);
    s.frame.width = s.frame.height = 48;
    s.frame.camera = camera_at(vec3_make(0, 0, 3), vec3_make(0, 0, 0));
    s.frame.shading = FNL_SHADING_FORWARD;
    s.frame.lists = FNL_LISTS_ALL;
    return s;
}

static fnl_image traced(const struct stage *s, bool shadows) {
    fnl_trace_params p = trace_plain();
    fnl_trace trace;
    p.width = s->frame.width, p.height = s->frame.height, p.camera = s->frame.camera;
    p.shadows = shadows;
    assert_int_equal(fnl_scene_trace(s->scene, &p, &trace), FNL_OK);
    fnl_image_free(&s->scene->host, &trace.color);
    return trace.radiance;
}

/* Pixels that differ by more than a part of the brightest; fails where one picture is black. */
static uint32_t count_off(const fnl_image *a, const fnl_image *b, double part) {
    const float *x = a->pixels, *y = b->pixels;
    double most = 0;
    uint32_t off = 0;
    for (size_t i = 0; i < (size_t)a->width * a->height; i++) most = fmax(most, (double)y[4 * i + 1]);
    assert_true(most > 0.1);
    for (size_t i = 0; i < (size_t)a->width * a->height; i++)
        for (int c = 0; c < 3; c++)
            if (fabs((double)x[4 * i + (size_t)c] - (double)y[4 * i + (size_t)c]) > part * most) {
                off++;
                break;
            }
    return off;
}

static const fnl_shading paths[] = {FNL_SHADING_FORWARD, FNL_SHADING_DEFERRED, FNL_SHADING_VISIBILITY};

/* The scene of the stage must look like the other, which goes. At most `allowed` pixels may differ. */
static void expect_like(struct stage *s, fnl_scene *expected, const char *what, uint32_t allowed) {
    struct stage other = open_stage(expected);
    other.frame.camera = s->frame.camera;
    for (uint32_t i = 0; i < COUNT_OF(paths); i++) {
        s->frame.shading = other.frame.shading = paths[i];
        struct shot a = stage_shoot(s, &s->frame), b = stage_shoot(&other, &other.frame);
        const uint32_t off = count_off(&a.radiance, &b.radiance, 2e-3);
        if (off > allowed) fail_msg("%s: %u pixels of path %u are off", what, off, i);
        shot_free(&a);
        shot_free(&b);
    }
    fnl_image a = traced(s, false), b = traced(&other, false);
    const uint32_t off = count_off(&a, &b, 2e-3);
    if (off > allowed) fail_msg("%s: %u pixels are off when it is traced", what, off);
    fnl_image_free(&s->scene->host, &a);
    fnl_image_free(&s->scene->host, &b);
    stage_close(&other);
}

static void expect_same(fnl_scene *scene, fnl_scene *expected, const char *what, uint32_t allowed) {
    struct stage s = open_stage(scene);
    expect_like(&s, expected, what, allowed);
    stage_close(&s);
}

#define PLAIN "\"attributes\":{\"POSITION\":0,\"NORMAL\":1,\"TEXCOORD_0\":2},\"indices\":3"
#define MESH(extra) "\"meshes\":[{\"primitives\":[{" PLAIN ",\"material\":0" extra "}]}]"

/* ---- skins ---- */

#define SKINNED "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":1,\"TEXCOORD_0\":2,\"JOINTS_0\":4,\"WEIGHTS_0\":5},\"indices\":3,\"material\":0}]}]"
#define SIDES(double_sided) "\"materials\":[{\"doubleSided\":" double_sided ",\"pbrMetallicRoughness\":{\"metallicFactor\":0.2,\"roughnessFactor\":0.5}}],"

static void begin_skin(void) {
    static uint8_t joints[POINTS][4];
    static float weights[POINTS][4];
    static const float times[2] = {0, 1}, scales[6] = {1, 1, 1, -1, 1, 1};
    for (uint32_t i = 0; i < POINTS; i++) joints[i][0] = 1, weights[i][0] = 1;
    begin();
    add_accessor(joints, sizeof joints, 5121, "VEC4", POINTS);
    add_accessor(weights, sizeof weights, 5126, "VEC4", POINTS);
    add_accessor(times, sizeof times, 5126, "SCALAR", 2);
    add_accessor(scales, sizeof scales, 5126, "VEC3", 2);
}

/* Joints 0 and 2 move nothing, and mirror nothing. */
static void test_skins_under_mirrored_skeletons(void **state) {
    UNUSED(state);
#define SKIN(nodes) SKINNED ",\"skins\":[{\"joints\":[2,1,3]}],\"nodes\":[{\"mesh\":0,\"skin\":0}," nodes ",{},{}]"
    static const char *const skins[] = {
        SKIN("{\"scale\":[-1,1,1]}"),
        SKIN("{\"matrix\":[-1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]}"),
        SKINNED ",\"skins\":[{\"joints\":[2,1,3]}],\"nodes\":[{\"mesh\":0,\"skin\":0},{},{},{},{\"children\":[0,1,2,3],\"scale\":[-1,1,1]}]",
        SKIN("{}") ",\"animations\":[{\"samplers\":[{\"input\":6,\"output\":7}],\"channels\":[{\"sampler\":0,\"target\":{\"node\":1,\"path\":\"scale\"}}]}]",
    };
    static const char *const sides[] = {SIDES("false"), SIDES("true")};
    for (uint32_t side = 0; side < 2; side++)
        for (uint32_t i = 0; i < COUNT_OF(skins); i++) {
            char text[2048], what[64];
            snprintf(text, sizeof text, "%s%s", sides[side], skins[i]);
            snprintf(what, sizeof what, "skin %u, %s-sided", i, side ? "double" : "single");
            begin_skin();
            struct stage s = open_stage(finish(text));
            if (i == 3) { /* the sign changes between two frames, and back */
                struct shot shot = stage_shoot(&s, &s.frame);
                shot_free(&shot);
                assert_int_equal(fnl_scene_set_time(s.scene, 0, 1), FNL_OK);
            }
            snprintf(text, sizeof text, "%s" MESH("") ",\"nodes\":[{\"mesh\":0,\"scale\":[-1,1,1]}]", sides[side]);
            begin();
            expect_like(&s, finish(text), what, 0);
            if (i == 3) {
                assert_int_equal(fnl_scene_set_time(s.scene, 0, 0), FNL_OK);
                snprintf(text, sizeof text, "%s" MESH("") ",\"nodes\":[{\"mesh\":0}]", sides[side]);
                begin();
                expect_like(&s, finish(text), what, 0);
            }
            stage_close(&s);
        }
}

/* ---- normals and tangents ---- */

static void normal_texels(uint8_t out[64]) {
    for (uint32_t i = 0; i < 16; i++) {
        const vec3 n = vec3_normalize(vec3_make(i % 4 < 2 ? 0.5f : -0.2f, i / 4 < 2 ? 0.4f : -0.3f, 1));
        for (int c = 0; c < 3; c++) out[4 * i + (uint32_t)c] = (uint8_t)lrintf(((&n.x)[c] * 0.5f + 0.5f) * 255);
        out[4 * i + 3] = 255;
    }
}

#define TEXTURE(view) "\"images\":[{\"bufferView\":" #view ",\"mimeType\":\"image/png\"}],\"textures\":[{\"source\":0}],"

/* A target that bends a flat sheet, where the file has no normals: flat ones, and tangents, of the bent. */
static void test_morphed_meshes_without_normals(void **state) {
    UNUSED(state);
    uint8_t texels[64];
    static vec3 moves[POINTS];
    static const char *const rough = "\"materials\":[{\"pbrMetallicRoughness\":{\"metallicFactor\":0,\"roughnessFactor\":0.6},\"normalTexture\":{\"index\":0}}],"
                                     "\"nodes\":[{\"mesh\":0}],";
    char text[2048];
    normal_texels(texels);
    for (uint32_t i = 0; i < POINTS; i++) {
        const float x = 2 * (float)(i % SIDE) / (SIDE - 1) - 1, y = 1 - 2 * (float)(i / SIDE) / (SIDE - 1);
        moves[i] = vec3_make(0, 0, height(x, y, 2));
    }
    begin_with(0, 1, straight);
    add_picture(texels);
    add_accessor(moves, sizeof moves, 5126, "VEC3", POINTS);
    snprintf(text, sizeof text, "%s" TEXTURE(4) "\"meshes\":[{\"weights\":[1],\"primitives\":[{\"attributes\":{\"POSITION\":0,\"TEXCOORD_0\":2},\"indices\":3,\"material\":0,"
             "\"targets\":[{\"POSITION\":4}]}]}]", rough);
    fnl_scene *scene = finish(text);
    begin_with(2, 1, straight);
    add_picture(texels);
    snprintf(text, sizeof text, "%s" TEXTURE(4) "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"TEXCOORD_0\":2},\"indices\":3,\"material\":0}]}]", rough);
    expect_same(scene, finish(text), "morphed", 2);
}

/* The same coordinates, once in the file and once by KHR_texture_transform. */
static void test_tangents_follow_texture_transforms(void **state) {
    UNUSED(state);
#define COAT "\"extensions\":{\"KHR_materials_clearcoat\":{\"clearcoatFactor\":1,\"clearcoatRoughnessFactor\":0.3,\"clearcoatNormalTexture\":{\"index\":0%s}}}"
#define STRETCH "\"extensions\":{\"KHR_materials_anisotropy\":{\"anisotropyStrength\":0.9,\"anisotropyTexture\":{\"index\":0%s}}}"
#define BASE "\"pbrMetallicRoughness\":{\"metallicFactor\":0.3,\"roughnessFactor\":0.4}"
    static const char *const materials[] = {
        BASE ",\"normalTexture\":{\"index\":0%s}", BASE "," COAT, BASE "," STRETCH,
        /* The tangents are those of the normal texture, which is not turned. */
        BASE ",\"normalTexture\":{\"index\":0,\"scale\":0}," COAT, BASE ",\"normalTexture\":{\"index\":0,\"scale\":0}," STRETCH};
    static const struct {
        const char *transform;
        float turn[4];
    } turns[] = {{"\"rotation\":1.5707963267948966", {0, 1, -1, 0}}, {"\"scale\":[-1,1]", {-1, 0, 0, 1}}, {"\"scale\":[2,-2]", {2, 0, 0, -2}},
                 {"\"rotation\":0.6", {0.82533561f, 0.56464247f, -0.56464247f, 0.82533561f}}};
    uint8_t texels[64];
    char text[2048], material[1024], transform[256], what[64];
    normal_texels(texels);
    for (uint32_t m = 0; m < COUNT_OF(materials); m++)
        for (uint32_t t = m < 3 ? 0 : 2; t < COUNT_OF(turns); t++) {
            /* A flat sheet: there a turn within the surface is the same as one of its coordinates. */
            const float bend = m < 3 ? 1 : 0;
            snprintf(what, sizeof what, "material %u, transform %u", m, t);
            snprintf(transform, sizeof transform, ",\"extensions\":{\"KHR_texture_transform\":{%s}}", turns[t].transform);
            for (uint32_t k = 0; k < 2; k++) {
                snprintf(material, sizeof material, materials[m], k ? "" : transform);
                begin_with(bend, 1, k ? turns[t].turn : straight);
                add_picture(texels);
                snprintf(text, sizeof text, "\"extensionsUsed\":[\"KHR_texture_transform\",\"KHR_materials_clearcoat\",\"KHR_materials_anisotropy\"]," TEXTURE(4)
                         "\"materials\":[{%s}]," MESH("") ",\"nodes\":[{\"mesh\":0}]", material);
                static fnl_scene *scenes[2];
                scenes[k] = finish(text);
                fnl_entity_info info; /* a material that is set keeps the frame of its tangents */
                fnl_material_params params;
                assert_int_equal(fnl_scene_query_entity(scenes[k], FNL_ENTITY_MATERIAL, 0, &info), FNL_OK);
                assert_int_equal(fnl_scene_query_material(scenes[k], 0, &params), FNL_OK);
                assert_int_equal(fnl_scene_set_material(scenes[k], info.id.material, &params), FNL_OK);
                if (k) expect_same(scenes[0], scenes[1], what, 40); /* at texel borders a filter rounds in another way */
            }
        }
}

static void test_scales_of_any_size(void **state) {
    UNUSED(state);
    static const float scales[] = {1e13f, 1e-13f, 1e11f, -1e11f};
    for (uint32_t i = 0; i < COUNT_OF(scales); i++)
        for (int flat = 0; flat < 2; flat++) {
            char text[1024], what[64];
            static const char *const attributes[] = {"\"POSITION\":0,\"NORMAL\":1", "\"POSITION\":0"};
            snprintf(what, sizeof what, "scale %g, %s normals", (double)scales[i], flat ? "flat" : "given");
            begin_with(1, 1 / fabsf(scales[i]), straight);
            snprintf(text, sizeof text, "\"meshes\":[{\"primitives\":[{\"attributes\":{%s},\"indices\":3}]}],\"nodes\":[{\"mesh\":0,\"scale\":[%g,%g,%g]}]",
                     attributes[flat], (double)scales[i], fabs((double)scales[i]), fabs((double)scales[i]));
            fnl_scene *scene = finish(text);
            begin();
            snprintf(text, sizeof text, "\"meshes\":[{\"primitives\":[{\"attributes\":{%s},\"indices\":3}]}],\"nodes\":[{\"mesh\":0,\"scale\":[%g,%g,%g]}]",
                     attributes[flat], scales[i] < 0 ? -1.0 : 1.0, 1.0, 1.0);
            expect_same(scene, finish(text), what, 12); /* at edges of faces a rounded corner decides */
        }
}

/* ---- cutouts ---- */

static void test_alpha_that_equals_the_cutoff_stays(void **state) {
    UNUSED(state);
    static float colors[POINTS][4];
    uint8_t texels[64];
    memset(texels, 255, sizeof texels);
    for (uint32_t i = 0; i < 16; i++) texels[4 * i + 3] = 51; /* a fifth */
    for (uint32_t i = 0; i < POINTS; i++)
        for (int c = 0; c < 4; c++) colors[i][c] = c < 3 ? 1 : 0.7f;
    static const struct {
        const char *factor, *cutoff;
        bool texture, color;
    } cases[] = {{"1", "1", false, false}, {"0.5", "0.5", false, false}, {"1", "0.7", false, true}, {"1", "0.2", true, false}, {"0.5", "0.07", true, true}};
    for (uint32_t i = 0; i < COUNT_OF(cases); i++)
        for (int shadows = 0; shadows < 3; shadows++) {
            char text[2048];
            const char *color = cases[i].color ? ",\"COLOR_0\":4" : "", *texture = cases[i].texture ? ",\"baseColorTexture\":{\"index\":0}" : "";
            struct shot shots[2];
            fnl_image rays[2];
            for (int opaque = 0; opaque < 2; opaque++) {
                begin();
                add_accessor(colors, sizeof colors, 5126, "VEC4", POINTS);
                add_picture(texels);
                snprintf(text, sizeof text, TEXTURE(5) "\"materials\":[{\"alphaMode\":\"%s\"%s%s,\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,1,1,%s]%s}}],"
                         "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":1,\"TEXCOORD_0\":2%s},\"indices\":3,\"material\":0}]}],"
                         "\"nodes\":[{\"mesh\":0},{\"mesh\":0,\"scale\":[0.3,0.3,0.3],\"translation\":[0.4,0.5,0.6]}]",
                         opaque ? "OPAQUE" : "MASK", opaque ? "" : ",\"alphaCutoff\":", opaque ? "" : cases[i].cutoff, cases[i].factor, texture, color);
                struct stage s = open_stage(finish(text));
                s.frame.shadows = shadows == 0 ? FNL_SHADOWS_OFF : shadows == 1 ? FNL_SHADOWS_RAYS : FNL_SHADOWS_MAPS;
                shots[opaque] = stage_shoot(&s, &s.frame);
                rays[opaque] = traced(&s, shadows > 0);
                stage_close(&s);
            }
            const uint32_t off = count_off(&shots[0].radiance, &shots[1].radiance, 1e-4), off_rays = count_off(&rays[0], &rays[1], 1e-4);
            if (off || off_rays) fail_msg("case %u, shadows %d: holes in %u pixels, and %u that are traced", i, shadows, off, off_rays);
            for (int k = 0; k < 2; k++) {
                shot_free(&shots[k]);
                fnl_image_free(NULL, &rays[k]);
            }
        }
}

/* A pane with holes before a sheet. Texture coordinates 2 are straight, 4 are turned: `sets` names those of the pane, `set` the one that cuts. */
static struct stage cut_pane(const char *sets, int set) {
    static vec2 turned[POINTS];
    uint8_t texels[64];
    char text[2048];
    memset(texels, 255, sizeof texels);
    for (uint32_t i = 0; i < 16; i++) texels[4 * i + 3] = i % 4 == 0 || i / 4 == 1 ? 0 : 255; /* the left, and a bar: alike from no other side */
    for (uint32_t i = 0; i < POINTS; i++) turned[i] = vec2_make((float)(i / SIDE) / (SIDE - 1), 1 - (float)(i % SIDE) / (SIDE - 1));
    begin();
    add_accessor(turned, sizeof turned, 5126, "VEC2", POINTS);
    add_picture(texels);
    snprintf(text, sizeof text, TEXTURE(5) "\"materials\":[{\"pbrMetallicRoughness\":{\"metallicFactor\":0}},{\"alphaMode\":\"MASK\",\"doubleSided\":true,"
             "\"pbrMetallicRoughness\":{\"metallicFactor\":0,\"baseColorFactor\":[0.8,0.2,0.1,1],\"baseColorTexture\":{\"index\":0,\"texCoord\":%d}}}],"
             "\"meshes\":[{\"primitives\":[{" PLAIN ",\"material\":0}]},{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":1,%s},\"indices\":3,\"material\":1}]}],"
             "\"nodes\":[{\"mesh\":0},{\"mesh\":1,\"scale\":[0.4,0.4,0.4],\"translation\":[0.3,0.4,0.8]}]", set, sets);
    return open_stage(finish(text));
}

/* What is seen through the holes, and the light that falls through them. */
static void test_cutouts_by_the_second_texture_coordinates(void **state) {
    UNUSED(state);
    static const struct {
        fnl_shading shading;
        fnl_shadows shadows;
    } ways[] = {{FNL_SHADING_FORWARD, FNL_SHADOWS_OFF},  {FNL_SHADING_FORWARD, FNL_SHADOWS_RAYS},   {FNL_SHADING_FORWARD, FNL_SHADOWS_MAPS},
                {FNL_SHADING_DEFERRED, FNL_SHADOWS_OFF}, {FNL_SHADING_VISIBILITY, FNL_SHADOWS_OFF}};
    struct stage first = cut_pane("\"TEXCOORD_0\":2", 0), second = cut_pane("\"TEXCOORD_0\":4,\"TEXCOORD_1\":2", 1), other = cut_pane("\"TEXCOORD_0\":4", 0);
    struct stage *const stages[] = {&first, &second, &other};
    for (uint32_t i = 0; i < 2 + COUNT_OF(ways); i++) { /* the first two are traced */
        struct shot shots[3] = {0};
        fnl_image pictures[3];
        for (uint32_t k = 0; k < 3; k++) {
            if (i < 2) {
                pictures[k] = traced(stages[k], i == 1);
                continue;
            }
            stages[k]->frame.shading = ways[i - 2].shading, stages[k]->frame.shadows = ways[i - 2].shadows;
            shots[k] = stage_shoot(stages[k], &stages[k]->frame);
            pictures[k] = shots[k].radiance;
        }
        const uint32_t off = count_off(&pictures[1], &pictures[0], 2e-3), turned = count_off(&pictures[2], &pictures[0], 0.02);
        if (off) fail_msg("way %u: the second texture coordinates change %u pixels", i, off);
        if (turned < 60) fail_msg("way %u: other texture coordinates change %u pixels only", i, turned);
        for (uint32_t k = 0; k < 3; k++) {
            if (i < 2) fnl_image_free(NULL, &pictures[k]);
            else shot_free(&shots[k]);
        }
    }
    for (uint32_t k = 0; k < 3; k++) stage_close(stages[k]);
}

/* ---- transmission ---- */

/* The light on the middle of a wall behind a pane, and on it alone. */
static void light_behind_pane(const char *material, fnl_shadows shadows, float out[2]) {
    uint8_t texels[64];
    char text[2048];
    memset(texels, 0, sizeof texels);
    for (uint32_t i = 0; i < 16; i++) texels[4 * i + 3] = 255;
    begin_with(0, 1, straight);
    add_picture(texels);
    snprintf(text, sizeof text, "\"extensionsUsed\":[\"KHR_materials_transmission\"]," TEXTURE(4) "\"materials\":[{\"pbrMetallicRoughness\":{\"metallicFactor\":0}},{%s}],"
             "\"meshes\":[{\"primitives\":[{" PLAIN ",\"material\":0}]},{\"primitives\":[{" PLAIN ",\"material\":1}]}],"
             "\"nodes\":[{\"mesh\":0,\"scale\":[2,2,1]},{\"mesh\":1,\"scale\":[0.3,0.3,1],\"translation\":[0.5,0.75,1]}]", material);
    struct stage s = open_stage(finish(text));
    s.frame.camera = camera_at(vec3_make(-1, -1, 0.8f), vec3_make(0, 0, 0)); /* below the pane */
    s.frame.shadows = shadows;
    struct shot shot = stage_shoot(&s, &s.frame);
    fnl_image rays = traced(&s, true);
    out[0] = ((const float *)shot.radiance.pixels)[(24 * 48 + 24) * 4 + 1];
    out[1] = ((const float *)rays.pixels)[(24 * 48 + 24) * 4 + 1];
    fnl_image_free(NULL, &rays);
    shot_free(&shot);
    stage_close(&s);
}

static void test_opaque_parts_of_transmissive_materials_cast_shadows(void **state) {
    UNUSED(state);
#define GLASS(metal, more) "\"pbrMetallicRoughness\":{\"metallicFactor\":" metal "},\"extensions\":{\"KHR_materials_transmission\":{\"transmissionFactor\":1" more "}}"
    static const struct {
        const char *material;
        bool dark;
    } cases[] = {{GLASS("0", ""), false}, {GLASS("0", ",\"transmissionTexture\":{\"index\":0}"), true}, {GLASS("1", ""), true}, {"\"pbrMetallicRoughness\":{}", true}};
    for (uint32_t i = 0; i < COUNT_OF(cases); i++)
        for (int way = 0; way < 2; way++) {
            float light[2];
            light_behind_pane(cases[i].material, way ? FNL_SHADOWS_MAPS : FNL_SHADOWS_RAYS, light);
            for (int k = 0; k < 2; k++)
                if (cases[i].dark ? light[k] > 0.01f : light[k] < 0.5f) fail_msg("material %u, %s: %g cd/m^2", i, k ? "traced" : way ? "maps" : "rays", (double)light[k]);
        }
}

/* ---- samplers ---- */

static void test_nearest_texels_are_not_blended(void **state) {
    UNUSED(state);
    static const fnl_shading others[] = {FNL_SHADING_DEFERRED, FNL_SHADING_VISIBILITY, FNL_SHADING_TEXTURING, FNL_SHADING_DAIS};
    uint8_t texels[64];
    for (uint32_t i = 0; i < 16; i++) {
        const uint8_t value = (i + i / 4) % 2 ? 255 : 0, texel[4] = {value, value, value, 255};
        memcpy(texels + 4 * i, texel, 4);
    }
    begin_with(0, 1, straight);
    add_picture(texels);
    struct stage s = open_stage(finish("\"extensionsUsed\":[\"KHR_materials_unlit\"],\"images\":[{\"bufferView\":4,\"mimeType\":\"image/png\"}],\"textures\":[{\"source\":0,\"sampler\":0}],"
                                       "\"samplers\":[{\"magFilter\":9728,\"minFilter\":9728}],\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}},"
                                       "\"extensions\":{\"KHR_materials_unlit\":{}}}]," MESH("") ",\"nodes\":[{\"mesh\":0}]"));
    s.frame.camera = camera_at(vec3_make(2, 0.3f, 1.1f), vec3_make(0, 0, 0)); /* slanted: footprints are long */
    struct shot first = stage_shoot(&s, &s.frame);
    for (uint32_t i = 0; i < COUNT_OF(others); i++) {
        s.frame.shading = others[i];
        struct shot shot = stage_shoot(&s, &s.frame);
        const float *pixels = shot.radiance.pixels;
        for (size_t k = 0; k < 48 * 48; k++)
            if (pixels[4 * k + 1] > 0.01f && pixels[4 * k + 1] < 0.99f) fail_msg("path %u: pixel %zu is %g", i, k, (double)pixels[4 * k + 1]);
        assert_true(count_off(&shot.radiance, &first.radiance, 1e-3) <= 4); /* on the very borders of texels */
        shot_free(&shot);
    }
    shot_free(&first);
    stage_close(&s);
}

/* ---- orthographic cameras ---- */

/* Planes of 0 and a million metres, from near and from far; and such as fit. */
static void test_orthographic_planes_far_apart(void **state) {
    UNUSED(state);
    static const char *const lenses[] = {"\"znear\":0,\"zfar\":1e6", "\"znear\":0.1,\"zfar\":1e6", "\"znear\":0.1,\"zfar\":70"};
    static const float distances[] = {2.2f, 50};
    static const fnl_shading ways[] = {FNL_SHADING_FORWARD, FNL_SHADING_DEFERRED, FNL_SHADING_LIGHT_PREPASS};
    for (uint32_t far = 0; far < 2; far++)
        for (uint32_t way = 0; way < COUNT_OF(ways) + 1; way++) {
            struct shot shots[COUNT_OF(lenses)] = {0};
            fnl_image rays[COUNT_OF(lenses)] = {0};
            for (uint32_t i = 0; i < COUNT_OF(lenses); i++) {
                char text[1024];
                begin();
                snprintf(text, sizeof text, "\"materials\":[{\"pbrMetallicRoughness\":{\"metallicFactor\":0,\"roughnessFactor\":0.7}}]," MESH("")
                         ",\"cameras\":[{\"type\":\"orthographic\",\"orthographic\":{\"xmag\":2,\"ymag\":2,%s}}],"
                         "\"nodes\":[{\"mesh\":0},{\"mesh\":0,\"scale\":[0.2,0.2,0.2],\"translation\":[0,0,1.4]},{\"camera\":0,\"translation\":[0,0,%g]}]",
                         lenses[i], (double)distances[far]);
                struct stage s = open_stage(finish(text));
                assert_int_equal(fnl_scene_query_camera(s.scene, 0, &s.frame.camera), FNL_OK);
                assert_true(i != 0 || s.frame.camera.near_distance == 0);
                if (way == COUNT_OF(ways)) {
                    rays[i] = traced(&s, true);
                } else {
                    s.frame.shading = ways[way];
                    shots[i] = stage_shoot(&s, &s.frame);
                }
                stage_close(&s);
            }
            const bool by_rays = way == COUNT_OF(ways);
            for (uint32_t i = 0; i < 2; i++) {
                const uint32_t off = by_rays ? count_off(&rays[i], &rays[2], 2e-3) : count_off(&shots[i].radiance, &shots[2].radiance, 2e-3);
                if (off) fail_msg("lens %u from %g m, way %u: %u pixels are off", i, (double)distances[far], way, off);
            }
            for (uint32_t i = 0; i < COUNT_OF(lenses); i++) {
                if (by_rays) fnl_image_free(NULL, &rays[i]);
                else shot_free(&shots[i]);
            }
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_skins_under_mirrored_skeletons, harness_check),
        cmocka_unit_test_teardown(test_morphed_meshes_without_normals, harness_check),
        cmocka_unit_test_teardown(test_tangents_follow_texture_transforms, harness_check),
        cmocka_unit_test_teardown(test_scales_of_any_size, harness_check),
        cmocka_unit_test_teardown(test_alpha_that_equals_the_cutoff_stays, harness_check),
        cmocka_unit_test_teardown(test_cutouts_by_the_second_texture_coordinates, harness_check),
        cmocka_unit_test_teardown(test_opaque_parts_of_transmissive_materials_cast_shadows, harness_check),
        cmocka_unit_test_teardown(test_nearest_texels_are_not_blended, harness_check),
        cmocka_unit_test_teardown(test_orthographic_planes_far_apart, harness_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
