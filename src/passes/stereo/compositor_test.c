/* SPDX-License-Identifier: MIT */
/** From eyes to the display: lenses, trimming, late poses, layers. */
#include "fanal/compositor.h"
#include "passes/stereo/lens.h"
#include "tests/render_test.h"

static const fnl_rigid_pose nowhere = {{0, 0, 0}, {0, 0, 0, 1}};

/* Of a Vive's kind: barrel against pincushion, blue more than red. */
static const fnl_lens lens = {{0.03f, -0.02f}, {{0.14f, 0.06f, 0, 0}, {0.17f, 0.08f, 0, 0}, {0.21f, 0.11f, 0, 0}}};

static fnl_compositor_params params_of(uint32_t width, uint32_t height, uint32_t eye_count, const fnl_lens *with) {
    fnl_compositor_params p = fnl_compositor_params_default();
    p.width = width;
    p.height = height;
    p.eye_count = eye_count;
    for (uint32_t i = 0; i < 2 && with; i++) {
        fnl_display_eye *e = &p.eyes[i];
        e->lens = *with;
        e->left = fnl_lens_display_edge(with, e->eye.left, false);
        e->right = fnl_lens_display_edge(with, e->eye.right, false);
        e->down = fnl_lens_display_edge(with, e->eye.down, true);
        e->up = fnl_lens_display_edge(with, e->eye.up, true);
    }
    return p;
}

static fnl_compositor *make(const fnl_compositor_params *params) {
    fnl_compositor *c;
    assert_int_equal(fnl_compositor_create(harness_device(), params, &c), FNL_OK);
    return c;
}

static fnl_image compose(fnl_compositor *c, const fnl_composition *with) {
    fnl_image image;
    assert_int_equal(fnl_compositor_compose(c, with, &image), FNL_OK);
    return image;
}

static void release(fnl_image *image) { fnl_image_free(gpu_host((gpu_device *)harness_device()), image); }

/* Pictures of `eyes` eyes, one below the other. */
typedef void paint(uint32_t eye, float x, float y, uint8_t pixel[4]);
static fnl_image painted(uint32_t width, uint32_t height, uint32_t eyes, paint *how) {
    uint8_t *pixels = host_allocate(gpu_host((gpu_device *)harness_device()), 4ull * width * height * eyes);
    assert_non_null(pixels);
    for (uint32_t i = 0; i < width * height * eyes; i++) how(i / (width * height), (float)(i % width), (float)(i / width % height), &pixels[4 * i]);
    return (fnl_image){width, height * eyes, FNL_PIXEL_FORMAT_RGBA8, pixels};
}

static void paint_noise(uint32_t eye, float x, float y, uint8_t pixel[4]) {
    uint32_t h = ((uint32_t)x * 73856093u) ^ ((uint32_t)y * 19349663u) ^ (eye * 83492791u);
    for (int c = 0; c < 4; c++) {
        h = h * 1664525u + 1013904223u;
        pixel[c] = c == 3 ? 255 : (uint8_t)(h >> 24);
    }
}

static fnl_result submit(fnl_compositor *c, const fnl_image *color, const fnl_image *normal, fnl_rigid_pose head) {
    return fnl_compositor_submit(c, &(fnl_eye_pictures){color, normal, head});
}

static const uint8_t *pixel_of(const fnl_image *image, uint32_t x, uint32_t y) { return (const uint8_t *)image->pixels + 4 * ((size_t)y * image->width + x); }

/* ---- lenses ---- */

/* Without lens and turn each pixel of the display is that of the eye, to the bit, whatever way it comes (VR-8, VR-12). */
static void test_identity_is_a_copy_VR_8_VR_12(void **state) {
    UNUSED(state);
    enum { W = 61, H = 47 };
    fnl_image color = painted(W, H, 2, paint_noise);
    float *depth = host_allocate_zero(gpu_host((gpu_device *)harness_device()), 2ull * W * H * 16);
    for (uint32_t i = 0; i < 2 * W * H; i++) depth[4 * i + 3] = i % 7 == 0 ? 0 : 0.5f + (float)(i % 50); /* ragged */
    fnl_image normal = {W, 2 * H, FNL_PIXEL_FORMAT_RGBA32F, depth};
    const fnl_rigid_pose head = {{1, 2, 3}, quat_axis_angle(vec3_normalize(vec3_make(1, 2, 0.5f)), 0.7f)};
    for (uint32_t warp = 0; warp < FNL_WARP_COUNT; warp++)
        for (uint32_t way = 0; way < FNL_REPROJECTION_COUNT; way++) {
            fnl_compositor_params p = params_of(W, H, 2, NULL);
            p.warp = (fnl_warp)warp;
            fnl_compositor *c = make(&p);
            assert_int_equal(submit(c, &color, &normal, head), FNL_OK);
            fnl_image out = compose(c, &(fnl_composition){.head = head, .reprojection = (fnl_reprojection)way});
            assert_int_equal(out.width, 2 * W);
            for (uint32_t y = 0; y < H; y++)
                for (uint32_t x = 0; x < 2 * W; x++)
                    if (memcmp(pixel_of(&out, x, y), pixel_of(&color, x % W, y + x / W * H), 4) != 0)
                        fail_msg("warp %u, reprojection %u: pixel %u %u is %u, was %u", warp, way, x, y, pixel_of(&out, x, y)[0], pixel_of(&color, x % W, y + x / W * H)[0]);
            release(&out);
            fnl_compositor_destroy(&c);
        }
    release(&color);
    host_free(gpu_host((gpu_device *)harness_device()), depth, 2ull * W * H * 16);
}

