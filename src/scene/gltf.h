/* SPDX-License-Identifier: MIT */
/**
 * Inside the glTF importer. Rules of its functions: every complaint names the file and the JSON pointer; what is wrong in
 * one place becomes a warning there and the part is left out; only what makes the file unusable (and lack of memory) sets
 * gltf.result, after which every function returns quickly and the load fails.
 */
#ifndef FNL_SCENE_GLTF_H
#define FNL_SCENE_GLTF_H

#include "scene/scene.h"

#include <jansson.h>

/** A place in the document: a chain of keys and array indices up to the root. Lives on the stack, costs nothing. */
struct at {
    const struct at *parent; /* NULL: this is the root */
    const char *key;         /* NULL: an array index */
    size_t index;
};
#define AT_KEY(up, name) (&(const struct at){.parent = (up), .key = (name)})
#define AT_INDEX(up, i) (&(const struct at){.parent = (up), .index = (i)})

/** Writes the JSON pointer of a place, "/" for the root; long ones lose their head. */
void gltf_pointer(const struct at *at, char *out, size_t capacity);

struct gltf_buffer {
    const unsigned char *data; /* NULL: nothing to read (placeholder, or not found) */
    uint64_t size;             /* as declared */
    bool valid;
};

struct gltf_view {
    const unsigned char *data; /* NULL: nothing to read */
    uint64_t size;
    uint32_t stride; /* 0: not given */
    bool valid;
    uint32_t attribute_accessor; /* the first accessor that reads vertex attributes from here, or SCENE_NONE */
};

enum gltf_component {
    GLTF_BYTE = 5120,
    GLTF_UNSIGNED_BYTE = 5121,
    GLTF_SHORT = 5122,
    GLTF_UNSIGNED_SHORT = 5123,
    GLTF_UNSIGNED_INT = 5125,
    GLTF_FLOAT = 5126,
};

enum gltf_type { GLTF_SCALAR, GLTF_VEC2, GLTF_VEC3, GLTF_VEC4, GLTF_MAT2, GLTF_MAT3, GLTF_MAT4 };

/** Vertex data of one accessor that several primitives share is decoded once per use. */
enum gltf_use {
    GLTF_USE_POSITION,
    GLTF_USE_NORMAL,
    GLTF_USE_TANGENT,
    GLTF_USE_UV,
    GLTF_USE_COLOR,
    GLTF_USE_MORPH,
    GLTF_USE_INDEX,
    GLTF_USE_COUNT
};

struct gltf_accessor {
    bool valid, normalized;
    bool compressed; /* stands in a primitive with KHR_draco_mesh_compression: without a view it is a format alone */
    enum gltf_component component;
    enum gltf_type type;
    uint32_t count;
    uint32_t view; /* SCENE_NONE: zeros */
    uint64_t offset;
    struct {
        uint32_t count; /* 0: not sparse */
        uint32_t index_view, value_view;
        uint64_t index_offset, value_offset;
        enum gltf_component index_component;
    } sparse;
    void *decoded[GLTF_USE_COUNT];
};

/** Where a vertex went when unused ones were dropped; entries with an old stamp count as unset. */
struct gltf_vertex_map {
    uint32_t stamp, index;
};

/** TEXCOORD_n, JOINTS_n and so on are read for n below this. */
#define GLTF_SET_MAX 16u

/** What a primitive's joints ask of a skin. */
struct gltf_primitive_joints {
    uint32_t source; /* its number in the document's mesh, which may have lost others */
    uint32_t set_count;
    uint32_t highest[GLTF_SET_MAX],
        highest_used[GLTF_SET_MAX]; /* of each JOINTS_n: the highest joint at all, and with a weight */
};

struct gltf_texture {
    uint32_t image, sampler; /* of the scene; image SCENE_NONE: there is none */
};

struct gltf_camera {
    bool valid;
    const char *name, *extras;
    fnl_camera camera;
};

struct gltf_light {
    bool valid;
    const char *name, *extras;
    fnl_light_params params;
};

