/* SPDX-License-Identifier: MIT */
/** Shadows: what stops light on its way. docs/techniques/shadows.md tells more. */
#ifndef FANAL_SHADOWS_H
#define FANAL_SHADOWS_H

#include "fanal/base.h"

#ifdef __cplusplus
extern "C" {
#endif

/** How shadows are found. */
typedef enum fnl_shadows {
    FNL_SHADOWS_OFF = 0, /**< not at all: light goes through walls */
    /** A ray from each surface to each light that reaches it: exact hard shadows of all lights, through cutouts and glass. Slow with many lights. */
    FNL_SHADOWS_RAYS,
    /**
     * Shadow maps of all lights in one image of a fixed size, in pages that are made only where a pixel looks them up and are kept from frame to frame.
     * Capsules and rectangles trace rays, and so do lights for which the image has no room. Blended surfaces receive shadows but cast none.
     */
    FNL_SHADOWS_MAPS,
    /**
     * Rays too, but from each surface to a few of its lights, which are chosen by chance: the more a light gives without shadows, the likelier it is.
     * The picture is noisy, and the mean of frames with different seeds is that of FNL_SHADOWS_RAYS. Directional lights are sent a ray always.
     */
    FNL_SHADOWS_SAMPLED,
    /**
     * A cube map for each probe of the scene (fanal/probe.h) says where its walls let light in, and one look-up finds the soft, coloured shadow that they
     * cast into the room from a light outside. Rays find the shadows of what is in the room, of lights in it, and of surfaces outside all probes.
     */
    FNL_SHADOWS_CUBEMAP,
    /**
     * FNL_SHADOWS_MAPS, but each local light whose rays cost less than drawing its pages gets rays: one that few pixels see, that moves, or before which much moves.
     * What costs less is measured (fnl_shadow_options.page_rays); a light changes only when it pays. Each light's shadow is that of FNL_SHADOWS_MAPS or that of FNL_SHADOWS_RAYS.
     */
    FNL_SHADOWS_HYBRID,
    /**
     * One of off, rays, maps and hybrid, by the scene and the device: off without lights; rays with at most 4 lights where a GPU has ray queries, and where there can be no
     * maps; hybrid while local lights move; else maps. The stats and settings of a frame name what it took.
     */
    FNL_SHADOWS_AUTO,
    FNL_SHADOWS_COUNT
} fnl_shadows;

/** How the edges of shadows from maps are filtered. */
typedef enum fnl_shadow_filter {
    FNL_SHADOW_FILTER_HARD = 0, /**< not at all: the nearest texel decides */
    FNL_SHADOW_FILTER_PCF,      /**< percentage-closer filtering: a disk of three texels smooths their steps, whatever the light's size */
    /** Percentage-closer soft shadows: penumbras as wide as the light's radius and the distances of light, blocker and receiver make them. Lights
        without a radius cast hard shadows. */
    FNL_SHADOW_FILTER_PCSS,
    FNL_SHADOW_FILTER_AUTO, /**< pcf in scenes of up to 8 lights, where it costs little; otherwise hard */
    FNL_SHADOW_FILTER_COUNT
} fnl_shadow_filter;

/** FNL_SHADOWS_CUBEMAP: how soft shadows are, by the distance between a surface and the wall that its light comes through. */
typedef enum fnl_cubemap_lod {
    FNL_CUBEMAP_LOD_LINEAR = 0, /**< fnl_probe_params.softness levels of detail a metre, the same for all lights */
    FNL_CUBEMAP_LOD_PHYSICAL,   /**< as wide as the radius or angle of the light makes penumbras; lights without one cast hard shadows */
    FNL_CUBEMAP_LOD_COUNT
} fnl_cubemap_lod;

/** FNL_SHADOWS_CUBEMAP: what casts shadows in the room besides its walls. */
typedef enum fnl_cubemap_inside {
    FNL_CUBEMAP_INSIDE_ALL = 0, /**< everything, by a ray that ends at the wall; what has moved, by one that goes on to the light */
    FNL_CUBEMAP_INSIDE_MOVING,  /**< what an animation moves, what has moved since the probes were baked, and what deforms: a scene in which nothing does sends no rays */
    FNL_CUBEMAP_INSIDE_NONE,    /**< nothing */
    FNL_CUBEMAP_INSIDE_COUNT
} fnl_cubemap_inside;

/** What shadow rays go through. All give the same picture, but for rays that meet the very edge of a triangle. */
typedef enum fnl_ray_backend {
    FNL_RAY_BACKEND_AUTO = 0, /**< FNL_RAY_BACKEND_RAY_QUERY where the device has it and is a GPU, else FNL_RAY_BACKEND_BVH */
    FNL_RAY_BACKEND_BVH,      /**< bounding volume hierarchies of our own, walked by any shader of any device */
    /** The device's acceleration structures (fnl_device_info.ray_query). Devices without take FNL_RAY_BACKEND_BVH, and a line in the log says so. */
    FNL_RAY_BACKEND_RAY_QUERY,
    FNL_RAY_BACKEND_COUNT
} fnl_ray_backend;

/** Settings of shadows. */
typedef struct fnl_shadow_options {
    /**
     * maps: memory of the image that holds all maps, MiB, 1 .. 1024, for each view; rounded down to a square of whole pages. Where it is too small
     * for maps as fine as the picture, those of the lights that matter least become coarser first. Default 64.
     */
    uint32_t memory;
    /**
     * maps, hybrid: maximum face width of a local light's shadow map, 8 to 1920 texels; default 1920.
     * Face widths: 8, 24, 56, 120, 240, 480, 960, 1920. Lower: fewer pages to draw, coarser shadows near lights.
     */
    uint32_t texels_max;
    fnl_shadow_filter filter; /**< maps; default FNL_SHADOW_FILTER_AUTO */
    /**
     * maps: opaque surfaces take their lights from lists of tiles of 8x8 pixels, out of which the lights are taken that the maps show in shadow all over the tile.
     * The picture is the same to the bit, with fewer lights to evaluate. For forward, deferred and visibility shading with one sample a pixel and maps that
     * are not filtered; fnl_frame.lists then matters for blended surfaces alone. Elsewhere it changes nothing. Default false.
     */
    bool classify;
    /**
     * hybrid: how many rays take as long as drawing one page, 0 .. 1 000 000. 0 (default): this is measured, a few times a minute; before the first measurement it is
     * 64 on CPUs and 1024 elsewhere. With 0 two runs may decide differently, with a number they do not.
     */
    float page_rays;
    /**
     * Shadow rays that go from a point to points of a light that has a radius, 1 .. 1024: with several its shadows by rays are soft. They are the same in
     * every frame, unless frames are collected (fnl_frame.aa is TAA). Default 1: one ray to the middle, hard shadows. Lights that are points always get one.
     * sampled: a local light that is chosen gets one ray, to one of so many points, another one with each seed; their mean is the soft shadow that rays have with as many.
     */
    uint32_t samples;
    float light_radius; /**< fnl_light_params.source_radius of lights where that is 0, metres, >= 0; default 0 */
    float sun_degrees;  /**< fnl_light_params.source_angle of lights where that is 0, here in degrees, 0 .. 57; default 0 */
    /**
     * sampled: rays from each surface, 1 .. 16, besides those to directional lights. A surface with no more lights than this has exact shadows.
     * Default 1.
     */
    uint32_t rays;
    /** sampled: frames with the same seed, 0 .. 999 999, have the same noise. Those of which a mean is taken count it up. Temporal antialiasing does so itself. Default 0. */
    uint32_t seed;
    fnl_ray_backend ray_backend; /**< wherever rays find shadows; default FNL_RAY_BACKEND_AUTO */
    /**
     * sampled: filters the noise over time and space, for real time; deferred shading with 1 sample alone. Shadows then lag behind what moves by a few frames, and
     * are blurred where few frames know them. Frames take other lights each, and those of a still scene come close to FNL_SHADOWS_RAYS. Default false.
     */
    bool denoise;
    /**
     * sampled: lights that earlier frames found hidden in the same place of the picture get fewer rays, which leaves more for the others. The mean over all frames is that of
     * FNL_SHADOWS_RAYS as without; single frames have less noise. For deferred shading with 1 sample; glass and other surfaces that are shaded forward choose as without. A frame
     * that earlier ones do not count for (a view's first, of another size, after reset_history) is to the bit what it is without. Default false.
     */
    bool guide;
    fnl_cubemap_lod cubemap_lod;       /**< cubemap; default FNL_CUBEMAP_LOD_LINEAR */
    fnl_cubemap_inside cubemap_inside; /**< cubemap; default FNL_CUBEMAP_INSIDE_ALL */
    bool cubemap_tint;                 /**< cubemap: coloured glass in the walls colours the light; default true */
    /** cubemap: looks up where the ray to the light leaves the box; false: in the direction of the light itself, which is right in one point of the
        room alone, and is there to show it. Default true. */
    bool cubemap_correct;
    /** cubemap: stores the cube maps of probes as BC3 if the device has fnl_device_info.texture_compression. They take a quarter of the memory, and soft shadows
        change slightly. A change of this option bakes all probes again. Default false. */
    bool cubemap_compress;
    /**
     * Contact shadows: length of the march from each point toward each light along the depth of the picture; a surface in front of the march hides the light. Meters, >= 0;
     * default 0: none. They multiply the shadows of any method, also work without one, and add shadows where things touch, for which maps are too coarse. Up to
     * 32 depth reads for each light of each pixel; paths that shade before they have depth draw it in an extra pass. Occluders outside the picture or hidden in it are missing.
     */
    float contact_length;
} fnl_shadow_options;

#ifdef __cplusplus
}
#endif
#endif