/* What the mesh shows at each pixel of a display of 1080 x 1200 that is seen, against the polynomial: below half a pixel of the eye's picture (VR-8). */
static void test_mesh_is_close_to_the_polynomial_VR_8(void **state) {
    UNUSED(state);
    static struct gpu_lens_vertex v[LENS_VERTICES];
    const fnl_compositor_params p = params_of(1080, 1200, 1, &lens);
    const fnl_display_eye *e = &p.eyes[0];
    const float pixels = 1080 / (e->eye.right - e->eye.left); /* of an eye's picture with as many as the display */
    double worst[3] = {0};
    lens_mesh(e, v);
    for (uint32_t y = 0; y < 1200; y += 3)
        for (uint32_t x = 0; x < 1080; x += 3) {
            const float px = ((float)x + 0.5f) / 1080, py = ((float)y + 0.5f) / 1200, gx = px * LENS_QUADS, gy = py * LENS_QUADS, fx = gx - floorf(gx), fy = gy - floorf(gy);
            const struct gpu_lens_vertex *at = &v[(uint32_t)gy * (LENS_QUADS + 1) + (uint32_t)gx];
            const vec2 q = {e->left + (e->right - e->left) * px, e->up + (e->down - e->up) * py};
            for (uint32_t ch = 0; ch < 3; ch++) {
                const vec2 *a = &at[0].red + ch, *b = &at[1].red + ch, *c = &at[LENS_QUADS + 1].red + ch, *d = &at[LENS_QUADS + 2].red + ch, exact = lens_bend(&lens, q, ch);
                const bool first = fx + fy < 1;
                const float wa = first ? 1 - fx - fy : 0, wd = first ? 0 : fx + fy - 1, wb = first ? fx : 1 - fy, wc = first ? fy : 1 - fx;
                const float mx = wa * a->x + wb * b->x + wc * c->x + wd * d->x, my = wa * a->y + wb * b->y + wc * c->y + wd * d->y;
                const float dx = exact.x - lens.center.x, dy = exact.y - lens.center.y;
                if (dx * dx + dy * dy < 1.03f * 1.03f) worst[ch] = fmax(worst[ch], (double)(sqrtf((mx - exact.x) * (mx - exact.x) + (my - exact.y) * (my - exact.y)) * pixels));
            }
        }
    printf("mesh against polynomial, pixels of the eye: red %.2f, green %.2f, blue %.2f\n", worst[0], worst[1], worst[2]);
    for (uint32_t ch = 0; ch < 3; ch++)
        if (worst[ch] > 0.5 || worst[ch] == 0) fail_msg("channel %u is %.3f pixels off", ch, worst[ch]);
}

static void paint_waves(uint32_t eye, float x, float y, uint8_t pixel[4]) {
    UNUSED(eye);
    const float slope = 8, along[3] = {x, y, x + y};
    for (int c = 0; c < 3; c++) {
        const float phase = fmodf(along[c] * slope, 256);
        pixel[c] = (uint8_t)(64 + (phase < 128 ? phase : 255 - phase));
    }
    pixel[3] = 255;
}

