/* SPDX-License-Identifier: MIT */
/** What the tests of decals share: a grey wall, decals and pictures for it, frames and cameras. Comes after tests/render_test.h. */
#ifndef FNL_TESTS_DECALS_CASES_H
#define FNL_TESTS_DECALS_CASES_H

enum { SIDE = 64 };

static inline struct scene_material grey_material(void) {
    struct scene_material m = scene_material_default();
    m.name = "";
    m.base_color = (vec4){0.5f, 0.5f, 0.5f, 1};
    m.metallic = 0;
    return m;
}

static inline uint32_t add_grey(fnl_scene *scene) {
    struct scene_material m = grey_material();
    return scene_add_material(scene, &m);
}

/* A grey wall from -1 to 1 in light from all around. */
static inline fnl_scene *wall_scene(void) {
    fnl_scene *scene = test_scene();
    test_place(scene, test_quad_mesh(scene, add_grey(scene)), (vec3){0, 0, 0}, (vec3){1, 1, 1});
    assert_int_equal(fnl_scene_set_ambient(scene, (vec3){1, 1, 1}, (vec3){1, 1, 1}), FNL_OK);
    scene_update_transforms(scene);
    return scene;
}

static inline mat4 box_at(vec3 position, quat rotation, vec3 size) { return mat4_from_trs(position, rotation, size); }

static inline fnl_decal_params plain(float r, float g, float b, float alpha, mat4 transform) {
    fnl_decal_params p = fnl_decal_params_default();
    p.transform = transform;
    p.color[0] = r;
    p.color[1] = g;
    p.color[2] = b;
    p.color[3] = alpha;
    p.channels = FNL_DECAL_COLOR;
    return p;
}

static inline fnl_decal_id add(fnl_scene *scene, const fnl_decal_params *p) {
    fnl_decal_id id;
    assert_int_equal(fnl_scene_add_decal(scene, p, &id), FNL_OK);
    return id;
}

/* An RGBA8 picture from a function of the texel. */
static inline fnl_image_id add_picture(fnl_scene *scene, uint32_t width, uint32_t height, bool color,
                                void (*texel)(uint32_t x, uint32_t y, uint8_t out[4])) {
    uint8_t *pixels = malloc((size_t)width * height * 4);
    for (uint32_t i = 0; i < width * height; i++) texel(i % width, i / width, pixels + (size_t)i * 4);
    fnl_image image = {.width = width, .height = height, .format = FNL_PIXEL_FORMAT_RGBA8, .pixels = pixels};
    fnl_image_id id;
    assert_int_equal(fnl_scene_add_image(scene, &image, color, &id), FNL_OK);
    free(pixels);
    return id;
}

static inline fnl_frame frame_with(fnl_shading shading, fnl_decals decals, uint32_t outputs) {
    fnl_frame frame = test_frame(outputs);
    frame.shading = shading;
    frame.decals = decals;
    return frame;
}

static inline fnl_camera eye_camera(vec3 eye, vec3 target, float fov) {
    fnl_camera camera = fnl_camera_default();
    camera.position = eye;
    camera.target = target;
    camera.vertical_fov = fov;
    return camera;
}

/** Whether the box of a transform with this inverse holds a position; `nearest`: how far off its border is, in boxes. */
static inline bool holds(const mat4 *inverse, const float *position, double *nearest) {
    double far = 0;
    for (int r = 0; r < 3; r++) {
        double q = inverse->m[12 + r];
        for (int c = 0; c < 3; c++) q += (double)inverse->m[c * 4 + r] * (double)position[c];
        far = fmax(far, fabs(q));
    }
    *nearest = fabs(far - 0.5);
    return far <= 0.5;
}

#endif
