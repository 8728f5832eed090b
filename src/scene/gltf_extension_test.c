/* SPDX-License-Identifier: MIT */
/* What the importer makes of extensions that say more than a scene shows at once: variants of materials, environments,
   metadata. */
#include "tests/gltf_test_file.h"

#include <setjmp.h>
#include <unistd.h>

#include <cmocka.h>

#define ASSET "\"asset\":{\"version\":\"2.0\"}"

static struct test_log file_log;

static fnl_scene *load(const char *json, const void *binary, size_t size) {
    fnl_scene *scene = NULL;
    if (test_load(&file_log, json, binary, size, &scene) != FNL_OK) fail_msg("not loaded: %s", file_log.text);
    return scene;
}

static fnl_scene *load_clean(const char *json, const void *binary, size_t size) {
    fnl_scene *scene = load(json, binary, size);
    if (file_log.count) fail_msg("%s", file_log.text);
    return scene;
}

static void expect_lines(const char *const *lines, uint32_t count) {
    for (uint32_t i = 0; i < count; i++)
        if (!strstr(file_log.text, lines[i])) fail_msg("no '%s' in:\n%s", lines[i], file_log.text);
    if (file_log.count != count) fail_msg("%u lines, not %u:\n%s", file_log.count, count, file_log.text);
}

/* ---- what is read ---- */

/* What Khronos has ratified, and the extensions of others that are named in the documents. */
static void test_ratified_extensions_are_full(void **state) {
    UNUSED(state);
    static const char *const names[] = {"KHR_animation_pointer", "KHR_draco_mesh_compression", "KHR_lights_punctual", "KHR_materials_anisotropy", "KHR_materials_clearcoat",
                                        "KHR_materials_dispersion", "KHR_materials_emissive_strength", "KHR_materials_ior", "KHR_materials_iridescence",
                                        "KHR_materials_sheen", "KHR_materials_specular", "KHR_materials_transmission", "KHR_materials_unlit", "KHR_materials_variants",
                                        "KHR_materials_volume", "KHR_mesh_quantization", "KHR_texture_basisu", "KHR_texture_transform", "KHR_xmp_json_ld",
                                        "KHR_materials_diffuse_transmission", "KHR_meshopt_compression", "KHR_node_visibility", "EXT_lights_ies", "EXT_lights_image_based",
                                        "EXT_mesh_gpu_instancing", "EXT_meshopt_compression", "EXT_texture_webp", "MSFT_lod", "MSFT_texture_dds"};
    char json[2000] = "{" ASSET ",\"extensionsUsed\":[";
    for (uint32_t i = 0; i < COUNT_OF(names); i++) {
        const size_t at = strlen(json);
        snprintf(json + at, sizeof json - at, "%s\"%s\"", i ? "," : "", names[i]);
    }
    strcat(json, "]}");
    fnl_scene *scene = load(json, NULL, 0);
    for (uint32_t i = 0; i < COUNT_OF(names); i++) {
        fnl_extension_info info;
        assert_int_equal(fnl_scene_query_extension(scene, i, &info), FNL_OK);
        assert_string_equal(info.name, names[i]);
        /* A build without libdraco says so. */
        if (strcmp(info.treatment, "full") != 0 && !(i == 1 && strstr(info.treatment, "built without libdraco"))) fail_msg("%s is %s", names[i], info.treatment);
    }
    fnl_scene_destroy(&scene);
}

/* ---- KHR_materials_variants ---- */

#define TRIANGLE                                                                                                            \
    "\"buffers\":[{\"byteLength\":36}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],\"accessors\":[{\"bufferView\":0,"  \
    "\"componentType\":5126,\"type\":\"VEC3\",\"count\":3,\"min\":[0,0,0],\"max\":[1,1,0]}]"
#define PRIMITIVE(material, mappings)                                                                                       \
    "{" material "\"attributes\":{\"POSITION\":0},\"extensions\":{\"KHR_materials_variants\":{\"mappings\":[" mappings "]}}}"
static const vec3 triangle[3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};

/* Three primitives: one that two variants change, one without a material of its own that the third changes, and one that none does. */
static const char colours[] =
    "{" ASSET ",\"extensionsUsed\":[\"KHR_materials_variants\"],\"extensionsRequired\":[\"KHR_materials_variants\"],"
    "\"extensions\":{\"KHR_materials_variants\":{\"variants\":[{\"name\":\"red\"},{\"name\":\"crimson\",\"extras\":{\"id\":4}},{\"name\":\"dusk\"}]}},"
    "\"materials\":[{\"name\":\"plain\"},{\"name\":\"red\"},{\"name\":\"dark\"}]," TRIANGLE ",\"meshes\":[{\"primitives\":["
    PRIMITIVE("\"material\":0,", "{\"material\":1,\"variants\":[0,1]},{\"material\":2,\"variants\":[2],\"name\":\"night\"}") ","
    PRIMITIVE("", "{\"material\":2,\"variants\":[2]}") "]},"
    "{\"primitives\":[{\"material\":1,\"attributes\":{\"POSITION\":0}}]}],\"nodes\":[{\"mesh\":0},{\"mesh\":1}]}";

static void expect_materials(const fnl_scene *scene, uint32_t first, uint32_t offset, const uint32_t materials[3]) {
    for (uint32_t i = 0; i < 3; i++)
        assert_int_equal(scene->primitives.data[first + i].material, materials[i] == SCENE_NONE ? SCENE_NONE : materials[i] + offset);
}

enum { VARIANTS = 3 };
static const uint32_t standard[3] = {0, SCENE_NONE, 1}, by_variant[VARIANTS][3] = {{1, SCENE_NONE, 1}, {1, SCENE_NONE, 1}, {2, 2, 1}};

