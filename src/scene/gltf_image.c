/* SPDX-License-Identifier: MIT */
/* Images (only their headers are read), samplers and textures (glTF 2.0, 3.8). */
#include "image/image.h"
#include "scene/gltf.h"

/* ---- images ---- */

bool gltf_take_image(struct gltf *g, const struct at *at, uint32_t width, uint32_t height) {
    return gltf_take_memory(g, at, (uint64_t)width * height * 4);
}

static const char *kind_name(enum image_file_kind kind) {
    switch (kind) {
    case IMAGE_FILE_PNG:
        return "png";
    case IMAGE_FILE_JPEG:
        return "jpeg";
    case IMAGE_FILE_WEBP:
        return "webp";
    case IMAGE_FILE_DDS:
        return "dds";
    case IMAGE_FILE_KTX2:
        return "ktx2";
    case IMAGE_FILE_HDR:
    case IMAGE_FILE_EXR:
    case IMAGE_FILE_UNKNOWN:
        break;
    }
    return NULL;
}

/** Finds the encoded bytes. False: there are none (warned). */
static bool find_bytes(struct gltf *g, json_t *object, const struct at *at, const unsigned char **data, uint64_t *size) {
    json_t *uri = json_object_get(object, "uri"), *view_value = json_object_get(object, "bufferView");
    if (!uri == !view_value) {
        gltf_warn(g, at, "must have either 'uri' or 'bufferView'; it is shown as white");
        return false;
    }
    if (uri) {
        const char *text = gltf_string(g, object, at, "uri", true);
        return text && gltf_read_uri(g, AT_KEY(at, "uri"), text, false, data, size);
    }
    uint32_t index = gltf_index(g, object, at, "bufferView", true, g->view_count);
    if (index == SCENE_NONE) return false;
    const struct gltf_view *view = &g->views[index];
    if (view->stride)
        gltf_warn(g, AT_KEY(at, "bufferView"), "the buffer view of an image must not have a byteStride; it is ignored");
    if (!json_object_get(object, "mimeType")) gltf_warn(g, at, "has a 'bufferView' but no 'mimeType'; the bytes will tell");
    if (!view->valid || !view->data) {
        gltf_warn(g, AT_KEY(at, "bufferView"), "has no data; the image is shown as white");
        return false;
    }
    *data = view->data;
    *size = view->size;
    return true;
}

/** Whether the declared type is that of the bytes, which decide. */
static void check_mime_type(struct gltf *g, json_t *object, const struct at *at, const char *kind) {
    char expected[32], type[64];
    snprintf(expected, sizeof expected, "image/%s", strcmp(kind, "dds") == 0 ? "vnd-ms.dds" : kind);
    const char *uri = json_string_value(json_object_get(object, "uri"));
    if (uri && gltf_uri_media_type(uri, type, sizeof type) && strcmp(type, expected) != 0)
        gltf_warn(g, at, "its data URI says %s, but the bytes are %s, as which they are read", type, expected);
    const char *declared = gltf_string(g, object, at, "mimeType", false);
    if (declared && strcmp(declared, expected) != 0)
        gltf_warn(g, at, "its mimeType is '%.100s', but the bytes are %s, as which they are read", declared, expected);
}

/** Whether the file says that it has pictures of its kind, which core glTF has not. */
static void check_extension(struct gltf *g, const struct at *at, enum image_file_kind kind) {
    static const struct {
        enum image_file_kind kind;
        const char *name, *extension;
    } kinds[] = {{IMAGE_FILE_WEBP, "WebP", "EXT_texture_webp"}, {IMAGE_FILE_KTX2, "KTX2", "KHR_texture_basisu"}, {IMAGE_FILE_DDS, "DDS", "MSFT_texture_dds"}};
    for (uint32_t i = 0; i < COUNT_OF(kinds); i++)
        if (kinds[i].kind == kind && !gltf_uses(g, kinds[i].extension))
            gltf_warn(g, at, "is %s, but %s is not in extensionsUsed; it is used all the same", kinds[i].name, kinds[i].extension);
}

