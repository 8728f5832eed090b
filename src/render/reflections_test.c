/* SPDX-License-Identifier: MIT */
/** Frames with reflection probes: where mirrors show what, energy, how probes blend, every shading order, and what it costs. */
#include "render/shading.h"
#include "tests/coarse_cases.h"
#include "tests/render_harness.h"

static const vec3 HALF = {2, 1.5f, 3};
enum { SIDE = 64 };

/* ---- rooms ---- */

static fnl_material_id add_material(fnl_scene *scene, fnl_material_params params) {
    fnl_material_id id;
    assert_int_equal(fnl_scene_add_material(scene, &params, &id), FNL_OK);
    return id;
}

static fnl_material_params mirror(void) {
    fnl_material_params params = fnl_material_params_default();
    params.roughness = 0;
    params.double_sided = true;
    return params;
}

static fnl_material_params bare(void) {
    fnl_material_params params = fnl_material_params_default();
    params.unlit = params.double_sided = true;
    return params;
}

/* A rectangle of 4 vertices; `colors`: 4 each, or NULL. */
static void add_quad(fnl_scene *scene, fnl_material_id material, const float *positions, const float *colors, const mat4 *placed) {
    static const uint32_t indices[] = {0, 1, 2, 0, 2, 3};
    const fnl_mesh_params mesh = {.vertex_count = 4, .index_count = 6, .positions = positions, .colors = colors, .indices = indices, .material = material};
    fnl_mesh_id id;
    fnl_instance_id instance;
    assert_int_equal(fnl_scene_add_mesh(scene, &mesh, &id), FNL_OK);
    assert_int_equal(fnl_scene_add_instance(scene, id, placed, &instance), FNL_OK);
}

/* Six walls that shine as they are coloured: by where they are in the room, -HALF .. HALF as 0 .. 1, or all in 1. */
static void add_room(fnl_scene *scene, bool even, const mat4 *placed) {
    const fnl_material_id material = add_material(scene, bare());
    for (int wall = 0; wall < 6; wall++) {
        float positions[12], colors[16];
        for (int i = 0; i < 4; i++) {
            vec3 p = {0};
            (&p.x)[wall / 2] = wall % 2 ? 1 : -1;
            (&p.x)[(wall / 2 + 1) % 3] = i == 1 || i == 2 ? 1 : -1;
            (&p.x)[(wall / 2 + 2) % 3] = i < 2 ? -1 : 1;
            for (int c = 0; c < 3; c++) {
                positions[3 * i + c] = (&p.x)[c] * (&HALF.x)[c];
                colors[4 * i + c] = even ? 1 : (&p.x)[c] * 0.5f + 0.5f;
            }
            colors[4 * i + 3] = 1;
        }
        add_quad(scene, material, positions, colors, placed);
    }
}

static void add_floor(fnl_scene *scene, fnl_material_id material, const mat4 *placed) {
    const float x = HALF.x, y = -HALF.y + 0.01f, z = HALF.z, positions[12] = {-x, y, -z, -x, y, z, x, y, z, x, y, -z};
    add_quad(scene, material, positions, NULL, placed);
}

static fnl_probe_params probe_of_room(void) {
    fnl_probe_params params = fnl_probe_params_default();
    params.half_size = HALF;
    params.face_size = SIDE;
    params.reflection = true;
    return params;
}

static fnl_probe_id add_probe(fnl_scene *scene, const fnl_probe_params *params) {
    fnl_probe_id id;
    assert_int_equal(fnl_scene_add_probe(scene, params, &id), FNL_OK);
    return id;
}

static struct stage look(fnl_scene *scene, vec3 from, vec3 to) {
    struct stage s = stage_open_scene(scene);
    s.frame.width = 64, s.frame.height = 48;
    s.frame.outputs = FNL_OUTPUT_RADIANCE | FNL_OUTPUT_NORMAL | FNL_OUTPUT_POSITION | FNL_OUTPUT_SURFACE;
    s.frame.shading = FNL_SHADING_FORWARD;
    s.frame.lists = FNL_LISTS_CLUSTERED; /* as captures have */
    s.frame.camera = fnl_camera_default();
    s.frame.camera.position = from;
    s.frame.camera.target = to;
    s.frame.camera.vertical_fov = 1.3f;
    return s;
}

static const float *at(const fnl_image *image, uint32_t i) { return (const float *)image->pixels + 4 * (size_t)i; }

static bool shows_mirror(const struct shot *shot, uint32_t i) { return at(&shot->normal, i)[3] > 0 && at(&shot->surface, i)[3] < 0.001f; }

/* Root of the squared differences over that of the squares. */
static double relative_error(const fnl_image *a, const fnl_image *b) {
    double error = 0, sum = 0;
    for (uint32_t i = 0; i < a->width * a->height; i++)
        for (int c = 0; c < 3; c++) {
            const double x = (double)at(a, i)[c], y = (double)at(b, i)[c];
            error += (x - y) * (x - y);
            sum += y * y;
        }
    return sqrt(error / sum);
}

/* ---- parallax ---- */

