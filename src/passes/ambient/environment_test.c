/* SPDX-License-Identifier: MIT */
/** The maps of an environment against sums in double precision on the CPU. */
#include "passes/ambient/environment.h"
#include "fanal/image.h"
#include "image/bc6h.h"
#include "scene/scene_environment.h"
#include "tests/render_harness.h"
#include "tests/stand_in.h"

#include <unistd.h>

enum { MOST_MIPS = 12 };

/* What is on the device, read back. */
struct maps {
    uint32_t side, last;
    float *mips[MOST_MIPS]; /* RGB, faces one after the other */
    struct gpu_environment light;
};

struct copy_data {
    graph_buffer from[2], to[2];
    uint64_t size[2];
};

static void execute_copy(const struct graph_context *context, const void *data) {
    const struct copy_data *d = data;
    for (int i = 0; i < 2; i++)
        gpu_copy_buffer(context->commands, graph_get_buffer(context, d->from[i]), 0, graph_get_buffer(context, d->to[i]), 0, d->size[i]);
}

static struct maps filter(const struct panorama *p, bool compressed) {
    gpu_device *device = harness_device();
    const size_t count = (size_t)p->width * p->height;
    uint16_t *pixels = calloc(count, 8);
    struct environment_maps device_maps = {0};
    struct graph *graph;
    assert_non_null(pixels);
    for (size_t i = 0; i < count; i++)
        for (size_t c = 0; c < 3; c++) pixels[4 * i + c] = half_from_float(p->texels[3 * i + c]);
    assert_int_equal(environment_prepare(device, pixels, p->width, p->height, compressed, &device_maps), FNL_OK);
    assert_int_equal(gpu_upload_flush(device), FNL_OK);
    free(pixels);
    struct maps out = {.side = device_maps.side, .last = environment_last_mip(device_maps.side)};
    uint64_t texel_count = 0;
    for (uint32_t mip = 0; out.side >> mip && (!compressed || mip <= out.last); mip++) texel_count += 6ull * (out.side >> mip) * (out.side >> mip);
    struct copy_data copy = {.size = {texel_count * (compressed ? 1 : 8), sizeof out.light}};
    struct gpu_buffer read[2];
    assert_int_equal(graph_create(gpu_host(device), device, &graph), FNL_OK);
    for (int i = 0; i < 2; i++) assert_int_equal(gpu_buffer_create(device, "read", copy.size[i], GPU_MEMORY_READBACK, &read[i]), FNL_OK);
    graph_begin(graph);
    assert_int_equal(gpu_frame_begin(device), FNL_OK);
    const struct environment_light light = environment_add(graph, device, &device_maps, true);
    copy.from[0] = compressed ? light.blocks : light.texels;
    copy.from[1] = light.light;
    struct graph_pass *pass = NULL;
    for (int i = 0; i < 2; i++) copy.to[i] = graph_import_buffer(graph, i ? "light read" : "texels read", &read[i]);
    pass = graph_add_pass(graph, "read", GRAPH_QUEUE_GRAPHICS, execute_copy, &copy, sizeof copy);
    for (int i = 0; i < 2; i++) {
        graph_use_buffer(pass, copy.from[i], GRAPH_COPY_FROM);
        graph_use_buffer(pass, copy.to[i], GRAPH_COPY_TO);
    }
    pass = graph_add_pass(graph, "host", GRAPH_QUEUE_GRAPHICS, NULL, NULL, 0);
    for (int i = 0; i < 2; i++) graph_use_buffer(pass, copy.to[i], GRAPH_READ_HOST);
    assert_int_equal(graph_compile(graph), FNL_OK);
    assert_int_equal(graph_execute_frame(graph, NULL), FNL_OK);
    assert_int_equal(gpu_wait_idle(device), FNL_OK);
    memcpy(&out.light, read[1].mapped, sizeof out.light);
    const uint16_t *halves = read[0].mapped;
    const unsigned char *blocks = read[0].mapped;
    for (uint32_t mip = 0; mip <= out.last; mip++) {
        const uint32_t side = out.side >> mip;
        const size_t texels = 6 * (size_t)side * side;
        out.mips[mip] = malloc(texels * 3 * sizeof(float));
        assert_non_null(out.mips[mip]);
        if (compressed) {
            float *rgba = malloc(texels * 4 * sizeof(float));
            assert_non_null(rgba);
            bc6h_decode_picture(blocks, false, side, 6 * side, rgba); /* faces are whole blocks: one below the other */
            for (size_t i = 0; i < texels * 3; i++) out.mips[mip][i] = rgba[i / 3 * 4 + i % 3];
            free(rgba);
            blocks += texels; /* 16 bytes for 16 texels */
            continue;
        }
        for (size_t i = 0; i < texels; i++)
            for (size_t c = 0; c < 3; c++) out.mips[mip][3 * i + c] = half_to_float(halves[4 * i + c]);
        halves += 4 * texels;
    }
    graph_destroy(&graph);
    for (int i = 0; i < 2; i++) gpu_buffer_destroy(device, &read[i]);
    environment_finish_maps(device, &device_maps);
    return out;
}

