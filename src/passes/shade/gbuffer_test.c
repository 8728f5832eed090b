/* SPDX-License-Identifier: MIT */
/** Layouts of the G-buffer: every field there and back, pictures against forward shading, encodings of normals, chroma, material IDs, and
 *  what is lit forward. */
#include "passes/shade/gbuffer_layouts.h"
#include "passes/shade/gbuffer_test_shared.h"
#include "shaders.h"
#include "tests/render_harness.h"

/* ---- every field, there and back ---- */

enum { CASES = 4096, ENTRIES = 2048 };

static struct gpu_gbuffer_case cases[CASES], results[CASES];
static struct gpu_material_entry entries[ENTRIES];

static void execute_test(const struct graph_context *context, const void *data) {
    const struct gpu_gbuffer_test_push *push = data;
    struct gpu_compute_params params = {.shader = &shader_gbuffer_test_comp};
    gpu_bind(context->commands, gpu_compute_pipeline(context->device, &params));
    gpu_push(context->commands, push, sizeof *push);
    gpu_dispatch_linear(context->commands, DIVIDE_UP(CASES, 64));
}

static void execute_nothing(const struct graph_context *context, const void *data) {
    UNUSED(context);
    UNUSED(data);
}

static void ask_device(struct gpu_gbuffer_test_push push) {
    gpu_device *device = harness_device();
    struct graph *graph;
    struct gpu_buffer buffers[3];
    static const char *const names[] = {"test cases", "test entries", "test results"};
    const uint64_t sizes[] = {sizeof cases, sizeof entries, sizeof results};
    graph_buffer handles[3];
    assert_int_equal(graph_create(gpu_host(device), device, &graph), FNL_OK);
    graph_begin(graph);
    for (int i = 0; i < 3; i++) {
        assert_int_equal(
            gpu_buffer_create(device, names[i], sizes[i], i == 2 ? GPU_MEMORY_READBACK : GPU_MEMORY_UPLOAD, &buffers[i]),
            FNL_OK);
        handles[i] = graph_import_buffer(graph, names[i], &buffers[i]);
    }
    memcpy(buffers[0].mapped, cases, sizeof cases);
    memcpy(buffers[1].mapped, entries, sizeof entries);
    assert_int_equal(gpu_frame_begin(device), FNL_OK);
    push.cases = buffers[0].address;
    push.entries = buffers[1].address;
    push.results = buffers[2].address;
    push.count = CASES;
    struct graph_pass *pass = graph_add_pass(graph, "pack", GRAPH_QUEUE_GRAPHICS, execute_test, &push, sizeof push);
    for (int i = 0; i < 3; i++) graph_use_buffer(pass, handles[i], i == 2 ? GRAPH_WRITE_COMPUTE : GRAPH_READ_COMPUTE);
    struct graph_pass *host = graph_add_pass(graph, "to host", GRAPH_QUEUE_GRAPHICS, execute_nothing, NULL, 0);
    graph_keep(host);
    graph_use_buffer(host, handles[2], GRAPH_READ_HOST);
    assert_int_equal(graph_compile(graph), FNL_OK);
    assert_int_equal(graph_execute_frame(graph, NULL), FNL_OK);
    assert_int_equal(gpu_wait_idle(device), FNL_OK);
    memcpy(results, buffers[2].mapped, sizeof results);
    graph_destroy(&graph);
    for (int i = 0; i < 3; i++) gpu_buffer_destroy(device, &buffers[i]);
}

static uint32_t rounding_of(VkFormat format) {
    switch (format) {
    case VK_FORMAT_R8G8B8A8_SRGB:
        return ROUND_SRGB8;
    case VK_FORMAT_R16G16B16A16_UNORM:
    case VK_FORMAT_R16G16_UNORM:
        return ROUND_UNORM16;
    case VK_FORMAT_A2B10G10R10_UNORM_PACK32:
        return ROUND_UNORM10;
    case VK_FORMAT_R16G16B16A16_SFLOAT:
    case VK_FORMAT_R16G16_SFLOAT:
        return ROUND_HALF;
    default:
        return ROUND_UNORM8;
    }
}

/* Lowest, middle or highest; later cases take anything. */
static float pick(struct random_state *random, uint32_t i) {
    float u = random_float(random);
    return i >= CASES / 2 ? u : u < 1 / 3.0f ? 0 : u < 2 / 3.0f ? 0.5f : 1;
}

