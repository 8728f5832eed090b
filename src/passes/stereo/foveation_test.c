/* SPDX-License-Identifier: MIT */
/** Resolution that falls towards the edges (VR-11). */
#include "tests/render_harness.h"

static const fnl_eye eye = {{{0, 0, 0}, {0, 0, 0, 1}}, -1.1f, 0.9f, -1, 1};

static void test_cells_cover_the_picture_VR_11(void **state) {
    UNUSED(state);
    static const uint32_t sizes[][2] = {{3, 3}, {64, 37}, {101, 100}};
    for (uint32_t s = 0; s < COUNT_OF(sizes); s++)
        for (uint32_t k = 1; k <= 10; k++) {
            fnl_eye_cell cells[9];
            uint64_t covered = 0;
            assert_int_equal(fnl_eye_query_cells(NULL, &eye, sizes[s][0], sizes[s][1], (float)k / 10, 0.5f, cells), FNL_OK);
            for (uint32_t i = 0; i < 9; i++) {
                const fnl_eye_cell *c = &cells[i];
                covered += (uint64_t)c->width * c->height;
                assert_true(c->width > 0 && c->height > 0 && c->rendered_width > 0 && c->rendered_width <= c->width);
                assert_float_equal(c->eye.left, eye.left + (eye.right - eye.left) * (float)c->x / (float)sizes[s][0], 1e-5f);
                assert_float_equal(c->eye.down, eye.up + (eye.down - eye.up) * (float)(c->y + c->height) / (float)sizes[s][1], 1e-5f);
                if (i % 3 < 2) assert_int_equal(c->x + c->width, cells[i + 1].x);
                if (i < 6) assert_int_equal(c->y + c->height, cells[i + 3].y);
            }
            assert_int_equal(covered, sizes[s][0] * sizes[s][1]);
            assert_int_equal(cells[0].width, cells[8].width);
            assert_int_equal(cells[4].rendered_width, cells[4].width);
        }
}

enum { WIDTH = 100, HEIGHT = 90 };

static fnl_camera camera_of(const fnl_eye *of, const fnl_camera *at, uint32_t width, uint32_t height) {
    fnl_camera camera;
    const vec3 forward = vec3_normalize(vec3_sub(at->target, at->position));
    const fnl_rigid_pose head = {at->position, quat_axis_angle(vec3_make(0, 1, 0), atan2f(-forward.x, -forward.z))};
    assert_int_equal(fnl_eye_query_camera(NULL, of, &head, width, height, 0.05f, &camera), FNL_OK);
    return camera;
}

/* A row of the views of a frame, which stand one below the other. */
static fnl_image picture_of(const fnl_image *all, uint32_t height, uint32_t view) {
    fnl_image own = *all;
    own.height = height;
    own.pixels = (char *)all->pixels + (size_t)view * all->width * height * fnl_pixel_size(all->format);
    return own;
}

static fnl_frame eye_frame(const struct stage *stage, const fnl_camera *at) {
    fnl_frame frame = stage->frame;
    frame.width = WIDTH;
    frame.height = HEIGHT;
    frame.ev = 1;
    frame.lists = FNL_LISTS_CLUSTERED;
    frame.camera = camera_of(&eye, at, WIDTH, HEIGHT);
    return frame;
}

/* dB of the rectangle, or of all beyond it. */
static double psnr_of(const fnl_image *a, const fnl_image *b, const fnl_eye_cell *cell, bool inside) {
    double sum = 0;
    uint32_t count = 0;
    for (uint32_t y = 0; y < a->height; y++)
        for (uint32_t x = 0; x < a->width; x++) {
            const bool in = x >= cell->x && x < cell->x + cell->width && y >= cell->y && y < cell->y + cell->height;
            if (in != inside) continue;
            const size_t at = 4 * ((size_t)y * a->width + x);
            for (uint32_t c = 0; c < 3; c++) {
                const int d = ((const uint8_t *)a->pixels)[at + c] - ((const uint8_t *)b->pixels)[at + c];
                sum += d * d / 65025.0;
            }
            count += 3;
        }
    return -10 * log10(sum / count + 1e-12);
}

