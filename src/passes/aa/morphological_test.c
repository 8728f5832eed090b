/* SPDX-License-Identifier: MIT */
/** Morphological antialiasing and SMAA: small pictures of known shapes, a slow reference, and how near they come to true coverage. */
#include "passes/aa/morphological.h"
#include "passes/aa/morphological_shared.h"
#include "tests/render_test.h"

enum method { MLAA, SMAA };

/* ---- pictures ---- */

struct picture {
    uint32_t width, height;
    uint8_t *pixels; /* RGBA */
};

static struct picture picture_create(uint32_t width, uint32_t height) {
    struct picture p = {width, height, calloc((size_t)width * height, 4)};
    assert_non_null(p.pixels);
    for (size_t i = 0; i < (size_t)width * height; i++) p.pixels[i * 4 + 3] = 255;
    return p;
}

static void set_grey(struct picture *p, uint32_t x, uint32_t y, uint8_t value) {
    memset(p->pixels + ((size_t)y * p->width + x) * 4, value, 3);
}

static uint8_t grey(const struct picture *p, uint32_t x, uint32_t y) { return p->pixels[((size_t)y * p->width + x) * 4]; }

/* Rows of text: '#' is white, the rest black. */
static struct picture picture_of(const char *const *rows, uint32_t count) {
    struct picture p = picture_create((uint32_t)strlen(rows[0]), count);
    for (uint32_t y = 0; y < count; y++)
        for (uint32_t x = 0; x < p.width; x++) set_grey(&p, x, y, rows[y][x] == '#' ? 255 : 0);
    return p;
}

static double decode(double c) { return c <= 0.04045 ? c / 12.92 : pow((c + 0.055) / 1.055, 2.4); }
static double encode(double c) { return c <= 0.0031308 ? 12.92 * c : 1.055 * pow(c, 1 / 2.4) - 0.055; }
static double light(const struct picture *p, uint32_t x, uint32_t y) { return decode(grey(p, x, y) / 255.0); }

/* ---- running the passes ---- */

struct copy_data {
    graph_image image;
    graph_buffer buffer;
};

static void execute_copy(const struct graph_context *context, const void *data) {
    const struct copy_data *d = data;
    gpu_copy_image_to_buffer(context->commands, graph_get_image(context, d->image), graph_get_buffer(context, d->buffer), 0);
}

static void execute_nothing(const struct graph_context *context, const void *data) {
    UNUSED(context);
    UNUSED(data);
}

static struct picture antialias_as(const struct picture *in, enum method method, struct morphological_params shapes) {
    struct gpu_image image;
    struct gpu_buffer buffer;
    struct graph *graph;
    uint64_t size = (uint64_t)in->width * in->height * 4;
    struct gpu_image_params params = {.name = "picture",
                                      .format = VK_FORMAT_R8G8B8A8_UNORM,
                                      .width = in->width,
                                      .height = in->height,
                                      .layers = 1,
                                      .mips = 1,
                                      .samples = 1,
                                      .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT};
    assert_int_equal(gpu_image_create(test_device, &params, &image), FNL_OK);
    assert_int_equal(gpu_upload_image(test_device, &image, in->pixels, size, false, false), FNL_OK);
    assert_int_equal(gpu_upload_flush(test_device), FNL_OK);
    assert_int_equal(gpu_buffer_create(test_device, "result", size, GPU_MEMORY_READBACK, &buffer), FNL_OK);
    assert_int_equal(graph_create(gpu_host(test_device), test_device, &graph), FNL_OK);
    assert_int_equal(gpu_frame_begin(test_device), FNL_OK);
    graph_begin(graph);
    graph_image picture = graph_import_image(graph, &image, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL,
                                             VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
    graph_image result = method == MLAA ? mlaa_add(graph, picture, &shapes) : smaa_add(graph, picture, &shapes);
    struct copy_data copy = {result, graph_import_buffer(graph, "result", &buffer)};
    struct graph_pass *pass = graph_add_pass(graph, "read", GRAPH_QUEUE_GRAPHICS, execute_copy, &copy, sizeof copy);
    graph_use_image(pass, result, GRAPH_COPY_FROM);
    graph_use_buffer(pass, copy.buffer, GRAPH_COPY_TO);
    pass = graph_add_pass(graph, "to host", GRAPH_QUEUE_GRAPHICS, execute_nothing, NULL, 0);
    graph_use_buffer(pass, copy.buffer, GRAPH_READ_HOST);
    assert_int_equal(graph_compile(graph), FNL_OK);
    struct graph_execute_params execute = {.poison = true};
    assert_int_equal(graph_execute_frame(graph, &execute), FNL_OK);
    assert_int_equal(gpu_frame_wait(test_device, gpu_frame_number(test_device)), FNL_OK);
    struct picture out = picture_create(in->width, in->height);
    memcpy(out.pixels, buffer.mapped, size);
    graph_destroy(&graph);
    gpu_buffer_destroy(test_device, &buffer);
    gpu_image_destroy(test_device, &image);
    return out;
}

static struct picture antialias(const struct picture *in, enum method method, bool swap) {
    return antialias_as(in, method, (struct morphological_params){.swap = swap});
}

/* ---- the reference: one pixel after the other, one edge after the other ---- */

static const uint8_t *pixel(const struct picture *p, int x, int y) {
    x = CLAMP(x, 0, (int)p->width - 1);
    y = CLAMP(y, 0, (int)p->height - 1);
    return p->pixels + ((size_t)y * p->width + (size_t)x) * 4;
}

static double luma(const struct picture *p, int x, int y) {
    const uint8_t *c = pixel(p, x, y);
    return (0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2]) / 255;
}

