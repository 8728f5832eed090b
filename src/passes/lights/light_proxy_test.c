/* SPDX-License-Identifier: MIT */
/** The volumes of lights: what shading and lists are told about points, bounding spheres and proxies, against double precision. */
#include "passes/lights/light_proxy.h"
#include "passes/lights/light_proxy_test_shared.h"
#include "render/device/light_shapes.h"
#include "shaders.h"
#include "tests/light_reference.h"
#include "tests/render_harness.h"

enum { LIGHT_COUNT = 120, POINTS_EACH = 400, POINT_COUNT = LIGHT_COUNT * POINTS_EACH };

static struct {
    fnl_light_params params[LIGHT_COUNT];
    struct gpu_light *lights; /* as the device has them, then planes, then bounds */
    const struct gpu_entity_bounds *bounds;
    struct light_hull *hulls[LIGHT_COUNT];
    vec3 points[POINT_COUNT];
    struct gpu_light_answer answers[POINT_COUNT];
    vec3 corners[LIGHT_COUNT * 8];
} bench;

static vec3 random_vector(struct random_state *random, float size) {
    return vec3_make(random_range(random, -size, size), random_range(random, -size, size),
                     random_range(random, -size, size));
}

static fnl_light_params random_light(struct random_state *random, uint32_t i) {
    fnl_light_params l = fnl_light_params_default();
    l.kind = (fnl_light_kind)(1 + i % 6);
    l.position = random_vector(random, i % 7 == 6 ? 3000.0f : 20.0f);
    l.direction = i % 4 == 3 ? vec3_make(0, -1, 0) : random_vector(random, 1);
    l.up = i % 4 == 3 ? vec3_make(0, 1, 0) : random_vector(random, 1); /* parallel: another one is taken */
    l.intensity = exp2f(random_range(random, -3, 6));
    l.range = i % 3 == 0 ? fnl_light_range(&l, 1, 0.05f) : exp2f(random_range(random, -3, 4));
    l.outer_cone_angle = random_range(random, 0.01f, 1) * (i % 2 ? 0.2f : PI / 2);
    l.inner_cone_angle = l.outer_cone_angle * (i % 8 == 1 ? 1 : random_range(random, 0, 1));
    l.length = i % 10 == 2 ? 0 : exp2f(random_range(random, -4, 4));
    for (int k = 0; k < 2; k++) l.wedge_angles[k] = random_range(random, 0.02f, i % 2 ? 0.3f : 1.5f);
    l.box_size =
        (vec3){exp2f(random_range(random, -3, 4)), exp2f(random_range(random, -3, 4)), exp2f(random_range(random, -3, 4))};
    l.rectangle_size[0] = exp2f(random_range(random, -4, 3)), l.rectangle_size[1] = exp2f(random_range(random, -4, 3));
    l.two_sided = i % 4 < 2;
    l.inner_fraction = i % 9 == 4 ? 1 : random_range(random, 0, 0.99f);
    return l;
}

/* Points where something may happen: near the axis, anywhere in a ball a little larger than the bounds, and on the range. */
static vec3 random_point(struct random_state *random, const struct gpu_shape *g, const struct gpu_entity_bounds *b,
                         uint32_t k) {
    vec3 ball;
    do ball = random_vector(random, 1);
    while (vec3_length(ball) > 1 || vec3_length(ball) < 0.01f);
    vec3 axis = vec3_add_scaled(g->position, g->direction, random_range(random, -0.1f, 1.05f) * g->range);
    if (k % 4 == 0) return vec3_add_scaled(axis, ball, random_range(random, 0, 0.2f) * vec3_distance(axis, g->position));
    if (k % 4 == 1) return vec3_add_scaled(g->position, vec3_normalize(ball), g->range * random_range(random, 0.98f, 1.01f));
    return vec3_add_scaled(b->center, ball, b->radius * 1.2f);
}

struct ask_data {
    struct gpu_light_proxy_push push;
};

