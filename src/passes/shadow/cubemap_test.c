/* SPDX-License-Identifier: MIT */
/* Where rays leave boxes, against the slabs in double precision, and the faces of cubes. */
#include "passes/shadow/cubemap_test_shared.h"
#include "shaders.h"
#include "tests/render_harness.h"

enum { COUNT = 20000 };

static struct gpu_cube_case cases[COUNT];
static struct gpu_cube_answer answers[COUNT];

static void ask(void) {
    gpu_device *device = harness_device();
    struct graph *graph;
    struct gpu_buffer in, out;
    assert_int_equal(graph_create(gpu_host(device), device, &graph), FNL_OK);
    graph_begin(graph);
    assert_int_equal(gpu_buffer_create(device, "cases", sizeof cases, GPU_MEMORY_UPLOAD, &in), FNL_OK);
    assert_int_equal(gpu_buffer_create(device, "answers", sizeof answers, GPU_MEMORY_READBACK, &out), FNL_OK);
    memcpy(in.mapped, cases, sizeof cases);
    assert_int_equal(gpu_frame_begin(device), FNL_OK);
    const graph_buffer given = graph_import_buffer(graph, "cases", &in), taken = graph_import_buffer(graph, "answers", &out);
    struct gpu_cubes_push push = {.count = COUNT};
    graph_dispatch(graph, &(struct graph_dispatch){.name = "cubes",
                                                   .pipeline = {.shader = &shader_cubemap_test_comp},
                                                   .groups = {DIVIDE_UP(COUNT, 64u)},
                                                   GRAPH_PUSH(push),
                                                   GRAPH_ROWS(graph_reads(&push.cases, given), graph_writes(&push.answers, taken))});
    struct graph_pass *host = graph_add_pass(graph, "to host", GRAPH_QUEUE_GRAPHICS, NULL, NULL, 0);
    graph_keep(host);
    graph_use_buffer(host, taken, GRAPH_READ_HOST);
    assert_int_equal(graph_compile(graph), FNL_OK);
    assert_int_equal(graph_execute_frame(graph, NULL), FNL_OK);
    assert_int_equal(gpu_wait_idle(device), FNL_OK);
    memcpy(answers, out.mapped, sizeof answers);
    graph_destroy(&graph);
    gpu_buffer_destroy(device, &in);
    gpu_buffer_destroy(device, &out);
}

/* Axis by axis: the face that the ray heads for. */
static double exit_of(const struct gpu_cube_case *c) {
    const float *from = &c->from.x, *along = &c->along.x, *half = &c->half_size.x;
    double least = INFINITY;
    for (int k = 0; k < 3; k++) {
        if (along[k] == 0) continue;
        const double face = along[k] > 0 ? (double)half[k] : -(double)half[k];
        least = fmin(least, (face - (double)from[k]) / (double)along[k]);
    }
    return least;
}

/* A third of the rays run along one or two axes, and a third begin on planes, edges and corners. */
static void test_rays_leave_boxes_where_slabs_say_LC_3(void **state) {
    UNUSED(state);
    struct random_state random = {5};
    for (uint32_t i = 0; i < COUNT; i++) {
        struct gpu_cube_case *c = &cases[i];
        float *from = &c->from.x, *along = &c->along.x, *half = &c->half_size.x;
        for (int k = 0; k < 3; k++) {
            half[k] = random_range(&random, 0.5f, 6);
            from[k] = half[k] * random_range(&random, -1, 1);
            along[k] = random_range(&random, -1, 1);
            if (i % 3 == 1 && random_float(&random) < 0.5f) along[k] = random_float(&random) < 0.5f ? 0.0f : -0.0f;
            if (i / 3 % 3 == 1 && random_float(&random) < 0.5f) from[k] = random_float(&random) < 0.5f ? half[k] : -half[k];
        }
        if (vec3_length(c->along) < 0.1f) c->along = (vec3){0, random_float(&random) < 0.5f ? 1 : -1, 0};
        c->along = vec3_normalize(c->along);
    }
    ask();
    for (uint32_t i = 0; i < COUNT; i++) {
        const double wanted = exit_of(&cases[i]), found = (double)answers[i].distance;
        const vec3 place = vec3_add(cases[i].from, vec3_scale(cases[i].along, answers[i].distance));
        if (!(fabs(found - wanted) <= 1e-5 * (1 + wanted))) fail_msg("ray %u leaves after %g m, not %g", i, found, wanted);
        for (int k = 0; k < 3; k++)
            if (!(fabsf((&place.x)[k]) <= (&cases[i].half_size.x)[k] * 1.00001f + 1e-5f)) fail_msg("ray %u leaves outside of the box", i);
    }
}

static void test_faces_hold_all_directions_LC_3(void **state) {
    UNUSED(state);
    ask();
    for (uint32_t i = 0; i < COUNT; i++) {
        const vec3 d = cases[i].along, got = answers[i].along;
        const float most = fmaxf(fabsf(d.x), fmaxf(fabsf(d.y), fabsf(d.z)));
        if (vec3_length(vec3_sub(got, vec3_scale(d, 1 / most))) > 1e-5f) fail_msg("direction %u: (%g %g %g)", i, (double)got.x, (double)got.y, (double)got.z);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_rays_leave_boxes_where_slabs_say_LC_3, harness_check),
        cmocka_unit_test_teardown(test_faces_hold_all_directions_LC_3, harness_check),
    };
    return cmocka_run_group_tests_name("shadow_cubes", tests, harness_begin, harness_end);
}
