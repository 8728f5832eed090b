/* SPDX-License-Identifier: MIT */
/*
 * Compares shadow edges of maps and rays under suns at grazing angles: how many pixels from the true edge maps are
 * wrong.
 * FANAL_GRAZING=WIDTHxHEIGHT runs all scenes and suns at that size. FANAL_GRAZING_WORLD=NAME runs one scene.
 * FANAL_GRAZING_MEMORY=MIB sets shadow.memory.
 */
#include "tests/render_harness.h"
#include "tests/shadow_leak.h"
#include "tests/trace_world.h"

/* ---- scenes ---- */

enum { MOST_CORNERS = 1 << 16 };
static float corners[MOST_CORNERS * 3];
static uint32_t corner_count;

static void put_quad(vec3 a, vec3 b, vec3 c, vec3 d) {
    const vec3 six[6] = {a, b, c, a, c, d};
    for (int i = 0; i < 6; i++) {
        assert_true(corner_count < MOST_CORNERS);
        memcpy(&corners[3 * corner_count++], &six[i], sizeof(float) * 3);
    }
}

/* A box turned about the vertical, without a bottom. */
static void put_box(vec3 at, vec3 half, float turn) {
    const float c = cosf(turn), s = sinf(turn);
    vec3 p[8];
    for (int i = 0; i < 8; i++) {
        const float x = i & 1 ? half.x : -half.x, y = i & 2 ? half.y : -half.y, z = i & 4 ? half.z : -half.z;
        p[i] = vec3_add(at, vec3_make(c * x + s * z, y, c * z - s * x));
    }
    put_quad(p[4], p[5], p[7], p[6]);
    put_quad(p[1], p[0], p[2], p[3]);
    put_quad(p[5], p[1], p[3], p[7]);
    put_quad(p[0], p[4], p[6], p[2]);
    put_quad(p[6], p[7], p[3], p[2]);
}

static void put_ground(float size) { put_quad(vec3_make(-size, 0, size), vec3_make(size, 0, size), vec3_make(size, 0, -size), vec3_make(-size, 0, -size)); }

/* Walls and a gable roof with its ridge along z; `wide`, `high` and `deep` are the size of the walls. */
static void put_house(vec3 at, float wide, float high, float deep, float roof) {
    put_box(vec3_make(at.x, at.y + 0.5f * high, at.z), vec3_make(0.5f * wide, 0.5f * high, 0.5f * deep), 0);
    const float x = 0.55f * wide, z = 0.55f * deep, low = at.y + high - 0.1f * roof, top = at.y + high + roof;
    for (int i = 0; i < 2; i++) { /* both sides of each plane */
        const float e = 0.05f * (float)i;
        put_quad(vec3_make(at.x - x, low - e, at.z + z), vec3_make(at.x, top - e, at.z + z), vec3_make(at.x, top - e, at.z - z), vec3_make(at.x - x, low - e, at.z - z));
        put_quad(vec3_make(at.x + x, low - e, at.z + z), vec3_make(at.x + x, low - e, at.z - z), vec3_make(at.x, top - e, at.z - z), vec3_make(at.x, top - e, at.z + z));
    }
    for (int i = -1; i <= 1; i += 2) {
        const float w = 0.5f * wide, end = at.z + 0.5f * deep * (float)i;
        const vec3 a = vec3_make(at.x - w, at.y + high, end), b = vec3_make(at.x + w, at.y + high, end), c = vec3_make(at.x, at.y + high + roof * 0.95f, end);
        put_quad(a, b, c, c);
    }
}

static void put_round(vec3 at, float radius, float high, uint32_t sides, float taper) {
    for (uint32_t i = 0; i < sides; i++) {
        const float a = 2 * PI * (float)i / (float)sides, b = 2 * PI * (float)(i + 1) / (float)sides;
        const vec3 p = vec3_make(at.x + radius * cosf(a), at.y, at.z - radius * sinf(a)), q = vec3_make(at.x + radius * cosf(b), at.y, at.z - radius * sinf(b)),
                   r = vec3_make(at.x + taper * radius * cosf(b), at.y + high, at.z - taper * radius * sinf(b)),
                   t = vec3_make(at.x + taper * radius * cosf(a), at.y + high, at.z - taper * radius * sinf(a));
        put_quad(p, q, r, t);
        put_quad(t, r, vec3_make(at.x, at.y + high, at.z), vec3_make(at.x, at.y + high, at.z));
    }
}

static float hill(float x, float z) { return 1.5f * sinf(0.21f * x) * cosf(0.17f * z) + 0.5f * sinf(0.5f * x + 0.4f * z); }