static void execute_ask(const struct graph_context *context, const void *data) {
    const struct ask_data *d = data;
    struct gpu_compute_params params = {&shader_light_proxy_test_comp, 1, {GPU_LIGHTING_AREA_LIGHTS}};
    gpu_bind(context->commands, gpu_compute_pipeline(context->device, &params));
    gpu_push(context->commands, &d->push, sizeof d->push);
    gpu_dispatch_linear(context->commands, DIVIDE_UP(POINT_COUNT, 64));
}

static void execute_nothing(const struct graph_context *context, const void *data) {
    UNUSED(context);
    UNUSED(data);
}

static void ask_device(uint64_t light_bytes, uint64_t planes, uint64_t bounds) {
    gpu_device *device = harness_device();
    struct graph *graph;
    struct gpu_buffer buffers[4]; /* lights, points, answers, corners */
    static const char *const names[] = {"asked lights", "asked points", "answers", "corners"};
    const uint64_t sizes[] = {light_bytes, sizeof bench.points, sizeof bench.answers, sizeof bench.corners};
    graph_buffer handles[4];
    assert_int_equal(graph_create(gpu_host(device), device, &graph), FNL_OK);
    graph_begin(graph);
    for (int i = 0; i < 4; i++) {
        assert_int_equal(
            gpu_buffer_create(device, names[i], sizes[i], i < 2 ? GPU_MEMORY_UPLOAD : GPU_MEMORY_READBACK, &buffers[i]),
            FNL_OK);
        handles[i] = graph_import_buffer(graph, names[i], &buffers[i]);
    }
    memcpy(buffers[0].mapped, bench.lights, light_bytes);
    memcpy(buffers[1].mapped, bench.points, sizeof bench.points);
    assert_int_equal(gpu_frame_begin(device), FNL_OK);
    struct light_input input = {.set = {.lights = buffers[0].address,
                                        .shapes = buffers[0].address,
                                        .planes = buffers[0].address + planes,
                                        .entities = buffers[0].address + bounds,
                                        .local_count = LIGHT_COUNT}};
    struct ask_data ask = {.push = {.points = buffers[1].address,
                                    .answers = buffers[2].address,
                                    .corners = buffers[3].address,
                                    .light_count = LIGHT_COUNT,
                                    .points_each = POINTS_EACH}};
    light_list_header(device, &input, &ask.push.list);
    struct graph_pass *pass = graph_add_pass(graph, "ask lights", GRAPH_QUEUE_GRAPHICS, execute_ask, &ask, sizeof ask);
    for (int i = 0; i < 4; i++) graph_use_buffer(pass, handles[i], i < 2 ? GRAPH_READ_COMPUTE : GRAPH_WRITE_COMPUTE);
    struct graph_pass *host = graph_add_pass(graph, "to host", GRAPH_QUEUE_GRAPHICS, execute_nothing, NULL, 0);
    graph_keep(host);
    for (int i = 2; i < 4; i++) graph_use_buffer(host, handles[i], GRAPH_READ_HOST);
    assert_int_equal(graph_compile(graph), FNL_OK);
    assert_int_equal(graph_execute_frame(graph, NULL), FNL_OK);
    assert_int_equal(gpu_wait_idle(device), FNL_OK);
    memcpy(bench.answers, buffers[2].mapped, sizeof bench.answers);
    memcpy(bench.corners, buffers[3].mapped, sizeof bench.corners);
    graph_destroy(&graph);
    for (int i = 0; i < 4; i++) gpu_buffer_destroy(device, &buffers[i]);
}

/* A scene of lights, a third of them cut by hulls; what the device is sent; and its answers to random points. */
static fnl_scene *scene;
static struct device_scene gathered;