static void test_variants_change_materials(void **state) {
    UNUSED(state);
    fnl_scene *scene = load_clean(colours, triangle, sizeof triangle);
    fnl_entity_info entity;
    fnl_scene_info info;
    fnl_extension_info extension;
    uint32_t index;
    assert_int_equal(fnl_scene_query_extension(scene, 0, &extension), FNL_OK);
    assert_string_equal(extension.treatment, "full");
    assert_int_equal(fnl_scene_query_info(scene, &info), FNL_OK);
    assert_int_equal(info.variant_count, VARIANTS);
    assert_int_equal(fnl_scene_count(scene, FNL_ENTITY_VARIANT), VARIANTS);
    assert_int_equal(fnl_scene_find(scene, FNL_ENTITY_VARIANT, "crimson", &index), FNL_OK);
    assert_int_equal(index, 1);
    assert_int_equal(fnl_scene_query_entity(scene, FNL_ENTITY_VARIANT, 1, &entity), FNL_OK);
    assert_string_equal(entity.extras, "{\"id\":4}");
    assert_int_equal(fnl_scene_find(scene, FNL_ENTITY_VARIANT, "blue", &index), FNL_ERROR_INVALID);
    assert_non_null(strstr(file_log.text, "there is no 'blue' among the 3 variants: 'red', 'crimson', 'dusk'"));

    /* From each to each, and back to none: renderers hear of it where something changes, and of no shapes. */
    expect_materials(scene, 0, 0, standard);
    for (uint32_t from = 0; from < VARIANTS; from++)
        for (uint32_t to = 0; to <= VARIANTS; to++) {
            const uint32_t *expected = to == VARIANTS ? standard : by_variant[to];
            assert_int_equal(fnl_scene_select_variant(scene, from), FNL_OK);
            expect_materials(scene, 0, 0, by_variant[from]);
            const uint64_t before = scene->structure_version, materials = scene->material_version;
            assert_int_equal(fnl_scene_select_variant(scene, to == VARIANTS ? FNL_NO_VARIANT : to), FNL_OK);
            expect_materials(scene, 0, 0, expected);
            const bool changes = memcmp(expected, by_variant[from], sizeof standard) != 0;
            assert_int_equal(scene->structure_version > before, changes);
            if (changes) assert_int_equal(scene->edited_since, scene->structure_version);
            assert_int_equal(scene->material_version, materials);
            for (uint32_t i = 0; i < 3; i++) assert_int_equal(scene->primitives.data[i].version, 0);
        }
    assert_int_equal(fnl_scene_select_variant(scene, VARIANTS), FNL_ERROR_INVALID);
    expect_materials(scene, 0, 0, standard);

    /* What else was set goes, but where no variant says anything. */
    const fnl_material_id dark = {2, 1};
    for (uint32_t mesh = 0; mesh < 2; mesh++) {
        fnl_mesh_info shown;
        assert_int_equal(fnl_scene_query_mesh(scene, mesh, 0, &shown), FNL_OK);
        shown.params.material = dark;
        assert_int_equal(fnl_scene_set_mesh(scene, (fnl_mesh_id){mesh, 1}, 0, &shown.params), FNL_OK);
    }
    expect_materials(scene, 0, 0, (const uint32_t[]){2, SCENE_NONE, 2});
    assert_int_equal(fnl_scene_select_variant(scene, FNL_NO_VARIANT), FNL_OK);
    expect_materials(scene, 0, 0, (const uint32_t[]){0, SCENE_NONE, 2});
    fnl_scene_destroy(&scene);
}

/* In one scene each file has its own variants. */
static void test_variants_of_two_files(void **state) {
    UNUSED(state);
    fnl_scene *scene = load_clean(colours, triangle, sizeof triangle);
    size_t size;
    unsigned char *glb = test_glb(colours, triangle, sizeof triangle, &size);
    fnl_load_params params = fnl_load_params_default();
    params.data = glb;
    params.size = size;
    fnl_loaded loaded;
    assert_int_equal(fnl_scene_load_into(scene, (fnl_instance_id){0, 0}, "b.glb", &params, &loaded), FNL_OK);
    free(glb);
    const uint32_t b = loaded.first[FNL_ENTITY_VARIANT], offset = loaded.first[FNL_ENTITY_MATERIAL];
    assert_int_equal(b, VARIANTS);
    assert_int_equal(loaded.count[FNL_ENTITY_VARIANT], VARIANTS);
    assert_int_equal(fnl_scene_select_variant(scene, b + 2), FNL_OK);
    expect_materials(scene, 0, 0, standard);
    expect_materials(scene, 3, offset, by_variant[2]);
    assert_int_equal(fnl_scene_select_variant(scene, 0), FNL_OK);
    expect_materials(scene, 0, 0, by_variant[0]);
    expect_materials(scene, 3, offset, by_variant[2]);
    assert_int_equal(fnl_scene_select_variant(scene, FNL_NO_VARIANT), FNL_OK);
    expect_materials(scene, 0, 0, standard);
    expect_materials(scene, 3, offset, standard);
    fnl_scene_destroy(&scene);
}

static void test_broken_variants(void **state) {
    UNUSED(state);
#define MAPPINGS "/meshes/0/primitives/0/extensions/KHR_materials_variants/mappings"
    fnl_scene *scene = load(
        "{" ASSET ",\"extensionsUsed\":[\"KHR_materials_variants\"],\"extensions\":{\"KHR_materials_variants\":{\"variants\":["
        "{\"name\":\"a\"},{},{\"name\":\"a\"},7,{\"name\":\"b\"}]}},\"materials\":[{},{}]," TRIANGLE ",\"meshes\":[{\"primitives\":["
        PRIMITIVE("\"material\":0,", "{\"material\":1,\"variants\":[0,5,0]},{\"material\":2,\"variants\":[1]},{\"variants\":[1]},{\"material\":0},"
                                     "{\"material\":0,\"variants\":[]},{\"material\":0,\"variants\":[\"b\",0,4]},3,"
                                     "{\"material\":1,\"variants\":[2,-1]}") "]},"
        "{\"primitives\":[" PRIMITIVE("", "") "]}],\"nodes\":[{\"mesh\":0}]}",
        triangle, sizeof triangle);
    static const char *const lines[] = {
        "/extensions/KHR_materials_variants/variants/1: has no name; only its number, 1, selects it",
        "/extensions/KHR_materials_variants/variants/2/name: 'a' is the name of variant 0 too; only its number, 2, selects it",
        "/extensions/KHR_materials_variants/variants/3: is a number, not an object",
        MAPPINGS "/0/variants/1: refers to number 5, but there are 5",
        MAPPINGS "/0/variants/2: variant 0 has its material already; this one is ignored",
        MAPPINGS "/1/material: refers to number 2, but there are 2",
        MAPPINGS "/2: has no 'material'",
        MAPPINGS "/3: has no 'variants'",
        MAPPINGS "/4/variants: is empty",
        MAPPINGS "/5/variants/0: is not an index",
        MAPPINGS "/5/variants/1: variant 0 has its material already",
        MAPPINGS "/6: is a number, not an object",
        MAPPINGS "/7/variants/1: is not an index",
        "/meshes/1/primitives/0/extensions/KHR_materials_variants/mappings: is empty",
    };
    expect_lines(lines, COUNT_OF(lines));
    const uint32_t expected[] = {1, 0, 1, 0, 0};
    assert_int_equal(scene->variants.count, COUNT_OF(expected));
    for (uint32_t i = 0; i < COUNT_OF(expected); i++) {
        assert_int_equal(fnl_scene_select_variant(scene, i), FNL_OK);
        assert_int_equal(scene->primitives.data[0].material, expected[i]);
    }
    fnl_scene_destroy(&scene);

    scene = load("{" ASSET ",\"extensionsUsed\":[\"KHR_materials_variants\"],\"materials\":[{}]," TRIANGLE
                 ",\"meshes\":[{\"primitives\":[" PRIMITIVE("", "{\"material\":0,\"variants\":[0]}") "]}]}",
                 triangle, sizeof triangle);
    static const char *const missing[] = {MAPPINGS "/0: the file has no /extensions/KHR_materials_variants; all mappings are ignored"};
    expect_lines(missing, COUNT_OF(missing));
    assert_int_equal(scene->primitives.data[0].mapping_count, 0);
    fnl_scene_destroy(&scene);
}