/* The same as pictures, in which a pixel of the eye's picture is 8 steps. */
static void test_mesh_and_pixels_give_one_picture_VR_8(void **state) {
    UNUSED(state);
    enum { SIDE = 240 };
    fnl_image color = painted(SIDE, SIDE, 2, paint_waves), out[2];
    for (uint32_t warp = 0; warp < 2; warp++) {
        fnl_compositor_params p = params_of(200, 200, 2, &lens);
        p.warp = (fnl_warp)warp;
        p.trim = false;
        fnl_compositor *c = make(&p);
        assert_int_equal(submit(c, &color, NULL, nowhere), FNL_OK);
        out[warp] = compose(c, &(fnl_composition){.head = nowhere});
        fnl_compositor_destroy(&c);
    }
    uint32_t differ = 0, shown = 0;
    int worst = 0;
    for (uint32_t i = 0; i < 4 * 400 * 200; i++) {
        const uint8_t a = ((const uint8_t *)out[0].pixels)[i], b = ((const uint8_t *)out[1].pixels)[i];
        const bool edge = (a == 0) != (b == 0); /* of what was rendered: one is outside already */
        if (edge)
            differ++;
        else
            worst = MAX(worst, abs(a - b));
        shown += a > 0 && a < 255;
    }
    assert_true(shown > 100000);
    if (worst > 4) fail_msg("pictures differ by %d steps, %.2f pixels", worst, worst / 8.0);
    if (differ > 200) fail_msg("the edges of %u values differ", differ);
    release(&out[0]);
    release(&out[1]);
    release(&color);
}

static void paint_line(uint32_t eye, float x, float y, uint8_t pixel[4]) {
    UNUSED(eye);
    UNUSED(y);
    memset(pixel, x >= 179 && x <= 181 ? 255 : 0, 3);
    pixel[3] = 255;
}

/* A white line comes apart into colours, each where the inverse of its polynomial says (VR-8). */
static void test_colours_come_apart_VR_8(void **state) {
    UNUSED(state);
    enum { SIDE = 200 };
    fnl_image color = painted(SIDE, SIDE, 1, paint_line);
    const fnl_compositor_params p = params_of(SIDE, SIDE, 1, &lens);
    const fnl_display_eye *e = &p.eyes[0];
    fnl_compositor *c = make(&p);
    assert_int_equal(submit(c, &color, NULL, nowhere), FNL_OK);
    fnl_image out = compose(c, &(fnl_composition){.head = nowhere});
    /* In the row through the lens's centre. */
    const uint32_t row = (uint32_t)((e->up - lens.center.y) / (e->up - e->down) * SIDE);
    double found[3];
    for (uint32_t ch = 0; ch < 3; ch++) {
        double sum = 0, weight = 0;
        for (uint32_t x = 0; x < SIDE; x++) {
            const double w = (double)decode_srgb((float)pixel_of(&out, x, row)[ch] / 255);
            sum += w * (x + 0.5);
            weight += w;
        }
        assert_true(weight > 1);
        found[ch] = sum / weight;
        fnl_lens one = lens;
        memcpy(one.k[1], lens.k[ch], sizeof one.k[1]); /* the inverse is that of green */
        const double tangent = -1 + 2 * 180.5 / SIDE, display = (double)fnl_lens_display_edge(&one, (float)tangent, false);
        const double wanted = (display - (double)e->left) / (double)(e->right - e->left) * SIDE;
        if (fabs(found[ch] - wanted) > 0.15) fail_msg("channel %u is at %.2f, should be at %.2f", ch, found[ch], wanted);
    }
    assert_true(found[0] > found[1] + 0.5 && found[1] > found[2] + 0.5); /* blue is bent most, so it is drawn farthest inwards */
    release(&out);
    fnl_compositor_destroy(&c);
    release(&color);
}

/* The trimmed mesh gives the same picture with less work (VR-9). */
static void test_trimming_saves_work_VR_9(void **state) {
    UNUSED(state);
    enum { W = 162, H = 180 }; /* a Vive's 1080 x 1200 */
    static const fnl_lens vive = {{0, 0}, {{0.09f, 0.03f, 0, 0}, {0.10f, 0.035f, 0, 0}, {0.115f, 0.04f, 0, 0}}};
    fnl_image color = painted(227, 252, 2, paint_noise), out[2];
    fnl_compositor_stats stats[2];
    for (uint32_t trim = 0; trim < 2; trim++) {
        fnl_compositor_params p = fnl_compositor_params_default();
        p.width = W;
        p.height = H;
        for (uint32_t i = 0; i < 2; i++) { /* the eyes are mirrored */
            fnl_display_eye *e = &p.eyes[i];
            e->eye.left = i ? -1.2424f : -1.3955f, e->eye.right = i ? 1.3955f : 1.2424f, e->eye.down = -1.4642f, e->eye.up = 1.4642f;
            e->lens = vive;
            e->left = fnl_lens_display_edge(&vive, e->eye.left, false);
            e->right = fnl_lens_display_edge(&vive, e->eye.right, false);
            e->down = fnl_lens_display_edge(&vive, e->eye.down, true);
            e->up = fnl_lens_display_edge(&vive, e->eye.up, true);
            e->visible_radius = 1.4642f;
        }
        p.trim = trim;
        p.count = true;
        fnl_compositor *c = make(&p);
        assert_int_equal(submit(c, &color, NULL, nowhere), FNL_OK);
        out[trim] = compose(c, &(fnl_composition){.head = nowhere});
        assert_int_equal(fnl_compositor_query_stats(c, &stats[trim]), FNL_OK);
        fnl_compositor_destroy(&c);
    }
    assert_int_equal(count_differing(&out[0], &out[1]), 0);
    assert_int_equal(stats[0].pixels_shaded, 2 * W * H);
    assert_int_equal(stats[0].quads_drawn, stats[0].quads);
    const double saved = 1 - (double)stats[1].pixels_shaded / (double)stats[0].pixels_shaded;
    printf("trimmed mesh: source 15 %%, ours %.1f %% fewer pixels, %.1f %% fewer quads: %s\n", saved * 100, 100 - 100.0 * stats[1].quads_drawn / stats[1].quads,
           saved >= 0.15 ? "as the source says" : "less than the source says");
    if (saved < 0.1) fail_msg("only %.3f is saved", saved);
    release(&out[0]);
    release(&out[1]);
    release(&color);
}

