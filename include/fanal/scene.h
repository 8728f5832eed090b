/* SPDX-License-Identifier: MIT */
/**
 * Scenes: loaded from glTF, made by built-in generators, or put together by calls. A scene lives in host memory and
 * needs no device; one scene may be rendered by several renderers. Calls on one scene are not thread-safe. This header
 * includes those of everything that a scene is made of.
 *
 * Units are glTF's: metres, radians, candela (lights that spread), lux (directional and box). Right-handed, +Y up.
 */
#ifndef FANAL_SCENE_H
#define FANAL_SCENE_H

#include "fanal/camera.h"
#include "fanal/decal.h"
#include "fanal/environment.h"
#include "fanal/image.h"
#include "fanal/instance.h"
#include "fanal/light.h"
#include "fanal/light_kinds.h"
#include "fanal/mesh.h"
#include "fanal/probe.h"
#include "fanal/scene_ids.h"
#include "fanal/scene_query.h"
#include "fanal/values.h"

#ifdef __cplusplus
extern "C" {
#endif

/** An empty scene. `host` may be NULL. */
FNL_API fnl_result fnl_scene_create(const fnl_host *host, fnl_scene **out);

/* ---- loading ---- */

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
     * if that fails, otherwise when the file is unloaded (fnl_scene_remove_instance) or during fnl_scene_destroy. Any other
     * result means that the resource is missing, and nothing is released; FNL_ERROR_MEMORY ends the load. The callbacks must not
     * use the scene. Default NULL.
     */
    fnl_result (*resolve)(void *user, const char *uri, fnl_resource *out);
    /**
     * Frames do not wait for the images of this file. No image is decoded while a file is loaded, in any case: a renderer decodes those that
     * it needs, before its first frame, on all threads. With `async` it does so in the background, from its first frame (or
     * fnl_renderer_warm) on. Until an image is there, materials show their factors alone, without emission if it is that of an emissive texture, and a
     * decal that uses it does not show. Each frame takes up at most 8 MiB of what was decoded, as RGBA8 or blocks: a larger image comes over several frames.
     * The counter "images.pending" (fnl_frame_stats) says how many were still missing; once it is 0, frames are equal to the bit to those of a file
     * that was loaded without `async`. Temporal antialiasing starts anew whenever images arrive, and `auto` measures nothing before all
     * have. A broken image is logged when it is decoded, by the thread that does; if memory runs out, the frame that would have taken the
     * image up fails with FNL_ERROR_MEMORY.
     *
     * While images are pending there is a thread for them, which decodes on one thread fewer than the device's host has, or with the host's
     * parallel_for, while frames may call that too. fnl_renderer_destroy waits for what is being decoded at that moment. Baked decals and
     * fnl_scene_grow_metal decode the images that they change at once. Default false.
     */
    bool async;
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
 * Loads `source`: the path of a .gltf or .glb file, or of a folder that holds one such file, or
 * "builtin:NAME?key=value&key=value" (docs/cli.md lists them). `params` NULL: defaults. Other scene formats, such as
 * OBJ or FBX, give FNL_ERROR_UNSUPPORTED, and the log says how to convert them. Files whose parts
 * are far from 0, 0, 0 but near each other get an origin among their parts, a multiple of 16 m
 * (fnl_scene_set_origin). On failure `*out` is NULL and the log
 * says which file, where in it, and what is wrong.
 */
FNL_API fnl_result fnl_scene_load(const fnl_host *host, const char *source, const fnl_load_params *params, fnl_scene **out);
FNL_API void fnl_scene_destroy(fnl_scene **scene);

/** What came with a file: entities first[kind] .. first[kind] + count[kind] - 1 of each kind, until something is removed. */
typedef struct fnl_loaded {
    fnl_instance_id root; /**< a new instance without a mesh, the first of its kind, named after the source: all nodes of the file are below it */
    uint32_t first[FNL_ENTITY_COUNT], count[FNL_ENTITY_COUNT];
} fnl_loaded;

/**
 * Loads a .gltf or .glb file, not a built-in scene, into a scene that is there, under `parent` (all-zero: under nothing). What the scene has
 * keeps its ids and indices; ambient light, environment, background and origin stay as they are.
 * Without a parent, the file's coordinates are relative to 0, 0, 0, not to the origin. `out` may be
 * NULL. After an error the scene is unchanged.
 */
FNL_API fnl_result fnl_scene_load_into(fnl_scene *scene, fnl_instance_id parent, const char *source, const fnl_load_params *params,
                                       fnl_loaded *out);

/**
 * A file that the scene was read from, by number: its path as it was opened, first the loaded file, then those that it refers to (also ones that are
 * not there), those of files loaded into the scene, and the environment's picture. A path may stand there more than once. NULL if there is no such
 * number. It lives until the scene is changed or destroyed. What a resolver supplied has no path.
 */
FNL_API const char *fnl_scene_source(const fnl_scene *scene, uint32_t index);

/* ---- saving ---- */

/** How a scene is saved. */
typedef struct fnl_save_params {
    uint32_t max_size; /**< bytes that the file may have; default UINT32_MAX, which is the most that the format allows */
} fnl_save_params;

FNL_API fnl_save_params fnl_save_params_default(void);
/**
 * Writes the scene as a binary glTF 2.0 file (.glb), complete or not at all. `params` NULL: defaults.
 *
 * A scene of fnl_scene_load keeps all that its file says, extensions and extras that Fanal does not know included. What other calls have changed since is
 * patched in: transforms, visibility, morph weights, materials, meshes, lights and surroundings; what they added is added. Buffers and images become part
 * of the file. What an animation of the file sets stays as the file has it, as does the choice of a variant. The file itself and what it refers to are not
 * read again; the picture of an environment is. A scene of another origin is written whole.
 *
 * glTF has no words for some of it. Light shapes and shadows go into extras, ambient light, background, environment and probes into the
 * extension FNL_surroundings, which fnl_scene_load reads. What is left out is logged as a warning: hulls, new light profiles, decals (those of the file
 * stay), an environment that came as fnl_image, shifts of cameras, cutoff and anisotropy.
 *
 * FNL_ERROR_UNSUPPORTED: it does not fit into max_size.
 */
FNL_API fnl_result fnl_scene_save(const fnl_scene *scene, const char *path, const fnl_save_params *params);

/* ---- large worlds ---- */

/** Largest coordinate of an origin, meters. */
#define FNL_ORIGIN_MAX 1e12

/**
 * Sets the scene's origin: the point, in meters, that all positions of this interface are relative
 * to (cameras, lights, decals, probes, instances without a parent). Default 0, 0, 0;
 * fnl_scene_load() chooses one for a file whose geometry is far away.
 *
 * Floats are practically exact near the origin. Their steps are 0.1 mm at 1 km, 8 mm at 131 km and
 * 0.5 m at 6371 km, so a scene far from the origin jitters and loses shadows.
 *
 * Moving the origin moves nothing in the world. The scene stores positions in doubles and derives
 * the floats from them, so restoring an earlier origin restores the same bytes. Shift the positions
 * that your program stores, such as its camera, by the old origin minus the new one.
 *
 * Advice: move the origin once the camera is 2 km away from it, by multiples of 16 m, which floats
 * represent exactly. Do not move the origin every frame: after each move the next frame uploads all
 * transforms and lights, and redraws shadow maps. Motion vectors and history survive.
 *
 * FNL_ERROR_INVALID: a value is not within FNL_ORIGIN_MAX of 0.
 */
FNL_API fnl_result fnl_scene_set_origin(fnl_scene *scene, const double origin[3]);
FNL_API fnl_result fnl_scene_query_origin(const fnl_scene *scene, double out[3]);

/* ---- surroundings ---- */

/** Ambient light, cd/m^2: `sky` from +Y, `ground` from -Y, blended by the y component of the normal. Default 0. */
FNL_API fnl_result fnl_scene_set_ambient(fnl_scene *scene, fnl_vec3 sky, fnl_vec3 ground);
/** Radiance where no surface is visible, cd/m^2. Default 0. */
FNL_API fnl_result fnl_scene_set_background(fnl_scene *scene, fnl_vec3 radiance);
/** Maximum anisotropy of mipmapped textures, 1 .. 16, clamped to what the device supports; default 8. */
FNL_API fnl_result fnl_scene_set_anisotropy(fnl_scene *scene, float anisotropy);
/**
 * LOD bias of mipmapped textures in frames, -16 .. 16, clamped to what the device supports; default 0. Negative values sharpen textures: with -0.5 log2(n)
 * the mean of n jittered frames shows the detail of a larger picture. Leave it 0 for virtual-texturing, whose pages would
 * show single texels.
 */
FNL_API fnl_result fnl_scene_set_texture_bias(fnl_scene *scene, float levels);

/* ---- time ---- */

/**
 * Poses the scene at `seconds` of animation `animation` (clamped to its ends). The index must be below the animation
 * count; a scene without animations accepts index 0 and ignores it. Besides nodes an animation may set what instances are
 * visible, and properties of materials, lights, cameras and a file's environment (KHR_animation_pointer); what other calls set stays until then.
 * FNL_ERROR_MEMORY can only come from decals that are baked into an animated material.
 */
FNL_API fnl_result fnl_scene_set_time(fnl_scene *scene, uint32_t animation, double seconds);

/** An animation that is blended with others. */
typedef struct fnl_animation_time {
    uint32_t animation;
    double seconds;
    float weight; /**< 0 .. 1e6: how much it counts, in proportion to the weights of the others; 0: not at all */
} fnl_animation_time;

/**
 * Poses the scene by `count` (1 .. 1024) animations at once, one of which has a weight above 0. Each property is the mean of what the animations that set
 * it say, by their weights; what only one of them sets is that one's, whatever its weight. Rotations are averaged as quaternions on the side of the
 * heaviest one. Visibility, and what all of them set in steps, is the heaviest one's. With one animation it is fnl_scene_set_time, to the bit. An
 * animation may stand there more than once, as at two times. An error of an argument changes nothing.
 */
FNL_API fnl_result fnl_scene_set_times(fnl_scene *scene, const fnl_animation_time *times, uint32_t count);
/** Removes an animation; later animations move down by one index. Values that it has set stay. */
FNL_API fnl_result fnl_scene_remove_animation(fnl_scene *scene, uint32_t index);

#ifdef __cplusplus
}
#endif
#endif