static int ask_begin(void **state) {
    if (harness_begin(state)) return -1;
    struct random_state random = {31};
    assert_int_equal(fnl_scene_create(gpu_host(harness_device()), &scene), FNL_OK);
    for (uint32_t i = 0; i < LIGHT_COUNT; i++) {
        fnl_light_id id;
        fnl_light_params l = random_light(&random, i);
        assert_int_equal(fnl_scene_add_light(scene, &l, &id), FNL_OK);
        assert_int_equal(fnl_scene_query_light(scene, i, &bench.params[i]), FNL_OK);
        if (i / 5 % 3 != 2) continue;
        vec3 corners[12];
        struct gpu_light light;
        struct gpu_entity_bounds sphere;
        device_light(&bench.params[i], i, &light, &sphere);
        float size = sphere.radius * random_range(&random, 0.2f, 1.5f);
        vec3 middle = vec3_add_scaled(l.position, bench.params[i].direction, size * random_range(&random, 0, 1));
        for (int k = 0; k < 12; k++) corners[k] = vec3_add(middle, random_vector(&random, size));
        assert_int_equal(fnl_scene_set_light_hull(scene, id, corners, 12), FNL_OK);
    }
    gathered = (struct device_scene){.host = *gpu_host(harness_device()), .scene = scene};
    assert_int_equal(device_lights_gather(&gathered), FNL_OK);
    uint64_t planes = DIVIDE_UP(LIGHT_COUNT * sizeof *bench.lights, sizeof(vec4)) * sizeof(vec4),
             bounds = planes + gathered.planes_taken.end * sizeof(vec4), bytes = bounds + LIGHT_COUNT * sizeof *bench.bounds;
    bench.lights = calloc(1, bytes);
    memcpy(bench.lights, gathered.light_data.data, LIGHT_COUNT * sizeof *bench.lights);
    memcpy((char *)bench.lights + planes, gathered.plane_data.data, gathered.planes_taken.end * sizeof(vec4));
    bench.bounds = (const struct gpu_entity_bounds *)((char *)bench.lights + bounds);
    memcpy((char *)bench.lights + bounds, gathered.light_bounds.data, LIGHT_COUNT * sizeof *bench.bounds);
    for (uint32_t i = 0; i < LIGHT_COUNT; i++) {
        bench.hulls[i] = scene->lights.data[i].hull;
        for (uint32_t k = 0; k < POINTS_EACH; k++)
            bench.points[i * POINTS_EACH + k] = random_point(&random, &bench.lights[i].shape, &bench.bounds[i], k);
    }
    ask_device(bytes, planes, bounds);
    return 0;
}

static int ask_end(void **state) {
    free(bench.lights);
    array_free(&gathered.host, &gathered.light_data);
    array_free(&gathered.host, &gathered.light_bounds);
    array_free(&gathered.host, &gathered.plane_data);
    ranges_finish(&gathered.host, &gathered.planes_taken);
    fnl_scene_destroy(&scene);
    return harness_end(state);
}

/* Greatest signed distance of a point from the planes; above 0 it is outside. */
static double out_of_hull(const struct light_hull *hull, vec3 p) {
    double worst = -INFINITY;
    for (uint32_t i = 0; hull && i < hull->plane_count; i++) {
        const double *n = hull->planes[i];
        worst = fmax(worst, n[0] * (double)p.x + n[1] * (double)p.y + n[2] * (double)p.z + n[3]);
    }
    return worst;
}

static double distance_of(const fnl_light_params *l, const double p[3]) {
    double axes[3][3], ray[3] = {l->position.x - p[0], l->position.y - p[1], l->position.z - p[2]};
    if (l->kind == FNL_LIGHT_CAPSULE) {
        light_axes(l, axes);
        double along = fmin(fmax(-light_dot(ray, axes[2]), -(double)l->length / 2), (double)l->length / 2);
        for (int i = 0; i < 3; i++) ray[i] += axes[2][i] * along;
    }
    if (l->kind == FNL_LIGHT_RECTANGLE) {
        light_axes(l, axes);
        for (int k = 0; k < 2; k++) {
            const double half = (double)l->rectangle_size[k] / 2, along = fmin(fmax(-light_dot(ray, axes[k]), -half), half);
            for (int i = 0; i < 3; i++) ray[i] += axes[k][i] * along;
        }
    }
    return sqrt(light_dot(ray, ray));
}

