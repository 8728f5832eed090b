/* SPDX-License-Identifier: MIT */
/** Surfaces that show what is behind them: against rays, in layers, and what frames without them pay. */
#include "fanal/trace.h"
#include "render/shading.h"
#include "tests/coarse_cases.h"
#include "tests/render_harness.h"

enum { WIDTH = 64, HEIGHT = 40 };
#define DEGREES_45 0.78539816339744831

static fnl_material_params glass(float r, float g, float b) {
    fnl_material_params p = fnl_material_params_default();
    p.base_color[0] = r, p.base_color[1] = g, p.base_color[2] = b;
    p.metallic = p.roughness = 0;
    p.transmission.strength = 1;
    return p;
}

static fnl_material_id add_material(fnl_scene *scene, const fnl_material_params *p) {
    fnl_material_id id;
    assert_int_equal(fnl_scene_add_material(scene, p, &id), FNL_OK);
    return id;
}

static fnl_material_id add_glow(fnl_scene *scene, float r, float g, float b) {
    fnl_material_params p = fnl_material_params_default();
    p.base_color[0] = p.base_color[1] = p.base_color[2] = 0;
    p.specular = 0;
    p.metallic = 0;
    p.emissive[0] = r, p.emissive[1] = g, p.emissive[2] = b;
    return add_material(scene, &p);
}

/* Strips of known radiance, 0.5 m wide, at z = -2. */
static void add_wall(fnl_scene *scene) {
    const fnl_material_id colors[3] = {add_glow(scene, 4, 1, 0.5f), add_glow(scene, 0.5f, 3, 1), add_glow(scene, 1, 0.5f, 5)};
    for (int i = -8; i < 8; i++) coarse_add_plane(scene, colors[(i + 9) % 3], 0.5f * (float)i, 0.5f * (float)(i + 1), -2, 0, 0);
}

/* A square that faces the camera, or its wall, at z. */
static void add_pane(fnl_scene *scene, fnl_material_id material, float x, float y, float z, float half, float scale) {
    const float positions[12] = {-half, -half, 0, half, -half, 0, half, half, 0, -half, half, 0}, normals[12] = {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1};
    const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
    const fnl_mesh_params mesh = {4, 6, positions, normals, NULL, NULL, NULL, indices, material};
    fnl_mat4 place = mat4_translation((vec3){x, y, z});
    place.m[0] = place.m[5] = place.m[10] = scale;
    fnl_mesh_id id;
    fnl_instance_id instance;
    assert_int_equal(fnl_scene_add_mesh(scene, &mesh, &id), FNL_OK);
    assert_int_equal(fnl_scene_add_instance(scene, id, &place, &instance), FNL_OK);
}

/* Closed, with corners of its own for each face. */
static void add_box(fnl_scene *scene, fnl_material_id material, vec3 at, vec3 half) {
    float positions[72], normals[72];
    uint32_t indices[36];
    for (uint32_t face = 0; face < 6; face++) {
        const uint32_t axis = face / 2, u = (axis + 1) % 3, v = (axis + 2) % 3;
        const float sign = face % 2 ? 1 : -1, *size = &half.x;
        for (uint32_t k = 0; k < 4; k++) {
            const float du = k == 1 || k == 2 ? 1 : -1, dv = k >= 2 ? 1 : -1;
            float *p = &positions[(face * 4 + k) * 3], *n = &normals[(face * 4 + k) * 3];
            n[axis] = sign, n[u] = n[v] = 0;
            p[axis] = sign * size[axis], p[u] = sign * du * size[u], p[v] = dv * size[v];
        }
        const uint32_t corners[6] = {0, 1, 2, 0, 2, 3};
        for (uint32_t k = 0; k < 6; k++) indices[face * 6 + k] = face * 4 + corners[k];
    }
    const fnl_mesh_params mesh = {24, 36, positions, normals, NULL, NULL, NULL, indices, material};
    const fnl_mat4 place = mat4_translation(at);
    fnl_mesh_id id;
    fnl_instance_id instance;
    assert_int_equal(fnl_scene_add_mesh(scene, &mesh, &id), FNL_OK);
    assert_int_equal(fnl_scene_add_instance(scene, id, &place, &instance), FNL_OK);
}