/* The middle is as in the whole picture; the borders cost less and come close to it. */
static void test_the_middle_stays_as_it_was_VR_11(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:hall?lights=100", 0);
    fnl_eye_cell cells[9];
    assert_int_equal(fnl_eye_query_cells(NULL, &eye, WIDTH, HEIGHT, 0.6f, 0.5f, cells), FNL_OK);
    const fnl_camera at = stage.frame.camera;
    const fnl_frame whole_frame = eye_frame(&stage, &at);
    struct shot whole = stage_shoot(&stage, &whole_frame), shots[4];
    fnl_image pictures[9], joined;
    uint64_t shaded = 0;
    static const uint32_t groups[4][4] = {{4}, {0, 2, 6, 8}, {3, 5}, {1, 7}};
    static const uint32_t counts[4] = {1, 4, 2, 2};
    for (uint32_t g = 0; g < 4; g++) { /* cells of one size are views of one frame */
        fnl_camera cameras[4];
        fnl_frame frame = whole_frame;
        const fnl_eye_cell *first = &cells[groups[g][0]];
        frame.width = first->rendered_width;
        frame.height = first->rendered_height;
        for (uint32_t i = 0; i < counts[g]; i++) cameras[i] = camera_of(&cells[groups[g][i]].eye, &at, frame.width, frame.height);
        frame.views = cameras;
        frame.view_count = counts[g];
        shots[g] = stage_shoot(&stage, &frame);
        shaded += (uint64_t)frame.width * frame.height * counts[g];
        for (uint32_t i = 0; i < counts[g]; i++) pictures[groups[g][i]] = picture_of(&shots[g].color, frame.height, i);
    }
    assert_int_equal(fnl_eye_join_cells(NULL, &eye, cells, 9, pictures, &joined), FNL_OK);
    assert_true(joined.width == WIDTH && joined.height == HEIGHT);
    const double inner = psnr_of(&joined, &whole.color, &cells[4], true), outer = psnr_of(&joined, &whole.color, &cells[4], false), part = (double)shaded / (WIDTH * HEIGHT);
    printf("3 x 3 cells: %.1f dB in the middle, %.1f dB in the borders, %.0f %% of the pixels\n", inner, outer, part * 100);
    if (inner < 45) fail_msg("the middle has %.1f dB", inner);
    assert_true(outer > 12 && part < 0.7);
    for (uint32_t g = 0; g < 4; g++) shot_free(&shots[g]);
    fnl_image_free(NULL, &joined);
    shot_free(&whole);
    stage_close(&stage);
}

/* All quadrants in one frame, joined. `pixels`: how many are rendered. */
static fnl_image draw_quadrants(struct stage *stage, const fnl_camera *at, fnl_vec2 strength, uint64_t *pixels) {
    fnl_eye_cell cells[4];
    fnl_camera cameras[4];
    fnl_image pictures[4], joined;
    fnl_frame frame = eye_frame(stage, at);
    assert_int_equal(fnl_eye_query_quadrants(NULL, &eye, WIDTH, HEIGHT, strength, cells), FNL_OK);
    frame.width = cells[0].rendered_width;
    frame.height = cells[0].rendered_height;
    for (uint32_t i = 0; i < 4; i++) cameras[i] = camera_of(&cells[i].eye, at, frame.width, frame.height);
    frame.views = cameras;
    frame.view_count = 4;
    struct shot shot = stage_shoot(stage, &frame);
    for (uint32_t i = 0; i < 4; i++) pictures[i] = picture_of(&shot.color, frame.height, i);
    assert_int_equal(fnl_eye_join_cells(NULL, &eye, cells, 4, pictures, &joined), FNL_OK);
    *pixels = 4ull * frame.width * frame.height;
    shot_free(&shot);
    return joined;
}

/*
 * Without strength the four parts make the picture again, to the rounding of their cameras. With it far fewer pixels make it, and what is seen stays
 * where it is: in a room without textures, whose edges are soft, the whole picture stays as it was.
 */