/* A variant's textures want coordinates, and its normal texture tangents. */
static void test_variants_want_coordinates(void **state) {
    UNUSED(state);
    static const struct {
        vec3 positions[3];
        vec2 uv1[3], uv0[3]; /* along y, along x */
    } binary = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 0}, {0, 1}, {1, 0}}, {{0, 0}, {1, 0}, {0, 1}}};
    static const char form[] =
        "{" ASSET ",\"extensionsUsed\":[\"KHR_materials_variants\"],\"extensions\":{\"KHR_materials_variants\":{\"variants\":[{\"name\":\"a\"}]}},"
        "\"images\":[{\"uri\":\"data:image/png;base64," TEST_PNG_BASE64 "\"}],\"textures\":[{\"source\":0}],"
        "\"materials\":[%s,{\"normalTexture\":{\"index\":0,\"texCoord\":1}%s}],"
        "\"buffers\":[{\"byteLength\":84}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":36},{\"buffer\":0,\"byteOffset\":36,\"byteLength\":24},"
        "{\"buffer\":0,\"byteOffset\":60,\"byteLength\":24}],"
        "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC3\",\"count\":3,\"min\":[0,0,0],\"max\":[1,1,0]},"
        "{\"bufferView\":1,\"componentType\":5126,\"type\":\"VEC2\",\"count\":3},"
        "{\"bufferView\":2,\"componentType\":5126,\"type\":\"VEC2\",\"count\":3}],\"meshes\":[{\"primitives\":[{\"material\":0,\"attributes\":{"
        "\"POSITION\":0,%s\"TEXCOORD_1\":1},\"extensions\":{\"KHR_materials_variants\":{\"mappings\":[{\"material\":1,\"variants\":[0]}]}}}]}]}";
    static const struct {
        const char *own, *base, *uv0, *line;
        bool second;
    } cases[] = {
        {"{}", "", "\"TEXCOORD_0\":2,", NULL, true},
        {"{\"normalTexture\":{\"index\":0}}", "", "\"TEXCOORD_0\":2,",
         MAPPINGS ": the normal texture of material 1 wants tangents by TEXCOORD_1; those by TEXCOORD_0 are used", false},
        {"{}", ",\"emissiveTexture\":{\"index\":0}", "", MAPPINGS ": the textures of material 1 want TEXCOORD_0, which the primitive lacks", true},
    };
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        char json[2048];
        snprintf(json, sizeof json, form, cases[i].own, cases[i].base, cases[i].uv0);
        fnl_scene *scene = load(json, &binary, sizeof binary);
        /* warnings of the file's sets that do not follow one another are not of interest here */
        if (cases[i].line && !strstr(file_log.text, cases[i].line)) fail_msg("no '%s' in:\n%s", cases[i].line, file_log.text);
        if (!cases[i].line && strstr(file_log.text, "material")) fail_msg("%s", file_log.text);
        const vec4 tangent = scene->primitives.data[0].tangents[0];
        assert_true((cases[i].second ? tangent.y : tangent.x) > 0.999f);
        fnl_scene_destroy(&scene);
    }
}

/* ---- EXT_lights_image_based ---- */

enum { FACES = 6, SIDE = 16 };

/* Faces of one PNG after the other, as a GLB's binary. Each has a colour, in sRGB bytes, and its upper left quarter a fifth of the alpha; one texel is a lamp. */
struct faces {
    unsigned char bytes[1 << 14];
    size_t size, offsets[FACES], sizes[FACES];
};
static const uint8_t face_colors[FACES][3] = {{200, 0, 0}, {0, 200, 0}, {0, 0, 200}, {200, 200, 0}, {0, 200, 200}, {200, 0, 200}};

static struct faces make_faces(uint32_t odd_side) {
    struct faces out = {.size = 0};
    char path[64];
    snprintf(path, sizeof path, "/tmp/fanal-faces-%d.png", (int)getpid());
    fnl_host host = test_host(&file_log);
    for (uint32_t f = 0; f < FACES; f++) {
        static uint8_t pixels[4 * 4 * SIDE * SIDE];
        const uint32_t side = f == 4 ? odd_side : SIDE;
        for (uint32_t i = 0; i < side * side; i++) {
            memcpy(pixels + 4 * i, face_colors[f], 3);
            pixels[4 * i + 3] = i % side < side / 2 && i / side < side / 2 ? 51 : 255;
        }
        if (f == 1) pixels[4 * (14 * side + 8) + 3] = 1;
        struct file_view file;
        assert_int_equal(fnl_image_save(&host, path, &(fnl_image){side, side, FNL_PIXEL_FORMAT_RGBA8, pixels}), FNL_OK);
        assert_int_equal(file_load(&host, path, &file), FNL_OK);
        out.offsets[f] = out.size;
        out.sizes[f] = file.size;
        assert_true(out.size + file.size + 3 < sizeof out.bytes);
        memcpy(out.bytes + out.size, file.data, file.size);
        out.size += align_up(file.size, 4);
        file_free(&host, &file);
    }
    unlink(path);
    return out;
}

#define COEFFICIENTS "[[1,1,1],[0,0,0],[0,0,0],[0,0,0],[0,0,0],[0,0,0],[0,0,0],[0,0,0],[0,0,0]]"

#define SHOWS_LIGHT "\"extensions\":{\"EXT_lights_image_based\":{\"light\":0}}"

static char json[8192]; /* of the last that was loaded */
static const char *more_views = "", *more = ""; /* in such files: buffer views, and members of the file with a comma before them */

/* `scene` "": the light is of the scene that is not shown. */
static fnl_scene *load_faces(const struct faces *faces, const char *light, const char *scene) {
    int n = snprintf(json, sizeof json, "{" ASSET ",\"extensionsUsed\":[%s\"EXT_lights_image_based\"],\"extensions\":{\"EXT_lights_image_based\":{\"lights\":[{%s}]}},"
                                        "\"buffers\":[{\"byteLength\":%zu}],\"bufferViews\":[", *more ? "\"KHR_animation_pointer\"," : "", light, faces->size);
    for (uint32_t f = 0; f < FACES; f++)
        n += snprintf(json + n, sizeof json - (size_t)n, "%s{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu}", f ? "," : "", faces->offsets[f], faces->sizes[f]);
    n += snprintf(json + n, sizeof json - (size_t)n, "%s],\"images\":[", more_views);
    for (uint32_t f = 0; f < FACES; f++) n += snprintf(json + n, sizeof json - (size_t)n, "%s{\"bufferView\":%u,\"mimeType\":\"image/png\"}", f ? "," : "", f);
    snprintf(json + n, sizeof json - (size_t)n, "],\"scenes\":[{%s},{%s}],\"scene\":1%s}", *scene ? "" : SHOWS_LIGHT, scene, more);
    return load(json, faces->bytes, faces->size);
}

