/* SPDX-License-Identifier: MIT */
/**
 * Scenes: loaded from glTF, made by built-in generators, or put together by calls. A scene lives in host memory and
 * needs no device; one scene may be rendered by several renderers. Calls on one scene are not thread-safe.
 *
 * Units are glTF's: metres, radians, candela (lights that spread), lux (directional and box). Right-handed, +Y up.
 */
#ifndef FANAL_SCENE_H
#define FANAL_SCENE_H

#include "fanal/base.h"
#include "fanal/values.h"
#include "fanal/image.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct fnl_scene fnl_scene;

/** Ids: an index and a generation, so that the id of something that was removed is recognised. All-zero is "none". */
typedef struct fnl_image_id {
    uint32_t index, generation;
} fnl_image_id;
typedef struct fnl_material_id {
    uint32_t index, generation;
} fnl_material_id;
typedef struct fnl_mesh_id {
    uint32_t index, generation;
} fnl_mesh_id;
typedef struct fnl_instance_id {
    uint32_t index, generation;
} fnl_instance_id;
typedef struct fnl_light_id {
    uint32_t index, generation;
} fnl_light_id;
typedef struct fnl_decal_id {
    uint32_t index, generation;
} fnl_decal_id;

/** An empty scene. `host` may be NULL. */
FNL_API fnl_result fnl_scene_create(const fnl_host *host, fnl_scene **out);
/** Bytes that a resolver hands over. They belong to the caller, and are only read. */
typedef struct fnl_resource {
    const void *data; /**< NULL only with size 0 */
    size_t size;      /**< bytes */
    /** Called once, with `user`, `data` and `size`, when the bytes are no longer needed. NULL: no call. */
    void (*release)(void *user, const void *data, size_t size);
    void *user;
} fnl_resource;

/** How files are loaded; built-in scenes ignore all of it. */
typedef struct fnl_load_params {
    /**
     * Loads what can be shown of a file that would otherwise be refused, with a warning for what is left out: a file that
     * requires a material extension, whose materials are then shown by their core properties; a file whose data is missing;
     * or one that refers to files it may not read (they are not read). Default false.
     */
    bool lenient;
    /**
     * Refuses files outside the folder of the loaded one; otherwise they are read with a warning. Symbolic links are resolved
     * first. Absolute paths and "file:" are refused in any case. Default false.
     */
    bool confine;
    /**
     * Bytes that the file may take: files that it refers to, vertices, indices, animations, instances, embedded and
     * compressed data, and its pictures as RGBA8, counted before anything is allocated. A file that needs more is
     * FNL_ERROR_MEMORY. The loaded file itself, what jansson makes of its JSON, and the memory of a device are not counted.
     * UINT64_MAX: no limit. Default: half of the machine's memory.
     */
    uint64_t max_memory;
    /**
     * Supplies the bytes of a `uri` in the file. If set, Fanal opens no file except the loaded one, and `confine` has no
     * effect. `uri` is the text in the file, still percent-encoded, and lives as long as the call; "data:" URIs are not
     * asked for. Called during the loading call, on its thread, for one URI after the other, and for the same URI as often
     * as the file names it.
     *
     * On FNL_OK `out`, initially all zero, says where the bytes are. They must stay unchanged until `release`, because
     * pictures are decoded from them when a renderer needs them, on any thread. `release` is called during the loading call
     * if that fails, otherwise during fnl_scene_destroy. Any other result means that the resource is missing, and nothing is
     * released; FNL_ERROR_MEMORY ends the load. The callback must not use the scene. Default NULL.
     */
    fnl_result (*resolve)(void *user, const char *uri, fnl_resource *out);
    /**
     * Called on the thread that loads, before the first part of the file, after each one, and at the end, when `done` is `total`: files that it
     * refers to, images (which are not decoded here), meshes, animations, and a few others. Returns whether to go on; false ends
     * the load with FNL_ERROR_CANCELLED, and nothing of it stays. Default NULL.
     */
    bool (*progress)(void *user, uint32_t done, uint32_t total);
    void *user; /**< for `resolve` and `progress`; default NULL */
    /**
     * The bytes of a .gltf or .glb file, which are copied. The source then only stands for the file in messages, and there is no
     * folder: what the file refers to comes from `resolve`, or is an error. Default NULL, 0: the file is read.
     */
    const void *data;
    size_t size; /**< bytes of `data` */
} fnl_load_params;