static double contrast(const struct picture *p, enum method method, int x0, int y0, int x1, int y1) {
    const uint8_t *a = pixel(p, x0, y0), *b = pixel(p, x1, y1);
    if (method == SMAA) return fabs(luma(p, x0, y0) - luma(p, x1, y1));
    double most = 0;
    for (int c = 0; c < 3; c++) most = fmax(most, abs(a[c] - b[c]) / 255.0);
    return most;
}

/* Is there an edge between a pixel and the one on its left (dx = 1) or above it (dy = 1)? */
static bool edge(const struct picture *p, enum method method, int x, int y, int dx, int dy) {
    if (x < dx || y < dy || x < 0 || y < 0 || x >= (int)p->width || y >= (int)p->height) return false;
    double delta = contrast(p, method, x, y, x - dx, y - dy);
    if (delta <= MORPHOLOGICAL_THRESHOLD) return false;
    if (method == MLAA) return true;
    const int beside[6][4] = {{x, y, x - 1, y}, {x, y, x, y - 1},     {x, y, x + 1, y},
                              {x, y, x, y + 1}, {x - 1, y, x - 2, y}, {x, y - 1, x, y - 2}};
    double most = 0;
    for (int k = 0; k < 6; k++) most = fmax(most, contrast(p, SMAA, beside[k][0], beside[k][1], beside[k][2], beside[k][3]));
    return delta >= 0.5 * most - 1e-4;
}

/* The same with the axes changed for vertical lines: `line` is the row below the edge, `at` the column. */
static bool along(const struct picture *p, enum method m, bool vertical, int line, int at) {
    return vertical ? edge(p, m, line, at, 1, 0) : edge(p, m, at, line, 0, 1);
}
static bool across(const struct picture *p, enum method m, bool vertical, int line, int at) {
    return vertical ? edge(p, m, at == 0 ? -1 : line, at, 0, 1) : edge(p, m, at, at == 0 ? -1 : line, 1, 0);
}

static double triangle(double half, double k) {
    double sum = 0;
    enum { STEPS = 1000 };
    for (int i = 0; i < STEPS; i++) {
        double x = k + (i + 0.5) / STEPS;
        if (x < half) sum += 0.5 * (1 - x / half);
    }
    return sum / STEPS;
}

/* `side` 1: the pixel behind the line, 0: before it. */
static double reference_weight(const struct picture *p, enum method m, bool vertical, int line, int at, int side) {
    if (!along(p, m, vertical, line, at)) return 0;
    int first = at, last = at;
    while (along(p, m, vertical, line, first - 1)) {
        if (m == SMAA && (across(p, m, vertical, line, first) || across(p, m, vertical, line - 1, first))) break;
        first--;
    }
    while (along(p, m, vertical, line, last + 1)) {
        if (m == SMAA && (across(p, m, vertical, line, last + 1) || across(p, m, vertical, line - 1, last + 1))) break;
        last++;
    }
    int ends[2] = {first, last + 1};
    bool crossed[2][2]; /* end, side */
    for (int e = 0; e < 2; e++)
        for (int s = 0; s < 2; s++) crossed[e][s] = across(p, m, vertical, line - 1 + s, ends[e]);
    double weight = 0, half = 0.5 * (last - first + 1);
    for (int e = 0; e < 2; e++) {
        bool both = crossed[e][0] && crossed[e][1], other_one = crossed[!e][0] != crossed[!e][1];
        bool here = crossed[e][side] && !both;
        if (m == SMAA && both && other_one) here = !crossed[!e][side];
        if (!here) continue;
        double area = triangle(half, e ? last - at : at - first);
        if (m == SMAA && across(p, m, vertical, side ? line + 1 : line - 2, ends[e])) area *= 0.25;
        weight += area;
    }
    return weight;
}