static struct stage open_view(fnl_scene *scene) {
    struct stage s = stage_open_scene(scene);
    s.frame.width = WIDTH, s.frame.height = HEIGHT;
    s.frame.outputs = FNL_OUTPUT_RADIANCE;
    s.frame.camera = fnl_camera_default();
    s.frame.camera.position = (fnl_vec3){0, 0, 3};
    s.frame.camera.target = (fnl_vec3){0, 0, 0};
    s.frame.camera.vertical_fov = 0.6f;
    return s;
}

static uint64_t count_of(const struct stage *s, const char *key) {
    const fnl_frame_stats stats = harness_stats(s->renderer);
    for (uint32_t i = 0; i < stats.counter_count; i++)
        if (strcmp(stats.counters[i].key, key) == 0) return stats.counters[i].value;
    fail_msg("no counter %s", key);
    return 0;
}

/* As programs do: again while something had no room. */
static struct shot shoot_all(struct stage *s) {
    struct shot shot = stage_shoot(s, &s->frame);
    for (int i = 0; i < 8 && count_of(s, "transmission.overflow-layers"); i++) {
        shot_free(&shot);
        shot = stage_shoot(s, &s->frame);
    }
    return shot;
}

static const float *pixel_at(const struct shot *shot, uint32_t x, uint32_t y) {
    return (const float *)shot->radiance.pixels + 4 * ((size_t)y * shot->radiance.width + x);
}

/* Relative root of the mean squared difference over columns x0 .. x1, rows y0 .. y1. */
static double difference(const fnl_image *a, const fnl_image *b, uint32_t x0, uint32_t y0, uint32_t x1, uint32_t y1) {
    const float *pa = a->pixels, *pb = b->pixels;
    double error = 0, sum = 0;
    for (uint32_t y = y0; y < y1; y++)
        for (uint32_t x = x0; x < x1; x++)
            for (uint32_t c = 0; c < 3; c++) {
                const size_t at = 4 * ((size_t)y * a->width + x) + c;
                error += pow((double)pa[at] - (double)pb[at], 2);
                sum += pow((double)pb[at], 2);
            }
    return sqrt(error / sum);
}

static fnl_trace trace_of(const struct stage *s, uint32_t samples) {
    fnl_trace_params p = trace_plain();
    p.width = s->frame.width, p.height = s->frame.height, p.camera = s->frame.camera;
    p.samples = samples;
    p.shadows = s->frame.shadows == FNL_SHADOWS_RAYS;
    fnl_trace trace;
    assert_int_equal(fnl_scene_trace(s->scene, &p, &trace), FNL_OK);
    return trace;
}

/* ---- sheets ---- */

/* Clear, frosted near the wall, frosted far from it, and half frosted between bumps: blurred by how far away what is behind is. */
static void test_sheets_are_those_of_rays_MA_13(void **state) {
    UNUSED(state);
    static const float roughness[4] = {0, 0.3f, 0.3f, 0.6f}, z[4] = {-1, -1.9f, -1, -1.7f};
    fnl_scene *scene = coarse_scene();
    add_wall(scene);
    for (int i = 0; i < 4; i++) {
        fnl_material_params p = glass(0.9f, 0.6f, 0.8f);
        p.roughness = roughness[i];
        add_pane(scene, add_material(scene, &p), (i % 2 ? 0.7f : -0.7f) * (3 - z[i]) / 4, (i / 2 ? -0.45f : 0.45f) * (3 - z[i]) / 4, z[i], 0.35f * (3 - z[i]) / 4, 1);
    }
    coarse_add_light(scene, FNL_LIGHT_POINT, (vec3){0.4f, 0.3f, 1}, 3);    /* highlights, */
    coarse_add_light(scene, FNL_LIGHT_POINT, (vec3){-0.4f, -0.2f, -1.8f}, 3); /* and one that shines through */
    struct stage s = open_view(scene);
    struct shot shot = shoot_all(&s);
    fnl_trace traces[2] = {trace_of(&s, 1), trace_of(&s, 400)}; /* what is sharp: through the same points */
    double worst = 0;
    for (uint32_t i = 0; i < 4; i++) {
        const uint32_t x = i % 2 ? 39 : 16, y = i / 2 ? 25 : 6; /* within the panes */
        const double off = difference(&shot.radiance, &traces[roughness[i] > 0].radiance, x, y, x + 9, y + 9);
        print_message("roughness %.1f at z %.1f: %.4f off\n", (double)roughness[i], (double)z[i], off);
        worst = fmax(worst, off / (roughness[i] > 0 ? 0.09 : 0.002));
    }
    assert_true(worst < 1);
    for (int i = 0; i < 2; i++) fnl_trace_free(&s.scene->host, &traces[i]);
    shot_free(&shot);
    stage_close(&s);
}