/* Surfaces that the layout can hold. */
static void make_cases(const struct gbuffer_layout *l) {
    struct random_state random = {23};
    for (uint32_t i = 0; i < ENTRIES; i++) {
        float tint = 0.2f * random_float(&random);
        entries[i] =
            (struct gpu_material_entry){{tint, i % 3 ? tint : 0.08f, 0.04f}, i % 5 ? 1 : 0.25f, i % 7 ? 0 : 1, i % 4};
    }
    for (uint32_t i = 0; i < CASES; i++) {
        struct gpu_gbuffer_case *c = &cases[i];
        float z = random_range(&random, 0.02f, 1), angle = random_range(&random, -PI, PI), across = sqrtf(1 - z * z);
        *c = (struct gpu_gbuffer_case){.roughness = pick(&random, i), .occlusion = pick(&random, i)};
        c->base_color = (vec3){pick(&random, i), pick(&random, i), pick(&random, i)};
        c->motion = (vec3){pick(&random, i) * 2 - 1, pick(&random, i) * 2 - 1, pick(&random, i) * 2 - 1};
        c->position =
            (vec3){random_range(&random, -40, 40), random_range(&random, -30, 30), -random_range(&random, 0.3f, 900)};
        /* Towards the viewer of the pixel, and down the axis of the view: encodings of that half alone hold it. */
        c->normal = (vec3){across * cosf(angle), across * sinf(angle), z};
        vec3 to_view = vec3_normalize(vec3_scale(c->position, -1));
        if (vec3_dot(c->normal, to_view) < 0.02f) c->normal = to_view;
        c->id = l->id_count ? i % l->id_count : 0;
        const struct gpu_material_entry *e = &entries[c->id];
        if (l->layers) {
            vec3 other = {random_range(&random, -1, 1), random_range(&random, -1, 1), random_range(&random, -1, 1)};
            c->coat = i % 4 ? pick(&random, i) : 0;
            c->coat_roughness = pick(&random, i);
            c->coat_normal = vec3_normalize(other);
            c->anisotropy = i % 3 ? pick(&random, i) : 0;
            c->tangent = vec3_normalize(vec3_cross(c->normal, i % 5 ? other : (vec3){(float)(i % 2), (float)(i / 2 % 2), 0.5f}));
        }
        if (l->tint) {
            c->metallic = pick(&random, i);
            c->dielectric_f90 = pick(&random, i);
            c->dielectric_f0 = (vec3){pick(&random, i), pick(&random, i), pick(&random, i)};
        } else if (l->id_count) {
            bool strength = l->strength && e->second & GBUFFER_SECOND_STRENGTH;
            c->metallic = l->metallic && e->second & GBUFFER_SECOND_METALLIC ? pick(&random, i) : e->metallic;
            c->dielectric_f90 = strength ? pick(&random, i) : e->dielectric_f90;
            c->dielectric_f0 = vec3_scale(e->dielectric_f0, c->dielectric_f90);
        } else {
            float grey = fmaxf(pick(&random, i), 0.04f);
            c->dielectric_f90 = 1;
            c->dielectric_f0 = (vec3){grey, grey, grey};
        }
    }
}

static double srgb(double c) { return c <= 0.0031308 ? 12.92 * c : 1.055 * pow(c, 1 / 2.4) - 0.055; }