/* Where each image's first texel is, by the tables of Vulkan and OpenGL. */
static const vec3 first_texels[FACES] = {{1, 1, 1}, {-1, 1, -1}, {-1, 1, -1}, {-1, -1, 1}, {-1, 1, 1}, {1, 1, -1}};

static void expect_environment(const fnl_scene *scene, quat rotation) {
    const struct panorama *p = &scene->environment.panorama;
    assert_int_equal(p->width, 4 * SIDE);
    assert_int_equal(p->height, 2 * SIDE);
    const mat4 turn = mat4_from_trs(vec3_make(0, 0, 0), rotation, vec3_make(1, 1, 1));
    vec3 rows[3];
    scene_environment_axes(&scene->environment, rows);
    const float level = powf((200 / 255.0f + 0.055f) / 1.055f, 2.4f);
    for (uint32_t f = 0; f < FACES; f++)
        for (int away = 0; away < 2; away++) { /* in the upper left quarter, and opposite */
            float d[3] = {first_texels[f].x, first_texels[f].y, first_texels[f].z};
            for (uint32_t c = 0; c < 3; c++)
                if (c != f / 2) d[c] *= away ? -0.4f : 0.4f;
            const vec3 direction = mat4_direction(&turn, vec3_normalize(vec3_make(d[0], d[1], d[2])));
            float x, y;
            panorama_place(p, vec3_make(vec3_dot(rows[0], direction), vec3_dot(rows[1], direction), vec3_dot(rows[2], direction)), &x, &y);
            const uint32_t column = (uint32_t)(lroundf(x) + (long)p->width) % p->width, row = (uint32_t)CLAMP(lroundf(y), 0, (long)p->height - 1);
            for (uint32_t c = 0; c < 3; c++) {
                const float expected = face_colors[f][c] ? level * (away ? 1 : 5) : 0;
                assert_true(fabsf(p->texels[3 * ((size_t)row * p->width + column) + c] - expected) < 1e-4f * expected + 1e-6f);
            }
        }
}

static vec3 sun_of(const fnl_scene *scene) {
    fnl_light_params light;
    assert_int_equal(fnl_scene_query_light(scene, 0, &light), FNL_OK);
    return light.direction;
}

static void test_environments_of_files(void **state) {
    UNUSED(state);
    const struct faces faces = make_faces(SIDE);
    static const quat rotations[] = {{0, 0, 0, 1}, {0, 0.70710678f, 0, 0.70710678f}, {0.70710678f, 0, 0, 0.70710678f}, {0.5f, 0.5f, 0.5f, 0.5f}};
    for (uint32_t i = 0; i < COUNT_OF(rotations); i++) {
        char light[512];
        snprintf(light, sizeof light, "\"intensity\":2.5,\"rotation\":[%.8g,%.8g,%.8g,%.8g],\"irradianceCoefficients\":" COEFFICIENTS
                 ",\"specularImageSize\":16,\"specularImages\":[[0,1,2,3,4,5]]", (double)rotations[i].x, (double)rotations[i].y, (double)rotations[i].z,
                 (double)rotations[i].w);
        fnl_scene *scene = load_faces(&faces, light, SHOWS_LIGHT);
        if (file_log.count) fail_msg("%s", file_log.text);
        fnl_scene_info info;
        assert_int_equal(fnl_scene_query_info(scene, &info), FNL_OK);
        assert_true(info.has_environment && scene_environment_scale(&scene->environment) == 2.5f && scene->environment.background);
        expect_environment(scene, rotations[i]);
        const vec3 sun = sun_of(scene);
        fnl_environment_params params = fnl_environment_params_default(); /* on top of the file's */
        params.rotation = 0.7f;
        params.intensity = 3;
        params.background = false;
        assert_int_equal(fnl_scene_set_environment(scene, &params), FNL_OK);
        assert_true(fabsf(scene_environment_scale(&scene->environment) - 7.5f) < 1e-5f && !scene->environment.background);
        const quat turn = quat_axis_angle(vec3_make(0, 1, 0), 0.7f);
        expect_environment(scene, quat_mul(turn, rotations[i]));
        const mat4 turned = mat4_from_trs(vec3_make(0, 0, 0), turn, vec3_make(1, 1, 1));
        assert_true(vec3_distance(sun_of(scene), vec3_scale(mat4_direction(&turned, sun), 1)) < 1e-5f);
        assert_int_equal(fnl_scene_count(scene, FNL_ENTITY_LIGHT), 1);
        params.source = "builtin:overcast"; /* nothing of the file's stays with another picture */
        assert_int_equal(fnl_scene_set_environment(scene, &params), FNL_OK);
        assert_true(scene_environment_scale(&scene->environment) == 3 && scene->environment.own.rotation.w == 1);
        fnl_scene_destroy(&scene);
        scene = load_faces(&faces, light, ""); /* the light of no scene that is shown */
        assert_int_equal(fnl_scene_query_info(scene, &info), FNL_OK);
        assert_true(!info.has_environment && file_log.count == 0);
        fnl_scene_destroy(&scene);
    }
}

