/* SPDX-License-Identifier: MIT */
/**
 * The scene in host memory. The importer, the built-in generators and the public calls all fill it through the same
 * functions; the renderer reads it and follows its version counters.
 */
#ifndef FNL_SCENE_SCENE_H
#define FNL_SCENE_SCENE_H

#include "base/base.h"
#include "base/check.h"
#include "base/file.h"
#include "base/jobs.h"
#include "base/maths.h"
#include "base/ranges.h"
#include "fanal/scene.h"
#include "fanal/stage.h"
#include "scene/ies.h"
#include "scene/material_layers.h"
#include "scene/scene_environment.h"

#include <stdatomic.h>

#define SCENE_NONE UINT32_MAX

/** Step of the origins that Fanal chooses, meters: a power of two, so floats and doubles represent them exactly. */
#define ORIGIN_STEP 16.0

/** Generation of the first image, material, or mesh at an index. Each reuse of the index increments it. */
enum { FIRST_GENERATION = 1 };

/** A picture: encoded bytes that are decoded when they are first needed, or RGBA8 pixels. */
struct scene_image {
    const char *name;             /* for messages, such as "car.glb: /images/2" */
    const unsigned char *encoded; /* borrowed from a mapped file or the scene's memory; NULL when pixels are given */
    size_t encoded_size;
    const char *file_kind;  /* "png", "jpeg", "webp", "ktx2", "dds", or "generated" */
    uint32_t width, height; /* 0x0 for a missing or broken image, which renders as white */
    uint8_t *pixels;        /* RGBA8, or NULL */
    void *memory;           /* that the image owns: its pixels and name, or NULL */
    size_t memory_size;
    bool color;             /* used for colour: mips are averaged in linear light */
    bool normals;           /* a file's material uses it as a normal map */
    bool async;             /* renderers decode it in the background (fnl_load_params.async) */
    uint32_t version;       /* incremented with each change of the pixels; continues when another image takes the index */
    uint32_t generation;
    bool removed;
};

enum scene_filter { SCENE_FILTER_NEAREST, SCENE_FILTER_LINEAR };
enum scene_wrap { SCENE_WRAP_REPEAT, SCENE_WRAP_MIRROR, SCENE_WRAP_CLAMP };

struct scene_sampler {
    enum scene_filter mag, min, mip;
    bool mipmapped;
    enum scene_wrap wrap_u, wrap_v;
};

enum scene_texture_slot {
    SCENE_TEXTURE_BASE_COLOR,
    SCENE_TEXTURE_METALLIC_ROUGHNESS,
    SCENE_TEXTURE_NORMAL,
    SCENE_TEXTURE_OCCLUSION,
    SCENE_TEXTURE_EMISSIVE,
    SCENE_TEXTURE_SPECULAR,
    SCENE_TEXTURE_SPECULAR_COLOR,
    SCENE_TEXTURE_CORE_COUNT, /* those before belong to all materials, those from here on to layers */
    SCENE_TEXTURE_BEFORE_LAYERS = SCENE_TEXTURE_CORE_COUNT - 1,
#define TEXTURE(slot, ...) SCENE_TEXTURE_##slot,
    MATERIAL_LAYER_TEXTURES(TEXTURE)
#undef TEXTURE
    SCENE_TEXTURE_SLOT_COUNT,
};

/** Whether a texture holds colours, not numbers: it is stored by the transfer function of sRGB. */
bool scene_texture_is_color(enum scene_texture_slot slot);
/** Whether it is a normal map. */
bool scene_texture_is_normals(enum scene_texture_slot slot);

/** uv' = (u, v, 1) through the 2x3 matrix of KHR_texture_transform. */
struct scene_texture {
    uint32_t image;     /* SCENE_NONE: no texture */
    uint32_t sampler;   /* index; sampler 0 is glTF's default (linear, mipmapped, repeat) */
    uint32_t uv_set;    /* 0 or 1 */
    float transform[6]; /* u' = t[0] u + t[1] v + t[2];  v' = t[3] u + t[4] v + t[5] */
};

/** What animations set by itself, and a material has combined: emission, and the transforms of textures. */
struct scene_material_parts {
    vec3 emissive;
    float emissive_strength;
    struct scene_texture_turn {
        float offset[2], scale[2], rotation;
    } turns[SCENE_TEXTURE_SLOT_COUNT]; /* KHR_texture_transform */
};

struct scene_material {
    const char *name, *extras; /* extras: JSON text, or NULL; so below */
    vec4 base_color;
    float metallic, roughness, normal_scale, occlusion_strength;
    vec3 emissive; /* cd/m^2, strength included */
    float ior, specular;
    vec3 specular_color;
    fnl_alpha_mode alpha_mode;
    float alpha_cutoff;
    bool double_sided, unlit, casts_shadows;
    /* Layers, by their numbers; their images are in `textures`. volume.attenuation_distance is infinite where light is not attenuated. */
#define LAYER(member, type, extension) type member;
    MATERIAL_LAYERS(LAYER)
#undef LAYER
    struct scene_texture textures[SCENE_TEXTURE_SLOT_COUNT];
    float tangent_frame[4]; /* rows of the 2x2 matrix by which tangents saw texture coordinates; all 0: as the mesh has them */
    struct scene_material_parts parts; /* as the file or an animation said last: calls change only what they make */
    uint32_t generation;
    bool removed;
    bool animated; /* within animation_apply: it has new values */
};

