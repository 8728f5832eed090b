/* SPDX-License-Identifier: MIT */
/** The scene in device memory. */
#ifndef FNL_SHADERS_SCENE_SHARED_H
#define FNL_SHADERS_SCENE_SHARED_H

#include "layers_shared.h"
#include "texture_shared.h"

#define GPU_TEXTURE_COUNT 7 /* in the order of enum scene_texture_slot; slots of layers follow */

#define GPU_MATERIAL_UNLIT 1u
#define GPU_MATERIAL_MASK 2u
#define GPU_MATERIAL_BLEND 4u
#define GPU_MATERIAL_DOUBLE_SIDED 8u
#define GPU_MATERIAL_SHARED_OCCLUSION 16u /* occlusion is the red of the very texture that metalness and roughness have */
#define GPU_MATERIAL_LAYERED 32u /* gpu_material.layers is there */
#define GPU_MATERIAL_TRANSMISSIVE 64u /* and it lets through what is behind */
#define GPU_MATERIAL_SHADOWLESS 128u /* it casts no shadow */
#define GPU_MATERIAL_DARK (1u << 16) /* of a transmissive one: it is opaque somewhere, and casts shadows there */
#define GPU_MATERIAL_CLASS_SHIFT 8u /* GPU_CLASS_… in the bits from here on */

/* What of the code of material_surface() and shade_surface() a material needs, as bits. */
#define GPU_CLASS_LIT 1u
#define GPU_CLASS_METAL 2u
#define GPU_CLASS_TEXTURES 4u
#define GPU_CLASS_NORMAL_MAP 8u
#define GPU_CLASS_LAYERS 16u
#define GPU_CLASSES 32u

/* Bits of the feature constant of shaders that draw the scene (gpu_graphics_params.features). */
#define GPU_FEATURE_DECALS 1u      /* box and volume decals are looked up in a list */
#define GPU_FEATURE_MESH_DECALS 2u /* some instance has decals of its own, in the space of its mesh */
#define GPU_FEATURES_DECALS (GPU_FEATURE_DECALS | GPU_FEATURE_MESH_DECALS)
#define GPU_FEATURE_LIGHT_MASKS 8u /* lights have masks: items that lack bits are shaded forward where the item is not known */
/* Shading normals may differ from geometric normals; deferred paths store surface.geometric. */
#define GPU_FEATURE_LEANING 16u
#define GPU_FEATURE_COMPACTED 4u   /* draws leave out triangles: passes/geometry/clusters.h */

/* Vertex data apart from the position, which is a stream of its own (3 floats). */
struct gpu_attributes {
    uint normal;    /* octahedral, 2 x 16-bit signed normalised */
    uint tangent;   /* octahedral, 16 + 15 bits unsigned normalised; bit 31: handedness is -1 */
    vec2 uv0;
    vec2 uv1;
    uvec2 color;    /* 4 x 16-bit unsigned normalised, linear */
};

struct gpu_material {
    vec4 base_color;
    vec3 emissive;          /* cd/m^2 */
    float metallic;
    vec3 dielectric_f0;     /* from index of refraction and specular colour, before `specular` */
    float roughness;
    float specular;
    vec4 normal_turn;       /* rows of a 2x2 matrix: from x and y of the normal texture to tangent and bitangent */
    float occlusion_strength;
    float alpha_cutoff;
    uint flags;
    uint forward_layouts;   /* a bit for each G-buffer layout that cannot hold it */
    ADDRESS(layers_block) layers; /* with GPU_MATERIAL_LAYERED */
    STRUCT(gpu_texture) textures[GPU_TEXTURE_COUNT];
    uint pad;
};

/* Object to world: rows of a 3x4 matrix. */
struct gpu_instance {
    vec4 rows[3];
};

/* A part of a mesh with one material; a skinned or morphed node has primitives of its own. */
struct gpu_primitive {
    vec3 center;       /* of the bounding box, object space */
    uint material;
    vec3 half_extent;
    uint first_index;
    uint index_count;
    int vertex_offset;
    uint corners;      /* 3: triangles; 2: lines, 1: points, which have no back */
    int bind_offset;   /* from a deformed vertex to the one that it was made from */
    uint first_cluster;
    uint cluster_count; /* 0: not cut into clusters */
};

/* A run of triangles of a primitive that lie together; object space. */
struct gpu_cluster {
    vec3 center; /* of a sphere round them */
    float radius;
    vec3 cone_axis;    /* with e from the eye to the centre, all face away where dot(e, axis) >= cutoff * length(e) + radius */
    float cone_cutoff; /* 1: never */
    float thinnest;    /* the smallest altitude of a triangle that has an area */
    uint first_triangle; /* of the primitive */
    uint triangle_count;
    /* In gpu_scene.cluster_words: the numbers of its vertices in the primitive, then for each triangle which three of these, 8 bits each. */
    uint first_word;
    uint vertex_count;
};

/* One primitive of one instance: what is culled and drawn. Sorted by bucket, then primitive. */
struct gpu_item {
    uint instance;
    uint primitive;
    uint receivers;    /* 8 bits: decals that share one are on it; from GPU_ITEM_LIGHTS_SHIFT on 8 bits: lights that share one affect it; from GPU_ITEM_VIEWS_SHIFT on those that show it */
};
#define GPU_ITEM_LIGHTS_SHIFT 8u
#define GPU_ITEM_VIEWS_SHIFT 16u

/* A run of items of one primitive: one indirect draw. */
struct gpu_group {
    uint first_item;
    uint item_count;
    uint primitive;
    uint first_unit; /* pages of shadow maps draw units: the primitive, then each of its clusters if it has several and does not deform */
};

struct gpu_draw {
    uint index_count;
    uint instance_count;
    uint first_index;
    int vertex_offset;
    uint first_instance;
};

struct gpu_scene {
    ADDRESS(position_array) positions;
    ADDRESS(attributes_array) attributes;
    ADDRESS(instance_array) instances;
    ADDRESS(primitive_array) primitives;
    ADDRESS(material_array) materials;
    ADDRESS(item_array) items;
    ADDRESS(group_array) groups;
    ADDRESS(cluster_array) clusters;
    ADDRESS(const_uint_array) cluster_words; /* 0 where the device has no mesh shaders */
};

#endif
