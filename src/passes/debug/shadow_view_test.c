/* SPDX-License-Identifier: MIT */
/** Debug views of shadow maps: each pixel against the page, the level and the texel that geometry says, and against rays. */
#include "tests/render_harness.h"
#include "tests/render_test.h"

enum { SIZE = 200, LEVELS = 8, LEGEND_HEIGHT = 14, LEGEND_WIDTH = 64 };
#define PIXEL (2.0 / SIZE) /* metres: the camera sees the floor from -1 to 1 */

static const int sides[LEVELS] = {16, 8, 4, 2, 1, 1, 1, 1}, texels[LEVELS] = {120, 120, 120, 120, 120, 56, 24, 8};
static const double base = 0.6;

/* A floor that faces the camera at z = 0, and nothing else. */
static fnl_scene *floor_scene(float half) {
    fnl_scene *scene = test_scene();
    struct scene_material m = scene_material_default();
    m.base_color = (vec4){(float)base, (float)base, (float)base, 1};
    test_place(scene, test_quad_mesh(scene, scene_add_material(scene, &m)), (vec3){0, 0, 0}, (vec3){half, half, 1});
    return scene;
}

static void add_light(fnl_scene *scene, const fnl_light_params *light) {
    fnl_light_id id;
    assert_int_equal(fnl_scene_add_light(scene, light, &id), FNL_OK);
}

static fnl_frame view_frame(fnl_debug_view view) {
    fnl_frame frame = test_frame(FNL_OUTPUT_COLOR | FNL_OUTPUT_RADIANCE);
    frame.width = frame.height = SIZE;
    frame.shading = FNL_SHADING_DEFERRED;
    frame.shadows = FNL_SHADOWS_MAPS;
    frame.debug = view;
    return frame;
}

/* ---- where a look-up goes ---- */

struct place {
    int face, level, x, y; /* level: not known next to where it changes, -1 */
    double texel;          /* over a pixel */
    double edge;           /* pixels to the nearest edge of the page */
};

static struct place place_of(vec3 light, uint32_t x, uint32_t y, int bias) {
    const double ray[3] = {(x + 0.5) * PIXEL - 1 - (double)light.x, 1 - (y + 0.5) * PIXEL - (double)light.y, -(double)light.z};
    int axis = 2, level = 0;
    for (int i = 0; i < 2; i++)
        if (fabs(ray[i]) > fabs(ray[axis])) axis = i;
    const double along = fabs(ray[axis]), across = 2 * along / PIXEL;
    struct place p = {.face = 2 * axis + (ray[axis] < 0)};
    while (level + 1 < LEVELS && sides[level + 1] * texels[level + 1] >= across) level++;
    for (int i = 0; i < LEVELS; i++)
        if (fabs(across / (sides[i] * texels[i]) - 1) < 1e-3) level = -100;
    for (int i = 0; i < 3; i++)
        if (i != axis && fabs(fabs(ray[i]) / along - 1) < 1e-3) level = -100;
    p.level = level < 0 ? -1 : MIN(level + bias, LEVELS - 1);
    if (p.level < 0) return p;
    const double width = sides[p.level] * texels[p.level], u = (ray[(axis + 1) % 3] / along * 0.5 + 0.5) * width,
                 v = (ray[(axis + 2) % 3] / along * 0.5 + 0.5) * width, page = texels[p.level];
    p.x = (int)(u / page);
    p.y = (int)(v / page);
    p.texel = across / width;
    p.edge = fmin(fmin(u - p.x * page, (p.x + 1) * page - u), fmin(v - p.y * page, (p.y + 1) * page - v)) * p.texel;
    return p;
}

/* ---- colours ---- */

static vec3 heat(double t) {
    static const vec3 stops[9] = {{68, 1, 84}, {71, 45, 123}, {59, 82, 139}, {44, 114, 142}, {33, 144, 140},
                                  {39, 173, 129}, {93, 200, 99}, {170, 220, 50}, {253, 231, 37}};
    const int i = MIN((int)(t * 8), 7);
    return vec3_scale(vec3_lerp(stops[i], stops[i + 1], (float)(t * 8 - i)), 1 / 255.0f);
}

/* That of the floor, whose normal is level. */
static vec3 plain(void) {
    const float grey = (float)(0.12 + 0.88 * base * 0.6);
    return (vec3){grey, grey, grey};
}

static bool is_color(const fnl_image *image, uint32_t x, uint32_t y, vec3 wanted) {
    const uint8_t *p = test_pixel8(image, x, y);
    const float want[3] = {wanted.x, wanted.y, wanted.z};
    for (int c = 0; c < 3; c++)
        if (fabsf(p[c] - want[c] * 255) > 1.6f) return false;
    return true;
}