/* How far from where walls are mirrors show them, at most: in texels of the cube as wide as they are on the wall there. */
static double farthest_off(const struct shot *shot, vec3 eye, vec3 capture, const mat4 *placed) {
    double worst = 0;
    uint32_t seen = 0;
    for (uint32_t i = 0; i < shot->radiance.width * shot->radiance.height; i++) {
        if (!shows_mirror(shot, i)) continue;
        const float *n = at(&shot->normal, i), *p = at(&shot->position, i);
        const vec3 normal = {n[0], n[1], n[2]}, position = {p[0], p[1], p[2]}, along = vec3_normalize(vec3_sub(position, eye));
        const vec3 ray = vec3_sub(along, vec3_scale(normal, 2 * vec3_dot(along, normal)));
        double way = 1e30, start[3], step[3];
        for (int k = 0; k < 3; k++) { /* in the axes of the room */
            const vec3 axis = {placed->m[4 * k], placed->m[4 * k + 1], placed->m[4 * k + 2]};
            start[k] = (double)vec3_dot(axis, vec3_sub(position, vec3_make(placed->m[12], placed->m[13], placed->m[14])));
            step[k] = (double)vec3_dot(axis, ray);
            if (fabs(step[k]) > 1e-9) way = fmin(way, ((step[k] > 0 ? 1 : -1) * (double)(&HALF.x)[k] - start[k]) / step[k]);
        }
        double off = 0;
        if (start[1] + way * step[1] < -(double)HALF.y + 0.15) continue; /* there the probe sees the mirror, which is black, in part of a texel */
        for (int k = 0; k < 3; k++) {
            const double shown = ((double)at(&shot->radiance, i)[k] * 2 - 1) * (double)(&HALF.x)[k], is = start[k] + way * step[k];
            off += (shown - is) * (shown - is);
        }
        const vec3 met = mat4_point(placed, vec3_make((float)(start[0] + way * step[0]), (float)(start[1] + way * step[1]), (float)(start[2] + way * step[2])));
        const vec3 from = vec3_sub(met, capture);
        worst = fmax(worst, sqrt(off) / (2.0 / SIDE * (double)fmaxf(fabsf(from.x), fmaxf(fabsf(from.y), fabsf(from.z)))));
        seen++;
    }
    assert_true(seen > 500);
    return worst;
}

/*
 * A mirror on the floor of a room whose walls say where they are. The room is turned, and seen from beside its middle. Without the correction, and
 * with a box that is not the room's, mirrors show other places.
 */
static void test_mirrors_show_walls_within_a_texel_EN_20_MP_11(void **state) {
    UNUSED(state);
    const mat4 placed = mat4_from_trs(vec3_make(5, 1, -2), quat_axis_angle(vec3_make(0, 1, 0), 0.6f), vec3_make(1, 1, 1));
    fnl_scene *scene = coarse_scene();
    add_room(scene, false, &placed);
    add_floor(scene, add_material(scene, mirror()), &placed);
    fnl_probe_params params = probe_of_room();
    params.centre = vec3_make(5, 1, -2);
    params.rotation = quat_axis_angle(vec3_make(0, 1, 0), 0.6f);
    params.capture = vec3_make(0.3f, 0.2f, -0.4f);
    const fnl_probe_id probe = add_probe(scene, &params);
    const vec3 eye = mat4_point(&placed, vec3_make(1, 0.5f, 2.2f));
    struct stage s = look(scene, eye, mat4_point(&placed, vec3_make(-0.5f, -1.5f, -0.5f)));
    double off[3];
    for (int i = 0; i < 3; i++) {
        s.frame.reflections.parallax = i != 1;
        if (i == 2) params.half_size.x *= 1.3f, assert_int_equal(fnl_scene_set_probe(scene, probe, &params), FNL_OK);
        struct shot shot = stage_shoot(&s, &s.frame);
        off[i] = farthest_off(&shot, eye, mat4_point(&placed, params.capture), &placed);
        shot_free(&shot);
    }
    print_message("%.2f texels off; without parallax %.1f, with another box %.1f\n", off[0], off[1], off[2]);
    assert_true(off[0] < 1 && off[1] > 10 && off[2] > 4);
    stage_close(&s);
}

/* ---- energy ---- */

/* In a room that is 1 everywhere a ball is 1 as well, as far as it mirrors all or scatters all; the sky outside, which is black, is not seen. */
static void test_a_white_room_is_a_furnace_EN_21_MP_12(void **state) {
    UNUSED(state);
    const mat4 here = mat4_identity();
    double worst[3] = {0};
    for (int i = 0; i < 3; i++) {
        fnl_scene *scene = coarse_scene();
        fnl_material_params params = fnl_material_params_default();
        params.metallic = i == 0;
        params.roughness = i == 0 ? 0.5f : 0.8f;
        if (i == 2) params.clearcoat = (fnl_clearcoat_params){.strength = 1, .roughness = 0.2f};
        add_room(scene, true, &here);
        coarse_add_sphere(scene, add_material(scene, params), 0.8f); /* its inside, where the probe is, has no surface */
        const fnl_probe_params probe = probe_of_room();
        add_probe(scene, &probe);
        assert_int_equal(fnl_scene_set_ambient(scene, (fnl_vec3){0}, (fnl_vec3){0}), FNL_OK);
        struct stage s = look(scene, vec3_make(0, 0, 2.5f), vec3_make(0, 0, 0));
        s.frame.energy = FNL_ENERGY_CONSERVING;
        struct shot shot = stage_shoot(&s, &s.frame);
        for (uint32_t k = 0; k < 64 * 48; k++)
            for (int c = 0; c < 3; c++) worst[i] = fmax(worst[i], fabs((double)at(&shot.radiance, k)[c] - 1));
        shot_free(&shot);
        stage_close(&s);
    }
    print_message("metal %.5f, dielectric %.5f, varnish %.5f off\n", worst[0], worst[1], worst[2]);
    assert_true(worst[0] < 0.002 && worst[1] < 0.002 && worst[2] < 0.02);
}

