/* SPDX-License-Identifier: MIT */
/**
 * What a scene contains: counts, names, and the present values of its parts. Calls on one scene are not thread-safe.
 */
#ifndef FANAL_SCENE_QUERY_H
#define FANAL_SCENE_QUERY_H

#include "fanal/camera.h"
#include "fanal/decal.h"
#include "fanal/instance.h"
#include "fanal/light.h"
#include "fanal/mesh.h"
#include "fanal/probe.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct fnl_entity_info {
    const char *name;   /**< "" if it has none; lives as long as the scene */
    const char *extras; /**< glTF's "extras" as JSON text, or NULL; lives as long as the scene */
    union {
        fnl_instance_id instance;
        fnl_light_id light;
        fnl_decal_id decal;
        fnl_probe_id probe;
        fnl_mesh_id mesh;
        fnl_material_id material;
        fnl_image_id image;
    } id; /**< for the calls that change it; cameras, animations, variants and metadata have no id, only an index */
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

typedef struct fnl_scene_info {
    uint64_t triangle_count;        /**< of all visible instances */
    uint64_t unique_triangle_count; /**< of all meshes, each counted once */
    uint64_t unique_vertex_count;
    uint32_t mesh_count, primitive_count, material_count, image_count, node_count;
    uint64_t instance_count; /**< visible instances that have a mesh */
    uint32_t light_count;    /**< of all kinds, including those of hidden nodes */
    uint32_t light_kind_counts[FNL_LIGHT_KIND_COUNT];
    uint32_t unlimited_light_count; /**< lights whose range is INFINITY, hidden ones included */
    double light_threshold;         /**< illuminance at which these lights end, lux; 0: they are unlimited (fnl_scene_set_light_cutoff) */
    uint32_t decal_count; /**< of all kinds */
    uint32_t decal_kind_counts[FNL_DECAL_KIND_COUNT];
    uint32_t probe_count;
    uint32_t camera_count, animation_count, skin_count, extension_count, message_count;
    uint32_t variant_count; /**< of materials */
    bool has_ambient;       /**< nonzero, from fnl_scene_set_ambient or the file */
    bool has_environment;   /**< fnl_scene_set_environment, or the file's own */
    fnl_vec3 bounds_low, bounds_high; /**< meters, relative to the origin; low > high: empty */
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
FNL_API fnl_result fnl_scene_query_probe(const fnl_scene *scene, uint32_t index, fnl_probe_params *out);
FNL_API fnl_result fnl_scene_query_material(const fnl_scene *scene, uint32_t index, fnl_material_params *out);

/** A mesh and one of its primitives: a mesh of a file may have several, each with its own material. */
typedef struct fnl_mesh_info {
    uint32_t primitive_count;
    uint32_t corner_count;       /**< of the primitive: 3 for triangles, 2 for lines, 1 for points */
    uint32_t morph_target_count;
    fnl_vec3 bounds_low, bounds_high; /**< of the whole mesh with any morph weights of 0 .. 1, metres */
    /**
     * The primitive as fnl_scene_set_mesh takes it, including normals and tangents that were generated. The arrays belong to
     * the scene, and are valid until the mesh is changed or the scene is destroyed.
     */
    fnl_mesh_params params;
} fnl_mesh_info;

FNL_API fnl_result fnl_scene_query_mesh(const fnl_scene *scene, uint32_t index, uint32_t primitive, fnl_mesh_info *out);

typedef struct fnl_instance_info {
    fnl_mat4 transform;     /**< to the space of `parent`; to the world if there is no parent */
    fnl_mat4 world;         /**< to the world, relative to the scene's origin */
    fnl_instance_id parent; /**< all-zero: none */
    fnl_mesh_id mesh;       /**< all-zero: none */
    bool visible;           /**< as set by fnl_scene_set_instance_visible */
    bool shown;             /**< visible, and so are all instances above it, and none is of a level of detail that the last picture left out */
    uint32_t joint_count;   /**< of its skin; 0: it has none */
    uint32_t morph_target_count; /**< of its mesh */
    const float *morph_weights;  /**< the present weight of each target, valid until the scene is changed; NULL: all are 0 */
    uint32_t receivers;          /**< decals that it receives: fnl_scene_set_instance_receivers */
    uint32_t light_mask;         /**< lights that affect it: fnl_scene_set_instance_light_mask */
    uint32_t view_mask;          /**< cameras that show it: fnl_scene_set_instance_view_mask */
} fnl_instance_info;

FNL_API fnl_result fnl_scene_query_instance(const fnl_scene *scene, uint32_t index, fnl_instance_info *out);

#ifdef __cplusplus
}
#endif
#endif