static void test_quadrants_make_the_picture_VR_11(void **state) {
    UNUSED(state);
    static const struct {
        const char *scene;
        fnl_vec2 strength;
        double middle, all, part; /* dB at least, pixels at most */
    } cases[] = {{"builtin:hall?lights=100", {0, 0}, 60, 55, 1.2}, {"builtin:room", {0, 0}, 60, 60, 1.2}, {"builtin:room", {0.35f, 0.35f}, 45, 45, 0.72}, {"builtin:room", {1, 0.5f}, 44, 45, 0.45}};
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        struct stage stage = stage_open(cases[i].scene, 0);
        const fnl_camera at = stage.frame.camera;
        const fnl_frame frame = eye_frame(&stage, &at);
        struct shot whole = stage_shoot(&stage, &frame);
        uint64_t pixels;
        fnl_image joined = draw_quadrants(&stage, &at, cases[i].strength, &pixels);
        const fnl_eye_cell middle = {.x = 40, .y = 30, .width = 30, .height = 30}, all = {.width = WIDTH, .height = HEIGHT};
        const double inner = psnr_of(&joined, &whole.color, &middle, true), psnr = psnr_of(&joined, &whole.color, &all, true), part = (double)pixels / (WIDTH * HEIGHT);
        printf("%s, quadrants of strength %g, %g: %.1f dB in the middle, %.1f dB in all, %.0f %% of the pixels\n", cases[i].scene, (double)cases[i].strength.x,
               (double)cases[i].strength.y, inner, psnr, part * 100);
        assert_true(inner >= cases[i].middle && psnr >= cases[i].all && part <= cases[i].part);
        fnl_image_free(NULL, &joined);
        shot_free(&whole);
        stage_close(&stage);
    }
}

/* Directions of a cell's tangents in the space of the head, in doubles. */
static void direction_of(const fnl_eye *of, double x, double y, double out[3]) {
    const double q[4] = {(double)of->pose.rotation.x, (double)of->pose.rotation.y, (double)of->pose.rotation.z, (double)of->pose.rotation.w}, p[3] = {x, y, -1};
    double t[3];
    for (uint32_t i = 0; i < 3; i++) t[i] = 2 * (q[(i + 1) % 3] * p[(i + 2) % 3] - q[(i + 2) % 3] * p[(i + 1) % 3]);
    for (uint32_t i = 0; i < 3; i++) out[i] = p[i] + q[3] * t[i] + q[(i + 1) % 3] * t[(i + 2) % 3] - q[(i + 2) % 3] * t[(i + 1) % 3];
}

/* Which tangents of the eye a place of a cell's picture shows. */
static void eye_tangents(const fnl_eye *seen_by, const fnl_eye_cell *cell, double column, double row, double out[2]) {
    const double u = column / cell->rendered_width, v = row / cell->rendered_height;
    double d[3], x[3], y[3], z[3];
    direction_of(&cell->eye, (double)cell->eye.left + u * (double)(cell->eye.right - cell->eye.left), (double)cell->eye.up - v * (double)(cell->eye.up - cell->eye.down), d);
    direction_of(seen_by, 1, 0, x);
    direction_of(seen_by, 0, 1, y);
    direction_of(seen_by, 0, 0, z);
    double along[3] = {0, 0, 0};
    for (uint32_t i = 0; i < 3; i++) {
        along[0] += d[i] * (x[i] - z[i]);
        along[1] += d[i] * (y[i] - z[i]);
        along[2] += d[i] * z[i];
    }
    out[0] = along[0] / along[2];
    out[1] = along[1] / along[2];
}

/*
 * Pixels of quadrants show what lens-matched shading shows there: as many for a pixel of the eye as (1 + w)^-3 says, one at the axis; each quadrant has
 * all of its rectangle, and a pixel more on each side. Of an eye that is turned and off its axis, at odd sizes.
 */