FNL_API fnl_load_params fnl_load_params_default(void);
/**
 * Loads `source`: the path of a .gltf or .glb file, or "builtin:NAME?key=value&key=value" (docs/cli.md lists them). `params`
 * NULL: defaults. On failure `*out` is NULL and the log says which file, where in it, and what is wrong.
 */
FNL_API fnl_result fnl_scene_load(const fnl_host *host, const char *source, const fnl_load_params *params, fnl_scene **out);
FNL_API void fnl_scene_destroy(fnl_scene **scene);

/* ---- images and materials ---- */

/** Adds a copy of an RGBA8 picture. `color`: its RGB is sRGB-encoded (base colour, emission), else linear data. */
FNL_API fnl_result fnl_scene_add_image(fnl_scene *scene, const fnl_image *image, bool color, fnl_image_id *out);

typedef enum fnl_alpha_mode { FNL_ALPHA_OPAQUE = 0, FNL_ALPHA_MASK, FNL_ALPHA_BLEND } fnl_alpha_mode;

/** A glTF 2.0 metallic-roughness material. Textures multiply their factors; an all-zero id is no texture. */
typedef struct fnl_material_params {
    float base_color[4];       /**< linear RGB and alpha, 0..1; default 1, 1, 1, 1 */
    float metallic;            /**< 0..1; default 1 */
    float roughness;           /**< perceptual roughness, 0..1; default 1 */
    float emissive[3];         /**< cd/m^2 (strength included), >= 0; default 0 */
    float normal_scale;        /**< scales the normal map's x and y; default 1 */
    float occlusion_strength;  /**< 0..1; default 1 */
    float ior;                 /**< index of refraction of the dielectric part, >= 1, or 0 for none; default 1.5 */
    float specular;            /**< strength of the dielectric specular part, 0..1; default 1 */
    float specular_color[3];   /**< linear F0 tint of the dielectric part, >= 0; default 1 */
    fnl_alpha_mode alpha_mode; /**< default opaque */
    float alpha_cutoff;        /**< for FNL_ALPHA_MASK; default 0.5 */
    bool double_sided;         /**< default false */
    bool unlit;                /**< the base colour is shown without lighting; default false */
    fnl_image_id base_color_image, metallic_roughness_image, normal_image, occlusion_image, emissive_image;
} fnl_material_params;

FNL_API fnl_material_params fnl_material_params_default(void);
FNL_API fnl_result fnl_scene_add_material(fnl_scene *scene, const fnl_material_params *params, fnl_material_id *out);
/**
 * Changes a material, including one from a file (fnl_scene_query_material returns its current values). A texture whose image
 * stays the same keeps its coordinates and filters; specular textures, which are not in fnl_material_params, stay as they
 * are. Renderers upload the material, and an image that none used before, but go through all instances to sort them again.
 */
FNL_API fnl_result fnl_scene_set_material(fnl_scene *scene, fnl_material_id material, const fnl_material_params *params);

/**
 * Grows the metallic areas of metallic-roughness textures by `texels` (0 .. 64). At the border of a metal the mask is
 * blurred over a texel; there a bright base colour is shaded as half a dielectric, which shows as a bright halo. Growing the
 * metal beyond its colour avoids that. Call it before the scene is rendered.
 */
FNL_API fnl_result fnl_scene_grow_metal(fnl_scene *scene, uint32_t texels);

/* ---- meshes and instances ---- */

/** Triangles with one material. Arrays are copied. Missing normals and tangents are generated. */
typedef struct fnl_mesh_params {
    uint32_t vertex_count;    /**< 1 .. 2^32 - 2 */
    uint32_t index_count;     /**< a multiple of 3; 0: vertices are used in order */
    const float *positions;   /**< 3 per vertex, metres, finite; required */
    const float *normals;     /**< 3 per vertex, unit, or NULL: flat normals are generated */
    const float *tangents;    /**< 4 per vertex, unit xyz and handedness +1 or -1, or NULL */
    const float *uv;          /**< 2 per vertex, or NULL */
    const float *colors;      /**< 4 per vertex, linear, multiply the base colour, or NULL */
    const uint32_t *indices;  /**< each below vertex_count, or NULL with index_count 0 */
    fnl_material_id material; /**< all-zero: glTF's default material */
} fnl_mesh_params;

