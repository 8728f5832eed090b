/* SPDX-License-Identifier: MIT */
/**
 * Instances: meshes placed in the scene, and the nodes of files, which may carry lights, cameras and other nodes. Calls on one scene
 * are not thread-safe.
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
 * Moves `count` instances: instances[i] gets transforms[i]. All are checked before any is moved: an error names the element that is wrong, and the
 * scene is as it was. Of an id that stands there twice the last transform counts. With 0 instances the pointers may be NULL.
 * Costs in proportion to what is below them, each node once, however many of them are below one another.
 *
 * In a file, every node is an instance: the transform is relative to the parent node, and everything below moves along, as
 * do lights, cameras, decals and skins that follow those nodes. The transform holds until fnl_scene_set_time is called with
 * an animation of this very node, which sets translation, rotation and scale from the animation, and those that are not
 * animated from the file.
 */
FNL_API fnl_result fnl_scene_set_instance_transforms(fnl_scene *scene, const fnl_instance_id *instances,
                                                     const fnl_mat4 *transforms, uint32_t count);
/** The same for one instance. */
static inline fnl_result fnl_scene_set_instance_transform(fnl_scene *scene, fnl_instance_id instance, const fnl_mat4 *transform) {
    return fnl_scene_set_instance_transforms(scene, &instance, transform, 1);
}
/**
 * Hides an instance with everything below it, including lights and decals, or shows it again if nothing above it is hidden.
 * Nodes of a file that are hidden (KHR_node_visibility) or in none of the scenes shown begin hidden. A skin is shown with the
 * node of its mesh, wherever its joints are. Renderers upload a few bytes per instance, but go through all of them to sort them again.
 */
FNL_API fnl_result fnl_scene_set_instance_visible(fnl_scene *scene, fnl_instance_id instance, bool visible);
/**
 * Removes an instance with everything below it, including lights. Cameras below it stay where they are, as do joints of the
 * skins of other nodes; decals below it are no longer shown. All other ids stay valid.
 */
FNL_API fnl_result fnl_scene_remove_instance(fnl_scene *scene, fnl_instance_id instance);

/**
 * Sets which decals an instance receives: those that share a bit with `receivers` (8 bits; initially 255). 0: none. Renderers
 * go through all instances to sort them again.
 */
FNL_API fnl_result fnl_scene_set_instance_receivers(fnl_scene *scene, fnl_instance_id instance, uint32_t receivers);

#ifdef __cplusplus
}
#endif
#endif
