/* SPDX-License-Identifier: MIT */
/** What temporal antialiasing collects: against the recurrence on the CPU, over cuts and edits of the scene, and in two runs. */
#include "passes/aa/taa.h"
#include "tests/temporal_cases.h"
#include "render/view.h"

/* ---- against the recurrence on the CPU ---- */

enum { BAR = 2, BARS = 80, ROWS = 64, WIRE = 60 };

/*
 * A wall of grey bars across the view, two rows each, under ambient light alone: everything depends on the row only. A wire before it, a fifth
 * of a pixel wide, has the wall's colours, and is seen by few frames.
 */
static fnl_scene *barred_wall(void) {
    static const float greys[5] = {0.9f, 0.25f, 0.6f, 0.1f, 0.75f};
    fnl_scene *scene = test_scene();
    uint32_t meshes[5];
    for (int i = 0; i < 5; i++) {
        struct scene_material material = scene_material_default();
        material.base_color = (vec4){greys[i], greys[i], greys[i], 1};
        material.metallic = 0;
        meshes[i] = test_quad_mesh(scene, scene_add_material(scene, &material));
    }
    for (int i = 0; i < BARS; i++) {
        float y = BAR * ((float)i + 0.5f - BARS / 2) / 32;
        test_place(scene, meshes[i % 5], (vec3){0, y, 0}, (vec3){6, BAR / 64.0f, 1});
        test_place(scene, meshes[i % 5], (vec3){(WIRE + 0.5f) / 32 - 1, y, 1}, (vec3){0.1f / 32, BAR / 64.0f, 1});
    }
    return scene;
}

static void set_ambient(fnl_scene *scene, float level) {
    assert_int_equal(fnl_scene_set_ambient(scene, (vec3){level, level, level}, (vec3){level, level, level}), FNL_OK);
}

/* The bar of a row, 0 .. 4, when the wall has moved down by `shift` pixels; no sample is near a border of two. */
static int bar_of(int row, double shift) {
    double up = BARS / 2 * BAR + ROWS / 2 - (row + 0.5 + shift);
    assert_true(fabs(up - round(up)) > 0.005);
    return (int)floor(up / BAR) % 5;
}

struct collected {
    double color[ROWS], count[ROWS];
};

/* One frame of rows `now` as taa.h describes it; `fall`: by how many rows history lies below, `speed`: the length of the motion. */
static void collect_rows(struct collected *c, const double now[ROWS], double fall, double speed, bool still) {
    struct collected before = *c;
    for (int y = 0; y < ROWS; y++) {
        double place = y + 0.5 + fall, old = before.color[y], count = before.count[y];
        if (!still) {
            double sum = 0, squares = 0, base = floor(place - 0.5), t = place - 0.5 - base;
            for (int k = -1; k <= 1; k++) {
                double near = now[CLAMP(y + k, 0, ROWS - 1)];
                sum += near / 3;
                squares += near * near / 3;
            }
            const double weights[4] = {-0.5 * t + t * t - 0.5 * t * t * t, 1 - 2.5 * t * t + 1.5 * t * t * t,
                                       0.5 * t + 2 * t * t - 1.5 * t * t * t, -0.5 * t * t + 0.5 * t * t * t};
            old = 0;
            for (int k = 0; k < 4; k++) old += weights[k] * before.color[CLAMP((int)base + k - 1, 0, ROWS - 1)];
            double spread = fmax(1.5 * sqrt(fmax(squares - sum * sum, 0)), 1e-5);
            old = fmax(fmin(fmax(fmax(old, 0), sum - spread), sum + spread), 0);
            bool inside = place >= 0 && place < ROWS;
            count = inside ? fmin(before.count[(int)place], 16 + (6 - 16) * fmin(speed, 1)) : 0;
        }
        c->color[y] = count > 0 ? old + (now[y] - old) / (count + 1) : now[y];
        c->count[y] = count + 1;
    }
}

/*
 * What is collected of a wall whose light changes with every frame, while the camera rests, creeps, and moves fast, is at each
 * pixel what the recurrence gives: jitter, motion, cubic fetch, clipping, and how many frames history counts for.
 */