enum gltf_target_kind {
    GLTF_TARGET_NODE,
    GLTF_TARGET_MESH,
    GLTF_TARGET_MATERIAL,
    GLTF_TARGET_LIGHT,
    GLTF_TARGET_CAMERA,
    GLTF_TARGET_ENVIRONMENT,
    GLTF_TARGET_UNUSED, /* what this renderer has no use for */
    GLTF_TARGET_KIND_COUNT
};

/** What a channel of an animation sets. */
struct gltf_target {
    enum gltf_target_kind kind;
    enum scene_animation_path path;
    uint32_t index; /* in the document */
    const struct scene_property *property; /* or NULL */
    uint32_t width, first_weight; /* as of struct scene_channel */
    bool one_weight;
    const char *pointer; /* NULL: plain glTF */
};

/** What shows a mesh, light or camera of the document: chains that end with SCENE_NONE. */
struct gltf_users {
    uint32_t *first, *next;
};

struct gltf {
    fnl_scene *scene;
    const fnl_host *host;
    const char *name;   /* of the file, for messages */
    const char *folder; /* NULL: the file is read from memory */
    fnl_load_params params;
    json_t *root;
    json_t *document; /* a copy that is to be saved, or NULL */
    struct at top;
    struct arena scratch; /* freed when the load ends */
    fnl_result result;    /* what the load came to so far */
    uint64_t budget;      /* bytes that may still be decoded in proportion to the size of the file */
    uint64_t memory_left; /* of params.max_memory */
    uint32_t steps_done, steps_total; /* for params.progress */
    uint64_t check_left;  /* bytes that may still be compared with declared bounds */

    bool is_glb;
    const unsigned char *binary; /* the GLB's BIN chunk, or NULL */
    uint64_t binary_size;

    struct gltf_buffer *buffers;
    struct gltf_view *views;
    struct gltf_accessor *accessors;
    uint32_t buffer_count, view_count, accessor_count, node_count, mesh_count, skin_count, material_count, image_count,
        texture_count, sampler_count, camera_count, light_count;

    struct gltf_texture *textures;
    uint32_t *image_twin; /* of each image: its copy for the other colour use, or SCENE_NONE */
    bool *image_used;
    uint8_t *image_transfer; /* enum texture_transfer: how its file says that colours are stored */
    ARRAY(struct gltf_primitive_joints) primitive_joints; /* by scene primitive */
    ARRAY(struct gltf_vertex_map) vertex_map;             /* scratch of gltf_load_indices */
    uint32_t vertex_map_stamp;
    struct gltf_camera *cameras;
    struct gltf_light *lights;
    fnl_light_profile_id *profiles; /* of EXT_lights_ies; all-zero: broken */
    uint32_t profile_count;
    uint32_t *variant_stamps, variant_stamp; /* scratch of gltf_load_mappings */
    uint32_t *node_lights; /* by node: a light, or SCENE_NONE */
    struct gltf_users users[GLTF_TARGET_KIND_COUNT]; /* of gltf_first_user */
    bool *in_scene;        /* by node: part of the shown scene, visible or not */
    bool *hidden;          /* by node: KHR_node_visibility hides it and what is below */
};

/** Loads the file of a scene again, out of what the scene has kept of it; `out_root` gets its JSON. */
fnl_result gltf_load_again(const fnl_host *host, const fnl_scene *scene, fnl_scene **out, json_t **out_root);

/** One step is done: tells the host, which may cancel the load (gltf.c). */
void gltf_step(struct gltf *g);

/* ---- messages (gltf_json.c) ---- */

/** A warning; the part is left out or mended, as the text says. */
void gltf_warn(struct gltf *g, const struct at *at, const char *format, ...) __attribute__((format(printf, 3, 4)));
/** An error that ends the load. */
void gltf_fail(struct gltf *g, fnl_result result, const struct at *at, const char *format, ...)
    __attribute__((format(printf, 4, 5)));
/** Out of memory (already logged by the allocator). */
void gltf_fail_memory(struct gltf *g);
/** An error where the load is not lenient, else a warning that what stands there is ignored. */
void gltf_refuse(struct gltf *g, fnl_result result, const struct at *at, const char *format, ...)
    __attribute__((format(printf, 4, 5)));
