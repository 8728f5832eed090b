/* SPDX-License-Identifier: MIT */
/**
 * A scene in device memory: uploaded once, rebuilt when its structure changes, and kept in step with transforms and lights by copies
 * inside the frame.
 */
#ifndef FNL_RENDER_DEVICE_SCENE_H
#define FNL_RENDER_DEVICE_SCENE_H

#include "base/ranges.h"
#include "passes/geometry/geometry.h"
#include "passes/geometry/skin.h"
#include "passes/texturing/virtual.h"
#include "decals_shared.h"
#include "passes/lights/light_list.h"
#include "scene/scene.h"
#include "view_shared.h"

/** One node that is skinned or morphed: its joint matrices and weights are sent with every frame. */
struct device_deform {
    uint32_t node, skin, matrix_count, first_matrix, weight_count, first_weight;
};

/** A picture of a decal: images of materials serve them not, as alpha is multiplied in before mips are made. */
enum decal_picture_kind { DECAL_PICTURE_DATA, DECAL_PICTURE_COLOR, DECAL_PICTURE_PREMULTIPLIED };
struct decal_picture {
    uint32_t image; /* of the scene */
    enum decal_picture_kind kind;
    struct gpu_image gpu; /* handle 0: missing or broken */
};

/** The decals on the device (decals.c). */
struct device_decals {
    struct gpu_buffer decals, boxes;         /* struct gpu_decal, struct gpu_light; sent inside the frame */
    struct gpu_buffer mesh_ranges, mesh_ids; /* of mesh decals: see struct gpu_decal_set */
    struct gpu_buffer redraw_indices, redraw_draws, redraw_table; /* see struct decals_redraw */
    ARRAY(struct gpu_decal) data; /* boxes and volumes, then those of meshes, then redraws; each in order */
    ARRAY(struct gpu_light) box_data;
    ARRAY(uint32_t) order; /* indices of scene decals, as in data */
    ARRAY(struct decal_picture) pictures;
    uint32_t count, mesh_count, redraw_count;
    uint32_t draw_count; /* of redrawn decals */
    bool moves;          /* some move with nodes */
    bool masks;          /* some box or volume is not on everything, or something does not receive all */
    bool emits;          /* some box or volume changes emission */
    uint64_t version, structure_version, transform_version, sent_version; /* of the scene: prepared, sent */
    uint32_t sampler;
};

struct device_scene {
    gpu_device *device;
    fnl_host host;
    fnl_scene *scene;
    uint64_t structure_version, image_version, transform_version, light_version; /* what has been uploaded; UINT64_MAX: nothing yet */

    struct gpu_buffer positions, attributes, indices, instances, primitives, materials, material_entries, items, groups,
        table, deforms, influences, morphs, clusters, cluster_words;
    ARRAY(struct gpu_image) images; /* one per scene image; handle 0: missing */
    ARRAY(int16_t) image_blues;     /* of each: the blue of all its pixels, or -1 where it varies */
    ARRAY(struct geometry_bucket) buckets;
    ARRAY(uint32_t) node_instances;  /* first instance of each node, or SCENE_NONE */
    ARRAY(uint32_t) node_primitives; /* first own primitive of each deforming node, or SCENE_NONE */
    ARRAY(bool) node_mirrored;       /* whether its draws were sorted as those of a mirrored node */
    ARRAY(struct device_deform) deformed;
    ARRAY(uint32_t) deform_vertex_counts;
    uint32_t material_count, material_classes; /* classes: bit 1 << c, some material is of GPU_CLASS_… bits c */
    uint32_t attribute_bits; /* GEOMETRY_…: what materials and meshes have */
    uint64_t cluster_count, triangle_count; /* of all items that culling by clusters is for */
    uint32_t index_count, pool_triangles;   /* of the scene; triangles for which there is room behind its indices */
    uint32_t wanted_triangles;              /* room that the next frame asks for */
    uint32_t item_count, group_count, most_triangles, blend_first_item, blend_item_count, matrix_count, weight_count;

    bool keeps_previous;        /* the frame wants to know where instances and vertices were in the last one */
    struct gpu_buffer previous; /* then: all instances, and behind them the positions from first_deformed on */
    uint32_t first_deformed, deformed_vertex_count; /* vertices */
    uint64_t upload_count, image_upload_count; /* of scenes and of images so far */

    struct box bounds; /* of the scene when it was uploaded, grown by what moved since */
    struct device_decals decals;

    struct gpu_buffer lights;           /* room for `sun_room` directional ones, the last of them used; then a place for each slot of the scene */
    struct gpu_buffer planes;           /* of the lights' hulls */
    uint32_t sun_room;
    ARRAY(struct gpu_light) sun_data;   /* the same on the CPU */
    ARRAY(struct gpu_light) light_data; /* by slot; without a range where no light is, or a hidden one */
    ARRAY(vec4) plane_data;
    struct ranges planes_taken;
    uint32_t plane_room;                /* in the buffer */
    uint32_t lit_count;                 /* of light_data */
    uint64_t light_bytes_sent;          /* with the last frame */
    struct gpu_buffer faded_lights; /* a copy for frames with light_lod; made when first asked for */
    ARRAY(float) bound_radii;       /* of light_data before it was faded; empty: it is not */
};

