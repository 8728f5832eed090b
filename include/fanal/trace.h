/* SPDX-License-Identifier: MIT */
/**
 * Traces a scene with rays on the CPU: the truth that frames are measured against. It needs no device. Direct light, of the same BRDF, lights,
 * textures and camera rays as a frame, with exact shadows; or, with bounces, all light by path tracing. docs/techniques/trace.md tells more.
 */
#ifndef FANAL_TRACE_H
#define FANAL_TRACE_H

#include "fanal/frame.h"
#include "fanal/image.h"

#include <math.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct fnl_trace_params {
    uint32_t width, height; /**< pixels, 1 .. 16384; default 1280 x 720 */
    fnl_camera camera;      /**< default fnl_camera_default() */
    /**
     * Rays per pixel, 1 .. 1048576. Ray k goes through position k of fnl_jitter(), the first through the pixel's center. Textures are filtered over 1 /
     * sqrt(samples) of the pixel's width: the mean is as sharp as a downsampled larger picture. Default 1.
     */
    uint32_t samples;
    /**
     * How often light may bounce before it meets the surface that is seen, 0 .. 1024. 0: only lights and the environment shine, and ambient
     * light is what it is in a frame, without shadows. From 1 on ambient light comes from the sky that paths reach, and surfaces that glow are lights. Default 0.
     */
    uint32_t bounces;
    /** Default true. */
    bool shadows;
    /**
     * Radius of the sources that cast shadows, metres, >= 0, in place of the lights' own; INFINITY (the default): theirs. Above 0 a shadow ray goes to a
     * random point of a disk round the light (of capsules round any point of the segment): the shadow is soft, the light that it dims stays that of a
     * frame. At 0 shadows are hard; those of capsules are cast by the nearest point of the segment.
     */
    float light_radius;
    float sun_angle; /**< the same for directional lights and boxes: half the angle that they fill, radians, 0 .. 1; or INFINITY, the default */
    /** Ends long paths by chance. The mean stays the same, with more noise in less time. Default false. */
    bool russian_roulette;
    /**
     * Sends rays to bright parts of the environment and, from 1 bounce on, to glowing surfaces, instead of relying on paths to hit them. The mean stays
     * the same. Default true.
     */
    bool light_sampling;
    uint64_t seed;     /**< of all chances; default 1 */
    bool visibility;   /**< wants fnl_trace.visibility; default false */
    fnl_energy energy; /**< as in fnl_frame; default gltf */
    bool studio;       /**< as in fnl_frame, like the next three; default true */
    fnl_ground ground; /**< default auto */
    fnl_background background; /**< default auto */
    float background_blur;     /**< radians; default 0.35 */
    fnl_tonemap tonemap;   /**< of fnl_trace.color; default Khronos neutral */
    fnl_exposure exposure; /**< default auto */
    float ev;              /**< EV100 for FNL_EXPOSURE_EV, -64 .. 64; default 0 */
    /**
     * Called on the calling thread, again and again, while others trace; `total` is the number of tiles of 16 x 16 pixels, times the samples. False
     * ends it, and the pictures hold what was traced until then. Default NULL.
     */
    bool (*progress)(void *user, uint64_t done, uint64_t total);
    void *user; /**< default NULL */
} fnl_trace_params;

static inline fnl_trace_params fnl_trace_params_default(void) {
    const fnl_trace_params params = {1280,  720, fnl_camera_default(),        1,                 0, true, INFINITY, INFINITY, false, true, 1,
                                     false, FNL_ENERGY_GLTF, true, FNL_GROUND_AUTO, FNL_BACKGROUND_AUTO, 0.35f, FNL_TONEMAP_KHRONOS_NEUTRAL, FNL_EXPOSURE_AUTO, 0, NULL, NULL};
    return params;
}

/** What was traced. */
typedef struct fnl_trace {
    fnl_image radiance; /**< linear, cd/m^2, RGBA32F; as FNL_OUTPUT_RADIANCE of a frame */
    fnl_image color;    /**< tone-mapped, sRGB-encoded RGBA8; as FNL_OUTPUT_COLOR */
    /**
     * If it was asked for, RGBA32F: X is the part of the lights' direct light that shadows leave, 0 .. 1 (1 where no light shines), weighted by the
     * luminance that each light adds to the nearest surface; Y is the luminance that there would be without shadows, cd/m^2.
     */
    fnl_image visibility;
    float ev;           /**< EV100 that `color` is exposed with */
    bool complete;      /**< false: fnl_trace_params.progress ended it; pixels may have fewer samples, or none, and are then transparent black */
    uint64_t ray_count; /**< of all kinds: from the camera, to lights, of paths */
    uint32_t unseen;    /**< primitives of lines and points, and decals that are not baked: rays do not see them */
} fnl_trace;

/**
 * Traces on all threads of the scene's host. The same scene and parameters give the same bytes, whatever the number of threads. The scene must not
 * change meanwhile. FNL_ERROR_UNSUPPORTED, with a log line, where Fanal was built without Embree. Free `out` with fnl_trace_free.
 */
FNL_API fnl_result fnl_scene_trace(const fnl_scene *scene, const fnl_trace_params *params, fnl_trace *out);
/** `host`: the scene's, or NULL if it had none. */
static inline void fnl_trace_free(const fnl_host *host, fnl_trace *trace) {
    fnl_image_free(host, &trace->radiance);
    fnl_image_free(host, &trace->color);
    fnl_image_free(host, &trace->visibility);
}

#ifdef __cplusplus
}
#endif
#endif