/** Takes `bytes` from params.max_memory; an error when that is used up. Before the memory is allocated. */
bool gltf_take_memory(struct gltf *g, const struct at *at, uint64_t bytes);
/** The same, and from what is in proportion to the file; warns when that alone is used up. False: leave the part out. */
bool gltf_spend(struct gltf *g, const struct at *at, uint64_t bytes);
/** Gives back what was only needed for a while. */
void gltf_refund(struct gltf *g, uint64_t bytes);
/** Zeroed memory that lives until the load ends / as long as the scene. NULL sets the result. Size 0 gives a block. */
void *gltf_scratch(struct gltf *g, uint64_t count, size_t size);
void *gltf_keep(struct gltf *g, uint64_t count, size_t size);

/** A host for calls whose failure is only a warning here: it keeps the line that they log. */
struct gltf_quiet_host {
    fnl_host host;
    const fnl_host *inner;
    char line[400];
};
void gltf_quiet_host_init(struct gltf_quiet_host *quiet, const fnl_host *inner);

/* ---- reading the document (gltf_json.c) ---- */

/** Members of the stated type, else NULL with a warning; absent ones warn only when `required`. */
json_t *gltf_object(struct gltf *g, json_t *object, const struct at *at, const char *key, bool required);
/** Arrays that are there must not be empty. */
json_t *gltf_array(struct gltf *g, json_t *object, const struct at *at, const char *key, bool required);
/** An element that must be an object, else NULL with a warning. */
json_t *gltf_element(struct gltf *g, json_t *array, const struct at *at, size_t index);
/** Number of elements, at most UINT32_MAX - 1; NULL has none. */
uint32_t gltf_count(json_t *array);
const char *gltf_string(struct gltf *g, json_t *object, const struct at *at, const char *key, bool required);
/** A copy of "name" in the scene, "" without one. Never NULL. */
const char *gltf_name(struct gltf *g, json_t *object, const struct at *at);
/** "extras" as JSON text in the scene, or NULL. */
const char *gltf_extras(struct gltf *g, json_t *object);
bool gltf_bool(struct gltf *g, json_t *object, const struct at *at, const char *key, bool fallback);
/** A whole number in low..high. False: absent or wrong (warned); `out` is then unchanged. */
bool gltf_uint(struct gltf *g, json_t *object, const struct at *at, const char *key, bool required, uint64_t low,
               uint64_t high, uint64_t *out);
/** An index below `count`; SCENE_NONE when absent or wrong. */
uint32_t gltf_index(struct gltf *g, json_t *object, const struct at *at, const char *key, bool required, uint32_t count);
/** The same for an array element. */
uint32_t gltf_index_value(struct gltf *g, json_t *value, const struct at *at, uint32_t count);
/** A finite number; outside low..high it is clamped with a warning. False: absent or no number; `out` is unchanged. */
bool gltf_float(struct gltf *g, json_t *object, const struct at *at, const char *key, bool required, float low, float high,
                float *out);
/** A unit quaternion; others are normalized with a warning. False: absent or no quaternion. */
bool gltf_rotation(struct gltf *g, json_t *object, const struct at *at, const char *key, quat *out);
bool gltf_exact_rotation(struct gltf *g, json_t *object, const struct at *at, const char *key, double out[4]);
/** Exactly `count` finite numbers (16 at most), clamped as in gltf_float(). */
bool gltf_doubles(struct gltf *g, json_t *object, const struct at *at, const char *key, uint32_t count, float low, float high,
                  double *out);
bool gltf_floats(struct gltf *g, json_t *object, const struct at *at, const char *key, uint32_t count, float low, float high,
                 float *out);
/** extensions/NAME of an object, or NULL; `place` gets where it stands: warn at &place.extension. */
struct gltf_extension_place {
    struct at extensions, extension;
};
json_t *gltf_extension(json_t *object, const struct at *at, const char *name, struct gltf_extension_place *place);
/** Whether extensionsUsed names it. */
bool gltf_uses(const struct gltf *g, const char *extension);

/* ---- the parts, in the order in which they are loaded ---- */

/** Checks extensionsUsed and extensionsRequired, and every extension object's place (gltf_extension.c). */
void gltf_load_extensions(struct gltf *g);