/* A panorama of what is seen from the middle of the room. */
static void surround_by_room(fnl_scene *scene) {
    enum { WIDTH = 256, HEIGHT = 128 };
    static float pixels[WIDTH * HEIGHT * 4];
    for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) {
        const float longitude = ((float)(i % WIDTH) + 0.5f) / WIDTH * 2 * PI - PI, latitude = ((float)(i / WIDTH) + 0.5f) / HEIGHT * PI;
        const vec3 d = vec3_make(sinf(latitude) * cosf(longitude), cosf(latitude), sinf(latitude) * sinf(longitude));
        float way = 1e30f;
        for (int k = 0; k < 3; k++) way = fminf(way, (&HALF.x)[k] / fmaxf(fabsf((&d.x)[k]), 1e-6f));
        for (int k = 0; k < 3; k++) pixels[4 * i + (uint32_t)k] = (&d.x)[k] * way / (&HALF.x)[k] * 0.5f + 0.5f;
        pixels[4 * i + 3] = 1;
    }
    fnl_image image = {WIDTH, HEIGHT, FNL_PIXEL_FORMAT_RGBA32F, pixels};
    fnl_environment_params params = fnl_environment_params_default();
    params.image = &image;
    params.lights = false;
    assert_int_equal(fnl_scene_set_environment(scene, &params), FNL_OK);
}

/* A ball in an environment that is a picture of the room is as one in the room, by a probe without parallax: lobes, mips of another size, diffuse light. */
static void test_probes_are_filtered_as_environments_EN_21_MP_12(void **state) {
    UNUSED(state);
    const mat4 here = mat4_identity();
    for (int kind = 0; kind < 3; kind++) {
        struct shot shots[2];
        for (int i = 0; i < 2; i++) {
            fnl_scene *scene = coarse_scene();
            fnl_material_params params = fnl_material_params_default();
            params.metallic = kind < 2;
            params.roughness = kind == 0 ? 0.15f : kind == 1 ? 0.4f : 0.8f;
            if (i == 0) surround_by_room(scene);
            else add_room(scene, false, &here);
            coarse_add_sphere(scene, add_material(scene, params), 0.8f);
            const fnl_probe_params probe = probe_of_room();
            if (i == 1) add_probe(scene, &probe);
            struct stage s = look(scene, vec3_make(1.4f, 0.2f, 2.1f), vec3_make(0, 0, 0));
            s.frame.camera.vertical_fov = 0.4f; /* nothing but the ball */
            s.frame.reflections.parallax = false;
            shots[i] = stage_shoot(&s, &s.frame);
            stage_close(&s);
        }
        const double off = relative_error(&shots[1].radiance, &shots[0].radiance);
        print_message("kind %d: %.4f off\n", kind, off);
        assert_true(off < 0.02);
        for (int i = 0; i < 2; i++) shot_free(&shots[i]);
    }
}

/* ---- masks ---- */

/* A ball in a room, by a probe: with which mask, and far away or not; the mask of all instances. */
static struct shot shoot_ball(uint32_t probe_mask, bool away, uint32_t instance_mask, fnl_shading shading) {
    fnl_scene *scene = coarse_scene();
    const mat4 here = mat4_identity();
    fnl_material_params params = fnl_material_params_default();
    params.metallic = 1;
    params.roughness = 0.2f;
    add_room(scene, false, &here);
    coarse_add_sphere(scene, add_material(scene, params), 0.8f);
    fnl_probe_params probe = probe_of_room();
    probe.mask = probe_mask;
    if (away) probe.centre.x = 1000;
    add_probe(scene, &probe);
    for (uint32_t i = 0; i < fnl_scene_count(scene, FNL_ENTITY_INSTANCE); i++) {
        fnl_entity_info info;
        assert_int_equal(fnl_scene_query_entity(scene, FNL_ENTITY_INSTANCE, i, &info), FNL_OK);
        assert_int_equal(fnl_scene_set_instance_light_mask(scene, info.id.instance, instance_mask), FNL_OK);
    }
    struct stage s = look(scene, vec3_make(1.4f, 0.2f, 2.1f), vec3_make(0, 0, 0));
    s.frame.shading = shading;
    struct shot shot = stage_shoot(&s, &s.frame);
    stage_close(&s);
    return shot;
}