static void test_answers(void **state) {
    UNUSED(state);
    uint32_t lit[FNL_LIGHT_KIND_COUNT] = {0}, dark[FNL_LIGHT_KIND_COUNT] = {0}, cut = 0, beyond = 0;
    for (uint32_t i = 0; i < POINT_COUNT; i++) {
        uint32_t light = i / POINTS_EACH;
        const fnl_light_params *l = &bench.params[light];
        const struct gpu_light_answer *a = &bench.answers[i];
        const double p[3] = {bench.points[i].x, bench.points[i].y, bench.points[i].z};
        double to_light[3] = {0}, strength = light_reference(l, p, to_light), got = (double)a->illuminance.x;
        /* One question, one answer. */
        assert_true((a->reaches != 0) == (got > 0));
        assert_true(isfinite(got) && got >= 0);
        /* Exactly nothing from the range on, nor outside of the hull. */
        double distance = distance_of(l, p), range = (double)fnl_light_range(l, 1, 0.05f);
        double rounding = 2e-6 * range + 1e-6 * sqrt(light_dot(p, p));
        if (distance >= range + rounding) {
            assert_true(got == 0);
            beyond++;
        }
        double out = out_of_hull(bench.hulls[light], bench.points[i]);
        if (out > rounding) {
            assert_true(got == 0);
            cut += strength > 0;
            continue;
        }
        if (out > -rounding) continue;
        /* Fading edges magnify the rounding of positions by their steepness. */
        double peak = l->kind == FNL_LIGHT_BOX ? 1 : 1 / fmax(distance * distance, 1e-8);
        double wanted = strength * (double)l->intensity;
        bool steep = bench.lights[light].shape.spot_scale > 50 || fabs(p[0]) + fabs(p[1]) + fabs(p[2]) > 500 || distance < 1e-3;
        double slack = 2e-3 + 4 * rounding / distance;
        if (!steep && fabs(got - wanted) > slack * peak * (double)l->intensity)
            fail_msg("light %u of kind %d: %g lux, reference %g", light, (int)l->kind, got, wanted);
        if (!steep && got > 0) {
            const double seen[3] = {a->to_light.x, a->to_light.y, a->to_light.z};
            assert_true(strength == 0 || light_dot(seen, to_light) > 0.9999);
        }
        lit[l->kind] += got > 0;
        dark[l->kind] += got == 0;
    }
    for (int kind = FNL_LIGHT_POINT; kind < FNL_LIGHT_KIND_COUNT; kind++) {
        print_message("kind %d: %u points lit, %u dark\n", kind, lit[kind], dark[kind]);
        assert_true(lit[kind] > 500 && dark[kind] > 200);
    }
    print_message("%u points cut off by hulls, %u out of range\n", cut, beyond);
    assert_true(cut > 500 && beyond > 5000);
}

static double volume_of(const vec3 c[8]) {
    static const int tetrahedra[5][4] = {{0, 1, 2, 4}, {3, 1, 2, 7}, {5, 1, 4, 7}, {6, 2, 4, 7}, {1, 2, 4, 7}};
    double sum = 0;
    for (int t = 0; t < 5; t++) {
        const int *k = tetrahedra[t];
        vec3 a = vec3_sub(c[k[1]], c[k[0]]), b = vec3_sub(c[k[2]], c[k[0]]), d = vec3_sub(c[k[3]], c[k[0]]);
        sum += fabs((double)vec3_dot(a, vec3_cross(b, d))) / 6;
    }
    return sum;
}