FNL_API fnl_result fnl_scene_add_mesh(fnl_scene *scene, const fnl_mesh_params *params, fnl_mesh_id *out);

/** Places a mesh. `transform` is affine, finite, and may mirror. */
FNL_API fnl_result fnl_scene_add_instance(fnl_scene *scene, fnl_mesh_id mesh, const fnl_mat4 *transform,
                                          fnl_instance_id *out);
/**
 * In a file, every node is an instance: the transform is relative to the parent node, and everything below moves along, as
 * do lights, cameras, decals and skins that follow those nodes. The transform holds until fnl_scene_set_time is called with
 * an animation of this very node, which sets translation, rotation and scale from the animation, and those that are not
 * animated from the file.
 */
FNL_API fnl_result fnl_scene_set_instance_transform(fnl_scene *scene, fnl_instance_id instance, const fnl_mat4 *transform);
/**
 * Hides an instance with everything below it, including lights and decals, or shows it again if nothing above it is hidden.
 * Nodes of a file that are hidden (KHR_node_visibility) or in none of the scenes shown begin hidden. A skin is shown with the
 * node of its mesh, wherever its joints are. Renderers upload a few bytes per instance, but go through all of them to sort them again.
 */
FNL_API fnl_result fnl_scene_set_instance_visible(fnl_scene *scene, fnl_instance_id instance, bool visible);
/**
 * Removes an instance with everything below it, including lights. Cameras below it stay where they are, as do joints of the
 * skins of other nodes; decals below it are no longer shown. All other ids stay valid.
 */
FNL_API fnl_result fnl_scene_remove_instance(fnl_scene *scene, fnl_instance_id instance);

/* ---- lights ---- */

typedef enum fnl_light_kind {
    FNL_LIGHT_DIRECTIONAL = 0, /**< parallel light everywhere */
    FNL_LIGHT_POINT,           /**< from a point in all directions, up to a range */
    FNL_LIGHT_SPOT,            /**< from a point into a round cone */
    FNL_LIGHT_CAPSULE,         /**< a tube: each point is lit from the nearest point of a segment */
    FNL_LIGHT_WEDGE,           /**< from a point into a pyramid of rectangular cross-section */
    FNL_LIGHT_BOX,             /**< parallel light that fills an oriented box and nothing else */
    FNL_LIGHT_KIND_COUNT
} fnl_light_kind;

typedef struct fnl_light_params {
    fnl_light_kind kind; /**< default point */
    fnl_vec3 position;   /**< metres; apex of spots and wedges, middle of capsules and boxes; not for directional lights */
    /** Where the light shines to; for capsules, along the segment. Normalised by the call. Default 0, 0, -1. Not for points. */
    fnl_vec3 direction;
    float color[3];  /**< linear RGB, >= 0; default 1 */
    float intensity; /**< candela, or lux for directional lights and boxes, >= 0; default 1 */
    /**
     * Distance from the position (capsules: from the segment) beyond which the light contributes exactly zero, metres, > 0;
     * INFINITY (the default) derives it from the intensity (fnl_light_range). Not for directional lights and boxes.
     */
    float range;
    float inner_cone_angle; /**< half angle of full intensity, radians, 0 .. outer; default 0 */
    float outer_cone_angle; /**< half angle beyond which there is no light, radians, up to pi/2; default pi/4 */
    /**
     * Wedges and boxes: the direction of their height. The call makes it a unit vector perpendicular to `direction`; if the
     * two are parallel, it chooses another. The width lies along direction x up. Default 0, 1, 0.
     */
    fnl_vec3 up;
    float length;          /**< capsules: length of the segment, which is centred on the position, metres, >= 0; default 1 */
    float wedge_angles[2]; /**< wedges: half angles across the width and the height, radians, 0 .. 1.5; default pi/4, pi/6 */
    fnl_vec3 box_size;     /**< boxes: width, height and depth (along the direction), metres, > 0; default 1 */
    /** Wedges and boxes: full intensity up to this fraction of the way from the axis to the edge, then a fade to zero at the
        edge, 0 .. 1; default 0.7. */
    float inner_fraction;
} fnl_light_params;