/**
 * Alpha below this is a hole. An alpha that equals the cutoff is none (glTF 2.0, 3.9.4), so the cutoff is less what interpolation and vertex colors of
 * 16 bits take from it; textures of 8 bits have steps of 1/255.
 */
static inline float scene_material_cutoff(const struct scene_material *material) { return material->alpha_cutoff - 1.0f / 65535; }

enum scene_topology {
    SCENE_TOPOLOGY_TRIANGLES,
    SCENE_TOPOLOGY_LINES,
    SCENE_TOPOLOGY_POINTS
}; /* strips, fans and loops are expanded */

/** A primitive's material in a variant. */
struct scene_mapping {
    uint32_t variant, material;
};

/** Differences to the base vertices; NULL where the target leaves an attribute alone. */
struct scene_morph_target {
    const vec3 *positions, *normals, *tangents;
};

/** Arrays belong to the scene's arena, or once they were replaced to `memory`. Only positions and indices are always there; importers generate missing normals and tangents (lines and points stay without, and are unlit). */
struct scene_primitive {
    uint32_t material; /* index; SCENE_NONE: glTF's default material */
    const struct scene_mapping *mappings; /* each variant once, all of one file; the others have standard_material */
    uint32_t mapping_count, standard_material;
    enum scene_topology topology;
    uint32_t vertex_count, index_count;
    const uint32_t *indices;
    const vec3 *positions, *normals;
    const vec4 *tangents;
    const vec2 *uv[2];
    const vec4 *colors;
    const uint16_t *joints; /* joint_count per vertex: indices into the skin's joints */
    const float *weights;   /* joint_count per vertex, sum 1 */
    uint32_t joint_count;   /* per vertex, a multiple of 4; 0: not skinned */
    const struct scene_morph_target *morph_targets;
    uint32_t morph_target_count;
    struct box bounds; /* of the base vertices grown by all morph targets */
    bool leans;        /* some vertex normal may differ from the geometric normal of its triangle */
    uint32_t version, shape_version; /* count the changes of all arrays; of positions and indices among them */
    uint32_t source; /* its number in the mesh of its file, of whose primitives some may have been left out */
    struct arena memory; /* holds the arrays that fnl_scene_set_mesh has replaced; empty: the scene's does */
};

struct scene_mesh {
    const char *name, *extras;
    uint32_t first_primitive, primitive_count;
    const float *morph_weights; /* default weights, one per target; NULL: zeros */
    uint32_t morph_target_count;
    struct box bounds;
    uint32_t generation;
    bool removed;
};

struct scene_node {
    const char *name, *extras;
    uint32_t parent, first_child, next_sibling; /* SCENE_NONE ends */
    bool has_matrix;                            /* local is given as matrix, not as TRS */
    bool placed; /* a call set the local transform, and no animation has set it since */
    bool hidden; /* with what is below it */
    bool unchosen; /* another level of detail is shown in its place, and in that of what is below it */
    bool mesh_off; /* the same of its mesh alone */
    bool active; /* neither it nor a node above is hidden or unchosen */
    bool removed;
    bool staged; /* `removed` for all public calls, but drawn: a part of the stage */
    bool moves;   /* within scene_move_nodes: it has a new local transform */
    bool linked; /* a file's: skins, animations, cameras and lights may refer to it, so its place is not used again */
    double translation[3], rotation[4], scale[3];
    struct affine local_exact, world_exact; /* independent of the origin */
    mat4 world;                             /* rounded, relative to the origin */
    uint32_t mesh, skin, camera; /* SCENE_NONE: none */
    float *morph_weights;        /* this node's weights, or NULL: the mesh's */
    bool owns_weights;           /* they are the host's; else the arena's */
    const mat4 *instances;       /* EXT_mesh_gpu_instancing: transforms in node space, or NULL */
    uint32_t instance_count;     /* 1 without `instances` */
    uint32_t generation;         /* for fnl_instance_id */
    uint64_t moved_version;      /* transform_version at which `world` or `morph_weights` last changed */
    uint64_t edited_version;     /* structure_version at which it last came, went, was hidden or shown, or got other receivers or another mask */
    uint8_t refuses;             /* receiver bits that the node lacks: decals that share no other are not on it */
    uint8_t unseen;              /* view mask bits that the node lacks: cameras that share no other do not show it */
    uint8_t unlit;               /* light mask bits that the node lacks: lights that share no other do not affect it */
};

/** What stands for the same thing, finest first: nodes, or with of_mesh the mesh of the first node and those of nodes below it (levels.c). */
struct scene_levels {
    const uint32_t *nodes;
    const float *coverage; /* of each: the least part of the screen's height that it is shown at; descending */
    uint32_t count;
    uint32_t shown; /* by the last picture; count: none */
    bool of_mesh, measured;
    vec3 center; /* of the sphere round the first, in its node's space as it stood when it was measured */
    float radius;
};

struct scene_skin {
    const char *name;
    const uint32_t *joints; /* node indices */
    const mat4 *inverse_bind;
    uint32_t joint_count;
};

enum scene_animation_path {
    SCENE_PATH_TRANSLATION,
    SCENE_PATH_ROTATION,
    SCENE_PATH_SCALE,
    SCENE_PATH_WEIGHTS,
    SCENE_PATH_VISIBLE,
    SCENE_PATH_PROPERTY, /* of what is no node */
};
enum scene_interpolation { SCENE_INTERPOLATION_STEP, SCENE_INTERPOLATION_LINEAR, SCENE_INTERPOLATION_CUBIC };

