/* SPDX-License-Identifier: MIT */
/* Walls and eyes: files of displays, frusta through corners, pictures that meet at the edges of walls, and several devices. */
#include "cave/cave.h"
#include "tests/frame_plain.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

const char program_commit[] = "test";

static char folder[] = "/tmp/fanal-cave-XXXXXX";

static const char *path_of(const char *name) {
    static char path[4][128];
    static int turn;
    snprintf(path[turn = (turn + 1) % 4], sizeof path[0], "%s/%s", folder, name);
    return path[turn];
}

static const char *write_file(const char *name, const char *text) {
    FILE *file = fopen(path_of(name), "w");
    assert_non_null(file);
    assert_true(fputs(text, file) >= 0 && fclose(file) == 0);
    return path_of(name);
}

static struct cave_options options_for(const char *scene) {
    struct cave_options o = {.render = {.frame = frame_plain(), .world = world_options_default(), .frame_count = 1, .frame_time = 0.25, .quiet = true, .validate = true}};
    o.render.world.scene = scene;
    o.render.no_cache = true;
    o.render.outputs[0] = "x.png";
    o.render.output_count = 1;
    o.render.frame.shading = FNL_SHADING_FORWARD;
    o.render.frame.lists = FNL_LISTS_ALL;
    o.render.frame.exposure = FNL_EXPOSURE_EV;
    return o;
}

/* ---- frusta ---- */

/* Where a point falls in the picture of a camera: pixels from the left and from the top. */
static fnl_vec2 pixel_of(const fnl_camera *c, uint32_t width, uint32_t height, struct cave_vector p) {
    const struct cave_vector eye = {(double)c->position.x, (double)c->position.y, (double)c->position.z};
    struct cave_vector ahead = cave_subtract((struct cave_vector){(double)c->target.x, (double)c->target.y, (double)c->target.z}, eye);
    ahead = cave_add_scaled((struct cave_vector){0, 0, 0}, ahead, 1 / cave_length(ahead));
    struct cave_vector right = cave_cross(ahead, (struct cave_vector){(double)c->up.x, (double)c->up.y, (double)c->up.z});
    right = cave_add_scaled((struct cave_vector){0, 0, 0}, right, 1 / cave_length(right));
    const struct cave_vector up = cave_cross(right, ahead), d = cave_subtract(p, eye);
    const double half = tan((double)c->vertical_fov / 2), z = cave_dot(d, ahead);
    const double x = cave_dot(d, right) / z / (half * width / height * (double)c->pixel_aspect) + (double)c->shift.x, y = cave_dot(d, up) / z / half + (double)c->shift.y;
    return (fnl_vec2){(float)((x + 1) / 2 * width), (float)((1 - y) / 2 * height)};
}

static double random_in(double low, double high) { return low + (high - low) * rand() / RAND_MAX; }