static double degrees_between(vec3 a, vec3 b) {
    vec3 c = {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
    return atan2((double)vec3_length(c), (double)vec3_dot(a, b)) * 57.29577951308232;
}

static double off(float a, float b) { return fabs((double)a - (double)b); }
static double off3(vec3 a, vec3 b) { return fmax(off(a.x, b.x), fmax(off(a.y, b.y), off(a.z, b.z))); }

struct field_errors {
    double color, normal, roughness, metallic, occlusion, f0, f90, motion, position, coat, coat_normal, anisotropy, tangent;
};

/* A component of a base colour on the scale on which the layout rounds it. */
static double color_code(const struct gbuffer_layout *l, float c) {
    return l->tint ? sqrt((double)c) : srgb((double)c);
}

static struct field_errors measure(const struct gbuffer_layout *l) {
    struct field_errors e = {0};
    for (uint32_t i = 0; i < CASES; i++) {
        const struct gpu_gbuffer_case *c = &cases[i], *r = &results[i];
        const float *in = &c->base_color.x, *out = &r->base_color.x;
        for (int k = 0; k < 3; k++) e.color = fmax(e.color, fabs(color_code(l, in[k]) - color_code(l, out[k])));
        e.normal = fmax(e.normal, degrees_between(c->normal, r->normal));
        e.roughness = fmax(e.roughness, off(c->roughness, r->roughness));
        e.metallic = fmax(e.metallic, off(c->metallic, r->metallic));
        e.occlusion = fmax(e.occlusion, off(c->occlusion, r->occlusion));
        vec3 a = c->dielectric_f0, b = r->dielectric_f0;
        e.f0 = fmax(e.f0, off3((vec3){sqrtf(a.x), sqrtf(a.y), sqrtf(a.z)}, (vec3){sqrtf(b.x), sqrtf(b.y), sqrtf(b.z)}));
        e.f90 = fmax(e.f90, off(c->dielectric_f90, r->dielectric_f90));
        e.motion = fmax(e.motion, off3(c->motion, r->motion));
        vec3 p = c->position, q = r->position;
        if (q.x == 0 && q.y == 0) p.x = p.y = 0; /* the depth alone */
        e.position = fmax(e.position, off3(p, q) / -(double)c->position.z);
        assert_int_equal(r->id, c->id);
        e.coat = fmax(e.coat, off(c->coat, r->coat));
        e.anisotropy = fmax(e.anisotropy, off(c->anisotropy, r->anisotropy));
        if (c->coat > 0) e.coat = fmax(e.coat, off(c->coat_roughness, r->coat_roughness));
        if (c->coat > 0) e.coat_normal = fmax(e.coat_normal, degrees_between(c->coat_normal, r->coat_normal));
        const double turned = c->anisotropy > 0 ? degrees_between(c->tangent, r->tangent) : 0;
        e.tangent = fmax(e.tangent, fmin(turned, 180 - turned)); /* either way along it */
        if (c->anisotropy > 0) assert_true(off(vec3_dot(r->tangent, r->normal), 0) < 1e-5 && off(vec3_length(r->tangent), 1) < 1e-5);
    }
    return e;
}

static void test_fields_round_trip(void **state) {
    UNUSED(state);
    const double half = 0.502 / 255, half10 = 0.502 / 1023, none = 1e-6;
    /* The most that each field may be off; motion of 2 is motion that is not there. Normals in degrees; colour as its square root where the layout
       stores that, else sRGB-encoded; F0 as its square root; position in parts of the view depth. Roughness of siege and frostbite2 has 8 bits where the second field is used. */
    static const double step16 = 0.51 / 65535;
    const struct field_errors most[FNL_GBUFFER_COUNT] = {
        [FNL_GBUFFER_DEFAULT] = {half10, 0.004, step16, half, half, half, half, 2, none, 0, 0, 0, 0},
        [FNL_GBUFFER_SIEGE] = {half, 0.1, half, half, half, 0.021, half, 1.01 / 127, none, 0, 0, 0, 0},
        [FNL_GBUFFER_KILLZONE2] = {half, 3, half, none, half, half, none, 2, none, 0, 0, 0, 0},
        [FNL_GBUFFER_FROSTBITE2] = {half, 0.42, half, half, half, 0.021, half, 2, none, 0, 0, 0, 0},
        [FNL_GBUFFER_STALKER] = {half, 0.05, half, none, 3e-4, none, none, 2, 1e-3 * 40, 0, 0, 0, 0},
        [FNL_GBUFFER_CLEAR_SKY] = {half, 3, half, none, 0.502 / 127, none, none, 2, 1e-3, 0, 0, 0, 0},
        [FNL_GBUFFER_ENGEL] = {half, 3, half, none, half, half, none, 2, none, 0, 0, 0, 0},
        [FNL_GBUFFER_DESTINY] = {half, 1.3, 2.0 / 255, none, half, none, none, 2, none, 0, 0, 0, 0},
        [FNL_GBUFFER_LAYERS] = {half10, 0.004, step16, half, half, half, half, 2, none, step16, 0.004, step16, 0.008},
    };
    for (int layout = 0; layout < FNL_GBUFFER_COUNT; layout++) {
        const struct gbuffer_layout *l = &gbuffer_layouts[layout];
        struct gpu_gbuffer_test_push push = {.form = gbuffer_form_of((fnl_gbuffer)layout, FNL_NORMALS_LAYOUT, false)};
        for (uint32_t t = 0; t < l->target_count; t++) push.formats |= rounding_of(l->targets[t].format) << 4 * t;
        make_cases(l);
        ask_device(push);
        struct field_errors e = measure(l);
        print_message(
            "%-10s colour %.2g, normal %.3g degrees, roughness %.2g, metalness %.2g, occlusion %.2g, F0 %.2g, F90 %.2g, "
            "motion %.2g, position %.2g, coat %.2g, its normal %.3g degrees, anisotropy %.2g, its direction %.3g degrees\n",
            fnl_value_name(FNL_ENUM_GBUFFER, (uint32_t)layout), e.color, e.normal, e.roughness, e.metallic, e.occlusion, e.f0, e.f90, e.motion, e.position, e.coat, e.coat_normal, e.anisotropy, e.tangent);
        const double *got = &e.color, *limit = &most[layout].color;
        for (uint32_t k = 0; k < sizeof e / sizeof(double); k++)
            if (got[k] > limit[k]) fail_msg("%s: field %u is off by %g, not %g", fnl_value_name(FNL_ENUM_GBUFFER, (uint32_t)layout), k, got[k], limit[k]);
    }
}

/* Flat colours of all kinds through luma and chroma: within one step of 255 of what the plain layout holds. */
static void test_flat_colors_ES_13(void **state) {
    UNUSED(state);
    struct random_state random = {31};
    static uint8_t codes[CASES][3];
    for (uint32_t i = 0; i < CASES; i++) {
        cases[i] = (struct gpu_gbuffer_case){.normal = {0, 0, 1}, .position = {0, 0, -1}};
        float color[3];
        for (int k = 0; k < 3; k++) {
            static const uint32_t powers[] = {1, 3, 9};
            codes[i][k] = (uint8_t)(i < 27 ? 127.5f * (float)(i / powers[k] % 3) : random_range(&random, 0, 256));
            double c = codes[i][k] / 255.0;
            color[k] = (float)(c <= 0.04045 ? c / 12.92 : pow((c + 0.055) / 1.055, 2.4));
        }
        cases[i].base_color = (vec3){color[0], color[1], color[2]};
    }
    ask_device((struct gpu_gbuffer_test_push){.form = gbuffer_form_of(FNL_GBUFFER_DEFAULT, FNL_NORMALS_LAYOUT, true)});
    double worst = 0;
    for (uint32_t i = 0; i < CASES; i++) {
        const vec3 *r = &results[i].base_color;
        worst = fmax(worst, fabs(round(255 * (double)r->x) - codes[i][0]));
        worst = fmax(worst, fabs(round(255 * (double)r->y) - codes[i][1]));
        worst = fmax(worst, fabs(round(255 * (double)r->z) - codes[i][2]));
    }
    print_message("flat colours are off by %.0f/255 at most\n", worst);
    assert_true(worst <= 1);
}

/* ---- pictures ---- */

static double mean_difference(const fnl_image *a, const fnl_image *b) {
    const uint8_t *p = a->pixels, *q = b->pixels;
    uint64_t sum = 0, count = (uint64_t)a->width * a->height * 4;
    for (uint64_t i = 0; i < count; i++) sum += (uint64_t)abs(p[i] - q[i]);
    return (double)sum / (double)count * 4 / 3;
}

/* What a layout's quantisation may do to the picture of glossy spheres: greatest difference but for one pixel of 200, and mean, in 1/255. */
static const struct {
    int most;
    double mean;
} tolerances[FNL_GBUFFER_COUNT] = {
    [FNL_GBUFFER_DEFAULT] = {1, 0.15},   [FNL_GBUFFER_SIEGE] = {2, 0.15},   [FNL_GBUFFER_KILLZONE2] = {2, 0.15},
    [FNL_GBUFFER_FROSTBITE2] = {4, 0.3}, [FNL_GBUFFER_STALKER] = {2, 0.15}, [FNL_GBUFFER_CLEAR_SKY] = {2, 0.15},
    [FNL_GBUFFER_ENGEL] = {2, 0.15},     [FNL_GBUFFER_DESTINY] = {4, 0.3},  [FNL_GBUFFER_LAYERS] = {1, 0.15},
};

static void check_lists(struct stage *stage, fnl_frame frame, const struct shot *all) {
    static const fnl_light_lists lists[] = {FNL_LISTS_TILED, FNL_LISTS_CLUSTERED, FNL_LISTS_BACKFACE,
                                            FNL_LISTS_FINE,  FNL_LISTS_SPARSE,    FNL_LISTS_ZBIN};
    for (uint32_t i = 0; i < COUNT_OF(lists); i++) {
        frame.lists = lists[i];
        struct shot shot = stage_shoot(stage, &frame);
        if (count_differing(&all->radiance, &shot.radiance))
            fail_msg("%s: %s differ from all", fnl_value_name(FNL_ENUM_GBUFFER, frame.gbuffer.layout), fnl_value_name(FNL_ENUM_LISTS, lists[i]));
        shot_free(&shot);
    }
}

/* Every layout against forward shading; and all lists and ways to run deferred lighting against one another, to the bit. */
static void test_layouts_equal_forward(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:spheres?lights=12", 0);
    fnl_frame frame = stage.frame;
    frame.width = 117;
    frame.height = 67;
    frame.lists = FNL_LISTS_ALL;
    frame.shading = FNL_SHADING_FORWARD_PREPASS;
    struct shot forward = stage_shoot(&stage, &frame);
    for (int layout = 0; layout < FNL_GBUFFER_COUNT; layout++) {
        frame.gbuffer.layout = (fnl_gbuffer)layout;
        frame.shading = FNL_SHADING_DEFERRED;
        struct shot all = stage_shoot(&stage, &frame);
        assert_int_equal(count_broken(&all.radiance), 0);
        uint64_t beyond = count_beyond(&forward.color, &all.color, tolerances[layout].most);
        double mean = mean_difference(&forward.color, &all.color);
        print_message("%-10s %3d/255 at most, mean %.4f, %llu pixels beyond %d\n", fnl_value_name(FNL_ENUM_GBUFFER, frame.gbuffer.layout),
                      greatest_difference(&forward.color, &all.color), mean, (unsigned long long)beyond,
                      tolerances[layout].most);
        assert_true(beyond * 200 <= frame.width * frame.height && mean <= tolerances[layout].mean);
        /* Pipelines take long to make; what follows does not know one layout from another. */
        if (layout != FNL_GBUFFER_CLEAR_SKY && layout != FNL_GBUFFER_KILLZONE2) {
            shot_free(&all);
            continue;
        }
        check_lists(&stage, frame, &all);
        frame.deferred.class_blocks = 8;
        struct shot classes = stage_shoot(&stage, &frame);
        assert_int_equal(count_differing(&all.radiance, &classes.radiance), 0);
        shot_free(&classes);
        frame.deferred.class_blocks = 0;
        frame.shading = FNL_SHADING_DEFERRED_VOLUMES;
        struct shot volumes = stage_shoot(&stage, &frame);
        assert_true(greatest_difference(&all.color, &volumes.color) <= 2);
        shot_free(&volumes);
        shot_free(&all);
    }
    shot_free(&forward);
    stage_close(&stage);
}

/* ---- normals ---- */

static void test_encodings_in_pictures(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:spheres?lights=12", 0);
    fnl_frame frame = stage.frame;
    frame.width = 97;
    frame.height = 55;
    frame.lists = FNL_LISTS_ALL;
    static const fnl_gbuffer layouts[] = {FNL_GBUFFER_DEFAULT, FNL_GBUFFER_FROSTBITE2, FNL_GBUFFER_STALKER};
    for (uint32_t i = 0; i < COUNT_OF(layouts); i++) {
        frame.gbuffer.layout = layouts[i];
        frame.gbuffer.normals = FNL_NORMALS_FLOAT;
        struct shot exact = stage_shoot(&stage, &frame);
        fnl_gbuffer_info info;
        assert_int_equal(fnl_gbuffer_query_info(frame.gbuffer.layout, &info), FNL_OK);
        for (int e = FNL_NORMALS_LAYOUT; e < FNL_NORMALS_FLOAT; e++) {
            frame.gbuffer.normals = (fnl_normal_encoding)e;
            if (!(info.encodings >> e & 1)) {
                assert_int_equal(fnl_renderer_render(stage.renderer, &frame), FNL_ERROR_UNSUPPORTED);
                continue;
            }
            struct shot shot = stage_shoot(&stage, &frame);
            double mean = mean_difference(&exact.color, &shot.color);
            print_message("%-10s %-13s %3d/255 at most, mean %.4f\n", fnl_value_name(FNL_ENUM_GBUFFER, frame.gbuffer.layout),
                          fnl_value_name(FNL_ENUM_NORMALS, frame.gbuffer.normals), greatest_difference(&exact.color, &shot.color), mean);
            /* 16 bits show no difference to speak of, half floats hardly one; 8 bits turn highlights. */
            bool lossy = e == FNL_NORMALS_XY || e == FNL_NORMALS_SPHERE_MAP;
            double allowed = frame.gbuffer.layout == FNL_GBUFFER_FROSTBITE2 ? 0.6 : lossy ? 0.15 : 0.05;
            if (frame.gbuffer.normals == FNL_NORMALS_BEST_FIT) allowed = 0.05;
            assert_true(mean < allowed);
            shot_free(&shot);
        }
        shot_free(&exact);
    }
    stage_close(&stage);
}

/* ---- scenes of squares ---- */

struct square {
    fnl_material_params material;
    float x, y, z, half;
};

static fnl_scene *squares_scene(const struct square *squares, uint32_t count) {
    static const float positions[] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
    static const uint32_t indices[] = {0, 1, 2, 0, 2, 3};
    fnl_scene *scene;
    assert_int_equal(fnl_scene_create(NULL, &scene), FNL_OK);
    for (uint32_t i = 0; i < count; i++) {
        const struct square *s = &squares[i];
        fnl_mesh_params mesh = {.vertex_count = 4, .index_count = 6, .positions = positions, .indices = indices};
        fnl_mesh_id mesh_id;
        fnl_instance_id instance;
        assert_int_equal(fnl_scene_add_material(scene, &s->material, &mesh.material), FNL_OK);
        assert_int_equal(fnl_scene_add_mesh(scene, &mesh, &mesh_id), FNL_OK);
        fnl_mat4 matrix = {{s->half, 0, 0, 0, 0, s->half, 0, 0, 0, 0, 1, 0, s->x, s->y, s->z, 1}};
        assert_int_equal(fnl_scene_add_instance(scene, mesh_id, &matrix, &instance), FNL_OK);
    }
    assert_int_equal(fnl_scene_set_ambient(scene, (fnl_vec3){20, 20, 20}, (fnl_vec3){20, 20, 20}), FNL_OK);
    return scene;
}

/* From the front: the square -half .. half of the plane z = 0. */
static void front_camera(fnl_frame *frame, float half, uint32_t size) {
    frame->width = frame->height = size;
    frame->camera = fnl_camera_default();
    frame->camera.orthographic = true;
    frame->camera.vertical_extent = 2 * half;
    frame->camera.near_distance = 0.5f;
    frame->camera.far_distance = 60;
    frame->camera.position = (fnl_vec3){0, 0, 20};
    frame->camera.target = (fnl_vec3){0, 0, 0};
    frame->lists = FNL_LISTS_ALL;
    frame->ev = 4;
}

static fnl_material_params plastic(float r, float g, float b) {
    fnl_material_params m = fnl_material_params_default();
    m.metallic = 0;
    m.roughness = 0.6f;
    const float color[3] = {r, g, b};
    memcpy(m.base_color, color, sizeof color);
    return m;
}

/* ---- chroma ---- */

/* Squares of strong colours before a wall of another: chroma of one must not reach the other, be it over one pixel. */
static void test_no_bleeding_ES_13(void **state) {
    UNUSED(state);
    struct square squares[40] = {{plastic(0.1f, 0.8f, 0.15f), 0, 0, -9, 6}};
    struct random_state random = {3};
    for (uint32_t i = 1; i < COUNT_OF(squares); i++)
        squares[i] =
            (struct square){plastic(i % 2 ? 0.9f : 0.05f, 0.05f, i % 2 ? 0.05f : 0.9f), random_range(&random, -3, 3),
                            random_range(&random, -3, 3), (float)i * 0.25f, random_range(&random, 0.15f, 0.6f)};
    struct stage stage = stage_open_scene(squares_scene(squares, COUNT_OF(squares)));
    fnl_frame frame = stage.frame;
    front_camera(&frame, 3, 131);
    struct shot plain = stage_shoot(&stage, &frame);
    frame.gbuffer.chroma = true;
    struct shot chroma = stage_shoot(&stage, &frame);
    int most = greatest_difference(&plain.color, &chroma.color);
    print_message("with chroma the picture is off by %d/255 at most; %llu and %llu bytes\n", most,
                  (unsigned long long)counter(&plain.stats, "gbuffer.bytes"),
                  (unsigned long long)counter(&chroma.stats, "gbuffer.bytes"));
    assert_true(most <= 2); /* one for the colours, one for tone mapping */
    assert_int_equal(counter(&plain.stats, "gbuffer.bytes"), 16ull * 131 * 131);
    assert_int_equal(counter(&chroma.stats, "gbuffer.bytes"), 14ull * 131 * 131);
    shot_free(&plain);
    shot_free(&chroma);
    stage_close(&stage);
}

/* ---- base colour ---- */

/* A ramp of greys under flat light: deferred shading must not be brighter or darker than forward shading, which rounds no base colour. */
static void test_greys_keep_their_radiance(void **state) {
    UNUSED(state);
    enum { GREYS = 96, STEP = 4 };
    struct square squares[GREYS];
    for (uint32_t i = 0; i < GREYS; i++) {
        float grey = (float)(i + 5) / 100.0f; /* 0.05 .. 1, 0.5 among them */
        squares[i] = (struct square){plastic(grey, grey, grey), (float)i - (GREYS - 1) / 2.0f, 0, 0, 0.5f};
        squares[i].material.specular = 0;
    }
    struct stage stage = stage_open_scene(squares_scene(squares, GREYS));
    fnl_frame frame = stage.frame;
    front_camera(&frame, GREYS / 2.0f, GREYS * STEP);
    frame.shading = FNL_SHADING_FORWARD_PREPASS;
    struct shot forward = stage_shoot(&stage, &frame);
    frame.shading = FNL_SHADING_DEFERRED;
    struct shot deferred = stage_shoot(&stage, &frame);
    assert_int_equal(counter(&deferred.stats, "gbuffer.bytes"), 16ull * frame.width * frame.height);
    double sum = 0, worst = 0;
    for (uint32_t i = 0; i < GREYS; i++) {
        size_t at = 4 * ((size_t)frame.height / 2 * frame.width + i * STEP + STEP / 2);
        float a = ((const float *)forward.radiance.pixels)[at], b = ((const float *)deferred.radiance.pixels)[at];
        assert_true(a > 0);
        double gain = (double)b / (double)a;
        sum += gain;
        worst = fmax(worst, fabs(gain - 1));
        if (i == 45 && fabs(gain - 1) > 0.002) fail_msg("a grey of 0.5 is shown at %.4f of its radiance", gain);
    }
    print_message("greys keep %.5f of their radiance in the mean, off by %.4f at most\n", sum / GREYS, worst);
    assert_true(fabs(sum / GREYS - 1) < 0.001);
    assert_true(worst < 0.0055); /* at 0.05 half a step of 10 bits is 0.44 %; both radiances are half floats, rounded by 0.05 % */
    shot_free(&forward);
    shot_free(&deferred);
    stage_close(&stage);
}

/* ---- materials ---- */

/* 17 x 16 squares of as many materials side by side. Each pixel is what a scene of that material alone shows. */
static void test_material_ids_ES_11_MP_21(void **state) {
    UNUSED(state);
    enum { ROWS = 17, COLUMNS = 16, COUNT = ROWS * COLUMNS, STEP = 4 };
    struct square squares[COUNT];
    for (uint32_t i = 0; i < COUNT; i++) {
        fnl_material_params m = plastic(0.5f, 0.5f, 0.5f);
        m.metallic = i % 2 ? 1.0f : 0.0f;
        m.ior = 1.2f + 0.005f * (float)i;
        m.specular = i % 3 ? 1 : 0.5f;
        m.specular_color[1] = 0.3f + 0.7f * (float)i / COUNT;
        m.roughness = 0.2f + 0.7f * (float)i / COUNT;
        squares[i] = (struct square){m, (float)(i % COLUMNS) - 7.5f, 8.0f - (float)(i / COLUMNS), 0, 0.5f};
    }
    static const fnl_gbuffer layouts[] = {FNL_GBUFFER_SIEGE, FNL_GBUFFER_DESTINY, FNL_GBUFFER_FROSTBITE2,
                                          FNL_GBUFFER_STALKER, FNL_GBUFFER_CLEAR_SKY};
    struct stage stage = stage_open_scene(squares_scene(squares, COUNT));
    fnl_light_params light = fnl_light_params_default();
    light.position = (fnl_vec3){1, 2, 9};
    light.intensity = 900;
    fnl_light_id id;
    assert_int_equal(fnl_scene_add_light(stage.scene, &light, &id), FNL_OK);
    fnl_frame frame = stage.frame;
    front_camera(&frame, ROWS / 2.0f, ROWS * STEP);
    for (uint32_t k = 0; k < COUNT_OF(layouts); k++) {
        frame.gbuffer.layout = layouts[k];
        frame.debug = FNL_DEBUG_NONE;
        frame.count_lights = true;
        struct shot mixed = stage_shoot(&stage, &frame);
        /* IDs of 8 bits hold 256 materials; the others are lit forward. */
        assert_int_equal(counter(&mixed.stats, "gbuffer.items-forward"),
                         layouts[k] == FNL_GBUFFER_STALKER ? 0 : COUNT - 256);
        frame.debug = FNL_DEBUG_MATERIAL_ID;
        struct shot ids = stage_shoot(&stage, &frame);
        uint32_t colors[COUNT], distinct = 0;
        for (uint32_t i = 0; i < 256; i++) {
            uint32_t x = i % COLUMNS * STEP + STEP / 2 + STEP / 2, y = i / COLUMNS * STEP + STEP / 2;
            memcpy(&colors[i], (const uint8_t *)ids.color.pixels + (y * frame.width + x) * 4, 4);
            bool known = false;
            for (uint32_t j = 0; j < i; j++) known = known || colors[j] == colors[i];
            distinct += !known;
        }
        assert_int_equal(distinct, 256);
        shot_free(&ids);
        frame.debug = FNL_DEBUG_NONE;
        if (k > 1) { /* the rest of the test is about the mechanism, which is the same */
            shot_free(&mixed);
            continue;
        }
        static const uint32_t probes[] = {17, 18, 133, 134, 254, 255, 256, 257};
        for (uint32_t p = 0; p < COUNT_OF(probes); p++) {
            struct square alone = {squares[probes[p]].material, 0, 0, 0, 20};
            struct stage one = stage_open_scene(squares_scene(&alone, 1));
            assert_int_equal(fnl_scene_add_light(one.scene, &light, &id), FNL_OK);
            struct shot dedicated = stage_shoot(&one, &frame);
            uint64_t compared = 0, differing = 0;
            for (uint32_t y = 0; y < STEP; y++)
                for (uint32_t x = 0; x < STEP; x++) {
                    uint32_t px = probes[p] % COLUMNS * STEP + STEP / 2 + x, py = probes[p] / COLUMNS * STEP + y;
                    const float *a = (const float *)mixed.radiance.pixels + (py * frame.width + px) * 4,
                                *b = (const float *)dedicated.radiance.pixels + (py * frame.width + px) * 4;
                    compared++;
                    for (int c = 0; c < 3;
                         c++) /* where its ID does not fit it is the forward pass that is compared, to 2/255 */
                        if (probes[p] < 256 ? a[c] != b[c] : fabsf(a[c] / b[c] - 1) > 0.02f) {
                            differing++;
                            break;
                        }
                }
            if (differing)
                fail_msg("%s: material %u: %llu of %llu pixels differ", fnl_value_name(FNL_ENUM_GBUFFER, layouts[k]), probes[p],
                         (unsigned long long)differing, (unsigned long long)compared);
            shot_free(&dedicated);
            stage_close(&one);
        }
        shot_free(&mixed);
    }
    stage_close(&stage);
}

/* ---- lit forward ---- */

/* Two squares, one behind the other, as one item. */
static void add_folded(fnl_scene *scene, const fnl_material_params *material) {
    static const float positions[] = {-1, -1, 0.5f, 1, -1, 0.5f, 1, 1, 0.5f, -1, 1, 0.5f, -0.8f, -0.8f, 0, 1.2f, -0.8f, 0, 1.2f, 1.2f, 0, -0.8f, 1.2f, 0};
    static const uint32_t indices[] = {0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7};
    fnl_mesh_params mesh = {.vertex_count = 8, .index_count = 12, .positions = positions, .indices = indices};
    fnl_mesh_id mesh_id;
    fnl_instance_id instance;
    const fnl_mat4 matrix = {{0.4f, 0, 0, 0, 0, 0.4f, 0, 0, 0, 0, 0.4f, 0, 1.4f, -1.6f, 0.5f, 1}};
    assert_int_equal(fnl_scene_add_material(scene, material, &mesh.material), FNL_OK);
    assert_int_equal(fnl_scene_add_mesh(scene, &mesh, &mesh_id), FNL_OK);
    assert_int_equal(fnl_scene_add_instance(scene, mesh_id, &matrix, &instance), FNL_OK);
}

/* Plastic and metal, tinted and weak, with lights that reach everything: each pixel visits each of them exactly once. */
static void test_lit_once_FP_8(void **state) {
    UNUSED(state);
    enum { LIGHTS = 7 };
    struct square squares[12] = {{plastic(0.3f, 0.4f, 0.5f), 0, 0, -3, 2.5f}};
    for (uint32_t i = 1; i < COUNT_OF(squares); i++) {
        fnl_material_params m = plastic(0.8f, 0.2f + 0.05f * (float)i, 0.3f);
        if (i % 4 == 1) m.metallic = 1;
        if (i % 4 == 2) m.specular_color[0] = 0.5f;
        if (i % 4 == 3) m.specular = 0.5f;
        /* Some lie in one plane and overlap. */
        squares[i] = (struct square){m, -2.2f + 0.4f * (float)i, 0.3f * (float)(i % 3) - 0.3f, 0.1f * (float)(i / 2), 0.45f};
    }
    fnl_scene *scene = squares_scene(squares, COUNT_OF(squares));
    add_folded(scene, &squares[1].material);
    for (uint32_t i = 0; i < LIGHTS; i++) {
        fnl_light_params light = fnl_light_params_default();
        light.position = (fnl_vec3){(float)i - 3, 1, 4};
        light.intensity = 60;
        light.range = 60;
        fnl_light_id id;
        assert_int_equal(fnl_scene_add_light(scene, &light, &id), FNL_OK);
    }
    struct stage stage = stage_open_scene(scene);
    fnl_frame frame = stage.frame;
    front_camera(&frame, 3, 99);
    frame.count_lights = true;
    frame.outputs |= FNL_OUTPUT_POSITION;
    struct shot reference = {0};
    for (int layout = 0; layout < FNL_GBUFFER_COUNT; layout++)
        for (uint32_t blocks = 0; blocks <= (layout == FNL_GBUFFER_ENGEL ? 8 : 0); blocks += 8) {
            frame.gbuffer.layout = (fnl_gbuffer)layout;
            frame.deferred.class_blocks = blocks;
            struct shot shot = stage_shoot(&stage, &frame);
            uint64_t opaque = 0;
            for (uint32_t i = 0; i < frame.width * frame.height; i++)
                opaque += ((const fnl_vec4 *)shot.position.pixels)[i].w > 0;
            assert_true(opaque > 1000 && opaque < frame.width * frame.height);
            assert_int_equal(shot.stats.evaluations, opaque * LIGHTS);
            assert_int_equal(shot.stats.max_per_pixel, LIGHTS);
            bool plastic_alone = layout == FNL_GBUFFER_KILLZONE2 || layout == FNL_GBUFFER_ENGEL;
            assert_int_equal(counter(&shot.stats, "gbuffer.items-forward"), plastic_alone ? 10 : 0);
            /* A material that is lit forward looks as it does where the layout holds it. */
            if (layout == 0 && blocks == 0) {
                reference = shot;
                continue;
            }
            int most = greatest_difference(&reference.color, &shot.color);
            if (most > 3) fail_msg("%s, blocks of %u: %d/255 from default", fnl_value_name(FNL_ENUM_GBUFFER, frame.gbuffer.layout), blocks, most);
            shot_free(&shot);
        }
    shot_free(&reference);
    /* The view of them shows the squares that the layout cannot hold, and nothing else. */
    frame.deferred.class_blocks = 0;
    frame.gbuffer.layout = FNL_GBUFFER_ENGEL;
    frame.debug = FNL_DEBUG_LIT_FORWARD;
    struct shot seen = stage_shoot(&stage, &frame);
    uint64_t white = 0, grey = 0, black = 0;
    for (uint32_t i = 0; i < frame.width * frame.height; i++) {
        const uint8_t *p = (const uint8_t *)seen.color.pixels + i * 4;
        white += p[0] == 255;
        grey += p[0] == 64;
        black += p[0] == 0;
    }
    assert_true(white > 500 && grey > 500 && black > 500 && white + grey + black == frame.width * frame.height);
    shot_free(&seen);
    stage_close(&stage);
}

/* A full-screen draw behind a stencil gives the bits of the dispatch that looks at depth and mask, and visits as many lights. */
static void test_stencil_FP_15(void **state) {
    UNUSED(state);
    static const fnl_gbuffer layouts[] = {FNL_GBUFFER_DEFAULT, FNL_GBUFFER_ENGEL};
    static const fnl_light_lists lists[] = {FNL_LISTS_ALL, FNL_LISTS_TILED, FNL_LISTS_FINE};
    static const char *const scenes[] = {"builtin:spheres?lights=12", "builtin:glass"};
    for (uint32_t s = 0; s < COUNT_OF(scenes); s++) {
        struct stage stage = stage_open(scenes[s], 0);
        fnl_frame frame = stage.frame;
        frame.width = 101;
        frame.height = 59;
        frame.count_lights = true;
        for (uint32_t i = 0; i < COUNT_OF(layouts); i++)
            for (uint32_t l = 0; l < COUNT_OF(lists); l++) {
                frame.gbuffer.layout = layouts[i];
                frame.lists = lists[l];
                frame.deferred.pass = FNL_DEFERRED_COMPUTE;
                struct shot compute = stage_shoot(&stage, &frame);
                frame.deferred.pass = FNL_DEFERRED_FRAGMENT;
                struct shot fragment = stage_shoot(&stage, &frame);
                char plan[65536];
                assert_true(fnl_renderer_print(stage.renderer, FNL_PRINT_PLAN, plan, sizeof plan) < sizeof plan);
                assert_non_null(strstr(plan, "'deferred stencil'"));
                assert_int_equal(count_differing(&compute.radiance, &fragment.radiance), 0);
                assert_int_equal(compute.stats.evaluations, fragment.stats.evaluations);
                assert_int_equal(compute.stats.max_per_pixel, fragment.stats.max_per_pixel);
                shot_free(&compute);
                shot_free(&fragment);
            }
        frame.deferred.class_blocks = 8;
        assert_int_equal(fnl_renderer_render(stage.renderer, &frame), FNL_ERROR_UNSUPPORTED);
        stage_close(&stage);
    }
}

/* ---- views, sizes ---- */

static void test_views_and_errors(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:spheres?lights=3", 0);
    fnl_frame frame = stage.frame;
    frame.width = 64;
    frame.height = 36;
    for (int layout = 0; layout < FNL_GBUFFER_COUNT; layout++) {
        fnl_gbuffer_info info;
        assert_int_equal(fnl_gbuffer_query_info((fnl_gbuffer)layout, &info), FNL_OK);
        uint32_t bits = 0;
        for (uint32_t i = 0; i < info.field_count; i++) {
            assert_true(info.fields[i].target < info.target_count);
            bits += info.fields[i].bits;
        }
        /* Clear Sky's half float has patterns that are no numbers: 1 of its bits tells nothing. */
        assert_int_equal(bits, layout == FNL_GBUFFER_CLEAR_SKY ? info.bits - 1 : info.bits);
        frame.gbuffer.layout = (fnl_gbuffer)layout;
        for (int view = FNL_DEBUG_GBUFFER_0; view <= FNL_DEBUG_LIT_FORWARD; view++) {
            frame.debug = (fnl_debug_view)view;
            bool wanted = view <= FNL_DEBUG_GBUFFER_4 ? (uint32_t)(view - FNL_DEBUG_GBUFFER_0) < info.target_count
                                                      : view == FNL_DEBUG_LIT_FORWARD || info.material_count;
            if (!wanted) {
                assert_int_equal(fnl_renderer_render(stage.renderer, &frame), FNL_ERROR_UNSUPPORTED);
                continue;
            }
            struct shot shot = stage_shoot(&stage, &frame);
            shot_free(&shot);
        }
    }
    frame.debug = FNL_DEBUG_NONE;
    frame.gbuffer.layout = FNL_GBUFFER_ENGEL;
    frame.gbuffer.chroma = true;
    assert_int_equal(fnl_renderer_render(stage.renderer, &frame), FNL_ERROR_UNSUPPORTED);
    frame.gbuffer.chroma = false;
    frame.gbuffer.normals = FNL_NORMALS_BEST_FIT;
    assert_int_equal(fnl_renderer_render(stage.renderer, &frame), FNL_ERROR_UNSUPPORTED);
    fnl_gbuffer_info engel;
    assert_int_equal(fnl_gbuffer_query_info(FNL_GBUFFER_ENGEL, &engel), FNL_OK);
    assert_int_equal(engel.published_bits, 20 * 8);
    stage_close(&stage);
}

int main(void) {
#define TEST(name, function)                                                                                                \
    { name, function, NULL, harness_check, NULL }
    const struct CMUnitTest tests[] = {
        TEST("ES-9, ES-10, ES-11, ES-12, MP-20, MP-21: every field, there and back", test_fields_round_trip),
        TEST("ES-13: flat colours within 1/255", test_flat_colors_ES_13),
        TEST("ES-9, ES-10, FP-8: every layout equals forward, all lists alike", test_layouts_equal_forward),
        TEST("ES-12, TD-13: encodings of normals in pictures", test_encodings_in_pictures),
        TEST("ES-13: no chroma over edges of depth", test_no_bleeding_ES_13),
        TEST("greys keep their radiance", test_greys_keep_their_radiance),
        TEST("ES-11, MP-21: neighbours of different materials, 256 of them", test_material_ids_ES_11_MP_21),
        TEST("FP-8: every pixel is lit once", test_lit_once_FP_8),
        TEST("FP-15: the same bits behind a stencil", test_stencil_FP_15),
        TEST("ES-10, MP-20: views and sizes", test_views_and_errors),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