/* ---- late poses ---- */

enum { EYE = 96 };

/* Eye pictures of a scene for a head, with depth. */
struct rendered {
    struct shot shot;
    fnl_rigid_pose head;
};

static struct rendered render(struct stage *stage, const fnl_compositor_params *p, fnl_rigid_pose head) {
    struct rendered r = {.head = head};
    fnl_frame frame = stage->frame;
    fnl_camera cameras[2];
    for (uint32_t i = 0; i < p->eye_count; i++) assert_int_equal(fnl_eye_query_camera(NULL, &p->eyes[i].eye, &head, EYE, EYE, 0.05f, &cameras[i]), FNL_OK);
    frame.width = frame.height = EYE;
    frame.views = cameras;
    frame.view_count = p->eye_count;
    frame.outputs = FNL_OUTPUT_COLOR | FNL_OUTPUT_NORMAL;
    frame.lists = FNL_LISTS_CLUSTERED;
    frame.msaa = 4;
    frame.ev = 0;
    r.shot = stage_shoot(stage, &frame);
    return r;
}

static fnl_rigid_pose head_of(const fnl_camera *camera) {
    const vec3 forward = vec3_normalize(vec3_sub(camera->target, camera->position));
    const float yaw = atan2f(-forward.x, -forward.z);
    return (fnl_rigid_pose){camera->position, quat_axis_angle(vec3_make(0, 1, 0), yaw)};
}

/* Of the pixels of the first eye between `margin` of the picture and its edges, dB. */
static double psnr(const fnl_image *a, const fnl_image *b, uint32_t margin) {
    double sum = 0;
    uint32_t count = 0;
    for (uint32_t y = margin; y < EYE - margin; y++)
        for (uint32_t x = margin; x < EYE - margin; x++)
            for (int c = 0; c < 3; c++, count++) {
                const double d = (pixel_of(a, x, y)[c] - pixel_of(b, x, y)[c]) / 255.0;
                sum += d * d;
            }
    return -10 * log10(sum / count + 1e-12);
}

static double reprojected(fnl_compositor *c, fnl_rigid_pose now, fnl_reprojection how, const fnl_image *wanted, uint32_t margin) {
    fnl_image out = compose(c, &(fnl_composition){.head = now, .reprojection = how});
    const double result = psnr(&out, wanted, margin);
    release(&out);
    return result;
}