enum scene_property_owner { SCENE_PROPERTY_MATERIAL, SCENE_PROPERTY_LIGHT, SCENE_PROPERTY_CAMERA, SCENE_PROPERTY_ENVIRONMENT };
/** What else follows from new values. */
enum scene_property_effect {
    SCENE_EFFECT_NONE,
    SCENE_EFFECT_EMISSIVE, /* parts to the product */
    SCENE_EFFECT_TURN,     /* parts to the matrix of `slot` */
    SCENE_EFFECT_IOR,      /* 0, or at least 1 */
    SCENE_EFFECT_EXTENT,   /* half of it is given, with either sign */
    SCENE_EFFECT_ROTATION, /* a quaternion */
};

/** One to four floats of a scene_material, fnl_light_params, fnl_camera or scene_environment_own. */
struct scene_property {
    enum scene_property_owner owner;
    enum scene_property_effect effect;
    enum scene_texture_slot slot;
    size_t offset;
    float low, high; /* values beyond, also of splines between good keys, are clamped */
};

struct scene_channel {
    uint32_t node; /* SCENE_NONE for properties */
    enum scene_animation_path path;
    const struct scene_property *property; /* or NULL */
    uint32_t object, generation;           /* whose: an index, and for lights the generation; of an environment which light of its file */
    enum scene_interpolation interpolation;
    uint32_t key_count, width; /* width: floats per value (1 to 4, or the weight count) */
    uint32_t first_weight;     /* the first that it sets */
    const float *times;        /* strictly increasing */
    const float *values;       /* key_count * width, for cubic 3 times that: in-tangent, value, out-tangent */
};

struct scene_animation {
    const char *name, *extras;
    const struct scene_channel *channels;
    uint32_t channel_count;
    float duration; /* last key of all channels */
    bool removed;
};

/* Convex bound of a light, in world space (light_hull.c). */
#define LIGHT_HULL_POINTS_MAX 64u
#define LIGHT_HULL_PLANES_MAX (2 * LIGHT_HULL_POINTS_MAX - 4)
struct light_hull {
    uint32_t plane_count;
    double planes[LIGHT_HULL_PLANES_MAX][4]; /* outside is dot(xyz, p) + w > 0; xyz is unit */
    vec3 center;                             /* a sphere that holds it */
    double place[3];                         /* of `center`, independent of the origin */
    float radius;
};

struct scene_light {
    fnl_light_params params; /* position, direction and up in world space; the latter two unit and at right angles */
    double place[3];         /* params.position, independent of the origin; unused while a node carries the light */
    struct light_hull *hull; /* or NULL */
    const char *name, *extras; /* NULL: none */
    uint32_t node;           /* the node that carries it, or SCENE_NONE */
    uint32_t generation;
    uint32_t slot;           /* of a local light, from when it is added until it is removed; else SCENE_NONE */
    uint32_t unlimited_at;   /* index in fnl_scene.unlimited, or SCENE_NONE */
    float reach;             /* meters; takes the place of a range, see scene_follow_reach() */
    uint32_t shadow_request; /* fnl_shadow_update: another number is another request */
    bool removed;
    bool staged;   /* `removed` for all public calls, but it shines: a part of the stage */
    bool animated; /* within animation_apply: it has new values */
};

/* Scene state at the last scene_follow_reach(). */
struct scene_reach {
    struct box bounds;
    bool grown; /* the bounds may be larger than the scene's: enough for unlimited lights, not for a threshold */
    uint64_t structure_version, transform_version, light_version; /* structure_version UINT64_MAX: no state yet */
};

/* A place in the array of local lights on the device. Caches may key on the place and its light's generation. */
struct scene_light_slot {
    uint32_t light;           /* SCENE_NONE: free */
    uint64_t changed_version; /* light_version at which what is in it last changed */
};

/* A decal (decal.c). Pictures are indices; the transform is that of the parameters. */
struct scene_decal {
    fnl_decal_params params;
    double place[3]; /* translation of params.transform, independent of the origin; unused with a node */
    uint32_t node;   /* the node it is on or moves with, or SCENE_NONE */
    uint32_t generation;
    bool removed;
};

/* A probe (probe.c). */
struct scene_probe {
    fnl_probe_params params;
    double place[3]; /* params.centre, independent of the origin */
    uint64_t version; /* of the scene's probes when it was added or set */
    uint32_t generation;
    bool removed;
};

/* A node whose textures are painted on: what it showed before (decal_bake.c). */
struct scene_painted {
    uint32_t node, mesh; /* the mesh that others may show too */
    uint32_t own_mesh;   /* with materials and pictures of its own */
};

struct scene_camera {
    const char *name, *extras;
    uint32_t node;     /* pose comes from the node; SCENE_NONE: `camera` holds it */
    fnl_camera camera; /* projection, and the pose of free cameras */
    double place[3];   /* camera.position, independent of the origin; unused with a node */
    char *own_name;    /* `name` where a call gave it, or NULL */
    bool removed;
};

/* A variant of materials (fnl_scene_select_variant). */
struct scene_variant {
    const char *name, *extras;
    uint32_t first; /* of the variants of its file */
    bool removed;
};

/* XMP (KHR_xmp_json_ld). */
struct scene_packet {
    const char *text, *about; /* JSON, or NULL: broken; JSON pointers, or "" */
};