/* Instances that share no bit with a probe look as if it were elsewhere, others as ever; a G-buffer does not know instances. */
static void test_probes_heed_masks(void **state) {
    UNUSED(state);
    static const fnl_shading shadings[] = {FNL_SHADING_FORWARD, FNL_SHADING_DEFERRED};
    for (uint32_t i = 0; i < COUNT_OF(shadings); i++) {
        struct shot served = shoot_ball(255, false, 255, FNL_SHADING_FORWARD), met = shoot_ball(2, false, 6, shadings[i]),
                    elsewhere = shoot_ball(255, true, 255, FNL_SHADING_FORWARD), missed = shoot_ball(2, false, 1, shadings[i]);
        assert_true(count_differing(&served.radiance, &elsewhere.radiance) > 100);
        /* Shaders with masks may round their sums in another way. */
        const double met_off = relative_error(&met.radiance, &served.radiance), missed_off = relative_error(&missed.radiance, &elsewhere.radiance);
        if (!(met_off < 1e-5) || !(missed_off < 1e-5)) fail_msg("shading %u: %g and %g off", i, met_off, missed_off);
        shot_free(&served), shot_free(&met), shot_free(&elsewhere), shot_free(&missed);
    }
}

/* ---- several ---- */

enum { PROBES = 3 };

static float clamped(float x) { return fminf(fmaxf(x, 0), 1); }

/* What a mirror at x shows in a room that is 1 everywhere: probes of one priority share what is left by their weights, in turn. */
static double blended(const fnl_probe_params *probes, float x, double ambient) {
    double sum = 0, left = 1;
    for (int priority = 2; priority >= 0; priority--) {
        double light = 0, weights = 0;
        for (int i = 0; i < PROBES; i++) {
            if (probes[i].priority != priority) continue;
            const double weight = (double)clamped((probes[i].half_size.x + probes[i].wall - fabsf(x - probes[i].centre.x)) / probes[i].blend);
            light += weight * (double)probes[i].intensity;
            weights += weight;
        }
        if (weights <= 0) continue;
        const double share = fmin(weights, 1);
        sum += left * light * share / weights;
        left *= 1 - share;
    }
    return sum + left * ambient;
}

/*
 * Probes that overlap, each of which shows another number, and none at one side: weights, ranks, what is left, by a list and without one. In all pixels
 * what the formula says, so weights sum to 1 and nothing jumps.
 */
static void test_probes_blend_by_distance_and_priority_EN_22(void **state) {
    UNUSED(state);
    const mat4 here = mat4_identity();
    fnl_scene *scene = coarse_scene();
    add_room(scene, true, &here);
    fnl_material_params one_sided = mirror();
    one_sided.double_sided = false;
    add_floor(scene, add_material(scene, one_sided), &here); /* probes see from below, where it is not; there is 1, too */
    assert_int_equal(fnl_scene_set_background(scene, (fnl_vec3){1, 1, 1}), FNL_OK);
    assert_int_equal(fnl_scene_set_ambient(scene, (fnl_vec3){5, 5, 5}, (fnl_vec3){5, 5, 5}), FNL_OK);
    fnl_probe_params probes[PROBES];
    fnl_probe_id ids[PROBES];
    const float centres[PROBES] = {-1.2f, 0, 0.9f}, halves[PROBES] = {0.9f, 0.8f, 0.6f}, blends[PROBES] = {0.5f, 0.6f, 0.3f}, intensities[PROBES] = {1, 2, 4};
    for (int i = 0; i < PROBES; i++) {
        probes[i] = probe_of_room();
        probes[i].centre.x = centres[i];
        probes[i].half_size = vec3_make(halves[i], 3, 5);
        probes[i].capture = vec3_make(-centres[i] * 0.4f, -2, 0);
        probes[i].face_size = 16;
        probes[i].blend = blends[i];
        probes[i].intensity = intensities[i];
        probes[i].wall = 0.02f;
        ids[i] = add_probe(scene, &probes[i]);
    }
    struct stage s = look(scene, vec3_make(0, 1.4f, 0.1f), vec3_make(0, -1.5f, 0));
    struct shot few = {0};
    for (int i = 0; i < 3; i++) {
        if (i == 1) probes[2].priority = 2, assert_int_equal(fnl_scene_set_probe(scene, ids[2], &probes[2]), FNL_OK);
        if (i == 2) /* a list; these reach nothing that is seen */
            for (int k = 0; k < 3; k++) {
                fnl_probe_params more = probes[0];
                more.centre = vec3_make(-40, 0, (float)k * 3);
                more.intensity = 100;
                add_probe(scene, &more);
            }
        struct shot shot = stage_shoot(&s, &s.frame);
        assert_int_equal(counter(&shot.stats, "reflections.probes"), i == 2 ? 6 : 3);
        assert_int_equal(counter(&shot.stats, "reflections.captures"), i == 0 ? 3 : i == 1 ? 1 : 3);
        assert_true(has_counter(&shot.stats, "reflections.entries") == (i == 2));
        double worst = 0, least = 10, most = 0;
        for (uint32_t k = 0; k < 64 * 48; k++) {
            if (!shows_mirror(&shot, k)) continue;
            const double want = blended(probes, at(&shot.position, k)[0], 5), is = (double)at(&shot.radiance, k)[0];
            worst = fmax(worst, fabs(is - want) / want);
            least = fmin(least, is), most = fmax(most, is);
        }
        print_message("%.5f off; %.2f to %.2f\n", worst, least, most);
        assert_true(worst < 0.004 && least < 1.1 && most > 4.5);
        if (i == 2) {
            assert_true(counter(&shot.stats, "reflections.entries") > 0);
            assert_int_equal(count_differing(&few.radiance, &shot.radiance), 0);
        }
        if (i == 1) few = shot;
        else shot_free(&shot);
    }
    shot_free(&few);
    stage_close(&s);
}