void gltf_load_buffers(struct gltf *g); /* buffers and bufferViews (gltf_buffer.c) */
/**
 * The bytes behind a URI: decoded data, a mapped file, or what the resolver hands over (gltf_uri.c). False when there are none: it is
 * refused (gltf_refuse) when it may not be read or `needed` is set, else a warning.
 */
bool gltf_read_uri(struct gltf *g, const struct at *at, const char *uri, bool needed, const unsigned char **data,
                   uint64_t *size);
bool gltf_is_data_uri(const char *uri);
/** The media type of a data URI, such as "image/png", in lower case; false when there is none, or it is longer than `capacity` - 1. */
bool gltf_uri_media_type(const char *uri, char *out, size_t capacity);
/** Decodes KHR_ or EXT_meshopt_compression of a bufferView (gltf_meshopt.c). False (warned) when it is broken. */
bool gltf_decode_meshopt(struct gltf *g, json_t *extension, const struct at *at, struct gltf_view *view);

void gltf_load_accessors(struct gltf *g); /* gltf_accessor.c */
/** Marks accessors of primitives with KHR_draco_mesh_compression, and decodes those primitives (gltf_draco.c). */
void gltf_mark_compressed(struct gltf *g);
void gltf_load_compressed(struct gltf *g);
uint32_t gltf_component_size(enum gltf_component component);
uint32_t gltf_type_components(enum gltf_type type);
/** "VEC3 of UNSIGNED_SHORT", for messages. */
const char *gltf_format_name(const struct gltf_accessor *accessor, char *out, size_t capacity);
/** Element `index` of a sparse accessor's indices. */
uint32_t gltf_sparse_index(const struct gltf *g, const struct gltf_accessor *accessor, uint32_t index);
/** Bytes from one element to the next, of the view and of tightly packed ones. */
uint32_t gltf_accessor_stride(const struct gltf *g, const struct gltf_accessor *accessor);
uint32_t gltf_packed_stride(const struct gltf_accessor *accessor);
/** As stored: "normalized" has no effect. Exact for all types. */
double gltf_component_value(const unsigned char *bytes, enum gltf_component component);
/** Where a component lies in its element. */
uint32_t gltf_component_offset(const struct gltf_accessor *accessor, uint32_t component);
/** Compares the elements of a valid accessor with its 'min' and 'max' and warns where they differ (gltf_bounds.c). */
void gltf_check_bounds(struct gltf *g, json_t *object, const struct at *at, const struct gltf_accessor *accessor);
/** Whether the accessor's bytes are there; warns at `at` when it is broken, and refuses the file when they are missing. */
bool gltf_accessor_readable(struct gltf *g, uint32_t accessor, const struct at *at);
/** All elements as floats, integers normalised where the accessor says so. `out` holds count * components. */
bool gltf_read_floats(struct gltf *g, uint32_t accessor, const struct at *at, float *out);
/** All elements as unsigned integers; for unsigned component types. */
bool gltf_read_uints(struct gltf *g, uint32_t accessor, const struct at *at, uint32_t *out);

void gltf_load_images(struct gltf *g);    /* images, samplers, textures (gltf_image.c) */
/** gltf_take_memory for a picture as it will be decoded. */
bool gltf_take_image(struct gltf *g, const struct at *at, uint32_t width, uint32_t height);
void gltf_load_materials(struct gltf *g); /* gltf_material.c */
void gltf_load_variants(struct gltf *g);  /* of materials: their names (gltf_variant.c) */
/** What material a primitive has in each variant; its own one is there. False: lack of memory. */
bool gltf_load_mappings(struct gltf *g, json_t *primitive, const struct at *at, struct scene_primitive *out);
void gltf_load_meshes(struct gltf *g);    /* gltf_mesh.c */
/** The vertices that a primitive's indices name; `source` NULL means all, in order. */
struct gltf_selection {
    const uint32_t *source;
    uint32_t count;
};
/**
 * Indices, expanded to plain triangles, lines or points, over `vertex_count` vertices (gltf_index.c). When the indices
 * name fewer vertices than there are, only those are selected. False (warned): the primitive is left out.
 */