/* The corners of a wall are those of its picture, wherever wall, head and CAVE are, and however pixels are shaped. */
static void test_corners_of_walls_are_corners_of_pictures(void **state) {
    (void)state;
    srand(5);
    for (int i = 0; i < 300; i++) {
        struct cave_displays d = {.source = (char *)"test", .wall_count = 1, .ipd = 0.064, .near_distance = 0.1};
        struct cave_quaternion q = {random_in(-1, 1), random_in(-1, 1), random_in(-1, 1), random_in(-1, 1)};
        const double length = sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w), width = random_in(0.2, 4), height = random_in(0.2, 4);
        q = (struct cave_quaternion){q.x / length, q.y / length, q.z / length, q.w / length};
        struct cave_wall *w = &d.walls[0];
        w->stereo = true;
        w->lower_left = (struct cave_vector){random_in(-3, 3), random_in(-3, 3), random_in(-3, 3)};
        w->lower_right = cave_add_scaled(w->lower_left, cave_rotate(q, (struct cave_vector){1, 0, 0}), width);
        w->upper_left = cave_add_scaled(w->lower_left, cave_rotate(q, (struct cave_vector){0, 1, 0}), height);
        const struct cave_place place = {{{random_in(-9, 9), random_in(-9, 9), random_in(-9, 9)}, cave_turn(random_in(-3, 3))}, random_in(0.2, 5)};
        const struct cave_vector in_front = cave_rotate(q, (struct cave_vector){random_in(-2, 2), random_in(-2, 2), random_in(0.2, 3)});
        const struct cave_moment m = {.head = {cave_add_scaled(w->lower_left, in_front, 1), cave_turn(random_in(-3, 3))}, .eyes = {[CAVE_LEFT] = {-0.032, 0, 0}, [CAVE_RIGHT] = {0.032, 0, 0}}};
        const struct cave_view view = {.width = 200, .height = 70, .eye = (i & 1) ? CAVE_LEFT : CAVE_RIGHT};
        fnl_camera camera;
        assert_true(cave_view_camera(&d, &place, &m, &view, &camera));
        const fnl_vec2 a = pixel_of(&camera, 200, 70, cave_placed(&place, w->lower_left)), b = pixel_of(&camera, 200, 70, cave_placed(&place, w->lower_right)),
                       c = pixel_of(&camera, 200, 70, cave_placed(&place, w->upper_left));
        const float most = 0.02f; /* pixels */
        assert_float_equal(a.x, 0, most);
        assert_float_equal(a.y, 70, most);
        assert_float_equal(b.x, 200, most);
        assert_float_equal(b.y, 70, most);
        assert_float_equal(c.x, 0, most);
        assert_float_equal(c.y, 0, most);
        /* The eye is where the head has it, whatever the wall. */
        const struct cave_vector eye = cave_placed(&place, cave_add_scaled(m.head.position, cave_rotate(m.head.rotation, m.eyes[view.eye]), 1));
        assert_float_equal(camera.position.x, eye.x, 1e-4);
        assert_float_equal(camera.position.z, eye.z, 1e-4);
        assert_float_equal(camera.near_distance, 0.1 * place.scale, 1e-6);
    }
}

/* Messages to stderr while it is on. */
static char messages[4096];
static int old_stderr;
static void catch_messages(void) {
    fflush(stderr);
    old_stderr = dup(STDERR_FILENO);
    assert_non_null(freopen(path_of("messages"), "w", stderr));
}
static void release_messages(void) {
    fflush(stderr);
    dup2(old_stderr, STDERR_FILENO);
    close(old_stderr);
    FILE *file = fopen(path_of("messages"), "r");
    assert_non_null(file);
    messages[fread(messages, 1, sizeof messages - 1, file)] = 0;
    fclose(file);
}
static void expect_message(const char *wanted) {
    if (!strstr(messages, wanted)) fail_msg("'%s' is not in: %s", wanted, messages);
}