/* ---- orders ---- */

/* A ball, a floor, and a pane of glass that mirrors, in a room; in every order as in forward. Without the probe it is another picture. */
static void test_every_order_has_the_same_reflections_EN_23(void **state) {
    UNUSED(state);
    const mat4 here = mat4_identity();
    fnl_scene *scene = coarse_scene();
    fnl_material_params metal = mirror(), paint = fnl_material_params_default(), glass = mirror();
    metal.roughness = 0.3f;
    metal.double_sided = false; /* the probe is inside */
    paint.metallic = 0;
    paint.double_sided = true;
    glass.base_color[3] = 0.5f;
    glass.alpha_mode = FNL_ALPHA_BLEND;
    add_room(scene, false, &here);
    add_floor(scene, add_material(scene, paint), &here);
    coarse_add_sphere(scene, add_material(scene, metal), 0.8f);
    const float pane[12] = {-1.5f, -1, 1.2f, -0.1f, -1, 1.2f, -0.1f, 1, 1.2f, -1.5f, 1, 1.2f};
    add_quad(scene, add_material(scene, glass), pane, NULL, &here);
    const fnl_probe_params params = probe_of_room();
    add_probe(scene, &params);
    struct stage s = look(scene, vec3_make(0, 0.4f, 2.8f), vec3_make(0, -0.2f, 0));
    s.frame.width = 49, s.frame.height = 33;
    s.frame.outputs = FNL_OUTPUT_RADIANCE;
    struct shot want = stage_shoot(&s, &s.frame);
    s.frame.reflections.parallax = false;
    struct shot other = stage_shoot(&s, &s.frame);
    print_message("without parallax: %.4f off\n", relative_error(&other.radiance, &want.radiance));
    assert_true(relative_error(&other.radiance, &want.radiance) > 0.01);
    const float *mirrored = at(&want.radiance, 16 * 49 + 15), *unlike = at(&other.radiance, 16 * 49 + 15); /* on the pane */
    assert_true(fabsf(mirrored[0] - unlike[0]) + fabsf(mirrored[1] - unlike[1]) + fabsf(mirrored[2] - unlike[2]) > 0.02f);
    s.frame.reflections.parallax = true;
    for (int shading = 0; shading < FNL_SHADING_AUTO; shading++) {
        s.frame.shading = (fnl_shading)shading;
        s.frame.lists = FNL_LISTS_AUTO;
        if (shading == FNL_SHADING_FORWARD || shading == FNL_SHADING_VIRTUAL_TEXTURING) continue; /* has the shaders of texturing */
        if (shading == FNL_SHADING_LOW_RES || shading == FNL_SHADING_INFERRED) continue;          /* light fewer pixels */
        struct shot shot = stage_shoot(&s, &s.frame);
        const double off = relative_error(&shot.radiance, &want.radiance);
        print_message("%s: %.4f off\n", fnl_value_name(FNL_ENUM_SHADING, s.frame.shading), off);
        assert_true(off < (shading_is(s.frame.shading, SHADING_APPROXIMATE) ? 0.01 : 0.002));
        shot_free(&shot);
    }
    s.frame.shading = FNL_SHADING_FORWARD_PREPASS;
    for (int i = 0; i < 2; i++) { /* shaders of their own */
        s.frame.lists = i ? FNL_LISTS_MULTIPASS : FNL_LISTS_BATCHES;
        struct shot shot = stage_shoot(&s, &s.frame);
        assert_true(relative_error(&shot.radiance, &want.radiance) < 0.002);
        shot_free(&shot);
    }
    shot_free(&other);
    shot_free(&want);
    stage_close(&s);
}

/* ---- what it costs ---- */

