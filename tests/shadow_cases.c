/* SPDX-License-Identifier: MIT */
#include "tests/shadow_cases.h"

#include "scene/scene.h"

#define EXTENT 8.0 /* metres of the floor that are seen */

static shadow_measure *measure;
static double tolerance, strip;

/* What lies between the light and the floor at the height 1: a rectangle. */
struct shade {
    double low[2], high[2];
};

fnl_scene *shadow_floor(void) {
    fnl_scene *scene = world_create(NULL);
    fnl_material_params floor = matt(1);
    add_square(scene, &floor, vec3_make(10, 1, 10), vec3_make(0, 0, 0));
    add_point_light(scene, SHADOW_LIGHT, 50);
    return scene;
}

/* Every pixel of the floor is as visible as `inside` or `outside` of the shade's shadow says; but for a strip at the edge. */
static void expect_shadow(fnl_scene *scene, struct shade shade, double inside, double outside, const char *what) {
    /* From just above the floor, where nothing hides it. */
    const fnl_trace_params view = look_down(vec3_make(0, 0, 0), (float)EXTENT, 0.5f, SHADOW_SIZE);
    float seen[SHADOW_SIZE * SHADOW_SIZE];
    measure(scene, &view, seen);
    uint32_t dark = 0, lit = 0;
    for (uint32_t y = 0; y < SHADOW_SIZE; y++)
        for (uint32_t x = 0; x < SHADOW_SIZE; x++) {
            /* Where the way to the light is at the height of the shade. */
            const double light[2] = {(double)SHADOW_LIGHT.x, (double)SHADOW_LIGHT.z},
                         floor[2] = {((x + 0.5) / SHADOW_SIZE - 0.5) * EXTENT, ((y + 0.5) / SHADOW_SIZE - 0.5) * EXTENT};
            double edge = INFINITY; /* metres inside of the nearest edge */
            for (int i = 0; i < 2; i++) {
                double at = floor[i] + (light[i] - floor[i]) / (double)SHADOW_LIGHT.y;
                edge = fmin(edge, fmin(at - shade.low[i], shade.high[i] - at));
            }
            if (fabs(edge) < strip) continue;
            double wanted = edge > 0 ? inside : outside, got = (double)seen[y * SHADOW_SIZE + x];
            if (!(fabs(got - wanted) <= tolerance))
                fail_msg("%s: at %g, %g visibility is %g, must be %g", what, floor[0], floor[1], got, wanted);
            *(edge > 0 ? &dark : &lit) += 1;
        }
    assert_true(dark > 20 && lit > 20);
}

static const struct shade SQUARE = {{-1, -1}, {1, 1}};

static void hard_shadow(void) {
    for (int turned = 0; turned < 2; turned++) { /* the back of a single-sided square stops light too */
        fnl_scene *scene = shadow_floor();
        fnl_material_params material = matt(1);
        fnl_mesh_id mesh = add_square_mesh(scene, add_material(scene, &material));
        add_instance(
            scene, mesh,
            mat4_from_trs(vec3_make(0, 1, 0), quat_axis_angle(vec3_make(1, 0, 0), turned ? PI : 0), vec3_make(1, 1, 1)));
        expect_shadow(scene, SQUARE, 0, 1, turned ? "turned" : "plain");
    }
    fnl_scene *scene = shadow_floor();
    expect_shadow(scene, (struct shade){{-100, -100}, {0, 100}}, 1, 1, "without a square");
}