bool gltf_load_indices(struct gltf *g, json_t *primitive, const struct at *at, uint32_t vertex_count,
                       struct scene_primitive *out, struct gltf_selection *selection);

enum gltf_semantic {
    GLTF_POSITION,
    GLTF_NORMAL,
    GLTF_TANGENT,
    GLTF_TEXCOORD,
    GLTF_COLOR,
    GLTF_JOINTS,
    GLTF_WEIGHTS,
    GLTF_SEMANTIC_COUNT
};
/** Accessors of a primitive or of a morph target: [semantic][set], SCENE_NONE where there is none that can be used. */
struct gltf_attributes {
    uint32_t accessor[GLTF_SEMANTIC_COUNT][GLTF_SET_MAX];
};
/** Checks every attribute (gltf_attribute.c). `base` is NULL for the primitive itself, its attributes for a morph target. */
void gltf_find_attributes(struct gltf *g, json_t *object, const struct at *at, const struct gltf_attributes *base,
                          struct gltf_attributes *out);
/** Fills in the vertex arrays (gltf_vertex.c). False (warned): the primitive is left out. */
bool gltf_load_vertices(struct gltf *g, json_t *primitive, const struct at *at, const struct gltf_attributes *attributes,
                        const struct gltf_selection *selection, struct scene_primitive *out);
/** Joints and weights of a primitive (gltf_skin.c). False (warned): it is shown without its skin. */
bool gltf_load_joints(struct gltf *g, const struct at *at, const struct gltf_attributes *attributes,
                      const struct gltf_selection *selection, struct scene_primitive *out,
                      struct gltf_primitive_joints *joints);
void gltf_load_cameras(struct gltf *g); /* cameras and lights, before they are placed (gltf_light.c) */
/** EXT_lights_ies (gltf_ies.c): the profiles; and the light that a node has by it, false: none. */
void gltf_load_profiles(struct gltf *g);
bool gltf_read_profile_light(struct gltf *g, uint32_t node, fnl_light_params *out);
void gltf_load_nodes(struct gltf *g);   /* the hierarchy, which nodes are shown, what they carry (gltf_node.c) */
void gltf_load_scenes(struct gltf *g);  /* gltf_scene.c */
/** EXT_mesh_gpu_instancing of a node (gltf_scene.c). */
void gltf_load_instances(struct gltf *g, json_t *extension, const struct at *at, struct scene_node *node);
void gltf_load_skins(struct gltf *g);      /* skins, and whether the skinned meshes fit them (gltf_skin.c) */
void gltf_place(struct gltf *g);           /* puts cameras and lights on the shown nodes (gltf_light.c) */
/** A mask of 8 bits in the extras of an object: `*mask` stays as it is if there is none of this name (gltf_light.c). */
void gltf_mask(struct gltf *g, json_t *object, const struct at *at, const char *name, uint32_t *mask);
void gltf_load_decals(struct gltf *g);     /* FNL_decal of the shown nodes (gltf_decal.c) */
void gltf_load_animations(struct gltf *g); /* gltf_animation.c */
/** What a pointer of KHR_animation_pointer names (gltf_animation_pointer.c). False (warned): it cannot be animated. */
bool gltf_find_target(struct gltf *g, const char *pointer, const struct at *at, struct gltf_target *target);
/** The properties that a pointer can name, one after the other: false beyond the last. `pointer` has '#' for an index. */
bool gltf_query_property(uint32_t index, const char **pointer, uint32_t *width, const struct scene_property **out);
/** The first node that shows a mesh with its weights, or scene light, or scene camera; the others follow by gltf.users. */
uint32_t gltf_first_user(struct gltf *g, enum gltf_target_kind kind, uint32_t index);
void gltf_load_environment(struct gltf *g); /* EXT_lights_image_based (gltf_environment.c) */
void gltf_load_surroundings(struct gltf *g); /* FNL_surroundings (gltf_surroundings.c) */
/** MSFT_lod (gltf_lod.c): of nodes; and, when all else is there, of the materials that nodes show. */
void gltf_load_levels(struct gltf *g);
void gltf_load_material_levels(struct gltf *g);
void gltf_load_xmp(struct gltf *g);        /* KHR_xmp_json_ld (gltf_xmp.c) */

#endif
