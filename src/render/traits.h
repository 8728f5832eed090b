/* SPDX-License-Identifier: MIT */
/** What shading paths support and frames need, from the options only. */
#ifndef FNL_RENDER_TRAITS_H
#define FNL_RENDER_TRAITS_H

#include "base/check.h"
#include "fanal/frame.h"

enum shading_trait {
    SHADING_FORWARD = 1 << 0,      /* shades while it draws: pixels may have several samples */
    SHADING_GBUFFER = 1 << 1,      /* shades what a G-buffer holds: lists may look at depth and normals */
    SHADING_PREPASS = 1 << 2,      /* draws the depth of the opaque set first */
    SHADING_MAY_PREPASS = 1 << 3,  /* does so where gbuffer.prepass asks for it */
    SHADING_BLENDS = 1 << 4,       /* adds lights up by blending into the radiance target */
    SHADING_POSITIONS = 1 << 5,    /* looks lights up at positions rebuilt from depth, as lists made from depth do */
    SHADING_SAMPLES = 1 << 6,      /* pixels may have several samples */
    SHADING_LAYOUTS = 1 << 7,      /* heeds gbuffer.layout, normals and chroma, and has the debug views of a G-buffer */
    SHADING_REDRAW = 1 << 8,       /* draws the geometry a second time for its materials */
    SHADING_APPROXIMATE = 1 << 9,  /* gives a picture that is close to that of the others, not equal */
    SHADING_VOLUMES = 1 << 10,     /* finds the lights of opaque surfaces by drawing volumes: lists serve blended ones alone */
    SHADING_ITEMS = 1 << 11,       /* knows the item that a pixel shows: lists of objects serve it */
    SHADING_FULL_RASTER = 1 << 12, /* draws all geometry in the frame's own pixels: culling may leave out what their samples do not see */
    SHADING_LISTS_FIRST = 1 << 13, /* makes its lists before it draws: they see depth only after a prepass */
    SHADING_VERTICES = 1 << 14,    /* needs vertex shaders */
    SHADING_DECALS = 1 << 15,      /* with decals = gbuffer it applies boxes and volumes to what it stores */
    SHADING_DECAL_STEP = 1 << 16,  /* does so in a step that walks their list and does not know what a surface receives */
    SHADING_VIEWS = 1 << 17,       /* draws several views in one frame */
    SHADING_MULTIVIEW = 1 << 18,   /* of them what it draws before lists, the prepass included, for several views at once */
    SHADING_HIDDEN = 1 << 21,      /* leaves out what hidden areas cover (fnl_frame.hidden_areas) */
    SHADING_LAYERS = 1 << 20,      /* shades layered materials itself; where it does not they are drawn over its picture */
    SHADING_SURFACES = 1 << 19     /* with one sample a pixel it shades just what depth shows there, whatever else it shades for nothing */
};
/** Whether an order has all of these traits, whatever the options of a frame; auto has none. */
bool shading_is(fnl_shading shading, uint32_t traits);
/** The same of the order of a frame with its options, which may add traits or take them away. Not auto. */
bool frame_is(const fnl_frame *frame, uint32_t traits);

/** Refuses a frame whose shading path lacks traits: "WHAT needs the shading A, B or C, not D"; A, B and C are the paths that have them. */
fnl_result shading_refuse(const struct call *call, const char *what, const fnl_frame *frame, uint32_t traits);

enum shadow_trait {
    SHADOWS_MAPS = 1 << 0,   /* maps, where the device can draw them and there is room */
    SHADOWS_RAYS = 1 << 1,   /* rays, even for lights that have maps */
    SHADOWS_SPLIT = 1 << 2,  /* maps or rays for each light, whichever cost less */
    SHADOWS_TREES = 1 << 3,  /* rays go through the trees, not the device's structures */
    SHADOWS_ROOMS = 1 << 4,  /* probes record what the walls of rooms let in */
    SHADOWS_CHOSEN = 1 << 5, /* a random choice of each pixel's lights */
    SHADOWS_EXACT = 1 << 6   /* every light of a pixel, one by one */
};
/** Whether the frame's shadow method has all of these traits; auto has none. */
bool shadows_have(const fnl_frame *frame, uint32_t traits);

/** Whether the frame asks for denoised shadows. Its check sees to it that its order has them. */
static inline bool shadows_denoised(const fnl_frame *frame) { return shadows_have(frame, SHADOWS_CHOSEN) && frame->shadow.denoise; }
/** Whether what frames see of lights guides the next one's choice of them. The frame's check sees to it that its order does that. */
static inline bool shadows_guided(const fnl_frame *frame) { return shadows_have(frame, SHADOWS_CHOSEN) && frame->shadow.guide; }

#endif