static void test_eyes_behind_walls(void **state) {
    (void)state;
    struct cave_displays d;
    assert_true(cave_displays_load("builtin:three", &d));
    const struct cave_place place = {{{0, 0, 0}, {0, 0, 0, 1}}, 2};
    const struct {
        double z;
        const char *wanted;
    } cases[] = {{-1.5, "0.5 m behind the wall"}, {-1, "on the wall's plane"}, {-0.9999, "0.0001 m in front of the wall's plane, too near"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct cave_moment m = cave_predict(&(struct cave_options){.render.frame_time = 1}, &d, 3, 0);
        const struct cave_view view = {.wall = 0, .width = 64, .height = 36, .eye = CAVE_LEFT};
        fnl_camera camera;
        m.head.position.z = cases[i].z;
        catch_messages();
        const bool good = cave_view_camera(&d, &place, &m, &view, &camera);
        release_messages();
        assert_false(good);
        expect_message("builtin:three: /walls/0: 'front/left'");
        expect_message("frame 3, 3 s");
        expect_message(cases[i].wanted);
    }
    cave_displays_free(&d);
}

/* ---- files ---- */

static void test_examples_are_of_one_kind_VR_15(void **state) {
    (void)state;
    static const struct {
        const char *name;
        uint32_t walls, views;
    } examples[] = {{"builtin:mono", 1, 1}, {"builtin:stereo", 1, 2}, {"builtin:three", 3, 4}, {"builtin:cave", 5, 10}};
    for (size_t i = 0; i < sizeof examples / sizeof *examples; i++) {
        struct cave_displays d;
        struct cave_view views[CAVE_VIEWS];
        const struct cave_options o = options_for("builtin:room");
        assert_true(cave_displays_load(examples[i].name, &d));
        assert_int_equal(d.wall_count, examples[i].walls);
        assert_int_equal(cave_list_views(&o, &d, 0, views), examples[i].views);
        assert_float_equal(d.ipd, 0.064, 0);
        /* The left eye is on the left, for whoever looks at the front wall. */
        const struct cave_moment m = cave_predict(&o, &d, 0, 0);
        const struct cave_place place = {{{0, 0, 0}, {0, 0, 0, 1}}, 2};
        fnl_camera left, right;
        if (d.walls[0].stereo) {
            assert_true(cave_view_camera(&d, &place, &m, &views[0], &left) && cave_view_camera(&d, &place, &m, &views[1], &right));
            assert_float_equal(right.position.x - left.position.x, 2 * 0.064, 1e-6);
        }
        /* A file with the same text is the same. */
        struct cave_displays read;
        assert_true(cave_displays_load(write_file("example.json", cave_displays_example(examples[i].name)), &read));
        assert_memory_equal(read.walls, d.walls, sizeof d.walls);
        assert_true(read.hash == d.hash);
        cave_displays_free(&read);
        cave_displays_free(&d);
    }
    /* Neighbours of the three displays meet at their edge, turned by 45 degrees. */
    struct cave_displays d;
    assert_true(cave_displays_load("builtin:three", &d));
    const struct cave_vector front = cave_subtract(d.walls[0].lower_right, d.walls[0].lower_left), left = cave_subtract(d.walls[1].lower_right, d.walls[1].lower_left);
    assert_true(cave_length(cave_subtract(d.walls[1].lower_right, d.walls[0].lower_left)) < 1e-9);
    assert_true(cave_length(cave_subtract(d.walls[0].lower_right, d.walls[2].lower_left)) < 1e-9);
    assert_float_equal(cave_dot(front, left) / cave_length(front) / cave_length(left), sqrt(0.5), 1e-6);
    assert_float_equal(cave_length(left), 1.6, 1e-6);
    cave_displays_free(&d);
}

#define WALL "{\"name\": \"w\", \"lower_left\": [-1, 0, -1], \"lower_right\": [1, 0, -1], \"upper_left\": [-1, 1, -1], \"resolution\": [8, 4]"
#define HEAD "\"head\": {\"position\": [0, 1, 0]}"

static void test_broken_files(void **state) {
    (void)state;
    static const struct {
        const char *text, *wanted;
    } cases[] = {
        {"{", "line 1, column 1"},
        {"[]", ": /: must be an object"},
        {"{\"walls\": []}", "/walls: must be an array of 1 to 32 walls"},
        {"{\"wals\": []}", "has no 'wals'; it may have devices, head"},
        {"{\"walls\": [" WALL "}]}", "/head: is missing"},
        {"{\"walls\": [" WALL "}, " WALL "}], " HEAD "}", "/walls/1/name: wall 0 is called 'w' too"},
        {"{\"walls\": [" WALL ", \"colour\": 3}], " HEAD "}", "/walls/0: has no 'colour'"},
        {"{\"walls\": [" WALL ", \"stereo\": 1}], " HEAD "}", "/walls/0/stereo: must be true or false"},
        {"{\"walls\": [" WALL ", \"device\": 0}], " HEAD "}", "/walls/0/device: there are no /devices"},
        {"{\"devices\": [0, -1], \"walls\": [" WALL "}], " HEAD "}", "/devices/1: must be the index or the name"},
        {"{\"devices\": [0], \"walls\": [" WALL ", \"device\": 1}], " HEAD "}", "/walls/0/device: must be a whole number from 0 to 0"},
        {"{\"walls\": [" WALL ", \"rank\": [0, 1]}], " HEAD "}", "/walls/0/rank: must be a number, or on a stereo wall two"},
        {"{\"walls\": [" WALL ", \"rank\": 64}], " HEAD "}", "/walls/0/rank: must be a whole number from 0 to 63"},
        {"{\"walls\": [{\"name\": \"a/b\"}], " HEAD "}", "/walls/0/name: must be 1 to 31 letters"},
        {"{\"walls\": [{\"name\": \"a\", \"lower_left\": [0, 0]}], " HEAD "}", "/walls/0/lower_left: must be 3 numbers"},
        {"{\"walls\": [{\"name\": \"a\", \"lower_left\": [0, 0, 0], \"lower_right\": [1, 0, 0]}], " HEAD "}", "/walls/0/upper_left: is missing"},
        {"{\"walls\": [{\"name\": \"a\", \"lower_left\": [0, 0, 0], \"lower_right\": [1, 0, 0], \"upper_left\": [1, 1, 0]}], " HEAD "}", "/walls/0: is no rectangle: the angle at lower_left is 45.00"},
        {"{\"walls\": [{\"name\": \"a\", \"lower_left\": [0, 0, 0], \"lower_right\": [0, 0, 0], \"upper_left\": [1, 1, 0]}], " HEAD "}", "its sides are 0 m"},
        {"{\"walls\": [{\"name\": \"a\", \"lower_left\": [0, 0, 0], \"lower_right\": [1, 0, 0], \"upper_left\": [0, 1, 0], \"resolution\": [0, 4]}], " HEAD "}", "/walls/0/resolution: must be two whole numbers"},
        {"{\"walls\": [" WALL "}], \"head\": {\"position\": [0, 0, 1], \"rotation\": [0, 0, 0, 2]}}", "/head/rotation: must be a unit quaternion x, y, z, w; its length is 2"},
        {"{\"walls\": [" WALL "}], \"head\": [{\"time\": 1, \"position\": [0, 0, 1]}, {\"time\": 1, \"position\": [0, 0, 1]}]}", "/head/1: times must rise"},
        {"{\"walls\": [" WALL "}], \"head\": [{\"position\": [0, 0, 1]}]}", "/head/0: time must be a number"},
        {"{\"walls\": [" WALL "}], \"head\": \"none.txt\"}", "none.txt: cannot be read"},
        {"{\"walls\": [" WALL "}], \"head\": \"bad.txt\"}", "bad.txt: line 3: must be 'seconds x y z'"},
        {"{\"walls\": [" WALL "}], \"head\": 1}", "/head: must be a pose, a track"},
        {"{\"walls\": [" WALL "}], " HEAD ", \"ipd\": -0.1}", "/ipd: must be a number from 0 to 1"},
        {"{\"walls\": [" WALL "}], " HEAD ", \"near\": 0}", "/near: must be a number from 0.0001"},
        {"{\"walls\": [" WALL "}], " HEAD ", \"origin\": {\"rotation\": [0, 0, 0, 1]}}", "/origin: rotation needs a position"},
        {"{\"walls\": [" WALL "}], " HEAD ", \"origin\": {\"scale\": 0}}", "/origin/scale: must be a number from 0.001"},
    };
    write_file("bad.txt", "# seconds x y z\n0 0 0 1\n1 0 0\n");
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct cave_displays d;
        write_file("bad.json", cases[i].text);
        catch_messages();
        const bool good = cave_displays_load(path_of("bad.json"), &d);
        release_messages();
        cave_displays_free(&d);
        if (good) fail_msg("taken: %s", cases[i].text);
        expect_message(cases[i].wanted);
        expect_message(folder);
        if (strchr(messages, '\n') != messages + strlen(messages) - 1) fail_msg("not one line: %s", messages);
    }
    static const char *const lines[] = {"+1 0 0 1", "1 0x1 0 1", "1 0 inf 1", "1 0 0 1e999", "1 0 0 1x", "1 0 0 1 0 0 0", "1 0 0 1 0 0 0 1 2", "1,0,0,1"};
    for (size_t i = 0; i < sizeof lines / sizeof *lines; i++) {
        char text[128];
        struct cave_displays d;
        snprintf(text, sizeof text, "0 0 0 1 # first\n\t%s\n", lines[i]);
        write_file("bad.txt", text);
        write_file("bad.json", "{\"walls\": [" WALL "}], \"head\": \"bad.txt\"}");
        catch_messages();
        const bool good = cave_displays_load(path_of("bad.json"), &d);
        release_messages();
        cave_displays_free(&d);
        if (good) fail_msg("taken: %s", lines[i]);
        expect_message("bad.txt: line 2: must be 'seconds x y z'");
    }
}

