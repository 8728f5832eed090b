/* SPDX-License-Identifier: MIT */
/**
 * Probes: boxes in which a room is seen from one point. What a probe has seen serves every surface in its box. Calls on one scene are not thread-safe.
 */
#ifndef FANAL_PROBE_H
#define FANAL_PROBE_H

#include "fanal/scene_ids.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct fnl_probe_params {
    fnl_vec3 centre;    /**< of the box, world space, metres; default 0 */
    fnl_vec3 half_size; /**< from the centre to the faces, metres, > 0; default 1. Faces lie on the walls of the room, or as near to them as can be */
    fnl_vec4 rotation;  /**< of the box: a unit quaternion x, y, z, w; default none */
    /** Where the room is seen from: metres from the centre along the box's axes, inside the box; default 0. */
    fnl_vec3 capture;
    /**
     * What lies within so many metres of the box's faces, on either side, is the wall, metres, > 0; default 0.05. Of uneven walls: how far they are from
     * the faces at most.
     */
    float wall;
    /**
     * Texels on the side of each of the cube's six faces, 8 .. 2048; default 128. Of reflections the greatest power of two that is not above it, 16 .. 1024.
     */
    uint32_t face_size;
    bool shadows;       /**< FNL_SHADOWS_CUBEMAP: lights outside shine in through it; where boxes overlap, the first two that have it are blended; default true */
    /** shadow.cubemap-lod=linear: levels of detail for each metre between a surface and the wall, 0 .. 16; 0 (default): hard shadows. */
    float softness;
    /**
     * A reflection probe: what surfaces in the box mirror, and their diffuse light from all around, is what is seen from `capture`, not the environment.
     * Reflections are followed to the faces of the box. It is captured in the first frame, and again when the probe is set again, with the same values
     * too. Default false. docs/techniques/reflection-probes.md tells more.
     */
    bool reflection;
    /**
     * Reflections: metres over which it fades, >= 0, inwards from where it ends, `wall` metres outside of the faces. Default 0.05: it serves all of the box.
     * Where probes of one priority overlap they are blended; what they leave is the environment's.
     */
    float blend;
    int32_t priority; /**< reflections: where a probe of a higher priority is, others count only as far as it fades; default 0 */
    float intensity;  /**< reflections: multiplies their light, >= 0; default 1 */
    uint32_t mask;    /**< reflections: light mask, 8 bits; the probe serves instances that share a bit with it (fnl_scene_set_instance_light_mask); default 255 */
} fnl_probe_params;

FNL_API fnl_probe_params fnl_probe_params_default(void);
FNL_API fnl_result fnl_scene_add_probe(fnl_scene *scene, const fnl_probe_params *params, fnl_probe_id *out);
FNL_API fnl_result fnl_scene_set_probe(fnl_scene *scene, fnl_probe_id probe, const fnl_probe_params *params);
FNL_API fnl_result fnl_scene_remove_probe(fnl_scene *scene, fnl_probe_id probe);

/**
 * Adds a probe for each room of the scene, as its surfaces stand now; what deforms is not looked at. A room is a space with a floor and a ceiling and walls
 * on three sides at least, such that its surfaces are seen from within; furniture and pillars do not part it, doors and windows do not let it out. Faces
 * of its box lie on its walls, where these are even, else within a few hundredths of the scene's length of them; then `wall` is so much larger. It is also at
 * least half of the walls to other rooms, half a metre at most, for the sides of doorways. Boxes stand
 * upright and are turned as most walls of the scene are. The same scene gives the same probes.
 *
 * `params` (NULL: defaults) says all but centre, half_size, rotation and capture, which are ignored. At most `most` probes, 1 .. 64, those of the
 * largest rooms first. A scene without any room (a place in the open, a single thing) gets one probe whose box is the scene's bounds; one without an extent in
 * all three directions none. `out_count` (or NULL): how many were added. FNL_ERROR_MEMORY may leave some.
 */
FNL_API fnl_result fnl_scene_place_probes(fnl_scene *scene, const fnl_probe_params *params, uint32_t most, uint32_t *out_count);

#ifdef __cplusplus
}
#endif
#endif