/* ---- volumes ---- */

/* Along the normal: what enters, is tinted and attenuated by the instance's thickness. Of a wall that is even where it is looked at. */
static void test_volumes_attenuate_MA_14(void **state) {
    UNUSED(state);
    fnl_scene *scene = coarse_scene();
    coarse_add_plane(scene, add_glow(scene, 2, 2, 2), -4, 4, -2, 0, 0);
    fnl_material_params p = glass(0.9f, 0.8f, 0.7f);
    p.volume = (fnl_volume_params){.thickness = 0.4f, .attenuation_distance = 0.5f, .attenuation_color = {0.5f, 0.7f, 0.2f}};
    const fnl_material_id volume = add_material(scene, &p);
    add_pane(scene, volume, -0.6f, 0, 0, 0.4f, 1);
    add_pane(scene, volume, 0.6f, 0, 0, 0.2f, 2); /* twice as thick */
    struct stage s = open_view(scene);
    s.frame.camera.orthographic = true, s.frame.camera.vertical_extent = 2;
    struct shot shot = shoot_all(&s);
    for (int i = 0; i < 2; i++) {
        const float *seen = pixel_at(&shot, i ? 51 : 12, HEIGHT / 2);
        for (int c = 0; c < 3; c++) {
            const double want = 2 * 0.96 * (double)p.base_color[c] * pow((double)p.volume.attenuation_color[c], (i ? 0.8 : 0.4) / 0.5);
            print_message("%d, %d: %.4f, %.4f\n", i, c, (double)seen[c], want);
            assert_true(fabs((double)seen[c] - want) < 0.006 * want + 0.002); /* the table of reflectance has halves */
        }
    }
    shot_free(&shot);
    stage_close(&s);
}

/* Where the border between two colours of the wall is seen, in pixels, as `channel` goes from `low` to `high` in a row. */
static double border_of(const struct shot *shot, uint32_t x0, uint32_t x1, uint32_t y, int channel) {
    const double first = (double)pixel_at(shot, x0, y)[channel], last = (double)pixel_at(shot, x1, y)[channel];
    for (uint32_t x = x0; x < x1; x++) {
        const double a = (double)pixel_at(shot, x, y)[channel], b = (double)pixel_at(shot, x + 1, y)[channel], middle = (first + last) / 2;
        if ((a - middle) * (b - middle) <= 0 && a != b) return x + (middle - a) / (b - a);
    }
    fail_msg("no border between columns %u and %u", x0, x1);
    return 0;
}

/* A plate moves what is behind it: by the way through it at Snell's angle. With dispersion each colour by its own index. */
static void test_volumes_refract_MA_15(void **state) {
    UNUSED(state);
    double borders[3][3];
    for (int variant = 0; variant < 3; variant++) { /* a sheet, a volume, one that disperses */
        fnl_scene *scene = coarse_scene();
        coarse_add_plane(scene, add_glow(scene, 4, 4, 4), -4, 0, -2, 0, 0);
        coarse_add_plane(scene, add_glow(scene, 1, 1, 1), 0, 4, -2, 0, 0);
        fnl_material_params p = glass(1, 1, 1);
        p.ior = 1.5f;
        if (variant) p.volume.thickness = 0.8f;
        if (variant == 2) p.dispersion = 6;
        /* It leans 45 degrees: z = x. */
        coarse_add_plane(scene, add_material(scene, &p), -1, 1, 0, 1, 0);
        struct stage s = open_view(scene);
        s.frame.camera.orthographic = true, s.frame.camera.vertical_extent = 2;
        struct shot shot = shoot_all(&s);
        for (int c = 0; c < 3; c++) borders[variant][c] = border_of(&shot, 14, 50, HEIGHT / 2, c);
        shot_free(&shot);
        stage_close(&s);
    }
    const double pixel = 2.0 / HEIGHT, spread = 0.5 * 0.025 * 6;
    for (int c = 0; c < 3; c++) {
        const double ior = 1.5 + spread * (c - 1), plain = 0.8 * sin(DEGREES_45 - asin(sin(DEGREES_45) / 1.5)),
                     split = 0.8 * sin(DEGREES_45 - asin(sin(DEGREES_45) / ior));
        print_message("%d: %.2f, moved by %.2f (%.2f), %.2f (%.2f)\n", c, borders[0][c], borders[1][c] - borders[0][c], plain / pixel,
                      borders[2][c] - borders[0][c], split / pixel);
        assert_true(fabs(borders[0][c] - 31.5) < 0.3);
        assert_true(fabs(fabs(borders[1][c] - borders[0][c]) - plain / pixel) < 0.3);
        assert_true(fabs(fabs(borders[2][c] - borders[0][c]) - split / pixel) < 0.3);
    }
}