static void test_tracks(void **state) {
    (void)state;
    struct cave_displays d, same;
    write_file("walk.txt", "# seconds x y z qx qy qz qw\n\n-1 0 1 0\n1 2 1 0 0 0.70710678 0 0.70710678  # to the left\n");
    assert_true(cave_displays_load(write_file("track.json", "{\"walls\": [" WALL "}], \"head\": \"walk.txt\", \"ipd\": 0}"), &d));
    assert_true(cave_displays_load(write_file("array.json", "{\"walls\": [" WALL "}], \"ipd\": 0, \"head\": [{\"time\": -1, \"position\": [0, 1, 0]}, "
                                                            "{\"time\": 1, \"position\": [2, 1, 0], \"rotation\": [0, 0.70710678, 0, 0.70710678]}]}"),
                                   &same));
    for (int i = 0; i < 9; i++) {
        const double time = -2 + 0.5 * i, part = fmax(0, fmin(1, (time + 1) / 2));
        const struct cave_pose p = cave_displays_head(&d, time), q = cave_displays_head(&same, time);
        assert_memory_equal(&p, &q, sizeof p);
        assert_float_equal(p.position.x, 2 * part, 1e-9);
        const struct cave_vector right = cave_rotate(p.rotation, (struct cave_vector){1, 0, 0}); /* turns evenly by 90 degrees to the left */
        assert_float_equal(right.x, cos(part * 1.5707963267949), 1e-7);
        assert_float_equal(right.z, -sin(part * 1.5707963267949), 1e-7);
    }
    cave_displays_free(&d);
    cave_displays_free(&same);
}