static void test_history_counts_as_it_should_ES_21(void **state) {
    UNUSED(state);
    static const struct {
        int frames;
        double right, down; /* pixels a frame */
        bool still;         /* nor does the light change */
    } phases[] = {{20, 0, 0, false}, {10, 1.25, 0, false}, {12, 0.25, 0, false},   {6, 0, 0.375, false},
                  {9, 0, -1, false}, {24, 0, 0, true},     {8, 0.3, 0.7, false}, {6, 0.1, -2.2, false}};
    fnl_scene *scene = barred_wall();
    fnl_renderer *renderer = test_renderer(scene);
    fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE);
    set_ambient(scene, 1);
    fnl_image plain = test_render(scene, &frame, FNL_OUTPUT_RADIANCE);
    double greys[5], worst = 0, right = 0, down = 0, level = 1;
    for (int y = 0; y < ROWS; y += BAR) greys[bar_of(y, 0.1)] = (double)test_pixel(&plain, 32, (uint32_t)y)[0];
    free_picture(&plain);
    frame.aa = FNL_ANTIALIASING_TAA;
    struct random_state random = {3};
    struct collected rows = {{0}, {0}};
    uint32_t index = 0, wires = 0;
    for (uint32_t phase = 0; phase < COUNT_OF(phases); phase++)
        for (int i = 0; i < phases[phase].frames; i++, index++) {
            bool still = phases[phase].still && i > 0;
            double dx = phases[phase].right, dy = phases[phase].down, now[ROWS];
            right += dx;
            down += dy;
            if (!still) {
                level = (double)random_range(&random, 0.2f, 0.33f) * (index % 7 == 6 ? 3 : 1); /* beyond the spread too */
                set_ambient(scene, (float)level);
            }
            frame.camera.position.x = frame.camera.target.x = (float)(-right / 32);
            frame.camera.position.y = frame.camera.target.y = (float)(down / 32);
            test_render_frame(renderer, &frame);
            wires += phase == 0 && fabsf(pixel_jitter(index).x) < 0.1f;
            for (int y = 0; y < ROWS; y++) now[y] = level * greys[bar_of(y, (double)pixel_jitter(index).y - down)];
            collect_rows(&rows, now, -dy, hypot(dx, dy), still);
            fnl_image image = test_read(renderer, FNL_OUTPUT_RADIANCE);
            for (uint32_t y = 0; y < ROWS; y++)
                for (int k = 0; k < (phase ? 2 : 4); k++) {
                    /* What comes in at the left is still collecting. Beside the wire while it stays there. */
                    uint32_t x = (const uint32_t[]){32, 56, WIRE - 1, WIRE + 1}[k];
                    double off = fabs((double)test_pixel(&image, x, y)[0] - rows.color[y]);
                    worst = fmax(worst, off);
                    if (off > 1e-3) fail_msg("phase %u, frame %d, pixel %u, %u: off by %g", phase, i, x, y, off);
                }
            free_picture(&image);
        }
    print_message("%u frames, %u with a wire at first: off by at most %.1e\n", index, wires, worst);
    assert_in_range(wires, 3, 10);
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* ---- contracts ---- */

