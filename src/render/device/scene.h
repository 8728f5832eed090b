/* SPDX-License-Identifier: MIT */
/**
 * A scene in device memory. Meshes and images are sent once; of what is made anew when the structure changes (items, groups, materials …)
 * only what differs is sent. Transforms and lights are kept in step by copies inside the frame.
 *
 * Renderers of one scene on one device share it: the first that makes a frame after an edit sends it, in the order in which frames are
 * submitted, so the others find it there. The graphs order what their frames do to the arrays (gpu_last_uses). What depends on a
 * renderer's own frames is in its struct device_scene_user.
 */
#ifndef FNL_RENDER_DEVICE_SCENE_H
#define FNL_RENDER_DEVICE_SCENE_H

#include "base/ranges.h"
#include "image/image_queue.h"
#include "passes/geometry/geometry.h"
#include "passes/geometry/skin.h"
#include "passes/texturing/virtual.h"
#include "decals_shared.h"
#include "passes/ambient/environment.h"
#include "passes/lights/light_list.h"
#include "passes/shadow/rays.h"
#include "scene/scene.h"
#include "view_shared.h"

/** An array on the device, and what it holds: only what changes is sent. */
struct device_array {
    struct gpu_buffer buffer;
    ARRAY(char) sent;
};

/** Where what belongs to a primitive of the scene lies in the pools. */
struct device_primitive {
    uint32_t version, shape_version; /* of the scene's primitive, when it was sent */
    uint32_t first_vertex, vertex_count, first_index, index_count, first_influence, influence_count, first_morph, morph_count;
    uint32_t first_cluster, cluster_count, first_word, word_count;
    bool clustered;
};

/** What a node has on the device; of one that shows nothing first_instance is SCENE_NONE. */
struct device_node {
    uint32_t generation, mesh, skin; /* when its places were taken */
    uint32_t first_instance, instance_count;
    uint32_t first_vertex, vertex_count; /* of its own, where it deforms */
    uint32_t first_primitive;            /* of its own; SCENE_NONE: it does not deform */
    bool mirrored, masked;               /* its draws were sorted as those of a mirrored node; of a node with a light mask */
    bool fresh;                          /* its instances are not sent yet */
};

/** One node that is skinned or morphed: its joint matrices and weights are sent with every frame. */
struct device_deform {
    uint32_t node, skin, matrix_count, first_matrix, weight_count, first_weight;
};

/** Items of one primitive and one handedness. Groups are ordered by bucket, whose bits are a sort key, then by primitive. */
struct device_group {
    uint32_t bucket, primitive, mirrored, masked, first, count;
};

/** An image of the scene, as materials use it. */
struct device_image {
    struct gpu_image gpu; /* handle 0: not there */
    uint32_t version;     /* of the scene's image, when it was uploaded or asked for */
    int16_t blue;         /* of all its pixels, or -1 where it varies or is not known */
    bool used;            /* by a material */
    bool coming;          /* it is being decoded in the background */
    bool broken;          /* it cannot be decoded */
};

/** An image on its way to the device, a part in each frame. */
struct device_arrival {
    bool busy;
    struct image_answer answer;
    struct gpu_image gpu; /* handle 0: none is made yet, or no material uses it */
    uint32_t mip, row_count; /* that it has already: mips, and rows of the next */
};

/** A picture of a decal: images of materials serve them not, as alpha is multiplied in before mips are made. */
enum decal_picture_kind { DECAL_PICTURE_DATA, DECAL_PICTURE_COLOR, DECAL_PICTURE_PREMULTIPLIED };
struct decal_picture {
    uint32_t image; /* of the scene */
    enum decal_picture_kind kind;
    uint32_t version; /* of the scene's image */
    struct gpu_image gpu; /* handle 0: missing, broken or coming */
    bool coming;          /* to be decoded: the decal does not show until then */
};

/** The decals on the device (decals.c). */
struct device_decals {
    struct gpu_buffer decals, bounds;        /* struct gpu_decal; struct gpu_entity_bounds of boxes and volumes; sent inside the frame */
    struct gpu_buffer mesh_ranges, mesh_ids; /* of mesh decals: see struct gpu_decal_set */
    struct gpu_buffer redraw_indices, redraw_draws, redraw_table; /* see struct decals_redraw */
    ARRAY(struct gpu_decal) data; /* boxes and volumes, then those of meshes, then redraws; each in order */
    ARRAY(struct gpu_entity_bounds) bound_data;
    ARRAY(uint32_t) order; /* indices of scene decals, as in data */
    ARRAY(struct decal_picture) pictures;
    uint32_t count, mesh_count, redraw_count;
    uint32_t draw_count; /* of redrawn decals */
    bool moves;          /* some move with nodes */
    bool masks;          /* some box or volume is not on everything, or something does not receive all */
    bool emits;          /* some box or volume changes emission */
    uint64_t version, structure_version; /* of the scene, when they were prepared */
    uint32_t sampler;
};