static void test_quadrants_are_lens_matched_VR_11(void **state) {
    UNUSED(state);
    const fnl_eye eyes[] = {eye, {{{0.03f, 0, 0}, quat_axis_angle(vec3_make(0, 1, 0), 0.2f)}, -0.6f, 1.3f, -1.1f, 0.8f}};
    static const uint32_t sizes[][2] = {{101, 67}, {640, 481}, {2, 2}};
    static const fnl_vec2 strengths[] = {{0, 0}, {0.35f, 0.2f}, {1, 1}, {0, 1}};
    for (uint32_t n = 0; n < COUNT_OF(eyes) * COUNT_OF(sizes) * COUNT_OF(strengths); n++) {
        const fnl_eye *e = &eyes[n % 2];
        const uint32_t *size = sizes[n / 2 % 3];
        const fnl_vec2 strength = strengths[n / 6];
        fnl_eye_cell cells[4];
        assert_int_equal(fnl_eye_query_quadrants(NULL, e, size[0], size[1], strength, cells), FNL_OK);
        assert_int_equal(cells[0].width + cells[1].width, size[0]);
        assert_int_equal(cells[0].height + cells[2].height, size[1]);
        const double dx = (double)(e->right - e->left) / size[0], dy = (double)(e->up - e->down) / size[1];
        for (uint32_t i = 0; i < 4; i++) {
            const fnl_eye_cell *c = &cells[i];
            assert_true(c->x == (i % 2) * cells[0].width && c->y == (i / 2) * cells[0].height);
            assert_true(c->rendered_width == cells[0].rendered_width && c->rendered_height == cells[0].rendered_height);
            double corners[2][2] = {{1e9, 1e9}, {-1e9, -1e9}}; /* of the rectangle, by walking over the rendered picture */
            for (uint32_t k = 0; k <= 8; k++)
                for (uint32_t l = 0; l <= 8; l++) {
                    /* A pixel at a place in the picture, and how large it is for the eye. */
                    const double column = c->rendered_width * (k / 8.0), row = c->rendered_height * (l / 8.0), step = 1e-3;
                    double at[2], left[2], right[2], up[2], down[2];
                    eye_tangents(e, c, column, row, at);
                    eye_tangents(e, c, column - step, row, left);
                    eye_tangents(e, c, column + step, row, right);
                    eye_tangents(e, c, column, row - step, up);
                    eye_tangents(e, c, column, row + step, down);
                    const double area = fabs((right[0] - left[0]) * (down[1] - up[1]) - (right[1] - left[1]) * (down[0] - up[0])) / (4 * step * step * dx * dy);
                    const double edge_x = (double)(i % 2 ? e->right : e->left), edge_y = (double)(i / 2 ? e->down : e->up);
                    const double w = 1 + (double)strength.x * at[0] / edge_x + (double)strength.y * at[1] / edge_y;
                    if (w > 0.5 && w < 4 && fabs(area / (w * w * w) - 1) > 1e-3) fail_msg("%u pixels, quadrant %u, w %g: a pixel has the area of %g of the eye's", size[0], i, w, area);
                    corners[0][0] = fmin(corners[0][0], at[0]), corners[1][0] = fmax(corners[1][0], at[0]);
                    corners[0][1] = fmin(corners[0][1], at[1]), corners[1][1] = fmax(corners[1][1], at[1]);
                }
            const double left = (double)e->left + dx * c->x, up = (double)e->up - dy * c->y;
            assert_true(corners[0][0] < left && corners[1][0] > left + dx * c->width && corners[0][1] < up - dy * c->height && corners[1][1] > up);
        }
    }
}

/* Values of pixels that a cell shares with the eye are kept, floats too; others lie between their neighbours; what no cell covers is black. */
static void test_joining_keeps_values_VR_11(void **state) {
    UNUSED(state);
    const fnl_eye flat = {{{0, 0, 0}, {0, 0, 0, 1}}, -1, 1, -1, 1};
    fnl_eye_cell cells[9];
    fnl_image pictures[9], joined;
    float values[9][4 * 64];
    assert_int_equal(fnl_eye_query_cells(NULL, &flat, 12, 12, 0.5f, 1, cells), FNL_OK);
    for (uint32_t i = 0; i < 9; i++) {
        for (uint32_t k = 0; k < 4 * cells[i].rendered_width * cells[i].rendered_height; k++) values[i][k] = (float)(1000 * i + k);
        pictures[i] = (fnl_image){cells[i].rendered_width, cells[i].rendered_height, FNL_PIXEL_FORMAT_RGBA32F, values[i]};
    }
    assert_int_equal(fnl_eye_join_cells(NULL, &flat, cells, 9, pictures, &joined), FNL_OK);
    for (uint32_t i = 0; i < 9; i++)
        for (uint32_t y = 0; y < cells[i].height; y++)
            assert_memory_equal((float *)joined.pixels + 4 * ((cells[i].y + y) * 12 + cells[i].x), &values[i][4 * y * cells[i].width], 16 * cells[i].width);
    fnl_image_free(NULL, &joined);

    float two[8] = {1, 2, 3, 4, 5, 6, 7, 8}; /* one row for 4 x 2 pixels, and a part without a cell */
    const fnl_eye_cell half = {{flat.pose, -1, 1, -1, 1}, 0, 0, 4, 2, 2, 1}, far = {{flat.pose, -1, 1, -1, 1}, 5, 0, 1, 2, 2, 1};
    const fnl_eye_cell both[2] = {half, far};
    const fnl_image row = {2, 1, FNL_PIXEL_FORMAT_RGBA32F, two}, rows[2] = {row, row};
    assert_int_equal(fnl_eye_join_cells(NULL, &flat, both, 2, rows, &joined), FNL_OK);
    assert_true(joined.width == 6 && joined.height == 2);
    for (uint32_t x = 0; x < 6; x++) { /* the eye's picture has 6 columns: the cell reaches over all of them */
        const double place = (x + 0.5) / 3 - 0.5, red = x == 4 ? 0 : 1 + 4 * fmin(fmax(place, 0), 1);
        assert_float_equal(((float *)joined.pixels)[4 * (6 + x)], red, 1e-4);
    }
    fnl_image_free(NULL, &joined);
    assert_int_equal(fnl_eye_join_cells(NULL, &flat, both, 2, (fnl_image[]){row, {1, 2, FNL_PIXEL_FORMAT_RGBA32F, two}}, &joined), FNL_ERROR_INVALID);
}