static void test_proxies(void **state) {
    UNUSED(state);
    uint32_t inside = 0;
    for (uint32_t light = 0; light < LIGHT_COUNT; light++) {
        const struct gpu_shape *g = &bench.lights[light].shape;
        const struct gpu_entity_bounds *b = &bench.bounds[light];
        vec3 corners[8];
        shape_corners(g, b, corners);
        float scale = g->range + vec3_length(g->position);
        for (int k = 0; k < 8; k++)
            assert_true(vec3_distance(corners[k], bench.corners[light * 8 + (uint32_t)k]) < 1e-6f * scale);
        struct light_hull *hull;
        if (light_hull_create(gpu_host(harness_device()), corners, 8, &hull) != FNL_OK) fail_msg("proxy %u is flat", light);
        for (uint32_t k = 0; k < POINTS_EACH; k++) {
            uint32_t i = light * POINTS_EACH + k;
            if (!bench.answers[i].reaches) continue;
            inside++;
            double out = out_of_hull(hull, bench.points[i]);
            if (out > 1e-6 * (double)scale)
                fail_msg("light %u of kind %u lights a point %g m outside of its proxy", light, g->kind, out);
            double from_center = (double)vec3_distance(bench.points[i], b->center);
            if (from_center > (double)b->radius * (1 + 1e-4) + 1e-6 * (double)scale)
                fail_msg("light %u of kind %u lights a point %g m from its bound's centre, radius %g", light, g->kind,
                         from_center, (double)b->radius);
        }
        host_free(gpu_host(harness_device()), hull, sizeof *hull);
    }
    print_message("%u lit points lie in their lights' proxies and spheres\n", inside);
    assert_true(inside > 5000);
}

/* Volumes of proxy and bounding sphere of shapes whose fit is known. */
static void test_proxies_fit(void **state) {
    UNUSED(state);
    fnl_light_params l = fnl_light_params_default();
    l.range = 10;
    l.direction = vec3_make(0, 0, -1);
    static const struct {
        fnl_light_kind kind;
        float angle, most; /* most: proxy to sphere, by volume */
    } cases[] = {{FNL_LIGHT_POINT, 0, 1.92f},     {FNL_LIGHT_SPOT, 0.05f, 0.007f},  {FNL_LIGHT_SPOT, 0.3f, 0.24f},
                 {FNL_LIGHT_SPOT, PI / 2, 0.96f}, {FNL_LIGHT_WEDGE, 0.05f, 0.002f}, {FNL_LIGHT_WEDGE, 1.5f, 0.24f},
                 {FNL_LIGHT_CAPSULE, 0, 0.13f},   {FNL_LIGHT_BOX, 0, 0.0025f}};
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        l.kind = cases[i].kind;
        l.outer_cone_angle = l.wedge_angles[0] = cases[i].angle;
        l.wedge_angles[1] = 0.3f * cases[i].angle;
        l.length = 60;
        l.box_size = vec3_make(20, 1, 0.4f);
        struct gpu_light g;
        struct gpu_entity_bounds b;
        device_light(&l, 0, &g, &b);
        vec3 corners[8];
        shape_corners(&g.shape, &b, corners);
        double sphere = 4 / 3.0 * (double)PI * pow((double)b.radius, 3), part = volume_of(corners) / sphere;
        print_message("kind %d, %g rad: proxy takes %.4f of the sphere\n", (int)l.kind, (double)cases[i].angle, part);
        assert_true(part < (double)cases[i].most && part > (double)cases[i].most * 0.5);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        {"ES-5: lights of all shapes give exactly nothing from their range on, and tell lists what shading gets",
         test_answers, NULL, harness_check, NULL},
        {"spheres and proxies hold all that a light lights", test_proxies, NULL, harness_check, NULL},
        {"proxies of narrow lights are far smaller than their spheres", test_proxies_fit, NULL, harness_check, NULL},
    };
    return cmocka_run_group_tests_name("light volumes", tests, ask_begin, ask_end);
}