/** What the device has been sent inside of frames, by versions of the scene; UINT64_MAX: nothing yet. */
struct device_scene_sent {
    uint64_t transforms, poses, lights; /* poses: what deforms has its vertices of these transforms */
    uint64_t decals, decal_transforms;
    uint64_t ray_meshes, ray_items; /* transforms of what the trees of rays.c were made for */
    uint64_t ray_poses, ray_instances; /* … and the structures of structures.c */
    uint64_t environment;              /* its maps are filtered */
    uint64_t environment_frame;        /* in whose frame, while they are to be kept between runs; or 0 */
    bool table;                        /* of reflectance is filled */
};

/** The device's acceleration structure of a primitive's triangles (structures.c). */
struct device_structure {
    uint64_t key;                      /* of what it is made of */
    uint32_t share;                    /* the row whose structure serves: another one's for what a deforming node shows as it is */
    bool wanted;                       /* some item shows it */
    bool built, measured;              /* in frames that were submitted */
    uint32_t query;                    /* by which it is measured, or GPU_NO_INDEX */
    uint32_t updates;                  /* since it was built */
    struct gpu_structure made, smaller; /* smaller: what the next frame compacts it into; handle 0: nothing */
    struct gpu_structure_input input;  /* without addresses */
    uint64_t build_scratch, update_scratch;
};
typedef ARRAY(struct device_structure) device_structure_list;

/** What a frame does to structures. */
struct device_structure_work {
    uint32_t built, updated, compacted, instances;
    bool placed; /* the one over the instances is built */
};

struct device_structures {
    uint64_t structure; /* structure_version that they are of */
    device_structure_list rows; /* as d->primitives */
    uint32_t first_deformed;    /* row */
    uint32_t unbuilt, unmeasured, copies; /* rows: to be built, not measured yet, to be compacted */
    struct gpu_buffer bottoms, instances; /* see struct ray_query_input */
    struct gpu_structure top;
    uint32_t top_capacity;
    uint64_t top_scratch;
    struct device_array addresses; /* by row */
    struct gpu_structure_queries queries; /* of rows that are being measured */
    bool asked;                           /* by a frame that was submitted: asked_frame */
    uint64_t asked_frame;
    /* Of the frame that was declared. */
    bool declared;
    struct device_structure_work frame;
    ARRAY(struct gpu_structure_build) builds;
    ARRAY(uint32_t) changed; /* the rows of `builds` */
    ARRAY(struct ray_query_copy) moves;
    ARRAY(struct gpu_structure) measured;
};

struct device_scene {
    gpu_device *device;
    fnl_host host;
    fnl_scene *scene;
    struct device_scene *next;       /* on the device */
    struct device_scene_user *users; /* who share it */
    /* What has been uploaded; UINT64_MAX: nothing yet. */
    uint64_t structure_version, material_version;
    struct device_scene_sent sent;
    /* A frame was declared and has not been submitted so far: what had been sent before, and whether instances or vertices change. */
    bool declared, overwrites;
    struct device_scene_sent sent_before;