/* A turned head: what is far is where a frame for that head has it (VR-12). A moved head: depth brings it closer to such a frame. */
static void test_late_poses_VR_12(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:hall?lights=200", 0);
    fnl_compositor_params p = params_of(EYE, EYE, 1, NULL);
    p.eyes[0].eye.pose = nowhere; /* turns about itself: as if all were infinitely far */
    fnl_compositor *c = make(&p);
    const fnl_rigid_pose then = head_of(&stage.frame.camera);
    fnl_rigid_pose now = then;
    struct rendered old = render(&stage, &p, then);
    assert_int_equal(submit(c, &old.shot.color, &old.shot.normal, then), FNL_OK);

    const float degree = PI / 180;
    now.rotation = quat_axis_angle(vec3_make(0, 1, 0), 2 * atan2f(then.rotation.y, then.rotation.w) + 4 * degree);
    struct rendered turned = render(&stage, &p, now);
    const double before = reprojected(c, now, FNL_REPROJECTION_OFF, &turned.shot.color, 8), after = reprojected(c, now, FNL_REPROJECTION_ROTATION, &turned.shot.color, 8);
    printf("turned by 4 degrees: %.1f dB without, %.1f dB with reprojection\n", before, after);
    fnl_rigid_pose other = now; /* a degree off is worse: what is left is the second filtering of fine detail */
    other.rotation = quat_axis_angle(vec3_make(0, 1, 0), 2 * atan2f(then.rotation.y, then.rotation.w) + 3 * degree);
    assert_true(reprojected(c, other, FNL_REPROJECTION_ROTATION, &turned.shot.color, 8) < after - 1);
    if (after < 25 || after < before + 8) fail_msg("turned: %.2f dB without, %.2f dB with reprojection", before, after);
    assert_true(reprojected(c, now, FNL_REPROJECTION_DEPTH, &turned.shot.color, 8) > after - 0.5);

    now = then;
    now.position = vec3_add(then.position, (vec3){0.12f, 0.05f, 0.08f});
    struct rendered moved = render(&stage, &p, now);
    const double rotation = reprojected(c, now, FNL_REPROJECTION_ROTATION, &moved.shot.color, 12), depth = reprojected(c, now, FNL_REPROJECTION_DEPTH, &moved.shot.color, 12);
    printf("moved by 15 cm: %.1f dB by rotation, %.1f dB by depth\n", rotation, depth);
    if (depth < rotation + 2) fail_msg("moved: %.2f dB by rotation, %.2f dB by depth", rotation, depth);
    shot_free(&old.shot);
    shot_free(&turned.shot);
    shot_free(&moved.shot);
    fnl_compositor_destroy(&c);
    stage_close(&stage);
}

/*
 * A display of 90 Hz on a virtual clock. The application takes 8 ms for a frame, but stalls once for 20 ms more; the compositor takes the newest finished
 * frame at each refresh and turns it to the head of that moment (VR-12).
 */
static void paint_far_dot(uint32_t eye, float x, float y, uint8_t pixel[4]) {
    UNUSED(eye);
    const float dx = x + 0.5f - EYE / 2, dy = y + 0.5f - EYE / 2;
    memset(pixel, dx * dx + dy * dy < 9 ? 255 : 0, 3);
    pixel[3] = 255;
}

static float yaw_at(double time) { return 0.15f * sinf((float)time * 12); }
static fnl_rigid_pose looking(double time) { return (fnl_rigid_pose){{0, 0, 0}, quat_axis_angle(vec3_make(0, 1, 0), yaw_at(time))}; }

static void test_a_stall_misses_no_refresh_VR_12(void **state) {
    UNUSED(state);
    fnl_compositor_params p = params_of(EYE, EYE, 1, NULL);
    p.eyes[0].eye.pose = nowhere;
    fnl_compositor *c = make(&p);
    fnl_image dot = painted(EYE, EYE, 1, paint_far_dot); /* straight ahead of the head that it was rendered for */
    const double refresh = 1 / 90.0;
    double finished = 0.008, rendered_for = 0, started = 0;
    uint32_t repeated = 0, frames = 0, number = 0;
    for (uint32_t vsync = 1; vsync <= 14; vsync++) {
        const double now = vsync * refresh;
        for (; finished <= now; number++) { /* each begins at a refresh */
            rendered_for = started;
            assert_int_equal(submit(c, &dot, NULL, looking(rendered_for)), FNL_OK);
            frames++;
            started = ceil(finished / refresh) * refresh;
            finished = started + 0.008 + (frames == 5 ? 0.020 : 0);
        }
        fnl_image out = compose(c, &(fnl_composition){.head = looking(now)});
        /* The dot stays where it is in the world: to the left by as much as the head has turned to the left's opposite since. */
        double sum = 0, weight = 0;
        for (uint32_t x = 0; x < EYE; x++) {
            const double w = (double)decode_srgb((float)pixel_of(&out, x, EYE / 2)[1] / 255);
            sum += w * (x + 0.5);
            weight += w;
        }
        const double wanted = EYE / 2 * (1 + tan((double)(yaw_at(now) - yaw_at(rendered_for))));
        if (weight < 3) fail_msg("refresh %u shows nothing", vsync);
        if (fabs(sum / weight - wanted) > 0.3) fail_msg("refresh %u: the dot is at %.2f, should be at %.2f", vsync, sum / weight, wanted);
        fnl_compositor_stats stats;
        assert_int_equal(fnl_compositor_query_stats(c, &stats), FNL_OK);
        assert_int_equal(stats.composed, vsync);
        assert_int_equal(stats.submitted, frames);
        repeated += stats.repeated > 1;
        release(&out);
    }
    assert_int_equal(repeated, 2); /* 28 ms are more than two refreshes */
    release(&dot);
    fnl_compositor_destroy(&c);
}

/* ---- layers ---- */