static void put_hills(void) {
    enum { CELLS = 60 };
    const float step = 1.5f;
    for (int j = 0; j < CELLS; j++)
        for (int i = 0; i < CELLS; i++) {
            const float x = step * (float)(i - CELLS / 2), z = step * (float)(j - CELLS / 2), u = x + step, v = z + step;
            put_quad(vec3_make(x, hill(x, z), z), vec3_make(x, hill(x, v), v), vec3_make(u, hill(u, v), v), vec3_make(u, hill(u, z), z));
        }
}

static void gable(void) { put_ground(500), put_house(vec3_make(0, 0, 0), 8, 4, 10, 4); }
static void columns(void) {
    put_ground(500);
    for (int i = 0; i < 8; i++) put_round(vec3_make(2.5f * (float)i - 9, 0, i % 2 ? 1.5f : -1.5f), 0.3f, 4, 12, 0.8f);
}
static void fence(void) {
    put_ground(500);
    for (int i = 0; i < 24; i++) put_box(vec3_make(0.5f * (float)i - 6, 0.6f, 0), vec3_make(0.12f, 0.6f, 0.05f), 0);
    put_box(vec3_make(0, 0.9f, -0.08f), vec3_make(6, 0.08f, 0.03f), 0);
}
static void street(void) {
    put_ground(500);
    for (int i = 0; i < 5; i++) {
        put_box(vec3_make(-7 - 0.7f * (float)(i % 3), 5, 9 * (float)i - 18), vec3_make(3, 5 + (float)(i % 2), 4), 0);
        put_box(vec3_make(7 + 0.5f * (float)(i % 2), 4, 9 * (float)i - 18), vec3_make(3, 4 + (float)(i % 3), 4), 0);
        for (int k = 0; k < 3; k++) put_box(vec3_make(3.6f + 0.5f * (float)(i % 2), 2 + 2 * (float)k, 9 * (float)i - 18), vec3_make(0.5f, 0.1f, 1.5f), 0); /* balconies */
    }
}
static void facade(void) { /* with sills; the sun grazes the facade */
    put_ground(500);
    put_box(vec3_make(0, 6, -8), vec3_make(14, 6, 1), 0);
    for (int j = 0; j < 3; j++)
        for (int i = 0; i < 7; i++) put_box(vec3_make(4 * (float)i - 12, 2 + 3.5f * (float)j, -6.9f), vec3_make(0.9f, 0.12f, 0.25f), 0);
}
static void turned(void) { /* blocks at all angles */
    put_ground(500);
    for (int i = 0; i < 9; i++) put_box(vec3_make(5 * (float)(i % 3) - 5, 1 + 0.3f * (float)(i % 4), 5 * (float)(i / 3) - 5), vec3_make(1, 1 + 0.3f * (float)(i % 4), 1.3f), 0.35f * (float)i);
}
static void stairs(void) {
    put_ground(500);
    for (int i = 0; i < 12; i++) put_box(vec3_make(0, 0.15f * (float)(i + 1) * 0.5f, -0.35f * (float)i), vec3_make(3, 0.15f * (float)(i + 1) * 0.5f, 0.175f), 0);
    for (int i = 0; i < 2; i++) put_box(vec3_make(i ? 3.2f : -3.2f, 1.4f, -2), vec3_make(0.2f, 1.4f, 2.2f), 0);
}
static void hills(void) { put_hills(); }
static void hill_houses(void) {
    put_hills();
    for (int i = 0; i < 5; i++) {
        const float x = 7 * (float)i - 14, z = i % 2 ? 4.0f : -6.0f;
        put_house(vec3_make(x, hill(x, z) - 0.5f, z), 3, 2.5f, 4, 1.5f);
    }
}
static void bridge(void) {
    put_ground(500);
    put_box(vec3_make(0, 3, 0), vec3_make(12, 0.3f, 1.5f), 0.3f);
    for (int i = 0; i < 4; i++) put_box(vec3_make(-7.5f + 5 * (float)i, 1.5f, -0.31f * (-7.5f + 5 * (float)i)), vec3_make(0.4f, 1.5f, 0.8f), 0.3f);
}
static void cones(void) {
    put_ground(500);
    for (int i = 0; i < 7; i++) put_round(vec3_make(3 * (float)i - 9, 0, (float)(i * 5 % 7) - 3), 1, 2.5f, 24, 0.05f);
}
static void tables(void) {
    put_ground(500);
    for (int i = 0; i < 4; i++) {
        const vec3 at = vec3_make(3 * (float)i - 4.5f, 0, (float)(i % 2));
        put_box(vec3_make(at.x, 0.75f, at.z), vec3_make(0.9f, 0.03f, 0.6f), 0.2f * (float)i);
        for (int k = 0; k < 4; k++) put_box(vec3_make(at.x + (k & 1 ? 0.6f : -0.6f), 0.36f, at.z + (k & 2 ? 0.3f : -0.3f)), vec3_make(0.05f, 0.36f, 0.05f), 0);
    }
}