    struct gpu_buffer positions, attributes; /* of primitives, and of deforming nodes */
    struct gpu_buffer indices;               /* of primitives; behind them room for pool_triangles, which culling fills in each frame */
    struct gpu_buffer influences, morphs, clusters, cluster_words, instances;
    struct device_array primitives, materials, layers, material_entries, items, groups, table, deforms, profiles, lobes;
    struct ranges vertices_taken, indices_taken, instances_taken, clusters_taken, words_taken, influences_taken, morphs_taken;
    ARRAY(struct device_primitive) primitive_places;
    ARRAY(struct device_node) nodes;
    ARRAY(struct device_image) images; /* one per scene image */
    struct image_queue *image_queue;   /* while some are coming */
    struct device_arrival arrival;
    uint32_t images_coming;
    uint64_t image_arrivals;           /* how often some have come that frames were not to wait for */
    uint64_t texture_version;          /* grows when materials get other textures; not when those come that were expected */
    ARRAY(struct geometry_bucket) buckets;
    ARRAY(struct device_group) group_list;
    ARRAY(struct gpu_item) item_list; /* by group, and within one as nodes follow */
    ARRAY(uint32_t) item_nodes;       /* of each */
    ARRAY(struct device_deform) deformed;
    ARRAY(uint32_t) deform_vertex_counts;
    uint32_t material_count, material_classes; /* classes: bit 1 << c, some material is of GPU_CLASS_… bits c */
    uint32_t color_bits, texture_bits; /* GEOMETRY_…: what meshes and materials have */
    bool leaning, mapped; /* some mesh leans (scene_primitive.leans); some material has a normal map */
    uint64_t cluster_count, triangle_count; /* of all items that culling by clusters is for */
    uint32_t index_count, influence_count, morph_count; /* in use by the scene's primitives; morph_count: floats */
    uint32_t pool_triangles;
    uint32_t item_count, group_count, unit_count, most_triangles, blend_first_item, blend_item_count, caster_count, matrix_count, weight_count;

    ARRAY(struct range) arrived; /* places of instances that have come, and that not all users have drawn */
    uint64_t arrived_before;     /* so many came before these */
    uint32_t first_deformed, deformed_vertex_count; /* vertices */
    uint64_t upload_count, image_upload_count; /* changes of structure, and images, so far */
    uint64_t sort_count;                       /* of the former, those for which all items were sorted */
    uint64_t bytes_uploaded;                   /* outside of frames, so far; lights, moves and decals are not in it */

    struct box bounds;      /* of the scene when it was uploaded, grown by what moved or came since */
    uint32_t bounds_edits;  /* nodes added or removed since */
    struct device_decals decals;

    /* For shadow rays (rays.c), once some frame has traced any; the structure that they are of. */
    uint64_t ray_structure, ray_key; /* key: of the triangles and where they lie */
    struct device_array ray_table; /* struct gpu_ray_mesh */
    struct gpu_buffer ray_meshes, ray_items;
    uint32_t ray_primitives, ray_triangles;
    struct device_structures structures; /* for ray queries, once some frame has asked for them */

    struct environment_maps environment;
    bool conserves; /* some frame conserved energy: the environment's table is there */
    uint64_t environment_version; /* of the scene, when its picture was sent; UINT64_MAX: never */
    uint64_t environment_key;     /* of what is kept of it between runs */
    /* What the last frame that was declared does for its maps. */
    enum { DEVICE_ENVIRONMENT_THERE, DEVICE_ENVIRONMENT_FILTERED, DEVICE_ENVIRONMENT_KEPT } environment_made;

    struct gpu_buffer lights;           /* room for `sun_room` directional ones, the last of them used; then a place for each slot of the scene */
    struct gpu_buffer bound_buffer;     /* of the lights: struct gpu_entity_bounds, a place for each slot */
    struct gpu_buffer planes;           /* of the lights' hulls */
    struct gpu_buffer masks;            /* of the lights, in the places of `lights`: a uint each; once one has another mask than 255 */
    uint32_t sun_room;
    ARRAY(struct gpu_light) sun_data;   /* the same on the CPU */
    ARRAY(struct gpu_light) light_data; /* by slot; without a range where no light is, or a hidden one */
    ARRAY(struct gpu_entity_bounds) light_bounds; /* by slot */
    ARRAY(vec4) plane_data;
    struct ranges planes_taken;
    uint32_t plane_room;                /* in the buffer */
    uint32_t lit_count, shaped_count;   /* of light_data; those of other shapes than sphere and cone, and with hulls */
    uint32_t profiled_count;            /* lights in places that have a profile */
    uint32_t area_count;                /* area lights in places */
    uint64_t profile_version;           /* of the scene's, as sent */
    uint64_t light_bytes_sent;          /* with the last frame, of whichever user */
    ARRAY(float) bound_radii;       /* of light_bounds before they were faded; empty: they are not */
};

/** Instances, and behind them positions of vertices, as they were when they were kept. */
struct device_previous {
    uint32_t instance_count, first_deformed, deformed_count;
};
static inline uint64_t device_previous_offset(const struct device_previous *p) { /* of the positions, in bytes */
    return (uint64_t)p->instance_count * sizeof(struct gpu_instance);
}