/* ---- coarse.fovea: rates by the angle from where the viewer looks ---- */

/* How many pixels across block (x, y) of `size` shares, as the header says it; 0: too near to a limit to tell. */
static uint32_t side_at(const fnl_frame *frame, const fnl_camera *camera, const fnl_vec3 *gaze, uint32_t x, uint32_t y) {
    const uint32_t size = frame->coarse.size;
    const vec3 back = vec3_normalize(vec3_sub(camera->position, camera->target)), right = vec3_normalize(vec3_cross(camera->up, back)), up = vec3_cross(back, right);
    const float tangent = tanf(camera->vertical_fov / 2), aspect = camera->pixel_aspect * (float)frame->width / (float)frame->height;
    const float u = 2 * ((float)x + 0.5f * (float)size) / (float)frame->width - 1, v = 1 - 2 * ((float)y + 0.5f * (float)size) / (float)frame->height;
    const vec3 to = vec3_sub(vec3_add(vec3_scale(right, (u - camera->shift.x) * tangent * aspect), vec3_scale(up, (v - camera->shift.y) * tangent)), back);
    const vec3 look = gaze ? vec3_sub(*gaze, camera->position) : vec3_scale(back, -1);
    const float angle = acosf(fminf(fmaxf(vec3_dot(vec3_normalize(to), vec3_normalize(look)), -1), 1)) * (180 / PI);
    const float far = fmaxf(frame->coarse.fovea, frame->coarse.fovea_far);
    if (fabsf(angle - frame->coarse.fovea) < 0.02f || (size == 4 && fabsf(angle - far) < 0.02f)) return 0;
    return angle < frame->coarse.fovea ? 1 : size == 4 && angle < far ? 2 : size;
}

/* Blocks where the viewer looks are as in `reference` to the bit, and so is the background; all others are lit as often as their side says. */
static void check_fovea(const fnl_frame *frame, const fnl_camera *camera, const fnl_vec3 *gaze, const struct shot *shot, const struct shot *reference) {
    const uint32_t size = frame->coarse.size, width = frame->width, height = frame->height;
    const vec4 *radiance = shot->radiance.pixels, *wanted = reference->radiance.pixels, *normals = shot->normal.pixels;
    uint64_t shaded = 0, open = 0, shown = 0, near = 0, differing = 0;
    for (uint32_t y = 0; y < height; y += size)
        for (uint32_t x = 0; x < width; x += size) {
            const uint32_t side = side_at(frame, camera, gaze, x, y);
            uint32_t parts = 0; /* a bit for each that shows a surface */
            for (uint32_t v = y; v < MIN(y + size, height); v++)
                for (uint32_t u = x; u < MIN(x + size, width); u++) {
                    const size_t at = (size_t)v * width + u;
                    const bool surface = normals[at].w > 0, same = memcmp(&radiance[at], &wanted[at], sizeof *radiance) == 0;
                    shown += surface;
                    if (surface && side) parts |= 1u << ((v - y) / side * size / side + (u - x) / side);
                    if ((side == 1 || !surface) && !same) fail_msg("pixel %u, %u is not as in deferred", u, v);
                    near += side == 1 && surface;
                    differing += !same;
                }
            open += side ? 0 : size * size;
            for (; parts; parts &= parts - 1) shaded++;
        }
    const fnl_frame_stats *s = &shot->stats;
    const uint64_t counted = counter(s, "coarse.shaded");
    print_message("%ux%u, size %u: %u of %u pixels each, %u times in all, %u differ\n", width, height, size, (uint32_t)near, (uint32_t)shown, (uint32_t)counted, (uint32_t)differing);
    assert_int_equal(counter(s, "coarse.pixels"), shown);
    assert_true(counted >= shaded && counted <= shaded + open && open < (uint64_t)width * height / 10);
    if (shown > near + open + 16) assert_true(differing > 0 && counted < shown);
    assert_true(s->evaluations > 0 && s->evaluations * shown == reference->stats.evaluations * counted); /* with lists that have all lights in each pixel */
}