static const struct world {
    const char *name;
    void (*put)(void);
    vec3 from, at;
    float azimuth; /* of the sun, degrees */
    float high;    /* meters: the view shows the end of the shadow of an object this high; 0: its foot */
    uint32_t far_off; /* most pixels far off at 480x270; they lie in creases between surfaces that the sun grazes */
    bool always;   /* also without FANAL_GRAZING */
} worlds[] = {
    {"gable", gable, {14, 9, 16}, {4, 1, 0}, 250, 6.5f, 2, true},      {"columns", columns, {0, 1.7f, 12}, {0, 1.2f, 0}, 290, 3.7f, 2, false}, {"fence", fence, {-4, 2.5f, 7}, {0, 0, 1}, 200, 1.0f, 2, false},
    {"street", street, {0, 1.7f, 24}, {0, 3, 0}, 215, 0.0f, 2, false},  {"facade", facade, {6, 3, 12}, {0, 5, -8}, 272, 0.0f, 20, true},       {"turned", turned, {10, 9, 12}, {0, 0, 0}, 245, 1.8f, 2, false},
    {"stairs", stairs, {5, 3, 7}, {0, 1, -1}, 262, 0.5f, 2, false},     {"hills", hills, {0, 9, 30}, {0, 0, 0}, 260, 0.0f, 200, false},           {"houses", hill_houses, {12, 8, 22}, {0, 1, 0}, 240, 1.5f, 80, false},
    {"bridge", bridge, {-6, 2, 14}, {0, 1.5f, 0}, 300, 3.0f, 2, false}, {"cones", cones, {2, 6, 13}, {0, 0.5f, 0}, 275, 2.2f, 2, false},        {"tables", tables, {4, 2.2f, 6}, {0, 0.4f, 0}, 235, 0.75f, 4, true},
};

static fnl_scene *world_of(const struct world *w, float elevation) {
    fnl_scene *scene = world_create(NULL);
    const fnl_material_params white = matt(0.8f);
    corner_count = 0;
    w->put();
    uint32_t *indices = malloc(corner_count * sizeof *indices);
    assert_non_null(indices);
    for (uint32_t i = 0; i < corner_count; i++) indices[i] = i;
    const fnl_mesh_params params = {.vertex_count = corner_count, .index_count = corner_count, .positions = corners, .indices = indices, .material = add_material(scene, &white)};
    fnl_mesh_id mesh;
    assert_int_equal(fnl_scene_add_mesh(scene, &params, &mesh), FNL_OK);
    free(indices);
    add_instance(scene, mesh, mat4_identity());
    fnl_light_params sun = fnl_light_params_default();
    const float e = elevation * PI / 180, a = w->azimuth * PI / 180;
    sun.kind = FNL_LIGHT_DIRECTIONAL;
    sun.direction = vec3_make(-cosf(e) * sinf(a), -sinf(e), -cosf(e) * cosf(a));
    sun.intensity = 100;
    fnl_light_id id;
    assert_int_equal(fnl_scene_add_light(scene, &sun, &id), FNL_OK);
    return scene;
}

/* ---- edges ---- */

static int fine = 3; /* reference pixels per pixel, along each axis */

/* 1: lit; 0: in shadow; -1: not lit by the sun, or lit at less than half a degree. */
static signed char *lit_of(struct stage *s, fnl_shadows shadows, uint32_t times, fnl_frame_stats *stats) {
    fnl_frame frame = s->frame;
    frame.width *= times, frame.height *= times;
    frame.shadows = FNL_SHADOWS_OFF;
    struct shot open = stage_shoot(s, &frame);
    frame.shadows = shadows;
    struct shot shot = stage_shoot(s, &frame);
    for (int i = 0; i < 4 && shadows == FNL_SHADOWS_MAPS && counter(&shot.stats, "shadows.waiting") > 0; i++) { /* the room grows */
        shot_free(&shot);
        shot = stage_shoot(s, &frame);
    }
    const size_t count = (size_t)frame.width * frame.height;
    signed char *lit = malloc(count);
    assert_non_null(lit);
    for (size_t i = 0; i < count; i++) {
        const float whole = ((const float *)open.radiance.pixels)[4 * i + 1], part = ((const float *)shot.radiance.pixels)[4 * i + 1];
        lit[i] = whole > 0.25f ? part > 0.5f * whole : -1;
    }
    if (stats) *stats = shot.stats;
    shot_free(&open);
    shot_free(&shot);
    return lit;
}