/* Intensity and rotation follow KHR_animation_pointer, and so does the light that was parted off; below what a call says. */
static void test_environments_are_animated(void **state) {
    UNUSED(state);
    static const float data[] = {0, 2, /* times */ 1, 3, /* intensities */ 0, 0, 0, 1, 0, 0.70710678f, 0, 0.70710678f};
    static const char light[] = "\"intensity\":5,\"rotation\":[0,1,0,0],\"irradianceCoefficients\":" COEFFICIENTS ",\"specularImageSize\":16,\"specularImages\":[[0,1,2,3,4,5]]";
#define POINTS_TO(sampler, pointer) \
    "{\"sampler\":" #sampler ",\"target\":{\"path\":\"pointer\",\"extensions\":{\"KHR_animation_pointer\":{\"pointer\":\"/extensions/EXT_lights_image_based/lights/" pointer "\"}}}}"
    struct faces faces = make_faces(SIDE);
    char views[160];
    snprintf(views, sizeof views, ",{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu}", faces.size, sizeof data);
    memcpy(faces.bytes + faces.size, data, sizeof data);
    faces.size += sizeof data;
    more_views = views;
    more = ",\"accessors\":[{\"bufferView\":6,\"componentType\":5126,\"type\":\"SCALAR\",\"count\":2,\"min\":[0],\"max\":[2]},"
           "{\"bufferView\":6,\"byteOffset\":8,\"componentType\":5126,\"type\":\"SCALAR\",\"count\":2},"
           "{\"bufferView\":6,\"byteOffset\":16,\"componentType\":5126,\"type\":\"VEC4\",\"count\":2}],"
           "\"animations\":[{\"samplers\":[{\"input\":0,\"output\":1},{\"input\":0,\"output\":2}],\"channels\":[" POINTS_TO(0, "0/intensity") "," POINTS_TO(1, "0/rotation") "]}]";
    fnl_scene *scene = load_faces(&faces, light, SHOWS_LIGHT);
    if (strstr(file_log.text, "nimat")) fail_msg("%s", file_log.text);
    assert_true(scene_environment_scale(&scene->environment) == 5); /* at rest the file's */
    fnl_environment_params params = fnl_environment_params_default();
    params.intensity = 10;
    assert_int_equal(fnl_scene_set_environment(scene, &params), FNL_OK);
    const uint64_t version = scene->environment.version;
    const vec3 rest = sun_of(scene);
    for (int i = 0; i < 3; i++) { /* 0, 45 and 90 degrees; the sun was at 180 */
        assert_int_equal(fnl_scene_set_time(scene, 0, i), FNL_OK);
        assert_true(fabsf(scene_environment_scale(&scene->environment) - 10 * (1 + (float)i)) < 1e-4f);
        expect_environment(scene, quat_axis_angle(vec3_make(0, 1, 0), (float)i * PI / 4));
        const mat4 turn = mat4_from_trs(vec3_make(0, 0, 0), quat_axis_angle(vec3_make(0, 1, 0), (float)i * PI / 4 - PI), vec3_make(1, 1, 1));
        assert_true(vec3_distance(sun_of(scene), mat4_direction(&turn, rest)) < 1e-5f);
        fnl_light_params sun;
        assert_int_equal(fnl_scene_query_light(scene, 0, &sun), FNL_OK);
        const vec3 *from = &scene->environment.sources[0].illuminance;
        assert_true(fabsf(sun.intensity / (10 * (1 + (float)i) * fmaxf(from->x, fmaxf(from->y, from->z))) - 1) < 1e-5f);
    }
    assert_true(scene->environment.version == version); /* maps are not made anew */
    params.source = "builtin:overcast"; /* another environment is not the file's to move */
    assert_int_equal(fnl_scene_set_environment(scene, &params), FNL_OK);
    assert_int_equal(fnl_scene_set_time(scene, 0, 1), FNL_OK);
    assert_true(scene_environment_scale(&scene->environment) == 10);
    fnl_scene_destroy(&scene);
    more = ",\"accessors\":[{\"bufferView\":6,\"componentType\":5126,\"type\":\"SCALAR\",\"count\":2,\"min\":[0],\"max\":[2]}],"
           "\"animations\":[{\"samplers\":[{\"input\":0,\"output\":0}],\"channels\":[" POINTS_TO(0, "1/intensity") "," POINTS_TO(0, "0/name") "]}]";
    scene = load_faces(&faces, light, SHOWS_LIGHT);
    if (!strstr(file_log.text, "lights/1/intensity' names nothing that the file has") || !strstr(file_log.text, "lights/0/name' names nothing that can be animated"))
        fail_msg("%s", file_log.text);
    fnl_scene_destroy(&scene);
    more_views = more = "";
}

/* In another scene a file brings no surroundings, nor lights that were parted off. */
static void test_environments_stay_with_their_files(void **state) {
    UNUSED(state);
    static const char light[] = "\"irradianceCoefficients\":" COEFFICIENTS ",\"specularImageSize\":16,\"specularImages\":[[0,1,2,3,4,5]]";
    struct faces faces = make_faces(SIDE);
    fnl_scene *scene = load_faces(&faces, light, SHOWS_LIGHT);
    const fnl_light_params sun = fnl_light_params_default();
    assert_int_equal(fnl_scene_count(scene, FNL_ENTITY_LIGHT), 1);
    size_t size;
    unsigned char *glb = test_glb(json, faces.bytes, faces.size, &size);
    fnl_load_params params = fnl_load_params_default();
    params.data = glb;
    params.size = size;
    fnl_scene *other;
    fnl_light_id id;
    fnl_loaded loaded;
    fnl_host host = test_host(&file_log);
    assert_int_equal(fnl_scene_create(&host, &other), FNL_OK);
    assert_int_equal(fnl_scene_add_light(other, &sun, &id), FNL_OK);
    assert_int_equal(fnl_scene_load_into(other, (fnl_instance_id){0, 0}, "b.glb", &params, &loaded), FNL_OK);
    assert_int_equal(other->environment.panorama.width, 0);
    assert_int_equal(fnl_scene_count(other, FNL_ENTITY_LIGHT), 1);
    fnl_scene_destroy(&other);
    assert_int_equal(fnl_scene_create(&host, &other), FNL_OK);
    fnl_environment_params environment = fnl_environment_params_default(), found;
    environment.source = "builtin:overcast";
    environment.rotation = 0.5f;
    environment.background = false;
    assert_int_equal(fnl_scene_set_environment(scene, &environment), FNL_OK);
    assert_int_equal(fnl_scene_query_environment(scene, &found), FNL_OK);
    assert_string_equal(found.source, "builtin:overcast");
    assert_true(found.rotation == 0.5f && found.intensity == 1 && !found.background && found.lights && !found.image);
    assert_int_equal(fnl_scene_set_environment(scene, NULL), FNL_OK);
    assert_int_equal(fnl_scene_query_environment(scene, &found), FNL_ERROR_INVALID);
    assert_int_equal(scene_merge(other, SCENE_NONE, scene, &loaded), FNL_OK);
    assert_int_equal(fnl_scene_count(other, FNL_ENTITY_LIGHT), 0);
    assert_int_equal(loaded.count[FNL_ENTITY_LIGHT], 0);
    fnl_scene_destroy(&other);
    fnl_scene_destroy(&scene);
    free(glb);
}

