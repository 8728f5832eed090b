/* SPDX-License-Identifier: MIT */
/* Every accessor type, component type, normalisation, stride and kind of sparseness against a slow reference. */
#include "scene/gltf.h"
#include "tests/gltf_test_file.h"

#include <setjmp.h>

#include <cmocka.h>

static const char *const types[] = {"SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"};
static const uint32_t rows[] = {1, 2, 3, 4, 2, 3, 4}, columns[] = {1, 1, 1, 1, 2, 3, 4};
static const uint32_t components[] = {5120, 5121, 5122, 5123, 5125, 5126}, sizes[] = {1, 1, 2, 2, 4, 4};

enum { COUNT = 7, SPARSE_COUNT = 3, BASE_OFFSET = 4, INDEX_OFFSET = 2048, VALUE_OFFSET = 2064, BINARY_SIZE = 4096 };
static const uint16_t sparse_indices[SPARSE_COUNT] = {0, 3, 6};

/** The specification's table, said once more: columns of matrices begin at multiples of four bytes. */
static uint32_t offset_of(uint32_t type, uint32_t size, uint32_t component) {
    uint32_t column_size = columns[type] == 1 ? rows[type] * size : (rows[type] * size + 3) / 4 * 4;
    return component / rows[type] * column_size + component % rows[type] * size;
}

static double reference(const unsigned char *bytes, uint32_t component, bool normalized) {
    int8_t i8;
    int16_t i16;
    uint16_t u16;
    uint32_t u32;
    float f;
    memcpy(&i8, bytes, 1);
    memcpy(&i16, bytes, 2);
    memcpy(&u16, bytes, 2);
    memcpy(&u32, bytes, 4);
    memcpy(&f, bytes, 4);
    switch (component) {
    case 5120:
        return normalized ? fmax(i8 / 127.0, -1) : i8;
    case 5121:
        return normalized ? *bytes / 255.0 : *bytes;
    case 5122:
        return normalized ? fmax(i16 / 32767.0, -1) : i16;
    case 5123:
        return normalized ? u16 / 65535.0 : u16;
    case 5125:
        return u32;
    default:
        return (double)f;
    }
}

static void fill(unsigned char *binary, uint32_t component, uint64_t seed) {
    struct random_state random = {seed};
    if (component == 5126) {
        for (uint32_t i = 0; i < BINARY_SIZE / 4; i++) {
            float value = random_range(&random, -100, 100);
            memcpy(binary + i * 4, &value, 4);
        }
    } else {
        for (uint32_t i = 0; i < BINARY_SIZE; i++) binary[i] = (unsigned char)random_bits(&random);
        binary[BASE_OFFSET] = 0x80; /* the most negative values: clamped to -1 when normalised */
    }
    memcpy(binary + INDEX_OFFSET, sparse_indices, sizeof sparse_indices);
}

enum sparse { DENSE, SPARSE_OVER_BASE, SPARSE_ALONE };

static void check_case(uint32_t type, uint32_t c, bool normalized, uint32_t stride, enum sparse sparse) {
    static unsigned char binary[BINARY_SIZE];
    static struct test_log log;
    fill(binary, components[c], type * 100 + c);
    char json[2048], base[64] = "", stride_text[64] = "", sparse_text[256] = "";
    if (sparse != SPARSE_ALONE) snprintf(base, sizeof base, "\"bufferView\":0,\"byteOffset\":4,");
    if (stride) snprintf(stride_text, sizeof stride_text, ",\"byteStride\":%u", stride);
    if (sparse != DENSE)
        snprintf(
            sparse_text, sizeof sparse_text,
            ",\"sparse\":{\"count\":3,\"indices\":{\"bufferView\":1,\"componentType\":5123},\"values\":{\"bufferView\":2}}");
    snprintf(json, sizeof json,
             "{\"bufferViews\":[{\"buffer\":0,\"byteLength\":1024%s},"
             "{\"buffer\":0,\"byteOffset\":2048,\"byteLength\":16},{\"buffer\":0,\"byteOffset\":2064,\"byteLength\":1024}],"
             "\"buffers\":[{\"byteLength\":4096}],"
             "\"accessors\":[{%s\"componentType\":%u,\"type\":\"%s\",\"count\":7,\"normalized\":%s%s}]}",
             stride_text, base, components[c], types[type], normalized ? "true" : "false", sparse_text);

    fnl_host host = test_host(&log);
    fnl_scene *scene;
    assert_int_equal(scene_create(&host, "test", &scene), FNL_OK);
    struct gltf g = {.scene = scene,
                     .host = &scene->host,
                     .name = "test",
                     .is_glb = true,
                     .binary = binary,
                     .binary_size = sizeof binary};
    g.root = json_loads(json, 0, NULL);
    assert_non_null(g.root);
    arena_init(&g.scratch, g.host, 4096);
    gltf_load_buffers(&g);
    gltf_load_accessors(&g);
    uint32_t width = rows[type] * columns[type], size = sizes[c];
    float values[COUNT * 16];
    assert_true(gltf_read_floats(&g, 0, &g.top, values));
    assert_int_equal(log.count, 0);

    uint32_t packed = offset_of(type, size, width - 1) + size;
    if (columns[type] > 1) packed = (packed + 3) / 4 * 4;
    for (uint32_t i = 0; i < COUNT; i++)
        for (uint32_t k = 0; k < width; k++) {
            const unsigned char *from =
                sparse == SPARSE_ALONE ? NULL : binary + BASE_OFFSET + i * (stride ? stride : packed);
            for (uint32_t s = 0; s < SPARSE_COUNT && sparse != DENSE; s++)
                if (sparse_indices[s] == i) from = binary + VALUE_OFFSET + s * packed;
            double expected = from ? reference(from + offset_of(type, size, k), components[c], normalized) : 0;
            if (fabs((double)values[i * width + k] - expected) > 1e-6 * fabs(expected))
                fail_msg("%s of %u%s, stride %u, sparse %d: element %u component %u is %g, not %g", types[type],
                         components[c], normalized ? " normalized" : "", stride, (int)sparse, i, k,
                         (double)values[i * width + k], expected);
        }
    json_decref(g.root);
    arena_finish(&g.scratch);
    fnl_scene_destroy(&scene);
}