static void load_image(struct gltf *g, json_t *object, const struct at *at, uint32_t index, struct scene_image *image) {
    const unsigned char *data;
    uint64_t size;
    if (!find_bytes(g, object, at, &data, &size)) return;
    struct gltf_quiet_host quiet;
    gltf_quiet_host_init(&quiet, g->host);
    struct image_file_info info;
    fnl_result result = image_peek(&quiet.host, data, (size_t)size, "the picture", &info);
    const char *kind = result == FNL_OK ? kind_name(info.kind) : NULL;
    if (result == FNL_ERROR_MEMORY) {
        gltf_fail_memory(g);
    } else if (!kind || info.cube || info.is_float) {
        gltf_warn(g, at, "%s; it is shown as white",
                  result != FNL_OK ? quiet.line
                  : !kind          ? "is neither PNG, JPEG, WebP, KTX2 nor DDS"
                  : info.cube      ? "is a cube map, not a picture"
                                   : "is a picture of floats, not of 8 bits a channel");
    } else {
        check_extension(g, at, info.kind);
        check_mime_type(g, object, at, kind);
        g->image_transfer[index] = (uint8_t)info.transfer;
        if (!gltf_take_image(g, at, info.width, info.height)) return;
        image->encoded = data;
        image->encoded_size = (size_t)size;
        image->file_kind = kind;
        image->width = info.width;
        image->height = info.height;
        image->async = g->params.async;
    }
}

static void load_images(struct gltf *g) {
    json_t *array = gltf_array(g, g->root, &g->top, "images", false);
    const struct at *at = AT_KEY(&g->top, "images");
    g->image_count = gltf_count(array);
    g->image_twin = gltf_scratch(g, g->image_count, sizeof *g->image_twin);
    g->image_used = gltf_scratch(g, g->image_count, sizeof *g->image_used);
    g->image_transfer = gltf_scratch(g, g->image_count, sizeof *g->image_transfer);
    for (uint32_t i = 0; i < g->image_count && g->result == FNL_OK; i++) {
        struct scene_image image = {
            .name = arena_format(&g->scene->arena, "%s: /images/%u", g->name, i),
            .file_kind = "missing",
        };
        if (!image.name) gltf_fail_memory(g);
        json_t *object = gltf_element(g, array, at, i);
        if (object) load_image(g, object, AT_INDEX(at, i), i, &image);
        g->image_twin[i] = SCENE_NONE;
        if (scene_add_image(g->scene, &image) == SCENE_NONE) gltf_fail_memory(g);
        gltf_step(g);
    }
}

/* ---- samplers ---- */

enum {
    NEAREST = 9728,
    LINEAR,
    NEAREST_MIPMAP_NEAREST = 9984,
    LINEAR_MIPMAP_NEAREST,
    NEAREST_MIPMAP_LINEAR,
    LINEAR_MIPMAP_LINEAR
};
enum { CLAMP_TO_EDGE = 33071, MIRRORED_REPEAT = 33648, REPEAT = 10497 };

static enum scene_wrap read_wrap(struct gltf *g, json_t *object, const struct at *at, const char *key) {
    uint64_t value = REPEAT;
    gltf_uint(g, object, at, key, false, 0, UINT32_MAX, &value);
    if (value == CLAMP_TO_EDGE) return SCENE_WRAP_CLAMP;
    if (value == MIRRORED_REPEAT) return SCENE_WRAP_MIRROR;
    if (value != REPEAT) gltf_warn(g, AT_KEY(at, key), "is unknown; it is taken as repeat");
    return SCENE_WRAP_REPEAT;
}

