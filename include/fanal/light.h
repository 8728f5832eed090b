/* SPDX-License-Identifier: MIT */
/**
 * The lights of a scene. fanal/lights.h is about the lists that find which of them reach a pixel. Calls on one scene are not
 * thread-safe.
 *
 * Units are glTF's: metres, radians, candela (lights that spread), lux (directional and box).
 */
#ifndef FANAL_LIGHT_H
#define FANAL_LIGHT_H

#include "fanal/scene_ids.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum fnl_light_kind {
    FNL_LIGHT_DIRECTIONAL = 0, /**< parallel light everywhere */
    FNL_LIGHT_POINT,           /**< from a point in all directions, up to a range */
    FNL_LIGHT_SPOT,            /**< from a point into a round cone */
    FNL_LIGHT_CAPSULE,         /**< a tube: each point is lit from the nearest point of a segment */
    FNL_LIGHT_WEDGE,           /**< from a point into a pyramid of rectangular cross-section */
    FNL_LIGHT_BOX,             /**< parallel light that fills an oriented box and nothing else */
    FNL_LIGHT_RECTANGLE,       /**< a flat panel, alike from all sides (Lambert's law), that lights what is in front of it */
    FNL_LIGHT_KIND_COUNT
} fnl_light_kind;

/** When the shadow maps of a light are drawn again. Shadows that rays find are always those of the moment. */
typedef enum fnl_shadow_update {
    FNL_SHADOW_UPDATE_ALWAYS = 0, /**< where what they show has changed: nothing is drawn in still scenes */
    /**
     * Not when things move, but after fnl_scene_refresh_shadows(). Parts of the maps that a pixel looks up for the first time are drawn as things are then; all
     * are drawn again when the light itself moves, and when materials, textures or meshes change.
     */
    FNL_SHADOW_UPDATE_ON_REQUEST,
    FNL_SHADOW_UPDATE_COUNT
} fnl_shadow_update;

/** Largest number of lights without a range that stay unlimited; if there are more, all are cut off (fnl_scene_set_light_cutoff). */
#define FNL_UNLIMITED_LIGHTS_MAX 64

typedef struct fnl_light_params {
    fnl_light_kind kind; /**< default point */
    fnl_vec3 position;   /**< metres; apex of spots and wedges, middle of capsules, boxes and rectangles; not for directional lights */
    /** Where the light shines to; for capsules, along the segment. Normalised by the call. Default 0, 0, -1. Not for points. */
    fnl_vec3 direction;
    float color[3];  /**< linear RGB, >= 0; default 1 */
    /**
     * Candela, or lux for directional lights and boxes, >= 0; default 1. Of a rectangle it is what it sends straight ahead: its luminance in cd/m^2
     * is this over its area, and a larger one does not give more light.
     */
    float intensity;
    /**
     * Distance from the position (capsules: from the segment, rectangles: from their nearest point) beyond which the light contributes exactly zero, metres, > 0;
     * INFINITY (the default): no limit, as in glTF; but see fnl_scene_set_light_cutoff(). Not for directional lights and boxes.
     */
    float range;
    float inner_cone_angle; /**< half angle of full intensity, radians, 0 .. outer; default 0 */
    float outer_cone_angle; /**< half angle beyond which there is no light, radians, up to pi/2; default pi/4 */
    /**
     * Wedges, boxes and rectangles: the direction of their height. The call makes it a unit vector perpendicular to `direction`; if the
     * two are parallel, it chooses another. The width lies along direction x up. Default 0, 1, 0.
     */
    fnl_vec3 up;
    float length;          /**< capsules: length of the segment, which is centred on the position, metres, >= 0; default 1 */
    float wedge_angles[2]; /**< wedges: half angles across the width and the height, radians, 0 .. 1.5; default pi/4, pi/6 */
    fnl_vec3 box_size;     /**< boxes: width, height and depth (along the direction), metres, > 0; default 1 */
    float rectangle_size[2]; /**< rectangles: width and height, metres, 1e-9 .. 1e9; default 1 */
    bool two_sided;        /**< rectangles: default false: light goes to the side of `direction`; true: to both sides alike */
    /** Wedges and boxes: full intensity up to this fraction of the way from the axis to the edge, then a fade to zero at the
        edge, 0 .. 1; default 0.7. */
    float inner_fraction;
    /**
     * Radius of what shines, metres, >= 0; default 0, a point. Not for directional lights and boxes, nor for rectangles, whose own size counts. It makes shadows soft, if the frame asks
     * for that (fnl_shadow_options): a shadow is as dark as the part is large that is hidden of a disk of this radius that faces the surface;
     * for capsules of all disks round points of the segment. How bright the light is, and its highlights, do not change.
     */
    float source_radius;
    /** The same for directional lights and boxes: half the angle that the source fills, radians, 0 .. 1; default 0. The sun's: 0.00465. */
    float source_angle;
    bool casts_shadows; /**< default true; false: it shines through everything, where frames have shadows too */
    float contact_scale; /**< multiplies fnl_shadow_options.contact_length for this light, 0 .. 1000; default 1; 0: it has no contact shadows */
    fnl_shadow_update shadow_update; /**< FNL_SHADOWS_MAPS and FNL_SHADOWS_HYBRID; default FNL_SHADOW_UPDATE_ALWAYS */
    /**
     * Points and spots: how bright the light is in each direction (fnl_scene_add_light_profile); all-zero, the default: the same in all. The
     * intensity is that of the brightest direction, and a spot's cone is cut out of the profile. The profile looks along `direction`, with the
     * horizontal angle 0 at direction x up, growing towards `up`: a point that has one has these two as wedges do.
     */
    fnl_light_profile_id profile;
    /**
     * Light mask, 8 bits: the light affects instances that share a bit with it (fnl_scene_set_instance_light_mask); default 255. All instances cast shadows of
     * the light, including instances with other masks. Light lists keep the light for all surfaces in its volume.
     */
    uint32_t mask;
} fnl_light_params;