struct scene_extension {
    const char *name, *treatment;
    bool required;
};

/** What a scene was read from. */
struct scene_source {
    const char *uri;  /* as it stands in the file; NULL: the file itself */
    const char *path; /* NULL: a resolver gave it */
    const unsigned char *data; /* NULL: it is missing */
    uint64_t size;
};

/** Arrays of a scene whose elements can be removed. A removed element leaves a hole; the indices of public calls skip holes. */
enum scene_pool {
    SCENE_IMAGES,
    SCENE_SAMPLERS,
    SCENE_MATERIALS,
    SCENE_PRIMITIVES,
    SCENE_MESHES,
    SCENE_NODES,
    SCENE_SKINS,
    SCENE_ANIMATIONS,
    SCENE_LIGHTS,
    SCENE_CAMERAS,
    SCENE_DECALS,
    SCENE_PROBES,
    SCENE_VARIANTS,
    SCENE_PROFILES,
    SCENE_POOLS
};

/** The file of fnl_scene_load as it is stored; what it refers to is in fnl_scene.sources. For fnl_scene_save. */
struct scene_document {
    const unsigned char *bytes; /* NULL: the scene came from no file */
    size_t size;
    bool lenient;
    struct scene_buffer {
        const unsigned char *data; /* NULL: missing */
        uint64_t size;
    } *buffers;
    uint32_t buffer_count;
    uint32_t counts[SCENE_POOLS]; /* elements of the file: the first of each array. Their indices are never reused, because saving relies on them */
};

/** What scene_set_stage() has added. Its mesh and material are holes in the scene's arrays. */
struct scene_stage {
    uint32_t node, mesh, material; /* of the floor; SCENE_NONE: it was never shown */
    fnl_ground ground;
    uint64_t placed_version; /* structure_version for which the floor has its place; UINT64_MAX: none */
    enum stage_light { STAGE_NO_LIGHT, STAGE_FILL, STAGE_STUDIO } light;
    struct box bounds;                      /* of the scene, which its lights are spread over where the studio fills in */
    uint64_t bounds_version, light_version; /* of the scene, at which `bounds` and the fill's strength were found */
};

/**
 * A file that was loaded into the scene with fnl_scene_load_into (scene_part.c). Removing its root closes it: everything that only the file
 * uses is removed. Its meshes, materials, images and profiles stay until nothing outside the file uses any of them.
 */
struct scene_part {
    uint32_t root, generation;
    struct range blocks[SCENE_POOLS]; /* its elements, the root first among the nodes; indices are not reused before the file is gone */
    struct range files, resources, sources, messages, packets;
    struct arena arena; /* data of its elements */
    bool closed;
};

struct fnl_scene {
    fnl_host host;
    struct arena arena;
    char *source;                  /* path or builtin:… for messages */
    ARRAY(struct file_view) files; /* kept while images point into them; without an identity: bytes from memory or of a data URI */
    ARRAY(fnl_resource) resources; /* from a resolver; so too */
    ARRAY(struct scene_source) sources;
    struct scene_document document;

    ARRAY(struct scene_part) parts;
    atomic_uint readers; /* renderers that decode images in the background: files stay */
    ARRAY(struct scene_image) images;
    ARRAY(struct scene_sampler) samplers;
    ARRAY(struct scene_material) materials;
    ARRAY(struct scene_primitive) primitives;
    ARRAY(struct scene_mesh) meshes;
    ARRAY(struct scene_node) nodes;
    ARRAY(struct scene_skin) skins;
    ARRAY(struct scene_animation) animations;
    ARRAY(struct scene_light) lights; /* removed ones stay as holes and are reused */
    ARRAY(struct scene_decal) decals; /* so too */
    ARRAY(struct scene_painted) painted;
    ARRAY(struct scene_probe) probes; /* removed ones stay as holes and are reused */
    ARRAY(struct scene_camera) cameras;
    ARRAY(struct scene_variant) variants;
    ARRAY(struct scene_packet) packets;
    ARRAY(struct scene_extension) extensions;
    ARRAY(const char *) messages;

    double origin[3];        /* fnl_scene_set_origin: float positions are relative to it */
    uint64_t origin_version; /* transform_version of its last move; nodes moved at it may differ only in floats */

    vec3 ambient_sky, ambient_ground, background;
    struct scene_environment environment;
    struct scene_stage stage;
    float anisotropy;                           /* of mipmapped textures, 1 .. 16 */
    float texture_bias;                         /* levels of detail added to theirs, -16 .. 16 */
    float cutoff_roughness, cutoff_illuminance; /* of lights without a range; an illuminance of 0: automatic */
    struct scene_reach reach;
    uint32_t next_generation;
    uint32_t hull_plane_count; /* of all lights */

    /* A renderer remembers the versions it has seen. */
    uint64_t structure_version;     /* images, materials, meshes, nodes came, changed or went */
    ARRAY(uint32_t) edited; /* every node whose edited_version is above edited_since, once; nothing else has changed since then */
    uint64_t edited_since;
    uint64_t material_version;      /* … images, samplers and materials among them */
    uint64_t light_version;         /* lights, ambient */
    uint64_t light_set_version;     /* … at which all changed: re-read all */
    uint64_t sun_version;           /* … at which a directional light last came, changed or went */
    ARRAY(uint32_t) changed_slots;  /* every one whose changed_version is above changed_slots_since, once */
    uint64_t changed_slots_since;
    uint64_t decal_version;     /* decals; those that move with nodes follow transform_version besides */
    uint64_t probe_version;
    uint64_t transform_version; /* node transforms or morph weights */
    ARRAY(uint32_t) moved; /* every node whose moved_version is above moved_since; a renderer that saw less re-reads all */
    uint64_t moved_since;