static void shadow_of_instances(void) {
    fnl_scene *scene = shadow_floor();
    fnl_material_params material = matt(1);
    fnl_mesh_id mesh = add_square_mesh(scene, add_material(scene, &material));
    add_instance(scene, mesh, mat4_mul(mat4_translation((vec3){0.5f, 1, -0.25f}), mat4_scaling((vec3){-0.5f, 7, 1.25f})));
    add_instance(
        scene, mesh,
        mat4_mul(mat4_translation((vec3){0, -5, 0}), mat4_scaling((vec3){3, 1, 3}))); /* of the same mesh, elsewhere */
    expect_shadow(scene, (struct shade){{0, -1.5}, {1, 1}}, 0, 1, "mirrored and stretched");
    scene = shadow_floor();
    mesh = add_square_mesh(scene, add_material(scene, &material));
    add_instance(scene, mesh,
                 mat4_mul(mat4_translation((vec3){0, 1, 0}), mat4_scaling((vec3){1, 0, 0.5f}))); /* has no inverse */
    expect_shadow(scene, (struct shade){{-1, -0.5}, {1, 0.5}}, 0, 1, "flattened");
    /* An instance that is hidden, or gone, casts none. */
    scene = shadow_floor();
    fnl_instance_id hidden = add_square(scene, &material, (vec3){1, 1, 1}, (vec3){0, 1, 0});
    assert_int_equal(fnl_scene_set_instance_visible(scene, hidden, false), FNL_OK);
    expect_shadow(scene, SQUARE, 1, 1, "hidden");
}

/* The half of the texture with x < 0.5 is a hole; linear filtering crosses the cutoff in the middle. */
static fnl_image_id half_hole(fnl_scene *scene) {
    static uint8_t texels[8] = {255, 255, 255, 0, 255, 255, 255, 255};
    fnl_image image = {2, 1, FNL_PIXEL_FORMAT_RGBA8, texels};
    fnl_image_id id;
    assert_int_equal(fnl_scene_add_image(scene, &image, true, &id), FNL_OK);
    return id;
}

static void cutout_lets_light_through_its_holes(void) {
    fnl_scene *scene = shadow_floor();
    fnl_material_params leaf = matt(1);
    leaf.base_color_image = half_hole(scene);
    leaf.alpha_mode = FNL_ALPHA_MASK;
    /* The texture repeats, and is filtered over its edge: a mirrored wrap keeps both halves whole. */
    fnl_material_id material = add_material(scene, &leaf);
    const struct scene_sampler clamped = {
        .mag = SCENE_FILTER_LINEAR, .min = SCENE_FILTER_LINEAR, .wrap_u = SCENE_WRAP_CLAMP, .wrap_v = SCENE_WRAP_CLAMP};
    scene->materials.data[material.index].textures[SCENE_TEXTURE_BASE_COLOR].sampler = scene_add_sampler(scene, &clamped);
    add_instance(scene, add_square_mesh(scene, material), mat4_translation((vec3){0, 1, 0}));
    expect_shadow(scene, (struct shade){{0, -1}, {1, 1}}, 0, 1, "cutout");
}

/* Glass hides no light, unless it is metal, and so is opaque. */
static void glass_lets_light_through(void) {
    for (uint32_t metal = 0; metal < 2; metal++) {
        fnl_scene *scene = shadow_floor();
        fnl_material_params glass = matt(1);
        glass.transmission.strength = 1;
        glass.metallic = (float)metal;
        add_square(scene, &glass, (vec3){1, 1, 1}, (vec3){0, 1, 0});
        expect_shadow(scene, SQUARE, metal ? 0 : 1, 1, metal ? "metal" : "glass");
    }
}

static void blended_surfaces_attenuate(void) {
    fnl_scene *scene = shadow_floor();
    fnl_material_params glass = matt(1);
    glass.alpha_mode = FNL_ALPHA_BLEND;
    glass.base_color[3] = 0.25f;
    add_square(scene, &glass, (vec3){1, 1, 1}, (vec3){0, 1, 0});
    expect_shadow(scene, SQUARE, 0.75, 1, "one pane");
    scene = shadow_floor();
    add_square(scene, &glass, (vec3){1, 1, 1}, (vec3){0, 1, 0});
    glass.base_color[3] = 0.5f;
    add_square(scene, &glass, (vec3){100, 1, 100}, (vec3){0, 2, 0});
    expect_shadow(scene, SQUARE, 0.375, 0.5, "two panes");
}

/* ---- poses ---- */

