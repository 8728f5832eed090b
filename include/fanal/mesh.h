/* SPDX-License-Identifier: MIT */
/**
 * Images, materials and meshes of a scene. To remove them, remove their users first: instances, then meshes, materials and images. Removing
 * the root of a file removes everything that came with it (fnl_scene_remove_instance). The memory of a file loaded by fnl_scene_load() is freed only by
 * fnl_scene_destroy(). Renderers keep on the device only images that a material uses. Calls on one scene are not thread-safe.
 */
#ifndef FANAL_MESH_H
#define FANAL_MESH_H

#include "fanal/image.h"
#include "fanal/scene_ids.h"

#include <string.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- images ---- */

/** Adds a copy of an RGBA8 picture. `color`: its RGB is sRGB-encoded (base colour, emission), else linear data. */
FNL_API fnl_result fnl_scene_add_image(fnl_scene *scene, const fnl_image *image, bool color, fnl_image_id *out);
/** Removes an image. FNL_ERROR_INVALID if a material or a decal uses it. */
FNL_API fnl_result fnl_scene_remove_image(fnl_scene *scene, fnl_image_id image);

/* ---- materials ---- */

typedef enum fnl_alpha_mode { FNL_ALPHA_OPAQUE = 0, FNL_ALPHA_MASK, FNL_ALPHA_BLEND } fnl_alpha_mode;

/**
 * A clear varnish over the material, of index of refraction 1.5 (KHR_materials_clearcoat). Textures here and below multiply their factors by the
 * channel that is named, and an all-zero id is no texture.
 */
typedef struct fnl_clearcoat_params {
    float strength;               /**< 0..1; 0: no coat */
    float roughness;              /**< perceptual, 0..1 */
    float normal_scale;           /**< of normal_image; 0 is taken as 1 */
    fnl_image_id image;           /**< red: strength */
    fnl_image_id roughness_image; /**< green */
    fnl_image_id normal_image;    /**< the coat's own bumps; without one it is as smooth as the mesh, whatever the material's normal map */
} fnl_clearcoat_params;

/** Fibres that stand out of cloth and glow at its edges (KHR_materials_sheen). */
typedef struct fnl_sheen_params {
    float color[3];               /**< linear, 0..1; black: no sheen */
    float roughness;              /**< perceptual, 0..1 */
    fnl_image_id color_image;     /**< a colour */
    fnl_image_id roughness_image; /**< alpha */
} fnl_sheen_params;

/** A thin film that colours what the surface mirrors, such as a soap bubble's (KHR_materials_iridescence). */
typedef struct fnl_iridescence_params {
    float strength;                             /**< 0..1; 0: no film */
    float ior;                                  /**< of the film, >= 1; 0 is taken as 1.3 */
    float thickness_minimum, thickness_maximum; /**< nanometres, >= 0: where the texture is 0 and 1; without one the maximum counts; both 0: 100, 400 */
    fnl_image_id image;                         /**< red: strength */
    fnl_image_id thickness_image;               /**< green */
} fnl_iridescence_params;

/** Highlights that are stretched, as those of brushed metal (KHR_materials_anisotropy). */
typedef struct fnl_anisotropy_params {
    float strength;     /**< 0..1; 0: round highlights */
    float rotation;     /**< of the direction along which they are stretched, radians from the tangent, counter-clockwise */
    fnl_image_id image; /**< red and green: the direction, as -1..1, before it is turned; blue: strength */
} fnl_anisotropy_params;

/**
 * What is behind the surface shows through it, tinted by the base colour, in place of the colour of its own (KHR_materials_transmission): panes,
 * bottles, water. Rough surfaces blur it. Metals let nothing through. Surfaces in front of each other are seen through each other
 * (fnl_frame.transmission_layers).
 */
typedef struct fnl_transmission_params {
    float strength;     /**< 0..1; 0: none */
    fnl_image_id image; /**< red */
} fnl_transmission_params;

/**
 * What lies below a surface with transmission or diffuse transmission (KHR_materials_volume): it refracts by the index of refraction, and takes
 * some of the light on its way. All-zero: the surface is a thin sheet, which does neither.
 */
typedef struct fnl_volume_params {
    float thickness;            /**< metres of the mesh, before the instance's scale, >= 0; 0: a thin sheet. fnl_scene_trace goes by the mesh instead */
    float attenuation_distance; /**< metres after which white light has attenuation_color, > 0; 0: it never has */
    float attenuation_color[3]; /**< linear, 0..1 */
    fnl_image_id image;         /**< green: thickness */
} fnl_volume_params;

/** Diffuse light from behind, as through paper, leaves or wax (KHR_materials_diffuse_transmission). */
typedef struct fnl_diffuse_transmission_params {
    float strength;     /**< 0..1: the part of diffuse light that goes through; 0: none */
    float color[3];     /**< linear, 0..1, of what went through */
    fnl_image_id image; /**< alpha: strength */
    fnl_image_id color_image;
} fnl_diffuse_transmission_params;

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
    bool casts_shadows;        /**< default true; false: all light goes through it, as through the glass round a lamp. It still receives shadows and is seen */
    fnl_image_id base_color_image, metallic_roughness_image, normal_image, occlusion_image, emissive_image;
    fnl_clearcoat_params clearcoat; /**< this and all below: all-zero (default) is off, costs nothing and leaves the picture as it is, to the bit */
    fnl_sheen_params sheen;
    fnl_iridescence_params iridescence;
    fnl_anisotropy_params anisotropy;
    fnl_transmission_params transmission;
    fnl_volume_params volume;
    float dispersion; /**< of a volume with transmission: 20 over its Abbe number, >= 0 (KHR_materials_dispersion) */
    fnl_diffuse_transmission_params diffuse_transmission;
} fnl_material_params;