FNL_API fnl_light_params fnl_light_params_default(void);
/** A scene has at most 48 million lights that are not directional: FNL_ERROR_UNSUPPORTED, also from other calls that add some. */
FNL_API fnl_result fnl_scene_add_light(fnl_scene *scene, const fnl_light_params *params, fnl_light_id *out);
/**
 * Changes `count` lights: lights[i] gets params[i]. All elements are checked before any light changes: an error names the
 * element, and the scene stays as it was. If an id appears twice, its last parameters count. With a count of 0 the pointers
 * may be NULL. Renderers upload the lights that changed and no others.
 *
 * A light of a file follows its node. It keeps following if position, direction and up (those that its kind has) are the
 * values that fnl_scene_query_light returned; any other pose detaches it from its node, and it stays where it was put.
 */
FNL_API fnl_result fnl_scene_set_lights(fnl_scene *scene, const fnl_light_id *lights, const fnl_light_params *params,
                                        uint32_t count);
/** The same for one light. */
static inline fnl_result fnl_scene_set_light(fnl_scene *scene, fnl_light_id light, const fnl_light_params *params) {
    return fnl_scene_set_lights(scene, &light, params, 1);
}
/**
 * The shadow maps of `count` lights whose shadow_update is FNL_SHADOW_UPDATE_ON_REQUEST are drawn as things are in the next frame; those of others are anyway.
 * An id that is no light is an error (logged) that names the element, and nothing is asked for. With a count of 0 `lights` may be NULL.
 */
FNL_API fnl_result fnl_scene_refresh_shadows(fnl_scene *scene, const fnl_light_id *lights, uint32_t count);
/**
 * Adds a luminaire's photometric data for lights to have (fnl_light_params.profile): a file of IESNA LM-63 (.ies) of 1986 to 2019, type C, B or A.
 * It is `size` bytes at `data`, which are not kept; with data NULL the file called `name` is read. `name` is for messages besides.
 * `candela`, unless NULL, gets the intensity of the brightest direction: a light of this intensity shines as the luminaire does. What tilting does
 * to lamps (TILT) is left out. FNL_ERROR_FORMAT if the data is not in LM-63 format.
 */