    ARRAY(struct scene_levels) levels;
    ARRAY(struct light_profile) profiles;
    struct ranges profile_floats; /* on the device; 0 is none */
    uint64_t profile_version;
    ARRAY(struct scene_light_slot) light_slots;
    ARRAY(uint32_t) free_light_slots; /* a heap, the lowest first */
    uint32_t light_slot_end;          /* no light is in a place from here on */
    bool has_area_lights;             /* some light was an area light at some time */
    bool has_light_masks;             /* at some time a light or probe had a mask other than 255, a light a contact_scale other than 1, or an instance the light mask 0 */
    bool has_requested;               /* some light's shadow maps were drawn on request at some time */
    uint32_t shadow_requests;         /* numbers of requests that were given */
    ARRAY(uint32_t) suns;             /* directional lights, ascending: they have no slots */
    ARRAY(uint32_t) unlimited;        /* lights without a range, in any order */

    uint32_t hole_counts[SCENE_POOLS];
    struct ranges holes[SCENE_POOLS];        /* reusable holes; only `gaps` is used */
    ARRAY(uint32_t) free_nodes, free_lights; /* more reusable holes, in constant time: there may be many */
    uint64_t nodes_placed; /* by scene_move_nodes since the scene was made, also those that stayed where they were; tests count its work */
};

/* ---- building: used by the importer, the generators and the public calls ---- */

fnl_result scene_create(const fnl_host *host, const char *source, fnl_scene **out);
struct scene_material scene_material_default(void);
/** Whether it has more than glTF's core material with KHR_materials_ior and _specular. */
bool scene_material_layered(const struct scene_material *material);
/** Whether it has layers besides clearcoat and anisotropy. */
bool scene_material_layered_besides(const struct scene_material *material);
/** Whether what is behind shows through it, which makes it a layered one. */
bool scene_material_transmissive(const struct scene_material *material);
/** Of transmissive ones: whether a part lets through less than half, by a texture or as metal. */
bool scene_material_dark(const struct scene_material *material);
uint32_t scene_take_generation(fnl_scene *scene);
/** Takes the lowest run of `count` reusable holes; SCENE_NONE if there is none. */
uint32_t scene_take_holes(fnl_scene *scene, enum scene_pool pool, uint32_t count);
/** Records that an element was removed. */
void scene_leave_hole(fnl_scene *scene, enum scene_pool pool, uint32_t index);
/** Whether the index belongs to a file, and must not be reused before the file is gone. */
bool scene_is_reserved(const fnl_scene *scene, enum scene_pool pool, uint32_t index);
/** The index of a new element: a hole, or the end of the array, which is zeroed. SCENE_NONE if memory ran out. */
#define scene_take_place(scene, pool, array)                                                                                \
    scene_take_element(scene, pool, (void **)&(array)->data, &(array)->count, &(array)->capacity, sizeof *(array)->data)
uint32_t scene_take_element(fnl_scene *scene, enum scene_pool pool, void **data, uint32_t *count, uint32_t *capacity, size_t size);
struct scene_texture scene_texture_none(void);
/** The matrix of a texture: scaled, then turned counter-clockwise in a picture whose v points down, then moved. */
void scene_turn_texture(struct scene_texture *texture, const struct scene_texture_turn *turn);
/**
 * How the axes of a texture's picture lie to the tangents, which are those of scene_material.tangent_frame: rows of a 2x2 matrix, from x and y of its texels
 * to tangent and bitangent.
 */
void scene_texture_turn_of(const struct scene_material *material, enum scene_texture_slot slot, float out[4]);
/** The texture whose coordinates tangents are made by: of the normals, the coat's, or the anisotropy; NULL: none. */
const struct scene_texture *scene_tangent_texture(const struct scene_material *material);
/** After a change of a material: its copies that baked decals are painted on follow. `before`: what it was. */
fnl_result scene_repaint(fnl_scene *scene, uint32_t material, const struct scene_material *before);
/** Creates an image that owns `width` x `height` pixels and its name, "SOURCE: KIND". False if memory ran out. */
bool scene_image_create(const fnl_scene *scene, const char *kind, uint32_t width, uint32_t height, bool color, struct scene_image *out);
/**
 * Each returns the new index, or SCENE_NONE if memory ran out (logged). Data pointed to must live in scene->arena, or be owned by the element. An image's
 * memory passes to the scene even if the call fails; a mesh's stays with the caller then.
 */