static inline fnl_material_params fnl_material_params_default(void) {
    fnl_material_params params;
    memset(&params, 0, sizeof params);
    for (int i = 0; i < 4; i++) params.base_color[i] = 1;
    for (int i = 0; i < 3; i++) params.specular_color[i] = 1;
    params.metallic = params.roughness = params.normal_scale = params.occlusion_strength = params.specular = 1;
    params.ior = 1.5f;
    params.casts_shadows = true;
    params.alpha_cutoff = 0.5f;
    return params;
}
FNL_API fnl_result fnl_scene_add_material(fnl_scene *scene, const fnl_material_params *params, fnl_material_id *out);
/**
 * Changes a material, including one from a file (fnl_scene_query_material returns its current values). A texture whose image
 * stays the same keeps its coordinates and filters; specular textures, which are not in fnl_material_params, stay as they
 * are. Renderers upload the material, and an image that none used before, but go through all instances to sort them again.
 */
FNL_API fnl_result fnl_scene_set_material(fnl_scene *scene, fnl_material_id material, const fnl_material_params *params);
/** Removes a material, but not its images. FNL_ERROR_INVALID if a mesh uses it, including in a variant. */
FNL_API fnl_result fnl_scene_remove_material(fnl_scene *scene, fnl_material_id material);

/** A number of a material's layers, for user interfaces that show all of them. Strings live as long as the program. */
typedef struct fnl_layer_number {
    const char *name;  /**< the member of fnl_material_params, such as "clearcoat.strength" */
    const char *label; /**< for user interfaces; "": do not show the number */
    const char *help;  /**< one line, or "" */
    size_t offset;     /**< in fnl_material_params, bytes */
    uint32_t count;    /**< floats: 1, or 3 for a linear color */
    float least, most; /**< range for a slider; calls may accept more */
    size_t under;      /**< offset of another number: show this one only while that is above 0; 0: show it always */
} fnl_layer_number;

/** A texture of a material's layers. */
typedef struct fnl_layer_texture {
    const char *name;  /**< the member of fnl_material_params, such as "clearcoat.image" */
    const char *label;
    size_t offset;     /**< of the fnl_image_id in fnl_material_params, bytes */
} fnl_layer_texture;

/** Fills `out` with the number or texture `index`, from 0, in the order of fnl_material_params. Returns false past the last. */
FNL_API bool fnl_layer_number_query(uint32_t index, fnl_layer_number *out);
FNL_API bool fnl_layer_texture_query(uint32_t index, fnl_layer_texture *out);

/**
 * Grows the metallic areas of metallic-roughness textures by `texels` (0 .. 64). At the border of a metal the mask is
 * blurred over a texel; there a bright base colour is shaded as half a dielectric, which shows as a bright halo. Growing the
 * metal beyond its colour avoids that. Call it before the scene is rendered.
 */
FNL_API fnl_result fnl_scene_grow_metal(fnl_scene *scene, uint32_t texels);

/* ---- meshes ---- */

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
/**
 * Replaces vertices, indices and material of a mesh, for all instances that show it. `primitive` is 0 for meshes of
 * fnl_scene_add_mesh; meshes of files may have several (fnl_mesh_info.primitive_count). fnl_scene_query_mesh returns the
 * present contents in the same struct: change a part of it and hand it back to keep the rest.
 *
 * Arrays are copied. Renderers upload what differs: only the attributes if positions and indices stay the same, and no
 * geometry if only the material changes. New positions or indices also cost about a microsecond per triangle, because the
 * mesh is cut into clusters again.
 *
 * The counts may change, with one exception. If a file gave the mesh morph targets, joints or a second set of texture
 * coordinates, these stay, and they are stored per vertex: vertex_count must not change, and indices, normals and, with
 * texture coordinates, tangents must be given. Lines and points also keep their number of vertices.
 *
 * Baked decals on the mesh are painted again. The copy of the mesh that they are painted on cannot be changed itself
 * (FNL_ERROR_INVALID). An error changes nothing.
 */
FNL_API fnl_result fnl_scene_set_mesh(fnl_scene *scene, fnl_mesh_id mesh, uint32_t primitive, const fnl_mesh_params *params);
/** Removes a mesh, but not its materials. FNL_ERROR_INVALID if an instance shows it. */
FNL_API fnl_result fnl_scene_remove_mesh(fnl_scene *scene, fnl_mesh_id mesh);

/* ---- variants of materials ---- */

#define FNL_NO_VARIANT UINT32_MAX
/**
 * Shows the meshes of a file as one of its variants says (KHR_materials_variants): an index below fnl_scene_count of FNL_ENTITY_VARIANT, which
 * fnl_scene_find finds by name. Primitives for which the variant names no material get the one that they have without variants. FNL_NO_VARIANT: all
 * primitives of all files do. Where several files were loaded into a scene, a variant concerns the meshes of its own file, and those of the others
 * stay as they are. The scene is then as if the file said so without variants, and what fnl_scene_set_mesh said of the material is lost; primitives
 * that no variant names stay as they are. Renderers upload no geometry, but sort all instances again.
 */
FNL_API fnl_result fnl_scene_select_variant(fnl_scene *scene, uint32_t variant);

#ifdef __cplusplus
}
#endif
#endif
