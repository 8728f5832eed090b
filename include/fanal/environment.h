/* SPDX-License-Identifier: MIT */
/** Light from all around, out of a picture of the surroundings. fanal/scene.h includes this. */
#ifndef FANAL_ENVIRONMENT_H
#define FANAL_ENVIRONMENT_H

#include "fanal/image.h"
#include "fanal/scene_ids.h"

#ifdef __cplusplus
extern "C" {
#endif

/**
 * Where a scene stands. The picture is a panorama by longitude and latitude, twice as wide as high: the top row looks to +Y, the middle of the
 * width to +X, and a quarter to the right of it is +Z. Its values are radiance in cd/m^2; pictures of 8 or 16 bits are taken as sRGB.
 */
typedef struct fnl_environment_params {
    /**
     * A file that fnl_image_load reads, or an environment made by code. Default NULL: use `image`.
     * "builtin:studio": a key light, soft boxes and a gray room, in relative values around 1.
     * "builtin:sky": a clear sky with its sun, in cd/m^2 (at 40 degrees the sun gives
     * 85 000 lux at normal incidence, the zenith 2000 cd/m^2).
     * "builtin:sky?elevation=5&azimuth=60&turbidity=2.5": the sun's height (-6 .. 90 degrees; default 40), its
     * direction from +X toward +Z (default 60), and the haze (2 .. 10; default 2.5); sun=0 leaves the sun out. If the
     * scene has a directional light, the sky has no sun and is brightest where that light comes from; elevation,
     * azimuth and sun override this.
     * "builtin:overcast": the CIE overcast sky, 4000 cd/m^2 overhead.
     */
    const char *source;
    /**
     * Read during the call; default NULL. Where source is NULL too, the picture stays that which the scene has, a file's own (EXT_lights_image_based) or that
     * of an earlier call, as `lights` was then; FNL_ERROR_INVALID where it has none.
     */
    const fnl_image *image;
    float rotation;  /**< radians about +Y, anticlockwise seen from above, on top of the rotation that a file gives its own; default 0 */
    float intensity; /**< factor of all radiance, and of the intensity that a file gives its own, 0 .. 1e6; default 1 */
    /**
     * Whether `intensity` is multiplied so that surfaces get as much light, on average, from the environment as from
     * the scene's lights: for pictures with relative values in scenes lit in candela or lux. The factor is chosen when
     * the environment is set; fnl_scene_query_environment returns the product. Default false.
     */
    bool intensity_auto;
    bool background;        /**< whether it is seen where no surface is; otherwise the scene's background is. Default true */
    /**
     * Small bright sources (the sun, lamps) become directional lights of the scene, with shadows, and go from the picture: prefiltered light has
     * neither sharp shadows nor exact highlights. At most 8, those with the most illuminance; each fills at most 10 degrees and gives at
     * least 2 % of the light. Default true.
     */
    bool lights;
    /**
     * Renderers keep it as BC6H where fnl_device_info.texture_compression: an eighth of the memory, 1.4 to 2.9 % off. Default false.
     */
    bool compressed;
    /**
     * Byte limit for the picture of `source`, decoded and as the scene stores it, checked before any allocation. A larger picture gives FNL_ERROR_MEMORY.
     * UINT64_MAX: no limit. Default: half of the machine's memory.
     */
    uint64_t max_memory;
} fnl_environment_params;

FNL_API fnl_environment_params fnl_environment_params_default(void);
/**
 * Surrounds the scene. Ambient light (fnl_scene_set_ambient) is not used while there is an environment; surfaces get light from it by their
 * roughness, without shadows but for their own occlusion. Where the picture stays the same, by `source` and `lights` or because neither source nor image is given, a change costs next to nothing.
 * `params` NULL: no environment, as in a new scene. Lights that came with the environment before go. On errors (the log names the file) all stays
 * as it was.
 */
FNL_API fnl_result fnl_scene_set_environment(fnl_scene *scene, const fnl_environment_params *params);
/**
 * The environment as it was set, except `image`, which is NULL, and the `source` of a sky, which includes the position
 * of the sun if a light of the scene determined it. `source` is valid until the environment is set again, and NULL for
 * an environment from an image or a glTF file. FNL_ERROR_INVALID for a scene without one
 * (fnl_scene_info.has_environment), and `*out` has defaults.
 */
FNL_API fnl_result fnl_scene_query_environment(const fnl_scene *scene, fnl_environment_params *out);

#ifdef __cplusplus
}
#endif
#endif
