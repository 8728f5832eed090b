/* SPDX-License-Identifier: MIT */
/** What the built-in scenes share: their table, materials and textures by name, and placing meshes and lights. */
#ifndef FNL_SCENE_BUILTIN_H
#define FNL_SCENE_BUILTIN_H

#include "base/jobs.h"
#include "scene/scene.h"

#define BUILTIN_LIGHTS_MAX 1048576u
#define BUILTIN_DECALS_MAX 1048576u
/** Each placed thing takes 128 bytes of host memory while a scene is made, 64 afterwards: 2 GiB. */
#define BUILTIN_INSTANCES_MAX 16777216u
#define BUILTIN_TRIANGLES_MAX 1000000000u
/** The value of a key whose default depends on the others. */
#define BUILTIN_NOT_GIVEN UINT64_MAX

/** Procedural picture sets (builtin_texture.c). Each tiles, and has a size in metres. */
enum builtin_texture {
    TEXTURE_ASPHALT, /* wet: smooth where puddles stand */
    TEXTURE_PAVING,
    TEXTURE_CONCRETE,
    TEXTURE_BRICK,
    TEXTURE_PLASTER,
    TEXTURE_STONE, /* ashlar blocks */
    TEXTURE_SANDSTONE,
    TEXTURE_MARBLE,
    TEXTURE_TILES,
    TEXTURE_WOOD,
    TEXTURE_BARK,
    TEXTURE_LEAVES, /* alpha is cut out */
    TEXTURE_GRASS,  /* alpha is cut out */
    TEXTURE_GROUND,
    TEXTURE_FABRIC,
    TEXTURE_METAL,
    TEXTURE_MARKING, /* worn road paint; alpha is cut out */
    TEXTURE_FACADE,  /* windows, some of them lit; emits */
    TEXTURE_ROOMS,   /* 4 x 4 interiors behind windows; emits */
    TEXTURE_COUNT,
};

struct builtin_images {
    uint32_t base_color, surface, normal, emissive; /* SCENE_NONE: none; surface: occlusion, roughness, metallic */
    float width, height;                            /* metres of one repetition */
    bool made;
};

/** The copies of one mesh. */
struct builtin_placement {
    ARRAY(mat4) transforms;
};

/** A scene being made. After `failed` every helper is a no-op that returns index 0, and the scene is dropped at the end. */
struct builtin {
    fnl_scene *scene;
    struct jobs *jobs;
    struct random_state random;
    struct builtin_images images[TEXTURE_COUNT];
    ARRAY(struct builtin_placement) placements; /* by mesh */
    uint64_t placed, placed_triangles;          /* copies in all, and triangles of theirs */
    struct scene_material scratch;              /* what builtin_material_at gives after a failure */
    bool failed;
};

/** One key of the text after '?', an integer in a range. */
struct builtin_key {
    const char *name;
    uint64_t low, high, fallback;
};

/** A line of the table: `make` gets the values in the order of the keys. */
struct builtin_scene {
    const char *name;
    struct builtin_key keys[7]; /* ends with a NULL name or with the array */
    void (*make)(struct builtin *b, const uint64_t *values);
    /** Its environment; NULL: constant ambient light, which is also there for those who take the environment away. Beside the key "sun" it is builtin:sky. */
    const char *environment;
    float intensity, intensity_by_sun;
};

/** The table; entry `index`, or NULL behind the last. */
const struct builtin_scene *builtin_scene_at(uint32_t index);

/* ---- the scenes ---- */