/* ---- pictures ---- */

struct show {
    struct cave_options o;
    struct cave_displays d;
    struct cave_view views[CAVE_VIEWS];
    uint32_t count;
    struct cave_place place;
    struct cave_moment moment;
    fnl_scene *scene;
    struct cave_stage *stage;
};

static void show(struct show *s, const char *displays, const char *scene, uint32_t side, struct cave_vector head) {
    const fnl_host host = fnl_host_default();
    fnl_camera camera;
    s->o = options_for(scene);
    s->o.width = side;
    s->o.height = side;
    s->o.render.aovs = 1u << RENDER_AOV_POSITION;
    assert_true(cave_displays_load(displays, &s->d));
    s->count = cave_list_views(&s->o, &s->d, 0, s->views);
    assert_true(world_load(&s->o.render.world, &host, side, side, true, &s->scene, &camera));
    s->moment = cave_predict(&s->o, &s->d, 0, 10);
    s->place = cave_find_place(&s->d, &s->moment, &camera, false);
    s->moment.head.position = cave_add_scaled(s->moment.head.position, head, 1);
    assert_true(cave_stage_create(&s->o, &s->d, &host, s->scene, s->views, s->count, 0, &s->stage));
    assert_true(cave_stage_render(s->stage, &s->place, &s->moment));
    assert_int_equal(cave_stage_messages(s->stage), 0);
}

static void end_show(struct show *s) {
    cave_stage_destroy(&s->stage);
    fnl_scene_destroy(&s->scene);
    cave_displays_free(&s->d);
}

enum side { SIDE_LEFT, SIDE_RIGHT, SIDE_TOP, SIDE_BOTTOM };

/* Pixel `i` along a side of a picture. */
static size_t along(enum side side, uint32_t size, uint32_t i, uint32_t inwards) {
    const uint32_t x = side == SIDE_LEFT ? inwards : side == SIDE_RIGHT ? size - 1 - inwards : i, y = side == SIDE_TOP ? inwards : side == SIDE_BOTTOM ? size - 1 - inwards : i;
    return (size_t)y * size + x;
}

static double color_step(const uint8_t *a, const uint8_t *b) {
    return (abs(a[0] - b[0]) + abs(a[1] - b[1]) + abs(a[2] - b[2])) / 3.0;
}

/*
 * What is seen beside the common edge of two walls, from a head that is off the centre: the surface point of each pixel along it falls, in the picture of
 * the neighbour, behind its edge by less than a pixel, and as far along it; and colours go on.
 */
