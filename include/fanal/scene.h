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

/** Handles: an index and a generation, so that a handle of something removed is recognised. All-zero is "none". */
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
    /** Called once, with `user`, `data` and `size`, when nothing reads the bytes any more. NULL: no call. */
    void (*release)(void *user, const void *data, size_t size);
    void *user;
} fnl_resource;

/** How files are loaded; built-in scenes ignore all of it. */
typedef struct fnl_load_params {
    /**
     * Loads what can be shown of a file that would otherwise be refused, with a warning for what is left out: a file that requires
     * a material extension, whose materials are then shown by their core properties; a file whose data is missing; or one that
     * refers to files it may not read (they are not read). Default false.
     */
    bool lenient;
    /**
     * Refuses files outside the folder of the loaded one; otherwise they are read with a warning. Symbolic links are resolved
     * first. Absolute paths and "file:" are refused in any case. Default false.
     */
    bool confine;
    /**
     * Bytes that the file may take: files that it refers to, vertices, indices, animations, instances, embedded and compressed data, and its
     * pictures as RGBA8, counted before anything is allocated. A file that needs more is FNL_ERROR_MEMORY. The loaded file itself,
     * what jansson makes of its JSON, and the memory of a device are not counted. UINT64_MAX: no limit. Default: half of the
     * machine's memory.
     */
    uint64_t max_memory;
    /**
     * Hands over what a `uri` of the file stands for; when it is set, Fanal opens no file but the loaded one, and `confine`
     * has nothing to do. `uri` is the text in the file, still percent-encoded, and lives as long as the call; "data:" URIs
     * are not asked for. Called from within the loading call, on its thread, for one URI after the other, for the same one
     * as often as the file names it.
     *
     * On FNL_OK `out`, all zeros at first, says where the bytes are. They must neither change nor go until `release`, as
     * pictures are decoded from them when a renderer needs them, on any thread. `release` is called within the loading call
     * when it fails, else within fnl_scene_destroy. Any other result: the resource is missing, nothing is released;
     * FNL_ERROR_MEMORY ends the load. It must not use the scene. Default NULL.
     */
    fnl_result (*resolve)(void *user, const char *uri, fnl_resource *out);
    void *user; /**< for `resolve`; default NULL */
} fnl_load_params;

FNL_API fnl_load_params fnl_load_params_default(void);
/**
 * Loads `source`: the path of a .gltf or .glb file, or "builtin:NAME?key=value&key=value" (docs/cli.md lists them). `params`
 * NULL: defaults. On failure `*out` is NULL and the log says which file, where in it, and what is wrong.
 */
FNL_API fnl_result fnl_scene_load(const fnl_host *host, const char *source, const fnl_load_params *params, fnl_scene **out);
/**
 * Loads the bytes of a .gltf or .glb file, which are copied. `name` stands for the file in messages. There is no folder:
 * what the file refers to comes from `params->resolve`, or is an error.
 */
FNL_API fnl_result fnl_scene_load_memory(const fnl_host *host, const void *data, size_t size, const char *name,
                                         const fnl_load_params *params, fnl_scene **out);
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
    bool unlit;                /**< base colour is shown as it is; default false */
    fnl_image_id base_color_image, metallic_roughness_image, normal_image, occlusion_image, emissive_image;
} fnl_material_params;

FNL_API fnl_material_params fnl_material_params_default(void);
FNL_API fnl_result fnl_scene_add_material(fnl_scene *scene, const fnl_material_params *params, fnl_material_id *out);
/**
 * Changes a material, also one of a file (fnl_scene_query_material has what it is). Textures whose image stays keep their coordinates and
 * filters; specular textures, which fnl_material_params does not name, stay too. Renderers upload the scene again, except for its
 * images, so this is not a call for every frame.
 */
FNL_API fnl_result fnl_scene_set_material(fnl_scene *scene, fnl_material_id material, const fnl_material_params *params);

/**
 * Grows the metallic areas of metallic-roughness textures by `texels` (0 .. 64). At the border of a metal the mask is blurred over a texel; there
 * a bright base colour is shaded as half a dielectric, which shows as a bright halo. Growing the metal beyond its colour avoids it. To be called
 * before the scene is rendered.
 */
FNL_API fnl_result fnl_scene_grow_metal(fnl_scene *scene, uint32_t texels);

/* ---- meshes and instances ---- */