/* Captures when a probe is new, or set again, or refreshed; nothing else. Without one: no counter, and the bytes of a scene that never had one. */
static void test_captures_are_counted_EN_24(void **state) {
    UNUSED(state);
    const mat4 here = mat4_identity();
    fnl_scene *scene = coarse_scene();
    add_room(scene, false, &here);
    add_floor(scene, add_material(scene, mirror()), &here);
    struct stage s = look(scene, vec3_make(1, 0.5f, 2), vec3_make(0, -1.5f, 0));
    struct shot plain = stage_shoot(&s, &s.frame), last = {0};
    assert_false(has_counter(&plain.stats, "reflections.captures"));
    fnl_probe_params params = probe_of_room();
    params.face_size = 40; /* 32 */
    params.reflection = false;
    fnl_probe_id ids[2] = {add_probe(scene, &params)};
    struct shot without = stage_shoot(&s, &s.frame);
    assert_false(has_counter(&without.stats, "reflections.captures"));
    assert_int_equal(count_differing(&plain.radiance, &without.radiance), 0);
    params.reflection = true;
    const uint64_t captures[] = {1, 0, 1, 0, 1, 1, 2, 1, 1, 0, 0};
    for (uint32_t i = 0; i < COUNT_OF(captures); i++) {
        if (i == 0 || i == 2) assert_int_equal(fnl_scene_set_probe(scene, ids[0], &params), FNL_OK); /* the same, too */
        if (i == 0) assert_int_equal(fnl_renderer_warm(s.renderer, &s.frame, NULL, true, NULL), FNL_OK); /* captures nothing, and fills no table */
        if (i == 4) ids[1] = add_probe(scene, &params);
        if (i == 5) s.frame.reflections.refresh = 1;
        if (i == 6) s.frame.reflections.refresh = 5;
        if (i == 7) s.frame.reflections.refresh = 1;
        if (i == 9) s.frame.reflections.refresh = 0;
        if (i == 10) assert_int_equal(fnl_scene_set_background(scene, (fnl_vec3){1, 2, 3}), FNL_OK);
        struct shot shot = stage_shoot(&s, &s.frame);
        assert_int_equal(counter(&shot.stats, "reflections.captures"), captures[i]);
        static char plan[1 << 16];
        assert_true(graph_print(s.renderer->graph, plan, sizeof plan) < sizeof plan);
        assert_int_equal(strstr(plan, "reflections light") != NULL, captures[i] > 0); /* their diffuse light is gathered once */
        assert_int_equal(counter(&shot.stats, "reflections.faces"), 6 * captures[i]);
        assert_int_equal(counter(&shot.stats, "reflections.bytes"), (i < 4 ? 1 : 2) * (6 * 8 * (32 * 32 + 16 * 16 + 8 * 8) + sizeof(struct gpu_environment)));
        assert_true(count_differing(&plain.radiance, &shot.radiance) > 500 && at(&shot.radiance, 24 * 64 + 32)[0] > 0.1f);
        if (i == 1 || i == 3) assert_int_equal(count_differing(&last.radiance, &shot.radiance), 0);
        if (i > 0) shot_free(&last);
        last = shot;
    }
    fnl_probe_params bad[3] = {params, params, params};
    bad[0].blend = -0.1f, bad[1].intensity = NAN, bad[2].intensity = -1;
    for (int i = 0; i < 3; i++) assert_int_equal(fnl_scene_set_probe(scene, ids[0], &bad[i]), FNL_ERROR_INVALID);
    assert_int_equal(fnl_scene_remove_probe(scene, ids[0]), FNL_OK);
    assert_int_equal(fnl_scene_remove_probe(scene, ids[1]), FNL_OK);
    struct shot after = stage_shoot(&s, &s.frame);
    assert_int_equal(count_differing(&plain.radiance, &after.radiance), 0);
    shot_free(&after);
    shot_free(&last);
    shot_free(&without);
    shot_free(&plain);
    stage_close(&s);
}

/* One capture a frame goes round: what changes in all rooms is seen in the mirror of the one whose turn it is, and no other. */
static void test_refreshed_probes_take_turns_EN_24(void **state) {
    UNUSED(state);
    enum { ROOMS = 3 };
    fnl_scene *scene = coarse_scene();
    fnl_material_params walls = bare();
    const fnl_material_id wall = add_material(scene, walls), floor = add_material(scene, mirror());
    for (uint32_t i = 0; i < ROOMS; i++) { /* a wall behind a mirror on the floor */
        const mat4 here = mat4_translation(vec3_make(10 * (float)i, 0, 0));
        const float positions[12] = {-2, -1.5f, -3, 2, -1.5f, -3, 2, 1.5f, -3, -2, 1.5f, -3};
        fnl_probe_params params = probe_of_room();
        params.centre = vec3_make(10 * (float)i, 0, 0);
        params.face_size = 16;
        add_quad(scene, wall, positions, NULL, &here);
        add_floor(scene, floor, &here);
        add_probe(scene, &params);
    }
    struct stage s = look(scene, vec3_make(0, 0.5f, 2), vec3_make(0, -1.5f, -1));
    float value = 1, shown[ROOMS] = {1, 1, 1}; /* by the last capture of each room */
    for (uint32_t frame = 0; frame <= 2 * ROOMS; frame++) { /* the first captures all */
        if (frame > 0) {
            value *= 0.75f;
            for (int c = 0; c < 3; c++) walls.base_color[c] = value;
            assert_int_equal(fnl_scene_set_material(scene, wall, &walls), FNL_OK);
            shown[(frame - 1) % ROOMS] = value;
        }
        for (uint32_t i = 0; i < ROOMS; i++) {
            s.frame.reflections.refresh = frame > 0 && i == 0; /* then the others are looked at */
            s.frame.camera.position.x = s.frame.camera.target.x = 10 * (float)i;
            struct shot shot = stage_shoot(&s, &s.frame);
            assert_int_equal(counter(&shot.stats, "reflections.captures"), i > 0 ? 0 : frame == 0 ? ROOMS : 1);
            const float seen = at(&shot.radiance, 24 * 64 + 32)[0];
            if (fabsf(seen - shown[i]) > 0.01f * shown[i]) fail_msg("frame %u, room %u: %g in the mirror, should be %g", frame, i, (double)seen, (double)shown[i]);
            shot_free(&shot);
        }
    }
    stage_close(&s);
}