uint32_t scene_add_image(fnl_scene *scene, const struct scene_image *image);
uint32_t scene_add_sampler(fnl_scene *scene, const struct scene_sampler *sampler);
uint32_t scene_add_material(fnl_scene *scene, const struct scene_material *material);
/** Adds a mesh of `count` primitives; computes their bounds. */
uint32_t scene_add_mesh(fnl_scene *scene, const char *name, const struct scene_primitive *primitives, uint32_t count);
/** A child of `parent` (SCENE_NONE: a root, whose matrix is relative to the origin) with a local matrix; active. */
uint32_t scene_add_node(fnl_scene *scene, const char *name, uint32_t parent, const mat4 *local, uint32_t mesh);
/** The same at a given index: a hole, or the end of the array, which has room. */
void scene_put_node(fnl_scene *scene, uint32_t index, const char *name, uint32_t parent, const mat4 *local, uint32_t mesh);
/** Call after a change of the structure that concerns more than a few nodes. */
void scene_structure_changed(fnl_scene *scene);
/** After a change of materials, samplers, or an image, whose `version` grows besides. */
void scene_materials_changed(fnl_scene *scene);
uint32_t scene_add_light(fnl_scene *scene, const fnl_light_params *params, uint32_t node);
/** Stores a light at an index: a hole, or one that scene_reserve_lights() made room for. */
void scene_put_light(fnl_scene *scene, uint32_t index, const fnl_light_params *params, uint32_t node);
/** Floats of all profiles: shaders know a place by a float. */
enum { SCENE_PROFILE_FLOATS_MAX = 1 << 24, SCENE_PROFILE_BYTES_MOST = 361 * 360 * 4 };
/** Reads a light profile; `out` gets its id. */
fnl_result scene_add_profile(fnl_scene *scene, const fnl_host *host, const char *name, const void *data, size_t size, fnl_light_profile_id *out);
/** Stores a profile at an index; assigns its generation and its place on the device. */
void scene_place_profile(fnl_scene *scene, uint32_t index, const struct light_profile *profile);
/** A light's profile, or NULL. */
const struct light_profile *scene_light_profile(const fnl_scene *scene, const fnl_light_params *light);
/** Local lights of a scene: the device counts to the shape of each in bytes, with 32 bits. */
enum { SCENE_LOCAL_LIGHTS_MAX = 48000000 };
/**
 * Makes room for `count` lights to come, or to become local or directional: so many scene_add_light() cannot fail after it,
 * where nothing is removed. FNL_ERROR_UNSUPPORTED, with a log line, where they could be more than SCENE_LOCAL_LIGHTS_MAX.
 */
fnl_result scene_reserve_lights(fnl_scene *scene, uint32_t count);
/** After a change of one light, of some, or of all. */
void scene_light_changed(fnl_scene *scene, uint32_t light);
void scene_lights_edited(fnl_scene *scene, const fnl_light_id *lights, uint32_t count);
void scene_lights_changed(fnl_scene *scene);
/** After nodes moved at a transform_version; and after a node, with what is below it, was hidden or shown: the lights that they carry. */
void scene_pose_lights(fnl_scene *scene, uint64_t version);
void scene_show_lights(fnl_scene *scene, uint32_t root);
/** Logs a warning and keeps it for `fanal info`. */
void scene_add_message(fnl_scene *scene, const char *format, ...) __attribute__((format(printf, 2, 3)));

/**
 * Recomputes world matrices, light poses and `moved` from the local transforms; call once after building.
 */
void scene_update_transforms(fnl_scene *scene);
/** Makes the local transform from translation, rotation and scale; replaces one set by a call. Updates nothing else. */
void scene_pose_node(struct scene_node *node);
/** After the morph weights of a node changed. */
void scene_weights_changed(fnl_scene *scene, uint32_t node);
/** Frees weights that are the node's own. */
void scene_free_weights(fnl_scene *scene, struct scene_node *node);
/**
 * Gives nodes new local transforms; of a node that stands there twice the last one counts. Costs what is below them, each
 * node once, and a look at the lights if one is linked.
 */
void scene_move_nodes(fnl_scene *scene, const fnl_instance_id *nodes, const mat4 *locals, uint32_t count);
/** Which decals a node receives. */
void scene_set_receivers(fnl_scene *scene, uint32_t node, uint32_t receivers);
/** Which cameras show it. */
void scene_set_view_mask(fnl_scene *scene, uint32_t node, uint32_t mask);
/** Sets has_light_masks if `used`; it is never unset. */
void scene_use_light_masks(fnl_scene *scene, bool used);
/** Which lights affect it. */
void scene_set_light_mask(fnl_scene *scene, uint32_t node, uint32_t mask);
/** Finds out which nodes of a tree are active. */
void scene_activate(fnl_scene *scene, uint32_t root);
/**
 * Appends what a file was loaded into, under a new node; `from` is then empty, and can only be destroyed. Both have the same
 * host. An error leaves both as they were.
 */