static void test_broken_environments(void **state) {
    UNUSED(state);
#define LIGHT "/extensions/EXT_lights_image_based/lights/0"
#define FIT "\"irradianceCoefficients\":" COEFFICIENTS ",\"specularImageSize\":16,"
    static const struct {
        const char *light, *scene, *line;
        bool shown;
    } cases[] = {
        {FIT "\"specularImages\":[[0,1,2,3,4]]", SHOWS_LIGHT, LIGHT "/specularImages/0: is not an array of six images", false},
        {FIT "\"specularImages\":[[0,1,2,3,4,6]]", SHOWS_LIGHT, LIGHT "/specularImages/0/5: refers to number 6, but there are 6", false},
        {FIT "\"specularImages\":[]", SHOWS_LIGHT, LIGHT "/specularImages: is empty", false},
        {FIT "\"name\":\"a\"", SHOWS_LIGHT, LIGHT ": has no 'specularImages'", false},
        {"\"specularImageSize\":16,\"specularImages\":[[0,1,2,3,4,5]]", SHOWS_LIGHT, LIGHT ": has no 'irradianceCoefficients'", true},
        {"\"irradianceCoefficients\":[[1,1,1]],\"specularImageSize\":16,\"specularImages\":[[0,1,2,3,4,5]]", SHOWS_LIGHT,
         LIGHT "/irradianceCoefficients: are not 9 by 3 numbers", true},
        {"\"irradianceCoefficients\":" COEFFICIENTS ",\"specularImageSize\":32,\"specularImages\":[[0,1,2,3,4,5]]", SHOWS_LIGHT,
         LIGHT "/specularImageSize: is 32, but the images have 16 pixels", true},
        {FIT "\"rotation\":[0,0.5,0,0],\"specularImages\":[[0,1,2,3,4,5]]", SHOWS_LIGHT, LIGHT "/rotation: is not of unit length", true},
        {FIT "\"specularImages\":[[0,1,2,3,4,5]]", "\"extensions\":{\"EXT_lights_image_based\":{\"light\":1}}",
         "/scenes/1/extensions/EXT_lights_image_based/light: refers to number 1, but there are 1", false},
        {FIT "\"specularImages\":[[0,1,2,3,4,5]]", "\"extensions\":{\"EXT_lights_image_based\":{}}",
         "/scenes/1/extensions/EXT_lights_image_based: has no 'light'", false},
    };
    struct faces faces = make_faces(SIDE);
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        fnl_scene *scene = load_faces(&faces, cases[i].light, cases[i].scene);
        expect_lines(&cases[i].line, 1);
        assert_int_equal(scene->environment.panorama.width > 0, cases[i].shown);
        fnl_scene_destroy(&scene);
    }
    faces.bytes[faces.offsets[2] + faces.sizes[2] / 2] ^= 255;
    fnl_scene *scene = load_faces(&faces, cases[4].light, SHOWS_LIGHT);
    if (!strstr(file_log.text, LIGHT "/specularImages/0/2: ") || scene->environment.panorama.width) fail_msg("%s", file_log.text);
    fnl_scene_destroy(&scene);
    faces = make_faces(2 * SIDE);
    scene = load_faces(&faces, cases[4].light, SHOWS_LIGHT);
    if (!strstr(file_log.text, LIGHT "/specularImages/0/4: image 4 has not the size of the others") || scene->environment.panorama.width) fail_msg("%s", file_log.text);
    fnl_scene_destroy(&scene);
}

/* ---- KHR_xmp_json_ld ---- */

static fnl_entity_info metadata(const fnl_scene *scene, uint32_t index) {
    fnl_entity_info info;
    assert_int_equal(fnl_scene_query_entity(scene, FNL_ENTITY_METADATA, index, &info), FNL_OK);
    return info;
}

#define XMP(packet) "\"extensions\":{\"KHR_xmp_json_ld\":{\"packet\":" packet "}}"

static void test_metadata_is_kept(void **state) {
    UNUSED(state);
    /* A packet is no glTF: what is called extensions in it says nothing. */
    static const char told[] =
        "{\"asset\":{\"version\":\"2.0\"," XMP("1") "},\"extensionsUsed\":[\"KHR_xmp_json_ld\"],\"extensionsRequired\":[\"KHR_xmp_json_ld\"],"
        "\"extensions\":{\"KHR_xmp_json_ld\":{\"packets\":[{\"@context\":{\"dc\":\"http://purl.org/dc/elements/1.1/\"},\"dc:title\":\"a\"},"
        "{\"@context\":{},\"extensions\":{\"x\":1}},{\"@context\":{}}]}},"
        "\"materials\":[{},{" XMP("0") "}],\"images\":[{\"uri\":\"data:image/png;base64," TEST_PNG_BASE64 "\"," XMP("0") "}],"
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]," XMP("0") "}],\"nodes\":[{},{" XMP("1") "}],"
        "\"scenes\":[{" XMP("0") "}]," TRIANGLE "}";
    fnl_scene *scene = load_clean(told, triangle, sizeof triangle);
    static const struct {
        const char *about, *text;
    } expected[] = {{"/scenes/0 /meshes/0 /materials/1 /images/0", "{\"@context\":{\"dc\":\"http://purl.org/dc/elements/1.1/\"},\"dc:title\":\"a\"}"},
                    {"/asset /nodes/1", "{\"@context\":{},\"extensions\":{\"x\":1}}"},
                    {"", "{\"@context\":{}}"}};
    assert_int_equal(fnl_scene_count(scene, FNL_ENTITY_METADATA), COUNT_OF(expected));
    for (uint32_t i = 0; i < COUNT_OF(expected); i++) {
        assert_string_equal(metadata(scene, i).name, expected[i].about);
        assert_string_equal(metadata(scene, i).extras, expected[i].text);
    }
    size_t size;
    unsigned char *glb = test_glb(told, triangle, sizeof triangle, &size);
    fnl_load_params params = fnl_load_params_default();
    params.data = glb;
    params.size = size;
    assert_int_equal(fnl_scene_load_into(scene, (fnl_instance_id){0, 0}, "b.glb", &params, NULL), FNL_OK);
    free(glb);
    assert_int_equal(fnl_scene_count(scene, FNL_ENTITY_METADATA), 2 * COUNT_OF(expected));
    assert_string_equal(metadata(scene, 4).name, expected[1].about);
    fnl_scene_destroy(&scene);
}

static void test_broken_metadata(void **state) {
    UNUSED(state);
    fnl_scene *scene = load("{\"asset\":{\"version\":\"2.0\"," XMP("4") "},\"extensionsUsed\":[\"KHR_xmp_json_ld\"],"
                            "\"extensions\":{\"KHR_xmp_json_ld\":{\"packets\":[{\"dc:title\":\"a\"},7]}},"
                            "\"nodes\":[{\"extensions\":{\"KHR_xmp_json_ld\":{}}},{" XMP("1") "}],\"cameras\":[{" XMP("0") ",\"type\":\"orthographic\","
                            "\"orthographic\":{\"xmag\":1,\"ymag\":1,\"znear\":0,\"zfar\":1}}]}",
                            NULL, 0);
    static const char *const lines[] = {
        "/extensions/KHR_xmp_json_ld/packets/0: has no '@context', so is not JSON-LD; it is kept all the same",
        "/extensions/KHR_xmp_json_ld/packets/1: is a number, not an object",
        "/asset/extensions/KHR_xmp_json_ld/packet: refers to number 4, but there are 2",
        "/nodes/0/extensions/KHR_xmp_json_ld: has no 'packet'",
        "/cameras/0/extensions/KHR_xmp_json_ld: KHR_xmp_json_ld has no meaning here",
    };
    expect_lines(lines, COUNT_OF(lines));
    assert_string_equal(metadata(scene, 0).name, "");
    assert_string_equal(metadata(scene, 0).extras, "{\"dc:title\":\"a\"}");
    assert_null(metadata(scene, 1).extras);
    assert_string_equal(metadata(scene, 1).name, "/nodes/1");
    fnl_scene_destroy(&scene);
    scene = load("{\"asset\":{\"version\":\"2.0\"," XMP("0") "},\"extensionsUsed\":[\"KHR_xmp_json_ld\"]}", NULL, 0);
    static const char *const missing[] = {"/asset/extensions/KHR_xmp_json_ld: the file has no /extensions/KHR_xmp_json_ld; it is ignored"};
    expect_lines(missing, COUNT_OF(missing));
    fnl_scene_destroy(&scene);
}

