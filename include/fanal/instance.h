/* SPDX-License-Identifier: MIT */
/**
 * Instances: meshes placed in the scene, and the nodes of files, which may carry lights, cameras and other nodes. Calls on
 * one scene are not thread-safe.
 */
#ifndef FANAL_INSTANCE_H
#define FANAL_INSTANCE_H

#include "fanal/scene_ids.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Places a mesh. `transform` is affine, finite, and may mirror. */
FNL_API fnl_result fnl_scene_add_instance(fnl_scene *scene, fnl_mesh_id mesh, const fnl_mat4 *transform,
                                          fnl_instance_id *out);
/**
 * Moves `count` instances: instances[i] gets transforms[i]. All elements are checked before any instance moves: an error
 * names the element, and the scene stays as it was. If an id appears twice, its last transform counts. With a count of 0 the
 * pointers may be NULL. The cost is in proportion to the number of nodes below the instances; each is updated once, even if several
 * nodes above it move.
 *
 * In a file, every node is an instance: the transform is relative to the parent node, and everything below moves along, as
 * do lights, cameras, decals and skins that follow those nodes. The transform holds until fnl_scene_set_time is called with
 * an animation of this very node, which sets translation, rotation and scale from the animation, and those that are not
 * animated from the file.
 */
FNL_API fnl_result fnl_scene_set_instance_transforms(fnl_scene *scene, const fnl_instance_id *instances,
                                                     const fnl_mat4 *transforms, uint32_t count);
/** The same for one instance. */
static inline fnl_result fnl_scene_set_instance_transform(fnl_scene *scene, fnl_instance_id instance,
                                                          const fnl_mat4 *transform) {
    return fnl_scene_set_instance_transforms(scene, &instance, transform, 1);
}
/** How an instance is deformed. All zero: it stays as it is. */
typedef struct fnl_pose {
    /** The weight of each morph target of the mesh, finite, usually 0 .. 1. NULL: the weights stay. */
    const float *morph_weights;
    uint32_t morph_weight_count; /**< fnl_instance_info.morph_target_count; 0 with NULL */
    /**
     * The transform of each joint of the instance's skin to the space of the joint's parent node, affine, finite, in the
     * order of the skin in the file. NULL: the joints stay.
     */
    const fnl_mat4 *joints;
    uint32_t joint_count; /**< fnl_instance_info.joint_count; 0 with NULL */
} fnl_pose;

/**
 * Poses an instance without an animation. Joints are instances too: this moves them as fnl_scene_set_instance_transforms
 * does, with everything below them, and for every skin that uses them. Joints that were removed stay where they were. An
 * error changes nothing.
 *
 * A pose holds until fnl_scene_set_time is called with an animation of these weights or of one of these joints. That sets
 * the weights, or that joint, and leaves the rest as it was posed. To mix both, call fnl_scene_set_time first.
 */
FNL_API fnl_result fnl_scene_set_pose(fnl_scene *scene, fnl_instance_id instance, const fnl_pose *pose);
/**
 * Hides an instance with everything below it, including lights and decals, or shows it again if nothing above it is hidden.
 * Nodes of a file that are hidden (KHR_node_visibility) or in none of the scenes shown begin hidden. A skin is shown with
 * the node of its mesh, wherever its joints are. Renderers take what is hidden out of their sorted list of draws. They sort
 * the whole list again only if something among it has a skin or morph targets, or if more than 64 instances come or go
 * between two frames.
 */
FNL_API fnl_result fnl_scene_set_instance_visible(fnl_scene *scene, fnl_instance_id instance, bool visible);
/**
 * Removes an instance with everything below it, including lights. Cameras below it stay where they are, as do joints of the
 * skins of other nodes; decals below it are no longer shown. All other ids stay valid.
 *
 * Removing a file's root (fnl_loaded.root) unloads the file: its meshes, materials, images, light profiles, animations, cameras, probes and decals
 * are removed, and their memory is freed. If something outside the file still uses any of its meshes, materials, images or light profiles, then
 * all meshes, materials and profiles of the file, and the images in use, stay until the last user is removed. Unused images are freed at once. While a renderer decodes images in the
 * background (fnl_load_params.async), the memory is freed by a later removal.
 */
FNL_API fnl_result fnl_scene_remove_instance(fnl_scene *scene, fnl_instance_id instance);

/**
 * Sets which decals an instance receives: those that share a bit with `receivers` (8 bits; initially 255). 0: none. Costs as
 * much as hiding the instance.
 */
FNL_API fnl_result fnl_scene_set_instance_receivers(fnl_scene *scene, fnl_instance_id instance, uint32_t receivers);
/**
 * Sets which lights affect an instance: those that share a bit with `mask` (fnl_light_params.mask; 8 bits; initially 255). 0: none, so only ambient light and
 * emission are left. Costs as much as hiding the instance. In shading paths with a G-buffer, instances with a mask other than 255 are shaded forward
 * once some light has a mask other than 255.
 */
FNL_API fnl_result fnl_scene_set_instance_light_mask(fnl_scene *scene, fnl_instance_id instance, uint32_t mask);

/**
 * Sets which cameras show an instance: those that share a bit with `mask` (fnl_camera.view_mask; 8 bits; initially 255). Pictures of all other cameras still show
 * its shadows, and its reflections by probes and by traced rays. Costs as much as hiding the instance.
 */
FNL_API fnl_result fnl_scene_set_instance_view_mask(fnl_scene *scene, fnl_instance_id instance, uint32_t mask);

#ifdef __cplusplus
}
#endif
#endif