/* A mirror that is captured shows black in the first capture, and in the second what it mirrors. */
static void test_bounces_show_mirrors_in_mirrors_EN_25(void **state) {
    UNUSED(state);
    const mat4 here = mat4_identity();
    float seen[2];
    for (uint32_t i = 0; i < 2; i++) {
        fnl_scene *scene = coarse_scene();
        add_room(scene, true, &here);
        add_floor(scene, add_material(scene, mirror()), &here);
        const float x = HALF.x - 0.02f, y = HALF.y, z = HALF.z, wall[12] = {x, -y, -z, x, y, -z, x, y, z, x, -y, z};
        add_quad(scene, add_material(scene, mirror()), wall, NULL, &here);
        const fnl_probe_params params = probe_of_room();
        add_probe(scene, &params);
        struct stage s = look(scene, vec3_make(-1.5f, 0.5f, 0), vec3_make(0.2f, -1.5f, 0.1f));
        s.frame.reflections.bounces = i + 1;
        struct shot shot = stage_shoot(&s, &s.frame);
        assert_int_equal(counter(&shot.stats, "reflections.captures"), i + 1);
        seen[i] = at(&shot.radiance, 24 * 64 + 32)[0]; /* the floor, which mirrors the wall, which mirrors the room */
        shot_free(&shot);
        stage_close(&s);
    }
    print_message("1 bounce %.3f, 2 bounces %.3f\n", (double)seen[0], (double)seen[1]);
    assert_true(seen[0] < 0.01f && fabsf(seen[1] - 1) < 0.01f);
}

/* Diffuse light stays with its probe when others, which come first, are added and go: not a bit changes, and another one's light is another. */
static void test_diffuse_light_stays_with_its_probe_EN_25(void **state) {
    UNUSED(state);
    const mat4 rooms[2] = {mat4_identity(), mat4_translation(vec3_make(20, 0, 0))};
    fnl_scene *scene = coarse_scene();
    fnl_material_params paint = fnl_material_params_default();
    paint.metallic = 0;
    for (int i = 0; i < 2; i++) add_room(scene, i == 1, &rooms[i]);
    coarse_add_sphere(scene, add_material(scene, paint), 0.8f);
    fnl_probe_params params = probe_of_room();
    params.face_size = 32;
    fnl_probe_id ids[3];
    for (int i = 0; i < 2; i++) {
        params.centre.x = 20 * (float)i;
        ids[i] = add_probe(scene, &params);
    }
    struct stage s = look(scene, vec3_make(0, 0, 2.5f), vec3_make(0, 0, 0));
    struct shot want = {0};
    for (int i = 0; i < 3; i++) {
        params.centre.x = 40;
        params.priority = 3;
        if (i == 1) ids[2] = add_probe(scene, &params);
        if (i == 2) assert_int_equal(fnl_scene_remove_probe(scene, ids[2]), FNL_OK);
        struct shot shot = stage_shoot(&s, &s.frame);
        assert_int_equal(counter(&shot.stats, "reflections.captures"), 2 - i);
        if (i > 0) assert_int_equal(count_differing(&want.radiance, &shot.radiance), 0);
        if (i == 0) want = shot;
        else shot_free(&shot);
    }
    /* The side to +X is redder than the other: it faces that wall, whose red is 1. */
    const float right = at(&want.radiance, 24 * 64 + 40)[0], left = at(&want.radiance, 24 * 64 + 24)[0];
    assert_true(left < 0.45f && right > 0.55f);
    shot_free(&want);
    stage_close(&s);
}

/* Views of one frame have lists of their own: each is as a frame of that camera alone, to the bit. */
static void test_views_look_up_their_own_lists_EN_22(void **state) {
    UNUSED(state);
    const mat4 here = mat4_identity();
    fnl_scene *scene = coarse_scene();
    add_room(scene, false, &here);
    add_floor(scene, add_material(scene, mirror()), &here);
    for (int i = 0; i < 6; i++) {
        fnl_probe_params params = probe_of_room();
        params.centre.x = -2 + 0.8f * (float)i;
        params.half_size.x = 0.5f;
        params.face_size = 16;
        params.blend = 0.3f;
        add_probe(scene, &params);
    }
    struct stage s = look(scene, vec3_make(1, 0.5f, 2), vec3_make(0, -1.5f, 0));
    fnl_camera cameras[2] = {s.frame.camera, s.frame.camera};
    cameras[1].position = vec3_make(-1.5f, 0.2f, -2);
    s.frame.outputs = FNL_OUTPUT_RADIANCE;
    struct shot each[2];
    for (int i = 0; i < 2; i++) {
        s.frame.camera = cameras[i];
        each[i] = stage_shoot(&s, &s.frame);
    }
    s.frame.views = cameras;
    s.frame.view_count = 2;
    struct shot both = stage_shoot(&s, &s.frame); /* one below the other */
    const size_t bytes = (size_t)64 * 48 * 16;
    for (uint32_t i = 0; i < 2; i++) {
        assert_memory_equal(each[i].radiance.pixels, (const char *)both.radiance.pixels + i * bytes, bytes);
        shot_free(&each[i]);
    }
    shot_free(&both);
    stage_close(&s);
}