/* ---- layers ---- */

/* Panes of three colours that glow and came in no order: each dims those behind it. Too few layers leave out the farthest. */
static void test_layers_are_seen_through_each_other_MA_16(void **state) {
    UNUSED(state);
    static const float colors[3][3] = {{0.9f, 0.3f, 0.8f}, {0.5f, 0.9f, 0.6f}, {0.7f, 0.8f, 0.4f}}, z[3] = {-0.5f, 0.5f, 0};
    fnl_scene *scene = coarse_scene();
    coarse_add_plane(scene, add_glow(scene, 2, 2, 2), -4, 4, -2, 0, 0);
    for (int i = 0; i < 3; i++) {
        fnl_material_params p = glass(colors[i][0], colors[i][1], colors[i][2]);
        p.emissive[i] = 0.7f;
        add_pane(scene, add_material(scene, &p), 0.3f * (float)(i - 1), 0, z[i], 0.6f, 1);
    }
    struct stage s = open_view(scene);
    struct shot shot = stage_shoot(&s, &s.frame);
    assert_int_equal(count_of(&s, "transmission.layers"), 1);
    assert_int_equal(count_of(&s, "transmission.longest"), 3);
    assert_int_equal(count_of(&s, "transmission.overflow-layers"), 2);
    shot_free(&shot);
    for (uint32_t limit = 3; limit >= 1; limit--) {
        s.frame.transmission_layers = limit;
        shot = shoot_all(&s);
        assert_int_equal(count_of(&s, "transmission.layers"), limit);
        assert_int_equal(count_of(&s, "transmission.overflow-layers"), 0);
        const float *seen = pixel_at(&shot, WIDTH / 2, HEIGHT / 2);
        for (int c = 0; c < 3; c++) {
            double want = 2;
            static const int behind[3] = {0, 2, 1}; /* from the farthest on */
            for (uint32_t k = 3 - limit; k < 3; k++) want = want * 0.96 * (double)colors[behind[k]][c] + (c == behind[k] ? 0.7 : 0);
            print_message("%u layers, %d: %.4f, %.4f\n", limit, c, (double)seen[c], want);
            assert_true(fabs((double)seen[c] - want) < 0.01 * want);
        }
        shot_free(&shot);
    }
    stage_close(&s);
}

