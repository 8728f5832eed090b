/* SPDX-License-Identifier: MIT */
#include "scene/builtin.h"
#include "scene/builtin_texel.h"

/** How a texture set is made. */
struct recipe {
    const char *name;
    texel_function *function;
    uint32_t size;       /* pixels of a side */
    float width, height; /* metres of one repetition */
    bool flat;           /* no normal map and no surface map: the emissive and distant ones */
    bool emits;
};

static const struct recipe recipes[TEXTURE_COUNT] = {
    [TEXTURE_ASPHALT] = {"asphalt", texel_asphalt, 512, 8, 8, false, false},
    [TEXTURE_PAVING] = {"paving", texel_paving, 512, 2.4f, 2.4f, false, false},
    [TEXTURE_CONCRETE] = {"concrete", texel_concrete, 256, 4, 4, false, false},
    [TEXTURE_BRICK] = {"brick", texel_brick, 512, 1.92f, 1.92f, false, false},
    [TEXTURE_PLASTER] = {"plaster", texel_plaster, 256, 3, 3, false, false},
    [TEXTURE_STONE] = {"stone", texel_stone, 512, 3.2f, 3.2f, false, false},
    [TEXTURE_SANDSTONE] = {"sandstone", texel_sandstone, 256, 2, 2, false, false},
    [TEXTURE_MARBLE] = {"marble", texel_marble, 512, 2, 2, false, false},
    [TEXTURE_TILES] = {"tiles", texel_tiles, 512, 2, 2, false, false},
    [TEXTURE_WOOD] = {"wood", texel_wood, 256, 1.2f, 1.2f, false, false},
    [TEXTURE_BARK] = {"bark", texel_bark, 256, 1, 1, false, false},
    [TEXTURE_LEAVES] = {"leaves", texel_leaves, 256, 1, 1, false, false},
    [TEXTURE_GRASS] = {"grass", texel_grass, 256, 1, 1, false, false},
    [TEXTURE_GROUND] = {"ground", texel_ground, 256, 4, 4, false, false},
    [TEXTURE_FABRIC] = {"fabric", texel_fabric, 256, 1, 1, false, false},
    [TEXTURE_METAL] = {"metal", texel_metal, 256, 1, 1, false, false},
    [TEXTURE_MARKING] = {"marking", texel_marking, 256, 2, 2, true, false},
    [TEXTURE_FACADE] = {"facade", texel_facade, 512, 24, 25.6f, true, true},
    [TEXTURE_ROOMS] = {"rooms", texel_rooms, 512, 1, 1, true, true},
};

/** The pictures being filled, one row a job. */
struct canvas {
    const struct recipe *recipe;
    struct texel *texels;
    uint8_t *base_color, *surface, *normal, *emissive; /* RGBA8, or NULL */
};

static uint8_t byte_linear(float x) { return (uint8_t)(CLAMP(x, 0.0f, 1.0f) * 255 + 0.5f); }

/** IEC 61966-2-1. */
static uint8_t byte_srgb(float x) {
    x = CLAMP(x, 0.0f, 1.0f);
    return byte_linear(x <= 0.0031308f ? 12.92f * x : 1.055f * powf(x, 1 / 2.4f) - 0.055f);
}

static void put_color(uint8_t *out, vec3 color, float alpha) {
    out[0] = byte_srgb(color.x);
    out[1] = byte_srgb(color.y);
    out[2] = byte_srgb(color.z);
    out[3] = byte_linear(alpha);
}

static void fill_row(void *context, uint32_t y) {
    struct canvas *canvas = context;
    uint32_t size = canvas->recipe->size;
    for (uint32_t x = 0; x < size; x++)
        canvas->texels[(size_t)y * size + x] =
            canvas->recipe->function(((float)x + 0.5f) / (float)size, ((float)y + 0.5f) / (float)size);
}