/** Where the instances and vertices that a user's last frame drew are. */
enum device_last {
    DEVICE_LAST_UNKNOWN, /* nowhere: it has drawn none, or a frame of another user has overwritten them and this one did not keep them */
    DEVICE_LAST_THERE,   /* in the scene's arrays, but for those that have arrived since */
    DEVICE_LAST_KEPT,    /* in `previous`: copied there before a frame of another user overwrote them */
};

/** What one renderer has of a scene that others may share. It is not moved in memory while the scene is open. */
struct device_scene_user {
    struct device_scene *scene;
    struct device_scene_user *next; /* of those that share the scene */
    uint32_t pool_triangles;        /* of the room behind the indices: what its culling of a view fills */
    struct gpu_buffer faded_lights, faded_bounds; /* copies for frames with light_lod; made when first asked for */

    bool wants_previous; /* the frame being made wants to know where instances and vertices were in its last one */
    bool keeps_previous; /* the last frame did: its instances and vertices are kept for the next */
    enum device_last last;
    uint64_t transform_version, arrived; /* what the last frame drew: transforms of the scene, and so many arrivals */
    struct gpu_buffer previous;
    struct device_previous kept; /* in it */
    bool keeping;                /* the frame that was declared copies to it */
};

/** Finds the scene on the device, or begins it. FNL_ERROR_MEMORY. */
fnl_result device_scene_open(gpu_device *device, fnl_scene *scene, struct device_scene_user *out);
/** The last to close it destroys it. Frames of all users must be over. Once more does no harm. */
void device_scene_close(struct device_scene_user *user);

/**
 * Uploads what changed in the scene's structure; blocks while images are decoded. Call outside of frames. After an error, and where the device
 * has one that sticks, everything is uploaded again with the next call.
 */
fnl_result device_scene_prepare(struct device_scene *d);
/** Then: room behind the scene's indices for so many triangles of this user's culling, for each of the views that are culled before one of them is drawn. Others fill the same room. */
fnl_result device_scene_reserve_triangles(struct device_scene_user *user, uint32_t count, uint32_t views);
/** Everything is uploaded again with the next device_scene_prepare. */
void device_scene_forget(struct device_scene *d);

struct device_scene_frame {
    struct geometry_scene geometry;
    struct light_set lights;
    struct environment_light environment; /* without reflection probes */
    bool layered;              /* some material has layers */
    bool moved;                /* instances or vertices are elsewhere than in the user's last frame */
    bool lost;                 /* the frame wants what the last one drew, and that is not known (any more) */
    /** With wants_previous, where something moved or came: what the user's last frame drew, with rows of 0 for instances that it did not
        draw. Else id 0. */
    graph_buffer previous;
    struct device_previous previous_layout;
};
/**
 * Declares a user's frame: its updates (moved instances, lights, skinning), before which it keeps what other users' last frames drew, and
 * imports the buffers. Nothing of it counts until device_scene_submitted: a frame that fails, or is declared for its pipelines alone, is
 * taken back by the next call.
 */
fnl_result device_scene_add(struct device_scene_user *user, struct graph *graph, struct device_scene_frame *out);
/** The frame that was declared last, a user's, was submitted. */
void device_scene_submitted(struct device_scene_user *user);

/* ---- the parts ---- */

void device_scene_init(struct device_scene *d, gpu_device *device, fnl_scene *scene);
void device_scene_finish(struct device_scene *d);

/** Outside of frames: room for what users keep (users.c). */
fnl_result device_users_prepare(struct device_scene *d);
/** All places of instances are others: what users drew is not known any more. */
void device_users_lose(struct device_scene *d);
/** Where instances have arrived: forgets arrivals that all users have drawn. */
void device_users_trim(struct device_scene *d);
/** In a user's frame, before instances or vertices change (d->overwrites: they do). */
fnl_result device_users_add(struct device_scene_user *user, struct graph *graph, graph_buffer vertices,
                            struct device_scene_frame *out);

/** Makes a device buffer and fills it; of size 0 it is as small as can be. */
fnl_result device_upload_array(struct device_scene *d, enum gpu_use use, const char *name, struct gpu_buffer *buffer, const void *data,
                               uint64_t size);

fnl_result device_upload(struct device_scene *d, const struct gpu_buffer *buffer, uint64_t offset, const void *data,
                         uint64_t size);
/** Room for `needed` bytes; the first `used` stay. What is made larger becomes half as large again at least. */
fnl_result device_buffer_reserve(struct device_scene *d, enum gpu_use use, const char *name, struct gpu_buffer *buffer, uint64_t used,
                                 uint64_t needed);