fnl_result scene_merge(fnl_scene *into, uint32_t parent, fnl_scene *from, fnl_loaded *out);
/** Bytes that images may point into, as into a file, which the caller fills; NULL: memory ran out. */
unsigned char *scene_keep_bytes(fnl_scene *scene, size_t size);
/** Call after a removal. Frees closed files that nothing uses any more. */
void scene_drop_parts(fnl_scene *scene);
/** Each removes an element that nothing uses. */
void scene_remove_mesh(fnl_scene *scene, uint32_t mesh);
void scene_remove_material(fnl_scene *scene, uint32_t material);
void scene_remove_image(fnl_scene *scene, uint32_t image);
void scene_remove_profile(fnl_scene *scene, uint32_t profile);
void scene_remove_camera(fnl_scene *scene, uint32_t camera);
void scene_remove_animation(fnl_scene *scene, uint32_t animation);
void scene_remove_decal(fnl_scene *scene, uint32_t decal);
void scene_remove_probe(fnl_scene *scene, uint32_t probe);
/** Hides a node with what is below it, or shows what is not hidden below it. */
void scene_show_node(fnl_scene *scene, uint32_t node, bool visible);
/** Removes a node, what is below it, and the lights there. */
fnl_result scene_remove_node(fnl_scene *scene, uint32_t node);
void scene_remove_light(fnl_scene *scene, uint32_t light);
/** Levels of detail of which the first is shown; copies the arrays. False: lack of memory. */
bool scene_add_levels(fnl_scene *scene, const uint32_t *nodes, const float *coverage, uint32_t count, bool of_mesh);
/** The part of the screen's height that the diameter of their sphere takes, 0 .. 1. */
float scene_levels_coverage(const fnl_scene *scene, const struct scene_levels *levels, const fnl_camera *camera);
/** Shows, of all levels, those that fit the size on the camera's screen. Costs what changes. */
void scene_choose_levels(fnl_scene *scene, const fnl_camera *camera);
/** Whether a node shows its mesh. */
static inline bool scene_node_draws(const struct scene_node *node) {
    return node->active && (!node->removed || node->staged) && !node->mesh_off && node->mesh != SCENE_NONE;
}
static inline bool scene_has_ambient(const fnl_scene *scene) {
    const vec3 a = scene->ambient_sky, b = scene->ambient_ground;
    return a.x > 0 || a.y > 0 || a.z > 0 || b.x > 0 || b.y > 0 || b.z > 0;
}
/** Whether a light shines, the stage's too. */
static inline bool scene_light_shines(const struct scene_light *light) { return !light->removed || light->staged; }
/**
 * Sets the stage of the next picture: the studio, whole where the scene has no light of its own, as a fill where it has nothing but lights; and
 * the floor. Costs nothing when it stays.
 */
fnl_result scene_set_stage(fnl_scene *scene, bool studio, fnl_ground ground);
/** The studio as the scene's environment, which has none of its own: whole, or without its key light; or none again. */
fnl_result scene_environment_stage(fnl_scene *scene, enum stage_light light);
/** Makes the environment as bright as the scene's lights are on average, which near ones spread over these bounds. */
void scene_environment_fill(fnl_scene *scene, const struct box *bounds);
/** After a change of what one node shows. */
void scene_node_edited(fnl_scene *scene, uint32_t node);
/** To the space of its parent; of a root relative to the origin. */
mat4 scene_node_local(const fnl_scene *scene, const struct scene_node *node);
/** World matrix of instance k of a node in doubles, and relative to the origin; meaningless for skinned nodes. */
struct affine scene_instance_exact(const struct scene_node *node, uint32_t k);
mat4 scene_instance_world(const fnl_scene *scene, const struct scene_node *node, uint32_t k);
/**
 * Sets the origin to the middle of the shown geometry's bounds, rounded to ORIGIN_STEP meters on each axis. Keeps
 * 0, 0, 0 if the middle is not far away, or if the scene is so large that an origin would not help. Call after loading,
 * before anything uses positions.
 */
void scene_find_origin(fnl_scene *scene);
/** World-space bounds of a tree, active or not; `alone`: of its root. */
struct box scene_tree_bounds(const fnl_scene *scene, uint32_t root, bool alone);
/** World-space bounds of all active instances (skinned meshes by their bind pose moved by the joints' boxes). */
struct box scene_bounds(const fnl_scene *scene);
/** Updates the reach of lights without a range, and marks lights whose reach changes. Free if nothing changed. */
void scene_follow_reach(fnl_scene *scene);
/** Illuminance at which lights without a range end in a scene with these bounds, lux; 0: they are unlimited. */
double scene_light_threshold(const fnl_scene *scene, const struct box *bounds);
/** True if the light is on and has no range. */
bool light_is_unlimited(const struct scene_light *light);
/** Distance from which a light contributes nothing: its range or its reach, meters. */
float light_effective_range(const struct scene_light *light);
/** `up` at right angles to a unit direction, unit; where it is parallel, another axis. */
vec3 light_up(vec3 direction, vec3 up);

/** The hull of 4 .. 64 finite points; FNL_ERROR_INVALID (logged) when they have no volume. Freed by light_hull_free. */
fnl_result light_hull_create(const fnl_host *host, const vec3 *points, uint32_t count, struct light_hull **out);
/** Takes a light's hull away, if it has one. */
void light_hull_free(fnl_scene *scene, struct scene_light *light);