FNL_API fnl_light_params fnl_light_params_default(void);
FNL_API fnl_result fnl_scene_add_light(fnl_scene *scene, const fnl_light_params *params, fnl_light_id *out);
/**
 * A light of a file follows its node. It keeps following if position, direction and up (those that its kind has) are the
 * values that fnl_scene_query_light returned; any other pose detaches it from its node, and it stays where it was put.
 */
FNL_API fnl_result fnl_scene_set_light(fnl_scene *scene, fnl_light_id light, const fnl_light_params *params);
FNL_API fnl_result fnl_scene_remove_light(fnl_scene *scene, fnl_light_id light);

/**
 * Clips a light to the convex hull of `count` (4 .. 64) world-space points: outside the hull it contributes exactly zero, as
 * it does outside its own volume. The hull does not move with the light. NULL and 0 remove it. Points that lie in one plane,
 * on one line or at one place are an error (logged) and change nothing. Directional lights ignore their hull.
 */
FNL_API fnl_result fnl_scene_set_light_hull(fnl_scene *scene, fnl_light_id light, const fnl_vec3 *points, uint32_t count);

/**
 * Distance in metres beyond which a light contributes exactly zero. That is its range if finite; for a box, half its
 * diagonal. Otherwise it is sqrt(I g / threshold), where I is the intensity times the brightest colour channel: the distance
 * at which the light adds less than `threshold` / pi cd/m^2 (`threshold` in lux, > 0) to the brightest possible surface of
 * roughness `min_roughness` (0 .. 1). g = max(1, 1 / (4 alpha^2)) with alpha = max(min_roughness^2, 0.001) is the ratio of a
 * white metal's largest BRDF value seen head-on, 1 / (4 pi alpha^2), to that of a white matt surface, 1/pi. The smoother the
 * surfaces, the farther lights reach: sharp highlights are visible long after diffuse light is not. INFINITY for directional
 * lights; 0 (logged) for NULL.
 */
FNL_API float fnl_light_range(const fnl_light_params *params, float min_roughness, float threshold);
/**
 * Sets the arguments of fnl_light_range for lights whose range is INFINITY: the lowest roughness whose highlights must not
 * be cut off, 0 .. 1 (default 1), and the threshold in lux, > 0 (default 0.05).
 */
FNL_API fnl_result fnl_scene_set_light_cutoff(fnl_scene *scene, float min_roughness, float threshold);

/**
 * Adds `count` lights at pseudo-random places within the scene's bounds, three points to one spot. Their radius follows from
 * the extent of the scene, so that a point of it lies in about 8 of them on average, whatever the count; their intensity
 * follows from the radius. The same scene, count and seed give the same lights.
 */
FNL_API fnl_result fnl_scene_scatter_lights(fnl_scene *scene, uint32_t count, uint64_t seed);

typedef struct fnl_scatter_params {
    uint32_t count; /**< number of lights; default 0 */
    uint64_t seed;  /**< default 1 */
    /** Relative number of each kind, >= 0; default 3 points, 1 spot. Directional lights cannot be scattered. */
    float shares[FNL_LIGHT_KIND_COUNT];
    float radius_scale; /**< multiplies the radius that fnl_scene_scatter_lights would choose, > 0; default 1 */
} fnl_scatter_params;

FNL_API fnl_scatter_params fnl_scatter_params_default(void);
/** As fnl_scene_scatter_lights, with lights of all shapes. With the default shares and scale it adds exactly the same lights. */
FNL_API fnl_result fnl_scene_scatter_light_shapes(fnl_scene *scene, const fnl_scatter_params *params);

/* ---- decals ---- */

/** How a decal finds the surface that it changes. docs/techniques/decals.md says when to use which. */
typedef enum fnl_decal_kind {
    FNL_DECAL_BOX = 0, /**< projected along the box's -Z onto whatever is in the box */
    FNL_DECAL_VOLUME,  /**< a 3D picture, stored as a stack of slices: a surface shows the texel at its position (marble, a cut) */
    FNL_DECAL_MESH,    /**< on one instance, in the space of its undeformed mesh: it stretches and moves with the skin */
    FNL_DECAL_REDRAW,  /**< draws the triangles of one instance that the box touches again, over the instance, and lights them separately */
    FNL_DECAL_BAKED,   /**< painted into copies of one instance's textures when it is added: costs nothing per frame */
    FNL_DECAL_KIND_COUNT
} fnl_decal_kind;