/** Triangles with one material. Arrays are copied. Missing normals and tangents are generated. */
typedef struct fnl_mesh_params {
    uint32_t vertex_count;    /**< 1 .. 2^32 - 2 */
    uint32_t index_count;     /**< a multiple of 3; 0: vertices are used in order */
    const float *positions;   /**< 3 per vertex, metres, finite; required */
    const float *normals;     /**< 3 per vertex, unit, or NULL: flat ones are made */
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
 * Instances of files are their nodes: the transform is to the space of the parent, and what is below moves along, as do lights, cameras,
 * decals and skins that follow the nodes. It holds until fnl_scene_set_time is called with an animation that moves this very node:
 * that gives it translation, rotation and scale of the animation and, for those that are not animated, of the file.
 */
FNL_API fnl_result fnl_scene_set_instance_transform(fnl_scene *scene, fnl_instance_id instance, const fnl_mat4 *transform);
/**
 * Hides an instance with all that is below it, lights and decals too, or shows it again where nothing above it is hidden. Nodes of a
 * file that are hidden (KHR_node_visibility) or in none of its shown scenes begin hidden. A skin is shown with the node of its mesh, wherever
 * its joints are. Renderers upload the scene anew, but for its images: not for every frame.
 */
FNL_API fnl_result fnl_scene_set_instance_visible(fnl_scene *scene, fnl_instance_id instance, bool visible);
/**
 * Removes an instance with all that is below it and the lights there. Cameras there stay where they are, as do joints for the skins of
 * other nodes; decals there show no more. Ids of all else stay valid.
 */
FNL_API fnl_result fnl_scene_remove_instance(fnl_scene *scene, fnl_instance_id instance);

/* ---- lights ---- */

typedef enum fnl_light_kind {
    FNL_LIGHT_DIRECTIONAL = 0, /**< parallel light everywhere */
    FNL_LIGHT_POINT,           /**< from a point to all sides, up to a range */
    FNL_LIGHT_SPOT,            /**< from a point into a round cone */
    FNL_LIGHT_CAPSULE,         /**< a tube: each point is lit from the nearest point of a segment */
    FNL_LIGHT_WEDGE,           /**< from a point into a pyramid of rectangular cross-section */
    FNL_LIGHT_BOX,             /**< parallel light that fills an oriented box and nothing else */
    FNL_LIGHT_KIND_COUNT
} fnl_light_kind;

typedef struct fnl_light_params {
    fnl_light_kind kind; /**< default point */
    fnl_vec3 position;   /**< metres; apex of spots and wedges, middle of capsules and boxes; not for directional lights */
    fnl_vec3
        direction; /**< where the light shines to; capsules: along the segment; normalised by the call; not for point lights;
                              default 0, 0, -1 */
    float color[3];  /**< linear RGB, >= 0; default 1 */
    float intensity; /**< candela, or lux for directional lights and boxes, >= 0; default 1 */
    /**
     * Distance from the position (capsules: from the segment) from which on the light gives exactly nothing, metres, > 0;
     * INFINITY (the default) derives it from the intensity (fnl_light_range). Not for directional lights and boxes.
     */
    float range;
    float inner_cone_angle; /**< half angle of full intensity, radians, 0 .. outer; default 0 */
    float outer_cone_angle; /**< half angle from which on there is no light, radians, up to pi/2; default pi/4 */
    /**
     * Wedges and boxes: the way their height points, made a unit vector at right angles to the direction by the call; where it is
     * parallel to that, another is chosen. The width points along direction x up. Default 0, 1, 0.
     */
    fnl_vec3 up;
    float length;          /**< capsules: of the segment, half of it to each side of the position, metres, >= 0; default 1 */
    float wedge_angles[2]; /**< wedges: half angles across the width and the height, radians, 0 .. 1.5; default pi/4, pi/6 */
    fnl_vec3 box_size;     /**< boxes: width, height and depth (along the direction), metres, > 0; default 1 */
    float
        inner_fraction; /**< wedges and boxes: part of the way from axis to edge that has full intensity, beyond it fades to
                                nothing at the edge, 0 .. 1; default 0.7 */
} fnl_light_params;

/** Names such as "point"; NULL for a value out of range. */

FNL_API fnl_light_params fnl_light_params_default(void);
FNL_API fnl_result fnl_scene_add_light(fnl_scene *scene, const fnl_light_params *params, fnl_light_id *out);
/**
 * A light of a file follows its node. It goes on doing so where position, direction and up, as far as its kind has them, are as fnl_scene_query_light
 * gave them; another pose takes it off its node, and it stays there.
 */
FNL_API fnl_result fnl_scene_set_light(fnl_scene *scene, fnl_light_id light, const fnl_light_params *params);
FNL_API fnl_result fnl_scene_remove_light(fnl_scene *scene, fnl_light_id light);

/**
 * Bounds a light by the convex hull of `count` (4 .. 64) world-space points: it gives exactly nothing outside of it, nor outside of
 * its own volume. The hull stays where it is when the light moves. NULL and 0 remove it. Points in one plane, on one line or in one
 * place are an error (logged) and change nothing. Directional lights have no bound: theirs is not heeded.
 */
FNL_API fnl_result fnl_scene_set_light_hull(fnl_scene *scene, fnl_light_id light, const fnl_vec3 *points, uint32_t count);

/**
 * Distance in metres from which on a light gives exactly nothing: its range when that is finite, and of a box half its diagonal.
 * Otherwise sqrt(I g / threshold), I being its intensity times its brightest colour: where it would no longer give `threshold` lux
 * (> 0) times 1/pi cd/m^2 to the brightest surface of `min_roughness` (0 .. 1). g = max(1, 1 / (4 alpha^2)) with alpha =
 * max(min_roughness^2, 0.001) is what the largest value of a white metal's BRDF seen head-on, 1 / (4 pi alpha^2), is to a white matt
 * one's, 1/pi. Lights reach the farther the smoother the surfaces are: sharp highlights stand out where diffuse light is long lost.
 * INFINITY for directional lights; 0 (logged) for NULL.
 */
FNL_API float fnl_light_range(const fnl_light_params *params, float min_roughness, float threshold);
/**
 * What fnl_light_range is given for lights whose range is INFINITY: the smoothest roughness whose highlights shall be kept, 0 .. 1
 * (default 1), and lux, > 0 (default 0.05).
 */
FNL_API fnl_result fnl_scene_set_light_cutoff(fnl_scene *scene, float min_roughness, float threshold);

/**
 * Scatters `count` seeded point and spot lights (three to one) through the scene's bounds. Their radius follows from
 * the extent so that a point of the scene lies in about 8 of them on average, whatever the count; their intensity
 * follows from the radius. Same scene, count and seed give the same lights.
 */
FNL_API fnl_result fnl_scene_scatter_lights(fnl_scene *scene, uint32_t count, uint64_t seed);

typedef struct fnl_scatter_params {
    uint32_t count; /**< of lights; default 0 */
    uint64_t seed;  /**< default 1 */
    float shares
        [FNL_LIGHT_KIND_COUNT]; /**< relative number of each kind, >= 0; default 3 points, 1 spot; no directional ones */
    float radius_scale;         /**< times the radius that lets 8 points reach a point of the scene, > 0; default 1 */
} fnl_scatter_params;

FNL_API fnl_scatter_params fnl_scatter_params_default(void);
/** The same with lights of all shapes; with the default shares and scale it gives exactly the same lights. */
FNL_API fnl_result fnl_scene_scatter_light_shapes(fnl_scene *scene, const fnl_scatter_params *params);

/* ---- decals ---- */

/** How a decal finds the surface that it changes. docs/techniques/decals.md tells when to take which. */
typedef enum fnl_decal_kind {
    FNL_DECAL_BOX = 0, /**< projected along the box's -Z onto whatever is in the box */
    FNL_DECAL_VOLUME,  /**< the box is a stack of slices: a surface shows the picture at its very place (marble, a cut) */
    FNL_DECAL_MESH,    /**< on one instance, in the space of its mesh before it deforms: stretches and moves with the skin */
    FNL_DECAL_REDRAW, /**< the triangles of one instance that the box touches are drawn again over it, with lighting of their own */
    FNL_DECAL_BAKED, /**< painted into copies of one instance's textures when it is added: no cost in a frame */
    FNL_DECAL_KIND_COUNT
} fnl_decal_kind;

/** What becomes of a base colour `b` under a decal's colour `c`, before both are mixed by the decal's alpha. */
typedef enum fnl_decal_blend {
    FNL_DECAL_BLEND_ALPHA = 0, /**< c */
    FNL_DECAL_BLEND_MULTIPLY,  /**< b c */
    FNL_DECAL_BLEND_ADD,       /**< b + c, at most 1 */
    FNL_DECAL_BLEND_SCREEN,    /**< b + c - b c */
    FNL_DECAL_BLEND_OVERLAY,   /**< 2 b c where b < 1/2, else 1 - 2 (1 - b) (1 - c) */
    FNL_DECAL_BLEND_COUNT
} fnl_decal_blend;

/** What of the surface a decal changes; bits. */
typedef enum fnl_decal_channel {
    FNL_DECAL_COLOR = 1,  /**< alone: a tattoo */
    FNL_DECAL_NORMAL = 2, /**< alone: an embossing */
    FNL_DECAL_ROUGHNESS = 4,
    FNL_DECAL_METALLIC = 8,
    FNL_DECAL_EMISSION = 16,
    FNL_DECAL_ALL = 31 /**< a sticker */
} fnl_decal_channel;

typedef struct fnl_decal_params {
    fnl_decal_kind kind; /**< default box */
    /**
     * From the unit cube (-1/2 .. 1/2) to the world, or to the space of `instance`: affine and invertible, may mirror. The picture lies in the
     * cube's xy plane, +Y up, and is seen from +Z. Default: the cube itself.
     */
    fnl_mat4 transform;
    /** Mesh, redraw and baked decals: what they are on. Box and volume decals: what they move with; all-zero (default): nothing. */
    fnl_instance_id instance;
    float color[4];     /**< linear RGB and alpha, 0..1, multiply the picture; default 1 */
    float metallic;     /**< 0..1; default 0 */
    float roughness;    /**< 0..1; default 0.5 */
    float normal_scale; /**< scales the normal map's x and y; default 1 */
    float emissive[3];  /**< cd/m^2, >= 0; default 0 */
    fnl_image_id color_image, normal_image, metallic_roughness_image, emissive_image; /**< all-zero (default): none */
    uint32_t channels;     /**< fnl_decal_channel bits; default colour, roughness and metallic */
    fnl_decal_blend blend; /**< default alpha */
    bool flatten;     /**< the normal map replaces the surface's own details instead of lying upon them; default false */
    int32_t sort_key; /**< decals are applied by ascending key, of equal ones in the order they were added; default 0 */
    /**
     * Angles between the surface and the box's +Z, radians, 0 .. pi: in full up to fade_start, not at all from fade_end (>= fade_start) on.
     * Default 65 and 85 degrees: sides seen edge-on would be streaks. Not for volume decals.
     */
    float fade_start, fade_end;
    uint32_t
        receivers; /**< 8 bits: applied where they share one with the instance's (fnl_scene_set_instance_receivers); default 255 */
    bool distance_field; /**< the picture's alpha is a distance, and is cut at `cut`; default false */
    float cut;           /**< 0..1; default 0.5 */
    uint32_t slices;     /**< volume decals: pictures stacked in each image, the topmost at +Z, 1 .. 4096; default 1 */
} fnl_decal_params;

/** Names such as "box" and "multiply"; NULL for a value out of range. */

FNL_API fnl_decal_params fnl_decal_params_default(void);
FNL_API fnl_result fnl_scene_add_decal(fnl_scene *scene, const fnl_decal_params *params, fnl_decal_id *out);
/** The kind and, but for box and volume decals, the instance stay as they are; a baked decal is painted anew. */
FNL_API fnl_result fnl_scene_set_decal(fnl_scene *scene, fnl_decal_id decal, const fnl_decal_params *params);
FNL_API fnl_result fnl_scene_remove_decal(fnl_scene *scene, fnl_decal_id decal);
/** Which decals an instance receives: they must share a bit with `receivers` (8 bits; 255 at first). 0: none. Renderers upload
 *  the scene anew: not for every frame. */
FNL_API fnl_result fnl_scene_set_instance_receivers(fnl_scene *scene, fnl_instance_id instance, uint32_t receivers);
/**
 * Scatters `count` seeded box decals (graffiti, cracks, footprints, made by the library) over the scene's surfaces; fewer where there are none.
 * Same scene, count and seed give the same decals.
 */
FNL_API fnl_result fnl_scene_scatter_decals(fnl_scene *scene, uint32_t count, uint64_t seed);

/** Light from all around, cd/m^2: `sky` from +Y, `ground` from -Y, blended by the normal's height. Default 0. */
FNL_API fnl_result fnl_scene_set_ambient(fnl_scene *scene, fnl_vec3 sky, fnl_vec3 ground);
/** What is seen where nothing is, cd/m^2. Default 0. */
FNL_API fnl_result fnl_scene_set_background(fnl_scene *scene, fnl_vec3 radiance);
/** Most samples that mipmapped textures take along the longer axis of a pixel's footprint, 1 .. 16 as far as the device goes; default 8. */
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
    fnl_vec3 target;       /**< a point it looks at; must differ from the position */
    fnl_vec3 up;           /**< default 0, 1, 0 */
    bool orthographic;     /**< default false */
    float vertical_fov;    /**< radians, 0 .. pi; default 0.9 */
    float vertical_extent; /**< orthographic: height of the view in metres; default 10 */
    float near_distance;   /**< metres, > 0; default 0.05 */
    float far_distance;    /**< orthographic only, > near; perspective views reach to infinity; default 1000 */
    fnl_vec2 shift;        /**< off-axis projection: moves the picture, in half widths and half heights; default 0 */
} fnl_camera;