/* A box in a box, and a pane that is half opaque with a card's shadow on it, in each order and with MSAA. */
static void test_every_order_draws_transmission_MA_17(void **state) {
    UNUSED(state);
    fnl_scene *scene = coarse_scene();
    add_wall(scene);
    fnl_material_params outer = glass(0.9f, 0.95f, 0.9f), inner = glass(0.9f, 0.5f, 0.3f);
    outer.volume = (fnl_volume_params){.thickness = 0.2f, .attenuation_distance = 1, .attenuation_color = {0.6f, 0.8f, 0.9f}};
    outer.roughness = 0.15f;
    add_box(scene, add_material(scene, &inner), (vec3){0.1f, 0, 0}, (vec3){0.25f, 0.25f, 0.25f});
    add_box(scene, add_material(scene, &outer), (vec3){0, 0, 0}, (vec3){0.6f, 0.5f, 0.5f});
    fnl_material_params half = glass(0.9f, 0.9f, 0.9f);
    half.transmission.strength = 0.3f;
    half.roughness = 0.8f;
    add_pane(scene, add_material(scene, &half), 0.95f, -0.1f, 0.2f, 0.35f, 1);
    add_pane(scene, add_glow(scene, 0, 0, 0), 0.925f, 0.2f, 0.5f, 0.12f, 1);
    for (int i = 0; i < 4; i++)
        coarse_add_light(scene, i % 2 ? FNL_LIGHT_POINT : FNL_LIGHT_SPOT, (vec3){-0.9f + 0.6f * (float)i, 0.5f, 0.8f}, 4);
    struct stage s = open_view(scene);
    for (uint32_t msaa = 1; msaa <= 4; msaa += 3) {
        s.frame.msaa = msaa;
        s.frame.shading = FNL_SHADING_FORWARD;
        struct shot want = shoot_all(&s);
        for (int shading = 0; shading < FNL_SHADING_AUTO; shading++) {
            s.frame.shading = (fnl_shading)shading;
            const bool some = shading == FNL_SHADING_DEFERRED || shading == FNL_SHADING_LIGHT_PREPASS;
            if (msaa > 1 && !some) continue;
            struct shot shot = shoot_all(&s);
            const double off = difference(&shot.radiance, &want.radiance, 0, 0, WIDTH, HEIGHT);
            print_message("%s, %u samples: %.5f off\n", fnl_value_name(FNL_ENUM_SHADING, s.frame.shading), msaa, off);
            assert_true(off < (shading == FNL_SHADING_MOBILE ? 0.01 : 1e-4)); /* which keeps light in 11 bits */
            shot_free(&shot);
        }
        shot_free(&want);
    }
    /* Maps hold no shadow of what lets all through, and are asked for by what is seen of it. */
    s.frame.msaa = 1;
    s.frame.shading = FNL_SHADING_DEFERRED;
    s.frame.shadows = FNL_SHADOWS_RAYS;
    struct shot rays = shoot_all(&s);
    s.frame.shadows = FNL_SHADOWS_MAPS;
    for (int i = 0; i < 3; i++) shot_free(&(struct shot[]){stage_shoot(&s, &s.frame)}[0]); /* pages come a frame later */
    struct shot maps = shoot_all(&s);
    s.frame.shadows = FNL_SHADOWS_OFF;
    struct shot off = shoot_all(&s);
    const double by_maps = difference(&maps.radiance, &rays.radiance, 0, 0, WIDTH, HEIGHT), none = difference(&off.radiance, &rays.radiance, 0, 0, WIDTH, HEIGHT);
    print_message("shadows of maps: %.4f off, of none: %.4f\n", by_maps, none);
    assert_true(by_maps < 0.5 * none); /* edges of pages of a small picture */
    shot_free(&off);
    shot_free(&rays);
    shot_free(&maps);
    stage_close(&s);
}

/* Smoke behind glass shows through it, smoke before it covers it, with each kind of transparency; beside the glass each is drawn once. */
static void test_blended_surfaces_lie_on_both_sides_MA_18(void **state) {
    UNUSED(state);
    static const double colors[2][3] = {{3, 0, 0.5}, {0, 1, 4}};
    fnl_scene *scene = coarse_scene();
    coarse_add_plane(scene, add_glow(scene, 2, 2, 2), -4, 4, -2, 0, 0);
    fnl_material_params pane = glass(0.8f, 0.7f, 0.6f);
    add_pane(scene, add_material(scene, &pane), -0.4f, 0, 0, 0.4f, 1);
    for (int i = 0; i < 2; i++) {
        fnl_material_params p = fnl_material_params_default();
        p.base_color[0] = p.base_color[1] = p.base_color[2] = 0;
        p.specular = 0, p.metallic = 0;
        for (int c = 0; c < 3; c++) p.emissive[c] = (float)colors[i][c];
        p.base_color[3] = 0.5f;
        p.alpha_mode = FNL_ALPHA_BLEND;
        add_pane(scene, add_material(scene, &p), 0, 0, i ? 0.6f : -0.6f, 1, 1);
    }
    struct stage s = open_view(scene);
    for (int kind = 0; kind < 3; kind++) {
        s.frame.transparency = (fnl_transparency)kind;
        struct shot shot = shoot_all(&s);
        for (int side = 0; side < 2; side++) {
            const float *seen = pixel_at(&shot, side ? 46 : 20, HEIGHT / 2);
            for (int c = 0; c < 3; c++) {
                double want = 0.5 * 2 + 0.5 * colors[0][c];
                if (!side) want *= 0.96 * (double)pane.base_color[c];
                want = 0.5 * want + 0.5 * colors[1][c];
                print_message("%d, %d, %d: %.4f, %.4f\n", kind, side, c, (double)seen[c], want);
                if (kind == FNL_TRANSPARENCY_WEIGHTED && side) continue; /* a guess where two cover a pixel */
                assert_true(fabs((double)seen[c] - want) < 0.01 * want);
            }
        }
        shot_free(&shot);
    }
    stage_close(&s);
}

/* ---- light ---- */