static void maps_free(struct maps *m) {
    for (uint32_t mip = 0; mip <= m->last; mip++) free(m->mips[mip]);
}

/* ---- the reference ---- */

struct dvec {
    double x, y, z;
};

static double dot3(struct dvec a, struct dvec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static struct dvec unit(struct dvec a) {
    const double scale = 1 / sqrt(dot3(a, a));
    return (struct dvec){a.x * scale, a.y * scale, a.z * scale};
}
static struct dvec cross3(struct dvec a, struct dvec b) { return (struct dvec){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
static struct dvec blend3(struct dvec a, double s, struct dvec b, double t, struct dvec c, double u) {
    return (struct dvec){a.x * s + b.x * t + c.x * u, a.y * s + b.y * t + c.y * u, a.z * s + b.z * t + c.z * u};
}

/* Of one mip, with bilinear filtering inside the face. */
static void look(const struct maps *m, uint32_t mip, struct dvec d, double out[3]) {
    const double x = fabs(d.x), y = fabs(d.y), z = fabs(d.z);
    const uint32_t side = m->side >> mip;
    uint32_t face;
    double u, v, most;
    if (x >= y && x >= z) face = d.x < 0, u = d.x < 0 ? d.z : -d.z, v = -d.y, most = x;
    else if (y >= z) face = 2 + (d.y < 0), u = d.x, v = d.y < 0 ? -d.z : d.z, most = y;
    else face = 4 + (d.z < 0), u = d.z < 0 ? -d.x : d.x, v = -d.y, most = z;
    const double at[2] = {CLAMP((u / most + 1) / 2 * side - 0.5, 0.0, side - 1.0), CLAMP((v / most + 1) / 2 * side - 0.5, 0.0, side - 1.0)};
    const uint32_t x0 = (uint32_t)at[0], y0 = (uint32_t)at[1], x1 = MIN(x0 + 1, side - 1), y1 = MIN(y0 + 1, side - 1);
    const double fx = at[0] - x0, fy = at[1] - y0;
    const float *texels = m->mips[mip] + 3 * (size_t)face * side * side;
    for (int c = 0; c < 3; c++)
        out[c] = ((double)texels[3 * (y0 * side + x0) + (uint32_t)c] * (1 - fx) + (double)texels[3 * (y0 * side + x1) + (uint32_t)c] * fx) * (1 - fy) +
                 ((double)texels[3 * (y1 * side + x0) + (uint32_t)c] * (1 - fx) + (double)texels[3 * (y1 * side + x1) + (uint32_t)c] * fx) * fy;
}

/* What a surface that faces the viewer mirrors: 65 536 samples of the GGX lobe. */
static void mirror(const struct maps *m, struct dvec axis, double roughness, double out[3]) {
    enum { COUNT = 65536 };
    const double alpha = roughness * roughness;
    const struct dvec side = unit(cross3(fabs(axis.y) < 0.9 ? (struct dvec){0, 1, 0} : (struct dvec){1, 0, 0}, axis)), up = cross3(axis, side);
    double weight = 0;
    out[0] = out[1] = out[2] = 0;
    for (uint32_t i = 0; i < COUNT; i++) {
        uint32_t bits = i;
        double radical = 0;
        for (double half = 0.5; bits; bits >>= 1, half /= 2) radical += bits & 1 ? half : 0;
        const double angle = 2 * (double)PI * (i + 0.5) / COUNT, cosine = sqrt((1 - radical) / (1 + (alpha * alpha - 1) * radical));
        const double sine = sqrt(fmax(1 - cosine * cosine, 0)), n_l = 2 * cosine * cosine - 1;
        if (n_l <= 0) continue;
        double texel[3];
        look(m, 0, blend3(side, 2 * cosine * sine * cos(angle), up, 2 * cosine * sine * sin(angle), axis, n_l), texel);
        for (int c = 0; c < 3; c++) out[c] += n_l * texel[c];
        weight += n_l;
    }
    for (int c = 0; c < 3; c++) out[c] /= weight;
}

/* What a white diffuse surface reflects: the panorama itself, each texel by its solid angle. */
static void diffuse(const struct panorama *p, struct dvec normal, double out[3]) {
    out[0] = out[1] = out[2] = 0;
    for (uint32_t y = 0; y < p->height; y++) {
        const double step = (double)PI / p->height, angle = 2 * (double)PI / p->width * (cos(step * y) - cos(step * (y + 1)));
        for (uint32_t x = 0; x < p->width; x++) {
            const vec3 d = panorama_direction(p, (float)x, (float)y);
            const double cosine = dot3(normal, (struct dvec){(double)d.x, (double)d.y, (double)d.z}) * angle / (double)PI;
            if (cosine <= 0) continue;
            for (int c = 0; c < 3; c++) out[c] += cosine * (double)p->texels[3 * ((size_t)y * p->width + x) + (size_t)c];
        }
    }
}

static void from_harmonics(const struct gpu_environment *e, struct dvec n, double out[3]) {
    const double basis[9] = {1, n.y, n.z, n.x, n.x * n.y, n.y * n.z, 3 * n.z * n.z - 1, n.x * n.z, n.x * n.x - n.y * n.y};
    out[0] = out[1] = out[2] = 0;
    for (int b = 0; b < 9; b++) {
        out[0] += basis[b] * (double)e->diffuse[b].x;
        out[1] += basis[b] * (double)e->diffuse[b].y;
        out[2] += basis[b] * (double)e->diffuse[b].z;
    }
}

/* ---- pictures ---- */

/* A sample, or its stand-in, at half its size, without its bright sources. */
static struct panorama load(const char *file, uint32_t *source_count) {
    const fnl_host host = fnl_host_default();
    fnl_image image = stand_in_or_sample(file);
    struct panorama p = {image.width, image.height, malloc((size_t)image.width * image.height * 12)};
    struct panorama_source sources[ENVIRONMENT_LIGHTS_MAX];
    assert_non_null(p.texels);
    for (size_t i = 0; i < (size_t)p.width * p.height; i++)
        for (size_t c = 0; c < 3; c++) p.texels[3 * i + c] = ((const float *)image.pixels)[4 * i + c];
    free(image.pixels);
    assert_int_equal(panorama_part(&host, &p, sources, source_count), FNL_OK);
    return p;
}

static struct dvec place_of(uint32_t number) { /* on the sphere, well inside a face */
    struct random_state random = {number * 7 + 1};
    for (;;) {
        double c[3], most = 0;
        for (int i = 0; i < 3; i++) c[i] = (double)random_float(&random) * 2 - 1;
        for (int i = 0; i < 3; i++) most = fmax(most, fabs(c[i]));
        int inside = 0;
        for (int i = 0; i < 3; i++) inside += fabs(c[i]) < 0.74 * most;
        if (most > 0.1 && inside == 2) return unit((struct dvec){c[0], c[1], c[2]});
    }
}

/* As shading finds it: widths of lobes in double precision. */
static double width_of(double roughness) {
    enum { COUNT = 20000 };
    const double alpha2 = pow(fmax(roughness * roughness, 1e-3), 2);
    double sum = 0, weight = 0;
    for (uint32_t i = 0; i < COUNT; i++) {
        const double u = (i + 0.5) / COUNT, n_l = 2 * (1 - u) / (1 + (alpha2 - 1) * u) - 1;
        if (n_l <= 0) break;
        sum += n_l * (1 - n_l);
        weight += n_l;
    }
    return sum / weight;
}

static double table_mip(const struct maps *m, double roughness) {
    const double width = width_of(roughness);
    uint32_t mip = 0;
    while (mip + 1 < m->last && width_of((double)environment_roughness(mip + 1, m->last)) < width) mip++;
    const double low = mip ? width_of((double)environment_roughness(mip, m->last)) : 0, high = width_of((double)environment_roughness(mip + 1, m->last));
    return mip + (width - low) / (high - low);
}

/* Mips between which shading reads; relative RMSE over all directions. */
static double mirror_error(const struct maps *m, double roughness, uint32_t places) {
    const double lod = table_mip(m, roughness);
    const uint32_t low = MIN((uint32_t)lod, m->last - 1);
    double error = 0, sum = 0;
    for (uint32_t i = 0; i < places; i++) {
        double want[3], a[3], b[3];
        const struct dvec axis = place_of(i);
        mirror(m, axis, roughness, want);
        look(m, low, axis, a);
        look(m, low + 1, axis, b);
        for (int c = 0; c < 3; c++) {
            const double got = a[c] + (b[c] - a[c]) * (lod - low);
            error += (got - want[c]) * (got - want[c]);
            sum += want[c] * want[c];
        }
    }
    return sqrt(error / sum);
}

static void check_picture(const char *file) {
    uint32_t sources;
    struct panorama p = load(file, &sources);
    struct maps m = filter(&p, false);
    double worst = 0, between = 0, error = 0, sum = 0;
    for (uint32_t mip = 1; mip <= m.last; mip++) {
        const double roughness = (double)environment_roughness(mip, m.last), before = (double)environment_roughness(mip - 1, m.last);
        const double off = mirror_error(&m, roughness, 12);
        if (roughness >= 0.1) worst = fmax(worst, off);
        print_message("  mip %u, roughness %.3f: %.2f %%\n", mip, roughness, 100 * off);
        if (mip > 1) between = fmax(between, mirror_error(&m, (roughness + before) / 2, 12));
    }
    for (uint32_t i = 0; i < 24; i++) {
        double want[3], got[3];
        diffuse(&p, place_of(i), want);
        from_harmonics(&m.light, place_of(i), got);
        for (int c = 0; c < 3; c++) {
            error += (got[c] - want[c]) * (got[c] - want[c]);
            sum += want[c] * want[c];
        }
    }
    print_message("%s: %u sources; mirrored %.2f %%, between mips %.2f %%; diffuse %.2f %%\n", file, sources, 100 * worst, 100 * between,
                  100 * sqrt(error / sum));
    assert_true(worst < 0.02);
    assert_true(between < 0.15); /* lobes are blended, which those of lamps show */
    assert_true(sqrt(error / sum) < 0.03);
    maps_free(&m);
    free(p.texels);
}

static void test_maps_hold_what_surfaces_reflect_MP_12_EN_2_EN_3_MB_10(void **state) {
    UNUSED(state);
    check_picture("spiaggia_di_mondello_1k.hdr");
    check_picture("peppermint_powerplant_1k.hdr");
    check_picture("venice_sunset_256.hdr");
}

/* Blocks hold what filtering gave, mip by mip, and light that is the same from everywhere. */
static void test_cubes_are_compressed_BC_14(void **state) {
    UNUSED(state);
    for (int even = 0; even < 2; even++) {
        uint32_t sources;
        struct panorama p = load("venice_sunset_256.hdr", &sources);
        for (size_t i = 0; even && i < (size_t)p.width * p.height * 3; i++) p.texels[i] = i % 3 == 0 ? 2 : 0.7f;
        struct maps want = filter(&p, false), got = filter(&p, true);
        for (uint32_t mip = 0; mip <= want.last; mip++) {
            double error = 0, sum = 0;
            for (size_t i = 0; i < 18 * (size_t)(want.side >> mip) * (want.side >> mip); i++) {
                error += pow((double)got.mips[mip][i] - (double)want.mips[mip][i], 2);
                sum += pow((double)want.mips[mip][i], 2);
            }
            print_message("mip %u: %.3f %% off\n", mip, 100 * sqrt(error / sum));
            assert_true(sqrt(error / sum) < (even ? 1e-3 : 0.03));
        }
        maps_free(&want);
        maps_free(&got);
        free(p.texels);
    }
}

/* Light that is the same from everywhere stays so: in all mips, and in the harmonics. */
static void test_a_constant_picture_stays_constant_MP_12(void **state) {
    UNUSED(state);
    struct panorama p = {130, 65, calloc((size_t)130 * 65 * 3, sizeof(float))};
    assert_non_null(p.texels);
    for (size_t i = 0; i < (size_t)130 * 65 * 3; i++) p.texels[i] = i % 3 == 0 ? 2 : 0.5f;
    struct maps m = filter(&p, false);
    for (uint32_t mip = 0; mip <= m.last; mip++)
        for (size_t i = 0; i < 18 * (size_t)(m.side >> mip) * (m.side >> mip); i++)
            assert_float_equal(m.mips[mip][i], (i % 3 == 0 ? 2 : 0.5f), 2e-3f);
    for (uint32_t i = 0; i < 12; i++) {
        double got[3];
        from_harmonics(&m.light, place_of(i), got);
        assert_float_equal((float)got[0], 2, 4e-3f);
        assert_float_equal((float)got[1], 0.5f, 1e-3f);
    }
    maps_free(&m);
    free(p.texels);
}

/* A cube map that fnl_image_compress makes of the panorama has the same faces. */
static void compare_compressed(const struct panorama *p, const struct maps *m) {
    const size_t count = (size_t)p->width * p->height, texels = 6 * (size_t)m->side * m->side;
    char path[] = "/tmp/fanal-environment-XXXXXX.dds";
    float *pixels = malloc(count * 16);
    fnl_image image = {p->width, p->height, FNL_PIXEL_FORMAT_RGBA32F, pixels}, cube;
    fnl_compress_params params = fnl_compress_params_default();
    const int file = mkstemps(path, 4);
    double sum = 0;
    assert_non_null(pixels);
    assert_true(file >= 0);
    close(file);
    for (size_t i = 0; i < 4 * count; i++) pixels[i] = i % 4 == 3 ? 1 : p->texels[i / 4 * 3 + i % 4];
    params.quality = FNL_COMPRESS_FAST;
    params.cube_size = m->side;
    assert_int_equal(fnl_image_compress(NULL, path, &image, &params, NULL), FNL_OK);
    assert_int_equal(fnl_image_load(NULL, path, &cube), FNL_OK);
    unlink(path);
    assert_true(cube.width == m->side && cube.height == 6 * m->side);
    for (size_t i = 0; i < 3 * texels; i++) {
        const float got = ((const float *)cube.pixels)[i / 3 * 4 + i % 3], off = fabsf(got - m->mips[0][i]);
        if (off > 0.05f) fail_msg("face %zu, texel %zu: %g, not %g", i / 3 / (texels / 6), i / 3 % (texels / 6), (double)got, (double)m->mips[0][i]);
        sum += (double)off;
    }
    print_message("compressed faces: %.5f off on average\n", sum / (double)(3 * texels));
    assert_true(sum / (double)(3 * texels) < 0.01);
    fnl_image_free(NULL, &cube);
    free(pixels);
}

/* Faces look where Vulkan's cube maps do: six coloured axes. */
static void test_faces_look_along_their_axes_MP_11(void **state) {
    UNUSED(state);
    struct panorama p = {256, 128, calloc((size_t)256 * 128 * 3, sizeof(float))};
    assert_non_null(p.texels);
    for (uint32_t y = 0; y < p.height; y++)
        for (uint32_t x = 0; x < p.width; x++) {
            const vec3 d = panorama_direction(&p, (float)x, (float)y);
            float *texel = p.texels + 3 * ((size_t)y * p.width + x);
            texel[0] = d.x + 1, texel[1] = d.y + 1, texel[2] = d.z + 1;
        }
    struct maps m = filter(&p, false);
    compare_compressed(&p, &m);
    for (uint32_t i = 0; i < 40; i++) {
        const struct dvec d = place_of(i);
        double got[3], mirrored[3];
        look(&m, 0, d, got);
        assert_float_equal((float)got[0], (float)d.x + 1, 0.01f);
        assert_float_equal((float)got[1], (float)d.y + 1, 0.01f);
        assert_float_equal((float)got[2], (float)d.z + 1, 0.01f);
        look(&m, 1, d, mirrored); /* a blurred gradient is the same gradient, fainter */
        assert_true(fabs(mirrored[0] - got[0]) < 0.03 && fabs(mirrored[1] - got[1]) < 0.03 && fabs(mirrored[2] - got[2]) < 0.03);
    }
    maps_free(&m);
    free(p.texels);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_cubes_are_compressed_BC_14, harness_check),
        cmocka_unit_test_teardown(test_maps_hold_what_surfaces_reflect_MP_12_EN_2_EN_3_MB_10, harness_check),
        cmocka_unit_test_teardown(test_a_constant_picture_stays_constant_MP_12, harness_check),
        cmocka_unit_test_teardown(test_faces_look_along_their_axes_MP_11, harness_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