FNL_API fnl_camera fnl_camera_default(void);
/** By index, in file order. The pose follows the camera's node. */
FNL_API fnl_result fnl_scene_query_camera(const fnl_scene *scene, uint32_t index, fnl_camera *out);
FNL_API fnl_result fnl_scene_add_camera(fnl_scene *scene, const char *name, const fnl_camera *camera);
/** A camera from which the whole scene fits a picture of the given aspect (width / height). */
FNL_API fnl_result fnl_scene_query_framing_camera(const fnl_scene *scene, float aspect, fnl_camera *out);

/* ---- what is in it ---- */

typedef struct fnl_scene_info {
    uint64_t triangle_count;        /**< over all instances */
    uint64_t unique_triangle_count; /**< over all meshes once */
    uint64_t unique_vertex_count;
    uint32_t mesh_count, primitive_count, material_count, image_count, node_count;
    uint64_t instance_count; /**< of meshes that are shown */
    uint32_t light_count;    /**< placed lights, those of hidden nodes too */
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
    const char *treatment; /**< "full", "ignored", or what is done instead */
} fnl_extension_info;

/** By index below the counts of fnl_scene_info; the strings live as long as the scene. */
FNL_API fnl_result fnl_scene_query_image(const fnl_scene *scene, uint32_t index, fnl_image_info *out);
FNL_API fnl_result fnl_scene_query_animation(const fnl_scene *scene, uint32_t index, fnl_animation_info *out);
FNL_API fnl_result fnl_scene_query_extension(const fnl_scene *scene, uint32_t index, fnl_extension_info *out);
/** Warnings of the import, in order, each with its JSON pointer. NULL when the index is too high. */
FNL_API const char *fnl_scene_message(const fnl_scene *scene, uint32_t index);
FNL_API fnl_result fnl_scene_query_light(const fnl_scene *scene, uint32_t index, fnl_light_params *out);
FNL_API fnl_result fnl_scene_query_decal(const fnl_scene *scene, uint32_t index, fnl_decal_params *out);
FNL_API fnl_result fnl_scene_query_material(const fnl_scene *scene, uint32_t index, fnl_material_params *out);