/* ---- layers of materials ---- */

#define PIXEL                                                                                                               \
    "\"images\":[{\"uri\":\"data:image/png;base64,"                                                                          \
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAAC0lEQVR4nGP4DwQACfsD/fteaysAAAAASUVORK5CYII=\"}],"                     \
    "\"textures\":[{\"source\":0},{\"source\":0}],"
#define LAYERS                                                                                                              \
    "\"extensionsUsed\":[\"KHR_materials_clearcoat\",\"KHR_materials_sheen\",\"KHR_materials_iridescence\","              \
    "\"KHR_materials_anisotropy\",\"KHR_materials_transmission\",\"KHR_materials_volume\",\"KHR_materials_dispersion\"," \
    "\"KHR_materials_diffuse_transmission\",\"KHR_materials_unlit\"],"
#define TEXTURE(name, number) "\"" name "Texture\":{\"index\":0,\"texCoord\":" number "}"

static void test_layers_of_materials_MA_7(void **state) {
    UNUSED(state);
    fnl_scene *scene = load_clean(
        "{" ASSET "," LAYERS PIXEL "\"materials\":[{\"extensions\":{"
        "\"KHR_materials_clearcoat\":{\"clearcoatFactor\":0.5,\"clearcoatRoughnessFactor\":0.25," TEXTURE("clearcoat", "1") ","
        TEXTURE("clearcoatRoughness", "0") ",\"clearcoatNormalTexture\":{\"index\":1,\"scale\":0.75,\"texCoord\":1}},"
        "\"KHR_materials_sheen\":{\"sheenColorFactor\":[0.1,0.2,0.3],\"sheenRoughnessFactor\":0.4," TEXTURE("sheenColor", "1") ","
        TEXTURE("sheenRoughness", "0") "},"
        "\"KHR_materials_iridescence\":{\"iridescenceFactor\":0.6,\"iridescenceIor\":1.7,\"iridescenceThicknessMinimum\":50,"
        "\"iridescenceThicknessMaximum\":900," TEXTURE("iridescence", "1") "," TEXTURE("iridescenceThickness", "0") "},"
        "\"KHR_materials_anisotropy\":{\"anisotropyStrength\":0.8,\"anisotropyRotation\":2," TEXTURE("anisotropy", "1") "},"
        "\"KHR_materials_transmission\":{\"transmissionFactor\":0.7," TEXTURE("transmission", "1") "},"
        "\"KHR_materials_volume\":{\"thicknessFactor\":3,\"attenuationDistance\":2,\"attenuationColor\":[0.1,0.5,0.9]," TEXTURE("thickness", "0") "},"
        "\"KHR_materials_dispersion\":{\"dispersion\":0.6},"
        "\"KHR_materials_diffuse_transmission\":{\"diffuseTransmissionFactor\":0.35,\"diffuseTransmissionColorFactor\":[0.2,0.4,0.6],"
        TEXTURE("diffuseTransmission", "1") "," TEXTURE("diffuseTransmissionColor", "0") "}}},"
        "{\"extensions\":{\"KHR_materials_clearcoat\":{},\"KHR_materials_sheen\":{},\"KHR_materials_iridescence\":{},"
        "\"KHR_materials_anisotropy\":{},\"KHR_materials_transmission\":{},\"KHR_materials_volume\":{},\"KHR_materials_dispersion\":{},"
        "\"KHR_materials_diffuse_transmission\":{}}},"
        "{\"extensions\":{\"KHR_materials_iridescence\":{\"iridescenceFactor\":1},\"KHR_materials_unlit\":{}}}]}",
        NULL, 0);
    const struct scene_material *m = &scene->materials.data[0];
    assert_true(m->clearcoat.strength == 0.5f && m->clearcoat.roughness == 0.25f && m->clearcoat.normal_scale == 0.75f);
    assert_true(m->sheen.color[0] == 0.1f && m->sheen.color[2] == 0.3f && m->sheen.roughness == 0.4f);
    assert_true(m->iridescence.strength == 0.6f && m->iridescence.ior == 1.7f && m->iridescence.thickness_minimum == 50 &&
                m->iridescence.thickness_maximum == 900);
    assert_true(m->anisotropy.strength == 0.8f && m->anisotropy.rotation == 2);
    assert_true(m->transmission.strength == 0.7f && m->dispersion == 0.6f && scene_material_transmissive(m));
    assert_true(m->volume.thickness == 3 && m->volume.attenuation_distance == 2 && m->volume.attenuation_color[1] == 0.5f);
    assert_true(m->diffuse_transmission.strength == 0.35f && m->diffuse_transmission.color[2] == 0.6f);
    for (int slot = SCENE_TEXTURE_CORE_COUNT; slot < SCENE_TEXTURE_SLOT_COUNT; slot++) {
        const struct scene_texture *t = &m->textures[slot];
        const bool second = slot == SCENE_TEXTURE_CLEARCOAT || slot == SCENE_TEXTURE_CLEARCOAT_NORMAL || slot == SCENE_TEXTURE_SHEEN_COLOR ||
                            slot == SCENE_TEXTURE_IRIDESCENCE || slot == SCENE_TEXTURE_ANISOTROPY || slot == SCENE_TEXTURE_TRANSMISSION ||
                            slot == SCENE_TEXTURE_DIFFUSE_TRANSMISSION;
        if (t->image == SCENE_NONE || t->uv_set != second) fail_msg("slot %d: image %d, uv %u", slot, (int)t->image, t->uv_set);
        assert_true(scene->images.data[t->image].color == (slot == SCENE_TEXTURE_SHEEN_COLOR || slot == SCENE_TEXTURE_DIFFUSE_TRANSMISSION_COLOR));
    }
    assert_true(scene_material_layered(m));
    m = &scene->materials.data[1];
    assert_true(!scene_material_layered(m) && m->iridescence.ior == 1.3f && m->iridescence.thickness_minimum == 100 &&
                m->iridescence.thickness_maximum == 400 && m->clearcoat.normal_scale == 1);
    assert_true(!scene_material_transmissive(m) && m->volume.thickness == 0 && m->volume.attenuation_distance == INFINITY &&
                m->volume.attenuation_color[2] == 1 && m->diffuse_transmission.color[0] == 1);
    assert_false(scene_material_layered(&scene->materials.data[2])); /* unlit surfaces reflect nothing */
    fnl_scene_destroy(&scene);
    scene = load("{" ASSET "," LAYERS "\"materials\":[{\"extensions\":{\"KHR_materials_clearcoat\":{\"clearcoatFactor\":1.5},"
                 "\"KHR_materials_sheen\":{\"sheenColorFactor\":[0,0]},\"KHR_materials_iridescence\":{\"iridescenceIor\":0.5},"
                 "\"KHR_materials_transmission\":{\"transmissionFactor\":-1},\"KHR_materials_volume\":{\"attenuationDistance\":0,"
                 "\"thicknessFactor\":-2},\"KHR_materials_dispersion\":{\"dispersion\":\"x\"}}}]}",
                 NULL, 0);
    static const char *const lines[] = {"/KHR_materials_transmission/transmissionFactor", "/KHR_materials_volume/attenuationDistance",
                                        "/KHR_materials_volume/thicknessFactor", "/KHR_materials_dispersion/dispersion",
                                        "/materials/0/extensions/KHR_materials_clearcoat/clearcoatFactor", "/KHR_materials_sheen/sheenColorFactor",
                                        "/KHR_materials_iridescence/iridescenceIor"};
    expect_lines(lines, COUNT_OF(lines));
    fnl_scene_destroy(&scene);
}