/* A cut, another size: the next frame is as if it were the first, and that is one without antialiasing. */
static void test_history_resets_ES_21(void **state) {
    UNUSED(state);
    fnl_scene *scene = fence();
    fnl_renderer *renderer = test_renderer(scene);
    fnl_frame frame = fence_frame(FNL_OUTPUT_RADIANCE), plain = frame;
    frame.aa = FNL_ANTIALIASING_TAA;
    for (int change = 0; change < 3; change++) {
        for (int i = 0; i < 5; i++) test_render_frame(renderer, &frame);
        if (change == 1) {
            frame.reset_history = true;
            plain.camera.position.x = frame.camera.position.x = 2;
        }
        if (change == 2) plain.width = frame.width = 55;
        test_render_frame(renderer, &frame);
        fnl_image after = test_read(renderer, FNL_OUTPUT_RADIANCE);
        fnl_image expected = test_render(scene, &plain, FNL_OUTPUT_RADIANCE);
        assert_int_equal(test_equal(&after, &expected), change != 0);
        free_picture(&after);
        free_picture(&expected);
        frame.reset_history = false;
    }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* ---- edits of the scene ---- */

struct edited {
    fnl_scene *scene;
    fnl_renderer *renderer;
    uint32_t bar, morphed, gone; /* nodes; the last is out of the view */
    uint32_t white;              /* mesh */
};

static struct edited open_edited(void) {
    struct edited e = {.scene = fence(), .bar = 3};
    struct scene_material white = test_unlit(1, 1, 1);
    e.white = test_quad_mesh(e.scene, scene_add_material(e.scene, &white));
    e.gone = test_place(e.scene, e.white, (vec3){50, 0, 0}, (vec3){1, 1, 1});
    e.morphed = test_place(e.scene, morphed_square(e.scene), (vec3){-1.6f, -1.2f, 1}, (vec3){1, 1, 1});
    scene_update_transforms(e.scene);
    e.renderer = test_renderer(e.scene);
    return e;
}

/* What moves in both scenes: a bar, and the square by its target. */
static void move_on(struct edited *e, uint32_t index) {
    const mat4 m = mat4_from_trs((vec3){-1.5f + 0.07f * (float)index, 0, 0.3f}, quat_identity(), (vec3){0.07f, 2, 1});
    assert_int_equal(fnl_scene_set_instance_transform(e->scene, id_of(e->scene, e->bar), &m), FNL_OK);
    set_weight(e->scene, e->morphed, 0.1f * (float)index);
}

static void add_white(struct edited *e, float x, float y, float z) {
    fnl_instance_id id;
    const mat4 m = mat4_from_trs((vec3){x, y, z}, quat_identity(), (vec3){0.35f, 0.35f, 1});
    assert_int_equal(fnl_scene_add_instance(e->scene, (fnl_mesh_id){e->white, 1}, &m, &id), FNL_OK);
}

/* One is new in the view, in the place of one that went. The other way, so many are new besides that buffers grow, with a heavy mesh. */
static void change_structure(struct edited *e, int way) {
    fnl_scene *scene = e->scene;
    assert_int_equal(fnl_scene_remove_instance(scene, id_of(scene, e->gone)), FNL_OK);
    add_white(e, -0.6f, 0.9f, 2);
    if (way == 0) return;
    for (int i = 0; i < 100; i++) add_white(e, 60, 0, 0);
    struct scene_material heavy = test_unlit(1, 0, 0);
    uint32_t mesh = test_sphere_mesh(scene, scene_add_material(scene, &heavy), 40);
    test_place(scene, mesh, (vec3){-60, 0, 0}, (vec3){1, 1, 1});
    fnl_material_params look = fnl_material_params_default(); /* of nothing */
    fnl_material_id id;
    assert_int_equal(fnl_scene_add_material(scene, &look, &id), FNL_OK);
}

/* Is there a pixel among the 3 x 3 around that the last frame did not draw; are all of them so? */
static void look_around(const fnl_image *motion, uint32_t x, uint32_t y, bool *any, bool *all) {
    *any = false;
    *all = true;
    for (int i = 0; i < 9; i++) {
        bool fresh = test_pixel(motion, x + (uint32_t)(i % 3) - 1, y + (uint32_t)(i / 3) - 1)[3] == 0;
        *any = *any || fresh;
        *all = *all && fresh;
    }
}

/*
 * An instance that comes has no history, and is shown as without antialiasing. Everything else keeps its own, to the bit: what
 * stands, what moves, and what is deformed while buffers move.
 */
static void test_history_survives_edits_ES_21(void **state) {
    UNUSED(state);
    enum { EDITED = 6 };
    for (int way = 0; way < 2; way++) {
        struct edited with = open_edited(), without = open_edited();
        fnl_frame frame = fence_frame(FNL_OUTPUT_RADIANCE | FNL_OUTPUT_MOTION);
        frame.aa = FNL_ANTIALIASING_TAA;
        frame.camera.position.x = 0.5f;
        for (uint32_t i = 0; i <= EDITED; i++) {
            move_on(&with, i);
            move_on(&without, i);
            if (i == EDITED) change_structure(&with, way);
            test_render_frame(with.renderer, &frame);
            test_render_frame(without.renderer, &frame);
        }
        assert_int_equal(with.renderer->device_scene->upload_count, 2);
        fnl_image picture = test_read(with.renderer, FNL_OUTPUT_RADIANCE), motion = test_read(with.renderer, FNL_OUTPUT_MOTION);
        fnl_image other = test_read(without.renderer, FNL_OUTPUT_RADIANCE), other_motion = test_read(without.renderer, FNL_OUTPUT_MOTION);
        fnl_frame plain = fence_frame(FNL_OUTPUT_RADIANCE);
        plain.camera = frame.camera;
        plain.jitter = pixel_jitter(EDITED);
        fnl_image raw = test_render(with.scene, &plain, FNL_OUTPUT_RADIANCE);
        uint32_t fresh = 0, kept = 0, averaged = 0, moving = 0;
        for (uint32_t y = 1; y < HEIGHT - 1; y++)
            for (uint32_t x = 1; x < WIDTH - 1; x++) {
                bool any, all;
                look_around(&motion, x, y, &any, &all);
                const float *p = test_pixel(&picture, x, y);
                if (all) {
                    fresh++;
                    assert_memory_equal(p, test_pixel(&raw, x, y), 16);
                }
                if (any) continue;
                kept++;
                assert_memory_equal(p, test_pixel(&other, x, y), 16);
                assert_memory_equal(test_pixel(&motion, x, y), test_pixel(&other_motion, x, y), 16);
                averaged += memcmp(p, test_pixel(&raw, x, y), 16) != 0;
                moving += test_pixel(&motion, x, y)[3] > 1.2f;
            }
        assert_true(fresh > 20 && kept > 5500);
        print_message("way %d: %u new, %u kept, of these %u averaged, %u moving\n", way, fresh, kept, averaged, moving);
        assert_true(averaged > kept / 3 && moving > 50);

        /* The frame after knows the new one, too. */
        test_render_frame(with.renderer, &frame);
        fnl_image next = test_read(with.renderer, FNL_OUTPUT_MOTION);
        for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) assert_true(test_pixel(&next, i % WIDTH, i / WIDTH)[3] >= 1);
        free_picture(&picture);
        free_picture(&motion);
        free_picture(&other);
        free_picture(&other_motion);
        free_picture(&raw);
        free_picture(&next);
        fnl_renderer_destroy(&with.renderer);
        fnl_renderer_destroy(&without.renderer);
        fnl_scene_destroy(&with.scene);
        fnl_scene_destroy(&without.scene);
    }
}