/** How a decal's colour `c` combines with the surface's base colour `b`. The result is mixed with `b` by the decal's alpha. */
typedef enum fnl_decal_blend {
    FNL_DECAL_BLEND_ALPHA = 0, /**< c */
    FNL_DECAL_BLEND_MULTIPLY,  /**< b c */
    FNL_DECAL_BLEND_ADD,       /**< b + c, at most 1 */
    FNL_DECAL_BLEND_SCREEN,    /**< b + c - b c */
    FNL_DECAL_BLEND_OVERLAY,   /**< 2 b c where b < 1/2, else 1 - 2 (1 - b) (1 - c) */
    FNL_DECAL_BLEND_COUNT
} fnl_decal_blend;

/** Which properties of the surface a decal changes; bits. */
typedef enum fnl_decal_channel {
    FNL_DECAL_COLOR = 1,  /**< by itself: a tattoo */
    FNL_DECAL_NORMAL = 2, /**< by itself: an embossing */
    FNL_DECAL_ROUGHNESS = 4,
    FNL_DECAL_METALLIC = 8,
    FNL_DECAL_EMISSION = 16,
    FNL_DECAL_ALL = 31 /**< a sticker */
} fnl_decal_channel;

typedef struct fnl_decal_params {
    fnl_decal_kind kind; /**< default box */
    /**
     * From the unit cube (-1/2 .. 1/2) to the world, or to the space of `instance` if there is one: affine and invertible,
     * may mirror. The picture lies in the cube's xy plane, +Y up, and faces +Z. Default: identity.
     */
    fnl_mat4 transform;
    /** Mesh, redraw and baked decals: the instance that they are on. Box and volume decals: the instance that they move
        with; all-zero (default): none. */
    fnl_instance_id instance;
    float color[4];     /**< linear RGB and alpha, 0..1, multiplied with the picture; default 1 */
    float metallic;     /**< 0..1; default 0 */
    float roughness;    /**< 0..1; default 0.5 */
    float normal_scale; /**< scales the normal map's x and y; default 1 */
    float emissive[3];  /**< cd/m^2, >= 0; default 0 */
    fnl_image_id color_image, normal_image, metallic_roughness_image, emissive_image; /**< all-zero (default): none */
    uint32_t channels;     /**< fnl_decal_channel bits; default colour, roughness and metallic */
    fnl_decal_blend blend; /**< default alpha */
    bool flatten;     /**< the normal map replaces the normal map of the surface instead of adding to it; default false */
    int32_t sort_key; /**< decals are applied by ascending key, those with equal keys in the order they were added; default 0 */
    /**
     * The decal fades by the angle between the surface normal and the box's +Z, radians, 0 .. pi: full strength up to
     * fade_start, nothing from fade_end (>= fade_start) on. Default 65 and 85 degrees, because the picture would smear into
     * streaks on faces seen edge-on. Not for volume decals.
     */
    float fade_start, fade_end;
    /** 8 bits. The decal applies to instances that share a bit with it (fnl_scene_set_instance_receivers); default 255. */
    uint32_t receivers;
    bool distance_field; /**< the picture's alpha is a distance field, with the edge at `cut`; default false */
    float cut;           /**< 0..1; default 0.5 */
    uint32_t slices;     /**< volume decals: number of slices stacked in each image, the topmost at +Z, 1 .. 4096; default 1 */
} fnl_decal_params;

FNL_API fnl_decal_params fnl_decal_params_default(void);
FNL_API fnl_result fnl_scene_add_decal(fnl_scene *scene, const fnl_decal_params *params, fnl_decal_id *out);
/** Cannot change the kind, nor the instance unless it is a box or volume decal. A baked decal is painted again. */
FNL_API fnl_result fnl_scene_set_decal(fnl_scene *scene, fnl_decal_id decal, const fnl_decal_params *params);
FNL_API fnl_result fnl_scene_remove_decal(fnl_scene *scene, fnl_decal_id decal);
/**
 * Sets which decals an instance receives: those that share a bit with `receivers` (8 bits; initially 255). 0: none. Renderers
 * go through all instances to sort them again.
 */