void builtin_make_city(struct builtin *b, const uint64_t *values);
void builtin_make_hall(struct builtin *b, const uint64_t *values);
void builtin_make_interior(struct builtin *b, const uint64_t *values);
void builtin_make_wall(struct builtin *b, const uint64_t *values);
void builtin_make_room(struct builtin *b, const uint64_t *values);
void builtin_make_spheres(struct builtin *b, const uint64_t *values);
void builtin_make_pole(struct builtin *b, const uint64_t *values);
void builtin_make_lamps(struct builtin *b, const uint64_t *values);
void builtin_make_grass(struct builtin *b, const uint64_t *values);
void builtin_make_onetile(struct builtin *b, const uint64_t *values);
void builtin_make_nearplane(struct builtin *b, const uint64_t *values);
void builtin_make_sky(struct builtin *b, const uint64_t *values);
void builtin_make_glass(struct builtin *b, const uint64_t *values);

/* ---- materials ---- */

/**
 * A material with a texture set, whose colour is multiplied by `tint` (linear). Its uvs are metres: the texture
 * transform divides by the set's size. Valid until the next call: change it through builtin_material_at.
 */
uint32_t builtin_material(struct builtin *b, const char *name, enum builtin_texture texture, vec3 tint);
/** A material without textures. */
uint32_t builtin_plain(struct builtin *b, const char *name, vec3 color, float metallic, float roughness);
/** A plain dark material that emits `radiance` in cd/m^2. */
uint32_t builtin_glow(struct builtin *b, const char *name, vec3 radiance);
/** The same for what stands round a light: it casts no shadow. */
uint32_t builtin_globe(struct builtin *b, const char *name, vec3 radiance);
/** Clear glass of the given tint and coverage, drawn with blending. */
uint32_t builtin_glass(struct builtin *b, const char *name, vec3 tint, float alpha);
/** The material itself, to change further; a scratch one after a failure. */
struct scene_material *builtin_material_at(struct builtin *b, uint32_t material);

/** Makes the pictures of a set when they are first asked for (builtin_texture.c). */
const struct builtin_images *builtin_texture_images(struct builtin *b, enum builtin_texture texture);

/* ---- placing ---- */

/** Adds one copy of a mesh. */
void builtin_place(struct builtin *b, uint32_t mesh, mat4 transform);
/** A transform: turned by `yaw` radians about +Y, scaled, moved. */
mat4 builtin_at(float x, float y, float z, float yaw, float scale);
/**
 * Replaces what the scene shows by its triangles from the farthest to the nearest of its first camera, some of them twice: about four
 * fragments of a pixel pass the depth test. Called once, by builtin_load.
 */
void builtin_overdraw(struct builtin *b);
/** Makes one node per placed mesh. Called once, by builtin_load. */
void builtin_flush(struct builtin *b);

/** Any light; direction and up are unit and at right angles. */
void builtin_light(struct builtin *b, const fnl_light_params *light);
/** Candela and metres; `color` is scaled to a maximum of 1 by the caller. */
void builtin_point(struct builtin *b, vec3 position, vec3 color, float intensity, float range);
/** `angle`: half angle of the cone in radians; full intensity within 60% of it. */
void builtin_spot(struct builtin *b, vec3 position, vec3 direction, vec3 color, float intensity, float range, float angle);

/**
 * `count` small random point lights in a box, whose range lets about `overlap` of them reach a point of the box, but is at
 * most `range`; their intensity follows from it.
 */
void builtin_fill(struct builtin *b, uint64_t count, vec3 low, vec3 high, float overlap, float range);

/** A perspective camera; `fov`: vertical, radians. */
void builtin_camera(struct builtin *b, const char *name, vec3 position, vec3 target, float fov);

/** Linear colours of light sources, maximum 1. */
#define LIGHT_SODIUM ((vec3){1.0f, 0.56f, 0.20f})
#define LIGHT_WARM ((vec3){1.0f, 0.72f, 0.44f})
#define LIGHT_NEUTRAL ((vec3){1.0f, 0.88f, 0.74f})
#define LIGHT_COOL ((vec3){0.78f, 0.90f, 1.0f})
/** A saturated colour of the hue circle; `hue` in turns. */
vec3 builtin_hue(float hue, float saturation);

#endif
