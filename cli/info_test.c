/* SPDX-License-Identifier: MIT */
#include "fanal/fanal.h"
#include "command_capture.h"
#include "commands.h"

#include "base/base.h"
#include "base/file.h"

#include <jansson.h>

static char folder[64];
static int run(const char *line) {
    char words[512];
    snprintf(words, sizeof words, "info %s", line);
    return capture(command_info, words);
}

static void save(const char *name, const char *text) {
    fnl_host host = host_resolve(NULL);
    assert_int_equal(file_save(&host, name, text, strlen(text)), FNL_OK);
}

static const char lights[] =
    "{\"asset\":{\"version\":\"2.0\"},\"extensionsUsed\":[\"KHR_lights_punctual\",\"ACME_odd\"],"
    "\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[{\"name\":\"bulb\",\"type\":\"spot\",\"spot\":{},\"intensity\":7,\"range\":3},{"
    "\"type\":\"point\"}]}},"
    "\"cameras\":[{\"name\":\"front\",\"type\":\"perspective\",\"perspective\":{\"yfov\":1,\"znear\":0.1}}],"
    "\"images\":[{\"uri\":\"none.png\"}],"
    "\"materials\":[{\"name\":\"oak\"},{}],"
    "\"nodes\":[{\"name\":\"desk lamp\",\"translation\":[1,2,3],\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}},"
    "{\"extensions\":{\"KHR_lights_punctual\":{\"light\":1}}},{\"camera\":0}]}";

static void test_text(void **state) {
    UNUSED(state);
    save("lights.gltf", lights);
    assert_int_equal(run("lights.gltf"), 0);
    assert_string_equal(err, ""); /* warnings are part of the list, not said twice */
    static const char *const expected[] = {
        "  lights                  2  (0 directional, 1 point, 1 spot)\n",
        "  nodes                   3\n",
        "  spot                 7 cd ",
        "range 3 m  inner cone 0.0 degrees  cone 45.0 degrees  bulb\n",
        "no range\n",
        "front",
        "  KHR_lights_punctual                   used      full\n",
        "  ACME_odd                              used      ignored\n",
        "\nNodes\n    0  desk lamp\n\nMaterials\n    0  oak\n\n", /* the others have no name, and there is no mesh */
        "Warnings\n",
        "lights.gltf: /images/0/uri: none.png: cannot be opened",
        "nothing is shown",
    };
    for (uint32_t i = 0; i < COUNT_OF(expected); i++)
        if (!strstr(out, expected[i])) fail_msg("no '%s' in:\n%s", expected[i], out);
}

static void test_variants(void **state) {
    UNUSED(state);
    save("shoe.gltf", "{\"asset\":{\"version\":\"2.0\"},\"extensionsUsed\":[\"KHR_materials_variants\"],\"extensions\":{"
                      "\"KHR_materials_variants\":{\"variants\":[{\"name\":\"street\"},{\"name\":\"beach\"},{\"name\":\"0\"}]}}}");
    assert_int_equal(run("shoe.gltf"), 0);
    assert_non_null(strstr(out, "\nVariants\n    0  street\n    1  beach\n    2  0\n"));
    static const struct {
        const char *name;
        int index;
    } cases[] = {{"beach", 1}, {"1", 1}, {"0", 2}}; /* names come first */
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        char line[64];
        snprintf(line, sizeof line, "shoe.gltf --json --variant %s", cases[i].name);
        assert_int_equal(run(line), 0);
        json_t *root = json_loads(out, 0, NULL);
        assert_int_equal(json_array_size(json_object_get(root, "variants")), 3);
        assert_int_equal(json_integer_value(json_object_get(root, "variant")), cases[i].index);
        json_decref(root);
    }
    assert_int_equal(run("shoe.gltf --variant beach"), 0);
    assert_non_null(strstr(out, "    1  beach  (shown)\n    2  0\n"));
    static const char *const wrong[] = {"office", "3", "-1", "1x"};
    for (uint32_t i = 0; i < COUNT_OF(wrong); i++) {
        char line[64], expected[160];
        snprintf(line, sizeof line, "shoe.gltf --variant %s", wrong[i]);
        snprintf(expected, sizeof expected, "--variant: the scene has no variant '%s'; it has 0 'street', 1 'beach', 2 '0'\n", wrong[i]);
        assert_int_equal(run(line), 2);
        if (!strstr(err, expected)) fail_msg("no '%s' in: %s", expected, err);
    }
    assert_int_equal(run("builtin:spheres --variant a"), 2);
    assert_non_null(strstr(err, "the scene has no variant 'a'; it has none\n"));
}