static void paint_edge(uint32_t eye, float x, float y, uint8_t pixel[4]) {
    UNUSED(eye);
    UNUSED(y);
    memset(pixel, x < 256 ? 0 : 255, 3);
    pixel[3] = 255;
}
static void paint_grey(uint32_t eye, float x, float y, uint8_t pixel[4]) {
    UNUSED(eye);
    UNUSED(x);
    UNUSED(y);
    memset(pixel, 40, 3);
    pixel[3] = 255;
}

/* Pixels of the display over which an edge rises from a tenth to nine tenths. */
static double edge_width(const fnl_image *out, uint32_t row, uint32_t from, uint32_t to) {
    double at[2] = {-1, -1};
    for (uint32_t x = from; x < to; x++) {
        const double a = (double)decode_srgb((float)pixel_of(out, x, row)[1] / 255), b = (double)decode_srgb((float)pixel_of(out, x + 1, row)[1] / 255);
        for (int i = 0; i < 2; i++) {
            const double level = i ? 0.9 : 0.1;
            if (at[i] < 0 && a < level && b >= level) at[i] = x + (level - a) / (b - a);
        }
    }
    assert_true(at[0] >= 0 && at[1] >= at[0]);
    return at[1] - at[0];
}

/* How much of the contrast of thin stripes is left: the standard deviation by the mean, 1 where they are black and white. */
static void paint_stripes(uint32_t eye, float x, float y, uint8_t pixel[4]) {
    UNUSED(eye);
    UNUSED(y);
    memset(pixel, (uint32_t)x / 8 % 2 ? 255 : 0, 3);
    pixel[3] = 255;
}
static double contrast(const fnl_image *out, uint32_t row, uint32_t from, uint32_t to) {
    double sum = 0, squares = 0;
    for (uint32_t x = from; x < to; x++) {
        const double a = (double)decode_srgb((float)pixel_of(out, x, row)[1] / 255);
        sum += a;
        squares += a * a;
    }
    const double mean = sum / (to - from);
    return sqrt(fmax(squares / (to - from) - mean * mean, 0)) / mean;
}

/* With the scene at half the resolution the layer stays as sharp as before; blended first it does not (VR-14). */
static void test_layers_stay_sharp_VR_14(void **state) {
    UNUSED(state);
    enum { SIDE = 192 };
    double widths[2][2], contrasts[2][2];
    fnl_image edge = painted(512, 512, 1, paint_edge), stripes = painted(512, 512, 1, paint_stripes);
    fnl_layer layer = {.image = &edge, .version = 1, .pose = {{0, 0, -2}, {0, 0, 0, 1}}, .width = 2, .height = 2, .head_locked = true};
    for (uint32_t half = 0; half < 2; half++) {
        fnl_compositor_params p = params_of(SIDE, SIDE, 1, &lens);
        p.eyes[0].eye.pose = nowhere;
        fnl_compositor *c = make(&p);
        fnl_image color = painted(SIDE >> half, SIDE >> half, 1, paint_grey);
        assert_int_equal(submit(c, &color, NULL, nowhere), FNL_OK);
        for (uint32_t first = 0; first < 2; first++) {
            fnl_composition with = {.head = nowhere, .layers = &layer, .layer_count = 1, .layers_first = first};
            layer.image = &edge;
            layer.version = 1;
            fnl_image out = compose(c, &with);
            widths[half][first] = edge_width(&out, SIDE / 2 - 10, SIDE / 4, SIDE * 3 / 4);
            release(&out);
            layer.image = &stripes;
            layer.version = 2;
            out = compose(c, &with);
            contrasts[half][first] = contrast(&out, SIDE / 2 - 10, SIDE * 2 / 5, SIDE * 3 / 5);
            release(&out);
        }
        release(&color);
        fnl_compositor_destroy(&c);
    }
    printf("edge, pixels of the display: layer %.2f, blended first %.2f; scene at half: %.2f, %.2f\n", widths[0][0], widths[0][1], widths[1][0], widths[1][1]);
    printf("contrast of stripes: layer %.2f, blended first %.2f; scene at half: %.2f, %.2f\n", contrasts[0][0], contrasts[0][1], contrasts[1][0], contrasts[1][1]);
    assert_float_equal((float)widths[1][0], (float)widths[0][0], 0.01f);
    assert_float_equal((float)contrasts[1][0], (float)contrasts[0][0], 0.01f);
    assert_true(widths[0][0] <= widths[0][1] && contrasts[0][0] >= contrasts[0][1]);
    assert_true(widths[1][1] > 1.5 * widths[1][0] && contrasts[1][1] < 0.7 * contrasts[1][0]);
    release(&edge);
    release(&stripes);
}