static void test_edges_of_walls_match_VR_15(void **state) {
    (void)state;
    enum { SIZE = 64, FRONT = 0, LEFT = 1, RIGHT = 2, FLOOR = 3, CEILING = 4 };
    static const struct {
        uint32_t first, second;
        enum side first_side, second_side;
    } seams[] = {{FRONT, LEFT, SIDE_LEFT, SIDE_RIGHT}, {FRONT, RIGHT, SIDE_RIGHT, SIDE_LEFT}, {FRONT, FLOOR, SIDE_BOTTOM, SIDE_TOP}, {FRONT, CEILING, SIDE_TOP, SIDE_BOTTOM}};
    struct show s = {0};
    show(&s, "builtin:cave", "builtin:room", SIZE, (struct cave_vector){0.3, -0.1, 0.2});
    assert_int_equal(s.count, 10);
    double worst = 0, across = 0, inside = 0;
    for (size_t k = 0; k < sizeof seams / sizeof *seams; k++) {
        for (uint32_t eye = 0; eye < 2; eye++) {
            for (int way = 0; way < 2; way++) {
                const uint32_t a = 2 * (way ? seams[k].second : seams[k].first) + eye, b = 2 * (way ? seams[k].first : seams[k].second) + eye;
                const enum side at = way ? seams[k].second_side : seams[k].first_side, there = way ? seams[k].first_side : seams[k].second_side;
                fnl_image position, colors, neighbour;
                fnl_camera camera;
                assert_true(cave_stage_picture(s.stage, a, 4, &position) && cave_stage_picture(s.stage, a, 0, &colors) && cave_stage_picture(s.stage, b, 0, &neighbour));
                assert_true(cave_view_camera(&s.d, &s.place, &s.moment, &s.views[b], &camera));
                for (uint32_t i = 0; i < SIZE; i++) {
                    const size_t pixel = along(at, SIZE, i, 0);
                    const float *p = (const float *)position.pixels + pixel * 4;
                    if (p[3] == 0) continue; /* sky in a window */
                    const fnl_vec2 seen = pixel_of(&camera, SIZE, SIZE, (struct cave_vector){(double)p[0], (double)p[1], (double)p[2]});
                    const bool sideways = there == SIDE_LEFT || there == SIDE_RIGHT;
                    const double beyond = there == SIDE_LEFT ? (double)-seen.x : there == SIDE_RIGHT ? (double)seen.x - SIZE : there == SIDE_TOP ? (double)-seen.y : (double)seen.y - SIZE;
                    const double slip = fabs((double)(sideways ? seen.y : seen.x) - (i + 0.5));
                    if (!(beyond > 0 && beyond <= 1 && slip <= 1)) fail_msg("wall %u of %u, pixel %u: %g beyond the edge, %g along it", a / 2, b / 2, i, beyond, slip);
                    worst = fmax(worst, fmax(beyond, slip));
                    const uint8_t *own = (const uint8_t *)colors.pixels + pixel * 4;
                    across += color_step(own, (const uint8_t *)neighbour.pixels + along(there, SIZE, i, 0) * 4);
                    inside += color_step(own, (const uint8_t *)colors.pixels + along(at, SIZE, i, 1) * 4);
                }
            }
        }
    }
    printf("at most %.2f pixels off; colours change by %.0f across edges and by %.0f to the next pixel inside\n", worst, across, inside);
    assert_true(inside > 0 && across < 1.5 * inside);
    end_show(&s);
}

static json_t *find_sum(const json_t *report, const char *key, double *out) {
    size_t i;
    json_t *one;
    *out = 0;
    json_array_foreach((json_t *)report, i, one) *out += json_number_value(json_object_get(one, key));
    return json_array_get(report, 0);
}

static void compare_devices(const char *const files[3], const int renderers[3], const char *scene) {
    enum { SIZE = 32 };
    uint8_t *first = NULL;
    for (size_t k = 0; k < 3; k++) {
        struct show s = {0};
        show(&s, write_file("devices.json", files[k]), scene, SIZE, (struct cave_vector){0});
        assert_int_equal(s.count, 3);
        const size_t bytes = (size_t)SIZE * SIZE * 4;
        uint8_t *all = calloc(3, bytes);
        for (uint32_t v = 0; v < 3; v++) {
            fnl_image image;
            assert_true(cave_stage_picture(s.stage, v, 0, &image));
            memcpy(all + v * bytes, image.pixels, bytes);
        }
        if (first)
            assert_memory_equal(all, first, 3 * bytes);
        else
            assert_memory_not_equal(all, all + bytes, bytes); /* eyes differ */
        if (!first)
            first = all;
        else
            free(all);
        json_t *report = cave_stage_report(s.stage);
        double copied, milliseconds;
        assert_int_equal(json_array_size(report), renderers[k]);
        for (int i = 0; i < renderers[k]; i++) assert_int_equal(json_integer_value(json_object_get(json_array_get(report, (size_t)i), "device")), (k == 2) ^ (i == 1)); /* in the order of the walls */
        assert_non_null(find_sum(report, "copy_bytes", &copied));
        assert_non_null(find_sum(report, "copy_ms", &milliseconds));
        assert_float_equal(copied, 3 * (bytes + 4 * bytes), 0); /* colours, positions */
        assert_true(milliseconds > 0);
        json_decref(report);
        end_show(&s);
    }
    free(first);
}