typedef struct fnl_instance_info {
    fnl_mat4 transform;     /**< to the space of `parent` */
    fnl_mat4 world;         /**< to the world */
    fnl_instance_id parent; /**< all-zero: none */
    fnl_mesh_id mesh;       /**< all-zero: none */
    bool visible;           /**< as fnl_scene_set_instance_visible has it */
    bool shown;             /**< so are all instances above it */
} fnl_instance_info;

FNL_API fnl_result fnl_scene_query_instance(const fnl_scene *scene, uint32_t index, fnl_instance_info *out);

/** What a scene has several of. */
typedef enum fnl_entity {
    FNL_ENTITY_INSTANCE = 0, /**< of files: every node, with a mesh or without */
    FNL_ENTITY_LIGHT,        /**< one for each node that carries it; called as the light, or as the node */
    FNL_ENTITY_DECAL,
    FNL_ENTITY_MESH,
    FNL_ENTITY_MATERIAL,
    FNL_ENTITY_IMAGE,
    FNL_ENTITY_CAMERA,
    FNL_ENTITY_ANIMATION,
    FNL_ENTITY_COUNT
} fnl_entity;

typedef struct fnl_entity_info {
    const char *name;   /**< "" for what has none; lives as long as the scene */
    const char *extras; /**< glTF's "extras" as JSON text, or NULL; lives as long as the scene */
    union {
        fnl_instance_id instance;
        fnl_light_id light;
        fnl_decal_id decal;
        fnl_mesh_id mesh;
        fnl_material_id material;
        fnl_image_id image;
    } id; /**< what changes it; cameras and animations have none: they are known by index */
} fnl_entity_info;

/**
 * Queries take an index, changes an id. Indices are 0 .. fnl_scene_count - 1, in the order of the file and of adding as long as nothing was
 * removed. Those that come after something removed move down; ids stay. 0 for a kind out of range (logged).
 */
FNL_API uint32_t fnl_scene_count(const fnl_scene *scene, fnl_entity kind);
FNL_API fnl_result fnl_scene_query_entity(const fnl_scene *scene, fnl_entity kind, uint32_t index, fnl_entity_info *out);
/** The first index of this name; FNL_ERROR_INVALID (logged with the names there are) when there is none. */
FNL_API fnl_result fnl_scene_find(const fnl_scene *scene, fnl_entity kind, const char *name, uint32_t *out_index);

#ifdef __cplusplus
}
#endif
#endif