static struct shot shoot_deferred(struct stage *stage, fnl_frame frame) {
    frame.shading = FNL_SHADING_DEFERRED;
    return stage_shoot(stage, &frame);
}

static fnl_frame fovea_frame(const struct stage *stage, uint32_t width, uint32_t height) {
    fnl_frame frame = stage->frame;
    frame.shading = FNL_SHADING_COARSE;
    frame.lists = FNL_LISTS_ALL;
    frame.width = width;
    frame.height = height;
    frame.outputs = FNL_OUTPUT_COLOR | FNL_OUTPUT_RADIANCE | FNL_OUTPUT_NORMAL;
    frame.count_lights = true;
    frame.coarse.size = 4;
    frame.coarse.fovea = 14;
    frame.coarse.fovea_far = 24;
    return frame;
}

/* Somewhere in the picture, -1 .. 1 right and up, `away` metres from the camera; beyond 1 outside of it. */
static vec3 point_in(const fnl_camera *camera, float aspect, float x, float y, float away) {
    const vec3 back = vec3_normalize(vec3_sub(camera->position, camera->target)), right = vec3_normalize(vec3_cross(camera->up, back)), up = vec3_cross(back, right);
    const float tangent = tanf(camera->vertical_fov / 2);
    const vec3 to = vec3_sub(vec3_add(vec3_scale(right, x * tangent * aspect), vec3_scale(up, y * tangent)), back);
    return vec3_add_scaled(camera->position, to, away);
}

static void test_fovea_follows_the_gaze_VR_11(void **state) {
    UNUSED(state);
    static const struct {
        uint32_t width, height, size;
        float x, y, away;
    } cases[] = {{96, 64, 4, 0, 0, 0}, {101, 67, 4, -0.6f, 0.4f, 3}, {101, 67, 2, 0.5f, -0.3f, 50}, {63, 65, 4, 1, 1, 1000}, {64, 36, 4, 3, 0, 10}, {64, 36, 2, 0.2f, 0, -5}, {3, 5, 4, 0, 0, 0}};
    static const char *const scenes[] = {"builtin:sky?lights=20", "builtin:hall?lights=20&decals=20"};
    for (uint32_t s = 0; s < COUNT_OF(scenes); s++) {
        struct stage stage = stage_open(scenes[s], 0);
        for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
            fnl_frame frame = fovea_frame(&stage, cases[i].width, cases[i].height);
            const vec3 gaze = point_in(&frame.camera, (float)frame.width / (float)frame.height, cases[i].x, cases[i].y, cases[i].away);
            frame.gaze = cases[i].away != 0 ? &gaze : NULL;
            frame.coarse.size = cases[i].size;
            frame.coarse.filter = i % 2 ? FNL_COARSE_FILTER_SAMPLED : FNL_COARSE_FILTER_MEAN;
            struct shot shot = stage_shoot(&stage, &frame), reference = shoot_deferred(&stage, frame);
            check_fovea(&frame, &frame.camera, frame.gaze, &shot, &reference);
            shot_free(&shot);
            shot_free(&reference);
        }
        stage_close(&stage);
    }
}