static void expect_color(const fnl_image *image, uint32_t x, uint32_t y, vec3 wanted, const char *what) {
    const uint8_t *p = test_pixel8(image, x, y);
    if (!is_color(image, x, y, wanted))
        fail_msg("%s: pixel %u, %u is %d %d %d, expected %.1f %.1f %.1f", what, x, y, p[0], p[1], p[2], (double)wanted.x * 255,
                 (double)wanted.y * 255, (double)wanted.z * 255);
}

static bool in_legend(uint32_t x, uint32_t y) { return x < LEGEND_WIDTH && y >= SIZE - LEGEND_HEIGHT; }

/* ---- levels and texels ---- */

static vec3 texel_color(double texel) {
    const double steps = log2(texel);
    const vec3 same = {0.1f, 0.75f, 0.2f}, fine = {0.1f, 0.3f, 0.9f}, coarse = {0.95f, 0.85f, 0.1f}, worst = {0.95f, 0.1f, 0.05f};
    return steps <= 0 ? vec3_lerp(same, fine, (float)fmin(-0.5 * steps, 1)) : vec3_lerp(coarse, worst, (float)fmin(steps / 3, 1));
}

static void check_levels(fnl_renderer *renderer, vec3 light, int bias, uint32_t memory, bool *met) {
    for (int view = 0; view < 2; view++) {
        fnl_frame frame = view_frame(view ? FNL_DEBUG_SHADOW_TEXELS : FNL_DEBUG_SHADOW_LEVELS);
        frame.shadow.memory = memory;
        test_render_frame(renderer, &frame);
        fnl_image image = test_read(renderer, FNL_OUTPUT_COLOR);
        uint32_t known = 0;
        for (uint32_t y = 0; y < SIZE; y++)
            for (uint32_t x = 0; x < SIZE; x++) {
                const struct place p = place_of(light, x, y, bias);
                if (p.level < 0 || (!view && in_legend(x, y))) continue;
                const vec3 color = view ? texel_color(p.texel) : heat(1 - p.level / 8.0);
                expect_color(&image, x, y, vec3_lerp(plain(), color, 0.8f), view ? "texels" : "levels");
                if (bias == 0 && p.level > 0) assert_true(p.texel <= 1 && p.texel > 0.25);
                met[p.level] = true;
                known++;
            }
        assert_true(known > SIZE * SIZE * 8 / 10);
        free_picture(&image);
    }
}

static void test_levels_and_texels(void **state) {
    UNUSED(state);
    bool met[LEVELS] = {false};
    static const vec3 lights[] = {{0.1f, 0.2f, 0.5f}, {-0.3f, 0, 7}, {0.1f, 0.1f, 3}, {0, 0.3f, 0.02f}, {0.2f, 0, 14}};
    for (uint32_t i = 0; i < COUNT_OF(lights); i++) {
        fnl_scene *scene = floor_scene(1.5f);
        const fnl_light_params light = test_point(lights[i], 1, 40);
        add_light(scene, &light);
        fnl_renderer *renderer = test_renderer(scene);
        check_levels(renderer, lights[i], 0, 64, met);
        fnl_renderer_destroy(&renderer);
        fnl_scene_destroy(&scene);
    }
    for (int level = 0; level < LEVELS; level++)
        if (!met[level]) fail_msg("no pixel has level %d", level);
}