/* Without diagonals. */
static struct picture reference(const struct picture *in, enum method m) {
    struct picture out = picture_create(in->width, in->height);
    for (int y = 0; y < (int)in->height; y++)
        for (int x = 0; x < (int)in->width; x++) {
            double w[4] = {reference_weight(in, m, false, y, x, 1), reference_weight(in, m, false, y + 1, x, 0),
                           reference_weight(in, m, true, x, y, 1), reference_weight(in, m, true, x + 1, y, 0)};
            bool upright = w[0] + w[1] >= w[2] + w[3] - 1e-4;
            double a = upright ? w[0] : w[2], b = upright ? w[1] : w[3];
            const uint8_t *self = pixel(in, x, y), *before = upright ? pixel(in, x, y - 1) : pixel(in, x - 1, y),
                          *after = upright ? pixel(in, x, y + 1) : pixel(in, x + 1, y);
            for (int c = 0; c < 3; c++) {
                double value =
                    decode(self[c] / 255.0) * (1 - a - b) + decode(before[c] / 255.0) * a + decode(after[c] / 255.0) * b;
                out.pixels[((size_t)y * in->width + (size_t)x) * 4 + (size_t)c] =
                    a + b > 0 ? (uint8_t)lrint(encode(value) * 255) : self[c];
            }
        }
    return out;
}

static int difference(const struct picture *a, const struct picture *b) {
    int most = 0;
    for (size_t i = 0; i < (size_t)a->width * a->height * 4; i++) most = MAX(most, abs(a->pixels[i] - b->pixels[i]));
    return most;
}

/* ---- tests ---- */

/* Slopes below the threshold, flat colour, noise of small steps: the same bits, at odd sizes down to one pixel. */
static void test_no_edge_no_change_MP_25(void **state) {
    UNUSED(state);
    static const uint32_t sizes[][2] = {{1, 1}, {1, 77}, {65, 1}, {33, 31}, {129, 67}};
    for (uint32_t i = 0; i < COUNT_OF(sizes); i++) {
        struct picture in = picture_create(sizes[i][0], sizes[i][1]);
        struct random_state random = {i + 1};
        for (uint32_t y = 0; y < in.height; y++)
            for (uint32_t x = 0; x < in.width; x++)
                for (int c = 0; c < 3; c++)
                    in.pixels[(y * in.width + x) * 4 + (uint32_t)c] = (uint8_t)(100 + 25 * random_float(&random));
        for (int m = MLAA; m <= SMAA; m++) {
            struct picture out = antialias(&in, m, false);
            assert_int_equal(difference(&in, &out), 0);
            free(out.pixels);
        }
        free(in.pixels);
    }
}

/* A stair that descends by one pixel in eight: white beside black by the formula, and an even ramp from step to step. */
static void test_step_of_eight_ramps_by_the_formula_MP_25(void **state) {
    UNUSED(state);
    struct picture in = picture_create(80, 24);
    for (uint32_t y = 0; y < in.height; y++)
        for (uint32_t x = 0; x < in.width; x++) set_grey(&in, x, y, y > 6 + x / 8 ? 255 : 0);
    for (int m = MLAA; m <= SMAA; m++) {
        struct picture out = antialias(&in, m, false);
        for (uint32_t step = 1; step < 9; step++) {
            uint32_t row = 6 + step; /* the last black one at this step */
            double before = 2;
            for (uint32_t k = 0; k < 8; k++) {
                /* The true border crosses the rows' common line in the middle: white reaches up on the left, black down on the right. */
                double white = k < 4 ? 0.5 * (1 - (k + 0.5) / 4) : 0, black = k < 4 ? 0 : 0.5 * (1 - (7 - k + 0.5) / 4);
                double upper = light(&out, step * 8 + k, row), lower = light(&out, step * 8 + k, row + 1);
                assert_true(fabs(upper - white) < 0.005);
                assert_true(fabs(lower - (1 - black)) < 0.005);
                assert_true(upper + lower < before);
                before = upper + lower;
            }
        }
        /* Values of a linear picture are light already. */
        struct picture linear = antialias_as(&in, m, (struct morphological_params){.linear = true});
        for (uint32_t i = 0; i < in.width * in.height; i++)
            assert_true(fabs(linear.pixels[i * 4] / 255.0 - decode(out.pixels[i * 4] / 255.0)) < 0.006);
        free(linear.pixels);
        free(out.pixels);
    }
    free(in.pixels);
}