struct edges {
    uint32_t lit, dark, wrong, far_off; /* pixels; far_off: wrong and more than 1.5 pixels from the edge */
    double farthest;                    /* pixels */
    fnl_frame_stats stats;
};

static struct edges edges_of(struct stage *s) {
    const int width = (int)s->frame.width, height = (int)s->frame.height, most = 40;
    struct edges e = {0};
    signed char *maps = lit_of(s, FNL_SHADOWS_MAPS, 1, &e.stats), *truth = lit_of(s, FNL_SHADOWS_RAYS, (uint32_t)fine, NULL);
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            const int u = fine * x + fine / 2, v = fine * y + fine / 2, mine = truth[v * width * fine + u];
            if (mine < 0 || maps[y * width + x] < 0) continue;
            *(mine ? &e.lit : &e.dark) += 1;
            if (maps[y * width + x] == mine) continue;
            e.wrong++;
            int nearest = most * most;
            for (int b = MAX(v - most, 0); b <= MIN(v + most, height * fine - 1); b++)
                for (int a = MAX(u - most, 0); a <= MIN(u + most, width * fine - 1); a++)
                    if (truth[b * width * fine + a] == 1 - mine) nearest = MIN(nearest, (a - u) * (a - u) + (b - v) * (b - v));
            const double away = (sqrt(nearest) - 0.5) / fine; /* the edge lies between two reference pixels */
            e.farthest = fmax(e.farthest, away);
            e.far_off += away > 1.5;
        }
    free(maps);
    free(truth);
    return e;
}

static struct stage stage_of(const struct world *w, float elevation) {
    struct stage s = stage_open_scene(world_of(w, elevation));
    const float far = w->high / tanf(elevation * PI / 180), turn = w->azimuth * PI / 180;
    const vec3 away = vec3_make(-far * sinf(turn), 0, -far * cosf(turn));
    s.frame.width = 480, s.frame.height = 270;
    s.frame.camera.position = vec3_add(w->from, away);
    s.frame.camera.target = vec3_add(w->at, away);
    s.frame.camera.up = vec3_make(0, 1, 0);
    s.frame.outputs = FNL_OUTPUT_RADIANCE;
    s.frame.shadow.filter = FNL_SHADOW_FILTER_HARD;
    return s;
}

static void test_edges_are_where_rays_have_them(void **state) {
    UNUSED(state);
    static const float elevations[] = {2, 10, 5, 30};
    const char *size = getenv("FANAL_GRAZING"), *only = getenv("FANAL_GRAZING_WORLD"), *memory = getenv("FANAL_GRAZING_MEMORY");
    for (uint32_t i = 0; i < COUNT_OF(worlds); i++)
        for (uint32_t k = 0; k < (size ? 4 : 2); k++) {
            if (only ? strcmp(only, worlds[i].name) != 0 : !size && !worlds[i].always) continue;
            struct stage s = stage_of(&worlds[i], elevations[k]);
            if (size && sscanf(size, "%ux%u", &s.frame.width, &s.frame.height) != 2) fail_msg("FANAL_GRAZING=%s: expected WIDTHxHEIGHT", size);
            if (s.frame.width > 1000) fine = 1;
            if (memory) s.frame.shadow.memory = (uint32_t)atoi(memory);
            const struct edges e = edges_of(&s);
            print_message("%-8s %2.0f deg: %u lit, %u dark, %u wrong, %u more than 1.5 pixels off, %.1f at most; %u of %u pages, %u oblong, %u cells wanted\n",
                          worlds[i].name, (double)elevations[k], e.lit, e.dark, e.wrong, e.far_off, e.farthest, (uint32_t)counter(&e.stats, "shadows.pages"),
                          (uint32_t)counter(&e.stats, "shadows.wanted"), (uint32_t)counter(&e.stats, "shadows.oblong"), (uint32_t)counter(&e.stats, "shadows.cells-wanted"));
            assert_true(e.lit > 100 && e.dark + e.lit > 1000);
            assert_true(e.far_off <= worlds[i].far_off || s.frame.width != 480);
            assert_true(counter(&e.stats, "shadows.oblong") > 0 && counter(&e.stats, "shadows.oblong") < counter(&e.stats, "shadows.wanted"));
            stage_close(&s);
        }
}