static void load_sampler(struct gltf *g, json_t *object, const struct at *at, struct scene_sampler *sampler) {
    uint64_t mag = LINEAR, min = LINEAR_MIPMAP_LINEAR;
    gltf_uint(g, object, at, "magFilter", false, NEAREST, LINEAR, &mag);
    gltf_uint(g, object, at, "minFilter", false, NEAREST, LINEAR_MIPMAP_LINEAR, &min);
    if (min > LINEAR && min < NEAREST_MIPMAP_NEAREST) {
        gltf_warn(g, AT_KEY(at, "minFilter"), "is unknown; it is taken as linear with mipmaps");
        min = LINEAR_MIPMAP_LINEAR;
    }
    sampler->mag = mag == NEAREST ? SCENE_FILTER_NEAREST : SCENE_FILTER_LINEAR;
    sampler->min = min == NEAREST || min == NEAREST_MIPMAP_NEAREST || min == NEAREST_MIPMAP_LINEAR ? SCENE_FILTER_NEAREST
                                                                                                   : SCENE_FILTER_LINEAR;
    sampler->mip = min == NEAREST_MIPMAP_LINEAR || min == LINEAR_MIPMAP_LINEAR ? SCENE_FILTER_LINEAR : SCENE_FILTER_NEAREST;
    sampler->mipmapped = min >= NEAREST_MIPMAP_NEAREST;
    sampler->wrap_u = read_wrap(g, object, at, "wrapS");
    sampler->wrap_v = read_wrap(g, object, at, "wrapT");
}

/** The document's sampler i becomes the scene's i + 1; the scene's 0 is the default. */
static void load_samplers(struct gltf *g) {
    json_t *array = gltf_array(g, g->root, &g->top, "samplers", false);
    const struct at *at = AT_KEY(&g->top, "samplers");
    g->sampler_count = gltf_count(array);
    for (uint32_t i = 0; i < g->sampler_count && g->result == FNL_OK; i++) {
        struct scene_sampler sampler = g->scene->samplers.data[0];
        json_t *object = gltf_element(g, array, at, i);
        if (object) load_sampler(g, object, AT_INDEX(at, i), &sampler);
        if (scene_add_sampler(g->scene, &sampler) == SCENE_NONE) gltf_fail_memory(g);
    }
}

/* ---- textures ---- */

static void load_textures(struct gltf *g) {
    static const char *const extensions[] = {"KHR_texture_basisu", "EXT_texture_webp", "MSFT_texture_dds"};
    json_t *array = gltf_array(g, g->root, &g->top, "textures", false);
    const struct at *at = AT_KEY(&g->top, "textures");
    g->texture_count = gltf_count(array);
    g->textures = gltf_scratch(g, g->texture_count, sizeof *g->textures);
    for (uint32_t i = 0; i < g->texture_count && g->result == FNL_OK; i++) {
        struct gltf_texture *texture = &g->textures[i];
        *texture = (struct gltf_texture){.image = SCENE_NONE, .sampler = 0};
        json_t *object = gltf_element(g, array, at, i);
        if (!object) continue;
        const struct at *here = AT_INDEX(at, i);
        for (uint32_t k = 0; k < COUNT_OF(extensions) && texture->image == SCENE_NONE; k++) {
            struct gltf_extension_place place;
            json_t *extension = gltf_extension(object, here, extensions[k], &place);
            if (extension) texture->image = gltf_index(g, extension, &place.extension, "source", false, g->image_count);
        }
        uint32_t source = gltf_index(g, object, here, "source", false, g->image_count);
        if (texture->image == SCENE_NONE) texture->image = source;
        uint32_t sampler = gltf_index(g, object, here, "sampler", false, g->sampler_count);
        if (sampler != SCENE_NONE) texture->sampler = sampler + 1;
    }
}

void gltf_load_images(struct gltf *g) {
    load_images(g);
    if (g->result == FNL_OK) load_samplers(g);
    if (g->result == FNL_OK) load_textures(g);
}