/** Makes the array hold `count` elements of `stride` bytes. Sends the elements that differ from what it held. */
fnl_result device_array_set(struct device_scene *d, enum gpu_use use, const char *name, struct device_array *array, const void *data,
                            uint64_t count, uint32_t stride);

/** Whether a node shows a mesh. */
static inline bool device_node_draws(const struct scene_node *node) {
    return scene_node_draws(node);
}

/** Outside of frames: sends the environment's picture, or what an earlier run has kept of it (environment.c). */
fnl_result device_environment_prepare(struct device_scene *d);
/** Declares what a frame shades with, and filters what is new. */
struct environment_light device_environment_add(struct device_scene *d, struct graph *graph);
void device_environment_finish(struct device_scene *d);

/** Outside of frames: makes room in the buffers for all lights (lights.c). */
fnl_result device_lights_prepare(struct device_scene *d);
void device_lights_finish(struct device_scene *d);
/** Declares the update of the light array: sends only the lights that changed, but all directional ones if any of those did. */
fnl_result device_lights_add(struct device_scene *d, struct graph *graph, graph_buffer lights);
/** For each directional light, then for each place: 0, or a number of the request that its shadow maps were last drawn for (fnl_shadow_update). */
void device_lights_updates(const struct device_scene *d, uint32_t *out);
/** The lights as one frame sees them. */
struct light_set device_lights_set(const struct device_scene *d, graph_buffer lights);
/** The part that needs no device: fills light_data, light_bounds, sun_data and plane_data from d->scene. */
fnl_result device_lights_gather(struct device_scene *d);
/** Local lights that the next frame lights with: of the scene as it is now, before they are gathered. Costs a look at what changed. */
uint32_t device_lights_count(const struct device_scene *d);
/**
 * For frames with a light_lod (0: none): lists that the CPU builds see faded lights too (passes/lights/sprites.h). Costs a walk over the
 * lights where `walk` says that the frame has such lists, or to undo it.
 */
fnl_result device_lights_fade(struct device_scene_user *user, const struct gpu_view *view, float lod, bool walk);

/** What a frame traces shadow rays through, and what else it wants of the trees. */
struct device_rays_use {
    bool trees, query; /* the trees; the device's own structures, where it has fnl_device_info.ray_query */
    bool items;        /* the tree over items, which drawing maps goes through too. Where both others are false it is all that is wanted */
};
/** Outside of frames, after device_scene_prepare, for frames that trace shadow rays, or want the tree over items alone (rays.c). */
fnl_result device_rays_prepare(struct device_scene *d, struct device_rays_use use);
/** Then, in the frame: makes what of it changed. `geometry` is of device_scene_add. */
struct rays device_rays_add(struct device_scene *d, struct graph *graph, const struct geometry_scene *geometry, struct device_rays_use use);
void device_rays_finish(struct device_scene *d);

/** The same for the device's own structures (structures.c); `out` points into `d`. */
fnl_result device_structures_prepare(struct device_scene *d);
fnl_result device_structures_add(struct device_scene *d, struct ray_query_input *out);
/** The frame that was declared last was submitted. */
void device_structures_submitted(struct device_scene *d);
/** All of them are built anew. */
void device_structures_forget(struct device_scene *d);
void device_structures_finish(struct device_scene *d);

/** Outside of frames, when structure or decals changed: pictures, tables of mesh decals. */
fnl_result device_decals_prepare(struct device_scene *d);
void device_decals_finish(struct device_scene *d);
/** The decals as one frame sees them; buffers of id 0 where there are none of the kind. */
struct device_decals_frame {
    graph_buffer decals, bounds, mesh_ranges, mesh_ids, redraw_draws;
};
/** What lists see of decal `index`, a box that `transform` makes of the cube -1/2 .. 1/2: the sphere round it. */
struct gpu_entity_bounds device_decal_bounds(const mat4 *transform, uint32_t index);
/** Sends what changed. */
fnl_result device_decals_add(struct device_scene *d, struct graph *graph, struct device_decals_frame *out);

/** Uploads the images that materials use, decoded on all threads; those that may come later are only asked for (images.c). */
fnl_result device_images_upload(struct device_scene *d);
/**
 * Sends so many bytes of what was decoded since, and gives materials and decals the images that are whole now. A quarter of the upload ring:
 * nobody waits for room in it.
 */