FNL_API fnl_result fnl_scene_set_instance_receivers(fnl_scene *scene, fnl_instance_id instance, uint32_t receivers);
/**
 * Adds `count` box decals (graffiti, cracks, footprints, made by the library) at pseudo-random places on the scene's
 * surfaces, or fewer if it finds too few surfaces. The same scene, count and seed give the same decals.
 */
FNL_API fnl_result fnl_scene_scatter_decals(fnl_scene *scene, uint32_t count, uint64_t seed);

/** Ambient light, cd/m^2: `sky` from +Y, `ground` from -Y, blended by the y component of the normal. Default 0. */
FNL_API fnl_result fnl_scene_set_ambient(fnl_scene *scene, fnl_vec3 sky, fnl_vec3 ground);
/** Radiance where no surface is visible, cd/m^2. Default 0. */
FNL_API fnl_result fnl_scene_set_background(fnl_scene *scene, fnl_vec3 radiance);
/** Maximum anisotropy of mipmapped textures, 1 .. 16, clamped to what the device supports; default 8. */
FNL_API fnl_result fnl_scene_set_anisotropy(fnl_scene *scene, float anisotropy);

/* ---- time ---- */

/**
 * Poses the scene at `seconds` of animation `animation` (clamped to its ends). The index must be below the animation
 * count; a scene without animations accepts index 0 and ignores it.
 */
FNL_API fnl_result fnl_scene_set_time(fnl_scene *scene, uint32_t animation, double seconds);

/* ---- cameras ---- */

typedef struct fnl_camera {
    fnl_vec3 position;     /**< metres */
    fnl_vec3 target;       /**< a point that it looks at; must differ from the position */
    fnl_vec3 up;           /**< default 0, 1, 0 */
    bool orthographic;     /**< default false */
    float vertical_fov;    /**< radians, 0 .. pi; default 0.9 */
    float vertical_extent; /**< orthographic: height of the view in metres; default 10 */
    float near_distance;   /**< metres, > 0; default 0.05 */
    float far_distance;    /**< orthographic only, metres, > near_distance; perspective views reach to infinity; default 1000 */
    fnl_vec2 shift;        /**< off-axis projection: shifts the picture, in half widths and half heights; default 0 */
} fnl_camera;

FNL_API fnl_camera fnl_camera_default(void);
/** Queries a camera by index, in the order of the file. Its pose follows its node. */
FNL_API fnl_result fnl_scene_query_camera(const fnl_scene *scene, uint32_t index, fnl_camera *out);
FNL_API fnl_result fnl_scene_add_camera(fnl_scene *scene, const char *name, const fnl_camera *camera);
/** A camera from which the whole scene fits a picture of the given aspect (width / height). */
FNL_API fnl_result fnl_scene_query_framing_camera(const fnl_scene *scene, float aspect, fnl_camera *out);

/* ---- contents ---- */

typedef struct fnl_scene_info {
    uint64_t triangle_count;        /**< of all visible instances */
    uint64_t unique_triangle_count; /**< of all meshes, each counted once */
    uint64_t unique_vertex_count;
    uint32_t mesh_count, primitive_count, material_count, image_count, node_count;
    uint64_t instance_count; /**< visible instances that have a mesh */
    uint32_t light_count;    /**< of all kinds, including those of hidden nodes */
    uint32_t directional_count, point_count, spot_count, capsule_count, wedge_count, box_count;
    uint32_t decal_count; /**< of all kinds */
    uint32_t decal_kind_counts[FNL_DECAL_KIND_COUNT];
    uint32_t camera_count, animation_count, skin_count, extension_count, message_count;
    fnl_vec3 bounds_low, bounds_high; /**< metres; low > high for an empty scene */
} fnl_scene_info;

FNL_API fnl_result fnl_scene_query_info(const fnl_scene *scene, fnl_scene_info *out);

typedef struct fnl_image_info {
    const char *name;
    const char *file_kind;
    uint32_t width, height;
} fnl_image_info;
typedef struct fnl_animation_info {
    const char *name;
    double duration;
    uint32_t channel_count;
} fnl_animation_info;
typedef struct fnl_extension_info {
    const char *name;
    bool required;
    const char *treatment; /**< "full", "ignored", or what Fanal does instead */
} fnl_extension_info;