static void test_every_accessor(void **state) {
    UNUSED(state);
    for (uint32_t type = 0; type < COUNT_OF(types); type++)
        for (uint32_t c = 0; c < COUNT_OF(components); c++)
            for (int normalized = 0; normalized < (c < 4 ? 2 : 1); normalized++)
                for (uint32_t stride = 0; stride <= 72; stride += 72)
                    for (enum sparse sparse = DENSE; sparse <= SPARSE_ALONE; sparse++)
                        check_case(type, c, normalized, stride, sparse);
}

/** Accessors that must be refused, each with the place that the message must name. */
static void test_accessors_that_do_not_fit(void **state) {
    UNUSED(state);
    static const struct {
        const char *accessor, *place;
    } cases[] = {
        {"{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC3\",\"count\":2000000000}",
         "/accessors/0: 2000000000 elements"},
        {"{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC3\",\"count\":357913943}", /* times 12 is 20 in 32 bits */
         "/accessors/0: 357913943 elements"},
        {"{\"componentType\":5126,\"type\":\"VEC3\",\"count\":2000000000}", "/accessors/0/count: is 2000000000"},
        {"{\"bufferView\":0,\"byteOffset\":9223372036854775807,\"componentType\":5126,\"type\":\"VEC3\",\"count\":1}",
         "/accessors/0/byteOffset"},
        {"{\"bufferView\":0,\"byteOffset\":56,\"componentType\":5126,\"type\":\"VEC3\",\"count\":1}",
         "/accessors/0/byteOffset"},
        {"{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC3\",\"count\":99999999999999999999}", "/accessors/0/count"},
        {"{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC3\",\"count\":-1}", "/accessors/0/count"},
        {"{\"bufferView\":1,\"componentType\":5126,\"type\":\"MAT4\",\"count\":1}",
         "/accessors/0/bufferView: its byteStride"},
        {"{\"bufferView\":0,\"componentType\":5124,\"type\":\"VEC3\",\"count\":1}", "/accessors/0/componentType"},
        {"{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC5\",\"count\":1}", "/accessors/0/type"},
        {"{\"componentType\":5126,\"type\":\"SCALAR\",\"count\":2,\"sparse\":{\"count\":3,\"indices\":{\"bufferView\":0,"
         "\"componentType\":5125},\"values\":{\"bufferView\":0}}}",
         "/accessors/0/sparse/count"},
        {"{\"componentType\":5126,\"type\":\"SCALAR\",\"count\":20,\"sparse\":{\"count\":17,\"indices\":{\"bufferView\":0,"
         "\"componentType\":5125},\"values\":{\"bufferView\":0}}}",
         "/accessors/0/sparse/indices"},
        {"{\"componentType\":5126,\"type\":\"VEC2\",\"count\":20,\"sparse\":{\"count\":9,\"indices\":{\"bufferView\":0,"
         "\"componentType\":5125},\"values\":{\"bufferView\":0}}}",
         "/accessors/0/sparse/values"},
    };
    static const unsigned char binary[128];
    static struct test_log log;
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        char json[1024];
        snprintf(json, sizeof json,
                 "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":128}],\"bufferViews\":[{\"buffer\":0,"
                 "\"byteLength\":64},"
                 "{\"buffer\":0,\"byteLength\":64,\"byteStride\":4}],\"accessors\":[%s],"
                 "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}]}",
                 cases[i].accessor);
        fnl_scene *scene;
        assert_int_equal(test_load(&log, json, binary, sizeof binary, &scene), FNL_OK);
        char expected[128];
        snprintf(expected, sizeof expected, "test.glb: %s", cases[i].place);
        if (!strstr(log.text, expected)) fail_msg("no '%s' in:\n%s", expected, log.text);
        assert_int_equal(scene->primitives.count, 0);
        fnl_scene_destroy(&scene);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_accessor),
        cmocka_unit_test(test_accessors_that_do_not_fit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
