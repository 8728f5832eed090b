/* SPDX-License-Identifier: MIT */
/** Every encoding of normals, there and back through UNORM targets of 8 and 16 bits, within the errors that shaders/normal_encodings.glsl
 *  states. */
#include "passes/shade/normal_encodings_test_shared.h"
#include "shaders.h"
#include "tests/render_harness.h"

enum { COUNT = 30000 };

static vec3 normals[COUNT], decoded[COUNT], stored[COUNT];

struct ask_data {
    struct gpu_encodings_push push;
};

static void execute_ask(const struct graph_context *context, const void *data) {
    const struct ask_data *d = data;
    struct gpu_compute_params params = {.shader = &shader_normal_encodings_test_comp};
    gpu_bind(context->commands, gpu_compute_pipeline(context->device, &params));
    gpu_push(context->commands, &d->push, sizeof d->push);
    gpu_dispatch_linear(context->commands, DIVIDE_UP(COUNT, 64));
}

static void execute_nothing(const struct graph_context *context, const void *data) {
    UNUSED(context);
    UNUSED(data);
}

static void ask_device(struct gpu_encodings_push push) {
    gpu_device *device = harness_device();
    struct graph *graph;
    struct gpu_buffer buffers[3];
    static const char *const names[] = {"test normals", "test decoded", "test stored"};
    graph_buffer handles[3];
    assert_int_equal(graph_create(gpu_host(device), device, &graph), FNL_OK);
    graph_begin(graph);
    for (int i = 0; i < 3; i++) {
        assert_int_equal(
            gpu_buffer_create(device, names[i], sizeof normals, i ? GPU_MEMORY_READBACK : GPU_MEMORY_UPLOAD, &buffers[i]),
            FNL_OK);
        handles[i] = graph_import_buffer(graph, names[i], &buffers[i]);
    }
    memcpy(buffers[0].mapped, normals, sizeof normals);
    assert_int_equal(gpu_frame_begin(device), FNL_OK);
    push.normals = buffers[0].address;
    push.decoded = buffers[1].address;
    push.stored = buffers[2].address;
    push.count = COUNT;
    struct ask_data ask = {push};
    struct graph_pass *pass = graph_add_pass(graph, "encode", GRAPH_QUEUE_GRAPHICS, execute_ask, &ask, sizeof ask);
    for (int i = 0; i < 3; i++) graph_use_buffer(pass, handles[i], i ? GRAPH_WRITE_COMPUTE : GRAPH_READ_COMPUTE);
    struct graph_pass *host = graph_add_pass(graph, "to host", GRAPH_QUEUE_GRAPHICS, execute_nothing, NULL, 0);
    graph_keep(host);
    for (int i = 1; i < 3; i++) graph_use_buffer(host, handles[i], GRAPH_READ_HOST);
    assert_int_equal(graph_compile(graph), FNL_OK);
    assert_int_equal(graph_execute_frame(graph, NULL), FNL_OK);
    assert_int_equal(gpu_wait_idle(device), FNL_OK);
    memcpy(decoded, buffers[1].mapped, sizeof decoded);
    memcpy(stored, buffers[2].mapped, sizeof stored);
    graph_destroy(&graph);
    for (int i = 0; i < 3; i++) gpu_buffer_destroy(device, &buffers[i]);
}

static double degrees_between(vec3 a, vec3 b) {
    double x = (double)a.y * (double)b.z - (double)a.z * (double)b.y,
           y = (double)a.z * (double)b.x - (double)a.x * (double)b.z,
           z = (double)a.x * (double)b.y - (double)a.y * (double)b.x;
    double dot = (double)a.x * (double)b.x + (double)a.y * (double)b.y + (double)a.z * (double)b.z;
    return atan2(sqrt(x * x + y * y + z * z), dot) * 57.29577951308232;
}

/* All over the sphere; crowded round the poles and the equator; the axes and their mirror images. */
static void make_normals(void) {
    struct random_state random = {17};
    for (uint32_t i = 0; i < COUNT; i++) {
        float z = random_range(&random, -1, 1);
        if (i % 4 == 1) z = 1 - 0.01f * z * z;
        if (i % 4 == 2) z = -1 + 0.01f * z * z;
        if (i % 4 == 3) z = 0.02f * z;
        float angle = random_range(&random, -PI, PI), across = sqrtf(fmaxf(1 - z * z, 0));
        normals[i] = vec3_normalize(vec3_make(across * cosf(angle), across * sinf(angle), z));
    }
    for (uint32_t i = 0; i < 6; i++)
        normals[i] = vec3_make(i / 2 == 0 ? 1 - 2 * (float)(i % 2) : 0, i / 2 == 1 ? 1 - 2 * (float)(i % 2) : 0,
                               i / 2 == 2 ? 1 - 2 * (float)(i % 2) : 0);
}

static void test_round_trips_TD_13(void **state) {
    UNUSED(state);
    static const struct {
        const char *name;
        double lowest_z, most[2]; /* degrees at 8 and 16 bits; 0: not for this size */
    } encodings[ENCODING_COUNT] = {{"xy", 0, {7.2, 0.45}},
                                   {"spherical", -1, {5.2, 0.33}},
                                   {"sphere map", -1, {12, 0.75}},
                                   {"stereographic", -0.5, {1.2, 0.005}},
                                   {"octahedral", -1, {0.96, 0.004}},
                                   {"view space", 0, {7.2, 0.45}},
                                   {"best fit", -1, {0.33, 0}},
                                   {"xyz", -1, {0.39, 0.0016}}};
    make_normals();
    vec3 to_view = vec3_normalize(vec3_make(0.3f, 0.5f, -0.7f));
    for (uint32_t e = 0; e < ENCODING_COUNT; e++)
        for (int bits = 0; bits < 2; bits++) {
            if (encodings[e].most[bits] == 0) continue;
            ask_device((struct gpu_encodings_push){.to_view = to_view, .encoding = e, .most = bits ? 65535 : 255});
            double worst = 0;
            uint32_t tried = 0;
            for (uint32_t i = 0; i < COUNT; i++) {
                double z = (double)(e == ENCODING_VIEW ? vec3_dot(normals[i], to_view) : normals[i].z);
                assert_true(isfinite(decoded[i].x) && isfinite(decoded[i].y) && isfinite(decoded[i].z));
                assert_true(fabs((double)vec3_length(decoded[i]) - 1) < 1e-5);
                for (int k = 0; k < 3; k++) {
                    float v = k == 0 ? stored[i].x : k == 1 ? stored[i].y : stored[i].z;
                    assert_true(v >= 0 && v <= 1);
                }
                if (z < encodings[e].lowest_z) continue;
                tried++;
                worst = fmax(worst, degrees_between(normals[i], decoded[i]));
            }
            print_message("%s, %d bits: %.4f degrees at most\n", encodings[e].name, bits ? 16 : 8, worst);
            assert_true(tried > COUNT / 4);
            assert_true(worst <= encodings[e].most[bits]);
            assert_true(worst > encodings[e].most[bits] / 3); /* what is stated is what it is */
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test_teardown(test_round_trips_TD_13, harness_check)};
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