FNL_API fnl_result fnl_scene_add_light_profile(fnl_scene *scene, const char *name, const void *data, size_t size, fnl_light_profile_id *out,
                                               float *candela);
FNL_API fnl_result fnl_scene_remove_light(fnl_scene *scene, fnl_light_id light);
/** Removes a light profile. FNL_ERROR_INVALID if a light uses it. */
FNL_API fnl_result fnl_scene_remove_light_profile(fnl_scene *scene, fnl_light_profile_id profile);

/**
 * Clips a light to the convex hull of `count` (4 .. 64) world-space points: outside the hull it contributes exactly zero, as
 * it does outside its own volume. The hull does not move with the light. NULL and 0 remove it. Points that lie in one plane,
 * on one line or at one place are an error (logged) and change nothing. Directional lights ignore their hull.
 */
FNL_API fnl_result fnl_scene_set_light_hull(fnl_scene *scene, fnl_light_id light, const fnl_vec3 *points, uint32_t count);

/**
 * Distance in metres beyond which a light contributes exactly zero. That is its range if finite; for a box, half its
 * diagonal. Otherwise it is sqrt(I g / threshold), where I is the intensity times the brightest colour channel: the distance
 * at which the light adds less than `threshold` / pi cd/m^2 (`threshold` in lux, > 0) to the brightest possible surface of
 * roughness `min_roughness` (0 .. 1). g = max(1, 1 / (4 alpha^2)) with alpha = max(min_roughness^2, 0.001) is the ratio of a
 * white metal's largest BRDF value seen head-on, 1 / (4 pi alpha^2), to that of a white matt surface, 1/pi. The smoother the
 * surfaces, the farther lights reach: sharp highlights are visible long after diffuse light is not. INFINITY for directional
 * lights; 0 (logged) for NULL.
 */
FNL_API float fnl_light_range(const fnl_light_params *params, float min_roughness, float threshold);
/**
 * Sets how far lights whose range is INFINITY reach.
 *
 * Threshold 0, the default: up to FNL_UNLIMITED_LIGHTS_MAX such lights light everything, at any distance. If there are more,
 * each light ends where its illuminance is below a shared threshold: 1/1024 of their combined average illuminance in the
 * scene without shadows, rounded down to a power of two. It depends only on these lights and on the scene's bounds.
 * fnl_scene_query_info() returns it.
 *
 * Threshold above 0, in lux: all such lights end at fnl_light_range(). `min_roughness`, 0 .. 1, is the lowest roughness whose
 * highlights must not be cut off; a threshold of 0 ignores it.
 */
FNL_API fnl_result fnl_scene_set_light_cutoff(fnl_scene *scene, float min_roughness, float threshold);

/** How lights are scattered. */
typedef struct fnl_scatter_params {
    uint32_t count; /**< number of lights; default 0 */
    uint64_t seed;  /**< default 1 */
    /** Relative number of each kind, >= 0; default 3 points, 1 spot. Directional lights cannot be scattered. */
    float shares[FNL_LIGHT_KIND_COUNT];
    float radius_scale; /**< multiplies the radius of the lights, > 0; default 1 */
} fnl_scatter_params;

static inline fnl_scatter_params fnl_scatter_params_default(void) {
    const fnl_scatter_params params = {0, 1, {0, 3, 1}, 1};
    return params;
}
/**
 * Adds lights at pseudo-random places within the scene's bounds. Their radius follows from the extent of the scene, so that
 * a point of it lies in about 8 of them on average, whatever the count; their intensity follows from the radius. The same
 * scene and parameters give the same lights. An error adds none.
 */
FNL_API fnl_result fnl_scene_scatter_light_shapes(fnl_scene *scene, const fnl_scatter_params *params);
/** The same with `count` lights, three points to one spot. */
static inline fnl_result fnl_scene_scatter_lights(fnl_scene *scene, uint32_t count, uint64_t seed) {
    fnl_scatter_params params = fnl_scatter_params_default();
    params.count = count;
    params.seed = seed;
    return fnl_scene_scatter_light_shapes(scene, &params);
}

#ifdef __cplusplus
}
#endif
#endif