/* Splits come closer to the whole rate with as much work for what is shared. One rate for all pixels is no foveation. */
static void test_fovea_with_splits_and_limits_VR_11(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:spheres", 40);
    fnl_frame frame = fovea_frame(&stage, 101, 67);
    frame.count_lights = false;
    struct shot full = shoot_deferred(&stage, frame), none = stage_shoot(&stage, &frame);
    fnl_image_difference difference;
    for (uint32_t split = 1; split < FNL_COARSE_SPLIT_COUNT; split++) {
        frame.coarse.split = (fnl_coarse_split)split;
        frame.coarse.ao_radius = split == 1 ? 0.3f : 0;
        struct shot shot = stage_shoot(&stage, &frame);
        assert_int_equal(fnl_image_compare(gpu_host(harness_device()), &shot.color, &full.color, &difference), FNL_OK);
        print_message("%s: %.1f dB\n", fnl_value_name(FNL_ENUM_COARSE_SPLIT, frame.coarse.split), difference.psnr);
        if (split > 1) assert_true(difference.psnr > 22);
        if (split == 1) assert_int_equal(counter(&shot.stats, "coarse.ao-shaded"), counter(&none.stats, "coarse.shaded"));
        assert_int_equal(counter(&shot.stats, "coarse.shaded"), counter(&none.stats, "coarse.shaded"));
        shot_free(&shot);
    }
    /* One rate for all is as if there was none, to the bit, and so are blocks of a pixel. */
    frame.coarse = fovea_frame(&stage, 1, 1).coarse;
    for (uint32_t i = 0; i < 2; i++) {
        frame.coarse.fovea = i ? 5 : 180;
        frame.coarse.size = i ? 1 : 4;
        struct shot shot = stage_shoot(&stage, &frame);
        assert_int_equal(count_differing(&shot.radiance, &full.radiance), 0);
        assert_int_equal(counter(&shot.stats, "coarse.shaded"), counter(&shot.stats, "coarse.pixels"));
        shot_free(&shot);
    }
    frame.coarse.fovea = 10;
    frame.camera.orthographic = true;
    frame.camera.vertical_extent = 2;
    frame.camera.far_distance = 100;
    assert_int_equal(fnl_renderer_render(stage.renderer, &frame), FNL_ERROR_UNSUPPORTED);
    frame.coarse.fovea = 0;
    assert_int_equal(fnl_renderer_render(stage.renderer, &frame), FNL_OK);
    shot_free(&full);
    shot_free(&none);
    stage_close(&stage);
}

/* Both eyes of a headset with canted displays look at one point: each has the pixels around it where it sees it. */
static void test_fovea_of_two_eyes_VR_11(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:hall?lights=20", 0);
    fnl_frame frame = fovea_frame(&stage, 80, 60);
    fnl_camera eyes[2];
    const fnl_camera at = frame.camera;
    const vec3 gaze = point_in(&at, 4 / 3.0f, 0.2f, 0.1f, 2);
    uint64_t shaded[2];
    struct shot single[2];
    frame.gaze = &gaze;
    for (int i = 0; i < 2; i++) {
        const fnl_eye one = {{{i ? 0.0315f : -0.0315f, 0, 0}, quat_axis_angle(vec3_make(0, 1, 0), i ? -0.17f : 0.17f)}, i ? -0.8f : -1.2f, i ? 1.2f : 0.8f, -0.9f, 0.8f};
        eyes[i] = camera_of(&one, &at, frame.width, frame.height);
        frame.camera = eyes[i];
        single[i] = stage_shoot(&stage, &frame);
        struct shot reference = shoot_deferred(&stage, frame);
        check_fovea(&frame, &eyes[i], &gaze, &single[i], &reference);
        shaded[i] = counter(&single[i].stats, "coarse.shaded");
        shot_free(&reference);
    }
    frame.views = eyes;
    frame.view_count = 2;
    frame.stereo.eyes = 2;
    struct shot both = stage_shoot(&stage, &frame);
    const size_t half = single[0].radiance.width * single[0].radiance.height * sizeof(vec4);
    for (int i = 0; i < 2; i++) {
        assert_memory_equal((const char *)both.radiance.pixels + i * half, single[i].radiance.pixels, half);
        assert_int_equal(fnl_counter_find(&both.stats.views[i], "coarse.shaded")->value, shaded[i]);
        shot_free(&single[i]);
    }
    shot_free(&both);
    stage_close(&stage);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_cells_cover_the_picture_VR_11, harness_check),
        cmocka_unit_test_teardown(test_the_middle_stays_as_it_was_VR_11, harness_check),
        cmocka_unit_test_teardown(test_quadrants_make_the_picture_VR_11, harness_check),
        cmocka_unit_test_teardown(test_quadrants_are_lens_matched_VR_11, harness_check),
        cmocka_unit_test_teardown(test_joining_keeps_values_VR_11, harness_check),
        cmocka_unit_test_teardown(test_fovea_follows_the_gaze_VR_11, harness_check),
        cmocka_unit_test_teardown(test_fovea_with_splits_and_limits_VR_11, harness_check),
        cmocka_unit_test_teardown(test_fovea_of_two_eyes_VR_11, harness_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