/* The upper row of a line is blended towards the lower one where an edge crosses it, and the other way round. */
static void test_shapes_Z_U_L_MP_25(void **state) {
    UNUSED(state);
    static const struct {
        const char *name, *rows[5];
        int row, percent[10];
    } cases[] = {
        /* Four pixels, crossed above on the left, below on the right. */
        {"Z", {"........", "##......", "######..", "########"}, 1, {100, 75, 38, 13, 0, 0, 0, 0}},
        {"Z", {"........", "##......", "######..", "########"}, 2, {100, 100, 100, 100, 88, 63, 25, 0}},
        /* Crossed above at both ends; of four pixels, and of three: the middle one gets two small triangles. */
        {"U", {"..........", "###....###", "##########"}, 1, {100, 96, 67, 38, 13, 13, 38, 67, 96, 100}},
        {"U", {"..........", "###....###", "##########"}, 2, {100, 100, 100, 100, 100, 100, 100, 100, 100, 100}},
        {"U of three", {".......", "##...##", "#######"}, 1, {100, 75, 33, 8, 33, 75, 100}},
        /* Crossed at one end; the other ends at the border of the picture. */
        {"L", {"........", "####....", "########"}, 1, {100, 100, 88, 63, 38, 13, 0, 0}},
        {"none", {"........", "........", "########"}, 1, {0, 0, 0, 0, 0, 0, 0, 0}},
        /* A dot fades by half: one axis counts. */
        {"dot", {".....", "..#..", "....."}, 1, {0, 0, 50, 0, 0}},
    };
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        uint32_t count = 0;
        while (count < 5 && cases[i].rows[count]) count++;
        struct picture in = picture_of(cases[i].rows, count), turned = picture_create(in.height, in.width);
        for (uint32_t y = 0; y < in.height; y++)
            for (uint32_t x = 0; x < in.width; x++) set_grey(&turned, y, x, grey(&in, x, y));
        struct picture out = antialias(&in, MLAA, false), turned_out = antialias(&turned, MLAA, false);
        for (uint32_t x = 0; x < in.width; x++) {
            int found = (int)lrint(light(&out, x, (uint32_t)cases[i].row) * 100);
            if (abs(found - cases[i].percent[x]) > 1)
                print_error("%s, row %d, pixel %u: %d%%, not %d%%\n", cases[i].name, cases[i].row, x, found,
                            cases[i].percent[x]);
            assert_true(abs(found - cases[i].percent[x]) <= 1);
        }
        /* The other axis does the same. */
        for (uint32_t y = 0; y < in.height; y++)
            for (uint32_t x = 0; x < in.width; x++) assert_int_equal(grey(&turned_out, y, x), grey(&out, x, y));
        free(in.pixels);
        free(turned.pixels);
        free(out.pixels);
        free(turned_out.pixels);
    }
}

static void compare_with_reference(const struct picture *in, enum method m) {
    struct picture out = antialias(in, m, false), expected = reference(in, m);
    for (uint32_t y = 0; y < in->height; y++)
        for (uint32_t x = 0; x < in->width; x++)
            if (abs(grey(&out, x, y) - grey(&expected, x, y)) > 1)
                print_error("%ux%u, pixel %u, %u: %u, not %u, of %u\n", in->width, in->height, x, y, grey(&out, x, y),
                            grey(&expected, x, y), grey(in, x, y));
    assert_true(difference(&out, &expected) <= 1);
    assert_true(in->width == 2 || difference(in, &out) > 20);
    free(out.pixels);
    free(expected.pixels);
}