/* Camera, an object and lights move, in two runs: the same bytes; and no frame but the first ones allocates. */
static void test_sequences_repeat_ES_21(void **state) {
    UNUSED(state);
    fnl_image pictures[2];
    for (int run = 0; run < 2; run++) {
        fnl_scene *scene = fence();
        fnl_renderer *renderer = test_renderer(scene);
        fnl_frame frame = fence_frame(FNL_OUTPUT_COLOR | FNL_OUTPUT_MOTION);
        frame.aa = FNL_ANTIALIASING_TAA;
        frame.exposure = FNL_EXPOSURE_AUTO;
        long long allocations = 0;
        for (int i = 0; i < 12; i++) {
            if (i % 4 == 0) frame.camera.position.x += 0.05f;
            if (i % 3 == 1) {
                mat4 m = mat4_from_trs((vec3){0.1f * (float)i, 0, 0}, quat_identity(), (vec3){0.1f, 1, 1});
                scene_move_nodes(scene, &(fnl_instance_id){.index = 3}, &m, 1);
            }
            test_render_frame(renderer, &frame);
            if (i == 6) allocations = atomic_load(&test_device_memory.allocations);
        }
        assert_int_equal(atomic_load(&test_device_memory.allocations), allocations);
        pictures[run] = test_read(renderer, FNL_OUTPUT_COLOR);
        fnl_renderer_destroy(&renderer);
        fnl_scene_destroy(&scene);
    }
    assert_true(test_equal(&pictures[0], &pictures[1]));
    free_picture(&pictures[0]);
    free_picture(&pictures[1]);
}

const struct CMUnitTest history_tests[] = {
    cmocka_unit_test(test_history_counts_as_it_should_ES_21),
    cmocka_unit_test(test_history_resets_ES_21),
    cmocka_unit_test(test_history_survives_edits_ES_21),
    cmocka_unit_test(test_sequences_repeat_ES_21),
};
const size_t history_test_count = COUNT_OF(history_tests);
