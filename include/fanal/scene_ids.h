/* SPDX-License-Identifier: MIT */
/**
 * What a scene is made of, and how its parts are named: by an index in queries, and by an id in calls that change them.
 */
#ifndef FANAL_SCENE_IDS_H
#define FANAL_SCENE_IDS_H

#include "fanal/base.h"

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
typedef struct fnl_light_profile_id {
    uint32_t index, generation;
} fnl_light_profile_id;
typedef struct fnl_decal_id {
    uint32_t index, generation;
} fnl_decal_id;
typedef struct fnl_probe_id {
    uint32_t index, generation;
} fnl_probe_id;

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
    FNL_ENTITY_PROBE,
    FNL_ENTITY_VARIANT,  /**< of the materials of a file (fnl_scene_select_variant) */
    FNL_ENTITY_METADATA, /**< a packet of XMP as JSON-LD (KHR_xmp_json_ld): "extras" is its text, "name" says what it is about, as JSON pointers
                              into its file with blanks between them ("/asset /nodes/3") */
    FNL_ENTITY_COUNT
} fnl_entity;

#ifdef __cplusplus
}
#endif
#endif