/* Paper lit from behind, in even light too, with shadows of a card behind it and of glass before it: against rays. */
static void test_diffuse_transmission_is_that_of_rays_MA_19(void **state) {
    UNUSED(state);
    for (int shadows = 0; shadows < 2; shadows++) {
        fnl_scene *scene = coarse_scene();
        fnl_material_params paper = fnl_material_params_default(), card = fnl_material_params_default();
        paper.metallic = card.metallic = 0;
        paper.double_sided = card.double_sided = true;
        paper.base_color[0] = 0.8f, paper.base_color[1] = 0.7f, paper.base_color[2] = 0.3f;
        paper.diffuse_transmission = (fnl_diffuse_transmission_params){.strength = 0.6f, .color = {0.3f, 0.9f, 0.5f}};
        add_pane(scene, add_material(scene, &paper), 0, 0, 0, 0.8f, 1);
        add_pane(scene, add_material(scene, &card), 0.3f, 0, -0.3f, 0.2f, 1); /* its shadow is seen from the front */
        fnl_material_params pane = glass(0.9f, 0.8f, 0.7f);
        pane.transmission.strength = 0.6f; /* so dark is its shadow */
        if (shadows) add_pane(scene, add_material(scene, &pane), -0.3f, 0.05f, 0.3f, 0.1f, 1);
        coarse_add_light(scene, FNL_LIGHT_POINT, (vec3){0.3f, 0.2f, -0.8f}, 5);
        coarse_add_light(scene, FNL_LIGHT_POINT, (vec3){-0.4f, 0.1f, 0.5f}, 2);
        fnl_light_params sun = fnl_light_params_default(); /* from behind, too */
        sun.kind = FNL_LIGHT_DIRECTIONAL;
        sun.direction = (fnl_vec3){-0.1f, -0.3f, 0.9486833f};
        sun.intensity = 3;
        assert_int_equal(fnl_scene_add_light(scene, &sun, &(fnl_light_id){0}), FNL_OK);
        assert_int_equal(fnl_scene_set_ambient(scene, (fnl_vec3){0.5f, 0.6f, 0.8f}, (fnl_vec3){0.3f, 0.2f, 0.1f}), FNL_OK);
        struct stage s = open_view(scene);
        s.frame.shadows = shadows ? FNL_SHADOWS_RAYS : FNL_SHADOWS_OFF;
        static const struct {
            fnl_shading shading;
            fnl_light_lists lists;
            uint32_t layers; /* of lights per pixel: the others are lit one by one */
            uint32_t msaa;   /* 0: 1 */
        } rows[] = {{FNL_SHADING_FORWARD, FNL_LISTS_TILED, 0, 0},
                    {FNL_SHADING_DEFERRED, FNL_LISTS_BACKFACE, 0, 0}, /* which leaves out lights behind what a G-buffer shows */
                    {FNL_SHADING_VISIBILITY, FNL_LISTS_TILED, 0, 0},
                    {FNL_SHADING_LIGHT_PREPASS, FNL_LISTS_TILED, 0, 0},
                    {FNL_SHADING_FORWARD_PREPASS, FNL_LISTS_MULTIPASS, 0, 0},
                    {FNL_SHADING_DEFERRED_VOLUMES, FNL_LISTS_TILED, 0, 0},
                    {FNL_SHADING_LIGHT_INDEXED, FNL_LISTS_TILED, 4, 0},
                    {FNL_SHADING_ZIOMA, FNL_LISTS_TILED, 4, 0},
                    {FNL_SHADING_ZIOMA, FNL_LISTS_TILED, 1, 0},
                    {FNL_SHADING_FORWARD, FNL_LISTS_TILED, 0, 4},
                    {FNL_SHADING_ZIOMA, FNL_LISTS_TILED, 4, 4}};
        fnl_trace trace = trace_of(&s, 1); /* through the same points */
        for (uint32_t i = 0; i < COUNT_OF(rows); i++) {
            s.frame.shading = rows[i].shading;
            s.frame.lists = rows[i].lists;
            s.frame.msaa = MAX(rows[i].msaa, 1);
            if (rows[i].layers) s.frame.light_indexed.layers = rows[i].layers;
            struct shot shot = stage_shoot(&s, &s.frame);
            const double off = difference(&shot.radiance, &trace.radiance, 20, 10, 44, 30);
            print_message("%s, %s, shadows %d: %.4f off\n", fnl_value_name(FNL_ENUM_SHADING, rows[i].shading), fnl_value_name(FNL_ENUM_LISTS, rows[i].lists), shadows, off);
            assert_true(off < (rows[i].msaa ? 0.2 : 0.005)); /* the edge of the shadow is smoothed: by 0.17 */
            shot_free(&shot);
        }
        fnl_trace_free(&s.scene->host, &trace);
        stage_close(&s);
    }
}