static void test_metadata(void **state) {
    UNUSED(state);
    save("told.gltf", "{\"asset\":{\"version\":\"2.0\",\"extensions\":{\"KHR_xmp_json_ld\":{\"packet\":1}}},\"nodes\":[{\"extensions\":{"
                      "\"KHR_xmp_json_ld\":{\"packet\":1}}}],\"extensionsUsed\":[\"KHR_xmp_json_ld\"],\"extensions\":{\"KHR_xmp_json_ld\":{\"packets\":["
                      "{\"@context\":{}},{\"@context\":{},\"dc:title\":\"a shoe\\u001b\",\"dc:rights\":{\"@value\":1}}]}}}");
    assert_int_equal(run("told.gltf"), 0);
    if (!strstr(out, "\nMetadata\n    0  (of nothing)\n    1  /asset /nodes/0\n       \"dc:title\": \"a shoe\\u001B\"\n       \"dc:rights\": {\"@value\":1}\n"))
        fail_msg("%s", out);
    assert_int_equal(run("told.gltf --json"), 0);
    json_t *root = json_loads(out, 0, NULL), *packets = json_object_get(root, "metadata"), *told = json_array_get(packets, 1);
    assert_int_equal(json_array_size(packets), 2);
    assert_int_equal(json_array_size(json_object_get(json_array_get(packets, 0), "about")), 0);
    assert_string_equal(json_string_value(json_array_get(json_object_get(told, "about"), 1)), "/nodes/0");
    assert_int_equal(json_integer_value(json_object_get(json_object_get(json_object_get(told, "packet"), "dc:rights"), "@value")), 1);
    json_decref(root);
}

static void test_json(void **state) {
    UNUSED(state);
    save("lights.gltf", lights);
    assert_int_equal(run("lights.gltf --json"), 0);
    json_t *root = json_loads(out, 0, NULL);
    assert_non_null(root);
    json_t *list = json_object_get(root, "lights"), *counts = json_object_get(root, "counts");
    assert_int_equal(json_integer_value(json_object_get(counts, "lights")), 2);
    assert_int_equal(json_array_size(list), 2);
    assert_string_equal(json_string_value(json_object_get(json_array_get(list, 0), "kind")), "spot");
    assert_true(json_number_value(json_object_get(json_array_get(list, 0), "range")) == 3);
    assert_true(json_is_null(json_object_get(json_array_get(list, 1), "range")));
    assert_int_equal(json_integer_value(json_object_get(counts, "unlimited_lights")), 1);
    assert_true(json_is_null(json_object_get(root, "light_threshold")));
    assert_true(json_number_value(json_array_get(json_object_get(json_array_get(list, 0), "position"), 2)) == 3);
    assert_true(json_is_null(json_object_get(root, "extent")));
    assert_int_equal(json_array_size(json_object_get(root, "warnings")), 2);
    assert_string_equal(json_string_value(json_object_get(json_array_get(json_object_get(root, "cameras"), 0), "name")),
                        "front");
    assert_string_equal(json_string_value(json_object_get(json_array_get(list, 0), "name")), "bulb");
    assert_string_equal(json_string_value(json_array_get(json_object_get(root, "nodes"), 0)), "desk lamp");
    assert_string_equal(json_string_value(json_array_get(json_object_get(root, "nodes"), 2)), "");
    assert_int_equal(json_array_size(json_object_get(root, "materials")), 2);
    assert_string_equal(json_string_value(json_array_get(json_object_get(root, "materials"), 0)), "oak");
    assert_int_equal(json_array_size(json_object_get(root, "meshes")), 0);
    json_decref(root);
}