/* A layer in the world moves against the head, one in the head does not; it is seen from its front alone. */
static void test_layers_lie_where_they_are(void **state) {
    UNUSED(state);
    enum { SIDE = 64 };
    fnl_compositor_params p = params_of(SIDE, SIDE, 2, NULL);
    fnl_compositor *c = make(&p);
    fnl_image white = painted(4, 4, 1, paint_edge), behind = painted(SIDE, 2 * SIDE, 1, paint_grey);
    memset(white.pixels, 255, 64);
    assert_int_equal(submit(c, &behind, NULL, nowhere), FNL_OK);
    for (uint32_t locked = 0; locked < 2; locked++)
        for (uint32_t back = 0; back < 2; back++) {
            const fnl_layer layer = {&white, 1, {{0, 0, -1}, back ? (quat){0, 1, 0, 0} : (quat){0, 0, 0, 1}}, 0.25f, 0.5f, locked};
            const fnl_rigid_pose head = {{0.125f, 0, 0}, {0, 0, 0, 1}};
            fnl_image out = compose(c, &(fnl_composition){.head = head, .layers = &layer, .layer_count = 1});
            for (uint32_t eye = 0; eye < 2; eye++) {
                double sum = 0;
                uint32_t count = 0;
                for (uint32_t y = 0; y < SIDE; y++)
                    for (uint32_t x = 0; x < SIDE; x++)
                        if (pixel_of(&out, x + eye * SIDE, y)[0] > 128) sum += x + 0.5, count++;
                        else assert_int_equal(pixel_of(&out, x + eye * SIDE, y)[0], 40); /* beside the layer is what is behind it */
                if (back) {
                    assert_int_equal(count, 0);
                    continue;
                }
                const double at = (locked ? 0 : -0.125) + (eye ? -0.032 : 0.032);
                assert_int_equal(count, 8 * 16); /* a quarter by a half of 2 in 64 pixels */
                assert_float_equal((float)(sum / count), (float)(SIDE / 2 * (1 + at)), 0.51f);
            }
            release(&out);
        }
    release(&white);
    release(&behind);
    fnl_compositor_destroy(&c);
}

/* 0.75 to 3.5 m from the head, wherever that is; the log is told once. */
static void test_layers_are_at_a_comfortable_distance_VR_22(void **state) {
    UNUSED(state);
    static const struct {
        float z;
        bool locked;
        uint32_t wanted;
    } rows[] = {{-1, true, 0}, {-0.76f, true, 0}, {-0.7f, true, 1}, {-3.4f, true, 0}, {-3.6f, true, 1}, {-3.6f, false, 0}, {-1, false, 1}};
    const fnl_rigid_pose head = {{0, 0, -0.5f}, {0, 0, 0, 1}};
    fnl_compositor_params p = params_of(32, 32, 1, NULL);
    fnl_compositor *c = make(&p);
    fnl_image white = painted(4, 4, 1, paint_grey);
    const int before = test_device_memory.warnings;
    for (uint32_t i = 0; i < COUNT_OF(rows); i++) {
        const fnl_layer layer = {&white, 1, {{0, 0, rows[i].z}, {0, 0, 0, 1}}, 0.25f, 0.5f, rows[i].locked};
        fnl_compositor_stats stats;
        fnl_image out = compose(c, &(fnl_composition){.head = head, .layers = &layer, .layer_count = 1});
        release(&out);
        assert_int_equal(fnl_compositor_query_stats(c, &stats), FNL_OK);
        assert_int_equal(stats.layers_uncomfortable, rows[i].wanted);
        assert_int_equal(test_device_memory.warnings - before, i >= 2);
    }
    release(&white);
    fnl_compositor_destroy(&c);
}

/* ---- views, misuse ---- */