/* The square of a mesh with a morph target that moves it by 2 in x, and a skin of one joint. */
static void posed_meshes_cast_their_shadow(void) {
    enum { ROOM = 6 }; /* vertices may have been split between the triangles */
    static const vec3 moved[ROOM] = {{2, 0, 0}, {2, 0, 0}, {2, 0, 0}, {2, 0, 0}, {2, 0, 0}, {2, 0, 0}};
    static const struct scene_morph_target target = {.positions = moved};
    static float weight = 0.5f; /* of the mesh: it is moved by 1 */
    fnl_scene *scene = shadow_floor();
    fnl_material_params material = matt(1);
    fnl_mesh_id mesh = add_square_mesh(scene, add_material(scene, &material));
    struct scene_primitive *p = &scene->primitives.data[scene->meshes.data[mesh.index].first_primitive];
    assert_true(p->vertex_count <= ROOM);
    p->morph_targets = &target;
    p->morph_target_count = 1;
    scene->meshes.data[mesh.index].morph_weights = &weight;
    scene->meshes.data[mesh.index].morph_target_count = 1;
    add_instance(scene, mesh, mat4_mul(mat4_translation((vec3){0, 1, 0}), mat4_scaling((vec3){0.5f, 1, 1})));
    expect_shadow(scene, (struct shade){{0, -1}, {1, 1}}, 0, 1, "morphed");

    static const uint16_t joints[ROOM * 4] = {0};
    static const float weights[ROOM * 4] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};
    static const mat4 inverse = {{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -4, 0, 0, 1}};
    scene = shadow_floor();
    mesh = add_square_mesh(scene, add_material(scene, &material));
    p = &scene->primitives.data[scene->meshes.data[mesh.index].first_primitive];
    p->joints = joints;
    p->weights = weights;
    p->joint_count = 4;
    mat4 joint_pose = mat4_mul(mat4_translation((vec3){2, 1, 0}), mat4_scaling((vec3){0.5f, 1, 0.5f}));
    const uint32_t joint = scene_add_node(scene, "joint", SCENE_NONE, &joint_pose, SCENE_NONE);
    fnl_instance_id body = add_instance(scene, mesh, mat4_translation((vec3){0, 77, 0}));
    scene_update_transforms(scene);
    const struct scene_skin skin = {.joints = &joint, .inverse_bind = &inverse, .joint_count = 1};
    assert_true(array_push(&scene->host, &scene->skins, skin));
    scene->nodes.data[body.index].skin = scene->skins.count - 1; /* the place of the node itself no longer matters */
    /* x -> (x - 4) / 2 + 2 */
    expect_shadow(scene, (struct shade){{-0.5, -0.5}, {0.5, 0.5}}, 0, 1, "skinned");
}

/* A lamp in the plane of the ceiling lights the room below, and not the one above; no surface shadows itself, also far from the origin. */
static void light_on_a_surface(void) {
    static const float offsets[] = {0, 1000};
    for (uint32_t i = 0; i < COUNT_OF(offsets); i++) {
        const float o = offsets[i];
        fnl_scene *scene = world_create(NULL);
        fnl_material_params white = matt(1);
        for (int k = 0; k < 3; k++) add_square(scene, &white, (vec3){9, 1, 9}, (vec3){o, 3 * (float)k, o});
        add_point_light(scene, (vec3){o + 0.1f, 3, o}, 10);
        const fnl_trace_params view = look_down((vec3){o, 0, o}, 8, 2, SHADOW_SIZE);
        float seen[SHADOW_SIZE * SHADOW_SIZE];
        measure(scene, &view, seen);
        for (uint32_t k = 0; k < SHADOW_SIZE * SHADOW_SIZE; k++)
            if (!(fabs((double)seen[k] - 1) <= tolerance)) fail_msg("%g from the origin, pixel %u: visibility is %g", (double)o, k, (double)seen[k]);
    }
}

void shadow_cases(const struct shadow_cases *cases) {
    measure = cases->measure;
    tolerance = cases->tolerance;
    strip = cases->strip;
    hard_shadow();
    shadow_of_instances();
    cutout_lets_light_through_its_holes();
    glass_lets_light_through();
    if (cases->blended) blended_surfaces_attenuate();
    posed_meshes_cast_their_shadow();
    light_on_a_surface();
}