/** Of checked ones; SCENE_NONE without memory. */
bool scene_has_reflections(const fnl_scene *scene);
fnl_result scene_check_probe(const struct call *call, const fnl_probe_params *params);
uint32_t scene_add_probe(fnl_scene *scene, const fnl_probe_params *params);
/** A checked decal; `node` as in struct scene_decal. SCENE_NONE when memory ran out or it cannot be painted (logged). */
uint32_t scene_add_decal(fnl_scene *scene, const fnl_decal_params *params, uint32_t node);
/** Whether it is there and what it is on too; whether that is shown besides. */
bool decal_exists(const fnl_scene *scene, const struct scene_decal *decal);
bool decal_shows(const fnl_scene *scene, const struct scene_decal *decal);
/** Whether numbers are in their ranges; logged. Instance and pictures are left to the caller. */
fnl_result decal_check(const struct call *call, const fnl_decal_params *params);
/** Whether a camera can be used; `prefix` stands before the names of its fields, such as "camera.". */
fnl_result camera_check(const struct call *call, const char *prefix, const fnl_camera *camera);
/** The argument `transform`, or an element of `transforms`. */
fnl_result scene_check_affine(const struct call *call, const fnl_mat4 *transform);
/** Number of entities of a kind; the array element of a public index; and the public index of an array element. */
uint32_t scene_entity_count(const fnl_scene *scene, fnl_entity kind);
uint32_t scene_entity_slot(const fnl_scene *scene, fnl_entity kind, uint32_t index);
uint32_t scene_entity_index(const fnl_scene *scene, fnl_entity kind, uint32_t slot);
/** Check an id that was passed to a public function; `or_none`: all-zero is allowed. */
fnl_result scene_check_image(const struct call *call, const fnl_scene *scene, const char *name, fnl_image_id id, bool or_none);
fnl_result scene_check_material(const struct call *call, const fnl_scene *scene, fnl_material_id id, bool or_none);
fnl_result scene_check_mesh(const struct call *call, const fnl_scene *scene, fnl_mesh_id id);
/** The id of an element; all-zero for SCENE_NONE. */
fnl_image_id scene_image_id(const fnl_scene *scene, uint32_t image);
fnl_material_id scene_material_id(const fnl_scene *scene, uint32_t material);
/** A camera in its current pose. */
void scene_camera_pose(const fnl_scene *scene, const struct scene_camera *camera, fnl_camera *out);
/** The argument `instance` of a public function. */
fnl_result scene_check_instance(const struct call *call, const fnl_scene *scene, fnl_instance_id id);
/** From the unit cube to the world, or for mesh, redraw and baked decals to the space of their mesh. */
mat4 decal_transform(const fnl_scene *scene, const struct scene_decal *decal);
/** An index of a picture; SCENE_NONE: none. */
static inline uint32_t decal_image(fnl_image_id id) { return id.generation ? id.index : SCENE_NONE; }
/** Call after nodes were removed. Removes the meshes, materials and images that were painted for them. */
void decal_forget_removed(fnl_scene *scene);
/** Paints all baked decals of a node into copies of its textures, or shows it as it was when there are none left (decal_bake.c). */
fnl_result decal_bake(fnl_scene *scene, uint32_t node);
/** Whether the unit cube around the origin touches a triangle. */
bool decal_touches(const vec3 corners[3]);
/** The pictures of graffiti, cracks and footprints as decals that only lack a place (builtin_decal.c). */
enum { SCATTER_DECAL_KINDS = 8 };
fnl_result decal_prototypes(fnl_scene *scene, uint64_t seed, fnl_decal_params out[SCATTER_DECAL_KINDS]);

/* ---- the parts ---- */

/** Loads a .gltf or .glb file (gltf.c). `params` NULL: defaults. */
fnl_result gltf_load(const fnl_host *host, const char *path, const fnl_load_params *params, fnl_scene **out);
/** Loads from memory, which is copied. */
fnl_result gltf_load_memory(const fnl_host *host, const void *bytes, size_t size, const char *name,
                            const fnl_load_params *params, fnl_scene **out);
/** Makes "builtin:NAME?…" (builtin.c); the text after the colon is given. */
fnl_result builtin_load(const fnl_host *host, const char *text, fnl_scene **out);

/**
 * Fills in what a triangle primitive lacks (mesh_build.c): indices, flat normals (vertices are split where faces meet),
 * tangents where there are uvs (mesh_tangents.c; vertices are split where they differ), and with flat normals those of morph targets. The arrays may be replaced; new ones
 * come from `arena`.
 */
fnl_result mesh_complete(struct arena *arena, struct scene_primitive *primitive);
/** The same with tangents by one set of texture coordinates, times the rows of a 2x2 matrix (NULL: as they are). */
fnl_result mesh_complete_by(struct arena *arena, struct scene_primitive *primitive, uint32_t set, const float *turn);
/** The most memory that mesh_complete may hold at once for it, what stays included; and what one vertex of it takes as it is. */
uint64_t mesh_complete_bytes(const struct scene_primitive *primitive);
/** Of that: the normals and tangents of morph targets. */
uint64_t mesh_made_target_bytes(const struct scene_primitive *primitive);
uint64_t mesh_vertex_bytes(const struct scene_primitive *primitive);
struct box primitive_bounds(const struct scene_primitive *primitive);
/** scene_primitive.leans. */
bool primitive_leans(const struct scene_primitive *primitive);

/** Sets what an animation sets, at a time (animation.c); then scene_update_transforms. */
fnl_result animation_apply(fnl_scene *scene, uint32_t animation, double seconds);
/** A property gets `width` values (animation_property.c); after all of them the second tells the lights and materials. */
void animation_set_property(fnl_scene *scene, const struct scene_channel *channel, const float *values);
fnl_result animation_finish_properties(fnl_scene *scene, const struct scene_animation *animation);
/** joint matrices = inverse(world of mesh node) is NOT applied: world(joint) * inverse_bind, as glTF says. */
void skin_matrices(const fnl_scene *scene, uint32_t skin, mat4 *out);
/** Whether the joints mirror the node's mesh: most of its vertices, where they do not agree. Its triangles then wind the other way. */
bool skin_mirrors(const fnl_scene *scene, const struct scene_node *node);
/**
 * Skinned vertices are drawn as an instance: not moved, or, if the joints mirror them, mirrored in x, which skin_instance_matrices takes back. What holds
 * for mirrored instances (windings, normals, tangents) then holds for skins.
 */
mat4 skin_instance(bool mirrored);
void skin_instance_matrices(const fnl_scene *scene, uint32_t skin, bool mirrored, mat4 *out);

#endif