/** Central differences of the height field, which wraps; +Y of a glTF normal map points up the picture. */
static vec3 row_normal(const struct canvas *canvas, uint32_t x, uint32_t y) {
    uint32_t size = canvas->recipe->size, mask = size - 1;
    const struct texel *t = canvas->texels;
    float right = t[(size_t)y * size + ((x + 1) & mask)].height, left = t[(size_t)y * size + ((x - 1) & mask)].height;
    float below = t[(size_t)((y + 1) & mask) * size + x].height, above = t[(size_t)((y - 1) & mask) * size + x].height;
    float step_x = canvas->recipe->width / (float)size, step_y = canvas->recipe->height / (float)size;
    return vec3_normalize(vec3_make((left - right) / (2 * step_x), (below - above) / (2 * step_y), 1));
}

static void pack_row(void *context, uint32_t y) {
    struct canvas *canvas = context;
    uint32_t size = canvas->recipe->size;
    for (uint32_t x = 0; x < size; x++) {
        size_t at = (size_t)y * size + x;
        const struct texel *t = &canvas->texels[at];
        put_color(canvas->base_color + 4 * at, t->color, t->alpha);
        if (canvas->emissive) put_color(canvas->emissive + 4 * at, t->emission, 1);
        if (!canvas->surface) continue;
        uint8_t *surface = canvas->surface + 4 * at, *normal = canvas->normal + 4 * at;
        surface[0] = byte_linear(t->occlusion);
        surface[1] = byte_linear(t->roughness);
        surface[2] = byte_linear(t->metallic);
        vec3 n = row_normal(canvas, x, y);
        normal[0] = byte_linear(n.x * 0.5f + 0.5f);
        normal[1] = byte_linear(n.y * 0.5f + 0.5f);
        normal[2] = byte_linear(n.z * 0.5f + 0.5f);
        surface[3] = normal[3] = 255;
    }
}

static uint32_t add_picture(struct builtin *b, const char *name, const char *part, uint32_t size, uint8_t *pixels,
                            bool color) {
    if (!pixels) return SCENE_NONE;
    struct scene_image image = {
        .name = arena_format(&b->scene->arena, "%s: %s %s", b->scene->source, name, part),
        .file_kind = "generated",
        .width = size,
        .height = size,
        .pixels = pixels,
        .color = color,
    };
    uint32_t index = image.name ? scene_add_image(b->scene, &image) : SCENE_NONE;
    if (index == SCENE_NONE) b->failed = true;
    return index;
}

static void make_images(struct builtin *b, const struct recipe *recipe, struct builtin_images *images) {
    struct arena *arena = &b->scene->arena;
    uint32_t size = recipe->size;
    size_t bytes = (size_t)size * size * 4, texel_bytes = sizeof(struct texel) * (size_t)size * size;
    struct canvas canvas = {.recipe = recipe, .texels = host_allocate(&b->scene->host, texel_bytes)};
    canvas.base_color = arena_allocate(arena, bytes);
    canvas.emissive = recipe->emits ? arena_allocate(arena, bytes) : NULL;
    canvas.surface = recipe->flat ? NULL : arena_allocate(arena, bytes);
    canvas.normal = recipe->flat ? NULL : arena_allocate(arena, bytes);
    if (!canvas.texels || !canvas.base_color || (recipe->emits && !canvas.emissive) ||
        (!recipe->flat && (!canvas.surface || !canvas.normal))) {
        b->failed = true;
    } else {
        jobs_parallel_for(b->jobs, size, fill_row, &canvas);
        jobs_parallel_for(b->jobs, size, pack_row, &canvas);
        images->base_color = add_picture(b, recipe->name, "base colour", size, canvas.base_color, true);
        images->surface = add_picture(b, recipe->name, "surface", size, canvas.surface, false);
        images->normal = add_picture(b, recipe->name, "normal", size, canvas.normal, false);
        images->emissive = add_picture(b, recipe->name, "emission", size, canvas.emissive, true);
    }
    host_free(&b->scene->host, canvas.texels, texel_bytes);
}

const struct builtin_images *builtin_texture_images(struct builtin *b, enum builtin_texture texture) {
    struct builtin_images *images = &b->images[texture];
    if (images->made) return images;
    const struct recipe *recipe = &recipes[texture];
    *images = (struct builtin_images){SCENE_NONE, SCENE_NONE, SCENE_NONE, SCENE_NONE, recipe->width, recipe->height, true};
    if (!b->failed) make_images(b, recipe, images);
    return images;
}
