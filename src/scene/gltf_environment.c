/* SPDX-License-Identifier: MIT */
/*
 * EXT_lights_image_based: the environment of the shown scene, out of the six faces of its sharpest mip. What else the extension gives is computed
 * anew from these: the blurred mips, and the coefficients of the light that diffuse surfaces get.
 */
#include "image/image.h"
#include "scene/gltf.h"

#define NAME "EXT_lights_image_based"
enum { FACES = 6, COEFFICIENTS = 9, MOST_WIDTH = 4096 };

struct cube {
    uint32_t side;
    float *texels; /* RGB, face by face */
};

static size_t cube_bytes(const struct cube *cube) { return (size_t)FACES * cube->side * cube->side * 3 * sizeof(float); }

static float srgb_decode(float value) { return value <= 0.04045f ? value / 12.92f : powf((value + 0.055f) / 1.055f, 2.4f); }

/* The alpha of a PNG divides its colours (RGBD); all else is as it is seen. */
static void unpack(const fnl_image *image, bool divides, float *out) {
    const size_t count = (size_t)image->width * image->height;
    const bool deep = image->format == FNL_PIXEL_FORMAT_RGBA16;
    const float most = deep ? 65535 : 255;
    for (size_t i = 0; i < count; i++) {
        float rgba[4];
        for (size_t c = 0; c < 4; c++)
            rgba[c] = (deep ? (float)((const uint16_t *)image->pixels)[4 * i + c] : (float)((const uint8_t *)image->pixels)[4 * i + c]) / most;
        const float divisor = divides ? fmaxf(rgba[3], 1 / most) : 1;
        for (size_t c = 0; c < 3; c++) out[3 * i + c] = srgb_decode(rgba[c]) / divisor;
    }
}

static bool decode_face(struct gltf *g, const struct at *at, const struct scene_image *image, float *out) {
    struct gltf_quiet_host quiet;
    gltf_quiet_host_init(&quiet, g->host);
    fnl_image picture;
    const fnl_result result = image_decode(&quiet.host, image->encoded, image->encoded_size, "the picture", false, &picture);
    if (result == FNL_ERROR_MEMORY) gltf_fail_memory(g);
    if (result != FNL_OK) {
        gltf_warn(g, at, "%s; the light is left out", quiet.line);
        return false;
    }
    unpack(&picture, strcmp(image->file_kind, "png") == 0, out);
    fnl_image_free(&quiet.host, &picture);
    return true;
}

/* The images of the sharpest mip; all are squares of one size. */
static bool find_faces(struct gltf *g, json_t *light, const struct at *at, const struct scene_image *faces[FACES]) {
    json_t *mips = gltf_array(g, light, at, "specularImages", true), *mip = json_array_get(mips, 0);
    if (gltf_count(mips) == 0) return false;
    const struct at *mips_at = AT_KEY(at, "specularImages"), *here = AT_INDEX(mips_at, 0);
    if (!json_is_array(mip) || json_array_size(mip) != FACES) {
        gltf_warn(g, here, "is not an array of six images; the light is left out");
        return false;
    }
    for (uint32_t i = 0; i < FACES; i++) {
        const uint32_t index = gltf_index_value(g, json_array_get(mip, i), AT_INDEX(here, i), g->image_count);
        if (index == SCENE_NONE) return false;
        faces[i] = &g->scene->images.data[index];
        const char *fault = !faces[i]->encoded                         ? "cannot be read"
                            : faces[i]->width != faces[i]->height      ? "is no square"
                            : faces[i]->width != faces[0]->width       ? "has not the size of the others"
                                                                       : NULL;
        if (!fault) continue;
        gltf_warn(g, AT_INDEX(here, i), "image %u %s; the light is left out", index, fault);
        return false;
    }
    uint64_t size = faces[0]->width;
    gltf_uint(g, light, at, "specularImageSize", true, 1, IMAGE_SIDE_MAX, &size);
    if (size != faces[0]->width)
        gltf_warn(g, AT_KEY(at, "specularImageSize"), "is %u, but the images have %u pixels; these count", (uint32_t)size, faces[0]->width);
    return true;
}

/* They are computed anew, but a light without them is broken. */
static void check_coefficients(struct gltf *g, json_t *light, const struct at *at) {
    json_t *array = gltf_array(g, light, at, "irradianceCoefficients", true);
    if (!array) return;
    bool good = json_array_size(array) == COEFFICIENTS;
    for (size_t i = 0; i < COEFFICIENTS && good; i++) {
        json_t *row = json_array_get(array, i);
        good = json_array_size(row) == 3;
        for (size_t c = 0; c < 3; c++) good = good && json_is_number(json_array_get(row, c));
    }
    if (!good) gltf_warn(g, AT_KEY(at, "irradianceCoefficients"), "are not 9 by 3 numbers; they are not needed");
}