void device_scene_init(struct device_scene *d, gpu_device *device, fnl_scene *scene);
void device_scene_finish(struct device_scene *d);
/** Uploads what changed in the scene's structure; blocks while images are decoded and copied. Call outside of frames. */
fnl_result device_scene_prepare(struct device_scene *d);
/** After a frame that failed: uploads everything again with the next. */
void device_scene_forget(struct device_scene *d);

struct device_scene_frame {
    struct geometry_scene geometry;
    struct light_input lights; /* view, width and height are left to the caller */
    bool moved;                /* instances or vertices are elsewhere than in the last frame */
    graph_buffer previous;     /* with keeps_previous, where something moved: what the last frame drew; else id 0 */
};
/** Declares this frame's updates (moved instances, lights, skinning) and imports the buffers. */
fnl_result device_scene_add(struct device_scene *d, struct graph *graph, struct device_scene_frame *out);

/** What the device has been sent, as far as this struct knows; for frames that are declared and never executed, which send nothing. */
struct device_scene_sent {
    uint64_t transform_version, light_version, decal_version, decal_transform_version;
};
static inline struct device_scene_sent device_scene_sent(const struct device_scene *d) {
    return (struct device_scene_sent){d->transform_version, d->light_version, d->decals.sent_version,
                                      d->decals.transform_version};
}
static inline void device_scene_unsend(struct device_scene *d, const struct device_scene_sent *sent) {
    d->transform_version = sent->transform_version;
    d->light_version = sent->light_version;
    d->decals.sent_version = sent->decal_version;
    d->decals.transform_version = sent->decal_transform_version;
}

/* ---- the parts ---- */

/** Makes a device buffer and fills it; of size 0 it is as small as can be. */
fnl_result device_upload_array(struct device_scene *d, const char *name, struct gpu_buffer *buffer, const void *data,
                               uint64_t size);

/** Whether a node shows a mesh. */
static inline bool device_node_draws(const struct scene_node *node) {
    return node->active && !node->removed && node->mesh != SCENE_NONE;
}

/** Outside of frames: makes the buffers as large as the lights are many (lights.c). */
fnl_result device_lights_prepare(struct device_scene *d);
void device_lights_finish(struct device_scene *d);
/** Declares the update of the light array: only the lights that changed are sent, and all directional ones where one of them did. */
fnl_result device_lights_add(struct device_scene *d, struct graph *graph, graph_buffer lights);
/** The lights as one frame sees them; view, width and height are left to the caller. */
struct light_input device_lights_input(const struct device_scene *d, graph_buffer lights);
/** The part that needs no device: fills light_data, sun_data and plane_data from d->scene. */
fnl_result device_lights_gather(struct device_scene *d);
/** Local lights that the next frame lights with: of the scene as it is now, before they are gathered. Costs a look at what changed. */
uint32_t device_lights_count(const struct device_scene *d);
struct gpu_light device_light(const fnl_light_params *light);
/**
 * For frames with a light_lod (0: none): lists that the CPU builds see faded lights too (passes/lights/sprites.h). Costs a walk over the
 * lights where `walk` says that the frame has such lists, or to undo it.
 */
fnl_result device_lights_fade(struct device_scene *d, const struct gpu_view *view, float lod, bool walk);

/** Outside of frames, when structure or decals changed: pictures, tables of mesh decals. */
fnl_result device_decals_prepare(struct device_scene *d);
void device_decals_finish(struct device_scene *d);
/** The decals as one frame sees them; buffers of id 0 where there are none of the kind. */
struct device_decals_frame {
    graph_buffer decals, boxes, mesh_ranges, mesh_ids, redraw_draws;
};
/** Sends what changed. */
fnl_result device_decals_add(struct device_scene *d, struct graph *graph, struct device_decals_frame *out);

/** Decodes on all threads and uploads the images that materials use (images.c). */
fnl_result device_images_upload(struct device_scene *d, struct jobs *jobs);

/** After the images; the last material is glTF's default, for primitives without one (materials.c). */
fnl_result device_materials_upload(struct device_scene *d);
/**
 * Makes the atlas of virtual texturing, `side` texels at most, unless it is there (virtual.c). The atlas cannot hold materials whose
 * textures differ in coordinates or wraps, or are not filtered smoothly.
 */
fnl_result device_virtual_prepare(struct device_scene *d, uint32_t side, struct virtual_atlas *atlas);
bool device_virtual_holds(const struct device_scene *d, const struct scene_material *material);
/** A bit for each G-buffer layout that cannot hold a material, and VIRTUAL_FORWARD; `id` is its index. */
uint32_t device_material_forward_layouts(const struct device_scene *d, const struct scene_material *material, uint32_t id);

/** Vertices, indices, primitives and what deforms, then everything below (geometry.c). */
fnl_result device_geometry_upload(struct device_scene *d);

/**
 * Instances, items, groups and buckets (items.c). `primitives` are those of the scene, then those of deforming nodes;
 * node_primitives[node] is the first own primitive of a deforming node, else SCENE_NONE.
 */
fnl_result device_items_upload(struct device_scene *d, const struct gpu_primitive *primitives, uint32_t primitive_count,
                               const uint32_t *node_primitives);
/** Object to world of one of a node's instances, at its present pose; and the device form of all of them. */
mat4 device_instance_matrix(const struct scene_node *node, uint32_t k);
void device_scene_node_instances(const struct scene_node *node, struct gpu_instance *out);

#endif