/** By index below the counts of fnl_scene_info; the strings live as long as the scene. */
FNL_API fnl_result fnl_scene_query_image(const fnl_scene *scene, uint32_t index, fnl_image_info *out);
FNL_API fnl_result fnl_scene_query_animation(const fnl_scene *scene, uint32_t index, fnl_animation_info *out);
FNL_API fnl_result fnl_scene_query_extension(const fnl_scene *scene, uint32_t index, fnl_extension_info *out);
/** Warnings of the import, in order, each with its JSON pointer. NULL if the index is out of range. */
FNL_API const char *fnl_scene_message(const fnl_scene *scene, uint32_t index);
FNL_API fnl_result fnl_scene_query_light(const fnl_scene *scene, uint32_t index, fnl_light_params *out);
FNL_API fnl_result fnl_scene_query_decal(const fnl_scene *scene, uint32_t index, fnl_decal_params *out);
FNL_API fnl_result fnl_scene_query_material(const fnl_scene *scene, uint32_t index, fnl_material_params *out);

typedef struct fnl_instance_info {
    fnl_mat4 transform;     /**< to the space of `parent` */
    fnl_mat4 world;         /**< to the world */
    fnl_instance_id parent; /**< all-zero: none */
    fnl_mesh_id mesh;       /**< all-zero: none */
    bool visible;           /**< as set by fnl_scene_set_instance_visible */
    bool shown;             /**< visible, and so are all instances above it */
} fnl_instance_info;

FNL_API fnl_result fnl_scene_query_instance(const fnl_scene *scene, uint32_t index, fnl_instance_info *out);

/** The kinds of things that a scene holds. */
typedef enum fnl_entity {
    FNL_ENTITY_INSTANCE = 0, /**< in files: every node, with or without a mesh */
    FNL_ENTITY_LIGHT,        /**< one per node that carries it; named after the light, or else after the node */
    FNL_ENTITY_DECAL,
    FNL_ENTITY_MESH,
    FNL_ENTITY_MATERIAL,
    FNL_ENTITY_IMAGE,
    FNL_ENTITY_CAMERA,
    FNL_ENTITY_ANIMATION,
    FNL_ENTITY_COUNT
} fnl_entity;

typedef struct fnl_entity_info {
    const char *name;   /**< "" if it has none; lives as long as the scene */
    const char *extras; /**< glTF's "extras" as JSON text, or NULL; lives as long as the scene */
    union {
        fnl_instance_id instance;
        fnl_light_id light;
        fnl_decal_id decal;
        fnl_mesh_id mesh;
        fnl_material_id material;
        fnl_image_id image;
    } id; /**< for the calls that change it; cameras and animations have no id, only an index */
} fnl_entity_info;

/**
 * Queries take an index, changes take an id. Indices are 0 .. fnl_scene_count - 1, in the order of the file and then of the
 * calls that added. Removing something moves the indices behind it down; ids never change. Returns 0 for a kind out of range
 * (logged).
 */
FNL_API uint32_t fnl_scene_count(const fnl_scene *scene, fnl_entity kind);
FNL_API fnl_result fnl_scene_query_entity(const fnl_scene *scene, fnl_entity kind, uint32_t index, fnl_entity_info *out);
/** Finds the first entity with this name. FNL_ERROR_INVALID if there is none; the log then lists the existing names. */
FNL_API fnl_result fnl_scene_find(const fnl_scene *scene, fnl_entity kind, const char *name, uint32_t *out_index);

/** What came with a file: entities first[kind] .. first[kind] + count[kind] - 1 of each kind, until something is removed. */
typedef struct fnl_loaded {
    fnl_instance_id root; /**< a new instance without a mesh, the first of its kind, named after the source: all nodes of the file are below it */
    uint32_t first[FNL_ENTITY_COUNT], count[FNL_ENTITY_COUNT];
} fnl_loaded;

/**
 * Loads a .gltf or .glb file, not a built-in scene, into a scene that is there, under `parent` (all-zero: under nothing). What the scene has
 * keeps its ids and indices; ambient light and background stay as they are. `out` may be NULL. After an error the scene is as it was.
 */
FNL_API fnl_result fnl_scene_load_into(fnl_scene *scene, fnl_instance_id parent, const char *source, const fnl_load_params *params,
                                       fnl_loaded *out);

#ifdef __cplusplus
}
#endif
#endif