/* Both eyes on one device, an eye on each of two, and a wall on each of two: the same bytes. */
static void test_devices_show_the_same_VR_16(void **state) {
    (void)state;
    /* A thing on the right, near a limit of its levels: low as it is, the picture of the side wall alone would show a finer one. */
    static const char lod[] =
        "{\"asset\": {\"version\": \"2.0\"}, \"extensionsUsed\": [\"MSFT_lod\"], \"scene\": 0, \"scenes\": [{\"nodes\": [0, 2]}], \"nodes\": [{\"mesh\": 0, \"translation\": [4, 0, 0], "
        "\"extensions\": {\"MSFT_lod\": {\"ids\": [1]}}, \"extras\": {\"MSFT_screencoverage\": [0.265, 0.01]}}, {\"mesh\": 1, \"translation\": [4, 0, 0]}, "
        "{\"mesh\": 1, \"translation\": [-1, 0, -4]}], "
        "\"materials\": [{\"doubleSided\": true, \"emissiveFactor\": [1, 1, 1]}, {\"doubleSided\": true, \"emissiveFactor\": [1, 0, 0]}], \"meshes\": "
        "[{\"primitives\": [{\"attributes\": {\"POSITION\": 0}, \"material\": 0}]}, {\"primitives\": [{\"attributes\": {\"POSITION\": 0}, \"material\": 1}]}], "
        "\"accessors\": [{\"bufferView\": 0, \"componentType\": 5126, \"count\": 3, \"type\": \"VEC3\", \"min\": [0, 0, 0], \"max\": [0, 1, 1]}], "
        "\"bufferViews\": [{\"buffer\": 0, \"byteLength\": 36}], "
        "\"buffers\": [{\"byteLength\": 36, \"uri\": \"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAIA/\"}]}";
#define TWO_WALLS(devices, front, side)                                                                                                                    \
    "{\"origin\": {\"position\": [0, 0, 0]}, " devices " " HEAD ", \"walls\": [{\"name\": \"front\", \"lower_left\": [-1, 0, -1], \"lower_right\": [1, 0, -1], \"upper_left\": [-1, 2, -1], "      \
    "\"resolution\": [8, 4], \"stereo\": true" front "}, {\"name\": \"side\", \"lower_left\": [1, 0, -1], \"lower_right\": [1, 0, 1], \"upper_left\": [1, 1, -1], " \
    "\"resolution\": [8, 4]" side "}]}"
    static const char *const files[] = {TWO_WALLS("", "", ""), TWO_WALLS("\"devices\": [0, 0],", ", \"device\": [0, 1]", ", \"device\": 1"),
                                        TWO_WALLS("\"devices\": [0, 0],", ", \"device\": 1", ", \"device\": 0")};
    static const int renderers[] = {1, 2, 2};
    char levels[128];
    snprintf(levels, sizeof levels, "%s", write_file("levels.gltf", lod));
    const char *const scenes[] = {"builtin:spheres?lights=8", levels};
    for (int scene = 0; scene < 2; scene++) compare_devices(files, renderers, scenes[scene]);
}

static int make_folder(void **state) {
    (void)state;
    return mkdtemp(folder) ? 0 : 1;
}

static int remove_folder(void **state) {
    (void)state;
    static const char *const names[] = {"example.json", "bad.json", "bad.txt", "walk.txt", "track.json", "array.json", "devices.json", "levels.gltf", "messages"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) unlink(path_of(names[i]));
    return rmdir(folder);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_corners_of_walls_are_corners_of_pictures), cmocka_unit_test(test_eyes_behind_walls),  cmocka_unit_test(test_examples_are_of_one_kind_VR_15),
        cmocka_unit_test(test_broken_files),                             cmocka_unit_test(test_tracks),             cmocka_unit_test(test_edges_of_walls_match_VR_15),
        cmocka_unit_test(test_devices_show_the_same_VR_16),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