/* One light more than can be unlimited. */
static void test_lights_that_are_cut(void **state) {
    UNUSED(state);
    char file[8192];
    int used = snprintf(file, sizeof file, "{\"asset\":{\"version\":\"2.0\"},\"extensionsUsed\":[\"KHR_lights_punctual\"],\"extensions\":{\"KHR_lights_punctual\":{\"lights\":"
                                           "[{\"type\":\"point\"}]}},\"scenes\":[{\"nodes\":[0");
    for (int i = 1; i <= FNL_UNLIMITED_LIGHTS_MAX; i++) used += snprintf(file + used, sizeof file - (size_t)used, ",%d", i);
    used += snprintf(file + used, sizeof file - (size_t)used, "]}],\"nodes\":[");
    for (int i = 0; i <= FNL_UNLIMITED_LIGHTS_MAX; i++)
        used += snprintf(file + used, sizeof file - (size_t)used, "%s{\"translation\":[%d,0,0],\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}}", i ? "," : "", i);
    snprintf(file + used, sizeof file - (size_t)used, "]}");
    save("many.gltf", file);
    assert_int_equal(run("many.gltf"), 0);
    assert_non_null(strstr(out, "no range             65  (cut where they give less than 0.000122 lx)")); /* 3 * 65 / 32^2 / 1024, rounded down to 2^-13 */
    assert_int_equal(run("many.gltf --json"), 0);
    json_t *root = json_loads(out, 0, NULL);
    assert_true(fabs(json_number_value(json_object_get(root, "light_threshold")) - 0x1p-13) < 1e-9);
    json_decref(root);
}

static void test_errors(void **state) {
    UNUSED(state);
    save("broken.gltf",
         "{\"asset\":{\"version\":\"2.0\"},\"extensionsUsed\":[\"ACME_odd\"],\"extensionsRequired\":[\"ACME_odd\"]}");
    assert_int_equal(run("broken.gltf"), 2);
    assert_string_equal(out, "");
    assert_non_null(strstr(err, "broken.gltf: /extensionsRequired/0: the file requires the extension ACME_odd"));
    assert_int_equal(run("missing.glb"), 2);
    assert_non_null(strstr(err, "missing.glb: cannot be opened"));
    assert_int_equal(run(""), 2);
    assert_int_equal(run("a.glb b.glb"), 2);
    assert_int_equal(run("--unknown a.glb"), 2);
    assert_int_equal(run("--help"), 0);
    assert_non_null(strstr(out, "Examples:"));
}

static void test_gbuffers_MP_20_MP_24(void **state) {
    UNUSED(state);
    assert_int_equal(run("--gbuffers --size 2800x1800 --samples 4"), 0);
    const char *engel = strstr(out, "\nengel\n"), *destiny = strstr(out, "\ndestiny\n");
    assert_true(engel && destiny);
    const char *twenty = strstr(engel, "20 bytes a pixel"), *twelve = strstr(destiny, "12 bytes a pixel");
    assert_true(twenty && twenty < destiny && twelve);
    assert_non_null(strstr(twenty, "403200000 bytes    24.19 GB/s"));
    assert_true(strstr(twenty, "403200000") < destiny);
    assert_int_equal(run("--gbuffers a.glb"), 2);
    assert_int_equal(run("--gbuffers --samples 0"), 2);
    assert_int_equal(run("--gbuffers --fps 0"), 2);
}

static int make_folder(void **state) {
    UNUSED(state);
    snprintf(folder, sizeof folder, "/tmp/fanal-info-test-%d", (int)getpid());
    char command[128];
    snprintf(command, sizeof command, "mkdir -p %s", folder);
    return system(command) || chdir(folder);
}

static int remove_folder(void **state) {
    UNUSED(state);
    char command[128];
    snprintf(command, sizeof command, "rm -r %s", folder);
    return chdir("/") || system(command);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_text), cmocka_unit_test(test_json), cmocka_unit_test(test_variants), cmocka_unit_test(test_metadata),
                                       cmocka_unit_test(test_lights_that_are_cut), cmocka_unit_test(test_errors), cmocka_unit_test(test_gbuffers_MP_20_MP_24)};
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