/* As graphics interfaces place cube maps; the first row of an image is that of t = 0. */
static vec3 look_up(const struct cube *cube, vec3 d) {
    const float x = fabsf(d.x), y = fabsf(d.y), z = fabsf(d.z);
    uint32_t face;
    float s, t, major;
    if (x >= y && x >= z) {
        face = d.x < 0;
        major = x, s = d.x < 0 ? d.z : -d.z, t = -d.y;
    } else if (y >= z) {
        face = 2 + (d.y < 0);
        major = y, s = d.x, t = d.y < 0 ? -d.z : d.z;
    } else {
        face = 4 + (d.z < 0);
        major = z, s = d.z < 0 ? -d.x : d.x, t = -d.y;
    }
    const float side = (float)cube->side, last = side - 1;
    const float u = CLAMP((s / major + 1) / 2 * side - 0.5f, 0.0f, last), v = CLAMP((t / major + 1) / 2 * side - 0.5f, 0.0f, last);
    const uint32_t column = (uint32_t)u, row = (uint32_t)v;
    const uint32_t right = MIN(column + 1, cube->side - 1), below = MIN(row + 1, cube->side - 1);
    const float *texels = cube->texels + (size_t)face * cube->side * cube->side * 3;
    const float a = u - (float)column, b = v - (float)row;
    float out[3];
    for (uint32_t c = 0; c < 3; c++) {
        const float *top = texels + (size_t)row * cube->side * 3 + c, *bottom = texels + (size_t)below * cube->side * 3 + c;
        out[c] = (top[3 * column] * (1 - a) + top[3 * right] * a) * (1 - b) + (bottom[3 * column] * (1 - a) + bottom[3 * right] * a) * b;
    }
    return vec3_make(out[0], out[1], out[2]);
}

/* As the scene's environment is: a panorama. */
static void surround(struct gltf *g, const struct at *at, const struct cube *cube, const struct scene_environment_own *own) {
    const struct panorama shape = {.width = MIN(4 * cube->side, MOST_WIDTH), .height = MIN(2 * cube->side, MOST_WIDTH / 2)};
    const size_t size = (size_t)shape.width * shape.height * 4 * sizeof(float);
    if (!gltf_take_memory(g, at, 2 * size)) return; /* and as the scene keeps it */
    float *pixels = host_allocate(g->host, size);
    if (!pixels) {
        gltf_fail_memory(g);
        return;
    }
    for (uint32_t y = 0; y < shape.height; y++)
        for (uint32_t x = 0; x < shape.width; x++) {
            const vec3 light = look_up(cube, panorama_direction(&shape, (float)x, (float)y));
            const float pixel[4] = {light.x, light.y, light.z, 1};
            memcpy(pixels + 4 * ((size_t)y * shape.width + x), pixel, sizeof pixel);
        }
    const fnl_image image = {shape.width, shape.height, FNL_PIXEL_FORMAT_RGBA32F, pixels};
    fnl_environment_params params = fnl_environment_params_default();
    params.image = &image;
    const fnl_result result = scene_set_own_environment(g->scene, &params, own);
    host_free(g->host, pixels, size);
    if (result != FNL_OK && g->result == FNL_OK) g->result = result; /* logged */
}

static void load_light(struct gltf *g, json_t *light, const struct at *at, uint32_t index) {
    const struct scene_image *faces[FACES];
    quat turn = quat_identity();
    float intensity = 1;
    check_coefficients(g, light, at);
    gltf_rotation(g, light, at, "rotation", &turn);
    gltf_float(g, light, at, "intensity", false, 0, 1e6f, &intensity);
    if (!find_faces(g, light, at, faces)) return;
    struct cube cube = {.side = faces[0]->width};
    if (!gltf_take_memory(g, at, cube_bytes(&cube))) return;
    cube.texels = host_allocate(g->host, cube_bytes(&cube));
    if (!cube.texels) gltf_fail_memory(g);
    bool good = cube.texels != NULL;
    const struct at *mips_at = AT_KEY(at, "specularImages"), *here = AT_INDEX(mips_at, 0);
    for (uint32_t i = 0; i < FACES && good; i++)
        good = decode_face(g, AT_INDEX(here, i), faces[i], cube.texels + (size_t)i * cube.side * cube.side * 3);
    if (good) surround(g, at, &cube, &(struct scene_environment_own){turn, intensity, index});
    host_free(g->host, cube.texels, cube.texels ? cube_bytes(&cube) : 0);
}

void gltf_load_environment(struct gltf *g) {
    struct gltf_extension_place place, scene_place;
    json_t *extension = gltf_extension(g->root, &g->top, NAME, &place);
    json_t *lights = extension ? gltf_array(g, extension, &place.extension, "lights", true) : NULL;
    json_t *scenes = json_object_get(g->root, "scenes"); /* gltf_load_scenes has complained of what is wrong there */
    const json_t *shown_value = json_object_get(g->root, "scene");
    const json_int_t shown = json_is_integer(shown_value) && json_integer_value(shown_value) < gltf_count(scenes) ? json_integer_value(shown_value) : 0;
    const struct at *scenes_at = AT_KEY(&g->top, "scenes"), *lights_at = AT_KEY(&place.extension, "lights");
    for (uint32_t i = 0; i < gltf_count(scenes) && g->result == FNL_OK; i++) {
        json_t *object = json_array_get(scenes, i);
        json_t *reference = json_is_object(object) ? gltf_extension(object, AT_INDEX(scenes_at, i), NAME, &scene_place) : NULL;
        if (!reference) continue;
        if (!extension) {
            gltf_warn(g, &scene_place.extension, "the file has no /extensions/" NAME "; it is ignored");
            continue;
        }
        const uint32_t index = gltf_index(g, reference, &scene_place.extension, "light", true, gltf_count(lights));
        json_t *light = index != SCENE_NONE && i == shown ? gltf_element(g, lights, lights_at, index) : NULL;
        if (light) load_light(g, light, AT_INDEX(lights_at, index), index);
    }
}