/* Random dots of few colours, and rectangles whose lines are longer than a word of the edges' bits. */
static void test_mlaa_equals_reference_MP_25(void **state) {
    UNUSED(state);
    static const uint32_t sizes[][2] = {{2, 2}, {31, 45}, {32, 33}, {97, 64}, {131, 67}};
    for (uint32_t i = 0; i < COUNT_OF(sizes); i++)
        for (int kind = 0; kind < 2; kind++) {
            struct picture in = picture_create(sizes[i][0], sizes[i][1]);
            struct random_state random = {i * 2 + (uint32_t)kind + 7};
            for (uint32_t y = 0; y < in.height; y++)
                for (uint32_t x = 0; x < in.width; x++)
                    if (kind == 0) set_grey(&in, x, y, (uint8_t)(85 * (int)(4 * random_float(&random))));
            for (int r = 0; kind == 1 && r < 12; r++) {
                uint32_t x0 = (uint32_t)(random_float(&random) * (float)in.width),
                         y0 = (uint32_t)(random_float(&random) * (float)in.height);
                uint32_t x1 = x0 + 1 + (uint32_t)(random_float(&random) * 110), y1 = y0 + 1 + r * r;
                uint8_t color[3] = {(uint8_t)(random_float(&random) * 255), (uint8_t)(random_float(&random) * 255), 40};
                for (uint32_t y = y0; y < MIN(y1, in.height); y++)
                    for (uint32_t x = x0; x < MIN(x1, in.width); x++) memcpy(in.pixels + (y * in.width + x) * 4, color, 3);
            }
            compare_with_reference(&in, MLAA);
            free(in.pixels);
        }
}

/* Rectangles at even places: stairs of single steps, which make diagonals, do not occur. */
static void test_smaa_lines_equal_reference(void **state) {
    UNUSED(state);
    for (uint32_t i = 0; i < 4; i++) {
        struct picture in = picture_create(95 + i, 61 + i);
        struct random_state random = {i + 21};
        for (int r = 0; r < 40; r++) {
            uint32_t x0 = 2 * (uint32_t)(random_float(&random) * 47), y0 = 2 * (uint32_t)(random_float(&random) * 30),
                     x1 = x0 + 2 + 2 * (uint32_t)(random_float(&random) * 12),
                     y1 = y0 + 2 + 2 * (uint32_t)(random_float(&random) * 12);
            uint8_t value = (uint8_t)(random_float(&random) * 255);
            for (uint32_t y = y0; y < MIN(y1, in.height); y++)
                for (uint32_t x = x0; x < MIN(x1, in.width); x++) set_grey(&in, x, y, value);
        }
        compare_with_reference(&in, SMAA);
        free(in.pixels);
    }
}

/* Gentle slopes: both ends of runs of up to 60 pixels are found, lying and upright, and SMAA's search is 64 pixels each way. */
static void test_long_lines_equal_reference(void **state) {
    UNUSED(state);
    static const uint32_t runs[] = {24, 40, 60};
    for (uint32_t i = 0; i < 2 * COUNT_OF(runs); i++) {
        bool upright = i & 1;
        uint32_t run = runs[i / 2], length = 4 * run + 7, across = 12;
        struct picture in = upright ? picture_create(across, length) : picture_create(length, across);
        for (uint32_t at = 0; at < length; at++)
            for (uint32_t side = 0; side < across; side++)
                set_grey(&in, upright ? side : at, upright ? at : side, side < 3 + (at + 5) / run ? 230 : 20);
        compare_with_reference(&in, MLAA);
        compare_with_reference(&in, SMAA);
        free(in.pixels);
    }
}

/* ---- how near it comes to coverage ---- */

static double inside(double x, double y, double angle, double offset, int shape) {
    if (shape == 0) return x * cos(angle) + y * sin(angle) < offset; /* a half-plane */
    if (shape == 1) return hypot(x, y) < 20 + offset;                /* a disc */
    return fabs(x * cos(angle) + y * sin(angle) - offset) < 1.2;     /* a line of 2.4 pixels */
}

/* Sums the squared differences of none, MLAA and SMAA from the true coverage, in linear light. */
static void add_errors(double angle, double offset, int shape, double errors[3]) {
    enum { SIZE = 64, GRID = 8 };
    struct picture in = picture_create(SIZE, SIZE);
    static double truth[SIZE][SIZE];
    for (uint32_t y = 0; y < SIZE; y++)
        for (uint32_t x = 0; x < SIZE; x++) {
            double sum = 0, px = x - SIZE / 2.0, py = y - SIZE / 2.0;
            for (int s = 0; s < GRID * GRID; s++)
                sum += inside(px + (s % GRID + 0.5) / GRID, py + (s / GRID + 0.5) / GRID, angle, offset, shape);
            truth[y][x] = sum / (GRID * GRID);
            set_grey(&in, x, y, inside(px + 0.5, py + 0.5, angle, offset, shape) > 0 ? 255 : 0);
        }
    struct picture out[3] = {in, antialias(&in, MLAA, false), antialias(&in, SMAA, false)};
    for (uint32_t y = 8; y < SIZE - 8; y++)
        for (uint32_t x = 8; x < SIZE - 8; x++)
            for (int m = 0; m < 3; m++) errors[m] += pow(light(&out[m], x, y) - truth[y][x], 2);
    for (int m = 0; m < 3; m++) free(out[m].pixels);
}