static uint32_t differing(const fnl_image *a, const fnl_image *b) {
    uint32_t count = 0;
    for (uint32_t i = 0; i < a->width * a->height; i++) count += fabsf(pixel_at(a, i % a->width, i / a->width)[1] - pixel_at(b, i % a->width, i / a->width)[1]) > 0.02f;
    return count;
}

/* All paths sample the same pages, and a view that returns reuses them. */
static void test_paths_and_frames_agree(void **state) {
    UNUSED(state);
    static const fnl_shading paths[] = {FNL_SHADING_DEFERRED, FNL_SHADING_VISIBILITY, FNL_SHADING_FORWARD_PREPASS};
    struct stage s = stage_of(&worlds[0], 5);
    s.frame.shadows = FNL_SHADOWS_MAPS;
    s.frame.shading = FNL_SHADING_FORWARD;
    struct shot forward = stage_shoot(&s, &s.frame);
    const uint64_t oblong = counter(&forward.stats, "shadows.oblong");
    assert_true(oblong > 10);
    for (uint32_t i = 0; i < COUNT_OF(paths); i++) {
        s.frame.shading = paths[i];
        struct shot other = stage_shoot(&s, &s.frame);
        const uint32_t count = differing(&forward.radiance, &other.radiance);
        print_message("path %u: %u pixels differ\n", (uint32_t)paths[i], count);
        assert_true(count <= 12);
        assert_int_equal(counter(&other.stats, "shadows.oblong"), oblong);
        shot_free(&other);
    }
    s.frame.shading = FNL_SHADING_FORWARD;
    s.frame.camera.position.x += 0.3f;
    struct shot moved = stage_shoot(&s, &s.frame);
    assert_true(counter(&moved.stats, "shadows.drawn") < oblong / 2);
    s.frame.camera.position.x -= 0.3f;
    const fnl_vec3 target = s.frame.camera.target;
    s.frame.camera.target.y += 100; /* nothing but sky: pages stay for when the view returns */
    struct shot sky = stage_shoot(&s, &s.frame);
    assert_int_equal(counter(&sky.stats, "shadows.oblong"), 0);
    shot_free(&sky);
    s.frame.camera.target = target;
    for (int i = 0; i < 6; i++) { /* the last of these frames reuse the pages as they are */
        struct shot back = stage_shoot(&s, &s.frame);
        assert_int_equal(differing(&forward.radiance, &back.radiance), 0);
        assert_int_equal(counter(&back.stats, "shadows.drawn"), 0);
        shot_free(&back);
    }
    shot_free(&moved);
    shot_free(&forward);
    stage_close(&s);
}

/* With MSAA, only the first sample of a pixel has a plane. If there is no room, square pages replace oblong ones. */
static void test_samples_and_budgets(void **state) {
    UNUSED(state);
    struct stage s = stage_of(&worlds[0], 2);
    s.frame.msaa = 4;
    s.frame.shadows = FNL_SHADOWS_RAYS;
    struct shot rays = stage_shoot(&s, &s.frame);
    s.frame.shadows = FNL_SHADOWS_MAPS;
    static const uint32_t budgets[] = {64, 3, 1};
    for (uint32_t i = 0; i < COUNT_OF(budgets); i++) {
        s.frame.shadow.memory = budgets[i];
        struct shot maps = stage_shoot(&s, &s.frame);
        const uint32_t count = differing(&rays.radiance, &maps.radiance);
        print_message("%u MiB: %u of %u pages, %u cells wanted, %u pixels differ\n", budgets[i], (uint32_t)counter(&maps.stats, "shadows.pages"),
                      (uint32_t)counter(&maps.stats, "shadows.wanted"), (uint32_t)counter(&maps.stats, "shadows.cells-wanted"), count);
        assert_true((counter(&maps.stats, "shadows.coarsened") > 0) == (i > 0));
        assert_true(counter(&maps.stats, "shadows.cells-wanted") == counter(&maps.stats, "shadows.wanted"));
        assert_int_equal(counter(&maps.stats, "shadows.traced"), 0);
        assert_true(count < s.frame.width * s.frame.height / (i ? 50 : 200));
        shot_free(&maps);
    }
    shot_free(&rays);
    stage_close(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_edges_are_where_rays_have_them, harness_check),
        cmocka_unit_test_teardown(test_paths_and_frames_agree, harness_check),
        cmocka_unit_test_teardown(test_samples_and_budgets, harness_check),
    };
    return cmocka_run_group_tests_name("shadow_grazing", tests, harness_begin, harness_end);
}
