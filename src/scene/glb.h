/* SPDX-License-Identifier: MIT */
/**
 * Inside fnl_scene_save. A scene that came from a file keeps the file's JSON, and is compared with the scene that the file makes when it is loaded
 * again: what differs is patched in. What the file has not (all of it, where there is none) is written anew. Errors set glb.result, after which every
 * function returns quickly.
 */
#ifndef FNL_SCENE_GLB_H
#define FNL_SCENE_GLB_H

#include "scene/gltf.h"

/** Bytes of the binary chunk; they live until the file is written. */
struct glb_part {
    const void *data;
    uint64_t size;
};

struct glb_texture {
    uint32_t image, sampler; /* of the scene */
    uint32_t index;          /* in the file */
};

struct glb {
    const fnl_scene *scene;
    const fnl_scene *file; /* what the scene was when it was loaded; NULL: it came from no file */
    const fnl_host *host;
    const char *path;
    json_t *root;
    fnl_result result;
    struct arena memory;
    uint32_t max_size;
    ARRAY(struct glb_part) parts;
    uint64_t size; /* of all parts */

    /* How many of each the document has: these are at the same index in the scene. */
    uint32_t node_count, mesh_count, material_count, image_count, sampler_count, skin_count;
    /* Where the scene's are in the file; SCENE_NONE: not there (yet). */
    uint32_t *nodes, *meshes, *materials, *images, *samplers, *skins;
    ARRAY(struct glb_texture) textures;
    ARRAY(char *) pictures; /* of free() */
    struct {
        const void *data;
        uint32_t count, accessor;
        enum gltf_type type;
    } known[64]; /* the last arrays */
    uint32_t known_next;
};

/* ---- glb.c ---- */

void glb_fail(struct glb *g, fnl_result result, const char *format, ...) __attribute__((format(printf, 3, 4)));
/** What the file cannot say. */
void glb_left_out(const struct glb *g, const char *format, ...) __attribute__((format(printf, 2, 3)));
/** Memory until the file is written; NULL sets the result. */
void *glb_memory(struct glb *g, uint64_t count, size_t size);
/** Appends bytes at a multiple of four; where they begin. */
uint64_t glb_add_bytes(struct glb *g, const void *data, uint64_t size);
/** Each gives its index. */
uint32_t glb_add_view(struct glb *g, const void *data, uint64_t size, int target);
enum { GLB_VERTICES = 34962, GLB_INDICES = 34963 };
uint32_t glb_add_accessor(struct glb *g, const void *data, uint32_t count, enum gltf_component component, enum gltf_type type, int target);

/* JSON. Values are taken over; NULL is lack of memory. */
json_t *glb_float(float value);
/** A name, which JSON cannot hold unless it is UTF-8: otherwise cleaned, with a warning. */
json_t *glb_text(const struct glb *g, const char *text);
json_t *glb_floats(const float *values, uint32_t count);
json_t *glb_doubles(const double *values, uint32_t count);
void glb_set(struct glb *g, json_t *object, const char *key, json_t *value);
/** The object or array at a key, made if it is not there. */
json_t *glb_object(struct glb *g, json_t *object, const char *key);
json_t *glb_array(struct glb *g, json_t *object, const char *key);
/** extensions/NAME of an object, likewise; extensionsUsed gets the name. */
json_t *glb_extension(struct glb *g, json_t *object, const char *name);
/** Takes it away, and "extensions" if nothing else is there. */
void glb_remove_extension(json_t *object, const char *name);
uint32_t glb_append(struct glb *g, json_t *array, json_t *value);
/** Appends to an array of the document; the index. */
uint32_t glb_add(struct glb *g, const char *array, json_t *value);
/** What an object of the extras says, beside what else is in them; an empty one goes. */
void glb_set_extra(struct glb *g, json_t *object, const char *name, json_t *value);
void glb_set_name(struct glb *g, json_t *object, const char *name, const char *extras);
/** Whether an animation of the file sets a property of a node; or of something else. */
bool glb_animates_node(const struct glb *g, uint32_t node, enum scene_animation_path path);
bool glb_animates(const struct glb *g, enum scene_property_owner owner, uint32_t object, size_t offset);

/* ---- the parts ---- */

/** The scene that is shown: made, with all roots of the file, where there is none. And its nodes. */
json_t *glb_shown_scene(struct glb *g);
json_t *glb_roots(struct glb *g);
/** Adds `node`, with the members it has, as a root: rotation `turn`, translation `place`, independent of the origin. */
void glb_add_root(struct glb *g, json_t *node, const mat4 *turn, const double place[3]);
/** A matrix whose -Z axis and +Y axis make exactly this direction and this up again, as lights take them from their nodes. */
mat4 glb_turn(vec3 direction, vec3 up);

uint32_t glb_material(struct glb *g, uint32_t material); /* where it is in the file; written, if it was not */
uint32_t glb_mesh(struct glb *g, uint32_t mesh);
void glb_save_materials(struct glb *g); /* glb_material.c */
void glb_save_meshes(struct glb *g);    /* glb_mesh.c */
void glb_save_nodes(struct glb *g);     /* glb_node.c: with cameras, skins and animations */
void glb_save_lights(struct glb *g);    /* glb_light.c */
void glb_save_surroundings(struct glb *g); /* glb_surroundings.c; and what is left out */
/** One buffer in place of the document's, and its images in it (glb_document.c). */
void glb_embed(struct glb *g);
void glb_finish_buffers(struct glb *g);

#endif