static void test_views_of_what_goes_on(void **state) {
    UNUSED(state);
    enum { SIDE = 128 };
    fnl_compositor_params p = params_of(SIDE, SIDE, 1, &lens);
    p.eyes[0].visible_radius = 0.9f;
    p.trim = false;
    fnl_compositor *c = make(&p);
    fnl_image empty = compose(c, &(fnl_composition){.head = nowhere}); /* before the first frame */
    for (uint32_t i = 0; i < SIDE * SIDE; i++) assert_int_equal(pixel_of(&empty, i % SIDE, i / SIDE)[1], 0);
    release(&empty);
    fnl_image color = painted(SIDE, SIDE, 1, paint_grey);
    assert_int_equal(submit(c, &color, NULL, nowhere), FNL_OK);
    fnl_image mask = compose(c, &(fnl_composition){.head = nowhere, .view = FNL_DISPLAY_VIEW_MASK});
    assert_true(pixel_of(&mask, 1, 1)[0] > 150 && pixel_of(&mask, 1, 1)[1] < 100); /* magenta */
    assert_int_equal(pixel_of(&mask, SIDE / 2, SIDE / 2)[0], 40);
    release(&mask);
    fnl_image mesh = compose(c, &(fnl_composition){.head = nowhere, .view = FNL_DISPLAY_VIEW_MESH});
    uint32_t lines = 0;
    for (uint32_t i = 0; i < SIDE * SIDE; i++) lines += pixel_of(&mesh, i % SIDE, i / SIDE)[1] == 255;
    assert_true(lines > SIDE * SIDE / 8);
    release(&mesh);
    fnl_image fringes = compose(c, &(fnl_composition){.head = nowhere, .view = FNL_DISPLAY_VIEW_FRINGES});
    assert_true(pixel_of(&fringes, SIDE / 2, SIDE / 2)[2] < 40);
    assert_true(pixel_of(&fringes, SIDE / 8, SIDE / 2)[0] > 20 && pixel_of(&fringes, SIDE / 8, SIDE / 2)[0] > pixel_of(&fringes, SIDE / 4, SIDE / 2)[0]);
    assert_true(pixel_of(&fringes, SIDE / 8, SIDE / 2)[2] > pixel_of(&fringes, SIDE / 4, SIDE / 2)[2] && pixel_of(&fringes, SIDE / 8, SIDE / 2)[1] == 0);
    release(&fringes);
    release(&color);
    fnl_compositor_destroy(&c);
}

static void test_misuse(void **state) {
    UNUSED(state);
    fnl_compositor *c = NULL;
    fnl_compositor_params p = params_of(32, 32, 2, NULL);
    p.eye_count = 3;
    assert_int_equal(fnl_compositor_create(harness_device(), &p, &c), FNL_ERROR_INVALID);
    p = params_of(32, 32, 2, NULL);
    p.eyes[1].lens.k[2][3] = NAN;
    assert_int_equal(fnl_compositor_create(harness_device(), &p, &c), FNL_ERROR_INVALID);
    p = params_of(32, 32, 2, NULL);
    p.eyes[0].right = p.eyes[0].left;
    assert_int_equal(fnl_compositor_create(harness_device(), &p, &c), FNL_ERROR_INVALID);
    assert_null(c);
    p = params_of(32, 32, 2, NULL);
    c = make(&p);
    fnl_image odd = painted(5, 5, 1, paint_grey), out;
    assert_int_equal(submit(c, &odd, NULL, nowhere), FNL_ERROR_INVALID); /* five rows for two eyes */
    fnl_rigid_pose bad = nowhere;
    bad.rotation.w = 3;
    assert_int_equal(fnl_compositor_compose(c, &(fnl_composition){.head = bad}, &out), FNL_ERROR_INVALID);
    const fnl_layer flat = {&odd, 1, nowhere, 0, 1, true};
    assert_int_equal(fnl_compositor_compose(c, &(fnl_composition){.head = nowhere, .layers = &flat, .layer_count = 1}, &out), FNL_ERROR_INVALID);
    assert_int_equal(fnl_compositor_compose(c, &(fnl_composition){.head = nowhere, .layer_count = 9}, &out), FNL_ERROR_INVALID);
    assert_int_equal(fnl_compositor_compose(c, &(fnl_composition){.head = nowhere, .view = FNL_DISPLAY_VIEW_COUNT}, &out), FNL_ERROR_INVALID);
    release(&odd);
    fnl_compositor_destroy(&c);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_identity_is_a_copy_VR_8_VR_12, harness_check),
        cmocka_unit_test_teardown(test_mesh_is_close_to_the_polynomial_VR_8, harness_check),
        cmocka_unit_test_teardown(test_mesh_and_pixels_give_one_picture_VR_8, harness_check),
        cmocka_unit_test_teardown(test_colours_come_apart_VR_8, harness_check),
        cmocka_unit_test_teardown(test_trimming_saves_work_VR_9, harness_check),
        cmocka_unit_test_teardown(test_late_poses_VR_12, harness_check),
        cmocka_unit_test_teardown(test_a_stall_misses_no_refresh_VR_12, harness_check),
        cmocka_unit_test_teardown(test_layers_stay_sharp_VR_14, harness_check),
        cmocka_unit_test_teardown(test_layers_lie_where_they_are, harness_check),
        cmocka_unit_test_teardown(test_layers_are_at_a_comfortable_distance_VR_22, harness_check),
        cmocka_unit_test_teardown(test_views_of_what_goes_on, harness_check),
        cmocka_unit_test_teardown(test_misuse, harness_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