#define DEVICE_IMAGE_BYTES (8ull << 20)
fnl_result device_images_take(struct device_scene *d);
/** Frees all, and waits for those that are being decoded. */
void device_images_free(struct device_scene *d);
/** Has a picture decoded in the background, unless it is already. */
fnl_result device_image_ask(struct device_scene *d, uint32_t image);
/**
 * Decodes pictures on all threads, to RGBA8, or with `blocks` also to blocks that the device samples. `deliver` is called for each, on this one; its
 * texture is NULL where it is broken, which is logged.
 */
typedef fnl_result device_image_deliver(struct device_scene *d, uint32_t image, const struct texture *texture);
fnl_result device_images_decode(struct device_scene *d, const uint32_t *images, uint32_t count, bool blocks, device_image_deliver *deliver);
/** Of a scene's image that is encoded, for the pictures of decals that wait for it (decals.c). */
device_image_deliver device_decals_deliver;

/**
 * After the images; the last material is glTF's default, for primitives without one (materials.c). `out_regroup`: whether items have to be
 * sorted anew, because a material is in other buckets than the last time.
 */
fnl_result device_materials_upload(struct device_scene *d, bool *out_regroup);
/** Whether a material's texture is there, or will come. */
bool device_has_texture(const struct device_scene *d, const struct scene_material *material, enum scene_texture_slot slot);
/**
 * Makes the atlas of virtual texturing, `side` texels at most, unless it is there (virtual.c). The atlas cannot hold materials whose
 * textures differ in coordinates or wraps, or are not filtered smoothly.
 */
fnl_result device_virtual_prepare(struct device_scene *d, uint32_t side, struct virtual_atlas *atlas);
bool device_virtual_holds(const struct device_scene *d, const struct scene_material *material);
/** Whether a material has layers, as of the last upload. */
bool device_has_layers(const struct device_scene *d);
/** A bit for each G-buffer layout that cannot hold a material, VIRTUAL_FORWARD and GEOMETRY_LAYERED; `id` is its index. */
uint32_t device_material_forward_layouts(const struct device_scene *d, const struct scene_material *material, uint32_t id);

/** What has come of vertices, indices, clusters and what deforms; then everything below (geometry.c). */
fnl_result device_geometry_upload(struct device_scene *d);
/** Takes and gives back the places of nodes, and sends the instances of those that got one (nodes.c). `nodes` NULL: of all. */
fnl_result device_nodes_place(struct device_scene *d, const uint32_t *nodes, uint32_t count);
/**
 * Follows edits of nodes since a structure_version, with the outcome of device_geometry_upload(). `*done` is false where there are too
 * many, or one has several instances or deforms; nothing has changed then. Costs what was edited, and moving the items behind it.
 */
fnl_result device_nodes_edit(struct device_scene *d, uint64_t since, bool *done);
bool device_node_mirrors(const fnl_scene *scene, const struct scene_node *node);
/** Whether the vertices of a primitive are the node's own, moved every frame. */
bool device_node_deforms(const struct scene_node *node, const struct scene_primitive *p);
/** Logs it. */
fnl_result device_too_many_vertices(const struct device_scene *d);

/** Items, groups and buckets, of d->primitives (items.c). */
fnl_result device_items_upload(struct device_scene *d);
/** The items of a node that has one instance and does not deform, out of the lists or into them; then device_items_send. */
void device_items_remove(struct device_scene *d, uint32_t node);
fnl_result device_items_insert(struct device_scene *d, uint32_t node);
fnl_result device_items_send(struct device_scene *d);
/** What an item shows, as the public interface names it (objects_add of passes/debug/debug.h). */
struct device_object {
    uint32_t instance;  /* index of the query functions + 1 */
    uint32_t primitive; /* of the instance's mesh */
    int32_t material;   /* -1: glTF's default one */
};
/** Those of all items, d->item_count of them. Costs a look at each item, and where nodes were removed at each node. */
fnl_result device_items_name(const struct device_scene *d, struct device_object *out);
/** The addresses of all arrays (geometry.c). */
fnl_result device_table_send(struct device_scene *d);
/** Object to world of one of a node's instances, at its present pose; and the device form of all of them. */
mat4 device_instance_matrix(const fnl_scene *scene, const struct scene_node *node, uint32_t k);
void device_scene_node_instances(const fnl_scene *scene, const struct scene_node *node, struct gpu_instance *out);

#endif