/* By the API: what is set is told, zeros are the defaults, and what is out of range is refused by name. */
static void test_layers_by_the_api_MA_7(void **state) {
    UNUSED(state);
    const uint8_t white[4] = {255, 255, 255, 255};
    const fnl_image picture = {1, 1, FNL_PIXEL_FORMAT_RGBA8, (void *)(uintptr_t)white};
    fnl_scene *scene = load_clean("{" ASSET "}", NULL, 0);
    fnl_material_params p = fnl_material_params_default(), told;
    fnl_material_id id;
    fnl_image_id image;
    assert_int_equal(fnl_scene_add_image(scene, &picture, false, &image), FNL_OK);
    p.clearcoat = (fnl_clearcoat_params){.strength = 0.5f, .roughness = 0.1f, .normal_image = image};
    p.iridescence.strength = 0.4f;
    p.sheen = (fnl_sheen_params){.color = {0.5f, 0, 0}, .roughness_image = image};
    p.anisotropy = (fnl_anisotropy_params){.strength = 0.3f, .rotation = -1, .image = image};
    p.transmission = (fnl_transmission_params){.strength = 0.6f, .image = image};
    p.volume = (fnl_volume_params){.thickness = 2, .attenuation_color = {0.5f, 1, 1}};
    p.dispersion = 3;
    p.diffuse_transmission = (fnl_diffuse_transmission_params){.strength = 0.2f, .color = {0, 1, 0}, .color_image = image};
    assert_int_equal(fnl_scene_add_material(scene, &p, &id), FNL_OK);
    assert_int_equal(fnl_scene_query_material(scene, id.index, &told), FNL_OK);
    assert_true(told.transmission.strength == 0.6f && told.transmission.image.generation && told.volume.thickness == 2 &&
                told.volume.attenuation_distance == 0 && told.dispersion == 3 && told.diffuse_transmission.color[1] == 1 &&
                told.diffuse_transmission.color_image.generation);
    assert_true(told.clearcoat.strength == 0.5f && told.clearcoat.normal_scale == 1 && told.clearcoat.normal_image.index == image.index &&
                told.clearcoat.normal_image.generation && !told.clearcoat.image.generation);
    assert_true(told.iridescence.ior == 1.3f && told.iridescence.thickness_minimum == 100 && told.iridescence.thickness_maximum == 400);
    assert_true(told.sheen.color[0] == 0.5f && told.sheen.roughness_image.generation && told.anisotropy.rotation == -1);
    assert_int_equal(fnl_scene_set_material(scene, id, &told), FNL_OK);
    p = fnl_material_params_default();
    assert_int_equal(fnl_scene_set_material(scene, id, &p), FNL_OK);
    assert_int_equal(fnl_scene_query_material(scene, id.index, &told), FNL_OK);
    assert_true(told.clearcoat.strength == 0 && !told.clearcoat.normal_image.generation && told.sheen.color[0] == 0);
    const struct {
        const char *name;
        size_t offset;
        float value;
    } bad[] = {{"clearcoat.strength", offsetof(fnl_material_params, clearcoat.strength), 1.5f},
               {"clearcoat.roughness", offsetof(fnl_material_params, clearcoat.roughness), -1},
               {"clearcoat.normal_scale", offsetof(fnl_material_params, clearcoat.normal_scale), NAN},
               {"sheen.color", offsetof(fnl_material_params, sheen.color), 2},
               {"sheen.roughness", offsetof(fnl_material_params, sheen.roughness), NAN},
               {"iridescence.strength", offsetof(fnl_material_params, iridescence.strength), -0.1f},
               {"iridescence.ior", offsetof(fnl_material_params, iridescence.ior), 0.5f},
               {"iridescence.thickness_minimum", offsetof(fnl_material_params, iridescence.thickness_minimum), -1},
               {"iridescence.thickness_maximum", offsetof(fnl_material_params, iridescence.thickness_maximum), INFINITY},
               {"anisotropy.strength", offsetof(fnl_material_params, anisotropy.strength), 2},
               {"anisotropy.rotation", offsetof(fnl_material_params, anisotropy.rotation), NAN},
               {"transmission.strength", offsetof(fnl_material_params, transmission.strength), 1.1f},
               {"volume.thickness", offsetof(fnl_material_params, volume.thickness), -1},
               {"volume.attenuation_distance", offsetof(fnl_material_params, volume.attenuation_distance), -1},
               {"volume.attenuation_color", offsetof(fnl_material_params, volume.attenuation_color), 2},
               {"dispersion", offsetof(fnl_material_params, dispersion), NAN},
               {"diffuse_transmission.strength", offsetof(fnl_material_params, diffuse_transmission.strength), 7},
               {"diffuse_transmission.color", offsetof(fnl_material_params, diffuse_transmission.color), -1}};
    for (uint32_t i = 0; i < COUNT_OF(bad); i++) {
        p = fnl_material_params_default();
        memcpy((char *)&p + bad[i].offset, &bad[i].value, sizeof(float));
        file_log.count = 0;
        assert_int_equal(fnl_scene_set_material(scene, id, &p), FNL_ERROR_INVALID);
        if (!strstr(file_log.text, bad[i].name)) fail_msg("no %s in %s", bad[i].name, file_log.text);
    }
    p = fnl_material_params_default();
    p.anisotropy.image = (fnl_image_id){77, 1};
    assert_int_equal(fnl_scene_set_material(scene, id, &p), FNL_ERROR_INVALID);
    assert_non_null(strstr(file_log.text, "anisotropy.image"));
    fnl_scene_destroy(&scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_ratified_extensions_are_full),
        cmocka_unit_test(test_layers_of_materials_MA_7),
        cmocka_unit_test(test_layers_by_the_api_MA_7),
        cmocka_unit_test(test_variants_change_materials),
        cmocka_unit_test(test_variants_of_two_files),
        cmocka_unit_test(test_broken_variants),
        cmocka_unit_test(test_variants_want_coordinates),
        cmocka_unit_test(test_environments_of_files),
        cmocka_unit_test(test_environments_are_animated),
        cmocka_unit_test(test_environments_stay_with_their_files),
        cmocka_unit_test(test_broken_environments),
        cmocka_unit_test(test_metadata_is_kept),
        cmocka_unit_test(test_broken_metadata),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