/* ---- what it costs ---- */

static bool has_pass(const struct stage *s, const char *name) {
    const fnl_frame_stats stats = harness_stats(s->renderer);
    for (uint32_t i = 0; i < stats.pass_count; i++)
        if (strstr(stats.passes[i].name, name)) return true;
    return false;
}

/* Strength 0 is a core material, whatever else is set: its bits, no pass and no memory. */
static void test_transmission_of_strength_0_is_none_MA_20(void **state) {
    UNUSED(state);
    struct shot shots[2];
    for (int i = 0; i < 2; i++) {
        fnl_scene *scene = coarse_scene();
        add_wall(scene);
        fnl_material_params p = glass(0.9f, 0.6f, 0.8f);
        p.transmission.strength = 0;
        if (i) p.volume = (fnl_volume_params){.thickness = 1, .attenuation_distance = 0.1f, .attenuation_color = {0.1f, 0.5f, 0.9f}};
        if (i) p.dispersion = 5, p.diffuse_transmission.color[1] = 1;
        add_pane(scene, add_material(scene, &p), 0, 0, 0, 0.5f, 1);
        coarse_add_light(scene, FNL_LIGHT_POINT, (vec3){0.4f, 0.3f, 1}, 3);
        struct stage s = open_view(scene);
        s.frame.timers = true;
        shots[i] = stage_shoot(&s, &s.frame);
        const fnl_frame_stats stats = harness_stats(s.renderer);
        assert_false(has_pass(&s, "transmission"));
        assert_false(has_counter(&stats, "transmission.bytes"));
        stage_close(&s);
    }
    assert_memory_equal(shots[0].radiance.pixels, shots[1].radiance.pixels, WIDTH * HEIGHT * 16);
    shot_free(&shots[0]);
    shot_free(&shots[1]);
}

/* Cutouts without a hole are the glass itself, however clear it is. */
static void test_cutouts_of_glass_are_seen(void **state) {
    UNUSED(state);
    struct shot shots[2];
    for (int i = 0; i < 2; i++) {
        fnl_scene *scene = coarse_scene();
        add_wall(scene);
        fnl_material_params p = glass(0.9f, 0.2f, 0.4f);
        p.alpha_mode = i ? FNL_ALPHA_MASK : FNL_ALPHA_OPAQUE;
        for (int k = 0; k < 2; k++) add_pane(scene, add_material(scene, &p), 0.1f * (float)k, 0, -0.5f * (float)k, 0.5f, 1); /* layers */
        coarse_add_light(scene, FNL_LIGHT_POINT, (vec3){0.4f, 0.3f, 1}, 3);
        struct stage s = open_view(scene);
        shots[i] = stage_shoot(&s, &s.frame);
        assert_true(count_of(&s, "transmission.fragments") > 0);
        stage_close(&s);
    }
    assert_memory_equal(shots[0].radiance.pixels, shots[1].radiance.pixels, WIDTH * HEIGHT * 16);
    shot_free(&shots[0]);
    shot_free(&shots[1]);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_cutouts_of_glass_are_seen, harness_check),
        cmocka_unit_test_teardown(test_sheets_are_those_of_rays_MA_13, harness_check),
        cmocka_unit_test_teardown(test_volumes_attenuate_MA_14, harness_check),
        cmocka_unit_test_teardown(test_volumes_refract_MA_15, harness_check),
        cmocka_unit_test_teardown(test_layers_are_seen_through_each_other_MA_16, harness_check),
        cmocka_unit_test_teardown(test_every_order_draws_transmission_MA_17, harness_check),
        cmocka_unit_test_teardown(test_blended_surfaces_lie_on_both_sides_MA_18, harness_check),
        cmocka_unit_test_teardown(test_diffuse_transmission_is_that_of_rays_MA_19, harness_check),
        cmocka_unit_test_teardown(test_transmission_of_strength_0_is_none_MA_20, harness_check),
    };
    return cmocka_run_group_tests_name("transmission", tests, harness_begin, harness_end);
}