static void test_quality_of_edges_MP_25(void **state) {
    UNUSED(state);
    static const char *const names[] = {"half-planes", "discs", "thin lines"};
    for (int shape = 0; shape < 3; shape++) {
        double errors[3] = {0};
        for (int i = 0; i < 24; i++) add_errors(0.03 + i * 0.2618 * 0.5, 0.13 * i - 1, shape, errors);
        print_message("%s: root of the sum of squared errors: none %.2f, mlaa %.2f, smaa %.2f\n", names[shape],
                      sqrt(errors[0]), sqrt(errors[1]), sqrt(errors[2]));
        assert_true(sqrt(errors[1]) < 0.6 * sqrt(errors[0]));
        assert_true(sqrt(errors[2]) < 1.05 * sqrt(errors[1]));
    }
    /* Just off 45 degrees the stairs have runs of one and now and then two: there the diagonals count. */
    double errors[3] = {0};
    for (int i = 0; i < 8; i++) add_errors(PI / 4 + 0.02 + 0.015 * i, 0.3 * i, 0, errors);
    print_message("near 45 degrees: none %.2f, mlaa %.2f, smaa %.2f\n", sqrt(errors[0]), sqrt(errors[1]), sqrt(errors[2]));
    assert_true(sqrt(errors[2]) < 0.6 * sqrt(errors[1]));
    /* A longer step after 20 to 30 single ones: both ends of such a diagonal are found. */
    double long_errors[3] = {0};
    for (int i = 0; i < 8; i++) add_errors(PI / 4 + 0.018 + 0.001 * i, 0.3 * i, 0, long_errors);
    print_message("long diagonals: none %.2f, mlaa %.2f, smaa %.2f\n", sqrt(long_errors[0]), sqrt(long_errors[1]),
                  sqrt(long_errors[2]));
    assert_true(sqrt(long_errors[2]) < 0.2 * sqrt(long_errors[0]));
}

/* A square keeps its corners but for a trace; blue steps, too dark for luma, are seen by their colour; BGRA makes no difference. */
static void test_corners_and_channels(void **state) {
    UNUSED(state);
    struct picture in = picture_create(40, 40);
    for (uint32_t y = 10; y < 30; y++)
        for (uint32_t x = 10; x < 30; x++) set_grey(&in, x, y, 255);
    struct picture rounded = antialias(&in, MLAA, false), sharp = antialias(&in, SMAA, false);
    assert_true(light(&rounded, 10, 10) < 0.55); /* half of it is cut off */
    assert_true(light(&sharp, 10, 10) > 0.85);
    free(rounded.pixels);
    free(sharp.pixels);
    free(in.pixels);

    struct picture colors = picture_create(65, 47), swapped = picture_create(65, 47);
    struct random_state random = {3};
    for (size_t i = 0; i < 65 * 47; i++)
        for (size_t c = 0; c < 3; c++)
            swapped.pixels[i * 4 + 2 - c] = colors.pixels[i * 4 + c] = (uint8_t)(random_float(&random) * 255);
    for (int m = MLAA; m <= SMAA; m++) {
        struct picture a = antialias(&colors, m, false), b = antialias(&swapped, m, true);
        assert_true(difference(&colors, &a) > 20);
        for (size_t i = 0; i < 65 * 47 * 4; i++)
            assert_int_equal(a.pixels[i], b.pixels[i % 4 == 3 ? i : i / 4 * 4 + 2 - i % 4]);
        free(a.pixels);
        free(b.pixels);
    }
    free(colors.pixels);
    free(swapped.pixels);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_no_edge_no_change_MP_25),    cmocka_unit_test(test_step_of_eight_ramps_by_the_formula_MP_25),
        cmocka_unit_test(test_shapes_Z_U_L_MP_25),         cmocka_unit_test(test_mlaa_equals_reference_MP_25),
        cmocka_unit_test(test_smaa_lines_equal_reference), cmocka_unit_test(test_long_lines_equal_reference),
        cmocka_unit_test(test_quality_of_edges_MP_25),
        cmocka_unit_test(test_corners_and_channels),
    };
    return cmocka_run_group_tests_name("morphological", tests, test_group_begin, test_group_end);
}