static uint32_t passes_named(const struct stage *s, const char *name) {
    static char text[1 << 18];
    uint32_t count = 0;
    assert_true(fnl_renderer_print(s->renderer, FNL_PRINT_PLAN, text, sizeof text) < sizeof text);
    for (const char *at = text; (at = strstr(at, name)); at++) count++;
    return count;
}

/* Eyes that share a light list still look up their own lists of probes. */
static void test_eyes_that_share_lights_have_their_own_probes_EN_22(void **state) {
    UNUSED(state);
    struct stage s = stage_open("builtin:hall", 0);
    fnl_camera eyes[2] = {s.frame.camera, s.frame.camera};
    eyes[1].position.x += 0.3f, eyes[1].target.x += 0.3f;
    fnl_frame frame = s.frame;
    frame.width = 64, frame.height = 48;
    frame.shading = FNL_SHADING_DEFERRED;
    frame.lists = FNL_LISTS_CLUSTERED;
    frame.views = eyes;
    frame.view_count = frame.stereo.eyes = 2;
    frame.outputs = FNL_OUTPUT_RADIANCE;
    frame.stereo.lists = FNL_STEREO_LISTS_EYE;
    struct shot without = stage_shoot(&s, &frame);
    for (int i = 0; i < 6; i++) {
        fnl_probe_params params = probe_of_room();
        params.centre = vec3_add(eyes[0].position, vec3_make(0.8f * (float)i - 2, 0, 0));
        params.face_size = 16;
        params.blend = 0.3f;
        add_probe(s.scene, &params);
    }
    struct shot apart = stage_shoot(&s, &frame);
    const uint32_t of_each = passes_named(&s, "lights gather");
    frame.stereo.lists = FNL_STEREO_LISTS_HEAD;
    struct shot shared = stage_shoot(&s, &frame);
    print_message("%u lists, %u when shared\n", of_each, passes_named(&s, "lights gather"));
    assert_int_equal(passes_named(&s, "lights gather") + 1, of_each);
    assert_true(count_differing(&without.radiance, &apart.radiance) > 1000);
    assert_int_equal(count_differing(&shared.radiance, &apart.radiance), 0);
    shot_free(&without);
    shot_free(&shared);
    shot_free(&apart);
    stage_close(&s);
}

/* Cube maps are compressed where the environment is, and the picture stays close. */
static void test_compressed_probes_BC_14(void **state) {
    UNUSED(state);
    const bool able = gpu_info(harness_device())->texture_compression;
    const mat4 here = mat4_identity();
    fnl_scene *scene = coarse_scene();
    add_room(scene, false, &here);
    add_floor(scene, add_material(scene, mirror()), &here);
    const fnl_probe_params params = probe_of_room();
    const fnl_probe_id probe = add_probe(scene, &params);
    float pixels[16 * 8 * 4] = {0};
    fnl_image image = {16, 8, FNL_PIXEL_FORMAT_RGBA32F, pixels};
    fnl_environment_params environment = fnl_environment_params_default();
    environment.image = &image;
    struct stage s = look(scene, vec3_make(1, 0.5f, 2), vec3_make(0, -1.5f, 0));
    struct shot shots[2];
    for (int i = 0; i < 2; i++) {
        environment.compressed = i;
        assert_int_equal(fnl_scene_set_environment(scene, &environment), FNL_OK);
        assert_int_equal(fnl_scene_set_probe(scene, probe, &params), FNL_OK);
        shots[i] = stage_shoot(&s, &s.frame);
        const VkFormat format = s.renderer->reflections.list.data[0].maps.cube.params.format;
        assert_int_equal(format, i && able ? VK_FORMAT_BC6H_UFLOAT_BLOCK : VK_FORMAT_R16G16B16A16_SFLOAT);
    }
    const double off = relative_error(&shots[1].radiance, &shots[0].radiance);
    print_message("compressed: %.4f off\n", off);
    assert_true(off < 0.02 && (off > 0) == able);
    for (int i = 0; i < 2; i++) shot_free(&shots[i]);
    stage_close(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_mirrors_show_walls_within_a_texel_EN_20_MP_11, harness_check),
        cmocka_unit_test_teardown(test_a_white_room_is_a_furnace_EN_21_MP_12, harness_check),
        cmocka_unit_test_teardown(test_probes_are_filtered_as_environments_EN_21_MP_12, harness_check),
        cmocka_unit_test_teardown(test_probes_blend_by_distance_and_priority_EN_22, harness_check),
        cmocka_unit_test_teardown(test_views_look_up_their_own_lists_EN_22, harness_check),
        cmocka_unit_test_teardown(test_probes_heed_masks, harness_check),
        cmocka_unit_test_teardown(test_every_order_has_the_same_reflections_EN_23, harness_check),
        cmocka_unit_test_teardown(test_captures_are_counted_EN_24, harness_check),
        cmocka_unit_test_teardown(test_refreshed_probes_take_turns_EN_24, harness_check),
        cmocka_unit_test_teardown(test_bounces_show_mirrors_in_mirrors_EN_25, harness_check),
        cmocka_unit_test_teardown(test_diffuse_light_stays_with_its_probe_EN_25, harness_check),
        cmocka_unit_test_teardown(test_eyes_that_share_lights_have_their_own_probes_EN_22, harness_check),
        cmocka_unit_test_teardown(test_compressed_probes_BC_14, harness_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