/* Little memory: the texels of a light whose pages are coarser are wider than pixels. */
static void test_coarser_texels(void **state) {
    UNUSED(state);
    bool met[LEVELS] = {false};
    const vec3 at = {0, 0, 4.7f};
    fnl_scene *scene = floor_scene(1.5f);
    const fnl_light_params light = test_point(at, 1, 40);
    for (int i = 0; i < 20; i++) add_light(scene, &light); /* all alike: of them the first is shown */
    fnl_renderer *renderer = test_renderer(scene);
    fnl_frame frame = view_frame(FNL_DEBUG_SHADOW_LEVELS);
    frame.shadow.memory = 1;
    test_render_frame(renderer, &frame);
    fnl_frame_stats stats;
    assert_int_equal(fnl_renderer_query_stats(renderer, &stats), FNL_OK);
    assert_true(counter(&stats, "shadows.coarsened") > 0 && counter(&stats, "shadows.traced") == 0);
    fnl_image image = test_read(renderer, FNL_OUTPUT_COLOR);
    int bias = 0;
    for (; bias < LEVELS; bias++) {
        const vec3 color = heat(1 - place_of(at, SIZE / 2, SIZE / 2, bias).level / 8.0);
        if (is_color(&image, SIZE / 2, SIZE / 2, vec3_lerp(plain(), color, 0.8f))) break;
    }
    assert_true(bias > 0 && bias < LEVELS);
    check_levels(renderer, at, bias, 1, met);
    free_picture(&image);
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

static void test_legend(void **state) {
    UNUSED(state);
    fnl_scene *scene = floor_scene(0.2f);
    fnl_frame frame = view_frame(FNL_DEBUG_SHADOW_LEVELS);
    fnl_image image = test_render(scene, &frame, FNL_OUTPUT_COLOR);
    for (uint32_t level = 0; level < LEVELS; level++) expect_color(&image, level * 8 + 1, SIZE - 2, heat(1 - level / 8.0), "legend");
    expect_color(&image, LEGEND_WIDTH, SIZE - 2, (vec3){0, 0, 0}, "beside the legend"); /* the sky */
    free_picture(&image);
    fnl_scene_destroy(&scene);
}

/* ---- pages ---- */

struct page {
    uint32_t light;
    struct place place;
    uint8_t color[3];
};

static bool same_page(const struct page *page, uint32_t light, const struct place *p) {
    return page->light == light && page->place.face == p->face && page->place.level == p->level && page->place.x == p->x && page->place.y == p->y;
}

/* Three lights: each pixel has one colour for each page of the light that is brightest there, and pages have an edge. */
static void test_pages(void **state) {
    UNUSED(state);
    static const vec3 at[] = {{-0.6f, 0.1f, 2.9f}, {0.7f, 0.5f, 3.3f}, {0.2f, -0.9f, 0.8f}};
    static const float power[] = {2, 3, 0.3f};
    fnl_scene *scene = floor_scene(1.5f);
    for (int i = 0; i < 3; i++) {
        const fnl_light_params light = test_point(at[i], power[i], 1e4f);
        add_light(scene, &light);
    }
    fnl_frame frame = view_frame(FNL_DEBUG_SHADOW_PAGES);
    fnl_renderer *renderer = test_renderer(scene);
    test_render_frame(renderer, &frame);
    fnl_image image = test_read(renderer, FNL_OUTPUT_COLOR);
    struct page pages[512];
    uint32_t count = 0, edges = 0, of_light[3] = {0};
    for (uint32_t y = 0; y < SIZE; y++)
        for (uint32_t x = 0; x < SIZE; x++) {
            double lux[3];
            uint32_t best = 0;
            for (uint32_t i = 0; i < 3; i++) {
                const double dx = (x + 0.5) * PIXEL - 1 - (double)at[i].x, dy = 1 - (y + 0.5) * PIXEL - (double)at[i].y, z = (double)at[i].z;
                lux[i] = (double)power[i] * z / pow(dx * dx + dy * dy + z * z, 1.5);
                if (lux[i] > lux[best]) best = i;
            }
            bool close = false;
            for (uint32_t i = 0; i < 3; i++) close = close || (i != best && lux[i] > 0.999 * lux[best]);
            const struct place p = place_of(at[best], x, y, 0);
            if (close || p.level < 0 || fabs(p.edge - 0.75) < 0.01) continue;
            const uint8_t *got = test_pixel8(&image, x, y);
            uint32_t i = 0;
            while (i < count && !same_page(&pages[i], best, &p)) i++;
            if (p.edge < 0.75) { /* lighter than the page inside */
                if (i == count) continue;
                for (int c = 0; c < 3; c++) assert_true(got[c] >= pages[i].color[c]);
                assert_true(got[0] + got[1] + got[2] > pages[i].color[0] + pages[i].color[1] + pages[i].color[2] + 20);
                edges++;
                continue;
            }
            assert_true(i < COUNT_OF(pages));
            if (i == count) {
                pages[count++] = (struct page){best, p, {got[0], got[1], got[2]}};
                of_light[best]++;
            } else if (memcmp(pages[i].color, got, 3) != 0) {
                fail_msg("pixel %u, %u: a page has two colours", x, y);
            }
        }
    for (uint32_t i = 0; i < count; i++)
        for (uint32_t k = 0; k < i; k++)
            if (memcmp(pages[i].color, pages[k].color, 3) == 0) fail_msg("pages %u and %u of %u have one colour", k, i, count);
    fnl_frame_stats stats;
    assert_int_equal(fnl_renderer_query_stats(renderer, &stats), FNL_OK);
    assert_true(count <= counter(&stats, "shadows.wanted"));
    assert_true(of_light[0] > 4 && of_light[1] > 4 && of_light[2] > 2 && edges > 200);
    free_picture(&image);
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* Capsules have no maps; a light that does not reach, or shines from behind, gives nothing; so does a sky. */
static void test_pixels_without_pages(void **state) {
    UNUSED(state);
    static const fnl_debug_view views[] = {FNL_DEBUG_SHADOW_PAGES, FNL_DEBUG_SHADOW_LEVELS, FNL_DEBUG_SHADOW_TEXELS};
    for (uint32_t i = 0; i < COUNT_OF(views); i++) {
        fnl_scene *scene = floor_scene(0.8f);
        fnl_light_params capsule = test_point((vec3){-0.4f, 0.4f, 0.2f}, 1, 0.4f);
        capsule.kind = FNL_LIGHT_CAPSULE;
        capsule.length = 0.1f;
        add_light(scene, &capsule);
        const fnl_light_params behind = test_point((vec3){0.4f, 0.4f, -0.2f}, 1, 0.4f);
        add_light(scene, &behind);
        fnl_frame frame = view_frame(views[i]);
        fnl_image image = test_render(scene, &frame, FNL_OUTPUT_COLOR);
        expect_color(&image, 60, 60, (vec3){0.9f, 0.1f, 0.8f}, "capsule");
        expect_color(&image, 140, 60, vec3_scale(plain(), 0.5f), "behind");
        expect_color(&image, 140, 140, vec3_scale(plain(), 0.5f), "unlit");
        expect_color(&image, 195, 100, (vec3){0, 0, 0}, "sky");
        free_picture(&image);
        fnl_scene_destroy(&scene);
    }
}

/* ---- errors ---- */

/* Marked are those pixels whose light differs when rays find it, red where there is too much and blue where there is too little. */
static void check_errors(fnl_scene *scene, uint32_t memory, uint32_t *red, uint32_t *blue) {
    fnl_renderer *renderer = test_renderer(scene);
    fnl_frame frame = view_frame(FNL_DEBUG_SHADOW_ERRORS);
    frame.shading = FNL_SHADING_FORWARD; /* its positions are those of the view */
    frame.shadow.memory = memory;
    test_render_frame(renderer, &frame);
    fnl_image image = test_read(renderer, FNL_OUTPUT_COLOR), maps = test_read(renderer, FNL_OUTPUT_RADIANCE);
    frame.debug = FNL_DEBUG_NONE;
    frame.shadows = FNL_SHADOWS_RAYS;
    test_render_frame(renderer, &frame);
    fnl_image rays = test_read(renderer, FNL_OUTPUT_RADIANCE);
    *red = *blue = 0;
    for (uint32_t y = 0; y < SIZE; y++)
        for (uint32_t x = 0; x < SIZE; x++) {
            const float map = test_pixel(&maps, x, y)[1], ray = test_pixel(&rays, x, y)[1];
            const uint8_t *got = test_pixel8(&image, x, y);
            const bool more = got[0] > got[2], less = got[2] > got[0];
            if (more != (map > 1.001f * ray) || less != (ray > 1.001f * map))
                fail_msg("pixel %u, %u: maps give %g, rays %g, and the colour is %d %d %d", x, y, (double)map, (double)ray, got[0], got[1], got[2]);
            *red += more;
            *blue += less;
        }
    free_picture(&image);
    free_picture(&maps);
    free_picture(&rays);
    fnl_renderer_destroy(&renderer);
}

static void test_errors_are_where_rays_differ(void **state) {
    UNUSED(state);
    uint32_t red, blue, fine;
    fnl_scene *scene = floor_scene(1.5f);
    struct scene_material m = scene_material_default();
    const uint32_t mesh = test_quad_mesh(scene, scene_add_material(scene, &m));
    const quat turned = quat_axis_angle((vec3){0.3f, 0.2f, 1}, 0.4f);
    mat4 matrix = mat4_from_trs((vec3){0.1f, 0, 0.5f}, turned, (vec3){0.25f, 0.2f, 1});
    scene_add_node(scene, "", SCENE_NONE, &matrix, mesh);
    const fnl_light_params light = test_point((vec3){0.3f, 0.6f, 2.1f}, 1, 40);
    add_light(scene, &light);
    check_errors(scene, 64, &red, &blue);
    fine = red + blue;
    assert_true(red > 3 && blue > 3 && fine < SIZE * SIZE / 50);
    /* The same light a hundred times, and room for a few pages. */
    for (int i = 0; i < 99; i++) add_light(scene, &light);
    check_errors(scene, 1, &red, &blue);
    assert_true(red + blue > 2 * fine);
    fnl_scene_destroy(&scene);
}

/* ---- rays ---- */

/* Each light over the floor sends a ray to those pixels that its range holds, and a soft one SAMPLES. */
enum { SAMPLES = 4 };
struct ray_light {
    vec3 at;
    float range, radius;
};

static void check_rays(const struct ray_light *lights, uint32_t count, fnl_shadows shadows, fnl_light_kind kind) {
    fnl_scene *scene = floor_scene(1.5f);
    for (uint32_t i = 0; i < count; i++) {
        fnl_light_params light = test_point(lights[i].at, 1, lights[i].range);
        light.source_radius = lights[i].radius;
        light.kind = kind;
        light.length = 0;
        add_light(scene, &light);
    }
    fnl_renderer *renderer = test_renderer(scene);
    fnl_frame frame = view_frame(FNL_DEBUG_SHADOW_RAYS);
    frame.shadows = shadows;
    frame.shadow.samples = SAMPLES;
    frame.count_lights = true;
    test_render_frame(renderer, &frame);
    fnl_frame_stats stats;
    assert_int_equal(fnl_renderer_query_stats(renderer, &stats), FNL_OK);
    fnl_image image = test_read(renderer, FNL_OUTPUT_COLOR);
    uint64_t least = 0, most = 0;
    uint32_t met[32] = {0};
    for (uint32_t y = 0; y < SIZE; y++)
        for (uint32_t x = 0; x < SIZE; x++) {
            uint32_t sure = 0, unsure = 0;
            for (uint32_t i = 0; i < count; i++) {
                const double dx = (x + 0.5) * PIXEL - 1 - (double)lights[i].at.x, dy = 1 - (y + 0.5) * PIXEL - (double)lights[i].at.y, z = (double)lights[i].at.z,
                             away = sqrt(dx * dx + dy * dy + z * z) - (double)lights[i].range;
                const uint32_t rays = shadows == FNL_SHADOWS_MAPS && kind == FNL_LIGHT_POINT ? 0 : lights[i].radius > 0 ? SAMPLES : 1;
                *(fabs(away) < 1e-4 ? &unsure : &sure) += away < 1e-4 ? rays : 0;
            }
            least += sure;
            most += sure + unsure;
            if (unsure || (x < 160 && y >= SIZE - LEGEND_HEIGHT)) continue;
            met[sure]++;
            const vec3 color = heat((log2(fmax(sure, 1)) + 1) / 9);
            expect_color(&image, x, y, sure ? vec3_lerp(plain(), color, 0.8f) : vec3_scale(plain(), 0.5f), "rays");
        }
    const uint64_t sent = counter(&stats, "shadows.rays");
    if (sent < least || sent > most) fail_msg("%u rays are sent, the view shows %u to %u", (uint32_t)sent, (uint32_t)least, (uint32_t)most);
    if (shadows == FNL_SHADOWS_RAYS) assert_true(met[0] > 100 && met[1] > 100 && met[2] > 100 && met[3] > 100 && met[SAMPLES + 3] > 100);
    expect_color(&image, 16 * 3 + 14, SIZE - 2, heat(3 / 9.0), "legend"); /* 4 */
    free_picture(&image);
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

static void test_rays_of_pixels(void **state) {
    UNUSED(state);
    static const struct ray_light lights[] = {{{-0.3f, 0, 0.3f}, 0.8f, 0}, {{0.3f, 0.1f, 0.4f}, 0.8f, 0}, {{0, 0.3f, 0.2f}, 0.7f, 0}, {{0.1f, 0, 0.2f}, 0.4f, 0.1f}};
    check_rays(lights, COUNT_OF(lights), FNL_SHADOWS_RAYS, FNL_LIGHT_POINT);
    check_rays(lights, COUNT_OF(lights), FNL_SHADOWS_MAPS, FNL_LIGHT_POINT);   /* none */
    check_rays(lights, COUNT_OF(lights), FNL_SHADOWS_MAPS, FNL_LIGHT_CAPSULE); /* which have no maps */
}

/* ---- ages ---- */

/* Frames since the page was drawn: all grow in each frame, but for the pages that see what has moved. */
static void test_ages_of_pages(void **state) {
    UNUSED(state);
    const vec3 at = {-0.6f, 0.1f, 2.9f};
    fnl_scene *scene = floor_scene(1.5f);
    struct scene_material m = scene_material_default();
    const uint32_t node = test_place(scene, test_quad_mesh(scene, scene_add_material(scene, &m)), (vec3){0.7f, 0.7f, 0.3f}, (vec3){0.05f, 0.05f, 1});
    const fnl_light_params light = test_point(at, 1, 40);
    add_light(scene, &light);
    fnl_renderer *renderer = test_renderer(scene);
    fnl_frame frame = view_frame(FNL_DEBUG_SHADOW_AGE);
    const fnl_instance_id id = {node, scene->nodes.data[node].generation};
    enum { MOVED = 4, FRAMES = 7 };
    uint64_t drawn = 0;
    for (int step = 0; step < FRAMES; step++) {
        if (step == MOVED) {
            const mat4 place = mat4_from_trs((vec3){0.72f, 0.7f, 0.3f}, quat_identity(), (vec3){0.05f, 0.05f, 1});
            assert_int_equal(fnl_scene_set_instance_transform(scene, id, &place), FNL_OK);
        }
        test_render_frame(renderer, &frame);
        fnl_frame_stats stats;
        assert_int_equal(fnl_renderer_query_stats(renderer, &stats), FNL_OK);
        if (step == MOVED) drawn = counter(&stats, "shadows.drawn");
        fnl_image image = test_read(renderer, FNL_OUTPUT_COLOR);
        struct page pages[64];
        uint32_t count = 0, old = 0, fresh = 0;
        for (uint32_t y = 0; y < SIZE; y++)
            for (uint32_t x = 0; x < SIZE; x++) {
                const struct place p = place_of(at, x, y, 0);
                if (p.level < 0 || (x > 150 && y < 50)) continue; /* the square itself */
                const bool is_old = is_color(&image, x, y, vec3_lerp(plain(), heat(1 - log2(step + 1) / 6), 0.8f));
                if (!is_old) expect_color(&image, x, y, vec3_lerp(plain(), heat(1 - log2(step < MOVED ? step + 1 : step - MOVED + 1) / 6), 0.8f), "ages");
                uint32_t i = 0;
                while (i < count && !same_page(&pages[i], 0, &p)) i++;
                assert_true(i < COUNT_OF(pages));
                if (i == count) {
                    pages[count++] = (struct page){0, p, {is_old}};
                    *(is_old ? &old : &fresh) += 1;
                }
                assert_int_equal(pages[i].color[0], is_old);
            }
        assert_true(old > 2 && (step < MOVED ? fresh == 0 : fresh > 0 && fresh <= drawn && drawn < old));
        free_picture(&image);
    }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* Where finer pages wait for room the coarser ones that stand in are striped. */
static void test_missing_pages_are_striped(void **state) {
    UNUSED(state);
    fnl_scene *scene = floor_scene(1.5f);
    const fnl_light_params light = test_point((vec3){0, 0, 2.9f}, 1, 40);
    add_light(scene, &light);
    fnl_renderer *renderer = test_renderer(scene);
    fnl_frame frame = view_frame(FNL_DEBUG_SHADOW_AGE);
    frame.width = frame.height = SIZE / 4; /* coarse pages */
    test_render_frame(renderer, &frame);
    renderer->shadows.pairs = 1; /* of a page and an item: one page a frame */
    frame.width = frame.height = SIZE;
    uint32_t last = SIZE * SIZE;
    for (int step = 0; step < 3 + GPU_FRAMES_IN_FLIGHT; step++) {
        test_render_frame(renderer, &frame);
        fnl_image image = test_read(renderer, FNL_OUTPUT_COLOR);
        uint32_t striped = 0;
        for (uint32_t y = 0; y < SIZE; y++)
            for (uint32_t x = 0; x < SIZE; x++) {
                const bool is = is_color(&image, x, y, (vec3){0.9f, 0.1f, 0.8f});
                assert_true(!is || (x + y) % 8 < 2);
                striped += is;
            }
        if (step == 0) assert_true(striped > SIZE * SIZE / 6 && striped < SIZE * SIZE / 4); /* all but one page's */
        assert_true(striped <= last);
        last = striped;
        free_picture(&image);
    }
    assert_int_equal(last, 0);
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* ---- classes ---- */

enum { CLASSES = 4, TILE = 8, TILES = SIZE / TILE };

/* How many of at most two lights of a tile are in each class; false: the colour is no such mixture. */
static bool classes_of(const fnl_image *image, uint32_t tile_x, uint32_t tile_y, uint32_t counts[CLASSES]) {
    static const vec3 colors[CLASSES] = {{0.1f, 0.3f, 0.9f}, {1, 0.45f, 0.05f}, {0.4f, 0.4f, 0.4f}, {1, 1, 1}};
    const uint32_t x = tile_x * TILE + 3, y = tile_y * TILE + 3;
    memset(counts, 0, CLASSES * sizeof *counts);
    if (is_color(image, x, y, vec3_scale(plain(), 0.5f))) return true;
    for (uint32_t a = 0; a < CLASSES; a++)
        for (uint32_t b = a; b < CLASSES; b++)
            if (is_color(image, x, y, vec3_lerp(plain(), vec3_lerp(colors[a], colors[b], 0.5f), 0.8f))) {
                counts[a]++;
                counts[b]++;
                return true;
            }
    return false;
}

/*
 * Two lights, and a square that hides the floor from the first: their lists in tiles. Both have unlimited range, so that each tile has two entries; sums are
 * those of the statistics.
 */
static void test_classes_of_tiles_ES_49(void **state) {
    UNUSED(state);
    const vec3 at[2] = {{0, 0, 2}, {-0.9f, 0.9f, 1.2f}};
    fnl_scene *scene = floor_scene(1.5f);
    struct scene_material m = scene_material_default();
    m.double_sided = true;
    test_place(scene, test_quad_mesh(scene, scene_add_material(scene, &m)), (vec3){0.3f, -0.3f, 0.3f}, (vec3){0.4f, 0.3f, 1});
    for (int i = 0; i < 2; i++) {
        const fnl_light_params light = test_point(at[i], 1, 1e4f);
        add_light(scene, &light);
    }
    fnl_frame frame = view_frame(FNL_DEBUG_SHADOW_CLASSES);
    frame.camera.position.z = 0.2f; /* from below the square */
    frame.camera.near_distance = 0.05f;
    frame.shadow.classify = true;
    frame.lists = FNL_LISTS_TILED;
    fnl_renderer *renderer = test_renderer(scene);
    test_render_frame(renderer, &frame);
    fnl_frame_stats stats;
    assert_int_equal(fnl_renderer_query_stats(renderer, &stats), FNL_OK);
    fnl_image image = test_read(renderer, FNL_OUTPUT_COLOR);
    uint32_t sums[CLASSES] = {0}, wrong = 0;
    for (uint32_t y = 0; y < TILES; y++)
        for (uint32_t x = 0; x < TILES; x++) {
            uint32_t counts[CLASSES], lit[2] = {0};
            if (!classes_of(&image, x, y, counts)) fail_msg("tile %u, %u has the colour %d %d %d", x, y, test_pixel8(&image, x * TILE + 3, y * TILE + 3)[0],
                                                            test_pixel8(&image, x * TILE + 3, y * TILE + 3)[1], test_pixel8(&image, x * TILE + 3, y * TILE + 3)[2]);
            bool close = false; /* to the edge of a shadow */
            for (int k = 0; k < 2; k++)
                for (uint32_t i = 0; i < TILE * TILE; i++) {
                    const double px = (x * TILE + i % TILE + 0.5) * PIXEL - 1, py = 1 - (y * TILE + i / TILE + 0.5) * PIXEL, part = 0.3 / (double)at[k].z;
                    const double sx = px + ((double)at[k].x - px) * part - 0.3, sy = py + ((double)at[k].y - py) * part + 0.3;
                    const double inside = fmin(0.4 - fabs(sx), 0.3 - fabs(sy));
                    close = close || fabs(inside) < 1.5 * PIXEL;
                    lit[k] += inside < 0;
                }
            uint32_t all = 0, none = 0;
            for (int k = 0; k < 2; k++) {
                all += lit[k] == TILE * TILE;
                none += lit[k] == 0;
            }
            if (!close) wrong += counts[3] != all || counts[0] + counts[1] != none || counts[2] != 2 - all - none;
            for (uint32_t i = 0; i < CLASSES; i++) sums[i] += counts[i];
        }
    print_message("left %u, dark %u, some %u, all %u\n", sums[0], sums[1], sums[2], sums[3]);
    assert_int_equal(wrong, 0);
    assert_int_equal(sums[0] + sums[1] + sums[2] + sums[3], 2 * TILES * TILES);
    assert_int_equal(counter(&stats, "shadows.entries"), 2 * TILES * TILES);
    assert_int_equal(counter(&stats, "shadows.dark"), sums[0]);
    assert_true(sums[0] > 60 && sums[1] < sums[0] && sums[2] > 30 && sums[3] > 700);
    free_picture(&image);
    frame.shadow.classify = false;
    assert_int_equal(fnl_renderer_render(renderer, &frame), FNL_ERROR_UNSUPPORTED);
    frame.shadow.classify = true;
    frame.shading = FNL_SHADING_LIGHT_PREPASS;
    assert_int_equal(fnl_renderer_render(renderer, &frame), FNL_ERROR_UNSUPPORTED);
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* Tiles that no light reaches have none in any class. */
static void test_tiles_without_lights(void **state) {
    UNUSED(state);
    fnl_scene *scene = floor_scene(1.5f);
    const fnl_light_params light = test_point((vec3){0, 0, 0.1f}, 1, 0.3f); /* reaches those in the middle */
    add_light(scene, &light);
    fnl_frame frame = view_frame(FNL_DEBUG_SHADOW_CLASSES);
    frame.shadow.classify = true;
    frame.lists = FNL_LISTS_TILED;
    fnl_renderer *renderer = test_renderer(scene);
    harness_hooks(renderer)->poison = true;
    test_render_frame(renderer, &frame);
    fnl_image image = test_read(renderer, FNL_OUTPUT_COLOR);
    uint32_t none = 0, some = 0;
    for (uint32_t y = 0; y < TILES; y++)
        for (uint32_t x = 0; x < TILES; x++) {
            const double px = fabs((x + 0.5) * TILE * PIXEL - 1), py = fabs((y + 0.5) * TILE * PIXEL - 1);
            const bool is_plain = is_color(&image, x * TILE + 3, y * TILE + 3, vec3_scale(plain(), 0.5f));
            if (fmax(px, py) > 0.3 + 2 * TILE * PIXEL) {
                if (!is_plain) fail_msg("tile %u, %u shows classes of lights", x, y);
                none++;
            } else
                some += !is_plain;
        }
    assert_true(none > TILES && some > 0);
    free_picture(&image);
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* ---- every path ---- */

static void test_views_need_maps(void **state) {
    UNUSED(state);
    fnl_scene *scene = floor_scene(0.5f);
    fnl_renderer *renderer = test_renderer(scene);
    for (uint32_t view = FNL_DEBUG_SHADOW_PAGES; view <= FNL_DEBUG_SHADOW_ERRORS; view++)
        for (uint32_t shadows = 0; shadows < FNL_SHADOWS_COUNT; shadows++) {
            fnl_frame frame = view_frame((fnl_debug_view)view);
            if (shadows == FNL_SHADOWS_AUTO) continue; /* one of the others */
            frame.shadows = (fnl_shadows)shadows;
            const bool shown = shadows == FNL_SHADOWS_MAPS || shadows == FNL_SHADOWS_HYBRID || (shadows == FNL_SHADOWS_CUBEMAP && view == FNL_DEBUG_SHADOW_ERRORS);
            assert_int_equal(fnl_renderer_render(renderer, &frame), shown ? FNL_OK : FNL_ERROR_UNSUPPORTED);
        }
    for (uint32_t shadows = 0; shadows < FNL_SHADOWS_AUTO; shadows++) {
        fnl_frame frame = view_frame(FNL_DEBUG_SHADOW_RAYS);
        frame.shadows = (fnl_shadows)shadows;
        assert_int_equal(fnl_renderer_render(renderer, &frame), shadows == FNL_SHADOWS_OFF || shadows == FNL_SHADOWS_SAMPLED ? FNL_ERROR_UNSUPPORTED : FNL_OK);
        frame.debug = FNL_DEBUG_SHADOW_AGE;
        assert_int_equal(fnl_renderer_render(renderer, &frame), shadows == FNL_SHADOWS_MAPS || shadows == FNL_SHADOWS_HYBRID ? FNL_OK : FNL_ERROR_UNSUPPORTED);
    }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* What is looked up does not depend on how surfaces are shaded, nor on the lists: one picture for all. */
static void test_views_are_the_same_in_all_paths(void **state) {
    UNUSED(state);
    fnl_scene *scene = floor_scene(1.5f);
    for (int i = 0; i < 40; i++) {
        const vec3 at = {-1 + 0.05f * (float)i, 0.5f - 0.03f * (float)(i % 7), 0.4f + 0.1f * (float)(i % 5)};
        const fnl_light_params light = test_point(at, 1, 1.5f);
        add_light(scene, &light);
    }
    fnl_renderer *renderer = test_renderer(scene);
    fnl_frame frame = view_frame(FNL_DEBUG_SHADOW_PAGES);
    frame.width = frame.height = 64;
    test_render_frame(renderer, &frame);
    fnl_image first = test_read(renderer, FNL_OUTPUT_COLOR);
    for (uint32_t shading = 0; shading <= FNL_SHADING_AUTO; shading++) {
        frame.shading = shading == FNL_SHADING_AUTO ? FNL_SHADING_FORWARD : (fnl_shading)shading;
        frame.lists = shading == FNL_SHADING_AUTO ? FNL_LISTS_ALL : FNL_LISTS_TILED;
        if (!fnl_shading_supports(frame.shading, frame.lists, 1)) frame.lists = FNL_LISTS_MULTIPASS;
        test_render_frame(renderer, &frame);
        fnl_image image = test_read(renderer, FNL_OUTPUT_COLOR);
        if (!test_equal(&first, &image)) fail_msg("%s shows other pages", fnl_value_name(FNL_ENUM_SHADING, frame.shading));
        free_picture(&image);
    }
    free_picture(&first);
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_levels_and_texels),
        cmocka_unit_test(test_coarser_texels),
        cmocka_unit_test(test_legend),
        cmocka_unit_test(test_pages),
        cmocka_unit_test(test_pixels_without_pages),
        cmocka_unit_test(test_errors_are_where_rays_differ),
        cmocka_unit_test(test_rays_of_pixels),
        cmocka_unit_test(test_ages_of_pages),
        cmocka_unit_test(test_missing_pages_are_striped),
        cmocka_unit_test(test_classes_of_tiles_ES_49),
        cmocka_unit_test(test_tiles_without_lights),
        cmocka_unit_test(test_views_need_maps),
        cmocka_unit_test(test_views_are_the_same_in_all_paths),
    };
    return cmocka_run_group_tests(tests, test_group_begin, test_group_end);
}
